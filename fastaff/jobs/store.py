"""Results of a job on disk: a Zarr hierarchy with a piece of every array for each chunk of orbits; xarray opens it.

    NAME.zarr           attributes: the job as TOML, settled options, versions; format
      launch            z0 (coordinate, orbit), finished (orbit); seals (array, chunk) of all pieces
      poincare, ...     the arrays of each analysis's result, orbits last, and attempt (orbit): 0, or which rerun

Points of a grid that the energy does not reach have no orbit: their numbers are NaN, -1 or False, `finished` is 0.
`finished` is written last: a chunk without it does not count. Each piece has a seal, a number of its content, its array
and its chunk, which is compared when it is read: a piece that was exchanged for another is noticed.
"""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.interruption import imported, reraise_interrupt
from ..core.numbers import shown
from ..core.placing import draft, like, text_of
from ..core.status import Status
from ..exchange.files import opened, unpacked
from ..results.result import Column, columns
from .guard import (
    SEALED,
    SEALS,
    Hierarchy,
    Seals,
    checked_arrays,
    checked_root,
    has_items,
    reported_as_damage,
    seal,
    sealed_arrays,
)
from .wording import OptionError

FORMAT = 5
"""Format of the stores that this version writes and reads."""

ATTRIBUTES = "fastaff"
"""Name of the root's attribute that tells all of the job."""

WAITING = -1
"""Value of `finished`: not computed yet."""

ABSENT = 0
"""Value of `finished`: no orbit at this point."""

DONE = 1
"""Value of `finished`: computed."""

ATTEMPT = "attempt"


class StoreLayout(NamedTuple):
    """The layout of a store: the number of points, the number in a chunk, and the name of their axis."""

    number: int
    chunk: int
    item: str


class Store:
    """Store of a job, open for reading or for writing chunks.

    Parameters
    ----------
    path : path_like
        Path of an existing store.
    writing : bool, default False
        Open for writing too.
    """

    def __init__(self, path: Any, *, writing: bool = False):
        self.path = Path(path)
        self.facts = facts_of(self.path)
        self._folder = _folder(self.path)
        self.root = Hierarchy(self.path, _opened(self.path, "r+" if writing else "r"))
        checked_arrays(self.path, self.root, self.facts)
        self.orbits = int(self.facts["orbits"])
        self.chunk = int(self.facts["chunk"])
        self._written: dict[int, dict[str, int]] = {}
        self._seals = Seals(self.root[f"launch/{SEALS}"], self.facts[SEALED])
        self.root.sealed(self._seals)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.orbits // self.chunk)

    @inserts_parameters
    def points(self, chunk: int) -> slice:
        """Return the points of a chunk.

        Parameters
        ----------
        {chunk_number}

        Returns
        -------
        slice
            Numbers of the points in the launch set.
        """
        return slice(chunk * self.chunk, min((chunk + 1) * self.chunk, self.orbits))

    def finished(self) -> np.ndarray:
        """Return the state of all points.

        Returns
        -------
        ndarray of int, shape (points,)
            WAITING, ABSENT (inaccessible) or DONE.
        """
        return np.asarray(self.root["launch/finished"][:])

    @inserts_parameters
    def state(self, chunk: int) -> np.ndarray:
        """Return the state of the points of a chunk.

        Parameters
        ----------
        {chunk_number}

        Returns
        -------
        ndarray of int, shape (points,)
            WAITING, ABSENT (inaccessible) or DONE.
        """
        return np.asarray(self.root["launch/finished"][self.points(chunk)])

    @inserts_parameters
    def part(self, analysis: str, name: str, chunk: int) -> np.ndarray:
        """Return the numbers of an array that belong to a chunk.

        Parameters
        ----------
        {analysis_name}
        name : str
            Name of the array.
        {chunk_number}

        Returns
        -------
        ndarray, shape (..., points)
            The numbers.
        """
        return np.asarray(self.root[f"{analysis}/{name}"][..., self.points(chunk)])

    @inserts_parameters
    def write(self, chunk: int, z0: np.ndarray, place: np.ndarray, results: Mapping[str, Any]) -> None:
        """Write the orbits and the results of a chunk.

        Written again, they have the same bytes.

        Parameters
        ----------
        {chunk_number}
        z0 : ndarray, shape (2n, orbits)
            Initial conditions.
        place : ndarray of int, shape (orbits,)
            Numbers of the orbits within the chunk.
        results : dict of Result
            Results by name of the analysis.
        """
        self._unseal(chunk)
        points = self.points(chunk)
        count = points.stop - points.start
        written = [self._put("launch", "z0", chunk, _spread(z0, place, count))]
        for analysis, result in results.items():
            content, found = laid_out(result)
            if content != self.facts["contents"][analysis]:
                raise ValueError(f"chunk {chunk} of {analysis} does not belong to this store: it has other settings")
            for column in found:
                written.append(self._put(analysis, column.name, chunk, _spread(column.value, place, count)))
            first = _spread(np.zeros(place.size, np.int16), place, count)
            written.append(self._put(analysis, ATTEMPT, chunk, first))
        _on_disk(written)

    @inserts_parameters
    def start(self, chunk: int, z0: np.ndarray) -> None:
        """Write the initial conditions of a chunk, before anything of it is computed.

        Parameters
        ----------
        {chunk_number}
        z0 : ndarray, shape (2n, orbits)
            Initial conditions.
        """
        written = [self._put("launch", "z0", chunk, z0)]
        _on_disk([*written, *self._sealed(chunk)])

    @inserts_parameters
    def amend(self, chunk: int, analysis: str, rows: np.ndarray, result: Any, attempt: int) -> None:
        """Write new results of some orbits of a chunk over the results of earlier attempts.

        Missing entries become empty.

        Parameters
        ----------
        {chunk_number}
        {analysis_name}
        rows : ndarray of int
            Numbers of the orbits within the chunk.
        result : Result
            Result of these orbits.
        attempt : int
            Number of the attempt.
        """
        found = {column.name: column.value for column in columns(result)}
        found[ATTEMPT] = np.full(rows.size, attempt, np.int16)
        written = []
        for name, array in self.root[analysis].arrays():
            if has_items(array):
                whole = self.part(analysis, name, chunk)
                whole[..., rows] = found.get(name, _empty(whole.dtype))
                written.append(self._put(analysis, name, chunk, whole))
        _on_disk(written)

    @inserts_parameters
    def finish(self, chunk: int, place: np.ndarray) -> None:
        """Mark a chunk as finished, after all else is on the disk.

        Parameters
        ----------
        {chunk_number}
        place : ndarray of int, shape (orbits,)
            Numbers of its orbits within the chunk. The other points have none.
        """
        points = self.points(chunk)
        done = np.full(points.stop - points.start, ABSENT, np.int8)
        done[place] = DONE
        self._note("launch/finished", chunk, done)
        _on_disk(self._sealed(chunk))
        _on_disk([self._put("launch", "finished", chunk, done)])

    @inserts_parameters
    def forget(self, chunk: int) -> None:
        """Mark a chunk as not finished, before it is changed.

        Parameters
        ----------
        {chunk_number}

        Raises
        ------
        ValueError
            If a piece of the chunk is damaged.
        """
        self.verify(range(chunk, chunk + 1))
        points = self.points(chunk)
        kept = self._seals.of(chunk)
        _on_disk([self._put("launch", "finished", chunk, np.full(points.stop - points.start, WAITING, np.int8))])
        self._unseal(chunk)
        self._written[chunk] = kept

    def verify(self, chunks: range | None = None) -> None:
        """Compare the pieces of finished chunks with their checksums.

        Parameters
        ----------
        chunks : range, optional
            Numbers of the chunks. Default: all.

        Raises
        ------
        ValueError
            If a piece is damaged.
        """
        chosen = range(self.chunks) if chunks is None else chunks
        for _, array in sealed_arrays(self.root, self.facts):
            array.verify(chosen)

    def _note(self, name: str, chunk: int, value: np.ndarray) -> None:
        """Keep the seal of a piece, to be written with the others of its chunk."""
        self._written.setdefault(chunk, {})[name] = seal(name, chunk, value)

    def _sealed(self, chunk: int) -> list[Path]:
        """Write the seals of a chunk's pieces, which are on the disk; return their file."""
        self._seals.keep(chunk, self._written.pop(chunk))
        return [self._seals.file(chunk)]

    def _unseal(self, chunk: int) -> None:
        """Take the seals from pieces of a chunk that are going to be written, all but those of its starts, which stay
        the same.
        """
        kept = self._seals.of(chunk)
        if kept.keys() - {"launch/z0"}:
            self._seals.keep(chunk, {name: number for name, number in kept.items() if name == "launch/z0"})
            _on_disk([self._seals.file(chunk)])

    @inserts_parameters
    def read(self, analysis: str, points: slice | None = None, **given: Any) -> Any:
        """Return the result of the finished orbits.

        Parameters
        ----------
        {analysis_name}
        points : slice, optional
            Points of the launch set. Default: all.
        **given : Any
            Fields of the result that have values of user-defined classes, by name.

        Returns
        -------
        Result
            The result.
        """
        part = points or slice(0, self.orbits)
        there = self.root["launch/finished"][part] == DONE
        chunks = np.unique((part.start + np.flatnonzero(there)) // self.chunk)
        arrays = {}
        for name, array in self.root[analysis].arrays():
            if has_items(array):
                if absent := array.lacks(chunks):
                    raise OptionError(f"{self.path} is damaged: {analysis}/{name} of chunk {absent[0]} is not there")
                arrays[name] = np.ascontiguousarray(array[..., points or slice(None)][..., there])
            else:
                arrays[name] = array[...]
        with reported_as_damage(f"{self.path} is damaged: its root tells of {analysis} what does not fit"):
            return unpacked("", self.facts["contents"][analysis], arrays, given)

    def tell(self, **facts: Any) -> None:
        """Change the record of the job in the root of the store, in one move.

        Parameters
        ----------
        **facts : Any
            New values by key.
        """
        self._stays()
        self.facts = {**self.facts, **facts}
        path = self.path / "zarr.json"
        data = json.loads(path.read_text())
        data["attributes"][ATTRIBUTES] = json.dumps(self.facts)
        with draft(self.path) as fresh:
            fresh.write_text(json.dumps(data, indent=1))
            _on_disk([fresh])
            os.chmod(fresh, path.stat().st_mode)
            os.replace(fresh, path)

    def _put(self, group: str, name: str, chunk: int, value: np.ndarray) -> Path:
        """Write a piece and return its path."""
        array = self.root[f"{group}/{name}"]
        file: Path = array.file(chunk)
        self._stays()
        if name != "finished":
            self._note(f"{group}/{name}", chunk, np.asarray(value, array.dtype))
        try:
            array[..., self.points(chunk)] = value
        except OSError as problem:
            self._stays(file)
            if problem.errno is not None and problem.filename is None:
                problem.filename = str(file)
            raise
        self._stays(file)
        return file

    def _stays(self, written: Path | None = None) -> None:
        """Refuse to write if the store is no more; remove the folders that a piece has made there."""
        if _folder(self.path) == self._folder:
            return
        if written is not None and not is_store(self.path):
            written.unlink(missing_ok=True)
            for folder in written.parents:
                if not folder.is_relative_to(self.path):
                    break
                with contextlib.suppress(OSError):  # a folder with other files stays
                    folder.rmdir()
        raise FileNotFoundError(
            f"{self.path} was moved, replaced or removed while it was written. Use fastaff resume NEW_PLACE."
        )


@reraise_interrupt()
def create(
    path: Any,
    facts: Mapping[str, Any],
    template: Mapping[str, Any],
    names: tuple[str, ...],
    *,
    overwrite: bool,
    prepared: Callable[[Store], Any] | None = None,
) -> Store:
    """Make a store with no chunk finished: complete under another name, then moved to its place.

    facts: its root's record, with `orbits` and `chunk`; template: results of a few orbits by the name of the analysis;
    names: of the rows of z0; prepared: called with the store before it is at its place. Raises FileExistsError if the
    path exists; with `overwrite` a store of fastaff is replaced; it stays if that fails.
    """
    path = _behind_links(Path(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    replacing = path.exists()  # a store that another process makes from now on is not replaced
    if replacing and not (overwrite and is_store(path)):
        raise FileExistsError(f"{path} exists" + ("" if not overwrite else " and is no store of fastaff"))
    with draft(path.parent, of_files=True) as fresh:
        root = _zarr().open_group(str(fresh), mode="w", zarr_format=3)
        items = {entry.axes[-1] for result in template.values() for entry in columns(result)}
        layout = StoreLayout(facts["orbits"], facts["chunk"], items.pop())
        launch = root.create_group("launch")
        sealed = ["launch/z0", "launch/finished"]
        _array(launch, "z0", np.float64, (len(names),), ("coordinate",), layout)
        _labels(launch, "coordinate", names)
        _array(launch, "finished", np.int8, (), (), layout)
        contents = {}
        for analysis, result in template.items():
            group = root.create_group(analysis, attributes={"result": type(result).__name__})
            contents[analysis], found = laid_out(result)
            _fill(group, result, found, layout)
            _array(group, ATTEMPT, np.int16, (), (), layout)
            sealed += [f"{analysis}/{name}" for name in (*(column.name for column in found), ATTEMPT)]
        _seals(launch, len(sealed), -(-layout.number // layout.chunk))
        told = {"format": FORMAT, **facts, "contents": contents, SEALED: sealed}
        root.attrs.update({"title": "orbits of fastaff", "job": facts["job"], ATTRIBUTES: json.dumps(told)})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # consolidated metadata are no part of the format yet; xarray reads them
            _zarr().consolidate_metadata(str(fresh), zarr_format=3)
        if prepared is not None:
            prepared(Store(fresh, writing=True))
        if replacing:
            _exchanged(fresh, path)
        else:
            os.rename(fresh, path)
    return Store(path, writing=True)


def _behind_links(path: Path) -> Path:
    """Return the place to which a link leads: a store is made there, and the link stays."""
    if not path.is_symlink():
        return path
    try:
        place = path.resolve()
    except (OSError, RuntimeError):  # a link to itself
        raise OptionError(f"{path} is a link that leads nowhere") from None
    if not place.parent.is_dir():
        raise OptionError(f"{path} is a link to {place}, whose folder does not exist")
    return place


def _exchanged(fresh: Path, path: Path) -> None:
    """Move a new store to the place of an old one, which is removed, or stays if that fails."""
    like(fresh, path)
    old = Path(tempfile.mkdtemp(prefix=f".{path.name}-old-", dir=path.parent))
    os.rename(path, old / "store")
    try:
        os.rename(fresh, path)
    except BaseException:
        os.rename(old / "store", path)
        os.rmdir(old)
        raise
    with draft(path.parent, of_files=True) as gone:
        os.rename(old, gone / "old")


def laid_out(result: Any) -> tuple[Any, list[Column]]:
    """Return the description of a result apart from its orbits, as plain data, and the arrays that have an entry for
    each orbit.
    """
    arrays: dict[str, np.ndarray] = {}
    found = list(columns(result))
    content = opened("", result, arrays)
    return _by_name(content, {column.name for column in found}), found


def _by_name(content: Any, names: set[str], prefix: str = "") -> Any:
    """Return packed data of a result in which the fields of these names are arrays, numbers too."""
    fields = {}
    for key, entry in content["fields"].items():
        name = prefix + key
        nested = isinstance(entry, dict) and "result" in entry and "fields" in entry
        fields[key] = {"array": name} if name in names else _by_name(entry, names, f"{name}_") if nested else entry
    return {**content, "fields": fields}


def is_store(path: Any) -> bool:
    """Tell whether there is a store of fastaff, of any version."""
    with contextlib.suppress(OSError, ValueError, TypeError, LookupError, RecursionError):
        return _told(Path(path)) is not None
    return False


def _told(path: Path) -> Any:
    """Return the root's record: text, which other formats hold too, of JSON."""
    return json.loads(json.loads(text_of(path / "zarr.json"))["attributes"][ATTRIBUTES])


def facts_of(path: Path) -> dict[str, Any]:
    """Return the root's record of a store; refuse other folders, and stores whose arrays other code would read."""
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist")
    if not is_store(path):
        raise OptionError(f"{path} must be a store of a fastaff job: it has none of its attributes")
    facts = _told(path)
    version = facts.get("format") if isinstance(facts, dict) else None
    if type(version) is not int or version != FORMAT:
        raise OptionError(f"{path} has the format {shown(version)}; this version of fastaff reads {FORMAT}")
    checked_root(path, facts)
    return facts


def _opened(path: Path, mode: Any) -> Any:
    zarr = _zarr()
    with reported_as_damage(f"{path} is damaged", OSError):
        return zarr.open_group(str(path), mode=mode, zarr_format=3, use_consolidated=False)


def _zarr() -> Any:
    return imported("zarr", what="a store")


def _fill(group: Any, result: Any, found: Iterable[Column], layout: StoreLayout) -> None:
    """Make the arrays of a result, with labels, units and the values that all orbits share."""
    arrays: dict[str, np.ndarray] = {}
    opened("", result, arrays)
    names = set()
    for column in found:
        value = column.value
        axes = [name.replace(" ", "_") for name in column.axes[:-1]]
        attributes = {"units": column.unit} if column.unit else {}
        _array(group, column.name, value.dtype, value.shape[:-1], axes, layout, attributes)
        names.add(column.name)
        if column.labels and axes and axes[0] not in names and axes[0] not in arrays:
            names.add(axes[0])
            _labels(group, axes[0], column.labels)
    for name, value in arrays.items():
        if name not in names:
            _whole(group, name, value, [f"{name}_{k + 1}" for k in range(value.ndim)])
    if hasattr(result, "status"):
        said = " ".join(entry.name for entry in Status)
        group["status"].attrs.update({"flag_values": [int(entry) for entry in Status], "flag_meanings": said})


def _folder(path: Path) -> tuple[int, int] | None:
    """Return the numbers that tell a folder from one that takes its place."""
    with contextlib.suppress(OSError):
        found = path.stat()
        return found.st_dev, found.st_ino
    return None


def _labels(group: Any, name: str, labels: tuple[str, ...]) -> None:
    """Name the entries of an axis."""
    _whole(group, name, np.array(labels, object), [name], dtype=str)


def _whole(group: Any, name: str, value: np.ndarray, axes: list[str], dtype: Any = None) -> None:
    """Write an array that all orbits share: one piece with a checksum, also where it is empty or zeros."""
    array = group.create_array(
        name,
        shape=value.shape,
        chunks=tuple(max(1, n) for n in value.shape),
        dtype=value.dtype if dtype is None else dtype,
        compressors=_compressors(),
        dimension_names=axes if value.ndim else None,
        config={"write_empty_chunks": True},
    )
    array[...] = value


def _compressors() -> list[Any]:
    from zarr.codecs import ZstdCodec

    return [ZstdCodec(level=1, checksum=True)]


def _array(
    group: Any, name: str, dtype: Any, shape: tuple, axes: Iterable[str], layout: StoreLayout, attributes: Any = None
) -> None:
    group.create_array(
        name,
        shape=(*shape, layout.number),
        chunks=(*(max(1, n) for n in shape), layout.chunk),
        dtype=dtype,
        fill_value=_empty(np.dtype(dtype)),
        compressors=_compressors(),
        dimension_names=(*axes, layout.item),
        attributes=attributes or {},
    )


def _seals(launch: Any, arrays: int, chunks: int) -> None:
    launch.create_array(
        SEALS,
        shape=(arrays, chunks),
        chunks=(arrays, 1),
        dtype=np.uint64,
        fill_value=0,
        compressors=_compressors(),
        dimension_names=("array", "chunk"),
    )


def _empty(dtype: np.dtype) -> Any:
    """Return the value for points without an orbit."""
    return {"f": np.nan, "c": complex(np.nan, np.nan), "i": -1, "b": False, "u": np.iinfo(np.uint8).max}[dtype.kind]


def _spread(value: np.ndarray, place: np.ndarray, count: int) -> np.ndarray:
    """Return values of orbits (..., orbits) at their numbers among so many points."""
    if place.size == count:
        return np.ascontiguousarray(value)
    array = np.full((*value.shape[:-1], count), _empty(value.dtype), value.dtype)
    array[..., place] = value
    return array


def _on_disk(paths: Iterable[Path]) -> None:
    """Return when files have reached the disk."""
    for path in paths:
        with contextlib.suppress(FileNotFoundError):  # a chunk of fill values is no file
            handle = os.open(path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
