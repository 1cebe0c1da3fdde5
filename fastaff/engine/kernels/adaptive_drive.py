"""The driver of units of orbits by adaptive steps, with separate step control of each; bits and stops as in `drive`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.status import STEP_TOO_SMALL_CODE
from ..jit import LANES, jit, read_now, write_now
from ..pointers import call
from .stepping import (
    aligned_zeros,
    call_derivative,
    check_vectors,
    combine,
    filled,
    load_lane,
    look_back,
    move_lane,
    runge_kutta_stages,
    store_lane,
)

AT_WALL = 1e-13
"""Step, relative to the longest, at which an orbit that would leave the domain ends: shorter ones do not move it."""
PATIENCE = 2**19
"""Number of steps after which an orbit ends if it runs away faster and faster."""

RUNAWAY = 1e-4
"""The mean step, over the longest one, below which it does."""

SAFETY = 0.75
"""Next step relative to the step of error 1. With 0.9 a fifth of the steps were repeated, and the same errors of double
pendulums, Kepler orbits, Hénon-Heiles and walls cost a tenth more slopes, at all tolerances.
"""
STATE_NOISE = 1e-15
"""Rounding error of a coordinate that should be 0, relative to the largest coordinate."""
TINY = 1e-290
"""Least scale of an error, so that no quotient is infinite."""


class AdaptiveSteps(NamedTuple):
    """Steps controlled by their errors, of each orbit to its time `until` (orbits,).

    The first `own` rows of both halves are the state. In any units atol counts relative to a row's value or to its
    slope times the step, whichever is larger, and rounding relative to the largest row of its half, of both if they are
    `mixed`. The other rows are tangent vectors, whose lengths are near 1. The observer sees every accepted step
    (cadence = 0), and may change its state with `renew`, or multiples of `cadence` by the interpolant.
    """

    until: np.ndarray
    rtol: float
    atol: float
    own: int
    mixed: bool
    cadence: float
    renew: bool


class Lanes(NamedTuple):
    """A block of running orbits: their numbers, whether their step is accepted, samples so far, whether the observer is
    done with them; the step from t to t + h from the state z with the slopes k; the observer's memory.
    """

    orbit: np.ndarray
    fresh: np.ndarray
    ticks: np.ndarray
    done: np.ndarray
    t: np.ndarray
    h: np.ndarray
    z: np.ndarray
    k: np.ndarray
    memory: np.ndarray


@jit
def error_norm(rows, lanes, steps, errors, step, z, new, k, work, norm):
    """Set norm (LANES) to the scaled RMS error estimate; two rows of errors give DOP853's blend of orders 5 and 3.
    work: scratch, 2*rows + 5 rows.

    Source: Hairer, Norsett & Wanner II.4 and II.10. Here and below slices of one length spare the loops checks of
    indices.
    """
    size = rows * LANES
    stages = errors.shape[1]
    blend = errors.shape[0] > 1
    h = step[:lanes]
    one = work[:size]
    other = work[size : 2 * size]
    more = work[2 * size :]
    upper = more[:lanes]
    lower = more[LANES : LANES + lanes]
    scale = more[2 * LANES : 2 * LANES + lanes]
    first = more[3 * LANES : 3 * LANES + lanes]
    second = more[4 * LANES : 4 * LANES + lanes]
    combine(rows, lanes, stages, errors[0], k, one)
    if blend:
        combine(rows, lanes, stages, errors[1], k, other)
    widths(rows, lanes, steps, z, upper, lower)
    first[:] = 0.0
    second[:] = 0.0
    for at in range(0, size, LANES):
        begin = z[at : at + lanes]
        end = new[at : at + lanes]
        slope = k[at : at + lanes]
        place = at if 2 * at < size else at - size // 2
        if place < steps.own * LANES:
            scales(steps, h, begin, end, slope, upper if place == at else lower, scale)
        else:
            for i in range(lanes):
                scale[i] = steps.atol + steps.rtol * max(abs(begin[i]), abs(end[i]))
        error = one[at : at + lanes]
        for i in range(lanes):
            first[i] += (error[i] / scale[i]) ** 2
        if blend:
            error = other[at : at + lanes]
            for i in range(lanes):
                second[i] += (error[i] / scale[i]) ** 2
    share, weighed, result = (0.01, second, norm[:lanes]) if blend else (0.0, first, norm[:lanes])
    for i in range(lanes):
        denominator = first[i] + share * weighed[i]
        value = h[i] * first[i] / np.sqrt(denominator * rows) if denominator > 0.0 else 0.0
        result[i] = value if denominator >= 0.0 else np.inf


@jit
def widths(rows, lanes, steps, z, upper, lower):
    """Set upper and lower to the largest coordinates of the halves of a state, of both if they are `mixed`."""
    upper[:] = 0.0
    lower[:] = 0.0
    half = rows // 2 * LANES
    for at in range(0, steps.own * LANES, LANES):
        q = z[at : at + lanes]
        p = z[half + at : half + at + lanes]
        for i in range(lanes):
            upper[i] = max(upper[i], abs(q[i]))
            lower[i] = max(lower[i], abs(p[i]))
    if steps.mixed:
        for i in range(lanes):
            upper[i] = max(upper[i], lower[i])
            lower[i] = upper[i]


@jit
def scales(steps, h, begin, end, slope, widest, scale):
    """Set scale to the errors that count as 1 in a row of a state."""
    rtol = steps.rtol
    atol = steps.atol
    for i in range(scale.size):
        size = max(abs(begin[i]), abs(end[i]))
        noise = STATE_NOISE * widest[i]
        scale[i] = rtol * size + atol * max(size, h[i] * abs(slope[i])) + noise + TINY


@jit
def controlled(lanes, norm, code, h, fresh, ceiling, ahead, longest):
    """Decide which steps are accepted, and set the lengths of the next ones, by the norms of their errors.

    By the eighth root of the error norm, made of exactly rounded roots, also for an estimate that shrinks as h^9: there
    the next step has -1/8 of the (logarithmic) error of a wrong one; a ninth root changed the cost by less than 4 %.
    """
    for i in range(lanes):
        root = np.sqrt(np.sqrt(np.sqrt(norm[i])))
        wanted = SAFETY / root
        wanted = wanted if wanted > 0.2 else 0.2
        factor = wanted if (norm[i] > 0.0) & (wanted < ceiling[i]) else ceiling[i]
        # A trial beyond the wall is too long a step, not yet a collapse: try a shorter one.
        factor = 0.2 if (code[i] != 0.0) & (factor > 0.2) else factor
        ahead[i] = h[i] * factor
    for i in range(lanes):
        fresh[i] = 1.0 if (norm[i] < 1.0) & (code[i] == 0.0) else 0.0
        ceiling[i] = 10.0 if fresh[i] > 0.0 else 1.0
    for i in range(lanes):
        longest[i] = h[i] if (fresh[i] > 0.0) & (h[i] > longest[i]) else longest[i]


@jit
def ended(lanes, tried, code, fresh, ahead, longest, t):
    """Count the attempts, and set the codes of lanes that their steps no longer move, or that run away."""
    for i in range(lanes):
        count = tried[i]
        now = t[i]
        wrong = code[i]
        accepted = fresh[i]
        most = longest[i]
        following = ahead[i]
        runs = (count > PATIENCE) & (now < RUNAWAY * most * count)
        stuck = (not (now + following > now)) | ((wrong > 0.0) & (following < AT_WALL * most))
        small = runs if accepted > 0.0 else stuck
        last = wrong if wrong > 0.0 else STEP_TOO_SMALL_CODE
        code[i] = last if small else 0.0
        tried[i] = count + 1.0


@jit
def passed(lanes, fresh, reached, kinetic, h, t, until):
    """Go on to the ends of accepted steps."""
    for i in range(lanes):
        accepted = fresh[i]
        now = t[i]
        step = h[i]
        last = until[i]
        before = kinetic[i]
        most = reached[i]
        end = now + step
        end = last if step == last - now else end
        kinetic[i] = most if accepted > 0.0 else before
        t[i] = end if accepted > 0.0 else now


@jit
def leaving(lanes, code, done, t, until):
    """Return the number of lanes whose orbits have ended."""
    number = 0
    for i in range(lanes):
        wrong = code[i]
        over = done[i]
        now = t[i]
        last = until[i]
        number += 1 if (wrong > 0.0) | (over > 0.0) | (now == last) else 0
    return number


@jit
def dense_state(rows, i, x, z, step, k, dense, target):
    """Evaluate the interpolant of lane i at the fraction x of its step into the same lane of target."""
    size = rows * LANES
    for r in range(rows):
        j = r * LANES + i
        value = 0.0
        for m in range(dense.shape[0] - 1, -1, -1):
            slope = 0.0
            for s in range(dense.shape[1]):
                slope += dense[m, s] * k[s * size + j]
            value = slope + (x if m % 2 == 1 else 1.0 - x) * value
        target[j] = z[j] + step * x * value


@jit
def observe_dense(observer, dense, rows, count, cadence, lanes, sample, out):
    """Call the observer at all multiples of `cadence` inside the accepted steps of the lanes. sample: scratch for a
    state.
    """
    observe, numbers, calls = observer
    orbit, fresh, ticks, done, t, h, z, k, memory = lanes
    pending = 1
    seen = aligned_zeros(1)
    at = aligned_zeros(1)
    while pending > 0:
        pending = 0
        for i in range(count):
            tick = (ticks[i] + 1) * cadence
            seen[i] = 0.0
            if fresh[i] > 0.0 and done[i] == 0.0 and tick <= (t[i] + h[i]) * (1.0 + 4e-16):
                dense_state(rows, i, min(1.0, (tick - t[i]) / h[i]), z, h[i], k, dense, sample)
                at[i] = tick
                seen[i] = 1.0
                ticks[i] += 1
                pending += 1
        if pending > 0:
            call(observe, numbers, calls, count, orbit, seen, at, sample, memory, out, done)


def run_adaptive(u, stop, progress, blocks, scheme, observer, steps, unit, orbits):
    """Advance the orbits of unit u from their times to steps.until with separate step control of each orbit; lanes are
    always refilled.

    Each attempted step of a block costs stages - 1 slopes (the last slope is the first of the next step), 3 or 4 more
    where the interpolant is used.
    """
    params = blocks.params
    check = blocks.check
    derivative = blocks.derivative
    observe, numbers, calls = observer
    a = scheme.a
    b = scheme.b
    cadence = steps.cadence
    z0, time0, attempts, step0, ticks0, kinetic0, radius, status, memory0, out = orbits
    rows = z0.shape[0]
    size = rows * LANES
    stages = b.size
    memory_rows = memory0.shape[0]
    following = u * unit
    end = min((u + 1) * unit, z0.shape[1])
    z = aligned_zeros(rows)
    new = aligned_zeros(rows)
    momenta = new[blocks.half * LANES :]
    work = aligned_zeros(2 * rows + 5)
    k = aligned_zeros(max(stages, a.shape[0]) * rows)
    memory = aligned_zeros(memory_rows)
    t = aligned_zeros(1)
    h = aligned_zeros(1)
    norm = aligned_zeros(1)
    bound = aligned_zeros(1)
    until = aligned_zeros(1)
    ahead = aligned_zeros(1)
    ceiling = aligned_zeros(1)
    kinetic = aligned_zeros(1)
    reached = aligned_zeros(1)
    longest = aligned_zeros(1)
    code = aligned_zeros(1)
    done = aligned_zeros(1)
    fresh = aligned_zeros(1)
    tried = aligned_zeros(1)
    ticks = np.empty(LANES, np.int64)
    orbit = np.empty(LANES, np.int64)
    block = Lanes(orbit, fresh, ticks, done, t, h, z, k, memory)
    lanes = 0
    while read_now(stop, 0) == 0:
        loaded = 0
        while lanes < LANES and following < end:
            if status[following] == 0 and time0[following] < steps.until[following]:
                load_lane(z0, following, z, lanes)
                load_lane(memory0, following, memory, lanes)
                orbit[lanes] = following
                t[lanes] = time0[following]
                ticks[lanes] = ticks0[following]
                ahead[lanes] = step0[following]
                kinetic[lanes] = kinetic0[following]
                ceiling[lanes] = 10.0
                longest[lanes] = 0.0
                bound[lanes] = radius[following]
                until[lanes] = steps.until[following]
                code[lanes] = 0.0
                done[lanes] = 0.0
                tried[lanes] = attempts[following]
                lanes += 1
                loaded += 1
            following += 1
        if lanes == 0:
            break
        if loaded > 0:
            call_derivative(derivative, params, lanes, z, k[:size])
        for i in range(lanes):
            h[i] = min(ahead[i], until[i] - t[i])
            reached[i] = kinetic[i]
        wide = max(filled(lanes, rows, z, h), filled(lanes, rows, k, h))  # states and their slopes alike
        runge_kutta_stages(derivative, params, a, 1, stages, rows, wide, h, z, k, new)
        error_norm(rows, wide, steps, scheme.errors, h, z, new, k, work, norm)
        call(check, params, wide, bound, new, momenta, code, reached)
        check_vectors(blocks, lanes, new, code, 1.0)
        look_back(blocks, lanes, z, new, code)
        controlled(lanes, norm, code, h, fresh, ceiling, ahead, longest)
        ended(lanes, tried, code, fresh, ahead, longest, t)
        if cadence > 0.0:
            inside = 0
            for i in range(lanes):
                if fresh[i] > 0.0 and (ticks[i] + 1) * cadence <= (t[i] + h[i]) * (1.0 + 4e-16):
                    inside += 1
            if inside > 0:
                runge_kutta_stages(derivative, params, a, stages, a.shape[0], rows, wide, h, z, k, work)
                observe_dense(observer, scheme.dense, rows, lanes, cadence, block, work[size : 2 * size], out)
        passed(lanes, fresh, reached, kinetic, h, t, until)
        move_steps(rows, lanes, fresh, new, k[(stages - 1) * size :], z, k)
        if cadence == 0.0:
            call(observe, numbers, calls, lanes, orbit, fresh, t, z, memory, out, done)
            if steps.renew:
                call_derivative(derivative, params, lanes, z, k[:size])
        write_now(progress, u, following - u * unit - lanes)
        i = 0 if leaving(lanes, code, done, t, until) > 0 else lanes
        while i < lanes:
            o = orbit[i]
            if code[i] > 0.0 or done[i] > 0.0 or t[i] == until[i]:
                store_lane(z, i, z0, o)
                store_lane(memory, i, memory0, o)
                time0[o] = t[i]
                step0[o] = ahead[i]
                ticks0[o] = ticks[i]
                kinetic0[o] = kinetic[i]
                status[o] = np.int64(code[i])
                attempts[o] = np.int64(tried[i])
                lanes -= 1
                move_lane(rows, lanes, i, z)
                move_lane(rows, lanes, i, k)
                move_lane(memory_rows, lanes, i, memory)
                orbit[i] = orbit[lanes]
                t[i] = t[lanes]
                ticks[i] = ticks[lanes]
                ahead[i] = ahead[lanes]
                ceiling[i] = ceiling[lanes]
                code[i] = code[lanes]
                done[i] = done[lanes]
                kinetic[i] = kinetic[lanes]
                bound[i] = bound[lanes]
                longest[i] = longest[lanes]
                until[i] = until[lanes]
                tried[i] = tried[lanes]
            else:
                i += 1
    for i in range(lanes):
        o = orbit[i]
        store_lane(z, i, z0, o)
        store_lane(memory, i, memory0, o)
        time0[o] = t[i]
        step0[o] = ahead[i]
        ticks0[o] = ticks[i]
        kinetic0[o] = kinetic[i]
        attempts[o] = np.int64(tried[i])


@jit
def move_steps(rows, lanes, fresh, new, last, z, k):
    """Accept the steps of fresh lanes: the new states, and their slopes as the first ones of the next steps."""
    accepted = fresh[:lanes]
    for at in range(0, rows * LANES, LANES):
        state = z[at : at + lanes]
        slope = k[at : at + lanes]
        end = new[at : at + lanes]
        ahead = last[at : at + lanes]
        for i in range(lanes):  # all numbers are read, as otherwise the loop would not vectorise
            before = state[i]
            after = end[i]
            first = slope[i]
            second = ahead[i]
            state[i] = after if accepted[i] > 0.0 else before
            slope[i] = second if accepted[i] > 0.0 else first
