"""Weighted sums of slopes over lanes, held in registers: to store a partial sum between two terms takes longer than to
add them.
"""

from __future__ import annotations

import functools
import operator
from typing import Any

from numba import types

from .fused import fma, has_instructions, multiply_add
from .jit import JIT_DISABLED
from .numba_private import cgutils, intrinsic
from .numba_private import llvm_ir as ir

VECTOR = 8
"""Numbers of a cache line, and of the widest registers; LLVM splits them where a processor has narrower ones."""

NARROW = 2
"""Vectors of a sum over few lanes."""

WIDE = 8 if has_instructions("avx512f", other=False) else 4
"""Vectors of a sum over many lanes: enough to hide the latency of an addition, and few enough for the registers, of
which processors without AVX-512 have half as many, of half the width.
"""


def _spread(builder: Any, number: Any) -> Any:
    """Return the vector of one number."""
    kind, places = (ir.VectorType(entry, VECTOR) for entry in (number.type, ir.IntType(32)))
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), number, cgutils.int32_t(0))
    return builder.shuffle_vector(one, one, ir.Constant(places, [0] * VECTOR))


def _sum(vectors: int, moved: bool) -> Any:
    """Return the function total[at:...] = sum of weights[j]*k[terms[j] + at:...] over j < count, in this order, for
    this number of `vectors`; if `moved`, z[at:...] + step[lane:...] times that.
    """

    def generate(context, builder, signature, arguments):
        at, lane, count = arguments[6:]
        kinds = signature.args
        kind = ir.VectorType(ir.DoubleType(), VECTOR)

        def data(number):
            return context.make_array(kinds[number])(context, builder, arguments[number]).data

        def vector(array, place):
            return builder.bitcast(builder.gep(array, [place]), kind.as_pointer())

        def places(begin):
            return [builder.add(begin, ir.Constant(begin.type, VECTOR * j)) for j in range(vectors)]

        slopes = data(3)
        begins = data(4)
        factors = data(5)
        sums = [cgutils.alloca_once_value(builder, ir.Constant(kind, [0.0] * VECTOR)) for _ in range(vectors)]
        with cgutils.for_range(builder, count) as loop:
            factor = _spread(builder, builder.load(builder.gep(factors, [loop.index])))
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

Terms = tuple[tuple[int, ...], ...]
"""The numbers of the arrays in each sum of a table."""

CHAIN = 4
"""Terms of a table's sum that are added one after the other."""


@functools.cache
def sum_of_table(table: Terms, apart: int, vectors: bool) -> Any:
    """Return the function that sets total[:size], whole vectors of it if `vectors`, to sum number s of a table: of the
    arrays k[apart*j:] with the weights of the table, in chains of fused multiply-adds that are added in their order.

    Each sum is a separate loop, whose weights stay in registers. Written in Python, they would take Numba seconds.
    """
    starts = [sum(map(len, table[:s])) for s in range(len(table))]
    lanes = VECTOR if vectors else 1

    def generate(context, builder, signature, arguments):
        total, k, weights = (
            context.make_array(kind)(context, builder, given).data
            for kind, given in zip(signature.args[:3], arguments[:3], strict=True)
        )
        s, size = arguments[3:]
        kind = ir.VectorType(ir.DoubleType(), VECTOR) if vectors else ir.DoubleType()

        def place(array, at):
            found = builder.gep(array, [at])
            return builder.bitcast(found, kind.as_pointer()) if vectors else found

        def weight(number):
            one = builder.load(builder.gep(weights, [ir.Constant(size.type, number)]))
            return _spread(builder, one) if vectors else one

        end = builder.append_basic_block("summed")
        sums = builder.switch(s, end)
        for number, (terms, start) in enumerate(zip(table, starts, strict=True)):
            sums.add_case(ir.Constant(s.type, number), block := builder.append_basic_block(f"sum{number}"))
            builder.position_at_end(block)
            factors = [weight(start + j) for j in range(len(terms))]
            bounds = (ir.Constant(size.type, 0), size, ir.Constant(size.type, lanes))
            with cgutils.for_range_slice(builder, *bounds) as (at, _):
                chains = [] if terms else [ir.Constant(kind, [0.0] * VECTOR if vectors else 0.0)]
                for length, (j, factor) in enumerate(zip(terms, factors, strict=True)):
                    known = builder.load(place(k, builder.add(at, ir.Constant(at.type, apart * j))), align=8)
                    if length % CHAIN == 0:
                        chains.append(builder.fmul(factor, known))
                    else:
                        chains[-1] = multiply_add(builder, factor, known, chains[-1])
                builder.store(functools.reduce(builder.fadd, chains), place(total, at), align=8)
            builder.branch(end)
        builder.position_at_end(end)
        return context.get_dummy_value()

    def summed(typingcontext, total, k, weights, s, size):
        return types.void(total, k, weights, s, size), generate

    def plain(total, k, weights, s, size):
        first = starts[s]
        terms = table[s]
        for i in range(size):
            chains = []
            for at in range(0, len(terms), CHAIN):
                chain = weights[first + at] * k[apart * terms[at] + i]
                for j in range(at + 1, min(at + CHAIN, len(terms))):
                    chain = fma(weights[first + j], k[apart * terms[j] + i], chain)
                chains.append(chain)
            total[i] = functools.reduce(operator.add, chains or [0.0])

    return plain if JIT_DISABLED else intrinsic(summed)
