"""The lattice that the lines of an orbit's loops span: its generators, and what it leaves unexplained.

Frequencies and error bars are in bins, cycles over the samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...engine.jit import jit, read_now
from .fundamental import BLOCK, FrequencyLattice, generate, relate
from .harmonic_inversion import PEAK_BASIS, new_band
from .loop_lines import DOUBLE, FEWEST, LoopLines, read_peaks, signed_places, split_peaks
from .loop_transforms import SUMS
from .spectrum_lines import find_peaks, top_of

FIRST = 6
"""Peaks of each loop that are sought first."""

MORE = 10
"""Peaks that are sought, with the lines beside them, where the first leave the lattice incomplete."""

SLOWEST = 2.0
"""Bins from which a line is told from frequency 0."""

DOUBTFUL = 1.5
"""Largest distance, in bins, of two lines that are seen as one."""

CHANCE = 0.5
"""Expected number of accidental relations up to which a line counts as explained."""


class RankedLines(NamedTuple):
    """Lines of loops, the largest first: frequencies, error bars, and sizes relative to the loop's largest (orbits, m,
    lines).
    """

    value: np.ndarray
    bar: np.ndarray
    strength: np.ndarray


class LatticeLimits(NamedTuple):
    """Limits of a lattice: sharp, the error bar in bins up to which a line belongs to it; minor, the relative size from
    which one does; visible, from which it must be explained.
    """

    sharp: float
    minor: float
    visible: float


class FoundLattices(NamedTuple):
    """Lines of orbits and their lattices: lines; lattice; rest (orbits,), the largest share of a loop's size outside of
    its FIRST peaks; tail (orbits,), the largest size above three quarters of the highest frequency of the samples,
    relative to the loop's largest; unexplained_size (orbits,): the relative size of the largest line that the lattice
    does not explain.
    """

    lines: RankedLines
    lattice: FrequencyLattice
    rest: np.ndarray
    tail: np.ndarray
    unexplained_size: np.ndarray


@jit
def divides(value, bar, nu, bars, rank, table, count, related, k):
    """Return whether generators are multiples of a line, or its multiples are combinations of them while the line is
    not (`related` False): then they span only a part of the lattice.

    A line whose bar is DOUBLE a bin or more may be two, each up to DOUBTFUL bins from it.
    """
    for m in range(2, 4):
        for i in range(rank):
            width = DOUBTFUL if bar > DOUBLE else min(max(bar, 0.05), 0.5)
            if abs(m * value - nu[i]) < m * width:
                return True
        if not related and relate(m * value, 0.3 * m, nu, bars, rank, table, count, CHANCE, k):
            return True
    return False


@jit
def size_of_tail(spectrum):
    """Return the largest size of a windowed transform above three quarters of the highest frequency."""
    samples = spectrum.size
    high = 0.0
    power = np.empty(BLOCK)
    best = np.empty(BLOCK // 4)
    for at in range(3 * samples // 8, 5 * samples // 8, BLOCK):
        own = spectrum[at : min(at + BLOCK, 5 * samples // 8)]
        for i in range(own.size):
            power[i] = own[i].real * own[i].real + own[i].imag * own[i].imag
        high = max(high, top_of(power[: own.size], best))
    return math.sqrt(high)


@jit
def rank_lines(lines, moving, limits, values, bars):
    """Write frequencies and bars of the lines that belong to the lattice, the dominant ones first, then the others by
    size; return their number, 0 where a loop's dominant line is not sharp: sharper ones may be its multiples.
    """
    value, bar, strength = lines
    used = 0
    key = np.zeros(values.size)
    for j in range(moving.size):
        for i in range(value.shape[1]):
            if strength[j, i] > limits.minor and bar[j, i] < limits.sharp and value[j, i] > SLOWEST:
                own = strength[j, i] + (2.0 if i == 0 else 0.0)
                at = used
                while at > 0 and key[at - 1] < own:
                    key[at], values[at], bars[at] = key[at - 1], values[at - 1], bars[at - 1]
                    at -= 1
                key[at], values[at], bars[at] = own, value[j, i], bar[j, i]
                used += 1
            elif i == 0 and moving[j] != 0:
                return 0
    return used


@jit
def unexplained(lines, moving, limits, nu, bars, rank, vectors, samples):
    """Return the relative size of the largest line that generators do not explain, or of which they are multiples; 1
    for a dominant line.
    """
    (value, bar, strength) = lines
    (tables, sizes) = vectors
    k = np.zeros(nu.size, np.int64)
    most = 0.0
    r = rank - 1
    for j in range(moving.size):
        for i in range(value.shape[1]):
            part = strength[j, i]
            u = value[j, i]
            if moving[j] == 0 or not part > most or not u > SLOWEST:
                continue
            width = min(bar[j, i], 0.3)
            related = relate(u, width, nu, bars, rank, tables[r], sizes[r, 0], CHANCE, k)
            for alias in (samples - u, samples + u):
                related = related or relate(alias, width, nu, bars, rank, tables[r], sizes[r, 1], CHANCE, k)
            if i == 0 and not related:
                return 1.0
            divisor = divides(u, bar[j, i], nu, bars, rank, tables[r], sizes[r, 0], related, k)
            sharp = bar[j, i] < limits.sharp and part > limits.visible
            if divisor or (sharp and not related):
                most = part
    return most


@jit
def write_lines(lines, read, end, value, bar, strength):
    """Write places, without sign, bars and relative sizes of a loop's lines, the largest first: of the `read` peaks,
    and of those beside them from number MORE to `end`.
    """
    top = 0.0
    written = 0
    for i in range(end):
        top = max(top, lines.size[i]) if i < read or i >= MORE else top
    value[:] = 0.0
    bar[:] = math.inf
    strength[:] = 0.0
    for i in range(end if top > 0.0 else 0):
        if read <= i < MORE:
            continue
        at = written
        part = lines.size[i] / top
        written += 1
        while at > 0 and strength[at - 1] < part:
            value[at], bar[at], strength[at] = value[at - 1], bar[at - 1], strength[at - 1]
            at -= 1
        value[at], bar[at], strength[at] = abs(lines.place[i]), lines.bar[i], part


def find_lattice(unit, stop, progress, spectra, bands, order, limits, vectors, found):
    """Find the lines of the loops of an orbit and the generators of their lattice: by the FIRST peaks of each loop, and
    where these leave the lattice incomplete, by all peaks and the lines beside them.

    spectra, bands: see `loop_transforms`; order: of the window; vectors: see `fundamental.relate`.
    """
    if read_now(stop, 0) > 0:
        return
    moving = spectra.rows.moving[unit]
    lattice = found.lattice
    m = moving.size
    samples = spectra.n[unit]
    size = bands.size[unit]
    first = spectra.start[unit]
    begin = bands.start[unit]
    spectrum = spectra.numbers[first : first + m * samples].reshape((m, samples))
    transforms = bands.numbers[begin : begin + m * SUMS * size].reshape((m, SUMS, size))
    edges = bands.edges[unit]
    own = RankedLines(found.lines.value[unit], found.lines.bar[unit], found.lines.strength[unit])
    band = new_band(PEAK_BASIS)
    most = own.value.shape[1]
    places = np.zeros((m, most))
    sizes = np.zeros((m, most))
    widths = np.zeros((m, most))
    doubts = np.zeros((m, most))
    peaks = np.zeros(m, np.int64)
    values = np.zeros(m * most)
    bars = np.zeros(m * most)
    nu = lattice.nu[unit]
    spread = lattice.spread[unit]
    source = lattice.source[unit]
    some = 0
    for j in range(m):
        if moving[j] != 0:
            some += 1
            peaks[j], rest = find_peaks(
                spectrum[j], order, FEWEST, FIRST, places[j, :MORE], sizes[j, :MORE], doubts[j, :MORE]
            )
            found.rest[unit] = max(found.rest[unit], rest)
            if sizes[j, 0] > 0.0:
                found.tail[unit] = max(found.tail[unit], size_of_tail(spectrum[j]) / sizes[j, 0])
            signed_places(LoopLines(places[j], sizes[j], widths[j], doubts[j]), peaks[j], samples)
    # Lines not larger than those near the highest frequency may be aliases of faster ones.
    limits = LatticeLimits(limits.sharp, max(limits.minor, found.tail[unit]), max(limits.visible, found.tail[unit]))
    for attempt in range(2):
        for j in range(m):
            if moving[j] == 0:
                continue
            lines = LoopLines(places[j], sizes[j], widths[j], doubts[j])
            few = min(FIRST, peaks[j])
            old, read, split = (0, few, min(few, 1)) if attempt == 0 else (few, peaks[j], peaks[j])
            read_peaks(transforms[j], edges[j], samples, old, read, lines, band)
            end = split_peaks(transforms[j], edges[j], samples, order, split, read, limits.minor, lines, MORE, band)
            write_lines(lines, read, end, own.value[j], own.bar[j], own.strength[j])
        used = rank_lines(own, moving, limits, values, bars)
        rank = generate(values, bars, used, m, vectors, float(samples), nu, spread, source)
        lattice.rank[unit] = rank
        unexplained_size = 1.0
        if rank > 0:
            unexplained_size = unexplained(own, moving, limits, nu, spread, rank, vectors, float(samples))
        found.unexplained_size[unit] = unexplained_size
        # Where a dominant line is not sharp, more lines do not tell more.
        if used == 0 or (rank == some and unexplained_size == 0.0):
            break
    progress[unit] = 1.0
