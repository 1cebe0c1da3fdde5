"""Lattices of the lines of orbits, and the rates of their generators."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .classify import CHANCE, RESOLVED, changing, close_lines, known_frequencies, unexplained, unsettled
from .fundamental import LatticeModes, Loops, has_other_lines, modes, taken
from .inverted_lines import PARTS, beats
from .loop_rates import LoopRates, line_frequencies
from .signals import Signals

DRIFT = 3.0
"""Factor of what the frequency of a half differs from that of the whole beyond its own error: of orbits next to
separatrices, which rounding errors move, 99 % are within (bench/frequency_coverage.py).
"""

ROUNDING = 3e-13
"""Relative error of all frequencies by rounding."""

GROWN = 1e-14
"""The same times the growth of a coordinate in units of its swing."""

CLOSE_LINES = 4.0
"""Factor of errors where lines are closer than a window of `inverted_lines.PARTS` resolves: that window cannot show
them. Over 150 to 1000 units of time 2 of 3382 orbits of Henon and Heiles are beyond ten times their errors without it.
"""

ALIASED = 2.5
"""Power of the amplitude near the highest frequency of the samples that bounds the amplitudes of aliased lines, which
may lie anywhere.
"""


class Lattices(NamedTuple):
    """Lattices of lines of orbits, the rates of their loops, and as in a Reading whether they are ambiguous or
    irregular; aliased (orbits, 1): the cycles by which aliased lines may shift a frequency.
    """

    found: LatticeModes
    rates: LoopRates
    ambiguous: np.ndarray
    irregular: np.ndarray
    aliased: np.ndarray


def lattices_of(s: Signals, start: Signals | None, m: int, threads: int) -> Lattices:
    """Return the lattices of the lines of the first m loops of signals."""
    time = s.time[:, None]
    found = modes(s, m, threads)
    loops = _lattice_loops(s, found)
    rates = _lattice_rates(s, start, loops, found, threads)
    ambiguous = unexplained(found, s.time)
    irregular = changing(rates, found, s.time)
    unknown = found.moving & ~found.owned & ~(found.combination != 0).any(axis=2)
    unknown |= ambiguous[:, None] & found.moving
    aliased = found.tail[:, None] ** ALIASED
    error = rates.error + (np.where(unknown, 1.0, 0.0) + aliased) / time + drifted(rates)
    rates = rates._replace(error=error)
    beat = np.zeros_like(error)
    close = np.flatnonzero(close_lines(known_frequencies(rates, found), s.time, RESOLVED, threads, CHANCE))
    if close.size:
        some = s.of(close), taken(loops, close)
        beat[close] = beats(*some, np.where(found.owned[close], rates.nu[close], 0.0), threads)
        concealed = close[has_other_lines(*some, taken(found, close), threads)]
        ambiguous[concealed] = True
        error[concealed] += np.where(found.moving[concealed], 1.0, 0.0) / time[concealed]
    unsure, distance = unsettled(rates, found, beat, s.time, threads)
    rates = rates._replace(error=np.maximum(error, distance))
    ambiguous |= unsure
    return Lattices(found, rates, ambiguous, irregular, aliased)


def _lattice_rates(s: Signals, start: Signals | None, loops: Loops, found: LatticeModes, threads: int) -> LoopRates:
    """Return the frequencies of the loops of modes; the error is inf where nothing moves."""
    rates = line_frequencies(s, start, loops, found.nu, threads)
    # With each loop beyond two there are more lines beside that of a generator.
    crowd = max(1, found.nu.shape[1] - 1)
    # The rounding of a coordinate that has grown is relative to its size, not to its swing.
    rounded = GROWN * np.abs(loops.drift) * s.samples[:, None] * np.abs(found.nu)
    known = known_frequencies(rates, found)
    close = np.where(close_lines(known, s.time, 2 / min(PARTS), threads), CLOSE_LINES, 1.0)[:, None]
    return rates._replace(error=np.where(found.moving, close * crowd * rates.error + rounded, np.inf))


def _lattice_loops(s: Signals, found: LatticeModes) -> Loops:
    """Return the loops of the modes."""
    c = np.zeros((*found.nu.shape, s.rows), complex)
    c[:, :, : found.dual.shape[2]] = found.dual
    return Loops(c, found.offset, found.drift)


def drifted(rates: LoopRates) -> np.ndarray:
    """Return the errors (orbits, loops) of frequencies that change by more than their windows explain."""
    off = np.abs(rates.halves - rates.nu[:, :, None])
    off -= rates.halves_error + ROUNDING * np.abs(rates.nu).max(axis=1)[:, None, None]
    return DRIFT * np.where(np.isfinite(off), np.maximum(off, 0.0), 0.0).max(axis=2, initial=0.0)
