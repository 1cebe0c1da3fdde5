"""Models of one's own that several test modules use."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import fastaff as fa
from fastaff.systems.models.contracts import Kind


class OneSpring(NamedTuple):
    """A mass on a spring, with only what every model must have: no second derivatives, no angles."""

    k: float = 1.0
    degrees_of_freedom = 1
    coordinates = ("x",)

    def velocity(self, p):
        return (p,)

    def force(self, x):
        return (-self.k * x,)

    def kinetic_energy(self, p):
        return p * p / 2

    def potential_energy(self, x):
        return self.k * x * x / 2

    def margin(self, x):
        return 1.0 + 0.0 * x


class HenonHeilesInUnits(NamedTuple):
    """Henon-Heiles with the origin, the zero of V and the units of length, time and mass changed."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0
    origin: float = 0.0
    zero: float = 0.0

    degrees_of_freedom = 2
    coordinates = ("x", "y")

    @property
    def energy(self):
        return self.mass * self.length**2 / self.time**2

    def velocity(self, px, py):
        return px / self.mass, py / self.mass

    def force(self, x, y):
        x, y, f = x / self.length - self.origin, y / self.length - self.origin, self.mass * self.length / self.time**2
        return -f * (x + 2 * x * y), -f * (y + x * x - y * y)

    def tangent_force(self, x, y, dx, dy):
        x, y, k = x / self.length - self.origin, y / self.length - self.origin, self.mass / self.time**2
        return -k * (dx + 2 * (y * dx + x * dy)), -k * (dy + 2 * (x * dx - y * dy))

    def kinetic_energy(self, px, py):
        return (px * px + py * py) / (2 * self.mass)

    def potential_energy(self, x, y):
        x, y = x / self.length - self.origin, y / self.length - self.origin
        return self.energy * ((x * x + y * y) / 2 + x * x * y - y * y * y / 3 + self.zero)

    def margin(self, x, y):
        return 0.0 * x + 1.0

    def rows(self, z):
        """Phase points of these units."""
        momentum = self.mass * self.length / self.time
        return np.concatenate([(z[:2] + self.origin) * self.length, z[2:] * momentum])

    def section(self):
        return fa.Hyperplane(normal=(1, 0, 0, 0), offset=self.origin * self.length)


class Driven(NamedTuple):
    """A pendulum with a wave of amplitude a and frequency 1, in the phase space extended by the time."""

    a: float

    kind = Kind.DRIVEN
    coordinates = ("x", "t")
    degrees_of_freedom = 2
    period = 2 * np.pi

    def phase(self, t):
        return t - 2 * np.pi * np.floor(t / (2 * np.pi))

    def velocity(self, px, pt):
        return px, 1.0 + 0.0 * pt

    def force(self, x, t):
        return -np.sin(x) - self.a * np.sin(x - t), self.a * np.sin(x - t)

    def tangent_force(self, x, t, dx, dt):
        wave = self.a * np.cos(x - t) * (dx - dt)
        return -np.cos(x) * dx - wave, wave

    def kinetic_energy(self, px, pt):
        return px * px / 2

    def potential_energy(self, x, t):
        return -np.cos(x) - self.a * np.cos(x - t)

    def margin(self, x, t):
        return 1.0 + 0.0 * (x + t)


class NoPhase(NamedTuple):
    """As `Driven`, without the phase."""

    a: float

    kind, coordinates, degrees_of_freedom, period = Kind.DRIVEN, ("x", "t"), 2, 2 * np.pi
    velocity, force, margin = Driven.velocity, Driven.force, Driven.margin
    kinetic_energy, potential_energy = Driven.kinetic_energy, Driven.potential_energy


class Stopped(NamedTuple):
    """As `Driven`, with a time that stands still."""

    a: float

    kind, coordinates, degrees_of_freedom, period = Kind.DRIVEN, ("x", "t"), 2, 2 * np.pi
    phase, force, margin = Driven.phase, Driven.force, Driven.margin
    kinetic_energy, potential_energy = Driven.kinetic_energy, Driven.potential_energy

    def velocity(self, px, pt):
        return px, 0.0 * pt


class Plain:
    """A function of one variable without a slope."""

    def __init__(self, value):
        self.value = value


class Radius(NamedTuple):
    """The section sqrt(D1^2 + D2^2) = constant of a body, over beta: with what a grid and a sample on it need."""

    constant: float
    direction: int = 1

    over = "beta"

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        return np.sqrt(a1 * a1 + a2 * a2 + b1 * b1 + b2 * b2) - self.constant

    def radii(self, u):
        return np.sqrt(self.constant**2 - u * u), u

    def slopes(self, alpha, beta):
        return alpha / self.constant, beta / self.constant

    def leaning(self, u):
        return u * u / (self.constant**2 - u * u)
