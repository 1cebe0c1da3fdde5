"""Surfaces of section as values: `section(z)` is the signed distance function.

`direction` = +1 counts crossings where the function increases, -1 where it decreases, 0 both. A section of one's own is
a NamedTuple with a field `direction` and a method `value(self, q1, ..., pn)` made of arithmetic.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class _Callable:
    """Gives the sections of this module `section(z)`; z has shape (2n,) or (2n, orbits)."""

    def __call__(self, z):
        return self.value(*np.asarray(z))


def _section(cls):
    """Attach the call to a NamedTuple, which cannot inherit it."""
    cls.__call__ = _Callable.__call__
    return cls


@_section
class Linear(NamedTuple):
    """The hyperplane normal . z = offset of the phase space, for a system of any number of degrees of freedom.

    `normal` has 2n entries in the row order of z; x = 0 of Henon-Heiles is Linear(normal=(1, 0, 0, 0)).
    """

    normal: tuple[float, ...]
    offset: float = 0.0
    direction: int = 1

    def value(self, *z):
        """Return normal . z - offset."""
        total = -self.offset
        for i in range(len(z)):
            total = total + self.normal[i] * z[i]
        return total


@_section
class AlphaTurning(NamedTuple):
    """Turning points of alpha, p_alpha = 0: the function is alpha p_alpha = a . p_a.

    Increasing (direction +1) at a minimum of alpha, decreasing at a maximum.
    Source: EQ2.0b of Martens & Slawianowski.
    """

    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return alpha p_alpha."""
        return a1 * pa1 + a2 * pa2


@_section
class BetaTurning(NamedTuple):
    """Turning points of beta, p_beta = 0: the function is beta p_beta = b . p_b, smooth through beta = 0.

    Increasing (direction +1) at a minimum of beta, decreasing at a maximum.
    Source: EQ2.0b of Martens & Slawianowski.
    """

    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return beta p_beta."""
        return b1 * pb1 + b2 * pb2


@_section
class AlphaEquals(NamedTuple):
    """The surface alpha = constant: the function is alpha - constant."""

    constant: float
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return alpha - constant."""
        return np.sqrt(a1 * a1 + a2 * a2) - self.constant


@_section
class BetaEquals(NamedTuple):
    """The surface beta = constant > 0: the function is beta - constant."""

    constant: float
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return beta - constant."""
        return np.sqrt(b1 * b1 + b2 * b2) - self.constant


@_section
class AreaEquals(NamedTuple):
    """The surface D1 D2 = constant (area ratio of the deformation): the function is det phi - constant.

    Source: EQ2.2x of Martens & Slawianowski, D1 D2 = (alpha^2 - beta^2)/2.
    """

    constant: float = 1.0
    direction: int = 1

    def value(self, a1, a2, b1, b2, pa1, pa2, pb1, pb2):
        """Return D1 D2 - constant."""
        return (a1 * a1 + a2 * a2 - b1 * b1 - b2 * b2) / 2 - self.constant


@_section
class Stroboscopic(NamedTuple):
    """The moments at which the drive of a driven system has a phase: t = phase, up to whole periods.

    Its crossings are exact multiples of the period apart; a start on it is none. phase: a time.
    Source: Poincare 1899, Les methodes nouvelles de la mecanique celeste III (the map over a period).
    """

    phase: float = 0.0

    @property
    def direction(self) -> int:
        """+1: the time goes on."""
        return 1

    def value(self, *z):
        """Return t - phase."""
        return z[len(z) // 2 - 1] - self.phase
