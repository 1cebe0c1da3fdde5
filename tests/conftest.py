"""Settings that all tests share."""

import os

# Two test runs on two cores: threads of BLAS that wait for one another made matrices of 500 rows ten times slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

settings.register_profile("fastaff", deadline=None, max_examples=25, derandomize=True)
settings.load_profile("fastaff")


@pytest.fixture
def two_threads():
    """Skip where Numba has one thread only."""
    if (os.cpu_count() or 1) < 2 or os.environ.get("NUMBA_NUM_THREADS") == "1":
        pytest.skip("needs two threads")
