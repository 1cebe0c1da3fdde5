"""The self-gravity of a homogeneous ellipsoid, by the symmetric elliptic integrals of its squared stretches.

V = -k R_F(D1^2, D2^2, D3^2) with Carlson's R_F = 1/2 int_0^inf P^(-1/2) ds and P = s^3 + I1 s^2 + I2 s + J^2. All
derivatives are integrals K_n = int s^n P^(-3/2) ds: V_I1 = k K_2/4, V_I2 = k K_1/4, V_(J^2) = k K_0/4. R_F has the
degree -1/2, so that R_F = (I1 K_2 + 2 I2 K_1 + 3 J^2 K_0)/2, a sum of positive terms. They depend on the invariants
alone: nothing cancels where axes coincide. Carlson's second integral is R_D(y, z, x) = 3/2 (K_2 + (y + z) K_1 + y z
K_0).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from .matrix_potentials import of_invariants

STEP = 0.38
"""Step of the trapezoidal rule in u = ln s. The integrands are analytic for |Im u| < pi, whatever the axes. Measured
against STEP = 0.2: relative error 2e-15 of second derivatives at equal axes, the worst case; 3e-13 with 0.44.
"""

LOWEST = -51.0
"""Least u, relative to ln g of the scale g of the squared axes. The rest of K_0 is exp(LOWEST) g/x of the least squared
axis x: 1e-16 for ratios of axes of 1000.
"""

HIGHEST = 32.0
"""Greatest u, relative to ln g. The rest of K_2 is (x exp(-HIGHEST)/g)^(3/2) of the greatest squared axis x: 1e-16 for
ratios of axes of 1000.
"""

NODES = tuple(
    (float(np.exp(STEP * i)), float(STEP * np.exp(STEP * i)))
    for i in range(int(np.ceil(LOWEST / STEP)), int(np.floor(HIGHEST / STEP)) + 1)
)
"""Nodes s and weights of the trapezoidal rule."""


@of_invariants
@inserts_parameters
class SelfGravity(NamedTuple):
    """Define the gravitational energy of a homogeneous ellipsoid.

    Parameters
    ----------
    k : float, energy, default 1
        Minus the energy of the sphere, 3 G M^2/(5 R) for the mass M and the radius R of the undeformed body, whose
        inertia is mu = M R^2/5.

    Notes
    -----
    * Potential energy: ``V = -k R_F(D1^2, D2^2, D3^2)`` with Carlson's integral R_F, defined for J = det phi > 0.
    * Density: pi G rho = k/(4 mu J).
    * Accuracy: V and its derivatives have a relative error below 1e-14 for ratios of the axes up to 1000. They are
      regular where axes coincide.
    * Cost: one force takes about 0.6 microseconds, the time of 20 to 30 forces of `GasCloud`.
    * Without pressure the body collapses. Add `GasCloud` with `Sum3`.

    References
    ----------
    Chandrasekhar 1969, Ellipsoidal Figures of Equilibrium, chapter 3; Carlson 1995, Numer. Algorithms 10, 13 (R_F);
    Trefethen & Weideman 2014, SIAM Rev. 56, 385 (the trapezoidal rule).

    Examples
    --------
    >>> round(float(fa.models.SelfGravity(k=2.0).value(3.0, 3.0, 1.0)), 12)
    -2.0
    """

    k: float = 1.0

    def integrals(self, I1, I2, J):
        """Return the symmetric elliptic integrals K_0, K_1 and K_2.

        Parameters
        ----------
        {invariants3}

        Returns
        -------
        tuple of float or ndarray
            Integrals of s^n P^(-3/2) over s > 0 for n = 0, 1, 2.
        """
        g = np.sqrt(I2 / 3)
        w = 1 / g
        a = I1 * w
        b = I2 * w * w
        c = J * J * w * w * w
        K0 = 0.0 * a
        K1 = 0.0 * a
        K2 = 0.0 * a
        for s, weight in NODES:
            P = ((s + a) * s + b) * s + c
            f = weight / (P * np.sqrt(P))
            K0 = K0 + f
            K1 = K1 + s * f
            K2 = K2 + s * s * f
        root = np.sqrt(w)
        return K0 * w * w * w * root, K1 * w * w * root, K2 * w * root

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
        K0, K1, K2 = self.integrals(I1, I2, J)
        return -self.k / 2 * (I1 * K2 + 2 * I2 * K1 + 3 * J * J * K0)

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
        K0, K1, K2 = self.integrals(I1, I2, J)
        return self.k / 4 * K2, self.k / 4 * K1, self.k / 2 * J * K0

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
        g = np.sqrt(I2 / 3)
        w = 1 / g
        a = I1 * w
        b = I2 * w * w
        c = J * J * w * w * w
        da = dI1 * w
        db = dI2 * w * w
        dc = 2 * J * dJ * w * w * w
        K0 = 0.0 * a
        L0 = 0.0 * a
        L1 = 0.0 * a
        L2 = 0.0 * a
        for s, weight in NODES:
            P = ((s + a) * s + b) * s + c
            inverse = 1 / P
            f = weight * inverse * np.sqrt(inverse)
            K0 = K0 + f
            f = f * ((da * s + db) * s + dc) * inverse
            L0 = L0 + f
            L1 = L1 + s * f
            L2 = L2 + s * s * f
        root = np.sqrt(w)
        front = -3 / 8 * self.k * w * root
        return (
            front * L2,
            front * w * L1,
            2 * J * front * w * w * L0 + self.k / 2 * dJ * K0 * w * w * w * root,
        )

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
