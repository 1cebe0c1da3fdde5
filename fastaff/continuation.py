"""Families of periodic orbits followed in the energy or a parameter, with their bifurcations (layer L3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from .boundary import checked_section, checked_tangent_model, energies
from .engine import Flow
from .periodic import PeriodicOrbits, closing_matrix, packed, periodic_orbits, return_time
from .periodic_search import joined
from .recipe import recorded
from .returns import Returns, least_change, onto, section_returns
from .scalars import positive, real, whole
from .schemes import KAHAN_LI8, RungeKutta, Splitting
from .shown import screen
from .status import Status
from .trials import make_flow

CORRECTIONS = 10
EASY = 3
"""Corrections after which the next step along the branch is longer."""

BEND = 0.35
"""Largest angle, in radians, between neighbouring tangents of the branch."""

JUMP = 0.1
"""Largest change of the residues' product between neighbouring points, beside 1 + the product: a dip must not pass unseen."""


class Event(IntEnum):
    """What happens at a point of a branch where the stability changes.

    FOLD: the energy or parameter turns back, a residue passes 0; BRANCHING: a residue passes 0 without a turn (pitchfork,
    transcritical); DOUBLING: a residue passes 1, an orbit of twice the period branches off.
    """

    FOLD = 0
    BRANCHING = 1
    DOUBLING = 2


class Bifurcation(NamedTuple):
    """A point of a branch where its stability changes: the event, arclength, energy or parameter, z (2n,), period in time."""

    event: Event
    arclength: float
    value: float
    z: np.ndarray
    time: float

    def __repr__(self) -> str:
        return screen(self)


@dataclass(frozen=True)
class Branch:
    """A family of periodic orbits.

    value (points,): the energy or the parameter; arclength (points,) in the space of z and value; orbits: PeriodicOrbits with the
    points of the branch as orbits (z, time, residue, stability, ...); bifurcations in the order of the branch; status:
    OK where it ended by its number of steps or its bounds, NOT_CONVERGED where the shortest step failed.
    """

    value: np.ndarray
    arclength: np.ndarray
    orbits: PeriodicOrbits
    bifurcations: tuple[Bifurcation, ...]
    status: Status

    def __repr__(self) -> str:
        return screen(self)


@recorded
def continuation(
    model: Any, z0: Any, *, section: Any, period: int = 1, parameter: float | None = None, energy: float | None = None,
    bounds: tuple[float, float] = (-np.inf, np.inf), direction: int = 1, length: float = 0.01, longest: float = 0.1, steps: int = 100,
    max_time: float | None = None, tolerance: float = 1e-12, step: float | None = None,
    scheme: Splitting | RungeKutta = KAHAN_LI8, rtol: float = 1e-13, atol: float = 1e-13, threads: int | None = None,
) -> Branch:  # fmt: skip
    """Follow a family of periodic orbits in the energy, or in a parameter of the model at one energy, by pseudo-arclength.

    Parameters: model, or, with a parameter, a function that makes the model of a number, `lambda C: Body(Hyperelastic(C))`;
    z0 (2n,): a guess of the first orbit; section, period as in `periodic_orbits`; parameter: its first value, or None to follow
    the energy; energy: of the first orbit (None: that of the guess), kept where a parameter is followed; bounds of the
    energy or parameter, where the branch ends; direction: +1 or -1, which way the energy or parameter goes at first; length,
    longest: first and longest step of arclength in (z, value); steps: the most points beside the first; max_time, tolerance as in
    `periodic_orbits`; step, scheme, rtol, atol, threads as in `integrate`.
    Returns Branch. Raises ValueError or TypeError for wrong input, and where the first guess leads to no periodic orbit.

    Each point is predicted along the tangent and corrected by Gauss-Newton with the condition that the correction is normal to
    it, so that the branch passes folds. The step grows by half after an easy correction and is halved after a failed one, a bend
    of more than 0.35 radians or a change of the residue R of more than 0.1 (1 + |R|). Derivatives to the parameter are central
    differences of returns. Bifurcations are where the product of the residues, or of 1 - residue, changes its sign between two
    points, polished by Brent's method in the arclength. A residue that touches 0 or 1, or passes it twice between two points, is
    not seen. At a branching the branch goes straight on.
    Cost: about 3 returns of 2n + 1 vectors for each point (9 with a parameter), of one orbit at a time.
    Source: Keller 1977, in Applications of Bifurcation Theory (pseudo-arclength); Greene, MacKay, Vivaldi & Feigenbaum 1981,
    Physica D 3, 468 (residues at bifurcations).
    """
    make, first_model = _family(model, parameter)
    checked_section(section, checked_tangent_model(first_model, "model"))
    if not isinstance(direction, (int, float, np.number)) or direction not in (-1, 1):
        raise ValueError(f"direction must be +1 or -1, got {direction!r}")
    low, high = _bounds(bounds)
    longest = positive("longest", longest)
    length = min(positive("length", length), longest)
    steps, period = whole("steps", steps, 1), whole("period", period, 1)
    first = periodic_orbits(
        first_model, z0, section=section, period=period, energy=energy, max_time=max_time, tolerance=tolerance, step=step,
        scheme=scheme, rtol=rtol, atol=atol, threads=threads,
    )  # fmt: skip
    if first.status.size != 1 or first.status[0] != Status.OK:
        raise ValueError(f"z0 must be a guess (2n,) that leads to a periodic orbit, got {first.summary()}")
    value = float(first.energy[0]) if parameter is None else parameter
    if not low <= value <= high:
        raise ValueError(f"bounds must contain the first value {value!r}, got {bounds!r}")
    flow, _ = make_flow(first_model, first.z, first.scheme, first.step if np.isfinite(first.step) else 1.0, rtol, atol, threads)
    wait = return_time(flow, first.z, period) if max_time is None else positive("max_time", max_time)
    family = _Family(make, flow, section, period, wait, tolerance, None if parameter is None else float(first.energy[0]))
    start = family.corrected(np.append(first.z[:, 0], value), None)
    if start is None:
        raise ValueError("z0 leads to an orbit that cannot be continued")
    points, status = _follow(family, start, direction, length, longest, steps, (low, high))
    orbits = joined([family.orbits(p) for p in points])
    values = np.array([p.u[-1] for p in points])
    arclength = np.concatenate([[0.0], np.cumsum([np.linalg.norm(b.u - a.u) for a, b in pairwise(points)])])
    return Branch(values, arclength, orbits, tuple(_bifurcations(family, points, arclength, orbits)), status)


def _family(model: Any, parameter: float | None) -> tuple[Callable, Any]:
    """Return the function from the parameter to the model, and the first model."""
    if parameter is None:
        return (lambda _: model), model
    if not callable(model) or isinstance(model, tuple):
        raise TypeError(f"model must be a function that makes a model of the parameter, got {model!r} ({type(model).__name__})")
    return model, model(real("parameter", parameter))


def _bounds(bounds: Any) -> tuple[float, float]:
    try:
        low, high = map(float, bounds)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"bounds must be two numbers, got {bounds!r}") from None
    if not low < high:
        raise ValueError(f"bounds must be two increasing numbers, got {bounds!r}")
    return low, high


@dataclass(frozen=True)
class _Point:
    """A point u = (z, value) of a branch, its return, the branch's unit tangent there, and how many corrections it took."""

    u: np.ndarray
    back: Returns
    tangent: np.ndarray
    corrections: int

    def follows(self, last: _Point, length: float) -> bool:
        """Tell whether this is the next point of the branch after `last`, at a distance of about `length`."""
        return bool(self.tangent @ last.tangent > np.cos(BEND) and np.linalg.norm(self.u - last.u) < 1.5 * length)


@dataclass(frozen=True)
class _Family:
    """The equations of a family: the orbit closes, lies on the section, and has the energy `energy`, or its value where that is None."""

    make: Callable
    flow: Flow
    section: Any
    period: int
    max_time: float
    tolerance: float
    energy: float | None

    def at(self, value: float) -> Flow:
        """Return the flow at a value of the parameter."""
        return self.flow if self.energy is None else replace(self.flow, model=self.make(value))

    def aim(self, value: float) -> np.ndarray:
        """Return the energy (1,) that the orbit of a value must have."""
        return np.array([value if self.energy is None else self.energy])

    def returned(self, u: np.ndarray) -> Returns:
        """Return what becomes of the orbit u = (z, value)."""
        return section_returns(self.at(u[-1]), self.section, u[:-1, None], self.period, self.max_time)

    def matrix(self, u: np.ndarray, back: Returns) -> np.ndarray:
        """Return the derivative (2n + 2, 2n + 2) of the equations to z, time and value."""
        z, value = u[:-1, None], u[-1]
        model = self.at(value).model
        closing = closing_matrix(model, self.section, z, back.points[:, -1], back.monodromy)[0]
        rows = len(z)
        column = np.zeros(rows + 2)
        if self.energy is None:
            column[rows + 1] = -1.0
        else:
            h = 1e-5 * max(1.0, abs(value))
            ends = []
            for shifted in (value + h, value - h):
                there = self.returned(np.append(u[:-1], shifted))
                # At the return of u itself, not at that of the shifted model.
                ends.append(there.points[0, -1] - closing[:rows, rows] * (there.time[0] - back.time[0]))
            column[:rows] = (ends[0] - ends[1]) / (2 * h)
            up, down = (energies(self.make(value + s * h), z)[0] for s in (1, -1))
            column[rows + 1] = (up - down) / (2 * h)
        return np.column_stack([closing, column])

    def corrected(self, u: np.ndarray, tangent: np.ndarray | None) -> _Point | None:
        """Return the point of the branch normal to the tangent from u (at the value of u for None); None if there is none."""
        rows = u.size - 1
        normal = np.eye(rows + 1)[rows] if tangent is None else tangent
        before = np.inf
        for k in range(CORRECTIONS):
            z, reached = onto(self.at(u[-1]).model, self.section, u[:-1, None], self.aim(u[-1]))
            if not reached[0]:
                return None
            u = np.append(z[:, 0], u[-1])
            back = self.returned(u)
            if back.status[0] != Status.OK:
                return None
            short = u[:-1] - back.points[0, -1]
            size = float(np.linalg.norm(short))
            goal = self.tolerance * (1 + np.linalg.norm(u[:-1])) * max(1.0, float(np.linalg.norm(back.monodromy)))
            matrix = self.matrix(u, back)
            if not np.isfinite(matrix).all():
                return None
            border = np.insert(normal, rows, 0.0)
            if size <= goal or (size <= 30 * goal and size > 0.5 * before):
                return _Point(u, back, _tangent(matrix, border), k)
            right = np.concatenate([short, [0.0, 0.0, 0.0]])
            change = least_change(np.vstack([matrix, border])[None], right[None])[0]
            u = u + np.delete(change, rows)
            before = size
        return None

    def orbits(self, point: _Point) -> PeriodicOrbits:
        """Return a point of the branch as PeriodicOrbits of one orbit."""
        residual = np.linalg.norm(point.back.points[:, -1] - point.u[:-1], axis=1)
        energy, count = self.aim(point.u[-1]), np.array([point.corrections + 1])
        return packed(self.at(point.u[-1]), self.section, point.u[:-1, None], energy, point.back, residual, count)

    def products(self, point: _Point) -> np.ndarray:
        """Return the products of the residues and of 1 - residue: they change sign at bifurcations."""
        return _products(self.orbits(point))[0]


def _tangent(matrix: np.ndarray, border: np.ndarray) -> np.ndarray:
    """Return the unit vector in (z, value) along which the equations hold, on the side of the bordering row."""
    change = least_change(np.vstack([matrix, border])[None], np.append(np.zeros(len(matrix)), 1.0)[None])[0]
    along = np.delete(change, len(change) - 2)
    return along / np.linalg.norm(along)


def _products(orbits: PeriodicOrbits) -> np.ndarray:
    R = orbits.residues
    return np.array([np.prod(R, axis=0).real, np.prod(1 - R, axis=0).real]).T


def _follow(family, start, direction, length, longest, steps, bounds) -> tuple[list[_Point], Status]:
    """Step along the branch to its bounds, its number of steps, or the shortest step."""
    forward = start.tangent if start.tangent[-1] * direction >= 0 else -start.tangent
    points, signs = [replace(start, tangent=forward)], family.products(start)
    shortest = 1e-6 * length
    while len(points) <= steps:
        last = points[-1]
        point = family.corrected(last.u + length * last.tangent, last.tangent)
        ahead = family.products(point) if point is not None and point.follows(last, length) else np.full(2, np.nan)
        if not (np.abs(ahead - signs) <= JUMP * (1 + np.abs(signs))).all():
            length *= 0.5
            if length < shortest:
                return points, Status.NOT_CONVERGED
            continue
        if not bounds[0] <= point.u[-1] <= bounds[1]:
            edge = bounds[0] if point.u[-1] < bounds[0] else bounds[1]
            share = (edge - last.u[-1]) / (point.u[-1] - last.u[-1])
            end = family.corrected(np.append(((1 - share) * last.u + share * point.u)[:-1], edge), None)
            return [*points, end] if end is not None and share > 1e-9 else points, Status.OK
        points.append(point)
        signs = ahead
        if point.corrections <= EASY:
            length = min(1.5 * length, longest)
    return points, Status.OK


def _bifurcations(family: _Family, points: list[_Point], arclength: np.ndarray, orbits: PeriodicOrbits) -> list[Bifurcation]:
    """Find the sign changes between neighbouring points and polish them."""
    from scipy.optimize import brentq

    signs = _products(orbits)
    found = []
    for k in range(len(points) - 1):
        last, reach = points[k], float(np.linalg.norm(points[k + 1].u - points[k].u))
        turned = last.tangent[-1] * points[k + 1].tangent[-1] < 0
        for kind in range(2):
            if not signs[k, kind] * signs[k + 1, kind] < 0:
                continue
            ahead = (points[k + 1].u - last.u) / reach
            at: dict[float, _Point | None] = {}

            def product(s, last=last, ahead=ahead, kind=kind, at=at, ends=(k, reach)):
                if s in (0.0, ends[1]):
                    return signs[ends[0] + (s > 0.0), kind]
                at[s] = family.corrected(last.u + s * ahead, ahead)
                return np.nan if at[s] is None else family.products(at[s])[kind]

            s = brentq(product, 0.0, reach, xtol=1e-11, rtol=1e-12, disp=False)
            point = at.get(s) or family.corrected(last.u + s * ahead, ahead)
            if point is not None and abs(family.products(point)[kind]) < 1e-5:
                event = Event.DOUBLING if kind else Event.FOLD if turned else Event.BRANCHING
                found.append(Bifurcation(event, float(arclength[k] + s), float(point.u[-1]), point.u[:-1], float(point.back.time[0])))
    return sorted(found, key=lambda b: b.arclength)
