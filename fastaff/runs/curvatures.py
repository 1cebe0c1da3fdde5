"""Angular frequencies of small displacements at a phase point, from differences of forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.sums import length, total
from ..systems.models.mechanics import System, stacked
from ..systems.models.pointwise import at_points

NUDGE = 1e-6
"""Relative displacement for the change of a force, or of rates."""

ITERATIONS = 8
"""Force differences that give the highest frequency: a frequency four times lower contributes only 1e-9."""


def fastest_rates(system: System, z: np.ndarray, step: Any) -> np.ndarray:
    """Return the highest angular frequency (orbits,) of small displacements from z (2n, orbits), even in a direction in
    which the orbit hardly moves: the root of the largest eigenvalue of W dF/dq, W = dv/dp, from below.

    By power iteration on differences of forces over a small part of |q| or of the path of a step, and the rate of a
    rotating frame. 0 where there is none.
    """
    if not system.newtonian:
        return linear_rates(system, z)
    n = z.shape[0] // 2
    q = z[:n]
    W = system.inverse_masses(z)
    with np.errstate(all="ignore"):
        way = length(_velocity(system, z[n:])) * np.where(np.isfinite(step), step, 0.0)
        size = NUDGE * np.maximum(length(system.without_time(q)), way)
        u = system.without_time(np.cos(np.arange(1, n + 1))[:, None] + np.zeros(q.shape))
        u = u / length(u)
        for _ in range(ITERATIONS):
            change = _turned(system, W, q, size * u) / (2 * size)
            growth = length(change)
            u = change / np.where(growth > 0, growth, 1.0)
    return np.sqrt(np.where(np.isfinite(growth), growth, 0.0)) + system.frame_rate


def linear_rates(system: System, z: np.ndarray) -> np.ndarray:
    """Return the largest size (orbits,) of the eigenvalues of the derivative of dz/dt of H(q, p) at z (2n, orbits); 0
    where it has none.
    """
    A = np.moveaxis(system.tangent_slopes(z[:, None], np.eye(len(z))[:, :, None]), -1, 0)
    known = np.isfinite(A).all(axis=(1, 2))
    return np.where(known, np.abs(np.linalg.eigvals(np.where(known[:, None, None], A, 0.0))).max(axis=1), 0.0)


def applied(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return matrix (n, n, ...) times vector (n, ...), in the same order for any number of orbits."""
    return np.array([total(row * vector) for row in matrix])


def first_rates(system: System, z: np.ndarray, W: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return first estimates of angular frequencies, from the curvature of V along force or velocity and from that of
    the path, at least those of a motion over the distance from the origin, or over `reach` (orbits,), inf where
    unknown: where the curvature vanishes there is no other scale. Also return the frequencies of small oscillations
    along a direction of no symmetry, 0 where there are none.
    """
    n = z.shape[0] // 2
    if not system.newtonian:
        linear = linear_rates(system, z)
        return np.where(linear > 0, linear, 1.0), linear
    with np.errstate(all="ignore"):
        v, p, F = seen(system, z)
        u = applied(W, F)
        distance, momentum, force, speed, pull = (
            length(x) for x in (*(system.without_time(x) for x in (z[:n], p, F)), v, u)
        )
        odd = np.sqrt(np.abs(np.array([W[i, i] for i in range(n)]))) * (1.0 + 0.618 * np.arange(n))[:, None]
        units = np.array([u / pull, v / speed, odd / length(odd)]).transpose(1, 0, 2)
        path = 0.3 * np.sqrt(force / momentum * pull / speed)
        wide = 0.3 * np.fmax(np.sqrt(pull / np.fmin(np.where(distance > 0, distance, np.inf), reach)), speed / reach)
        guesses = np.concatenate([[path, wide], _curvatures(system, z, W, units)])
    known = np.where(np.isfinite(guesses) & (guesses > 0), guesses, 0.0)
    stiff = known[2:4].max(axis=0)
    path = np.where(
        (stiff > 0) & (known[0] > 100 * stiff), 0.0, known[0]
    )  # next to a turning point the path turns sharply
    best = np.maximum(np.maximum(stiff, path), known[1])
    return np.where(best > 0, best, 1.0), known[4]


def _curvatures(system: System, z: np.ndarray, W: np.ndarray, units: np.ndarray) -> np.ndarray:
    """Return the angular frequencies (directions, orbits) of small oscillations along unit vectors (n, directions,
    orbits), from differences of forces; NaN where none.
    """
    q = z[: len(units), None]
    size = length(system.without_time(q))
    shift = NUDGE * np.where(size > 0, size, 1.0) * units
    with np.errstate(all="ignore"):
        return np.sqrt(length(_turned(system, W[:, :, None], q, shift)) / (2 * length(shift)))


def _turned(system: System, W: np.ndarray, q: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Return W times the change of the force (n, ...) from q - shift to q + shift."""
    above, below = np.moveaxis(_force(system, np.stack([q + shift, q - shift], axis=1)), 1, 0)
    return applied(W, above - below)


def seen(system: System, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return velocities, momenta and forces (n, ...) in the model's frame."""
    n = z.shape[0] // 2
    if system.frame:
        return system.without_time(system.velocities(z)), *system.seen(z)
    return _velocity(system, z[n:]), z[n:], _force(system, z[:n])


def _force(system: System, q: np.ndarray) -> np.ndarray:
    return stacked(at_points(system.model, "force", *q), q)


def _velocity(system: System, p: np.ndarray) -> np.ndarray:
    return system.without_time(stacked(at_points(system.model, "velocity", *p), p))
