"""Levels of bodies that do not separate: adiabatic channels in vartheta on a grid in rho."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ...flows.interruptible import interruptible
from ..states.level_table import LevelTable, Waves, class_levels, level_scale
from ..states.symmetry import SymmetryClass
from .channels import STEEP, Problem, TooLarge, beyond, by_channels, cut_off, inner_exponent, sizes, too_large
from .cover import Cover, plane_cover
from .elements import elements, left_over, lowest, quadratic
from .factor_tables import angle_of
from .panels import DENSE, Panels, between, merged, panels
from .plane_shape import ElementWaves
from .separable import angular_interval, angular_potential, by_chance
from .singular_ends import (
    NoGroundState,
    Well,
    check_bottom,
    check_poles,
    count_top,
    decayed,
    potential,
    sampled,
    well,
)

ELEMENTS = ((5,), (6,), (8,), (11,), (14,), (18,))
"""Nodes of every element where V has narrow features: bases from small to large."""
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
ANGLES = 200
"""Nodes of x that a global basis may take at little cost, however few its functions."""
SPECTRAL = 4.0
"""Error of elements in units of the change from a lower degree: 0.1 where V is smooth, 1 at cones."""
SMOOTH = 0.5
"""Error of global bases in units of the change from a smaller one: 0.1 as a rule, and what is cut off counts too."""
ALGEBRAIC = 30.0
"""Error in units of the change from a smaller basis where convergence is algebraic; 26 was the worst seen."""
STEPS = (
    (1.3, 1.0, 9.0),
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


SPARE, FAR = (40, 6), 600
"""States more than are asked for, and functions of rho beyond which there are fewer of them."""
SMALLER = {True: 1, False: 2}
"""How many bases, global ones or elements, are only for comparison where there is no room for larger ones."""


def plane_levels(
    body: Any,
    chosen: SymmetryClass,
    count: int,
    hbar: float,
    tolerance: float,
    known: list[LevelTable] | None = None,
    report: Callable[[float], None] | None = None,
    limit: float = np.inf,
) -> LevelTable:
    """Compute the lowest levels of a class of a body by adiabatic channels, whether the potential separates or not.

    Parameters and result as in `spectrum` (chosen: its class), which checks them; known: a list that gets the
    levels of each basis; limit: as in `radial`. Raises as `spectrum`, and ValueError
    where the potential lives elsewhere than on det phi > 0 or on all of GL(2,R). At every node of a Gauss-Jacobi grid
    in rho the equation in x = cos(vartheta) is solved in Jacobi polynomials; channels below a cut are kept, and the
    matrix of d^2/drho^2 between them is diagonalised (sequential truncation). Weights have the exponents at alpha = 0,
    beta = 0, det phi = 0 and rho = 0. Cut and both bases grow together until two in succession agree: an upper size of
    6000. Source: Bacic & Light 1986, J. Chem. Phys. 85, 4594 (sequential truncation of a discrete variable
    representation).
    """
    unit = hbar**2 / (2 * body.mu)
    problem = _problem(body, chosen, unit, limit)
    bottom, top = _range(problem, count, unit)
    seen = interruptible(_seen, problem, body, unit, bottom, top)
    hidden = seen.unseen([problem.rho, np.cos(problem.v[::-1])])
    if hidden.low.size:
        problem = _problem(body, chosen, unit, limit, hidden)
        bottom, top = _range(problem, count, unit)
    with np.errstate(invalid="ignore"):
        ends = decayed("V", problem.rho, problem.lowest, beyond(problem, bottom, top), 0.0, problem.far)
    parts = interruptible(_partition, problem, ends, bottom, top, hidden)
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
            method=f"not separated: {grid}; f = 0 where V is infinite (Friedrichs){seen.said}",
            functions=size,
            waves=waves,
        )

    known = [] if known is None else known
    bases, start = STEPS if smooth else ELEMENTS, SMALLER[smooth]
    done: list[tuple] = []
    why: object = (
        f"other functions than those of |m - l| = {2 * chosen.a:g} and |m + l| = {2 * chosen.b:g}, whose barriers are "
        "so unlike V that none of them are near its levels; take smaller m and l, or a larger hbar"
    )

    def solved(number: int) -> tuple | None:
        """The levels of one basis, or None where it has no room for them."""
        nonlocal why
        try:
            found = interruptible(
                by_channels if smooth else _solve_elements, problem, parts, count, bottom, top, *bases[number]
            )
        except TooLarge as reason:
            why = reason
            return None
        return found if found[2] >= count else None

    def keep() -> np.ndarray:
        """Add the table of the largest basis so far to those known; return its errors."""
        E, waves, size, left = done[-1]
        gap = by_chance(np.abs(E - done[-2][0])) if len(done) > 1 else np.full(count, np.inf)
        rounding = 64 * np.finfo(float).eps * (np.abs(E) + abs(top - bottom))
        factor = SPECTRAL if not smooth else SMOOTH if problem.smooth else ALGEBRAIC
        error = unit * (factor * gap + left + rounding + seen.lost(E))
        known.append(table(E, error, size, waves))
        return error

    for number in range(start, len(bases)):
        found = solved(number)
        if found is None and (done or isinstance(why, TooLarge)):
            break
        if found is not None:
            done.append(found)
            top = max(found[0][-1], top)
            if np.all(keep() <= tolerance * level_scale(unit * found[0])):
                break
        if report is not None:
            report((number + 1) / len(bases))
    for number in range(start - 1, -1, -1):
        if len(done) < 2 and (found := solved(number)) is not None:
            done.insert(0, found)
            keep()
    if not known:
        raise ValueError(f"count = {count} needs {why}")
    return known[-1]


def _range(problem: Problem, count: int, unit: float) -> tuple[float, float]:
    """Return the bottom of V, and an energy below which there are `count` levels and more, fewer of them where they
    reach far, as next to a limit of V.
    """
    bottom = float(problem.lowest.min())
    step = 1 / float(problem.rho[np.argmin(problem.lowest)]) ** 2
    for spare in SPARE:
        top = count_top(problem.states, bottom, step, _wanted(problem, count, unit, spare))
        try:
            with np.errstate(invalid="ignore"):
                ends = decayed("V", problem.rho, problem.lowest, beyond(problem, bottom, top), 0.0, problem.far)
        except NoGroundState:
            if spare == SPARE[-1]:
                raise
            continue
        if sizes(problem, *ends, bottom, top, 1.0)[0] < FAR:
            break
    return bottom, top


def _seen(problem: Problem, body: Any, unit: float, bottom: float, top: float) -> Cover:
    """Return where V may be below the top energy."""
    quanta = float(problem.a[0]), float(problem.b[0])
    ends = float(problem.rho[0]), float(problem.rho[-1])
    return plane_cover(body, quanta, ends, problem.well.hi < 3, top, top - bottom, unit)


def _wanted(problem: Problem, count: int, unit: float, spare: int) -> float:
    """Return how many states there should be below the top energy; raises where V does not bind the levels."""
    wanted = 1.1 * count + spare
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


def _partition(
    problem: Problem, ends: tuple[float, float], bottom: float, top: float, hidden: Cover
) -> tuple[Panels, Panels]:
    """Return partitions of rho and of x that resolve V: seen on LINES of the other coordinate, on a few of them
    densely, between, and where wells are hidden.

    Where points between the lines find something, lines through them are looked at too; what is not resolved then is
    counted. What V misses where states hardly reach counts as little.
    """
    share = partial(problem.share, top=top)
    x, quasi = _line_x(problem), (np.arange(LINES) * 0.6180339887498949 + 0.31) % 1

    def V(q: np.ndarray, x: np.ndarray) -> np.ndarray:
        return problem.U(q, angle_of(-1.0, 1.0, 1 + x))

    thin = np.stack([hidden.lo, hidden.hi], axis=1)

    def along(rows: np.ndarray, columns: np.ndarray, dense: int) -> tuple[Panels, Panels]:
        """Partitions of rho as seen at `rows` of x, and of x as seen at `columns` of rho."""
        return (
            panels(lambda q: V(q, rows[:, None]), *ends, bottom, top - bottom, dense, PANELS[0], thin[0]),
            panels(
                lambda x: bottom + share(columns[:, None]) * (V(columns[:, None], x) - bottom),
                *x,
                bottom,
                top - bottom,
                dense,
                PANELS[1],
                thin[1],
            ),
        )

    def refined(parts: tuple[Panels, Panels], more: tuple[Panels, Panels]) -> tuple[Panels, Panels]:
        return merged(parts[0], more[0]), merged(parts[1], more[1])

    rows, columns = (lo + (hi - lo) * quasi for lo, hi in (x, ends))
    deep = hidden.at[:, np.argsort(hidden.low)[:WORST]]
    few = slice(0, CLOSE)
    found = refined(
        along(np.sort(np.append(rows, deep[1])), np.sort(np.append(columns, deep[0])), DENSE >> 4),
        along(np.sort(rows[few]), np.sort(columns[few]), DENSE),
    )
    for _ in range(ROUNDS):
        at, miss = between(V, found, bottom, top - bottom, share)
        if not miss.size:
            return found
        found = refined(found, along(at[1, :WORST], at[0, :WORST], DENSE))
    at, miss = between(V, found, bottom, top - bottom, share)
    return found[0].missing(at[0], miss), found[1].missing(at[1], miss * share(at[0]))


def _line_x(problem: Problem) -> tuple[float, float]:
    ends = angular_interval("V", problem.well, problem.a, problem.b)
    return ends.lo, ends.hi


def _global(
    problem: Problem, parts: tuple[Panels, Panels], ends: tuple[float, float], bottom: float, top: float
) -> bool:
    """Return whether global bases of the usual size resolve V, or nearly."""
    n_rho, n_x = sizes(problem, *ends, bottom, top, STEPS[0][1])
    return parts[0].needed <= 1.3 * n_rho and parts[1].needed <= max(3 * n_x, ANGLES)


def _problem(body: Any, chosen: SymmetryClass, unit: float, limit: float, hidden: Cover | None = None) -> Problem:
    """Return the problem of a class; hidden: where there are wells that the samples do not see."""
    a, b = np.array([chosen.a]), np.array([chosen.b])

    def U(rho, vartheta):
        A, B = (rho * np.cos(vartheta / 2)) ** 2, (rho * np.sin(vartheta / 2)) ** 2
        with np.errstate(over="ignore"):
            return potential(body, A, B) / unit

    v = np.pi * (np.arange(256) + 0.5) / 256
    rho = _size(U, v[::16], a, b) * np.geomspace(1e-4, 1e4, 1601)
    if hidden is not None:
        inside = (x := hidden.nodes(1))[(np.abs(x) < 1)]
        rho, v = np.union1d(rho, hidden.nodes(0)), np.union1d(v, np.arccos(inside))
    grid, far = U(rho[:, None], v), np.inf
    if np.isfinite(limit):
        far = decayed("V", rho, grid.min(axis=1), limit / unit, 0.0, np.inf)[1]
        rho, grid = rho[rho <= far], grid[rho <= far]
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
    check_bottom("V", place, rho.size, far)
    wells = [
        well("V", lambda angle, q=q: U(q, angle) * q * q / 4, 0.0, np.pi)
        for q in (0.8 * rho[place], rho[place], 1.3 * rho[place])
    ]
    one = wells[1]
    if any(abs(other.hi - one.hi) > 1e-9 or abs(other.lo - one.lo) > 1e-9 for other in wells) or one.lo != 0:
        raise ValueError(
            "the potential must live on det phi > 0 or on all of GL(2,R), alpha > beta or all alpha, beta > 0"
        )
    for angle in one.hi * np.array([0.2, 0.5, 0.8]):
        along = U(rho, angle)
        live = slice(*(np.flatnonzero(np.isfinite(along))[[0, -1]] + [0, 1]))
        check_poles("V along rho", lambda q, angle=angle: U(q, angle), rho[live], along[live])
    around = rho[:, None] / 2 * np.gradient(v)
    cell = np.gradient(rho)[:, None] * around

    def states(top):
        """Cells of phase space: int int (top - w) dalpha dbeta/(4 pi)."""
        return float((np.maximum(top - w, 0) * cell).sum() / (4 * np.pi))

    def channels(top):
        """Semiclassical number of channels below `top`, the most of all rho."""
        return float((np.sqrt(np.maximum(top - w, 0)) * around).sum(axis=1).max() / np.pi)

    strengths = [sum(getattr(x, c) for x in wells) / 3 for c in ("c_lo", "c_hi")]
    uniform = all(
        max(getattr(x, c) for x in wells) - min(getattr(x, c) for x in wells) <= 1e-6 * (1 + abs(s))
        for c, s in zip(("c_lo", "c_hi"), strengths)
    )
    fine = np.pi * (np.arange(200_000) + 0.5) / 200_000  # valleys far out are narrow in vartheta
    before, last = (float(U(q, fine).min()) for q in (rho[-1] / 10, rho[-1]))
    level_out = np.isinf(far) and last - before < 0.01 * (last - lowest[place])
    smooth = uniform and _even(U, rho[place], one)
    # Strengths that change with rho: no one exponent; that of the free problem, 1 at a wall.
    ends = one if uniform else one._replace(c_lo=0.0, c_hi=0.0)
    top = last if level_out else np.inf
    return Problem(U, a, b, ends, rho, v, lowest, top, smooth=smooth, states=states, channels=channels, far=far)


def _size(U: Callable, v: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Return the unit of rho: 1 where the lowest state lives there, in so many decades."""
    rho = np.geomspace(1e-24, 1e24, 193)
    with np.errstate(all="ignore"):
        around = a**2 / np.cos(v / 2) ** 2 + b**2 / np.sin(v / 2) ** 2
        lowest = (U(rho[:, None], v) + (1 + around) / rho[:, None] ** 2).min(axis=1)
    place = int(np.argmin(np.where(np.isnan(lowest), np.inf, lowest)))
    size = float(rho[place])
    return 1.0 if 1e-3 < size < 1e3 or place in (0, rho.size - 1) else size


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


def _solve_elements(
    problem: Problem, parts: tuple[Panels, Panels], count: int, bottom: float, top: float, n: int
) -> tuple[np.ndarray, Waves, int, np.ndarray]:
    """Return as `by_channels`, in products of functions of elements of n nodes: V is diagonal, the matrix sparse."""
    from scipy.sparse import diags, identity, kron

    rho, x = (part.cut(phases) for part, phases in zip(parts, _phases(problem, parts, bottom, top), strict=True))
    size, fewest = (math.prod(side.missed.size * (n - 1) + 1 for side in sides) for sides in ((rho, x), parts))
    if size > PRODUCTS:
        raise too_large(size, PRODUCTS, parts, 2 * fewest > PRODUCTS)
    v = angular_interval("V", problem.well, problem.a, problem.b)
    angles = elements(x.edges, n, float(v.e_lo[0]), float(v.e_hi[0]), v.wall_lo, v.wall_hi)
    quanta = (np.full(len(angles.x), side[0]) for side in (problem.a, problem.b))
    around = 1 - angles.x**2, angular_potential(angles, *quanta)
    turning = angles.assembled(*around)
    vartheta = angles.shared(angle_of(angles.lo, angles.hi, angles.below))

    def V(q):
        return cut_off(sampled(lambda v: problem.U(q, v), vartheta), bottom + STEEP * (top - bottom))

    near, tiny = rho.edges[0], 1e-6 * rho.edges[-1]
    e_lo = inner_exponent(near, tiny, (turning * (4 / tiny**2) + diags(V(tiny))).toarray()) if near == 0 else 1.0
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


def _phases(problem: Problem, parts: tuple[Panels, Panels], bottom: float, top: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the phases of the shortest waves over the panels of rho and of x."""
    rho, x = parts
    lowest = np.interp(np.hstack([rho.points, rho.edges[1:, None]]), problem.rho, problem.lowest).min(axis=1)
    turns = np.sqrt(np.maximum(top - problem.lowest, 0) * problem.rho**2).max() / 2
    return np.diff(rho.edges) * np.sqrt(np.maximum(top - lowest, 0)), -np.diff(
        np.arccos(np.clip(x.edges, -1, 1))
    ) * turns
