"""Rows of frequency analysis: ten lines of the planets over 20 million years, and a batch of short signals."""

from __future__ import annotations

from functools import partial

import numpy as np
from common import SAMPLES, signals_of
from pages import version

from fastaff.frequencies.naff import naff

from .contest import Contestant, Row

LA2010A = {
    "g1": 5.59,
    "g2": 7.453,
    "g3": 17.368,
    "g4": 17.916,
    "g5": 4.257482,
    "g6": 28.2449,
    "g7": 3.087946,
    "g8": 0.673019,
}
"""Secular frequencies of the perihelia, arcsec/yr: Laskar et al. 2011, A&A 532, A89, Table 6, column La2010a."""
RATES = np.array([*LA2010A.values(), 2 * LA2010A["g6"] - LA2010A["g5"], 2 * LA2010A["g3"] - LA2010A["g4"]])
"""Ten lines as of a planet's eccentricity: the eight and two combinations. Published are the frequencies; sizes and
phases are ours, so that the truth is known by construction."""
ORDER = [4, 5, 1, 3, 2, 0, 8, 6, 7, 9]
SIZES = 0.04 * 10 ** -(np.argsort(ORDER) / 3.0)
"""From 0.04 (g5) down to 4e-5, three lines a decade."""
PHASES = np.random.default_rng(1990).uniform(0, 2 * np.pi, RATES.size)
YEARS, TURN = 20e6, 1296000.0
"""The time spanned, and arcsec in a turn."""
LONG = 32768
"""Samples, 610 years apart: a power of two, which REBOUND's transform needs."""


def planet() -> np.ndarray:
    """Return the signal (LONG,)."""
    turns = np.outer(np.arange(LONG), RATES * (YEARS / LONG / TURN))
    return (SIZES * np.exp(1j * (2 * np.pi * (turns - np.rint(turns)) + PHASES))).sum(axis=1)


def off(rates) -> float:
    """Return the largest distance of a true line from the nearest one found, arcsec/yr."""
    return np.abs(RATES[:, None] - np.ravel(rates)).min(axis=1).max()


def planets() -> list[Contestant]:
    """Make the contestants of the ten lines."""
    signal, dt, lines = planet(), YEARS / LONG, RATES.size
    runs = {f"window order {p}": partial(naff, signal, dt, lines=lines, window_order=p) for p in (1, 2, 3)}
    found = [Contestant("fastaff", runs, lambda result: off(result.nu * TURN))]
    if version("nafflib"):
        import nafflib

        runs = {f"window order {p}": partial(nafflib.naff, signal, lines, window_order=p) for p in (1, 2, 4)}
        found.append(Contestant("nafflib", runs, lambda result: off(result[1] * TURN / dt)))
    if version("rebound"):
        import rebound

        pairs, most = signal.view(float), 60.0 * 2 * np.pi * dt / TURN
        runs = {
            kind: partial(rebound.frequency_analysis, pairs, type=kind, nfreq=lines, minfreq=-most, maxfreq=most)
            for kind in ("mft", "fmft", "fmft2")
        }
        found.append(Contestant("REBOUND", runs, lambda result: off(result[0] * TURN / (2 * np.pi * dt))))
    if version("PyNAFF"):
        import PyNAFF

        runs = {
            f"window {p}": partial(PyNAFF.naff, signal, LONG - 1, lines, 0, getFullSpectrum=True, window=p)
            for p in (1, 2)
        }
        found.append(Contestant("PyNAFF", runs, lambda result: off(result[:, 1] * TURN / dt)))
    return found


def batch(lines: int) -> list[Contestant]:
    """Make the contestants of 1000 signals of 8192 samples: nafflib takes 20 of them."""
    signals, nu = signals_of(lines)
    few = 20

    def bins(found):
        distance = np.abs(found[:, :, None] - nu[: len(found), None, :])
        return np.quantile(np.minimum(distance, 1 - distance).min(axis=2)[:few] * SAMPLES, 0.99)

    runs = {f"window order {p}": partial(naff, signals, 1.0, lines=3, window_order=p) for p in (1, 2, 3, 4)}
    found = [Contestant("fastaff", runs, lambda result: bins(result.nu))]
    if version("nafflib"):
        import nafflib

        def each(order):
            return np.array([nafflib.naff(z, num_harmonics=3, window_order=order)[1] for z in signals[:few]])

        runs = {f"window order {p}": partial(each, p) for p in (1, 2, 4)}
        found.append(Contestant("nafflib", runs, bins, few / len(signals)))
    return found


PEERS = ("nafflib", "rebound", "PyNAFF")
ROWS = [
    Row(
        "Ten secular lines, 32768 samples over 20 million years",
        "largest error of a line, arcsec/yr, truth by construction",
        (1e-4, 1e-8),
        planets,
        PEERS,
        note="frequencies g1 to g8 of La2010a and two combinations; sizes from 0.04 to 4e-5",
    ),
    Row(
        f"1000 signals of {SAMPLES} samples, three lines each",
        "error of a line in bins, 99 % of 20 signals, truth by construction",
        (1e-8, 1e-11),
        partial(batch, 3),
        ("nafflib",),
    ),
    Row(
        f"1000 signals of {SAMPLES} samples, three of eight lines each",
        "error of a line in bins, 99 % of 20 signals, truth by construction",
        (1e-4, 1e-6),
        partial(batch, 8),
        ("nafflib",),
    ),
]
