"""Kernels launched over units of work, in Python's own threads, with progress and Ctrl-C."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..engine.jit import JIT_DISABLED, LANES
from ..engine.packing import run_units, shares
from ..engine.threads import own_threads, together, works

BRIEF = 10_000
"""Most steps of an orbit for which the caller's own thread does the work: Ctrl-C waits at most a fraction of a second,
while another thread takes the time of a hundred steps to wake up.
"""
Callback = Callable[[float], None]
"""Called about ten times a second with the fraction of the work that is done."""


def launch(
    kernel: Callable,
    arguments: tuple,
    progress: np.ndarray,
    work: float,
    threads: int,
    callback: Callback | None,
    steps: float = math.inf,
) -> None:
    """Run kernel(unit, stop, progress, *arguments) for all units, one entry of `progress` each, without the GIL in a
    worker thread.

    The main thread draws progress. Ctrl-C there sets stop[0], which kernels poll; KeyboardInterrupt is raised when the
    kernel has put its state back. Work of at most BRIEF `steps` of an orbit runs in this thread; a worker takes part in
    the work that it begins.
    """

    stop = np.zeros(1, np.int64)

    def tell() -> None:
        if callback is not None and work > 0:
            callback(min(1.0, float(progress.sum()) / work))

    if (steps <= BRIEF or works()) and not JIT_DISABLED:
        few = 1 if steps <= BRIEF else own_threads(threads)
        run_units(kernel, (stop, progress, *arguments), progress.size, threads=few)
        tell()
        return
    calls, end = shares(kernel, (stop, progress, *arguments), progress.size, threads)

    def halt() -> None:
        stop.fill(1)
        end()

    together(calls, halt, tell)


def early(callback: Callback | None, flow: Any, ensemble: Any, time: float, share: float = 1.0) -> Callback | None:
    """Return a callback for a run whose orbits may end before `time`: it takes the fraction of all steps, and reports
    that of the steps needed, by the share that ended orbits have needed, or `share` while there are none.
    """
    if callback is None or flow.adaptive:  # which counts orbits
        return callback
    steps = np.broadcast_to(flow.steps(time), ensemble.count.shape)
    begun = ensemble.count.copy()

    def tell(fraction: float) -> None:
        taken = ensemble.count - begun
        ended = taken > 0
        need = taken[ended].sum() / steps[ended].sum() if ended.any() else share
        callback(min(1.0, fraction / need))

    return tell


def units(orbits: int, size: int = LANES) -> np.ndarray:
    """Return a progress of 0 for each unit of `size` orbits."""
    return np.zeros(math.ceil(orbits / size), np.int64)
