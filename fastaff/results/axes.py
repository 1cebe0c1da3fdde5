"""Arrays with named axes: how the fields of results declare them."""

from __future__ import annotations

import functools
from typing import NamedTuple, cast, get_type_hints

import numpy as np


class Axes(NamedTuple):
    """Axes of a field, as `along` declares them: their names, the unit, the field with the labels of the first axis,
    whether these alone name its rows, and the axis that is filled with NaN to a common length.
    """

    names: tuple[str, ...]
    unit: str
    labels: str
    plain: bool
    padded: str

    def around(self, axis: str | None) -> tuple[int, int]:
        """Return the number of axes before and after the axis of the items."""
        before = self.names.index(cast(str, axis))
        return before, len(self.names) - before - 1

    def place(self, axis: str | None, index: tuple) -> tuple:
        """Return the index into a whole array for an index of its items."""
        return (*(slice(None),) * self.around(axis)[0], *index)


def along(*axes: str, unit: str = "", labels: str = "", plain: bool = False, padded: str = "") -> Axes:
    """Declare the axes of an array of a `Result`: their names in order.

    unit: of its numbers, in words; labels: the field that names the entries of its first axis, so that
    `result["FIELD_LABEL"]` is one of them; plain: `result["LABEL"]` too; padded: an axis that may differ between
    results to be joined, NaN past its end. A number in place of an array holds for all items, None for a field that
    was not asked for, a result within the result has the same items.
    """
    return Axes(axes, unit, labels, plain, padded)


@functools.cache
def declared(cls: type) -> dict[str, Axes]:
    """Return the axes that a class declares for its arrays."""
    hints = get_type_hints(cls, include_extras=True)
    found = {
        name: [mark for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, Axes)]
        for name, hint in hints.items()
    }
    return {name: marks[0] for name, marks in found.items() if marks}


def padded(array: np.ndarray, axis: int, length: int) -> np.ndarray:
    """Return an array with NaN up to that length of an axis."""
    if array.shape[axis] == length:
        return array
    width = [(0, 0)] * array.ndim
    width[axis] = (0, length - array.shape[axis])
    return np.pad(array, width, constant_values=np.nan)
