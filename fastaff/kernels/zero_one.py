"""The 0-1 test for chaos on samples."""

from __future__ import annotations

import math

import numpy as np

from ..compile.jit import jit, read_now, write_now

TOGETHER = 4
"""Samples whose displacements at all lags are added in one pass."""


@jit
def correlation(samples, c, cosine, sine, lags, p, q, square):
    """Return the correlation of time with the mean square displacement of the translations driven by samples at the
    angle c.

    cosine, sine: of c times 1, 2, ...; p, q (samples,), square (lags,): scratch.
    """
    count = samples.size
    mean, x, y = samples.mean(), 0.0, 0.0
    for j in range(count):
        x += samples[j] * cosine[j]
        y += samples[j] * sine[j]
        p[j], q[j] = x, y
    square[:lags] = 0.0
    last = count - lags
    whole = last // TOGETHER * TOGETHER
    for j in range(0, whole, TOGETHER):  # the lags are neighbours: a loop without dependences
        p0, p1, p2, p3 = p[j], p[j + 1], p[j + 2], p[j + 3]
        q0, q1, q2, q3 = q[j], q[j + 1], q[j + 2], q[j + 3]
        px, qx = p[j + 1 : j + 1 + lags + TOGETHER], q[j + 1 : j + 1 + lags + TOGETHER]
        for i in range(lags):
            total = square[i]
            u, v = px[i] - p0, qx[i] - q0
            total += u * u + v * v
            u, v = px[i + 1] - p1, qx[i + 1] - q1
            total += u * u + v * v
            u, v = px[i + 2] - p2, qx[i + 2] - q2
            total += u * u + v * v
            u, v = px[i + 3] - p3, qx[i + 3] - q3
            square[i] = total + (u * u + v * v)
    for j in range(whole, last):
        for i in range(lags):
            u, v = p[j + 1 + i] - p[j], q[j + 1 + i] - q[j]
            square[i] += u * u + v * v
    sums = np.zeros(5)
    for lag in range(1, lags + 1):
        # The part that the mean of the samples gives oscillates in time: leave it out.
        value = square[lag - 1] / last - mean * mean * (1.0 - math.cos(lag * c)) / (1.0 - math.cos(c))
        sums[0] += lag
        sums[1] += value
        sums[2] += lag * lag
        sums[3] += lag * value
        sums[4] += value * value
    across = sums[3] - sums[0] * sums[1] / lags
    spread = (sums[2] - sums[0] * sums[0] / lags) * (sums[4] - sums[1] * sums[1] / lags)
    return across / math.sqrt(spread) if spread > 0.0 else 0.0


def zero_one(o, stop, progress, samples, counts, angles, cosine, sine, result):
    """Set result[o] (orbits,) to the median over `angles` of the correlation for the first counts[o] in row o of
    samples.

    cosine, sine (angles, samples): of the angles times 1, 2, ...
    """
    count = counts[o]
    if read_now(stop, 0) == 0:
        lags = count // 10
        p, q, square, k = np.empty(count), np.empty(count), np.empty(lags), np.empty(angles.size)
        for j in range(angles.size):
            k[j] = correlation(samples[o, :count], angles[j], cosine[j], sine[j], lags, p, q, square)
        result[o] = np.median(k)
        write_now(progress, o, 1)
