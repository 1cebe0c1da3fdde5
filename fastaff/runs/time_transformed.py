"""Running time-transformed splittings: to a given time, with samples or section crossings, and the trial of rates."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..core.numbers import Callback, fits, shown
from ..core.status import Status
from ..engine.kernels.crossings import LOCATED, NOTHING, RECORD
from ..engine.kernels.time_levels import ROWS
from ..systems.models.mechanics import System, system_of
from ..systems.models.sections import Hyperplane
from . import observers
from .flow import Ensemble, Flow, early
from .observers import Observer
from .requirements import energy_drift
from .scales import typical_rate
from .schemes.catalogue import DOP853
from .schemes.time_transformed import (
    Algebraic,
    Logistic,
    TimeTransformed,
    lifted,
    lowered,
    transformed_model,
    transformed_section,
)
from .trials import Sample, following_step, sample_of, trial_step

PATIENCE = 1000
"""Most steps of an orbit over the expected number: one that falls into a singularity would never end."""


LOOKS = 40
"""States of each orbit that give the range of its potential."""

OVERSHOOT = 1e3
"""Upper bound of tau = t/time: as a coordinate it must not count as escaped."""


@dataclass(frozen=True)
class TransformedFlow:
    """A model's flow by a `TimeTransformed` scheme up to `time`, in place of `Flow`.

    The ensemble's states are those of the transformed model (see `lifted`), its `time` is the orbits' time; `states`
    and `section` translate. `pace` is about dt/ds and predicts numbers of steps.
    """

    original: System
    flow: Flow
    scheme: TimeTransformed
    pace: float
    patience: int = PATIENCE

    adaptive = False
    precise = False
    alike = True

    @property
    def model(self) -> Any:
        """The transformed model."""
        return self.flow.model

    @property
    def system(self) -> System:
        """The transformed model with its traits and mechanics."""
        return self.flow.system

    @property
    def threads(self) -> int:
        """The number of threads."""
        return self.flow.threads

    @property
    def step(self) -> float:
        """The step in s."""
        return float(self.flow.step)

    @property
    def row(self) -> int:
        """The row of tau in a state."""
        return self.model.degrees_of_freedom - 1

    def steps(self, time: float) -> int:
        """Return the most steps that an orbit may take to reach `time`."""
        return self.patience * math.ceil(time / (self.step * self.pace))

    def fitted(self, time: float, parts: int = 1) -> TransformedFlow:
        """Return the flow itself: its steps divide no time."""
        return self

    def sized(self, step: np.ndarray) -> TransformedFlow:
        """Return the flow with a step in s of that size, the first of (orbits,)."""
        return replace(self, flow=replace(self.flow, step=float(step[0])))

    def states(self, z: np.ndarray) -> np.ndarray:
        """Return the model's phase points (2n, ...) of rows z of an ensemble."""
        return lowered(z)

    def section(self, section: Any) -> Any:
        """Return a section of the model as one of the flow's states."""
        return transformed_section(section)

    def ensemble(self, z0: np.ndarray, radius: np.ndarray | None = None) -> Ensemble:
        """Start orbits from phase points z0 (2n, orbits) of the model; radius: see `Flow.ensemble`."""
        started = self.flow.ensemble(lifted(z0, self.original.energies(z0)), radius=radius)
        started.radius = np.hypot(started.radius, OVERSHOOT)
        return started

    def advance(
        self,
        ensemble: Ensemble,
        observer: Observer,
        memory: np.ndarray,
        out: np.ndarray,
        *,
        time: float,
        refill: bool = True,
        callback: Callback | None = None,
    ) -> None:
        """Advance the ensemble until it has reached the model's time or the observer ends its orbits; see
        `Flow.advance`.
        """
        most = self.steps(time)
        running = (ensemble.status == Status.OK) & (ensemble.count < most)
        watcher = observers.either(observer, observers.beyond(self.row, 1.0))
        try:
            self.flow.advance(ensemble, watcher, memory, out, time=most * self.step, refill=True, callback=callback)
        finally:
            tau = ensemble.z[self.row]
            exhausted = running & (ensemble.status == Status.OK) & (ensemble.count >= most) & (tau < 1.0)
            ensemble.status[exhausted] = Status.STEP_TOO_SMALL
            ensemble.time[:] = tau * self.model.time

    def locate(self, section: Any, records: np.ndarray, where: np.ndarray, callback: Callback | None = None) -> None:
        """Turn the records numbered `where` into crossings of a section of transformed states; drop late ones."""
        self.flow.locate(section, records, where, callback)
        tau = records[where, RECORD.state + self.row]
        records[where, RECORD.time] = tau * self.model.time
        records[where[(tau > 1.0) & (records[where, RECORD.kind] == LOCATED)], RECORD.kind] = NOTHING

    def shifted(self, z: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """Return the states one step later or earlier; see `Flow.shifted`."""
        return self.flow.shifted(z, steps)

    def trajectory(
        self, ensemble: Ensemble, time: float, count: int, callback: Callback | None
    ) -> tuple[np.ndarray, bool]:
        """Run to the end; return states (count, 2n, orbits) at equidistant times, NaN where not reached, and whether
        interrupted.

        Orbits that finish end at the last of them.
        """
        levels = np.arange(1, max(count, 1) + 1) / max(count, 1)
        states, interrupted = self._passages(ensemble, levels, callback)
        return states[:count], interrupted

    def trajectory_at(
        self, ensemble: Ensemble, time: float, moments: np.ndarray, callback: Callback | None, damping: None = None
    ) -> tuple[np.ndarray, bool]:
        """Run to the end; return states (moments, 2n, orbits) at these times, NaN where not reached, and whether
        interrupted.
        """
        levels = moments / time
        states, interrupted = self._passages(
            ensemble, levels if levels[-1] == 1.0 else np.append(levels, 1.0), callback
        )
        return states[: len(levels)], interrupted

    def _passages(self, ensemble: Ensemble, levels: np.ndarray, callback: Callback | None) -> tuple[np.ndarray, bool]:
        """Run to the end; return states (levels, 2n, orbits) where tau passes increasing levels, the last of them 1."""
        count = len(levels)
        rows, orbits = ensemble.z.shape
        width = RECORD.state + rows
        fits("samples", orbits, count, width)
        observer = observers.levels(self.row, count, rows)
        memory = np.zeros((observer.rows, orbits))
        out = np.full((orbits, count * width), np.nan)
        out[:, RECORD.time :: width] = levels
        memory[ROWS.state :] = ensemble.z
        interrupted = False
        try:
            told = early(callback, self, ensemble, self.model.time, 1 / self.patience)
            self.advance(ensemble, observer, memory, out, time=self.model.time, callback=told)
        except KeyboardInterrupt:
            interrupted = True
        records = out.reshape(-1, width)
        passed = memory[ROWS.passed].astype(np.int64)
        where = np.flatnonzero(np.arange(count) < passed[:, None])
        normal = (0.0,) * self.row + (1.0,) + (0.0,) * (rows - self.row - 1)
        try:
            self.flow.locate(Hyperplane(normal), records, where)
        except KeyboardInterrupt:
            interrupted = True
            left = where[records[where, RECORD.kind] != LOCATED]
            records[left] = np.nan
            ensemble.status[left // count] = Status.INTERRUPTED
        states = records[:, RECORD.state :].reshape(orbits, count, rows).transpose(1, 2, 0)
        states[:, self.row] += levels[:, None]
        whole = (passed == count) & np.isfinite(states[-1]).all(axis=0)
        ensemble.z[:, whole] = states[-1][:, whole]
        ensemble.time[:] = np.where(whole, self.model.time, ensemble.z[self.row] * self.model.time)
        return np.array([lowered(state) for state in states]).reshape(count, rows - 2, orbits), interrupted


def prepared(
    time: float,
    system: System,
    z: np.ndarray,
    scheme: TimeTransformed,
    step: float | None,
    threads: int,
    error: float = 1e-11,
) -> tuple[TransformedFlow, float, float]:
    """Return the flow with rate and step, by trial where they are missing; its largest energy error in the trial and
    its force evaluations per unit time.

    For each rate, steps shrink until the largest energy error of a sample of orbits is below `error`. The result has
    the rate with the fewest evaluations per unit time, or that of least error if all errors are larger.
    """
    _check_rate(system, scheme, z)
    if scheme.rate is not None and step is not None:
        pace = float(np.median(scheme.rate.at(system.potential_energies(z))))
        return _flow(time, system, scheme, step, pace, threads), math.nan, math.nan
    sample = sample_of(system, z, 20, time, threads)
    rate, bottom, top = survey(sample)
    best: tuple[TransformedFlow, float, float] | None = None
    for transformed in [scheme] if scheme.rate is not None else [replace(scheme, rate=r) for r in rates(bottom, top)]:
        k = 0
        while k < sample.most:
            found = _tried(transformed, step or trial_step(k, rate), sample)
            if best is None or _rank(found, error) < _rank(best, error):
                best = found
            if step is not None or found[1] <= error or (best[1] <= error and found[2] >= best[2]):
                break
            k = following_step(k, found[1], error, transformed.splitting.order)
    flow, worst, cost = best  # type: ignore[misc]
    return _flow(time, system, flow.scheme, flow.step, flow.pace, threads), worst, cost


def _rank(found: tuple[TransformedFlow, float, float], error: float) -> tuple[bool, float]:
    """Return a sort key of trials: those below the error by cost, then the others by error."""
    _, worst, cost = found
    return (False, cost) if worst <= error else (True, worst)


def _check_rate(system: System, scheme: TimeTransformed, z: np.ndarray) -> None:
    """Raise ValueError unless the rate is a positive number at the starts."""
    if scheme.rate is None:
        return
    V = system.potential_energies(z)
    try:
        with np.errstate(all="ignore"):
            g = np.asarray(scheme.rate.at(V), dtype=np.float64)
        if g.shape != V.shape:
            raise ValueError(f"shape {g.shape} for V of shape {V.shape}")
    except Exception as problem:
        raise TypeError(
            f"rate {shown(scheme.rate)} must be arithmetic of V that takes arrays; at(V) fails: {problem}"
        ) from problem
    if not (np.all(np.isfinite(g)) and g.min() > 1e-12 and g.max() < 1e12):
        raise ValueError(
            f"rate {shown(scheme.rate)} must be near 1 at the initial conditions, got {g.min():.3g} to {g.max():.3g}. "
            "Try an origin nearer to V there."
        )


def _flow(
    time: float,
    system: System,
    scheme: TimeTransformed,
    step: float,
    pace: float,
    threads: int,
    patience: int = PATIENCE,
) -> TransformedFlow:
    """Return the flow of a scheme whose rate and step are known."""
    extended = transformed_model(system.model, scheme.rate, time)
    step = min(step, time / pace)  # tau = t/time must not overshoot 1 by orders of magnitude
    flow = Flow(system_of(extended), scheme.splitting, step, 1e-12, 1e-12, threads)
    return TransformedFlow(system, flow, scheme, pace, patience)


def _tried(scheme: TimeTransformed, step: float, sample: Sample) -> tuple[TransformedFlow, float, float]:
    """Run the sample; return the flow with its pace, the largest energy error and force evaluations per unit time."""
    time = sample.span * sample.rounds
    flow = _flow(time, sample.system, scheme, step, 1.0, sample.threads, 100)
    ensemble = flow.ensemble(sample.z)
    states, interrupted = flow.trajectory(ensemble, time, sample.rounds, None)
    if interrupted:
        raise KeyboardInterrupt
    if np.any(ensemble.status != Status.OK):
        return flow, math.inf, math.inf
    worst = max(float(energy_drift(flow.original, state, ensemble.energy, ensemble.scale).max()) for state in states)
    pace = float(ensemble.time.sum() / (ensemble.count.sum() * step))
    return replace(flow, pace=pace, patience=PATIENCE), worst, scheme.stages / (step * pace)


def survey(sample: Sample) -> tuple[float, float, float]:
    """Return the typical angular frequency, the lowest potential and the highest energy of orbits over a round of some
    librations. States that have escaped are left out: no other orbit reaches such depths.
    """
    system = sample.system
    z = sample.z
    flow = Flow(system, DOP853, math.inf, 1e-9, 1e-9, sample.threads)
    ensemble = flow.ensemble(z.copy())
    states = flow.sampled(ensemble, LOOKS, time=sample.span).reshape(-1, len(z)).T
    states = np.concatenate([z, states[:, np.isfinite(states).all(axis=0)]], axis=1)
    V = system.potential_energies(states)
    return typical_rate(system, states), float(np.nanmin(V)), float(np.max(ensemble.energy))


def rates(bottom: float, top: float) -> Iterable[Any]:
    """Return rates to try for orbits whose potential goes from `bottom` to `top`."""
    height = top - bottom if top > bottom else 1.0
    for share in (0.15, 0.19, 0.25, 0.5):
        for level in (0.25, 0.375):
            yield Logistic(height * share, bottom + height * level)
    for share, exponent in ((0.125, 1.0), (0.125, 1.5), (0.25, 2.0)):
        yield Algebraic(height * share, bottom, exponent)
