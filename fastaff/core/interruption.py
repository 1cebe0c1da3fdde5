"""Ctrl-C in a long function: the results so far are kept; Ctrl-C waits where it would break the code of others."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any


class Interrupted(KeyboardInterrupt):
    """Report Ctrl-C during a run, with the result so far.

    Unfinished orbits have the status INTERRUPTED. Finished parts are bitwise the same as in a complete run. While a
    function still chooses steps there is no result: Ctrl-C raises ``KeyboardInterrupt``.

    Attributes
    ----------
    partial : Result or None
        Result so far.
    """

    partial: Any = None


@contextmanager
def partial_result_on_interrupt(function: str, partial: Callable[[], Any]) -> Iterator[None]:
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


@contextmanager
def reraise_interrupt() -> Iterator[None]:
    """Raise Ctrl-C as KeyboardInterrupt where the code of others turns it into another exception."""
    earlier = sys.exc_info()[1]  # which the caller has dealt with
    try:
        yield
    except Exception as problem:
        cause: BaseException | None = problem
        while cause is not earlier and cause is not None and not isinstance(cause, KeyboardInterrupt):
            cause = cause.__cause__ or cause.__context__
        if cause is not earlier and cause is not None:
            raise cause from None
        raise


@contextmanager
def defer_signals() -> Iterator[Callable[[], None]]:
    """Put signals off until the end of the block, and yield a function that handles those that have come, to be called
    at safe moments: an exception of a handler would be lost in the code of others, or leave its work half done.
    """
    main = threading.get_ident()
    if threading.current_thread() is not threading.main_thread():  # where nothing is raised
        yield lambda: None
        return
    before: dict[int, Any] = {n: taken for n in signal.valid_signals() if callable(taken := signal.getsignal(n))}
    arrived: list[int] = []

    def take() -> None:
        if threading.get_ident() == main:  # the code of others may ask from other threads
            _taken(arrived, before)

    problem = None
    try:
        for number in before:
            signal.signal(number, lambda number, _: arrived.append(number))
        yield take
    finally:
        for number, taken in before.items():
            while signal.getsignal(number) is not taken:
                try:
                    signal.signal(number, taken)
                except BaseException as raised:  # by a handler that is back in its place
                    problem = raised
        _taken(arrived, before)
        if problem is not None:
            raise problem


EXTRAS = {
    "dask": "dask",
    "h5netcdf": "io",
    "matplotlib": "plot",
    "pyarrow": "tools",
    "sympy": "symbolic",
    "xarray": "io",
    "zarr": "io",
}
"""Extras that install the packages of others that are optional."""


def extra_of(package: str) -> str:
    """Return the command that installs an optional package."""
    return f"pip install 'fastaff[{EXTRAS[package]}]'"


def imported(name: str, package: str | None = None, what: str = "this") -> Any:
    """Return a module, loaded where it is not yet. Ctrl-C waits: it would leave modules half loaded for good. Raises
    ModuleNotFoundError where an optional package is missing: it names the feature and the extra to install.
    """
    try:
        with defer_signals():
            return import_module(name, package)
    except ModuleNotFoundError as problem:
        missing = (problem.name or "").partition(".")[0]
        if missing not in EXTRAS:
            raise
        said = f"{what} needs {missing}: {extra_of(missing)}"
        raise ModuleNotFoundError(said, name=missing) from None


def _taken(arrived: list[int], handlers: Mapping[int, Any]) -> None:
    """Call the handler of each signal that has come, even if another handler raises; raise the last exception."""
    problem = None
    while arrived:
        number = arrived.pop(0)
        try:
            handlers[number](number, sys._getframe())
        except BaseException as raised:
            problem = raised
    if problem is not None:
        raise problem
