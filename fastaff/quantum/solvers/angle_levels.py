"""Levels of an angle in a periodic potential: Hill's equation -X'' + W X = K X, by Fourier series.

Mathieu's equation is W = 2 q cos(2 eta). Functions of period 2 pi are single-valued on the body; those that change sign
over 2 pi live on its double cover.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...systems.models.functions import Zero
from ..states.angle_states import AngleFunction
from .convergence import POWERS, ROUGH, until_equal
from .separable import check_size
from .singular_ends import count_top, sampled

SAMPLES = 1 << 15
"""Points of the circle at which a potential is sampled: its Fourier coefficients are exact for features of 1e-3."""
SMOOTH = 1e-11
"""Largest Fourier coefficient of high order, relative to the potential, of a smooth one."""
PERIODIC = 1e-9
"""Difference of values 2 pi apart, relative to the potential, that is rounding."""
CHECKED = 64
"""Angles at which the period is checked."""


class AngleLevels(NamedTuple):
    """The lowest levels of an angle, ascending: K = 2 mu c/hbar^2 of the separation constant c, its error (levels,),
    the functions, and the size of the basis.
    """

    K: np.ndarray
    error: np.ndarray
    functions: tuple[AngleFunction, ...]
    size: int

    @property
    def periodic(self) -> np.ndarray:
        """Return whether each function has the period 2 pi (levels,)."""
        return np.array([not function.changes_sign for function in self.functions])


def angle_levels(
    name: str, V: Any, count: int, hbar: float, mu: float, tolerance: float, single_valued: bool
) -> AngleLevels:
    """Solve -(hbar^2/2 mu) X'' + V X = c X for functions of period 2 pi, or, unless `single_valued`, of period 4 pi."""
    W = _samples(name, V) * (2 * mu / hbar**2)
    parts = [_levels(name, V, W, count, tolerance, shift) for shift in ((0.0,) if single_valued else (0.0, 0.5))]
    K, error = (np.concatenate([getattr(part, field) for part in parts]) for field in ("K", "error"))
    functions = [function for part in parts for function in part.functions]
    order = np.argsort(K, kind="stable")[:count]
    return AngleLevels(K[order], error[order], tuple(functions[k] for k in order), max(part.size for part in parts))


def angles(count: int) -> np.ndarray:
    """Return the middles of equal parts of (-pi, pi)."""
    return (np.arange(count) + 0.5) * 2 * np.pi / count - np.pi


def _samples(name: str, V: Any) -> np.ndarray:
    """Return V at SAMPLES angles; raises ValueError for one that is not finite or has no period 2 pi."""
    values = sampled(V.value, angles(SAMPLES))
    if not np.isfinite(values).all():
        place = angles(SAMPLES)[np.flatnonzero(~np.isfinite(values))[0]]
        raise ValueError(f"{name} must be finite at all angles, got an infinite value at {place:.4g}")
    some = angles(CHECKED) + 0.01
    change = np.abs(sampled(V.value, some + 2 * np.pi) - sampled(V.value, some))
    if not change.max() <= PERIODIC * np.abs(values).max():
        worst = int(np.argmax(change))
        raise ValueError(f"{name} must have the period 2 pi, got a change by {change[worst]:.3g} at {some[worst]:.4g}")
    return values


def _levels(name: str, V: Any, W: np.ndarray, count: int, tolerance: float, shift: float) -> AngleLevels:
    """Return the levels of functions with the wave numbers shift, shift + 1, ..."""
    low = float(W.min())
    height = float(W.max()) - low
    if isinstance(V, Zero) or height == 0.0:
        waves = _wave_numbers(count, shift)[:count]
        functions = tuple(_function(np.eye(count)[k], shift) for k in range(count))
        return AngleLevels(low + waves**2, np.zeros(count), functions, count)
    spectrum = _coefficients(W)
    rough = np.abs(spectrum[spectrum.size // 4 :]).max() > SMOOTH * height / SAMPLES**0.5
    first = int(1.3 * _needed(W, count)) + 24
    check_size(name, first, count)

    def solve(n: int, _: float) -> tuple[None, tuple[np.ndarray, np.ndarray]]:
        waves = _wave_numbers(n, shift)
        matrix = _matrix(spectrum, n, shift)
        vectors = np.linalg.eigh(matrix + np.diag(waves**2))[1][:, : count + 1]
        # Rayleigh quotients: the squares of the wave numbers are large, and their rounding is in the eigenvalues.
        values = (waves[:, None] ** 2 * vectors**2).sum(axis=0) + (vectors * (matrix @ vectors)).sum(axis=0)
        order = np.argsort(values, kind="stable")
        return None, (values[None, order], vectors[None][..., order])

    powers = POWERS[POWERS <= ROUGH] if rough else POWERS[POWERS > ROUGH]
    _, (values, vectors), error, size = until_equal(solve, first, 1.0, 1.0, count, tolerance, powers)
    functions = tuple(_function(vectors[0, :, k], shift) for k in range(count))
    sampling = _sampling_errors(W, vectors[0, :, :count], functions, shift) if rough else 0.0
    return AngleLevels(values[0, :count], error[0] + sampling, functions, size)


def _coefficients(W: np.ndarray) -> np.ndarray:
    """Return the complex Fourier coefficients of samples; they begin next to -pi."""
    spectrum = np.fft.rfft(W) / SAMPLES
    return spectrum * np.exp(1j * np.arange(spectrum.size) * np.pi * (1 - 1 / SAMPLES))


def _sampling_errors(
    W: np.ndarray, vectors: np.ndarray, functions: tuple[AngleFunction, ...], shift: float
) -> np.ndarray:
    """Return the errors (levels,) of the mean of W X^2 over the samples: at a jump half of it, elsewhere the change by
    half of the samples.
    """
    halves = _matrix(_coefficients(np.where(np.arange(SAMPLES) % 2, W, -W)), len(vectors), shift)
    error = np.abs((vectors * (halves @ vectors)).sum(axis=0))
    change = np.abs(np.diff(W, append=W[:1]))
    jumps = np.maximum(change - 2 * np.maximum(np.roll(change, 1), np.roll(change, -1)), 0.0)
    places = np.flatnonzero(jumps > PERIODIC * (W.max() - W.min()))
    if places.size:
        density = np.array([function(angles(SAMPLES)[places]) ** 2 for function in functions])
        error = error + density @ jumps[places] / (2 * SAMPLES)
    return error


def _needed(W: np.ndarray, count: int) -> float:
    """Return the number of waves, sines and cosines, up to the energy of the highest level: its semiclassical one."""
    some = W - W.min()
    top = count_top(lambda top: 2 * float(np.sqrt(np.maximum(top - some, 0.0)).mean()), 0.0, 1.0, count + 1)
    return 2 * float(np.sqrt(top))


def _wave_numbers(n: int, shift: float) -> np.ndarray:
    """Return the wave numbers (n,) of 1, cos, sin, cos, ... or, with the shift 1/2, of cos, sin, cos, ..."""
    k = np.arange(n)
    return (k + 1) // 2 if shift == 0.0 else k // 2 + shift


def _matrix(spectrum: np.ndarray, n: int, shift: float) -> np.ndarray:
    """Return the matrix (n, n) of W between orthonormal real waves, from its complex Fourier coefficients."""
    waves = _wave_numbers(n, shift)
    sine = _sines(n, shift)
    total = np.rint(waves[:, None] + waves).astype(int)
    apart = np.rint(waves[:, None] - waves).astype(int)
    cosine_of = spectrum.real
    sine_of = -spectrum.imag
    both = np.where(sine[:, None], -1.0, 1.0) * cosine_of[total]
    same = cosine_of[np.abs(apart)] + both
    # cos(j x) sin(k x) = [sin((j + k) x) + sin((k - j) x)]/2, the wave of the sine second
    toward = np.where(sine[:, None], apart, -apart)
    mixed = sine_of[total] + np.sign(toward) * sine_of[np.abs(toward)]
    matrix = np.where(sine[:, None] == sine, same, mixed)
    if shift == 0.0:  # the constant is 1, not sqrt(2) cos(0)
        matrix[0] *= np.sqrt(0.5)
        matrix[:, 0] *= np.sqrt(0.5)
    return matrix


def _sines(n: int, shift: float) -> np.ndarray:
    """Return whether each wave (n,) is a sine."""
    k = np.arange(n)
    return (k % 2 == 0) & (k > 0) if shift == 0.0 else k % 2 == 1


def _function(c: np.ndarray, shift: float) -> AngleFunction:
    """Return the function of coefficients c (n,), of the sign of its largest one."""
    place = int(np.argmax(np.abs(c)))
    sign = -1.0 if c[place] < 0 else 1.0
    return AngleFunction(shift != 0.0, tuple((sign * c).tolist()))
