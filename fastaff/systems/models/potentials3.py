"""Isotropic potentials of the body in space: gas clouds and hyperelastic materials.

Each class gives `value`, `slopes`, `changes` (the change of the slopes along a vector) and `margin`, of the invariants
(I1, I2, J) or of the stretches (D1, D2, D3). The decorator adds the methods of matrices.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from .constructors import checks_arguments
from .letters import inertia_is_mu
from .matrix_potentials import of_invariants, of_stretches


def _is_power_law(arguments: Mapping[str, Any]) -> None:
    """Refuse gamma = 1, where V divides by 0."""
    gamma = arguments.get("gamma")
    if isinstance(gamma, (int, float)) and gamma == 1:
        raise ValueError(f"gamma must differ from 1, got {gamma}. Try fa.models.formula3('-k*log(J)', k=1.0).")


@checks_arguments(_is_power_law)
@of_invariants
@inserts_parameters
class GasCloud(NamedTuple):
    """Define the potential of an adiabatic gas cloud in a harmonic trap.

    Parameters
    ----------
    k : float, energy, default 1
        Strength of the gas: (gamma - 1) times its internal energy at J = 1.
    gamma : float, default 5/3
        Adiabatic exponent, above 1. An isothermal gas is ``formula3("-k*log(J)", k=...)``.
    C : float, energy, default 1
        Stiffness of the trap, 0 for a cloud that expands freely.

    Raises
    ------
    ValueError
        If gamma is 1.

    Notes
    -----
    * Potential energy: ``V = C (D1^2 + D2^2 + D3^2)/2 + k J^(1 - gamma)/(gamma - 1)`` with J = D1 D2 D3 > 0.
    * A homogeneous deformation of a cloud keeps the form of its density profile, so that phi obeys the equations of
      `Body3` exactly.
    * For gamma = 5/3 and every spin, R^2 = D1^2 + D2^2 + D3^2 oscillates harmonically with the angular frequency 2
      sqrt(C/mu). ``(R^2 |p|^2 - (phi . p)^2)/(2 mu) + R^2 k J^(1 - gamma)/(gamma - 1)`` is conserved.
    * The potential of the paper with (D1 D2 D3)^-p is gamma = 1 + p.

    References
    ----------
    Dyson 1968, J. Math. Mech. 18, 91 (spinning gas clouds); Gaffet 1996, J. Fluid Mech. 325, 113 (gamma = 5/3); Martens
    & Slawianowski, section 3, below EQ2.2h (bodies in space).

    Examples
    --------
    >>> round(float(fa.models.GasCloud(gamma=2.0).value(3.0, 3.0, 1.0)), 12)
    2.5
    """

    k: float = 1.0
    gamma: float = 5 / 3
    C: float = 1.0

    def value(self, I1, I2, J):
        """Return the potential energy V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.C * I1 / 2 + self.k * np.power(J, 1 - self.gamma) / (self.gamma - 1)

    def slopes(self, I1, I2, J):
        """Return the first derivatives of V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        tuple of float or ndarray
            Derivatives with respect to I1, I2 and J.
        """
        return self.C / 2 + 0.0 * I1, 0.0 * I2, -self.k * np.power(J, -self.gamma)

    def changes(self, I1, I2, J, dI1, dI2, dJ):
        """Return the change of the slopes along a vector.

        Parameters
        ----------
        {invariants3}
        {invariant_changes3}

        Returns
        -------
        tuple of float or ndarray
            Changes of the derivatives with respect to I1, I2 and J.
        """
        return 0.0 * dI1, 0.0 * dI2, self.k * self.gamma * np.power(J, -self.gamma) / J * dJ

    def margin(self, I1, I2, J):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            J, the volume.
        """
        return J + 0.0 * (I1 + I2)


@inertia_is_mu("fa.models.Body3(..., mu=...)")
@of_invariants
@inserts_parameters
class NeoHookean3(NamedTuple):
    """Define the potential of a compressible neo-Hookean material in space.

    Parameters
    ----------
    G : float, energy, default 1
        Shear modulus.
    K : float, energy, default 2
        Coefficient of the volume term.

    Notes
    -----
    The potential energy is ``V = G/2 (I1 - 3) - G ln J + K/2 (J - 1)^2``, defined for J > 0. If D3 = 1, it is the
    planar `NeoHookean` of D1 and D2.

    References
    ----------
    Ogden 1984, Non-Linear Elastic Deformations, section 7.2. The potential is not in the paper.

    Examples
    --------
    >>> fa.models.NeoHookean3().value(3.0, 3.0, 1.0)
    np.float64(0.0)
    """

    G: float = 1.0
    K: float = 2.0

    def value(self, I1, I2, J):
        """Return the potential energy V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.G * ((I1 - 3) / 2 - np.log(J)) + self.K / 2 * (J - 1) * (J - 1)

    def slopes(self, I1, I2, J):
        """Return the first derivatives of V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        tuple of float or ndarray
            Derivatives with respect to I1, I2 and J.
        """
        return self.G / 2 + 0.0 * I1, 0.0 * I2, self.K * (J - 1) - self.G / J

    def changes(self, I1, I2, J, dI1, dI2, dJ):
        """Return the change of the slopes along a vector.

        Parameters
        ----------
        {invariants3}
        {invariant_changes3}

        Returns
        -------
        tuple of float or ndarray
            Changes of the derivatives with respect to I1, I2 and J.
        """
        return 0.0 * dI1, 0.0 * dI2, (self.K + self.G / (J * J)) * dJ

    def margin(self, I1, I2, J):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            J, the volume.
        """
        return J + 0.0 * (I1 + I2)


@of_invariants
@inserts_parameters
class MooneyRivlin3(NamedTuple):
    """Define the potential of a compressible Mooney-Rivlin material in space.

    Parameters
    ----------
    c10, c01 : float, energy, default 0.4 and 0.1
        Coefficients of I1 and I2.
    K : float, energy, default 2
        Coefficient of the volume term.

    Notes
    -----
    The potential energy is ``V = c10 (I1 - 3) + c01 (I2 - 3) - (2 c10 + 4 c01) ln J + K/2 (J - 1)^2``, defined for J >
    0. The undeformed body is at rest. The shear modulus is 2 (c10 + c01).

    References
    ----------
    Ciarlet & Geymonat 1982, C. R. Acad. Sci. Paris II 295, 423; Ogden 1984, Non-Linear Elastic Deformations, section
    7.2. The potential is not in the paper.

    Examples
    --------
    >>> fa.models.MooneyRivlin3().value(3.0, 3.0, 1.0)
    np.float64(0.0)
    """

    c10: float = 0.4
    c01: float = 0.1
    K: float = 2.0

    def value(self, I1, I2, J):
        """Return the potential energy V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        shear = self.c10 * (I1 - 3) + self.c01 * (I2 - 3)
        return shear - (2 * self.c10 + 4 * self.c01) * np.log(J) + self.K / 2 * (J - 1) * (J - 1)

    def slopes(self, I1, I2, J):
        """Return the first derivatives of V.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        tuple of float or ndarray
            Derivatives with respect to I1, I2 and J.
        """
        return self.c10 + 0.0 * I1, self.c01 + 0.0 * I2, self.K * (J - 1) - (2 * self.c10 + 4 * self.c01) / J

    def changes(self, I1, I2, J, dI1, dI2, dJ):
        """Return the change of the slopes along a vector.

        Parameters
        ----------
        {invariants3}
        {invariant_changes3}

        Returns
        -------
        tuple of float or ndarray
            Changes of the derivatives with respect to I1, I2 and J.
        """
        return 0.0 * dI1, 0.0 * dI2, (self.K + (2 * self.c10 + 4 * self.c01) / (J * J)) * dJ

    def margin(self, I1, I2, J):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        float or ndarray
            J, the volume.
        """
        return J + 0.0 * (I1 + I2)


@of_stretches
@inserts_parameters
class Ogden3(NamedTuple):
    """Define the potential of a compressible Ogden material of two terms in space.

    Parameters
    ----------
    mu1 : float, energy, default 0.6
        Modulus of the first term. The shear modulus is (mu1 a1 + mu2 a2)/2.
    a1 : float, default 1.3
        Exponent of the first term, not 0.
    mu2 : float, energy, default -0.1
        Modulus of the second term.
    a2 : float, default -2
        Exponent of the second term, not 0.
    K : float, energy, default 2
        Coefficient of the volume term.

    Notes
    -----
    The potential energy is the sum of ``mu_p/a_p (D1^a_p + D2^a_p + D3^a_p - 3) - mu_p ln J`` over both terms and of
    ``K/2 (J - 1)^2``. The undeformed body is at rest. With a = 2 a term is neo-Hookean.

    References
    ----------
    Ogden 1972, Proc. R. Soc. Lond. A 328, 567. The potential is not in the paper.

    Examples
    --------
    >>> fa.models.Ogden3().value(1.0, 1.0, 1.0)
    np.float64(0.0)
    """

    mu1: float = 0.6
    a1: float = 1.3
    mu2: float = -0.1
    a2: float = -2.0
    K: float = 2.0

    def value(self, D1, D2, D3):
        """Return the potential energy V.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        J = D1 * D2 * D3
        one = np.power(D1, self.a1) + np.power(D2, self.a1) + np.power(D3, self.a1) - 3
        other = np.power(D1, self.a2) + np.power(D2, self.a2) + np.power(D3, self.a2) - 3
        volume = self.K / 2 * (J - 1) * (J - 1) - (self.mu1 + self.mu2) * np.log(J)
        return self.mu1 / self.a1 * one + self.mu2 / self.a2 * other + volume

    def slopes(self, D1, D2, D3):
        """Return the first derivatives of V.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        tuple of float or ndarray
            Derivatives with respect to D1, D2 and D3.
        """
        J = D1 * D2 * D3
        wall = self.K * J * (J - 1) - (self.mu1 + self.mu2)
        return (
            (self.mu1 * np.power(D1, self.a1) + self.mu2 * np.power(D1, self.a2) + wall) / D1,
            (self.mu1 * np.power(D2, self.a1) + self.mu2 * np.power(D2, self.a2) + wall) / D2,
            (self.mu1 * np.power(D3, self.a1) + self.mu2 * np.power(D3, self.a2) + wall) / D3,
        )

    def changes(self, D1, D2, D3, d1, d2, d3):
        """Return the change of the slopes along a vector.

        Parameters
        ----------
        {stretches}
        {stretch_changes}

        Returns
        -------
        tuple of float or ndarray
            Changes of the derivatives with respect to D1, D2 and D3.
        """
        J = D1 * D2 * D3
        wall = self.K * J * (J - 1) - (self.mu1 + self.mu2)
        growth = self.K * J * (2 * J - 1) * (d1 / D1 + d2 / D2 + d3 / D3)
        f1 = self.mu1 * (self.a1 - 1)
        f2 = self.mu2 * (self.a2 - 1)
        return (
            ((f1 * np.power(D1, self.a1) + f2 * np.power(D1, self.a2) - wall) / D1 * d1 + growth) / D1,
            ((f1 * np.power(D2, self.a1) + f2 * np.power(D2, self.a2) - wall) / D2 * d2 + growth) / D2,
            ((f1 * np.power(D3, self.a1) + f2 * np.power(D3, self.a2) - wall) / D3 * d3 + growth) / D3,
        )

    def margin(self, D1, D2, D3):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            The least stretch.
        """
        return np.minimum(np.minimum(D1, D2), D3)


@inserts_parameters
class Sum3(NamedTuple):
    """Define the sum of two potentials of the body in space.

    Parameters
    ----------
    first, second : potential
        Potentials of 3x3 matrices. A sum of three is ``Sum3(a, Sum3(b, c))``.

    Notes
    -----
    The domain is the intersection of both domains.

    References
    ----------
    Martens & Slawianowski, section 2: forces add.

    Examples
    --------
    >>> star = fa.models.Sum3(fa.models.SelfGravity(k=1.0), fa.models.GasCloud(k=0.2, C=0.0))
    >>> round(float(star.matrix_value(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)), 12)
    -0.7
    """

    first: Any
    second: Any

    def matrix_value(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
        """Return the potential energy V of a matrix.

        Parameters
        ----------
        {matrix_coordinates}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        one = self.first.matrix_value(x1, x2, x3, y1, y2, y3, z1, z2, z3)
        return one + self.second.matrix_value(x1, x2, x3, y1, y2, y3, z1, z2, z3)

    def matrix_slopes(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
        """Return the gradient of V in the elements of a matrix.

        Parameters
        ----------
        {matrix_coordinates}

        Returns
        -------
        tuple of float or ndarray
            Nine derivatives, row by row.
        """
        a1, a2, a3, b1, b2, b3, c1, c2, c3 = self.first.matrix_slopes(x1, x2, x3, y1, y2, y3, z1, z2, z3)
        d1, d2, d3, e1, e2, e3, f1, f2, f3 = self.second.matrix_slopes(x1, x2, x3, y1, y2, y3, z1, z2, z3)
        return a1 + d1, a2 + d2, a3 + d3, b1 + e1, b2 + e2, b3 + e3, c1 + f1, c2 + f2, c3 + f3

    def matrix_changes(self, x1, x2, x3, y1, y2, y3, z1, z2, z3, *change):
        """Return the change of the gradient of V along a change of the matrix.

        Parameters
        ----------
        {matrix_coordinates}
        {matrix_changes}

        Returns
        -------
        tuple of float or ndarray
            Nine numbers: the Hessian of V times the change.
        """
        a1, a2, a3, b1, b2, b3, c1, c2, c3 = self.first.matrix_changes(x1, x2, x3, y1, y2, y3, z1, z2, z3, *change)
        d1, d2, d3, e1, e2, e3, f1, f2, f3 = self.second.matrix_changes(x1, x2, x3, y1, y2, y3, z1, z2, z3, *change)
        return a1 + d1, a2 + d2, a3 + d3, b1 + e1, b2 + e2, b3 + e3, c1 + f1, c2 + f2, c3 + f3

    def matrix_margin(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
        """Return a number that is positive for matrices inside the domain.

        Parameters
        ----------
        {matrix_coordinates}

        Returns
        -------
        float or ndarray
            The lesser of both margins.
        """
        one = self.first.matrix_margin(x1, x2, x3, y1, y2, y3, z1, z2, z3)
        return np.minimum(one, self.second.matrix_margin(x1, x2, x3, y1, y2, y3, z1, z2, z3))

    def stretch_value(self, D1, D2, D3):
        """Return the potential energy V of stretches.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            V, an energy.
        """
        return self.first.stretch_value(D1, D2, D3) + self.second.stretch_value(D1, D2, D3)

    def stretch_slopes(self, D1, D2, D3):
        """Return the derivatives of V in the stretches.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        tuple of float or ndarray
            Three derivatives.
        """
        a1, a2, a3 = self.first.stretch_slopes(D1, D2, D3)
        b1, b2, b3 = self.second.stretch_slopes(D1, D2, D3)
        return a1 + b1, a2 + b2, a3 + b3

    def stretch_changes(self, D1, D2, D3, d1, d2, d3):
        """Return the change of the derivatives of V along a change of the stretches.

        Parameters
        ----------
        {stretches}
        {stretch_changes}

        Returns
        -------
        tuple of float or ndarray
            Three numbers: the Hessian of V times the change.
        """
        a1, a2, a3 = self.first.stretch_changes(D1, D2, D3, d1, d2, d3)
        b1, b2, b3 = self.second.stretch_changes(D1, D2, D3, d1, d2, d3)
        return a1 + b1, a2 + b2, a3 + b3

    def stretch_margin(self, D1, D2, D3):
        """Return a number that is positive for stretches inside the domain.

        Parameters
        ----------
        {stretches}

        Returns
        -------
        float or ndarray
            The lesser of both margins.
        """
        return np.minimum(self.first.stretch_margin(D1, D2, D3), self.second.stretch_margin(D1, D2, D3))
