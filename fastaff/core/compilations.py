"""The record of what this process compiles, and of the time for it."""

from __future__ import annotations

import contextlib
import time as clock
from collections.abc import Iterator


class Compiling:
    """Record of compilations, kept by `engine.jit` and `engine.cache`. kernels: number of kernels compiled so far;
    seconds: time of compilation; depth: compilations under way, each begun by the one before.
    """

    kernels = 0
    seconds = 0.0
    depth = 0
    begun = 0.0

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
