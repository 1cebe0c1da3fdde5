"""Trials: steps for each orbit by itself, and runs of candidate schemes on a sample."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..core.status import Status
from ..systems.models.mechanics import System
from . import observers
from .flow import Flow, no_memory
from .requirements import energy_drift
from .scales import MotionScales, typical_rate
from .schemes.automatic import TRIAL_ORBITS, Automatic, CandidateTrial, spread, trial_rounds
from .schemes.catalogue import DOP853, Nystrom, RungeKutta, Splitting

SPAN = 16.0
"""Radians of each orbit's motion over which trial steps are compared."""

SAMPLES = 4
"""Number of moments of comparison."""

PACED = 4 * SPAN
"""Most radians of the pace over which they are compared: a slow orbit under a fast drive would take any number of
steps, and a chaotic one would forget its start.
"""

MEASURABLE = 3e-12
"""Least error over SPAN that a trial measures above rounding; smaller ones follow from the order."""

FIRST = 0.25
"""The first step of trials, in radians."""

COARSEST = 1.2
"""The longest step of trials, in radians."""

FINEST = 1.5e-3
"""The shortest step of trials, in radians."""

COMPARABLE = 1e-2
"""Errors of trials below which they show the order at which they fall."""

LADDER = 4
"""Numbers of steps are q 2^k with q from LADDER to 2 LADDER. Orbits of similar steps share blocks, and large numbers
have a large power of two as a divisor, after which slowed runs pause.
"""

STEPS = 14
"""Most steps that are tried for a set of orbits."""

TRIALS = 8
"""Most steps that are tried for an orbit."""

STALLS = 2
"""Trials end after so many shorter steps whose errors have not fallen in proportion: the errors are rounding then,
which a chaotic orbit amplifies and no step reduces.
"""


def round_down_to_grid(step: np.ndarray, time: Any, parts: int = 1) -> np.ndarray:
    """Return steps time/(parts*N), at most as long as the given ones, with N from 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14,
    16, 20, ...
    """
    least = np.maximum(time / (parts * step) * (1 - 1e-12), 1.0)
    unit = np.maximum(2.0 ** (np.floor(np.log2(least))) / LADDER, 1.0)
    return time / (parts * unit * np.ceil(least / unit))


class Chosen(NamedTuple):
    """Steps for orbits: step (orbits,), the error of each over SPAN radians, and the order at which errors fall
    there.
    """

    step: np.ndarray
    error: np.ndarray
    order: np.ndarray


def chosen_steps(flow: Flow, z: np.ndarray, found: MotionScales, error: np.ndarray) -> Chosen:
    """Return for each orbit (orbits,) the step whose error over SPAN radians of its motion is `error`.

    The error of a step is the distance from the states with half of it, in units of the motion's amplitudes
    (`MotionScales`). Steps are tried until one is near, over a shorter time where the pace is much faster; errors
    below MEASURABLE follow from the order. If no step down to FINEST radians reaches it, the step is FINEST; if
    shorter ones no longer help, it is the one before them. The order is the scheme's, or a lower one that two trials
    show: steps may be too coarse for the former, or forces not smooth. Every orbit is treated by itself. Cost: some
    500 steps an orbit.
    """
    orbits = z.shape[1]
    rate = found.rate
    pace = found.pace
    first = 2 * FIRST if isinstance(flow.scheme, Nystrom) else FIRST  # of order 12, whose steps are longer
    step = first / pace
    least = np.full(orbits, np.nan)
    order = np.full(orbits, float(flow.scheme.order))
    coarse, most = np.full((2, orbits), np.nan)
    at = step.copy()
    floor = np.full(orbits, np.inf)
    stalls = np.zeros(orbits, np.int64)
    share = np.minimum(1.0, PACED / SPAN * rate / pace)
    error = error * share
    wanted = np.maximum(error, MEASURABLE)
    todo = np.arange(orbits)
    for _ in range(TRIALS):
        apart = halving(flow, z[:, todo], step[todo], share[todo] * SPAN / rate[todo], found.of(todo))
        least[todo] = apart
        with np.errstate(all="ignore"):
            fell = ~(apart * at[todo] >= floor[todo] * step[todo])
        stalls[todo] += ~fell & (step[todo] < at[todo]) & (apart < COMPARABLE)
        at[todo], floor[todo] = np.where(fell, (step[todo], apart), (at[todo], floor[todo]))
        with np.errstate(all="ignore"):
            seen = np.log(most[todo] / apart) / np.log(coarse[todo] / step[todo])
        told = coarse[todo] > np.sqrt(2) * step[todo]
        order[todo] = np.where(told & (seen < flow.scheme.order), np.maximum(seen, 1.0), flow.scheme.order)
        wider = (apart < COMPARABLE) & ~(step[todo] < coarse[todo])
        coarse[todo], most[todo] = np.where(wider, (step[todo], apart), (coarse[todo], most[todo]))
        with np.errstate(all="ignore"):
            change = _change(wanted[todo] / np.maximum(apart, 1e-14), order[todo], flow.scheme.order)
        change = np.where(np.isfinite(apart), change, 0.0)
        following = np.clip(step[todo] * np.clip(change, 0.25, 3.0), FINEST / pace[todo], COARSEST / pace[todo])
        near = (change >= 0.6) & (change <= 1.6) | (following == step[todo]) | (stalls[todo] == STALLS)
        step[todo] = np.where(near, step[todo], following)
        todo = todo[~near]
        if not todo.size:
            break
    stalled = stalls == STALLS
    step, least = np.where(stalled, (at, floor), (step, least))
    known = np.maximum(np.where(np.isfinite(least), least, 1.0), 1e-14)
    change = np.where(stalled, 1.0, np.clip(_change(error / known, order, flow.scheme.order), 0.1, 1.6))
    last = np.clip(step * change, FINEST / pace, COARSEST / pace)
    return Chosen(last, known * (last / step) ** order / share, order)


def _change(gain: np.ndarray, order: np.ndarray, most: int) -> np.ndarray:
    """Return the factor of the step whose error is `gain` times as large: by the order seen if it becomes shorter, by
    the scheme's if it becomes longer.
    """
    return gain ** (1 / np.where(gain > 1, most, order))


def sampled(flow: Flow, z: np.ndarray, step: np.ndarray, time: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return states (SAMPLES, rows, orbits) with each orbit's step at equal intervals of its time, NaN where none."""
    tried = replace(flow, step=step)
    return tried.sampled(tried.ensemble(z.copy(), radius=radius), SAMPLES, time=time).transpose(1, 2, 0)


def halving(flow: Flow, z: np.ndarray, step: np.ndarray, time: np.ndarray, found: MotionScales) -> np.ndarray:
    """Return the largest distance between states with each orbit's step and with half of it, at SAMPLES moments; inf
    where none.
    """
    orbits = z.shape[1]
    states = sampled(flow, np.tile(z, 2), np.concatenate([step, step / 2]), np.tile(time, 2), np.tile(found.radius, 2))
    apart = found.between(states[..., :orbits], states[..., orbits:], flow.threads)
    known = np.isfinite(apart)
    return np.where(known[0], np.where(known, apart, 0.0).max(axis=0), np.inf)


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
    span = radians / typical_rate(system, z)
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
