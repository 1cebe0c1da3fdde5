"""The command line: `fastaff poincare`, `frequency-map`, `demo`, `warmup`, `doctor` (layer L5).

Parsing and help by cyclopts, progress by rich; matplotlib is imported when there is something to draw.
"""

# ruff: noqa: B008
from __future__ import annotations

import os
import platform
import signal
import sys
import threading
import time as clock
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from .options import (
    HELP,
    HOW,
    WRITTEN,
    Model,
    Output,
    Parameter,
    Run,
    Starts,
    Surface,
    cyclopts,
    enough_time,
    figure_of,
    finish,
    named,
    return_times,
    stated,
)
from .progress import COMPILE_SECONDS, EXIT_INTERRUPTED, Progress, begun, compiled, counted, drawing, finished, is_cold, kept, say, watched

EXIT_WRONG_INPUT = 2
COMMANDS = ("demo", "poincare", "frequency-map", "warmup", "doctor")
NO_EXTRAS = 'fastaff: the command line needs cyclopts and rich, figures need matplotlib: pip install "fastaff[demo]"'


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 2 for wrong input, 130 after Ctrl-C."""
    try:
        code = _run(sys.argv[1:] if arguments is None else arguments)
    except KeyboardInterrupt:
        say("stopped by Ctrl-C; nothing was computed yet, nothing is kept")
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
        say(f"error: {_one_line(problem)}  ({' '.join(['fastaff', *command, '--help'])})")
    except ModuleNotFoundError as problem:
        if (problem.name or "").partition(".")[0] not in ("matplotlib", "cyclopts", "rich"):
            raise
        print(NO_EXTRAS, file=sys.stderr)
    except (ValueError, TypeError, OSError) as problem:
        say(f"error: {_one_line(problem)}")
    return EXIT_WRONG_INPUT


def _one_line(problem: BaseException) -> str:
    return " ".join(str(problem).split())


def _app() -> Any:
    from . import __version__

    app = cyclopts.App(
        name="fastaff", version=__version__, help_format="markdown", suppress_keyboard_interrupt=False, help=HELP,
        default_parameter=Parameter(negative="", show_default=False),
    )  # fmt: skip
    for name, command in dict[str, Any](zip(COMMANDS, (demo, poincare, frequencies, warmup, doctor), strict=True)).items():
        app.command(command, name=name)
    return app


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
    output.check()
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
    fastaff.scalars.whole("crossings", crossings, 1)
    compiled("poincare", smallest)
    choices = run.build(body, z0)
    pace = return_times(body, z0, section, choices)
    if max_time is None:
        fixed["max_time"] = enough_time(pace, section, crossings)
    period = fixed["max_time"] / 4 / crossings if max_time is None else 3.0
    share = float(np.fmin(pace * crossings / fixed["max_time"], 1.0).mean())
    facts = stated(body, surface, section, starts, choices, z0, fixed)
    start = clock.perf_counter()

    def save(result: Any, extra: dict[str, Any], interrupted: bool = True) -> Path:
        wall = {"wall_time": clock.perf_counter() - start, "interrupted": interrupted}
        return output.save(stem, result, {**facts, **wall, **extra})

    result = watched(
        Progress("section", z0.shape[1], share),
        lambda report: fastaff.poincare_map(body, z0, report=report, **fixed, **choices),
        lambda partial: kept(partial, lambda: save(*begun(partial, z0))),
    )
    seconds = clock.perf_counter() - start
    say(finished(result, seconds))
    extra: dict[str, Any] = {"wall_time": seconds}
    if span:
        time = max(200.0, 400 * period)

        def known(found: Any) -> dict[str, Any]:
            return {**extra, "diffusion": np.where(found.status == 0, found.diffusion, np.nan), "diffusion_time": time}

        extra = known(watched(
            Progress("diffusion", z0.shape[1]),
            lambda report: fastaff.frequency_map(body, z0, time=time, report=report, **span, **choices),
            lambda partial: kept(result, lambda: save(result, known(partial))),
        ))  # fmt: skip
    with drawing(save(result, extra, interrupted=False)):
        if not output.no_figure:
            figure, ax = figure_of()
            values = extra.get("diffusion")
            norm = None if values is None else plot.diffusion_scale(values)
            drawn = plot.plot_section(result, ax=ax, values=values, boundary=edge, norm=norm)
            finish(figure, ax, body, surface, section, f"{counted(result.status)}; {drawn.missing} not drawn", stem, facts)
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

    from . import demo as demonstration

    body = options.build()
    section = surface.build(body)
    grid, _, z0 = starts.build(body, section, surface, "40x40")
    method = named("--method", method.lower(), ("birkhoff", "naff"))
    stem = output.stem("fastaff-frequency-map")
    output.check()
    fixed: dict[str, Any] = {"time": fastaff.scalars.positive("time", time), "method": method}
    inner = getattr(body, "potential", body)
    if isinstance(inner, fastaff.NeoHookean):  # its librations mix; only these loops tell them apart
        method = fixed["method"] = "naff"
        fixed["angles"] = demonstration.NormalModes()

    def smallest() -> None:
        scheme = fastaff.scheme_named(run.scheme.replace("-", "_"))
        few: dict[str, Any] = {"scheme": scheme, "step": run.step or 0.02, "threads": run.threads}
        fastaff.frequency_map(body, z0[:, :1], **{**fixed, "time": 5.0}, **few)
        if method == "birkhoff":
            fastaff.frequency_map(body, z0[:, :1], time=5.0, method="naff", **few)

    compiled("frequency-map", smallest)
    choices = run.build(body, z0)
    facts = stated(body, surface, section, starts, choices, z0, fixed)
    start = clock.perf_counter()

    def save(result: Any, seconds: float, interrupted: bool = True) -> Path:
        return output.save(stem, result, {**facts, "wall_time": seconds, "interrupted": interrupted})

    def sorted_out(found: Any) -> Any:
        return demonstration.sorted_out(found) if "angles" in fixed else found

    result = sorted_out(watched(
        Progress("frequencies", z0.shape[1]),
        lambda report: fastaff.frequency_map(body, z0, report=report, **fixed, **choices),
        lambda partial: kept(partial, lambda: save(sorted_out(partial), clock.perf_counter() - start)),
    ))  # fmt: skip
    seconds = clock.perf_counter() - start
    shown = demonstration.told_apart(result) if "angles" in fixed else np.ones(result.status.size, bool)
    say(finished(result, seconds))
    with drawing(save(result, seconds, interrupted=False)):
        if not output.no_figure:
            _draw_frequencies(result, shown, grid, starts, body, surface, section, max_order, stem, facts)
    return 0


def _draw_frequencies(result, shown, grid, starts, body, surface, section, max_order, stem, facts) -> None:
    from . import plot

    figure, ax = figure_of(panels=1 if starts.orbits is not None else 2)
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
    finish(figure, axes[-1], body, surface, section, f"{counted(result.status)}; {drawn.missing} not drawn", stem, facts)


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
    Output().check()
    from . import demo as demonstration

    bars: list[Progress] = []

    def meter(title: str) -> Any:
        for bar in bars:
            bar.__exit__()
        bars[:] = [Progress(title).__enter__()]
        return bars[0]

    def leave(*_: Any) -> None:
        for bar in bars:
            bar.__exit__()
        say("stopped by Ctrl-C; the demo writes its files at the end, nothing is kept")
        os._exit(EXIT_INTERRUPTED)

    ours = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGINT)
    if ours:
        signal.signal(signal.SIGINT, leave)
    if is_cold():
        say(f"compiling once (about {COMPILE_SECONDS['frequency-map']} s)")
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
        compiled("frequency-map", job, announce=False)
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
    compiled("poincare", check)
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
