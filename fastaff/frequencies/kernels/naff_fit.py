"""The sample side of `naff`: Levenberg-Marquardt over all amplitudes and frequencies at once.

Conventions as in `naff_lines`.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...engine.jit import LANES, jit
from ...engine.kernels.stepping import blank
from .naff_lines import EPS, lines_beside, take_line, write_lines
from .naff_spectrum import load_spectrum, start_phase, strongest_bin, update_spectrum

LONG_VECTORS = False
"""Loops of this module take a twentieth less time with the vectors that LLVM chooses."""


class Sums(NamedTuple):
    """Scratch memory for sums over the samples of one signal at a time."""

    fast: Any  # (lines, 2, LANES) exp(i u tau) within a row of samples
    slow: Any  # (lines, 2, rows) and at the row starts
    lanes: Any  # (lines, 4, LANES)
    moments: Any  # (lines, 4) <e, r> and <tau e, r>, real and imaginary parts


def sums_of(samples: int, lines: int) -> Sums:
    """Allocate scratch memory for signals of `samples` and up to `lines` lines."""
    rows = -(-samples // LANES)
    fast = blank(2 * lines)
    lanes = blank(4 * lines)
    slow = np.zeros((lines, 2, rows))
    moments = np.zeros((lines, 4))
    return Sums(fast.reshape(lines, 2, LANES), slow, lanes.reshape(lines, 4, LANES), moments)


@jit(apart=True)
def phasors(table, u, samples, stride, start):
    """Fill table (2, count) with exp(2 pi i u (start + stride*j)/samples); start in half samples."""
    middle = math.floor(u + 0.5)
    delta = u - middle
    count = table.shape[1]
    turn = start_phase(u, start, samples)
    table[0, 0] = math.cos(turn)
    table[1, 0] = math.sin(turn)
    done = 1
    while done < count:  # double the table: few roundings per entry, exact integer part of the phase
        turn = (middle * done * stride % samples + delta * (done * stride)) / samples * (2 * math.pi)
        c, s = math.cos(turn), math.sin(turn)
        for j in range(min(done, count - done)):
            table[0, done + j] = table[0, j] * c - table[1, j] * s
            table[1, done + j] = table[1, j] * c + table[0, j] * s
        done *= 2


@jit(apart=True)
def residual_moments(signal, window, u, a, m, lanes, sums):
    """Fill sums.moments with <e, r> and <tau e, r> of the residual r of m lines; return <r, r>."""
    samples = signal.size
    weight = window.weight
    re = lanes[0]
    im = lanes[1]
    cost = lanes[2]
    cost[:] = 0.0
    for k in range(m):
        phasors(sums.fast[k], u[k], samples, 1, 0)
        phasors(sums.slow[k], u[k], samples, LANES, 1 - samples)
        sums.lanes[k] = 0.0
    for row in range(sums.slow.shape[2]):
        start = row * LANES
        width = min(LANES, samples - start)
        time = start - 0.5 * (samples - 1)
        row_signal = signal[start : start + width]
        row_weight = weight[start : start + width]
        for i in range(width):
            re[i] = row_signal[i].real
            im[i] = row_signal[i].imag
        for k in range(m):
            subtract_row(re, im, width, sums.fast[k], a[k] * complex(sums.slow[k, 0, row], sums.slow[k, 1, row]))
        for i in range(width):
            w = row_weight[i]
            cost[i] += w * (re[i] * re[i] + im[i] * im[i])
            re[i] *= w
            im[i] *= w
        for k in range(m):
            project_row(re, im, width, sums.slow[k, 0, row], sums.slow[k, 1, row], time, sums.lanes[k])
    total = 0.0
    for i in range(LANES):
        total += cost[i]
    for k in range(m):
        reduce_lanes(sums.lanes[k], sums.fast[k], samples, sums.moments[k])
    return total


@jit
def subtract_row(re, im, width, fast, z):
    """Subtract z*fast from a row of samples."""
    zr = z.real
    zi = z.imag
    c = fast[0]
    s = fast[1]
    for i in range(width):
        re[i] -= zr * c[i] - zi * s[i]
        im[i] -= zr * s[i] + zi * c[i]


@jit
def project_row(re, im, width, c, s, time, sums):
    """Add conj(c + i s)*row, and the same times `time`, to the lane sums (4, LANES)."""
    s0 = sums[0]
    s1 = sums[1]
    s2 = sums[2]
    s3 = sums[3]
    for i in range(width):
        pr = c * re[i] + s * im[i]
        pi = c * im[i] - s * re[i]
        s0[i] += pr
        s1[i] += pi
        s2[i] += time * pr
        s3[i] += time * pi


@jit
def reduce_lanes(sums, fast, samples, moments):
    """Finish <e, r> and <tau e, r> from the lane sums, in a fixed order."""
    moments[:] = 0.0
    for i in range(LANES):
        c, s = fast[0, i], fast[1, i]
        tr = sums[2, i] + i * sums[0, i]
        ti = sums[3, i] + i * sums[1, i]
        moments[0] += c * sums[0, i] + s * sums[1, i]
        moments[1] += c * sums[1, i] - s * sums[0, i]
        moments[2] += (c * tr + s * ti) * (2 * math.pi / samples)
        moments[3] += (c * ti - s * tr) * (2 * math.pi / samples)


@jit
def dirichlet(d, samples):
    """Return D(d) = sin(pi d)/(N sin(pi d/N)) and its first two derivatives."""
    turns = math.floor(d / samples + 0.5)
    x = d - turns * samples
    sign = -1.0 if (turns * (samples - 1)) % 2 else 1.0
    if abs(x) < 1e-3:
        c = math.pi**2 / 6 * (1.0 - 1.0 / samples**2)
        return sign * (1.0 - c * x * x), sign * -2.0 * c * x, sign * -2.0 * c
    q = math.pi / samples
    s = math.sin(math.pi * x)
    c = math.cos(math.pi * x)
    bottom = math.sin(q * x)
    slope = q * math.cos(q * x)
    value = s / bottom
    first = (math.pi * c - value * slope) / bottom
    second = (-(math.pi**2) * s + value * q * q * bottom - 2.0 * first * slope) / bottom
    return sign * value / samples, sign * first / samples, sign * second / samples


@jit
def window_transform(d, window):
    """Return W(d), W'(d), W''(d) to absolute rounding accuracy."""
    samples = window.weight.size
    value, first, second = dirichlet(d, samples)
    for j in range(1, window.order + 1):
        q = window.fourier[j]
        for side in (-1, 1):
            term = dirichlet(d + side * j, samples)
            value = value + q * term[0]
            first = first + q * term[1]
            second = second + q * term[2]
    return value, first, second


@jit(apart=True)
def normal_equations(window, u, a, m, moments, work):
    """Fill matrix and gradient of the fit in (Re a, Im a, |a| u) of m lines, weighted by the window."""
    matrix = work.matrix
    for k in range(m):
        size = abs(a[k])
        pk = a[k] / size if size > 0.0 else 1.0 + 0j
        s0 = complex(moments[k, 0], moments[k, 1])
        s1 = complex(moments[k, 2], moments[k, 3])
        work.gradient[3 * k], work.gradient[3 * k + 1] = s0.real, s0.imag
        work.gradient[3 * k + 2] = (pk.conjugate() * s1).imag
        for j in range(k + 1):
            size = abs(a[j])
            pj = a[j] / size if size > 0.0 else 1.0 + 0j
            w0, w1, w2 = window_transform(u[k] - u[j], window)
            r = 3 * k
            c = 3 * j
            matrix[r, c], matrix[r, c + 1], matrix[r, c + 2] = w0, 0.0, -pj.real * w1
            matrix[r + 1, c], matrix[r + 1, c + 1], matrix[r + 1, c + 2] = 0.0, w0, -pj.imag * w1
            matrix[r + 2, c], matrix[r + 2, c + 1] = pk.real * w1, pk.imag * w1
            matrix[r + 2, c + 2] = -(pj.conjugate() * pk).real * w2


@jit(apart=True)
def cholesky(matrix, factor, n, damping):
    """Factor the lower triangle of matrix + damping*diag(matrix); tiny pivots are kept positive."""
    for i in range(n):
        for j in range(i + 1):
            x = matrix[i, j] * (1.0 + damping if i == j else 1.0)
            for k in range(j):
                x -= factor[i, k] * factor[j, k]
            factor[i, j] = math.sqrt(max(x, 1e-15 * matrix[i, i])) if i == j else x / factor[j, j]


@jit(apart=True)
def substitute(factor, n, x):
    """Solve factor factor^T x = x in place."""
    for i in range(n):
        for k in range(i):
            x[i] -= factor[i, k] * x[k]
        x[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= factor[k, i] * x[k]
        x[i] /= factor[i, i]


@jit
def trial_step(work, u, a, m, damping):
    """Solve for a damped step of at most half a bin per line and write the trial lines: row 1 of u, a."""
    cholesky(work.matrix, work.factor, 3 * m, damping)
    for k in range(3 * m):
        work.step[k] = work.gradient[k]
    substitute(work.factor, 3 * m, work.step)
    for k in range(m):
        size = abs(a[0, k])
        move = work.step[3 * k + 2] / size if size > 0.0 else 0.0
        u[1, k] = u[0, k] + min(max(move, -0.5), 0.5)
        a[1, k] = a[0, k] + complex(work.step[3 * k], work.step[3 * k + 1])


@jit
def accept(u, a, m):
    """Make the trial lines the current ones."""
    for k in range(m):
        u[0, k], a[0, k] = u[1, k], a[1, k]


@jit(apart=True)
def couple(work, who, m):
    """Set work.coupling of the m lines that were fitted last: the factor of their errors due to others."""
    cholesky(work.matrix, work.factor, 3 * m, 0.0)
    for k in range(m):
        work.step[: 3 * m] = 0.0
        work.step[3 * k + 2] = 1.0
        substitute(work.factor, 3 * m, work.step)
        widened = work.step[3 * k + 2] * work.matrix[3 * k + 2, 3 * k + 2]
        work.coupling[who[k]] = math.sqrt(widened) if widened > 0.0 else math.inf  # lines that are not resolved


@jit(apart=True)
def refit(signal, window, work, sums, m, strict):
    """Fit m lines jointly to all samples (Levenberg-Marquardt); return the largest last step in bins, 0 if
    converged.
    """
    u = work.u
    a = work.a
    cost = residual_moments(signal, window, u[0], a[0], m, work.lanes, sums)
    normal_equations(window, u[0], a[0], m, sums.moments, work)
    damping = 0.0
    last = 0.0
    for _ in range(80 if strict else 8):
        trial_step(work, u, a, m, damping)
        top = 0.0
        small = True
        last = 0.0
        for k in range(m):
            top = max(top, abs(a[0, k]))
        enough = EPS * top if strict else max(EPS * top, 0.01 * math.sqrt(cost))
        for k in range(m):
            move = abs(u[1, k] - u[0, k])
            last = max(last, move)
            small = small and (move <= 1e-8 or move * abs(a[0, k]) <= enough)
        if small and damping <= 1e-3:
            accept(u, a, m)
            return 0.0
        trial = residual_moments(signal, window, u[1], a[1], m, work.lanes, sums)
        if trial <= cost * (1.0 + 1e-6) + (EPS * top) ** 2:
            accept(u, a, m)
            cost = trial
            damping = 0.1 * damping if damping > 1e-4 else 0.0
            normal_equations(window, u[0], a[0], m, sums.moments, work)
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e9:
                break
    return last


@jit
def collect_from_samples(signal, window, work, sums, lines):
    """Find and fit up to `lines` lines all together to all samples; return their number and the last step in bins (0 if
    converged).

    A peak beside a known line may be the residual of its first guess, so it counts as a line only after a fit.
    """
    m = 0
    fitted = 0
    top = 0.0
    high = 0.0
    who = work.who
    while m < lines:
        k = strongest_bin(work.spectrum, work.lanes)
        if fitted < m and lines_beside(window, work, m, k) > 0:
            refit(signal, window, work, sums, m, False)
            for i in range(m):
                who[i] = i
            update_spectrum(window, work, who, m)
            fitted = m
            continue
        if not take_line(window, work, m, k, top, high):
            break
        top = max(top, abs(work.a[0, m]))
        high = max(high, abs(work.u[0, m]))
        m += 1
    if m == 0:
        return 0, 0.0
    last = refit(signal, window, work, sums, m, True)
    normal_equations(window, work.u[0], work.a[0], m, sums.moments, work)
    for k in range(m):
        who[k] = k
    couple(work, who, m)
    update_spectrum(window, work, who, m)
    return m, last


@jit
def fit_lines(signals, transforms, window, work, sums, nu, amplitude, error, residual):
    """Find the lines of signals (batch, N) with windowed FFTs (batch, N): rows of nu (in bins), amplitude, error."""
    for s in range(transforms.shape[0]):
        load_spectrum(transforms[s], window, work)
        m, last = collect_from_samples(signals[s], window, work, sums, nu.shape[1])
        residual[s] = write_lines(window, work, m, last, nu[s], amplitude[s], error[s])
