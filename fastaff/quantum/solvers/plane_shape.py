"""Amplitudes of states in rho and vartheta where a body does not separate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...systems.charts import R_VARTHETA, Chart
from .elements import Elements
from .factor_tables import angle_of
from .jacobi_basis import ProblemEnds, interval_rule, interval_weight, jacobi_table

POINTS = 4096
"""Points whose polynomials are tabulated at once."""


class Polynomials(NamedTuple):
    """The first `size` orthonormal polynomials of an interval times its weights."""

    interval: ProblemEnds
    size: int

    @property
    def lo(self) -> float:
        """Return the lower end."""
        return self.interval.lo

    @property
    def hi(self) -> float:
        """Return the upper end."""
        return self.interval.hi

    @property
    def degree(self) -> int:
        """Return the highest degree."""
        return self.size - 1

    def dense(self, below: np.ndarray, above: np.ndarray, shift: float) -> np.ndarray:
        """Return the functions (points, size) at distances from the ends, times below^shift; 0 outside."""
        ends = self.interval
        middle = (ends.hi - ends.lo) / 2
        inside = (below >= 0) & (above >= 0)
        low = np.where(inside, below, middle)
        high = np.where(inside, above, middle)
        t = np.clip((low - high) / (ends.hi - ends.lo), -1, 1).reshape(1, -1)
        weight = interval_weight(ends.lo, ends.hi, float(ends.e_lo[0]), float(ends.e_hi[0]), low, high, shift)
        inside &= weight > 1e-300
        table = jacobi_table(self.size, 2 * ends.e_hi, 2 * ends.e_lo, np.where(inside, t, 0.0))[0]
        return table * np.where(inside, weight, 0.0)[:, None]

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return Gauss nodes as distances from lo, and weights of functions that carry their own."""
        ends = self.interval
        return interval_rule(ends.lo, ends.hi, float(ends.e_lo[0]), float(ends.e_hi[0]), order)


class PlaneShape(NamedTuple):
    """A(r, vartheta) = rho^-3/2 u(rho, x)/pi of x = cos(vartheta); u: a sum of products of the functions of two lines.

    coefficients (n_rho, n_x); int u^2 drho dx = 1.
    """

    rho: Polynomials | Elements
    x: Polynomials | Elements
    coefficients: np.ndarray

    @property
    def chart(self) -> Chart:
        """The chart r, vartheta."""
        return R_VARTHETA

    @property
    def degrees(self) -> tuple[int, int]:
        """Return the degrees of the polynomials."""
        return self.rho.degree, self.x.degree

    def __call__(self, r: np.ndarray, vartheta: np.ndarray) -> np.ndarray:
        """Return A (...) at r, vartheta (...); 0 where V is infinite or A has decayed below rounding."""
        rho = np.sqrt(r)
        half = np.asarray(vartheta) / 2
        return self.of_radii(rho * np.cos(half), rho * np.sin(half))

    def of_radii(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return A (...) at alpha, beta (...) >= 0."""
        out = np.empty(np.shape(alpha))
        flat = out.reshape(-1)
        a = np.ravel(alpha)
        b = np.ravel(beta)
        for start in range(0, flat.size, POINTS):
            some = slice(start, start + POINTS)
            flat[some] = self._of(a[some], b[some])
        return out

    def _of(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        u = self.rho
        v = self.x
        q = np.hypot(a, b)
        sine = b / np.where(q > 0, q, 1.0)
        cosine = np.where(q > 0, a, 1.0) / np.where(q > 0, q, 1.0)
        below = 2 * cosine**2 if v.lo == -1 else (cosine - sine) * (cosine + sine) - v.lo
        first = v.dense(below, 2 * sine**2 if v.hi == 1 else v.hi - (cosine - sine) * (cosine + sine), 0.0)
        second = u.dense(q - u.lo, u.hi - q, 0.0 if u.lo else -1.5)
        values = np.einsum("pi,pi->p", second @ self.coefficients, first) / np.pi
        return values * np.maximum(q, u.lo) ** -1.5 if u.lo else values

    def rule(self, orders: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return Gauss nodes r (i,), vartheta (j,) and weights (i, j)."""
        (q, w), (below, v) = (line.rule(order) for line, order in zip((self.rho, self.x), orders, strict=True))
        q = self.rho.lo + q
        return q * q, angle_of(self.x.lo, self.x.hi, below), np.outer(np.pi**2 * w * q**3, v)


@dataclass(frozen=True, repr=False)
class ChannelWaves:
    """States of channels at nodes of rho: coefficients (size, levels) of the vectors G (size, n_x), grid, and lines."""

    grid: np.ndarray
    node: np.ndarray
    G: np.ndarray
    coefficients: np.ndarray
    rho: ProblemEnds
    x: ProblemEnds

    def __repr__(self) -> str:
        return f"{self.node.size} channels in rho and vartheta"

    def shape(self, n: Sequence[int]) -> PlaneShape:
        """Return the shape of a level."""
        table = np.zeros((len(self.grid), self.G.shape[1]))
        np.add.at(table, self.node, self.coefficients[:, n[0], None] * self.G)
        table = self.grid @ table
        lines = Polynomials(self.rho, len(table)), Polynomials(self.x, self.G.shape[1])
        return PlaneShape(*lines, np.sign(table.flat[np.argmax(np.abs(table))]) * table)


@dataclass(frozen=True, repr=False)
class ElementWaves:
    """States on products of elements: coefficients (levels, n_rho, n_x)."""

    rho: Elements
    x: Elements
    coefficients: np.ndarray

    def __repr__(self) -> str:
        return f"{self.rho.size} x {self.x.size} functions of elements in rho and vartheta"

    def shape(self, n: Sequence[int]) -> PlaneShape:
        """Return the shape of a level."""
        table = self.coefficients[n[0]]
        density = np.abs(table) / np.sqrt(np.outer(self.rho.mass, self.x.mass))
        return PlaneShape(self.rho, self.x, np.sign(table.flat[np.argmax(density)]) * table)
