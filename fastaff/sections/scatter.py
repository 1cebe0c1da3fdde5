"""Tests whether the points of an orbit on a section fill an area and lose memory of their start, as in chaos, or lie on
curves.
"""

from __future__ import annotations

import numpy as np

QUERIES = 300
"""Points whose surroundings are examined."""

NEIGHBOURS = 5
"""Neighbours of each of these points."""

LAGS = 16
"""Lags over which pairs of neighbours are followed."""

APART = 2
"""Crossings that must lie between two neighbours at least."""

FEWEST = 200
"""Least number of points for evidence."""

FORGOTTEN = 0.9
"""Least `separation` of chaos. One of 1800 regular orbits of standard maps, quadratic maps, ellipses and chains of
islands with 256 points or more had this and ROUND (and few digits), and more than 94 % of 800 chaotic ones.
"""

ROUND = 0.3
"""Least `roundness` of chaos."""


def scattered(points: np.ndarray) -> bool:
    """Tell whether points (crossings, 2) are those of a chaotic orbit. Cost: 600 distances a point."""
    if len(points) < FEWEST:
        return False
    spread = points.std(axis=0)
    points = (points - points.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    return roundness(points) > ROUND and separation(points) > FORGOTTEN


def roundness(points: np.ndarray) -> float:
    """Return the median ratio of the axes of the clouds of nearest neighbours: 0 on a curve with many points, 0.56 on
    an area.
    """
    near = np.argpartition(_squares(points, points), NEIGHBOURS, axis=1)[:, : NEIGHBOURS + 1]
    cloud = points[near] - points[near].mean(axis=1, keepdims=True)
    axes = np.linalg.eigvalsh(np.einsum("qki,qkj->qij", cloud, cloud))
    return float(np.median(np.sqrt(np.maximum(axes[:, 0], 0.0) / np.where(axes[:, 1] > 0, axes[:, 1], 1.0))))


def separation(points: np.ndarray) -> float:
    """Return the separation of nearest neighbours after an eighth to a quarter of the crossings, from 0 to 1.

    The mean logarithm of their distances over those at the start, relative to that of pairs at random. On an invariant
    curve neighbours keep their difference of angles, so it is 0 whatever the curve's shape; on a chaotic orbit it is 1
    once they have parted.
    """
    count = len(points)
    first = points[: count - count // 4]
    squares = _squares(first, first)
    chosen = _chosen(len(first))
    squares[np.abs(chosen[:, None] - np.arange(len(first))) <= APART] = np.inf
    partner = squares.argmin(axis=1)
    lags = np.unique(np.linspace(count // 8, count // 4 - 1, LAGS).astype(int))
    one = points[chosen[:, None] + lags]
    other = points[partner[:, None] + lags]
    shuffled = other[np.random.default_rng(0).permutation(len(other))]
    start = _mean_log(squares[np.arange(len(chosen)), partner])
    parted, most = (_mean_log(((one - two) ** 2).sum(axis=-1)) - start for two in (other, shuffled))
    return parted / most if most > 0 else 0.0


def _chosen(count: int) -> np.ndarray:
    return np.unique(np.linspace(0, count - 1, min(count, QUERIES)).astype(int))


def _squares(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the squared distances (chosen, others) of some of the points from all others."""
    return ((points[_chosen(len(points)), None] - others) ** 2).sum(axis=-1)


def _mean_log(squares: np.ndarray) -> float:
    return float(np.log(np.maximum(squares, 1e-30)).mean()) / 2
