"""Peak memory and speed of a job against its number of orbits: `python bench/job_memory.py 10000 100000 1000000`.

Each number runs in a process of its own: a frequency map of Hénon-Heiles on a square grid, into a store in a temporary
folder, and the plain call on the same orbits where these are few. A job is stopped after `CHUNKS` chunks, once the
memory of a chunk has been taken many times; by then a job has taken the memory for all its points.
"""

import json
import math
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fastaff as fa
from fastaff.jobs import EnergySurface, FrequencyOptions, InitialConditions, Job, launch

PLAIN = 100_000
"""Points up to which the plain call is made too."""

CHUNKS = 12
"""Units of a job that are computed."""


def job(points):
    """A frequency map of so many cells, over ten periods."""
    side = math.isqrt(points)
    return Job(
        model=fa.HenonHeiles(),
        energy_surface=EnergySurface(energy=0.1),
        initial_conditions=InitialConditions(grid=f"{side}x{side}"),
        frequency_map=FrequencyOptions(time=60.0),
    )


def some_units(one, path):
    """Compute the first chunks of a job."""
    left = [CHUNKS]

    def stop(*_):
        left[0] -= 1
        if not left[0]:
            raise KeyboardInterrupt

    try:
        return fa.run(one, path, memory=256 * 2**20, on_chunk=stop)
    except fa.Interrupted as stopped:
        return stopped.partial


def peak():
    """Return the largest memory of this process so far, in MiB: without that of the process that began it, which the
    system's own account has.
    """
    return int(re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text())[1]) / 1024


def measured(points, how):
    """Print seconds, peak memory in MiB before and after, and orbits, of a job in a store or of the plain call."""
    one = job(points)
    fa.run(job(64))  # compiles
    before = peak()
    start = time.perf_counter()
    if how == "job":
        with tempfile.TemporaryDirectory() as folder:
            found = some_units(one, Path(folder) / "map.zarr")
            seconds = time.perf_counter() - start
            orbits = sum(found.counts()["frequency_map"].values())
            chunk = max(entry.orbits for entry in found.chunks)
    else:
        plan = one.plan()
        z0 = launch.whole(plan.launch)[0]
        fa.frequency_map(plan.model, z0, time=60.0)
        seconds, orbits, chunk = time.perf_counter() - start, z0.shape[1], 0
    found = {"orbits": orbits, "seconds": seconds, "before_MiB": before, "peak_MiB": peak(), "chunk": chunk}
    print(json.dumps(found))


def asked(points, how):
    """Return these numbers of a process of its own."""
    return json.loads(subprocess.check_output([sys.executable, __file__, "--one", str(points), how], text=True))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        measured(int(sys.argv[2]), sys.argv[3])
    else:
        for points in map(int, sys.argv[1:] or (10_000, 100_000)):
            for how in ("job", "plain")[: 2 if points <= PLAIN else 1]:
                print(f"{points:9d} {how:>5}", asked(points, how), flush=True)
