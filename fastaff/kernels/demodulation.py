"""Kernels of loops: their values, their mean rates, and demodulated, weighted sums of a loop times exp(-2 pi i nu t),
whose ratios give the distance of its line from nu.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compile.jit import jit, read_now
from ..compile.plane_loops import angle_of
from .fundamental import BLOCK, fill_turns, rows_of, weighted_sum

CHUNK, PARTS = 512, BLOCK // 4
"""Samples of a loop that are demodulated at once, and partial sums."""


class Loops(NamedTuple):
    """Loops c . s - offset - drift j of signals s at sample j: c (orbits, loops, rows), offset, drift (orbits,
    loops).
    """

    c: np.ndarray
    offset: np.ndarray
    drift: np.ndarray

    def of(self, loops: slice) -> Loops:
        """Return some of the loops."""
        return Loops(*(entry[:, loops] for entry in self))

    def complexes(self) -> Loops:
        """Return the loops with complex coefficients, for kernels."""
        return Loops(*(np.ascontiguousarray(entry, dtype=np.complex128) for entry in self))


@jit
def add_products(weights, re, im, sums):
    """Add weights times re and im (samples,) to partial sums (2, PARTS)."""
    first, second, whole = sums[0], sums[1], weights.size // BLOCK * BLOCK
    for start in range(0, whole, BLOCK):
        w, x, y = weights[start : start + BLOCK], re[start : start + BLOCK], im[start : start + BLOCK]
        for i in range(PARTS):
            k, m, n = i + PARTS, i + 2 * PARTS, i + 3 * PARTS
            first[i] += (w[i] * x[i] + w[k] * x[k]) + (w[m] * x[m] + w[n] * x[n])
        for i in range(PARTS):  # a separate loop: LLVM proves only few arrays distinct in one
            k, m, n = i + PARTS, i + 2 * PARTS, i + 3 * PARTS
            second[i] += (w[i] * y[i] + w[k] * y[k]) + (w[m] * y[m] + w[n] * y[n])
    for i in range(whole, weights.size):
        first[i % PARTS] += weights[i] * re[i]
        second[i % PARTS] += weights[i] * im[i]


@jit
def add_rows(c, s, begin, end, re, im):
    """Add c . s, for samples begin to end of the rows s (rows, samples), to its parts re and im (end - begin,)."""
    r = 0
    while r < c.size:
        if c[r] == 0.0:
            r += 1
            continue
        other = r + 1
        while other < c.size and c[other] == 0.0:
            other += 1
        one, x, y = s[r, begin:end], c[r].real, c[r].imag
        if other < c.size:  # two rows at once halve the reads and writes of sums
            two, u, v = s[other, begin:end], c[other].real, c[other].imag
            for i in range(one.size):
                re[i] += x * one[i] + u * two[i]
                im[i] += y * one[i] + v * two[i]
        else:
            for i in range(one.size):
                re[i] += x * one[i]
                im[i] += y * one[i]
        r = other + 1


def demodulate(unit, stop, progress, signals, samples, loops, nu, interval, windows, places, sums):
    """Fill sums (orbits, loops, sums) with sum_j w_j f_j exp(-2 pi i nu t_j) of the loops f of an orbit.

    signals: the s of all orbits, see `rows_of`; the first `samples` (orbits,) of them count; nu (orbits, loops) in
    cycles per unit time, interval (orbits,); places, tables (sums, 3): place of the weights w of a sum among the
    windows of an orbit, their first sample and their number; time counts from the first sample. A loop with nu = 0 has
    sums of 0.
    """
    if read_now(stop, 0) > 0:
        return
    s, length, used = rows_of(signals, unit), samples[unit], sums.shape[2]
    weights, place = windows.numbers[windows.start[unit] :], places.numbers[places.start[unit] :]
    re, im, partial = np.empty(CHUNK), np.empty(CHUNK), np.empty((used, 2, PARTS))
    u, v, p, q = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    for k in range(loops.c.shape[1]):
        if nu[unit, k] == 0.0:
            continue
        c, a, b = loops.c[unit, k], loops.offset[unit, k], loops.drift[unit, k]
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
                for i in range(BLOCK):  # two loops: LLVM proves only few arrays distinct in one
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
            whole, other = 0.0, 0.0
            for i in range(PARTS):
                whole += partial[w, 0, i]
                other += partial[w, 1, i]
            sums[unit, k, w] = complex(whole, other)
    progress[unit] = 1.0


def turn(unit, stop, progress, signals, loops, windows, spans, rates):
    """Fill rates (orbits, loops, windows) with weighted mean angles per sample of the loops of an orbit.

    signals (orbits, rows, > steps); windows (windows, steps), each of sum 1 and 0 outside of its span; spans (windows,
    2), each beginning with a BLOCK.
    """
    if read_now(stop, 0) > 0:
        return
    s, steps = signals[unit], windows.shape[1]
    angles, re, im, sums = np.empty(steps), np.empty(CHUNK + 1), np.empty(CHUNK + 1), np.empty(BLOCK)
    for k in range(loops.c.shape[1]):
        offset, drift = loops.offset[unit, k], loops.drift[unit, k]
        for at in range(0, steps, CHUNK):
            width = min(CHUNK, steps - at)
            for i in range(width + 1):
                re[i] = -offset.real - drift.real * (at + i)
                im[i] = -offset.imag - drift.imag * (at + i)
            for r in range(s.shape[0]):
                c, row = loops.c[unit, k, r], s[r, at : at + width + 1]
                if c != 0.0:
                    for i in range(row.size):
                        re[i] += c.real * row[i]
                        im[i] += c.imag * row[i]
            angle = angles[at : at + width]
            for i in range(angle.size):
                x = re[i + 1] * re[i] + im[i + 1] * im[i]
                y = im[i + 1] * re[i] - re[i + 1] * im[i]
                angle[i] = angle_of(x, y)
        for w in range(windows.shape[0]):
            begin, end = spans[w]
            rates[unit, k, w] = weighted_sum(windows[w, begin:end], angles[begin:end], sums)
    progress[unit] = 1.0


def loop_values(unit, stop, progress, signals, orbits, number, loops, values):
    """Fill values (values, samples) with those of loops, given by the orbits (values,) and the loops' numbers (values,)
    there; signals: the s of all orbits, see `rows_of`.
    """
    if read_now(stop, 0) > 0:
        return
    o, k, value = orbits[unit], number[unit], values[unit]
    s, samples = rows_of(signals, o), value.size
    for i in range(samples):
        value[i] = -loops.offset[o, k] - loops.drift[o, k] * i
    for r in range(s.shape[0]):
        c, row = loops.c[o, k, r], s[r]
        if c != 0.0:
            for i in range(samples):
                value[i] += c * row[i]
    progress[unit] = 1.0
