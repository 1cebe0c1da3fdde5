"""Threads that run compiled code: their number and their tasks.

Compiled code releases the GIL, so Python's own threads are enough. Unlike those of OpenMP they do no harm to a fork,
and several callers may use them at once.
"""

from __future__ import annotations

import _thread
import atexit
import contextlib
import functools
import math
import os
import threading
import time as clock
from collections.abc import Callable, Iterable, Iterator
from queue import Empty, SimpleQueue
from typing import Any

import numba
import numpy as np

from ..core.memory import keep_freed
from ..core.numbers import whole
from .jit import JIT_DISABLED
from .numba_private import parallel


def default_threads() -> int:
    """Return the default number of threads of kernels: that of `numba.set_num_threads` if it was called, else
    $NUMBA_NUM_THREADS or the cores of this process.
    """
    if JIT_DISABLED:
        return 1
    # A question to Numba would start its own threads, unless they run already.
    return numba.get_num_threads() if parallel._is_initialized else available_threads()


def available_threads() -> int:
    """Return the largest number of threads that kernels can use in this process."""
    return 1 if JIT_DISABLED else int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def checked_threads(threads: Any) -> int:
    """Return the number of threads to use: `threads` if this process can have so many, the default for None."""
    count = default_threads() if threads is None else whole("threads", threads, 1)
    if count > available_threads():
        raise ValueError(f"threads must be at most {available_threads()} here, got {count}")
    return count


class Task:
    """A call that a thread of this process makes, unless it is cancelled before.

    Ctrl-C may reach its owner anywhere; a lock, as in `concurrent.futures`, could then stay locked for ever.
    """

    def __init__(self, call: Callable[[], object]):
        self._call = call
        self._made_by: dict[str, object] = {}
        self._bell: SimpleQueue[None] = SimpleQueue()
        self._begun = self._done = False
        self._problem: BaseException | None = None

    def begin(self) -> None:
        """Let a thread make the call."""
        self._begun = True
        _tasks(os.getpid()).put(self)

    def cancelled(self) -> bool:
        """Return whether the call does not run; if it has not begun, it never will."""
        return self._made_by.setdefault("by", "nobody") == "nobody" or self._done

    def ended(self, seconds: float) -> bool:
        """Return whether the call has ended, after at most that many seconds; raise its exception if it has one. If all
        threads are busy with other work until then, it gets a thread of its own.
        """
        if not self._done:
            with contextlib.suppress(Empty):
                self._bell.get(timeout=seconds)
        if not self._done:
            if self._begun and not self._made_by:
                _started(self.make)
            return False
        if self._problem is not None:
            raise self._problem
        return True

    def make(self) -> None:
        """Make the call, unless it was cancelled or another thread has made it."""
        mine = object()
        if self._made_by.setdefault("by", mine) is not mine:
            return
        try:
            self._call()
        except BaseException as problem:  # the owner's
            self._problem = problem
        finally:
            self._done = True
            self._bell.put(None)


class _Worker(threading.Thread):
    """A thread that makes calls for other threads, with a number of threads for kernels of its own."""

    threads = 1


def _started(target: Callable[[], object]) -> _Worker:
    """Return a worker that another thread starts: Ctrl-C in `Thread.start` may become a RuntimeError."""
    worker = _Worker(target=target, daemon=True)
    _thread.start_new_thread(worker.start, ())
    return worker


_UNDER_WAY: dict[object, Callable[[], object]] = {}
"""Functions that stop the work of threads other than the main one."""

_ENDING = threading.Event()
"""Whether the interpreter ends: it then frees objects of daemon threads while their compiled code uses them."""

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_UNDER_WAY.clear)  # a fork has none of these threads


@contextlib.contextmanager
def ending(stop: Callable[[], object]) -> Iterator[None]:
    """Run compiled code that stop() can end early. If the interpreter ends meanwhile, it calls stop() and waits, and
    the daemon thread ends with SystemExit: the unfinished work is no result.
    """
    thread = threading.current_thread()
    # The interpreter ends in the main thread; workers have an owner.
    if thread is threading.main_thread() or isinstance(thread, _Worker):
        yield
        return
    mark = object()
    _UNDER_WAY[mark] = stop
    try:
        if _ENDING.is_set():
            raise SystemExit
        yield
    finally:
        _UNDER_WAY.pop(mark, None)
    if _ENDING.is_set():
        raise SystemExit


@atexit.register
def _end() -> None:
    _ENDING.set()
    while _UNDER_WAY:
        for stop in list(_UNDER_WAY.values()):
            stop()
        clock.sleep(0.001)


def together(calls: Iterable[Callable[[], object]], stop: Callable[[], object], between: Callable[[], object]) -> None:
    """Make calls in threads, with between() about ten times a second in this one; after any exception stop() ends all
    of them, and none is left running.
    """
    tasks = [Task(call) for call in calls]
    with ending(stop):
        try:
            for task in tasks:
                task.begin()
            for task in tasks:
                while not task.ended(0.1):
                    between()
        except BaseException:
            stop()
            join_all(tasks)
            raise


def works() -> bool:
    """Return whether this thread is a worker: a task that it begins would wait for a free thread."""
    return isinstance(threading.current_thread(), _Worker)


def own_threads(threads: int) -> int:
    """Return how many of so many threads this one may use: all of them, or as many as it has got as a worker."""
    here = threading.current_thread()
    return min(threads, here.threads) if isinstance(here, _Worker) else threads


FEW = 2**17
"""Least numbers in a portion that justify another thread: of smaller arrays most of the time is Python's, whose lock
only one thread holds.
"""

PORTIONS = 4
"""Most portions. N numbers in p portions take a time in proportion to N/p + p FEW/2, as each waits for Python's lock
between any two operations of NumPy, hence p = (2 N/FEW)^(1/2); with more than these, 16 cores took longer for any N.
Threads that are left run kernels of the portions.
"""


def by_portions(
    call: Callable[[slice], object], count: int, each: int | np.ndarray, threads: int, least: int = 1
) -> None:
    """Make call(slice) for portions of `count` items of `each` numbers (count,), at least so many, in threads: for
    NumPy, which releases the GIL. A call must change only its own portion, and set itself which errors NumPy ignores.
    """
    alike = np.ndim(each) == 0
    numbers = int(count * each if alike else np.sum(each))
    threads = own_threads(threads)
    portions = min(threads, PORTIONS, math.isqrt(2 * numbers // FEW), count // least)
    if portions <= 1:
        if count:
            call(slice(0, count))
        return
    shares = np.arange(1, portions) / portions
    inner = np.floor(count * shares) if alike else np.searchsorted(np.cumsum(each), numbers * shares, side="right")
    ends = np.unique([0, *inner, count]).astype(int).tolist()
    by_workers(lambda worker: call(slice(ends[worker], ends[worker + 1])), len(ends) - 1, threads // portions)


def by_workers(call: Callable[[int], object], workers: int, threads: int = 1) -> None:
    """Make call(worker) for worker = 0, ..., workers - 1, each in a thread, with so many threads for its kernels; a
    single one in the caller's. A worker makes those calls itself that no other thread has begun.
    """

    def share(worker: int) -> None:
        here = threading.current_thread()
        assert isinstance(here, _Worker)
        before = here.threads
        here.threads = threads
        try:
            call(worker)
        finally:
            here.threads = before

    if workers == 1:
        call(0)
        return
    calls = [functools.partial(share, worker) for worker in range(workers)]
    if not works():
        together(calls, int, int)
        return
    tasks = [Task(call) for call in calls]
    try:
        for task in tasks[1:]:
            task.begin()
        for task in tasks:
            task.make()
        for task in tasks:
            while not task.ended(0.1):
                pass
    except BaseException:
        join_all(tasks)
        raise


def join_all(tasks: Iterable[Task]) -> None:
    """Wait until none of these tasks runs, despite any exception meanwhile; those not begun never will."""
    for task in tasks:
        while not task.cancelled():
            with contextlib.suppress(BaseException):
                task.ended(1.0)


@functools.cache
def _tasks(process: int) -> SimpleQueue[Task | None]:
    """Return the queue from which the threads of this process take tasks; a fork has no threads of its parent."""
    tasks: SimpleQueue[Task | None] = SimpleQueue()
    keep_freed()

    def work() -> None:
        while (task := tasks.get()) is not None:
            task.make()
            del task  # and the objects that it holds

    threads = [_started(work) for _ in range(available_threads())]

    def end() -> None:
        _end()
        _tasks.cache_clear()
        for _ in threads:
            tasks.put(None)
        for thread in threads:
            if thread.is_alive():
                thread.join()

    atexit.register(end)
    return tasks
