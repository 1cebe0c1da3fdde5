"""Angles of orbits in figures: winding angles are drawn within one period about 0."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.interruption import imported
from ..runs.requirements import current_system


def argument_of(found: Any, name: str) -> Any:
    """Return an argument of the call that made a result, None where that is not known."""
    call: Any = getattr(found, "call", None)
    try:
        return imported("..exchange.files", __package__).decoded(name, call.arguments[name], {})
    except (AttributeError, KeyError, ValueError):
        return None


def around_zero(found: Any, name: str, values: np.ndarray) -> np.ndarray:
    """Return the values (..., orbits) of a coordinate of a result, within half a period around 0 if it is an angle of
    its model that an orbit winds around.
    """
    model = argument_of(found, "model") if name in found.names else None
    row = found.names.index(name) if model is not None else 0
    periods = current_system(model).periods if model is not None else ()
    period = periods[row] if row < len(periods) else 0.0
    with np.errstate(all="ignore"):
        winds = period > 0 and np.nanmax(np.abs(values), initial=0.0) > period
    return values - period * np.rint(values / period) if winds else values


def broken(u: np.ndarray, v: np.ndarray, plain: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, ...]:
    """Return a curve (moments,) of angles, with a gap at each jump by a period, and the number of each moment; `plain`
    is the same curve without jumps.
    """
    left, right = (
        np.abs(np.diff(a) - np.diff(b)) > 0.5 * np.abs(np.diff(a)) for a, b in zip((u, v), plain, strict=True)
    )
    gaps = np.flatnonzero(left | right) + 1
    return np.insert(u, gaps, np.nan), np.insert(v, gaps, np.nan), np.insert(np.arange(len(u)), gaps, gaps)
