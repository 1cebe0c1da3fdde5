"""Surfaces of section as values: `section(z)` is the signed distance function.

`direction` = +1 counts crossings where the function increases, -1 where it decreases, 0 both. Your own section is a
NamedTuple with a field `direction` and a method `value(self, q1, ..., pn)` made of arithmetic.

Sections of a body in the planes a and b have more (`_of_bodies`), from which texts, grids, samples and figures follow.
A section that gives one radius as a function of the other, u, has `radii(u)`, alpha and beta. If the given radius
varies with u, so that u and its momentum are no canonical pair on it, the section also has `slopes(alpha, beta)`, the
derivatives of its function, positive for that radius, and `leaning(u)`, the squared derivative of that radius by u.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class _Callable:
    """Call of the sections of this module, `section(z)`; z has shape (2n,) or (2n, orbits)."""

    def __call__(self, z):
        return self.value(*np.asarray(z))


def _section(cls):
    """Attach the call to a NamedTuple, which cannot inherit it."""
    cls.__call__ = _Callable.__call__
    return cls


OF_BODIES: dict[str, Any] = {}
"""Sections of bodies by their text, which ends with "=c" if they have a constant."""


def _of_bodies(text, label, over):
    """Register a section of bodies under its text; label: its function in LaTeX; over: the radius on the axis."""

    def entered(cls):
        cls.label = label
        cls.over = over
        OF_BODIES[text] = cls
        return _section(cls)

    return entered


@_section
class Hyperplane(NamedTuple):
    """The hyperplane normal . z = offset of the phase space, for a system of any number of degrees of freedom.

    Parameters
    ----------
    normal : tuple of 2n floats
        Entries in the row order of z; x = 0 of Henon-Heiles is Hyperplane(normal=(1, 0, 0, 0)).
    offset : float, default 0
        Value of normal . z on the section.
    direction : {1, -1, 0}, default 1
        Sign of the crossings that count; 0: both.

    Examples
    --------
    >>> fa.Hyperplane((1.0, 0.0, 0.0, 0.0), offset=0.25).value(0.5, 0.0, 0.3, 0.0)
    0.25
    """

    normal: tuple[float, ...]
    offset: float = 0.0
    direction: int = 1

    def value(self, *z):
        """Return normal . z - offset."""
        total = -self.offset
        for i in range(len(z)):
            total = total + self.normal[i] * z[i]
        return total


@_section
class AngleEquals(NamedTuple):
    """The surfaces normal . z = offset, up to whole periods, for instance of a winding angle.

    Parameters
    ----------
    normal : tuple of 2n floats
        Entries in the row order of z.
    offset : float, default 0
        Value of normal . z on the section.
    period : float > 0, default 2 pi
        Crossings of offset plus any multiple of it count.
    direction : {1, -1, 0}, default 1
        Sign of the crossings that count; 0: both.

    Examples
    --------
    >>> fa.models.sections.AngleEquals((1.0, 0.0)).value(6.5, 0.3).round(6)
    np.float64(0.216815)
    """

    normal: tuple[float, ...]
    offset: float = 0.0
    period: float = 2 * np.pi
    direction: int = 1

    def value(self, *z):
        """Return normal . z - offset, reduced to half a period around 0."""
        total = -self.offset
        for i in range(len(z)):
            total = total + self.normal[i] * z[i]
        return total - self.period * np.floor(total / self.period + 0.5)


@_of_bodies("alpha-turning", r"p_{\alpha}", "beta")
class AlphaTurning(NamedTuple):
    """Turning points of alpha, p_alpha = 0: the section function is alpha p_alpha = a . p_a.

    Parameters
    ----------
    direction : {1, -1, 0}, default 1
        +1, increasing: minima of alpha; -1, decreasing: maxima; 0: both.

    References
    ----------
    EQ2.0b of Martens & Slawianowski.

    Examples
    --------
    >>> fa.AlphaTurning().value(1.0, 0.0, 0.5, 0.0, 0.3, 0.1, 0.0, 0.2)
    0.3
    """

    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return alpha p_alpha."""
        return a1 * pa1 + a2 * pa2


@_of_bodies("beta-turning", r"p_{\beta}", "alpha")
class BetaTurning(NamedTuple):
    """Turning points of beta, p_beta = 0: the section function is beta p_beta = b . p_b, smooth through beta = 0.

    Parameters
    ----------
    direction : {1, -1, 0}, default 1
        +1, increasing: minima of beta; -1, decreasing: maxima; 0: both.

    References
    ----------
    EQ2.0b of Martens & Slawianowski.

    Examples
    --------
    >>> fa.BetaTurning().value(1.0, 0.0, 0.5, 0.0, 0.3, 0.1, 0.2, 0.2)
    0.1
    """

    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return beta p_beta."""
        return b1 * pb1 + b2 * pb2


@_of_bodies("alpha", r"\alpha", "beta")
class AlphaEquals(NamedTuple):
    """The surface alpha = constant: the section function is alpha - constant.

    Parameters
    ----------
    constant : float > 0
        Value of alpha.
    direction : {1, -1, 0}, default 1
        Sign of the crossings that count; 0: both.

    Examples
    --------
    >>> fa.AlphaEquals(1.2).value(1.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0).round(9)
    np.float64(0.3)
    """

    constant: float
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return alpha - constant."""
        return np.sqrt(a1 * a1 + a2 * a2) - self.constant

    def radii(self, u):
        """Return alpha and beta over u = beta."""
        return np.full(u.shape, float(self.constant)), u


@_of_bodies("beta", r"\beta", "alpha")
class BetaEquals(NamedTuple):
    """The surface beta = constant > 0: the section function is beta - constant.

    Parameters
    ----------
    constant : float > 0
        Value of beta.
    direction : {1, -1, 0}, default 1
        Sign of the crossings that count; 0: both.

    Examples
    --------
    >>> fa.BetaEquals(0.25).value(1.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
    np.float64(0.25)
    """

    constant: float
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return beta - constant."""
        return np.sqrt(b1 * b1 + b2 * b2) - self.constant

    def radii(self, u):
        """Return alpha and beta over u = alpha."""
        return u, np.full(u.shape, float(self.constant))


@_of_bodies("area", "D_1D_2", "beta")
class AreaEquals(NamedTuple):
    """The surface D1 D2 = constant (area ratio of the deformation): the section function is det phi - constant.

    Parameters
    ----------
    constant : float, default 1
        Value of det phi.
    direction : {1, -1, 0}, default 1
        Sign of the crossings that count; 0: both.

    References
    ----------
    EQ2.2x of Martens & Slawianowski, D1 D2 = (alpha^2 - beta^2)/2.

    Examples
    --------
    >>> fa.AreaEquals().value(2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    0.5
    """

    constant: float = 1.0
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return D1 D2 - constant."""
        return (a1 * a1 + a2 * a2 - b1 * b1 - b2 * b2) / 2 - self.constant

    def radii(self, u):
        """Return alpha and beta over u = beta."""
        return np.sqrt(2 * self.constant + u * u), u

    def slopes(self, alpha, beta):
        """Return the derivatives of D1 D2 by alpha and by beta."""
        return alpha, -beta

    def leaning(self, u):
        """Return (d alpha/d beta)^2 over u = beta."""
        return np.square(u) / (2 * self.constant + np.square(u))


@_section
class Stroboscopic(NamedTuple):
    """Times at which the drive of a driven system has a given phase: t = phase, up to whole periods.

    The times between crossings are exact multiples of the period; a start on the section is no crossing.

    Parameters
    ----------
    phase : float, time, default 0
        Phase of the drive.

    References
    ----------
    Poincare 1899, Les methodes nouvelles de la mecanique celeste III (the map over a period).

    Examples
    --------
    >>> pendulum = fa.hamiltonian("-(1 + e*cos(t))*cos(x)", coordinates="x", drive_period="2*pi", e=0.1)
    >>> cut = fa.poincare_map(pendulum, [0.3, 0.0], section=fa.models.sections.Stroboscopic(), crossings=3)
    >>> (cut.times[:, 0] / (2 * np.pi)).round(9)
    array([1., 2., 3.])
    """

    phase: float = 0.0

    @property
    def direction(self) -> int:
        """+1: the time increases."""
        return 1

    def value(self, *z):
        """Return t - phase."""
        return z[len(z) // 2 - 1] - self.phase
