"""Orbits, signals, timing and the naive scalar loops that the benchmarks share."""

from __future__ import annotations

import time

import numba
import numpy as np

from fastaff import AlphaTurning, Body, HenonHeiles, Hyperplane, NeoHookean, energy_grid

ORBITS = 4096
SAMPLES, SIGNALS = 8192, 1000
NEO = Body(NeoHookean(G=1.0, K=2.0))


def hyperelastic_orbits(orbits: int = ORBITS) -> np.ndarray:
    """Return z0 (8, orbits) around alpha = 1.5, beta = 0.3 with a spread of 0.1 (seed 1)."""
    z0 = np.zeros((8, orbits))
    z0[0], z0[2] = 1.5, 0.3
    return z0 + 0.1 * np.random.default_rng(1).standard_normal(z0.shape)


def henon_heiles_orbits(orbits: int = 1024) -> np.ndarray:
    """Return z0 (4, orbits) on x = 0 at E = 1/8, a random choice of a grid (seed 0)."""
    axes = (np.linspace(-0.4, 0.6, 60), np.linspace(-0.45, 0.45, 60))
    z0 = energy_grid(HenonHeiles(), energy=1 / 8, section=Hyperplane((1.0, 0.0, 0.0, 0.0)), axes=axes).z0
    return np.ascontiguousarray(z0[:, np.random.default_rng(0).choice(z0.shape[1], orbits, replace=False)])


def mixed_orbits(each: int) -> np.ndarray:
    """Return z0 (4, 4 each) on x = 0 of Henon-Heiles at E = 1/12, 1/8, 1/7, 1/6.2: regular to mostly chaotic ones."""
    axes = (np.linspace(-0.45, 0.9, 60), np.linspace(-0.55, 0.55, 60))
    rng, parts = np.random.default_rng(3), []
    for energy in (1 / 12, 1 / 8, 1 / 7, 1 / 6.2):
        z0 = energy_grid(HenonHeiles(), energy=energy, section=Hyperplane((1.0, 0.0, 0.0, 0.0)), axes=axes).z0
        parts.append(z0[:, rng.choice(z0.shape[1], each, replace=False)])
    return np.concatenate(parts, axis=1)


def neo_hookean_orbits(*cells: int) -> np.ndarray:
    """Return z0 (8, orbits) of the neo-Hookean body at E = 1.5 on a grid of so many beta and p_beta, p_alpha = 0."""
    axes = np.linspace(0.05, 1.3, cells[0]), np.linspace(-1.5, 1.5, cells[1])
    return energy_grid(NEO, energy=1.5, p_eta=0.3, p_gamma=0.2, section=AlphaTurning(+1), axes=axes).z0


def energy_error(z: np.ndarray, z0: np.ndarray) -> float:
    """Return the largest |E - E0|/(T0 + |V0|) over orbits (4, orbits)."""
    model = HenonHeiles()
    energy = [model.kinetic_energy(*s[2:]) + model.potential_energy(*s[:2]) for s in (z, z0)]
    return float(
        np.abs(
            (energy[0] - energy[1]) / (model.kinetic_energy(*z0[2:]) + np.abs(model.potential_energy(*z0[:2])))
        ).max()
    )


def signals_of(lines: int, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return signals (SIGNALS, SAMPLES) and their frequencies (SIGNALS, lines), 3 bins apart or more."""
    rng = np.random.default_rng(1)
    gaps = rng.exponential(size=(SIGNALS, lines))
    gaps = 3 / SAMPLES + gaps / gaps.sum(1, keepdims=True) * (1 - 3 * lines / SAMPLES)
    nu = (np.cumsum(gaps, 1) + rng.random((SIGNALS, 1))) % 1.0 - 0.5
    size = 10 ** -np.linspace(0, 2, lines) * np.exp(2j * np.pi * rng.random((SIGNALS, lines)))
    signals = np.zeros((SIGNALS, SAMPLES), complex)
    for k in range(lines):
        turns = nu[:, k, None] * np.arange(SAMPLES)
        signals += size[:, k, None] * np.exp(2j * np.pi * (turns - np.rint(turns)))
    if noise:
        signals += noise * rng.normal(size=(SIGNALS, SAMPLES, 2)).view(complex)[..., 0]
    return signals, nu


def best(function, *, repeats: int = 5) -> float:
    """Return the shortest of a few run times of function(), the first run (warm-up) left out."""
    function()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def alternating(runs: dict, *, repeats: int, clock=time.process_time) -> tuple[dict, dict]:
    """Return the results of functions by name and their shortest processor times, or those of another clock, taken in
    turns: for ratios.
    """
    results, cost = {name: run() for name, run in runs.items()}, dict.fromkeys(runs, np.inf)
    for _ in range(repeats):
        for name, run in runs.items():
            start = clock()
            run()
            cost[name] = min(cost[name], clock() - start)
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


def batched(integrator, z0, time):
    """Return the ends of orbits by a batch integrator of heyoka, on one thread, set anew for each batch."""
    z, width = np.empty_like(z0), integrator.batch_size
    for first in range(0, z0.shape[1], width):
        integrator.set_time(0.0)
        integrator.state[:] = z0[:, first : first + width]
        integrator.propagate_until(time)
        z[:, first : first + width] = integrator.state
    return z
