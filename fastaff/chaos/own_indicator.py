"""Indicators of chaos of your own, from the growth of tangent vectors."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.numbers import flag, real, shown, whole
from ..runs.requirements import current_system
from .indicator import VectorIndicator
from .indicators import SLACK, moving_rows


@dataclass(frozen=True)
class TangentIndicator(VectorIndicator):
    """An indicator of your own: a reading of the growth of tangent vectors, beside the others in the same pass.

    name: that of its row in `ChaosMap`; ``reading(growth, i, *parameters)``: a Python function that Numba compiles (or
    one that it has compiled) and that returns the number for lane i of `fastaff.engine.kernels.readings.Growth`;
    threshold: chaotic orbits are above it, or below it where `above` is False; count: number of tangent vectors it
    needs, 1 to 2n; parameters: floats for the reading, other values compile nothing; across_flow: whether it needs the
    part of the first vector across the flow; judge(value, before, threshold, n): a mask (orbits,) of orbits that look
    regular, from the readings at the end and at half the time, called with arrays (default: those whose reading changed
    by less than log10(2) + 0.75 towards chaos, as decades of a vector on a torus do). An orbit whose reading is NaN is
    undecided.

    :Raises: nothing itself: `chaos_map` checks it.
    :Source: the tangent vectors are those of Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9.

    Examples
    --------
    >>> from fastaff.engine.kernels.readings import length
    >>> own = fa.chaos.TangentIndicator("own", lambda growth, i: length(growth, 0, i), threshold=9.0)
    >>> fa.chaos_map(fa.models.StandardMap(6.0), [2.0, 0.1], time=500, indicators=own).chaotic
    array([ True])
    """

    name: str
    reading: Callable[..., float]
    threshold: float
    above: bool = True
    count: int = 1
    parameters: tuple[float, ...] = ()
    across_flow: bool = False
    judge: Callable[..., np.ndarray] | None = None

    def check(self, where: str, model: Any) -> None:
        """Refuse fields of wrong kinds or values."""
        rows = moving_rows(current_system(model))
        if not inspect.isfunction(getattr(self.reading, "py_func", self.reading)):
            raise TypeError(f"{where}.reading must be a function reading(growth, i, *parameters), got {self.reading!r}")
        if self.judge is not None and not inspect.isfunction(self.judge):
            raise TypeError(f"{where}.judge must be a function or None, got {self.judge!r}")
        if whole(f"{where}.count", self.count, 1) > rows:
            raise ValueError(f"{where}.count must be 1 ... {rows} here, got {self.count}")
        if not isinstance(self.parameters, tuple):
            raise TypeError(f"{where}.parameters must be a tuple of floats, got {self.parameters!r}")
        for j, number in enumerate(self.parameters):
            real(f"{where}.parameters[{j}]", number)
        flag(f"{where}.above", self.above)
        flag(f"{where}.across_flow", self.across_flow)

    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return a mask of the orbits that look regular."""
        if self.judge is not None:
            said = self.judge(value, before, threshold, n)
            if not isinstance(said, np.ndarray) or said.dtype != bool or said.shape != value.shape:
                raise TypeError(
                    f"judge of the indicator {self.name} must return an array of {value.size} True or False, got "
                    f"{shown(said)}"
                )
            return said
        return (value - before if self.above else before - value) < math.log10(2.0) + SLACK
