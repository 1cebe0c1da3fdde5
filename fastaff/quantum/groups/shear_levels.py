"""Levels of the shear of affinely invariant models: in closed form without a potential, else by a radial equation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..exact.exact_levels import ROUNDING
from ..solvers.separable import radial
from ..solvers.singular_ends import NoGroundState, sampled
from ..states.level_table import level_scale
from ..states.symmetry import SymmetryClass
from .shear_series import BOTTOM, casimir, series, why_none

FAR = 300.0
"""a or b at which the limits of a potential are read: det is e^(+-300), its square and root are within floats."""

GROWTH = 0.05
"""Relative growth of V from half of that to it beyond which V has no limit. A logarithm grows by 0.12, a tail 1/b by
less than 0.01.
"""

CSCH = (-1 / 3, 1 / 15, -2 / 189, 1 / 675, -2 / 10395, 1382 / 58046625, -4 / 1403325)
"""Coefficients of 1/sinh(x)^2 - 1/x^2 in powers of x^2, to 2e-14 for x < 0.3."""

MOST_SHOWN = 8
"""Most weights k that the reason lists."""


class ShearRates(NamedTuple):
    """Constants of H = rate L + rotor of the shear, each with hbar^2."""

    rate: float
    rotor: float


class Shear(NamedTuple):
    """Levels of the shear with the rotor's term, their errors, status, method and size; the bottom of its continuum."""

    E: np.ndarray
    error: np.ndarray
    converged: np.ndarray
    bottom: float
    method: str
    size: int
    reason: str

    def slack(self, energy: float) -> float:
        """Return the error of a threshold at an energy: that of the lowest level, and rounding."""
        return float(self.error[0] if self.error.size else 0.0) + ROUNDING * abs(energy)


def closed_shear(rates: ShearRates, symmetry: SymmetryClass) -> Shear:
    """Return the discrete series and the bottom of the principal series."""
    k = series(symmetry)
    parts = rates.rate * casimir(k)
    reason = why_none(symmetry) or f"k = {', '.join(f'{one:g}' for one in k[:MOST_SHOWN])} of the discrete series"
    return Shear(
        E=parts + rates.rotor,
        error=ROUNDING * (np.abs(parts) + rates.rotor),
        converged=np.ones(k.shape, bool),
        bottom=rates.rate * BOTTOM + rates.rotor,
        method="shear: discrete series of SL(2,R) in closed form",
        size=0,
        reason=f"shear: {reason}",
    )


class _ShearPotential(NamedTuple):
    """V_b and the terms of rate L for u = sqrt(sinh b) f, less rate (beta^2 - 1/4)/b^2, as a radial potential."""

    V: Callable[[Any], Any]
    rate: float
    alpha: float
    beta: float

    def value(self, b: Any) -> Any:
        """Return the radial potential at b."""
        rest = BOTTOM - _curved(b) / 4 + self.beta**2 / 4 * _curved(b / 2) - self.alpha**2 / 4 * _squared_sech(b / 2)
        return self.V(b) + self.rate * rest


def _curved(x: np.ndarray) -> np.ndarray:
    """Return 1/sinh(x)^2 - 1/x^2, accurate at small x."""
    near = x < 0.3
    y = np.where(near, x, 0.0) ** 2
    small = np.polynomial.polynomial.polyval(y, CSCH)
    far = np.where(near, 1.0, x)
    decay = np.exp(-far)
    return np.where(near, small, (2 * decay / (1 - decay * decay)) ** 2 - 1 / far**2)


def _squared_sech(x: np.ndarray) -> np.ndarray:
    """Return 1/cosh(x)^2 without overflow."""
    decay = np.exp(-np.abs(x))
    return (2 * decay / (1 + decay * decay)) ** 2


def bound_shear(
    held: Callable[[Any], Any], rates: ShearRates, symmetry: SymmetryClass, count: int, tolerance: float
) -> Shear:
    """Return the lowest levels of a shear with a potential, as a radial problem in two dimensions, b its radius."""
    problem = _ShearPotential(held, rates.rate, symmetry.a, symmetry.b)
    K = np.array([symmetry.b**2])
    open_end = limit(held, 1) + rates.rate * BOTTOM
    spare = spare_levels(open_end)
    solved = radial("V of r/det", problem, 2, K, count, 1.0, 0.5 / rates.rate, tolerance, spare)
    E, error = solved.values[0], solved.error[0]
    if not E[-1] < open_end:
        raise NoGroundState(f"V of r/det binds fewer levels than count = {count}")
    return Shear(
        E=E + rates.rotor,
        error=error + ROUNDING * (np.abs(E) + rates.rotor),
        converged=error <= tolerance * level_scale(E),
        bottom=open_end + rates.rotor,
        method=f"shear: Galerkin in Jacobi polynomials with the exponents of the ends{solved.said}",
        size=solved.size,
        reason="shear: levels with the potential V_b",
    )


def spare_levels(open_end: float) -> int:
    """Return how many levels more set the reach of a basis: none where V has a limit, which may bind no more."""
    return 0 if np.isfinite(open_end) else 2


def limit(V: Callable[[Any], Any], side: int) -> float:
    """Return the limit of V at +-infinity, inf where it grows."""
    near, half, far = (float(sampled(V, np.array([place]))[0]) for place in (0.0, side * FAR / 2, side * FAR))
    return far if far - half <= GROWTH * max(abs(half - near), abs(far)) else np.inf
