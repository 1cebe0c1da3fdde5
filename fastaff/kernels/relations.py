"""Kernel of relations: lines that frequencies do not explain, and combinations of frequencies close to 0."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compile.jit import jit, read_now
from .fundamental import relate
from .peaks import STRONG, divides
from .spectrum_lines import FEWEST

SHORT = 6
"""Largest |k|_1 of combinations whose lines may be hidden by others."""

CHANCE = 1 / 5
"""Largest |k|_1 of a beat that is not accidental, in cycles of the fastest line: for two frequencies about 3
|k|_1/cycles combinations are as slow as the time by chance.
"""


class Spans(NamedTuple):
    """Of orbits: length of the signals, and sampling rates, modulo which combinations appear (orbits,)."""

    time: np.ndarray
    rate: np.ndarray


class Combinations(NamedTuple):
    """Integer vectors k (m, vectors), by lengths |k|_1 (vectors,), one of each pair +-k, as real numbers."""

    k: np.ndarray
    lengths: np.ndarray


class Closeness(NamedTuple):
    """Relations of the frequencies of orbits.

    strange (orbits,): the amplitude, relative to its loop's largest, of the largest line of which a generator is a
    multiple; 1 where a generator is in no strong line and not told from a combination of others; blur (orbits, m): the
    cycles by which close lines of combinations may shift each frequency; near, close, beating (orbits,): whether such
    combinations exist that are large, that show, or that beat: those whose |k|_1 is at most CHANCE of the cycles of the
    fastest line, so that they are not accidental.
    """

    strange: np.ndarray
    blur: np.ndarray
    near: np.ndarray
    close: np.ndarray
    beating: np.ndarray


@jit
def _sums(k, nu):
    """Return the frequencies (vectors,) of combinations k (m, vectors) of nu (m,)."""
    sums = np.zeros(k.shape[1])
    for j in range(nu.size):
        known, row = nu[j], k[j]
        for v in range(sums.size):
            sums[v] += row[v] * known
    return sums


def relations(unit, stop, progress, seen, nu, spread, weak, vectors, combinations, spans, limits, closeness):
    """Compare the frequencies of an orbit with one another: fill in the lines seen that they do not explain, and their
    combinations so close to 0 that lines are not resolved.

    nu, spread (orbits, m) of generators, 0 where there is none; weak (orbits, m): of those that are known from lines
    beside which no others show. limits: cycles over the time up to which combinations
    are close, and near; amplitudes above which lines show, and are large.

    Amplitudes are assumed to fall with each step of |k|_1 by the factor of the known lines, and those of |k|_1 > SHORT
    to be at most the smallest known line's, FEWEST if all lines are known.
    """
    if read_now(stop, 0) > 0:
        return
    resolved, beside, shows, large = limits
    (value, bar, strength), (tables, sizes), (k, lengths) = seen, vectors, combinations
    strange, blur, near, close, beating = closeness
    time, rate = spans.time[unit], spans.rate[unit]
    m, lines = value.shape[1], value.shape[2]
    own, bars, where, rank = np.zeros(m), np.zeros(m), np.zeros(m, np.int64), 0
    found, decay, most = np.zeros(m, np.int64), 1e-3, FEWEST
    shown, fastest = np.zeros(m, np.int64), 0.0
    for j in range(m):
        if nu[unit, j] > 0.0:
            own[rank], bars[rank], where[rank] = nu[unit, j], spread[unit, j], j
            shown[rank] = 1 if weak[unit, j] else 0
            fastest = max(fastest, nu[unit, j])
            rank += 1
    for j in range(m):
        if strength[unit, j, lines - 1] > 0.0:
            most = max(most, strength[unit, j, lines - 1] / strength[unit, j, 0])
        for i in range(lines):
            part = strength[unit, j, i] / strength[unit, j, 0] if strength[unit, j, i] > 0.0 else 0.0
            if part == 0.0 or rank == 0:
                continue
            r = rank - 1
            width = min(bar[unit, j, i], 0.3 / time)
            related = relate(value[unit, j, i], width, own, bars, rank, tables[r], sizes[r, 0], 0.5, found)
            if related:
                length = 0
                for g in range(rank):
                    length += abs(found[g])
                for g in range(rank):
                    shown[g] += 1 if found[g] != 0 and (i == 0 or (part > STRONG and length <= 3)) else 0
                if length > 1 and i > 0:
                    decay = max(decay, part ** (1.0 / (length - 1)))
            if value[unit, j, i] > 0.0 and divides(
                value[unit, j, i], bar[unit, j, i], 1.0 / time, own, bars, rank, tables[r], sizes[r, 0], related, found
            ):
                strange[unit] = max(strange[unit], part)
    sums = _sums(k, nu[unit])
    for v in range(sums.size):
        aliases = math.floor(sums[v] / rate + 0.5)
        cycles = abs(sums[v] - rate * aliases) * time
        if not cycles < beside:
            continue
        there = True
        for j in range(m):
            there = there and (k[j, v] == 0.0 or nu[unit, j] > 0.0)
        if there:
            reach = decay ** (lengths[v] - 2)
            reach = min((3.0 if aliases == 0.0 else 10.0) * (min(reach, most) if lengths[v] > SHORT else reach), 1.0)
            near[unit] = near[unit] or reach > large
            if cycles < resolved:
                beating[unit] = beating[unit] or lengths[v] <= CHANCE * time * fastest
                for g in range(rank):  # in no strong line, and a combination of others: it may be no generator
                    strange[unit] = 1.0 if shown[g] == 0 and abs(k[where[g], v]) == 1.0 else strange[unit]
                close[unit] = close[unit] or reach > shows
                for j in range(m):
                    if k[j, v] != 0.0:
                        blur[unit, j] = max(blur[unit, j], 1.0 if reach > shows else reach)
    progress[unit] = 1.0


def first_vectors(unit, stop, progress, value, bar, nu, spread, vectors, k, found):
    """Fill k (orbits, m, m) with the first of the vectors such that value = k @ nu (orbits, m) within the errors, and
    found (orbits, m) with whether there is one; vectors (m + 1, count), see `fundamental.relate`.
    """
    if read_now(stop, 0) == 0:
        m = nu.shape[1]
        for j in range(m):
            found[unit, j] = relate(
                value[unit, j],
                bar[unit, j],
                nu[unit],
                spread[unit],
                m,
                vectors,
                vectors.shape[1],
                math.inf,
                k[unit, j],
            )
        progress[unit] = 1.0


def vanishing(unit, stop, progress, nu, error, k, found):
    """Fill found (orbits,) with whether one of the combinations k (m, vectors) of nu (orbits, m) is 0 within its error;
    combinations with unknown frequencies, NaN, do not count.
    """
    if read_now(stop, 0) > 0:
        return
    sums, widths, some = np.zeros(k.shape[1]), np.zeros(k.shape[1]), 0
    for j in range(k.shape[0]):
        row, one, width = k[j], nu[unit, j], error[unit, j]
        for v in range(row.size):
            sums[v] += row[v] * one if row[v] != 0.0 else 0.0
            widths[v] += abs(row[v]) * width if row[v] != 0.0 else 0.0
    for v in range(sums.size):
        some += 1 if abs(sums[v]) <= widths[v] else 0
    found[unit] = some > 0
    progress[unit] = 1.0
