"""Windows over samples, and the tables of their weights."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..engine.kernels.birkhoff import SHARPNESS
from .kernels.fundamental import WindowTables

WINDOW_ORDER = 3
"""p of the window (1 + cos)^p of sums over samples."""

APART_ORDER = 3
"""p of the window of lines that stand apart."""

GOLDEN = (math.sqrt(5) - 1) / 2
SPANS = ((0.0, 1.0), (0.0, 0.5), (0.5, 1.0), (0.0, GOLDEN), (1.0 - GOLDEN, 1.0), (0.2, 0.2 + math.sqrt(0.4)))
"""Windows of averages: the whole, both halves, and others whose lengths and starts have no common phase."""

BRIEF = 16384
"""Samples up to which many tables are kept."""


def tabulated(make: Callable[..., Any], most: int = 2) -> Callable[..., Any]:
    """Keep the tables that make(samples, ...) returns: many of few samples, `most` of many."""
    brief, long = functools.lru_cache(maxsize=64)(make), functools.lru_cache(maxsize=most)(make)

    @functools.wraps(make)
    def made(samples: int, *more: Any) -> Any:
        return (brief if samples <= BRIEF else long)(samples, *more)

    return made


def tables_for(make: Callable[[int], np.ndarray], counts: np.ndarray) -> WindowTables:
    """Return make(count), arrays, of the counts (orbits,)."""
    different, which = np.unique(counts, return_inverse=True)
    if different.size == 1:
        return WindowTables(make(int(different[0])).reshape(-1), np.zeros(counts.size, np.int64))
    numbers, start = _joined(make, tuple(int(count) for count in different))
    return WindowTables(numbers, start[which])


@functools.lru_cache(maxsize=16)
def _joined(make: Callable[[int], np.ndarray], counts: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    made = [make(count).reshape(-1) for count in counts]
    sizes = np.array([table.size for table in made])
    return np.concatenate(made), np.cumsum(sizes) - sizes


def fast_length(samples: int) -> int:
    """Return the largest number up to `samples` whose Fourier transform is fast."""
    from scipy.fft import prev_fast_len  # not at import, which it would make slow

    return prev_fast_len(samples)


def fast_lengths(samples: np.ndarray) -> np.ndarray:
    """Return `fast_length` of each number."""
    different, which = np.unique(samples, return_inverse=True)
    return np.array([fast_length(int(n)) for n in different], dtype=np.int64)[which]


def weight_at(x: np.ndarray) -> np.ndarray:
    """Return the weight at -1 < x < 1 of a window, 0 outside it."""
    y = 1 - x * x
    return np.where(y > 0, np.exp(SHARPNESS * (np.sqrt(np.maximum(y, 0.0)) - 1)), 0.0)


@tabulated
def bump(samples: int, x0: float, x1: float) -> np.ndarray:
    """Return weights (samples,) at the middles of samples equal parts of (0, 1), over the span x0 to x1, of sum 1."""
    w = weight_at(2 * ((np.arange(samples) + 0.5) / samples - x0) / (x1 - x0) - 1)
    return w / (w.sum() or 1.0)


@tabulated
def growth_windows(samples: int) -> np.ndarray:
    """Return the weights (3, samples - 1) that `frequencies.kernels.fundamental.growth` takes."""
    return np.array([bump(samples - 1, *SPANS[i]) for i in (0, 3, 4)])


def damping(cycles: np.ndarray) -> np.ndarray:
    """Return an upper bound of the share, in a weighted average, of a line so many cycles per window from zero."""
    root = np.sqrt(np.maximum(SHARPNESS**2 - (np.pi * cycles) ** 2, 0.0))
    return np.exp(root - SHARPNESS)


@tabulated
def cosine_window(samples: int) -> np.ndarray:
    """Return the window (1 + cos)^WINDOW_ORDER of sum 1."""
    w = (1 + np.cos(2 * np.pi * (np.arange(samples) - (samples - 1) / 2) / samples)) ** WINDOW_ORDER
    return w / w.sum()


@tabulated
def apart_window(samples: int) -> np.ndarray:
    """Return the window of lines that stand apart, of sum 1, whose transform is closed."""
    times = 2 * np.pi * (np.arange(samples) - (samples - 1) / 2) / samples
    weight = np.ones(samples)
    for i in range(APART_ORDER):
        weight *= np.cos(times) + math.cos((2 * i + 1) * math.pi / samples)
    return weight / weight.sum()
