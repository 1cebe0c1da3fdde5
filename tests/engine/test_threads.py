"""Threads of compiled code, and Ctrl-C at any moment: none writes to memory that was let go of, nothing hangs."""

from __future__ import annotations

import gc
import os
import random
import signal
import subprocess
import sys
import threading
import time
import traceback
import warnings
import weakref

import battery
import numpy as np
import pytest
from comparison import same
from thorough import TIMES

import fastaff as fa
from fastaff.core.memory import SETTINGS, keep_freed
from fastaff.engine import packing
from fastaff.engine.threads import (
    FEW,
    Task,
    _tasks,
    available_threads,
    by_portions,
    by_workers,
    join_all,
    own_threads,
    works,
)
from fastaff.runs.options import Options, plan

TRIES = 150 * TIMES


def fill(unit, out, rounds):
    for _ in range(rounds * (1 + 10 * unit)):
        for i in range(out.shape[1]):
            out[unit, i] = 0.5 * out[unit, i] + unit


forking = pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks here")


def settled(task):
    """Wait until a thread has made it."""
    while not task.ended(10.0):
        pass


@pytest.mark.race
def test_freed_memory_is_used_again():
    """The pages of a section's arrays are not new ones in each call, unless the environment says so."""
    if not keep_freed({}):
        pytest.skip("no glibc here")
    code = (
        "import resource, numpy as np, fastaff as fa\n"
        "z0 = 0.1*np.random.default_rng(1).standard_normal((4, 64))\n"
        "def faults():\n"
        "    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt\n"
        "    fa.poincare_map(fa.HenonHeiles(), z0, section='x=0', crossings=400, max_time=4e3, step=0.2, threads=1)\n"
        "    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before\n"
        "print([faults() for _ in range(4)][-1])\n"
    )
    told = {}
    for name in ("here", *SETTINGS[:1]):
        kept = {key: value for key, value in os.environ.items() if key not in SETTINGS} | {name: "131072"}
        told[name] = int(subprocess.run([sys.executable, "-c", code], env=kept, capture_output=True, check=True).stdout)
    assert told["here"] < 100 < told[SETTINGS[0]]


def test_a_task_is_made_once_by_a_thread():
    said = []
    task = Task(lambda: said.append(threading.current_thread() is threading.main_thread()))
    assert not task.ended(0.0)
    task.begin()
    settled(task)
    task.begin()
    join_all([task])
    assert task.cancelled()
    assert said == [False]


def test_what_was_taken_back_is_never_made():
    said = []
    task = Task(lambda: said.append(1))
    assert task.cancelled()
    task.begin()
    last = Task(lambda: None)
    last.begin()
    settled(last)
    assert not task.ended(0.05)
    assert task.cancelled()
    assert said == []


def test_what_a_task_raises_is_its_owners():
    def fail():
        raise ZeroDivisionError

    task = Task(fail)
    task.begin()
    with pytest.raises(ZeroDivisionError):
        settled(task)
    with pytest.raises(ZeroDivisionError):
        task.ended(0.0)
    join_all([task])


def test_a_task_needs_no_thread_that_is_busy():
    """Others may keep all threads for hours."""
    go = threading.Event()
    long = [Task(go.wait) for _ in range(2 * available_threads())]
    for task in long:
        task.begin()
    said = []
    task = Task(lambda: said.append(1))
    task.begin()
    settled(task)
    go.set()
    for entry in (*long, *(Task(lambda: None) for _ in range(available_threads()))):
        entry.begin()
        settled(entry)
    task.make()
    assert said == [1]


@pytest.mark.race
def test_a_thread_keeps_nothing_of_what_it_has_done():
    class Held:
        pass

    held = Held()
    gone = weakref.ref(held)
    task = Task(lambda held=held: None)
    task.begin()
    settled(task)
    del task, held
    for _ in range(1000):  # until the thread has gone back for more
        if gone() is None:
            break
        time.sleep(0.01)
    assert gone() is None


@pytest.mark.parametrize("at", ["begin", "ended"])
def test_threads_hold_what_they_write_to(at, monkeypatch):
    """Where Ctrl-C comes between the caller's units and the others' end, or between two beginnings."""
    begun = []

    class Late(Task):
        def begin(self):
            begun.append(self)
            if at == "begin":
                raise KeyboardInterrupt

        def cancelled(self):
            return False

        def ended(self, seconds):
            raise KeyboardInterrupt

    monkeypatch.setattr(packing, "Task", Late)

    def given_up():
        out = np.zeros((3, 4))
        with pytest.raises(KeyboardInterrupt):
            packing.run_units(fill, (out, 2), 3, threads=2)
        return out.copy(), weakref.ref(out)

    seen, out = given_up()
    gc.collect()
    assert out() is not None
    begun[0].make()
    np.testing.assert_array_equal(out(), seen)  # no unit is begun any more
    begun.clear()
    gc.collect()
    assert out() is None


def units():
    packing.run_units(fill, (np.zeros((2, 100_000)), 2), 2, threads=2)


def first():
    """Units by threads that begin."""
    _tasks.cache_clear()
    units()


def orbits():
    fa.integrate(fa.HenonHeiles(), np.full((4, 8), 0.1), time=400.0, step=0.02, threads=2)


def lines():
    fa.naff(np.exp(1j * np.arange(1024))[None] * np.ones((70, 1)), dt=1.0, lines=3, threads=2)


def interrupted(call, again):
    """Interrupt a call at random moments in a fork of this process, then do `again`; return its exit code."""
    begin = time.perf_counter()
    call()
    seconds = min(1.2 * (time.perf_counter() - begin), 0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads, which a fork has none of
        child = os.fork()
    if child == 0:
        code = 1
        try:
            source = random.Random(3)
            signal.signal(signal.SIGALRM, signal.default_int_handler)
            for _ in range(TRIES):
                try:
                    signal.setitimer(signal.ITIMER_REAL, max(1e-5, source.uniform(0.0, seconds)))
                    call()
                    signal.setitimer(signal.ITIMER_REAL, 0.0)
                except KeyboardInterrupt:
                    signal.setitimer(signal.ITIMER_REAL, 0.0)  # the call before may have been interrupted this late
                    others = np.zeros((2, 100_000))
                    time.sleep(0.001)
                    assert not others.any()
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            again()
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    for _ in range(6000 * TIMES):
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    pytest.fail("it hangs")


@pytest.mark.race
@forking
@pytest.mark.parametrize("call", [units, first, orbits, lines])
def test_ctrl_c_at_any_moment(call):
    call()  # compiled
    assert interrupted(call, call) == 0


@pytest.mark.race
@forking
@pytest.mark.skipif(TIMES == 1, reason="takes minutes: make faults")
@pytest.mark.parametrize("name", sorted(set(battery.CALLS) - {"run", "univariate", "TuneAccumulator"}))
def test_ctrl_c_in_any_call(name):
    """What it gives has the same bits after many that were interrupted; what those left out give has no equality."""
    truth = battery.call(name, battery.base(name))

    def again():
        same(battery.call(name, battery.base(name)), truth)

    assert interrupted(lambda: battery.call(name, battery.base(name)), again) == 0


def once(unit, made):
    made[unit] += 1


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_units_are_all_run_once(threads):
    """Whatever their number, and that of the threads, which take parts of several units where there are many."""
    for number in (1, 2, 63, 64, 65, 1000, 20_000):
        made = np.zeros(number, np.int64)
        packing.run_units(once, (made,), number, threads=threads)
        assert (made == 1).all(), number


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_portions_are_all_made_once(threads):
    """Whatever the threads, in ones of their own where there are enough numbers; what one raises is raised."""
    made, names = np.zeros(1000, np.int64), set()

    def add(at):
        made[at] += 1
        names.add(threading.current_thread().name)

    by_portions(add, 1000, FEW, threads)
    assert (made == 1).all()
    by_portions(add, 1000, 1, threads)
    assert (made == 2).all()
    by_portions(add, 1000, np.zeros(1000), threads)
    by_portions(lambda at: pytest.fail(str(at)), 0, np.zeros(0), threads)
    assert (made == 3).all()
    assert threading.main_thread().name in names

    def fail(at):
        if at.stop == 1000:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        by_portions(fail, 1000, FEW, threads)


def test_portions_have_equal_numbers():
    """Of items of different numbers, as of orbits with more samples than others."""
    each, made = np.random.default_rng(3).integers(0, 4 * FEW, 1000), []
    by_portions(lambda at: made.append((at.start, at.stop)), each.size, each, 4)
    numbers = [each[begin:end].sum() for begin, end in made]
    assert sum(numbers) == each.sum()
    assert max(numbers) - min(numbers) <= 2 * each.max()


@pytest.mark.parametrize("threads", [4, 9])
def test_what_a_portion_launches_runs_in_its_own_thread_too(threads):
    """Where it waited for another one, all threads might wait; those that are free may help."""
    plane = fa.HenonHeiles()
    z0 = np.array([0.0, 0.1, 0.4, 0.1])[:, None] + 1e-3 * np.arange(800)
    found, launched = [None] * 4, []

    def run(at):
        flow = plan(plane, z0[:, at], Options(step=0.05, threads=2)).flow
        ensemble = flow.ensemble(z0[:, at].copy())
        states = flow.sampled(ensemble, 4, time=20.0)
        launched.append(works())
        found[at.start // 200] = states

    by_portions(run, 800, FEW, threads)
    assert launched == [True] * 4
    whole = fa.integrate(plane, z0, time=20.0, step=0.05, samples=4)
    np.testing.assert_array_equal(np.concatenate(found), whole.samples.transpose(2, 0, 1))


def test_portions_share_the_threads():
    """Each has its part of them for kernels and for portions of its own, which are made once; what one raises is
    raised, and a later portion begins with one thread again.
    """
    seen, made, lock = [], np.zeros((4, 50), np.int64), threading.Lock()

    def inner(row, number):
        with lock:
            made[row, number] += 1
            seen.append(own_threads(8))
        if number == 49:
            raise ZeroDivisionError

    def outer(at):
        row = at.start // 200
        seen.append(own_threads(8))
        by_workers(lambda number: inner(row, number), 40)
        with pytest.raises(ZeroDivisionError):
            by_workers(lambda number: inner(row, 40 + number), 10)
        seen.append(own_threads(8))

    assert own_threads(8) == 8
    by_portions(outer, 800, FEW, 8)
    assert (made[:, :40] == 1).all()
    assert (made <= 1).all()
    assert sorted(seen)[-8:] == [2] * 8
    assert set(seen) == {1, 2}
    alone = []
    by_portions(lambda at: alone.append(own_threads(8)), 800, FEW, 2)
    assert alone == [1, 1]
