"""The 0-1 test for chaos on samples.

Samples phi_j drive the translation p_j = sum_(i <= j) phi_i exp(i c (i + 1)). The square of a displacement is a sum of
products of samples, the same for all angles c, with cosines, the same for all orbits:

    |p_(j+n) - p_j|^2 = sum_(1 <= l, m <= n) phi_(j+l) phi_(j+m) cos(c (m - l)).

From n - 1 to n the sum over j grows by S(n, n) + 2 sum_(1 <= k < n) S(n - k, n) cos(c k), where S(l, m) = sum_j
phi_(j+l) phi_(j+m), and S(l + 1, m + 1) differs from S(l, m) by two products: for L lags and A angles L^2 A operations,
a fortieth of those for the displacements of each angle.
"""

from __future__ import annotations

import math

import numpy as np

from ...engine.jit import jit, read_now, write_now

TOGETHER = 4
"""Terms that are added in one pass."""


@jit
def first_products(y, last, first):
    """Set first[k] to the sum of y[j + 1] y[j + 1 + k] over 0 <= j < last."""
    first[:] = 0.0
    whole = last // TOGETHER * TOGETHER
    for j in range(0, whole, TOGETHER):  # the k are neighbours: a loop without dependences
        y0 = y[j + 1]
        y1 = y[j + 2]
        y2 = y[j + 3]
        y3 = y[j + 4]
        for k in range(first.size):
            total = first[k] + y0 * y[j + 1 + k]
            total += y1 * y[j + 2 + k]
            total += y2 * y[j + 3 + k]
            first[k] = total + y3 * y[j + 4 + k]
    for j in range(whole, last):
        for k in range(first.size):
            first[k] += y[j + 1] * y[j + 1 + k]


@jit
def add_rows(weights, count, table, total):
    """Add to total (angles,) the first `count` rows of table (lags, angles), each with its weight."""
    whole = count // TOGETHER * TOGETHER
    for k in range(0, whole, TOGETHER):
        w0 = weights[k]
        w1 = weights[k + 1]
        w2 = weights[k + 2]
        w3 = weights[k + 3]
        for a in range(total.size):
            sums = total[a] + w0 * table[k, a]
            sums += w1 * table[k + 1, a]
            sums += w2 * table[k + 2, a]
            total[a] = sums + w3 * table[k + 3, a]
    for k in range(whole, count):
        for a in range(total.size):
            total[a] += weights[k] * table[k, a]


@jit
def correlations(samples, cosine, result):
    """Set result (angles,) to the correlation of time with the mean square displacement over a tenth of the samples.

    cosine (lags, angles): of the angles times 0, 1, 2 ... The oscillating term of the mean of the samples alone is left
    out.
    """
    lags = samples.size // 10
    last = samples.size - lags
    mean = samples.mean()
    y = np.empty(samples.size)
    sums = np.zeros(lags + 1)
    weights = np.empty(lags)
    first = np.empty(lags)
    products = np.empty(lags)
    for j in range(y.size):
        y[j] = samples[j] - mean
    for j in range(last):
        sums[1] += y[j + 1]
    for m in range(1, lags):
        sums[m + 1] = sums[m] + (y[last + m] - y[m])
    first_products(y, last, first)
    square = np.zeros(result.size)
    ahead = np.zeros(result.size)
    own = np.zeros(result.size)
    total = np.zeros(result.size)
    middle = 0.5 * (lags + 1)
    for n in range(1, lags + 1):
        for k in range(n - 1):
            products[k] += y[last + n - 1 - k] * y[last + n - 1] - y[n - 1 - k] * y[n - 1]
        products[n - 1] = first[n - 1]
        for k in range(n):
            weights[k] = 2.0 * (products[k] + mean * (sums[n - k] + sums[n]))
        weights[0] *= 0.5
        add_rows(weights, n, cosine, square)
        for a in range(result.size):
            total[a] += square[a]
            ahead[a] += (n - middle) * square[a]
            own[a] += square[a] * square[a]
    spread = lags * (lags * lags - 1.0) / 12.0  # the sum of (n - middle)^2
    for a in range(result.size):
        size = spread * (own[a] - total[a] * total[a] / lags)
        result[a] = ahead[a] / math.sqrt(size) if size > 0.0 else 0.0


def zero_one(o, stop, progress, samples, counts, cosine, result):
    """Set result[o] (orbits,) to the median over the angles of the correlation for the first counts[o] in row o of
    samples.

    cosine (lags, angles): of the angles times 0, 1, 2 ...
    """
    if read_now(stop, 0) == 0:
        k = np.empty(cosine.shape[1])
        correlations(samples[o, : counts[o]], cosine, k)
        result[o] = np.median(k)
        write_now(progress, o, 1)
