"""Sections as text: alpha-turning, beta=0.2, x=0. The grammar of jobs, of the command line and of all functions."""

from __future__ import annotations

from typing import Any

from ..base.names import named
from ..models.contracts import coordinate_names, isotropic, planar
from ..models.sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Linear
from .number import number

TURNING = {"alpha-turning": AlphaTurning, "beta-turning": BetaTurning}
EQUALS = {"alpha": AlphaEquals, "beta": BetaEquals, "area": AreaEquals}


def section_forms(model: Any) -> tuple[str, ...]:
    """Return the texts that stand for sections of a model, with c for a number."""
    coordinates = tuple(f"{name}=c" for name in coordinate_names(model))
    if not planar(model):
        return coordinates
    return (*TURNING, *(f"{name}=c" for name in EQUALS), *(() if isotropic(model) else coordinates))


def section_named(text: str, model: Any, direction: int = 1, *, argument: str = "section") -> Any:
    """Return the section of a model that a text stands for. Raises ValueError with the forms that there are."""
    forms = section_forms(model)
    name, equals, constant = text.partition("=")
    form = named(argument, f"{name.strip()}=c" if equals else name.strip(), forms)
    if not equals:
        return TURNING[form](direction)
    name = form.removesuffix("=c")
    if not constant.strip():
        raise ValueError(f"{argument} {form} needs a number for c, such as {name}=0.2, got {text!r}")
    value = number(f"{argument} {form}: c", constant)
    if planar(model) and name in EQUALS:
        return EQUALS[name](value, direction)
    row = coordinate_names(model).index(name)
    return Linear(tuple(float(k == row) for k in range(2 * model.degrees_of_freedom)), value, direction)


def section_of(value: Any, model: Any) -> Any:
    """Return the section that a text stands for; anything else as it is."""
    return section_named(value, model) if isinstance(value, str) and hasattr(model, "degrees_of_freedom") else value
