"""Running kernels: flows of a model by a scheme, interruption and progress."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import fits, number_of_steps
from ..engine.jit import LANES
from ..engine.kernels import crossing_roots as roots
from ..engine.kernels.adaptive_drive import AdaptiveSteps, run_adaptive
from ..engine.kernels.crossings import CERTAIN, RECORD
from ..engine.kernels.drive import FixedSteps, run_along, run_fixed, run_one
from ..engine.kernels.samples import WEAR_ROWS, lost_until
from ..engine.lane_sums import VECTOR
from ..engine.threads import by_portions
from ..systems.models.mechanics import System
from . import observers
from .ensemble import Ensemble, no_memory
from .launch import Report, launch, units
from .leaving import leave_open, mark_escapes
from .observers import Observer
from .reaches import FARTHEST, escape_radii
from .schemes.catalogue import Collocation, Nystrom, Scheme, Splitting
from .stepping import stepping

WEAR_STEPS = 2, 4, 8, 16, 32
"""Steps, or one, after which slowed orbits lose part of their momenta: lanes of a block stop together."""


class Wear(NamedTuple):
    """Slowing of each orbit: by the time t momenta have lost the fraction share*(u + 2 u e/(u + e)), u = sqrt(t),
    e = sqrt(early), three times as much in the beginning as later; they lose it about once in a time `every`. Arrays
    (orbits,).
    """

    share: np.ndarray
    early: np.ndarray
    every: np.ndarray

    def pace(self, step: np.ndarray | float, parts: np.ndarray | int = 0) -> np.ndarray:
        """Return the number (orbits,) of steps after which momenta are lost: 1 or one of WEAR_STEPS, a divisor of
        `parts`.
        """
        found = np.ones(len(self.every), np.int64)
        most = self.every / step
        for steps in WEAR_STEPS:
            found = np.where((steps <= most) & (parts % steps == 0), steps, found)
        return found

    def begin(self, ensemble: Ensemble, memory: np.ndarray, pace: np.ndarray) -> None:
        """Set WEAR_ROWS of orbits that lose momenta every `pace` steps; the loss up to the first of these is made at
        once, as chaotic orbits have amplified by then what else would not be there.
        """
        early = np.sqrt(self.early)
        momenta = len(ensemble.z) // 2
        lost = lost_until(pace * ensemble.ahead, self.share, early)
        memory[WEAR_ROWS.share] = self.share
        memory[WEAR_ROWS.early] = early
        memory[WEAR_ROWS.lost] = lost
        ensemble.z[momenta:] *= 1 - lost


@dataclass(frozen=True)
class Flow:
    """A model's flow by a scheme: with steps of size `step`, or adaptive with relative tolerance `rtol` (and `atol`).

    step: one number for all orbits or (orbits,), a step for each; vectors: number of tangent vectors of each orbit.
    """

    system: System
    scheme: Scheme
    step: float | np.ndarray
    rtol: float
    atol: float
    threads: int
    vectors: int = 0

    patience = 1

    @property
    def model(self) -> Any:
        """The model."""
        return self.system.model

    @property
    def adaptive(self) -> bool:
        """Whether the scheme controls its step."""
        return self.scheme.adaptive

    @property
    def fixed(self) -> bool:
        """Whether it takes equal steps in time."""
        return not (self.adaptive or self.system.iterated)

    @property
    def alike(self) -> bool:
        """Whether the caller chose one step or one pair of tolerances for all orbits."""
        return self.adaptive

    @property
    def precise(self) -> bool:
        """Whether steps are summed as increments with carried rounding errors: for schemes whose own error is small
        enough.
        """
        return getattr(self.scheme, "increments", isinstance(self.scheme, Collocation))

    def ensemble(
        self, z0: np.ndarray, deviations: np.ndarray | None = None, radius: np.ndarray | None = None
    ) -> Ensemble:
        """Start orbits from z0 (2n, orbits), which is taken over, with the tangent vectors deviations (vectors, 2n,
        orbits).

        radius (orbits,): the distances beyond which they have escaped, `escape_radii` of z0, if these are known
        already.
        """
        n = self.system.n
        state = z0
        if deviations is not None:
            whole = np.concatenate([z0[None], deviations]).reshape(1 + self.vectors, 2, n, -1)
            state = np.ascontiguousarray(whole.transpose(1, 0, 2, 3)).reshape(-1, z0.shape[1])
        started = Ensemble(state, self.system.energies(z0), self.system.kinetic_energies(z0), self.vectors)
        started.radius = escape_radii(self.system, z0, started.energy) if radius is None else radius
        started.ahead[:] = self.step if np.isfinite(self.step).all() else self._first_steps(z0)
        return started

    def _first_steps(self, z0: np.ndarray) -> np.ndarray:
        """Return the first steps (orbits,) of a scheme that controls them: those given, else a hundredth of the time in
        which z0 changes by its size.
        """
        size = np.abs(z0).max(axis=0)
        speed = np.abs(self.system.slopes(z0)).max(axis=0)
        guess = np.where(speed > 0, 0.01 * size / np.where(speed > 0, speed, 1.0), 0.01)
        guess = np.where(guess > 0, guess, 1e-6)
        if self.system.driven:
            guess = np.full_like(guess, 1e-3 * self.model.period)
        return np.where(np.isfinite(self.step), self.step, guess)

    def steps(self, time: float | np.ndarray) -> np.ndarray:
        """Return the number of steps that reach `time`, for each orbit where steps or times differ."""
        return np.maximum(1, number_of_steps(time, self.step)).astype(np.int64)

    def fitted(self, time: float | np.ndarray, parts: int = 1) -> Flow:
        """Return the flow with the longest steps, at most its own, that divide `time` into a multiple of `parts`;
        itself if adaptive.
        """
        return replace(self, step=time / (parts * self.steps(time / parts))) if self.fixed else self

    def sized(self, step: np.ndarray) -> Flow:
        """Return the flow with steps of those sizes (orbits,); an adaptive one with tolerances that follow by its
        order, where its own count as a step of 1.
        """
        if self.adaptive:
            factor = float(step[0]) ** self.scheme.order
            return replace(self, rtol=self.rtol * factor, atol=self.atol * factor)
        return replace(self, step=step)

    def finer(self) -> Flow:
        """Return the flow with half its step, or with a hundredth of its tolerances."""
        if self.adaptive:
            return replace(self, rtol=max(self.rtol / 100, 1e-15), atol=self.atol / 100)
        return replace(self, step=self.step / 2)

    def of(self, orbits: Any) -> Flow:
        """Return the flow of some of the orbits, chosen by an index array or mask."""
        return replace(self, step=self.step[orbits]) if isinstance(self.step, np.ndarray) and self.step.ndim else self

    def _unit(self, orbits: int) -> int:
        """Number of orbits that a thread takes at once: about eight portions each, whole blocks where there are enough
        orbits, else equal numbers of blocks for each thread, all of equal numbers of whole vectors.
        """
        portion = math.ceil(orbits / (8 * self.threads))
        if portion >= LANES:
            return LANES * math.ceil(portion / LANES)
        own = math.ceil(orbits / self.threads)
        size = math.ceil(own / math.ceil(own / LANES))
        return size if own <= LANES else VECTOR * math.ceil(size / VECTOR)

    def unit(self, orbits: int) -> int:
        """Return the number of orbits, at most a block, that a thread takes at once if all have equally many steps."""
        return min(LANES, self._unit(orbits))

    def advance(
        self,
        ensemble: Ensemble,
        observer: Observer,
        memory: np.ndarray,
        out: np.ndarray,
        *,
        time: float | np.ndarray,
        observations: int | np.ndarray = 0,
        refill: bool = False,
        report: Report | None = None,
    ) -> None:
        """Advance the ensemble to `time`, perhaps one for each orbit, and update its status.

        The observer sees `observations` equidistant states, for which steps are shortened as necessary, or every step
        if that is 0.
        """
        known = not self.adaptive and bool((ensemble.radius < FARTHEST).any())
        begun = ensemble.of(np.arange(ensemble.status.size)) if known else None
        try:
            self.run(
                ensemble, observer, memory, out, time=time, observations=observations, refill=refill, report=report
            )
            if begun is not None:
                mark_escapes(self, ensemble, begun, lambda: self._equal_steps(begun.status.size, time, observations)[2])
        except BaseException:
            if begun is not None:
                leave_open(ensemble, begun)
            raise

    def run(
        self,
        ensemble: Ensemble,
        observer: Observer,
        memory: np.ndarray,
        out: np.ndarray,
        *,
        time: float | np.ndarray,
        observations: int | np.ndarray = 0,
        refill: bool = False,
        report: Report | None = None,
    ) -> None:
        """Advance the ensemble as `advance` does; an orbit that overflows is NONFINITE."""
        run = self._advance_adaptive if self.adaptive else self._advance_fixed
        run(ensemble, observer, memory, out, time, observations, refill, report)

    def states(self, z: np.ndarray) -> np.ndarray:
        """Return the model's phase points (2n, ...) from the rows z of an ensemble: the rows without an idle one, with
        the time of a driven system reduced to its period.
        """
        if self.system.driven:
            z[self.system.moving] = self.model.phase(z[self.system.moving])
        return z[: self.system.rows]

    def section(self, section: Any) -> Any:
        """Return a section of the model as one of the flow's states: itself, or with a 0 for an idle row."""
        idle = 2 * self.system.n - self.system.rows
        return section._replace(normal=(*section.normal, 0.0)) if idle else section

    def trajectory(self, ensemble: Ensemble, time: float, count: int, report: Report | None) -> tuple[np.ndarray, bool]:
        """Run to the end; return states (count, 2n, orbits) at equidistant times, NaN where not reached, and whether
        interrupted.
        """
        rows, orbits = ensemble.z.shape
        fits("samples", orbits, count, rows)
        states = np.full((orbits, count, rows), np.nan)
        interrupted = False
        try:
            if count:
                self.sampled(ensemble, count, time=time, states=states, report=report)
            else:
                nothing = observers.nothing()
                self.advance(ensemble, nothing, *no_memory(ensemble), time=time, observations=1, report=report)
        except KeyboardInterrupt:
            interrupted = True
        self.states(states.transpose(2, 0, 1))
        return states.transpose(1, 2, 0)[:, : self.system.rows], interrupted

    def sampled(
        self,
        ensemble: Ensemble,
        count: int,
        *,
        time: float | np.ndarray,
        states: np.ndarray | None = None,
        report: Report | None = None,
    ) -> np.ndarray:
        """Advance the ensemble to `time`; return `count` equidistant states (orbits, count, rows) of it, NaN where not
        reached.

        They are written to `states` if it is given, so that Ctrl-C does not lose them.
        """
        rows, orbits = ensemble.z.shape
        if states is None:
            states = np.full((orbits, count, rows), np.nan)
        observer = observers.samples(rows)
        out = states.reshape(orbits, count * rows)
        memory = np.zeros((observer.rows, orbits))
        self.advance(ensemble, observer, memory, out, time=time, observations=count, report=report)
        return states

    def worn(
        self, ensemble: Ensemble, count: int, wear: Wear, *, time: float, report: Report | None
    ) -> tuple[np.ndarray, bool]:
        """Run as `trajectory` does, while the momenta wear down, after each step or every WEAR_STEPS."""
        rows, orbits = ensemble.z.shape
        fits("samples", orbits, count, rows)
        states = np.full((orbits, count, rows), np.nan)
        interrupted = False
        each = self.steps(time / count)
        pace = wear.pace(self.step, each)
        stride = each // pace
        observer = observers.worn_samples(rows)
        at = WEAR_ROWS
        memory = np.zeros((observer.rows, orbits))
        wear.begin(ensemble, memory, pace)
        memory[at.stride] = stride
        memory[at.left] = stride
        out = states.reshape(orbits, count * rows)
        try:
            self.advance(ensemble, observer, memory, out, time=time, observations=count * stride, report=report)
        except KeyboardInterrupt:
            interrupted = True
        return states.transpose(1, 2, 0), interrupted

    def observed(
        self,
        z0: np.ndarray,
        observer: Observer,
        *,
        time: float,
        columns: int = 1,
        observations: int = 0,
        report: Report | None = None,
    ) -> tuple[Ensemble, np.ndarray, np.ndarray]:
        """Run orbits from z0 (2n, orbits) to `time` under an observer, as in `advance`; return the ensemble, the
        observer's memory (rows, orbits), which is zero at the start, and its records (orbits, columns), else NaN.
        """
        ensemble = self.ensemble(np.array(z0, dtype=np.float64, order="C"))
        orbits = z0.shape[1]
        memory = np.zeros((observer.rows, orbits))
        out = np.full((orbits, columns), np.nan)
        self.advance(ensemble, observer, memory, out, time=time, observations=observations, report=report)
        return ensemble, memory, out

    def _advance_adaptive(self, ensemble, observer, memory, out, time, observations, refill, report) -> None:
        """Advance with step control; lanes are always refilled, so `refill` changes nothing."""
        orbits = ensemble.z.shape[1]
        unit = self._unit(orbits)
        steps = AdaptiveSteps(
            until=np.array(np.broadcast_to(time, orbits), dtype=np.float64),
            rtol=self.rtol,
            atol=self.atol,
            own=self.model.degrees_of_freedom,
            mixed=not self.system.canonical,
            cadence=float(time / observations) if observations else 0.0,
            renew=self.vectors > 0,
        )
        under_way = ensemble.orbits(memory, out)
        arguments = *stepping(self, "check"), observer.bound, steps, unit, under_way
        launch(run_adaptive, arguments, units(orbits, unit), float(orbits), self.threads, report)

    def _advance_fixed(self, ensemble, observer, memory, out, time, observations, refill, report) -> None:
        """Advance each orbit with equal steps; `count` of the ensemble is the number of steps done."""
        orbits = ensemble.z.shape[1]
        every, total, h = self._equal_steps(orbits, time, observations)
        # Orbits that end and are observed together share blocks.
        order = np.lexsort((every, -total))
        unit = self._unit(orbits) if refill else self.unit(orbits)
        single = isinstance(self.scheme, Nystrom) or (isinstance(self.scheme, Splitting) and not self.precise)
        solo = unit == 1 and single and not self.system.poles
        steps = FixedSteps(h, total, every, order, strict=self.vectors > 0, refill=refill)
        kernel = run_one if solo else run_fixed
        if solo and refill and observer.along is not None:
            kernel = run_along
            observer = observer.along
            steps = steps._replace(every=np.full_like(every, observer.stretch))
        how = stepping(self, "inside", "check", solo=solo)
        arguments = *how, observer.bound, steps, unit, ensemble.orbits(memory, out)
        try:
            work = float((total - ensemble.count).sum())
            launch(kernel, arguments, units(orbits, unit), work, self.threads, report, work)
        finally:
            ensemble.time[:] = ensemble.count * h

    def _equal_steps(self, orbits: int, time: Any, observations: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the steps (orbits,) between observations, those to `time`, and their sizes."""
        every = np.ones(orbits, np.int64)
        total = np.empty(orbits, np.int64)
        h = np.empty(orbits)
        if np.any(observations):
            every[:] = self.steps(time / observations)
            total[:] = observations * every
            h[:] = time / total
        else:
            total[:] = self.steps(time)
            h[:] = self.step
        return every, total, h

    def locate(self, section: Any, records: np.ndarray, where: np.ndarray, report: Report | None = None) -> None:
        """Turn the records numbered `where` into crossings of the section, in place."""
        if not where.size:
            return
        certain = np.empty(where.size, bool)

        def look(at: slice) -> None:
            np.equal(records[where[at], RECORD.kind], CERTAIN, out=certain[at])

        by_portions(look, where.size, records.shape[1], self.threads)
        doubtful = where[~certain]
        if doubtful.size:
            where = np.concatenate([where[certain], doubtful])  # whose search takes longer
        function = observers.bound("value", section, self.model.degrees_of_freedom, self.vectors)
        found = *stepping(self), function
        if doubtful.size:
            steps = float(roots.SLOW * doubtful.size)
            launch(roots.bracket, (*found, records, doubtful), units(doubtful.size), 0.0, self.threads, None, steps)
        portion = math.ceil(where.size / self.threads)
        unit = portion if portion <= 8 * LANES else math.ceil(portion / 4)  # lanes of a unit take its next records
        arguments = *found, float(section.direction), records, where, unit
        steps = float(roots.USUAL * where.size)
        launch(roots.locate, arguments, units(where.size, unit), float(where.size), self.threads, report, steps)

    def shifted(self, z: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """Return the states z (rows, orbits) one step of steps[orbit] later, or earlier where that is negative."""
        table = np.array(z, order="C")
        arguments = *stepping(self), steps, table
        launch(roots.shift, arguments, units(z.shape[1]), 0.0, self.threads, None, z.shape[1])
        return table
