"""Levels on a lattice of points: the grid, its Hamiltonian, and the error of the points."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .lapack import lowest_states

LARGEST = 2500
"""Largest matrix: some 10 s."""

LINE = 4096
"""Most points of one coordinate, whose matrix of all has 130 MB."""

LONGER = 1.5
"""Ratio of the points of two coordinates from which on the longer one is the outer one."""
SHIFTS = (64, 32, 32)
"""Lattices between the points of a grid that are compared with it, by coordinates."""
OTHERS = (16, 4, 4)
"""States above those asked for, by coordinates, whose mixing counts with their own energies, not with the cut."""
HUGE = 1e100
"""Largest height of V above the cut that is counted."""
EDGE = 4
"""Points beyond a grid where residuals are taken: they fall as the square of the distance from waves that end."""

EVENLY = (1.6180339887498949, 1.3247179572447460, 1.2207440846057596)
"""x with x^(d + 1) = x + 1 by coordinates d: multiples of 1/x, 1/x^2, ... modulo 1 fill a cell evenly."""


class LatticeProblem(NamedTuple):
    """H = -(1/2) d^2/du^2 + V, u = R^-1 q: V of points u (d, ...), infinite where there is none; the minima (d,
    wells) with their values, the lowest first; periods of coordinates that are angles, 0 of others; R (d, d).
    """

    V: Callable[[np.ndarray], np.ndarray]
    wells: np.ndarray
    values: np.ndarray
    periods: np.ndarray
    R: np.ndarray

    @property
    def bottom(self) -> float:
        """The least of V."""
        return float(self.values[0])


class LatticeGrid(NamedTuple):
    """Points of a lattice from `low` to `high` (d,) steps off the lowest well; around: mask of periodic axes; V and
    kept, a mask of points, (n1, ...); the wells in steps (d, wells); the wall; points from which V falls out of them.
    """

    low: np.ndarray
    high: np.ndarray
    step: np.ndarray
    around: np.ndarray
    V: np.ndarray = np.empty(0)
    kept: np.ndarray = np.empty(0, bool)
    at: np.ndarray = np.empty(0, np.int64)
    wall: float = math.inf
    leak: np.ndarray = np.empty(0, bool)

    def points(self, wells: np.ndarray, shift: np.ndarray | float = 0.0) -> np.ndarray:
        """The points (d, n1, ...), moved by a part of a step."""
        axes = [np.arange(a, b + 1) for a, b in zip(self.low, self.high, strict=True)]
        column = (-1, *[1] * len(axes))
        moved = np.array(np.meshgrid(*axes, indexing="ij")) + np.reshape(shift, (-1, *[1] * len(axes)))
        return moved * self.step.reshape(column) + wells[:, 0].reshape(column)

    def states(self, energy: float) -> float:
        """The volume of phase space below an energy over (2 pi)^d."""
        d = self.step.size
        ball = math.pi ** (d / 2) / math.gamma(d / 2 + 1)
        room = np.maximum(2 * (energy - self.V[self.kept]), 0.0) ** (d / 2)
        return float(ball * room.sum() * np.prod(self.step) / (2 * math.pi) ** d)


class BasisTooLarge(Exception):
    """A basis would be larger than it may be."""


class LatticeLevels(NamedTuple):
    """Levels E (levels,), the parts of their errors that the grid's points and the functions left out make, the size of
    the basis, and the states (levels, points kept) with these points' flat indices.
    """

    E: np.ndarray
    missed: np.ndarray
    left: np.ndarray
    size: int
    states: np.ndarray
    kept: np.ndarray


def lowest(grid: LatticeGrid, problem: LatticeProblem, cut: float, count: int) -> LatticeLevels:
    """Return the lowest levels of a grid, with both parts of their errors.

    If the points resolve V and the states, the means of V over products of states are the same for points between them;
    if V is narrower than the step, or singular, they are not: `missed`, their deviation, with states above those asked
    for too. Functions left out, those of shorter waves and of points above the wall, have energies above the cut. Their
    effect is at most that of the residual (H - E) psi in second order, over that gap: `left`. The residual is taken of
    the wave between the points too, where it is 0 at none. V is the whole one, see `_saturated`.
    """
    if (points := max(grid.V.shape)) > LINE:
        raise BasisTooLarge(f"{points} points of one coordinate, more than {LINE}. Try a larger hbar or fewer levels.")
    T = [kinetic(n, step, bool(turns)) for n, step, turns in zip(grid.V.shape, grid.step, grid.around, strict=True)]
    H, basis = _hamiltonian(T, grid, cut)
    if len(H) < count:
        raise BasisTooLarge(f"a basis that has more than the {len(H)} functions below {cut:.6g}")
    E, C = lowest_states(H, min(count + OTHERS[grid.step.size - 1], len(H)))
    states = (basis @ C).T.reshape(E.size, *grid.V.shape)
    missed, left = _errors(_edged(grid), problem, cut, E, _with_edge(states, grid.around), count)
    E = E[:count]
    flat = states[:count].reshape(count, -1)
    kept = np.flatnonzero(grid.kept)
    signs = np.sign(flat[np.arange(count), np.abs(flat).argmax(axis=1)])
    return LatticeLevels(E, missed, left, len(H), signs[:, None] * flat[:, kept], kept)


def _errors(
    grid: LatticeGrid, problem: LatticeProblem, cut: float, E: np.ndarray, states: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return errors (levels,) of states (levels, n1, ...) by the points and by the functions left out, see `lowest`.

    Functions left out have energies above the cut, or, at points left out, above V and the wall.
    """
    d = grid.step.size
    energies = E[:count].reshape(-1, *[1] * d)
    bent = np.zeros((count, *states.shape[1:]))
    for k, (n, step, turns) in enumerate(zip(grid.kept.shape, grid.step, grid.around, strict=True)):
        bent += _along(kinetic(n, step, bool(turns)), states[:count], k)
    shifts = [k * EVENLY[d - 1] ** -np.arange(1.0, d + 1) % 1.0 for k in range(SHIFTS[d - 1])]
    V = np.array([problem.V(grid.points(problem.wells, shift)) for shift in shifts])
    V = _saturated(V, cut, cut - problem.bottom)
    floor = np.where(grid.kept, cut, min(grid.wall, cut))
    means = []
    left = np.zeros(count)
    for shift, there in zip(shifts, V, strict=True):
        moved, curved = states, bent
        for axis, (n, turns) in enumerate(zip(grid.kept.shape, grid.around, strict=True)):
            between = _between(n, shift[axis], bool(turns))
            moved, curved = _along(between, moved, axis), _along(between, curved, axis)
        weighted = ((there - problem.bottom) * moved[:count]).reshape(count, -1)
        means.append(weighted @ moved.reshape(E.size, -1).T)
        residual = curved + (there - energies) * moved[:count]
        room = np.maximum(there, floor) - energies
        with np.errstate(divide="ignore"):
            left += np.where(room > 0, residual**2 / np.abs(room), np.inf).reshape(count, -1).sum(axis=1)
    missed = np.abs(np.mean(means, axis=0) - means[0]) + np.std(means, axis=0)
    return _mixed(E, missed), left / len(shifts)


def _saturated(V: np.ndarray, cut: float, shortest: float) -> np.ndarray:
    """Return V (shifts, n1, ...), of which the part above the cut has at most the mean `shortest` in each cell.

    That part changes a level by at most its mean over the state; nor by more than it costs to keep a wave out of the
    cell, the kinetic energy `shortest` of waves as short as a cell. So bounds stay finite at poles and steep walls.
    """
    above = np.clip(V - cut, 0.0, HUGE)
    mean = above.mean(axis=0)
    return np.minimum(V, cut) + above * np.minimum(1.0, shortest / np.maximum(mean, shortest))


def _edged(grid: LatticeGrid) -> LatticeGrid:
    """Return a grid with EDGE more points on all sides, which are not kept."""
    wide = np.where(grid.around, 0, EDGE)
    kept = np.pad(grid.kept, [(int(k), int(k)) for k in wide])
    return grid._replace(low=grid.low - wide, high=grid.high + wide, kept=kept)


def _with_edge(states: np.ndarray, around: np.ndarray) -> np.ndarray:
    """Return states (levels, n1, ...) on the points of `_edged`."""
    return np.pad(states, [(0, 0), *[(0, 0) if turns else (EDGE, EDGE) for turns in around]])


def _mixed(E: np.ndarray, W: np.ndarray) -> np.ndarray:
    """Return bounds (levels,) of the changes of the first of levels E by a perturbation with elements up to W (levels,
    all levels): of first order, and of second order or, where levels are closer than W, of first order.
    """
    apart = np.abs(np.subtract.outer(E[: len(W)], E))
    own = np.diagonal(W)
    others = np.where(np.eye(*W.shape) > 0, 0.0, W)
    return np.asarray(own + (others**2 / np.maximum(apart + others, 1e-300)).sum(axis=1))


def _along(A: np.ndarray, states: np.ndarray, axis: int) -> np.ndarray:
    """Return a matrix applied to an axis of states (levels, n1, ...)."""
    return np.moveaxis(np.tensordot(A, states, (1, axis + 1)), 0, axis + 1)


def _hamiltonian(T: list[np.ndarray], grid: LatticeGrid, cut: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the Hamiltonian and its basis, of `matrix`, with the longest coordinates as the outer ones.

    Across a narrow valley there are few states for each point along it, but many along it for each point across.
    """
    shape = np.array(grid.V.shape)
    order = np.argsort(-shape, kind="stable") if shape.max() > LONGER * shape.min() else np.arange(shape.size)
    H, basis = matrix([T[k] for k in order], grid.V.transpose(order), grid.kept.transpose(order), cut)
    back = (*np.argsort(order), shape.size)
    return H, basis.reshape(*shape[order], -1).transpose(back).reshape(shape.prod(), -1)


def _between(n: int, shift: float, around: bool) -> np.ndarray:
    """Return the waves of n points, periodic if `around` (then n is odd), at points moved by a part of a step."""
    apart = np.arange(n - 1, -n, -1) + shift
    wave = np.sinc(apart) / np.sinc(apart / n) if around and shift else np.sinc(apart)
    return np.lib.stride_tricks.sliding_window_view(wave, n)[::-1]


def kinetic(n: int, step: float, around: bool) -> np.ndarray:
    """Return -(1/2) d^2/du^2 between the n points of a lattice, periodic if `around` (then n is odd)."""
    difference = np.subtract.outer(np.arange(n), np.arange(n))
    sign = 1.0 - 2.0 * (difference % 2)
    same = difference == 0
    apart = np.where(difference == 0, 1, difference)
    if not around:
        return sign * np.where(same, math.pi**2 / 6, 1.0 / apart**2) / step**2
    angle = math.pi * apart / n
    T = np.where(same, (n * n - 1) / 24, np.cos(angle) / (4 * np.sin(angle) ** 2))
    return sign * T * (2 * math.pi / (n * step)) ** 2


def matrix(T: list[np.ndarray], V: np.ndarray, kept: np.ndarray, cut: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the Hamiltonian (size, size) and its basis (points, size): the points kept, or for each point of the first
    coordinate the states of the others below the cut.
    """
    if V.ndim == 1:
        at = np.flatnonzero(kept)
        return T[0][np.ix_(at, at)] + np.diag(V[at]), np.eye(V.size)[:, at]
    energies = []
    states = []
    nodes = []
    for i in np.flatnonzero(kept.reshape(len(V), -1).any(axis=1)):
        part, basis = matrix(T[1:], V[i], kept[i], cut)
        E, C = np.linalg.eigh(part)
        below = cut > E
        energies.append(E[below])
        states.append(basis @ C[:, below])
        nodes.append(np.full(int(below.sum()), i))
        if sum(map(len, energies)) > LARGEST:
            raise BasisTooLarge(
                f"more than {LARGEST} functions of {V.ndim} coordinates. Try a larger hbar or fewer levels."
            )
    G = np.concatenate(states, axis=1)
    node = np.concatenate(nodes)
    H = G.T @ G
    H *= T[0][node[:, None], node]
    H[np.diag_indices_from(H)] += np.concatenate(energies)
    basis = np.zeros((len(V), *G.shape))
    basis[node, :, np.arange(node.size)] = G.T
    return H, basis.reshape(V.size, node.size)
