"""The shear of affinely invariant models: the invariant Laplacian of SL(2,R), its discrete series and its continuum.

In a class m, l the shear b = ln(D1/D2) has the operator

    L = -(1/sinh b) d/db sinh b d/db + (m^2 + l^2 + 2 m l cosh b)/(4 sinh^2 b)

in L^2(sinh b db). With alpha = |m - l|/2 and beta = |m + l|/2 it is Poeschl and Teller's problem of x = b/2,

    4 L = 1 - d^2/dx^2 + (beta^2 - 1/4)/sinh^2 x - (alpha^2 - 1/4)/cosh^2 x.

| part | classes | values of L |
|---|---|---|
| principal series | all | 1/4 + s^2, s > 0: continuous |
| discrete series | m l < 0 | k (1 - k) with k = min(|m|, |l|)/2 - n > 1/2, n = 0, 1, ... |

k = 1/2, the limit of the discrete series, is not square integrable. l belongs to psi = -Psi/2, so m l < 0 are matrix
elements between weights m and -l of one sign. Representations of lowest or highest weight 2 k have these weights, all
at least 2 k in size.

Source: Martens & Slawianowski, EQ6.17-EQ6.22 (the metric); Bargmann 1947, Ann. Math. 48, 568 (the series).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ...core.numbers import numbers, shown, whole
from ..states.factors import AngleFactor
from ..states.symmetry import SymmetryClass, checked_class

BOTTOM = 0.25
"""Lower end of the continuum of L, that of the principal series."""


def series(symmetry: SymmetryClass) -> np.ndarray:
    """Return k > 1/2 of the discrete levels of a class, descending, as n grows from 0."""
    m, l = symmetry
    least = min(abs(m), abs(l)) if m * l < 0 else 0
    return least / 2 - np.arange(least // 2)


def casimir(k: ArrayLike) -> np.ndarray:
    """Return k (1 - k), the value of L of the discrete series of lowest weight 2 k."""
    weight = np.asarray(k, float)
    return weight * (1 - weight)


def why_none(symmetry: SymmetryClass) -> str:
    """Return why the shear of a class has no discrete level, in one sentence without a full stop; empty if it has."""
    if series(symmetry).size:
        return ""
    m, l = symmetry
    if m * l >= 0:
        return f"m l = {m * l} is not negative: the shear does not attract, only the principal series contributes"
    return "min(|m|, |l|) = 1: k = 1/2, the limit of the discrete series, is not square integrable"


def shear_factor(b: ArrayLike, *, n: int, m: int, l: int) -> np.ndarray:
    """Compute the normalised shear factor of a discrete level of an affinely invariant model.

    Parameters
    ----------
    b : array_like, shape (...)
        Shear b = ln(D1/D2), at least 0.
    n : int
        Number of the discrete level of the class, from 0, below min(``|m|``, ``|l|``)/2 - 1/2.
    m, l : int
        Quantum numbers of spin and vorticity, m l < 0, with an even sum.

    Returns
    -------
    ndarray, shape (...)
        Values of f, positive for large b.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the class has no such level, or b is negative.

    Notes
    -----
    - State on GL+(2,R): e^(i m phi + i l psi) f(b) g(a) with a = ln det phi and g a state of the dilatation.
    - f = N tanh(b/2)^``|m + l|``/2 cosh(b/2)^(-2 k) P_n(1 - 2 tanh(b/2)^2), Jacobi's polynomials with the exponents
      ``|m + l|``/2 and 2 k - 1, k = min(``|m|``, ``|l|``)/2 - n.
    - Norm: the integral of f^2 sinh(b) db is 1.
    - It does not depend on the constants of inertia.

    References
    ----------
    Martens & Slawianowski, EQ6.20-EQ6.22; Bargmann 1947, Ann. Math. 48, 568 (discrete series).

    Examples
    --------
    >>> fa.quantum.shear_factor([0.0, 1.0, 2.0], n=0, m=2, l=-2).round(6)
    array([0.707107, 0.556103, 0.296967])
    """
    symmetry = checked_class(m, l)
    weights = series(symmetry)
    number = whole("n", n, 0)
    if number >= weights.size:
        raise ValueError(f"n must be below the {weights.size} discrete levels of m = {m}, l = {l}, got {shown(n)}")
    x = numbers("b", b) / 2
    if not np.all(x >= 0):
        raise ValueError(f"b must be at least 0 and no NaN, got {shown(b)}")
    excess = 2 * float(weights[number]) - 1
    factor = AngleFactor(number, excess, symmetry.b)
    decay = np.exp(-x)
    sech = 2 * decay / (1 + decay * decay)
    return math.sqrt(excess / symmetry.a) * sech * factor.of_squares(np.tanh(x) ** 2, sech * sech)
