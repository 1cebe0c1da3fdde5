"""Frequencies of the lines of signals that are fitted together with their neighbours."""

from __future__ import annotations

import numpy as np

from .naff import FrequencyLines, found_lines
from .windows import LINE_ORDER, fast_length

DRIFTS = 0.6
"""Change of every loop's leading line between the halves, in cycles over a half, beyond which an orbit is chaotic."""


def fitted_lines(f: np.ndarray, interval: float, threads: int, lines: int = 8) -> FrequencyLines:
    """Return the strongest lines of signals f (signals, samples), from a number of first samples with a fast Fourier
    transform.
    """
    samples = fast_length(f.shape[1])
    return found_lines(f[:, :samples], interval, max(1, min(lines, samples // 4 - LINE_ORDER)), LINE_ORDER, threads)


def drifts(loops: np.ndarray, leading: np.ndarray, moving: np.ndarray, h: float, threads: int) -> np.ndarray:
    """Return a mask of orbits of which no loop (orbits, m, samples) has its leading line, or one near it, among the
    three strongest of both halves.
    """
    half = loops.shape[2] // 2
    lines = min(3, half // 4 - LINE_ORDER)
    if lines < 1 or not len(loops):
        return np.zeros(len(loops), bool)
    change = np.zeros(leading.shape)
    for part in (loops[:, :, :half], loops[:, :, -half:]):
        found = found_lines(np.ascontiguousarray(part), h, lines, LINE_ORDER, threads)
        near = np.abs(np.abs(found.nu) - leading[:, :, None]) + np.where(np.isfinite(found.error), 0.0, np.inf)
        change = np.maximum(change, near.min(axis=2) * half * h)
    return moving.any(axis=1) & (np.where(moving, change, np.inf).min(axis=1) > DRIFTS)
