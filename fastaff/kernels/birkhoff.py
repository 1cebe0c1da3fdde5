"""Weighted averages and samples along running orbits."""

from __future__ import annotations

import math

from ..compile.jit import LANES, jit

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


@jit(constants=True)
def sample(rows, lanes, orbit, fresh, block, memory, out):
    """Write the rows of block as the next sample of each orbit; row `rows` of memory counts the samples."""
    for i in range(lanes):
        taken = int(memory[rows * LANES + i])
        if fresh[i] > 0.0 and (taken + 1) * rows <= out.shape[1]:
            for r in range(rows):
                out[orbit[i], taken * rows + r] = block[r * LANES + i]
            memory[rows * LANES + i] += 1.0


@jit
def average(time, lanes, fresh, t, memory):
    """Add row 0 of memory to its weighted sums over both halves of `time`: rows 1 and 3 the weights, 2 and 4 the
    weighted values.
    """
    for i in range(lanes):
        x = 2.0 * t[i] / time - 1.0
        w1, w2 = fresh[i] * weight(2.0 * x + 1.0), fresh[i] * weight(2.0 * x - 1.0)
        memory[LANES + i] += w1
        memory[2 * LANES + i] += w1 * memory[i] if w1 > 0.0 else 0.0
        memory[3 * LANES + i] += w2
        memory[4 * LANES + i] += w2 * memory[i] if w2 > 0.0 else 0.0
