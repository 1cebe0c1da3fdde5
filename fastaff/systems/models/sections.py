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

from ...core.docstrings import inserts_parameters


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
@inserts_parameters
class Hyperplane(NamedTuple):
    """Hyperplane ``normal @ z = offset`` of phase space, for any number of degrees of freedom.

    Parameters
    ----------
    normal : tuple of float, length 2n
        Normal vector, in the row order of z: x = 0 of `HenonHeiles` is ``Hyperplane(normal=(1, 0, 0, 0))``.
    offset : float, default 0
        Value of ``normal @ z`` on the section.
    {direction}

    Examples
    --------
    >>> fa.Hyperplane((1.0, 0.0, 0.0, 0.0), offset=0.25).value(0.5, 0.0, 0.3, 0.0)
    0.25
    """

    normal: tuple[float, ...]
    offset: float = 0.0
    direction: int = 1

    def value(self, *z):
        """Return ``normal @ z - offset``.

        Parameters
        ----------
        *z : float or ndarray
            Coordinates, then momenta.

        Returns
        -------
        float or ndarray
            Section function.
        """
        total = -self.offset
        for i in range(len(z)):
            total = total + self.normal[i] * z[i]
        return total


@_section
@inserts_parameters
class AngleEquals(NamedTuple):
    """Surfaces on which ``normal @ z`` equals an offset up to whole periods, for example of a periodic coordinate.

    Parameters
    ----------
    normal : tuple of float, length 2n
        Normal vector, in the row order of z.
    offset : float, default 0
        Value of ``normal @ z`` on the section.
    period : float, default 2 pi
        Positive period of the section function. Crossings of the offset plus any multiple of it count.
    {direction}

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
        """Return ``normal @ z - offset``, reduced to half a period around 0.

        Parameters
        ----------
        *z : float or ndarray
            Coordinates, then momenta.

        Returns
        -------
        float or ndarray
            Section function.
        """
        total = -self.offset
        for i in range(len(z)):
            total = total + self.normal[i] * z[i]
        return total - self.period * np.floor(total / self.period + 0.5)


@_of_bodies("alpha-turning", r"p_{\alpha}", "beta")
class AlphaTurning(NamedTuple):
    r"""Turning points of alpha of a body, :math:`p_\alpha = 0`.

    Parameters
    ----------
    direction : {1, -1, 0}, default 1
        Crossings that count: 1 is minima of alpha, -1 is maxima, 0 is both.

    Notes
    -----
    The section function is :math:`\alpha p_\alpha = a \cdot p_a`.

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
        """Return ``alpha p_alpha``.

        Parameters
        ----------
        a1, a2, b1, b2 : float or ndarray
            Coordinates in the planes a and b.
        pa1, pa2, pb1, pb2 : float or ndarray
            Momenta of these coordinates.

        Returns
        -------
        float or ndarray
            Section function, a product of a coordinate and a momentum.
        """
        return a1 * pa1 + a2 * pa2


@_of_bodies("beta-turning", r"p_{\beta}", "alpha")
class BetaTurning(NamedTuple):
    r"""Turning points of beta of a body, :math:`p_\beta = 0`.

    Parameters
    ----------
    direction : {1, -1, 0}, default 1
        Crossings that count: 1 is minima of beta, -1 is maxima, 0 is both.

    Notes
    -----
    The section function is :math:`\beta p_\beta = b \cdot p_b`. It is smooth at :math:`\beta = 0`.

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
        """Return ``beta p_beta``.

        Parameters
        ----------
        a1, a2, b1, b2 : float or ndarray
            Coordinates in the planes a and b.
        pa1, pa2, pb1, pb2 : float or ndarray
            Momenta of these coordinates.

        Returns
        -------
        float or ndarray
            Section function, a product of a coordinate and a momentum.
        """
        return b1 * pb1 + b2 * pb2


@_of_bodies("alpha", r"\alpha", "beta")
@inserts_parameters
class AlphaEquals(NamedTuple):
    """Surface on which alpha of a body is constant; the section function is alpha less the constant.

    Parameters
    ----------
    constant : float
        Positive value of alpha.
    {direction}

    Examples
    --------
    >>> fa.AlphaEquals(1.2).value(1.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0).round(9)
    np.float64(0.3)
    """

    constant: float
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return alpha less the constant.

        Parameters
        ----------
        a1, a2, b1, b2 : float or ndarray
            Coordinates in the planes a and b.
        pa1, pa2, pb1, pb2 : float or ndarray
            Momenta of these coordinates.

        Returns
        -------
        float or ndarray
            Section function, a length.
        """
        return np.sqrt(a1 * a1 + a2 * a2) - self.constant

    def radii(self, u):
        """Return alpha and beta of points of the section.

        Parameters
        ----------
        u : ndarray
            Values of beta.

        Returns
        -------
        tuple of ndarray
            Values of alpha and beta, of the shape of `u`.
        """
        return np.full(u.shape, float(self.constant)), u


@_of_bodies("beta", r"\beta", "alpha")
@inserts_parameters
class BetaEquals(NamedTuple):
    """Surface on which beta of a body is constant; the section function is beta less the constant.

    Parameters
    ----------
    constant : float
        Positive value of beta.
    {direction}

    Examples
    --------
    >>> fa.BetaEquals(0.25).value(1.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
    np.float64(0.25)
    """

    constant: float
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return beta less the constant.

        Parameters
        ----------
        a1, a2, b1, b2 : float or ndarray
            Coordinates in the planes a and b.
        pa1, pa2, pb1, pb2 : float or ndarray
            Momenta of these coordinates.

        Returns
        -------
        float or ndarray
            Section function, a length.
        """
        return np.sqrt(b1 * b1 + b2 * b2) - self.constant

    def radii(self, u):
        """Return alpha and beta of points of the section.

        Parameters
        ----------
        u : ndarray
            Values of alpha.

        Returns
        -------
        tuple of ndarray
            Values of alpha and beta, of the shape of `u`.
        """
        return u, np.full(u.shape, float(self.constant))


@_of_bodies("area", "D_1D_2", "beta")
@inserts_parameters
class AreaEquals(NamedTuple):
    r"""Surface on which the area ratio D1 D2 of a deformed body is constant.

    Parameters
    ----------
    constant : float, default 1
        Value of the area ratio, the determinant of the configuration.
    {direction}

    Notes
    -----
    The section function is :math:`\det\varphi - c`, where :math:`c` is the constant and :math:`\det\varphi = D_1 D_2 =
    (\alpha^2 - \beta^2)/2`.

    References
    ----------
    EQ2.2x of Martens & Slawianowski.

    Examples
    --------
    >>> fa.AreaEquals().value(2.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    0.5
    """

    constant: float = 1.0
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return D1 D2 less the constant.

        Parameters
        ----------
        a1, a2, b1, b2 : float or ndarray
            Coordinates in the planes a and b.
        pa1, pa2, pb1, pb2 : float or ndarray
            Momenta of these coordinates.

        Returns
        -------
        float or ndarray
            Section function, an area.
        """
        return (a1 * a1 + a2 * a2 - b1 * b1 - b2 * b2) / 2 - self.constant

    def radii(self, u):
        """Return alpha and beta of points of the section.

        Parameters
        ----------
        u : ndarray
            Values of beta.

        Returns
        -------
        tuple of ndarray
            Values of alpha and beta, of the shape of `u`.
        """
        return np.sqrt(2 * self.constant + u * u), u

    def slopes(self, alpha, beta):
        """Return the derivatives of D1 D2 with respect to alpha and beta.

        Parameters
        ----------
        alpha : ndarray
            Values of alpha.
        beta : ndarray
            Values of beta.

        Returns
        -------
        tuple of ndarray
            Both derivatives.
        """
        return alpha, -beta

    def leaning(self, u):
        r"""Return the squared derivative of alpha with respect to beta along the section.

        Parameters
        ----------
        u : ndarray
            Values of beta.

        Returns
        -------
        ndarray
            :math:`(d\alpha/d\beta)^2`.
        """
        return np.square(u) / (2 * self.constant + np.square(u))


@_section
class Stroboscopic(NamedTuple):
    """Times at which the drive of a system has a given phase: ``t = phase``, up to multiples of the drive period.

    Parameters
    ----------
    phase : float, default 0
        Phase of the drive, in units of time.

    Notes
    -----
    The times between crossings are exact multiples of the drive period. Initial conditions on the section do not count
    as a crossing.

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
        """Direction of the crossings: 1, because the time increases."""
        return 1

    def value(self, *z):
        """Return the time less the phase.

        Parameters
        ----------
        *z : float or ndarray
            Rows of the state; the last coordinate is the time.

        Returns
        -------
        float or ndarray
            Section function, a time.
        """
        return z[len(z) // 2 - 1] - self.phase
