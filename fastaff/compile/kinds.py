"""Kinds of motion: the equations of a system in words, and the terms that loops, analyses and refusals go by."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from typing import Any, ClassVar

TERMS = {
    "drive": "V depends on the time, which is the last coordinate: `period`, phase(t)",
    "frame": "the frame of the first two coordinates turns: angular_velocity()",
    "friction": "momenta are damped in proportion to themselves: damping_rate()",
    "nonseparable": "H of coordinates and momenta together: energy(z...), rates(z...), tangent_rates(z..., dz...)",
    "rates": "variables instead of coordinates with momenta: rates(z...)",
    "iterates": "whole numbers of iterates instead of a time: iterate(z...), periods()",
}
"""Terms that equations have beside H = T(p) + V(q), and the methods that a model then has."""


@dataclass(frozen=True)
class Kind:
    """The equations of a model in words, and those of TERMS that they have. A model without `kind` is SEPARABLE."""

    equations: str
    terms: Set[str] = frozenset()

    def __post_init__(self) -> None:
        terms = frozenset(self.terms)
        others = terms - {"drive"}
        if others - TERMS.keys() or len(others) > 1 or (others != terms and others & {"rates", "iterates"}):
            allowed = f"one of {', '.join(TERMS)}, or drive with frame, friction or nonseparable"
            raise ValueError(f"terms must be {allowed}, got {', '.join(sorted(terms))}")
        object.__setattr__(self, "terms", terms)

    SEPARABLE: ClassVar[Kind]
    DRIVEN: ClassVar[Kind]
    ROTATING: ClassVar[Kind]
    DAMPED: ClassVar[Kind]
    NONSEPARABLE: ClassVar[Kind]
    FLOW: ClassVar[Kind]
    MAP: ClassVar[Kind]


Kind.SEPARABLE = Kind("H = T(p) + V(q)")
Kind.ROTATING = Kind("H = T(p) + V(q) in a rotating frame or a uniform magnetic field", {"frame"})
Kind.DRIVEN = Kind("H = T(p) + V(q, t) with a period in t", {"drive"})
Kind.DAMPED = Kind("H = T(p) + V(q) with a friction in proportion to the momenta", {"friction"})
Kind.NONSEPARABLE = Kind("H(q, p)", {"nonseparable"})
Kind.MAP = Kind("z -> M(z)", {"iterates"})
Kind.FLOW = Kind("dz/dt = f(z)", {"rates"})

KINDS = (Kind.SEPARABLE, Kind.ROTATING, Kind.DRIVEN, Kind.DAMPED, Kind.NONSEPARABLE, Kind.MAP, Kind.FLOW)
"""The kinds that the package makes itself; models of one's own may have others."""


def term(name: str) -> Any:
    """Return a property: whether equations have that one of the TERMS, by the `terms` of its owner."""
    return property(lambda owner: name in owner.terms, doc=TERMS[name])


def terms_of(value: Any) -> Set[str]:
    """Return the terms of a value's equations, by its kind; none where it has no `Kind`, as a section."""
    return getattr(getattr(value, "kind", None), "terms", frozenset())


def winding_of(value: Any) -> tuple[bool, ...]:
    """Return which rows (2n,) of a map have a period; none of what is no map."""
    return tuple(period > 0 for period in value.periods()) if "iterates" in terms_of(value) else ()
