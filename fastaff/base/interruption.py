"""Ctrl-C in a long function: what was found until then is kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run; `.partial` is the result so far, where unfinished orbits have the status INTERRUPTED.

    What is finished in it has the bits that it would have had. While a function still chooses steps there is nothing so
    far: there Ctrl-C is a plain KeyboardInterrupt.
    """

    partial: Any = None


@contextmanager
def keeping(function: str, partial: Callable[[], Any]) -> Iterator[None]:
    """Turn Ctrl-C within the block into Interrupted, with partial() as the result of `function` so far.

    A function called within it, which has a partial result of its own kind, is part of this one's work: that is lost
    unless partial() uses it.
    """
    try:
        yield
    except KeyboardInterrupt:
        stopped = Interrupted(function)
        stopped.partial = partial()
        raise stopped from None
