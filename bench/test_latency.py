"""Time of a call on one orbit, Python included, and of first calls. Run: pytest bench/test_latency.py -s"""

from __future__ import annotations

import cold
import numpy as np
import pytest

from fastaff import (
    KAHAN_LI8,
    SOFRONIOU_SPALETTA10,
    Body,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    integrate,
    poincare_map,
)
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8

CALLS = 200
HENON_HEILES, START = HenonHeiles(), np.array([0.0, 0.1, 0.35, 0.1])
BODY, STRETCHED = Body(Hyperelastic(C=1.0)), np.array([1.5, 0.1, 0.3, 0.0, 0.1, 0.3, 0.2, 0.1])
X = Hyperplane((1, 0, 0, 0))


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
def test_short_calls(numbers, timed, name):
    """One orbit over a time that the kernels are through with in microseconds."""
    run = RUNS[name]
    least, result = timed(run, repeats=CALLS), run()
    error = result.error if getattr(result, "error", None) is not None else result.energy_error
    numbers.update(ms=1e3 * least, error=error.max())


@pytest.mark.parametrize(
    ("scheme", "step"), [(KAHAN_LI8, 0.08), (BLANES_CASAS_ESCORIHUELA8, 0.16)], ids=["KL8", "BCE8"]
)
def test_crossings_of_one_orbit(numbers, timed, scheme, step):
    """All crossings of Henon-Heiles until T = 2000, their times against a finer run of higher order."""

    def run(scheme=scheme, step=step):
        return poincare_map(HENON_HEILES, START, section=X, crossings=400, max_time=2000.0, step=step, scheme=scheme)

    least, found, fine = timed(run, repeats=30), run(), run(SOFRONIOU_SPALETTA10, 0.1)
    count = int(found.counts[0])
    numbers.update(
        crossings=count,
        us_each=1e6 * least / count,
        time_error=np.nanmax(np.abs(found.times - fine.times)),
        section_error=found.section_error.max(),
        energy_error=found.energy_error.max(),
    )


def test_first_calls(numbers):
    """The first section and the first frequency map of fresh processes, with the import of the package; seconds of
    processor time, with an empty cache and with a full one.
    """
    for how, seconds in zip(("cold", "warm"), cold.measured()):
        section = seconds["import"][0] + seconds["section"][0]
        numbers.update({f"{how}_section": section, f"{how}_map": section + seconds["frequency map"][0]})
