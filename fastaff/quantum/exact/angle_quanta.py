"""Quasiclassical levels of an angle in a periodic potential: librations J = (n + 1/2) h and rotations J = n h.

Levels are numbered as the exact ones, upwards from 0. Rotations of both senses are the levels 2 n - 1 and 2 n, as by
Hill's theorem on the zeros of their functions; librations are the levels below. Between both there is none at some
numbers: no torus has these actions.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

SAMPLES = 1 << 14
"""Points of the circle between which extrema are sought."""
NODES = 32, 4096
"""Fewest and most nodes of an action's quadrature; they double until it changes by less than CONVERGED."""
CONVERGED = 1e-13
"""Relative change of an action that ends its quadrature."""
MOST = 10_000
"""Librations of one angle that are listed."""


class Libration(NamedTuple):
    """A well between two barriers: the nearest minima and the barriers at both ends, and the energies between which it
    is one well.
    """

    ends: tuple[float, float]
    minima: tuple[float, float]
    low: float
    high: float


class AngleQuanta:
    """The quasiclassical levels of one angle; turns: 1 for functions of period 2 pi, 2 for 4 pi."""

    def __init__(self, V: Any, mu: float, h: float, turns: int):
        self.V = V
        self.mu = mu
        self.h = h
        self.turns = turns

    def periodic(self, k: int) -> bool:
        """Return whether the functions of the level have the period 2 pi."""
        return self.turns == 1 or (k + 1) // 2 % 2 == 0

    def level(self, k: int) -> float:
        """Return the separation constant c of the level k, NaN where no torus has its action."""
        if k < self._librations.size:
            return float(self._librations[k])
        J = (k + 1) // 2 * self.h / self.turns
        top = self._top
        least = self._rotation(top)
        if least > J or (least == J and self._wells):
            return np.nan
        return self._solved(self._rotation, J, top, np.inf)

    @cached_property
    def _librations(self) -> np.ndarray:
        """The levels of all librations, ascending."""
        found: list[float] = []
        for well in self._wells:
            least, most = (self._libration(well, c) / self.h for c in (well.low, well.high))
            first = int(np.ceil(least - 0.5))
            last = int(np.ceil(most - 0.5))
            if len(found) + last - first > MOST:
                raise ValueError(f"hbar must be larger: an angle has more than {MOST} librations")
            levels = [
                self._solved(lambda c, well=well: self._libration(well, c), (n + 0.5) * self.h, well.low, well.high)
                for n in range(first, last)
            ]
            found += levels * self.turns
        return np.sort(found)

    def _solved(self, action: Any, J: float, low: float, high: float) -> float:
        """Return the energy between low and high of an action."""
        from scipy.optimize import brentq

        if np.isinf(high):
            step = (J / (2 * np.pi)) ** 2 / (2 * self.mu) + 1e-300
            while action(low + step) < J:
                step *= 2
            high = low + step
        if action(low) >= J:
            return low
        return float(brentq(lambda c: action(c) - J, low, high, xtol=1e-300, rtol=8.9e-16))

    def _rotation(self, c: float) -> float:
        """Return the closed integral of p over 2 pi."""
        return self._mean(lambda x: np.sqrt(np.maximum(2 * self.mu * (c - self._values(x)), 0.0))) * 2 * np.pi

    def _libration(self, well: Libration, c: float) -> float:
        """Return the closed integral of p in a well."""
        from scipy.optimize import brentq

        turning = []
        for end, inner in zip(well.ends, well.minima, strict=True):
            if self._value(inner) >= c:
                return 0.0
            turning.append(end if self._value(end) <= c else brentq(lambda x: self._value(x) - c, end, inner))
        middle = (turning[0] + turning[1]) / 2
        half = (turning[1] - turning[0]) / 2

        def momentum(t):
            under = np.maximum(2 * self.mu * (c - self._values(middle + half * np.cos(t))), 0.0)
            return np.sqrt(under) * np.abs(np.sin(t))

        return self._mean(momentum) * 2 * np.pi * half

    def _mean(self, function: Any) -> float:
        """Return the mean of a function of period 2 pi, by the midpoint rule."""
        before = np.inf
        n = NODES[0]
        while True:
            value = float(function((np.arange(n) + 0.5) * 2 * np.pi / n).mean())
            if abs(value - before) <= CONVERGED * abs(value) or n >= NODES[1]:
                return value
            before = value
            n *= 2

    def _values(self, x: np.ndarray) -> np.ndarray:
        return np.asarray(self.V.value(x), float) + 0.0 * x

    def _value(self, x: float) -> float:
        return float(self._values(np.array([x]))[0])

    @cached_property
    def _top(self) -> float:
        """The height of the highest barrier."""
        return self._value(self._maxima[0]) if self._wells else float(self._values(np.zeros(1))[0])

    @cached_property
    def _extrema(self) -> tuple[list[float], list[float]]:
        """The places of maxima and of minima in (0, 2 pi), in turn, a maximum first; both empty for a constant."""
        x = (np.arange(SAMPLES) + 0.5) * 2 * np.pi / SAMPLES
        values = self._values(x)
        rises = np.sign(np.diff(values, append=values[:1]))
        moving = np.flatnonzero(rises)
        turns = np.flatnonzero(rises[moving] != np.roll(rises[moving], 1))
        after = moving[turns]
        sharp = [self._extremum(x[k], rises[k] < 0) for k in after]
        maxima = [place for place, k in zip(sharp, after, strict=True) if rises[k] < 0]
        minima = [place for place, k in zip(sharp, after, strict=True) if rises[k] > 0]
        return maxima, minima

    @property
    def _maxima(self) -> list[float]:
        """The maxima, the highest first."""
        return sorted(self._extrema[0], key=self._value, reverse=True)

    def _extremum(self, x: float, maximum: bool) -> float:
        """Return the place of an extremum near a sample."""
        from scipy.optimize import minimize_scalar

        step = 2 * np.pi / SAMPLES
        sign = -1.0 if maximum else 1.0
        found = minimize_scalar(
            lambda x: sign * self._value(x),
            bounds=(x - 2 * step, x + 2 * step),
            method="bounded",
            options={"xatol": 1e-12},
        )
        return float(found.x)

    @cached_property
    def _wells(self) -> list[Libration]:
        """All wells: between any two barriers, and, above the lower barriers inside of it, as one."""
        maxima, minima = self._extrema
        if not maxima:
            return []
        start = self._maxima[0]
        inside = sorted((place - start) % (2 * np.pi) + start for place in maxima if place != start)
        lows = sorted((place - start) % (2 * np.pi) + start for place in minima)
        return list(self._between(start, start + 2 * np.pi, inside, lows))

    def _between(self, left: float, right: float, maxima: list[float], minima: list[float]) -> Iterator[Libration]:
        """Yield the wells between two barriers, with the maxima and minima inside."""
        high = min(self._value(left), self._value(right))
        within = [place for place in minima if left < place < right]
        barriers = [place for place in maxima if left < place < right]
        low = self._value(max(barriers, key=self._value)) if barriers else self._value(within[0])
        yield Libration((left, right), (within[0], within[-1]), low, high)
        if barriers:
            cut = max(barriers, key=self._value)
            yield from self._between(left, cut, maxima, minima)
            yield from self._between(cut, right, maxima, minima)
