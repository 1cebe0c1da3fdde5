"""Lines of a loop: the peaks of its windowed Fourier transform, and by harmonic inversion the lines of their bands.

Places, widths and error bars are in bins, cycles over the samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import jit, read_now
from .harmonic_inversion import PEAK_BASIS, converge, fill_overlaps, form, new_band, residual_of, start
from .spectrum_lines import find_peaks

SAFETY = 20.0
"""Factor of a line's error bar over its growth and its residual, where no other window is compared."""

ROUNDED = 1e-5
"""Addition to error bars, in bins: lines of a lattice that are this close are one."""

STEADY = 1e-3
"""Change of a line, in bins, after which no iteration is needed: the next is about its cube, and ROUNDED is more."""

REACH = 1.5
"""Largest distance, in bins, of a line from its peak."""

DOUBLE = 0.05
"""Disagreement of the bins of a peak, in bins, from which it may hold several lines."""

LARGE = 0.03
"""Size of a peak, relative to the largest, from which lines beside its own one are sought."""

SAME = 0.1
"""Distance in bins within which two lines are one."""

FEWEST = 1e-6
"""Size, relative to the largest peak's, from which a peak is a line."""

WEAKEST = 1e-12
"""The same beside lines that were taken from a loop."""

DEFINITE = 0.1
"""Error bar, in bins, up to which a line has the size of its eigenvector, else that of its peak: the largest peak of a
loop stays the largest line where no line is sharp.
"""

WIDE = 9.0
"""Error bar, in bins, of a peak without a line of its own."""


class LoopLines(NamedTuple):
    """Lines of a loop, those of its peaks first, the largest of these first: place, signed, size, the error bar, and
    the disagreement of the bins of the peak, arrays (lines,).
    """

    place: np.ndarray
    size: np.ndarray
    bar: np.ndarray
    doubt: np.ndarray


@jit
def turn_of(cycles):
    """Return the complex number of that many cycles."""
    angle = 2.0 * math.pi * cycles
    return complex(math.cos(angle), math.sin(angle))


@jit
def open_band(transform, edges, samples, guess, band):
    """Fill the matrices of the band around a guess, in cycles per sample, from a loop's transforms (SUMS, size)."""
    size = transform.shape[1]
    half = (samples - 3) // 2
    first = math.floor(guess * size) - (band.z.size // 2 - 1)
    for j in range(band.z.size):
        number = (first + j) % size
        for part in range(4):
            band.sums[j, part] = transform[part, number]
        band.z[j] = turn_of(-number / size)
        band.sums[j, 4] = turn_of(-((number * (half + 1)) % size) / size)
    fill_overlaps(edges, half, band.z, band.sums, band.overlaps)


@jit
def read_line(band, known, u, samples, guess, steady):
    """Return place and error bar, in bins, and the amplitude at the first sample of the line next to u in a band; the
    bar is inf where there is none. The first `known` eigenvectors are kept out; x is the start, and becomes the line's
    vector.

    steady: change of the line, in bins, after which no iteration is needed.
    """
    u, norm = converge(band, known, u, 2.0 * math.pi * steady / samples)
    if not abs(u) > 0.0 or not abs(norm) > 0.0:
        return guess, math.inf, 0j
    residual = residual_of(band.overlaps, band.x, u, norm)
    along = 0j
    for j in range(band.z.size):
        along += band.x[j] * band.sums[j, 0]
    place = math.atan2(u.imag, u.real) / (2.0 * math.pi) * samples
    place += samples * math.floor((guess - place) / samples + 0.5)
    growth = abs(math.log(abs(u))) / (2.0 * math.pi)
    bar = SAFETY * max(growth, residual / (4.0 * math.pi)) * samples
    return place, (bar if bar < math.inf else math.inf), along * along / norm


@jit
def start_beside(band, function):
    """Start with one function of a band alone, in x; return the quotient of its matrices, a guess of an eigenvalue."""
    for j in range(band.z.size):
        band.x[j] = 1.0 if j == function else 0.0
    norm = form(band.x, band.overlaps[0])
    return form(band.x, band.overlaps[1]) / norm if abs(norm) > 0.0 else 1.0 + 0j


@jit
def keep_vector(band, known):
    """Keep x as a known eigenvector of that number."""
    for j in range(band.z.size):
        band.known[known, j] = band.x[j]


@jit
def is_new(lines, first, last, place):
    """Return whether no line from number `first` to `last` is at that place."""
    new = True
    for i in range(first, last):
        new = new and abs(lines.place[i] - place) >= SAME
    return new


@jit
def split_peak(band, guess, samples, reach, least, lines, read, begin, count):
    """Add the other lines, not smaller than `least`, of the band of a peak, whose own line is its first known vector,
    to those of the `read` peaks and those from number `begin` to `count`; return the new end.
    """
    known = 1
    middle = band.z.size // 2
    for function in (middle - 2, middle + 1, middle - 3, middle + 2):
        if count == lines.place.size:
            break
        u = start_beside(band, function)
        place, bar, amplitude = read_line(band, known, u, samples, guess, STEADY)
        bar += ROUNDED
        size = abs(amplitude)
        new = is_new(lines, 0, read, place) and is_new(lines, begin, count, place)
        if new and bar < 1.0 and abs(place - guess) < reach and size > least:
            lines.place[count] = place
            lines.size[count] = size
            lines.bar[count] = bar
            lines.doubt[count] = WIDE
            count += 1
            keep_vector(band, known)
            known += 1
    return count


@jit
def read_peaks(transform, edges, samples, first, last, lines, band):
    """Set place, size and error bar of the lines of the peaks from number `first` to `last`."""
    for i in range(first, last):
        guess = lines.place[i]
        doubt = lines.doubt[i]
        open_band(transform, edges, samples, guess / samples, band)
        start(band.z, (samples - 3) // 2, band.x)
        place, bar, amplitude = read_line(band, 0, turn_of(guess / samples), samples, guess, STEADY)
        bar += ROUNDED
        lines.bar[i] = max(WIDE, 3.0 * doubt)
        if bar < WIDE and abs(place - guess) < REACH and is_new(lines, 0, i, place):
            lines.place[i] = place
            lines.bar[i] = bar
            if bar < DEFINITE:
                lines.size[i] = abs(amplitude)


@jit
def split_peaks(transform, edges, samples, order, split, read, minor, lines, begin, band):
    """Write from number `begin` on the lines beside those of the first `split` peaks whose bins disagree, of a size
    relative to the largest peak's of `minor` or more, that are none of the `read` peaks' own; return their end.
    """
    count = begin
    for i in range(split):
        if lines.doubt[i] > DOUBLE and lines.size[i] > LARGE * lines.size[0]:
            guess = lines.place[i]
            open_band(transform, edges, samples, guess / samples, band)
            start(band.z, (samples - 3) // 2, band.x)
            _, bar, _ = read_line(band, 0, turn_of(guess / samples), samples, guess, STEADY)
            if bar < math.inf:
                keep_vector(band, 0)
                least = minor * lines.size[0]
                count = split_peak(band, guess, samples, order + 1.5, least, lines, read, begin, count)
    return count


@jit
def signed_places(lines, count, samples):
    """Count the bins of the first lines from 0 to both sides."""
    for i in range(count):
        if lines.place[i] > 0.5 * samples:
            lines.place[i] -= samples


def lines_of_values(unit, stop, progress, windowed, sums, edges, order, place, size, bar):
    """Fill place, size, bar (loops, lines) with the lines of a loop by its transforms; see `prepare_values`."""
    if read_now(stop, 0) == 0:
        lines = LoopLines(place[unit], size[unit], bar[unit], np.empty(place.shape[1]))
        samples = windowed.shape[1]
        count, _ = find_peaks(windowed[unit], order, WEAKEST, 0, lines.place, lines.size, lines.doubt)
        signed_places(lines, count, samples)
        read_peaks(sums[unit], edges[unit], samples, 0, count, lines, new_band(PEAK_BASIS))
        for i in range(count, place.shape[1]):
            place[unit, i] = 0.0
            size[unit, i] = 0.0
            bar[unit, i] = math.inf
        progress[unit] = 1.0
