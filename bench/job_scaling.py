"""How far a job scales: a simulation of workers, from measured costs: `python bench/job_scaling.py STORE`.

The costs of chunks are those in a store's log. The time of a scheduler for each task, one after another, is measured
with dask on this machine unless it is given (`--overhead`, seconds). Each worker takes the next chunk as soon as it is
free; a chunk reaches it after the scheduler's time, and waits while the scheduler serves others. Speed-up is against
one worker without a scheduler; the ideal is the number of workers. Units of another size have costs in proportion,
drawn from the same log.
"""

import argparse
import heapq
import warnings

import numpy as np

from fastaff.jobs import JobResults

WORKERS = (10, 100, 1000)
SIZES = (1 / 16, 1 / 4, 1, 4, 16)
"""Sizes of chunks, relative to those of the store."""


def simulated(costs, workers, overhead):
    """Seconds that workers take for chunks of these costs, handed out one after another by a scheduler."""
    free = [(0.0, k) for k in range(workers)]
    scheduler = end = 0.0
    for cost in costs:
        at, k = heapq.heappop(free)
        scheduler = max(scheduler, at) + overhead
        end = max(end, scheduler + cost)
        heapq.heappush(free, (scheduler + cost, k))
    return end


def measured_overhead(tasks=2000):
    """Seconds that dask's scheduler takes for a task that does nothing."""
    import time

    import distributed

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        executor = client.get_executor()
        for _ in range(2):
            start = time.perf_counter()
            for future in [executor.submit(int, k) for k in range(tasks)]:
                future.result()
            taken = (time.perf_counter() - start) / tasks
    return taken


def resized(costs, factor, orbits, random):
    """Costs of so many orbits in chunks of another size: sums of drawn costs, or parts of them."""
    count = max(1, round(orbits / factor))
    if factor >= 1:
        return random.choice(costs, (count, int(factor))).sum(axis=1)
    return random.choice(costs, count) * factor


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("store")
    parser.add_argument("--chunks", type=int, default=20000, help="chunks of the store's size that the job has")
    parser.add_argument("--overhead", type=float, help="seconds of the scheduler for a task [measured with dask]")
    given = parser.parse_args()
    costs = np.array([chunk.seconds for chunk in JobResults.stored(given.store).chunks])
    overhead = measured_overhead() if given.overhead is None else given.overhead
    random = np.random.default_rng(0)
    print(
        f"{costs.size} chunks measured: {costs.mean():.3f} s each, {costs.std():.3f} apart; scheduler {overhead:.2e} s"
    )
    print(f"speed-up of {given.chunks} such chunks by workers")
    print("seconds a chunk  chunks " + "".join(f"{workers:>10d}" for workers in WORKERS))
    for factor in SIZES:
        drawn = resized(costs, factor, given.chunks, random)
        found = [drawn.sum() / simulated(drawn, workers, overhead) for workers in WORKERS]
        print(f"{drawn.mean():14.3f} {drawn.size:6d} " + "".join(f"{value:10.1f}" for value in found))


if __name__ == "__main__":
    main()
