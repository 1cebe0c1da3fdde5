"""One step of a scheme for a block of lanes. State blocks are flat: row r of lane i is z[r*LANES + i]."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..compile.jit import LANES, jit
from ..compile.pointers import call, caller

LINE = 64
"""Bytes of a cache line, and of the widest vector registers."""


class Blocks(NamedTuple):
    """A model and a scheme's step as kernels see them: parameters and block functions, idle ones where a run has no use
    for them, and the addresses of the derivative and, of a model with poles, of what sees steps across them, or 0.
    """

    params: np.ndarray
    splitting: Any
    march: Any
    step: Any
    inside: Any
    check: Any
    derivative: int = 0
    leapt: int = 0


class Coefficients(NamedTuple):
    """A scheme as kernels see it: the coefficients of a splitting, or of a Runge-Kutta tableau with those of its error
    estimates and its interpolant; `copies`: how many times its rows a state takes, 3 where a splitting works on
    increments; `spare`: rows behind the state that it takes. Of a collocation, which makes up to so many `sweeps`, a is
    in the form of `schemes.Collocation` and dense that of its first sweep.
    """

    drift: np.ndarray = np.zeros(1)
    kick: np.ndarray = np.zeros(0)
    a: np.ndarray = np.zeros((0, 0))
    b: np.ndarray = np.zeros(0)
    errors: np.ndarray = np.zeros((0, 0))
    dense: np.ndarray = np.zeros((0, 0))
    copies: int = 1
    spare: int = 0
    sweeps: int = 0


@jit
def room(rows):
    """Return zeros for so many rows of a block (rows*LANES), from the beginning of a cache line.

    Arrays begin at multiples of 16 or 32 bytes, at others in each process: vectors that lie across two lines take up
    to two thirds longer.
    """
    whole = np.zeros(rows * LANES + LINE // 8)
    first = (-whole.ctypes.data % LINE) // 8
    return whole[first : first + rows * LANES]


@jit
def stretch(rows, lanes):
    """Return how far apart the beginnings of stretches of neighbours are that a loop over all rows goes through, and
    how long they are: rows of so many lanes, or of a nearly full block all at once, as a loop takes time to begin.
    """
    return (LANES, lanes) if lanes < 3 * LANES // 4 else (rows * LANES, rows * LANES)


@jit
def keep(rows, lanes, source, target):
    """Copy the rows of lanes."""
    apart, length = stretch(rows, lanes)
    for at in range(0, rows * LANES, apart):
        own, other = source[at : at + length], target[at : at + length]
        for i in range(length):
            other[i] = own[i]


@jit
def combine(rows, lanes, first, last, coefficients, k, total):
    """Set total = sum of coefficients[s] * k[s] over first <= s < last, in the order of s, without those that are 0.

    Eight or four of them at a time: what is stored between two takes longer than the sums.
    """
    size, begun, s = rows * LANES, 0, first
    apart, length = stretch(rows, lanes)
    terms = np.empty(8, np.int64)
    while s < last or begun == 0:
        found = 0
        while s < last and found < 8:
            if coefficients[s] != 0.0:
                terms[found] = s
                found += 1
            s += 1
        eight = found == 8
        fours = 0 if eight else found // 4
        if eight:
            add_eight(rows, lanes, terms, coefficients, k, total, begun)
        else:
            if begun == 0 and found == 0:
                for r in range(rows):
                    for i in range(lanes):
                        total[r * LANES + i] = 0.0
            if fours:
                add_four(rows, lanes, terms, coefficients, k, total, begun)
            for t in range(4 * fours, found):
                c = coefficients[terms[t]]
                begin = terms[t] * size
                new = begun == 0 and t == 0
                for at in range(0, size, apart):
                    ks, sums = k[begin + at : begin + at + length], total[at : at + length]
                    for i in range(length):
                        sums[i] = (0.0 if new else sums[i]) + c * ks[i]
        begun = 1


@jit
def add_four(rows, lanes, terms, coefficients, k, total, begun):
    """Add four terms to a sum, or begin it."""
    size = rows * LANES
    s0, s1, s2, s3 = terms[0], terms[1], terms[2], terms[3]
    c0, c1, c2, c3 = coefficients[s0], coefficients[s1], coefficients[s2], coefficients[s3]
    apart, length = stretch(rows, lanes)
    for at in range(0, size, apart):
        to, sums = at + length, total[at : at + length]
        k0, k1 = k[s0 * size + at : s0 * size + to], k[s1 * size + at : s1 * size + to]
        k2, k3 = k[s2 * size + at : s2 * size + to], k[s3 * size + at : s3 * size + to]
        for i in range(length):
            sum = (0.0 if begun == 0 else sums[i]) + c0 * k0[i]
            sums[i] = ((sum + c1 * k1[i]) + c2 * k2[i]) + c3 * k3[i]


@jit
def add_eight(rows, lanes, terms, coefficients, k, total, begun):
    """Add eight terms to a sum, or begin it."""
    size = rows * LANES
    s0, s1, s2, s3, s4, s5, s6, s7 = terms[0], terms[1], terms[2], terms[3], terms[4], terms[5], terms[6], terms[7]
    c0, c1, c2, c3 = coefficients[s0], coefficients[s1], coefficients[s2], coefficients[s3]
    c4, c5, c6, c7 = coefficients[s4], coefficients[s5], coefficients[s6], coefficients[s7]
    apart, length = stretch(rows, lanes)
    for at in range(0, size, apart):
        to, sums = at + length, total[at : at + length]
        k0, k1 = k[s0 * size + at : s0 * size + to], k[s1 * size + at : s1 * size + to]
        k2, k3 = k[s2 * size + at : s2 * size + to], k[s3 * size + at : s3 * size + to]
        k4, k5 = k[s4 * size + at : s4 * size + to], k[s5 * size + at : s5 * size + to]
        k6, k7 = k[s6 * size + at : s6 * size + to], k[s7 * size + at : s7 * size + to]
        for i in range(length):
            sum = (0.0 if begun == 0 else sums[i]) + c0 * k0[i]
            sum = ((sum + c1 * k1[i]) + c2 * k2[i]) + c3 * k3[i]
            sums[i] = (((sum + c4 * k4[i]) + c5 * k5[i]) + c6 * k6[i]) + c7 * k7[i]


call_derivative, call_leapt = caller("derivative"), caller("leapt")


@jit
def look_back(blocks, lanes, begin, z, code):
    """Set the code of lanes that have passed a pole in a step from `begin` to z, of a model that has some."""
    if blocks.leapt != 0:
        call_leapt(blocks.leapt, blocks.params, lanes, begin, z, code)


@jit
def runge_kutta_stages(derivative, params, a, first, last, rows, lanes, step, z, k, work):
    """Fill the slopes k[first:last] (stages, rows*LANES) of an explicit tableau a at the state z, by the derivative at
    that address.
    """
    size = rows * LANES
    for s in range(first, last):
        combine(rows, lanes, 0, s, a[s], k, work)
        for r in range(rows):
            for i in range(lanes):
                work[r * LANES + i] = z[r * LANES + i] + step[i] * work[r * LANES + i]
        call_derivative(derivative, params, lanes, work, k[s * size : (s + 1) * size])


@jit
def runge_kutta(derivative, params, lanes, rows, a, b, dense, sweeps, step, z, k, work):
    """Take one step of an explicit tableau."""
    runge_kutta_stages(derivative, params, a, 0, b.size, rows, lanes, step, z, k, work)
    combine(rows, lanes, 0, b.size, b, k, work)
    for r in range(rows):
        for i in range(lanes):
            z[r * LANES + i] += step[i] * work[r * LANES + i]
    return 1


@jit
def advance(blocks, scheme, rows, lanes, step, steps, z, k, work):
    """Advance z by steps of the scheme, step[i] in lane i: a splitting where it has kicks, else a collocation or a
    Runge-Kutta tableau.

    Returns how many were taken: a splitting stops at one with which a lane leaves the domain, the others after each.
    Where z has room for increments and carried errors, the splitting works on increments.
    """
    if scheme.kick.size > 0:
        return call(blocks.splitting, blocks.params, lanes, scheme.drift, scheme.kick, step, steps, z)
    a, b, dense, sweeps = scheme.a, scheme.b, scheme.dense, scheme.sweeps
    return call(blocks.step, blocks.derivative, blocks.params, lanes, rows, a, b, dense, sweeps, step, z, k, work)


@jit
def move_lane(rows, source, target, block):
    """Copy all rows of one lane over another lane of the same block."""
    for r in range(rows):
        block[r * LANES + target] = block[r * LANES + source]


@jit
def load_lane(table, column, block, lane):
    """Copy a column of table (rows, orbits) into a lane."""
    for r in range(table.shape[0]):
        block[r * LANES + lane] = table[r, column]


@jit
def store_lane(block, lane, table, column):
    """Copy a lane into a column of table (rows, orbits)."""
    for r in range(table.shape[0]):
        table[r, column] = block[r * LANES + lane]


@jit
def row(block, number):
    """Return the numbered row (LANES,) of a flat block."""
    return block[number * LANES : (number + 1) * LANES]
