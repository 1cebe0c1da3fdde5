"""Jobs beside the plain call on the same orbits, and beside workers of a cluster: `pytest bench/test_jobs.py -s`."""

import time
import warnings

import job_memory
import numpy as np
import pytest
from job_scaling import measured_overhead

import fastaff as fa
from fastaff.jobs import (
    EnergySurface,
    FrequencyOptions,
    InitialConditions,
    IntegrateOptions,
    Job,
    PoincareOptions,
    launch,
)

SIDE = 240
"""Cells along each axis: some 44,000 orbits."""

ANALYSES = {
    "poincare": {"poincare": PoincareOptions(crossings=20)},
    "integrate": {"integrate": IntegrateOptions(time=1000.0)},
    "frequency_map": {"frequency_map": FrequencyOptions(time=200.0)},
}


def job(side=SIDE, **analyses):
    """A job of Hénon-Heiles over a grid."""
    start = {
        "energy_surface": EnergySurface(energy=0.125),
        "initial_conditions": InitialConditions(grid=f"{side}x{side}"),
    }
    return Job(model=fa.HenonHeiles(), **start, **analyses)


def seconds(call):
    """Wall time of a call, and its result."""
    start = time.perf_counter()
    found = call()
    return time.perf_counter() - start, found


@pytest.mark.parametrize("name", ANALYSES)
def test_a_job_beside_the_plain_call(numbers, tmp_path, name):
    """In turns: the plain call with the options that the job settled, and the job into a store."""
    one = job(SIDE if name != "frequency_map" else SIDE // 3, **ANALYSES[name])
    plan = one.plan()
    fa.run(job(8, **ANALYSES[name]), tmp_path / "warm.zarr")
    analysis = plan.analyses[name]
    settled = analysis.resolve_defaults(plan.few(), one.options)
    plain, stored, whole = [], [], launch.whole(plan.launch)[0]
    for k in range(2):
        taken, alone = seconds(lambda: analysis.compute(plan.few()._replace(z0=whole), settled, one.options))
        plain.append(taken)
        taken, found = seconds(lambda k=k: fa.run(one, tmp_path / f"{k}.zarr"))
        stored.append(taken)
    result = found[name]
    for field in ("z", "points", "nu"):
        if hasattr(result, field):
            assert np.array_equal(getattr(result, field), getattr(alone, field), equal_nan=True)
    chunks = max(chunk.number for chunk in found.chunks) + 1
    numbers.update(
        analysis=name,
        orbits=len(result),
        chunks=chunks,
        plain=min(plain),
        job=min(stored),
        ratio=min(stored) / min(plain),
    )


@pytest.mark.parametrize(("points", "how"), [(30_000, "plain"), (100_000, "job"), (4_000_000, "job")])
def test_memory(numbers, points, how):
    """The peak of a frequency map, in a process of its own."""
    numbers.update(points=points, by={"job": "a job", "plain": "the plain call"}[how], **job_memory.asked(points, how))


def test_workers_beside_threads(numbers, tmp_path):
    """Two dask workers of one thread each, on this machine, beside one process of two threads."""
    distributed = pytest.importorskip("distributed")
    one = job(SIDE, integrate=IntegrateOptions(time=1000.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of ports that are taken
        cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        executor = client.get_executor()
        warm = job(24, integrate=IntegrateOptions(time=1000.0))
        fa.run(warm, tmp_path / "warm.zarr")
        fa.run(warm, tmp_path / "warm-dask.zarr", executor=executor)
        alone, shared = [], []
        for k in range(2):
            alone.append(seconds(lambda k=k: fa.run(one, tmp_path / f"{k}.zarr", threads=2))[0])
            shared.append(seconds(lambda k=k: fa.run(one, tmp_path / f"{k}-dask.zarr", executor=executor))[0])
    numbers.update(
        orbits=launch.whole(one.plan().launch)[0].shape[1],
        threads=min(alone),
        workers=min(shared),
        ratio=min(shared) / min(alone),
        scheduler_ms=1e3 * measured_overhead(500),
    )
