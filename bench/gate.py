"""A gate for CI: ratios of processor time within one run, alternating, under bounds that noise does not reach.

No time is compared with a number of another machine or day. Each bound is two to two and a half times the ratio it was
set for (the number before it), 1.4 times for frequency maps, so it stays silent under noise and speaks when something
becomes three times, or half as much, slower. A row above its bound is measured once more before it counts. Run: make
gate.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from common import alternating, hyperelastic_orbits, naive_henon_heiles, naive_hyperelastic

from fastaff import (
    KAHAN_LI8,
    SALI,
    YOSHIDA4,
    AlphaTurning,
    Body,
    HenonHeiles,
    Hyperelastic,
    Linear,
    chaos_map,
    frequency_map,
    integrate,
    poincare_map,
)
from fastaff.analysis.frequencies.naff import naff

BODY, PLANE = Body(Hyperelastic(1.0), 1.0), HenonHeiles()
AXIS = Linear((1, 0, 0, 0))
TIME, STEP = 100.0, 0.05


def naive(kernel, z0, scheme, *parameters):
    """Return a run of a scalar loop."""
    return lambda: kernel(z0.copy(), *parameters, scheme.drift_array, scheme.kick_array, STEP, round(TIME / STEP))


def rows():
    """Return (what, measured, bound, run, beside) for each ratio of the two runs' processor times."""
    grid, flat = hyperelastic_orbits(1024), np.array([[0.0], [0.1], [0.4], [0.14]])
    many = flat + 0.01 * np.random.default_rng(2).standard_normal((4, 1024))
    run = {"time": TIME, "step": STEP}
    signals = np.exp(2j * np.pi * np.outer(np.random.default_rng(3).random(100), np.arange(4096)))
    kahan = lambda z0, model: lambda: integrate(model, z0, **run)  # noqa: E731 the runs that others are beside
    yield (
        "integrate, YOSHIDA4, body / scalar loop",
        0.18,
        0.45,
        lambda: integrate(BODY, grid, scheme=YOSHIDA4, **run),
        naive(naive_hyperelastic, grid, YOSHIDA4, 1.0, 1.0),
    )
    yield (
        "integrate, KAHAN_LI8, body / scalar loop",
        0.1,
        0.25,
        kahan(grid, BODY),
        naive(naive_hyperelastic, grid, KAHAN_LI8, 1.0, 1.0),
    )
    yield (
        "integrate, one orbit of Henon-Heiles / scalar loop",
        1.1,
        2.2,
        lambda: integrate(PLANE, flat, time=100 * TIME, step=STEP),
        lambda: naive_henon_heiles(
            flat.copy(), 1.0, KAHAN_LI8.drift_array, KAHAN_LI8.kick_array, STEP, round(100 * TIME / STEP)
        ),
    )
    yield (
        "poincare_map / integrate, body",
        2.3,
        5.0,
        lambda: poincare_map(BODY, grid, section=AlphaTurning(+1), crossings=60, max_time=TIME, step=STEP),
        kahan(grid, BODY),
    )
    yield (
        "poincare_map / integrate, Henon-Heiles",
        2.6,
        5.5,
        lambda: poincare_map(PLANE, many, section=AXIS, crossings=30, max_time=TIME, step=STEP),
        kahan(many, PLANE),
    )
    yield (
        "poincare_map / integrate, one orbit of Henon-Heiles",
        2.05,
        4.2,
        lambda: poincare_map(PLANE, flat, section=AXIS, crossings=400, max_time=20 * TIME, step=STEP, threads=1),
        lambda: integrate(PLANE, flat, time=20 * TIME, step=STEP, threads=1),
    )
    yield (
        "frequency_map / integrate, body",
        5.7,
        8.0,
        lambda: frequency_map(BODY, grid[:, :256], **run),
        kahan(grid[:, :256], BODY),
    )
    yield (
        "frequency_map / integrate, Henon-Heiles",
        5.0,
        7.0,
        lambda: frequency_map(PLANE, many[:, :256], time=4 * TIME, step=STEP),
        lambda: integrate(PLANE, many[:, :256], time=4 * TIME, step=STEP),
    )
    yield (
        "chaos_map, SALI / integrate, Henon-Heiles",
        4.4,
        9.0,
        lambda: chaos_map(PLANE, many, indicators=(SALI(),), **run),
        kahan(many, PLANE),
    )
    yield (
        "naff / five FFTs of NumPy",
        0.58,
        1.3,
        lambda: naff(signals, 1.0, lines=1),
        lambda: [np.fft.fft(signals) for _ in range(5)],
    )


def ratio(run, beside) -> float:
    """Return the ratio of the shortest processor times of alternating runs."""
    _, cost = alternating({"run": run, "beside": beside}, repeats=5)
    return cost["run"] / cost["beside"]


def main() -> int:
    """Print the ratios; return how many are above their bounds."""
    start, failed = time.perf_counter(), 0
    for what, measured, bound, run, beside in rows():
        found = ratio(run, beside)
        if found > bound:
            found = min(found, ratio(run, beside))
        failed += found > bound
        said = f"ABOVE {bound}" if found > bound else f"bound {bound}"
        print(f"{what:52s} {found:6.2f}   (was {measured}, {said})", flush=True)
    print(f"{time.perf_counter() - start:.0f} s")
    return failed


if __name__ == "__main__":
    sys.exit(main())
