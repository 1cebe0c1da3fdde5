"""The checks of a store before and while it is read: its data are complete and of the kind that this package writes."""

from __future__ import annotations

import hashlib
import os
import re
import stat
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..core.interruption import reraise_interrupt
from ..core.numbers import MOST, fits, shown
from .wording import OptionError

ITEMS = ("orbit", "case")
"""Names of the axis that is cut into chunks."""

LAUNCH = {"z0": "float64", "finished": "int8"}
"""Arrays that every store has."""

SEALS = "seals"
"""Array of the group launch with a row for each chunk: a seal of its piece of each array, 0 before it is written."""

ENTRIES: dict[str, type] = {
    "job": str,
    "orbits": int,
    "chunk": int,
    "contents": dict,
    "settled": dict,
    "source": str,
    "processor": str,
    "other_cpu_allowed": bool,
    "reruns": list,
}
"""Entries in the root's record of a store."""

AT_ONCE = 2**20
"""Bytes of an array that are read at once, or a chunk that takes more: memory has no second copy of all."""

SEALED = "sealed"
"""Entry in the root's record of a store: the names of the arrays that have seals, in the order of these."""

RERUN = {"status": list, "options": dict, "analyses": list}
"""Entries in the record of each rerun."""


def checked_root(path: Path, facts: dict[str, Any]) -> None:
    """Refuse a store whose root has another record than this package writes."""
    for name, kind in ENTRIES.items():
        if not isinstance(facts.get(name), kind) or (kind is int and isinstance(facts[name], bool)):
            raise OptionError(f"{path} is damaged: its root does not tell {name}")
    orbits = facts["orbits"]
    chunk = facts["chunk"]
    if not 1 <= chunk <= orbits <= MOST:
        raise OptionError(f"{path} is damaged: it has chunks of {chunk} of {orbits} orbits")
    fits(f"{path}", orbits)
    for name in (*facts["contents"], *facts["settled"]):
        if not re.fullmatch(r"[A-Za-z_]\w*", name) or not (path / name).is_dir():
            raise OptionError(f"{path} is damaged: it has no {shown(name)}")
    if facts["contents"].keys() != facts["settled"].keys() or "launch" in facts["contents"]:
        raise OptionError(f"{path} is damaged: what was settled is of other analyses than its results")
    for name, content in facts["contents"].items():
        if not isinstance(content, dict) or not isinstance(content.get("fields"), dict) or "result" not in content:
            raise OptionError(f"{path} is damaged: what it tells of {name} is no result")
    for name, table in facts["settled"].items():
        if not isinstance(table, dict) or not all(isinstance(value, (int, float)) for value in table.values()):
            raise OptionError(f"{path} is damaged: what was settled of {name} is {shown(table)}")
    for again in facts["reruns"]:
        if not isinstance(again, dict) or not all(isinstance(again.get(key), kind) for key, kind in RERUN.items()):
            raise OptionError(f"{path} is damaged: it tells of a rerun {shown(again)}")
        if not set(map(str, again["analyses"])) <= facts["contents"].keys():
            raise OptionError(f"{path} is damaged: it tells of a rerun of {shown(again['analyses'])}")
    sealed = facts.get(SEALED)
    if not isinstance(sealed, list) or not all(isinstance(name, str) for name in sealed):
        raise OptionError(f"{path} is damaged: its root does not tell {SEALED}")


def checked_arrays(path: Path, root: Hierarchy, facts: dict[str, Any]) -> None:
    """Refuse a store whose arrays are not those that this package writes; reads no numbers. Arrays that Zarr itself
    refuses, such as those of unknown codecs, are refused here.
    """
    for depth in ("*", "*/*", "*/*/*"):
        for entry in path.glob(depth):
            _plain(path, entry)
    for name, kind in LAUNCH.items():
        if root[f"launch/{name}"].dtype != kind:
            raise OptionError(f"{path} is damaged: launch/{name} is no array of {kind}")
    for group in ("launch", *facts["contents"]):
        for name in sorted(entry.name for entry in (path / group).iterdir() if entry.is_dir()):
            array = root[f"{group}/{name}"]
            where = f"{group}/{name}"
            for folder in array.file(0).parents:
                if folder == path / where:
                    break
                _plain(path, folder)
            shape = array.shape
            cut = has_items(array)
            pieces = tuple(max(1, n) for n in shape)
            if cut:
                pieces = *pieces[:-1], facts["chunk"]
            elif where == f"launch/{SEALS}":
                pieces = *pieces[:-1], 1
            else:
                fits(f"{path}: {where}", *shape, itemsize=array.dtype.itemsize or 1)
            fits(f"{path}: {where}", *array.chunks, itemsize=array.dtype.itemsize or 1)
            if array.chunks != pieces or (cut and shape[-1] != facts["orbits"]):
                raise OptionError(f"{path} is damaged: {where} has the shape {shape} in pieces of {array.chunks}")

    chunks = -(-facts["orbits"] // facts["chunk"])
    seals = root[f"launch/{SEALS}"]
    arrays = {name for name, _ in sealed_arrays(root, facts)}
    if (seals.shape, seals.dtype) != ((len(facts[SEALED]), chunks), np.uint64) or arrays != set(facts[SEALED]):
        raise OptionError(f"{path} is damaged: launch/{SEALS} has no seals of its arrays")


def _plain(path: Path, entry: Path) -> None:
    """Refuse what no store has: links, by which another folder would be written, and pipes, which have no end."""
    mode = 0
    try:
        mode = os.lstat(entry).st_mode
    except FileNotFoundError:
        return
    if stat.S_ISLNK(mode):
        raise OptionError(f"{path} has a link, {entry.relative_to(path)}, which no store of fastaff has: not read")
    if not (stat.S_ISDIR(mode) or stat.S_ISREG(mode)):
        raise OptionError(
            f"{path} has a pipe or device, {entry.relative_to(path)}, which no store of fastaff has: not read"
        )


def sealed_arrays(root: Hierarchy, facts: dict[str, Any]) -> Iterator[tuple[str, Numbers]]:
    """Yield names and arrays whose pieces have seals: all that have an entry for each orbit."""
    for group in ("launch", *facts["contents"]):
        for name, array in root[group].arrays():
            if has_items(array):
                yield f"{group}/{name}", array


def seal(name: str, chunk: int, value: np.ndarray) -> int:
    """Return the seal of a chunk's piece of an array: a number of its content, its name and the chunk, never 0."""
    content = np.ascontiguousarray(one_nan(value))
    digest = hashlib.blake2b(f"{name} {chunk} {content.dtype.str} {content.shape}\0".encode(), digest_size=8)
    digest.update(content.data if content.size else b"")
    return int.from_bytes(digest.digest(), "little") or 1


def one_nan(value: Any) -> np.ndarray:
    """Return numbers whose NaN have one form, whichever operation they came from: the sign of a NaN depends on the
    neighbours in a vector.
    """
    value = np.asarray(value)
    if value.dtype.kind in "fc" and (empty := np.isnan(value)).any():
        value = np.where(empty, np.asarray(np.nan if value.dtype.kind == "f" else complex(np.nan, np.nan)), value)
    return value


class Seals:
    """The seals of a store: a piece that is another chunk's, or of another array or moment, does not fit its seal.

    The seals of a chunk are 0 while its pieces are being written, so that one that is there always fits.
    """

    def __init__(self, array: Numbers, names: list[str]) -> None:
        self._array = array
        self._place = {name: k for k, name in enumerate(names)}
        self._known: dict[int, np.ndarray] = {}

    def of(self, chunk: int) -> dict[str, int]:
        """Return the seals of a chunk by the names of arrays, as they are on the disk: those that are there."""
        found = self._read(chunk)
        return {name: int(found[at]) for name, at in self._place.items() if found[at]}

    def _read(self, chunk: int) -> np.ndarray:
        return np.asarray(self._array[:, chunk])

    def file(self, chunk: int) -> Path:
        """Return the file of a chunk's seals."""
        path: Path = self._array.file(chunk)
        return path

    def keep(self, chunk: int, found: dict[str, int]) -> None:
        """Write the seals of a chunk: those of arrays that are not named are 0."""
        column = np.zeros(len(self._place), np.uint64)
        for name, number in found.items():
            column[self._place[name]] = number
        self._array[:, chunk] = column
        self._known.pop(chunk, None)

    def fits(self, name: str, chunk: int, value: np.ndarray) -> bool:
        """Tell whether the piece of a chunk is what was written there; so it is where the chunk is being written."""
        if name not in self._place:
            return True
        number = seal(name, chunk, value)
        at = self._place[name]
        finished = name == "launch/finished"
        for fresh in (False, True):  # another process may have written the chunk anew
            if fresh or chunk not in self._known:
                self._known[chunk] = self._read(chunk)
            kept = int(self._known[chunk][at])
            if kept == number or (kept == 0 and not finished):
                return True
        return finished and bool((value < 0).all())


@contextmanager
def reported_as_damage(where: str, *passed: type[Exception]) -> Iterator[None]:
    """Turn all errors of a damaged or forged store within the block into `OptionError`, but for those in `passed`."""
    try:
        with reraise_interrupt():
            yield
    except passed:
        raise
    except Exception as problem:
        raise OptionError(f"{where}: {problem}") from None


class Numbers:
    """An array of a store: any damage in it raises an error with its name."""

    def __init__(self, path: Path, name: str, array: Any, seals: Seals | None = None) -> None:
        self._path = path
        self._name = name
        self._seals = seals
        # Empty pieces are written too: a missing piece is a lost one.
        self._array = array.with_config({"write_empty_chunks": True})

    def __getattr__(self, name: str) -> Any:
        return getattr(self._array, name)

    def __setitem__(self, key: Any, value: Any) -> None:
        value = one_nan(value)
        with reraise_interrupt():
            self._array[key] = value

    def __getitem__(self, key: Any) -> Any:
        with reported_as_damage(f"{self._path} is damaged in {self._name}", OSError, OptionError):
            if has_items(self._array):
                return self._of_units(key)
            if self._name == f"launch/{SEALS}":
                self._is_file(key[-1])
            elif self.lacks([0]):  # a missing piece would be read as fill values
                raise OptionError(f"{self._path} is damaged: {self._name} is not there")
            return self._array[key]

    def _of_units(self, key: Any) -> Any:
        """Return the entries of a key, its last part a slice of items, from whole pieces that fit their seals."""
        *before, items = key if isinstance(key, tuple) else (key,)
        if items is ... or (not before and self._array.ndim > 1):
            before = [] if items is ... else [items]
            items = slice(None)
        first, last, _ = items.indices(self.shape[-1])
        if last <= first:
            return self._array[key]
        found = np.empty((*self.shape[:-1], last - first), self._array.dtype)
        size = self.chunks[-1]
        chunks = range(first // size, -(-last // size))
        for begin, step in self._runs(chunks):
            low = begin * size
            high = min(begin + step, chunks.stop) * size
            whole = self._checked(begin, low, high)
            part = slice(max(first, low), min(last, high))
            found[..., part.start - first : part.stop - first] = whole[..., part.start - low : part.stop - low]
        return found[(*before, slice(None)) if ... in before else (*before, ..., slice(None))]

    def verify(self, chunks: range) -> None:
        """Refuse pieces of some chunks that do not fit their seals; they are read some at a time."""
        size = self.chunks[-1]
        for begin, step in self._runs(chunks):
            self._checked(begin, begin * size, min(begin + step, chunks.stop) * size)

    def _runs(self, chunks: range) -> Iterator[tuple[int, int]]:
        """Yield the first of some chunks and the number that is read with it."""
        each = max(1, self._array.dtype.itemsize * int(np.prod(self.shape[:-1])) * self.chunks[-1])
        step = max(1, AT_ONCE // each)
        for begin in chunks[::step]:
            yield begin, step

    def _checked(self, begin: int, low: int, high: int) -> np.ndarray:
        """Return the items of some chunks, the first of which is `begin`, if they fit their seals."""
        size = self.chunks[-1]
        numbers = range(begin, -(-high // size))
        for number in numbers:
            self._is_file(number)
        whole = np.asarray(self._array[..., low:high])
        for number in numbers:
            part = whole[..., number * size - low : (number + 1) * size - low]
            if self._seals is not None and not self._seals.fits(self._name, number, part):
                raise OptionError(
                    f"{self._path} is damaged: {self._name} of chunk {number} is not what was written there"
                )
        return whole

    def _is_file(self, number: int) -> None:
        """Refuse a piece that is no file, such as a pipe, which would be waited for without an end."""
        _plain(self._path, self.file(number))

    def lacks(self, numbers: Iterable[int]) -> list[int]:
        """Return the chunks among `numbers` that have no piece."""
        if 0 in self._array.shape:
            return []
        return [int(number) for number in numbers if not self.file(int(number)).is_file()]

    def file(self, number: int) -> Path:
        """Return the file of a chunk's piece."""
        key = (*[0] * (self._array.ndim - 1), number)[: self._array.ndim]
        return self._path / self._name / self._array.metadata.encode_chunk_key(key)


def has_items(array: Any) -> bool:
    """Tell whether an array has an entry for each point, and is cut into chunks."""
    names = array.metadata.dimension_names
    return bool(names) and names[-1] in ITEMS


class Hierarchy:
    """The groups and arrays of a store by name."""

    def __init__(self, path: Path, root: Any, prefix: str = "") -> None:
        self._path = path
        self._root = root
        self._prefix = prefix
        self._known: dict[str, Any] = {}
        self._seals: Seals | None = None

    def sealed(self, seals: Seals) -> None:
        """Compare all arrays with their seals from now on."""
        self._seals = seals
        self._known.clear()

    def __getitem__(self, name: str) -> Any:
        if name not in self._known:
            inner = f"{self._prefix}{name}"
            try:
                with reported_as_damage(f"{self._path} is damaged in {inner}", KeyError):
                    found = self._root[name]
            except KeyError:
                raise OptionError(f"{self._path} is damaged: it has no {inner}") from None
            if hasattr(found, "chunks"):
                self._known[name] = Numbers(self._path, inner, found, self._seals)
            else:
                self._known[name] = Hierarchy(self._path, found, f"{inner}/")
                self._known[name]._seals = self._seals
        return self._known[name]

    def __contains__(self, name: str) -> bool:
        return name in self._root

    def arrays(self) -> Iterator[tuple[str, Numbers]]:
        """Yield names and arrays of a group."""
        with reported_as_damage(f"{self._path} is damaged in {self._prefix}"):
            names = sorted(self._root.array_keys())
        for name in names:
            yield name, self[name]
