"""What indicators of chaos take besides tangent vectors: observers in the same pass, and passes of their own over the
orbits, each of which returns values, what they are compared with (NaN where that is a limit alone), and statuses.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...base.numbers import fits
from ...base.status import Status
from ...flows import observers
from ...flows.flow import Flow, no_memory
from ...flows.launch import Report, launch, units
from ...flows.motion import motion
from ...kernels import birkhoff
from ...kernels import zero_one as correlations
from ...kernels.samples import ROWS
from ..frequencies.frequencies import FrequencyKind
from ..frequencies.frequency_map import FrequencyWork, checked_angles
from ..frequencies.map_frequencies import map_frequencies_of
from ..frequencies.turning import CHANGED

ANGLES = 100
"""Angles c of the 0-1 test, random in (pi/5, 4 pi/5): away from the resonances with the sampling."""

QUIET, DENSE = 50.0, 0.5
"""Correlation times samples below which an orbit may be regular: most regular ones have less, of the chaotic ones of
Henon and Heiles at the energy 1/8 one in a hundred; and the radians of its natural frequency between samples that this
takes: the angles of denser ones belong to frequencies beyond those of the motion."""

LEAST_SAMPLES, MOST_SAMPLES = 400, 4000
"""Samples of the 0-1 test where none are asked for."""


class Watch(NamedTuple):
    """An observer of the pass of tangent vectors, with `columns` numbers of an orbit in `out`.

    prepare(memory) sets rows of its memory (rows, orbits); read(memory, time) returns the values (orbits,) and what
    they are compared with, of orbits that have come to `time` (orbits,); finish(out, report), of values that take long,
    returns them after the pass.
    """

    observer: observers.Observer
    columns: int
    prepare: Callable[[np.ndarray], None]
    read: Callable[[np.ndarray, np.ndarray], tuple[Any, Any]]
    finish: Callable[[np.ndarray, Report | None], np.ndarray] | None = None


def kinetic_averages(flow: Flow, time: float) -> Watch:
    """Watch digits to which averages of the squared kinetic energy over both halves of the time agree."""

    def read(memory: np.ndarray, reached: np.ndarray) -> tuple[np.ndarray, float]:
        rows = birkhoff.ROWS
        with np.errstate(all="ignore"):
            a, b = memory[rows.early] / memory[rows.early_weight], memory[rows.late] / memory[rows.late_weight]
            digits = -np.log10(np.where(a == b, 0.0, np.abs(a - b) / np.maximum(np.abs(a), np.abs(b))) + 1e-17)
        return np.where(reached >= time * (1 - 1e-12), digits, np.nan), np.nan

    return Watch(observers.averages(flow.model, flow.vectors, time), 0, lambda memory: None, read)


def median_correlation(samples: np.ndarray, counts: np.ndarray, threads: int, report: Report | None) -> np.ndarray:
    """Return K (orbits,) of the 0-1 test on samples (orbits, columns), the first `counts` of each row."""
    orbits = len(samples)
    angles = math.pi * (0.2 + 0.6 * np.random.default_rng(1).random(ANGLES))
    cosine = np.cos(np.arange(counts.max() // 10)[:, None] * angles)
    result = np.full(orbits, np.nan)
    launch(correlations.zero_one, (samples, counts, cosine, result), units(orbits, 1), float(orbits), threads, report)
    return result


def kinetic_samples(samples: int | None, flow: Flow, time: float, rates: np.ndarray) -> Watch:
    """Watch the kinetic energy at some of each orbit's steps, or at some of equidistant states where the scheme is
    adaptive, for the median correlation K of the 0-1 test; compared: the correlation below which an orbit may be
    regular.
    """
    most = np.clip(0.8 * time * rates, LEAST_SAMPLES, MOST_SAMPLES)
    wanted = most if samples is None else np.full(rates.size, samples)
    seen = _equidistant(samples) if flow.adaptive else flow.steps(time)
    stride = np.maximum(1, seen // wanted)
    counts = np.minimum(wanted, seen // stride).astype(np.int64)
    fits("ZeroOne.samples", rates.size, int(counts.max()))
    sparse = flow.traits.iterated | (time * rates * stride / seen > DENSE)
    quiet = np.where(sparse, QUIET / counts, 0.0)

    def prepare(memory: np.ndarray) -> None:
        memory[ROWS.stride] = memory[ROWS.left] = stride

    def finish(out: np.ndarray, report: Report | None) -> np.ndarray:
        return median_correlation(out, counts, flow.threads, report)

    observer = observers.kinetic_samples(flow.model, flow.vectors)
    return Watch(observer, int(counts.max()), prepare, lambda memory, reached: (np.nan, quiet), finish)


def _equidistant(samples: int | None) -> int:
    """Return how many states an adaptive scheme shows to the 0-1 test."""
    return max(MOST_SAMPLES, samples or 0)


def zero_one(
    samples: int | None, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the median correlation K of the 0-1 test on equidistant samples, for an adaptive scheme."""
    watch, ensemble = kinetic_samples(samples, flow, time, rates), flow.ensemble(z0.copy())
    memory, out = np.zeros((watch.observer.rows, rates.size)), np.zeros((rates.size, watch.columns))
    watch.prepare(memory)
    flow.advance(ensemble, watch.observer, memory, out, time=time, observations=_equidistant(samples), report=report)
    found, (_, quiet) = watch.finish(out, report), watch.read(memory, ensemble.time)  # type: ignore[misc]
    return np.where(ensemble.status == Status.OK, found, np.nan), quiet, ensemble.status


def frequency_diffusion(
    angles: Any, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, report: Report | None
) -> tuple[np.ndarray, np.ndarray | float, np.ndarray]:
    """Return log10 of the change of the frequencies between the halves of the run, in cycles per natural period; NaN
    where it says nothing: lines that are close change the halves of regular orbits, too.
    """
    if flow.traits.iterated:
        found = map_frequencies_of(flow, z0, int(time))
        value = found.diffusion + np.log10(2 * math.pi)
        return np.where(found.status == Status.OK, value, np.nan), np.nan, found.status
    work = FrequencyWork(flow, checked_angles(angles, flow.model), z0, time, None, None, report)
    work.run()
    found = work.result()
    value = found.diffusion - np.log10(rates / (2 * math.pi))
    moving = np.any(found.halves != 0, axis=(0, 1))
    vague = (found.kind == FrequencyKind.UNDECIDED) & moving
    beside = (found.kind != FrequencyKind.IRREGULAR) & (time / 2 * 10.0**found.diffusion > CHANGED)
    known = (found.status == Status.OK) & ~vague & ~beside
    return np.where(known, value, np.nan), np.nan, found.status


def reversibility_error(
    flow: Flow, z0: np.ndarray, time: float, report: Report | None
) -> tuple[np.ndarray, float, np.ndarray]:
    """Return log10 of the distance from the start, in amplitudes of the motion, after going to `time` and coming
    back.
    """
    momenta_turned = np.repeat([1.0, -1.0], flow.model.degrees_of_freedom)[:, None]
    there = flow.ensemble(z0.copy())
    _advance(flow, there, time, report)
    back = flow.ensemble(there.z * momenta_turned)
    back.status[:] = there.status
    _advance(flow, back, time, report)
    with np.errstate(all="ignore"):
        away = motion(flow.model, z0, flow.threads).distance(back.z * momenta_turned - z0)
        value = np.log10(np.maximum(away, 1e-17))
    return np.where(back.status == Status.OK, value, np.nan), np.nan, back.status


def _advance(flow: Flow, ensemble: Any, time: float, report: Report | None) -> None:
    flow.advance(ensemble, observers.nothing(), *no_memory(ensemble), time=time, observations=1, report=report)
