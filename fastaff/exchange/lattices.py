"""Monitors, particles and lines of xtrack."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.foreign import Foreign
from .kicks import ROWS, Kick, turn
from .linear_parts import compared, higher, kept_momentum, probed, told


def orbits(monitor: Any, name: str, coordinates: tuple[str, ...] | None) -> Foreign:
    """Return the records of a monitor, turn by turn: x, y, px, py, or the rows of `coordinates`."""
    names = ROWS if coordinates is None else coordinates
    missing = [entry for entry in names if not hasattr(monitor, entry)]
    if missing or not hasattr(monitor, "at_turn"):
        said = f"has no {missing[0]}" if missing else "records no turns"
        if hasattr(monitor, "element_dict"):
            said += ": give line.record_last_track, after line.track(..., turn_by_turn_monitor=True)"
        raise TypeError(f"{name} must be a monitor of xtrack; this {type(monitor).__name__} {said}")
    array = np.array([getattr(monitor, entry) for entry in names], dtype=float)
    if array.ndim != 3:
        said = f"turn_by_turn_monitor=True), got {type(monitor).__name__} of shape {array.shape[1:]}"
        raise TypeError(f"{name} must be a monitor of xtrack with (particles, turns), as of line.track(..., {said}")
    return Foreign(array, None, tuple(names))


def starts(particles: Any, name: str) -> np.ndarray:
    """Return the phase points x, y, px, py (4, particles) of Particles that are alive."""
    if not all(hasattr(particles, entry) for entry in (*ROWS, "state")):
        raise TypeError(f"{name} must be Particles of xtrack, got {type(particles).__name__}")
    alive = np.asarray(particles.state) > 0
    return np.array([np.asarray(getattr(particles, entry))[alive] for entry in ROWS], dtype=float)


CUT = "cut it into thin kicks first, line.slice_thick_elements(...)"
TAKEN_LINEAR = ("Bend", "RBend", "DipoleEdge", "Solenoid", "UniformSolenoid")
"""Elements whose linear part is taken, and those cut of them."""


def lattice(line: Any) -> str:
    """Return the map of one turn of a Line, on momentum, as a text."""
    if getattr(line, "particle_ref", None) is None or not hasattr(line, "element_dict"):
        raise TypeError(f"text must be a Line of xtrack with its particle_ref, got {type(line).__name__}")
    if not line._has_valid_tracker():
        line.build_tracker()
    limits = told([name for name in line.element_names if "Limit" in type(line.element_dict[name]).__name__])
    return turn(p for k, name in enumerate(line.element_names) if name not in limits for p in _parts(line, k, name))


def _parts(line: Any, k: int, name: str) -> list[Any]:
    """Return kicks and linear parts of an element; a ValueError names one that has others."""
    element = line.element_dict[name]
    kind = type(element).__name__
    whole = getattr(element, "parent_name", name)
    parent = line.element_dict[whole]
    off = f"take it off, line.remove({name!r})"
    volts = [f"line[{whole!r}].{entry} = 0" for entry in ("voltage", "crab_voltage") if getattr(parent, entry, 0.0)]

    def track(points: np.ndarray) -> np.ndarray:
        particles = line.build_particles(**dict(zip(ROWS, points, strict=True)), zeta=0.01, mode="set")
        line.track(particles, ele_start=k, num_elements=1)
        particles.sort(interleave_lost_particles=True)
        kept_momentum(not np.any(particles.delta), name, kind, *volts or [off])
        return np.where(np.asarray(particles.state) < 1, np.nan, [getattr(particles, row) for row in ROWS])

    thin = element.get_equivalent_element() if hasattr(element, "get_equivalent_element") else element
    linear = type(parent).__name__ in TAKEN_LINEAR
    thick = getattr(element, "isthick", False) and "Drift" not in kind
    if thick or type(thin).__name__ != "Multipole":
        return [probed(track, name, kind, linear, CUT if thick else off, higher(parent) if linear and thick else ())]
    axis = [float(getattr(thin, entry, 0.0)) for entry in ("shift_x", "shift_y", "rot_s_rad")]
    strengths = np.array([thin.knl, thin.ksl])
    if not np.any(thin.hxl):
        return [compared(Kick(*strengths).moved(*axis), track, name, kind)]
    linear = linear and bool(np.any(strengths[:, 1:2])) and not any(axis)
    strengths[:, :2] = 0
    kick, back = (Kick(*part).moved(*axis) for part in (strengths, -strengths))
    off = "take off shifts and turns, and the gradient of one that is no bend cut into kicks, or set hxl = 0"
    return [probed(lambda points: back.images(track(points)), name, kind, linear, off), kick]
