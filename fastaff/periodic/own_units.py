"""The own units of orbits, for distances of phase points and for phases.

A guess has those of the motion that is seen from it. Next to an unstable orbit this motion may run away, and its
amplitudes are no size of the orbit: an orbit that has closed has its own, `closed_scale`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..runs.flow import Flow
from ..runs.scales import motion, natural_rates
from ..runs.schemes.catalogue import DOP853, ITERATION
from ..systems.models.mechanics import System

LOOKS = 64
"""Samples of a trial run of orbits of a flow."""

TURNS = 4 * np.pi
"""Radians that a trial run should show."""

LONGER = 10
"""Largest number of doublings of the time of a trial run."""

LOOSE = 1e-8
"""Tolerance of such a run."""

RESTING = 1e-28
"""Share of the largest row below which another is 0, and moves by the rounding of a Newton step alone."""


INFLATED = 100.0
"""Ratio of the motion's amplitudes to the size of the orbit that has closed above which the latter is the unit."""

PLACES = 64
"""Places at which an orbit that has closed is sampled for its size."""

DECADES = 320
"""Decades by which a unit may be too large."""

HALVINGS = 12
"""Halvings of DECADES until the right unit is known to a sixth."""

DIGITS = 1e-6
"""Part of the distance from the origin below which differences show rounding."""


class Scale(NamedTuple):
    """The own units of orbits: rows (2n, orbits), amplitudes of coordinates and momenta; rate (orbits,), an angular
    frequency; energy.
    """

    rows: np.ndarray
    rate: np.ndarray
    energy: np.ndarray

    def of(self, which: Any) -> Scale:
        """Return the units of some of the orbits."""
        return Scale(*(entry[..., which] for entry in self))

    def put(self, which: Any, others: Scale) -> None:
        """Set the units of some of the orbits."""
        for entry, other in zip(self, others, strict=True):
            entry[..., which] = other

    def matrix(self, monodromy: np.ndarray) -> np.ndarray:
        """Return monodromy matrices (orbits, 2n, 2n) in these units."""
        with np.errstate(all="ignore"):
            return monodromy * self.rows.T[:, None, :] / self.rows.T[:, :, None]

    def norm(self, change: np.ndarray) -> np.ndarray:
        """Return the lengths of changes (orbits, 2n) of phase points."""
        with np.errstate(all="ignore"):
            return np.linalg.norm(change / self.rows.T, axis=1)

    def rounding(self, z: np.ndarray) -> np.ndarray:
        """Return the rounding error of phase points z (2n, orbits): large where the origin is far."""
        with np.errstate(all="ignore"):
            return 4e-16 * (1 + np.linalg.norm(z / self.rows, axis=0))


def orbit_scale(system: System, z: np.ndarray, energy: np.ndarray, threads: int) -> Scale:
    """Return the own units of the orbits through z (2n, orbits), those of `MotionScales`; |energy - H(z)| counts if it
    exceeds the kinetic energy.
    """
    if system.iterated and not system.symplectic:
        return _scale_of_images(system, z, threads)
    if not system.canonical:
        return _scale_of_flow(system, z, threads)
    found = motion(system, z, threads)
    if system.iterated:
        return Scale(np.concatenate([found.position, found.momentum]), found.rate, found.kinetic)
    W = np.einsum("iij->ij", system.inverse_masses(z))
    with np.errstate(all="ignore"):
        W = found.rate * found.position / found.momentum if system.nonquadratic else W
        K = np.fmax(found.kinetic, np.abs(energy - system.energies(z)))
        if system.driven:
            K = np.where(K > 0, K, 1.0)  # a fixed point of its map may be at rest: then any unit will do
        rows = np.stack([np.sqrt(2 * K * W) / found.rate, np.sqrt(2 * K / W)])
        if system.driven:
            rows[0, -1] = system.model.period
            rows[1, -1] = K
        return Scale(rows.reshape(-1, *K.shape), found.rate, K)


def _scale_of_images(system: System, z: np.ndarray, threads: int) -> Scale:
    """Return the own units of orbits of a map that is not symplectic: half of the range of LOOKS iterates, or the
    distance from 0 if that is larger, half of the period of an angle, and the rate 1. Iterates may come to rest.
    """
    orbits = z.shape[1]
    flow = Flow(system, ITERATION, 1.0, LOOSE, LOOSE, threads)
    path = flow.sampled(flow.ensemble(np.array(z, order="C")), LOOKS, time=float(LOOKS))
    size = _half_ranges(np.concatenate([z.T[:, None], path], axis=1))
    size = np.fmax(np.where(np.isfinite(size), size, 0.0), np.abs(z))
    size = np.where(size > 0, size, 1.0)
    periods = system.model.periods()
    for row in range(system.rows):
        if periods[row] > 0:
            size[row] = periods[row] / 2
    return Scale(size, np.ones(orbits), np.zeros(orbits))


def _scale_of_flow(system: System, z: np.ndarray, threads: int) -> Scale:
    """Return the own units of orbits of dz/dt = f(z): half of the range of each row, and the rate pi/2 <|dz/dt|> over
    that, the largest of all rows: 2 pi over the period of a row that oscillates.

    They come from a trial run that is doubled until it shows two turns.
    """
    rows, orbits = z.shape
    with np.errstate(all="ignore"):
        first = natural_rates(system, z, threads)
    turns = TURNS / np.where(np.isfinite(first) & (first > 0), first, 1.0)
    time = 2.0 ** np.ceil(np.log2(turns))  # orbits that share theirs are run together
    size = np.zeros((rows, orbits))
    rate = np.zeros(orbits)
    todo = np.arange(orbits)
    flow = Flow(system, DOP853, np.inf, LOOSE, LOOSE, threads)
    for _ in range(LONGER):
        short = np.zeros(orbits, bool)
        for length in np.unique(time[todo]):
            some = todo[time[todo] == length]
            ensemble = flow.ensemble(np.ascontiguousarray(z[:, some]))
            path = np.concatenate([z[:, some].T[:, None], flow.sampled(ensemble, LOOKS, time=float(length))], axis=1)
            with np.errstate(all="ignore"):
                half = (np.fmax.reduce(path, axis=1) - np.fmin.reduce(path, axis=1)) / 2
                rates = 0.5 * np.pi * np.nansum(np.abs(np.diff(path, axis=1)), axis=1) / (half * length)
            size[:, some] = half.T
            rate[some] = np.fmax.reduce(np.where(half > 0, rates, 0.0), axis=1)
            short[some] = np.isfinite(path).all(axis=(1, 2)) & (rate[some] * length < TURNS)
        todo = np.flatnonzero(short)
        if not todo.size:
            break
        time[todo] *= 2.0
    least = RESTING * np.fmax(np.fmax.reduce(size, axis=0), np.abs(z).max(axis=0))
    here = np.where(np.abs(z) > least, np.abs(z), 1.0)
    size = np.where(np.isfinite(size) & (size > least), size, here)
    return Scale(size, np.where(rate > 0, rate, 1 / time), np.zeros(orbits))


def closed_scale(flow: Flow, z: np.ndarray, points: np.ndarray, time: np.ndarray, scale: Scale) -> Scale:
    """Return the own units of orbits from z (2n, orbits) that have closed after `time` (orbits,) at these crossings or
    images, points (orbits, crossings, 2n): `scale`, or where that is INFLATED by neighbours that run away the size of
    the orbit itself.

    It is the extent of the orbit, or the distance at which the system is no longer linear, if that is larger: a fixed
    point has no extent. A linear system has no such distance: there it is the distance from the origin.
    """
    system = flow.system
    if system.iterated:
        path = np.concatenate([z.T[:, None], points], axis=1)
        return _shrunk(flow, z, path, scale)
    if not system.canonical:
        size = _half_ranges(_path(Flow(flow.system, DOP853, np.inf, LOOSE, LOOSE, flow.threads), z, time))
        least = RESTING * np.fmax(np.fmax.reduce(size, axis=0), np.abs(z).max(axis=0))
        here = np.where(np.abs(z) > least, np.fmin(np.abs(z), scale.rows), scale.rows)
        size = np.where(np.isfinite(size) & (size > least), size, here)
        return scale._replace(rows=np.where(scale.rows > INFLATED * size, size, scale.rows))
    with np.errstate(all="ignore"):
        there = np.fmax.reduce([system.kinetic_energies(at) for at in (z, *np.moveaxis(points, 1, 0).swapaxes(1, 2))])
        doubtful = np.flatnonzero(~(scale.energy <= INFLATED**2 * there))
    if doubtful.size:
        some = scale.of(doubtful)
        path = _path(flow.of(doubtful), z[:, doubtful], time[doubtful])
        scale = Scale(*(entry.copy() for entry in scale))
        scale.put(doubtful, _shrunk(flow, z[:, doubtful], path, some))
    return scale


def _path(flow: Flow, z: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return the states (orbits, 1 + PLACES, 2n) of orbits over the time (orbits,) of each."""
    path = np.concatenate([z.T[:, None], np.full((z.shape[1], PLACES, len(z)), np.nan)], axis=1)
    for length in np.unique(time[np.isfinite(time) & (time > 0)]):
        some = np.flatnonzero(time == length)
        own = replace(flow.of(some), vectors=0).fitted(float(length), PLACES)
        path[some, 1:] = own.sampled(own.ensemble(np.ascontiguousarray(z[:, some])), PLACES, time=float(length))
    return path


def _half_ranges(path: np.ndarray) -> np.ndarray:
    """Return half of the range (2n, orbits) of each row over paths (orbits, places, 2n)."""
    with np.errstate(all="ignore"):
        return ((np.fmax.reduce(path, axis=1) - np.fmin.reduce(path, axis=1)) / 2).T


def _shrunk(flow: Flow, z: np.ndarray, path: np.ndarray, scale: Scale) -> Scale:
    """Return units that are smaller by one factor for all rows where the path (orbits, places, 2n), the distance where
    the system is no longer linear, and of a linear one the distance from the origin, are all much smaller.
    """
    n = len(z) // 2
    free = _rows_of_size(flow, n)
    if not free.size:
        return scale
    rows = scale.rows[free]
    with np.errstate(all="ignore"):
        own = np.fmax.reduce(_half_ranges(path)[free] / rows, axis=0, initial=0.0)
        beside = np.fmax.reduce(np.abs(z)[free] / rows, axis=0, initial=0.0)
    doubtful = np.flatnonzero(INFLATED * np.fmax(own, beside) < 1.0)
    factor = np.ones(own.size)
    if doubtful.size:
        linear = _linear_reach(flow, z[:, doubtful], scale.of(doubtful), free)
        factor[doubtful] = np.fmax(own[doubtful], np.where(linear < 1.0, linear, beside[doubtful]))
    factor = np.where((INFLATED * factor < 1.0) & (factor > 0.0), factor, 1.0)
    size = scale.rows.copy()
    size[free] *= factor
    if flow.system.driven:
        size[-1] *= factor**2  # of an energy
    return Scale(size, scale.rate, scale.energy * factor**2)


def _rows_of_size(flow: Flow, n: int) -> np.ndarray:
    """Return the numbers of the rows whose units are amplitudes of the motion: not those of a map's angles, whose unit
    is the radian, nor the time and its momentum.
    """
    system = flow.system
    if system.iterated:
        moving = [i for i, period in enumerate(flow.model.periods()[:n]) if not period > 0]
    else:
        moving = list(range(system.moving))
    both = np.array([*moving, *(n + i for i in moving)], np.int64)
    return both[both < system.rows]


def _linear_reach(flow: Flow, z: np.ndarray, scale: Scale, free: np.ndarray) -> np.ndarray:
    """Return the part (orbits,) of the units within which the map, or dz/dt, is linear about z (2n, orbits): second
    differences stay below first ones; 1 where it is linear in all of the unit.
    """
    change = _iterate(flow.system) if flow.system.iterated else flow.system.slopes
    rows = scale.rows

    def linear(part: np.ndarray) -> np.ndarray:
        here = change(z)
        first = np.zeros(part.size)
        second = np.zeros(part.size)
        for row in free:
            for side in (part, -part):
                near = z.copy()
                far = z.copy()
                near[row] += side * rows[row]
                far[row] += 2 * side * rows[row]
                one, two = ((change(at) - here)[free] / (rows[free] * part) for at in (near, far))
                first += np.abs(one).sum(axis=0)
                second += np.abs(two - 2 * one).sum(axis=0)
        return second <= first

    with np.errstate(all="ignore"):
        seen = DIGITS * np.fmax.reduce(np.abs(z)[free] / rows[free], axis=0)
        low = np.clip(np.log10(np.fmax(seen, 10.0**-DECADES)), -DECADES, 0.0)
        high = np.zeros(low.size)
        whole = linear(np.ones(low.size))
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            within = linear(10.0**middle)
            low = np.where(within, middle, low)
            high = np.where(within, high, middle)
    return np.where(whole, 1.0, 10.0**low)


def _iterate(system: System) -> Any:
    """Return the map as a function of phase points (2n, orbits)."""
    return lambda z: np.array(np.broadcast_arrays(*system.model.iterate(*z[: system.rows])))
