"""Affine motion in the plane before any chart: placements, inertia, kinetic energy, deformation tensors (section 2)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array, at_orbit, checked, first
from ..core.numbers import positive


class Inertia(NamedTuple):
    """Hold the moments of a mass distribution that affine motion depends on: total mass, centre of mass (2,), second
    moments J (2, 2).
    """

    mass: float
    centre: Array
    moments: Array


class TensorInvariants(NamedTuple):
    """Hold trace, determinant and eigenvalues (first >= second) of symmetric tensors, one each per orbit."""

    trace: Array
    determinant: Array
    first: Array
    second: Array


def placement(phi: ArrayLike, labels: ArrayLike, centre: ArrayLike = (0.0, 0.0)) -> Array:
    """Place material points in space.

    phi: (2, 2, ...).  labels: (2, points), Lagrange coordinates a^K.  centre: (2,) or (2, ...), the centre of mass x^i.
    Returns y (2, points, ...). Raises TypeError or ValueError for other shapes and for numbers not real and finite.
    Formula: y^i = phi^i_K a^K + x^i.  Source: EQa'.
    """
    matrix = checked("phi", phi, (2, 2))
    material = checked("labels", labels, (2,))
    x = checked("centre", centre, (2,))
    if material.ndim != 2:
        raise ValueError(f"labels takes shape (2, points); got shape {material.shape}")
    moved = np.einsum("ik...,kn->in...", matrix, material)
    return moved + x.reshape(2, 1, *(x.shape[1:] or (1,) * (matrix.ndim - 2)))


def inertia(labels: ArrayLike, masses: ArrayLike) -> Inertia:
    """Compute mass, centre of mass and second moments of material points.

    labels: (2, points), Lagrange coordinates.  masses: (points,), >= 0, not all 0. Returns Inertia; the moments are
    about the centre, where the paper puts the origin. The body is isotropic, as in all models here, when they are mu
    times the identity. Raises TypeError or ValueError for other input.
    Formula: J^KL = sum m a^K a^L.  Source: section 2, above EQ2.0.
    """
    material = checked("labels", labels, (2,))
    m = checked("masses", masses, ())
    if material.ndim != 2 or m.shape != material.shape[1:]:
        raise ValueError(f"labels takes (2, points) and masses (points,); got shapes {material.shape} and {m.shape}")
    if np.any(m < 0) or not np.sum(m) > 0:
        raise ValueError(f"masses must not be negative, nor all 0; got {m}")
    centre = material @ m / np.sum(m)
    about = material - centre[:, None]
    return Inertia(float(np.sum(m)), centre, (about * m) @ about.T)


def kinetic_energy(velocity: ArrayLike, moments: ArrayLike) -> Array:
    """Compute the internal kinetic energy of an affine body.

    velocity: dphi/dt (2, 2, ...).  moments: J (2, 2), or the number mu > 0 of an isotropic body, J = mu times identity.
    Returns T (...). Raises TypeError or ValueError for other shapes and for numbers not real and finite.
    Formula: T = Tr(dphi/dt^T dphi/dt J)/2.  (The centre of mass adds m |dx/dt|^2/2.)  Source: section 2, last formula;
    EQ2.2a.
    """
    rate = checked("velocity", velocity, (2, 2))
    J = positive("moments", moments) * np.eye(2) if np.ndim(moments) == 0 else checked("moments", moments, (2, 2))
    return np.einsum("ia...,ib...,ab->...", rate, rate, J) / 2


def green_tensor(phi: ArrayLike) -> Array:
    """Compute the Green deformation tensor, the metric of space pulled back to the body.

    phi: (2, 2, ...).  Returns G (2, 2, ...). Raises TypeError or ValueError for other input.
    Formula: G = phi^T phi = O(psi) diag(D1^2, D2^2) O(psi)^T.  Source: section 3, below EQ2.2f.
    """
    matrix = checked("phi", phi, (2, 2))
    return np.einsum("ia...,ib...->ab...", matrix, matrix)


def cauchy_tensor(phi: ArrayLike) -> Array:
    """Compute the Cauchy deformation tensor, the metric of the body pushed forward to space.

    phi: (2, 2, ...), det phi != 0.  Returns (2, 2, ...). Raises ValueError where det phi = 0, naming the orbit.
    Formula: phi^-T phi^-1 = (phi phi^T)^-1 = O(phi) diag(D1^-2, D2^-2) O(phi)^T.  Source: derived, with the Green
    tensor.
    """
    back = inverse(checked("phi", phi, (2, 2)))
    return np.einsum("ai...,aj...->ij...", back, back)


def tensor_invariants(tensor: ArrayLike) -> TensorInvariants:
    """Compute the invariants of symmetric tensors.

    tensor: (2, 2, ...), symmetric.  Returns TensorInvariants: r = D1^2 + D2^2, (D1 D2)^2, D1^2, D2^2 for the Green
    tensor. Raises TypeError or ValueError for other input.
    Formula: (trace +- hypot(t11 - t22, 2 t12))/2; the second is determinant/first where that loses fewer digits.
    Source: section 3, below EQ2.2f (rho = sqrt(Tr G)).
    """
    (t11, t12), (t21, t22) = checked("tensor", tensor, (2, 2))
    bad = np.abs(t12 - t21) > 1e-12 * (np.abs(t11) + np.abs(t22) + np.abs(t12))
    if np.any(bad):
        raise ValueError(f"tensor must be symmetric; it is not{at_orbit(first(bad)) or ' here'}")
    trace = t11 + t22
    determinant = t11 * t22 - t12 * t21
    spread = np.hypot(t11 - t22, t12 + t21)
    larger = np.where(trace >= 0, trace + spread, trace - spread) / 2
    other = np.divide(determinant, larger, out=np.zeros_like(larger), where=larger != 0)
    return TensorInvariants(trace, determinant, np.maximum(larger, other), np.minimum(larger, other))


def inverse(phi: np.ndarray, name: str = "phi") -> np.ndarray:
    """Compute the inverses of matrices.

    phi: (2, 2, ...), real or complex.  name: its name in a message.  Returns phi^-1 (2, 2, ...).
    Raises ValueError where det phi = 0, naming the orbit.  Source: EQ6.19, which needs it.
    """
    (x, y), (z, u) = phi
    det = x * u - y * z
    if np.any(det == 0):
        raise ValueError(f"{name} must be invertible; det {name} = 0{at_orbit(first(np.asarray(det == 0)))}")
    return np.stack([u, -y, -z, x]).reshape(2, 2, *np.shape(x)) / det
