"""Samples of running orbits at given times: the first state at or after each of them."""

from __future__ import annotations

from typing import NamedTuple

from ..jit import LANES, jit
from .stepping import row

ROUNDING = 4.5e-16
"""Relative difference up to which a time is that of a sample: a number of steps times their size is rounded twice."""


class SampleTimeRows(NamedTuple):
    """Rows of observer memory: samples taken; the time of the next one.

    The caller sets the latter. `out` holds a record for each sample: its time, which the time of the state replaces,
    and the state.
    """

    taken: int = 0
    following: int = 1
    end: int = 2


ROWS = SampleTimeRows()


@jit
def write_state(rows, i, o, now, z, taken, memory, out):
    """Write the state in lane i at the time now as every sample of orbit o up to then; set the next one in lane
    `taken` of memory.
    """
    width = rows + 1
    first = int(memory[ROWS.taken * LANES + taken]) * width
    following = memory[ROWS.following * LANES + taken]
    while first < out.shape[1] and now * (1.0 + ROUNDING) >= following:
        out[o, first] = now
        for r in range(rows):
            out[o, first + 1 + r] = z[r * LANES + i]
        first += width
        if first < out.shape[1]:
            following = out[o, first]
    memory[ROWS.taken * LANES + taken] = first // width
    memory[ROWS.following * LANES + taken] = following


@jit(inline=True)
def pass_times(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: write the first state at or after the time of each sample."""
    rows = int(value.rows)
    following = row(memory, ROWS.following)
    due = 0
    for i in range(lanes):
        due += 1 if t[i] * (1.0 + ROUNDING) >= following[i] else 0
    if due > 0:
        for i in range(lanes):
            if fresh[i] > 0.0:
                write_state(rows, i, orbit[i], t[i], z, i, memory, out)
    return 0


@jit(inline=True)
def pass_times_along(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer of `lanes` successive states of one orbit: the records of `pass_times` at each."""
    rows = int(value.rows)
    if t[lanes - 1] * (1.0 + ROUNDING) >= memory[ROWS.following * LANES]:
        for s in range(lanes):
            write_state(rows, s, orbit[0], t[s], z, 0, memory, out)
    return 0
