"""The accessible part of a section of an energy surface: its boundary, and random points spread evenly over it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from ...base.axes import along
from ...base.numbers import entries, fits, flag, shown, span, whole
from ...base.recipe import recorded
from ...base.results import Result
from ...base.short_forms import takes
from ...flows.checks import checked_model
from ...formulas.section_text import section_in_words, section_of
from ...models.contracts import Dynamics, Model, Section
from ...models.mechanics import at_rest, least_energies
from ...models.sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Linear
from ...models.traits import traits_of
from .allowed_region import LARGEST, Function, evaluated, extrema, highest, intervals, line, radii
from .energy_grid import ARRAYS, checked_surface, lift_sheets, no_planes, planes, radial, radii_over, room
from .energy_limits import NotReached, may_escape, too_low
from .invariant_measure import Measure, Ranges, measure_of, ranges_of
from .named_axes import Axes, are_named, by_name, checked_energy, checked_sign

ENDLESS = 32
"""Bounded pieces of a section beyond which there is no end of them, as of a potential that is periodic."""


@dataclass(frozen=True)
class Edge(Result, axis=None):
    """The boundary of the accessible part of a section: coordinate (points,) and the largest momentum there, beyond the
    `centre`, that of rest in a turning frame, else 0.
    """

    coordinate: Annotated[np.ndarray, along("point")]
    momentum: Annotated[np.ndarray, along("point")]
    centre: float = 0.0

    @property
    def axes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The ranges of the coordinate and of its momentum."""
        top = float(self.momentum.max())
        return (float(self.coordinate[0]), float(self.coordinate[-1])), (self.centre - top, self.centre + top)


@dataclass(frozen=True)
class EnergySample(Result):
    """Random points of an energy surface.

    z0 (2n, orbits); points (names, orbits): the coordinates drawn, by name: a section's coordinate and its momentum, or
    rows of z, or angles; energy.
    """

    z0: Annotated[np.ndarray, along("coordinate", "orbit")]
    points: Annotated[np.ndarray, along("section coordinate", "orbit", labels="names", plain=True)]
    names: tuple[str, ...]
    energy: float


Seed = int | Sequence[int] | np.random.SeedSequence | np.random.BitGenerator | np.random.Generator | None
"""What `numpy.random.default_rng` takes."""


@takes(section=section_of, axes=by_name, fixed=by_name)
@recorded
def energy_sample(
    body: Dynamics,
    *,
    orbits: int,
    energy: float | None = None,
    section: Section | str | None = None,
    seed: Seed = 0,
    rng: Seed = None,
    axes: Axes | None = None,
    fixed: Mapping[str, float] | None = None,
    solve: str | None = None,
    sign: int = 1,
    at_rest: bool = False,
    p_eta: float = 0.0,
    p_gamma: float = 0.0,
) -> EnergySample:
    """Draw random points of an energy surface or of a section of it, uniform in the invariant measure.

    Parameters
    ----------
    body : model
        Any number n of degrees of freedom.
    orbits : int
        Number of points. The first points are the same for any number.
    energy, section : as in `energy_grid`
    seed : int or seed of `numpy.random.default_rng`, default 0
        Seed of the random numbers.
    rng : as seed, or a `numpy.random.Generator`, optional
        Instead of seed, as SPEC 7 of Scientific Python names it.
    axes : two ranges, or dict of ranges (low, high), optional
        Ranges of the section's coordinate and momentum, or of rows by name (default: all bounded parts that the energy
        allows).
    fixed, solve, sign, at_rest, p_eta, p_gamma : as in `energy_grid`

    Returns
    -------
    `EnergySample`
        Phase points and their section coordinates.

    Raises
    ------
    NotReached
        A ValueError: the energy reaches nothing.
    ValueError
        Nothing bounds the points and axes is missing.

    Notes
    -----
    On a section of a body, or of a system of two degrees of freedom, points are uniform over (beta, p_beta) on
    AlphaTurning and AlphaEquals, over (alpha, p_alpha) on BetaTurning and BetaEquals, over beta and its momentum along
    the section, p_beta + (beta/alpha) p_alpha, on AreaEquals, and over (q_j, p_j) on Linear. The return map preserves
    this area dq dp, so the chaotic share of the points is that of the section's area. It is not the share of the energy
    surface's volume, where each point counts with its return time. All wells are drawn from, on a turning section also
    those of the turning radius. Sections of direction 0 are drawn from one of their two sides, as in `energy_grid`.

    For any n, a section q_i = c is drawn in the volume of all other dq dp. Without a section the points are uniform on
    the energy surface, dq dp delta(E - H), whose means are the time averages of chaotic orbits (n of 2 or more; axes:
    ranges of coordinates). With `solve` they are uniform in the ranges of `axes` by name, the rest as in `energy_grid`.
    At rest: directions uniform over the sphere. Of a map, which has no energy: uniform in the ranges of `axes` by name.

    Cost: that of `energy_grid` for about 1.5 times the points, and half a second for `edge` of a turning section. In
    the volume of n degrees of freedom: some tenths of a second for the box of coordinates, and 2 evaluations of the
    potential a point for n = 2, 6 for n = 3, 2000 for n = 8, by the share of the box that the energy fills.

    References
    ----------
    Poincare's integral invariant (Lichtenberg & Lieberman 1992, Regular and Chaotic Dynamics, section 1.2b);
    Liouville's theorem; Smith 1984, Oper. Res. 32, 1296 (walks along random chords, for the box).

    Examples
    --------
    >>> sample = fa.energy_sample(fa.HenonHeiles(), energy=0.1, section="x=0", orbits=5)
    >>> sample.z0.shape, sample.names
    ((4, 5), ('y', 'p_y'))
    """
    count = whole("orbits", orbits, 1)
    fits("orbits", ARRAYS, count)
    seed = _seed(seed, rng)
    how = (axes, fixed, solve, checked_sign(sign), at_rest)
    if section is None or not on_section(body, section, *how):
        source = source_of(body, energy, section, *how, p_eta=p_eta, p_gamma=p_gamma)
        fits("orbits", ARRAYS * body.degrees_of_freedom, count)
        return sample_of(source, count, seed)
    energy, p_eta, p_gamma = checked_surface(body, section, energy, p_eta, p_gamma)
    boxes = ranges_to_draw(body, section, energy, p_eta, p_gamma, axes)
    return drawn(body, section, energy, p_eta, p_gamma, boxes, count, seed)[0]


def on_section(
    body: Any,
    section: Any,
    axes: Any = None,
    fixed: Any = None,
    solve: Any = None,
    sign: Any = 1,
    at_rest: Any = False,
) -> bool:
    """Tell whether points lie on a section of a body or of a system of two degrees of freedom, by its two
    coordinates.
    """
    by_rows = are_named(axes) or fixed is not None or solve is not None or sign != 1 or at_rest is not False
    plain = type(section) is Linear and not traits_of(body).isotropic and getattr(body, "degrees_of_freedom", 2) != 2
    return not (by_rows or plain)


def source_of(
    body: Any,
    energy: Any,
    section: Any,
    axes: Any,
    fixed: Any,
    solve: Any,
    sign: Any,
    at_rest: Any,
    *,
    p_eta: Any = 0.0,
    p_gamma: Any = 0.0,
) -> Measure | Ranges:
    """Return what points of any number of degrees of freedom are drawn from; raises naming what is wrong."""
    checked_model(body, needs="a start by rows")
    energy = checked_energy(body, energy)
    no_planes(p_eta, p_gamma)
    if flag("at_rest", at_rest) or solve is not None or not traits_of(body).launches:
        return ranges_of(body, energy, section, axes, fixed, solve, sign, at_rest)
    if fixed is not None or sign != 1:
        raise ValueError(f"{'sign' if fixed is None else 'fixed'} goes with solve or at_rest, which are missing")
    if traits_of(body).isotropic and section is None and axes is None:
        raise ValueError(
            "axes must give ranges of the coordinates of a body, or section one of its sections: wells of its four "
            "coordinates are rings"
        )
    return measure_of(body, energy, section, axes)


def _seed(seed: Any, rng: Any) -> Any:
    """Return the seed or generator that is given by one of two names."""
    name, value = ("seed", seed) if rng is None else ("rng", rng)
    if rng is not None and not (type(seed) is int and seed == 0):
        raise ValueError(f"rng must not be given beside seed, got rng={shown(rng)} and seed={shown(seed)}")
    try:
        np.random.default_rng(value)
    except (TypeError, ValueError) as problem:
        takes = "one of numpy.random.default_rng, such as a whole number of at least 0"
        raise type(problem)(f"{name} must be {takes}, got {shown(value)}") from None
    return value


def sample_of(source: Measure | Ranges, count: int, seed: Any) -> EnergySample:
    """Return so many points of a source."""
    z0, points = source.draw(count, seed)
    return EnergySample(z0, points, source.names, energy=source.energy)


Box = tuple[tuple[float, float], tuple[float, float]]


def ranges_to_draw(body: Any, section: Any, energy: float, p_eta: float, p_gamma: float, axes: Any = None) -> list[Box]:
    """Return the ranges of coordinate and momentum to draw from: those given, or of each bounded part of the
    section.
    """
    if axes is None:
        parts = _bounded_parts(body, section, energy, p_eta, p_gamma)
        centre = _centre(body, section)
        boxes = [((part.low, part.high), (centre - part.top, centre + part.top)) for part in parts]
    else:
        ranges = entries("axes", axes, "two ranges (low, high)", 2)
        (u0, u1), (v0, v1) = (span(f"axes[{k}]", ends) for k, ends in enumerate(ranges))
        boxes = [((u0, u1), (v0, v1))]
    if isinstance(section, AreaEquals):  # |P| is below |p| times the length of the section over that of beta
        boxes = [
            ((u0, u1), (_steepest(section, u0, u1) * v0, _steepest(section, u0, u1) * v1))
            for (u0, u1), (v0, v1) in boxes
        ]
    return boxes


def drawn(
    body: Any,
    section: Any,
    energy: float,
    p_eta: float,
    p_gamma: float,
    boxes: list[Box],
    count: int,
    seed: Any,
    sheets: int = 1,
) -> tuple[EnergySample, int]:
    """Return so many points of the ranges, and the number of sheets that they lie on: of `sheets` or more."""
    while True:
        found, most = _draw(body, section, energy, p_eta, p_gamma, boxes, sheets, count, np.random.default_rng(seed))
        if most <= sheets:
            return found, sheets
        sheets = most


def _steepest(section: AreaEquals, u0: float, u1: float) -> float:
    """Return the largest ratio of the lengths along the section and along beta between two values of beta."""
    with np.errstate(all="ignore"):
        return float(np.sqrt(1 + np.nanmax(np.square([u0, u1]) / (2 * section.constant + np.square([u0, u1])))))


def _draw(
    body: Model,
    section: Section,
    energy: float,
    p_eta: float,
    p_gamma: float,
    boxes: list,
    sheets: int,
    count: int,
    random: Any,
) -> tuple[EnergySample, int]:
    """Return so many points, each drawn from one of the boxes by their areas, and of `sheets` sheets one; and the most
    sheets met.

    A point where its sheet is missing is drawn anew, so that every sheet has the same density.
    """
    raise_section = _area_lift if isinstance(section, AreaEquals) else lift_sheets
    areas = np.array([(u1 - u0) * (v1 - v0) for (u0, u1), (v0, v1) in boxes])
    found_parts: list[tuple[np.ndarray, np.ndarray]] = []
    names, kept, tried, batch, most = ("", ""), 0, 0, max(64, count), 1
    while kept < count and most <= sheets:
        u, v = random.uniform(size=batch), random.uniform(size=batch)
        box = np.zeros(batch, np.int64) if len(boxes) == 1 else random.choice(len(boxes), batch, p=areas / areas.sum())
        (u0, u1), (v0, v1) = np.moveaxis(np.array(boxes), 0, -1)[..., box]
        u, v = u0 + (u1 - u0) * u, v0 + (v1 - v0) * v
        z, found, names = raise_section(body, section, energy, p_eta, p_gamma, u, v)
        most = int(found.sum(axis=0).max())
        if most > sheets:
            break
        # Sheets that exist are numbered anew: a turning point at a wall is none.
        number = np.zeros(batch, np.int64) if sheets == 1 else random.integers(sheets, size=batch)
        at = np.argmax(np.cumsum(found, axis=0) == number + 1, axis=0)
        exists = found.sum(axis=0) > number
        found_parts.append(
            (np.take_along_axis(z, at[None, None], axis=0)[0][:, exists], np.array([u[exists], v[exists]]))
        )
        kept, tried = kept + int(exists.sum()), tried + batch
        batch = min(2 * batch, max(8192, count))
        if tried > 1000 * (kept + 16):
            raise NotReached(
                f"energy {energy} reaches less than a thousandth of the ranges {boxes!r} on {section!r}: narrow them"
            )
    if most > sheets:
        return EnergySample(z0=np.zeros((0, 0)), points=np.zeros((2, 0)), names=names, energy=energy), most
    z0, points = (np.concatenate(part, axis=1)[:, :count] for part in zip(*found_parts, strict=True))
    return EnergySample(np.ascontiguousarray(z0), np.ascontiguousarray(points), names, energy=energy), most


def _area_lift(
    body: Any, section: Any, energy: float, p_eta: float, p_gamma: float, u: np.ndarray, P: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Lift (beta, P) to an area section: P/sqrt(1 + (beta/alpha)^2) is the momentum along it, the energy gives the one
    across.
    """
    alpha = np.sqrt(2 * section.constant + u * u)
    length = np.hypot(alpha, u)
    with np.errstate(all="ignore"):
        along = P * alpha / length
        rest = room(body, energy, p_eta, p_gamma, alpha, u)[0] - along**2
        across = (-1.0 if section.direction < 0 else 1.0) * np.sqrt(np.maximum(rest, 0.0))
        found = (rest >= 0) & np.isfinite(rest)
        p_alpha, p_beta = (across * alpha + along * u) / length, (along * alpha - across * u) / length
        z = planes(alpha, p_alpha, p_eta, u, p_beta, p_gamma)
    return z[None], (found & np.isfinite(z).all(axis=0))[None], ("beta", "P")


class _Part(NamedTuple):
    """A bounded part of a section: range of the coordinate, largest momentum."""

    low: float
    high: float
    top: float


def edge(
    body: Any, section: Any, *, energy: float, p_eta: float = 0.0, p_gamma: float = 0.0, points: int = 800
) -> Edge:
    """Return the boundary of the accessible part of a section of an energy surface, for axis ranges and for drawing.

    Parameters as in `energy_grid`.

    :Returns: Edge; where the bounded part falls apart, of all its pieces in turn; valleys that go to infinity beside
        them are left out; on AreaEquals the direction forbids a little more on one side.
    :Raises: ValueError where the energy reaches nothing or no piece is bounded, TypeError for a section without a grid.
        Coordinates of all sizes are searched.
    :Source: the kinetic energy of the coordinate, p^2/(2 mu) = E - min V_effective, has to be positive.
    """
    checked_model(body, needs="an energy surface")
    section = section_of(section, body)
    parts = _bounded_parts(body, section, energy, p_eta, p_gamma)
    rest = _rest(body, section, energy, p_eta, p_gamma)
    share = max(2, points // len(parts))
    # Dense at all ends, where the boundary is steep.
    dense = (1 - np.cos(np.linspace(0, np.pi, share))) / 2
    u = np.concatenate([part.low + (part.high - part.low) * dense for part in parts])
    value = evaluated(rest, u, np.zeros(u.size, np.int64))[0]
    return Edge(u, np.sqrt(np.maximum(value, 0.0)), _centre(body, section))


def _centre(body: Any, section: Any) -> float:
    """Return the momentum about which the accessible part of a section is symmetric: that of rest."""
    if not isinstance(section, Linear) or not traits_of(body).frame:
        return 0.0
    i = int(np.flatnonzero(section.normal)[0])
    q = np.zeros(2)
    q[i] = section.offset / section.normal[i]
    return float(at_rest(body, q)[1 - i])


def _bounded_parts(body: Any, section: Any, energy: float, p_eta: float, p_gamma: float) -> list[_Part]:
    """Return the pieces of the section that the energy allows, without those that go to infinity."""
    rest = _rest(body, section, energy, p_eta, p_gamma)
    nodes = radii() if traits_of(body).isotropic else line()
    found, name = intervals(rest, nodes), section_in_words(section, body)
    if not found:
        raise NotReached(
            too_low(body, energy, p_eta, p_gamma)
            or f"energy {energy:g} does not reach the section {name}: the least energy there is "
            f"{_least(body, section, energy, rest, nodes):.6g}"
        )
    bounded, parts = [ends for ends in found if np.isfinite(ends).all()], []
    endless = len(bounded) > ENDLESS
    for low, high in [min(bounded, key=lambda ends: abs(ends[0] + ends[1]))] if endless else bounded:
        inside = extrema(rest, 1, np.linspace(low, high, 65)) if high > low else extrema(rest, 1, np.full(3, low))
        parts.append(_Part(low, high, float(np.sqrt(max(0.0, inside.f.max())))))
    if not parts or not all(np.isfinite(part.top) for part in parts):
        if below := too_low(body, energy, p_eta, p_gamma):
            raise NotReached(below)
        why = may_escape(body, energy, p_eta, p_gamma) or f"energy {energy:g} does not bound the motion"
        raise ValueError(f"{why}; nothing bounds the section {name}: give the ranges of the axes")
    if endless:
        low, high, top = parts[0]
        raise ValueError(
            f"what energy {energy:g} allows of the section {name} falls apart into pieces without end: give the ranges "
            f"of the axes, such as (({low:.6g}, {high:.6g}), ({-top:.6g}, {top:.6g}))"
        )
    return parts


def _least(body: Any, section: Any, energy: float, rest: Function, nodes: np.ndarray) -> float:
    """Return the least energy on a section: from there on some momentum is left."""
    if traits_of(body).isotropic:
        mass = body.mu
    else:
        mass = 0.5 / body.kinetic_energy(*np.eye(2)[1 - int(np.flatnonzero(section.normal)[0])])
    return energy - float(highest(rest, 1, nodes)[0]) / (2 * mass)


def _rest(body: Any, section: Any, energy: float, p_eta: float, p_gamma: float) -> Function:
    """Return the largest squared momentum at a coordinate as a function of one column; infinite where nothing bounds
    the other radius.
    """
    if isinstance(section, Linear) and body.degrees_of_freedom == 2:
        i = int(np.flatnonzero(section.normal)[0])
        at = section.offset / section.normal[i]
        weight = body.kinetic_energy(*np.eye(2)[1 - i])

        def left(u, _):
            q = np.array([at + 0 * u, u] if i == 0 else [u, at + 0 * u])
            V = np.where(body.margin(*q) > 0, least_energies(body, q), np.inf)
            return (energy - V) / weight, (abs(energy) + np.abs(V)) / weight

        return left
    if not traits_of(body).isotropic:
        raise TypeError(f"section {section!r} has no known boundary for {type(body).__name__}")
    surface = body, energy, p_eta, p_gamma
    if isinstance(section, (AlphaTurning, BetaTurning)):
        return lambda u, _: _widest(*surface, u, alpha=isinstance(section, AlphaTurning))
    if isinstance(section, (AlphaEquals, BetaEquals, AreaEquals)):
        return lambda u, _: room(*surface, *radii_over(section, u))
    raise TypeError(f"section {section!r} has no known boundary")


def _widest(
    body: Any, energy: float, p_eta: float, p_gamma: float, u: np.ndarray, *, alpha: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest squared momentum at u over all values of the other radius, infinite where it has no bound; and
    its size.
    """
    flat = u.ravel()
    rest = radial(body, energy, p_eta, p_gamma, flat, alpha=alpha)
    far = evaluated(rest, np.full(flat.size, LARGEST), np.arange(flat.size))[0] > 0
    best = np.where(far, np.inf, highest(rest, flat.size, radii())).reshape(u.shape)
    return best, 2 * body.mu * abs(energy) + np.abs(best)
