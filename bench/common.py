"""Orbits, the naive scalar loops and the higher-precision reference that the benchmarks share."""

from __future__ import annotations

import time

import numba
import numpy as np

ORBITS = 4096


def hyperelastic_orbits(orbits: int = ORBITS) -> np.ndarray:
    """Return z0 (8, orbits) around alpha = 1.5, beta = 0.3 with a spread of 0.1 (seed 1)."""
    z0 = np.zeros((8, orbits))
    z0[0], z0[2] = 1.5, 0.3
    return z0 + 0.1 * np.random.default_rng(1).standard_normal(z0.shape)


def best(function, *, repeats: int = 5) -> float:
    """Return the shortest of a few run times of function(), the first run (warm-up) left out."""
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def alternating(runs: dict, *, repeats: int) -> tuple[dict, dict]:
    """Return the results of functions by name and their shortest processor times, taken in turns: for ratios."""
    results, cost = {name: run() for name, run in runs.items()}, dict.fromkeys(runs, np.inf)
    for _ in range(repeats):
        for name, run in runs.items():
            start = time.process_time()
            run()
            cost[name] = min(cost[name], time.process_time() - start)
    return results, cost


@numba.njit(parallel=True, error_model="numpy")
def naive_hyperelastic(z, C, mu, drift, kick, h, steps):
    """The loop that one writes first: an orbit at a time, its state in scalars, parallel over orbits."""
    w = 1.0 / mu
    for o in numba.prange(z.shape[1]):
        a1, a2, b1, b2, p1, p2, p3, p4 = z[0, o], z[1, o], z[2, o], z[3, o], z[4, o], z[5, o], z[6, o], z[7, o]
        for _ in range(steps):
            for s in range(kick.size):
                d = drift[s] * h * w
                a1, a2, b1, b2 = a1 + d * p1, a2 + d * p2, b1 + d * p3, b2 + d * p4
                x = a1 * a1 + a2 * a2 - b1 * b1 - b2 * b2
                wall = 2.0 * C / (x * x)
                k = kick[s] * h
                fa, fb = -2.0 * (0.5 * C - wall) * k, -2.0 * (0.5 * C + wall) * k
                p1, p2, p3, p4 = p1 + fa * a1, p2 + fa * a2, p3 + fb * b1, p4 + fb * b2
            d = drift[kick.size] * h * w
            a1, a2, b1, b2 = a1 + d * p1, a2 + d * p2, b1 + d * p3, b2 + d * p4
        z[0, o], z[1, o], z[2, o], z[3, o], z[4, o], z[5, o], z[6, o], z[7, o] = a1, a2, b1, b2, p1, p2, p3, p4


@numba.njit(error_model="numpy")
def naive_henon_heiles(z, lam, drift, kick, h, steps):
    """The same for Henon-Heiles, serial: for a single orbit."""
    for o in range(z.shape[1]):
        x, y, px, py = z[0, o], z[1, o], z[2, o], z[3, o]
        for _ in range(steps):
            for s in range(kick.size):
                d, k = drift[s] * h, kick[s] * h
                x, y = x + d * px, y + d * py
                px, py = px + k * (-x - 2.0 * lam * x * y), py + k * (-y - lam * (x * x - y * y))
            d = drift[kick.size] * h
            x, y = x + d * px, y + d * py
        z[0, o], z[1, o], z[2, o], z[3, o] = x, y, px, py


def heyoka_system(hy, C: float = 1.0, mu: float = 1.0):
    """Return the equations of Body(Hyperelastic(C), mu) for heyoka."""
    q = hy.make_vars("a1", "a2", "b1", "b2")
    p = hy.make_vars("pa1", "pa2", "pb1", "pb2")
    x = q[0] ** 2 + q[1] ** 2 - q[2] ** 2 - q[3] ** 2
    wall = 2.0 * C / x**2
    slopes = [C / 2 - wall] * 2 + [C / 2 + wall] * 2
    return [(q[i], p[i] / mu) for i in range(4)] + [(p[i], -2.0 * slopes[i] * q[i]) for i in range(4)], q, p


def reference_states(hy, z0: np.ndarray, time: float) -> np.ndarray:
    """Integrate z0 (8, orbits) in 80-bit arithmetic with tolerance 1e-19."""
    extended = np.longdouble
    system, _, _ = heyoka_system(hy)
    ta = hy.taylor_adaptive(system, [extended(1)] * 8, tol=extended(1e-19), fp_type=extended)
    end = np.empty(z0.shape)
    for i in range(z0.shape[1]):
        ta.time = extended(0)
        ta.state[:] = z0[:, i]
        ta.propagate_until(extended(time))
        end[:, i] = ta.state
    return end
