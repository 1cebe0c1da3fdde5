"""Lines of loops by harmonic inversion: frequency, error and amplitude of the line next to a guess.

A loop of a quasiperiodic orbit is a sum of lines, f_n = sum_k d_k u_k^n. With a few functions z_j^n at frequencies next
to a guess, the matrices U_p[j, k] = sum_{m, n} f_{m + n + p} z_j^m z_k^n (m, n from 0 to M) obey U_1 B = u U_0 B
exactly as soon as the band of the functions holds no more lines than functions: there is no window and no leakage. The
eigenvalue next to the guess comes from Rayleigh quotients, B^T U_1 B / B^T U_0 B, of inverse iterations, which converge
cubically. Directions that no line has, in which both matrices are rounding errors, do no harm: U_0 on the right-hand
side makes them as small as the division makes them large.

Source: Wall and Neuhauser 1995, J. Chem. Phys. 102, 8011; Mandelshtam and Taylor 1997, J. Chem. Phys. 107, 6756.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import jit, read_now
from .fundamental import BLOCK, fill_turns, rows_of, weighted_sum
from .loops import add_rows

PEAK_BASIS = 8
"""Basis functions of the band of a peak, and of the windows that show errors: lines that such a band may hold."""

LINE_BASIS = 14
"""Basis functions of the band of a generator's line over all samples: over 30 to 100 periods 3 to 20 times smaller
errors than with 8, for a twentieth of a frequency map's time. 20 functions halve them, 14 in all windows do not.
"""

SPACING = 1.6
"""Distance of neighbouring basis functions, in cycles over the window: information ends at 2, see the module."""

ITERATIONS = 6
"""Most inverse iterations: they converge cubically, two or three do."""

CONVERGED = 1e-5
"""Change of a line's frequency, in cycles over the window, after which no iteration is needed: the next change is about
its cube.
"""

PARTS = BLOCK // 4
"""Partial sums of a block."""

LEAST = 16
"""Least number of samples of a window."""


class Windows(NamedTuple):
    """Windows of the samples of each orbit: begin, length (orbits, windows); basis (windows,): functions of the band in
    which their line is inverted, LINE_BASIS, PEAK_BASIS, or 0 for no line; and where the weights (length - 1,) of their
    mean begin in `weights` (orbits, windows), -1 for no mean.
    """

    begin: np.ndarray
    length: np.ndarray
    basis: np.ndarray
    place: np.ndarray
    weights: np.ndarray


class Line(NamedTuple):
    """Lines next to guesses, arrays (orbits, loops, windows): mean, that of a smooth window less the guess;
    shift, the line's frequency less the guess, and growth, all in cycles per sample; residual, the
    distance of U_2 from u^2 U_0 along the line, in the same unit.
    """

    mean: np.ndarray
    shift: np.ndarray
    growth: np.ndarray
    residual: np.ndarray


class Band(NamedTuple):
    """Rooms for a band: the functions z, vectors x, y (basis,), sums (basis, 5), matrix (basis, basis), overlaps (3,
    basis, basis), and the eigenvectors that are known (basis, basis).
    """

    z: np.ndarray
    x: np.ndarray
    y: np.ndarray
    sums: np.ndarray
    matrix: np.ndarray
    overlaps: np.ndarray
    known: np.ndarray


@jit
def new_band(size):
    """Return the rooms of a band of so many functions."""
    return Band(
        np.empty(size, np.complex128),
        np.empty(size, np.complex128),
        np.empty(size, np.complex128),
        np.empty((size, 5), np.complex128),
        np.empty((size, size), np.complex128),
        np.empty((3, size, size), np.complex128),
        np.empty((size, size), np.complex128),
    )


@jit
def add_dots(table, values, sums):
    """Add the products of a table and of values (BLOCK,) to partial sums (PARTS,)."""
    for i in range(PARTS):
        k = i + PARTS
        m = i + 2 * PARTS
        n = i + 3 * PARTS
        sums[i] += (table[i] * values[i] + table[k] * values[k]) + (table[m] * values[m] + table[n] * values[n])


@jit
def fill_moments(re, im, begin, count, angle, tables, padded, partial, moments):
    """Fill moments (4,) with the sums of re e^(i angle n), im e^(i angle n), n re e^(i angle n) and n im e^(i angle n)
    over `count` samples n = 0, 1, ... from sample `begin` on.

    Real sums, with tables of one block's turns, which the phase of each block turns on: nothing is rotated sample by
    sample. Rooms: tables (4, BLOCK), padded (2, BLOCK), partial (8, PARTS).
    """
    for part in range(4):
        moments[part] = 0j
    for first in range(0, count, BLOCK):
        at = begin + first
        if count - first >= BLOCK:
            x, y = re[at : at + BLOCK], im[at : at + BLOCK]
        else:
            x, y = padded[0], padded[1]
            for i in range(count - first):
                x[i], y[i] = re[at + i], im[at + i]
            for i in range(count - first, BLOCK):
                x[i] = 0.0
                y[i] = 0.0
        partial[:] = 0.0
        for row in range(4):
            add_dots(tables[row], x, partial[2 * row])
            add_dots(tables[row], y, partial[2 * row + 1])
        for row in range(8):
            p = partial[row]
            for i in range(PARTS // 2):
                p[i] += p[i + PARTS // 2]
            p[0] = ((p[0] + p[4]) + (p[1] + p[5])) + ((p[2] + p[6]) + (p[3] + p[7]))
        turn = complex(math.cos(angle * first), math.sin(angle * first))
        for part in range(2):
            plain = turn * complex(partial[part, 0], partial[2 + part, 0])
            moments[part] += plain
            moments[2 + part] += turn * complex(partial[4 + part, 0], partial[6 + part, 0]) + first * plain


@jit
def basis_sums(re, im, begin, half, step, room, sums):
    """Fill sums (basis, 5) of a loop from sample `begin`, for the powers of z_j = exp(i step (j - (basis - 1)/2)): over
    the first half + 1 samples plain and times n + 1, over the next `half` samples plain and times half - n; and
    z_j^(half + 1).

    The sums of a real signal at opposite angles are conjugate: those of re and im serve both.
    """
    tables, padded, partial, moments = room
    size = sums.shape[0]
    for j in range(size // 2, size):
        angle = step * (j - (size - 1) / 2)
        other = size - 1 - j
        fill_turns(angle, tables[0], tables[1])
        for i in range(BLOCK):
            tables[2, i], tables[3, i] = i * tables[0, i], i * tables[1, i]
        for part in range(2):
            first = begin if part == 0 else begin + half + 1
            count = half + 1 if part == 0 else half
            fill_moments(re, im, first, count, angle, tables, padded, partial, moments)
            for sign in range(2):
                x = moments[0]
                y = moments[1]
                p = moments[2]
                q = moments[3]
                if sign == 1:
                    x = x.conjugate()
                    y = y.conjugate()
                    p = p.conjugate()
                    q = q.conjugate()
                plain = x + 1j * y
                weighted = p + 1j * q
                row = j if sign == 0 else other
                sums[row, 2 * part] = plain
                sums[row, 2 * part + 1] = weighted + plain if part == 0 else half * plain - weighted
        whole = complex(math.cos(angle * (half + 1)), math.sin(angle * (half + 1)))
        sums[j, 4], sums[other, 4] = whole, whole.conjugate()


@jit
def fill_overlaps(edges, half, z, sums, overlaps):
    """Fill overlaps (3, basis, basis), U_0, U_1 and U_2, from the sums (basis, 5) of the functions z (basis,).

    edges (2, 3): the values of the loop at samples p, p + half + 1 and p + 2 half + 1 for p = 0 and 1, which leave and
    enter the sums as these move on by a sample.
    """
    functions = z.size
    first = sums[:, 0].copy()
    weighted = np.empty(functions, np.complex128)
    second = sums[:, 2].copy()
    whole = sums[:, 4]
    between = np.empty((functions, functions), np.complex128)
    for j in range(functions):
        weighted[j] = sums[j, 1] + whole[j] * sums[j, 3]
        for k in range(j):
            between[j, k] = 1.0 / (z[j] - z[k])
    for p in range(3):
        for j in range(functions):
            overlaps[p, j, j] = weighted[j]
            for k in range(j):
                apart = z[j] * first[j] - z[k] * first[k] + whole[j] * z[k] * second[k] - whole[k] * z[j] * second[j]
                overlaps[p, j, k] = apart * between[j, k]
                overlaps[p, k, j] = overlaps[p, j, k]
        if p == 2:
            break
        old, middle, last = edges[p]
        for j in range(functions):
            inverse = z[j].conjugate()
            power = whole[j] * inverse
            weighted[j] = (weighted[j] - first[j] + whole[j] * second[j] + last * whole[j] * power) * inverse
            first[j] = (first[j] - old) * inverse + middle * power
            second[j] = (second[j] - middle) * inverse + last * power * inverse


@jit
def solve(matrix, x):
    """Solve matrix y = x in place, x by y, by elimination with pivots; matrix is overwritten."""
    n = x.size
    for column in range(n):
        pivot = column
        most = -1.0
        for row in range(column, n):
            size = abs(matrix[row, column].real) + abs(matrix[row, column].imag)
            if size > most:
                pivot = row
                most = size
        if pivot != column:
            for k in range(column, n):
                other = matrix[pivot, k]
                matrix[pivot, k] = matrix[column, k]
                matrix[column, k] = other
            value = x[pivot]
            x[pivot] = x[column]
            x[column] = value
        if most == 0.0:
            matrix[column, column] = 1e-300
        inverse = 1.0 / matrix[column, column]
        for row in range(column + 1, n):
            factor = matrix[row, column] * inverse
            for k in range(column + 1, n):
                matrix[row, k] -= factor * matrix[column, k]
            x[row] -= factor * x[column]
        matrix[column, column] = inverse
    for column in range(n - 1, -1, -1):
        for k in range(column + 1, n):
            x[column] -= matrix[column, k] * x[k]
        x[column] *= matrix[column, column]


@jit
def form(x, matrix):
    """Return x^T matrix x."""
    value = 0j
    for j in range(x.size):
        row = 0j
        for k in range(x.size):
            row += matrix[j, k] * x[k]
        value += x[j] * row
    return value


@jit
def remove(known, count, overlaps, x):
    """Take from x (basis,) its parts along the first `count` of known eigenvectors (lines, basis)."""
    functions = x.size
    for i in range(count):
        vector = known[i]
        along = 0j
        norm = 0j
        for j in range(functions):
            row = 0j
            for k in range(functions):
                row += overlaps[0, j, k] * vector[k]
            along += x[j] * row
            norm += vector[j] * row
        if norm != 0.0:
            factor = along / norm
            for j in range(functions):
                x[j] -= factor * vector[j]


@jit
def converge(band, known, u, least):
    """Return the eigenvalue of a band next to u, and the norm x^T U_0 x of its vector x, which is its start; NaN where
    there is none. The first `known` eigenvectors are kept out.

    least: change of the eigenvalue after which there is no other iteration.
    """
    x = band.x
    y = band.y
    matrix = band.matrix
    overlaps = band.overlaps
    norm = 0j
    functions = x.size
    for _ in range(ITERATIONS):
        remove(band.known, known, overlaps, x)
        for j in range(functions):
            y[j] = 0j
            for k in range(functions):
                y[j] += overlaps[0, j, k] * x[k]
                matrix[j, k] = overlaps[1, j, k] - u * overlaps[0, j, k]
        for j in range(functions):
            x[j] = y[j]
        solve(matrix, x)
        most = 0.0
        for j in range(functions):
            most = max(most, abs(x[j].real) + abs(x[j].imag))
        if not most > 0.0 or not math.isfinite(most):
            return complex(math.nan, 0.0), 0j
        for j in range(functions):
            x[j] /= most
        norm = form(x, overlaps[0])
        if norm == 0.0:
            return complex(math.nan, 0.0), 0j
        now = form(x, overlaps[1]) / norm
        change = abs(now - u)
        u = now
        if not change > least:
            break
    return u, norm


@jit
def start(z, half, x):
    """Start with the two middle functions z, in phase in the middle of the first half of the samples."""
    functions = z.size
    middle = functions // 2
    for j in range(functions):
        x[j] = 0j
    for j in range(middle - 1, middle + 1):
        angle = 0.5 * half * math.atan2(z[j].imag, z[j].real)
        x[j] = complex(math.cos(angle), -math.sin(angle))


@jit
def residual_of(overlaps, x, u, norm):
    """Return the residual |u_2 - u^2| of a line, where u_2 is the quotient of U_2; NaN where there is no line."""
    return abs(form(x, overlaps[2]) / norm - u * u) if norm != 0.0 else math.nan


@jit
def mean_turn(re, im, begin, weights, sums):
    """Return the turn, in cycles, from one sample of a loop to the next, by its sums with weights from sample `begin`
    on: that of a line, and an average over lines that are closer than the window resolves. sums (BLOCK,): scratch.
    """
    end = begin + weights.size
    x = weighted_sum(weights, re[begin:end], sums)
    y = weighted_sum(weights, im[begin:end], sums)
    p = weighted_sum(weights, re[begin + 1 : end + 1], sums)
    q = weighted_sum(weights, im[begin + 1 : end + 1], sums)
    return math.atan2(q * x - p * y, p * x + q * y) / (2.0 * math.pi)


@jit
def next_line(re, im, begin, length, band, edges, room):
    """Return the eigenvalue u of the line next to frequency 0 of a loop (samples,) in a window, and its residual, see
    `residual_of`; edges (2, 3), and room as of basis_sums: scratch.
    """
    z = band.z
    x = band.x
    overlaps = band.overlaps
    functions = z.size
    half = (length - 3) // 2
    step = -2.0 * math.pi * SPACING / length
    for j in range(functions):
        turn = step * (j - (functions - 1) / 2)
        z[j] = complex(math.cos(turn), math.sin(turn))
    basis_sums(re, im, begin, half, step, room, band.sums)
    for p in range(2):
        for place, away in enumerate((0, half + 1, 2 * half + 1)):
            edges[p, place] = complex(re[begin + p + away], im[begin + p + away])
    fill_overlaps(edges, half, z, band.sums, overlaps)
    start(z, half, x)
    u, norm = converge(band, 0, 1.0 + 0j, 2.0 * math.pi * CONVERGED / length)
    return u, residual_of(overlaps, x, u, norm)


def invert_loops(unit, stop, progress, signals, loops, nu, interval, windows, lines):
    """Fill lines (orbits, loops, windows) with those next to nu (orbits, loops), in cycles per unit time, of the loops
    of an orbit; a loop with nu = 0 has none.

    signals: the s of all orbits, see `rows_of`; interval (orbits,).
    """
    if read_now(stop, 0) > 0:
        return
    s = rows_of(signals, unit)
    samples = s.shape[1]
    re = np.empty(samples)
    im = np.empty(samples)
    tables = np.empty((4, BLOCK))
    scratch = np.empty(BLOCK)
    wide = new_band(LINE_BASIS)
    narrow = new_band(PEAK_BASIS)
    edges = np.empty((2, 3), np.complex128)
    room = tables, np.empty((2, BLOCK)), np.empty((8, PARTS)), np.empty(4, np.complex128)
    for k in range(loops.c.shape[1]):
        if nu[unit, k] == 0.0:
            continue
        offset = loops.offset[unit, k]
        drift = loops.drift[unit, k]
        for i in range(samples):
            re[i] = -offset.real - drift.real * i
            im[i] = -offset.imag - drift.imag * i
        add_rows(loops.c[unit, k], s, 0, samples, re, im)
        turn = -2.0 * math.pi * nu[unit, k] * interval[unit]
        fill_turns(turn, tables[0], tables[1])
        for first in range(0, samples, BLOCK):
            x, y = math.cos(turn * first), math.sin(turn * first)
            for i in range(BLOCK):
                tables[2, i] = tables[0, i] * x - tables[1, i] * y
                tables[3, i] = tables[0, i] * y + tables[1, i] * x
            f = re[first : min(first + BLOCK, samples)]
            g = im[first : min(first + BLOCK, samples)]
            for i in range(f.size):
                value = f[i] * tables[2, i] - g[i] * tables[3, i]
                other = f[i] * tables[3, i] + g[i] * tables[2, i]
                f[i] = value
                g[i] = other
        for w in range(windows.begin.shape[1]):
            begin = windows.begin[unit, w]
            length = windows.length[unit, w]
            if length < LEAST:
                continue
            place = windows.place[unit, w]
            if place >= 0:
                weights = windows.weights[place : place + length - 1]
                lines.mean[unit, k, w] = mean_turn(re, im, begin, weights, scratch)
            if windows.basis[w] != 0:
                band = wide if windows.basis[w] == LINE_BASIS else narrow
                u, residual = next_line(re, im, begin, length, band, edges, room)
                lines.shift[unit, k, w] = math.atan2(u.imag, u.real) / (2.0 * math.pi)
                lines.growth[unit, k, w] = math.log(abs(u)) / (2.0 * math.pi) if abs(u) > 0.0 else math.nan
                lines.residual[unit, k, w] = residual / (4.0 * math.pi)
    progress[unit] = 1.0
