"""The line elements of the paper, one function per chart: ds^2 = Tr(dphi^T dphi) and the volume element, in closed
form.

Each takes the four coordinates as arrays and returns a `Form`. They are written from the paper (corrected where a note
says so), not from the charts: the tests compare the two.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.arrays import Array


class Form(NamedTuple):
    """Hold a line element: ds^2 = sum diagonal_i dq_i^2 + sum 2 g dq_i dq_j over `cross` = ((i, j, g), ...), and
    sqrt|g|.
    """

    diagonal: tuple[Array | float, Array | float, Array | float, Array | float]
    density: Array | float
    cross: tuple[tuple[int, int, Array | float], ...] = ()

    def tensor(self) -> Array:
        """Return g_ij (4, 4, ...)."""
        g = np.zeros((4, 4, *np.broadcast_shapes(*map(np.shape, self.diagonal))))
        for i, value in enumerate(self.diagonal):
            g[i, i] = value
        for i, j, value in self.cross:
            g[i, j] = g[j, i] = value
        return g


def cartesian(x: Array, y: Array, z: Array, u: Array) -> Form:
    """dx^2 + dy^2 + dz^2 + du^2.  Source: EQ2.2b, EQ6.1."""
    one = np.ones_like(x)
    return Form((one, one, one, one), one)


def alpha_beta(alpha: Array, beta: Array, eta: Array, gamma: Array) -> Form:
    """dalpha^2 + dbeta^2 + alpha^2 deta^2 + beta^2 dgamma^2.  Source: EQ2.0b."""
    one = np.ones_like(alpha)
    return Form((one, one, alpha**2, beta**2), alpha * beta)


def alpha_beta_phi_psi(alpha: Array, beta: Array, phi: Array, psi: Array) -> Form:
    """dalpha^2 + dbeta^2 + (alpha^2 + beta^2)(dphi^2 + dpsi^2) + 2 (beta^2 - alpha^2) dphi dpsi.  Source: EQ2.0b,
    section 5.
    """
    one = np.ones_like(alpha)
    size = alpha**2 + beta**2
    return Form((one, one, size, size), 2 * alpha * beta, ((2, 3, (beta - alpha) * (beta + alpha)),))


def two_polar(D1: Array, D2: Array, phi: Array, psi: Array) -> Form:
    """dD1^2 + dD2^2 + (D1^2 + D2^2)(dphi^2 + dpsi^2) - 4 D1 D2 dphi dpsi.  Source: EQ2.0a."""
    one = np.ones_like(D1)
    size = D1**2 + D2**2
    return Form((one, one, size, size), (D1 - D2) * (D1 + D2), ((2, 3, -2 * D1 * D2),))


def rho_epsilon(rho: Array, epsilon: Array, eta: Array, gamma: Array) -> Form:
    """drho^2 + rho^2 (depsilon^2 + cos^2(epsilon) deta^2 + sin^2(epsilon) dgamma^2).  Source: section 3, below
    EQ2.2c'.
    """
    c = np.cos(epsilon)
    s = np.sin(epsilon)
    r = rho**2
    return Form((np.ones_like(rho), r, r * c**2, r * s**2), rho**3 * s * c)


def rho_vartheta(rho: Array, vartheta: Array, eta: Array, gamma: Array) -> Form:
    """drho^2 + rho^2 (dvartheta^2/4 + cos^2(vartheta/2) deta^2 + sin^2(vartheta/2) dgamma^2).  Source: section 3, below
    EQ2.2c'.
    """
    r = rho**2
    diagonal = (np.ones_like(rho), r / 4, r * np.cos(vartheta / 2) ** 2, r * np.sin(vartheta / 2) ** 2)
    return Form(diagonal, rho**3 / 4 * np.sin(vartheta))


def r_vartheta_eta_gamma(r: Array, vartheta: Array, eta: Array, gamma: Array) -> Form:
    """dr^2/4r + (r/4) dvartheta^2 + r cos^2(vartheta/2) deta^2 + r sin^2(vartheta/2) dgamma^2.  Source: section 3,
    below EQ2.2c'.
    """
    diagonal = (1 / (4 * r), r / 4, r * np.cos(vartheta / 2) ** 2, r * np.sin(vartheta / 2) ** 2)
    return Form(diagonal, r / 8 * np.sin(vartheta))


def r_vartheta(r: Array, vartheta: Array, phi: Array, psi: Array) -> Form:
    """dr^2/4r + (r/4) dvartheta^2 + r (dphi^2 - 2 cos(vartheta) dphi dpsi + dpsi^2).  Source: section 3, below
    EQ2.2f.
    """
    return Form((1 / (4 * r), r / 4, r, r), r / 4 * np.sin(vartheta), ((2, 3, -r * np.cos(vartheta)),))


def euler(rho: Array, Phi: Array, Theta: Array, Psi: Array) -> Form:
    """drho^2 + (rho^2/4)(dTheta^2 + dPhi^2 + 2 cos(Theta) dPhi dPsi + dPsi^2).  Source: EQ6.4, first line."""
    top = rho**2 / 4
    return Form((np.ones_like(rho), top, top, top), rho**3 / 8 * np.sin(Theta), ((1, 3, top * np.cos(Theta)),))


def r_euler(r: Array, Phi: Array, Theta: Array, Psi: Array) -> Form:
    """(dr^2 + r^2 (dTheta^2 + dPhi^2 + 2 cos(Theta) dPhi dPsi + dPsi^2))/4r.  Source: EQ6.4, second line."""
    top = r / 4
    return Form((1 / (4 * r), top, top, top), r / 16 * np.sin(Theta), ((1, 3, top * np.cos(Theta)),))


def elliptic(focus: float, kappa: Array, lam: Array, eta: Array, gamma: Array) -> Form:
    """focus^2 {(cosh^2 k - cos^2 l)(dk^2 + dl^2) + cosh^2 k cos^2 l deta^2 + sinh^2 k sin^2 l dgamma^2}.

    Source: section 3, elliptic variables; corrected, the printed one lacks the factor focus^2 = 2.
    """
    alpha = focus * np.cosh(kappa) * np.cos(lam)
    beta = focus * np.sinh(kappa) * np.sin(lam)
    stretch = focus**2 * (np.sinh(kappa) ** 2 + np.sin(lam) ** 2)
    return Form((stretch, stretch, alpha**2, beta**2), stretch * alpha * beta)


def parabolic(xi: Array, delta: Array, eta: Array, gamma: Array) -> Form:
    """(xi^2 + delta^2)(dxi^2 + ddelta^2) + alpha^2 deta^2 + beta^2 dgamma^2.  Source: section 3, parabolic variables;
    derived.
    """
    stretch = xi**2 + delta**2
    alpha = (xi**2 - delta**2) / 2
    beta = xi * delta
    return Form((stretch, stretch, alpha**2, beta**2), stretch * alpha * beta)


def bipolar(c: float, e: Array, f: Array, eta: Array, gamma: Array) -> Form:
    """c^2/(cosh e - cos f)^2 {de^2 + df^2 + sinh^2 e deta^2 + sin^2 f dgamma^2}.

    Source: section 3, the variables (e, f); derived.
    """
    h = c / (np.cosh(e) - np.cos(f))
    return Form((h**2, h**2, (h * np.sinh(e)) ** 2, (h * np.sin(f)) ** 2), h**4 * np.sinh(e) * np.sin(f))


def exponential(a: Array, b: Array, phi: Array, psi: Array) -> Form:
    """e^a {cosh(b)(da^2 + db^2)/2 + sinh(b) da db + 2 cosh(b)(dphi^2 + dpsi^2) - 4 dphi dpsi}.

    Source: section 3, D1, D2 = exp((a +- b)/2); derived.
    """
    area = np.exp(a)
    size = np.exp(a) * np.cosh(b)
    shear = area * np.sinh(b)
    return Form((size / 2, size / 2, 2 * size, 2 * size), area * shear, ((0, 1, shear / 2), (2, 3, -2 * area)))


def delta_b(delta: Array, b: Array, Phi: Array, Psi: Array) -> Form:
    """2 cosh(b) ddelta^2 + 2 delta sinh(b) ddelta db + (delta^2/2) cosh(b) (db^2 + dPhi^2 + 2 dPhi dPsi/cosh(b) +
    dPsi^2).

    Source: EQ6.4a; corrected, twice the printed one.
    """
    top = delta**2 / 2
    size = top * np.cosh(b)
    cross = ((0, 1, delta * np.sinh(b)), (2, 3, top))
    return Form((2 * np.cosh(b), size, size, size), delta**3 / 2 * np.sinh(b), cross)


def spherical(r: Array, lam: Array, mu: Array, nu: Array) -> Form:
    """dr^2 + r^2 (dlambda^2 + sin^2(lambda)(dmu^2 + cos^2(mu) dnu^2)).  Source: section 3, above EQ2.2c; derived."""
    s, c = np.sin(lam), np.cos(mu)
    return Form((np.ones_like(r), r**2, (r * s) ** 2, (r * s * c) ** 2), r**3 * s**2 * c)


def spherical_cartesian(R: Array, theta: Array, chi: Array, u: Array) -> Form:
    """dR^2 + R^2 (dtheta^2 + sin^2(theta) dchi^2) + du^2.  Source: section 3, below EQ2.2c; derived."""
    one = np.ones_like(R)
    return Form((one, R**2, (R * np.sin(theta)) ** 2, one), R**2 * np.sin(theta))


def polar_polar(r1: Array, chi1: Array, r2: Array, chi2: Array) -> Form:
    """dr1^2 + r1^2 dchi1^2 + dr2^2 + r2^2 dchi2^2.  Source: section 3, below EQ2.2c; derived."""
    one = np.ones_like(r1)
    return Form((one, r1**2, one, r2**2), r1 * r2)


def polar_cartesian(r1: Array, chi1: Array, z: Array, u: Array) -> Form:
    """dr1^2 + r1^2 dchi1^2 + dz^2 + du^2.  Source: section 3, below EQ2.2c; derived."""
    one = np.ones_like(r1)
    return Form((one, r1**2, one, one), r1)
