"""Kernels launched over units of work, in Python's own threads, with progress and Ctrl-C."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ..compile.jit import JIT_DISABLED, LANES
from ..compile.packing import run_units
from ..compile.threads import together, works

BRIEF = 10_000
"""Steps of an orbit that the caller's own thread takes: at most a fraction of a second, which Ctrl-C waits for, while
another thread needs as long as a hundred to wake up.
"""
Report = Callable[[float], None]
"""Called about ten times a second with the fraction of the work that is done."""


def launch(
    kernel: Callable,
    arguments: tuple,
    progress: np.ndarray,
    work: float,
    threads: int,
    report: Report | None,
    steps: float = math.inf,
) -> None:
    """Run kernel(unit, stop, progress, *arguments) for all units, one entry of `progress` each, without the GIL in a
    worker thread.

    The main thread draws progress and owns Ctrl-C, which sets stop[0], which kernels poll; KeyboardInterrupt is raised
    when the kernel has put its state back. What takes so few `steps` of an orbit that they are BRIEF runs here, and
    what a thread of `by_portions` begins.
    """

    stop = np.zeros(1, np.int64)

    def tell() -> None:
        if report is not None and work > 0:
            report(min(1.0, float(progress.sum()) / work))

    if (steps <= BRIEF or works()) and not JIT_DISABLED:
        run_units(kernel, (stop, progress, *arguments), progress.size, threads=1)
        tell()
        return
    run = partial(run_units, kernel, (stop, progress, *arguments), progress.size, threads=threads)
    together([run], partial(stop.fill, 1), tell)


def early(report: Report | None, flow: Any, ensemble: Any, time: float, share: float = 1.0) -> Report | None:
    """Return what takes the fraction of a run to `time` whose orbits may end before, and reports that of the steps that
    they need: such a share as those have needed which have ended, before these `share`.
    """
    if report is None or flow.adaptive:  # which counts orbits
        return report
    steps, begun = np.broadcast_to(flow.steps(time), ensemble.count.shape), ensemble.count.copy()

    def tell(fraction: float) -> None:
        taken = ensemble.count - begun
        ended = taken > 0
        need = taken[ended].sum() / steps[ended].sum() if ended.any() else share
        report(min(1.0, fraction / need))

    return tell


def units(orbits: int, size: int = LANES) -> np.ndarray:
    """Return the progress of as many units of that size as so many orbits make, at their beginning."""
    return np.zeros(math.ceil(orbits / size), np.int64)
