"""Samples of running orbits."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..compile.jit import LANES, jit
from ..compile.pointers import call_value
from .stepping import row


class Rows(NamedTuple):
    """Rows of observer memory: samples taken; where only every stride-th observation is one, also the value now,
    observations seen, the stride, and whether this one is a sample.
    """

    taken: int = 0
    value: int = 1
    seen: int = 2
    stride: int = 3
    due: int = 4
    end: int = 5


ROWS = Rows()


@jit(constants=True)
def sample(rows, lanes, orbit, fresh, block, taken, out):
    """Write the rows of block as the next sample of each fresh orbit; taken (LANES,) counts the samples."""
    for i in range(lanes):
        first = int(taken[i]) * rows
        if fresh[i] > 0.0 and first + rows <= out.shape[1]:
            for r in range(rows):
                out[orbit[i], first + r] = block[r * LANES + i]
            taken[i] += 1.0


@jit(inline=True)
def states(value, rows, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: write each state as a sample."""
    sample(rows, lanes, orbit, fresh, z, row(memory, ROWS.taken), out)
    return 0


@jit(inline=True)
def thinned(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: write what the call gives at every n-th observation of an orbit, n in its row `stride`."""
    call_value(calls, 0, lanes, z, row(memory, ROWS.value))
    for i in range(lanes):
        seen, stride = memory[ROWS.seen * LANES + i] + fresh[i], memory[ROWS.stride * LANES + i]
        memory[ROWS.seen * LANES + i] = seen
        memory[ROWS.due * LANES + i] = fresh[i] if seen - stride * math.floor(seen / stride) == 0.0 else 0.0
    sample(1, lanes, orbit, row(memory, ROWS.due), row(memory, ROWS.value), row(memory, ROWS.taken), out)
    return 0


@jit(inline=True)
def nothing(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: keep nothing."""
    return 0
