"""The boundary of the accessible part of a section of an energy surface: the least and the largest momentum over the
other coordinate. For a section q_i = c of H(q, p) both are taken at the p_i of the least energy there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import entries, shown, span
from ..results.progress import says_progress
from ..results.result import Result, along
from ..runs.requirements import checked_system
from ..systems.formulas.section_text import section_forms, section_in_words, section_of
from ..systems.models.sections import AlphaTurning, AngleEquals, BetaTurning, Hyperplane
from .allowed_region import LARGEST, Function, evaluated, extrema, highest, intervals, line, radii
from .energy_shell import EnergyShell, Momenta, NotReached
from .invariant_measure import LineMeasure
from .section_points import radii_over

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

STEEPEST = 65
"""Places of a section at which its slope is computed."""

ACROSS = 128
"""Parts of the range of a coordinate in which an H of any kind is sampled."""

ALONG = 64
"""Parts of the range of a momentum in which an H of any kind is sampled."""

HALVINGS = 48
"""Halvings for the ends of these ranges."""


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


Box = tuple[tuple[float, float], tuple[float, float]]
"""Ranges of a coordinate and of its momentum."""


class EdgePart(NamedTuple):
    """A bounded part of a section: ranges of the coordinate and of the momentum."""

    low: float
    high: float
    bottom: float
    top: float


class Sides(NamedTuple):
    """Coordinates (points,), and the least and the largest momentum over each."""

    coordinate: np.ndarray
    low: np.ndarray
    high: np.ndarray


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
    shell = EnergyShell(system, energy, section, p_eta, p_gamma)
    if not system.ellipsoidal:
        u, low, high = (np.concatenate(rows) for rows in zip(*sides_of_any(shell, max(2, points // 4)), strict=True))
        return Edge(u, (high - low) / 2, (low + high) / 2)
    slices = _slices_of(shell)
    parts = _bounded_parts(shell, slices)
    share = max(2, points // len(parts))
    # Dense at all ends, where the boundary is steep.
    dense = (1 - np.cos(np.linspace(0, np.pi, share))) / 2
    u = np.concatenate([part.low + (part.high - part.low) * dense for part in parts])
    reach, centre = slices.ends(u)
    return Edge(u, reach, centre)


def edge_parts(shell: EnergyShell) -> list[EdgePart]:
    """Return the pieces of the section of any system."""
    if shell.system.ellipsoidal:
        return _bounded_parts(shell, _slices_of(shell))
    box = LineMeasure.of(shell, {}).box
    k = 2 - shell.section_coordinate()[0]
    return [EdgePart(*map(float, (box.low[0], box.high[0], box.low[k], box.high[k])))]


def _bounded_parts(shell: EnergyShell, slices: Slices) -> list[EdgePart]:
    """Return the pieces of the section that the energy allows, without those that go to infinity."""
    system, energy, section = shell[:3]
    nodes = _nodes(shell)
    found = intervals(slices.room, nodes)
    name = section_in_words(section, system)
    if abs(nodes[-1]) < LARGEST:  # of an angle
        found = [(max(low, float(nodes[0])), min(high, float(nodes[-1]))) for low, high in found]
    if not found:
        least = slices.least(nodes)
        why = f"energy {energy:g} does not reach the section {name}: the least energy there is {least:.6g}"
        if not np.isfinite(least):
            others = [form for form in section_forms(system) if form[:-2] != name.partition("=")[0]]
            why = f"section {name} has no points of finite energy. Try {' or '.join(others[:8])}, with a number c."
        raise NotReached(shell.too_low() or why)
    bounded = [ends for ends in found if np.isfinite(ends).all()]
    parts = []
    endless = len(bounded) > ENDLESS
    for low, high in [min(bounded, key=lambda ends: abs(ends[0] + ends[1]))] if endless else bounded:
        parts.append(EdgePart(low, high, *slices.span(low, high)))
    if not parts or not all(np.isfinite([part.bottom, part.top]).all() for part in parts):
        if below := shell.too_low():
            raise NotReached(below)
        why = shell.may_escape() or f"energy {energy:g} does not bound the motion"
        raise ValueError(f"section {name} is unbounded: {why}. Pass the ranges of the axes.")
    usual = [_usual(slices, part) for part in parts]
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
        q = next(name for name in system.names if name != shell.section_row()[0])
        angle = "." if system.separable else f", or periodic={{'{q}': '2*pi'}} if {q} is an angle."
        raise ValueError(
            f"section {name} is unbounded at energy {energy:g}. Pass the ranges of the axes, such as {ranges}{angle}"
        )
    return parts


def _nodes(shell: EnergyShell) -> np.ndarray:
    """Return the coordinates between which the allowed ones are sought: one turn of an angle."""
    system = shell.system
    if system.isotropic:
        return radii()
    turns = [
        period
        for name, period in zip(system.names, system.periods)
        if isinstance(shell.section, (Hyperplane, AngleEquals)) and name != shell.section_row()[0]
    ]
    half = turns[0] / 2 if len(turns) == 1 else 0.0
    return np.linspace(-half, half, TURN + 1) if half > 0 else line()


def _usual(slices: Slices, part: EdgePart) -> EdgePart:
    """Return a piece of a section with the range of momenta that USUAL of its length needs."""
    u = part.low + (part.high - part.low) * (np.arange(LOOKS) + 0.5) / LOOKS
    half, centre = slices.ends(u)
    bottom, top = centre - half, centre + half
    return EdgePart(part.low, part.high, float(np.quantile(bottom, 1 - USUAL)), float(np.quantile(top, USUAL)))


def ranges_to_draw(shell: EnergyShell, axes: Any = None) -> list[Box]:
    """Return the ranges of coordinate and momentum to draw from: those given, or of each bounded part of the
    section.
    """
    if axes is None:
        boxes = [((part.low, part.high), (part.bottom, part.top)) for part in edge_parts(shell)]
    else:
        ranges = entries("axes", axes, "two ranges (low, high)", 2)
        (u0, u1), (v0, v1) = (span(f"axes[{k}]", ends) for k, ends in enumerate(ranges))
        boxes = [((u0, u1), (v0, v1))]
    section = shell.section
    if hasattr(section, "slopes"):  # |P| is below |p| times the length of the section over that of its radius
        boxes = [
            ((u0, u1), (_steepest(section, u0, u1) * v0, _steepest(section, u0, u1) * v1))
            for (u0, u1), (v0, v1) in boxes
        ]
    return boxes


def _steepest(section: Any, u0: float, u1: float) -> float:
    """Return the largest ratio of the lengths along the section and along its radius between two values of that."""
    with np.errstate(all="ignore"):
        return float(np.sqrt(1 + np.nanmax(section.leaning(np.linspace(u0, u1, STEEPEST)))))


# --- sections whose momenta fill an ellipse over each place ----------------------------------------------------------


class EqualEllipses:
    """Momenta of T(p) + V(q): their square about one centre has a bound over each coordinate."""

    def __init__(self, shell: EnergyShell):
        self.shell = shell
        self.room = _rest(shell)
        self.centre = _centre(shell)

    def ends(self, u: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the reach of the momentum to each side at coordinates (points,), and its centre."""
        value = evaluated(self.room, u, np.zeros(u.size, np.int64))[0]
        return np.sqrt(np.maximum(value, 0.0)), self.centre

    def span(self, low: float, high: float) -> tuple[float, float]:
        """Return the range of momenta between two coordinates."""
        top = float(np.sqrt(max(0.0, extrema(self.room, 1, _between(low, high)).f.max())))
        return self.centre - top, self.centre + top

    def least(self, nodes: np.ndarray) -> float:
        """Return the least energy on the section, above which momenta are allowed."""
        system, energy = self.shell[:2]
        left = float(highest(self.room, 1, nodes)[0])
        if system.isotropic:
            return energy - left / (2 * system.model.mu)
        mass = 0.5 / _weight(system.model, self.shell.section_coordinate()[0])
        return energy - left / (2 * mass)


class Ellipses:
    """Momenta over the points of a section of an H of second degree in the momenta: ellipses that differ from place to
    place.
    """

    def __init__(self, shell: EnergyShell):
        self.i, self.at, _ = shell.section_coordinate()
        self.energy = shell.energy
        self.momenta = Momenta.of(shell.system, self.i)

    def places(self, u: np.ndarray) -> np.ndarray:
        """Return places (2, ...) over values (...) of the other coordinate."""
        q = np.full((2, *u.shape), float(self.at))
        q[1 - self.i] = u
        return q

    def room(self, u: np.ndarray, _: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the energy that is left, as a function of one column, and its size."""
        floor = self.momenta.floor(self.places(u))
        return self.energy - floor, abs(self.energy) + np.abs(floor)

    def ends(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the reach of the momentum to each side at coordinates (points,), and its centre."""
        _, low, high = self.sides(u)
        return (high - low) / 2, (low + high) / 2

    def span(self, low: float, high: float) -> tuple[float, float]:
        """Return the range of momenta between two coordinates."""

        def end(side: int) -> Function:
            return lambda u, _: (side * self.sides(u.ravel())[1 if side < 0 else 2].reshape(u.shape), 0.0 * u)

        bottom, top = (float(highest(end(side), 1, _between(low, high))[0]) for side in (-1, 1))
        return -bottom, top

    def least(self, nodes: np.ndarray) -> float:
        """Return the least energy on the section, above which momenta are allowed."""
        return self.energy - float(highest(self.room, 1, nodes)[0])

    def sides(self, u: np.ndarray) -> Sides:
        """Return the ends of the ellipses over coordinates (points,)."""
        q = self.places(u)
        with np.errstate(all="ignore"):
            room = evaluated(self.room, u, np.zeros(u.size, np.int64))[0]
            reach, centre = self.momenta.reach(q)
            half = reach * np.sqrt(2 * np.maximum(room, 0.0))
        return Sides(u, centre - half, centre + half)


Slices = EqualEllipses | Ellipses


def _slices_of(shell: EnergyShell) -> Slices:
    system = shell.system
    return Ellipses(shell) if system.nonseparable and system.n == 2 else EqualEllipses(shell)


def _between(low: float, high: float) -> np.ndarray:
    return np.linspace(low, high, 65) if high > low else np.full(3, low)


def _centre(shell: EnergyShell) -> float:
    """Return the momentum about which the accessible part of a section is symmetric: that of rest."""
    system = shell.system
    if not isinstance(shell.section, (Hyperplane, AngleEquals)) or not system.frame:
        return 0.0
    i, at, _ = shell.section_coordinate()
    q = np.zeros(2)
    q[i] = at
    return float(system.at_rest(q)[1 - i])


def _weight(model: Any, i: int) -> float:
    """Return the least kinetic energy, over the i-th of two momenta, at which the other one is 1."""
    own, other = np.eye(2)[[i, 1 - i]]
    return float(model.kinetic_energy(*other) - model.velocity(*other)[i] ** 2 / (4 * model.kinetic_energy(*own)))


def _rest(shell: EnergyShell) -> Function:
    """Return the largest squared momentum at a coordinate as a function of one column; infinite where the other radius
    is unbounded.
    """
    system, energy, section = shell[:3]
    body = system.model
    linear = isinstance(section, (Hyperplane, AngleEquals))
    i, at, _ = shell.section_coordinate() if linear else (0, 0.0, 0)
    if linear and body.degrees_of_freedom == 2:
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
        return lambda u, _: _widest(shell, u, alpha=isinstance(section, AlphaTurning))
    radii_over(section, np.zeros(0))  # or TypeError
    return lambda u, _: shell.room(*radii_over(section, u))


def _widest(shell: EnergyShell, u: np.ndarray, *, alpha: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest squared momentum at u over all values of the other radius, infinite where it has no bound; and
    its size.
    """
    flat = u.ravel()
    rest = shell.radial(flat, alpha=alpha)
    far = evaluated(rest, np.full(flat.size, LARGEST), np.arange(flat.size))[0] > 0
    best = np.where(far, np.inf, highest(rest, flat.size, radii())).reshape(u.shape)
    return best, 2 * shell.model.mu * abs(shell.energy) + np.abs(best)


# --- sections of any H(q, p) ----------------------------------------------------------------------------------------


def sides_of_any(shell: EnergyShell, points: int) -> list[Sides]:
    """Return the pieces of a section of any H(q, p), told by a net over the box that the energy bounds."""
    system, energy = shell[:2]
    box = LineMeasure.of(shell, {}).box
    i, at, _ = shell.section_coordinate()
    low, high = (dict(zip((1 - i, 2, 3), ends)) for ends in (box.low, box.high))
    nodes = np.linspace(low[2 + i], high[2 + i], ALONG + 1)

    def room(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the energy that is left at points (points,) at the best p_i."""

        def over(p: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            z = np.empty((4, *p.shape))
            z[i], z[1 - i], z[2 + i], z[3 - i] = at, u[column], p, v[column]
            return shell.left(z)

        return highest(over, u.size, nodes)

    def best(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the momentum at which the most energy is left over coordinates, and that energy."""
        a = np.full(u.size, low[3 - i])
        b = np.full(u.size, high[3 - i])
        for parts in (ALONG, 8, 8, 8, 8, 8, 8):
            v = a + (b - a) * np.linspace(0, 1, parts + 1)[:, None]
            rest = room(np.tile(u, parts + 1), v.ravel()).reshape(v.shape)
            k = np.clip(rest.argmax(axis=0), 1, parts - 1)
            a, b, v = (np.take_along_axis(v, (k + step)[None], axis=0)[0] for step in (-1, 1, 0))
        return v, np.take_along_axis(rest, k[None], axis=0)[0]

    u = np.linspace(low[1 - i], high[1 - i], ACROSS + 1)
    allowed = best(u)[1] > 0
    pieces = []
    if not allowed.any():
        raise NotReached(f"energy {energy:g} reaches less of the section {system.names[i]}={at:g} than can be seen")
    for first, last in _runs(allowed):
        ends = [
            _bisected(lambda x: best(x)[1] > 0, u[[k]], u[[k + step]])[0] if 0 <= k + step < u.size else u[k]
            for k, step in ((first, -1), (last, 1))
        ]
        dense = ends[0] + (ends[1] - ends[0]) * (1 - np.cos(np.linspace(0, np.pi, points))) / 2
        is_in = partial(_positive, room, dense)
        middle = best(dense)[0]
        sides = [_bisected(is_in, middle, np.full(points, ends[3 - i])) for ends in (low, high)]
        pieces.append(Sides(dense, *sides))
    return pieces


def _positive(room: Any, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.asarray(room(u, v) > 0)


def _runs(allowed: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and the last number of each run of true entries."""
    steps = np.diff(np.concatenate([[0], allowed.astype(np.int64), [0]]))
    return list(zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1) - 1, strict=True))


def _bisected(is_in: Any, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Return the last points on the way from inner to outer ones that are in."""
    for _ in range(HALVINGS):
        middle = (inner + outer) / 2
        kept = is_in(middle)
        inner = np.where(kept, middle, inner)
        outer = np.where(kept, outer, middle)
    return inner
