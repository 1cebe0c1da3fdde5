"""How far orbits may go before they count as escaped."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..kernels import escape
from ..models.contracts import Kind, driven, kind_of, moving
from ..models.mechanics import energies, least_energies, slopes

FARTHEST, ESCAPE = 1e150, 1e6
"""Distance whose square is still a number; escape radius in units of the orbit's own size."""

CHUNK = 4096
"""Orbits whose turning points are looked for at once."""


def escape_radii(model: Any, z: np.ndarray, energy: np.ndarray | None = None) -> np.ndarray:
    """Return the distance from the origin (orbits,) beyond which each orbit from z (2n, orbits) counts as escaped;
    energy (orbits,) of these, where it is known already.

    ESCAPE times its size: its distance at the start, or where it would turn on the straight line that it starts along,
    if that is farther; `FARTHEST` where it has neither. So it follows the unit of length, and knows neither the company
    nor the zero of V. Orbits of a map end where they are no longer finite, and no distance counts: a start near a fixed
    point says nothing of the size.
    """
    if kind_of(model) in (Kind.MAP, Kind.FLOW):
        return np.full(z.shape[1], FARTHEST)
    reach, limit = np.empty((2, z.shape[1]))
    limit[:] = energies(model, z) if energy is None else energy
    for start in range(0, len(reach), CHUNK):
        part = slice(start, start + CHUNK)
        with np.errstate(all="ignore"):
            _set_reaches(model, np.ascontiguousarray(z[:, part]), limit[part], reach[part])
    return np.where(reach > 0, np.minimum(ESCAPE * reach, FARTHEST), FARTHEST)


def _set_reaches(model: Any, z: np.ndarray, limit: np.ndarray, reach: np.ndarray) -> None:
    """Set reach (orbits,) to the distances from the origin, or of turning points, to two digits, of orbits from z with
    these energies.
    """
    n, orbits = moving(model), len(reach)
    q, distances, speeds = z[:n], _distances(), slopes(model, z)
    still: tuple[np.ndarray, ...] = ()
    if driven(model):  # the line goes through the potential of one moment
        still, limit = (np.tile(z[n], 2),), limit - z[-1]
        speeds = np.concatenate([speeds[:n], speeds[n + 1 : -1]])
    along, first, looks = np.empty((n, 2 * orbits)), np.empty(2 * orbits, np.int64), np.empty(2 * orbits, np.int64)

    def potential(spacing: int, looks: int) -> np.ndarray:
        points, energy = np.empty((n, looks, 2 * orbits)), np.empty((looks, 2 * orbits))
        escape.place(q, along, distances, first, spacing, points)
        energy[:] = least_energies(model, np.stack([*points, *(row + 0.0 * points[0] for row in still)]))
        return energy

    escape.aim(q, speeds, along, first, looks)
    escape.last_turn(potential(escape.FINE, looks.max()), limit, first, looks)
    for spacing in (escape.PARTS, 1):
        escape.halve(potential(spacing, escape.PARTS), limit, spacing, first)
    escape.reaches(q, distances, first, reach)
    near = np.flatnonzero((first.reshape(2, -1) < 0).all(axis=0) & (reach > 0))
    if near.size:  # the turns of an orbit that starts next to the origin may lie beyond what its distance tells
        centred, own, far = np.array(z[:, near]), limit[near], np.empty(near.size)
        centred[:n] = 0.0
        _set_reaches(model, centred, own + (z[-1, near] if driven(model) else 0.0), far)
        reach[near] = np.where(far > 10.0 ** escape.OWN[1] * reach[near], far, reach[near])


@functools.cache
def _distances() -> np.ndarray:
    """Return the distances that are tried, in units of an orbit's own."""
    least, most = escape.DECADES
    return 10.0 ** (np.arange(least * escape.FINE, most * escape.FINE + 1) / escape.FINE)
