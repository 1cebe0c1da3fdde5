"""Visits of running orbits to cells of the state space, and means of their states.

The records `out` have no rows of orbits: they hold the table of the cells, which all orbits share, `TABLE`. Numbers of
cells are whole floats below 2^52.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...engine.jit import LANES, jit

MASK = 2**52 - 1
"""Numbers of cells count modulo this, plus 1."""

FACTOR = 67
"""Factor of the number of a cell for each further row: more than the cells along a row."""


class Table(NamedTuple):
    """Rows of the table: low ends of the rows, inverse sizes, 0 for rows that do not count, and periods, 0 for none;
    for each set of cells the number of cells along a row, the first place of its cells and how many there are. From
    the row `sets` + the number of sets on, the cells of all sets follow one another, those of a set sorted.
    """

    low: int = 0
    inverse: int = 1
    period: int = 2
    sets: int = 3


TABLE = Table()


@jit
def cell_along(x, low, inverse, number):
    """Return the number of a cell along a row, from 1; 0 and number + 1 beyond the ends."""
    at = math.floor((x - low) * inverse * number) + 1.0
    return min(max(at, 0.0), number + 1.0)


@jit
def held(cells, key, first, length):
    """Return whether a cell is one of those of a set, by bisection."""
    begin = first
    end = first + length
    while begin < end:
        middle = (begin + end) // 2
        if cells[middle] < key:
            begin = middle + 1
        else:
            end = middle
    return begin < first + length and cells[begin] == key


@jit(inline=True)
def visits(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: count visits to each set in the first rows of memory; then add states, from the middle of the box, and
    their squares, of angles cosine and sine.
    """
    rows = int(value.rows)
    sets = int(value.sets)
    cells = out[TABLE.sets + sets]
    for s in range(sets):
        number = out[TABLE.sets + s, 0]
        first = int(out[TABLE.sets + s, 1])
        length = int(out[TABLE.sets + s, 2])
        for i in range(lanes):
            if fresh[i] > 0.0:
                key = 0
                for r in range(rows):
                    inverse = out[TABLE.inverse, r]
                    if inverse > 0.0:
                        x = z[r * LANES + i]
                        period = out[TABLE.period, r]
                        if period > 0.0:
                            x -= period * math.floor(x / period + 0.5)
                        key = (key * FACTOR + int(cell_along(x, out[TABLE.low, r], inverse, number))) & MASK
                if held(cells, float(key), first, length):
                    memory[s * LANES + i] += 1.0
    for r in range(rows):
        period = out[TABLE.period, r]
        middle = out[TABLE.low, r]
        if out[TABLE.inverse, r] > 0.0:
            middle += 0.5 / out[TABLE.inverse, r]
        for i in range(lanes):
            if fresh[i] > 0.0:
                x = z[r * LANES + i]
                if period > 0.0:
                    one = math.cos(2.0 * math.pi * x / period)
                    other = math.sin(2.0 * math.pi * x / period)
                else:
                    one = x - middle
                    other = one * one
                memory[(sets + 2 * r) * LANES + i] += one
                memory[(sets + 2 * r + 1) * LANES + i] += other
    return 0
