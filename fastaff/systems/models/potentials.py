"""Doubly isotropic potentials V(A, B) of A = alpha^2 and B = beta^2.

D1 D2 = (A - B)/2 and D1^2 + D2^2 = A + B. Each class gives `value`, `slopes` (V_A, V_B), `curvatures` (V_AA, V_AB,
V_BB) and `margin`, positive in the domain. The methods are plain formulas: they run on floats and arrays, and compiled
in kernels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .angles import AlphaBeta, AreaTrace, RVartheta
from .functions import Barriers, CoshOscillator, Cosine, CosOscillator, Oscillator, Secant, Spring
from .separable import SeparableAlphaBeta, SeparableElliptic, SeparableRVartheta


class Harmonic(NamedTuple):
    """V = C (D1^2 + D2^2)/2: the isotropic oscillator of R^4, smooth through det phi = 0.

    Parameters
    ----------
    C : float, energy, default 1
        Stiffness.

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
        """Return V."""
        return self.C * (A + B) / 2

    def slopes(self, A, B):
        """Return V_A, V_B."""
        return self.C / 2 + 0.0 * A, self.C / 2 + 0.0 * B

    def curvatures(self, A, B):
        """Return V_AA, V_AB, V_BB."""
        zero = 0.0 * (A + B)
        return zero, zero, zero

    def margin(self, A, B):
        """Return 1: the potential is defined everywhere."""
        return 1.0 + 0.0 * (A + B)


class Anharmonic(NamedTuple):
    """V = C (D1^2 + D2^2)/2 + 4 C/(D1 + D2)^2, separable in three charts; crosses det phi = 0 smoothly.

    Parameters
    ----------
    C : float, energy, default 1
        Stiffness.

    References
    ----------
    Martens & Slawianowski, EQa and EQb, which are one function: C (A + B)/2 + 2 C/A.

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
        """Return V."""
        return self.C * ((A + B) / 2 + 2 / A)

    def slopes(self, A, B):
        """Return V_A, V_B."""
        return self.C * (0.5 - 2 / (A * A)), self.C / 2 + 0.0 * B

    def curvatures(self, A, B):
        """Return V_AA, V_AB, V_BB."""
        zero = 0.0 * (A + B)
        return 4 * self.C / (A * A * A), zero, zero

    def margin(self, A, B):
        """Return A: the barrier is at alpha = 0 only."""
        return A + 0.0 * B


class Hyperelastic(NamedTuple):
    """V = C (1/(D1 D2) + (D1^2 + D2^2)/2), defined on det phi > 0, separable in (r, vartheta).

    Parameters
    ----------
    C : float, energy, default 1
        Stiffness.

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
        """Return V."""
        return self.C * ((A + B) / 2 + 2 / (A - B))

    def slopes(self, A, B):
        """Return V_A, V_B."""
        w = 1 / (A - B)
        wall = 2 * self.C * w * w
        return self.C / 2 - wall, self.C / 2 + wall

    def curvatures(self, A, B):
        """Return V_AA, V_AB, V_BB."""
        w = 1 / (A - B)  # the one division that slopes make too
        wall = 4 * self.C * w * w * w
        return wall, -wall, wall

    def margin(self, A, B):
        """Return 2 det phi."""
        return A - B


class HeavyTop(NamedTuple):
    """V = C r/2 + A cos(vartheta)/r, with r = alpha^2 + beta^2: separable in (r, vartheta).

    Parameters
    ----------
    C, A : float, default 1
        Strengths of the oscillator and of the field.

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
        """Return V."""
        r = A + B
        return self.C * r / 2 + self.A * (A - B) / (r * r)

    def slopes(self, A, B):
        """Return V_A, V_B."""
        w = 1 / (A + B)
        common = self.C / 2 - 2 * self.A * (A - B) * w * w * w
        return common + self.A * w * w, common - self.A * w * w

    def curvatures(self, A, B):
        """Return V_AA, V_AB, V_BB."""
        w = 1 / (A + B)
        cube = self.A * w * w * w
        mixed = 6 * cube * (A - B) * w
        return mixed - 4 * cube, mixed, mixed + 4 * cube

    def margin(self, A, B):
        """Return r: the potential is singular at phi = 0 only."""
        return A + B


class NeoHookean(NamedTuple):
    """V = G/2 (D1^2 + D2^2 - 2) - G ln(D1 D2) + K/2 (D1 D2 - 1)^2, a compressible material; not separable.

    Parameters
    ----------
    G, K : float, energy, default 1 and 2
        Shear modulus, and coefficient of the volume term.

    References
    ----------
    The compressible neo-Hookean energy of nonlinear elasticity (Ogden 1984, Non-Linear Elastic Deformations, section
    7.2), in two dimensions; beyond the paper.

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
        """Return V."""
        d = (A - B) / 2
        return self.G * ((A + B) / 2 - 1 - np.log(d)) + self.K / 2 * (d - 1) * (d - 1)

    def slopes(self, A, B):
        """Return V_A, V_B."""
        d = (A - B) / 2
        w = 2 / (A - B)
        wall = (self.K * (d - 1) - self.G * w) / 2
        return self.G / 2 + wall, self.G / 2 - wall

    def curvatures(self, A, B):
        """Return V_AA, V_AB, V_BB."""
        w = 2 / (A - B)  # the one division that slopes make too
        wall = (self.K + self.G * w * w) / 4
        return wall, -wall, wall

    def margin(self, A, B):
        """Return 2 det phi."""
        return A - B
