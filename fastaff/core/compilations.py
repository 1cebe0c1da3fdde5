"""The record of what this process compiles, and of the time for it."""

from __future__ import annotations

import contextlib
import time as clock
from collections.abc import Iterator
from typing import ClassVar

KERNELS = {"find_turns_of_words": 1.13, "run_fixed_of_words": 1.3}
"""Seconds of the processor, on the machine of `progress.PARTS`, of kernels that almost every call needs: they measure
the speed of a machine.
"""


class Compiling:
    """Record of compilations, kept by `engine.jit`. seconds, worked: time and processor time of compilation; kernels:
    names of compiled kernels; speed: ratio of their processor time to that on the machine of `progress.PARTS`.
    """

    depth = 0
    known = 0
    seconds = 0.0
    worked = 0.0
    begun = 0.0, 0.0
    kernels: ClassVar[list[str]] = []
    speed: float | None = None

    @classmethod
    @contextlib.contextmanager
    def under_way(cls) -> Iterator[None]:
        """Count the time of a compilation, which may begin others."""
        if not cls.depth:
            cls.begun, cls.known = (clock.perf_counter(), clock.process_time()), len(cls.kernels)
        cls.depth += 1
        try:
            yield
        finally:
            cls.depth -= 1
            if not cls.depth:
                worked = clock.process_time() - cls.begun[1]
                cls.seconds += clock.perf_counter() - cls.begun[0]
                cls.worked += worked
                if len(new := cls.kernels[cls.known :]) == 1 and new[0] in KERNELS:
                    cls.speed = worked / KERNELS[new[0]]

    @classmethod
    def spent(cls) -> tuple[float, float]:
        """Return the seconds that this process has compiled and loaded so far, and those of the processor in them."""
        if not cls.depth:
            return cls.seconds, cls.worked
        return cls.seconds + clock.perf_counter() - cls.begun[0], cls.worked + clock.process_time() - cls.begun[1]
