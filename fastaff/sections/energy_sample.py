"""Random points of an energy surface or of a section of it, spread evenly in the invariant measure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..core.numbers import entries, fits, flag, shown, span, whole
from ..results.calls import coerces_arguments, records_call
from ..results.result import Result, along
from ..runs.requirements import checked_model, current_system
from ..systems.formulas.section_text import section_of
from ..systems.models.contracts import Dynamics, Section
from ..systems.models.mechanics import System
from ..systems.models.sections import AngleEquals, Hyperplane
from .energy_grid import ARRAYS, checked_surface, lift_sheets, no_planes
from .energy_limits import NotReached, Where
from .invariant_measure import Measure, Ranges, measure_of, ranges_of
from .named_axes import NO_OTHERS, Axes, Others, are_named, by_name, checked_energy, checked_sign
from .section_edge import parts
from .section_points import radii_over, slopes_over
from .surface_points import SurfaceMeasure

STEEPEST = 65
"""Places of a section at which its slope is computed."""

FIRST = 64
"""Points of a section that are tried first."""

MORE = 512
"""Most points that are tried at once after the first."""

BLOCK = 1024
"""Points of one seed: blocks can be drawn apart."""


@dataclass(frozen=True)
class EnergySample(Result):
    """Random points of an energy surface.

    z0 (2n, orbits); points (names, orbits): the coordinates drawn, by name: a section's coordinate and its momentum, or
    rows of z, or angles; energy. section: the common one, which `poincare_map` takes from here, or None.
    """

    z0: Annotated[np.ndarray, along("coordinate", "orbit")]
    points: Annotated[np.ndarray, along("section coordinate", "orbit", labels="names", plain=True)]
    names: tuple[str, ...]
    energy: float
    section: Section | None = None


Seed = int | Sequence[int] | np.random.SeedSequence | np.random.BitGenerator | np.random.Generator | None
"""Seeds that `numpy.random.default_rng` takes."""


@coerces_arguments(section=section_of, axes=by_name, fixed=by_name)
@records_call
def energy_sample(
    model: Dynamics,
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
    model : model
        Any number n of degrees of freedom.
    orbits : int
        Number of points. The first points are the same for any number, and those of a `Job` with this seed.
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
        A ValueError: the energy reaches no point.
    ValueError
        The region is unbounded, as momenta are at a pole of the potential, and axes is missing.

    Notes
    -----
    On a section of a body, or of a system of two degrees of freedom, points are uniform over (beta, p_beta) on
    AlphaTurning and AlphaEquals, over (alpha, p_alpha) on BetaTurning and BetaEquals, over beta and its momentum along
    the section, p_beta + (beta/alpha) p_alpha, on AreaEquals, and over (q_j, p_j) on Hyperplane. The return map
    preserves this area dq dp, so the chaotic share of the points is that of the section's area. It is not the share of
    the energy surface's volume, where each point counts with its return time. All wells have points, on a turning
    section those of the turning radius too; sections of direction 0 on one of their two sides, as in `energy_grid`.

    For any n, a section q_i = c is drawn in the volume of all other dq dp. Without a section the points are uniform on
    the energy surface, dq dp delta(E - H), whose means are the time averages of chaotic orbits (n of 2 or more; axes:
    ranges of coordinates). With `solve` they are uniform in the ranges of `axes` by name, the rest as in `energy_grid`.
    At rest: directions uniform over the sphere. For a map, without energy: uniform in the ranges of `axes` by name.

    For H(q, p) of second degree in p, momenta fill an ellipsoid at each place; its volume is the place's weight. Any
    other H is met by random lines along its rows, with weights of the points for the density ``1/|grad H|`` on the
    surface; on sections all roots count, and `axes` may name momenta too. Angles are drawn from one period around 0.

    Cost: that of `energy_grid` for about 1.5 times the points, and half a second for `edge` of a turning section. In
    the volume of n degrees of freedom: some tenths of a second for the box of coordinates, and 2 evaluations of the
    potential a point for n = 2, 6 for n = 3, 2000 for n = 8, by the share of the box that the energy fills. For H(q, p)
    some seconds for the box; by lines, thousands of evaluations of H a point.

    References
    ----------
    Poincare's integral invariant (Lichtenberg & Lieberman 1992, Regular and Chaotic Dynamics, section 1.2b);
    Liouville's theorem; Smith 1984, Oper. Res. 32, 1296 (walks along random chords, for the box); Santalo 1976,
    Integral Geometry and Geometric Probability, section 14.4 (lines across a surface).

    Examples
    --------
    >>> sample = fa.energy_sample(fa.HenonHeiles(), energy=0.1, section="x=0", orbits=5)
    >>> sample.z0.shape, sample.names
    ((4, 5), ('y', 'p_y'))
    """
    count = whole("orbits", orbits, 1)
    fits("orbits", ARRAYS, count)
    seed = _seed(seed, rng)
    system = current_system(model)
    others = Others(fixed, solve, checked_sign(sign), at_rest)
    if section is None or not on_section(system, section, axes, others):
        source: Source = OfSource(source_of(system, energy, section, axes, others, (p_eta, p_gamma)))
        fits("orbits", ARRAYS * system.n, count)
    else:
        where = checked_surface(system, section, energy, p_eta, p_gamma)
        source = OnSection(where, ranges_to_draw(where, axes))
    found = EnergySample.concat([block_of(source, k, count, seed) for k in range(-(-count // BLOCK))])
    return replace(found, section=section_of(section, model))


def on_section(system: System, section: Any, axes: Any = None, others: Others = NO_OTHERS) -> bool:
    """Tell whether points lie on a section of a body or of a system of two degrees of freedom, by its two
    coordinates.
    """
    by_rows = are_named(axes) or others.given or others.sign != 1
    plain = (
        type(section) in (Hyperplane, AngleEquals)
        and not system.isotropic
        and getattr(system.model, "degrees_of_freedom", 2) != 2
    )
    return not (by_rows or plain)


def source_of(
    system: System, energy: Any, section: Any, axes: Any, others: Others, planes: tuple[Any, Any]
) -> Measure | SurfaceMeasure | Ranges:
    """Return the source of points of any number of degrees of freedom; errors name the wrong argument."""
    checked_model(system.model, needs="a start by rows")
    energy = checked_energy(system, energy)
    no_planes(*planes)
    by_rows = others.solve is not None or (others.fixed is not None and section is not None)
    if flag("at_rest", others.at_rest) or by_rows or not system.conserves:
        return ranges_of(system, energy, section, axes, others)
    if others.fixed is not None or others.sign != 1:
        p = system.row_names[system.n]
        q = system.names[0]
        raise ValueError(
            f"{'sign' if others.fixed is None else 'fixed'} goes with solve or at_rest, which are missing: solve={p!r} "
            f"for the row that the energy gives, with axes={{{q!r}: (low, high)}} for those to draw"
        )
    if system.isotropic and section is None and axes is None:
        raise ValueError(
            "axes must give ranges of the coordinates of a body, or section one of its sections: wells of its four "
            "coordinates are rings"
        )
    return measure_of(system, energy, section, axes)


def _seed(seed: Any, rng: Any) -> Any:
    """Return the seed or generator that is given by one of two names."""
    name, value = ("seed", seed) if rng is None else ("rng", rng)
    if rng is not None and not (type(seed) is int and seed == 0):
        raise ValueError(f"rng must not be given beside seed, got rng={shown(rng)} and seed={shown(seed)}")
    try:
        np.random.default_rng(value)
    except (TypeError, ValueError) as problem:
        taken = "one of numpy.random.default_rng, such as a whole number of at least 0"
        raise type(problem)(f"{name} must be {taken}, got {shown(value)}") from None
    return value


Box = tuple[tuple[float, float], tuple[float, float]]


class OfSource(NamedTuple):
    """Random points of any number of degrees of freedom."""

    source: Measure | SurfaceMeasure | Ranges

    def draw(self, count: int, seed: Any) -> EnergySample:
        """Return so many points."""
        z0, points = self.source.draw(count, seed)
        return EnergySample(z0, points, self.source.names, energy=self.source.energy)


class OnSection(NamedTuple):
    """Random points of a section, uniform in its invariant area."""

    where: Where
    boxes: list[Box]

    def draw(self, count: int, seed: Any) -> EnergySample:
        """Return so many points."""
        sheets = 1
        while True:
            found, most = _draw(self.where, self.boxes, sheets, count, np.random.default_rng(seed))
            if most <= sheets:
                return found
            sheets = most


Source = OfSource | OnSection


def block_of(source: Source, block: int, count: int, seed: Any) -> EnergySample:
    """Return block number `block` of `count` points: each has a seed of its own, the first the seed that is given. A
    generator goes on.
    """
    if block and not isinstance(seed, (np.random.Generator, np.random.BitGenerator)):
        root = seed if isinstance(seed, np.random.SeedSequence) else np.random.SeedSequence(seed)
        seed = np.random.SeedSequence(root.entropy, spawn_key=(*root.spawn_key, BLOCK, block))
    return source.draw(min(BLOCK, count - block * BLOCK), seed)


def ranges_to_draw(where: Where, axes: Any = None) -> list[Box]:
    """Return the ranges of coordinate and momentum to draw from: those given, or of each bounded part of the
    section.
    """
    if axes is None:
        boxes = [((part.low, part.high), (part.bottom, part.top)) for part in parts(where)]
    else:
        ranges = entries("axes", axes, "two ranges (low, high)", 2)
        (u0, u1), (v0, v1) = (span(f"axes[{k}]", ends) for k, ends in enumerate(ranges))
        boxes = [((u0, u1), (v0, v1))]
    section = where.section
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


def _draw(where: Where, boxes: list[Box], sheets: int, count: int, random: Any) -> tuple[EnergySample, int]:
    """Return so many points, each drawn from one of the boxes by their areas and from one of `sheets` sheets; and the
    largest number of sheets met.

    A point where its sheet is missing is drawn anew, so that every sheet has the same density.
    """
    energy = where.energy
    section = where.section
    raise_section = _leaning_lift if hasattr(section, "slopes") else lift_sheets
    areas = np.array([(u1 - u0) * (v1 - v0) for (u0, u1), (v0, v1) in boxes])
    found_parts: list[tuple[np.ndarray, np.ndarray]] = []
    names = ("", "")
    kept = 0
    tried = 0
    batch = FIRST
    most = 1
    while kept < count and most <= sheets:
        u = random.uniform(size=batch)
        v = random.uniform(size=batch)
        box = np.zeros(batch, np.int64) if len(boxes) == 1 else random.choice(len(boxes), batch, p=areas / areas.sum())
        (u0, u1), (v0, v1) = np.moveaxis(np.array(boxes), 0, -1)[..., box]
        u, v = u0 + (u1 - u0) * u, v0 + (v1 - v0) * v
        z, found, names = raise_section(where, u, v)
        most = int(found.sum(axis=0).max())
        if most > sheets:
            break
        # Existing sheets are numbered anew: a turning point at a wall is no sheet.
        number = np.zeros(batch, np.int64) if sheets == 1 else random.integers(sheets, size=batch)
        at = np.argmax(np.cumsum(found, axis=0) == number + 1, axis=0)
        exists = found.sum(axis=0) > number
        found_parts.append(
            (np.take_along_axis(z, at[None, None], axis=0)[0][:, exists], np.array([u[exists], v[exists]]))
        )
        kept = kept + int(exists.sum())
        tried = tried + batch
        batch = min(3 * tried, MORE)
        if tried > 1000 * (kept + 16):
            raise NotReached(
                f"energy {energy} reaches less than a thousandth of the ranges {boxes!r} on {section!r}: narrow them"
            )
    if most > sheets:
        return EnergySample(z0=np.zeros((0, 0)), points=np.zeros((2, 0)), names=names, energy=energy), most
    z0, points = (np.concatenate(part, axis=1)[:, :count] for part in zip(*found_parts, strict=True))
    return EnergySample(
        np.ascontiguousarray(z0), np.ascontiguousarray(points), names, energy=energy, section=section
    ), most


def _leaning_lift(where: Where, u: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Lift (u, P) to a section that leans, such as that of the area: P du/dl, of the length l along it, is the momentum
    along it, the energy gives the one across.
    """
    section = where.section
    alpha, beta = radii_over(section, u)
    own, other = slopes_over(section, alpha, beta)
    length = np.hypot(other, own)
    with np.errstate(all="ignore"):
        along = P * other / length
        rest = where.room(alpha, beta)[0] - along**2
        across = (-1.0 if section.direction < 0 else 1.0) * np.sqrt(np.maximum(rest, 0.0))
        found = (rest >= 0) & np.isfinite(rest)
        momenta = (across * other - along * own) / length, (along * other + across * own) / length
        p_alpha, p_beta = momenta[::-1] if section.over == "alpha" else momenta
        z = where.point(alpha, p_alpha, beta, p_beta)
    return z[None], (found & np.isfinite(z).all(axis=0))[None], (section.over, "P")
