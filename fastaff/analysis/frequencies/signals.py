"""Signals of sampled orbits, each of as many samples as it needs, and the tables of windows that these take."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np


class Signals(NamedTuple):
    """Rows of equidistant samples of orbits in one array of numbers: those of an orbit side by side, each row after the
    other.

    start, samples, interval (orbits,): where an orbit's first row begins, how many samples a row has, and the time
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
        """What kernels take, for `kernels.fundamental.rows_of`."""
        return self.numbers, self.rows, self.start, self.samples

    def of(self, orbits: np.ndarray) -> Signals:
        """Return those of some orbits."""
        return self._replace(start=self.start[orbits], samples=self.samples[orbits], interval=self.interval[orbits])

    def alike(self, orbits: np.ndarray | None = None) -> Iterator[np.ndarray]:
        """Yield the numbers of those of the orbits, or of all, that have equally many samples."""
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
    start, count = np.arange(orbits) * (rows * samples), np.full(orbits, samples)
    return Signals(np.ascontiguousarray(s).reshape(-1), rows, start, count, np.full(orbits, interval))


BRIEF = 16384
"""Samples up to which many tables are kept."""


def tabulated(make: Callable[..., Any], most: int = 2) -> Callable[..., Any]:
    """Keep what make(samples, ...) returns: many tables of few samples, `most` of many."""
    brief, long = functools.lru_cache(maxsize=64)(make), functools.lru_cache(maxsize=most)(make)

    @functools.wraps(make)
    def made(samples: int, *more: Any) -> Any:
        return (brief if samples <= BRIEF else long)(samples, *more)

    return made


class Tables(NamedTuple):
    """Tables of weights for different numbers of samples, one after the other: an orbit's begins at its `start`."""

    numbers: np.ndarray
    start: np.ndarray


def tables_for(make: Callable[[int], np.ndarray], counts: np.ndarray) -> Tables:
    """Return make(count), arrays, of the counts (orbits,)."""
    different, which = np.unique(counts, return_inverse=True)
    if different.size == 1:
        return Tables(make(int(different[0])).reshape(-1), np.zeros(counts.size, np.int64))
    numbers, start = _joined(make, tuple(int(count) for count in different))
    return Tables(numbers, start[which])


@functools.lru_cache(maxsize=16)
def _joined(make: Callable[[int], np.ndarray], counts: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    made = [make(count).reshape(-1) for count in counts]
    sizes = np.array([table.size for table in made])
    return np.concatenate(made), np.cumsum(sizes) - sizes
