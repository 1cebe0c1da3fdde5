"""Domains of formulas: conditions that are positive inside.

Arguments of logarithms, of roots and powers that are not whole, and the second of gammainc must be positive, those of
asin and acos below 1 in size. A pole 1/g is a wall g > 0 (or -g > 0) if g has one sign on the whole region: D1 > D2 > 0
for a body, everywhere for other systems. 1/g^2 is always a wall.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ...core.descent import descended
from .gammainc import GAMMAINC, numeric

SAMPLES = 400
"""Random points at which the sign of a denominator is looked up."""

SIMPLE = 60
"""Operations of a denominator above which it is not factored."""

SIZES = 6.0
"""Decades to both sides of 1 in which coordinates are drawn: their units and origins may be any."""


def everywhere(symbols: Iterable[Any]) -> Callable[[np.random.Generator, int], dict[Any, np.ndarray]]:
    """Return a function that draws coordinates of these symbols: half around the origin, half of all sizes."""

    def region(rng: np.random.Generator, count: int) -> dict[Any, np.ndarray]:
        near = {x: 1.5 * rng.standard_normal(count) for x in symbols}
        sizes = {x: rng.choice([-1.0, 1.0], count) * 10 ** rng.uniform(-SIZES, SIZES, count) for x in symbols}
        return {x: np.concatenate([near[x], sizes[x]]) for x in symbols}

    return region


def reached(walls: Sequence[Any], symbols: Sequence[Any], values: Mapping[str, float]) -> list[float] | None:
    """Return values of these symbols at which all walls are positive, found by upward steps along the coordinates from
    points of all sizes; None where there are none, or no wall. values: those of the parameters.
    """
    import sympy

    if not walls:
        return None
    fixed = {x: values[x.name.removeprefix("self.")] for w in walls for x in w.free_symbols if x not in symbols}
    heights = sympy.lambdify(symbols, [w.xreplace(fixed) for w in walls], numeric("numpy"), dummify=True)

    def below(x: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            each = [np.log1p(np.maximum(-np.real(h), 0.0)) + 0.0 * x[0] for h in heights(*x)]
        return np.nan_to_num(np.sum(each, axis=0), nan=np.inf)

    drawn = everywhere(symbols)(np.random.default_rng(3), 64)
    start = np.array([drawn[x] for x in symbols])
    x, low, _ = descended(below, start, np.maximum(np.abs(start) / 2, 1e-3))
    best = int(np.argmin(low))
    return [float(c) for c in x[:, best]] if low[best] == 0 else None


def conditions(
    expression: Any,
    region: Callable[[np.random.Generator, int], Mapping[Any, np.ndarray]],
    centres: Sequence[Any] = (),
) -> list[Any]:
    """Return expressions that are positive in the domain of `expression`; region(rng, count) draws coordinates.

    Bases of powers that are nowhere negative, and whose zeros are `centres`, are no walls.

    Parameters, whose values may change later, are drawn positive.
    """
    import sympy

    found: list[Any] = []
    coordinates = set(region(np.random.default_rng(1), 1))

    def add(g: Any) -> None:
        # Radii may be 0, where 1/r has its pole: the symbols' own positivity proves nothing.
        closed = {x: sympy.Dummy(nonnegative=True) for x in coordinates if x.is_positive}
        if g.xreplace(closed).is_positive or not g.free_symbols & coordinates:
            return
        g = _plain(g)
        if g not in found:
            found.append(g)

    for e in sympy.postorder_traversal(expression):
        if isinstance(e, sympy.log):
            add(e.args[0])
        elif isinstance(e, (sympy.asin, sympy.acos)):
            add(1 - e.args[0] ** 2)
        elif type(e).__name__ == GAMMAINC:
            add(e.args[1])
        elif e.is_Pow and not e.exp.is_Integer:
            if e.base not in centres or _sign(e.base, region) <= 0:
                add(e.base)
        elif e.is_Pow and e.exp.is_negative:
            sign = _sign(e.base, region)
            if sign:
                add(sign * e.base)
            elif e.exp.is_even:
                add(e.base**2)
    return found


def poles(expression: Any, region: Callable[[np.random.Generator, int], Mapping[Any, np.ndarray]]) -> list[Any]:
    """Return expressions that pass a whole number at poles of `expression` inside its domain: an orbit may be on either
    side of them, but crosses none; region as in `conditions`.

    For a sine or cosine it is the number of its half turns: one step may pass two of its poles.
    """
    import sympy

    found: list[Any] = []
    coordinates = set(region(np.random.default_rng(1), 1))
    for e in sympy.postorder_traversal(expression):
        if isinstance(e, sympy.tan):
            bases = [sympy.cos(e.args[0])]
        else:
            bases = [e.base] if e.is_Pow and e.exp.is_Integer and e.exp.is_negative else []
        for base in bases:
            for g in sympy.Mul.make_args(sympy.factor(sympy.trigsimp(base)) if base.count_ops() < SIMPLE else base):
                g = g.base if g.is_Pow and g.exp.is_Integer else g
                if g.free_symbols & coordinates and not _sign(g, region) and not {g, -g} & {*found}:
                    found.append(g)
    return [_counting(g) for g in found]


def _counting(g: Any) -> Any:
    """Return an expression that passes a whole number where g is 0."""
    import sympy

    if isinstance(g, (sympy.sin, sympy.cos)):
        return g.args[0] / sympy.pi - (sympy.Rational(1, 2) if isinstance(g, sympy.cos) else 0)
    return g / (1 + sympy.Abs(g))


def _plain(g: Any) -> Any:
    """Return g without a constant positive factor."""
    import sympy

    coefficient, rest = sympy.factor_terms(g).as_coeff_Mul()
    if rest.is_Add or not coefficient.is_number:
        return rest if coefficient > 0 else sympy.Mul(-1, rest, evaluate=True)
    return g / abs(coefficient)


def _sign(g: Any, region: Callable) -> int:
    """Return +1 or -1 where g has that sign at every sample of the region, else 0."""
    import sympy

    rng = np.random.default_rng(2)
    points = region(rng, SAMPLES)
    count = len(next(iter(points.values())))
    arguments = sorted(g.free_symbols, key=str)
    values = [points[a] if a in points else rng.uniform(0.1, 2.0, count) for a in arguments]
    with np.errstate(all="ignore"):
        numbers = np.broadcast_to(sympy.lambdify(arguments, g, numeric("numpy"), dummify=True)(*values), count)
    if numbers.dtype.kind != "f":
        return 0
    numbers = numbers[np.isfinite(numbers) & (numbers != 0)]  # 0 may be an underflow
    if not numbers.size:
        return 0
    if numbers.min() > 0:
        return 1
    if numbers.max() < 0:
        return -1
    return 0
