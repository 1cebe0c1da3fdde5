"""Indicators of chaos that make passes of their own over the orbits. Each returns its values, what these are judged by
(NaN where that is a limit alone), and statuses (orbits,).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...base.status import Status
from ...flows import observers
from ...flows.flow import Flow, Report, no_memory
from ...flows.motion import motion
from ..frequencies.frequencies import FrequencyKind
from ..frequencies.frequency_map import FrequencyWork, checked_angles
from ..frequencies.map_frequencies import map_frequencies_of
from ..frequencies.turning import CHANGED
from .indicators import FrequencyDiffusion, ReversibilityError, ZeroOne
from .translations import median_correlation, sampling


def frequency_diffusion(
    indicator: FrequencyDiffusion, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray | float, np.ndarray]:
    """Return log10 of the change of the frequencies between the halves of the run, in cycles per natural period; NaN
    where it says nothing: lines that are close change the halves of regular orbits, too.
    """
    if flow.exact:
        found = map_frequencies_of(flow, z0, int(time))
        value = found.diffusion + np.log10(2 * math.pi)
        return np.where(found.status == Status.OK, value, np.nan), np.nan, found.status
    work = FrequencyWork(flow, checked_angles(indicator.angles, flow.model), z0, time, None, None, report)
    work.run()
    found = work.result()
    value = found.diffusion - np.log10(rates / (2 * math.pi))
    moving = np.any(found.halves != 0, axis=(0, 1))
    vague = (found.kind == FrequencyKind.UNDECIDED) & moving
    beside = (found.kind != FrequencyKind.IRREGULAR) & (time / 2 * 10.0**found.diffusion > CHANGED)
    known = (found.status == Status.OK) & ~vague & ~beside
    return np.where(known, value, np.nan), np.nan, found.status


def zero_one(
    indicator: ZeroOne, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray | float, np.ndarray]:
    """Return the median correlation K of the 0-1 test on equidistant samples of the kinetic energy, for an adaptive
    scheme.
    """
    chosen = sampling(indicator, flow, time, rates)
    ensemble, observer = flow.ensemble(z0.copy()), observers.kinetic_samples(flow.model, 0)
    memory, out = np.zeros((observer.rows, rates.size)), np.zeros((rates.size, chosen.columns))
    chosen.prepare(memory)
    flow.advance(ensemble, observer, memory, out, time=time, observations=int(chosen.seen), report=report)
    found = median_correlation(out, chosen.counts, flow.threads, report)
    return np.where(ensemble.status == Status.OK, found, np.nan), chosen.quiet, ensemble.status


def reversibility_error(
    indicator: ReversibilityError, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray | float, np.ndarray]:
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
    return np.where(back.status == Status.OK, value, np.nan), np.nan, back.status


def _advance(flow: Flow, ensemble: Any, time: float, report: Report | None) -> None:
    flow.advance(ensemble, observers.nothing(), *no_memory(ensemble), time=time, observations=1, report=report)
