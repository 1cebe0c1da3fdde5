"""Convert between matrices, planes and the paper's charts of GL(2,R), both ways, with momenta.

A phase point `z` has rows a1, a2, b1, b2, then their momenta: the planes a = (x + u, z - y)/sqrt2 and
b = (x - u, y + z)/sqrt2 of phi = [[x, y], [z, u]], an orthogonal and so canonical change of the matrix elements.
It is regular everywhere. The charts are for people, and each one is plane polar coordinates taken once or twice:

    a = alpha (cos eta, sin eta),   b = beta (cos gamma, sin gamma),   (alpha, beta) = sqrt(r) (cos, sin)(vartheta/2)
    D1, D2 = (alpha +- beta)/sqrt2,   phi = (eta + gamma)/2,   psi = (gamma - eta)/2

`from_planes` answers in the canonical sheet: alpha, beta >= 0; eta, gamma in [0, 2 pi); hence D1 >= |D2| with the sign
of det phi = D1 D2, vartheta in [0, pi], and, of the two pairs (phi, psi) ~ (phi + pi, psi + pi) of one matrix, the one
with phi in [0, 2 pi), psi in (-pi, pi). `to_planes` takes any sheet (negative radii, any turn of an angle).

Polar coordinates end where the radius is 0. There the angle is that of the momentum, so that p_radius = |momentum| and
p_angle = 0 exactly, the limit along the straight motion through that point, and the phase point comes back; where the
momentum is 0 too, the angle is 0. So at beta = 0 (D1 = D2, vartheta = 0): gamma = arg p_b, p_beta = |p_b|, p_gamma = 0;
and so for eta at alpha = 0 (D1 = -D2, vartheta = pi). At r = 0 vartheta = 2 arg(p_alpha, p_beta), p_vartheta = 0, and
p_r = p_rho/(2 sqrt(r)) is +inf (0 for a body at rest): the only value here that is not finite and does not come back.

Rounding: a round trip returns z to a few units of rounding of each plane in ALPHA_BETA. The other two keep beta or
alpha only beside the larger one, so near a singular set they return momenta to eps |p| sqrt(r)/min(alpha, beta), and
a radius below eps sqrt(r) reads as 0 (`to_planes` then refuses an angular momentum that is not 0).

Source: Martens, Slawianowski, "Affinely-Rigid Body and Oscillatory Dynamical Models on GL(2,R)", labels as cited.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

ROOT2 = np.sqrt(2.0)
TURN = 2*np.pi


class Chart(NamedTuple):
    """Carry one coordinate system of GL(2,R) as a value: `ALPHA_BETA.from_planes(z)`.

    name: the chart in words.  names: its four coordinates, in row order; `momenta`: the names of the other four rows.
    from_planes(z) -> q and to_planes(q) -> z: arrays (8, ...) of any trailing shape, rows coordinates then conjugate
    momenta; angles in radians. Both raise TypeError or ValueError for what is not 8 rows of finite real numbers, and
    to_planes raises ValueError where a momentum would be infinite.
    Source: EQ2.0a (TWO_POLAR), EQ2.0b (ALPHA_BETA), EQ2.2f (R_VARTHETA).
    """

    name: str
    names: tuple[str, str, str, str]
    from_planes: Callable[[ArrayLike], Array]
    to_planes: Callable[[ArrayLike], Array]

    @property
    def momenta(self) -> tuple[str, ...]:
        return tuple(f"p_{name}" for name in self.names)


class AngularMomenta(NamedTuple):
    """Hold the angular momenta of the planes, p_eta and p_gamma, the spin p_phi and the vorticity p_psi (EQ2.1b)."""

    p_eta: Array
    p_gamma: Array
    p_phi: Array
    p_psi: Array


class Deformation(NamedTuple):
    """Hold the deformation invariants D1 >= |D2| (EQ2.0) and alpha, beta >= 0 (EQ2.0b), one each per orbit."""

    D1: Array
    D2: Array
    alpha: Array
    beta: Array


def from_matrix(phi: ArrayLike, momentum: ArrayLike) -> Array:
    """Convert matrices and their momenta to phase points.

    phi: (2, 2, ...), [[x, y], [z, u]].  momentum: the same shape, [[p_x, p_y], [p_z, p_u]] (mu dphi/dt for a body).
    Returns z, (8, ...). Raises TypeError or ValueError for other shapes and for numbers not real and finite.
    Formula: a = (x + u, z - y)/sqrt2, b = (x - u, y + z)/sqrt2, and the same for the momenta.
    Source: EQ2.2c' (the matrix elements); the planes are derived.
    """
    position, conjugate = _checked("phi", phi, (2, 2)), _checked("momentum", momentum, (2, 2))
    if position.shape != conjugate.shape:
        raise ValueError(f"momentum must have the shape of phi, {position.shape}; got {conjugate.shape}")
    return np.concatenate([_planes(position), _planes(conjugate)])


def to_matrix(z: ArrayLike) -> tuple[Array, Array]:
    """Convert phase points to matrices and their momenta.

    z: (8, ...).  Returns (phi, momentum), each (2, 2, ...). Raises TypeError or ValueError as `from_matrix`.
    Formula: [[x, y], [z, u]] = [[a1 + b1, b2 - a2], [a2 + b2, a1 - b1]]/sqrt2, and the same for the momenta.
    Source: EQ2.2c' (the matrix elements); the planes are derived.
    """
    rows = _checked("z", z, (8,))
    return _matrix(rows[:4]), _matrix(rows[4:])


def angular_momenta(z: ArrayLike) -> AngularMomenta:
    """Compute the four angular momenta, constants of every doubly isotropic motion.

    z: (8, ...).  Returns AngularMomenta, each (...). Raises TypeError or ValueError as `from_matrix`.
    Formula: p_eta = a x p_a, p_gamma = b x p_b, p_phi = p_gamma + p_eta, p_psi = p_gamma - p_eta; regular everywhere.
    Source: EQ2.1b.
    """
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = _checked("z", z, (8,))
    p_eta, p_gamma = a1*pa2 - a2*pa1, b1*pb2 - b2*pb1
    return AngularMomenta(p_eta, p_gamma, p_gamma + p_eta, p_gamma - p_eta)


def deformation(z: ArrayLike) -> Deformation:
    """Compute the deformation invariants, which do not feel rotations of space and of material.

    z: (8, ...).  Returns Deformation, each (...). Raises TypeError or ValueError as `from_matrix`.
    Formula: alpha = |a|, beta = |b|, D1, D2 = (alpha +- beta)/sqrt2; D1 and |D2| are the singular values of phi.
    Near det phi = 0 the error of D2 is a few units of rounding of D1.  Source: EQ2.0, EQ2.0b.
    """
    a1, a2, b1, b2 = _checked("z", z, (8,))[:4]
    alpha, beta = np.hypot(a1, a2), np.hypot(b1, b2)
    return Deformation(*_turned(alpha, beta), alpha, beta)


def _alpha_beta_from_planes(z: ArrayLike) -> Array:
    """Convert phase points (8, ...) to alpha, beta, eta, gamma and momenta: two plane polar charts.

    Formula: p_alpha = a . p_a/alpha, p_eta = a x p_a; p_beta, p_gamma likewise.  Source: EQ2.0b.
    """
    a1, a2, b1, b2, pa1, pa2, pb1, pb2 = _checked("z", z, (8,))
    alpha, eta, p_alpha, p_eta = _polar(a1, a2, pa1, pa2)
    beta, gamma, p_beta, p_gamma = _polar(b1, b2, pb1, pb2)
    return np.stack([alpha, beta, eta, gamma, p_alpha, p_beta, p_eta, p_gamma])


def _alpha_beta_to_planes(q: ArrayLike) -> Array:
    """Convert alpha, beta, eta, gamma and momenta (8, ...) to phase points.

    Raises ValueError where p_eta is not 0 at alpha = 0, or p_gamma at beta = 0.
    Formula: p_a = p_alpha e + (p_eta/alpha) e', e = (cos eta, sin eta), e' = (-sin eta, cos eta).  Source: EQ2.0b.
    """
    alpha, beta, eta, gamma, p_alpha, p_beta, p_eta, p_gamma = _checked("q", q, (8,))
    spin_a = _transverse(p_eta, alpha, "p_eta = (p_phi - p_psi)/2", "alpha = (D1 + D2)/sqrt2")
    spin_b = _transverse(p_gamma, beta, "p_gamma = (p_phi + p_psi)/2", "beta = (D1 - D2)/sqrt2")
    a1, a2, pa1, pa2 = _cartesian(alpha, np.cos(eta), np.sin(eta), p_alpha, spin_a)
    b1, b2, pb1, pb2 = _cartesian(beta, np.cos(gamma), np.sin(gamma), p_beta, spin_b)
    return np.stack([a1, a2, b1, b2, pa1, pa2, pb1, pb2])


def _two_polar_from_planes(z: ArrayLike) -> Array:
    """Convert phase points (8, ...) to D1, D2, phi, psi and momenta.

    Formula: D1, D2 = (alpha +- beta)/sqrt2, phi, psi = (gamma +- eta)/2; p_D1, p_D2 = (p_alpha +- p_beta)/sqrt2,
    p_phi, p_psi = p_gamma +- p_eta.  Source: EQ2.0, EQ2.0a.
    """
    alpha, beta, eta, gamma, p_alpha, p_beta, p_eta, p_gamma = _alpha_beta_from_planes(z)
    return np.stack([*_turned(alpha, beta), (gamma + eta)/2, (gamma - eta)/2,
                     *_turned(p_alpha, p_beta), p_gamma + p_eta, p_gamma - p_eta])


def _two_polar_to_planes(q: ArrayLike) -> Array:
    """Convert D1, D2, phi, psi and momenta (8, ...) to phase points.

    Raises ValueError where p_phi + p_psi is not 0 at D1 = D2 (beta = 0), or p_phi - p_psi at D1 = -D2 (alpha = 0).
    Formula: the inverse of the one of `TWO_POLAR.from_planes`; any signs and order of D1, D2.  Source: EQ2.0, EQ2.0a.
    """
    D1, D2, phi, psi, p_D1, p_D2, p_phi, p_psi = _checked("q", q, (8,))
    return _alpha_beta_to_planes(np.stack([*_turned(D1, D2), phi - psi, phi + psi,
                                           *_turned(p_D1, p_D2), (p_phi - p_psi)/2, (p_phi + p_psi)/2]))


def _r_vartheta_from_planes(z: ArrayLike) -> Array:
    """Convert phase points (8, ...) to r, vartheta, phi, psi and momenta: polar coordinates of the (alpha, beta) plane.

    Formula: r = rho^2, vartheta = 2 epsilon, p_r = p_rho/(2 rho), p_vartheta = p_epsilon/2, where (rho, epsilon) are
    polar in (alpha, beta). At r = 0 p_r is +inf, or 0 for a body at rest.  Source: EQ2.2f, EQ2.2x, EQ2.2y.
    """
    alpha, beta, eta, gamma, p_alpha, p_beta, p_eta, p_gamma = _alpha_beta_from_planes(z)
    rho, epsilon, p_rho, p_epsilon = _polar(alpha, beta, p_alpha, p_beta)
    r = rho*rho
    return np.stack([r, 2*epsilon, (gamma + eta)/2, (gamma - eta)/2,
                     _quotient(p_rho, 2*np.sqrt(r)), p_epsilon/2, p_gamma + p_eta, p_gamma - p_eta])


def _r_vartheta_to_planes(q: ArrayLike) -> Array:
    """Convert r, vartheta, phi, psi and momenta (8, ...) to phase points.

    Raises ValueError where r < 0, where p_vartheta is not 0 at r = 0, and where p_eta = (p_phi - p_psi)/2 is not 0 at
    alpha = 0 (vartheta = pi) or p_gamma = (p_phi + p_psi)/2 at beta = 0 (vartheta = 0).
    Formula: the inverse of the one of `R_VARTHETA.from_planes`, with cos(vartheta/2) = sin((pi - vartheta)/2) so that
    the double nearest pi is alpha = 0 exactly.  Source: EQ2.2f.
    """
    r, vartheta, phi, psi, p_r, p_vartheta, p_phi, p_psi = _checked("q", q, (8,))
    if np.any(r < 0):
        raise ValueError(f"q: r = D1^2 + D2^2 must not be negative; got r = {np.min(r)}")
    rho = np.sqrt(r)
    alpha, beta, p_alpha, p_beta = _cartesian(rho, np.sin((np.pi - vartheta)/2), np.sin(vartheta/2), 2*rho*p_r,
                                              _transverse(p_vartheta, rho/2, "p_vartheta", "r"))
    return _alpha_beta_to_planes(np.stack([alpha, beta, phi - psi, phi + psi,
                                           p_alpha, p_beta, (p_phi - p_psi)/2, (p_phi + p_psi)/2]))


TWO_POLAR = Chart("two-polar", ("D1", "D2", "phi", "psi"), _two_polar_from_planes, _two_polar_to_planes)
ALPHA_BETA = Chart("alpha-beta", ("alpha", "beta", "eta", "gamma"), _alpha_beta_from_planes, _alpha_beta_to_planes)
R_VARTHETA = Chart("r-vartheta", ("r", "vartheta", "phi", "psi"), _r_vartheta_from_planes, _r_vartheta_to_planes)


def _polar(x: Array, y: Array, p_x: Array, p_y: Array) -> tuple[Array, Array, Array, Array]:
    """Return (radius, angle in [0, 2 pi), p_radius, p_angle) of a plane; at radius 0 take the angle of (p_x, p_y)."""
    radius = np.hypot(x, y)
    off_centre = radius > 0
    e_x, e_y = np.where(off_centre, x, p_x) + 0.0, np.where(off_centre, y, p_y) + 0.0   # + 0.0 takes the sign from -0.0
    length = np.hypot(e_x, e_y)
    length = np.where(length > 0, length, 1.0)
    angle = np.mod(np.arctan2(e_y, e_x), TURN)
    angle = np.where(angle < TURN, angle, 0.0)                                          # -1e-20 mod 2 pi rounds to 2 pi
    return radius, angle, (e_x/length)*p_x + (e_y/length)*p_y, x*p_y - y*p_x


def _cartesian(radius: Array, cosine: Array, sine: Array, p_radius: Array,
               transverse: Array) -> tuple[Array, Array, Array, Array]:
    """Return (x, y, p_x, p_y) from a radius, its direction, and the radial and transverse momenta."""
    return (radius*cosine, radius*sine,
            p_radius*cosine - transverse*sine, p_radius*sine + transverse*cosine)


def _transverse(p_angle: Array, radius: Array, p_name: str, radius_name: str) -> Array:
    """Return p_angle/radius, 0 where both are 0; refuse an infinite one."""
    momentum = _quotient(p_angle, radius)
    if not np.isfinite(momentum).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(momentum))[0])
        raise ValueError(f"q: {p_name} must be 0 where {radius_name} = 0 (the momentum across the radius is their "
                         f"quotient, infinite here); got {p_angle[index]}" + (f" at orbit {index}" if index else ""))
    return momentum


def _quotient(p: Array, radius: Array) -> Array:
    """Return p/radius without warnings, 0 where p is 0 and infinite where only the radius is."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(p == 0, 0.0, p/radius)


def _turned(first: Array, second: Array) -> tuple[Array, Array]:
    """Return ((first + second), (first - second))/sqrt2: alpha, beta to D1, D2, and back."""
    return (first + second)/ROOT2, (first - second)/ROOT2


def _planes(matrix: Array) -> Array:
    """(2, 2, ...) -> (4, ...)."""
    (x, y), (z, u) = matrix
    return np.stack([x + u, z - y, x - u, y + z])/ROOT2


def _matrix(planes: Array) -> Array:
    """(4, ...) -> (2, 2, ...)."""
    a1, a2, b1, b2 = planes
    return np.stack([a1 + b1, b2 - a2, a2 + b2, a1 - b1]).reshape(2, 2, *a1.shape)/ROOT2


def _checked(name: str, value: ArrayLike, leading: tuple[int, ...]) -> Array:
    """Return `value` as floats of shape (*leading, ...), or say what was wrong with it."""
    takes = f"{name} takes finite real numbers of shape ({', '.join(map(str, leading))}, ...)"
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{takes}; got rows of different lengths") from error
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{takes}; got {type(value).__name__} of {array.dtype}")
    if array.shape[:len(leading)] != leading:
        raise ValueError(f"{takes}; got shape {array.shape}")
    array = array.astype(np.float64, copy=False)
    if not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{takes}; got {array[index]} at index {index} (leave out orbits that have failed)")
    return array
