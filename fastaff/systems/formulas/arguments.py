"""Arguments of formulas as checked values: texts, names, parameters, masses."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.foreign import call_for, dispatch_adapter
from ...core.numbers import positive, real, shown
from .grammar import checked_name
from .reserved import MAX_DEGREES_OF_FREEDOM, RESERVED, WITHOUT_BODY

MAX_PARAMETERS = 64
"""Most parameters of a formula."""


def text_of(text: Any) -> str:
    """Return a formula as text: expressions, of SymPy and of heyoka, go through a tree whitelist."""
    if isinstance(text, str):
        return text
    expression = dispatch_adapter("expression", text)
    expression = text if expression is None else expression
    sympy = sys.modules.get("sympy")
    if sympy is not None and isinstance(expression, sympy.Expr):
        from .sympy_bridge import to_text

        return to_text(expression)
    raise TypeError(
        f"text must be a formula such as 'C/2*(D1**2 + D2**2)' or a SymPy expression, got {shown(text)} "
        f"({type(text).__name__}){call_for(text)}"
    )


def values_of(parameters: dict[str, Any], variables: tuple[str, ...], *, body: bool = False) -> dict[str, float]:
    """Return the parameters of a formula with their numbers, checked; body: it is the formula of a body."""
    if len(parameters) > MAX_PARAMETERS:
        raise ValueError(f"parameters must be at most {MAX_PARAMETERS}, got {len(parameters)}")
    taken = {*variables, *(RESERVED if body else WITHOUT_BODY)}
    return {checked_name(name, "parameter", taken): real(name, value) for name, value in parameters.items()}


def inertia_of(mu: Any) -> tuple[float, float]:
    """Return a pair of inertias, checked."""
    if len(mu) != 2:
        raise ValueError(f"mu must be a positive number or a pair of them, got {shown(mu)}")
    return positive("mu[0]", mu[0]), positive("mu[1]", mu[1])


def checked_names(argument: str, coordinates: Any, taken: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the names of coordinates in a text or a sequence; refuse names that are taken."""
    if isinstance(coordinates, str):
        coordinates = coordinates.replace(",", " ").split()
    if not isinstance(coordinates, Sequence):
        raise TypeError(
            f"{argument} must be names such as 'x y', got {shown(coordinates)} ({type(coordinates).__name__})"
        )
    if not 1 <= len(coordinates) <= MAX_DEGREES_OF_FREEDOM:
        raise ValueError(f"{argument} must be 1 to {MAX_DEGREES_OF_FREEDOM} names, got {len(coordinates)}")
    names: list[str] = []
    for name in coordinates:
        what = {"coordinates": "coordinate"}.get(argument, argument)
        names.append(checked_name(name, what, {*names, *taken, "self", "np"}))
    return tuple(names)


def masses_of(masses: Any, count: int) -> tuple[float, ...]:
    """Return the masses of `count` coordinates, checked."""
    if (
        not isinstance(masses, (Sequence, np.ndarray))
        or isinstance(masses, str)
        or (isinstance(masses, np.ndarray) and masses.ndim != 1)
    ):
        raise TypeError(
            f"masses must be one positive number for each coordinate, got {shown(masses)} ({type(masses).__name__})"
        )
    if len(masses) != count:
        raise ValueError(f"masses must be {count} positive numbers, one for each coordinate, got {len(masses)}")
    return tuple(positive(f"masses[{i}]", mass) for i, mass in enumerate(masses))
