"""The accessible part of a section of an energy surface: its boundary, and random points spread evenly over it (layer L3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .grid import NotReached, checked_surface, lift, planes
from .models import Body
from .scalars import whole
from .sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Linear


class Edge(NamedTuple):
    """The boundary of the accessible part of a section: coordinate (points,) and the largest momentum there."""

    coordinate: np.ndarray
    momentum: np.ndarray

    @property
    def axes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The ranges of the coordinate and of its momentum."""
        top = float(self.momentum.max())
        return (float(self.coordinate[0]), float(self.coordinate[-1])), (-top, top)


@dataclass(frozen=True)
class Sample:
    """Random points on a section of an energy surface.

    z0 (2n, orbits); points (2, orbits): the section's coordinate and its momentum, of the names given; energy.
    """

    z0: np.ndarray
    points: np.ndarray
    names: tuple[str, str]
    energy: float


def energy_sample(
    body: Any, *, energy: float, section: Any, orbits: int, seed: Any = 0, p_eta: float = 0.0, p_gamma: float = 0.0, axes: Any = None
) -> Sample:
    """Draw random points of a section of an energy surface, uniform in the measure that the section's return map keeps.

    Parameters: energy, section, p_eta, p_gamma: as in `energy_grid`; orbits: how many; seed: of `numpy.random.default_rng`; axes: ranges
    (low, high) of the coordinate and of its momentum to draw from (default: all that the energy allows, by `edge`).
    Returns Sample: on AlphaTurning and AlphaEquals over (beta, p_beta), on BetaTurning and BetaEquals over (alpha, p_alpha), on AreaEquals
    over beta and its momentum along the section, p_beta + (beta/alpha) p_alpha, on Linear over (q_j, p_j).
    Raises NotReached, a ValueError, where the energy reaches nothing, ValueError where `edge` finds no bounds and axes is missing.

    The area dq dp of the section in canonical coordinates is what the return map keeps, so that the chaotic share of these points is
    that of the section's area. It is not the share of the energy surface's volume: there each point counts with its time of
    return. Sections of direction 0 are drawn from one sheet, as in `energy_grid`. Cost: that of `energy_grid` for about 1.5
    times the points. Source: Poincare's integral invariant (Lichtenberg & Lieberman 1992, Regular and Chaotic Dynamics, section 1.2b).
    """
    energy, p_eta, p_gamma = checked_surface(body, section, energy, p_eta, p_gamma)
    count = whole("orbits", orbits, 1)
    if axes is None:
        axes = edge(body, section, energy=energy, p_eta=p_eta, p_gamma=p_gamma).axes
    (u0, u1), (v0, v1) = axes
    if isinstance(section, AreaEquals):  # |P| is below |p| times the length of the section over that of beta
        steepest = np.sqrt(1 + np.max(np.square([u0, u1]) / (2 * section.constant + np.square([u0, u1]))))
        v0, v1 = steepest * v0, steepest * v1
    raise_section = _area_lift if isinstance(section, AreaEquals) else lift
    random = np.random.default_rng(seed)
    parts: list[tuple[np.ndarray, np.ndarray]] = []
    names, kept, tried, batch = ("", ""), 0, 0, max(64, count)
    while kept < count:
        u, v = random.uniform(u0, u1, batch), random.uniform(v0, v1, batch)
        z, found, names = raise_section(body, section, energy, p_eta, p_gamma, u, v)
        parts.append((z[:, found], np.array([u[found], v[found]])))
        kept, tried = kept + int(found.sum()), tried + batch
        batch = min(2 * batch, max(8192, count))
        if tried > 1000 * (kept + 16):
            raise NotReached(f"energy {energy} reaches less than a thousandth of the ranges {axes!r} on {section!r}: narrow them")
    z0, points = (np.concatenate(part, axis=1)[:, :count] for part in zip(*parts, strict=True))
    return Sample(np.ascontiguousarray(z0), np.ascontiguousarray(points), names, energy)


def _area_lift(
    body: Any, section: Any, energy: float, p_eta: float, p_gamma: float, u: np.ndarray, P: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Lift (beta, P) to an area section: P/sqrt(1 + (beta/alpha)^2) is the momentum along it, the energy gives the one across."""
    alpha = np.sqrt(2 * section.constant + u * u)
    room, _ = _room(body, section, energy, p_eta, p_gamma)
    length = np.hypot(alpha, u)
    with np.errstate(all="ignore"):
        along = P * alpha / length
        rest = room(u) - along**2
        across = (-1.0 if section.direction < 0 else 1.0) * np.sqrt(np.maximum(rest, 0.0))
        found = (rest >= 0) & np.isfinite(rest)
        p_alpha, p_beta = (across * alpha + along * u) / length, (along * alpha - across * u) / length
        z = planes(alpha, p_alpha, p_eta, u, p_beta, p_gamma)
    return z, found & np.isfinite(z).all(axis=0), ("beta", "P")


def edge(body: Any, section: Any, *, energy: float, p_eta: float = 0.0, p_gamma: float = 0.0, points: int = 800) -> Edge:
    """Return the boundary of the accessible part of a section of an energy surface, for axis ranges and for drawing.

    Parameters as in `energy_grid`. Returns Edge; where the part falls apart, the outermost ends; on AreaEquals the direction forbids a
    little more on one side. Raises ValueError where the
    energy reaches nothing or the part is not bounded, TypeError for a section without a grid.
    Source: the kinetic energy of the coordinate, p^2/(2 mu) = E - min V_effective, has to be positive.
    """
    rest, radius = _room(body, section, energy, p_eta, p_gamma)
    span = radius * np.linspace(-1.0, 1.0, 4001) if not isinstance(body, Body) else np.geomspace(1e-4, radius, 2000)
    with np.errstate(all="ignore"):
        inside = np.flatnonzero(rest(span) > 0)
        if inside.size == 0:
            raise NotReached(f"energy {energy} does not reach {section!r}: it is below the minimum there")
        if not isinstance(body, Body):  # the well around the origin, not the valleys beyond the passes
            middle = inside[np.argmin(np.abs(span[inside]))]
            gaps = np.flatnonzero(~(rest(span) > 0))
            inside = np.arange(max(gaps[gaps < middle], default=-1) + 1, min(gaps[gaps > middle], default=span.size))
        if inside[-1] == span.size - 1:
            raise ValueError(f"energy {energy} does not bound the motion on {section!r}: give the ranges of the axes")
        low, high = (_zero(rest, span, k) for k in (inside[0], inside[-1] + 1))
        # Dense at both ends, where the boundary is steep.
        u = low + (high - low) * (1 - np.cos(np.linspace(0, np.pi, points))) / 2
        return Edge(u, np.sqrt(np.maximum(np.nan_to_num(rest(u)), 0.0)))


def _room(body: Any, section: Any, energy: float, p_eta: float, p_gamma: float) -> tuple[Any, float]:
    """Return the largest squared momentum at a coordinate, as a function, and how far to look."""
    if isinstance(section, Linear) and body.degrees_of_freedom == 2:
        i = int(np.flatnonzero(section.normal)[0])
        at = section.offset / section.normal[i]

        def left(u):
            q = (at + 0 * u, u) if i == 0 else (u, at + 0 * u)
            return (energy - body.potential_energy(*q)) / body.kinetic_energy(*np.eye(2)[1 - i])

        return left, 16.0
    if not isinstance(body, Body):
        raise TypeError(f"section {section!r} has no known boundary for {type(body).__name__}")

    def room(alpha, beta):
        A, B = alpha * alpha, beta * beta
        barrier = (p_eta / alpha) ** 2 if p_eta else 0.0
        barrier = barrier + ((p_gamma / beta) ** 2 if p_gamma else 0.0)
        left = 2 * body.mu * (energy - body.potential.value(A, B)) - barrier
        return np.where(body.potential.margin(A, B) > 0, left, -np.inf)

    other = np.geomspace(1e-3, 64.0, 3000)[:, None]
    if isinstance(section, AlphaTurning):
        return lambda u: np.nanmax(room(other, u), axis=0), 64.0
    if isinstance(section, BetaTurning):
        return lambda u: np.nanmax(room(u, other), axis=0), 64.0
    if isinstance(section, AlphaEquals):
        return lambda u: room(np.full_like(u, section.constant), u), 64.0
    if isinstance(section, BetaEquals):
        return lambda u: room(u, np.full_like(u, section.constant)), 64.0
    if isinstance(section, AreaEquals):
        return lambda u: room(np.sqrt(2 * section.constant + u * u), u), 64.0
    raise TypeError(f"section {section!r} has no known boundary")


def _zero(rest: Any, span: np.ndarray, k: int) -> float:
    """Return the allowed end of the sign change of rest between span[k - 1] and span[k]."""
    if k == 0:
        return float(span[0])
    low, high = span[k - 1], span[k]
    rising = rest(np.array([high]))[0] > 0
    for _ in range(50):
        middle = 0.5 * (low + high)
        allowed = rest(np.array([middle]))[0] > 0
        low, high = (low, middle) if allowed == rising else (middle, high)
    return float(high if rising else low)
