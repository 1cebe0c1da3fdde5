"""Wells of a vibration that descents do not meet: boxes of coordinates whose enclosures of V exclude all others.

Intervals run through V and through the force, over boxes that cover all coordinates from 1e-8 to 1e8. See `cover`.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from ...core.descent import descended
from .cover import SLACK, THIN
from .intervals import Interval, interval
from .lattice import LatticeGrid, LatticeProblem

SMALL = 1e-8
"""Coordinates of boxes below this one are cut evenly, the others by ratios."""

LARGE = 1e8
"""Largest coordinate of boxes that is cut by ratios."""

MOST = 1 << 16
"""Most boxes."""

RELATIVE = 0.125
"""If a region has no end, the narrowest box that tells regions apart, in parts of its coordinates."""

DESCENTS = 256
"""Most descents at a time."""

SETTLED = 1e-6
"""Size of the last step, in sizes of the coordinates, of a descent that has come to a minimum."""

STEPS = 0.5
"""First step of a descent in parts of its box."""


class WellCover(NamedTuple):
    """Boxes of coordinates that together hold all places where V may be below an energy, and their samples of V.

    lo, hi (d, boxes); at (d, boxes), low (boxes,): the place and the least of the samples of each; floor (boxes,): a
    lower bound of V in it; coarse (boxes,): whether it would have to be halved, but there are too many boxes; blind:
    whether V takes no intervals, and there are no boxes.
    """

    lo: np.ndarray
    hi: np.ndarray
    at: np.ndarray
    low: np.ndarray
    floor: np.ndarray
    coarse: np.ndarray
    blind: bool = False

    def where(self, chosen: np.ndarray) -> WellCover:
        """Return some of the boxes."""
        lo, hi, at, low, floor, coarse = (row[..., chosen] for row in self[:6])
        return WellCover(lo, hi, at, low=low, floor=floor, coarse=coarse, blind=self.blind)


class Boxes(NamedTuple):
    """How boxes of coordinates are made of boxes of t, q = SMALL sinh(t): model; problem; half: the largest coordinate
    of angles (d, 1), infinite for others.
    """

    model: Any
    problem: LatticeProblem
    half: np.ndarray

    def place(self, t: np.ndarray) -> np.ndarray:
        """Return q of t (d, ...): even next to 0, logarithmic beyond."""
        half = self.half.reshape(-1, *[1] * (t.ndim - 1))
        return np.clip(SMALL * np.sinh(t), -half, half)

    def V(self, q: np.ndarray) -> np.ndarray:
        """Return V of coordinates q (d, ...)."""
        return self.problem.V(np.tensordot(np.linalg.inv(self.problem.R), q, 1))

    def bounds(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return bounds (boxes,) of V between q = low and high (d, boxes), and whether a minimum may be there: where no
        slope has one sign, or where V ends.

        The best of three: intervals through V; V at the middle and the largest slopes times half widths, which is of
        second order in the width; intervals through V at the ends that signs of slopes name, for the lower bound.
        """
        shape = low.shape[1:]
        box = [Interval(*ends) for ends in zip(low, high, strict=True)]
        with np.errstate(all="ignore"):
            margin = interval(self.model.margin(*box))
            live = margin.hi > 0
            flat = np.ones(shape, bool)
            plain = interval(self.model.potential_energy(*box))
            floor = np.broadcast_to(plain.lo, shape)
            ceiling = np.broadcast_to(plain.hi, shape)
            slopes = _slopes(self.model, box)
            if slopes is not None:
                least, most = slopes
                middle = self.V((low + high) / 2)
                steep = (np.maximum(np.abs(least), np.abs(most)) * ((high - low) / 2)).sum(axis=0)
                first = np.where(most <= 0, high, low)
                last = np.where(least >= 0, low, high)
                pinned = interval(self.model.potential_energy(*map(Interval, first, last)))
                floor = np.fmax(np.fmax(floor, middle - steep), np.broadcast_to(pinned.lo, shape))
                ceiling = np.fmin(ceiling, middle + steep)
                flat = ((least <= 0) & (most >= 0)).all(axis=0) | (margin.lo <= 0)
        return np.where(live, floor, np.inf), np.where(live, ceiling, np.inf), flat


def vibration_cover(model: Any, problem: LatticeProblem, top: float, step: np.ndarray) -> WellCover:
    """Return the cover of the coordinates by boxes where V may be below `top`.

    A box is halved while V may be far below its samples, and, down to the steps (d,) of a grid, while it may hold a
    minimum and is not all below `top`: from other boxes V falls to their neighbours.
    """
    d = len(problem.wells)
    half = np.where(problem.periods > 0, problem.periods * np.diagonal(problem.R) / 2, np.inf)[:, None]
    size = max(1.0, float(np.abs(problem.R @ problem.wells[:, :1]).max(initial=0.0)))
    boxes = Boxes(model, problem, half)
    edge = np.minimum(math.asinh(LARGE * size / SMALL), np.arcsinh(half / SMALL))
    inverse = np.abs(np.linalg.inv(problem.R))
    lo = -edge
    hi = edge
    done = []
    looked = 0
    faces = _corners(boxes.place(lo), boxes.place(hi), 8)
    endless = bool((boxes.V(faces[:, (np.abs(faces) >= LARGE).any(axis=0).ravel()]) < top).any())
    while lo.size:
        low, high = boxes.place(lo), boxes.place(hi)
        try:
            floor, ceiling, flat = boxes.bounds(low, high)
        except Exception:  # any error of a function that takes numbers alone
            none = np.empty(0)
            return WellCover(*(lo[:, :0],) * 3, none, none, none > 0, blind=True)
        keep = floor < top
        looked = looked + floor.size
        lo, hi, low, high, floor = (row[..., keep] for row in (lo, hi, low, high, floor))
        flat = (flat & (ceiling >= top))[keep]
        points = boxes.place(_corners(lo, hi, 2))
        values = boxes.V(points)
        best = np.argmin(values, axis=0)
        each = np.arange(floor.size)
        at = points[:, best, each]
        least = values[best, each]
        slack = SLACK * np.maximum(top - problem.bottom, top - least)
        deep = (floor < least - slack) | (least < values[:-1].min(axis=0) - slack)
        wide = step[:, None] if not endless else np.maximum(step, RELATIVE * np.abs(inverse @ np.abs(at)).T).T
        several = flat & (inverse @ (high - low) > wide).any(axis=0)
        more = (deep | several) & ((hi - lo) > THIN * np.maximum(np.abs(lo), np.abs(hi))).any(axis=0)
        full = looked + 2 * more.sum() > MOST
        split = more & ~full
        done.append([row[..., ~split] for row in (low, high, at, least, floor, more)])
        lo = lo[:, split]
        hi = hi[:, split]
        which = np.arange(d)[:, None] == np.argmax(hi - lo, axis=0)
        middle = (lo + hi) / 2
        lo = np.concatenate([lo, np.where(which, middle, lo)], axis=1)
        hi = np.concatenate([np.where(which, middle, hi), hi], axis=1)
    low, high, at, least, floor, coarse = (np.concatenate(rows, axis=-1) for rows in zip(*done, strict=True))
    return WellCover(low, high, at, low=least, floor=floor, coarse=coarse)


def _corners(lo: np.ndarray, hi: np.ndarray, count: int) -> np.ndarray:
    """Return the points (d, points, boxes) of even lattices of count^d points of boxes, then their middles."""
    part = np.array(np.meshgrid(*[np.linspace(0, 1, count)] * len(lo), indexing="ij")).reshape(len(lo), -1)
    part = np.append(part, np.full((len(lo), 1), 0.5), axis=1)[..., None]
    return np.asarray(lo[:, None] * (1 - part) + hi[:, None] * part)


def _slopes(model: Any, box: list[Interval]) -> tuple[np.ndarray, np.ndarray] | None:
    """Return bounds (d, boxes) of dV/dq on boxes, None where the force takes no intervals."""
    try:
        with np.errstate(all="ignore"):
            force = [interval(one) for one in model.force(*box)]
    except Exception:  # any error of a function that takes numbers alone
        return None
    shape = box[0].lo.shape
    return tuple(
        np.array([np.broadcast_to(end, shape) for end in ends])
        for ends in zip(*((-f.hi, -f.lo) for f in force), strict=True)
    )  # type: ignore[return-value]


def more_wells(problem: LatticeProblem, cover: WellCover, grid: LatticeGrid | None, top: float) -> LatticeProblem:
    """Return the problem with further minima of V: those that descents reach from boxes which a grid does not see."""
    inverse = np.linalg.inv(problem.R)
    some = cover.where((cover.low < top) & _hidden(problem, grid, top, inverse @ cover.at, cover.low))
    if not some.low.size:
        return problem
    order = np.argsort(some.low, kind="stable")
    if order.size > DESCENTS:  # the lowest, and others evenly
        half = DESCENTS // 2
        order = np.concatenate([order[:half], order[half:][:: -(-(order.size - half) // half)]])
    some = some.where(order)
    step = np.abs(inverse) @ (STEPS * (some.hi - some.lo))
    x, value, last = descended(problem.V, inverse @ some.at, step)
    settled = (last.max(axis=0) <= SETTLED * np.maximum(step.max(axis=0), np.abs(x).max(axis=0))) & np.isfinite(value)
    settled &= (value < top) & (np.abs(problem.R @ x).max(axis=0) < LARGE)
    settled &= _hidden(problem, grid, top, x, value)
    wells = np.concatenate([problem.wells, x[:, settled]], axis=1)
    values = np.concatenate([problem.values, value[settled]])
    order = np.argsort(values, kind="stable")
    return problem._replace(wells=wells[:, order], values=values[order])


def lost(problem: LatticeProblem, cover: WellCover, grid: LatticeGrid, top: float, E: np.ndarray) -> np.ndarray:
    """Return bounds of the errors of levels E by wells that neither intervals exclude nor the grid sees.

    The least of the distance to the floor and, to first order, of the possible fall of V times the largest density of
    waves of that kinetic energy. If a region below `top` remains outside of the grid's wells, no
    minimum of V was found in it: it has no end, and boxes beyond the grid do not count.
    """
    none = np.zeros(E.shape)
    if cover.blind or not cover.low.size:
        return none
    around, kept = _beside(problem, grid, np.linalg.solve(problem.R, cover.at))
    around = np.minimum(np.where(cover.coarse, top, around), top)
    far = SLACK * (top - problem.bottom)
    away = (cover.floor < E.max()) & (cover.floor < around - far)
    away &= kept | ~(~kept & (cover.low < top - far)).any()
    if not away.any():
        return none
    some = cover.where(away)
    d = len(problem.wells)
    size = np.prod(some.hi - some.lo, axis=0) / abs(np.linalg.det(problem.R))
    ball = math.pi ** (d / 2) / math.gamma(d / 2 + 1)
    density = ball * (math.sqrt(2 * (top - problem.bottom)) / (2 * math.pi)) ** d
    first_order = float(((around[away] - some.floor) * size).sum() * density)
    small = first_order < SLACK * (top - problem.bottom)
    return np.minimum(np.maximum(E - some.floor.min(), 0), first_order if small else np.inf)


def _hidden(problem: LatticeProblem, grid: LatticeGrid | None, top: float, u: np.ndarray, V: np.ndarray) -> np.ndarray:
    """Tell places u (d, places) where V is far below its values at the points of a grid around, or none is kept."""
    if grid is None:
        return np.ones(V.shape, bool)
    around, kept = _beside(problem, grid, u)
    return ~kept | (np.minimum(around, top) - SLACK * (top - problem.bottom) > V)


def _beside(problem: LatticeProblem, grid: LatticeGrid, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least V (places,) at the points of a grid around places u (d, places), infinite beyond the grid, and
    whether one of these points is kept.
    """
    steps = (u - problem.wells[:, :1]) / grid.step[:, None]
    shape = np.array(grid.V.shape)[:, None]
    least = np.full(u.shape[1], np.inf)
    kept = np.zeros(u.shape[1], bool)
    for corner in itertools.product((0, 1), repeat=len(u)):
        index = np.floor(steps) + np.array(corner)[:, None] - grid.low[:, None]
        index = np.where(grid.around[:, None], index % shape, index)
        inside = ((index >= 0) & (index < shape)).all(axis=0)
        place = tuple(np.where(inside, index, 0).astype(np.int64))
        least = np.where(inside, np.minimum(least, grid.V[place]), least)
        kept |= inside & grid.kept[place]
    return least, kept
