"""Levels of bodies that do not separate: adiabatic channels in vartheta on a grid in rho."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...flows.interruptible import interruptible
from ..states.level_table import LevelTable, Waves, class_levels, level_scale
from ..states.symmetry import SymmetryClass
from .elements import elements, left_over, lowest, quadratic
from .factor_tables import angle_of
from .jacobi_basis import Basis, Interval, basis, gauss_jacobi, jacobi_table
from .panels import DENSE, Panels, between, merged, panels
from .plane_shape import ChannelWaves, ElementWaves
from .separable import angular_interval, angular_potential
from .singular_ends import NoGroundState, Well, check_bottom, count_top, decayed, exponent, potential, sampled, well

LARGEST = 6000
"""Largest matrix: 0.3 GB each of a handful."""
ELEMENTS = ((8,), (11,), (14,), (18,))
"""The same where V has narrow features: nodes of every element."""
LINES, CLOSE = 48, 3
"""Lines of either coordinate along which V is looked at, and how many of them densely."""
ROUNDS, WORST = 3, 8
"""How often partitions are refined along lines through the points where V is not resolved, and through how many of
them.
"""
PANELS = (120, 30)
"""Panels of rho and of x at most."""
PRODUCTS = 100_000
"""Largest sparse matrix: some 10 s and 1 GB."""
SPECTRAL = 4.0
"""Error of elements in units of the change from a lower degree: 0.1 where V is smooth, 1 at cones."""
ALGEBRAIC = 30.0
"""Error in units of the change from a smaller basis where convergence is algebraic; 26 was the worst seen."""
STEEP = 1e9
"""Where exponential walls are cut off, in units of the energy: no wave reaches there, and its rounding would be that of
all levels.
"""
STEPS = (
    (1.5, 1.15, 10.0),
    (1.8, 1.3, 11.0),
    (2.2, 1.5, 13.0),
    (2.8, 1.75, 15.0),
    (3.6, 2.1, 18.0),
    (4.8, 2.5, 22.0),
    (6.5, 3.0, 26.0),
)
"""Refinements: cut of the channels in units of the energy of the highest level above the bottom, density of both bases,
action to which tails of channels are kept."""


class _Problem(NamedTuple):
    """One class of a body in units hbar^2/2 mu = 1: U(rho, vartheta) = 2 mu V/hbar^2, and samples of it with
    centrifugal terms.

    lowest: the least of every rho, with Langer's 1/rho^2; threshold: what it grows to, inf without bound; smooth:
    whether the weights take all that is not smooth at the ends of vartheta.
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


def plane_levels(
    body: Any,
    chosen: SymmetryClass,
    count: int,
    hbar: float,
    tolerance: float,
    known: list[LevelTable] | None = None,
    report: Callable[[float], None] | None = None,
) -> LevelTable:
    """Compute the lowest levels of a class of a body by adiabatic channels, whether the potential separates or not.

    Parameters and result as in `spectrum` (chosen: its class), which checks them; known: a list that gets the
    levels of each basis. Raises as `spectrum`, and ValueError
    where the potential lives elsewhere than on det phi > 0 or on all of GL(2,R). At every node of a Gauss-Jacobi grid
    in rho the equation in x = cos(vartheta) is solved in Jacobi polynomials; channels below a cut are kept, and the
    matrix of d^2/drho^2 between them is diagonalised (sequential truncation). Weights have the exponents at alpha = 0,
    beta = 0, det phi = 0 and rho = 0. Cut and both bases grow together until two in succession agree: an upper size of
    6000. Source: Bacic & Light 1986, J. Chem. Phys. 85, 4594 (sequential truncation of a discrete variable
    representation).
    """
    unit = hbar**2 / (2 * body.mu)
    problem = _problem(body, chosen, unit)
    bottom = problem.lowest.min()
    top = count_top(
        problem.states, bottom, 1 / problem.rho[np.argmin(problem.lowest)] ** 2, _wanted(problem, count, unit)
    )
    with np.errstate(invalid="ignore"):
        ends = decayed("V", problem.rho, problem.lowest, _beyond(problem, bottom, top), 0.0, np.inf)
    parts = interruptible(_partition, problem, ends, bottom, top)
    smooth = _global(problem, parts, ends, bottom, top)
    grid = (
        "adiabatic channels in vartheta, Gauss-Jacobi grid in rho"
        if smooth
        else "spectral elements in rho and vartheta"
    )

    def table(E: np.ndarray, error: np.ndarray, size: int, waves: Waves) -> LevelTable:
        return class_levels(
            chosen,
            unit * E,
            error,
            np.arange(count)[None],
            tolerance,
            names=("level",),
            constants=np.zeros((0, count)),
            constant_names=(),
            hbar=hbar,
            method=f"not separated: {grid}; f = 0 where V is infinite (Friedrichs)",
            functions=size,
            waves=waves,
        )

    known = [] if known is None else known
    coarse: np.ndarray | None = None
    bases = STEPS if smooth else ELEMENTS
    for number, step in enumerate(bases):
        try:
            E, waves, size, left = interruptible(
                _solve if smooth else _solve_elements, problem, parts, count, bottom, top, *step
            )
        except _TooLarge:
            break
        if report is not None:
            report((number + 1) / len(bases))
        if size < count:
            continue
        gap = np.full(count, np.inf) if coarse is None else np.abs(E - coarse)
        coarse, top = E, max(E[-1], top)
        rounding = 64 * np.finfo(float).eps * (np.abs(E) + abs(top - bottom))
        if not smooth:  # a level that two bases agree on by chance
            gap = np.maximum(gap, 0.1 * np.maximum.accumulate(gap))
        factor = SPECTRAL if not smooth else 1.0 if problem.smooth else ALGEBRAIC
        error = unit * (factor * gap + left + rounding)
        known.append(table(E, error, size, waves))
        if np.all(error <= tolerance * level_scale(unit * E)):
            break
    if not known:
        raise ValueError(
            f"count = {count} needs more than {LARGEST} functions in two dimensions; ask for fewer, or a larger hbar"
        )
    return known[-1]


def _wanted(problem: _Problem, count: int, unit: float) -> float:
    """Return how many states there should be below the top energy; raises where V does not bind the levels."""
    wanted = 1.1 * count + 40
    if np.isinf(problem.threshold):
        return wanted
    bound = problem.states(problem.threshold)
    if bound < count + 0.5:
        raise NoGroundState(
            f"V grows to {unit * problem.threshold:.6g} only at large distance and binds about {bound:.0f} levels of a "
            "class below that; "
            f"count = {count}"
        )
    return min(wanted, (count + bound) / 2)


def _partition(problem: _Problem, ends: tuple[float, float], bottom: float, top: float) -> tuple[Panels, Panels]:
    """Return partitions of rho and of x that resolve V: seen on LINES of the other coordinate, on a few of them
    densely, and between.

    Where points between the lines find something, lines through them are looked at too; what is not resolved then is
    counted.
    """
    x, quasi = _line_x(problem), (np.arange(LINES) * 0.6180339887498949 + 0.31) % 1

    def V(q: np.ndarray, x: np.ndarray) -> np.ndarray:
        return problem.U(q, angle_of(-1.0, 1.0, 1 + x))

    def along(rows: np.ndarray, columns: np.ndarray, dense: int) -> tuple[Panels, Panels]:
        """Partitions of rho as seen at `rows` of x, and of x as seen at `columns` of rho."""
        return (
            panels(lambda q: V(q, rows[:, None]), *ends, bottom, top - bottom, dense, PANELS[0]),
            panels(lambda x: V(columns[:, None], x), *x, bottom, top - bottom, dense, PANELS[1]),
        )

    def refined(parts: tuple[Panels, Panels], more: tuple[Panels, Panels]) -> tuple[Panels, Panels]:
        return merged(parts[0], more[0]), merged(parts[1], more[1])

    rows, columns = (lo + (hi - lo) * quasi for lo, hi in (x, ends))
    few = slice(0, CLOSE)
    found = refined(
        along(np.sort(rows), np.sort(columns), DENSE >> 4), along(np.sort(rows[few]), np.sort(columns[few]), DENSE)
    )
    for _ in range(ROUNDS):
        at, miss = between(V, found, bottom, top - bottom)
        if not miss.size:
            return found
        found = refined(found, along(at[1, :WORST], at[0, :WORST], DENSE))
    at, miss = between(V, found, bottom, top - bottom)
    return found[0].missing(at[0], miss), found[1].missing(at[1], miss)


def _line_x(problem: _Problem) -> tuple[float, float]:
    ends = angular_interval("V", problem.well, problem.a, problem.b)
    return ends.lo, ends.hi


def _global(
    problem: _Problem, parts: tuple[Panels, Panels], ends: tuple[float, float], bottom: float, top: float
) -> bool:
    """Return whether global bases of the usual size resolve V, or nearly."""
    n_rho, n_x = _sizes(problem, *ends, bottom, top, STEPS[0][1])
    return parts[0].needed <= 1.3 * n_rho and parts[1].needed <= 3 * n_x


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
        raise NoGroundState(
            "V falls as fast as -1/rho^2 or faster at phi = 0: the energy is unbounded below, there is no ground state"
        )
    check_bottom("V", place, rho.size, np.inf)
    wells = [
        well("V", lambda angle, q=q: U(q, angle) * q * q / 4, 0.0, np.pi)
        for q in (0.8 * rho[place], rho[place], 1.3 * rho[place])
    ]
    one = wells[1]
    if any(abs(other.hi - one.hi) > 1e-9 or abs(other.lo - one.lo) > 1e-9 for other in wells) or one.lo != 0:
        raise ValueError(
            "the potential must live on det phi > 0 or on all of GL(2,R), alpha > beta or all alpha, beta > 0"
        )
    cell = np.gradient(rho) * rho / 2 * (v[1] - v[0])
    span = rho / 2 * (v[1] - v[0]) / np.pi

    def states(top):
        """Cells of phase space: int int (top - w) dalpha dbeta/(4 pi)."""
        return float((np.maximum(top - w, 0).sum(axis=1) * cell).sum() / (4 * np.pi))

    def channels(top):
        """Semiclassical number of channels below `top`, the most of all rho."""
        return float((np.sqrt(np.maximum(top - w, 0)).sum(axis=1) * span).max())

    strengths = [sum(getattr(x, c) for x in wells) / 3 for c in ("c_lo", "c_hi")]
    uniform = all(
        max(getattr(x, c) for x in wells) - min(getattr(x, c) for x in wells) <= 1e-6 * (1 + abs(s))
        for c, s in zip(("c_lo", "c_hi"), strengths)
    )
    fine = np.pi * (np.arange(200_000) + 0.5) / 200_000  # valleys far out are narrow in vartheta
    before, last = (float(U(q, fine).min()) for q in (1e3, 1e4))
    level_out = last - before < 0.01 * (last - lowest[place])
    smooth = uniform and _even(U, rho[place], one)
    # Strengths that change with rho: no one exponent; that of the free problem, 1 at a wall.
    ends = one if uniform else one._replace(c_lo=0.0, c_hi=0.0)
    return _Problem(U, a, b, ends, rho, lowest, last if level_out else np.inf, smooth, states, channels)


def _even(U: Callable, rho: float, found: Well) -> bool:
    """Return whether V less its singular part is even in vartheta at both natural ends: no cone, as |beta| would
    make.
    """
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
    """Grid in rho and basis in x: polynomials of nodes, nodes, -d^2/drho^2 + (3/4 - rest)/rho^2 between nodes, rest;
    matrix of L_x.
    """

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


def _sizes(problem: _Problem, near: float, far: float, bottom: float, top: float, density: float) -> tuple[int, int]:
    """Return how many global functions of rho and of x resolve waves."""
    return int(density * (0.5 * np.sqrt(top - bottom) * (far - near) + 12)), int(
        density * (1.2 * problem.channels(top) + 16)
    )


def _bases(problem: _Problem, parts: tuple[Panels, Panels], bottom: float, top: float, density: float) -> _Bases:
    with np.errstate(invalid="ignore"):
        near, far = decayed("V", problem.rho, problem.lowest, _beyond(problem, bottom, top), 0.0, np.inf)
    n_rho, n_x = _sizes(problem, near, far, bottom, top, density)
    n_rho = max(n_rho, parts[0].needed)
    if n_rho > LARGEST or n_x > LARGEST // 2:
        raise _TooLarge
    angular = basis(
        angular_interval("V", problem.well, problem.a, problem.b), n_x, max(n_x // 2 + 16, parts[1].needed - n_x)
    )
    free = angular.matrix(angular_potential(angular, problem.a, problem.b), 1 - angular.x**2)[0]
    tiny = np.array([1e-6 * far])
    e_lo = _inner_exponent(near, tiny[0], _angular_matrices(problem, angular, free, tiny)[0])
    outer = Interval(near, far, np.array([e_lo]), np.array([1.0]), True, True)
    radial = basis(outer, n_rho, 8)
    weights = 2 * e_lo / (radial.below * radial.above)  # e_lo (e_lo - 1)/rho^2 cancels at rho = 0; it is 0 at a wall
    alpha, beta = 2 * outer.e_hi, 2 * outer.e_lo
    t, w = gauss_jacobi(n_rho, alpha, beta)
    grid = (jacobi_table(n_rho, alpha, beta, t)[0] * np.sqrt(w[0])[:, None]).T
    return _Bases(
        outer,
        grid,
        near + (far - near) * (1 + t[0]) / 2,
        grid.T @ radial.matrix(weights, 1.0)[0] @ grid,
        0.75 - e_lo * (e_lo - 1),
        angular,
        free,
    )


def _inner_exponent(near: float, tiny: float, matrix: np.ndarray) -> float:
    """Return the exponent at the least rho: at 0 of the lowest channel, whose matrix at a tiny rho has rho^2 U where it
    has a limit.
    """
    return exponent("V", 0.75 + float(np.linalg.eigvalsh(matrix)[0]) * tiny**2, "at phi = 0") if near == 0.0 else 1.0


def _solve(
    problem: _Problem,
    parts: tuple[Panels, Panels],
    count: int,
    bottom: float,
    top: float,
    cut: float,
    density: float,
    depth: float,
) -> tuple[np.ndarray, Waves, int, float]:
    """Return the lowest eigenvalues, their waves, the size, and what is not resolved, for one cut and density."""
    from scipy.linalg import eigh

    bases = _bases(problem, parts, bottom, top, density)
    energies, vectors = np.linalg.eigh(
        _angular_matrices(problem, bases.angular, bases.free, bases.nodes, bottom + STEEP * (top - bottom))
    )
    energies = energies + bases.rest / bases.nodes[:, None] ** 2
    kept = _kept(energies, bases.nodes, bottom + cut * (top - bottom), bottom + 1.05 * (top - bottom), depth)
    node, channel = np.nonzero(kept)
    if node.size > LARGEST:
        raise _TooLarge
    G = vectors[node, :, channel]  # (size, n_x)
    H = G @ G.T
    H *= bases.kinetic[node[:, None], node]
    H[np.arange(node.size), np.arange(node.size)] += energies[node, channel]
    E, C = eigh(H, subset_by_index=(0, min(count, node.size) - 1), overwrite_a=True, check_finite=False, driver="evr")
    return E, ChannelWaves(bases.grid, node, G, C, bases.rho, bases.angular.interval), node.size, 0.0


def _solve_elements(
    problem: _Problem, parts: tuple[Panels, Panels], count: int, bottom: float, top: float, n: int
) -> tuple[np.ndarray, Waves, int, np.ndarray]:
    """Return as `_solve` in products of the functions of elements, n nodes each: V is diagonal, the matrix sparse."""
    from scipy.sparse import diags, identity, kron

    rho, x = (part.cut(phases) for part, phases in zip(parts, _phases(problem, parts, bottom, top), strict=True))
    if (rho.missed.size * (n - 1) + 1) * (x.missed.size * (n - 1) + 1) > PRODUCTS:
        raise _TooLarge
    v = angular_interval("V", problem.well, problem.a, problem.b)
    angles = elements(x.edges, n, float(v.e_lo[0]), float(v.e_hi[0]), v.wall_lo, v.wall_hi)
    quanta = (np.full(len(angles.x), side[0]) for side in (problem.a, problem.b))
    around = 1 - angles.x**2, angular_potential(angles, *quanta)
    turning = angles.assembled(*around)
    vartheta = angles.shared(angle_of(angles.lo, angles.hi, angles.below))

    def V(q):
        return _cut_off(sampled(lambda v: problem.U(q, v), vartheta), bottom + STEEP * (top - bottom))

    near, tiny = rho.edges[0], 1e-6 * rho.edges[-1]
    e_lo = _inner_exponent(near, tiny, (turning * (4 / tiny**2) + diags(V(tiny))).toarray()) if near == 0 else 1.0
    radii = elements(rho.edges, n, e_lo, 1.0, True, True)
    q = 0.75 / radii.x**2
    q[0] -= e_lo * (e_lo - 1) / radii.below[0] ** 2
    along = np.ones_like(q), q
    nodes = radii.shared(radii.x)
    U = V(nodes[:, None])
    matrix = (
        kron(radii.assembled(*along), identity(angles.size)) + kron(diags(4 / nodes**2), turning) + diags(U.ravel())
    )
    tables = lowest(matrix.tocsc(), count, bottom, 0.01 * (top - bottom)).T.reshape(count, *U.shape)
    E, left = np.empty(count), np.empty(count)
    for k, c in enumerate(tables):
        E[k] = quadratic(radii, *along, c).sum() + quadratic(angles, *around, c.T) @ (4 / nodes**2) + (U * c**2).sum()
        sides = (np.sqrt((c**2).sum(axis=axis))[:, None] for axis in (1, 0))
        left[k] = sum(
            left_over(line, part.missed, side)[0]
            for line, part, side in zip((radii, angles), (rho, x), sides, strict=True)
        )
    order = np.argsort(E)
    return E[order], ElementWaves(radii, angles, tables[order]), U.size, left[order]


def _phases(
    problem: _Problem, parts: tuple[Panels, Panels], bottom: float, top: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the phases of the shortest waves over the panels of rho and of x."""
    rho, x = parts
    lowest = np.interp(np.hstack([rho.points, rho.edges[1:, None]]), problem.rho, problem.lowest).min(axis=1)
    turns = np.sqrt(np.maximum(top - problem.lowest, 0) * problem.rho**2).max() / 2
    return np.diff(rho.edges) * np.sqrt(np.maximum(top - lowest, 0)), -np.diff(
        np.arccos(np.clip(x.edges, -1, 1))
    ) * turns


def _kept(energies: np.ndarray, rho: np.ndarray, limit: float, top: float, depth: float) -> np.ndarray:
    """Return which channels (rho, n) to keep: those below `limit`, and their tails until an action of `depth` at the
    energy `top`.

    Behind centrifugal barriers waves decay by a power of rho: a cut in energy alone would converge slowly.
    """
    below = energies < limit
    action = np.cumsum(np.sqrt(np.maximum(energies - top, 0)) * np.gradient(rho)[:, None], axis=0)
    first, last = np.argmax(below, axis=0), below.shape[0] - 1 - np.argmax(below[::-1], axis=0)
    columns = np.arange(below.shape[1])
    index = np.arange(below.shape[0])[:, None]
    tail = (index < first) & (action[first, columns] - action < depth) | (index > last) & (
        action - action[last, columns] < depth
    )
    between = (index >= first) & (index <= last)
    return (between | tail) & below.any(axis=0)


def _cut_off(U: np.ndarray, highest: float) -> np.ndarray:
    """Return U, no more than `highest`; raises ValueError where it is infinite."""
    if not np.all(np.isfinite(U)):
        raise ValueError(
            "the potential must be finite on all of det phi > 0 or of GL(2,R); it is infinite at some alpha, beta "
            "inside"
        )
    return np.minimum(U, highest)


def _angular_matrices(
    problem: _Problem, angular: Basis, free: np.ndarray, rho: np.ndarray, highest: float = np.inf
) -> np.ndarray:
    """Return the matrices (rho, n, n) of 4 L_x/rho^2 + U at every rho, U cut off at `highest`."""
    vartheta = 2 * np.arctan2(np.sqrt(1 - angular.x[0]), np.sqrt(1 + angular.x[0]))
    U = sampled(lambda q: problem.U(q, vartheta), rho[:, None] + 0 * vartheta)
    values, U = angular.values[0], _cut_off(U, highest)
    return free * (4 / rho**2)[:, None, None] + (values * (angular.weight[0] * U)[..., None]).mT @ values
