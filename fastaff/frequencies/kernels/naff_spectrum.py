"""The spectrum side of `naff`: guesses, removal of lines by their analytic transform, noise and leakage.

Conventions as in `naff_lines`.
"""

import math

from ...engine.jit import LANES, jit

NOISE_REACH = 24  # bins around a line that give its noise level
LEAKAGE_REACH = 1024  # bins within which an error bar weighs the residual bin by bin, over 2^p


@jit
def start_phase(u, start, samples):
    """Return the phase 2 pi u (start/2)/samples of a line at a sample, in half samples, with the exact integer part."""
    middle = math.floor(u + 0.5)
    return (middle * start % (2 * samples) + (u - middle) * start) / samples * math.pi


@jit
def line_shape(j, delta, window):
    """Return W(j - delta) for whole |j| <= order and |delta| <= 1/2, without loss of digits.

    W(d) = -(-1)^p sin(pi delta)/pi prod S_i^2/prod_{i=-p..p} X_(j+i), with X_j = (-1)^j S(j - delta).
    """
    samples = window.weight.size
    order = window.order
    zero = window.zero
    sd = math.sin(math.pi / samples * delta)
    cd = math.cos(math.pi / samples * delta)
    shape = 1.0 if delta == 0.0 else math.sin(math.pi * delta) / (samples * sd)
    below = 1.0
    for i in range(1, order + 1):
        shape *= window.sine[zero + i] ** 2
    for i in range(j - order, j + order + 1):
        if i != 0:
            below *= window.sine[zero + i] * cd - window.cosine[zero + i] * sd
    return (shape if order % 2 == 0 else -shape) / below


@jit
def tail_reach(change, order):
    """Return the distance in bins beyond which a line `change` times as strong is below 1."""
    reach = change
    for i in range(1, order + 1):
        reach *= i * i
    return order + 1 + min(reach ** (1.0 / (2 * order + 1)), 1e15)


@jit(apart=True)
def subtract_line(spectrum, window, u, a, reach, lanes):
    """Subtract the line a*exp(i u tau) from the spectrum (2, N), to `reach` bins from its centre."""
    samples = spectrum.shape[1]
    order = window.order
    odd = -1.0 if samples % 2 == 0 else 1.0  # sign of exp(i N tau)
    middle = math.floor(u + 0.5)
    delta = u - middle
    for j in range(-order, order + 1):
        k = (middle + j) % samples
        shape = line_shape(j, delta, window) * (1.0 if 0 <= middle + j < samples else odd)
        spectrum[0, k] -= a.real * shape
        spectrum[1, k] -= a.imag * shape
    height = math.sin(math.pi * delta) / math.pi * (1.0 if order % 2 else -1.0)
    for i in range(1, order + 1):
        height *= window.sine[window.zero + i] ** 2
    left = int(min(reach, samples // 2))
    right = int(min(reach, (samples - 1) // 2))
    for wrap in range(-1, 2):
        origin = middle + wrap * samples
        h = a * (height if wrap == 0 else odd * height)
        subtract_tail(spectrum, window, h, delta, origin, max(0, origin - left), min(samples, origin - order), lanes)
        subtract_tail(
            spectrum, window, h, delta, origin, max(0, origin + order + 1), min(samples, origin + right + 1), lanes
        )


@jit
def subtract_tail(spectrum, window, h, delta, origin, first, stop, lanes):
    """Subtract h/(S prod(S^2 - S_i^2)) from the bins first <= k < stop, S = S(k - origin - delta)."""
    samples = spectrum.shape[1]
    hr = h.real
    hi = h.imag
    sd = math.sin(math.pi * delta / samples)
    cd = math.cos(math.pi * delta / samples)
    square = lanes[0]
    below = lanes[1]
    for start in range(first, stop, LANES):
        end = min(start + LANES, stop)
        j = start - origin + window.zero
        sine = window.sine[j : j + LANES]
        cosine = window.cosine[j : j + LANES]
        re, im = spectrum[0, start:end], spectrum[1, start:end]
        for i in range(end - start):
            x = sine[i] * cd - cosine[i] * sd
            square[i] = x * x
            below[i] = x
        for k in range(1, window.order + 1):
            pole = window.sine[window.zero + k] ** 2
            for i in range(end - start):
                below[i] *= square[i] - pole
        for i in range(end - start):
            inverse = 1.0 / below[i]
            re[i] -= hr * inverse
            im[i] -= hi * inverse


@jit
def strongest_bin(spectrum, lanes):
    """Return the first bin of the largest modulus of a spectrum (2, N)."""
    samples = spectrum.shape[1]
    high = lanes[0]
    top = -1.0
    where = 0
    for start in range(0, samples, LANES):
        re = spectrum[0, start : start + LANES]
        im = spectrum[1, start : start + LANES]
        count = re.size
        for i in range(count):
            high[i] = re[i] * re[i] + im[i] * im[i]
        best = -1.0
        for i in range(count):
            best = high[i] if high[i] > best else best
        if best > top:  # a spectrum of NaN has no strongest bin
            top = best
            where = start
    for k in range(where, min(where + LANES, samples)):
        if spectrum[0, k] * spectrum[0, k] + spectrum[1, k] * spectrum[1, k] == top:
            return k
    return 0


@jit
def first_guess(spectrum, k, window):
    """Return (u, a), -N/2 <= u < N/2, of the line that peaks at bin k, from the ratio to its larger neighbour."""
    samples = spectrum.shape[1]
    order = window.order
    here = math.hypot(spectrum[0, k], spectrum[1, k])
    left = math.hypot(spectrum[0, k - 1], spectrum[1, k - 1])
    right = math.hypot(spectrum[0, (k + 1) % samples], spectrum[1, (k + 1) % samples])
    if here == 0.0:
        return float(k), 0j
    ratio = max(left, right) / here
    scale = math.pi / samples  # |W(1 - d)/W(d)| = S(p + d)/S(p + 1 - d)
    tangent = ratio * math.sin(scale * (order + 1)) - math.sin(scale * order)
    tangent /= ratio * math.cos(scale * (order + 1)) + math.cos(scale * order)
    delta = min(max(math.atan(tangent) / scale, -0.5), 0.5)
    delta = delta if right >= left else -delta
    a = complex(spectrum[0, k], spectrum[1, k]) / line_shape(0, delta, window)
    if 2 * k < samples:
        return k + delta, a
    return k - samples + delta, (-a if samples % 2 == 0 else a)


@jit
def noise_floor(spectrum, u, gap):
    """Return the level of |bin| between lines (mean of power -1/2), from `gap` to NOISE_REACH + gap bins around u."""
    samples = spectrum.shape[1]
    total = 0.0
    count = 0
    for j in range(gap, min(NOISE_REACH + gap, samples // 2)):
        for k in (math.floor(u) - j, math.floor(u) + 1 + j):
            power = spectrum[0, k % samples] ** 2 + spectrum[1, k % samples] ** 2
            total += 1.0 / math.sqrt(math.sqrt(max(power, 1e-300)))
        count += 2
    return (count / total) ** 2 if count else 0.0


@jit
def spectrum_power(spectrum, lanes):
    """Return the sum of |bin|^2, in a fixed order."""
    samples = spectrum.shape[1]
    total = lanes[0]
    total[:] = 0.0
    for start in range(0, samples, LANES):
        re = spectrum[0, start : start + LANES]
        im = spectrum[1, start : start + LANES]
        for i in range(re.size):
            total[i] += re[i] * re[i] + im[i] * im[i]
    result = 0.0
    for i in range(LANES):
        result += total[i]
    return result


@jit
def load_spectrum(transform, window, work):
    """Split a transform (N,) into real and imaginary parts, time counted from the middle; no line is known yet."""
    re = work.spectrum[0]
    im = work.spectrum[1]
    centre = window.centre
    work.top[0] = 0.0
    for k in range(transform.size):
        z = transform[k]
        c = centre[k]
        re[k] = z.real * c.real - z.imag * c.imag
        im[k] = z.real * c.imag + z.imag * c.real


@jit
def leakage(spectrum, window, u, power, lanes):
    """Return the root of sum |residual bin|^2 bound(bin - u)^2: the largest effect of the residual on a unit line."""
    samples = spectrum.shape[1]
    height = window.envelope[0]
    width = 1.0 / window.envelope[1]
    total = lanes[0]
    square = lanes[1]
    fall = lanes[2]
    total[:] = 0.0
    reach = min(max(LEAKAGE_REACH >> window.order, 64), (samples - 1) // 2)
    for wrap in range(-1, 2):
        origin = u + wrap * samples
        stop = min(samples, int(origin) + reach)
        for start in range(max(0, int(origin) - reach), stop, LANES):
            end = min(start + LANES, stop)
            re = spectrum[0, start:end]
            im = spectrum[1, start:end]
            offset = start - origin
            for i in range(end - start):
                d = (offset + i) * width
                square[i] = d * d
                fall[i] = square[i]
            for _ in range(2 * window.order):
                for i in range(end - start):
                    fall[i] *= square[i]
            for i in range(end - start):
                total[i] += (re[i] * re[i] + im[i] * im[i]) / (1.0 + fall[i])
    result = power / (1.0 + (reach * width) ** (4 * window.order + 2))
    for i in range(LANES):
        result += total[i]
    return height * math.sqrt(result)


@jit(apart=True)
def update_spectrum(window, work, who, count):
    """Bring the residual spectrum up to date with the first `count` lines of `who`, to the window's floor of the
    largest line so far.
    """
    for i in range(count):
        work.top[0] = max(work.top[0], abs(work.a[0, who[i]]))
    lowest = window.floor * work.top[0]
    for i in range(count):
        k = who[i]
        old = work.a[2, k]
        new = work.a[0, k]
        change = abs(new - old) + abs(new) * min(abs(work.u[0, k] - work.u[2, k]), 1.0) * 2 * math.pi
        if change > lowest:
            reach = tail_reach(change / lowest, window.order)
            if old != 0.0:
                subtract_line(work.spectrum, window, work.u[2, k], -old, reach, work.lanes)
            subtract_line(work.spectrum, window, work.u[0, k], new, reach, work.lanes)
            work.u[2, k] = work.u[0, k]
            work.a[2, k] = new


@jit
def apart(first, second, samples):
    """Return the number of bins from the second of two places to the first, -N/2 to N/2."""
    bins = (first - second) % samples
    return bins - samples if 2 * bins > samples else bins
