"""The command line: `fastaff poincare`, `frequency-map`, `demo`, `warmup`, `doctor` (layer L5).

Parsing and help by cyclopts, progress by rich; matplotlib is imported when there is something to draw. Orbits run
in batches of a fraction of a second, which is what lets Ctrl-C stop at once; orbits do not know of each other, so batches do
not change a bit of them.
"""

from __future__ import annotations

import difflib
import math
import os
import platform
import signal
import sys
import threading
import time as clock
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

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


EXIT_WRONG_INPUT, EXIT_INTERRUPTED = 2, 130
BATCH_SECONDS = 0.3
PATIENCE = 0.9
"""Seconds after Ctrl-C that the batch under way may take before it is given up."""
COMMANDS = ("demo", "poincare", "frequency-map", "warmup", "doctor")
COMPILE_SECONDS = {"poincare": 20, "frequency-map": 40}
NO_EXTRAS = 'fastaff: the command line needs cyclopts and rich, figures need matplotlib: pip install "fastaff[demo]"'

MODELS = {
    "harmonic": ("Harmonic", ("C",)),
    "anharmonic": ("Anharmonic", ("C",)),
    "hyperelastic": ("Hyperelastic", ("C",)),
    "heavy-top": ("HeavyTop", ("C", "A")),
    "neo-hookean": ("NeoHookean", ("G", "K")),
    "henon-heiles": ("HenonHeiles", ("lam",)),
}
SECTIONS = ("alpha-turning", "beta-turning", "alpha=c", "beta=c", "area=c", "x=c", "y=c")


class Wrong(ValueError):
    """Wrong input: its text is all that the user sees."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 2 for wrong input, 130 after Ctrl-C."""
    try:
        code = _run(sys.argv[1:] if arguments is None else arguments)
    except KeyboardInterrupt:
        _say("stopped by Ctrl-C; nothing was computed yet, nothing is kept")
        code = EXIT_INTERRUPTED
    if arguments is None:
        sys.exit(code)
    return code


def _run(arguments: list[str]) -> int:
    if cyclopts is None:
        print(NO_EXTRAS, file=sys.stderr)
        return EXIT_WRONG_INPUT
    try:
        return int(_app()(arguments, exit_on_error=False, print_error=False, result_action="return_value") or 0)
    except cyclopts.CycloptsError as problem:
        command = [word for word in arguments[:1] if word in COMMANDS]
        _say(f"error: {_one_line(problem)}  ({' '.join(['fastaff', *command, '--help'])})")
    except ModuleNotFoundError as problem:
        if (problem.name or "").partition(".")[0] not in ("matplotlib", "cyclopts", "rich"):
            raise
        print(NO_EXTRAS, file=sys.stderr)
    except (ValueError, TypeError, OSError) as problem:
        _say(f"error: {_one_line(problem)}")
    return EXIT_WRONG_INPUT


def _one_line(problem: BaseException) -> str:
    return " ".join(str(problem).split())


def _say(text: str) -> None:
    print(f"fastaff: {text}", file=sys.stderr, flush=True)


def _app() -> Any:
    from . import __version__

    app = cyclopts.App(
        name="fastaff", version=__version__, help_format="markdown", suppress_keyboard_interrupt=False, help=HELP,
        default_parameter=Parameter(negative="", show_default=False),
    )  # fmt: skip
    for name, command in zip(COMMANDS, (demo, poincare, frequencies, warmup, doctor), strict=True):
        app.command(command, name=name)
    return app


HELP = """Poincaré sections and frequency maps of planar affinely-rigid bodies.

Each command computes many orbits on all cores, draws a PNG and writes an .npz file with the numbers, all
parameters, versions and the seed (read it with `fastaff.files.load`). Ctrl-C stops within a second and keeps
what is finished. Exit codes: 0, 2 for wrong input, 130 after Ctrl-C.

Start with one of

- `fastaff demo`
- `fastaff poincare --energy 1.5 --p-eta 0.3 --p-gamma 0.2`
- `fastaff poincare --model henon-heiles --energy 0.125 --orbits 200`
- `fastaff frequency-map --model hyperelastic --energy 3.5 --p-eta 0.3 --p-gamma 0.2`
"""
WHAT, WHERE, STARTS, HOW, WRITTEN = (
    Group(name, sort_key=k)
    for k, name in enumerate(("Body", "Energy surface and section", "Starting points", "Computation", "Output"))
)


@Parameter(name="*", group=WHAT)
@dataclass(frozen=True, kw_only=True)
class Model:
    """The body."""

    model: str = "neo-hookean"
    """harmonic, anharmonic, hyperelastic (parameter C), heavy-top (C, A), neo-hookean (G, K), henon-heiles (lam). [neo-hookean]"""
    C: Annotated[float | None, Parameter(name="--C")] = None
    """Stiffness of harmonic, anharmonic, hyperelastic and heavy-top [1]."""
    A: Annotated[float | None, Parameter(name="--A")] = None
    """Strength of the heavy top's cos(vartheta) term [1]."""
    G: Annotated[float | None, Parameter(name="--G")] = None
    """Shear modulus of neo-hookean [1]."""
    K: Annotated[float | None, Parameter(name="--K")] = None
    """Bulk modulus of neo-hookean [2]."""
    lam: float | None = None
    """Coupling of henon-heiles [1]."""
    mu: float = 1.0
    """Inertia of a body. [1]"""

    def build(self) -> Any:
        """Return the model, refusing parameters that it does not have."""
        import fastaff

        key = _named("--model", self.model.lower().replace("_", "-"), tuple(MODELS))
        kind, names = MODELS[key]
        given = {name: getattr(self, name) for name in ("C", "A", "G", "K", "lam") if getattr(self, name) is not None}
        for name in given:
            if name not in names:
                raise Wrong(f"--{name} is not a parameter of {key}, which has {', '.join('--' + n for n in names)}")
        value = getattr(fastaff, kind)(**given)
        return value if key == "henon-heiles" else fastaff.Body(value, self.mu)


@Parameter(name="*", group=WHERE)
@dataclass(frozen=True, kw_only=True)
class Surface:
    """Where the orbits live."""

    energy: float | None = None
    """Energy of every orbit. Required."""
    p_eta: float = 0.0
    """Angular momentum in the plane a, |a| = alpha = (D1 + D2)/sqrt(2). [0]"""
    p_gamma: float = 0.0
    """Angular momentum in the plane b, |b| = beta = (D1 - D2)/sqrt(2). [0]"""
    section: str | None = None
    """alpha-turning (p_alpha = 0), beta-turning, alpha=c, beta=c, area=c (D1 D2 = c), x=c or y=c for
    henon-heiles, with c a number. [alpha-turning; x=0]"""
    direction: str = "+1"
    """Crossings where the section function increases (+1), decreases (-1) or both (0). [+1]"""

    def build(self, body: Any) -> Any:
        """Return the section."""
        import fastaff

        if self.energy is None:
            raise Wrong("--energy is required: the energy of every orbit, for example --energy 1.5")
        plane = not isinstance(body, fastaff.Body)
        text = self.section or ("x=0" if plane else "alpha-turning")
        if self.direction.lstrip("+") not in ("1", "-1", "0"):
            raise Wrong(f"--direction must be +1, -1 or 0, got {self.direction}")
        direction = int(self.direction)
        name, equals, constant = text.lower().partition("=")
        form = _named("--section", name + "=c" if equals else name, SECTIONS)
        if equals:
            try:
                value = float(constant)
            except ValueError:
                raise Wrong(f"--section {name}=c needs a number for c, got {constant!r}") from None
        if plane != (form in ("x=c", "y=c")):
            suits = "x=c, y=c" if plane else ", ".join(SECTIONS[:5])
            raise Wrong(f"--section {text} does not suit {type(body).__name__}; it takes {suits}")
        if plane:
            normal = (1.0, 0.0, 0.0, 0.0) if form == "x=c" else (0.0, 1.0, 0.0, 0.0)
            return fastaff.Linear(normal, value, direction)
        if not equals:
            return (fastaff.AlphaTurning if form == "alpha-turning" else fastaff.BetaTurning)(direction)
        kinds = {"alpha=c": fastaff.AlphaEquals, "beta=c": fastaff.BetaEquals, "area=c": fastaff.AreaEquals}
        return kinds[form](value, direction)


@Parameter(name="*", group=STARTS)
@dataclass(frozen=True, kw_only=True)
class Starts:
    """Where the orbits start."""

    grid: str | None = None
    """Cells N1xN2 over the section's coordinate and its momentum; cells beyond the energy are left out. [20x20 or 40x40]"""
    orbits: int | None = None
    """Random starts, uniform over the accessible part of the section, instead of a grid."""
    seed: int = 0
    """Seed of the random starts. [0]"""
    range1: str | None = None
    """Range LOW:HIGH of the section's coordinate. [all that the energy allows]"""
    range2: str | None = None
    """Range LOW:HIGH of its momentum. [all that the energy allows]"""

    def build(self, body: Any, section: Any, surface: Surface, default: str) -> tuple[Any, Any, Any]:
        """Return the grid of starts, with all its cells or a random choice, the edge of the section, and the chosen z0."""
        import fastaff

        from . import plot

        if self.grid is not None and self.orbits is not None:
            raise Wrong("give --grid or --orbits, not both")
        if self.orbits is not None and self.orbits < 1:
            raise Wrong(f"--orbits must be at least 1, got {self.orbits}")
        ranges: list[Any] = [_range(name, text) for name, text in (("--range1", self.range1), ("--range2", self.range2))]
        where: dict[str, Any] = {"energy": surface.energy, "p_eta": surface.p_eta, "p_gamma": surface.p_gamma}
        edge = None
        try:
            edge = plot.edge(body, section, **where)
            ranges = [given or found for given, found in zip(ranges, edge.axes)]
        except ValueError as problem:
            if None in ranges:
                raise Wrong(f"{problem}; or give --range1 and --range2") from None
        n1, n2 = (300, 300) if self.orbits is not None else _cells(self.grid or default)
        # Cell centres: the ends of the range are the edge itself.
        axes = [low + (high - low) * (np.arange(n) + 0.5) / n for (low, high), n in zip(ranges, (n1, n2))]
        grid = fastaff.energy_grid(body, section=section, axes=axes, **where)
        z0 = grid.z0
        if self.orbits is not None:
            cells = z0.shape[1]
            chosen = np.random.default_rng(self.seed).choice(cells, size=self.orbits, replace=self.orbits > cells)
            z0 = np.ascontiguousarray(z0[:, chosen])
        return grid, edge, z0


@Parameter(name="*", group=HOW)
@dataclass(frozen=True, kw_only=True)
class Run:
    """How to integrate."""

    scheme: str = "KAHAN_LI8"
    """LEAPFROG, YOSHIDA4, BLANES_MOAN6, KAHAN_LI8, SOFRONIOU_SPALETTA10, RK4, DOP853 (adaptive). [KAHAN_LI8]"""
    step: float | None = None
    """Fixed step. [chosen by a short trial for an energy error of 1e-11]"""
    threads: int | None = None
    """Threads. [all cores]"""

    def build(self, body: Any, z0: np.ndarray) -> dict[str, Any]:
        """Return the options of the library's functions, with the step chosen once for all batches."""
        from .engine import make_flow
        from .schemes import scheme_named

        scheme = scheme_named(self.scheme.replace("-", "_"))
        flow = make_flow(body, z0, scheme, self.step, 1e-12, 1e-12, self.threads)
        return {"scheme": scheme, "step": flow.step if math.isfinite(flow.step) else None, "threads": flow.threads}


@Parameter(name="*", group=WRITTEN)
@dataclass(frozen=True, kw_only=True)
class Output:
    """What is written."""

    out: Path | None = None
    """Path without ending; .npz and .png are added, and a number where they exist. [fastaff-poincare, fastaff-frequency-map]"""
    force: bool = False
    """Replace existing files instead of numbering the new ones."""
    no_figure: bool = False
    """Write the data only."""

    def stem(self, default: str) -> Path:
        """Return the path without ending under which nothing exists yet."""
        from .files import free_stem

        stem = self.out or Path(default)
        stem = stem.with_suffix("") if stem.suffix in (".npz", ".png") else stem
        if not stem.parent.is_dir():
            raise Wrong(f"--out {stem}: the folder {stem.parent} does not exist")
        return stem if self.force else free_stem(stem, (".npz", ".png"))


def _named(option: str, given: str, names: tuple[str, ...]) -> str:
    if given in names:
        return given
    near = difflib.get_close_matches(given, names, n=1, cutoff=0.5)
    raise Wrong(f"{option} must be one of {', '.join(names)}, got {given!r}." + (f" Did you mean {near[0]}?" if near else ""))


def _range(option: str, text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    low, colon, high = text.partition(":")
    try:
        ends = (float(low), float(high))
        if not (colon and math.isfinite(ends[0]) and math.isfinite(ends[1]) and ends[0] < ends[1]):
            raise ValueError
    except ValueError:
        raise Wrong(f"{option} must be LOW:HIGH with LOW < HIGH, for example 0.1:1.2, got {text!r}") from None
    return ends


def _cells(text: str) -> tuple[int, int]:
    first, cross, second = text.lower().partition("x")
    try:
        n1, n2 = int(first), int(second if cross else first)
        if n1 < 1 or n2 < 1:
            raise ValueError
    except ValueError:
        raise Wrong(f"--grid must be N1xN2 with whole numbers of at least 1, for example 40x40, got {text!r}") from None
    return n1, n2


class Batches:
    """Orbits computed batch by batch, with progress, and what is finished in hand at any moment."""

    def __init__(self, title: str, z0: np.ndarray, compute: Any, threads: int, keep: Any):
        self.title, self.z0, self.compute, self.threads, self.keep = title, z0, compute, threads, keep
        self.parts: list[Any] = []
        self.done = 0
        self.interrupted = False
        self._saving = threading.Lock()

    def run(self) -> Any:
        """Return the joined result; after Ctrl-C keep what is finished and leave with exit code 130."""
        before = signal.getsignal(signal.SIGINT)
        ours = threading.current_thread() is threading.main_thread()
        if ours:
            signal.signal(signal.SIGINT, self._on_interrupt)
        try:
            with Progress(self.title, self.z0.shape[1]) as progress:
                self._all(progress)
        except (KeyboardInterrupt, Exception) as stopped:
            if not self.interrupted and not isinstance(stopped, KeyboardInterrupt):
                raise
            # Whatever the batch under way came to after Ctrl-C, the finished ones are kept.
            partial = getattr(stopped, "partial", None)
            with self._saving:
                self._leave([*self.parts, *([partial] if partial is not None else [])])
            raise SystemExit(EXIT_INTERRUPTED) from None
        finally:
            if ours:
                signal.signal(signal.SIGINT, before)
        return joined(self.parts)

    def _all(self, progress: Any) -> None:
        total = self.z0.shape[1]
        size = min(total, 64 * self.threads)
        while self.done < total:
            if self.interrupted:
                raise KeyboardInterrupt
            part = np.ascontiguousarray(self.z0[:, self.done : self.done + size])
            start = clock.perf_counter()
            found = self.compute(part, lambda f, n=part.shape[1]: progress(self.done + f * n))
            elapsed = max(clock.perf_counter() - start, 1e-3)
            self.parts.append(found)
            self.done += part.shape[1]
            progress(self.done)
            unit = 64 * self.threads
            size = unit * max(1, min(64, round(BATCH_SECONDS / elapsed * part.shape[1] / unit)))

    def _on_interrupt(self, *_: Any) -> None:
        """Ask the kernels to stop; if the batch under way does not in time, keep the finished ones and leave."""
        if not self.interrupted:
            self.interrupted = True
            threading.Thread(target=self._watch, daemon=True).start()
        raise KeyboardInterrupt

    def _watch(self) -> None:
        clock.sleep(PATIENCE)
        if self._saving.acquire(blocking=False):
            try:
                self._leave(list(self.parts))
            finally:
                os._exit(EXIT_INTERRUPTED)

    def _leave(self, parts: list[Any]) -> None:
        total = self.z0.shape[1]
        if not parts:
            _say(f"stopped by Ctrl-C before any of {total} orbits was finished; nothing is kept")
            return
        result = joined(parts)
        finished = int(np.count_nonzero(np.asarray(result.status) != 7))
        path = self.keep(result)
        _say(f"stopped by Ctrl-C: kept {finished} finished of {total} orbits{_crossings(result)} in {path}; no figure drawn")


def _crossings(result: Any) -> str:
    return f" ({int(result.counts.sum())} crossings)" if hasattr(result, "counts") else ""


def joined(parts: list[Any]) -> Any:
    """Join results of batches along their orbits."""
    first, changes = parts[0], {}
    for entry in fields(first):
        values = [getattr(part, entry.name) for part in parts]
        if isinstance(values[0], np.ndarray):
            orbits_last = entry.name in ("nu", "error", "method")
            changes[entry.name] = np.concatenate(values, axis=-1 if orbits_last else 0)
    return replace(first, **changes)


class Progress:
    """Bar, orbits/s and time left on a terminal; nothing elsewhere."""

    def __init__(self, title: str, total: int):
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        self.bar = Bar(
            TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:3.0f} %"),
            TextColumn("{task.fields[rate]}"), TimeRemainingColumn(compact=True), TextColumn("left"),
            console=Console(stderr=True), transient=True,
        )  # fmt: skip
        self.shown = self.bar.console.is_terminal
        self.task = self.bar.add_task(title, total=total, rate="")
        self.start = clock.perf_counter()

    def __call__(self, orbits: float) -> None:
        rate = orbits / max(clock.perf_counter() - self.start, 1e-9)
        self.bar.update(self.task, completed=orbits, rate=f"{rate:,.0f} orbits/s")

    def __enter__(self) -> Progress:
        if self.shown:
            self.bar.start()
        return self

    def __exit__(self, *_: Any) -> None:
        if self.shown:
            self.bar.stop()


def _compiled(what: str, first: Any, announce: bool = True) -> None:
    """Run `first`, the smallest case of what comes, in a thread of its own, so that Ctrl-C need not wait for the compiler."""
    failure: list[BaseException] = []
    finished = threading.Event()

    def work() -> None:
        try:
            first()
        except BaseException as problem:  # handed to the caller below
            failure.append(problem)
        finally:
            finished.set()

    before = signal.getsignal(signal.SIGINT)
    ours = threading.current_thread() is threading.main_thread()
    if ours:
        signal.signal(signal.SIGINT, _leave_the_compiler)
    try:
        threading.Thread(target=work, daemon=True).start()
        if announce and not finished.wait(0.5) and (_is_cold() or not finished.wait(1.5)):
            how_long = f"about {COMPILE_SECONDS[what]} s" if _is_cold() else "a few seconds, for a new model or section"
            _say(f"compiling once ({how_long})")
        while not finished.wait(0.1):
            pass
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)
    if failure:
        raise failure[0]


def _leave_the_compiler(*_: Any) -> None:
    # A thread inside the compiler cannot be stopped; Numba moves finished cache files into place, so none is left half written.
    _say("stopped by Ctrl-C before any orbit was finished (compiling); nothing is kept")
    sys.stderr.flush()
    os._exit(EXIT_INTERRUPTED)


def _is_cold() -> bool:
    from ._jit import cache_directory

    folder = cache_directory()
    return folder is None or sum(1 for _ in folder.rglob("*.nbi")) < 10


def poincare(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Output = Output(),
    crossings: Annotated[int, Parameter(group=HOW)] = 500,
    max_time: Annotated[float | None, Parameter(group=HOW)] = None,
    no_diffusion: Annotated[bool, Parameter(group=HOW)] = False,
) -> int:
    """Draw a Poincaré section of one energy surface, coloured by the diffusion of each orbit.

    Orbits start on a grid of the section (20x20) or at random points of it. Units are those of the parameters: with G = mu = 1 or
    C = mu = 1 the unit of time is sqrt(mu/G) or sqrt(mu/C).

    Parameters
    ----------
    crossings
        Crossings wanted from each orbit. [500]
    max_time
        Time at which an orbit ends whatever it does. [four times what the crossings need in a trial]
    no_diffusion
        Do not compute the diffusion; draw in one colour.
    """
    import fastaff

    from . import plot

    body = options.build()
    section = surface.build(body)
    _, edge, z0 = starts.build(body, section, surface, "20x20")
    stem = output.stem("fastaff-poincare")
    _needs_matplotlib(output)
    fixed: dict[str, Any] = {"section": section, "crossings": crossings}
    if max_time is not None:
        fixed["max_time"] = max_time
    span: dict[str, Any] = {} if no_diffusion else {"method": "naff"}

    def smallest() -> None:
        scheme, step = fastaff.scheme_named(run.scheme.replace("-", "_")), run.step or 0.02
        few: dict[str, Any] = {"scheme": scheme, "step": step, "threads": run.threads}
        fastaff.poincare_map(body, z0[:, :1], section=section, crossings=1, max_time=max_time or 20.0, **few)
        if span:
            fastaff.frequency_map(body, z0[:, :1], time=5.0, **span, **few)

    # The checks of the library come before the compiler.
    fastaff.boundary.whole("crossings", crossings, 1)
    _compiled("poincare", smallest)
    choices = run.build(body, z0)
    fixed.setdefault("max_time", _enough_time(body, z0, section, crossings, choices))
    period = fixed["max_time"] / 4 / crossings if max_time is None else 3.0

    facts = _facts(body, surface, section, starts, choices, z0, fixed)
    start = clock.perf_counter()

    def keep(result: Any) -> Path:
        return _saved(stem, result, output, {**facts, "wall_time": clock.perf_counter() - start, "interrupted": True})

    compute = _with(fastaff.poincare_map, body, {**fixed, **choices})
    result = Batches("section", z0, compute, choices["threads"], keep).run()
    seconds = clock.perf_counter() - start
    _say(_finished(result, seconds))
    extra: dict[str, Any] = {}
    if span:
        time = max(200.0, 400 * period)
        compute = _with(fastaff.frequency_map, body, {"time": time, **span, **choices})
        found = Batches("diffusion", z0, compute, choices["threads"], lambda _: keep(result)).run()
        extra = {"diffusion": np.where(found.status == 0, found.diffusion, np.nan), "diffusion_time": time}
    path = _saved(stem, result, output, {**facts, **extra, "wall_time": seconds, "interrupted": False})
    if not output.no_figure:
        figure, ax = _figure()
        values = extra.get("diffusion")
        norm = None if values is None else plot.diffusion_scale(values)
        drawn = plot.plot_section(result, ax=ax, values=values, boundary=edge, norm=norm)
        _finish(figure, ax, body, surface, section, f"{_counted(result.status)}; {drawn.missing} not drawn", stem, facts)
    _report_files(path, stem, output)
    return 0


def frequencies(
    *,
    options: Model = Model(),
    surface: Surface = Surface(),
    starts: Starts = Starts(),
    run: Run = Run(),
    output: Output = Output(),
    time: Annotated[float, Parameter(group=HOW)] = 1000.0,
    method: Annotated[str, Parameter(group=HOW)] = "birkhoff",
    max_order: Annotated[int, Parameter(group=WRITTEN)] = 7,
) -> int:
    """Compute the fundamental frequencies of orbits of one energy surface, and draw their map and their diffusion.

    Orbits start on a grid of the section (40x40) or at random points of it. Two panels: diffusion over the section, and the ratios of
    frequencies with the resonance lines m:n on which orbits stand. Frequencies are in cycles per unit time.

    Parameters
    ----------
    time
        Time over which frequencies are averaged, best 100 periods or more. [1000]
    method
        birkhoff (weighted averages, and NAFF where they do not converge) or naff. [birkhoff; always naff for neo-hookean]
    max_order
        Largest m + n of the resonances m:n to look for. [7]
    """
    import fastaff

    body = options.build()
    section = surface.build(body)
    grid, _, z0 = starts.build(body, section, surface, "40x40")
    method = _named("--method", method.lower(), ("birkhoff", "naff"))
    stem = output.stem("fastaff-frequency-map")
    _needs_matplotlib(output)
    fixed: dict[str, Any] = {"time": fastaff.boundary.positive("time", time), "method": method}
    inner = getattr(body, "potential", body)
    if isinstance(inner, fastaff.NeoHookean):  # its librations mix; only these loops tell them apart
        from .demo import NormalModes

        method = fixed["method"] = "naff"
        fixed["angles"] = NormalModes()

    def smallest() -> None:
        scheme = fastaff.scheme_named(run.scheme.replace("-", "_"))
        few: dict[str, Any] = {"scheme": scheme, "step": run.step or 0.02, "threads": run.threads}
        fastaff.frequency_map(body, z0[:, :1], **{**fixed, "time": 5.0}, **few)
        if method == "birkhoff":
            fastaff.frequency_map(body, z0[:, :1], time=5.0, method="naff", **few)

    _compiled("frequency-map", smallest)
    choices = run.build(body, z0)
    facts = _facts(body, surface, section, starts, choices, z0, fixed)
    start = clock.perf_counter()

    def keep(result: Any) -> Path:
        return _saved(stem, result, output, {**facts, "wall_time": clock.perf_counter() - start, "interrupted": True})

    compute = _with(fastaff.frequency_map, body, {**fixed, **choices})
    result = Batches("frequencies", z0, compute, choices["threads"], keep).run()
    seconds = clock.perf_counter() - start
    shown = np.ones(result.status.size, bool)
    if "angles" in fixed:
        from .demo import sorted_out, told_apart

        result = sorted_out(result)
        shown = told_apart(result)
    _say(_finished(result, seconds))
    path = _saved(stem, result, output, {**facts, "wall_time": seconds, "interrupted": False})
    if not output.no_figure:
        _draw_frequencies(result, shown, grid, starts, body, surface, section, max_order, stem, facts)
    _report_files(path, stem, output)
    return 0


def _draw_frequencies(result, shown, grid, starts, body, surface, section, max_order, stem, facts) -> None:
    from . import plot

    figure, ax = _figure(panels=1 if starts.orbits is not None else 2)
    axes = [ax] if starts.orbits is not None else list(ax)
    if len(axes) == 2:
        values = np.where(result.status == 0, result.diffusion, np.nan)
        plot.plot_diffusion_grid(grid, values, ax=axes[0], norm=plot.diffusion_scale(values), colorbar=False)
    first, second = result.names[:2]
    plane = result.nu_gamma is not None
    x, y = (f"{second}/{first}", f"gamma/{first}") if plane else (first, second)
    ratio = plot.frequency(result, f"{second}/{first}")
    fine = np.isfinite(ratio) & (result.status == 0) & shown
    low, high = np.quantile(ratio[fine], [0.01, 0.99]) if fine.any() else (0.0, 1.0)
    least = max(3, result.status.size // 200)
    lines = []
    for n, _, m in plot.resonances_between(low - 1e-3, high + 1e-3, max_order):
        line = (n, 0, m) if plane else (m, n, 0)
        if plot.on_line(result, line, x=x, y=y, tolerance=1e-6, shown=shown) >= least:
            lines.append(line)
    drawn = plot.plot_frequency_map(result, ax=axes[-1], x=x, y=y, lines=lines, shown=shown)
    _finish(figure, axes[-1], body, surface, section, f"{_counted(result.status)}; {drawn.missing} not drawn", stem, facts)


def demo(*, out: Path = Path("fastaff-demo"), quick: bool = False, threads: int | None = None, force: bool = False) -> int:
    """Compute and draw the demonstration: a neo-Hookean body with islands and chaos, and an integrable one beside it.

    About a minute on two cores, and about 40 s of compilation the first time.

    Parameters
    ----------
    out
        Folder for the figure and the data, made if missing. [fastaff-demo]
    quick
        A small version in seconds.
    threads
        Threads. [all cores]
    force
        Replace earlier files instead of numbering the new ones.
    """
    _needs_matplotlib(Output())
    from . import demo as demonstration

    bars: list[Progress] = []

    def meter(title: str) -> Any:
        for bar in bars:
            bar.__exit__()
        bars[:] = [Progress(title, 1)]
        bars[0].bar.columns = tuple(c for k, c in enumerate(bars[0].bar.columns) if k != 3)
        bars[0].__enter__()
        return bars[0]

    def leave(*_: Any) -> None:
        for bar in bars:
            bar.__exit__()
        _say("stopped by Ctrl-C; the demo writes its files at the end, nothing is kept")
        os._exit(EXIT_INTERRUPTED)

    ours = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGINT)
    if ours:
        signal.signal(signal.SIGINT, leave)
    if _is_cold():
        _say(f"compiling once (about {COMPILE_SECONDS['frequency-map']} s)")
    try:
        demonstration.run(out, quick, threads=threads, meter=meter, force=force)
    finally:
        for bar in bars:
            bar.__exit__()
        if ours:
            signal.signal(signal.SIGINT, before)
    return 0


def warmup() -> int:
    """Compile everything once, into the cache folder, and say how long it took.

    Needed only to keep the first command of a new version short: each compiles what it uses.
    """
    import fastaff

    from ._jit import cache_directory

    body = fastaff.Body(fastaff.NeoHookean())
    z0 = fastaff.energy_grid(body, energy=1.5, section=fastaff.AlphaTurning(), axes=([0.6, 0.7], [0.0]), p_eta=0.3, p_gamma=0.2).z0
    jobs = {
        "integrate": lambda: fastaff.integrate(body, z0, time=1.0, step=0.05, samples=2),
        "integrate, adaptive": lambda: fastaff.integrate(body, z0, time=1.0, scheme=fastaff.DOP853),
        "poincare": lambda: fastaff.poincare_map(body, z0, section=fastaff.AlphaTurning(), crossings=2, max_time=20.0, step=0.05),
        "frequency-map": lambda: fastaff.frequency_map(body, z0, time=10.0, step=0.05),
        "naff": lambda: fastaff.frequency_map(body, z0, time=10.0, step=0.05, method="naff"),
    }
    total = 0.0
    for name, job in jobs.items():
        start = clock.perf_counter()
        _compiled("frequency-map", job, announce=False)
        seconds = clock.perf_counter() - start
        total += seconds
        print(f"{name:<22}{seconds:6.1f} s", flush=True)
    print(f"{'together':<22}{total:6.1f} s, kept in {cache_directory()}")
    return 0


def doctor() -> int:
    """Say what is installed and where, and integrate one harmonic orbit as a check. Exit code 1 where the check fails."""
    import fastaff

    from . import files
    from ._jit import cache_directory, cache_root
    from .engine import default_threads

    facts = files.provenance()
    folder = cache_directory()
    size = sum(f.stat().st_size for f in cache_root().rglob("*") if f.is_file()) / 2**20 if folder else 0.0
    writable = "writable" if folder else "NOT WRITABLE (set FASTAFF_CACHE_DIR)"
    rows = [
        ("fastaff", f"{facts['fastaff']}, {Path(fastaff.__file__).parent}"),
        ("Python", f"{facts['python']}, {sys.executable}"),
        *((name, _version(name)) for name in ("numba", "numpy", "scipy", "matplotlib", "cyclopts", "rich")),
        ("machine", f"{platform.platform()}, {facts['cpu']}"),
        ("cores", f"{facts['cores']} for this process; {default_threads()} threads unless told otherwise"),
        ("cache", f"{folder or cache_root()}: {writable}, {size:.0f} MiB with older versions"),
    ]  # fmt: skip
    for name, text in rows:
        print(f"{name:<12}{text}")
    error: list[float] = []

    def check() -> None:
        z0 = np.array([1.0, 0.0, 0.3, 0.0, 0.0, 0.5, 0.0, 0.2])
        end = fastaff.integrate(fastaff.Body(fastaff.Harmonic(C=1.0)), z0, time=2 * np.pi, step=0.02).z[:, 0]
        error.append(float(np.abs(end - z0).max()))

    start = clock.perf_counter()
    _compiled("poincare", check)
    fine = error[0] < 1e-11
    verdict, seconds = "passed" if fine else "FAILED", clock.perf_counter() - start
    print(f"{'self-check':<12}{verdict}: a harmonic orbit returns after 2 pi to {error[0]:.1e}, in {seconds:.1f} s")
    return 0 if fine else 1


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return 'missing: pip install "fastaff[demo]"'


def _with(function: Any, body: Any, options: dict[str, Any]) -> Any:
    return lambda z0, report: function(body, z0, report=report, **options)


def _enough_time(body: Any, z0: np.ndarray, section: Any, crossings: int, choices: dict[str, Any]) -> float:
    """Return four times what the median of a few orbits needs for the crossings."""
    from .engine import natural_rate
    from .poincare import poincare_map

    few = np.ascontiguousarray(z0[:, :: max(1, z0.shape[1] // 64)])
    horizon = 300.0 / natural_rate(body, few)
    found = poincare_map(body, few, section=section, crossings=16, max_time=horizon, **choices)
    with np.errstate(all="ignore"):
        between = np.array([t[n - 1] / n for t, n in zip(found.times, found.counts) if n])
    if between.size == 0:
        raise Wrong(f"no orbit crosses {section!r} within the time {horizon:.4g}; give --max-time, or another section or direction")
    return float(4.0 * np.median(between) * (crossings + 4))


def _facts(body, surface, section, starts, choices, z0, fixed) -> dict[str, Any]:
    return {
        "model": body, "energy": surface.energy, "p_eta": surface.p_eta, "p_gamma": surface.p_gamma, "section": section,
        "seed": starts.seed if starts.orbits is not None else None, "grid": starts.grid, "orbits": z0.shape[1],
        "range1": starts.range1, "range2": starts.range2, "rtol": 1e-12, "atol": 1e-12, "energy_tolerance": 1e-6,
        "threads": choices["threads"], "z0": z0, **{name: value for name, value in fixed.items() if name != "section"},
    }  # fmt: skip


def _saved(stem: Path, result: Any, output: Output, facts: dict[str, Any]) -> Path:
    from .files import save

    own = {entry.name for entry in fields(result)}
    facts = {name: value for name, value in facts.items() if name not in own or name in ("section", "time")}
    return save(stem.with_name(stem.name + ".npz"), result, force=output.force, **facts)


def _needs_matplotlib(output: Output) -> None:
    if not output.no_figure:
        import importlib.util

        if importlib.util.find_spec("matplotlib") is None:
            raise ModuleNotFoundError("matplotlib", name="matplotlib")


def _figure(panels: int = 1) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6 if panels == 1 else 12.6, 6.2), dpi=200, layout="constrained")
    return figure, figure.subplots(1, panels)


def _finish(figure, ax, body, surface, section, text, stem, facts) -> None:
    """Put title and caption on the figure and write it, with the parameters inside the PNG."""
    import json

    from .files import plain, provenance

    inner = getattr(body, "potential", body)
    values = ", ".join(f"{name} = {value:g}" for name, value in zip(inner._fields, inner))
    where = f"E = {surface.energy:g}"
    if inner is not body:
        values += f", mu = {body.mu:g}"
        where += rf", $p_\eta$ = {surface.p_eta:g}, $p_\gamma$ = {surface.p_gamma:g}"
    figure.suptitle(f"{type(inner).__name__} ({values}), {where}", fontsize=11)
    figure.supxlabel(f"section {_in_words(section)}; {text}; {_units(inner, body)}", fontsize=7.5, color="0.3")
    kept = {name: plain(value) for name, value in facts.items() if not isinstance(value, np.ndarray)}
    figure.savefig(stem.with_name(stem.name + ".png"), metadata={"Title": "fastaff", "Description": json.dumps({**provenance(), **kept})})


def _in_words(section: Any) -> str:
    turn = {1: "rising", -1: "falling", 0: "both ways"}[section.direction]
    name = type(section).__name__
    if name == "Linear":
        return f"{'x' if section.normal[0] else 'y'} = {section.offset:g}, {turn}"
    if name.endswith("Turning"):
        return rf"$p_\{name.removesuffix('Turning').lower()}$ = 0, {turn}"
    left = {"AlphaEquals": r"$\alpha$", "BetaEquals": r"$\beta$", "AreaEquals": "$D_1D_2$"}[name]
    return f"{left} = {section.constant:g}, {turn}"


def _units(inner: Any, body: Any) -> str:
    stiffness = inner._fields[0]
    if inner is body or inner[0] != 1 or body.mu != 1:
        return "units: those of the parameters"
    return rf"units: {stiffness} = $\mu$ = 1"


def _counted(status: np.ndarray) -> str:
    from .status import summary

    return "orbits: " + ", ".join(f"{count} {outcome.name}" for outcome, count in summary(status).items())


def _finished(result: Any, seconds: float) -> str:
    orbits = result.status.size
    rate = f"{orbits / seconds:,.0f} orbits/s"
    if hasattr(result, "counts"):
        rate += f", {result.counts.sum() / seconds:,.0f} crossings/s"
    drift = f"largest energy error {result.energy_error.max():.1e}"
    return f"{orbits} orbits{_crossings(result)} in {seconds:.1f} s: {rate}; {result.summary()}; {drift}"


def _report_files(path: Path, stem: Path, output: Output) -> None:
    print(path)
    if not output.no_figure:
        print(stem.with_name(stem.name + ".png"))
