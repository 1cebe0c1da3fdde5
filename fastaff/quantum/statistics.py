"""Statistics of levels: unfolding, spacings and their ratios, against regular (Poisson) and chaotic (GOE) spectra.

Statistics compare with random matrices only within one symmetry: the levels of one class (m, l). The potential of a
body depends on alpha^2 and beta^2 alone, so reflections of space and of the body change the signs of m and l, and leave
no parity inside a class, not for m = 0, l = 0 or |m| = |l| either. There is one exception: a potential that is the same
at -det phi, V(A, B) = V(B, A), has alpha <-> beta as a parity inside classes with m l = 0. Bodies on det phi > 0 never
have it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..base.arrays import checked
from ..base.numbers import MOST, an_array, function, numbers, real, shown, whole

POISSON_RATIO = 2 * math.log(2) - 1
"""Mean ratio of spacings of independent levels, 0.38629. Source: Oganesyan & Huse 2007, Phys. Rev. B 75, 155111."""
GOE_RATIO = 0.5307
"""Mean ratio of large real symmetric random matrices, +-0.0001. Source: Atas et al. 2013, Phys. Rev. Lett. 110, 084101,
table I.
"""
SAME = 1e-9
"""Spacings below this fraction of the mean are degenerate levels."""


class SpacingLaw(Protocol):
    """A distribution of spacings with one parameter in [0, 1] and mean spacing 1."""

    def density(self, s: ArrayLike) -> np.ndarray:
        """Return P(s)."""

    def cumulative(self, s: ArrayLike) -> np.ndarray:
        """Return the probability of a spacing below s."""


def _share(name: str, value: Any) -> float:
    number = real(name, value)
    if not 0 <= number <= 1:
        raise ValueError(f"{name} must lie in [0, 1], got {value!r}")
    return number


def _spacings(s: ArrayLike) -> np.ndarray:
    spacings = numbers("s", s)
    if not np.all((spacings >= 0) & (spacings <= MOST)):
        raise ValueError(f"s must be at least 0 and at most 2**53, in mean spacings, and no NaN, got {shown(s)}")
    return spacings


@dataclass(frozen=True)
class BerryRobnik:
    """Spacings of regular and chaotic levels, superposed independently; `chaotic` is the chaotic share of the energy
    surface.

    BerryRobnik(0) is Poisson, e^-s; BerryRobnik(1) Wigner, (pi s/2) e^(-pi s^2/4). P(s) is the second derivative of the
    gap probability e^(-(1 - q) s) erfc(sqrt(pi) q s/2), q = chaotic. Source: Berry & Robnik 1984, J. Phys. A 17, 2413,
    eq. 28 (one chaotic region).
    """

    chaotic: float

    def __post_init__(self) -> None:
        _share("chaotic", self.chaotic)

    def density(self, s: ArrayLike) -> np.ndarray:
        """Return P(s)."""
        from scipy.special import erfc

        s, q, p = _spacings(s), self.chaotic, 1 - self.chaotic
        wigner = (2 * p * q + np.pi * q**3 * s / 2) * np.exp(-np.pi * q * q * s * s / 4)
        return np.exp(-p * s) * (p * p * erfc(math.sqrt(np.pi) * q * s / 2) + wigner)

    def cumulative(self, s: ArrayLike) -> np.ndarray:
        """Return the probability of a spacing below s."""
        from scipy.special import erfc

        s, q, p = _spacings(s), self.chaotic, 1 - self.chaotic
        return 1 - np.exp(-p * s) * (p * erfc(math.sqrt(np.pi) * q * s / 2) + q * np.exp(-np.pi * q * q * s * s / 4))

    def mean_ratio(self) -> float:
        """Return the mean ratio of neighbouring spacings of such a superposition.

        Exact for Poisson; the chaotic part as if three levels were all there are, 4 - 2 sqrt3 = 0.5359 at chaotic = 1
        where large matrices have 0.5307. Derived: the joint density of both spacings from the gap probability and the
        three-level surmise of Atas et al.
        """
        nodes, weights = np.polynomial.legendre.leggauss(80)
        share, scale = (1 + nodes) / 4, weights / 4  # smaller spacing = share*z of the sum z of both, in (0, 1/2)
        z, dz = 10 * (1 + nodes), 10 * weights
        joint = self._joint(z[:, None] * share, z[:, None] * (1 - share))
        return float(2 * ((dz * z) @ joint @ (share / (1 - share) * scale)))

    def _joint(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the density of neighbouring spacings x, y: each of the three levels regular or chaotic."""
        from scipy.special import erfc

        q, p = self.chaotic, 1 - self.chaotic
        z, Q = x + y, q * (x + y)
        gap, lone, pair = (
            erfc(math.sqrt(np.pi) * Q / 2),
            np.exp(-np.pi * Q * Q / 4),
            np.pi * Q / 2 * np.exp(-np.pi * Q * Q / 4),
        )
        regular = p * (p * p * gap + 2 * p * q * lone + q * q * pair)
        X, Y = q * x, q * y
        empty = np.zeros(z.shape)
        for node, weight in zip(*np.polynomial.legendre.leggauss(40), strict=True):  # int_X^(X + 8) _one_sided(., Y)
            empty += 4 * weight * _one_sided(X + 4 * (1 + node), Y)
        chaotic = q * (p * p * empty + p * q * (_one_sided(X, Y) + _one_sided(Y, X)) + q * q * _three_levels(X, Y))
        return np.exp(-p * z) * (regular + chaotic)


SURMISE = 9 / (4 * math.pi)
"""c of the three-level surmise (9/sqrt(pi)) c^(5/2) x y (x + y) e^(-c (x^2 + x y + y^2)), which has mean spacing 1."""


def _three_levels(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the joint density of both spacings of three levels of GOE."""
    return 9 / math.sqrt(np.pi) * SURMISE**2.5 * x * y * (x + y) * np.exp(-SURMISE * (x * x + x * y + y * y))


def _one_sided(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the integral of _three_levels(x, .) from y to infinity."""
    from scipy.special import erfc

    c, Y = SURMISE, y + x / 2
    tail = Y * np.exp(-c * Y * Y) / (2 * c) + (1 / (2 * c) - x * x / 4) * math.sqrt(np.pi / c) / 2 * erfc(
        math.sqrt(c) * Y
    )
    return 9 / math.sqrt(np.pi) * c**2.5 * x * np.exp(-0.75 * c * x * x) * tail


@dataclass(frozen=True)
class Brody:
    """Spacings with level repulsion s^repulsion, from Poisson (0) to Wigner (1), a formula without a theory behind it.

    P(s) = (w + 1) b s^w e^(-b s^(w + 1)), b = Gamma((w + 2)/(w + 1))^(w + 1), w = repulsion.
    Source: Brody 1973, Lett. Nuovo Cimento 7, 482.
    """

    repulsion: float

    def __post_init__(self) -> None:
        _share("repulsion", self.repulsion)

    def _front(self) -> float:
        return math.gamma((self.repulsion + 2) / (self.repulsion + 1)) ** (self.repulsion + 1)

    def density(self, s: ArrayLike) -> np.ndarray:
        """Return P(s)."""
        s, w, b = _spacings(s), self.repulsion, self._front()
        return (w + 1) * b * s**w * np.exp(-b * s ** (w + 1))

    def cumulative(self, s: ArrayLike) -> np.ndarray:
        """Return the probability of a spacing below s."""
        return -np.expm1(-self._front() * _spacings(s) ** (self.repulsion + 1))


class SpacingFit(NamedTuple):
    """The law of largest likelihood, and the ends of the interval of its parameter where the likelihood is above
    e^(-1/2) of that.
    """

    law: SpacingLaw
    low: float
    high: float


class MeanRatio(NamedTuple):
    """Mean ratio of spacings, its standard error, and the number of ratios."""

    value: float
    error: float
    ratios: int


def checked_levels(levels: Any, least: int = 3, name: str = "levels") -> np.ndarray:
    """Return levels (n,) if they are finite, ascending, and at least `least`; raises ValueError or TypeError."""
    E = checked(name, levels, ())
    if E.ndim != 1 or E.size < least:
        raise ValueError(f"{name} must be (n,) with n >= {least}, got shape {E.shape}")
    if np.any(np.diff(E) < 0):
        raise ValueError(f"{name} must ascend; level {int(np.argmax(np.diff(E) < 0)) + 1} is below the one before")
    return E


def _simple(E: np.ndarray) -> np.ndarray:
    """Return the spacings; raises ValueError for degenerate levels."""
    spacings = np.diff(E)
    same = np.flatnonzero(spacings <= SAME * (E[-1] - E[0]) / spacings.size)
    if same.size:
        raise ValueError(
            f"levels {same[0]} and {same[0] + 1} are degenerate ({same.size} such pairs): take one symmetry class (m, "
            "l) at a time; a body "
            "whose classes have multiplets, like the harmonic one, has no statistics of spacings"
        )
    return spacings


def polynomial_count(levels: ArrayLike, degree: int = 5) -> Callable[[ArrayLike], np.ndarray]:
    """Fit a polynomial to the staircase of levels, a smooth count for `unfold` where no Weyl count is at hand.

    Parameters: levels (n,), ascending, n > degree; degree: at least 1, low enough not to follow fluctuations.
    Returns a function of the energy, k + 1/2 on average at level k. Raises ValueError or TypeError for wrong input.
    Source: Haake 2010, Quantum Signatures of Chaos, section 4.8.
    """
    degree = whole("degree", degree, 1)
    E = checked_levels(levels, degree + 2)
    if np.unique(E).size <= degree:
        raise ValueError(f"levels must have more than degree = {degree} different energies, got {np.unique(E).size}")
    fitted: Any = np.polynomial.Polynomial.fit(E, np.arange(E.size) + 0.5, degree)
    return fitted


def unfold(levels: ArrayLike, count: Callable[[np.ndarray], ArrayLike]) -> np.ndarray:
    """Map levels of one class to a sequence with mean spacing 1.

    Parameters: levels (n,), ascending, any part of the spectrum; count: a smooth number of levels below an energy, such
    as functools.partial(weyl_count, body, m=m, l=l, hbar=hbar) or `polynomial_count(levels)`. Returns count(levels)
    (n,). Raises ValueError or TypeError for wrong input, and where the count does not grow along the levels. Source:
    Bohigas, Giannoni & Schmit 1984, Phys. Rev. Lett. 52, 1.
    """
    E = checked_levels(levels, 1)
    x = checked("count(levels)", function("count", count)(E), ())
    if x.shape != E.shape:
        raise ValueError(f"count must return one number for each level, got shape {x.shape} for {E.shape}")
    fall = np.flatnonzero((np.diff(x) <= 0) & (np.diff(E) > 0))
    if fall.size:
        raise ValueError(
            f"count must grow; it falls from level {fall[0]}, {E[fall[0]]:.6g}, to the next: a lower degree, or higher "
            "levels"
        )
    return x


def count_deviation(levels: ArrayLike, count: Callable[[np.ndarray], ArrayLike]) -> np.ndarray:
    """Compute how far the staircase of the lowest levels is above a smooth count: a check that no level is missing.

    Parameters: levels (n,): all from the lowest on; count: as in `unfold`. Returns k + 1/2 - count(E_k) (n,): it
    oscillates around 0 for `weyl_count`; from a missing level on it lies 1 lower, from a level too many 1 higher, and a
    drift tells of a wrong count. Raises ValueError or TypeError for wrong input. Source: Baltes & Hilf 1976, Spectra of
    Finite Systems, chapter 6 (the check of completeness).
    """
    smooth = unfold(levels, count)
    return np.arange(smooth.size) + 0.5 - smooth


def spacing_ratios(levels: ArrayLike) -> np.ndarray:
    """Compute the ratios of neighbouring spacings, which need no unfolding.

    Parameters: levels (n,), ascending, of one class. Returns r_k = min(s_k, s_(k+1))/max(s_k, s_(k+1)) (n - 2,), s_k =
    E_(k+1) - E_k. Raises ValueError or TypeError for wrong input: fewer than 3 levels, not ascending, not finite,
    degenerate (spacings below 1e-9 of the mean). Source: Oganesyan & Huse 2007, Phys. Rev. B 75, 155111; Atas et al.
    2013, Phys. Rev. Lett. 110, 084101.
    """
    return _ratios("levels", levels)


def _ratios(name: str, levels: ArrayLike) -> np.ndarray:
    s = _simple(checked_levels(levels, name=name))
    return np.minimum(s[1:], s[:-1]) / np.maximum(s[1:], s[:-1])


def mean_spacing_ratio(spectra: Sequence[ArrayLike]) -> MeanRatio:
    """Compute the mean ratio of spacings of one or several spectra, with its standard error.

    Parameters: spectra: a sequence of level arrays, each (n,) of one class, with the same classical limit; their ratios
    are pooled. Returns MeanRatio, error inf for a single ratio; compare POISSON_RATIO (regular), GOE_RATIO (chaotic),
    BerryRobnik(q).mean_ratio() (both). Raises as `spacing_ratios`. The error has the variance of a ratio and its
    covariance with the next, which shares a spacing with it. Source: Atas et al. 2013, Phys. Rev. Lett. 110, 084101;
    the error is derived.
    """
    if not isinstance(spectra, (list, tuple)) or not spectra or np.ndim(an_array("spectra[0]", spectra[0])) != 1:
        raise TypeError("spectra must be a list of level arrays, such as [levels]")
    parts = [_ratios(f"spectra[{k}]", levels) for k, levels in enumerate(spectra)]
    r = np.concatenate(parts)
    away = [part - r.mean() for part in parts]
    variance, next_to = sum(float(d @ d) for d in away), sum(float(d[1:] @ d[:-1]) for d in away)
    if r.size < 2:
        return MeanRatio(float(r.mean()), math.inf, r.size)
    return MeanRatio(float(r.mean()), math.sqrt(max(variance + 2 * next_to, 0.1 * variance)) / r.size, r.size)


def fit_spacings(spacings: ArrayLike, law: Callable[[float], SpacingLaw]) -> SpacingFit:
    """Fit the parameter of a law of spacings by largest likelihood.

    Parameters: spacings (n,), > 0, unfolded (mean about 1); law: BerryRobnik or Brody, or any function of a number in
    [0, 1] that returns a SpacingLaw. Returns SpacingFit: law, and the 68 % interval of the parameter, cut at 0 and 1.
    Raises ValueError or TypeError for wrong input. Neighbouring spacings are taken as independent; those of GOE repel,
    with a correlation of -0.27, so that the interval is rather too wide. Source: Brody et al. 1981, Rev. Mod. Phys. 53,
    385.
    """
    s = checked("spacings", spacings, ())
    if s.ndim != 1 or s.size < 2 or np.any(s <= 0):
        raise ValueError(
            f"spacings must be (n,) with n >= 2 and positive, got shape {s.shape}, least {s.min(initial=np.inf):.3g}"
        )
    if s.max() > MOST:
        raise ValueError(f"spacings must be in mean spacings, at most 2**53, got {s.max():.3g}")
    parameter = np.linspace(0.0, 1.0, 401)
    if not hasattr(function("law", law)(0.5), "density"):
        raise TypeError(f"law must be a law of spacings such as BerryRobnik or Brody, got {shown(law)}")
    with np.errstate(divide="ignore"):
        likelihood = np.array([np.log(law(float(q)).density(s)).sum() for q in parameter])
    best = int(np.argmax(likelihood))
    inside = parameter[likelihood >= likelihood[best] - 0.5]
    return SpacingFit(law(float(parameter[best])), float(inside[0]), float(inside[-1]))


def number_variance(unfolded: ArrayLike, lengths: ArrayLike) -> np.ndarray:
    """Compute the variance of the number of unfolded levels in intervals of given lengths.

    Parameters: unfolded (n,), of `unfold`; lengths (...), each positive and below a fifth of the sequence. Returns
    Sigma^2 (...), over 4 n intervals spread evenly: L for Poisson, (2/pi^2)(ln(2 pi L) + 1.5772 - pi^2/8) for GOE and L
    > 1. Raises ValueError or TypeError for wrong input. Source: Mehta 2004, Random Matrices, section 16.1.
    """
    x, spans = checked_levels(unfolded, 5, "unfolded"), checked("lengths", lengths, ())
    if np.any(spans <= 0) or np.any(spans > (x[-1] - x[0]) / 5):
        raise ValueError(
            f"lengths must be positive and below a fifth of the sequence, {(x[-1] - x[0]) / 5:.3g}, got {lengths!r}"
        )
    out = np.empty(spans.shape)
    for place, span in np.ndenumerate(spans):
        start = np.linspace(x[0], x[-1] - span, 4 * x.size)
        out[place] = np.var(np.searchsorted(x, start + span) - np.searchsorted(x, start))
    return out[()]
