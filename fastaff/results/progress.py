"""Progress of a long call on a terminal or in a notebook: that it compiles, the share that is done, the time left.
In a pipe or file, the same as whole lines: of compilation through `logging`, of shares if they are asked for.

A separate thread writes it, because the caller's may be in the compiler, which lets other Python threads run.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import logging
import os
import sys
import threading
import time as clock
from collections.abc import Callable, Iterator
from queue import Empty, SimpleQueue
from typing import Any, ParamSpec, TypeVar, cast

from ..core.compilations import Compiling

SILENCE = 1.5
"""Seconds after which a call says something; half a second where it compiles, which is known to take more."""

STALLED = 3.0
"""Least seconds without a report after which the earlier pace counts no more."""


NOTICED = 5.0
"""Seconds of compilation after which a call says so in a pipe or file, as Matplotlib does of its fonts."""

SETTLED = 3
"""Looks, one a second, without a compilation after which it counts as ended: calls compute between kernels."""

APART = 30.0
"""Seconds between lines in a pipe or file, where shares are asked for."""

LOGGER = logging.getLogger("fastaff")


class Compilation:
    """Kernels that are compiled from now on, and the time for them."""

    def __init__(self) -> None:
        self.kernels = Compiling.kernels
        self.begun = Compiling.spent()

    @property
    def begins(self) -> bool:
        """Whether anything is compiled."""
        return Compiling.kernels > self.kernels

    def spent(self) -> float:
        """Return the seconds of compilation so far."""
        return Compiling.spent() - self.begun

    def said(self) -> str:
        """Return how many kernels were compiled, and in which time."""
        count = Compiling.kernels - self.kernels
        return f"compiled {count} {'kernel' if count == 1 else 'kernels'} in {self.spent():.0f} s"


COMPILING = "compiling once; later calls start within seconds"
"""A call's first line where it compiles and its line is not written anew."""

P = ParamSpec("P")
R = TypeVar("R")

MARKS = 256
"""Reports that a line keeps; beyond that every second old one goes."""


class _Shown:
    """Whether calls write progress: as `show_progress` was told, otherwise on terminals and in notebooks."""

    wanted: bool | None = None
    busy = False
    line: _Line | None = None


def show_progress(shown: bool = True) -> None:
    """Let long calls show their progress, or keep them silent.

    In terminals and notebooks, a call of more than 2 s writes one line. The line shows that the call compiles, then the
    completed fraction and the time left. It disappears at the end. A call with a `callback` writes no line.

    In pipes and files, a call logs two lines if it compiles for more than 5 s: that it compiles, and at the end the
    number of kernels and the seconds. The logger is ``logging.getLogger("fastaff")``, the level is WARNING. After
    ``show_progress(True)``, long calls also write the completed fraction to stderr, every 30 s.

    Parameters
    ----------
    shown : bool, default True
        True for progress in pipes and files, too; False to keep all calls silent. For processes that do not call this
        function, the environment variable FASTAFF_PROGRESS=1 or 0 does the same.

    Returns
    -------
    None
        The setting holds for the process.

    Raises
    ------
    TypeError
        If `shown` is not a bool.

    Notes
    -----
    A line costs a thread that wakes five times a second, 0.1 ms for a call.

    References
    ----------
    The time left follows from the completed fraction and its rate in the last third of the run, without time of
    compilation. The time of compilation is not estimated beforehand.

    Examples
    --------
    >>> fa.show_progress(False)
    """
    if not isinstance(shown, bool):
        raise TypeError(f"shown must be True or False, got {shown!r} ({type(shown).__name__})")
    _Shown.wanted = shown


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Keep calls silent within the block, which writes its own progress."""
    before = _Shown.busy
    _Shown.busy = True
    try:
        yield
    finally:
        _Shown.busy = before


def in_notebook() -> bool:
    """Return whether stderr is that of a notebook's cell."""
    return type(sys.stderr).__module__.startswith("ipykernel")


def asked() -> bool | None:
    """Return whether progress is asked for, by `show_progress` or the environment; None where nobody says."""
    if _Shown.wanted is not None:
        return _Shown.wanted
    return {"0": False, "1": True}.get(os.environ.get("FASTAFF_PROGRESS", ""))


def _looked_at() -> bool:
    """Return whether stderr is a terminal or a notebook's."""
    try:
        return in_notebook() or sys.stderr.isatty()
    except (AttributeError, ValueError):  # no stream, or a closed one
        return False


def _line(name: str, logged: bool) -> _Line | None:
    wanted = asked()
    if wanted is False:
        return None
    if _looked_at():
        return _Line(name)
    return _LoggedLines(name, shares=wanted is True) if wanted or logged else None


@contextlib.contextmanager
def watched(name: str, logged: bool = True) -> Iterator[Callable[[float], Any] | None]:
    """Show the progress of a call, and yield the `callback` that takes the fraction done; None where nobody looks, or
    where it is part of a call that is watched.

    logged: whether the call says in pipes and files that it compiles.
    """
    free = not _Shown.busy and threading.current_thread() is threading.main_thread()
    line = _line(name, logged) if free else None
    if line is None:
        yield None
        return
    with silent():
        _Shown.line = line
        try:
            line.start()
            yield line.report if line.shares else None
        finally:
            _Shown.line = None
            line.end()


def tell(name: str, fraction: float, said: str = "") -> None:
    """Write the fraction done and a text into the line of the call of this name, if it is watched: for calls without
    `callback`.
    """
    line = _Shown.line
    if line is not None and line.what == name and threading.current_thread() is threading.main_thread():
        line.report(fraction)
        line.said = said and f", {said}"


def says_progress(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function show its progress on a terminal or in a notebook, unless it is given `callback` or `on_chunk`."""
    told = "callback" in inspect.signature(function).parameters

    @functools.wraps(function)
    def wrapped(*given: Any, **named: Any) -> Any:
        if named.get("callback") is not None or named.get("on_chunk") is not None:
            with silent():
                return function(*given, **named)
        # Processes of an executor fork while the call runs, where no thread should be.
        with watched(function.__name__, logged=named.get("executor") is None) as callback:
            if told and callback is not None and "callback" not in named:
                named["callback"] = callback
            return function(*given, **named)

    return cast(Callable[P, R], wrapped)


class _Line(threading.Thread):
    """A line that is written anew while a call runs."""

    pause = 0.2
    shares = True

    def __init__(self, name: str):
        super().__init__(name="fastaff-progress", daemon=True)
        # without a lock that Ctrl-C may leave locked
        self.what = name
        self.bell = SimpleQueue[None]()
        self.compilation = Compilation()
        self.begun = clock.perf_counter()
        self.marks: list[tuple[float, float]] = []
        self.said = ""
        self.width = 0
        self.cell: Any = None  # the line in a notebook: an output that is replaced, as a stream keeps all its text

    def report(self, fraction: float) -> None:
        """Take the fraction that is done."""
        self.marks = [*self.marks, (computed(), fraction)]
        if len(self.marks) > MARKS:
            self.marks = self.marks[:-1:2] + self.marks[-1:]

    def run(self) -> None:
        """Look after each pause what is to be said, until the call ends."""
        while True:
            try:
                return self.bell.get(timeout=self.pause)
            except Empty:
                self.look(clock.perf_counter() - self.begun)

    def look(self, seconds: float) -> None:
        """Write the line anew after that many seconds."""
        if text := self.text(seconds):
            self.write(text)

    def text(self, seconds: float) -> str:
        """Return the text of the line after that many seconds."""
        marks = self.marks
        compilation = self.compilation
        if compilation.begins and (Compiling.depth or not marks) and seconds > 0.5:
            return f"{self.what}: compiling once, {compilation.spent():.0f} s"
        if seconds < SILENCE:
            return ""
        left = time_left(marks, computed())
        if left is None:
            share = f"{marks[-1][1]:4.0%}, " if marks and marks[-1][1] > marks[0][1] else ""
            return f"{self.what}: {share}{seconds:.0f} s{self.said}"
        return f"{self.what}: {marks[-1][1]:4.0%}{self.said}, about {duration(left)} left"

    def write(self, text: str) -> None:
        with contextlib.suppress(OSError, ValueError, AttributeError):  # a stream that is gone
            if in_notebook():
                return self.show({"text/plain": text})
            sys.stderr.write(f"\r{text:<{self.width}}")
            sys.stderr.flush()
            self.width = len(text)

    def show(self, output: dict[str, str]) -> None:
        """Put the line into the cell's output, in place of the one before."""
        from IPython.display import display

        if self.cell is None:
            self.cell = display(output, raw=True, display_id=True)
        else:
            self.cell.update(output, raw=True)

    def end(self) -> None:
        """Remove the line from the terminal or notebook."""
        self.bell.put(None)
        self.join(1.0)
        if self.cell is not None:
            self.show({"text/plain": ""})
        elif self.width:
            self.write("")
            self.write("\r")


class _LoggedLines(_Line):
    """Lines in a pipe or file: that a call compiles, how long it took and, if asked for, the share that is done."""

    pause = 1.0

    def __init__(self, name: str, shares: bool):
        super().__init__(name)
        self.shares = shares
        self.noticed = self.ended = False
        self.kernels = Compiling.kernels
        self.quiet = 0
        self.next = APART

    def look(self, seconds: float) -> None:
        """Write what is new after that many seconds."""
        quiet = not Compiling.depth and Compiling.kernels == self.kernels
        self.kernels = Compiling.kernels
        self.quiet = self.quiet + 1 if quiet else 0
        if not self.noticed and self.compilation.begins and self.compilation.spent() > NOTICED:
            self.noticed = True
            self.notice(COMPILING)
        elif self.noticed and not self.ended and self.quiet >= SETTLED:
            self.settle()
        elif self.shares and seconds > self.next:
            self.next = seconds + APART
            self.write(f"fastaff: {self.text(seconds)}")

    def settle(self) -> None:
        """Say how long the compilation took."""
        self.ended = True
        self.notice(self.compilation.said())

    def notice(self, text: str) -> None:
        """Log a line, which logging writes to stderr unless it is told otherwise."""
        LOGGER.warning("fastaff: %s: %s", self.what, text)

    def write(self, text: str) -> None:
        """Write a line to stderr."""
        with contextlib.suppress(OSError, ValueError, AttributeError):  # a stream that is gone
            sys.stderr.write(f"{text}\n")
            sys.stderr.flush()

    def end(self) -> None:
        """Say what is left to be said."""
        self.bell.put(None)
        self.join(1.0)
        if self.noticed and not self.ended:
            self.settle()


def computed() -> float:
    """Return a time in seconds that stands still while something is compiled."""
    return clock.perf_counter() - Compiling.spent()


def time_left(marks: list[tuple[float, float]], now: float) -> float | None:
    """Return the seconds that are left after `marks` of times and fractions, at the pace of the last third of the time:
    the passes of a call differ in pace. None before the first progress, and after a longer time without a report than
    all earlier reports took.
    """
    if not marks or marks[-1][1] <= marks[0][1] or now - marks[-1][0] > max(STALLED, marks[-1][0] - marks[0][0]):
        return None
    last = marks[-1][1]
    recent = [mark for mark in marks if mark[0] <= now - (now - marks[0][0]) / 3 and mark[1] < last]
    since, fraction = recent[-1] if recent else marks[0]
    return (1.0 - last) / (last - fraction) * (now - since)


def duration(seconds: float) -> str:
    """Return a time as text in seconds, minutes or hours."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
