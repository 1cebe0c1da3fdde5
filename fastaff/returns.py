"""Returns of orbits to a section with their monodromy matrices: what searches for periodic orbits are made of (layer L3).

All that mixes coordinates and momenta is done in an orbit's own units, `orbit_scale`: results are the same in any unit of length,
time and mass, for any origin and zero of the potential, and know nothing of other orbits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from . import observers
from .boundary import energies
from .engine import Flow
from .kernels import crossings as kernels
from .poincare import SPARE, follow_crossings, start_crossings
from .status import Status

COMPLEX_STEP = 1e-100
RANK = 1e-8
"""Singular values below this fraction of the largest count as 0: directions in which a periodic orbit has periodic neighbours."""

FIRST_STEP = 0.2
"""The step that is tried first, beside 1/rate of the orbit."""

FINEST, LONGEST_JUMP = 14, 6
"""Powers of sqrt(2) that a step may be finer than the first, and by which it changes at once."""

WAIT = 20
"""Turns at an orbit's rate to wait for a crossing."""


class Returns(NamedTuple):
    """Orbits followed to a crossing of a section.

    points (orbits, period, 2n): the crossings in their order; time (orbits,) of the last; monodromy (orbits, 2n, 2n): the derivative
    of the flow over that time; status (orbits,). NaN where the status is not OK.
    """

    points: np.ndarray
    time: np.ndarray
    monodromy: np.ndarray
    status: np.ndarray


def section_returns(flow: Flow, section: Any, z: np.ndarray, period: int, max_time: Any, step: np.ndarray) -> Returns:
    """Follow z (2n, orbits), all on the section, to crossing number `period` with 2n tangent vectors each.

    max_time, step: (orbits,), those of each orbit; orbits of one step run together.
    """
    rows, orbits = z.shape
    n = rows // 2
    found = Returns(
        np.full((orbits, period, rows), np.nan), np.full(orbits, np.nan), np.full((orbits, rows, rows), np.nan),
        np.full(orbits, int(Status.NONFINITE)),
    )  # fmt: skip
    with np.errstate(all="ignore"):
        inside = np.isfinite(z).all(axis=0) & (np.broadcast_to(flow.model.margin(*z[:n]), orbits) > 0)
    limit = np.broadcast_to(max_time, orbits)
    for size in np.unique(step[inside]):
        live = np.flatnonzero(inside & (step == size))
        some = _returns(replace(flow, step=float(size)), section, z[:, live], period, float(limit[live].max()))
        late = (some.status == Status.OK) & (some.time > limit[live])
        some.status[late] = Status.TOO_FEW_CROSSINGS
        for whole, part in zip(found, some, strict=True):
            if part.ndim > 1 or part.dtype == np.float64:
                part[late] = np.nan
            whole[live] = part
    return found


def _returns(flow: Flow, section: Any, z: np.ndarray, period: int, max_time: float) -> Returns:
    """Follow orbits of one step."""
    rows, orbits = z.shape
    flow = replace(flow, vectors=rows)
    unit = np.broadcast_to(np.eye(rows)[:, :, None], (rows, rows, orbits))
    ensemble = flow.ensemble(np.ascontiguousarray(z), unit)
    whole = len(ensemble.z)
    width = kernels.RECORD + whole
    observer = observers.crossings(section, period, rows // 2, rows)
    memory, out = np.zeros((observer.rows, orbits)), np.full((orbits, (period + SPARE) * width), np.nan)
    start_crossings(memory, section, ensemble)
    memory[1] = 0.0  # on the section, whatever its units
    follow_crossings(flow, ensemble, section, period, observer, memory, out, max_time, None)
    records = out.reshape(orbits, -1, width)[:, :period]
    parts = records[:, :, kernels.RECORD :].reshape(orbits, period, 2, 1 + rows, rows // 2)
    monodromy = parts[:, -1, :, 1:].transpose(0, 1, 3, 2).reshape(orbits, rows, rows)
    arrived = np.isfinite(monodromy).all(axis=(1, 2)) & (memory[5] >= period)
    ended = np.where(ensemble.status == Status.OK, Status.TOO_FEW_CROSSINGS, ensemble.status)
    status = np.where(arrived, Status.OK, ended)
    return Returns(parts[:, :, :, 0].reshape(orbits, period, rows), records[:, -1, 0].copy(), monodromy, status)


class Scale(NamedTuple):
    """The own units of orbits: rows (2n, orbits) of coordinates and momenta, rate (orbits,), an angular frequency, and energy (orbits,)."""

    rows: np.ndarray
    rate: np.ndarray
    energy: np.ndarray

    def take(self, which: Any) -> Scale:
        """Return the scale of the orbits `which`."""
        return Scale(self.rows[:, which], self.rate[which], self.energy[which])

    def matrix(self, monodromy: np.ndarray) -> np.ndarray:
        """Return monodromy matrices (orbits, 2n, 2n) in these units."""
        return monodromy * self.rows.T[:, None, :] / self.rows.T[:, :, None]

    def norm(self, change: np.ndarray) -> np.ndarray:
        """Return the lengths of changes (orbits, 2n) of phase points."""
        return np.linalg.norm(change / self.rows.T, axis=1)

    def resolution(self, z: np.ndarray) -> np.ndarray:
        """Return the rounding of phase points z (2n, orbits): large where the origin is far."""
        return 4e-16 * np.linalg.norm(z / self.rows, axis=0)


def orbit_scale(model: Any, z: np.ndarray, energy: np.ndarray | None = None) -> Scale:
    """Return the own units of orbits from their phase points z (2n, orbits), moved to the energy (orbits,) unless that is None.

    With W the inverse mass of a coordinate, L = sqrt(2 K W)/rate and P = sqrt(2 K/W) for the energy K = T + |F|^2 W/(2 rate^2),
    that of an oscillation, or what is missing to the wanted energy where that is more. rate^2 is the largest |eigenvalue| of the
    second derivatives of V beside the masses, or where it is more 1/t^2 of the time in which V changes by T on a straight line.
    """
    n = model.degrees_of_freedom
    zero = np.zeros(z.shape[1])
    W = np.array([model.velocity(*row)[i] for i, row in enumerate(np.eye(n))])
    with np.errstate(all="ignore"):
        force = np.array([f + zero for f in model.force(*z[:n])])
        columns = [[f + zero for f in model.tangent_force(*z[:n], *row)] for row in np.sqrt(W)[:, None] * np.eye(n)]
        stiffness = np.array(columns).transpose(2, 1, 0) * np.sqrt(W)[:, None]
        rate = np.sqrt(each(lambda K: np.linalg.norm(K, 2), stiffness, (), np.float64))
        T = model.kinetic_energy(*z[n:]) + zero
        rate = _faster(model, z, T, rate)
        K = T + (W[:, None] * force**2).sum(axis=0) / (2 * rate**2)
        if energy is not None:
            K = np.fmax(K, np.abs(energy - energies(model, z)))
        return Scale(np.concatenate([np.sqrt(2 * K * W[:, None]) / rate, np.sqrt(2 * K / W[:, None])]), rate, K)


def _faster(model: Any, z: np.ndarray, T: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return the rates (orbits,), or 1/t where V changes by T in a shorter time t along a straight line: at a point of inflection."""
    n = len(z) // 2
    start, speed = model.potential_energy(*z[:n]), np.array(model.velocity(*z[n:])) + 0.0 * z[:n]
    time = np.where(rate > 0, 1 / rate, 1e90)
    going = (T > 0) & np.isfinite(rate)
    for _ in range(600):
        ends = [np.abs(model.potential_energy(*(z[:n] + s * time * speed)) - start) for s in (1, -1)]
        going &= ~(np.maximum(*ends) < T)  # no number: beyond the domain
        if not going.any():
            break
        time = np.where(going, 0.5 * time, time)
    return np.where(going, np.nan, 1 / time)


def finer_by(scheme_order: int, change: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Return how many powers of sqrt(2) finer a step must be to bring the change to the goal, fewer than 0 where it can be coarser."""
    with np.errstate(all="ignore"):
        powers = np.ceil(2 * np.log2(change / goal) / scheme_order)
    return np.clip(np.where(np.isnan(powers), 0, powers), -LONGEST_JUMP, LONGEST_JUMP).astype(np.int64)


def vector_field(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dz/dt (orbits, 2n) of Hamilton's equations at z (2n, orbits)."""
    n = model.degrees_of_freedom
    with np.errstate(all="ignore"):
        return np.array([*model.velocity(*z[n:]), *model.force(*z[:n])]).T


def energy_gradient(model: Any, z: np.ndarray) -> np.ndarray:
    """Return grad H (orbits, 2n): Hamilton's equations turned by a right angle."""
    n, field = model.degrees_of_freedom, vector_field(model, z)
    return np.concatenate([-field[:, n:], field[:, :n]], axis=1)


def section_gradient(section: Any, z: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return the gradient (orbits, 2n) of the section function: complex steps, or differences where the function is not analytic.

    scale (2n, orbits): the orbits' own units, which differences are small beside.
    """
    exact, difference = np.zeros(z.shape[::-1]), np.zeros(z.shape[::-1])
    with np.errstate(all="ignore"):
        for r in range(len(z)):
            h = 6e-6 * scale[r]
            difference[:, r] = (_value(section, z, r, h) - _value(section, z, r, -h)) / (2 * h)
            try:
                exact[:, r] = np.imag(_value(section, z, r, COMPLEX_STEP * 1j)) / COMPLEX_STEP
            except (TypeError, ValueError):
                exact[:, r] = np.nan
        off, size = np.abs(exact - difference) * scale.T, np.abs(difference) * scale.T
        return np.where(off <= 1e-4 * size.max(axis=1)[:, None], exact, difference)


def _value(section: Any, z: np.ndarray, row: int, shift: Any) -> np.ndarray:
    """Return the section function at z with one row shifted, one number for each orbit."""
    rows = [z[r] + shift if r == row else z[r] for r in range(len(z))]
    return section.value(*rows) + np.zeros(z.shape[1])


def onto(model: Any, section: Any, z: np.ndarray, energy: np.ndarray, scale: Scale) -> tuple[np.ndarray, np.ndarray]:
    """Move z (2n, orbits) the shortest way, in the orbits' units, to the section and the energy (orbits,); return it and which arrived."""
    z, D, zero, n = z.copy(), scale.rows, np.zeros(z.shape[1]), len(z) // 2
    with np.errstate(all="ignore"):
        for _ in range(20):
            rows = np.stack([section_gradient(section, z, D), energy_gradient(model, z)], axis=1)
            short = np.stack([section.value(*z) + zero, energies(model, z) - energy], axis=1)
            # What rounding of z and of the sums makes of both.
            size = (np.abs(rows) * (np.abs(z) + D).T[:, None]).sum(axis=2)
            size[:, 1] += scale.energy + model.kinetic_energy(*z[n:]) + np.abs(model.potential_energy(*z[:n]))
            near = (np.abs(short) <= 4e-15 * size).all(axis=1)
            rows = rows * D.T[:, None]
            length = np.linalg.norm(rows, axis=2)
            change = D * least_change(rows / length[:, :, None], short / length).T
            z = np.where(near, z, z - change)
            if (near | ~np.isfinite(z).all(axis=0)).all():
                break
        arrived = np.isfinite(z).all(axis=0) & (np.abs(short) <= 1e-13 * size).all(axis=1)
    return np.where(arrived, z, np.nan), arrived


def least_change(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the shortest x (k, columns) with the least |matrix x - right| of matrix (k, rows, columns); NaN where not finite."""
    x = np.full((len(matrix), matrix.shape[2]), np.nan)
    good = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    if good.any():
        inverse = np.linalg.pinv(matrix[good], rcond=RANK)
        x[good] = (inverse @ right[good, :, None])[..., 0]
    return x


def reduced_monodromy(model: Any, section: Any, z: np.ndarray, monodromy: np.ndarray, scale: Scale) -> np.ndarray:
    """Return the derivative (orbits, 2n - 2, 2n - 2) of the section map within the energy surface at fixed points z (2n, orbits).

    In a basis of the plane of both that is orthonormal in the orbits' own units; the flow takes each image back to the section.
    """
    D = scale.rows.T
    field, up = vector_field(model, z) / D, energy_gradient(model, z) * D
    along, own = section_gradient(section, z, scale.rows) * D, scale.matrix(monodromy)
    reduced = np.full((len(monodromy), len(z) - 2, len(z) - 2), np.nan)
    good = np.isfinite(own).all(axis=(1, 2))
    if good.any():
        normals = np.stack([row / np.linalg.norm(row, axis=1)[:, None] for row in (along[good], up[good])], axis=1)
        _, _, rows = np.linalg.svd(normals, full_matrices=True)
        basis, M, f, s = rows[:, 2:], own[good], field[good], along[good]
        delay = (s[:, None] @ M) / (s * f).sum(axis=1)[:, None, None]
        reduced[good] = basis @ (M - f[:, :, None] * delay) @ basis.transpose(0, 2, 1)
    return reduced


def each(function: Callable, stack: np.ndarray, shape: tuple[int, ...], dtype: type) -> np.ndarray:
    """Return function(matrix) of each matrix of a stack, NaN where it is not finite."""
    result: np.ndarray = np.full((len(stack), *shape), np.nan, dtype)
    for k in np.flatnonzero(np.isfinite(stack).all(axis=(1, 2))):
        result[k] = function(stack[k])
    return result
