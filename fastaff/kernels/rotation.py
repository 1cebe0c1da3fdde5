"""Streamed rotation rates: weighted Birkhoff averages of the rates of angles, each in its own clock (layer L2).

Observer memory, in rows of LANES, for n angles:
    8 n + 2   Re Q, Im Q, Re P, Im P and their time derivatives of each angle; rate of the clock and its derivative;
    SHARED    time, clock, rate and derivative at the last observation, length of the clock's window; then the sums, over
              three windows each, of weights, of weights times the clock's rate (window in time, then window in the clock);
    6         the weights of the moment: three windows in time, three in the clock;
    5 n       of each angle: centre, scale kappa, three sums of weights times its rate.
The three windows are the whole, its first half and its second half.
"""

from __future__ import annotations

import math

from .._jit import LANES, jit

SHARED, WEIGHTS, PER_ANGLE = 14, 6, 5

SHARPNESS = 30.0
"""beta of the weight exp(beta (sqrt(1 - x^2) - 1)) on -1 < x < 1 (Barnett, Magland & af Klinteberg 2019, SIAM J. Sci. Comput. 41,
C479): a line further than beta/pi cycles per window from zero is damped below 2e-12 of the mean weight."""


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
def keep_time(time, n, lanes, fresh, t, memory):
    """Advance each lane's clock to t (Hermite's rule, error h^5/720) and set and sum the weights of the moment."""
    rate = 8 * n * LANES
    shared = rate + 2 * LANES
    weights = shared + SHARED * LANES
    for i in range(lanes):
        on = fresh[i]
        h = on * (t[i] - memory[shared + i])
        r0, r1 = memory[shared + 2 * LANES + i], memory[rate + i]
        d0, d1 = memory[shared + 3 * LANES + i], memory[rate + LANES + i]
        clock = memory[shared + LANES + i] + h * (0.5 * (r0 + r1) + h * (d0 - d1) * (1.0 / 12.0))
        memory[shared + LANES + i] = clock
        memory[shared + i] = t[i] if on > 0.0 else memory[shared + i]
        memory[shared + 2 * LANES + i] = r1 if on > 0.0 else r0
        memory[shared + 3 * LANES + i] = d1 if on > 0.0 else d0
        x, y = 2.0 * t[i] / time - 1.0, 2.0 * clock / memory[shared + 4 * LANES + i] - 1.0
        w0, w1, w2 = on * weight(x), on * weight(2.0 * x + 1.0), on * weight(2.0 * x - 1.0)
        v0, v1, v2 = on * weight(y), on * weight(2.0 * y + 1.0), on * weight(2.0 * y - 1.0)
        memory[weights + i], memory[weights + LANES + i], memory[weights + 2 * LANES + i] = w0, w1, w2
        memory[weights + 3 * LANES + i], memory[weights + 4 * LANES + i], memory[weights + 5 * LANES + i] = v0, v1, v2
        memory[shared + 5 * LANES + i] += w0
        memory[shared + 6 * LANES + i] += w1
        memory[shared + 7 * LANES + i] += w2
        memory[shared + 8 * LANES + i] += w0 * r1
        memory[shared + 9 * LANES + i] += w1 * r1
        memory[shared + 10 * LANES + i] += w2 * r1
        memory[shared + 11 * LANES + i] += v0 * r1
        memory[shared + 12 * LANES + i] += v1 * r1
        memory[shared + 13 * LANES + i] += v2 * r1


@jit(constants=True)
def rotate(time, clocks, lanes, fresh, t, memory):
    """Add the weighted rates of all angles; clocks[k] = 1 where angle k is averaged over the clock instead of time."""
    n = len(clocks)
    keep_time(time, n, lanes, fresh, t, memory)
    weights = (8 * n + 2 + SHARED) * LANES
    for k in range(n):
        s = 8 * k * LANES
        m = weights + (WEIGHTS + PER_ANGLE * k) * LANES
        w = weights + 3 * clocks[k] * LANES
        for i in range(lanes):
            kappa = memory[m + LANES + i]
            re = memory[s + i] - memory[m + i] + kappa * memory[s + 3 * LANES + i]
            im = memory[s + LANES + i] - kappa * memory[s + 2 * LANES + i]
            re_rate = memory[s + 4 * LANES + i] + kappa * memory[s + 7 * LANES + i]
            im_rate = memory[s + 5 * LANES + i] - kappa * memory[s + 6 * LANES + i]
            rate = (re * im_rate - im * re_rate) / (re * re + im * im)
            memory[m + 2 * LANES + i] += memory[w + i] * rate
            memory[m + 3 * LANES + i] += memory[w + LANES + i] * rate
            memory[m + 4 * LANES + i] += memory[w + 2 * LANES + i] * rate


@jit(constants=True)
def widen(signals, lanes, fresh, memory):
    """Widen the range of each signal: memory rows are signals, smallest values, largest values."""
    for s in range(signals):
        for i in range(lanes):
            value = memory[s * LANES + i]
            j, k = (signals + s) * LANES + i, (2 * signals + s) * LANES + i
            memory[j] = min(memory[j], value) if fresh[i] > 0.0 else memory[j]
            memory[k] = max(memory[k], value) if fresh[i] > 0.0 else memory[k]


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
    """Add row 0 of memory to its weighted sums over both halves of `time`: rows 1 and 3 the weights, 2 and 4 the weighted values."""
    for i in range(lanes):
        x = 2.0 * t[i] / time - 1.0
        w1, w2 = fresh[i] * weight(2.0 * x + 1.0), fresh[i] * weight(2.0 * x - 1.0)
        memory[LANES + i] += w1
        memory[2 * LANES + i] += w1 * memory[i] if w1 > 0.0 else 0.0
        memory[3 * LANES + i] += w2
        memory[4 * LANES + i] += w2 * memory[i] if w2 > 0.0 else 0.0
