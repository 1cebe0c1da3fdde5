"""Launch points of a system of any number of degrees of freedom, by the names of its coordinates and momenta: named
rows are given, one row follows from the energy, all others are 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..core.names import did_you_mean, named
from ..core.numbers import flag, kind_of, listed, numbers, real, shown, span
from ..runs.requirements import check_given
from ..systems.models.mechanics import System
from .accessible_box import spread
from .allowed_region import crossings, extrema
from .energy_shell import EnergyShell, NotReached, rest

AT_REST = -1
"""Value for the row that the energy gives: the point is at rest, there is no such row."""

NOTHING = -2
"""Value for the row that the energy gives: there is none."""

BATCH = 4096
"""Points that are tried together: the first ones do not depend on the number asked for."""

FEWEST = 1e-3
"""Least share of valid points among those tried in ranges."""

CHANCE = 3
"""Allowance for chance in this share, in points."""


class Others(NamedTuple):
    """The rows beside the axes: values by name, the row that the energy gives with the sign of its root, or momenta of
    rest.
    """

    fixed: Any = None
    solve: Any = None
    sign: int = 1
    at_rest: Any = False

    @property
    def given(self) -> bool:
        """Whether anything but the sign is given."""
        return self.fixed is not None or self.solve is not None or self.at_rest is not False


NO_OTHERS = Others()


class Launching(NamedTuple):
    """The map from values of some rows to phase points of one energy.

    names: of these values: rows of z, or at rest the angles of a direction; base (2n,): the other rows; row: the one
    that follows from the energy, AT_REST for the distance from base along the direction, NOTHING for a map, which has
    no energy; sign: of the root.
    """

    shell: EnergyShell
    names: tuple[str, ...]
    base: tuple[float, ...]
    row: int
    sign: int

    def lift(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return phase points (2n, points) at values (names, points), and a mask (points,) of those that the energy
        reaches.
        """
        system = self.shell.system
        z = np.repeat(np.array(self.base)[:, None], values.shape[1], axis=1)
        with np.errstate(all="ignore"):
            if self.row == AT_REST:
                n = len(self.base) // 2
                z[:n] += self._rest(values, z)
                z[n:] = rest(system, z[:n])
            else:
                rows = system.row_names
                for name, value in zip(self.names, values, strict=True):
                    z[rows.index(name)] = value
                if self.row == NOTHING:
                    return z, np.isfinite(z).all(axis=0) & system.inside(z)
                z[self.row] = self._solved(z)
            return z, self.shell.contains(z)

    def _rest(self, angles: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the points, relative to z, where rays from z, at rest, first leave the region of the energy."""
        n = len(self.base) // 2
        each = directions(angles)

        def room(r: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            at = spread(z[:, column], r)
            at[:n] += r * spread(each[:, column], r)
            at[n:] = rest(self.shell.system, at[:n])
            return self.shell.left(at)

        column = np.arange(angles.shape[1])
        sheets, _ = crossings(room, extrema(room, column.size), column, np.zeros(column.size), False)
        first = np.isfinite(sheets).sum(axis=0) - 1  # the outermost comes first
        return np.take_along_axis(sheets, np.maximum(first, 0)[None], axis=0)[0] * each

    def _solved(self, z: np.ndarray) -> np.ndarray:
        """Return the row that the energy gives; NaN where it gives none."""
        system = self.shell.system
        n = len(z) // 2
        if self.row < n or not system.quadratic:  # the outermost root, up to which the energy allows motion
            return self.shell.roots_along(z, self.row, self.sign)[0]
        z[self.row] = 0.0
        weight = system.model.kinetic_energy(*np.eye(n)[self.row - n])
        half = system.velocities(z)[self.row - n] / (2 * weight)
        square = half * half + (self.shell.energy - system.energies(z)) / weight
        return self.sign * np.sqrt(np.where(square >= 0, square, np.nan)) - half


def angle_names(n: int) -> tuple[str, ...]:
    """Return the names of the angles of a direction in n dimensions: the last is the azimuth in the first two
    coordinates, those before it are polar angles from the last coordinate, the one before it, ...
    """
    polar = ("theta",) if n == 3 else tuple(f"theta_{k + 1}" for k in range(n - 2))
    return (*polar, "phi")


def directions(angles: np.ndarray) -> np.ndarray:
    """Return unit vectors (n, points) of angles (n - 1, points), in the order of `angle_names`."""
    rows = []
    left = np.ones(angles.shape[1:])
    for angle in angles[:-1]:
        rows.append(left * np.cos(angle))
        left = left * np.sin(angle)
    return np.array([left * np.cos(angles[-1]), left * np.sin(angles[-1]), *rows[::-1]])


def angles_of(unit: np.ndarray) -> np.ndarray:
    """Return the angles (n - 1, points) of vectors (n, points)."""
    n = len(unit)
    polar = [np.arctan2(np.sqrt((unit[: k - 1] ** 2).sum(axis=0)), unit[k - 1]) for k in range(n, 2, -1)]
    return np.array([*polar, np.arctan2(unit[1], unit[0])])


Axes = Mapping[str, ArrayLike] | Sequence[ArrayLike] | Sequence[tuple[str, ArrayLike]]
"""Rows by name, or two section coordinates."""


def by_name(value: Any, _: Any = None) -> Any:
    """Return a mapping as pairs of names and values; return other values as they are."""
    return tuple(value.items()) if isinstance(value, Mapping) else value


def are_named(axes: Any) -> bool:
    """Tell whether axes are pairs of names and values."""
    return isinstance(axes, (tuple, list)) and any(
        isinstance(entry, (tuple, list)) and len(entry) == 2 and isinstance(entry[0], str) for entry in axes
    )


def checked_names(argument: str, value: Any, takes: str, rows: Sequence[str] = ()) -> dict[str, Any]:
    """Return pairs of names and values as a dict; TypeError or ValueError for other values, with a call by `rows`."""
    pairs = by_name(value)
    if not isinstance(pairs, (tuple, list)) or not all(
        isinstance(pair, (tuple, list)) and len(pair) == 2 and isinstance(pair[0], str) for pair in pairs
    ):
        call = f", such as {argument}=dict({', '.join(f'{row}=...' for row in rows[:2])})" if rows else ""
        raise TypeError(f"{argument} must be {takes} by name{call}, got {shown(value)} ({type(value).__name__})")
    names = [name for name, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{argument} names {name} twice")
    return dict(pairs)


def checked_sign(sign: Any) -> int:
    """Return a sign that is +1 or -1."""
    if type(sign) is bool or not isinstance(sign, (int, np.integer)) or sign not in (-1, 1):
        raise ValueError(f"sign must be +1 or -1, got {shown(sign)}")
    return int(sign)


def launching(shell: EnergyShell, names: Any, others: Others) -> Launching:
    """Return the map from values of these names to phase points; TypeError or ValueError for wrong arguments."""
    system = shell.system
    section = shell.section
    fixed = others.fixed
    solve = others.solve
    sign = others.sign
    rows = system.row_names
    n = system.n
    resting = flag("at_rest", others.at_rest)
    check_given(system, "a start by energy", section=section, solve=solve, at_rest=resting or None)
    base = {
        named("fixed", name, rows): real(f"fixed[{name!r}]", value)
        for name, value in checked_names("fixed", () if fixed is None else fixed, "numbers").items()
    }
    if resting:
        return _resting(shell, names, base, solve)
    names = tuple(named("axes", name, rows) for name in names)
    if section is not None:
        name, value, direction = shell.section_row()
        if name in names or name in base:
            raise ValueError(
                f"{name} is given by the section, it must not be in {'axes' if name in names else 'fixed'}"
            )
        base[name] = value
        if solve is None and name in rows[:n]:
            if sign < 0 < direction:
                raise ValueError("sign must be that of the section's direction, +1: give the section direction=-1")
            solve = rows[n + rows.index(name)]
            sign = direction or sign
    for name in names:
        if name in base:
            raise ValueError(f"axes and fixed both name {name}")
        if names.count(name) > 1:
            raise ValueError(f"axes names {name} twice")
    if not system.conserves:
        return Launching(shell, names, tuple(base.get(name, 0.0) for name in rows), NOTHING, sign)
    left = [name for name in rows if name not in names and name not in base]
    if not left:
        raise ValueError("axes and fixed must leave out one row for the energy, got all coordinates and momenta")
    if solve is None:
        raise ValueError(f"solve must name what the energy gives, one of {listed(left)}")
    if not isinstance(solve, str) or solve not in left:
        asked = solve if isinstance(solve, str) else shown(solve)
        raise ValueError(f"solve must be one of {listed(left)}, got {shown(solve)}.{did_you_mean(asked, left)}")
    return Launching(shell, names, tuple(base.get(name, 0.0) for name in rows), rows.index(solve), sign)


def _resting(shell: EnergyShell, names: Any, base: dict[str, float], solve: Any) -> Launching:
    """Return the map from angles to phase points at rest."""
    system = shell.system
    section = shell.section
    rows = system.row_names
    n = system.n
    if n < 2:
        raise ValueError(f"at_rest needs two degrees of freedom or more, {kind_of(system.model)} has {n}")
    if system.nonseparable and not system.ellipsoidal:
        raise ValueError(
            f"at_rest requires H of second degree in the momenta with positive masses, which {kind_of(system.model)} "
            "does not have. Use rows by name."
        )
    if section is not None or solve is not None:
        what = "section" if section is not None else "solve"
        raise ValueError(f"at_rest and {what} exclude one another: at rest the energy gives the distance")
    for name in base:
        if name in rows[n:]:
            raise ValueError(f"fixed must be coordinates, of the point where rays begin, at rest; got {name}")
    angles = angle_names(n)
    names = tuple(named("axes", name, angles) for name in names)
    for angle in angles:
        if names.count(angle) != 1:
            raise ValueError(f"axes at rest must be {listed(angles)}, once each, got {listed(names) or 'none'}")
    order = tuple(base.get(name, 0.0) for name in rows)
    if names != angles:
        raise ValueError(f"axes at rest must come in the order {listed(angles)}, got {listed(names)}")
    return Launching(shell, names, order, AT_REST, 1)


def checked_values(axes: Any, rows: Sequence[str]) -> tuple[tuple[str, ...], tuple[np.ndarray, ...]]:
    """Return names and arrays of axes by name."""
    found = checked_names("axes", axes, "arrays of numbers", rows)
    if not found:
        raise ValueError("axes must name one row at least")
    arrays = []
    for name, value in found.items():
        array = np.atleast_1d(numbers(f"axes[{name!r}]", value)).astype(np.float64)
        if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
            raise ValueError(
                f"axes[{shown(name)}] must be a non-empty, finite, one-dimensional array, got shape {array.shape} in "
                f"{shown(value)}"
            )
        arrays.append(array)
    return tuple(found), tuple(arrays)


def checked_ranges(axes: Any, system: System) -> dict[str, tuple[float, float]]:
    """Return the ranges of axes by name."""
    found = checked_names("axes", axes, "ranges (low, high)", system.row_names)
    return {name: span(f"axes[{name!r}]", ends) for name, ends in found.items()}


class Ranges(NamedTuple):
    """Ranges of rows that are drawn uniformly, with another row from the energy; at rest, directions."""

    launching: Launching
    ranges: tuple[tuple[float, float], ...]

    @property
    def shell(self) -> EnergyShell:
        """The energy surface."""
        return self.launching.shell

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows, or angles, that are drawn."""
        return self.launching.names

    def draw(self, count: int, seed: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return phase points (2n, count) and the drawn values (names, count). Raises NotReached where too few are
        found.
        """
        random = np.random.default_rng(seed)
        kept = 0
        tried = 0
        z = [np.zeros((len(self.launching.base), 0))]
        points = [np.zeros((len(self.names), 0))]
        batch = BATCH if self.ranges else BATCH // 8  # a ray takes some 500 energies
        while kept < count:
            if self.ranges:
                low, high = np.array(self.ranges).T[..., None]
                values = low + (high - low) * random.uniform(size=(len(self.ranges), batch))
            else:
                values = angles_of(random.standard_normal((len(self.names) + 1, batch)))
            lifted, found = self.launching.lift(values)
            z.append(lifted[:, found])
            points.append(values[:, found])
            kept = kept + int(found.sum())
            tried = tried + batch
            if kept + CHANCE < FEWEST * tried:
                what = dict(zip(self.names, self.ranges)) if self.ranges else "directions"
                raise NotReached(
                    f"energy {self.shell.energy:g} reaches less than a thousandth of the {what}: "
                    f"{'narrow the ranges' if self.ranges else 'take another energy, or another point in fixed'}"
                )
        return tuple(np.ascontiguousarray(np.concatenate(part, axis=1)[:, :count]) for part in (z, points))  # type: ignore[return-value]


def ranges_of(shell: EnergyShell, axes: Any, others: Others) -> Ranges:
    """Return a source that draws from ranges of rows, or directions at rest; errors name the wrong argument."""
    system = shell.system
    section = shell.section
    if others.at_rest:
        if axes is not None:
            raise ValueError("axes and at_rest exclude one another: directions are drawn from all")
        names = angle_names(system.n) if system.n > 1 else ()
        return Ranges(launching(shell, names, others), ())
    if axes is None:
        rows = system.row_names
        n = system.n
        given = [*checked_names("fixed", () if others.fixed is None else others.fixed, "numbers")]
        given += [others.solve] if isinstance(others.solve, str) else []
        if section is not None:
            given.append(shell.section_row()[0])
            given += [p for q, p in zip(rows[:n], rows[n:], strict=False) if q == given[-1] and others.solve is None]
        free = next((name for name in rows if name not in given), rows[0])
        raise ValueError(
            "axes must give the ranges to draw from, as nothing else bounds the initial conditions. Try "
            f"axes={{{shown(free)}: (-1, 1)}}."
        )
    ranges = checked_ranges(axes, system)
    if not ranges:
        raise ValueError("axes must name one row at least")
    made = launching(shell, tuple(ranges), others)
    return Ranges(made, tuple(ranges.values()))
