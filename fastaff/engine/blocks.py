"""Block functions: loops over lanes generated around the scalar methods of a model, a section or a set of angles.

A value (a NamedTuple, possibly of NamedTuples) enters a kernel as a typed pointer to a compiled loop and a vector of
parameters, so the engine is compiled once for all models and parameters stay run-time values.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import inspect
import itertools
import sys
import types as python_types
import weakref
from collections import Counter, namedtuple
from collections.abc import Callable, Iterator, Set
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numba import types

from ..core.numbers import listed, shown
from . import cache, jit, map_sums, map_texts, nystrom
from .callees import Callee
from .fingerprint import fingerprint, is_ours
from .fused import fma
from .jit import JIT_DISABLED, SIGNATURES
from .numba_private import AbstractTemplate, AttributeTemplate, infer_getattr, lower_builtin
from .plane_loops import angle_of
from .pointers import COLUMNS, Calls, distant
from .state_rows import StateRows
from .substitution import replaced
from .texts import ARGUMENTS, ONE_VARIABLE, TEXTS, observed, read, signals, taken
from .values import built, is_value, methods_of, parameters

KEPT = 1024
"""Compiled blocks, and methods in them, that a process keeps for the next call: those of some hundred models. The code
of what is let go stays in LLVM's memory, which it never frees: whoever uses it may go on.
"""

ALONE = ("check", "inside")
"""Kinds of loops around the orbits alone, whose code serves all numbers of deviation vectors."""

PREAMBLES = ("Failed in ", "- Resolution failure")
"""Beginnings of Numba's lines before the one that names the error."""


@functools.lru_cache(maxsize=KEPT)
def _compilable(cls: type, state: int) -> type:
    """Return `cls`; if it has no fields, a twin with one unused field, as Numba cannot pass it; state: of its
    methods.
    """
    if cls._fields:  # type: ignore[attr-defined]
        return cls
    twin: type = namedtuple("twin", ["unused"])
    for name, method in methods_of(cls):
        setattr(twin, name, method)
    return twin


def rows_of(value: Any, n: int, vectors: int) -> StateRows:
    """Return the rows of a state of a model, or of a section's argument, by the terms of its equations."""
    terms: Set[str] = getattr(getattr(value, "kind", None), "terms", frozenset())
    variables = 0
    if "rates" in terms:
        variables = len(value.coordinates)
    elif "nonseparable" in terms:
        variables = 2 * n
    winding = tuple(period > 0 for period in value.periods()) if "iterates" in terms else ()
    return StateRows(n, vectors, terms, variables, winding, nonquadratic=hasattr(value, "tangent_velocity"))


def model_block(kind: str, value: Any, degrees_of_freedom: int, vectors: int = 0) -> Any:
    """Return the compiled block function `kind` of a model or section; a state is an orbit with its tangent
    vectors.

    Tangent vectors are further rows of the same scheme: a splitting of H moves them by its exact derivative, which is
    symplectic, and a Runge-Kutta tableau solves the variational equations.
    """
    vectors = 0 if kind in ALONE else vectors
    return _model_block(kind, *built(value), rows_of(value, degrees_of_freedom, vectors))


@functools.lru_cache(maxsize=KEPT)
def _model_block(kind: str, line: str, classes: tuple, rows: StateRows) -> Any:
    helpers = {"angle_of": _ANGLE_OF} if kind == "angles" else {}
    if rows.substep is not None:
        helpers["numbers"] = rows.substep.numbers
    names = tuple((name, entry if JIT_DISABLED else _compiled_method(entry)) for name, entry in helpers.items())
    with _explained(_must(classes)):
        return _compiled(kind, line + _texts(rows)[kind](rows), classes, names)


def _must(classes: tuple) -> str:
    """Return the sentence that says how the methods of a value with these classes must be written."""
    return (
        f"{classes[0][0].__name__} must have methods, of the class itself, that Numba compiles (arithmetic and NumPy "
        "functions, no other Python functions)"
    )


def _texts(rows: StateRows) -> dict[str, Callable[[StateRows], str]]:
    """Return the texts by kind of a system with these rows."""
    return {**map_texts.TEXTS, **map_sums.TEXTS} if rows.winding else TEXTS


def nystrom_block(kind: str, value: Any, degrees_of_freedom: int, vectors: int, terms: nystrom.Terms) -> Any:
    """Return the compiled block `nystrom_splitting` or, of one orbit, `nystrom_march`: steps of a Runge-Kutta-Nyström
    scheme; terms: the forces in each of its sums.
    """
    rows = replace(rows_of(value, degrees_of_freedom, vectors), nonquadratic=False)  # T is quadratic for these schemes
    return _nystrom_block(kind, *built(value), rows, terms)


@functools.lru_cache(maxsize=KEPT)
def _nystrom_block(kind: str, line: str, classes: tuple, rows: StateRows, terms: nystrom.Terms) -> Any:
    text = nystrom.march_text if kind == "nystrom_march" else nystrom.steps_text
    with _explained(_must(classes)):
        return _compiled(kind, line + text(rows, terms), classes, (("summed", nystrom.sums(kind, rows.half, terms)),))


def source(value: Any, kind: str, degrees_of_freedom: int | None = None, vectors: int = 0) -> str:
    """Return the text that is compiled for a model or a section.

    Parameters
    ----------
    value : NamedTuple
        Model or section.
    kind : str
        Kind of the loop over lanes around the scalar methods.

        * of a model: "splitting" (steps of a splitting), "precise_splitting" (with compensated summation), "march" (one
          orbit), "derivative", "check", "inside", "kinetic", "potential", "along" (the flow);
        * of a section: "value".
    degrees_of_freedom : int, optional
        Degrees of freedom. A section needs them; default for a model: its own.
    vectors : int, default 0
        Number of deviation vectors of a state.

    Returns
    -------
    str
        Python source text.

    Raises
    ------
    TypeError
        If `value` is not a NamedTuple of floats, or if `degrees_of_freedom` is missing.
    ValueError
        If `kind` is unknown. The message lists the kinds.

    Examples
    --------
    >>> print(fa.engine.source(fa.HenonHeiles(), "potential").splitlines()[1])
    def potential(params, lanes, z, result):
    """
    if not is_value(value):
        raise TypeError(f"value must be a model or section, a NamedTuple of floats, got {shown(value)}")
    n = getattr(value, "degrees_of_freedom", None) if degrees_of_freedom is None else degrees_of_freedom
    if n is None:
        raise TypeError(f"degrees_of_freedom must be given for {type(value).__name__}, which has none of its own")
    line, classes = built(value)
    rows = rows_of(value, n, vectors)
    texts = _texts(rows)
    if kind not in texts:
        whose = " for a map" if rows.winding else ""
        raise ValueError(f"kind must be one of {listed(map(repr, texts))}{whose}, got {shown(kind)}")
    return _text(kind, line + texts[kind](rows), classes)


def function_block(function: Any) -> Any:
    """Return the compiled block of a function of one variable."""
    line, classes = built(function)
    takes = "must be a formula that Numba compiles (NumPy functions, no other Python functions)"
    with _explained(f"{type(function).__name__} {takes}"):
        return _compiled("value", line + ONE_VARIABLE, classes, ())


class Bound(NamedTuple):
    """A compiled function with its parameters, and the table of its own calls."""

    function: Any
    parameters: np.ndarray
    table: np.ndarray


def call_table(own: np.ndarray, calls: tuple[Bound, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the parameters of a function, `own` and those of its calls, and the table of the calls.

    The rows of the calls' own calls come after all calls, with ranges that count from the calls' own
    beginnings.
    """
    row = len(calls)
    at = len(own)
    table = np.zeros((row + sum(len(call.table) for call in calls), len(COLUMNS)), np.int64)
    for number, call in enumerate(calls):
        ends = at + len(call.parameters), row + len(call.table)
        table[number] = call.function.address, at, ends[0], row, ends[1]
        table[row : ends[1]] = call.table
        at, row = ends
    return np.concatenate([own, *(call.parameters for call in calls)]), table


def signals_block(angles: Any, rows: int, kept: tuple[int, ...]) -> Bound:
    """Return the compiled function of the kept signals of angles at states of this number of rows."""
    return Bound(_signals_block(*built(angles), rows, kept), *call_table(parameters(angles), ()))


@functools.lru_cache(maxsize=KEPT)
def _signals_block(line: str, classes: tuple, rows: int, kept: tuple[int, ...]) -> Any:
    with _explained(f"angles must have signals that Numba compiles, {classes[0][0].__name__} does not"):
        return _compiled("value", line + signals(rows, kept), classes, ())


def rows_block(order: tuple[int, ...]) -> Bound:
    """Return the compiled function of the rows of a state in an order."""
    return Bound(_compiled("value", taken(order), (), ()), *call_table(np.zeros(1), ()))


@contextlib.contextmanager
def _explained(wrong: str) -> Iterator[None]:
    """Raise TypeError with the text `wrong` and Numba's first line of the reason where Numba cannot compile."""
    try:
        yield
    except Exception as problem:  # Numba's own, and any other that its passes raise, such as a bare AssertionError
        lines = (line.strip() for line in str(problem).splitlines())
        why = next((line for line in lines if line and not line.startswith(PREAMBLES)), type(problem).__name__)
        raise TypeError(f"{wrong}: {why}") from problem


def idle_block(kind: str) -> Any:
    """Return a block function of that kind that does nothing: for the arguments that a run does not use."""
    return _compiled(kind, "    return\n" if SIGNATURES[kind].return_type == types.void else "    return 0\n", (), ())


def step_block(function: Callable) -> Any:
    """Return the compiled step(derivative, params, ...) of a scheme that steps by the derivative."""
    return _compiled("step", f"    return take({ARGUMENTS['step']})\n", (), (("take", function),))


def observer_block(value: Any, function: Callable, sizes: tuple[int, ...], calls: bool) -> Any:
    """Return the compiled observer function(value, [calls,] *sizes, lanes, ...); `value` is built from params."""
    return _observer_block(*built(value), function, sizes, calls)


@functools.lru_cache(maxsize=KEPT)
def _observer_block(line: str, classes: tuple, function: Callable, sizes: tuple[int, ...], calls: bool) -> Any:
    names = ("keep", _compiled_function(function)), *([("Calls", Calls)] if calls else [])
    return _compiled("observe", line + observed(sizes, calls), classes, names)


@functools.lru_cache(maxsize=KEPT)
def reading_block(function: Callable, parameters: int, view: Callable) -> Any:
    """Return the compiled reading function(growth, i, *parameters), where growth = view(n, k, m, memory)."""
    plain = getattr(function, "py_func", function)
    names = ("read", plain if JIT_DISABLED else _compiled_method(plain)), ("view", view)
    with _explained(f"reading must be a function reading(growth, i, *parameters) of {parameters} parameters for Numba"):
        return _compiled("reading", read(parameters), (), names)


def _text(kind: str, body: str, classes: tuple) -> str:
    return (
        f"# {' of '.join([kind, ', '.join(cls.__qualname__ for cls, *_ in classes)])}\n"
        f"def {kind}({ARGUMENTS[kind]}):\n{body}"
    )


_NUMBERS = itertools.count()

NO_FILE = "<fastaff block>"
"""Name of the file of a text that is not kept."""

_ANGLE_OF = getattr(angle_of, "py_func", angle_of)


@functools.lru_cache(maxsize=KEPT)
def _compiled(kind: str, body: str, classes: tuple, namespace: tuple) -> Any:
    """Write, execute and compile the text of a block function; once per process for each value type."""
    text = _text(kind, body, classes)
    identity = fingerprint(tuple(cls for cls, *_ in classes), tuple(entry for _, entry in namespace))
    folder = None if identity is None or JIT_DISABLED else jit.cache_directory()
    filename = NO_FILE
    module = f"fastaff_block_{kind}_{next(_NUMBERS)}"
    if folder is not None:
        key = hashlib.sha256(f"{identity}\n{text}".encode()).hexdigest()[:20]
        path = folder / "blocks" / f"{kind}_{key}.py"
        if not path.exists():
            cache.write(path, text.encode())
        filename = str(path)
        module = f"fastaff_block_{kind}_{key}"
    # Numba looks up the module of cached code by name, so the text gets a real module, as long as its block is in use.
    _USES[module] += 1
    names = sys.modules.setdefault(module, python_types.ModuleType(module)).__dict__
    try:
        block = _executed(kind, text, names, classes, namespace, filename)
    except BaseException:
        _left(module)
        raise
    weakref.finalize(block, _left, module).atexit = False
    return block


_USES: Counter[str] = Counter()
"""Blocks by the names of their modules: two threads may make the same."""


def _left(module: str) -> None:
    """Remove the module of a block that is no more."""
    _USES[module] -= 1
    if _USES[module] <= 0:
        del _USES[module]
        sys.modules.pop(module, None)


def _executed(kind: str, text: str, names: dict[str, Any], classes: tuple, namespace: tuple, filename: str) -> Any:
    """Execute a text in the names of its module and compile the function; the code of a file is kept in the cache."""
    names.update(
        {name: _compilable(cls, state) for cls, name, state in classes},
        fma=fma,
        distant=distant,
        np=np,
        **dict(namespace),
    )
    exec(compile("\n" + text, filename, "exec"), names)  # below the line of the checksum
    if not JIT_DISABLED:
        for cls, *_ in classes:
            _register_methods(cls)
    return jit.block_function(names[kind], SIGNATURES[kind], cache=filename != NO_FILE)


_REGISTERED: set[str] = set()


def _register_methods(cls: type) -> None:
    """Teach Numba to call the plain methods of NamedTuple classes by name."""
    for name, _ in methods_of(cls):
        if name not in _REGISTERED:
            _register(name)
            _REGISTERED.add(name)


@infer_getattr
class _Methods(AttributeTemplate):
    """The types of methods of NamedTuples; `_register` adds their compiled calls."""

    key = types.BaseNamedTuple

    def generic_resolve(self, value, name):
        method = vars(value.instance_class).get(name) if name in _REGISTERED else None
        if not inspect.isfunction(method):
            return None

        class MethodCall(AbstractTemplate):
            key = types.BaseNamedTuple, name

            def generic(self, args, kws):
                # The method of now: Numba keeps one type of a bound method, however often the class is patched.
                compiled = types.Dispatcher(_compiled_method(vars(value.instance_class)[name]))
                return compiled.get_call_type(self.context, (value, *args), kws).as_method()

        return types.BoundFunction(MethodCall, value)


def _register(name: str) -> None:
    @lower_builtin((types.BaseNamedTuple, name), types.BaseNamedTuple, types.VarArg(types.Any))
    def call(context, builder, signature, arguments):
        compiled = types.Dispatcher(_compiled_method(vars(signature.args[0].instance_class)[name]))
        function = context.get_function(compiled, signature)
        context.add_linking_libs(function.libs)
        return function(builder, arguments)


def _compiled_function(function: Callable) -> Callable:
    """Return a kernel of the package as it is, another function compiled like the methods of models."""
    return function if is_ours(function) else _compiled_method(getattr(function, "py_func", function))


@functools.lru_cache(maxsize=KEPT)
def _compiled_method(method: Any) -> Callable:
    """Return a method with branch-free functions, always inlined: a loop over lanes does not vectorise if one call
    remains in it because LLVM finds a method too long.
    """
    return Callee(replaced(method), constants=True, forceinline=True)
