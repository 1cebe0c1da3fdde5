"""Turning points on the straight lines along the initial velocities of orbits, both ways: they give escape radii.

Distances along the lines are entries of a table, in units of an orbit's distance from the origin; the unit is 1 for an
orbit at the origin.
"""

from __future__ import annotations

import numpy as np

from ..jit import LANES, jit
from .stepping import aligned_zeros, load_lane

ROUNDS = 2
"""Number of divisions of a decade of the table."""

PARTS = 16
"""Parts of each division."""

FINE = PARTS**ROUNDS
"""Distances in the table to a decade."""

DECADES = -30, 30
"""Decades of the table: 10^-30 to 10^30."""

OWN = -2, 20
"""Decades of the search if the unit is an orbit's distance from the origin."""


@jit
def below(of, rows, lanes, start, along, way, number, limit, far, place, least):
    """Set least to 1 in lanes whose least energy at the numbered distance is at most the limit, else to 0.

    of: the model's parameters and potential, the centrifugal coefficient of x^2 + y^2 that a rotating frame subtracts
    from the least energy, and the distances.
    """
    params, potential, centrifugal, distances = of
    for i in range(lanes):
        far[i] = way * distances[min(max(number[i], 0), distances.size - 1)]
    for r in range(rows):
        for i in range(lanes):
            place[r * LANES + i] = start[r * LANES + i] + far[i] * along[r * LANES + i]
    potential(params, lanes, place, least)
    for i in range(lanes):
        if centrifugal != 0.0:
            least[i] -= centrifugal * (place[i] * place[i] + place[LANES + i] * place[LANES + i])
        least[i] = 1.0 if least[i] <= limit[i] else 0.0


def find_turns(u, params, potential, centrifugal, distances, z, along, begin, looks, limit, turn):
    """Set turn (2, orbits) of block u to the number of the distance, either way along the line, where the potential
    energy rises through the limit for the last time; without such a distance it keeps its value.

    The search goes by decades, `looks` (orbits,) of them from `begin` on; the last one found is bisected down to one
    distance of the table. Only orbits at rest start uphill at once. z (n, orbits) are positions, along (n, orbits)
    lines in units of theirs.
    """
    of = params, potential, centrifugal, distances
    rows, orbits = z.shape
    first = u * LANES
    lanes = min(LANES, orbits - first)
    start = aligned_zeros(rows)
    line = aligned_zeros(rows)
    place = aligned_zeros(rows)
    least = aligned_zeros(1)
    bound = aligned_zeros(1)
    far = aligned_zeros(1)
    inside = np.zeros(LANES, np.int64)
    number = np.zeros(LANES, np.int64)
    most = 0
    begun = begin[first : first + lanes]
    wanted = looks[first : first + lanes]
    for i in range(lanes):
        load_lane(z, first + i, start, i)
        load_lane(along, first + i, line, i)
        bound[i] = limit[first + i]
        most = max(most, wanted[i])
    for side in range(2):
        way = 1.0 - 2.0 * side
        last = turn[side, first : first + lanes]
        for i in range(lanes):
            inside[i] = 0
        for k in range(most):
            for i in range(lanes):
                number[i] = begun[i] + FINE * k
            below(of, rows, lanes, start, line, way, number, bound, far, place, least)
            for i in range(lanes):
                now = 1 if least[i] > 0.0 else 0
                last[i] = number[i] - FINE if (k < wanted[i]) & (inside[i] > now) else last[i]
                inside[i] = now if k < wanted[i] else inside[i]
        half = FINE // 2
        while half > 0:
            for i in range(lanes):
                number[i] = last[i] + half
            below(of, rows, lanes, start, line, way, number, bound, far, place, least)
            for i in range(lanes):
                last[i] += half if last[i] >= 0 and least[i] > 0.0 else 0
            half //= 2
