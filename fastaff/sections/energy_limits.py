"""The energies that a system can have: its minimum, and the saddle above which orbits may escape."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..systems.models.mechanics import System, system_of
from ..systems.models.reduction import reduced_body
from .allowed_region import Function

RADII = np.geomspace(1e-8, 1e8, 129)
"""Distances at which the search for stationary points starts: all sizes."""

ANGLES = 24
"""Directions in which the search for stationary points starts."""

STEPS = 60
"""Steps of the search for stationary points."""

LONGEST = 0.5
"""Longest step of the search, in distances from the origin."""


class NotReached(ValueError):
    """Raised if an energy surface has no point on the section or in the ranges, because the energy is too low there."""


class Limits(NamedTuple):
    """The least energy of a minimum and of a saddle of the effective potential; NaN where none was found."""

    minimum: float
    saddle: float


def energy_limits(system: System, p_eta: float = 0.0, p_gamma: float = 0.0) -> Limits:
    """Return the least energies of a minimum and of a saddle: of a body at the angular momenta of its planes, or of a
    system of two coordinates.

    Newton's method from some 3000 points of all sizes finds where the force is 0, the second derivatives tell minima
    from saddles. The values are for messages, not for computations: a narrow well far from the others may be missed.
    NaN where there is none or the second derivatives are not known.
    Source: Henon & Heiles 1964, Astron. J. 69, 73: a minimum at 0 and three saddles at 1/6.
    """
    plane = _in_plane(system, p_eta, p_gamma)
    if plane.n != 2 or not hasattr(plane.model, "tangent_force"):
        return Limits(np.nan, np.nan)
    try:
        with np.errstate(all="ignore"):
            energy, negative = _stationary(plane)
    except AttributeError:  # a potential without second derivatives
        return Limits(np.nan, np.nan)
    minimum, saddle = (float(energy[negative == k].min()) if (negative == k).any() else np.nan for k in (0, 1))
    return Limits(minimum, saddle)


def _in_plane(system: System, p_eta: float, p_gamma: float) -> System:
    """Return the system of two coordinates at the angular momenta of a body's planes; any other system as it is."""
    if not system.isotropic:
        return system
    return system_of(reduced_body(system.model, p_eta=p_eta, p_gamma=p_gamma))


def _stationary(system: System) -> tuple[np.ndarray, np.ndarray]:
    """Return energies of stationary points of a potential of two coordinates, and the number of directions in which
    each is a maximum.
    """
    turn = (np.arange(ANGLES) + 0.5) * (2 * np.pi / ANGLES)
    q = np.array([np.outer(RADII, np.cos(turn)).ravel(), np.outer(RADII, np.sin(turn)).ravel()])
    q = q[:, system.model.margin(*q) > 0]
    step = np.zeros_like(q)
    for _ in range(STEPS):
        force, second = _derivatives(system, q)
        a = second[0, 0]
        b = second[0, 1]
        d = second[1, 1]
        step = np.array([d * force[0] - b * force[1], a * force[1] - b * force[0]]) / (a * d - b * b)
        long = np.hypot(*step) / (LONGEST * np.hypot(*q))
        q = q + step / np.maximum(long, 1.0)
    found = (np.hypot(*step) <= 1e-9 * np.hypot(*q)) | (np.hypot(*q) < 1e-12)
    q = q[:, found & np.isfinite(q).all(axis=0) & (system.model.margin(*q) > 0)]
    _, second = _derivatives(system, q)
    energy = system.least_energies(q)
    bends = np.linalg.eigvalsh(np.moveaxis(np.where(np.isfinite(second), second, 0.0), 2, 0))
    return energy[np.isfinite(energy)], (bends < 0).sum(axis=1)[np.isfinite(energy)]


def _derivatives(system: System, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return force (2, points) and second derivatives (2, 2, points) of the potential at q (2, points)."""
    unit = np.ones(q.shape[1:])
    columns = [system.model.tangent_force(*q, unit, 0.0 * unit), system.model.tangent_force(*q, 0.0 * unit, unit)]
    spread = np.array([[np.broadcast_to(-row, unit.shape) for row in column] for column in columns])
    force = np.array([np.broadcast_to(row, unit.shape) for row in system.model.force(*q)])
    if system.frame:  # the centrifugal force
        pull = system.turning_mass * system.frame_rate**2
        return force + pull * q, spread - pull * np.eye(2)[:, :, None]
    return force, spread


def fitting_energy(system: System, p_eta: float, p_gamma: float) -> float:
    """Return an energy under the lowest saddle, else that of rest at a distance of about 1; NaN where none is known."""
    least, saddle = energy_limits(system, p_eta, p_gamma)
    if saddle > least:
        return least + 0.75 * (saddle - least)
    plane = _in_plane(system, p_eta, p_gamma)
    if plane.n != 2:
        return np.nan
    with np.errstate(all="ignore"):
        return float(plane.energies(np.array([[1.0], [0.5], [0.0], [0.0]]))[0])


def too_low(system: System, energy: float, p_eta: float, p_gamma: float) -> str | None:
    """Return the sentence for an energy below the minimum of the system; None where it is not known to be."""
    least = energy_limits(system, p_eta, p_gamma).minimum
    if not energy < least or system.frame:  # a turning frame has lower energies far away
        return None
    where = f" with p_eta = {p_eta:g} and p_gamma = {p_gamma:g}" if system.isotropic else ""
    what = "body" if system.isotropic else "system"
    least = least if abs(least) > 1e-12 * abs(energy) else 0.0  # hidden by rounding
    return f"energy must be at least the minimum {least:.6g} of this {what}{where}, got {energy:g}"


def may_escape(system: System, energy: float, p_eta: float = 0.0, p_gamma: float = 0.0) -> str | None:
    """Return the sentence for an energy above the lowest saddle of the potential; None where there is none below."""
    saddle = energy_limits(system, p_eta, p_gamma).saddle
    if not energy > saddle + 1e-12 * abs(saddle):  # to rounding
        return None
    return f"energy {energy:g} exceeds the escape energy {saddle:.6g}"


class Where(NamedTuple):
    """A section of an energy surface, of a body at the angular momenta of its planes: where orbits are launched."""

    system: System
    section: Any
    energy: float
    p_eta: float = 0.0
    p_gamma: float = 0.0

    @property
    def model(self) -> Any:
        """The model."""
        return self.system.model

    def too_low(self) -> str | None:
        """Return the sentence for an energy below the minimum; None where it is not known to be."""
        return too_low(self.system, self.energy, self.p_eta, self.p_gamma)

    def may_escape(self) -> str | None:
        """Return the sentence for an energy above the lowest saddle; None where there is none below."""
        return may_escape(self.system, self.energy, self.p_eta, self.p_gamma)

    def room(self, alpha: Any, beta: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return 2 mu (energy - H) at rest in alpha and beta, the squared momentum that is left, and the sum of the
        sizes of its terms.
        """
        potential = self.model.potential
        mass = 2 * self.model.mu
        A = alpha * alpha
        B = beta * beta
        barrier = (self.p_eta / alpha) ** 2 if self.p_eta else 0.0
        barrier = barrier + ((self.p_gamma / beta) ** 2 if self.p_gamma else 0.0)
        V = potential.value(A, B)
        left = np.where(potential.margin(A, B) > 0, mass * (self.energy - V) - barrier, -np.inf)
        return left, mass * (abs(self.energy) + np.abs(V)) + barrier

    def radial(self, u: np.ndarray, *, alpha: bool) -> Function:
        """Return `room` as a function of alpha (else beta) in columns over values u of the other radius."""
        if alpha:
            return lambda x, j: self.room(x, u[j])
        return lambda x, j: self.room(u[j], x)

    def point(self, alpha: Any, p_alpha: Any, beta: Any, p_beta: Any) -> np.ndarray:
        """Return phase points with eta = gamma = 0; a radius 0 is allowed where its angular momentum is 0."""
        across_a = self.p_eta / alpha if self.p_eta else 0.0 * alpha
        across_b = self.p_gamma / beta if self.p_gamma else 0.0 * beta
        return np.array([alpha, 0 * alpha, beta, 0 * beta, p_alpha, across_a, p_beta, across_b])
