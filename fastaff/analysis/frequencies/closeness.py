"""Combinations of frequencies that are closer to 0 than the resolution of lines."""

from __future__ import annotations

import functools

import numpy as np

from ...kernels.peaks import Lines
from ...kernels.relations import Closeness, Combinations, Spans, relations, vanishing
from .fundamental import BRIEF, Modes, run, tables_of
from .integer_lattice import ball, one_of_each

RESOLVED, NEAR = 1.5, 8.0
"""Cycles over the window between two lines that windows tell apart, and within which a line changes the frequencies of
its halves.
"""

RELATED = (48, 32, 12, 6, 4, 3, 3, 2)
"""Largest |k|_1 of combinations of 1, 2, ... frequencies that are compared with 0."""

FEW = 10
"""Largest |k|_1 of a combination that keeps frequencies from being independent where it is 0 within its error."""

SHOWS, LARGE = 0.1, 0.3
"""Relative amplitudes from which a line that is not told apart leaves an orbit undecided, and changes its halves."""


def closeness(found: Modes, nu: np.ndarray, time: np.ndarray, interval: np.ndarray, threads: int) -> Closeness:
    """Compare frequencies nu (orbits, m) of modes with each other that were found over a time (orbits,), from samples
    an interval (orbits,) apart.
    """
    orbits, m = nu.shape
    lines = Lines(*(np.ascontiguousarray(found.lines[:, i]) for i in range(3)))
    known = np.where(found.owned & np.isfinite(nu), nu, 0.0), np.where(found.owned, found.spread, 0.0)
    result = Closeness(np.zeros(orbits), np.zeros((orbits, m)), *np.zeros((3, orbits), bool))
    limits = RESOLVED, NEAR, SHOWS, LARGE
    spans = Spans(time, 1 / interval)
    arguments = lines, *known, found.weak, tables_of(m), _relating(m), spans, limits, result
    run(relations, orbits, arguments, threads)
    return result


def related(nu: np.ndarray, error: np.ndarray, threads: int) -> np.ndarray:
    """Return a mask of orbits whose frequencies (orbits, m) have a combination |k|_1 <= FEW of 0 within its error."""
    found = np.zeros(len(nu), bool)
    run(vanishing, len(nu), (nu, error, _few(nu.shape[1]), found), threads, BRIEF)
    return found


@functools.cache
def _few(m: int) -> np.ndarray:
    """Return the vectors k (m, vectors) of `_relating` that are no longer than FEW."""
    k, lengths = _relating(m)
    return np.ascontiguousarray(k[:, lengths <= FEW])


@functools.cache
def _relating(m: int) -> Combinations:
    """Return the vectors k (m, vectors), one of each pair +-k, of the relations of m frequencies that are tested, and
    |k|_1.
    """
    k = one_of_each(ball(m, RELATED[min(m, len(RELATED)) - 1])[1:])
    length = np.abs(k).sum(axis=1)
    return Combinations(np.ascontiguousarray(k[length > 1].T, dtype=np.float64), length[length > 1])
