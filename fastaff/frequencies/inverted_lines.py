"""Frequencies of the lines of loops by harmonic inversion, in windows of the whole and of its halves, with errors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .fundamental import Loops, run
from .kernels import harmonic_inversion as kernels
from .signals import Signals, signals_of
from .windows import cosine_window, tables_for

PARTS = (0.7,)
"""Lengths of windows at the beginning and at the end, in units of the whole, that show the error of a line: windows of
0.85 too cover no more, 99.0 % in the place of 98.9.
"""

SAFETY = 5.0
"""Factor of the error over the largest of growth, residual and differences of windows: 98.9 % of 1937 lines of regular
orbits over 20 to 300 periods are within, 0.2 % ten times beyond; with classifications see
`bench/frequency_coverage.py`.
"""

HALVES_SAFETY = 20.0
"""The same for a half, of whose parts no line is sought: growth and residual of both halves alone."""

REACH = 1.5
"""Largest distance of a line from its guess, in cycles over the window: another line may be next to it."""

SHARP = 0.1
"""Error of the frequency of a half, in cycles over the whole, up to which its line counts as found."""


class LineRates(NamedTuple):
    """Frequencies nu (orbits, loops) of lines with their errors, and those of both halves (orbits, loops, 2)."""

    nu: np.ndarray
    error: np.ndarray
    halves: np.ndarray
    halves_error: np.ndarray


def _windows(samples: np.ndarray, precise: bool) -> kernels.Windows:
    """Return windows (orbits, 3 + 2 PARTS): the whole, the first and the last of PARTS, both halves, with means of the
    halves; not `precise`: the whole and the halves, with means alone.
    """
    zero = np.zeros_like(samples)
    half = samples // 2
    begin = [zero]
    length = [samples]
    for part in PARTS if precise else ():
        short = np.rint(part * samples).astype(np.int64)
        begin += [zero, samples - short]
        length += [short, short]
    begin += [zero, samples - half]
    length += [half, half]
    tables = tables_for(_weights, samples)
    none = np.full_like(samples, -1)
    of_half = tables.start + samples - 1
    place = [none] * (len(begin) - 2) + [of_half, of_half]
    if not precise:
        place[0] = tables.start
    basis = np.full(len(begin), kernels.PEAK_BASIS if precise else 0)
    if precise:
        basis[0] = kernels.LINE_BASIS
    return kernels.Windows(
        begin=np.ascontiguousarray(np.stack(begin, axis=1)),
        length=np.ascontiguousarray(np.stack(length, axis=1)),
        basis=basis,
        place=np.stack(place, axis=1),
        weights=tables.numbers,
    )


def _weights(samples: int) -> np.ndarray:
    """Return the weights of means of so many samples, then those of their half."""
    return np.concatenate([cosine_window(samples - 1), cosine_window(samples // 2 - 1)])


def _lines(signals: Signals, loops: Loops, nu: np.ndarray, windows: kernels.Windows, threads: int) -> kernels.Line:
    """Return the lines next to nu (orbits, loops) of loops in windows."""
    lines = kernels.Line(*np.full((4, *nu.shape, windows.begin.shape[1]), np.nan))
    arguments = signals.ragged, loops.complexes(), nu, signals.interval, windows, lines
    run(kernels.invert_loops, len(nu), arguments, threads)
    return lines


def inverted(signals: Signals, loops: Loops, nu: np.ndarray, threads: int) -> LineRates:
    """Return the frequencies of the lines next to nu (orbits, loops), 0 for none, of loops of the signals.

    The growth of a line, which has none, its residual, and how much it changes in shorter windows bound its error. All
    are complex numbers, as is the error, so that none vanishes where the error does not. A line that is not next to its
    guess has an infinite error. Where a half has no sharp line, as those of chaotic orbits, its frequency is the mean
    of a smooth window, which follows a line that moves or spreads.
    """
    lines = _lines(signals, loops, nu, _windows(signals.samples, True), threads)
    own = np.maximum(np.abs(lines.growth), lines.residual)
    found = lines.shift + 1j * lines.growth
    parts = slice(1, 1 + 2 * len(PARTS))
    halves = slice(1 + 2 * len(PARTS), None)
    apart = np.abs(found[:, :, parts] - found[:, :, :1]).max(axis=2)
    interval = signals.interval[:, None]
    samples = signals.samples[:, None]
    error = SAFETY * np.maximum(own[:, :, 0], apart)
    known = (np.abs(lines.shift[:, :, 0]) * samples < REACH) & np.isfinite(error)
    half_error = HALVES_SAFETY * own[:, :, halves].max(axis=2)
    shift = lines.shift[:, :, halves]
    sharp = (half_error * samples < SHARP) & (np.abs(shift) * samples[:, :, None] < 2 * REACH).all(axis=2)
    shift = np.where(sharp[:, :, None], shift, lines.mean[:, :, halves])
    half_error = np.where(sharp, half_error, np.inf)
    return LineRates(
        nu + np.where(known, lines.shift[:, :, 0], 0.0) / interval,
        np.where(known, error / interval, np.inf),
        nu[:, :, None] + np.where(np.isfinite(shift), shift, 0.0) / interval[:, :, None],
        np.repeat((half_error / interval)[:, :, None], 2, axis=2),
    )


def inverted_values(f: np.ndarray, nu: np.ndarray) -> LineRates:
    """Return the frequencies (signals,), per sample, of the lines next to nu (signals,) of complex signals f (signals,
    samples).
    """
    count = len(f)
    if count == 0:
        return LineRates(*np.zeros((2, 0)), *np.zeros((2, 0, 2)))
    signals = signals_of(np.stack([f.real, f.imag], axis=1), 1.0)
    zero = np.zeros((count, 1), complex)
    loops = Loops(np.tile(np.array([1.0, 1.0j]), (count, 1, 1)), zero, zero)
    near = np.where(nu == 0, np.finfo(float).tiny, nu)  # 0 is no line
    return LineRates(*(entry[:, 0] for entry in inverted(signals, loops, near[:, None], 1)))


def beats(signals: Signals, loops: Loops, nu: np.ndarray, threads: int) -> np.ndarray:
    """Return the largest differences (orbits, loops) of mean rates of loops over the halves, in smooth windows, from
    their lines nu (orbits, loops); 0 where there is no line.
    """
    mean = _lines(signals, loops, nu, _windows(signals.samples, False), threads).mean[:, :, 1:]
    off = np.abs(mean).max(axis=2) / signals.interval[:, None]
    return np.where(np.isfinite(off), off, 0.0)


def changes(coarse: Signals, fine: Signals, loops: Loops, nu: np.ndarray, threads: int) -> np.ndarray:
    """Return the differences (orbits, loops, 3) of the frequencies of lines by nu (orbits, loops) between two signals
    of the same orbits, over the samples of `fine` and over their halves; 0 where there is no line.

    In each window both are the mean of a smooth one, so that what other lines add is the same.
    """
    windows = _windows(fine.samples, False)
    one, other = (_lines(signals, loops, nu, windows, threads).mean for signals in (coarse, fine))
    change = (one - other) / fine.interval[:, None, None]
    return np.where(np.isfinite(change), change, 0.0)
