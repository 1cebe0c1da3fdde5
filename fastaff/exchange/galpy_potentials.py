"""Potentials of galpy by their classes, in its natural units: textbook formulas in x, y, z and the amplitude.

:Source: Binney & Tremaine 2008, Galactic Dynamics, chapter 2; Dehnen 1993, MNRAS 265, 250; Dejonghe & de Zeeuw 1988,
    ApJ 333, 90 (Kuzmin & Kutuzov); Evans 1994, MNRAS 267, 333 (power laws); Henon & Heiles 1964, Astron. J. 69, 73;
    Bovy 2015, ApJS 216, 29 (the cut-off of MWPotential2014).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..base.foreign import ForeignSystem
from ..base.interruption import imported
from ..formulas.grammar import parse
from ..formulas.sympy_bridge import to_sympy
from .sums import apart_from, check, parts_of, summed, trial_points

R2 = "(x**2 + y**2)"
SQUARE = "(x**2 + y**2 + z**2)"
R = f"sqrt{SQUARE}"


def _cut_off(potential: Any) -> str:
    """Return the formula of a density r^-alpha exp(-r^2/rc^2), with the number alpha in it."""
    alpha = float(potential.alpha)
    if alpha >= 2:
        raise ValueError(f"text: alpha of a PowerSphericalPotentialwCutoff must be below 2, got {alpha!r}")
    a, b = 1 - alpha / 2, 1.5 - alpha / 2
    inside = f"{math.gamma(b)!r}*gammainc({b!r}, {SQUARE}/rc**2)/{R}"
    return f"2*pi*amp*rc**{3 - alpha!r}*({math.gamma(a)!r}*gammainc({a!r}, {SQUARE}/rc**2)/rc - {inside})"


FORMULAS: dict[str, tuple[str | Callable[[Any], str], dict[str, str]]] = {
    "DehnenCoreSphericalPotential": (f"-amp*(1 - (1 + a/{R})**(-2))/(6*a)", {"a": "a"}),
    "DehnenSphericalPotential": (
        f"-amp*(1 - (1 + a/{R})**(alpha - 2))/(a*(2 - alpha)*(3 - alpha))",
        {"a": "a", "alpha": "alpha"},
    ),
    "FlattenedPowerPotential": (
        f"-amp*({R2} + z**2/q2 + core2)**(-alpha/2)/alpha",
        {"q2": "q2", "core2": "core2", "alpha": "alpha"},
    ),
    "HenonHeilesPotential": ("amp*((x**2 + y**2)/2 + x**2*y - y**3/3)", {}),
    "HernquistPotential": (f"-amp/(2*(a + {R}))", {"a": "a"}),
    "IsochronePotential": (f"-amp/(b + sqrt(b**2 + {SQUARE}))", {"b": "b"}),
    "JaffePotential": (f"-amp*log(1 + a/{R})/a", {"a": "a"}),
    "KeplerPotential": (f"-amp/{R}", {}),
    "KuzminKutuzovStaeckelPotential": (
        f"-amp/sqrt({SQUARE} - alpha - gamma + 2*sqrt(alpha*gamma - gamma*{R2} - alpha*z**2))",
        {"alpha": "_alpha", "gamma": "_gamma"},
    ),
    "LogarithmicHaloPotential": (
        "amp/2*log(x**2 + y**2/b**2 + z**2/q**2 + core2)",
        {"b": "_b", "q": "_q", "core2": "_core2"},
    ),
    "MiyamotoNagaiPotential": (f"-amp/sqrt({R2} + (a + sqrt(z**2 + b**2))**2)", {"a": "_a", "b": "_b"}),
    "NFWPotential": (f"-amp*log(1 + {R}/a)/{R}", {"a": "a"}),
    "PlummerPotential": (f"-amp/sqrt({SQUARE} + b**2)", {"b": "_b"}),
    "PowerSphericalPotential": (f"amp*{R}**(2 - alpha)/(2 - alpha)", {"alpha": "alpha"}),
    "PowerSphericalPotentialwCutoff": (_cut_off, {"rc": "rc"}),
    "PseudoIsothermalPotential": (f"amp*(log(1 + {SQUARE}/a**2)/2 + a*atan({R}/a)/{R})/a", {"a": "_a"}),
}
"""Formula, or the function that writes that of a potential, and the attributes of all parameters but the amplitude; a
parameter of None is 1.
"""

CUSPED = ("NFWPotential", "PowerSphericalPotentialwCutoff", "PseudoIsothermalPotential")
"""Those whose formulas divide by zero at the centre, where they are finite."""


def system(potential: Any) -> ForeignSystem:
    """Return the formula of a potential of `FORMULAS`, or of a sum or list of them."""
    every = potential if isinstance(potential, list) else [potential]
    for entry in every:
        if not hasattr(entry, "dim") or callable(entry.dim) or entry.dim != every[0].dim:
            raise TypeError(f"text must be a potential of galpy, or some of one dimension, got {type(entry).__name__}")
    dims = "xyz"[: every[0].dim]
    parts = parts_of(potential, _children)
    text, parameters = summed({key: _part(part, dims) for key, part in parts.items()})
    cusp = [(0.0,) * len(dims)] * any(type(part).__name__ in CUSPED for part in parts.values())
    points = trial_points(len(dims))
    R, phi = np.hypot(*points[:2]), np.arctan2(points[1], points[0])
    place = (R, points[2]) if len(dims) == 3 else (R,)
    energies = [sum(entry(*at, phi=angle, use_physical=False) for entry in every) for *at, angle in zip(*place, phi)]
    check(text, dims, parameters, points, np.array(energies, dtype=float))
    return ForeignSystem(
        text=text,
        coordinates=tuple(dims),
        parameters=parameters,
        domain=apart_from(cusp, dims),
    )


def _children(potential: Any) -> Any:
    listed = potential if isinstance(potential, list) else getattr(potential, "_potlist", None)
    return None if listed is None else enumerate(listed, 1)


def _part(potential: Any, dims: str) -> tuple[Any, dict[str, float]]:
    """Return the formula of one potential and its parameters."""
    kind = type(potential).__name__
    if kind not in FORMULAS or not 2 <= len(dims) <= 3:
        raise ValueError(
            f"text: no formula of galpy's {kind} is known, only of {', '.join(FORMULAS)}: write one, "
            "fa.hamiltonian('...'), or integrate in galpy and give the Orbit to fa.orbit_frequencies"
        )
    sympy = imported("sympy", what="a potential of galpy")
    written, fields = FORMULAS[kind]
    text = written if isinstance(written, str) else written(potential)
    found = {name: getattr(potential, field) for name, field in {"amp": "_amp", **fields}.items()}
    values = {name: 1.0 if value is None else float(value) for name, value in found.items()}
    symbols = {name: sympy.Symbol(name) for name in (*dims, *values)}
    return to_sympy(parse(text, tuple(dims), tuple(values)), symbols), values
