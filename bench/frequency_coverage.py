"""Whether `frequency_map` tells the truth: orbits of integrable systems of known frequencies, far from resonances
and close to them: `python bench/frequency_coverage.py`, with --quick in two minutes.

Each group of orbits is one model with parameters, units and offsets drawn at random; the lines of its table count

- within error: REGULAR orbits whose nu are M nu_true within `error`, M a unimodular matrix of integers |k| <= 4;
  the worst ratio of the difference to the error is beside them, and orbits that are not within are wrong;
- RESONANT, which is wrong where no |k| <= 6 has |k . nu_true| <= 1e-9/T, and IRREGULAR, which is always wrong here;
- UNDECIDED, which is never wrong, but needless where no |k|_1 <= 6 (p + q near the resonance q:p, if that is more) has
  |k . nu_true| T < 1.5.

With --maps the same of coupled maps, by `frequency_map` and by `tunes` of their samples (`coupled_maps.py`).
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import mpmath
import numpy as np
from coupled_maps import CALLS, map_results
from pages import put
from scipy.special import ellipk, ellipkm1

import fastaff as fa
from fastaff import Classification

RESONANCES = ((1, 1), (2, 1), (3, 1), (4, 1), (3, 2), (4, 3))  # (q, p) with |q nu_1 - p nu_2| T log-uniform in NEAR
CELLS = ("generic", *(f"{q}:{p}" for q, p in RESONANCES))
NEAR = (-4.0, 1.0)
GROUP = 25
TRUTH = 1e-13  # relative error of the true frequencies
ENTRY, ORDER = 4, 6
STEPS = ("default", "accuracy 1e-6", "coarse step")


@dataclass(frozen=True)
class Family:
    """Orbits of one model: `start(s)` are states (2n, orbits), s (orbits,) in (0, 1) moves the first two frequencies
    against each other, `truth(z)` are all frequencies (n, orbits) in the order of the resonances. options: of
    `fa.hamiltonian`, such as periods.
    """

    text: str
    parameters: dict
    start: Callable
    truth: Callable
    options: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Case:
    """A group of orbits with true frequencies, and the arguments of its call."""

    system: str
    cell: str
    periods: float
    steps: str
    text: str
    parameters: dict = field(repr=False)
    z0: np.ndarray = field(repr=False)
    nu: np.ndarray = field(repr=False)
    time: float = 0.0
    making: dict = field(default_factory=dict, repr=False)

    @property
    def model(self):
        """The model; a text compiles once."""
        return fa.hamiltonian(self.text, coordinates="x y z"[: 2 * len(self.nu) - 1], **self.making, **self.parameters)

    @property
    def options(self) -> dict:
        """Options of the call beside the time."""
        fast = float(np.median(np.abs(self.nu).max(axis=0)))
        return {"accuracy 1e-6": {"accuracy": 1e-6}, "coarse step": {"step": 0.1 / fast}}.get(self.steps, {})


# Wells f(q) of one coordinate with the frequency 1/2 pi at the bottom: the formula, the largest energy, f, half the
# squared frequency's root 2 pi nu(e), and the turning points.


def _quartic(e, b):
    """Return 2 pi nu and the amplitude of q^2/2 + b q^4/4."""
    a2 = 4 * e / (1 + np.sqrt(1 + 4 * b * e))
    w2 = 1 + b * a2
    return np.sqrt(w2) * np.pi / (2 * ellipk(b * a2 / (2 * w2))), np.sqrt(a2)


def _cubic(e):
    """Return 2 pi nu and the turning points of q^2/2 - q^3/3."""
    phi = 2 * np.arcsin(np.sqrt(6 * e)) / 3
    root = np.sqrt(3) * np.sin(phi + np.pi / 3)  # between the outer roots of e - f
    rate = np.pi * np.sqrt(root / 6) / ellipk(np.sqrt(3) * np.sin(phi) / root)
    return rate, (0.5 + np.cos(phi + 2 * np.pi / 3), 0.5 + np.cos(phi - 2 * np.pi / 3))


WELLS = {
    "Morse": (
        "(1-exp(-{q}))**2/2",
        0.48,
        lambda q: np.expm1(-q) ** 2 / 2,
        lambda e: np.sqrt(1 - 2 * e),
        lambda e: (-np.log1p(np.sqrt(2 * e)), -np.log1p(-np.sqrt(2 * e))),
    ),
    "hard": (
        "{q}**2/2+{q}**4/4",
        20.0,
        lambda q: q**2 / 2 + q**4 / 4,
        lambda e: _quartic(e, 1.0)[0],
        lambda e: (-_quartic(e, 1.0)[1], _quartic(e, 1.0)[1]),
    ),
    "soft": (
        "{q}**2/2-{q}**4/4",
        0.24,
        lambda q: q**2 / 2 - q**4 / 4,
        lambda e: _quartic(e, -1.0)[0],
        lambda e: (-_quartic(e, -1.0)[1], _quartic(e, -1.0)[1]),
    ),
    "pendulum": (
        "1-cos({q})",
        1.95,
        lambda q: 2 * np.sin(q / 2) ** 2,
        lambda e: np.pi / (2 * ellipkm1(1 - e / 2)),
        lambda e: (-2 * np.arcsin(np.sqrt(e / 2)), 2 * np.arcsin(np.sqrt(e / 2))),
    ),
    "rotor": (
        "1-cos({q})",
        8.0,
        lambda q: 2 * np.sin(q / 2) ** 2,
        lambda e: np.pi * np.sqrt(e / 2) / ellipkm1((e - 2) / e),
        lambda e: (-np.pi + 0 * e, np.pi + 0 * e),
    ),
    "cubic": (
        "{q}**2/2-{q}**3/3",
        0.165,
        lambda q: q**2 / 2 - q**3 / 3,
        lambda e: _cubic(e)[0],
        lambda e: _cubic(e)[1],
    ),
}


EDGES = {"pendulum": 2.0, "rotor": 8.0, "soft": 0.25, "cubic": 1 / 6}
"""Energies of separatrices; of rotors, which begin at theirs, the largest."""


def decades(rng, low, high, size=None):
    """Return numbers whose log10 is uniform."""
    return 10 ** rng.uniform(low, high, size)


def offsets(rng, size):
    """Return so many offsets, in units of the shifted quantity: to the hundredfold, of either sign."""
    return rng.choice([-1, 1], size) * decades(rng, -1, 2, size)


def parts(rng, size):
    """Return parts of the energy's range: most anywhere in it, a quarter close to the bottom."""
    return np.where(rng.random(size) < 0.75, rng.uniform(0.02, 1, size), decades(rng, -4, -1.7, size))


def wells(rng, kinds, m, resonance, *, turn=None, text=None, weak=False, edge=False):
    """Return uncoupled wells of these kinds; `turn`: a matrix (n, n), or True for one at random: the wells' coordinates
    are those that it turns the body's into. weak: all but the second have amplitudes of 1e-8 to 1e-1 of their range;
    edge: energies within 1e-4 to 1e-1 of the separatrix.
    """
    n = len(kinds)
    formulas, tops, potentials, rates, ends = zip(*(WELLS[k] for k in kinds))
    bottoms = np.array([2.2 if k == "rotor" else 0.0 for k in kinds])
    tops = np.array(tops)
    if edge:
        bottoms = np.array([2.0 if k == "rotor" else 0.0 for k in kinds])
        tops = np.array([EDGES[k] for k in kinds])
    unit, clock = decades(rng, -3, 3, 2)
    l, w = unit * decades(rng, -0.5, 0.5, n), decades(rng, -0.7, 0.7, n) / clock
    if turn is None:
        l = unit * decades(rng, -2, 2, n)
    else:
        turn = np.linalg.qr(rng.standard_normal((n, n)))[0] if turn is True else turn
    if text is not None:
        l[:], w[:] = unit * np.sqrt(0.5), 1 / clock
    elif resonance:  # where the two middling energies are resonant
        middle = [rates[i](bottoms[i] + (tops[i] - bottoms[i]) * rng.uniform(0.1, 0.9)) for i in range(2)]
        w[1] = w[0] * resonance[0] * middle[0] / (resonance[1] * middle[1])
    u, axes = (l * w) ** 2, np.eye(n) if turn is None else turn
    shift = l * offsets(rng, n)
    names = "xyz"[:n]
    parameters = {f"{a}0": s for a, s in zip(names, shift)} | {"v0": u.max() * offsets(rng, None)}
    if text is None:
        parameters |= {f"u{i}": u[i] for i in range(n)} | {f"l{i}": l[i] for i in range(n)}
        moved = [f"({a}-{a}0)" for a in names]
        if turn is not None:
            parameters |= {f"c{i}{j}": axes[i, j] for i in range(n) for j in range(n)}
            moved = ["(" + "+".join(f"c{i}{j}*({a}-{a}0)" for j, a in enumerate(names)) + ")" for i in range(n)]
        text = "+".join(f"u{i}*({formulas[i].format(q=f'({moved[i]}/l{i})')})" for i in range(n)) + "+v0"
    else:
        parameters |= {"u0": 2 * u[0], "l0": unit}
    share, phase, side = parts(rng, (n, m)), rng.uniform(-1.5, 1.5, (n, m)), rng.choice([-1, 1], (n, m))
    if weak:
        share = decades(rng, -16, -2, (n, m))
    near = decades(rng, -4, -1, (n, m))

    def start(s):
        q, p = np.empty((n, m)), np.empty((n, m))
        for i in range(n):
            part = s if i == 1 else share[i]
            if edge:
                part = near[i] if kinds[i] == "rotor" else 1 - near[i]
            e = bottoms[i] + (tops[i] - bottoms[i]) * part
            a, b = ends[i](e)
            q[i] = (a + b) / 2 + (b - a) / 2 * np.sin(phase[i])
            p[i] = side[i] * np.sqrt(2 * np.maximum(e - potentials[i](q[i]), 0.0))
        q, p = q * l[:, None], p * (l * w)[:, None]
        return np.concatenate([axes.T @ q + shift[:, None], axes.T @ p])

    def truth(z):
        q, p = axes @ (z[:n] - shift[:, None]) / l[:, None], axes @ z[n:] / (l * w)[:, None]
        e = [p[i] ** 2 / 2 + potentials[i](q[i]) for i in range(n)]
        return np.array([w[i] * rates[i](e[i]) for i in range(n)]) / (2 * np.pi)

    return Family(text, parameters, start, truth)


def henon(rng, m, resonance):
    """Return orbits of the integrable relative of Henon-Heiles: equal cubic wells in y + x and y - x."""
    turn, x, y = np.array([[-1.0, -1.0], [1.0, -1.0]]) * np.sqrt(0.5), "((x-x0)/l0)", "((y-y0)/l0)"
    text = f"u0*(({x}**2+{y}**2)/2+{x}**2*{y}+{y}**3/3)+v0"
    return wells(rng, ("cubic", "cubic"), m, resonance, turn=turn, text=text)


def central(rng, m, kepler):
    """Return orbits in x, y of -1/(1 + sqrt(1 + r^2)), or of -1/r + c/r^2; nu: angle, radius."""
    l, w = decades(rng, -3, 3, 2)
    u = (l * w) ** 2
    shift, c = (l * offsets(rng, 2))[:, None], decades(rng, -2, 0)
    r = "sqrt((x-x0)**2+(y-y0)**2)/l0"
    text = f"u0*(-1/({r})+c0/({r})**2)+v0" if kepler else f"u0*(-1/(1+sqrt(1+({r})**2)))+v0"
    parameters = {"x0": shift[0, 0], "y0": shift[1, 0], "l0": l, "u0": u, "v0": u * offsets(rng, None)}
    if kepler:
        parameters["c0"] = c
    spread = decades(rng, -1, 1, m)
    phase, turn = rng.uniform(-1.5, 1.5, m), rng.uniform(0, 2 * np.pi, m)
    sides = rng.choice([-1, 1], (2, m))

    def start(s):
        if kepler:
            e, momentum = -1 / (4 * c * (1 + spread)), np.sqrt(2 * c * s * spread)
            middle, product = -0.5 / e, -(momentum**2 / 2 + c) / e  # of the roots of 2 e r^2 + 2 r - L^2 - 2 c
            radius = middle + np.sqrt(np.maximum(middle**2 - product, 0)) * np.sin(phase)
            potential = -1 / radius + c / radius**2
        else:
            e = -0.5 / (1 + spread)
            size = np.sqrt(-2 / e)  # L + sqrt(L^2 + 4) of the circle
            momentum = s * (size - 4 / size) / 2
            middle, product = -0.5 / e, -(2 * e + 2 + momentum**2) / (2 * e)  # the same for sqrt(1 + r^2)
            root = middle + np.sqrt(np.maximum(middle**2 - product, 0)) * np.sin(phase)
            radius, potential = np.sqrt((root - 1) * (root + 1)), -1 / (1 + root)
        across = momentum / radius * sides[1]
        along = sides[0] * np.sqrt(np.maximum(2 * (e - potential) - across**2, 0))
        cos, sin = np.cos(turn), np.sin(turn)
        q, p = radius * np.array([cos, sin]), np.array([along * cos - across * sin, along * sin + across * cos])
        return np.concatenate([l * q + shift, l * w * p])

    def truth(z):
        q, p = (z[:2] - shift) / l, z[2:] / (l * w)
        r2, momentum = (q**2).sum(axis=0), np.abs(q[0] * p[1] - q[1] * p[0])
        potential = -1 / np.sqrt(r2) + c / r2 if kepler else -1 / (1 + np.sqrt(1 + r2))
        radial = (-2 * ((p**2).sum(axis=0) / 2 + potential)) ** 1.5
        ratio = momentum / np.sqrt(momentum**2 + 2 * c) if kepler else (1 + momentum / np.sqrt(momentum**2 + 4)) / 2
        return w / (2 * np.pi) * np.array([ratio * radial, radial])

    return Family(text, parameters, start, truth)


def toda(rng, n, m):
    """Return orbits of n particles between fixed ends, an odd solution of the periodic lattice of N = 2 n + 2. With its
    discriminant D(x), whose even coefficients are integrals, the actions are integrals of arccosh |D/2| over gaps, and
    nu = dE/dJ (Flaschka & McLaughlin 1976, Prog. Theor. Phys. 55, 438).
    """
    l, w = decades(rng, -3, 3, 2)
    u = (l * w) ** 2
    shift, size = l * offsets(rng, 1), 2 * n + 2
    chain = ["", *(f"({a}-x0)/l0" for a in "xyz"[:n]), ""]
    text = "+".join(f"exp({right}{f'-{left}' if left else ''})" for left, right in itertools.pairwise(chain))
    text = f"u0*({text}-{n + 1})+v0"
    parameters = {"x0": shift[0], "l0": l, "u0": u, "v0": u * offsets(rng, None)}
    ray = rng.standard_normal((2 * n, m))
    ray *= decades(rng, -0.7, 0.2, m) / np.sqrt((ray**2).sum(axis=0))
    theta = (np.arange(128) + 0.5) * np.pi / 128

    def start(s):
        z = ray * 2 * s
        return np.concatenate([l * z[:n] + shift[0], l * w * z[n:]])

    def truth(z):
        x, p = (z[:n] - shift[0]) / l, z[n:] / (l * w)
        none = np.zeros((1, z.shape[1]))
        q, b = (np.concatenate([none, part, none, -part[::-1], none]).T for part in (x, p))
        a, i = np.exp(np.diff(q) / 2), np.arange(size)
        edges = []
        for sign in (1, -1):
            matrix = np.zeros((z.shape[1], size, size))
            matrix[:, i, i], matrix[:, i[:-1], i[1:]] = b[:, :-1], a[:, :-1]
            matrix[:, 0, -1] = sign * a[:, -1]
            edges.append(np.linalg.eigvalsh(matrix, UPLO="U"))
        edges = np.sort(np.concatenate(edges, axis=1), axis=1)[:, size + 1 :]  # those above zero
        slopes = np.empty((z.shape[1], n, n))
        for gap in range(n):
            low, high = edges[:, 2 * gap], edges[:, 2 * gap + 1]
            place = ((low + high) / 2 + (high - low) / 2 * np.cos(theta)[:, None]).T
            rest = np.delete(edges, [2 * gap, 2 * gap + 1], axis=1)[:, :, None]
            under = (
                np.abs(place[:, None] ** 2 - rest**2).prod(axis=1) * (place + low[:, None]) * (place + high[:, None])
            )
            for k in range(n):
                slopes[:, gap, k] = (place ** (2 * (n - k) - 1) / np.sqrt(under)).mean(axis=1)
        return w / (2 * np.pi) * np.abs(np.linalg.inv(slopes)[:, 0]).T / 2

    return Family(text, parameters, start, truth)


def rotors(rng, n, m):
    """Return uncoupled pendulums of 1 to 4 equal wells a turn, coordinates with the period 2 pi: the mean rates of
    those that go round are frequencies, their lines are multiples of them.
    """
    names, folds, clock = "xyz"[:n], rng.integers(1, 5, n), decades(rng, -3, 3)
    w = decades(rng, -0.7, 0.7, n) / clock
    u, shift, side = (w / folds) ** 2, rng.uniform(-9, 9, n), rng.choice([-1, 1], (n, m))
    text = "+".join(f"u{i}*(1-cos({k}*({a}-{a}0)))" for i, (a, k) in enumerate(zip(names, folds)))
    parameters = {f"u{i}": u[i] for i in range(n)} | {f"{a}0": shift[i] for i, a in enumerate(names)}
    parts_of, phase = rng.random((n, m)), rng.uniform(-1.2, 1.2, (n, m))
    round_ = rng.random((n, m)) < np.array([1.0, *[0.5] * (n - 1)])[:, None]

    def start(s):
        share = parts_of.copy()
        share[1 % n] = s
        e = np.where(round_, 2.2 + 6 * share, 0.02 + 1.9 * share)
        top = np.where(round_, np.pi, 2 * np.arcsin(np.sqrt(np.minimum(e, 2.0) / 2)))
        angle = top * np.sin(phase)
        rate = side * np.sqrt(2 * np.maximum(e - 2 * np.sin(angle / 2) ** 2, 0.0))
        return np.concatenate([angle / folds[:, None] + shift[:, None], rate * (w / folds)[:, None]])

    def truth(z):
        angle, rate = folds[:, None] * (z[:n] - shift[:, None]), z[n:] / (w / folds)[:, None]
        e = rate**2 / 2 + 2 * np.sin(angle / 2) ** 2
        swings, turns = WELLS["pendulum"][3](np.minimum(e, 1.99)), WELLS["rotor"][3](np.maximum(e, 2.01))
        return w[:, None] / (2 * np.pi) * np.where(e > 2, turns / folds[:, None], swings)

    return Family(text, parameters, start, truth, {"periodic": dict.fromkeys(names, "2*pi")})


def foucault(rng, m):
    """Return ellipses of any axes that turn: of Foucault's pendulum, of two circular motions of any amplitudes."""
    w, turn = decades(rng, -3, 3), decades(rng, -2, -0.3)
    small, phase = decades(rng, -8, 0, m), rng.uniform(0, 2 * np.pi, (2, m))
    size = decades(rng, -3, 3) * np.where(rng.random(m) < 0.5, [np.ones(m), small], [small, np.ones(m)])

    def start(s):
        A, B = size * np.exp(1j * phase)
        A = A * (0.5 + s)
        q, v = A + B, 1j * w * (A - B)
        return np.array([q.real, q.imag, v.real, v.imag])

    def truth(z):
        return np.abs(w * np.array([[1 - turn], [1 + turn]]) * np.ones(z.shape[1])) / (2 * np.pi)

    return Family("w0**2*(x**2+y**2)/2", {"w0": w}, start, truth, {"rotation": w * turn})


CENTRAL = {
    "logarithmic": ("log({r}**2+c0**2)/2", lambda r, c: mpmath.log(r**2 + c**2) / 2, lambda r, c: r / (r**2 + c**2)),
    "Plummer": (
        "-1/sqrt({r}**2+c0**2)",
        lambda r, c: -1 / mpmath.sqrt(r**2 + c**2),
        lambda r, c: r / (r**2 + c**2) ** 1.5,
    ),
    "power": ("{r}**(2*c0)/(2*c0)", lambda r, c: r ** (2 * c) / (2 * c), lambda r, c: r ** (2 * c - 1)),
    "falling": ("-{r}**(-c0)/c0", lambda r, c: -(r**-c) / c, lambda r, c: r ** (-c - 1)),
}


def circular(rng, m):
    """Return nearly circular orbits in x, y of a central potential; nu: angle, radius, by 40-digit quadrature."""
    formula, value, slope = CENTRAL[rng.choice(list(CENTRAL))]
    l, w = decades(rng, -1, 1, 2)
    u, c = (l * w) ** 2, rng.uniform(0.3, 0.9)
    shift = (l * rng.uniform(-3, 3, 2))[:, None]
    text = "u0*(" + formula.format(r="(sqrt((x-x0)**2+(y-y0)**2)/l0)") + ")"
    parameters = {"x0": shift[0, 0], "y0": shift[1, 0], "l0": l, "u0": u, "c0": c}
    eccentric, turn, sides = decades(rng, -8, -0.5, m), rng.uniform(0, 2 * np.pi, m), rng.choice([-1, 1], (2, m))
    phase = rng.uniform(-1.5, 1.5, m)

    def start(s):
        r = 0.3 + 1.5 * s
        across = np.sqrt(r * slope(r, c)) * (1 + eccentric * np.sin(phase)) * sides[1]
        along = eccentric * np.cos(phase) * np.abs(across)
        cos, sin = np.cos(turn), np.sin(turn)
        q, p = r * np.array([cos, sin]), np.array([along * cos - across * sin, along * sin + across * cos])
        return np.concatenate([l * q + shift, l * w * p])

    def rates(point):
        x, y, p, s = (mpmath.mpf(float(v)) for v in point)
        r, momentum = mpmath.sqrt(x * x + y * y), abs(x * s - y * p)
        energy = (p * p + s * s) / 2 + value(r, c)

        def radial(r):
            return 2 * (energy - value(r, c)) - (momentum / r) ** 2

        middle = mpmath.findroot(lambda r: r**3 * slope(r, c) - momentum**2, r)
        away = mpmath.sqrt(radial(middle)) * middle**2 / momentum / 4
        low, high = (_edge(radial, middle, sign * away) for sign in (-1, 1))
        half, centre, count = (high - low) / 2, (high + low) / 2, 48
        period = angle = mpmath.mpf(0)
        for i in range(count):
            at = centre + half * mpmath.cos(mpmath.pi * (2 * i + 1) / (2 * count))
            one = mpmath.sqrt((high - at) * (at - low) / radial(at)) * 2 * mpmath.pi / count
            period += one
            angle += one * momentum / at**2
        return float(angle / (2 * mpmath.pi * period)), float(1 / period)

    def truth(z):
        with mpmath.workdps(40):
            points = np.concatenate([(z[:2] - shift) / l, z[2:] / (l * w)])
            return w * np.array([rates(point) for point in points.T]).T

    return Family(text, parameters, start, truth)


def _edge(f, inside, step):
    """Return the zero of f beyond a point where it is positive, by doubled steps and bisection with secants."""
    step = step if step else mpmath.mpf(10) ** -30
    while f(inside + step) > 0:
        step *= 2 if inside + 2 * step > 0 else mpmath.mpf("0.5") * (-inside / step + 1)
    return mpmath.findroot(f, (inside, inside + step), solver="anderson", tol=1e-60, verify=False)


MIXED = ("Morse", "hard", "soft", "cubic", "pendulum")

SYSTEMS: dict[str, Callable] = {
    "Morse": lambda rng, m, at: wells(rng, ("Morse", "Morse"), m, at),
    "quartic": lambda rng, m, at: wells(
        rng, [("hard", "hard"), ("hard", "soft"), ("soft", "soft")][rng.integers(3)], m, at
    ),
    "pendulums": lambda rng, m, at: wells(rng, rng.choice(["pendulum", "pendulum", "rotor"], 2), m, at),
    "cubic, 45°": henon,
    "turned": lambda rng, m, at: wells(
        rng, [("Morse", "hard"), ("cubic", "pendulum"), ("soft", "hard")][rng.integers(3)], m, at, turn=True
    ),
    "isochrone": lambda rng, m, at: central(rng, m, False),
    "precessing Kepler": lambda rng, m, at: central(rng, m, True),
    "Toda": lambda rng, m, at: toda(rng, 2, m),
    "Morse, n = 3": lambda rng, m, at: wells(rng, ("Morse",) * 3, m, at),
    "turned, n = 3": lambda rng, m, at: wells(rng, ("Morse", "hard", "pendulum"), m, at, turn=True),
    "Toda, n = 3": lambda rng, m, at: toda(rng, 3, m),
    "weak lines": lambda rng, m, at: wells(rng, rng.choice(MIXED, 2), m, at, turn=True, weak=True),
    "weak lines, n = 3": lambda rng, m, at: wells(rng, rng.choice(MIXED, 3), m, at, turn=True, weak=True),
    "nearly circular": lambda rng, m, at: circular(rng, m),
    "ellipses": lambda rng, m, at: foucault(rng, m),
    "circulating": lambda rng, m, at: rotors(rng, 2, m),
    "circulating, n = 3": lambda rng, m, at: rotors(rng, 3, m),
    "separatrices": lambda rng, m, at: wells(rng, rng.choice(list(EDGES), 2), m, at, edge=True),
}
ALONE = tuple(SYSTEMS)[-7:]
"""Systems that have one cell, generic."""


def made(rng, system, cell, periods, steps="default", orbits=GROUP) -> Case | None:
    """Return a case of so many orbits or fewer; None where the resonance is out of the system's reach."""
    resonance = None if cell == "generic" else tuple(int(k) for k in cell.split(":"))
    m = 4 * orbits if resonance else orbits
    family = SYSTEMS[system](rng, m, resonance)
    free = parts(rng, m)
    span = float(periods / np.median(np.abs(family.truth(family.start(np.full(m, 0.5)))).min(axis=0)))
    z0 = family.start(free)
    if resonance:
        wanted = rng.choice([-1, 1], m) * decades(rng, *NEAR, m) / span

        def excess(s):
            nu = family.truth(family.start(s))
            return resonance[0] * nu[0] - resonance[1] * nu[1] - wanted

        grid = np.linspace(0.02, 0.98, 25)
        values = np.array([excess(np.full(m, s)) for s in grid])
        change = values[1:] * values[:-1] < 0
        found, first = change.any(axis=0), change.argmax(axis=0)
        low, high = grid[first], grid[first + 1]
        below = np.sign(values[first, np.arange(m)])
        for _ in range(60):
            middle = (low + high) / 2
            left = np.sign(excess(middle)) == below
            low, high = np.where(left, middle, low), np.where(left, high, middle)
        z0 = family.start(low)[:, found][:, :orbits]
    if not z0.shape[1]:
        return None
    z0 = np.ascontiguousarray(z0)
    return Case(
        system, cell, periods, steps, family.text, family.parameters, z0, family.truth(z0), span, family.options
    )


def cases(seed=0, *, systems=None, periods=(10, 30, 100, 1000), orbits=8, steps=("default",)) -> Iterator[Case]:
    """Yield cases of all systems, times and cells, in groups of at most GROUP orbits; each has a seed of its own."""
    names = list(SYSTEMS)
    rows = itertools.product(systems or names, periods, CELLS, steps)
    for system, t, cell, how in rows:
        if how == "coarse step" and (cell not in ("generic", "2:1") or t < 100):
            continue
        if system in ALONE and cell != "generic":
            continue
        key = [seed, names.index(system), int(t), *cell.encode()]
        rng, left, tries = np.random.default_rng(key), orbits, 0
        while left > 0 and tries < 4 * -(-orbits // GROUP):
            case, tries = made(rng, system, cell, t, how, min(left, GROUP)), tries + 1
            if case is not None:
                left -= case.z0.shape[1]
                yield case


def combinations(n, largest, order=None):
    """Return integer vectors (., n) other than 0 with entries up to `largest`, of one sign and so much altogether."""
    k = np.array(list(itertools.product(range(-largest, largest + 1), repeat=n)))
    k = k[np.abs(k).sum(axis=1) > 0]
    return k if order is None else k[np.abs(k).sum(axis=1) <= order]


def ratios(nu, error, true):
    """Return the least, over unimodular M, of the largest |nu - M true|/error of rows, for each orbit (n, orbits)."""
    n, k = len(nu), combinations(len(nu), ENTRY)
    lines, least = k @ true, np.full(nu.shape[1], np.inf)
    with np.errstate(all="ignore"):
        each = np.abs(nu[:, None] - lines) / (error + TRUTH * np.abs(true).max(axis=0))[:, None]
    tuples = np.array(list(itertools.product(range(40 if n == 2 else 14), repeat=n)))
    for orbit in range(nu.shape[1]):
        best = np.argsort(each[:, :, orbit], axis=1)[:, : tuples.max() + 1]
        rows = best[np.arange(n), tuples]
        unimodular = np.abs(np.rint(np.linalg.det(k[rows]))) == 1
        worst = each[np.arange(n), rows, orbit].max(axis=1)
        least[orbit] = worst[unimodular].min(initial=np.inf)
    return least


@dataclass(frozen=True)
class Judged:
    """Outcomes of the orbits of a case: arrays (orbits,)."""

    case: Case
    found: fa.FrequencyMap
    ratio: np.ndarray  # NaN of orbits that are not REGULAR
    classification: np.ndarray  # -1 of orbits that are not OK
    wrong: np.ndarray
    needless: np.ndarray


def judged(case: Case, threads=None) -> Judged:
    """Return the result of `frequency_map` for a case, and whether it is true."""
    found = fa.frequency_map(case.model, case.z0, time=case.time, threads=threads, **case.options)
    kind = np.where(found.status == 0, found.classification, -1)
    n, own = len(case.nu), kind == Classification.REGULAR
    ratio = np.full(kind.size, np.nan)
    ratio[own] = ratios(found.nu[:, own], found.error[:, own], case.nu[:, own])
    locked = np.abs(combinations(n, ORDER) @ case.nu).min(axis=0) * case.time <= 1e-9
    order = ORDER if case.cell == "generic" else max(ORDER, sum(map(int, case.cell.split(":"))))
    slow = np.abs(combinations(n, order, order) @ case.nu).min(axis=0) * case.time < 1.5
    wrong = ((ratio > 1) | (own & locked)) | ((kind == Classification.RESONANT) & ~locked)
    wrong |= kind == Classification.IRREGULAR
    return Judged(case, found, ratio, kind, wrong, (kind == Classification.UNDECIDED) & ~slow)


HEAD = ("orbits", "within error (%)", "worst ratio", "regular (%)", "undecided (%)", "resonant (%)")
HEAD += ("irregular (%)", "wrong: regular", "resonant", "irregular", "needless undecided", "not OK")


def row(group: list[Judged]) -> list[str]:
    """Return the cells of one line."""
    kind, wrong, ratio = (np.concatenate([getattr(j, a) for j in group]) for a in ("classification", "wrong", "ratio"))
    own = kind == Classification.REGULAR
    shown = [f"{kind.size:,}"]
    shown += [f"{100 * np.mean(ratio[own] <= 1):.2f}", f"{ratio[own].max():.3g}"] if own.any() else ["", ""]
    for k in (Classification.REGULAR, Classification.UNDECIDED, Classification.RESONANT, Classification.IRREGULAR):
        shown.append(f"{100 * np.mean(kind == k):.1f}")
    shown += [
        str((wrong & (kind == k)).sum())
        for k in (Classification.REGULAR, Classification.RESONANT, Classification.IRREGULAR)
    ]
    return [*shown, str(sum(j.needless.sum() for j in group)), str((kind < 0).sum())]


def table(results: list[Judged], titles: tuple[str, ...], key: Callable) -> str:
    """Return a table in Markdown with a line for each key, in the order of the results, and one of all."""
    groups: dict = {}
    for j in results:
        groups.setdefault(key(j.case), []).append(j)
    lines = ["| " + " | ".join((*titles, *HEAD)) + " |", "|" + "---|" * (len(titles) + len(HEAD))]
    lines += ["| " + " | ".join([*map(str, k), *row(g)]) + " |" for k, g in groups.items()]
    lines.append("| " + " | ".join(["all", *[""] * (len(titles) - 1), *row(results)]) + " |")
    return "\n".join(lines) + "\n"


def tables(results: list[Judged]) -> str:
    """Return the tables: by system, by distance to a resonance, by steps."""
    cells = sorted(results, key=lambda j: (CELLS.index(j.case.cell), j.case.periods))
    hows = sorted(results, key=lambda j: (STEPS.index(j.case.steps), j.case.periods))
    return "\n".join(
        (
            table(results, ("system", "T"), lambda c: (c.system, c.periods)),
            table(cells, ("near", "T"), lambda c: (c.cell, c.periods)),
            table(hows, ("steps", "T"), lambda c: (c.steps, c.periods)),
        )
    )


def map_tables(results: list) -> str:
    """Return the tables of coupled maps, one for each call: by distance to a resonance, modulo 1, and turns."""
    said = []
    for call in CALLS:
        own = [j for j in results if j.call == call]
        own.sort(key=lambda j: (CELLS.index(j.case.cell), j.case.turns))
        said.append(table(own, (f"`{call}`, near", "turns"), lambda c: (c.cell, c.turns)))
    return "\n".join(said)


def shown(results: list[Judged], count: int) -> str:
    """Return the worst orbits of each kind, so that they can be run again."""
    said = []
    for name, score in {
        "REGULAR, wrong": lambda j: np.where(j.wrong & (j.classification == Classification.REGULAR), j.ratio, 0),
        "RESONANT, wrong": lambda j: (j.wrong & (j.classification == Classification.RESONANT)) * j.case.periods,
        "IRREGULAR": lambda j: (j.classification == Classification.IRREGULAR) * j.case.periods,
        "UNDECIDED, needless": lambda j: j.needless * j.case.periods,
        "not OK": lambda j: (j.classification < 0) * j.case.periods,
    }.items():
        worst = [(s, j, i) for j in results for i, s in enumerate(score(j)) if s > 0]
        for _, j, i in sorted(worst, key=lambda w: -w[0])[:count]:
            c, f = j.case, j.found
            numbers = {k: float(v) for k, v in c.parameters.items()}
            said.append(
                f"# {name}: {c.system}, near {c.cell}, T = {c.periods} periods, {c.steps}; ratio {j.ratio[i]:.4g}\n"
                f"model = fa.hamiltonian({c.text!r}, coordinates={'x y z'[: 2 * len(c.nu) - 1]!r}, **{c.making}, "
                f"**{numbers})\n"
                f"fa.frequency_map(model, {c.z0[:, i].tolist()}, time={c.time!r}, **{c.options})\n"
                f"#   nu    {f.nu[:, i].tolist()}\n#   error {f.error[:, i].tolist()}\n"
                f"#   true  {c.nu[:, i].tolist()}  rank {f.rank[i]} status {f.status[i]}\n"
            )
    return "\n".join(said)


def checked(threads=None) -> str:
    """Return the relative differences of true frequencies from those found at T = 1000, far from resonances."""
    said = []
    for case in cases(12, periods=(1000,), orbits=GROUP):
        if case.cell == "generic":
            j = judged(case, threads)
            own = j.classification == Classification.REGULAR
            size = np.abs(case.nu[:, own]).max(axis=0)
            # With errors of 1 the ratio is the difference itself.
            far = ratios(j.found.nu[:, own] / size, np.ones_like(j.found.nu[:, own]), case.nu[:, own] / size)
            said.append(f"{case.system:20} {own.sum():4} orbits, median {np.median(far):.1e}, largest {far.max():.1e}")
    return "\n".join(said)


def main() -> None:
    """Measure, print, and write the tables where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--orbits", type=int, default=200, help="of each system, time and distance")
    parser.add_argument("--periods", type=int, nargs="+", default=[10, 30, 100, 1000])
    parser.add_argument("--systems", nargs="+", choices=list(SYSTEMS))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--show", type=int, default=0, metavar="N", help="the N worst orbits of each kind")
    parser.add_argument("--quick", action="store_true", help="few orbits, steps by default")
    parser.add_argument("--deep", action="store_true", help="T = 10^4 too")
    parser.add_argument("--check", action="store_true", help="only compare the truths with long runs")
    parser.add_argument("--maps", action="store_true", help="coupled maps instead")
    parser.add_argument("--write", action="store_true", help="into docs/benchmarks/validation.md")
    given = parser.parse_args()
    if given.check:
        print(checked(given.threads))
        return
    if given.maps:
        text = map_tables(map_results(given.seed, 20 if given.quick else given.orbits, threads=given.threads))
        print(text)
        if given.write:
            put("docs/benchmarks/validation.md", "coverage of coupled maps", text)
        return
    periods = [*given.periods, *([10000] if given.deep else [])]
    orbits, steps = (12, STEPS[:1]) if given.quick else (given.orbits, STEPS)
    begin, results = time.perf_counter(), []
    for case in cases(given.seed, systems=given.systems, periods=periods, orbits=orbits, steps=steps):
        results.append(judged(case, given.threads))
    text = tables(results)
    print(text, f"{time.perf_counter() - begin:.0f} s", sep="\n")
    if given.show:
        print(shown(results, given.show))
    if given.write:
        put("docs/benchmarks/validation.md", "frequency coverage", text)


if __name__ == "__main__":
    main()
