"""Long calls of libraries that Ctrl-C should stop at once."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from typing import Any


def interruptible(function: Callable, *arguments: Any) -> Any:
    """Return function(*arguments), run by a thread of its own, so that Ctrl-C reaches the main thread while LAPACK is
    busy.

    After Ctrl-C the thread ends with the call of a library that it is in; it does not keep the process alive.
    """
    found: list[tuple[Any, BaseException | None]] = []

    def run() -> None:
        try:
            found.append((function(*arguments), None))
        except BaseException as problem:
            found.append((None, problem))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        while thread.is_alive():
            thread.join(0.1)
    except BaseException:
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), ctypes.py_object(SystemExit))
        raise
    result, problem = found[0]
    if problem is not None:
        raise problem
    return result
