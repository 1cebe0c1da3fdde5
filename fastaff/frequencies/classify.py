"""Classes of orbits: what their frequencies, the errors of these and the lines beside them tell. Limits of
lines are `fundamental.LIMITS`, the others are here.

A line is explained by a combination of the frequencies within its error bar. An orbit whose visible lines are all
explained by n frequencies is REGULAR, by fewer of them RESONANT; one whose frequencies change more than steady
lines can is IRREGULAR; any other is UNDECIDED. `bench/frequency_coverage.py` counts how often this is wrong, on orbits
of known frequencies.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np

from ..core.classification import Classification
from .fundamental import BRIEF, BROAD, LIMITS, LatticeModes, run
from .integer_lattice import ball, one_of_each
from .kernels.relations import RelationLimits, vanishing

if TYPE_CHECKING:
    from .loop_rates import LoopRates

FEW_TURNS = 18
"""Turns from which independent frequencies are told: over 12 periods 2 of 57 lattices of turned wells are wrong, over
20 none (`bench/frequency_coverage.py --periods 12 20`).
"""

MANY_TURNS = 30
"""Turns from which a relation of frequencies, or a change of them between the halves, is evidence."""

UNSURE = 0.15
"""Error of a frequency, in cycles over the time, from which it may be that of another line: lines of one loop are
rarely closer than a cycle.
"""

EXACT = 1e-3
"""Error of the dominant lines, in cycles over the time, up to which fewer frequencies than loops are no close pairs: of
3106 orbits of `bench/frequency_coverage.py --quick --seed 3` one of 76 such pairs is left.
"""

SHORT = 4
"""Largest |k|_1 of combinations that may not turn less than RESOLVED."""

RESOLVED = 1.0
"""Cycles over the time below which these may be a libration: the orbit may be trapped in the resonance."""

LIBRATION = 0.1
"""Error of a combination, in cycles over the time, in units of the cube of its cycles c, up to which it is no
libration. One of amplitude pi, seen where it is fastest, passes c cycles with a rate that the windows of 0.7 of the
time see change by 0.04 c^3; errors state 5 times that (`inverted_lines.SAFETY`).
"""

HIDDEN = 0.01
"""Beat of a loop, in units of the cycles of a combination, up to which no line is hidden next to its own: of two lines
so far apart it is about the ratio of their sizes times that distance.
"""

CHANCE = 0.02
"""Expected number of combinations as small by chance, up to which one counts as a relation that is not resolved."""

LONGEST = (48, 12, 12, 6, 4, 3, 3, 2)
"""Largest |k|_1 of combinations of 1, 2, ... frequencies that are compared with 0."""

CHANGED = 0.25
"""Change of a frequency between the whole and the halves, in cycles over a half, that steady lines do not cause: none
of 1000 regular orbits of Henon and Heiles, of three oscillators and of a logarithmic potential changes as much that has
the other two signs of chaos.
"""

EACH = 1.5
"""The same of three loops and more, for each beyond one."""

ROUGH = 0.12
"""Share of a loop's size outside of its strongest lines up to which a change is no evidence of chaos."""

SHARP = 0.1
"""Error of a dominant line, in cycles over the time, up to which it is none either."""

BEAT = 0.5
"""Cycles over the time within which the dominant lines of two loops are one, and by which frequencies change as these
beat.
"""


def unexplained(found: LatticeModes, time: np.ndarray) -> np.ndarray:
    """Return a mask of orbits over a time (orbits,) with lines that the frequencies may not explain."""
    rough = (found.moving & ~(found.dominant_error * time[:, None] < EXACT)).any(axis=1)
    missing = found.rank < found.moving.sum(axis=1)
    incomplete = missing & (rough | (found.rest > BROAD) | (found.unexplained_size > 0))
    return (found.rank == 0) | (found.unexplained_size > LIMITS.visible) | incomplete


def changing(rates: LoopRates, found: LatticeModes, time: np.ndarray) -> np.ndarray:
    """Return a mask of orbits over a time (orbits,) whose frequencies change by more than steady lines can cause."""
    apart = np.abs(rates.halves - rates.nu[:, :, None]).max(axis=2)
    change = np.maximum(np.ptp(rates.halves, axis=2), apart) * time[:, None] / 2
    change = np.where(found.moving & np.isfinite(change), change, 0.0).max(axis=1, initial=0.0)
    m = found.nu.shape[1]
    least = np.full(change.size, max(CHANGED, EACH * (m - 1) if m > 2 else 0.0))
    if m == 2:
        beating = np.ptp(found.dominant, axis=1) * time < BEAT
        least = np.where(beating, np.maximum(least, BEAT), least)
    sharp = (found.dominant_error * time[:, None] <= SHARP) | ~found.moving
    return (change > least) & (found.rest > ROUGH) & ~sharp.all(axis=1)


def unsettled(
    rates: LoopRates, found: LatticeModes, beat: np.ndarray, time: np.ndarray, threads: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return a mask of orbits over a time (orbits,) with a frequency that is not sure, or a combination of frequencies
    that may be 0; and the errors (orbits, loops) that such a combination causes. beat (orbits, loops): see
    `unresolved_relations`.
    """
    known = known_frequencies(rates, found)
    unsure = (found.owned & (rates.error * time[:, None] > UNSURE)).any(axis=1)
    distance = unresolved_relations(known, rates.error, beat, time, threads)
    return unsure | (distance >= 0).any(axis=1), np.maximum(distance, 0.0)


def known_frequencies(rates: LoopRates, found: LatticeModes) -> np.ndarray:
    """Return the frequencies (orbits, loops) of generators, NaN for loops without their own."""
    return np.where(found.owned, rates.nu, np.nan)


def related(nu: np.ndarray, error: np.ndarray, threads: int) -> np.ndarray:
    """Return a mask of orbits whose frequencies (orbits, m) have a combination of 0 within its error."""
    limits = RelationLimits(0.0, float(SHORT), 0.0, 0.0, 0.0)
    time = np.full(len(nu), np.inf)
    return np.asarray((_vanishing(nu, error, np.zeros_like(nu), time, limits, threads) >= 0).any(axis=1))


def unresolved_relations(
    nu: np.ndarray, error: np.ndarray, beat: np.ndarray, time: np.ndarray, threads: int
) -> np.ndarray:
    """Return for each of the frequencies (orbits, m) over a time (orbits,) the largest combination with it that may be
    0, -1 for none: too short a time tells no more.

    An orbit that a resonance has trapped has other frequencies: k . nu is then the rate of a libration, by up to which
    the frequencies are off. beat (orbits, m): by how much the mean rates of loops differ from their lines, as they do
    if another line is so close that none of a spectrum's peaks is its own; it may be a frequency that is not known.
    """
    return _vanishing(nu, error, beat, time, RelationLimits(RESOLVED, float(SHORT), CHANCE, LIBRATION, HIDDEN), threads)


def close_lines(nu: np.ndarray, time: np.ndarray, cycles: float, threads: int, chance: float = 0.0) -> np.ndarray:
    """Return a mask of orbits whose frequencies (orbits, m) have a short combination that turns by less than so many
    cycles over a time (orbits,): strong lines are as close. chance: see `RelationLimits`.
    """
    none = np.zeros_like(nu)
    limits = RelationLimits(cycles, float(SHORT), chance, 0.0, 0.0)
    return np.asarray((_vanishing(nu, none, none, time, limits, threads) >= 0).any(axis=1))


def _vanishing(
    nu: np.ndarray, error: np.ndarray, beat: np.ndarray, time: np.ndarray, limits: RelationLimits, threads: int
) -> np.ndarray:
    """Return the largest combinations (orbits, m) that may be 0; see `frequencies.kernels.relations.vanishing`."""
    found = np.full(nu.shape, -1.0)
    run(vanishing, len(nu), (nu, error, beat, time, _combinations(nu.shape[1]), limits, found), threads, BRIEF)
    return found


@functools.cache
def _combinations(m: int) -> np.ndarray:
    """Return vectors k (m + 1, vectors), one of each pair +-k, with |k|_1 in the last row, by that."""
    k = one_of_each(ball(m, LONGEST[min(m, len(LONGEST)) - 1])[1:])
    length = np.abs(k).sum(axis=1)
    k = k[length > 1]
    return np.ascontiguousarray(np.concatenate([k.T, [length[length > 1]]]), dtype=np.float64)


def classify(
    rank: np.ndarray, frequencies: int, turns: np.ndarray, undecided: np.ndarray, irregular: np.ndarray
) -> np.ndarray:
    """Return the classification (orbits,) of orbits with so many independent frequencies, rank (orbits,), over so many
    turns of the fastest (orbits,), from masks of those that are undecided, or irregular, by their lines.
    """
    classification = np.where(rank < frequencies, Classification.RESONANT, Classification.REGULAR)
    classification[undecided] = Classification.UNDECIDED
    classification[irregular] = Classification.IRREGULAR
    classification[(turns < MANY_TURNS) & (classification != Classification.REGULAR)] = Classification.UNDECIDED
    classification[turns < FEW_TURNS] = Classification.UNDECIDED
    return classification
