"""The checks of a store before and while it is read: its data are complete and of the kind that this package writes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..base.interruption import recognized
from ..base.numbers import MOST, fits, shown
from .wording import Wrong

ITEMS = ("orbit", "case")
"""Names of the axis that is cut into units."""

LAUNCH = {"z0": "float64", "finished": "int8"}
"""Arrays that every store has."""

ENTRIES: dict[str, type] = {
    "job": str,
    "orbits": int,
    "unit": int,
    "contents": dict,
    "settled": dict,
    "source": str,
    "processor": str,
    "other_processors": bool,
    "reruns": list,
}
"""Entries in the root's record of a store."""

RERUN = {"status": list, "run": dict, "analyses": list}
"""Entries in the record of each rerun."""


def checked_root(path: Path, facts: dict[str, Any]) -> None:
    """Refuse a store whose root has another record than this package writes."""
    for name, kind in ENTRIES.items():
        if not isinstance(facts.get(name), kind) or (kind is int and isinstance(facts[name], bool)):
            raise Wrong(f"{path} is damaged: its root does not tell {name}")
    orbits, unit = facts["orbits"], facts["unit"]
    if not 1 <= unit <= orbits <= MOST:
        raise Wrong(f"{path} is damaged: it has units of {unit} of {orbits} orbits")
    fits(f"{path}", orbits)
    for name in (*facts["contents"], *facts["settled"]):
        if not re.fullmatch(r"[A-Za-z_]\w*", name) or not (path / name).is_dir():
            raise Wrong(f"{path} is damaged: it has no {name!r}")
    if facts["contents"].keys() != facts["settled"].keys() or "launch" in facts["contents"]:
        raise Wrong(f"{path} is damaged: what was settled is of other analyses than its results")
    for name, content in facts["contents"].items():
        if not isinstance(content, dict) or not isinstance(content.get("fields"), dict) or "result" not in content:
            raise Wrong(f"{path} is damaged: what it tells of {name} is no result")
    for name, table in facts["settled"].items():
        if not isinstance(table, dict) or not all(isinstance(value, (int, float)) for value in table.values()):
            raise Wrong(f"{path} is damaged: what was settled of {name} is {shown(table)}")
    for again in facts["reruns"]:
        if not isinstance(again, dict) or not all(isinstance(again.get(key), kind) for key, kind in RERUN.items()):
            raise Wrong(f"{path} is damaged: it tells of a rerun {shown(again)}")
        if not set(map(str, again["analyses"])) <= facts["contents"].keys():
            raise Wrong(f"{path} is damaged: it tells of a rerun of {shown(again['analyses'])}")


def checked_arrays(path: Path, root: Hierarchy, facts: dict[str, Any]) -> None:
    """Refuse a store whose arrays are not those that this package writes; reads no numbers. Arrays that Zarr itself
    refuses, such as those of unknown codecs, are refused here.
    """
    for link in (entry for depth in ("*", "*/*", "*/*/*") for entry in path.glob(depth) if entry.is_symlink()):
        raise Wrong(f"{path} has a link, {link.relative_to(path)}, which no store of fastaff has: not read")
    for name, kind in LAUNCH.items():
        if root[f"launch/{name}"].dtype != kind:
            raise Wrong(f"{path} is damaged: launch/{name} is no array of {kind}")
    for group in ("launch", *facts["contents"]):
        for name in sorted(entry.name for entry in (path / group).iterdir() if entry.is_dir()):
            array, where = root[f"{group}/{name}"], f"{group}/{name}"
            shape, cut = array.shape, has_items(array)
            pieces = tuple(max(1, n) for n in shape)
            if cut:
                pieces = *pieces[:-1], facts["unit"]
            else:
                fits(f"{path}: {where}", *shape, itemsize=array.dtype.itemsize or 1)
            fits(f"{path}: {where}", *array.chunks, itemsize=array.dtype.itemsize or 1)
            if array.chunks != pieces or (cut and shape[-1] != facts["orbits"]):
                raise Wrong(f"{path} is damaged: {where} has the shape {shape} in pieces of {array.chunks}")


@contextmanager
def sound(where: str, *passed: type[Exception]) -> Iterator[None]:
    """Turn all errors of a damaged or forged store within the block into `Wrong`, but for those in `passed`."""
    try:
        with recognized():
            yield
    except passed:
        raise
    except Exception as problem:
        raise Wrong(f"{where}: {problem}") from None


class Numbers:
    """An array of a store: any damage in it raises an error with its name."""

    def __init__(self, path: Path, name: str, array: Any) -> None:
        self._path, self._name = path, name
        # Empty chunks are written too: a missing chunk is a lost one.
        self._array = array.with_config({"write_empty_chunks": True})

    def __getattr__(self, name: str) -> Any:
        return getattr(self._array, name)

    def __setitem__(self, key: Any, value: Any) -> None:
        value = np.asarray(value)
        if value.dtype.kind in "fc" and (empty := np.isnan(value)).any():
            # NaN has one form, whichever operation it came from: its sign depends on the neighbours in a vector.
            value = np.where(empty, np.asarray(np.nan if value.dtype.kind == "f" else complex(np.nan, np.nan)), value)
        with recognized():
            self._array[key] = value

    def __getitem__(self, key: Any) -> Any:
        with sound(f"{self._path} is damaged in {self._name}", OSError, Wrong):
            if not has_items(self._array) and self.lacks([0]):  # a missing chunk would be read as fill values
                raise Wrong(f"{self._path} is damaged: {self._name} is not there")
            return self._array[key]

    def lacks(self, numbers: Iterable[int]) -> list[int]:
        """Return the units among `numbers` that have no chunk."""
        if 0 in self._array.shape:
            return []
        return [int(number) for number in numbers if not self.file(int(number)).is_file()]

    def file(self, number: int) -> Path:
        """Return the file of a unit's chunk."""
        key = (*[0] * (self._array.ndim - 1), number)[: self._array.ndim]
        return self._path / self._name / self._array.metadata.encode_chunk_key(key)


def has_items(array: Any) -> bool:
    """Tell whether an array has an entry for each point, and is cut into units."""
    names = array.metadata.dimension_names
    return bool(names) and names[-1] in ITEMS


class Hierarchy:
    """The groups and arrays of a store by name."""

    def __init__(self, path: Path, root: Any, prefix: str = "") -> None:
        self._path, self._root, self._prefix = path, root, prefix
        self._known: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self._known:
            inner = f"{self._prefix}{name}"
            try:
                with sound(f"{self._path} is damaged in {inner}", KeyError):
                    found = self._root[name]
            except KeyError:
                raise Wrong(f"{self._path} is damaged: it has no {inner}") from None
            array = hasattr(found, "chunks")
            self._known[name] = (
                Numbers(self._path, inner, found) if array else Hierarchy(self._path, found, f"{inner}/")
            )
        return self._known[name]

    def __contains__(self, name: str) -> bool:
        return name in self._root

    def arrays(self) -> Iterator[tuple[str, Numbers]]:
        """Yield names and arrays of a group."""
        with sound(f"{self._path} is damaged in {self._prefix}"):
            names = sorted(self._root.array_keys())
        for name in names:
            yield name, self[name]
