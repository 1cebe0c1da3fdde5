"""Quantities of Astropy as numbers, in one system of units: kpc, Myr, solar masses, radians; and its tables."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.foreign import Foreign
from ..core.interruption import imported
from .frames import orbits as of_table

BASES = ("kpc", "Myr", "solMass", "rad")
"""Units of the numbers that Quantities become: those of gala's `galactic`."""


UNITS = {"time": "Myr", "energy": "kpc2 Myr-2", "action": "kpc2 Myr-1"}


def units(value: Any) -> dict[str, str] | None:
    """Return the meaning of the words for units in results, in the units of `BASES`, energies and actions for a unit of
    mass; None for values without a physical unit.
    """
    kind = getattr(getattr(value, "unit", None), "physical_type", "dimensionless")
    return None if kind == "dimensionless" else UNITS


def plain(value: Any) -> Any:
    """Return a Quantity as a number or array in the units of `BASES`; return other values as they are."""
    if not hasattr(value, "unit") or not hasattr(value, "decompose"):
        return value
    units = imported("astropy.units")
    return np.asarray(value.decompose([getattr(units, name) for name in BASES]).value)[()]


def orbits(value: Any, name: str, coordinates: tuple[str, ...] | None) -> Foreign | None:
    """Return the orbits of a table, or of an array that has one unit for all rows; None for other values."""
    if hasattr(value, "colnames"):
        return of_table({entry: plain(value[entry]) for entry in value.colnames}, name, coordinates)
    return Foreign(plain(value), None, None) if hasattr(value, "unit") else None
