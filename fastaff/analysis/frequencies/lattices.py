"""Lattices of the lines of orbits, the rates of their generators, and whether these tell a torus."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .closeness import Closeness, closeness, related
from .fundamental import Loops, Modes, adopt, fit, modes, taken, values
from .line_rates import line_changes
from .loop_rates import Rates, line_frequencies, portions, with_lines
from .signals import Signals
from .turning import CHANGED

SURELY, EACH = 3.0, 1.5
"""Change of frequencies from half to half, in cycles over a half, that close lines cannot cause; for three loops and
more for each beyond one, if lines were not told apart.
"""

BEATEN = 5.0
"""Factor of the change from half to half, the largest of an orbit, that bounds the errors of its frequencies by beats
about as slow as the whole window, and by combs of lines: 99 % of Henon's and Heiles's orbits over 30 to 500 periods
(bench/frequency_coverage.py).
"""

FAINT, SHARP, BEAT = 0.12, 0.1, 0.5
"""Share of a loop's size that lines leave, and error of the leading line of some loop, in cycles over the whole, up to
which a change from half to half of one or two loops is no evidence of chaos; and cycles over the whole within which
leading lines are one, and by which frequencies change as these beat.
"""

ROUGH, BROAD, STRANGE = 0.1, 0.03, 0.05
"""Share of a loop's size that its strongest lines leave, from which these are not few and small, and from which one fit
in ten is better than sums; relative amplitude of a line from which its multiple is no frequency.
"""

UNSURE = 0.15
"""Error of a frequency, in cycles over the whole, from which it may be that of another line: a relation that holds
within the errors may then be exact.
"""

MUCH, UNSHARP = 0.13, 0.15
"""Share of a loop's size that lines leave, and error of a leading line, in cycles over the whole, from which fits
explain no orbit of three loops and more.
"""

DRIFT = 3.0
"""Factor of what the frequency of a half differs from that of the whole beyond its own error: of orbits next to
separatrices, which rounding errors move, 99 % are within (bench/frequency_coverage.py).
"""

CLEAN = 1e-7
"""Share of a loop's size that lines leave, up to which fewer lines than loops are complete."""

SLOW = 5.0
"""Cycles over the whole from which a line differs from frequency 0."""

ROUNDING, GROWN = 3e-13, 1e-14
"""Relative errors of frequencies by rounding: of all, and times the growth of a coordinate in units of its swing."""

ALIASED = 2.5
"""Power of the amplitude near the highest frequency of the samples that bounds the amplitudes of aliased lines, which
may lie anywhere.
"""


class Lattices(NamedTuple):
    """Lattices of lines of orbits, the rates of their loops, and as in a Reading whether they are vague or irregular;
    beating (orbits,) as in a Closeness, broad (orbits,): whether fits would hardly tell more, aliased (orbits, 1): the
    cycles by which aliased lines may shift a frequency.
    """

    found: Modes
    rates: Rates
    vague: np.ndarray
    irregular: np.ndarray
    beating: np.ndarray
    broad: np.ndarray
    aliased: np.ndarray


def lattices_of(s: Signals, start: Signals | None, m: int, fallback: float | None, threads: int) -> Lattices:
    """Return the lattices of the lines of the first m loops of signals."""
    time = s.time[:, None]
    found, spectra = modes(s, m, threads)
    loops = _lattice_loops(s, found)
    lattice = _lattice_rates(s, start, loops, found, threads)
    close = closeness(found, lattice.nu, s.time, s.interval, threads)
    vague = _vague(found, close)
    irregular = _irregular(lattice, s, loops, found, close.near, vague, threads)
    again = np.flatnonzero(found.drifting & ~irregular & ~_hopeless(found, time))  # not chaos: lines are fitted
    if again.size:
        fit(found, s, spectra, again, threads)
        some, part, fitted = s.of(again), None if start is None else start.of(again), taken(found, again)
        theirs = _lattice_loops(some, fitted)
        rates = _lattice_rates(some, part, theirs, fitted, threads)
        now = closeness(fitted, rates.nu, some.time, some.interval, threads)
        vague[again] = _vague(fitted, now)
        # Beside a weak generator other lines may be larger: they are fitted.
        irregular[again] = _irregular(rates, some, theirs, fitted, np.ones_like(now.near), vague[again], threads)
        for table, new in ((loops, theirs), (lattice, rates), (close, now)):
            adopt(table, again, new)
    centre = found.nu
    slow = np.abs(centre) * time < SLOW  # not separated from the rest at frequency 0
    # Lines closer than the resolution beat, and all windows see the same part of the beat.
    unknown = found.moving & ~found.owned & ~(found.combination != 0).any(axis=2)
    blur = np.where(unknown | (vague[:, None] & found.moving), 1.0, close.blur)
    broad = irregular | ((found.rest > BROAD) & (fallback is None))  # fits would hardly tell more
    useless = broad[:, None] | slow | (lattice.error * time < blur)
    steady = centre if fallback == 0 else np.where(useless, 0.0, centre)
    lattice = with_lines(lattice, s, loops, steady, fallback, threads)
    vague |= related(np.where(found.owned, lattice.nu, np.nan), lattice.error, threads)
    aliased = found.tail[:, None] ** ALIASED
    error = lattice.error + (blur + aliased) / time + beaten(lattice, close.beating) + drifted(lattice)
    lattice = lattice._replace(error=error)
    unsure = np.flatnonzero((found.owned & (lattice.error * time > UNSURE)).any(axis=1))
    own = np.where(found.owned[unsure], lattice.nu[unsure], np.nan)
    vague[unsure] |= related(own, lattice.error[unsure], threads)
    return Lattices(found, lattice, vague, irregular, close.beating, broad, aliased)


def _lattice_rates(s: Signals, start: Signals | None, loops: Loops, found: Modes, threads: int) -> Rates:
    """Return the frequencies of the loops of modes; the error is inf where nothing moves."""
    rates = line_frequencies(s, start, loops, found.nu, threads)
    # The rounding of a coordinate that has grown is relative to its size, not to its swing.
    rounded = GROWN * np.abs(loops.drift) * s.samples[:, None] * np.abs(found.nu)
    return rates._replace(error=np.where(found.moving, rates.error + rounded, np.inf))


def _hopeless(found: Modes, time: np.ndarray) -> np.ndarray:
    """Return a mask of orbits of three loops and more whose fitted lines would neither explain the motion nor show
    chaos: much is left, and not all leading lines are resolved.
    """
    blurred = found.moving & (found.leading_error * time > UNSHARP)
    return (found.nu.shape[1] > 2) & (found.rest > MUCH) & blurred.any(axis=1)


def _vague(found: Modes, closeness: Closeness) -> np.ndarray:
    """Return a mask of orbits with two visible lines closer than the window resolves, or with unexplained lines."""
    missing = found.rank < found.moving.sum(axis=1)
    unexplained = missing & ((found.rest > CLEAN) | (found.unexplained > 0))
    return closeness.close | (closeness.strange > STRANGE) | unexplained | (found.rank == 0)


def _irregular(
    rates: Rates,
    s: Signals,
    loops: Loops,
    found: Modes,
    near: np.ndarray,
    vague: np.ndarray,
    threads: int,
) -> np.ndarray:
    """Return a mask of orbits whose frequencies change from half to half by more than close lines can cause.

    A line of relative amplitude a changes the difference of the halves by at most 2 a cycles over a half. If that may
    be the whole change, the line is fitted in both halves.
    """
    change = np.where(found.moving, _change(rates) * s.time[:, None] / 2, 0.0)
    change = np.where(np.isfinite(change), change, 0.0)
    most, loop = change.max(axis=1, initial=0.0), change.argmax(axis=1)
    rough = found.rest > np.where(found.drifting & (most < SURELY), 2 * ROUGH, ROUGH)
    # Three loops and more have so many lines that several are close, if they were not told apart.
    m = found.nu.shape[1]
    least = np.where(found.drifting & (m > 2), EACH * (m - 1), CHANGED)
    if m == 2:  # leading lines of one frequency may be two, which beat
        least[np.ptp(found.leading, axis=1) * s.time < BEAT] = BEAT
    result = (most > np.where(vague & (found.rank > 0), SURELY, least)) & rough & ~near
    # With three loops and more, beats may make all the change where no line is resolved.
    unsure = (most > least) & ~result & ~(vague & ((found.rank > 0) | (m > 2)))
    for o, j in portions(s, unsure[:, None] & (np.arange(m) == loop[:, None])):
        f = values(s, loops, o, j, threads)
        result[o] = line_changes(f, float(s.interval[o[0]]), found.nu[o, j], threads) > CHANGED
    sharp = (found.leading_error * s.time[:, None] <= SHARP) | ~found.moving
    return result & ((m > 2) | ((found.rest > FAINT) & ~sharp.all(axis=1)))


def _lattice_loops(s: Signals, found: Modes) -> Loops:
    """Return the loops of the modes."""
    c = np.zeros((*found.nu.shape, s.rows), complex)
    c[:, :, : found.dual.shape[2]] = found.dual
    return Loops(c, found.offset, found.drift)


def _change(rates: Rates) -> np.ndarray:
    """Return the change of the rates (orbits, loops) from one half of the time to the other."""
    return np.abs(rates.halves[:, :, 0] - rates.halves[:, :, 1])


def beaten(rates: Rates, beating: np.ndarray) -> np.ndarray:
    """Return the errors of the frequencies of loops of orbits with combinations so slow that all windows see the same
    part of their beats, or that fits do not tell from their neighbours (orbits,): actions change with them, and all
    frequencies with these.
    """
    change = _change(rates) - ROUNDING * np.abs(rates.nu).max(axis=1, keepdims=True)
    known = np.isfinite(rates.error) & np.isfinite(change)
    most = np.where(known, np.maximum(change, 0.0), 0.0).max(axis=1, keepdims=True, initial=0.0)
    return np.where(beating[:, None], BEATEN * most, 0.0)


def drifted(rates: Rates) -> np.ndarray:
    """Return the errors (orbits, loops) of frequencies that change by more than their windows explain."""
    off = np.abs(rates.halves - rates.nu[:, :, None])
    off -= rates.halves_error + ROUNDING * np.abs(rates.nu).max(axis=1)[:, None, None]
    return DRIFT * np.where(np.isfinite(off), np.maximum(off, 0.0), 0.0).max(axis=2, initial=0.0)
