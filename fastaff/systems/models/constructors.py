"""Checks of the arguments of models and potentials: a NamedTuple cannot define a `__new__`."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

T = TypeVar("T", bound=type)


def checks_arguments(check: Callable[[Mapping[str, Any]], None]) -> Callable[[T], T]:
    """Return a decorator of NamedTuples whose given arguments, by name, `check` must accept: it raises an error if they
    are wrong. Defaults are not among them. The class then makes the value, or refuses arguments that it does not have.
    """

    def checked(cls: T) -> T:
        made: Any = cls.__new__
        fields: tuple[str, ...] = cls._fields  # type: ignore[attr-defined]

        @functools.wraps(made)
        def wrapped(own: type, *given: Any, **named: Any) -> Any:
            check({**dict(zip(fields, given)), **named})
            return made(own, *given, **named)

        cls.__new__ = wrapped  # type: ignore[method-assign, assignment]
        return cls

    return checked
