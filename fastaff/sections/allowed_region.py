"""Ranges where functions of one variable are positive, at any scale: their extrema, found by ratios, not lengths.

A function f(x, column) returns its values and the sizes of the terms in their sums, which set their rounding; values
that are not finite count as minus infinity. Between neighbouring extrema it is monotone, so that every crossing of a
level has a sure bracket.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

Function = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]

SMALLEST = 1e-40
"""Least distance from 0 that is searched."""

LARGEST = 1e40
"""Largest distance from 0 that is searched."""

COARSE = 12
"""Nodes in a decade of the whole range."""

FINE = 40
"""Nodes in a decade of the part with extrema and zeros."""

ZOOM = 6
"""Nodes in a decade of the distances from a maximum."""

ROUNDING = 16 * float(np.finfo(float).eps)
"""Rounding error of a function, relative to the size of its terms."""

_BLOCK = 2048
"""Columns that are searched at once."""

_PILOTS = 48
"""Columns whose extrema and zeros tell where those of all others are sought."""

_PEAKS = 4
"""Highest peaks of a column that are climbed."""


class Extrema(NamedTuple):
    """The ends of the range and the extrema between, ascending: x and f (extrema, columns), the last one repeated where
    there are fewer.
    """

    x: np.ndarray
    f: np.ndarray


def radii(least: float = SMALLEST, most: float = LARGEST, density: int = COARSE) -> np.ndarray:
    """Return numbers from least to most, `density` in a decade."""
    return np.geomspace(least, most, 2 + int(density * np.log10(most / least)))


def line() -> np.ndarray:
    """Return numbers of both signs and all sizes, and 0."""
    positive = radii()
    return np.concatenate([-positive[::-1], [0.0], positive])


def evaluated(f: Function, x: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return values, minus infinity where there are none, and their rounding errors."""
    with np.errstate(all="ignore"):
        value, size = f(x, column)
        value = np.broadcast_to(value, np.shape(x))
        size = np.broadcast_to(size, np.shape(x))
        value = np.where(np.isnan(value), -np.inf, value)
        return value, np.where(np.isfinite(size) & np.isfinite(value), ROUNDING * size, 0.0)


def climb(
    f: Function, column: np.ndarray, low: np.ndarray, high: np.ndarray, sign: Any = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the place and the value of the maximum of sign*f, the only one between low and high, to 1e-9 of the
    distance.

    It takes the best of some points between, then the same between its neighbours: many points at once for few columns.
    """
    count = 31 if column.size < 256 else 5
    share = np.arange(count + 2)[:, None] / (count + 1)
    a = low
    b = high
    for _ in range(int(np.ceil(30 / np.log2((count + 1) / 2)))):
        x = a + (b - a) * share
        value = sign * evaluated(f, x, column)[0]
        best = np.clip(value.argmax(axis=0), 1, count)
        a, b = (np.take_along_axis(x, (best + step)[None], axis=0)[0] for step in (-1, 1))
    middle = np.take_along_axis(x, best[None], axis=0)[0]
    return middle, sign * np.take_along_axis(value, best[None], axis=0)[0]


def _peaks(value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows and columns of interior nodes that are at least as high as their neighbours, and higher than the
    next.
    """
    inner = value[1:-1]
    row, column = np.nonzero((inner >= value[:-2]) & (inner > value[2:]) & np.isfinite(inner))
    return row + 1, column


def highest(f: Function, columns: int, nodes: np.ndarray) -> np.ndarray:
    """Return the largest value of each column between the first and the last of the nodes."""
    x = np.broadcast_to(nodes[:, None], (nodes.size, columns))
    value, _ = evaluated(f, x, np.arange(columns))
    best = value.max(axis=0)
    row, column = _peaks(value)
    if row.size:
        _, top = climb(f, column, nodes[row - 1], nodes[row + 1])
        np.maximum.at(best, column, top)
    return best


def extrema(f: Function, columns: int, nodes: np.ndarray | None = None) -> Extrema:
    """Return the extrema of each column, from nodes, or a search over all sizes of positive x, and closer nodes around
    maxima.
    """
    if nodes is None:
        nodes = _where_it_happens(f, columns, radii())
    j = np.arange(columns)
    parts = [_block(_among(f, block), block.size, nodes) for block in np.split(j, range(_BLOCK, columns, _BLOCK))]
    length = max(len(part.x) for part in parts)
    whole = [[np.concatenate([a, np.repeat(a[-1:], length - len(a), axis=0)]) for a in part] for part in parts]
    return Extrema(*(np.concatenate(arrays, axis=1) for arrays in zip(*whole, strict=True)))


def _among(f: Function, chosen: np.ndarray) -> Function:
    """Return the function of the chosen columns alone."""
    return lambda x, j: f(x, chosen[j])


def line_where_it_happens(f: Function, columns: int) -> np.ndarray:
    """Return numbers of both signs and 0, at all sizes at which a few columns have extrema or zeros."""
    if columns <= _PILOTS:
        return line()
    near = _where_it_happens(f, columns, line(), COARSE)
    return np.concatenate([-near[::-1], [0.0], near])


def _where_it_happens(f: Function, columns: int, nodes: np.ndarray, density: int = FINE) -> np.ndarray:
    """Return close nodes around the sizes of all extrema and zeros of a few columns, with three decades of margin."""
    pilots = np.unique(np.linspace(0, columns - 1, min(columns, _PILOTS)).astype(np.int64))
    few = _among(f, pilots)
    found = _block(few, pilots.size, nodes)
    size = np.abs(found.x)
    positive = found.f >= 0
    edges = positive[1:] != positive[:-1]
    happens = np.zeros(found.x.shape, dtype=bool)
    happens[1:-1] = (size[1:-1] > SMALLEST * 2) & (size[1:-1] < LARGEST / 2)
    marks = [size[happens]]
    rows, column = np.nonzero(edges)
    if rows.size:
        up = ~positive[rows, column]
        zeros = _bisected(few, column, found.x[rows, column], found.x[rows + 1, column], up, 0.0 * column)
        marks.append(np.abs(zeros[zeros != 0]))
    seen = np.concatenate(marks)
    if not seen.size:
        return radii()
    return radii(max(SMALLEST, 1e-3 * seen.min()), min(LARGEST, 1e3 * seen.max()), density)


def _block(f: Function, columns: int, nodes: np.ndarray) -> Extrema:
    j = np.arange(columns)
    x = np.array(np.broadcast_to(nodes[:, None], (nodes.size, columns)))
    value, noise = evaluated(f, x, j)
    row, column = _peaks(value)
    if row.size:
        keep = _rank(column, value[row, column]) < _PEAKS
        row, column = row[keep], column[keep]
        width = nodes[row + 1] - nodes[row - 1]
        top, _ = climb(f, column, nodes[row - 1], nodes[row + 1])
        slot = _rank(column, value[row, column])
        steps = 10.0 ** (-np.arange(9 * ZOOM) / ZOOM)
        offsets = np.concatenate([-steps, [0.0], steps[::-1]])
        extra = np.full((slot.max() + 1, columns, offsets.size), nodes[-1])
        extra[slot, column] = np.clip(top[:, None] + width[:, None] * offsets, nodes[0], nodes[-1])
        extra = extra.transpose(0, 2, 1).reshape(-1, columns)
        more, more_noise = evaluated(f, extra, j)
        order = np.argsort(np.concatenate([x, extra]), axis=0, kind="stable")
        x, value, noise = (
            np.take_along_axis(np.concatenate(pair), order, axis=0)
            for pair in ((x, extra), (value, more), (noise, more_noise))
        )
    turns = _turns(value, noise)
    at, found = (np.take_along_axis(array, turns, axis=0) for array in (x, value))
    last = len(x) - 1
    row, column = np.nonzero((turns > 0) & (turns < last))
    if row.size:
        middle = turns[row, column]
        sign = np.where(found[row, column] >= found[row - 1, column], 1.0, -1.0)
        low = x[middle - 1, column]
        high = x[middle + 1, column]
        place, height = climb(f, column, low, high, sign)
        better = sign * height > sign * found[row, column]
        at[row, column] = np.where(better, place, at[row, column])
        found[row, column] = np.where(better, height, found[row, column])
    return Extrema(at, found)


def _rank(column: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return the rank of each value among those of its column, the largest first."""
    order = np.lexsort((-value, column))
    first = np.searchsorted(column[order], column[order], side="left")
    rank = np.empty(column.size, np.int64)
    rank[order] = np.arange(column.size) - first
    return rank


def _turns(value: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return the rows of the first node, of maxima and minima in turn, and of the last node; ripples below the noise do
    not count.
    """
    rows, columns = value.shape
    j = np.arange(columns)
    rising = np.ones(columns, dtype=bool)
    best = value[0].copy()
    at = np.zeros(columns, np.int64)
    count = np.ones(columns, np.int64)
    found = np.zeros((8, columns), np.int64)
    for k in range(1, rows):
        now = value[k]
        with np.errstate(invalid="ignore"):
            turned = np.where(rising, now < best - noise[k], now > best + noise[k])
        if turned.any():
            if count.max() + 2 > len(found):
                found = np.concatenate([found, np.zeros_like(found)])
            new = turned & (at > 0)
            found[count[new], j[new]] = at[new]
            count[new] += 1
            rising = rising ^ turned
        further = turned | np.where(rising, now > best, now < best)
        best = np.where(further, now, best)
        at = np.where(further, k, at)
    found[count, j] = rows - 1
    length = int(count.max()) + 1
    order = np.arange(length)[:, None]
    return np.where(order <= count, found[:length], rows - 1)


def crossings(
    f: Function, found: Extrema, column: np.ndarray, level: np.ndarray, up: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the crossings at which columns rise (or fall) through levels (points,): x (sheets, points), the allowed
    end of two neighbouring doubles.

    The outermost comes first, NaN where there are fewer; bounded wells come before one that has no end. Also return a
    mask of the points that are allowed at the lower end of the range.
    """
    allowed = found.f[:, column] >= level
    here = (~allowed[:-1] & allowed[1:]) if up else (allowed[:-1] & ~allowed[1:])
    row, point = np.nonzero(here)
    root = _bisected(
        f,
        column[point],
        found.x[row, column[point]],
        found.x[row + 1, column[point]],
        np.full(row.size, up),
        level[point],
    )
    count = here.sum(axis=0)
    endless = allowed[-1] & (count > 1) & up
    # The outermost is number 0; a well without end goes behind the others.
    number = (count[point] - 1) - (np.cumsum(here, axis=0)[row, point] - 1)
    number = np.where(endless[point], (number - 1) % np.maximum(count[point], 1), number)
    sheets = np.full((max(1, int(count.max(initial=0))), column.size), np.nan)
    sheets[number, point] = root
    return sheets, allowed[0]


def _bisected(
    f: Function, column: np.ndarray, low: np.ndarray, high: np.ndarray, up: np.ndarray, level: np.ndarray
) -> np.ndarray:
    """Return the allowed one (f >= level) of the neighbouring doubles between which f crosses the level."""
    a = _ordered(low)
    b = _ordered(high)
    for _ in range(64):
        middle = (a >> 1) + (b >> 1) + (a & b & 1)
        upper = (evaluated(f, _double(middle), column)[0] >= level) == up
        a = np.where(upper, a, middle)
        b = np.where(upper, middle, b)
    return _double(np.where(up, b, a))


def _ordered(x: np.ndarray) -> np.ndarray:
    """Return whole numbers in the order of the doubles x, neighbours for neighbours."""
    bits = np.ascontiguousarray(x, dtype=np.float64).view(np.int64)
    return np.where(bits < 0, -(bits & np.int64(0x7FFFFFFFFFFFFFFF)), bits)


def _double(order: np.ndarray) -> np.ndarray:
    """Return the doubles of whole numbers made by `_ordered`."""
    size = np.abs(order).view(np.float64)
    return np.where(order < 0, -size, size)


def intervals(f: Function, nodes: np.ndarray) -> list[tuple[float, float]]:
    """Return the intervals of x where the single column f is positive, ascending; infinite or 0 where they reach the
    range's end.
    """
    found = extrema(f, 1, nodes)
    zero = np.zeros(1, np.int64)
    allowed = found.f[:, 0] > 0
    ends: list[float] = [] if not allowed[0] else [0.0 if nodes[0] > 0 else -np.inf]
    for k in np.flatnonzero(allowed[1:] != allowed[:-1]):
        up = bool(allowed[k + 1])
        ends.append(float(_bisected(f, zero, found.x[k], found.x[k + 1], np.array([up]), np.zeros(1))[0]))
    if allowed[-1]:
        ends.append(np.inf)
    return list(zip(ends[::2], ends[1::2], strict=True))
