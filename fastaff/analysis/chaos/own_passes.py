"""Indicators of chaos that make passes of their own over the orbits. Each returns its values and statuses (orbits,)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...base.numbers import fits
from ...base.status import Status
from ...flows import observers
from ...flows.flow import Flow, Report, launch, no_memory
from ...flows.motion import motion
from ...kernels import zero_one as kernels
from ...kernels.samples import ROWS
from ..frequencies.frequency_map import FALLBACK, FrequencyWork, checked_angles
from .indicators import FrequencyDiffusion, ReversibilityError, ZeroOne

ANGLES = 100
"""Angles c of the 0-1 test, random in (pi/5, 4 pi/5): away from the resonances with the sampling."""

LEAST_SAMPLES, MOST_SAMPLES = 400, 4000
"""Samples of the 0-1 test where none are asked for."""


def frequency_diffusion(
    indicator: FrequencyDiffusion, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return log10 of the change of the frequencies between the halves of the run, in cycles per natural period."""
    work = FrequencyWork(flow, checked_angles(indicator.angles, flow.model), z0, time, None, FALLBACK, report)
    work.run()
    found = work.result()
    value = found.diffusion - np.log10(rates / (2 * math.pi))
    return np.where(found.status == Status.OK, value, np.nan), found.status


def zero_one(
    indicator: ZeroOne, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the median correlation K of the 0-1 test on samples of the kinetic energy, at some of each orbit's
    steps.
    """
    orbits = z0.shape[1]
    wanted = (
        np.clip(0.8 * time * rates, LEAST_SAMPLES, MOST_SAMPLES)
        if indicator.samples is None
        else np.full(orbits, indicator.samples)
    )
    seen = max(MOST_SAMPLES, indicator.samples or 0) if flow.adaptive else flow.steps(time)
    stride = np.maximum(1, seen // wanted)
    counts = np.minimum(wanted, seen // stride).astype(np.int64)
    fits("ZeroOne.samples", orbits, int(counts.max()))
    ensemble, observer = flow.ensemble(z0.copy()), observers.kinetic_samples(flow.model)
    memory, out = np.zeros((observer.rows, orbits)), np.zeros((orbits, counts.max()))
    memory[ROWS.stride] = stride
    flow.advance(
        ensemble, observer, memory, out, time=time, observations=int(seen) if flow.adaptive else 0, report=report
    )
    angles = math.pi * (0.2 + 0.6 * np.random.default_rng(1).random(ANGLES))
    turns = angles[:, None] * np.arange(1, counts.max() + 1)
    stop, progress, result = np.zeros(1, np.int64), np.zeros(orbits, np.int64), np.full(orbits, np.nan)
    launch(
        kernels.zero_one,
        (out, counts, angles, np.cos(turns), np.sin(turns), result),
        stop,
        progress,
        float(orbits),
        flow.threads,
        report,
    )
    return np.where(ensemble.status == Status.OK, result, np.nan), ensemble.status


def reversibility_error(
    indicator: ReversibilityError, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return log10 of the distance from the start, in amplitudes of the motion, after going to `time` and coming
    back.
    """
    n = flow.model.degrees_of_freedom
    there = flow.ensemble(z0.copy())
    _advance(flow, there, time, report)
    back = flow.ensemble(there.z * np.repeat([1.0, -1.0], n)[:, None])
    back.status[:] = there.status
    _advance(flow, back, time, report)
    away = back.z * np.repeat([1.0, -1.0], n)[:, None] - z0
    with np.errstate(all="ignore"):
        value = np.log10(np.maximum(motion(flow.model, z0, flow.threads).distance(away), 1e-17))
    return np.where(back.status == Status.OK, value, np.nan), back.status


def _advance(flow: Flow, ensemble: Any, time: float, report: Report | None) -> None:
    flow.advance(ensemble, observers.nothing(), *no_memory(ensemble), time=time, observations=1, report=report)
