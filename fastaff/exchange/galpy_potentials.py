"""Potentials of galpy by their classes, in its natural units: textbook formulas in x, y, z and the amplitude.

:Source: Binney & Tremaine 2008, Galactic Dynamics, chapter 2; Dehnen 1993, MNRAS 265, 250; Dejonghe & de Zeeuw 1988,
    ApJ 333, 90 (Kuzmin & Kutuzov); Evans 1994, MNRAS 267, 333 (power laws); Henon & Heiles 1964, Astron. J. 69, 73;
    Bovy 2015, ApJS 216, 29 (the cut-off of MWPotential2014).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ..core.interruption import imported
from ..core.numbers import listed, shown
from ..systems.formulas.grammar import parse
from ..systems.formulas.sympy_bridge import to_sympy

R2 = "(x**2 + y**2)"
SQUARE = "(x**2 + y**2 + z**2)"
R = f"sqrt{SQUARE}"


def _cut_off(potential: Any) -> str:
    """Return the formula of a density r^-alpha exp(-r^2/rc^2), with the number alpha in it."""
    alpha = float(potential.alpha)
    if alpha >= 2:
        raise ValueError(f"text: alpha of a PowerSphericalPotentialwCutoff must be below 2, got {shown(alpha)}")
    a = 1 - alpha / 2
    b = 1.5 - alpha / 2
    inside = f"{math.gamma(b)!r}*gammainc({b!r}, {SQUARE}/rc**2)/{R}"
    return f"2*pi*amp*rc**{3 - alpha!r}*({math.gamma(a)!r}*gammainc({a!r}, {SQUARE}/rc**2)/rc - {inside})"


FORMULAS: dict[str, tuple[str | Callable[[Any], str], str]] = {
    "DehnenCoreSphericalPotential": (f"-amp*(1 - (1 + a/{R})**(-2))/(6*a)", "a"),
    "DehnenSphericalPotential": (f"-amp*(1 - (1 + a/{R})**(alpha - 2))/(a*(2 - alpha)*(3 - alpha))", "a alpha"),
    "FlattenedPowerPotential": (f"-amp*({R2} + z**2/q2 + core2)**(-alpha/2)/alpha", "q2 core2 alpha"),
    "HenonHeilesPotential": ("amp*((x**2 + y**2)/2 + x**2*y - y**3/3)", ""),
    "HernquistPotential": (f"-amp/(2*(a + {R}))", "a"),
    "IsochronePotential": (f"-amp/(b + sqrt(b**2 + {SQUARE}))", "b"),
    "JaffePotential": (f"-amp*log(1 + a/{R})/a", "a"),
    "KeplerPotential": (f"-amp/{R}", ""),
    "KuzminKutuzovStaeckelPotential": (
        f"-amp/sqrt({SQUARE} - alpha - gamma + 2*sqrt(alpha*gamma - gamma*{R2} - alpha*z**2))",
        "alpha gamma",
    ),
    "LogarithmicHaloPotential": ("amp/2*log(x**2 + y**2/b**2 + z**2/q**2 + core2)", "b q core2"),
    "MiyamotoNagaiPotential": (f"-amp/sqrt({R2} + (a + sqrt(z**2 + b**2))**2)", "a b"),
    "NFWPotential": (f"-amp*log(1 + {R}/a)/{R}", "a"),
    "PlummerPotential": (f"-amp/sqrt({SQUARE} + b**2)", "b"),
    "PowerSphericalPotential": (f"amp*{R}**(2 - alpha)/(2 - alpha)", "alpha"),
    "PowerSphericalPotentialwCutoff": (_cut_off, "rc"),
    "PseudoIsothermalPotential": (f"amp*(log(1 + {SQUARE}/a**2)/2 + a*atan({R}/a)/{R})/a", "a"),
}
"""Formula, or the function that writes that of a potential, and its parameters beside the amplitude: attributes of that
name or with a line before it; one of None is 1.
"""

CUSPED = ("NFWPotential", "PowerSphericalPotentialwCutoff", "PseudoIsothermalPotential")
"""Those whose formulas divide by zero at the centre, where they are finite."""


def formula_of(potential: Any, dims: str) -> tuple[Any, dict[str, float]]:
    """Return the formula of one potential and its parameters."""
    kind = type(potential).__name__
    if kind not in FORMULAS or not 2 <= len(dims) <= 3:
        raise ValueError(
            f"text must be one of {listed(FORMULAS)} of galpy, got {kind}. Use fa.orbit_frequencies with an Orbit of "
            "galpy."
        )
    sympy = imported("sympy", what="a potential of galpy")
    written, names = FORMULAS[kind]
    text = written if isinstance(written, str) else written(potential)
    values = {}
    for name in ("amp", *names.split()):
        value = getattr(potential, name if hasattr(potential, name) else f"_{name}")
        values[name] = 1.0 if value is None else float(value)
    symbols = {name: sympy.Symbol(name) for name in (*dims, *values)}
    return to_sympy(parse(text, tuple(dims), tuple(values)), symbols), values
