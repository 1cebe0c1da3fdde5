"""Orbits that enter the neighbourhood of an attractor from which no orbit leaves.

Such a neighbourhood is a tube of some radius about segments; those of a fixed point have no length. The records `out`
have rows for the table of the segments after those of the orbits: all orbits share it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...engine.jit import LANES, jit
from ...engine.kernels.stepping import row


class TrapRows(NamedTuple):
    """Rows of observer memory, for the segment at hand: the square of the distance from its begin, and the product of
    this way with the segment.
    """

    square: int = 0
    along: int = 1
    end: int = 2


ROWS = TrapRows()


class TrapRecord(NamedTuple):
    """Columns of an orbit's record: the number of its attractor from 1, 0 for none, and the time of its entry."""

    attractor: int = 0
    time: int = 1
    end: int = 2


RECORD = TrapRecord()


class SegmentRecord(NamedTuple):
    """Columns of a segment: number of its attractor from 1, square of the radius, square of the length and its inverse,
    or 0; the begin, and then the way to the end in units of the rows.

    Of the row before the first segment, the places of the begin hold inverse units of the rows, 0 for rows that do not
    count, the places after them the periods, 0 for none.
    """

    attractor: int = 0
    radius: int = 1
    size: int = 2
    inverse: int = 3
    begin: int = 4


SEGMENT = SegmentRecord()


@jit(inline=True)
def trapped(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: end orbits within a tube; write the attractor's number and the time."""
    rows = int(value.rows)
    first = int(value.orbits)
    square = row(memory, ROWS.square)
    along = row(memory, ROWS.along)
    found = 0
    for s in range(first + 1, first + 1 + int(value.segments)):
        for i in range(lanes):
            square[i] = 0.0
            along[i] = 0.0
        for r in range(rows):
            weight = out[first, SEGMENT.begin + r]
            period = out[first, SEGMENT.begin + rows + r]
            begin = out[s, SEGMENT.begin + r]
            way = out[s, SEGMENT.begin + rows + r]
            if weight > 0.0:
                inverse = 1.0 / period if period > 0.0 else 0.0
                for i in range(lanes):
                    away = z[r * LANES + i] - begin
                    away = weight * (away - period * np.floor(away * inverse + 0.5))
                    square[i] += away * away
                    along[i] += away * way
        size = out[s, SEGMENT.size]
        share = out[s, SEGMENT.inverse]
        radius = out[s, SEGMENT.radius]
        for i in range(lanes):
            part = min(max(along[i] * share, 0.0), 1.0)
            nearest = square[i] - part * (2.0 * along[i] - part * size)
            if nearest < radius and fresh[i] > 0.0 and done[i] == 0.0:
                out[orbit[i], RECORD.attractor] = out[s, SEGMENT.attractor]
                out[orbit[i], RECORD.time] = t[i]
                done[i] = 1.0
                found += 1
    return found
