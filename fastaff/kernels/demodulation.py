"""Kernels of demodulated loops: weighted sums of a loop times exp(-2 pi i nu t), whose ratios say by how much its line
is off nu.
"""

from __future__ import annotations

import math

import numpy as np

from ..compile.jit import jit, read_now
from .fundamental import BLOCK, fill_turns, rows_of

CHUNK, PARTS = 512, BLOCK // 4
"""Samples of a loop that are demodulated at once, and partial sums."""


@jit
def add_products(weights, re, im, sums):
    """Add weights times re and im (samples,) to partial sums (2, PARTS)."""
    first, second, whole = sums[0], sums[1], weights.size // BLOCK * BLOCK
    for start in range(0, whole, BLOCK):
        w, x, y = weights[start : start + BLOCK], re[start : start + BLOCK], im[start : start + BLOCK]
        for i in range(PARTS):
            k, m, n = i + PARTS, i + 2 * PARTS, i + 3 * PARTS
            first[i] += (w[i] * x[i] + w[k] * x[k]) + (w[m] * x[m] + w[n] * x[n])
            second[i] += (w[i] * y[i] + w[k] * y[k]) + (w[m] * y[m] + w[n] * y[n])
    for i in range(whole, weights.size):
        first[i % PARTS] += weights[i] * re[i]
        second[i % PARTS] += weights[i] * im[i]


@jit
def add_rows(c, s, begin, end, re, im):
    """Add c . s, of the rows s (rows, samples) from begin to end, to its parts re and im (end - begin,)."""
    r = 0
    while r < c.size:
        if c[r] == 0.0:
            r += 1
            continue
        other = r + 1
        while other < c.size and c[other] == 0.0:
            other += 1
        one, x, y = s[r, begin:end], c[r].real, c[r].imag
        if other < c.size:  # two rows at once: what is read and written of sums is half as much
            two, u, v = s[other, begin:end], c[other].real, c[other].imag
            for i in range(one.size):
                re[i] += x * one[i] + u * two[i]
                im[i] += y * one[i] + v * two[i]
        else:
            for i in range(one.size):
                re[i] += x * one[i]
                im[i] += y * one[i]
        r = other + 1


def demodulate(
    unit,
    stop,
    progress,
    signals,
    samples,
    loops,
    offset,
    drift,
    nu,
    interval,
    tables,
    table_start,
    places,
    place_start,
    sums,
):
    """Fill sums (orbits, loops, sums) with sum_j w_j f_j exp(-2 pi i nu t_j) of the loops f = c . s - offset - drift j
    of an orbit.

    signals: the s of all, see `rows_of`, of which the first samples (orbits,) are taken; loops
    (orbits, loops, rows); nu (orbits, loops) in cycles per unit time, interval (orbits,); places, from an orbit's
    place_start on (sums, 3): where in tables, from its table_start on, the weights w of a sum are, at which sample they
    begin and how many they are; time counts from the first sample. A loop with nu = 0 has sums of 0.
    """
    if read_now(stop, 0) > 0:
        return
    s, length, used = rows_of(signals, unit), samples[unit], sums.shape[2]
    weights, place = tables[table_start[unit] :], places[place_start[unit] :]
    re, im, partial = np.empty(CHUNK), np.empty(CHUNK), np.empty((used, 2, PARTS))
    u, v, p, q = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    for k in range(loops.shape[1]):
        if nu[unit, k] == 0.0:
            continue
        c, a, b = loops[unit, k], offset[unit, k], drift[unit, k]
        turn = 2.0 * math.pi * nu[unit, k] * interval[unit]
        partial[:] = 0.0
        fill_turns(-turn, u, v)
        for at in range(0, length, CHUNK):
            width = min(CHUNK, length - at)
            for i in range(width):
                re[i], im[i] = -a.real, -a.imag
            if b != 0.0:
                for i in range(width):
                    re[i] -= b.real * (at + i)
                    im[i] -= b.imag * (at + i)
            add_rows(c, s, at, at + width, re, im)
            for first in range(0, width, BLOCK):
                x, y = math.cos(turn * (at + first)), -math.sin(turn * (at + first))
                f, g = re[first : min(first + BLOCK, width)], im[first : min(first + BLOCK, width)]
                for i in range(BLOCK):  # two loops: LLVM keeps few arrays apart in one
                    p[i] = u[i] * x - v[i] * y
                    q[i] = u[i] * y + v[i] * x
                for i in range(f.size):
                    value, other = f[i] * p[i] - g[i] * q[i], f[i] * q[i] + g[i] * p[i]
                    f[i], g[i] = value, other
            for w in range(used):
                first = place[3 * w + 1] - at
                begin, end = max(first, 0), min(first + place[3 * w + 2], width)
                if begin < end:
                    own = place[3 * w] - first
                    add_products(weights[own + begin : own + end], re[begin:end], im[begin:end], partial[w])
        for w in range(used):
            sums[unit, k, w] = complex(partial[w, 0].sum(), partial[w, 1].sum())
    progress[unit] = 1.0
