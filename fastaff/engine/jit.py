"""The only place that configures Numba: decorators, lane width, compile cache."""

from __future__ import annotations

import contextlib
import functools
import gc
from collections.abc import Callable, Iterator
from typing import Any

import numba
from numba import types

from ..core.compilations import Compiling
from ..core.interruption import defer_signals
from .cache import CodeCache
from .callees import Callee, EntryPipeline
from .code_folder import cache_directory, config, prebuilt
from .fingerprint import function_key
from .numba_private import CFunc, cgutils, events, intrinsic, normalize_signature

LANES = 128
"""Orbits in a lane block. A constant of the compiled code: a state block is a flat array whose row r
starts at r*LANES, so that LLVM sees constant distances between rows and needs no aliasing checks."""

POINTS = 32 * LANES
"""Points of a function of many points that a thread takes at once."""

JIT_DISABLED = bool(config.DISABLE_JIT)


class _Between(events.Listener):
    """Handle signals at the start of a pass of the compiler: elsewhere they may be lost, or leave it half done, locked
    for other threads or with unfinished calls on its own record.
    """

    def __init__(self, take: Callable[[], None]):
        self._take = take

    def on_start(self, event):
        """Handle the signals that have come."""
        self._take()

    def on_end(self, event):
        """Do nothing: the output of the pass is not stored yet."""


@contextlib.contextmanager
def compiling() -> Iterator[None]:
    """Run the block, which compiles or loads. Signals wait for the next pass: LLVM asks Python for code, and goes on
    without it after an error. Garbage collection waits: it takes a fifth of the time, and there is little garbage.
    """
    with Compiling.under_way(), defer_signals() as take, events.install_listener("numba:run_pass", _Between(take)):
        before = gc.isenabled()
        gc.disable()
        try:
            yield
        finally:
            if before:
                gc.enable()


def jit(
    function: Callable | None = None, *, constants: bool = False, inline: bool = False, apart: bool = False
) -> Callable:
    """Compile a kernel at its first call: strict floating point, no GIL, cached by package content.

    With `constants`, calls with constants get separate code for these: for loops over rows of lanes, which become up to
    a third faster. Else one code serves all numbers. With `inline` the code becomes part of the caller, which alone is
    compiled: for a function with a single caller. With `apart` its callers jump to it: for a long function called in
    several places, whose copies would take long to compile.
    """
    if function is None:
        return functools.partial(jit, constants=constants, inline=inline, apart=apart)
    if JIT_DISABLED:
        return function
    how: Any = "always" if inline else "never"
    kernel: Any = numba.njit(function, nogil=True, error_model="numpy", inline=how)
    if (folder := cache_directory()) is not None:
        kernel._cache = CodeCache(function, folder, functools.partial(function_key, function), prebuilt)
    kernel.compile = compiling()(kernel.compile)
    if not inline:
        kernel.part = Callee(function, constants=constants, apart=apart)
        kernel.get_call_template = kernel.part.get_call_template
        kernel.get_overload = kernel.part.get_overload
    return kernel


def _element(context, builder, array_type, array, index):
    """Address of array[index]."""
    view = context.make_array(array_type)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, array_type, view, [index], wraparound=False)


@intrinsic
def _atomic_read(typingcontext, array, index):
    def generate(context, builder, signature, arguments):
        address = _element(context, builder, signature.args[0], *arguments)
        return builder.load_atomic(address, "monotonic", 8)

    return array.dtype(array, index), generate


@intrinsic
def _atomic_write(typingcontext, array, index, value):
    def generate(context, builder, signature, arguments):
        address = _element(context, builder, signature.args[0], *arguments[:2])
        builder.store_atomic(arguments[2], address, "monotonic", 8)
        return context.get_dummy_value()

    return types.void(array, index, array.dtype), generate


@jit
def read_now(array, index):
    """Read array[index] (int64) from memory at this very moment.

    Kernels promise LLVM that nobody else writes to their arrays, so a plain read of a flag that another thread sets is
    moved out of the loop that polls it.
    """
    return _atomic_read(array, index)


@jit
def write_now(array, index, value):
    """Write array[index] (int64) to memory at this very moment, for another thread to see."""
    _atomic_write(array, index, value)


if JIT_DISABLED:

    def read_now(array, index):
        """Read array[index]."""
        return array[index]

    def write_now(array, index, value):
        """Write array[index]."""
        array[index] = value


class BlockFunction(types.WrapperAddressProtocol):
    """A compiled function that kernels receive as a typed pointer: they need no recompilation for it."""

    def __init__(self, function: Callable, signature: Any, *, cache: bool, keyed: bool = False):
        compiled: Any = CFunc(function, normalize_signature(signature), {}, {"error_model": "numpy"}, EntryPipeline)
        if cache and (folder := cache_directory()) is not None:
            content = (lambda: "") if keyed else functools.partial(function_key, function)
            compiled._cache = CodeCache(function, folder, content, prebuilt)
        with compiling():
            compiled.compile()
        self._compiled = compiled
        # the hash of a text is quick
        self._signature = signature
        self.shown = str(signature)
        self.address: int = compiled.address
        """The address of its code, which is kept for good."""

    def __wrapper_address__(self) -> int:
        return self.address

    def signature(self) -> Any:
        return self._signature


FUNCTIONS: dict[int, Callable] = {}
"""Block functions by the numbers that replace their addresses where the JIT is disabled."""


def block_function(function: Any, signature: Any, *, cache: bool) -> Any:
    """Compile `function` for use as a kernel argument, or by its `address` (the function itself where the JIT is
    disabled). The name of its module is a key of all that it reads.
    """
    if not JIT_DISABLED:
        return BlockFunction(function, signature, cache=cache, keyed=True)
    function.address = id(function)
    FUNCTIONS[function.address] = function
    return function


_f8 = types.float64
_i8 = types.int64
_vector, _matrix = (types.Array(_f8, axes, "C") for axes in (1, 2))
SIGNATURES = {
    # (params, lanes, drifts, kicks, step, steps, z) -> steps taken: until a lane leaves the domain
    "splitting": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    "precise_splitting": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    # drifts and kicks are the tableau of `nystrom`
    "nystrom_splitting": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    # For maps drifts are the weights of iterates, see `map_sums`
    "moments": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    "angles": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    # (params, drifts, kicks, step, steps, z, trace) -> steps taken: whole steps of lane 0, until it leaves the domain;
    # or all of them, and the state after the k-th in lane k of a trace that is not empty
    "march": _i8(_vector, _vector, _vector, _f8, _i8, _vector, _vector),
    "nystrom_march": _i8(_vector, _vector, _vector, _f8, _i8, _vector, _vector),
    # (address of the derivative, params, lanes, rows, a, b, dense, sweeps, step, z, k, work) -> steps taken: one
    "step": _i8(_i8, _vector, _i8, _i8, _matrix, _vector, _matrix, _i8, _vector, _vector, _vector, _vector),
    # (params, lanes, z, result)
    "derivative": types.void(_vector, _i8, _vector, _vector),
    # (params, lanes, z, momenta, status): of the orbits alone; momenta is z from the orbit's first momentum on
    "inside": types.void(_vector, _i8, _vector, _vector, _vector),
    "value": types.void(_vector, _i8, _vector, _vector),
    "kinetic": types.void(_vector, _i8, _vector, _vector),
    "potential": types.void(_vector, _i8, _vector, _vector),
    "along": types.void(_vector, _i8, _vector, _vector),
    # (params, lanes, states before, z, status)
    "leapt": types.void(_vector, _i8, _vector, _vector, _vector),
    # (params, lanes, escape radii, z, momenta, status, largest kinetic energy so far)
    "check": types.void(_vector, _i8, _vector, _vector, _vector, _vector, _vector),
    # (params, lanes, n, k, m, due, memory, result)
    "reading": types.void(_vector, _i8, _i8, _i8, _i8, _vector, _vector, _vector),
    # (params, calls, lanes, orbit, fresh, t, z, memory, out, done) -> lanes that became done
    "observe": _i8(
        _vector,
        types.Array(_i8, 2, "C"),
        _i8,
        types.Array(_i8, 1, "C"),
        _vector,
        _vector,
        _vector,
        _vector,
        types.Array(_f8, 2, "A"),  # each of two observers has some of the columns
        _vector,
    ),
}
