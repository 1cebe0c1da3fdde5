"""Numerical analysis of fundamental frequencies: the strongest lines of many signals at once."""

from __future__ import annotations

import functools
import math
import threading
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, an_array, checked_callback, positive, whole
from ..core.status import counted
from ..engine.threads import checked_threads, together, works
from ..results.progress import says_progress
from ..results.result import Result, along
from .kernels.naff_fit import fit_lines, sums_of
from .kernels.naff_lines import NaffWindow, workspace
from .windows import tabulated

CHUNK_SAMPLES = 65536  # samples in work per thread: 1 MiB, stays in L2
MAX_ORDER = 12
FLOOR = 1e-17
"""Amplitude at which tails of lines are cut, relative to the largest line's: below the rounding of the transform."""
MARGIN = 10
"""Bins beyond half the transform, and twice the order, that tables of lines have."""
SAFE_EXPONENT = 300  # signals beyond 2^+-300 are scaled by a power of two, so that squares stay finite


@dataclass(frozen=True)
class FrequencyLines(Result, axis="signal"):
    r"""Spectral lines of each signal, the strongest first.

    Attributes
    ----------
    nu : ndarray, shape (..., lines)
        Frequencies in cycles per unit time; 0 for a missing line.
    amplitude : ndarray of complex, shape (..., lines)
        Amplitudes in units of the signal; 0 for a missing line.
    error : ndarray, shape (..., lines)
        Error estimates of `nu`; inf for a missing line.
    residual : ndarray, shape (...)
        Root mean square of the signal without its lines.

    Notes
    -----
    A signal is :math:`\sum_k a_k e^{2\pi i \nu_k t}`. Signals are the leading axes, as in the array that was analysed.

    References
    ----------
    Laskar (1990) Icarus 88, 266.
    """

    nu: Annotated[np.ndarray, along("signal", "line", unit="cycles/time")]
    """(..., lines) frequencies in cycles per unit time, signed, in [-1/(2 dt), 1/(2 dt))."""
    amplitude: Annotated[np.ndarray, along("signal", "line")]
    """(..., lines) complex amplitudes at the first sample (t = 0)."""
    error: Annotated[np.ndarray, along("signal", "line", unit="cycles/time")]
    """(..., lines) error bars of nu, about two standard deviations; inf where a line is missing."""
    residual: Annotated[np.ndarray, along("signal")]
    """(...) root mean square of the rest without the lines, weighted by the squared window."""

    def summary(self) -> str:
        """Return one line with the numbers of signals and lines, and with the strongest line of a single signal.

        Returns
        -------
        str
            Summary.
        """
        found = self.nu.reshape(-1, self.nu.shape[-1])
        said = f"{counted(len(found), 'signal')} of {counted(found.shape[1], 'line')}"
        return f"{said}; the strongest at nu = {found[0, 0]:.9g}" if len(found) == 1 else said

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu in radians per unit time, shape (..., lines)."""
        return 2 * np.pi * self.nu


@says_progress
@inserts_parameters
def naff(
    signal: ArrayLike,
    dt: float,
    *,
    lines: int,
    window_order: int = 2,
    threads: int | None = None,
    callback: Callback | None = None,
) -> FrequencyLines:
    r"""Compute the strongest spectral lines of each signal in a joint fit.

    Parameters
    ----------
    signal : array_like, shape (..., samples)
        Complex or real samples at equal intervals. A real signal has its lines in pairs of opposite frequencies.
    dt : float
        Positive interval between samples, in units of time.
    lines : int
        Positive number of lines of each signal. It needs ``4*(lines + window_order)`` samples or more.
    window_order : int, default 2
        Order p of the window :math:`(1 + \cos)^p`, from 0 (no window) to 12. Higher orders suppress distant lines that
        are not fitted, but widen each line to p + 1 bins and pass more noise.
    {threads}
    {callback}

    Returns
    -------
    `FrequencyLines`
        Frequencies, amplitudes and error estimates of the lines, and the residual of each signal.

    Raises
    ------
    ValueError
        If a value or shape is out of its range, or a sample is not finite.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the result so far in ``.partial``. Signals left out have no lines and the residual NaN.

    Notes
    -----
    - Method: a stationary point of :math:`\sum_n \chi_p(t_n) |f(t_n) - \sum_k a_k e^{2\pi i \nu_k t_n}|^2` for free
      :math:`a_k, \nu_k`, started from peaks of the windowed transform.
    - Accuracy: exact to round-off if the signal has at most `lines` lines, 1/T apart or more. An unfitted line D bins
      away and b/a as large shifts :math:`\nu` by :math:`(p!)^2 (b/a) D^{-(2p+1)}/T`.
    - Limits: lines closer than one bin count as one, and `error` cannot include this. Lines below
      :math:`2\epsilon|\nu|T` of the largest are round-off and count as missing.
    - Cost: one FFT, and 20 flops a line and sample for each of one or two iterations. Memory: 5 MiB a thread, or 6
      signals.

    References
    ----------
    Laskar (1990) Icarus 88, 266; Laskar, Froeschle, Celletti (1992) Physica D 56, 253; Laskar (1999), Introduction to
    frequency map analysis, NATO ASI C 533, 134.

    Examples
    --------
    >>> t = 0.1 * np.arange(256)
    >>> found = fa.naff(np.exp(2j * np.pi * 0.31 * t) + 0.5 * np.exp(-2j * np.pi * 0.7 * t), 0.1, lines=2)
    >>> found.nu.round(9), abs(found.amplitude).round(9)
    (array([ 0.31, -0.7 ]), array([1. , 0.5]))
    """
    checked_callback(callback)
    signal, dt, lines, order = _checked(signal, dt, lines, window_order)
    shape = signal.shape[:-1]
    samples = signal.shape[-1]
    flat = signal.reshape(-1, samples) if signal.size else np.empty((0, samples))
    batch = len(flat)
    nu = np.empty((batch, lines))
    error = np.empty((batch, lines))
    residual = np.empty(batch)
    amplitude = np.empty((batch, lines), complex)
    finished = np.zeros(batch, bool)
    rows = max(1, CHUNK_SAMPLES // samples)
    chunks = [slice(start, min(start + rows, batch)) for start in range(0, batch, rows)]
    workers = 1 if works() else max(1, min(len(chunks), checked_threads(threads)))
    stop = threading.Event()

    def analyse(worker: int, callback: Callback | None = None) -> None:
        scratch = _Scratch(min(rows, batch), _window(samples, order), lines)
        for chunk in chunks[worker::workers]:
            if stop.is_set():
                return
            part = FrequencyLines(nu[chunk], amplitude[chunk], error[chunk], residual=residual[chunk])
            scratch.analyse(flat[chunk], chunk.start, part)
            finished[chunk] = True
            if callback is not None:
                callback(float(finished.mean()))

    def found() -> FrequencyLines:
        missing = ~finished
        nu[missing] = 0.0
        amplitude[missing] = 0.0
        error[missing] = np.inf
        residual[missing] = np.nan
        unit = samples * dt
        full = (*shape, lines)
        cycles = (nu / unit).reshape(full)
        bars = (error / unit).reshape(full)
        return FrequencyLines(cycles, amplitude.reshape(full), bars, residual=residual.reshape(shape))

    with partial_result_on_interrupt("naff", found):
        if workers == 1:
            analyse(0, callback)
        else:
            calls = [functools.partial(analyse, worker) for worker in range(workers)]
            together(calls, stop.set, lambda: callback is not None and callback(float(finished.mean())))
    return found()


class _Scratch:
    """Memory of one thread, kept over its chunks."""

    def __init__(self, rows: int, window: NaffWindow, lines: int):
        samples = window.weight.size
        self.transforms = np.empty((rows, samples), np.complex128)
        self.window = window
        self.work = workspace(samples, lines)
        self.signals, self.sums = np.empty((rows, samples), np.complex128), sums_of(samples, lines)

    def analyse(self, rows: np.ndarray, first: int, result: FrequencyLines) -> None:
        """Fill `result`, nu and error in bins, from `rows` (rows, samples), the first being signal number `first`."""
        transforms = self.transforms[: len(rows)]
        weight = self.window.weight
        signals = self.signals[: len(rows)]
        signals[...] = rows
        with np.errstate(invalid="ignore", over="ignore"):
            np.multiply(rows, weight, out=transforms)
        floats = transforms.view(np.float64)
        peak = np.maximum(floats.max(axis=1), -floats.min(axis=1))
        if not np.isfinite(peak).all():
            row, n = np.argwhere(~np.isfinite(rows))[0]
            raise ValueError(f"signal must be finite, got {rows[row, n]} at sample {n} of signal {first + row}")
        exponent = np.frexp(peak)[1]
        exponent[np.abs(exponent) <= SAFE_EXPONENT] = 0
        for row in np.flatnonzero(exponent):
            scaled = np.ldexp(np.array(rows[row], complex).view(np.float64), -exponent[row]).view(complex)
            np.multiply(scaled, weight, out=transforms[row])
            signals[row] = scaled
        np.fft.fft(transforms, axis=-1, out=transforms)
        lines = result.nu, result.amplitude, result.error, result.residual
        fit_lines(signals, transforms, self.window, self.work, self.sums, *lines)
        with np.errstate(over="ignore"):  # an amplitude may exceed the largest float by the root of 2
            for row in np.flatnonzero(exponent):
                amplitude = result.amplitude[row].view(np.float64)
                amplitude[:] = np.ldexp(amplitude, exponent[row])
                result.residual[row] = np.ldexp(result.residual[row], exponent[row])


@functools.partial(tabulated, most=8)
def _window(samples: int, order: int) -> NaffWindow:
    """Tabulate the window of `order` over `samples`, its transform at whole bins, and the bounds of its tails."""
    times = 2 * np.pi * (np.arange(samples) - (samples - 1) / 2) / samples
    weight = np.ones(samples)
    for i in range(order):
        weight *= np.cos(times) + math.cos((2 * i + 1) * math.pi / samples)
        weight[[i, -1 - i]] = 0.0
    weight /= weight.sum()
    zero = samples // 2 + MARGIN + 2 * order
    k = np.arange(samples)
    j = np.arange(-zero, zero + 1)
    scale = np.where(j % 2, -samples / np.pi, samples / np.pi)
    curvature = np.sum(weight * times**2)
    bins = np.linspace(0, order + 2, 8 * order + 24)
    height = max(abs(np.sum(weight * times * np.sin(d * times))) for d in bins) / curvature
    width = (math.factorial(order) ** 2 / (curvature * height)) ** (1 / (2 * order + 1))
    power = np.sum(weight**2)
    # three standard deviations; 1.5 turns noise_floor into the root mean square of white noise
    noise = 3 * 1.5 * math.sqrt(np.sum((weight * times) ** 2) / (2 * power)) / curvature
    return NaffWindow(
        order=order,
        weight=weight,
        centre=np.exp(1j * np.pi * (k * (samples - 1) % (2 * samples)) / samples),
        zero=zero,
        sine=scale * np.sin(np.pi * j / samples),
        cosine=scale * np.cos(np.pi * j / samples),
        fourier=np.array([np.sum(weight * np.cos(i * times)) for i in range(order + 1)]),
        floor=FLOOR,
        envelope=np.array([height, width, 1 / (samples * power), noise]),
    )


def _checked(signal, dt, lines, window_order) -> tuple[np.ndarray, float, int, int]:
    """Return the arguments of `naff` in their own types, or raise."""
    array = an_array("signal", signal)
    if array.dtype.kind not in "fiuc":
        raise TypeError(f"signal must be a real or complex array, got dtype {array.dtype}")
    if array.ndim == 0:
        raise ValueError("signal must have shape (..., samples), got a scalar")
    dt = positive("dt", dt)
    lines = whole("lines", lines, 1)
    samples = array.shape[-1]
    order = whole("window_order", window_order, 0, MAX_ORDER)
    if samples < 4 * (lines + order):
        raise ValueError(
            f"signal must have at least 4*(lines + window_order) = {4 * (lines + order)} samples, got {samples}"
        )
    return array, dt, lines, order
