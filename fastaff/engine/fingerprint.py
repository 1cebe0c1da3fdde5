"""Content keys of code: of the bytecode of classes and functions, the functions called and the values read.

Code is keyed by what it is, not by its name alone: a class of the package may have been changed in this process. What
cannot be keyed is compiled, but never kept on disk.
"""

from __future__ import annotations

import enum
import hashlib
import inspect
import types as python_types
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from . import sources
from .numba_private import CPUDispatcher
from .sources import COMPILED, PACKAGE, ROOT
from .values import methods_of

KNOWN_MODULES = {"math": "", "cmath": "", "numpy": np.__version__}
"""Modules whose functions and numbers methods may read, with their versions."""

PLAIN = (type(None), bool, int, float, complex, str, bytes)
"""Types of values whose text is all of them."""


def fingerprint(classes: tuple[type, ...], functions: tuple[Any, ...] = ()) -> str | None:
    """Content key of classes and functions: their code, and that which it calls and reads; None if this is unknown.

    Numba stamps a cached function with its own file only, so an edited model in another file would return old numbers.
    Code without a source file (typed at a prompt, or put into a class of the package) is compiled but never cached.
    """
    content = Content()
    for entry in (*classes, *(getattr(function, "py_func", function) for function in functions)):
        if not is_ours(entry):
            try:
                source_file = inspect.getsourcefile(entry)
            except (TypeError, OSError):
                return None
            if source_file is None or not Path(source_file).is_file():
                return None
            content.add(Path(source_file).read_bytes())
        if not content.takes(entry, of_package=is_ours(entry)):
            return None
    return content.digest()


def function_key(function: Callable) -> str | None:
    """Content key of a kernel of the package and all that it calls; None if this is unknown: something that a kernel
    reads is not the package's.
    """
    content = Content()
    return content.digest() if content.takes(function, of_package=True) else None


def is_ours(entry: Any) -> bool:
    """Tell whether the key of the compile cache covers a module, or that of a class or function."""
    kind = "__name__" if isinstance(entry, python_types.ModuleType) else "__module__"
    package, _, module = (getattr(entry, kind, None) or "").partition(".")
    inside = f"{module.replace('.', '/')}/".startswith(tuple(f"{folder}/" for folder in COMPILED))
    return package == PACKAGE and inside


class Content:
    """The content of code, gathered piece by piece into a key."""

    def __init__(self) -> None:
        self._digest = hashlib.sha256()
        self._seen: dict[int, int] = {}
        self._pending: list[tuple[Any, bool]] = []

    def add(self, *parts: Any) -> bool:
        """Add texts, numbers and bytes, each with its length; return True."""
        for part in parts:
            piece = part if isinstance(part, bytes) else str(part).encode("utf-8", "surrogatepass")
            self._digest.update(b"%d:" % len(piece) + piece)
        return True

    def digest(self) -> str:
        """Return the key."""
        return self._digest.hexdigest()

    def takes(self, entry: Any, of_package: bool) -> bool:
        """Add an entry and all that it reads; return whether the whole content is known. of_package: it is read by code
        of the package, whose own values of other kinds the source of its module covers, see `sources`.
        """
        self._pending.append((entry, of_package))
        while self._pending:
            if not self._one(*self._pending.pop()):
                self._pending.clear()
                return False
        return True

    def _one(self, entry: Any, of_package: bool) -> bool:
        """Add an entry; functions and values that it reads wait for their turn, as code may call itself."""
        kind = type(entry)
        if kind in PLAIN:
            return self.add(kind.__name__, repr(entry))
        if isinstance(entry, CPUDispatcher):
            options = () if is_ours(entry.py_func) else tuple(sorted(entry.targetoptions.items()))
            self._pending.append((options, False))
            return self._once(entry.py_func, self._function)
        if inspect.isfunction(entry):
            return self._once(entry, self._function)
        if isinstance(entry, type):
            return self._once(entry, self._class)
        if isinstance(entry, np.generic):
            return not entry.dtype.hasobject and self.add(entry.dtype.str, entry.tobytes())
        if kind is np.ndarray:
            return not entry.dtype.hasobject and self.add(entry.dtype.str, entry.shape, entry.tobytes())
        if kind in (tuple, frozenset):
            return self._all(kind.__name__, sorted(entry, key=repr) if kind is frozenset else entry, of_package)
        if isinstance(entry, enum.Enum):
            return self._all(entry.name, (kind, entry.value), of_package)
        if isinstance(entry, tuple) and hasattr(kind, "_fields"):
            return self._all("values", (kind, *entry), of_package)
        if isinstance(entry, python_types.ModuleType):
            version = KNOWN_MODULES.get(entry.__name__)
            return self.add("module", entry.__name__, version) and (version is not None or of_package)
        if isinstance(entry, (python_types.BuiltinFunctionType, np.ufunc)):
            return self.add("builtin", getattr(entry, "__module__", ""), entry.__name__)
        # Of the package: types, intrinsics and the like, which the source of the module that reads them covers.
        return of_package and self.add("value", kind.__module__, kind.__qualname__)

    def _once(self, entry: Any, add: Callable[[Any], bool]) -> bool:
        """Add a function or class, or where it was met before."""
        if id(entry) in self._seen:
            return self.add("again", self._seen[id(entry)])
        self._seen[id(entry)] = len(self._seen)
        return add(entry)

    def _source(self, entry: Any) -> bool:
        """Add the source of the module of a function or class of the package, with all that it imports."""
        known = sources.key((entry.__module__,))
        return known is not None and self.add(known)

    def _all(self, what: str, entries: Iterable[Any], of_package: bool) -> bool:
        waiting = [(entry, of_package) for entry in entries]
        self._pending.extend(reversed(waiting))
        return self.add(what, len(waiting))

    def _function(self, function: Any) -> bool:
        """Add a function: its code, closure and defaults, and the globals that it reads."""
        own = is_ours(function) and _in_package(function.__code__)
        self.add("function", function.__qualname__)
        for name, entry in _read(function):
            self.add(name)
            self._pending.append((entry, own))
        return self._code(function.__code__, own) and (not is_ours(function) or self._source(function))

    def _code(self, code: python_types.CodeType, own: bool) -> bool:
        """Add code, and that of functions within it."""
        self.add(code.co_code, " ".join(code.co_names), " ".join(code.co_varnames), code.co_flags)
        for constant in code.co_consts:
            if isinstance(constant, python_types.CodeType):
                self._code(constant, own)
            else:
                self._pending.append((constant, own))
        return True

    def _class(self, cls: type) -> bool:
        """Add a class that compiled code may make, read or call: an enumeration by its members, a NamedTuple by its
        fields and methods, one of the language by its name. Others are unknown.
        """
        self.add("class", cls.__module__, cls.__qualname__)
        if is_ours(cls) and not self._source(cls):
            return False
        if issubclass(cls, enum.Enum):
            members = cls.__members__.items()
            names = " ".join(name for name, _ in members)
            return self._all(names, [entry.value for _, entry in members], False)
        if issubclass(cls, tuple) and hasattr(cls, "_fields"):
            methods = methods_of(cls)
            defaults = getattr(cls, "_field_defaults", {})
            self._pending.extend((entry, is_ours(cls)) for _, entry in [*methods, *defaults.items()])
            if is_ours(cls) and not all(is_ours(entry) and _in_package(entry.__code__) for _, entry in methods):
                return False  # changed in this process
            return self.add(cls._fields, [name for name, _ in methods], list(defaults))
        return cls.__module__ in ("builtins", *KNOWN_MODULES) or is_ours(cls)


def _read(function: Any) -> list[tuple[str, Any]]:
    """Return what a function reads from outside: its cells, its defaults, and globals with its names."""
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    found = [(name, cell.cell_contents) for name, cell in cells]
    found += [("default", entry) for entry in function.__defaults__ or ()]
    found += (function.__kwdefaults__ or {}).items()
    names = []
    pending = [function.__code__]
    while pending:
        code = pending.pop()
        names += code.co_names
        pending += [constant for constant in code.co_consts if isinstance(constant, python_types.CodeType)]
    space = function.__globals__
    found += [(name, space[name]) for name in dict.fromkeys(names) if name in space]
    for module in [space[name] for name in names if isinstance(space.get(name), python_types.ModuleType)]:
        # Its numbers, such as np.pi, which somebody may have set to others; of the package its functions too.
        kinds = (object,) if is_ours(module) else (int, float)
        found += [(name, entry) for name in names if isinstance(entry := vars(module).get(name), kinds)]
    return found


def _in_package(code: python_types.CodeType) -> bool:
    return code.co_filename.startswith(str(ROOT))
