"""The boundary of the accessible part of a section of an energy surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import shown
from ..results.progress import says_progress
from ..results.result import Result, along
from ..runs.requirements import checked_system
from ..systems.formulas.section_text import section_forms, section_in_words, section_of
from ..systems.models.mechanics import System
from ..systems.models.sections import AlphaTurning, AngleEquals, BetaTurning, Hyperplane
from .allowed_region import LARGEST, Function, evaluated, extrema, highest, intervals, line, radii
from .energy_limits import NotReached, Where
from .named_axes import section_row
from .section_points import fixed_coordinate, radii_over
from .section_sides import Ellipses, Sides, sides_of_any
from .surface_points import surface_of

ENDLESS = 32
"""Number of bounded pieces of a section beyond which there is no end of them, as for a periodic potential."""

TURN = 256
"""Parts of a turn of an angle between which extrema are sought."""

USUAL = 0.9
"""Share of the length of a section whose momenta are usual."""

STEEP = 1e3
"""Ratio to the usual momenta from which momenta are those near a pole of the potential. They leave the usual ones less
of a range than can be seen or drawn from.
"""

LOOKS = 1000
"""Places at which the momenta are computed."""


@dataclass(frozen=True)
class Edge(Result, axis=None):
    """Boundary of the accessible part of a section.

    Attributes
    ----------
    coordinate : ndarray, shape (points,)
        Coordinate of the section.
    momentum : ndarray, shape (points,)
        Largest momentum beyond the centre.
    centre : float or ndarray, shape (points,)
        Momentum of rest in a rotating frame, shape (points,) for H(q, p), else 0.
    """

    coordinate: Annotated[np.ndarray, along("point")]
    momentum: Annotated[np.ndarray, along("point")]
    centre: Annotated[float | np.ndarray, along("point")] = 0.0

    @property
    def axes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ranges of the coordinate and of its momentum."""
        low = float((self.centre - self.momentum).min())
        high = float((self.centre + self.momentum).max())
        return (float(self.coordinate[0]), float(self.coordinate[-1])), (low, high)


class EdgePart(NamedTuple):
    """A bounded part of a section: ranges of the coordinate and of the momentum."""

    low: float
    high: float
    bottom: float
    top: float


@says_progress
@inserts_parameters
def edge(
    model: Any, section: Any, *, energy: float, p_eta: float = 0.0, p_gamma: float = 0.0, points: int = 800
) -> Edge:
    """Compute the boundary of the accessible part of a section, for axis ranges and figures.

    Parameters
    ----------
    {model}
    section : Section or str
        Surface of section, or a short form such as ``"x=0"``.
    energy : float
        Energy of the orbits.
    p_eta, p_gamma : float, default 0
        Angular momenta of the planes of a body.
    points : int, default 800
        Number of points of the boundary.

    Returns
    -------
    Edge
        The boundary. If the bounded part has several pieces, their boundaries follow one another. Unbounded valleys
        beside them are left out. On `AreaEquals` the direction excludes a little more on one side.

    Raises
    ------
    ValueError
        If the energy reaches no point, no piece is bounded, or momenta are not bounded, for example at a pole of the
        potential.
    TypeError
        If the section has no grid.

    Notes
    -----
    - The kinetic energy of the coordinate, p^2/(2 mu) = E - min V_effective, is positive inside.
    - Coordinates of all sizes are searched.

    Examples
    --------
    >>> edge = fa.plot.edge(fa.HenonHeiles(), "x=0", energy=1 / 8)
    >>> edge.momentum.max().round(4)
    np.float64(0.5)
    """
    system = checked_system(model, needs="an energy surface")
    section = section_of(section, model)
    where = Where(system, section, energy, p_eta, p_gamma)
    if not _of_ellipses(system) and not system.quadratic:
        return _edge_of(sides_of_any(where, max(2, points // 4)))
    parts = _bounded_parts(where)
    share = max(2, points // len(parts))
    # Dense at all ends, where the boundary is steep.
    dense = (1 - np.cos(np.linspace(0, np.pi, share))) / 2
    u = np.concatenate([part.low + (part.high - part.low) * dense for part in parts])
    if _of_ellipses(system):
        return _edge_of([Ellipses(where).sides(u)])
    value = evaluated(_rest(where), u, np.zeros(u.size, np.int64))[0]
    return Edge(u, np.sqrt(np.maximum(value, 0.0)), _centre(system, section))


def _nodes(system: System, section: Any) -> np.ndarray:
    """Return the coordinates between which the allowed ones are sought: one turn of an angle."""
    if system.isotropic:
        return radii()
    turns = [
        period
        for name, period in zip(system.names, system.periods)
        if isinstance(section, (Hyperplane, AngleEquals)) and name != section_row(system, section)[0]
    ]
    half = turns[0] / 2 if len(turns) == 1 else 0.0
    return np.linspace(-half, half, TURN + 1) if half > 0 else line()


def _of_ellipses(system: System) -> bool:
    """Tell whether ellipses of momenta differ from place to place."""
    return system.nonseparable and system.ellipsoidal


def _edge_of(pieces: list[Sides]) -> Edge:
    u, low, high = (np.concatenate(rows) for rows in zip(*pieces, strict=True))
    return Edge(u, (high - low) / 2, (low + high) / 2)


def parts(where: Where) -> list[EdgePart]:
    """Return the pieces of the section of any system."""
    system = where.system
    section = where.section
    if _of_ellipses(system) or system.quadratic:
        return _bounded_parts(where)
    box = surface_of(system, where.energy, section, None).box
    k = 2 - system.names.index(section_row(system, section)[0])
    return [EdgePart(*map(float, (box.low[0], box.high[0], box.low[k], box.high[k])))]


def _momenta_of(where: Where, rest: Function, low: float, high: float) -> tuple[float, float]:
    """Return the range of momenta on a piece of a section."""
    nodes = np.linspace(low, high, 65) if high > low else np.full(3, low)
    if _of_ellipses(where.system):
        found = Ellipses(where)

        def end(side: int) -> Function:
            return lambda u, _: (side * found.sides(u.ravel())[1 if side < 0 else 2].reshape(u.shape), 0.0 * u)

        bottom, top = (float(highest(end(side), 1, nodes)[0]) for side in (-1, 1))
        return -bottom, top
    centre = _centre(where.system, where.section)
    top = float(np.sqrt(max(0.0, extrema(rest, 1, nodes).f.max())))
    return centre - top, centre + top


def _usual(where: Where, rest: Function, part: EdgePart) -> EdgePart:
    """Return a piece of a section with the range of momenta that USUAL of its length needs."""
    u = part.low + (part.high - part.low) * (np.arange(LOOKS) + 0.5) / LOOKS
    if _of_ellipses(where.system):
        _, bottom, top = Ellipses(where).sides(u)
    else:
        centre = _centre(where.system, where.section)
        half = np.sqrt(np.maximum(evaluated(rest, u, np.zeros(u.size, np.int64))[0], 0.0))
        bottom = centre - half
        top = centre + half
    return EdgePart(part.low, part.high, float(np.quantile(bottom, 1 - USUAL)), float(np.quantile(top, USUAL)))


def _centre(system: System, section: Any) -> float:
    """Return the momentum about which the accessible part of a section is symmetric: that of rest."""
    if not isinstance(section, (Hyperplane, AngleEquals)) or not system.frame:
        return 0.0
    i = fixed_coordinate(section, system.model)
    q = np.zeros(2)
    q[i] = section.offset / section.normal[i]
    return float(system.at_rest(q)[1 - i])


def _bounded_parts(where: Where) -> list[EdgePart]:
    """Return the pieces of the section that the energy allows, without those that go to infinity."""
    system, section, energy = where[:3]
    rest = _rest(where)
    nodes = _nodes(system, section)
    found = intervals(rest, nodes)
    name = section_in_words(section, system)
    if abs(nodes[-1]) < LARGEST:  # of an angle
        found = [(max(low, float(nodes[0])), min(high, float(nodes[-1]))) for low, high in found]
    if not found:
        least = _least(where, rest, nodes)
        why = f"energy {energy:g} does not reach the section {name}: the least energy there is {least:.6g}"
        if not np.isfinite(least):
            others = [form for form in section_forms(system) if form[:-2] != name.partition("=")[0]]
            why = f"section {name} has no points of finite energy. Try {' or '.join(others[:8])}, with a number c."
        raise NotReached(where.too_low() or why)
    bounded = [ends for ends in found if np.isfinite(ends).all()]
    parts = []
    endless = len(bounded) > ENDLESS
    for low, high in [min(bounded, key=lambda ends: abs(ends[0] + ends[1]))] if endless else bounded:
        parts.append(EdgePart(low, high, *_momenta_of(where, rest, low, high)))
    if not parts or not all(np.isfinite([part.bottom, part.top]).all() for part in parts):
        if below := where.too_low():
            raise NotReached(below)
        why = where.may_escape() or f"energy {energy:g} does not bound the motion"
        raise ValueError(f"section {name} is unbounded: {why}. Pass the ranges of the axes.")
    usual = [_usual(where, rest, part) for part in parts]
    steep = any(part.top - part.bottom > STEEP * (near.top - near.bottom) for part, near in zip(parts, usual))
    if endless or steep:
        ends = np.array(usual if steep else parts)
        low, bottom = ends[:, [0, 2]].min(axis=0)
        high, top = ends[:, [1, 3]].max(axis=0)
        ranges = f"(({low:.6g}, {high:.6g}), ({bottom:.6g}, {top:.6g}))"
        if not endless:
            raise ValueError(
                f"section {name} is unbounded at energy {energy:g}, at a pole of the potential. Pass the ranges of the "
                f"axes, such as {ranges}."
            )
        q = next(name for name in system.names if name != section_row(system, section)[0])
        angle = "." if system.separable else f", or periodic={{'{q}': '2*pi'}} if {q} is an angle."
        raise ValueError(
            f"section {name} is unbounded at energy {energy:g}. Pass the ranges of the axes, such as {ranges}{angle}"
        )
    return parts


def _least(where: Where, rest: Function, nodes: np.ndarray) -> float:
    """Return the least energy on a section, above which momenta are allowed."""
    system = where.system
    left = float(highest(rest, 1, nodes)[0])
    if _of_ellipses(system):
        return where.energy - left
    mass = (
        system.model.mu
        if system.isotropic
        else 0.5 / _weight(system.model, fixed_coordinate(where.section, system.model))
    )
    return where.energy - left / (2 * mass)


def _weight(model: Any, i: int) -> float:
    """Return the least kinetic energy, over the i-th of two momenta, at which the other one is 1."""
    own, other = np.eye(2)[[i, 1 - i]]
    return float(model.kinetic_energy(*other) - model.velocity(*other)[i] ** 2 / (4 * model.kinetic_energy(*own)))


def _rest(where: Where) -> Function:
    """Return the largest squared momentum at a coordinate as a function of one column; infinite where the other radius
    is unbounded.
    """
    system, section, energy = where[:3]
    body = system.model
    linear = isinstance(section, (Hyperplane, AngleEquals))
    i = fixed_coordinate(section, body) if linear else 0
    if _of_ellipses(system) and body.degrees_of_freedom == 2:
        return Ellipses(where).room
    if linear and body.degrees_of_freedom == 2:
        at = section.offset / section.normal[i]
        weight = _weight(body, i)

        def left(u, _):
            q = np.array([at + 0 * u, u] if i == 0 else [u, at + 0 * u])
            V = np.where(body.margin(*q) > 0, system.least_energies(q), np.inf)
            return (energy - V) / weight, (abs(energy) + np.abs(V)) / weight

        return left
    if not system.isotropic:
        n = body.degrees_of_freedom
        raise TypeError(
            f"section {shown(section)} must be of a system of two degrees of freedom to have a boundary, got {n}. Use "
            "found.plot() for the points."
        )
    if isinstance(section, (AlphaTurning, BetaTurning)):
        return lambda u, _: _widest(where, u, alpha=isinstance(section, AlphaTurning))
    radii_over(section, np.zeros(0))  # or TypeError
    return lambda u, _: where.room(*radii_over(section, u))


def _widest(where: Where, u: np.ndarray, *, alpha: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest squared momentum at u over all values of the other radius, infinite where it has no bound; and
    its size.
    """
    flat = u.ravel()
    rest = where.radial(flat, alpha=alpha)
    far = evaluated(rest, np.full(flat.size, LARGEST), np.arange(flat.size))[0] > 0
    best = np.where(far, np.inf, highest(rest, flat.size, radii())).reshape(u.shape)
    return best, 2 * where.model.mu * abs(where.energy) + np.abs(best)
