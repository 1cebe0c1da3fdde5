"""Narrow features of potentials of one variable: samples against their own interpolant.

Turning points are sought in steps, and quadratures start from few nodes: both miss a narrower barrier. So every
function is sampled once, finely. Where its samples differ from the prediction by neighbours further off, the extrema
and inflections are its knots; turning points are sought at knots too, and quadratures are cut there.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..systems.models.regular_variables import in_regular_variable

OCTAVES = 40
"""Range of s = 2^-40 ... 2^40 that is sampled, in factors of 2 on either side of 1."""

PER_OCTAVE = 8192
"""Samples in a factor of 2: features of a relative width of 1e-4 are found."""

AROUND = 32768
"""Samples of an angle."""

STRIDE = 4
"""Distance, in samples, of those that predict one: a feature is narrow where four of them, 2 strides apart, miss it."""

MISSED = 1e-9
"""Largest misfit, relative to the largest value nearby."""

NOISE = 1e-12
"""Least difference that counts, relative to the largest value nearby."""

NEARBY = 512
"""Samples whose largest value others are judged by."""

APART = 64
"""Samples between which two features are two."""

MOST = 512
"""Knots of one function at most."""


def knots(function: Any, variable: Any) -> np.ndarray:
    """Return the knots of a potential of one variable, increasing; none where it is smooth.

    They are values of the coordinate's regular variable s (see `systems.models.regular_variables`), or, where that
    is bounded, of the ratio s/(1 - s).
    """
    V = in_regular_variable(function, variable)
    return _knots(_types(V), V, variable.bounded)


def knots_around(function: Any) -> np.ndarray:
    """Return the knots of a potential of an angle, in three turns, increasing."""
    return _knots_around(_types(function), function)


def _types(function: Any) -> tuple[Any, ...]:
    """Return the types of a function and of its parts: equal tuples may be different functions."""
    parts = function if isinstance(function, tuple) else ()
    return type(function), *(_types(part) for part in parts)


@functools.lru_cache(maxsize=256)
def _knots(_: tuple[Any, ...], V: Any, bounded: bool) -> np.ndarray:
    if bounded:
        half = (np.arange(AROUND) + 0.5) * np.pi / 2 / AROUND
        return np.tan(half[_found(_values(V, np.sin(half) ** 2))]) ** 2
    s = 2.0 ** (np.arange(-OCTAVES * PER_OCTAVE, OCTAVES * PER_OCTAVE + 1) / PER_OCTAVE)
    return s[_found(_values(V, s))]


@functools.lru_cache(maxsize=256)
def _knots_around(_: tuple[Any, ...], V: Any) -> np.ndarray:
    x = (np.arange(AROUND) + 0.5) * 2 * np.pi / AROUND - np.pi
    at = _found(_values(V, x), periodic=True)
    return np.sort(np.concatenate([x[at] + turn for turn in (-2 * np.pi, 0.0, 2 * np.pi)]))


def _values(V: Any, x: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.asarray(V.value(x), dtype=np.float64) + 0.0 * x


def _found(V: np.ndarray, periodic: bool = False) -> np.ndarray:
    """Return the numbers of the samples at extrema and inflections inside of narrow features, and of those inside of
    narrow walls.
    """
    reach = 3 * STRIDE
    if periodic:
        V = np.concatenate([V[-reach:], V, V[:reach]])
    with np.errstate(all="ignore"):
        near = V[2 * STRIDE : -4 * STRIDE] + V[4 * STRIDE : -2 * STRIDE]
        far = V[: -6 * STRIDE] + V[6 * STRIDE :]
        size = _largest_nearby(V)[reach:-reach]
        inner = V[reach:-reach]
        narrow = np.abs((9 * near - far) / 16 - inner) > MISSED * size
        slope = np.diff(V)
        bend = np.diff(V, 2)
        marks = np.zeros(V.size, bool)
        for difference in (slope, bend):
            sure = np.flatnonzero(np.abs(difference) > NOISE * _largest_nearby(V)[: difference.size])
            turns = np.flatnonzero(np.diff(np.sign(difference[sure])) != 0)
            marks[(sure[turns] + sure[turns + 1] + 2) // 2] = True
    marks = marks[reach:-reach] & narrow
    start = 0 if periodic else reach
    missed = np.flatnonzero(narrow)
    feature = np.cumsum(np.diff(missed, prepend=missed[:1]) > APART)  # a number for each, of all of its samples
    has = np.zeros(missed.size + 1, bool)
    has[feature[marks[missed]]] = True
    edge = np.diff(feature, prepend=-1) + np.diff(feature, append=missed.size) > 0  # where features begin and end
    found = np.union1d(np.flatnonzero(marks), missed[edge & has[feature]]) + start
    walls = np.flatnonzero(~np.isfinite(inner))
    if walls.size:  # a wall between two places where it is finite
        edges = np.flatnonzero(np.diff(np.isfinite(inner).astype(np.int8)))
        if edges.size >= 2:
            begin = edges[:-1] + 1
            end = edges[1:]
            inside = ~np.isfinite(inner[begin])
            found = np.union1d(
                found, np.concatenate([begin[inside], (begin[inside] + end[inside]) // 2, end[inside]]) + start
            )
    return found[:: max(1, -(-found.size // MOST))]


def _largest_nearby(V: np.ndarray) -> np.ndarray:
    """Return the largest finite |V| within about NEARBY samples."""
    size = np.where(np.isfinite(V), np.abs(V), 0.0)
    blocks = np.append(size, np.zeros(-size.size % NEARBY)).reshape(-1, NEARBY).max(axis=1)
    around = np.maximum(blocks, np.maximum(np.append(blocks[1:], 0.0), np.append(0.0, blocks[:-1])))
    return np.repeat(around, NEARBY)[: V.size]
