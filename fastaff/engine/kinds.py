"""Kinds of motion: the equations of a system in words, and the terms that loops, analyses and refusals depend on."""

from __future__ import annotations

import functools
from collections.abc import Set
from dataclasses import dataclass
from typing import ClassVar

from ..core.numbers import listed
from .damping import FRICTION
from .terms import Term
from .turning import FRAME

TERMS: dict[str, Term] = {
    "drive": Term(
        "V depends on the time, which is the last coordinate: `period`, phase(t)",
        "H = T(p) + V(q, t) with a period in t",
    ),
    "frame": FRAME,
    "friction": FRICTION,
    "nonseparable": Term(
        "H of coordinates and momenta together: energy(z...), rates(z...), tangent_rates(z..., dz...)", "H(q, p)"
    ),
    "rates": Term("variables instead of coordinates with momenta: rates(z...)", "dz/dt = f(z)"),
    "iterates": Term("whole numbers of iterates instead of a time: iterate(z...), periods()", "z -> M(z)"),
}
"""Terms that equations have beside H = T(p) + V(q), by name."""


@dataclass(frozen=True)
class Kind:
    """The equations of a model in words, and those of TERMS that they have. A model without `kind` is SEPARABLE."""

    equations: str
    terms: Set[str] = frozenset()

    def __post_init__(self) -> None:
        terms = frozenset(self.terms)
        others = terms - {"drive"}
        if others - TERMS.keys() or len(others) > 1 or (others != terms and others & {"rates", "iterates"}):
            beside = ", ".join(name for name, entry in TERMS.items() if entry.substep is not None)
            allowed = f"one of {', '.join(TERMS)}, or drive with {beside} or nonseparable"
            raise ValueError(f"terms must be {allowed}, got {listed(sorted(terms))}")
        object.__setattr__(self, "terms", terms)

    @functools.cached_property
    def words(self) -> Set[str]:
        """The words that refusals depend on: its terms and the properties of each. These are "drifts" or "kicks", the
        stage of its substep, and "energy" if it adds to H; a frame has none, as the least energy at a place with it is
        known.
        """
        found = {*self.terms}
        for entry in map(TERMS.__getitem__, self.terms):
            found |= {"term", *entry.words} | (
                set() if entry.substep is None else {"substep", f"{entry.substep.stage}s"}
            )
            found |= {"energy"} if entry.energy != "0" and entry is not FRAME else set()
        return frozenset(found)

    @functools.cached_property
    def own(self) -> Term | None:
        """The term that splittings solve with their drifts or kicks, None where there is none."""
        return own_of(self.terms)

    SEPARABLE: ClassVar[Kind]
    DRIVEN: ClassVar[Kind]
    ROTATING: ClassVar[Kind]
    DAMPED: ClassVar[Kind]
    NONSEPARABLE: ClassVar[Kind]
    FLOW: ClassVar[Kind]
    MAP: ClassVar[Kind]


@functools.cache
def alone(name: str) -> Kind:
    """Return the kind whose equations have one of the TERMS."""
    return Kind(TERMS[name].equations, {name})


Kind.SEPARABLE = Kind("H = T(p) + V(q)")
Kind.DRIVEN = alone("drive")
Kind.ROTATING = alone("frame")
Kind.DAMPED = alone("friction")
Kind.NONSEPARABLE = alone("nonseparable")
Kind.FLOW = alone("rates")
Kind.MAP = alone("iterates")

KINDS = (Kind.SEPARABLE, *map(alone, TERMS))
"""The kinds that the package makes itself; users' models may have others."""

OPTIONS = {option: name for name, entry in TERMS.items() for option in entry.options}
"""The terms by the names of the arguments of `formulas.hamiltonian` and options of commands that make them."""


def own_of(terms: Set[str]) -> Term | None:
    """Return the term that splittings solve with their drifts or kicks, None where there is none."""
    return next((TERMS[name] for name in terms if TERMS[name].substep is not None), None)
