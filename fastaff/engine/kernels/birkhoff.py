"""Weighted averages along running orbits."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..jit import LANES, jit
from ..pointers import call_value
from .stepping import row

SHARPNESS = 30.0
"""beta of the weight exp(beta (sqrt(1 - x^2) - 1)) on -1 < x < 1 (Barnett, Magland & af Klinteberg 2019, SIAM J. Sci.
Comput. 41, C479): a line further than beta/pi cycles per window from zero is damped below 2e-12 of the mean weight."""


@jit
def weight(x):
    """Return the weight at -1 < x < 1 of a window, 0 outside it; no branch, so that loops over lanes vectorise."""
    y = 1.0 - x * x
    inside = y > 0.0
    u = (math.sqrt(y if inside else 0.0) - 1.0) * (SHARPNESS / 128.0)
    # exp(u) by its Taylor series on -0.24 < u <= 0 (remainder 1e-16), then its 128th power
    e = 1.0 + u / 11.0
    for k in (10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0):
        e = 1.0 + e * u * (1.0 / k)
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    return e if inside else 0.0


class BirkhoffRows(NamedTuple):
    """Rows of observer memory: the value now; sums of weights and of weighted values over the first and second half."""

    value: int = 0
    early_weight: int = 1
    early: int = 2
    late_weight: int = 3
    late: int = 4
    end: int = 5


ROWS = BirkhoffRows()


@jit(inline=True)
def average(value, calls, lanes, orbit, fresh, t, z, memory, out, done):
    """Observer: add the square of the kinetic energy, by the call, to its weighted sums over both halves of
    value.time.
    """
    call_value(calls, 0, lanes, z, row(memory, ROWS.value))
    for i in range(lanes):
        memory[ROWS.value * LANES + i] *= memory[ROWS.value * LANES + i]
    for i in range(lanes):
        x = 2.0 * t[i] / value.time - 1.0
        now = memory[ROWS.value * LANES + i]
        w = fresh[i] * weight(2.0 * x + 1.0 if x < 0.0 else 2.0 * x - 1.0)
        w1 = w if x < 0.0 else 0.0
        w2 = w if x > 0.0 else 0.0
        memory[ROWS.early_weight * LANES + i] += w1
        memory[ROWS.early * LANES + i] += w1 * now if w1 > 0.0 else 0.0
        memory[ROWS.late_weight * LANES + i] += w2
        memory[ROWS.late * LANES + i] += w2 * now if w2 > 0.0 else 0.0
    return 0
