"""The 0-1 test for chaos on samples."""

from __future__ import annotations

import math

import numpy as np

from ..compile.jit import jit, read_now, write_now


@jit
def correlation(samples, c, lags, p, q):
    """Return the correlation of time with the mean square displacement of the translations driven by samples at the
    angle c.
    """
    count = samples.size
    mean = samples.mean()
    x, y = 0.0, 0.0
    for j in range(count):
        x += samples[j] * math.cos(c * (j + 1))
        y += samples[j] * math.sin(c * (j + 1))
        p[j], q[j] = x, y
    sums = np.zeros(5)
    for lag in range(1, lags + 1):
        square = 0.0
        for j in range(count - lags):
            u, v = p[j + lag] - p[j], q[j + lag] - q[j]
            square += u * u + v * v
        # The part that the mean of the samples gives oscillates in time: leave it out.
        value = square / (count - lags) - mean * mean * (1.0 - math.cos(lag * c)) / (1.0 - math.cos(c))
        sums[0] += lag
        sums[1] += value
        sums[2] += lag * lag
        sums[3] += lag * value
        sums[4] += value * value
    across = sums[3] - sums[0] * sums[1] / lags
    spread = (sums[2] - sums[0] * sums[0] / lags) * (sums[4] - sums[1] * sums[1] / lags)
    return across / math.sqrt(spread) if spread > 0.0 else 0.0


def zero_one(o, stop, progress, samples, counts, angles, result):
    """Set result[o] (orbits,) to the median over `angles` of the correlation for the first counts[o] in row o of
    samples.
    """
    count = counts[o]
    if read_now(stop, 0) == 0:
        p, q, k = np.empty(count), np.empty(count), np.empty(angles.size)
        for j in range(angles.size):
            k[j] = correlation(samples[o, :count], angles[j], count // 10, p, q)
        result[o] = np.median(k)
        write_now(progress, o, 1)
