"""Expressions of heyoka: potentials of `hamiltonian`, right-hand sides of `ode`."""

from __future__ import annotations

from typing import Any

from ..core.foreign import ForeignSystem
from ..core.interruption import imported


def expression(given: Any) -> Any:
    """Return a SymPy expression: par[i] is the parameter par_i, the time is t."""
    sympy = imported("sympy", what="an expression of heyoka")
    found = sympy.sympify(imported("heyoka").to_sympy(given))
    names = {entry: sympy.Symbol(entry.name.replace("[", "_").replace("]", "")) for entry in found.free_symbols}
    times = {entry: sympy.Symbol("t") for entry in found.atoms(sympy.Function) if entry.func.__name__ == "heyoka_time"}
    return found.xreplace({**names, **times})


def system(given: Any) -> ForeignSystem:
    """Return the formula of an expression; its coordinates and parameters are the user's."""
    return ForeignSystem(expression(given))
