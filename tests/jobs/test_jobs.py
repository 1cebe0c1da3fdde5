"""A job has the same bits in memory and in a store, for any threads, chunks, executors, order and interruption, and
goes on where it was stopped, whatever stopped it.
"""

import dataclasses
import errno
import json
import multiprocessing
import os
import resource
import signal
import subprocess
import sys
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from job_cases import CELLS, JOBS, LARGE, MOTION, ONES, TEXT, bits, pieces

import fastaff as fa
from fastaff.jobs import (
    ChaosOptions,
    EnergySurface,
    FrequencyOptions,
    InitialConditions,
    IntegrateOptions,
    Job,
    PoincareOptions,
    RunOptions,
    chunks,
    running,
    watching,
)
from fastaff.jobs import store as stores
from fastaff.jobs.launch import BLOCK
from fastaff.jobs.running import begin
from fastaff.jobs.store import Store

ROOT = Path(__file__).parents[1]
MODEST = replace(CELLS, poincare=None, chunk=7)


@pytest.fixture(scope="module")
def whole():
    """Results in memory, by the name of the job."""
    found = {}

    def get(name):
        if name not in found:
            found[name] = bits(fa.run(JOBS[name], threads=1))
        return found[name]

    return get


# --- the same bits ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", JOBS)
def test_a_store_has_the_bits_of_a_run_in_memory(name, whole, tmp_path):
    stored = fa.run(replace(JOBS[name], chunk=7), tmp_path / "s")
    assert bits(stored) == whole(name)
    assert stored.complete
    assert bits(fa.run(JOBS[name], threads=2)) == whole(name)


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("chunk", [1, 7, 64, 1000])
@pytest.mark.parametrize("name", JOBS)
def test_any_unit_and_threads_of_all(name, chunk, threads, whole, tmp_path):
    assert bits(fa.run(replace(JOBS[name], chunk=chunk), tmp_path / "s", threads=threads)) == whole(name)


def test_the_grid_has_whole_units_beyond_the_energy(tmp_path):
    done = fa.run(MODEST, tmp_path / "s")
    store = Store(tmp_path / "s")
    states = [set(store.state(number)) for number in range(store.chunks)]
    assert {0} in states
    assert {1} in states or {0, 1} in states
    assert len(done.place) == len(done["integrate"].status) < store.orbits
    assert len(set(done["integrate"].status.tolist())) >= 1
    assert "beyond the energy" in done.table()


@pytest.mark.parametrize("name", ["cells", "text", "own starts", "1e8"])
def test_the_bits_of_the_plain_call(name, tmp_path):
    job = replace(JOBS[name], chunk=7)
    stored, plan = fa.run(job, tmp_path / "s"), job.plan()
    there = Store(tmp_path / "s").finished() == 1
    z0 = np.ascontiguousarray(Store(tmp_path / "s").root["launch/z0"][:][:, there])
    plain = {}
    if job.integrate:
        plain["integrate"] = fa.integrate(plan.model, z0, time=5.0, samples=2, step=job.options.step)
    if job.poincare:
        options = {"crossings": 3, "max_time": job.poincare.max_time, "step": job.options.step}
        plain["poincare"] = fa.poincare_map(plan.model, z0, section=plan.section, **options)
    if job.frequency_map:
        plain["frequency_map"] = fa.frequency_map(plan.model, z0, time=40.0)
    assert bits(stored) == bits(plain)


def test_starts_of_a_file(tmp_path, whole):
    np.save(tmp_path / "z.npy", ONES)
    job = replace(JOBS["own starts"], initial_conditions=InitialConditions(file=str(tmp_path / "z.npy")), chunk=7)
    assert bits(fa.run(job, tmp_path / "s")) == whole("own starts")
    (tmp_path / "z.npy").unlink()  # the store has them
    assert bits(fa.resume(tmp_path / "s")) == whole("own starts")


def test_starts_of_a_file_that_became_another(tmp_path):
    np.save(tmp_path / "z.npy", ONES)
    job = replace(JOBS["own starts"], initial_conditions=InitialConditions(file=str(tmp_path / "z.npy")), chunk=7)
    fa.run(job, tmp_path / "s")
    np.save(tmp_path / "z.npy", ONES + 1e-9)
    with pytest.raises(ValueError, match=r"holds another job: \[initial_conditions\]"):
        fa.run(job, tmp_path / "s")


def test_random_starts_across_blocks(tmp_path):
    """The points do not depend on chunks; those of a longer job begin with those of a shorter."""
    job = replace(
        JOBS["library"],
        options=RunOptions(step=0.5),
        integrate=IntegrateOptions(time=0.5),
        initial_conditions=InitialConditions(orbits=BLOCK + 30),
    )
    long = fa.run(replace(job, chunk=700), tmp_path / "s")
    assert bits(long) == bits(fa.run(job))
    short = fa.run(replace(job, initial_conditions=InitialConditions(orbits=50)))
    assert np.array_equal(short["integrate"].z, long["integrate"].z[..., :50])
    other = fa.run(replace(job, initial_conditions=InitialConditions(orbits=50, seed=1)))
    assert not np.isin(other["integrate"].z, short["integrate"].z).any()


def test_any_order_and_interruption(tmp_path, whole):
    job = replace(CELLS, chunk=7)
    fa.run(job, tmp_path / "one")
    stores_ = tmp_path / "other"
    count = begin(job, stores_).chunks
    for number in np.random.default_rng(1).permutation(count)[: count // 2]:
        chunks.compute_chunk(str(stores_), int(number), 1)
    half = fa.jobs.JobResults.stored(stores_)
    assert not half.complete
    assert 0 < len(half["integrate"].status) < len(fa.run(job)["integrate"].status)
    chunks.compute_chunk(str(stores_), 3, 2)
    chunks.compute_chunk(str(stores_), 3, 1)
    assert bits(fa.resume(stores_)) == whole("cells")
    assert pieces(stores_) == pieces(tmp_path / "one")


def test_ctrl_c_keeps_what_is_finished(tmp_path, whole):
    def ring(progress, chunk):
        if progress.orbits > 30:
            raise KeyboardInterrupt

    with pytest.raises(fa.Interrupted) as stopped:
        fa.run(replace(CELLS, chunk=7), tmp_path / "s", on_chunk=ring)
    partial = stopped.value.partial
    assert not partial.complete
    assert np.count_nonzero(Store(tmp_path / "s").finished() >= 0) == 35
    assert bits(fa.run(replace(CELLS, chunk=7), tmp_path / "s")) == whole("cells")


def test_a_store_without_a_finished_unit_has_empty_results(tmp_path):
    begin(MODEST, tmp_path / "s")
    none = fa.jobs.JobResults.stored(tmp_path / "s")
    assert none["integrate"].status.size == 0
    assert not none.complete
    assert none.table()


# --- executors ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("threads", [1, 2])
def test_a_pool_of_threads(threads, tmp_path, whole):
    with ThreadPoolExecutor(2) as pool:
        assert bits(fa.run(replace(CELLS, chunk=7), tmp_path / "s", executor=pool, threads=threads)) == whole("cells")


def test_a_pool_of_processes(tmp_path, whole):
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        assert bits(fa.run(replace(CELLS, chunk=7), tmp_path / "s", executor=pool)) == whole("cells")
        large = replace(JOBS["1e8"], chunk=7)
        assert bits(fa.run(large, tmp_path / "t", executor=pool)) == whole("1e8")


@pytest.mark.race
def test_workers_that_die(tmp_path, whole, monkeypatch):
    """What is finished stays."""
    monkeypatch.setattr(watching, "PENDING", 2)  # most chunks are not handed over yet when the first is finished
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:

        def kill(progress, chunk):
            for worker in list(pool._processes or ()):
                os.kill(worker, signal.SIGKILL)

        with pytest.raises(BrokenProcessPool, match="abruptly"):
            fa.run(replace(CELLS, chunk=1), tmp_path / "s", executor=pool, on_chunk=kill)
    assert 0 < np.count_nonzero(Store(tmp_path / "s").finished() >= 0) < 66
    assert bits(fa.run(replace(CELLS, chunk=1), tmp_path / "s")) == whole("cells")


@pytest.mark.parametrize("executor", [1, "x", [], object(), multiprocessing, len])
def test_what_is_no_executor(executor, tmp_path):
    with pytest.raises(TypeError, match="executor must have submit"):
        fa.run(MODEST, tmp_path / "s", executor=executor)
    with pytest.raises(TypeError, match="executor must have submit"):
        fa.resume(tmp_path / "s", executor=executor)


def test_an_executor_needs_a_store():
    with ThreadPoolExecutor(1) as pool, pytest.raises(ValueError, match="executor needs a store"):
        fa.run(MODEST, executor=pool)


class Later:
    """A future as those of submitit: it knows done and result alone, and is done some time after."""

    def __init__(self, function, *arguments):
        self.left, self.call = 2, (function, arguments)

    def done(self):
        self.left -= 1
        return self.left < 0

    def result(self):
        function, arguments = self.call
        return function(*arguments)


class Failing:
    """An executor whose work fails after some chunks."""

    def __init__(self, chunks, problem):
        self.chunks, self.problem = chunks, problem

    def submit(self, function, *arguments):
        if self.chunks == 0:

            def function(*_):
                raise self.problem

        self.chunks -= 1
        return Later(function, *arguments)


def test_futures_that_know_little(tmp_path, whole):
    assert bits(fa.run(replace(CELLS, chunk=7), tmp_path / "s", executor=Failing(-1, None))) == whole("cells")


@pytest.mark.parametrize("problem", [RuntimeError("the node is gone"), OSError(errno.ENOSPC, "No space left")])
def test_a_worker_that_fails(problem, tmp_path, whole):
    with pytest.raises(type(problem), match=r"the node is gone|No space left"):
        fa.run(replace(CELLS, chunk=7), tmp_path / "s", executor=Failing(4, problem))
    assert np.count_nonzero(Store(tmp_path / "s").finished() >= 0) == 28
    assert bits(fa.resume(tmp_path / "s")) == whole("cells")


def test_an_executor_that_refuses_work(tmp_path, whole):
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(RuntimeError, match="shutdown"):
        fa.run(replace(CELLS, chunk=7), tmp_path / "s", executor=pool)
    assert bits(fa.resume(tmp_path / "s")) == whole("cells")


def test_a_cancelled_future(tmp_path, whole):
    class Cancelling:
        def submit(self, *_):
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    from concurrent.futures import CancelledError

    with pytest.raises(CancelledError):
        fa.run(replace(CELLS, chunk=7), tmp_path / "s", executor=Cancelling())
    assert bits(fa.resume(tmp_path / "s")) == whole("cells")


@pytest.mark.race
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_of_two_workers_one_of_which_is_killed(tmp_path, whole):
    from distributed import Client, LocalCluster

    fa.run(replace(CELLS, chunk=2), tmp_path / "one")
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as cluster,
        Client(cluster) as client,
    ):
        pids = list(client.run(os.getpid).values())
        killed = []

        def kill(progress, chunk):
            if progress.orbits > 20 and not killed:
                killed.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

        done = fa.run(replace(CELLS, chunk=2), tmp_path / "s", executor=client.get_executor(), on_chunk=kill)
        assert killed
    assert bits(done) == whole("cells")
    assert pieces(tmp_path / "s") == pieces(tmp_path / "one")


# --- what stops a run ---------------------------------------------------------------------------------------------

AGAIN = """
import sys
sys.path.insert(0, {tests!r})
from dataclasses import replace
from job_cases import CELLS
from thorough import TIMES
import fastaff as fa
{first}
print("ready", flush=True)
fa.run(replace(CELLS, chunk=2), {path!r}{more})
print("done", flush=True)
"""


def started(path, first="", more=""):
    return of_python(AGAIN.format(tests=str(ROOT), path=str(path), first=first, more=more))


def of_python(text):
    return subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process):
    with process:
        out, err = process.communicate(timeout=600)  # a hang, not a speed
    return process.returncode, out, err


def test_what_killed_writers_left_goes(tmp_path, whole):
    """Pieces of chunks in the store that Zarr was writing, the old ones; drafts of stores: `test_placing.py`."""
    begin(replace(CELLS, chunk=7), tmp_path / "s")
    chunk = next((tmp_path / "s" / "integrate" / "z").glob("c/*/*"), tmp_path / "s" / "integrate" / "z" / "c" / "0")
    chunk.mkdir(parents=True, exist_ok=True)
    old, young, mine = f"0.{'a1' * 16}.partial", f"0.{'b2' * 16}.partial", "mine.partial"
    for name in (old, young, mine):
        (chunk / name).write_text("x")
        os.utime(chunk / name, None if name == young else (0, 0))
    assert bits(fa.resume(tmp_path / "s")) == whole("cells")
    assert sorted(path.name for path in chunk.glob("*.partial")) == [young, mine]


def test_starts_of_ones_own_are_there_before_the_store_is(tmp_path, monkeypatch):
    """Killed while they were written, there would be a store without them."""
    job = replace(JOBS["own starts"], chunk=7)

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("fastaff.jobs.running.between", stop)
    with pytest.raises(KeyboardInterrupt):
        fa.run(job, tmp_path / "s")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("after", [0, 1, 5, 20, 100])
def test_a_full_disk(after, tmp_path, whole, monkeypatch):
    """Each file that is written may be the one that does not fit: what is there stays, nothing is half written."""
    from zarr.storage import _local

    real, count = _local._put, [0]

    def put(path, value, exclusive=False):
        count[0] += 1
        if count[0] > after:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, value, exclusive)

    monkeypatch.setattr(_local, "_put", put)
    with pytest.raises(OSError, match="No space left") as caught:
        fa.run(replace(CELLS, chunk=7), tmp_path / "s")
    monkeypatch.undo()
    assert str(tmp_path / "s") in str(caught.value.filename)
    assert (f"go on with: fastaff resume {tmp_path / 's'}" in str(caught.value)) == (tmp_path / "s").exists()
    assert not [entry for entry in tmp_path.rglob("*") if entry.name.endswith(".partial")]
    assert [entry.name for entry in tmp_path.iterdir()] == (["s"] if (tmp_path / "s").exists() else [])
    assert bits(fa.run(replace(CELLS, chunk=7), tmp_path / "s")) == whole("cells")


def test_files_that_may_not_grow(tmp_path):
    """As with a full disk, by the system: no file of more than so many bytes."""
    first = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (2500, 2500))"
    code, _, err = ended(started(tmp_path / "s", first))
    assert code == 1
    assert "OSError: [Errno 27] File too large" in err
    assert list(tmp_path.iterdir()) == []
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != 2500


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("old")
    with pytest.raises(OSError, match="file"):
        fa.run(MODEST, tmp_path / "file" / "s")
    with pytest.raises(FileExistsError, match="exists"):
        fa.run(MODEST, tmp_path / "file")
    with pytest.raises(FileExistsError, match="is no store of fastaff"):
        fa.run(MODEST, tmp_path / "file", overwrite=True)
    (tmp_path / "folder").mkdir()
    with pytest.raises(FileExistsError, match="is no store of fastaff"):
        fa.run(MODEST, tmp_path / "folder", overwrite=True)
    assert (tmp_path / "file").read_text() == "old"
    if os.geteuid():
        (tmp_path / "folder").chmod(0o500)
        with pytest.raises(PermissionError):
            fa.run(MODEST, tmp_path / "folder" / "s")
        (tmp_path / "folder").chmod(0o700)
    assert list((tmp_path / "folder").iterdir()) == []


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_finished_store_that_may_not_be_written_can_be_read(tmp_path, whole):
    fa.run(replace(CELLS, chunk=64), tmp_path / "s")
    for entry in (tmp_path / "s").rglob("*"):
        entry.chmod(0o555 if entry.is_dir() else 0o444)
    assert bits(fa.run(replace(CELLS, chunk=64), tmp_path / "s")) == whole("cells")


@pytest.mark.parametrize("where", ["create_group", "rename"])
def test_overwriting_that_fails_leaves_the_old_store(where, tmp_path, monkeypatch):
    fa.run(MODEST, tmp_path / "s")
    before, real = pieces(tmp_path / "s"), os.rename

    def fails(one, other):
        if Path(other) == tmp_path / "s" and Path(one).name != "store":
            raise OSError(errno.ENOSPC, "No space left")
        real(one, other)

    if where == "rename":
        monkeypatch.setattr(stores.os, "rename", fails)
    else:
        monkeypatch.setattr(stores, "_fill", lambda *_: fails("", tmp_path / "s"))
    with pytest.raises(OSError, match="No space left"):
        fa.run(replace(MODEST, options=RunOptions(step=0.05)), tmp_path / "s", overwrite=True)
    monkeypatch.undo()
    assert pieces(tmp_path / "s") == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["s"]
    fa.run(replace(MODEST, options=RunOptions(step=0.05)), tmp_path / "s", overwrite=True)
    assert pieces(tmp_path / "s") != before
    assert [entry.name for entry in tmp_path.iterdir()] == ["s"]


# --- two processes ------------------------------------------------------------------------------------------------


THRICE = """
import sys
sys.path.insert(0, {tests!r})
from dataclasses import replace
from job_cases import CELLS
import fastaff as fa
mine = replace(CELLS, chunk=2)
for job, more in ((mine, {{}}), (mine, {{"overwrite": True}}), (replace(mine, integrate=None), {{"overwrite": True}})):
    try:
        fa.run(job, {path!r}, **more)
    except Exception as problem:
        print(problem)
"""


def test_a_store_that_another_process_writes_is_refused(tmp_path, whole):
    """The same job, the same anew and another one in its place."""
    seen = []

    def second(progress, chunk):
        if not seen:
            text = THRICE.format(tests=str(ROOT), path=str(tmp_path / "s"))
            seen.append(ended(of_python(text)))

    done = fa.run(replace(CELLS, chunk=2), tmp_path / "s", on_chunk=second)
    ((code, out, err),) = seen
    assert (code, err) == (0, "")
    assert [line.count("is being written by another process") for line in out.splitlines()] == [1, 1, 1]
    assert bits(done) == whole("cells")


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_store_that_another_process_makes_meanwhile_is_gone_on_with(tmp_path, whole, monkeypatch, overwrite):
    job, begin = replace(CELLS, chunk=2), running.begin

    def late(*arguments, **options):
        monkeypatch.undo()
        begin(job, tmp_path / "s")
        return begin(*arguments, **options)

    monkeypatch.setattr(running, "begin", late)
    assert bits(fa.run(job, tmp_path / "s", overwrite=overwrite)) == whole("cells")
    assert [entry.name for entry in tmp_path.iterdir()] == ["s"]


@pytest.mark.slow
def test_two_processes_at_once(tmp_path, whole):
    for k in range(3):
        path = tmp_path / str(k)
        both = [started(path), started(path)]
        codes = [ended(process) for process in both]
        assert 0 in [code for code, _, _ in codes]
        for code, _, err in codes:
            assert code == 0 or "another process" in err
        assert bits(fa.run(replace(CELLS, chunk=2), path)) == whole("cells")
        assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith(".")] == []


# --- another job --------------------------------------------------------------------------------------------------

FULL = Job(
    model=TEXT,
    energy_surface=EnergySurface(energy=0.3, section="x=0.0", direction="+1"),
    initial_conditions=InitialConditions(grid="3x3", q_range="-0.1:0.2", p_range="-0.1:0.1"),
    options=RunOptions(step=0.1),
    poincare=PoincareOptions(crossings=1, max_time=20.0),
    frequency_map=FrequencyOptions(time=20.0),
    chaos_map=ChaosOptions(time=5.0),
    integrate=IntegrateOptions(time=1.0),
    chunk=9,
)
OTHER = {
    "model.model": "harmonic",
    "model.map": "p1 = p + a*x; x1 = x + p1",
    "model.ode": "x' = p; p' = -x",
    "model.friction": "0.1*a",
    "model.periodic": ["x=6.3"],
    "model.hamiltonian": "a*x**2/2 + b*y**2/2 + c*x**2*y",
    "model.parameter": ["a=1.0", "b=1.0", "c=0.5"],
    "model.coordinates": "x y",
    "model.momenta": "p s",
    "model.domain": "9 - x**2",
    "model.drive_period": "6.3",
    "model.rotation": "0.3",
    "model.magnetic": "0.2*a",
    "model.vector_potential": ["y=a*x"],
    "model.formula": "D1**2",
    "energy_surface.energy": 0.31,
    "energy_surface.section": "x=0.01",
    "energy_surface.direction": "-1",
    "initial_conditions.grid": "3x4",
    "initial_conditions.q_range": "-0.1:0.21",
    "initial_conditions.p_range": "-0.1:0.11",
    "initial_conditions.seed": 1,
    "initial_conditions.orbits": 9,
    "initial_conditions.axes": ["x=0:0.1:3"],
    "initial_conditions.fixed": ["y=0.1"],
    "initial_conditions.solve": "p_y",
    "initial_conditions.at_rest": True,
    "initial_conditions.microcanonical": True,
    "initial_conditions.file": "z.npy",
    "options.step": 0.11,
    "options.scheme": "YOSHIDA4",
    "options.accuracy": 1e-9,
    "poincare.crossings": 2,
    "poincare.max_time": 21.0,
    "frequency_map.time": 21.0,
    "frequency_map.returns": 3.0,
    "chaos_map.time": 6.0,
    "chaos_map.returns": 3.0,
    "chaos_map.indicators": "sali",
    "chaos_map.early_stop": True,
    "integrate.time": 2.0,
    "integrate.samples": 1,
}


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    path = tmp_path_factory.mktemp("full") / "s"
    fa.run(FULL, path)
    return path


def test_every_field_is_tried():
    tables = [name for name in FULL.tables() if name != "chunk"]
    names = {f"{table}.{entry.name}" for table in tables for entry in dataclasses.fields(getattr(FULL, table))}
    others = {f"model.{name}" for name in ("C", "A", "G", "K", "lam", "mu")} | {
        "energy_surface.p_eta",
        "energy_surface.p_gamma",
    }
    assert names == set(OTHER) | others | {"options.threads"}


@pytest.mark.parametrize(
    "field",
    [
        *OTHER,
        *(f"model.{name}" for name in ("C", "A", "G", "K", "lam", "mu")),
        "energy_surface.p_eta",
        "energy_surface.p_gamma",
    ],
)
def test_a_changed_job_is_refused(field, full):
    table, _, key = field.partition(".")
    before = pieces(full)
    changed = replace(FULL, **{table: replace(getattr(FULL, table), **{key: OTHER.get(field, 0.5)})})
    with pytest.raises(ValueError, match=rf"holds another job: \[{table}\] {key} was .*, is .*overwrite"):
        fa.run(changed, full)
    assert pieces(full) == before


@pytest.mark.parametrize("name", ["poincare", "chaos_map", "integrate"])
def test_analyses_less_or_more_are_refused(name, full):
    with pytest.raises(ValueError, match=rf"holds another job: \[{name}\]"):
        fa.run(replace(FULL, **{name: None}), full)
    with pytest.raises(ValueError, match=r"holds another job: \[action_angles\]"):
        fa.run(replace(FULL, action_angles=fa.jobs.ActionAngleOptions()), full)


def test_threads_and_units_are_no_change(full):
    same = bits(fa.run(FULL, full))
    assert bits(fa.run(replace(FULL, chunk=None, options=replace(FULL.options, threads=2)), full)) == same


def test_models_and_starts_of_ones_own_that_changed_are_refused(tmp_path):
    job = replace(JOBS["1e8"], chunk=23)
    done = bits(fa.run(job, tmp_path / "s"))
    for changed, part in (
        (replace(job, model=LARGE._replace(zero=1.0)), r"\[model\]"),
        (replace(job, model=TEXT), r"\[model\]"),
        (replace(job, initial_conditions=job.initial_conditions * (1 + 1e-15)), r"\[initial_conditions\]"),
        (replace(job, initial_conditions=job.initial_conditions[:, :5]), r"\[initial_conditions\]"),
        (
            replace(job, initial_conditions=InitialConditions(grid="2x2"), energy_surface=EnergySurface(energy=1.0)),
            r"\[initial_conditions\]|\[energy_surface\]",
        ),
        (replace(job, integrate=replace(MOTION, time=1.0)), r"\[integrate\] time"),
    ):
        with pytest.raises(ValueError, match=rf"holds another job: {part}"):
            fa.run(changed, tmp_path / "s")
    with pytest.raises(ValueError, match="model"):
        fa.resume(tmp_path / "s")
    with pytest.raises(ValueError, match="is of the model"):
        fa.resume(tmp_path / "s", model=LARGE._replace(zero=1.0))
    assert bits(fa.resume(tmp_path / "s", model=LARGE)) == done
    fa.run(replace(job, model=TEXT, initial_conditions=ONES), tmp_path / "s", overwrite=True)


def test_a_store_of_another_version_does_not_go_on(tmp_path):
    fa.run(MODEST, tmp_path / "s")
    store = Store(tmp_path / "s", writing=True)
    store.tell(source="0123456789abcdef")
    fa.jobs.JobResults.stored(tmp_path / "s")["integrate"]  # it can be read
    with pytest.raises(ValueError, match="begun by another version of fastaff"):
        fa.run(MODEST, tmp_path / "s")
    with pytest.raises(ValueError, match="begun by another version of fastaff"):
        fa.resume(tmp_path / "s")
    fa.run(MODEST, tmp_path / "s", overwrite=True)
    assert Store(tmp_path / "s").facts["source"] != "0123456789abcdef"


def test_what_is_told_while_it_runs(tmp_path):
    told, shares = [], []
    done = fa.run(MODEST, tmp_path / "s", on_chunk=lambda *what: told.append(what), callback=shares.append)
    assert [progress.orbits for progress, _ in told][-1] == 66
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(done.chunks) == len(told) == Store(tmp_path / "s").chunks
    lines = (tmp_path / "s" / "chunks.jsonl").read_text().splitlines()
    assert [json.loads(line)["number"] for line in lines] == list(range(len(told)))


@pytest.mark.parametrize("store", [1, b"x", [], 1.5, {}, len, "a\0b", "\ud800", True], ids=repr)
@pytest.mark.parametrize(
    "act", [fa.resume, lambda store: fa.run(MODEST, store), lambda s: fa.rerun(s, status="OK", step=0.1)]
)
def test_what_is_no_path(act, store):
    with pytest.raises(TypeError, match="store must be the path of a folder"):
        act(store)


def test_what_is_no_job():
    for job in (None, 1, "job.toml", {}, TEXT, [MODEST]):
        with pytest.raises(TypeError, match="job must be a Job"):
            fa.run(job)
