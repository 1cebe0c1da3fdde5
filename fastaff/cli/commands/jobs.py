"""`fastaff run`, `resume`, `rerun` and `status`: jobs in stores."""

# ruff: noqa: B008
from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
import shlex
import signal
import threading
from collections.abc import Callable, Iterator
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...core.interruption import Interrupted
from ...core.numbers import reason
from ...jobs import chunks, running
from ...jobs.analyses import RunOptions
from ...jobs.job import OPTIONS, Job, JobPlan, as_key
from ...jobs.results import JobResults
from ...jobs.store import WAITING, Store, is_store
from ...jobs.wording import OptionError, respelled, spelled
from ..options import HOW, WRITTEN, LogOptions, Parameter, Workers, given, size_of
from ..progress import JobProgress
from ..stops import EXIT_INTERRUPTED, STOPPING, Stops, say
from .maps import checked, settled


def run(
    job: Path,
    /,
    *,
    workers: Workers = Workers(),
    memory: Annotated[str | None, Parameter(group=HOW)] = None,
    store: Annotated[Path | None, Parameter(group=WRITTEN)] = None,
    overwrite: Annotated[bool, Parameter(group=WRITTEN)] = False,
    told: LogOptions = LogOptions(),
) -> int:
    """Run a job, chunk by chunk, into a store that keeps all finished chunks; the same command resumes it.

    The command prints a table of the outcomes of the orbits, which `fastaff status STORE` shows again. Ctrl-C or
    SIGTERM stops it within a second and prints the command that resumes the job.

    Parameters
    ----------
    job
        File of the job, TOML; `fastaff frequency-map ... --write-job map.toml` writes one.
    memory
        Bytes that a chunk may take, such as 500MB or 2GiB, which bounds its orbits. [a quarter of the free memory]
    store
        Zarr store of the results. [that of the job's name, .zarr]
    overwrite
        Replace a store of another job.
    """
    room = size_of(memory)
    _check(workers, told)
    asked = Job.read(job)
    path = job.with_suffix(".zarr") if store is None else store
    with in_keys(str(job)):
        plan = checked(asked)
        plan.few()
    if not path.parent.is_dir():
        raise OptionError(f"--store {path}: the folder {path.parent} does not exist")

    _compiled(plan, asked.options, told, str(job))

    def work(**how: Any) -> JobResults:
        return running.run(asked, path, memory=room, overwrite=overwrite, **how)

    return _watched(path, plan.launch.size, work, workers, told)


def resume(store: Path, /, *, workers: Workers = Workers(), told: LogOptions = LogOptions()) -> int:
    """Resume the job of a store where it was stopped; the result is bitwise equal to that of a run without a stop.

    Parameters
    ----------
    store
        Zarr store of `fastaff run`.
    """
    _check(workers, told)
    with in_keys(str(store)):
        begun = chunks.running(store)
        if len(chunks.waiting(begun.store)):
            chunks.same_processor(begun.store, workers.allow_other_cpu)
    _compiled(begun.plan, begun.job.options, told, str(store))
    return _watched(store, begun.store.orbits, lambda **how: running.resume(store, **how), workers, told)


def rerun(
    store: Path,
    /,
    *,
    status: Annotated[list[str], Parameter(group=HOW)],
    scheme: Annotated[str | None, Parameter(group=HOW)] = None,
    step: Annotated[float | None, Parameter(group=HOW)] = None,
    accuracy: Annotated[float | None, Parameter(group=HOW)] = None,
    analysis: Annotated[list[str] | None, Parameter(group=HOW)] = None,
    workers: Workers = Workers(),
    told: LogOptions = LogOptions(),
) -> int:
    """Repeat the failed orbits of a store with other options; the new results replace the old ones.

    Prints the table of the outcomes of all orbits. A stopped rerun goes on by `fastaff resume`.

    Parameters
    ----------
    store
        Zarr store of `fastaff run`.
    status
        Status of the orbits to run again, such as ENERGY_DRIFT or TOO_FEW_CROSSINGS; once for each.
    scheme
        Another scheme, such as DOP853 or VERNER9.
    step
        Another step.
    accuracy
        Another accuracy.
    analysis
        Which of the job's analyses, such as frequency_map. [all that have statuses]
    """
    _check(workers, told)
    with in_keys(str(store)):
        begun = chunks.running(store)
        chunks.same_processor(begun.store, workers.allow_other_cpu)
    _compiled(begun.plan, begun.job.options, told, str(store))
    changed: dict[str, Any] = {"scheme": scheme, "step": step, "accuracy": accuracy, "analyses": analysis}

    def work(**how: Any) -> JobResults:
        return running.rerun(store, status=status, **changed, **how)

    return _watched(store, begun.store.orbits, work, workers, told)


def status(store: Path, /) -> int:
    """Print the outcomes of the orbits of a job so far: counts and share of each status, errors, the slowest chunk.

    Parameters
    ----------
    store
        Zarr store of `fastaff run`.
    """
    with in_keys(str(store)):
        results = JobResults.stored(store)
        print(results.table())
        if not results.complete:
            print(f"go on with: {running.resume_command(store)}")
    return 0


def _check(workers: Workers, told: LogOptions) -> None:
    workers.check()
    told.check()


def _compiled(plan: JobPlan, options: RunOptions, told: LogOptions, name: str) -> None:
    """Compile the kernels that a job needs before its progress is shown."""
    with in_keys(name):
        settled(plan, options, announce=not told.quiet)


@contextlib.contextmanager
def in_keys(name: str) -> Iterator[None]:
    """Report errors of a job or store by its keys, after the name of the file."""
    try:
        with spelled(as_key):
            yield
    except FileNotFoundError as problem:
        text = str(problem) if problem.filename is None else f"{problem.filename} does not exist"
        raise OptionError(text if text.startswith(name) else f"{name}: {text}") from None
    except (ValueError, TypeError) as problem:
        with spelled(as_key):
            text = respelled(str(problem), OPTIONS)
        raise OptionError(text if text.startswith(name) else f"{name}: {text}") from None
    except LookupError as problem:
        raise OptionError(f"{name} is damaged: it has no {problem}") from None


def _watched(path: Path, orbits: int, work: Callable[..., JobResults], workers: Workers, told: LogOptions) -> int:
    """Run a job, show its progress and outcomes, and return the exit code."""
    finished = float(np.mean(Store(path).finished() != WAITING)) if is_store(path) else 0.0
    bar = JobProgress(orbits, finished, shown=not told.quiet and told.log is None)
    on_chunk = _log if told.log else bar.on_chunk
    try:
        with _executor(workers, path) as executor, bar:
            how = {"threads": workers.threads, "allow_other_cpu": workers.allow_other_cpu}
            results = work(executor=executor, callback=bar, on_chunk=on_chunk, **how)
    except KeyboardInterrupt as stopped:
        if not (isinstance(stopped, Interrupted) or is_store(path)):
            raise
        left = int(np.count_nonzero(Store(path).finished() == WAITING))
        say(f"stopped: {left} of {orbits} points are still to be computed, all others are kept in {path}; go on with")
        print(shlex.join(["fastaff", "resume", str(path), *given(workers), *given(told)]), flush=True)
        return EXIT_INTERRUPTED
    if told.log:
        print(json.dumps({"store": str(path), "complete": results.complete, "statuses": results.counts()}), flush=True)
    elif not told.quiet:
        print(f"{path}\n{results.table()}")
    return 0


def _log(so_far: running.Progress, chunk: Any) -> None:
    """Print the outcome of a chunk, and of the job so far, as a line of JSON."""
    print(json.dumps({"chunk": chunk._asdict(), "so_far": so_far._asdict()}), flush=True)


@contextlib.contextmanager
def _executor(workers: Workers, path: Path) -> Iterator[Any]:
    """Yield the executor of the chunks, None for this process; no process is left behind, even after an error."""
    from concurrent.futures import ProcessPoolExecutor

    if workers.dask is not None:
        with _client(workers.dask) as client, _failing(path):
            yield client.get_executor()
    elif workers.workers is not None:
        context = multiprocessing.get_context("spawn")
        if hasattr(signal, "pthread_sigmask"):
            with _unheard():
                resource_tracker.ensure_running()  # a process too; its start unblocks some signals again
        pool = ProcessPoolExecutor(workers.workers, mp_context=context, initializer=_obey_the_parent)
        try:
            with _failing(path):
                yield _Pool(pool)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.kill()  # a chunk that is not finished counts as none
            raise
        pool.shutdown()
    else:
        yield None


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise ImportError('--dask needs distributed: pip install "fastaff[dask]"') from None
    try:
        return Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise OptionError(f"--dask {address}: no scheduler there: {problem}") from None


@contextlib.contextmanager
def _failing(path: Path) -> Iterator[None]:
    """Say in one line that workers failed: the results of other chunks are kept."""
    try:
        yield
    except (ValueError, TypeError, OSError):
        raise
    except Exception as problem:
        again = running.resume_command(path)
        raise OptionError(f"a worker failed: {reason(problem)}; go on with: {again}") from None


@contextlib.contextmanager
def _unheard() -> Iterator[None]:
    """Mask the stopping signals within the block: a process started there inherits the mask; no terminal stops it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Pool:
    """A pool whose processes leave the stopping signals to their parent, from their first moment on."""

    def __init__(self, pool: Any):
        self.pool = pool

    def submit(self, *work: Any) -> Any:
        """Hand over work, for which a process may be started; a process stopped half way would have no parent to end
        it. Another thread of the process takes the signals that this one blocks.
        """
        with Stops.later(), _unheard():
            return self.pool.submit(*work)


def _obey_the_parent() -> None:
    """Make a worker leave the stopping signals to its parent, and end when the parent ends, for any reason."""
    for number in STOPPING:
        signal.signal(number, signal.SIG_IGN)
    parent: Any = multiprocessing.parent_process()

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
