"""Potentials of gala by their symbolic form, in kpc, Myr and solar masses, or without units as they are."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import ForeignSystem
from .gala_formulas import children, formula_of, has_units, left_out, origin
from .quantities import plain
from .sums import apart_from, check, parts_of, summed, trial_points

CUSPED = ("NFWPotential", "PowerLawCutoffPotential", "StonePotential")
"""Those whose formulas divide by zero at the centre, where they are finite."""


def system(given: Any) -> ForeignSystem:
    """Return the formula of a potential that gala has in symbols, a sum of these, or a Hamiltonian with one."""
    frame, potential = getattr(given, "frame", None), getattr(given, "potential", given)
    if not hasattr(potential, "to_sympy"):
        raise TypeError(f"text must be a gala potential or Hamiltonian, got {type(given).__name__}")
    dims, parts = "xyz"[: potential.ndim], parts_of(potential, children)
    text, parameters = summed({key: formula_of(part, dims) for key, part in parts.items()})
    cusps = [origin(part) for part in parts.values() if type(part).__name__ in CUSPED]
    rotation = None
    if frame is not None and "Omega" in frame.parameters:
        rates = np.atleast_1d(plain(frame.parameters["Omega"]))
        if rates[:-1].any():
            raise ValueError(f"text: a frame must turn about z, this one has Omega = {rates}")
        rotation = float(rates[-1])
    points = trial_points(len(dims))
    at = points * potential.units["length"] if has_units(potential) else points
    check(text, dims, parameters, plain(at), plain(potential.energy(at)), left_out(parts))
    return ForeignSystem(
        text=text,
        coordinates=tuple(dims),
        parameters=parameters,
        domain=apart_from(cusps, dims),
        rotation=rotation,
    )
