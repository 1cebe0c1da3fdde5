"""Frequencies of loops with their errors, from inverted lines and from weighted mean rates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .fundamental import Loops, taken
from .integer_lattice import combined
from .inverted_lines import changes, inverted
from .mean_rates import PARTS, parts, turning
from .signals import Signals
from .windows import damping

SAFETY = 5.0
"""Factor of error estimates over the differences of windows and of steps: covers 99 % of the errors
(bench/test_frequency.py).
"""

REST = 5.0
"""Assumed remaining amplitude at frequency 0, relative to a line's; none for planes, whose loops have no centre that
may be off.
"""

HIGHER = 0.8
"""Share of the change with half the step that the correction for the step may be off."""


class LoopRates(NamedTuple):
    """Frequencies (orbits, loops) with their errors without those of the scheme.

    halves, halves_error (orbits, loops, 2): values of the halves; step: their decrease when the step is halved, and
    step_error: the error of that.
    """

    nu: np.ndarray
    error: np.ndarray
    step: np.ndarray
    step_error: np.ndarray
    halves: np.ndarray
    halves_error: np.ndarray

    def where(self, chosen: np.ndarray, other: LoopRates) -> LoopRates:
        """Return these rates for the chosen entries, `other` for the rest."""
        return LoopRates(
            *(np.where(chosen if a.ndim == 2 else chosen[:, :, None], a, b) for a, b in zip(self, other, strict=True))
        )

    def combined(self, k: np.ndarray) -> LoopRates:
        """Return the rates of combinations k (orbits, loops, loops) of the loops."""
        size = np.abs(k)
        return LoopRates(
            nu=combined(k, self.nu),
            error=combined(size, self.error),
            step=combined(k, self.step),
            step_error=combined(size, self.step_error),
            halves=np.stack([combined(k, half) for half in np.moveaxis(self.halves, 2, 0)], axis=2),
            halves_error=np.stack([combined(size, half) for half in np.moveaxis(self.halves_error, 2, 0)], axis=2),
        )

    def times(self, factor: np.ndarray) -> LoopRates:
        """Return the rates times factors (orbits, loops), with errors times their sizes."""
        size = np.abs(factor)
        each = factor[:, :, None]
        return LoopRates(
            nu=self.nu * factor,
            error=self.error * size,
            step=self.step * factor,
            step_error=self.step_error * size,
            halves=self.halves * each,
            halves_error=self.halves_error * np.abs(each),
        )

    def of(self, loops: slice) -> LoopRates:
        """Return the rates of some loops."""
        return LoopRates(*(entry[:, loops] for entry in self))


def line_frequencies(
    s: Signals, start: Signals | None, loops: Loops, nu: np.ndarray, threads: int, rest: float = REST
) -> LoopRates:
    """Return the frequencies of lines by nu (orbits, loops) of loops; the error is inf where there is none."""
    found = inverted(s, loops, nu, threads)
    time = s.time[:, None]
    # The halves too: the change in one window may be small by chance.
    change = np.zeros((*nu.shape, 3)) if start is None else changes(s, start, loops, nu, threads)
    return LoopRates(
        found.nu,
        found.error + rest * damping(np.abs(found.nu) * time) / time,
        *_of_step(change),
        found.halves,
        found.halves_error,
    )


def _of_step(change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the change of frequencies (orbits, loops, windows) over the first window when the step is halved, and its
    error: from the other windows, and from terms of higher order.
    """
    first = change[:, :, 0]
    return first, np.maximum(np.abs(change - change[:, :, :1]).max(axis=2), HIGHER * np.abs(first))


def averages(s: Signals, start: Signals | None, loops: Loops, librations: int, threads: int) -> LoopRates:
    """Return weighted averages of the rates of a body's own loops' arguments, those of librations first."""
    shape = loops.offset.shape
    rates = np.zeros((*shape, len(PARTS)))
    change = np.zeros((*shape, 1))
    for o in s.alike():
        own = taken(loops, o)
        run = s.array(o)
        dt = float(s.interval[o[0]])
        weights, spans = parts(run.shape[2] - 1)
        rates[o] = turning(run, own, weights, spans, dt, threads)
        if start is not None:
            for part in start.of(o).alike():
                count = int(start.samples[o[part[0]]])
                theirs = taken(own, part)
                weights, spans = (table[:1] for table in parts(count - 1))
                first = run if part.size == o.size else run[part]
                pair = first, start.array(o[part])
                coarse, fine = (turning(x, theirs, weights, spans, dt, threads) for x in pair)
                change[o[part]] = coarse - fine
    found = of_parts(rates, change)
    # The argument of a loop whose centre is not exact beats with its frequency; that of a plane has none.
    found.error[:, :librations] += damping(np.abs(found.nu[:, :librations]) * s.time[:, None]) / s.time[:, None]
    return found


def of_parts(rates: np.ndarray, change: np.ndarray) -> LoopRates:
    """Return frequencies from mean rates (orbits, loops, PARTS) and their decrease (orbits, loops, 1) when the step is
    halved.
    """

    def spread(whole: int, *parts: int) -> np.ndarray:
        return SAFETY * np.abs(rates[:, :, parts] - rates[:, :, whole, None]).max(axis=2)

    error = spread(0, 3, 4)
    halves_error = np.stack([spread(1, 5, 6), spread(2, 7, 8)], axis=2)
    return LoopRates(
        rates[:, :, 0].copy(),
        np.where(np.isfinite(error), error, np.inf),
        *_of_step(change),
        rates[:, :, 1:3],
        np.where(np.isfinite(halves_error), halves_error, np.inf),
    )
