"""The strongest lines of the signals of all angles of sampled orbits, with amplitudes and phases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..core.numbers import fits
from ..results.result import Result, along
from .angle_loops import SignalLayout
from .fundamental import Loops, prepared, values
from .plane_lines import plane_lines
from .signals import Signals

MARGIN = 2
"""Lines fewer than a quarter of the samples that are sought."""

AT_ONCE = 256
"""Orbits whose lines are found at once."""


@dataclass(frozen=True)
class AngleLines(Result):
    r"""Spectral lines of the signal of each angle, the strongest first.

    Attributes
    ----------
    names : tuple of str, length n
        Names of the angles.
    nu : ndarray, shape (n, lines, orbits)
        Signed frequencies in cycles per unit time, positive for motion with q = cos and p = -sin.
    amplitude : ndarray of complex, shape (n, lines, orbits)
        Amplitudes in units of Q, at time 0: the start of a run, or the first sample. 0 for a missing line.
    error : ndarray, shape (n, lines, orbits)
        Error estimates of `nu`, in cycles per unit time; inf for a missing line.

    Notes
    -----
    The signal is :math:`Q - i \kappa P = \sum_k A_k e^{2\pi i \nu_k t}`, without its mean and without the mean growth
    of a coordinate that grows without bound. :math:`\kappa` is the ratio of the root mean squares of Q and P.

    References
    ----------
    Wall & Neuhauser 1995, J. Chem. Phys. 102, 8011.
    """

    names: tuple[str, ...]
    nu: Annotated[np.ndarray, along("angle", "line", "orbit", unit="cycles/time", labels="names")]
    amplitude: Annotated[np.ndarray, along("angle", "line", "orbit", labels="names")]
    error: Annotated[np.ndarray, along("angle", "line", "orbit", unit="cycles/time", labels="names")]

    @property
    def phase(self) -> np.ndarray:
        """Phases of the lines at time 0 in radians, shape (n, lines, orbits)."""
        return np.angle(self.amplitude)

    @property
    def omega(self) -> np.ndarray:
        """Angular frequencies 2 pi nu in radians per unit time, shape (n, lines, orbits)."""
        return 2 * np.pi * self.nu


class LineTable:
    """Lines in the making."""

    def __init__(self, names: tuple[str, ...], lines: int, orbits: int):
        self.names = names
        self.count = lines
        fits("lines", len(names), lines, orbits, itemsize=32)
        self.nu = np.zeros((len(names), lines, orbits))
        self.amplitude = np.zeros((len(names), lines, orbits), complex)
        self.error = np.full((len(names), lines, orbits), np.inf)

    def adopt(self, orbits: np.ndarray, layout: SignalLayout, signals: Signals, delay: float) -> None:
        """Fill in the lines of the signals of these orbits; delay: time of the first sample, in intervals."""
        for o in signals.alike():
            for begin in range(0, o.size, AT_ONCE):
                part = o[begin : begin + AT_ONCE]
                self._adopt(orbits[part], layout, signals.of(part), delay)

    def _adopt(self, orbits: np.ndarray, layout: SignalLayout, signals: Signals, delay: float) -> None:
        interval = float(signals.interval[0])
        count = max(0, min(self.count, int(signals.samples[0]) // 4 - MARGIN))
        if count:
            for angles, f, size in _signals(layout, signals):
                found = plane_lines(f, count)
                turns = found.nu * delay
                with np.errstate(all="ignore"):  # a size may overflow, for numbers with infinite squares
                    amplitude = size[:, :, None] * found.amplitude * np.exp(-2j * np.pi * (turns - np.rint(turns)))
                known = np.isfinite(amplitude) & np.isfinite(found.error)
                here = np.ix_(np.array(angles), np.arange(count), orbits)
                self.nu[here] = np.where(known, found.nu / interval, 0.0).transpose(1, 2, 0)
                self.error[here] = np.where(known, found.error / interval, np.inf).transpose(1, 2, 0)
                self.amplitude[here] = np.where(known, amplitude, 0.0).transpose(1, 2, 0)

    def result(self) -> AngleLines:
        """Return the lines."""
        return AngleLines(names=self.names, nu=self.nu, amplitude=self.amplitude, error=self.error)


def _signals(layout: SignalLayout, signals: Signals) -> list[tuple[list[int], np.ndarray, np.ndarray]]:
    """Return angles, their signals (orbits, angles, samples) and the units of these (orbits, angles)."""
    m = layout.m
    s = np.ascontiguousarray(signals.array(np.arange(signals.samples.size))[:, : 2 * m])
    orbits, _, samples = s.shape
    result = []
    if m:
        _, loops, rows = prepared(s, samples, 1, at_rest=0.0)
        result.append((layout.librations, loops, rows.size[:, ::2]))
    if layout.planes:
        c, _ = layout.own(signals, 1)
        c = np.ascontiguousarray(c[:, layout.planes])
        zero = np.zeros((orbits, len(layout.planes)), complex)
        o, k = (entry.ravel() for entry in np.mgrid[:orbits, : len(layout.planes)])
        f = values(signals, Loops(c, zero, zero), o, k, 1).reshape(orbits, len(layout.planes), samples).copy()
        result.append((layout.planes, f, np.ones((orbits, len(layout.planes)))))
    return result
