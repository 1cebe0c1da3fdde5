"""exp, log, sin and cos without branches or tables, for loops over lanes, which then vectorise; and models that use
them.

Numba's own are calls for one number at a time: in a loop over lanes they cost five times as much and keep the rest of
it scalar too.
"""

from __future__ import annotations

import functools
import types
from collections import namedtuple
from typing import Any

import numpy as np
from numba.core.types import Complex
from numba.extending import overload

from .blocks import inlined, is_value
from .callees import Callee
from .fused import FUSED, SHIFT, fma

LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""ln 2 in two parts; whole multiples of the first are exact."""


HALF_PI = 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33
"""pi/2 in three parts, each the next 53 bits."""


def exp(x):
    """Return e^x: by the branch-free formula where it is compiled, else NumPy's.

    The reduced argument |r| <= ln(2)/2 leaves 4e-18 to the Taylor series of degree 13. Below -708 the value stays at
    e^-708.
    """
    return np.exp(x)


def log(x):
    """Return ln x, NaN for x <= 0: by the branch-free formula where it is compiled, else NumPy's.

    With x = 2^k m, sqrt(1/2) <= m < sqrt(2): ln m = 2 artanh(s), s = (m - 1)/(m + 1). Numbers below 2e-308 are not
    normal, and inaccurate.
    Source: FDLIBM e_log.c (Sun Microsystems 1993), the polynomial in s^2.
    """
    return np.log(x)


def sin(x):
    """Return sin x: by the branch-free formula where it is compiled, else NumPy's.

    x - k pi/2, with k the nearest whole number, by fused multiply-adds with pi/2 in three parts: to 1.4 units in the
    last place for |x| < 1e14, 3 at 1e15. NaN beyond 1.7e15, where k soon has more digits than a number, and of NaN.
    Source: FDLIBM k_sin.c and k_cos.c (Sun Microsystems 1993), the polynomials.
    """
    return np.sin(x)


def cos(x):
    """Return cos x: by the branch-free formula where it is compiled, else NumPy's; see `sin`."""
    return np.cos(x)


@overload(exp, jit_options={"error_model": "numpy", "forceinline": True})
def _exp(x):
    if isinstance(x, Complex):
        return lambda x: np.exp(x)

    def formula(x):
        y = x if x > -708.0 else -708.0
        y = y if y < 709.0 else 709.0
        whole = y * 1.4426950408889634 + SHIFT
        k = whole - SHIFT
        r = (y - k * LN2_HIGH) - k * LN2_LOW
        s = 1.0 / 6227020800.0
        s = s * r + 1.0 / 479001600.0
        s = s * r + 1.0 / 39916800.0
        s = s * r + 1.0 / 3628800.0
        s = s * r + 1.0 / 362880.0
        s = s * r + 1.0 / 40320.0
        s = s * r + 1.0 / 5040.0
        s = s * r + 1.0 / 720.0
        s = s * r + 1.0 / 120.0
        s = s * r + 1.0 / 24.0
        s = s * r + 1.0 / 6.0
        s = s * r + 0.5
        power = np.int64((np.float64(whole).view(np.int64) + 1023) << 52)
        return (1.0 + (r + r * r * s)) * power.view(np.float64) + 0.0 * x

    return formula


@overload(log, jit_options={"error_model": "numpy", "forceinline": True})
def _log(x):
    if isinstance(x, Complex):
        return lambda x: np.log(x)

    def formula(x):
        bits = np.float64(x).view(np.int64)
        k = (bits - 0x3FE6A09E667F3BCD) >> 52
        m = np.int64(bits - (k << 52)).view(np.float64)
        power = np.int64(k + 0x4338000000000000).view(np.float64) - SHIFT
        f = m - 1.0
        s = f / (2.0 + f)
        z = s * s
        w = z * z
        even = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01))
        odd = 1.818357216161805012e-01 + w * 1.479819860511658591e-01
        odd = z * (6.666666666666735130e-01 + w * (2.857142874366239149e-01 + w * odd))
        half = 0.5 * f * f
        result = power * LN2_HIGH - ((half - (s * (half + even + odd) + power * LN2_LOW)) - f)
        return (result if x > 0.0 else np.nan) + 0.0 * x

    return formula


QUARTERS = 2.0**50
"""Quarters of a turn, at most, that are counted."""


def _turned(x, quarters):
    """Return sin(x + quarters pi/2)."""
    whole = fma(x, 0.6366197723675814, SHIFT)
    k = whole - SHIFT
    r = fma(-k, HALF_PI[0], x)
    r = fma(-k, HALF_PI[1], r)
    r = fma(-k, HALF_PI[2], r)
    z = r * r
    s = fma(z, 1.58969099521155010221e-10, -2.50507602534068634195e-08)
    s = fma(z, s, 2.75573137070700676789e-06)
    s = fma(z, s, -1.98412698298579493134e-04)
    s = fma(z, s, 8.33333333332248946124e-03)
    s = fma(z, s, -1.66666666666666324348e-01)
    sine = fma(z * r, s, r)
    c = fma(z, -1.13596475577881948265e-11, 2.08757232129817482790e-09)
    c = fma(z, c, -2.75573143513906633035e-07)
    c = fma(z, c, 2.48015872894767294178e-05)
    c = fma(z, c, -1.38888888888741095749e-03)
    c = fma(z, c, 4.16666666666666019037e-02)
    half = 0.5 * z
    cosine = fma(z * z, c, 1.0 - half)
    turn = np.float64(whole).view(np.int64) + quarters
    value = cosine if turn & 1 else sine
    value = -value if turn & 2 else value
    return value if abs(k) < QUARTERS else np.nan


_turn = Callee(_turned, constants=True, forceinline=True)


@overload(sin, jit_options={"error_model": "numpy", "forceinline": True})
def _sin(x):
    return (lambda x: np.sin(x)) if isinstance(x, Complex) or not FUSED else (lambda x: _turn(x, 0))


@overload(cos, jit_options={"error_model": "numpy", "forceinline": True})
def _cos(x):
    return (lambda x: np.cos(x)) if isinstance(x, Complex) or not FUSED else (lambda x: _turn(x, 1))


_numpy: Any = types.ModuleType("numpy")  # named so that caches know what it holds
_numpy.__dict__.update(vars(np))
_numpy.__doc__ = "NumPy with branch-free functions."  # a part of the key of what is compiled
_numpy.exp, _numpy.log, _numpy.sin, _numpy.cos = exp, log, sin, cos


def branch_free(value: Any) -> Any:
    """Return a model or other value whose methods use this module's exp and log for np.exp and np.log, and are always
    inlined.

    One call left in a loop over lanes, because LLVM finds a method too long, and the loop does not vectorise.
    """
    twin: Any = type(value)
    return _twin(twin)(*(branch_free(entry) if is_value(entry) else entry for entry in value))


@functools.cache
def _twin(cls: Any) -> Any:
    """Return the class with such methods."""
    own = {name: entry for name, entry in vars(cls).items() if name not in dir(tuple) and not name.startswith("_")}
    methods = {name: entry for name, entry in own.items() if isinstance(entry, types.FunctionType)}
    twin: Any = namedtuple(cls.__name__, cls._fields)  # type: ignore[misc]
    twin.__module__, twin.__qualname__ = cls.__module__, cls.__qualname__
    for name, entry in own.items():
        if name not in cls._fields:
            setattr(twin, name, _rebound(entry) if name in methods else entry)
    return twin


def _rebound(method: Any) -> types.FunctionType:
    """Return the method with this module's functions in place of NumPy's."""
    names = {name: _numpy if entry is np else entry for name, entry in method.__globals__.items()}
    bound = types.FunctionType(method.__code__, names, method.__name__, method.__defaults__, method.__closure__)
    bound.__kwdefaults__ = method.__kwdefaults__
    return inlined(bound)
