"""Lines of one spectrum from its bins: their places, sizes and errors, the largest first."""

from __future__ import annotations

import math

import numpy as np

from ...engine.jit import jit
from .fundamental import BLOCK, total


@jit
def shape_of(d, samples, order):
    """Return the transform of the window, 1 at d = 0, at d bins from the line, |d| < 1."""
    x = math.sin(math.pi * d / samples)
    value = 1.0 if d == 0.0 else math.sin(math.pi * d) / (samples * x)
    for i in range(1, order + 1):
        s = math.sin(math.pi * i / samples)
        value *= s * s / (s * s - x * x)
    return value


@jit
def quotient(one, other):
    """Return the real and imaginary part of a quotient of two numbers, given by theirs."""
    (a, b) = one
    (c, d) = other
    if abs(c) >= abs(d):
        ratio = d / c
        whole = c + d * ratio
        return (a + b * ratio) / whole, (b - a * ratio) / whole
    ratio = c / d
    whole = c * ratio + d
    return (a * ratio + b) / whole, (b * ratio - a) / whole


@jit
def place_of(spectrum, k, samples, order):
    """Return the place in bins of the line whose largest bin is k, and its error by the two pairs of bins."""
    step = math.pi / samples
    half = math.tan(step * (order + 0.5))
    x = -math.cos(step)
    y = math.sin(step)
    middle = spectrum[k]
    below = spectrum[(k - 1) % samples]
    above = spectrum[(k + 1) % samples]
    a, b = quotient((above.real, above.imag), (middle.real, middle.imag))
    c, d = quotient((below.real, below.imag), (middle.real, middle.imag))
    # With the time from the middle of the samples the phase turns by x + i y from bin to bin.
    ahead = a * x - b * y
    turned = a * y + b * x
    behind = c * x + d * y
    back = d * x - c * y
    up = math.atan(half * (ahead - 1.0) / (ahead + 1.0)) / step + 0.5 if ahead > -1.0 else 9.0
    down = 0.5 - math.atan(half * (behind - 1.0) / (behind + 1.0)) / step - 1.0 if behind > -1.0 else 9.0
    error = abs(up - down) + abs(turned) + abs(back)
    return k + 0.5 * (up + down), error


@jit
def top_of(part, best):
    """Return the largest of at most BLOCK values. best (BLOCK // 4,): scratch."""
    for i in range(best.size):
        best[i] = part[i] if i < part.size else -1.0
    for start in range(best.size, part.size, best.size):
        more = part[start : start + best.size]
        for i in range(more.size):
            best[i] = more[i] if more[i] > best[i] else best[i]
    top = -1.0
    for i in range(best.size):
        top = best[i] if best[i] > top else top
    return top


@jit
def largest(power, tops):
    """Return the place of the largest of the values; tops: the largest of each BLOCK."""
    block = 0
    for i in range(tops.size):
        block = i if tops[i] > tops[block] else block
    part = power[block * BLOCK : (block + 1) * BLOCK]
    for i in range(part.size):
        if part[i] == tops[block]:
            return block * BLOCK + i
    return 0


@jit
def side_lobe(d, samples, order):
    """Return a bound of the transform of the window, 1 at 0, at d bins from a line, outside of its main lobe."""
    x = math.sin(math.pi * d / samples)
    value = 1.0 / (samples * abs(x))
    for i in range(1, order + 1):
        s = math.sin(math.pi * i / samples)
        value *= s * s / abs(x * x - s * s)
    return value


@jit
def hidden(k, height, order, samples, place, size, count):
    """Return whether a peak at bin k is not above the side lobes of the first peaks."""
    bound = 0.0
    for i in range(count):
        d = abs(k - place[i])
        d = min(d, samples - d)
        if d > order + 0.5:
            bound += size[i] * side_lobe(d, samples, order)
    return height < (2.0 * bound) ** 2


@jit
def find_peaks(spectrum, order, least, counted, place, size, error):
    """Fill place, size, error with the peaks of a spectrum, the largest first, down to a relative size `least`; return
    their number and the share of the power outside of the bins of the `counted` largest, order + 1 on each side.
    """
    samples = spectrum.size
    count = 0
    power = np.empty(samples)
    left = np.empty(samples)
    sums = np.zeros(BLOCK)
    best = np.empty(BLOCK // 4)
    tops = np.empty(-(-samples // BLOCK))
    for block in range(tops.size):
        own = spectrum[block * BLOCK : (block + 1) * BLOCK]
        part = power[block * BLOCK : (block + 1) * BLOCK]
        for i in range(part.size):
            part[i] = own[i].real * own[i].real + own[i].imag * own[i].imag
        for i in range(part.size):
            sums[i] += part[i]
        tops[block] = top_of(part, best)
    for i in range(samples):  # `left[:] = power` compiles two seconds longer, for the text of an error
        left[i] = power[i]
    whole = total(sums)
    rest = whole
    top = 0.0
    while count < place.size:
        k = largest(power, tops)
        height = power[k]
        if not height > least * least * top or height == 0.0:
            break
        above = spectrum[(k + 1) % samples]
        below = spectrum[(k - 1) % samples]
        beside = above.real * above.real + above.imag * above.imag
        beside = max(beside, below.real * below.real + below.imag * below.imag)
        # A slope, or a side lobe, of a larger peak.
        if beside > height or hidden(k, height, order, samples, place, size, count):
            power[k] = 0.0
            tops[k // BLOCK] = top_of(power[k // BLOCK * BLOCK : (k // BLOCK + 1) * BLOCK], best)
            continue
        top = max(top, height)
        u, bar = place_of(spectrum, k, samples, order)
        found = abs(u - k) < 1.0
        place[count] = u if found else k
        error[count] = bar if found else 9.0
        size[count] = math.sqrt(height) / abs(shape_of(place[count] - k, samples, order))
        count += 1
        for j in range(k - order - 1, k + order + 2 if count <= counted else k - order - 1):
            rest -= left[j % samples]
            left[j % samples] = 0.0
        for j in range(k - 1, k + 2):
            power[j % samples] = 0.0
        for j in (k - 1, k, k + 1):
            block = j % samples // BLOCK
            tops[block] = top_of(power[block * BLOCK : (block + 1) * BLOCK], best)
    return count, math.sqrt(max(rest, 0.0) / whole) if whole > 0.0 else 0.0
