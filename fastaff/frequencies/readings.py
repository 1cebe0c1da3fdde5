"""Frequencies read from samples of orbits: each from the most accurate loop or line, with an error."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np

from ..engine.jit import LANES
from ..engine.threads import by_portions, own_threads
from .angle_loops import SignalLayout
from .axis_angles import DRIVEN, about_axis, symmetric, through_the_plane
from .classify import related, unresolved_relations
from .fundamental import BRIEF, LatticeModes, Loops, run, store_rows, taken
from .integer_lattice import box, combined
from .kernels.relations import first_vectors
from .lattices import ROUNDING, lattices_of
from .loop_rates import SAFETY, LoopRates, averages, line_frequencies, of_parts
from .rotations import Winding, going_round, mean_turns
from .signals import Signals

BEATS = 10.0
"""Factor of the errors of mean rates of orbits whose lines are closer than 1/time: all windows see the same part of
their beats.
"""

SWAYED = 0.3
"""Cycles over the window by which a beat of unresolved lines may turn a plane: up to 0.2 in heavy tops."""

ROUND = 2.0
"""Factor of the errors of mean rates of coordinates: two windows are not enough for few turns."""

SAME = 0.5
"""Largest distance of a mean rate from its line, in cycles over the window."""

COST = 16
"""Numbers that the reading of one counts as."""

STEADY = 8192
"""Samples from which the relative error of frequencies by rounding grows with the root of their number."""

REACH = 12
"""Largest |k_i| that relates a body's own angles to the lattice of its librations' lines."""


class SampledOrbits(NamedTuple):
    """Input for some orbits: signals of the run, and of its start with a finer step.

    order: of a scheme whose frequencies are those of a nearby system, so that the error is the same over all times; 0
    where it grows. start: None for given samples, whose scheme is unknown.
    """

    run: Signals
    start: Signals | None
    order: int

    def of(self, orbits: slice | np.ndarray) -> SampledOrbits:
        """Return the samples of some of the orbits."""
        return SampledOrbits(self.run.of(orbits), None if self.start is None else self.start.of(orbits), self.order)


class Reading(NamedTuple):
    """Frequencies as in a FrequencyMap, orbits first: nu and the like (orbits, n), halves and halves_error (orbits, n,
    2), basis (orbits, n, n).

    scheme_error: the share of the error (orbits, n) that is the scheme's, and rounding's. ambiguous (orbits,): whether
    two lines are closer than 1/time, or a motion is not explained by lines; irregular (orbits,): whether frequencies
    change from half to half more than close lines can do.
    """

    nu: np.ndarray
    error: np.ndarray
    scheme_error: np.ndarray
    halves: np.ndarray
    halves_error: np.ndarray
    rank: np.ndarray
    dominant: np.ndarray
    dominant_error: np.ndarray
    basis: np.ndarray
    ambiguous: np.ndarray
    irregular: np.ndarray


def read(layout: SignalLayout, samples: SampledOrbits, threads: int) -> Reading:
    """Read the frequencies of sampled orbits. Threads have equal shares of the samples."""
    parts: dict[int, Reading] = {}
    work = COST * samples.run.rows * samples.run.samples

    def some(at: slice) -> None:
        parts[at.start] = _by_axis(layout, samples.of(at), own_threads(threads))

    by_portions(some, work.size, work, threads, least=LANES)
    return Reading(*map(np.concatenate, zip(*(parts[begin] for begin in sorted(parts)), strict=True)))


def _by_axis(layout: SignalLayout, samples: SampledOrbits, threads: int) -> Reading:
    """Read the frequencies of orbits, those apart that an axis drives, by the caller's thread but for its kernels."""
    if not layout.axis:
        return _read(layout, samples, layout.m, threads)
    alone = symmetric(samples.run, layout.m)
    parts = np.flatnonzero(alone), np.flatnonzero(~alone)
    found = []
    for own, m in zip(parts, (layout.m, layout.m + 1), strict=True):
        if own.size:
            found.append(_read(layout, samples.of(own), m, threads))
    order = np.argsort(np.concatenate(parts))
    return Reading(*(np.concatenate(entries)[order] for entries in zip(*found, strict=True)))


def _read(layout: SignalLayout, samples: SampledOrbits, m: int, threads: int) -> Reading:
    """Read the frequencies of orbits by the lattice of the lines of their first m loops."""
    s = samples.run
    start = samples.start
    n = len(layout.angles.names)
    time = s.time[:, None]
    some = lattices_of(s, start, m, threads)
    driven = m > layout.m
    if driven:
        through_the_plane(some, layout.m, s, start, threads)
    found, lattice, ambiguous, irregular, aliased = some
    chosen = lattice
    combination = found.combination
    dominant, dominant_error = np.zeros((2, len(time), n))
    dominant[:, :m], dominant_error[:, :m] = found.dominant, found.dominant_error
    basis = np.zeros((len(time), n, n), np.int64)
    if layout.planes:
        c, offset = layout.own(s, threads)
        loops = Loops(c, offset, np.zeros_like(offset))
        planar = slice(layout.m, None)
        own = averages(s, start, loops, layout.m, threads)
        own = own._replace(error=np.where(ambiguous[:, None], BEATS, 1.0) * own.error)
        planes = own.of(planar)
        at = loops.of(planar)
        near = np.where(planes.error * time < 3 * SAFETY, planes.nu, 0.0)
        line = line_frequencies(s, start, at, near, threads, rest=0.0)
        same = np.abs(line.nu - planes.nu) <= planes.error
        planes = line.where(same & np.isfinite(line.error), planes)
        unresolved = (aliased + np.where(ambiguous[:, None], SWAYED, 0.0)) / time
        planes = planes._replace(error=planes.error + unresolved)
        if driven:
            chosen, combination, turning = about_axis(some, planes, s.time, threads)
        else:
            librations = own.of(slice(0, m))
            chosen, combination = _own_angles(lattice, librations, found, layout.separate, time, threads)
            chosen = LoopRates(*(np.concatenate(pair, axis=1) for pair in zip(chosen, planes, strict=True)))
            basis[:, range(m, n), range(m, n)] = 1
            turning = np.ones((len(time), 1), bool)
        dominant[:, planar] = np.where(turning, planes.nu, dominant[:, planar])
        dominant_error[:, planar] = np.where(turning, planes.error, dominant_error[:, planar])
    basis[:, :m, :m] = combination
    _better_dominant(dominant[:, :m], dominant_error[:, :m], combination, chosen.of(slice(0, m)))
    rank = found.rank + n - m
    if driven:
        ambiguous |= (chosen.error * time >= 1).any(axis=1)
    elif layout.axis:  # a resonance, as in Kepler's potential
        known = np.column_stack([np.where(found.owned, 1.0, np.nan), np.ones(len(time))])
        rank -= related(known * chosen.nu, np.minimum(chosen.error, DRIVEN / time), threads) & (rank == n)
    if layout.periods.any():
        _count_turns(
            samples, layout.periods, found, chosen, (dominant, dominant_error, basis, rank, ambiguous), threads
        )
    return _with_scheme(chosen, samples, rank, dominant, dominant_error, basis, ambiguous, irregular)


def _better_dominant(dominant: np.ndarray, error: np.ndarray, combination: np.ndarray, rates: LoopRates) -> None:
    """Set dominant lines (orbits, m) and their errors from the frequencies where the integers are known and these are
    more accurate than bins.
    """
    known = (combination != 0).any(axis=2) & np.isfinite(rates.error).all(axis=1, keepdims=True)
    through = combined(combination, rates.nu), combined(np.abs(combination), rates.error)
    known &= through[1] < error
    dominant[:] = np.where(known, through[0], dominant)
    error[:] = np.where(known, through[1], error)


def _count_turns(
    samples: SampledOrbits, periods: np.ndarray, found: LatticeModes, rates: LoopRates, places: tuple, threads: int
) -> None:
    """Make the mean rates of winding coordinates their frequencies: a lattice of lines has them, or only a multiple,
    or is incomplete.
    """
    dominant, dominant_error, basis, rank, ambiguous = places
    s = samples.run
    start = samples.start
    known = found.owned & found.moving  # one frequency too many is left to a coordinate that does not librate
    rank -= (found.owned & ~found.moving).sum(axis=1)
    going = going_round(s, periods)
    wound = np.flatnonzero(going.any(axis=1))
    if not wound.size:
        return
    turns = of_parts(*mean_turns(s.of(wound), None if start is None else start.of(wound), periods))
    turns = turns._replace(error=np.where(ambiguous[wound, None], BEATS, ROUND) * turns.error)
    mine = Winding(taken(rates, wound), basis[wound], known[wound])
    unexplained_size = mine.wind(turns, going[wound], s.time[wound], threads)
    placed = mine.placed
    for table, new in (dominant, turns.nu), (dominant_error, turns.error):
        table[wound] = np.where(placed, new, table[wound])
    store_rows(rates, wound, mine.rates)
    basis[wound] = mine.basis
    rank[wound] += mine.added
    # A rate that has no place may be a frequency of its own.
    ambiguous[wound] &= found.moving[wound].any(axis=1)
    ambiguous[wound] |= unexplained_size
    nu = np.where(mine.known, mine.rates.nu, np.nan)
    distance = unresolved_relations(nu, mine.rates.error, np.zeros_like(nu), s.time[wound], threads)
    ambiguous[wound] |= (distance >= 0).any(axis=1)
    rates.error[wound] = np.maximum(rates.error[wound], distance)


def _with_scheme(
    rates: LoopRates,
    samples: SampledOrbits,
    rank: np.ndarray,
    dominant: np.ndarray,
    dominant_error: np.ndarray,
    basis: np.ndarray,
    ambiguous: np.ndarray,
    irregular: np.ndarray,
) -> Reading:
    """Return the reading with the scheme's error subtracted where it is known, and SAFETY times its uncertainty as an
    error.
    """
    if samples.start is None:
        growth = np.zeros(1)
        correction = np.zeros_like(rates.step)
    elif samples.order:
        growth = np.ones(1)
        correction = rates.step / (1 - 0.5**samples.order)
    else:
        growth = (samples.run.samples / samples.start.samples)[:, None]
        correction = np.zeros_like(rates.step)
    top = np.abs(rates.nu).max(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        longer = np.sqrt(np.maximum(samples.run.samples / STEADY, 1.0))[:, None]
        more = SAFETY * growth * rates.step_error + ROUNDING * longer * top
        nu = rates.nu - correction
        error = rates.error + more
    known = np.isfinite(error) & np.isfinite(nu)
    dominant_error = dominant_error + np.where(np.isfinite(more), more, np.inf).max(axis=1, keepdims=True)
    return Reading(
        nu=np.where(known, nu, 0.0),
        error=np.where(known, error, np.inf),
        scheme_error=more,
        halves=rates.halves,
        halves_error=rates.halves_error,
        rank=rank,
        dominant=dominant,
        dominant_error=dominant_error,
        basis=basis,
        ambiguous=ambiguous,
        irregular=irregular,
    )


@functools.cache
def _short_first(m: int) -> np.ndarray:
    """Return the vectors of |k_i| <= REACH, by lengths, as `frequencies.kernels.fundamental.relate` takes them."""
    k = box([REACH] * m)
    k = k[np.argsort(np.abs(k).sum(axis=1), kind="stable")]
    return np.concatenate([k.T, [np.abs(k).sum(axis=1)]]).astype(float)


def _own_angles(
    lattice: LoopRates, own: LoopRates, found: LatticeModes, separate: bool, time: np.ndarray, threads: int
) -> tuple[LoopRates, np.ndarray]:
    """Return a body's librations, by its own angles where their turning is a basis of the lattice, and the dominant
    lines' integers.

    The values are those of the lattice's lines where the own angles identify them. An incomplete lattice does not
    overrule angles that turn steadily; no lattice overrules those of bodies that `separate`.
    """
    orbits, m = lattice.nu.shape
    vectors = np.zeros((orbits, m, m), np.int64)
    known = np.zeros((orbits, m), bool)
    bar = np.minimum(lattice.error, 1 / time)
    arguments = np.ascontiguousarray(own.nu), own.error + 1e-3 / time, lattice.nu, bar, _short_first(m), vectors, known
    run(first_vectors, orbits, arguments, threads, BRIEF)
    matched = (found.rank == m) & (known & (own.error * time < SAME)).all(axis=1)
    basis = matched & (np.abs(np.rint(np.linalg.det(vectors.astype(float)))) == 1)
    steady = (own.error * time < SAME).all(axis=1) & (found.rank < m)
    kept = basis | steady | separate
    best = lattice._replace(error=bar).combined(vectors).where(basis[:, None], own)
    chosen = best.where(kept[:, None], lattice)
    # dominant = combination @ lattice and own = vectors @ lattice: dominant = combination vectors^-1 @ own.
    inverse = np.zeros_like(vectors)
    inverse[basis] = np.rint(np.linalg.inv(vectors[basis].astype(float))).astype(np.int64)
    return chosen, np.where(basis[:, None, None], found.combination @ inverse, found.combination)
