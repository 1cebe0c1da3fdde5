"""Trials of candidate schemes on a sample of the orbits."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..core.status import Status
from ..systems.models.mechanics import System
from . import observers
from .flow import Flow, no_memory
from .requirements import energy_drift
from .scales import fastest_rates, typical_rate
from .schemes.automatic import TRIAL_ORBITS, Automatic, CandidateTrial, spread, trial_rounds
from .schemes.catalogue import DOP853, RungeKutta, Splitting

STEPS = 14
"""Most steps that are tried for a set of orbits."""


THROWN_OUT = 1 / 16
"""Part of the fastest rate at the starts below which the natural rate is that of a way out, after a close approach: a
round of its radians would last for many runs.
"""


class Sample(NamedTuple):
    """Orbits for trials of schemes: z (2n, orbits), the `span` of time of a round, the number of rounds, and the most
    steps that are tried.
    """

    system: System
    z: np.ndarray
    span: float
    rounds: int
    most: int
    threads: int


def sample_of(system: System, z: np.ndarray, radians: float, time: float | None, threads: int) -> Sample:
    """Return a sample of orbits that stay in the domain, with rounds of that many radians, for a run over `time`.

    An orbit that escapes or collapses is no test of a scheme: no step would conserve its energy. If all do, they are
    returned, for a trial of one step.
    """
    z = spread(z, TRIAL_ORBITS)
    rate = typical_rate(system, z)
    span = radians / rate
    if time is not None and span > time and rate < THROWN_OUT * float(np.median(fastest_rates(system, z, np.inf))):
        span = time
    rounds = trial_rounds(z, span, time)
    flow = Flow(system, DOP853, math.inf, 1e-9, 1e-9, threads)
    ensemble = flow.ensemble(z.copy())
    flow.advance(ensemble, observers.nothing(), *no_memory(ensemble), time=1.25 * (span * rounds))
    stays = ensemble.status == Status.OK
    z, most = (np.ascontiguousarray(z[:, stays]), STEPS) if stays.any() else (z, 1)
    return Sample(system, z, span, rounds, most, threads)


def trials_in_time(
    system: System, z: np.ndarray, scheme: Automatic, rtol: float, atol: float, threads: int, time: float | None
) -> list[CandidateTrial]:
    """Try the candidates that step in time itself on a sample of orbits, for 60/omega at a time.

    The error of an adaptive scheme is extended in proportion to a run over `time`.
    """
    sample = sample_of(system, z, 60, time, threads)
    tried = []
    for candidate in scheme.candidates:
        if not isinstance(candidate, (Splitting, RungeKutta)):
            continue
        flow = Flow(system, candidate, math.inf, rtol, atol, threads)
        if flow.adaptive:
            worst, steps = _run_trial(flow, sample)
            worst *= max(1.0, (time or sample.span) / (sample.span * sample.rounds))
        else:
            flow, worst = try_steps(flow, sample, scheme.bound)
            steps = sample.span / float(flow.step)
        tried.append(CandidateTrial(candidate, float(flow.step), worst, steps * candidate.evaluations / sample.span))
    return tried


def try_steps(flow: Flow, sample: Sample, error: float) -> tuple[Flow, float]:
    """Return the flow with the longest `trial_step` below the error, and the largest of its energy errors.

    The errors are those at the ends of rounds; if no step is below the error, it is the one of least error.
    """
    best = math.inf
    least = math.inf
    k = 0
    rate = max(typical_rate(flow.system, sample.z), flow.system.drive_rate)
    while k < sample.most:
        step = trial_step(k, rate)
        worst, _ = _run_trial(replace(flow, step=step), sample)
        if worst < least:
            best = step
            least = worst
        if worst <= error:
            break
        k = following_step(k, worst, error, flow.scheme.order)
    return replace(flow, step=best if math.isfinite(best) else 1e-3), least


def trial_step(k: int, rate: float) -> float:
    """Return the k-th of the steps that are tried for a set of orbits of that angular frequency: 0.4/(2^(k/2) rate)."""
    return 0.4 / (rate * 2 ** (k / 2))


def following_step(k: int, worst: float, error: float, order: int) -> int:
    """Return the number of the step to try after the k-th gave the error `worst`: one before the step that should reach
    `error` by the order.
    """
    ahead = 2 * math.log2(worst / error) / order if math.isfinite(worst) else 0.0
    return k + max(1, int(ahead) - 1)


def _run_trial(flow: Flow, sample: Sample) -> tuple[float, float]:
    """Return the largest of the energy errors at the ends of rounds, and the mean number of steps in one."""
    energy = flow.system.energies(sample.z)
    z = sample.z
    errors = []
    steps = 0.0
    kinetic = np.zeros(z.shape[1])
    for _ in range(sample.rounds):
        ensemble = flow.ensemble(z.copy())
        np.maximum(ensemble.kinetic, kinetic, out=ensemble.kinetic)
        flow.advance(
            ensemble,
            observers.nothing(),
            *no_memory(ensemble),
            time=sample.span,
            observations=0 if flow.adaptive else 1,
        )
        drift = energy_drift(flow.system, ensemble.z, energy, ensemble.scale)
        kinetic = ensemble.kinetic
        errors.append(np.where(ensemble.status == Status.OK, drift, np.inf))
        z = ensemble.z
        steps = steps + float(ensemble.count.mean())
        if not np.isfinite(errors[-1]).all():
            break
    return float(np.max(errors)), steps / sample.rounds
