"""Samples of running orbits, and the natural frequencies that follow from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..jit import LANES, jit
from ..pointers import call_value
from .stepping import row


class SampleRows(NamedTuple):
    """Rows of observer memory: samples taken; if only every stride-th observation is one, also the stride, observations
    left until the next sample, whether it is this one, and the value now.

    The caller sets the stride, and `left` to the same number.
    """

    taken: int = 0
    stride: int = 1
    left: int = 2
    due: int = 3
    value: int = 4
    end: int = 5


ROWS = SampleRows()


class DampingRows(NamedTuple):
    """Rows of observer memory of slowed orbits: the share that momenta lose in a unit of sqrt(time), the root of the
    time up to which they lose three times as much, the share lost so far and the share kept now; as in `SampleRows`, a
    stride, observations left and whether one is due: one that slows, or of orbits that each observation slows one that
    is a sample, which have another row for the number taken.

    The caller sets the share, the root, the stride, and `left` to the stride.
    """

    share: int = 0
    early: int = 1
    lost: int = 2
    kept: int = 3
    stride: int = 4
    left: int = 5
    due: int = 6
    end: int = 7
    taken: int = 7
    sampled: int = 8


DAMPING_ROWS = DampingRows()


@jit
def sample(rows, lanes, orbit, fresh, block, taken, out):
    """Write the rows of block as the next sample of each fresh orbit; taken (LANES,) counts the samples."""
    for i in range(lanes):
        first = int(taken[i]) * rows
        if fresh[i] > 0.0 and first + rows <= out.shape[1]:
            for r in range(rows):
                out[orbit[i], first + r] = block[r * LANES + i]
            taken[i] += 1.0


@jit(inline=True)
def states(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: write each state as a sample."""
    sample(int(value.rows), lanes, orbit, fresh, z, row(memory, ROWS.taken), out)
    return 0


@jit(inline=True)
def columns(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: write each state as a sample, out[row * samples + taken, orbit]: neighbours side by side."""
    taken = row(memory, ROWS.taken)
    samples = int(value.samples)
    for r in range(int(value.rows)):
        for i in range(lanes):
            if fresh[i] > 0.0 and taken[i] < samples:
                out[r * samples + int(taken[i]), orbit[i]] = z[r * LANES + i]
    for i in range(lanes):
        taken[i] += fresh[i]
    return 0


@jit
def count_down(lanes, fresh, left, stride, due):
    """Mark the lanes whose stride-th fresh observation this is; return their number."""
    found = 0
    for i in range(lanes):
        rest = left[i] - fresh[i]
        due[i] = fresh[i] if rest == 0.0 else 0.0
        left[i] = stride[i] if rest == 0.0 else rest
        found += 1 if rest == 0.0 else 0
    return found


def lost_until(t, share, early):
    """Return the fraction share*(u + 2 u e/(u + e)) that momenta lose up to the time t, with u = sqrt(t), e = early;
    numbers or arrays.
    """
    root = np.sqrt(t)
    return share * root * (1.0 + 2.0 * early / (root + early))


_lost_until = jit(lost_until)


@jit
def wear_one(i, fresh, t, memory):
    """Return the share that the momenta of the orbit in lane i of memory keep at the time t, if it is fresh."""
    share = memory[DAMPING_ROWS.share * LANES + i]
    early = memory[DAMPING_ROWS.early * LANES + i]
    lost = memory[DAMPING_ROWS.lost * LANES + i]
    more = fresh * (_lost_until(t, share, early) - lost)
    memory[DAMPING_ROWS.lost * LANES + i] = lost + more
    return 1.0 - more


@jit
def wear_down(rows, lanes, fresh, t, z, memory):
    """Slow each fresh orbit by `wear_one`."""
    kept = row(memory, DAMPING_ROWS.kept)
    for i in range(lanes):
        kept[i] = wear_one(i, fresh[i], t[i], memory)
    for r in range(rows // 2, rows):
        for i in range(lanes):
            z[r * LANES + i] *= kept[i]


@jit(inline=True)
def damped_samples(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: slow each orbit at every n-th observation, n in its row `stride`, as rounding errors might."""
    due = row(memory, DAMPING_ROWS.due)
    if count_down(lanes, fresh, row(memory, DAMPING_ROWS.left), row(memory, DAMPING_ROWS.stride), due) > 0:
        wear_down(int(value.rows), lanes, due, t, z, memory)
    return 0


@jit(inline=True)
def worn_along(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer of `lanes` successive states of one orbit, or as many as `done` says, of which none but the last is one
    that slows it: the same as `damped_samples` at each.
    """
    taken = int(done[0]) if done[0] > 0.0 else lanes
    rows = int(value.rows)
    memory[DAMPING_ROWS.left * LANES] -= taken
    if memory[DAMPING_ROWS.left * LANES] == 0.0:
        memory[DAMPING_ROWS.left * LANES] = memory[DAMPING_ROWS.stride * LANES]
        kept = wear_one(0, 1.0, t[taken - 1], memory)
        for r in range(rows // 2, rows):
            z[r * LANES + taken - 1] *= kept
    return 0


@jit(inline=True)
def worn_states(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: slow the orbits at each observation, as rounding errors might, and write every n-th state as a sample,
    n in its row `stride`.
    """
    rows = int(value.rows)
    wear_down(rows, lanes, fresh, t, z, memory)
    due = row(memory, DAMPING_ROWS.due)
    if count_down(lanes, fresh, row(memory, DAMPING_ROWS.left), row(memory, DAMPING_ROWS.stride), due) > 0:
        sample(rows, lanes, orbit, due, z, row(memory, DAMPING_ROWS.taken), out)
    return 0


@jit(inline=True)
def thinned(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: write the value of the call at every n-th observation of an orbit, n in its row `stride`."""
    due = row(memory, ROWS.due)
    now = row(memory, ROWS.value)
    if count_down(lanes, fresh, row(memory, ROWS.left), row(memory, ROWS.stride), due) > 0:
        call_value(calls, 0, lanes, z, now)
        sample(1, lanes, orbit, due, now, row(memory, ROWS.taken), out)
    return 0


CHUNK = 16
"""Values of a row that are written at once: some cache lines."""


class ChunkRows(NamedTuple):
    """Rows of observer memory of signals: number of values written or kept, their final number, place of the first row
    in `out`, and the values kept.

    The caller sets their number and the place.
    """

    taken: int = 0
    length: int = 1
    start: int = 2
    kept: int = 3


CHUNK_ROWS = ChunkRows()


@jit
def places(rows):
    """Return the number of rows of memory between two kept values of a row: an odd number, as otherwise those of a
    chunk would share few places of the cache.
    """
    return rows + 1 - rows % 2


@jit
def keep_values(rows, lanes, fresh, memory, made, kept, out):
    """Keep the rows of made in each fresh lane; write full chunks to out (1, numbers): each row of an orbit after the
    other.
    """
    taken = row(memory, CHUNK_ROWS.taken)
    lengths = row(memory, CHUNK_ROWS.length)
    start = row(memory, CHUNK_ROWS.start)
    numbers = out[0]
    slot = int(taken[0]) % CHUNK
    apart = 0
    full = 0
    width = places(rows) * LANES
    for i in range(lanes):
        chunks = taken[i] / CHUNK
        apart += 1 if (chunks - np.floor(chunks)) * CHUNK != slot else 0
        apart += 1 if fresh[i] != 1.0 else 0
    if apart == 0:
        for k in range(rows * LANES):
            kept[slot * width + k] = made[k]
    else:
        for i in range(lanes):
            place = int(taken[i]) % CHUNK * width + i
            for r in range(rows if fresh[i] > 0.0 else 0):
                kept[place + r * LANES] = made[r * LANES + i]
    for i in range(lanes):
        taken[i] += fresh[i]
        chunks = taken[i] / CHUNK
        full += 1 if chunks == np.floor(chunks) else 0
        full += 1 if taken[i] == lengths[i] else 0
    if full == 0:
        return
    for r in range(rows):  # before lanes: neighbours in a cache line are read one after the other
        for i in range(lanes):
            n = int(taken[i])
            length = int(lengths[i])
            if fresh[i] > 0.0 and (n % CHUNK == 0 or n == length) and n <= length:
                done = (n - 1) // CHUNK * CHUNK
                first = int(start[i]) + r * length + done
                own = r * LANES + i
                if n - done == CHUNK:
                    part = numbers[first : first + CHUNK]
                    for s in range(CHUNK):
                        part[s] = kept[s * width + own]
                else:
                    for s in range(n - done):
                        numbers[first + s] = kept[s * width + own]


@jit(inline=True)
def called_rows(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: write the rows that the call gives at each observation."""
    kept = memory[CHUNK_ROWS.kept * LANES :]
    rows = int(value.rows)
    made = kept[CHUNK * places(rows) * LANES :]
    call_value(calls, 0, lanes, z, made)
    keep_values(rows, lanes, fresh, memory, made, kept, out)
    return 0


@jit(inline=True)
def nothing(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: keep nothing."""
    return 0


def scales(unit, W, force, velocity, momentum, kinetic, rate, largest):
    """Set rate (orbits,), of the orbits of a unit, to (<F.W F>/<p.v>)^(1/2) of all samples that are finite, largest to
    their largest T.

    W (n, n, orbits); force, velocity, momentum (n, samples, orbits); kinetic (samples, orbits).
    """
    n, samples, orbits = force.shape
    first = unit * LANES
    lanes = min(LANES, orbits - first)
    pull = np.zeros(lanes)
    move = np.zeros(lanes)
    top = np.full(lanes, -np.inf)
    turned = np.empty(lanes)
    pulled = np.empty(lanes)
    moved = np.empty(lanes)
    for s in range(samples):  # loops over orbits innermost: vectors
        pulled[:] = 0.0
        moved[:] = 0.0
        for i in range(n):
            turned[:] = 0.0
            for j in range(n):
                for o in range(lanes):
                    turned[o] += W[i, j, first + o] * force[j, s, first + o]
            for o in range(lanes):
                pulled[o] += force[i, s, first + o] * turned[o]
                moved[o] += momentum[i, s, first + o] * velocity[i, s, first + o]
        for o in range(lanes):
            T = kinetic[s, first + o]
            sound = np.isfinite(pulled[o]) and np.isfinite(moved[o]) and np.isfinite(T)
            pull[o] += pulled[o] if sound else 0.0
            move[o] += moved[o] if sound else 0.0
            top[o] = max(top[o], T if sound else 0.0)
    for o in range(lanes):
        rate[first + o] = np.sqrt(np.divide(pull[o], move[o]))
        largest[first + o] = top[o]
