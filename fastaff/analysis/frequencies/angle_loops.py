"""Signals of angles and their own loops from samples of orbits, and averages in an angle's own clock."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np

from ...compile.blocks import rows_block, signals_block
from ...compile.pointers import Bound, call_table
from ...kernels import fundamental as kernels
from ...models.angles import AlphaBeta, RVartheta
from .demodulated import PARTS, parts
from .fundamental import run, weight_at
from .rooms import Room
from .signals import Signals


class Plain(NamedTuple):
    """Loops in the coordinate planes (q_i, p_i) of any system; averaged over time."""

    names: tuple[str, ...]

    @property
    def planes(self) -> tuple[bool, ...]:
        """Which angles are those of a plane: none."""
        return (False,) * len(self.names)

    @property
    def clocks(self) -> tuple[int, ...]:
        """1 where an angle is averaged over the clock instead of time: none."""
        return (0,) * len(self.names)


class Layout:
    """Which rows of signals belong to which angle: two for each libration (real Q and P), then four for each plane;
    last the rate of the clock where angles have one.
    """

    def __init__(self, angles: Any, degrees_of_freedom: int):
        self.angles, planes = angles, angles.planes
        self.librations = [i for i, plane in enumerate(planes) if not plane]
        self.planes = [i for i, plane in enumerate(planes) if plane]
        self.m = len(self.librations)
        self.kept = [4 * i + part for i in self.librations for part in (0, 2)]
        self.kept += [4 * i + part for i in self.planes for part in range(4)]
        self.clocked = [i for i, clock in enumerate(getattr(angles, "clocks", [0] * len(planes))) if clock]
        self.body = bool(self.planes)
        self.separate = isinstance(angles, (AlphaBeta, RVartheta))
        self.rows, self.n = len(self.kept) + bool(self.clocked), degrees_of_freedom

    @functools.cached_property
    def call(self) -> Bound:
        """The function of the signals of states."""
        if isinstance(self.angles, Plain):
            return rows_block(tuple(part + i for i in range(self.n) for part in (0, self.n)))
        return signals_block(self.angles, 2 * self.n, tuple(self.kept), bool(self.clocked))

    def signals(self, states: np.ndarray, threads: int, room: Room) -> np.ndarray:
        """Return the signals (orbits, rows, samples), in a room, of states (orbits, samples, 2n)."""
        s = room.array(len(states), self.rows, states.shape[1])
        run(kernels.read_signals, len(states), (states, *call_table(np.zeros(0), (self.call,)), s), threads)
        return s

    def own(self, signals: Signals, threads: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the loops (orbits, n, rows) Q - c - i kappa P of all angles, with the sense of turning in a plane, and
        their offsets.
        """
        orbits, rows = signals.samples.size, signals.rows
        low, high = np.empty((2, orbits, rows))
        run(kernels.extremes, orbits, (*signals.ragged, low, high), threads)
        first_one = signals.numbers[signals.start[:, None] + np.arange(rows) * signals.samples[:, None]]
        loops, offset = (
            np.zeros((orbits, len(self.angles.names), rows), complex),
            np.zeros((orbits, len(self.angles.names)), complex),
        )
        width = high - low
        for place, i in enumerate([*self.librations, *self.planes]):
            first = 2 * place if place < self.m else 2 * self.m + 4 * (place - self.m)
            parts = 1 if place < self.m else 2
            q, p = width[:, first : first + parts].max(axis=1), width[:, first + parts : first + 2 * parts].max(axis=1)
            scale = np.where((q > 0) & (p > 0), q / np.where(p > 0, p, 1.0), 1.0)
            scale = np.where(np.isfinite(scale), scale, 1.0)
            if parts == 1:
                loops[:, i, first], loops[:, i, first + 1] = 1.0, -1j * scale
                offset[:, i] = (low[:, first] + high[:, first]) / 2
                continue
            a1, a2, p1, p2 = first_one[:, first : first + 4].T
            scale = np.where(a1 * p2 - a2 * p1 < 0, -scale, scale)
            for j, c in enumerate((1.0, 1j, -1j * scale, scale)):
                loops[:, i, first + j] = c
        return loops, offset


def _for_steps(weights: np.ndarray) -> np.ndarray:
    """Return weights (orbits, steps) of angles per step whose sum is that of rates times these weights (orbits,
    samples).

    Means over steps would ripple with the clock and beat with the rates. (asinh y)/(y (1 + y^2)^(1/2)) of differences 2
    y, to the order 8, on the means of neighbours.
    """
    result = (weights[:, 1:] + weights[:, :-1]) / 2
    difference = result
    for c in (-1 / 6, 1 / 30, -1 / 140, 1 / 630):
        wide = np.pad(difference, ((0, 0), (1, 1)))
        difference = wide[:, 2:] - 2 * difference + wide[:, :-2]
        result = result + c * difference
    return result


def clock_windows(rate: np.ndarray) -> np.ndarray:
    """Return weights (orbits, parts, steps) over equal PARTS of a clock of so fast `rate` (orbits, samples), as
    `parts` over time's.

    They turn angles per step into mean angles per clock unit, times the clock's mean rate. The clock is summed by a
    rule of order 6.
    """
    samples = rate.shape[1]
    padded = np.concatenate([rate[:, :1], rate[:, :1], rate, rate[:, -1:], rate[:, -1:]], axis=1)
    steps = np.zeros((rate.shape[0], samples - 1))
    for i, c in enumerate((11, -93, 802, 802, -93, 11)):
        steps += c / 1440 * padded[:, i : i + samples - 1]
    clock = np.pad(np.cumsum(steps, axis=1), ((0, 0), (1, 0)))
    x, plain = clock / clock[:, -1:], parts(samples - 1)
    middle = (rate[:, 1:] + rate[:, :-1]) / 2
    weights = np.empty((rate.shape[0], len(PARTS), samples - 1))
    for w, (x0, x1) in enumerate(PARTS):
        weights[:, w] = _for_steps(weight_at(2 * (x - x0) / (x1 - x0) - 1))
        mean = (plain[w] * middle).sum(axis=1)
        weights[:, w] *= (mean / (weights[:, w] * steps).sum(axis=1))[:, None]
    return weights
