"""A frequency map of a million cells on a SLURM cluster: `python examples/job_on_slurm.py map.zarr`.

Needs `pip install "fastaff[dask]" dask-jobqueue` and a folder that all nodes see. Tried on one machine with

    python examples/job_on_slurm.py map.zarr --local --grid 60x60

Run it again after any stop: it goes on. Each worker is a process of one thread that writes its own chunks; compiled
code goes to the cache in the home folder, which all share, or to FASTAFF_CACHE_DIR.
"""

import argparse

import distributed

import fastaff as fa
from fastaff.jobs import EnergySurface, FrequencyOptions, InitialConditions, Job


def cluster_of(given):
    """Workers of one thread each: of SLURM, or on this machine."""
    if given.local:
        return distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    from dask_jobqueue import SLURMCluster

    found = SLURMCluster(queue=given.queue, cores=16, processes=16, memory="32GB", walltime="04:00:00")
    found.scale(jobs=given.nodes)
    return found


def main():
    """Run the job, or go on with it, and print the outcomes of the orbits."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("store", help="the results: a folder in Zarr format, new or of a run before")
    parser.add_argument("--grid", default="1000x1000")
    parser.add_argument("--local", action="store_true", help="two workers on this machine")
    parser.add_argument("--queue", default="normal")
    parser.add_argument("--nodes", type=int, default=4)
    given = parser.parse_args()
    job = Job(
        model=fa.Body(fa.NeoHookean()),
        energy_surface=EnergySurface(energy=1.5, p_eta=0.3, p_gamma=0.2),
        initial_conditions=InitialConditions(grid=given.grid),
        frequency_map=FrequencyOptions(time=1000.0),
    )
    with cluster_of(given) as cluster, distributed.Client(cluster) as client:
        results = fa.run(job, given.store, executor=client.get_executor())
    print(results.table())


if __name__ == "__main__":
    main()
