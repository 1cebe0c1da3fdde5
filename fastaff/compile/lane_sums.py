"""Weighted sums of slopes over lanes, held in registers: to store what is there between two terms takes longer than to
add them.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .fused import has_instructions
from .jit import JIT_DISABLED

VECTOR = 8
"""Numbers of a cache line, and of the widest registers; LLVM splits them where a processor has narrower ones."""

NARROW, WIDE = 2, 8 if has_instructions("avx512f", other=False) else 4
"""Vectors of a sum over few lanes, and over many: so many hide how long an addition takes and find room in registers,
of which there are half as many of half the width elsewhere.
"""


def _sum(vectors: int, moved: bool) -> Any:
    """Return the function total[at:...] = sum of weights[j]*k[terms[j] + at:...] over j < count, in this order, for so
    many vectors of numbers; if `moved`, z[at:...] + step[lane:...] times that.
    """

    def generate(context, builder, signature, arguments):
        at, lane, count = arguments[6:]
        kinds, kind = signature.args, ir.VectorType(ir.DoubleType(), VECTOR)

        def data(number):
            return context.make_array(kinds[number])(context, builder, arguments[number]).data

        def vector(array, place):
            return builder.bitcast(builder.gep(array, [place]), kind.as_pointer())

        def places(begin):
            return [builder.add(begin, ir.Constant(begin.type, VECTOR * j)) for j in range(vectors)]

        slopes, begins, factors = data(3), data(4), data(5)
        sums = [cgutils.alloca_once_value(builder, ir.Constant(kind, [0.0] * VECTOR)) for _ in range(vectors)]
        with cgutils.for_range(builder, count) as loop:
            one = builder.insert_element(
                ir.Constant(kind, ir.Undefined), builder.load(builder.gep(factors, [loop.index])), cgutils.int32_t(0)
            )
            factor = builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), VECTOR), [0] * VECTOR))
            begin = builder.add(builder.load(builder.gep(begins, [loop.index])), at)
            for sum, place in zip(sums, places(begin), strict=True):
                term = builder.fmul(factor, builder.load(vector(slopes, place), align=8))
                builder.store(builder.fadd(builder.load(sum), term), sum)
        for sum, place, row in zip(sums, places(at), places(lane), strict=True):
            value = builder.load(sum)
            if moved:
                h, start = (builder.load(vector(data(i), p), align=8) for i, p in ((2, row), (1, place)))
                value = builder.fadd(start, builder.fmul(h, value))
            builder.store(value, vector(data(0), place), align=8)
        return context.get_dummy_value()

    def typed(typingcontext, total, z, step, k, terms, weights, at, lane, count):
        return types.void(total, z, step, k, terms, weights, at, lane, count), generate

    def plain(total, z, step, k, terms, weights, at, lane, count):
        size = VECTOR * vectors
        value = 0.0 * total[at : at + size]
        value[:] = 0.0
        for j in range(count):
            value = value + weights[j] * k[terms[j] + at : terms[j] + at + size]
        total[at : at + size] = z[at : at + size] + step[lane : lane + size] * value if moved else value

    return plain if JIT_DISABLED else intrinsic(typed)


wide_sum, narrow_sum, wide_move, narrow_move = (_sum(n, moved) for moved in (False, True) for n in (WIDE, NARROW))
