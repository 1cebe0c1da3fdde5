"""The lanes of a row that have news, as the bits of one number: to look at each lane takes longer than to find them."""

from __future__ import annotations

from typing import Any

from numba import types

from .jit import JIT_DISABLED
from .numba_private import cgutils, intrinsic
from .numba_private import llvm_ir as ir

FLAGS = 64
"""Lanes whose flags are one number."""


def _flags(typingcontext, row, first):
    """Return the number whose bit i tells whether row[first + i] is not 0."""

    def generate(context, builder, signature, arguments):
        kind = ir.VectorType(ir.DoubleType(), FLAGS)
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        numbers = builder.load(builder.bitcast(builder.gep(data, [arguments[1]]), kind.as_pointer()), align=8)
        return builder.bitcast(
            builder.fcmp_unordered("!=", numbers, ir.Constant(kind, [0.0] * FLAGS)), ir.IntType(FLAGS)
        )

    return types.int64(row, types.int64), generate


def _lowest(typingcontext, number):
    """Return the place of the lowest bit of a number that is not 0."""

    def generate(context, builder, signature, arguments):
        return builder.cttz(arguments[0], cgutils.true_bit)

    return types.int64(types.int64), generate


def _plain_flags(row, first):
    return sum(1 << i for i in range(FLAGS) if row[first + i] != 0.0)


def _plain_lowest(number):
    return (number & -number).bit_length() - 1


flags: Any = _plain_flags if JIT_DISABLED else intrinsic(_flags)
lowest: Any = _plain_lowest if JIT_DISABLED else intrinsic(_lowest)
