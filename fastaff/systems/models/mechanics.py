"""Systems: a model with its traits and its mechanics, velocities, forces and energies for any terms."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from ...core.identity import by_identity
from ...core.sums import total
from .pointwise import at_points
from .traits import Traits


class System(Traits):
    """A model with its traits, and its velocities, forces and energies at phase points. For a map or dz/dt = f(z) the
    energy and the kinetic energy are 0, so that nothing drifts.
    """

    def velocities(self, z: np.ndarray) -> np.ndarray:
        """Return dq/dt (n, ...) at phase points z (2n, ...)."""
        n = self.n
        if not self.separable:
            return self._rates(z)[:n]
        v = stacked(at_points(self.model, "velocity", *z[n:]), z[n:])
        return self._added("v", z, v)

    def tangent_velocities(self, p: np.ndarray, dp: np.ndarray) -> np.ndarray:
        """Return the change of dq/dt (n, ...) along a change dp (n, ...) of the momenta p: 0 for the time of a driven
        model.
        """
        model = self.model
        rows = at_points(model, "tangent_velocity", *p, *dp) if self.bends else at_points(model, "velocity", *dp)
        return self.without_time(stacked(rows, dp))

    def without_time(self, rows: np.ndarray) -> np.ndarray:
        """Return rows (n, ...) of coordinates or momenta, those of the time of a driven model set to 0."""
        if not self.driven:
            return rows
        kept = rows.copy()
        kept[self.moving] = 0.0
        return kept

    def forces(self, z: np.ndarray) -> np.ndarray:
        """Return dp/dt (n, ...) at phase points z (2n, ...)."""
        n = self.n
        if not self.separable:
            return self._rates(z)[n:]
        f = stacked(at_points(self.model, "force", *z[:n]), z[:n])
        return self._added("f", z, f)

    def _added(self, letter: str, z: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return velocities ("v") or forces ("f") with the contribution of its term beside T and V."""
        if self.own is None:
            return rows
        return np.array(self.own.added(letter, self.rate, z[: self.n], z[self.n :], rows))

    def slopes(self, z: np.ndarray) -> np.ndarray:
        """Return dz/dt (2n, ...) at phase points z (2n, ...): velocities and forces."""
        if self.iterated:
            return np.zeros(z.shape)
        with np.errstate(all="ignore"):
            if not self.separable:
                return self._rates(z)
            return np.concatenate([self.velocities(z), self.forces(z)])

    def kinetic_energies(self, z: np.ndarray) -> np.ndarray:
        """Return the kinetic energy, the scale of energy errors, of phase points z (2n, ...): T of the momenta, also
        in a rotating frame; half of |p . dH/dp| for H(q, p).
        """
        n = self.n
        if not self.energetic:
            return _full(0.0, z)
        with np.errstate(all="ignore"):
            if self.nonseparable:
                return 0.5 * np.abs(total(z[n : n + self.moving] * self.velocities(z)[: self.moving]))
            return _full(at_points(self.model, "kinetic_energy", *z[n:]), z)

    def potential_energies(self, z: np.ndarray) -> np.ndarray:
        """Return the energy of phase points z (2n, ...) less the kinetic energy, with p_t if driven."""
        n = self.n
        if not self.energetic:
            return _full(0.0, z)
        with np.errstate(all="ignore"):
            if self.nonseparable:
                return self.energies(z) - self.kinetic_energies(z)
            V = _full(at_points(self.model, "potential_energy", *z[:n]), z)
            V = V + z[-1] if self.driven else V
            return V if self.own is None else V + self.own.energies(self.rate, z[:n], z[n:])

    def energies(self, z: np.ndarray) -> np.ndarray:
        """Return the energy of phase points z (2n, ...), Jacobi's in a rotating frame; NaN outside the domain."""
        with np.errstate(all="ignore"):
            if self.nonseparable:
                return _full(at_points(self.model, "energy", *z), z)
            return self.kinetic_energies(z) + self.potential_energies(z)

    def inverse_masses(self, z: np.ndarray) -> np.ndarray:
        """Return W = dv/dp (n, n, orbits) at z (2n, orbits), for T(p) without `tangent_velocity` at small momenta: the
        inverse mass matrix of a kinetic energy quadratic in p.
        """
        n = z.shape[0] // 2
        if self.nonseparable or self.curved:
            return self.tangent_slopes(z[:, None], np.eye(2 * n)[:, n:, None])[:n]
        size = 1e-3 * np.abs(z[n:]).max(axis=0)
        size = np.where(size > 0, size, 1.0)
        with np.errstate(all="ignore"):
            units = [size * unit[:, None] for unit in np.eye(n)]
            small = [self.without_time(stacked(at_points(self.model, "velocity", *p), p)) / size for p in units]
            return np.array(small).transpose(1, 0, 2)

    def mean_inverse_masses(self, z: np.ndarray) -> np.ndarray:
        """Return <v^2>/|<p v>| (n, orbits) of each coordinate over states z (2n, samples, orbits), of a T(p) that may
        be flat at small momenta; 0 where it rests.
        """
        p = z[self.n :]
        v = self.without_time(self.velocities(z))
        with np.errstate(all="ignore"):
            sound = np.isfinite(p * v)
            found = np.where(sound, v * v, 0.0).sum(axis=1) / np.abs(np.where(sound, p * v, 0.0).sum(axis=1))
        return np.where(np.isfinite(found), found, 0.0)

    def momentum_form(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return W (n, n, ...), v (n, ...) and H (...) over places q (n, ...) of H(q, p) = H + v.p + p.W p/2."""
        n = len(q)
        z = np.concatenate([q, np.zeros_like(q)])
        W = self.tangent_slopes(z[:, None], np.eye(2 * n)[:, n:].reshape(2 * n, n, *[1] * (q.ndim - 1)))[:n]
        with np.errstate(all="ignore"):
            return W, self.velocities(z), self.energies(z)

    def tangent_slopes(self, z: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Return the change of dz/dt (2n, ...) of H(q, p), or of a curved T(p) + V(q), along vectors w (2n, ...) at
        phase points z (2n, ...).
        """
        n = self.n
        model = self.model
        with np.errstate(all="ignore"):
            if self.curved:
                velocity = at_points(model, "tangent_velocity", *z[n:], *w[n:])
                changes = *velocity, *at_points(model, "tangent_force", *z[:n], *w[:n])
            else:
                changes = at_points(model, "tangent_rates", *z, *w)
            return np.array(np.broadcast_arrays(*changes, np.empty(np.broadcast_shapes(z.shape[1:], w.shape[1:])))[:-1])

    def inside(self, z: np.ndarray) -> np.ndarray:
        """Tell which phase points z (2n, ...) are in the domain."""
        with np.errstate(all="ignore"):
            return _full(at_points(self.model, "margin", *z[: self.positions]), z) > 0

    def _rates(self, z: np.ndarray) -> np.ndarray:
        """Return the rates of a flow, 0 in an idle row."""
        found = np.zeros(z.shape)
        rows = self.rows
        for row, number in zip(found, at_points(self.model, "rates", *z[:rows]), strict=False):
            row[...] = number
        return found

    @cached_property
    def rate(self) -> float:
        """Return the rate of its term beside T and V, 0 for other models."""
        return 0.0 if self.own is None else getattr(self.model, self.own.rate)()

    @cached_property
    def frame_rate(self) -> float:
        """Return |Omega| of a rotating frame, 0 for other models."""
        return abs(float(self.model.angular_velocity())) if self.frame else 0.0

    @cached_property
    def drive_rate(self) -> float:
        """Return the angular frequency of a drive, 0 for other models."""
        return 2 * math.pi / float(self.model.period) if self.driven else 0.0

    @cached_property
    def turning_mass(self) -> float:
        """Return the mass of the first two coordinates of a rotating frame: T = (p_x^2 + p_y^2)/2m + ..."""
        return 0.5 / float(self.model.kinetic_energy(1.0, *[0.0] * (self.n - 1)))

    def least_energies(self, q: np.ndarray) -> np.ndarray:
        """Return the least energy at places q (n, ...): V, in a rotating frame less the centrifugal part
        m Omega^2 (x^2 + y^2)/2. An orbit can reach a place whose least energy does not exceed its own energy.
        """
        with np.errstate(all="ignore"):
            V = np.empty(q.shape[1:])
            V[...] = at_points(self.model, "potential_energy", *q)
            if self.frame:
                V -= 0.5 * self.turning_mass * self.model.angular_velocity() ** 2 * (q[0] * q[0] + q[1] * q[1])
            return V

    def at_rest(self, q: np.ndarray) -> np.ndarray:
        """Return the momenta (n, ...) of rest at places q (n, ...): 0, except in a rotating frame."""
        p = np.zeros(q.shape)
        return -self.turning_mass * self._added("v", np.concatenate([q, p]), p) if self.frame else p

    def seen(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the momenta (n, ...) less those of rest at phase points z (2n, ...), and their rates of
        change: the mass times velocity and acceleration in the model's frame.
        """
        with np.errstate(all="ignore"):
            v = self.velocities(z)
            f = self.forces(z)
            return z[self.n :] - self.at_rest(z[: self.n]), f - self.at_rest(v)


def _full(number: Any, z: np.ndarray) -> np.ndarray:
    """Return a method's values at phase points z, or one number for all, as a fresh array (...)."""
    result = np.empty(z.shape[1:])
    result[...] = number
    return result


def stacked(numbers: Any, like: np.ndarray) -> np.ndarray:
    """Return the rows that a method gives, arrays or numbers, as one array of that shape."""
    rows = np.empty_like(like)
    for row, number in zip(rows, numbers, strict=True):
        row[...] = number
    return rows


@by_identity
def system_of(model: Any) -> System:
    """Return a model with its traits and its mechanics, a value that is made once."""
    return System(model)
