"""Wave functions of vibrations: levels of a uniform grid as functions of the coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import checked
from ...core.names import named
from ...core.numbers import text
from ...results.display import screen
from ...results.result import Drawable
from ...systems.models.contracts import Dynamics
from .modes import WAYS, modes_of

CHUNK = 1 << 21
"""Numbers of the largest table at once."""


@dataclass(frozen=True)
class PointLattice:
    """Points q = R (step (low + i) + origin) of i (d, 1), with the names of the coordinates; u = R^-1 q, with some
    periodic axes: shape (d,), whole numbers low (d,), step (d,), origin (d,), around (d,), R (d, d).
    """

    names: tuple[str, ...]
    shape: tuple[int, ...]
    low: np.ndarray
    step: np.ndarray
    origin: np.ndarray
    around: np.ndarray
    R: np.ndarray

    def axis(self, k: int) -> np.ndarray:
        """Return u (points,) along an axis."""
        return (self.low[k] + np.arange(self.shape[k])) * self.step[k] + self.origin[k]

    def points(self, index: np.ndarray) -> np.ndarray:
        """Return q (d, points) at flat indices of the lattice."""
        places = np.unravel_index(index, self.shape)
        return self.R @ np.array([self.axis(k)[place] for k, place in enumerate(places)])

    def away(self, index: np.ndarray, centre: np.ndarray) -> np.ndarray:
        """Return q - centre (d, points) at flat indices, of angles the shorter way around."""
        u = np.linalg.solve(self.R, self.points(index) - centre[:, None])
        turn = np.multiply(self.shape, self.step)[:, None]
        return self.R @ (u - np.where(self.around[:, None], turn * np.rint(u / turn), 0.0))

    def waves(self, k: int, u: np.ndarray) -> np.ndarray:
        """Return the waves (points, shape[k]) of an axis at u (points,): 1 at their own point, 0 at others."""
        apart = (u[:, None] - self.axis(k)) / self.step[k]
        if not self.around[k]:
            return np.sinc(apart)
        apart -= self.shape[k] * np.rint(apart / self.shape[k])
        return np.sinc(apart) / np.sinc(apart / self.shape[k])

    def slopes(self, k: int) -> np.ndarray:
        """Return d/du between the points of an axis, of waves that end or go around."""
        n = self.shape[k]
        apart = np.subtract.outer(np.arange(n), np.arange(n))
        same = apart == 0
        far = np.where(same, 1, apart)
        if self.around[k]:
            far = n / np.pi * np.sin(np.pi * far / n)
        return np.where(same, 0.0, (1.0 - 2.0 * (apart % 2)) / far) / self.step[k]


@dataclass(frozen=True, repr=False)
class LatticeWaves:
    """Wave functions of levels of a body: values (levels, kept) at the points of a lattice with flat indices kept."""

    model: Any
    lattice: PointLattice
    kept: np.ndarray
    values: np.ndarray

    def __repr__(self) -> str:
        return f"{len(self.values)} functions on {self.kept.size} points"

    def state(self, number: int, energy: float, hbar: float) -> VibrationState:
        """Return the state of a level."""
        return VibrationState(number, energy, hbar, self.model, self.lattice, self.kept, self.values[number])


@dataclass(frozen=True)
class VibrationState(Drawable):
    """Stationary state of a vibration, real and normalised: call it on coordinates.

    The argument q has the shape (n, ...).

    Attributes
    ----------
    number : int
        Number of the level, from 0.
    energy : float
        Energy.
    hbar : float
        Planck's constant over 2 pi.
    model : model
        The vibration.
    lattice : object
        Sample points.
    kept : ndarray of int, shape (points,)
        Flat indices of the sample points at which the state is not 0.
    values : ndarray, shape (points,)
        Values at these points; the sum of their squares is 1.
    """

    number: int
    energy: float
    hbar: float
    model: Dynamics
    lattice: PointLattice
    kept: np.ndarray
    values: np.ndarray

    def __repr__(self) -> str:
        return screen(self)

    def summary(self) -> str:
        """Return one line that names the state.

        Returns
        -------
        str
            The line.
        """
        return f"level {self.number}, E = {self.energy:.10g}, over {', '.join(self.lattice.names)}"

    @property
    def table(self) -> np.ndarray:
        """Values at all sample points, shape (n1, ...)."""
        full = np.zeros(int(np.prod(self.lattice.shape)))
        full[self.kept] = self.values
        return full.reshape(self.lattice.shape)

    def __call__(self, q: ArrayLike) -> np.ndarray:
        """Return Psi (...) at coordinates q (n, ...): ``|Psi|^2`` has the integral 1 over them. Beyond the lattice it
        is 0. Raises ValueError or TypeError for wrong input.
        """
        d = len(self.lattice.shape)
        places = checked("q", q, (d,))
        u = np.linalg.solve(self.lattice.R, places.reshape(d, -1))
        out = np.empty(u.shape[1])
        table = self.table
        size = abs(float(np.linalg.det(self.lattice.R))) * float(np.prod(self.lattice.step))
        part = max(1, CHUNK // max(1, table.size // self.lattice.shape[0]))
        for start in range(0, out.size, part):
            some = slice(start, start + part)
            left = np.tensordot(self.lattice.waves(0, u[0, some]), table, 1)
            for k in range(1, d):
                left = np.einsum("pi,pi...->p...", self.lattice.waves(k, u[k, some]), left)
            out[some] = left
        beyond = [
            ~self.lattice.around[k]
            & ((u[k] < axis[0] - self.lattice.step[k]) | (u[k] > axis[-1] + self.lattice.step[k]))
            for k, axis in enumerate(map(self.lattice.axis, range(d)))
        ]
        return np.where(np.any(beyond, axis=0), 0.0, out / np.sqrt(size)).reshape(places.shape[1:])[()]

    def density(self, q: ArrayLike) -> np.ndarray:
        """Return the probability density ``|Psi|^2``.

        Parameters
        ----------
        q : array_like, shape (n, ...)
            Coordinates.

        Returns
        -------
        ndarray, shape (...)
            Density.
        """
        return self(q) ** 2

    def moments(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return means and covariances of coordinates and momenta.

        Returns
        -------
        mean : ndarray, shape (n,)
            Means of q. For periodic coordinates they have no meaning.
        covariance : ndarray, shape (n, n)
            Covariance of q. For periodic coordinates it has no meaning.
        momentum_covariance : ndarray, shape (n, n)
            Covariance of p. The mean of p is 0.
        """
        lattice = self.lattice
        weights = self.values**2
        q = lattice.points(self.kept)
        mean = q @ weights
        away = q - mean[:, None]
        table = self.table
        rise = [np.moveaxis(np.tensordot(lattice.slopes(k), table, (1, k)), 0, k).ravel() for k in range(q.shape[0])]
        p = self.hbar * np.linalg.solve(lattice.R.T, np.array(rise))
        return mean, (away * weights) @ away.T, p @ p.T

    def quanta(self, modes: str = "normal") -> np.ndarray:
        """Return the mean numbers of quanta in the modes, about the lowest minimum.

        Parameters
        ----------
        modes : {"normal", "local"}, default "normal"
            Normal modes, the fastest first, or the mode of each coordinate.

        Returns
        -------
        ndarray, shape (n,)
            Means ``<(Q^2 + P^2)/(2 hbar)> - 1/2`` of each mode. Periodic coordinates are measured the shorter way
            around.

        Raises
        ------
        TypeError, ValueError
            If the modes are unknown or the minimum is flat.

        Notes
        -----
        Means near integers label the level. In a resonance, sums of them (polyads such as 2 n1 + n2 of a Fermi
        resonance) stay near integers if each is not.

        References
        ----------
        Kellman & Lynch 1986, J. Chem. Phys. 85, 7216 (polyads).
        """
        found = modes_of(self.model, named("modes", text("modes", modes), WAYS))
        p = self.moments()[2]
        away = self.lattice.away(self.kept, found.equilibrium[: len(p)])
        q = (away * self.values**2) @ away.T
        none = np.zeros_like(p)
        return found.actions(np.block([[q, none], [none, p]])) / self.hbar - 0.5
