"""One chunk of a job: a pure function of the job and the chunk's number, the same in every process."""

from __future__ import annotations

import functools
import time as clock
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import portion, shown
from ..core.status import Status
from ..engine.code_folder import package_hash
from ..results.machine import processor
from .analyses import AnalysedOrbits, RunOptions
from .job import Job, JobPlan, distinct
from .launch import Points, between
from .store import ATTEMPT, DONE, WAITING, Store
from .wording import OptionError

LOG = "chunks.jsonl"
"""File in a store with a line for each chunk that was computed, for people."""


class Chunk(NamedTuple):
    """Outcome of a chunk of orbits.

    Attributes
    ----------
    number : int
        Number of the chunk, from 0.
    orbits : int
        Number of orbits.
    seconds : float
        Wall time in seconds.
    statuses : dict of dict of int
        Number of orbits of each status, by analysis and name.
    energy_error : float
        Largest relative energy error.
    crossings : int
        Number of crossings.
    """

    number: int
    orbits: int
    seconds: float
    statuses: dict[str, dict[str, int]]
    energy_error: float
    crossings: int = 0


class Running(NamedTuple):
    """An open store with its job and plan."""

    store: Store
    job: Job
    plan: JobPlan


def running(path: Any, **own: Any) -> Running:
    """Return an open store with its job; own: model or initial conditions that no text describes."""
    store = Store(path, writing=True)
    if store.facts["source"] != package_hash():
        raise OptionError(
            f"{path} was begun by another version of fastaff, Numba or Python (source {store.facts['source']}, here "
            f"{package_hash()}). Run the job again."
        )
    if "model" in own and (told := stated(store).get("model")) != distinct(own["model"]):
        raise OptionError(f"{path} is of the model {told or 'in its job'}, got {distinct(own['model'])}")
    if not store.facts["own_initial_conditions"]:
        job = Job.parsed(store.facts["job"], str(path), **own)
        return Running(store, job, job.plan())
    z0 = store.root["launch/z0"]
    job = Job.parsed(store.facts["job"], str(path), **{**own, "initial_conditions": z0[:, :1]})
    return Running(store, job, job.plan()._replace(launch=Points(z0)))


def same_processor(store: Store, other: bool) -> None:
    """Refuse to compute chunks of a store that was begun on another kind of processor, unless that is asked for now or
    was before; the store records it.
    """
    if other and not store.facts["other_cpu_allowed"]:
        store.tell(other_cpu_allowed=True)
    begun, here = (text.split() for text in (store.facts["processor"], processor()))
    if begun == here or store.facts["other_cpu_allowed"]:
        return
    first, second = (" ".join(sorted({*one} - {*two})) or "nothing" for one, two in ((begun, here), (here, begun)))
    raise OptionError(
        f"{store.path} was begun on another type of processor (only there {shown(first, 24)}, only here "
        f"{shown(second, 24)}). Use --allow-other-cpu (allow_other_cpu=True)."
    )


def stated(store: Store) -> dict[str, str]:
    """Return the names, in the job of a store, of model and starts that no text describes."""
    try:
        tables = tomllib.loads(store.facts["job"])
        return {
            name: str(tables[name]["value"])
            for name in ("model", "initial_conditions")
            if "value" in tables.get(name, {})
        }
    except (ValueError, TypeError, AttributeError, RecursionError) as problem:
        raise OptionError(f"{store.path} is damaged: its job is no TOML: {problem}") from None


@functools.lru_cache(maxsize=2)
def _opened(path: str, source: str, modified: float, own: tuple) -> Running:
    begun = running(path, **dict(own))
    same_processor(begun.store, False)
    return begun


@inserts_parameters
def compute_chunk(path: str, number: int, threads: int | None = None, own: dict[str, Any] | None = None) -> Chunk:
    """Compute a chunk of a store in this process and write it, for user-defined executors.

    Parameters
    ----------
    path : str
        Path of the store.
    number : int
        Number of the chunk, from 0.
    {chunk_threads}
    own : dict, optional
        Values ``"model"`` and ``"initial_conditions"`` of the job, if TOML cannot describe them.

    Returns
    -------
    Chunk
        Outcome of the chunk.

    Raises
    ------
    FileNotFoundError
        If there is no store.
    ValueError
        If the store is damaged, or was begun on another kind of processor without `allow_other_cpu` in `run`.

    Notes
    -----
    The arguments and the result are small and can be sent to other processes. The store, its job and the kernels are
    kept for the next chunk.

    Examples
    --------
    >>> asked = fa.jobs.IntegrateOptions(time=1.0)
    >>> job = fa.Job(model=fa.HenonHeiles(), initial_conditions=[0.1, 0.0, 0.0, 0.2], integrate=asked)
    >>> whole = fa.run(job, "chunks.zarr")
    >>> fa.jobs.compute_chunk("chunks.zarr", 0).orbits
    1
    """
    modified = (Path(path) / "zarr.json").stat().st_mtime
    return refresh_chunk(_opened(path, package_hash(), modified, tuple((own or {}).items())), number, threads)


def refresh_chunk(running: Running, number: int, threads: int | None = None, callback: Any = None) -> Chunk:
    """Bring a chunk up to date: compute it and write it, and run its orbits of reruns again."""
    start = clock.perf_counter()
    store, job, plan = running
    run = job.options.on(threads)
    state = store.state(number)
    results: dict[str, Any] = {}
    if state[0] == WAITING:
        points = store.points(number)
        z0, place = between(plan.launch, points.start, points.stop)
        if place.size:
            results = dict(computed(plan, z0, store.facts["settled"], run, callback))
        store.write(number, z0, place, results)
    else:
        place = np.flatnonzero(state == DONE)
        store.forget(number)
    for attempt, again in enumerate(store.facts["reruns"], 1):
        for name in again["analyses"]:
            rows = place[to_run_again(store, name, again, attempt, number)[place]]
            if rows.size:
                orbits = AnalysedOrbits(
                    plan.system, plan.section, np.ascontiguousarray(store.part("launch", "z0", number)[:, rows])
                )
                other = replace(run, **again["options"])
                results[name] = plan.analyses[name].compute(orbits, store.facts["settled"][name], other)
                store.amend(number, name, rows, results[name], attempt)
    store.finish(number, place)
    return summed(number, place.size, clock.perf_counter() - start, results)


def computed(
    plan: JobPlan, z0: np.ndarray, settled: dict[str, Any], run: RunOptions, callback: Any = None
) -> Iterator[tuple[str, Any]]:
    """Yield the results of orbits at z0 (2n, orbits), analysis by analysis."""
    orbits = AnalysedOrbits(plan.system, plan.section, z0)
    for k, (name, analysis) in enumerate(plan.analyses.items()):
        yield name, analysis.compute(orbits, settled[name], run, portion(callback, k, len(plan.analyses)))


def to_run_again(store: Store, name: str, again: dict[str, Any], attempt: int, number: int | None = None) -> np.ndarray:
    """Return the orbits of a chunk, or of the whole store, that a rerun is for and has not reached."""
    status, last = (
        np.asarray(store.root[f"{name}/{field}"][:]) if number is None else store.part(name, field, number)
        for field in ("status", ATTEMPT)
    )
    return np.isin(status, again["status"]) & (last >= 0) & (last < attempt)


def waiting(store: Store) -> np.ndarray:
    """Return the numbers of the chunks that are not finished, or have orbits that are to be run again."""
    found = (store.finished() == WAITING) | again_to_run(store)
    return np.unique(np.flatnonzero(found) // store.chunk)


def again_to_run(store: Store) -> np.ndarray:
    """Tell of each finished orbit whether a rerun is for it that has not reached it."""
    state = store.finished()
    found = np.zeros(store.orbits, bool)
    for attempt, again in enumerate(store.facts["reruns"], 1):
        for name in again["analyses"]:
            found |= to_run_again(store, name, again, attempt) & (state == DONE)
    return found


def summed(number: int, orbits: int, seconds: float, results: dict[str, Any]) -> Chunk:
    """Return the outcome of a chunk."""
    statuses: dict[str, dict[str, int]] = {}
    worst = 0.0
    crossings = 0
    for name, result in results.items():
        statuses[name] = outcomes(result.statuses if hasattr(result, "statuses") else result.status)
        if hasattr(result, "energy_error"):
            worst = max(worst, float(np.nanmax(result.energy_error, initial=0.0)))
        crossings += int(result.counts.sum()) if hasattr(result, "counts") else 0
    return Chunk(number, orbits, seconds, statuses, worst, crossings)


def outcomes(values: np.ndarray) -> dict[str, int]:
    """Count statuses by name: those of orbits (orbits,), or counts of each status (statuses, cases)."""
    if values.ndim == 1:
        values = np.bincount(values, minlength=len(Status))[:, None]
    return {status.name: int(row.sum()) for status, row in zip(Status, values) if row.sum()}
