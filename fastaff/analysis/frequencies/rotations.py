"""Mean rates of winding coordinates with a period: frequencies that are in no line if nothing else turns."""

from __future__ import annotations

import numpy as np

from .demodulated import PARTS, parts
from .signals import Signals


def going_round(s: Signals, periods: np.ndarray) -> np.ndarray:
    """Return a mask (orbits, n) of coordinates, rows 2i of the signals, that end more than a period (n,) from their
    start; those of a period 0 do not.
    """
    first = s.start[:, None] + 2 * np.arange(periods.size) * s.samples[:, None]
    moved = s.numbers[first + s.samples[:, None] - 1] - s.numbers[first]
    return (periods > 0) & (np.abs(moved) > periods)


def mean_turns(s: Signals, start: Signals | None, periods: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return weighted mean rates (orbits, n, PARTS), in periods per unit time, of coordinates, rows 2i of the signals,
    and their decrease (orbits, n, 3) with the finer step of `start`, over its samples and over its halves.

    They are differences of unwrapped coordinates: no turn is lost, however few samples it has.
    """
    shape = s.samples.size, periods.size
    rates, change = np.zeros((*shape, len(PARTS))), np.zeros((*shape, 3))
    for o in s.alike():
        run, unit = s.array(o)[:, ::2], np.where(periods > 0, periods, 1.0)[:, None] * float(s.interval[o[0]])
        rates[o] = _weighted(run, parts(run.shape[2] - 1)[0]) / unit
        if start is None:
            continue
        for part in start.of(o).alike():
            fine = start.array(o[part])[:, ::2]
            weights = parts(fine.shape[2] - 1)[0][:3]
            change[o[part]] = (_weighted(run[part, :, : fine.shape[2]], weights) - _weighted(fine, weights)) / unit
    return rates, change


def _weighted(coordinates: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the means (orbits, n, windows) of the steps of coordinates (orbits, n, samples)."""
    steps = np.diff(coordinates, axis=2)
    return np.stack([(steps * weight).sum(axis=2) for weight in weights], axis=2)
