"""Plain methods of NamedTuples as calls that Numba compiles."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

from numba import types
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr
from numba.extending import lower_builtin

from .callees import Callee
from .substitution import replaced

_TUPLE_NAMES = {*dir(tuple), "_make", "_asdict", "_replace", "_fields", "_field_defaults"}


def own_methods(cls: type) -> list[tuple[str, Callable]]:
    """Return the plain methods of a class, by name."""
    return [
        (name, entry)
        for name, entry in vars(cls).items()
        if inspect.isfunction(entry) and name not in _TUPLE_NAMES and not name.startswith("__")
    ]


_REGISTERED: set[str] = set()


def register_methods(cls: type) -> None:
    """Teach Numba to call the plain methods of NamedTuple classes by name."""
    for name, _ in own_methods(cls):
        if name not in _REGISTERED:
            _register(name)
            _REGISTERED.add(name)


@infer_getattr
class _Methods(AttributeTemplate):
    """The types of methods of NamedTuples; `_register` adds what calls compile to."""

    key = types.BaseNamedTuple

    def generic_resolve(self, value, name):
        method = vars(value.instance_class).get(name) if name in _REGISTERED else None
        if not inspect.isfunction(method):
            return None
        compiled = types.Dispatcher(compiled_method(method))

        class Call(AbstractTemplate):
            key = types.BaseNamedTuple, name

            def generic(self, args, kws):
                return compiled.get_call_type(self.context, (value, *args), kws).as_method()

        return types.BoundFunction(Call, value)


def _register(name: str) -> None:
    @lower_builtin((types.BaseNamedTuple, name), types.BaseNamedTuple, types.VarArg(types.Any))
    def call(context, builder, signature, arguments):
        compiled = types.Dispatcher(compiled_method(vars(signature.args[0].instance_class)[name]))
        function = context.get_function(compiled, signature)
        context.add_linking_libs(function.libs)
        return function(builder, arguments)


@functools.cache
def compiled_method(method: Any) -> Callable:
    """Return a method with branch-free functions, always inlined: one call left in a loop over lanes, because LLVM
    finds a method too long, and the loop does not vectorise.
    """
    return Callee(replaced(method), constants=True, forceinline=True)
