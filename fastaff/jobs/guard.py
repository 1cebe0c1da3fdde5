"""What must hold of a store before and while it is read: it is data of the kind that this package writes, all there."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..base.interruption import recognized
from ..base.numbers import MOST, fits, shown
from .wording import Wrong

CODECS = ("bytes", "zstd", "vlen-utf8")
"""All that arrays of a store are coded with: whatever else a file names is not run."""

KINDS = {
    "bool": 1,
    "string": 16,
    **{f"{sign}int{8 * size}": size for sign in ("", "u") for size in (1, 2, 4, 8)},
    **{f"float{8 * size}": size for size in (2, 4, 8)},
    **{f"complex{8 * size}": size for size in (8, 16)},
}
"""Kinds of numbers in a store, with their bytes."""

ITEMS = ("orbit", "case")
"""Names of the axis that is cut into units."""

EMPTY = ("NaN", "Infinity", "-Infinity")
"""Texts for numbers that JSON does not have."""

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
"""What the root of a store tells."""

RERUN = {"status": list, "run": dict, "analyses": list}
"""What is told of each rerun."""

FRAME, CHECKSUM = b"\x28\xb5\x2f\xfd", 4
"""How Zstandard's frames begin (RFC 8878), and the bit that says that the content has a checksum."""

TEXT = 2**20
"""Bytes of an array of labels, at most."""


def checked_store(path: Path, facts: dict[str, Any]) -> None:
    """Refuse a store whose root, groups or arrays are not those that this package writes; reads no numbers."""
    for name, kind in ENTRIES.items():
        if not isinstance(facts.get(name), kind) or (kind is int and isinstance(facts[name], bool)):
            raise Wrong(f"{path} is damaged: its root does not tell {name}")
    orbits, unit = facts["orbits"], facts["unit"]
    if not 1 <= unit <= orbits <= MOST:
        raise Wrong(f"{path} is damaged: it has units of {unit} of {orbits} orbits")
    fits(f"{path}", orbits)
    for name in (*facts["contents"], *facts["settled"]):
        if not re.fullmatch(r"[A-Za-z_]\w*", name) or not (path / name / "zarr.json").is_file():
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
    for name, data_type in LAUNCH.items():
        if _described(path / "launch" / name / "zarr.json").get("data_type") != data_type:
            raise Wrong(f"{path} is damaged: launch/{name} is no array of {data_type}")
    links = [entry for entry in path.iterdir() if entry.is_symlink()]
    for member in _arrays(path):
        data = _described(member / "zarr.json")
        _checked_array(path, member.relative_to(path).as_posix(), data, orbits, unit)
        chunks = [member / "c"]
        for _ in data["shape"][1:]:
            chunks.append(chunks[-1] / "0")
        links += [entry for entry in (member, member / "zarr.json", *chunks) if entry.is_symlink()]
    if links:
        raise Wrong(f"{path} has a link, {links[0].relative_to(path)}, which no store of fastaff has: not read")
    known = _described(path / "zarr.json").get("consolidated_metadata") or {}
    for name, data in (known.get("metadata") or {}).items() if isinstance(known, dict) else ():
        if not isinstance(data, dict) or data.get("node_type") != "group":
            _checked_array(path, name, data, orbits, unit)


def _arrays(path: Path) -> Iterator[Path]:
    for group in sorted(path.iterdir()):
        if (group / "zarr.json").is_file():
            if _described(group / "zarr.json").get("node_type") != "group":
                raise Wrong(f"{group} is no group of a store")
            yield from (member for member in sorted(group.iterdir()) if member.is_dir())


def _described(path: Path) -> dict[str, Any]:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError, ValueError, RecursionError):
        data = None
    if not isinstance(data, dict):
        raise Wrong(f"{path} is no part of a store")
    return data


def _checked_array(path: Path, name: str, data: Any, orbits: int, unit: int) -> None:
    try:
        codecs = [entry["name"] if isinstance(entry, dict) else entry for entry in data["codecs"]]
        kind, shape = data["data_type"], data["shape"]
        axes: Any = data.get("dimension_names") or []
        pieces = data["chunk_grid"]["configuration"]["chunk_shape"]
        keys, transformers = data["chunk_key_encoding"], data.get("storage_transformers")
        whole = [type(n) is int and n >= 0 for n in (*shape, *pieces)]
        plain = len(shape) > 0 or kind != "string"
        plain = plain and all(whole) and len(shape) == len(pieces) and all(n > 0 for n in pieces)
        plain = plain and data["chunk_grid"]["name"] == "regular" and data["node_type"] == "array"
        plain = plain and data["zarr_format"] == 3 and all(isinstance(axis, str) for axis in axes)
        plain = plain and (kind == "string" or not isinstance(data["fill_value"], str) or data["fill_value"] in EMPTY)
        plain = plain and keys == {"name": "default", "configuration": {"separator": "/"}} and not transformers
    except (KeyError, TypeError, AttributeError):
        raise Wrong(f"{path} is damaged: {name} is no array of a store") from None
    other = [str(codec) for codec in codecs if codec not in CODECS]
    if other or not isinstance(kind, str) or kind not in KINDS:
        raise Wrong(
            f"{path} has {name} coded with {other[0] if other else kind}, which no store of fastaff is: not read"
        )
    cut = len(axes) > 0 and axes[-1] in ITEMS
    size = [*(max(1, n) for n in shape[:-1]), unit]
    if not plain or (cut and (shape[-1] != orbits or pieces != size)):
        raise Wrong(f"{path} is damaged: {name} has the shape {shape} in pieces of {pieces}")
    if not cut and pieces != [max(1, n) for n in shape]:
        raise Wrong(f"{path} is damaged: {name} of all orbits is in pieces of {pieces}")
    if not cut:
        fits(f"{path}: {name}", *shape, itemsize=KINDS[kind])
    fits(f"{path}: {name}", *pieces, itemsize=KINDS[kind])


@contextmanager
def sound(where: str, *passed: type[Exception]) -> Iterator[None]:
    """Refuse whatever a damaged or forged store leads to within the block, but for what is passed on."""
    try:
        with recognized():
            yield
    except passed:
        raise
    except Exception as problem:
        raise Wrong(f"{where}: {problem}") from None


class Numbers:
    """An array of a store: what is damaged in it is refused with its name, whatever is found."""

    def __init__(self, path: Path, name: str, array: Any) -> None:
        self._path, self._name = path, name
        # Also what is empty is written: what is not there was lost.
        self._array = array.with_config({"write_empty_chunks": True})

    def __getattr__(self, name: str) -> Any:
        return getattr(self._array, name)

    def __setitem__(self, key: Any, value: Any) -> None:
        value = np.asarray(value)
        if value.dtype.kind in "fc" and (empty := np.isnan(value)).any():
            # What is no number has one form, whichever operation it came from: its sign depends on the company.
            value = np.where(empty, np.asarray(np.nan if value.dtype.kind == "f" else complex(np.nan, np.nan)), value)
        with recognized():
            self._array[key] = value

    def __getitem__(self, key: Any) -> Any:
        with sound(f"{self._path} is damaged in {self._name}", OSError, Wrong):
            last: Any = key[-1] if isinstance(key, tuple) and key else key
            for number in self._pieces(last if isinstance(last, slice) else slice(None)):
                self._whole(number)
            return self._array[key]

    def lacks(self, numbers: np.ndarray) -> list[int]:
        """Return those units among `numbers` that have no chunk."""
        if 0 in self._array.shape:
            return []
        return [int(number) for number in numbers if not self.file(int(number)).is_file()]

    def file(self, number: int) -> Path:
        """Return the file of a unit's chunk."""
        key = (*[0] * (self._array.ndim - 1), number)[: self._array.ndim]
        return self._path / self._name / self._array.metadata.encode_chunk_key(key)

    def _pieces(self, part: slice) -> range:
        array = self._array
        if 0 in array.shape:
            return range(0)
        if not has_items(array):
            return range(1)
        low, high, _ = part.indices(array.shape[-1])
        return range(low // array.chunks[-1], -(-high // array.chunks[-1]))

    def _whole(self, number: int) -> None:
        """Refuse a chunk that does not say that it holds what it should: before memory is taken for it."""
        array = self._array
        try:
            with open(self.file(number), "rb") as file:
                head = file.read(18)
        except FileNotFoundError:
            if has_items(array):
                return  # a unit that is not computed yet
            raise Wrong(f"{self._path} is damaged: {self._name} is not there") from None
        found, size = _content(head), math.prod(array.chunks) * array.dtype.itemsize
        text = array.dtype.kind not in "biufc"
        if found is None or (found > TEXT if text else found != size):
            raise Wrong(f"{self._path} is damaged in {self._name}: chunk {number} does not hold {size} bytes")
        if not head[4] & CHECKSUM:
            raise Wrong(f"{self._path} is damaged in {self._name}: chunk {number} has no checksum")


def has_items(array: Any) -> bool:
    """Tell whether an array has an entry for each point, and is cut into units."""
    names = array.metadata.dimension_names
    return bool(names) and names[-1] in ITEMS


def _content(head: bytes) -> int | None:
    """Return the size that the beginning of a frame tells of its content; None where it is no frame or tells none."""
    if head[:4] != FRAME or len(head) < 6:
        return None
    single, flag = head[4] >> 5 & 1, head[4] >> 6
    at, length = 5 + (1 - single) + (0, 1, 2, 4)[head[4] & 3], (single, 2, 4, 8)[flag]
    return int.from_bytes(head[at : at + length], "little") + (256 if length == 2 else 0) if length else None


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
