"""Driven systems beside natural ones of the same force, side by side. Run: pytest bench/test_driven.py -s"""

from __future__ import annotations

import time

import numpy as np
import pytest
from common import ORBITS

from fastaff import KAHAN_LI8, hamiltonian, integrate

STEPS, STEP = 250, 0.05
WAVES = "-cos(x) - a*cos(x - {t})"
DUFFING = "-x**2/2 + x**4/4 - a*x*cos({t})"
PAIRS = {
    "pendulum and a wave": (WAVES, "y", WAVES),
    "Duffing": (DUFFING, "y", DUFFING),
    "pendulum and a wave, at rest": (WAVES, None, "-cos(x) - a*cos(x - 0.3)"),
}
"""The potential of a driven system; the coordinate that stands for its time in a natural one with the same force, None
where that has one degree of freedom; the natural potential."""


@pytest.mark.parametrize("name", PAIRS)
def test_as_fast_as_a_natural_system(benchmark, name):
    """Million steps/s of both, in turns, and the energy errors after 250 steps: at least 0.8 of the natural one's."""
    text, other, natural = PAIRS[name]
    driven = hamiltonian(text.format(t="t"), coordinates="x", period="2*pi", a=0.05)
    plain = hamiltonian(natural.format(t=other), coordinates="x" if other is None else "x y", a=0.05)
    rng = np.random.default_rng(1)
    z0 = {"driven": np.array([rng.uniform(-1, 1, ORBITS), rng.uniform(-0.5, 0.5, ORBITS)])}
    rest = np.zeros(ORBITS)
    rows = z0["driven"] if other is None else np.array([z0["driven"][0], rest, z0["driven"][1], rest + 1.0])
    z0["natural"] = rows
    models, runs, shortest = {"driven": driven, "natural": plain}, {}, dict.fromkeys(("driven", "natural"), np.inf)
    for _ in range(25):
        for key, model in models.items():
            start = time.perf_counter()
            runs[key] = integrate(model, z0[key], time=STEP * STEPS, step=STEP, scheme=KAHAN_LI8)
            shortest[key] = min(shortest[key], time.perf_counter() - start)
    benchmark.pedantic(
        lambda: integrate(driven, z0["driven"], time=STEP * STEPS, step=STEP, scheme=KAHAN_LI8), rounds=3
    )
    rates = {key: ORBITS * STEPS / least / 1e6 for key, least in shortest.items()}
    errors = {key: float(run.energy_error.max()) for key, run in runs.items()}
    ratio = rates["driven"] / rates["natural"]
    print(
        f"\n{name}: driven {rates['driven']:.2f} M steps/s (energy error {errors['driven']:.1e}), natural "
        f"{rates['natural']:.2f} ({errors['natural']:.1e}), ratio {ratio:.2f}"
    )
    benchmark.extra_info.update(ratio=ratio, rates=rates, errors=errors)
