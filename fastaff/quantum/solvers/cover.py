"""Places where a potential may be lower than its samples: boxes that shrink until the enclosure of V excludes wells.

Samples miss wells that are narrower than their distances. An enclosure, by intervals that run through the formula of V,
misses none: a box whose enclosure reaches far below the samples in it is halved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .intervals import Interval, Sector, interval
from .singular_ends import potential, sampled

SLACK = 0.1
"""How far, in parts of the energy of the levels above the bottom, V may be below the samples of a box."""
MOST = 1 << 17
"""Largest number of boxes."""

MANY = 1 << 10
"""Number of boxes after which curvatures are used too."""

THIN = 2.0**-44
"""Narrowest box, in parts of its coordinates."""
EDGE = 2.0**-13
"""Part of an interval at its ends that is left to the exponents there."""
AXIS = 2e-5
"""1 - |cos(vartheta)| at alpha = 0 and beta = 0 that is left to the exponents there."""
NODES = 1500
"""Nodes that a cover adds to a grid at most."""
ONLY_SAMPLES = "; V is known at points only: no well between them is excluded"
"""Words in the method of levels if V takes no intervals."""


class Cover(NamedTuple):
    """Boxes that together hold all places where V may be below the top energy, and their samples of V.

    V(points (d, ...)); kinetic: of the highest level at the bottom; lo, hi (d, boxes); at (d, boxes), low (boxes,): the
    least sample of each; floor (boxes,): a lower bound of V in it; doubt (boxes,): whether that is far below `low`;
    blind: V takes no intervals, and there are no boxes.
    """

    V: Callable
    kinetic: float
    lo: np.ndarray
    hi: np.ndarray
    at: np.ndarray
    low: np.ndarray
    floor: np.ndarray
    doubt: np.ndarray
    blind: bool = False

    @property
    def said(self) -> str:
        """Words for the method of levels with this cover."""
        return ONLY_SAMPLES if self.blind else ""

    def where(self, chosen: np.ndarray) -> Cover:
        """Return some of the boxes."""
        rows = (self.lo, self.hi, self.at, self.low, self.floor, self.doubt)
        lo, hi, at, low, floor, doubt = (row[..., chosen] for row in rows)
        return Cover(self.V, self.kinetic, lo, hi=hi, at=at, low=low, floor=floor, doubt=doubt, blind=self.blind)

    def unseen(self, grids: Sequence[np.ndarray]) -> Cover:
        """Return the boxes whose least samples are much lower than V at the points of grids around them."""
        after = [np.clip(np.searchsorted(grid, at), 1, grid.size - 1) for grid, at in zip(grids, self.at, strict=True)]
        return self._below(*(np.array([grid[k - i] for grid, k in zip(grids, after, strict=True)]) for i in (1, 0)))

    def thin(self, lo: float, hi: float, samples: int) -> np.ndarray:
        """Return the intervals (2, k), inside of (lo, hi), whose wells so many samples there miss."""
        step = (hi - lo) / samples
        edge = EDGE * (hi - lo)
        some = self.where((self.lo[0] > lo + edge) & (self.hi[0] < hi - edge))
        before = lo + step * (np.floor((some.at - lo) / step - 0.5) + 0.5)
        return np.concatenate(some._below(before, before + step)[2:4])

    def _below(self, lo: np.ndarray, hi: np.ndarray) -> Cover:
        if not self.low.size:
            return self
        return self.where(self.low < self.V(_points(lo, hi)[:, :-1]).min(axis=0) - SLACK * self.kinetic)

    def nodes(self, which: int) -> np.ndarray:
        """Return the ends and middles of all boxes in one coordinate, spread over all of them if there are many."""
        lo = self.lo[which]
        hi = self.hi[which]
        nodes = np.unique([lo, (lo + hi) / 2, hi])
        return nodes[:: max(-(-nodes.size // NODES), 1)]

    def lost(self, E: np.ndarray) -> np.ndarray:
        """Return bounds of the error of levels E of -Delta + V by wells that cannot be excluded: E may be too high.

        The least of the distance to the floor and, to first order, the possible fall of V times the largest density.
        """
        some = self.where(self.doubt & (self.floor < E.max()))
        if not some.low.size:
            return np.zeros(E.shape)
        falls = ((some.low - some.floor) * np.prod(some.hi - some.lo, axis=0)).sum()
        first_order = falls * self.kinetic ** (len(some.lo) / 2)
        return np.minimum(np.maximum(E - some.floor.min(), 0), first_order if first_order < self.kinetic else np.inf)


def line_cover(U: Callable, V: Callable, edges: np.ndarray, top: float, kinetic: float) -> Cover:
    """Return the cover of the intervals between edges (n + 1,) by V; U(interval) encloses it."""

    def enclosure(lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
        return interval(U(Interval(lo[0], hi[0]))).lo

    return _cover(enclosure, lambda points: sampled(V, points[0]), edges[None, :-1], edges[None, 1:], top, kinetic)


def plane_cover(
    model: Any,
    quanta: tuple[float, float],
    rho: tuple[float, float],
    walled: bool,
    top: float,
    kinetic: float,
    unit: float = 1.0,
) -> Cover:
    """Return the cover of a body's plane, in rho and x = cos(vartheta), by V/unit + a^2/A + b^2/B, of quanta a, b.

    walled: whether the body lives on det phi > 0 alone.
    """
    a, b = (number**2 for number in quanta)

    def rest(A: Any, B: Any) -> Any:
        return (a / A if a else 0.0) + (b / B if b else 0.0)

    q = np.geomspace(*rho, 57)
    x = np.linspace(0.0 if walled else AXIS - 1, 1 - AXIS, 9)

    def enclosure(lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
        A, B = Sector(lo, hi).squares()
        live = interval(model.potential.margin(A, B)).hi > 0
        return np.where(live, interval(model.potential.value(A, B)).lo / unit + rest(A.hi, B.hi), np.inf)

    def V(points: np.ndarray) -> np.ndarray:
        q, x = points
        A = q * q * (1 + x) / 2
        B = q * q * (1 - x) / 2
        with np.errstate(all="ignore"):
            return np.asarray(potential(model, A, B) / unit + rest(A, B))

    def sag(lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
        """Bound by curvatures how far V may be below the corners: boxes are quadrangles of A + B and A - B."""
        A, B = Sector(lo, hi).squares()
        V_AA, V_AB, V_BB = map(interval, model.potential.curvatures(A, B))
        steep = rest(A.lo**3, np.inf), rest(np.inf, B.lo**3)
        V_AA, V_BB = (V / unit + Interval(0.0 * more, 2 * more) for V, more in zip((V_AA, V_BB), steep, strict=True))
        both = V_AA + V_BB
        mixed = V_AA - V_BB
        bends = ((both + 2 / unit * V_AB).hi, (both - 2 / unit * V_AB).hi, 2 * np.absolute(mixed).hi)
        s, d = (side.hi - side.lo for side in (A + B, A - B))
        return sum(np.maximum(bend, 0) * part for bend, part in zip(bends, (s * s, d * d, s * d), strict=True)) / 32

    lo, hi = (np.array(np.meshgrid(*side)).reshape(2, -1) for side in ((q[:-1], x[:-1]), (q[1:], x[1:])))
    return _cover(enclosure, V, lo, hi, top, kinetic, sag if hasattr(model.potential, "curvatures") else None)


def _cover(
    enclosure: Callable,
    V: Callable,
    lo: np.ndarray,
    hi: np.ndarray,
    top: float,
    kinetic: float,
    sag: Callable | None = None,
) -> Cover:
    """Return a cover of the boxes lo, hi (d, boxes).

    enclosure(lo, hi) encloses V on boxes, sag(lo, hi) bounds how far V may be below its corners.
    """
    done = []
    looked = 0
    while True:
        try:
            floor = _floor(enclosure, lo, hi)
        except Exception:  # any error of a function that takes numbers alone
            none = np.empty(0)
            return Cover(V, kinetic, *(lo[:, :0],) * 3, none, none, none > 0, True)
        keep = floor < top
        looked = looked + lo.shape[1]
        lo = lo[:, keep]
        hi = hi[:, keep]
        floor = floor[keep]
        points = _points(lo, hi)
        values = V(points)
        least = np.argmin(values, axis=0)
        each = np.arange(floor.size)
        at = points[:, least, each]
        low = values[least, each]
        if sag is not None and looked > MANY:
            floor = np.fmax(floor, values[:-1].min(axis=0) + _floor(lambda *box: -sag(*box), lo, hi))
        slack = SLACK * np.maximum(kinetic, top - low)
        doubt = floor < low - slack
        dip = low < values[:-1].min(axis=0) - slack
        split = (doubt | dip) & ((hi - lo) > THIN * np.maximum(np.abs(lo), np.abs(hi))).any(axis=0)
        if looked + 2 * split.sum() > MOST:
            split[:] = False
        done.append([row[..., ~split] for row in (lo, hi, at, low, floor, doubt)])
        if not split.any():
            break
        lo, hi = _halves(enclosure, lo[:, split], hi[:, split], floor[split])
    lo, hi, at, low, floor, doubt = (np.concatenate(rows, axis=-1) for rows in zip(*done, strict=True))
    return Cover(V=V, kinetic=kinetic, lo=lo, hi=hi, at=at, low=low, floor=floor, doubt=doubt)


def _floor(enclosure: Callable, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        floor = np.broadcast_to(enclosure(lo, hi), lo.shape[1:])
    return np.where(np.isnan(floor), -np.inf, floor)


def _points(lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """Return corners and middles (d, points, boxes) of boxes, the middles last."""
    corners = np.array(np.meshgrid(*[[0.0, 1.0]] * len(lo), indexing="ij")).reshape(len(lo), -1)
    parts = np.append(corners, np.full((len(lo), 1), 0.5), axis=1)[..., None]
    return np.asarray(lo[:, None] * (1 - parts) + hi[:, None] * parts)


def _halves(enclosure: Callable, lo: np.ndarray, hi: np.ndarray, floor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both halves of each box, along the coordinate whose width moves the enclosure most.

    Those of positive coordinates that grow more than twofold have equal ratios.
    """
    middle = np.where((lo > 0) & (hi > 2 * lo), np.sqrt(np.abs(lo * hi)), (lo + hi) / 2)
    which = np.zeros(lo.shape[1], int)
    if len(lo) > 1:
        sides = np.eye(len(lo), dtype=bool)[..., None]
        flat = np.array([_floor(enclosure, *(np.where(side, middle, end) for end in (lo, hi))) for side in sides])
        known = np.isfinite(floor) & np.isfinite(flat).all(axis=0)
        width = (hi - lo) / (hi + np.abs(lo))
        with np.errstate(invalid="ignore"):
            which = np.argmax(np.where(known, flat - floor, width), axis=0)
    cut = np.arange(len(lo))[:, None] == which
    left = np.where(cut, middle, hi)
    right = np.where(cut, middle, lo)
    return np.concatenate([lo, right], axis=1), np.concatenate([left, hi], axis=1)
