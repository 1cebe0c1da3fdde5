"""Results kept by the identity of a value: equal tuples may differ in the sign of a zero, or in their class."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

KNOWN = 64
"""Values whose results are kept at most."""

Result = TypeVar("Result")

_ALL: list[dict[int, tuple[Any, Any]]] = []
"""The results of each function, by the identity of values."""


def forget(value: Any) -> None:
    """Forget all results of a value: its class has changed."""
    for known in _ALL:
        known.pop(id(value), None)


def by_identity(function: Callable[[Any], Result]) -> Callable[[Any], Result]:
    """Return the function with its results kept for the immutable values met last."""
    known: dict[int, tuple[Any, Result]] = {}
    _ALL.append(known)

    @wraps(function)
    def kept(value: Any) -> Result:
        found = known.get(id(value))
        if found is None or found[0] is not value:
            found = value, function(value)
            if len(known) >= KNOWN:
                known.clear()
            known[id(value)] = found
        return found[1]

    return kept
