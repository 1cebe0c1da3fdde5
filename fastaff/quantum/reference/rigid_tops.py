"""The body without shear potential as a free top: levels of spherical and symmetric tops, Wigner's d functions.

V_vartheta = 0 makes h_vartheta the spherical top of I = mu/4 with Theta = vartheta, Phi = 2 phi, Psi = -2 psi: so j, m'
= m/2 and l' = l/2 are all integer or all half-integer, and EQ4.10 is solved by d^j_(m', -l')(vartheta); d^j_(m', l')
belongs to Psi = +2 psi.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.numbers import positive, shown, whole_numbers
from ..states.factors import AngleFactor
from ..states.symmetry import action_quantum, checked_class


class TopLevels(NamedTuple):
    """Energies E (...) of a free top, and degeneracy (...), the number of their states of one j (and |l|)."""

    E: np.ndarray
    degeneracy: np.ndarray


def doubled(name: str, value: ArrayLike, least: int | None = None) -> np.ndarray:
    """Return twice a half-integer quantum number, as integers; raises TypeError or ValueError for others."""
    numbers = np.asarray(value)
    if numbers.dtype.kind not in "iuf" or numbers.size == 0:
        raise TypeError(f"{name} must be integers or half-integers, got {shown(value)}")
    try:
        twice = whole_numbers(name, 2 * numbers)
    except ValueError:
        raise ValueError(f"{name} must be integers or half-integers, got {shown(value)}") from None
    if least is not None and np.any(twice < least):
        raise ValueError(f"{name} must be at least {least / 2:g}, got {shown(value)}")
    return twice


def spherical_top(I: float, *, j: ArrayLike, hbar: float = 1.0) -> TopLevels:
    """Compute the levels of a free spherical top.

    I: its moment of inertia, > 0; j (...): integers or half-integers >= 0; hbar > 0.  Returns TopLevels. Raises
    ValueError or TypeError for wrong input.  Formula: E = hbar^2 j (j + 1)/(2 I), (2 j + 1)^2 times.
    Source: Martens & Slawianowski, section 4, below EQ4.10 (E_j).
    """
    twice = doubled("j", j, 0)
    E = action_quantum(hbar) ** 2 / (2 * positive("I", I)) * twice * (twice + 2) / 4
    return TopLevels(E, (twice + 1) ** 2)


def symmetric_top(I: float, K: float, *, j: ArrayLike, l: ArrayLike, hbar: float = 1.0) -> TopLevels:
    """Compute the levels of a free symmetric top.

    I, K: the moments of inertia, > 0, I the double one; j (...) >= 0 and l (...), |l| <= j, integers or half-integers
    together: the projection of the angular momentum on the axis of the body; hbar > 0.  Returns TopLevels. Raises
    ValueError or TypeError for wrong input.
    Formula: E = hbar^2 j (j + 1)/(2 I) + hbar^2 (1/(2 K) - 1/(2 I)) l^2, 2 (2 j + 1) times, 2 j + 1 times for l = 0.
    Source: Martens & Slawianowski, section 4 (E_(j,l); the sign of the second term and the degeneracy of l = 0
    corrected).
    """
    twice, axis = np.broadcast_arrays(doubled("j", j, 0), doubled("l", l))
    _check_projection("l", twice, axis)
    size = action_quantum(hbar) ** 2
    double = positive("I", I)
    single = positive("K", K)
    E = size * (twice * (twice + 2) / 4 / (2 * double) + (1 / (2 * single) - 1 / (2 * double)) * (axis / 2) ** 2)
    return TopLevels(E, np.where(axis == 0, 1, 2) * (twice + 1))


def shear_levels(mu: float, *, j: ArrayLike, hbar: float = 1.0) -> TopLevels:
    """Compute the eigenvalues e_vartheta of h_vartheta without shear potential.

    mu: the inertia of the body, > 0; j (...), hbar as in `spherical_top`.  Returns TopLevels. Raises ValueError or
    TypeError as `spherical_top`.
    Formula: e = (2 hbar^2/mu) j (j + 1), the spherical top of I = mu/4; (2 j + 1)^2 classes m, l, all with m + l even.
    Source: Martens & Slawianowski, section 4 (e_(Theta j)).
    """
    return spherical_top(positive("mu", mu) / 4, j=j, hbar=hbar)


def _check_projection(name: str, twice_j: np.ndarray, twice_m: np.ndarray) -> None:
    if np.any((twice_j - twice_m) % 2) or np.any(np.abs(twice_m) > twice_j):
        raise ValueError(f"{name} must be j, j - 1, ..., -j; got {twice_m / 2} for j = {twice_j / 2}")


def wigner_d(j: float, m: float, l: float, theta: ArrayLike) -> np.ndarray:
    """Compute Wigner's function d^j_(m l)(theta) = <j m| e^(-i theta J_y) |j l>.

    j >= 0, m, l in -j ... j: integers or half-integers together; theta (...) in [0, pi], in radians. Returns (...).
    Raises ValueError or TypeError for wrong input.
    Formula: +-sqrt(2/(2 j + 1)) times the normalised Jacobi function of sin^|m - l|, cos^|m + l| of theta/2, by the
    ladder of `AngleFactor`; error below 1e-12 for j <= 500, orthogonal with integral d^2 sin = 2/(2 j + 1). Condon and
    Shortley's phases.
    Source: Martens & Slawianowski, EQ4.10; Edmonds 1957, Angular Momentum in Quantum Mechanics, section 4.1.
    """
    twice, first, second = (_single(name, value) for name, value in (("j", j), ("m", m), ("l", l)))
    if twice < 0:
        raise ValueError(f"j must be at least 0, got {shown(j)}")
    _check_projection("m", np.array(twice), np.array(first))
    _check_projection("l", np.array(twice), np.array(second))
    n = (twice - max(abs(first), abs(second))) // 2
    a = abs(first + second) // 2
    b = abs(first - second) // 2
    # d is positive near theta = 0 for l >= m, else (-1)^(m - l); the factor is positive near theta = pi: (-1)^n near 0
    odd = n + (b if first > second else 0)
    return (-1.0) ** odd * math.sqrt(2 / (twice + 1)) * AngleFactor(n, float(a), float(b))(theta)


def _single(name: str, value: Any) -> int:
    twice = doubled(name, value)
    if twice.ndim:
        raise TypeError(f"{name} must be one number, got {shown(value)}")
    return int(twice)


def nutation_factor(*, m: int, l: int, j: float, theta: ArrayLike) -> np.ndarray:
    """Compute the normalised f_vartheta of the body without shear potential, sqrt((2 j + 1)/2) d^j_(m/2, -l/2)(theta).

    m, l: spin and vorticity, m + l even; j: |m|/2, |l|/2 <= j, in steps of one; theta (...) in [0, pi].  Returns (...),
    with integral f^2 sin = 1. Raises ValueError or TypeError for wrong input. It solves EQ4.10 with e = (2 hbar^2/mu) j
    (j + 1) and is, up to its sign, the harmonic `AngleFactor` of n_vartheta = j - (a + b)/2.
    Source: Martens & Slawianowski, EQ4.8, EQ4.10 (m', l' signed; -l', as Psi = -2 psi).
    """
    symmetry = checked_class(m, l)
    return math.sqrt((2 * float(j) + 1) / 2) * wigner_d(j, symmetry.m / 2, -symmetry.l / 2, theta)
