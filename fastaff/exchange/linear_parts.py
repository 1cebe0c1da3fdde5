"""Elements of a lattice by the images of points: matrices of linear ones, kicks that are compared with them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence

import numpy as np

from ..core.numbers import listed, shown
from .kicks import Kick

J = np.kron(np.array([[0.0, 1.0], [-1.0, 0.0]]), np.eye(2))
SMALL = 1e-5
"""Amplitude for the matrix of an element's linear part."""

LARGE = 1e-3
"""Amplitude for the matrix of a linear element."""

LINEAR = 1e-9
"""Largest error of a linear element."""

SYMPLECTIC = 1e-6
"""Largest error of symplecticity of such a matrix."""
STRENGTHS = ("k2", "k2s", "k3", "k3s", "knl", "ksl", "knl_rel", "ksl_rel", "PolynomB", "PolynomA")
"""Attributes for multipoles: of order 2 and more, or by order from 0."""


def higher(element: object) -> list[str]:
    """Return the names of an element's multipoles of order 2 and more that are not 0: k2, knl[3]."""
    held = ((name, getattr(element, name, 0.0)) for name in STRENGTHS)
    named = [(f"{name}[{n}]" if np.ndim(row) else name, n, row) for name, row in held for n in range(np.size(row))]
    return [name for name, n, row in named if np.ravel(row)[n] and (n > 1 or not np.ndim(row))]


def told(apertures: list[str]) -> list[str]:
    """Return the names of apertures; warn that they are no part of a map."""
    if apertures:
        said = ", ".join(map(repr, apertures[:3])) + (", ..." if apertures[3:] else "")
        warnings.warn(f"the map leaves out apertures ({said}): no orbit is lost there", UserWarning, stacklevel=6)
    return apertures


def kept_momentum(keeps: bool, name: str, kind: str, call: str) -> None:
    """Raise ValueError, naming the element and the call that switches it off, where it changes the momentum."""
    if not keeps:
        raise ValueError(f"the element {shown(name)} ({kind}) must not change the momentum. {call}")


def compared(kick: Kick, track: Callable[[np.ndarray], np.ndarray], name: str, kind: str) -> Kick:
    """Return the kick of an element; ValueError where the element's images of points are others."""
    points = LARGE * np.array(
        [[0.7, -0.6, 0.0, 0.4], [-0.4, 0.5, 0.0, 0.9], [0.3, 0.1, 0.0, -0.8], [0.8, 0.2, 0.0, 0.5]]
    )
    if not np.allclose(track(points.copy()), kick.images(points), rtol=LINEAR, atol=LINEAR * LARGE):
        raise ValueError(
            f"the element {shown(name)} ({kind}) must have the kick of its strengths. Remove shifts, tilts and scaling."
        )
    return kick


def probed(
    track: Callable[[np.ndarray], np.ndarray], name: str, kind: str, linear: bool, call: str, thick: Sequence[str] = ()
) -> tuple[np.ndarray, ...]:
    """Return the matrix (4, 4) and shift (4,) of an element, of its images of points (4, count) in ROWS' order; linear:
    whether that is taken where it is no more than the element's linear part; call: what to do where it is not; thick:
    multipoles beyond the linear part, which are never left out.

    Raises ValueError naming the element otherwise.
    """
    refused = f"the element {name!r} ({kind}) is neither linear nor a thin multipole"
    if thick:
        raise ValueError(f"{refused}, {listed(thick)} {'is' if len(thick) == 1 else 'are'} not 0: {call}")
    size = SMALL if linear else LARGE
    points = size * np.concatenate([np.eye(4), -np.eye(4), np.zeros((4, 1)), [[0.7], [-0.4], [0.3], [0.8]]], axis=1)
    images = np.asarray(track(points.copy()), dtype=float)
    if not np.isfinite(images).all():
        raise ValueError(f"the element {shown(name)} ({kind}) must not lose particles, which it does at {size:g}")
    shift = images[:, 8]
    matrix = (images[:, :4] - images[:, 4:8]) / (2 * size)
    if not linear and np.abs(matrix @ points[:, 9] + shift - images[:, 9]).max() > LINEAR * size:
        raise ValueError(f"{refused}: {call}")
    if np.abs(matrix.T @ J @ matrix - J).max() > SYMPLECTIC:
        raise ValueError(
            f"the element {shown(name)} ({kind}) must be symplectic on momentum. Switch off what damps or ramps."
        )
    for _ in range(2):  # to rounding symplectic, as differences of images are not
        matrix = matrix @ (np.eye(4) + J @ (matrix.T @ J @ matrix - J) / 2)
    return matrix, shift
