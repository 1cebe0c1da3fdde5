"""Against heyoka's batch mode in one run, same orbits, same threads. Run: pytest bench/test_heyoka.py -s (extra
`peers`)
"""

from __future__ import annotations

import numba
import numpy as np
import pytest
from common import ORBITS, best, heyoka_system, hyperelastic_orbits, reference_states

from fastaff import BLANES_MOAN6, SOFRONIOU_SPALETTA10, AlphaTurning, Body, Hyperelastic, integrate, poincare_map

hy = pytest.importorskip("heyoka")
BODY = Body(Hyperelastic(1.0), 1.0)
TIME = 200.0
CHECKED = 64


def batches(ta, z0, time, threads, reset=lambda t: None):
    """Propagate z0 (8, orbits) through an ensemble of batch integrators; return the integrators."""
    width = ta.state.shape[1]

    def start(t, i):
        t.state[:] = z0[:, i * width : (i + 1) * width]
        t.set_time(0.0)
        reset(t)
        return t

    return hy.ensemble_propagate_until_batch(
        ta, time, z0.shape[1] // width, start, algorithm="thread", max_workers=threads
    )


@pytest.mark.parametrize(("tol", "scheme", "step"), [(1e-15, SOFRONIOU_SPALETTA10, 0.088), (1e-9, BLANES_MOAN6, 0.1)])
def test_end_states(benchmark, tol, scheme, step):
    """4096 orbits of EQ2.2h to T = 200: time, and error against 80-bit arithmetic on 64 of them."""
    z0, threads = hyperelastic_orbits(), numba.config.NUMBA_NUM_THREADS
    truth = reference_states(hy, z0[:, :CHECKED], TIME)
    ta = hy.taylor_adaptive_batch(heyoka_system(hy)[0], z0[:, : hy.recommended_simd_size()].copy(), tol=tol)

    def peer():
        return batches(ta, z0, TIME, threads)

    def ours():
        return integrate(BODY, z0, time=TIME, step=step, scheme=scheme, threads=threads)

    theirs = np.concatenate([run[0].state for run in peer()], axis=1)
    errors = [np.abs(z[:, :CHECKED] - truth).max(axis=0) for z in (ours().z, theirs)]
    slow, fast = best(peer, repeats=3), best(ours)
    benchmark.pedantic(ours, rounds=3)
    benchmark.extra_info.update(ratio=slow / fast, error=errors[0].max(), peer_error=errors[1].max())
    print(
        f"\nheyoka {hy.__version__} tol {tol}: {slow:.3f} s, error max {errors[1].max():.1e} median "
        f"{np.median(errors[1]):.1e}; "
        f"fastaff {scheme.name} step {step}: {fast:.3f} s, error max {errors[0].max():.1e} median "
        f"{np.median(errors[0]):.1e}; "
        f"{slow / fast:.1f} x on {threads} threads, {ORBITS} orbits"
    )


@pytest.mark.parametrize("threads", [1, numba.config.NUMBA_NUM_THREADS])
def test_crossings(benchmark, threads):
    """alpha p_alpha = 0 rising, 4096 orbits to T = 200: heyoka's batch events with a callback that stores time and
    state.
    """
    z0 = hyperelastic_orbits()
    system, q, p = heyoka_system(hy)

    class Store:
        def __init__(self):
            self.rows = []

        def __call__(self, ta, time, sign, lane):
            ta.update_d_output(np.where(np.arange(ta.state.shape[1]) == lane, time, ta.time))
            self.rows.append((time, lane, ta.d_output[:, lane].copy()))

    event = hy.nt_event_batch(q[0] * p[0] + q[1] * p[1], Store(), direction=hy.event_direction.positive)
    ta = hy.taylor_adaptive_batch(system, z0[:, : hy.recommended_simd_size()].copy(), tol=1e-15, nt_events=[event])

    def peer():
        return batches(ta, z0, TIME, threads)

    def ours():
        return poincare_map(
            BODY,
            z0,
            section=AlphaTurning(+1),
            crossings=110,
            max_time=TIME,
            step=0.1,
            scheme=BLANES_MOAN6,
            threads=threads,
        )

    result, runs = ours(), peer()
    theirs = np.array([row[2] for run in runs for row in run[0].nt_events[0].callback.rows]).T
    found = int(result.counts.sum())
    kept = result.points[:, np.isfinite(result.times)]
    ends = [np.abs(z[0] * z[4] + z[1] * z[5]).max() for z in (kept, theirs)]
    slow, fast = best(peer, repeats=2), best(ours, repeats=3)
    benchmark.pedantic(ours, rounds=3)
    benchmark.extra_info.update(ratio=slow / fast, crossings=found, peer_crossings=theirs.shape[1])
    print(
        f"\n{threads} threads: heyoka {theirs.shape[1]} crossings in {slow:.3f} s, |section| {ends[1]:.1e}; fastaff "
        f"{found} in "
        f"{fast:.3f} s ({found / fast / 1e6:.2f} million/s), |section| {ends[0]:.1e}, energy error "
        f"{result.energy_error.max():.1e}; "
        f"{slow / fast:.1f} x"
    )
