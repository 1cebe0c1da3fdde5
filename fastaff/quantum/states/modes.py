"""Normal and local modes of a vibration about its lowest minimum."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...runs.requirements import current_system
from ...sections.accessible_box import minima, potential_of, walled

WAYS = ("normal", "local")
"""Kinds of modes for the quantum numbers."""


class NormalModes(NamedTuple):
    """The equilibrium (2n,), and motions Re a v e^(i omega t) about it: v (2n, modes), with the action |a|^2/2; omega.

    Their amplitudes a are v^+ i S (z - equilibrium), S the symplectic matrix.
    """

    equilibrium: np.ndarray
    v: np.ndarray
    omega: np.ndarray

    def start(self, J: np.ndarray) -> np.ndarray:
        """Return the phase point (2n,) with actions J (modes,) in the limit of small ones, all modes at phase 0."""
        return self.equilibrium + (self.v @ np.sqrt(J / np.pi)).real

    def kicked(self, J: np.ndarray) -> np.ndarray:
        """Return the phase point (2n,) at the equilibrium, with the momenta of small actions J (modes,)."""
        return self.equilibrium + (self.v @ (-1j * np.sqrt(J / np.pi))).real

    def size(self, h: float) -> np.ndarray:
        """Return the amplitudes (2n,) of the rows for an action h of each mode."""
        return np.sqrt((np.abs(self.v) ** 2).sum(axis=1) * h)

    @property
    def rows(self) -> np.ndarray:
        """Matrix (modes, 2n) from phase points less the equilibrium to amplitudes (modes,)."""
        return swapped(self.v).conj().T * 1j

    def lines(self, k: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the integer vector (modes, d) of the largest line of each mode's amplitude on a torus, whose series
        has the vectors k (terms, d) and coefficients z (2n, terms).
        """
        moved = k.any(axis=1)
        terms = np.hstack([self.rows @ z[:, moved], self.rows @ z[:, moved].conj()])
        return np.vstack([k[moved], -k[moved]])[np.abs(terms).argmax(axis=1)]

    def actions(self, squares: np.ndarray) -> np.ndarray:
        """Return the mean of ``|a|^2/2`` (modes,) over points with mean squares (2n, 2n) about the equilibrium."""
        return np.einsum("ia,ab,ib->i", self.rows, squares, self.rows.conj()).real / 2


def swapped(rows: np.ndarray) -> np.ndarray:
    """Return S rows: momenta, then less the coordinates."""
    q, p = np.split(rows, 2)
    return np.concatenate([p, -q])


def modes_of(model: Any, way: str) -> NormalModes:
    """Return the normal modes of a model about its lowest minimum, slow ones last, or those of each coordinate."""
    system = current_system(model)
    n = system.n

    wells, values = minima(walled(potential_of(model), list(system.periods)), n)
    if not values.size or not np.isfinite(values[0]):
        raise ValueError("model must have a potential with a minimum, got one without: its tori need guess=")
    W = system.inverse_masses(np.ones((2 * n, 1)))[..., 0]
    K = -np.array([np.hstack(model.tangent_force(*wells[:, 0], *unit)) for unit in np.eye(n)])
    local = way == WAYS[1]
    if local:
        W = np.diag(np.diag(W))
        K = np.diag(np.diag(K))
    root = np.linalg.cholesky(W)
    squares, u = np.linalg.eigh(root.T @ (K + K.T) / 2 @ root)
    if not squares[0] > 0:
        raise ValueError("model must have a minimum with positive curvatures: at a flat one there are no modes")
    omega = np.sqrt(squares)
    u *= np.where(u[np.abs(u).argmax(axis=0), np.arange(n)] < 0, -1.0, 1.0)
    v = np.concatenate([root @ u / np.sqrt(omega), 1j * np.linalg.solve(root.T, u) * np.sqrt(omega)])
    order = np.abs(u).argmax(axis=0).argsort() if local else np.arange(n)[::-1]
    return NormalModes(np.concatenate([wells[:, 0], np.zeros(n)]), v[:, order], omega[order])
