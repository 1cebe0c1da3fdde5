"""Systems that are sums of parts, each with parameters of its own; a check of a formula against the tool."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..core.interruption import imported
from ..systems.formulas.gammainc import numeric
from ..systems.formulas.sympy_bridge import to_text

SAME = 1e-9
"""Part of the largest energy by which those of another tool may be off."""

POINTS = 12
"""Points at which a formula is compared with the tool that it is from."""


def parts_of(potential: Any, children: Callable[[Any], Iterable[tuple[Any, Any]] | None], name: str = "") -> dict:
    """Return the terms of a sum of potentials, by names; children: those of a sum with keys, None for one term."""
    found = children(potential)
    if found is None:
        return {name: potential}
    every = (parts_of(entry, children, f"{name}_{key}".strip("_")) for key, entry in found)
    return {key: part for parts in every for key, part in parts.items()}


def summed(parts: Mapping[str, tuple[Any, dict[str, float]]]) -> tuple[Any, dict[str, float]]:
    """Return the sum of formulas (SymPy expressions) and the parameters of all of them: PARAMETER_PART where there are
    several parts.
    """
    sympy = imported("sympy", what="a potential of another tool")
    whole: Any = sympy.Integer(0)
    values: dict[str, float] = {}
    for part, (text, own) in parts.items():
        named = {name: name if name == "G" or not part else re.sub(r"\W", "_", f"{name}_{part}") for name in own}
        whole += text.xreplace({s: sympy.Symbol(named.get(s.name, s.name)) for s in text.free_symbols})
        values |= {named[name]: value for name, value in own.items()}
    return whole, values


def check(
    text: Any, dims: str, parameters: Mapping[str, float], points: np.ndarray, energies: Any, note: str = ""
) -> None:
    """Raise ValueError unless a formula has the energies (points,) that the tool itself gives at points (n, points);
    note: a possible reason.
    """
    sympy = imported("sympy", what="a potential of another tool")
    to_text(text)  # refuses functions that no formula has
    with np.errstate(all="ignore"):
        found = sympy.lambdify([*dims, *parameters], text, numeric("numpy"))(
            *points, *map(np.float64, parameters.values())
        )
    off = ~(np.abs(found - energies) <= SAME * np.abs(energies).max())
    if off.any():
        k = int(off.argmax())
        raise ValueError(
            f"text must have the energies of the tool, got {found[k]:.6g} in place of {energies[k]:.6g}{note}. Use "
            "fa.hamiltonian('...') with its formula."
        )


def trial_points(dimensions: int) -> np.ndarray:
    """Return points (dimensions, POINTS) off the axes, from a tenth of a unit to ten units from the origin."""
    random = np.random.default_rng(8)
    direction = random.normal(size=(dimensions, POINTS))
    return direction / np.linalg.norm(direction, axis=0) * np.geomspace(0.1, 10.0, POINTS)


def apart_from(places: Iterable[Sequence[float]], dims: str) -> str | None:
    """Return a text that is positive but at these places, None for no place."""
    squares = (" + ".join(f"({axis} - ({at!r}))**2" for axis, at in zip(dims, place)) for place in places)
    return "*".join(f"({entry})" for entry in dict.fromkeys(squares)) or None
