"""Frequencies of the integrable bodies against dE/dJ by quadrature, and orbits per second. Run: pytest
bench/test_frequency.py -s
"""

from __future__ import annotations

import time

import naive
import numpy as np
import pytest
from common import alternating

from fastaff import (
    SOFRONIOU_SPALETTA10,
    AlphaTurning,
    Anharmonic,
    Body,
    Classification,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    NeoHookean,
    energy_grid,
    frequency_map,
    integrate,
)

ORBITS, TIME = 1000, 200 * np.pi
CASES = [(Harmonic(), 0.1), (Anharmonic(), 0.02), (Hyperelastic(), 0.01), (HeavyTop(1.0, 0.5), 0.01)]


def random_orbits(body: Body, orbits: int, seed: int = 1) -> np.ndarray:
    """Return bound orbits with normal random coordinates and momenta, at least 0.5 inside the potential's margin.

    A heavy top is bound where its angular momentum Lambda of R^4 is large enough to keep it from r = 0.
    """
    z = np.random.default_rng(seed).standard_normal((8, 8 * orbits))
    A, B = (z[:2] ** 2).sum(axis=0), (z[2:4] ** 2).sum(axis=0)
    inside = body.potential.margin(A, B) > 0.5
    if isinstance(body.potential, HeavyTop):
        radial = (z[:4] * z[4:]).sum(axis=0)
        kinetic = (A + B) * (z[4:] ** 2).sum(axis=0) - radial**2 + 2 * body.mu * body.potential.A * (A - B) / (A + B)
        inside &= kinetic > 2.2 * body.mu * abs(body.potential.A)
    return np.ascontiguousarray(z[:, inside][:, :orbits])


@pytest.mark.parametrize(("potential", "step"), CASES, ids=[type(p).__name__ for p, _ in CASES])
def test_against_quadrature(numbers, potential, step):
    """1000 random bound orbits over 200 periods pi of the radial motion: the share within 1e-11 of dE/dJ."""
    body = Body(potential)
    z0 = random_orbits(body, ORBITS)
    truth = naive.frequencies(body, z0)
    options = {"time": TIME, "scheme": SOFRONIOU_SPALETTA10, "step": step}
    frequency_map(body, z0[:, :8], **options)
    start = time.perf_counter()
    found = frequency_map(body, z0, **options)
    elapsed = time.perf_counter() - start
    values = np.array([*found.nu[:2], found.nu_eta, found.nu_gamma])
    scale = np.abs(truth).max(axis=0)
    error = (np.abs(values - truth) / scale).max(axis=0)
    estimate = (found.error / scale).max(axis=0)
    numbers.update(
        within=(error <= 1e-11).mean(),
        median_error=np.median(error),
        covered=(error <= np.maximum(estimate, 1e-11)).mean(),
        undecided=(found.classification == Classification.UNDECIDED).mean(),
        seconds=elapsed,
    )


def grids():
    """Return systems with their orbits, times and steps: a coupled body and a cheap force, regular and chaotic ones."""
    body, cubic = Body(NeoHookean()), HenonHeiles()
    axes = [np.linspace(0.05, 1.2, 60), np.linspace(-1.4, 1.4, 45)]
    orbits = energy_grid(body, energy=1.5, section=AlphaTurning(1), axes=axes, p_eta=0.3, p_gamma=0.2).z0
    axes = [np.linspace(-0.4, 0.6, 40), np.linspace(-0.45, 0.45, 40)]
    plane = energy_grid(cubic, energy=1 / 8, section=Hyperplane(normal=(1, 0, 0, 0)), axes=axes).z0
    return {
        "neo-Hookean, E = 1.5": (body, orbits[:, :1106], 400.0, 0.04),
        "Henon-Heiles, E = 1/8": (cubic, plane[:, :1106], 1000.0, 0.1),
    }


@pytest.mark.parametrize("name", ["neo-Hookean, E = 1.5", "Henon-Heiles, E = 1/8"])
def test_multiples_of_the_integration(numbers, name):
    """Processor time of a frequency map over that of `integrate` with the same step, in alternating runs."""
    body, z0, end, step = grids()[name]
    options = {"time": end, "step": step}
    runs = {
        "integrate": lambda: integrate(body, z0, **options),
        "default": lambda: frequency_map(body, z0, **options),
    }
    results, cost = alternating(runs, repeats=2)
    found = results["default"]
    own = found.classification == Classification.REGULAR
    relative = found.error[:, own].max(axis=0) / np.abs(found.nu[:, own]).max(axis=0)
    numbers.update(
        orbits=z0.shape[1],
        independent=own.sum(),
        integrate_s=cost["integrate"],
        default=cost["default"] / cost["integrate"],
        default_error=np.median(relative),
    )
