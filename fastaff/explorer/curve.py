"""The rotation number of a closed curve of any shape, as in curve.js: about its inside, not the mean of its points."""

from __future__ import annotations

from typing import NamedTuple

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

CLOSED = 1.25
"""Largest length of a polygon over that of every second point: it is 1 on a curve, 2 for points over an area."""

MOST_BACKWARDS = 0.03
"""Turns that images may go backwards: rounding alone on a curve seen from its inside, above a tenth for crescents."""

AGREES = 2.0
"""Distance of two rotation numbers that agree, in sums of their errors."""

LEAST_GAP = np.pi
"""Gap of the angles about the mean from which the mean lies outside."""


class Turning(NamedTuple):
    """A rotation number in turns per crossing, in (-1/2, 1/2], with its error."""

    value: float
    error: float


class Ordered(NamedTuple):
    """Points in the order of the fractions of k turns, and the length of their closed polygon."""

    turn: float
    order: np.ndarray
    length: float


def curve_rotation(points: np.ndarray) -> Turning | None:
    """Return the rotation number of points (2, crossings) about the inside of their curve, None for too few points.

    It is about the mean of the points if that sees all of the curve; else it is the mean advance along the curve.
    """
    found = rotation_number(points)
    if not np.isfinite(found.error[0]):
        return None
    about = Turning(float(found.rotation[0]), float(found.error[0]))
    if _seen_from_mean(points):
        return about
    along = along_curve(points)
    if along is None:
        return about
    apart = abs(about.value - along.value)
    differ = min(apart, 1.0 - apart) > AGREES * (about.error + along.error)
    return along if differ or along.error < about.error else about


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
    if best is None or not _is_curve(best.order, plane):
        return None
    walked = np.concatenate([[0.0], np.cumsum(_sides(best.order, plane))])
    places = np.empty(plane.shape[1])
    places[best.order] = 2 * np.pi * walked[:-1] / walked[-1]
    advance = rotation_number(np.array([np.cos(places), np.sin(places)]), centre=[0.0, 0.0])
    value = float(advance.rotation[0])
    apart = value - best.turn
    turns = value if _area(best.order, plane) > 0 else -value
    return Turning(turns - np.ceil(turns - 0.5), float(advance.error[0]) + abs(apart - round(apart)))


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


def _is_curve(order: np.ndarray, plane: np.ndarray) -> bool:
    """Tell whether the polygon of points in an order is no longer than that of a curve."""
    return bool(_sides(order, plane).sum() <= CLOSED * _sides(order[::2], plane).sum())


def _area(order: np.ndarray, plane: np.ndarray) -> float:
    """Return twice the area of a polygon, positive if it turns counterclockwise."""
    u, v = plane[:, order]
    return float(np.sum(u * np.roll(v, -1) - v * np.roll(u, -1)))
