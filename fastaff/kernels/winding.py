"""Weighted means of what the angles of a map wind on in an iterate, along running orbits."""

from __future__ import annotations

import numpy as np

from ..compile.jit import LANES, jit
from ..compile.pointers import call_value
from .birkhoff import weight


@jit(inline=True)
def wind(value, calls, rows, spans, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: add what each of the rows that wind moves in the next iterate, which the call gives, to its weighted
    sums over the spans of value.time; row r and span s are row r*spans + s of the memory.

    value.begin and value.length (spans,) are parts of the time. All lanes have the same number of iterates.
    """
    along = np.empty(rows * LANES)
    call_value(calls, 0, lanes, z, along)
    place = (t[0] - 0.5) / value.time
    for s in range(spans):
        x = 2.0 * (place - value.begin[s]) / value.length[s] - 1.0
        if x > -1.0 and x < 1.0:
            w = weight(x)
            for r in range(rows):
                row, moved = (r * spans + s) * LANES, r * LANES
                for i in range(lanes):
                    memory[row + i] += w * along[moved + i]
    return 0
