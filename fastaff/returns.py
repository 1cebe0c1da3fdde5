"""Returns of orbits to a section with their monodromy matrices: what searches for periodic orbits are made of (layer L3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from . import observers
from .boundary import energies, energy_scale
from .engine import Flow
from .kernels import crossings as kernels
from .poincare import SPARE, follow_crossings, start_crossings
from .scalars import fits
from .shown import screen
from .status import Status

COMPLEX_STEP = 1e-100
RANK = 1e-8
"""Singular values below this fraction of the largest count as 0: directions in which a periodic orbit has periodic neighbours."""


class Returns(NamedTuple):
    """Orbits followed to a crossing of a section.

    points (orbits, period, 2n): the crossings in their order; time (orbits,) of the last; monodromy (orbits, 2n, 2n): the derivative
    of the flow over that time; status (orbits,). NaN where the status is not OK.
    """

    points: np.ndarray
    time: np.ndarray
    monodromy: np.ndarray
    status: np.ndarray

    def __repr__(self) -> str:
        return screen(self)


def section_returns(flow: Flow, section: Any, z: np.ndarray, period: int, max_time: float) -> Returns:
    """Follow z (2n, orbits), all on the section, to crossing number `period` with 2n tangent vectors each."""
    rows, orbits = z.shape
    n = rows // 2
    fits("period", orbits, period + SPARE, kernels.RECORD + rows * (1 + rows))
    found = Returns(
        np.full((orbits, period, rows), np.nan), np.full(orbits, np.nan), np.full((orbits, rows, rows), np.nan),
        np.full(orbits, int(Status.NONFINITE)),
    )  # fmt: skip
    with np.errstate(all="ignore"):
        inside = np.isfinite(z).all(axis=0) & (np.broadcast_to(flow.model.margin(*z[:n]), orbits) > 0)
    live = np.flatnonzero(inside)
    if not live.size:
        return found
    flow = replace(flow, vectors=rows)
    unit = np.broadcast_to(np.eye(rows)[:, :, None], (rows, rows, live.size))
    ensemble = flow.ensemble(np.ascontiguousarray(z[:, live]), unit)
    whole = len(ensemble.z)
    width = kernels.RECORD + whole
    observer = observers.crossings(section, period, n, rows)
    memory, out = np.zeros((observer.rows, live.size)), np.full((live.size, (period + SPARE) * width), np.nan)
    start_crossings(flow, memory, section, ensemble, on=True)
    follow_crossings(flow, ensemble, section, period, observer, memory, out, max_time, None)
    records = out.reshape(live.size, -1, width)[:, :period]
    parts = records[:, :, kernels.RECORD :].reshape(live.size, period, 2, 1 + rows, n)
    found.points[live] = parts[:, :, :, 0].reshape(live.size, period, rows)
    found.time[live] = records[:, -1, 0]
    found.monodromy[live] = parts[:, -1, :, 1:].transpose(0, 1, 3, 2).reshape(live.size, rows, rows)
    arrived = np.isfinite(found.monodromy[live]).all(axis=(1, 2)) & (memory[5] >= period)
    ended = np.where(ensemble.status == Status.OK, Status.TOO_FEW_CROSSINGS, ensemble.status)
    found.status[live] = np.where(arrived, Status.OK, ended)
    return found


def vector_field(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dz/dt (orbits, 2n) of Hamilton's equations at z (2n, orbits)."""
    n = model.degrees_of_freedom
    with np.errstate(all="ignore"):
        return np.array([*model.velocity(*z[n:]), *model.force(*z[:n])]).T


def energy_gradient(model: Any, z: np.ndarray) -> np.ndarray:
    """Return grad H (orbits, 2n): Hamilton's equations turned by a right angle."""
    n, field = model.degrees_of_freedom, vector_field(model, z)
    return np.concatenate([-field[:, n:], field[:, :n]], axis=1)


def section_gradient(section: Any, z: np.ndarray) -> np.ndarray:
    """Return the gradient (orbits, 2n) of the section function: complex steps, or differences where the function is not analytic."""
    gradient = np.zeros(z.shape[::-1])
    with np.errstate(all="ignore"):
        for r in range(len(z)):
            h = 6e-6 * (1.0 + np.abs(z[r]))
            difference = (_value(section, z, r, h) - _value(section, z, r, -h)) / (2 * h)
            try:
                exact = np.imag(_value(section, z, r, COMPLEX_STEP * 1j)) / COMPLEX_STEP
            except (TypeError, ValueError):
                exact = difference
            agree = np.abs(exact - difference) <= 1e-4 * (np.abs(difference) + 1e-4)
            gradient[:, r] = np.where(agree, exact, difference)
    return gradient


def _value(section: Any, z: np.ndarray, row: int, shift: Any) -> np.ndarray:
    """Return the section function at z with one row shifted, one number for each orbit."""
    rows = [z[r] + shift if r == row else z[r] for r in range(len(z))]
    return section.value(*rows) + np.zeros(z.shape[1])


@np.errstate(all="ignore")
def onto(model: Any, section: Any, z: np.ndarray, energy: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Move z (2n, orbits) the shortest way to the section, and to the energy (orbits,) unless None; return it and which arrived."""
    z = z.copy()
    zero = np.zeros(z.shape[1])
    for _ in range(20):
        values, rows = [section.value(*z) + zero], [section_gradient(section, z)]
        sizes = [1.0 + (z * z).sum(axis=0)]
        if energy is not None:
            values.append(energies(model, z) - energy)
            rows.append(energy_gradient(model, z))
            sizes.append(energy_scale(model, z))
        short = np.array(values)
        with np.errstate(all="ignore"):
            near = (np.abs(short) <= 4e-15 * np.array(sizes)).all(axis=0)
            change = least_change(np.stack(rows, axis=1), short.T)
        z = np.where(near, z, z - change.T)
        if (near | ~np.isfinite(z).all(axis=0)).all():
            break
    with np.errstate(all="ignore"):
        arrived = np.isfinite(z).all(axis=0) & (np.abs(short) <= 1e-13 * np.array(sizes)).all(axis=0)
    return np.where(arrived, z, np.nan), arrived


def least_change(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the shortest x (k, columns) with the least |matrix x - right| of matrix (k, rows, columns); NaN where not finite."""
    x = np.full((len(matrix), matrix.shape[2]), np.nan)
    good = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    if good.any():
        inverse = np.linalg.pinv(matrix[good], rcond=RANK)
        x[good] = (inverse @ right[good, :, None])[..., 0]
    return x


def reduced_monodromy(model: Any, section: Any, z: np.ndarray, monodromy: np.ndarray) -> np.ndarray:
    """Return the derivative (orbits, 2n - 2, 2n - 2) of the section map within the energy surface at fixed points z (2n, orbits).

    In an orthonormal basis of the plane of both; the flow takes each image back to the section.
    """
    field, along, up = vector_field(model, z), section_gradient(section, z), energy_gradient(model, z)
    reduced = np.full((len(monodromy), len(z) - 2, len(z) - 2), np.nan)
    good = np.isfinite(monodromy).all(axis=(1, 2))
    if good.any():
        _, _, rows = np.linalg.svd(np.stack([along, up], axis=1)[good], full_matrices=True)
        basis, M, f, s = rows[:, 2:], monodromy[good], field[good], along[good]
        delay = (s[:, None] @ M) / (s * f).sum(axis=1)[:, None, None]
        reduced[good] = basis @ (M - f[:, :, None] * delay) @ basis.transpose(0, 2, 1)
    return reduced


def each(function: Callable, stack: np.ndarray, shape: tuple[int, ...], dtype: type) -> np.ndarray:
    """Return function(matrix) of each matrix of a stack, NaN where it is not finite."""
    result: np.ndarray = np.full((len(stack), *shape), np.nan, dtype)
    for k in np.flatnonzero(np.isfinite(stack).all(axis=(1, 2))):
        result[k] = function(stack[k])
    return result
