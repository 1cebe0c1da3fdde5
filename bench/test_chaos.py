"""Indicators of chaos: a MEGNO map, the cost of tangent vectors and of every indicator. Run: pytest
bench/test_chaos.py -s
"""

from __future__ import annotations

import time

import numpy as np
import pytest
from common import alternating, henon_heiles_orbits

import fastaff
from fastaff import (
    FLI,
    GALI,
    MEGNO,
    OFLI,
    SALI,
    FrequencyDiffusion,
    HenonHeiles,
    Lyapunov,
    ReversibilityError,
    WeightedBirkhoff,
    ZeroOneTest,
    chaos_map,
    integrate,
    tangent_map,
)
from fastaff.systems.models.mechanics import system_of

ALL = (Lyapunov(), FLI(), OFLI(), MEGNO(), SALI(), GALI(2), WeightedBirkhoff(), ZeroOneTest(), FrequencyDiffusion())
"""All that take two tangent vectors or none."""

SETS = {
    **{entry.name: (entry,) for entry in (*ALL, ReversibilityError())},
    "megno, sali, fli": (MEGNO(), SALI(), FLI()),
    "all": ALL,
}


def neo_hookean_grid(cells: int) -> tuple[fastaff.Body, np.ndarray]:
    """Return the demo's body and a grid of cells x cells on its section at E = 1.5."""
    from fastaff import plot

    body, section = fastaff.Body(fastaff.NeoHookean()), fastaff.AlphaTurning()
    where = {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2}
    axes = [
        low + (high - low) * (np.arange(cells) + 0.5) / cells for low, high in plot.edge(body, section, **where).axes
    ]
    return body, fastaff.energy_grid(body, section=section, axes=axes, **where).z0


def test_megno_map(numbers):
    """128 x 128 cells of the neo-Hookean section over 200 natural periods: orbit-steps per second, with and without
    early stop.
    """
    from fastaff.runs.scales import typical_rate

    body, z0 = neo_hookean_grid(128)
    span = 200 * 2 * np.pi / typical_rate(system_of(body), z0)
    chaos_map(body, z0[:, :8], time=1.0, indicators=(MEGNO(),))
    numbers.update(orbits=z0.shape[1], time=span)
    for how, early in (("", False), ("early_", True)):
        start = time.perf_counter()
        found = chaos_map(body, z0, time=span, indicators=(MEGNO(),), early_stop=early)
        seconds, steps = time.perf_counter() - start, (found.t / found.step).sum()
        numbers.update({f"{how}seconds": seconds, f"{how}rate": steps / seconds})
        numbers[f"{how}energy_error"] = found.energy_error.max()


@pytest.mark.parametrize("name", ["henon-heiles", "neo-hookean"])
def test_multiples_of_an_integration(numbers, name):
    """Tangent vectors, every indicator by itself, and together, beside `integrate` with the same step, in turns; one
    thread.
    """
    if name == "henon-heiles":
        model, z0, run = HenonHeiles(), henon_heiles_orbits(), {"time": 1000.0, "step": 0.1, "threads": 1}
    else:
        model, z0 = neo_hookean_grid(44)
        run = {"time": 400.0, "step": 0.04, "threads": 1}
    z0, size = np.ascontiguousarray(z0[:, :1024]), len(z0)
    runs = {"integrate": lambda: integrate(model, z0, **run)}
    for count in range(2, size + 1, 2):
        vectors = np.eye(size)[:count]
        runs[f"{count} vectors"] = lambda vectors=vectors: tangent_map(model, z0, deviation_vectors=vectors, **run)
    for key, chosen in SETS.items():
        runs[key] = lambda chosen=chosen: chaos_map(model, z0, indicators=chosen, **run)
    found, cost = alternating(runs, repeats=2)
    plain, drift = cost.pop("integrate"), found["integrate"].energy_error
    numbers.update(orbits=z0.shape[1], integrate_s=plain, energy_error=np.median(drift))
    numbers.update({key: seconds / plain for key, seconds in cost.items()})
    numbers["pair"] = 2 * (numbers[f"{size} vectors"] - 1) / size
