"""The period of a driven potential: what it is, and whether the potential has it."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from typing import Any

from ..base.numbers import positive, shown
from .grammar import CONSTANTS, FUNCTIONS, TIME, Program, parse
from .library import Request

POINTS, PHASES = 24, 7
"""Random points at which a potential is looked at, and moments of its period."""

ALIKE, ROUNDED = 1e-9, 1e-13
"""Change of a potential over its period beside its change within it, and beside its size, that are rounding: those of
a period that is given with ten digits are not.
"""


def period_of(request: Request, period: Any, values: Mapping[str, float], length: int) -> float:
    """Return the period of a request's potential, given as a number or as a formula of the parameters with these
    values. Raises ValueError or TypeError where it is none, or where V does not depend on the time or has not that
    period.
    """
    if request.period:
        own = parse(request.period, (), request.parameters, argument="period")
        number = _value(own, values)
        if number is None or not number > 0:
            raise ValueError(f"period must be positive, got {request.period!r}, which is {number}")
    else:
        number = positive("period", period)
    program = request.program(length)
    if TIME not in program.names:
        raise ValueError(
            f"text: the formula {request.text!r} does not depend on the time {TIME}: leave its period out, got "
            f"{shown(period)}"
        )
    _check_period(program, request.coordinates[:-1], values, number)
    return number


def _check_period(program: Program, coordinates: tuple[str, ...], values: Mapping[str, float], period: float) -> None:
    """Refuse a potential whose values a period apart are not the same."""
    rng = random.Random(1)
    for _ in range(POINTS):
        scale = 10 ** rng.uniform(-1, 1)
        q = {name: scale * rng.uniform(-1.5, 1.5) for name in coordinates}
        moments = [period * (k + rng.random()) / PHASES for k in range(PHASES)]
        now = [_value(program, {**values, **q, TIME: t}) for t in moments]
        later = [_value(program, {**values, **q, TIME: t + period}) for t in moments]
        known = [value for value in now if value is not None]
        if not known:
            continue
        allowed = ALIKE * (max(known) - min(known)) + ROUNDED * max(map(abs, known))
        for t, one, other in zip(moments, now, later, strict=True):
            if one is None and other is None:
                continue
            if one is None or other is None or not abs(one - other) <= allowed:
                at = ", ".join(f"{name} = {value:.4g}" for name, value in q.items())
                raise ValueError(
                    f"period must be one of the potential's, got {period!r}: at {at} it is {one} at {TIME} = {t:.4g} "
                    f"and {other} a period later"
                )


def _value(program: Program, names: Mapping[str, float]) -> float | None:
    """Return the value of a program in the arithmetic of floats; None where it is no finite real number."""
    functions = {name: getattr(math, name) for name in FUNCTIONS}
    try:
        value = program.run(float, {**names, **CONSTANTS}, functions, pow)
    except (ArithmeticError, ValueError):
        return None
    return value if isinstance(value, (int, float)) and math.isfinite(value) else None
