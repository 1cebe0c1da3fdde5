"""Threads that run compiled code: how many, and what they are given to do.

Compiled code lets go of the GIL, so Python's own threads will do. They leave nothing behind that a fork could not
survive, as OpenMP does, and several callers may use them at once.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import os
import threading
from collections.abc import Callable, Iterable
from queue import Empty, SimpleQueue
from typing import Any

import numba
from numba.np.ufunc import parallel

from ..base.numbers import whole
from .jit import JIT_DISABLED


def default_threads() -> int:
    """Return the number of threads that kernels use unless told otherwise: of `numba.set_num_threads` if it was called,
    else $NUMBA_NUM_THREADS or the cores of this process.
    """
    if JIT_DISABLED:
        return 1
    # To ask Numba would start its own threads, where that has not happened yet.
    return numba.get_num_threads() if parallel._is_initialized else available_threads()


def available_threads() -> int:
    """Return the largest number of threads that kernels can use in this process."""
    return 1 if JIT_DISABLED else int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def checked_threads(threads: Any) -> int:
    """Return the number of threads to use: `threads` if it is one this process can have, the default for None."""
    count = default_threads() if threads is None else whole("threads", threads, 1)
    if count > available_threads():
        raise ValueError(f"threads must be at most {available_threads()} here, got {count}")
    return count


class Task:
    """A call that a thread of this process makes, unless it is taken back before.

    Ctrl-C may reach its owner anywhere; where locks are, as in `concurrent.futures`, it may leave one locked for ever.
    """

    def __init__(self, call: Callable[[], object]):
        self._call = call
        self._made_by: dict[str, str] = {}
        self._bell: SimpleQueue[None] = SimpleQueue()
        self._done = False
        self._problem: BaseException | None = None

    def begin(self) -> None:
        """Let a thread make the call."""
        _tasks(os.getpid()).put(self)

    def withdrawn(self) -> bool:
        """Return whether the call runs no more: not begun, it never will."""
        return self._made_by.setdefault("by", "nobody") == "nobody" or self._done

    def ended(self, seconds: float) -> bool:
        """Return whether the call has ended, after at most so many seconds; what it raised is raised."""
        if not self._done:
            with contextlib.suppress(Empty):
                self._bell.get(timeout=seconds)
        if not self._done:
            return False
        if self._problem is not None:
            raise self._problem
        return True

    def make(self) -> None:
        """Make the call, unless it was taken back."""
        if self._made_by.setdefault("by", "a thread") != "a thread":
            return
        try:
            self._call()
        except BaseException as problem:  # the owner's
            self._problem = problem
        finally:
            self._done = True
            self._bell.put(None)


def settle(tasks: Iterable[Task]) -> None:
    """Return when none of these tasks runs any more, whatever comes meanwhile: those not begun never will."""
    for task in tasks:
        while not task.withdrawn():
            with contextlib.suppress(BaseException):
                task.ended(1.0)


@functools.cache
def _tasks(process: int) -> SimpleQueue[Task | None]:
    """Return what the threads of this process take their tasks from; a fork has no threads of its parent's."""
    tasks: SimpleQueue[Task | None] = SimpleQueue()

    def work() -> None:
        while (task := tasks.get()) is not None:
            task.make()
            del task  # and what it holds

    threads = [threading.Thread(target=work, name=f"fastaff-{n}", daemon=True) for n in range(available_threads())]
    for thread in threads:
        thread.start()

    def end() -> None:
        _tasks.cache_clear()
        for _ in threads:
            tasks.put(None)
        for thread in threads:
            thread.join()

    atexit.register(end)
    return tasks
