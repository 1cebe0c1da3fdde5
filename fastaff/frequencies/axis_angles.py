"""Frequencies of angles about an axis: phi by the mean rate of the azimuth, R and z by their strongest own lines."""

from __future__ import annotations

import numpy as np

from .fundamental import AT_REST, BRIEF, LatticeModes, run, store_rows, tables_of, taken
from .kernels import fundamental as kernels
from .lattices import Lattices, lattices_of
from .loop_rates import LoopRates
from .signals import Signals

DRIVEN = 1e-4
"""Cycles over the time within which a frequency that is not told from a combination of the others is one."""

SLACK = 0.02
"""Least error of lines, in cycles over the time, for their integers: bars of lines beside others may be too short."""


UNSETTLED = 0.02
"""Error of a frequency, in cycles over the time, from which other loops are asked too."""

SEEN = 6
"""Strongest lines of R and z among which their own is sought."""

KEPT = 1e-6
"""Largest relative change of an angular momentum that the axis keeps."""


def symmetric(s: Signals, m: int) -> np.ndarray:
    """Return a mask (orbits,) of orbits, not circular ones, that keep their angular momentum about the axis, the
    plane behind m loops: phi drives no line of R or z.
    """
    kept = np.zeros(s.samples.size, bool)
    for o in s.alike():
        rows = s.array(o)
        R = rows[:, 0]
        (x, y, px, py) = rows[:, 2 * m : 2 * m + 4].swapaxes(0, 1)
        turning = x * py - y * px
        with np.errstate(invalid="ignore"):
            kept[o] = np.ptp(turning, axis=1) <= KEPT * np.abs(turning).max(axis=1)
            kept[o] &= np.ptp(R, axis=1) > AT_REST * R.max(axis=1)
    return kept


def about_axis(
    some: Lattices, azimuth: LoopRates, time: np.ndarray, threads: int
) -> tuple[LoopRates, np.ndarray, np.ndarray]:
    """Return the rates (orbits, n) of R (, z) and phi, the integers (orbits, n, n) of their dominant lines, and a mask
    (orbits, 1) of orbits whose azimuth has a mean rate, from those of generators and of the azimuth (orbits, 1).

    A line of R or z that the other frequencies combine to is driven: in a bar R has the line 2 nu_phi, often its
    strongest. The frequency is that of the strongest line that makes a basis with the others; where there is none,
    the dominant line is shown, and the rank is smaller. The azimuth of an orbit that does not go around may make no
    basis: the frequency is then that of a generator.
    """
    lattice = some.rates
    found = some.found
    n = lattice.nu.shape[1]
    place = np.arange(n)
    own = np.eye(n, dtype=np.int64)
    _without_driven(some, time, threads)
    value, bar = (np.where(place == n - 1, entry, 0.0) for entry in (np.abs(azimuth.nu), azimuth.error))
    sign = np.where(azimuth.nu < 0, -1, 1)
    turns = sign * _integers(found, lattice.nu, lattice.error, value, bar, threads)[:, -1]
    goes = turns.any(axis=1)
    complete = found.rank == n
    slack = SLACK / time
    vectors = np.tile(own, (len(turns), 1, 1))
    again = np.flatnonzero((found.combination == 0).all(axis=2).any(axis=1))
    combination = found.combination.copy()
    combination[again] = _through(some, again, found.dominant, found.dominant_error, slack, threads)
    combination[goes, -1] = turns[goes]
    which = np.flatnonzero((combination != own).any(axis=(1, 2)))
    vectors[which] = _basis(some, which, turns[which], slack, threads)
    combination = combination @ np.rint(np.linalg.inv(vectors)).astype(np.int64)
    kept = (vectors[:, -1] == turns).all(axis=1) | (~complete & np.isfinite(azimuth.error[:, 0]))
    rates = lattice.combined(vectors)
    has = (np.abs(vectors) @ found.owned[:, :, None])[:, :, 0] > 0
    shown = ~has & (place < n - 1) & combination.any(axis=2)
    rates = rates.combined(combination).where(shown, rates)
    through = LoopRates(*(np.repeat(entry, n, axis=1) for entry in azimuth))
    better = kept[:, None] & (place == n - 1) & ((through.error < rates.error) | ~complete[:, None])
    return through.where(better, rates), combination, goes[:, None]


def _without_driven(some: Lattices, time: np.ndarray, threads: int) -> None:
    """Take generators from orbits that are not told where the others combine to them: a line was less exact
    than it seemed.
    """
    found = some.found
    nu = some.rates.nu
    place = np.arange(nu.shape[1])
    before = found.rank.copy()
    unsure = some.ambiguous | (some.rates.error * time[:, None] >= 1).any(axis=1)
    bar = np.repeat(DRIVEN / time[:, None], place.size, axis=1)
    for j in place:
        value = np.where(place == j, nu, 0.0)
        others = np.where(place == j, 0.0, nu)
        driven = unsure & found.owned[:, j] & _integers(found, others, 0 * bar, value, bar, threads)[:, j].any(axis=1)
        found.owned[driven, j] = False
        found.rank[driven] -= 1
    again = found.rank < before
    k = _integers(found, nu, found.spread, found.dominant, found.dominant_error, threads)
    found.combination[again] = k[again]


def _integers(
    found: LatticeModes, nu: np.ndarray, spread: np.ndarray, value: np.ndarray, bar: np.ndarray, threads: int
) -> np.ndarray:
    """Return integers (orbits, n, n) with value = k @ nu within the errors, 0 where none are short."""
    k = np.zeros((*nu.shape, nu.shape[1]), np.int64)
    basis = np.where(found.owned, nu, 0.0)
    width = np.where(found.owned, spread, 0.0)
    value = np.where(np.isfinite(bar), value, 0.0)
    arguments = value, np.where(np.isfinite(bar), bar, 0.0), basis, width, tables_of(nu.shape[1]), k
    run(kernels.combinations, len(nu), arguments, threads, BRIEF)
    return k


def _through(
    some: Lattices, orbits: np.ndarray, value: np.ndarray, bar: np.ndarray, slack: np.ndarray, threads: int
) -> np.ndarray:
    """Return the integers (orbits, n, n) of lines (all, n), with their errors, in the frequencies of some orbits."""
    found = taken(some.found, orbits)
    rates = taken(some.rates, orbits)
    width = np.maximum(bar[orbits], slack[orbits, None])
    return _integers(found, rates.nu, rates.error, value[orbits], width, threads)


def _basis(some: Lattices, which: np.ndarray, turns: np.ndarray, slack: np.ndarray, threads: int) -> np.ndarray:
    """Return the vectors (orbits, n, n) of the frequencies of R (, z) and phi in the generators of the orbits `which`,
    with those of the azimuth's mean rate (orbits, n).
    """
    every = np.arange(which.size)
    n = turns.shape[1]
    basis = np.tile(np.eye(n, dtype=np.int64), (which.size, 1, 1))
    single = (np.abs(turns) == 1)[:, ::-1]  # of its own generator, if there is a choice
    left = n - 1 - single.argmax(axis=1)
    fits = single.any(axis=1)
    basis[every[fits], left[fits]], basis[fits, -1] = basis[fits, -1], turns[fits]
    lines = some.found.lines
    value, bar, _ = np.take_along_axis(
        lines, np.argsort(-lines[:, 2], axis=2, kind="stable")[:, None], axis=3
    ).swapaxes(0, 1)
    k = [_through(some, which, value[:, :, i], bar[:, :, i], slack, threads) for i in range(SEEN)]
    for j in range(n - 1):
        back = np.rint(np.linalg.inv(basis)).astype(np.int64)
        free = np.ones(which.size, bool)
        for line in k:  # the strongest first
            own = (line[:, j, None] @ back)[:, 0, j]
            taken = free & (np.abs(own) == 1)
            basis[taken, j] = line[taken, j]
            free &= ~taken
    return basis


def through_the_plane(some: Lattices, m: int, s: Signals, start: Signals | None, threads: int) -> None:
    """Fill in the lattices of the lines of x, y (, z) for orbits whose R (, z) and plane, m + 1 loops, tell too little:
    R is not smooth near the axis. The lines that are seen stay those of R (, z).
    """
    own = np.flatnonzero(~_settled(some, s.time))
    if not own.size:
        return
    rows = [2 * m, 2 * m + 2, *range(2, 2 * m), 2 * m + 1, 2 * m + 3]  # x, z and y in the places of R, z and phi
    run = s.of(own).with_rows(rows)
    finer = None if start is None else start.of(own).with_rows(rows)
    now = lattices_of(run, finer, m + 1, threads)
    better = _settled(now, run.time) | (now.rates.error.max(axis=1) < some.rates.error[own].max(axis=1))
    taking = own[better]
    found = taken(now.found, better)
    seen = {name: getattr(some.found, name)[taking] for name in ("dominant", "dominant_error", "lines")}
    found = found._replace(**seen)
    k = _integers(found, found.nu, found.spread, found.dominant, found.dominant_error, threads)
    store_rows(some.found, taking, found._replace(combination=k))
    store_rows(some.rates, taking, taken(now.rates, better))
    for old, new in zip(some[2:], now[2:], strict=True):
        old[taking] = new[better]


def _settled(some: Lattices, time: np.ndarray) -> np.ndarray:
    """Return a mask of orbits over that time with all frequencies, in steady lines."""
    close = (some.rates.error * time[:, None] < UNSETTLED).all(axis=1)
    return close & ~some.ambiguous & ~some.irregular & (some.found.rank == some.found.nu.shape[1])
