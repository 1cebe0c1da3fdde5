"""Weighted mean rates of loops of orbits, in windows of the whole and of its halves."""

from __future__ import annotations

import numpy as np

from .fundamental import Loops, run
from .kernels import loops as loop_kernels
from .kernels.fundamental import BLOCK
from .windows import bump, tabulated

PARTS = (
    *((0.0, 1.0), (0.0, 0.5), (0.5, 1.0), (0.0, 0.6), (0.4, 1.0)),
    *((0.0, 0.35), (0.15, 0.5), (0.5, 0.85), (0.65, 1.0)),
)
"""Windows of orbits in time: the whole, both halves, two that tell the error of the whole, and two for each half."""


@tabulated
def parts(steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the weights (parts, steps) of PARTS, and where each begins and ends (parts, 2), in whole BLOCKs."""
    weights = np.array([bump(steps, *span) for span in PARTS])
    places = np.array(PARTS) * steps / BLOCK
    spans = BLOCK * np.stack([np.floor(places[:, 0]), np.ceil(places[:, 1])], axis=1).astype(np.int64)
    return weights, np.minimum(spans, steps)


def turning(
    signals: np.ndarray, loops: Loops, weights: np.ndarray, spans: np.ndarray, interval: float, threads: int
) -> np.ndarray:
    """Return weighted mean rates (orbits, loops, windows), in cycles per unit time, of loops of the first samples of
    the signals, with the weights of some of `parts`.
    """
    rates = np.zeros((*loops.offset.shape, len(weights)))
    run(loop_kernels.turn, len(signals), (signals, loops.complexes(), weights, spans, rates), threads)
    return rates / (2 * np.pi * interval)
