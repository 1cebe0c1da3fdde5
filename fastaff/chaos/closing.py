"""Attracting periodic orbits and fixed points: Newton's method from states that have nearly settled, and the tubes
about them from which no orbit leaves.

A periodic orbit of a map, or of a drive, closes after a whole number of intervals. One of dz/dt = f(z) has an unknown
period too: it is sought within the plane across the flow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..systems.models.mechanics import System
from .settling import Motion, Tube

ITERATIONS = 12
"""Newton steps."""

CLOSED = 1e-7
"""Length of the last Newton step, in units of the rows, of an orbit that has closed."""

MOVED = 0.1
"""Largest distance of the orbit from its guess: beyond, it is another one's."""

SAME = 1e-5
"""Distance below which two points are one."""

LEAST_LOSS = 1e-5
"""Least share of a displacement that a period must take away."""

RESTING = 1e-6
"""Distance that an equilibrium moves in a radian, beside that of its neighbours at distance 1."""

WIDEST = 0.1
"""Largest radius of a tube that is tried."""

NARROWER = 4.0
"""Ratio of successive radii."""

LEVELS = 9
"""Number of radii: down to 1.5e-6."""

SETTLED = 0.1
"""Largest share of a displacement that the linear motion leaves at the end of a trial."""

LENGTHENED = 1.25
"""Factor by which a trial is longer than the one before."""

INSIDE = 0.25
"""Largest distance then, in radii, of an orbit that the tube keeps."""

BUDGET = 2**20
"""Numbers in memory at once."""

DIRECTIONS = 4
"""Random directions that are tried beside those of rows and multipliers."""

PLACES = 4
"""Places of a closed curve where neighbours are tried."""

PARTS = 32
"""Largest number of turns in a return of a cycle."""

CURVE = 256
"""Points of a closed curve."""

SAGGING = 0.1
"""Largest distance of the curve from its polygon, in radii."""

SAFETY = 4.0
"""Factor of an error over the change by shorter steps."""

ROUNDING = 4e-16
"""Rounding error of a state, relative to its size."""


@dataclass(frozen=True)
class Closed:
    """An attracting orbit: its first point and the error of that (rows,), its period in units of time, 0 for an
    equilibrium; the number of intervals that it takes, 0 for a curve; its exponent and the error of that; its tube.
    """

    point: np.ndarray
    error: np.ndarray
    period: float
    intervals: int
    exponent: float
    exponent_error: float
    tube: Tube

    def has(self, motion: Motion, z: np.ndarray) -> np.ndarray:
        """Return a mask (orbits,) of the periodic points z (rows, orbits) that are on it: no other orbit closes within
        its tube.
        """
        return nearest(motion, self.tube, z) < max(SAME, self.tube.radius)


@dataclass
class Candidates:
    """Guesses of periodic orbits: states (rows, guesses), times (guesses,) after which they return; free: whether the
    times are unknown.
    """

    z: np.ndarray
    time: np.ndarray
    free: bool


def closed_orbits(motion: Motion, guesses: Candidates, longest: float) -> list[Closed]:
    """Return the attracting orbits near guesses, each once; those whose tubes take longer than `longest` to keep orbits
    are left out.
    """
    found: list[Closed] = []
    z, time, matrix, good = _newton(motion, guesses)
    fields = _rates(motion.system, z)
    for k in np.argsort(time, kind="stable"):
        if not good[k]:
            continue
        orbit = _attracting(motion, z[:, k], float(time[k]), matrix[k], fields[:, k], guesses.free, longest)
        if orbit is None:
            good &= motion.apart(z, z[:, k, None]) > SAME
        else:
            found.append(orbit)
            good &= ~orbit.has(motion, z)
    return found


def nearest(motion: Motion, tube: Tube, z: np.ndarray) -> np.ndarray:
    """Return the distances (orbits,) of states z (rows, orbits) from an orbit."""
    inverse = (1 / motion.scale[motion.kept])[:, None]
    way = motion.wrapped(np.roll(tube.points, -1, axis=1) - tube.points)[motion.kept] * inverse
    size = (way**2).sum(axis=0) if tube.curve else np.zeros(way.shape[1])
    share = np.where(size > 0, 1 / np.where(size > 0, size, 1.0), 0.0)
    found = np.full(z.shape[1], np.inf)
    together = max(1, BUDGET // tube.points.size)
    for first in range(0, z.shape[1], together):
        some = z[:, first : first + together]
        away = motion.wrapped(some[:, :, None] - tube.points[:, None])[motion.kept] * inverse[:, :, None]
        part = np.clip((away * way[:, None]).sum(axis=0) * share, 0.0, 1.0)
        away = away - way[:, None] * part
        with np.errstate(all="ignore"):
            found[first : first + together] = np.sqrt((away**2).sum(axis=0).min(axis=1))
    return np.where(np.isnan(found), np.inf, found)


def _rates(system: System, z: np.ndarray) -> np.ndarray:
    """Return dz/dt at z (rows, orbits), an idle row 0; 0 for a map."""
    found = np.zeros(z.shape)
    if not system.iterated:
        with np.errstate(all="ignore"):
            rates = system.slopes(z)
        found[: len(rates)] = rates
    return found


def _step(motion: Motion, guesses: Candidates, z: np.ndarray, time: np.ndarray, finer: bool = False) -> tuple:
    """Return the Newton steps of states and times, in units of the rows and in time, and the derivatives (orbits,
    kept, kept) in units of the rows.
    """
    scale = motion.scale[motion.kept]
    end, matrix = motion.after(z, time, finer)
    own = matrix[:, motion.kept][:, :, motion.kept] * scale / scale[:, None]
    left = (motion.wrapped(end - z)[motion.kept] / scale[:, None]).T
    d = len(scale)
    wide = np.zeros((len(own), d + 1, d + 1))
    right = np.zeros((len(own), d + 1))
    wide[:, :d, :d] = np.eye(d) - own
    right[:, :d] = left
    wide[:, d, d] = 1.0
    if guesses.free:
        first = (_rates(motion.system, z)[motion.kept] / scale[:, None]).T
        last = (_rates(motion.system, end)[motion.kept] / scale[:, None]).T
        wide[:, :d, d] = -last * motion.interval
        wide[:, d, :d] = first * motion.interval
        wide[:, d, d] = 0.0
    step = np.full((len(own), d + 1), np.nan)
    good = np.isfinite(wide).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    if good.any():
        with np.errstate(all="ignore"):
            step[good] = (np.linalg.pinv(wide[good], rcond=1e-13) @ right[good][:, :, None])[..., 0]
    return step[:, :d].T, step[:, d] * motion.interval, own


def _newton(motion: Motion, guesses: Candidates) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the points (rows, guesses) of closed orbits, their periods, the derivatives and a mask of those closed."""
    z = np.array(guesses.z)
    time = np.array(guesses.time)
    d = len(motion.kept)
    matrix = np.full((time.size, d, d), np.nan)
    good = np.zeros(time.size, bool)
    live = np.arange(time.size)
    for _ in range(ITERATIONS):
        if not live.size:
            break
        some = Candidates(z[:, live], time[live], guesses.free)
        step, delay, own = _step(motion, some, some.z, some.time)
        size = np.linalg.norm(step, axis=0)
        matrix[live] = own
        closed = size < CLOSED
        ahead = some.z.copy()
        with np.errstate(all="ignore"):
            ahead[motion.kept] += step * motion.scale[motion.kept][:, None]
            later = some.time + delay
            near = (motion.apart(ahead, guesses.z[:, live]) < MOVED) & (later > 0.5 * guesses.time[live])
            near &= later < 2 * guesses.time[live]
        z[:, live[near]] = ahead[:, near]
        time[live[near]] = later[near]
        good[live[near & closed]] = True
        live = live[near & ~closed]
    return z, time, matrix, good


def _attracting(
    motion: Motion, z: np.ndarray, time: float, own: np.ndarray, field: np.ndarray, free: bool, longest: float
) -> Closed | None:
    """Return the closed orbit through z over its minimal period if it attracts and keeps a tube of neighbours."""
    scale = motion.scale[motion.kept]
    rests = not motion.stepwise and np.linalg.norm(field[motion.kept] / scale) * motion.interval < RESTING
    if free and rests:
        return None
    intervals = round(time / motion.interval) if motion.stepwise else 0
    if intervals > 1:
        path = np.concatenate([z[:, None], motion.window(z[:, None], intervals)[0][:, :, 0].T], axis=1)
        back = np.flatnonzero(motion.apart(path[:, 1:], z[:, None]) < SAME)
        if back.size and back[0] + 1 < intervals:
            intervals = int(back[0]) + 1
            time = intervals * motion.interval
            own = _step(motion, Candidates(z[:, None], np.array([time]), False), z[:, None], np.array([time]))[2][0]
    elif free:
        time, own = _minimal(motion, z, time, own)
    elif not motion.stepwise and not rests:
        return None  # a cycle whose period is the interval
    values, vectors = np.linalg.eig(own)
    across = values.copy()
    if free:  # without the multiplier 1 along the flow
        across[np.argmin(np.abs(values - 1))] = 0.0
    rho = float(np.abs(across).max(initial=0.0))
    if not rho < 1 - LEAST_LOSS:
        return None
    with np.errstate(all="ignore"):
        own = ((vectors * across) @ np.linalg.pinv(vectors, rcond=1e-12)).real if free else own
    returns = 1
    while not np.linalg.norm(np.linalg.matrix_power(own, returns), 2) < SETTLED:
        returns = math.ceil(LENGTHENED * returns)
        if returns * time > longest:
            return None
    points = _path(motion, z, time, intervals, free)
    if points is None:
        return None
    directions = _directions(vectors, len(scale))
    radius = _radius(motion, points, free, directions, returns, time)
    if radius is None:
        return None
    if not free:
        points = points[:, : max(1, intervals)]
    error, delay, exponent, exponent_error = _errors(motion, z, time, rho, free)
    return Closed(
        point=z,
        error=error,
        period=0.0 if rests else time,
        intervals=max(1, intervals) if motion.stepwise else 0,
        exponent=exponent,
        exponent_error=exponent_error + (abs(exponent) * delay / time if delay > 0 else 0.0),
        tube=Tube(points, radius, free),
    )


def _minimal(motion: Motion, z: np.ndarray, time: float, own: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the minimal period of a cycle of dz/dt = f(z), and the derivative over it in units of the rows."""
    parts = np.arange(2, PARTS + 1)
    end, matrix = motion.after(np.repeat(z[:, None], parts.size, axis=1), time / parts)
    back = np.flatnonzero(motion.apart(end, z[:, None]) < SAME)
    if not back.size:
        return time, own
    scale = motion.scale[motion.kept]
    least = matrix[back[-1]][np.ix_(motion.kept, motion.kept)] * scale / scale[:, None]
    return time / int(parts[back[-1]]), least


def _path(motion: Motion, z: np.ndarray, time: float, intervals: int, free: bool) -> np.ndarray | None:
    """Return points of the orbit (rows, points); those of a curve divide its period."""
    if not free:
        if intervals <= 1:
            return z[:, None]
        return np.concatenate([z[:, None], motion.window(z[:, None], intervals - 1)[0][:, :, 0].T], axis=1)
    flow, ensemble = motion.begun(z[:, None])
    flow = flow.fitted(time, CURVE)
    states = flow.sampled(ensemble, CURVE, time=time)[0].T
    return np.roll(states, 1, axis=1) if np.isfinite(states).all() else None


def _directions(vectors: np.ndarray, rows: int) -> np.ndarray:
    """Return unit directions (rows, directions) both ways: rows, directions of multipliers, and some more."""
    more = np.random.default_rng(52).standard_normal((rows, DIRECTIONS))
    found = np.concatenate([np.eye(rows), vectors.real, vectors.imag, more], axis=1)
    size = np.linalg.norm(found, axis=0)
    found = found[:, size > 1e-8] / size[size > 1e-8]
    return np.concatenate([found, -found], axis=1)


def _radius(
    motion: Motion, points: np.ndarray, curve: bool, directions: np.ndarray, returns: int, time: float
) -> float | None:
    """Return the largest radius of a tube whose neighbours in all directions come back to the orbit; None for none."""
    scale = motion.scale[motion.kept]
    places = points[:, :: points.shape[1] // PLACES] if curve else points
    sizes = WIDEST / NARROWER ** np.arange(LEVELS)
    near = np.repeat(places[:, :, None], directions.shape[1], axis=2)[:, :, :, None] * np.ones(LEVELS)
    near[motion.kept] += (scale[:, None] * directions)[:, None, :, None] * sizes
    flat = near.reshape(len(points), -1)
    inside = motion.system.inside(flat)
    end = np.full(flat.shape, np.nan)
    if inside.any():
        count = max(1, round(returns * time / motion.interval))
        end[:, inside] = motion.run(flat[:, inside], count, []).z
    away = nearest(motion, Tube(points, 0.0, curve), end)
    kept: np.ndarray = np.all(away.reshape(-1, LEVELS) <= INSIDE * sizes, axis=0)
    if curve:
        middle = points[:, 1::2]
        sag = float(nearest(motion, Tube(points[:, ::2], 0.0, True), middle).max()) / 4
        kept = kept & (sag < SAGGING * sizes)
    for level in range(LEVELS):
        if kept[level : level + 3].all():
            return float(sizes[level]) / 2
    return None


def _errors(
    motion: Motion, z: np.ndarray, time: float, rho: float, free: bool
) -> tuple[np.ndarray, float, float, float]:
    """Return the errors of the point (rows,) and of the period, the exponent and its error, by shorter steps."""
    given = Candidates(z[:, None], np.array([time]), free)
    scale = motion.scale[motion.kept]
    step, delay, fine = _step(motion, given, given.z, given.time, finer=True)
    error = np.zeros(len(z))
    lost = np.linalg.norm(np.linalg.pinv(np.eye(len(scale)) - fine[0], rcond=1e-6), 2)
    rounding = ROUNDING * (np.linalg.norm(z[motion.kept] / scale) + 1.0) * (1.0 + lost)
    error[motion.kept] = scale * (SAFETY * np.abs(step[:, 0]) + SAFETY * rounding)
    values = np.linalg.eigvals(fine[0])
    if free:
        values = np.delete(values, int(np.argmin(np.abs(values - 1))))
    finer = float(np.abs(values).max(initial=0.0))
    change = SAFETY * (abs(finer - rho) + ROUNDING * (1.0 + float(np.linalg.norm(fine[0]))))
    exponent = math.log(rho) / time if rho > 0 else -math.inf
    return error, SAFETY * abs(float(delay[0])), exponent, change / rho / time if rho > 0 else math.inf
