"""Random points of the energy surface of any H(q, p), and of its sections, uniform in the invariant measure.

A line along one of the rows, drawn evenly over the box of all others, meets the surface H = E at points whose density
on the surface is the share of its normal along that row. Over all rows, in units of the box, that is |grad H|_1 with
regard to the measure delta(H - E) dq dp: points are taken with the probability least |grad H|_1/|grad H|_1. On a
section q_i = c lines along p_i alone, over the box of the other rows, give dq dp as it is.

Source of the idea: Crofton's formula (Santalo 1976, Integral Geometry and Geometric Probability, section 14.4).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.names import named
from ..core.numbers import listed
from ..systems.models.mechanics import System
from .accessible_box import AccessibleBox, NoWell, box_of_angles, spread, walled, within
from .allowed_region import crossings, extrema
from .energy_limits import NotReached, may_escape
from .named_axes import on_surface, section_row
from .surface_roots import left

LINES = 1024
"""Lines that are tried together: the first points do not depend on the number asked for."""

NODES = 128
"""Parts of a range between which extrema of H along a line are sought."""

FEWEST = 1e-4
"""Least share of the lines that give a point."""

CHANCE = 3
"""Allowance for chance, in points."""


class SurfaceMeasure(NamedTuple):
    """The invariant measure of an energy surface over a box of the free rows (d,) of those at (2n,), or of a section;
    the momentum `along` of a section follows from the energy, with a velocity of the sign.

    heaviest: the largest 1/|grad H|_1 met; sheets: the most points on a line met.
    """

    system: System
    energy: float
    at: tuple[float, ...]
    free: tuple[int, ...]
    box: AccessibleBox
    along: int | None = None
    sign: int = 0
    heaviest: float = 0.0
    sheets: int = 1

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the drawn rows; for a section without its momentum."""
        names = self.system.row_names
        return tuple(names[k] for k in self.free if k != self.along)

    @property
    def turns(self) -> list[float]:
        """Periods of the free rows, 0 where there is none."""
        periods = self.system.periods
        n = len(self.at) // 2
        return [periods[k] if k < n else 0.0 for k in self.free]

    def draw(self, count: int, seed: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return phase points (2n, count) and their rows of the names. Raises NotReached where too few are found."""
        random = np.random.default_rng(seed)
        parts = [np.zeros((len(self.at), 0))]
        kept = 0
        tried = 0
        while kept < count:
            line, places = self._lines(random)
            z, found = self._met(line, places)
            weight = self._weights(z)
            most = int(found.sum(axis=0).max(initial=0))
            heaviest = float(weight[found].max(initial=0.0))
            if most > self.sheets or heaviest > self.heaviest:  # once more from the beginning
                heavier = 1.1 * heaviest if heaviest > self.heaviest else self.heaviest
                return self._replace(sheets=max(most, self.sheets), heaviest=heavier).draw(count, seed)
            number = random.integers(self.sheets, size=line.size)
            level = random.uniform(size=line.size)
            sheet = np.argmax(np.cumsum(found, axis=0) == number + 1, axis=0)
            column = np.flatnonzero(found.sum(axis=0) > number)
            chosen = z[:, sheet[column], column]
            chosen = chosen[:, level[column] * self.heaviest < weight[sheet[column], column]]
            if self.box.leaky and chosen.size:
                chosen = chosen[:, within(walled(self._floor, self.turns), self.box, chosen[list(self.free)])]
            parts.append(chosen)
            kept = kept + chosen.shape[1]
            tried = tried + line.size
            if kept + CHANCE < FEWEST * tried:
                raise NotReached(
                    f"axes must be narrower: energy {self.energy:g} reaches less than {FEWEST:g} of the ranges of "
                    f"{listed(self.names)}"
                )
        z = np.ascontiguousarray(np.concatenate(parts, axis=1)[:, :count])
        return z, z[[k for k in self.free if k != self.along]]

    def _lines(self, random: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return numbers of free rows (lines,) that lines go along, and points (2n, lines) of them."""
        low, high = self.box.low[:, None], self.box.high[:, None]
        places = np.repeat(np.array(self.at)[:, None], LINES, axis=1)
        places[list(self.free)] = low + (high - low) * random.uniform(size=(len(self.free), LINES))
        if self.along is not None:
            return np.full(LINES, self.free.index(self.along)), places
        return random.integers(len(self.free), size=LINES), places

    def _met(self, line: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the points (2n, sheets, lines) at which lines meet the surface, and a mask of those that exist."""
        row = np.array(self.free)[line]
        low = self.box.low[line]
        width = (self.box.high - self.box.low)[line]
        every = np.arange(line.size)

        def at(t: np.ndarray, column: np.ndarray) -> np.ndarray:
            z = spread(places[:, column], t)
            there = np.broadcast_to(row[column], t.shape)
            np.put_along_axis(z, there[None], (low[column] + width[column] * t)[None], axis=0)
            return z

        def room(t: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return left(self.system, self.energy, at(t, column))

        turns = extrema(room, line.size, np.linspace(0.0, 1.0, NODES + 1))
        level = np.zeros(line.size)
        sides = [crossings(room, turns, every, level, up)[0] for up in (False, True)]
        t = np.concatenate(sides)
        with np.errstate(all="ignore"):
            z = at(t, every)
            found = np.isfinite(t) & on_surface(self.system, z.reshape(len(z), -1), self.energy).reshape(t.shape)
            if self.sign:
                n = len(self.at) // 2
                found &= self.system.slopes(z)[self.along - n] * self.sign > 0  # type: ignore[operator]
        return z, found

    def _weights(self, z: np.ndarray) -> np.ndarray:
        """Return 1/|grad H|_1 (...) in units of the box, 1 on a section."""
        if self.along is not None:
            return np.ones(z.shape[1:])
        n = len(z) // 2
        width = (self.box.high - self.box.low).reshape(-1, *[1] * (z.ndim - 1))
        with np.errstate(all="ignore"):
            steep = np.roll(np.abs(self.system.slopes(z)), n, axis=0)  # dH/dq of dp/dt, dH/dp of dq/dt
            return 1 / (steep * width).sum(axis=0)

    def _floor(self, x: np.ndarray) -> np.ndarray:
        """Return H over the free rows x (d, ...), infinite outside its domain."""
        system = self.system
        z = np.empty((len(self.at), *x.shape[1:]))
        z[...] = np.reshape(self.at, (-1, *[1] * (x.ndim - 1)))
        z[list(self.free)] = x
        energy = system.energies(z)
        return np.where(system.inside(z) & ~np.isnan(energy), energy, np.inf)


def surface_of(
    system: System, energy: float, section: Any, given: dict[str, tuple[float, float]] | None
) -> SurfaceMeasure:
    """Return the invariant measure of an energy surface (section None) or of a section, over ranges of rows by name,
    others bounded by the energy; raises NotReached if it reaches no point, ValueError if the region is unbounded.
    """
    rows = system.row_names
    n = system.n
    at = [0.0] * (2 * n)
    along = None
    sign = 0
    fixed = -1
    if section is not None:
        name, value, sign = section_row(system, section)
        fixed = rows.index(name)
        if fixed >= n:
            raise TypeError(f"section must be on a coordinate such as {rows[0]}=0 for random points, got {name}")
        at[fixed] = value
        along = n + fixed
        sign = sign or 1
    free = tuple(k for k in range(2 * n) if k != fixed)
    for name in given or {}:
        named("axes", name, [rows[k] for k in free])
    made = SurfaceMeasure(
        system, energy, tuple(at), free, AccessibleBox(np.zeros(1), np.zeros(1), 0.0, False), along, sign
    )
    names = tuple(rows[k] for k in free)
    ends = dict(given or {})
    if len(ends) == len(free):
        low, high = np.array([ends[name] for name in names]).T
        return made._replace(box=AccessibleBox(low, high, 0.0, False))
    try:
        box = box_of_angles(made._floor, made.turns, energy)
    except NoWell as problem:
        raise no_well(system, energy, problem, names, section is not None) from None
    if ends:
        low, high = (
            np.array([ends.get(name, both)[k] for name, both in zip(names, zip(box.low, box.high))]) for k in (0, 1)
        )
        box = AccessibleBox(low, high, 0.0, False)
    return made._replace(box=box)


def no_well(system: System, energy: float, problem: NoWell, names: tuple[str, ...], on_section: bool) -> ValueError:
    """Return the error for an energy that reaches no bounded region of the rows of these names."""
    least = problem.least
    if energy <= least:
        where = " on the section" if on_section else ""
        return NotReached(f"energy must be at least the minimum {least:.6g} of this system{where}, got {energy:g}")
    if problem.endless:
        why = f"what energy {energy:g} allows falls apart into wells without end"
    else:
        escape = None if system.isotropic else may_escape(system, energy)
        why = escape or f"energy {energy:g} does not bound the motion"
    ranges = ", ".join(f'"{name}": (low, high)' for name in names)
    rows = system.row_names
    n = system.n
    what = "coordinates" if len(names) <= n else "rows"
    across = [p for q, p in zip(rows[:n], rows[n:], strict=True) if on_section and p in names and q not in names]
    instead = f", or solve={across[0]!r} with ranges of the others" if across else ""
    return ValueError(f"{why}: give ranges of the {what}, axes={{{ranges}}}{instead}")
