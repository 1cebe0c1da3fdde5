"""Values: the NamedTuples that are models, potentials, sections, angles and parts of these, as Python sees them.

What is known of a value is kept by its identity; equal values of two classes are told apart. A value has parameters,
and a line of text that builds it from them again. Its class has methods, which may be replaced, and which have values
at many points.
"""

from __future__ import annotations

import functools
import inspect
import itertools
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, TypeVar

import numpy as np

from ..core.numbers import reason, shown

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

    @functools.wraps(function)
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


def is_value(candidate: Any) -> bool:
    """Tell whether `candidate` is a NamedTuple instance."""
    return isinstance(candidate, tuple) and hasattr(candidate, "_fields")


def is_number(entry: Any) -> bool:
    """Tell whether an entry is a real number."""
    taken = isinstance(entry, (int, float, np.integer, np.floating))
    return taken and not isinstance(entry, (bool, np.timedelta64))


def parameters(value: Any) -> np.ndarray:
    """Flatten the float parameters of a NamedTuple of NamedTuples, in field order."""
    return _known(value)[1].copy()


def built(value: Any) -> tuple[str, tuple]:
    """Return the line of text that makes `value` of params, and its classes with their names there and the states of
    their methods.
    """
    return _known(value)[0]


@by_identity
def _known(value: Any) -> tuple[tuple[str, tuple], np.ndarray]:
    """Return the line and classes of `built`, and the numbers; a call needs them some forty times."""
    flat: list[float] = []
    classes: dict[type, str] = {}
    line = f"    value = {_walk(value, flat, classes)}\n"
    built = line, tuple((cls, name, state_of(cls)) for cls, name in classes.items())
    return built, np.array(flat, dtype=np.float64) if flat else np.zeros(1)


def _float(name: str, number: Any) -> float:
    try:
        return float(number)
    except OverflowError:
        raise ValueError(f"{name} must be within the range of floats") from None


def _walk(value: Any, flat: list[float], classes: dict[type, str]) -> str:
    """Collect parameters and classes; return the source text that builds `value` from `params`."""
    name = classes.setdefault(type(value), f"Value{len(classes)}")
    arguments = []
    declared = getattr(type(value), "__annotations__", {})
    for field, entry in zip(value._fields, value, strict=True):
        number = getattr(declared.get(field), "__forward_arg__", declared.get(field)) in (float, int, "float", "int")
        if is_value(entry) and not number:
            try:
                arguments.append(_walk(entry, flat, classes))
            except (TypeError, ValueError) as problem:
                raise type(problem)(f"{type(value).__name__}.{field}: {problem}") from None
        elif isinstance(entry, tuple) and entry and all(map(is_number, entry)) and not number:
            arguments.append("(" + "".join(f"params[{len(flat) + j}], " for j in range(len(entry))) + ")")
            flat.extend(_float(f"{type(value).__name__}.{field}", part) for part in entry)
        elif is_number(entry):
            arguments.append(f"params[{len(flat)}]")
            flat.append(_float(f"{type(value).__name__}.{field}", entry))
        else:
            raise TypeError(
                f"{type(value).__name__}.{field} must be a float{'' if number else ' or a NamedTuple of floats'}, got "
                f"{shown(entry)} "
                f"({type(entry).__name__})" + (": wrap it, univariate(f)" if inspect.isfunction(entry) else "")
            )
    return f"{name}({', '.join(arguments) or '0.0'})"


def is_as_met(value: Any) -> bool:
    """Tell whether the classes of a value have the methods that they had when this value was first used. If not, what
    is known of it is forgotten.
    """
    if all(state_of(cls) == state for cls, _, state in built(value)[1]):
        return True
    forget(value)
    return False


TUPLE_NAMES = {*dir(tuple), "_make", "_asdict", "_replace", "_fields", "_field_defaults"}
"""Names of the methods of all tuples."""

_NUMBERS = itertools.count()

CLASSES = 256
"""Classes whose replaced methods are remembered at once."""


@functools.lru_cache(maxsize=CLASSES)
def _states(_: type) -> list[tuple[int, int, dict[str, Any]]]:
    """The states in which a class was met: their numbers, the sizes of its dictionary, its methods."""
    return []


def state_of(cls: type) -> int:
    """Return the number of the methods that a class has now: another where some were replaced, the first again where
    that was undone.
    """
    states = _states(cls)
    now = cls.__dict__
    for number, size, methods in states:
        if size == len(now) and all(now.get(name) is method for name, method in methods.items()):
            return number
    states.append((next(_NUMBERS), len(now), dict(methods_of(cls))))
    return states[-1][0]


def methods_of(cls: type) -> list[tuple[str, Callable]]:
    """Return the methods of a NamedTuple that it does not share with all tuples, with their names."""
    return [
        (name, entry)
        for name, entry in vars(cls).items()
        if inspect.isfunction(entry) and name not in TUPLE_NAMES and not name.startswith("__")
    ]


FAILS = (TypeError, ValueError, AttributeError, ArithmeticError)
"""Errors of methods that take no arrays, or have no value at a point."""


def at_points(model: Any, method: str, *rows: Any) -> Any:
    """Return the values of a model's method at rows of numbers or arrays; one point at a time if it takes no arrays, as
    one with an `if`.
    """
    try:
        return getattr(model, method)(*rows)
    except FAILS as problem:
        return _one_by_one(model, method, rows, problem)


def _one_by_one(model: Any, method: str, rows: Sequence[Any], problem: Exception) -> Any:
    """Return the values of a method at each point, NaN where it has none; `problem`: its error at all points at once.

    Raises TypeError that names class and method where it gives numbers at no point.
    """
    arrays = np.broadcast_arrays(*rows) if rows else []
    shape = arrays[0].shape if arrays else ()
    found: list[Any] = []
    for point in zip(*(array.ravel().tolist() for array in arrays)) if shape else ():
        try:
            found.append(getattr(model, method)(*point))
        except (ValueError, ArithmeticError) as fault:  # outside of its domain
            found.append(None)
            problem = fault
        except (TypeError, AttributeError) as fault:
            found = []
            problem = fault
            break
    first = next((entry for entry in found if entry is not None), None)
    if first is None:
        raise TypeError(f"{type(model).__name__}.{method} does not give numbers ({reason(problem)})") from None
    several = isinstance(first, (tuple, list))
    nothing = [np.nan] * len(first) if several else np.nan
    values = np.array([nothing if entry is None else entry for entry in found], dtype=np.float64)
    return tuple(values.T.reshape(-1, *shape)) if several else values.reshape(shape)
