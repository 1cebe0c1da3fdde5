"""Doubly isotropic potentials V(A, B) of A = alpha^2 and B = beta^2.

D1 D2 = (A - B)/2 and D1^2 + D2^2 = A + B. Each class gives `value`, `slopes` (V_A, V_B), `curvatures` (V_AA, V_AB,
V_BB) and `margin`, positive in the domain. The methods are plain formulas: they run on floats and arrays, and compiled
in kernels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.docstrings import inserts_parameters
from .angles import AlphaBeta, AreaTrace, RVartheta
from .functions import Barriers, CoshOscillator, Cosine, CosOscillator, Oscillator, Secant, Spring
from .letters import inertia_is_mu
from .separable import SeparableAlphaBeta, SeparableElliptic, SeparableRVartheta


@inserts_parameters
class Harmonic(NamedTuple):
    """Define the isotropic oscillator, V = C (D1^2 + D2^2)/2.

    Parameters
    ----------
    C : float, energy, default 1
        Stiffness.

    Notes
    -----
    The potential energy is ``V = C (A + B)/2``, the isotropic oscillator of R^4. It is smooth through det phi = 0.

    References
    ----------
    Martens & Slawianowski, EQ3.1.

    Examples
    --------
    >>> fa.Harmonic(C=2.0).value(2.0, 0.0)
    2.0
    """

    C: float = 1.0

    @property
    def angles(self) -> AlphaBeta:
        """Angle variables natural to this potential."""
        return AlphaBeta()

    @property
    def alpha_beta(self) -> SeparableAlphaBeta:
        """The potential as a member of the family that separates in (alpha, beta)."""
        return SeparableAlphaBeta(Oscillator(self.C), Oscillator(self.C))

    @property
    def r_vartheta(self) -> SeparableRVartheta:
        """The potential as a member of the family that separates in (r, vartheta)."""
        return SeparableRVartheta(Spring(self.C), Barriers())

    @property
    def elliptic(self) -> SeparableElliptic:
        """The potential as a member of the family that separates in (kappa, lambda)."""
        return SeparableElliptic(CoshOscillator(self.C), CosOscillator(self.C))

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
        return self.C * (A + B) / 2

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
        return self.C / 2 + 0.0 * A, self.C / 2 + 0.0 * B

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
        zero = 0.0 * (A + B)
        return zero, zero, zero

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            1: the potential is defined everywhere.
        """
        return 1.0 + 0.0 * (A + B)


@inserts_parameters
class Anharmonic(NamedTuple):
    """Define the potential V = C (D1^2 + D2^2)/2 + 4 C/(D1 + D2)^2.

    Parameters
    ----------
    C : float, energy, default 1
        Stiffness.

    Notes
    -----
    The potential energy is ``V = C (A + B)/2 + 2 C/A``. It separates in three charts. Orbits cross det phi = 0
    smoothly.

    References
    ----------
    Martens & Slawianowski, EQa and EQb, which are the same function.

    Examples
    --------
    >>> fa.Anharmonic().value(2.0, 0.0)
    2.0
    """

    C: float = 1.0

    @property
    def angles(self) -> AlphaBeta:
        """Angle variables natural to this potential."""
        return AlphaBeta()

    @property
    def alpha_beta(self) -> SeparableAlphaBeta:
        """The potential as a member of the family that separates in (alpha, beta)."""
        return SeparableAlphaBeta(Oscillator(self.C, 2 * self.C), Oscillator(self.C))

    @property
    def r_vartheta(self) -> SeparableRVartheta:
        """The potential as a member of the family that separates in (r, vartheta)."""
        return SeparableRVartheta(Spring(self.C), Barriers(2 * self.C))

    @property
    def elliptic(self) -> SeparableElliptic:
        """The potential as a member of the family that separates in (kappa, lambda)."""
        return SeparableElliptic(CoshOscillator(self.C, 2 * self.C), CosOscillator(self.C, 2 * self.C))

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
        return self.C * ((A + B) / 2 + 2 / A)

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
        return self.C * (0.5 - 2 / (A * A)), self.C / 2 + 0.0 * B

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
        zero = 0.0 * (A + B)
        return 4 * self.C / (A * A * A), zero, zero

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            A: the only barrier is at alpha = 0.
        """
        return A + 0.0 * B


@inserts_parameters
class Hyperelastic(NamedTuple):
    """Define the potential V = C (1/(D1 D2) + (D1^2 + D2^2)/2).

    Parameters
    ----------
    C : float, energy, default 1
        Stiffness.

    Notes
    -----
    The potential energy is ``V = C (A + B)/2 + 2 C/(A - B)``. It is defined for det phi > 0 and separates in (r,
    vartheta).

    References
    ----------
    Martens & Slawianowski, EQ2.2h.

    Examples
    --------
    >>> fa.Hyperelastic().value(2.0, 0.0)
    2.0
    """

    C: float = 1.0

    @property
    def angles(self) -> RVartheta:
        """Angle variables natural to this potential."""
        return RVartheta()

    @property
    def r_vartheta(self) -> SeparableRVartheta:
        """The potential as a member of the family that separates in (r, vartheta)."""
        return SeparableRVartheta(Spring(self.C), Secant(2 * self.C))

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
        return self.C * ((A + B) / 2 + 2 / (A - B))

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
        w = 1 / (A - B)
        wall = 2 * self.C * w * w
        return self.C / 2 - wall, self.C / 2 + wall

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
        w = 1 / (A - B)  # the one division that slopes make too
        wall = 4 * self.C * w * w * w
        return wall, -wall, wall

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            A - B, which is 2 det phi.
        """
        return A - B


@inserts_parameters
class HeavyTop(NamedTuple):
    """Define the potential V = C r/2 + A cos(vartheta)/r.

    Parameters
    ----------
    C : float, energy, default 1
        Stiffness of the oscillator.
    A : float, energy, default 1
        Strength of the field.

    Notes
    -----
    Here r = alpha^2 + beta^2 and tan(vartheta/2) = beta/alpha. The potential separates in (r, vartheta).

    References
    ----------
    Martens & Slawianowski, EQ2.2f with V_vartheta = A cos(vartheta), the heavy top of section 3.

    Examples
    --------
    >>> fa.HeavyTop().value(2.0, 0.0)
    1.5
    """

    C: float = 1.0
    A: float = 1.0

    @property
    def angles(self) -> RVartheta:
        """Angle variables natural to this potential."""
        return RVartheta()

    @property
    def r_vartheta(self) -> SeparableRVartheta:
        """The potential as a member of the family that separates in (r, vartheta)."""
        return SeparableRVartheta(Spring(self.C), Cosine(self.A))

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
        r = A + B
        return self.C * r / 2 + self.A * (A - B) / (r * r)

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
        w = 1 / (A + B)
        common = self.C / 2 - 2 * self.A * (A - B) * w * w * w
        return common + self.A * w * w, common - self.A * w * w

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
        w = 1 / (A + B)
        cube = self.A * w * w * w
        mixed = 6 * cube * (A - B) * w
        return mixed - 4 * cube, mixed, mixed + 4 * cube

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            A + B, which is r: the only singularity is phi = 0.
        """
        return A + B


@inertia_is_mu("fa.Body(fa.NeoHookean(G=1.0), mu=...)")
@inserts_parameters
class NeoHookean(NamedTuple):
    """Define the potential of a compressible neo-Hookean material.

    Parameters
    ----------
    G : float, energy, default 1
        Shear modulus.
    K : float, energy, default 2
        Coefficient of the volume term.

    Notes
    -----
    The potential energy is ``V = G/2 (D1^2 + D2^2 - 2) - G ln(D1 D2) + K/2 (D1 D2 - 1)^2``, defined for det phi > 0. It
    is not separable.

    References
    ----------
    Ogden 1984, Non-Linear Elastic Deformations, section 7.2, in two dimensions. The potential is not in the paper.

    Examples
    --------
    >>> fa.NeoHookean().value(2.0, 0.0)
    np.float64(0.0)
    """

    G: float = 1.0
    K: float = 2.0

    @property
    def angles(self) -> AreaTrace:
        """Angle variables natural to this potential."""
        return AreaTrace()

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
        d = (A - B) / 2
        return self.G * ((A + B) / 2 - 1 - np.log(d)) + self.K / 2 * (d - 1) * (d - 1)

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
        d = (A - B) / 2
        w = 2 / (A - B)
        wall = (self.K * (d - 1) - self.G * w) / 2
        return self.G / 2 + wall, self.G / 2 - wall

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
        w = 2 / (A - B)  # the one division that slopes make too
        wall = (self.K + self.G * w * w) / 4
        return wall, -wall, wall

    def margin(self, A, B):
        """Return a number that is positive inside the domain.

        Parameters
        ----------
        {invariants}

        Returns
        -------
        float or ndarray
            A - B, which is 2 det phi.
        """
        return A - B
