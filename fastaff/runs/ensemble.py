"""Running orbits."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..core.status import Status
from ..engine.kernels.drive import Orbits
from ..systems.models.mechanics import System
from .checks import energy_drift
from .reaches import FARTHEST


@dataclass
class Ensemble:
    """Running orbits: all data that a run needs to go on where it stopped. Arrays over orbits.

    z (2n (1 + vectors), orbits) with tangent vectors: positions of the orbit and of each vector, then momenta likewise;
    energy at the start; kinetic: the largest kinetic energy so far, the scale of energy errors, which is independent
    of the zero of V; radius: the distance from the origin beyond which an orbit has escaped.
    """

    z: np.ndarray
    energy: np.ndarray
    kinetic: np.ndarray
    vectors: int = 0
    status: np.ndarray = field(init=False)
    count: np.ndarray = field(init=False)
    time: np.ndarray = field(init=False)
    ahead: np.ndarray = field(init=False)
    ticks: np.ndarray = field(init=False)
    radius: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        n = self.z.shape[1]
        self.status = np.zeros(n, np.int64)
        self.count = np.zeros(n, np.int64)
        self.ticks = np.zeros(n, np.int64)
        self.time = np.zeros(n)
        self.ahead = np.zeros(n)
        self.radius = np.full(n, FARTHEST)

    def of(self, orbits: Any) -> Ensemble:
        """Return some of the orbits as an ensemble of their own."""
        part = Ensemble(self.z[:, orbits], self.energy[orbits], self.kinetic[orbits], self.vectors)
        for name in ("status", "count", "time", "ahead", "ticks", "radius"):
            setattr(part, name, getattr(self, name)[orbits])
        return part

    def orbits(self, memory: np.ndarray, out: np.ndarray) -> Orbits:
        """Return the arrays of the orbits for kernels, with the memory and records of an observer."""
        places = self.z, self.time, self.count, self.ahead, self.ticks, self.kinetic, self.radius, self.status
        return Orbits(*places, memory, out)

    def take(self, orbits: Any, part: Ensemble) -> None:
        """Take over the state of `part` for the orbits of that index array or mask."""
        for name in ("z", "energy", "kinetic", "status", "count", "time", "ahead", "ticks", "radius"):
            getattr(self, name)[..., orbits] = getattr(part, name)

    @property
    def scale(self) -> np.ndarray:
        """The scale of energy errors: the largest kinetic energy seen; 1 for an orbit that rests."""
        return np.where(self.kinetic > 0, self.kinetic, 1.0)

    @property
    def points(self) -> np.ndarray:
        """The orbits' phase points (2n, orbits)."""
        return self.z if self.vectors == 0 else self.parts[:, 0].reshape(-1, self.z.shape[1])

    @property
    def parts(self) -> np.ndarray:
        """A view (2, 1 + vectors, n, orbits) of z: positions and momenta of the orbit and of its tangent vectors."""
        return self.z.reshape(2, 1 + self.vectors, -1, self.z.shape[1])

    @property
    def deviations(self) -> np.ndarray:
        """The tangent vectors (vectors, 2n, orbits)."""
        return self.parts[:, 1:].transpose(1, 0, 2, 3).reshape(self.vectors, -1, self.z.shape[1])


def energy_error(system: System, ensemble: Ensemble) -> np.ndarray:
    """Return |E - E0| of each orbit over the largest kinetic energy seen on it; inf where the energy has no value."""
    return energy_drift(system, ensemble.points, ensemble.energy, ensemble.scale)


def mark_drift(ensemble: Ensemble, error: np.ndarray, tolerance: float) -> None:
    """Give orbits whose energy error exceeds the tolerance the status ENERGY_DRIFT, unless they have another."""
    ensemble.status[(ensemble.status == Status.OK) & (error > tolerance)] = Status.ENERGY_DRIFT


def no_memory(ensemble: Ensemble) -> tuple[np.ndarray, np.ndarray]:
    """Return the memory and output arrays of an observer that keeps nothing."""
    return np.zeros((1, ensemble.z.shape[1])), np.zeros((1, 1))
