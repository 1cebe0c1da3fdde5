"""Growth and alignment of tangent vectors, streamed: orthonormal vectors, and the coefficients of the true ones in them (layer L2).

The vectors of a state are kept orthonormal, W(t) = Q R_m ... R_1; S_i sums log R_ii, which is the volume's growth. The true vectors
are the columns of the triangular product: `columns` holds them normalised, with the logarithm L_j of each length. So
log GALI_k = sum_(i<k) (S_i - L_i) keeps all its digits below 1e-16, where vectors that align in memory could not be told apart.

Observer memory, in rows of LANES, for k vectors and m indicators: SHARED rows (see the constants), then S (k), S at half time (k),
L (k), columns (k*k), factor R (k*k), readings (m), times of detection (m).
"""

from __future__ import annotations

import math

from .._jit import LANES, jit

SHARED = 9
WAIT, DUE, LAST, WEIGHTED, AREA, MEGNO_NOW, LARGEST, LARGEST_ACROSS, RECORDED = range(SHARED)
"""Observations since the last one acted on; whether this one is; time of the last one; sum of t dL for MEGNO; integral of
MEGNO over time; MEGNO; largest L_0; largest log of the part of w_0 across the flow; history slots written."""


@jit
def place(k, m, what):
    """Return the first row of S (0), S at half time (1), L (2), columns (3), factor (4), readings (5), detections (6), end (7).

    The number m of readings only counts for what follows them.
    """
    rows = SHARED + k * min(what, 3)
    rows += k * k * max(0, min(what - 3, 2))
    return rows + m * max(0, what - 5)


@jit
def wait(stride, lanes, fresh, memory):
    """Mark the lanes whose vectors are due at this observation, every `stride`-th of an orbit; return how many."""
    due = 0.0
    for i in range(lanes):
        waited = memory[WAIT * LANES + i] + fresh[i]
        on = 1.0 if fresh[i] > 0.0 and waited >= stride else 0.0
        memory[WAIT * LANES + i] = 0.0 if on > 0.0 else waited
        memory[DUE * LANES + i] = on
        due += on
    return due


@jit(constants=True)
def orthonormalise(n, k, lanes, z, memory):
    """Make the k vectors of the due lanes orthonormal, in their order (modified Gram-Schmidt); R into memory, S summed.

    z holds n positions of the orbit and of each vector, then momenta likewise (and carried rounding errors, which vectors drop).
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
                for i in range(lanes):
                    memory[entry + i] += z[u + i] * z[w + i]
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
                    memory[entry + i] += memory[(factor + b * k + c) * LANES + i] * memory[(columns + c * k + j) * LANES + i]
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
def grow(k, half_time, lanes, t, memory):
    """Update what the growth L_0 of the first vector gives: the largest L_0, MEGNO and its mean; keep S at half time.

    MEGNO is Y = (2/t) int s dL(s), Cincotta & Simo 2000, with s of the middle of each interval; its mean by the trapezoidal rule.
    """
    sums, before, lengths, factor = place(k, 0, 0), place(k, 0, 1), place(k, 0, 2), place(k, 0, 4)
    for i in range(lanes):
        on = memory[DUE * LANES + i] > 0.0
        last, now = memory[LAST * LANES + i], t[i]
        gained = math.log(memory[factor * LANES + i])
        weighted = memory[WEIGHTED * LANES + i] + 0.5 * (last + now) * gained
        megno = 2.0 * weighted / now
        memory[AREA * LANES + i] += 0.5 * (megno + memory[MEGNO_NOW * LANES + i]) * (now - last) if on else 0.0
        memory[WEIGHTED * LANES + i] = weighted if on else memory[WEIGHTED * LANES + i]
        memory[MEGNO_NOW * LANES + i] = megno if on else memory[MEGNO_NOW * LANES + i]
        growth = memory[lengths * LANES + i]
        memory[LARGEST * LANES + i] = max(memory[LARGEST * LANES + i], growth) if on else memory[LARGEST * LANES + i]
        memory[LAST * LANES + i] = now if on else last
    for j in range(k):
        for i in range(lanes):
            early = memory[DUE * LANES + i] > 0.0 and t[i] <= half_time
            row = (before + j) * LANES + i
            memory[row] = memory[(sums + j) * LANES + i] if early else memory[row]


@jit
def across(k, i, along, memory):
    """Update the largest log of the part of the first vector across the flow; `along` is its cosine with the flow."""
    growth = memory[place(k, 0, 2) * LANES + i] + 0.5 * math.log(max(1.0 - along * along, 1e-300))
    if memory[DUE * LANES + i] > 0.0:
        memory[LARGEST_ACROSS * LANES + i] = max(memory[LARGEST_ACROSS * LANES + i], growth)


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
    """Return log10 of SALI of lane i: the shorter diagonal 2 sin(x/2) of two unit vectors at the angle x, sin x their area."""
    area = volume(2, k, i, memory)
    if area < -18.0:
        return area / LN10
    return math.log10(2.0 * math.sin(0.5 * math.asin(math.exp(area))))


@jit
def judge(k, m, limits, signs, early_stop, slots, time, lanes, orbit, t, memory, out, done):
    """Note when each reading first passes its limit, and write the history; return the lanes that are done."""
    readings, detections = place(k, m, 5), place(k, m, 6)
    ended = 0
    for i in range(lanes):
        if memory[DUE * LANES + i] == 0.0:
            continue
        passed = 0
        for j in range(m):
            row = (detections + j) * LANES + i
            if memory[row] == 0.0 and (memory[(readings + j) * LANES + i] - limits[j]) * signs[j] > 0.0:
                memory[row] = t[i]
            passed += 1 if memory[row] > 0.0 else 0
        slot = int(memory[RECORDED * LANES + i])
        if slot < slots and t[i] * slots >= (slot + 1) * time * (1.0 - 1e-12):
            o, c = orbit[i], slot * (m + 1)
            out[o, c] = t[i]
            for j in range(m):
                out[o, c + 1 + j] = memory[(readings + j) * LANES + i]
            memory[RECORDED * LANES + i] = slot + 1.0
        if early_stop > 0.0 and passed == m:
            done[i] = 1.0
            ended += 1
    return ended
