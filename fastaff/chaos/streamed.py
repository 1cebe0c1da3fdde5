"""A chaos map in the making: a streamed pass with tangent vectors, averages and samples, and the other passes."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.numbers import Callback, fits, listed, number_of_steps, shown
from ..core.status import Status
from ..engine.kernels import readings
from ..engine.kernels.deviations import ROWS, layout
from ..runs import observers
from ..runs.flow import Ensemble, Flow, early, no_memory
from ..runs.options import Plan
from ..runs.requirements import carried
from ..runs.scales import motion, natural_rates
from ..runs.tangent_map import checked_deviations
from ..systems.models.mechanics import System, length, total
from .indicator import Indicator, VectorIndicator, Watch, threshold_of

DEPENDENT = 1e-10
"""Distance of a unit vector from the plane of those before it, below which rounding errors would decide its direction.
"""


ITERATES = 8.0
"""Iterates of a map after which vectors are made orthonormal again, sooner where the first has grown long."""

LONGEST = 1e8
"""Square of the first vector's growth at which it is renormalised before its time, on orbits without equal steps."""

RECORDS = 32
"""Records of the growth of volumes, from which the errors of exponents follow."""

# tests/chaos/test_separatrices.py holds regular orbits beside separatrices to the next three constants.

PARTS = 8
"""Equal parts of a run over which the growth of the first tangent vector is compared."""

PASSAGES = 3
"""Number of these parts, those of the most growth, that may be passages of saddles."""

LASTING = 1.0
"""Decades by which the first vector must grow in the other parts before an orbit is called chaotic. 99 in 100 of 714
regular orbits, 1e-1 to 1e-10 beside the separatrices of pendulums, wells, products of two and McMillan maps, have 0.6
decades there or less; 99 in 100 chaotic ones of Henon-Heiles, standard maps and driven pendulums more than 1, where a
threshold is passed at all.
"""

UNMOVED = 1e-9
"""Relative distance of the end from the start, in all rows, below which an orbit is at rest."""

BLOCKS = {8: 4.2}
"""Number of blocks of a run whose spread gives the errors of exponents, and the number of standard errors that hold 99
%: Student's and a fifth more, as the blocks' distribution has longer tails.
"""

LONG_MEMORY = {8: 4.2, 4: 7.0, 3: 12.0}
"""The same for symplectic systems, whose chaotic orbits stick to islands for arbitrarily long times: few long blocks
see more of it.
"""


class _Envelope(VectorIndicator):
    """The largest growth of the first vector so far, which every classification on vectors rests on."""

    name = "envelope"
    threshold = -math.inf
    reading = staticmethod(readings.largest_length)

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Tell nothing."""
        return np.zeros(value.shape, bool)


ENVELOPE = _Envelope()


def own_rates(plan: Plan, time: float) -> np.ndarray:
    """Return the natural frequency (orbits,) of each orbit; where it has none, one radian in the time."""
    rates = natural_rates(plan.flow.system, plan.z, plan.flow.threads, plan.motion)
    return np.where(np.isfinite(rates) & (rates > 0), rates, 1 / time)


def scales(system: System, z0: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return s (2n, orbits): a tangent vector's positions times sqrt(m omega), and its momenta over it, have the same
    unit. The n coordinates are those beside the time, which is the same on all orbits.

    omega is the orbit's natural frequency, 1/m = dv/dp of each coordinate. |s w| of an oscillator doesn't change in
    time. The scaling is symplectic, so volumes and exponents do not change. For a flow it is 1.
    """
    if not system.canonical:
        return np.ones_like(z0)
    if system.iterated:
        found = motion(system, z0)
        own = np.sqrt(found.momentum / found.position)
        return np.concatenate([own, 1 / own])
    inverse = np.abs(np.einsum("iik->ik", system.inverse_masses(z0)))[: system.moving]
    inverse = np.where(np.isfinite(inverse) & (inverse > 0), inverse, 1.0)
    own = np.sqrt(rates / inverse)
    return np.concatenate([own, 1 / own])


def _unit_vectors(deviation_vectors: Any, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return given tangent vectors with unit length in the scale, and the logarithms (count, orbits) of their
    volumes.
    """
    given = checked_deviations(deviation_vectors, scale)
    with np.errstate(all="ignore"):
        given = given / np.abs(given).max(axis=1, keepdims=True)  # squares must neither overflow nor vanish
        given = given * scale / length((given * scale).transpose(1, 0, 2))[:, None]
    unit = np.nan_to_num(given).transpose(2, 1, 0)
    factors = np.abs(np.diagonal(np.linalg.qr(unit, mode="r"), axis1=1, axis2=2))
    if len(given) > len(scale) or not (factors > DEPENDENT).all():
        raise ValueError(
            f"deviation_vectors must be at most {len(scale)} linearly independent vectors, got {len(given)} of lower "
            "rank"
        )
    return given / scale, np.log(factors).T


def symplectic_frame(n: int, count: int) -> np.ndarray:
    """Return tangent vectors (count, 2n): columns of a fixed random symplectic orthogonal matrix, w_(2n+1-i) the
    conjugate of w_i.
    """
    random = np.random.default_rng(20)
    unitary, _ = np.linalg.qr(random.standard_normal((n, n)) + 1j * random.standard_normal((n, n)))
    first = np.concatenate([unitary.real, unitary.imag]).T
    conjugate = np.concatenate([-unitary.imag, unitary.real]).T
    return np.concatenate([first, conjugate[::-1]])[:count]


def frame(system: System, count: int) -> np.ndarray:
    """Return first tangent vectors (count, 2n); for a flow they are columns of a fixed random orthogonal matrix."""
    if system.canonical:
        return symplectic_frame(system.moving, count)
    square = np.random.default_rng(20).standard_normal(2 * (system.rows,))
    return carried(np.linalg.qr(square)[0].T, system, 1)[:count]


class ChaosRun:
    """The state of a chaos map between its passes; `values` (indicators, orbits) are readings, exponents as decades of
    growth.
    """

    def __init__(
        self,
        flow: Flow,
        z0: np.ndarray,
        rates: np.ndarray,
        time: float,
        chosen: tuple[Indicator, ...],
        *,
        slots: int,
        early_stop: bool,
        deviation_vectors: Any,
    ):
        self.flow = flow
        self.z0 = z0
        self.rates = rates
        self.time = time
        self.chosen = chosen
        self.slots = slots
        self.early_stop = early_stop
        self.finer = 1
        self.n = flow.system.moving
        self.orbits = z0.shape[1]
        self.degrees = flow.model.degrees_of_freedom
        self.scale = scales(flow.system, z0, rates)
        self.thresholds = np.array([threshold_of(entry, self.n, self.rates * time, time) for entry in chosen])
        self.tangent: list[tuple[int, Any]] = [(j, entry) for j, entry in enumerate(chosen) if entry.vectors(self.n)]
        if not flow.adaptive:  # the steps asked for, or the nearest shorter ones that divide the time
            self.flow = flow.fitted(time)
        start = self._start(deviation_vectors) if self.tangent else None
        watches = [(j, entry.watch(self.flow, time, self.rates)) for j, entry in enumerate(chosen)]
        self.watches: list[tuple[int, Watch]] = [(j, watch) for j, watch in watches if watch is not None]
        self.streams = bool(self.tangent or self.watches)
        self.k = self.flow.vectors
        self.m = len(self.tangent) + bool(self.tangent)
        self.ensemble: Ensemble = self.flow.ensemble(z0.copy(), start)
        self.lived = np.zeros(self.orbits)
        self.every = np.ones(self.orbits, np.int64)
        self.values, self.before = np.full((2, len(chosen), self.orbits), np.nan)
        self.records_kept = slots
        self.sums_kept = 0
        self.aligned = 0
        if self.tangent:
            least = RECORDS if self.spectrum else PARTS
            self.finer = -(-least // slots) if slots else 1
            self.records_kept = max(slots * self.finer, least)
            # The vectors are made orthonormal at all of these records, so all of them lie at looks.
            self.aligned = self.records_kept if slots else 0
        if self.tangent and self.spectrum:  # the user's vectors are among them
            self.aligned = self.records_kept
            self.sums_kept = self.k
        self.width = 1 + self.m + self.sums_kept
        number_of_steps(time, 1 / self.rates)
        fits("history", self.orbits, len(chosen) + self.width, self.records_kept)
        self._observe()

    def _observe(self) -> None:
        """Make the observer of the stream, of vectors first; its memory and columns."""
        parts = []
        if self.tangent:
            chosen = (*(entry for _, entry in self.tangent), ENVELOPE)
            vectors = observers.deviations(
                self.flow.model,
                self.k,
                chosen,
                time=self.time,
                early_stop=self.early_stop,
                slots=self.records_kept,
                forced=self.records_kept if self.aligned else 0,
                sums=self.sums_kept,
                longest=math.inf if self.flow.fixed else LONGEST,
            )
            parts.append((vectors, self.width * self.records_kept))
        parts += [(watch.observer, watch.columns) for _, watch in self.watches]
        self.observer, firsts, columns = observers.chain(parts)
        self.memory = np.zeros((self.observer.rows, self.orbits))
        self.out = np.full((self.orbits, max(1, columns)), np.nan)
        own = [(self.memory[row:], self.out[:, column:]) for row, column in firsts]
        self.watched = [(*watch, *kept) for watch, kept in zip(self.watches, own[bool(self.tangent) :])]
        for _, watch, memory, _ in self.watched:
            watch.prepare(memory)
        if self.tangent:
            self.growth: Any = layout(self.degrees, self.k, self.m).of(self.memory)
            self._prepare()

    def _prepare(self) -> None:
        """Set the rows of the memory that the stream only reads, and the columns."""
        growth = self.growth
        growth.columns[:: self.k + 1] = 1.0
        growth.thresholds[:-1] = self.thresholds[[j for j, _ in self.tangent]]
        growth.thresholds[-1] = ENVELOPE.threshold
        growth.signs[:-1] = np.array([1.0 if entry.above else -1.0 for _, entry in self.tangent])[:, None]
        growth.signs[-1] = 1.0
        growth.metric[:] = self._whole(self.scale**2)
        # About a radian, as a power of two steps: lanes with the same steps then share the work.
        steps = np.ones(self.orbits) if self.flow.adaptive else 1 / (self.rates * self.flow.step)
        if self.flow.system.iterated:
            steps = np.full(self.orbits, ITERATES)
        stride = 2.0 ** np.floor(np.log2(np.clip(steps, 1.0, 2.0**40)))
        self.every = self._between_looks(stride)
        self.memory[ROWS.stride] = self.memory[ROWS.left] = stride / self.every

    def _between_looks(self, stride: np.ndarray) -> np.ndarray:
        """Return how many steps (orbits,) are taken between two looks at the vectors: all up to where they are made
        orthonormal, if half the time and the records of the history are at such steps, else one.
        """
        each_step = self.watches or self.early_stop or any(entry.each_step for _, entry in self.tangent)
        if each_step or not self.flow.fixed:
            return np.ones(self.orbits, np.int64)
        steps = self.flow.steps(self.time)
        parts = math.lcm(2, max(1, self.aligned))
        between = np.where(steps % parts == 0, steps // parts, 1)
        return np.minimum(stride.astype(np.int64), between & -between)

    def _start(self, deviation_vectors: Any) -> np.ndarray:
        """Return the tangent vectors at the start, and make the flow carry them."""
        needed = max(entry.vectors(self.n) for _, entry in self.tangent)
        whole = min(2 * self.n, self.flow.system.rows)
        if self.spectrum and not self.paired:
            needed = whole
        if deviation_vectors is None:
            start = frame(self.flow.system, needed)[:, :, None] / self.scale
            self.first = np.zeros((needed, 1))
        else:
            start, self.first = _unit_vectors(deviation_vectors, self.scale[:whole])
            start = start if self.flow.system.driven else carried(start, self.flow.system, 1)
            needed = whole if self.spectrum else needed
        if len(start) < needed and deviation_vectors is None:
            names = listed([entry.name for _, entry in self.tangent if entry.vectors(self.n) > len(start)])
            raise ValueError(
                f"indicators must need at most {len(start)} deviation vector of this system, got {names}. Use 'megno'."
            )
        if len(start) < needed:
            raise ValueError(
                f"deviation_vectors must be at least {needed} vectors for these indicators, got {len(start)}"
            )
        self.flow = replace(self.flow, vectors=len(start))
        return np.array([self._whole(vector) for vector in start])

    def _whole(self, rows: np.ndarray) -> np.ndarray:
        """Return rows (2n, orbits) with zeros for the time and its momentum, if the model has them."""
        missing = self.degrees - self.n
        both = rows.reshape(2, self.n, -1)
        return np.pad(both, ((0, 0), (0, missing), (0, 0))).reshape(2 * self.degrees, -1) if missing else rows

    @property
    def spectrum(self) -> bool:
        """Whether all exponents are asked for."""
        return any(entry.spectrum for _, entry in self.tangent)

    @property
    def planar(self) -> bool:
        """Whether orbits run in a plane, of one degree of freedom without a drive or of two variables: none is chaotic,
        however near a separatrix (Poincare and Bendixson).
        """
        system = self.flow.system
        return not system.iterated and not system.driven and system.rows <= 2

    @property
    def paired(self) -> bool:
        """Whether each exponent has its negative, as for a Hamiltonian system or a symplectic map."""
        return self.flow.system.symplectic

    def stream(self, callback: Callback | None) -> None:
        """Run the tangent vectors, the averages and the samples."""
        try:
            self.flow.advance(
                self.ensemble,
                self.observer,
                self.memory,
                self.out,
                time=self.time,
                observations=self.flow.steps(self.time) // self.every if np.any(self.every > 1) else 0,
                refill=self.early_stop,
                callback=early(callback, self.flow, self.ensemble, self.time) if self.early_stop else callback,
            )
        finally:
            self._read()
            self.lived = self.ensemble.time.copy()
        if self.flow.system.iterated and self.tangent:
            self.alone()

    def _read(self) -> None:
        """Take the readings of the streamed indicators from the memory of the observer."""
        if self.tangent:
            which = [j for j, _ in self.tangent]
            self.values[which] = self.growth.readings[:-1]
            self.before[which] = np.where(self.memory[ROWS.half] > 0, self.growth.half_readings[:-1], np.nan)
        for j, watch, memory, _ in self.watched:
            self.values[j], self.before[j] = watch.read(memory, self.ensemble.time)

    def alone(self) -> None:
        """Find the ends of orbits of a map without their vectors, for orbits that ended with them: vectors may overflow
        before.
        """
        lost = np.flatnonzero(np.isin(self.ensemble.status, (Status.NONFINITE, Status.LOST)))
        if not lost.size:
            return
        flow = replace(self.flow, vectors=0)
        run = flow.ensemble(self.z0[:, lost])
        flow.advance(run, observers.nothing(), *no_memory(run), time=self.time, observations=1)
        ended = run.status != Status.OK
        self.lived[lost[ended]] = run.time[ended]
        self.ensemble.status[lost[ended]] = run.status[ended]

    @property
    def passes(self) -> list[Callable[[Callback | None], None]]:
        """The stream, the values that are finished after it, and the indicators' own passes."""
        found: list[Callable[[Callback | None], None]] = [self.stream] if self.streams else []
        found += [functools.partial(self._finish, j, w.finish, out) for j, w, _, out in self.watched if w.finish]
        streamed = {j for j, _ in (*self.tangent, *self.watches)}
        return found + [functools.partial(self._adopt, j) for j in range(len(self.chosen)) if j not in streamed]

    def _finish(self, j: int, finish: Callable, out: np.ndarray, callback: Callback | None) -> None:
        """Take the values that an indicator finds from its observations."""
        self.values[j] = np.where(self.ensemble.status == Status.OK, finish(out, callback), np.nan)

    def _adopt(self, j: int, callback: Callback | None) -> None:
        """Run the pass of an indicator of its own; an orbit that fails in it is marked."""
        entry: Any = self.chosen[j]
        found = entry.compute(replace(self.flow, vectors=0), self.z0, self.time, self.rates, callback)
        shapes = [np.shape(part) for part in found] if isinstance(found, tuple) else []
        if shapes not in ([(self.orbits,), end, (self.orbits,)] for end in ((), (self.orbits,))):
            raise TypeError(
                f"compute of the indicator {entry.name} must return values, references and statuses of {self.orbits} "
                f"orbits, got {shown(found)}"
            )
        self.values[j], self.before[j], status = found
        fine = self.ensemble.status == Status.OK
        self.ensemble.status[fine] = status[fine]

    def records(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the times of detection (indicators, orbits), the history (indicators, slots, orbits) and its times
        (slots, orbits).
        """
        detected = np.full(self.values.shape, np.nan)
        history = np.full((len(self.chosen), self.slots, self.orbits), np.nan)
        if not self.tangent:
            return detected, history, np.full((self.slots, self.orbits), np.nan)
        records = self._records()
        for number, (j, _) in enumerate(self.tangent):
            times = self.growth.detected[number]
            detected[j] = np.where(times > 0, times, np.nan)
            history[j] = records[1 + number, self.finer - 1 :: self.finer][: self.slots]
        return detected, history, records[0, self.finer - 1 :: self.finer][: self.slots]

    def lasting(self) -> np.ndarray:
        """Return a mask (orbits,) of the orbits whose first vector has grown all the time: in more parts of the run
        than those with the most growth, which may be one passage of a saddle each.

        One passage stretches a vector by as much as an orbit is near the separatrix, of regular orbits too; the largest
        length so far then stays as it is, while that of chaotic orbits grows on.
        """
        if not self.tangent:
            return np.zeros(self.orbits, bool)
        at = -(-self.records_kept * np.arange(1, PARTS + 1) // PARTS) - 1
        largest = self._records()[self.m][at]
        largest[-1] = self.growth.readings[-1]
        largest = np.maximum.accumulate(np.fmax(np.where(np.isfinite(largest), largest, 0.0), 0.0), axis=0)
        growth = np.sort(np.diff(largest, axis=0, prepend=0.0), axis=0)
        return growth[: PARTS - PASSAGES].sum(axis=0) > LASTING

    def rests(self) -> np.ndarray:
        """Return a mask (orbits,) of the orbits that are at the end where they started; none if nothing was streamed,
        as indicators with passes of their own do without it.
        """
        if not self.streams:
            return np.zeros(self.orbits, bool)
        n = self.degrees
        moving = self.n
        rows = [*range(moving), *range(n, n + moving)]
        start = self.z0[rows]
        end = self.ensemble.points[rows]
        with np.errstate(all="ignore"):
            return (np.abs(end - start) <= UNMOVED * np.abs(start)).all(axis=0)

    def _records(self) -> np.ndarray:
        """Return the times, the readings and the sums (columns, records, orbits) that the stream has written."""
        kept = self.out[:, : self.records_kept * self.width].reshape(self.orbits, self.records_kept, self.width)
        return kept.transpose(2, 1, 0)

    def exponents(self) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Return the Lyapunov spectrum, the largest first, and its errors."""
        if not self.spectrum:
            return None, None
        records = self._records()
        last = self.memory[ROWS.last]
        # Volumes count from the start, whatever the angles between given vectors.
        sums = np.concatenate([records[1 + self.m :], self.growth.sums[:, None]], axis=1) - self.first[:, None]
        # An iterate may leave no digits for the rest.
        if self.paired and (self.k < 2 * self.n or self.flow.system.iterated):
            sums = np.concatenate([sums[: self.n], -sums[: self.n][::-1]])
        with np.errstate(all="ignore"):
            now = sums[:, -1] / last
        error = averaging_error(records[0], sums[:, :-1], now, LONG_MEMORY if self.paired else BLOCKS)
        order = np.argsort(-now, axis=0, kind="stable")
        return np.take_along_axis(now, order, axis=0), np.take_along_axis(error, order, axis=0)


def averaging_error(times: np.ndarray, sums: np.ndarray, mean: np.ndarray, blocks: dict[int, float]) -> np.ndarray:
    """Return the error (rows, orbits) of rates of growth `mean` (rows, orbits) = S/T from S at some RECORDS equidistant
    times (records, orbits), sums (rows, records, orbits).

    It is the change by the first record, in which tangent vectors align, plus the spread of blocks of the rest, the
    largest for these numbers of blocks. It is inf for orbits that are too short.
    """
    known = np.isfinite(times).sum(axis=0)
    spread = np.zeros_like(mean)
    for count, student in blocks.items():
        edges = known * (1 + (RECORDS - 1) * np.arange(count + 1)[:, None] // count) // RECORDS - 1
        edges = np.maximum(edges, 0)
        t = np.take_along_axis(times, edges, axis=0)
        S = np.take_along_axis(sums, edges[None], axis=1)
        with np.errstate(all="ignore"):
            rates = np.moveaxis(np.diff(S, axis=1) / np.diff(t, axis=0), 1, 0)
            variance = total((rates - total(rates) / count) ** 2) / (count - 1)
            spread = np.maximum(spread, student * np.sqrt(variance) / math.sqrt(count))
            error = np.abs(mean - (S[:, -1] - S[:, 0]) / (t[-1] - t[0])) + spread
    return np.where((known >= max(blocks)) & np.isfinite(error), error, np.inf)
