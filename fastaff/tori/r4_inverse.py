"""From actions and angles to matrix elements in the charts of R^4: the formulas of `r4_tori`, solved for the state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..systems.charts.catalogue import CARTESIAN
from .closed_oscillators import swing
from .kernels.closed import TURN
from .r4_charts import R4Separated, Subspace


class RadialPlaces(NamedTuple):
    """Places of the radial motion, each (n,): |q|^2, q.p and dS_r/dL at fixed J_r."""

    s: np.ndarray
    root: np.ndarray
    swept: np.ndarray


def split_rows(separated: R4Separated, rows: np.ndarray) -> list[np.ndarray]:
    """Return the rows (4, n) of each subspace."""
    ends = np.cumsum([space.dimension for space in separated.family.subspaces])
    return np.split(rows, ends[:-1])


def momenta_of_actions(J: np.ndarray) -> np.ndarray:
    """Return |L_2|, L_3, ... of the actions (d, n) of a subspace."""
    return np.cumsum(np.abs(J[:0:-1]), axis=0) / TURN


def harmonic_energy(separated: R4Separated, J: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return E and dE/dJ (4, n) of a harmonic body: E = (omega/2 pi) times the sum of the actions, the radial ones
    doubled.
    """
    omega = np.sqrt(separated.body.stiffness / separated.mu)
    factors = np.concatenate(
        [[2.0 if space.dimension > 1 else 1.0, *np.ones(space.dimension - 1)] for space in separated.family.subspaces]
    )
    signs = np.where(J < 0, -1.0, 1.0)
    nu = omega / TURN * factors[:, None] * signs
    return (nu * J).sum(axis=0) + separated.body.offset, nu


def harmonic_places(separated: R4Separated, J: np.ndarray, L: np.ndarray, theta: np.ndarray) -> RadialPlaces:
    """Return the places of the radial motion of a harmonic body, of radial actions and angles (n,)."""
    s, root, around, chi = swing(J, L, np.sqrt(separated.mu * separated.body.stiffness), TURN * theta)
    return RadialPlaces(s, root, chi / 2 - around)


def line_points(separated: R4Separated, J: np.ndarray, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return one element of a harmonic body and its momentum, (1, n) each."""
    stiffness = np.sqrt(separated.mu * separated.body.stiffness)
    size = np.sqrt(2 * J / (TURN * stiffness))
    return -size * np.cos(TURN * theta), stiffness * size * np.sin(TURN * theta)


def subspace_points(
    space: Subspace, J: np.ndarray, theta: np.ndarray, places: RadialPlaces
) -> tuple[np.ndarray, np.ndarray]:
    """Return elements and momenta (d, n) of a subspace of at least two elements."""
    d = space.dimension
    sizes = momenta_of_actions(J)
    q, p = np.zeros((2, d, J.shape[1]))
    square = places.s
    root = places.root
    swept = places.swept
    for row, j in enumerate(range(d - 1, 1, -1), start=1):
        upper, lower = sizes[j - 1], sizes[j - 2]
        ratio = _quotient(lower, upper, 1.0)
        psi = TURN * theta[row] - swept
        sine, cosine = np.sin(psi), np.cos(psi)
        forward = 1.0 if space.from_axis[row - 1] else -1.0
        tilt = forward * np.sqrt((1 - ratio) * (1 + ratio))
        radius = np.sqrt(square)
        q[j] = radius * tilt * cosine
        # q_j q.p - |q|^2 p_j = |q| L_j c sin(psi) is the turn away from the axis.
        p[j] = _quotient(q[j] * root - radius * upper * tilt * sine, square, 0.0)
        root = root - q[j] * p[j]
        square = square * (ratio**2 * cosine**2 + sine**2)
        swept = swept + np.arctan2(sine, cosine) - np.arctan2(sine, ratio * cosine)
    sign = np.where(J[-1] < 0, -1.0, 1.0)
    azimuth = TURN * theta[-1] - sign * swept
    radius = np.sqrt(square)
    along = _quotient(root, radius, 0.0)
    across = _quotient(J[-1] / TURN, radius, 0.0)
    q[0], q[1] = radius * np.cos(azimuth), radius * np.sin(azimuth)
    p[0] = along * np.cos(azimuth) - across * np.sin(azimuth)
    p[1] = along * np.sin(azimuth) + across * np.cos(azimuth)
    return q, p


def gathered(separated: R4Separated, parts: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return the phase points (8, n) of the elements and momenta of all subspaces."""
    order = np.argsort([row for space in separated.family.subspaces for row in space.elements])
    q, p = (np.concatenate([part[i] for part in parts])[order] for i in range(2))
    return CARTESIAN.to_planes(np.concatenate([q, p]))


def _quotient(over: np.ndarray, under: np.ndarray, otherwise: float) -> np.ndarray:
    """Return a quotient, another value where the divisor is 0."""
    return np.where(under > 0, over / np.where(under > 0, under, 1.0), otherwise)
