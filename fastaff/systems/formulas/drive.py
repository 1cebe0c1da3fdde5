"""The period of a driven potential: its value, and a test that the potential has it."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...core.numbers import positive, shown
from .grammar import CONSTANTS, FUNCTIONS, NUMERIC, TIME, Program, parse
from .library import Request

POINTS = 24
"""Number of random points at which a potential is evaluated."""

PHASES = 7
"""Number of moments of its period at which a potential is evaluated."""

ALIKE = 1e-9
"""Change of a potential over its period, relative to its change within it, that counts as rounding. A period given with
only ten digits makes a larger one.
"""

ROUNDED = 1e-13
"""Change of a potential over its period, relative to its size, that counts as rounding."""


def period_of(request: Request, period: Any, values: Mapping[str, float], length: int) -> float:
    """Return the period of a request's potential, given as a number or as a formula of the parameters with these
    values. Raises ValueError or TypeError where it is no period, or where V does not depend on the time or does not
    have that period.
    """
    if request.period:
        own = parse(request.period, (), request.parameters, argument="drive_period")
        number = _value(own, values)
        if number is None or not number > 0:
            raise ValueError(f"drive_period must be positive, got {shown(request.period)}, which is {number}")
    else:
        number = positive("drive_period", period)
    program = request.program(length)
    if TIME not in program.names:
        raise ValueError(
            f"drive_period must be left out for a formula without the time {TIME}, got {shown(period)} and "
            f"{shown(request.text)}"
        )
    _check_period(program, tuple(name for name in request.variables if name != TIME), values, number)
    return number


def _check_period(program: Program, coordinates: tuple[str, ...], values: Mapping[str, float], period: float) -> None:
    """Refuse a potential whose values a period apart differ."""
    rng = random.Random(1)
    q = np.empty((len(coordinates), POINTS, 1))
    moments = np.empty((POINTS, PHASES))
    for k in range(POINTS):
        scale = 10 ** rng.uniform(-1, 1)
        q[:, k, 0] = [scale * rng.uniform(-1.5, 1.5) for _ in coordinates]
        moments[k] = [period * (j + rng.random()) / PHASES for j in range(PHASES)]
    known = {name: np.float64(value) for name, value in {**values, **CONSTANTS}.items()}
    given = {**known, **dict(zip(coordinates, q))}
    now, later = (_values(program, {**given, TIME: t}) for t in (moments, moments + period))
    with np.errstate(invalid="ignore"):
        within = [np.fmax.reduce(now, axis=1), -np.fmax.reduce(-now, axis=1)]
        allowed = ALIKE * (within[0] - within[1]) + ROUNDED * np.fmax.reduce(np.abs(now), axis=1)
        seen = np.isfinite(now).any(axis=1)[:, None] & (np.isfinite(now) | np.isfinite(later))
        wrong = seen & ~(np.abs(now - later) <= allowed[:, None])
    if wrong.any():
        k, j = np.argwhere(wrong)[0]
        one, other = (None if np.isnan(value) else value for value in (float(now[k, j]), float(later[k, j])))
        raise ValueError(
            f"drive_period must be a period of the potential, got {shown(period)}: a value of V changes from "
            f"{_brief(one)} to {_brief(other)} after it"
        )


def _brief(value: float | None) -> str:
    return "None" if value is None else f"{value:.6g}"


def _values(program: Program, names: Mapping[str, Any]) -> np.ndarray:
    """Return the values (POINTS, PHASES) of a program of arrays, NaN where they are no finite real numbers."""
    with np.errstate(all="ignore"):
        functions = NUMERIC | {name: getattr(np, name) for name in FUNCTIONS}
        value = program.run(np.float64, names, functions, np.power)
    value = np.broadcast_to(value, (POINTS, PHASES))
    return np.where(np.isfinite(value), value, np.nan)


def _value(program: Program, names: Mapping[str, float]) -> float | None:
    """Return the value of a program in the arithmetic of floats; None where it is no finite real number."""
    try:
        value = program.run(float, {**names, **CONSTANTS}, NUMERIC, pow)
    except (ArithmeticError, ValueError):
        return None
    return value if isinstance(value, (int, float)) and math.isfinite(value) else None
