"""Arguments of `hamiltonian` that make a term of the equations beside T and V (`engine.kinds.OPTIONS`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...core.numbers import listed, real, shown
from ...engine.kinds import OPTIONS, TERMS
from ...engine.terms import Term
from .hints import PULLED


def term_of(options: Mapping[str, Any], period: Any) -> Term | None:
    """Return the term that options add to T and V; refuse two terms, and a term with a drive."""
    given = {name: TERMS[OPTIONS[name]] for name, entry in options.items() if entry is not None}
    terms = [*dict.fromkeys(given.values())]
    lost = next((name for name, term in given.items() if "loss" in term.words), None)
    if lost is not None and (len(terms) > 1 or period is not None):
        others = ", ".join(name for name in options if OPTIONS[name] != OPTIONS[lost])
        raise ValueError(f"{lost} must be given without {others} and drive_period. {PULLED}")
    if len(terms) > 1:
        raise ValueError(f"{' and '.join(given)} must not be given together. Use the equations, fa.ode(...).")
    if terms and period is not None:
        raise ValueError(f"drive_period must be given without {listed(given)}: a driven system has no rotating frame")
    return terms[0] if terms else None


def rates_of(given: Mapping[str, Any], values: dict[str, float], names: tuple[str, ...]) -> dict[str, str]:
    """Return the given options of terms as formulas of the parameters; a number becomes a parameter of that
    name.
    """
    found: dict[str, str] = {}
    for name, entry in given.items():
        if entry is None:
            continue
        if len(names) < 2 and TERMS[OPTIONS[name]].planar:
            raise ValueError(f"{name} must rotate two coordinates, the first ones, got {listed(names)}")
        if isinstance(entry, str):
            found[name] = entry
            continue
        if name in names:
            raise ValueError(f"coordinates must not have the name {shown(name)} of an argument that is a number")
        values[name] = real(name, entry)
        found[name] = name
    return found
