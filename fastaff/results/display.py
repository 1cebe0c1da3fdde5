"""Display of a result at a prompt: one line for each of its fields, no pages of numbers."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

WIDTH = 120
"""Columns of a line of a printed result."""

SMALL = 6
"""Most numbers of an array that is shown whole; larger ones are shown as dtype and shape."""


def short(result: Any) -> str:
    """Return the class of a result and its `summary()` where it has one: the first line of its display."""
    said = result.summary() if hasattr(result, "summary") else ""
    return _cut(f"{type(result).__name__}: {said}" if said else type(result).__name__, 2 * WIDTH)


def screen(result: Any) -> str:
    """Return the printed form of a result: the line of `short` and one for each field."""
    names = public_fields(result) if hasattr(result, "__dataclass_fields__") else result._fields
    width = max(map(len, names), default=0)
    lines = [f"  {name:<{width}}  {_cut(brief(getattr(result, name)), WIDTH - width - 4)}" for name in names]
    return "\n".join([short(result), *lines])


def public_fields(result: Any) -> list[str]:
    """Return the names of the fields of a dataclass that a person sees."""
    return [field.name for field in dataclasses.fields(result) if field.repr and not field.name.startswith("_")]


def brief(value: Any) -> str:
    """Return a value in one line: arrays by dtype and shape, results within a result by their first line."""
    if isinstance(value, np.ndarray):
        if value.ndim > 1 or value.size > SMALL:
            return f"{value.dtype} {value.shape}"
        return np.array2string(value, separator=", ", precision=12).replace("\n", " ")
    if type(value) in (tuple, list):
        shown = ", ".join(map(brief, value[:SMALL])) + (f", ... {len(value)} in all" if len(value) > SMALL else "")
        return f"({shown}{',' * (len(value) == 1)})" if isinstance(value, tuple) else f"[{shown}]"
    if isinstance(value, np.generic):
        value = value.item()
    return repr(value).partition("\n")[0]


def _cut(text: str, length: int) -> str:
    return text if len(text) <= length else text[: length - 4] + " ..."
