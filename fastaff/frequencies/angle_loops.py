"""Signals of angles and their own loops from samples of orbits."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import shown
from ..engine.blocks import Bound, call_table, rows_block, signals_block
from ..results.calls import names_of
from ..systems.models.angles import AlphaBeta, Cylindrical, Polar, RVartheta
from .fundamental import run
from .kernels import fundamental as kernels
from .signals import ReusableBuffer, Signals


class Plain(NamedTuple):
    """Loops in the coordinate planes (q_i, p_i) of any system."""

    names: tuple[str, ...]

    @property
    def planes(self) -> tuple[bool, ...]:
        """Mask of the angles of a plane: none."""
        return (False,) * len(self.names)


NAMED = {value.names: value for value in (Polar(), Cylindrical())}
"""Angles by name: "R phi", "R z phi"."""


def named_signals(value: Any, _: Any = None) -> Any:
    """Return the angles that a text names; return other values as they are."""
    if not isinstance(value, str):
        return value
    names = names_of(value)
    found = NAMED.get(names)
    if found is None:
        said = ", ".join(f"{' '.join(known)!r} for {len(known)} coordinates" for known in NAMED)
        meant = [" ".join(known) for known in NAMED if sorted(known) == sorted(names)]
        hint = f". Did you mean {meant[0]!r}?" if meant else ""
        raise ValueError(f"signals must be {said}, or an object of fastaff.models.angles, got {shown(value)}{hint}")
    return found


def suited(signals: Any, degrees_of_freedom: int, whose: str) -> None:
    """Refuse angles of another number of coordinates; those with a name are named in the error."""
    if len(signals.names) != degrees_of_freedom:
        said = " ".join(signals.names)
        n = len(signals.names)
        own = next((" ".join(names) for names in NAMED if len(names) == degrees_of_freedom), None)
        got = f"{said!r}, of {n} Cartesian coordinates" if signals.names in NAMED else shown(signals)
        other = f". Use {own!r}, or leave signals out." if own else ""
        raise ValueError(f"signals must have {degrees_of_freedom} angles for {whose}, got {got}{other}")


class SignalLayout:
    """The rows of signals of each angle: two for each libration (real Q and P), then four for each plane; and the
    periods (n,) of coordinates that are signals themselves and may go round, 0 for others.
    """

    def __init__(self, angles: Any, degrees_of_freedom: int, periods: tuple[float, ...] = ()):
        self.angles = angles
        planes = angles.planes
        if sorted(planes) != list(planes):
            raise ValueError(f"signals must have those of planes last, got planes {planes} of {shown(angles)}")
        self.librations = [i for i, plane in enumerate(planes) if not plane]
        self.planes = [i for i, plane in enumerate(planes) if plane]
        self.m = len(self.librations)
        self.kept = [4 * i + part for i in self.librations for part in (0, 2)]
        self.kept += [4 * i + part for i in self.planes for part in range(4)]
        self.body = bool(self.planes)
        self.axis = type(angles) in {type(value) for value in NAMED.values()}
        self.separate = isinstance(angles, (AlphaBeta, RVartheta))
        self.rows = len(self.kept)
        self.n = degrees_of_freedom
        self.periods = np.array(periods, dtype=np.float64)
        if self.periods.any() and not isinstance(angles, Plain):
            with np.errstate(all="ignore"):
                point = np.arange(1.0, 2 * self.n + 1)
                themselves = np.array(angles.signals(*point)[::4]) == point[: self.n]
            self.periods = np.where(themselves, self.periods, 0.0)

    @functools.cached_property
    def call(self) -> Bound:
        """The function of the signals of states."""
        if isinstance(self.angles, Plain):
            return rows_block(tuple(part + i for i in range(self.n) for part in (0, self.n)))
        return signals_block(self.angles, 2 * self.n, tuple(self.kept))

    def signals(self, states: np.ndarray, threads: int, room: ReusableBuffer) -> np.ndarray:
        """Return the signals (orbits, rows, samples), in a room, of states (orbits, samples, 2n)."""
        s = room.array(len(states), self.rows, states.shape[1])
        run(kernels.read_signals, len(states), (states, *call_table(np.zeros(0), (self.call,)), s), threads)
        return s

    def own(self, signals: Signals, threads: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the loops (orbits, n, rows) Q - c - i kappa P of all angles, with the sense of turning in a plane, and
        their offsets.
        """
        orbits = signals.samples.size
        rows = signals.rows
        low, high = np.empty((2, orbits, rows))
        run(kernels.extremes, orbits, (signals.ragged, low, high), threads)
        first_one = signals.numbers[signals.start[:, None] + np.arange(rows) * signals.samples[:, None]]
        loops = np.zeros((orbits, len(self.angles.names), rows), complex)
        offset = np.zeros((orbits, len(self.angles.names)), complex)
        width = high - low
        for place, i in enumerate([*self.librations, *self.planes]):
            first = 2 * place if place < self.m else 2 * self.m + 4 * (place - self.m)
            parts = 1 if place < self.m else 2
            q = width[:, first : first + parts].max(axis=1)
            p = width[:, first + parts : first + 2 * parts].max(axis=1)
            scale = np.where((q > 0) & (p > 0), q / np.where(p > 0, p, 1.0), 1.0)
            scale = np.where(np.isfinite(scale), scale, 1.0)
            if parts == 1:
                loops[:, i, first] = 1.0
                loops[:, i, first + 1] = -1j * scale
                offset[:, i] = (low[:, first] + high[:, first]) / 2
                continue
            a1, a2, p1, p2 = first_one[:, first : first + 4].T
            scale = np.where(a1 * p2 - a2 * p1 < 0, -scale, scale)
            for j, c in enumerate((1.0, 1j, -1j * scale, scale)):
                loops[:, i, first + j] = c
        return loops, offset
