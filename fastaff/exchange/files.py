"""Results on disk: one .npz file with the arrays and everything needed to compute them again."""

from __future__ import annotations

import dataclasses
import enum
import functools
import json
import zipfile
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..chaos import indicators, own_indicator
from ..core.numbers import StrPath, fits, listed, shown
from ..core.placing import checked_file, write_atomically
from ..core.status import summary
from ..results.calls import OWN, Call, NotSerializable, encoded, keep, plain
from ..results.display import screen
from ..results.progress import says_progress
from ..results.provenance import provenance
from ..results.result import Result, saved
from ..runs import schemes
from ..runs.schemes import time_transformed
from ..systems import charts, models, molecules
from ..systems.formulas import space_formula
from ..systems.formulas.iterated_map import remade
from ..systems.models import angles, sections
from ..systems.molecules import pair_sums
from ..tori import families, r4_charts, separation
from .tables import exported

METADATA = "metadata"

FORMAT = 1
"""Format of the files that this version writes and reads."""


class Saved(NamedTuple):
    """Hold the contents of a file of `save`.

    Attributes
    ----------
    arrays : dict of ndarray
        Arrays by name.
    metadata : dict
        Versions, machine, call and all other values that `save` writes.
    """

    arrays: dict[str, np.ndarray]
    metadata: dict[str, Any]

    def __repr__(self) -> str:
        return screen(self)


@says_progress
def save(path: StrPath, result: object, *, overwrite: bool = False, **parameters: Any) -> Path:
    """Write a result and the call that made it to a file.

    Parameters
    ----------
    path : path
        File. Without an ending or with .npz, `load` gives the same result back. Other endings are for other programs:

        * .csv and .parquet: tables with a row for each item. Arrays with more axes, such as samples, are left out.
        * .nc and .mat: NetCDF and MATLAB files with all arrays.
    result : Result or dataclass
        Result of an analysis. Its call is stored too; `recipe` reads it.
    overwrite : bool, default False
        True to replace an existing file. Else the new file gets the first free number, such as "name-2.npz".
    **parameters : object
        Other values to store in an .npz file, such as an energy, a seed or a wall time. Arrays are stored as arrays,
        other values as metadata.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    TypeError
        If `result` is not a result, if an array holds objects, or if a table has no arrays along the items.
    ValueError
        If `path` has another ending, or if parameters are given for a file of another program.
    ImportError
        If the package that writes this format is missing.
    OSError
        If the file cannot be written.

    Notes
    -----
    * Metadata: versions, machine, CPU, cores, date, command line, the counts of each status, scheme, section and the
      parameters.
    * The file is complete or absent: it is written under another name and then moved.

    References
    ----------
    The .npy format, NEP 1.

    Examples
    --------
    >>> orbits = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1.0)
    >>> fa.save("orbits", orbits, seed=0).name
    'orbits.npz'
    """
    path = Path(path)
    if path.suffix != ".npz" and path.suffix[1:2].isalpha():  # not the digits of "energy_0.12"
        return exported(path, result, overwrite, parameters)
    stem = path.with_suffix("") if path.suffix == ".npz" else path
    return save_among(stem, ".npz", result, overwrite=overwrite, parameters=parameters)


def save_among(
    stem: Path,
    ending: str,
    result: Any,
    *,
    parameters: Mapping[str, Any],
    beside: Iterable[str] = (),
    overwrite: bool = False,
) -> Path:
    """Write a result as `save` does to stem + ending, under a number that is free of the endings `beside` too."""
    dataclass = dataclasses.is_dataclass(result) and not isinstance(result, type)
    if not dataclass and type(result) is not _results().get(type(result).__name__):
        raise TypeError(f"result must be a result of fastaff, such as a SectionMap, got {type(result).__name__}")
    arrays: dict[str, Any] = {}
    content = opened("", result, arrays)
    facts = _facts(result)
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
    for name in (name for name, array in arrays.items() if array.dtype.hasobject):
        raise TypeError(f"array {name} must hold numbers, got dtype {arrays[name].dtype}")
    metadata = {**provenance(), **facts, "format": FORMAT, "result": type(result).__name__, "content": content}
    if "status" in arrays:
        metadata["status_counts"] = {outcome.name: count for outcome, count in summary(arrays["status"]).items()}
    arrays[METADATA] = np.array(json.dumps(metadata, allow_nan=False))
    stem.parent.mkdir(parents=True, exist_ok=True)

    def write(path: Path) -> None:
        with open(path, "wb") as file:
            np.savez(file, **arrays)

    return write_atomically(stem, ending, write, beside=beside, overwrite=overwrite)


@saved.register
def _(result: Result, path: Any, **parameters: Any) -> Path:
    return save(path, result, **parameters)


@says_progress
def load(path: StrPath, **given: Any) -> Any:
    """Read the result in a file of `save`.

    Parameters
    ----------
    path : path
        File of `save`.
    **given : object
        Fields that the file cannot hold, by name: functions and values of user-defined classes.

    Returns
    -------
    Result
        Result of the same class, bitwise the same in every field, with its call.

    Raises
    ------
    FileNotFoundError
        If there is no file.
    ValueError
        If `save` did not write the file, or if its format or class is unknown to this version. Also if an array does
        not fit in memory, or if a field must be given; the message names the field.

    Notes
    -----
    No part of the file is executed. It names classes of the package, numbers and formulas, which are read as
    mathematics. `contents` reads the arrays and metadata as they are.

    References
    ----------
    The .npy format, NEP 1.

    Examples
    --------
    >>> path = fa.save("again", fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1.0))
    >>> fa.load(path).status
    array([0])
    """
    arrays, metadata = contents(path)
    try:
        return keep(unpacked("", metadata["content"], arrays, given), _call(metadata, arrays))
    except _ToBeGiven as absent:
        name = str(absent).rpartition(".")[2]
        raise ValueError(f"{path} can't hold {absent}: give {name}, as in load(path, {name}=...)") from None
    except Exception as problem:  # any error of a damaged or forged file
        raise ValueError(f"{path} must hold a result of this version of fastaff: {_said(problem)}") from None


def contents(path: Any) -> Saved:
    """Return the arrays and metadata of a file of `save`.

    Parameters
    ----------
    path : path
        File of `save`. The class of its result need not exist here.

    Returns
    -------
    `Saved`
        Arrays by name, and the metadata.

    Raises
    ------
    FileNotFoundError
        If there is no file.
    ValueError
        If `save` did not write the file, or if it does not fit in memory.

    Examples
    --------
    >>> path = fa.save("orbits", fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1.0))
    >>> fa.files.contents(path).arrays["z"].shape
    (4, 1)
    """
    try:
        checked_file(path)
        with zipfile.ZipFile(path) as archive:
            fits(f"{path}", sum(entry.file_size for entry in archive.infolist()), itemsize=1)
        with np.load(path, allow_pickle=False) as file:
            if METADATA not in file:
                raise ValueError("it has no metadata")
            metadata = json.loads(str(file[METADATA][()]))
            if not isinstance(metadata, dict):
                raise ValueError("its metadata are no table")
            if (written := metadata.get("format", FORMAT)) != FORMAT:
                raise ValueError(f"it has the format {shown(written)}, this version of fastaff reads {FORMAT}")
            return Saved({name: file[name] for name in file.files if name != METADATA}, metadata)
    except FileNotFoundError:
        raise
    except Exception as problem:
        raise ValueError(f"{path} must be a file written by fastaff.save: {problem}") from None


class Recipe(NamedTuple):
    """Hold a call that was read from a file.

    Attributes
    ----------
    function : str
        Name of the analysis.
    arguments : dict
        Arguments by name.
    """

    function: str
    arguments: dict[str, Any]

    def run(self, **instead: Any) -> Any:
        """Compute the result again.

        Parameters
        ----------
        **instead : object
            Other values of arguments, by name.

        Returns
        -------
        Result
            Result, bitwise the same if no argument is replaced.
        """
        return _public(self.function)(**{**self.arguments, **instead})


def recipe(path: Any, **given: Any) -> Recipe:
    """Return the call that made the result in a file of `save`.

    Parameters
    ----------
    path : path
        File of `save`.
    **given : object
        Arguments that replace those in the file, by name. Functions and values of user-defined classes, which the file
        cannot hold, must be given.

    Returns
    -------
    `Recipe`
        Function and arguments: model with its formula, initial conditions and every option.

    Raises
    ------
    FileNotFoundError
        If there is no file.
    ValueError
        If `save` did not write the file, if it has no call, or if an argument must be given. The message names the
        argument.

    Notes
    -----
    Models, sections and schemes of the package and models of formulas are made again from their numbers and texts. No
    part of the file is executed.

    Examples
    --------
    >>> path = fa.save("orbits", fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1.0))
    >>> fa.files.recipe(path).run(time=2.0).t
    array([2.])
    """
    arrays, metadata = contents(path)
    call = metadata.get("call")
    if not isinstance(call, dict):
        raise ValueError(
            f"{path} must have the call of its result, got one joined by hand or saved by an older version"
        )
    kinds = {"function": str, "arguments": dict, "missing": list}
    if not all(isinstance(call.get(name), kind) for name, kind in kinds.items()):
        raise ValueError(f"{path} must hold a call with {listed(kinds)}, got {shown(call)}")
    _public(call["function"])
    absent = [str(name) for name in call["missing"] if name not in given]
    if absent:
        raise ValueError(f"{path} can't hold functions: give {absent[0]}, as in recipe(path, {absent[0]}=...)")
    arguments = dict(given)
    for name, data in call["arguments"].items():
        if name not in given:
            try:
                arguments[name] = decoded(name, data, arrays)
            except ValueError:
                raise
            except Exception as problem:  # any error of a damaged or forged file
                raise ValueError(f"{path} must hold {name} as this version writes it: {_said(problem)}") from None
    return Recipe(call["function"], arguments)


ANALYSES = {
    "action_angles": "tori.action_angles",
    "all_levels": "quantum.spectra.all_levels",
    "basins": "chaos.basins",
    "bifurcation_diagram": "chaos.parameter_diagrams",
    "chaos_map": "chaos.chaos_map",
    "chaotic_fraction": "chaos.chaotic_fraction",
    "class_diagram": "quantum.spectra.level_diagram",
    "continuation": "periodic.continuation",
    "energy_grid": "sections.energy_grid",
    "energy_of_actions": "tori.inverse_tori",
    "energy_sample": "sections.energy_sample",
    "exact_levels": "quantum.exact.exact_levels",
    "find_periodic_orbits": "periodic.find_periodic_orbits",
    "fit_torus": "tori.fit_torus",
    "frequency_map": "frequencies.frequency_map",
    "integrate": "runs.integrate",
    "level_diagram": "quantum.spectra.level_diagram",
    "periodic_orbits": "periodic.periodic_orbits",
    "poincare_map": "sections.poincare_map",
    "quasiclassical_levels": "quantum.exact.quasiclassical_levels",
    "spectrum": "quantum.spectra.spectrum",
    "tangent_map": "runs.tangent_map",
    "unitary_levels": "quantum.groups.unitary",
}
"""Modules of the public functions that keep their call with their result; a test holds that none is missing."""


def _public(name: str) -> Any:
    """Return the analysis of this name: a function that makes a result and keeps its call with it, so that a forged
    file calls none that writes.
    """
    if name in ANALYSES:
        return getattr(import_module(f"{OWN}.{ANALYSES[name]}"), name)
    raise ValueError(f"function {shown(name)} is no analysis of fastaff {provenance()['fastaff']}, which makes results")


def _stored(name: str, data: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return encoded data with its arrays moved to `arrays`, or to one of them that is the same, and named."""
    if isinstance(data, np.ndarray):
        key = next((key for key, array in arrays.items() if _same_bits(array, data)), name)
        arrays[key] = arrays.get(key, data)
        return {"array": key}
    if isinstance(data, dict):
        return {key: _stored(f"{name}_{key}", entry, arrays) for key, entry in data.items()}
    if isinstance(data, list):
        return [_stored(f"{name}_{k}", entry, arrays) for k, entry in enumerate(data)]
    return data


def decoded(name: str, data: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return the value that `encoded` data describes; lists become tuples."""
    if isinstance(data, list):
        return tuple(decoded(f"{name}[{k}]", entry, arrays) for k, entry in enumerate(data))
    if not isinstance(data, dict):
        return data
    if "class" not in data:
        ((kind, entry),) = data.items()
        return _MARKS[kind](entry, arrays)
    fields = {
        key: decoded(f"{name}.{key}", entry, arrays)
        for key, entry in data.items()
        if key not in ("class", "formula", "module")
    }
    if "formula" in data:
        return remade(decoded(name, data["formula"], arrays), tuple(fields.values()))
    if "module" in data or data["class"] not in _classes():
        kind = ".".join(filter(None, [data.get("module"), data["class"]]))
        raise ValueError(
            f"{name} must be of a class of fastaff, got {kind}. Pass {name.partition('.')[0]}=... with its value."
        )
    return _classes()[data["class"]](**fields)


_MARKS: dict[str, Callable[[Any, dict[str, np.ndarray]], Any]] = {
    "array": lambda name, arrays: arrays[name],
    "float": lambda text, _: float(text),
    "scheme": lambda name, _: schemes.scheme_named(name),
    "chart": lambda name, _: charts.CHARTS[name],
}
"""Meaning of encoded data that name no class."""


@functools.cache
def _classes() -> dict[str, type]:
    """The package's classes of values by name: models, potentials, functions, sections, angles, indicators, schemes."""
    values = models, models.functions, sections, angles, indicators, own_indicator, schemes
    modules = *values, molecules, pair_sums, space_formula, time_transformed, families, r4_charts, separation
    found = {entry for module in modules for entry in vars(module).values() if isinstance(entry, type)}
    return {entry.__name__: entry for entry in found if entry.__module__.partition(".")[0] == OWN}


def _same_bits(one: np.ndarray, other: np.ndarray) -> bool:
    """Tell whether two arrays are the same, with the sign of 0."""
    return one.dtype == other.dtype and np.array_equal(one, other) and one.tobytes() == other.tobytes()


def _names(cls: Any) -> list[str]:
    return list(cls._fields) if hasattr(cls, "_fields") else [field.name for field in dataclasses.fields(cls)]


HOMES = (
    *("runs.given_orbits", "runs.integrate", "runs.tangent_map"),
    *("frequencies", "sections", "chaos", "periodic", "tori", "quantum"),
)
"""Folders and modules whose classes files may hold."""


@functools.cache
def _results() -> dict[str, type]:
    """The package's results and their parts by name: dataclasses and NamedTuples of the modules of HOMES."""
    inside = [name for home in HOMES for name in _modules(f"{OWN}.{home}")]
    beside = [entry for name in inside for entry in vars(import_module(name)).values()]
    parts = [entry for entry in beside if _is_own(entry) and entry.__module__ in inside]
    kinds = [entry for entry in parts if dataclasses.is_dataclass(entry) or hasattr(entry, "_fields")]
    found = {entry.__name__: entry for entry in kinds}
    return {name: entry for name, entry in found.items() if name not in _classes() and not name.startswith("_")}


def _modules(name: str) -> list[str]:
    """Return the modules within a folder of the package, or a module itself."""
    paths = getattr(import_module(name), "__path__", None)
    return [name] if paths is None else [found.name for found in walk_packages(paths, f"{name}.")]


def _is_own(entry: Any) -> bool:
    return isinstance(entry, type) and entry is not Result and entry.__module__.partition(".")[0] == OWN


def _below(cls: Any) -> list[Any]:
    """Return a class and all that inherit from it."""
    return [cls, *(entry for child in cls.__subclasses__() for entry in _below(child))]


@functools.cache
def _enumerations() -> dict[str, type[enum.Enum]]:
    """The package's enumerations by name."""
    return {entry.__name__: entry for entry in _below(enum.Enum) if _is_own(entry)}


class _ToBeGiven(Exception):
    """A field that a file can't hold."""


def _packed(name: str, value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return a value as data that JSON holds, its arrays moved to `arrays` under the names of their fields."""
    inner = f"{name}_" if name else ""
    if isinstance(value, np.ndarray):
        arrays[name] = value
        return {"array": name}
    if isinstance(value, np.generic):
        arrays[name] = np.asarray(value)
        return {"number": name}
    if isinstance(value, enum.Enum):
        return {"enum": type(value).__name__, "name": value.name}
    if isinstance(value, Mapping):
        entries = [[key, _packed(f"{inner}{key}", entry, arrays)] for key, entry in value.items()]
        return {"mapping": entries, "frozen": not isinstance(value, dict)}
    if type(value) is _results().get(type(value).__name__):
        return opened(inner, value, arrays)
    if type(value) in (list, tuple):
        return {type(value).__name__: [_packed(f"{inner}{k}", entry, arrays) for k, entry in enumerate(value)]}
    try:
        return {"value": _stored(name, encoded(value), arrays)}
    except NotSerializable:
        return {"missing": type(value).__name__}


def opened(prefix: str, value: Any, arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    """Return class and packed fields of a result; its arrays go to `arrays`."""
    fields = {key: _packed(f"{prefix}{key}", getattr(value, key), arrays) for key in _names(value)}
    return {"result": type(value).__name__, "fields": fields}


def unpacked(name: str, data: Any, arrays: dict[str, np.ndarray], given: Mapping[str, Any]) -> Any:
    """Return the value that `_packed` data describes; missing values are those of `given`, by the name of the field."""
    inner = f"{name}." if name else ""
    last = name.rpartition(".")[2]
    if last in given:
        return given[last]
    if "array" in data:
        return arrays[data["array"]]
    if "number" in data:
        return arrays[data["number"]][()]
    if "enum" in data:
        return _known(_enumerations(), data["enum"], name)[data["name"]]
    if "mapping" in data:
        entries = {key: unpacked(f"{inner}{key}", entry, arrays, given) for key, entry in data["mapping"]}
        return MappingProxyType(entries) if data["frozen"] else entries
    if "result" in data:
        cls = _known(_results(), data["result"], name)
        if not set(data["fields"]) <= set(_names(cls)):  # files of earlier versions lack fields that have defaults
            raise ValueError(f"a {cls.__name__} has the fields {listed(_names(cls))}, not {listed(data['fields'])}")
        return cls(**{key: unpacked(f"{inner}{key}", entry, arrays, given) for key, entry in data["fields"].items()})
    for kind in (list, tuple):
        if kind.__name__ in data:
            return kind(unpacked(f"{inner}{k}", entry, arrays, given) for k, entry in enumerate(data[kind.__name__]))
    if "missing" in data or _foreign(data["value"]):
        raise _ToBeGiven(name)
    return decoded(name, data["value"], arrays)


def _known(classes: Mapping[str, Any], name: Any, field: str) -> Any:
    if name not in classes:
        raise ValueError(f"{field or 'it'} has the class {name}, which is not the package's")
    return classes[name]


def _foreign(data: Any) -> bool:
    """Tell whether encoded data name a class of another package."""
    if isinstance(data, dict):
        return "module" in data or any(map(_foreign, data.values()))
    return isinstance(data, list) and any(map(_foreign, data))


def _said(problem: Exception) -> str:
    return f"no {problem}" if isinstance(problem, KeyError) else f"{problem}"


def _call(metadata: dict[str, Any], arrays: dict[str, np.ndarray]) -> Call | None:
    """Return the call in the metadata as `records_call` kept it."""
    call = metadata.get("call")
    if not isinstance(call, dict):
        return None
    arguments = {name: _filled(data, arrays) for name, data in call["arguments"].items()}
    return Call(call["function"], arguments, tuple(call["missing"]))


def _filled(data: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return encoded data with the arrays that `_stored` moved away."""
    if isinstance(data, dict):
        moved = set(data) == {"array"}
        return arrays[data["array"]] if moved else {key: _filled(entry, arrays) for key, entry in data.items()}
    return [_filled(entry, arrays) for entry in data] if isinstance(data, list) else data


def _facts(result: Any) -> dict[str, Any]:
    """Return the fields of a result that are no arrays, for people."""
    facts: dict[str, Any] = {}
    for name in _names(result):
        value = getattr(result, name)
        arrays = isinstance(value, tuple) and value and all(isinstance(entry, np.ndarray) for entry in value)
        if value is None or isinstance(value, np.ndarray) or arrays:
            continue
        facts[name] = _facts(value) if isinstance(value, Result) else plain(value)
    return facts
