"""Benchmarks import from this folder and from tests/. Each puts its measurements into `numbers`."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
TESTS = HERE.parent / "tests"
sys.path[:0] = [str(HERE), str(TESTS), str(TESTS / "explorer")]

FOUND = pytest.StashKey[dict]()


def pytest_addoption(parser):
    """Add the option."""
    parser.addoption("--numbers", help="file for all numbers, as JSON: for bench/tables.py")


def pytest_configure(config):
    """Begin with no numbers."""
    config.stash[FOUND] = {}


@pytest.fixture
def timed(benchmark):
    """Return the shortest run time of a function by pytest-benchmark, the first run left out: for one of each test."""

    def shortest(function, *, repeats=5):
        benchmark.pedantic(function, rounds=repeats, warmup_rounds=1)
        return benchmark.stats.stats.min

    return shortest


@pytest.fixture
def numbers(request):
    """Give a benchmark the dictionary for its measurements; it is printed (-s), and kept for --numbers."""
    found = {}
    extra = request.getfixturevalue("benchmark").extra_info if "benchmark" in request.fixturenames else {}
    yield found
    if not found:  # it was skipped
        return
    plain = {key: value.tolist() if isinstance(value, np.generic) else value for key, value in found.items()}
    said = (f"{key} {value:.3g}" if isinstance(value, float) else f"{key} {value}" for key, value in plain.items())
    print(f"\n{request.node.name}: {'; '.join(said)}")
    extra.update(plain)
    name = f"bench/{request.path.name}::{request.node.originalname}"
    request.config.stash[FOUND].setdefault(name, []).append(plain)


def pytest_sessionfinish(session):
    """Write the numbers: for each benchmark one dictionary for each of its parameters, in their order."""
    if session.config.getoption("numbers"):
        Path(session.config.getoption("numbers")).write_text(json.dumps(session.config.stash[FOUND]))
