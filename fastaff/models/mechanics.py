"""What a model says of phase points: velocities, forces, energies. The one place that knows a model's `Kind`.

A map has no energy: it is 0, as its kinetic energy is, so that nothing drifts.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .contracts import Kind, kind_of


def velocities(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dq/dt (n, ...) at phase points z (2n, ...)."""
    return _rows(model.velocity(*z[model.degrees_of_freedom :]), z)


def forces(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dp/dt (n, ...) at phase points z (2n, ...)."""
    return _rows(model.force(*z[: model.degrees_of_freedom]), z)


def slopes(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dz/dt (2n, ...) at phase points z (2n, ...): velocities and forces."""
    with np.errstate(all="ignore"):
        return np.concatenate([velocities(model, z), forces(model, z)])


def kinetic_energies(model: Any, z: np.ndarray) -> np.ndarray:
    """Return the kinetic energy, the scale of energy errors, of phase points z (2n, ...)."""
    if kind_of(model) is Kind.MAP:
        return _full(0.0, z)
    with np.errstate(all="ignore"):
        return _full(model.kinetic_energy(*z[model.degrees_of_freedom :]), z)


def potential_energies(model: Any, z: np.ndarray) -> np.ndarray:
    """Return what is left of the energy beside the kinetic one, of phase points z (2n, ...)."""
    if kind_of(model) is Kind.MAP:
        return _full(0.0, z)
    with np.errstate(all="ignore"):
        return _full(model.potential_energy(*z[: model.degrees_of_freedom]), z)


def energies(model: Any, z: np.ndarray) -> np.ndarray:
    """Return the energy of phase points z (2n, ...); NaN outside the potential's domain."""
    with np.errstate(all="ignore"):
        return kinetic_energies(model, z) + potential_energies(model, z)


def inside(model: Any, z: np.ndarray) -> np.ndarray:
    """Tell which phase points z (2n, ...) lie where the potential lives."""
    with np.errstate(all="ignore"):
        return _full(model.margin(*z[: model.degrees_of_freedom]), z) > 0


def _full(number: Any, z: np.ndarray) -> np.ndarray:
    """Return what a method gave of phase points z, perhaps one number for all, as a fresh array (...)."""
    result = np.empty(z.shape[1:])
    result[...] = number
    return result


def _rows(numbers: Any, z: np.ndarray) -> np.ndarray:
    """Return rows that a method gave of phase points z as an array (n, ...)."""
    rows = np.empty((z.shape[0] // 2, *z.shape[1:]))
    for row, number in zip(rows, numbers, strict=True):
        row[...] = number
    return rows
