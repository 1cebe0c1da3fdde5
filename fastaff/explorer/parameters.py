"""The parameters of a model and of the values inside of it, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def parameter_values(model: Any) -> dict[str, float]:
    """Return the parameters of a model, those of inner values too, by name."""
    return dict(numbers_in(model, ()))


def with_parameters(model: Any, values: Mapping[str, float], path: tuple[str, ...] = ()) -> Any:
    """Return a model with other values of its parameters, by the names of `parameter_values`; others are left out."""
    changed: dict[str, Any] = {}
    for name in fields_of(model):
        entry = getattr(model, name)
        if isinstance(entry, (int, float, np.floating, np.integer)) and not isinstance(entry, bool):
            key = parameter_name((*path, name))
            changed[name] = float(values[key]) if key in values else entry
        elif fields_of(entry):
            changed[name] = with_parameters(entry, values, (*path, name))
    return model._replace(**changed) if hasattr(model, "_replace") else model


def numbers_in(value: Any, path: tuple[str, ...]) -> list[tuple[str, float]]:
    """Return names and values of all numbers in the fields of a value."""
    found: list[tuple[str, float]] = []
    for name in fields_of(value):
        entry = getattr(value, name)
        if isinstance(entry, (int, float, np.floating, np.integer)) and not isinstance(entry, bool):
            found.append((parameter_name((*path, name)), float(entry)))
        elif fields_of(entry):
            found += numbers_in(entry, (*path, name))
    return found


def fields_of(value: Any) -> tuple[str, ...]:
    """Return the names of the fields of a value."""
    return tuple(getattr(value, "_fields", ()) or getattr(value, "__dataclass_fields__", ()))


def parameter_name(path: Sequence[str]) -> str:
    """Return the name of a parameter: that of its field, with the names of its path if they are needed."""
    inner = path[1:] if path[0] == "potential" and path[1:] != ("mu",) else path
    return "_".join(inner)
