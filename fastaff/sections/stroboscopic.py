"""Stroboscopic sections of driven systems: states at exact multiples of the period, where nothing is searched."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, fits, portion
from ..core.status import Status
from ..runs import observers
from ..runs.accuracy import Steps, planned, refine_steps, until
from ..runs.flow import Damping, Flow, energy_error, no_memory
from ..runs.integrate import Compared
from ..runs.options import Options, Problem
from ..runs.requirements import energy_drift
from ..runs.scales import motion
from ..systems.models.sections import Stroboscopic
from .crossing_run import Crossings
from .section_map import SectionMap

START = 8 * float(np.finfo(float).eps)
"""Part of the period that is rounding: a start that close to the section is on it."""

PORTION = 2**27
"""Bytes that are used beside the result at a time."""

COMPARED = 8
"""Work memory of an orbit, in units of its crossings."""


def strobed(problem: Problem, crossings: Crossings) -> SectionMap:
    """Follow orbits of a driven system to so many crossings of a stroboscopic section; see `poincare_map`."""
    flow, z, *_ = problem.plan(time=float(problem.model.period), error=None)
    fits("crossings", crossings.number, *z.shape)
    return _Strobed(flow, z, crossings.section, crossings.number, problem.options).run()


class _Strobed:
    """A stroboscopic map in the making; arrays (crossings, 2n, orbits) hold the results so far."""

    def __init__(self, flow: Flow, z: np.ndarray, section: Stroboscopic, wanted: int, options: Options):
        self.flow = flow
        self.z = z
        self.section = section
        self.wanted = wanted
        self.options = options
        self.period = float(flow.model.period)
        self.row = flow.system.moving
        lead = np.mod(section.phase - z[self.row], self.period)
        near = START * self.period
        self.lead = np.where((lead < near) | (lead > self.period - near), self.period, lead)
        rows, orbits = z.shape
        self.times = self.period * np.arange(1, wanted + 1)[:, None] - (self.period - self.lead)
        self.states = np.full((wanted, rows, orbits), np.nan)
        self.error: np.ndarray | None = None
        self.ensemble = flow.ensemble(z.copy())
        self.ensemble.status[:] = Status.INTERRUPTED
        self.step: np.ndarray | float = flow.step if flow.adaptive else np.full(orbits, np.nan)
        self.until = np.zeros(orbits)

    def run(self) -> SectionMap:
        """Follow all orbits, once or with steps that are halved until the states agree."""
        goal = self.options.goal()
        callback = self.options.callback
        steps = None if goal is None else self._steps(goal)  # there is nothing to keep yet
        with partial_result_on_interrupt("poincare_map", self.result):
            if goal is None or steps is None:
                self._once(callback)
            else:
                self._accurate(steps, goal, callback)
        return self.result()

    def _once(self, callback: Callback | None) -> None:
        flow = self.flow.fitted(self.period)
        self.step = flow.step
        every = np.arange(self.z.shape[1])
        self._keep(every, self._follow(flow, every, self.ensemble.radius, None, callback))

    def _steps(self, goal: float) -> Steps:
        """Return the first steps; from here on states have errors."""
        flow = self.flow
        z = self.z
        found = motion(flow.system, z, flow.threads)
        steps = planned(flow, z, found, self.wanted * self.period, goal, run=self.period, parts=2)
        self.error = np.full(self.states.shape, np.nan)
        return steps

    def _accurate(self, steps: Steps, goal: float, callback: Callback | None) -> None:
        flow = self.flow
        found = steps.motion
        errors = np.asarray(self.error)
        rows, orbits = self.z.shape
        size = np.concatenate([found.position, found.momentum])

        def run(
            orbits: np.ndarray, step: np.ndarray, damping: Damping | None, callback: Callback | None, fine
        ) -> Compared:
            try:
                return self._follow(flow.sized(step), orbits, found.radius[orbits], damping, callback)
            except KeyboardInterrupt:
                if fine is not None:
                    self._keep(orbits, fine)
                self.ensemble.status[orbits] = Status.INTERRUPTED  # whatever their outcome with these steps
                raise

        def compare(fine: Compared, coarse: Compared, orbits: np.ndarray, _weight: np.ndarray | None) -> tuple:
            ended = ~np.isfinite(fine.states).all(axis=1)
            apart = found.of(orbits).between(fine.states, coarse.states, flow.threads)
            phase = np.where(ended, 0.0, self.times[:, orbits] * found.rate[orbits])
            return np.where(ended, 0.0, apart), phase, np.ones((1, orbits.size))

        def keep(orbits: np.ndarray, fine: Compared, chosen: np.ndarray, error: np.ndarray) -> None:
            where = orbits[chosen]
            self._keep(where, fine.of(chosen))
            error = error[:, chosen]
            errors[..., where] = error[:, None] * size[:, where]
            holds = np.isnan(self.states[:, 0, where]) | (error <= goal)
            self.until[where] = until(holds, self.times[:, where], self.ensemble.time[where])

        def drifts(run: Compared) -> np.ndarray:
            drift = energy_error(flow.system, run.ensemble)
            return (run.ensemble.status == Status.OK) & (drift > self.options.drift)

        parts = max(1, min(orbits, 8 * COMPARED * self.wanted * rows * orbits // PORTION))
        for number, part in enumerate(np.array_split(np.arange(orbits), parts)):
            told = portion(callback, number, parts)
            refine_steps(flow, steps.of(part), goal, run, compare, keep, drifts, part, told)

    def _follow(
        self, flow: Flow, orbits: np.ndarray, radius: np.ndarray, damping: Damping | None, callback: Callback | None
    ) -> Compared:
        """Run these orbits: to the section, unless they start a period before it, then from period to period; both
        kinds run separately, as each orbit would alone.
        """
        on = self.lead[orbits] >= self.period
        if on.any() and not on.all():
            whole = flow.ensemble(np.ascontiguousarray(self.z[:, orbits]), radius=radius)
            states = np.empty((self.wanted, *whole.z.shape))
            steps = np.empty(orbits.size)
            for some in (np.flatnonzero(on), np.flatnonzero(~on)):
                damped_part = None if damping is None else Damping(*(entry[some] for entry in damping))
                part = self._follow(flow.of(some), orbits[some], radius[some], damped_part, callback)
                whole.take(some, part.ensemble)
                states[..., some] = part.states
                steps[some] = part.step
            return Compared(states, whole, steps)
        used = np.broadcast_to(np.inf if flow.adaptive else flow.step, orbits.size)
        ensemble = flow.ensemble(np.ascontiguousarray(self.z[:, orbits]), radius=radius)
        lead = self.lead[orbits]
        rest = self.wanted
        first: list[np.ndarray] = []
        if (lead < self.period).any():
            begin = flow if flow.adaptive else replace(flow, step=lead / flow.steps(lead))
            nothing = observers.nothing()
            observed = 0 if flow.adaptive else 1
            begin.advance(ensemble, nothing, *no_memory(ensemble), time=lead, observations=observed, callback=None)
            first = [flow.states(np.where(ensemble.status == 0, ensemble.z, np.nan))[None]]
            rest = rest - 1
            ensemble.count[:] = 0
            ensemble.time[:] = 0.0
        interrupted = False
        states = np.zeros((0, *self.z[:, orbits].shape))
        if rest and damping is None:
            states, interrupted = flow.trajectory(ensemble, rest * self.period, rest, callback)
        elif rest and damping is not None:
            states, interrupted = flow.damped(ensemble, rest, damping, time=rest * self.period, callback=callback)
        if first:
            ensemble.time += lead
        run = Compared(np.concatenate([*first, states]), ensemble, used)
        if interrupted:
            done = np.isfinite(run.states[-1]).all(axis=0)
            ensemble.status[(ensemble.status == Status.OK) & ~done] = Status.INTERRUPTED
            self._keep(orbits, run)
            raise KeyboardInterrupt
        return run

    def _keep(self, orbits: np.ndarray, run: Compared) -> None:
        self.states[..., orbits] = run.states
        self.ensemble.take(orbits, run.ensemble)
        if isinstance(self.step, np.ndarray):
            self.step[orbits] = run.step

    def result(self) -> SectionMap:
        """Return the map so far: each orbit up to its end, or to where its energy has drifted."""
        flow = self.flow
        ensemble = self.ensemble
        tolerance = self.options.drift
        states = self.states
        there = np.isfinite(self.states).all(axis=1)
        t = states[:, self.row]
        t -= self.period * np.rint((t - self.section.phase) / self.period)  # near the phase from both sides
        drift = energy_drift(flow.system, states.transpose(1, 0, 2), ensemble.energy, ensemble.scale)
        beyond = there & (drift > tolerance)
        counts = np.where(beyond.any(axis=0), beyond.argmax(axis=0), there.sum(axis=0))
        kept = np.arange(self.wanted)[:, None] < counts
        energy = np.where(there, drift, 0.0).max(axis=0)
        status = ensemble.status.copy()
        status[(status == Status.OK) & (energy > tolerance)] = Status.ENERGY_DRIFT
        points = np.where(kept[:, None], states, np.nan).transpose(1, 0, 2)
        residual = np.where(kept, np.abs(t - self.section.phase), 0.0).max(axis=0)
        points[self.row, kept] = self.section.phase
        error = late = None
        if self.error is not None:
            late = np.where(kept, 0.0, np.nan)
            error = np.where(kept[:, None], self.error, np.nan)
            error[:, self.row] = np.where(kept, residual + START * self.period, np.nan)
            error = error.transpose(1, 0, 2)
        return SectionMap(
            points=points,
            times=np.where(kept, self.times, np.nan),
            counts=counts.astype(np.int64),
            section_error=residual,
            energy_error=energy,
            status=status,
            section=self.section,
            scheme=flow.scheme,
            step=self.step,
            names=flow.system.row_names,
            time_error=late,
            point_error=error,
            accurate_until=None if error is None else self.until,
        )
