"""Attractors that are not periodic: sets of cells of the state space that orbits visit again and again.

:Source: Datseris & Wagemakers 2022, Chaos 32, 023104 (attractors by recurrences).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import Callback
from ..core.status import Status
from ..runs.observers import Observer
from .kernels.visits import FACTOR, MASK, TABLE, visits
from .settling import Motion

CELLS = (64, 32, 16, 8)
"""Cells along each row of the state space, of the finest grid first."""

RECURRENT = 0.95
"""Least share of the states of one half of a long run that are in cells of the other half."""

COMMON = 0.9
"""Least share of states of one orbit in cells of another that is on the same attractor."""

TOUCHING = 0.5
"""Least share of states in cells of an attractor of an orbit that was there for some time."""

KEPT = 4096
"""States on a set that are kept."""

TYPICAL = 0.25
"""Part of the range of a mean or a spread over windows of an attractor by which one may lie beyond it."""


@dataclass(frozen=True)
class CellBox:
    """The box that is divided in cells: low ends and sizes of the rows that count (kept,)."""

    low: np.ndarray
    size: np.ndarray

    @classmethod
    def of(cls, motion: Motion, states: np.ndarray) -> CellBox:
        """Return the box of states (states, rows, orbits)."""
        rows = motion.wrapped(states.transpose(1, 0, 2))[motion.kept].reshape(len(motion.kept), -1)
        low = rows.min(axis=1)
        size = rows.max(axis=1) - low
        periods = motion.periods[motion.kept]
        low = np.where(periods > 0, -periods / 2, low - 1e-3 * size)
        size = np.where(periods > 0, periods, 1.002 * size)
        return cls(low, np.where(size > 1e-9 * motion.scale[motion.kept], size, np.inf))

    def cells(self, motion: Motion, states: np.ndarray, number: int) -> np.ndarray:
        """Return the numbers of the cells (states, orbits) of states (states, rows, orbits), as `visits` has them."""
        rows = motion.wrapped(states.transpose(1, 0, 2))[motion.kept]
        key = np.zeros(rows.shape[1:], np.int64)
        for row, low, size in zip(rows, self.low, self.size, strict=True):
            if np.isfinite(size):
                with np.errstate(all="ignore"):
                    at = np.floor((row - low) * (1 / size) * number) + 1.0
                at = np.clip(np.where(np.isnan(at), 0.0, at), 0.0, number + 1.0)
                key = (key * FACTOR + at.astype(np.int64)) & MASK
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

    def holds(self, motion: Motion, frame: CellBox, states: np.ndarray) -> np.ndarray:
        """Return the shares (orbits,) of states (states, rows, orbits) that are in its cells."""
        return np.isin(frame.cells(motion, states, self.number), self.cells).mean(axis=0)

    def usual(self, found: np.ndarray) -> np.ndarray:
        """Return a mask (orbits,) of the means and spreads (2 kept, orbits) that windows on it have."""
        low, high = self.ranges
        spare = TYPICAL * (high - low)
        return ((found >= (low - spare)[:, None]) & (found <= (high + spare)[:, None])).all(axis=0)


class _VisitValue(NamedTuple):
    rows: float
    sets: float


def settled_in(
    motion: Motion, frame: CellBox, sets: list[Recurrent], z: np.ndarray, window: int, callback: Callback | None
) -> np.ndarray:
    """Return a mask (sets, orbits) of the orbits from z (rows, orbits) whose next states are in the cells of a set, and
    usual there.
    """
    rows, orbits = z.shape
    places: Any = {int(row): k for k, row in enumerate(motion.kept)}
    table = np.zeros((TABLE.sets + len(sets) + 1, max(rows, 3, sum(one.cells.size for one in sets))))
    for row, k in places.items():
        table[TABLE.low, row] = frame.low[k]
        table[TABLE.inverse, row] = 1 / frame.size[k]
    table[TABLE.period, :rows] = motion.periods
    first = 0
    for s, one in enumerate(sets):
        table[TABLE.sets + s, :3] = one.number, first, one.cells.size
        table[-1, first : first + one.cells.size] = one.cells
        first += one.cells.size
    observer = Observer(visits, len(sets) + 2 * rows, _VisitValue(float(rows), float(len(sets))))
    flow, ensemble = motion.begun(z)
    memory = np.zeros((observer.rows, orbits))
    time = window * motion.interval
    flow.advance(ensemble, observer, memory, table, time=time, observations=window, callback=callback)
    sums = memory[len(sets) :].reshape(rows, 2, orbits) / window
    found = []
    for row, k in places.items():
        mean, square = sums[row]
        if motion.periods[row] > 0:
            found += [mean, square]
        else:
            middle = table[TABLE.low, row] + (0.5 * frame.size[k] if np.isfinite(frame.size[k]) else 0.0)
            found += [mean + middle, np.sqrt(np.maximum(square - mean**2, 0.0))]
    states = np.array(found)
    going = ensemble.status == Status.OK
    return np.array([going & (memory[s] >= COMMON * window) & one.usual(states) for s, one in enumerate(sets)])


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
    motion: Motion, frame: CellBox | None, states: np.ndarray, window: int
) -> tuple[CellBox | None, list[Recurrent]]:
    """Return the box of cells and the sets that long runs, states (states, rows, orbits), visit again and again.

    A set that another of these orbits has left again is transient, and none.
    """
    half = len(states) // 2
    fine = np.isfinite(states).all(axis=(0, 1))
    numbers = np.zeros(states.shape[2], np.int64)
    for o in np.flatnonzero(fine):
        own = CellBox.of(motion, states[:, :, o : o + 1])
        for number in CELLS:
            key = own.cells(motion, states[:, :, o : o + 1], number)[:, 0]
            first, second = key[:half], key[half:]
            if min(np.isin(first, second).mean(), np.isin(second, first).mean()) >= RECURRENT:
                numbers[o] = number
                break
    recurrent = np.flatnonzero(numbers > 0)
    if not recurrent.size:
        return frame, []
    frame = CellBox.of(motion, states[:, :, recurrent]) if frame is None else frame
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
        found_set = Recurrent(
            number, cells, np.array([seen.min(axis=1), seen.max(axis=1)]), states[-KEPT:, :, group[0]]
        )
        if not (others.size and (found_set.holds(motion, frame, early[:, :, others]) >= TOUCHING).any()):
            found.append(found_set)
    return frame, found


def known(motion: Motion, frame: Any, sets: list[Recurrent], one: Recurrent) -> bool:
    """Tell whether a set is one of those found before."""
    return any(other.holds(motion, frame, one.states[:, :, None])[0] >= COMMON for other in sets)
