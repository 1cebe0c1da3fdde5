"""Kernels of `naff`: find the strongest lines of windowed signals and fit them together.

Frequencies u are in bins (cycles per signal length), times run from the middle of the signal:
tau_n = 2 pi (n - (N - 1)/2)/N. A line is a*exp(i u tau). The window weights w_n sum to one and are sampled so
that their transform W(d) = sum w_n cos(d tau_n) is closed, with scaled sines S(x) = N/pi sin(pi x/N):
W(d) = sin(pi d)/(pi S(d)) prod_{i=1..p} S(i)^2/(S(i)^2 - S(d)^2). It falls like d^-(2p+1) beyond bin p.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..compile.jit import LANES, jit
from .naff_fit import cholesky, normal_equations, phasors, refit, substitute
from .naff_spectrum import (
    first_guess,
    leakage,
    load_spectrum,
    noise_floor,
    spectrum_power,
    strongest_bin,
    subtract_line,
    tail_reach,
)

FLOOR = 1e-17  # relative amplitude at which the tail of a line is cut, below the rounding of the transform
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
        full((2, samples)),
        full((4, LANES)),
        full((lines, 2, LANES)),
        full((lines, 2, rows)),
        full((lines, 4, LANES)),
        full((lines, 4)),
        full((3 * lines, 3 * lines)),
        full((3 * lines, 3 * lines)),
        full(3 * lines),
        full(3 * lines),
        full((3, lines)),
        full((3, lines), np.complex128),
    )


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
        if not abs(a[0, m]) > 2 * EPS * (1.0 + high) * top or not abs(a[0, m]) < math.inf:
            break
        top, high = max(top, abs(a[0, m])), max(high, abs(u[0, m]))
        u[2, m], a[2, m] = 0.0, 0.0  # nothing taken off yet, nor left of the signal before
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
