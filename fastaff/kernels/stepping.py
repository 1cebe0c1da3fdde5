"""One step of a scheme for a block of lanes. State blocks are flat: row r of lane i is z[r*LANES + i]."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..compile.fused import fma
from ..compile.jit import LANES, jit
from ..compile.pointers import caller

LINE = 64
"""Bytes of a cache line, and of the widest vector registers."""


class Blocks(NamedTuple):
    """A model and a scheme's step as kernels see them: parameters and block functions, idle ones where a run has no use
    for them, and the address of the derivative, 0 likewise.
    """

    params: np.ndarray
    splitting: Any
    march: Any
    step: Any
    inside: Any
    check: Any
    derivative: int = 0


class Coefficients(NamedTuple):
    """A scheme as kernels see it: the coefficients of a splitting, or of a Runge-Kutta tableau with those of its error
    estimates and its interpolant; `copies`: how many times its rows a state takes, 3 where a splitting works on
    increments; `spare`: rows behind the state that it takes. Of a collocation, which makes up to so many `sweeps`, a is
    in the form of `schemes.Collocation` and dense extrapolates its slopes.
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
def combine(rows, lanes, first, last, coefficients, k, total):
    """Set total = sum of coefficients[s] * k[s] over first <= s < last, in the order of s."""
    size = rows * LANES
    for r in range(rows):
        for i in range(lanes):
            total[r * LANES + i] = 0.0
    for s in range(first, last):
        if coefficients[s] != 0.0:
            for r in range(rows):
                row = r * LANES
                ks = k[s * size + row : s * size + row + lanes]
                for i in range(lanes):
                    total[row + i] += coefficients[s] * ks[i]


call_derivative = caller("derivative")


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


SETTLED = 2.0**-36
"""Change of a sweep, beside the largest numbers of its half of a state, above which no iteration has converged."""


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
def collocate(derivative, params, lanes, rows, a, b, dense, sweeps, step, z, k, work):
    """Take one step of a collocation: z, its carried rounding errors, the parts L_s = h b_s f(Y_s) of the step before.

    Y_s = z + sum of a[s, j] L_j is iterated stage after stage, from parts that are extrapolated from the step before,
    until in all rows of a lane the change has stopped to fall: it is rounding then, and the lane is frozen while others
    go on. Where it is not within so many sweeps, z becomes NaN and its carried errors inf. The parts are summed with
    the rounding errors carried over (Kahan's summation).

    Source: Hairer, Lubich & Wanner, Geometric Numerical Integration, 2nd ed. 2006, VIII.6; Antonana, Makazaga & Murua,
    Numer. Algorithms 76 (2017) 861 (form of a, stopping); Hairer, McLachlan & Razakarivony, BIT 48 (2008) 231.
    """
    size, stages, half = rows * LANES, b.size, rows // 2
    carried, parts = z[size : 2 * size], z[2 * size :]
    slope, change, least = k[:size], k[size : 2 * size], k[2 * size : 3 * size]
    going, large, new = room(1), room(1), room(stages)
    for r in range(rows):
        row = r * LANES
        for j in range(stages * LANES):
            new[j] = 0.0
        for s in range(stages):
            for t in range(stages):
                for i in range(lanes):
                    new[s * LANES + i] += dense[s, t] * parts[t * size + row + i]
        for s in range(stages):
            for i in range(lanes):
                parts[s * size + row + i] = new[s * LANES + i]
        for i in range(lanes):
            least[row + i] = np.inf
    for i in range(lanes):
        going[i] = 1.0
    count = lanes
    for _ in range(sweeps):
        for j in range(size):
            change[j] = 0.0
        for s in range(stages):
            for r in range(rows):
                row = r * LANES
                for i in range(lanes):
                    work[row + i] = carried[row + i]
                for j in range(0, stages, 4):
                    a0, a1, a2, a3 = a[s, j], a[s, j + 1], a[s, j + 2], a[s, j + 3]
                    at = j * size + row
                    for i in range(lanes):
                        first = fma(a1, parts[at + size + i], a0 * parts[at + i])
                        last = fma(a3, parts[at + 3 * size + i], a2 * parts[at + 2 * size + i])
                        work[row + i] += first + last
                for i in range(lanes):
                    work[row + i] += z[row + i]
            call_derivative(derivative, params, lanes, work, slope)
            for r in range(rows):
                row, at = r * LANES, s * size + r * LANES
                for i in range(lanes):
                    part = step[i] * b[s] * slope[row + i]
                    moved = abs(part - parts[at + i])
                    change[row + i] = change[row + i] if change[row + i] >= moved else moved
                    parts[at + i] = part if going[i] > 0.0 else parts[at + i]
        for i in range(lanes):
            large[i] = going[i]
            going[i] = 0.0
        for first in range(0, rows, half):
            for i in range(lanes):
                most, falls, whole = 0.0, 0.0, 0.0
                for r in range(first, first + half):
                    j = r * LANES + i
                    falls = 1.0 if (change[j] > 0.0) & (change[j] < least[j]) else falls
                    least[j] = change[j] if change[j] < least[j] else least[j]
                    most = max(most, change[j])
                    whole = max(whole, abs(z[j]) + abs(work[j]))
                falls = falls if most <= SETTLED * whole else 1.0
                going[i] = large[i] if falls > 0.0 else going[i]
        count = 0
        for i in range(lanes):
            count += 1 if going[i] > 0.0 else 0
        if count == 0:
            break
    for r in range(rows):
        row = r * LANES
        for i in range(lanes):
            work[row + i] = carried[row + i]
        for s in range(stages):
            for i in range(lanes):
                work[row + i] += parts[s * size + row + i]
        for i in range(lanes):
            total = z[row + i] + work[row + i]
            carried[row + i] = work[row + i] - (total - z[row + i])
            z[row + i] = total
    for i in range(lanes):
        whole = going[i]
        for r in range(rows):
            whole += 0.0 * z[r * LANES + i]
        if whole != 0.0:
            for r in range(rows):
                z[r * LANES + i], carried[r * LANES + i] = np.nan, np.inf
    return 1


@jit
def advance(blocks, scheme, rows, lanes, step, steps, z, k, work):
    """Advance z by steps of the scheme, step[i] in lane i: a splitting where it has kicks, else a collocation or a
    Runge-Kutta tableau.

    Returns how many were taken: a splitting stops at one with which a lane leaves the domain, the others after each.
    Where z has room for increments and carried errors, the splitting works on increments.
    """
    if scheme.kick.size > 0:
        return blocks.splitting(blocks.params, lanes, scheme.drift, scheme.kick, step, steps, z)
    a, b, dense = scheme.a, scheme.b, scheme.dense
    return blocks.step(blocks.derivative, blocks.params, lanes, rows, a, b, dense, scheme.sweeps, step, z, k, work)


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
