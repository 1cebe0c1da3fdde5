"""A limit on the time for the algebra of a formula."""

from __future__ import annotations

import contextlib
import ctypes
import threading
from collections.abc import Iterator

CEILING = 180.0
"""Seconds after which a derivation is given up."""


class _TooLong(BaseException):
    """Raised in the thread that derives; no `except Exception` of a library catches it."""


@contextlib.contextmanager
def ceiling(seconds: float = CEILING) -> Iterator[None]:
    """Raise ValueError where the body takes longer, at its next Python instruction; Ctrl-C works as usual."""
    thread, lock, over = ctypes.c_ulong(threading.get_ident()), threading.Lock(), threading.Event()

    def strike() -> None:
        with lock:
            if not over.is_set():
                ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(_TooLong))

    timer = threading.Timer(seconds, strike)
    timer.daemon = True
    timer.start()
    try:
        try:
            yield
        finally:
            with lock:
                over.set()
            timer.cancel()
    except _TooLong:
        raise ValueError(
            f"text: the derivatives of the formula take more than {seconds:.0f} s: write it with fewer nested powers "
            "and quotients, or as "
            "a class with force and tangent_force of your own"
        ) from None
