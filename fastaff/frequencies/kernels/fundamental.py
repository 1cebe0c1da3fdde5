"""Kernels of fundamental frequencies: the lattice that lines lie in, amplitudes of lines.

A line of a torus is k . nu with an integer vector k. Tables of such vectors, one for each rank, are ordered by length,
see `relate`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import LANES, jit, read_now
from ...engine.pointers import Calls, call_value

ACCIDENTAL = 0.05
"""Expected number of accidental relations, within the errors, up to which longer vectors are tried; a fifth of that
for fractions.
"""

BLOCK = 64
"""Samples of a loop that are processed at once."""

ABREAST = 64
"""Vectors that are tried together."""

DENOMINATORS = 4
"""Largest m of a relation m nu = k . basis that refines a lattice."""


class Vectors(NamedTuple):
    """Tables of integer vectors of ranks 1, 2, ..., see `relate`, and their numbers (ranks, 2), of all and of short."""

    tables: np.ndarray
    sizes: np.ndarray


class FrequencyLattice(NamedTuple):
    """Lattices of lines: ranks (orbits,), generators with their errors, and their numbers among the lines, -1 for those
    that are no line (orbits, m).
    """

    rank: np.ndarray
    nu: np.ndarray
    spread: np.ndarray
    source: np.ndarray


class WindowTables(NamedTuple):
    """Tables for different numbers of samples, one after the other: an orbit's begins at its `start`."""

    numbers: np.ndarray
    start: np.ndarray


class SignalRows(NamedTuple):
    """Rows of orbits by pairs Q, P: their drift from sample to sample, their means without drift, and sizes (orbits,
    2m), and which of the loops Q - i P move (orbits, m).
    """

    drift: np.ndarray
    centre: np.ndarray
    size: np.ndarray
    moving: np.ndarray


@jit
def relate(value, bar, basis, spread, rank, table, count, accidental, k):
    """Write to k (rank,) the shortest of the first `count` vectors of table with value = k . basis within the errors;
    return whether there is one.

    table (>= rank + 1, vectors): the components, a row each, and in the last row |k|_1.
    """
    scale = 0.0
    lengths = table[table.shape[0] - 1]
    sums = np.empty(ABREAST)
    widths = np.empty(ABREAST)
    for i in range(rank):
        scale = max(scale, abs(basis[i]))
    for first in range(0, count, ABREAST):
        end = min(first + ABREAST, count)
        some = 0
        size = lengths[first:end]
        for j in range(size.size):
            sums[j] = 0.0
            widths[j] = bar
        for i in range(rank):
            row = table[i, first:end]
            one = basis[i]
            width = spread[i]
            for j in range(row.size):
                sums[j] += row[j] * one
                widths[j] += abs(row[j]) * width
        for j in range(size.size):
            likely = 2.0 * widths[j] * (first + j + 1) > accidental * scale * size[j]
            some += 1 if likely or abs(value - sums[j]) <= widths[j] else 0
        for j in range(size.size if some > 0 else 0):
            if 2.0 * widths[j] * (first + j + 1) > accidental * scale * size[j]:
                return False
            if abs(value - sums[j]) <= widths[j]:
                for i in range(rank):
                    k[i] = int(table[i, first + j])
                return True
    return False


@jit
def reduce_columns(matrix, rows, columns):
    """Bring an integer matrix to lower column-echelon form in place, by Euclid's algorithm on columns."""
    column = 0
    for row in range(rows):
        while column < columns:
            pivot = -1
            filled = 0
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
            basis[i] = value
            spread[i] = bar
            source[i] = line
            return
    matrix = np.zeros((rank, rank + 1), np.int64)
    for i in range(rank):
        matrix[i, i], matrix[i, rank] = m, k[i]
    reduce_columns(matrix, rank, rank + 1)
    old = basis[:rank].copy()
    bars = spread[:rank].copy()
    for j in range(rank):
        basis[j] = 0.0
        spread[j] = bar
        source[j] = -1
        for i in range(rank):
            basis[j] += matrix[i, j] * old[i] / m
            spread[j] += abs(matrix[i, j]) * bars[i] / m


@jit
def generate(value, bar, count, most, vectors, rate, basis, spread, source):
    """Find at most `most` generators of the lattice of lines, the first ones trusted most; return their number.

    A line k . basis, also modulo the sampling rate, is in the lattice; one with m value = k . basis refines it; any
    other adds a generator while there is room.
    """
    tables, sizes = vectors
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
        for alias in (rate - value[line], rate + value[line]):
            if rank > 0 and related != 1:
                short = sizes[rank - 1, 1]
                if relate(alias, bar[line], basis, spread, rank, tables[rank - 1], short, ACCIDENTAL, k):
                    related = 1
        if related > 1:
            refine(related, k, rank, value[line], bar[line], line, basis, spread, source)
        elif related == 0 and rank < most:
            basis[rank], spread[rank], source[rank] = value[line], bar[line], line
            rank += 1
    return rank


def generators(unit, stop, progress, value, bar, count, vectors, rate, lattice):
    """Run `generate` on the lines (orbits, lines) of an orbit of samples at this rate (orbits,)."""
    if read_now(stop, 0) == 0:
        lines = count[unit]
        nu = lattice.nu[unit]
        spread = lattice.spread[unit]
        source = lattice.source[unit]
        lattice.rank[unit] = generate(value[unit], bar[unit], lines, nu.size, vectors, rate[unit], nu, spread, source)
        progress[unit] = 1.0


@jit
def rows_of(signals, orbit):
    """Return the rows (rows, samples) of an orbit of signals: a tuple of the numbers of all orbits, the number of rows
    of each, and the place of the first row and the samples of a row (orbits,).
    """
    numbers, rows, start, count = signals
    first = start[orbit]
    samples = count[orbit]
    return numbers[first : first + rows * samples].reshape((rows, samples))


@jit
def total(sums):
    """Return the sum of partial sums (BLOCK,), which it overwrites: the sum of their halves, and so on."""
    size = BLOCK // 2
    while size >= 8:
        first = sums[:size]
        second = sums[size : 2 * size]
        for i in range(size):
            first[i] += second[i]
        size //= 2
    return ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]))


@jit
def fill_turns(turn, cosine, sine):
    """Fill cosine and sine (BLOCK,) with those of turn times 0, 1, ..., by doubling."""
    cosine[0] = 1.0
    sine[0] = 0.0
    done = 1
    while done < BLOCK:
        c, s = math.cos(turn * done), math.sin(turn * done)
        for i in range(done):
            cosine[done + i] = cosine[i] * c - sine[i] * s
            sine[done + i] = cosine[i] * s + sine[i] * c
        done *= 2


@jit
def weighted_sum(weights, values, sums):
    """Return the sum of weights times values (both of one size), over BLOCK partial sums (BLOCK,)."""
    for i in range(BLOCK):
        sums[i] = 0.0
    whole = values.size // BLOCK * BLOCK
    for start in range(0, whole, BLOCK):
        w = weights[start : start + BLOCK]
        v = values[start : start + BLOCK]
        for i in range(BLOCK):
            sums[i] += w[i] * v[i]
    for i in range(values.size - whole):
        sums[i] += weights[whole + i] * values[whole + i]
    return total(sums)


def read_signals(unit, stop, progress, states, parameters, table, signals):
    """Fill signals (orbits, rows, samples) with the values of the table's call at states (orbits, samples, 2n)."""
    if read_now(stop, 0) > 0:
        return
    own = states[unit]
    calls = Calls(table, parameters)
    samples = signals.shape[2]
    size = own.shape[1]
    rows = signals.shape[1]
    z = np.zeros(size * LANES)
    made = np.zeros(rows * LANES)
    for start in range(0, samples, LANES):
        lanes = min(LANES, samples - start)
        for i in range(lanes):
            for r in range(size):
                z[r * LANES + i] = own[start + i, r]
        call_value(calls, 0, lanes, z, made)
        for r in range(rows):
            row = signals[unit, r, start : start + lanes]
            first = r * LANES
            for i in range(lanes):
                row[i] = made[first + i]
    progress[unit] = 1.0


def extremes(unit, stop, progress, signals, low, high):
    """Fill low and high (orbits, rows) with the extremes of the signals, see `rows_of`."""
    if read_now(stop, 0) > 0:
        return
    s = rows_of(signals, unit)
    least = np.empty(BLOCK)
    most = np.empty(BLOCK)
    for r in range(s.shape[0]):
        for i in range(BLOCK):
            least[i], most[i] = s[r, 0], s[r, 0]
        for at in range(0, s.shape[1], BLOCK):
            part = s[r, at : at + BLOCK]
            for i in range(part.size):
                least[i] = part[i] if part[i] < least[i] else least[i]
                most[i] = part[i] if part[i] > most[i] else most[i]
        low[unit, r], high[unit, r] = s[r, 0], s[r, 0]
        for i in range(BLOCK):
            low[unit, r], high[unit, r] = min(low[unit, r], least[i]), max(high[unit, r], most[i])
    progress[unit] = 1.0


def quickness(unit, stop, progress, signals, ratio):
    """Fill ratio (orbits,) with the largest ratio, over rows of signals, of the mean square of second differences to
    that of first ones.
    """
    if read_now(stop, 0) > 0:
        return
    first = np.empty(BLOCK)
    second = np.empty(BLOCK)
    best = 0.0
    samples = signals.shape[2]
    for r in range(signals.shape[1]):
        row = signals[unit, r]
        first[:] = 0.0
        second[:] = 0.0
        for start in range(0, samples - 2, BLOCK):
            for i in range(min(BLOCK, samples - 2 - start)):
                before = row[start + i + 1] - row[start + i]
                after = row[start + i + 2] - row[start + i + 1]
                first[i] += before * before
                second[i] += (after - before) * (after - before)
        end = row[samples - 1] - row[samples - 2]
        below = (total(first) + end * end) / (samples - 1)
        value = total(second) / (samples - 2) / below if below > 0.0 else 0.0
        best = value if value > best and value < math.inf else best
    ratio[unit] = best
    progress[unit] = 1.0


@jit
def growth(row, tables, rest, sums):
    """Return the mean change per sample of a row that grows without bound, like a rotating coordinate; else 0.

    tables (3, samples - 1): weights of the whole and of two of its parts; rest, sums: scratch.
    """
    samples = row.size
    for i in range(samples - 1):
        rest[i] = row[i + 1] - row[i]
    mean = weighted_sum(tables[0], rest[: samples - 1], sums)
    first = weighted_sum(tables[1], rest[: samples - 1], sums)
    last = weighted_sum(tables[2], rest[: samples - 1], sums)
    if not max(abs(first - mean), abs(last - mean)) < 0.1 * abs(mean):
        return 0.0
    low = math.inf
    high = -math.inf
    for i in range(samples):
        value = row[i] - mean * i
        low, high = min(low, value), max(high, value)
    return mean if abs(mean) * samples > 2.0 * (high - low) else 0.0


def prepare(unit, stop, progress, signals, window, tables, at_rest, rows, loops, found):
    """Fill rows (orbits, 2m, samples) with the first samples of the signals without drift and mean, in units of their
    size; loops (orbits, m, samples) with Q - i P of these, 0 where a loop is at rest; and `found` with their drift,
    mean, size and motion, see `SignalRows`. window (samples,): of sum 1.
    """
    drift, centre, size, moving = found
    if read_now(stop, 0) > 0:
        return
    samples = window.size
    scratch = np.empty(window.size)
    sums = np.empty(BLOCK)
    for r in range(rows.shape[1]):
        row = rows[unit, r]
        source = signals[unit, r]
        for i in range(samples):
            row[i] = source[i]
        change = growth(row, tables, scratch, sums)
        if change != 0.0:
            for i in range(samples):
                row[i] -= change * i
        mean = weighted_sum(window, row, sums)
        for i in range(samples):
            row[i] -= mean
            scratch[i] = row[i] * row[i]
        drift[unit, r] = change
        centre[unit, r] = mean
        size[unit, r] = math.sqrt(weighted_sum(window, scratch, sums))
    largest = 0.0
    for j in range(loops.shape[1]):
        largest = max(largest, size[unit, 2 * j] * size[unit, 2 * j + 1])
    for j in range(loops.shape[1]):
        loop = loops[unit, j]
        q = rows[unit, 2 * j]
        p = rows[unit, 2 * j + 1]
        moving[unit, j] = size[unit, 2 * j] * size[unit, 2 * j + 1] > at_rest * largest
        for r in (2 * j, 2 * j + 1):
            size[unit, r] = size[unit, r] if size[unit, r] > 0.0 else 1.0
        one = 1.0 / size[unit, 2 * j]
        other = 1.0 / size[unit, 2 * j + 1]
        for i in range(samples):
            q[i] *= one
            p[i] *= other
        for i in range(samples):
            loop[i] = complex(q[i], -p[i]) if moving[unit, j] else 0j
    progress[unit] = 1.0


def combinations(unit, stop, progress, value, bar, nu, spread, vectors, k):
    """Fill k (orbits, m, m) with integers such that value = k @ nu (orbits, m), where a short vector fits; entries with
    nu = 0 are left out.
    """
    if read_now(stop, 0) > 0:
        return
    tables, sizes = vectors
    m = value.shape[1]
    basis = np.zeros(m)
    width = np.zeros(m)
    where = np.zeros(m, np.int64)
    rank = 0
    found = np.zeros(m, np.int64)
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
