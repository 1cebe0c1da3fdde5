"""The lowest eigenvalues of a matrix by LAPACK, called by its address: SciPy's own call keeps Python's lock until it
ends, so that Ctrl-C and progress would wait for a minute.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

import numpy as np


@functools.cache
def _solver() -> Any:
    from ...engine.numba_private import get_cython_function_address

    address = get_cython_function_address("scipy.linalg.cython_lapack", "dsyevr")
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 21)(address)


def lowest_states(H: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest `count` eigenvalues of a symmetric matrix (n, n) and their vectors (n, count), with the bits of
    `scipy.linalg.eigh` and its driver "evr". Raises LinAlgError where they are not found.
    """
    size = len(H)
    a = np.array(H, dtype=float, order="F")
    w = np.zeros(size)
    v = np.zeros((size, count), order="F")
    support = np.zeros(2 * size, np.int32)

    def call(work: np.ndarray, whole: np.ndarray, asked: tuple[int, int]) -> None:
        found = np.zeros(1, np.int32)
        info = np.zeros(1, np.int32)
        n = np.array([size, 1, count, *asked], np.int32)
        nothing = np.zeros(1)
        letters = np.frombuffer(b"VIL", np.uint8)
        at = [n[k:].ctypes.data for k in range(5)]
        how = [letters[k:].ctypes.data for k in range(3)]
        zero = nothing.ctypes.data
        _solver()(
            *how, at[0], a.ctypes.data, at[0], zero, zero, at[1], at[2], zero, found.ctypes.data, w.ctypes.data,
            v.ctypes.data, at[0], support.ctypes.data, work.ctypes.data, at[3], whole.ctypes.data, at[4],
            info.ctypes.data,
        )  # fmt: skip
        if info[0] or (asked[0] > 0 and found[0] != count):
            raise np.linalg.LinAlgError(f"dsyevr found {found[0]} of {count} levels (info {info[0]})")

    work = np.zeros(1)
    whole = np.zeros(1, np.int32)
    call(work, whole, (-1, -1))
    lengths = int(work[0]), int(whole[0])
    call(np.zeros(lengths[0]), np.zeros(lengths[1], np.int32), lengths)
    return w[:count], v
