"""Objects of other tools: which module of `fastaff.exchange` reads them.

The package of its class, which the user has imported, identifies an object. Nothing else of that package is imported
here, and an adapter is loaded when one of its objects is met.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from .interruption import imported

ADAPTERS: Mapping[str, str] = {
    "astropy": "quantities",
    "at": "from_at",
    "gala": "from_gala",
    "galpy": "from_galpy",
    "heyoka": "from_heyoka",
    "pandas": "frames",
    "pathlib": "mad",
    "polars": "frames",
    "rebound": "from_rebound",
    "scipy": "from_scipy",
    "xtrack": "lattices",
}
"""Package: module of `fastaff.exchange`; a path is a file of MAD."""


class Foreign(NamedTuple):
    """Orbits of another tool as plain arrays.

    rows: an array (2n, orbits, samples), or named arrays (orbits, samples); times (samples,), None where they are
    unknown; names (2n,) of the rows q1, ..., qn, p1, ..., pn.
    """

    rows: Any
    times: Any
    names: tuple[str, ...] | None


class ForeignSystem(NamedTuple):
    """A system of another tool as a formula.

    text: V as a SymPy expression of the coordinates, () where the user names them; parameters: their values by name;
    domain: an expression that is positive except at the singular points of V, None where V has none; rotation: rate at
    which the frame turns, None where it is at rest.
    """

    text: Any
    coordinates: tuple[str, ...] = ()
    parameters: Mapping[str, float] = MappingProxyType({})
    domain: str | None = None
    rotation: float | None = None


def adapter(value: Any) -> Any:
    """Return the module that reads an object of another tool; None for everything else."""
    for cls in type(value).__mro__[:-1]:
        name = ADAPTERS.get(f"{cls.__module__}".partition(".")[0])
        if name is not None:
            return imported(f"..exchange.{name}", __package__)
    return None


def dispatch_adapter(part: str, value: Any, *given: Any) -> Any:
    """Return the result of function `part` of a value's adapter, or of that of the first of a list of systems; None
    where there is none.
    """
    one = value[0] if part == "system" and isinstance(value, list) and value else value
    reads = getattr(adapter(one), part, None)
    return None if reads is None else reads(value, *given)


def call_for(value: Any) -> str:
    """Return the call that makes a model of a system of another tool, as a hint; empty for anything else."""
    tool = adapter(value)
    for part, call in (("lattice", "iterated_map(lattice)"), ("system", "hamiltonian(potential)")):
        if hasattr(tool, part):
            return f". Use fa.{call}."
    return ""


def without_unit(value: Any) -> Any:
    """Return a Quantity as numbers in the units of `exchange.quantities`, anything else as it is."""
    found = dispatch_adapter("plain", value) if hasattr(value, "unit") else None
    return value if found is None else found
