"""Ctrl-C and the other signals that stop a command, and their messages; this module is loaded before the slow ones."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time as clock
from collections.abc import Iterator
from types import FrameType
from typing import Any

EXIT_WRONG_INPUT = 2
"""Exit code of a command with wrong input."""

EXIT_INTERRUPTED = 130
"""Exit code of a command that Ctrl-C has ended: 128 + SIGINT."""

EXIT_BROKEN_PIPE = 141
"""Exit code of a command whose reader has gone: 128 + SIGPIPE."""

AS_ONE = 2.0
"""Seconds within which signals are one: batch systems and impatient fingers send several."""

STOPPING = [number for name in ("SIGINT", "SIGTERM", "SIGHUP") if (number := getattr(signal, name, None)) is not None]
"""Ctrl-C; the signal of batch systems; the signal of a terminal that is closed."""


def say(text: str) -> None:
    """Tell the user one line, on stderr, if anybody is there."""
    with contextlib.suppress(OSError, ValueError, AttributeError):  # a terminal that is gone, a stream that is closed
        sys.stderr.write(f"fastaff: {text}\n")
        sys.stderr.flush()


@contextlib.contextmanager
def on_stop(handler: Any, for_good: bool = False) -> Iterator[None]:
    """Let the stopping signals call a handler within the block, or `for_good`; a signal that is ignored, as by nohup,
    stays so.
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


class Stops:
    """The effect of Ctrl-C and its like on a command: end it while it is being loaded, stop its computing or drawing at
    once, and wait while it holds a result that is not written yet. Several in a row are one.
    """

    own = loading = holding = arrived = ended = leaving = False
    """Whether the process is this command's alone; whether it is being loaded, holds a result, was stopped meanwhile,
    has ended, is left.
    """
    code: int | None = None
    sent: int | None = None
    """The signal that has come, of several the first."""
    last = -AS_ONE

    @classmethod
    def begin(cls, own: bool) -> None:
        """Begin a command, whose modules are still to be loaded."""
        cls.own = own
        cls.loading = True
        cls.holding = False
        cls.arrived = False
        cls.ended = False
        cls.code = None
        cls.sent = None
        cls.last = -AS_ONE

    @classmethod
    def said(cls) -> str:
        """Name the signal that stopped the command: Ctrl-C, which is SIGINT, or the name of another one."""
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
        before = cls.last
        now = clock.monotonic()
        if now - before < AS_ONE:
            return
        cls.last = now
        if not cls.ended:
            raise KeyboardInterrupt
        if cls.own and cls.code is not None:  # the interpreter is about to end, which others' threads may delay
            os._exit(cls.code)

    @classmethod
    def leave(cls, when: str) -> None:
        """End the process at once: there is nothing to keep."""
        if not cls.leaving:
            cls.leaving = True
            say(f"{cls.said()} {when}; nothing new is kept")
            os._exit(EXIT_INTERRUPTED)

    @classmethod
    @contextlib.contextmanager
    def later(cls) -> Iterator[None]:
        """Let a signal stop the command after the block, not in the middle of it."""
        before = cls.holding
        cls.holding = True
        try:
            yield
        finally:
            if not before:
                cls.release()

    @classmethod
    def release(cls) -> None:
        """Hold nothing from now on: a signal that has arrived meanwhile stops the command."""
        before = cls.arrived
        cls.holding = False
        cls.arrived = False
        if before:
            cls.last = clock.monotonic()
            raise KeyboardInterrupt
