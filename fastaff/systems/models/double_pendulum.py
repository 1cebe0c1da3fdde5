"""The double pendulum: H(q, p) whose kinetic energy depends on the angles."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .contracts import Kind


class DoublePendulum(NamedTuple):
    """Model two masses on massless rods, one below the other.

    The coordinates are the angles q1 and q2 from straight down. The momenta p1 and p2 are the angular momenta dL/dq1'
    and dL/dq2'. Units must be consistent.

    Parameters
    ----------
    m_1, m_2 : float, mass, default 1
        Upper and lower mass.
    l_1, l_2 : float, length, default 1
        Upper and lower rod.
    g : float, acceleration, default 1
        Gravity.

    Notes
    -----
    The Hamiltonian, with D = m_1 + m_2 sin(q1 - q2)^2, is

    ::

        H = (m_2 l_2^2 p1^2 + (m_1 + m_2) l_1^2 p2^2 - 2 m_2 l_1 l_2 cos(q1 - q2) p1 p2)/(2 m_2 l_1^2 l_2^2 D)
            - (m_1 + m_2) g l_1 cos q1 - m_2 g l_2 cos q2

    References
    ----------
    Landau & Lifshitz, Mechanics, section 5, problem 1; Richter & Scholz 1984, in: Stochastic Phenomena and Chaotic
    Behaviour in Complex Systems, p. 86 (its chaos).

    Examples
    --------
    >>> fa.models.DoublePendulum().joints(0.0, np.pi / 2)
    ((np.float64(0.0), np.float64(0.0), np.float64(1.0)), (np.float64(-0.0), np.float64(-1.0), np.float64(-1.0)))
    """

    m_1: float = 1.0
    m_2: float = 1.0
    l_1: float = 1.0
    l_2: float = 1.0
    g: float = 1.0

    @property
    def degrees_of_freedom(self) -> int:
        """Return 2."""
        return 2

    def periods(self):
        """Return the periods of the rows.

        Returns
        -------
        tuple of float
            Periods of q1, q2, p1, p2; 0 for momenta.
        """
        return 2 * np.pi, 2 * np.pi, 0.0, 0.0

    def inverse_masses(self):
        """Return the coefficients of the kinetic energy.

        Returns
        -------
        tuple of float
            Factors of p1^2/D, p2^2/D and cos(q1 - q2) p1 p2/D in 2H, half of the last.
        """
        a = self.l_1
        b = self.l_2
        return 1 / (a * a), (self.m_1 + self.m_2) / (self.m_2 * b * b), -1 / (a * b)

    def weights(self):
        """Return the coefficients of the potential energy.

        Returns
        -------
        tuple of float
            Numbers (m_1 + m_2) g l_1 and m_2 g l_2.
        """
        return (self.m_1 + self.m_2) * self.g * self.l_1, self.m_2 * self.g * self.l_2

    def shape(self, q1, q2):
        """Return 1/D and cos(q1 - q2)/D with their derivatives.

        Parameters
        ----------
        q1, q2 : float or array_like, radians
            Angles from straight down.

        Returns
        -------
        tuple of float or ndarray
            Values u, u', u'', w, w', w'' of u = 1/D and w = cos(q1 - q2)/D; derivatives are with respect to q1 - q2.
        """
        s, c = np.sin(q1 - q2), np.cos(q1 - q2)
        u = 1 / (self.m_1 + self.m_2 * s * s)
        slope = 2 * self.m_2 * s * c
        u1 = -slope * u * u
        u2 = 2 * u * u * (slope * slope * u - self.m_2 * (c * c - s * s))
        return u, u1, u2, c * u, c * u1 - s * u, c * u2 - 2 * s * u1 - c * u

    def energy(self, q1, q2, p1, p2):
        """Return the energy H.

        Parameters
        ----------
        q1, q2 : float or array_like, radians
            Angles from straight down.
        p1, p2 : float or array_like
            Angular momenta.

        Returns
        -------
        float or ndarray
            Energy H.
        """
        a, b, d = self.inverse_masses()
        f, g = self.weights()
        u, _, _, w, _, _ = self.shape(q1, q2)
        return (a * p1 * p1 + b * p2 * p2) * u / 2 + d * w * p1 * p2 - f * np.cos(q1) - g * np.cos(q2)

    def rates(self, q1, q2, p1, p2):
        """Return the rates of the rows.

        Parameters
        ----------
        q1, q2 : float or array_like, radians
            Angles from straight down.
        p1, p2 : float or array_like
            Angular momenta.

        Returns
        -------
        tuple of float or ndarray
            Four rows: dH/dp, then -dH/dq.
        """
        a, b, d = self.inverse_masses()
        f, g = self.weights()
        u, u1, _, w, w1, _ = self.shape(q1, q2)
        turn = (a * p1 * p1 + b * p2 * p2) * u1 / 2 + d * w1 * p1 * p2
        return a * u * p1 + d * w * p2, d * w * p1 + b * u * p2, -turn - f * np.sin(q1), turn - g * np.sin(q2)

    def tangent_rates(self, q1, q2, p1, p2, dq1, dq2, dp1, dp2):
        """Return the change of the rates along a vector.

        Parameters
        ----------
        q1, q2 : float or array_like, radians
            Angles from straight down.
        p1, p2 : float or array_like
            Angular momenta.
        dq1, dq2, dp1, dp2 : float or array_like
            Vector of changes of the rows.

        Returns
        -------
        tuple of float or ndarray
            Four rows: the changes of dH/dp, then of -dH/dq.
        """
        a, b, d = self.inverse_masses()
        f, g = self.weights()
        u, u1, u2, w, w1, w2 = self.shape(q1, q2)
        x = dq1 - dq2
        turn = (a * p1 * dp1 + b * p2 * dp2) * u1 + d * (dp1 * p2 + p1 * dp2) * w1
        turn = turn + ((a * p1 * p1 + b * p2 * p2) * u2 / 2 + d * w2 * p1 * p2) * x
        return (
            a * (u * dp1 + u1 * x * p1) + d * (w * dp2 + w1 * x * p2),
            d * (w * dp1 + w1 * x * p1) + b * (u * dp2 + u1 * x * p2),
            -turn - f * np.cos(q1) * dq1,
            turn - g * np.cos(q2) * dq2,
        )

    def joints(self, q1, q2):
        """Return the positions of the suspension and of both masses, for animations.

        Parameters
        ----------
        q1, q2 : float or array_like, radians
            Angles from straight down.

        Returns
        -------
        tuple of tuples
            Values of x, then of y, of the three points. The axis of y points upwards.
        """
        x = self.l_1 * np.sin(q1)
        y = -self.l_1 * np.cos(q1)
        return (0.0 * x, x, x + self.l_2 * np.sin(q2)), (0.0 * y, y, y - self.l_2 * np.cos(q2))

    def margin(self, q1, q2, p1, p2):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        q1, q2 : float or array_like, radians
            Angles from straight down.
        p1, p2 : float or array_like
            Angular momenta.

        Returns
        -------
        float or ndarray
            1: the system is defined everywhere.
        """
        return 1.0 + 0.0 * (q1 + q2 + p1 + p2)


_named: Any = DoublePendulum
_named.kind = Kind.NONSEPARABLE
_named.coordinates = ("q1", "q2")
_named.momenta = ("p1", "p2")
