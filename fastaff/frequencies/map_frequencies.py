"""Frequency maps of maps: tunes of the planes that oscillate, rotation numbers of the angles that wind."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..core.classification import Classification
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, fits, shown, whole
from ..core.status import Status
from ..engine.threads import by_portions
from ..runs import observers
from ..runs.flow import Ensemble, Flow, no_memory
from ..runs.given_orbits import given_orbits, lengths
from ..runs.options import Problem
from ..runs.requirements import check_given
from .angle_lines import LineTable
from .angle_loops import Plain, SignalLayout
from .classify import MANY_TURNS
from .frequencies import FrequencyMap
from .inverted_lines import inverted_values
from .plane_modes import driven, entangled
from .running_turns import ROWS, running_means
from .signals import ReusableBuffer, signals_of
from .tunes import EXACT, FALLBACK, LEAST, SHORT, TuneWork
from .turning import CHANGED, COST, LOCKED, ROUNDING, calm_change, from_whole, relations

BUDGET = 1 << 25
"""Bytes of samples in memory at once."""

TWICE = 2.0
"""Factor of the error of lines of coordinates that wind, whose lines are dense: 99 % of circles of the standard map
over 100 to 3000 iterates are within, none ten times beyond.
"""

COUPLED = 4
"""Most planes whose tunes are tried in other orders."""

SWINGS = 2.0
"""Turns over a half by which the mean of an angle must change to be chaos: slow swings in a resonance change it too."""


class _Window(NamedTuple):
    """Frequencies of orbits in a window of turns: nu, error (n, orbits), halves (2, n, orbits); span (orbits,),
    the turns that they are from; ambiguous (orbits,): a mask of orbits with two tunes that are not told apart.
    """

    nu: np.ndarray
    error: np.ndarray
    halves: np.ndarray
    span: np.ndarray
    ambiguous: np.ndarray


def map_frequencies(
    problem: Problem,
    *,
    time: float,
    window: int | None,
    signals: Any,
    lines: int | None,
) -> FrequencyMap:
    """Return the frequency map of a map, see `frequency_map`."""
    flow, z, *_ = problem.plan(time=time)
    turns = int(time)
    check_given(flow.system, "a time", "the loops of a map are those of (q, p)", signals=signals)
    if window is not None and 2 * whole("window", window, LEAST) > turns:
        raise ValueError(f"window must be at most half of the {turns} iterates, got {shown(window)}")
    if turns < LEAST:
        raise ValueError(f"time must be at least {LEAST} iterates, got {shown(time)}")
    fits("time", len(z), turns if window is None else int(window))
    work = MapFrequencies(flow, z, turns, window, lines)
    with partial_result_on_interrupt("frequency_map", work.result):
        work.run(problem.options.callback)
    return work.result()


def map_frequencies_of(flow: Flow, z: np.ndarray, turns: int) -> FrequencyMap:
    """Return the frequency map of the orbits of a map from z (2n, orbits), by averages alone."""
    work = MapFrequencies(flow, z, max(turns, LEAST), None, averages_alone=True)
    work.run()
    return work.result()


class MapFrequencies:
    """A frequency map of a map in the making; arrays over angles and orbits hold the results so far."""

    def __init__(
        self,
        flow: Flow,
        z: np.ndarray,
        turns: int,
        window: int | None,
        lines: int | None = None,
        averages_alone: bool = False,
    ):
        self.flow = flow
        self.z = z
        self.turns = turns
        self.length = window or turns
        self.kept = window is not None
        self.averages_alone, self.room = averages_alone, ReusableBuffer()
        n = len(z) // 2
        orbits = z.shape[1]
        self.names = flow.system.names
        self.lines = None if lines is None else LineTable(self.names, lines, orbits)
        self.nu = np.zeros((n, orbits))
        self.error = np.full((n, orbits), np.inf)
        self.halves = np.zeros((2, n, orbits))
        self.later = np.zeros((n, orbits), bool)
        self.status = np.full(orbits, int(Status.INTERRUPTED))
        self.t = np.zeros(orbits)
        self.span = np.full(orbits, float(self.length))
        self.ambiguous = np.zeros(orbits, bool)

    def run(self, callback: Callback | None = None) -> None:
        """Find the frequencies of all orbits, as many at a time as memory allows."""
        orbits = self.z.shape[1]
        portion = BUDGET // (8 * ROWS)
        for begin in range(0, orbits, portion):
            part = np.arange(begin, min(begin + portion, orbits))
            self._portion(part)
            if callback is not None:
                callback(part[-1] / orbits)

    def _portion(self, part: np.ndarray) -> None:
        """Find the frequencies of these orbits."""
        ensemble = self.flow.ensemble(self.z[:, part].copy())
        start = ensemble.of(np.arange(part.size))
        first, counts = self._seen(ensemble)
        if self.lines is not None:
            for own in self._portions(np.flatnonzero(counts >= LEAST)):
                self._lined(start.of(own), part[own], first.nu[:, own], self.lines)
        self.nu[:, part], self.error[:, part], self.halves[:, :, part] = first[:3]
        self.span[part], self.ambiguous[part] = first.span, first.ambiguous
        self.later[:, part] = np.isfinite(first.error) if not self.kept else False
        t = counts
        status = ensemble.status.copy()
        if self.kept:
            between = self.flow.ensemble(ensemble.z.copy(), radius=ensemble.radius)
            between.status[:] = ensemble.status
            rest = self.turns - 2 * self.length
            if rest:
                self.flow.advance(between, observers.nothing(), *no_memory(between), time=float(rest), observations=1)
                gone = (between.status != Status.OK) & (status == Status.OK)
                t = np.where(gone, t + between.time - 1, t + rest * (status == Status.OK))
                status = between.status
            last = self.flow.ensemble(between.z.copy(), radius=ensemble.radius)
            last.status[:] = status
            going = np.flatnonzero(status == Status.OK)
            whole_one = last.of(going)
            second, more = self._seen(whole_one)
            self.halves[0][:, part] = first.nu
            self.halves[1][:, part[going]] = self._in_order(second.nu, first.nu[:, going])
            self.later[:, part[going]] = np.isfinite(second.error) & np.isfinite(first.error[:, going])
            t[going] += more
            status[going] = whole_one.status
        self.t[part] = t
        self.status[part] = status

    def _in_order(self, nu: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Return tunes (n, orbits) in the order in which they are nearest to the first ones: coupled planes that share
        their lines equally may have changed them.
        """
        plain = np.flatnonzero(~self._wound_rows())
        best = nu.copy()
        least = np.full(nu.shape[1], np.inf)
        for order in itertools.permutations(plain) if plain.size <= COUPLED else ():
            change = nu[list(order)] - first[plain]
            change = from_whole(change).max(axis=0, initial=0.0)
            better = change < least
            best[np.ix_(plain, better)] = nu[np.ix_(order, better)]
            least[better] = change[better]
        return best

    def _seen(self, ensemble: Ensemble) -> tuple[_Window, np.ndarray]:
        """Follow orbits through a window; return its frequencies, and the turns (orbits,) of each orbit in it.

        Its samples are those after 1 to `length` turns.
        """
        orbits = ensemble.z.shape[1]
        wound = self._wound_rows()
        start = ensemble.of(np.arange(orbits))
        self.flow.advance(ensemble, observers.nothing(), *no_memory(ensemble), time=1.0, observations=1)
        (nu, error, halves), moving = running_means(self.flow, ensemble, self.length - 1)
        counts = ensemble.count - (ensemble.status != Status.OK)
        whole_ones = counts == self.length
        error = np.where(whole_ones, error, np.inf)
        nu = np.where(whole_ones, nu, 0.0)
        halves = np.where(whole_ones, halves, 0.0)
        nu[~wound] %= 1.0
        span = np.full(orbits, float(self.length))
        found = _Window(nu, error, halves, span, np.zeros(orbits, bool))
        least = math.inf if self.averages_alone else FALLBACK
        tight = EXACT if not self.averages_alone and self.length - 1 <= SHORT else least
        with_lines = whole_ones & (moving & (error > tight))[~wound].any(axis=0)
        plain = (nu[~wound], error[~wound])
        steps = self.length - 1
        shared = entangled(plain[0], steps) | driven(*plain).any(axis=0)
        shared |= (relations(*plain, steps).unseen > plain[1]).any(axis=0)
        with_lines |= whole_ones & moving[~wound].all(axis=0) & shared
        with_lines |= whole_ones & self._invertible(found, least).any(axis=0)
        again = np.flatnonzero((with_lines & (self.length >= LEAST)) | (~whole_ones & (counts >= LEAST) & ~wound.all()))
        for part in self._portions(again):
            self._sampled(start.of(part), part, found, least)
        found.nu[~np.isfinite(found.error)] = 0.0
        return found, counts.astype(np.float64)

    def _portions(self, orbits: np.ndarray) -> Iterator[np.ndarray]:
        """Yield some orbits, as many at a time as memory has room for their samples."""
        portion = max(1, BUDGET // (8 * len(self.z) * self.length))
        for begin in range(0, orbits.size, portion):
            yield orbits[begin : begin + portion]

    def _states(self, ensemble: Ensemble) -> tuple[np.ndarray, np.ndarray]:
        """Return the states (orbits, length, 2n) after 1 to `length` turns, which the next call overwrites, NaN behind
        an orbit's end, and their numbers (orbits,).
        """
        rows, orbits = ensemble.z.shape
        out = self.room.array(orbits, self.length * rows)
        observer = observers.samples(rows)
        memory = np.zeros((observer.rows, orbits))
        self.flow.advance(ensemble, observer, memory, out, time=float(self.length), observations=self.length)
        counts = ensemble.count - (ensemble.status != Status.OK)
        states = out.reshape(orbits, self.length, rows)
        for orbit in np.flatnonzero(counts < self.length):
            states[orbit, counts[orbit] :] = np.nan
        return states, counts

    def _lined(self, ensemble: Ensemble, orbits: np.ndarray, nu: np.ndarray, table: LineTable) -> None:
        """Fill in the lines of orbits with those rotation numbers nu (n, orbits)."""
        n = len(nu)
        states, counts = self._states(ensemble)
        for length, own in lengths(counts, self.length, LEAST):
            s = np.empty((own.size, 2 * n, length + 1))
            for r, period in enumerate(self.flow.model.periods()):
                row = states[own, : length + 1, r]
                if period > 0:  # a winding angle without its mean turn
                    turned = np.diff(row) / period - (nu[r, own, None] if r < n else 0.0)
                    turned = np.pad(turned - np.rint(turned), ((0, 0), (1, 0)))
                    row = row[:, :1] + period * np.cumsum(turned, axis=1)
                s[:, 2 * (r % n) + r // n] = row
            table.adopt(orbits[own], SignalLayout(Plain(self.names), n), signals_of(s, 1.0), 1.0)

    def _sampled(self, ensemble: Ensemble, orbits: np.ndarray, found: _Window, least: float) -> None:
        """Fill in the tunes of oscillating planes, from samples, for orbits that end in the window or need lines; these
        where a mean turn is off by more than `least`.
        """
        rows = len(self.z)
        plain = np.flatnonzero(~self._wound_rows())
        states, counts = self._states(ensemble)
        self._wound_lines(states, counts, orbits, found, least)
        if not plain.size:
            return
        z = states.transpose(2, 0, 1)
        kept = z if plain.size == rows // 2 else z[[*plain, *(rows // 2 + plain)]]
        own = TuneWork(
            given_orbits(kept, coordinates=None, least=LEAST),
            self.flow.threads,
            None,
            inexact=math.inf if self.averages_alone else EXACT,
        )
        own.run()
        where = np.ix_(plain, orbits)
        found.nu[where], found.error[where] = own.nu % 1.0, own.error
        found.halves[:, where[0], where[1]] = own.halves
        found.ambiguous[orbits] = own.ambiguous
        ended = own.window < self.length - 1
        found.span[orbits[ended]] = own.window[ended]

    def _invertible(self, found: _Window, least: float) -> np.ndarray:
        """Return a mask (n, orbits) of coordinates that wind whose mean turns are off by more than `least` and whose
        lines are sought: in runs that are not long, of orbits whose means do not change from half to half.
        """
        steady = self.length / 2 * np.abs(found.halves[0] - found.halves[1]) <= CHANGED
        return (found.error > least) & steady & self._wound_rows()[:, None] & (self.length <= SHORT)

    def _wound_lines(
        self, states: np.ndarray, counts: np.ndarray, orbits: np.ndarray, found: _Window, least: float
    ) -> None:
        """Replace mean turns of coordinates that wind, of orbits that last, by their lines in exp(2 pi i x/period),
        where there is one within the error and is more exact.
        """
        sought = self._invertible(found, least)[:, orbits] & (counts == self.length)
        t = np.arange(self.length)
        for r in np.flatnonzero(sought.any(axis=1)):
            whole_ones = np.flatnonzero(sought[r])
            mean = found.nu[r, orbits[whole_ones]]
            error = found.error[r, orbits[whole_ones]]
            turns = states[whole_ones, :, r] / self.flow.model.periods()[r] - mean[:, None] * t
            line = inverted_values(np.exp(2j * np.pi * (turns - np.rint(turns))), np.zeros(whole_ones.size))
            bar = TWICE * line.error
            better = np.isfinite(bar) & (bar < error) & (np.abs(line.nu) <= error)
            own = orbits[whole_ones[better]]
            found.nu[r, own], found.error[r, own] = (mean + line.nu)[better], bar[better] + ROUNDING
            found.halves[:, r, own] = (mean[:, None] + line.halves)[better].T

    def result(self) -> FrequencyMap:
        """Assemble the map."""
        n, orbits = self.nu.shape
        classification = np.empty(orbits, np.int64)
        diffusion = np.empty(orbits)
        error = self.error.copy()
        own = np.zeros((n, orbits), bool)

        def some(at: slice) -> None:
            classification[at], diffusion[at], own[:, at], error[:, at] = self._classify(at)

        by_portions(some, orbits, COST * n, self.flow.threads)
        known = np.isfinite(self.error)
        basis = np.zeros((n, n, orbits), np.int64)
        basis[range(n), range(n)] = own
        nu = np.where(known, self.nu, np.nan)
        return FrequencyMap(
            names=self.names,
            nu=nu,
            error=error,
            diffusion=diffusion,
            energy_error=np.zeros(orbits),
            status=self.status,
            nu_eta=None,
            nu_gamma=None,
            time=float(self.turns),
            scheme=self.flow.scheme,
            step=self.flow.step,
            classification=classification,
            rank=own.sum(axis=0),
            dominant=nu.copy(),
            dominant_error=error.copy(),
            basis=basis,
            t=self.t,
            lines=None if self.lines is None else self.lines.result(),
        )

    def _classify(self, at: slice) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return classes and diffusion of some orbits, a mask (n, orbits) of the frequencies that are independent of
        the earlier ones, and the errors (n, orbits).
        """
        tables = self.nu, self.error, self.halves, self.later, self.span
        nu, error, halves, later, whole_span = (table[..., at] for table in tables)
        ambiguous = self.ambiguous[at]
        change = np.abs(halves[0] - halves[1])
        wound = self._wound_rows()
        change[~wound] = from_whole(change[~wound])  # known modulo 1
        change = np.where(later, change, 0.0)
        known = np.isfinite(error)
        some = later.any(axis=0)
        largest = change.max(axis=0)
        span = whole_span if self.kept else whole_span / 2
        related = relations(nu, error, whole_span, wound)
        own = known & ~related.tied & ~(_locked(nu, error, self.length) & wound[:, None])
        classification = np.where(own.all(axis=0), Classification.REGULAR, Classification.RESONANT)
        error = np.maximum(error, related.unseen)
        error = np.where(ambiguous & ~wound[:, None], np.maximum(error, 1 / np.maximum(whole_span, 1)), error)
        classification[span * largest > CHANGED] = Classification.UNDECIDED
        beyond = np.where(wound[:, None], SWINGS, calm_change(nu, halves, span))
        classification[(span * change > beyond).any(axis=0)] = Classification.IRREGULAR
        classification[(classification != Classification.IRREGULAR) & related.unsure] = Classification.UNDECIDED
        classification[np.logical_or(np.logical_not(some), ambiguous)] = Classification.UNDECIDED
        turned = whole_span * np.where(known, from_whole(nu), 0.0).max(axis=0)
        ended = whole_span < self.length
        classification[(turned < MANY_TURNS) & (ended | (classification == Classification.REGULAR))] = (
            Classification.UNDECIDED
        )
        return classification, np.where(some, np.log10(largest + 1e-18), np.nan), own, error

    def _wound_rows(self) -> np.ndarray:
        """Return a mask (n,) of the coordinates that are angles."""
        return np.array([period > 0 for period in self.flow.model.periods()[: len(self.nu)]])


def _locked(nu: np.ndarray, error: np.ndarray, length: int) -> np.ndarray:
    """Return a mask (n, orbits) of rational rotation numbers, as of an angle that winds with a chain of islands."""
    q = np.arange(1, LOCKED + 1)[:, None, None]
    return np.asarray((from_whole(q * nu) <= q * np.minimum(error, 1 / length)).any(axis=0))
