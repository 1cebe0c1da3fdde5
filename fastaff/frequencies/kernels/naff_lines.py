"""Kernels of `naff`: the strongest lines of windowed signals, that are fitted together.

Frequencies u are in bins (cycles per signal length), times run from the middle of the signal:
tau_n = 2 pi (n - (N - 1)/2)/N. A line is a*exp(i u tau). The window weights w_n sum to one and are sampled so
that their transform W(d) = sum w_n cos(d tau_n) is closed, with scaled sines S(x) = N/pi sin(pi x/N):
W(d) = sin(pi d)/(pi S(d)) prod_{i=1..p} S(i)^2/(S(i)^2 - S(d)^2). It falls like d^-(2p+1) beyond bin p.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...engine.jit import LANES, jit
from ...engine.kernels.stepping import blank
from .naff_spectrum import apart, first_guess, leakage, noise_floor, spectrum_power, start_phase, update_spectrum

EPS = 2.220446049250313e-16

CUT = 16
"""Amplitude, in floors, up to which a peak may be the rest of cut tails and is no line."""


class NaffWindow(NamedTuple):
    """Tables of one window: order p >= 0 over N samples."""

    order: int
    weight: Any  # (N,) w_n, sum 1
    centre: Any  # (N,) complex, moves the time origin of FFT bin k to the middle
    zero: int  # index of j = 0 in the next two
    sine: Any  # (2 zero + 1,) (-1)^j N/pi sin(pi j/N), j = -zero ... zero, zero = N//2 + 2p + 10
    cosine: Any  # the same with cos
    fourier: Any  # (p + 1,) W(j) at whole bins: w_n = (fourier[0] + 2 sum_j fourier[j] cos(j tau_n))/N
    floor: float  # amplitude, relative to the largest line's, at which the tails of lines are cut
    envelope: Any  # (4,) height, width of the bound of |W'|/sum w_n tau_n^2; 1/(N sum w_n^2); noise to error of u


class NaffScratch(NamedTuple):
    """Scratch memory for one signal at a time."""

    spectrum: Any  # (2, N) transform of the windowed signal without the lines, real and imaginary parts
    top: Any  # (1,) amplitude of the largest line so far
    lanes: Any  # (4, LANES)
    matrix: Any  # (3 lines, 3 lines)
    factor: Any  # (3 lines, 3 lines)
    gradient: Any  # (3 lines,)
    step: Any  # (3 lines,)
    u: Any  # (3, lines) bins: current, trial, already subtracted from the spectrum
    a: Any  # (3, lines) complex amplitudes in the middle of the signal
    who: Any  # (lines,) lines that change
    coupling: Any  # (lines,) factor by which neighbours of a line widen its error


def workspace(samples: int, lines: int) -> NaffScratch:
    """Allocate scratch memory for signals of `samples` and up to `lines` lines."""
    full = np.zeros
    return NaffScratch(
        spectrum=full((2, samples)),
        top=full(1),
        lanes=blank(4).reshape(4, LANES),
        matrix=full((3 * lines, 3 * lines)),
        factor=full((3 * lines, 3 * lines)),
        gradient=full(3 * lines),
        step=full(3 * lines),
        u=full((3, lines)),
        a=full((3, lines), np.complex128),
        who=full(lines, np.int64),
        coupling=full(lines),
    )


@jit
def error_bars(window, work, m, last, power, error):
    """Fill error (lines,) in bins: leakage of the residual times the coupling to other lines, and rounding."""
    for k in range(m):
        leak = leakage(work.spectrum, window, work.u[0, k], power, work.lanes)
        noise = window.envelope[3] * noise_floor(work.spectrum, work.u[0, k], window.order + 2)
        size = math.hypot(leak, noise) / abs(work.a[0, k])
        error[k] = work.coupling[k] * size + 2 * EPS * max(abs(work.u[0, k]), 1.0) + last


@jit
def lines_beside(window, work, m, k):
    """Write to work.who which of m lines are beside bin k; return their number."""
    samples = window.weight.size
    count = 0
    for j in range(m):
        if abs(apart(k, math.floor(work.u[0, j]), samples)) <= 2 * window.order + 8:
            work.who[count] = j
            count += 1
    return count


@jit
def take_line(window, work, m, k, top, high):
    """Subtract the peak at bin k from the spectrum as line number m; return whether it is a line: larger than rounding
    and than the rest of cut tails of lines up to the amplitude `top` and the place `high`.
    """
    u = work.u
    a = work.a
    u[0, m], a[0, m] = first_guess(work.spectrum, k, window)
    if not abs(a[0, m]) > max(2 * EPS * (1.0 + high), CUT * window.floor) * top or not abs(a[0, m]) < math.inf:
        return False
    u[2, m] = u[0, m]
    a[2, m] = 0.0
    work.who[0] = m
    update_spectrum(window, work, work.who, 1)
    return True


@jit
def write_lines(window, work, m, last, nu, amplitude, error):
    """Write the m lines, the largest first, with their error bars; return the root mean square of the residual."""
    power = spectrum_power(work.spectrum, work.lanes)
    error_bars(window, work, m, last, power, error)
    write_sorted(work, m, window.weight.size, nu, amplitude, error)
    return math.sqrt(power * window.envelope[2])


@jit
def write_sorted(work, m, samples, nu, amplitude, error):
    """Write u in [-N/2, N/2) and the amplitude at the first sample, the largest first."""
    bars = work.gradient
    for k in range(m):  # a copy by slices takes a second to compile
        bars[k] = error[k]
    for k in range(m):
        rank = 0
        for j in range(m):
            ahead = abs(work.a[0, j]) - abs(work.a[0, k])
            if ahead > 0.0 or (ahead == 0.0 and j < k):
                rank += 1
        u = work.u[0, k]
        nu[rank] = u - samples * math.floor(u / samples + 0.5)
        turn = start_phase(u, 1 - samples, samples)
        amplitude[rank] = work.a[0, k] * complex(math.cos(turn), math.sin(turn))
        error[rank] = bars[k]
    for k in range(m, nu.size):
        nu[k] = 0.0
        amplitude[k] = 0.0
        error[k] = math.inf
