"""Points of an energy surface H = E along one row of phase points, and the ellipsoids of momenta that it allows."""

from __future__ import annotations

import numpy as np

from ..systems.models.mechanics import System
from .accessible_box import spread
from .allowed_region import crossings, extrema, line, line_where_it_happens

MOST = 32
"""Number of roots along a row beyond which there is no end of them, as for an H that is periodic in it."""


def left(system: System, energy: float, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the energy that is left at phase points (2n, ...), and the size of its terms."""
    if system.nonseparable:
        H = system.energies(z)
        return np.where(system.inside(z), energy - H, -np.inf), abs(energy) + np.abs(H)
    T = system.kinetic_energies(z)
    V = system.potential_energies(z)
    return np.where(system.inside(z), energy - T - V, -np.inf), abs(energy) + np.abs(T) + np.abs(V)


def roots_along(system: System, energy: float, z: np.ndarray, row: int, sign: int) -> np.ndarray:
    """Return the values (sheets, points) of a row at which points z (2n, points) have the energy and H rises with
    sign times the row: the last one in that direction first, NaN where there are fewer.

    For a momentum in which H is of second degree they are in closed form; else between extrema at all sizes.
    """
    n = len(z) // 2
    if row >= n and system.of_degree_two:
        return _of_parabola(system, energy, z, row, sign)[None]

    def room(x: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        at = spread(z[:, column], x)
        at[row] = sign * x
        return left(system, energy, at)

    column = np.arange(z.shape[1])
    nodes = line() if system.separable else line_where_it_happens(room, column.size)
    found = sign * crossings(room, extrema(room, column.size, nodes), column, np.zeros(column.size), False)[0]
    if len(found) > MOST:
        name = system.row_names[row]
        raise ValueError(f"energy {energy:g} is met without end along {name}: solve for another row")
    return found


def _of_parabola(system: System, energy: float, z: np.ndarray, row: int, sign: int) -> np.ndarray:
    """Return the root of a momentum p in H = H0 + v p + w p^2/2 at which its velocity, +-sqrt(v^2 + 2 w (E - H0)), has
    the sign; refined by a step of Newton's method where this lessens the error.
    """
    at = z.copy()
    k = row - len(z) // 2
    at[row] = 0.0
    v = system.velocities(at)[k]
    rest = energy - system.energies(at)
    w = system.tangent_slopes(at, np.eye(len(z))[row, :, None])[k]
    square = v * v + 2 * w * rest
    speed = sign * np.sqrt(np.where(square >= 0, square, np.nan))
    p = np.where(v * sign > 0, 2 * rest / (v + speed), (speed - v) / w)
    at[row] = p
    miss = system.energies(at) - energy
    at[row] = better = p - miss / system.velocities(at)[k]
    return np.where(np.abs(system.energies(at) - energy) < np.abs(miss), better, p)


# --- ellipsoids of momenta: small systems of equations at many points, rows first -----------------------------------


def rest(system: System, q: np.ndarray) -> np.ndarray:
    """Return the momenta (n, ...) at places q (n, ...) at which all velocities are 0."""
    if not system.nonseparable:
        return system.at_rest(q)
    W, v, _ = system.momentum_form(q)
    L = cholesky(W)
    return -backward(L, forward(L, v))


def cholesky(W: np.ndarray) -> np.ndarray:
    """Return L (n, n, ...) of W = L L^T (n, n, ...), lower triangular; NaN where W is not positive definite."""
    L = np.zeros_like(W)
    for j in range(len(W)):
        square = W[j, j] - (L[j, :j] ** 2).sum(axis=0)
        L[j, j] = np.sqrt(np.where(square > 0, square, np.nan))
        for i in range(j + 1, len(W)):
            L[i, j] = (W[i, j] - (L[i, :j] * L[j, :j]).sum(axis=0)) / L[j, j]
    return L


def forward(L: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return y (n, ...) of L y = b."""
    y = np.empty(np.broadcast_shapes(L.shape[1:], b.shape))
    for i in range(len(y)):
        y[i] = (b[i] - (L[i, :i] * y[:i]).sum(axis=0)) / L[i, i]
    return y


def backward(L: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return x (n, ...) of L^T x = y."""
    x = np.empty(np.broadcast_shapes(L.shape[1:], y.shape))
    for i in range(len(x) - 1, -1, -1):
        x[i] = (y[i] - (L[i + 1 :, i] * x[i + 1 :]).sum(axis=0)) / L[i, i]
    return x
