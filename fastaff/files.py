"""Results on disk: one .npz file with the arrays and everything needed to compute them again."""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import functools
import json
import math
import os
import platform
import shlex
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from . import charts, models, schemes
from .analysis.chaos import indicators
from .base.display import screen
from .base.recipe import OWN, NoData, encoded
from .base.status import summary
from .formulas.library import rebuild
from .models import angles, sections
from .schemes import time_transformed

FORMAT = 1
METADATA = "metadata"


class Saved(NamedTuple):
    """What `load` read: arrays by name, and the metadata of `save`."""

    arrays: dict[str, np.ndarray]
    metadata: dict[str, Any]

    def __repr__(self) -> str:
        return screen(self)


def save(path: Any, result: Any, *, force: bool = False, **parameters: Any) -> Path:
    """Write a result and all that made it to an .npz file and return its path.

    Parameters: path, with or without .npz; result: a SectionMap, FrequencyMap, Orbits, Grid or any dataclass of arrays;
    force: replace an existing file, which otherwise is left alone: the new one gets a number (`name-2.npz`);
    parameters: anything else worth keeping: model, energy, seed, threads, wall_time; arrays go beside those of the
    result, the rest into the metadata. The call that made the result is kept with it: `recipe` reads it back. Returns
    the path written. Raises TypeError for what is no dataclass or has arrays of objects, OSError as `open` does.

    Metadata: versions (fastaff, numpy, numba, python), machine, CPU, cores, date, command line, the counts of each
    status, scheme, section and the parameters. The file is complete or absent: it is written under another name and
    then moved. Needs no pickle to read. Source: the .npy format, NEP 1.
    """
    arrays, facts = _take_apart(result)
    for name, value in parameters.items():
        if isinstance(value, np.ndarray) and value.ndim:
            if name in arrays:
                raise ValueError(f"{name} is an array of the result already; choose another name")
            arrays[name] = value
        else:
            facts[name] = plain(value)
    call = getattr(result, "call", None)
    if call is not None:
        stored = {name: _stored(f"call_{name}", entry, arrays) for name, entry in call.arguments.items()}
        facts["call"] = {**call._asdict(), "arguments": stored}
    for name, array in arrays.items():
        if array.dtype.hasobject:
            raise TypeError(f"array {name} must hold numbers, got dtype {array.dtype}")
    metadata = {**provenance(), "result": type(result).__name__, **facts}
    if "status" in arrays:
        metadata["status_counts"] = {outcome.name: count for outcome, count in summary(arrays["status"]).items()}
    text = np.array(json.dumps(metadata, allow_nan=False))
    return _write(Path(path), {**arrays, METADATA: text}, force)


def load(path: Any) -> Saved:
    """Read a file of `save` at `path`: arrays by name and the metadata.

    Raises FileNotFoundError, or ValueError for a file that `save` did not write. Nothing in the file is executed.
    Source: as `save`.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            if METADATA not in file:
                raise ValueError("it has no metadata")
            metadata = json.loads(str(file[METADATA][()]))
            return Saved({name: file[name] for name in file.files if name != METADATA}, metadata)
    except FileNotFoundError:
        raise
    except Exception as problem:
        raise ValueError(f"{path} must be a file written by fastaff.files.save: {problem}") from None


class Recipe(NamedTuple):
    """A call read from a file: the function of that name in fastaff, fastaff.analysis or fastaff.quantum, which makes
    the result again, bit for bit.
    """

    function: str
    arguments: dict[str, Any]

    def run(self, **instead: Any) -> Any:
        """Make the result again, with other values of the arguments given here."""
        return _public(self.function)(**{**self.arguments, **instead})


def recipe(path: Any, **given: Any) -> Recipe:
    """Return the call that made the result in a file of `save`: the function, the model with its formula, z0 and every
    option.

    Parameters: path; given: arguments that take the place of those in the file. Models, sections and schemes of the
    package and models of formulas are made anew from their numbers and texts; what the file can't hold, functions and
    values of classes of your own, is to be given by name. Nothing in the file is executed. Raises as `load`; ValueError
    for a file without a call, or naming what is to be given.
    """
    arrays, metadata = load(path)
    call = metadata.get("call")
    if not isinstance(call, dict):
        raise ValueError(f"{path} has no call: its result was put together by hand, or saved by an older version")
    absent = [name for name in call["missing"] if name not in given]
    if absent:
        raise ValueError(f"{path} can't hold functions: give {absent[0]}, as in recipe(path, {absent[0]}=...)")
    arguments = dict(given)
    for name, data in call["arguments"].items():
        if name not in given:
            arguments[name] = _decoded(name, data, arrays)
    return Recipe(call["function"], arguments)


def _public(name: str) -> Any:
    """Return the function of the package that has this name."""
    import fastaff

    for home in (fastaff, fastaff.analysis, fastaff.quantum):
        if name in home.__all__:
            return getattr(home, name)
    raise ValueError(f"function {name!r} is none of fastaff {fastaff.__version__}: an older or newer version has it")


def free_stem(stem: Path, suffixes: Iterable[str]) -> Path:
    """Return `stem`, or `stem-2`, `stem-3`, ... so that none of stem + suffix exists."""
    suffixes = tuple(suffixes)
    candidate, number = stem, 1
    while any(candidate.with_name(candidate.name + suffix).exists() for suffix in suffixes):
        number += 1
        candidate = stem.with_name(f"{stem.name}-{number}")
    return candidate


def provenance() -> dict[str, Any]:
    """Return versions, machine, date and command line."""
    import fastaff

    return {
        "format": FORMAT,
        "fastaff": fastaff.__version__,
        "numpy": np.__version__,
        "numba": numba.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cpu": cpu_name(),
        "cores": cores(),
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]) if sys.argv else "",
    }


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cpu_name() -> str:
    """Return the name of the processor, as far as the system tells it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def plain(value: Any) -> Any:
    """Return `value` as JSON holds it: values by class and fields (`recipe.encoded`), schemes by name, infinities as
    text.
    """
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else str(float(value))
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        try:
            return plain(encoded(value))
        except NoData:
            return {
                "class": type(value).__name__,
                **{name: plain(entry) for name, entry in zip(value._fields, value, strict=True)},
            }
    if hasattr(value, "name") and hasattr(value, "order") and hasattr(value, "source"):
        return {"name": value.name, "order": value.order, "source": value.source}
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, set, np.ndarray)):
        return [plain(entry) for entry in value]
    return str(value)


def _stored(name: str, data: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return encoded data with its arrays moved to `arrays`, or to one of them that is the same, and named."""
    if isinstance(data, np.ndarray):
        same = [key for key, array in arrays.items() if array.dtype == data.dtype and np.array_equal(array, data)]
        key = same[0] if same else name
        arrays[key] = arrays.get(key, data)
        return {"array": key}
    if isinstance(data, dict):
        return {key: _stored(f"{name}_{key}", entry, arrays) for key, entry in data.items()}
    if isinstance(data, list):
        return [_stored(f"{name}_{k}", entry, arrays) for k, entry in enumerate(data)]
    return data


def _decoded(name: str, data: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return the value that `encoded` data describes; lists become tuples."""
    if isinstance(data, list):
        return tuple(_decoded(f"{name}[{k}]", entry, arrays) for k, entry in enumerate(data))
    if not isinstance(data, dict):
        return data
    if "array" in data:
        return arrays[data["array"]]
    if "float" in data:
        return float(data["float"])
    if "scheme" in data:
        return schemes.scheme_named(data["scheme"])
    if "chart" in data:
        return charts.CHARTS[data["chart"]]
    fields = {
        key: _decoded(f"{name}.{key}", entry, arrays)
        for key, entry in data.items()
        if key not in ("class", "formula", "module")
    }
    if "formula" in data:
        return rebuild(_decoded(name, data["formula"], arrays), tuple(fields.values()))
    if "module" in data or data["class"] not in _classes():
        kind = ".".join(filter(None, [data.get("module"), data["class"]]))
        raise ValueError(
            f"{name} has the class {kind}, which is not the package's: give {name.partition('.')[0]}=... with its value"
        )
    return _classes()[data["class"]](**fields)


@functools.cache
def _classes() -> dict[str, type]:
    """The package's classes of values by name: models, their potentials and functions, sections, angles, indicators and
    schemes.
    """
    modules = (models, models.functions, sections, angles, indicators, schemes, time_transformed)
    found = {entry for module in modules for entry in vars(module).values() if isinstance(entry, type)}
    return {entry.__name__: entry for entry in found if entry.__module__.partition(".")[0] == OWN}


def _take_apart(result: Any) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Return the arrays and the other fields of a dataclass; tuples of arrays are numbered, arrays of results within it
    named by both.
    """
    if not dataclasses.is_dataclass(result) or isinstance(result, type):
        raise TypeError(f"result must be a result of fastaff, such as a SectionMap, got {type(result).__name__}")
    arrays: dict[str, np.ndarray] = {}
    facts: dict[str, Any] = {}
    for field in dataclasses.fields(result):
        value = getattr(result, field.name)
        if isinstance(value, np.ndarray):
            arrays[field.name] = value
        elif isinstance(value, tuple) and value and all(isinstance(entry, np.ndarray) for entry in value):
            arrays.update({f"{field.name}_{k}": entry for k, entry in enumerate(value)})
        elif dataclasses.is_dataclass(value) and hasattr(value, "status"):  # a result within a result
            inner, own = _take_apart(value)
            arrays.update({f"{field.name}_{name}": entry for name, entry in inner.items()})
            facts[field.name] = own
        elif value is not None:
            facts[field.name] = plain(value)
    return arrays, facts


def _write(path: Path, arrays: dict[str, Any], force: bool) -> Path:
    """Write to a temporary file beside `path`, then move it there; without `force`, to a name that is free."""
    stem = path.with_suffix("") if path.suffix == ".npz" else path
    stem.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=f".{stem.name}-", suffix=".npz", dir=stem.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez(file, **arrays)
        os.chmod(temporary, 0o666 & ~_umask())
        if force:
            target = stem.with_name(stem.name + ".npz")
            os.replace(temporary, target)
            return target
        return _move_without_overwriting(temporary, stem)
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(temporary)


def _move_without_overwriting(temporary: str, stem: Path) -> Path:
    """Move to the first free name; a link fails where another process took the name first."""
    while True:
        free = free_stem(stem, [".npz"])
        target = free.with_name(free.name + ".npz")
        try:
            os.link(temporary, target)
        except FileExistsError:
            continue
        except OSError:  # a file system without links
            os.replace(temporary, target)
        return target


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
