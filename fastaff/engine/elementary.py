"""Elementary functions without branches or tables, for loops over lanes, which then vectorise.

Numba's own are calls for one number at a time: in a loop over lanes they cost five to ten times as much and keep the
rest of it scalar too. `substitution` replaces NumPy's and Python's functions by these where models are compiled.

Errors are below 1 unit in the last place, of hypot 1.2, arcsin and arccos 1.4; for sin, cos and tan this holds up to
|x| = 1e10, and absolute errors grow to 1e-12 at 1e15 (tests/engine/test_elementary.py). 0, infinite numbers and NaN
give the values of IEEE 754, or NaN; e^x and powers below 3.3e-308 are 0. Without fused multiply-adds they are NumPy's.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types as kinds

from .callees import Callee
from .fused import FUSED, SHIFT, fma
from .numba_private import overload

LN2_HIGH = 6.93147180369123816490e-01
"""The first part of ln 2: whole multiples of it are exact."""

LN2_LOW = 1.9082149292705877e-10
"""The second part of ln 2."""

HALF_PI = 1.5707963267341256, 6.077100506506192e-11, 3.5215598651832e-27, 2.0670321098263988e-43
"""pi/2 in four parts: the first 33 bits, then the next 53 each. When whole multiples of them are subtracted from a
number, only the last difference that matters is rounded.
"""

QUARTER_PI = 0.7853981633974483, 3.061616997868383e-17
"""pi/4 in two parts; multiples of the first up to 4 are exact."""

THIRDS = 0.6666666666666666, 3.700743415417188e-17
"""2/3 in two parts."""

QUARTERS = 2.0**50
"""Most quarters of a turn that are counted."""

_LARGEST_SINH = 710.4758600739439
"""Argument above which sinh and cosh overflow."""


def _remainder(x):
    """Return x - k pi/2 as a sum of two numbers, and k + SHIFT, k the nearest whole number."""
    whole = fma(x, 0.6366197723675814, SHIFT)
    k = whole - SHIFT
    exact = fma(-k, HALF_PI[0], x)
    part = k * HALF_PI[1]
    r = exact - part
    rest = ((exact - r) - part) - fma(k, HALF_PI[1], -part)
    return r, fma(-k, HALF_PI[3], fma(-k, HALF_PI[2], rest)), whole


def _sine_tail(r, rest):
    """Return sin(r + rest) - r."""
    z = r * r
    w = z * z
    a = fma(z, 8.33333333332248946124e-03, -1.66666666666666324348e-01)
    b = fma(z, 2.75573137070700676789e-06, -1.98412698298579493134e-04)
    s = fma(w, fma(w, fma(z, 1.58969099521155010221e-10, -2.50507602534068634195e-08), b), a)
    return fma(rest, fma(-0.5, z, 1.0), z * r * s)


def _cosine(r, rest):
    """Return cos(r + rest) as a sum of two numbers: 1 - r^2/2, rounded, and the remainder."""
    z = r * r
    w = z * z
    a = fma(z, -1.38888888888741095749e-03, 4.16666666666666019037e-02)
    b = fma(z, -2.75573143513906633035e-07, 2.48015872894767294178e-05)
    c = fma(w, fma(w, fma(z, -1.13596475577881948265e-11, 2.08757232129817482790e-09), b), a)
    most = fma(-0.5, z, 1.0)
    return most, fma(w, c, fma(-0.5, z, 1.0 - most) - r * rest)


def _turned(x, quarters):
    """Return sin(x + quarters pi/2), NaN beyond 1.7e15, where k soon has more digits than a number.

    Source: FDLIBM k_sin.c and k_cos.c (Sun Microsystems 1993), the polynomials.
    """
    r, rest, whole = _remainder_part(x)
    sine = r + _sine_part(r, rest)
    most, less = _cosine_part(r, rest)
    turn = np.float64(whole).view(np.int64) + quarters
    value = most + less if turn & 1 else sine
    value = -value if turn & 2 else value
    return value if abs(whole - SHIFT) < QUARTERS else np.nan


def _sin(x):
    return _turned_part(x, 0)


def _cos(x):
    return _turned_part(x, 1)


def _tan(x):
    """Return sin(r)/cos(r) or -cos(r)/sin(r), both as sums of two numbers."""
    r, rest, whole = _remainder_part(x)
    tail = _sine_part(r, rest)
    sine = r + tail
    most, less = _cosine_part(r, rest)
    cosine = most + less
    odd = np.float64(whole).view(np.int64) & 1
    above, below = (-cosine, sine) if odd else (sine, cosine)
    sine_rest = tail - (sine - r)
    cosine_rest = less - (cosine - most)
    above_rest, below_rest = (-cosine_rest, sine_rest) if odd else (sine_rest, cosine_rest)
    value, error = _quotient_part(above, above_rest, below, below_rest)
    return value + error if abs(whole - SHIFT) < QUARTERS else np.nan


def _quotient(a, a_rest, b, b_rest):
    """Return (a + a_rest)/(b + b_rest) as a sum of two numbers."""
    inverse = 1.0 / b
    value = a * inverse
    return value, (fma(-value, b, a) + a_rest - value * b_rest) * inverse


def _growth(r):
    """Return (e^r - 1 - r)/r^2, |r| <= ln(2)/2: the polynomial through eleven of Chebyshev's points, to 6e-18."""
    z = r * r
    a = fma(z, fma(r, 8.333333333326141e-03, 4.166666666666667e-02), fma(r, 1.6666666666666670e-01, 0.5))
    b = fma(
        z,
        fma(r, 2.7557255425720897e-06, 2.4801587325533377e-05),
        fma(r, 1.9841269874800512e-04, 1.3888888888883752e-03),
    )
    c = fma(z, 2.091467938417506e-09, fma(r, 2.510520638458724e-08, 2.75572736613304e-07))
    w = z * z
    return fma(w, fma(w, c, b), a)


def _power_of_two(whole, shift):
    """Return 2^(k + shift) of k + SHIFT."""
    return np.int64((np.float64(whole).view(np.int64) + 1023 + shift) << 52).view(np.float64)


def _exp(x):
    y = -708.0 if x < -708.0 else x
    y = 710.0 if y > 710.0 else y
    whole = fma(y, 1.4426950408889634, SHIFT)
    k = whole - SHIFT
    r = fma(-k, LN2_LOW, fma(-k, LN2_HIGH, y))
    value = fma(2.0, fma(r * r, _growth_part(r), r), 2.0) * _power_part(whole, -1)
    return 0.0 if x < -708.0 else value


def _exp_less_1(x):
    """Return (e^x - 1)/4 as a sum of two numbers, for -40 <= x < 711.3."""
    whole = fma(x, 1.4426950408889634, SHIFT)
    k = whole - SHIFT
    exact = fma(-k, LN2_HIGH, x)
    small = k * LN2_LOW
    r = exact - small
    curve = r * r * _growth_part(r)
    q = r + curve
    q_rest = (curve - (q - r)) + ((exact - r) - small)
    power = _power_part(whole, -2)
    base = power - 0.25
    value = fma(power, q, base)
    return value, fma(power, q, base - value) + (((power - base) - 0.25) + power * q_rest)


def _expm1(x):
    y = -40.0 if x < -40.0 else x
    value, rest = _less_1_part(710.0 if y > 710.0 else y)
    return 4.0 * (value + rest) if x <= 709.782712893384 else x + np.inf


def _grown(x, shift):
    """Return g = (e^|x| - 1)/4 and g/(g + shift), each as a sum of two numbers."""
    value, rest = _less_1_part(x)
    below = value + shift
    back = below - value
    below_rest = (value - (below - back)) + (shift - back) + rest
    share, share_rest = _quotient_part(value, rest, below, below_rest)
    return value, rest, share, share_rest


def _sinh(x):
    size = abs(x)
    value, rest, share, share_rest = _grown_part(_LARGEST_SINH if size > _LARGEST_SINH else size, 0.25)
    quarter = 0.25 * share
    total = value + quarter
    half = total + ((quarter - (total - value)) + (rest + 0.25 * share_rest))
    half = np.inf if size > _LARGEST_SINH else half
    return -2.0 * half if x < 0.0 else 2.0 * half


def _cosh(x):
    size = abs(x)
    value, rest, share, share_rest = _grown_part(_LARGEST_SINH if size > _LARGEST_SINH else size, 0.25)
    double = value + value
    more = double * share
    more_rest = fma(double, share, -more) + fma(double, share_rest, 2.0 * rest * share)
    total = 1.0 + more
    back = total - more
    value = total + ((more - (total - back)) + (1.0 - back) + more_rest)
    return np.inf if size > _LARGEST_SINH else value


def _tanh(x):
    size = abs(x)
    _, _, share, share_rest = _grown_part(40.0 if size > 20.0 else size + size, 0.5)
    value = 1.0 if size > 20.0 else share + share_rest
    return -value if x < 0.0 else value


def _parts(x):
    """Return k and f of a positive number x = 2^k (1 + f), sqrt(1/2) <= 1 + f < sqrt(2)."""
    tiny = x < 2.2250738585072014e-308
    bits = np.float64(x * 18014398509481984.0 if tiny else x).view(np.int64) + 0x95F619980C433
    m = np.int64((bits & 0xFFFFFFFFFFFFF) + 0x3FE6A09E667F3BCD).view(np.float64)
    power = np.int64(((bits >> 52) & 0x7FF) | 0x4330000000000000).view(np.float64)
    return power - (4503599627371573.0 if tiny else 4503599627371519.0), m - 1.0


def _log(x):
    """Return ln x = k ln 2 + 2 artanh(s), s = f/(2 + f).

    Source: FDLIBM e_log.c (Sun Microsystems 1993), the polynomial in s^2.
    """
    k, f = _parts_part(x)
    s = f / (2.0 + f)
    z = s * s
    w = z * z
    even = w * fma(w, fma(w, 1.531383769920937332e-01, 2.222219843214978396e-01), 3.999999999940941908e-01)
    odd = fma(w, 1.479819860511658591e-01, 1.818357216161805012e-01)
    odd = z * fma(w, fma(w, odd, 2.857142874366239149e-01), 6.666666666666735130e-01)
    half = 0.5 * f * f
    value = fma(k, LN2_HIGH, f - (half - fma(s, half + (even + odd), k * LN2_LOW)))
    value = value if x < np.inf else x
    return value if x > 0.0 else (-np.inf if x == 0.0 else np.nan)


def _precise_log(x):
    """Return ln x of a positive number as a sum of two numbers, to 2^-66 of it.

    artanh(s) = s + s^3/3 + ..., from s^5/5 on by the polynomial through nine of Chebyshev's points in s^2.
    """
    k, f = _parts_part(x)
    below = 2.0 + f
    s, s_rest = _quotient_part(f, 0.0, below, f - (below - 2.0))
    z = s * s
    z_rest = fma(s, s, -z) + 2.0 * s * s_rest
    w = fma(z, 0.10762292748628435, 0.10456341798674194)
    w = fma(z, w, 0.11766812472663445)
    w = fma(z, w, 0.13333296549420992)
    w = fma(z, w, 0.1538461576097939)
    w = fma(z, w, 0.18181818179658235)
    w = fma(z, w, 0.22222222222228424)
    w = fma(z, w, 0.28571428571428564)
    more = z * fma(z, w, 0.4)
    c = THIRDS[0] + more
    c_rest = (more - (c - THIRDS[0])) + THIRDS[1]
    cube = z * s
    cube_rest = fma(z, s, -cube) + (z * s_rest + z_rest * s)
    curve = cube * c
    curve_rest = fma(cube, c, -curve) + (cube * c_rest + cube_rest * c)
    double = s + s
    part = double + curve
    part_rest = (curve - (part - double)) + (curve_rest + 2.0 * s_rest)
    exact = k * LN2_HIGH
    total = exact + part
    rest = (part - (total - exact)) + fma(k, LN2_LOW, part_rest)
    value = total + rest
    return value, rest - (value - total)


def _power(x, y):
    """Return |x|^y = exp(y ln |x|), the product as a sum of two numbers; negative x take whole y alone."""
    size = abs(x)
    logarithm, logarithm_rest = _precise_part(size)
    logarithm = logarithm if size < np.inf else size
    logarithm = -np.inf if size == 0.0 else logarithm
    inner = (size > 0.0) & (size < np.inf)
    product = y * logarithm
    rest = fma(y, logarithm, -product) + y * logarithm_rest
    inner = inner & (abs(product) < 1000.0)
    rest = rest if inner else 0.0
    e = -708.0 if product < -708.0 else product
    e = 710.0 if e > 710.0 else e
    whole = fma(e, 1.4426950408889634, SHIFT)
    k = whole - SHIFT
    exact = fma(-k, LN2_HIGH, e)
    small = fma(k, LN2_LOW, -rest)
    r = exact - small
    t = r + fma(r * r, _growth_part(r), (exact - r) - small)
    value = fma(2.0, t, 2.0) * _power_part(whole, -1)
    value = 0.0 if product < -708.0 else value
    nearest = np.floor(y)
    whole_number = nearest == y
    odd = whole_number & (2.0 * np.floor(0.5 * y) != y)
    value = -value if odd & _negative_part(x) else value
    value = value if (x >= 0.0) | whole_number else np.nan
    return 1.0 if (y == 0.0) | (x == 1.0) else value


def _negative(x):
    """Tell whether the sign of x is minus, of -0 too."""
    return np.float64(x).view(np.int64) < 0


def _hypot(x, y):
    x, y = abs(x), abs(y)
    a, b = (y, x) if y < x else (x, y)
    large = b > 2.0**500
    small = b < 2.0**-400
    scale, back = (2.0**-600, 2.0**600) if large else ((2.0**600, 2.0**-600) if small else (1.0, 1.0))
    a = scale * a
    b = scale * b
    square = b * b
    value = back * np.sqrt(fma(a, a, square) + fma(b, b, -square))
    return np.inf if (x == np.inf) | (y == np.inf) else value


def _arctan2(y, x):
    """Return the angle of (x, y): arctan of the smaller over the larger, or of their difference over their sum.

    Source: FDLIBM s_atan.c (Sun Microsystems 1993), the polynomial.
    """
    across = abs(x)
    along = abs(y)
    steep = along > across
    a, b = (across, along) if steep else (along, across)
    scale = 2.0**-100 if b > 2.0**900 else (2.0**100 if b < 2.0**-900 else 1.0)
    a, b = (scale * a, scale * b) if b < np.inf else ((0.0 if a < np.inf else 1.0), 1.0)
    far = a > 0.41421356237309503 * b
    above = a - b
    below = a + b
    above_rest = a - (above + b)
    below_rest = a - (below - b)
    above, above_rest = (above, above_rest) if far else (a, 0.0)
    below, below_rest = (below, below_rest) if far else (b, 0.0)
    below = 1.0 if below == 0.0 else below
    t, t_rest = _quotient_part(above, above_rest, below, below_rest)
    z = t * t
    w = z * z
    even = fma(w, 1.62858201153657823623e-02, 4.97687799461593236017e-02)
    even = fma(w, fma(w, even, 6.66107313738753120669e-02), 9.09088713343650656196e-02)
    even = fma(w, fma(w, even, 1.42857142725034663711e-01), 3.33333333333329318027e-01)
    odd = fma(w, -3.65315727442169155270e-02, -5.83357013379057348645e-02)
    odd = fma(w, fma(w, odd, -7.69187620504482999495e-02), -1.11111104054623557880e-01)
    s = fma(z, fma(w, odd, -1.99999999998764832476e-01), even)
    rest = fma(-t * z, s, t_rest)
    eighths = 1.0 if far else 0.0
    eighths, t, rest = (2.0 - eighths, -t, -rest) if steep else (eighths, t, rest)
    eighths, t, rest = (4.0 - eighths, -t, -rest) if _negative_part(x) else (eighths, t, rest)
    most = eighths * QUARTER_PI[0]
    total = most + t
    value = total + (((most - total) + t) + fma(eighths, QUARTER_PI[1], rest))
    value = -value if _negative_part(y) else value
    return value if (x == x) & (y == y) else np.nan


def _arctan(x):
    return _arctan2_part(x, 1.0)


def _arcsin(x):
    return _arctan2_part(x, np.sqrt(fma(-x, x, 1.0)))


def _arccos(x):
    return _arctan2_part(np.sqrt(fma(-x, x, 1.0)), x)


def _part(formula: Any) -> Any:
    return Callee(formula, constants=True, forceinline=True)


_remainder_part, _sine_part, _cosine_part, _turned_part = map(_part, (_remainder, _sine_tail, _cosine, _turned))
_quotient_part, _growth_part, _power_part = map(_part, (_quotient, _growth, _power_of_two))
_less_1_part, _grown_part, _parts_part, _precise_part = map(_part, (_exp_less_1, _grown, _parts, _precise_log))
_negative_part, _arctan2_part = map(_part, (_negative, _arctan2))

NUMBERS = kinds.Float, kinds.Integer, kinds.Boolean
"""Types of arguments for the formulas, which do not take arrays and complex numbers."""

OPTIONS: Any = {"error_model": "numpy", "forceinline": True}


def _branch_free(formula: Callable, original: Any) -> Any:
    """Return the function that is the formula where it is compiled for numbers, else NumPy's."""

    def function(*numbers):
        return original(*numbers)

    @overload(function, jit_options=OPTIONS)
    def chosen(*numbers):
        known = FUSED and len(numbers) == original.nin and all(isinstance(kind, NUMBERS) for kind in numbers)
        callee = _part(formula) if known else original
        return lambda *numbers: callee(*numbers)

    function.__name__ = original.__name__
    return function


exp = _branch_free(_exp, np.exp)
expm1 = _branch_free(_expm1, np.expm1)
log = _branch_free(_log, np.log)
sin = _branch_free(_sin, np.sin)
cos = _branch_free(_cos, np.cos)
tan = _branch_free(_tan, np.tan)
sinh = _branch_free(_sinh, np.sinh)
cosh = _branch_free(_cosh, np.cosh)
tanh = _branch_free(_tanh, np.tanh)
arcsin = _branch_free(_arcsin, np.arcsin)
arccos = _branch_free(_arccos, np.arccos)
arctan = _branch_free(_arctan, np.arctan)
arctan2 = _branch_free(_arctan2, np.arctan2)
hypot = _branch_free(_hypot, np.hypot)
power = _branch_free(_power, np.power)
