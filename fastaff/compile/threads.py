"""Threads that run compiled code: how many, and the pool that they belong to.

Compiled code lets go of the GIL, so Python's own threads will do. They leave nothing behind that a fork could not
survive, as OpenMP does, and several callers may use them at once.
"""

from __future__ import annotations

import functools
import os
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numba
from numba.np.ufunc import parallel

from ..base.numbers import whole
from .jit import JIT_DISABLED


def default_threads() -> int:
    """Return the number of threads that kernels use unless told otherwise: of `numba.set_num_threads` if it was called,
    else $NUMBA_NUM_THREADS or the cores of this process.
    """
    if JIT_DISABLED:
        return 1
    # To ask Numba would start its own threads, where that has not happened yet.
    return numba.get_num_threads() if parallel._is_initialized else available_threads()


def available_threads() -> int:
    """Return the largest number of threads that kernels can use in this process."""
    return 1 if JIT_DISABLED else int(numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


def checked_threads(threads: Any) -> int:
    """Return the number of threads to use: `threads` if it is one this process can have, the default for None."""
    count = default_threads() if threads is None else whole("threads", threads, 1)
    if count > available_threads():
        raise ValueError(f"threads must be at most {available_threads()} here, got {count}")
    return count


def pool() -> ThreadPoolExecutor:
    """Return the threads of this process; a fork has none of its parent's."""
    return _pool(os.getpid())


@functools.cache
def _pool(process: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(available_threads(), thread_name_prefix="fastaff")
