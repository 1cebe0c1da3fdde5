"""The drivers of units of orbits, and of one orbit, by fixed steps; `adaptive_drive` has that by adaptive steps.

Every orbit's arithmetic is its own, so results are bitwise the same for any number of threads, unit size or order of
the orbits. State that outlives a call (z, observer memory, steps done, status) is per orbit: a stopped run continues
where it stopped.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base.status import NOT_CONVERGED_CODE
from ..compile.jit import LANES, jit, read_now, write_now
from ..compile.pointers import call
from .stepping import advance, filled, keep, load_lane, look_back, move_lane, room, store_lane

BURST, BETWEEN = 128, 37
"""Steps between reads of the stop flag; steps after such a read when the orbits are checked once more."""
LONG = 64 * BURST
"""Steps of one orbit between reads of the stop flag."""
STRETCH = 32
"""Steps of one orbit that are checked together, at most LANES: those beyond its end do not count."""


@jit
def next_look(n):
    """Return the first number of steps above n at which a block checks its orbits.

    Powers of two up to BURST, then two moments of each BURST: an orbit may be at rest at all multiples of one number of
    steps.
    """
    if n < BURST:
        power = 1
        while power <= n:
            power *= 2
        return power
    rest = n % BURST
    return n - rest + (BETWEEN if rest < BETWEEN else BURST)


class Orbits(NamedTuple):
    """Running orbits, as in `flows.Ensemble`, with an observer's memory and records of each: z and memory (rows,
    orbits), out (orbits, columns), the others, such as the number of steps `taken`, (orbits,).
    """

    z: np.ndarray
    time: np.ndarray
    taken: np.ndarray
    ahead: np.ndarray
    ticks: np.ndarray
    kinetic: np.ndarray
    radius: np.ndarray
    status: np.ndarray
    memory: np.ndarray
    out: np.ndarray


class FixedSteps(NamedTuple):
    """Steps of an orbit's own size, up to `total` of them, observed every every[orbit] steps, or at least as often by
    `run_along`; arrays (orbits,).

    Orbits are taken in that `order`. With `refill` a lane takes the next orbit as soon as it is free; else the lanes of
    a block keep the same step number. strict: states are checked before they are observed.
    """

    size: np.ndarray
    total: np.ndarray
    every: np.ndarray
    order: np.ndarray
    strict: bool = False
    refill: bool = False


def run_fixed(u, stop, progress, blocks, scheme, observer, steps, unit, orbits):
    """Advance unit u of the orbits by fixed steps.

    The domain is checked at every step; escape radii and kinetic energies are checked at `next_look` (at every step
    with `refill`, before every observation if `strict`); splittings take all steps to the next check or observation at
    once. orbits.kinetic keeps the largest kinetic energy that was seen.
    """
    params, inside, check = blocks.params, blocks.inside, blocks.check
    observe, numbers, calls = observer
    step, total, every, order, strict, refill = steps
    z0, count, kinetic0, status = orbits.z, orbits.taken, orbits.kinetic, orbits.status
    radius, memory0, out = orbits.radius, orbits.memory, orbits.out
    rows, memory_rows = z0.shape[0], memory0.shape[0]
    state_rows = scheme.copies * rows
    following, end = u * unit, min((u + 1) * unit, z0.shape[1])
    block, work, memory = room(state_rows + scheme.spare), room(rows), room(memory_rows)
    k, begin = room(scheme.b.size * rows), room(rows)
    z = block[: state_rows * LANES]
    t, h, code, done, fresh = room(1), room(1), room(1), room(1), room(1)
    kinetic, seen, found, reached, bound = room(1), room(1), room(1), room(1), room(1)
    n, orbit = np.empty(LANES, np.int64), np.empty(LANES, np.int64)
    left, cadence, lanes = np.empty(LANES, np.int64), np.empty(LANES, np.int64), 0
    while read_now(stop, 0) == 0:
        if refill or lanes == 0:
            while lanes < LANES and following < end:
                o = order[following]
                if status[o] == 0 and count[o] < total[o]:
                    load_lane(z0, o, z, lanes)
                    for r in range(rows, state_rows):
                        z[r * LANES + lanes] = 0.0
                    load_lane(memory0, o, memory, lanes)
                    orbit[lanes], n[lanes], h[lanes], cadence[lanes] = o, count[o], step[o], every[o]
                    left[lanes], kinetic[lanes], bound[lanes] = every[o] - count[o] % every[o], kinetic0[o], radius[o]
                    code[lanes], done[lanes], fresh[lanes] = 0.0, 0.0, 1.0
                    lanes += 1
                following += 1
        if lanes == 0:
            break
        burst = BURST - n[0] % BURST
        for i in range(lanes):
            burst = min(burst, total[orbit[i]] - n[i])
        ran, ended, wide = 0, 0, filled(lanes, state_rows, z, h)
        while ran < burst and ended == 0:
            each = refill or blocks.leapt != 0
            quiet = 1 if each else min(burst - ran, next_look(n[0]) - n[0])  # steps to the next check
            if quiet > 1:
                for i in range(lanes):
                    quiet = min(quiet, left[i])
            if blocks.leapt != 0:
                keep(rows, lanes, z, begin)
            taken = advance(blocks, scheme, rows, wide, h, quiet, block, k, work)
            ran, due = ran + taken, 0
            for i in range(lanes):
                n[i], left[i] = n[i] + taken, left[i] - taken
                t[i] = n[i] * h[i]
                due += 1 if left[i] == 0 else 0
            all_look = refill or next_look(n[0] - 1) == n[0]
            if all_look:
                call(check, params, wide, bound, z, code, kinetic)
            else:
                call(inside, params, wide, z, code)
                if ran == burst or (strict and due > 0):
                    for i in range(lanes):
                        found[i], reached[i] = code[i], kinetic[i]
                    call(check, params, lanes, bound, z, found, reached)
                    for i in range(lanes):  # each orbit is checked at its own moments, independent of its neighbours
                        if n[i] == total[orbit[i]] or (strict and left[i] == 0):
                            code[i], kinetic[i] = found[i], reached[i]
            look_back(blocks, lanes, begin, z, code)
            lost = 0
            for i in range(lanes):
                now, until, again, sees = code[i], left[i], cadence[i], fresh[i]  # read first: no branches, vectors
                lost += 0 if now == 0.0 else 1
                sees = sees if now == 0.0 else 0.0
                fresh[i] = sees
                seen[i] = sees if until == 0 else 0.0
                left[i] = again if until == 0 else until
            ended += lost
            if lost > 0 and scheme.sweeps > 0:
                for i in range(lanes):
                    if code[i] > 0.0 and block[rows * LANES + i] == np.inf:
                        code[i] = NOT_CONVERGED_CODE
            if due > 0:
                ended += call(observe, numbers, calls, lanes, orbit, seen, t, z, memory, out, done)
        write_now(progress, u, progress[u] + ran * lanes)
        i = 0
        while i < lanes:
            o = orbit[i]
            if code[i] > 0.0 or done[i] > 0.0 or n[i] == total[o]:
                store_lane(z, i, z0, o)
                store_lane(memory, i, memory0, o)
                count[o], kinetic0[o] = n[i], kinetic[i]
                status[o] = np.int64(code[i])
                lanes -= 1
                move_lane(state_rows, lanes, i, z)
                move_lane(memory_rows, lanes, i, memory)
                orbit[i], n[i], left[i], cadence[i] = orbit[lanes], n[lanes], left[lanes], cadence[lanes]
                h[i], kinetic[i], bound[i] = h[lanes], kinetic[lanes], bound[lanes]
                code[i], done[i], fresh[i] = code[lanes], done[lanes], fresh[lanes]
            else:
                i += 1
    for i in range(lanes):
        store_lane(z, i, z0, orbit[i])
        store_lane(memory, i, memory0, orbit[i])
        count[orbit[i]], kinetic0[orbit[i]] = n[i], kinetic[i]


def run_one(u, stop, progress, blocks, scheme, observer, steps, unit, orbits):
    """Advance one orbit by `march`, with the bits of `run_fixed`; its loops over lanes would take as long as a step."""
    params, strict, refill, o = blocks.params, steps.strict, steps.refill, steps.order[u]
    observe, numbers, calls = observer
    total, every, h, n, out = steps.total[o], steps.every[o], steps.size[o], orbits.taken[o], orbits.out
    if orbits.status[o] != 0 or n >= total:
        return
    rows, memory_rows = orbits.z.shape[0], orbits.memory.shape[0]
    block, memory, orbit = room(scheme.copies * rows + scheme.spare), room(memory_rows), np.full(LANES, o, np.int64)
    z = block[: scheme.copies * rows * LANES]
    t, code, done, seen, kinetic, bound = room(1), room(1), room(1), room(1), room(1), room(1)
    load_lane(orbits.z, o, z, 0)
    load_lane(orbits.memory, o, memory, 0)
    kinetic[0], bound[0], left, begun = orbits.kinetic[o], orbits.radius[o], every - n % every, n
    while n < total and code[0] == 0.0 and done[0] == 0.0 and read_now(stop, 0) == 0:
        until = min(total, n + LONG - n % LONG)
        while n < until and code[0] == 0.0 and done[0] == 0.0:
            quiet = min(left, 1 if refill else min(until, next_look(n)) - n)
            taken = call(blocks.march, params, scheme.drift, scheme.kick, h, quiet, block, block[:0])
            n, left = n + taken, left - taken
            t[0] = n * h
            if refill or n == total or next_look(n - 1) == n or (strict and left == 0):
                call(blocks.check, params, 1, bound, z, code, kinetic)
            else:
                call(blocks.inside, params, 1, z, code)
            if left == 0:
                seen[0], left = 1.0 if code[0] == 0.0 else 0.0, every
                call(observe, numbers, calls, 1, orbit, seen, t, z, memory, out, done)
        write_now(progress, u, progress[u] + n - begun)
        begun = n
    store_lane(z, 0, orbits.z, o)
    store_lane(memory, 0, orbits.memory, o)
    orbits.taken[o], orbits.kinetic[o], orbits.status[o] = n, kinetic[0], np.int64(code[0])


def run_along(u, stop, progress, blocks, scheme, observer, steps, unit, orbits):
    """Advance one orbit by `march`, with the bits of `run_fixed` that observes each step; up to STRETCH of its states
    are the lanes of a block, for `check` and for the observer.

    The observer sees these states, the last of which it may change, of one orbit, whose memory is in lane 0; after them
    are two rows of its own; done[0] is the number of the state, from 1, that ends the orbit. The steps that are
    multiples of `every` are last states.
    """
    params, o, (observe, numbers, calls), out = blocks.params, steps.order[u], observer, orbits.out
    total, h, n = steps.total[o], steps.size[o], orbits.taken[o]
    if orbits.status[o] != 0 or n >= total:
        return
    rows, memory_rows = orbits.z.shape[0], orbits.memory.shape[0]
    block, memory, orbit = room(scheme.copies * rows + scheme.spare), room(memory_rows), np.full(LANES, o, np.int64)
    trace, t, code, done, seen, kinetic, bound = room(rows + 2), room(1), room(1), room(1), room(1), room(1), room(1)
    load_lane(orbits.z, o, block[: rows * LANES], 0)
    load_lane(orbits.memory, o, memory, 0)
    largest, ended, begun, stretch = orbits.kinetic[o], 0.0, n, min(STRETCH, steps.every[o])
    for i in range(STRETCH):
        bound[i], seen[i] = orbits.radius[o], 1.0
    while n < total and ended == 0.0 and done[0] == 0.0 and read_now(stop, 0) == 0:
        until = min(total, n + LONG - n % LONG)
        while n < until and ended == 0.0 and done[0] == 0.0:
            lanes = min(stretch - n % stretch, until - n)
            call(blocks.march, params, scheme.drift, scheme.kick, h, lanes, block, trace)
            for i in range(lanes):
                t[i], kinetic[i] = (n + (i + 1)) * h, largest
            call(blocks.check, params, lanes, bound, trace, code, kinetic)
            sound = 0
            while sound < lanes and code[sound] == 0.0:
                sound += 1
            taken = lanes
            if sound < lanes:
                taken, ended = sound + 1, code[sound]
            if sound > 0:
                call(observe, numbers, calls, sound, orbit, seen, t, trace, memory, out, done)
            if done[0] > 0.0:
                taken, ended = int(done[0]), 0.0
            for i in range(taken):
                largest = max(largest, kinetic[i])
            n += taken
            for r in range(rows):
                block[r * LANES] = trace[r * LANES + taken - 1]
        write_now(progress, u, progress[u] + n - begun)
        begun = n
    store_lane(block, 0, orbits.z, o)
    store_lane(memory, 0, orbits.memory, o)
    orbits.taken[o], orbits.kinetic[o], orbits.status[o] = n, largest, np.int64(ended)
