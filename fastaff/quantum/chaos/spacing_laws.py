"""Laws of the spacings of unfolded levels between regular and chaotic, and their fit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.docstrings import inserts_parameters
from ...core.numbers import MOST, function, numbers, real, shown


class SpacingLaw(Protocol):
    """A distribution of spacings with one parameter in [0, 1] and mean spacing 1."""

    def density(self, s: ArrayLike) -> np.ndarray:
        """Return P(s)."""

    def cumulative(self, s: ArrayLike) -> np.ndarray:
        """Return the probability of a spacing below s."""


def _share(name: str, value: Any) -> float:
    number = real(name, value)
    if not 0 <= number <= 1:
        raise ValueError(f"{name} must lie in [0, 1], got {shown(value)}")
    return number


def _spacings(s: ArrayLike) -> np.ndarray:
    spacings = numbers("s", s)
    if not np.all((spacings >= 0) & (spacings <= MOST)):
        raise ValueError(f"s must be at least 0 and at most 2**53, in mean spacings, and no NaN, got {shown(s)}")
    return spacings


@dataclass(frozen=True)
class BerryRobnik:
    """Distribution of spacings of independently superposed regular and chaotic levels.

    Parameters
    ----------
    chaotic : float
        Chaotic share q of the energy surface, from 0 (Poisson, e^-s) to 1 (Wigner, (pi s/2) e^(-pi s^2/4)).

    Notes
    -----
    P(s) is the second derivative of the gap probability e^(-(1 - q) s) erfc(sqrt(pi) q s/2).

    References
    ----------
    Berry & Robnik 1984, J. Phys. A 17, 2413, eq. 28 (one chaotic region).

    Examples
    --------
    >>> fa.quantum.BerryRobnik(0.0).density([0.0, 1.0]).round(6)
    array([1.      , 0.367879])
    """

    chaotic: float

    def __post_init__(self) -> None:
        _share("chaotic", self.chaotic)

    @inserts_parameters
    def density(self, s: ArrayLike) -> np.ndarray:
        """Return the probability density P(s).

        Parameters
        ----------
        {spacing}

        Returns
        -------
        ndarray
            Density.
        """
        from scipy.special import erfc

        s = _spacings(s)
        q = self.chaotic
        p = 1 - self.chaotic
        wigner = (2 * p * q + np.pi * q**3 * s / 2) * np.exp(-np.pi * q * q * s * s / 4)
        return np.exp(-p * s) * (p * p * erfc(math.sqrt(np.pi) * q * s / 2) + wigner)

    @inserts_parameters
    def cumulative(self, s: ArrayLike) -> np.ndarray:
        """Return the probability of a spacing below s.

        Parameters
        ----------
        {spacing}

        Returns
        -------
        ndarray
            Probability.
        """
        from scipy.special import erfc

        s = _spacings(s)
        q = self.chaotic
        p = 1 - self.chaotic
        return 1 - np.exp(-p * s) * (p * erfc(math.sqrt(np.pi) * q * s / 2) + q * np.exp(-np.pi * q * q * s * s / 4))

    def mean_ratio(self) -> float:
        """Return the mean ratio of neighbouring spacings of the superposition.

        Returns
        -------
        float
            Mean ratio.

        Notes
        -----
        - Exact for Poisson.
        - The chaotic part has the value of three levels: 4 - 2 sqrt3 = 0.5359 at chaotic = 1. Large matrices have
          0.5307.
        - Derived from the gap probability and the three-level surmise of Atas et al. 2013.
        """
        nodes, weights = np.polynomial.legendre.leggauss(80)
        # smaller spacing = share*z of the sum z of both, in (0, 1/2)
        share = (1 + nodes) / 4
        scale = weights / 4
        z = 10 * (1 + nodes)
        dz = 10 * weights
        joint = self._joint(z[:, None] * share, z[:, None] * (1 - share))
        return float(2 * ((dz * z) @ joint @ (share / (1 - share) * scale)))

    def _joint(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the density of neighbouring spacings x, y: each of the three levels regular or chaotic."""
        from scipy.special import erfc

        q = self.chaotic
        p = 1 - self.chaotic
        z = x + y
        Q = q * (x + y)
        gap = erfc(math.sqrt(np.pi) * Q / 2)
        lone = np.exp(-np.pi * Q * Q / 4)
        pair = np.pi * Q / 2 * np.exp(-np.pi * Q * Q / 4)
        regular = p * (p * p * gap + 2 * p * q * lone + q * q * pair)
        X = q * x
        Y = q * y
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

    c = SURMISE
    Y = y + x / 2
    tail = Y * np.exp(-c * Y * Y) / (2 * c) + (1 / (2 * c) - x * x / 4) * math.sqrt(np.pi / c) / 2 * erfc(
        math.sqrt(c) * Y
    )
    return 9 / math.sqrt(np.pi) * c**2.5 * x * np.exp(-0.75 * c * x * x) * tail


@dataclass(frozen=True)
class Brody:
    """Empirical distribution of spacings with level repulsion s^w.

    Parameters
    ----------
    repulsion : float
        Exponent w of the level repulsion, from 0 (Poisson) to 1 (Wigner).

    Notes
    -----
    P(s) = (w + 1) b s^w e^(-b s^(w + 1)) with b = Gamma((w + 2)/(w + 1))^(w + 1). No theory supports the formula.

    References
    ----------
    Brody 1973, Lett. Nuovo Cimento 7, 482.

    Examples
    --------
    >>> fa.quantum.Brody(1.0).cumulative([0.0, 1.0]).round(6)
    array([0.      , 0.544062])
    """

    repulsion: float

    def __post_init__(self) -> None:
        _share("repulsion", self.repulsion)

    def _front(self) -> float:
        return math.gamma((self.repulsion + 2) / (self.repulsion + 1)) ** (self.repulsion + 1)

    @inserts_parameters
    def density(self, s: ArrayLike) -> np.ndarray:
        """Return the probability density P(s).

        Parameters
        ----------
        {spacing}

        Returns
        -------
        ndarray
            Density.
        """
        s = _spacings(s)
        w = self.repulsion
        b = self._front()
        return (w + 1) * b * s**w * np.exp(-b * s ** (w + 1))

    @inserts_parameters
    def cumulative(self, s: ArrayLike) -> np.ndarray:
        """Return the probability of a spacing below s.

        Parameters
        ----------
        {spacing}

        Returns
        -------
        ndarray
            Probability.
        """
        return -np.expm1(-self._front() * _spacings(s) ** (self.repulsion + 1))


class SpacingFit(NamedTuple):
    """Law of maximum likelihood.

    Attributes
    ----------
    law : SpacingLaw
        The law with the fitted parameter.
    low, high : float
        Ends of the interval of the parameter in which the likelihood is above e^(-1/2) of its maximum.
    """

    law: SpacingLaw
    low: float
    high: float


def fit_spacings(spacings: ArrayLike, law: Callable[[float], SpacingLaw]) -> SpacingFit:
    """Fit the parameter of a law of spacings by maximum likelihood.

    Parameters
    ----------
    spacings : array_like, shape (n,)
        Positive unfolded spacings, with a mean of about 1.
    law : callable
        `BerryRobnik`, `Brody`, or a function of a number from 0 to 1 that returns an object with the methods
        ``density`` and ``cumulative``.

    Returns
    -------
    SpacingFit
        The law, and the 68 % interval of its parameter, cut at 0 and 1.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If a spacing is not positive and finite.

    Notes
    -----
    Neighbouring spacings are treated as independent. Those of GOE have a correlation of -0.27, so the interval is
    somewhat too wide.

    References
    ----------
    Brody et al. 1981, Rev. Mod. Phys. 53, 385.

    Examples
    --------
    >>> spacings = np.random.default_rng(0).exponential(size=4000)
    >>> found = fa.quantum.fit_spacings(spacings, fa.quantum.Brody)
    >>> found.low, bool(found.high < 0.05)
    (0.0, True)
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
