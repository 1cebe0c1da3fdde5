"""Passages of a coordinate through equidistant levels, recorded for location."""

from __future__ import annotations

from ..compile.jit import LANES, jit
from .crossings import CERTAIN, RECORD

MEMORY = 2
"""Rows of observer memory before the state: levels passed; time of the step before."""


@jit(constants=True)
def pass_levels(row, count, rows, lanes, orbit, fresh, t, z, memory, out, done):
    """Record the brackets in which row `row` of z rises through 1/count, 2/count ... 1; memory (MEMORY + rows)*LANES.

    A record's row is counted from its level, so that all are crossings of zero. A lane is done when it passes 1.
    Returns how many became done.
    """
    width = RECORD + rows
    ended = 0
    for i in range(lanes):
        if fresh[i] == 0.0:
            continue
        o, passed, before = orbit[i], int(memory[i]), memory[LANES + i]
        while passed < count and z[row * LANES + i] * count >= passed + 1:
            c = passed * width
            out[o, c], out[o, c + 1], out[o, c + 2], out[o, c + 3] = before, CERTAIN, 0.0, t[i] - before
            for r in range(rows):
                out[o, c + RECORD + r] = memory[(MEMORY + r) * LANES + i]
            passed += 1
            out[o, c + RECORD + row] -= passed / count
        memory[i], memory[LANES + i] = passed, t[i]
        for r in range(rows):
            memory[(MEMORY + r) * LANES + i] = z[r * LANES + i]
        if passed == count:
            done[i] = 1.0
            ended += 1
    return ended


@jit(constants=True)
def stop_beyond(row, limit, lanes, fresh, z, done):
    """Mark the lanes whose row `row` has reached `limit` as done; return how many became so."""
    ended = 0
    for i in range(lanes):
        if fresh[i] > 0.0 and done[i] == 0.0 and z[row * LANES + i] >= limit:
            done[i] = 1.0
            ended += 1
    return ended
