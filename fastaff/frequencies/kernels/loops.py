"""Kernels of loops: their values and their mean rates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...engine.jit import jit, read_now
from ...engine.plane_loops import angle_of
from .fundamental import BLOCK, rows_of, weighted_sum

CHUNK = 512
"""Samples of a loop that are read at once."""


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
        one = s[r, begin:end]
        x = c[r].real
        y = c[r].imag
        if other < c.size:  # two rows at once halve the reads and writes of sums
            two = s[other, begin:end]
            u = c[other].real
            v = c[other].imag
            for i in range(one.size):
                re[i] += x * one[i] + u * two[i]
                im[i] += y * one[i] + v * two[i]
        else:
            for i in range(one.size):
                re[i] += x * one[i]
                im[i] += y * one[i]
        r = other + 1


def turn(unit, stop, progress, signals, loops, windows, spans, rates):
    """Fill rates (orbits, loops, windows) with weighted mean angles per sample of the loops of an orbit.

    signals (orbits, rows, > steps); windows (windows, steps), each of sum 1 and 0 outside of its span; spans (windows,
    2), each beginning with a BLOCK.
    """
    if read_now(stop, 0) > 0:
        return
    s = signals[unit]
    steps = windows.shape[1]
    angles = np.empty(steps)
    re = np.empty(CHUNK + 1)
    im = np.empty(CHUNK + 1)
    sums = np.empty(BLOCK)
    for k in range(loops.c.shape[1]):
        offset = loops.offset[unit, k]
        drift = loops.drift[unit, k]
        for at in range(0, steps, CHUNK):
            width = min(CHUNK, steps - at)
            for i in range(width + 1):
                re[i] = -offset.real - drift.real * (at + i)
                im[i] = -offset.imag - drift.imag * (at + i)
            for r in range(s.shape[0]):
                c = loops.c[unit, k, r]
                row = s[r, at : at + width + 1]
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
    o = orbits[unit]
    k = number[unit]
    value = values[unit]
    s = rows_of(signals, o)
    samples = value.size
    for i in range(samples):
        value[i] = -loops.offset[o, k] - loops.drift[o, k] * i
    for r in range(s.shape[0]):
        c = loops.c[o, k, r]
        row = s[r]
        if c != 0.0:
            for i in range(samples):
                value[i] += c * row[i]
    progress[unit] = 1.0
