"""Names written along curves so that none covers another, nor leaves the frame."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .style import SMALL

PLACES = 48
"""Places along a curve that are tried."""
ROOM = 1.25
"""Sizes of the room that a name takes, beside its own."""
APART = 2.0
"""Half heights of a text that stay empty between two names, so that each is seen with its own curve."""


class LabelBox(NamedTuple):
    """A rectangle in pixels: its centre, half its sides, and its direction in radians."""

    centre: np.ndarray
    half: np.ndarray
    angle: float

    def corners(self) -> np.ndarray:
        """Return the corners (4, 2)."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        sides = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * self.half
        return self.centre + sides @ np.array([[c, s], [-s, c]])

    def holds(self, points: np.ndarray) -> int:
        """Return the number of points (points, 2) in it."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        return int((np.abs((points - self.centre) @ np.array([[c, -s], [s, c]])) <= self.half).all(axis=1).sum())

    def overlaps(self, other: LabelBox) -> bool:
        """Tell whether two rectangles share a point: no side of either has them on different sides."""
        one = self.corners()
        two = other.corners()
        for angle in (self.angle, self.angle + math.pi / 2, other.angle, other.angle + math.pi / 2):
            axis = np.array([math.cos(angle), math.sin(angle)])
            a = one @ axis
            b = two @ axis
            if a.max() < b.min() or b.max() < a.min():
                return False
        return True


def pixel_length(ax: Any, curve: np.ndarray) -> float:
    """Return the length of a curve (points, 2) on the figure, inside the frame, in pixels."""
    where = ax.transData.transform(curve)
    box = ax.transAxes.inverted().transform(where)
    inside = ((box >= 0) & (box <= 1)).all(axis=1)
    steps = np.hypot(*np.diff(where, axis=0).T)
    return float(steps[inside[1:] & inside[:-1]].sum())


def size_of(ax: Any, text: str, **style: Any) -> np.ndarray:
    """Return width and height of a text on a figure in pixels."""
    written = ax.text(0.5, 0.5, text, transform=ax.transAxes, **style)
    box = written.get_window_extent()
    written.remove()
    return np.array([box.width, box.height])


def drawn_points(ax: Any) -> np.ndarray:
    """Return the points (points, 2) of the collections of axes."""
    return np.concatenate([np.zeros((0, 2)), *(np.asarray(one.get_offsets()) for one in ax.collections)])


def write_along(
    ax: Any,
    curve: np.ndarray,
    text: str,
    taken: list[LabelBox],
    lift: float = 0.0,
    points: np.ndarray | None = None,
    **style: Any,
) -> Any:
    """Write a name on a curve (points, 2) where it is straight and nothing is written yet; return the text, or None
    where there is no room.

    taken: boxes of the names written so far, to which that of this name is added; lift: of the name above the curve, in
    heights of the text; points (points, 2): it covers these only if there is no other room. Call it when limits and
    layout are final: `settled`.
    """
    style = {"fontsize": SMALL, "ha": "center", "va": "center", **style}
    half = 0.5 * size_of(ax, text, **style) * [1.0, ROOM] + [2.0, 0.0]
    where = ax.transData.transform(_even(ax, curve))
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(where, axis=0).T))])
    if travelled[-1] < 2 * half[0]:
        return None
    frame = np.array([ax.bbox.min, ax.bbox.max])
    best = -math.inf
    found = None
    dots = ax.transData.transform(np.zeros((0, 2)) if points is None else points)
    for share in np.linspace(0.0, 1.0, PLACES + 2)[1:-1]:
        middle = share * travelled[-1]
        if middle < half[0] or middle > travelled[-1] - half[0]:
            continue
        under = _at(where, travelled, middle + np.linspace(-1, 1, 9) * half[0])
        chord = under[-1] - under[0]
        chord = -chord if chord[0] < 0 else chord
        angle = math.atan2(chord[1], chord[0])
        normal = np.array([-math.sin(angle), math.cos(angle)])
        bend = float(np.ptp((under - under[0]) @ normal))
        centre = under[4] + lift * 2 * half[1] * normal
        box = LabelBox(centre, half, angle)
        around = LabelBox(centre, half + APART * half[1], angle)
        corners = box.corners()
        if (corners < frame[0] + 2).any() or (corners > frame[1] - 2).any() or any(map(around.overlaps, taken)):
            continue
        away = min((float(np.hypot(*(centre - other.centre))) for other in taken), default=math.inf)
        score = min(away / half[0], 4.0) - bend / half[1] - abs(share - 0.5) - min(box.holds(dots), 20) / 4
        if score > best:
            best = score
            found = box
    if found is None:
        return None
    taken.append(found)
    place = ax.transData.inverted().transform(found.centre)
    ahead = ax.transData.inverted().transform(
        found.centre + 10 * np.array([math.cos(found.angle), math.sin(found.angle)])
    )
    turned = math.degrees(math.atan2(*(ahead - place)[::-1]))
    return ax.text(*place, text, rotation=turned, rotation_mode="anchor", transform_rotates_text=True, **style)


def settled(ax: Any) -> None:
    """Lay the figure out, so that places in pixels are those of the picture."""
    ax.figure.draw_without_rendering()


def _even(ax: Any, curve: np.ndarray) -> np.ndarray:
    """Return a curve with 200 points or more, its straight parts cut."""
    if len(curve) >= 200:
        return curve
    pieces = max(1, 200 // max(len(curve) - 1, 1))
    t = np.linspace(0, len(curve) - 1, pieces * (len(curve) - 1) + 1)
    return np.column_stack([np.interp(t, np.arange(len(curve)), column) for column in curve.T])


def _at(where: np.ndarray, travelled: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(lengths, travelled, column) for column in where.T])
