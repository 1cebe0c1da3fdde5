"""Kernel of isolated lines: frequencies, amplitudes and generators from the bins of Fourier transforms, without
a fit.

The window of order p is w_n ~ prod_{i<p} (cos(2 pi t/T) + cos((2 i + 1) pi/N)); its transform W(d) at d bins is
closed, so two neighbouring bins of an isolated line give its place exactly, and the two pairs around its largest bin
agree. Their difference is the error that other lines make.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compile.jit import jit, read_now
from .fundamental import BLOCK, Lattice, Rows, generate, growth, relate, rows_of, total
from .spectrum_lines import amplitude_at, find_peaks, top_of

SLOW = 1e-3
"""Amplitude of slow motion, relative to the largest line's, up to which it is ignored."""


DOUBLE, DOUBTFUL = 0.05, 1.5
"""Error bar above which a line may be two, and their largest distance from it, in bins."""

STRONG = 0.05
"""Amplitude of a line, relative to its loop's largest, above which generators must not be multiples of it."""


class Lines(NamedTuple):
    """Lines of loops, the largest first: frequencies, error bars and amplitudes (orbits, m, lines)."""

    value: np.ndarray
    bar: np.ndarray
    strength: np.ndarray


@jit
def moments(row, window, sums, squares):
    """Return the weighted mean of a row (samples,) and its weighted root mean square about it; sums, squares (BLOCK,):
    scratch.
    """
    for i in range(BLOCK):
        sums[i], squares[i] = 0.0, 0.0
    first = row[0]
    for start in range(0, row.size, BLOCK):
        part, weight = row[start : start + BLOCK], window[start : start + BLOCK]
        for i in range(part.size):
            sums[i] += weight[i] * (part[i] - first)
        for i in range(part.size):  # a separate loop: LLVM proves only few arrays distinct in one
            value = part[i] - first
            squares[i] += weight[i] * value * value
    away = total(sums)
    return first + away, math.sqrt(max(total(squares) - away * away, 0.0))


@jit
def weigh(q, p, centre, change, units, weight, out):
    """Fill out (2*samples,) with the numbers of Q - i P, without mean and mean growth, times a weight.

    q, p, weight (samples,); centre, change, units: of Q and of P.
    """
    for start in range(0, q.size, BLOCK):
        own, to = weight[start : start + BLOCK], out[2 * start : 2 * start + 2 * BLOCK]
        one, other = q[start : start + BLOCK], p[start : start + BLOCK]
        for i in range(own.size):
            to[2 * i] = (one[i] - centre[0]) * units[0] * own[i]
            to[2 * i + 1] = (centre[1] - other[i]) * units[1] * own[i]
        if change[0] != 0.0 or change[1] != 0.0:
            for i in range(own.size):
                to[2 * i] -= change[0] * (start + i) * units[0] * own[i]
                to[2 * i + 1] += change[1] * (start + i) * units[1] * own[i]


@jit
def _grows(source):
    """Return whether samples may grow as `growth` requires: over each half of the time they change in one direction. A
    few samples exclude most oscillations.
    """
    first, last, half, back = source[0], source[source.size - 1], source.size // 2 + 1, 0
    if not abs(last - first) > abs(source[source.size // 2] - first):
        return False
    for i in range(0, source.size - half, source.size // 16 + 1):
        back += 1 if (source[i + half] > source[i]) != (last > first) else 0
    return back == 0


class Spectra(NamedTuple):
    """Fourier transforms of windowed loops of the first n samples (orbits,) of signals: those of an orbit (m, n) from
    its start (orbits,) on; and the `Rows` of their signals.
    """

    numbers: np.ndarray
    start: np.ndarray
    n: np.ndarray
    rows: Rows


def windowed(unit, stop, progress, signals, tables, at_rest, spectra):
    """Fill spectra, as real numbers, with the loops Q - i P of an orbit times a weight, for a Fourier transform, like
    `fundamental.prepare`: without mean and mean growth, in units of the sizes of Q and P.

    signals: see `rows_of`; tables: the window of means, the weight (samples,), and the tables (3, samples - 1) of
    `growth`.
    """
    if read_now(stop, 0) > 0:
        return
    drift, centre, size, moving = spectra.rows
    n, m, s = spectra.n[unit], moving.shape[1], rows_of(signals, unit)
    own = tables.numbers[tables.start[unit] :]
    window, weight, growing = own[:n], own[n : 2 * n], own[2 * n : 2 * n + 3 * (n - 1)].reshape((3, n - 1))
    out = spectra.numbers[2 * spectra.start[unit] :]
    sums, squares, rest = np.empty(BLOCK), np.empty(BLOCK), np.empty(n)
    largest_one = 0.0
    for r in range(2 * m):
        source = s[r, :n]
        drift[unit, r] = growth(source, growing, rest, sums) if _grows(source) else 0.0
        if drift[unit, r] != 0.0:
            for i in range(n):
                rest[i] = source[i] - drift[unit, r] * i
            centre[unit, r], size[unit, r] = moments(rest, window, sums, squares)
        else:
            centre[unit, r], size[unit, r] = moments(source, window, sums, squares)
    for j in range(m):
        largest_one = max(largest_one, size[unit, 2 * j] * size[unit, 2 * j + 1])
    for j in range(m):
        moving[unit, j] = size[unit, 2 * j] * size[unit, 2 * j + 1] > at_rest * largest_one
        first = 2 * j
        for r in (first, first + 1):
            size[unit, r] = size[unit, r] if size[unit, r] > 0.0 else 1.0
        share = 1.0 if moving[unit, j] else 0.0
        units, means = (share / size[unit, first], share / size[unit, first + 1]), centre[unit]
        weigh(
            s[first, :n],
            s[first + 1, :n],
            (means[first], means[first + 1]),
            (drift[unit, first], drift[unit, first + 1]),
            units,
            weight,
            out[2 * n * j : 2 * n * (j + 1)],
        )
    progress[unit] = 1.0


@jit
def solve(matrix, right, n):
    """Solve matrix x = right in place (n, columns) by elimination; return whether that was possible."""
    largest_one = 0.0
    for i in range(n):
        for j in range(n):
            largest_one = max(largest_one, abs(matrix[i, j]))
    for i in range(n):
        pivot = i
        for j in range(i + 1, n):
            if abs(matrix[j, i]) > abs(matrix[pivot, i]):
                pivot = j
        if not abs(matrix[pivot, i]) > 1e-9 * largest_one:
            return False
        for c in range(n):
            matrix[i, c], matrix[pivot, c] = matrix[pivot, c], matrix[i, c]
        for c in range(right.shape[1]):
            right[i, c], right[pivot, c] = right[pivot, c], right[i, c]
        for j in range(n):
            if j != i:
                factor = matrix[j, i] / matrix[i, i]
                for c in range(i, n):
                    matrix[j, c] -= factor * matrix[i, c]
                for c in range(right.shape[1]):
                    right[j, c] -= factor * right[i, c]
    for i in range(n):
        for c in range(right.shape[1]):
            right[i, c] /= matrix[i, i]
    return True


@jit
def divides(value, bar, unit, nu, bars, rank, table, count, related, k):
    """Return whether generators are multiples of a line, or its multiples are combinations of them while the line is
    not (`related` False): then they span only a part of the lattice. unit: the width of a bin.

    A line whose bar is DOUBLE a bin or more may be two, each up to DOUBTFUL bins from it.
    """
    for m in range(2, 4):
        for i in range(rank):
            width = DOUBTFUL * unit if bar > DOUBLE * unit else min(max(bar, 0.05 * unit), 0.5 * unit)
            if abs(m * value - nu[i]) < m * width:
                return True
        if not related and relate(m * value, 0.3 * m * unit, nu, bars, rank, table, count, 0.5, k):
            return True
    return False


class Apart(NamedTuple):
    """Results for orbits with isolated lines, frequencies in bins.

    lines: frequencies, error bars and amplitudes of the lines of each loop (orbits, m, lines), the largest first;
    lattice: their generators; dual (orbits, m, 2m) and share (orbits, m, m), see `fundamental`; rest (orbits,), the
    largest share of a loop's size outside all lines; tail (orbits,), the largest amplitude above three quarters of the
    highest frequency of the samples, relative to the loop's largest; clear (orbits,), whether every moving loop has its
    generator and every leading line is explained.
    """

    lines: Lines
    lattice: Lattice
    dual: np.ndarray
    share: np.ndarray
    rest: np.ndarray
    tail: np.ndarray
    clear: np.ndarray


@jit
def _measure(unit, j, spectrum, limits, found, apart):
    """Write the lines of loop j to found (place, size and error, each (m, lines)) and apart; return whether its leading
    one is sharp and moves, and no part of the loop is too slow to be a line.
    """
    order, sharp, width = limits
    (value, bar, strength), rest, tail = apart.lines, apart.rest, apart.tail
    (place, size, error), samples = found, spectrum.size
    count, left = find_peaks(spectrum, order, place[j], size[j], error[j])
    rest[unit] = max(rest[unit], left)
    high, power, best = 0.0, np.empty(BLOCK), np.empty(BLOCK // 4)
    for at in range(3 * samples // 8, 5 * samples // 8, BLOCK):
        own = spectrum[at : min(at + BLOCK, 5 * samples // 8)]
        for i in range(own.size):
            power[i] = own[i].real * own[i].real + own[i].imag * own[i].imag
        high = max(high, top_of(power[: own.size], best))
    tail[unit] = max(tail[unit], math.sqrt(high) / size[j, 0]) if size[j, 0] > 0.0 else tail[unit]
    for i in range(count):
        u = place[j, i] if place[j, i] < samples / 2 else place[j, i] - samples
        place[j, i], value[unit, j, i] = u, abs(u)
        bar[unit, j, i], strength[unit, j, i] = 3.0 * error[j, i] + width, size[j, i]
    slow = 0.0
    for i in range(-order - 1, order + 2):
        own = spectrum[i % samples]
        slow = max(slow, own.real * own.real + own.imag * own.imag)
    return error[j, 0] < sharp and value[unit, j, 0] > order + 2.0 and slow < (SLOW * size[j, 0]) ** 2


@jit
def _ranked(unit, minor, sharp, found, lines, values, bars):
    """Write the frequencies and bars of the sharp lines of all loops, the leading ones first, then the others by their
    shares of their loops; return their number.
    """
    (_, size, error), (value, bar, _), used = found, lines, 0
    key = np.zeros(values.size)
    for j in range(size.shape[0]):
        for i in range(size.shape[1]):
            if size[j, i] > minor * size[j, 0] and error[j, i] < sharp and value[unit, j, i] > 2.0:
                own = size[j, i] / size[j, 0] + (2.0 if i == 0 else 0.0)
                at = used
                while at > 0 and key[at - 1] < own:
                    key[at], values[at], bars[at] = key[at - 1], values[at - 1], bars[at - 1]
                    at -= 1
                key[at], values[at], bars[at] = own, value[unit, j, i], bar[unit, j, i]
                used += 1
    return used


@jit
def _explained(unit, moving, order, size, generators, vectors, apart):
    """Return whether the generators explain every leading line, are not multiples of a strong one, are lines
    themselves, and are isolated.
    """
    (value, bar, _), (nu, bars, source, found), (tables, sizes) = apart.lines, generators, vectors
    m, k, r = size.shape[0], np.zeros(size.shape[0], np.int64), max(found, 1) - 1
    for j in range(m):
        if moving[j] != 0 and not (
            found > 0 and relate(value[unit, j, 0], bar[unit, j, 0], nu, bars, found, tables[r], sizes[r, 0], 0.5, k)
        ):
            return False
        for i in range(size.shape[1]):
            if size[j, i] > STRONG * size[j, 0] and found > 0:
                u, width = value[unit, j, i], bar[unit, j, i]
                related = relate(u, min(width, 0.3), nu, bars, found, tables[r], sizes[r, 0], 0.5, k)
                if divides(u, width, 1.0, nu, bars, found, tables[r], sizes[r, 0], related, k):
                    return False
    for i in range(found):
        if source[i] < 0:
            return False
        for j in range(i):
            if not abs(nu[i] - nu[j]) > order + 1.0:
                return False
    return True


@jit
def _conjugate(unit, moving, spectrum, order, nu, found, apart):
    """Write share and dual of the generators, from the amplitudes of Q and P of each loop; return whether the dual
    exists.
    """
    m, samples = spectrum.shape
    matrix, right = np.zeros((2 * found, 2 * found)), np.zeros((2 * found, 2 * found))
    rows, row = np.zeros(2 * m, np.int64), 0
    for j in range(m):
        if moving[j] != 0:
            for i in range(found):
                a, b = amplitude_at(spectrum[j], nu[i], samples, order)
                c, d = amplitude_at(spectrum[j], -nu[i], samples, order)
                # Q - i P is (a + i b) exp(i phi) + (c + i d) exp(-i phi): the amplitudes of Q and of P.
                q, p = (0.5 * (a + c), 0.5 * (b - d)), (-0.5 * (b + d), 0.5 * (a - c))
                apart.share[unit, i, j] = math.hypot(q[0], q[1]) * math.hypot(p[0], p[1])
                # s = sum_i 2 Re(A_i exp(i phi)): rows q, p of the real matrix of 2 Re A, -2 Im A.
                matrix[row, 2 * i], matrix[row, 2 * i + 1] = 2.0 * q[0], -2.0 * q[1]
                matrix[row + 1, 2 * i], matrix[row + 1, 2 * i + 1] = 2.0 * p[0], -2.0 * p[1]
            rows[row], rows[row + 1] = 2 * j, 2 * j + 1
            row += 2
    for i in range(2 * found):
        right[i, i] = 1.0
    if not solve(matrix, right, 2 * found):
        return False
    for i in range(found):
        for r in range(2 * found):
            apart.dual[unit, i, rows[r]] = complex(right[2 * i, r], right[2 * i + 1, r])
    return True


def separate(unit, stop, progress, spectra, order, minor, sharp, width, vectors, apart):
    """Find the lines of the loops of an orbit and the generators of their lattice, if all are isolated.

    spectra: of the loops Q - i P, in units of the sizes of Q and P.
    """
    if read_now(stop, 0) > 0:
        return
    moving, lattice = spectra.rows.moving[unit], apart.lattice
    m, samples, lines, first = moving.size, spectra.n[unit], apart.lines.value.shape[2], spectra.start[unit]
    spectrum = spectra.numbers[first : first + m * samples].reshape((m, samples))
    size, error = np.zeros((m, lines)), np.full((m, lines), 9.0)
    found = np.zeros((m, lines)), size, error
    good, some = True, 0
    for j in range(m):
        if moving[j] != 0:
            some += 1
            good = _measure(unit, j, spectrum[j], (order, sharp, width), found, apart) and good
    values, bars = np.zeros(m * lines), np.zeros(m * lines)
    used = _ranked(unit, minor, sharp, found, apart.lines, values, bars)
    nu, spread, source = lattice.nu[unit], lattice.spread[unit], lattice.source[unit]
    rank = generate(values, bars, used, m, vectors, float(samples), nu, spread, source)
    lattice.rank[unit] = rank
    good = good and _explained(unit, moving, order, size, (nu, spread, source, rank), vectors, apart)
    good = good and rank == some and some > 0
    apart.clear[unit] = good and _conjugate(unit, moving, spectrum, order, nu, rank, apart)
    progress[unit] = 1.0
