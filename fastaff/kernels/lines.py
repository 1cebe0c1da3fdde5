"""Kernels of `naff`: find the strongest lines of windowed signals and fit them together (layer L2).

Frequencies u are in bins (cycles per signal length), times run from the middle of the signal:
tau_n = 2 pi (n - (N - 1)/2)/N. A line is a*exp(i u tau). The window weights w_n sum to one and are sampled so
that their transform W(d) = sum w_n cos(d tau_n) is closed, with scaled sines S(x) = N/pi sin(pi x/N):
W(d) = sin(pi d)/(pi S(d)) prod_{i=1..p} S(i)^2/(S(i)^2 - S(d)^2). It falls like d^-(2p+1) beyond bin p.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from fastaff._jit import jit

LANES = 128
FLOOR = 1e-17  # relative amplitude at which the tail of a line is cut, below the rounding of the transform
NOISE_REACH = 24  # bins around a line that tell its noise level
LEAKAGE_REACH = 1024  # bins within which an error bar weighs the residual bin by bin
EPS = 2.220446049250313e-16


class Window(NamedTuple):
    """Tables of one window: order p >= 0 over N samples."""

    order: int
    weight: Any  # (N,) w_n, sum 1
    centre: Any  # (N,) complex, moves the time origin of FFT bin k to the middle
    sine: Any  # (2 (N//2) + 1,) (-1)^j N/pi sin(pi j/N), j = -N//2 ... N//2
    cosine: Any  # the same with cos
    fourier: Any  # (p + 1,) W(j) at whole bins: w_n = (fourier[0] + 2 sum_j fourier[j] cos(j tau_n))/N
    envelope: Any  # (4,) height, width of the bound of |W'|/sum w_n tau_n^2; 1/(N sum w_n^2); noise to error of u


class Work(NamedTuple):
    """Scratch memory for one signal at a time."""

    spectrum: Any  # (2, N) transform of the windowed residual, real and imaginary parts
    lanes: Any  # (4, LANES)
    fast: Any  # (lines, 2, LANES) exp(i u tau) within a row of samples
    slow: Any  # (lines, 2, rows) and at the row starts
    sums: Any  # (lines, 4, LANES)
    moments: Any  # (lines, 4) <e, r> and <tau e, r>, real and imaginary parts
    matrix: Any  # (3 lines, 3 lines)
    factor: Any  # (3 lines, 3 lines)
    gradient: Any  # (3 lines,)
    step: Any  # (3 lines,)
    u: Any  # (3, lines) bins: current, trial, already subtracted from the spectrum
    a: Any  # (3, lines) complex amplitudes in the middle of the signal


def workspace(samples: int, lines: int) -> Work:
    """Allocate scratch memory for signals of `samples` and up to `lines` lines."""
    rows, full = -(-samples // LANES), np.zeros
    return Work(
        full((2, samples)), full((4, LANES)), full((lines, 2, LANES)), full((lines, 2, rows)),
        full((lines, 4, LANES)), full((lines, 4)), full((3 * lines, 3 * lines)), full((3 * lines, 3 * lines)),
        full(3 * lines), full(3 * lines), full((3, lines)), full((3, lines), np.complex128),
    )  # fmt: skip


@jit
def line_shape(j, delta, samples, order):
    """Return W(j - delta) for whole |j| <= order and |delta| <= 1/2, without loss of digits."""
    scale = math.pi / samples
    shape = 1.0 if delta == 0.0 else math.sin(math.pi * delta) / (samples * math.sin(scale * delta))
    for i in range(1, order + 1):
        shape *= math.sin(scale * i) ** 2
    for i in range(-order, order + 1):
        if i != -j:
            shape /= math.sin(scale * (j + i - delta))
    return -shape if (order + j) % 2 else shape


@jit
def tail_reach(change, order):
    """Return the distance in bins beyond which a line of relative amplitude `change` is below FLOOR."""
    reach = change / FLOOR
    for i in range(1, order + 1):
        reach *= i * i
    return order + 1 + min(reach ** (1.0 / (2 * order + 1)), 1e15)


@jit
def subtract_line(spectrum, window, u, a, reach, lanes):
    """Subtract the line a*exp(i u tau) from the spectrum (2, N), to `reach` bins from its centre."""
    samples, order = spectrum.shape[1], window.order
    odd = -1.0 if samples % 2 == 0 else 1.0  # sign of exp(i N tau)
    middle = math.floor(u + 0.5)
    delta = u - middle
    for j in range(-order, order + 1):
        k = (middle + j) % samples
        shape = line_shape(j, delta, samples, order) * (1.0 if 0 <= middle + j < samples else odd)
        spectrum[0, k] -= a.real * shape
        spectrum[1, k] -= a.imag * shape
    height = math.sin(math.pi * delta) / math.pi * (1.0 if order % 2 else -1.0)
    for i in range(1, order + 1):
        height *= window.sine[i + samples // 2] ** 2
    left, right = int(min(reach, samples // 2)), int(min(reach, (samples - 1) // 2))
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
    samples, hr, hi = spectrum.shape[1], h.real, h.imag
    sd, cd = math.sin(math.pi * delta / samples), math.cos(math.pi * delta / samples)
    square, below, half = lanes[0], lanes[1], samples // 2
    for start in range(first, stop, LANES):
        end = min(start + LANES, stop)
        j = start - origin + half
        sine, cosine = window.sine[j : j + LANES], window.cosine[j : j + LANES]
        re, im = spectrum[0, start:end], spectrum[1, start:end]
        for i in range(end - start):
            x = sine[i] * cd - cosine[i] * sd
            square[i] = x * x
            below[i] = x
        for k in range(1, window.order + 1):
            pole = window.sine[k + half] ** 2
            for i in range(end - start):
                below[i] *= square[i] - pole
        for i in range(end - start):
            inverse = 1.0 / below[i]
            re[i] -= hr * inverse
            im[i] -= hi * inverse


@jit
def strongest_bin(spectrum, lanes):
    """Return the bin of the largest modulus of a spectrum (2, N)."""
    samples = spectrum.shape[1]
    best, where = lanes[0], lanes[1]
    best[:] = -1.0
    for start in range(0, samples, LANES):
        row = float(start)
        re, im = spectrum[0, start : start + LANES], spectrum[1, start : start + LANES]
        for i in range(re.size):
            power = re[i] * re[i] + im[i] * im[i]
            larger = power > best[i]
            best[i] = power if larger else best[i]
            where[i] = row if larger else where[i]
    top = 0
    for i in range(1, min(LANES, samples)):
        if best[i] > best[top] or (best[i] == best[top] and where[i] < where[top]):
            top = i
    return int(where[top]) + top


@jit
def first_guess(spectrum, k, order):
    """Return (u, a), -N/2 <= u < N/2, of the line that peaks at bin k, from the ratio to its larger neighbour."""
    samples = spectrum.shape[1]
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
    a = complex(spectrum[0, k], spectrum[1, k]) / line_shape(0, delta, samples, order)
    if 2 * k < samples:
        return k + delta, a
    return k - samples + delta, (-a if samples % 2 == 0 else a)


@jit
def phasors(table, u, samples, stride, start):
    """Fill table (2, count) with exp(2 pi i u (start + stride*j)/samples); start in half samples."""
    middle = math.floor(u + 0.5)
    delta, count = u - middle, table.shape[1]
    turn = (middle * start % (2 * samples) + delta * start) / samples * math.pi
    table[0, 0], table[1, 0] = math.cos(turn), math.sin(turn)
    done = 1
    while done < count:  # double the table: few roundings per entry, exact integer part of the phase
        turn = (middle * done * stride % samples + delta * (done * stride)) / samples * (2 * math.pi)
        c, s = math.cos(turn), math.sin(turn)
        for j in range(min(done, count - done)):
            table[0, done + j] = table[0, j] * c - table[1, j] * s
            table[1, done + j] = table[1, j] * c + table[0, j] * s
        done *= 2


@jit
def residual_moments(signal, window, u, a, m, work):
    """Fill work.moments with <e, r> and <tau e, r> of the residual r of m lines; return <r, r>."""
    samples, weight = signal.size, window.weight
    re, im, cost = work.lanes[0], work.lanes[1], work.lanes[2]
    cost[:] = 0.0
    for k in range(m):
        phasors(work.fast[k], u[k], samples, 1, 0)
        phasors(work.slow[k], u[k], samples, LANES, 1 - samples)
        work.sums[k] = 0.0
    for row in range(work.slow.shape[2]):
        start = row * LANES
        width, time = min(LANES, samples - start), start - 0.5 * (samples - 1)
        row_signal, row_weight = signal[start : start + width], weight[start : start + width]
        for i in range(width):
            re[i] = row_signal[i].real
            im[i] = row_signal[i].imag
        for k in range(m):
            subtract_row(re, im, width, work.fast[k], a[k] * complex(work.slow[k, 0, row], work.slow[k, 1, row]))
        for i in range(width):
            w = row_weight[i]
            cost[i] += w * (re[i] * re[i] + im[i] * im[i])
            re[i] *= w
            im[i] *= w
        for k in range(m):
            project_row(re, im, width, work.slow[k, 0, row], work.slow[k, 1, row], time, work.sums[k])
    total = 0.0
    for i in range(LANES):
        total += cost[i]
    for k in range(m):
        reduce_lanes(work.sums[k], work.fast[k], samples, work.moments[k])
    return total


@jit
def subtract_row(re, im, width, fast, z):
    """Subtract z*fast from a row of samples."""
    zr, zi, c, s = z.real, z.imag, fast[0], fast[1]
    for i in range(width):
        re[i] -= zr * c[i] - zi * s[i]
        im[i] -= zr * s[i] + zi * c[i]


@jit
def project_row(re, im, width, c, s, time, sums):
    """Add conj(c + i s)*row, and the same times `time`, to the lane sums (4, LANES)."""
    s0, s1, s2, s3 = sums[0], sums[1], sums[2], sums[3]
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
        tr, ti = sums[2, i] + i * sums[0, i], sums[3, i] + i * sums[1, i]
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
    s, c, bottom, slope = math.sin(math.pi * x), math.cos(math.pi * x), math.sin(q * x), q * math.cos(q * x)
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
            value, first, second = value + q * term[0], first + q * term[1], second + q * term[2]
    return value, first, second


@jit
def normal_equations(window, u, a, m, work):
    """Fill matrix and gradient of the fit in (Re a, Im a, |a| u) of m lines, weighted by the window."""
    matrix, moments = work.matrix, work.moments
    for k in range(m):
        size = abs(a[k])
        pk = a[k] / size if size > 0.0 else 1.0 + 0j
        s0, s1 = complex(moments[k, 0], moments[k, 1]), complex(moments[k, 2], moments[k, 3])
        work.gradient[3 * k], work.gradient[3 * k + 1] = s0.real, s0.imag
        work.gradient[3 * k + 2] = (pk.conjugate() * s1).imag
        for j in range(k + 1):
            size = abs(a[j])
            pj = a[j] / size if size > 0.0 else 1.0 + 0j
            w0, w1, w2 = window_transform(u[k] - u[j], window)
            r, c = 3 * k, 3 * j
            matrix[r, c], matrix[r, c + 1], matrix[r, c + 2] = w0, 0.0, -pj.real * w1
            matrix[r + 1, c], matrix[r + 1, c + 1], matrix[r + 1, c + 2] = 0.0, w0, -pj.imag * w1
            matrix[r + 2, c], matrix[r + 2, c + 1] = pk.real * w1, pk.imag * w1
            matrix[r + 2, c + 2] = -(pj.conjugate() * pk).real * w2


@jit
def cholesky(matrix, factor, n, damping):
    """Factor the lower triangle of matrix + damping*diag(matrix); tiny pivots are held positive."""
    for i in range(n):
        for j in range(i + 1):
            x = matrix[i, j] * (1.0 + damping if i == j else 1.0)
            for k in range(j):
                x -= factor[i, k] * factor[j, k]
            factor[i, j] = math.sqrt(max(x, 1e-15 * matrix[i, i])) if i == j else x / factor[j, j]


@jit
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
def trial_step(work, m, damping):
    """Solve for a damped step of at most half a bin per line and write the trial lines."""
    cholesky(work.matrix, work.factor, 3 * m, damping)
    work.step[: 3 * m] = work.gradient[: 3 * m]
    substitute(work.factor, 3 * m, work.step)
    for k in range(m):
        a = work.a[0, k]
        move = work.step[3 * k + 2] / abs(a) if abs(a) > 0.0 else 0.0
        work.u[1, k] = work.u[0, k] + min(max(move, -0.5), 0.5)
        work.a[1, k] = a + complex(work.step[3 * k], work.step[3 * k + 1])


@jit
def accept(u, a, m):
    """Make the trial lines the current ones."""
    for k in range(m):
        u[0, k], a[0, k] = u[1, k], a[1, k]


@jit
def refit(signal, window, work, m, strict):
    """Fit m lines jointly (Levenberg-Marquardt); return the largest last step in bins, 0 if converged."""
    u, a = work.u, work.a
    cost = residual_moments(signal, window, u[0], a[0], m, work)
    normal_equations(window, u[0], a[0], m, work)
    damping, last = 0.0, 0.0
    for _ in range(80):
        trial_step(work, m, damping)
        top, small, last = 0.0, True, 0.0
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
        trial = residual_moments(signal, window, u[1], a[1], m, work)
        if trial <= cost * (1.0 + 1e-6) + (EPS * top) ** 2:
            accept(u, a, m)
            cost, damping = trial, (0.1 * damping if damping > 1e-4 else 0.0)
            normal_equations(window, u[0], a[0], m, work)
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e9:
                break
    return last


@jit
def update_spectrum(window, work, m):
    """Bring the residual spectrum up to date with the refitted lines."""
    top = 0.0
    for k in range(m):
        top = max(top, abs(work.a[0, k]))
    for k in range(m):
        old, new = work.a[2, k], work.a[0, k]
        change = abs(new - old) + abs(new) * min(abs(work.u[0, k] - work.u[2, k]), 1.0) * 2 * math.pi
        if change > FLOOR * top:
            reach = tail_reach(change / top, window.order)
            if old != 0.0:
                subtract_line(work.spectrum, window, work.u[2, k], -old, reach, work.lanes)
            subtract_line(work.spectrum, window, work.u[0, k], new, reach, work.lanes)
            work.u[2, k], work.a[2, k] = work.u[0, k], new


@jit
def leakage(spectrum, window, u, power, lanes):
    """Return the root of sum |residual bin|^2 bound(bin - u)^2: what a residual of this power can do to a unit line."""
    samples, height, width = spectrum.shape[1], window.envelope[0], 1.0 / window.envelope[1]
    total, square, fall = lanes[0], lanes[1], lanes[2]
    total[:] = 0.0
    reach = min(LEAKAGE_REACH, (samples - 1) // 2)
    for wrap in range(-1, 2):
        origin = u + wrap * samples
        stop = min(samples, int(origin) + reach)
        for start in range(max(0, int(origin) - reach), stop, LANES):
            end = min(start + LANES, stop)
            re, im, offset = spectrum[0, start:end], spectrum[1, start:end], start - origin
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


@jit
def noise_floor(spectrum, u, gap):
    """Return the level of |bin| between lines (mean of power -1/2), from `gap` to NOISE_REACH + gap bins around u."""
    samples, total, count = spectrum.shape[1], 0.0, 0
    for j in range(gap, min(NOISE_REACH + gap, samples // 2)):
        for k in (math.floor(u) - j, math.floor(u) + 1 + j):
            power = spectrum[0, k % samples] ** 2 + spectrum[1, k % samples] ** 2
            total += 1.0 / math.sqrt(math.sqrt(max(power, 1e-300)))
        count += 2
    return (count / total) ** 2 if count else 0.0


@jit
def spectrum_power(spectrum, lanes):
    """Return the sum of |bin|^2, in a fixed order."""
    samples, total = spectrum.shape[1], lanes[0]
    total[:] = 0.0
    for start in range(0, samples, LANES):
        re, im = spectrum[0, start : start + LANES], spectrum[1, start : start + LANES]
        for i in range(re.size):
            total[i] += re[i] * re[i] + im[i] * im[i]
    result = 0.0
    for i in range(LANES):
        result += total[i]
    return result


@jit
def error_bars(window, work, m, last, power, error):
    """Fill error (lines,) in bins: leakage of the residual times the coupling to other lines, and rounding."""
    normal_equations(window, work.u[0], work.a[0], m, work)
    cholesky(work.matrix, work.factor, 3 * m, 0.0)
    for k in range(m):
        work.step[: 3 * m] = 0.0
        work.step[3 * k + 2] = 1.0
        substitute(work.factor, 3 * m, work.step)
        coupling = math.sqrt(work.step[3 * k + 2] * work.matrix[3 * k + 2, 3 * k + 2])
        leak = leakage(work.spectrum, window, work.u[0, k], power, work.lanes)
        noise = window.envelope[3] * noise_floor(work.spectrum, work.u[0, k], window.order + 2)
        error[k] = coupling * math.hypot(leak, noise) / abs(work.a[0, k]) + 2 * EPS * max(abs(work.u[0, k]), 1.0) + last


@jit
def load_spectrum(transform, window, spectrum):
    """Split a transform (N,) into real and imaginary parts (2, N), time counted from the middle."""
    re, im, centre = spectrum[0], spectrum[1], window.centre
    for k in range(transform.size):
        z, c = transform[k], centre[k]
        re[k] = z.real * c.real - z.imag * c.imag
        im[k] = z.real * c.imag + z.imag * c.real


@jit
def beside_a_line(k, u, m, samples, reach):
    """Return whether bin k is within `reach` bins of one of m lines."""
    for j in range(m):
        d = abs(k - u[j])
        if min(d, abs(samples - d)) <= reach:
            return True
    return False


@jit
def collect(signal, window, work, lines):
    """Find and fit up to `lines` lines; return their number and the last step in bins (0 if converged).

    Far lines are taken off one by one and fitted once, at the end; a peak beside a known line may be what
    its first guess left over, so it counts as a line only after a fit of all lines so far.
    """
    samples, order, u, a = window.weight.size, window.order, work.u, work.a
    m, fitted, top, high = 0, 0, 0.0, 0.0
    while m < lines:
        k = strongest_bin(work.spectrum, work.lanes)
        if fitted < m and beside_a_line(k, u[0], m, samples, 2 * order + 8):
            refit(signal, window, work, m, False)
            update_spectrum(window, work, m)
            fitted = m
            continue
        u[0, m], a[0, m] = first_guess(work.spectrum, k, order)
        if abs(a[0, m]) <= 2 * EPS * (1.0 + high) * top:
            break
        top, high = max(top, abs(a[0, m])), max(high, abs(u[0, m]))
        a[2, m] = 0.0
        m += 1
        update_spectrum(window, work, m)
    last = 0.0
    if m > 0:
        last = refit(signal, window, work, m, True)
        update_spectrum(window, work, m)
    return m, last


@jit
def find_lines(signals, transforms, window, work, nu, amplitude, error, residual):
    """Find the lines of signals (batch, N) with windowed FFTs (batch, N): rows of nu (in bins), amplitude, error."""
    samples = signals.shape[1]
    for s in range(signals.shape[0]):
        load_spectrum(transforms[s], window, work.spectrum)
        m, last = collect(signals[s], window, work, nu.shape[1])
        power = spectrum_power(work.spectrum, work.lanes)
        error_bars(window, work, m, last, power, error[s])
        residual[s] = math.sqrt(power * window.envelope[2])
        write_sorted(work, m, samples, nu[s], amplitude[s], error[s])


@jit
def write_sorted(work, m, samples, nu, amplitude, error):
    """Write u in [-N/2, N/2) and the amplitude at the first sample, the largest first."""
    bars = work.gradient
    bars[:m] = error[:m]
    for k in range(m):
        rank = 0
        for j in range(m):
            ahead = abs(work.a[0, j]) - abs(work.a[0, k])
            if ahead > 0.0 or (ahead == 0.0 and j < k):
                rank += 1
        phasors(work.slow[0, :, :1], work.u[0, k], samples, 1, 1 - samples)
        u = work.u[0, k]
        nu[rank] = u - samples * math.floor(u / samples + 0.5)
        amplitude[rank] = work.a[0, k] * complex(work.slow[0, 0, 0], work.slow[0, 1, 0])
        error[rank] = bars[k]
    for k in range(m, nu.size):
        nu[k], amplitude[k], error[k] = 0.0, 0.0, math.inf
