"""Potentials of galpy by their classes, in its natural units."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import ForeignSystem
from ..base.interruption import imported
from ..formulas.grammar import parse
from ..formulas.sympy_bridge import to_sympy
from .galpy_formulas import CUSPED, FORMULAS
from .sums import apart_from, check, parts_of, summed, trial_points


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
