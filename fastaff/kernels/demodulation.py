"""Kernels of demodulated loops: weighted sums of a loop times exp(-2 pi i nu t), whose ratios say by how much its line
is off nu.
"""

from __future__ import annotations

import math

import numpy as np

from ..compile.jit import jit, read_now
from .fundamental import BLOCK, total


@jit
def add_products(weights, re, im, count, sums):
    """Add weights times re and im, of so many samples, to partial sums (2, BLOCK)."""
    first, second = sums[0], sums[1]
    for i in range(count):
        first[i] += weights[i] * re[i]
        second[i] += weights[i] * im[i]


def demodulate(unit, stop, progress, signals, loops, offset, drift, nu, interval, tables, ends, sums):
    """Fill sums (orbits, loops, tables) with sum_j tables[., j] f_j exp(-2 pi i nu t_j) of the loops f = c . s -
    offset - drift j of an orbit.

    signals (orbits, rows, samples); loops (orbits, loops, rows); nu (orbits, loops) in cycles per unit time; tables
    (tables, samples), which are 0 outside of ends (tables, 2); time counts from the first sample. A loop with nu = 0
    has sums of 0.
    """
    if read_now(stop, 0) > 0:
        return
    s, samples, count = signals[unit], tables.shape[1], tables.shape[0]
    re, im, fr, fi = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    wave, partial = np.empty((2, BLOCK)), np.empty((count, 2, BLOCK))
    for k in range(loops.shape[1]):
        if nu[unit, k] == 0.0:
            continue
        c, a, b = loops[unit, k], offset[unit, k], drift[unit, k]
        turn = 2.0 * math.pi * nu[unit, k] * interval
        partial[:] = 0.0
        for i in range(BLOCK):
            wave[0, i], wave[1, i] = math.cos(turn * i), -math.sin(turn * i)
        for start in range(0, samples, BLOCK):
            width = min(BLOCK, samples - start)
            for i in range(width):
                fr[i] = -a.real - b.real * (start + i)
                fi[i] = -a.imag - b.imag * (start + i)
            for r in range(c.size):
                x, y = c[r].real, c[r].imag
                if x != 0.0 or y != 0.0:
                    row = s[r, start : start + width]
                    for i in range(width):
                        fr[i] += x * row[i]
                        fi[i] += y * row[i]
            x, y = math.cos(turn * start), -math.sin(turn * start)
            u, v = wave[0], wave[1]
            for i in range(width):
                p, q = u[i] * x - v[i] * y, u[i] * y + v[i] * x
                re[i] = fr[i] * p - fi[i] * q
                im[i] = fr[i] * q + fi[i] * p
            for w in range(count):
                if start < ends[w, 1] and start + width > ends[w, 0]:
                    add_products(tables[w, start : start + width], re, im, width, partial[w])
        for w in range(count):
            sums[unit, k, w] = complex(total(partial[w, 0]), total(partial[w, 1]))
    progress[unit] = 1.0
