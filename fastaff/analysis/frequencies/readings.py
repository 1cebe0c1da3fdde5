"""Frequencies read from samples of orbits: each from the most accurate loop or line, with an error."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np

from ...compile.jit import LANES
from ...compile.threads import by_workers
from ...kernels.relations import first_vectors
from .angle_loops import Layout
from .closeness import Closeness, closeness, related
from .fundamental import BRIEF, Loops, Modes, adopt, fit, modes, run, taken, values
from .integer_lattice import box, combined
from .line_rates import line_changes
from .loop_rates import SAFETY, Rates, averages, line_frequencies, of_parts, portions, with_lines
from .rotations import going_round, mean_turns
from .signals import Signals
from .turning import CHANGED

SURELY, EACH = 3.0, 1.5
"""Change of frequencies from half to half, in cycles over a half, that close lines cannot cause; for three loops and
more for each beyond one, if lines were not told apart.
"""

BEATS = 10.0
"""Factor of the errors of mean rates of orbits whose lines are closer than 1/time: all windows see the same part of
their beats.
"""

ROUND = 2.0
"""Factor of the errors of mean rates of coordinates: two windows are not enough for few turns."""

BEATEN = 5.0
"""Factor of the change from half to half that bounds the errors of frequencies by beats about as slow as the whole
window.
"""

FAINT, SHARP, BEAT = 0.12, 0.1, 0.5
"""Share of a loop's size that lines leave, and error of the leading line of some loop, in cycles over the whole, up to
which a change from half to half of one or two loops is no evidence of chaos; and cycles over the whole within which
leading lines are one, and by which frequencies change as these beat.
"""

SAME = 0.5
"""Largest distance of a mean rate from its line, in cycles over the window."""

ROUGH, BROAD, STRANGE = 0.1, 0.03, 0.05
"""Share of a loop's size that its strongest lines leave, from which these are not few and small, and from which one fit
in ten is better than sums; relative amplitude of a line from which its multiple is no frequency.
"""

MUCH, UNSHARP = 0.13, 0.15
"""Share of a loop's size that lines leave, and error of a leading line, in cycles over the whole, from which fits
explain no orbit of three loops and more.
"""

CLEAN = 1e-7
"""Share of a loop's size that lines leave, up to which fewer lines than loops are complete."""

SLOW = 5.0
"""Cycles over the whole from which a line differs from frequency 0."""

ROUNDING, GROWN, STEADY = 3e-13, 1e-14, 8192
"""Relative errors of frequencies by rounding: of all, and times the growth of a coordinate in units of its swing; the
samples from which the first grows with the root of their number.
"""

ALIASED = 2.5
"""Power of the amplitude near the highest frequency of the samples that bounds the amplitudes of aliased lines, which
may lie anywhere.
"""

REACH = 12
"""Largest |k_i| that relates a body's own angles to the lattice of its librations' lines."""


class Samples(NamedTuple):
    """Input for some orbits: signals of the run, and of its start with a finer step.

    order: of a scheme whose frequencies are those of a nearby system, so that the error is the same over all times; 0
    where it grows. start: None for given samples, whose scheme is unknown.
    """

    run: Signals
    start: Signals | None
    order: int

    def of(self, orbits: slice) -> Samples:
        """Return the samples of some of the orbits."""
        return Samples(self.run.of(orbits), None if self.start is None else self.start.of(orbits), self.order)


class Reading(NamedTuple):
    """Frequencies as in a FrequencyMap, orbits first: nu and the like (orbits, n), halves and halves_error (orbits, n,
    2), basis (orbits, n, n).

    scheme_error: the share of the error (orbits, n) that is the scheme's, and rounding's. vague (orbits,): whether two
    lines are closer than 1/time, or a motion is not explained by lines; irregular (orbits,): whether frequencies change
    from half to half more than close lines can do.
    """

    nu: np.ndarray
    error: np.ndarray
    scheme_error: np.ndarray
    halves: np.ndarray
    halves_error: np.ndarray
    method: np.ndarray
    rank: np.ndarray
    leading: np.ndarray
    leading_error: np.ndarray
    basis: np.ndarray
    vague: np.ndarray
    irregular: np.ndarray


def read(layout: Layout, samples: Samples, fallback: float | None, threads: int) -> Reading:
    """Read the frequencies of sampled orbits; lines are fitted to the whole where the relative error exceeds `fallback`
    (0: all are lines; None: where a frequency is off by UNSETTLED). Threads have equal shares of the samples.
    """
    done = np.cumsum(samples.run.samples)
    shares = np.arange(max(1, min(threads, done.size // LANES)) + 1)
    ends = np.unique(np.searchsorted(done, samples.run.samples.sum() * (shares / shares[-1]), side="right"))
    if ends.size <= 2:
        return _read(layout, samples, fallback, threads)
    parts: list[Any] = [None] * (ends.size - 1)

    def some(worker: int) -> None:
        parts[worker] = _read(layout, samples.of(slice(ends[worker], ends[worker + 1])), fallback, 1)

    by_workers(some, len(parts))
    return Reading(*map(np.concatenate, zip(*parts, strict=True)))


def _read(layout: Layout, samples: Samples, fallback: float | None, threads: int) -> Reading:
    """Return the result of `read`, by the caller's thread but for its kernels."""
    s, start, m, n = samples.run, samples.start, layout.m, len(layout.angles.names)
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
    lattice = lattice._replace(error=lattice.error + (blur + aliased) / time + _beaten(lattice, close.beating))
    chosen, combination = lattice, found.combination
    leading, leading_error = np.zeros((2, len(centre), n))
    leading[:, :m], leading_error[:, :m] = found.leading, found.leading_error
    basis = np.zeros((len(centre), n, n), np.int64)
    if layout.body:
        c, offset = layout.own(s, threads)
        loops = Loops(c, offset, np.zeros_like(offset))
        own = averages(s, start, loops, m, threads)
        own = own._replace(error=np.where(vague[:, None], BEATS, 1.0) * own.error)
        chosen, combination = _own_angles(lattice, own.of(slice(0, m)), found, layout.separate, time, threads)
        planes, at = own.of(slice(m, None)), loops.of(slice(m, None))
        near = np.where(planes.error * time < 3 * SAFETY, planes.nu, 0.0)
        line = line_frequencies(s, start, at, near, threads, rest=0.0)
        same = np.abs(line.nu - planes.nu) <= planes.error
        planes = line.where(same & np.isfinite(line.error), planes)
        planes = with_lines(planes, s, at, np.where(broad[:, None] & (fallback != 0), 0.0, near), fallback, threads)
        planes = planes._replace(error=planes.error + aliased / time + _beaten(planes, close.beating))
        chosen = Rates(*(np.concatenate(pair, axis=1) for pair in zip(chosen, planes, strict=True)))
        leading[:, m:], leading_error[:, m:] = planes.nu, planes.error
        basis[:, range(m, n), range(m, n)] = 1
    basis[:, :m, :m] = combination
    _better_leading(leading[:, :m], leading_error[:, :m], combination, chosen.of(slice(0, m)))
    rank = found.rank + n - m
    if layout.periods.any():
        _count_turns(samples, layout.periods, found, chosen, (leading, leading_error, basis, rank, vague), threads)
    return _with_scheme(chosen, samples, rank, leading, leading_error, basis, vague, irregular)


def _better_leading(leading: np.ndarray, error: np.ndarray, combination: np.ndarray, rates: Rates) -> None:
    """Set leading lines (orbits, m) and their errors from the frequencies where the integers are known and these are
    more accurate than bins.
    """
    known = (combination != 0).any(axis=2) & np.isfinite(rates.error).all(axis=1, keepdims=True)
    through = combined(combination, rates.nu), combined(np.abs(combination), rates.error)
    known &= through[1] < error
    leading[:] = np.where(known, through[0], leading)
    error[:] = np.where(known, through[1], error)


def _count_turns(
    samples: Samples, periods: np.ndarray, found: Modes, rates: Rates, places: tuple, threads: int
) -> None:
    """Fill in the mean rates of winding coordinates where a frequency that no line has is missing."""
    leading, leading_error, basis, rank, vague = places
    s, start, n = samples.run, samples.start, rates.nu.shape[1]
    going = going_round(s, periods) & (rank < n)[:, None]
    wound = np.flatnonzero(going.any(axis=1))
    free = going[wound] & ~found.owned[wound]
    turns = of_parts(*mean_turns(s.of(wound), None if start is None else start.of(wound), periods))
    turns = turns._replace(error=np.where(vague[wound, None], BEATS, ROUND) * turns.error)
    adopt(rates, wound, turns.where(free, taken(rates, wound)))
    for table, new in (leading, turns.nu), (leading_error, turns.error):
        table[wound] = np.where(free, new, table[wound])
    basis[wound] = np.where(free[:, :, None], np.eye(n, dtype=np.int64), basis[wound])
    rank[wound] += free.sum(axis=1)
    # A rate that has no place may be a frequency of its own.
    vague[wound] &= found.moving[wound].any(axis=1)
    vague[wound] |= (going[wound] & ~free).any(axis=1) & (rank[wound] < n)
    vague[wound] |= related(np.where(found.owned[wound] | free, rates.nu[wound], np.nan), rates.error[wound], threads)


def _lattice_rates(s: Signals, start: Signals | None, loops: Loops, found: Modes, threads: int) -> Rates:
    """Return the frequencies of the loops of modes; the error is inf where nothing moves."""
    rates = line_frequencies(s, start, loops, found.nu, threads)
    # The rounding of a coordinate that has grown is relative to its size, not to its swing.
    rounded = GROWN * np.abs(loops.drift) * s.samples[:, None] * np.abs(found.nu)
    return rates._replace(error=np.where(found.moving, rates.error + rounded, np.inf))


def _with_scheme(
    rates: Rates,
    samples: Samples,
    rank: np.ndarray,
    leading: np.ndarray,
    leading_error: np.ndarray,
    basis: np.ndarray,
    vague: np.ndarray,
    irregular: np.ndarray,
) -> Reading:
    """Return the reading with the scheme's error subtracted where it is known, and SAFETY times its uncertainty as an
    error.
    """
    if samples.start is None:
        growth, correction = np.zeros(1), np.zeros_like(rates.step)
    elif samples.order:
        growth, correction = np.ones(1), rates.step / (1 - 0.5**samples.order)
    else:
        growth, correction = (samples.run.samples / samples.start.samples)[:, None], np.zeros_like(rates.step)
    top = np.abs(rates.nu).max(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        longer = np.sqrt(np.maximum(samples.run.samples / STEADY, 1.0))[:, None]
        more = SAFETY * growth * rates.step_error + ROUNDING * longer * top
        nu, error = rates.nu - correction, rates.error + more
    known = np.isfinite(error) & np.isfinite(nu)
    leading_error = leading_error + np.where(np.isfinite(more), more, np.inf).max(axis=1, keepdims=True)
    return Reading(
        nu=np.where(known, nu, 0.0),
        error=np.where(known, error, np.inf),
        scheme_error=more,
        halves=rates.halves,
        halves_error=rates.halves_error,
        method=rates.method,
        rank=rank,
        leading=leading,
        leading_error=leading_error,
        basis=basis,
        vague=vague,
        irregular=irregular,
    )


def _hopeless(found: Modes, time: np.ndarray) -> np.ndarray:
    """Return a mask of orbits of three loops and more whose fitted lines would neither explain the motion nor show
    chaos: much is left, and not all leading lines are resolved.
    """
    blurred = found.moving & (found.leading_error * time > UNSHARP)
    return (found.nu.shape[1] > 2) & (found.rest > MUCH) & blurred.any(axis=1)


def _vague(found: Modes, closeness: Closeness) -> np.ndarray:
    """Return a mask of orbits with two visible lines closer than the window resolves, or with unexplained lines."""
    missing = found.rank < found.moving.sum(axis=1)
    return closeness.close | (closeness.strange > STRANGE) | (missing & (found.rest > CLEAN)) | (found.rank == 0)


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


def _beaten(rates: Rates, beating: np.ndarray) -> np.ndarray:
    """Return the errors of the frequencies of loops of orbits with a combination so slow that all windows see the same
    part of its beat (orbits,): actions change with it, and all frequencies with them.
    """
    change = np.maximum(_change(rates) - ROUNDING * np.abs(rates.nu).max(axis=1, keepdims=True), 0.0)
    return np.where(beating[:, None] & np.isfinite(change), BEATEN * change, 0.0)


@functools.cache
def _short_first(m: int) -> np.ndarray:
    """Return the vectors of |k_i| <= REACH, by lengths, as `kernels.fundamental.relate` takes them."""
    k = box([REACH] * m)
    k = k[np.argsort(np.abs(k).sum(axis=1), kind="stable")]
    return np.concatenate([k.T, [np.abs(k).sum(axis=1)]]).astype(float)


def _own_angles(
    lattice: Rates, own: Rates, found: Modes, separate: bool, time: np.ndarray, threads: int
) -> tuple[Rates, np.ndarray]:
    """Return a body's librations, by its own angles where their turning is a basis of the lattice, and the leading
    lines' integers.

    The values are those of the lattice's lines where the own angles identify them. An incomplete lattice does not
    overrule angles that turn steadily; no lattice overrules those of bodies that `separate`.
    """
    orbits, m = lattice.nu.shape
    vectors, known = np.zeros((orbits, m, m), np.int64), np.zeros((orbits, m), bool)
    bar = np.minimum(lattice.error, 1 / time)
    arguments = np.ascontiguousarray(own.nu), own.error + 1e-3 / time, lattice.nu, bar, _short_first(m), vectors, known
    run(first_vectors, orbits, arguments, threads, BRIEF)
    matched = (found.rank == m) & (known & (own.error * time < SAME)).all(axis=1)
    basis = matched & (np.abs(np.rint(np.linalg.det(vectors.astype(float)))) == 1)
    steady = (own.error * time < SAME).all(axis=1) & (found.rank < m)
    kept = basis | steady | separate
    through = Rates(
        nu=combined(vectors, lattice.nu),
        error=np.where(basis[:, None], combined(np.abs(vectors), np.where(basis[:, None], bar, 0.0)), np.inf),
        method=np.where(vectors != 0, lattice.method[:, None, :], 0).max(axis=2),
        step=combined(vectors, lattice.step),
        step_error=combined(np.abs(vectors), lattice.step_error),
        halves=np.stack([combined(vectors, half) for half in np.moveaxis(lattice.halves, 2, 0)], axis=2),
        halves_error=np.stack(
            [combined(np.abs(vectors), half) for half in np.moveaxis(lattice.halves_error, 2, 0)], axis=2
        ),
    )
    best = through.where(np.isfinite(through.error), own)
    chosen = best.where(kept[:, None], lattice)
    # leading = combination @ lattice and own = vectors @ lattice: leading = combination vectors^-1 @ own.
    inverse = np.zeros_like(vectors)
    inverse[basis] = np.rint(np.linalg.inv(vectors[basis].astype(float))).astype(np.int64)
    return chosen, np.where(basis[:, None, None], found.combination @ inverse, found.combination)
