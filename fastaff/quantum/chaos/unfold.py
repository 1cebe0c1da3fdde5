"""Levels with mean spacing 1, by a smooth count of levels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.numbers import function, whole


def checked_levels(levels: Any, least: int = 3, name: str = "levels") -> np.ndarray:
    """Return levels (n,) if they are finite, ascending, and at least `least`; raises ValueError or TypeError."""
    E = checked(name, levels, ())
    if E.ndim != 1 or E.size < least:
        raise ValueError(f"{name} must be (n,) with n >= {least}, got shape {E.shape}")
    if np.any(np.diff(E) < 0):
        k = int(np.argmax(np.diff(E) < 0)) + 1
        raise ValueError(f"{name} must be ascending, got {E[k]:g} after {E[k - 1]:g} at index {k}")
    return E


def polynomial_count(levels: ArrayLike, degree: int = 5) -> Callable[[ArrayLike], np.ndarray]:
    """Fit a polynomial to the staircase of levels, as a smooth count for `unfold`.

    Parameters
    ----------
    levels : array_like, shape (n,)
        Ascending energies of levels of one symmetry class, n > degree.
    degree : int, default 5
        Degree of the polynomial, at least 1. Choose it so low that the polynomial does not follow fluctuations.

    Returns
    -------
    callable
        Function of the energy, on average k + 1/2 at level k.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the levels are not ascending or too few, or the degree is out of range.

    References
    ----------
    Haake 2010, Quantum Signatures of Chaos, section 4.8.

    Examples
    --------
    >>> fa.quantum.polynomial_count(np.arange(50.0), degree=1)([10.0, 20.5]).round(6)
    array([10.5, 21. ])
    """
    degree = whole("degree", degree, 1)
    E = checked_levels(levels, degree + 2)
    if np.unique(E).size <= degree:
        raise ValueError(f"levels must have more than degree = {degree} different energies, got {np.unique(E).size}")
    fitted: Any = np.polynomial.Polynomial.fit(E, np.arange(E.size) + 0.5, degree)
    return fitted


def unfold(levels: ArrayLike, smooth: Callable[[np.ndarray], ArrayLike]) -> np.ndarray:
    """Map levels of one symmetry class to a sequence with mean spacing 1.

    Parameters
    ----------
    levels : array_like, shape (n,)
        Ascending energies of levels of one symmetry class.
    smooth : callable
        Function of an array of energies that returns the smooth number of levels below each, for example
        ``functools.partial(weyl_count, body, m=m, l=l, hbar=hbar)`` or ``polynomial_count(levels)``.

    Returns
    -------
    ndarray, shape (n,)
        Values smooth(levels). The levels may be any part of the spectrum.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the levels are not ascending, or the smooth count does not grow along them.

    References
    ----------
    Bohigas, Giannoni & Schmit 1984, Phys. Rev. Lett. 52, 1.

    Examples
    --------
    >>> fa.quantum.unfold([0.0, 1.0, 4.0, 9.0], lambda E: np.sqrt(E) + 0.5)
    array([0.5, 1.5, 2.5, 3.5])
    """
    E = checked_levels(levels, 1)
    x = checked("smooth(levels)", function("smooth", smooth)(E), ())
    if x.shape != E.shape:
        raise ValueError(f"smooth must return one number for each level, got shape {x.shape} for {E.shape}")
    fall = np.flatnonzero((np.diff(x) <= 0) & (np.diff(E) > 0))
    if fall.size:
        raise ValueError(
            f"smooth must grow with the energy, got a fall after level {fall[0]}, {E[fall[0]]:.6g}. Try a lower "
            "degree or higher levels."
        )
    return x


def count_deviation(levels: ArrayLike, smooth: Callable[[np.ndarray], ArrayLike]) -> np.ndarray:
    """Compute the excess of the staircase of levels over a smooth count, to find missing levels.

    Parameters
    ----------
    levels : array_like, shape (n,)
        Ascending energies of all levels of one symmetry class from the lowest on.
    smooth : callable
        Function of an array of energies that returns the smooth number of levels below each, for example
        ``functools.partial(weyl_count, body, m=m, l=l, hbar=hbar)`` or ``polynomial_count(levels)``.

    Returns
    -------
    ndarray, shape (n,)
        Values k + 1/2 - smooth(E_k). They oscillate around 0 for `weyl_count`, are 1 lower after a missing level and 1
        higher after a spurious one. A drift indicates a wrong count.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the levels are not ascending.

    References
    ----------
    Baltes & Hilf 1976, Spectra of Finite Systems, chapter 6 (the check of completeness).

    Examples
    --------
    >>> levels = np.delete(np.arange(8.0), 4)
    >>> fa.quantum.count_deviation(levels, lambda E: E + 0.5)
    array([ 0.,  0.,  0.,  0., -1., -1., -1.])
    """
    unfolded = unfold(levels, smooth)
    return np.arange(unfolded.size) + 0.5 - unfolded
