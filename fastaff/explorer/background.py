"""A chaos map or frequency map as the background of a page: its numbers on the cells of a grid of the section."""

from __future__ import annotations

import base64
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..chaos.chaos_map import ChaosMap
from ..core.numbers import listed, shown
from ..core.status import Status
from ..exchange.files import contents, load
from ..frequencies.frequencies import FrequencyMap
from ..jobs.job import Job, JobPlan
from ..jobs.results import JobResults
from ..jobs.store import Store, is_store
from ..sections.energy_grid import EnergyGrid

SPREAD = 1e-6
"""Relative difference of the distances of neighbours on an axis up to which they count as equal."""

LABELS = {"megno": "MEGNO", "sali": "log10 SALI", "lyapunov": "Lyapunov exponent", "fli": "FLI", "ofli": "OFLI"}


class MapOnGrid(NamedTuple):
    """A map with its grid, and its job if there is one."""

    result: Any
    grid: Any
    job: Job | None = None
    plan: JobPlan | None = None


def found(background: Any) -> MapOnGrid:
    """Return the map of a path, or of a pair (result, grid); raises ValueError or TypeError for others."""
    if isinstance(background, (str, os.PathLike)):
        path = Path(background)
        read = _of_store(path) if is_store(path) else _of_file(path)
    elif isinstance(background, tuple) and len(background) == 2:
        read = MapOnGrid(*background)
    else:
        raise TypeError(
            "background must be the path of a chaos or frequency map, or a pair (result, EnergyGrid), got "
            f"{shown(background)}"
        )
    if not isinstance(read.result, (ChaosMap, FrequencyMap)):
        raise TypeError(f"background must be a ChaosMap or a FrequencyMap, got {type(read.result).__name__}")
    if not isinstance(read.grid, EnergyGrid):
        raise TypeError(f"background must be over an EnergyGrid of a section, got {type(read.grid).__name__}")
    if read.result.status.shape != read.grid.cell_index.shape:
        raise ValueError(
            f"background must be a result with its own grid, got {read.result.status.size} orbits and "
            f"{read.grid.cell_index.size} cells"
        )
    return read


def _of_store(path: Path) -> MapOnGrid:
    store = Store(path)
    results = JobResults.stored(path)
    names = [name for name in ("chaos_map", "frequency_map") if name in results.names]
    if not names:
        raise ValueError(f"background {path} has no chaos_map and no frequency_map, but {listed(results.names)}")
    place = results.place
    plan = results.job.plan()
    if not place.size:
        raise ValueError(f"background {path}: no orbit is finished yet")
    grid = plan.launch.placed(store.root["launch/z0"][:][:, place], place)
    return MapOnGrid(results[names[0]], grid, results.job, plan)


def _of_file(path: Path) -> MapOnGrid:
    arrays, facts = contents(path)
    result = load(path)
    if not isinstance(facts.get("job"), str) or "place" not in arrays:
        raise ValueError(
            f"background must have the initial conditions of its orbits, got {path}. Use (load(path), grid)."
        )
    job = Job.parsed(facts["job"], str(path))
    plan = job.plan()
    return MapOnGrid(result, plan.launch.placed(arrays["z0"], arrays["place"]), job, plan)


def background_record(read: MapOnGrid, of: dict[str, Any]) -> dict[str, Any]:
    """Return the record of a map for a page; of: its system and surface."""
    label, values = _values(read.result)
    cells = np.ma.filled(read.grid.to_grid(values.astype(np.float64)), np.nan)
    fine = cells[np.isfinite(cells)]
    low, high = np.quantile(fine, [0.01, 0.99]) if fine.size else (0.0, 1.0)
    if not high > low:
        low = low - 0.5
        high = high + 0.5
    extent = [edge for axis in read.grid.axes for edge in _edges(axis)]
    return {
        "title": "Chaos map" if isinstance(read.result, ChaosMap) else "Frequency map",
        "label": label,
        "axes": list(read.grid.names),
        "extent": extent,
        "width": cells.shape[0],
        "height": cells.shape[1],
        "values": base64.b64encode(np.ascontiguousarray(cells.T, dtype="<f4").tobytes()).decode(),
        "low": float(low),
        "high": float(high),
        "log": False,
        "of": of,
    }


def _values(result: Any) -> tuple[str, np.ndarray]:
    """Return the label and the shown numbers (orbits,) of a map, NaN for orbits without one."""
    if isinstance(result, ChaosMap):
        name = "megno" if "megno" in result.names else result.names[0]
        label = LABELS.get(name, name)
        values = result.values[result.names.index(name)]
    else:
        label = "log10 diffusion"
        values = result.diffusion
    return label, np.where((result.status == Status.OK) & np.isfinite(values), values, np.nan)


def _edges(axis: np.ndarray) -> tuple[float, float]:
    """Return both ends of the cells with equidistant middles."""
    steps = np.diff(axis)
    if axis.size < 2 or not (steps > 0).all() or np.ptp(steps) > SPREAD * np.abs(steps).max():
        raise ValueError("background must be over a grid of equidistant, ascending section coordinates, 2 x 2 or more")
    half = 0.5 * (axis[-1] - axis[0]) / (axis.size - 1)
    return float(axis[0] - half), float(axis[-1] + half)
