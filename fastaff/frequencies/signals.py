"""Signals of sampled orbits, each of as many samples as it needs, and the memory of samples and spectra."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np


class Signals(NamedTuple):
    """Rows of equidistant samples of orbits in one array of numbers: those of an orbit side by side, each row after the
    other.

    start, samples, interval (orbits,): the start of an orbit's first row, the number of samples of a row, and the time
    between two.
    """

    numbers: np.ndarray
    rows: int
    start: np.ndarray
    samples: np.ndarray
    interval: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Time (orbits,) from the first sample to the last."""
        return (self.samples - 1) * self.interval

    @property
    def ragged(self) -> tuple[np.ndarray, int, np.ndarray, np.ndarray]:
        """The arguments of kernels, for `frequencies.kernels.fundamental.rows_of`."""
        return self.numbers, self.rows, self.start, self.samples

    def of(self, orbits: np.ndarray | slice) -> Signals:
        """Return the signals of some orbits."""
        return self._replace(start=self.start[orbits], samples=self.samples[orbits], interval=self.interval[orbits])

    def with_rows(self, rows: list[int]) -> Signals:
        """Return signals of these rows alone, in this order."""
        parts = [self.array(np.array([o]))[0][rows].ravel() for o in range(self.samples.size)]
        count = len(rows) * self.samples
        return Signals(np.concatenate(parts), len(rows), np.cumsum(count) - count, self.samples, self.interval)

    def alike(self, orbits: np.ndarray | None = None) -> Iterator[np.ndarray]:
        """Yield the numbers of orbits, of the given ones or of all, that have equally many samples."""
        orbits = np.arange(self.samples.size) if orbits is None else orbits
        for count in np.unique(self.samples[orbits]):
            yield orbits[self.samples[orbits] == count]

    def array(self, orbits: np.ndarray) -> np.ndarray:
        """Return the signals (orbits, rows, samples) of orbits that have equally many."""
        size = self.rows * int(self.samples[orbits[0]])
        start = self.start[orbits]
        if (np.diff(start) == size).all():
            flat = self.numbers[start[0] : start[0] + start.size * size]
        else:
            flat = self.numbers[start[:, None] + np.arange(size)]
        return flat.reshape(start.size, self.rows, -1)


def signals_of(s: np.ndarray, interval: float) -> Signals:
    """Return the signals of an array (orbits, rows, samples)."""
    orbits, rows, samples = s.shape
    start = np.arange(orbits) * (rows * samples)
    count = np.full(orbits, samples)
    return Signals(np.ascontiguousarray(s).reshape(-1), rows, start, count, np.full(orbits, interval))


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
    """Memory that the arrays of one set of orbits after another use."""

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

    def complexes(self, *shape: int) -> np.ndarray:
        """Return a complex array of that shape, with arbitrary numbers."""
        return self.array(*shape[:-1], 2 * shape[-1]).view(complex)


class Buffers(threading.local):
    """Rooms of the calls of a thread: for signals of runs, those of their starts with a finer step, spectra and the
    sums of bands; values, transforms and sums of single loops.
    """

    def __init__(self):
        self.signals = ReusableBuffer()
        self.starts = ReusableBuffer()
        self.spectra = ReusableBuffer()
        self.bands = ReusableBuffer()
        self.values = ReusableBuffer()
        self.windowed = ReusableBuffer()
        self.sums = ReusableBuffer()


BUFFERS = Buffers()
