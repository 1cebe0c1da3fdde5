"""The drivers of units of orbits, and of one orbit, by fixed steps; `adaptive_drive` has that by adaptive steps.

Every orbit's arithmetic is its own, so results are bitwise the same for any number of threads, unit size or order of
the orbits. State that outlives a call (z, observer memory, steps done, status) is per orbit: a stopped run continues
where it stopped.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.status import NOT_CONVERGED_CODE
from ..jit import LANES, jit, read_now, write_now
from ..pointers import call
from .stepping import advance, aligned_zeros, check_vectors, filled, keep, load_lane, look_back, move_lane, store_lane

BURST = 128
"""Steps between reads of the stop flag."""

BETWEEN = 37
"""Steps after such a read when the orbits are checked once more."""

LONG = 64 * BURST
"""Steps of one orbit between reads of the stop flag."""
STRETCH = 32
"""Steps of one orbit that are checked together, at most LANES: those beyond its end do not count."""


@jit
def next_check(n):
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


class RunningOrbits(NamedTuple):
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

    The domain is checked at every step; escape radii and kinetic energies are checked at `next_check` (at every step
    with `refill`, before every observation if `strict`); splittings take all steps to the next check or observation at
    once. orbits.kinetic keeps the largest kinetic energy that was seen.
    """
    params = blocks.params
    inside = blocks.inside
    check = blocks.check
    observe, numbers, calls = observer
    step, total, every, order, strict, refill = steps
    z0 = orbits.z
    count = orbits.taken
    kinetic0 = orbits.kinetic
    status = orbits.status
    radius = orbits.radius
    memory0 = orbits.memory
    out = orbits.out
    rows = z0.shape[0]
    memory_rows = memory0.shape[0]
    state_rows = scheme.copies * rows
    following = u * unit
    end = min((u + 1) * unit, z0.shape[1])
    block = aligned_zeros(state_rows + scheme.spare)
    work = aligned_zeros(rows)
    memory = aligned_zeros(memory_rows)
    k = aligned_zeros(scheme.b.size * rows)
    begin = aligned_zeros(rows)
    z = block[: state_rows * LANES]
    momenta = z[blocks.half * LANES :]
    t = aligned_zeros(1)
    h = aligned_zeros(1)
    code = aligned_zeros(1)
    done = aligned_zeros(1)
    fresh = aligned_zeros(1)
    kinetic = aligned_zeros(1)
    seen = aligned_zeros(1)
    found = aligned_zeros(1)
    reached = aligned_zeros(1)
    bound = aligned_zeros(1)
    n = np.empty(LANES, np.int64)
    orbit = np.empty(LANES, np.int64)
    left = np.empty(LANES, np.int64)
    cadence = np.empty(LANES, np.int64)
    lanes = 0
    while read_now(stop, 0) == 0:
        if refill or lanes == 0:
            while lanes < LANES and following < end:
                o = order[following]
                if status[o] == 0 and count[o] < total[o]:
                    load_lane(z0, o, z, lanes)
                    for r in range(rows, state_rows):
                        z[r * LANES + lanes] = 0.0
                    load_lane(memory0, o, memory, lanes)
                    orbit[lanes] = o
                    n[lanes] = count[o]
                    h[lanes] = step[o]
                    cadence[lanes] = every[o]
                    left[lanes] = every[o] - count[o] % every[o]
                    kinetic[lanes] = kinetic0[o]
                    bound[lanes] = radius[o]
                    code[lanes] = 0.0
                    done[lanes] = 0.0
                    fresh[lanes] = 1.0
                    lanes += 1
                following += 1
        if lanes == 0:
            break
        burst = BURST - n[0] % BURST
        for i in range(lanes):
            burst = min(burst, total[orbit[i]] - n[i])
        ran = 0
        ended = 0
        wide = filled(lanes, state_rows, z, h)
        while ran < burst and ended == 0:
            each = refill or blocks.leapt != 0
            quiet = 1 if each else min(burst - ran, next_check(n[0]) - n[0])  # steps to the next check
            if quiet > 1:
                for i in range(lanes):
                    quiet = min(quiet, left[i])
            if blocks.leapt != 0:
                keep(rows, lanes, z, begin)
            taken = advance(blocks, scheme, rows, wide, h, quiet, block, k, work)
            ran = ran + taken
            due = 0
            for i in range(lanes):
                n[i] = n[i] + taken
                left[i] = left[i] - taken
                t[i] = n[i] * h[i]
                due += 1 if left[i] == 0 else 0
            all_look = refill or next_check(n[0] - 1) == n[0]
            if all_look:
                call(check, params, wide, bound, z, momenta, code, kinetic)
                check_vectors(blocks, lanes, z, code, 1.0)
            else:
                call(inside, params, wide, z, momenta, code)
                check_vectors(blocks, lanes, z, code, blocks.between)
                if ran == burst or (strict and due > 0):
                    for i in range(lanes):
                        found[i] = code[i]
                        reached[i] = kinetic[i]
                    call(check, params, lanes, bound, z, momenta, found, reached)
                    check_vectors(blocks, lanes, z, found, 1.0)
                    for i in range(lanes):  # each orbit is checked at its own moments, independent of its neighbours
                        if n[i] == total[orbit[i]] or (strict and left[i] == 0):
                            code[i] = found[i]
                            kinetic[i] = reached[i]
            look_back(blocks, lanes, begin, z, code)
            lost = 0
            for i in range(lanes):
                # read first: no branches, vectors
                now = code[i]
                until = left[i]
                again = cadence[i]
                sees = fresh[i]
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
                count[o] = n[i]
                kinetic0[o] = kinetic[i]
                status[o] = np.int64(code[i])
                lanes -= 1
                move_lane(state_rows, lanes, i, z)
                move_lane(memory_rows, lanes, i, memory)
                orbit[i] = orbit[lanes]
                n[i] = n[lanes]
                left[i] = left[lanes]
                cadence[i] = cadence[lanes]
                h[i] = h[lanes]
                kinetic[i] = kinetic[lanes]
                bound[i] = bound[lanes]
                code[i] = code[lanes]
                done[i] = done[lanes]
                fresh[i] = fresh[lanes]
            else:
                i += 1
    for i in range(lanes):
        store_lane(z, i, z0, orbit[i])
        store_lane(memory, i, memory0, orbit[i])
        count[orbit[i]] = n[i]
        kinetic0[orbit[i]] = kinetic[i]


def run_one(u, stop, progress, blocks, scheme, observer, steps, unit, orbits):
    """Advance one orbit by `march`, with the bits of `run_fixed`; its loops over lanes would take as long as a step."""
    params = blocks.params
    strict = steps.strict
    refill = steps.refill
    o = steps.order[u]
    observe, numbers, calls = observer
    total = steps.total[o]
    every = steps.every[o]
    h = steps.size[o]
    n = orbits.taken[o]
    out = orbits.out
    if orbits.status[o] != 0 or n >= total:
        return
    rows = orbits.z.shape[0]
    memory_rows = orbits.memory.shape[0]
    block = aligned_zeros(scheme.copies * rows + scheme.spare)
    memory = aligned_zeros(memory_rows)
    orbit = np.full(LANES, o, np.int64)
    z = block[: scheme.copies * rows * LANES]
    momenta = z[blocks.half * LANES :]
    t = aligned_zeros(1)
    code = aligned_zeros(1)
    done = aligned_zeros(1)
    seen = aligned_zeros(1)
    kinetic = aligned_zeros(1)
    bound = aligned_zeros(1)
    load_lane(orbits.z, o, z, 0)
    load_lane(orbits.memory, o, memory, 0)
    kinetic[0] = orbits.kinetic[o]
    bound[0] = orbits.radius[o]
    left = every - n % every
    begun = n
    while n < total and code[0] == 0.0 and done[0] == 0.0 and read_now(stop, 0) == 0:
        until = min(total, n + LONG - n % LONG)
        while n < until and code[0] == 0.0 and done[0] == 0.0:
            quiet = min(left, 1 if refill else min(until, next_check(n)) - n)
            taken = call(blocks.march, params, scheme.drift, scheme.kick, h, quiet, block, block[:0])
            n = n + taken
            left = left - taken
            t[0] = n * h
            if refill or n == total or next_check(n - 1) == n or (strict and left == 0):
                call(blocks.check, params, 1, bound, z, momenta, code, kinetic)
                check_vectors(blocks, 1, z, code, 1.0)
            else:
                call(blocks.inside, params, 1, z, momenta, code)
                check_vectors(blocks, 1, z, code, blocks.between)
            if left == 0:
                seen[0] = 1.0 if code[0] == 0.0 else 0.0
                left = every
                call(observe, numbers, calls, 1, orbit, seen, t, z, memory, out, done)
        write_now(progress, u, progress[u] + n - begun)
        begun = n
    store_lane(z, 0, orbits.z, o)
    store_lane(memory, 0, orbits.memory, o)
    orbits.taken[o] = n
    orbits.kinetic[o] = kinetic[0]
    orbits.status[o] = np.int64(code[0])


def run_along(u, stop, progress, blocks, scheme, observer, steps, unit, orbits):
    """Advance one orbit by `march`, with the bits of `run_fixed` that observes each step; up to STRETCH of its states
    are the lanes of a block, for `check` and for the observer.

    The observer sees these states, the last of which it may change, of one orbit, whose memory is in lane 0; after them
    are two rows of its own; done[0] is the number of the state, from 1, that ends the orbit. The steps that are
    multiples of `every` are last states.
    """
    params = blocks.params
    o = steps.order[u]
    observe, numbers, calls = observer
    out = orbits.out
    total = steps.total[o]
    h = steps.size[o]
    n = orbits.taken[o]
    if orbits.status[o] != 0 or n >= total:
        return
    rows = orbits.z.shape[0]
    memory_rows = orbits.memory.shape[0]
    block = aligned_zeros(scheme.copies * rows + scheme.spare)
    memory = aligned_zeros(memory_rows)
    orbit = np.full(LANES, o, np.int64)
    trace = aligned_zeros(rows + 2)
    momenta = trace[blocks.half * LANES :]
    t = aligned_zeros(1)
    code = aligned_zeros(1)
    done = aligned_zeros(1)
    seen = aligned_zeros(1)
    kinetic = aligned_zeros(1)
    bound = aligned_zeros(1)
    load_lane(orbits.z, o, block[: rows * LANES], 0)
    load_lane(orbits.memory, o, memory, 0)
    largest = orbits.kinetic[o]
    ended = 0.0
    begun = n
    stretch = min(STRETCH, steps.every[o])
    for i in range(STRETCH):
        bound[i] = orbits.radius[o]
        seen[i] = 1.0
    while n < total and ended == 0.0 and done[0] == 0.0 and read_now(stop, 0) == 0:
        until = min(total, n + LONG - n % LONG)
        while n < until and ended == 0.0 and done[0] == 0.0:
            lanes = min(stretch - n % stretch, until - n)
            call(blocks.march, params, scheme.drift, scheme.kick, h, lanes, block, trace)
            for i in range(lanes):
                t[i] = (n + (i + 1)) * h
                kinetic[i] = largest
            call(blocks.check, params, lanes, bound, trace, momenta, code, kinetic)
            check_vectors(blocks, lanes, trace, code, 1.0)
            sound = 0
            while sound < lanes and code[sound] == 0.0:
                sound += 1
            taken = lanes
            if sound < lanes:
                taken = sound + 1
                ended = code[sound]
            if sound > 0:
                call(observe, numbers, calls, sound, orbit, seen, t, trace, memory, out, done)
            if done[0] > 0.0:
                taken = int(done[0])
                ended = 0.0
            for i in range(taken):
                largest = max(largest, kinetic[i])
            n += taken
            for r in range(rows):
                block[r * LANES] = trace[r * LANES + taken - 1]
        write_now(progress, u, progress[u] + n - begun)
        begun = n
    store_lane(block, 0, orbits.z, o)
    store_lane(memory, 0, orbits.memory, o)
    orbits.taken[o] = n
    orbits.kinetic[o] = largest
    orbits.status[o] = np.int64(ended)
