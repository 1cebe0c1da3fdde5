"""Passages of a coordinate through given levels, recorded for location, and its end."""

from __future__ import annotations

from typing import NamedTuple

from ..jit import LANES, jit
from .crossings import CERTAIN, RECORD


class TimeLevelRows(NamedTuple):
    """Rows of observer memory: levels passed; time of the step before; the first one of the state then."""

    passed: int = 0
    before: int = 1
    state: int = 2


ROWS = TimeLevelRows()


@jit(inline=True)
def pass_levels(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: record the brackets in which row value.row of z rises through value.levels levels.

    The time of a record is its level before it is written. memory (ROWS.state + rows)*LANES. A record's row is counted
    from its level, so that all are crossings of zero. A lane is done when it passes the last level. Returns the number
    of lanes that became done.
    """
    row = int(value.row)
    rows = int(value.rows)
    count = int(value.levels)
    width = RECORD.state + rows
    ended = 0
    for i in range(lanes):
        if fresh[i] == 0.0:
            continue
        o = orbit[i]
        passed = int(memory[ROWS.passed * LANES + i])
        before = memory[ROWS.before * LANES + i]
        while passed < count and z[row * LANES + i] >= out[o, passed * width + RECORD.time]:
            c = passed * width
            level = out[o, c + RECORD.time]
            out[o, c + RECORD.time] = before
            out[o, c + RECORD.kind] = CERTAIN
            for r in range(rows):
                out[o, c + RECORD.state + r] = memory[(ROWS.state + r) * LANES + i]
            passed += 1
            out[o, c + RECORD.state + row] -= level
            out[o, c + RECORD.beyond] = z[row * LANES + i] - level
            out[o, c + RECORD.upper] = t[i] - before
        memory[ROWS.passed * LANES + i] = passed
        memory[ROWS.before * LANES + i] = t[i]
        for r in range(rows):
            memory[(ROWS.state + r) * LANES + i] = z[r * LANES + i]
        if passed == count:
            done[i] = 1.0
            ended += 1
    return ended


@jit(inline=True)
def stop_beyond(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: mark the lanes whose row value.row has reached value.limit as done; return the number of new ones."""
    ended = 0
    first = int(value.row) * LANES
    for i in range(lanes):
        if fresh[i] > 0.0 and done[i] == 0.0 and z[first + i] >= value.limit:
            done[i] = 1.0
            ended += 1
    return ended
