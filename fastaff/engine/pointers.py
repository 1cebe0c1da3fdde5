"""Functions that compiled code calls by their address: those of models, sections and other observers in an observer.

An observer is compiled once for all functions that it calls: they are rows of a table of numbers, each with its range
of the parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from numba import types

from .jit import FUNCTIONS, JIT_DISABLED, SIGNATURES, jit
from .numba_private import cgutils, intrinsic


class CallColumns(NamedTuple):
    """Columns of the table of calls: the address of a function, the ranges of its parameters and of its own calls."""

    address: int = 0
    parameters: int = 1
    parameters_end: int = 2
    calls: int = 3
    calls_end: int = 4


COLUMNS = CallColumns()


class Calls(NamedTuple):
    """Functions that compiled code may call: their table (calls, columns) and the vector of all their parameters."""

    table: Any
    parameters: Any


def _called(context, builder, pointer, signature, parts, given):
    """Call the function of that signature at a pointer.

    It gets arrays without reference counts: it keeps none, and counting up and down takes as long as a step of one
    orbit.
    """
    arguments = []
    for part, source, target in zip(parts, given, signature.args, strict=True):
        value = context.cast(builder, part, source, target)
        if isinstance(target, types.Array):
            array = context.make_array(target)(context, builder, value)
            array.meminfo = cgutils.get_null_value(array.meminfo.type)
            value = array._getvalue()
        arguments.append(value)
    kinds = [context.get_value_type(entry) for entry in signature.args]
    kind = cgutils.ir.FunctionType(context.get_value_type(signature.return_type), kinds)
    return builder.call(builder.bitcast(pointer, kind.as_pointer()), arguments)


@intrinsic
def distant(typingcontext, array, start):
    """Return array[start:] as an array of its own for LLVM: a loop that reads the first rows and writes many rows at an
    unknown place of one array does not become vectors. Both lie apart.
    """

    def generate(context, builder, signature, given):
        whole = context.make_array(signature.args[0])(context, builder, given[0])
        word = given[1].type
        size = word(context.get_abi_sizeof(context.get_data_type(array.dtype)))
        place = builder.add(builder.ptrtoint(whole.data, word), builder.mul(given[1], size))
        part = context.make_array(array)(context, builder)
        shape = [builder.sub(whole.nitems, given[1])]
        data = builder.inttoptr(place, whole.data.type)
        context.populate_array(part, data=data, shape=shape, strides=[size], itemsize=size, meminfo=None)
        return part._getvalue()

    return array(array, types.int64), generate


def _rest(array, start):
    """Return array[start:]."""
    return array[start:]


if JIT_DISABLED:
    distant = _rest  # type: ignore[assignment]


def caller(kind: str) -> Callable:
    """Return the function that calls the block function of that kind at an address."""
    if JIT_DISABLED:
        return lambda at, *arguments: FUNCTIONS[at](*arguments)
    expected = SIGNATURES[kind]

    @intrinsic
    def call(typingcontext, at, *arguments):
        given = types.BaseTuple.from_types(arguments)

        def generate(context, builder, signature, values):
            pointer = builder.inttoptr(values[0], cgutils.voidptr_t)
            return _called(context, builder, pointer, expected, cgutils.unpack_tuple(builder, values[1]), given)

        return expected.return_type(at, given), generate

    return call


@intrinsic
def _pointed(typingcontext, function, *arguments):
    given = types.BaseTuple.from_types(arguments)
    expected = function.signature

    def generate(context, builder, signature, values):
        pointer = cgutils.create_struct_proxy(signature.args[0])(context, builder, values[0]).c_addr
        return _called(context, builder, pointer, expected, cgutils.unpack_tuple(builder, values[1]), given)

    return expected.return_type(function, given), generate


call: Any = (lambda function, *arguments: function(*arguments)) if JIT_DISABLED else _pointed
"""Calls a block function, as `_called` says."""


_value, _reading, _observe = map(caller, ("value", "reading", "observe"))


@jit(inline=True)
def call_value(calls, number, lanes, z, result):
    """Set result to the values of the numbered function, a section or a scalar method of a model, at the states z."""
    row = calls.table[number]
    parameters = calls.parameters[row[COLUMNS.parameters] : row[COLUMNS.parameters_end]]
    _value(row[COLUMNS.address], parameters, lanes, z, result)


@jit(inline=True)
def call_reading(calls, number, n, k, m, lanes, due, memory, result):
    """Set result, in the lanes that are due, to the numbered reading of tangent vectors; see
    `engine.kernels.deviations`.
    """
    row = calls.table[number]
    parameters = calls.parameters[row[COLUMNS.parameters] : row[COLUMNS.parameters_end]]
    _reading(row[COLUMNS.address], parameters, lanes, n, k, m, due, memory, result)


@jit(inline=True)
def call_observer(calls, number, lanes, orbit, fresh, t, z, memory, out, done):
    """Call the numbered observer; return the number of lanes that it has ended."""
    row = calls.table[number]
    parameters = calls.parameters[row[COLUMNS.parameters] : row[COLUMNS.parameters_end]]
    table = calls.table[row[COLUMNS.calls] : row[COLUMNS.calls_end]]
    return _observe(row[COLUMNS.address], parameters, table, lanes, orbit, fresh, t, z, memory, out, done)
