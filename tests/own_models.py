"""Models of one's own that several test modules use."""

from __future__ import annotations

from typing import NamedTuple


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
