"""Loops of single modes: the rows dual to the amplitudes of an orbit's generators."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import jit, read_now
from .fundamental import BLOCK, fill_turns, rows_of, total


class Duals(NamedTuple):
    """Amplitudes (orbits, 2m, 2m) of lines, then of their negatives, in the rows in units of their sizes; dual (orbits,
    m, 2m), the rows dual to these; and share (orbits, m, m), that which line k has of the motion of loop j. Entries
    without a line are 0.
    """

    amplitude: np.ndarray
    dual: np.ndarray
    share: np.ndarray


SINGULAR = 1e-9
"""Relative size of a pivot up to which amplitudes are not independent."""


@jit
def project(unit, signals, samples, windows, interval, scaling, rank, nu, P, G):
    """Fill P (rows, n) with the sums w s exp(-2 pi i nu t) of an orbit, and G with the lines' own (2n, 2n).

    signals: see `rows_of`; the first `samples` (orbits,) of them count; scaling: drift and centre, which are
    subtracted, and sizes (orbits, rows). The lines of a Gram matrix are those at nu, then those at -nu; a window sums
    to 1 and is symmetric, so their products are real; time counts from its middle.
    """
    own = rows_of(signals, unit)
    r = rank[unit]
    n = P.shape[0]
    length = samples[unit]
    window = windows.numbers[windows.start[unit] : windows.start[unit] + length]
    drift, centre, units = scaling
    wave = np.empty((r, 2, BLOCK))
    cosine = np.empty((r, BLOCK))
    sine = np.empty((r, BLOCK))
    row = np.empty(BLOCK)
    sums = np.zeros((r, n, 2, BLOCK))
    pairs = np.zeros((r, r, 2, BLOCK))
    for k in range(r):
        fill_turns(2.0 * math.pi * nu[unit, k] * interval[unit], wave[k, 0], wave[k, 1])
    for start in range(0, length, BLOCK):
        width = min(BLOCK, length - start)
        w = window[start : start + width]
        for k in range(r):
            phase = 2.0 * math.pi * nu[unit, k] * interval[unit] * (start - 0.5 * (length - 1))
            x = math.cos(phase)
            y = math.sin(phase)
            c = cosine[k]
            d = sine[k]
            a = wave[k, 0]
            b = wave[k, 1]
            for i in range(width):
                c[i] = a[i] * x - b[i] * y
                d[i] = a[i] * y + b[i] * x
            for m in range(k + 1):
                e = cosine[m]
                f = sine[m]
                direct = pairs[k, m, 0]
                mirror = pairs[k, m, 1]
                for i in range(width):
                    direct[i] += w[i] * (c[i] * e[i] + d[i] * f[i])
                    mirror[i] += w[i] * (c[i] * e[i] - d[i] * f[i])
            for i in range(width):
                c[i] *= w[i]
                d[i] *= w[i]
            for j in range(n):
                source = own[j, start : start + width]
                re = sums[k, j, 0]
                im = sums[k, j, 1]
                growth_now = drift[unit, j]
                mean = centre[unit, j]
                size = units[unit, j]
                for i in range(width):
                    row[i] = (source[i] - mean - growth_now * (start + i)) * size
                for i in range(width):
                    re[i] += c[i] * row[i]
                    im[i] -= d[i] * row[i]
            for i in range(width):  # the next line's products need them without the window
                c[i] = a[i] * x - b[i] * y
                d[i] = a[i] * y + b[i] * x
    for k in range(r):
        for j in range(n):
            P[j, k] = complex(total(sums[k, j, 0]), total(sums[k, j, 1]))
        for m in range(k + 1):
            direct = total(pairs[k, m, 0])
            mirror = total(pairs[k, m, 1])
            for i, j in ((k, m), (m, k)):
                G[i, j] = G[r + i, r + j] = direct
                G[i, r + j] = G[r + i, j] = mirror


@jit
def solve(matrix, right, n):
    """Solve matrix x = right in place (n, columns), complex, by elimination; return whether that was possible."""
    most = 0.0
    for i in range(n):
        for j in range(n):
            most = max(most, abs(matrix[i, j].real) + abs(matrix[i, j].imag))
    for i in range(n):
        pivot = i
        size = 0.0
        for j in range(i, n):
            here = abs(matrix[j, i].real) + abs(matrix[j, i].imag)
            if here > size:
                pivot = j
                size = here
        if not size > SINGULAR * most:
            return False
        for c in range(n):
            matrix[i, c], matrix[pivot, c] = matrix[pivot, c], matrix[i, c]
        for c in range(right.shape[1]):
            right[i, c], right[pivot, c] = right[pivot, c], right[i, c]
        inverse = 1.0 / matrix[i, i]
        for j in range(n):
            if j != i:
                factor = matrix[j, i] * inverse
                for c in range(i, n):
                    matrix[j, c] -= factor * matrix[i, c]
                for c in range(right.shape[1]):
                    right[j, c] -= factor * right[i, c]
    for i in range(n):
        inverse = 1.0 / matrix[i, i]
        for c in range(right.shape[1]):
            right[i, c] *= inverse
    return True


@jit
def fill_amplitudes(P, G, r, A):
    """Fill A (2r, rows) with the amplitudes of the lines nu, then of -nu, by `project`; return whether they exist."""
    rows = P.shape[0]
    matrix = np.empty((2 * r, 2 * r), np.complex128)
    for i in range(2 * r):
        for j in range(2 * r):
            matrix[i, j] = G[i, j]
        for j in range(rows):
            A[i, j] = P[j, i] if i < r else P[j, i - r].conjugate()
    return solve(matrix, A, 2 * r)


@jit
def fill_dual(A, r, dual):
    """Fill dual (r, rows) with the shortest rows that have a product of 1 with one of the amplitudes A (2r, rows) of
    the lines nu, and of 0 with the others; return whether they exist.
    """
    n, rows = A.shape
    matrix = np.empty((n, n), np.complex128)
    right = np.zeros((n, r), np.complex128)
    scale = np.zeros(n)
    for i in range(n):
        for j in range(rows):
            scale[i] += A[i, j].real ** 2 + A[i, j].imag ** 2
        if not 0.0 < scale[i] < math.inf:
            return False
        scale[i] = 1.0 / math.sqrt(scale[i])
    for k in range(r):
        right[k, k] = scale[k]
    square = n == rows
    for i in range(n):
        for k in range(n):
            if square:
                matrix[i, k] = A[i, k] * scale[i]
            else:
                matrix[i, k] = 0j
                for j in range(rows):
                    matrix[i, k] += A[i, j] * A[k, j].conjugate()
                matrix[i, k] *= scale[i] * scale[k]
    if not solve(matrix, right, n):
        return False
    for k in range(r):
        for j in range(rows):
            if square:
                dual[k, j] = right[j, k]
            else:
                dual[k, j] = 0j
                for i in range(n):
                    dual[k, j] += right[i, k] * scale[i] * A[i, j].conjugate()
    return True


@jit
def fill_own(share, r, dual):
    """Fill dual (m, rows) with the loop Q - i P in which each of the r lines has its largest share (m, m), where there
    are no dual rows: as many lines are in the same rows.
    """
    dual[:] = 0j
    for k in range(r):
        largest = 0
        for j in range(share.shape[1]):
            largest = j if share[k, j] > share[k, largest] else largest
        dual[k, 2 * largest] = 1.0 + 0j
        dual[k, 2 * largest + 1] = -1j


def dual_loops(unit, stop, progress, signals, samples, windows, interval, scaling, rank, nu, found):
    """Fill `found` with the amplitudes of an orbit's lines nu (orbits, m), rank (orbits,) of them, and what follows
    from these; see `project`.
    """
    if read_now(stop, 0) > 0:
        return
    amplitude, dual, share = found
    r = rank[unit]
    rows = amplitude.shape[2]
    if r > 0:
        P = np.zeros((rows, r), np.complex128)
        G = np.zeros((2 * r, 2 * r))
        project(unit, signals, samples, windows, interval, scaling, rank, nu, P, G)
        A = amplitude[unit, : 2 * r]
        if fill_amplitudes(P, G, r, A):
            for k in range(r):
                for j in range(rows // 2):
                    share[unit, k, j] = abs(A[k, 2 * j]) * abs(A[k, 2 * j + 1])
            if not fill_dual(A, r, dual[unit, :r]):
                fill_own(share[unit], r, dual[unit])
        else:
            amplitude[unit] = 0j
    progress[unit] = 1.0
