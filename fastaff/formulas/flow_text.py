"""Autonomous systems of ordinary differential equations written as text: x' = s*(y - x); y' = ..."""

from __future__ import annotations

import re
from typing import Any

from ..base.numbers import real
from .equations import split
from .grammar import checked_name
from .library import RESERVED, Request, generated_class


def flow(text: Any, /, *, domain: str | None = None, **parameters: float) -> Any:
    """Make an autonomous system dz/dt = f(z) of equations written as text, with exact derivatives.

    Parameters: text: one equation for each variable, x' = ... or dx/dt = ..., with semicolons or line breaks between
    them, 1 to 16 variables, the right-hand sides in the grammar of `formula`; domain: a formula that is positive where
    the system lives; parameters: each by its name, floats. Returns a model with the parameters as its fields, the
    methods rates(z...) and tangent_rates(z..., dz...), and the names of its variables, in the order of the equations,
    as `coordinates`: z0 and all states have so many rows. Raises ValueError or TypeError for what is no system of
    equations (nothing is ever executed), or a name without a value or a value without use; ImportError where a new text
    finds no SymPy.

    Runge-Kutta schemes run it (DOP853 where none is given; VERNER9, or RK4 with a step), in `integrate`,
    `poincare_map` (sections x=c and Linear), `tangent_map` and `chaos_map` with indicators of tangent vectors. There is
    no energy: energy_error is 0, and what a system conserves is for the user to check. Parameters stay run-time values.
    Cost: a state of an odd number of variables takes the memory of one more.
    Source: Lorenz 1963, J. Atmos. Sci. 20, 130, for one; Meurer et al. 2017, PeerJ Comput. Sci. 3, e103 (SymPy).
    """
    equations = split(text)
    names: list[str] = []
    for name, _ in equations:
        names.append(checked_name(name, "variable", {*names, *RESERVED}))
    values = {
        checked_name(name, "parameter", {*names, *RESERVED}): real(name, value) for name, value in parameters.items()
    }
    for name, side in equations:
        if re.search(r"\bt\b", side) and "t" not in (*names, *values):
            raise ValueError(f"text: {name}' depends on t, which a flow does not know: make it a variable, t' = 1")
    request = Request(text, domain, tuple(values), tuple(names), "flow")
    programs = request.programs(2000)
    domain_program = request.domain_program()
    used = frozenset().union(*(p.names for p in (*programs, domain_program) if p is not None))
    unused = [name for name in values if name not in used]
    if unused:
        raise ValueError(
            f"parameter {unused[0]!r} is not used by the equations {text!r}: leave it out, or is a name misspelt?"
        )
    return generated_class(request, (programs, domain_program), values)(*values.values())
