"""Numbers as text: 1/6, pi/2, 1e-3, by the grammar of formulas."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from ...core.numbers import shown
from .grammar import CONSTANTS, NUMERIC, parse


def number(name: str, text: str, known: Mapping[str, float] = MappingProxyType({})) -> float:
    """Return the finite number of a text: a plain one, or a formula of numbers, pi and known names, in the arithmetic
    of floats. Raises ValueError that names the argument.
    """
    try:
        value = float(text)
    except ValueError:
        try:
            formula = parse(text, (), tuple(known), argument=name, length=200)
            value = formula.run(float, {**CONSTANTS, **known}, NUMERIC, pow)
        except (ValueError, ArithmeticError) as problem:
            what = str(problem).removeprefix(f"{name}: ").partition(". ")[0]
            hint = " (angles are in radians: 45*pi/180)" if text.rstrip().endswith(("deg", "°", "degrees")) else ""
            raise ValueError(
                f"{name} must be a number such as 1.5, 1/6, pi/2 or 1e-3, got {shown(text)}: {what}{hint}"
            ) from None
    if isinstance(value, complex) or not math.isfinite(value):
        raise ValueError(f"{name} must be finite, got {shown(text)}")
    return value
