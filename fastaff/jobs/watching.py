"""Progress of a running job: its callbacks, its log of chunks, and chunks in the hands of an executor."""

from __future__ import annotations

import contextlib
import json
import time as clock
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .chunks import LOG, Chunk, compute_chunk
from .store import Store

PENDING = 256
"""Chunks that an executor is handed at a time."""


class Progress(NamedTuple):
    """Progress of a job; as text it is one line.

    For example, ``on_chunk=lambda progress, chunk: print(progress, end="\\r")`` shows it, in notebooks too.

    Attributes
    ----------
    orbits : int
        Number of finished orbits.
    of : int
        Number of all orbits.
    seconds : float
        Wall time since the job began or was resumed, in seconds.
    rate : float
        Orbits per second of this run.
    crossings : float
        Crossings per second of this run.
    left : float
        Estimated remaining time in seconds.
    statuses : dict of dict of int
        Numbers of orbits so far by analysis and name of the status.
    """

    orbits: int
    of: int
    seconds: float
    rate: float
    crossings: float
    left: float
    statuses: dict[str, dict[str, int]]

    def __str__(self) -> str:
        parts = [f"{self.orbits} of {self.of} points ({self.orbits / self.of:.0%})", f"{self.rate:,.0f}/s"]
        if self.crossings:
            parts.append(f"{self.crossings:,.0f} crossings/s")
        parts.append(f"{self.left:.0f} s left")
        for name, counts in self.statuses.items():
            parts.append(f"{name}: " + ", ".join(f"{count} {status}" for status, count in counts.items()))
        return "; ".join(parts)


class Watched:
    """The callbacks of a running job, and the outcomes of its chunks."""

    def __init__(self, store: Store, chunks: int, callback: Any, on_chunk: Any):
        self.store = store
        self.callback = callback
        self.on_chunk = on_chunk
        self.chunks = chunks
        self.done = 0
        self.before = int(np.count_nonzero(store.finished() >= 0))
        self.start = clock.perf_counter()
        self.points = 0
        self.crossings = 0
        self.statuses: dict[str, dict[str, int]] = {}
        self.file: Any = None

    @contextlib.contextmanager
    def log(self) -> Iterator[None]:
        with open(self.store.path / LOG, "a", encoding="utf-8") as self.file:
            yield

    def within(self, fraction: float) -> None:
        if self.callback is not None:
            self.callback((self.done + fraction) / max(self.chunks, 1))

    def add(self, found: Chunk) -> None:
        self.file.write(json.dumps(found._asdict()) + "\n")
        self.file.flush()
        self.done += 1
        points = self.store.points(found.number)
        self.points += points.stop - points.start
        self.crossings += found.crossings
        for name, counts in found.statuses.items():
            mine = self.statuses.setdefault(name, {})
            for status, count in counts.items():
                mine[status] = mine.get(status, 0) + count
        seconds = clock.perf_counter() - self.start
        rate = self.points / max(seconds, 1e-9)
        finished = self.before + self.points
        all_ = self.store.orbits
        left = (all_ - finished) / rate
        if self.on_chunk is not None:
            crossings = self.crossings / max(seconds, 1e-9)
            self.on_chunk(Progress(finished, all_, seconds, rate, crossings, left, self.statuses), found)
        if self.callback is not None:
            self.callback(self.done / self.chunks)


def submitted(executor: Any, path: Path, todo: np.ndarray, threads: int, own: dict[str, Any], state: Watched) -> None:
    """Hand chunks to an executor, some at a time, and wait for all; the first failure is raised when none is lost."""
    waiting = [int(number) for number in todo][::-1]
    pending: list[Any] = []
    try:
        while waiting or pending:
            while waiting and len(pending) < PENDING:
                number = waiting.pop()
                pending.append(executor.submit(compute_chunk, str(path.absolute()), number, threads, own or None))
            ready = [future for future in pending if future.done()]
            for future in ready:
                pending.remove(future)
                state.add(Chunk(*future.result()))
            if not ready:
                clock.sleep(0.02)
    finally:
        for future in pending:
            getattr(future, "cancel", bool)()
