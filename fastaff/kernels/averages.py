"""Averages along orbits, which give the natural frequency."""

from __future__ import annotations

import numpy as np

from ..compile.jit import jit


@jit
def scales(W, force, velocity, momentum, kinetic, rate, largest):
    """Set rate (orbits,) to (<F.W F>/<p.v>)^(1/2) of all samples that are finite, largest to their largest T.

    W (n, n, orbits); force, velocity, momentum (n, samples, orbits); kinetic (samples, orbits).
    """
    n, samples, orbits = force.shape
    pull, move, turned = np.zeros(orbits), np.zeros(orbits), np.empty(orbits)
    pulled, moved = np.empty(orbits), np.empty(orbits)
    largest[:] = -np.inf
    for s in range(samples):  # loops over orbits innermost: vectors
        pulled[:], moved[:] = 0.0, 0.0
        for i in range(n):
            turned[:] = 0.0
            for j in range(n):
                for o in range(orbits):
                    turned[o] += W[i, j, o] * force[j, s, o]
            for o in range(orbits):
                pulled[o] += force[i, s, o] * turned[o]
                moved[o] += momentum[i, s, o] * velocity[i, s, o]
        for o in range(orbits):
            T = kinetic[s, o]
            sound = np.isfinite(pulled[o]) and np.isfinite(moved[o]) and np.isfinite(T)
            pull[o] += pulled[o] if sound else 0.0
            move[o] += moved[o] if sound else 0.0
            largest[o] = max(largest[o], T if sound else 0.0)
    for o in range(orbits):
        rate[o] = np.sqrt(np.divide(pull[o], move[o]))


@jit
def extents(q, step, reach, speed):
    """Set reach (n, orbits) to the largest |q| of samples (n, samples, orbits) at equal steps (orbits,), speed to the
    largest |q'|; samples that are not finite do not count, and there is 0 without any.
    """
    n, samples, orbits = q.shape
    for i in range(n):
        reach[i, :], speed[i, :] = 0.0, 0.0
        for s in range(samples):
            for o in range(orbits):
                away = abs(q[i, s, o])
                moved = abs(q[i, s, o] - q[i, s - 1, o]) if s > 0 else 0.0
                reach[i, o] = away if away > reach[i, o] else reach[i, o]
                speed[i, o] = moved if moved > speed[i, o] else speed[i, o]
        for o in range(orbits):
            speed[i, o] /= step[o]
