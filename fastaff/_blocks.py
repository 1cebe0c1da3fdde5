"""Block functions: loops over lanes generated around the scalar methods of a model, a section or a set of angles (layer L0).

A value (a NamedTuple, possibly of NamedTuples) enters a kernel as a typed pointer to a compiled loop and a vector of parameters,
so the engine is compiled once for all models and parameters stay run-time values.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
import os
import sys
import types as python_types
from collections import namedtuple
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import overload_method

from . import _jit
from ._jit import JIT_DISABLED, LANES, SIGNATURES

_TUPLE_NAMES = {*dir(tuple), "_make", "_asdict", "_replace", "_fields", "_field_defaults"}


def is_value(candidate: Any) -> bool:
    """Tell whether `candidate` is a NamedTuple instance."""
    return isinstance(candidate, tuple) and hasattr(candidate, "_fields")


def parameters(value: Any) -> np.ndarray:
    """Flatten the float parameters of a NamedTuple of NamedTuples, in field order."""
    flat: list[float] = []
    _walk(value, flat, {})
    return np.array(flat, dtype=np.float64) if flat else np.zeros(1)


def _is_number(entry: Any) -> bool:
    return isinstance(entry, (int, float, np.integer, np.floating)) and not isinstance(entry, bool)


def _walk(value: Any, flat: list[float], classes: dict[type, str]) -> str:
    """Collect parameters and classes; return the source text that builds `value` from `params`."""
    name = classes.setdefault(type(value), f"Value{len(classes)}")
    arguments = []
    for field, entry in zip(value._fields, value, strict=True):
        if is_value(entry):
            arguments.append(_walk(entry, flat, classes))
        elif isinstance(entry, tuple) and entry and all(map(_is_number, entry)):
            arguments.append("(" + "".join(f"params[{len(flat) + j}], " for j in range(len(entry))) + ")")
            flat.extend(float(number) for number in entry)
        elif _is_number(entry):
            arguments.append(f"params[{len(flat)}]")
            flat.append(float(entry))
        else:
            raise TypeError(
                f"{type(value).__name__}.{field} must be a float or a NamedTuple of floats, got {entry!r} "
                f"({type(entry).__name__})" + (": wrap it, one_variable(f)" if inspect.isfunction(entry) else "")
            )
    return f"{name}({', '.join(arguments) or '0.0'})"


@functools.cache
def _compilable(cls: type) -> type:
    """Return `cls`, or where it has no fields, which Numba can't pass, a twin with one unused field."""
    if cls._fields:  # type: ignore[attr-defined]
        return cls
    twin: type = namedtuple("twin", ["unused"])
    for name, method in _methods(cls):
        setattr(twin, name, method)
    return twin


def _row(array: str, rows: range) -> str:
    return ", ".join(f"{array}[{r * LANES} + i]" for r in rows)


def _assign(array: str, rows: range, values: list[str]) -> str:
    return "".join(f"        {array}[{r * LANES} + i] = {v}\n" for r, v in zip(rows, values, strict=True))


def _names(prefix: str, count: int) -> list[str]:
    return [f"{prefix}{r}" for r in range(count)]


def _stage(n: int) -> str:
    """Drift and kick of the state in place."""
    q, p = _names("q", n), _names("p", n)
    drift = [f"{_row('z', range(r, r + 1))} + hd*v{r}" for r in range(n)]
    return _drift_kick(n, [_row("z", range(n + r, n + r + 1)) for r in range(n)], drift, "", q, p, 0)


def _precise_stage(n: int) -> str:
    """Drift and kick of the increments since the start of the step (rows 2n...4n): they round at their own small size."""
    momenta = [f"{_row('z', range(n + r, n + r + 1))} + {_row('z', range(3 * n + r, 3 * n + r + 1))}" for r in range(n)]
    drift = [f"{_row('z', range(2 * n + r, 2 * n + r + 1))} + hd*v{r}" for r in range(n)]
    states = "".join(f"        q{r} = {_row('z', range(r, r + 1))} + d{r}\n" for r in range(n))
    increments = [_row("z", range(3 * n + r, 3 * n + r + 1)) for r in range(n)]
    return _drift_kick(n, momenta, drift, states, _names("d", n), increments, 2 * n)


def _drift_kick(n: int, momenta: list[str], drift: list[str], states: str, drifted: list[str], kicked: list[str], first: int) -> str:
    """Text of a drift of rows first...first+n and a kick of the n rows after them."""
    p, v, f, q = _names("p", n), _names("v", n), _names("f", n), _names("q", n)
    move = (
        "".join(f"        {p[r]} = {momenta[r]}\n" for r in range(n))
        + f"        {', '.join(v)}, = value.velocity({', '.join(p)})\n"
        + "        hd = drift*step[i]\n"
        + "".join(f"        {drifted[r]} = {drift[r]}\n" for r in range(n))
        + _assign("z", range(first, first + n), drifted)
    )
    return (
        "    if kick == 0.0:\n        for i in range(lanes):\n"
        + move.replace("        ", "            ")
        + "        return\n    for i in range(lanes):\n"
        + move
        + states
        + f"        {', '.join(f)}, = value.force({', '.join(q)})\n        hk = kick*step[i]\n"
        + _assign("z", range(first + n, first + 2 * n), [f"{kicked[r]} + hk*{f[r]}" for r in range(n)])
    )


def _march(n: int) -> str:
    """Whole steps of lane 0 with its state in scalars, and the arithmetic of `stage` to the bit: for a single orbit."""
    q, p, v, f = (_names(letter, n) for letter in "qpvf")
    drift = (
        f"            {', '.join(v)}, = value.velocity({', '.join(p)})\n            hd = drift[s]*step\n"
        + "".join(f"            {q[r]} = {q[r]} + hd*{v[r]}\n" for r in range(n))
    )  # fmt: skip
    return (
        f"    {', '.join(q + p)}, = {', '.join(f'z[{r * LANES}]' for r in range(2 * n))},\n"
        "    for _ in range(steps):\n        for s in range(drift.size):\n"
        + drift
        + "            if s < kick.size:\n"
        f"                {', '.join(f)}, = value.force({', '.join(q)})\n                hk = kick[s]*step\n"
        + "".join(f"                {p[r]} = {p[r]} + hk*{f[r]}\n" for r in range(n))
        + "".join(f"    z[{r * LANES}] = {name}\n" for r, name in enumerate(q + p))
    )


def _derivative(n: int) -> str:
    v, f = _names("v", n), _names("f", n)
    return (
        "    for i in range(lanes):\n"
        f"        {', '.join(v)}, = value.velocity({_row('z', range(n, 2 * n))})\n"
        f"        {', '.join(f)}, = value.force({_row('z', range(n))})\n" + _assign("result", range(2 * n), v + f)
    )


def _check(n: int) -> str:
    z = _names("z", 2 * n)
    # 0*z is 0 for finite z and NaN else; comparisons with NaN are false.
    return (
        "    for i in range(lanes):\n"
        f"        {', '.join(z)}, = {_row('z', range(2 * n))},\n"
        f"        finite = {' + '.join(f'0.0*{name}' for name in z)}\n"
        f"        size = {' + '.join(f'{name}*{name}' for name in z[:n])}\n"
        f"        margin = value.margin({', '.join(z[:n])})\n"
        "        code = 0.0 if margin > 0.0 else 2.0\n"
        "        code = code if size < radius*radius else 3.0\n"
        "        result[i] = code if finite == 0.0 else 1.0\n"
    )


def _value(n: int) -> str:
    return f"    for i in range(lanes):\n        result[i] = value.value({_row('z', range(2 * n))})\n"


_BODIES: dict[str, Callable[[int], str]] = {
    "stage": _stage,
    "precise_stage": _precise_stage,
    "march": _march,
    "derivative": _derivative,
    "check": _check,
    "value": _value,
}
_ARGUMENTS = {
    "stage": "params, lanes, drift, kick, step, z",
    "precise_stage": "params, lanes, drift, kick, step, z",
    "march": "params, drift, kick, step, steps, z",
    "check": "params, lanes, radius, z, result",
    "derivative": "params, lanes, z, result",
    "value": "params, lanes, z, result",
    "observe": "params, lanes, orbit, fresh, t, z, memory, out, done",
}


def model_block(kind: str, value: Any, degrees_of_freedom: int) -> Any:
    """Return the compiled block function `kind` of a model, section or set of angles."""
    classes: dict[type, str] = {}
    constructor = _walk(value, [], classes)
    return _compiled(kind, constructor, tuple(classes.items()), _BODIES[kind](degrees_of_freedom), ())


def function_block(function: Any, variable: str) -> Any:
    """Return the compiled block of a function of one variable: its `regular(s)`, or value(x) with the text `variable` for x(s)."""
    classes: dict[type, str] = {}
    constructor = _walk(function, [], classes)
    term = "regular(z[i])" if hasattr(function, "regular") else f"value({variable.format('z[i]')})"
    body = f"    for i in range(lanes):\n        result[i] = value.{term}\n"
    try:
        return _compiled("value", constructor, tuple(classes.items()), body, (("np", np),))
    except numba.core.errors.NumbaError as problem:
        raise TypeError(
            f"{type(function).__name__} must be a formula that Numba compiles (NumPy functions, no other Python functions): "
            f"{str(problem).strip().splitlines()[-1]}"
        ) from problem


def idle_block(kind: str) -> Any:
    """Return a block function of that kind that does nothing: for the arguments that a run does not use."""
    return _compiled(kind, "0.0", (), "    return\n", ())


def observer_block(value: Any, body: str, namespace: tuple[tuple[str, Any], ...]) -> Any:
    """Return an observer whose text `body` may use `value` (built from params) and the package names of `namespace`."""
    classes: dict[type, str] = {}
    constructor = _walk(value, [], classes)
    return _compiled("observe", constructor, tuple(classes.items()), body, namespace)


@functools.cache
def _compiled(kind: str, constructor: str, classes: tuple, body: str, namespace: tuple) -> Any:
    """Write, execute and compile the text of a block function; once per process for each value type."""
    text = (
        f"# {' of '.join([kind, ', '.join(cls.__qualname__ for cls, _ in classes)])}\n"
        f"def {kind}({_ARGUMENTS[kind]}):\n    value = {constructor}\n{body}"
    )
    identity = class_fingerprint(tuple(cls for cls, _ in classes))
    folder = None if identity is None or JIT_DISABLED else _jit.cache_directory()
    filename, module = "<fastaff block>", f"fastaff_block_{kind}_{id(classes)}"
    if folder is not None:
        key = hashlib.sha256(f"{identity}\n{text}".encode()).hexdigest()[:20]
        filename = str(_write_once(folder / "blocks" / f"{kind}_{key}.py", text))
        module = f"fastaff_block_{kind}_{key}"
    # Numba looks cached code's module up by name, so the text gets a real module.
    names = sys.modules.setdefault(module, python_types.ModuleType(module)).__dict__
    names.update({name: _compilable(cls) for cls, name in classes}, **dict(namespace))
    exec(compile(text, filename, "exec"), names)
    if not JIT_DISABLED:
        for cls, _ in classes:
            _register_methods(cls)
    return _jit.block_function(names[kind], SIGNATURES[kind], cache=folder is not None)


def _write_once(path: Path, text: str) -> Path:
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        draft = path.with_suffix(f".{os.getpid()}.tmp")
        draft.write_text(text)
        os.replace(draft, path)
    return path


def class_fingerprint(classes: tuple[type, ...]) -> str | None:
    """Content key of the code of `classes`: what their methods do, call and read; None where that can't be known.

    Numba stamps a cached function with its own file only, so an edited model in another file would return old numbers.
    A class without a source file (typed at a prompt) is compiled but never cached.
    """
    digest = hashlib.sha256()
    for cls in classes:
        if cls.__module__.split(".")[0] == __package__:
            digest.update(f"{cls.__module__}.{cls.__qualname__}".encode())  # the package hash covers it
            continue
        try:
            source = inspect.getsourcefile(cls)
        except (TypeError, OSError):
            return None
        if source is None or not Path(source).is_file():
            return None
        digest.update(Path(source).read_bytes())
        for name, method in _methods(cls):
            digest.update(name.encode())
            if not _fingerprint(method, digest, set()):
                return None
    return digest.hexdigest()


def _fingerprint(function: Any, digest: Any, seen: set[int]) -> bool:
    """Feed bytecode, constants and read globals of `function` to `digest`; False where a global has unknown content."""
    function = getattr(function, "py_func", function)
    if id(function) in seen:
        return True
    seen.add(id(function))
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
            if isinstance(entry, (int, float, complex, str, np.generic)):
                digest.update(repr(entry).encode())
            elif isinstance(entry, python_types.ModuleType):
                digest.update(f"{entry.__name__} {getattr(entry, '__version__', '')}".encode())
                if entry.__name__ not in ("math", "numpy", "cmath"):
                    return False
            elif isinstance(entry, (python_types.FunctionType, numba.core.registry.CPUDispatcher)):
                if not _fingerprint(entry, digest, seen):
                    return False
            elif entry is not None and not isinstance(entry, (type, python_types.BuiltinFunctionType, np.ufunc)):
                return False
    return True


def _methods(cls: type) -> list[tuple[str, Callable]]:
    return [
        (name, entry)
        for name, entry in vars(cls).items()
        if inspect.isfunction(entry) and name not in _TUPLE_NAMES and not name.startswith("__")
    ]


_REGISTERED: set[str] = set()


def _register_methods(cls: type) -> None:
    """Teach Numba to call the plain methods of NamedTuple classes by name."""
    for name, _ in _methods(cls):
        if name not in _REGISTERED:
            _REGISTERED.add(name)
            _register(name)


def _register(name: str) -> None:
    @overload_method(types.BaseNamedTuple, name)
    def resolve(self, *args):
        method = vars(self.instance_class).get(name)
        if not inspect.isfunction(method):
            return None
        compiled = _compiled_method(method)

        def call(self, *args):
            return compiled(self, *args)

        return call


@functools.cache
def _compiled_method(method: Callable) -> Callable:
    return numba.njit(method, error_model="numpy")
