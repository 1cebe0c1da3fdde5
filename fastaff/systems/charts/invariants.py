"""Matrices, angular momenta, deformation invariants and their relations, rotations and reflections of phase points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array, at_orbit, checked, first
from ...core.docstrings import inserts_parameters

ROOT2 = np.sqrt(2.0)


class AngularMomenta(NamedTuple):
    """Hold the angular momenta of phase points.

    Attributes
    ----------
    p_eta, p_gamma : ndarray, shape (...), action
        Angular momenta of the planes a and b.
    p_phi : ndarray, shape (...), action
        Spin.
    p_psi : ndarray, shape (...), action
        Vorticity.

    References
    ----------
    Martens & Slawianowski, EQ2.1b.
    """

    p_eta: Array
    p_gamma: Array
    p_phi: Array
    p_psi: Array


class Deformation(NamedTuple):
    """Hold the deformation invariants of phase points.

    The properties are functions of the same two numbers. The properties a, b and delta raise `ValueError` if det phi <=
    0; the message names the orbit.

    Attributes
    ----------
    D1, D2 : ndarray, shape (...), length
        Stretches, D1 >= ``|D2|``.
    alpha, beta : ndarray, shape (...), length
        Radii of the planes, (D1 + D2)/sqrt2 and (D1 - D2)/sqrt2, not negative.

    References
    ----------
    Martens & Slawianowski, EQ2.0, EQ2.0b, EQ2.2x-EQ2.2z; a, b and delta: section 3 and above EQ6.4a.
    """

    D1: Array
    D2: Array
    alpha: Array
    beta: Array

    @property
    def r(self) -> Array:
        """Size Tr phi^T phi = D1^2 + D2^2 = alpha^2 + beta^2 (EQ2.2x)."""
        return self.alpha**2 + self.beta**2

    @property
    def rho(self) -> Array:
        """Radius sqrt(r) in R^4 (EQ2.2x)."""
        return np.hypot(self.alpha, self.beta)

    @property
    def epsilon(self) -> Array:
        """Polar angle vartheta/2 in the plane (alpha, beta), in [0, pi/2]; 0 if alpha = beta = 0."""
        return np.arctan2(self.beta, self.alpha)

    @property
    def vartheta(self) -> Array:
        """Shear angle in [0, pi]: tan(vartheta) = (D1/D2 - D2/D1)/2 (EQ2.2x)."""
        return 2 * self.epsilon

    @property
    def area(self) -> Array:
        """Dilatation det phi = D1 D2 = (alpha^2 - beta^2)/2 = (r/2) cos(vartheta) (EQ2.2y, EQ2.2z)."""
        return self.D1 * self.D2

    @property
    def shear(self) -> Array:
        """Shear D1^2 - D2^2 = 2 alpha beta = r sin(vartheta) (EQ2.2y)."""
        return 2 * self.alpha * self.beta

    @property
    def a(self) -> Array:
        """Dilatation ln(D1 D2) of the exponential variables."""
        return np.log(self._positive("D1")) + np.log(self._positive("D2"))

    @property
    def b(self) -> Array:
        """Shear ln(D1/D2) >= 0 of the exponential variables, sinh(b) = tan(vartheta)."""
        return np.log(self._positive("D1")) - np.log(self._positive("D2"))

    @property
    def delta(self) -> Array:
        """Dilatation sqrt(D1 D2) = exp(a/2) (section 7, above EQ6.4a)."""
        return np.sqrt(self._positive("D1") * self._positive("D2"))

    def _positive(self, name: str) -> Array:
        value = np.asarray(getattr(self, name))
        if np.any(value <= 0):
            index = first(value <= 0)
            raise ValueError(f"a, b and delta need det phi = D1 D2 > 0; got {name} = {value[index]}{at_orbit(index)}")
        return value


def from_matrix(phi: ArrayLike, momentum: ArrayLike) -> Array:
    """Convert matrices and their momenta to phase points.

    Parameters
    ----------
    phi : array_like, shape (2, 2, ...)
        Matrices [[x, y], [z, u]].
    momentum : array_like, shape (2, 2, ...)
        Momenta [[p_x, p_y], [p_z, p_u]], for a body mu dphi/dt.

    Returns
    -------
    ndarray, shape (8, ...)
        Phase points: a1, a2, b1, b2, then their momenta.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If a shape is wrong or a number is not finite.

    Notes
    -----
    The planes are a = (x + u, z - y)/sqrt2 and b = (x - u, y + z)/sqrt2. Momenta and velocities transform in the same
    way.

    References
    ----------
    Martens & Slawianowski, EQ2.2c' (the matrix elements); the planes are derived.

    Examples
    --------
    >>> fa.charts.from_matrix(np.eye(2), np.zeros((2, 2))).round(6)
    array([1.414214, 0.      , 0.      , 0.      , 0.      , 0.      ,
           0.      , 0.      ])
    """
    position = checked("phi", phi, (2, 2))
    conjugate = checked("momentum", momentum, (2, 2))
    if position.shape != conjugate.shape:
        raise ValueError(f"momentum must have the shape of phi, {position.shape}; got {conjugate.shape}")
    return np.concatenate([_planes(position), _planes(conjugate)])


@inserts_parameters
def to_matrix(z: ArrayLike) -> tuple[Array, Array]:
    """Convert phase points to matrices and their momenta.

    Parameters
    ----------
    {body_states}

    Returns
    -------
    phi : ndarray, shape (2, 2, ...)
        Matrices [[x, y], [z, u]].
    momentum : ndarray, shape (2, 2, ...)
        Momenta of the matrix elements.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If a shape is wrong or a number is not finite.

    Notes
    -----
    The matrix is [[a1 + b1, b2 - a2], [a2 + b2, a1 - b1]]/sqrt2, and the momenta likewise.

    References
    ----------
    Martens & Slawianowski, EQ2.2c' (the matrix elements); the planes are derived.

    Examples
    --------
    >>> phi, momentum = fa.charts.to_matrix(fa.charts.from_matrix(np.diag([2.0, 1.0]), np.eye(2)))
    >>> phi.round(9)
    array([[2., 0.],
           [0., 1.]])
    """
    rows = checked("z", z, (8,))
    return _matrix(rows[:4]), _matrix(rows[4:])


@inserts_parameters
def angular_momenta(z: ArrayLike) -> AngularMomenta:
    """Compute the angular momenta, constants of every doubly isotropic motion.

    Parameters
    ----------
    {body_states}

    Returns
    -------
    `AngularMomenta`
        Four angular momenta of each phase point.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If a shape is wrong or a number is not finite.

    Notes
    -----
    The formulas p_eta = a x p_a, p_gamma = b x p_b, p_phi = p_gamma + p_eta, p_psi = p_gamma - p_eta are regular
    everywhere.

    References
    ----------
    Martens & Slawianowski, EQ2.1b.

    Examples
    --------
    >>> fa.charts.angular_momenta([1.0, 0.0, 0.5, 0.0, 0.0, 0.3, 0.0, 0.2]).p_phi.round(9)
    np.float64(0.4)
    """
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = checked("z", z, (8,))
    p_eta = a1 * pa2 - a2 * pa1
    p_gamma = b1 * pb2 - b2 * pb1
    return AngularMomenta(p_eta, p_gamma, p_gamma + p_eta, p_gamma - p_eta)


@inserts_parameters
def deformation(z: ArrayLike) -> Deformation:
    """Compute the deformation invariants of phase points.

    Parameters
    ----------
    {body_states}

    Returns
    -------
    `Deformation`
        Invariants, which rotations of space and of the body leave unchanged.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If a shape is wrong or a number is not finite.

    Notes
    -----
    * alpha = ``|a|``, beta = ``|b|``, D1 = (alpha + beta)/sqrt2, D2 = (alpha - beta)/sqrt2.
    * D1 and ``|D2|`` are the singular values of phi.
    * Accuracy: near det phi = 0 the error of D2 is a few units of round-off of D1.

    References
    ----------
    Martens & Slawianowski, EQ2.0, EQ2.0b.

    Examples
    --------
    >>> found = fa.charts.deformation(fa.charts.from_matrix(np.diag([2.0, 1.0]), np.eye(2)))
    >>> found.D1.round(9), found.D2.round(9)
    (np.float64(2.0), np.float64(1.0))
    """
    a1, a2, b1, b2 = checked("z", z, (8,))[:4]
    alpha, beta = np.hypot(a1, a2), np.hypot(b1, b2)
    return Deformation((alpha + beta) / ROOT2, (alpha - beta) / ROOT2, alpha, beta)


def vartheta_of_b(b: ArrayLike) -> Array:
    """Compute the shear angle from the exponential shear, the Gudermannian.

    Parameters
    ----------
    b : array_like, shape (...)
        Exponential shear ln(D1/D2).

    Returns
    -------
    ndarray, shape (...)
        Shear angle vartheta in (-pi/2, pi/2), in radians.

    Raises
    ------
    TypeError
        If `b` is not an array of real numbers.
    ValueError
        If a number is not finite.

    Notes
    -----
    The relations are tan(vartheta) = sinh(b), sin(vartheta) = tanh(b), cos(vartheta) = 1/cosh(b). The angle is computed
    as 2 arctan(tanh(b/2)).

    References
    ----------
    Martens & Slawianowski, section 3, below EQ2.2z.

    Examples
    --------
    >>> np.sin(fa.charts.vartheta_of_b(np.log(2.0))).round(9)  # tanh(b)
    np.float64(0.6)
    """
    return 2 * np.arctan(np.tanh(checked("b", b, ()) / 2))


def b_of_vartheta(vartheta: ArrayLike) -> Array:
    """Compute the exponential shear from the shear angle, the inverse Gudermannian.

    Parameters
    ----------
    vartheta : array_like, shape (...), radians
        Shear angle in (-pi/2, pi/2), where det phi > 0.

    Returns
    -------
    ndarray, shape (...)
        Exponential shear b = ln(D1/D2).

    Raises
    ------
    TypeError
        If `vartheta` is not an array of real numbers.
    ValueError
        If an angle is not in (-pi/2, pi/2).

    Notes
    -----
    The relation is sinh(b) = tan(vartheta).

    References
    ----------
    Martens & Slawianowski, section 3, below EQ2.2z.

    Examples
    --------
    >>> fa.charts.b_of_vartheta(np.pi / 4).round(9)
    np.float64(0.881373587)
    """
    angle = checked("vartheta", vartheta, ())
    outside = np.abs(angle) >= np.pi / 2
    if np.any(outside):
        index = first(outside)
        raise ValueError(f"vartheta must lie in (-pi/2, pi/2), where det phi > 0; got {angle[index]}{at_orbit(index)}")
    return np.arcsinh(np.tan(angle))


@inserts_parameters
def rotate(z: ArrayLike, *, space: float = 0.0, body: float = 0.0) -> Array:
    """Rotate phase points in space and in the body.

    Parameters
    ----------
    {body_states}
    space : array_like, shape (...), radians, default 0
        Angle of the rotation of space.
    body : array_like, shape (...), radians, default 0
        Angle of the rotation of the body.

    Returns
    -------
    ndarray, shape (8, ...)
        Rotated phase points.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If a shape is wrong or a number is not finite.

    Notes
    -----
    * Matrices: phi -> O(space) phi O(body)^T, and the momenta likewise.
    * Angles: phi -> phi + space, psi -> psi + body. Plane a rotates by space - body, plane b by space + body.
    * The right translation phi -> phi O(x) is body = -x.

    References
    ----------
    Martens & Slawianowski, EQ2.0, below it.

    Examples
    --------
    >>> z = fa.charts.rotate(fa.charts.from_matrix(np.eye(2), np.zeros((2, 2))), space=np.pi / 2)
    >>> fa.charts.to_matrix(z)[0].round(9) + 0.0
    array([[ 0., -1.],
           [ 1.,  0.]])
    """
    rows = checked("z", z, (8,))
    left = checked("space", space, ())
    right = checked("body", body, ())
    turned = [_turned(rows[2 * k], rows[2 * k + 1], left + (right if k % 2 else -right)) for k in range(4)]
    return np.concatenate([np.stack(pair) for pair in turned])


@inserts_parameters
def reflect_space(z: ArrayLike) -> Array:
    """Reflect phase points in space, phi -> diag(1, -1) phi.

    Parameters
    ----------
    {body_states}

    Returns
    -------
    ndarray, shape (8, ...)
        Reflected phase points.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If a shape is wrong or a number is not finite.

    Notes
    -----
    The momenta transform likewise. The sign of det phi changes, alpha <-> beta, and (eta, gamma) -> (-gamma, -eta).

    References
    ----------
    Martens & Slawianowski, derived from EQ2.0 with O(2).

    Examples
    --------
    >>> z = fa.charts.from_matrix(np.eye(2), np.zeros((2, 2)))
    >>> fa.charts.to_matrix(fa.charts.reflect_space(z))[0].round(9) + 0.0
    array([[ 1.,  0.],
           [ 0., -1.]])
    """
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = checked("z", z, (8,))
    return np.stack([b1, -b2, a1, -a2, pb1, -pb2, pa1, -pa2])


@inserts_parameters
def reflect_body(z: ArrayLike) -> Array:
    """Reflect phase points in the body, phi -> phi diag(1, -1).

    Parameters
    ----------
    {body_states}

    Returns
    -------
    ndarray, shape (8, ...)
        Reflected phase points.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If a shape is wrong or a number is not finite.

    Notes
    -----
    The momenta transform likewise. The sign of det phi changes, alpha <-> beta, and eta <-> gamma.

    References
    ----------
    Martens & Slawianowski, derived from EQ2.0 with O(2).

    Examples
    --------
    >>> z = fa.charts.from_matrix([[2.0, 1.0], [0.5, 1.0]], np.zeros((2, 2)))
    >>> fa.charts.to_matrix(fa.charts.reflect_body(z))[0].round(9) + 0.0
    array([[ 2. , -1. ],
           [ 0.5, -1. ]])
    """
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = checked("z", z, (8,))
    return np.stack([b1, b2, a1, a2, pb1, pb2, pa1, pa2])


def _turned(first_row: Array, second_row: Array, angle: Array) -> tuple[Array, Array]:
    c, s = np.cos(angle), np.sin(angle)
    return first_row * c - second_row * s, first_row * s + second_row * c


def _planes(matrix: Array) -> Array:
    """(2, 2, ...) -> (4, ...)."""
    (x, y), (z, u) = matrix
    return np.stack([x + u, z - y, x - u, y + z]) / ROOT2


def _matrix(planes: Array) -> Array:
    """(4, ...) -> (2, 2, ...)."""
    a1, a2, b1, b2 = planes
    return np.stack([a1 + b1, b2 - a2, a2 + b2, a1 - b1]).reshape(2, 2, *a1.shape) / ROOT2
