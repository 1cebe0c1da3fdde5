"""The part of a section q_i = c that an energy of H(q, p) allows, for two degrees of freedom: the least and the largest
momentum over the other coordinate. Both are taken at the p_i of the least energy there.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from .allowed_region import evaluated, highest
from .energy_limits import NotReached, Where
from .invariant_measure import Momenta
from .named_axes import section_row
from .surface_points import surface_of
from .surface_roots import left

ACROSS = 128
"""Parts of the range of a coordinate in which an H of any kind is sampled."""

ALONG = 64
"""Parts of the range of a momentum in which an H of any kind is sampled."""

HALVINGS = 48
"""Halvings for the ends of these ranges."""


class Sides(NamedTuple):
    """Coordinates (points,), and the least and the largest momentum over each."""

    coordinate: np.ndarray
    low: np.ndarray
    high: np.ndarray


class Ellipses:
    """The ellipses of momenta over the points of a section, of an H of second degree in the momenta."""

    def __init__(self, where: Where):
        name, self.at, _ = section_row(where.system, where.section)
        self.energy, self.i = where.energy, where.system.names.index(name)
        self.momenta = Momenta.of(where.system, self.i)

    def places(self, u: np.ndarray) -> np.ndarray:
        """Return places (2, ...) over values (...) of the other coordinate."""
        q = np.full((2, *u.shape), float(self.at))
        q[1 - self.i] = u
        return q

    def room(self, u: np.ndarray, _: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the energy that is left, as a function of one column, and its size."""
        floor = self.momenta.floor(self.places(u))
        return self.energy - floor, abs(self.energy) + np.abs(floor)

    def sides(self, u: np.ndarray) -> Sides:
        """Return the ends of the ellipses over coordinates (points,)."""
        q = self.places(u)
        with np.errstate(all="ignore"):
            room = evaluated(self.room, u, np.zeros(u.size, np.int64))[0]
            reach, centre = self.momenta.reach(q)
            half = reach * np.sqrt(2 * np.maximum(room, 0.0))
        return Sides(u, centre - half, centre + half)


def sides_of_any(where: Where, points: int) -> list[Sides]:
    """Return the pieces of a section of any H(q, p), told by a net over the box that the energy bounds."""
    system, section, energy = where[:3]
    box = surface_of(system, energy, section, None).box
    name, at, _ = section_row(system, section)
    i = system.names.index(name)
    low, high = (dict(zip((1 - i, 2, 3), ends)) for ends in (box.low, box.high))
    nodes = np.linspace(low[2 + i], high[2 + i], ALONG + 1)

    def room(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the energy that is left at points (points,) at the best p_i."""

        def over(p: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            z = np.empty((4, *p.shape))
            z[i], z[1 - i], z[2 + i], z[3 - i] = at, u[column], p, v[column]
            return left(system, energy, z)

        return highest(over, u.size, nodes)

    def best(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the momentum at which the most energy is left over coordinates, and that energy."""
        a = np.full(u.size, low[3 - i])
        b = np.full(u.size, high[3 - i])
        for parts in (ALONG, 8, 8, 8, 8, 8, 8):
            v = a + (b - a) * np.linspace(0, 1, parts + 1)[:, None]
            rest = room(np.tile(u, parts + 1), v.ravel()).reshape(v.shape)
            k = np.clip(rest.argmax(axis=0), 1, parts - 1)
            a, b, v = (np.take_along_axis(v, (k + step)[None], axis=0)[0] for step in (-1, 1, 0))
        return v, np.take_along_axis(rest, k[None], axis=0)[0]

    u = np.linspace(low[1 - i], high[1 - i], ACROSS + 1)
    allowed = best(u)[1] > 0
    pieces = []
    if not allowed.any():
        raise NotReached(f"energy {energy:g} reaches less of the section {name}={at:g} than can be seen")
    for first, last in _runs(allowed):
        ends = [
            _bisected(lambda x: best(x)[1] > 0, u[[k]], u[[k + step]])[0] if 0 <= k + step < u.size else u[k]
            for k, step in ((first, -1), (last, 1))
        ]
        dense = ends[0] + (ends[1] - ends[0]) * (1 - np.cos(np.linspace(0, np.pi, points))) / 2
        is_in = partial(_positive, room, dense)
        middle = best(dense)[0]
        sides = [_bisected(is_in, middle, np.full(points, ends[3 - i])) for ends in (low, high)]
        pieces.append(Sides(dense, *sides))
    return pieces


def _positive(room: Any, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.asarray(room(u, v) > 0)


def _runs(allowed: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and the last number of each run of true entries."""
    steps = np.diff(np.concatenate([[0], allowed.astype(np.int64), [0]]))
    return list(zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1) - 1, strict=True))


def _bisected(is_in: Any, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Return the last points on the way from inner to outer ones that are in."""
    for _ in range(HALVINGS):
        middle = (inner + outer) / 2
        kept = is_in(middle)
        inner = np.where(kept, middle, inner)
        outer = np.where(kept, outer, middle)
    return inner
