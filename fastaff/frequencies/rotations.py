"""Mean rates of winding coordinates with a period: frequencies that are in no line if nothing else turns."""

from __future__ import annotations

import numpy as np

from .fundamental import BRIEF, run, tables_of
from .kernels import fundamental as kernels
from .loop_rates import LoopRates
from .mean_rates import PARTS, parts
from .signals import Signals

MULTIPLES = 12
"""Largest multiple of a mean rate that is sought in a lattice: that of a potential of so many equal wells a turn."""

TOLD = 0.05
"""Error of a mean rate, in cycles over the time, up to which it is told whether a lattice has it."""


def going_round(s: Signals, periods: np.ndarray) -> np.ndarray:
    """Return a mask (orbits, n) of coordinates, rows 2i of the signals, that end more than a period (n,) from their
    start; those of a period 0 do not.
    """
    first = s.start[:, None] + 2 * np.arange(periods.size) * s.samples[:, None]
    moved = s.numbers[first + s.samples[:, None] - 1] - s.numbers[first]
    return (periods > 0) & (np.abs(moved) > periods)


def mean_turns(s: Signals, start: Signals | None, periods: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return weighted mean rates (orbits, n, PARTS), in periods per unit time, of coordinates, rows 2i of the signals,
    and their decrease (orbits, n, 3) with the finer step of `start`, over its samples and over its halves.

    They are differences of unwrapped coordinates: no turn is lost, however few samples it has.
    """
    shape = s.samples.size, periods.size
    rates = np.zeros((*shape, len(PARTS)))
    change = np.zeros((*shape, 3))
    for o in s.alike():
        run = s.array(o)[:, ::2]
        unit = np.where(periods > 0, periods, 1.0)[:, None] * float(s.interval[o[0]])
        rates[o] = _weighted(run, parts(run.shape[2] - 1)[0]) / unit
        if start is None:
            continue
        for part in start.of(o).alike():
            fine = start.array(o[part])[:, ::2]
            weights = parts(fine.shape[2] - 1)[0][:3]
            change[o[part]] = (_weighted(run[part, :, : fine.shape[2]], weights) - _weighted(fine, weights)) / unit
    return rates, change


def _weighted(coordinates: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the means (orbits, n, windows) of the steps of coordinates (orbits, n, samples)."""
    steps = np.diff(coordinates, axis=2)
    return np.stack([(steps * weight).sum(axis=2) for weight in weights], axis=2)


class Winding:
    """Frequencies of orbits with winding coordinates, in the making: rates, a mask `known` (orbits, n) of frequencies
    of their lattices, and basis (orbits, n, n) with dominant = basis @ nu; placed (orbits, n): of coordinates without
    frequencies of their own, which got their mean rates; added (orbits,): of rates that no lattice had.
    """

    def __init__(self, rates: LoopRates, basis: np.ndarray, known: np.ndarray):
        self.rates = rates
        self.basis = basis
        self.known = known
        self.placed = np.zeros(known.shape, bool)
        self.added = np.zeros(len(known), np.int64)

    def wind(self, turns: LoopRates, going: np.ndarray, time: np.ndarray, threads: int) -> np.ndarray:
        """Make the mean rates of the coordinates that are `going` (orbits, n) round their frequencies; return a mask
        (orbits,) of orbits with a rate that their frequencies do not make.
        """
        unexplained_size = np.zeros(len(going), bool)
        done = ~going
        for alone in (True, False):  # first those without frequencies of their own
            for i in range(going.shape[1]):
                some = ~done[:, i] & (self.known[:, i] != alone)
                multiple, k = self._related(turns, i, some, threads)
                sharp = some & (multiple == 0) & (turns.error[:, i] * time < TOLD)
                unexplained_size |= self._replace(turns, i, multiple, k, ~going | ~done)
                self._show(turns, i, np.flatnonzero(some & (multiple > 0) & ~self.known[:, i]))
                room = ~self.known.all(axis=1)
                self._add(turns, i, np.flatnonzero(some & (multiple == 0) & room))
                ambiguous = sharp & ~room & (self.rates.error[:, i] > turns.error[:, i])
                self._put(turns, i, np.flatnonzero(ambiguous))
                unexplained_size |= sharp & ~room
                done[some, i] = True
        return unexplained_size

    def _related(self, turns: LoopRates, i: int, going: np.ndarray, threads: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the least multiples (orbits,) of the mean rates of coordinate i that are combinations of the known
        frequencies, 0 for none, and their integers (orbits, n).
        """
        orbits, n = self.known.shape
        multiple = np.zeros(orbits, np.int64)
        integers = np.zeros((orbits, n), np.int64)
        nu, error = (np.where(self.known, entry, 0.0) for entry in (self.rates.nu, self.rates.error))
        value = np.abs(turns.nu[:, i])
        bar = turns.error[:, i]
        sure = going & np.isfinite(bar) & np.isfinite(nu).all(axis=1) & np.isfinite(error).all(axis=1)
        for first in range(1, MULTIPLES + 1, n):
            left = sure & (multiple == 0)
            if not left.any():
                break
            factors = np.arange(first, first + n)
            k = np.zeros((orbits, n, n), np.int64)
            pair = [np.where(left[:, None], entry[:, None] * factors, 0.0) for entry in (value, bar)]
            run(kernels.combinations, orbits, (*pair, nu, error, tables_of(n), k), threads, BRIEF)
            has = np.abs(k).max(axis=2) > 0
            own = np.flatnonzero(has.any(axis=1))
            at = has.argmax(axis=1)
            multiple[own], integers[own] = factors[at[own]], k[own, at[own]]
        return multiple, integers

    def _replace(self, turns: LoopRates, i: int, multiple: np.ndarray, k: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Make the mean rate of coordinate i, of which a multiple is k . nu, its frequency in the place of one that it
        makes with the others, of the `free` ones (orbits, n); return a mask (orbits,) of orbits of which the lattice is
        finer than the frequencies.
        """
        orbits, n = self.known.shape
        place = np.arange(n)
        own = (multiple == 1) & (np.abs(k).sum(axis=1) == 1) & (k[:, i] != 0)
        free = free & (np.abs(k) == 1) & self.known
        fits = (multiple > 0) & ~own & self.known[:, i] & free.any(axis=1)
        some = np.flatnonzero(fits)
        left = np.where(free[:, i], i, free.argmax(axis=1))[some]
        vectors = np.tile(np.eye(n), (orbits, 1, 1))
        factor = np.ones((orbits, n))
        vectors[some, left] = np.eye(n)[i]
        vectors[some, i], factor[some, i] = k[some], 1 / multiple[some]
        through = self.rates.combined(vectors.astype(np.int64)).times(factor)
        better = fits[:, None] & (place == i) & (turns.error < through.error)
        self.rates = turns.times(np.sign(turns.nu)).where(better, through)
        inverse = np.linalg.inv(vectors[some] * factor[some, :, None])
        self.basis[some] = np.rint(self.basis[some] @ inverse).astype(np.int64)
        return (multiple > 1) & ~fits

    def _add(self, turns: LoopRates, i: int, orbits: np.ndarray) -> None:
        """Add the mean rates of coordinate i to lattices that have a place left, if need be that of a coordinate which
        gets its frequency.
        """
        n = self.known.shape[1]
        had = self.known[orbits, i]
        other = np.where(had, self.known[orbits].argmin(axis=1), i)
        vectors = np.tile(np.eye(n, dtype=np.int64), (len(self.known), 1, 1))
        vectors[orbits, other] = np.eye(n, dtype=np.int64)[i]
        new = np.zeros(self.known.shape, bool)
        new[orbits, i] = True
        self.rates = turns.where(new, self.rates.combined(vectors))
        self.basis[orbits, :, other] = self.basis[orbits, :, i]
        self.basis[orbits, :, i] = 0
        self.basis[orbits[~had], i] = np.eye(n, dtype=np.int64)[i]
        self.placed[orbits[~had], i] = True
        self.known[orbits, other] = self.known[orbits, i] = True
        self.added[orbits] += 1

    def _show(self, turns: LoopRates, i: int, orbits: np.ndarray) -> None:
        """Give a coordinate without a frequency of its own its mean rate, of which the lattice has a multiple."""
        new = np.zeros(self.known.shape, bool)
        new[orbits, i] = True
        self.rates = turns.where(new, self.rates)
        self.placed[orbits, i] = True
        self.basis[orbits, i] = np.eye(self.known.shape[1], dtype=np.int64)[i]

    def _put(self, turns: LoopRates, i: int, orbits: np.ndarray) -> None:
        """Take the mean rates of coordinate i for frequencies that are less exact and not told from others."""
        new = np.zeros(self.known.shape, bool)
        new[orbits, i] = True
        self.rates = turns.where(new, self.rates)
        self.basis[orbits] = np.where((self.basis[orbits, :, i] != 0)[:, :, None], 0, self.basis[orbits])
