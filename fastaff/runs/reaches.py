"""Distances beyond which orbits count as escaped."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..core.sums import length
from ..engine.blocks import model_block, parameters
from ..engine.jit import LANES
from ..engine.kernels import escape
from ..engine.packing import run_units
from ..systems.models.mechanics import System

FARTHEST = 1e150
"""Distance beyond which orbits of usual size have escaped."""

ESCAPE = 1e6
"""Escape radius in units of the orbit's own size."""


LARGEST = 1e154
"""Largest escape radius, whose square is still a number."""

HUGE = 1e3
"""Least ratio of the escape radius, up to LARGEST, to the size of an orbit of more than FARTHEST."""


def escape_radii(system: System, z: np.ndarray, energy: np.ndarray | None = None) -> np.ndarray:
    """Return the distance from the origin (orbits,) beyond which each orbit from z (2n, orbits) counts as escaped;
    energy (orbits,) of these, where it is known already.

    It is ESCAPE times the orbit's size: its distance at the start, or that of the turning point on the straight line
    along its initial velocity, if that is farther; `FARTHEST` where it has neither. So it scales with the unit of
    length, and depends neither on other orbits nor on the zero of V. Orbits of a map, and of H(q, p), have no such
    limit: a start near a fixed point does not show the size, and coordinates may be angles that wind.
    """
    if not system.separable or "energy" in system.words:
        return np.full(z.shape[1], FARTHEST)
    limit = system.energies(z) if energy is None else energy
    with np.errstate(all="ignore"):
        reach = _reaches(system, z, limit)
    farthest = np.fmax(FARTHEST, np.fmin(HUGE * reach, LARGEST))
    return np.where(reach > 0, np.fmin(ESCAPE * reach, farthest), FARTHEST)


def _reaches(system: System, z: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Return the distances from the origin (orbits,) of orbits from z, or of their turning points at these energies, to
    two digits.
    """
    n = system.moving
    total = system.n
    orbits = z.shape[1]
    speeds = system.slopes(z)
    centrifugal = 0.0
    if system.driven:  # V along the line is that of one moment
        limit = limit - z[-1]
        speeds = np.concatenate([speeds[:n], speeds[n + 1 : -1]])
    if system.frame:
        centrifugal = 0.5 * system.turning_mass * float(system.model.angular_velocity()) ** 2
    q = np.ascontiguousarray(z[:total])
    distances = _distances()
    size = length(q[:n])
    along = np.zeros((total, orbits))
    unit = np.where(size > 0, size, 1.0)
    own = np.where((speeds[:n] != 0).any(axis=0), speeds[:n], speeds[n:])  # of an orbit that rests the force
    own = own / np.abs(own).max(axis=0)  # lengths of huge velocities have no square
    own = own / length(own)
    along[:n] = np.where(np.isfinite(own), own * unit, 0.0)
    lowest, highest = np.where(size > 0, np.array(escape.OWN)[:, None], np.array(escape.DECADES)[:, None])
    begin = escape.FINE * (lowest - escape.DECADES[0])
    looks = highest - lowest + 1
    turn = np.full((2, orbits), -1)
    if (potential := _potential(system.model)) is None:
        _find_turns(system, distances, q, along, begin, looks, limit, turn)
    else:
        arguments = (parameters(system.model), potential, centrifugal, distances, q, along, begin, looks, limit, turn)
        run_units(escape.find_turns, arguments, -(-orbits // LANES), threads=1)
    farther = turn.max(axis=0)
    turned = farther >= 0
    reach = np.where(turned, np.maximum(size, unit * distances[farther]), size)
    near = np.flatnonzero(~turned & (reach > 0))
    if near.size:  # turning points may be far beyond the distance of a start next to the origin
        centred = np.array(z[:, near])
        own = limit[near]
        centred[:n] = 0.0
        far = _reaches(system, centred, own + (z[-1, near] if system.driven else 0.0))
        reach[near] = np.where(far > 10.0 ** escape.OWN[1] * reach[near], far, reach[near])
    return reach


_NOT_COMPILED: set[tuple[type, ...]] = set()
"""Classes of models, with those of their fields, whose potential energy Numba does not compile."""


def _potential(model: Any) -> Any:
    """Return the compiled potential energy; None where it does not compile: no other function needs it compiled."""
    classes = (type(model), *map(type, model))
    if classes not in _NOT_COMPILED:
        try:
            return model_block("potential", model, model.degrees_of_freedom)
        except Exception:  # Numba's own, and any other that its passes raise
            _NOT_COMPILED.add(classes)
    return None


def _find_turns(
    system: System,
    distances: np.ndarray,
    q: np.ndarray,
    along: np.ndarray,
    begin: np.ndarray,
    looks: np.ndarray,
    limit: np.ndarray,
    turn: np.ndarray,
) -> None:
    """Set turn as `escape.find_turns` does, by NumPy."""

    def below(number: np.ndarray, way: float) -> np.ndarray:
        place = q + distances[np.clip(number, 0, distances.size - 1)] * (way * along)
        return system.least_energies(place) <= limit

    for side, way in enumerate((1.0, -1.0)):
        last = turn[side]
        inside = np.zeros(begin.size, bool)
        for k in range(looks.max()):
            now = below(begin + escape.FINE * k, way)
            last[:] = np.where((k < looks) & inside & ~now, begin + escape.FINE * (k - 1), last)
            inside = np.where(k < looks, now, inside)
        half = escape.FINE // 2
        while half > 0:
            last += np.where((last >= 0) & below(last + half, way), half, 0)
            half //= 2


@functools.cache
def _distances() -> np.ndarray:
    """Return the distances that are tried, in units of an orbit's own."""
    least, most = escape.DECADES
    return 10.0 ** (np.arange(least * escape.FINE, most * escape.FINE + 1) / escape.FINE)
