"""The strongest lines of the signals of all angles of sampled orbits, with amplitudes and phases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ...base.axes import along
from ...base.numbers import fits
from ...base.results import Result
from ...kernels import fundamental as kernels
from .angle_loops import Layout
from .fundamental import LINE_ORDER, SPANS, Loops, bump, cosine_window, run, values
from .naff import found_lines

AT_ONCE = 256
"""Orbits whose lines are found at once."""


@dataclass(frozen=True)
class AngleLines(Result):
    """Lines sum_k amplitude_k exp(2 pi i nu_k t) of the signal of each angle, the largest first.

    The signal is Q - i kappa P without its mean, and without its mean growth where it grows without bound, in the
    units of Q; kappa is the ratio of the sizes of Q and P, root mean square. names: of the angles; nu, error (n, lines,
    orbits) in cycles per unit time, signed, positive for motion q = cos, p = -sin; amplitude (n, lines, orbits),
    complex, at the time 0: of the start of a frequency map, of the first sample of orbits that were given. `phase` is
    its argument in radians. A line that there is none of has the amplitude 0 and the error inf.
    Source: Laskar 1990, Icarus 88, 266.
    """

    names: tuple[str, ...]
    nu: Annotated[np.ndarray, along("angle", "line", "orbit", unit="cycles/time", labels="names")]
    amplitude: Annotated[np.ndarray, along("angle", "line", "orbit", labels="names")]
    error: Annotated[np.ndarray, along("angle", "line", "orbit", unit="cycles/time", labels="names")]

    @property
    def phase(self) -> np.ndarray:
        """Phases (n, lines, orbits) of the lines at the time 0, in radians."""
        return np.angle(self.amplitude)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu."""
        return 2 * np.pi * self.nu


class LineTable:
    """Lines in the making."""

    def __init__(self, names: tuple[str, ...], lines: int, orbits: int):
        self.names, self.count = names, lines
        fits("lines", len(names), lines, orbits, itemsize=32)
        self.nu, self.amplitude = np.zeros((len(names), lines, orbits)), np.zeros((len(names), lines, orbits), complex)
        self.error = np.full((len(names), lines, orbits), np.inf)

    def adopt(self, orbits: np.ndarray, layout: Layout, signals: np.ndarray, interval: float, delay: float) -> None:
        """Fill in the lines of the signals of these orbits; delay: time of the first sample."""
        samples = signals.shape[2]
        count = max(0, min(self.count, samples // 4 - LINE_ORDER))
        for begin in range(0, orbits.size if count else 0, AT_ONCE):
            part = np.arange(begin, min(begin + AT_ONCE, orbits.size))
            for angles, f, size in _signals(layout, signals[part]):
                found = found_lines(f, interval, count, LINE_ORDER)
                turns = found.nu * delay
                with np.errstate(all="ignore"):  # a size may be none, of numbers whose squares are none
                    amplitude = size[:, :, None] * found.amplitude * np.exp(-2j * np.pi * (turns - np.rint(turns)))
                known = np.isfinite(amplitude) & np.isfinite(found.error)
                here = np.ix_(np.array(angles), np.arange(count), orbits[part])
                self.nu[here] = np.where(known, found.nu, 0.0).transpose(1, 2, 0)
                self.error[here] = np.where(known, found.error, np.inf).transpose(1, 2, 0)
                self.amplitude[here] = np.where(known, amplitude, 0.0).transpose(1, 2, 0)

    def result(self) -> AngleLines:
        """Return the lines."""
        return AngleLines(self.names, self.nu, self.amplitude, self.error)


def _signals(layout: Layout, signals: np.ndarray) -> list[tuple[list[int], np.ndarray, np.ndarray]]:
    """Return angles, their signals (orbits, angles, samples) and the units of these (orbits, angles)."""
    s, m = np.ascontiguousarray(signals[:, : 2 * layout.m]), layout.m
    orbits, rows, samples = s.shape
    result = []
    if m:
        x, loops, moving = np.empty_like(s), np.empty((orbits, m, samples), complex), np.zeros((orbits, m), bool)
        drift, centre, size = np.empty((3, orbits, rows))
        tables = np.array([bump(*SPANS[i], samples - 1) for i in (0, 3, 4)])
        arguments = (s, 1, cosine_window(samples), tables, 0.0, x, loops, drift, centre, size, moving)
        run(kernels.prepare, orbits, arguments, 1)
        result.append((layout.librations, loops, size[:, ::2]))
    if layout.planes:
        c, _ = layout.own(signals)
        c, zero = np.ascontiguousarray(c[:, layout.planes]), np.zeros((orbits, len(layout.planes)), complex)
        o, k = (entry.ravel() for entry in np.mgrid[:orbits, : len(layout.planes)])
        f = values(signals, Loops(c, zero, zero), o, k, 1, 1).reshape(orbits, len(layout.planes), samples)
        result.append((layout.planes, f, np.ones((orbits, len(layout.planes)))))
    return result
