"""Running jobs: into a store or in memory, here or by an executor, and from where they were stopped."""

from __future__ import annotations

import re
import shlex
import time as clock
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.interruption import Interrupted
from ..core.names import named
from ..core.numbers import StrPath, checked_callback, flag, free_memory, function, listed, shown, whole
from ..core.placing import sweep
from ..core.sizes import bytes_of
from ..core.status import Status
from ..engine.code_folder import package_hash
from ..engine.threads import checked_threads
from ..results.machine import processor
from ..results.progress import says_progress
from ..results.provenance import provenance
from ..results.result import columns
from ..runs.schemes.catalogue import Scheme
from ..systems.models.contracts import Dynamics
from .analyses import AnalysedOrbits
from .chunks import Chunk, computed, refresh_chunk, running, same_processor, stated, summed, waiting
from .holding import as_path, exclusive_lock
from .job import Job, JobPlan, difference, distinct
from .launch import InitialConditions, Points, between, some
from .results import JobResults
from .scans import Cases, assembled
from .store import Store, create, is_store
from .system import Model
from .watching import Progress, Watched, submitted
from .wording import OptionError

SECONDS = 2.0
"""Seconds of work in a chunk whose size is left open."""

PROBE = 256
"""Orbits of the trial that measures the time of a chunk."""

SMALLEST = 256
"""Orbits of a chunk whose size is left open: two blocks of lanes."""

WORKING = 6.0
"""Bytes that a chunk takes while it runs for each byte of its results: measured by `bench/job_memory.py`."""

PARTIAL = re.compile(r"\d+\.[0-9a-f]{32}\.partial")
"""Names of pieces that are being written, by Zarr."""

SHARE = 0.25
"""Share of the free memory that a job takes if nothing is said."""


@says_progress
@inserts_parameters
def run(
    job: Job,
    store: StrPath | None = None,
    *,
    executor: Executor | None = None,
    threads: int | None = None,
    memory: float | str | None = None,
    overwrite: bool = False,
    allow_other_cpu: bool = False,
    callback: Callable[[float], object] | None = None,
    on_chunk: Callable[[Progress, Chunk], object] | None = None,
) -> JobResults:
    """Run a job and return its results, in memory or in a store that can be resumed.

    Parameters
    ----------
    job : Job
        The job.
    store : path_like, optional
        Path of a Zarr hierarchy, new or of the same job, which is resumed. Default: all results in memory.
    {executor}
    {chunk_threads}
    memory : float or str, optional
        Largest memory of a chunk in bytes, or with a unit such as "500MB" or "16MiB". It limits the size of chunks
        unless the job sets that. Default: a quarter of the free memory.
    overwrite : bool, default False
        Replace a store of another job.
    {allow_other_cpu}
    {callback}
    {on_chunk}

    Returns
    -------
    JobResults
        The results, in memory or in the store.

    Raises
    ------
    TypeError, ValueError
        If the job is inconsistent, or the store belongs to another job. The message names the field.
    OSError
        If the store cannot be written.
    Interrupted
        On Ctrl-C. Its attribute ``partial`` has the contents of the store.

    Notes
    -----
    - A store is bitwise reproducible for any threads, executor, order and interruption on processors of one kind. Other
      processors raise an error.
    - The values of an orbit do not depend on the size of chunks.
    - Finished chunks survive a killed process. A chunk is finished when its last piece is on the disk.
    - Cost: the analyses, and writing their numbers.

    References
    ----------
    The Zarr storage specification, version 3.

    Examples
    --------
    >>> asked = fa.jobs.IntegrateOptions(time=1.0)
    >>> job = fa.Job(model=fa.HenonHeiles(), initial_conditions=[0.1, 0.0, 0.0, 0.2], integrate=asked)
    >>> fa.run(job).complete
    True
    """
    if not isinstance(job, Job):
        raise TypeError(f"job must be a Job, got {shown(job)} ({type(job).__name__})")
    _checked(executor, threads, callback, on_chunk, allow_other_cpu)
    flag("overwrite", overwrite)
    room = None if memory is None else bytes_of("memory", memory)
    if store is None:
        if executor is not None:
            raise OptionError("executor needs a store: workers hand over their results there")
        return _in_memory(job, threads, callback)
    path = as_path(store)
    there = path.exists()
    if not (there and is_store(path)):
        try:
            begin(job, path, memory=room, overwrite=overwrite and there, threads=threads)
        except FileExistsError:
            if not is_store(path):
                raise  # else another process made it in this moment; the store is used
    with exclusive_lock(path):
        change = _change(path, job, overwrite)
        if change is not None and not overwrite:
            raise OptionError(f"{path} holds another job: {change}. Take another store, or overwrite this one")
        if change is not None:
            begin(job, path, memory=room, overwrite=True, threads=threads)
    return _finished(path, _own(job), executor, threads, callback, on_chunk, allow_other_cpu)


@says_progress
@inserts_parameters
def resume(
    store: StrPath,
    *,
    executor: Executor | None = None,
    threads: int | None = None,
    callback: Callable[[float], object] | None = None,
    on_chunk: Callable[[Progress, Chunk], object] | None = None,
    model: Dynamics | None = None,
    allow_other_cpu: bool = False,
) -> JobResults:
    """Resume the job of a store and return its results.

    Parameters
    ----------
    store : path_like
        Path of the store.
    {executor}
    {chunk_threads}
    {callback}
    {on_chunk}
    model : model, optional
        Model of the job, if TOML cannot describe it.
    {allow_other_cpu}

    Returns
    -------
    JobResults
        The results in the store.

    Raises
    ------
    FileNotFoundError
        If there is no store.
    ValueError
        If the store is one of another version, or was begun on another kind of processor.
    Interrupted
        On Ctrl-C. Its attribute ``partial`` has the contents of the store.

    Notes
    -----
    Cost: the computation of the unfinished chunks.

    References
    ----------
    The Zarr storage specification, version 3.

    Examples
    --------
    >>> asked = fa.jobs.IntegrateOptions(time=1.0)
    >>> job = fa.Job(model=fa.HenonHeiles(), initial_conditions=[0.1, 0.0, 0.0, 0.2], integrate=asked)
    >>> whole = fa.run(job, "resumed.zarr")
    >>> fa.resume("resumed.zarr").complete
    True
    """
    _checked(executor, threads, callback, on_chunk, allow_other_cpu)
    own = {} if model is None else {"model": model}
    return _finished(as_path(store), own, executor, threads, callback, on_chunk, allow_other_cpu)


@says_progress
@inserts_parameters
def rerun(
    store: StrPath,
    *,
    status: Status | str | Sequence[Status | str],
    scheme: Scheme | str | None = None,
    step: float | None = None,
    accuracy: float | None = None,
    analyses: str | Sequence[str] | None = None,
    executor: Executor | None = None,
    threads: int | None = None,
    callback: Callable[[float], object] | None = None,
    on_chunk: Callable[[Progress, Chunk], object] | None = None,
    model: Dynamics | None = None,
    allow_other_cpu: bool = False,
) -> JobResults:
    """Compute the orbits of a store that have given statuses again, with other options.

    Parameters
    ----------
    store : path_like
        Path of a store, finished or not. Orbits that are not computed yet are computed again if they get one of the
        statuses.
    status : Status, str or sequence of these
        Statuses of the orbits.
    scheme : Scheme or str, optional
        New integration method or its name. At least one of `scheme`, `step` and `accuracy` is needed.
    step : float, optional
        New fixed step size, in units of time.
    accuracy : float, optional
        New requested error, relative to the amplitudes of the motion.
    analyses : str or sequence of str, optional
        Names of the analyses. Default: all that have statuses.
    {executor}
    {chunk_threads}
    {callback}
    {on_chunk}
    model : model, optional
        Model of the job, if TOML cannot describe it.
    {allow_other_cpu}

    Returns
    -------
    JobResults
        The results in the store. New numbers replace the old ones. ``JobResults.attempts`` identifies these orbits, and
        the store keeps the changes.

    Raises
    ------
    FileNotFoundError
        If there is no store.
    ValueError
        If the store is one of another version, was begun on another kind of processor, or a name is unknown.
    Interrupted
        On Ctrl-C. Its attribute ``partial`` has the contents of the store.

    Notes
    -----
    Cost: the computation of these orbits.

    References
    ----------
    The Zarr storage specification, version 3.

    Examples
    --------
    >>> asked = fa.jobs.IntegrateOptions(time=1.0)
    >>> job = fa.Job(model=fa.HenonHeiles(), initial_conditions=[0.1, 0.0, 0.0, 0.2], integrate=asked)
    >>> whole = fa.run(job, "rerun.zarr")
    >>> fa.rerun("rerun.zarr", status="NONFINITE", step=0.01).complete
    True
    """
    _checked(executor, threads, callback, on_chunk, allow_other_cpu)
    path = as_path(store)
    given = {} if model is None else {"model": model}
    with exclusive_lock(path):
        begun = running(path, **given)
        same_processor(begun.store, allow_other_cpu)
        names: Sequence[str]
        if analyses is None:
            names = tuple(begun.plan.analyses)
        elif isinstance(analyses, str):
            names = (analyses,)
        else:
            names = analyses
        if isinstance(begun.plan.launch, Cases):
            raise OptionError("rerun is for orbits; cases of a scan have their fallback scheme already")
        for name in names:
            named("analyses", name, tuple(begun.plan.analyses))
        name_of = None if scheme is None else str(getattr(scheme, "name", scheme))
        asked = {"scheme": name_of, "step": step, "accuracy": accuracy}
        changed: dict[str, Any] = {name: value for name, value in asked.items() if value is not None}
        if not changed:
            raise OptionError("rerun needs scheme, step or accuracy: with the same ones the numbers stay")
        options = replace(begun.job.options, **changed)
        few = begun.plan.few()
        few = few._replace(z0=few.z0[:, :1])
        for name in names:  # wrong options are refused before anything is changed
            begun.plan.analyses[name].compute(few, begun.store.facts["settled"][name], options)
        entry = {
            "status": sorted({int(_status(one)) for one in _several(status)}),
            "options": changed,
            "analyses": list(names),
            "date": provenance()["date"],
        }
        begun.store.tell(reruns=[*begun.store.facts["reruns"], entry])
    return _finished(path, given, executor, threads, callback, on_chunk, allow_other_cpu)


def _several(status: Any) -> list[Any]:
    found = [status] if isinstance(status, (str, int)) else list(status)
    if not found:
        raise ValueError("status must be one status or several, got none")
    return found


def _status(one: Any) -> Status:
    if isinstance(one, str):
        return Status[named("status", one.upper().replace("-", "_"), tuple(entry.name for entry in Status))]
    try:
        return Status(one)
    except ValueError:
        raise ValueError(f"status must be of {listed(entry.name for entry in Status)}, got {shown(one)}") from None


def begin(
    job: Job, path: Any, *, memory: float | None = None, overwrite: bool = False, threads: int | None = None
) -> Store:
    """Make the store of a job with no chunk finished; a few orbits settle the options that are left open."""
    plan = job.plan()
    run = job.options.on(threads)
    few = plan.few()
    settled = {name: analysis.resolve_defaults(few, run) for name, analysis in plan.analyses.items()}

    template = dict(computed(plan, few.z0[:, :1], settled, run))
    free = free_memory()
    room = free * SHARE if memory is None else memory
    each = WORKING * (_bytes_of(template) + 8 * few.z0.shape[0])
    most = int(room // each)
    if most < 1:
        raise OptionError(f"memory must be at least {each:.0f} bytes, one orbit of this job, got {room:.0f}")
    size = job.chunk
    if size is None:
        size = _chunk_size(plan, settled, run, most)
    elif min(size, plan.launch.size) > (most := int((free if memory is None else room) // each)):
        raise OptionError(f"chunk must be at most {most} orbits for {most * each:.0f} bytes of memory, got {size}")
    own_initial_conditions = isinstance(plan.launch, Points)
    facts = {
        "job": job.text(),
        "settled": settled,
        "orbits": plan.launch.size,
        "chunk": min(size, plan.launch.size),
        "source": package_hash(),
        "processor": processor(),
        "other_cpu_allowed": False,
        "own_initial_conditions": own_initial_conditions,
        "reruns": [],
        "provenance": provenance(),
    }

    def prepared(store: Store) -> None:
        for number in range(store.chunks if own_initial_conditions else 0):
            points = store.points(number)
            store.start(number, between(plan.launch, points.start, points.stop)[0])

    try:
        return create(path, facts, template, plan.rows, overwrite=overwrite, prepared=prepared)
    except OSError as problem:
        if Path(path).exists() and not isinstance(problem, FileExistsError) and not overwrite and is_store(path):
            raise FileExistsError(f"{path} was made by another process in this moment") from None
        if problem.errno is not None and problem.filename is None:
            problem.filename = str(path)
        raise


def _chunk_size(plan: JobPlan, settled: dict[str, Any], options: Any, most: int) -> int:
    """Return the number of orbits that take some seconds, a multiple of the smallest chunk, as far as memory allows."""
    if isinstance(plan.launch, Cases):
        return 1
    if plan.launch.size <= SMALLEST:
        return min(most, SMALLEST)
    z0 = some(plan.launch, min(PROBE, most))
    start = clock.perf_counter()
    dict(computed(plan, z0, settled, options))
    each = (clock.perf_counter() - start) / z0.shape[1]
    size = max(1, round(SECONDS / each / SMALLEST)) * SMALLEST
    return min(size, max(1, most // SMALLEST) * SMALLEST if most >= SMALLEST else most)


def _in_memory(job: Job, threads: int | None, callback: Any) -> JobResults:
    plan = job.plan()
    options = job.options.on(threads)
    few = plan.few()
    settled = {name: analysis.resolve_defaults(few, options) for name, analysis in plan.analyses.items()}
    _fits(plan, settled, options, few)
    z0, place = between(plan.launch, 0, plan.launch.size)
    found: dict[str, Any] = {}
    start = clock.perf_counter()
    try:
        for name, result in computed(plan, z0, settled, options, callback):
            found[name] = result
    except Interrupted as stopped:
        found[list(plan.analyses)[len(found)]] = stopped.partial
        raise _stopped(JobResults(job, found, place, None)) from None
    chunks = [summed(0, place.size, clock.perf_counter() - start, found)]
    if isinstance(plan.launch, Cases):
        found = {name: assembled(result, plan.launch) for name, result in found.items()}
    return JobResults(job, found, place, None, chunks)


def _fits(plan: JobPlan, settled: dict[str, Any], options: Any, few: AnalysedOrbits) -> None:
    """Refuse results that do not fit into memory."""
    size = plan.launch.size
    if size <= SMALLEST:
        return
    each = _bytes_of(dict(computed(plan, few.z0[:, :1], settled, options)))
    if WORKING * each * size > (free := free_memory()):
        raise OptionError(
            f"store must be given for {size} orbits, which require {WORKING * each * size:.3g} bytes of memory, "
            f"{free:.3g} are free"
        )


def _bytes_of(results: dict[str, Any]) -> int:
    """Return the bytes of the arrays of results."""
    return sum(column.value.nbytes for result in results.values() for column in columns(result))


def _stopped(results: JobResults) -> Interrupted:
    stopped = Interrupted("run")
    stopped.partial = results
    return stopped


def _own(job: Job) -> dict[str, Any]:
    return {} if isinstance(job.model, Model) else {"model": job.model}


def _change(path: Path, job: Job, overwrite: bool) -> str | None:
    """Return the difference between a job and that of a store; None where they agree."""
    try:
        store = Store(path)
        own = stated(store)
        for name, kind in (("model", Model), ("initial_conditions", InitialConditions)):
            mine = getattr(job, name)
            if (name in own) == isinstance(mine, kind):
                return f"[{name}] was {own.get(name, 'described by a text')}, is {shown(mine)}"
            if name in own:
                own[name] = mine
        old = Job.parsed(store.facts["job"], str(path), **own)
    except ValueError:
        if overwrite:
            return "it is damaged"
        raise
    if "model" in own and (told := stated(store)["model"]) != distinct(job.model):
        return f"[model] was {told}, is {distinct(job.model)}"
    change = difference(old, job)
    if change is None and store.facts["own_initial_conditions"] and not _same_starts(store, job.plan().launch):
        return "[initial_conditions] are other points"
    began = store.facts["source"], store.facts["processor"]
    if change is None and overwrite and began != (package_hash(), processor()):
        return "it was begun by another version, or on another kind of processor"
    return change


def _same_starts(store: Store, launch: Any) -> bool:
    if launch.size != store.orbits:
        return False
    parts = (store.points(number) for number in range(store.chunks))
    return all(
        np.array_equal(store.root["launch/z0"][:, part], between(launch, part.start, part.stop)[0], equal_nan=True)
        for part in parts
    )


def _finished(
    path: Path, own: dict[str, Any], executor: Any, threads: int | None, callback: Any, on_chunk: Any, other: bool
) -> JobResults:
    """Compute the chunks of a store that are waiting."""
    with exclusive_lock(path):
        begun = running(path, **own)
        if not len(waiting(begun.store)):
            return JobResults.stored(path, job=begun.job)
        same_processor(begun.store, other)
        sweep(path.glob("*/*/c/**/*.partial"), PARTIAL)
        begun.store.verify()
        todo = waiting(begun.store)
        state = Watched(begun.store, len(todo), callback, on_chunk)
        try:
            with state.log():
                if executor is None:
                    for number in todo:
                        state.add(refresh_chunk(begun, int(number), threads, state.within))
                else:
                    submitted(executor, path, todo, 1 if threads is None else threads, own, state)
        except KeyboardInterrupt:
            raise _stopped(JobResults.stored(path, job=begun.job)) from None
        except OSError as problem:
            if problem.errno is None or not is_store(path):
                raise
            said = f"{problem.strerror} (what is finished is kept; go on with: {resume_command(path)})"
            raise OSError(problem.errno, said, problem.filename or str(path)) from problem
    return JobResults.stored(path, job=begun.job)


def _checked(executor: Any, threads: Any, callback: Any, on_chunk: Any, allow_other_cpu: Any) -> None:
    """Refuse wrong executors, threads and callbacks before any chunk is computed."""
    checked_callback(callback)
    flag("allow_other_cpu", allow_other_cpu)
    if on_chunk is not None:
        function("on_chunk", on_chunk)
    if executor is None:
        checked_threads(threads)
    elif not callable(getattr(executor, "submit", None)):
        raise TypeError(f"executor must have submit, as concurrent.futures' have, got {shown(executor)}")
    elif threads is not None:  # those of the workers' machines
        whole("threads", threads, 1)


def resume_command(path: Any) -> str:
    """Return the command that goes on with a store."""
    return shlex.join(["fastaff", "resume", str(path)])
