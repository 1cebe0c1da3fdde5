"""Orbits and phase points of gala, in kpc, Myr and solar masses, or without units as they are; its potentials."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.foreign import Foreign, ForeignSystem
from .gala_potentials import CUSPED, children, formula_of, has_units, left_out, origin
from .quantities import plain
from .quantities import units as units_of
from .sums import apart_from, check, parts_of, summed, trial_points


def units(given: Any) -> dict[str, str] | None:
    """Return the units of positions that are Quantities; None if they have none."""
    return units_of(_cartesian(given).pos.xyz) if hasattr(given, "pos") else None


def orbits(orbit: Any, name: str, _: Any) -> Foreign:
    """Return the samples of an Orbit in Cartesian coordinates, velocities as momenta."""
    if getattr(orbit, "t", None) is None:
        run = ": fa.integrate(fa.hamiltonian(potential), z0, ...)" if hasattr(orbit, "energy") else ""
        raise TypeError(f"{name} must be a gala Orbit with its times, got {type(orbit).__name__}{run}")
    rows = _phase_points(orbit)
    n = orbit.ndim
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


def system(given: Any) -> ForeignSystem:
    """Return the formula of a potential that gala has in symbols, a sum of these, or a Hamiltonian with one."""
    frame = getattr(given, "frame", None)
    potential = getattr(given, "potential", given)
    if not hasattr(potential, "to_sympy"):
        raise TypeError(f"text must be a gala potential or Hamiltonian, got {type(given).__name__}")
    dims = "xyz"[: potential.ndim]
    parts = parts_of(potential, children)
    text, parameters = summed({key: formula_of(part, dims) for key, part in parts.items()})
    cusps = [origin(part) for part in parts.values() if type(part).__name__ in CUSPED]
    rotation = None
    if frame is not None and "Omega" in frame.parameters:
        rates = np.atleast_1d(plain(frame.parameters["Omega"]))
        if rates[:-1].any():
            raise ValueError(f"text: a frame must turn about z, this one has Omega = {rates}")
        rotation = float(rates[-1])
    points = trial_points(len(dims))
    at = points * potential.units["length"] if has_units(potential) else points
    check(text, dims, parameters, plain(at), plain(potential.energy(at)), left_out(parts))
    return ForeignSystem(
        text=text,
        coordinates=tuple(dims),
        parameters=parameters,
        domain=apart_from(cusps, dims),
        rotation=rotation,
    )
