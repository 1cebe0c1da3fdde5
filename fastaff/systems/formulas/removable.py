"""Denominators that vanish where the formula stays finite: there its floating-point value loses all digits."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from .gammainc import numeric

DIGITS = 120
"""Decimal digits in which quotients near their zeros are computed."""

DRAWS = 40
"""Random points that give the usual size of an expression."""

_NEAR = (-3, -5, -7, -9, -12)
"""Decades of the distances from a zero at which derivatives are compared."""

_ROUNDING = 1e-10
"""Error of derivatives in floating point, relative to their size, above which they lose digits."""


class Vanishing(NamedTuple):
    """A denominator, and the coordinates of a point where it is 0 and the formula finite."""

    denominator: Any
    point: tuple[float, ...]


class Places(NamedTuple):
    """Points of a formula's region for trial: place(coordinates) gives the values of its symbols, draw(rng) coordinates
    of a point.

    special: coordinates of places where denominators often vanish, None for those that are drawn; inside(values) tells
    whether a point is in the domain.
    """

    place: Callable[[Sequence[Any]], Mapping[str, Any]]
    draw: Callable[[random.Random], Sequence[float]]
    special: Sequence[Sequence[float | None]]
    inside: Callable[[Mapping[str, Any]], bool] = lambda values: True
    only_special: bool = False

    def within(self, inside: Callable[[Mapping[str, Any]], bool]) -> Places:
        """Return the places of a domain."""
        return self._replace(inside=inside)


def denominators(expression: Any) -> list[Any]:
    """Return the denominators of an expression: bases of powers that may be negative, and cosines of tangents."""
    import sympy

    found: dict[Any, None] = {}
    for e in sympy.postorder_traversal(expression):
        if e.is_Pow and e.exp.is_negative and not e.base.is_number:
            found[e.base] = None
        elif isinstance(e, sympy.tan):  # sin/cos
            found[sympy.cos(e.args[0])] = None
    return list(found)


def vanishing(expression: Any, places: Places, parameters: Mapping[str, float]) -> list[Vanishing]:
    """Return denominators that vanish inside the domain where the expression stays finite, with at least one of the
    points tried for each.
    """
    import mpmath

    below = denominators(expression)
    if not below:
        return []
    with mpmath.workdps(DIGITS):
        return _vanishing(mpmath.mp, expression, below, places, parameters)


def _vanishing(
    mp: Any, expression: Any, below: list[Any], places: Places, parameters: Mapping[str, float]
) -> list[Vanishing]:
    rng = random.Random(3)
    constants = {f"self.{name}": mp.mpf(value) for name, value in parameters.items()}
    whole = _function(expression)
    slopes = [expression.diff(x) for x in sorted(expression.free_symbols, key=str) if not x.name.startswith("self.")]
    forces = [(_function(slope), _function(slope, "math")) for slope in slopes]
    points = [[mp.mpf(x) for x in places.draw(rng)] for _ in range(DRAWS)]
    sizes = sorted(abs(v) for v in (_value(mp, whole, places, c, constants) for c in points) if v is not None)
    if not sizes:
        return []
    scale = sizes[len(sizes) // 2]
    found = []
    for base in below:
        g = _function(base)
        for zero in _zeros(mp, g, places, points, constants, rng):
            near = _approach(mp, zero, points)
            if not (places.inside(places.place(zero)) and _finite(mp, whole, places, near, constants, scale)):
                continue
            if _loses_digits(mp, forces, places, near, points, constants):
                found.append(Vanishing(base, tuple(float(x) for x in zero)))
                break
    return found


def _function(expression: Any, numbers: str = "mpmath") -> tuple[Any, list[str]]:
    """Return a formula as a function of these `numbers`, and the names of its arguments."""
    import sympy

    symbols = sorted(expression.free_symbols, key=str)
    return sympy.lambdify(symbols, expression, numeric(numbers), dummify=True), [symbol.name for symbol in symbols]


def _value(
    mp: Any, function: tuple[Any, list[str]], places: Places, point: Sequence[Any], constants: Mapping[str, Any]
) -> Any:
    """Return the value at a point, None where it is not a finite real number."""
    call, names = function
    values = {**places.place(point), **constants}
    try:
        value = mp.mpmathify(call(*(values[name] for name in names)))
    except (ArithmeticError, ValueError):
        return None
    return value if isinstance(value, mp.mpf) and mp.isfinite(value) else None


def _zeros(mp: Any, g: Any, places: Places, points: list, constants: Mapping[str, Any], rng: random.Random) -> Any:
    """Yield zeros of g: special places, and zeros between points where g has opposite signs."""
    for special in places.special:
        drawn = places.draw(rng)
        at = [mp.mpf(x if s is None else s) for s, x in zip(special, drawn, strict=True)]
        value = _value(mp, g, places, at, constants)
        if value is not None and abs(value) < mp.mpf(10) ** (20 - DIGITS):
            yield at
    values = [] if places.only_special else [_value(mp, g, places, c, constants) for c in points]
    positive = [c for c, v in zip(points, values, strict=False) if v is not None and v > 0]
    negative = [c for c, v in zip(points, values, strict=False) if v is not None and v < 0]
    for high, low in list(zip(positive, negative, strict=False))[:4]:
        for _ in range(int(3.33 * DIGITS)):
            middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
            value = _value(mp, g, places, middle, constants)
            if value is None:
                break
            low, high = (low, middle) if value > 0 else (middle, high)
        else:
            value = _value(mp, g, places, high, constants)
            if value is not None and abs(value) < mp.mpf(10) ** (40 - DIGITS):  # not a pole of g itself
                yield high


def _approach(mp: Any, zero: Sequence[Any], points: list) -> list[list[Any]]:
    """Return points on a line towards a zero, at distances 10^_NEAR times that of another point."""
    return [[z + mp.mpf(10) ** k * (o - z) for z, o in zip(zero, points[0], strict=True)] for k in _NEAR]


def _finite(mp: Any, whole: Any, places: Places, near: list, constants: Mapping[str, Any], scale: Any) -> bool:
    """Tell whether the formula approaches a finite value."""
    far, close = (_value(mp, whole, places, point, constants) for point in near[-2:])
    if far is None or close is None:
        return False
    return bool(abs(close - far) <= 1e-3 * (scale + abs(far)) and abs(close) <= 1e6 * scale)


def _loses_digits(
    mp: Any, forces: list, places: Places, near: list, points: list, constants: Mapping[str, Any]
) -> bool:
    """Tell whether derivatives in floating point are wrong on the line, by more than `_ROUNDING` of their size there or
    elsewhere.
    """
    for exact, floating in forces:
        sizes = [abs(v) for v in (_value(mp, exact, places, point, constants) for point in points) if v is not None]
        typical = sorted(sizes)[len(sizes) // 2] if sizes else 0
        for point in near:
            point = [mp.mpf(float(x)) for x in point]
            truth = _value(mp, exact, places, point, constants)
            values = {name: float(value) for name, value in {**places.place(point), **constants}.items()}
            if truth is None:
                continue
            rounded = {name: mp.mpf(value) for name, value in values.items()}
            truth = mp.mpmathify(exact[0](*(rounded[name] for name in exact[1])))
            try:
                found = floating[0](*(values[name] for name in floating[1]))
            except (ArithmeticError, ValueError):
                return True
            if not abs(found - truth) <= _ROUNDING * (abs(truth) + typical):
                return True
    return False


def refused(found: Vanishing, names: Sequence[str]) -> ValueError:
    """Return the error for a formula that cannot be evaluated to rounding."""
    at = ", ".join(f"{name} = {x:.4g}" for name, x in zip(names, found.point, strict=True))
    return ValueError(
        f"text: the denominator {found.denominator} vanishes inside the domain, as at {at}, where the formula stays "
        "finite: near there its "
        "forces would lose their digits. Write it without the quotient, or give a domain that leaves that place out"
    )
