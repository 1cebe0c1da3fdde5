"""The options of the command line: those of jobs, by flags, and those of the output."""

from __future__ import annotations

import contextlib
import errno
import importlib.util
import math
import os
import tempfile
import typing
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ..core.names import named
from ..core.numbers import listed, shown
from ..core.placing import write_atomically
from ..core.sizes import bytes_of
from ..jobs.analyses import ChaosOptions, FrequencyOptions, PoincareOptions, RunOptions
from ..jobs.job import OPTIONS, Job
from ..jobs.launch import InitialConditions
from ..jobs.system import EnergySurface, Model
from ..jobs.wording import OptionError, as_flag, respelled, spelled
from ..systems.formulas.number import number
from .stops import say

try:
    import cyclopts
    import rich
    from cyclopts import Group, Parameter
except ImportError:  # `main` says so in one line
    cyclopts = rich = None  # type: ignore[assignment]

    def Group(*_: Any, **__: Any) -> None:  # type: ignore[no-redef]
        """Stand in for cyclopts."""

    def Parameter(*_: Any, **__: Any) -> Any:  # type: ignore[no-redef]
        """Stand in for cyclopts."""
        return lambda options: options


HELP = """Compute Poincaré sections, frequency maps and chaos maps of many orbits.

Commands that compute use all cores, draw a PNG and write an .npz file with the numbers, all parameters, versions and
the seed; `fastaff.load` reads it. Ctrl-C, SIGTERM or SIGHUP stops within a second and keeps finished results.
Exit codes: 0 for success, 1 if `doctor` finds a fault, 2 for wrong input, 130 after a stop, 141 after a closed pipe.

Large grids are jobs: `--write-job map.toml` writes one, `fastaff run map.toml` computes it into a store, and
`fastaff resume map.zarr` resumes it, here or on other machines.

Start with one of

- `fastaff demo`
- `fastaff poincare --energy 1.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff poincare --model henon-heiles --energy 0.125 --orbits 200`
- `fastaff frequency-map --model hyperelastic --energy 3.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff chaos-map --energy 1.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff chaos-map --p-eta 0.3 --p-gamma 0.2 --scan energy=0.5:3:11`
- `fastaff spectrum --model hyperelastic`
- `fastaff frequency-map --energy 1.5 --grid 400x400 --write-job map.toml`, then `fastaff run map.toml`

Numbers may be fractions and formulas: `--energy 1/6`, `--p-eta pi/10`. `fastaff --install-completion` teaches bash, zsh
or fish to complete commands and options; `fastaff doctor` checks the installation.
"""
FORMATS = (".png", ".pdf", ".svg")
"""Endings of figures."""
REFUSED = (".jpg", ".jpeg", ".gif", ".eps", ".ps", ".tif", ".tiff", ".webp", ".bmp", ".mp4", ".html")
"""Endings that figures of the commands don't have: no part of a name."""
WHAT, WHERE, STARTS, HOW, WRITTEN = (
    Group(name, sort_key=k)
    for k, name in enumerate(("Body", "Energy surface and section", "Starting points", "Computation", "Output"))
)


_GROUPS = {
    Model: WHAT,
    EnergySurface: WHERE,
    InitialConditions: STARTS,
    RunOptions: HOW,
    PoincareOptions: HOW,
    FrequencyOptions: HOW,
    ChaosOptions: HOW,
}
for _options, _group in _GROUPS.items():
    Parameter(name="*", group=_group, name_transform=lambda name: name.replace("_", "-"))(_options)


@Parameter(name="*", group=WRITTEN)
@dataclass(frozen=True, kw_only=True)
class Output:
    """The files to write."""

    out: Path | None = None
    """Folder, or path with or without the ending of the figure: .png, .pdf or .svg. The endings are added, and a number
    if the files exist. [fastaff-poincare, fastaff-frequency-map, ...]
    """
    overwrite: bool = False
    """Replace existing files instead of numbering the new ones."""
    no_figure: bool = False
    """Write the data only."""

    @property
    def ending(self) -> str:
        """Ending of the figure's file."""
        ending = self.out.suffix.lower() if self.out is not None else ""
        return ending if ending in FORMATS else ".png"

    def stem(self, default: str) -> Path:
        """Return the path without ending and number; in a folder that exists, the default there."""
        stem = self.out or Path(default)
        if stem.suffix.lower() in REFUSED:
            raise OptionError(f"--out {stem}: figures are {listed(FORMATS)}")
        stem = stem / default if stem.is_dir() else stem
        stem = stem.with_suffix("") if stem.suffix.lower() in (".npz", *FORMATS) else stem
        if not stem.parent.is_dir():
            raise OptionError(f"--out {stem}: the folder {stem.parent} does not exist")
        try:
            os.stat(stem.with_name(f"{stem.name}-999{self.ending}"))  # with the number that it may get
        except OSError as problem:
            if problem.errno == errno.ENAMETOOLONG:
                raise OptionError(f"--out {shown(str(stem), 60)}: the name is too long") from None
        try:
            tempfile.TemporaryFile(dir=stem.parent).close()
        except OSError as problem:
            raise OptionError(f"--out {stem}: the folder {stem.parent} cannot be written: {problem.strerror}") from None
        return stem

    def check(self) -> None:
        """Refuse a figure where matplotlib is missing."""
        if not self.no_figure and importlib.util.find_spec("matplotlib") is None:
            raise ModuleNotFoundError("matplotlib", name="matplotlib")

    def save(self, stem: Path, result: Any, facts: dict[str, Any]) -> Path:
        """Write the data with all facts about them, under a number that is free for the figure too. If that fails,
        write them elsewhere and say so.
        """
        from ..exchange.files import save_among

        own = {entry.name for entry in fields(result)}
        facts = {name: value for name, value in facts.items() if name not in own or name in ("section", "time")}
        beside = () if self.no_figure else (self.ending,)
        try:
            return save_among(stem, ".npz", result, parameters=facts, beside=beside, overwrite=self.overwrite)
        except OSError as problem:
            for folder in (Path.cwd, Path.home, tempfile.gettempdir):
                with contextlib.suppress(OSError, RuntimeError):  # there may be no such folder
                    elsewhere = Path(folder()) / stem.name
                    path = save_among(elsewhere, ".npz", result, parameters=facts, beside=beside, overwrite=False)
                    say(f"{stem}.npz cannot be written: {problem.strerror or problem}; the results are in {path}")
                    return path
            raise


@Parameter(name="*", group=WRITTEN)
@dataclass(frozen=True, kw_only=True)
class FigureOptions:
    """How orbits are coloured."""

    colour: str | None = None
    """The quantity that colours the orbits: an indicator such as sali or megno, diffusion, a ratio of frequencies such
    as beta/alpha, or another column such as energy_error. It is computed if needed. [diffusion; the
    indicators and the classification]
    """
    vmin: float | None = None
    """Lower end of the colour scale. [fixed by the threshold of the indicator]"""
    vmax: float | None = None
    """Upper end of the colour scale."""

    def check(self) -> None:
        """Refuse ends of the colour scale that are not finite or not in order."""
        for name in ("vmin", "vmax"):
            if not math.isfinite(getattr(self, name) or 0.0):
                raise OptionError(f"--{name} must be a finite number, got {getattr(self, name)}")
        if self.vmin is not None and self.vmax is not None and not self.vmin < self.vmax:
            raise OptionError(f"--vmin must be below --vmax, got {self.vmin:g} and {self.vmax:g}")

    @property
    def given(self) -> bool:
        """Whether anything is asked for."""
        return self != type(self)()


@Parameter(name="*", group=WRITTEN)
@dataclass(frozen=True, kw_only=True)
class OutputFiles(Output):
    """The files to write of orbits: a job too."""

    write_job: Path | None = None
    """Write these options as a job (TOML) to this file, for `fastaff run`, and compute nothing."""

    def wrote(self, job: Job) -> bool:
        """Write the job where that is asked for, and tell."""
        if self.write_job is None:
            return False
        path = self.write_job
        text = job.text()
        if not path.parent.is_dir():
            raise OptionError(f"--write-job {path}: the folder {path.parent} does not exist")
        if path.exists() and not self.overwrite:
            raise OptionError(f"--write-job {path} exists; --overwrite replaces it")
        if path.exists() and not path.is_file():  # such as /dev/stdout
            path.write_text(text, encoding="utf-8")
        else:
            stem = path.with_suffix("")
            path = write_atomically(
                stem, path.suffix, lambda name: name.write_text(text, encoding="utf-8"), overwrite=self.overwrite
            )
        print(path)
        return True


@Parameter(name="*", group=HOW)
@dataclass(frozen=True, kw_only=True)
class Workers:
    """Who computes the chunks of a job."""

    threads: int | None = None
    """Threads of a chunk. [all cores; 1 with --workers or --dask]"""
    workers: int | None = None
    """Processes on this machine that compute chunks side by side, instead of one after the other."""
    dask: str | None = None
    """Address of a dask scheduler whose workers compute the chunks; they must reach the store by the same path."""
    allow_other_cpu: bool = False
    """Resume a store that was begun on another type of processor, although the last digits may differ."""

    def check(self) -> None:
        """Refuse numbers below 1, and two kinds of workers."""
        for name in ("threads", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise OptionError(f"--{name} must be at least 1, got {value}")
        if self.workers is not None and self.dask is not None:
            raise OptionError("give --workers or --dask, not both")


@Parameter(name="*", group=WRITTEN)
@dataclass(frozen=True, kw_only=True)
class LogOptions:
    """The messages while a job runs."""

    quiet: bool = False
    """Print only errors: no progress, no table."""
    log: str | None = None
    """json: a line of JSON for each finished chunk and one at the end, on standard output, instead of bar and table."""

    def check(self) -> None:
        """Refuse other logs, and one that is to be quiet."""
        if self.log is not None:
            named("--log", self.log, ("json",))
            if self.quiet:
                raise OptionError("give --quiet or --log, not both")


def converted(kind: Any, tokens: Any) -> Any:
    """Return the value of an option: numbers such as 1/6 and pi/2 too, whole ones such as 1e4."""
    kinds = (kind, *typing.get_args(kind))
    if float in kinds:
        return number("it", tokens[-1].value)
    if int in kinds:
        count = number("it", tokens[-1].value)
        if count != math.floor(count):
            raise ValueError(f"it must be a whole number, got {shown(tokens[-1].value)}")
        return int(count)
    return cyclopts.convert(kind, tokens)


def given(options: Any) -> list[str]:
    """Return the flags of the options that differ from their defaults, as a user would type them."""
    flags: list[str] = []
    for entry in fields(options):
        value = getattr(options, entry.name)
        if value != entry.default:
            flags += [as_flag(entry.name), *([] if value is True else [str(value)])]
    return flags


def size_of(text: str | None) -> float | None:
    """Return the bytes that a text such as 500MB, 2GiB or 1e9 stands for."""
    try:
        return None if text is None else bytes_of("--memory", text)
    except ValueError as problem:
        raise OptionError(str(problem)) from None


def pair(takes: str, text: str) -> tuple[float, float]:
    """Return the two finite numbers of a text such as 0.7,0.1; the error of another text names the right form."""
    try:
        first, second = map(float, text.split(","))
        if not (math.isfinite(first) and math.isfinite(second)):
            raise ValueError
    except ValueError:
        raise OptionError(f"{takes}, got {shown(text)}") from None
    return first, second


def job_of(**tables: Any) -> Job:
    """Return the job that options describe; errors name the flags."""
    with spelled(as_flag):
        try:
            return Job(**tables)
        except (ValueError, TypeError) as problem:
            raise OptionError(respelled(str(problem), OPTIONS)) from None
