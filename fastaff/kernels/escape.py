"""Where orbits would turn along the straight lines that they start along, both ways: escape radii follow from that.

Distances along the lines are numbers of a table, in units of an orbit's distance from the origin; of one at the origin,
1.
"""

from __future__ import annotations

import numpy as np

from ..compile.jit import LANES, jit
from .stepping import load_lane, room

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
def aim(z, slopes, o, i, along):
    """Set lane i of along to the unit of the line from column o of z (n, orbits): along the velocity, or the force of
    an orbit that rests; slopes (2n, orbits) has both.
    """
    n = slopes.shape[0] // 2
    own, largest = n, 0.0
    for r in range(n):
        own = 0 if slopes[r, o] != 0.0 else own
    for r in range(n):
        part = abs(slopes[own + r, o])
        largest = largest if part <= largest else part
    speed = 0.0
    for r in range(n):
        along[r * LANES + i] = slopes[own + r, o] / largest  # lengths of huge velocities have no square
        speed += along[r * LANES + i] ** 2
    speed, scale = np.sqrt(speed), unit_of(z, o)
    for r in range(n):
        part = along[r * LANES + i] / speed
        along[r * LANES + i] = part * scale if np.isfinite(part) else 0.0


@jit
def below(of, rows, lanes, start, along, way, number, limit, place, least):
    """Set least to 1 in lanes whose least energy at that number of a distance is at most the limit, else to 0.

    of: the model's parameters and potential, what the least energy is less in a turning frame, in units of x^2 + y^2,
    and the distances.
    """
    params, potential, centrifugal, distances = of
    for r in range(rows):
        for i in range(lanes):
            k = min(max(number[i], 0), distances.size - 1)
            place[r * LANES + i] = start[r * LANES + i] + distances[k] * (way * along[r * LANES + i])
    potential(params, lanes, place, least)
    for i in range(lanes):
        if centrifugal != 0.0:
            least[i] -= centrifugal * (place[i] * place[i] + place[LANES + i] * place[LANES + i])
        least[i] = 1.0 if least[i] <= limit[i] else 0.0


def find_reaches(u, params, potential, centrifugal, distances, moving, z, slopes, limit, reach, turned):
    """Set reach (orbits,) of block u to the distance from the origin, or to that of the farther turn, and turned to
    whether there is one.

    A turn is the last decade in which the potential energy rises through the limit, to two digits: the range is halved
    down to one distance of the table. A line that leads uphill at once is that of an orbit that rests. z (n, orbits)
    are places, of which the distance is that of the first `moving` rows.
    """
    of = params, potential, centrifugal, distances
    rows, orbits = z.shape
    first = u * LANES
    lanes = min(LANES, orbits - first)
    start, along, place, least, bound = room(rows), room(rows), room(rows), room(1), room(1)
    begin, looks, turn = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    inside, number, most = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64), 0
    for i in range(lanes):
        o = first + i
        load_lane(z, o, start, i)
        aim(z[:moving], slopes, o, i, along)
        bound[i], reach[o] = limit[o], length(z[:moving], o)
        lowest, highest = OWN if reach[o] > 0.0 else DECADES
        begin[i], looks[i] = FINE * (lowest - DECADES[0]), highest - lowest + 1
        most = max(most, looks[i])
    for way in (1.0, -1.0):
        for i in range(lanes):
            inside[i], turn[i] = 0, -1
        for k in range(most):
            for i in range(lanes):
                number[i] = begin[i] + FINE * k
            below(of, rows, lanes, start, along, way, number, bound, place, least)
            for i in range(lanes):
                now = 1 if least[i] > 0.0 else 0
                if k < looks[i]:
                    turn[i] = begin[i] + FINE * (k - 1) if inside[i] > now else turn[i]
                    inside[i] = now
        half = FINE // 2
        while half > 0:
            for i in range(lanes):
                number[i] = turn[i] + half
            below(of, rows, lanes, start, along, way, number, bound, place, least)
            for i in range(lanes):
                turn[i] += half if turn[i] >= 0 and least[i] > 0.0 else 0
            half //= 2
        for i in range(lanes):
            if turn[i] >= 0:
                turned[first + i] = True
                reach[first + i] = max(reach[first + i], unit_of(z[:moving], first + i) * distances[turn[i]])
