"""Monitors, particles and lines of xtrack."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import Foreign
from .kicks import ROWS, Kick, turn
from .linear_parts import compared, kept_momentum, probed


def orbits(monitor: Any, name: str, coordinates: tuple[str, ...] | None) -> Foreign:
    """Return the records of a monitor, turn by turn: x, y, px, py, or the rows of `coordinates`."""
    names = ROWS if coordinates is None else coordinates
    missing = [entry for entry in names if not hasattr(monitor, entry)]
    if missing or not hasattr(monitor, "at_turn"):
        said = f"has no {missing[0]}" if missing else "records no turns"
        if hasattr(monitor, "element_dict"):
            said += ": give line.record_last_track, after line.track(..., turn_by_turn_monitor=True)"
        raise TypeError(f"{name} must be a monitor of xtrack; this {type(monitor).__name__} {said}")
    arrays = [np.asarray(getattr(monitor, entry), dtype=float) for entry in names]
    if arrays[0].ndim != 2:
        raise TypeError(
            f"{name} must be a monitor of xtrack with (particles, turns), as of line.track(..., "
            f"turn_by_turn_monitor=True), got {type(monitor).__name__} of shape {arrays[0].shape}"
        )
    return Foreign(np.array(arrays), None, tuple(names))


def starts(particles: Any, name: str) -> np.ndarray:
    """Return the phase points x, y, px, py (4, particles) of Particles that are alive."""
    if not all(hasattr(particles, entry) for entry in (*ROWS, "state")):
        raise TypeError(f"{name} must be Particles of xtrack, got {type(particles).__name__}")
    alive = np.asarray(particles.state) > 0
    return np.array([np.asarray(getattr(particles, entry))[alive] for entry in ROWS], dtype=float)


CUT = "line.slice_thick_elements(...)"
"""The call that makes thin kicks of thick elements."""

TAKEN_LINEAR = ("Bend", "RBend", "DipoleEdge", "Solenoid", "UniformSolenoid")
"""Elements whose linear part is taken."""


def lattice(line: Any) -> str:
    """Return the map of one turn of a Line, on momentum, as a text."""
    if not hasattr(line, "element_dict") or getattr(line, "particle_ref", None) is None:
        raise TypeError(f"text must be a Line of xtrack with its particle_ref, got {type(line).__name__}")
    if not line._has_valid_tracker():
        line.build_tracker()
    return turn(_part(line, k, name) for k, name in enumerate(line.element_names))


def _part(line: Any, k: int, name: str) -> Any:
    """Return an element as a kick or a linear part; a ValueError names one that is neither."""
    element = line.element_dict[name]
    kind = type(element).__name__
    whole = getattr(element, "parent_name", name)
    kept_momentum(not getattr(line.element_dict[whole], "voltage", 0.0), name, kind, f"line[{whole!r}].voltage = 0")

    def track(points: np.ndarray) -> np.ndarray:
        particles = line.build_particles(**dict(zip(("x", "y", "px", "py"), points, strict=True)), mode="set")
        line.track(particles, ele_start=k, num_elements=1)
        particles.sort(interleave_lost_particles=True)
        lost = np.asarray(particles.state) < 1
        return np.where(lost, np.nan, np.array([getattr(particles, row) for row in ("x", "y", "px", "py")]))

    thin = element.get_equivalent_element() if kind.startswith("ThinSlice") else element
    if type(thin).__name__ == "Multipole" and not np.any(thin.hxl) and not getattr(thin, "isthick", False):
        kick = Kick(tuple(thin.knl), tuple(thin.ksl))
        axis = [float(getattr(thin, entry, 0.0)) for entry in ("shift_x", "shift_y", "rot_s_rad")]
        return compared(kick.moved(*axis) if any(axis) else kick, track, name, kind)
    return probed(track, name, kind, kind in TAKEN_LINEAR, CUT)
