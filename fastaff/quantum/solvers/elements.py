"""Spectral elements for Sturm-Liouville problems whose potential has narrow features.

If a global basis needs too many functions, panels that resolve the potential become elements with a nodal basis
(Gauss-Lobatto, Gauss-Radau with the exponents at the ends of the interval): V is diagonal in it, the matrix banded.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from .jacobi_basis import ProblemEnds, gauss_jacobi, interval_rule
from .lapack import lowest_states
from .panels import barycentric

DENSE = 6000
"""Largest matrix that is diagonalised as a whole where Lanczos does not end."""

RESTARTS = 100
"""Restarts after which Lanczos does not end, as with one level far below all others."""

POINTS = 1 << 14
"""Points at which functions are evaluated at once."""


class Elements(NamedTuple):
    """Nodal basis of f = w P on elements, P continuous and polynomial on each; w = (d/h)^e in the first and the last
    one, 1 between.

    edges (E + 1,); interval: its exponents (E,) are 0 but at the ends; t (E, n): nodes in (-1, 1); x, below, above,
    weight (E, n): nodes, their distances from the ends, and weights of int f^2; slopes (E, n, n): P' at the nodes of
    the cardinal polynomials; mass (size,): weights of the nodes, which elements share.
    """

    edges: np.ndarray
    interval: ProblemEnds
    t: np.ndarray
    x: np.ndarray
    below: np.ndarray
    above: np.ndarray
    weight: np.ndarray
    slopes: np.ndarray
    mass: np.ndarray

    @property
    def lo(self) -> float:
        """Return the lower end."""
        return float(self.edges[0])

    @property
    def hi(self) -> float:
        """Return the upper end."""
        return float(self.edges[-1])

    @property
    def degree(self) -> int:
        """Return the degree of the polynomials."""
        return self.x.shape[1] - 1

    @property
    def size(self) -> int:
        """Return the number of functions."""
        return self.mass.size

    def diagonal(self, q: np.ndarray) -> np.ndarray:
        """Return the diagonal matrix (size,) of q (E, n)."""
        return summed(self.weight * q) / self.mass

    def kinetic(self, p: np.ndarray) -> np.ndarray:
        """Return the matrices (E, n, n) of int p f'^2, p (E, n), less the part -(p w')'/w of the potential."""
        blocks = (self.slopes * (self.weight * p)[..., None]).mT @ self.slopes
        low, high = self.bounds(p)
        blocks[0, -1, -1] += low
        blocks[-1, 0, 0] += high
        root = np.sqrt(self.local(self.mass))
        return blocks / (root[:, :, None] * root[:, None, :])

    def shared(self, values: np.ndarray) -> np.ndarray:
        """Return the values (size,) at nodes of local ones (E, n) of a continuous function."""
        return np.append(values[:, :-1], values[-1, -1])

    def assembled(self, p: np.ndarray, q: np.ndarray) -> Any:
        """Return the sparse matrix (size, size) of int p f'^2 + q f^2, p and q (E, n)."""
        from scipy.sparse import coo_matrix, diags

        blocks = self.kinetic(p)
        index = np.arange(len(blocks))[:, None] * self.degree + np.arange(self.degree + 1)
        rows, columns = (
            np.broadcast_to(place, blocks.shape).ravel() for place in (index[:, :, None], index[:, None, :])
        )
        return (coo_matrix((blocks.ravel(), (rows, columns))) + diags(self.diagonal(q))).tocsc()

    def bounds(self, p: np.ndarray) -> tuple[float, float]:
        """Return p w w' where the first element ends, and -p w w' where the last one begins: the boundary terms of
        integration by parts.
        """
        h = np.diff(self.edges)
        ends = self.interval
        return float(p[0, -1] * ends.e_lo[0] / h[0]), float(p[-1, 0] * ends.e_hi[-1] / h[-1])

    def local(self, values: np.ndarray) -> np.ndarray:
        """Return the values (E, n, ...) on elements of values (size, ...) of the nodes."""
        n = self.degree
        return values[np.arange(self.x.shape[0])[:, None] * n + np.arange(n + 1)]

    def table(self, below: np.ndarray, above: np.ndarray, shift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of the functions that are not 0 at points (points, n), and their values there times
        below^shift (points, n).
        """
        span = self.hi - self.lo
        place = np.where(below < above, below, span - above)
        inside = (below >= 0) & (above >= 0)
        place = np.where(inside, place, span / 2)
        elements = self.x.shape[0]
        own = np.clip(np.searchsorted(self.edges - self.lo, place, side="right") - 1, 0, elements - 1)
        values = np.zeros((place.size, self.degree + 1))
        key = np.where(inside, own, elements)
        by_element = np.argsort(key, kind="stable")
        stops = np.searchsorted(key[by_element], np.arange(elements + 1))
        for k in range(elements):
            here = by_element[stops[k] : stops[k + 1]]
            if not here.size:
                continue
            h = self.edges[k + 1] - self.edges[k]
            t = 2 * (place[here] - (self.edges[k] - self.lo)) / h - 1
            local = barycentric(self.t[k], _weights(self.t[k]), np.clip(t, -1, 1))
            first = k == 0
            last = k == elements - 1
            with np.errstate(divide="ignore", under="ignore"):
                front = np.ones(here.size)
                if first:
                    front = (below[here] / h) ** (self.interval.e_lo[0] + shift) * h**shift
                elif shift:
                    front = place[here] ** shift
                if last:
                    front = front * (above[here] / h) ** self.interval.e_hi[-1]
            values[here] = local * front[:, None]
        index = own[:, None] * self.degree + np.arange(self.degree + 1)
        return index, values / np.sqrt(self.mass[index])

    def dense(self, below: np.ndarray, above: np.ndarray, shift: float) -> np.ndarray:
        """Return the functions (points, size) at distances from the ends, times below^shift; 0 outside."""
        index, values = self.table(below, above, shift)
        out = np.zeros((index.shape[0], self.size))
        np.put_along_axis(out, index, values, axis=1)
        return out

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return distances from lo and weights for functions of this basis: int f^2 g dx, with `order` nodes on each
        element.
        """
        h = np.diff(self.edges)
        ends = self.interval
        t, w = np.polynomial.legendre.leggauss(order)
        below = (self.edges[:-1] - self.lo)[:, None] + h[:, None] * (1 + t) / 2
        weights = h[:, None] * w / 2
        for k in (0, -1):
            lo = float(self.edges[:-1][k])
            hi = float(self.edges[1:][k])
            place, weights[k] = interval_rule(lo, hi, float(ends.e_lo[k]), float(ends.e_hi[k]), order)
            below[k] = lo - self.lo + place
        return below.ravel(), weights.ravel()


def summed(local: np.ndarray) -> np.ndarray:
    """Return the sums (size,) of local values (E, n) whose last and first are of the same node."""
    step = local.shape[1] - 1
    total = np.zeros(local.shape[0] * step + 1)
    total[:-1] = local[:, :-1].ravel()
    total[step::step] += local[:, -1]
    return total


def _weights(t: np.ndarray) -> np.ndarray:
    """Return barycentric weights of nodes, of largest size 1."""
    gaps = t[:, None] - t
    np.fill_diagonal(gaps, 1.0)
    weights = 1 / (2 * gaps).prod(axis=1)
    return weights / np.abs(weights).max()


def _reference(n: int, beta: float) -> tuple[np.ndarray, np.ndarray]:
    """Return n Gauss-Radau nodes with one at t = 1, and weights of total 1, for (1 + t)^beta."""
    t, w = gauss_jacobi(n - 1, np.ones(1), np.array([beta]))
    w = w[0] * 2 / (beta + 2) / (1 - t[0])
    return np.append(t[0], 1.0), np.append(w, 1 - w.sum())


@lru_cache(maxsize=64)
def _lobatto(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return n Gauss-Lobatto nodes and weights of total 1."""
    t, _ = gauss_jacobi(n - 2, np.ones(1), np.ones(1))
    t = np.concatenate([[-1.0], t[0], [1.0]])
    t = (t - t[::-1]) / 2
    last = np.polynomial.legendre.legval(t, [0.0] * (n - 1) + [1.0])
    return t, 1 / (n * (n - 1) * last**2)


def elements(edges: np.ndarray, n: int, e_lo: float, e_hi: float, wall_lo: bool, wall_hi: bool) -> Elements:
    """Return the basis of n nodes on each element (at least two elements); poles at walls are integrated exactly."""
    h = np.diff(edges)
    E = edges.size - 1
    t, w = (np.tile(row, (E, 1)) for row in _lobatto(n))
    first, w_first = _end(n, e_lo, wall_lo)
    last, w_last = _end(n, e_hi, wall_hi)
    t[0] = first
    w[0] = w_first
    t[-1] = -last[::-1]
    w[-1] = w_last[::-1]
    slopes = np.array([_derivative(row) for row in t]) * (2 / h)[:, None, None]
    below = edges[:-1, None] - edges[0] + h[:, None] * (1 + t) / 2
    above = edges[-1] - edges[1:, None] + h[:, None] * (1 - t) / 2
    weight = w * h[:, None]
    x = np.where(below < above, edges[0] + below, edges[-1] - above)
    exponents = np.zeros((2, E))
    exponents[0, 0] = e_lo
    exponents[1, -1] = e_hi
    interval = ProblemEnds(float(edges[0]), float(edges[-1]), exponents[0], exponents[1], wall_lo, wall_hi)
    return Elements(edges, interval, t, x, below, above, weight, slopes, mass=summed(weight))


def _end(n: int, e: float, wall: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of int ((1 + t)/2)^(2 e) dt/2 on the element at an end; at walls those of one power
    less.
    """
    t, w = _reference(n, 2 * e - wall)
    w = w / (2 * e - wall + 1)
    return t, w * ((1 + t) / 2) ** wall


@lru_cache(maxsize=256)
def _derivative_of(t: tuple[float, ...]) -> np.ndarray:
    nodes = np.array(t)
    weights = _weights(nodes)
    gaps = nodes[:, None] - nodes
    np.fill_diagonal(gaps, 1.0)
    D = weights / weights[:, None] / gaps
    np.fill_diagonal(D, 0.0)
    np.fill_diagonal(D, -D.sum(axis=1))
    return D


def _derivative(t: np.ndarray) -> np.ndarray:
    """Return the matrix of derivatives at nodes t of the cardinal polynomials of t."""
    return _derivative_of(tuple(t.tolist()))


class ElementFunction(NamedTuple):
    """One solution, normalised int f^2 dx = 1: coefficients (size,) of the functions of `line`."""

    line: Elements
    coefficients: np.ndarray

    @property
    def lo(self) -> float:
        """Return the lower end."""
        return self.line.lo

    @property
    def hi(self) -> float:
        """Return the upper end."""
        return self.line.hi

    @property
    def degree(self) -> int:
        """Return the degree of the polynomials."""
        return self.line.degree

    def at(self, below: np.ndarray, above: np.ndarray, shift: float = 0.0) -> np.ndarray:
        """Return f (x - lo)^shift at distances below = x - lo and above = hi - x from the ends; 0 outside."""
        shape = np.broadcast_shapes(np.shape(below), np.shape(above))
        rows = [np.broadcast_to(distance, shape).ravel() for distance in (below, above)]
        out = np.empty(rows[0].size)
        for start in range(0, out.size, POINTS):
            some = slice(start, start + POINTS)
            index, values = self.line.table(rows[0][some], rows[1][some], shift)
            out[some] = (values * self.coefficients[index]).sum(axis=1)
        return out.reshape(shape)

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes as distances from lo and weights: int f^2 g dx is the sum of weight*f^2*g."""
        return self.line.rule(order)


def lowest(matrix: Any, count: int, top: float, step: float) -> np.ndarray:
    """Return eigenvectors (size, count) of the lowest eigenvalues of a sparse symmetric matrix.

    The method is Lanczos with the inverse of matrix - s; s lies below all eigenvalues, so that no pivot is negative,
    and is sought below `top` in steps that double. Double eigenvalues that Lanczos has once are sought in the remaining
    space.
    Source: Lehoucq, Sorensen & Yang 1998, ARPACK Users' Guide (shift and invert).
    """
    from scipy.sparse import identity
    from scipy.sparse.linalg import ArpackNoConvergence, splu

    size = matrix.shape[0]
    while True:
        try:
            shifted = matrix - (top - step) * identity(size, format="csc")
            factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
            if (factor.U.diagonal() > 0).all():
                break
        except RuntimeError:  # a pivot is 0
            pass
        step *= 2
    try:
        return _by_lanczos(factor, size, count)
    except ArpackNoConvergence:
        if size > DENSE:
            raise
        return lowest_states(matrix.toarray(), count)[1]


def _by_lanczos(factor: Any, size: int, count: int) -> np.ndarray:
    """Return the eigenvectors of the largest eigenvalues of a factorised inverse."""
    from scipy.sparse.linalg import LinearOperator, eigsh

    most = RESTARTS if size <= DENSE else None
    start = np.cos(np.arange(size) * 1.234567)  # the same every time, and orthogonal to no eigenvector
    inverse = LinearOperator((size, size), matvec=factor.solve, dtype=float)
    values, vectors = eigsh(inverse, k=count, v0=start, ncv=min(size, 2 * count + 24), maxiter=most)
    while True:

        def rest(v, vectors=vectors):
            v = v - vectors @ (vectors.T @ v)
            v = factor.solve(v)
            return v - vectors @ (vectors.T @ v)

        value, vector = eigsh(
            LinearOperator((size, size), matvec=rest, dtype=float),
            k=1,
            v0=start[::-1],
            ncv=min(size, 24),
            tol=1e-6,
            maxiter=most,
        )
        if value[0] <= np.sort(values)[-count] * (1 + 1e-5):
            break
        values = np.append(values, value)
        vectors = np.linalg.qr(np.hstack([vectors, vector]))[0]
    return vectors[:, np.argsort(-values)[:count]]


def quadratic(line: Elements, p: np.ndarray, q: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return int p f'^2 + q f^2 (count,) of vectors c (size, count) as sums over the nodes; p, q (E, n).

    Eigenvectors enter squared, and no large entries of a matrix cancel: accurate to rounding of the value itself.
    """
    P = line.local(c / np.sqrt(line.mass)[:, None])
    slope = line.slopes @ P
    value = ((line.weight * p)[..., None] * slope**2 + (line.weight * q)[..., None] * P**2).sum(axis=(0, 1))
    low, high = line.bounds(p)
    return value + low * P[0, -1] ** 2 + high * P[-1, 0] ** 2


def solve(
    line: Elements, p: np.ndarray, q: np.ndarray, count: int, top: float, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest eigenvalues (count,) and vectors (size, count) of -(p f')' + q f, p and q (E, n)."""
    c = lowest(line.assembled(p, q), count, top, step)
    values = quadratic(line, p, q, c) / (c**2).sum(axis=0)
    order = np.argsort(values)
    return values[order], c[:, order]


def left_over(line: Elements, missed: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return int missed f^2 (count,) for vectors c (size, count): the first order of perturbation theory; missed (E,):
    the misfit of V.
    """
    share = (line.local(c / np.sqrt(line.mass)[:, None]) ** 2 * line.weight[..., None]).sum(axis=1)
    return np.minimum(missed, 1e300) @ share


def first_signs(c: np.ndarray) -> np.ndarray:
    """Return the signs (count,) that vectors c (size, count) have next to the lower end."""
    density = c**2
    first = np.argmax(density > 1e-8 * density.max(axis=0), axis=0)
    return np.sign(c[first, np.arange(c.shape[1])])
