"""Frequencies of the lines of signals that are fitted together with their neighbours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .naff import FrequencyLines, followed_line, found_lines
from .windows import LINE_ORDER, SPANS, fast_length

DRIFTS = 0.6
"""Change of every loop's leading line between the halves, in cycles over a half, beyond which no lattice is sought any
more.
"""


def lines_of(f: np.ndarray, interval: float, threads: int, lines: int = 8) -> FrequencyLines:
    """Return the strongest lines of signals f (signals, samples), from a number of first samples with a fast Fourier
    transform.
    """
    samples = fast_length(f.shape[1])
    return found_lines(f[:, :samples], interval, max(1, min(lines, samples // 4 - LINE_ORDER)), LINE_ORDER, threads)


def line_rates(
    f: np.ndarray,
    interval: float,
    nu: np.ndarray,
    useless: np.ndarray,
    threads: int,
    found: FrequencyLines | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the frequency (5, signals) of the line of f (signals, samples) by nu over the first five of SPANS, and its
    uncertainty.

    It is the strongest within three bins; NaN where there is none. The uncertainty is the larger of the line's error
    bar and of its changes with the last two windows. A signal whose uncertainty reaches `useless` (signals,) is given
    up, with inf for it. found: the result of `lines_of`, if that is known.
    """
    line, uncertainty = _line_by(f, interval, nu, lines_of(f, interval, threads) if found is None else found)
    rates = np.full((5, len(f)), np.nan)
    rates[0] = line.nu
    left = np.flatnonzero(uncertainty < useless)
    for window in (3, 4, 1, 2):  # the halves last: they do not enter the uncertainty
        rates[window, left] = line.over(SPANS[window], left, threads)
        if window > 2:
            change = np.abs(rates[window, left] - rates[0, left])
            uncertainty[left] = np.maximum(uncertainty[left], np.where(np.isfinite(change), change, np.inf))
            left = left[uncertainty[left] < useless[left]]
    return rates, np.where(uncertainty < useless, uncertainty, np.inf)


def line_changes(f: np.ndarray, interval: float, nu: np.ndarray, threads: int) -> np.ndarray:
    """Return the change (signals,) from half to half, in cycles over a half, of the line of `line_rates`, inf where it
    is lost.
    """
    line, _ = _line_by(f, interval, nu, lines_of(f, interval, threads, 4))
    every = np.arange(len(f))
    first, second = (line.over(SPANS[half], every, threads) for half in (1, 2))
    change = np.abs(first - second) * f.shape[1] * interval / 2
    return np.where(np.isfinite(change), change, np.inf)


def drifts(loops: np.ndarray, leading: np.ndarray, moving: np.ndarray, h: float, threads: int) -> np.ndarray:
    """Return a mask of orbits of which no loop (orbits, m, samples) has its leading line, or one near it, among the
    three strongest of both halves.
    """
    half = loops.shape[2] // 2
    lines = min(3, half // 4 - LINE_ORDER)
    if lines < 1 or not len(loops):
        return np.zeros(len(loops), bool)
    change = np.zeros(leading.shape)
    for part in (loops[:, :, :half], loops[:, :, -half:]):
        found = found_lines(np.ascontiguousarray(part), h, lines, LINE_ORDER, threads)
        near = np.abs(np.abs(found.nu) - leading[:, :, None]) + np.where(np.isfinite(found.error), 0.0, np.inf)
        change = np.maximum(change, near.min(axis=2) * half * h)
    return moving.any(axis=1) & (np.where(moving, change, np.inf).min(axis=1) > DRIFTS)


class _Line(NamedTuple):
    """The line number `which` (signals,) of those found in signals f (signals, samples), and its frequency nu."""

    f: np.ndarray
    interval: float
    found: FrequencyLines
    which: np.ndarray
    nu: np.ndarray

    def over(self, span: tuple[float, float], signals: np.ndarray, threads: int) -> np.ndarray:
        """Return its frequency over a part of the time in some of the signals."""
        samples = fast_length(self.f.shape[1])
        first = round(span[0] * samples)
        n = fast_length(min(round((span[1] - span[0]) * samples), samples - first))
        found = self.found.take(signals)
        which = self.which[signals]
        return followed_line(self.f[signals], self.interval, LINE_ORDER, first, first + n, found, which, threads)


def _line_by(f: np.ndarray, interval: float, nu: np.ndarray, found: FrequencyLines) -> tuple[_Line, np.ndarray]:
    """Return the strongest line found in f (signals, samples) within three bins of nu (signals,), and its error bar."""
    samples = fast_length(f.shape[1])
    near = (np.abs(found.nu - nu[:, None]) * samples * interval < 3) & np.isfinite(found.error)
    which = np.where(near, np.abs(found.amplitude), -1.0).argmax(axis=1)
    some, rows = near.any(axis=1), np.arange(len(f))
    line = _Line(f, interval, found, which, np.where(some, found.nu[rows, which], np.nan))
    return line, np.where(some, found.error[rows, which], np.inf)
