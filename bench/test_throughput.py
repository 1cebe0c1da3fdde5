"""Steps per second against a naive scalar loop, thread scaling and memory. Run: pytest bench/test_throughput.py -s"""

from __future__ import annotations

import tracemalloc

import numba
import numpy as np
import pytest
from common import (
    NEO,
    ORBITS,
    alternating,
    best,
    hyperelastic_orbits,
    naive_henon_heiles,
    naive_hyperelastic,
    neo_hookean_orbits,
)

from fastaff import (
    KAHAN_LI8,
    YOSHIDA4,
    AlphaTurning,
    Body,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    integrate,
    poincare_map,
)

BODY = Body(Hyperelastic(1.0), 1.0)
SCHEMES = [(YOSHIDA4, 0.01, 2000), (KAHAN_LI8, 0.05, 500)]


@pytest.mark.parametrize(("scheme", "step", "steps"), SCHEMES, ids=[s.name for s, _, _ in SCHEMES])
def test_against_scalar_loop(numbers, timed, scheme, step, steps):
    """4096 orbits of EQ2.2h: lane blocks against the scalar loop on the same threads, and two threads against one."""
    z0 = hyperelastic_orbits()
    threads = numba.config.NUMBA_NUM_THREADS

    def ours(count):
        return integrate(BODY, z0, time=step * steps, step=step, scheme=scheme, threads=count)

    def naive():
        z = z0.copy()
        naive_hyperelastic(z, 1.0, 1.0, scheme.drift_array, scheme.kick_array, step, steps)
        return z

    result = ours(threads)
    difference = np.abs(result.z - naive()).max()
    slow, one, all_ = best(naive, repeats=3), best(lambda: ours(1)), timed(lambda: ours(threads))
    numbers.update(
        rate=ORBITS * steps / all_,
        over_scalar_loop=slow / all_,
        threads=threads,
        over_one_thread=one / all_,
        energy_error=result.energy_error.max(),
        step=step,
        difference=difference,
    )
    assert difference < 1e-9


def test_memory_is_flat(numbers):
    """Peak memory of a run does not depend on the number of steps."""
    z0 = hyperelastic_orbits()
    peaks = []
    for time in (1.0, 10.0, 100.0):
        tracemalloc.start()
        integrate(BODY, z0, time=time, step=0.05)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    numbers.update(peak_MiB=max(peaks) / 2**20, z0_MiB=z0.nbytes / 2**20)
    assert max(peaks) < 1.05 * min(peaks)


def test_henon_heiles(numbers, timed):
    """One orbit against a scalar loop of the same scheme, and a grid of 1000."""
    model, steps, step, scheme = HenonHeiles(), 200_000, 0.05, KAHAN_LI8
    one = np.array([[0.0], [0.1], [0.4], [0.2]])
    many = one + 0.01 * np.random.default_rng(2).standard_normal((4, 1000))

    def naive():
        z = one.copy()
        naive_henon_heiles(z, 1.0, scheme.drift_array, scheme.kick_array, step, steps)
        return z

    def single():
        return integrate(model, one, time=steps * step, step=step, scheme=scheme)

    def grid():
        return integrate(model, many, time=2000 * step, step=step, scheme=scheme)

    result = single()
    slow, fast, wide = best(naive, repeats=3), best(single, repeats=3), timed(grid)
    numbers.update(
        over_scalar_loop=fast / slow,
        rate=2e6 / wide,
        energy_error=result.energy_error.max(),
        difference=np.abs(result.z - naive()).max(),
    )


def test_henon_heiles_section(numbers, timed):
    """Crossings per second of x = 0 by 1000 orbits."""
    many = np.array([[0.0], [0.1], [0.4], [0.2]]) + 0.01 * np.random.default_rng(2).standard_normal((4, 1000))

    def run():
        return poincare_map(
            HenonHeiles(), many, section=Hyperplane((1, 0, 0, 0)), crossings=100, max_time=2000.0, step=0.1
        )

    time, result = timed(run, repeats=3), run()
    numbers.update(
        rate=result.counts.sum() / time,
        section_error=result.section_error.max(),
        energy_error=result.energy_error.max(),
    )


def test_section_over_the_integration(numbers):
    """Processor time of `poincare_map` over that of `integrate` with the same step, in alternating runs."""
    section, time, step, z0 = AlphaTurning(+1), 400.0, 0.04, neo_hookean_orbits(40, 41)
    runs = {
        "integrate": lambda: integrate(NEO, z0, time=time, step=step),
        "poincare_map": lambda: poincare_map(NEO, z0, section=section, crossings=200, max_time=time, step=step),
    }
    results, cost = alternating(runs, repeats=5)
    found = results["poincare_map"]
    numbers.update(
        orbits=z0.shape[1],
        ratio=cost["poincare_map"] / cost["integrate"],
        steps_per_crossing=z0.shape[1] * time / step / np.isfinite(found.times).sum(),
        section_error=found.section_error.max(),
        energy_error=found.energy_error.max(),
    )
