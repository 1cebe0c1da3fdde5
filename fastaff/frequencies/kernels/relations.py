"""Kernels of relations: frequencies as combinations of others, and combinations of frequencies that are 0."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import read_now
from .fundamental import relate


class RelationLimits(NamedTuple):
    """Limits of combinations that may be 0, see `vanishing`."""

    resolved: float
    short: float
    chance: float
    curved: float
    hidden: float


def first_vectors(unit, stop, progress, value, bar, nu, spread, vectors, k, found):
    """Fill k (orbits, m, m) with the first of the vectors such that value = k @ nu (orbits, m) within the errors, and
    found (orbits, m) with whether there is one; vectors (m + 1, count), see `fundamental.relate`.
    """
    if read_now(stop, 0) == 0:
        m = nu.shape[1]
        for j in range(m):
            found[unit, j] = relate(
                value[unit, j],
                bar[unit, j],
                nu[unit],
                spread[unit],
                m,
                vectors,
                vectors.shape[1],
                math.inf,
                k[unit, j],
            )
        progress[unit] = 1.0


def vanishing(unit, stop, progress, nu, error, beat, time, k, limits, distance):
    """Fill distance (orbits, m) with the largest |k . nu| of combinations with k_j != 0 that may be 0, -1 for none: of
    k (m + 1, vectors), with the lengths |k|_1 in its last row, in ascending order.

    A combination may be 0 within its error. Within `resolved` cycles over the time (orbits,) it may also be 0 if |k|_1
    is at most `short`, or so small a combination among as many is expected by chance less than `chance` times; unless
    its error is below `curved` times the cube of its cycles, and the beats of its frequencies, `beat` (orbits, m), are
    below `hidden` times its cycles. Combinations with unknown frequencies, NaN, do not count. See `RelationLimits`.
    """
    if read_now(stop, 0) > 0:
        return
    m = nu.shape[1]
    lengths = k[k.shape[0] - 1]
    some = 0
    fastest = 0.0
    sums = np.zeros(k.shape[1])
    widths = np.zeros(k.shape[1])
    beats = np.zeros(k.shape[1])
    possible = np.zeros(k.shape[1])
    for j in range(m):
        row = k[j]
        one = nu[unit, j]
        width = error[unit, j]
        beating = beat[unit, j]
        fastest = max(fastest, abs(one)) if one == one else fastest
        for v in range(row.size):
            sums[v] += row[v] * one if row[v] != 0.0 else 0.0
            widths[v] += abs(row[v]) * width if row[v] != 0.0 else 0.0
            beats[v] = max(beats[v], beating) if row[v] != 0.0 else beats[v]
    for v in range(sums.size):
        near = limits.resolved / time[unit] if lengths[v] <= limits.short else 0.0
        chance = min(0.5 * limits.chance * fastest * lengths[v] / (v + 1), limits.resolved / time[unit])
        cycles = abs(sums[v]) * time[unit]
        unclear = widths[v] * time[unit] >= limits.curved * cycles * cycles * cycles
        unclear = unclear or beats[v] * time[unit] >= limits.hidden * cycles
        possible[v] = 1.0 if abs(sums[v]) <= widths[v] or (unclear and abs(sums[v]) <= max(near, chance)) else 0.0
        some += 1 if possible[v] != 0.0 else 0
    for j in range(m):
        distance[unit, j] = -1.0
        row = k[j]
        for v in range(sums.size if some > 0 else 0):
            if possible[v] != 0.0 and row[v] != 0.0:
                distance[unit, j] = max(distance[unit, j], abs(sums[v]))
    progress[unit] = 1.0
