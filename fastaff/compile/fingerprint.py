"""Content keys of code: of the bytecode of classes and functions, the functions called and the globals read."""

from __future__ import annotations

import hashlib
import inspect
import types as python_types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np

from . import jit

TUPLE_NAMES = {*dir(tuple), "_make", "_asdict", "_replace", "_fields", "_field_defaults"}


def fingerprint(classes: tuple[type, ...], functions: tuple[Callable, ...] = ()) -> str | None:
    """Content key of classes and functions: their code, and that which it calls and reads; None if this is unknown.

    Numba stamps a cached function with its own file only, so an edited model in another file would return old numbers.
    Code without a source file (typed at a prompt) is compiled but never cached.
    """
    digest = hashlib.sha256()
    for entry in (*classes, *(getattr(function, "py_func", function) for function in functions)):
        if is_ours(entry):
            digest.update(f"{entry.__module__}.{entry.__qualname__}".encode())  # the folder's name covers it
            continue
        try:
            source_file = inspect.getsourcefile(entry)
        except (TypeError, OSError):
            return None
        if source_file is None or not Path(source_file).is_file():
            return None
        digest.update(Path(source_file).read_bytes())
        for name, code in methods_of(entry) if isinstance(entry, type) else [(entry.__qualname__, entry)]:
            digest.update(name.encode())
            if not _fingerprint(code, digest, set()):
                return None
    return digest.hexdigest()


def is_ours(entry: Any) -> bool:
    """Tell whether the key of the compile cache covers the module of a class or function."""
    package, _, module = (entry.__module__ or "").partition(".")
    return package == __package__.partition(".")[0] and module.partition(".")[0] in jit.COMPILED


def _fingerprint(function: Any, digest: Any, seen: set[int]) -> bool:
    """Feed bytecode, constants and read globals of `function` to `digest`; False where a global has unknown content."""
    function = getattr(function, "py_func", function)
    if id(function) in seen:
        return True
    seen.add(id(function))
    if is_ours(function) and not function.__closure__:
        digest.update(f"{function.__module__}.{function.__qualname__}".encode())
        return True
    for cell in function.__closure__ or ():
        entry = cell.cell_contents
        if isinstance(entry, (python_types.FunctionType, numba.core.registry.CPUDispatcher)):
            if not _fingerprint(entry, digest, seen):
                return False
        elif isinstance(entry, (int, float, complex, str)):
            digest.update(repr(entry).encode())
        else:
            return False
    for default in (*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()):
        if not isinstance(default, (int, float, complex, str, tuple, np.generic)):
            return False
        digest.update(repr(default).encode())
    pending = [function.__code__]
    while pending:
        code = pending.pop()
        digest.update(code.co_code)
        pending.extend(c for c in code.co_consts if isinstance(c, python_types.CodeType))
        digest.update(repr([c for c in code.co_consts if not isinstance(c, python_types.CodeType)]).encode())
        digest.update(repr(code.co_names).encode())
        for name in code.co_names:
            entry = function.__globals__.get(name)
            if isinstance(entry, (int, float, complex, str, np.generic)) or _numbers(entry):
                digest.update(repr(entry).encode())
            elif isinstance(entry, python_types.ModuleType):
                digest.update(f"{entry.__name__} {getattr(entry, '__version__', '')} {entry.__doc__}".encode())
                if entry.__name__ not in ("math", "numpy", "cmath"):
                    return False
            elif isinstance(entry, (python_types.FunctionType, numba.core.registry.CPUDispatcher)):
                if not _fingerprint(entry, digest, seen):
                    return False
            elif entry is not None and not isinstance(entry, (type, python_types.BuiltinFunctionType, np.ufunc)):
                return False
    return True


def _numbers(entry: Any) -> bool:
    return isinstance(entry, tuple) and all(map(is_number, entry))


def methods_of(cls: type) -> list[tuple[str, Callable]]:
    """Return the methods of a NamedTuple that it does not share with all tuples, with their names."""
    return [
        (name, entry)
        for name, entry in vars(cls).items()
        if inspect.isfunction(entry) and name not in TUPLE_NAMES and not name.startswith("__")
    ]


def is_number(entry: Any) -> bool:
    """Tell whether an entry is a real number."""
    taken = isinstance(entry, (int, float, np.integer, np.floating))
    return taken and not isinstance(entry, (bool, np.timedelta64))
