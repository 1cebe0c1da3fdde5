"""Indicators of chaos of your own, from the growth of tangent vectors."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import flag, real, shown, whole
from ..runs.requirements import current_system
from .indicator import VectorIndicator
from .indicators import SLACK, moving_rows


@dataclass(frozen=True)
class TangentIndicator(VectorIndicator):
    r"""User-defined indicator: a number read from the growth of deviation vectors.

    It is computed in the same run as the other indicators of `chaos_map`.

    Parameters
    ----------
    name : str
        Name of its row in `ChaosMap`, an identifier.
    reading : callable
        Function ``reading(growth, i, *parameters)`` that returns the number of lane i of a
        `fastaff.engine.kernels.readings.Growth`. Numba compiles it unless it is compiled already.
    threshold : float
        Value beyond which an orbit is chaotic.
    above : bool, default True
        Whether chaotic orbits are above the threshold; if not, they are below it.
    count : int, default 1
        Number of deviation vectors, from 1 to 2n.
    parameters : tuple of float, default ()
        Further arguments of `reading`. Other values need no compilation.
    across_flow : bool, default False
        Whether `reading` needs the part of the first vector across the flow.
    judge : callable, optional
        Function ``judge(value, before, threshold, n)`` that returns a mask of the orbits that look regular, from arrays
        of readings at the end and at half the time. Default: orbits whose reading moved towards chaos by less than
        :math:`\log_{10} 2 + 0.75`, as decades of a vector on a torus do.

    Notes
    -----
    - `chaos_map` checks the fields.
    - An orbit whose reading is NaN is undecided.

    References
    ----------
    Benettin, Galgani, Giorgilli & Strelcyn 1980, Meccanica 15, 9 (deviation vectors).

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

    @inserts_parameters
    def check(self, where: str, model: Any) -> None:
        """Check the kinds and values of the fields.

        Parameters
        ----------
        {indicator_check}

        Raises
        ------
        ValueError
            If a value is out of its range.
        TypeError
            If a field is of a wrong kind.
        """
        rows = moving_rows(current_system(model))
        if not inspect.isfunction(getattr(self.reading, "py_func", self.reading)):
            raise TypeError(
                f"{where}.reading must be a function reading(growth, i, *parameters), got {shown(self.reading)}"
            )
        if self.judge is not None and not inspect.isfunction(self.judge):
            raise TypeError(f"{where}.judge must be a function or None, got {shown(self.judge)}")
        if whole(f"{where}.count", self.count, 1) > rows:
            raise ValueError(f"{where}.count must be from 1 to {rows} here, got {self.count}")
        if not isinstance(self.parameters, tuple):
            raise TypeError(f"{where}.parameters must be a tuple of floats, got {shown(self.parameters)}")
        for j, number in enumerate(self.parameters):
            real(f"{where}.parameters[{j}]", number)
        flag(f"{where}.above", self.above)
        flag(f"{where}.across_flow", self.across_flow)

    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular, by `judge` if it is given.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """
        if self.judge is not None:
            said = self.judge(value, before, threshold, n)
            if not isinstance(said, np.ndarray) or said.dtype != bool or said.shape != value.shape:
                raise TypeError(
                    f"judge of the indicator {self.name} must return an array of {value.size} True or False, got "
                    f"{shown(said)}"
                )
            return said
        return (value - before if self.above else before - value) < math.log10(2.0) + SLACK
