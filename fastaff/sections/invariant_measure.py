"""Random points of energy surfaces and sections of any number of degrees of freedom, uniform in the invariant measure.

Over coordinates q the energy allows an ellipsoid of momenta: H = floor(q) + |y|^2/2 with y = L^T (p - p*(q)). The
measure of the energy surface is uniform on that sphere of y, and has the density (E - floor)^(n/2 - 1)/det L in q; that
of dq dp on a section q_i = c is uniform in the ball of the other y, with the density (E - floor)^((n - 1)/2)/det L' of
the block L' of the others. For H(q, p) L depends on q.

Without such ellipsoids lines are drawn. A line along one of the rows, evenly over the box of all others, meets the
surface H = E at points whose density on the surface is the share of its normal along that row. Over all rows, in units
of the box, that is |grad H|_1 with regard to the measure delta(H - E) dq dp: points are taken with the probability
least |grad H|_1/|grad H|_1. On a section q_i = c lines along p_i alone, over the box of the other rows, give dq dp as
it is.
Source of the idea: Crofton's formula (Santalo 1976, Integral Geometry and Geometric Probability, section 14.4).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..core.descent import Floor
from ..core.names import named
from ..core.numbers import listed
from ..systems.models.mechanics import System
from .accessible_box import AccessibleBox, NoWell, box_of_angles, falls_below, least_within, spread, walled, within
from .allowed_region import crossings, extrema
from .energy_shell import EnergyShell, Momenta, NotReached, may_escape, too_low
from .named_axes import CHANCE, checked_ranges

BATCH = 4096
"""Places that are tried together: the first points do not depend on the number asked for."""

FEWEST_PLACES = 1e-6
"""Least share of valid points among the places tried."""

LINES = 1024
"""Lines that are tried together: the first points do not depend on the number asked for."""

NODES = 128
"""Parts of a range between which extrema of H along a line are sought."""

FEWEST_LINES = 1e-4
"""Least share of the lines that give a point."""

NOTHING = AccessibleBox(np.zeros(1), np.zeros(1), 0.0, False)
"""Box of a measure that is still to be bounded."""


def measure_of(shell: EnergyShell, axes: Any) -> EllipsoidMeasure | LineMeasure:
    """Return the invariant measure of an energy surface or of a section, over ranges of axes by name; raises NotReached
    if the energy reaches no point, ValueError if the region is unbounded.
    """
    system = shell.system
    if system.n < 2:
        raise ValueError(
            f"model must have two degrees of freedom or more, got {system.n}. Use fa.integrate with samples: the "
            "energy surface is one orbit."
        )
    given = {} if axes is None else checked_ranges(axes, system)
    if system.ellipsoidal:
        return EllipsoidMeasure.of(shell, given)
    return LineMeasure.of(shell, given)


class EllipsoidMeasure(NamedTuple):
    """The invariant measure over a box of the free coordinates (d,) of those at (n,), by ellipsoids of momenta.

    sign: of the velocity through a section; 0 for the whole energy surface; heaviest: the largest density, 0 where it
    is that of the least energy in the box; momenta_within: rows of momenta with the ends of their ranges.
    """

    shell: EnergyShell
    momenta: Momenta
    at: tuple[float, ...]
    free: tuple[int, ...]
    box: AccessibleBox
    sign: int
    heaviest: float = 0.0
    momenta_within: tuple[tuple[int, float, float], ...] = ()

    @classmethod
    def of(cls, shell: EnergyShell, given: dict[str, tuple[float, float]]) -> EllipsoidMeasure:
        """Return the measure over ranges of rows by name, others bounded by the energy."""
        system = shell.system
        n = system.n
        first, value, sign = _fixed(shell)
        at = [0.0] * n
        free = list(range(n))
        if shell.section is not None:
            at[first] = value
            free.remove(first)
        made = cls(shell, Momenta.of(system, first), tuple(at), tuple(free), NOTHING, sign)
        ends = {system.row_names.index(named("axes", name, made.names)): both for name, both in given.items()}
        momenta = tuple((row, *both) for row, both in ends.items() if row >= n)
        box = bounded(shell, made.floor, free, {k: both for k, both in ends.items() if k < n})
        if len(momenta) < len(ends):
            box = made._lowest(box)
        made = made._replace(box=box, momenta_within=momenta)
        if made.momenta.lower is None:
            made = made._heavier(-least_within(lambda x: -made.density(x), box.low, box.high))
        return made

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows that are drawn."""
        n = len(self.at)
        rows = self.shell.system.row_names
        return tuple(rows[k] for half in (0, n) for k in (half + f for f in self.free))

    def floor(self, x: np.ndarray) -> np.ndarray:
        """Return the least energy over free coordinates x (d, ...)."""
        return self.momenta.floor(self._full(x))

    def draw(self, count: int, seed: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return phase points (2n, count) and their rows of the names. Raises NotReached where too few are found."""
        n = len(self.at)
        d = len(self.free)
        power = (n - 1) / 2 if self.sign else n / 2 - 1
        random = np.random.default_rng(seed)
        found = [np.zeros((2 * n, 0))]
        kept = 0
        tried = 0
        box = self.box
        while kept < count:
            x = box.low[:, None] + (box.high - box.low)[:, None] * random.uniform(size=(d, BATCH))
            level = random.uniform(size=BATCH)
            normal = random.standard_normal((n + 1 if self.sign else n, BATCH))
            room = self.shell.energy - self.floor(x)
            top = self.shell.energy - box.least
            if self.momenta.lower is None:
                density = self.density(x)
                if density.max() > self.heaviest * (1 + 1e-9):  # once more from the beginning
                    return self._heavier(1.1 * float(density.max())).draw(count, seed)
                good = level * self.heaviest < density
            elif power and room.max() > top * (1 + 1e-9):  # a deeper place: once more from the beginning
                return self._replace(box=box._replace(least=self.shell.energy - float(room.max()))).draw(count, seed)
            else:
                good = room > 0
                if power:
                    good &= level < np.where(good, room / top, 0.0) ** power
            chosen = np.flatnonzero(good)
            if box.leaky and chosen.size:
                chosen = chosen[within(walled(self.floor, periods_of(self.shell.system, self.free)), box, x[:, chosen])]
            z = self.momenta.lifted(self._full(x[:, chosen]), self._on_ball(normal[:, chosen], room[chosen]))
            for row, low, high in self.momenta_within:
                z = z[:, (z[row] >= low) & (z[row] <= high)]
            found.append(z)
            kept = kept + z.shape[1]
            tried = tried + BATCH
            if kept + CHANCE < FEWEST_PLACES * tried:
                raise NotReached(
                    f"axes must be narrower: energy {self.shell.energy:g} reaches less than a millionth of the ranges "
                    f"of {listed(self.names[: len(self.free)])}"
                )
        z = np.ascontiguousarray(np.concatenate(found, axis=1)[:, :count])
        return z, z[[half + f for half in (0, n) for f in self.free]]

    def density(self, x: np.ndarray) -> np.ndarray:
        """Return the density of the measure over free coordinates x (d, ...)."""
        n = len(self.at)
        power = (n - 1) / 2 if self.sign else n / 2 - 1
        return self.momenta.density(self._full(x), self.shell.energy - self.floor(x), power, self.sign)

    def _heavier(self, density: float) -> EllipsoidMeasure:
        if not np.isfinite(density):
            raise ValueError("axes must leave out points where the masses are not positive and bounded")
        return self._replace(heaviest=density)

    def _on_ball(self, normal: np.ndarray, room: np.ndarray) -> np.ndarray:
        """Return y (n, points) with |y|^2/2 = room: on the sphere, or uniform in the ball of all but the first."""
        radius = np.sqrt(2 * room)
        unit = normal / np.sqrt((normal**2).sum(axis=0))
        if not self.sign:
            return radius * unit
        inner = radius * unit[2:]  # of a sphere of two dimensions more, all but two rows are uniform in a ball
        return np.concatenate([self.sign * np.sqrt(np.maximum(radius**2 - (inner**2).sum(axis=0), 0.0))[None], inner])

    def _full(self, x: np.ndarray) -> np.ndarray:
        q = np.empty((len(self.at), *x.shape[1:]))
        q[...] = np.reshape(self.at, (-1, *[1] * (x.ndim - 1)))
        q[list(self.free)] = x
        return q

    def _lowest(self, box: AccessibleBox) -> AccessibleBox:
        """Return ranges that are given, in part at least, with the least energy over them."""
        system, energy = self.shell[:2]
        least = least_within(self.floor, box.low, box.high)
        if not least < energy:
            raise NotReached(
                (None if system.isotropic else too_low(system, energy, 0.0, 0.0))
                or f"energy must be at least {least:.6g}, the least in the ranges of the axes, got {energy:g}"
            )
        if not np.isfinite(least):
            raise ValueError(
                f"axes must leave out where the potential of {type(system.model).__name__} is not bounded below"
            )
        return box._replace(least=least)


class LineMeasure(NamedTuple):
    """The invariant measure over a box of the free rows (d,) of those at (2n,), by lines; the momentum `along` of a
    section follows from the energy, with a velocity of the sign.

    heaviest: the largest 1/|grad H|_1 met; sheets: the most points on a line met.
    """

    shell: EnergyShell
    at: tuple[float, ...]
    free: tuple[int, ...]
    box: AccessibleBox
    along: int | None = None
    sign: int = 0
    heaviest: float = 0.0
    sheets: int = 1

    @classmethod
    def of(cls, shell: EnergyShell, given: dict[str, tuple[float, float]]) -> LineMeasure:
        """Return the measure over ranges of rows by name, others bounded by the energy."""
        system = shell.system
        rows = system.row_names
        fixed, value, sign = _fixed(shell)
        at = [0.0] * len(rows)
        free = tuple(range(len(rows)))
        along = None
        if shell.section is not None:
            at[fixed] = value
            free = tuple(k for k in free if k != fixed)
            along = system.n + fixed
        made = cls(shell, tuple(at), free, NOTHING, along, sign)
        names = [rows[k] for k in free]
        ends = {rows.index(named("axes", name, names)): both for name, both in given.items()}
        return made._replace(box=bounded(shell, made.floor, free, ends))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the drawn rows; for a section without its momentum."""
        names = self.shell.system.row_names
        return tuple(names[k] for k in self.free if k != self.along)

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
                chosen = chosen[
                    :,
                    within(
                        walled(self.floor, periods_of(self.shell.system, self.free)), self.box, chosen[list(self.free)]
                    ),
                ]
            parts.append(chosen)
            kept = kept + chosen.shape[1]
            tried = tried + line.size
            if kept + CHANCE < FEWEST_LINES * tried:
                raise NotReached(
                    f"axes must be narrower: energy {self.shell.energy:g} reaches less than {FEWEST_LINES:g} of the "
                    f"ranges of {listed(self.names)}"
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
            return self.shell.left(at(t, column))

        turns = extrema(room, line.size, np.linspace(0.0, 1.0, NODES + 1))
        level = np.zeros(line.size)
        sides = [crossings(room, turns, every, level, up)[0] for up in (False, True)]
        t = np.concatenate(sides)
        with np.errstate(all="ignore"):
            z = at(t, every)
            found = np.isfinite(t) & self.shell.contains(z.reshape(len(z), -1)).reshape(t.shape)
            if self.sign:
                n = len(self.at) // 2
                found &= self.shell.system.slopes(z)[self.along - n] * self.sign > 0  # type: ignore[operator]
        return z, found

    def _weights(self, z: np.ndarray) -> np.ndarray:
        """Return 1/|grad H|_1 (...) in units of the box, 1 on a section."""
        if self.along is not None:
            return np.ones(z.shape[1:])
        n = len(z) // 2
        width = (self.box.high - self.box.low).reshape(-1, *[1] * (z.ndim - 1))
        with np.errstate(all="ignore"):
            steep = np.roll(np.abs(self.shell.system.slopes(z)), n, axis=0)  # dH/dq of dp/dt, dH/dp of dq/dt
            return 1 / (steep * width).sum(axis=0)

    def floor(self, x: np.ndarray) -> np.ndarray:
        """Return H over the free rows x (d, ...), infinite outside its domain."""
        system = self.shell.system
        z = np.empty((len(self.at), *x.shape[1:]))
        z[...] = np.reshape(self.at, (-1, *[1] * (x.ndim - 1)))
        z[list(self.free)] = x
        energy = system.energies(z)
        return np.where(system.inside(z) & ~np.isnan(energy), energy, np.inf)


def _fixed(shell: EnergyShell) -> tuple[int, float, int]:
    """Return the coordinate that the section fixes, its value and the sign of its rate, + for both; (0, 0.0, 0) without
    a section.
    """
    if shell.section is None:
        return 0, 0.0, 0
    i, value, sign = shell.section_coordinate()
    return i, value, sign or 1


def periods_of(system: System, rows: Sequence[int]) -> list[float]:
    """Return the periods of rows of phase points, 0 where there is none."""
    return [system.periods[k] if k < system.n else 0.0 for k in rows]


def bounded(
    shell: EnergyShell, floor: Floor, rows: Sequence[int], given: dict[int, tuple[float, float]]
) -> AccessibleBox:
    """Return the box of rows to draw from: the ranges given, those found where they are left open."""
    if len(given) == len(rows):
        low, high = np.array([given[k] for k in rows]).T
        return AccessibleBox(low, high, 0.0, False)
    try:
        box = box_of_angles(floor, periods_of(shell.system, rows), shell.energy)
    except NoWell as problem:
        raise no_well(shell, floor, problem, tuple(shell.system.row_names[k] for k in rows)) from None
    if not given:
        return box
    low, high = box.low.copy(), box.high.copy()
    for place, k in enumerate(rows):
        if k in given:
            low[place], high[place] = given[k]
    return AccessibleBox(low, high, 0.0, False)


def no_well(shell: EnergyShell, floor: Floor, problem: NoWell, names: tuple[str, ...]) -> ValueError:
    """Return the error for an energy that reaches no bounded region of the rows of these names."""
    system, energy = shell[:2]
    on_section = shell.section is not None
    least = problem.least
    if energy <= least:
        where = " on the section" if on_section else ""
        kind = "local minimum" if falls_below(floor, len(names), least) else "minimum"
        return NotReached(f"energy must be at least the {kind} {least:.6g} of this system{where}, got {energy:g}")
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
