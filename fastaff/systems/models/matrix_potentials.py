"""Potentials of 3x3 matrices phi from functions of their invariants or of their stretches.

phi = [[x1, x2, x3], [y1, y2, y3], [z1, z2, z3]] has rows x, y, z in space and columns in the body. An isotropic
potential is V(I1, I2, J) with I1 = Tr C, I2 = (Tr(C)^2 - Tr(C^2))/2, C = phi^T phi and J = det phi, or a symmetric
V(D1, D2, D3) of the stretches, the singular values of phi. `of_invariants` and `of_stretches` give a class the same
methods of matrices and of stretches, so that bodies, reduced bodies and equilibria do not ask which it is.

I1 and I2 = |cof phi|^2 are polynomials: forces of V(I1, I2, J) are regular where stretches coincide. Forces of
V(D1, D2, D3) come from the singular value decomposition. Its vectors are arbitrary where stretches coincide, the forces
are not.
"""

from __future__ import annotations

import numpy as np

from ...core.docstrings import inserts_parameters

TINY = 1e-300
"""Added to a root that may be 0: the quotient 0/0 of columns that are orthogonal already is 0."""

SWEEPS = 5
"""Sweeps of Jacobi's rotations. Random, nearly singular and badly scaled matrices take 4."""

NEAR = 1 / 64
"""Half difference of two stretches, relative to their mean, below which their divided difference is an integral."""

NODES = (
    (0.2386191860831969, 0.4679139345726910),
    (0.6612093864662645, 0.3607615730481386),
    (0.9324695142031521, 0.1713244923791704),
)
"""Positive nodes and weights of Gauss and Legendre's rule with six points, for even functions on (0, 1)."""

MATRIX_METHODS = ("matrix_value", "matrix_slopes", "matrix_changes", "matrix_margin")
"""Methods of a potential that a body in space calls."""


def _attached(methods):
    """Return a class decorator that gives a NamedTuple, which cannot inherit, documented methods."""
    for method in methods:
        inserts_parameters(method)

    def decorate(cls):
        for method in methods:
            setattr(cls, method.__name__, method)
        return cls

    return decorate


# --- V(I1, I2, J) -----------------------------------------------------------------------------------------------------


def cofactors(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return the cofactors of phi, the derivatives of J, row by row: y x z, z x x, x x y.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    tuple of float or ndarray
        Nine numbers.
    """
    return (
        y2 * z3 - y3 * z2,
        y3 * z1 - y1 * z3,
        y1 * z2 - y2 * z1,
        z2 * x3 - z3 * x2,
        z3 * x1 - z1 * x3,
        z1 * x2 - z2 * x1,
        x2 * y3 - x3 * y2,
        x3 * y1 - x1 * y3,
        x1 * y2 - x2 * y1,
    )


def mixed_cofactors(self, matrix, change):
    """Return the change of the cofactors of a matrix of rows a, b, c along one of rows x, y, z.

    Parameters
    ----------
    matrix, change : tuple of float or ndarray
        Nine elements each, row by row. The result is symmetric in both.

    Returns
    -------
    tuple of float or ndarray
        Nine numbers: b x z + y x c, c x x + z x a, a x y + x x b.
    """
    a1, a2, a3, b1, b2, b3, c1, c2, c3 = matrix
    x1, x2, x3, y1, y2, y3, z1, z2, z3 = change
    return (
        b2 * z3 - b3 * z2 + y2 * c3 - y3 * c2,
        b3 * z1 - b1 * z3 + y3 * c1 - y1 * c3,
        b1 * z2 - b2 * z1 + y1 * c2 - y2 * c1,
        c2 * x3 - c3 * x2 + z2 * a3 - z3 * a2,
        c3 * x1 - c1 * x3 + z3 * a1 - z1 * a3,
        c1 * x2 - c2 * x1 + z1 * a2 - z2 * a1,
        a2 * y3 - a3 * y2 + x2 * b3 - x3 * b2,
        a3 * y1 - a1 * y3 + x3 * b1 - x1 * b3,
        a1 * y2 - a2 * y1 + x1 * b2 - x2 * b1,
    )


def matrix_invariants(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return the invariants of phi. I2 is the sum of the squared cofactors, which does not cancel.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    tuple of float or ndarray
        I1, I2 and J.
    """
    c1, c2, c3, d1, d2, d3, e1, e2, e3 = self.cofactors(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    I1 = x1 * x1 + x2 * x2 + x3 * x3 + (y1 * y1 + y2 * y2 + y3 * y3) + (z1 * z1 + z2 * z2 + z3 * z3)
    I2 = c1 * c1 + c2 * c2 + c3 * c3 + (d1 * d1 + d2 * d2 + d3 * d3) + (e1 * e1 + e2 * e2 + e3 * e3)
    return I1, I2, x1 * c1 + x2 * c2 + x3 * c3


def _value_of_invariants(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return the potential energy V of a matrix.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    float or ndarray
        V, an energy.
    """
    I1, I2, J = self.matrix_invariants(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    return self.value(I1, I2, J)


def _slopes_of_invariants(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return the gradient of V in the elements of a matrix.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    tuple of float or ndarray
        Nine derivatives, row by row.
    """
    phi = x1, x2, x3, y1, y2, y3, z1, z2, z3
    cofactors = self.cofactors(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    c1, c2, c3, d1, d2, d3, e1, e2, e3 = cofactors
    I1, I2, J = self.matrix_invariants(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    V_1, V_2, V_J = self.slopes(I1, I2, J)
    # grad I1 = 2 phi, grad J = cof phi, and grad I2 is twice the mixed cofactors of phi and cof phi.
    f1, f2, f3, g1, g2, g3, h1, h2, h3 = self.mixed_cofactors(phi, cofactors)
    a = 2 * V_1
    b = 2 * V_2
    return (
        a * x1 + b * f1 + V_J * c1,
        a * x2 + b * f2 + V_J * c2,
        a * x3 + b * f3 + V_J * c3,
        a * y1 + b * g1 + V_J * d1,
        a * y2 + b * g2 + V_J * d2,
        a * y3 + b * g3 + V_J * d3,
        a * z1 + b * h1 + V_J * e1,
        a * z2 + b * h2 + V_J * e2,
        a * z3 + b * h3 + V_J * e3,
    )


def _changes_of_invariants(self, x1, x2, x3, y1, y2, y3, z1, z2, z3, *change):
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
    phi = x1, x2, x3, y1, y2, y3, z1, z2, z3
    dx1, dx2, dx3, dy1, dy2, dy3, dz1, dz2, dz3 = change
    cofactors = self.cofactors(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    more = self.mixed_cofactors(phi, change)
    c1, c2, c3, d1, d2, d3, e1, e2, e3 = cofactors
    dc1, dc2, dc3, dd1, dd2, dd3, de1, de2, de3 = more
    f1, f2, f3, g1, g2, g3, h1, h2, h3 = self.mixed_cofactors(phi, cofactors)
    m1, m2, m3, n1, n2, n3, o1, o2, o3 = self.mixed_cofactors(change, cofactors)
    r1, r2, r3, s1, s2, s3, t1, t2, t3 = self.mixed_cofactors(phi, more)
    I1, I2, J = self.matrix_invariants(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    dI1 = 2 * (x1 * dx1 + x2 * dx2 + x3 * dx3 + y1 * dy1 + y2 * dy2 + y3 * dy3 + z1 * dz1 + z2 * dz2 + z3 * dz3)
    dI2 = 2 * (c1 * dc1 + c2 * dc2 + c3 * dc3 + d1 * dd1 + d2 * dd2 + d3 * dd3 + e1 * de1 + e2 * de2 + e3 * de3)
    dJ = c1 * dx1 + c2 * dx2 + c3 * dx3 + d1 * dy1 + d2 * dy2 + d3 * dy3 + e1 * dz1 + e2 * dz2 + e3 * dz3
    V_1, V_2, V_J = self.slopes(I1, I2, J)
    dV_1, dV_2, dV_J = self.changes(I1, I2, J, dI1, dI2, dJ)
    a = 2 * V_1
    b = 2 * V_2
    da = 2 * dV_1
    db = 2 * dV_2
    return (
        da * x1 + a * dx1 + db * f1 + b * (m1 + r1) + dV_J * c1 + V_J * dc1,
        da * x2 + a * dx2 + db * f2 + b * (m2 + r2) + dV_J * c2 + V_J * dc2,
        da * x3 + a * dx3 + db * f3 + b * (m3 + r3) + dV_J * c3 + V_J * dc3,
        da * y1 + a * dy1 + db * g1 + b * (n1 + s1) + dV_J * d1 + V_J * dd1,
        da * y2 + a * dy2 + db * g2 + b * (n2 + s2) + dV_J * d2 + V_J * dd2,
        da * y3 + a * dy3 + db * g3 + b * (n3 + s3) + dV_J * d3 + V_J * dd3,
        da * z1 + a * dz1 + db * h1 + b * (o1 + t1) + dV_J * e1 + V_J * de1,
        da * z2 + a * dz2 + db * h2 + b * (o2 + t2) + dV_J * e2 + V_J * de2,
        da * z3 + a * dz3 + db * h3 + b * (o3 + t3) + dV_J * e3 + V_J * de3,
    )


def _margin_of_invariants(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return a number that is positive for matrices inside the domain.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    float or ndarray
        Margin of the invariants.
    """
    I1, I2, J = self.matrix_invariants(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    return self.margin(I1, I2, J)


def _stretch_value_of_invariants(self, D1, D2, D3):
    """Return the potential energy V of stretches.

    Parameters
    ----------
    {stretches}

    Returns
    -------
    float or ndarray
        V, an energy.
    """
    A = D1 * D1
    B = D2 * D2
    C = D3 * D3
    return self.value(A + B + C, A * B + B * C + C * A, D1 * D2 * D3)


def _stretch_slopes_of_invariants(self, D1, D2, D3):
    """Return the derivatives of V in the stretches.

    Parameters
    ----------
    {stretches}

    Returns
    -------
    tuple of float or ndarray
        Three derivatives.
    """
    A = D1 * D1
    B = D2 * D2
    C = D3 * D3
    V_1, V_2, V_J = self.slopes(A + B + C, A * B + B * C + C * A, D1 * D2 * D3)
    return (
        2 * D1 * (V_1 + V_2 * (B + C)) + V_J * (D2 * D3),
        2 * D2 * (V_1 + V_2 * (C + A)) + V_J * (D3 * D1),
        2 * D3 * (V_1 + V_2 * (A + B)) + V_J * (D1 * D2),
    )


def _stretch_changes_of_invariants(self, D1, D2, D3, d1, d2, d3):
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
    A = D1 * D1
    B = D2 * D2
    C = D3 * D3
    dA = 2 * D1 * d1
    dB = 2 * D2 * d2
    dC = 2 * D3 * d3
    I1 = A + B + C
    I2 = A * B + B * C + C * A
    J = D1 * D2 * D3
    V_1, V_2, V_J = self.slopes(I1, I2, J)
    dV_1, dV_2, dV_J = self.changes(
        I1,
        I2,
        J,
        dA + dB + dC,
        dA * (B + C) + dB * (C + A) + dC * (A + B),
        d1 * D2 * D3 + D1 * d2 * D3 + D1 * D2 * d3,
    )
    return (
        2 * D1 * (dV_1 + dV_2 * (B + C) + V_2 * (dB + dC))
        + 2 * d1 * (V_1 + V_2 * (B + C))
        + dV_J * (D2 * D3)
        + V_J * (d2 * D3 + D2 * d3),
        2 * D2 * (dV_1 + dV_2 * (C + A) + V_2 * (dC + dA))
        + 2 * d2 * (V_1 + V_2 * (C + A))
        + dV_J * (D3 * D1)
        + V_J * (d3 * D1 + D3 * d1),
        2 * D3 * (dV_1 + dV_2 * (A + B) + V_2 * (dA + dB))
        + 2 * d3 * (V_1 + V_2 * (A + B))
        + dV_J * (D1 * D2)
        + V_J * (d1 * D2 + D1 * d2),
    )


def _stretch_margin_of_invariants(self, D1, D2, D3):
    """Return a number that is positive for stretches inside the domain.

    Parameters
    ----------
    {stretches}

    Returns
    -------
    float or ndarray
        Margin of the invariants.
    """
    A = D1 * D1
    B = D2 * D2
    C = D3 * D3
    return self.margin(A + B + C, A * B + B * C + C * A, D1 * D2 * D3)


# --- V(D1, D2, D3) ----------------------------------------------------------------------------------------------------


def turned_columns(self, first, second, one, other):
    """Return two columns rotated until they are orthogonal, and two others rotated by the same angle.

    Parameters
    ----------
    first, second : tuple of float or ndarray
        Columns that become orthogonal, three numbers each.
    one, other : tuple of float or ndarray
        Columns that are rotated, too.

    Returns
    -------
    tuple of tuple
        Four columns, in the same order.
    """
    a1, a2, a3 = first
    b1, b2, b3 = second
    u1, u2, u3 = one
    v1, v2, v3 = other
    more = b1 * b1 + b2 * b2 + b3 * b3 - (a1 * a1 + a2 * a2 + a3 * a3)
    both = 2 * (a1 * b1 + a2 * b2 + a3 * b3)
    tangent = both * np.copysign(1.0, more) / (np.sqrt(more * more) + np.sqrt(more * more + both * both) + TINY)
    c = 1 / np.sqrt(1 + tangent * tangent)
    s = c * tangent
    return (
        (c * a1 - s * b1, c * a2 - s * b2, c * a3 - s * b3),
        (s * a1 + c * b1, s * a2 + c * b2, s * a3 + c * b3),
        (c * u1 - s * v1, c * u2 - s * v2, c * u3 - s * v3),
        (s * u1 + c * v1, s * u2 + c * v2, s * u3 + c * v3),
    )


def singular_columns(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return the singular value decomposition of phi by Jacobi's rotations of its columns.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    tuple of float or ndarray
        Stretches D1, D2, D3 in any order; the columns of L as nine numbers; the columns of R; with phi = L diag(D) R^T.

    References
    ----------
    Demmel & Veselic 1992, SIAM J. Matrix Anal. Appl. 13, 1204: small stretches keep their relative accuracy.
    """
    one = 1.0 + 0.0 * x1
    zero = 0.0 * x1
    a, b, c = (x1, y1, z1), (x2, y2, z2), (x3, y3, z3)
    u, v, w = (one, zero, zero), (zero, one, zero), (zero, zero, one)
    for _ in range(SWEEPS):
        a, b, u, v = self.turned_columns(a, b, u, v)
        a, c, u, w = self.turned_columns(a, c, u, w)
        b, c, v, w = self.turned_columns(b, c, v, w)
    a1, a2, a3 = a
    b1, b2, b3 = b
    c1, c2, c3 = c
    D1 = np.sqrt(a1 * a1 + a2 * a2 + a3 * a3)
    D2 = np.sqrt(b1 * b1 + b2 * b2 + b3 * b3)
    D3 = np.sqrt(c1 * c1 + c2 * c2 + c3 * c3)
    k = 1 / D1
    m = 1 / D2
    n = 1 / D3
    left = k * a1, k * a2, k * a3, m * b1, m * b2, m * b3, n * c1, n * c2, n * c3
    return (D1, D2, D3), left, (u[0], u[1], u[2], v[0], v[1], v[2], w[0], w[1], w[2])


def in_space(self, L, R, M):
    """Return a matrix M of the principal axes in space and body, L M R^T.

    Parameters
    ----------
    L, R : tuple of float or ndarray
        Columns of the rotations, nine numbers each.
    M : tuple of float or ndarray
        Elements of M, nine numbers, row by row.

    Returns
    -------
    tuple of float or ndarray
        Nine elements, row by row.
    """
    m11, m12, m13, m21, m22, m23, m31, m32, m33 = M
    k1, k2, k3, l1, l2, l3, n1, n2, n3 = L
    u1, u2, u3, v1, v2, v3, w1, w2, w3 = R
    a1 = m11 * u1 + m12 * v1 + m13 * w1
    a2 = m11 * u2 + m12 * v2 + m13 * w2
    a3 = m11 * u3 + m12 * v3 + m13 * w3
    b1 = m21 * u1 + m22 * v1 + m23 * w1
    b2 = m21 * u2 + m22 * v2 + m23 * w2
    b3 = m21 * u3 + m22 * v3 + m23 * w3
    c1 = m31 * u1 + m32 * v1 + m33 * w1
    c2 = m31 * u2 + m32 * v2 + m33 * w2
    c3 = m31 * u3 + m32 * v3 + m33 * w3
    return (
        k1 * a1 + l1 * b1 + n1 * c1,
        k1 * a2 + l1 * b2 + n1 * c2,
        k1 * a3 + l1 * b3 + n1 * c3,
        k2 * a1 + l2 * b1 + n2 * c1,
        k2 * a2 + l2 * b2 + n2 * c2,
        k2 * a3 + l2 * b3 + n2 * c3,
        k3 * a1 + l3 * b1 + n3 * c1,
        k3 * a2 + l3 * b2 + n3 * c2,
        k3 * a3 + l3 * b3 + n3 * c3,
    )


def divided_slopes(self, Di, Dj, Dk, V_i, V_j):
    """Return (V_i - V_j)/(Di - Dj), regular where the stretches coincide.

    Parameters
    ----------
    Di, Dj, Dk : float or array_like
        Stretches, the third for the axis that is left.
    V_i, V_j : float or array_like
        Derivatives of V in the first two.

    Returns
    -------
    float or ndarray
        Divided difference. For close stretches it is half of the integral of the second derivative of V(m + t, m - t)
        over t, by Gauss's rule: relative error (1/128)^12.
    """
    middle = (Di + Dj) / 2
    half = (Di - Dj) / 2
    size = np.sqrt(half * half)
    limit = NEAR * middle
    far = np.maximum(size, limit)
    inner = np.minimum(size, limit)
    near = 1.0 * (size < limit)
    mean = 0.0 * half
    for node, weight in NODES:
        t = node * inner
        one, other, _ = self.changes(middle + t, middle - t, Dk, 1.0 + 0.0 * t, -1.0 + 0.0 * t, 0.0 * t)
        mean = mean + weight / 2 * (one - other)
    return near * mean + (1.0 - near) * (V_i - V_j) * np.copysign(1.0, half) / (2 * far)


def _value_of_stretches(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return the potential energy V of a matrix.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    float or ndarray
        V, an energy.
    """
    D, _, _ = self.singular_columns(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    return self.value(D[0], D[1], D[2])


def _slopes_of_stretches(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return the gradient of V in the elements of a matrix.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    tuple of float or ndarray
        Nine derivatives, row by row.
    """
    D, L, R = self.singular_columns(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    V_1, V_2, V_3 = self.slopes(D[0], D[1], D[2])
    zero = 0.0 * x1
    return self.in_space(L, R, (V_1, zero, zero, zero, V_2, zero, zero, zero, V_3))


def _changes_of_stretches(self, x1, x2, x3, y1, y2, y3, z1, z2, z3, *change):
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
    D, L, R = self.singular_columns(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    D1, D2, D3 = D
    k1, k2, k3, l1, l2, l3, n1, n2, n3 = L
    u1, u2, u3, v1, v2, v3, w1, w2, w3 = R
    back = (k1, l1, n1, k2, l2, n2, k3, l3, n3), (u1, v1, w1, u2, v2, w2, u3, v3, w3)
    # The change in the principal axes, L^T dphi R.
    m11, m12, m13, m21, m22, m23, m31, m32, m33 = self.in_space(back[0], back[1], change)
    V_1, V_2, V_3 = self.slopes(D1, D2, D3)
    c1, c2, c3 = self.changes(D1, D2, D3, m11, m22, m33)
    # Two axes stretch their symmetric shear by (V_i - V_j)/(Di - Dj) and their rotation by (V_i + V_j)/(Di + Dj).
    s12 = self.divided_slopes(D1, D2, D3, V_1, V_2) * (m12 + m21) / 2
    s23 = self.divided_slopes(D2, D3, D1, V_2, V_3) * (m23 + m32) / 2
    s31 = self.divided_slopes(D3, D1, D2, V_3, V_1) * (m31 + m13) / 2
    a12 = (V_1 + V_2) / (D1 + D2) * (m12 - m21) / 2
    a23 = (V_2 + V_3) / (D2 + D3) * (m23 - m32) / 2
    a31 = (V_3 + V_1) / (D3 + D1) * (m31 - m13) / 2
    changes = c1, s12 + a12, s31 - a31, s12 - a12, c2, s23 + a23, s31 + a31, s23 - a23, c3
    return self.in_space(L, R, changes)


def _margin_of_stretches(self, x1, x2, x3, y1, y2, y3, z1, z2, z3):
    """Return a number that is positive for matrices inside the domain, where det phi > 0.

    Parameters
    ----------
    {matrix_coordinates}

    Returns
    -------
    float or ndarray
        The lesser of det phi and the margin of the stretches.
    """
    J = x1 * (y2 * z3 - y3 * z2) + x2 * (y3 * z1 - y1 * z3) + x3 * (y1 * z2 - y2 * z1)
    D, _, _ = self.singular_columns(x1, x2, x3, y1, y2, y3, z1, z2, z3)
    return np.minimum(J, self.margin(D[0], D[1], D[2]))


def _stretch_value(self, D1, D2, D3):
    """Return the potential energy V of stretches.

    Parameters
    ----------
    {stretches}

    Returns
    -------
    float or ndarray
        V, an energy.
    """
    return self.value(D1, D2, D3)


def _stretch_slopes(self, D1, D2, D3):
    """Return the derivatives of V in the stretches.

    Parameters
    ----------
    {stretches}

    Returns
    -------
    tuple of float or ndarray
        Three derivatives.
    """
    return self.slopes(D1, D2, D3)


def _stretch_changes(self, D1, D2, D3, d1, d2, d3):
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
    return self.changes(D1, D2, D3, d1, d2, d3)


def _stretch_margin(self, D1, D2, D3):
    """Return a number that is positive for stretches inside the domain.

    Parameters
    ----------
    {stretches}

    Returns
    -------
    float or ndarray
        The least of the stretches and the margin.
    """
    return np.minimum(np.minimum(np.minimum(D1, D2), D3), self.margin(D1, D2, D3))


def _named(name, function):
    """Return a function under the name of the method that it becomes."""
    function.__name__ = name
    return function


of_invariants = _attached(
    (
        cofactors,
        mixed_cofactors,
        matrix_invariants,
        _named("matrix_value", _value_of_invariants),
        _named("matrix_slopes", _slopes_of_invariants),
        _named("matrix_changes", _changes_of_invariants),
        _named("matrix_margin", _margin_of_invariants),
        _named("stretch_value", _stretch_value_of_invariants),
        _named("stretch_slopes", _stretch_slopes_of_invariants),
        _named("stretch_changes", _stretch_changes_of_invariants),
        _named("stretch_margin", _stretch_margin_of_invariants),
    )
)
"""Decorator of a NamedTuple with value, slopes and margin of (I1, I2, J), and changes of (I1, I2, J, dI1, dI2, dJ)."""

of_stretches = _attached(
    (
        turned_columns,
        singular_columns,
        in_space,
        divided_slopes,
        _named("matrix_value", _value_of_stretches),
        _named("matrix_slopes", _slopes_of_stretches),
        _named("matrix_changes", _changes_of_stretches),
        _named("matrix_margin", _margin_of_stretches),
        _named("stretch_value", _stretch_value),
        _named("stretch_slopes", _stretch_slopes),
        _named("stretch_changes", _stretch_changes),
        _named("stretch_margin", _stretch_margin),
    )
)
"""Decorator of a NamedTuple with value, slopes and margin of (D1, D2, D3), and changes of (D1, D2, D3, d1, d2, d3)."""
