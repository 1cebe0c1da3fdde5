"""Threads that run compiled code: how many, and what they are given to do.

Compiled code lets go of the GIL, so Python's own threads will do. They leave nothing behind that a fork could not
survive, as OpenMP does, and several callers may use them at once.
"""

from __future__ import annotations

import _thread
import atexit
import contextlib
import functools
import os
import threading
import time as clock
from collections.abc import Callable, Iterable, Iterator
from queue import Empty, SimpleQueue
from typing import Any

import numba
from numba.np.ufunc import parallel

from ..base.memory import keep_freed
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
        self._made_by: dict[str, object] = {}
        self._bell: SimpleQueue[None] = SimpleQueue()
        self._begun = self._done = False
        self._problem: BaseException | None = None

    def begin(self) -> None:
        """Let a thread make the call."""
        self._begun = True
        _tasks(os.getpid()).put(self)

    def withdrawn(self) -> bool:
        """Return whether the call runs no more: not begun, it never will."""
        return self._made_by.setdefault("by", "nobody") == "nobody" or self._done

    def ended(self, seconds: float) -> bool:
        """Return whether the call has ended, after at most so many seconds; what it raised is raised. Where all threads
        are busy with the work of others until then, it gets one of its own.
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
        """Make the call, unless it was taken back or another thread has."""
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
    """A thread that makes what others have begun."""


def _started(target: Callable[[], object]) -> _Worker:
    """Return a worker that another thread starts: of `Thread.start` a Ctrl-C may make a RuntimeError."""
    worker = _Worker(target=target, daemon=True)
    _thread.start_new_thread(worker.start, ())
    return worker


_UNDER_WAY: dict[object, Callable[[], object]] = {}
"""How work of threads but the main one is told to come to an end."""

_ENDING = threading.Event()
"""Whether the interpreter ends, which lets go of what daemon threads hold while their compiled code uses it."""

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_UNDER_WAY.clear)  # a fork has none of these threads


@contextlib.contextmanager
def ending(stop: Callable[[], object]) -> Iterator[None]:
    """Run compiled code that stop() brings to an end before its time. Where the interpreter ends meanwhile it is called
    and waited for, and the thread, which is a daemon's, ends with SystemExit: what it has come to is no result.
    """
    thread = threading.current_thread()
    # In the main thread the interpreter ends; workers have an owner.
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
    """Make calls in threads, with between() about ten times a second in this one; whatever comes, stop() brings all of
    them to an end and none is left running.
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
            settle(tasks)
            raise


def works() -> bool:
    """Return whether this thread makes what others have begun: what it begins would wait for a free one."""
    return isinstance(threading.current_thread(), _Worker)


FEW = 2**16
"""Numbers of which a portion has at least what threads are woken for."""


def by_portions(call: Callable[[slice], object], count: int, each: int, threads: int) -> None:
    """Make call(slice) for portions of so many things, of `each` numbers each, in threads: for NumPy, which lets go of
    the GIL. The calls must change nothing but their own portion, and set what errors NumPy ignores themselves.
    """
    portions = max(1, min(threads, count * each // FEW))
    size = max(-(-count // portions), 1)
    by_workers(lambda worker: call(slice(worker * size, (worker + 1) * size)), -(-count // size))


def by_workers(call: Callable[[int], object], workers: int) -> None:
    """Make call(worker) for so many workers, each in a thread; of one in the caller's."""
    if workers == 1:
        call(0)
    else:
        together([functools.partial(call, worker) for worker in range(workers)], int, int)


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
    keep_freed()

    def work() -> None:
        while (task := tasks.get()) is not None:
            task.make()
            del task  # and what it holds

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
