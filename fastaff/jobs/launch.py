"""Where orbits start: the table [initial_conditions] of a job, and the launch set that it describes."""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from ..core.names import pairs
from ..core.numbers import fits
from ..core.placing import checked_file
from ..sections.energy_grid import ARRAYS, EnergyGrid, grid_of
from ..sections.energy_sample import (
    BLOCK,
    EnergySample,
    OfSource,
    OnSection,
    Source,
    block_of,
    on_section,
    source_of,
)
from ..sections.energy_shell import EnergyShell, NotReached
from ..sections.named_axes import Launching, Others, launching
from ..sections.section_edge import edge as section_edge
from ..sections.section_edge import ranges_to_draw
from ..sections.section_points import lift
from ..systems.formulas.number import number
from ..systems.models.mechanics import System
from .flags import axis_of, cells_of, flags_of_axes, range_of
from .system import EnergySurface
from .wording import OptionError, option, respelled

TRIED = 16
"""Blocks that orbits for a trial are taken from."""


@dataclass(frozen=True, kw_only=True)
class InitialConditions:
    """Where the orbits start."""

    grid: str | None = None
    """Cells N1xN2 over the section's coordinate and its momentum; cells beyond the energy are left out. [20x20, 40x40
    or 60x60]
    """
    orbits: int | None = None
    """Random starts, uniform over the accessible part of the section, instead of a grid."""
    seed: int = 0
    """Seed of the random starts. [0]"""
    q_range: str | None = None
    """Range LOW:HIGH of the section's coordinate. [all that the energy allows]"""
    p_range: str | None = None
    """Range LOW:HIGH of its momentum. [all that the energy allows]"""
    axes: list[str] | None = None
    """NAME=LOW:HIGH:N of a coordinate or momentum, once for each: a grid over these, of systems of any number of
    coordinates; with --orbits NAME=LOW:HIGH. At rest the angles phi, or theta and phi.
    """
    fixed: list[str] | None = None
    """NAME=VALUE of a coordinate or momentum beside --axes; once for each. [0]"""
    solve: str | None = None
    """Coordinate or momentum that the energy gives beside --axes, the larger root with --direction +1. [the section's
    momentum]
    """
    at_rest: bool = False
    """Start at rest, in the directions of --axes or in --orbits random ones: box orbits."""
    microcanonical: bool = False
    """Random starts over the whole energy surface instead of a section."""
    file: str | None = None
    """File of phase points (2n, orbits), .npy, instead of a grid."""

    def read(self) -> np.ndarray:
        """Return the phase points of the file, which stay on disk.

        Returns
        -------
        ndarray, shape (2n, orbits)
            Memory map of the file.
        """
        others = [name for name in ("grid", "orbits", "q_range", "p_range", *BY_NAME) if getattr(self, name)]
        if others:
            raise OptionError(f"give {option('file')} or {option(others[0])}, not both")
        checked_file(str(self.file), option("file"))
        try:
            with open(str(self.file), "rb") as file:
                if file.read(6) != b"\x93NUMPY":
                    raise ValueError("it does not begin as such a file does")
            array = np.load(str(self.file), mmap_mode="r", allow_pickle=False)
        except (ValueError, EOFError) as problem:
            raise OptionError(f"{option('file')} {self.file} must be an .npy file of numbers: {problem}") from None
        if not isinstance(array, np.ndarray) or array.ndim != 2 or array.dtype.kind not in "iuf":
            raise OptionError(f"{option('file')} {self.file} must have one array of real numbers (2n, orbits)")
        return array

    def launch(self, system: System, section: Any, surface: EnergySurface, default: str) -> Launch:
        """Return the launch set of the table: points by number.

        Parameters
        ----------
        system : object
            System of the job.
        section : Section
            Section of the job, or None.
        surface : EnergySurface
            Energy of the job.
        default : str
            Grid of cells, for example ``"20x20"``, used if the table names none.

        Returns
        -------
        Launch
            The launch set.
        """
        if self.grid is not None and self.orbits is not None:
            raise OptionError.of("give {grid} or {orbits}, not both")
        if self.orbits is not None and self.orbits < 1:
            raise OptionError(f"{option('orbits')} must be at least 1, got {self.orbits}")
        if self.orbits is not None:
            fits(option("orbits"), self.orbits, itemsize=1)
        if self.seed < 0:
            raise OptionError(f"{option('seed')} must be at least 0, got {self.seed}")
        if self.by_name or section is None or not system.conserves or not on_section(system, section):
            return self._by_name(system, section, surface)
        cells = cells_of(self.grid or default)
        fits(option("grid"), *cells, itemsize=1)
        fits(option("grid"), ARRAYS, max(cells))
        given = self.ranges()
        shell = EnergyShell.of_section(system, surface.energy, section, surface.p_eta, surface.p_gamma)
        edge = None
        ranges = given
        try:
            edge = section_edge(system.model, section, energy=shell.energy, p_eta=shell.p_eta, p_gamma=shell.p_gamma)
            ranges = [mine or found for mine, found in zip(given, edge.axes)]
        except ValueError as problem:
            if None in ranges:
                both = f"{option('q_range')} and {option('p_range')}"
                dicts = r"the ranges of the axes|ranges of the \w+, axes=\{.*\}"
                pairs = r"\(\((\S+), (\S+)\), \((\S+), (\S+)\)\)"
                raise OptionError(re.sub(pairs, r"\1:\2 and \3:\4", re.sub(dicts, both, str(problem)))) from None
        if self.orbits is not None:
            boxes = ranges_to_draw(shell, ranges if any(given) else None)
            return RandomPoints(OnSection(shell, boxes), self.orbits, self.seed, edge)
        # Cell centres: the ends of the range are the edge itself.
        axes = [low + (high - low) * (np.arange(n) + 0.5) / n for (low, high), n in zip(ranges, cells)]
        return Cells(shell, axes[0], axes[1], edge)

    @property
    def by_name(self) -> bool:
        """Whether the points are given by coordinates and momenta, or over the whole energy surface."""
        return any(getattr(self, name) for name in BY_NAME)

    def _by_name(self, system: System, section: Any, surface: EnergySurface) -> Launch:
        """Return the launch set of any number of degrees of freedom."""
        for name in ("q_range", "p_range", "grid"):
            if getattr(self, name) is not None:
                raise OptionError.of(
                    "{it} requires a section of a body or of a system of two coordinates. Use {axes} NAME=LOW:HIGH:N.",
                    it=option(name),
                )
        if self.microcanonical and (self.at_rest or self.solve is not None):
            other = option("at_rest" if self.at_rest else "solve")
            raise OptionError(f"give {option('microcanonical')} or {other}, not both")
        if self.microcanonical and self.orbits is None:
            raise OptionError.of("{microcanonical} needs {orbits}, how many are drawn")
        free = not system.conserves
        here = None if free or self.microcanonical or self.at_rest or self.solve is not None else section
        sign = -1 if surface.direction == "-1" and (self.solve is not None) else 1
        given = pairs(option("fixed"), self.fixed or (), "VALUE")
        fixed = {name: number(f"{option('fixed')} {name}", text) for name, text in given}
        others = Others(fixed or None, self.solve, sign, self.at_rest)
        try:
            shell = EnergyShell.of_rows(system, surface.energy, here, surface.p_eta, surface.p_gamma)
            if self.orbits is not None:
                given = pairs(option("axes"), self.axes or (), "LOW:HIGH")
                axes = {name: range_of(f"{option('axes')} {name}", text) for name, text in given} or None
                source = source_of(shell, axes, others)
                return RandomPoints(OfSource(source), self.orbits, self.seed)
            if not self.axes:
                raise OptionError.of(
                    "{axes} NAME=LOW:HIGH:N is required, once for each axis of the grid; or {orbits} N"
                )
            parts = {name: axis_of(name, text) for name, text in pairs(option("axes"), self.axes, "LOW:HIGH:N")}
            fits(option("axes"), *(part.size for part in parts.values()), itemsize=1)
            made = launching(shell, tuple(parts), others)
            return NamedCells(made, tuple(parts.values()))
        except (ValueError, TypeError) as problem:
            text = re.sub(r"axes=\{(.*)\}", flags_of_axes, str(problem))
            raise OptionError(respelled(text, BY_NAME)) from None

    def ranges(self) -> list[Any]:
        """Return the ranges of the coordinate and of the momentum.

        Returns
        -------
        list of tuple
            Ranges, None if not given.
        """
        return [range_of(option(name), getattr(self, name)) for name in ("q_range", "p_range")]


BY_NAME = ("axes", "fixed", "solve", "at_rest", "microcanonical")
"""Options of starts that are given by names, or over the whole energy surface."""


class Launch(Protocol):
    """A launch set: points by number, each where an orbit starts or where the energy allows none.

    Blocks are computed whole: a point has the same bits whichever others are asked for.
    """

    def __hash__(self) -> int:
        """Each is itself."""

    @property
    def edge(self) -> Any:
        """The edge of the section that the energy allows, None where it is not known."""

    @property
    def size(self) -> int:
        """Number of points."""

    @property
    def block(self) -> int:
        """Points that are computed together."""

    def points(self, block: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the phase points (2n, orbits) of a block, and the numbers of their points within it (orbits,)."""

    def placed(self, z0: np.ndarray, place: np.ndarray) -> EnergyGrid | EnergySample | None:
        """Return some of the points, given by z0 (2n, orbits) and their numbers, as figures take them; None where they
        are on no section.
        """


@dataclass(frozen=True, eq=False)
class Cells:
    """A grid of cells over two coordinates of a section, by rows; the energy does not reach all of them."""

    shell: EnergyShell
    first: np.ndarray
    second: np.ndarray
    edge: Any = None

    @property
    def size(self) -> int:
        """Number of cells."""
        return self.first.size * self.second.size

    @property
    def block(self) -> int:
        """Whole rows of cells."""
        return max(1, BLOCK // self.second.size) * self.second.size

    def points(self, block: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the phase points of the cells of some rows that the energy reaches, and their numbers."""
        rows = self.block // self.second.size
        u, v = np.meshgrid(self.first[block * rows : (block + 1) * rows], self.second, indexing="ij")
        z, found, _ = lift(self.shell, u.ravel(), v.ravel())
        return np.ascontiguousarray(z[:, found]), np.flatnonzero(found)

    def placed(self, z0: np.ndarray, place: np.ndarray) -> EnergyGrid:
        """Return some cells; the others count as those that the energy does not reach."""
        names = lift(self.shell, self.first[:1], self.second[:1])[2]
        return grid_of(z0, place, (self.first, self.second), names, self.shell.energy, self.shell.section)


@dataclass(frozen=True, eq=False)
class NamedCells:
    """A grid over coordinates and momenta by name, the last axis first; the energy does not reach all of them."""

    launching: Launching
    axes: tuple[np.ndarray, ...]
    edge: Any = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis."""
        return tuple(axis.size for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(np.prod(self.shape))

    block = BLOCK
    """Cells that are computed together."""

    def points(self, block: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the phase points of the cells of a block that the energy reaches, and their numbers."""
        number = np.arange(block * BLOCK, min((block + 1) * BLOCK, self.size))
        at = np.unravel_index(number, self.shape)
        z, found = self.launching.lift(np.array([axis[k] for axis, k in zip(self.axes, at, strict=True)]))
        return np.ascontiguousarray(z[:, found]), np.flatnonzero(found)

    def placed(self, z0: np.ndarray, place: np.ndarray) -> EnergyGrid | None:
        """Return some cells of a grid of two axes; the others count as those that the energy does not reach."""
        if len(self.axes) != 2:
            return None
        return grid_of(z0, place, self.axes, self.launching.names, self.launching.shell.energy)


@dataclass(frozen=True, eq=False)
class RandomPoints:
    """Random points: those of `energy_sample`, each block of a seed of its own."""

    source: Source
    size: int
    seed: int
    edge: Any = None

    block = BLOCK
    """Points of one seed."""

    def points(self, block: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the phase points of a block."""
        part = block_of(self.source, block, self.size, self.seed)
        return np.ascontiguousarray(part.z0), np.arange(len(part))

    def placed(self, z0: np.ndarray, place: np.ndarray) -> EnergySample:
        """Return some of the points: figures have the first two of what is drawn."""
        blocks = (block_of(self.source, block, self.size, self.seed) for block in range(-(-self.size // BLOCK)))
        found = EnergySample.concat(blocks).take(place)
        return replace(found, points=found.points[:2], names=found.names[:2])


@dataclass(frozen=True, eq=False)
class Points:
    """Phase points (2n, orbits) of one's own."""

    z0: np.ndarray
    edge: Any = None

    @property
    def size(self) -> int:
        """Number of orbits."""
        return self.z0.shape[1]

    block = BLOCK
    """Points that are taken together."""

    def points(self, block: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the phase points of a block."""
        z0 = np.ascontiguousarray(self.z0[:, block * BLOCK : (block + 1) * BLOCK], dtype=np.float64)
        return z0, np.arange(z0.shape[1])

    def placed(self, z0: np.ndarray, place: np.ndarray) -> None:
        """Return None: these points are on no known section."""


def between(launch: Launch, low: int, high: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the phase points (2n, orbits) of the points from `low` to `high` of a launch set, and their numbers from
    `low` on.
    """
    states = []
    places = []
    for block in range(low // launch.block, -(-high // launch.block)):
        z0, number = _points(launch, block)
        number = number + block * launch.block - low
        kept = (number >= 0) & (number < high - low)
        states.append(z0[:, kept])
        places.append(number[kept])
    return np.ascontiguousarray(np.concatenate(states, axis=1)), np.concatenate(places)


@functools.lru_cache(maxsize=4)
def _points(launch: Any, block: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a block, which several chunks may share."""
    return launch.points(block)


def whole(launch: Launch) -> tuple[np.ndarray, np.ndarray]:
    """Return all phase points of a launch set and the numbers of their points; ValueError where memory has no room."""
    rows = launch.points(0)[0].shape[0]
    options = {RandomPoints: option("orbits"), NamedCells: option("axes")}
    fits(options.get(type(launch), option("grid")), 2 * rows, launch.size)
    return between(launch, 0, launch.size)


def some(launch: Launch, count: int) -> np.ndarray:
    """Return the phase points (2n, orbits) of at most `count` orbits, spread over the launch set; at least one.

    Raises NotReached where the energy allows no orbit.
    """
    blocks = -(-launch.size // launch.block)
    few = np.unique(np.linspace(0, blocks - 1, min(blocks, TRIED)).astype(np.int64))
    found = [launch.points(int(block))[0] for block in few]
    rest = (launch.points(block)[0] for block in range(blocks) if block not in few)
    while not any(part.shape[1] for part in found):
        try:
            found.append(next(rest))
        except StopIteration:
            raise NotReached("the energy reaches no point of the launch set: it is below the minimum there") from None
    z0 = np.concatenate(found, axis=1)
    return np.ascontiguousarray(z0[:, np.unique(np.linspace(0, z0.shape[1] - 1, count).astype(np.int64))])
