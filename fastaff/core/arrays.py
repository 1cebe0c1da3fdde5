"""Checks of arrays for charts and matrices: finite real rows; errors name the argument and the orbit at fault."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .numbers import an_array, shown

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def checked(name: str, value: Any, leading: tuple[int, ...]) -> Array:
    """Return `value` as floats of shape (*leading, ...); raise ValueError or TypeError that names the fault."""
    shape = f" of shape ({', '.join([*map(str, leading), '...'])})" if leading else ""
    takes = f"{name} must be finite real numbers{shape}"
    try:
        array = an_array(name, value)
    except ValueError:
        raise ValueError(f"{takes}, got {shown(value)}") from None
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{takes}, got {type(value).__name__} of {array.dtype}")
    if array.shape[: len(leading)] != leading:
        raise ValueError(f"{takes}, got shape {array.shape}")
    array = array.astype(np.float64, copy=False)
    if not np.isfinite(array).all():
        index = first(~np.isfinite(array))
        place = f" at index {index}" if index else ""
        hint = ". Leave out orbits that have failed." if array.ndim > len(leading) else "."
        raise ValueError(f"{takes}, got {array[index]}{place}{hint}")
    return array


def first(bad: Mask) -> tuple[int, ...]:
    """Return the index of the first True."""
    return tuple(int(i) for i in np.argwhere(bad)[0])


def at_orbit(index: tuple[int, ...]) -> str:
    """Return ' at orbit (...)', or nothing for a single phase point."""
    return f" at orbit {index}" if index else ""
