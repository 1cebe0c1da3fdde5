"""Frequencies of the lines of loops by harmonic inversion, in windows of the whole and of its halves, with errors."""

from __future__ import annotations

import numpy as np

from ...kernels import harmonic_inversion as kernels
from .demodulated import LineRates, demodulated
from .fundamental import Loops, run, taken
from .signals import Signals

PARTS = (0.7,)
"""Lengths of windows at the beginning and at the end, in units of the whole, that show the error of a line: windows of
0.85 too cover no more, 99.0 % in the place of 98.9.
"""

SAFETY = 5.0
"""Factor of the error over the largest of growth, residual and differences of windows: 98.9 % of 1937 lines of regular
orbits over 20 to 300 periods are within, 0.2 % ten times beyond; with verdicts see `bench/frequency_coverage.py`.
"""

HALVES_SAFETY = 20.0
"""The same for a half, of whose parts no line is sought: growth and residual of both halves alone."""

REACH = 1.5
"""Largest distance of a line from its guess, in cycles over the window: another line may be next to it."""

SHARP = 0.1
"""Error of the frequency of a half, in cycles over the whole, up to which its line counts as found."""


def _windows(samples: np.ndarray) -> kernels.Windows:
    """Return the windows (orbits, 3 + 2 PARTS): the whole, the first and the last of each part, both halves."""
    zero, half = np.zeros_like(samples), samples // 2
    begin, length = [zero], [samples]
    for part in PARTS:
        short = np.rint(part * samples).astype(np.int64)
        begin += [zero, samples - short]
        length += [short, short]
    begin += [zero, samples - half]
    length += [half, half]
    return kernels.Windows(*(np.ascontiguousarray(np.stack(table, axis=1)) for table in (begin, length)))


def inverted(signals: Signals, loops: Loops, nu: np.ndarray, threads: int) -> LineRates:
    """Return the frequencies of the lines next to nu (orbits, loops), 0 for none, of loops of the signals.

    The growth of a line, which has none, its residual, and how much it changes in shorter windows bound its error. All
    are complex numbers, as is the error, so that none vanishes where the error does not. A line that is not next to its
    guess has an infinite error.
    """
    windows = _windows(signals.samples)
    shape = (*nu.shape, windows.begin.shape[1])
    shift, growth, residual = np.full((3, *shape), np.nan)
    lines = kernels.Line(shift, growth, residual, np.zeros(shape, complex))
    arguments = signals.ragged, loops.complexes(), nu, signals.interval, windows, lines
    run(kernels.invert_loops, len(nu), arguments, threads)
    own = np.maximum(np.abs(growth), residual)
    parts = slice(1, 1 + 2 * len(PARTS))
    found = shift + 1j * growth
    apart = np.abs(found[:, :, parts] - found[:, :, :1]).max(axis=2)
    interval, samples = signals.interval[:, None], signals.samples[:, None]
    error = SAFETY * np.maximum(own[:, :, 0], apart)
    near = np.abs(shift[:, :, 0]) * samples < REACH
    known = near & np.isfinite(error)
    rates = LineRates(
        nu + np.where(known, shift[:, :, 0], 0.0) / interval,
        np.where(known, error / interval, np.inf),
        nu[:, :, None] + np.where(nu[:, :, None] != 0, shift[:, :, -2:], 0.0) / interval[:, :, None],
        np.repeat(HALVES_SAFETY * own[:, :, -2:].max(axis=2, keepdims=True) / interval[:, :, None], 2, axis=2),
    )
    _fill_lost_halves(rates, signals, loops, nu, threads)
    return rates


def _fill_lost_halves(rates: LineRates, signals: Signals, loops: Loops, nu: np.ndarray, threads: int) -> None:
    """Replace frequencies of halves that are not sharp by those of weighted sums, which follow a line that moves or
    spreads, as those of chaotic orbits do.
    """
    time = signals.time[:, None, None]
    sharp = (rates.halves_error * time < SHARP) & (np.abs(rates.halves - nu[:, :, None]) * time < 2 * REACH)
    lost = ~sharp.all(axis=2) & (nu != 0)
    some = np.flatnonzero(lost.any(axis=1))
    if some.size:
        sums = demodulated(signals.of(some), taken(loops, some), nu[some], threads)
        for mine, theirs in ((rates.halves, sums.halves), (rates.halves_error, sums.halves_error)):
            mine[some] = np.where(lost[some, :, None], theirs, mine[some])
