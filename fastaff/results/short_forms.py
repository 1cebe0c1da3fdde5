"""Short forms of arguments: an unambiguous short form becomes its value before the function is called, so that result
and recipe are those of the full form.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec, Protocol, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from ..core.foreign import read_by

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


def takes(**forms: Full) -> Callable[[Callable[P, R]], Callable[P, R]]:
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
            units = next(filter(None, (read_by("units", value) for value in (*given, *named.values()))), None)
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
