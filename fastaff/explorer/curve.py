"""The rotation number of a closed curve or a chain of islands, as in curve.js; none where the points tell neither."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..frequencies.naff import naff
from ..sections.islands import rotation_number

LEAST_ON_CURVE = 64
"""Least number of points of a curve."""

MOST_ON_CURVE = 2048
"""Points of a curve that are looked at."""

FITTED_LINES = 6
"""Lines of u + iv that are fitted together."""

TRIED_LINES = 3
"""Strongest lines, and their differences, that give rotation numbers to try."""

TRIED_HARMONICS = 4
"""Harmonics of the rotation number that a line may be."""

LONGER_THAN_TREE = 1.1
"""Largest length of an open polygon over that of the shortest tree: 1 on a curve, more where it leaps over gaps."""

MOST_ISLANDS = 60
"""Islands of a chain that are looked for."""

LEAST_VISITS = 8
"""Points that each island of a chain must have."""

LEAST_TURNS = 2.0
"""Turns about its own centre that an island must show: the points of an arc of one curve make less than one."""

ROUNDING = 1e-14
"""Error of a fraction, in turns."""

MOST_BACKWARDS = 0.03
"""Turns that images may go backwards: rounding alone on a curve seen from its inside, above a tenth for crescents."""

LEAST_GAP = np.pi
"""Gap of the angles about the mean from which the mean lies outside."""


class Turning(NamedTuple):
    """A rotation number in turns per crossing, in (-1/2, 1/2], with its error; of a chain q and own turns."""

    value: float
    error: float
    q: int = 0
    secondary: Turning | None = None

    def record(self) -> dict[str, Any]:
        """Return the fields that the page reads."""
        own = {"value": self.value, "error": self.error}
        if not self.q:
            return own
        turns = None if self.secondary is None else {"value": self.secondary.value, "error": self.secondary.error}
        return {**own, "q": self.q, "secondary": turns}


class Tree(NamedTuple):
    """The shortest tree through points: both ends of each edge, and its length."""

    ends: np.ndarray
    length: float


class Ordered(NamedTuple):
    """Points in the order of the fractions of k turns, and the length of their closed polygon."""

    turn: float
    order: np.ndarray
    length: float


def curve_rotation(points: np.ndarray) -> Turning | None:
    """Return the rotation number of points (2, crossings); None for too few points, and for neither curve nor chain.

    That of a chain is p/q with the turns about an island in q crossings. That of a curve is about the mean of the
    points if that sees all of the curve; else it is the mean advance along the curve.
    """
    found = rotation_number(points)
    if not np.isfinite(found.error[0]):
        return None
    chain = _chain(points)
    if chain is not None:
        return chain
    if _seen_from_mean(points):
        return Turning(float(found.rotation[0]), float(found.error[0]))
    return along_curve(points)


def _chain(points: np.ndarray) -> Turning | None:
    """Return the rotation number of a chain of islands about its centre, None where the points show no chain.

    The points of an island are joined in the shortest tree, of which q - 1 edges lead from one to another, or alone in
    their sector about the mean. Points of one curve near a fraction p/q part alike, but those of an island turn.
    """
    plane = _scaled(points)
    count = plane.shape[1]
    tree = _shortest_tree(plane)
    around = np.argsort(np.arctan2(plane[1], plane[0]), kind="stable")
    for q in range(2, min(MOST_ISLANDS, count // LEAST_VISITS) + 1):
        joined = np.count_nonzero((tree.ends[0] - tree.ends[1]) % q) == q - 1
        if not joined and np.count_nonzero(np.diff(around, append=around[0]) % q) != q:
            continue
        visits = [plane[:, island::q] for island in range(q)]
        if min(max(_turns(own), _turns(own[:, ::2])) for own in visits) < LEAST_TURNS:
            continue
        p = _order(np.array([own.mean(axis=1) for own in visits]).T)
        if p is None:
            return None
        own = curve_rotation(points[:, q - 1 :: q])
        return Turning(p / q, ROUNDING, q, own)
    return None


def _shortest_tree(plane: np.ndarray) -> Tree:
    """Return the shortest tree through points, by the method of Prim."""
    count = plane.shape[1]
    ends = np.zeros((2, count - 1), np.int64)
    nearest = np.zeros(count, np.int64)
    away = np.full(count, np.inf)
    outside = np.ones(count, bool)
    last = 0
    length = 0.0
    for edge in range(count - 1):
        outside[last] = False
        apart = np.hypot(*(plane - plane[:, last : last + 1]))
        closer = outside & (apart < away)
        away[closer] = apart[closer]
        away[last] = np.inf
        nearest[closer] = last
        last = int(np.argmin(away))
        ends[:, edge] = nearest[last], last
        length += float(away[last])
    return Tree(ends, length)


def _turns(plane: np.ndarray) -> float:
    """Return the turns that points make about their mean, whichever way."""
    u, v = plane - plane.mean(axis=1, keepdims=True)
    angle = np.arctan2(v, u)
    return abs(float((np.mod(np.diff(angle) + np.pi, 2 * np.pi) - np.pi).sum())) / (2 * np.pi)


def _order(centres: np.ndarray) -> int | None:
    """Return by how many places around their mean each of the islands moves to the next; None if not by the same."""
    u, v = centres - centres.mean(axis=1, keepdims=True)
    q = u.size
    rank = np.argsort(np.argsort(np.arctan2(v, u), kind="stable"), kind="stable")
    steps = np.mod(np.diff(rank, append=rank[0]), q)
    if np.ptp(steps):
        return None
    p = int(steps[0])
    return p if 2 * p <= q else p - q


def along_curve(points: np.ndarray) -> Turning | None:
    """Return the mean advance of points (2, crossings) along their closed curve, counterclockwise; None off a curve.

    The order along a curve of rotation number w is that of the fractions of k w. Of the candidates that the lines of
    u + iv give, the right one has the shortest polygon.
    """
    if points.shape[1] < LEAST_ON_CURVE:
        return None
    plane = _scaled(points)
    if not np.ptp(plane, axis=1).all():
        return None
    best = min((_ordered_by(turn, plane) for turn in _candidates(plane)), key=lambda one: one.length, default=None)
    if best is None or not _is_curve(best, plane):
        return None
    walked = np.concatenate([[0.0], np.cumsum(_sides(best.order, plane))])
    places = np.empty(plane.shape[1])
    places[best.order] = 2 * np.pi * walked[:-1] / walked[-1]
    advance = rotation_number(np.array([np.cos(places), np.sin(places)]), centre=[0.0, 0.0])
    value = float(advance.rotation[0])
    apart = value - best.turn
    turns = value if _area(best.order, plane) > 0 else -value
    return Turning(float(turns - np.ceil(turns - 0.5)), float(advance.error[0]) + abs(apart - round(apart)))


def _scaled(points: np.ndarray) -> np.ndarray:
    """Return points (2, crossings) about their mean, each coordinate in units of its spread."""
    kept = points[:, :MOST_ON_CURVE]
    away = kept - kept.mean(axis=1, keepdims=True)
    spread = away.std(axis=1, keepdims=True)
    return away / np.where(spread > 0, spread, 1.0)


def _seen_from_mean(points: np.ndarray) -> bool:
    """Tell whether the mean sees all of a closed curve around it.

    The angles leave no gap of half a turn then, and their cyclic order is that of their images, as on a circle. Seen
    from a place off the inside, both sides of a crescent move against each other.
    """
    plane = _scaled(points)
    angle = np.arctan2(plane[1], plane[0])
    ring = np.sort(angle)
    gaps = np.diff(ring, append=ring[0] + 2 * np.pi)
    images = angle[1:][np.argsort(angle[:-1], kind="stable")]
    steps = np.mod(np.diff(images, append=images[0]) + np.pi, 2 * np.pi) - np.pi
    return bool(gaps.max() < LEAST_GAP and np.maximum(-steps, 0.0).sum() < MOST_BACKWARDS * 2 * np.pi)


def _candidates(plane: np.ndarray) -> list[float]:
    """Return rotation numbers of which the strongest lines of u + iv, or their differences, are a harmonic."""
    found = naff(plane[0] + 1j * plane[1], 1.0, lines=FITTED_LINES).nu
    lines = [float(nu) for nu in found[np.isfinite(found)][:TRIED_LINES]]
    differences = [one - other for k, one in enumerate(lines) for other in lines[:k]]
    return [(nu + k) / m for nu in (*lines, *differences) for m in range(1, TRIED_HARMONICS + 1) for k in range(m)]


def _ordered_by(turn: float, plane: np.ndarray) -> Ordered:
    order = np.argsort(np.mod(turn * np.arange(plane.shape[1]), 1.0), kind="stable")
    return Ordered(turn, order, float(_sides(order, plane).sum()))


def _sides(order: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Return the lengths of the sides of the closed polygon of points in an order."""
    ring = plane[:, order]
    return np.hypot(*(np.roll(ring, -1, axis=1) - ring))


def _is_curve(best: Ordered, plane: np.ndarray) -> bool:
    """Tell whether the polygon of points in an order is hardly longer than the shortest tree through them."""
    return bool(best.length - _sides(best.order, plane).max() <= LONGER_THAN_TREE * _shortest_tree(plane).length)


def _area(order: np.ndarray, plane: np.ndarray) -> float:
    """Return twice the area of a polygon, positive if it turns counterclockwise."""
    u, v = plane[:, order]
    return float(np.sum(u * np.roll(v, -1) - v * np.roll(u, -1)))
