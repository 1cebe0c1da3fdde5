"""Hints on a name without a value: it may be a momentum, a coordinate, or a term that a body does not have."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ParamSpec, TypeVar, cast

from ...core.numbers import shown
from ..models.body import FREE, TERMS
from .arguments import checked_names
from .grammar import TIME, UnknownName

PULLED = "Use ode(model, forces={'x': 'f*cos(w*t) - g*p_x'}, ...)."
"""Advice where friction is given with an argument that excludes it."""

P = ParamSpec("P")
R = TypeVar("R")


def hinted(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function that takes V or H as text name the argument that may be missing for a name without a value."""

    @functools.wraps(function)
    def wrapped(*given: Any, **named: Any) -> Any:
        try:
            return function(*given, **named)
        except UnknownName as problem:
            hint = _of_body(problem.name) if function.__name__ == "affine_body" else _of_rows(problem.name, named)
            if not hint:
                raise
            raise UnknownName(problem.place, problem.name, hint) from None

    return cast(Callable[P, R], wrapped)


def no_terms_of_motion(names: Iterable[str], text: Any) -> None:
    """Refuse parameters of a body's formula that would be terms of its motion, where they are not in the text."""
    for name in names:
        if name in TERMS and re.search(rf"\b{name}\b", str(text)) is None:
            raise ValueError(f"{name} must be a name in {shown(text, 40)}. {FREE}")


def _of_body(name: str) -> str:
    return FREE if name == TIME else ""


def _of_rows(name: str, named: Mapping[str, Any]) -> str:
    """Return a guess at the meaning of a name where V or H is written with these arguments."""
    coordinates = named.get("coordinates")
    known = ("x", "y") if coordinates is None else checked_names("coordinates", coordinates)
    if named.get("momenta") is None:
        count = range(1, len(known) + 1)
        rows = [[form.format(k) for k in keys] for keys in (known, count) for form in ("p_{}", "p{}", "P_{}", "P{}")]
        for own in (*rows, ["p"] if len(known) == 1 else []):
            if name in own:
                return f"For a momentum give momenta='{' '.join(own)}'; the text is then the whole of H."
        if coordinates is None and (found := re.fullmatch(r"p_([A-Za-z]\w*)", name)):
            return f"For a momentum give coordinates='{found[1]} ...' and momenta='{name} ...'."
    if coordinates is None and name != TIME:
        return f"Give a parameter its value, {name}=1.0, or name the coordinates, coordinates='{name} ...'."
    return ""
