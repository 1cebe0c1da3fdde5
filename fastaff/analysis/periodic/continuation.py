"""Families of periodic orbits followed in the energy or a parameter, with their bifurcations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Any

import numpy as np

from ...base.axes import along
from ...base.interruption import keeping
from ...base.numbers import numbers, positive, real, shown, whole
from ...base.recipe import recorded
from ...base.results import Result
from ...base.short_forms import takes
from ...base.status import Status
from ...flows.flow import Flow
from ...flows.needs import check_needs
from ...flows.options import Options, plan
from ...formulas.section_text import section_of
from ...models.contracts import Model, Section
from ...models.mechanics import energies
from ...models.traits import traits_of
from ...schemes.catalogue import RungeKutta, Splitting, scheme_of
from .bifurcations import Bifurcation, bifurcations, residue_products
from .closing_errors import Errors, closing_errors
from .found_orbits import PeriodicOrbits, no_orbits, packed
from .own_units import Scale, orbit_scale
from .periodic_orbits import LONGER, WAIT, periodic_orbits
from .return_map import (
    Returns,
    checked_return,
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
EASY = 3
"""Corrections after which the next step along the branch is longer."""

BEND = 0.35
"""Largest angle, in radians, between neighbouring tangents of the branch."""

JUMP = 0.1
"""Largest change of the residues' product between neighbouring points, beside 1 + the product: a dip must not pass
unseen.
"""

SHORTEST = 1e-6
"""Least step along the branch, beside the first one."""

TRIES = 6
"""Steps of the scheme that are tried for a point of the branch."""

COARSER, SPARE = 1.25, 1e-2
"""How many times longer a step of the scheme becomes where its error is this small beside what it may be."""

UNMOVED = 1e-12
"""Change of a return, in amplitudes, that is rounding: the orbit stays where it is whatever the parameter is."""

STOPPED = Status.INTERRUPTED, "stopped by the user before its end"
"""Status and ending of a branch after Ctrl-C."""

UNKNOWN = Errors(*4 * (np.full(1, np.nan),))
"""Of a point that is not checked yet."""

VANISHED = 1e-3
"""Energy of the motion, beside the first orbit's, below which a branch that ends has come to an equilibrium."""


@dataclass(frozen=True)
class Branch(Result, axis="point"):
    """A family of periodic orbits.

    value (points,): the energy or the parameter; arclength (points,) in the space of z and value, both in the units of
    the first orbit; orbits: PeriodicOrbits with the points of the branch as orbits (z, time, residue, stability, ...);
    bifurcations in the order of the branch; status: OK where it ended by its number of steps or its bounds, ACTION_ZERO
    where the orbits shrink to an equilibrium, NOT_CONVERGED where the shortest step failed, INTERRUPTED after Ctrl-C;
    ending: which of these it was, in words.
    """

    value: Annotated[np.ndarray, along("point")]
    arclength: Annotated[np.ndarray, along("point")]
    orbits: Annotated[PeriodicOrbits, along("point")]
    bifurcations: tuple[Bifurcation, ...]
    status: Status
    ending: str

    def summary(self) -> str:
        """Say in one line how far the branch goes and why it ends there."""
        if not len(self.value):
            return self.ending
        count = f"{len(self.value)} points from {self.value[0]:.6g} to {self.value[-1]:.6g}"
        return f"{count}, {len(self.bifurcations)} bifurcations; {self.ending}"


@takes(section=section_of, scheme=scheme_of)
@recorded
def continuation(
    model: Model,
    z0: Any,
    *,
    section: Section | None = None,
    period: int = 1,
    parameter: float | None = None,
    energy: float | None = None,
    bounds: tuple[float, float] = (-np.inf, np.inf),
    direction: int = 1,
    length: float = 0.01,
    longest: float = 0.1,
    steps: int = 100,
    max_time: float | None = None,
    tolerance: float = 1e-12,
    step: float | None = None,
    scheme: Splitting | RungeKutta | None = None,
    rtol: float = 1e-13,
    atol: float = 1e-13,
    threads: int | None = None,
) -> Branch:
    """Follow a family of periodic orbits in the energy, or in a parameter of the model at one energy, by
    pseudo-arclength.

    Parameters: model, or, with a parameter, a function that makes the model of a number, `lambda C:
    Body(Hyperelastic(C))`; z0 (2n,): a guess of the first orbit; section, period as in `periodic_orbits`; parameter:
    its first value, or None to follow the energy; energy: of the first orbit (None: that of the guess), kept where a
    parameter is followed; bounds of the energy or parameter, where the branch ends; direction: +1 or -1, which way the
    energy or parameter goes at first; length, longest: first and longest step of arclength in (z, value), z in the
    first orbit's amplitudes (`PeriodicOrbits.scale`), the value in its kinetic energy, or in the change of the
    parameter that moves its return by an amplitude; steps: the most points beside the first; max_time, tolerance as in
    `periodic_orbits`; step, scheme, rtol, atol, threads as in `integrate`. Returns Branch. Raises ValueError or
    TypeError for wrong input, and where the first guess leads to no periodic orbit; Interrupted on Ctrl-C, with the
    branch until there in `.partial`, its bifurcations not looked for.

    Each point is predicted along the tangent and corrected by Gauss-Newton with the condition that the correction is
    normal to it, so that the branch passes folds. The step grows by half after an easy correction and is halved after a
    failed one, a bend of more than 0.35 radians or a change of the residue R of more than 0.1 (1 + |R|). Derivatives to
    the parameter are central differences of returns. The scheme's step, where none is given, is each point's own:
    shortened until that moves the return no more than the tolerance, and longer again where it may be. Bifurcations are
    where the product of the residues, or of 1 - residue, changes its sign between two points, polished in the arclength
    by false position (the Illinois rule). A residue that touches 0 or 1, or passes it twice between two points, is not
    seen. At a branching the branch goes straight on.
    Cost: about 3 returns of 2n + 1 vectors for each point (9 with a parameter), of one orbit at a time.
    Source: Keller 1977, in Applications of Bifurcation Theory (pseudo-arclength); Greene, MacKay, Vivaldi & Feigenbaum
    1981, Physica D 3, 468 (residues at bifurcations).
    """
    make, first_model = _family(model, parameter)
    section = section_of(section, first_model)
    scheme = checked_return(first_model, section, scheme)
    check_needs(first_model, "a residue")
    if parameter is None:
        check_needs(first_model, "a branch along the energy")
    if not isinstance(direction, (int, float, np.number)) or direction not in (-1, 1):
        raise ValueError(f"direction must be +1 or -1, got {direction!r}")
    low, high = _bounds(bounds)
    longest, tolerance = positive("longest", longest), positive("tolerance", tolerance)
    length = min(positive("length", length), longest)
    steps, period = whole("steps", steps, 1), whole("period", period, 1)
    none, (status, ending) = no_orbits(first_model, section, scheme), STOPPED
    empty = Branch(np.zeros(0), np.zeros(0), none, bifurcations=(), status=status, ending=ending)
    with keeping("continuation", lambda: empty):
        first = periodic_orbits(
            first_model,
            z0,
            section=section,
            period=period,
            energy=energy,
            max_time=max_time,
            tolerance=tolerance,
            step=step,
            scheme=scheme,
            rtol=rtol,
            atol=atol,
            threads=threads,
        )
        if first.status.size != 1 or first.status[0] != Status.OK:
            raise ValueError(f"z0 must be a guess (2n,) that leads to a periodic orbit, got {first.summary()}")
        value = float(first.energy[0]) if parameter is None else parameter
        if not low <= value <= high:
            raise ValueError(f"bounds must contain the first value {value!r}, got {bounds!r}")
        given = not np.isinf(first.step[0]) and section is not None
        taken = float(first.step[0]) if given else None
        flow = plan(first_model, first.z, Options(first.scheme, taken, rtol=rtol, atol=atol, threads=threads)).flow
        limit = None if max_time is None else positive("max_time", max_time)
        own = step is None and flow.fixed
        scale = orbit_scale(first_model, first.z, first.energy, flow.threads)
        units = np.append(scale.rows[:, 0], scale.energy[0])
        kept = None if parameter is None else float(first.energy[0])
        wait = LONGER * first.time[0]
        family = _Family(make, flow, section, period, limit, tolerance, kept, own, units=units, wait=wait)
        if parameter is not None:
            units[-1] = family.parameter_unit(np.append(first.z[:, 0], value), scale)
        start = family.corrected(np.append(first.z[:, 0], value), None, scale, first.step[0])
        if start is None:
            raise ValueError("z0 leads to an orbit that cannot be continued")
    points = [_turned(start, direction)]
    with keeping("continuation", lambda: _branch(family, points, *STOPPED)):
        branch = _branch(family, points, *_follow(family, points, length, longest, steps, (low, high)))
        return replace(branch, bifurcations=tuple(bifurcations(family, points, branch.arclength, branch.orbits)))


def _branch(family: _Family, points: list[_Point], status: Status, ending: str) -> Branch:
    """Return the branch of the points found so far, without its bifurcations."""
    orbits = PeriodicOrbits.concat([family.orbits(p) for p in points])
    values = np.array([p.u[-1] for p in points])
    arclength = np.concatenate([[0.0], np.cumsum([family.apart(a.u, b.u) for a, b in pairwise(points)])])
    return Branch(value=values, arclength=arclength, orbits=orbits, bifurcations=(), status=status, ending=ending)


def _turned(start: _Point, direction: int) -> _Point:
    """Return the first point with its tangent the way that the energy or parameter goes at first."""
    forward = start.tangent if start.tangent[-1] * direction >= 0 else -start.tangent
    return replace(start, tangent=forward)


def _family(model: Any, parameter: float | None) -> tuple[Callable, Any]:
    """Return the function from the parameter to the model, and the first model."""
    if parameter is None:
        return (lambda _: model), model
    if not callable(model) or isinstance(model, tuple):
        raise TypeError(
            f"model must be a function that makes a model of the parameter, got {model!r} ({type(model).__name__})"
        )
    return model, model(real("parameter", parameter))


def _bounds(bounds: Any) -> tuple[float, float]:
    given = numbers("bounds", bounds)
    if given.shape != (2,) or not given[0] < given[1]:
        raise ValueError(f"bounds must be two increasing numbers, got {shown(bounds)}")
    return float(given[0]), float(given[1])


@dataclass(frozen=True)
class _Point:
    """A point u = (z, value) of a branch, its return, the branch's unit tangent there (in units of the branch), its own
    units, step of the scheme and the next one to try, errors, and how many corrections it took."""

    u: np.ndarray
    back: Returns
    tangent: np.ndarray
    scale: Scale
    step: float
    following: float
    errors: Errors
    corrections: int


@dataclass(frozen=True)
class _Family:
    """The equations of a family: flow(z) = z on the section and the energy, for z and the energy or parameter.

    energy: None where it is the value itself; own_step: whether the scheme's step may change; units (2n + 1,) of z and
    value; wait: time to wait for a return at least, where none is given.
    """

    make: Callable
    flow: Flow
    section: Any
    period: int
    max_time: float | None
    tolerance: float
    energy: float | None
    own_step: bool
    units: np.ndarray
    wait: float

    def at(self, value: float, step: float) -> Flow:
        """Return the flow at a value of the parameter."""
        flow = self.flow if self.flow.adaptive else replace(self.flow, step=step)
        return flow if self.energy is None else replace(flow, model=self.make(value))

    def aim(self, value: float) -> np.ndarray:
        """Return the energy (1,) that the orbit of a value must have."""
        return np.array([value if self.energy is None else self.energy])

    def apart(self, u: np.ndarray, v: np.ndarray) -> float:
        """Return the distance of two points of the branch."""
        return float(np.linalg.norm((v - u) / self.units))

    def limit(self, scale: Scale) -> np.ndarray:
        """Return the time to wait for a return."""
        if self.max_time is not None:
            return np.array([self.max_time])
        return np.maximum(WAIT * self.period / scale.rate, self.wait)

    def returned(self, u: np.ndarray, scale: Scale, step: float) -> Returns:
        """Return what becomes of the orbit u = (z, value)."""
        return section_returns(self.at(u[-1], step), self.section, u[:-1, None], self.period, self.limit(scale))

    def shifted(self, u: np.ndarray, back: Returns, scale: Scale, step: float, h: float) -> np.ndarray:
        """Return the derivative (2n,) of the return to the parameter in own units, at the time of the return of u."""
        end, ends = back.points[0, -1], []
        field = vector_field(self.at(u[-1], step).model, end[:, None])[0]
        for value in (u[-1] + h, u[-1] - h):
            there = self.returned(np.append(u[:-1], value), scale, step)
            ends.append(there.points[0, -1] - field * (there.time[0] - back.time[0]))
        return (ends[0] - ends[1]) / (2 * h) / scale.rows[:, 0]

    def parameter_unit(self, u: np.ndarray, scale: Scale) -> float:
        """Return the change of the parameter that moves the return by an amplitude, beside what it does to small
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
        z, unit = u[:-1, None], self.units[-1]
        model = self.at(u[-1], step).model
        closing = closing_matrix(model, self.section, z, back.points[:, -1], back.monodromy, scale)[0]
        rows = len(z)
        column = np.zeros(rows + 2)
        if self.section is None:  # of a map, which has no energy
            column[:rows] = unit * self.shifted(u, back, scale, step, 1e-5 * unit)
            return np.column_stack([closing, column])
        length = np.linalg.norm(energy_gradient(model, z)[0] * scale.rows[:, 0])
        if self.energy is None:
            column[rows + 1] = -unit / length
        else:
            h = 1e-5 * unit
            column[:rows] = unit * self.shifted(u, back, scale, step, h)
            up, down = (energies(self.make(u[-1] + s * h), z)[0] for s in (1, -1))
            column[rows + 1] = unit * (up - down) / (2 * h) / length
        return np.column_stack([closing, column])

    def corrected(self, u: np.ndarray, tangent: np.ndarray | None, scale: Scale, step: float) -> _Point | None:
        """Return the point of the branch normal to the tangent from u (at the value of u for None); None if there is
        none.

        Where the scheme's step may change it is shortened until its error is below the tolerance.
        """
        best = None
        for _ in range(TRIES if self.own_step else 1):
            point = self._closed(u, tangent, scale, step)
            if point is None:
                step /= 2.0
                continue
            z = point.u[:-1, None]
            flow = self.at(point.u[-1], step)
            errors = closing_errors(flow, self.section, z, self.limit(scale), point.back, scale)
            change, steps = errors.change, point.back.time / flow.step
            goal = step_goal(self.tolerance, z, steps, point.back.monodromy, scale)
            if best is not None and change[0] > 0.5 * best[0]:
                break  # rounding
            # At rest no step would show an error of the return, but its derivative has one.
            longer = self.own_step and change[0] < SPARE * goal[0] and not flow.traits.driven
            following = step * COARSER if longer else step
            back = point.back._replace(time=errors.time)
            best = change[0], replace(point, back=back, step=step, following=following, errors=errors)
            if change[0] <= goal[0]:
                break
            u, step = point.u, step / float(finer_by(change, goal, flow.scheme.order)[0])
        if best is None:
            return None
        point = best[1]
        model = self.at(point.u[-1], point.step).model
        own = orbit_scale(model, point.u[:-1, None], self.aim(point.u[-1]), self.flow.threads)
        slow = own.energy[0] < VANISHED**2 * scale.energy[0]
        at_rest = traits_of(model).driven and slow  # a fixed point like any other
        return replace(point, scale=scale if at_rest else own)

    def _closed(self, u: np.ndarray, tangent: np.ndarray | None, scale: Scale, step: float) -> _Point | None:
        """Return the point that `corrected` looks for, of one step of the scheme."""
        rows = u.size - 1
        normal = np.eye(rows + 1)[rows] if tangent is None else tangent
        own = np.append(scale.rows[:, 0], self.units[-1])
        before = np.inf
        for k in range(CORRECTIONS):
            z, reached = onto(self.at(u[-1], step).model, self.section, u[:-1, None], self.aim(u[-1]), scale)
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
                return _Point(u, back, along / np.linalg.norm(along), scale, step, step, UNKNOWN, k)
            right = np.concatenate([short, [0.0, 0.0, 0.0]])
            change = least_change(np.vstack([matrix, border])[None], right[None])[0]
            u = np.append(u[:-1] + change[:rows] * own[:-1], u[-1] if tangent is None else u[-1] + change[-1] * own[-1])
            before = size
        return None

    def follows(self, last: _Point, point: _Point, length: float) -> bool:
        """Tell whether `point` is the next one of the branch after `last`, at a distance of about `length`."""
        return bool(point.tangent @ last.tangent > np.cos(BEND) and self.apart(last.u, point.u) < 1.5 * length)

    def ahead(self, last: _Point, length: float) -> _Point | None:
        """Return the point of the branch at a distance of `length` along the tangent of the last one."""
        return self.corrected(last.u + length * last.tangent * self.units, last.tangent, last.scale, last.following)

    def between(self, last: _Point, following: _Point, s: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the point at the share s of the cubic through two points with their tangents, and the unit vector
        along it.

        Nearer to the branch than the chord: at a branching a correction cannot tell it from its neighbours.
        """
        reach = self.apart(last.u, following.u)
        first, end = (p.tangent * self.units * reach for p in (last, following))
        chord = following.u - last.u
        bend, twist = 3 * chord - 2 * first - end, first + end - 2 * chord
        along = (first + s * (2 * bend + 3 * s * twist)) / self.units
        return last.u + s * (first + s * (bend + s * twist)), along / np.linalg.norm(along)

    def orbits(self, point: _Point) -> PeriodicOrbits:
        """Return a point of the branch as PeriodicOrbits of one orbit."""
        residual = point.scale.norm(point.back.points[:, -1] - point.u[:-1])
        energy, count = self.aim(point.u[-1]), np.array([point.corrections + 1])
        return packed(
            self.at(point.u[-1], point.step),
            self.section,
            point.u[:-1, None],
            energy,
            point.back,
            point.scale,
            residual=residual,
            error=point.errors.orbit,
            reduced_error=point.errors.reduced,
            iterations=count,
        )

    def products(self, point: _Point) -> np.ndarray:
        """Return the products of the residues and of 1 - residue: they change sign at bifurcations."""
        return residue_products(self.orbits(point))[0]


def _tangent(matrix: np.ndarray, border: np.ndarray) -> np.ndarray:
    """Return the vector in (z, value) along which the equations hold, on the side of the bordering row."""
    change = least_change(np.vstack([matrix, border])[None], np.append(np.zeros(len(matrix)), 1.0)[None])[0]
    return np.delete(change, len(change) - 2)


def _follow(family, points: list[_Point], length, longest, steps, bounds) -> tuple[Status, str]:
    """Step along the branch from its first point to its bounds, its number of steps, or the shortest step; add to the
    points. Return the status and the reason for the end in words.
    """
    start, signs = points[0], family.products(points[0])
    shortest = SHORTEST * length
    while len(points) <= steps:
        last = points[-1]
        point = family.ahead(last, length)
        ahead = (
            family.products(point) if point is not None and family.follows(last, point, length) else np.full(2, np.nan)
        )
        if not (np.abs(ahead - signs) <= JUMP * (1 + np.abs(signs))).all():
            length *= 0.5
            if length < shortest:
                if last.scale.energy[0] < VANISHED * start.scale.energy[0]:
                    return Status.ACTION_ZERO, "ended where the orbits shrink to an equilibrium"
                return Status.NOT_CONVERGED, f"ended where steps down to {length:.1e} found no further orbit"
            continue
        if not bounds[0] <= point.u[-1] <= bounds[1]:
            edge = bounds[0] if point.u[-1] < bounds[0] else bounds[1]
            share = (edge - last.u[-1]) / (point.u[-1] - last.u[-1])
            between = np.append(((1 - share) * last.u + share * point.u)[:-1], edge)
            end = family.corrected(between, None, last.scale, last.following)
            if end is None and share > 1e-9:
                return Status.NOT_CONVERGED, f"ended next to the bound {edge:.6g}, where no orbit was found"
            if end is not None and share > 1e-9:
                points.append(end)
            return Status.OK, f"ended at the bound {edge:.6g}"
        points.append(point)
        signs = ahead
        if point.corrections <= EASY:
            length = min(1.5 * length, longest)
    return Status.OK, f"ended after its {steps} steps: more, or longer ones, go on"
