"""The two-polar form of GL(3,R): phi = L D R^T with rotations L in space and R in the body, and its momenta."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array, at_orbit, checked, first

LARGEST = 1e150
"""Largest element of a phase point: beyond it spin and vorticity overflow."""


class TwoPolar3(NamedTuple):
    """Hold the two-polar form of phase points of the body in space.

    Parameters
    ----------
    L : ndarray, shape (3, 3, ...)
        Rotation of the principal axes in space, with determinant 1.
    D : ndarray, shape (3, ...)
        Stretches, D1 >= D2 >= abs(D3). D3 has the sign of det phi.
    R : ndarray, shape (3, 3, ...)
        Rotation of the principal axes in the body, with determinant 1.
    p : ndarray, shape (3, ...)
        Momenta of the stretches.
    spin : ndarray, shape (3, ...)
        Spin about the axes x, y, z in space.
    vorticity : ndarray, shape (3, ...)
        Vorticity about the axes 1, 2, 3 in the body.

    Notes
    -----
    For an isotropic potential, spin and vorticity are conserved.

    References
    ----------
    Martens & Slawianowski, EQ2.0 and EQ2.1, for n = 3.

    Examples
    --------
    >>> z = np.concatenate([np.diag([3.0, 2.0, 1.0]).ravel(), np.zeros(9)])
    >>> fa.charts.two_polar3(z).D
    array([3., 2., 1.])
    """

    L: Array
    D: Array
    R: Array
    p: Array
    spin: Array
    vorticity: Array


def two_polar3(z: ArrayLike) -> TwoPolar3:
    """Return the two-polar form of phase points of the body in space.

    Parameters
    ----------
    z : array_like, shape (18, ...)
        Phase points of `Body3`: the elements of phi row by row, then their momenta.

    Returns
    -------
    TwoPolar3
        L, D, R, the momenta p of the stretches, spin and vorticity.

    Raises
    ------
    ValueError
        If `z` has another shape or a number that is not finite.

    Notes
    -----
    * Spin is the sum over the columns of phi of ``column x momentum``, vorticity that over the rows.
    * Columns of L and R have signs and, where stretches coincide, rotations that are not unique. They are those of
      LAPACK.

    References
    ----------
    Martens & Slawianowski, EQ2.0, for n = 3; Anderson et al. 1999, LAPACK Users' Guide.

    Examples
    --------
    >>> z = np.concatenate([np.diag([3.0, 2.0, 1.0]).ravel(), [0, 0, 0, 1.0, 0, 0, 0, 0, 0]])
    >>> fa.charts.two_polar3(z).spin, fa.charts.two_polar3(z).vorticity
    (array([0., 0., 3.]), array([ 0.,  0., -2.]))
    """
    phi, p = _matrices(z)
    spin = np.cross(phi, p, axis=0).sum(axis=1)
    vorticity = np.cross(phi, p, axis=1).sum(axis=0)
    moved = np.moveaxis(phi, (0, 1), (-2, -1))
    L, D, Rt = np.linalg.svd(moved)
    signs = np.ones_like(D)
    L = L * _signed(signs, np.linalg.det(L))[..., None, :]
    R = np.swapaxes(Rt, -1, -2) * _signed(signs, np.linalg.det(Rt))[..., None, :]
    D = D * _signed(signs, np.linalg.det(moved))
    inside = np.swapaxes(L, -1, -2) @ np.moveaxis(p, (0, 1), (-2, -1)) @ R
    own = np.diagonal(inside, axis1=-2, axis2=-1)
    back = (-2, -1), (0, 1)
    return TwoPolar3(
        np.moveaxis(L, *back), np.moveaxis(D, -1, 0), np.moveaxis(R, *back), np.moveaxis(own, -1, 0), spin, vorticity
    )


def from_two_polar3(
    L: ArrayLike,
    D: ArrayLike,
    R: ArrayLike,
    p: ArrayLike,
    spin: ArrayLike = (0.0, 0.0, 0.0),
    vorticity: ArrayLike = (0.0, 0.0, 0.0),
) -> np.ndarray:
    """Return phase points of the body in space from their two-polar form.

    Parameters
    ----------
    L : array_like, shape (3, 3, ...)
        Rotation of the principal axes in space.
    D : array_like, shape (3, ...)
        Stretches, of any order and sign.
    R : array_like, shape (3, 3, ...)
        Rotation of the principal axes in the body.
    p : array_like, shape (3, ...)
        Momenta of the stretches.
    spin, vorticity : array_like, shape (3, ...), optional
        Spin about the axes in space and vorticity about the axes in the body. Default: 0.

    Returns
    -------
    ndarray, shape (18, ...)
        Elements of phi row by row, then their momenta.

    Raises
    ------
    ValueError
        If an argument has another shape, L or R is not a rotation, or two stretches coincide while spin or vorticity
        about the third of the axes is not 0.

    Notes
    -----
    * In the principal axes spin and vorticity are ``D_i p_ji - D_j p_ij`` and ``D_i p_ij - D_j p_ji``. The matrix of
      the momenta p_ij follows from both unless D_i = D_j.
    * Round-off: momenta have the relative error of spin and vorticity times D_i/(D_i - D_j).

    References
    ----------
    Martens & Slawianowski, EQ2.0 and EQ2.1, for n = 3.

    Examples
    --------
    >>> z = fa.charts.from_two_polar3(np.eye(3), [3.0, 2.0, 1.0], np.eye(3), [0.1, 0.2, 0.3], spin=[0.0, 0.0, 1.0])
    >>> fa.charts.two_polar3(z).spin.round(12)
    array([0., 0., 1.])
    """
    left = _rotation("L", L)
    right = _rotation("R", R)
    D = checked("D", D, (3,))
    own = checked("p", p, (3,))
    turning = checked("spin", spin, (3,))
    curling = checked("vorticity", vorticity, (3,))
    shape = _common({"L": left[0], "R": right[0], "D": D, "p": own, "spin": turning, "vorticity": curling})
    S = np.einsum("ia...,i...->a...", left, turning)
    K = np.einsum("ia...,i...->a...", right, curling)
    inside = np.zeros((3, 3, *shape))
    diagonal = np.zeros((3, 3, *shape))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        gap = (D[i] - D[j]) * (D[i] + D[j])
        wrong = (gap == 0) & ((S[k] != 0) | (K[k] != 0))
        if np.any(wrong):
            raise ValueError(f"D must be of different size{at_orbit(first(np.asarray(wrong)))} for spin or vorticity.")
        w = 1 / np.where(gap == 0, 1.0, gap)
        inside[j, i] = (D[i] * S[k] + D[j] * K[k]) * w
        inside[i, j] = (D[j] * S[k] + D[i] * K[k]) * w
        inside[k, k] = own[k]
        diagonal[k, k] = D[k]
    found = [np.einsum("ia...,ab...,jb...->ij...", left, part, right) for part in (diagonal, inside)]
    return np.concatenate([np.broadcast_to(part, (3, 3, *shape)).reshape(9, *shape) for part in found])


def _matrices(z: ArrayLike) -> tuple[Array, Array]:
    """Return phi and p (3, 3, ...) of phase points."""
    rows = checked("z", z, (18,))
    if rows.size and np.abs(rows).max() > LARGEST:
        raise ValueError(f"z must be at most {LARGEST:g} in size, got {np.abs(rows).max():g}.")
    return rows[:9].reshape(3, 3, *rows.shape[1:]), rows[9:].reshape(3, 3, *rows.shape[1:])


def _signed(signs: Array, determinant: Array) -> Array:
    """Return signs (..., 3) whose third is that of a determinant, 1 where it is 0."""
    found = signs.copy()
    found[..., 2] = np.where(determinant < 0, -1.0, 1.0)
    return found


def _rotation(name: str, given: ArrayLike) -> Array:
    """Return rotations (3, 3, ...)."""
    matrix = checked(name, given, (3, 3))
    product = np.einsum("ia...,ib...->ab...", matrix, matrix)
    unit = np.eye(3).reshape(3, 3, *(1,) * (matrix.ndim - 2))
    turned = np.linalg.det(np.moveaxis(matrix, (0, 1), (-2, -1))) > 0
    if not (np.abs(product - unit) < 1e-9).all() or not np.all(turned):
        raise ValueError(f"{name} must be a rotation, got a matrix that is not orthogonal with determinant 1.")
    return matrix


def _common(given: dict[str, Array]) -> tuple[int, ...]:
    """Return the shape (...) of all arguments (3, ...) together."""
    shape: tuple[int, ...] = ()
    for name, vector in given.items():
        try:
            shape = np.broadcast_shapes(shape, vector.shape[1:])
        except ValueError:
            raise ValueError(
                f"{name} must be of as many orbits as the others, {shape}, got {vector.shape[1:]}."
            ) from None
    return shape
