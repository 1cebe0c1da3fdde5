"""Indicators of chaos: a MEGNO map, the cost of tangent vectors and of every indicator, errors beside times.

The multiples of `integrate` by themselves: `python bench/test_chaos.py`.
"""

from __future__ import annotations

import time

import numpy as np
import pytest
from common import alternating, best, henon_heiles_orbits

import fastaff
from fastaff import (
    FLI,
    GALI,
    MEGNO,
    OFLI,
    SALI,
    BirkhoffDigits,
    FrequencyDiffusion,
    HenonHeiles,
    Lyapunov,
    LyapunovSpectrum,
    ReversibilityError,
    ZeroOne,
    chaos_map,
    integrate,
)

ALL = (Lyapunov(), FLI(), OFLI(), MEGNO(), SALI(), GALI(2), BirkhoffDigits(), ZeroOne(), FrequencyDiffusion())
"""All that take two tangent vectors or none."""

SETS = {
    **{entry.name: (entry,) for entry in (*ALL, ReversibilityError())},
    "megno, sali, fli": (MEGNO(), SALI(), FLI()),
    "all but frequencies": ALL[:-1],
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


def test_megno_map(benchmark):
    """256 x 256 cells of the neo-Hookean section over 200 natural periods: orbit-steps per second, with and without
    early stop.
    """
    from fastaff.flows.motion import typical_rate

    body, z0 = neo_hookean_grid(256)
    span = 200 * 2 * np.pi / typical_rate(body, z0)
    for early in (False, True):
        start = time.perf_counter()
        if early:
            found = chaos_map(body, z0, time=span, indicators=(MEGNO(),), early_stop=True)
        else:
            found = benchmark.pedantic(
                lambda: chaos_map(body, z0, time=span, indicators=(MEGNO(),)), warmup_rounds=0, rounds=1
            )
        seconds = time.perf_counter() - start
        steps = found.t.sum() / found.step
        print(
            f"\nMEGNO map, early stop {early}: {z0.shape[1]} orbits, T = {span:.0f}, step {found.step:.3g}: "
            f"{seconds:.1f} s, "
            f"{steps / seconds / 1e6:.1f} M orbit-steps/s with a tangent vector each; energy error "
            f"{np.median(found.energy_error):.1e} "
            f"(median), {found.energy_error.max():.1e} (largest); {found.summary()}"
        )


@pytest.mark.parametrize("name", ["henon-heiles", "neo-hookean"])
def test_cost_of_tangent_vectors(benchmark, name):
    """A pass with tangent vectors beside a plain one, for each pair of vectors."""
    if name == "henon-heiles":
        model, z0 = HenonHeiles(), henon_heiles_orbits()
    else:
        model, z0 = neo_hookean_grid(40)
    z0, size = np.ascontiguousarray(z0[:, :1024]), len(z0)
    run = {"time": 100.0, "step": 0.1}
    benchmark.pedantic(lambda: fastaff.integrate(model, z0, **run), warmup_rounds=1, rounds=10)
    plain = benchmark.stats.stats.min
    print(f"\n{name}: plain {plain * 1e3:.1f} ms")
    for count in range(2, size + 1, 2):
        deviations = np.eye(size)[:count]
        tangent = best(
            lambda deviations=deviations: fastaff.tangent_map(model, z0, deviations=deviations, **run), repeats=7
        )
        pair = 2 * (tangent / plain - 1) / count
        print(
            f"  {count} vectors: {tangent * 1e3:.1f} ms, {tangent / plain:.2f} of the plain pass, {pair:.2f} for each "
            "pair"
        )
    for indicators in ((MEGNO(),), (SALI(),), (SALI(), MEGNO(), LyapunovSpectrum())):
        seconds = best(lambda indicators=indicators: chaos_map(model, z0, indicators=indicators, **run), repeats=5)
        print(
            f"  chaos {', '.join(type(entry).__name__ for entry in indicators)}: {seconds * 1e3:.1f} ms, "
            f"{seconds / plain:.2f}"
        )


@pytest.mark.parametrize("name", ["henon-heiles", "neo-hookean"])
def test_indicators_as_multiples_of_an_integration(name):
    """Every indicator by itself, and together, beside `integrate` with the same step, in turns; one thread."""
    print(multiples(name))


def multiples(name: str, *, orbits: int = 1024, repeats: int = 5) -> str:
    """Return a table of what indicators cost, as multiples of `integrate`: processor times of runs in turns."""
    if name == "henon-heiles":
        model, z0, run = HenonHeiles(), henon_heiles_orbits(), {"time": 1000.0, "step": 0.1, "threads": 1}
    else:
        model, z0 = neo_hookean_grid(44)
        run = {"time": 400.0, "step": 0.04, "threads": 1}
    z0 = np.ascontiguousarray(z0[:, :orbits])

    def judged(indicators):
        return lambda: chaos_map(model, z0, indicators=indicators, **run)

    runs = {"integrate": lambda: integrate(model, z0, **run), **{key: judged(entry) for key, entry in SETS.items()}}
    found, cost = alternating(runs, repeats=repeats)
    plain = cost["integrate"]
    drift = np.median(found["integrate"].energy_error)
    lines = [f"{name}: {z0.shape[1]} orbits, {plain * 1e3:.1f} ms each pass, energy error {drift:.1e} (median)"]
    for key, indicators in SETS.items():
        n = model.degrees_of_freedom
        vectors = max(entry.vectors(n) if hasattr(entry, "vectors") else 0 for entry in indicators)
        bound = 1.3 * (1 + vectors)
        lines.append(f"  {key:20} {cost[key] / plain:6.2f}  ({vectors} vectors: {bound:.1f})")
    return "\n".join(lines)


if __name__ == "__main__":
    for model_name in ("henon-heiles", "neo-hookean"):
        print(multiples(model_name), flush=True)
