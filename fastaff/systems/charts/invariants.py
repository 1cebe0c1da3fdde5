"""Matrices, angular momenta, deformation invariants and their relations, rotations and reflections of phase points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array, at_orbit, checked, first

ROOT2 = np.sqrt(2.0)


class AngularMomenta(NamedTuple):
    """Hold the angular momenta of the planes, p_eta and p_gamma, the spin p_phi and the vorticity p_psi (EQ2.1b)."""

    p_eta: Array
    p_gamma: Array
    p_phi: Array
    p_psi: Array


class Deformation(NamedTuple):
    """Hold the deformation invariants D1 >= ``|D2|`` (EQ2.0) and alpha, beta >= 0 (EQ2.0b), one each per orbit.

    The properties are the paper's other names of the same two numbers; each is a formula of EQ2.2x-EQ2.2z or of the
    exponential variables of section 3. a, b and delta raise ValueError where det phi <= 0, naming the orbit.
    """

    D1: Array
    D2: Array
    alpha: Array
    beta: Array

    @property
    def r(self) -> Array:
        """The size Tr phi^T phi = D1^2 + D2^2 = alpha^2 + beta^2 (EQ2.2x)."""
        return self.alpha**2 + self.beta**2

    @property
    def rho(self) -> Array:
        """The radius sqrt(r) in R^4 (EQ2.2x)."""
        return np.hypot(self.alpha, self.beta)

    @property
    def epsilon(self) -> Array:
        """The polar angle vartheta/2 in the plane (alpha, beta), in [0, pi/2]; 0 at alpha = beta = 0."""
        return np.arctan2(self.beta, self.alpha)

    @property
    def vartheta(self) -> Array:
        """The shear angle in [0, pi]: tan(vartheta) = (D1/D2 - D2/D1)/2 (EQ2.2x)."""
        return 2 * self.epsilon

    @property
    def area(self) -> Array:
        """The dilatation det phi = D1 D2 = (alpha^2 - beta^2)/2 = (r/2) cos(vartheta) (EQ2.2y, EQ2.2z)."""
        return self.D1 * self.D2

    @property
    def shear(self) -> Array:
        """D1^2 - D2^2 = 2 alpha beta = r sin(vartheta) (EQ2.2y)."""
        return 2 * self.alpha * self.beta

    @property
    def a(self) -> Array:
        """ln(D1 D2): the dilatation of the exponential variables."""
        return np.log(self._positive("D1")) + np.log(self._positive("D2"))

    @property
    def b(self) -> Array:
        """ln(D1/D2) >= 0: the shear of the exponential variables, sinh(b) = tan(vartheta)."""
        return np.log(self._positive("D1")) - np.log(self._positive("D2"))

    @property
    def delta(self) -> Array:
        """sqrt(D1 D2) = e^{a/2} (section 7, above EQ6.4a)."""
        return np.sqrt(self._positive("D1") * self._positive("D2"))

    def _positive(self, name: str) -> Array:
        value = np.asarray(getattr(self, name))
        if np.any(value <= 0):
            index = first(value <= 0)
            raise ValueError(f"a, b and delta need det phi = D1 D2 > 0; got {name} = {value[index]}{at_orbit(index)}")
        return value


def from_matrix(phi: ArrayLike, momentum: ArrayLike) -> Array:
    """Convert matrices and their momenta to phase points.

    phi: (2, 2, ...), [[x, y], [z, u]]. momentum: the same shape, [[p_x, p_y], [p_z, p_u]] (mu dphi/dt for a body).

    :Returns: z, (8, ...).
    :Raises: TypeError or ValueError for other shapes and for numbers not real and finite.
    :Formula: a = (x + u, z - y)/sqrt2, b = (x - u, y + z)/sqrt2, and the same for the momenta (or velocities).
    :Source: EQ2.2c' (the matrix elements); the planes are derived.

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


def to_matrix(z: ArrayLike) -> tuple[Array, Array]:
    """Convert phase points to matrices and their momenta.

    z: (8, ...).

    :Returns: (phi, momentum), each (2, 2, ...).
    :Raises: TypeError or ValueError as `from_matrix`.
    :Formula: [[x, y], [z, u]] = [[a1 + b1, b2 - a2], [a2 + b2, a1 - b1]]/sqrt2, and the same for the momenta.
    :Source: EQ2.2c' (the matrix elements); the planes are derived.

    Examples
    --------
    >>> phi, momentum = fa.charts.to_matrix(fa.charts.from_matrix(np.diag([2.0, 1.0]), np.eye(2)))
    >>> phi.round(9)
    array([[2., 0.],
           [0., 1.]])
    """
    rows = checked("z", z, (8,))
    return _matrix(rows[:4]), _matrix(rows[4:])


def angular_momenta(z: ArrayLike) -> AngularMomenta:
    """Compute the four angular momenta, constants of every doubly isotropic motion.

    z: (8, ...).

    :Returns: AngularMomenta, each (...).
    :Raises: TypeError or ValueError as `from_matrix`.
    :Formula: p_eta = a x p_a, p_gamma = b x p_b, p_phi = p_gamma + p_eta, p_psi = p_gamma - p_eta; regular everywhere.
    :Source: EQ2.1b.

    Examples
    --------
    >>> fa.charts.angular_momenta([1.0, 0.0, 0.5, 0.0, 0.0, 0.3, 0.0, 0.2]).p_phi.round(9)
    np.float64(0.4)
    """
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = checked("z", z, (8,))
    p_eta = a1 * pa2 - a2 * pa1
    p_gamma = b1 * pb2 - b2 * pb1
    return AngularMomenta(p_eta, p_gamma, p_gamma + p_eta, p_gamma - p_eta)


def deformation(z: ArrayLike) -> Deformation:
    """Compute the deformation invariants, which rotations of space and of material leave unchanged.

    z: (8, ...).

    :Returns: Deformation, each (...).
    :Raises: TypeError or ValueError as `from_matrix`.
    :Formula: alpha = ``|a|``, beta = ``|b|``, D1, D2 = (alpha +- beta)/sqrt2; D1 and ``|D2|`` are the singular values
        of phi. Near det phi = 0 the error of D2 is a few units of rounding of D1.
    :Source: EQ2.0, EQ2.0b.

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
    """Compute the shear angle of the exponential shear b = ln(D1/D2), the Gudermannian.

    b: (...).

    :Returns: vartheta (...) in (-pi/2, pi/2).
    :Raises: TypeError or ValueError for numbers not real and finite.
    :Formula: tan(vartheta) = sinh(b), sin(vartheta) = tanh(b), cos(vartheta) = 1/cosh(b), as 2 arctan(tanh(b/2)).
    :Source: section 3, below EQ2.2z.

    Examples
    --------
    >>> np.sin(fa.charts.vartheta_of_b(np.log(2.0))).round(9)  # tanh(b)
    np.float64(0.6)
    """
    return 2 * np.arctan(np.tanh(checked("b", b, ()) / 2))


def b_of_vartheta(vartheta: ArrayLike) -> Array:
    """Compute the exponential shear b = ln(D1/D2) of the shear angle, the inverse Gudermannian.

    vartheta: (...) in (-pi/2, pi/2), where det phi > 0.

    :Returns: b (...).
    :Raises: ValueError for other angles.
    :Formula: sinh(b) = tan(vartheta).
    :Source: section 3, below EQ2.2z.

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


def rotate(z: ArrayLike, *, space: float = 0.0, body: float = 0.0) -> Array:
    """Rotate phase points in space and in the body: phi -> O(space) phi O(body)^T, the momenta alike.

    z: (8, ...). space, body: angles in radians, numbers or (...).

    :Returns: z (8, ...).
    :Raises: TypeError or ValueError as `from_matrix`.
    :Formula: phi -> phi + space, psi -> psi + body, so plane a turns by space - body, plane b by space + body. (The
        right translation phi -> phi O(x) is body = -x.)
    :Source: EQ2.0, below it.

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


def reflect_space(z: ArrayLike) -> Array:
    """Reflect phase points in space: phi -> diag(1, -1) phi, the momenta alike.

    z: (8, ...).

    :Returns: z (8, ...).
    :Raises: TypeError or ValueError as `from_matrix`.
    :Formula: det phi changes its sign, alpha <-> beta, (eta, gamma) -> (-gamma, -eta).
    :Source: derived (EQ2.0 with O(2)).

    Examples
    --------
    >>> z = fa.charts.from_matrix(np.eye(2), np.zeros((2, 2)))
    >>> fa.charts.to_matrix(fa.charts.reflect_space(z))[0].round(9) + 0.0
    array([[ 1.,  0.],
           [ 0., -1.]])
    """
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = checked("z", z, (8,))
    return np.stack([b1, -b2, a1, -a2, pb1, -pb2, pa1, -pa2])


def reflect_body(z: ArrayLike) -> Array:
    """Reflect phase points in the body: phi -> phi diag(1, -1), the momenta alike.

    z: (8, ...).

    :Returns: z (8, ...).
    :Raises: TypeError or ValueError as `from_matrix`.
    :Formula: det phi changes its sign, alpha <-> beta, eta <-> gamma.
    :Source: derived (EQ2.0 with O(2)).

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
