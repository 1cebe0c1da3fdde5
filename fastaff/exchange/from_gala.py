"""Orbits and phase points of gala, in kpc, Myr and solar masses, or without units as they are; its potentials."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import Foreign
from .gala_potentials import system as system
from .quantities import plain
from .quantities import units as units_of


def units(given: Any) -> dict[str, str] | None:
    """Return the units of positions that are Quantities; None if they have none."""
    return units_of(_cartesian(given).pos.xyz) if hasattr(given, "pos") else None


def orbits(orbit: Any, name: str, _: Any) -> Foreign:
    """Return the samples of an Orbit in Cartesian coordinates, velocities as momenta."""
    if getattr(orbit, "t", None) is None:
        run = ": fa.integrate(fa.hamiltonian(potential), z0, ...)" if hasattr(orbit, "energy") else ""
        raise TypeError(f"{name} must be a gala Orbit with its times, got {type(orbit).__name__}{run}")
    rows, n = _phase_points(orbit), orbit.ndim
    samples = rows[:, None] if rows.ndim == 2 else rows.transpose(0, 2, 1)
    return Foreign(samples, plain(orbit.t), (*"xyz"[:n], *(f"v_{entry}" for entry in "xyz"[:n])))


def starts(point: Any, name: str) -> np.ndarray:
    """Return the phase points (2n,) or (2n, orbits) of a PhaseSpacePosition."""
    if not hasattr(point, "pos"):
        raise TypeError(f"{name} must be a PhaseSpacePosition of gala, got {type(point).__name__}")
    if getattr(point, "t", None) is not None:
        raise TypeError(f"{name} must be phase points: of a gala Orbit give one, such as orbit[0]")
    return _phase_points(point)


def _phase_points(point: Any) -> np.ndarray:
    point = _cartesian(point)
    return np.array([plain(part) for part in (*point.pos.xyz, *point.vel.d_xyz)])


def _cartesian(point: Any) -> Any:
    return point if hasattr(point.pos, "xyz") else point.represent_as("cartesian")
