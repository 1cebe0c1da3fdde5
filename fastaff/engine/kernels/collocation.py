"""Steps of a collocation for a block of lanes: its stages are iterated until their changes are rounding errors."""

from __future__ import annotations

import numpy as np

from ..fused import fma
from ..jit import LANES, jit
from .stepping import aligned_zeros, call_derivative, keep, stretch

SETTLED = 2.0**-36
"""Change of a sweep, relative to the largest numbers in its half of a state, above which no iteration has converged."""


NOTHING = 2.0**-60
"""Error of an iteration, relative to the size of a row, that counts as 0: hundreds of them make a rounding error. It
follows from two changes: later ones are assumed to fall by their quotient.
"""

FASTEST = 2.0**-6
"""Least quotient by which later changes are assumed to fall."""


@jit
def weighted(rows, lanes, weights, parts, begin, end, total):
    """Set total = begin + the sum of weights[t]*parts[t] + end of states; the number of parts is a multiple of 4.

    Here and below slices of one length spare the loops checks of indices. They are not made in the function that makes
    arrays, which would count the references to them.
    """
    stages = weights.size
    size = rows * LANES
    apart, length = stretch(rows, lanes)
    for at in range(0, size, apart):
        to = at + length
        head = begin[at:to]
        tail = end[at:to]
        result = total[at:to]
        for t in range(0, stages, 4):
            a0 = weights[t]
            a1 = weights[t + 1]
            a2 = weights[t + 2]
            a3 = weights[t + 3]
            b0 = t * size
            b1 = (t + 1) * size
            b2 = (t + 2) * size
            b3 = (t + 3) * size
            p0 = parts[b0 + at : b0 + to]
            p1 = parts[b1 + at : b1 + to]
            p2 = parts[b2 + at : b2 + to]
            p3 = parts[b3 + at : b3 + to]
            if stages == 8:  # in one loop: stores between two would take as long as the sums
                a4 = weights[4]
                a5 = weights[5]
                a6 = weights[6]
                a7 = weights[7]
                b4 = 4 * size
                b5 = 5 * size
                b6 = 6 * size
                b7 = 7 * size
                p4 = parts[b4 + at : b4 + to]
                p5 = parts[b5 + at : b5 + to]
                p6 = parts[b6 + at : b6 + to]
                p7 = parts[b7 + at : b7 + to]
                for i in range(length):
                    first = fma(a1, p1[i], a0 * p0[i])
                    second = fma(a3, p3[i], a2 * p2[i])
                    third = fma(a5, p5[i], a4 * p4[i])
                    last = fma(a7, p7[i], a6 * p6[i])
                    result[i] = (head[i] + ((first + second) + (third + last))) + tail[i]
                break
            for i in range(length):
                first = fma(a1, p1[i], a0 * p0[i])
                last = fma(a3, p3[i], a2 * p2[i])
                result[i] = (result[i] if t > 0 else head[i]) + (first + last)
        if stages != 8:
            for i in range(length):
                result[i] += tail[i]


@jit
def renewed(rows, lanes, weight, step, slope, going, parts, change):
    """Set the parts of running lanes to weight*step*slope, and change to its largest value in the sweep."""
    h = step[:lanes]
    active = going[:lanes]
    for at in range(0, rows * LANES, LANES):
        f = slope[at : at + lanes]
        part = parts[at : at + lanes]
        most = change[at : at + lanes]
        for i in range(lanes):
            new = h[i] * weight * f[i]
            moved = abs(new - part[i])
            most[i] = most[i] if most[i] >= moved else moved
            part[i] = new if active[i] > 0.0 else part[i]


@jit
def judged(rows, lanes, change, least, z, stage, going, before, relative, most, whole):
    """Set going, from the changes of a sweep, to 0 for lanes that are done and to 1/2 for those that take one more
    sweep; return the number of lanes that go on. before: the largest change of the sweep before, relative to its row.
    """
    half = rows // 2 * LANES
    more = most[:lanes]
    now = relative[:lanes]
    then = before[:lanes]
    state = going[:lanes]
    bound = whole[:lanes]
    width = whole[LANES : LANES + lanes]
    size = whole[2 * LANES : 2 * LANES + lanes]
    now[:] = 0.0
    more[:] = 0.0
    for first in range(0, rows * LANES, half):
        bound[:] = 0.0
        width[:] = 0.0
        for at in range(first, first + half, LANES):
            moved = change[at : at + lanes]
            best = least[at : at + lanes]
            y = z[at : at + lanes]
            other = stage[at : at + lanes]
            for i in range(lanes):  # loops of so few arrays each become vector instructions
                more[i] = 1.0 if (moved[i] > 0.0) & (moved[i] < best[i]) else more[i]
                best[i] = moved[i] if moved[i] < best[i] else best[i]
            for i in range(lanes):
                size[i] = abs(y[i]) + abs(other[i])
            for i in range(lanes):
                part = moved[i] / size[i]
                now[i] = part if part > now[i] else now[i]
            for i in range(lanes):
                bound[i] = bound[i] if bound[i] >= moved[i] else moved[i]
                width[i] = width[i] if width[i] >= size[i] else size[i]
        for i in range(lanes):
            more[i] = 1.0 if bound[i] > SETTLED * width[i] else more[i]
    active = 0
    for i in range(lanes):
        factor = now[i] / then[i]
        factor = factor if factor > FASTEST else FASTEST
        then[i] = now[i]
        left = 0.5 if factor * factor * now[i] <= NOTHING else 1.0
        state[i] = left if (state[i] == 1.0) & (more[i] > 0.0) else 0.0
        active += 1 if state[i] > 0.0 else 0
    return active


@jit
def settled(rows, lanes, stages, z, carried, parts, work):
    """Add the parts to a state, with its carried rounding errors (Kahan's summation)."""
    size = rows * LANES
    apart, length = stretch(rows, lanes)
    for at in range(0, size, apart):
        to = at + length
        y = z[at:to]
        error = carried[at:to]
        add = work[at:to]
        for i in range(length):
            add[i] = error[i]
        for first in range(at, stages * size, size):
            part = parts[first : first + length]
            for i in range(length):
                add[i] += part[i]
        for i in range(length):
            total = y[i] + add[i]
            error[i] = add[i] - (total - y[i])
            y[i] = total


@jit
def begun(rows, lanes, parts, fresh):
    """Set fresh to 1 for lanes without an earlier step, whose parts are 0; return their number."""
    new = 0
    first = fresh[:lanes]
    first[:] = 1.0
    for at in range(0, rows * LANES, LANES):
        part = parts[at : at + lanes]
        for i in range(lanes):
            first[i] = first[i] if part[i] == 0.0 else 0.0
    for i in range(lanes):
        new += 1 if first[i] > 0.0 else 0
    return new


@jit
def begin_anew(rows, lanes, fresh, other, total):
    """Take the other states in lanes that are fresh."""
    first = fresh[:lanes]
    for at in range(0, rows * LANES, LANES):
        own = other[at : at + lanes]
        result = total[at : at + lanes]
        for i in range(lanes):
            result[i] = own[i] if first[i] > 0.0 else result[i]


@jit
def collocate(derivative, params, lanes, rows, a, b, dense, sweeps, step, z, k, work):
    """Take one step of a collocation: z, its carried rounding errors, the parts L_s = h b_s f(Y_s) of the step before,
    and room for them.

    Y_s = z + sum of a[s, j] L_j is iterated stage after stage until in all rows of a lane the change no longer falls:
    it is a rounding error then, and the lane is frozen while others go on. The first sweep is a multistep method: a
    stage is the integral of the polynomial through the slopes of the last step and of the stages before it (`dense`);
    without a last step through the latter. If the iteration is not done within `sweeps` sweeps, z becomes NaN and its
    carried errors inf. The parts are summed with the rounding errors carried over (Kahan's summation).

    Source: Hairer, Lubich & Wanner, Geometric Numerical Integration, 2nd ed. 2006, VIII.6; Antonana, Makazaga & Murua,
    Numer. Algorithms 76 (2017) 861 (form of a, stopping); Hairer, McLachlan & Razakarivony, BIT 48 (2008) 231.
    """
    size = rows * LANES
    stages = b.size
    carried = z[size : 2 * size]
    parts = z[2 * size : (2 + stages) * size]
    old = z[(2 + stages) * size :]
    slope = k[:size]
    change = k[size : 2 * size]
    least = k[2 * size : 3 * size]
    going = aligned_zeros(1)
    before = aligned_zeros(1)
    none = aligned_zeros(rows)
    fresh = aligned_zeros(1)
    relative = aligned_zeros(1)
    most = aligned_zeros(1)
    whole = aligned_zeros(3)
    new = begun(rows, lanes, parts, fresh)
    keep(stages * rows, lanes, parts, old)
    least[:] = np.inf
    before[:] = np.inf
    going[:lanes] = 1.0
    for s in range(stages):
        weighted(rows, lanes, dense[s, :stages], old, carried, none, slope)
        weighted(rows, lanes, dense[s, stages:], parts, slope, z, work)
        if new > 0:
            weighted(rows, lanes, a[s], parts, carried, z, slope)
            begin_anew(rows, lanes, fresh, slope, work)
        call_derivative(derivative, params, lanes, work, slope)
        renewed(rows, lanes, b[s], step, slope, going, parts[s * size :], change)
    for _ in range(1, sweeps):
        change[:] = 0.0
        for s in range(stages):
            weighted(rows, lanes, a[s], parts, carried, z, work)
            call_derivative(derivative, params, lanes, work, slope)
            renewed(rows, lanes, b[s], step, slope, going, parts[s * size :], change)
        if judged(rows, lanes, change, least, z, work, going, before, relative, most, whole) == 0:
            break
    settled(rows, lanes, stages, z, carried, parts, work)
    for i in range(lanes):
        lost = going[i]
        for r in range(rows):
            lost += 0.0 * z[r * LANES + i]
        if lost != 0.0:
            for r in range(rows):
                z[r * LANES + i] = np.nan
                carried[r * LANES + i] = np.inf
    return 1
