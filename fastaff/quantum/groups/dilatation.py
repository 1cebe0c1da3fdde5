"""Levels of the dilatation of affinely invariant models: Schroedinger's equation of a = ln(det) on the line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..exact.exact_levels import ROUNDING
from ..solvers.separable import radial
from ..solvers.singular_ends import NoGroundState, sampled
from ..states.level_table import level_scale
from .shear_levels import FAR, limit, spare_levels

PLACES = np.linspace(-FAR, FAR, 12001)
"""Values of a among which the least of V is searched, 0.05 apart."""

ROOMS = (8.0, 16.0, 32.0, 64.0, 128.0, 256.0)
"""Distances of a wall from the least of V, towards smaller a. They grow until the levels of two of them agree."""


MARGIN = 1.5
"""Levels more than the semiclassical number that a well may bind: half of one, and one for its error."""


class Dilatation(NamedTuple):
    """Lowest levels E of the dilatation, their errors, whether they have converged, and the size of the basis."""

    E: np.ndarray
    error: np.ndarray
    converged: np.ndarray
    size: int
    said: str


class _HalfLine(NamedTuple):
    """V(a) as a function of (a - wall)^2, which `radial` takes in one dimension."""

    V: Callable[[Any], Any]
    wall: float

    def value(self, square: Any) -> Any:
        """Return V at the root of the square from the wall."""
        return self.V(np.sqrt(square) + self.wall)


def bound_dilatation(V: Callable[[Any], Any], mass: float, count: int, hbar: float, tolerance: float) -> Dilatation:
    """Return the lowest `count` levels of -(hbar^2/mass) d^2/da^2 + V(a).

    The line is a half-line with f = 0 at a wall where waves have decayed: a wall farther off gives the same levels, and
    the difference is a part of the error. Raises NoGroundState for a V without a well, or with fewer levels.
    """
    values = sampled(V, PLACES)
    lowest = int(np.argmin(values))
    if lowest in (0, values.size - 1):
        raise NoGroundState(
            f"V of det must have a well for discrete levels, got its least value at a = {PLACES[lowest]:g}"
        )
    open_end = min(limit(V, side) for side in (-1, 1))
    too_few = NoGroundState(f"V of det binds fewer levels than count = {count}")
    if np.isfinite(open_end):
        momentum = np.sqrt(mass * np.maximum(open_end - values, 0.0)) / hbar
        if count > momentum.sum() * (PLACES[1] - PLACES[0]) / np.pi + MARGIN:
            raise too_few
    spare = spare_levels(open_end)
    before: np.ndarray | None = None
    failed: NoGroundState | None = None
    best: Dilatation | None = None
    for room in ROOMS:
        try:
            problem = _HalfLine(V, float(PLACES[lowest]) - room)
            solved = radial("V of det", problem, 1, np.zeros(1), count, hbar, mass / 2, tolerance, spare)
        except NoGroundState as refused:  # a near wall squeezes waves that a farther one lets pass
            failed = refused
            continue
        E = solved.values[0]
        moved = np.abs(E - before) if before is not None else np.full(E.shape, np.inf)
        error = solved.error[0] + moved + ROUNDING * np.abs(E)
        best = Dilatation(E, error, error <= tolerance * level_scale(E), solved.size, solved.said)
        if best.converged.all():
            break
        before = E
    if best is None:
        raise failed or too_few
    if not best.E[-1] < open_end:
        raise too_few
    return best
