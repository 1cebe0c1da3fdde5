"""Orbits of two twist maps that know nothing of each other, seen in coordinates turned by any angle: their tunes are
known, far from resonances and close to them.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

import fastaff as fa
from fastaff import Classification

RESONANCES = ((1, 1), (3, 2), (2, 1), (3, 1))  # (q, p) with |q nu_1 -+ p nu_2| T, modulo 1, log-uniform in NEAR
CELLS = ("generic", *(f"{q}:{p}" for q, p in RESONANCES))
NEAR, RATIOS = (-4.0, 1.0), (-3.0, 0.0)
TURNS = (200, 1000, 5000, 20000)
APART = 0.03  # of tunes from 0 and 1/2, where samples do not show the shape of a loop
CALLS = ("frequency_map", "tunes")
TEXT = (
    "u = c*x + s*y; a = c*p_x + s*p_y; v = c*y - s*x; b = c*p_y - s*p_x;"
    "I = (u**2 + (h*a)**2)/2; J = (v**2 + (k*b)**2)/2; f = 2*pi*(m + A*I + B*J); g = 2*pi*(n + B*I + C*J);"
    "U = u*cos(f) + h*a*sin(f); V = v*cos(g) + k*b*sin(g);"
    "F = a*cos(f) - u/h*sin(f); G = b*cos(g) - v/k*sin(g);"
    "x1 = c*U - s*V; y1 = s*U + c*V; p_x1 = c*F - s*G; p_y1 = s*F + c*G"
)


@dataclass(frozen=True)
class MapCase:
    """Orbits of one map with their true tunes nu (2, orbits)."""

    cell: str
    turns: int
    parameters: dict = field(repr=False)
    z0: np.ndarray = field(repr=False)
    nu: np.ndarray = field(repr=False)

    @property
    def model(self):
        """The map; its text compiles once."""
        return fa.iterated_map(TEXT, coordinates="x, y", momenta="p_x, p_y", **self.parameters)

    def samples(self):
        """Return the samples (4, orbits, turns) in closed form."""
        p, (x, y, p_x, p_y) = self.parameters, self.z0
        c, s = p["c"], p["s"]
        w = np.array(
            [c * x + s * y - 1j * p["h"] * (c * p_x + s * p_y), c * y - s * x - 1j * p["k"] * (c * p_y - s * p_x)]
        )
        turns = self.nu[:, :, None] * np.arange(self.turns)
        w = w[:, :, None] * np.exp(2j * np.pi * (turns - np.rint(turns)))
        (u, v), (a, b) = w.real, -w.imag / np.array([p["h"], p["k"]])[:, None, None]
        return np.array([c * u - s * v, s * u + c * v, c * a - s * b, s * a + c * b])


def map_case(rng, cell: str, turns: int, orbits: int) -> MapCase:
    """Return a case: tunes, twists, the angle and the ratios of amplitudes are drawn at random."""
    while True:
        angle = rng.choice([np.pi / 4, rng.uniform(0, np.pi)])
        (h, k), size = 10 ** rng.uniform(-0.3, 0.3, 2), 10 ** rng.uniform(-2, 2)
        k = rng.choice([h, k])
        twist = rng.uniform(-0.1, 0.1, 3) / size**2
        m, n = rng.uniform(0, 1, 2)
        many = 40 * orbits
        I, J = size**2 * np.sort(10 ** (2 * rng.uniform(*RATIOS, (2, many))), axis=0)[rng.permutation(2)]
        I, J = I / np.maximum(I, J) * size**2, J / np.maximum(I, J) * size**2
        slopes = np.array([twist[0] * I + twist[1] * J, twist[1] * I + twist[2] * J])
        scale = rng.uniform(0.2, 2.0, many)
        if cell != "generic":
            q, p = (int(part) for part in cell.split(":"))
            p *= rng.choice([-1, 1])
            wanted = rng.choice([-1, 1], many) * 10 ** rng.uniform(*NEAR, many) / turns
            n = (q * m + q * slopes[0, 0] - p * slopes[1, 0] - rng.integers(0, abs(p))) / p
            with np.errstate(all="ignore"):
                scale = (wanted - q * m + p * n + np.rint(q * m - p * n)) / (q * slopes[0] - p * slopes[1])
                scale = np.where((scale > 0.2) & (scale < 2.0), scale, np.nan)
        nu = np.array([[m], [n]]) + scale * slopes
        good = np.isfinite(scale) & (np.abs(2 * nu - np.rint(2 * nu)) > 2 * APART).all(axis=0)
        if good.sum() < orbits:
            continue
        own = np.flatnonzero(good)[:orbits]
        radius = np.sqrt(2 * scale[own] * np.array([I[own], J[own]]))
        w = radius * np.exp(2j * np.pi * rng.uniform(size=radius.shape))
        (u, v), (a, b) = w.real, w.imag / np.array([[h], [k]])
        c, s = np.cos(angle), np.sin(angle)
        z0 = np.array([c * u - s * v, s * u + c * v, c * a - s * b, s * a + c * b])
        parameters = {"m": m, "n": n, "A": twist[0], "B": twist[1], "C": twist[2], "c": c, "s": s, "h": h, "k": k}
        # The tunes of the start as it is rounded.
        u, v = c * z0[0] + s * z0[1], c * z0[1] - s * z0[0]
        a, b = c * z0[2] + s * z0[3], c * z0[3] - s * z0[2]
        I, J = (u**2 + (h * a) ** 2) / 2, (v**2 + (k * b) ** 2) / 2
        nu = np.array([m + twist[0] * I + twist[1] * J, n + twist[1] * I + twist[2] * J])
        return MapCase(cell, turns, parameters, z0, nu)


def from_whole(turns):
    """Return distances from whole turns."""
    return np.abs(turns - np.rint(turns))


@dataclass(frozen=True)
class MapJudged:
    """Outcomes of the orbits of a case by one call, arrays (orbits,): as in `frequency_coverage.Judged`."""

    case: MapCase
    call: str
    ratio: np.ndarray
    classification: np.ndarray
    wrong: np.ndarray
    needless: np.ndarray


def map_judged(case: MapCase, call: str, threads=None, rounding=3e-15) -> MapJudged:
    """Return whether the result of a call is true: the tunes of REGULAR orbits are those of both maps, in either
    order and sense; RESONANT is wrong where no |k_i| <= 6 has |k . nu| T <= 1e-9, modulo 1.
    """
    if call == "tunes":
        found = fa.tunes(case.samples(), threads=threads)
    else:
        found = fa.frequency_map(case.model, case.z0, time=case.turns, threads=threads)
    kind = np.where(found.status == 0, found.classification, -1)
    own = kind == Classification.REGULAR
    orders = []
    for order in itertools.permutations(range(2)):
        off = np.minimum(from_whole(found.nu - case.nu[list(order)]), from_whole(found.nu + case.nu[list(order)]))
        orders.append((off / (found.error + rounding)).max(axis=0))
    ratio = np.where(own, np.min(orders, axis=0), np.nan)
    k = np.array([k for k in itertools.product(range(-6, 7), repeat=2) if any(k)])
    beats = from_whole(k @ case.nu) * case.turns
    locked, slow = (beats <= 1e-9).any(axis=0), (beats[np.abs(k).sum(axis=1) <= 6] < 1.5).any(axis=0)
    wrong = (own & ((ratio > 1) | locked)) | ((kind == Classification.RESONANT) & ~locked)
    wrong |= kind == Classification.IRREGULAR
    return MapJudged(case, call, ratio, kind, wrong, (kind == Classification.UNDECIDED) & ~slow)


def map_results(seed: int, orbits: int, turns=TURNS, threads=None, group=10) -> list[MapJudged]:
    """Return the outcomes of so many orbits of each cell and time, in groups of one map; each has a seed of its own."""
    results = []
    for number, cell in itertools.product(turns, CELLS):
        rng = np.random.default_rng([seed, number, *cell.encode()])
        for begin in range(0, orbits, group):
            case = map_case(rng, cell, number, min(group, orbits - begin))
            results += [map_judged(case, call, threads) for call in CALLS]
    return results
