"""Intervals of numbers that run through the formulas of a potential: their results enclose all its values there.

Operators and NumPy's functions of intervals are intervals. Rounding is not directed: enclosures hold to some 1e-13.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

_INF = np.inf
_RISING = {
    "sqrt": (0.0, _INF),
    "log": (0.0, _INF),
    "log1p": (-1.0, _INF),
    "arcsin": (-1.0, 1.0),
    **dict.fromkeys(("exp", "expm1", "sinh", "tanh", "arctan", "cbrt", "positive"), (-_INF, _INF)),
}
"""Functions that grow, and where they live."""
_EVEN = ("square", "cosh", "absolute", "fabs")


class Sector(NamedTuple):
    """Boxes in rho and x = cos(vartheta), lo and hi (2, k) of both."""

    lo: np.ndarray
    hi: np.ndarray

    def squares(self) -> tuple[Interval, Interval]:
        """Return A = alpha^2 and B = beta^2."""
        return _linear(self, (2, 0.0, 1.0, 0.0)), _linear(self, (2, 0.0, 0.0, 1.0))


class Interval(NDArrayOperatorsMixin):
    """Numbers between lo (k,) and hi (k,).

    linear: a sector and (power, c, p, q) of c + p alpha^power + q beta^power, whose range is known exactly; scaled: a
    number and the interval that it multiplies.
    """

    def __init__(self, lo: Any, hi: Any, linear: Any = None):
        self.lo = np.where(np.isnan(lo), -_INF, lo)
        self.hi = np.where(np.isnan(hi), _INF, hi)
        self.linear: Any = linear
        self.scaled: Any = None

    def __bool__(self) -> bool:
        raise TypeError("an interval is neither true nor false")

    def __array_function__(self, function: Any, types: Any, inputs: Any, extra: Any) -> Any:
        if function is not np.where or len(inputs) != 3:
            return NotImplemented
        chosen, yes, no = inputs[0], *map(interval, inputs[1:])
        if not isinstance(chosen, Interval):
            return Interval(np.where(chosen, yes.lo, no.lo), np.where(chosen, yes.hi, no.hi))
        lo, hi = ((pick(a, b), a, b) for pick, a, b in ((np.minimum, yes.lo, no.lo), (np.maximum, yes.hi, no.hi)))
        sure = chosen.lo > 0
        never = chosen.hi <= 0
        return Interval(*(np.where(sure, a, np.where(never, b, both)) for both, a, b in (lo, hi)))

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **extra: Any) -> Any:
        name = ufunc.__name__
        if method != "__call__" or extra:
            return NotImplemented
        if name in _RISING:
            lo, hi = (ufunc(np.clip(end, *_RISING[name])) for end in (self.lo, self.hi))
            if name == "sqrt" and self.linear and self.linear[1] in ((2, 0.0, 1.0, 0.0), (2, 0.0, 0.0, 1.0)):
                return _linear(self.linear[0], (1, *self.linear[1][1:]))
            return Interval(lo, hi)
        if name in _EVEN:
            ends = (ufunc(self.lo), ufunc(self.hi))
            zero = (self.lo < 0) & (self.hi > 0)
            return Interval(np.where(zero, ufunc(0.0), np.minimum(*ends)), np.maximum(*ends))
        rule = _RULES.get(name)
        return NotImplemented if rule is None else rule(*map(interval, inputs))


def interval(x: Any) -> Interval:
    """Return a number, or numbers, as intervals."""
    if isinstance(x, Interval):
        return x
    number = np.asarray(x, dtype=float)
    return Interval(number, number, (None, (0, float(number), 0.0, 0.0)) if number.ndim == 0 else None)


def _constant(x: Interval) -> float | None:
    """Return the number that x is, None for others."""
    return x.linear[1][1] if x.linear and x.linear[1][0] == 0 else None


def _linear(sector: Sector | None, form: tuple[int, float, float, float]) -> Interval:
    power, c, p, q = form
    if sector is None or power == 0:
        return interval(c)
    x = np.array([sector.lo[1], sector.hi[1]])
    first = (1 + x) / 2
    second = (1 - x) / 2
    if power == 1:
        first = np.sqrt(first)
        second = np.sqrt(second)
    ends = p * first + q * second
    low, high = ends.min(axis=0), ends.max(axis=0)
    if power == 1 and p * q > 0:  # sqrt(p^2 + q^2) cos(vartheta/2 - atan(q/p)) has its top inside
        size = np.hypot(p, q)
        top = (p * p - q * q) / (p * p + q * q)
        inside = (x[0] < top) & (top < x[1])
        low = np.where(inside & (p < 0), -size, low)
        high = np.where(inside & (p > 0), size, high)
    near = sector.lo[0] ** power
    far = sector.hi[0] ** power
    return Interval(c + low * np.where(low > 0, near, far), c + high * np.where(high > 0, far, near), (sector, form))


def _add(x: Interval, y: Interval) -> Interval:
    if x.linear and y.linear:
        one, a = x.linear
        other, b = y.linear
        if a[0] == b[0] or 0 in (a[0], b[0]):
            sums = (u + v for u, v in zip(a[1:], b[1:], strict=True))
            return _linear(one if other is None else other, (max(a[0], b[0]), *sums))
    return Interval(x.lo + y.lo, x.hi + y.hi)


def _negative(x: Interval) -> Interval:
    return _scaled(-1.0, x)


def _multiply(x: Interval, y: Interval) -> Interval:
    if x is y:
        return np.square(x)
    for one, other in ((x, y), (y, x)):
        if (c := _constant(one)) is not None:
            return _scaled(c, other)
        if one.scaled and one.scaled[1] is other:
            return _scaled(one.scaled[0], np.square(other))
    with np.errstate(all="ignore"):
        ends = [u * v for u in (x.lo, x.hi) for v in (y.lo, y.hi)]
    ends = [np.where(np.isnan(end), 0.0, end) for end in ends]  # 0 times infinity
    return Interval(np.minimum.reduce(ends), np.maximum.reduce(ends))


def _scaled(c: float, x: Interval) -> Interval:
    factor, base = x.scaled or (1.0, x)
    if x.linear:
        found = _linear(x.linear[0], (x.linear[1][0], *(c * part for part in x.linear[1][1:])))
    elif c == 0:
        return interval(0.0)
    else:
        found = Interval(*((c * x.lo, c * x.hi) if c > 0 else (c * x.hi, c * x.lo)))
    found.scaled = c * factor, base
    return found


def _reciprocal(x: Interval) -> Interval:
    split = (x.lo < 0) & (x.hi > 0)
    lo, hi = (
        np.where(end == 0, np.inf * sign, 1 / np.where(end == 0, 1.0, end)) for end, sign in ((x.hi, -1), (x.lo, 1))
    )
    return Interval(np.where(split, -_INF, lo), np.where(split, _INF, hi))


def _power(x: Interval, y: Interval) -> Interval:
    n = _constant(y)
    if n is None:
        return np.exp(_multiply(y, np.log(x)))
    if n < 0:
        return _reciprocal(_power(x, interval(-n)))
    if n % 2 == 0:
        x = np.absolute(x) if n else interval(1.0)
    low = x.lo if n.is_integer() else np.maximum(x.lo, 0.0)
    return np.square(x) if n == 2 else Interval(low**n, np.maximum(x.hi, low) ** n)


def _cos(x: Interval) -> Interval:
    turn = 2 * np.pi
    top = np.floor(x.hi / turn) >= np.ceil(x.lo / turn)
    bottom = np.floor(x.hi / turn - 0.5) >= np.ceil(x.lo / turn - 0.5)
    ends = np.cos(np.where(np.isfinite(x.lo), x.lo, 0.0)), np.cos(np.where(np.isfinite(x.hi), x.hi, 0.0))
    return Interval(np.where(bottom, -1.0, np.minimum(*ends)), np.where(top, 1.0, np.maximum(*ends)))


def _tan(x: Interval) -> Interval:
    whole = np.floor(x.hi / np.pi + 0.5) > np.floor(x.lo / np.pi + 0.5)
    return Interval(np.where(whole, -_INF, np.tan(x.lo)), np.where(whole, _INF, np.tan(x.hi)))


def _less(x: Interval, y: Interval) -> Interval:
    return Interval((x.hi < y.lo) * 1.0, (x.lo <= y.hi) * 1.0)


_RULES: dict[str, Callable] = {
    "add": _add,
    "subtract": lambda x, y: _add(x, _negative(y)),
    "multiply": _multiply,
    "divide": lambda x, y: _multiply(x, _reciprocal(y)),
    "reciprocal": _reciprocal,
    "negative": _negative,
    "power": _power,
    "float_power": _power,
    "arccos": lambda x: Interval(*(np.arccos(np.clip(end, -1, 1)) for end in (x.hi, x.lo))),
    "cos": _cos,
    "sin": lambda x: _cos(_add(x, interval(-np.pi / 2))),
    "tan": _tan,
    "maximum": lambda x, y: Interval(np.maximum(x.lo, y.lo), np.maximum(x.hi, y.hi)),
    "minimum": lambda x, y: Interval(np.minimum(x.lo, y.lo), np.minimum(x.hi, y.hi)),
    "hypot": lambda x, y: np.sqrt(_add(np.square(x), np.square(y))),
    **dict.fromkeys(("less", "less_equal"), _less),
    **dict.fromkeys(("greater", "greater_equal"), lambda x, y: _less(y, x)),
}
