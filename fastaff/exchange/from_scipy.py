"""Results of SciPy's solve_ivp."""

from __future__ import annotations

from typing import Any

from ..core.foreign import Foreign


def orbits(found: Any, name: str, coordinates: tuple[str, ...] | None) -> Foreign | None:
    """Return the orbit of a result, rows y at times t; None for other values."""
    return Foreign(found.y, found.t, coordinates) if hasattr(found, "y") and hasattr(found, "t") else None
