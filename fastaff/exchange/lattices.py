"""Monitors and particles of xtrack."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import Foreign

ROWS = ("x", "y", "px", "py")


def orbits(monitor: Any, name: str, coordinates: tuple[str, ...] | None) -> Foreign:
    """Return what a monitor has recorded, turn by turn: x, y, px, py, or the rows of `coordinates`."""
    names = ROWS if coordinates is None else coordinates
    missing = [entry for entry in names if not hasattr(monitor, entry)]
    if missing or not hasattr(monitor, "at_turn"):
        said = f"has no {missing[0]}" if missing else "records no turns"
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
