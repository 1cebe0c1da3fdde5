"""Rotations in a model of a page: the loops that give frequencies, and coordinates that are angles."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..systems.models.angles import AreaTrace, Coordinates2, RVartheta
from ..systems.models.mechanics import System


def loops_of(system: System) -> Any:
    """Return the angles whose loops give frequencies: the model's own if a page has them, else plain ones."""
    angles = getattr(system.model, "angles", None)
    if angles is not None and hasattr(angles, "signals") and not isinstance(angles, RVartheta):
        return angles
    return AreaTrace() if system.isotropic else Coordinates2()


def turns_around(model: Any) -> bool:
    """Tell whether the force of a driven system of one coordinate is that of an angle: the same 2 pi farther on."""
    x = np.linspace(-2.9, 2.7, 29)
    t = model.period * np.linspace(0, 1, 29) ** 2
    with np.errstate(all="ignore"):
        here, there = (np.broadcast_to(model.force(x + turn, t)[0], x.shape) for turn in (0.0, 2 * np.pi))
        return bool(np.ptp(here) > 0 and np.abs(here - there).max() <= 1e-12 * np.abs(here).max())
