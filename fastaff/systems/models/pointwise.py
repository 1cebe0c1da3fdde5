"""Values of the methods of models at many points, from Python."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.numbers import reason

FAILS = (TypeError, ValueError, AttributeError, ArithmeticError)
"""Errors of methods that take no arrays, or have no value at a point."""


def at_points(model: Any, method: str, *rows: Any) -> Any:
    """Return the values of a model's method at rows of numbers or arrays; one point at a time if it takes no arrays, as
    one with an `if`.
    """
    try:
        return getattr(model, method)(*rows)
    except FAILS as problem:
        return _one_by_one(model, method, rows, problem)


def _one_by_one(model: Any, method: str, rows: Sequence[Any], problem: Exception) -> Any:
    """Return the values of a method at each point, NaN where it has none; `problem`: its error at all points at once.

    Raises TypeError that names class and method where it gives numbers at no point.
    """
    arrays = np.broadcast_arrays(*rows) if rows else []
    shape = arrays[0].shape if arrays else ()
    found: list[Any] = []
    for point in zip(*(array.ravel().tolist() for array in arrays)) if shape else ():
        try:
            found.append(getattr(model, method)(*point))
        except (ValueError, ArithmeticError) as fault:  # outside of its domain
            found.append(None)
            problem = fault
        except (TypeError, AttributeError) as fault:
            found = []
            problem = fault
            break
    first = next((entry for entry in found if entry is not None), None)
    if first is None:
        raise TypeError(f"{type(model).__name__}.{method} does not give numbers ({reason(problem)})") from None
    several = isinstance(first, (tuple, list))
    nothing = [np.nan] * len(first) if several else np.nan
    values = np.array([nothing if entry is None else entry for entry in found], dtype=np.float64)
    return tuple(values.T.reshape(-1, *shape)) if several else values.reshape(shape)
