"""Kernels in processes that fork, threads that use them at once, and how many threads they take: each in a process of
its own, for a fork takes over what its parent has started.
"""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import fastaff
from fastaff.engine import jit

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
TESTS, PACKAGE = Path(__file__).parents[1], Path(fastaff.__file__).parents[1]

BEGINNING = """
import multiprocessing, sys, warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
import numpy as np
import fastaff as fa
warnings.filterwarnings("ignore", message=".*fork.*", category=DeprecationWarning)

body = fa.HenonHeiles()
z0 = 0.1*np.random.default_rng(1).standard_normal((4, 1000))

def part(k):
    found = fa.integrate(body, z0[:, k::4], time=BRIEF, step=0.05, threads=2)
    return found.z

def alike(parts):
    return all(np.array_equal(got, whole[:, k::4]) for k, got in enumerate(parts))

BRIEF = 50.0
whole = fa.integrate(body, z0, time=BRIEF, step=0.05, threads=2).z
"""


def python(code, **env):
    """Run code after BEGINNING in a fresh process with two threads; return its lines of output."""
    environment = (
        os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (TESTS, PACKAGE))), "NUMBA_NUM_THREADS": "2"} | env
    )
    command = [sys.executable, "-W", "error", "-c", BEGINNING + textwrap.dedent(code)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)  # a hang, not a speed
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout.splitlines()


FORKING = {
    "Pool": """
        with multiprocessing.get_context("fork").Pool(2) as pool:
            print(alike(pool.map(part, range(4))))
        """,
    "ProcessPoolExecutor": """
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as pool:
            print(alike(pool.map(part, range(4))))
        """,
    "a fork of a fork": """
        import os
        child = os.fork()
        if child == 0:
            with multiprocessing.get_context("fork").Pool(1) as pool:
                os._exit(0 if alike([*map(part, range(2)), *pool.map(part, range(2, 4))]) else 1)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0 and alike(map(part, range(4))))
        """,
    "frequencies, sections and quantum": """
        def others(k):
            section = fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
            cut = fa.poincare_map(body, z0[:, :40], section=section, crossings=5, max_time=100.0, step=0.05)
            state = fa.quantum.wavefunction(fa.Body(fa.Harmonic()), m=1, l=1, n=(2, 3))
            planes = np.random.default_rng(3).normal(size=(4, 10_000))
            return cut.points, fa.naff(np.sin(0.3*np.arange(4096.0)), 1.0, lines=2).nu, state.planes(planes)

        mine = others(0)
        with multiprocessing.get_context("fork").Pool(2) as pool:
            found = pool.map(others, range(2))
            print(all(np.array_equal(a, b, equal_nan=True) for k in found for a, b in zip(k, mine)))
        """,
}


@pytest.mark.parametrize("way", FORKING)
@pytest.mark.skipif(jit.JIT_DISABLED, reason="no threads")
def test_a_fork_after_use_computes_the_same(way):
    assert python(FORKING[way]) == ["True"]


def test_joblib_with_processes_that_fork():
    code = """
        from joblib import Parallel, delayed
        print(alike(Parallel(n_jobs=2, backend="multiprocessing")(delayed(part)(k) for k in range(4))))
        """
    assert python(code) == ["True"]


def test_a_job_by_processes_that_fork(tmp_path):
    code = f"""
        from job_cases import CELLS, bits
        one = fa.run(CELLS, {str(tmp_path / "a")!r})
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as pool:
            other = fa.run(CELLS, {str(tmp_path / "b")!r}, executor=pool)
        print(bits(one) == bits(other))
        """
    assert python(code) == ["True"]


@pytest.mark.skipif(jit.JIT_DISABLED, reason="no threads")
def test_several_threads_of_a_user_at_once():
    code = """
        with ThreadPoolExecutor(8) as pool:
            print(*pool.map(lambda n: alike(map(part, range(4))), range(8)))
        """
    assert python(code) == [" ".join(["True"] * 8)]


ENDLESS = {
    "integrate": "fa.integrate(body, z0, time=1e9, step=0.05, threads={threads})",
    "naff": "fa.naff(np.random.default_rng(1).normal(size=(9000, 8192)), dt=1.0, lines=9, threads={threads})",
    "calls": "[fa.integrate(body, z0, time=9.0, step=0.05, threads={threads}) for _ in range(10**7)]",
}


@pytest.mark.race
@pytest.mark.skipif(jit.JIT_DISABLED, reason="no threads")
@pytest.mark.parametrize(("name", "threads"), [("integrate", 2), ("naff", 2), ("calls", 1)])
def test_the_interpreter_ends_while_daemon_threads_compute(name, threads):
    """It waits for none of them to be done; none writes to memory that it lets go of, or takes half for a result. Nor
    does other work wait for them.
    """
    code = f"""
        import atexit, threading
        begun = threading.Event()
        atexit.register(lambda: print(np.array_equal(whole, fa.integrate(body, z0, time=50.0, step=0.05, threads=2).z)))

        def work():
            begun.set()
            try:
                {ENDLESS[name].format(threads=threads)}
            except Exception:
                pass
            print("done")

        threading.Thread(target=work, daemon=True).start()
        begun.wait()
        fa.integrate(body, z0, time=200.0, step=0.05, threads=1)
        print("left")
        """
    assert python(code) == ["left", "True"]


@pytest.mark.skipif(jit.JIT_DISABLED, reason="no threads")
def test_the_number_of_threads_is_that_of_the_user():
    code = """
        import threading, numba
        from numba.np.ufunc import parallel
        from fastaff.engine.threads import default_threads
        print(default_threads(), parallel._is_initialized)
        numba.set_num_threads(1)
        print(default_threads())
        print(sum(thread.name.startswith("fastaff") for thread in threading.enumerate()) <= 2)
        """
    assert python(code) == ["2 False", "1", "True"]
