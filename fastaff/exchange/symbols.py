"""Equations of motion of a model that is a formula, in symbols of SymPy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..core.interruption import imported
from ..engine.kinds import OPTIONS, TERMS
from ..engine.terms import Term
from ..systems.formulas.drive import TIME
from ..systems.formulas.library import Request
from ..systems.formulas.sympy_bridge import to_sympy

MOST = 8000
"""Characters of a formula, at most."""


def equations(request: Request, fields: tuple[str, ...]) -> tuple[list[str], list[Any]]:
    """Return the names of the rows and the right-hand sides, in the symbols z[i], c[i] and t."""
    sympy = imported("sympy", what="the source text of a model")
    names = {name: sympy.Symbol(f"c[{i}]") for i, name in enumerate(fields)}
    coordinates = [name for name in request.coordinates if request.period is None or name != TIME]
    n = len(coordinates)
    momenta = request.momenta or [f"p_{name}" for name in coordinates]
    q, p = ([sympy.Symbol(f"z[{i}]") for i in part] for part in (range(n), range(n, 2 * n)))
    names |= dict(zip((*coordinates, *request.momenta), (*q, *p)))
    names |= {} if request.period is None else {TIME: sympy.Symbol("t")}
    if request.inertia == "ode":
        return coordinates, [to_sympy(program, names) for program in request.programs(MOST)]
    H, rates = energy(request, names, q, p)
    v = [H.diff(p_i) for p_i in p]
    f = [-H.diff(q_i) for q_i in q]
    for term, rate in rates.items():
        v = term.added("v", rate, q, p, v)
        f = term.added("f", rate, q, p, f)
    return [*coordinates, *momenta], [*v, *f]


def energy(request: Request, names: Mapping[str, Any], q: list[Any], p: list[Any]) -> tuple[Any, dict[Term, Any]]:
    """Return H of a formula in these symbols, without the terms beside T and V, and the rate of each of these."""
    masses = [names.get(f"m_{i + 1}", 1) for i in range(len(q))]
    H = to_sympy(request.program(MOST), names)
    rates = {}
    if not request.momenta:
        H += sum(p_i**2 / (2 * m) for p_i, m in zip(p, masses))
    options = {name: to_sympy(program, names) for name, program in request.option_programs().items()}
    for term in {TERMS[OPTIONS[name]] for name in options}:
        rates[term], V = term.of_options(options, masses[0], q)
        H += V
    return H, rates
