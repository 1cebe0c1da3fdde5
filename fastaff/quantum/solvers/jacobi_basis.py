"""Spectral Galerkin method for Sturm-Liouville problems -(p f')' + q f = lambda f with singular ends.

The basis on (lo, hi) is f = (x - lo)^e_lo (hi - x)^e_hi times orthonormal Jacobi polynomials, e the exponents of the
wanted solution, so that the remaining factor is smooth. Many problems that differ in exponents and in q are solved at
once (first axis).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.packing import run_points
from ..kernels.laguerre_jacobi import polynomial_values


class ProblemEnds(NamedTuple):
    """Ends of problems with their exponents (problems,). wall: p is not 0 there; else p = 1 - x^2 vanishes there (x =
    -1 or 1).
    """

    lo: float
    hi: float
    e_lo: np.ndarray
    e_hi: np.ndarray
    wall_lo: bool
    wall_hi: bool


class Basis(NamedTuple):
    """Polynomials (problems, nodes, n) and their derivatives at quadrature nodes; weights include (x - lo)^2e_lo (hi -
    x)^2e_hi.

    x, below = x - lo, above = hi - x, weight: (problems, nodes).
    """

    interval: ProblemEnds
    x: np.ndarray
    below: np.ndarray
    above: np.ndarray
    weight: np.ndarray
    values: np.ndarray
    slopes: np.ndarray

    def matrix(self, q: np.ndarray, p: np.ndarray | float) -> np.ndarray:
        """Return the symmetric matrices (problems, n, n) of p P' P' + q P P."""
        kinetic = (self.slopes * (self.weight * p)[..., None]).mT @ self.slopes
        return kinetic + (self.values * (self.weight * q)[..., None]).mT @ self.values

    def lowest(self, q: np.ndarray, p: np.ndarray, count: int, start: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest eigenvalues (problems, count) and eigenvectors (problems, n, count).

        The matrix grows as n^4 at walls, and rounding with it; Rayleigh quotients as sums over the nodes, of
        eigenvectors whose errors enter squared, are accurate to rounding of the value itself. Signs: positive at the
        end `start`, 0 for lo, -1 for hi.
        """
        _, vectors = np.linalg.eigh(self.matrix(q, p))
        vectors = vectors[..., :count]
        f = self.values @ vectors
        slope = self.slopes @ vectors
        square = ((self.weight * p)[..., None] * slope**2 + (self.weight * q)[..., None] * f**2).sum(axis=1)
        density = (self.weight[..., None] * f**2)[:, :: -1 if start else 1]
        first = np.argmax(density > 1e-8 * density.max(axis=1, keepdims=True), axis=1)
        sign = np.sign(np.take_along_axis(f[:, :: -1 if start else 1], first[:, None], axis=1))
        return square / (vectors**2).sum(axis=1), vectors * sign


class IntervalFunction(NamedTuple):
    """One solution, normalised int f^2 dx = 1: coefficients (n,) of the orthonormal polynomials."""

    lo: float
    hi: float
    e_lo: float
    e_hi: float
    coefficients: np.ndarray

    @property
    def degree(self) -> int:
        """Return the degree of the polynomial."""
        return self.coefficients.size - 1

    def at(self, below: np.ndarray, above: np.ndarray, shift: float = 0.0) -> np.ndarray:
        """Return f (x - lo)^shift at distances below = x - lo and above = hi - x from the ends; 0 outside."""
        below, above = np.broadcast_arrays(below, above)
        inside = (below >= 0) & (above >= 0)
        middle = (self.hi - self.lo) / 2
        low = np.where(inside, below, middle)
        high = np.where(inside, above, middle)
        weight = interval_weight(self.lo, self.hi, self.e_lo, self.e_hi, low, high, shift)
        # Where the weight is below the range of floats, polynomials overflow.
        inside &= weight > 1e-300
        t = np.clip((low - high) / (self.hi - self.lo), -1, 1)
        diagonal, off = recurrence(self.coefficients.size, np.array([2 * self.e_hi]), np.array([2 * self.e_lo]))
        polynomial = np.empty(t.shape)
        points = np.ascontiguousarray(t).reshape(-1), polynomial.reshape(-1)
        run_points(polynomial_values, (diagonal[0], off[0], self.coefficients, *points), t.size)
        return np.where(inside, weight * np.where(inside, polynomial, 0.0), 0.0)

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes (order,) as distances from lo and weights: int f^2 g dx is the sum of weight*f^2*g."""
        return interval_rule(self.lo, self.hi, self.e_lo, self.e_hi, order)


def interval_rule(lo: float, hi: float, e_lo: float, e_hi: float, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss nodes (order,) as distances from lo, and weights for functions that carry (x - lo)^2e_lo (hi -
    x)^2e_hi themselves.
    """
    t, w = gauss_jacobi(order, np.array([2 * e_hi]), np.array([2 * e_lo]))
    below = (hi - lo) * (1 + t[0]) / 2
    above = (hi - lo) * (1 - t[0]) / 2
    return below, np.exp(
        np.log(w[0]) + log_total_weight(lo, hi, e_lo, e_hi) - 2 * e_lo * np.log(below) - 2 * e_hi * np.log(above)
    )


def interval_weight(
    lo: float, hi: float, e_lo: float, e_hi: float, below: np.ndarray, above: np.ndarray, shift: float = 0.0
) -> np.ndarray:
    """Return (x - lo)^(e_lo + shift) (hi - x)^e_hi at distances below, above >= 0, so that for shift = 0 the square has
    integral 1.
    """
    from scipy.special import xlogy

    logarithm = xlogy(e_lo + shift, below) + xlogy(e_hi, above) - log_total_weight(lo, hi, e_lo, e_hi) / 2
    with np.errstate(over="ignore", under="ignore"):
        return np.exp(logarithm)


def log_total_weight(lo: float, hi: float, e_lo: float, e_hi: float) -> float:
    """Return the logarithm of int (x - lo)^2e_lo (hi - x)^2e_hi dx."""
    power = 2 * e_lo + 2 * e_hi + 1
    return power * math.log(hi - lo) + math.lgamma(2 * e_lo + 1) + math.lgamma(2 * e_hi + 1) - math.lgamma(power + 1)


def recurrence(n: int, alpha: np.ndarray, beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return diagonals (problems, n) and off-diagonals (problems, n) of the Jacobi matrices of (1 - t)^alpha (1 +
    t)^beta.

    Source: Gautschi 2004, Orthogonal Polynomials: Computation and Approximation, table 1.1.
    """
    k = np.arange(1, n + 1)
    s = (alpha + beta)[:, None]
    a = alpha[:, None]
    b = beta[:, None]
    first = (b - a) / (s + 2)
    diagonal = np.hstack([first, (b - a) * s / ((2 * k + s) * (2 * k + s + 2))])[:, :n]
    # At k = 1 the factor (k + s)/(2 k + s - 1) is 1, also where s = -1.
    ratio = np.where(k == 1, 1.0, (k + s) / np.where(k == 1, 1.0, 2 * k + s - 1))
    square = 4 * k * (k + a) * (k + b) * ratio / ((2 * k + s) ** 2 * (2 * k + s + 1))
    return diagonal, np.sqrt(square)


def jacobi_table(n: int, alpha: np.ndarray, beta: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return the first n polynomials (problems, points, n) orthonormal in (1 - t)^alpha (1 + t)^beta scaled to
    total 1.
    """
    diagonal, off = recurrence(n, alpha, beta)
    table = np.empty((*t.shape, n))
    table[..., 0] = 1.0
    for k in range(1, n):
        table[..., k] = (t - diagonal[:, k - 1, None]) * table[..., k - 1]
        if k > 1:
            table[..., k] -= off[:, k - 2, None] * table[..., k - 2]
        table[..., k] /= off[:, k - 1, None]
    return table


def gauss_jacobi(n: int, alpha: np.ndarray, beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss nodes in (-1, 1) and weights of total 1, (problems, n).

    Source: Golub & Welsch 1969, Mathematics of Computation 23, 221; the weights are the Christoffel numbers.
    """
    from scipy.linalg import eigvalsh_tridiagonal

    diagonal, off = recurrence(n, alpha, beta)
    t = np.array([eigvalsh_tridiagonal(row, side[:-1]) for row, side in zip(diagonal, off, strict=True)])
    with np.errstate(over="ignore", invalid="ignore"):
        w = 1 / (jacobi_table(n, alpha, beta, t) ** 2).sum(axis=-1)
    if not np.all(w > 0):
        raise ValueError(
            f"m and l must give exponents whose {n} functions are finite, got {max(alpha.max(), beta.max()) / 2:.3g}. "
            "Try smaller m, l, fewer levels or a larger hbar."
        )
    return t, w / w.sum(axis=1, keepdims=True)


def basis(interval: ProblemEnds, n: int, extra: int) -> Basis:
    """Return the first n functions of problems on an interval at n + extra nodes.

    The nodes are those of a weight that is one power less at walls: simple poles there, from p f'^2 or of potentials,
    are integrated as smooth functions.
    """
    alpha, beta = 2 * interval.e_hi, 2 * interval.e_lo
    t, w = gauss_jacobi(n + extra, alpha - interval.wall_hi, beta - interval.wall_lo)
    w = w * (1 - t) ** interval.wall_hi * (1 + t) ** interval.wall_lo
    w /= w.sum(axis=1, keepdims=True)
    half = (interval.hi - interval.lo) / 2
    below = half * (1 + t)
    above = half * (1 - t)
    degree = np.arange(1, n)
    # The derivative of the k-th orthonormal polynomial is the (k-1)-th of (alpha + 1, beta + 1), up to its norm.
    s = alpha + beta
    factor = np.sqrt(degree * (degree + s[:, None] + 1) * ((s + 2) * (s + 3) / (4 * (alpha + 1) * (beta + 1)))[:, None])
    slopes = np.zeros((*t.shape, n))
    if n > 1:
        slopes[..., 1:] = jacobi_table(n - 1, alpha + 1, beta + 1, t) * factor[:, None] / half
    middle = interval.lo + below if interval.lo != -1 else np.where(t < 0, interval.lo + below, interval.hi - above)
    return Basis(interval, middle, below, above=above, weight=w, values=jacobi_table(n, alpha, beta, t), slopes=slopes)
