"""The chart as a value: points, velocities and momenta both ways, metric, density and kinetic energy."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array, at_orbit, checked, first
from ...core.docstrings import inserts_parameters
from ...core.numbers import positive
from .metrics import Form
from .steps import Step


@inserts_parameters
class Chart(NamedTuple):
    """Hold one coordinate system of GL(2,R).

    The methods accept arrays of any trailing shape. Angles are in radians, lengths in the units of phi. You get charts
    from `CHARTS`, `elliptic` and `bipolar`.

    Attributes
    ----------
    name : str
        Chart in words.
    names : tuple of str, 4 entries
        Coordinates, in the order of the rows.
    steps : tuple, internal
        Steps that lead from the planes to the chart.
    rows : tuple of int, internal
        Row of each coordinate in the last step.
    form : callable, internal
        Line element, as a function of the four coordinates.
    singular : str
        Singular set in words.

    References
    ----------
    Martens & Slawianowski, section 3, section 7. The label of each chart is given with its line element in
    ``fastaff.systems.charts.metrics``.

    Examples
    --------
    >>> z = fa.charts.from_matrix(np.diag([2.0, 1.0]), np.zeros((2, 2)))
    >>> fa.charts.TWO_POLAR.from_planes(z)[:2].round(9)
    array([2., 1.])
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
        """Convert phase points to coordinates and conjugate momenta.

        Parameters
        ----------
        z : array_like, shape (8, ...)
            Planes a1, a2, b1, b2, then their momenta.

        Returns
        -------
        ndarray, shape (8, ...)
            Coordinates of the canonical sheet, then their momenta p_q = J^T p.

        Raises
        ------
        TypeError
            If `z` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, section 3 (the coordinates); the momenta are derived.
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
        """Convert coordinates and conjugate momenta to phase points.

        Parameters
        ----------
        {chart_momenta}

        Returns
        -------
        ndarray, shape (8, ...)
            Planes a1, a2, b1, b2, then their momenta p = J^-T p_q.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, section 3 (the coordinates); the momenta are derived.
        """
        rows = checked("q", q, (8,))
        p = self._row_order(rows[4:])
        ladder, planes = self._ladder(rows[:4])
        with np.errstate(all="ignore"):
            for step, _, y in ladder:
                p = step.unpull(y, p)
        return self._defined("q", np.concatenate([planes, p]), rows)

    def points_from_planes(self, planes: ArrayLike) -> Array:
        """Convert planes to coordinates.

        Parameters
        ----------
        planes : array_like, shape (4, ...)
            Planes a1, a2, b1, b2.

        Returns
        -------
        ndarray, shape (4, ...)
            Coordinates of the canonical sheet. An undefined angle is 0.

        Raises
        ------
        TypeError
            If `planes` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.
        """
        x = checked("planes", planes, (4,))
        return self.from_planes(np.concatenate([x, np.zeros_like(x)]))[:4]

    def points_to_planes(self, q: ArrayLike) -> Array:
        """Convert coordinates to planes.

        Parameters
        ----------
        {chart_points}

        Returns
        -------
        ndarray, shape (4, ...)
            Planes a1, a2, b1, b2.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.
        """
        rows = checked("q", q, (4,))
        return self._defined("q", self._ladder(rows)[1], rows)

    def velocities_from_planes(self, w: ArrayLike) -> Array:
        """Convert planes and their velocities to coordinates and their velocities.

        Parameters
        ----------
        w : array_like, shape (8, ...)
            Planes a1, a2, b1, b2, then their velocities.

        Returns
        -------
        ndarray, shape (8, ...)
            Coordinates, then their velocities J^-1 v. If a radius is 0, the angle is that of the velocity and its rate
            is 0, the limit along the straight motion.

        Raises
        ------
        TypeError
            If `w` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, EQ2.0a, EQ2.0b.
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
        """Convert coordinates and their velocities to planes and their velocities.

        Parameters
        ----------
        {chart_velocities}

        Returns
        -------
        ndarray, shape (8, ...)
            Planes, then their velocities v = J dq/dt.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, EQ2.0a, EQ2.0b.
        """
        rows = checked("q", q, (8,))
        planes, v = self._pushed(rows[:4], rows[4:])
        return self._defined("q", np.concatenate([planes, v]), rows)

    def momenta_from_velocities(self, q: ArrayLike, mu: float = 1.0) -> Array:
        """Convert velocities to momenta, the Legendre transformation of T.

        Parameters
        ----------
        {chart_velocities}
        {inertia}

        Returns
        -------
        ndarray, shape (8, ...)
            Coordinates, then their momenta p = mu J^T J dq/dt, regular in every sheet.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, EQ2.1a.
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
        """Convert momenta to velocities, the inverse Legendre transformation.

        Parameters
        ----------
        {chart_momenta}
        {inertia}

        Returns
        -------
        ndarray, shape (8, ...)
            Coordinates, then their velocities dq/dt = J^-1 J^-T p/mu. The rate of an angle is 0 if its radius and its
            angular momentum are 0.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, EQ2.1a.
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
        """Compute the Jacobian J = d(a1, a2, b1, b2)/dq.

        Parameters
        ----------
        {chart_points}

        Returns
        -------
        ndarray, shape (4, 4, ...)
            Matrices J; column j belongs to coordinate j.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.
        """
        rows = checked("q", q, (4,))
        units = np.broadcast_to(np.eye(4).reshape(4, 4, *(1,) * (rows.ndim - 1)), (4, 4, *rows.shape[1:]))
        return self._defined("q", self._pushed(rows, units)[1], rows, skip=2)

    def metric(self, q: ArrayLike) -> Array:
        """Compute the metric g_ij of ds^2 = Tr(dphi^T dphi), by the formula of the paper.

        Parameters
        ----------
        {chart_points}

        Returns
        -------
        ndarray, shape (4, 4, ...)
            Metric, defined on singular sets too if it is finite there.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, EQ6.1, and the label of the chart's line element.
        """
        rows = checked("q", q, (4,))
        self._ladder(rows)
        with np.errstate(all="ignore"):
            return self._defined("q", self.form(*rows).tensor(), rows, skip=2)

    def inverse_metric(self, q: ArrayLike) -> Array:
        """Compute the inverse metric g^ij, the quadratic form 2 mu T of the momenta.

        Parameters
        ----------
        {chart_points}

        Returns
        -------
        ndarray, shape (4, 4, ...)
            Matrices J^-1 J^-T.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the density is 0. The message names the singular set and
            the orbit.

        References
        ----------
        Martens & Slawianowski, EQ2.1a, EQ2.2f.
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
        """Compute the density sqrt(det g), by the formula of the paper.

        Parameters
        ----------
        {chart_points}

        Returns
        -------
        ndarray, shape (...)
            Volume element of the chart, not negative.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, section 5, the measure; derived for the charts that section 5 does not use.
        """
        rows = checked("q", q, (4,))
        with np.errstate(all="ignore"):
            return self._defined("q", np.abs(self.form(*rows).density + np.zeros(rows.shape[1:])), rows, skip=0)

    def kinetic_energy(self, q: ArrayLike, mu: float = 1.0) -> Array:
        """Compute the kinetic energy from coordinates and velocities.

        Parameters
        ----------
        {chart_velocities}
        {inertia}

        Returns
        -------
        ndarray, shape (...)
            Energy T = mu/2 g_ij dq^i/dt dq^j/dt.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, EQ2.0a, EQ2.0b, EQ2.2a.
        """
        rows = checked("q", q, (8,))
        mass = positive("mu", mu)
        return mass / 2 * np.einsum("ij...,i...,j...->...", self.metric(rows[:4]), rows[4:], rows[4:])

    def kinetic_energy_from_momenta(self, q: ArrayLike, mu: float = 1.0) -> Array:
        """Compute the kinetic energy from coordinates and momenta.

        Parameters
        ----------
        {chart_momenta}
        {inertia}

        Returns
        -------
        ndarray, shape (...)
            Energy T = ``|J^-T p|^2``/(2 mu) = g^ij p_i p_j/(2 mu), also if the inverse metric is infinite.

        Raises
        ------
        TypeError
            If `q` is not an array of real numbers.
        ValueError
            If the shape is wrong, a number is not finite, or the result does not exist. The message names the singular
            set and the orbit.

        References
        ----------
        Martens & Slawianowski, EQ2.1a, EQ2.2f.
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
            raise ValueError(
                f"{what} must avoid {self.singular} in the {self.name} chart, got {where}{at_orbit(index)}"
            )
        return result

    def _refuse(self, what: str, rows: Array, holds: Callable[[Array], np.ndarray], prefix: str = "") -> None:
        """Raise ValueError where `holds` is False, and name the coordinate."""
        bad = ~np.asarray(holds(rows))
        if bad.any():
            row, *orbit = first(bad)
            raise ValueError(
                f"{what} must avoid {self.singular} in the {self.name} chart, got {prefix}{self.names[row]} = "
                f"{rows[(row, *orbit)]}{at_orbit(tuple(orbit))}"
            )
