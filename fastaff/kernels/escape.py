"""Where orbits would turn along the straight lines that they start along, both ways: escape radii follow from that.

Lines i and orbits + i are those of orbit i, forwards and backwards. Distances along them are numbers of a table, in
units of an orbit's distance from the origin; of one at the origin, 1.
"""

from __future__ import annotations

import numpy as np

from ..compile.jit import jit

ROUNDS, PARTS = 2, 16
"""How often a decade of the table is divided, and in how many parts."""

FINE = PARTS**ROUNDS
"""Distances in the table to a decade."""

DECADES = -30, 30
"""Of the table: 10^-30 to 10^30."""

OWN = -2, 20
"""Decades that are looked at where the unit is an orbit's distance from the origin."""


@jit
def length(z, i):
    """Return the root of the sum of squares of column i."""
    square = 0.0
    for r in range(z.shape[0]):
        square += z[r, i] * z[r, i]
    return np.sqrt(square)


@jit
def unit_of(z, i):
    """Return the unit of distances of orbit i, from z (n, orbits)."""
    size = length(z, i)
    return size if size > 0.0 else 1.0


@jit
def aim(z, slopes, along, first, looks):
    """Set along (n, lines) to the units of the lines from z (n, orbits), first to their first distances.

    A line goes along the velocity, or the force of an orbit that rests; slopes (2n, orbits) has both. looks (lines,):
    how many decades are looked at.
    """
    n, orbits = z.shape
    for i in range(orbits):
        own, largest = n, 0.0
        for r in range(n):
            own = 0 if slopes[r, i] != 0.0 else own
        for r in range(n):
            part = abs(slopes[own + r, i])
            largest = largest if part <= largest else part
        for r in range(n):
            along[r, i] = slopes[own + r, i] / largest  # lengths of huge velocities have no square
        speed, scale = length(along, i), unit_of(z, i)
        for r in range(n):
            part = along[r, i] / speed
            along[r, i] = part * scale if np.isfinite(part) else 0.0
            along[r, orbits + i] = -along[r, i]
        lowest, highest = OWN if length(z, i) > 0.0 else DECADES
        for line in (i, orbits + i):
            first[line], looks[line] = FINE * (lowest - DECADES[0]), highest - lowest + 1


@jit
def place(z, along, distances, first, spacing, points):
    """Set points (n, looks, lines) to those on the lines at their first distances and at every so many after them."""
    n, looks, lines = points.shape
    for r in range(n):
        for k in range(looks):
            for i in range(lines):
                number = min(max(first[i] + k * spacing, 0), distances.size - 1)
                points[r, k, i] = z[r, i % z.shape[1]] + distances[number] * along[r, i]


@jit
def last_turn(potential, limit, first, looks):
    """Set first (lines,) to the number of the last decade in which the potential energy rises through the limit, or -1.

    potential (decades, lines): at the beginnings of decades; limit (orbits,). A line that leads uphill at once is that
    of an orbit that rests.
    """
    for i in range(first.size):
        inside, turn = False, -1
        for k in range(looks[i]):
            now = potential[k, i] <= limit[i % limit.size]
            if inside and not now:
                turn = first[i] + FINE * (k - 1)
            inside = now
        first[i] = turn


@jit
def halve(potential, limit, spacing, first):
    """Move first (lines,) to the last distance below a rise of the potential energy (PARTS, lines) through the limit.

    The energies are those at `first` and at every so many distances after it; the range is halved down to one of them.
    """
    for i in range(first.size):
        part, half = 0, PARTS // 2
        while half > 0:
            part += half if potential[part + half, i] <= limit[i % limit.size] else 0
            half //= 2
        first[i] += part * spacing if first[i] >= 0 else 0


@jit
def reaches(z, distances, turn, reach):
    """Set reach (orbits,) to the distance from the origin, or to that of the farther turn, a number or -1 (lines,)."""
    orbits = reach.size
    for i in range(orbits):
        reach[i] = length(z, i)
        for line in (i, orbits + i):
            if turn[line] >= 0:
                reach[i] = max(reach[i], unit_of(z, i) * distances[turn[line]])
