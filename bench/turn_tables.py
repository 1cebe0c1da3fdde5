"""Tunes of maps that nobody tuned for, against turns, beside nafflib (make peers): errors, cost, coverage.

Samples are (2n, orbits, turns). The truth of kicked maps is a run over REFERENCE turns, of twist maps it is closed.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from time import process_time
from typing import NamedTuple

import numpy as np
from coupled_maps import from_whole, map_case

import fastaff as fa
from fastaff import Classification

COUNTS = (64, 128, 256, 512, 1024, 4096)
REFERENCE = 65536
ORBITS = 100
FEW = 20
"""Orbits of which nafflib finds the tunes: it takes one signal a call."""

BATCH = 10
"""Copies of the orbits in one call of `tunes` whose time is measured."""

ORDERS = (1, 2, 4)
EXACT = 1e-12
"""Largest error of a tune that is a truth."""

ROUNDED = 3e-15


class Sample(NamedTuple):
    """Samples z (2n, orbits, turns) of orbits with tunes nu (n, orbits), whose own errors are `error` (n, orbits)."""

    z: np.ndarray
    nu: np.ndarray
    error: np.ndarray


def kicked(seed: int, kick: Callable, tunes: np.ndarray | None = None) -> Callable[[int], Sample]:
    """Return samples of linear maps with random tunes, or those given, and a kick of (x, y), seen from axes turned by
    up to 0.3.
    """
    rng = np.random.default_rng(seed)
    many = 3 * ORBITS
    nu = rng.uniform(0.05, 0.45, (2, many)) if tunes is None else np.repeat(tunes[:, None], many, axis=1)
    angle = rng.uniform(-0.3, 0.3, many) if tunes is None else np.zeros(many)
    cosine, sine = np.cos(2 * np.pi * nu), np.sin(2 * np.pi * nu)
    w = 0.25 * rng.uniform(0.1, 1.0, (2, many)) * np.exp(2j * np.pi * rng.uniform(size=(2, many)))
    q, p, path = w.real, w.imag, np.empty((4, many, REFERENCE))
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    with np.errstate(all="ignore"):
        for t in range(REFERENCE):
            path[:2, :, t], path[2:, :, t] = (np.einsum("ijo,jo->io", turn, part) for part in (q, p))
            moved = p + kick(*q)
            q, p = cosine * q + sine * moved, cosine * moved - sine * q
    path = path[:, np.isfinite(path).all(axis=(0, 2))]
    truth = fa.tunes(path)
    good = (truth.classification == Classification.REGULAR) & (truth.error < EXACT).all(axis=0)
    own = np.flatnonzero(good)[:ORBITS]
    kept, nu, error = path[:, own, : COUNTS[-1]].copy(), truth.nu[:, own], truth.error[:, own]
    return lambda turns: Sample(kept[:, :, :turns], nu, error)


def islands(seed: int) -> Callable[[int], Sample]:
    """Return librational circles of the standard map, K = 0.6, about its fixed point."""
    x, p = np.random.default_rng(seed).uniform(0.3, 2.6, ORBITS), np.zeros(ORBITS)
    path = np.empty((2, ORBITS, REFERENCE))
    for t in range(REFERENCE):
        path[:, :, t] = x, p
        p = p - 0.6 * np.sin(x)
        x = x + p
    truth = fa.tunes(path)
    own = np.flatnonzero((truth.classification == Classification.REGULAR) & (truth.error < EXACT).all(axis=0))
    kept, nu, error = path[:, own, : COUNTS[-1]].copy(), truth.nu[:, own], truth.error[:, own]
    return lambda turns: Sample(kept[:, :, :turns], nu, error)


def twisted(seed: int, cell: str) -> Callable[[int], Sample]:
    """Return orbits of twist maps in coordinates turned by any angle, close to a resonance."""

    def made(turns: int) -> Sample:
        rng = np.random.default_rng([seed, turns, *cell.encode()])
        cases = [map_case(rng, cell, turns, 5) for _ in range(ORBITS // 5)]
        z, nu = [case.samples() for case in cases], [case.nu for case in cases]
        known = np.concatenate(nu, axis=1)
        return Sample(np.concatenate(z, axis=1), known, np.zeros_like(known))

    return made


SYSTEMS: dict[str, Callable[[], Callable[[int], Sample]]] = {
    "sextupoles": lambda: kicked(1, lambda x, y: np.array([x * x - y * y, -2 * x * y])),
    "octupoles": lambda: kicked(2, lambda x, y: np.array([x**3 - 3 * x * y * y, y**3 - 3 * x * x * y])),
    "Hénon 4-D": lambda: kicked(3, lambda x, y: np.array([x * x - y * y, -2 * x * y]), np.array([0.2831, 0.3123])),
    "standard map": lambda: islands(4),
    **{f"twist, {cell}": lambda cell=cell: twisted(5, cell) for cell in ("generic", "1:1", "3:2", "2:1")},
}


def nearest(nu: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Return the distances (n, orbits) of tunes from the nearest true one of their orbit, in either sense."""
    apart = np.minimum(from_whole(nu[:, None] - truth), from_whole(nu[:, None] + truth))
    return apart.min(axis=1)


def nafflib_tunes(z: np.ndarray, order: int) -> np.ndarray:
    """Return nafflib's tunes (n, orbits) of samples."""
    nafflib, n = importlib.import_module("nafflib"), len(z) // 2
    one = [[nafflib.tune(z[i, o], z[n + i, o], window_order=order) for o in range(z.shape[1])] for i in range(n)]
    return np.array(one, float)


def timed(call: Callable) -> tuple:
    """Return a result, and the least processor time of three calls."""
    call()
    times = []
    for _ in range(3):
        begin = process_time()
        result = call()
        times.append(process_time() - begin)
    return result, min(times)


class Row(NamedTuple):
    """Numbers of one system and one number of turns: errors (n, orbits) of `tunes` and, by order, of nafflib; seconds a
    signal of each; ratio (n, orbits) of errors to those stated, of REGULAR orbits; kind (orbits,).
    """

    off: np.ndarray
    theirs: dict[int, np.ndarray]
    cost: float
    their_cost: dict[int, float]
    ratio: np.ndarray
    classification: np.ndarray


def measured(sample: Sample) -> Row:
    """Return the numbers of a sample."""
    z, nu, error = sample
    found, together = fa.tunes(z, threads=1), np.tile(z, (1, BATCH, 1))
    _, cost = timed(lambda: fa.tunes(together, threads=1))
    off, few = nearest(found.nu, nu), z[:, :FEW]
    theirs, their_cost = {}, {}
    for order in ORDERS if importlib.util.find_spec("nafflib") else ():
        result, seconds = timed(lambda order=order: nafflib_tunes(few, order))
        theirs[order], their_cost[order] = nearest(result, nu[:, :FEW]), seconds / result.size
    own = found.classification == Classification.REGULAR
    ratio = (off / (found.error + error.max(axis=0) + ROUNDED))[:, own]
    return Row(off, theirs, cost / off.size / BATCH, their_cost, ratio, found.classification)


HEAD = ("system", "turns", "median", "90 %", *(f"order {p}, median" for p in ORDERS))
HEAD += (*(f"order {p}, 90 %" for p in ORDERS), "µs", "nafflib, µs")
HEAD += ("within (%)", "worst", "independent (%)", "undecided (%)", "dependent (%)", "irregular (%)")


def turn_tables() -> str:
    """Return the table: errors over the same orbits, seconds a signal, coverage of stated errors, kinds."""
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    for name, make in SYSTEMS.items():
        made = make()
        for turns in COUNTS:
            row = measured(made(turns))
            few = row.off[:, :FEW]
            cells = [name, str(turns), *(f"{np.nanquantile(few, q):.1e}" for q in (0.5, 0.9))]
            theirs = [(row.theirs.get(p, np.full(1, np.nan)), q) for q in (0.5, 0.9) for p in ORDERS]
            cells += [f"{np.nanquantile(off, q) if np.isfinite(off).any() else np.nan:.1e}" for off, q in theirs]
            cells += [f"{1e6 * row.cost:.3g}", f"{1e6 * min(row.their_cost.values(), default=np.nan):.3g}"]
            within = [f"{100 * np.mean(row.ratio <= 1):.1f}", f"{row.ratio.max():.2g}"] if row.ratio.size else ["", ""]
            share = [
                Classification.REGULAR,
                Classification.UNDECIDED,
                Classification.RESONANT,
                Classification.IRREGULAR,
            ]
            cells += [*within, *(f"{100 * np.mean(row.classification == k):.0f}" for k in share)]
            lines.append("| " + " | ".join(cells) + " |")
            print(lines[-1], flush=True)
    return "\n".join(lines)
