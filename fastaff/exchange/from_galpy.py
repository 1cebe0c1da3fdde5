"""Orbits of galpy in its natural units: lengths in ro, velocities in vo, times in ro/vo; its potentials."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.foreign import Foreign, ForeignSystem
from .galpy_potentials import CUSPED, formula_of
from .sums import apart_from, check, parts_of, summed, trial_points


def orbits(orbit: Any, name: str, _: Any) -> Foreign:
    """Return the samples of an integrated Orbit: x, y, z and velocities where its azimuth is known, else R, z."""
    if not hasattr(orbit, "orbit"):
        raise ValueError(f"{name} must be an integrated Orbit of galpy: orbit.integrate(times, potential)")
    if np.ndim(orbit.t) != 1:
        raise ValueError(f"{name} must be orbits at the same times")
    path = np.asarray(orbit.orbit, dtype=float)
    rows, names = _cartesian(np.moveaxis(path.reshape(-1, *path.shape[-2:]), -1, 0))
    return Foreign(rows, np.asarray(orbit.t, dtype=float), names)


def starts(orbit: Any, name: str) -> np.ndarray:
    """Return the initial phase points (2n,) or (2n, orbits) of an Orbit."""
    if not hasattr(orbit, "vxvv"):
        raise TypeError(f"{name} must be an Orbit of galpy, got {type(orbit).__name__}")
    z = _cartesian(np.asarray(orbit.vxvv, dtype=float).reshape(-1, orbit.phasedim()).T)[0]
    return z if orbit.shape else z[:, 0]


def _cartesian(z: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return rows q, p and their names of galpy's rows R, vR, vT, z, vz, phi, or those of fewer dimensions."""
    rows = len(z)
    if rows in (2, 3):  # a coordinate and its velocity, or R, vR, vT
        return z[:2], ("x", "v_x") if rows == 2 else ("R", "v_R")
    if rows == 5:
        return z[[0, 3, 1, 4]], ("R", "z", "v_R", "v_z")
    R = z[0]
    vR = z[1]
    vT = z[2]
    phi = z[-1]
    cos, sin = np.cos(phi), np.sin(phi)
    q = [R * cos, R * sin]
    v = [vR * cos - vT * sin, vR * sin + vT * cos]
    if rows == 6:
        q = [*q, z[3]]
        v = [*v, z[4]]
    names = "xyz"[: len(q)]
    return np.array([*q, *v]), (*names, *(f"v_{entry}" for entry in names))


def system(potential: Any) -> ForeignSystem:
    """Return the formula of a potential of `galpy_potentials.FORMULAS`, or of a sum or list of them."""
    every = potential if isinstance(potential, list) else [potential]
    for entry in every:
        if not hasattr(entry, "dim") or callable(entry.dim) or entry.dim != every[0].dim:
            raise TypeError(f"text must be a potential of galpy, or some of one dimension, got {type(entry).__name__}")
    dims = "xyz"[: every[0].dim]
    parts = parts_of(potential, _children)
    text, parameters = summed({key: formula_of(part, dims) for key, part in parts.items()})
    cusp = [(0.0,) * len(dims)] * any(type(part).__name__ in CUSPED for part in parts.values())
    points = trial_points(len(dims))
    R = np.hypot(*points[:2])
    phi = np.arctan2(points[1], points[0])
    place = (R, points[2]) if len(dims) == 3 else (R,)
    energies = [sum(entry(*at, phi=angle, use_physical=False) for entry in every) for *at, angle in zip(*place, phi)]
    check(text, dims, parameters, points, np.array(energies, dtype=float))
    return ForeignSystem(
        text=text,
        coordinates=tuple(dims),
        parameters=parameters,
        domain=apart_from(cusp, dims),
    )


def _children(potential: Any) -> Any:
    listed = potential if isinstance(potential, list) else getattr(potential, "_potlist", None)
    return None if listed is None else enumerate(listed, 1)
