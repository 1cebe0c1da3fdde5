"""Minima of functions of any number of variables, at any scale, by steps along the coordinates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Floor = Callable[[np.ndarray], np.ndarray]
"""A function of points (d, ...) with values (...)."""

ROUNDS = 120
"""Steps along each coordinate."""


def descended(
    floor: Floor, x: np.ndarray, step: np.ndarray, *, grow: float = 2.0, rounds: int = ROUNDS
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the lowest points that steps along the coordinates reach from x (d, points), their values, the last steps.

    A step that leads down is multiplied by `grow`; a step that leads down in neither direction is halved.
    """
    value = floor(x)
    x = x.copy()
    step = step.copy()
    for _ in range(rounds):
        for k in range(len(x)):
            better = np.zeros(x.shape[1], bool)
            for sign in (1, -1):
                trial = x.copy()
                trial[k] += sign * step[k]
                there = floor(trial)
                down = ~better & (there < value)
                x[k, down] = trial[k, down]
                value[down] = there[down]
                better |= down
            step[k] = np.where(better, grow * step[k], step[k] / 2)
    return x, value, step
