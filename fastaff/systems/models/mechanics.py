"""A system: a model with the facts that the package depends on, and its mechanics at phase points.

Facts (`Traits`) are determined once for each model. Velocities, forces and energies are those of the equations with all
their terms.
"""

from __future__ import annotations

import math
from collections.abc import Set
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...engine.kinds import Kind
from ...engine.terms import Substep, Term
from ...engine.values import at_points, by_identity
from . import maps


@dataclass(frozen=True)
class Traits:
    """The facts about a model, each determined at its first use. Facts about a whole kind of motion follow from the
    terms of its equations (`engine.kinds.TERMS`), so that a user's own kind has all of them.
    """

    model: Any

    @cached_property
    def kind(self) -> Kind:
        """The kind of its equations. A wrong one counts as that of none, until `check_kind` refuses it."""
        kind = getattr(self.model, "kind", Kind.SEPARABLE)
        return kind if isinstance(kind, Kind) else Kind.SEPARABLE

    @property
    def terms(self) -> Set[str]:
        """The terms of its equations beside H = T(p) + V(q)."""
        return self.kind.terms

    @cached_property
    def driven(self) -> bool:
        """Whether V depends on the time, which is its last coordinate."""
        return "drive" in self.terms

    @cached_property
    def frame(self) -> bool:
        """Whether its frame rotates."""
        return "frame" in self.terms

    @cached_property
    def iterated(self) -> bool:
        """Whether it is a map, which has whole numbers of iterates instead of a time."""
        return "iterates" in self.terms

    @cached_property
    def nonseparable(self) -> bool:
        """Whether its H depends on coordinates and momenta together."""
        return "nonseparable" in self.terms

    @property
    def words(self) -> Set[str]:
        """Its terms and the properties of each, which refusals depend on."""
        return self.kind.words

    @property
    def own(self) -> Term | None:
        """The term that splittings solve with their drifts or kicks, if there is one."""
        return self.kind.own

    @property
    def substep(self) -> Substep | None:
        """The exact solution of that term in splittings."""
        return None if self.own is None else self.own.substep

    @cached_property
    def dissipative(self) -> bool:
        """Whether its energy is lost."""
        return "loss" in self.words

    @cached_property
    def canonical(self) -> bool:
        """Whether its rows are coordinates and their momenta, not variables of dz/dt = f(z)."""
        return "rates" not in self.terms

    @cached_property
    def separable(self) -> bool:
        """Whether velocities depend on momenta and forces on coordinates alone, except for a term in a substep."""
        return not self.terms & {"rates", "iterates", "nonseparable"}

    @cached_property
    def poles(self) -> bool:
        """Whether it has a method for its poles, which steps may miss."""
        return not self.iterated and _tells_of_poles(self.model)

    @cached_property
    def energetic(self) -> bool:
        """Whether it has an energy, conserved or not."""
        return self.canonical and not self.iterated

    @cached_property
    def conserves(self) -> bool:
        """Whether its motion conserves an energy, H + p_t for a driven system."""
        return self.energetic and not self.dissipative

    @cached_property
    def symplectic(self) -> bool:
        """Whether its motion conserves the symplectic form; for a map by a test to rounding, at random points."""
        return maps.symplectic(self.model) if self.iterated else self.conserves and "noncanonical" not in self.words

    @cached_property
    def n(self) -> int:
        """Its number of degrees of freedom, with the time."""
        return self.model.degrees_of_freedom

    @cached_property
    def moving(self) -> int:
        """The number of its coordinates without the time; also the row of the time."""
        return self.n - self.driven

    @cached_property
    def rows(self) -> int:
        """The number of rows of a phase point: 2n, or that of the variables of dz/dt = f(z)."""
        return 2 * self.n if self.canonical else len(self.model.coordinates)

    @cached_property
    def positions(self) -> int:
        """The number of arguments of its margin: coordinates, or all variables."""
        return self.n if self.separable or self.iterated else self.rows

    @cached_property
    def winding(self) -> tuple[bool, ...]:
        """Which rows of a map have a period, () for other systems."""
        return tuple(period > 0 for period in self.model.periods()) if self.iterated else ()

    @cached_property
    def periods(self) -> tuple[float, ...]:
        """The periods of its coordinates that are angles, 0 for the others; of all variables of dz/dt = f(z)."""
        n = self.n if self.canonical else self.rows
        return tuple(map(float, getattr(self.model, "periods", lambda: (0.0,) * n)()[:n]))

    def turned_back(self, z: np.ndarray) -> np.ndarray:
        """Return phase points (2n, ...) with angles reduced, in place, to half a period around 0."""
        for row, period in zip(z, () if self.iterated else self.periods, strict=False):
            if period > 0:
                row -= period * np.floor(row / period + 0.5)
        return z

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of its coordinates, q1 to qn by default."""
        return tuple(getattr(self.model, "coordinates", [f"q{i + 1}" for i in range(self.n)]))

    @cached_property
    def row_names(self) -> tuple[str, ...]:
        """The names of the rows of a phase point: coordinates, then their momenta."""
        momenta = getattr(self.model, "momenta", [f"p_{name}" for name in self.names]) if self.canonical else ()
        return (*self.names, *momenta)

    @cached_property
    def planar(self) -> bool:
        """Whether it is a body in the planes a and b: it has a potential and says whether it is isotropic."""
        return hasattr(self.model, "potential") and hasattr(self.model, "isotropic")

    @cached_property
    def isotropic(self) -> bool:
        """Whether it is a body in the planes a and b whose angular momenta p_eta and p_gamma are conserved."""
        return bool(getattr(self.model, "isotropic", False))

    @cached_property
    def breathes(self) -> bool:
        """Whether it is a body in the planes a and b whose kinetic energy has a breathing term."""
        return hasattr(self.model, "breathing")

    @cached_property
    def conserves_spins(self) -> bool:
        """Whether it is a body in the planes a and b, of any kinetic energy, that conserves p_eta and p_gamma."""
        return self.isotropic or self.breathes

    @cached_property
    def quadratic(self) -> bool:
        """Whether its kinetic energy is quadratic in the momenta: velocities are linear in them (the time's is 1)."""
        if not self.separable:
            return False
        p = np.linspace(0.3, 1.1, self.n)
        d = np.linspace(-0.7, 0.4, self.n)
        with np.errstate(all="ignore"):
            v, rest, change = (np.array(self.model.velocity(*at))[: self.moving] for at in (p, p + d, d))
        rest = rest - v - change
        return bool(np.abs(rest).max() <= 1e-12 * np.abs(v).max())

    @cached_property
    def has_tangent_velocity(self) -> bool:
        """Whether it has the change of its velocities along a vector: its T need not be quadratic."""
        return hasattr(self.model, "tangent_velocity")

    @cached_property
    def nonquadratic(self) -> bool:
        """Whether it is T(p) + V(q), T not quadratic, and has the changes of velocities and forces along vectors."""
        return (
            self.separable and self.has_tangent_velocity and hasattr(self.model, "tangent_force") and not self.quadratic
        )

    @cached_property
    def newtonian(self) -> bool:
        """Whether accelerations are forces times inverse masses: it is T(p) + V(q), T quadratic or without a derivative
        of its velocities.
        """
        return self.separable and not self.nonquadratic

    @cached_property
    def of_degree_two(self) -> bool:
        """Whether H is of second degree in the momenta over each place, found at random points of all sizes."""
        return self.quadratic if self.separable else self.nonseparable and self._tried[0]

    @cached_property
    def ellipsoidal(self) -> bool:
        """Whether an energy allows an ellipsoid of momenta over each place: of second degree, with positive masses."""
        return self.quadratic if self.separable else self.of_degree_two and self._tried[1]

    @cached_property
    def _tried(self) -> tuple[bool, bool]:
        """Whether velocities are linear in the momenta, and the inverse masses positive definite, at the points
        tried.
        """
        n = self.n
        random = np.random.default_rng(11)
        count = 512
        q = random.standard_normal((n, count)) * 10.0 ** random.uniform(-2, 1, count)
        p, d = random.standard_normal((2, n, count)) * 10.0 ** random.uniform(-20, 20, count)
        zero = np.zeros((n, count))
        with np.errstate(all="ignore"):
            v0, v1, vd, both = (
                np.array(np.broadcast_arrays(*self.model.rates(*q, *p), p[0])[:n]) for p in (zero, p, d, p + d)
            )
            margins = [np.broadcast_to(self.model.margin(*q, *p), count) > 0 for p in (zero, p, d)]
            columns = [
                self.model.tangent_rates(*q, *zero, *zero, *np.repeat(row[:, None], count, 1)) for row in np.eye(n)
            ]
            W = np.array([np.broadcast_arrays(*column, p[0])[:n] for column in columns])
            size = np.abs(both) + np.abs(v1) + np.abs(vd) + np.abs(v0)
            kept = margins[0] & np.isfinite(size).all(axis=0) & np.isfinite(W).all(axis=(0, 1))
            linear = np.abs(both - v1 - vd + v0)[:, kept] <= 1e-9 * size.max(axis=0)[kept]
        same = all((margin == margins[0]).all() for margin in margins)
        if kept.sum() < count // 64 or not same or not linear.all():
            return False, False
        return True, bool((np.linalg.eigvalsh(np.moveaxis(W[..., kept], 2, 0)) > 0).all())


def _tells_of_poles(model: Any) -> bool:
    """Whether a model has a method for its poles, and so has the part that gives them."""
    own = getattr(model, getattr(model, "poles_of", ""), None)
    return hasattr(model, "poles") and (own is None or _tells_of_poles(own))


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
        rows = (
            at_points(model, "tangent_velocity", *p, *dp)
            if self.has_tangent_velocity
            else at_points(model, "velocity", *dp)
        )
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
        if self.nonseparable or self.nonquadratic:
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
            if self.nonquadratic:
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


def total(rows: np.ndarray) -> np.ndarray:
    """Return the sum over the first axis, row by row: in one order for any number of orbits. NumPy's own depends
    on their number.
    """
    result = np.zeros(rows.shape[1:])
    for row in rows:
        result += row
    return result


def length(rows: np.ndarray) -> np.ndarray:
    """Return the root of the sum of squares over the first axis, row by row."""
    return np.sqrt(total(rows * rows))


@by_identity
def system_of(model: Any) -> System:
    """Return a model with its traits and its mechanics, a value that is made once."""
    return System(model)
