"""A job: the orbits of a system and the analyses of each; read from and written as TOML."""

from __future__ import annotations

import contextlib
import json
import re
import tomllib
import typing
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any, NamedTuple

import numpy as np

from ..core.names import did_you_mean
from ..core.numbers import listed, numbers, shown, whole
from ..core.placing import text_of
from ..runs.requirements import check_given, checked_system, current_system, phase_points
from ..runs.starts import ordered, orders_of, starts_of
from ..systems.formulas.number import number
from ..systems.models.mechanics import System
from .analyses import (
    ANALYSES,
    TRIAL,
    ActionAngleOptions,
    AnalysedOrbits,
    Analysis,
    ChaosOptions,
    FrequencyOptions,
    IntegrateOptions,
    PoincareOptions,
    RunOptions,
)
from .launch import InitialConditions, Launch, Points, some
from .scans import Cases, Scan, ScanOfChaos
from .system import EnergySurface, Model, described
from .wording import OptionError, option, respelled, spelled


class JobPlan(NamedTuple):
    """The plan of a job: a system, a section or None, the launch set, and analyses by name."""

    system: System
    section: Any
    launch: Launch
    analyses: dict[str, Analysis]

    @property
    def model(self) -> Any:
        """The model."""
        return self.system.model

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the rows of a point: coordinates, or the parameters of a scan."""
        return getattr(self.launch, "names", None) or self.system.row_names

    def few(self) -> AnalysedOrbits:
        """Return orbits for a trial, spread over the launch set."""
        return AnalysedOrbits(self.system, self.section, some(self.launch, TRIAL))


@dataclass(frozen=True, kw_only=True)
class Job:
    """Describe many orbits of one system and the analyses of each.

    Each parameter is a table of the same name in a TOML file and a group of options on the command line.

    Parameters
    ----------
    model : Model or model, optional
        A `Model`, or any model of the library. Default: the neo-Hookean body.
    energy_surface : EnergySurface, optional
        Energy and section.
    initial_conditions : InitialConditions or array_like, shape (2n, orbits), optional
        Grid, random points or a file; or phase points.
    options : RunOptions, optional
        Integration method, step size or accuracy, threads.
    poincare : PoincareOptions, optional
        Crossings of the section. At least one analysis is needed.
    frequency_map : FrequencyOptions, optional
        Fundamental frequencies.
    chaos_map : ChaosOptions, optional
        Indicators of chaos.
    scan : Scan, optional
        Parameters over which `chaos_map` finds the chaotic fraction. The items of the job are then cases instead of
        orbits.
    action_angles : ActionAngleOptions, optional
        Actions and angles of a separable body.
    integrate : IntegrateOptions, optional
        Orbits up to a time.
    chunk : int, optional
        Number of orbits that are computed and stored together. Default: as many as take a few seconds.

    Raises
    ------
    TypeError, ValueError
        If a parameter is wrong. The message names the parameter and its field.

    Examples
    --------
    >>> surface = fa.jobs.EnergySurface(energy=0.1)
    >>> job = fa.Job(model=fa.HenonHeiles(), energy_surface=surface, poincare=fa.jobs.PoincareOptions())
    >>> list(job.analyses())
    ['poincare']
    """

    model: Any = field(default_factory=Model)
    energy_surface: EnergySurface = field(default_factory=EnergySurface)
    initial_conditions: Any = field(default_factory=InitialConditions)
    options: RunOptions = field(default_factory=RunOptions)
    poincare: PoincareOptions | None = None
    frequency_map: FrequencyOptions | None = None
    chaos_map: ChaosOptions | None = None
    scan: Scan | None = None
    action_angles: ActionAngleOptions | None = None
    integrate: IntegrateOptions | None = None
    chunk: int | None = None

    def __post_init__(self) -> None:
        for name, kind in TABLES.items():
            value = getattr(self, name)
            if name == "model" and isinstance(value, str):
                value = Model(model=value)
            elif isinstance(value, dict):
                value = _table(name, value)
            if isinstance(value, kind):
                hints = _hints(kind).items()
                value = replace(
                    value, **{key: _taken(option(key, name), getattr(value, key), hint) for key, hint in hints}
                )
                object.__setattr__(self, name, value.canonical() if hasattr(value, "canonical") else value)
            elif name == "model":
                object.__setattr__(self, name, described(checked_system(value, "model")) or value)
            elif name == "initial_conditions":
                value = ordered("initial_conditions", starts_of(value), lambda: orders_of(self._system()))
                points = numbers("initial_conditions", value)
                if points.ndim not in (1, 2):
                    raise ValueError(
                        f"initial_conditions must be phase points (2n, orbits), got shape {np.shape(value)}"
                    )
                object.__setattr__(self, name, value if points.ndim == 2 else points[:, None])
            elif value is not None or name in ("energy_surface", "options"):
                raise TypeError(f"{name} must be of class {kind.__name__}, got {shown(value)} ({type(value).__name__})")
        if not self.analyses():
            raise ValueError(f"a job must have an analysis, one of {listed(ANALYSES)}, got none")
        if self.chunk is not None:
            object.__setattr__(self, "chunk", whole("chunk", self.chunk, 1))
        if self.scan is not None and [*self.analyses()] != ["chaos_map"]:
            raise ValueError(f"scan takes chaos_map alone, got {listed(self.analyses())}")

    def analyses(self) -> dict[str, Analysis]:
        """Return the analyses of the job.

        Returns
        -------
        dict
            Options by name of the analysis.
        """
        return {name: getattr(self, name) for name in ANALYSES if getattr(self, name) is not None}

    def _system(self) -> System:
        """Return the system of the model."""
        return current_system(self.model.build() if isinstance(self.model, Model) else self.model)

    def plan(self) -> JobPlan:
        """Return system, section, initial conditions and analyses.

        Returns
        -------
        JobPlan
            Tuple of these parts.

        Raises
        ------
        TypeError, ValueError
            If parts do not fit together.
        """
        system = self._system()
        for name, analysis in self.analyses().items():
            _check_analysis(name, analysis, self.options)
        if system.iterated:
            self._check_map(system)
        if self.scan is not None:
            return self._scan(system, self.scan)
        timed = any(getattr(entry, "returns", None) is not None for entry in self.analyses().values())
        needed = self.poincare is not None or self.energy_surface.section is not None or timed
        if isinstance(self.initial_conditions, InitialConditions) and self.initial_conditions.file is None:
            section = self.energy_surface.build(system)
            launch = self.initial_conditions.launch(system, section, self.energy_surface, "40x40")
            needed |= not self.initial_conditions.by_name or (
                self.chaos_map is not None and self.chaos_map.time is None
            )
            return JobPlan(system, section if needed else None, launch, self.analyses())
        z0 = (
            self.initial_conditions.read()
            if isinstance(self.initial_conditions, InitialConditions)
            else numbers("initial_conditions", self.initial_conditions)
        )
        if system.driven and z0.shape[0] == 2 * system.moving and z0.size:
            z0 = phase_points("initial_conditions", z0, system)  # at t = 0
        if z0.shape[0] != system.rows or not z0.shape[1]:
            raise ValueError(f"initial_conditions must be phase points ({system.rows}, orbits), got {z0.shape}")
        section = self.energy_surface.section_of(system) if needed else None
        return JobPlan(system, section, Points(z0), self.analyses())

    def _check_map(self, system: System) -> None:
        """Refuse options that a map does not have."""
        run = {option(name): getattr(self.options, name) for name in ("scheme", "step", "accuracy")}
        check_given(system, "a time", "a map is iterated as it is", **run)
        if self.scan is not None:
            raise OptionError.of("{scan} takes random starts of a section, which a map does not have")
        if self.poincare is not None:
            late = {option("max_time"): self.poincare.max_time}
            check_given(system, "a time", "the crossings of a map are its iterates", **late)

    def _scan(self, system: System, scan: Scan) -> JobPlan:
        """Return the plan of a scan."""
        if isinstance(self.initial_conditions, InitialConditions) and self.initial_conditions.by_name:
            text = "{scan} takes random starts of a section ({orbits}), not {axes}, {at_rest} or {microcanonical}"
            raise OptionError.of(text)
        if (
            not isinstance(self.initial_conditions, InitialConditions)
            or self.initial_conditions.grid is not None
            or self.initial_conditions.file is not None
        ):
            share = "the share of random points is that of the section's area"
            raise OptionError.of("{scan} takes random starts ({orbits}), not {grid}: {share}", share=share)
        if None in self.initial_conditions.ranges() and any(self.initial_conditions.ranges()):
            raise OptionError.of("with {scan} give both of {q_range} and {p_range}, or none")
        cases = Cases(scan.parsed(system))
        work = ScanOfChaos(cases, self.energy_surface, self.initial_conditions, self.chaos_map or ChaosOptions())
        return JobPlan(system, self.energy_surface.section_of(system), cases, {"chaotic_fraction": work})

    def tables(self) -> dict[str, Any]:
        """Return the job as tables of plain values.

        Returns
        -------
        dict
            Fields that differ from their defaults, by table.
        """
        found: dict[str, Any] = {} if self.chunk is None else {"chunk": self.chunk}
        for name, kind in TABLES.items():
            value = getattr(self, name)
            if isinstance(value, kind):
                given = {
                    entry.name: getattr(value, entry.name)
                    for entry in fields(kind)
                    if entry.default is MISSING or repr(getattr(value, entry.name)) != repr(entry.default)
                }
                if given or name in ANALYSES:
                    found[name] = given
            elif value is not None:
                found[name] = {"value": distinct(value) if name == "model" else f"{np.shape(value)[1]} orbits"}
        return found

    def text(self) -> str:
        """Return the job as TOML.

        Returns
        -------
        str
            The text. Models and initial conditions that TOML cannot describe are only named.
        """
        lines = []
        for name, value in self.tables().items():
            if isinstance(value, dict):
                lines += ["", f"[{name}]", *(f"{key} = {_toml(entry)}" for key, entry in value.items())]
            else:
                lines.append(f"{name} = {_toml(value)}")
        return "\n".join(lines).lstrip("\n") + "\n"

    @classmethod
    def parsed(cls, text: str, name: str = "job", **own: Any) -> Job:
        """Return the job of a TOML text.

        Parameters
        ----------
        text : str
            The text.
        name : str, default "job"
            Name of the file, for messages.
        **own : Any
            ``model`` or ``initial_conditions`` that TOML cannot describe.

        Returns
        -------
        Job
            The job.

        Raises
        ------
        TypeError, ValueError
            If the text is wrong. The message names file, table and key.
        """
        with spelled(as_key):
            try:
                return cls(**{**_parsed(text, own), **own})
            except tomllib.TOMLDecodeError as problem:
                raise OptionError(f"{name} is no TOML: {in_one_line(str(problem))}") from None
            except RecursionError:
                raise OptionError(f"{name} has tables or lists within one another, too many to read") from None
            except (ValueError, TypeError) as problem:
                kind = TypeError if isinstance(problem, TypeError) else OptionError
                raise kind(f"{name}: {in_one_line(respelled(str(problem), OPTIONS))}") from None

    @classmethod
    def read(cls, path: Any, **own: Any) -> Job:
        """Return the job of a TOML file.

        Parameters
        ----------
        path : path_like
            The file.
        **own : Any
            ``model`` or ``initial_conditions`` that TOML cannot describe.

        Returns
        -------
        Job
            The job.

        Raises
        ------
        OSError
            If the file cannot be read.
        TypeError, ValueError
            If the text is wrong. The message names file, table and key.
        """
        try:
            text = text_of(path, "job")
        except UnicodeDecodeError as problem:
            raise OptionError(f"{path} is no text: {problem}") from None
        except FileNotFoundError:
            raise FileNotFoundError(f"{path} does not exist") from None
        return cls.parsed(text, str(path), **own)


TABLES: dict[str, type[Any]] = {
    "model": Model,
    "energy_surface": EnergySurface,
    "initial_conditions": InitialConditions,
    "options": RunOptions,
    **ANALYSES,
    "scan": Scan,
}
"""Tables of a job."""

OPTIONS = frozenset(entry.name for kind in TABLES.values() for entry in fields(kind))
"""Names of all their options."""


def as_key(name: str, table: str = "") -> str:
    """Name an option as a job's file does, with its table if only one has it: [energy_surface] energy."""
    homes = [table] if table else [home for home, kind in TABLES.items() if name in _hints(kind)]
    return f"[{homes[0]}] {name}" if len(homes) == 1 else name


def in_one_line(text: str, length: int = 600) -> str:
    """Return a sentence without its line breaks and other signs that move a cursor, short."""
    line = "".join(sign if sign.isprintable() else " " for sign in text)
    return line if len(line) <= length else line[: length - 4] + " ..."


def distinct(model: Any) -> str:
    """Return the text that tells a model of one's own from others: its class and numbers."""
    return re.sub(r" at 0x[0-9a-fA-F]+", "", repr(model))


def difference(old: Job, new: Job) -> str | None:
    """Return the first field in which two jobs would not give the same numbers, with both values; None where there is
    none.
    """
    one, other = ({**job.tables(), "chunk": None} for job in (old, new))
    for name in dict.fromkeys([*one, *other]):
        if (name in one) != (name in other):
            return f"[{name}] is {'not in the job' if name in one else 'new in the job'}"
        if name == "chunk":
            continue
        a = one[name]
        b = other[name]
        for key in dict.fromkeys([*a, *b]):
            if key != "threads" and a.get(key) != b.get(key):
                return f"[{name}] {key} was {_said(a, key)}, is {_said(b, key)}"
    return None


def _check_analysis(name: str, analysis: Analysis, run: RunOptions) -> None:
    """Check the options of an analysis; messages name its table, because several have a time."""
    try:
        analysis.check(run)
    except OptionError:
        raise
    except (ValueError, TypeError) as problem:
        word, _, rest = str(problem).partition(" ")
        known = word in _hints(type(analysis))
        raise type(problem)(f"{option(word, name)} {rest}" if known else str(problem)) from None


def _said(table: dict[str, Any], key: str) -> str:
    return repr(table[key]) if key in table else "left open"


def _hints(kind: Any) -> dict[str, Any]:
    hints = typing.get_type_hints(kind)
    return {entry.name: hints[entry.name] for entry in fields(kind)}


def _parsed(text: str, own: dict[str, Any]) -> dict[str, Any]:
    data = tomllib.loads(text)
    found: dict[str, Any] = {}
    for name, value in data.items():
        if name in own:
            continue
        if name == "chunk":
            found[name] = value
            continue
        kind = TABLES.get(name)
        if kind is None:
            homes = [f"[{table}] {name}" for table, other in TABLES.items() if name in _hints(other)]
            if homes and not isinstance(value, dict):
                raise OptionError(f"a key stands above its table: {' or '.join(homes)}")
            raise OptionError(f"[{name}] is no table of a job{_near(name, [*TABLES, 'chunk'])}")
        if not isinstance(value, dict):
            raise TypeError(f"{name} must be a table, [{name}] with keys below it, got {shown(value)}")
        if "value" in value and name in ("model", "initial_conditions"):
            raise OptionError(
                f"[{name}] is a user-defined value, {value['value']}, that no text describes. Pass {name}=..."
            )
        found[name] = _table(name, value)
    return found


def _table(name: str, value: dict[str, Any]) -> Any:
    """Return a table of a job from plain values by key."""
    hints = _hints(TABLES[name])
    for key in value:
        if key not in hints:
            raise OptionError(f"[{name}] has no key {key}{_near(key, list(hints))}")
    try:
        return TABLES[name](**{key: _taken(option(key, name), entry, hints[key]) for key, entry in value.items()})
    except TypeError as problem:
        if "missing" in str(problem):
            absent = str(problem).rpartition(": ")[2]
            raise OptionError(f"[{name}] needs {absent}") from None
        raise


def _near(name: str, names: list[str]) -> str:
    return f".{did_you_mean(name, names)} It takes {', '.join(names)}."


def _taken(name: str, value: Any, hint: Any) -> Any:
    """Return a value as the field takes it: lists and tables stand for texts with colons and commas, texts such as 1/6
    and whole numbers for floats; refuse one of another kind.
    """
    kinds = _kinds(hint)
    value = value.tolist() if isinstance(value, np.ndarray) else value
    if float in kinds and isinstance(value, str):
        return number(name, value)
    if str in kinds and not isinstance(value, str) and not hasattr(value, "_fields"):
        if isinstance(value, int) and not isinstance(value, bool) and int not in kinds:
            return f"{value:+d}" if name.endswith("direction") else str(value)
        if isinstance(value, (list, tuple)) and value and all(isinstance(entry, str) for entry in value):
            return ",".join(value)
        if isinstance(value, (list, tuple)) and value and all(type(entry) in (int, float) for entry in value):
            return ("x" if name.endswith("grid") else ":").join(map(repr, value))
    if list[str] in kinds and isinstance(value, dict):
        return [f"{key}={entry if isinstance(entry, str) else repr(entry)}" for key, entry in value.items()]
    for kind in kinds:
        if kind is float and isinstance(value, (int, float, np.floating, np.integer)) and not isinstance(value, bool):
            return _finite(name, value)
        if kind is int and isinstance(value, (int, np.integer)) and not isinstance(value, bool):
            return int(value)
        if kind is str and isinstance(value, str):
            return _writable(name, value)
        if kind in (bool, type(None)) and isinstance(value, kind):
            return value
        if kind == list[str] and isinstance(value, (list, tuple)) and all(isinstance(entry, str) for entry in value):
            return [_writable(name, entry) for entry in value]
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "a text", list[str]: "texts"}
    takes = " or ".join(words[kind] for kind in kinds if kind is not type(None))
    instead = ", such as x=0; poincare_map takes objects" if name.endswith("section") else ""
    raise TypeError(f"{name} must be {takes}{instead}, got {shown(value)}")


def _kinds(hint: Any) -> tuple[Any, ...]:
    """Return the kinds of value that a field takes; None may be among them."""
    return (hint,) if typing.get_origin(hint) is list else typing.get_args(hint) or (hint,)


def _writable(name: str, value: str) -> str:
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{name} must be text that can be written to a file, got {shown(value)}") from None
    return str(value)


def _finite(name: str, value: Any) -> float:
    with contextlib.suppress(OverflowError):
        if np.isfinite(finite := float(value)):
            return finite
    raise ValueError(f"{name} must be finite, got {shown(value)}")


def _toml(value: Any) -> str:
    """Return a plain value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return repr(value)
