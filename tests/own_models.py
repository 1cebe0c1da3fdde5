"""Models of one's own that several test modules use."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import fastaff as fa


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
        return fa.Linear(normal=(1, 0, 0, 0), offset=self.origin * self.length)
