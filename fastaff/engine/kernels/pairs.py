"""Two observers of one pass, called by their pointers."""

from __future__ import annotations

from typing import NamedTuple

from ..jit import LANES, jit
from ..pointers import call_observer
from .stepping import row


class PairRows(NamedTuple):
    """Rows of observer memory after those of the two observers that `both` calls: which of them is done with an orbit,
    and room for the lanes that an observer still sees.
    """

    first_done: int = 0
    second_done: int = 1
    seen: int = 2
    end: int = 3


ROWS = PairRows()


@jit(inline=True)
def both(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: call two; an orbit is done when both are done with it, and neither sees it after it is done with it.

    The first value.split rows of memory and value.columns columns of `out` are the first one's.
    """
    split = int(value.split) * LANES
    end = int(value.rows) * LANES
    columns = int(value.columns)
    own = memory[end:]
    seen = row(own, ROWS.seen)
    first_done = row(own, ROWS.first_done)
    second_done = row(own, ROWS.second_done)
    for i in range(lanes):
        seen[i] = fresh[i] * (1.0 - first_done[i])
    call_observer(calls, 0, lanes, orbit, seen, t, z, memory[:split], out[:, :columns], first_done)
    for i in range(lanes):
        seen[i] = fresh[i] * (1.0 - second_done[i])
    call_observer(calls, 1, lanes, orbit, seen, t, z, memory[split:end], out[:, columns:], second_done)
    ended = 0
    for i in range(lanes):
        if first_done[i] > 0.0 and second_done[i] > 0.0:
            done[i] = 1.0
            ended += 1
    return ended


@jit(inline=True)
def either(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: call two; an orbit is done when one of them is done with it.

    The first value.split rows of memory are the first one's, and all columns of `out`.
    """
    split = int(value.split) * LANES
    columns = out.shape[1]
    ended = call_observer(calls, 0, lanes, orbit, fresh, t, z, memory[:split], out, done)
    return ended + call_observer(calls, 1, lanes, orbit, fresh, t, z, memory[split:], out[:, columns:], done)
