"""a*b + c rounded once, as one instruction, in loops over lanes.

LLVM must not fuse by itself: it would in one loop, or for some lanes, and not in others. An explicit fused multiply-add
is one instruction with one result: in vectors, in the remaining lanes, and for one orbit alone.
"""

from __future__ import annotations

import math
import platform
from typing import Any

from numba import types

from .jit import JIT_DISABLED, config
from .numba_private import cgutils, get_host_cpu_features, intrinsic
from .numba_private import llvm_ir as ir

SHIFT = 6755399441055744.0
"""1.5 * 2^52: adding it rounds a number to a whole one, which is then in the low bits."""


def has_instructions(name: str, other: bool) -> bool:
    """Tell whether the target processor has that extension of x86; return `other` where it is no x86."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return other
    named = config.CPU_FEATURES  # of the environment, NUMBA_CPU_FEATURES
    return f"+{name}" in (get_host_cpu_features() if named is None else named).split(",")


FUSED = has_instructions("fma", other=True)
"""Whether `fma` rounds once. On x86 without FMA3 (before 2013), where it would be a function call for each number, its
product is rounded too, and results have other last digits.
"""


def multiply_add(builder, a, b, c):
    """Return the LLVM value of a*b + c, of numbers or of vectors of them."""
    if not FUSED:
        return builder.fadd(builder.fmul(a, b), c)
    name = f"v{c.type.count}f64" if isinstance(c.type, ir.VectorType) else "f64"
    function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(c.type, [c.type] * 3), f"llvm.fma.{name}")
    return builder.call(function, (a, b, c))


def _fma(typingcontext, a, b, c):
    """Return a*b + c."""

    def generate(context, builder, signature, arguments):
        return multiply_add(builder, *arguments)

    return types.float64(types.float64, types.float64, types.float64), generate


def _plain(a, b, c):
    """Return a*b + c: rounded once where Python can (3.13)."""
    return math.fma(a, b, c) if FUSED and hasattr(math, "fma") else a * b + c


fma: Any = _plain if JIT_DISABLED else intrinsic(_fma)
