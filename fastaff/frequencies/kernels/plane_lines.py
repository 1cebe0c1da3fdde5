"""Lines of complex signals with their amplitudes: those of their peaks, and those beside these, by harmonic inversion.

The amplitude of a line with the eigenvector B is (B^T c)^2 / (B^T U_0 B), c_j the sum of f_n z_j^n: see
`harmonic_inversion`. Places and error bars are in bins, cycles over the samples.
"""

from __future__ import annotations

import math

import numpy as np

from ...engine.jit import jit, read_now
from .harmonic_inversion import CONVERGED, PEAK_BASIS, new_band, start
from .loop_lines import REACH, SAME, WEAKEST, WIDE, keep_vector, open_band, read_line, start_beside, turn_of
from .spectrum_lines import find_peaks

DOUBLE = 1e-8
"""Disagreement of the bins of a peak, in bins, from which it may hold several lines."""

EQUAL = 1e-6
"""Distance in bins, beyond their error bars, within which lines of two bands are one."""

BROAD = 1.0
"""Error bar, in bins, from which a line is none."""


@jit
def insert_line(lines, count, place, bar, amplitude):
    """Insert a line among the first `count` by size, the largest first, unless it is there, found in another band;
    return their number.
    """
    places, bars, amplitudes = lines
    size = abs(amplitude)
    for i in range(count):
        if abs(places[i] - place) < min(bars[i] + bar, SAME) + EQUAL:
            bars[i] = max(bars[i], abs(places[i] - place))
            return count
    at = count
    while at > 0 and abs(amplitudes[at - 1]) < size:
        at -= 1
    if at == places.size:
        return count
    end = min(count, places.size - 1)
    for i in range(end, at, -1):
        places[i], bars[i], amplitudes[i] = places[i - 1], bars[i - 1], amplitudes[i - 1]
    places[at] = place
    bars[at] = bar
    amplitudes[at] = amplitude
    return end + 1


def lines_of_planes(unit, stop, progress, windowed, sums, edges, order, beside, place, bar, amplitude):
    """Fill place, bar, amplitude (signals, lines) with the lines of a signal by its transforms, see
    `loop_transforms.prepare_values`; missing ones have an infinite bar. A peak without a line counts as one with the
    bar WIDE and an amplitude of its size alone. beside: 1 to seek lines that make no peaks.
    """
    if read_now(stop, 0) > 0:
        return
    samples = windowed.shape[1]
    most = place.shape[1]
    lines = place[unit], bar[unit], amplitude[unit]
    peaks = np.empty(most)
    sizes = np.empty(most)
    doubts = np.empty(most)
    read, _ = find_peaks(windowed[unit], order, WEAKEST, 0, peaks, sizes, doubts)
    band = new_band(PEAK_BASIS)
    count = 0
    lines[0][:] = 0.0
    lines[1][:] = math.inf
    lines[2][:] = 0j
    for i in range(read):
        if peaks[i] > 0.5 * samples:
            peaks[i] -= samples
        guess = peaks[i]
        open_band(sums[unit], edges[unit], samples, guess / samples, band)
        start(band.z, (samples - 3) // 2, band.x)
        own, width, a = read_line(band, 0, turn_of(guess / samples), samples, guess, CONVERGED)
        if not width < BROAD or abs(own - guess) > REACH:
            continue
        count = insert_line(lines, count, own, width, a)
        if beside == 0 or doubts[i] < DOUBLE:
            continue
        known = 1
        middle = PEAK_BASIS // 2
        keep_vector(band, 0)
        for tried, function in enumerate((middle - 2, middle + 1, middle - 3, middle + 2)):
            # Where neither side of the peak shows a line there is none farther away.
            if tried == 2 and known == 1:
                break
            u = start_beside(band, function)
            own, width, a = read_line(band, known, u, samples, guess, CONVERGED)
            if width < BROAD and abs(own - guess) < order + REACH and abs(a) > WEAKEST * sizes[0]:
                count = insert_line(lines, count, own, width, a)
                keep_vector(band, known)
                known += 1
    for i in range(read):
        near = False
        for j in range(count):
            near = near or abs(lines[0][j] - peaks[i]) < REACH
        if not near:
            count = insert_line(lines, count, peaks[i], WIDE, complex(sizes[i], 0.0))
    progress[unit] = 1.0
