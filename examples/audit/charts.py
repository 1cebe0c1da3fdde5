"""The coordinates of GL(2,R), each as a map to the four matrix elements (x, y, z, u): matrix products, nothing
closed.
"""

from __future__ import annotations

from mpmath import cos, cosh, exp, mp, sin, sinh, sqrt


def product(*matrices):
    """Return the product of 2 x 2 matrices as a row-major 4-tuple."""
    x, y, z, u = matrices[0]
    for a, b, c, e in matrices[1:]:
        x, y, z, u = x * a + y * c, x * b + y * e, z * a + u * c, z * b + u * e
    return x, y, z, u


def rotation(angle):
    """Return the matrix of a rotation."""
    return cos(angle), -sin(angle), sin(angle), cos(angle)


def transposed(m):
    """Return the transposed matrix."""
    return m[0], m[2], m[1], m[3]


def inverse(m):
    """Return the inverse matrix."""
    return tuple(v / determinant(m) for v in (m[3], -m[1], -m[2], m[0]))


def determinant(m):
    """Return the determinant."""
    return m[0] * m[3] - m[1] * m[2]


def trace(m):
    """Return the trace."""
    return m[0] + m[3]


def dagger(m):
    """Return the Hermitian conjugate."""
    return tuple(mp.conj(v) for v in transposed(m))


def exponential(m):
    """Return exp of a 2 x 2 matrix as a row-major 4-tuple, by its power series."""
    total = term = (1, 0, 0, 1)
    for k in range(1, 90):
        term = tuple(v / k for v in product(term, m))
        total = tuple(s + t for s, t in zip(total, term))
    return total


def two_polar(D1, D2, varphi, psi):
    """EQ2.0."""
    return product(rotation(varphi), (D1, 0, 0, D2), transposed(rotation(psi)))


def alpha_beta(alpha, beta, eta, gamma):
    """Chart before EQ2.0b."""
    return two_polar((alpha + beta) / sqrt(2), (alpha - beta) / sqrt(2), (gamma + eta) / 2, (gamma - eta) / 2)


def alpha_beta_angles(varphi, psi, alpha, beta):
    """Order of section 5."""
    return alpha_beta(alpha, beta, varphi - psi, varphi + psi)


def r_vartheta(r, vartheta, eta, gamma):
    """Chart before EQ2.2y."""
    return alpha_beta(sqrt(r) * cos(vartheta / 2), sqrt(r) * sin(vartheta / 2), eta, gamma)


def r_vartheta_angles(r, vartheta, varphi, psi):
    """The same with the two-polar angles."""
    return r_vartheta(r, vartheta, varphi - psi, varphi + psi)


def rho_epsilon(rho, epsilon, eta, gamma):
    """Literal polar chart."""
    return alpha_beta(rho * cos(epsilon), rho * sin(epsilon), eta, gamma)


def euler(rho, Theta, Phi, Psi):
    """Chart with the doubled angles of section 3, Psi = 2 psi."""
    return r_vartheta_angles(rho * rho, Theta, Phi / 2, Psi / 2)


def euler_section7(rho, Theta, Phi, Psi):
    """The same with Psi = -2 psi, the sign of section 7."""
    return euler(rho, Theta, Phi, -Psi)


def elliptic(kappa, lam, eta, gamma):
    """Chart (i)."""
    return alpha_beta(sqrt(2) * cosh(kappa) * cos(lam), sqrt(2) * sinh(kappa) * sin(lam), eta, gamma)


def parabolic(xi, delta, eta, gamma):
    """Chart (ii)."""
    return alpha_beta((xi**2 - delta**2) / 2, xi * delta, eta, gamma)


def bipolar(e, f, eta, gamma):
    """Chart (iii), with c = 1."""
    return alpha_beta(sinh(e) / (cosh(e) - cos(f)), sin(f) / (cosh(e) - cos(f)), eta, gamma)


def exponents(a, b, varphi, psi):
    """Exponential deformation invariants of section 3."""
    return two_polar(exp((a + b) / 2), exp((a - b) / 2), varphi, psi)


def spherical(r, lam, mu, nu):
    """Spherical coordinates of R^4, section 3."""
    return r * sin(lam) * cos(mu) * cos(nu), r * sin(lam) * cos(mu) * sin(nu), r * sin(lam) * sin(mu), r * cos(lam)
