"""The chart as a value: points, velocities and momenta both ways, metric, density and kinetic energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array, at_orbit, checked, first
from ...core.numbers import positive
from .metrics import Form
from .steps import Step


class Chart(NamedTuple):
    """Hold one coordinate system of GL(2,R) as a value: `ALPHA_BETA.from_planes(z)`.

    name: the chart in words. names: its four coordinates, in row order; `momenta`: the names of their momenta. steps:
    the chain that leads from the planes to the chart. rows: the row of each coordinate in the last step. form: the
    paper's line element, as a function of the four coordinates. singular: the singular set, in words. Its methods take
    arrays (4, ...) of coordinates, or (8, ...) with velocities or momenta below them, of any trailing shape; angles in
    radians, lengths in the units of phi. Each raises TypeError or ValueError for values other than such rows of finite
    real numbers, and ValueError that names the singular set and the orbit where a result does not exist.

    :Source: section 3, section 7; the label of each chart is given with its line element in `fastaff.charts.metrics`.
    """

    name: str
    names: tuple[str, str, str, str]
    steps: tuple[Step, ...]
    rows: tuple[int, int, int, int]
    form: Callable[[Array, Array, Array, Array], Form]
    singular: str

    def __repr__(self) -> str:
        return f"<Chart {self.name}: {', '.join(self.names)}>"

    @property
    def momenta(self) -> tuple[str, ...]:
        """The names of the four conjugate momenta."""
        return tuple(f"p_{name}" for name in self.names)

    def from_planes(self, z: ArrayLike) -> Array:
        """Convert phase points z (8, ...), planes and momenta, to coordinates and conjugate momenta (8, ...).

        :Formula: p_q = J^T p.
        :Source: section 3 (the coordinates); the momenta are derived.
        """
        x, p = np.split(checked("z", z, (8,)), 2)
        with np.errstate(all="ignore"):
            for step in self.steps:
                y = step.invert(x, p)
                p = step.pull(x, y, p)
                x = y
        self._refuse("z", x[list(self.rows)], np.isfinite)
        self._refuse("z", p[list(self.rows)], lambda rows: ~np.isnan(rows), "p_")
        return np.concatenate([x[list(self.rows)], p[list(self.rows)]])

    def to_planes(self, q: ArrayLike) -> Array:
        """Convert coordinates and conjugate momenta q (8, ...) of any sheet to phase points (8, ...).

        :Formula: p = J^-T p_q.
        :Source: section 3 (the coordinates); the momenta are derived.
        """
        rows = checked("q", q, (8,))
        p = self._row_order(rows[4:])
        ladder, planes = self._ladder(rows[:4])
        with np.errstate(all="ignore"):
            for step, _, y in ladder:
                p = step.unpull(y, p)
        return self._defined("q", np.concatenate([planes, p]), rows)

    def points_from_planes(self, planes: ArrayLike) -> Array:
        """Convert planes a1, a2, b1, b2 (4, ...) to coordinates (4, ...); an undefined angle is 0."""
        x = checked("planes", planes, (4,))
        return self.from_planes(np.concatenate([x, np.zeros_like(x)]))[:4]

    def points_to_planes(self, q: ArrayLike) -> Array:
        """Convert coordinates (4, ...) of any sheet to planes a1, a2, b1, b2 (4, ...)."""
        rows = checked("q", q, (4,))
        return self._defined("q", self._ladder(rows)[1], rows)

    def velocities_from_planes(self, w: ArrayLike) -> Array:
        """Convert planes and their velocities w (8, ...) to coordinates and their velocities (8, ...).

        Where a radius is 0, the angle is that of the velocity, and its rate is 0: the limit along the straight motion.

        :Formula: dq/dt = J^-1 v.
        :Source: EQ2.0a, EQ2.0b.
        """
        given = checked("w", w, (8,))
        x, v = np.split(given, 2)
        with np.errstate(all="ignore"):
            for step in self.steps:
                y = step.invert(x, v)
                v = step.unpush(x, y, v)
                x = y
        return self._defined("w", np.concatenate([x[list(self.rows)], v[list(self.rows)]]), given)

    def velocities_to_planes(self, q: ArrayLike) -> Array:
        """Convert coordinates and their velocities q (8, ...) to planes and their velocities (8, ...).

        :Formula: v = J dq/dt.
        :Source: EQ2.0a, EQ2.0b.
        """
        rows = checked("q", q, (8,))
        planes, v = self._pushed(rows[:4], rows[4:])
        return self._defined("q", np.concatenate([planes, v]), rows)

    def momenta_from_velocities(self, q: ArrayLike, mu: float = 1.0) -> Array:
        """Convert coordinates and velocities q (8, ...) to coordinates and momenta, the Legendre transformation of T.

        mu: the inertia, > 0.

        :Formula: p = mu J^T J dq/dt, regular in every sheet.
        :Source: EQ2.1a.
        """
        rows = checked("q", q, (8,))
        mass = positive("mu", mu)
        ladder, _ = self._ladder(rows[:4])
        p = mass * self._pushed(rows[:4], rows[4:])[1]
        with np.errstate(all="ignore"):
            for step, x, y in reversed(ladder):
                p = step.pull(x, y, p)
        return self._defined("q", np.concatenate([rows[:4], p[list(self.rows)]]), rows)

    def velocities_from_momenta(self, q: ArrayLike, mu: float = 1.0) -> Array:
        """Convert coordinates and momenta q (8, ...) to coordinates and velocities, the inverse Legendre
        transformation.

        mu: the inertia, > 0.

        :Formula: dq/dt = J^-1 J^-T p/mu; the rate is 0 where a radius and its angular momentum are 0.
        :Source: EQ2.1a.
        """
        rows = checked("q", q, (8,))
        mass = positive("mu", mu)
        ladder, _ = self._ladder(rows[:4])
        v = self.to_planes(rows)[4:] / mass
        with np.errstate(all="ignore"):
            for step, x, y in reversed(ladder):
                v = step.unpush(x, y, v)
        return self._defined("q", np.concatenate([rows[:4], v[list(self.rows)]]), rows)

    def jacobian(self, q: ArrayLike) -> Array:
        """Compute J (4, 4, ...) = d(a1, a2, b1, b2)/dq at coordinates q (4, ...), column by column along the chain."""
        rows = checked("q", q, (4,))
        units = np.broadcast_to(np.eye(4).reshape(4, 4, *(1,) * (rows.ndim - 1)), (4, 4, *rows.shape[1:]))
        return self._defined("q", self._pushed(rows, units)[1], rows, skip=2)

    def metric(self, q: ArrayLike) -> Array:
        """Compute the metric g_ij (4, 4, ...) of ds^2 = Tr(dphi^T dphi) at coordinates q (4, ...), the paper's formula.

        :Source: EQ6.1, and the label of the chart's line element.
        """
        rows = checked("q", q, (4,))
        self._ladder(rows)
        with np.errstate(all="ignore"):
            return self._defined("q", self.form(*rows).tensor(), rows, skip=2)

    def inverse_metric(self, q: ArrayLike) -> Array:
        """Compute g^ij (4, 4, ...), the quadratic form 2 mu T of the momenta, at coordinates q (4, ...) where density >
        0.

        :Formula: J^-1 J^-T.
        :Source: EQ2.1a, EQ2.2f.
        """
        rows = checked("q", q, (4,))
        ladder, _ = self._ladder(rows)
        p: Array = np.array(np.broadcast_to(np.eye(4).reshape(4, 4, *(1,) * (rows.ndim - 1)), (4, 4, *rows.shape[1:])))
        p = self._row_order(p)
        density = self.density(rows)
        self._defined("q", np.where(density > 0, density, np.inf), rows, skip=0)
        with np.errstate(all="ignore"):
            for step, _, y in ladder:
                p = step.unpull(y, p)
            return self._defined("q", np.einsum("ki...,kj...->ij...", p, p), rows, skip=2)

    def density(self, q: ArrayLike) -> Array:
        """Compute sqrt|g| (...), the volume element of the chart, at coordinates q (4, ...): the paper's formula, >= 0.

        :Source: section 5, the measure; derived for the charts that section does not use.
        """
        rows = checked("q", q, (4,))
        with np.errstate(all="ignore"):
            return self._defined("q", np.abs(self.form(*rows).density + np.zeros(rows.shape[1:])), rows, skip=0)

    def kinetic_energy(self, q: ArrayLike, mu: float = 1.0) -> Array:
        """Compute T (...) from coordinates and velocities q (8, ...).

        mu: the inertia, > 0.

        :Formula: T = mu/2 g_ij dq^i/dt dq^j/dt.
        :Source: EQ2.0a, EQ2.0b, EQ2.2a.
        """
        rows = checked("q", q, (8,))
        mass = positive("mu", mu)
        return mass / 2 * np.einsum("ij...,i...,j...->...", self.metric(rows[:4]), rows[4:], rows[4:])

    def kinetic_energy_from_momenta(self, q: ArrayLike, mu: float = 1.0) -> Array:
        """Compute T (...) from coordinates and conjugate momenta q (8, ...), also where the inverse metric is infinite.

        mu: the inertia, > 0.

        :Formula: T = ``|J^-T p|^2``/2 mu = g^ij p_i p_j/2 mu.
        :Source: EQ2.1a, EQ2.2f.
        """
        rows = checked("q", q, (8,))
        mass = positive("mu", mu)
        return np.sum(self.to_planes(rows)[4:] ** 2, axis=0) / (2 * mass)

    def _row_order(self, rows: Array) -> Array:
        """Rows in the order of the last step."""
        ordered = np.empty_like(rows)
        ordered[list(self.rows)] = rows
        return ordered

    def _ladder(self, q: Array) -> tuple[list[tuple[Step, Array, Array]], Array]:
        """(step, coordinates before it, coordinates after it) from the chart down to the planes, and the planes."""
        y = self._row_order(q)
        ladder = []
        with np.errstate(all="ignore"):
            for step in reversed(self.steps):
                x = step.restore(y)
                ladder.append((step, x, y))
                y = x
        return ladder, y

    def _pushed(self, q: Array, v: Array) -> tuple[Array, Array]:
        """The planes, and J v."""
        ladder, planes = self._ladder(q)
        v = self._row_order(v)
        with np.errstate(all="ignore"):
            for step, _, y in ladder:
                v = step.push(y, v)
        return planes, v

    def _defined(self, what: str, result: Array, given: Array, skip: int = 1) -> Array:
        """Return `result` if it is finite; its first `skip` axes are not axes of orbits."""
        bad = ~np.isfinite(result)
        if bad.any():
            index = first(np.asarray(bad.any(axis=tuple(range(skip)))))
            where = ", ".join(f"{row[index]:.6g}" for row in given[:4])
            raise ValueError(f"{what}: the {self.name} chart fails here, {self.singular}; got {where}{at_orbit(index)}")
        return result

    def _refuse(self, what: str, rows: Array, holds: Callable[[Array], np.ndarray], prefix: str = "") -> None:
        """Raise ValueError where `holds` is False, and name the coordinate."""
        bad = ~np.asarray(holds(rows))
        if bad.any():
            row, *orbit = first(bad)
            raise ValueError(
                f"{what}: the {self.name} chart fails here, {self.singular}; got "
                f"{prefix}{self.names[row]} = {rows[(row, *orbit)]}{at_orbit(tuple(orbit))}"
            )
