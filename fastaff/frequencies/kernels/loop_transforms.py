"""Loops Q - i P of orbits, prepared for their Fourier transforms: windowed, and as the sums of harmonic inversion.

A loop has no mean and no mean growth and is in units of the sizes of Q and P. Its windowed transform shows where lines
are; the transforms of its two halves, plain and times a ramp, are the sums from which `harmonic_inversion` makes the
matrices of any band.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import jit, read_now
from .fundamental import BLOCK, SignalRows, growth, rows_of, total

SUMS = 4
"""Transforms of a loop for harmonic inversion: of the first half and of the second, each plain and times a ramp."""


class Spectra(NamedTuple):
    """Fourier transforms of windowed loops of the first n samples (orbits,) of signals: those of an orbit (m, n) from
    its start (orbits,) on; and the `SignalRows` of their signals.
    """

    numbers: np.ndarray
    start: np.ndarray
    n: np.ndarray
    rows: SignalRows


class Bands(NamedTuple):
    """Fourier transforms of the sums of loops: those of an orbit (m, SUMS, size) from its start (orbits,) on, size
    (orbits,); and the values of loops where the sums begin and end, edges (orbits, m, 2, 3), see
    `harmonic_inversion.fill_overlaps`.
    """

    numbers: np.ndarray
    start: np.ndarray
    size: np.ndarray
    edges: np.ndarray


@jit
def moments(row, window, sums, squares):
    """Return the weighted mean of a row (samples,) and its weighted root mean square about it; sums, squares (BLOCK,):
    scratch.
    """
    for i in range(BLOCK):
        sums[i] = 0.0
        squares[i] = 0.0
    first = row[0]
    for start in range(0, row.size, BLOCK):
        part = row[start : start + BLOCK]
        weight = window[start : start + BLOCK]
        for i in range(part.size):
            sums[i] += weight[i] * (part[i] - first)
        for i in range(part.size):  # a separate loop: LLVM proves only few arrays distinct in one
            value = part[i] - first
            squares[i] += weight[i] * value * value
    away = total(sums)
    return first + away, math.sqrt(max(total(squares) - away * away, 0.0))


@jit
def _grows(source):
    """Return whether samples may grow as `growth` requires: over each half of the time they change in one direction. A
    few samples exclude most oscillations.
    """
    first = source[0]
    last = source[source.size - 1]
    half = source.size // 2 + 1
    back = 0
    if not abs(last - first) > abs(source[source.size // 2] - first):
        return False
    for i in range(0, source.size - half, source.size // 16 + 1):
        back += 1 if (source[i + half] > source[i]) != (last > first) else 0
    return back == 0


@jit
def fill_row(source, centre, change, unit, row):
    """Fill row (samples,) with the source without centre and mean change per sample, times a unit."""
    if change == 0.0:
        for i in range(row.size):
            row[i] = (source[i] - centre) * unit
    else:
        for i in range(row.size):
            row[i] = (source[i] - centre - change * i) * unit


@jit
def fill_transforms(re, im, weight, windowed, sums, edges):
    """Fill windowed (2 samples,) and sums (SUMS, 2 size), as real numbers, with a loop for its Fourier transforms, and
    its edges (2, 3).
    """
    samples = re.size
    size = sums.shape[1] // 2
    half = (samples - 3) // 2
    for i in range(samples):
        windowed[2 * i] = re[i] * weight[i]
        windowed[2 * i + 1] = im[i] * weight[i]
    for part in range(2):
        plain = sums[2 * part]
        ramped = sums[2 * part + 1]
        first, count = (0, half + 1) if part == 0 else (half + 1, half)
        slope, base = (1.0, 1.0) if part == 0 else (-1.0, float(half))
        for i in range(count):
            x, y = re[first + i], im[first + i]
            ramp = base + slope * i
            plain[2 * i] = x
            plain[2 * i + 1] = y
            ramped[2 * i] = ramp * x
            ramped[2 * i + 1] = ramp * y
        for i in range(2 * count, 2 * size):
            plain[i] = 0.0
            ramped[i] = 0.0
    for p in range(2):
        for place, away in enumerate((0, half + 1, 2 * half + 1)):
            edges[p, place] = complex(re[p + away], im[p + away])


def prepare_transforms(unit, stop, progress, signals, tables, at_rest, spectra, bands):
    """Fill spectra and bands, as real numbers, with the loops Q - i P of an orbit, for their Fourier transforms.

    signals: see `rows_of`; tables: the window of means, the weight (samples,), and the tables (3, samples - 1) of
    `growth`; at_rest: product of the sizes of Q and P, relative to the largest, up to which a loop is at rest.
    """
    if read_now(stop, 0) > 0:
        return
    drift, centre, size, moving = spectra.rows
    n = spectra.n[unit]
    m = moving.shape[1]
    s = rows_of(signals, unit)
    own = tables.numbers[tables.start[unit] :]
    window = own[:n]
    weight = own[n : 2 * n]
    growing = own[2 * n : 2 * n + 3 * (n - 1)].reshape((3, n - 1))
    width = bands.size[unit]
    windowed = spectra.numbers[2 * spectra.start[unit] :]
    sums = bands.numbers[2 * bands.start[unit] :]
    room = np.empty(BLOCK)
    squares = np.empty(BLOCK)
    re = np.empty(n)
    im = np.empty(n)
    largest = 0.0
    for r in range(2 * m):
        source = s[r, :n]
        drift[unit, r] = growth(source, growing, re, room) if _grows(source) else 0.0
        fill_row(source, 0.0, drift[unit, r], 1.0, re)
        centre[unit, r], size[unit, r] = moments(re, window, room, squares)
    for j in range(m):
        largest = max(largest, size[unit, 2 * j] * size[unit, 2 * j + 1])
    for j in range(m):
        q = 2 * j
        p = 2 * j + 1
        moving[unit, j] = size[unit, q] * size[unit, p] > at_rest * largest
        for r in (q, p):
            size[unit, r] = size[unit, r] if size[unit, r] > 0.0 else 1.0
        share = 1.0 if moving[unit, j] else 0.0
        fill_row(s[q, :n], centre[unit, q], drift[unit, q], share / size[unit, q], re)
        fill_row(s[p, :n], centre[unit, p], drift[unit, p], -share / size[unit, p], im)
        mine = sums[2 * SUMS * width * j : 2 * SUMS * width * (j + 1)].reshape((SUMS, 2 * width))
        fill_transforms(re, im, weight, windowed[2 * n * j : 2 * n * (j + 1)], mine, bands.edges[unit, j])
    progress[unit] = 1.0


def prepare_values(unit, stop, progress, values, weight, windowed, sums, edges):
    """Fill windowed (loops, 2 samples), sums (loops, SUMS, 2 size) and edges (loops, 2, 3) with the loop of a number by
    its values (loops, 2 samples), as real numbers.
    """
    if read_now(stop, 0) > 0:
        return
    own = values[unit]
    re, im = np.empty(weight.size), np.empty(weight.size)
    for i in range(weight.size):
        re[i], im[i] = own[2 * i], own[2 * i + 1]
    fill_transforms(re, im, weight, windowed[unit], sums[unit], edges[unit])
    progress[unit] = 1.0
