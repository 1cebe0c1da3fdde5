"""Averages along orbits, which give the natural frequency."""

from __future__ import annotations

import numpy as np

from ..jit import jit


@jit
def scales(W, force, velocity, momentum, kinetic, rate, largest):
    """Set rate (orbits,) to (<F.W F>/<p.v>)^(1/2) of all samples that are finite, largest to their largest T.

    W (n, n, orbits); force, velocity, momentum (n, samples, orbits); kinetic (samples, orbits).
    """
    n, samples, orbits = force.shape
    pull = np.zeros(orbits)
    move = np.zeros(orbits)
    turned = np.empty(orbits)
    pulled = np.empty(orbits)
    moved = np.empty(orbits)
    largest[:] = -np.inf
    for s in range(samples):  # loops over orbits innermost: vectors
        pulled[:] = 0.0
        moved[:] = 0.0
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
