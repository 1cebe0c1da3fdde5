"""What a call on one orbit takes, Python included. Run: pytest bench/test_latency.py -s"""

from __future__ import annotations

import numpy as np
import pytest
from common import best

from fastaff import KAHAN_LI8, SOFRONIOU_SPALETTA10, Body, HenonHeiles, Hyperelastic, Linear, integrate, poincare_map
from fastaff.schemes import BLANES_CASAS_ESCORIHUELA8

CALLS = 200
HENON_HEILES, START = HenonHeiles(), np.array([0.0, 0.1, 0.35, 0.1])
BODY, STRETCHED = Body(Hyperelastic(C=1.0)), np.array([1.5, 0.1, 0.3, 0.0, 0.1, 0.3, 0.2, 0.1])
X = Linear((1, 0, 0, 0))


RUNS = {
    "integrate, Henon-Heiles, step given": lambda: integrate(HENON_HEILES, START, time=1.0, step=0.01),
    "integrate, EQ2.2h, step given": lambda: integrate(BODY, STRETCHED, time=1.0, step=0.05),
    "integrate, Henon-Heiles, step chosen": lambda: integrate(HENON_HEILES, START, time=1.0),
    "integrate, EQ2.2h, step chosen": lambda: integrate(BODY, STRETCHED, time=1.0),
    "poincare_map, 3 crossings, step given": lambda: poincare_map(
        HENON_HEILES, START, section=X, crossings=3, max_time=100.0, step=0.1
    ),
    "poincare_map, 3 crossings, step chosen": lambda: poincare_map(
        HENON_HEILES, START, section=X, crossings=3, max_time=100.0
    ),
}


@pytest.mark.parametrize("name", RUNS)
def test_short_calls(benchmark, name):
    """One orbit over a time that the kernels are through with in microseconds."""
    run = RUNS[name]
    least, result = best(run, repeats=CALLS), run()
    benchmark(run)
    error = result.error.max() if getattr(result, "error", None) is not None else result.energy_error.max()
    print(f"\n{name}: {1e3 * least:.2f} ms; error {error:.1e}")


@pytest.mark.parametrize(
    ("scheme", "step"), [(KAHAN_LI8, 0.08), (BLANES_CASAS_ESCORIHUELA8, 0.16)], ids=["KL8", "BCE8"]
)
def test_crossings_of_one_orbit(benchmark, scheme, step):
    """All crossings of Henon-Heiles until T = 2000, their times against a finer run of higher order."""

    def run(scheme=scheme, step=step):
        return poincare_map(HENON_HEILES, START, section=X, crossings=400, max_time=2000.0, step=step, scheme=scheme)

    least, found, fine = best(run, repeats=30), run(), run(SOFRONIOU_SPALETTA10, 0.1)
    benchmark.pedantic(run, rounds=10)
    count = int(found.counts[0])
    error = np.nanmax(np.abs(found.times - fine.times))
    benchmark.extra_info.update(crossings=count, time_error=error)
    print(
        f"\n{scheme.name}, {count} crossings: {1e6 * least / count:.1f} microseconds each; times {error:.1e}, section "
        f"{found.section_error.max():.1e}, energy {found.energy_error.max():.1e}"
    )
