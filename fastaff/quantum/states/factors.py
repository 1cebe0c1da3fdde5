"""Normalised factors of wave functions in one coordinate: f_alpha, f_beta, f_r, f_rho, f_vartheta in closed form.

A factor is a value that is called on its coordinate and knows its measure and a Gauss rule for it; a product state asks
for nothing else, so a factor found numerically takes the same place.

| factor | coordinate | measure | closed form (up to its constant) |
|---|---|---|---|
| PlaneFactor(n, s, kappa) | alpha or beta | x dx | x^s e^(-kappa x^2/2) L_n^s(kappa x^2) |
| RadialFactor(n, s, kappa) | r | r dr | r^((s - 1)/2) e^(-kappa r/2) L_n^s(kappa r) |
| AngleFactor(n, a, b) | vartheta in [0, pi] | sin(vartheta) dvartheta | cos^a(vartheta/2) sin^b(vartheta/2)
P_n^(a,b)(-cos vartheta) |
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...core.numbers import fits, nonnegative, numbers, positive, shown
from ...engine.packing import run_points
from ..kernels.laguerre_jacobi import jacobi_values, laguerre_values
from .symmetry import whole_quantum


class Factor(Protocol):
    """The methods of the factors of a product state: values, and nodes and weights of a rule for the factor's measure.

    A factor of vartheta also has `of_squares`, its values at sin^2(vartheta/2) and cos^2(vartheta/2).
    """

    @property
    def degree(self) -> int:
        """Return n, the degree: n + 1 nodes are enough for the norm."""

    def __call__(self, x: ArrayLike, /) -> np.ndarray:
        """Return f(x)."""

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes and weights: the integral of f^2 g m dx is the sum of weight*f^2*g."""


def quantum_number(name: str, value: Any) -> int:
    """Return a quantum number of at least 0 as an int; whole floats are converted."""
    number = whole_quantum(name, value)
    if number < 0:
        raise ValueError(f"{name} must be at least 0, got {shown(value)}")
    fits(name, 8, number)
    return number


def _coordinate(name: str, x: ArrayLike, top: float = np.inf) -> np.ndarray:
    given = numbers(name, x)
    values = np.ascontiguousarray(given).reshape(given.shape)
    if values.size and not (values.min() >= 0 and values.max() <= top):
        raise ValueError(f"{name} must lie in [0, {top:.3g}] and be no NaN, got {values.min()} to {values.max()}")
    return values


def _excess(x: float) -> float:
    """Return ln Gamma(x + 1) - x ln x + x, without the large terms: 0 at 0, ln(2 pi x)/2 + 1/(12 x) - ... far from
    it.
    """
    if x == 0:
        return 0.0
    if x < 20:
        return math.lgamma(x + 1) - x * math.log(x) + x
    w = 1 / (x * x)
    return math.log(2 * math.pi * x) / 2 + (1 / 12 - w * (1 / 360 - w * (1 / 1260 - w * (1 / 1680 - w / 1188)))) / x


def _times_log(x: float, y: float) -> float:
    """Return x ln y, 0 for x = 0."""
    return x * math.log(y) if x else 0.0


def _laguerre_ladder(n: int, s: float) -> tuple[np.ndarray, np.ndarray]:
    k = np.arange(n)
    return k / (k + 1 + s), 1 / (k + 1 + s)


def _log_binomial(n: int, s: float) -> float:
    """Return ln C(n + s, n)."""
    spread = n * math.log1p(s / n) + s * math.log1p(n / s) if n and s else 0.0
    return _excess(n + s) - _excess(n) - _excess(s) + spread


def _laguerre_constants(n: int, s: float, h: float, log_front: float) -> np.ndarray:
    """Constants (c, h, y0, cut) of front*y^h e^(-y/2) R_n(y) y^(-s/2), R_n orthonormal in dy: y0 = 2 h is the weight's
    peak.

    c: the logarithms at the peak, large terms cancelled by hand; h is s/2 or (s - 1)/2.
    """
    c = log_front + _log_binomial(n, s) / 2 - _excess(2 * h) / 2 - (math.log(s) / 2 if s > 2 * h else 0.0)
    return np.array([c, h, 2 * h if h > 0 else 0.0, 2 * (4 * n + 2 * s + 2) + 3000])


def _laguerre(n: int, s: float, h: float, log_front: float, y: np.ndarray) -> np.ndarray:
    return _laguerre_values((*_laguerre_ladder(n, s), _laguerre_constants(n, s, h, log_front)), 1.0, False, y)


def _laguerre_values(
    tables: tuple[np.ndarray, np.ndarray, np.ndarray], kappa: float, squared: bool, x: np.ndarray
) -> np.ndarray:
    out = np.empty(x.shape)
    run_points(laguerre_values, (*tables, float(kappa), squared, x.reshape(-1), out.reshape(-1)), x.size)
    return out


def _laguerre_rule(order: int, s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Gauss nodes y and their weights for the integral of functions that carry their own weight y^s e^-y, dy."""
    from scipy.linalg import eigh_tridiagonal

    k = np.arange(order)
    y = eigh_tridiagonal(2 * k + s + 1, np.sqrt(k[1:] * (k[1:] + s)), eigvals_only=True)
    y = np.abs(y)
    for _ in range(2):  # Newton: y L' = N L_N - (N + s) L_(N-1), where rounding of the matrix left the small nodes
        here, before = (_laguerre(n, s, s / 2, 0.0, y) for n in (order, order - 1))
        here = here * math.sqrt((order + s) / order)
        y = y * (1 - here / (order * here - (order + s) * before))
    return y, y / (order * (order + s) * _laguerre(order - 1, s, s / 2, 0.0, y) ** 2)


@dataclass(frozen=True)
class _Oscillation:
    """Quanta n, index s and kappa = sqrt(C mu)/hbar of a factor of an oscillator."""

    n: int
    s: float
    kappa: float

    def __post_init__(self) -> None:
        quantum_number("n", self.n)
        nonnegative("s", self.s)
        positive("kappa", self.kappa)

    @property
    def degree(self) -> int:
        """Return n."""
        return self.n


class PlaneFactor(_Oscillation):
    """Oscillator of one plane, f_alpha or f_beta: n quanta, index s (angular momentum and wall), kappa = sqrt(C
    mu)/hbar.

    f(x) = kappa^((1+s)/2) sqrt(2 Gamma(n+s+1)/n!)/Gamma(s+1) x^s e^(-kappa x^2/2) 1F1(-n; 1+s; kappa x^2), positive
    near x = 0, integral f^2 x dx = 1. Error below 1e-12 of the maximum for n, s <= 500.
    Source: Martens & Slawianowski, section 5, f_alpha and f_beta (the norm is derived).
    """

    @cached_property
    def _tables(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return *_laguerre_ladder(self.n, self.s), _laguerre_constants(
            self.n, self.s, self.s / 2, math.log(2 * self.kappa) / 2
        )

    def __call__(self, x: ArrayLike) -> np.ndarray:
        """Return f (...) at radii x (...) >= 0."""
        return _laguerre_values(self._tables, self.kappa, True, _coordinate("radius", x))

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return Gauss nodes and weights, exact for f^2 times polynomials of x^2 of degree < 2 (order - n)."""
        y, weights = _laguerre_rule(order, self.s)
        return np.sqrt(y / self.kappa), weights / (2 * self.kappa)


class RadialFactor(_Oscillation):
    """Dilatation factor f_r of n quanta, index s = 2 epsilon >= 0, kappa = sqrt(C mu)/hbar; `of_rho` is f_rho.

    f(r) = kappa^((1+s)/2) sqrt(Gamma(n+s+1)/n!)/Gamma(s+1) r^((s-1)/2) e^(-kappa r/2) 1F1(-n; 1+s; kappa r), positive
    near r = 0, integral f^2 r dr = 1; infinite at r = 0 for s < 1, where shear attracts. Error as `PlaneFactor`.
    Source: Martens & Slawianowski, section 5, f_r (the norm is derived).
    """

    @cached_property
    def _tables(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        weak = self.s < 1  # the kernel takes no negative power of r: `__call__` does
        front = math.log(self.kappa) + ((math.log(self.s or 1.0) - math.lgamma(self.s + 1)) / 2 if weak else 0.0)
        return *_laguerre_ladder(self.n, self.s), _laguerre_constants(
            self.n, self.s, 0.0 if weak else (self.s - 1) / 2, front
        )

    def __call__(self, x: ArrayLike) -> np.ndarray:
        """Return f_r (...) at r = x (...) >= 0."""
        r = _coordinate("r", x)
        out = _laguerre_values(self._tables, self.kappa, False, r)
        if self.s < 1:
            with np.errstate(divide="ignore"):
                out *= (self.kappa * r) ** ((self.s - 1) / 2)
        return out

    def of_rho(self, rho: ArrayLike) -> np.ndarray:
        """Return f_rho = sqrt2 f_r(rho^2), with integral f_rho^2 rho^3 drho = 1."""
        return math.sqrt(2) * self(np.square(_coordinate("rho", rho)))

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return Gauss nodes and weights, exact for f^2 times polynomials of r of degree < 2 (order - n)."""
        y, weights = _laguerre_rule(order, self.s)
        return y / self.kappa, weights * y / self.kappa**2


@dataclass(frozen=True)
class AngleFactor:
    """Shear factor f_vartheta of n quanta, index a of the end vartheta = pi (alpha = 0), b of vartheta = 0 (beta = 0).

    f = N cos^a(v/2) sin^b(v/2) 2F1(-n, 1+n+a+b; 1+a; cos^2(v/2)), positive near v = pi, integral f^2 sin(v) dv = 1,
    with N = ((1+a)_n/n!) sqrt((2n+a+b+1) n! Gamma(n+a+b+1)/(2 Gamma(n+a+1) Gamma(n+b+1))). Error as `PlaneFactor`.
    Source: Martens & Slawianowski, section 5, f_vartheta with chi = a, gamma = b (the norm is derived).
    """

    n: int
    a: float
    b: float

    def __post_init__(self) -> None:
        quantum_number("n", self.n)
        nonnegative("a", self.a)
        nonnegative("b", self.b)

    @cached_property
    def _tables(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        ends = [_jacobi_end(self.n, *pair) for pair in ((self.b, self.a), (self.a, self.b))]
        ends[0][2][5] = (-1.0) ** self.n
        u, w, constants = (np.array(rows) for rows in zip(*ends, strict=True))
        return u, w, constants

    def __call__(self, x: ArrayLike) -> np.ndarray:
        """Return f (...) at vartheta = x (...) in [0, pi]."""
        half = _coordinate("vartheta", x, np.pi) / 2
        return self.of_squares(np.sin(half) ** 2, np.cos(half) ** 2)

    def of_squares(self, sine: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Return f of sin^2(vartheta/2) and cos^2(vartheta/2), each accurate where it is small."""
        out = np.empty(np.shape(sine))
        run_points(jacobi_values, (*self._tables, np.ravel(sine), np.ravel(cosine), out.reshape(-1)), out.size)
        return out

    @property
    def degree(self) -> int:
        """Return n."""
        return self.n

    def rule(self, order: int) -> tuple[np.ndarray, np.ndarray]:
        """Return Gauss nodes and weights, exact for f^2 times polynomials of cos(vartheta) of degree < 2 (order -
        n).
        """
        from scipy.linalg import eigh_tridiagonal

        N = order
        p = self.b
        q = self.a
        k = np.arange(N)
        t = p + q
        diagonal = (q - p) * t / (np.maximum(2 * k + t, 1e-300) * (2 * k + t + 2))
        diagonal[0] = (q - p) / (t + 2)
        j = k[1:]
        off = np.sqrt(4 * j * (j + p) * (j + q) * (j + t) / ((2 * j + t) ** 2 * ((2 * j + t) ** 2 - 1)))
        x = eigh_tridiagonal(diagonal, off, eigvals_only=True)
        y = (1 - x) / 2
        z = (1 + x) / 2
        here = AngleFactor(N, q, p)
        before = AngleFactor(N - 1, q, p)
        front = -math.sqrt((2 * N + t - 1) * (N + p) * (N + q) / ((2 * N + t + 1) * N * (N + t)))
        for _ in range(2):  # Newton of y and of z, where rounding of the matrix left the small ones
            P = front * here.of_squares(y, z)
            P_before = before.of_squares(y, z)
            slope = N * (p - q - (2 * N + t) * (z - y)) * P + 2 * (N + p) * (N + q) * P_before
            change = 2 * (2 * N + t) * y * z * P / slope
            y = y + change
            z = z - change
        front = 4 * (2 * N + t) ** 2 * (2 * N + t - 1) / (4 * N * (N + t) * (N + p) * (N + q))
        return 2 * np.arctan2(np.sqrt(y), np.sqrt(z)), front * y * z / before.of_squares(y, z) ** 2


def _jacobi_end(n: int, p: float, q: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ladder tables and constants (c, h, y0, g, z0, sign) of the orthonormal Jacobi function seen from the end y = 0 of
    index p.
    """
    k = np.arange(n)
    t = p + q
    steps = (k + p + 1) * (k + t + 1)
    u = k * (k + q) * (2 * k + t + 2) / (steps * np.maximum(2 * k + t, 1e-300))
    w = (2 * k + t + 1) * (2 * k + t + 2) / steps
    y0, z0, M = (p / t, q / t, n + t) if t else (1.0, 1.0, max(n, 1))
    excesses = _excess(n + t) + _excess(n + p) - _excess(n) - _excess(n + q) - 2 * _excess(p)
    logarithms = (
        _times_log(n + t, (n + t) / M)
        + _times_log(n + p, (n + p) / M)
        - _times_log(n, n / M)
        - _times_log(n + q, (n + q) / M)
    )
    peak = -_times_log(p, p / M) + _times_log(q, q / M) - _times_log(t, t / M)  # y0^p z0^q/p^(2p)
    c = (math.log((2 * n + t + 1) / 2) + excesses + logarithms + peak) / 2
    return u, w, np.array([c, p / 2, y0 or 1.0, q / 2, z0 or 1.0, 1.0])
