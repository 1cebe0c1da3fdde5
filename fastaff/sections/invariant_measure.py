"""Random points of energy surfaces and sections of any number of degrees of freedom, uniform in the invariant measure.

Over coordinates q the energy allows an ellipsoid of momenta: H = floor(q) + |y|^2/2 with y = L^T (p - p*(q)). The
measure of the energy surface is uniform on that sphere of y, and has the density (E - floor)^(n/2 - 1)/det L in q; that
of dq dp on a section q_i = c is uniform in the ball of the other y, with the density (E - floor)^((n - 1)/2)/det L' of
the block L' of the others. For H(q, p) L depends on q; without such ellipsoids `surface_points` draws.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.names import named
from ..core.numbers import listed, shown, span
from ..systems.models.mechanics import System
from .accessible_box import AccessibleBox, NoWell, box_of_angles, least_within, walled, within
from .energy_limits import NotReached, too_low
from .named_axes import Launching, Others, angle_names, angles_of, checked_names, launching, section_row
from .surface_points import SurfaceMeasure, no_well, surface_of
from .surface_roots import backward, cholesky, forward

BATCH = 4096
"""Points that are tried together: the first ones do not depend on the number asked for."""

FEWEST = 1e-6
"""Least share of valid points among those tried."""

FEWEST_OF_RANGES = 1e-3
"""Least share of valid points among those tried in ranges."""

CHANCE = 3
"""Allowance for chance in both shares, in points."""


class Momenta(NamedTuple):
    """The momenta over coordinates: the coordinates' order, that of a section first, and L of the inverse inertia, None
    where that depends on the coordinates.
    """

    system: System
    order: tuple[int, ...]
    lower: np.ndarray | None

    @classmethod
    def of(cls, system: System, first: int = 0) -> Momenta:
        """Return the momenta of a system whose kinetic energy is quadratic."""
        n = system.n
        order = (first, *(k for k in range(n) if k != first))
        if system.nonseparable:
            return cls(system, order, None)
        inverse = np.array([system.model.velocity(*row) for row in np.eye(n)], dtype=np.float64)[np.ix_(order, order)]
        return cls(system, order, np.linalg.cholesky((inverse + inverse.T) / 2))

    def floor(self, q: np.ndarray) -> np.ndarray:
        """Return the least energy over coordinates q (n, ...), infinite outside the domain of the potential."""
        system = self.system
        z = np.concatenate([q, np.zeros_like(q)])
        if self.lower is None:
            lower, drift, energy = self._here(q)
            z[len(q) + np.array(self.order)] = backward(lower, -drift)
            # H there, not H(q, 0) less the kinetic part: far out that would be a difference of equal numbers.
            here = np.where(np.isnan(energy), energy, system.energies(z))
            energy = np.where(np.isnan(lower).any(axis=(0, 1)), -np.inf, here)
        else:
            drift = self._scaled(system.velocities(z))
            energy = system.energies(z) - (drift**2).sum(axis=0) / 2
        return np.where(system.inside(z) & ~np.isnan(energy), energy, np.inf)

    def lifted(self, q: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return phase points (2n, points) over q (n, points) at y (n, points)."""
        z = np.concatenate([q, np.zeros_like(q)])
        if self.lower is None:
            lower, drift, _ = self._here(q)
            z[len(q) + np.array(self.order)] = backward(lower, y - drift)
            return z
        y = y - self._scaled(self.system.velocities(z))
        z[len(q) + np.array(self.order)] = np.linalg.solve(self.lower.T, y)
        return z

    def reach(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return, for two coordinates (2, ...), the reach of the second momentum to each side at the kinetic energy
        1/2, and its value in the middle.
        """
        lower, drift, _ = self._here(q)
        return 1 / lower[1, 1], -backward(lower, drift)[1]

    def density(self, q: np.ndarray, room: np.ndarray, power: float, sign: int) -> np.ndarray:
        """Return the density of the measure over q (n, ...) with kinetic energy `room`, 0 where there is none."""
        with np.errstate(all="ignore"):
            size = np.where(room > 0, np.abs(room) ** power, np.nan)
            if self.lower is None:
                lower = self._here(q)[0]
                size = size / np.prod([lower[k, k] for k in range(bool(sign), len(lower))], axis=0)
        return np.where(np.isnan(size), 0.0, size)

    def _here(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return L, NaN where the inverse inertia is finite and not positive definite, L^-1 dq/dt and H at p = 0."""
        W, v, energy = self.system.momentum_form(q)
        order = np.array(self.order)
        with np.errstate(all="ignore"):
            known = np.isfinite(W).all(axis=(0, 1))
            lower = cholesky(W[order][:, order])
            return np.where(known, lower, np.inf), forward(lower, v[order]), np.where(known, energy, np.nan)

    def _scaled(self, velocity: np.ndarray) -> np.ndarray:
        assert self.lower is not None
        flat = velocity[list(self.order)].reshape(len(velocity), -1)
        return np.linalg.solve(self.lower, flat).reshape(velocity.shape)


class Measure(NamedTuple):
    """The invariant measure over a box of the free coordinates (d,) of those at (n,).

    sign: of the velocity through a section; 0 for the whole energy surface; heaviest: the largest density, 0 where it
    is that of the least energy in the box; momenta_within: rows of momenta with the ends of their ranges.
    """

    momenta: Momenta
    energy: float
    at: tuple[float, ...]
    free: tuple[int, ...]
    box: AccessibleBox
    sign: int
    heaviest: float = 0.0
    momenta_within: tuple[tuple[int, float, float], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows that are drawn."""
        n = len(self.at)
        rows = self.momenta.system.row_names
        return tuple(rows[k] for half in (0, n) for k in (half + f for f in self.free))

    @property
    def turns(self) -> list[float]:
        """Periods of the free coordinates, 0 where there is none."""
        return [self.momenta.system.periods[k] for k in self.free]

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
            room = self.energy - self.floor(x)
            top = self.energy - box.least
            if self.momenta.lower is None:
                density = self.density(x)
                if density.max() > self.heaviest * (1 + 1e-9):  # once more from the beginning
                    return self._heavier(1.1 * float(density.max())).draw(count, seed)
                good = level * self.heaviest < density
            elif power and room.max() > top * (1 + 1e-9):  # a deeper place: once more from the beginning
                return self._replace(box=box._replace(least=self.energy - float(room.max()))).draw(count, seed)
            else:
                good = room > 0
                if power:
                    good &= level < np.where(good, room / top, 0.0) ** power
            chosen = np.flatnonzero(good)
            if box.leaky and chosen.size:
                chosen = chosen[within(walled(self.floor, self.turns), box, x[:, chosen])]
            z = self.momenta.lifted(self._full(x[:, chosen]), self._on_ball(normal[:, chosen], room[chosen]))
            for row, low, high in self.momenta_within:
                z = z[:, (z[row] >= low) & (z[row] <= high)]
            found.append(z)
            kept = kept + z.shape[1]
            tried = tried + BATCH
            if kept + CHANCE < FEWEST * tried:
                raise NotReached(
                    f"axes must be narrower: energy {self.energy:g} reaches less than a millionth of the ranges of "
                    f"{listed(self.names[: len(self.free)])}"
                )
        z = np.ascontiguousarray(np.concatenate(found, axis=1)[:, :count])
        return z, z[[half + f for half in (0, n) for f in self.free]]

    def density(self, x: np.ndarray) -> np.ndarray:
        """Return the density of the measure over free coordinates x (d, ...)."""
        n = len(self.at)
        power = (n - 1) / 2 if self.sign else n / 2 - 1
        return self.momenta.density(self._full(x), self.energy - self.floor(x), power, self.sign)

    def _heavier(self, density: float) -> Measure:
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


class Ranges(NamedTuple):
    """Ranges of rows that are drawn uniformly, with another row from the energy; at rest, directions."""

    launching: Launching
    ranges: tuple[tuple[float, float], ...]

    @property
    def energy(self) -> float:
        """Energy of all points."""
        return self.launching.energy

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
            if kept + CHANCE < FEWEST_OF_RANGES * tried:
                what = dict(zip(self.names, self.ranges)) if self.ranges else "directions"
                raise NotReached(
                    f"energy {self.launching.energy:g} reaches less than a thousandth of the {what}: "
                    f"{'narrow the ranges' if self.ranges else 'take another energy, or another point in fixed'}"
                )
        return tuple(np.ascontiguousarray(np.concatenate(part, axis=1)[:, :count]) for part in (z, points))  # type: ignore[return-value]


def ranges_of(system: System, energy: float, section: Any, axes: Any, others: Others) -> Ranges:
    """Return a source that draws from ranges of rows, or directions at rest; errors name the wrong argument."""
    if others.at_rest:
        if axes is not None:
            raise ValueError("axes and at_rest exclude one another: directions are drawn from all")
        names = angle_names(system.n) if system.n > 1 else ()
        return Ranges(launching(system, energy, names, section, others), ())
    if axes is None:
        rows = system.row_names
        n = system.n
        given = [*checked_names("fixed", () if others.fixed is None else others.fixed, "numbers")]
        given += [others.solve] if isinstance(others.solve, str) else []
        if section is not None:
            given.append(section_row(system, section)[0])
            given += [p for q, p in zip(rows[:n], rows[n:], strict=False) if q == given[-1] and others.solve is None]
        free = next((name for name in rows if name not in given), rows[0])
        raise ValueError(
            "axes must give the ranges to draw from, as nothing else bounds the initial conditions. Try "
            f"axes={{{shown(free)}: (-1, 1)}}."
        )
    ranges = _ranges(axes, system)
    if not ranges:
        raise ValueError("axes must name one row at least")
    made = launching(system, energy, tuple(ranges), section, others)
    return Ranges(made, tuple(ranges.values()))


def measure_of(system: System, energy: float, section: Any, axes: Any) -> Measure | SurfaceMeasure:
    """Return the invariant measure of an energy surface (section None) or of a section; raises NotReached if the energy
    reaches no point, ValueError if the region is unbounded.
    """
    n = system.n
    names = system.names
    if n < 2:
        raise ValueError(
            f"model must have two degrees of freedom or more, got {n}. Use fa.integrate with samples: the energy "
            "surface is one orbit."
        )
    given = {} if axes is None else _ranges(axes, system)
    if not system.ellipsoidal:
        return surface_of(system, energy, section, given)
    at = [0.0] * n
    free = list(range(n))
    sign = 0
    first = 0
    if section is not None:
        name, value, sign = section_row(system, section)
        if name not in names:
            raise TypeError(f"section must be on a coordinate such as {names[0]}=0 for random points, got {name}")
        first = names.index(name)
        sign = sign or 1
        at[first] = value
        free.remove(first)
    nothing = AccessibleBox(np.zeros(1), np.zeros(1), 0.0, False)
    made = Measure(Momenta.of(system, first), energy, tuple(at), tuple(free), nothing, sign)
    ends = {system.row_names.index(named("axes", name, made.names)): both for name, both in given.items()}
    momenta = tuple((row, *both) for row, both in ends.items() if row >= n)
    made = made._replace(box=_box(made, {k: both for k, both in ends.items() if k < n}), momenta_within=momenta)
    if made.momenta.lower is None:
        made = made._heavier(-least_within(lambda x: -made.density(x), made.box.low, made.box.high))
    return made


def _ranges(axes: Any, system: System) -> dict[str, tuple[float, float]]:
    found = checked_names("axes", axes, "ranges (low, high)", system.row_names)
    return {name: span(f"axes[{name!r}]", ends) for name, ends in found.items()}


def _box(measure: Measure, given: dict[int, tuple[float, float]]) -> AccessibleBox:
    """Return the box to draw from: the ranges given, those found where they are left open."""
    system = measure.momenta.system
    energy = measure.energy
    if len(given) == len(measure.free):
        low, high = np.array([given[k] for k in measure.free]).T
    else:
        try:
            box = box_of_angles(measure.floor, measure.turns, energy)
        except NoWell as problem:
            names = tuple(system.names[k] for k in measure.free)
            raise no_well(system, energy, problem, names, measure.sign != 0) from None
        if not given:
            return box
        low, high = box.low.copy(), box.high.copy()
        for place, k in enumerate(measure.free):
            if k in given:
                low[place], high[place] = given[k]
    least = least_within(measure.floor, low, high)
    if not least < energy:
        raise NotReached(
            (None if system.isotropic else too_low(system, energy, 0.0, 0.0))
            or f"energy must be at least {least:.6g}, the least in the ranges of the axes, got {energy:g}"
        )
    if not np.isfinite(least):
        raise ValueError(
            f"axes must leave out where the potential of {type(system.model).__name__} is not bounded below"
        )
    return AccessibleBox(low, high, least, False)
