"""What a long call says on a terminal or in a notebook: that it compiles, the share that is done, the time left.

A thread of its own says it, as the caller's may be in the compiler, where Python's others get their turn.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import threading
import time as clock
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from .placing import placed

SILENCE = 2.0
"""Seconds after which a call says something; half a second where it compiles, which is known to take more."""

SECONDS = {"poincare_map": 26, "frequency_map": 25, "chaos_map": 13, "demo": 30, "animate": 5, "doctor": 4}
"""Seconds of compilation by function where this machine has not measured any."""

MOST, MORE = 30.0, 5.0
"""The same of other functions, and where only a model, a section or the like is new."""


class Compiling:
    """The compiler as others see it: `compile.jit` keeps it. root(): where its files are; sources(): what they are made
    of, nothing where a pack has come with the package.
    """

    depth, kernels, seconds, begun = 0, 0, 0.0, 0.0
    root: Callable[[], Path | None] = staticmethod(lambda: None)
    sources: Callable[[], str] = staticmethod(lambda: "")

    @classmethod
    @contextlib.contextmanager
    def under_way(cls) -> Iterator[None]:
        """Count the time of a compilation, which may begin others."""
        if not cls.depth:
            cls.begun = clock.perf_counter()
        cls.depth += 1
        try:
            yield
        finally:
            cls.depth -= 1
            if not cls.depth:
                cls.seconds += clock.perf_counter() - cls.begun

    @classmethod
    def spent(cls) -> float:
        """Return the seconds that this process has compiled and loaded so far."""
        return cls.seconds + (clock.perf_counter() - cls.begun if cls.depth else 0.0)


class _Shown:
    """Whether calls say something: as `progress` was told, else where somebody looks."""

    wanted: bool | None = None
    busy = False


def progress(shown: bool = True) -> None:
    """Let long calls say what they do, or keep them silent.

    On terminals and in notebooks a call that takes more than 2 s says so in a line, which goes when it ends: that it
    compiles and how long that takes on this machine, then the share that is done and the time left. Pipes, files and
    tests get nothing; nor do calls that are given a `report`, which is told instead.

    Parameters
    ----------
    shown : bool, default True
        False: never; True: wherever stderr goes. The variable FASTAFF_PROGRESS=0 of the environment does the same as
        False for processes that do not call this.

    Returns
    -------
    None

    Raises
    ------
    TypeError
        Where it is no bool.

    Notes
    -----
    A line costs a thread of its own that wakes five times a second, 0.1 ms for a call.

    References
    ----------
    The seconds of compilation are those of the last time, in seconds.json of the folder of the compile cache.

    Examples
    --------
    >>> fa.progress(False)
    """
    if not isinstance(shown, bool):
        raise TypeError(f"shown must be True or False, got {shown!r} ({type(shown).__name__})")
    _Shown.wanted = shown


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Keep calls silent within the block, which says itself what it does."""
    before, _Shown.busy = _Shown.busy, True
    try:
        yield
    finally:
        _Shown.busy = before


def in_notebook() -> bool:
    """Return whether stderr is a cell's."""
    return type(sys.stderr).__module__.startswith("ipykernel")


def _looked_at() -> bool:
    if _Shown.wanted is not None:
        return _Shown.wanted
    if os.environ.get("FASTAFF_PROGRESS") == "0":
        return False
    try:
        return in_notebook() or sys.stderr.isatty()
    except (AttributeError, ValueError):  # no stream, or a closed one
        return False


@contextlib.contextmanager
def watched(name: str) -> Iterator[Callable[[float], Any] | None]:
    """Say of a call what it does, and yield the `report` that tells how much is done; None where nobody looks, or where
    it is part of a call that is watched.
    """
    if _Shown.busy or threading.current_thread() is not threading.main_thread() or not _looked_at():
        yield None
        return
    line = _Line(name)
    with silent():
        try:
            line.start()
            yield line.report
        finally:
            line.end()


def compile_seconds(name: str) -> float:
    """Return how many seconds the compilation for a function takes: as measured on this machine, if it was."""
    found = _measured()
    if _is_new(name, found):
        return found.get(name, (SECONDS.get(name, MOST), ""))[0]
    return found.get(f"{name}, once more", (MORE, ""))[0]


def keep_seconds(name: str, seconds: float) -> None:
    """Keep how long the compilation for a function took on this machine."""
    path, found = _file(), _measured()
    if path is None or seconds < 0.5:
        return
    found[name if _is_new(name, found) else f"{name}, once more"] = round(seconds, 1), Compiling.sources()
    with contextlib.suppress(OSError):
        placed(path.with_suffix(""), path.suffix, lambda draft: draft.write_text(json.dumps(found)), force=True)


def _is_new(name: str, found: dict[str, tuple[float, str]]) -> bool:
    """Return whether nothing was compiled for a function of this version yet."""
    sources = Compiling.sources()
    return bool(sources) and found.get(name, (0.0, ""))[1] != sources


def _file() -> Path | None:
    root = Compiling.root()
    return None if root is None else root / "seconds.json"


def _measured() -> dict[str, tuple[float, str]]:
    """Return what was measured on this machine, and of which sources; nothing of the file is trusted to be more."""
    try:
        found = json.loads((_file() or Path()).read_text())
        return {str(key): (min(max(float(value), 0.0), 1e5), str(of)) for key, (value, of) in found.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


class _Line(threading.Thread):
    """A line that is written anew while a call runs."""

    def __init__(self, name: str):
        super().__init__(name="fastaff-progress", daemon=True)
        self.what, self.bell = name, SimpleQueue[None]()  # without a lock that Ctrl-C may leave locked
        self.kernels, self.seconds = Compiling.kernels, Compiling.spent()
        self.begun = clock.perf_counter()
        self.first: tuple[float, float] | None = None
        self.fraction, self.width = 0.0, 0
        self.cell: Any = None  # the line in a notebook: an output that is replaced, as it keeps what a stream was told

    def report(self, fraction: float) -> None:
        """Take the fraction that is done; where it falls, another pass has begun."""
        if self.first is None or fraction < self.fraction:
            self.first = clock.perf_counter(), fraction
        self.fraction = fraction

    def run(self) -> None:
        """Say what there is to say, until the call ends."""
        while True:
            try:
                return self.bell.get(timeout=0.2)
            except Empty:
                if text := self.text(clock.perf_counter() - self.begun):
                    self.write(text)

    def text(self, seconds: float) -> str:
        """Return the line after so many seconds."""
        if Compiling.kernels > self.kernels and (Compiling.depth or self.first is None) and seconds > 0.5:
            spent = Compiling.spent() - self.seconds
            return f"{self.what}: compiling once, {spent:.0f} s of about {max(compile_seconds(self.what), spent):.0f} s"
        if seconds < SILENCE:
            return ""
        if self.first is None or not self.fraction > self.first[1]:
            return f"{self.what}: {seconds:.0f} s"
        since, at = self.first
        left = (1.0 - self.fraction) / (self.fraction - at) * (clock.perf_counter() - since)
        return f"{self.what}: {self.fraction:4.0%}, about {duration(left)} left"

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
        """Take the line away, and keep how long compilation took."""
        self.bell.put(None)
        self.join(1.0)
        if self.cell is not None:
            self.show({"text/plain": ""})
        elif self.width:
            self.write("")
            self.write("\r")
        if Compiling.kernels > self.kernels:
            keep_seconds(self.what, Compiling.spent() - self.seconds)


def duration(seconds: float) -> str:
    """Return a time in the units of people."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
