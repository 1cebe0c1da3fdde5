"""Memory of samples and spectra, which one set of orbits after another uses."""

from __future__ import annotations

import math
import threading

import numpy as np

KEPT = 1 << 27
"""Bytes up to which memory is kept for the next call: to get new pages costs as much as a run."""


LINE = 8
"""Numbers in a line of the cache: arrays begin with one, or each vector of a row would lie in two."""


def in_lines(size: int) -> np.ndarray:
    """Return an array (size,) that begins with a line of the cache, with arbitrary numbers."""
    numbers = np.empty(size + LINE)
    begin = -(numbers.ctypes.data // numbers.itemsize) % LINE
    return numbers[begin : begin + size]


class ReusableBuffer:
    """Memory that one array after another uses."""

    def __init__(self):
        self._numbers = np.empty(0)

    def array(self, *shape: int) -> np.ndarray:
        """Return an array of that shape, with arbitrary numbers."""
        size = math.prod(shape)
        if size * self._numbers.itemsize > KEPT:
            return in_lines(size).reshape(shape)
        if self._numbers.size < size:
            self._numbers = in_lines(size)
        return self._numbers[:size].reshape(shape)


class Buffers(threading.local):
    """Rooms of the calls of a thread: for signals of runs, those of their starts with a finer step, spectra and the
    sums of bands.
    """

    def __init__(self):
        self.signals, self.starts, self.spectra, self.bands = (
            ReusableBuffer(),
            ReusableBuffer(),
            ReusableBuffer(),
            ReusableBuffer(),
        )


BUFFERS = Buffers()
