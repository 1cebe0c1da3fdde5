"""What a model says of phase points: velocities, forces, energies, whatever terms its equations have.

A map has no energy, nor has dz/dt = f(z): it is 0, as their kinetic energy is, so that nothing drifts.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.sums import total
from .traits import traits_of


def velocities(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dq/dt (n, ...) at phase points z (2n, ...)."""
    n = model.degrees_of_freedom
    if not traits_of(model).separable:
        return _rates(model, z)[:n]
    v = _rows(model.velocity(*z[n:]), z)
    return v + _turned(model, z[:n]) if traits_of(model).frame else v


def tangent_velocities(model: Any, dp: np.ndarray) -> np.ndarray:
    """Return the change of dq/dt (n, ...) along a change dp (n, ...) of the momenta, where T is quadratic: 0 for the
    time of a driven model.
    """
    changes = np.array([row + np.zeros(dp.shape[1:]) for row in model.velocity(*dp)])
    return without_time(model, changes)


def without_time(model: Any, rows: np.ndarray) -> np.ndarray:
    """Return rows (n, ...) of coordinates or momenta, those of the time of a driven model, if it is one, set to 0."""
    traits = traits_of(model)
    if not traits.driven:
        return rows
    kept = rows.copy()
    kept[traits.moving] = 0.0
    return kept


def forces(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dp/dt (n, ...) at phase points z (2n, ...)."""
    n, traits = model.degrees_of_freedom, traits_of(model)
    if not traits.separable:
        return _rates(model, z)[n:]
    f = _rows(model.force(*z[:n]), z)
    f = f - model.damping_rate() * z[n:] if traits.friction else f
    return f + _turned(model, z[n:]) if traits.frame else f


def slopes(model: Any, z: np.ndarray) -> np.ndarray:
    """Return dz/dt (2n, ...) at phase points z (2n, ...): velocities and forces."""
    traits = traits_of(model)
    if traits.iterated:
        return np.zeros(z.shape)
    with np.errstate(all="ignore"):
        if not traits.separable:
            return _rates(model, z)
        return np.concatenate([velocities(model, z), forces(model, z)])


def kinetic_energies(model: Any, z: np.ndarray) -> np.ndarray:
    """Return the kinetic energy, the scale of energy errors, of phase points z (2n, ...): T of the momenta, also in a
    turning frame; half of |p . dH/dp| for H(q, p).
    """
    n, traits = model.degrees_of_freedom, traits_of(model)
    if not traits.energetic:
        return _full(0.0, z)
    with np.errstate(all="ignore"):
        if traits.nonseparable:
            return 0.5 * np.abs(total(z[n : n + traits.moving] * velocities(model, z)[: traits.moving]))
        return _full(model.kinetic_energy(*z[model.degrees_of_freedom :]), z)


def potential_energies(model: Any, z: np.ndarray) -> np.ndarray:
    """Return what is left of the energy beside the kinetic one, of phase points z (2n, ...): with p_t where driven."""
    n, traits = model.degrees_of_freedom, traits_of(model)
    if not traits.energetic:
        return _full(0.0, z)
    with np.errstate(all="ignore"):
        if traits.nonseparable:
            return energies(model, z) - kinetic_energies(model, z)
        V = _full(model.potential_energy(*z[:n]), z)
        V = V + z[-1] if traits.driven else V
        return V - model.angular_velocity() * (z[0] * z[n + 1] - z[1] * z[n]) if traits.frame else V


def energies(model: Any, z: np.ndarray) -> np.ndarray:
    """Return the energy of phase points z (2n, ...), Jacobi's in a turning frame; NaN outside the domain."""
    with np.errstate(all="ignore"):
        if traits_of(model).nonseparable:
            return _full(model.energy(*z), z)
        return kinetic_energies(model, z) + potential_energies(model, z)


def inverse_masses(model: Any, z: np.ndarray) -> np.ndarray:
    """Return W = dv/dp (n, n, orbits) at z (2n, orbits), of T(p) at small momenta: the inverse mass matrix of a kinetic
    energy quadratic in p.
    """
    n = z.shape[0] // 2
    if traits_of(model).nonseparable:
        return tangent_slopes(model, z[:, None], np.eye(2 * n)[:, n:, None])[:n]
    size = 1e-3 * np.abs(z[n:]).max(axis=0)
    size = np.where(size > 0, size, 1.0)
    with np.errstate(all="ignore"):
        return np.array([tangent_velocities(model, size * unit[:, None]) / size for unit in np.eye(n)]).transpose(
            1, 0, 2
        )


def momentum_form(model: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return W (n, n, ...), v (n, ...) and H (...) over places q (n, ...) of H(q, p) = H + v.p + p.W p/2."""
    n, z = len(q), np.concatenate([q, np.zeros_like(q)])
    W = tangent_slopes(model, z[:, None], np.eye(2 * n)[:, n:].reshape(2 * n, n, *[1] * (q.ndim - 1)))[:n]
    with np.errstate(all="ignore"):
        return W, velocities(model, z), energies(model, z)


def tangent_slopes(model: Any, z: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return the change of dz/dt (2n, ...) of H(q, p) along vectors w (2n, ...) at phase points z (2n, ...)."""
    with np.errstate(all="ignore"):
        changes = model.tangent_rates(*z, *w)
        return np.array(np.broadcast_arrays(*changes, np.empty(np.broadcast_shapes(z.shape[1:], w.shape[1:])))[:-1])


def inside(model: Any, z: np.ndarray) -> np.ndarray:
    """Tell which phase points z (2n, ...) lie where the potential lives."""
    with np.errstate(all="ignore"):
        return _full(model.margin(*z[: traits_of(model).positions]), z) > 0


def _rates(model: Any, z: np.ndarray) -> np.ndarray:
    """Return the rates of a flow, 0 in an idle row."""
    found, rows = np.zeros(z.shape), traits_of(model).rows
    for row, number in zip(found, model.rates(*z[:rows]), strict=False):
        row[...] = number
    return found


# --- turning frames -------------------------------------------------------------------------------------------------


def frame_rate(model: Any) -> float:
    """Return |Omega| of a turning frame, 0 for other models."""
    return abs(float(model.angular_velocity())) if traits_of(model).frame else 0.0


def turning_mass(model: Any) -> float:
    """Return the mass of the first two coordinates of a turning frame: T = (p_x^2 + p_y^2)/2m + ..."""
    return 0.5 / float(model.kinetic_energy(1.0, *[0.0] * (model.degrees_of_freedom - 1)))


def least_energies(model: Any, q: np.ndarray) -> np.ndarray:
    """Return the least energy that there is at places q (n, ...): V, in a turning frame less the centrifugal part
    m Omega^2 (x^2 + y^2)/2. A place is reached where it does not exceed the orbit's.
    """
    with np.errstate(all="ignore"):
        V = np.empty(q.shape[1:])
        V[...] = model.potential_energy(*q)
        if traits_of(model).frame:
            V -= 0.5 * turning_mass(model) * model.angular_velocity() ** 2 * (q[0] * q[0] + q[1] * q[1])
        return V


def at_rest(model: Any, q: np.ndarray) -> np.ndarray:
    """Return the momenta (n, ...) of rest at places q (n, ...): 0, but in a turning frame."""
    p = np.zeros(q.shape)
    return p - turning_mass(model) * _turned(model, q) if traits_of(model).frame else p


def seen(model: Any, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the momenta (n, ...) beyond those of rest at phase points z (2n, ...), and what they change at: the mass
    times velocity and acceleration as they are seen in the model's frame.
    """
    n = model.degrees_of_freedom
    with np.errstate(all="ignore"):
        v, f = velocities(model, z), forces(model, z)
        return z[n:] - at_rest(model, z[:n]), f - at_rest(model, v)


def _turned(model: Any, rows: np.ndarray) -> np.ndarray:
    """Return what turning adds to the slopes of n rows: Omega times the second to the first, minus the first to the
    second.
    """
    omega, change = model.angular_velocity(), np.zeros(rows.shape)
    change[0], change[1] = omega * rows[1], -omega * rows[0]
    return change


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
