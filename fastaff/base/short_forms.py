"""Short forms of arguments: what stands for a value without doubt is made the value before anything else sees it, so
that result and recipe are those of the full form.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

Full = Callable[[Any, Any], Any]
"""The full form of an argument: a function of what was given and of the function's first argument, its system."""


def takes(**forms: Full) -> Callable[[Callable], Callable]:
    """Let a function take short forms of some of its keywords."""

    def wrap(function: Callable) -> Callable:
        first = next(iter(inspect.signature(function).parameters))

        @functools.wraps(function)
        def wrapped(*given: Any, **named: Any) -> Any:
            for name in forms.keys() & named.keys():
                named[name] = forms[name](named[name], given[0] if given else named.get(first))
            return function(*given, **named)

        return wrapped

    return wrap


def names_of(value: Any, _: Any = None) -> Any:
    """Return the names in a text, with commas or spaces between them; anything else as it is."""
    return tuple(value.replace(",", " ").split()) if isinstance(value, str) else value


def axes_of(value: Any, _: Any = None) -> Any:
    """Return the one axis that plain numbers stand for; anything else as it is."""
    alone = isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iuf"
    alone |= isinstance(value, (list, tuple)) and len(value) > 0 and all(type(entry) in (int, float) for entry in value)
    return (value,) if alone else value
