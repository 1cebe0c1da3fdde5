"""Items of a result that an index selects, and the names and axes of its fields."""

from __future__ import annotations

import dataclasses
import functools
import operator
import re
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np

from ..core.numbers import an_array, shown
from .axes import Axes, declared


def field_names(result: Any) -> list[str]:
    """Return the names of the fields of a result, or of another dataclass."""
    return [field.name for field in dataclasses.fields(result)]


def axes_of(result: Any, name: str) -> Axes | None:
    """Return the axes that a result declares for one of its arrays."""
    return declared(cast(Any, type(result))).get(name)


def rows_of(result: Any) -> dict[str, Callable[[], np.ndarray]]:
    """Return functions that give the labelled rows of arrays, by name."""
    found: dict[str, Callable[[], np.ndarray]] = {}
    for field in dataclasses.fields(result):
        axes = axes_of(result, field.name)
        value = getattr(result, field.name)
        if axes is None or not axes.labels or not isinstance(value, np.ndarray):
            continue
        for k, label in enumerate(getattr(result, axes.labels)):
            entry = functools.partial(value.__getitem__, k)
            found.setdefault(f"{field.name}_{label}", entry)
            if axes.plain:
                found.setdefault(label, entry)
    return found


def index_of(result: Any, items: Any) -> tuple:
    """Return an index of the axes over items; a single number becomes a slice, so that every axis stays."""
    shape = result.item_shape
    if not shape:
        raise TypeError(f"{type(result).__name__} of a single {result.axis} has no items to take")
    given = items if isinstance(items, tuple) else (items,)
    found: list[Any] = []
    used = 0
    for entry in given:
        size = shape[used] if used < len(shape) else 0
        if used >= len(shape):
            raise ValueError(f"items must be an index of {len(shape)} axes, got {shown(items)}")
        if isinstance(entry, slice):
            found.append(entry)
        elif isinstance(entry, (int, np.integer)) and not isinstance(entry, bool):
            k = operator.index(entry)
            if not -size <= k < size:
                raise ValueError(f"items must be numbers of {size} {result.axis}s, got {k}")
            found.append(slice(k % size, k % size + 1))
        else:
            found.append(_chosen(result, entry, shape[used:]))
            used += found[-1].ndim - 1 if found[-1].dtype == bool else 0
        used += 1
    return tuple(found)


def _chosen(result: Any, entry: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return numbers of items or a mask of them as an array."""
    array = np.asarray(an_array("items", entry))
    if not array.size and array.dtype.kind == "f":
        array = array.astype(np.int64)
    if array.dtype == bool and array.ndim and array.shape == shape[: array.ndim]:
        return array
    if array.dtype.kind in "iu" and array.ndim == 1:
        if np.all((array >= -shape[0]) & (array < shape[0])):
            return array
        raise ValueError(f"items must be numbers of {shape[0]} {result.axis}s, got {shown(entry)}")
    raise ValueError(f"items must be numbers of {shape[0]} {result.axis}s, a slice or a mask, got {shown(entry)}")


def alike(one: Any, other: Any) -> bool:
    """Tell whether two settings are the same, NaN where NaN is."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.shape == other.shape and np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
    if type(one) is not type(other):
        return False
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, Mapping):
        return list(one) == list(other) and all(alike(one[key], other[key]) for key in one)
    if dataclasses.is_dataclass(one):
        return all(alike(getattr(one, name), getattr(other, name)) for name in field_names(one))
    return bool(one == other) or (one != one and other != other)


def dims_of(result: Any, name: str, value: np.ndarray) -> tuple[str, ...]:
    """Return the names of an array's axes; where items have several axes these are numbered."""
    axes = axes_of(result, name)
    if axes is None:
        return tuple(f"{name}_{k + 1}" for k in range(value.ndim))
    repeated = axes.names.index(result.axis) if result.axis in axes.names else len(axes.names) - 1
    extra = value.ndim - len(axes.names)
    item = axes.names[repeated]
    if extra < 0:
        return tuple(axes.names[:repeated] + axes.names[repeated + 1 :])[: value.ndim]
    several = (item, *(f"{item}_{k + 2}" for k in range(extra)))
    return (*axes.names[:repeated], *several, *axes.names[repeated + 1 :])


def in_units(word: str, named: Mapping[str, str]) -> str:
    """Return a unit such as cycles/time with its words replaced as `named` says; a text of several words as it is."""
    return word if " " in word else re.sub(r"[a-z]+", lambda found: named.get(found[0], found[0]), word)
