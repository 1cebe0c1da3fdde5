"""Identity of values: results kept by it, and NamedTuples whose equality asks for their class."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from importlib import import_module
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
    """Return the function with its results kept for the immutable values met last, by their identity: equal values may
    differ in the sign of a zero.
    """
    known: dict[int, tuple[Any, Result]] = {}
    _ALL.append(known)

    @wraps(function)
    def kept(value: Any) -> Result:
        found = known.get(id(value))
        if found is None or found[0] is not value:
            found = value, function(value)
            if len(known) >= KNOWN:  # all: one that still knew a value would not be told that its class has changed
                for table in _ALL:
                    table.clear()
            known[id(value)] = found
        return found[1]

    return kept


def told_apart(cls: type, kind: object = None) -> type:
    """Return a class of NamedTuples whose values equal, and have the hash of, those of the same class alone, or of
    another class of the same `kind`, the text that both are made of.
    """
    known = cls if kind is None else (cls.__name__, kind)

    def equal(self: Any, other: Any) -> Any:
        if isinstance(other, tuple) and getattr(type(other), "_kind_of_value", type(other)) != known:
            return False
        return tuple.__eq__(self, other)

    def unequal(self: Any, other: Any) -> Any:
        same = equal(self, other)
        return same if same is NotImplemented else not same

    def hashed(self: Any) -> int:
        return hash((known, tuple.__hash__(self)))

    made: Any = cls
    made._kind_of_value = known
    made.__eq__ = equal
    made.__ne__ = unequal
    made.__hash__ = hashed
    return cls


def tell_apart(package: str, *more: str) -> None:
    """Make the NamedTuples of all modules of a package, which are its models, potentials or sections, `told_apart`;
    more: modules that are not loaded yet.
    """
    for name in more:
        import_module(f"{package}.{name}")
    for name, module in list(sys.modules.items()):
        if name.startswith(f"{package}."):
            for entry in list(vars(module).values()):
                if isinstance(entry, type) and entry.__module__ == name and hasattr(entry, "_fields"):
                    told_apart(entry)
