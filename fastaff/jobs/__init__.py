"""Jobs: many orbits of one system, kept unit by unit, so that a stopped job goes on where it was.

    job = Job(model=Model(model="neo-hookean"), surface=Surface(energy=1.5, p_eta=0.3), starts=Starts(grid="2000x2000"),
              frequency_map=Frequencies(time=1000.0))
    results = run(job, "map.zarr")
    results["frequency_map"].nu

A module each: the tables of a job (`system`, `launch`, `analyses`), the job itself and its TOML (`job`), one unit
(`units`), results on disk (`store`), running (`running`), and the results (`results`).
"""

from .analyses import Actions, Chaos, Frequencies, Motion, Poincare, Run
from .job import Job
from .launch import Starts
from .results import JobResults
from .running import rerun, resume, run
from .scans import Scan
from .store import Store
from .system import Model, Surface
from .units import Unit, compute_unit
from .watching import Progress

__all__ = [
    "Actions",
    "Chaos",
    "Frequencies",
    "Job",
    "JobResults",
    "Model",
    "Motion",
    "Poincare",
    "Progress",
    "Run",
    "Scan",
    "Starts",
    "Store",
    "Surface",
    "Unit",
    "compute_unit",
    "rerun",
    "resume",
    "run",
]
