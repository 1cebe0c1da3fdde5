"""Models from formulas against the hand-written ones, side by side. Run: pytest bench/test_formula.py -s"""

from __future__ import annotations

import time

import numpy as np
import pytest
from common import ORBITS, alternating, hyperelastic_orbits

from fastaff import KAHAN_LI8, Body, HenonHeiles, Hyperelastic, NeoHookean, affine_body, hamiltonian, integrate

STEPS, STEP = 250, 0.05
HYPERELASTIC = "C/2*(D1**2 + D2**2) + C/(D1*D2)"
NEO_HOOKEAN = "G/2*(D1**2 + D2**2 - 2) - G*log(D1*D2) + K/2*(D1*D2 - 1)**2"
HENON_HEILES = "(x**2 + y**2)/2 + lam*(x**2*y - y**3/3)"


def henon_heiles_orbits() -> np.ndarray:
    """Return z0 (4, ORBITS), bounded."""
    return 0.25 * np.random.default_rng(1).uniform(-1, 1, (4, ORBITS))


PAIRS = [
    ("Hyperelastic", Body(Hyperelastic(1.0)), lambda: affine_body(HYPERELASTIC, C=1.0), hyperelastic_orbits),
    ("NeoHookean", Body(NeoHookean(1.0, 2.0)), lambda: affine_body(NEO_HOOKEAN, G=1.0, K=2.0), hyperelastic_orbits),
    ("HenonHeiles", HenonHeiles(1.0), lambda: hamiltonian(HENON_HEILES, lam=1.0), henon_heiles_orbits),
    (
        "HenonHeiles with masses",
        HenonHeiles(1.0),
        lambda: hamiltonian(HENON_HEILES, masses=(1.0, 1.0), lam=1.0),
        henon_heiles_orbits,
    ),
]


@pytest.mark.parametrize(("name", "hand", "make", "orbits"), PAIRS, ids=[p[0] for p in PAIRS])
def test_as_fast_as_hand_written(numbers, name, hand, make, orbits):
    """Steps per second of both, in turns, and the largest difference of the end states after 250 steps."""
    model, z0 = make(), orbits()
    run = {"time": STEP * STEPS, "step": STEP, "scheme": KAHAN_LI8}
    runs = {"hand": lambda: integrate(hand, z0, **run), "formula": lambda: integrate(model, z0, **run)}
    found, shortest = alternating(runs, repeats=25, clock=time.perf_counter)
    difference = np.nanmax(np.abs(found["hand"].z - found["formula"].z))
    numbers.update(
        speed=shortest["hand"] / shortest["formula"],
        rate=ORBITS * STEPS / shortest["formula"],
        difference=difference,
        energy_error=found["formula"].energy_error.max(),
    )
    assert difference < 1e-8
