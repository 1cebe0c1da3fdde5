"""One step of a scheme for a block of lanes. State blocks are flat: row r of lane i is z[r*LANES + i]."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..jit import LANES, jit
from ..lane_sums import NARROW, VECTOR, WIDE, narrow_move, narrow_sum, wide_move, wide_sum
from ..pointers import call, caller

LINE = 64
"""Bytes of a cache line, and of the widest vector registers."""
LONE = 3
"""Number of lanes beyond whole vectors that take longer one by one than as another vector."""


class Blocks(NamedTuple):
    """A model and a scheme's step for kernels: parameters and block functions, idle ones where a run does not use them,
    and the addresses of the derivative and, for a model with poles, of the test for steps across them, or 0.

    own, half: number of the positions of an orbit, and with those of its vectors. between: code of an orbit in the
    domain whose vectors are not finite, between two checks: 1 for a map, else 0, as the next check finds them.
    """

    params: np.ndarray
    splitting: Any
    march: Any
    step: Any
    inside: Any
    check: Any
    derivative: int = 0
    leapt: int = 0
    own: int = 0
    half: int = 0
    between: float = 0.0


class Coefficients(NamedTuple):
    """A scheme for kernels: the coefficients of a splitting, or of a Runge-Kutta tableau with those of its error
    estimates and its interpolant; copies: rows in memory over rows of a state, 3 where a splitting works on increments;
    spare: further rows after the state. For a collocation, with at most `sweeps` sweeps, a has the form of
    `schemes.Collocation` and dense is that of its first sweep.
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


def blank(rows):
    """Return zeros for the rows of a block (rows*LANES), from the beginning of a cache line.

    Arrays begin at multiples of 16 or 32 bytes, which differ between processes: vectors across two lines take up to two
    thirds longer.
    """
    whole = np.zeros(rows * LANES + LINE // 8)
    first = (-whole.ctypes.data % LINE) // 8
    return whole[first : first + rows * LANES]


aligned_zeros = jit(blank)


@jit
def stretch(rows, lanes):
    """Return distance and length of the contiguous stretches in a loop over all rows: rows of these lanes, or all rows
    of a nearly full block at once, as a loop takes time to begin.
    """
    return (LANES, lanes) if lanes < 3 * LANES // 4 else (rows * LANES, rows * LANES)


@jit
def keep(rows, lanes, source, target):
    """Copy the rows of lanes."""
    apart, length = stretch(rows, lanes)
    for at in range(0, rows * LANES, apart):
        own = source[at : at + length]
        other = target[at : at + length]
        for i in range(length):
            other[i] = own[i]


@jit
def combine(rows, lanes, last, coefficients, k, total):
    """Set total = sum of coefficients[s] * k[s] over s < last, in the order of s, without those that are 0."""
    terms = np.empty(last, np.int64)
    weights = np.empty(last)
    count = nonzero(rows, last, coefficients, terms, weights)
    for at in range(0, rows * LANES, LANES):
        i = 0
        while i < lanes:
            if lanes - i > NARROW * VECTOR:
                wide_sum(total, total, total, k, terms, weights, at + i, i, count)
                i += WIDE * VECTOR
            else:
                narrow_sum(total, total, total, k, terms, weights, at + i, i, count)
                i += NARROW * VECTOR


@jit
def nonzero(rows, last, coefficients, terms, weights):
    """Set the terms to the beginnings of the slopes with nonzero coefficients, and the weights to these; return their
    number.
    """
    count = 0
    for s in range(last):
        if coefficients[s] != 0.0:
            terms[count] = s * rows * LANES
            weights[count] = coefficients[s]
            count += 1
    return count


call_derivative = caller("derivative")
call_leapt = caller("leapt")


@jit
def look_back(blocks, lanes, begin, z, code):
    """Set the code of lanes that have passed a pole in a step from `begin` to z, for a model with poles."""
    if blocks.leapt != 0:
        call_leapt(blocks.leapt, blocks.params, lanes, begin, z, code)


@jit
def check_vectors(blocks, lanes, z, code, inside):
    """Set the code of lanes whose vectors are not finite to 1, or to `inside` if it is 0."""
    half = blocks.half
    for r in range(blocks.own, half):
        q = z[r * LANES : (r + 1) * LANES]
        p = z[(half + r) * LANES : (half + r + 1) * LANES]
        for i in range(lanes):
            known = code[i]
            broken = inside if known == 0.0 else 1.0
            code[i] = known if 0.0 * q[i] + 0.0 * p[i] == 0.0 else broken


@jit
def runge_kutta_stages(derivative, params, a, first, last, rows, lanes, step, z, k, work):
    """Fill the slopes k[first:last] (stages, rows*LANES) of an explicit tableau a at the state z, by the derivative at
    that address; leave the last one's state in work.
    """
    size = rows * LANES
    terms = np.empty(last, np.int64)
    weights = np.empty(last)
    for s in range(first, last):
        moved(rows, lanes, nonzero(rows, s, a[s], terms, weights), terms, weights, step, z, k, work)
        call_derivative(derivative, params, lanes, work, k[s * size : (s + 1) * size])


@jit
def moved(rows, lanes, count, terms, weights, step, z, k, target):
    """Set target = z + step times the weighted sum of `count` slopes."""
    for at in range(0, rows * LANES, LANES):
        i = 0
        while i < lanes:
            if lanes - i > NARROW * VECTOR:
                wide_move(target, z, step, k, terms, weights, at + i, i, count)
                i += WIDE * VECTOR
            else:
                narrow_move(target, z, step, k, terms, weights, at + i, i, count)
                i += NARROW * VECTOR


@jit
def runge_kutta(derivative, params, lanes, rows, a, b, dense, sweeps, step, z, k, work):
    """Take one step of an explicit tableau."""
    runge_kutta_stages(derivative, params, a, 0, b.size, rows, lanes, step, z, k, work)
    combine(rows, lanes, b.size, b, k, work)
    for r in range(rows):
        for i in range(lanes):
            z[r * LANES + i] += step[i] * work[r * LANES + i]
    return 1


@jit
def advance(blocks, scheme, rows, lanes, step, steps, z, k, work):
    """Advance z by steps of the scheme, step[i] in lane i: a splitting where it has kicks, else a collocation or a
    Runge-Kutta tableau.

    Returns the number of steps taken: a splitting stops after a step with which a lane leaves the domain, the others
    after each step. If z has room for increments and carried errors, the splitting works on increments.
    """
    if scheme.kick.size > 0:
        return call(blocks.splitting, blocks.params, lanes, scheme.drift, scheme.kick, step, steps, z)
    a = scheme.a
    b = scheme.b
    dense = scheme.dense
    sweeps = scheme.sweeps
    return call(blocks.step, blocks.derivative, blocks.params, lanes, rows, a, b, dense, sweeps, step, z, k, work)


@jit
def move_lane(rows, source, target, block):
    """Copy all rows of one lane over another lane of the same block."""
    for r in range(rows):
        block[r * LANES + target] = block[r * LANES + source]


@jit
def filled(lanes, rows, block, step):
    """Return the number of lanes to step: `lanes` filled up to whole vectors by copies of the first.

    The remaining lanes of a loop run one by one, and each takes as long as some vectors.
    """
    over = lanes % VECTOR
    if over < LONE:
        return lanes
    for i in range(lanes, lanes - over + VECTOR):
        move_lane(rows, 0, i, block)
        step[i] = step[0]
    return lanes - over + VECTOR


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
