"""Checks of numbers: each raises at once, naming the argument, what it got and what it takes (layer L0)."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def positive(name: str, value: Any) -> float:
    """Return `value` as a finite float above 0."""
    number = real(name, value)
    if not number > 0.0:
        raise ValueError(f"{name} must be positive, got {value!r}")
    return number


def real(name: str, value: Any) -> float:
    """Return `value` as a finite float."""
    if isinstance(value, (bool, np.bool_, str, bytes, complex)) or np.ndim(value) != 0:
        raise TypeError(f"{name} must be a real number, got {value!r} ({type(value).__name__})")
    try:
        number = float(value)
    except OverflowError:
        raise ValueError(f"{name} must be within the range of floats") from None
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a real number, got {value!r} ({type(value).__name__})") from None
    if not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {value!r}")
    return number


def whole(name: str, value: Any, least: int) -> int:
    """Return `value` as an int of at least `least`."""
    try:
        if isinstance(value, bool):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, got {value!r} ({type(value).__name__})") from None
    if number < least:
        raise ValueError(f"{name} must be at least {least}, got {number}")
    return number


def whole_numbers(name: str, value: ArrayLike) -> np.ndarray:
    """Return whole numbers as an array of integers; whole floats are converted, all else and an empty array refused."""
    numbers = np.asarray(value)
    if numbers.dtype.kind not in "iuf" or numbers.size == 0:
        raise TypeError(f"{name} must be whole numbers, got {value!r}")
    if not np.all(np.abs(numbers) < 2.0**53) or np.any(numbers != np.round(numbers)):
        raise ValueError(f"{name} must be whole numbers, got {value!r}")
    return numbers.astype(np.int64)
