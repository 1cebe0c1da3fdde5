"""Potentials that separate in a chart, from functions of one variable, and the body with angular potentials (layer L1).

With V_eta and V_gamma constant the general separable Hamiltonians are doubly isotropic bodies; the angular terms are the same
V_eta(eta)/alpha^2 + V_gamma(gamma)/beta^2 in all three charts, so they belong to the body, `StackelBody`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..angles import AlphaBeta, RVartheta
from .body import planar_body

TINY = 1e-300
"""Added to A and B under square roots: at alpha = 0 or beta = 0 slopes are those of a point next to it."""


class SeparableAlphaBeta(NamedTuple):
    """V = V_alpha(alpha) + V_beta(beta).

    Source: Martens & Slawianowski, EQ2.1 (V_eta, V_gamma: `StackelBody`).
    """

    V_alpha: Any
    V_beta: Any

    @property
    def angles(self) -> AlphaBeta:
        """Angle variables natural to this potential."""
        return AlphaBeta()

    @property
    def alpha_beta(self) -> SeparableAlphaBeta:
        """Itself: the potential as a member of this family."""
        return self

    def value(self, A, B):
        """Return V."""
        return self.V_alpha.value(np.sqrt(A)) + self.V_beta.value(np.sqrt(B))

    def slopes(self, A, B):
        """Return V_A, V_B."""
        alpha, beta = np.sqrt(A + TINY), np.sqrt(B + TINY)
        return self.V_alpha.slope(alpha) / (2 * alpha), self.V_beta.slope(beta) / (2 * beta)

    def curvatures(self, A, B):
        """Return V_AA, V_AB, V_BB."""
        alpha, beta = np.sqrt(A + TINY), np.sqrt(B + TINY)
        V_AA = (self.V_alpha.curvature(alpha) - self.V_alpha.slope(alpha) / alpha) / (4 * alpha * alpha)
        V_BB = (self.V_beta.curvature(beta) - self.V_beta.slope(beta) / beta) / (4 * beta * beta)
        return V_AA, 0.0 * A, V_BB

    def margin(self, A, B):
        """Return 0.5 where V is finite, else -0.5."""
        V = self.value(A, B)
        return 1.0 * (V - V == 0) - 0.5


class SeparableRVartheta(NamedTuple):
    """V = V_r(r) + V_vartheta(vartheta)/r, with r = alpha^2 + beta^2, tan(vartheta/2) = beta/alpha.

    Source: Martens & Slawianowski, EQ2.2f (V_eta, V_gamma: `StackelBody`).
    """

    V_r: Any
    V_vartheta: Any

    @property
    def angles(self) -> RVartheta:
        """Angle variables natural to this potential."""
        return RVartheta()

    @property
    def r_vartheta(self) -> SeparableRVartheta:
        """Itself: the potential as a member of this family."""
        return self

    def value(self, A, B):
        """Return V."""
        return self.V_r.value(A + B) + self.V_vartheta.value(2 * np.arctan2(np.sqrt(B), np.sqrt(A))) / (A + B)

    def slopes(self, A, B):
        """Return V_A, V_B."""
        r, alpha, beta = A + B, np.sqrt(A + TINY), np.sqrt(B + TINY)
        w, vartheta = 1 / r, 2 * np.arctan2(beta, alpha)
        along = self.V_r.slope(r) - w * w * self.V_vartheta.value(vartheta)
        across = w * w * self.V_vartheta.slope(vartheta)
        return along - across * beta / alpha, along + across * alpha / beta

    def margin(self, A, B):
        """Return 0.5 where V is finite, else -0.5."""
        V = self.value(A, B)
        return 1.0 * (V - V == 0) - 0.5


class SeparableElliptic(NamedTuple):
    """V = (V_kappa(kappa) + V_lambda(lambda))/(2 (cosh^2 kappa - cos^2 lambda)).

    alpha = sqrt2 cosh(kappa) cos(lambda), beta = sqrt2 sinh(kappa) sin(lambda). The chart's focus kappa = lambda = 0 is the undeformed
    body: V is 0/0 there where V_kappa(0) + V_lambda(0) = 0, else singular.
    Source: Martens & Slawianowski, the elliptic Hamiltonian of section 3 (V_eta, V_gamma: `StackelBody`).
    """

    V_kappa: Any
    V_lambda: Any

    @property
    def angles(self) -> AlphaBeta:
        """Angle variables that serve this potential."""
        return AlphaBeta()

    @property
    def elliptic(self) -> SeparableElliptic:
        """Itself: the potential as a member of this family."""
        return self

    def squares(self, A, B):
        """Return sinh^2(kappa) and sin^2(lambda) at A = alpha^2, B = beta^2: no cancellation, 0 at the chart's edges."""
        sigma = (A + B) / 2 - 1
        root = np.sqrt(sigma * sigma + 2 * B)
        large = (np.sqrt(sigma * sigma) + root) / 2
        small = B / (2 * large + TINY)
        outside = 1.0 * (sigma >= 0)  # arithmetic: a scalar np.where is slow in compiled code
        return outside * large + (1 - outside) * small, outside * small + (1 - outside) * large

    def value(self, A, B):
        """Return V."""
        s, t = self.squares(A, B)
        return (self.V_kappa.value(np.arcsinh(np.sqrt(s))) + self.V_lambda.value(np.arcsin(np.sqrt(t)))) / (2 * (s + t))

    def slopes(self, A, B):
        """Return V_A, V_B."""
        s, t = self.squares(A, B + TINY)
        width = s + t
        kappa, lam = np.arcsinh(np.sqrt(s)), np.arcsin(np.sqrt(t))
        V = (self.V_kappa.value(kappa) + self.V_lambda.value(lam)) / (2 * width)
        V_s = self.V_kappa.slope(kappa) / (4 * width * np.sqrt(s * (1 + s)) + TINY) - V / width
        V_t = self.V_lambda.slope(lam) / (4 * width * np.sqrt(t * (1 - t)) + TINY) - V / width
        # s - t = (A + B)/2 - 1 and s t = B/2 give the derivatives of s and t.
        V_A = (V_s * s - V_t * t) / (2 * width)
        return V_A, V_A + (V_s + V_t) / (2 * width)

    def margin(self, A, B):
        """Return 0.5 where V is finite, else -0.5."""
        V = self.value(A, B)
        return 1.0 * (V - V == 0) - 0.5


@planar_body
class StackelBody(NamedTuple):
    """Body with angular potentials: H = |p|^2/(2 mu) + V(alpha, beta) + V_eta(eta)/alpha^2 + V_gamma(gamma)/beta^2.

    `potential` is a doubly isotropic one, V_eta and V_gamma functions of one angle (period 2 pi), mu > 0. With a potential of one of
    the separable families the body is integrable, without being isotropic: spin and vorticity are no constants.
    Source: Martens & Slawianowski, EQ2.1, EQ2.2f and the elliptic Hamiltonian of section 3.
    """

    potential: Any
    V_eta: Any
    V_gamma: Any
    mu: float = 1.0

    def force(self, a1, a2, b1, b2):
        """Return dp/dt = -grad V."""
        A, B = a1 * a1 + a2 * a2 + TINY, b1 * b1 + b2 * b2 + TINY
        V_A, V_B = self.potential.slopes(A, B)
        eta, gamma = np.arctan2(a2, a1), np.arctan2(b2, b1)
        radial_a, around_a = -2 * (V_A - self.V_eta.value(eta) / A / A), self.V_eta.slope(eta) / A / A
        radial_b, around_b = -2 * (V_B - self.V_gamma.value(gamma) / B / B), self.V_gamma.slope(gamma) / B / B
        return (
            radial_a * a1 + around_a * a2, radial_a * a2 - around_a * a1,
            radial_b * b1 + around_b * b2, radial_b * b2 - around_b * b1,
        )  # fmt: skip

    def potential_energy(self, a1, a2, b1, b2):
        """Return V."""
        A, B = a1 * a1 + a2 * a2 + TINY, b1 * b1 + b2 * b2 + TINY
        angular = self.V_eta.value(np.arctan2(a2, a1)) / A + self.V_gamma.value(np.arctan2(b2, b1)) / B
        return self.potential.value(A, B) + angular

    def margin(self, a1, a2, b1, b2):
        """Return a number that is positive where the potential lives."""
        return self.potential.margin(a1 * a1 + a2 * a2, b1 * b1 + b2 * b2)
