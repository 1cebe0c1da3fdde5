"""Bases enlarged until two in succession agree, and the error of the last one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .panels import ORDER, chebyshev
from .singular_ends import sampled

LARGEST = 1200
"""Functions of the largest basis in one dimension."""
FLOOR = 3e-14
"""Relative rounding of eigenvalues."""
POWERS = np.geomspace(0.1, 40.0, 200)
"""Powers of the size of a basis that errors are taken to fall by."""
ROUGH = 3.0
"""The highest of them where V is not smooth at an end, the lowest where it is."""
NOISE = 1e-6
"""Part of a change below which the sign of the next one means nothing."""
SAFE = 2.0
"""Error in units of the remainder of such a power."""


def until_equal(solve, n, hi, grow, count, tolerance, powers):
    """Enlarge basis and interval until the values of two in succession agree, twofold while they are far apart.

    Return basis, values and vectors, errors, size. A smaller basis goes before and shows how fast changes fall.
    """
    sizes = [max(int((n - 12) / 1.25), count + 2)]
    change = None
    far = False
    _, (coarse, _) = solve(sizes[0], hi / grow)
    while True:
        sizes.append(2 * sizes[-1] if far else sizes[-1] + sizes[-1] // 4 + 12)
        b, (values, vectors) = solve(sizes[-1], hi)
        gap = values[:, :count] - coarse[:, :count]
        scale = np.maximum(np.abs(values[:, :count]), np.abs(np.diff(values[:, : count + 1])))
        if change is not None:
            error = _left(sizes[-3:], change, gap, FLOOR * scale, powers)
            if np.all(error <= max(0.1 * tolerance, FLOOR) * scale) or sizes[-1] > LARGEST:
                rounding = 8 * np.finfo(float).eps * np.abs(values[:, :count]).max(axis=1, keepdims=True)
                return b, (values, vectors), error + rounding, sizes[-1]
            far = bool(np.any(np.abs(gap) > 1e-4 * scale))
        coarse = values
        change = gap
        hi = hi * grow


def _left(sizes: list[int], change: np.ndarray, gap: np.ndarray, floor: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Return the remaining error after two changes between bases of three sizes.

    It is twice the last change, and twice the following ones if errors fall as a power of the size, as at singular ends
    whose functions no exponent makes smooth. Changes of different signs, of the basis and of its quadrature, show no
    power: the error is the larger one.
    """
    size = np.abs(change)
    last = np.abs(gap)
    if powers[-1] < POWERS[-1]:  # errors of the basis and of its quadrature may cancel
        size = by_chance(size)
        last = by_chance(last)
    error = 2 * last + SAFE * _remaining(sizes, size - floor, last - floor, powers)
    turned = (change * gap < 0) & (last > np.maximum(floor, NOISE * size))
    return np.where(turned, np.maximum(error, size), error)


def by_chance(gap: np.ndarray) -> np.ndarray:
    """Return the changes (..., levels), no less than those of neighbours: two bases may agree on a level by chance."""
    wide = np.pad(gap, [(0, 0)] * (gap.ndim - 1) + [(1, 1)])
    nearby = np.maximum(np.maximum(wide[..., :-2], wide[..., 2:]), gap)
    return np.maximum(nearby, 0.1 * np.maximum.accumulate(gap, axis=-1))


def _remaining(sizes: list[int], change: np.ndarray, gap: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Return the error of the last of three bases if errors fall as one of some powers of their size."""
    errors = [(size / sizes[-1]) ** -powers for size in sizes]
    drop = errors[0] - errors[1]
    last = errors[1] - errors[2]
    change = np.maximum(change, 1e-300)
    return change * np.interp(np.maximum(gap, 0) / change, (last / drop)[::-1], (1 / drop)[::-1])


def near_end(U: Callable, place: float, step: float, power: float) -> Callable:
    """Return d^2 U as a function of t, d = step t^power its distance from an end."""
    return lambda t: (step * t**power) ** 2 * U(place + step * t**power)


def powers_of(*ends: Callable) -> np.ndarray:
    """Return the powers by which errors may fall where V has such ends: functions of t in (0, 1), smooth or not."""
    nodes, matrix = chebyshev(2 * ORDER)
    between = (np.arange(2 * ORDER) + 0.5) / (2 * ORDER)
    for end in ends:
        inner = sampled(end, nodes)
        seen = sampled(end, between)
        if not np.abs(matrix @ inner - seen).max() <= 1e-9 * np.abs(seen).max():
            return POWERS[POWERS <= ROUGH]
    return POWERS[POWERS > ROUGH]
