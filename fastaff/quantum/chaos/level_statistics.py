"""Statistics of levels: unfolding, spacings and their ratios, against regular (Poisson) and chaotic (GOE) spectra.

Statistics compare with random matrices only within one symmetry: the levels of one class (m, l). The potential of a
body depends on alpha^2 and beta^2 alone, so reflections of space and of the body change the signs of m and l, and leave
no parity inside a class, not for m = 0, l = 0 or |m| = |l| either. There is one exception: a potential that is the same
at -det phi, V(A, B) = V(B, A), has alpha <-> beta as a parity inside classes with m l = 0. Bodies on det phi > 0 never
have it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.numbers import an_array, shown
from .unfold import checked_levels

POISSON_RATIO = 2 * math.log(2) - 1
"""Mean ratio of spacings of independent levels, 0.38629. Source: Oganesyan & Huse 2007, Phys. Rev. B 75, 155111."""
GOE_RATIO = 0.5307
"""Mean ratio of large real symmetric random matrices, +-0.0001. Source: Atas et al. 2013, Phys. Rev. Lett. 110, 084101,
table I.
"""
SAME = 1e-9
"""Spacings below this fraction of the mean are degenerate levels."""


class MeanRatio(NamedTuple):
    """Mean ratio of neighbouring spacings.

    Attributes
    ----------
    value : float
        Mean ratio.
    error : float
        Standard error, inf for a single ratio.
    ratios : int
        Number of ratios.
    """

    value: float
    error: float
    ratios: int


def _simple(E: np.ndarray) -> np.ndarray:
    """Return the spacings; raises ValueError for degenerate levels."""
    spacings = np.diff(E)
    same = np.flatnonzero(spacings <= SAME * (E[-1] - E[0]) / spacings.size)
    if same.size:
        raise ValueError(
            f"levels must not be degenerate, got {same.size} equal pairs, first {same[0]} and {same[0] + 1}. Use one "
            "symmetry class (m, l) at a time."
        )
    return spacings


def spacing_ratios(levels: ArrayLike) -> np.ndarray:
    """Compute the ratios of neighbouring spacings, which need no unfolding.

    Parameters
    ----------
    levels : array_like, shape (n,)
        Ascending energies of levels of one symmetry class.

    Returns
    -------
    ndarray, shape (n - 2,)
        Ratios min(s_k, s_(k+1))/max(s_k, s_(k+1)) of the spacings s_k = E_(k+1) - E_k.

    Raises
    ------
    TypeError
        If the levels are not numbers.
    ValueError
        If the levels are fewer than 3, not ascending, not finite or degenerate, with spacings below 1e-9 of the mean.

    References
    ----------
    Oganesyan & Huse 2007, Phys. Rev. B 75, 155111; Atas et al. 2013, Phys. Rev. Lett. 110, 084101.

    Examples
    --------
    >>> fa.quantum.spacing_ratios([0.0, 1.0, 3.0, 4.0])
    array([0.5, 0.5])
    """
    return _ratios("levels", levels)


def _ratios(name: str, levels: ArrayLike) -> np.ndarray:
    s = _simple(checked_levels(levels, name=name))
    return np.minimum(s[1:], s[:-1]) / np.maximum(s[1:], s[:-1])


def mean_spacing_ratio(spectra: Sequence[ArrayLike]) -> MeanRatio:
    """Compute the mean ratio of spacings of one or several spectra, with its standard error.

    Parameters
    ----------
    spectra : sequence of array_like, shape (n,)
        Ascending levels of one symmetry class each, with the same classical limit. Their ratios are pooled.

    Returns
    -------
    MeanRatio
        Mean and standard error. Compare `POISSON_RATIO` (regular), `GOE_RATIO` (chaotic) and
        ``BerryRobnik(q).mean_ratio()`` (mixed).

    Raises
    ------
    TypeError
        If the levels are not numbers.
    ValueError
        If the levels of a spectrum are fewer than 3, not ascending, not finite or degenerate.

    Notes
    -----
    The error includes the covariance of a ratio with the next, which shares a spacing with it.

    References
    ----------
    Atas et al. 2013, Phys. Rev. Lett. 110, 084101; the error is derived.

    Examples
    --------
    >>> levels = np.cumsum(np.random.default_rng(0).exponential(size=4000))
    >>> found = fa.quantum.mean_spacing_ratio([levels])
    >>> bool(abs(found.value - fa.quantum.POISSON_RATIO) < 3 * found.error)
    True
    """
    if not isinstance(spectra, (list, tuple)) or not spectra or np.ndim(an_array("spectra[0]", spectra[0])) != 1:
        raise TypeError("spectra must be a list of level arrays, such as [levels]")
    parts = [_ratios(f"spectra[{k}]", levels) for k, levels in enumerate(spectra)]
    r = np.concatenate(parts)
    away = [part - r.mean() for part in parts]
    variance = sum(float(d @ d) for d in away)
    next_to = sum(float(d[1:] @ d[:-1]) for d in away)
    if r.size < 2:
        return MeanRatio(float(r.mean()), math.inf, r.size)
    return MeanRatio(float(r.mean()), math.sqrt(max(variance + 2 * next_to, 0.1 * variance)) / r.size, r.size)


def number_variance(unfolded: ArrayLike, lengths: ArrayLike) -> np.ndarray:
    """Compute the variance of the number of unfolded levels in intervals of given lengths.

    Parameters
    ----------
    unfolded : array_like, shape (n,)
        Levels of `unfold`.
    lengths : array_like
        Lengths L of the intervals, positive and below a fifth of the sequence.

    Returns
    -------
    ndarray
        Variance Sigma^2 over 4 n evenly spread intervals, of the shape of `lengths`.

    Raises
    ------
    TypeError
        If an argument is not numbers.
    ValueError
        If the levels are not ascending or a length is out of range.

    Notes
    -----
    - Poisson: Sigma^2 = L.
    - GOE, L > 1: Sigma^2 = (2/pi^2)(ln(2 pi L) + 1.5772 - pi^2/8).

    References
    ----------
    Mehta 2004, Random Matrices, section 16.1.

    Examples
    --------
    >>> fa.quantum.number_variance(np.arange(100.0), [1.0, 1.5]).round(6)
    array([0.  , 0.25])
    """
    x = checked_levels(unfolded, 5, "unfolded")
    spans = checked("lengths", lengths, ())
    if np.any(spans <= 0) or np.any(spans > (x[-1] - x[0]) / 5):
        raise ValueError(
            f"lengths must be positive and below {(x[-1] - x[0]) / 5:.3g}, a fifth of the sequence, got "
            f"{shown(lengths)}"
        )
    out = np.empty(spans.shape)
    for place, span in np.ndenumerate(spans):
        start = np.linspace(x[0], x[-1] - span, 4 * x.size)
        out[place] = np.var(np.searchsorted(x, start + span) - np.searchsorted(x, start))
    return out[()]
