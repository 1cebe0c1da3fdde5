"""One step of a scheme for a block of lanes. State blocks are flat: row r of lane i is z[r*LANES + i]."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..compile.jit import LANES, jit

LINE = 64
"""Bytes of a cache line, and of the widest vector registers."""


class Blocks(NamedTuple):
    """A model as kernels see it: its parameters and its block functions, idle ones where a run has no use for them."""

    params: np.ndarray
    splitting: Any
    march: Any
    derivative: Any
    inside: Any
    check: Any


class Coefficients(NamedTuple):
    """A scheme as kernels see it: the coefficients of a splitting, or of a Runge-Kutta tableau with those of its error
    estimates and its interpolant; `precise`: a splitting works on increments; `spare`: rows behind the state that it
    takes.
    """

    drift: np.ndarray = np.zeros(1)
    kick: np.ndarray = np.zeros(0)
    a: np.ndarray = np.zeros((0, 0))
    b: np.ndarray = np.zeros(0)
    errors: np.ndarray = np.zeros((0, 0))
    dense: np.ndarray = np.zeros((0, 0))
    precise: bool = False
    spare: int = 0


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


@jit
def runge_kutta_stages(blocks, a, first, last, rows, lanes, step, z, k, work):
    """Fill the slopes k[first:last] (stages, rows*LANES) of an explicit tableau a at the state z."""
    size = rows * LANES
    for s in range(first, last):
        combine(rows, lanes, 0, s, a[s], k, work)
        for r in range(rows):
            for i in range(lanes):
                work[r * LANES + i] = z[r * LANES + i] + step[i] * work[r * LANES + i]
        blocks.derivative(blocks.params, lanes, work, k[s * size : (s + 1) * size])


@jit
def advance(blocks, scheme, rows, lanes, step, steps, z, k, work):
    """Advance z by steps of the scheme, step[i] in lane i: a splitting where it has kicks, else a Runge-Kutta tableau.

    Returns how many were taken: a splitting stops at one with which a lane leaves the domain, a tableau after each.
    Where z has room for increments and carried errors, the splitting works on increments.
    """
    if scheme.kick.size > 0:
        return blocks.splitting(blocks.params, lanes, scheme.drift, scheme.kick, step, steps, z)
    stages = scheme.b.size
    runge_kutta_stages(blocks, scheme.a, 0, stages, rows, lanes, step, z, k, work)
    combine(rows, lanes, 0, stages, scheme.b, k, work)
    for r in range(rows):
        for i in range(lanes):
            z[r * LANES + i] += step[i] * work[r * LANES + i]
    return 1


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
