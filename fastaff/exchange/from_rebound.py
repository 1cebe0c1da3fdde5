"""Orbits of the bodies of a REBOUND archive, in its own units."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.foreign import Foreign
from ..core.numbers import fits

NAMES = ("x", "y", "z", "v_x", "v_y", "v_z")


def orbits(archive: Any, name: str, _: Any) -> Foreign:
    """Return positions and velocities of all bodies of a Simulationarchive, one orbit for each, in their order."""
    if not hasattr(archive, "getSimulation"):
        raise TypeError(
            f"{name} must be a rebound.Simulationarchive, got {type(archive).__name__}. Use "
            "simulation.save_to_file(path, step=...)."
        )
    bodies = archive[0].N
    count = len(archive)
    fits(name, 6, bodies, count)
    array = np.empty((6, bodies, count))
    times = np.empty(count)
    place, velocity = np.empty((2, bodies, 3))
    for k, simulation in enumerate(archive):
        if bodies != simulation.N:
            raise ValueError(
                f"{name} must have the same bodies throughout, got {bodies} at first and {simulation.N} at {k}"
            )
        simulation.serialize_particle_data(xyz=place, vxvyvz=velocity)
        array[:3, :, k] = place.T
        array[3:, :, k] = velocity.T
        times[k] = simulation.t
    return Foreign(array, times, NAMES)


def starts(simulation: Any, name: str) -> np.ndarray:
    """Refuse a Simulation, whose bodies move in the forces of one another."""
    raise TypeError(
        f"{name} must be phase points of the system, got {type(simulation).__name__} of REBOUND. Use [*particle.xyz, "
        "*particle.vxyz] of a body."
    )
