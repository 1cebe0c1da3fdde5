"""Frequency maps of maps: tunes of the planes that oscillate, rotation numbers of the angles that wind."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ...base.interruption import keeping
from ...base.numbers import fits, whole
from ...base.status import Status
from ...flows import observers
from ...flows.ensemble import Ensemble
from ...flows.flow import Flow, Report, no_memory
from ...flows.options import Options, plan
from ...models.contracts import coordinate_names
from ..orbits.given_orbits import given_orbits
from .angle_loops import Room
from .frequencies import MANY_TURNS, FrequencyKind, FrequencyMap
from .fundamental import SPANS, weight_at
from .methods import BirkhoffAverages, NaffLines
from .readings import CHANGED
from .tunes import FALLBACK, LEAST, TuneWork
from .turning import ROUNDING, SAFETY, unresolved

BUDGET = 1 << 25
"""Bytes of samples in memory at once."""

LOCKED = 12
"""Largest period of islands that a rotation number is looked at for."""


SWINGS = 2.0
"""Turns over a half by which the mean of an angle must change to be chaos: slow swings in a resonance change it too."""


class _Window(NamedTuple):
    """What a window of turns says of orbits: nu, error, method (n, orbits), halves (2, n, orbits)."""

    nu: np.ndarray
    error: np.ndarray
    method: np.ndarray
    halves: np.ndarray


def map_frequencies(
    body: Any,
    z0: Any,
    options: Options,
    *,
    time: float,
    method: BirkhoffAverages | NaffLines,
    window: int | None,
    angles: Any,
) -> FrequencyMap:
    """Return the frequency map of a map, see `frequency_map`."""
    flow, z, _ = plan(body, z0, options, time=time)
    turns = int(time)
    if angles is not None:
        raise ValueError(f"angles is for systems in time: the loops of a map are those of (q, p); got {angles!r}")
    if window is not None and 2 * whole("window", window, LEAST) > turns:
        raise ValueError(f"window must be at most half of the {turns} iterates, got {window!r}")
    if turns < LEAST:
        raise ValueError(f"time must be at least {LEAST} iterates, got {time!r}")
    fits("time", len(z), turns if window is None else int(window))
    work = MapFrequencies(flow, z, turns, window, method)
    with keeping("frequency_map", work.result):
        work.run(options.report)
    return work.result()


def map_frequencies_of(flow: Flow, z: np.ndarray, turns: int) -> FrequencyMap:
    """Return the frequency map of the orbits of a map from z (2n, orbits), by averages alone."""
    work = MapFrequencies(flow, z, max(turns, LEAST), None, BirkhoffAverages(fallback=math.inf))
    work.run()
    return work.result()


class MapFrequencies:
    """A frequency map of a map in the making; arrays over angles and orbits hold what is known so far."""

    def __init__(self, flow: Flow, z: np.ndarray, turns: int, window: int | None, method: BirkhoffAverages | NaffLines):
        self.flow, self.z, self.turns, self.length, self.kept = flow, z, turns, window or turns, window is not None
        self.chosen, self.room = method, Room()
        n, orbits = len(z) // 2, z.shape[1]
        self.names = coordinate_names(flow.model)
        self.nu, self.error = np.zeros((n, orbits)), np.full((n, orbits), np.inf)
        self.halves, self.method = np.zeros((2, n, orbits)), np.zeros((n, orbits), np.int8)
        self.later = np.zeros((n, orbits), bool)
        self.status, self.t = np.full(orbits, int(Status.INTERRUPTED)), np.zeros(orbits)

    def run(self, report: Report | None = None) -> None:
        """Find the frequencies of all orbits, as many at a time as memory allows."""
        rows, orbits = self.z.shape
        kept = 1 if self._wound_rows().all() else rows * self.length
        portion = max(1, BUDGET // (8 * kept))
        for begin in range(0, orbits, portion):
            part = np.arange(begin, min(begin + portion, orbits))
            self._portion(part)
            if report is not None:
                report(part[-1] / orbits)

    def _portion(self, part: np.ndarray) -> None:
        """Find the frequencies of these orbits."""
        ensemble = self.flow.ensemble(self.z[:, part].copy())
        first, counts = self._seen(ensemble)
        self.nu[:, part], self.error[:, part], self.method[:, part], self.halves[:, :, part] = first
        self.later[:, part] = np.isfinite(first.error) if not self.kept else False
        t, status = counts, ensemble.status.copy()
        if self.kept:
            between = self.flow.ensemble(ensemble.z.copy(), radius=ensemble.radius)
            between.status[:] = ensemble.status
            rest = self.turns - 2 * self.length
            if rest:
                self.flow.advance(between, observers.nothing(), *no_memory(between), time=float(rest), observations=1)
                gone = (between.status != Status.OK) & (status == Status.OK)
                t, status = np.where(gone, t + between.time - 1, t + rest * (status == Status.OK)), between.status
            last = self.flow.ensemble(between.z.copy(), radius=ensemble.radius)
            last.status[:] = status
            going = np.flatnonzero(status == Status.OK)
            whole_one = last.of(going)
            second, more = self._seen(whole_one)
            self.halves[0][:, part] = first.nu
            self.halves[1][:, part[going]] = second.nu
            self.later[:, part[going]] = np.isfinite(second.error) & np.isfinite(first.error[:, going])
            t[going] += more
            status[going] = whole_one.status
        self.t[part], self.status[part] = t, status

    def _seen(self, ensemble: Ensemble) -> tuple[_Window, np.ndarray]:
        """Follow orbits through a window; return what it says, and how many turns (orbits,) each has of it."""
        n, orbits = len(self.z) // 2, ensemble.z.shape[1]
        found = _Window(
            np.zeros((n, orbits)),
            np.full((n, orbits), np.inf),
            np.zeros((n, orbits), np.int8),
            np.zeros((2, n, orbits)),
        )
        wound = self._wound_rows()
        observer, columns = observers.winding(self.flow.model, float(self.length), SPANS), 1
        parts = [(observer, columns)] if wound.any() else []
        if not wound.all():
            parts.append((observers.samples(2 * n), self.length * 2 * n))
        observer, firsts, columns = observers.chain(parts)
        memory, out = np.zeros((observer.rows, orbits)), self.room.array(orbits, columns)
        self.flow.advance(ensemble, observer, memory, out, time=float(self.length), observations=self.length)
        counts = ensemble.count - (ensemble.status != Status.OK)
        if wound.any():
            self._wound(memory, counts, found)
        if not wound.all():
            states = out[:, firsts[-1][1] :].reshape(orbits, self.length, 2 * n)
            for orbit in np.flatnonzero(counts < self.length):
                states[orbit, counts[orbit] :] = np.nan
            self._turned(states.transpose(2, 0, 1), counts, found)
        return found, counts.astype(np.float64)

    def _turned(self, z: np.ndarray, counts: np.ndarray, found: _Window) -> None:
        """Fill in the tunes of the planes of z (2n, orbits, turns) that oscillate."""
        n, plain, long = len(z) // 2, np.flatnonzero(~self._wound_rows()), np.flatnonzero(counts >= LEAST)
        if not long.size:
            return
        kept = z if plain.size == n else z[[*plain, *(n + plain)]]
        kept = kept if long.size == counts.size else kept[:, long]
        fallback = FALLBACK if self.chosen.fallback is None else self.chosen.fallback
        own = TuneWork(given_orbits("samples", kept, coordinates=None, least=LEAST), fallback, self.flow.threads, None)
        own.run()
        where = np.ix_(plain, long)
        found.nu[where], found.error[where], found.method[where] = own.nu % 1.0, own.error, own.method
        found.halves[:, where[0], where[1]] = own.halves

    def _wound(self, memory: np.ndarray, counts: np.ndarray, found: _Window) -> None:
        """Fill in the rotation numbers of angles: the weighted means of what they wind on in an iterate."""
        angles, whole_ones = np.flatnonzero(self._wound_rows()), np.flatnonzero(counts == self.length)
        own = np.ix_(angles, whole_ones)
        sums = memory[: angles.size * len(SPANS)].reshape(angles.size, len(SPANS), -1)[:, :, whole_ones]
        place = (np.arange(self.length) + 0.5) / self.length
        weights = [weight_at(2 * (place - first) / (last - first) - 1).sum() for first, last in SPANS]
        means = np.array([sums[:, s] / weight for s, weight in enumerate(weights)])
        found.nu[own], found.halves[:, own[0], own[1]] = means[0], means[1:3]
        spread = SAFETY * np.abs(means[1:] - means[0]).max(axis=0)
        found.error[own] = spread + unresolved(means[0], self.length) + ROUNDING * np.maximum(np.abs(means[0]), 1.0)

    def result(self) -> FrequencyMap:
        """Assemble the map."""
        n, orbits = self.nu.shape
        change = np.abs(self.halves[0] - self.halves[1])
        for i, period in enumerate(self.flow.model.periods()[:n]):
            if period == 0:  # known modulo 1
                change[i] = np.abs(change[i] - np.rint(change[i]))
        change = np.where(self.later, change, 0.0)
        known = np.isfinite(self.error)
        some, largest = self.later.any(axis=0), change.max(axis=0)
        span = self.length if self.kept else self.length / 2
        kind = np.where(known.all(axis=0), FrequencyKind.INDEPENDENT, FrequencyKind.DEPENDENT)
        kind[self._dependent().any(axis=0)] = FrequencyKind.DEPENDENT
        kind[span * largest > CHANGED] = FrequencyKind.UNDECIDED
        beyond = np.where(self._wound_rows()[:, None], SWINGS, CHANGED)
        kind[(span * change > beyond).any(axis=0)] = FrequencyKind.IRREGULAR
        kind[~some] = FrequencyKind.UNDECIDED
        turned = self.length * np.where(known, np.abs(self.nu - np.rint(self.nu)), 0.0).max(axis=0)
        kind[(turned < MANY_TURNS) & (kind == FrequencyKind.INDEPENDENT)] = FrequencyKind.UNDECIDED
        basis = np.zeros((n, n, orbits), np.int64)
        basis[range(n), range(n)] = known
        diffusion = np.where(some, np.log10(largest + 1e-18), np.nan)
        return FrequencyMap(
            self.names,
            self.nu,
            self.error,
            diffusion,
            self.method,
            np.zeros(orbits),
            self.status,
            None,
            None,
            float(self.turns),
            self.flow.scheme,
            self.flow.step,
            kind,
            known.sum(axis=0),
            self.nu.copy(),
            self.error.copy(),
            basis,
            self.t,
        )

    def _wound_rows(self) -> np.ndarray:
        """Tell which coordinates (n,) are angles."""
        return np.array([period > 0 for period in self.flow.model.periods()[: len(self.nu)]])

    def _dependent(self) -> np.ndarray:
        """Tell which rotation numbers are fractions, of an angle that goes around with a chain of islands, and which
        tunes are equal (n, orbits).
        """
        n, q = len(self.nu), np.arange(1, LOCKED + 1)[:, None, None]
        wound = self._wound_rows()[:, None]
        beat = np.abs(q * self.nu - np.rint(q * self.nu))
        locked = wound & (beat <= q * np.minimum(self.error, 1 / self.length)).any(axis=0)
        for i in range(n):
            for j in range(i):
                for apart in (self.nu[i] - self.nu[j], self.nu[i] + self.nu[j]):
                    near = np.abs(apart - np.rint(apart)) <= self.error[i] + self.error[j]
                    locked[i] |= near & np.isfinite(self.error[i] + self.error[j])
        return locked
