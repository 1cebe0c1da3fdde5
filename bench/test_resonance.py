"""Resonance modules of frequency maps and section orbits per second, with their errors. Run: pytest
bench/test_resonance.py -s
"""

from __future__ import annotations

import numba
import numpy as np
import pytest
from common import best

from fastaff import Classification
from fastaff.frequencies.resonances import resonances, vectors
from fastaff.sections.islands import islands, rotation_number

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
def test_map(numbers, case, rank):
    """512 x 512 orbits, n = 4, order 12: time, share with the right rank against the accidents expected."""
    nu, threads = frequencies(case), numba.config.NUMBA_NUM_THREADS
    result = resonances(nu, max_order=ORDER)
    k = vectors(4, ORDER)
    flat = np.ascontiguousarray(nu.reshape(4, -1)[:, ::SHARE])
    count = np.zeros(flat.shape[1], np.int64)
    width = np.broadcast_to(1e-9 * np.abs(flat).max(axis=0), flat.shape).copy()
    slow = SHARE * best(lambda: naive_count(k, flat, width, count), repeats=1)
    one, all_ = (best(lambda t=t: resonances(nu, max_order=ORDER, threads=t), repeats=3) for t in (1, threads))
    differ = int(np.count_nonzero((count > 0) != (result.rank.ravel()[::SHARE] > 0)))
    numbers.update(
        seconds=all_,
        over_one_thread=one / all_,
        scalar_loop_seconds=slow,
        tests_a_second=len(k) * SIDE**2 / all_,
        other_rank=np.count_nonzero(result.rank != rank),
        expected=float(result.accidental.sum()),
    )
    assert differ == 0


def test_sections(numbers, timed):
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
    found = islands(path, centre=(0.0, 0.0))
    kinds = {kind.name: int((found.classification == kind).sum()) for kind in Classification}
    seconds = timed(lambda: islands(path, centre=(0.0, 0.0)), repeats=3)
    numbers.update(rotation_seconds=turning, islands_seconds=seconds, rotation_error=error, **kinds)
