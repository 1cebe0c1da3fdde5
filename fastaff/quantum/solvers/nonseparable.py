"""Levels of bodies that do not separate: adiabatic channels in vartheta on a grid in rho."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ...runs.interruptible import interruptible
from ..states.level_table import LevelTable, Waves, class_levels, level_scale
from ..states.symmetry import SymmetryClass
from .channels import STEEP, MatrixTooLarge, beyond, by_channels, cut_off, inner_exponent, sizes, too_large
from .convergence import by_chance
from .cover import Cover, plane_cover
from .elements import elements, left_over, lowest, quadratic
from .factor_tables import angle_of
from .panels import DENSE, Panels, between, merged, panels
from .plane_problem import PlaneProblem, plane_problem
from .plane_shape import ElementWaves
from .separable import angular_interval, angular_potential
from .singular_ends import NoGroundState, count_top, decayed, sampled

ELEMENTS = ((5,), (6,), (8,), (11,), (14,), (18,))
"""Nodes of every element where V has narrow features: bases from small to large."""
LINES = 48
"""Lines of either coordinate along which V is sampled."""

CLOSE = 3
"""Number of these lines that are dense."""

ROUNDS = 3
"""Number of refinements of partitions along lines through points where V is not resolved."""

WORST = 8
"""Number of these points."""

PANELS = (120, 30)
"""Panels of rho and of x at most."""
PRODUCTS = 100_000
"""Largest sparse matrix: some 10 s and 1 GB."""
ANGLES = 200
"""Nodes of x that a global basis may take at little cost, however few its functions."""
SPECTRAL = 4.0
"""Error of elements in units of the change from a lower degree: 0.1 where V is smooth, 1 at cones."""
SMOOTH = 0.5
"""Error of global bases in units of the change from a smaller one: usually 0.1; the error of the cut-off is added."""
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


SPARE = (40, 6)
"""States more than are asked for: the first number, or the second if functions of rho would be too many."""

FAR = 600
"""Functions of rho beyond which there are fewer spare states."""

SMALLER = {True: 1, False: 2}
"""How many bases, global ones or elements, are only for comparison where there is no room for larger ones."""


def plane_levels(
    model: Any,
    chosen: SymmetryClass,
    count: int,
    hbar: float,
    tolerance: float,
    known: list[LevelTable] | None = None,
    callback: Callable[[float], None] | None = None,
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
    unit = hbar**2 / (2 * model.mu)
    problem = plane_problem(model, chosen, unit, limit)
    bottom, top = _range(problem, count, unit)
    seen = interruptible(_seen, problem, model, unit, bottom, top)
    hidden = seen.unseen([problem.rho, np.cos(problem.v[::-1])])
    if hidden.low.size:
        problem = plane_problem(model, chosen, unit, limit, hidden)
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

    known = [] if known is None else known
    bases = _GrowingBases(problem, parts, count, bottom, top, smooth)

    def keep() -> np.ndarray:
        """Add the table of the largest basis so far to those known; return its errors."""
        E, waves, size, _ = bases.done[-1]
        error = unit * (bases.errors() + seen.lost(E))
        table = class_levels(
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
        known.append(table)
        return error

    for E in bases.larger(callback):
        if np.all(keep() <= tolerance * level_scale(unit * E)):
            break
    for _ in bases.smaller():
        keep()
    if not known:
        raise ValueError(f"count = {count} needs {bases.refused or _unlike(chosen)}")
    return known[-1]


def _unlike(chosen: SymmetryClass) -> str:
    """Return the end of the error for levels that are near none of the functions of their class."""
    return (
        f"functions nearer to V than those of |m - l| = {2 * chosen.a:g}, |m + l| = {2 * chosen.b:g}. "
        "Try smaller m and l, or a larger hbar."
    )


@dataclass
class _GrowingBases:
    """Bases of a problem from small to large: levels, waves, size and remaining errors of those that were solved
    (`done`), and the reason why one was refused.
    """

    problem: PlaneProblem
    parts: tuple[Panels, Panels]
    count: int
    bottom: float
    top: float
    smooth: bool
    done: list[tuple] = field(default_factory=list)
    refused: MatrixTooLarge | None = None

    @property
    def sizes(self) -> tuple:
        """Return the arguments of the solver for each basis."""
        return STEPS if self.smooth else ELEMENTS

    def larger(self, callback: Callable[[float], None] | None) -> Iterator[np.ndarray]:
        """Solve one basis after another; yield the levels of each that has room for them."""
        for number in range(SMALLER[self.smooth], len(self.sizes)):
            found = self.solve(number)
            if found is None and (self.done or self.refused):
                break
            if found is not None:
                self.done.append(found)
                self.top = max(found[0][-1], self.top)
                yield found[0]
            if callback is not None:
                callback((number + 1) / len(self.sizes))

    def smaller(self) -> Iterator[None]:
        """Put smaller bases before the only one, or in place of a missing one, until there are two to compare."""
        for number in range(SMALLER[self.smooth] - 1, -1, -1):
            if len(self.done) < 2 and (found := self.solve(number)) is not None:
                self.done.insert(0, found)
                yield

    def solve(self, number: int) -> tuple | None:
        """Return the levels of one basis, or None where it has no room for them."""
        solver = by_channels if self.smooth else _solve_elements
        how = self.problem, self.parts, self.count, self.bottom, self.top, *self.sizes[number]
        try:
            found = interruptible(solver, *how)
        except MatrixTooLarge as reason:
            self.refused = reason
            return None
        return found if found[2] >= self.count else None

    def errors(self) -> np.ndarray:
        """Return the errors of the levels of the largest basis so far."""
        E, _, _, left = self.done[-1]
        gap = by_chance(np.abs(E - self.done[-2][0])) if len(self.done) > 1 else np.full(self.count, np.inf)
        rounding = 64 * np.finfo(float).eps * (np.abs(E) + abs(self.top - self.bottom))
        if not self.smooth:
            factor = SPECTRAL
        elif self.problem.smooth:
            factor = SMOOTH
        else:
            factor = ALGEBRAIC
        return factor * gap + left + rounding


def _range(problem: PlaneProblem, count: int, unit: float) -> tuple[float, float]:
    """Return the bottom of V, and an energy with `count` levels and some spare ones below it, fewer spare ones if they
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


def _seen(problem: PlaneProblem, model: Any, unit: float, bottom: float, top: float) -> Cover:
    """Return the cover of the places where V may be below the top energy."""
    quanta = float(problem.a[0]), float(problem.b[0])
    ends = float(problem.rho[0]), float(problem.rho[-1])
    return plane_cover(model, quanta, ends, problem.well.hi < 3, top, top - bottom, unit)


def _wanted(problem: PlaneProblem, count: int, unit: float, spare: int) -> float:
    """Return the number of states that should lie below the top energy; raises if V does not bind the levels."""
    wanted = 1.1 * count + spare
    if np.isinf(problem.threshold):
        return wanted
    bound = problem.states(problem.threshold)
    if bound < count + 0.5:
        raise NoGroundState(
            f"V grows to {unit * problem.threshold:.6g} only at large distance and binds about {bound:.0f} levels of "
            f"a class below that, got count = {count}"
        )
    return min(wanted, (count + bound) / 2)


def _partition(
    problem: PlaneProblem, ends: tuple[float, float], bottom: float, top: float, hidden: Cover
) -> tuple[Panels, Panels]:
    """Return partitions of rho and of x that resolve V on LINES of the other coordinate, on a few of them densely,
    between the lines, and at hidden wells.

    If V is not resolved at points between the lines, lines through them are added; the remaining misfit is an error. It
    counts little where states hardly reach.
    """
    share = partial(problem.share, top=top)
    x = _line_x(problem)
    quasi = (np.arange(LINES) * 0.6180339887498949 + 0.31) % 1

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


def _line_x(problem: PlaneProblem) -> tuple[float, float]:
    ends = angular_interval("V", problem.well, problem.a**2, problem.b**2)
    return ends.lo, ends.hi


def _global(
    problem: PlaneProblem, parts: tuple[Panels, Panels], ends: tuple[float, float], bottom: float, top: float
) -> bool:
    """Return whether global bases of the usual size resolve V, or nearly."""
    n_rho, n_x = sizes(problem, *ends, bottom, top, STEPS[0][1])
    return parts[0].needed <= 1.3 * n_rho and parts[1].needed <= max(3 * n_x, ANGLES)


def _solve_elements(
    problem: PlaneProblem, parts: tuple[Panels, Panels], count: int, bottom: float, top: float, n: int
) -> tuple[np.ndarray, Waves, int, np.ndarray]:
    """Return as `by_channels`, in products of functions of elements of n nodes: V is diagonal, the matrix sparse."""
    from scipy.sparse import diags, identity, kron

    rho, x = (part.cut(phases) for part, phases in zip(parts, _phases(problem, parts, top), strict=True))
    size, fewest = (math.prod(side.missed.size * (n - 1) + 1 for side in sides) for sides in ((rho, x), parts))
    if size > PRODUCTS:
        raise too_large(size, PRODUCTS, parts, 2 * fewest > PRODUCTS)
    v = angular_interval("V", problem.well, problem.a**2, problem.b**2)
    angles = elements(x.edges, n, float(v.e_lo[0]), float(v.e_hi[0]), v.wall_lo, v.wall_hi)
    sides = (np.full(len(angles.x), side[0] ** 2) for side in (problem.a, problem.b))
    around = 1 - angles.x**2, angular_potential(angles, *sides)
    turning = angles.assembled(*around)
    vartheta = angles.shared(angle_of(angles.lo, angles.hi, angles.below))

    def V(q):
        return cut_off(sampled(lambda v: problem.U(q, v), vartheta), bottom + STEEP * (top - bottom))

    near = rho.edges[0]
    tiny = 1e-6 * rho.edges[-1]
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
    E = np.empty(count)
    left = np.empty(count)
    for k, c in enumerate(tables):
        E[k] = quadratic(radii, *along, c).sum() + quadratic(angles, *around, c.T) @ (4 / nodes**2) + (U * c**2).sum()
        sides = (np.sqrt((c**2).sum(axis=axis))[:, None] for axis in (1, 0))
        left[k] = sum(
            left_over(line, part.missed, side)[0]
            for line, part, side in zip((radii, angles), (rho, x), sides, strict=True)
        )
    order = np.argsort(E)
    return E[order], ElementWaves(radii, angles, tables[order]), U.size, left[order]


def _phases(problem: PlaneProblem, parts: tuple[Panels, Panels], top: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the phases of the shortest waves over the panels of rho and of x."""
    rho, x = parts
    lowest = np.interp(np.hstack([rho.points, rho.edges[1:, None]]), problem.rho, problem.lowest).min(axis=1)
    turns = np.sqrt(np.maximum(top - problem.lowest, 0) * problem.rho**2).max() / 2
    return np.diff(rho.edges) * np.sqrt(np.maximum(top - lowest, 0)), -np.diff(
        np.arccos(np.clip(x.edges, -1, 1))
    ) * turns
