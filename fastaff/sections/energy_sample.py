"""Random points of an energy surface or of a section of it, spread evenly in the invariant measure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import fits, flag, shown, whole
from ..core.status import counted
from ..results.calls import coerces_arguments, records_call
from ..results.result import Result, along
from ..runs.requirements import current_system
from ..systems.formulas.section_text import section_of
from ..systems.models.contracts import Dynamics, Section
from ..systems.models.mechanics import System
from ..systems.models.sections import AngleEquals, Hyperplane
from .energy_grid import ARRAYS
from .energy_shell import EnergyShell, NotReached
from .invariant_measure import EllipsoidMeasure, LineMeasure, measure_of
from .named_axes import NO_OTHERS, Axes, Others, Ranges, are_named, by_name, checked_sign, ranges_of
from .section_edge import Box, ranges_to_draw
from .section_points import lift_leaning, lift_sheets

FIRST = 64
"""Points of a section that are tried first."""

MORE = 512
"""Most points that are tried at once after the first."""

BLOCK = 1024
"""Points of one seed: blocks can be drawn apart."""


@dataclass(frozen=True)
class EnergySample(Result):
    """Random initial conditions on an energy surface or on a section of it.

    Attributes
    ----------
    z0 : ndarray, shape (2n, orbits)
        Phase points.
    points : ndarray, shape (names, orbits)
        Coordinates that were drawn: a section coordinate and its momentum, rows of z, or angles.
    names : tuple of str
        Names of these coordinates: ``sample["y"]`` is the row of that name.
    energy : float
        Energy of all orbits; NaN for a map.
    section : Section or None
        Section that all orbits lie on. `poincare_map` uses it by default.
    """

    z0: Annotated[np.ndarray, along("coordinate", "orbit")]
    points: Annotated[np.ndarray, along("section coordinate", "orbit", labels="names", plain=True)]
    names: tuple[str, ...]
    energy: float
    section: Section | None = None

    def summary(self) -> str:
        """Return one line with the number of orbits, their energy and the coordinates that were drawn.

        Returns
        -------
        str
            Summary.
        """
        energy = f" of energy {self.energy:.6g}" if np.isfinite(self.energy) else ""
        return f"{counted(len(self), 'orbit')}{energy}, random in {', '.join(self.names)}"


Seed = int | Sequence[int] | np.random.SeedSequence | np.random.BitGenerator | np.random.Generator | None
"""Seeds that `numpy.random.default_rng` takes."""


@coerces_arguments(section=section_of, axes=by_name, fixed=by_name)
@records_call
@inserts_parameters
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
    r"""Draw random points of an energy surface, or of a section of it, uniform in the invariant measure.

    Parameters
    ----------
    {model}
    orbits : int
        Number of points. The first points are the same for any number, and equal those of a `Job` with the same seed.
    energy : float, optional
        Energy of all orbits. It must be given unless the model is a map.
    section : Section or str, optional
        Surface that all orbits lie on, or a short form such as ``"x=0"`` (crossed upwards), ``"x=0-"`` (downwards),
        ``"alpha-turning"`` or ``"beta=0.2"`` of a body.
    seed : int or array_like of int, default 0
        Seed of the random numbers, as for `numpy.random.default_rng`.
    rng : int, array_like of int or numpy.random.Generator, optional
        Seed or generator, instead of `seed` (the name of SPEC 7 of Scientific Python).
    axes : tuple of two ranges, or dict of ranges, optional
        Ranges (low, high) of the section coordinate and its momentum, or of rows of z by name: of coordinates if there
        is no section. Default: all bounded parts of the accessible region, and one period around 0 for periodic
        coordinates. They must be given for a map.
    fixed : dict of float, optional
        Values of other rows by name; rows that are not named are 0.
    solve : str, optional
        Name of the row that follows from the energy. The others are uniform in the ranges of `axes`.
    sign : {1, -1}, default 1
        Root for `solve`. For a momentum, 1 is the larger root and -1 the smaller one, so the velocity has this sign.
        For a coordinate it is the outermost root in this direction.
    at_rest : bool, default False
        Set all momenta to 0. The direction in which the potential reaches the energy is uniform over the sphere.
    p_eta, p_gamma : float, default 0
        Angular momenta of the two planes, for bodies on a section.

    Returns
    -------
    `EnergySample`
        Phase points, and the coordinates that were drawn.

    Raises
    ------
    NotReached
        If the energy reaches no point. It is a `ValueError`.
    ValueError
        If the region is unbounded, as momenta are at a pole of the potential, and `axes` is not given.

    Notes
    -----
    - Section, two degrees of freedom: uniform in the area :math:`dq\,dp` that the return map preserves. Points fill all
      wells, on the side of `energy_grid` if the direction is 0. A chaotic fraction of them is that of the area, not the
      volume of the energy surface.
    - AreaEquals: the momentum is :math:`p_\beta + (\beta/\alpha) p_\alpha`.
    - Section q_i = c, more degrees of freedom: uniform in all other coordinates and momenta.
    - No section: uniform in :math:`\delta(E - H)\,dq\,dp`, for n > 1.
    - Cost of a point: 2 evaluations of the potential for n = 2, 2000 for n = 8, thousands if H is not quadratic in p.

    See the explanation page on sections and measure.

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
        source: Source = OfSource(source_of(EnergyShell.of_rows(system, energy, section, p_eta, p_gamma), axes, others))
        fits("orbits", ARRAYS * system.n, count)
    else:
        shell = EnergyShell.of_section(system, energy, section, p_eta, p_gamma)
        source = OnSection(shell, ranges_to_draw(shell, axes))
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


def source_of(shell: EnergyShell, axes: Any, others: Others) -> EllipsoidMeasure | LineMeasure | Ranges:
    """Return the source of points of any number of degrees of freedom; errors name the wrong argument."""
    system = shell.system
    section = shell.section
    by_rows = others.solve is not None or (others.fixed is not None and section is not None)
    if flag("at_rest", others.at_rest) or by_rows or not system.conserves:
        return ranges_of(shell, axes, others)
    if others.fixed is not None or others.sign != 1:
        p = system.row_names[system.n]
        q = system.names[0]
        raise ValueError(
            f"{'sign' if others.fixed is None else 'fixed'} requires solve or at_rest. Use solve={p!r} for the row "
            f"given by the energy and axes={{{q!r}: (low, high)}}."
        )
    if system.isotropic and section is None and axes is None:
        raise ValueError(
            "axes or section must be given for the energy surface of a body: ranges of its coordinates, or one of "
            "its sections"
        )
    return measure_of(shell, axes)


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


class OfSource(NamedTuple):
    """Random points of any number of degrees of freedom."""

    source: EllipsoidMeasure | LineMeasure | Ranges

    def draw(self, count: int, seed: Any) -> EnergySample:
        """Return so many points."""
        z0, points = self.source.draw(count, seed)
        return EnergySample(z0, points, self.source.names, energy=self.source.shell.energy)


class OnSection(NamedTuple):
    """Random points of a section, uniform in its invariant area."""

    shell: EnergyShell
    boxes: list[Box]

    def draw(self, count: int, seed: Any) -> EnergySample:
        """Return so many points."""
        sheets = 1
        while True:
            found, most = _draw(self.shell, self.boxes, sheets, count, np.random.default_rng(seed))
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


def _draw(shell: EnergyShell, boxes: list[Box], sheets: int, count: int, random: Any) -> tuple[EnergySample, int]:
    """Return so many points, each drawn from one of the boxes by their areas and from one of `sheets` sheets; and the
    largest number of sheets met.

    A point where its sheet is missing is drawn anew, so that every sheet has the same density.
    """
    energy = shell.energy
    section = shell.section
    raise_section = lift_leaning if hasattr(section, "slopes") else lift_sheets
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
        z, found, names = raise_section(shell, u, v)
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
                f"axes must be narrower: energy {energy:g} reaches less than a thousandth of {shown(boxes)}"
            )
    if most > sheets:
        return EnergySample(z0=np.zeros((0, 0)), points=np.zeros((2, 0)), names=names, energy=energy), most
    z0, points = (np.concatenate(part, axis=1)[:, :count] for part in zip(*found_parts, strict=True))
    return EnergySample(
        np.ascontiguousarray(z0), np.ascontiguousarray(points), names, energy=energy, section=section
    ), most
