"""Growth and alignment of tangent vectors, streamed: orthonormal vectors, and the coefficients of the true ones in
them.

The vectors of a state are kept orthonormal, W(t) = Q R_m ... R_1; S_i sums log R_ii, the growth of the volume. The true
vectors are the columns of the triangular product: `columns` holds them normalised, with the logarithm L_j of each
length. So log GALI_k = sum_(i<k) (S_i - L_i) keeps all its digits below 1e-16, where aligned vectors themselves could
not be told apart in memory.

Lengths and angles are those of each orbit's own metric sum_r g_r w_r^2, which brings positions and momenta to one unit.
A plain sum of their squares would change with the units, and show growth where a long position only turns into a short
momentum.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from ..elementary import log
from ..jit import LANES, jit
from ..pointers import call_reading, call_value
from .stepping import row


class DeviationRows(NamedTuple):
    """Rows of observer memory. The caller sets the stride, and `left` to the same number.

    left: looks until the next renormalisation of the orbit's vectors, every `stride` looks; due: whether it is now;
    last: time of the last one; half: time of the half-time values; weighted: sum of t dL for MEGNO; area: integral of
    MEGNO over time; megno; largest: largest L_0; largest_across: largest log of the part of w_0 across the flow;
    recorded: history slots written; peak, peak_across: largest square of the first vector since its renormalisation,
    and of its part across the flow; end: the first row of the `Parts`.
    """

    left: int = 0
    stride: int = 1
    due: int = 2
    last: int = 3
    half: int = 4
    weighted: int = 5
    area: int = 6
    megno: int = 7
    largest: int = 8
    largest_across: int = 9
    recorded: int = 10
    peak: int = 11
    peak_across: int = 12
    end: int = 13


ROWS = DeviationRows()


class Parts(NamedTuple):
    """First rows of the numbers kept for k vectors of 2n rows and m readings, in order; see `layout`. The caller sets
    columns, metric, thresholds and signs.

    sums (k): S; lengths (k): L; columns, factor (k*k): of the true vectors, and R;
    metric (2n); readings, half_readings, thresholds (m); signs (m): 1 where chaos is above the threshold, -1 below;
    detected (m): times of detection, 0 before.
    """

    sums: Any
    lengths: Any
    columns: Any
    factor: Any
    metric: Any
    readings: Any
    half_readings: Any
    thresholds: Any
    signs: Any
    detected: Any
    end: Any

    def of(self, memory: Any) -> Parts:
        """Return views of memory (rows, orbits) by the same names, with the remaining rows as `end`."""
        return Parts(*(memory[first:last] for first, last in itertools.pairwise((*self, None))))


def layout(n, k, m):
    """Return the parts of the memory for k vectors of 2n rows and m readings; m matters only for parts after the
    readings.
    """
    sums = ROWS.end
    columns = sums + 2 * k
    metric = columns + 2 * k * k
    readings = metric + 2 * n
    thresholds = readings + 2 * m
    detected = readings + 4 * m
    return Parts(
        sums,
        sums + k,
        columns,
        columns + k * k,
        metric,
        readings,
        readings + m,
        thresholds,
        thresholds + m,
        detected,
        detected + m,
    )


parts_of = jit(layout)
"""For kernels: Ctrl-C while compiled code makes a named tuple for Python is a crash (Numba 0.68)."""


@jit(constants=True)
def peak(n, k, lanes, fresh, z, memory):
    """Keep the largest square of the first vector since the last renormalisation."""
    half = n * (1 + k)
    at = parts_of(n, k, 0)
    for i in range(lanes):
        square = 0.0
        for r in range(2 * n):
            w = z[((n + r) if r < n else (half + r)) * LANES + i]
            square += memory[(at.metric + r) * LANES + i] * w * w
        largest = memory[ROWS.peak * LANES + i]
        memory[ROWS.peak * LANES + i] = square if fresh[i] > 0.0 and square > largest else largest


@jit(constants=True)
def peak_across(n, k, lanes, fresh, flow, z, memory):
    """Keep the largest square of the first vector's part across the direction `flow` (2n rows) of the orbit."""
    half = n * (1 + k)
    at = parts_of(n, k, 0)
    for i in range(lanes):
        square = 0.0
        along = 0.0
        size = 0.0
        for r in range(2 * n):
            w = z[((n + r) if r < n else (half + r)) * LANES + i]
            f = flow[r * LANES + i]
            g = memory[(at.metric + r) * LANES + i]
            square += g * w * w
            along += g * f * w
            size += g * f * f
        across = square - along * along / size if size > 0.0 else square
        largest = memory[ROWS.peak_across * LANES + i]
        memory[ROWS.peak_across * LANES + i] = max(largest, across) if fresh[i] > 0.0 else largest


@jit
def wait(time, slots, longest, lanes, fresh, t, memory):
    """Mark the lanes whose vectors are due at this look; return their number.

    They are due at every stride-th look at an orbit, at the first one past half time or past the next of the first
    `slots` records, at the end, and where the first vector has grown long. No branch, so that the loop vectorises.
    """
    found = 0
    for i in range(lanes):
        left = memory[ROWS.left * LANES + i] - fresh[i]
        recorded = memory[ROWS.recorded * LANES + i]
        now = t[i] * (1.0 + 1e-12)
        on = (left == 0.0) | (now >= time) | (memory[ROWS.peak * LANES + i] > longest)
        on |= (memory[ROWS.half * LANES + i] == 0.0) & (now >= 0.5 * time)
        on |= (recorded < slots) & (now * slots >= (recorded + 1.0) * time)
        on &= fresh[i] > 0.0
        memory[ROWS.left * LANES + i] = memory[ROWS.stride * LANES + i] if left == 0.0 else left
        memory[ROWS.due * LANES + i] = 1.0 if on else 0.0
        found += 1 if on else 0
    return found


@jit(constants=True)
def orthonormalise(n, k, lanes, z, memory):
    """Make the k vectors of the due lanes orthonormal in the metric, in their order (modified Gram-Schmidt); R into
    memory, S summed.

    z holds n positions of the orbit and of each vector, then momenta likewise, and numbers that a scheme keeps from
    step to step, such as carried rounding errors, which are set to 0 for the vectors of these lanes. A vector that
    vanishes, as the derivative of a map may have a lower rank, is 0 from then on.
    """
    half = n * (1 + k)
    at = parts_of(n, k, 0)
    for j in range(k):
        for b in range(j + 1):
            entry = (at.factor + b * k + j) * LANES
            for i in range(lanes):
                memory[entry + i] = 0.0
            for r in range(2 * n):
                first = (r if r < n else half + r - n) * LANES
                u = first + n * (1 + b) * LANES
                w = first + n * (1 + j) * LANES
                g = (at.metric + r) * LANES
                for i in range(lanes):
                    memory[entry + i] += memory[g + i] * z[u + i] * z[w + i]
            if b == j:
                for i in range(lanes):
                    memory[entry + i] = math.sqrt(memory[entry + i]) if memory[ROWS.due * LANES + i] > 0.0 else 1.0
                for i in range(lanes):
                    memory[(at.sums + j) * LANES + i] += log(memory[entry + i])
            else:
                for i in range(lanes):
                    memory[entry + i] = memory[entry + i] if memory[ROWS.due * LANES + i] > 0.0 else 0.0
            for r in range(2 * n):
                first = (r if r < n else half + r - n) * LANES
                u = first + n * (1 + b) * LANES
                w = first + n * (1 + j) * LANES
                if b == j:
                    g = (at.metric + r) * LANES
                    for i in range(lanes):  # rows without a metric (a drive's momentum) would grow as the rest shrinks
                        kept = memory[g + i] > 0.0 and memory[entry + i] != 0.0
                        z[w + i] = z[w + i] * (1.0 / memory[entry + i]) if kept else 0.0
                else:
                    for i in range(lanes):
                        z[w + i] -= memory[entry + i] * z[u + i]
    for first in range(2 * half, z.size // LANES, half):
        for r in range(n, half):
            for i in range(lanes):
                z[(first + r) * LANES + i] *= 1.0 - memory[ROWS.due * LANES + i]


@jit(constants=True)
def follow(n, k, lanes, memory):
    """Update the true vectors: columns = R columns, each normalised; the logarithm of its length is added to L."""
    at = parts_of(n, k, 0)
    for j in range(k):
        for b in range(j + 1):
            entry = (at.columns + b * k + j) * LANES
            for i in range(lanes):
                memory[entry + i] *= memory[(at.factor + b * k + b) * LANES + i]
            for c in range(b + 1, j + 1):
                for i in range(lanes):
                    memory[entry + i] += (
                        memory[(at.factor + b * k + c) * LANES + i] * memory[(at.columns + c * k + j) * LANES + i]
                    )
        for i in range(lanes):
            square = 0.0
            for b in range(j + 1):
                entry = (at.columns + b * k + j) * LANES + i
                square += memory[entry] * memory[entry]
            length = math.sqrt(square) if memory[ROWS.due * LANES + i] > 0.0 else 1.0
            memory[(at.lengths + j) * LANES + i] += log(length)
            for b in range(j + 1):
                memory[(at.columns + b * k + j) * LANES + i] /= length if length != 0.0 else 1.0


@jit(constants=True)
def grow(n, k, lanes, t, memory):
    """Update the values that follow from the growth L_0 of the first vector, before `follow`: the largest L_0, MEGNO
    and its mean.

    MEGNO is Y = (2/t) int s dL(s), Cincotta & Simo 2000, with s of the middle of each interval; its mean by the
    trapezoidal rule.
    """
    at = parts_of(n, k, 0)
    for i in range(lanes):
        on = memory[ROWS.due * LANES + i] > 0.0
        last = memory[ROWS.last * LANES + i]
        now = t[i]
        gained = log(memory[at.factor * LANES + i])
        weighted = memory[ROWS.weighted * LANES + i] + 0.5 * (last + now) * gained
        megno = 2.0 * weighted / now
        area = 0.5 * (megno + memory[ROWS.megno * LANES + i]) * (now - last)
        memory[ROWS.area * LANES + i] += area if on else 0.0
        memory[ROWS.weighted * LANES + i] = weighted if on else memory[ROWS.weighted * LANES + i]
        memory[ROWS.megno * LANES + i] = megno if on else memory[ROWS.megno * LANES + i]
        memory[ROWS.last * LANES + i] = now if on else last
    lengths = row(memory, at.lengths)
    crest(lanes, lengths, row(memory, ROWS.due), row(memory, ROWS.peak), row(memory, ROWS.largest))
    crest(lanes, lengths, row(memory, ROWS.due), row(memory, ROWS.peak_across), row(memory, ROWS.largest_across))


@jit
def crest(lanes, lengths, due, square, largest):
    """Keep the largest logarithm of a length in the lanes that are due: the largest square since they last were, on top
    of the length that the vector had then.
    """
    for i in range(lanes):
        growth = max(largest[i], lengths[i] + 0.5 * log(max(square[i], 1e-300)))
        largest[i] = growth if due[i] > 0.0 else largest[i]
        square[i] = 0.0 if due[i] > 0.0 else square[i]


@jit
def judge(value, n, k, lanes, orbit, t, memory, out, done):
    """Keep the values at half time, record the time when each reading first passes its threshold, write the history;
    return the number of lanes that are done.
    """
    m = int(value.readings)
    sums = int(value.sums)
    slots = value.slots
    time = value.time
    ended = 0
    at = parts_of(n, k, m)
    for i in range(lanes):
        if memory[ROWS.due * LANES + i] == 0.0:
            continue
        now = t[i] * (1.0 + 1e-12)
        if memory[ROWS.half * LANES + i] == 0.0 and now >= 0.5 * time:
            memory[ROWS.half * LANES + i] = t[i]
            for j in range(m):
                memory[(at.half_readings + j) * LANES + i] = memory[(at.readings + j) * LANES + i]
        passed = 0
        for j in range(m):
            entry = (at.detected + j) * LANES + i
            sign = memory[(at.signs + j) * LANES + i]
            beyond = memory[(at.readings + j) * LANES + i] - memory[(at.thresholds + j) * LANES + i]
            if memory[entry] == 0.0 and beyond * sign > 0.0:
                memory[entry] = t[i]
            passed += 1 if memory[entry] > 0.0 else 0
        slot = int(memory[ROWS.recorded * LANES + i])
        while slot < slots and now * slots >= (slot + 1) * time:
            o = orbit[i]
            c = slot * (1 + m + sums)
            out[o, c] = t[i]
            for j in range(m):
                out[o, c + 1 + j] = memory[(at.readings + j) * LANES + i]
            for j in range(sums):
                out[o, c + 1 + m + j] = memory[(at.sums + j) * LANES + i]
            slot += 1
        memory[ROWS.recorded * LANES + i] = slot
        if value.early_stop > 0.0 and passed == m:
            done[i] = 1.0
            ended += 1
    return ended


@jit(inline=True)
def deviations(value, calls, n, k, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: keep growth and alignment of the k tangent vectors of n degrees of freedom at every look, and judge
    orbits by readings of them.

    The first calls are the value.readings readings. `out` holds value.slots records of the time, the readings and the
    first value.sums sums.
    """
    peak(n, k, lanes, fresh, z, memory)
    if wait(value.time, value.forced, value.longest, lanes, fresh, t, memory) == 0:
        return 0
    orthonormalise(n, k, lanes, z, memory)
    grow(n, k, lanes, t, memory)
    follow(n, k, lanes, memory)
    m = int(value.readings)
    readings = parts_of(n, k, m).readings
    for j in range(m):
        call_reading(calls, j, n, k, m, lanes, row(memory, ROWS.due), memory, row(memory, readings + j))
    return judge(value, n, k, lanes, orbit, t, memory, out, done)


@jit(inline=True)
def deviations_across(value, calls, n, k, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: like `deviations`, also for the part across the flow; the last call gives the flow's direction."""
    flow = np.empty(2 * n * LANES)
    call_value(calls, int(value.readings), lanes, z, flow)
    peak_across(n, k, lanes, fresh, flow, z, memory)
    return deviations(value, calls, n, k, lanes, orbit, fresh, t, z, memory, out, done)
