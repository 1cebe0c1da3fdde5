"""Ctrl-C and the other signals that stop a command, and what is told of them: loaded before what takes time."""

from __future__ import annotations

import _thread
import contextlib
import os
import signal
import sys
import threading
import time as clock
from collections.abc import Iterator
from types import FrameType
from typing import Any

EXIT_WRONG_INPUT, EXIT_INTERRUPTED, EXIT_BROKEN_PIPE = 2, 130, 141

AS_ONE = 2.0
"""Seconds within which signals are one: batch systems and impatient fingers send several."""

PATIENCE = 1.0
"""Seconds that the code of others may take to come to an end, before the process ends in the middle of it."""

OTHERS = ("matplotlib", "contourpy", "kiwisolver", "PIL")
"""Packages whose compiled code calls Python and takes an exception from there for wrong input, or crashes."""

GOING = ("weakref.py", "_weakrefset.py")
"""Modules that are called when objects go."""

STOPPING = [number for name in ("SIGINT", "SIGTERM", "SIGHUP") if (number := getattr(signal, name, None)) is not None]
"""Ctrl-C; what batch systems send; what a terminal sends when it is closed."""


def say(text: str) -> None:
    """Tell the user one line, on stderr, if anybody is there."""
    with contextlib.suppress(OSError, ValueError, AttributeError):  # a terminal that is gone, a stream that is closed
        sys.stderr.write(f"fastaff: {text}\n")
        sys.stderr.flush()


@contextlib.contextmanager
def on_stop(handler: Any, for_good: bool = False) -> Iterator[None]:
    """Let what stops a command call a handler within the block, or `for_good`; what is ignored, as by nohup, stays
    so.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in STOPPING}
    taken = {number: old for number, old in before.items() if old not in (signal.SIG_IGN, None)}
    for number in taken:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, old in taken.items() if not for_good else ():
            signal.signal(number, old)


def _wake(number: int) -> None:
    """Send a signal to the main thread, which may be waiting for a lock."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        _thread.interrupt_main(signal.Signals(number))


def _others(frame: FrameType | None) -> bool:
    """Return whether a frame is of an import, of what is called when objects go, whose exceptions are only printed, or
    of a package that an exception may break in the middle.
    """
    while frame is not None:
        path = frame.f_code.co_filename
        if path.startswith("<frozen importlib") or path.endswith(GOING) or frame.f_code.co_name == "__del__":
            return True
        package = frame.f_globals.get("__name__", "").partition(".")[0]
        if package in OTHERS:
            return True
        if package == __package__.partition(".")[0]:
            return False
        frame = frame.f_back
    return False


class Stops:
    """What Ctrl-C and its like do to a command: end it while it is being loaded, stop at once what computes or draws,
    and wait while a result is held that is not written yet, or while code runs that it would break. Several in a row
    are one.
    """

    own = loading = holding = arrived = waiting = ended = leaving = False
    """Whether the process is this command's alone; whether it is being loaded, holds a result, was stopped meanwhile,
    waits for others' code to be stopped, has ended, is left.
    """
    code: int | None = None
    sent: int | None = None
    """The signal that has come, of several the first."""
    last = -AS_ONE

    @classmethod
    def begin(cls, own: bool) -> None:
        """Begin a command, with what it needs still to be loaded."""
        cls.own, cls.loading, cls.holding, cls.arrived, cls.ended = own, True, False, False, False
        cls.waiting = False
        cls.code, cls.sent, cls.last = None, None, -AS_ONE

    @classmethod
    def said(cls) -> str:
        """Say by what the command was stopped: Ctrl-C, which is SIGINT, or the name of another signal."""
        return f"stopped by {'Ctrl-C' if cls.sent in (None, signal.SIGINT) else signal.Signals(cls.sent).name}"

    @classmethod
    def handle(cls, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        cls.sent = cls.sent or number
        if cls.loading and not cls.ended:  # modules of others may swallow an exception, or tell of it
            cls.leave("before anything was computed")
        if cls.holding and not cls.ended:
            cls.arrived = True
            return
        before, now = cls.last, clock.monotonic()
        if now - before < AS_ONE:
            return
        if not cls.ended and _others(frame):
            if not cls.waiting:
                cls.waiting = True
                _thread.start_new_thread(cls._ring, (number,))  # without locks, which this may have interrupted
            return
        cls.last, cls.waiting = now, False
        if not cls.ended:
            raise KeyboardInterrupt
        if cls.own and cls.code is not None:  # the interpreter is about to end, which others' threads may delay
            os._exit(cls.code)

    @classmethod
    def _ring(cls, number: int) -> None:
        """Send a signal that waits again and again, until it is taken."""
        end = clock.monotonic() + PATIENCE
        while cls.waiting and not cls.ended:
            clock.sleep(0.001)
            if cls.own and clock.monotonic() > end and cls.waiting and not cls.ended:
                cls.leave("in the middle of what could not be interrupted", "nothing is kept but what is named above")
            _wake(number)

    @classmethod
    def check(cls) -> None:
        """Stop, where a signal waits for this moment, in which no code of others runs."""
        if cls.waiting:
            cls.last, cls.waiting = clock.monotonic(), False
            raise KeyboardInterrupt

    @classmethod
    def leave(cls, when: str, kept: str = "nothing is kept") -> None:
        """End the process at once: there is nothing to keep, or nothing that could be interrupted otherwise."""
        if not cls.leaving:
            cls.leaving = True
            say(f"{cls.said()} {when}; {kept}")
            os._exit(EXIT_INTERRUPTED)

    @classmethod
    @contextlib.contextmanager
    def later(cls) -> Iterator[None]:
        """Let a signal stop the command after the block, not in the middle of it."""
        before, cls.holding = cls.holding, True
        try:
            yield
        finally:
            if not before:
                cls.release()

    @classmethod
    def release(cls) -> None:
        """Hold nothing from now on: what has arrived meanwhile stops."""
        cls.holding, before = False, cls.arrived
        cls.arrived = False
        if before:
            cls.last = clock.monotonic()
            raise KeyboardInterrupt
