"""Potentials of gala by their symbolic form, in kpc, Myr and solar masses, or without units as they are."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.interruption import imported
from ..core.numbers import listed
from ..systems.formulas.gammainc import gammainc
from .quantities import plain


def children(potential: Any) -> Any:
    """Return the parts of a sum of potentials by name; None for a single one."""
    if hasattr(potential, "get_three_potentials"):  # an exponential disk
        potential = potential.get_three_potentials()
    return potential.items() if hasattr(potential, "items") else None


def formula_of(potential: Any, dims: str) -> tuple[Any, dict[str, float]]:
    """Return the formula of one potential and its parameters."""
    sympy = imported("sympy", what="a potential of gala")
    try:
        text, variables, symbols = potential.to_sympy()
    except NotImplementedError:
        kind = type(potential).__name__
        raise ValueError(f"text: gala has no formula of a {kind}; write one, fa.hamiltonian('...')") from None
    if set(variables) != set(dims):
        raise ValueError(
            f"text must be a potential in {listed(dims)}, got a formula in {listed(variables)}. Use "
            "fa.hamiltonian('...') with its formula."
        )
    place = [sympy.Symbol(axis) - at for axis, at in zip(dims, origin(potential))]
    if potential.R is not None:
        place = [sum(float(c) * entry for c, entry in zip(row, place)) for row in np.asarray(potential.R)]
    text = text.subs({variables[entry]: place[k] for k, entry in enumerate(dims)}, simultaneous=True)
    G = imported("astropy.constants").G if has_units(potential) else potential.G
    values = {"G": plain(G)} | {k: plain(v) for k, v in potential.parameters.items()}
    text = text.replace(sympy.lowergamma, lambda a, x: sympy.gamma(a) * gammainc()(a, x))
    firsts = {symbol.name for entry in text.atoms(gammainc()) for symbol in entry.args[0].free_symbols}
    text = text.xreplace({symbols[name]: sympy.Rational(repr(float(values[name]))) for name in firsts})
    return text, {key: float(values[key]) for key, symbol in symbols.items() if text.has(symbol)}


def left_out(parts: dict[str, Any]) -> str:
    """Return a note of the parameters that are not in gala's formulas of these potentials; empty if there is none."""
    found = []
    for potential in parts.values():
        text, _, symbols = potential.to_sympy()
        found += [
            f"{name} = {float(plain(value)):.6g} of its {type(potential).__name__}"
            for name, value in potential.parameters.items()
            if name not in symbols or not text.has(symbols[name])
        ]
    return f" (gala's formula leaves out {', '.join(found)})" if found else ""


def origin(potential: Any) -> list[float]:
    """Return the centre of a potential."""
    return [float(plain(at)) for at in np.atleast_1d(potential.origin)]


def has_units(potential: Any) -> bool:
    """Return whether a potential has units."""
    return not type(potential.units).__name__.startswith("Dimensionless")


CUSPED = ("NFWPotential", "PowerLawCutoffPotential", "StonePotential")
"""Those whose formulas divide by zero at the centre, where they are finite."""
