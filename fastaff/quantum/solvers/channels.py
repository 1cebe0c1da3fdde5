"""Levels in the plane of rho and vartheta by adiabatic channels: those of vartheta at every node of a grid in rho."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..states.level_table import Waves
from .jacobi_basis import Basis, ProblemEnds, basis, gauss_jacobi, jacobi_table
from .lapack import lowest_states
from .panels import Panels
from .plane_problem import PlaneProblem
from .plane_shape import ChannelWaves
from .separable import angular_interval, angular_potential
from .singular_ends import decayed, exponent, sampled

LARGEST = 6000
"""Largest matrix: 0.3 GB each of a handful."""
TAILS = 4.0
"""Error in units of the second-order perturbation by the states that are cut off; that is usually 0.7 to 1.2 times the
true error."""
LEVELS = 16
"""Levels whose waves are held in the whole basis at once."""
STEEP = 1e9
"""Height at which exponential walls are cut off, in units of the energy: no wave reaches there, and the rounding of
larger values would be in all levels.
"""


class MatrixTooLarge(Exception):
    """The matrix would be larger than it may be: the message has its size and the reason."""


def too_large(size: float, largest: int, parts: tuple[Panels, Panels], narrow: bool) -> MatrixTooLarge:
    """Return the error; narrow: whether features of V make the matrix large, not waves."""
    if not narrow:
        ends = parts[0].edges
        return MatrixTooLarge(
            f"{size:.3g} functions of rho and vartheta, more than {largest}, for waves in rho = {ends[0]:.3g} to "
            f"{ends[-1]:.3g}. Try a larger hbar or a smaller m, l or count."
        )
    place = [int(np.argmin(np.diff(part.edges[1:-1]))) + 1 if part.edges.size > 3 else 0 for part in parts]
    q, x = (float(part.edges[k]) for part, k in zip(parts, place, strict=True))
    return MatrixTooLarge(
        f"{size:.3g} functions of rho and vartheta, more than {largest}: V has narrow features. Widen "
        f"those at rho = {q:.4g} or cos(vartheta) = {x:.4g}."
    )


class _ChannelBasis(NamedTuple):
    """Grid in rho and basis in x: polynomials of nodes, nodes, -d^2/drho^2 + (3/4 - rest)/rho^2 between nodes, rest;
    matrix of L_x; the basis in rho, and the potential less the part that its weight takes.
    """

    rho: ProblemEnds
    grid: np.ndarray
    nodes: np.ndarray
    kinetic: np.ndarray
    rest: float
    angular: Basis
    free: np.ndarray
    radial: Basis
    weights: np.ndarray

    def quotients(self, problem: PlaneProblem, tables: np.ndarray, highest: float) -> np.ndarray:
        """Return the Rayleigh quotients (levels,) of tables (nodes, n_x, levels) as sums over the nodes.

        The matrix has large entries that cancel, with the rounding of the largest; vectors enter squared.
        """
        along = self.radial
        around = self.angular
        inverse = 1 / self.nodes[:, None] ** 2
        f, slope = (np.tensordot(side[0] @ self.grid, tables, 1) for side in (along.values, along.slopes))
        E = np.einsum("i,ijk->k", along.weight[0], slope**2)
        E += np.einsum("i,ijk->k", (along.weight * self.weights)[0], f**2)
        q = 4 * angular_potential(around, problem.a**2, problem.b**2)[0] + self.rest
        U = q * inverse + _at_nodes(problem, around, self.nodes, highest)
        f, slope = (side[0] @ tables for side in (around.values, around.slopes))
        E += np.einsum("ij,ijk->k", around.weight[0] * U, f**2)
        E += np.einsum("ij,ijk->k", 4 * inverse * around.weight[0] * (1 - around.x[0] ** 2), slope**2)
        return E / (tables**2).sum(axis=(0, 1))


def beyond(problem: PlaneProblem, bottom: float, top: float) -> float:
    """Return an energy above the highest level, and below where V ends."""
    return min(bottom + 1.2 * (top - bottom), (top + problem.threshold) / 2)


def sizes(problem: PlaneProblem, near: float, far: float, bottom: float, top: float, density: float) -> tuple[int, int]:
    """Return the numbers of global functions of rho and of x that resolve waves."""
    return int(density * (0.5 * np.sqrt(top - bottom) * (far - near) + 12)), int(
        density * (1.2 * problem.channels(top) + 16)
    )


def _bases(
    problem: PlaneProblem, parts: tuple[Panels, Panels], bottom: float, top: float, density: float
) -> _ChannelBasis:
    with np.errstate(invalid="ignore"):
        near, far = decayed("V", problem.rho, problem.lowest, beyond(problem, bottom, top), 0.0, problem.far)
    n_rho, n_x = sizes(problem, near, far, bottom, top, density)
    n_rho = max(n_rho, parts[0].needed)
    if n_rho > LARGEST or n_x > LARGEST // 2:
        raise too_large(n_rho * n_x, LARGEST, parts, parts[0].needed == n_rho > LARGEST)
    angular = basis(
        angular_interval("V", problem.well, problem.a**2, problem.b**2), n_x, max(n_x // 2 + 16, parts[1].needed - n_x)
    )
    free = angular.matrix(angular_potential(angular, problem.a**2, problem.b**2), 1 - angular.x**2)[0]
    tiny = np.array([1e-6 * far])
    e_lo = inner_exponent(near, tiny[0], _angular_matrices(problem, angular, free, tiny)[0])
    outer = ProblemEnds(near, far, np.array([e_lo]), np.array([1.0]), True, True)
    radial = basis(outer, n_rho, 8)
    weights = 2 * e_lo / (radial.below * radial.above)  # e_lo (e_lo - 1)/rho^2 cancels at rho = 0; it is 0 at a wall
    alpha, beta = 2 * outer.e_hi, 2 * outer.e_lo
    t, w = gauss_jacobi(n_rho, alpha, beta)
    grid = (jacobi_table(n_rho, alpha, beta, t)[0] * np.sqrt(w[0])[:, None]).T
    return _ChannelBasis(
        rho=outer,
        grid=grid,
        nodes=near + (far - near) * (1 + t[0]) / 2,
        kinetic=grid.T @ radial.matrix(weights, 1.0)[0] @ grid,
        rest=0.75 - e_lo * (e_lo - 1),
        angular=angular,
        free=free,
        radial=radial,
        weights=weights,
    )


def inner_exponent(near: float, tiny: float, matrix: np.ndarray) -> float:
    """Return the exponent at the least rho: at rho = 0 that of the lowest channel, from `matrix` at a tiny rho, where
    rho^2 U has its limit.
    """
    return exponent("V", 0.75 + float(np.linalg.eigvalsh(matrix)[0]) * tiny**2, "at phi = 0") if near == 0.0 else 1.0


def by_channels(
    problem: PlaneProblem,
    parts: tuple[Panels, Panels],
    count: int,
    bottom: float,
    top: float,
    cut: float,
    density: float,
    depth: float,
) -> tuple[np.ndarray, Waves, int, np.ndarray]:
    """Return the lowest eigenvalues, their waves, the size, and the errors of the cut, for one cut and density."""
    bases = _bases(problem, parts, bottom, top, density)
    highest = bottom + STEEP * (top - bottom)
    energies, vectors = np.linalg.eigh(_angular_matrices(problem, bases.angular, bases.free, bases.nodes, highest))
    energies = energies + bases.rest / bases.nodes[:, None] ** 2
    kept = _kept(energies, bases.nodes, bottom + cut * (top - bottom), bottom + 1.05 * (top - bottom), depth)
    node, channel = np.nonzero(kept)
    if node.size > LARGEST:
        raise too_large(node.size, LARGEST, parts, False)
    G = vectors[node, :, channel]  # (size, n_x)
    H = G @ G.T
    H *= bases.kinetic[node[:, None], node]
    H[np.arange(node.size), np.arange(node.size)] += energies[node, channel]
    E, C = lowest_states(H, min(count, node.size))
    left = np.empty(len(E))
    height = np.diagonal(bases.kinetic)[:, None] + energies
    for k in range(0, len(E), LEVELS):
        some = slice(k, k + LEVELS)
        within = np.zeros((*kept.shape, len(E[some])))
        within[kept] = C[:, some]
        tables = vectors @ within
        E[some] = bases.quotients(problem, tables, highest)
        outside = (vectors.mT @ np.tensordot(bases.kinetic, tables, 1))[~kept]
        left[some] = TAILS * (outside**2 / np.maximum(height[~kept][:, None] - E[some], top - bottom)).sum(axis=0)
    return E, ChannelWaves(bases.grid, node, G, C, bases.rho, bases.angular.interval), node.size, left


def _kept(energies: np.ndarray, rho: np.ndarray, limit: float, top: float, depth: float) -> np.ndarray:
    """Return the mask (rho, n) of the channels to keep: those below `limit`, and their tails up to an action of `depth`
    at the energy `top`.

    Behind centrifugal barriers waves decay by a power of rho: a cut in energy alone would converge slowly.
    """
    below = energies < limit
    action = np.cumsum(np.sqrt(np.maximum(energies - top, 0)) * np.gradient(rho)[:, None], axis=0)
    first = np.argmax(below, axis=0)
    last = below.shape[0] - 1 - np.argmax(below[::-1], axis=0)
    columns = np.arange(below.shape[1])
    index = np.arange(below.shape[0])[:, None]
    tail = (index < first) & (action[first, columns] - action < depth) | (index > last) & (
        action - action[last, columns] < depth
    )
    between = (index >= first) & (index <= last)
    return (between | tail) & below.any(axis=0)


def cut_off(U: np.ndarray, highest: float) -> np.ndarray:
    """Return U, no more than `highest`; raises ValueError where it is infinite."""
    if not np.all(np.isfinite(U)):
        raise ValueError(
            "model must have a finite potential in its domain, got an infinite one at some alpha, beta inside"
        )
    return np.minimum(U, highest)


def _angular_matrices(
    problem: PlaneProblem, angular: Basis, free: np.ndarray, rho: np.ndarray, highest: float = np.inf
) -> np.ndarray:
    """Return the matrices (rho, n, n) of 4 L_x/rho^2 + U at every rho, U cut off at `highest`."""
    U = _at_nodes(problem, angular, rho, highest)
    values = angular.values[0]
    return free * (4 / rho**2)[:, None, None] + (values * (angular.weight[0] * U)[..., None]).mT @ values


def _at_nodes(problem: PlaneProblem, angular: Basis, rho: np.ndarray, highest: float) -> np.ndarray:
    """Return U (rho, nodes) at every rho and at the nodes of the basis in x, cut off at `highest`."""
    vartheta = 2 * np.arctan2(np.sqrt(1 - angular.x[0]), np.sqrt(1 + angular.x[0]))
    return cut_off(sampled(lambda q: problem.U(q, vartheta), rho[:, None] + 0 * vartheta), highest)
