"""Settings that all tests share."""

import importlib
import os
import shutil
import sys
import zlib
from collections import Counter

# Two test runs on two cores: threads of BLAS that wait for one another made matrices of 500 rows ten times slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A cold cache would add lines to what processes of tests say.
os.environ.setdefault("FASTAFF_PROGRESS", "0")

import numpy as np
import pytest
from deep import DEEP
from hypothesis import settings

settings.register_profile("fastaff", deadline=None, max_examples=25, derandomize=True)
settings.load_profile("fastaff")

if os.environ.get("FASTAFF_TOOLS"):  # where all packages of the tests are installed, one that is missing fails
    pytest.importorskip = lambda name, **_: importlib.import_module(name)


SHARED, ALONE = ("test_inputs", "test_promises"), "test_quantum"
"""Modules that call every function, whose kernels the others find; and those that need next to none."""


def pytest_collection_modifyitems(items):
    """Mark what the deep tier alone runs as slow; order the modules."""
    seen = Counter()
    for item in items:
        name = item.module.__name__, item.originalname
        kept = DEEP.get(name[0], {}).get(name[1])
        seen[name] += 1
        if kept is not None and seen[name] > kept:
            item.add_marker(pytest.mark.slow)
    items[:] = ordered(items)


def ordered(items):
    """Return tests with the modules that compile for all others first and those that compile nothing in the middle,
    where the second of two workers begins: else both compile the same.
    """
    modules = {}
    for item in items:
        modules.setdefault(item.path, []).append(item)
    first, apart, rest = [], [], []
    for path, tests in modules.items():
        (first if path.stem in SHARED else apart if path.stem.startswith(ALONE) else rest).append(tests)
    behind = [*first, *rest]
    sizes = np.cumsum([sum(not any(item.iter_markers("slow")) for item in tests) for tests in behind])
    count = sum(not any(item.iter_markers("slow")) for item in items)
    place = int(np.searchsorted(sizes, count // 2, side="right"))
    return [item for tests in [*behind[:place], *apart, *behind[place:]] for item in tests]


def pytest_runtest_teardown():
    """Close the figures of a test: Matplotlib warns where more than twenty are open."""
    if (pyplot := sys.modules.get("matplotlib.pyplot")) is not None:
        pyplot.close("all")


def pytest_runtest_setup(item):
    """Give a test draws of its own, whichever tests ran before it."""
    generator, seed = getattr(item.module, "RNG", None), zlib.crc32(item.name.encode())
    if isinstance(generator, np.random.Generator):
        item.module.RNG = np.random.default_rng(seed)
    elif generator is not None:
        generator.seed(seed)


@pytest.fixture
def two_threads():
    """Skip where Numba has one thread only."""
    if (os.cpu_count() or 1) < 2 or os.environ.get("NUMBA_NUM_THREADS") == "1":
        pytest.skip("needs two threads")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder, in which the test is."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def refused(here, capsys):
    """What runs a command that is refused in one line, which it returns, and leaves its folder as it was."""
    from fastaff.cli import main

    def run(arguments, said):
        before = sorted(path.name for path in here.iterdir())
        assert main.main(arguments) == 2
        captured = capsys.readouterr()
        told = [line for line in captured.err.splitlines() if "compil" not in line]  # as a cold cache says
        assert len(told) == 1
        assert said in told[0]
        assert captured.out == ""
        assert sorted(path.name for path in here.iterdir()) == before
        return captured.err

    return run


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """A store of a small job, which nobody changes."""
    from job_cases import SMALL_GRID

    import fastaff

    path = tmp_path_factory.mktemp("made") / "s"
    fastaff.run(SMALL_GRID, path)
    return path


@pytest.fixture
def store(made, tmp_path):
    """A copy of it."""
    return shutil.copytree(made, tmp_path / "s")


@pytest.fixture
def ax():
    """Axes of a figure that is drawn at the end."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 5), dpi=100)
    FigureCanvasAgg(figure)
    yield figure.subplots()
    figure.canvas.draw()


@pytest.fixture
def unwarned(monkeypatch):
    """As in a process that has not warned of its cache yet."""
    from fastaff.engine import cache

    monkeypatch.setattr(cache, "_SAID", set())
