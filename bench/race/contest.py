"""Rows of the race, and their runs: every contestant on a ladder of accuracies, then the best in turns."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

TURNS, PATIENCE = 5, 12.0
"""Alternating runs of those that are compared, and the processor time after which a row takes no further turn."""


@dataclass(frozen=True)
class Contestant:
    """Hold one program's way to do a row's work: runs by name, from coarse to fine, and their results.

    `error` takes the result of a run. `share` is the part of the work that a run does: the times of slow programs,
    whose orbits are independent, are divided by it.
    """

    program: str
    runs: Mapping[str, Callable[[], Any]]
    error: Callable[[Any], float]
    share: float = 1.0


@dataclass(frozen=True)
class Row:
    """Hold a row: its task, its error, the accuracies asked (none: each run stands for itself).

    `contestants` makes truth and contestants when the row is run. `per` names a count the times are also given for.
    """

    title: str
    error: str
    asked: Sequence[float]
    contestants: Callable[[], Sequence[Contestant]]
    programs: Sequence[str]
    note: str = ""
    per: tuple[str, int] | None = None


@dataclass
class Timed:
    """Hold a run of a contestant: error, and the shortest processor (`cpu`) and elapsed times (`wall`), in seconds."""

    program: str
    how: str
    error: float
    share: float
    cpu: float = np.inf
    wall: float = np.inf

    def take(self, run: Callable[[], Any]) -> Any:
        """Run once more; return the result."""
        wall, cpu = time.perf_counter(), time.process_time()
        result = run()
        self.cpu = min(self.cpu, (time.process_time() - cpu) / self.share)
        self.wall = min(self.wall, (time.perf_counter() - wall) / self.share)
        return result


def best(timed: Sequence[Timed], asked: float, program: str, count: int = 1) -> list[Timed]:
    """Return the cheapest runs of a program with an error of at most `asked`."""
    good = [entry for entry in timed if entry.program == program and entry.error <= asked]
    return sorted(good, key=lambda entry: entry.cpu)[:count]


def hold(row: Row) -> list[Timed]:
    """Run a row: all runs once (twice, where the first compiles), then those that may be the best in turns."""
    timed, runs = [], {}
    for contestant in row.contestants():
        for i, (how, run) in enumerate(contestant.runs.items()):
            if i == 0:
                run()
            entry = Timed(contestant.program, how, np.inf, contestant.share)
            entry.error = float(contestant.error(entry.take(run)))
            timed.append(entry)
            runs[id(entry)] = run
    programs = dict.fromkeys(entry.program for entry in timed)
    chosen = timed
    if row.asked:
        chosen = list({id(e): e for a in row.asked for p in programs for e in best(timed, a, p, 3)}.values())
    start = time.process_time()
    for _ in range(TURNS):
        for entry in chosen:
            if time.process_time() - start < PATIENCE:
                entry.take(runs[id(entry)])
    return timed
