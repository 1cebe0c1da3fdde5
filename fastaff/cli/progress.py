"""The messages of the command line while it computes: progress, the compile notice, the results kept at Ctrl-C."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import time as clock
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..core.interruption import Interrupted
from ..core.status import Status
from ..results.calls import keep
from ..results.progress import COMPILING, Compilation, asked
from .stops import EXIT_INTERRUPTED, Stops, on_stop, say


class TerminalProgress:
    """Bar, orbits/s and time left on a terminal; nothing elsewhere. A `callback` of the library's functions."""

    def __init__(self, title: str, orbits: int | None = None):
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar
        from rich.text import Text

        class BarAndLine(Bar):
            """A bar with a line of text below."""

            below = ""

            def get_renderables(self) -> Iterator[Any]:
                yield from super().get_renderables()
                if self.below:
                    yield Text(self.below)

        rate = [] if orbits is None else [TextColumn("{task.fields[rate]}")]
        self.bar = BarAndLine(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            *rate,
            TimeRemainingColumn(compact=True),
            TextColumn("left"),
            console=Console(stderr=True),
            transient=True,
        )
        self.shown = sys.stderr.isatty()  # rich takes FORCE_COLOR and notebooks for terminals
        self.task = self.bar.add_task(title, total=1.0, rate="")
        self.orbits = orbits or 0
        self.start = clock.perf_counter()

    def __call__(self, fraction: float) -> None:
        rate = fraction * self.orbits / max(clock.perf_counter() - self.start, 1e-9)
        self.bar.update(self.task, completed=fraction, rate=f"{rate:,.0f} orbits/s")

    def __enter__(self) -> TerminalProgress:
        if self.shown:
            self.bar.start()
        return self

    def __exit__(self, *_: Any) -> None:
        if self.shown:
            self.bar.stop()


class JobProgress(TerminalProgress):
    """Progress of a job: orbits/s and crossings/s of this run, and below the bar the statuses so far."""

    def __init__(self, orbits: int, finished: float, shown: bool):
        super().__init__("job", orbits)
        self.shown = self.shown and shown
        self.finished = finished
        self(0.0)

    def __call__(self, fraction: float) -> None:
        self.bar.update(self.task, completed=self.finished + (1.0 - self.finished) * fraction)

    def on_chunk(self, so_far: Any, chunk: Any) -> None:
        """Show the progress that `jobs.run` reports after each chunk."""
        crossings = f", {so_far.crossings:,.0f} crossings/s" if so_far.crossings else ""
        self.bar.update(self.task, rate=f"{so_far.rate:,.0f} orbits/s{crossings}")
        self.bar.below = "; ".join(
            f"{name}: " + ", ".join(f"{count} {status}" for status, count in counts.items())
            for name, counts in so_far.statuses.items()
        )


def watched(progress: TerminalProgress, compute: Callable[[TerminalProgress], Any], keep: Callable[[Any], Any]) -> Any:
    """Return compute(progress), which is held from then on; after Ctrl-C keep the result so far, say so and leave with
    exit code 130.

    keep: called with the partial result; with None where there is none, but the result of an earlier computation.
    """
    result = None
    before = Stops.holding
    partial = None
    try:
        with progress:
            Stops.release()
            result = compute(progress)
            Stops.holding = True
        return result
    except Interrupted as stopped:
        partial = stopped.partial
    except KeyboardInterrupt:
        if result is not None:  # Ctrl-C came between the result and `holding`
            Stops.holding = Stops.arrived = True
            return result
        if not before:
            raise
    with on_stop(signal.SIG_IGN):  # a second Ctrl-C must not stop the saving
        keep(partial)
    raise SystemExit(EXIT_INTERRUPTED)


def kept(result: Any, save: Callable[[], Any]) -> None:
    """Save the result of an interrupted run, unless it is empty, and say so."""
    total = result.status.size
    done = int(np.count_nonzero(result.status != Status.INTERRUPTED))
    if done or (hasattr(result, "counts") and result.counts.any()):
        path = save()
        say(f"{Stops.said()}: kept {done} finished of {total} orbits{_crossings(result)} in {path}; no figure drawn")
    else:
        say(f"{Stops.said()} before any of {total} orbits was finished; nothing is kept")


def begun(partial: Any, z0: np.ndarray) -> tuple[Any, dict[str, Any]]:
    """Return a partial section map of the orbits that have begun, and their z0: the others' empty rows take seconds to
    write.
    """
    rows = np.flatnonzero((partial.status != Status.INTERRUPTED) | (partial.counts > 0))
    # The file says which orbits these are, beside the call that made all.
    return keep(partial.take(rows), getattr(partial, "call", None)), {"z0": z0[:, rows], "begun": rows}


@contextlib.contextmanager
def drawing(path: Any) -> Iterator[None]:
    """Name the file of the data; Ctrl-C while the figure is drawn leaves with exit code 130."""
    print(path, flush=True)
    try:
        Stops.release()
        yield
        Stops.holding = True  # all is written: nothing is left to stop
    except KeyboardInterrupt:
        say(f"{Stops.said()}: all results are in {path}; no figure drawn")
        raise SystemExit(EXIT_INTERRUPTED) from None


def _crossings(result: Any) -> str:
    return f" ({int(result.counts.sum())} crossings)" if hasattr(result, "counts") else ""


def compiled(first: Callable[[], Any], announce: bool = True) -> None:
    """Run `first`, the smallest case of the coming computation, in a thread of its own, so that Ctrl-C need not wait
    for the compiler. If it compiles, say so, and at the end for how long.
    """
    failure: list[BaseException] = []
    finished = threading.Event()
    compilation = Compilation()
    announce = announce and asked() is not False
    noticed = False

    def work() -> None:
        try:
            first()
        except BaseException as problem:  # handed to the caller below
            failure.append(problem)
        finally:
            finished.set()

    with on_stop(_leave_the_compiler):
        threading.Thread(target=work, daemon=True).start()
        finished.wait(0.5)  # a small kernel is not worth a word
        while not finished.wait(0.1):
            if announce and not noticed and compilation.begins:
                say(COMPILING)
                noticed = True
    if failure:
        raise failure[0]
    if noticed:
        say(compilation.said())


def _leave_the_compiler(number: int, *_: Any) -> None:
    # A thread inside the compiler cannot be stopped; finished cache files are moved into place, so none is left half
    # written.
    Stops.sent = Stops.sent or number
    Stops.leave("before any orbit was finished (compiling)")


def is_cold() -> bool:
    """Return whether the kernels of this version are still to be compiled: neither kept nor in a pack."""
    from ..engine.cache import SUFFIX
    from ..engine.code_folder import cache_directory, prebuilt

    folder = cache_directory()
    return folder is None or (prebuilt() is None and sum(1 for _ in folder.glob(f"*{SUFFIX}")) < 10)


def finished(result: Any, seconds: float) -> str:
    """Return one line with the number of computed orbits, their speed and their errors."""
    rate = f"{result.status.size / seconds:,.0f} orbits/s"
    if hasattr(result, "counts"):
        rate += f", {result.counts.sum() / seconds:,.0f} crossings/s"
    drift = f"largest energy error {result.energy_error.max():.1e}"
    return f"{result.summary()}; {seconds:.1f} s, {rate}; {drift}"
