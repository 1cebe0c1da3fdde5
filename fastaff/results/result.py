"""Results of all analyses: a field declares the axes of its array, and the rest follows from that.

A result is a frozen dataclass that inherits from `Result` and declares its arrays with `along`:

    @dataclass(frozen=True)
    class Orbits(Result):
        z: Annotated[np.ndarray, along("coordinate", "orbit", labels="names", plain=True)]
        status: Annotated[np.ndarray, along("orbit")]
        names: tuple[str, ...]

Its items, orbits unless the class names another axis (`class Levels(Result, axis="level")`), have the last axis of
every array that they share. The few results with items first declare that in the same way. Length, joining, rows by
name, tables, files and figures follow.
"""

from __future__ import annotations

import copyreg
import dataclasses
import functools
import html
import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import singledispatch
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Self, SupportsIndex, cast, get_type_hints, overload

import numpy as np
from numpy.typing import ArrayLike

from ..core import status as outcomes
from ..core.interruption import imported
from ..core.names import did_you_mean
from ..core.numbers import StrPath, an_array, listed, shown
from .display import brief, public_fields, screen, short
from .provenance import provenance


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
                raise IndexError(_beyond(result, k, size))
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
        raise IndexError(_beyond(result, int(array[(array < -shape[0]) | (array >= shape[0])][0]), shape[0]))
    raise ValueError(f"items must be indices of {result.axis}s, a slice or a mask {shape[:1]}, got {shown(entry)}")


def _beyond(result: Any, index: int, size: int) -> str:
    """Return the sentence for an index beyond the items of a result."""
    what = f"{size} {result.axis}{'' if size == 1 else 's'}"
    return f"items: the {result.axis} index {shown(index)} is out of range for a result with {what}"


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


def _table(entries: dict) -> MappingProxyType:
    return MappingProxyType(entries)


copyreg.pickle(MappingProxyType, lambda view: (_table, (dict(view),)))  # a field of some results


class Origin(NamedTuple):
    """Where a part of a result comes from: the call that made the whole, the shape of its items, and the indices that
    were taken one after the other.
    """

    call: Any
    shape: tuple[int, ...]
    taken: tuple[tuple, ...]

    def items(self) -> np.ndarray:
        """Return the numbers of the part's items among those of the whole."""
        numbers = np.arange(math.prod(self.shape)).reshape(self.shape)
        for index in self.taken:
            numbers = numbers[index]
        return numbers.ravel()


Items = SupportsIndex | slice | ArrayLike
"""Which items of a result: a number, a slice, numbers or a mask."""


class Drawable:
    """Base of classes that have a figure: `plot`."""

    def plot(self, *others: Any, **options: Any) -> Any:
        """Draw the figure of ``fastaff.plot`` for this result.

        Parameters
        ----------
        *others : object
            Further positional arguments of that function.
        **options : object
            Options of that function, such as ``ax``.

        Returns
        -------
        artists
            Artists that were drawn.

        Raises
        ------
        TypeError
            If there is no figure for this kind of result.
        """
        imported("..plot", __package__)  # which registers its figures; loaded when it is first used
        return drawn(self, *others, **options)


class Result(Drawable):
    """Provide the methods that all results share.

    A result has items, mostly orbits, which are the last axis of its arrays. ``len(result)`` is their number,
    ``result[items]`` the result of some of them, and ``result["name"]`` an array or a row by its name. Iteration yields
    the items one by one. Functions create results; you do not call this class.
    """

    axis: ClassVar[str | None] = "orbit"
    """Name of the axis over the items; None for a result that is one whole."""

    def __init_subclass__(cls, *, axis: str | None = "orbit", **others: Any) -> None:
        super().__init_subclass__(**others)
        cls.axis = axis
        if "__repr__" not in cls.__dict__:
            cls.__repr__ = Result.__repr__  # type: ignore[method-assign]  # so that `dataclass` writes no other

    def __repr__(self) -> str:
        return short(self)

    def __str__(self) -> str:
        return screen(self)

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows."""
        rows = []
        for name in public_fields(self):
            axes = axes_of(self, name)
            value = getattr(self, name)
            named = ", ".join(dims_of(self, name, value)) if isinstance(value, np.ndarray) else ""
            cells = (name, named, brief(value), axes.unit if axes else "")
            rows.append("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>")
        head = "<tr><th>field</th><th>axes</th><th>value</th><th>unit</th></tr>"
        return f"<table><caption>{html.escape(repr(self))}</caption>{head}{''.join(rows)}</table>"

    def __array__(self, *_: Any, **__: Any) -> np.ndarray:
        hint = ", give its .z0" if hasattr(self, "z0") else ""
        raise TypeError(f"a {type(self).__name__} is no array{hint}; its arrays are {listed(field_names(self))}")

    def __bool__(self) -> bool:
        return True

    @property
    def item_shape(self) -> tuple[int, ...]:
        """Shape of the axes over items: (orbits,), () of a single one."""
        for field in dataclasses.fields(cast(Any, self)):
            axes = axes_of(self, field.name)
            value = getattr(self, field.name)
            if axes is None or self.axis not in axes.names:
                continue
            if isinstance(value, Result):
                return value.item_shape
            if isinstance(value, (np.ndarray, np.generic)):
                before, after = axes.around(self.axis)
                return value.shape[before : value.ndim - after]
        raise TypeError(f"{type(self).__name__} is one result, not one of many items")

    def __len__(self) -> int:
        shape = self.item_shape
        if not shape:
            raise TypeError(f"{type(self).__name__} of a single {self.axis} has no length")
        return shape[0]

    @overload
    def __getitem__(self, key: str) -> Any: ...
    @overload
    def __getitem__(self, key: Items | tuple[Items, ...]) -> Self: ...
    def __getitem__(self, key: Any) -> Any:
        """Return an array by name, or the result of some items: a number, slice, mask or array of numbers."""
        return named(self, key) if isinstance(key, str) else self.take(key)

    def __iter__(self) -> Iterator[Self]:
        return (self.take(k) for k in range(len(self)))

    def take(self, items: Items | tuple[Items, ...]) -> Self:
        """Return the result of some of the items.

        Parameters
        ----------
        items : int, slice, array_like of int or mask
            Items to take, or a tuple of these if items have several axes.

        Returns
        -------
        Result
            Result of these items. Slices and single numbers give views. It has no ``call``, which would compute all
            items again.

        Raises
        ------
        TypeError
            If the result has no items.
        IndexError
            If an item does not exist.
        ValueError
            If `items` is not an index of the items. The message names the values allowed.
        """
        index = index_of(self, items)
        shape = self.item_shape
        found = dataclasses.replace(
            cast(Any, self),
            **{name: _taken(value, axes, self, index) for name, axes, value in _shared(self)},
        )
        if hasattr(self, "units"):
            object.__setattr__(found, "units", self.units)
        origin = getattr(self, "origin", None)
        if origin is None and hasattr(self, "call"):
            origin = Origin(self.call, shape, ())
        if origin is not None:
            object.__setattr__(found, "origin", origin._replace(taken=(*origin.taken, index)))
        return found

    def select(self, **wanted: Any) -> Self:
        """Return the items whose arrays have given values.

        Parameters
        ----------
        **wanted : value or sequence of values
            Value, or one of several, by the name of an array: ``select(status=Status.OK)``.

        Returns
        -------
        Result
            Result of these items.

        Raises
        ------
        KeyError
            If the result has no such array.
        ValueError
            If the array does not have one entry for each item.
        """
        kept = np.ones(self.item_shape, bool)
        for name, values in wanted.items():
            array = np.asarray(named(self, name))
            if array.shape != kept.shape:
                raise ValueError(f"{name} must have one entry for each of {kept.shape} items, it has {array.shape}")
            kept &= np.isin(array, np.atleast_1d(an_array(name, list(values) if isinstance(values, set) else values)))
        return self.take(kept)

    @classmethod
    def concat(cls, parts: Iterable[Any]) -> Self:
        """Join results of one kind, in their order.

        Parameters
        ----------
        parts : iterable of Result
            Results with the same settings.

        Returns
        -------
        Result
            Joined result, without a ``call``. An axis that is padded with NaN gets the longest length.

        Raises
        ------
        TypeError
            If the results are of different kinds.
        ValueError
            If a setting differs, which the message names, or if there is no result.
        """
        return cast(Self, _joined(cls, list(parts)))

    def replaced(self, items: Any, part: Self) -> Self:
        """Return the result with some items replaced.

        Parameters
        ----------
        items : int, slice, array_like of int or mask
            Items to take, or a tuple of these if items have several axes.
        part : Result
            Result of as many items, which replace them.

        Returns
        -------
        Result
            New result. Shared fields stay.
        """
        fresh = dataclasses.replace(
            cast(Any, self),
            **{name: value.copy() for name, _, value in _shared(self) if isinstance(value, np.ndarray)},
        )
        put(fresh, items, part)
        return fresh

    def summary(self) -> str:
        """Describe the outcomes of the items in one line.

        Returns
        -------
        str
            Count of each outcome.
        """
        if hasattr(self, "status"):
            return self._in_own_words(outcomes.describe(self.status, what=self.axis or "orbit"))
        try:
            count = int(np.prod(self.item_shape))
        except TypeError:
            return ""
        return f"{count} {self.axis}{'' if count == 1 else 's'}"

    @property
    def success(self) -> bool:
        """True if every item is OK, as in results of SciPy."""
        return not np.any(np.asarray(getattr(self, "status", 0)) != outcomes.Status.OK)

    @property
    def message(self) -> str:
        """Outcomes of the items in words, the text of ``summary()``."""
        return self.summary()

    def raise_if_failed(self) -> None:
        """Raise an error unless every item is OK.

        Raises
        ------
        OrbitError
            If an item has another status. The message counts the outcomes.
        """
        try:
            outcomes.raise_if_failed(getattr(self, "status", np.zeros(0)))
        except outcomes.OrbitError as failed:
            raise outcomes.OrbitError(self._in_own_words(str(failed))) from None

    def _in_own_words(self, text: str) -> str:
        """Return a description of outcomes with the sentences of `_advice`."""
        for outcome, sentence in self._advice().items():
            text = text.replace(f"({outcome.sentence})", f"({sentence})")
        return text

    def _advice(self) -> dict[outcomes.Status, str]:
        """Return outcomes in words that suit the kind of result better than those of orbits in time."""
        return {}

    def save(self, path: StrPath, *, overwrite: bool = False, **parameters: Any) -> Path:
        """Write the result to a file.

        Parameters
        ----------
        path : path
            File. Without an ending or with .npz, `load` reads it. For other programs: .csv, .parquet, .nc or .mat.
        overwrite : bool, default False
            True to replace an existing file. Else the file gets the first free number.
        **parameters : object
            Further numbers, texts or arrays to store in an .npz file.

        Returns
        -------
        Path
            Path of the file.

        Raises
        ------
        TypeError
            If an array does not hold numbers, or if a table has no arrays along the items.
        ValueError
            If the ending is another one, or if parameters are given for a file of another program.
        ImportError
            If the package that writes this format is missing.
        OSError
            If the file cannot be written.
        """
        imported("..exchange.files", __package__)  # which registers the writer
        return saved(self, path, overwrite=overwrite, **parameters)

    def to_dict(self) -> dict[str, Any]:
        """Return arrays with the names of their axes, units and provenance.

        Returns
        -------
        dict
            Keys data_vars and coords, each a dict of dims, data and attrs by name, and attrs. These are numbers and
            texts of the result, its ``call``, versions and date. ``xarray.Dataset.from_dict`` accepts it.

        Notes
        -----
        Units are words such as "time". After a call with Quantities of Astropy they are the units of the numbers, such
        as "Myr".
        """
        found = _labelled(self)
        named: Mapping[str, str] = getattr(self, "units", {})
        for entry in found["data_vars"].values():
            if "units" in entry["attrs"]:
                entry["attrs"]["units"] = in_units(entry["attrs"]["units"], named)
        return {**found, "attrs": {**_facts(self), **_call(self), **provenance()}}

    def to_xarray(self) -> Any:
        """Return the result as a Dataset of xarray.

        Returns
        -------
        xarray.Dataset
            Dataset of the dict of ``to_dict``.

        Raises
        ------
        ImportError
            If xarray is missing.
        """
        return imported("xarray", what="to_xarray (to_dict does not)").Dataset.from_dict(self.to_dict())

    def to_pandas(self) -> Any:
        """Return the result as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            Table that ``save`` writes to .csv.

        Raises
        ------
        ImportError
            If pandas is missing.
        ValueError
            If the result has no table.
        """
        found = imported("..exchange.tables", __package__).table(self)
        return imported("pandas", what="to_pandas (to_dict does not)").DataFrame(found)

    def _row(self, name: str) -> np.ndarray | None:
        """Return another named array of this kind of result, such as a coordinate of a chart; None for none."""
        return None


@singledispatch
def saved(result: Any, path: Any, **parameters: Any) -> Any:
    """Write a result to a file; `fastaff.files`, a higher layer, registers its writers here."""
    raise TypeError(f"{type(result).__name__} can't be saved before fastaff.files is imported")


@singledispatch
def drawn(result: Any, *others: Any, **options: Any) -> Any:
    """Draw a result; `fastaff.plot`, a higher layer, registers its figures here."""
    raise TypeError(f"there is no figure for a {type(result).__name__}")


def put(result: Any, items: Any, part: Any) -> None:
    """Write the arrays of `part` over those items of a result, in place, where both have an array."""
    index = index_of(result, items)
    for name, axes, value in _shared(result):
        new = getattr(part, name)
        if isinstance(value, Result) and isinstance(new, Result):
            put(value, items, new)
        elif isinstance(value, np.ndarray) and isinstance(new, np.ndarray):
            value[axes.place(result.axis, index)] = new


def named(result: Result, name: str) -> Any:
    """Return the field, property or labelled row with that name; raise KeyError with the names that exist."""
    own = field_names(result)
    if name in own or isinstance(getattr(type(result), name, None), property):
        return getattr(result, name)
    rows = rows_of(result)
    if name in rows:
        return rows[name]()
    derived = result._row(name)
    if derived is not None:
        return derived
    known = [row for row in rows if row.partition("_")[0] not in own] or own
    hint = did_you_mean(name, [*own, *rows]) or f" Names: {listed(known).removesuffix('.')}."
    raise KeyError(f"{type(result).__name__} has no field {shown(name)}.{hint}")


def _shared(result: Any) -> Iterator[tuple[str, Axes, Any]]:
    """Yield name, axes and value of the fields that have an entry for each item, no numbers that hold for all."""
    orbits = len(result.item_shape)
    for field in dataclasses.fields(result):
        axes = axes_of(result, field.name)
        value = getattr(result, field.name)
        if axes is None or result.axis not in axes.names:
            continue
        if isinstance(value, Result) or (isinstance(value, np.ndarray) and value.ndim >= len(axes.names) - 1 + orbits):
            yield field.name, axes, value


def _taken(value: Any, axes: Axes, result: Any, index: tuple) -> Any:
    return value.take(index) if isinstance(value, Result) else value[axes.place(result.axis, index)]


def _joined(cls: type, parts: list[Any]) -> Any:
    if not parts:
        raise ValueError("parts must have at least one result")
    kind = type(parts[0]) if cls is Result else cls
    for part in parts:
        if not isinstance(part, Result) or type(part) is not kind:
            raise TypeError(f"parts must all be {kind.__name__}, got a {type(part).__name__}")
    first = parts[0]
    shared = [{name for name, _, _ in _shared(part)} for part in parts]
    values: dict[str, Any] = {}
    for field in dataclasses.fields(first):
        name = field.name
        axes = axes_of(first, field.name)
        entries = [getattr(part, name) for part in parts]
        if axes is None or not any(name in own for own in shared):
            if not all(alike(entries[0], entry) for entry in entries[1:]):
                if axes is not None and axes.names == (first.axis,) and None not in entries:  # one number for each part
                    values[name] = np.concatenate([np.full(p.item_shape, e) for p, e in zip(parts, entries)])
                    continue
                raise ValueError(f"parts must have the same {name}, got {' and '.join(map(brief, entries[:2]))}")
            values[name] = entries[0]
        elif any(entry is None for entry in entries):
            raise ValueError(f"parts must all have {name}, or none of them: one has no such array")
        elif all(isinstance(entry, Result) for entry in entries):
            values[name] = Result.concat(entries)
        else:
            values[name] = _joined_arrays(name, axes, first.axis, entries, parts)
    return kind(**values)


def _joined_arrays(name: str, axes: Axes, axis: str | None, entries: list, parts: list) -> np.ndarray:
    """Return the arrays of one field as one, a number that holds for all as an array too."""
    place = axes.around(axis)[0]
    arrays = [
        entry if np.ndim(entry) else np.full(part.item_shape, entry) for entry, part in zip(entries, parts, strict=True)
    ]
    if axes.padded:
        grown = axes.names.index(axes.padded)
        longest = max(array.shape[grown] for array in arrays)
        arrays = [padded(array, grown, longest) for array in arrays]
    rest = [(*array.shape[:place], *array.shape[place + 1 :]) for array in arrays]
    if any(shape != rest[0] for shape in rest):
        raise ValueError(f"parts must have {name} of the same other axes, got {' and '.join(map(str, rest[:2]))}")
    return np.concatenate(arrays, axis=place)


class Column(NamedTuple):
    """An array of a result or of one within it, items last: its name, the names of its axes, the labels of the first,
    its unit.
    """

    name: str
    value: np.ndarray
    axes: tuple[str, ...]
    labels: tuple[str, ...]
    unit: str


def columns(result: Any, prefix: str = "") -> Iterator[Column]:
    """Yield the arrays that have an entry for each item, of a result and of those within it.

    A number that holds for all items is an array too.
    """
    for field in dataclasses.fields(result):
        axes = axes_of(result, field.name)
        value = getattr(result, field.name)
        if isinstance(value, Result):
            yield from columns(value, f"{prefix}{field.name}_")
        elif axes is not None and result.axis in axes.names and value is not None:
            if np.ndim(value) == 0:
                value = np.full(result.item_shape, value)
            labels = tuple(getattr(result, axes.labels)) if axes.labels else ()
            place = axes.names.index(result.axis)
            names = (*axes.names[:place], *axes.names[place + 1 :], result.axis)
            yield Column(prefix + field.name, np.moveaxis(value, place, -1), names, labels, axes.unit)


def _labelled(result: Any, prefix: str = "") -> dict[str, Any]:
    """Return data_vars and coords of a result and of those within it."""
    data: dict[str, Any] = {}
    coords: dict[str, Any] = {}
    for field in dataclasses.fields(result):
        axes = axes_of(result, field.name)
        value = getattr(result, field.name)
        name = prefix + field.name
        if isinstance(value, Result):
            inner = _labelled(value, f"{name}_")
            data |= inner["data_vars"]
            coords = {**inner["coords"], **coords}
        elif isinstance(value, np.ndarray):
            dims = dims_of(result, field.name, value)
            data[name] = {"dims": dims, "data": value, "attrs": {"units": axes.unit} if axes and axes.unit else {}}
            if axes and axes.labels and len(getattr(result, axes.labels)) == value.shape[0]:
                coords[dims[0]] = {"dims": dims[:1], "data": list(getattr(result, axes.labels)), "attrs": {}}
    return {"data_vars": data, "coords": coords}


def _facts(result: Any) -> dict[str, Any]:
    """Return the numbers and texts of a result, other values as text."""
    facts: dict[str, Any] = {"result": type(result).__name__}
    for name in field_names(result):
        value = getattr(result, name)
        if value is None or isinstance(value, (Result, np.ndarray)):
            continue
        facts[name] = value if type(value) in (int, float, str) else brief(value)
    return facts


def _call(result: Any) -> dict[str, str]:
    call = getattr(result, "call", None)
    if call is None:
        return {}
    given = ", ".join(f"{name}={brief(value)}" for name, value in call.arguments.items())
    return {"call": f"{call.function}({given})"}
