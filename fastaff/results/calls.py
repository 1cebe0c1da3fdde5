"""The call of a verb: short forms of arguments become values, and the result keeps the call as plain data.

An unambiguous short form becomes its value before the function is called, so that result and record are those of the
full form. The record is written into the file of a result and is enough to run the call again.
"""

from __future__ import annotations

import contextlib
import dataclasses
import enum
import functools
import inspect
import math
from collections.abc import Callable
from typing import Any, NamedTuple, ParamSpec, Protocol, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from ..core.foreign import dispatch_adapter
from ..core.names import did_you_mean, shortened
from ..core.numbers import checked_callback, listed
from .progress import watched

Full = Callable[[Any, Any], Any]
"""The full form of an argument: a function of the given value and of the function's first argument, its system."""


P = ParamSpec("P")
R = TypeVar("R")


class Launched(Protocol):
    """A grid or a sample of phase points."""

    @property
    def z0(self) -> np.ndarray:
        """Phase points (2n, orbits)."""


Starts = ArrayLike | Launched
"""Phase points, or an object that has them; objects of other tools have no types."""


def coerces_arguments(**forms: Full) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let a function take short forms of some of its arguments after the first, and the section from its starts where
    these lie on one.
    """

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        first, *rest = inspect.signature(function).parameters
        by_position = [forms.get(name) for name in rest]
        on_section = rest[:1] == ["z0"] and {"z0", "section"} <= forms.keys()

        @functools.wraps(function)
        def wrapped(*given: Any, **named: Any) -> Any:
            system = given[0] if given else named.get(first)
            units = next(filter(None, (dispatch_adapter("units", value) for value in (*given, *named.values()))), None)
            if on_section and named.get("section") is None:
                starts = given[1] if len(given) > 1 else named.get(rest[0])
                if (section := getattr(starts, "section", None)) is not None:
                    named["section"] = section
            for name in forms.keys() & named.keys():
                named[name] = forms[name](named[name], system)
            more = [value if make is None else make(value, system) for make, value in zip(by_position, given[1:])]
            result = function(*given[:1], *more, *given[1 + len(more) :], **named)
            if units is not None and dataclasses.is_dataclass(result):
                object.__setattr__(result, "units", units)
            return result

        return cast(Callable[P, R], wrapped)

    return wrap


def names_of(value: Any, _: Any = None) -> Any:
    """Return the names in a text, with commas or spaces between them; anything else as it is."""
    return tuple(value.replace(",", " ").split()) if isinstance(value, str) else value


def axes_of(value: Any, _: Any = None) -> Any:
    """Return plain numbers as a tuple of one axis; anything else as it is."""
    alone = isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iuf"
    alone |= isinstance(value, (list, tuple)) and len(value) > 0 and all(type(entry) in (int, float) for entry in value)
    return (value,) if alone else value


OWN = "fastaff"

RECORDED = "_fastaff_recorded"
"""Attribute of functions whose calls are kept with their results."""


ABBREVIATED = {"E": ("energy",), "t": ("time", "max_time"), "T": ("time", "max_time"), "dt": ("step",), "h": ("step",)}
"""Names of arguments that common letters stand for."""


OF_SYSTEMS = {"vector_potential", "drive_period", "periodic", "coordinates", "momenta"}
"""Arguments of systems, which are sometimes given to calls that take one, beside those of terms."""

ELSEWHERE = {
    **dict.fromkeys(("precision", "dtype"), "numbers are doubles; accuracy=, or tolerances, say how small errors are"),
    **dict.fromkeys(
        ("chunks", "chunksize", "batch", "batch_size"), "fastaff.run(fastaff.Job(...), store) goes by parts"
    ),
    **dict.fromkeys(("n_jobs", "workers", "processes"), "threads= share a call, fastaff.run(job, store) processes"),
    **dict.fromkeys(
        ("progress", "verbose", "tqdm"), "fastaff.show_progress(False) silences what is said, callback= is told"
    ),
}
"""Arguments of other programs, each with its counterpart here."""


class Call(NamedTuple):
    """A call of a public function: its name, its arguments as `encoded` data, and the names of those that are no data
    (functions).
    """

    function: str
    arguments: dict[str, Any]
    missing: tuple[str, ...] = ()


class NotSerializable(TypeError):
    """Raised for a value that is no number, text, value of the package or collection of these."""


def records_call(function: Callable[P, R]) -> Callable[P, R]:
    """Make a function keep its call with the dataclass that it returns, as the attribute `call`.

    `callback` is no part of the call; it is checked here. A partial result of an interrupted call keeps the call too.
    If arguments do not fit, the function itself raises.
    """
    signature = inspect.signature(function)

    @functools.wraps(function)
    def wrapped(*given: Any, **named: Any) -> Any:
        try:
            bound = signature.bind(*given, **named)
        except TypeError:
            return _misfit(function, signature, given, named)
        bound.apply_defaults()
        checked_callback(bound.arguments.get("callback"))
        call = _call(function.__name__, bound.arguments)
        try:
            told = bound.arguments.get("callback") is not None
            with contextlib.nullcontext() if told else watched(function.__name__) as callback:
                if callback is not None and "callback" in bound.arguments:
                    named["callback"] = callback
                result = function(*given, **named)
        except BaseException as problem:
            if dataclasses.is_dataclass(getattr(problem, "partial", None)):
                keep(problem.partial, call)  # type: ignore[attr-defined]
            raise
        return keep(result, call)

    vars(wrapped)[RECORDED] = True
    return cast(Callable[P, R], wrapped)


def is_recorded(function: object) -> bool:
    """Tell whether a function is one that `records_call` made: only these are the calls of results."""
    return bool(getattr(function, RECORDED, False))


LONGEST = 160
"""Characters of a message."""


def _misfit(function: Callable, signature: inspect.Signature, given: tuple, named: dict[str, Any]) -> Any:
    """Call a function with arguments that do not fit; raise its TypeError with the names that it takes."""
    from ..engine.kinds import OPTIONS

    names = [*signature.parameters]
    first = [name for name, entry in signature.parameters.items() if entry.kind is not entry.KEYWORD_ONLY]
    hint = f"; by position {', '.join(first)}, all else by name." if len(given) > len(first) else ""
    for name in [name for name in named if name not in names][:1]:
        meant = [other for other in ABBREVIATED.get(name, ()) if other in names]
        hint = f".{f' Did you mean {meant[0]}?' if meant else did_you_mean(name, names)}"
        if name in OF_SYSTEMS or name in OPTIONS:
            hint = f". Use hamiltonian('...', {name}=...)."
        if name in ELSEWHERE:
            hint = f": {ELSEWHERE[name]}."
    try:
        return function(*given, **named)
    except TypeError as problem:
        room = LONGEST - len(f"{problem}{hint or '.'} It takes .")
        helped = "Did you mean" in hint or " Use " in hint or room < len(names[0])
        known = "" if helped else f" It takes {shortened(listed(names).split(', '), room)}."
        raise TypeError(f"{problem}{hint or '.'}{known}") from None


def keep(result: Any, call: Call | None) -> Any:
    """Return the result with a call that made it."""
    if call is not None and not isinstance(result, type) and dataclasses.is_dataclass(result):
        object.__setattr__(result, "call", call)
    return result


def _call(name: str, given: dict[str, Any]) -> Call:
    arguments = {}
    missing = []
    for key, value in given.items():
        if key != "callback":
            try:
                arguments[key] = encoded(value)
            except (NotSerializable, RecursionError):
                missing.append(key)
    return Call(name, arguments, tuple(missing))


def encoded(value: Any) -> Any:
    """Return a value as data that JSON holds exactly, except arrays, which are copied; raise NoData for other values.

    Values and schemes become their class with its fields, a class of the user's with its module, a model of a formula
    with its text.
    """
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, (enum.Enum, np.timedelta64)):
        raise NotSerializable
    if isinstance(value, (int, np.integer, np.bool_)):
        return bool(value) if isinstance(value, np.bool_) else int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else {"float": str(float(value))}
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return value.copy()
    if hasattr(value, "form") and hasattr(value, "singular"):
        return {"chart": value.name}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return _class(value, value._fields)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        name = getattr(value, "name", None)
        if isinstance(name, str) and repr(value) == name:
            return {"scheme": repr(value)}
        return _class(value, [field.name for field in dataclasses.fields(value)])
    if isinstance(value, (list, tuple)):
        return [encoded(entry) for entry in value]
    raise NotSerializable


def _class(value: Any, names: Any) -> dict[str, Any]:
    """Return class and fields of a value; for a generated class also the request that it answers."""
    cls = type(value)
    own = cls.__module__.partition(".")[0] == OWN
    request = getattr(cls, "_request", None)
    origin: dict[str, Any]
    if request is not None:
        origin = {"formula": list(request)}
    elif own:
        origin = {}
    else:
        origin = {"module": cls.__module__}
    return {"class": cls.__name__, **origin, **{name: encoded(getattr(value, name)) for name in names}}


def plain(value: Any) -> Any:
    """Return `value` as JSON holds it: values by class and fields (`encoded`), schemes by name, infinities as
    text.
    """
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else str(float(value))
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        try:
            return plain(encoded(value))
        except NotSerializable:
            return {
                "class": type(value).__name__,
                **{name: plain(entry) for name, entry in zip(value._fields, value, strict=True)},
            }
    if hasattr(value, "name") and hasattr(value, "order") and hasattr(value, "source"):
        return {"name": value.name, "order": value.order, "source": value.source}
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, set, np.ndarray)):
        return [plain(entry) for entry in value]
    return str(value)
