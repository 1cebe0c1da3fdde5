"""Scales of the motion of each orbit, in any units and independent of other orbits.

First the angular frequencies of small displacements at a phase point, from differences of forces; then, by a pilot run,
the angular frequency, energy and size of each orbit.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..core.status import Status
from ..engine.jit import LANES
from ..engine.kernels.samples import scales
from ..engine.packing import run_units
from ..engine.threads import by_portions
from ..engine.values import at_points
from ..systems.models.maps import jacobian
from ..systems.models.mechanics import System, length, stacked, total
from .flow import ESCAPE, FARTHEST, Ensemble, Flow, escape_radii
from .observers import columns
from .schemes.catalogue import GAUSS8, ITERATION, KAHAN_LI8, YOSHIDA4

FD_STEP = 1e-6
"""Relative displacement for the change of a force, or of rates."""

ITERATIONS = 8
"""Force differences that give the highest frequency: a frequency four times lower contributes only 1e-9."""


def fastest_rates(system: System, z: np.ndarray, step: Any) -> np.ndarray:
    """Return the highest angular frequency (orbits,) of small displacements from z (2n, orbits), even in a direction in
    which the orbit hardly moves: the root of the largest eigenvalue of W dF/dq, W = dv/dp, from below.

    By power iteration on differences of forces over a small part of |q| or of the path of a step, and the rate of a
    rotating frame. 0 where there is none.
    """
    if not system.newtonian:
        return linear_rates(system, z)
    n = z.shape[0] // 2
    q = z[:n]
    W = system.inverse_masses(z)
    with np.errstate(all="ignore"):
        way = length(_velocity(system, z[n:])) * np.where(np.isfinite(step), step, 0.0)
        size = FD_STEP * np.maximum(length(system.without_time(q)), way)
        u = system.without_time(np.cos(np.arange(1, n + 1))[:, None] + np.zeros(q.shape))
        u = u / length(u)
        for _ in range(ITERATIONS):
            change = _turned(system, W, q, size * u) / (2 * size)
            growth = length(change)
            u = change / np.where(growth > 0, growth, 1.0)
    return np.sqrt(np.where(np.isfinite(growth), growth, 0.0)) + system.frame_rate


def vector_rates(system: System, z: np.ndarray) -> np.ndarray:
    """Return the largest angular frequency (orbits,) of deviation vectors of the states z (2n, orbits): power iteration
    on the Hessian.
    """
    if not system.separable:
        return fastest_rates(system, z, np.inf)
    n = system.n
    q = z[:n]
    direction = np.random.default_rng(2).standard_normal((n, 1)) + np.zeros_like(q)
    square = np.zeros(q.shape[1])
    with np.errstate(all="ignore"):
        for _ in range(20):
            direction = system.without_time(direction / length(direction))
            change = stacked(at_points(system.model, "tangent_force", *q, *direction), q)
            direction = system.tangent_velocities(z[n:], change)
            square = length(direction)
    return np.sqrt(np.where(np.isfinite(square) & (square > 0), square, 1e-300)) + system.frame_rate


def linear_rates(system: System, z: np.ndarray) -> np.ndarray:
    """Return the largest size (orbits,) of the eigenvalues of the derivative of dz/dt of H(q, p) at z (2n, orbits); 0
    where it has none.
    """
    A = np.moveaxis(system.tangent_slopes(z[:, None], np.eye(len(z))[:, :, None]), -1, 0)
    known = np.isfinite(A).all(axis=(1, 2))
    return np.where(known, np.abs(np.linalg.eigvals(np.where(known[:, None, None], A, 0.0))).max(axis=1), 0.0)


def applied(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return matrix (n, n, ...) times vector (n, ...), in the same order for any number of orbits."""
    return np.array([total(row * vector) for row in matrix])


def first_rates(system: System, z: np.ndarray, W: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return first estimates of angular frequencies, from the curvature of V along force or velocity and from that of
    the path, at least those of a motion over the distance from the origin, or over `reach` (orbits,), inf where
    unknown: where the curvature vanishes there is no other scale. Also return the frequencies of small oscillations
    along a direction of no symmetry, 0 where there are none.
    """
    n = z.shape[0] // 2
    if not system.newtonian:
        linear = linear_rates(system, z)
        return np.where(linear > 0, linear, 1.0), linear
    with np.errstate(all="ignore"):
        v, p, F = seen(system, z)
        u = applied(W, F)
        distance, momentum, force, speed, pull = (
            length(x) for x in (*(system.without_time(x) for x in (z[:n], p, F)), v, u)
        )
        odd = np.sqrt(np.abs(np.array([W[i, i] for i in range(n)]))) * (1.0 + 0.618 * np.arange(n))[:, None]
        units = np.array([u / pull, v / speed, odd / length(odd)]).transpose(1, 0, 2)
        path = 0.3 * np.sqrt(force / momentum * pull / speed)
        wide = 0.3 * np.fmax(np.sqrt(pull / np.fmin(np.where(distance > 0, distance, np.inf), reach)), speed / reach)
        guesses = np.concatenate([[path, wide], _curvatures(system, z, W, units)])
    known = np.where(np.isfinite(guesses) & (guesses > 0), guesses, 0.0)
    stiff = known[2:4].max(axis=0)
    path = np.where(
        (stiff > 0) & (known[0] > 100 * stiff), 0.0, known[0]
    )  # next to a turning point the path turns sharply
    best = np.maximum(np.maximum(stiff, path), known[1])
    return np.where(best > 0, best, 1.0), known[4]


def _curvatures(system: System, z: np.ndarray, W: np.ndarray, units: np.ndarray) -> np.ndarray:
    """Return the angular frequencies (directions, orbits) of small oscillations along unit vectors (n, directions,
    orbits), from differences of forces; NaN where none.
    """
    q = z[: len(units), None]
    size = length(system.without_time(q))
    shift = FD_STEP * np.where(size > 0, size, 1.0) * units
    with np.errstate(all="ignore"):
        return np.sqrt(length(_turned(system, W[:, :, None], q, shift)) / (2 * length(shift)))


def _turned(system: System, W: np.ndarray, q: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Return W times the change of the force (n, ...) from q - shift to q + shift."""
    above, below = np.moveaxis(_force(system, np.stack([q + shift, q - shift], axis=1)), 1, 0)
    return applied(W, above - below)


def seen(system: System, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return velocities, momenta and forces (n, ...) in the model's frame."""
    n = z.shape[0] // 2
    if system.frame:
        return system.without_time(system.velocities(z)), *system.seen(z)
    return _velocity(system, z[n:]), z[n:], _force(system, z[:n])


def _force(system: System, q: np.ndarray) -> np.ndarray:
    return stacked(at_points(system.model, "force", *q), q)


def _velocity(system: System, p: np.ndarray) -> np.ndarray:
    return system.without_time(stacked(at_points(system.model, "velocity", *p), p))


LOOKS = 64
"""Steps, and samples, of a first look at an orbit."""

LOOKED = 1 << 21
"""Bytes of samples in memory at once: larger arrays would be new pages each time."""

TOGETHER = 1 << 14
"""Most orbits whose other arrays are in memory at once."""

COST = 32
"""Numbers that a look at a coordinate of an orbit counts as."""

PHASE = 0.2
"""The intended step of a first look in radians of the motion that it finds."""

PHASES = (0.08, 0.5)
"""The range of this step that is accepted."""

ROUGH = 1e-2
"""Change of energy, in units of the kinetic energy, above which the steps of a look are not accurate enough."""

ROUNDS = 14
"""Most looks."""

LEAP = 32.0
"""Largest factor by which the step changes between two looks."""

STILL = 1e-9
"""Spread of a map's iterates, relative to their distance from 0, below which they count as one point."""

APART = 4
"""Numbers that the difference of two counts as."""

VANISHING = 1e3
"""Ratio of the frequency of small oscillations to that of the motion above which the latter counts as none."""


RUNAWAY = 1e4
"""Assumed ratio of speeds, end to start, of an orbit that escapes or collapses at once: at its end any speed is
possible.
"""

FREE = 1 / 16
"""Least frequency of an orbit, relative to that of its angles: there may be hardly a force on it."""


class MotionScales(NamedTuple):
    """The scales of orbits, of each orbit by itself.

    rate (orbits,): the angular frequency (<F.W F>/<p.v>)^(1/2) of averages along the orbit, W = dv/dp: omega of an
    oscillator; kinetic (orbits,): the largest kinetic energy T met; position (n, orbits) and momentum (n, orbits): the
    amplitudes (2 T W_ii)^(1/2)/rate and (2 T/W_ii)^(1/2) that each coordinate would have with all the energy; radius
    (orbits,): the distance from the origin beyond which an orbit has escaped, `escape_radii`; far (orbits,): the
    largest distance of a coordinate from the origin in amplitudes, at least 1; pace (orbits,): the angular frequency
    that steps must follow, the rate or that of a drive, if it is higher; winding (n, orbits): the period of each
    coordinate, inf where it has none. They scale with the units and do not depend on the zero of V; all but radius and
    far do not depend on the origin of coordinates. An orbit at rest in an equilibrium has kinetic 0. The amplitude of
    the time of a driven system is its period, that of p_t the kinetic energy. In a rotating frame all are those of the
    motion seen there, and rates are at least the frame's own.
    """

    rate: np.ndarray
    kinetic: np.ndarray
    position: np.ndarray
    momentum: np.ndarray
    radius: np.ndarray
    far: np.ndarray
    pace: np.ndarray
    winding: np.ndarray

    def of(self, orbits: Any) -> MotionScales:
        """Return the scales of some of the orbits."""
        return MotionScales(*(entry[..., orbits] for entry in self))

    def distance(self, apart: np.ndarray) -> np.ndarray:
        """Return the size of differences of phase points (..., 2n, orbits): the largest over the coordinates in units
        of their amplitudes.
        """
        size = np.concatenate([self.position, self.momentum])
        size = np.where(size > 0, size, 1.0)
        winds = np.isfinite(self.winding).any(axis=-1)
        largest = np.zeros((*apart.shape[:-2], apart.shape[-1]))
        for row in range(len(size)):  # rows one after the other: they need not lie side by side
            away = apart[..., row, :] / size[row]
            if row < len(winds) and winds[row]:
                turn = self.winding[row] / size[row]
                away -= np.where(np.isfinite(turn), turn * np.rint(away / turn), 0.0)
            np.maximum(largest, np.abs(away, out=away), out=largest)
        return largest

    def between(self, fine: np.ndarray, coarse: np.ndarray, threads: int) -> np.ndarray:
        """Return the distances of phase points (..., 2n, orbits) of two runs."""
        result = np.empty((*fine.shape[:-2], fine.shape[-1]))

        def some(at: slice) -> None:
            with np.errstate(all="ignore"):
                result[..., at] = self.of(at).distance(fine[..., at] - coarse[..., at])

        by_portions(some, result.shape[-1], APART * fine[..., 0].size, threads)
        return result


def _chunk(rows: int, orbits: int) -> int:
    """Return the number of orbits to look at at once: about LOOKED bytes of that many rows, in equal parts."""
    most = LOOKED / (8 * (1 + LOOKS) * rows)
    return max(LANES, math.ceil(orbits / max(1, round(orbits / most))))


def natural_rates(system: System, z: np.ndarray, threads: int = 1, found: MotionScales | None = None) -> np.ndarray:
    """Return the natural angular frequency (orbits,) of each orbit from z (2n, orbits), see `MotionScales`, which may
    be `found` already; for a flow the rate at which its velocity turns at the start, 1 for a map of one variable.
    """
    if system.iterated and not system.canonical:
        return np.ones(z.shape[1])
    return (found or motion(system, z, threads)).rate if system.canonical else _turning(system, z)


def _turning(system: System, z: np.ndarray) -> np.ndarray:
    """Return |d^2z/dt^2|/|dz/dt| (orbits,) at the start of orbits of a flow, from differences of the rates."""
    with np.errstate(all="ignore"):
        rates = system.slopes(z)
        speed = length(rates)
        shift = FD_STEP * np.where(length(z) > 0, length(z), 1.0) / speed
        change = system.slopes(z + shift * rates) - system.slopes(z - shift * rates)
        return length(change) / (2 * shift * speed)


def motion(system: System, z: np.ndarray, threads: int = 1) -> MotionScales:
    """Return the scales of the orbits from z (2n, orbits), from a look at some ten radians of each.

    The step of the look is adapted to the frequency found until it is about a fifth of a radian.
    Cost: 64 steps a look, mostly one or two looks.
    """
    if system.iterated:
        return _motion_of_map(system, z, threads)
    n = z.shape[0] // 2
    orbits = z.shape[1]
    one = np.zeros(orbits)
    each = np.zeros((n, orbits))
    found = MotionScales(one + 1, one.copy(), each, each.copy(), one.copy(), one + 1, one + 1, each + 1)

    def look(at: slice) -> None:
        for start in range(at.start, at.stop, TOGETHER):
            part = slice(start, min(start + TOGETHER, at.stop))
            for whole, entry in zip(found, _observed(system, np.ascontiguousarray(z[:, part]), threads), strict=True):
                whole[..., part] = entry

    by_portions(look, orbits, COST * n, threads)
    return found


def _motion_of_map(system: System, z: np.ndarray, threads: int) -> MotionScales:
    """Return the scales of a map's orbits: rate 1 per iterate; coordinates: half the extent of LOOKS iterates, or the
    period over 2 pi; momenta: those times the ratio sqrt(|dp'/dq|/|dq'/dp|) at the start, for an angle the momentum
    that turns it by a radian in one iterate.
    """
    n = z.shape[0] // 2
    orbits = z.shape[1]
    radius = escape_radii(system, z)
    position = np.empty((n, orbits))
    momentum = np.empty((n, orbits))
    one = np.ones(orbits)
    each = _chunk(2 * n, orbits)
    for start in range(0, orbits, each):
        part = slice(start, start + each)
        flow = Flow(system, ITERATION, 1.0, 1e-12, 1e-12, threads)
        ensemble = flow.ensemble(z[:, part].copy(), radius=radius[part])
        states = flow.sampled(ensemble, LOOKS, time=float(LOOKS))
        begin = z[:, part]
        with np.errstate(all="ignore"):
            states = np.concatenate([begin.T[:, None], states], axis=1)
            spread = (np.fmax.reduce(states, axis=1) - np.fmin.reduce(states, axis=1)).T / 2
            moved = np.where(spread > STILL * np.abs(begin), spread, np.abs(begin))
            M = jacobian(system.model, begin)
            for i, period in enumerate(system.model.periods()[:n]):
                pull = np.abs(M[n + i, i])
                push = np.abs(M[i, n + i])
                ratio = np.where((pull > 0) & (push > 0), np.sqrt(pull / push), np.where(push > 0, 1 / push, pull))
                ratio = np.where(np.isfinite(ratio) & (ratio > 0), ratio, 1.0)
                size = np.fmax(moved[i], moved[n + i] / ratio)
                if period > 0:
                    ratio = np.where(push > 0, 1 / push, 1.0)
                    size = np.full(len(size), period / (2 * np.pi))
                size = np.where(np.isfinite(size) & (size > 0), size, 1.0)
                position[i, part] = size
                momentum[i, part] = size * ratio
    never = np.full((n, orbits), math.inf)
    return MotionScales(one, np.zeros(orbits), position, momentum, radius, one.copy(), one.copy(), never)


def _observed(system: System, z: np.ndarray, threads: int) -> MotionScales:
    """Look at the orbits with steps that are adapted until they suit."""
    n = z.shape[0] // 2
    orbits = z.shape[1]
    W = system.inverse_masses(z)
    radius = escape_radii(system, z)
    rate, stiff = first_rates(system, z, W, np.where(radius < FARTHEST, radius / ESCAPE, np.inf))
    turning = system.frame_rate
    drive = system.drive_rate
    kinetic = np.zeros(orbits)
    step = PHASE / np.maximum(rate, turning)
    first = rate.copy()
    now = rate.copy()
    gone = np.zeros(orbits, bool)
    todo = np.arange(orbits)
    periods = system.periods
    speed = np.zeros((n, orbits))
    reach = np.abs(z[:n])
    longest = PHASES[1] / drive if drive else math.inf
    own = np.abs(np.array([W[i, i] for i in range(n)]))
    for round_ in range(ROUNDS):
        step[todo] = np.minimum(step[todo], longest)
        each = _chunk(2 * n, todo.size)
        for part in (todo[begin : begin + each] for begin in range(0, todo.size, each)):
            states, gone[part] = _look(system, np.ascontiguousarray(z[:, part]), step[part], radius[part], threads)
            now[part], kinetic[part] = _measured(system, states, W[:, :, part])
            if any(periods):
                turned = np.fmax.reduce(np.abs(np.diff(states[:n], axis=1)), axis=1) / step[part]
                speed[:, part] = np.where(np.isfinite(turned), turned, speed[:, part])  # none where no step was reached
            reach[:, part] = np.fmax.reduce(np.abs(states[:n]), axis=1)
            if system.nonquadratic:
                own[:, part] = system.mean_inverse_masses(states)
        failed = gone[todo]
        moves = np.isfinite(now[todo]) & (now[todo] > 0)
        rate[todo] = np.where(moves, now[todo], rate[todo])
        phase = np.maximum(rate[todo], turning) * step[todo]
        fits = ((PHASES[0] <= phase) | (step[todo] == longest)) & (phase <= PHASES[1])
        fits &= ~(failed & (round_ < ROUNDS // 2))
        change = np.where(failed, 1 / LEAP, np.where(moves, np.clip(PHASE / phase, 1 / LEAP, LEAP), 1.0))
        step[todo] *= np.where(fits, 1.0, change)
        todo = todo[(~fits & moves) | (failed & (round_ < ROUNDS // 2))]
        if not todo.size:
            break
    rate = np.where(gone, np.minimum(rate, RUNAWAY * first), rate)
    rate = np.where(stiff > VANISHING * rate, stiff, rate)
    own = np.where(own > 0, own, 1.0)
    with np.errstate(all="ignore"):
        winding = np.full((n, orbits), math.inf)
        around = np.zeros(orbits)
        for i, period in enumerate(periods):
            if period > 0:  # an angle, which steps must follow, even if other rows turn with it
                winding[i] = period
                around = np.maximum(around, 2 * np.pi / period * speed[i])
        rate = np.maximum(rate, FREE * around)
        whole = np.maximum(rate, turning)
        position = np.sqrt(2 * kinetic * own) / rate
        momentum = np.sqrt(2 * kinetic / own) * (whole / rate)
        if system.driven:
            position[-1] = system.model.period
            momentum[-1] = kinetic
            winding[-1] = system.model.period
        far = np.where((position > 0) & np.isfinite(reach), reach / position, 1.0).max(axis=0)
        far = np.maximum(far, 1.0)
        pace = np.maximum(np.maximum(whole, around), drive)
        return MotionScales(
            whole, kinetic, position, momentum=momentum, radius=radius, far=far, pace=pace, winding=winding
        )


def _look(
    system: System, z: np.ndarray, step: np.ndarray, radius: np.ndarray, threads: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the starts and the states after each of some steps (2n, 1 + LOOKS, orbits), NaN where not reached, and a
    mask of the orbits that failed. Orbits whose energy changes get steps of a higher order.
    """
    states, ended = _states(system, YOSHIDA4 if system.separable else GAUSS8, z, step, radius, threads)
    failed = ended.status != Status.OK
    if not system.separable:
        return states, failed
    with np.errstate(all="ignore"):
        change = np.abs(system.energies(ended.z) - ended.energy) / ended.scale
    poor = np.flatnonzero(failed | ~(change < ROUGH))
    if poor.size:
        states[..., poor], ended = _states(system, KAHAN_LI8, z[:, poor], step[poor], radius[poor], threads)
        failed[poor] = ended.status != Status.OK
    return states, failed


def _states(
    system: System, scheme: Any, z: np.ndarray, step: np.ndarray, radius: np.ndarray, threads: int
) -> tuple[np.ndarray, Ensemble]:
    """Return the states of `_look` by a scheme, and the orbits at its end."""
    flow = Flow(system, scheme, step, 1e-12, 1e-12, threads)
    ensemble = flow.ensemble(z.copy(), radius=radius)
    samples = 1 + LOOKS
    states = np.full((len(z), samples, z.shape[1]), np.nan)
    states[:, 0] = z
    observer = columns(len(z), samples)
    memory = np.ones((observer.rows, z.shape[1]))  # the starts are there
    flow.advance(ensemble, observer, memory, states.reshape(-1, z.shape[1]), time=LOOKS * step, observations=LOOKS)
    return states, ensemble


def _measured(system: System, z: np.ndarray, W: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the angular frequency and the largest kinetic energy of states z (2n, samples, orbits), over those
    that are finite.
    """
    rate, largest = np.empty((2, z.shape[2]))
    with np.errstate(all="ignore"):
        if not system.newtonian:
            return _measured_together(system, z)
        v, p, F = seen(system, z)
        T = system.kinetic_energies(np.concatenate([z[: len(p)], p]) if system.frame else z)
        arguments = np.ascontiguousarray(W), F, v, p, T, rate, largest
        run_units(scales, arguments, -(-rate.size // LANES), threads=1)
    return rate, largest


def _measured_together(system: System, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the angular frequency and the largest kinetic energy of states z (2n, samples, orbits) of H(q, p).

    The frequency is (<p'.q'' - q'.p''>/<2 p.q'>)^(1/2), by the symplectic form of dz/dt and its change: omega of an
    oscillator in any canonical coordinates.
    """
    n = len(z) // 2
    moving = system.moving
    s = system.slopes(z)
    change = system.tangent_slopes(z, s)
    (v, f), (dv, df), (_, p) = ((x[:moving], x[n : n + moving]) for x in (s, change, z))
    moved = total(p * v)
    pulled = total(f * dv - v * df) / 2
    sound = np.isfinite(moved) & np.isfinite(pulled)
    moved = np.where(sound, moved, 0.0)
    pulled = np.where(sound, pulled, 0.0)
    return np.sqrt(total(pulled) / total(moved)), np.abs(moved).max(axis=0) / 2


def typical_rate(system: System, z: np.ndarray) -> float:
    """Return the median natural angular frequency of a set of orbits: for quantities of the set, never of a single
    orbit.
    """
    rates = natural_rates(system, z)
    return float(np.median(rates)) if rates.size and math.isfinite(np.median(rates)) else 1.0
