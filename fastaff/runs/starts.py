"""Initial conditions of orbits: labelled arrays and tables are read by the names of their rows."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..core.foreign import dispatch_adapter
from ..core.numbers import numbers, shown
from ..systems.models.mechanics import System, system_of

COORDINATES = ("coordinate", "coordinates", "component", "components", "row", "rows", "variable", "variables")
ORBITS = (
    *("orbit", "orbits", "particle", "particles", "particle_id", "number", "star", "stars"),
    *("body", "bodies", "trajectory"),
)
"""Names of the dimensions of a labelled array that count rows and orbits."""

Orders = list[tuple[str, ...]]
"""Lists of the names that rows may have; the first is the whole one."""

LONGEST = 48
"""Characters of the labels that a message shows."""

UNNAMED = re.compile(r"dim_\d+|column_\d+")
"""Names that xarray gives to dimensions, and polars to columns, that have none."""


class Axis(NamedTuple):
    """An axis of a labelled array: its name, "" for none; its labels, None for none."""

    name: str
    labels: tuple[Any, ...] | None

    @property
    def texts(self) -> bool:
        """Whether some labels are names."""
        return any(isinstance(entry, str) for entry in self.labels or ())


def starts_of(value: Any, model: Any = None) -> Any:
    """Return the phase points of a grid or a sample of them, of a table or a labelled array, or of another tool;
    anything else as it is.
    """
    if (found := dispatch_adapter("starts", value, "z0")) is not None:
        return found
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = getattr(value, "z0", value)
    if not hasattr(model, "degrees_of_freedom"):
        return value  # which is refused later
    return in_rows("z0", value, system_of(model))


def in_rows(name: str, value: Any, system: System) -> Any:
    """Return the labelled phase points `value` as an array (2n, orbits) or (2n,) in the order of the model's rows;
    anything without labels as it is.
    """
    return ordered(name, value, lambda: orders_of(system))


def ordered(name: str, value: Any, orders: Callable[[], Orders]) -> Any:
    """Return labelled rows `value` as an array in the order of the names that `orders` gives, or of another of these
    lists of names; anything without labels as it is.

    Labels are those of xarray, pandas and polars. Rows are found by their names, along either axis; without names, by
    the name of the dimension; without both, as in an array. Raises ValueError for names that are not those of the rows,
    and wherever the order of the rows is unknown.
    """
    if isinstance(value, (list, tuple)):
        return numbers(name, value) if _entries_fit(name, value, orders) else value
    if isinstance(value, np.ndarray):
        return value
    if hasattr(value, "data_vars"):
        return _of_variables(name, value, orders())
    axes = _axes(name, value)
    if axes is None:
        return value
    row, places = _rows(name, axes, orders())
    array = np.moveaxis(numbers(name, value), row, 0)
    return array[list(places)] if places else array


def _axes(name: str, value: Any) -> list[Axis] | None:
    """Return the axes of a labelled array or a table; None for anything else."""
    dims = getattr(value, "dims", None)
    if isinstance(dims, tuple) and hasattr(value, "shape") and all(isinstance(entry, str) for entry in dims):
        coords = getattr(value, "coords", {})
        return [
            Axis("" if UNNAMED.fullmatch(entry) else entry, _labels(coords[entry]) if entry in coords else None)
            for entry in dims
        ]
    if hasattr(type(value), "collect") and hasattr(type(value), "columns"):
        raise TypeError(f"{name} must be a table with rows, got a {type(value).__name__}: give its .collect()")
    if hasattr(value, "column_names"):
        raise TypeError(f"{name} must be an array or a table of pandas or polars, got one of Arrow: give .to_pandas()")
    if hasattr(value, "iloc"):
        index = Axis("", _labels(value.index))
        return [index, Axis("", _labels(value.columns))] if hasattr(value, "columns") else [index]
    columns = getattr(value, "columns", None)
    if isinstance(columns, list) and all(isinstance(entry, str) for entry in columns):
        unnamed = all(UNNAMED.fullmatch(entry) for entry in columns)
        return [Axis("", None), Axis("", None if unnamed else tuple(columns))]
    return None


def _labels(index: Any) -> tuple[Any, ...]:
    """Return the labels of an index as plain numbers, texts or others."""
    return tuple(np.asarray(index, dtype=object).tolist())


def orders_of(system: System) -> Orders:
    """Return the names of the rows that phase points of a model may have: a driven one may leave out the time."""
    rows = system.row_names
    n = system.moving
    return [rows, (*rows[:n], *rows[n + 1 : -1])] if system.driven else [rows]


def _rows(name: str, axes: list[Axis], orders: Orders) -> tuple[int, tuple[int, ...]]:
    """Return which axis has the rows, and their places along it in the model's order, () where they stand in it."""
    named = [k for k, axis in enumerate(axes) if any(_places(axis, order) for order in orders)]
    if len(named) > 1:
        raise ValueError(f"{name} must have the names of its rows along one axis, got them along both: give an array")
    if named:
        return named[0], next(places for order in orders if (places := _places(axes[named[0]], order)))
    known = [k for k, axis in enumerate(axes) if axis.name.lower() in COORDINATES]
    others = [k for k, axis in enumerate(axes) if axis.name.lower() not in ORBITS]
    if not known and any(axis.name for axis in axes):
        known = others if len(others) == 1 and len(axes) == 2 else []
        if not known:
            dims = ", ".join(axis.name or f"dim_{k}" for k, axis in enumerate(axes))
            raise ValueError(f"{name} must have dimensions 'coordinate' and 'orbit', got {dims}: rename them")
    row = known[0] if known else 0
    suspects = [axes[row]] if known else axes
    if wrong := next((axis for axis in suspects if axis.texts), None):
        raise ValueError(
            f"{name} must have rows named {_some(orders[0])}, got {_some(wrong.labels)}. "
            "Try .to_numpy(), with the rows in that order."
        )
    labels = axes[row].labels
    if labels is not None and labels != tuple(range(len(labels))):
        raise ValueError(
            f"{name} must have rows named {_some(orders[0])}, got rows labelled {_some(labels)}: their order is unknown"
        )
    return row, ()


def _places(axis: Axis, names: tuple[str, ...]) -> tuple[int, ...]:
    """Return the places of all names among the labels of an axis, () unless its labels are these names."""
    labels = axis.labels or ()
    if len(labels) != len(names) or set(labels) != set(names):
        return ()
    return tuple(labels.index(entry) for entry in names)


def _of_variables(name: str, value: Any, orders: Orders) -> np.ndarray:
    """Return the rows of a Dataset, each a variable with the name of the row."""
    for order in orders:
        if all(entry in value for entry in order):
            dims = {tuple(value[entry].dims) for entry in order} - {()}
            if len(dims) > 1 or any(len(entry) > 1 for entry in dims):
                raise ValueError(f"{name} must have rows along one dimension, got {shown(sorted(dims))}")
            return np.array(np.broadcast_arrays(*(numbers(f"{name}[{key!r}]", value[key]) for key in order)))
    hint = f". Try its array, {name}[{name!r}]." if name in value else "."
    raise TypeError(
        f"{name} must have variables {_some(orders[0])}, got a {type(value).__name__} of {_some(value.data_vars)}{hint}"
    )


def _entries_fit(name: str, value: Any, orders: Callable[[], Orders]) -> bool:
    """Tell whether a list is one of labelled rows; refuse one whose labels say another order than the list."""
    entries = [entry for entry in value if len(getattr(entry, "shape", ())) == 1 and not isinstance(entry, np.ndarray)]
    labels = [axes[0].labels for entry in entries if (axes := _axes(name, entry))]
    names = tuple(_name_of(entry) for entry in entries)
    if not any(labels) and not any(names):
        return False
    known = orders()
    if any(set(entry or ()) & set(known[0]) for entry in labels):
        raise ValueError(f"{name} must be one table or an array, got a list of orbits with names of their rows")
    if any(entry != labels[0] for entry in labels):
        raise ValueError(f"{name} must have the same labels in each row, got rows with different ones")
    if set(names) & set(known[0]) and names not in known:
        raise ValueError(f"{name} must have the rows {_some(known[0])} in this order, got {_some(names)}")
    return True


def _name_of(entry: Any) -> str:
    """Return the name of a row: its label along a dimension of coordinates, else its own name; "" for none."""
    coords = getattr(entry, "coords", {})
    label = next((coords[key] for key in COORDINATES if key in coords), None)
    said = getattr(entry, "name", None) if label is None or np.ndim(label) else np.asarray(label, dtype=object).item()
    return said if isinstance(said, str) else ""


def _some(labels: Any) -> str:
    """Return some labels as text."""
    text = ", ".join(str(entry)[:16] for entry, _ in zip(labels, range(9)))
    return text if len(text) <= LONGEST else f"{text[:LONGEST].rpartition(', ')[0]}, ..."
