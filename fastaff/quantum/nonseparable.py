"""Levels of bodies that do not separate: adiabatic channels in vartheta on a grid in rho (layer L3)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..charts import R_VARTHETA, Chart
from .ends import NoGroundState, Well, check_bottom, count_top, decayed, exponent, potential, sampled, well
from .interruptible import interruptible
from .levels import Levels, level_scale
from .separable import angle_of, angular_interval, angular_potential
from .solvers import Basis, Interval, basis, gauss_jacobi, interval_rule, interval_weight, jacobi_table
from .symmetry import SymmetryClass

POINTS = 4096
"""Points whose polynomials are tabulated at once."""
LARGEST = 6000
"""Largest matrix: 0.3 GB each of a handful."""
ALGEBRAIC = 30.0
"""Error in units of the change from a smaller basis where convergence is algebraic; 26 was the worst seen."""
STEEP = 1e9
"""Where exponential walls are cut off, in units of the energy: no wave reaches there, and its rounding would be that of all levels."""
STEPS = ((1.5, 1.15, 10.0), (1.8, 1.3, 11.0), (2.2, 1.5, 13.0), (2.8, 1.75, 15.0), (3.6, 2.1, 18.0), (4.8, 2.5, 22.0), (6.5, 3.0, 26.0))
"""Refinements: cut of the channels in units of the energy of the highest level above the bottom, density of both bases,
action to which tails of channels are kept."""


class PlaneShape(NamedTuple):
    """A(r, vartheta) = rho^-3/2 u(rho, x)/pi of x = cos(vartheta); u: weights of two intervals times a sum of products of polynomials.

    coefficients (n_rho, n_x); int u^2 drho dx = 1.
    """

    rho: Interval
    x: Interval
    coefficients: np.ndarray

    @property
    def chart(self) -> Chart:
        """The chart r, vartheta."""
        return R_VARTHETA

    @property
    def degrees(self) -> tuple[int, int]:
        """Return the degrees of the polynomials."""
        n, k = self.coefficients.shape
        return n - 1, k - 1

    def __call__(self, r: np.ndarray, vartheta: np.ndarray) -> np.ndarray:
        """Return A (...) at r, vartheta (...); 0 where V is infinite or A has decayed below rounding."""
        rho, half = np.sqrt(r), np.asarray(vartheta) / 2
        return self.of_radii(rho * np.cos(half), rho * np.sin(half))

    def of_radii(self, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """Return A (...) at alpha, beta (...) >= 0."""
        out = np.empty(np.shape(alpha))
        flat, a, b = out.reshape(-1), np.ravel(alpha), np.ravel(beta)
        for start in range(0, flat.size, POINTS):
            some = slice(start, start + POINTS)
            flat[some] = self._of(a[some], b[some])
        return out

    def _of(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        u, v, q = self.rho, self.x, np.hypot(a, b)
        sine, cosine = b / np.where(q > 0, q, 1.0), np.where(q > 0, a, 1.0) / np.where(q > 0, q, 1.0)
        below = 2 * cosine**2 if v.lo == -1 else (cosine - sine) * (cosine + sine) - v.lo
        first = _side(self.coefficients.shape[1], v, below, 2 * sine**2, 0.0)
        second = _side(self.coefficients.shape[0], u, q - u.lo, u.hi - q, 0.0 if u.lo else -1.5)
        values = np.einsum("pi,pi->p", second @ self.coefficients, first) / np.pi
        return values * np.maximum(q, u.lo) ** -1.5 if u.lo else values

    def rule(self, orders: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return Gauss nodes r (i,), vartheta (j,) and weights (i, j)."""
        (q, w), (below, v) = (
            interval_rule(ends.lo, ends.hi, float(ends.e_lo[0]), float(ends.e_hi[0]), order)
            for ends, order in zip((self.rho, self.x), orders, strict=True)
        )
        q = self.rho.lo + q
        return q * q, angle_of(self.x.lo, self.x.hi, below), np.outer(np.pi**2 * w * q**3, v)


def _side(n: int, ends: Interval, below: np.ndarray, above: np.ndarray, shift: float) -> np.ndarray:
    """Return n weighted polynomials (points, n) at distances from the ends; 0 outside."""
    middle = (ends.hi - ends.lo) / 2
    inside = (below >= 0) & (above >= 0)
    low, high = np.where(inside, below, middle), np.where(inside, above, middle)
    t = np.clip((low - high) / (ends.hi - ends.lo), -1, 1).reshape(1, -1)
    weight = interval_weight(ends.lo, ends.hi, float(ends.e_lo[0]), float(ends.e_hi[0]), low, high, shift)
    inside &= weight > 1e-300
    table = jacobi_table(n, 2 * ends.e_hi, 2 * ends.e_lo, np.where(inside, t, 0.0))[0]
    return table * np.where(inside, weight, 0.0)[:, None]


class _Problem(NamedTuple):
    """One class of a body in units hbar^2/2 mu = 1: U(rho, vartheta) = 2 mu V/hbar^2, and samples of it with centrifugal terms.

    lowest: the least of every rho, with Langer's 1/rho^2; threshold: what it grows to, inf without bound; smooth: whether the weights
    take all that is not smooth at the ends of vartheta.
    """

    U: Callable
    a: np.ndarray
    b: np.ndarray
    well: Well
    rho: np.ndarray
    lowest: np.ndarray
    threshold: float
    smooth: bool
    states: Callable
    channels: Callable


def plane_levels(body: Any, chosen: SymmetryClass, levels: int, hbar: float, tolerance: float) -> Levels:
    """Compute the lowest levels of a class of a body by adiabatic channels, whether the potential separates or not.

    Parameters and result as in `spectrum` (chosen: its class), which checks them. Raises as `spectrum`, and ValueError where
    the potential lives elsewhere than on det phi > 0 or on all of GL(2,R).
    At every node of a Gauss-Jacobi grid in rho the equation in x = cos(vartheta) is solved in Jacobi polynomials; channels below a cut
    are kept, and the matrix of d^2/drho^2 between them is diagonalised (sequential truncation). Weights have the exponents at
    alpha = 0, beta = 0, det phi = 0 and rho = 0. Cut and both bases grow together until two in succession agree: an upper size of 6000.
    Source: Bacic & Light 1986, J. Chem. Phys. 85, 4594 (sequential truncation of a discrete variable representation).
    """
    unit = hbar**2 / (2 * body.mu)
    problem = _problem(body, chosen, unit)
    bottom = problem.lowest.min()
    top = count_top(problem.states, bottom, 1 / problem.rho[np.argmin(problem.lowest)] ** 2, _wanted(problem, levels, unit))
    coarse, size = None, 0
    for step in STEPS:
        try:
            E, states, found_size = interruptible(_solve, problem, levels, bottom, top, *step)
        except _TooLarge:
            break
        if found_size < levels:
            continue
        size = found_size
        gap = np.full(levels, np.inf) if coarse is None else np.abs(E - coarse)
        coarse, make, top = E, states, max(E[-1], top)
        error = unit * ((1 if problem.smooth else ALGEBRAIC) * gap + 64 * np.finfo(float).eps * (np.abs(E) + abs(top - bottom)))
        converged = error <= tolerance * level_scale(unit * E)
        if converged.all():
            break
    if size == 0:
        raise ValueError(f"levels = {levels} needs more than {LARGEST} functions in two dimensions; ask for fewer, or a larger hbar")
    method = "not separated: adiabatic channels in vartheta, Gauss-Jacobi grid in rho; f = 0 where V is infinite (Friedrichs)"
    return Levels(
        unit * coarse, error, converged, None, None, chosen.m, chosen.l, hbar, size, method, lambda k: (make(k), {"level": k}, {})
    )


def _wanted(problem: _Problem, levels: int, unit: float) -> float:
    """Return how many states there should be below the top energy; raises where V does not bind the levels."""
    wanted = 1.1 * levels + 40
    if np.isinf(problem.threshold):
        return wanted
    bound = problem.states(problem.threshold)
    if bound < levels + 0.5:
        raise NoGroundState(
            f"V grows to {unit * problem.threshold:.6g} only at large distance and binds about {bound:.0f} levels of a class below that; "
            f"levels = {levels}"
        )
    return min(wanted, (levels + bound) / 2)


class _TooLarge(Exception):
    """The matrix would be larger than LARGEST."""


def _problem(body: Any, chosen: SymmetryClass, unit: float) -> _Problem:
    a, b = np.array([chosen.a]), np.array([chosen.b])

    def U(rho, vartheta):
        A, B = (rho * np.cos(vartheta / 2)) ** 2, (rho * np.sin(vartheta / 2)) ** 2
        with np.errstate(over="ignore"):
            return potential(body, A, B) / unit

    rho, v = np.geomspace(1e-4, 1e4, 1601), np.pi * (np.arange(256) + 0.5) / 256
    grid = U(rho[:, None], v)
    with np.errstate(over="ignore"):
        w = grid + (a**2 / np.cos(v / 2) ** 2 + b**2 / np.sin(v / 2) ** 2) / rho[:, None] ** 2
    lowest = w.min(axis=1) + 1 / rho**2
    place = int(np.argmin(lowest))
    if not np.isfinite(lowest[place]):
        raise ValueError("the potential is finite nowhere")
    if place == 0 and lowest[0] < 0:
        raise NoGroundState("V falls as fast as -1/rho^2 or faster at phi = 0: the energy is unbounded below, there is no ground state")
    check_bottom("V", place, rho.size, np.inf)
    wells = [well("V", lambda angle, q=q: U(q, angle) * q * q / 4, 0.0, np.pi) for q in (0.8 * rho[place], rho[place], 1.3 * rho[place])]
    one = wells[1]
    if any(abs(other.hi - one.hi) > 1e-9 or abs(other.lo - one.lo) > 1e-9 for other in wells) or one.lo != 0:
        raise ValueError("the potential must live on det phi > 0 or on all of GL(2,R), alpha > beta or all alpha, beta > 0")
    cell = np.gradient(rho) * rho / 2 * (v[1] - v[0])
    span = rho / 2 * (v[1] - v[0]) / np.pi

    def states(top):
        """Cells of phase space: int int (top - w) dalpha dbeta/(4 pi)."""
        return float((np.maximum(top - w, 0).sum(axis=1) * cell).sum() / (4 * np.pi))

    def channels(top):
        """Semiclassical number of channels below `top`, the most of all rho."""
        return float((np.sqrt(np.maximum(top - w, 0)).sum(axis=1) * span).max())

    strengths = [sum(getattr(x, c) for x in wells) / 3 for c in ("c_lo", "c_hi")]
    uniform = all(max(getattr(x, c) for x in wells) - min(getattr(x, c) for x in wells) <= 1e-6 * (1 + abs(s))
                  for c, s in zip(("c_lo", "c_hi"), strengths))  # fmt: skip
    fine = np.pi * (np.arange(200_000) + 0.5) / 200_000  # valleys far out are narrow in vartheta
    before, last = (float(U(q, fine).min()) for q in (1e3, 1e4))
    level_out = last - before < 0.01 * (last - lowest[place])
    smooth = uniform and _even(U, rho[place], one)
    # Strengths that change with rho: no one exponent; that of the free problem, 1 at a wall.
    ends = one if uniform else one._replace(c_lo=0.0, c_hi=0.0)
    return _Problem(U, a, b, ends, rho, lowest, last if level_out else np.inf, smooth, states, channels)


def _even(U: Callable, rho: float, found: Well) -> bool:
    """Return whether V less its singular part is even in vartheta at both natural ends: no cone, as |beta| would make."""
    for natural, c, end, sign in ((found.natural_lo, found.c_lo, 0.0, 1), (found.natural_hi, found.c_hi, np.pi, -1)):
        if not natural:
            continue
        d = np.array([0.01, 0.02, 0.04])
        V = U(rho, end + sign * d) * rho**2 / 4 - c / d**2
        rise, next_rise = abs(V[1] - V[0]), abs(V[2] - V[1])
        if rise > 1e-9 * np.abs(V).max() and next_rise < 3 * rise:  # 2 for a cone, 4 for a smooth top
            return False
    return True


class _Bases(NamedTuple):
    """Grid in rho and basis in x: polynomials of nodes, nodes, -d^2/drho^2 + (3/4 - rest)/rho^2 between nodes, rest; matrix of L_x."""

    rho: Interval
    grid: np.ndarray
    nodes: np.ndarray
    kinetic: np.ndarray
    rest: float
    angular: Basis
    free: np.ndarray


def _beyond(problem: _Problem, bottom: float, top: float) -> float:
    """Return an energy above the highest level, and below where V ends."""
    return min(bottom + 1.2 * (top - bottom), (top + problem.threshold) / 2)


def _bases(problem: _Problem, bottom: float, top: float, density: float) -> _Bases:
    with np.errstate(invalid="ignore"):
        near, far = decayed("V", problem.rho, problem.lowest, _beyond(problem, bottom, top), 0.0, np.inf)
    n_rho = int(density * (0.5 * np.sqrt(top - bottom) * (far - near) + 12))
    n_x = int(density * (1.2 * problem.channels(top) + 16))
    angular = basis(angular_interval("V", problem.well, problem.a, problem.b), n_x, n_x // 2 + 16)
    free = angular.matrix(angular_potential(angular, problem.a, problem.b), 1 - angular.x**2)[0]
    # At rho -> 0 the lowest channel gives the exponent: rho^2 U is part of the angular problem where it has a limit.
    tiny = np.array([1e-6 * far])
    zero = float(np.linalg.eigvalsh(_angular_matrices(problem, angular, free, tiny))[0, 0] * tiny[0] ** 2)
    e_lo = exponent("V", 0.75 + zero, "at phi = 0") if near == 0.0 else 1.0
    outer = Interval(near, far, np.array([e_lo]), np.array([1.0]), True, True)
    radial = basis(outer, n_rho, 8)
    weights = 2 * e_lo / (radial.below * radial.above)  # e_lo (e_lo - 1)/rho^2 cancels at rho = 0; it is 0 at a wall
    alpha, beta = 2 * outer.e_hi, 2 * outer.e_lo
    t, w = gauss_jacobi(n_rho, alpha, beta)
    grid = (jacobi_table(n_rho, alpha, beta, t)[0] * np.sqrt(w[0])[:, None]).T
    return _Bases(
        outer, grid, near + (far - near) * (1 + t[0]) / 2, grid.T @ radial.matrix(weights, 1.0)[0] @ grid, 0.75 - e_lo * (e_lo - 1),
        angular, free,
    )  # fmt: skip


def _solve(
    problem: _Problem, levels: int, bottom: float, top: float, cut: float, density: float, depth: float
) -> tuple[np.ndarray, Callable, int]:
    """Return the lowest eigenvalues, a maker of states, and the size, for one cut and density."""
    from scipy.linalg import eigh

    bases = _bases(problem, bottom, top, density)
    energies, vectors = np.linalg.eigh(_angular_matrices(problem, bases.angular, bases.free, bases.nodes, bottom + STEEP * (top - bottom)))
    energies = energies + bases.rest / bases.nodes[:, None] ** 2
    kept = _kept(energies, bases.nodes, bottom + cut * (top - bottom), bottom + 1.05 * (top - bottom), depth)
    node, channel = np.nonzero(kept)
    if node.size > LARGEST:
        raise _TooLarge
    G = vectors[node, :, channel]  # (size, n_x)
    H = G @ G.T
    H *= bases.kinetic[node[:, None], node]
    H[np.arange(node.size), np.arange(node.size)] += energies[node, channel]
    E, C = eigh(H, subset_by_index=(0, min(levels, node.size) - 1), overwrite_a=True, check_finite=False, driver="evr")

    def state(k):
        table = np.zeros((bases.nodes.size, G.shape[1]))
        np.add.at(table, node, C[:, k, None] * G)
        table = bases.grid @ table
        return PlaneShape(bases.rho, bases.angular.interval, np.sign(table.flat[np.argmax(np.abs(table))]) * table)

    return E, state, node.size


def _kept(energies: np.ndarray, rho: np.ndarray, limit: float, top: float, depth: float) -> np.ndarray:
    """Return which channels (rho, n) to keep: those below `limit`, and their tails until an action of `depth` at the energy `top`.

    Behind centrifugal barriers waves decay by a power of rho: a cut in energy alone would converge slowly.
    """
    below = energies < limit
    action = np.cumsum(np.sqrt(np.maximum(energies - top, 0)) * np.gradient(rho)[:, None], axis=0)
    first, last = np.argmax(below, axis=0), below.shape[0] - 1 - np.argmax(below[::-1], axis=0)
    columns = np.arange(below.shape[1])
    index = np.arange(below.shape[0])[:, None]
    tail = (index < first) & (action[first, columns] - action < depth) | (index > last) & (action - action[last, columns] < depth)
    return below | tail & below.any(axis=0)


def _angular_matrices(problem: _Problem, angular: Basis, free: np.ndarray, rho: np.ndarray, highest: float = np.inf) -> np.ndarray:
    """Return the matrices (rho, n, n) of 4 L_x/rho^2 + U at every rho, U cut off at `highest`."""
    vartheta = 2 * np.arctan2(np.sqrt(1 - angular.x[0]), np.sqrt(1 + angular.x[0]))
    U = sampled(lambda q: problem.U(q, vartheta), rho[:, None] + 0 * vartheta)
    if not np.all(np.isfinite(U)):
        raise ValueError("the potential must be finite on all of det phi > 0 or of GL(2,R); it is infinite at some alpha, beta inside")
    values, U = angular.values[0], np.minimum(U, highest)
    return free * (4 / rho**2)[:, None, None] + (values * (angular.weight[0] * U)[..., None]).mT @ values
