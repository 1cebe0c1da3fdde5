"""Kernels of fundamental frequencies: the lattice that lines lie in, amplitudes of lines, mean turning rates of loops.

A line of a torus is k . nu with an integer vector k. Tables of such vectors, one for each rank, go from the short to
the long ones.
"""

from __future__ import annotations

import math

import numpy as np

from ..compile.jit import jit, read_now

ACCIDENTAL = 0.05
"""Expected number of accidental relations, within the errors, up to which longer vectors are tried; a fifth of it for
fractions.
"""

BLOCK = 64
"""Samples of a loop that are worked on at once."""

DENOMINATORS = 4
"""Largest m of a relation m nu = k . basis that refines a lattice."""


@jit
def relate(value, bar, basis, spread, rank, table, count, accidental, k):
    """Write to k (rank,) the shortest vector of the first `count` of table with value = k . basis within the errors;
    return whether.
    """
    scale = 0.0
    for i in range(rank):
        scale = max(scale, abs(basis[i]))
    for v in range(count):
        combination, tolerance, size = 0.0, bar, 0
        for i in range(rank):
            combination += table[v, i] * basis[i]
            tolerance += abs(table[v, i]) * spread[i]
            size += abs(table[v, i])
        if 2.0 * tolerance * (v + 1) > accidental * scale * size:
            return False
        if abs(value - combination) <= tolerance:
            for i in range(rank):
                k[i] = table[v, i]
            return True
    return False


@jit
def reduce_columns(matrix, rows, columns):
    """Bring an integer matrix to lower column-echelon form in place, by Euclid's algorithm on columns."""
    column = 0
    for row in range(rows):
        while column < columns:
            pivot, filled = -1, 0
            for j in range(column, columns):
                if matrix[row, j] != 0:
                    filled += 1
                    if pivot < 0 or abs(matrix[row, j]) < abs(matrix[row, pivot]):
                        pivot = j
            if filled == 0:
                break
            for i in range(rows):
                matrix[i, column], matrix[i, pivot] = matrix[i, pivot], matrix[i, column]
            if filled == 1:
                column += 1
                break
            for j in range(column + 1, columns):
                factor = matrix[row, j] // matrix[row, column]
                for i in range(rows):
                    matrix[i, j] -= factor * matrix[i, column]


@jit
def refine(m, k, rank, value, bar, line, basis, spread, source):
    """Refine a basis by a line with m value = k . basis: it replaces a generator, or the lattice gets generators that
    are no lines.
    """
    for i in range(rank):
        if abs(k[i]) == 1:
            basis[i], spread[i], source[i] = value, bar, line
            return
    matrix = np.zeros((rank, rank + 1), np.int64)
    for i in range(rank):
        matrix[i, i], matrix[i, rank] = m, k[i]
    reduce_columns(matrix, rank, rank + 1)
    old, bars = basis[:rank].copy(), spread[:rank].copy()
    for j in range(rank):
        basis[j], spread[j], source[j] = 0.0, bar, -1
        for i in range(rank):
            basis[j] += matrix[i, j] * old[i] / m
            spread[j] += abs(matrix[i, j]) * bars[i] / m


@jit
def generate(value, bar, count, most, tables, sizes, basis, spread, source):
    """Find at most `most` generators of the lattice of lines, the first ones trusted most; return their number.

    A line that is k . basis is in; one with m value = k . basis refines the lattice; any other adds a generator while
    there is room.
    """
    rank = 0
    k = np.zeros(most, np.int64)
    for line in range(count):
        related = 0
        for m in range(1, DENOMINATORS + 1):
            if rank > 0 and related == 0:
                whole = m == 1
                if relate(
                    m * value[line],
                    m * bar[line],
                    basis,
                    spread,
                    rank,
                    tables[rank - 1],
                    sizes[rank - 1, 0 if whole else 1],
                    ACCIDENTAL if whole else 0.2 * ACCIDENTAL,
                    k,
                ):
                    related = m
        if related > 1:
            refine(related, k, rank, value[line], bar[line], line, basis, spread, source)
        elif related == 0 and rank < most:
            basis[rank], spread[rank], source[rank] = value[line], bar[line], line
            rank += 1
    return rank


def generators(unit, stop, progress, value, bar, count, tables, sizes, rank, basis, spread, source):
    """Run `generate` on the lines (orbits, lines) of an orbit."""
    if read_now(stop, 0) == 0:
        rank[unit] = generate(
            value[unit], bar[unit], count[unit], basis.shape[1], tables, sizes, basis[unit], spread[unit], source[unit]
        )
        progress[unit] = 1.0


def project(unit, stop, progress, signals, stride, window, interval, rank, nu, moments, gram):
    """Fill moments (orbits, rows, n) with sum w s exp(-2 pi i nu t) of every stride-th sample, and the lines' own
    (orbits, 2n, 2n).

    The lines of a Gram matrix are those at nu, then those at -nu; the window (samples,) sums to 1; time counts from its
    middle.
    """
    if read_now(stop, 0) > 0:
        return
    s, r, samples = signals[unit], rank[unit], window.size
    P, G = moments[unit], gram[unit]
    e, turn = np.empty(r, np.complex128), np.empty(r, np.complex128)
    for k in range(r):
        phase = 2.0 * math.pi * nu[unit, k] * interval
        turn[k] = complex(math.cos(phase), math.sin(phase))
    for j in range(samples):
        if j % 64 == 0:
            for k in range(r):
                phase = 2.0 * math.pi * nu[unit, k] * interval * (j - 0.5 * (samples - 1))
                e[k] = complex(math.cos(phase), math.sin(phase))
        for k in range(r):
            c = window[j] * e[k].conjugate()
            for i in range(s.shape[0]):
                P[i, k] += c * s[i, j * stride]
            for m in range(r):
                G[k, m] += c * e[m]
                G[k, r + m] += c * e[m].conjugate()
        for k in range(r):
            e[k] *= turn[k]
    for k in range(r):
        for m in range(r):
            G[r + k, r + m] = G[k, m].conjugate()
            G[r + k, m] = G[k, r + m].conjugate()
    progress[unit] = 1.0


@jit
def angle_of(x, y):
    """Return the argument of x + i y to 3e-16, 0 of nothing, without branches: loops over it become vector
    instructions.

    atan u/u is a polynomial in u^2 on |u| <= tan(pi/8), to 5e-20; pi/4 is taken off above.
    """
    wide, high = abs(x), abs(y)
    big, small = max(wide, high), min(wide, high)
    beyond = small > 0.41421356237309503 * big
    top, bottom = (small - big if beyond else small), (small + big if beyond else big)
    u = top / (bottom if bottom != 0.0 else 1.0)
    w = u * u
    p = 0.015113765096600920006
    p = p * w - 0.033387824501211946912
    p = p * w + 0.044995007289840318104
    p = p * w - 0.052173125740615909524
    p = p * w + 0.058768340046141606564
    p = p * w - 0.066662052599765261871
    p = p * w + 0.0769228109993774325
    p = p * w - 0.090909080590311910269
    p = p * w + 0.11111111085322108759
    p = p * w - 0.14285714285329708164
    p = p * w + 0.19999999999997013892
    p = p * w - 0.33333333333333324206
    angle = (u + u * w * p) + (0.25 * math.pi if beyond else 0.0)
    angle = 0.5 * math.pi - angle if high > wide else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle


@jit
def loop_angles(s, c, offset, drift, samples, re, im, angles):
    """Fill angles (samples - 1,) with the angle from each value of the loop  c . s - offset - drift j  to the next.

    re, im (1 + BLOCK,): values of a block, behind the last one before it.
    """
    for start in range(0, samples, BLOCK):
        width = min(BLOCK, samples - start)
        re[0], im[0] = re[BLOCK], im[BLOCK]
        for i in range(width):
            re[i + 1] = -offset.real - drift.real * (start + i)
            im[i + 1] = -offset.imag - drift.imag * (start + i)
        for r in range(c.size):
            a, b, row = c[r].real, c[r].imag, s[r]
            for i in range(width):
                re[i + 1] += a * row[start + i]
                im[i + 1] += b * row[start + i]
        first = 1 if start == 0 else 0
        for i in range(first, width):
            x = re[i + 1] * re[i] + im[i + 1] * im[i]
            y = im[i + 1] * re[i] - re[i + 1] * im[i]
            angles[start + i - 1] = angle_of(x, y)


@jit
def weighted_sum(weights, values, sums):
    """Return the sum of weights times values (both of one size), over BLOCK partial sums."""
    sums[:] = 0.0
    count = values.size
    for start in range(0, count, BLOCK):
        for i in range(min(BLOCK, count - start)):
            sums[i] += weights[start + i] * values[start + i]
    total = 0.0
    for i in range(BLOCK):
        total += sums[i]
    return total


def turn(unit, stop, progress, signals, samples, loops, offset, drift, windows, rates):
    """Fill rates (orbits, loops, windows) with weighted mean angles per sample of the loops  c . s - offset - drift j
    of an orbit.

    signals (orbits, rows, >= samples); loops (orbits, loops, rows); windows (1 or orbits, windows, samples - 1), each
    of sum 1.
    """
    if read_now(stop, 0) > 0:
        return
    table = windows[unit % windows.shape[0]]
    angles, re, im, sums = np.empty(samples - 1), np.zeros(BLOCK + 1), np.zeros(BLOCK + 1), np.empty(BLOCK)
    for k in range(loops.shape[1]):
        loop_angles(signals[unit], loops[unit, k], offset[unit, k], drift[unit, k], samples, re, im, angles)
        for w in range(table.shape[0]):
            rates[unit, k, w] = weighted_sum(table[w], angles, sums)
    progress[unit] = 1.0


def combinations(unit, stop, progress, value, bar, nu, spread, tables, sizes, k):
    """Fill k (orbits, m, m) with integers such that value = k @ nu (orbits, m), where a short vector does; nu = 0 has
    no part.
    """
    if read_now(stop, 0) > 0:
        return
    m = value.shape[1]
    basis, width, where = np.zeros(m), np.zeros(m), np.zeros(m, np.int64)
    rank, found = 0, np.zeros(m, np.int64)
    for j in range(m):
        if nu[unit, j] != 0.0:
            basis[rank], width[rank], where[rank] = nu[unit, j], spread[unit, j], j
            rank += 1
    for j in range(m):
        if (
            rank > 0
            and value[unit, j] != 0.0
            and relate(
                value[unit, j],
                bar[unit, j],
                basis,
                width,
                rank,
                tables[rank - 1],
                sizes[rank - 1, 0],
                10.0 * ACCIDENTAL,
                found,
            )
        ):
            for i in range(rank):
                k[unit, j, where[i]] = found[i]
    progress[unit] = 1.0
