"""The strongest lines of complex signals, with amplitudes and errors, by harmonic inversion of their bands."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .fundamental import run, transforms_of
from .kernels import plane_lines as kernels
from .windows import APART_ORDER, fast_length

AT_ONCE = 1 << 18
"""Samples whose transforms are made at once: they stay in the cache."""


class PlaneLines(NamedTuple):
    """Lines sum_k amplitude_k exp(2 pi i nu_k t) of signals (..., lines), t in samples, the largest first: nu in
    cycles per sample, signed, complex amplitudes at the first sample, and errors of nu. A missing line has nu 0,
    amplitude 0 and error inf.
    """

    nu: np.ndarray
    amplitude: np.ndarray
    error: np.ndarray

    def of(self, signals: np.ndarray) -> PlaneLines:
        """Return the lines of these signals alone."""
        return PlaneLines(*(entry[signals] for entry in self))


def plane_lines(f: np.ndarray, lines: int, *, beside: bool = True) -> PlaneLines:
    """Return the strongest lines of signals f (..., samples), by a number of first samples with a fast Fourier
    transform; beside: also those without a peak of their own.
    """
    n = fast_length(f.shape[-1])
    flat = f.reshape(-1, f.shape[-1])
    count = len(flat)
    place = np.zeros((count, lines))
    bar = np.full((count, lines), np.inf)
    amplitude = np.zeros((count, lines), complex)
    portion = max(1, AT_ONCE // n)
    for begin in range(0, count, portion):
        part = slice(begin, begin + portion)
        transforms = transforms_of(np.ascontiguousarray(flat[part, :n], complex), 1)
        arguments = *transforms, APART_ORDER, int(beside), place[part], bar[part], amplitude[part]
        run(kernels.lines_of_planes, len(place[part]), arguments, 1)
    shape = (*f.shape[:-1], lines)
    return PlaneLines((place / n).reshape(shape), amplitude.reshape(shape), (bar / n).reshape(shape))
