"""Jobs: many orbits of one system, kept chunk by chunk, so that a stopped job goes on where it was.

    job = Job(
        model=Model(model="neo-hookean"),
        energy_surface=EnergySurface(energy=1.5, p_eta=0.3),
        initial_conditions=InitialConditions(grid="2000x2000"),
        frequency_map=FrequencyOptions(time=1000.0),
    )
    results = run(job, "map.zarr")
    results["frequency_map"].nu

A module each: the tables of a job (`system`, `launch`, `analyses`), the job itself and its TOML (`job`), one chunk
(`chunks`), results on disk (`store`), running (`running`), and the results (`results`).
"""

from .analyses import ActionAngleOptions, ChaosOptions, FrequencyOptions, IntegrateOptions, PoincareOptions, RunOptions
from .chunks import Chunk, compute_chunk
from .job import Job
from .launch import InitialConditions
from .results import JobResults
from .running import rerun, resume, run
from .scans import Scan
from .store import Store
from .system import EnergySurface, Model
from .watching import Progress

__all__ = [
    "ActionAngleOptions",
    "ChaosOptions",
    "Chunk",
    "EnergySurface",
    "FrequencyOptions",
    "InitialConditions",
    "IntegrateOptions",
    "Job",
    "JobResults",
    "Model",
    "PoincareOptions",
    "Progress",
    "RunOptions",
    "Scan",
    "Store",
    "compute_chunk",
    "rerun",
    "resume",
    "run",
]
