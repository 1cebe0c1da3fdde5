"""Resonance modules of frequency maps and section orbits per second, with their errors. Run: pytest
bench/test_resonance.py -s
"""

from __future__ import annotations

import numba
import numpy as np
import pytest
from common import best

from fastaff.analysis.frequencies.resonances import resonances, vectors
from fastaff.analysis.sections.islands import Kind, islands, rotation_number

SIDE, ORDER = 512, 12
SHARE = 8  # the scalar loop does one orbit of so many


@numba.njit(parallel=True, error_model="numpy")
def naive_count(k, nu, width, found):
    """The loop that one writes first: an orbit at a time, all vectors; counts the relations."""
    for o in numba.prange(nu.shape[1]):
        count = 0
        for v in range(k.shape[0]):
            distance = allowed = 0.0
            for i in range(nu.shape[0]):
                distance += k[v, i] * nu[i, o]
                allowed += abs(k[v, i]) * width[i, o]
            if abs(distance) <= allowed:
                count += 1
        found[o] = count


def frequencies(case: str) -> np.ndarray:
    """Return nu (4, SIDE, SIDE): random, or with nu_1 = nu_2 and nu_1 = 2 (nu_3 + nu_4) as in EQa, or periodic."""
    nu = np.random.default_rng(1).uniform(0.2, 1.0, (4, SIDE, SIDE))
    if case != "random":
        nu[0] = nu[1] = 2 * (nu[2] + nu[3])
    if case == "periodic":
        nu[:] = np.array([1.0, 1.0, 0.5, 0.0])[:, None, None]
    return nu


@pytest.mark.parametrize(("case", "rank"), [("random", 0), ("degenerate", 2), ("periodic", 3)])
def test_map(benchmark, case, rank):
    """512 x 512 orbits, n = 4, order 12: time, share with the right rank against the accidents expected."""
    nu, threads = frequencies(case), numba.config.NUMBA_NUM_THREADS
    result = resonances(nu, max_order=ORDER)
    k = vectors(4, ORDER)
    flat = np.ascontiguousarray(nu.reshape(4, -1)[:, ::SHARE])
    count = np.zeros(flat.shape[1], np.int64)
    width = np.broadcast_to(1e-9 * np.abs(flat).max(axis=0), flat.shape).copy()
    slow = SHARE * best(lambda: naive_count(k, flat, width, count), repeats=1)
    one, all_ = (best(lambda t=t: resonances(nu, max_order=ORDER, threads=t), repeats=3) for t in (1, threads))
    benchmark.pedantic(resonances, args=(nu,), kwargs={"max_order": ORDER}, rounds=3)
    wrong = int(np.count_nonzero(result.rank != rank))
    differ = int(np.count_nonzero((count > 0) != (result.rank.ravel()[::SHARE] > 0)))
    largest = np.nanmax(result.distance / result.width) if np.isfinite(result.distance).any() else 0.0
    rate = len(k) * SIDE**2 / all_ / 1e9
    benchmark.extra_info.update(seconds=all_, wrong=wrong, rate=rate, ratio_of_threads=one / all_, naive_seconds=slow)
    print(
        f"\n{case}: {SIDE} x {SIDE} orbits, {len(k)} vectors: {all_:.2f} s on {threads} threads ({rate:.1f} thousand "
        "million tests/s), "
        f"{one / all_:.2f} x one thread; orbit-at-a-time loop (counting only) {slow:.2f} s; {wrong} of other rank than "
        f"{rank}, "
        f"{float(result.accidental.sum()):.1f} accidents expected; {differ} disagreements with the loop; "
        f"largest distance/width {largest:.1e}"
    )
    assert differ == 0


def test_sections(benchmark):
    """1000 orbits of 1000 crossings of the standard map at K = 0.9: time of rotation numbers and of islands."""
    y = np.linspace(0.0, 0.5, 1002)[1:-1]
    path = np.empty((2, 1000, 1000))
    x = np.full(y.shape, 0.5)
    for n in range(1000):
        y = y + 0.9 / (2 * np.pi) * np.sin(2 * np.pi * x)
        x = x + y
        path[0, n], path[1, n] = (3 + y) * np.cos(2 * np.pi * x), (3 + y) * np.sin(2 * np.pi * x)
    golden = (np.sqrt(5) - 1) / 2 - 1
    t = 2 * np.pi * golden * np.arange(1000)
    error = abs(rotation_number(np.array([np.cos(t), 0.5 * np.sin(t)])).rotation[0] - golden)
    turning = best(lambda: rotation_number(path, centre=(0.0, 0.0)), repeats=3)
    found = benchmark.pedantic(lambda: islands(path, centre=(0.0, 0.0)), rounds=3, warmup_rounds=1)
    kinds = {kind.name: int((found.kind == kind).sum()) for kind in Kind}
    benchmark.extra_info.update(rotation_seconds=turning, rotation_error=error, **kinds)
    print(
        f"\n1000 orbits x 1000 crossings: rotation numbers {turning:.2f} s, islands {benchmark.stats['min']:.2f} s; "
        "golden ellipse off by "
        f"{error:.1e}; {found.summary()}"
    )
