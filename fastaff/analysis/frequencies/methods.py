"""Methods of `frequency_map` for the frequency of a loop: values of its `method`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...base.names import named
from ...base.numbers import positive


@dataclass(frozen=True)
class BirkhoffAverages:
    """Weighted Birkhoff averages of the rates of loops; lines where an average has not converged.

    fallback: relative error estimate above which an average is replaced by the fitted line where that has the smaller
    error (None: the accuracy asked for, or 1e-9; inf: never, which saves the fits).

    :Raises: ValueError or TypeError for other values.
    :Source: Das, Saiki, Sander & Yorke 2017, Nonlinearity 30, 4111.

    Examples
    --------
    >>> method = fa.analysis.BirkhoffAverages()
    >>> fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0, method=method).nu.round(6)
    array([[0.15556 ],
           [0.159622]])
    """

    fallback: float | None = None

    def __post_init__(self) -> None:
        given = self.fallback
        if given is not None and not (isinstance(given, float) and given == np.inf):
            object.__setattr__(self, "fallback", positive("fallback", given))


@dataclass(frozen=True)
class NaffLines:
    """The strongest lines of each loop, fitted together (NAFF), for all of them.

    :Source: Laskar 1990, Icarus 88, 266.

    Examples
    --------
    >>> method = fa.analysis.NaffLines()
    >>> fa.frequency_map(fa.HenonHeiles(), [0.1, 0.05, 0.0, 0.1], time=500.0, method=method).nu.round(6)
    array([[0.15556 ],
           [0.159622]])
    """

    fallback = 0.0
    """Relative error above which lines are fitted: 0, always."""


METHODS = (BirkhoffAverages, NaffLines)
"""Methods by their numbers in `FrequencyMap.method`."""


BY_NAME: dict[str, BirkhoffAverages | NaffLines] = {"birkhoff": BirkhoffAverages(), "naff": NaffLines()}


def method_of(value: Any, _: Any = None) -> Any:
    """Return the method of that name; return other values as they are."""
    return BY_NAME[named("method", value, BY_NAME)] if isinstance(value, str) else value


def checked_method(method: Any) -> BirkhoffAverages | NaffLines:
    """Return `method` if it is one."""
    if not isinstance(method, METHODS):
        raise TypeError(
            f"method must be BirkhoffAverages() or NaffLines() of fastaff.analysis, or a name, {' or '.join(BY_NAME)}; "
            f"got {method!r}"
        )
    return method
