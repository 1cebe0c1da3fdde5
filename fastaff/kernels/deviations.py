"""Growth and alignment of tangent vectors, streamed: orthonormal vectors, and the coefficients of the true ones in
them.

The vectors of a state are kept orthonormal, W(t) = Q R_m ... R_1; S_i sums log R_ii, which is the volume's growth. The
true vectors are the columns of the triangular product: `columns` holds them normalised, with the logarithm L_j of each
length. So log GALI_k = sum_(i<k) (S_i - L_i) keeps all its digits below 1e-16, where vectors that align in memory could
not be told apart.

Lengths and angles are those of each orbit's own metric sum_r g_r w_r^2, which makes one of positions and momenta: a
plain sum of their squares would change with the units, and see growth where a long position only turns into a short
momentum.

Observer memory, in rows of LANES, for k vectors of 2n rows and m indicators: SHARED rows (see the constants), then S
(k), S at half time (k), L (k), columns (k*k), factor R (k*k), readings (m), readings at half time (m), limits (m),
times of detection (m), metric (2n).
"""

from __future__ import annotations

import math

from ..compile.jit import LANES, jit

SHARED = 13
SEEN, STRIDE, DUE, LAST, HALF, WEIGHTED, AREA, MEGNO_NOW, LARGEST, LARGEST_ACROSS, RECORDED, PEAK, PEAK_ACROSS = range(
    SHARED
)
"""Steps seen; how many steps apart the orbit's vectors are renormalised; whether this one is such; time of the last
one; time of the half-time values; sum of t dL for MEGNO; integral of MEGNO over time; MEGNO; largest L_0; largest log
of the part of w_0 across the flow; history slots written; largest square of the first vector since it was renormalised,
and of its part across the flow."""

LONGEST = 1e8
"""Square of the first vector's growth at which it is renormalised before its time."""


@jit
def place(k, m, what):
    """Return the first row of S (0), S at half time (1), L (2), columns (3), factor (4), readings (5), those at half
    time (6), ...

    ... limits (7), detections (8), metric (9). The number m of readings only counts for what follows them.
    """
    rows = SHARED + k * min(what, 3)
    rows += k * k * max(0, min(what - 3, 2))
    return rows + m * max(0, what - 5)


@jit(constants=True)
def peak(n, k, metric, lanes, fresh, z, memory):
    """Keep the largest square of the first vector since the last renormalisation."""
    half = n * (1 + k)
    for i in range(lanes):
        square = 0.0
        for r in range(2 * n):
            w = z[((n + r) if r < n else (half + r)) * LANES + i]
            square += memory[(metric + r) * LANES + i] * w * w
        largest = memory[PEAK * LANES + i]
        memory[PEAK * LANES + i] = square if fresh[i] > 0.0 and square > largest else largest


@jit
def peak_across(i, square, along, size, memory):
    """Keep the largest square of the first vector's part across the flow, of its square, product with the flow, the
    flow's square.
    """
    across = square - along * along / size if size > 0.0 else square
    memory[PEAK_ACROSS * LANES + i] = max(memory[PEAK_ACROSS * LANES + i], across)


@jit
def wait(time, slots, lanes, fresh, t, memory):
    """Mark the lanes whose vectors are due at this step; return how many.

    Every STRIDE-th step of an orbit, its first one past half time, past the next record of the history and at the end,
    and where the first vector has grown long.
    """
    due = 0.0
    for i in range(lanes):
        seen = memory[SEEN * LANES + i] + fresh[i]
        stride, recorded, now = memory[STRIDE * LANES + i], memory[RECORDED * LANES + i], t[i] * (1.0 + 1e-12)
        on = seen - stride * math.floor(seen / stride) == 0.0 or now >= time or memory[PEAK * LANES + i] > LONGEST
        on = on or (memory[HALF * LANES + i] == 0.0 and now >= 0.5 * time)
        on = on or (recorded < slots and now * slots >= (recorded + 1.0) * time)
        on = on and fresh[i] > 0.0
        memory[SEEN * LANES + i] = seen
        memory[DUE * LANES + i] = 1.0 if on else 0.0
        due += memory[DUE * LANES + i]
    return due


@jit(constants=True)
def orthonormalise(n, k, metric, lanes, z, memory):
    """Make the k vectors of the due lanes orthonormal in the metric, in their order (modified Gram-Schmidt); R into
    memory, S summed.

    z holds n positions of the orbit and of each vector, then momenta likewise (and carried rounding errors, which
    vectors drop).
    """
    half, sums, factor = n * (1 + k), place(k, 0, 0), place(k, 0, 4)
    for j in range(k):
        for b in range(j + 1):
            entry = (factor + b * k + j) * LANES
            for i in range(lanes):
                memory[entry + i] = 0.0
            for r in range(2 * n):
                first = (r if r < n else half + r - n) * LANES
                u, w = first + n * (1 + b) * LANES, first + n * (1 + j) * LANES
                g = (metric + r) * LANES
                for i in range(lanes):
                    memory[entry + i] += memory[g + i] * z[u + i] * z[w + i]
            if b == j:
                for i in range(lanes):
                    memory[entry + i] = math.sqrt(memory[entry + i]) if memory[DUE * LANES + i] > 0.0 else 1.0
                for i in range(lanes):
                    memory[(sums + j) * LANES + i] += math.log(memory[entry + i])
            else:
                for i in range(lanes):
                    memory[entry + i] = memory[entry + i] if memory[DUE * LANES + i] > 0.0 else 0.0
            for r in range(2 * n):
                first = (r if r < n else half + r - n) * LANES
                u, w = first + n * (1 + b) * LANES, first + n * (1 + j) * LANES
                if b == j:
                    for i in range(lanes):
                        z[w + i] *= 1.0 / memory[entry + i]
                else:
                    for i in range(lanes):
                        z[w + i] -= memory[entry + i] * z[u + i]
    for first in range(4 * half, z.size // LANES, half):
        for r in range(n, half):
            for i in range(lanes):
                z[(first + r) * LANES + i] = 0.0


@jit(constants=True)
def follow(k, lanes, memory):
    """Carry the true vectors along: columns = R columns, each normalised, the logarithm of its length added to L."""
    lengths, columns, factor = place(k, 0, 2), place(k, 0, 3), place(k, 0, 4)
    for j in range(k):
        for b in range(j + 1):
            entry = (columns + b * k + j) * LANES
            for i in range(lanes):
                memory[entry + i] *= memory[(factor + b * k + b) * LANES + i]
            for c in range(b + 1, j + 1):
                for i in range(lanes):
                    memory[entry + i] += (
                        memory[(factor + b * k + c) * LANES + i] * memory[(columns + c * k + j) * LANES + i]
                    )
        for i in range(lanes):
            square = 0.0
            for b in range(j + 1):
                entry = (columns + b * k + j) * LANES + i
                square += memory[entry] * memory[entry]
            length = math.sqrt(square) if memory[DUE * LANES + i] > 0.0 else 1.0
            memory[(lengths + j) * LANES + i] += math.log(length)
            for b in range(j + 1):
                memory[(columns + b * k + j) * LANES + i] /= length


@jit(constants=True)
def grow(k, lanes, t, memory):
    """Update what the growth L_0 of the first vector gives, before and after `follow`: the largest L_0, MEGNO and its
    mean.

    MEGNO is Y = (2/t) int s dL(s), Cincotta & Simo 2000, with s of the middle of each interval; its mean by the
    trapezoidal rule.
    """
    lengths, factor = place(k, 0, 2), place(k, 0, 4)
    for i in range(lanes):
        on = memory[DUE * LANES + i] > 0.0
        last, now = memory[LAST * LANES + i], t[i]
        gained = math.log(memory[factor * LANES + i])
        weighted = memory[WEIGHTED * LANES + i] + 0.5 * (last + now) * gained
        megno = 2.0 * weighted / now
        memory[AREA * LANES + i] += 0.5 * (megno + memory[MEGNO_NOW * LANES + i]) * (now - last) if on else 0.0
        memory[WEIGHTED * LANES + i] = weighted if on else memory[WEIGHTED * LANES + i]
        memory[MEGNO_NOW * LANES + i] = megno if on else memory[MEGNO_NOW * LANES + i]
        memory[LAST * LANES + i] = now if on else last
        # The peaks are those since the last time: on top of the length that the vector had then.
        for row, largest in ((PEAK, LARGEST), (PEAK_ACROSS, LARGEST_ACROSS)):
            if on:
                growth = memory[lengths * LANES + i] + 0.5 * math.log(max(memory[row * LANES + i], 1e-300))
                memory[largest * LANES + i] = max(memory[largest * LANES + i], growth)
                memory[row * LANES + i] = 0.0


LN10 = math.log(10.0)


@jit(constants=True)
def volume(count, k, i, memory):
    """Return the logarithm of the volume of the first `count` normalised true vectors of lane i."""
    total = 0.0
    for j in range(count):
        total += memory[(place(k, 0, 0) + j) * LANES + i] - memory[(place(k, 0, 2) + j) * LANES + i]
    return min(total, 0.0)


@jit(constants=True)
def alignment(k, i, memory):
    """Return log10 of SALI of lane i: the shorter diagonal 2 sin(x/2) of two unit vectors at the angle x, sin x their
    area.
    """
    area = volume(2, k, i, memory)
    if area < -18.0:
        return area / LN10
    return math.log10(2.0 * math.sin(0.5 * math.asin(math.exp(area))))


@jit
def judge(k, m, signs, early_stop, slots, time, lanes, orbit, t, memory, out, done):
    """Keep the values at half time, note when each reading first passes its limit, write the history; return the lanes
    that are done.
    """
    readings, middle, limits, detections = place(k, m, 5), place(k, m, 6), place(k, m, 7), place(k, m, 8)
    sums, before = place(k, m, 0), place(k, m, 1)
    ended = 0
    for i in range(lanes):
        if memory[DUE * LANES + i] == 0.0:
            continue
        now = t[i] * (1.0 + 1e-12)
        if memory[HALF * LANES + i] == 0.0 and now >= 0.5 * time:
            memory[HALF * LANES + i] = t[i]
            for j in range(k):
                memory[(before + j) * LANES + i] = memory[(sums + j) * LANES + i]
            for j in range(m):
                memory[(middle + j) * LANES + i] = memory[(readings + j) * LANES + i]
        passed = 0
        for j in range(m):
            row = (detections + j) * LANES + i
            if (
                memory[row] == 0.0
                and (memory[(readings + j) * LANES + i] - memory[(limits + j) * LANES + i]) * signs[j] > 0.0
            ):
                memory[row] = t[i]
            passed += 1 if memory[row] > 0.0 else 0
        slot = int(memory[RECORDED * LANES + i])
        if slot < slots and now * slots >= (slot + 1) * time:
            o, c = orbit[i], slot * (m + 1)
            out[o, c] = t[i]
            for j in range(m):
                out[o, c + 1 + j] = memory[(readings + j) * LANES + i]
            memory[RECORDED * LANES + i] = slot + 1.0
        if early_stop > 0.0 and passed == m:
            done[i] = 1.0
            ended += 1
    return ended
