"""Equations of a family of periodic orbits: its points, their tangents and corrections."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..core.status import Status
from ..runs.flow import Flow
from ..systems.models.mechanics import System, system_of
from .bifurcations import residue_products
from .closing_errors import Errors, closing_errors
from .found_orbits import PeriodicOrbits, packed
from .own_units import Scale, closed_scale, orbit_scale
from .periodic_orbits import WAIT
from .return_map import (
    Returns,
    closing_goal,
    closing_matrix,
    energy_gradient,
    finer_by,
    least_change,
    onto,
    section_returns,
    step_goal,
    vector_field,
)

CORRECTIONS = 10
"""Most corrections of a predicted point of the branch."""

BEND = 0.35
"""Largest angle, in radians, between neighbouring tangents of the branch."""

TRIES = 6
"""Steps of the scheme that are tried for a point of the branch."""

HALVED = 4.0
"""Factor by which a step may become shorter if an orbit is not found; then the way to it is shortened."""

COARSER = 1.25
"""Factor by which a step of the scheme becomes longer if its error is below SPARE."""

SPARE = 1e-2
"""Part of the allowed error below which a step of the scheme becomes longer."""

UNMOVED = 1e-12
"""Change of a return, in amplitudes, that is rounding: the orbit does not depend on the parameter."""

UNKNOWN = Errors(*4 * (np.full(1, np.nan),))
"""Errors of a point that is not checked yet."""

PLACES = 128
"""Places of an orbit at which its coordinates are sampled for their amplitude."""

FINER = 16
"""Factor by which the Fourier series of these samples is sampled more finely."""

VANISHED = 1e-3
"""Energy of the motion, beside the first orbit's, below which a branch that ends has come to an equilibrium."""


@dataclass(frozen=True)
class Point:
    """A point u = (z, value) of a branch, its return, the branch's unit tangent there (in units of the branch), its own
    units, step of the scheme and the next one to try, errors, and number of corrections."""

    u: np.ndarray
    back: Returns
    tangent: np.ndarray
    scale: Scale
    step: float
    following: float
    errors: Errors
    corrections: int


@dataclass(frozen=True)
class Family:
    """The equations of a family: flow(z) = z on the section and the energy, for z and the energy or parameter.

    section: the one asked, of the rows in memory; energy: None where it is the value itself; own_step: whether the
    scheme's step may change; units (2n + 1,) of z and value; wait: least time to wait, where none is given.
    """

    make: Callable
    flow: Flow
    section: Any
    asked: Any
    crossings: int
    max_time: float | None
    tolerance: float
    energy: float | None
    own_step: bool
    units: np.ndarray
    wait: float

    def system(self, value: float) -> System:
        """Return the system at a value of the parameter."""
        return system_of(self.make(value))

    def at(self, value: float, step: float) -> Flow:
        """Return the flow at a value of the parameter."""
        flow = self.flow if self.flow.adaptive else replace(self.flow, step=step)
        return flow if self.energy is None else replace(flow, system=self.system(value))

    def aim(self, value: float) -> np.ndarray:
        """Return the energy (1,) that the orbit of a value must have."""
        return np.array([value if self.energy is None else self.energy])

    def distance(self, u: np.ndarray, v: np.ndarray) -> float:
        """Return the distance of two points of the branch."""
        return float(np.linalg.norm((v - u) / self.units))

    def limit(self, scale: Scale) -> np.ndarray:
        """Return the time to wait for a return."""
        if self.max_time is not None:
            return np.array([self.max_time])
        return np.maximum(WAIT * self.crossings / scale.rate, self.wait)

    def returned(self, u: np.ndarray, scale: Scale, step: float) -> Returns:
        """Return the return of the orbit u = (z, value)."""
        return section_returns(self.at(u[-1], step), self.section, u[:-1, None], self.crossings, self.limit(scale))

    def shifted(self, u: np.ndarray, back: Returns, scale: Scale, step: float, h: float) -> np.ndarray:
        """Return the derivative (2n,) of the return to the parameter in own units, at the time of the return of u."""
        end = back.points[0, -1]
        ends = []
        field = vector_field(self.at(u[-1], step).system, end[:, None])[0]
        for value in (u[-1] + h, u[-1] - h):
            there = self.returned(np.append(u[:-1], value), scale, step)
            ends.append(there.points[0, -1] - field * (there.time[0] - back.time[0]))
        return (ends[0] - ends[1]) / (2 * h) / scale.rows[:, 0]

    def parameter_unit(self, u: np.ndarray, scale: Scale) -> float:
        """Return the change of the parameter that moves the return by an amplitude, times its amplification of small
        changes.
        """
        size = abs(u[-1]) or 1.0
        for h in 1e-5 * size * 10.0 ** -np.arange(0, 12, 3):
            back = self.returned(u, scale, float(self.flow.step))
            moved = float(np.linalg.norm(self.shifted(u, back, scale, float(self.flow.step), h)))
            if moved * h < UNMOVED:
                continue
            unit = max(1.0, float(np.linalg.norm(scale.matrix(back.monodromy)))) / moved if moved > 0 else size
            if np.isfinite(unit) and unit > 10 * h:
                return float(unit)
        return size

    def matrix(self, u: np.ndarray, back: Returns, scale: Scale, step: float) -> np.ndarray:
        """Return the derivative (2n + 2, 2n + 2) of the equations to z, time and value, in own units and that of the
        value.
        """
        z = u[:-1, None]
        unit = self.units[-1]
        system = self.at(u[-1], step).system
        closing = closing_matrix(system, self.section, z, back.points[:, -1], back.monodromy, scale)[0]
        rows = len(z)
        column = np.zeros(rows + 2)
        if self.section is None:  # of a map, which has no energy
            column[:rows] = unit * self.shifted(u, back, scale, step, 1e-5 * unit)
            return np.column_stack([closing, column])
        length = np.linalg.norm(energy_gradient(system, z)[0] * scale.rows[:, 0]) or 1.0  # dz/dt = f(z) has no energy
        if self.energy is None:
            column[rows + 1] = -unit / length
        else:
            h = 1e-5 * unit
            column[:rows] = unit * self.shifted(u, back, scale, step, h)
            up, down = (self.system(u[-1] + s * h).energies(z)[0] for s in (1, -1))
            column[rows + 1] = unit * (up - down) / (2 * h) / length
        return np.column_stack([closing, column])

    def corrected(self, u: np.ndarray, tangent: np.ndarray | None, scale: Scale, step: float) -> Point | None:
        """Return the point of the branch normal to the tangent from u (at the value of u for None); None if there is
        none.

        Where the scheme's step may change it is shortened until its error is below the tolerance.
        """
        best = None
        halved = 1.0
        for _ in range(TRIES if self.own_step else 1):
            point = self._closed(u, tangent, scale, step)
            if point is None:
                halved *= 2.0
                if halved > HALVED:
                    break
                step /= 2.0
                continue
            z = point.u[:-1, None]
            flow = self.at(point.u[-1], step)
            errors = closing_errors(flow, self.section, z, self.limit(scale), point.back, scale)
            change = errors.change
            steps = point.back.time / flow.step
            goal = step_goal(self.tolerance, z, steps, point.back.monodromy, scale)
            if best is not None and change[0] > 0.5 * best[0]:
                break  # rounding
            # At rest no step would show an error of the return, but its derivative has one.
            longer = self.own_step and change[0] < SPARE * goal[0] and not flow.system.driven
            # Past an orbit that was missed, as next to an equilibrium, finer steps are not needed.
            following = step * (COARSER if longer else 1.0) * halved
            back = point.back._replace(time=errors.period)
            best = change[0], replace(point, back=back, step=step, following=following, errors=errors)
            if change[0] <= goal[0]:
                break
            u = point.u
            step = step / float(finer_by(change, goal, flow.scheme.order)[0])
        if best is None:
            return None
        point = best[1]
        own = self.own_scale(point.u, point.back, point.step)
        slow = own.energy[0] < VANISHED**2 * scale.energy[0]
        at_rest = self.at(point.u[-1], point.step).system.driven and slow  # a fixed point like any other
        if at_rest:
            return replace(point, scale=scale)
        return replace(point, scale=own, errors=_in_units(point.errors, scale, own))

    def own_scale(self, u: np.ndarray, back: Returns, step: float) -> Scale:
        """Return the own units of the closed orbit u = (z, value) with its return."""
        flow = self.at(u[-1], step)
        z = u[:-1, None]
        guessed = orbit_scale(flow.system, z, self.aim(u[-1]), flow.threads)
        return closed_scale(flow, z, back.points, back.time, guessed)

    def _closed(self, u: np.ndarray, tangent: np.ndarray | None, scale: Scale, step: float) -> Point | None:
        """Return the point that `corrected` seeks, with one step of the scheme."""
        rows = u.size - 1
        normal = np.eye(rows + 1)[rows] if tangent is None else tangent
        own = np.append(scale.rows[:, 0], self.units[-1])
        before = np.inf
        for k in range(CORRECTIONS):
            z, reached = onto(self.at(u[-1], step).system, self.section, u[:-1, None], self.aim(u[-1]), scale)
            if not reached[0]:
                return None
            u = np.append(z[:, 0], u[-1])
            back = self.returned(u, scale, step)
            if back.status[0] != Status.OK:
                return None
            short = (u[:-1] - back.points[0, -1]) / scale.rows[:, 0]
            size = float(np.linalg.norm(short))
            goal = float(closing_goal(self.tolerance, z, back.time / step, back.monodromy, scale)[0])
            matrix = self.matrix(u, back, scale, step)
            if not np.isfinite(matrix).all():
                return None
            border = np.insert(normal * own / self.units, rows, 0.0)
            if size <= goal or (size <= 30 * goal and size > 0.5 * before):
                along = _tangent(matrix, border) * own / self.units
                return Point(u, back, along / np.linalg.norm(along), scale, step, step, UNKNOWN, k)
            right = np.concatenate([short, [0.0, 0.0, 0.0]])
            change = least_change(np.vstack([matrix, border])[None], right[None])[0]
            u = np.append(u[:-1] + change[:rows] * own[:-1], u[-1] if tangent is None else u[-1] + change[-1] * own[-1])
            before = size
        return None

    def follows(self, last: Point, point: Point, length: float) -> bool:
        """Tell whether `point` is the next one of the branch after `last`, at a distance of about `length`."""
        return bool(point.tangent @ last.tangent > np.cos(BEND) and self.distance(last.u, point.u) < 1.5 * length)

    def ahead(self, last: Point, length: float) -> Point | None:
        """Return the point of the branch at a distance of `length` along the tangent of the last one."""
        return self.corrected(last.u + length * last.tangent * self.units, last.tangent, last.scale, last.following)

    def between(self, last: Point, following: Point, s: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the point at the share s of the cubic through two points with their tangents, and the unit vector
        along it.

        Nearer to the branch than the chord: at a branch point a correction cannot tell it from its neighbours.
        """
        reach = self.distance(last.u, following.u)
        first, end = (p.tangent * self.units * reach for p in (last, following))
        chord = following.u - last.u
        bend = 3 * chord - 2 * first - end
        twist = first + end - 2 * chord
        along = (first + s * (2 * bend + 3 * s * twist)) / self.units
        return last.u + s * (first + s * (bend + s * twist)), along / np.linalg.norm(along)

    def orbits(self, point: Point) -> PeriodicOrbits:
        """Return a point of the branch as PeriodicOrbits of one orbit."""
        residual = point.scale.norm(point.back.points[:, -1] - point.u[:-1])
        energy = self.aim(point.u[-1])
        count = np.array([point.corrections + 1])
        found = packed(
            self.at(point.u[-1], point.step),
            self.section,
            point.u[:-1, None],
            energy,
            point.back,
            point.scale,
            residual=residual,
            error=point.errors.orbit,
            reduced_monodromy_error=point.errors.reduced_monodromy,
            iterations=count,
        )
        return replace(found, section=self.asked)

    def amplitude(self, point: Point) -> np.ndarray | None:
        """Return half of the range of each variable (rows,) of a forced system over a period; None for other systems,
        whose families have an energy for that.
        """
        system = self.flow.system
        if system.iterated or not (system.driven or not system.canonical):
            return None
        time = float(point.back.time[0])
        flow = replace(self.at(point.u[-1], point.step), vectors=0).fitted(time, PLACES)
        states = flow.sampled(flow.ensemble(point.u[:-1, None].copy()), PLACES, time=time)[0]
        if system.driven:  # the time goes on, which is no motion
            states[:, system.moving] = 0.0
        curve = np.fft.irfft(np.fft.rfft(states, axis=0), FINER * PLACES, axis=0) * FINER
        return ((_highest(curve) + _highest(-curve)) / 2)[: system.rows]

    def products(self, point: Point) -> np.ndarray:
        """Return the products of the residues and of 1 - residue: they change sign at bifurcations."""
        return residue_products(self.orbits(point))[0]


def _in_units(errors: Errors, scale: Scale, own: Scale) -> Errors:
    """Return errors that are known in the units of `scale` in those of `own`, at most too large."""
    with np.errstate(all="ignore"):
        ratio = scale.rows / own.rows
        largest = ratio.max(axis=0)
        uneven = ratio.max(axis=0) / ratio.min(axis=0)
    return errors._replace(
        orbit=errors.orbit * np.maximum(largest, 1.0), reduced_monodromy=errors.reduced_monodromy * uneven
    )


def _highest(curve: np.ndarray) -> np.ndarray:
    """Return the tops (rows,) of closed curves (places, rows), of the parabola through the highest place and those
    beside it.
    """
    top = curve.argmax(axis=0)
    before, at, after = (curve[(top + k) % len(curve), np.arange(top.size)] for k in (-1, 0, 1))
    bend = 2 * at - before - after
    return at + np.where(bend > 0, (after - before) ** 2 / (8 * np.where(bend > 0, bend, 1.0)), 0.0)


def _tangent(matrix: np.ndarray, border: np.ndarray) -> np.ndarray:
    """Return the vector in (z, value) along which the equations hold, on the side of the bordering row."""
    change = least_change(np.vstack([matrix, border])[None], np.append(np.zeros(len(matrix)), 1.0)[None])[0]
    return np.delete(change, len(change) - 2)
