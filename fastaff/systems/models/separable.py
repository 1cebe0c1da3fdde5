"""Potentials that separate in a chart, from functions of one variable, and the body with angular potentials.

With V_eta and V_gamma constant the general separable Hamiltonians are doubly isotropic bodies; the angular terms are
the same V_eta(eta)/alpha^2 + V_gamma(gamma)/beta^2 in all three charts, so they belong to the body, `StackelBody`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from .angles import AlphaBeta, RVartheta
from .contracts import Arithmetic, OneVariable
from .energy_method import energy_method

TINY = 1e-300
"""Added to A and B under square roots: slopes at alpha = 0 or beta = 0 are those of a neighbouring point."""


@inserts_parameters
class SeparableAlphaBeta(NamedTuple):
    """Define a potential that separates in (alpha, beta).

    Parameters
    ----------
    V_alpha, V_beta : function of one variable
        Terms of V: each a class of ``fastaff.models`` or a result of `univariate`.

    Notes
    -----
    The potential energy is ``V = V_alpha(alpha) + V_beta(beta)``. `StackelBody` adds the terms V_eta and V_gamma.

    References
    ----------
    Martens & Slawianowski, EQ2.1.

    Examples
    --------
    >>> fa.SeparableAlphaBeta(fa.models.Oscillator(k=1.0), fa.models.Oscillator(k=4.0)).value(1.0, 1.0)
    np.float64(2.5)
    """

    V_alpha: OneVariable
    V_beta: OneVariable

    @property
    def angles(self) -> AlphaBeta:
        """Angle variables natural to this potential."""
        return AlphaBeta()

    @property
    def alpha_beta(self) -> SeparableAlphaBeta:
        """Itself: the potential as a member of this family."""
        return self

    def value(self, A, B):
        """Return the potential energy V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.V_alpha.value(np.sqrt(A)) + self.V_beta.value(np.sqrt(B))

    def slopes(self, A, B):
        """Return the first derivatives of V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        tuple of float or ndarray
            V_A and V_B, the derivatives with respect to A and B.
        """
        alpha, beta = np.sqrt(A + TINY), np.sqrt(B + TINY)
        return self.V_alpha.slope(alpha) / (2 * alpha), self.V_beta.slope(beta) / (2 * beta)

    def curvatures(self, A, B):
        """Return the second derivatives of V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        tuple of float or ndarray
            V_AA, V_AB and V_BB, the derivatives with respect to A and B.
        """
        alpha, beta = np.sqrt(A + TINY), np.sqrt(B + TINY)
        V_AA = (self.V_alpha.curvature(alpha) - self.V_alpha.slope(alpha) / alpha) / (4 * alpha * alpha)
        V_BB = (self.V_beta.curvature(beta) - self.V_beta.slope(beta) / beta) / (4 * beta * beta)
        return V_AA, 0.0 * A, V_BB

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            0.5 if V is finite, else -0.5.
        """
        V = self.value(A, B)
        return 1.0 * (V - V == 0) - 0.5


@inserts_parameters
class SeparableRVartheta(NamedTuple):
    """Define a potential that separates in (r, vartheta).

    Parameters
    ----------
    V_r, V_vartheta : function of one variable
        Terms of V: each a class of ``fastaff.models`` or a result of `univariate`.

    Notes
    -----
    The potential energy is ``V = V_r(r) + V_vartheta(vartheta)/r`` with r = alpha^2 + beta^2 and tan(vartheta/2) =
    beta/alpha. `StackelBody` adds the terms V_eta and V_gamma.

    References
    ----------
    Martens & Slawianowski, EQ2.2f.

    Examples
    --------
    >>> fa.SeparableRVartheta(fa.models.Spring(k=1.0), fa.models.Cosine(k=0.5)).value(1.0, 0.0)
    np.float64(1.0)
    """

    V_r: OneVariable
    V_vartheta: OneVariable

    @property
    def angles(self) -> RVartheta:
        """Angle variables natural to this potential."""
        return RVartheta()

    @property
    def r_vartheta(self) -> SeparableRVartheta:
        """Itself: the potential as a member of this family."""
        return self

    def value(self, A, B):
        """Return the potential energy V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.V_r.value(A + B) + self.V_vartheta.value(2 * np.arctan2(np.sqrt(B), np.sqrt(A))) / (A + B)

    def slopes(self, A, B):
        """Return the first derivatives of V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        tuple of float or ndarray
            V_A and V_B, the derivatives with respect to A and B.
        """
        r = A + B
        alpha = np.sqrt(A + TINY)
        beta = np.sqrt(B + TINY)
        w = 1 / r
        vartheta = 2 * np.arctan2(beta, alpha)
        along = self.V_r.slope(r) - w * w * self.V_vartheta.value(vartheta)
        across = w * w * self.V_vartheta.slope(vartheta)
        return along - across * beta / alpha, along + across * alpha / beta

    def curvatures(self, A, B):
        """Return the second derivatives of V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        tuple of float or ndarray
            V_AA, V_AB and V_BB, the derivatives with respect to A and B.
        """
        r = A + B
        alpha = np.sqrt(A + TINY)
        beta = np.sqrt(B + TINY)
        w = 1 / r
        vartheta = 2 * np.arctan2(beta, alpha)
        x = beta / alpha
        y = alpha / beta
        cube = w * w * w
        U = cube * self.V_vartheta.value(vartheta)
        slope = cube * self.V_vartheta.slope(vartheta)
        curvature = cube * self.V_vartheta.curvature(vartheta)
        radial = self.V_r.curvature(r) + 2 * U
        return (
            radial + curvature * x * x + slope * x * (3.5 + 0.5 * x * x),
            radial - curvature + 1.5 * slope * (x - y),
            radial + curvature * y * y - slope * y * (3.5 + 0.5 * y * y),
        )

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            0.5 if V is finite, else -0.5.
        """
        V = self.value(A, B)
        return 1.0 * (V - V == 0) - 0.5


@inserts_parameters
class SeparableElliptic(NamedTuple):
    """Define a potential that separates in the elliptic variables (kappa, lambda).

    Parameters
    ----------
    V_kappa, V_lambda : function of one variable
        Terms of V: each a class of ``fastaff.models`` or a result of `univariate`.

    Notes
    -----
    The potential energy is ``V = (V_kappa(kappa) + V_lambda(lambda))/(2 (cosh^2 kappa - cos^2 lambda))``. The variables
    follow from alpha = sqrt2 cosh(kappa) cos(lambda) and beta = sqrt2 sinh(kappa) sin(lambda).

    The focus kappa = lambda = 0 of the chart is the undeformed body. V has the form 0/0 there if V_kappa(0) +
    V_lambda(0) = 0, and is singular otherwise. `StackelBody` adds the terms V_eta and V_gamma.

    References
    ----------
    Martens & Slawianowski, the elliptic Hamiltonian of section 3.

    Examples
    --------
    >>> fa.SeparableElliptic(fa.models.CoshOscillator(), fa.models.CosOscillator()).value(3.0, 0.5).round(12)
    np.float64(1.75)
    """

    V_kappa: OneVariable
    V_lambda: OneVariable

    @property
    def angles(self) -> AlphaBeta:
        """Angle variables that serve this potential."""
        return AlphaBeta()

    @property
    def elliptic(self) -> SeparableElliptic:
        """Itself: the potential as a member of this family."""
        return self

    def squares(self, A, B):
        """Return the squares of sinh(kappa) and sin(lambda).

        Parameters
        ----------
        {invariants}

        Returns
        -------
        tuple of float or ndarray
            Values of sinh^2(kappa) and sin^2(lambda), without cancellation, and 0 at the boundaries of the chart.
        """
        sigma = (A + B) / 2 - 1
        root = np.sqrt(sigma * sigma + 2 * B)
        large = (np.sqrt(sigma * sigma) + root) / 2
        small = B / (2 * large + TINY)
        outside = 1.0 * (sigma >= 0)  # arithmetic: a scalar np.where is slow in compiled code
        return outside * large + (1 - outside) * small, outside * small + (1 - outside) * large

    def value(self, A, B):
        """Return the potential energy V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        s, t = self.squares(A, B)
        return (self.V_kappa.value(np.arcsinh(np.sqrt(s))) + self.V_lambda.value(np.arcsin(np.sqrt(t)))) / (2 * (s + t))

    def slopes(self, A, B):
        """Return the first derivatives of V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        tuple of float or ndarray
            V_A and V_B, the derivatives with respect to A and B.
        """
        s, t = self.squares(A, B + TINY)
        width = s + t
        kappa = np.arcsinh(np.sqrt(s))
        lam = np.arcsin(np.sqrt(t))
        V = (self.V_kappa.value(kappa) + self.V_lambda.value(lam)) / (2 * width)
        V_s = self.V_kappa.slope(kappa) / (4 * width * np.sqrt(s * (1 + s)) + TINY) - V / width
        V_t = self.V_lambda.slope(lam) / (4 * width * np.sqrt(t * (1 - t)) + TINY) - V / width
        # s - t = (A + B)/2 - 1 and s t = B/2 give the derivatives of s and t.
        V_A = (V_s * s - V_t * t) / (2 * width)
        return V_A, V_A + (V_s + V_t) / (2 * width)

    def curvatures(self, A, B):
        """Return the second derivatives of V.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        tuple of float or ndarray
            V_AA, V_AB and V_BB, the derivatives with respect to A and B.
        """
        s, t = self.squares(A, B + TINY)
        kappa = np.arcsinh(np.sqrt(s))
        lam = np.arcsin(np.sqrt(t))
        h = 0.5 / (s + t)
        S = s * (1 + s) + TINY
        T = t * (1 - t) + TINY
        slope_s = self.V_kappa.slope(kappa) / (2 * np.sqrt(S))
        slope_t = self.V_lambda.slope(lam) / (2 * np.sqrt(T))
        f = h * slope_s
        ff = h * (self.V_kappa.curvature(kappa) - 2 * (1 + 2 * s) * slope_s) / (4 * S)
        g = h * slope_t
        gg = h * (self.V_lambda.curvature(lam) - 2 * (1 - 2 * t) * slope_t) / (4 * T)
        V = h * (self.V_kappa.value(kappa) + self.V_lambda.value(lam))
        # d/ds and d/dt of V = (V_kappa + V_lambda)/(2 (s + t)), then of s and t by A and B
        V_s = f - 2 * h * V
        V_t = g - 2 * h * V
        V_ss = ff - 2 * h * (f + V_s - 2 * h * V)
        V_st = -2 * h * (f + V_t - 2 * h * V)
        V_tt = gg - 2 * h * (g + V_t - 2 * h * V)
        s_A = h * s
        t_A = -h * t
        s_B = h * (1 + s)
        t_B = h * (1 - t)
        w_A = 2 * h * (s_A + t_A)
        w_B = 2 * h * (s_B + t_B)
        s_AA = h * s_A - s_A * w_A
        t_AA = -h * t_A - t_A * w_A
        s_AB = h * s_B - s_A * w_B
        t_AB = -h * t_B - t_A * w_B
        s_BB = h * s_B - s_B * w_B
        t_BB = -h * t_B - t_B * w_B
        return (
            V_ss * s_A * s_A + 2 * V_st * s_A * t_A + V_tt * t_A * t_A + V_s * s_AA + V_t * t_AA,
            V_ss * s_A * s_B + V_st * (s_A * t_B + s_B * t_A) + V_tt * t_A * t_B + V_s * s_AB + V_t * t_AB,
            V_ss * s_B * s_B + 2 * V_st * s_B * t_B + V_tt * t_B * t_B + V_s * s_BB + V_t * t_BB,
        )

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            0.5 if V is finite, else -0.5.
        """
        V = self.value(A, B)
        return 1.0 * (V - V == 0) - 0.5


@inserts_parameters
class StackelBody(NamedTuple):
    """Model a body with angular potentials.

    Parameters
    ----------
    potential : potential
        Doubly isotropic potential, such as `SeparableAlphaBeta`.
    V_eta, V_gamma : function of one variable
        Functions of the angles eta and gamma with the period 2 pi.
    {inertia}

    Notes
    -----
    The Hamiltonian is ``H = |p|^2/(2 mu) + V(alpha, beta) + V_eta(eta)/alpha^2 + V_gamma(gamma)/beta^2``. With a
    potential of a separable family the body is integrable but not isotropic: spin and vorticity are not conserved.

    References
    ----------
    Martens & Slawianowski, EQ2.1, EQ2.2f and the elliptic Hamiltonian of section 3.

    Examples
    --------
    >>> body = fa.models.StackelBody(fa.Harmonic(), fa.models.Zero(), fa.models.Cosine(k=0.5))
    >>> body.potential_energy(1.0, 0.0, 0.5, 0.0)
    np.float64(2.625)
    """

    potential: Any
    V_eta: OneVariable
    V_gamma: OneVariable
    mu: float = 1.0

    @property
    def isotropic(self) -> bool:
        """Whether p_eta and p_gamma are conserved: no."""
        return False

    @property
    def degrees_of_freedom(self) -> int:
        """Return 4."""
        return 4

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the first 4 rows of z."""
        return "a1", "a2", "b1", "b2"

    def velocity(self, pa1, pa2, pb1, pb2):
        """Return the velocity dq/dt = p/mu.

        Parameters
        ----------
        {plane_momenta}

        Returns
        -------
        tuple of float or ndarray
            Four rows: the rates of a1, a2, b1, b2.
        """
        w = 1.0 / self.mu
        return w * pa1, w * pa2, w * pb1, w * pb2

    @property
    def energy(self) -> Arithmetic:
        """Function H(q..., p...): ``model.energy(*z)`` for phase points z (2n, ...), NaN outside the domain."""
        return energy_method(self)

    def kinetic_energy(self, pa1, pa2, pb1, pb2):
        """Return the kinetic energy.

        Parameters
        ----------
        {plane_momenta}

        Returns
        -------
        float or ndarray
            Energy T = ``|p|^2``/(2 mu).
        """
        return (pa1 * pa1 + pa2 * pa2 + pb1 * pb1 + pb2 * pb2) / (2 * self.mu)

    def force(self, a1, a2, b1, b2):
        """Return the force dp/dt = -grad V.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        tuple of float or ndarray
            Four rows: the rates of the momenta.
        """
        A = a1 * a1 + a2 * a2 + TINY
        B = b1 * b1 + b2 * b2 + TINY
        V_A, V_B = self.potential.slopes(A, B)
        eta = np.arctan2(a2, a1)
        gamma = np.arctan2(b2, b1)
        radial_a = -2 * (V_A - self.V_eta.value(eta) / A / A)
        around_a = self.V_eta.slope(eta) / A / A
        radial_b = -2 * (V_B - self.V_gamma.value(gamma) / B / B)
        around_b = self.V_gamma.slope(gamma) / B / B
        return (
            radial_a * a1 + around_a * a2,
            radial_a * a2 - around_a * a1,
            radial_b * b1 + around_b * b2,
            radial_b * b2 - around_b * b1,
        )

    def tangent_force(self, a1, a2, b1, b2, da1, da2, db1, db2):
        """Return the change of the force along a vector.

        Parameters
        ----------
        {plane_coordinates}
        {plane_changes}

        Returns
        -------
        tuple of float or ndarray
            Four rows: minus the Hessian of V times the vector.
        """
        A = a1 * a1 + a2 * a2 + TINY
        B = b1 * b1 + b2 * b2 + TINY
        dA = 2 * (a1 * da1 + a2 * da2)
        dB = 2 * (b1 * db1 + b2 * db2)
        d_eta = (a1 * da2 - a2 * da1) / A
        d_gamma = (b1 * db2 - b2 * db1) / B
        eta = np.arctan2(a2, a1)
        gamma = np.arctan2(b2, b1)
        V_A, V_B = self.potential.slopes(A, B)
        V_AA, V_AB, V_BB = self.potential.curvatures(A, B)
        f = self.V_eta.value(eta)
        f_eta = self.V_eta.slope(eta)
        g = self.V_gamma.value(gamma)
        g_gamma = self.V_gamma.slope(gamma)
        # As in `force`: radial parts -2 (V_A - V_eta/A^2), parts around V_eta'/A^2, and their changes.
        radial_a = -2 * (V_A - f / A / A)
        around_a = f_eta / A / A
        radial_b = -2 * (V_B - g / B / B)
        around_b = g_gamma / B / B
        more_a = -2 * (V_AA * dA + V_AB * dB - f_eta * d_eta / A / A + 2 * f * dA / A / A / A)
        more_b = -2 * (V_AB * dA + V_BB * dB - g_gamma * d_gamma / B / B + 2 * g * dB / B / B / B)
        turn_a = (self.V_eta.curvature(eta) * d_eta - 2 * f_eta * dA / A) / A / A
        turn_b = (self.V_gamma.curvature(gamma) * d_gamma - 2 * g_gamma * dB / B) / B / B
        return (
            more_a * a1 + radial_a * da1 + turn_a * a2 + around_a * da2,
            more_a * a2 + radial_a * da2 - turn_a * a1 - around_a * da1,
            more_b * b1 + radial_b * db1 + turn_b * b2 + around_b * db2,
            more_b * b2 + radial_b * db2 - turn_b * b1 - around_b * db1,
        )

    def potential_energy(self, a1, a2, b1, b2):
        """Return the potential energy.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        A = a1 * a1 + a2 * a2 + TINY
        B = b1 * b1 + b2 * b2 + TINY
        angular = self.V_eta.value(np.arctan2(a2, a1)) / A + self.V_gamma.value(np.arctan2(b2, b1)) / B
        return self.potential.value(A, B) + angular

    def margin(self, a1, a2, b1, b2):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {plane_coordinates}

        Returns
        -------
        float or ndarray
            Margin of the potential.
        """
        return self.potential.margin(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)
