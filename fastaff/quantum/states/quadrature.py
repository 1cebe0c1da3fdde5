"""Quadrature of many states of one class at once: a tensor grid over their extent, and tables of their values.

Gauss-Legendre nodes in lengths, alpha and beta or rho = sqrt(r) and vartheta: there states are smooth between the
walls, and every product of two of them, whatever the exponents of their factors, is integrated on one grid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...systems.charts import ALPHA_BETA, R_VARTHETA, Chart
from .factors import Factor
from .state import INVARIANTS, Product, State

SAMPLED = 1e-24, 1e24, 9601
"""Lengths between which states are searched, and the number of samples."""
TAIL = 1e-30
"""Density, relative to its maximum, below which a state has ended."""
LARGEST = 2400
"""Nodes of one coordinate."""
GROWTH = 1.4
"""Factor by which the number of nodes grows until norms are exact."""


class NodeGrid(NamedTuple):
    """Nodes x (X,), y (Y,) of two invariants of `chart`; weights (X, Y): sum of weights*amplitude^2 is the norm
    squared.
    """

    chart: Chart
    x: np.ndarray
    y: np.ndarray
    weights: np.ndarray

    @property
    def radii(self) -> tuple[np.ndarray, np.ndarray]:
        """alpha, beta (X, Y) of the nodes."""
        return INVARIANTS[self.chart.name].to_radii(*np.meshgrid(self.x, self.y, indexing="ij"))


class AmplitudeTables(NamedTuple):
    """Amplitudes of states at the nodes of a grid, flattened: the products of first (states, A) and second (states,
    B).
    """

    first: np.ndarray
    second: np.ndarray

    def integrals(self, weighted: np.ndarray) -> np.ndarray:
        """Return the sums (states,) of amplitude times `weighted` (X, Y)."""
        rows = weighted.reshape(self.first.shape[1], self.second.shape[1])
        return ((self.first @ rows) * self.second).sum(axis=1)

    def norms(self, weights: np.ndarray) -> np.ndarray:
        """Return the sums (states,) of weights (X, Y) times amplitude^2."""
        return AmplitudeTables(self.first**2, self.second**2).integrals(weights)

    def blocks(self, size: int) -> Iterator[tuple[slice, np.ndarray]]:
        """Yield slices of the flattened nodes, of some `size`, with the amplitudes (states, nodes) there."""
        B = self.second.shape[1]
        step = max(size // B, 1)
        for start in range(0, self.first.shape[1], step):
            some = self.first[:, start : start + step, None] * self.second[:, None, :]
            yield slice(start * B, start * B + some[0].size), some.reshape(len(some), -1)


class StateExtent(NamedTuple):
    """The extent of states in two lengths, or length and angle: ends, ascending, of one or more panels of each."""

    chart: Chart
    ends: tuple[list[float], list[float]]

    def grid(self, orders: tuple[int, int]) -> NodeGrid:
        """Return the grid with so many nodes in each panel of both directions."""
        from scipy.special import roots_legendre

        nodes = []
        weights = []
        for ends, order in zip(self.ends, orders, strict=True):
            t, w = roots_legendre(order)
            half = np.diff(ends)[:, None] / 2
            nodes.append((np.array(ends[:-1])[:, None] + half * (1 + t)).reshape(-1))
            weights.append((2 * math.pi * half * w).reshape(-1))
        u, v = nodes
        planes = self.chart.name == ALPHA_BETA.name
        # 4 pi^2 alpha beta dalpha dbeta, or pi^2 rho^3 sin(vartheta) drho dvartheta
        measure = np.outer(u, v) if planes else np.outer(u**3, np.sin(v) / 4)
        return NodeGrid(self.chart, u if planes else u * u, v, np.outer(*weights) * measure)

    def whole(self) -> StateExtent:
        """Return all of the quadrant as far as twice the reach of the states, in panels with their ends between."""
        first, second = self.ends
        last = 2 * second[-1] if self.chart.name == ALPHA_BETA.name else math.pi
        return StateExtent(self.chart, (sorted({0.0, *first, 2 * first[-1]}), sorted({0.0, *second, last})))


def factors(states: Sequence[State], chart: Chart) -> list[tuple[Factor, Factor]] | None:
    """Return the factors of states that are all products in a chart, else None."""
    shapes = [state.shape for state in states]
    pairs = [shape.factors for shape in shapes if isinstance(shape, Product) and shape.chart.name == chart.name]
    return pairs if len(pairs) == len(states) else None


def converged_box(states: Sequence[State]) -> tuple[StateExtent, tuple[int, int]]:
    """Return the extent of states of one body, and orders of Gauss-Legendre rules that integrate their squares to
    1e-11.
    """
    longest = _extremes(states)
    pairs = factors(longest, states[0].chart)
    chart = states[0].chart if pairs else R_VARTHETA
    planes = chart.name == ALPHA_BETA.name
    ends: list[list[float]] = []
    orders: list[int] = []
    for i in (0, 1):
        samples = np.geomspace(*SAMPLED) if i == 0 or planes else np.linspace(0, math.pi, 1001)
        profile = _profile(longest, pairs, i, planes, ends)
        measure: Callable[[np.ndarray], np.ndarray] = (lambda u: u) if planes else (np.sin if i else lambda u: u**3)
        lo, hi = _ends(profile, measure, samples)
        ends.append([0.0 if lo == samples[0] else lo, hi])
        orders.append(_order(profile, measure, *ends[i]))
    return StateExtent(chart, (ends[0], ends[1])), (orders[0], orders[1])


def resolved(groups: Sequence[Sequence[State]]) -> tuple[list[AmplitudeTables], NodeGrid]:
    """Return one grid on which all states, and the products of those of one class, are integrated, to 1e-9, and their
    tables by group.
    """
    box, orders = converged_box([state for group in groups for state in group])
    while max(orders) < LARGEST:
        grid = box.grid(orders)
        tables = [grid_tables(group, grid) for group in groups]
        if max(np.abs(table.norms(grid.weights) - 1).max() for table in tables) < 1e-9:
            return tables, grid
        orders = int(GROWTH * orders[0]), int(GROWTH * orders[1])
    raise ValueError(
        f"states must be resolved by {LARGEST} nodes in each coordinate. Try fewer or lower states, or another hbar."
    )


def grid_tables(states: Sequence[State], grid: NodeGrid) -> AmplitudeTables:
    """Return the values of states of one class on a grid."""
    pairs = factors(states, grid.chart)
    if pairs:
        first, second = (np.array([pair[i](q) for pair in pairs]) for i, q in enumerate((grid.x, grid.y)))
        return AmplitudeTables(first * INVARIANTS[grid.chart.name].front, second)
    x, y = (q.reshape(-1) for q in np.meshgrid(grid.x, grid.y, indexing="ij"))
    return AmplitudeTables(np.array([state.amplitude(x, y, grid.chart) for state in states]), np.ones((len(states), 1)))


def _extremes(states: Sequence[State]) -> list[State]:
    """Return the states that reach farthest and oscillate most: those of the largest energy and degrees, and of the
    least spins.
    """
    sizes = np.array([[state.energy, *state.shape.degrees, -state.symmetry.a, -state.symmetry.b] for state in states])
    return [states[k] for k in sorted({0, *np.argmax(sizes, axis=0)})]


def _profile(
    states: list[State], pairs: list[tuple[Factor, Factor]] | None, i: int, planes: bool, known: list[list[float]]
) -> Callable:
    """Return a function of length or angle i (n,) whose rows (..., n) are states along it."""

    def coordinate(u: np.ndarray) -> np.ndarray:
        return u if planes or i else u * u

    if pairs:
        return lambda u: np.array([pair[i](coordinate(u)) for pair in pairs])
    if i == 0:
        across = math.pi * (np.arange(16) + 0.5) / 16
        return lambda u: np.concatenate([state.amplitude(u * u, across[:, None], R_VARTHETA) for state in states])
    lo, hi = known[0]
    along = lo + (hi - lo) * (np.arange(16) + 0.5) / 16
    return lambda v: np.concatenate([state.amplitude(along[:, None] ** 2, v, R_VARTHETA) for state in states])


def _ends(profile: Callable, measure: Callable, samples: np.ndarray) -> tuple[float, float]:
    """Return the ends of all states: next to the last samples where they are not 0, or at the wall beyond which they
    are.
    """
    square = profile(samples) ** 2 * measure(samples)
    alive = np.flatnonzero((square > TAIL * square.max(axis=1, keepdims=True)).any(axis=0))
    if not alive.size:
        raise ValueError(f"hbar must suit the body, whose states vanish between {samples[0]:g} and {samples[-1]:g}")
    found = []
    for inside, step in ((alive[0], -1), (alive[-1], 1)):
        here, there = (float(samples[min(max(k, 0), samples.size - 1)]) for k in (inside, inside + step))
        if not profile(np.array([there])).any():
            while (middle := (here + there) / 2) not in (here, there):
                here, there = (middle, there) if profile(np.array([middle])).any() else (here, middle)
            there = here
        found.append(there)
    return found[0], found[1]


def _order(profile: Callable, measure: Callable, lo: float, hi: float) -> int:
    """Return the order whose rule integrates the squares of all rows to 1e-11, seen from the next one."""
    from scipy.special import roots_legendre

    order = 32
    before = None
    while order <= LARGEST:
        t, w = roots_legendre(order)
        u = lo + (hi - lo) * (1 + t) / 2
        value = profile(u) ** 2 @ (w * measure(u))
        if before is not None and np.all(np.abs(value - before) <= 1e-11 * value.max()):
            return order
        order = int(GROWTH * order)
        before = value
    raise ValueError(f"states must be integrable by {LARGEST} nodes in each coordinate. Try fewer levels.")
