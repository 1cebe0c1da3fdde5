"""Attractors that are not periodic: sets of cells of the state space that orbits visit again and again.

:Source: Datseris & Wagemakers 2022, Chaos 32, 023104 (attractors by recurrences).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .settling import Motion

CELLS = (64, 32, 16, 8)
"""Cells along each row of the state space, of the finest grid first."""

RECURRENT = 0.95
"""Least share of the states of one half of a long run that are in cells of the other half."""

COMMON = 0.9
"""Least share of states of one orbit in cells of another that is on the same attractor."""

TOUCHING = 0.5
"""Least share of states in cells of an attractor of an orbit that was there for some time."""

TYPICAL = 0.25
"""Part of the range of a mean or a spread over windows of an attractor by which one may lie beyond it."""


@dataclass(frozen=True)
class Frame:
    """The box that is divided in cells: low ends and sizes of the rows that count (kept,)."""

    low: np.ndarray
    size: np.ndarray

    @classmethod
    def of(cls, motion: Motion, states: np.ndarray) -> Frame:
        """Return the box of states (states, rows, orbits)."""
        rows = motion.wrapped(states.transpose(1, 0, 2))[motion.kept].reshape(len(motion.kept), -1)
        low = rows.min(axis=1)
        size = rows.max(axis=1) - low
        periods = motion.periods[motion.kept]
        low = np.where(periods > 0, -periods / 2, low - 1e-3 * size)
        size = np.where(periods > 0, periods, 1.002 * size)
        return cls(low, np.where(size > 1e-9 * motion.scale[motion.kept], size, np.inf))

    def cells(self, motion: Motion, states: np.ndarray, number: int) -> np.ndarray:
        """Return the numbers of the cells (states, orbits) of states (states, rows, orbits)."""
        rows = motion.wrapped(states.transpose(1, 0, 2))[motion.kept]
        with np.errstate(all="ignore"):
            at = np.floor((rows - self.low[:, None, None]) / self.size[:, None, None] * number)
        at = np.clip(np.where(np.isfinite(at), at, -(2.0**31)), -(2.0**31), 2.0**31).astype(np.int64)
        key = np.zeros(at.shape[1:], np.int64)
        with np.errstate(over="ignore"):
            for row in at:  # the factor is odd: numbers of cells within the box differ up to some dozen rows
                key = key * np.int64(1000003) + row
        return key


@dataclass(frozen=True)
class Recurrent:
    """A set of cells, sorted numbers, with the number of cells along a row; ranges (2, 2 kept) of the means and spreads
    of windows; states (states, rows), the last of one orbit.
    """

    number: int
    cells: np.ndarray
    ranges: np.ndarray
    states: np.ndarray

    def holds(self, motion: Motion, frame: Frame, states: np.ndarray) -> np.ndarray:
        """Return the shares (orbits,) of states (states, rows, orbits) that are in its cells."""
        return np.isin(frame.cells(motion, states, self.number), self.cells).mean(axis=0)

    def takes(self, motion: Motion, frame: Frame, states: np.ndarray) -> np.ndarray:
        """Return a mask (orbits,) of the windows (states, rows, orbits) that look like its own."""
        low, high = self.ranges
        spare = TYPICAL * (high - low)
        found = moments(motion, states)
        usual = ((found >= (low - spare)[:, None]) & (found <= (high + spare)[:, None])).all(axis=0)
        return usual & (self.holds(motion, frame, states) >= COMMON)


def moments(motion: Motion, states: np.ndarray) -> np.ndarray:
    """Return means and spreads (2 kept, orbits) of windows (states, rows, orbits); of an angle those of its sine and
    cosine.
    """
    rows = states.transpose(1, 0, 2)[motion.kept]
    found = []
    with np.errstate(all="ignore"):
        for row, period in zip(rows, motion.periods[motion.kept], strict=True):
            turned = 2 * np.pi * row / period if period > 0 else row
            found += [np.cos(turned).mean(axis=0), np.sin(turned).mean(axis=0)] if period > 0 else []
            found += [] if period > 0 else [row.mean(axis=0), row.std(axis=0)]
    return np.array(found)


def recurrent_sets(
    motion: Motion, frame: Frame | None, states: np.ndarray, window: int
) -> tuple[Frame | None, list[Recurrent]]:
    """Return the box of cells and the sets that long runs, states (states, rows, orbits), visit again and again.

    A set that another of these orbits has left again is transient, and none.
    """
    half = len(states) // 2
    fine = np.isfinite(states).all(axis=(0, 1))
    numbers = np.zeros(states.shape[2], np.int64)
    for o in np.flatnonzero(fine):
        own = Frame.of(motion, states[:, :, o : o + 1])
        for number in CELLS:
            key = own.cells(motion, states[:, :, o : o + 1], number)[:, 0]
            first, second = key[:half], key[half:]
            if min(np.isin(first, second).mean(), np.isin(second, first).mean()) >= RECURRENT:
                numbers[o] = number
                break
    recurrent = np.flatnonzero(numbers > 0)
    if not recurrent.size:
        return frame, []
    frame = Frame.of(motion, states[:, :, recurrent]) if frame is None else frame
    groups: list[list[int]] = []
    for o in recurrent:
        for group in groups:
            number = int(min(numbers[group[0]], numbers[o]))
            one, other = (frame.cells(motion, states[:, :, k : k + 1], number)[:, 0] for k in (group[0], o))
            if min(np.isin(one, other).mean(), np.isin(other, one).mean()) >= COMMON:
                group.append(int(o))
                break
        else:
            groups.append([int(o)])
    found = []
    others = np.flatnonzero(numbers == 0)
    early = states[: len(states) // 4]
    for group in groups:
        number = int(numbers[group].min())
        cells = np.unique(frame.cells(motion, states[:, :, group], number))
        parts = len(states) // window
        windows = states[: parts * window][:, :, group].reshape(parts, window, states.shape[1], len(group))
        seen = moments(motion, windows.transpose(1, 2, 0, 3).reshape(window, states.shape[1], -1))
        one = Recurrent(number, cells, np.array([seen.min(axis=1), seen.max(axis=1)]), states[-window:, :, group[0]])
        if not (others.size and (one.holds(motion, frame, early[:, :, others]) >= TOUCHING).any()):
            found.append(one)
    return frame, found


def known(motion: Motion, frame: Any, sets: list[Recurrent], one: Recurrent) -> bool:
    """Tell whether a set is one of those found before."""
    return any(other.holds(motion, frame, one.states[:, :, None])[0] >= COMMON for other in sets)
