"""The box of coordinates that an energy allows, found by walks, for functions of any number of variables, at any scale.

The function is the least energy over a point, infinite outside the domain of the potential.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..core.descent import Floor, descended
from ..engine.values import at_points
from .allowed_region import crossings, extrema, radii

SEED = 20
"""Seed of all random numbers here: results are the same in every call."""

STARTS = 256
"""Points from which minima are sought, at sizes from 1e-8 to 1e8."""

WELLS = 12
"""Wells that are walked in."""

WALKERS = 32
"""Walkers in each well."""

WALKS = 48
"""Chords of each walker."""

NODES = np.geomspace(1e-4, 1e3, 141)
"""Distances along a chord, in sizes of the well, between which extrema are sought."""

MARGIN = 0.03
"""Margin of a box beyond the chords on each side."""

FACES = 2048
"""Points of a face that must be inaccessible."""

DECADES = 3
"""Decades of distances, in chords, in which minima of one depth lie where there is no end of them."""

STRIDE = 1 / 64
"""Length, in sizes of the box, of the steps that tell wells in the box from regions that reach into it."""

STRIDES = 200
"""Number of these steps."""


DIRECTIONS = 32
"""Directions in which values below the lowest minimum are sought."""

FAR = np.geomspace(1e-2, 1e4, 61)
"""Distances, in units of the coordinates, at which they are sought. Expanded squares cancel to 1e-8 at the last."""

ALIKE = 1e-9
"""Relative difference of values that counts as rounding."""


class AccessibleBox(NamedTuple):
    """Ranges low, high (d,) of the coordinates of all bounded wells; the least value in them; whether another allowed
    region reaches into the box.
    """

    low: np.ndarray
    high: np.ndarray
    least: float
    leaky: bool


class NoWell(ValueError):
    """Raised if no bounded region is found: `least` is the least value met, NaN if there is no minimum; `endless`:
    whether there are wells without end, as for a periodic potential.
    """

    def __init__(self, least: float, endless: bool = False):
        super().__init__("no bounded well")
        self.least = least
        self.endless = endless


def falls_below(floor: Floor, d: int, least: float) -> bool:
    """Return whether a function of d coordinates has values below its lowest minimum, so that this is a local one."""
    direction = np.random.default_rng(SEED).standard_normal((d, DIRECTIONS))
    direction /= np.sqrt((direction**2).sum(axis=0))
    with np.errstate(all="ignore"):
        value = floor((direction[:, :, None] * FAR).reshape(d, -1))
    return bool((value < least - ALIKE * abs(least)).any())


def minima(floor: Floor, d: int) -> tuple[np.ndarray, np.ndarray]:
    """Return local minima (d, found) and their values (found,), the lowest first; without those that go to infinity."""
    random = np.random.default_rng(SEED)
    size = np.geomspace(1e-8, 1e8, STARTS)
    direction = random.standard_normal((d, STARTS))
    even = size * direction / np.sqrt((direction**2).sum(axis=0))
    uneven = random.choice([-1.0, 1.0], (d, STARTS)) * 10.0 ** random.uniform(-8, 8, (d, STARTS))
    start = np.concatenate([np.zeros((d, 1)), even, uneven], axis=1)
    start = start[:, np.isfinite(floor(start))]
    widest = np.abs(start)
    x, value, step = descended(floor, start, np.where(start == 0, 1.0, widest / 2))
    widest = np.maximum(np.maximum(widest, np.abs(x)).max(axis=0), step.max(axis=0))
    settled = (step.max(axis=0) <= 1e-3 * widest) & np.isfinite(value)
    order = np.argsort(value[settled], kind="stable")
    return x[:, settled][:, order], value[settled][order]


def potential_of(model: Any) -> Floor:
    """Return V of points (n, ...) as a function that is infinite where a model has none."""

    def V(q: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            value = np.broadcast_to(
                np.where(at_points(model, "margin", *q) > 0, at_points(model, "potential_energy", *q), np.inf),
                q.shape[1:],
            )
        return np.where(np.isnan(value), np.inf, value)

    return V


def box_of(floor: Floor, d: int, energy: float) -> AccessibleBox:
    """Return the box of all bounded wells found below an energy. Raises NoWell if there is none."""
    at, value = minima(floor, d)
    if not value.size or not value[0] < energy:
        raise NoWell(float(value[0]) if value.size else np.nan)
    at = at[:, value < energy]
    value = value[value < energy]
    # Symmetric wells count as one: either both have an end or none.
    depth = np.rint((energy - value) / (energy - value[0]) * 1e6)
    wells = [np.flatnonzero(depth == level) for level in np.unique(depth)[::-1][:WELLS]]
    low, high, endless = _walked(floor, energy, [at[:, well] for well in wells])
    bounded = np.isfinite(low).all(axis=0)
    if endless or not bounded.any():
        raise NoWell(float(value[0]), endless)
    least = min(float(value[well].min()) for well, kept in zip(wells, bounded) if kept)
    low = low[:, bounded].min(axis=1)
    high = high[:, bounded].max(axis=1)
    wide = MARGIN * (high - low)
    low = low - wide
    high = high + wide
    return AccessibleBox(low, high, least, _leaks(floor, energy, low, high))


def walled(floor: Floor, periods: Sequence[float]) -> Floor:
    """Return a function of coordinates with these periods, 0 for none, restricted to half of one around 0."""
    half = np.array([0.5 * period if period > 0 else np.inf for period in periods])
    if not np.isfinite(half).any():
        return floor

    def within_walls(x: np.ndarray) -> np.ndarray:
        edge = half.reshape(-1, *[1] * (x.ndim - 1))
        return np.where((np.abs(x) <= edge).all(axis=0), floor(np.clip(x, -edge, edge)), np.inf)

    return within_walls


def box_of_angles(floor: Floor, periods: Sequence[float], energy: float) -> AccessibleBox:
    """Return the box of wells of coordinates with these periods, 0 for none: within half of one around 0."""
    box = box_of(walled(floor, periods), len(periods), energy)
    half = np.array(periods) / 2
    turns = half > 0
    low = np.where(turns, np.maximum(box.low, -half), box.low)
    high = np.where(turns, np.minimum(box.high, half), box.high)
    return box._replace(low=low, high=high)


def least_within(floor: Floor, low: np.ndarray, high: np.ndarray) -> float:
    """Return the least value in a box."""

    def inner(x: np.ndarray) -> np.ndarray:
        kept = ((x >= low[:, None]) & (x <= high[:, None])).all(axis=0)
        return np.where(kept, floor(np.clip(x, low[:, None], high[:, None])), np.inf)

    width = (high - low)[:, None]
    start = low[:, None] + width * np.random.default_rng(SEED).uniform(size=(len(low), STARTS))
    return float(descended(inner, start, np.broadcast_to(width / 8, start.shape), rounds=60)[1].min())


def within(floor: Floor, box: AccessibleBox, x: np.ndarray) -> np.ndarray:
    """Return a mask of points x (d, points) of a leaky box in wells that end within it: small steps down stay there."""
    width = (box.high - box.low)[:, None]
    bottom = descended(floor, x, np.broadcast_to(STRIDE * width, x.shape), grow=1.0, rounds=STRIDES)[0]
    return np.asarray(((bottom > box.low[:, None]) & (bottom < box.high[:, None])).all(axis=0))


def _walked(floor: Floor, energy: float, wells: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, bool]:
    """Return the least and the largest coordinates (d, wells) that walks from points of each well reach, infinite
    where some chord has no end; and whether there are wells without end, where no walk is made.
    """
    d = len(wells[0])
    random = np.random.default_rng(SEED)
    x = np.stack([well[:, np.linspace(0, well.shape[1] - 1, WALKERS).astype(np.int64)] for well in wells], axis=1)
    low, high = np.full((2, d, len(wells)), np.inf) * np.array([1.0, -1.0])[:, None, None]
    open_ = np.zeros(len(wells), bool)
    chords = np.empty_like(x)
    for k in range(-d, WALKS):
        if k == 0 and any(map(_scattered, wells, chords.swapaxes(0, 1), open_)):
            return low, high, True
        if open_.all():
            break
        if k < 0:  # along each coordinate, at all sizes
            direction = np.broadcast_to(np.eye(d)[:, [[k]]], x.shape)
        else:
            along = np.eye(d)[:, random.integers(d, size=x.shape[1:])]
            direction = (random.standard_normal(x.shape) if k % 3 else along) * (high - low)[..., None]
        flat = x.reshape(d, -1)
        ways = direction.reshape(d, -1)
        nodes = radii() if k < 0 else NODES
        both = _end(floor, energy, np.tile(flat, 2), np.concatenate([ways, -ways], axis=1), nodes)
        ahead, back = both.reshape(2, *x.shape[1:])
        if k < 0:
            chords[k] = ahead + back
        open_ |= ~(np.isfinite(ahead) & np.isfinite(back)).all(axis=1)
        ahead = np.where(open_[:, None], 0.0, ahead)
        back = np.where(open_[:, None], 0.0, back)
        tips = np.concatenate([x + ahead * direction, x - back * direction], axis=2)
        low = np.minimum(low, tips.min(axis=2))
        high = np.maximum(high, tips.max(axis=2))
        if k >= 0:
            x = x + (random.uniform(size=x.shape[1:]) * (ahead + back) - back) * direction
    open_ |= ~(high > low).all(axis=0)
    return np.where(open_, np.inf, low), np.where(open_, np.inf, high), False


def _scattered(x: np.ndarray, chords: np.ndarray, open_: bool) -> bool:
    """Tell whether minima (d, points) of one depth, with chords along the coordinates, lie ever further away."""
    if open_:
        return False
    far = (np.abs(x) / np.median(chords, axis=1, keepdims=True)).max(axis=0)
    return np.unique(np.floor(np.log10(far[far > 10]))).size >= DECADES


def _end(floor: Floor, energy: float, x: np.ndarray, direction: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return the distances (points,) at which lines first leave the allowed region; infinite where they don't."""

    def room(t: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        value = floor(spread(x[:, column], t) + t * spread(direction[:, column], t))
        return np.where(np.isinf(value), -np.inf, energy - value), abs(energy) + np.abs(value)

    column = np.arange(x.shape[1])
    sheets, allowed = crossings(room, extrema(room, column.size, nodes), column, np.zeros(column.size), False)
    first = np.isfinite(sheets).sum(axis=0) - 1  # the outermost comes first
    end = np.take_along_axis(sheets, np.maximum(first, 0)[None], axis=0)[0]
    return np.where(allowed, np.where(first < 0, np.inf, end), 0.0)


def spread(rows: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return rows (k, columns) as a fresh array (k, ...) of the shape of x (..., columns)."""
    return np.array(np.broadcast_to(rows.reshape(len(rows), *[1] * (x.ndim - 1), -1), (len(rows), *x.shape)))


def _leaks(floor: Floor, energy: float, low: np.ndarray, high: np.ndarray) -> bool:
    random = np.random.default_rng(SEED)
    for k in range(len(low)):
        for side in (low[k], high[k]):
            face = low[:, None] + (high - low)[:, None] * random.uniform(size=(len(low), FACES))
            face[k] = side
            if (floor(face) < energy).any():
                return True
    return False
