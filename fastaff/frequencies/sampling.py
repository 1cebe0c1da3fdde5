"""Steps that resolve an orbit's motion, numbers of samples, and the part of a run that shows a step's error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..runs.accuracy import round_down_to_grid
from ..runs.flow import Flow

PILOT = 16
"""The step's error is found over this part of the time, or a longer one of at least PILOT_STEPS steps."""

PILOT_STEPS = 128
PILOT_SAMPLES = 48

SIZES = np.array([16 * q * 2**k for k in range(40) for q in (4, 5, 6, 7)])
"""Numbers of samples: few, as orbits of equal numbers are read together, all multiples of those of pilots."""

LONGEST = 1.5
"""Radians of the fastest small oscillation of an orbit that a step may have: more would show another frequency."""


def resolving(flow: Flow, rate: np.ndarray, time: float) -> Flow:
    """Return the flow with steps that resolve the fastest oscillation (orbits,) of each orbit, however weak."""
    long = rate * flow.step > LONGEST
    if not long.any():
        return flow
    return replace(flow, step=np.where(long, round_down_to_grid(LONGEST / np.where(long, rate, 1.0), time), flow.step))


def sample_counts(need: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return numbers of samples (orbits,), few different ones, that are enough for those needed and take few more steps
    than `steps`.
    """
    need = np.clip(need, SIZES[0], SIZES[-4])
    first = np.searchsorted(SIZES, need * (1 - 1e-9))
    choice = SIZES[first[:, None] + np.arange(3)]
    cost = choice * -(-steps[:, None] // choice) / steps[:, None] + 0.1 * choice / need[:, None]
    return np.take_along_axis(choice, cost.argmin(axis=1)[:, None], axis=1)[:, 0]


def pilot_share(steps: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return the divisor of steps and samples for the pilot: PILOT, or a smaller power of 2 that leaves it PILOT_STEPS
    and PILOT_SAMPLES.
    """
    room = np.maximum(np.minimum(steps // PILOT_STEPS, counts // PILOT_SAMPLES), 1)
    return np.minimum(PILOT, 2 ** np.floor(np.log2(room)).astype(np.int64))
