"""Steps per second against a naive scalar loop, thread scaling and memory. Run: pytest bench/test_throughput.py -s"""

from __future__ import annotations

import tracemalloc

import numba
import numpy as np
import pytest
from common import ORBITS, alternating, best, hyperelastic_orbits, naive_henon_heiles, naive_hyperelastic

from fastaff import (
    BLANES_MOAN6,
    KAHAN_LI8,
    SOFRONIOU_SPALETTA10,
    YOSHIDA4,
    AlphaTurning,
    Body,
    HenonHeiles,
    Hyperelastic,
    Linear,
    NeoHookean,
    energy_grid,
    integrate,
    poincare_map,
)

BODY = Body(Hyperelastic(1.0), 1.0)
SCHEMES = [(YOSHIDA4, 0.01, 2000), (BLANES_MOAN6, 0.05, 500), (KAHAN_LI8, 0.05, 500), (SOFRONIOU_SPALETTA10, 0.05, 250)]


@pytest.mark.parametrize(("scheme", "step", "steps"), SCHEMES, ids=[s.name for s, _, _ in SCHEMES])
def test_against_scalar_loop(benchmark, scheme, step, steps):
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
    slow, one, all_ = best(naive, repeats=3), best(lambda: ours(1)), best(lambda: ours(threads))
    benchmark.pedantic(ours, args=(threads,), rounds=3)
    benchmark.extra_info.update(
        msteps_per_s=ORBITS * steps / all_ / 1e6,
        ratio_to_scalar=slow / all_,
        threads=threads,
        ratio_of_threads=one / all_,
        energy_error=result.energy_error.max(),
        difference_to_scalar=difference,
    )
    print(
        f"\n{scheme.name}: {ORBITS * steps / all_ / 1e6:.1f} million steps/s on {threads} threads, {slow / all_:.1f} x "
        "the scalar loop "
        f"({ORBITS * steps / slow / 1e6:.1f}), {one / all_:.2f} x one thread; energy error "
        f"{result.energy_error.max():.1e}, "
        f"difference to the scalar loop {difference:.1e}"
    )
    assert difference < 1e-9


def test_memory_is_flat(benchmark):
    """Peak memory of a run does not depend on the number of steps."""
    z0 = hyperelastic_orbits()
    peaks = []
    for time in (1.0, 10.0, 100.0):
        tracemalloc.start()
        integrate(BODY, z0, time=time, step=0.05)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    benchmark.pedantic(lambda: integrate(BODY, z0, time=1.0, step=0.05), rounds=3)
    benchmark.extra_info["peaks"] = peaks
    print(
        f"\npeak memory at 20, 200, 2000 steps: {', '.join(f'{p / 2**20:.2f} MiB' for p in peaks)} (z0: "
        f"{z0.nbytes / 2**20:.2f} MiB)"
    )
    assert max(peaks) < 1.05 * min(peaks)


@pytest.mark.parametrize("scheme", [YOSHIDA4, KAHAN_LI8], ids=lambda s: s.name)
def test_henon_heiles(benchmark, scheme):
    """One orbit against a scalar loop of the same scheme, and a grid of 1000."""
    model, steps, step = HenonHeiles(), 200_000, 0.05
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

    difference = np.abs(single().z - naive()).max()
    slow, fast, wide = best(naive, repeats=3), best(single, repeats=3), best(grid)
    benchmark.pedantic(grid, rounds=3)
    benchmark.extra_info.update(
        single_ratio=fast / slow, grid_msteps_per_s=2.0 / wide, energy_error=single().energy_error.max()
    )
    print(
        f"\n{scheme.name}, Henon-Heiles: one orbit {steps / fast / 1e6:.2f} million steps/s, {fast / slow:.2f} x the "
        "scalar loop's time; "
        f"grid of 1000 {2.0 / wide:.0f} million steps/s; energy error {single().energy_error.max():.1e}, difference "
        f"{difference:.1e}"
    )


def test_call_overhead(benchmark):
    """The cost of a call that does almost nothing: one orbit, one step."""
    z0 = hyperelastic_orbits(1)
    benchmark(lambda: integrate(BODY, z0, time=0.05, step=0.05))


def test_henon_heiles_section(benchmark):
    """Crossings per second of x = 0 by 1000 orbits."""
    many = np.array([[0.0], [0.1], [0.4], [0.2]]) + 0.01 * np.random.default_rng(2).standard_normal((4, 1000))

    def run():
        return poincare_map(HenonHeiles(), many, section=Linear((1, 0, 0, 0)), crossings=100, max_time=2000.0, step=0.1)

    time, result = best(run, repeats=3), run()
    benchmark.pedantic(run, rounds=3)
    print(
        f"\nHenon-Heiles x = 0: {result.counts.sum() / time / 1e6:.2f} million crossings/s, section error "
        f"{result.section_error.max():.1e}, energy error {result.energy_error.max():.1e}"
    )


def test_section_over_the_integration(benchmark):
    """Processor time of `poincare_map` over that of `integrate` with the same step, in alternating runs."""
    body, section, time, step = Body(NeoHookean(G=1.0, K=2.0)), AlphaTurning(+1), 400.0, 0.04
    axes = np.linspace(0.05, 1.3, 40), np.linspace(-1.5, 1.5, 41)
    z0 = energy_grid(body, energy=1.5, p_eta=0.3, p_gamma=0.2, section=section, axes=axes).z0

    def cut():
        return poincare_map(body, z0, section=section, crossings=200, max_time=time, step=step)

    runs = {"integrate": lambda: integrate(body, z0, time=time, step=step), "poincare_map": cut}
    results, cost = alternating(runs, repeats=7)
    found = results["poincare_map"]
    benchmark.pedantic(cut, rounds=3)
    steps, crossings = z0.shape[1] * time / step, np.isfinite(found.times).sum()
    ratio = cost["poincare_map"] / cost["integrate"]
    benchmark.extra_info.update(ratio=ratio, steps_per_crossing=steps / crossings)
    print(
        f"\nneo-Hookean section, {z0.shape[1]} orbits, a crossing every {steps / crossings:.0f} steps: {ratio:.2f} of "
        f"the integration, {(ratio - 1) * steps / crossings:.0f} steps a crossing; section error "
        f"{found.section_error.max():.1e}, energy error {found.energy_error.max():.1e}"
    )
