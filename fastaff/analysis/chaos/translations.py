"""The 0-1 test for chaos: which samples it takes of orbits, and what they say."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...base.numbers import fits
from ...flows.flow import Flow, Report, launch
from ...kernels import zero_one as kernels
from ...kernels.samples import ROWS
from .indicators import ZeroOne

ANGLES = 100
"""Angles c of the 0-1 test, random in (pi/5, 4 pi/5): away from the resonances with the sampling."""

QUIET, DENSE = 50.0, 0.5
"""Correlation times samples below which an orbit may be regular: most regular ones have less, of the chaotic ones of
Henon and Heiles at the energy 1/8 one in a hundred; and the radians of its natural frequency between samples that this
takes: the angles of denser ones belong to frequencies beyond those of the motion."""

LEAST_SAMPLES, MOST_SAMPLES = 400, 4000
"""Samples of the 0-1 test where none are asked for."""


class Sampling(NamedTuple):
    """Samples of the 0-1 test: `counts` (orbits,), one after `stride` (orbits,) of `seen` observations; quiet
    (orbits,): the correlation below which an orbit may be regular.
    """

    stride: np.ndarray
    counts: np.ndarray
    seen: int | np.ndarray
    quiet: np.ndarray

    @property
    def columns(self) -> int:
        """The most that an orbit has."""
        return int(self.counts.max())

    def prepare(self, memory: np.ndarray) -> None:
        """Set the rows (rows, orbits) of the observer's memory that it needs."""
        memory[ROWS.stride] = memory[ROWS.left] = self.stride


def sampling(indicator: ZeroOne, flow: Flow, time: float, rates: np.ndarray) -> Sampling:
    """Return what samples the 0-1 test takes of orbits of such natural frequencies: some of each orbit's steps, or
    equidistant states where the scheme is adaptive.
    """
    wanted = (
        np.clip(0.8 * time * rates, LEAST_SAMPLES, MOST_SAMPLES)
        if indicator.samples is None
        else np.full(rates.size, indicator.samples)
    )
    seen = max(MOST_SAMPLES, indicator.samples or 0) if flow.adaptive else flow.steps(time)
    stride = np.maximum(1, seen // wanted)
    counts = np.minimum(wanted, seen // stride).astype(np.int64)
    fits("ZeroOne.samples", rates.size, int(counts.max()))
    sparse = flow.exact | (time * rates * stride / seen > DENSE)
    return Sampling(stride, counts, seen, np.where(sparse, QUIET / counts, 0.0))


def median_correlation(samples: np.ndarray, counts: np.ndarray, threads: int, report: Report | None) -> np.ndarray:
    """Return K (orbits,) of the 0-1 test on samples (orbits, columns), the first `counts` of each row."""
    orbits = len(samples)
    angles = math.pi * (0.2 + 0.6 * np.random.default_rng(1).random(ANGLES))
    cosine = np.cos(np.arange(counts.max() // 10)[:, None] * angles)
    result = np.full(orbits, np.nan)
    launch(
        kernels.zero_one, (samples, counts, cosine, result), np.zeros(orbits, np.int64), float(orbits), threads, report
    )
    return result
