"""Integrate orbits (layer L3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import observers
from .auto import Automatic
from .boundary import energy_drift
from .engine import Ensemble, Flow, Interrupted, Report, energy_error, mark_drift, no_memory
from .scalars import positive, whole
from .schemes import KAHAN_LI8, RungeKutta, Splitting
from .status import Status, describe, raise_if_failed
from .transformed import TimeTransformed, lowered
from .transformed_flow import TransformedFlow, flow_over


@dataclass(frozen=True)
class Orbits:
    """End states, samples and outcomes of integrated orbits.

    z (2n, orbits) at time `t` (orbits,), which is the asked time for orbits that finished; times (samples,);
    samples (samples, 2n, orbits); energy_error (orbits,) = |E - E0|/(T0 + |V0|), the largest over the samples and the end;
    status (orbits,) of `Status`; step: the fixed step (in its own time for a `TimeTransformed` scheme, whose rate the scheme
    holds), or inf for an adaptive scheme.
    """

    z: np.ndarray
    t: np.ndarray
    times: np.ndarray
    samples: np.ndarray
    energy_error: np.ndarray
    status: np.ndarray
    scheme: Splitting | RungeKutta | TimeTransformed
    step: float

    def raise_if_failed(self) -> None:
        """Raise OrbitError unless every orbit is OK."""
        raise_if_failed(self.status)

    def summary(self) -> str:
        """Say in one line what became of the orbits."""
        return describe(self.status)


def integrate(
    body: Any, z0: Any, *, time: float, step: float | None = None,
    scheme: Splitting | RungeKutta | TimeTransformed | Automatic = KAHAN_LI8, samples: int = 0, rtol: float = 1e-12,
    atol: float = 1e-12, energy_tolerance: float = 1e-6, threads: int | None = None, report: Report | None = None,
) -> Orbits:  # fmt: skip
    """Integrate orbits of `body` from `z0` over `time`.

    Parameters: z0 (2n,) or (2n, orbits); time > 0; step > 0, the longest fixed step (the step used divides the time between
    samples; chosen by a short trial for an energy error of 1e-11 where it is None), or the first step of an adaptive
    scheme, or of `TimeTransformed` one in its own time; scheme: a splitting, a Runge-Kutta scheme, `TimeTransformed` for steep walls
    or AUTO, which chooses; samples: number of equidistant samples in (0, time]; rtol, atol: tolerances of an adaptive scheme;
    energy_tolerance: energy error above which an orbit's status is ENERGY_DRIFT; threads; report(fraction).
    Returns Orbits, whose scheme and step are those that were chosen. Raises ValueError or TypeError for wrong input; Interrupted
    on Ctrl-C, with `.partial`.

    Accuracy: the scheme's order; a splitting's energy error does not grow with time. Cost: stages forces per step; an orbit
    of an adaptive scheme takes steps of its own and its lane is refilled when it ends. Memory: that of z0 and the samples.
    Source: Hairer, Lubich & Wanner 2006, Geometric Numerical Integration; each scheme names its own.
    """
    time = positive("time", time)
    count = whole("samples", samples, 0)
    tolerance = positive("energy_tolerance", energy_tolerance)
    flow, z = flow_over(time, body, z0, scheme, step, rtol, atol, threads)
    ensemble = flow.ensemble(z)
    if isinstance(flow, Flow):
        kept, interrupted = _sampled_in_time(flow, ensemble, time, count, report)
    else:
        kept, interrupted = _sampled_in_fictitious_time(flow, ensemble, count, report)
    if interrupted:
        ensemble.status[(ensemble.status == Status.OK) & (ensemble.time < time * (1 - 1e-12))] = Status.INTERRUPTED
    error = energy_error(body, ensemble)
    for block in kept:
        seen = np.isfinite(block).all(axis=0)
        error = np.where(seen, np.maximum(error, energy_drift(body, block, ensemble.energy, ensemble.scale)), error)
    mark_drift(ensemble, error, tolerance)
    times = time / count * np.arange(1, count + 1) if count else np.zeros(0)
    result = Orbits(ensemble.z, ensemble.time, times, kept, error, ensemble.status, flow.scheme, flow.step)
    if interrupted:
        stopped = Interrupted("integrate")
        stopped.partial = result
        raise stopped
    return result


def _sampled_in_time(flow: Flow, ensemble: Ensemble, time: float, count: int, report: Report | None) -> tuple[np.ndarray, bool]:
    """Run to the end; return the samples (count, 2n, orbits), NaN where not reached, and whether it was interrupted."""
    rows, orbits = ensemble.z.shape
    observer, (memory, out) = observers.nothing(), no_memory(ensemble)
    if count:
        observer = observers.samples(rows)
        memory, out = np.zeros((observer.rows, orbits)), np.full((orbits, count * rows), np.nan)
    interrupted = False
    try:
        flow.advance(ensemble, observer, memory, out, time=time, observations=max(count, 1), report=report)
    except KeyboardInterrupt:
        interrupted = True
    return out.reshape(orbits, count, rows).transpose(1, 2, 0) if count else np.zeros((0, rows, orbits)), interrupted


def _sampled_in_fictitious_time(
    flow: TransformedFlow, ensemble: Ensemble, count: int, report: Report | None
) -> tuple[np.ndarray, bool]:
    """Do the same with a time-transformed scheme; the ensemble's states lose time and energy."""
    states, interrupted = flow.sample(ensemble, max(count, 1), report)
    ensemble.z = lowered(ensemble.z)
    return np.array([lowered(state) for state in states[:count]]).reshape(count, *ensemble.z.shape), interrupted
