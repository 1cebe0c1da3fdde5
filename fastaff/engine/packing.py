"""Kernels of units of work, called by address with their arguments as 64-bit words.

Python's own threads share the units. `launch` runs them with progress and Ctrl-C.
"""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba import types

from ..core.numbers import Callback
from .callees import Callee
from .jit import JIT_DISABLED, LANES, POINTS, BlockFunction
from .numba_private import cgutils, intrinsic, models, register_model
from .threads import Task, default_threads, ending, own_threads, together, works

QUICK = 0x405
"""Flags of an array that is contiguous (NPY_ARRAY_C_CONTIGUOUS), owns its data (NPY_ARRAY_OWNDATA) and is writable
(NPY_ARRAY_WRITEABLE).
"""


class Words(types.Type):
    """Address of words that hold arguments of these types."""

    def __init__(self, arguments: tuple):
        self.arguments = arguments
        super().__init__(f"Words({', '.join(map(str, arguments))})")


@register_model(Words)
class _WordsModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, cgutils.ir.IntType(64))


class Packed:
    """An argument of many calls with its words, and the data that determine their types."""

    def __init__(self, value: Any):
        self.value = value
        self.words: list[int] = []
        self.kinds: list[Any] = []
        if not JIT_DISABLED:
            _pack((value,), self.words, self.kinds)


def _pack(arguments: tuple, words: list, kinds: list) -> None:
    """Append the words of the arguments, and data that determine their types, in a tenth of the time of Numba."""
    for argument in arguments:
        if isinstance(argument, np.ndarray):  # most are
            flags = argument.flags.num
            shape = argument.shape
            words += (_data(argument, flags), *shape, *argument.strides)
            kinds += (argument.dtype, len(shape), flags)
        elif isinstance(argument, Packed):
            words += argument.words
            kinds += argument.kinds
        elif isinstance(argument, BlockFunction):
            words.append(argument.address)
            kinds.append(argument.shown)
        elif isinstance(argument, tuple):
            kinds += (type(argument), len(argument))
            _pack(argument, words, kinds)
        else:
            number = isinstance(argument, (float, np.floating))
            words.append(int(np.float64(argument).view(np.int64)) if number else int(argument))
            kinds.append(type(argument))


def _data(array: np.ndarray, flags: int) -> int:
    """Return the address of an array's numbers, in a third of the usual time if the array owns them."""
    if array.size == 0:
        return 0
    if flags & QUICK == QUICK:
        return ctypes.addressof(ctypes.c_char.from_buffer(array))  # type: ignore[arg-type]
    return array.ctypes.data


def _unpacked(context, builder, word, kind):
    """Return the value of that type from its words, which word() returns one after the other."""
    if isinstance(kind, types.Array):
        data = context.get_value_type(types.CPointer(kind.dtype))
        array = context.make_array(kind)(context, builder)
        first = builder.inttoptr(word(), data)
        shape, strides = ([word() for _ in range(kind.ndim)] for _ in range(2))
        size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        context.populate_array(array, data=first, shape=shape, strides=strides, itemsize=size, meminfo=None)
        return array._getvalue()
    if isinstance(kind, types.FunctionType):
        function = cgutils.create_struct_proxy(kind)(context, builder)
        nothing = cgutils.get_null_value(cgutils.voidptr_t)
        function.c_addr = builder.inttoptr(word(), cgutils.voidptr_t)
        function.py_addr = nothing
        function.jit_addr = nothing
        return function._getvalue()
    if isinstance(kind, types.BaseTuple):
        return context.make_tuple(builder, kind, [_unpacked(context, builder, word, entry) for entry in kind])
    if isinstance(kind, types.Float):
        return builder.bitcast(word(), context.get_value_type(kind))
    return context.cast(builder, word(), types.int64, kind)


@intrinsic
def _arguments_in(typingcontext, words):
    """The tuple of arguments that these words hold."""

    def generate(context, builder, signature, values):
        memory = builder.inttoptr(values[0], cgutils.ir.IntType(64).as_pointer())
        at = iter(range(1 << 30))

        def word():
            return builder.load(cgutils.gep(builder, memory, next(at)))

        return _unpacked(context, builder, word, signature.return_type)

    return types.Tuple(words.arguments)(words), generate


_UNITS = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)
"""Python's call of a kernel for units, which releases the GIL meanwhile."""

PARTS = 64
"""Number of parts of the units for each thread."""

MOST_UNITS = 64
"""Most units in one part, for short units."""


@intrinsic
def _taken(typingcontext, following, size):
    """Add size to the number at an address, at this very moment; return the number before."""

    def generate(context, builder, signature, values):
        place = builder.inttoptr(values[0], cgutils.ir.IntType(64).as_pointer())
        return builder.atomic_rmw("add", place, values[1], "monotonic")

    return types.int64(following, size), generate


def _of_words(work: Any) -> Callable:
    def enter(following, size, units, words):
        begin = _taken(following, size)
        while begin < units:
            for unit in range(begin, min(begin + size, units)):
                work(unit, *_arguments_in(words))
            begin = _taken(following, size)

    enter.__qualname__ = f"{work.py_func.__qualname__}_of_words"
    return enter


@functools.cache
def _entry(work: Callable, arguments: tuple) -> BlockFunction:
    numbers = types.int64, types.int64, types.int64
    return BlockFunction(_of_words(Callee(work)), types.void(*numbers, Words(arguments)), cache=True)


_ENTRIES: dict[tuple, BlockFunction] = {}


def shares(
    work: Callable, arguments: tuple, units: int, threads: int
) -> tuple[list[Callable[[], None]], Callable[[], None]]:
    """Return calls, at most one for each thread, that together run work(unit, *arguments), not compiled yet, for every
    unit below `units`; and a function after which no unit is begun.

    `work` is compiled for the types of its arguments. Each call takes the next units as soon as it is free; it holds
    the memory to which it writes.
    """
    following = np.zeros(1, np.int64)
    end = functools.partial(following.fill, units)
    if JIT_DISABLED:

        def plain() -> None:
            while following[0] < units:
                following[0] += 1
                work(int(following[0]) - 1, *_values(arguments))

        return [plain], end
    words: list[int] = []
    kinds: list[Any] = [work]
    _pack(arguments, words, kinds)
    key = tuple(kinds)
    if key not in _ENTRIES:
        _ENTRIES[key] = _entry(work, tuple(map(numba.typeof, _values(arguments))))
    enter = _UNITS(_ENTRIES[key].address)
    memory = np.array(words, np.int64)
    size = min(max(units // (PARTS * threads), 1), MOST_UNITS)

    def share(_held: tuple = arguments) -> None:
        enter(_data(following, QUICK), size, units, _data(memory, QUICK))

    return [share] * max(1, min(threads, -(-units // size))), end


def run_units(work: Callable, arguments: tuple, units: int, *, threads: int) -> None:
    """Run work(unit, *arguments) for every unit below `units`, by this number of threads: the caller's and others.

    After an interruption of the caller no unit is begun; units that other threads have begun may go on for a moment.
    """
    calls, end = shares(work, arguments, units, threads)
    others = [Task(call) for call in calls[1:]]
    with ending(end):
        try:
            for other in others:
                other.begin()
            calls[0]()
        finally:
            end()
            for other in others:
                # A task that has not begun would wait for a free thread.
                while not (other.cancelled() or other.ended(1.0)):
                    pass


def _values(arguments: tuple) -> list:
    return [argument.value if isinstance(argument, Packed) else argument for argument in arguments]


def run_points(work: Callable, arguments: tuple, points: int) -> None:
    """Run work(portion, *arguments) for all portions of POINTS points, by the threads that kernels use by default."""
    run_units(work, arguments, -(-points // POINTS), threads=default_threads())


BRIEF = 10_000
"""Most steps of an orbit for which the caller's own thread does the work: Ctrl-C waits at most a fraction of a second,
while another thread takes the time of a hundred steps to wake up.
"""


def launch(
    kernel: Callable,
    arguments: tuple,
    progress: np.ndarray,
    work: float,
    threads: int,
    callback: Callback | None,
    steps: float = math.inf,
) -> None:
    """Run kernel(unit, stop, progress, *arguments) for all units, one entry of `progress` each, without the GIL in a
    worker thread.

    The main thread draws progress. Ctrl-C there sets stop[0], which kernels poll; KeyboardInterrupt is raised when the
    kernel has put its state back. Work of at most BRIEF `steps` of an orbit runs in this thread; a worker takes part in
    the work that it begins.
    """
    stop = np.zeros(1, np.int64)

    def tell() -> None:
        if callback is not None and work > 0:
            callback(min(1.0, float(progress.sum()) / work))

    if (steps <= BRIEF or works()) and not JIT_DISABLED:
        few = 1 if steps <= BRIEF else own_threads(threads)
        run_units(kernel, (stop, progress, *arguments), progress.size, threads=few)
        tell()
        return
    calls, end = shares(kernel, (stop, progress, *arguments), progress.size, threads)

    def halt() -> None:
        stop.fill(1)
        end()

    together(calls, halt, tell)


def units(orbits: int, size: int = LANES) -> np.ndarray:
    """Return a progress of 0 for each unit of `size` orbits."""
    return np.zeros(math.ceil(orbits / size), np.int64)
