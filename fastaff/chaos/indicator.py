"""Indicators of chaos: their contract and defaults, their needs, and the classification that follows."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..core.classification import Classification
from ..core.docstrings import inserts_parameters
from ..core.names import named
from ..core.numbers import Callback, listed, real, shown
from ..runs import observers
from ..runs.flow import Flow
from ..runs.requirements import check_needs
from ..systems.models.mechanics import System

MANY = 100.0
"""Natural periods before an orbit is called regular. Among the orbits of Henon and Heiles at the energy 1/8 that looked
regular, half were chaotic in the end after 16 periods, one in fifteen after 130."""


def decades(phase: Any) -> Any:
    """Return log10 of the phase x = omega T, at least that of 10."""
    return np.log10(np.maximum(phase, 10.0))


class Watch(NamedTuple):
    """An observer of the pass of tangent vectors, with `columns` numbers of an orbit in `out`.

    prepare(memory) sets rows of its memory (rows, orbits); read(memory, time) returns the values (orbits,) and their
    numbers for comparison, for orbits that have come to `time` (orbits,); finish(out, callback), for values that take
    long, returns them after the pass.
    """

    observer: observers.Observer
    columns: int
    prepare: Callable[[np.ndarray], None]
    read: Callable[[np.ndarray, np.ndarray], tuple[Any, Any]]
    finish: Callable[[np.ndarray, Callback | None], np.ndarray] | None = None


@runtime_checkable
class Indicator(Protocol):
    """Indicator for `chaos_map`: a value that inherits the defaults of this class, or has all of its attributes.

    Its values come from readings of deviation vectors (`VectorIndicator`), from `watch` or from `compute`.

    Attributes
    ----------
    name : str
        Name of its row in `ChaosMap`.
    threshold : float or None
        Value beyond which an orbit is chaotic. None stands for ``default(n, phase)``.
    above : bool
        Whether chaotic orbits are above the threshold; if not, colours of figures fall with the values.
    rate : bool
        Whether values are decades of growth that are shown as exponents.
    least : float
        Natural periods before an orbit is called chaotic.
    needs : tuple of str
        Words of ``NEEDS``. A system or method that lacks one raises an error.
    """

    name: str
    threshold: Any
    above: bool = True
    rate: bool = False
    least: float = 0.0
    needs: tuple[str, ...] = ()

    @abstractmethod
    @inserts_parameters
    def calm(self, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, n: int) -> np.ndarray:
        """Return whether orbits look regular.

        Parameters
        ----------
        {indicator_calm}

        Returns
        -------
        ndarray of bool, shape (orbits,)
            Whether an orbit looks regular.
        """

    @inserts_parameters
    def check(self, where: str, model: Any) -> None:
        """Check the fields; by default all are accepted.

        Parameters
        ----------
        {indicator_check}

        Raises
        ------
        ValueError
            If a value is out of its range.
        TypeError
            If a field does not suit the model.
        """
        return

    def vectors(self, n: int) -> int:
        """Return the number of deviation vectors; by default 0.

        Parameters
        ----------
        n : int
            Number of degrees of freedom.

        Returns
        -------
        int
            Number of vectors.
        """
        return 0

    @inserts_parameters
    def watch(self, flow: Flow, time: float, rates: np.ndarray) -> Watch | None:
        """Return the observer of the run with the deviation vectors; by default None.

        Parameters
        ----------
        {indicator_watch}

        Returns
        -------
        Watch or None
            Observer of the run with the deviation vectors; None if the indicator has none.
        """
        return None

    @inserts_parameters
    def compute(
        self, flow: Flow, z0: np.ndarray, time: float, rates: np.ndarray, callback: Callback | None
    ) -> tuple[np.ndarray, Any, np.ndarray]:
        """Compute the values in a run of their own.

        Parameters
        ----------
        {indicator_compute}

        Returns
        -------
        tuple
            Values of shape (orbits,), NaN if they are unknown; numbers that `calm` compares them with, or NaN; and
            statuses of shape (orbits,).
        """
        raise TypeError(f"{type(self).__name__} must read vectors, or have a `watch` or a `compute`")


class IndicatorStyle(NamedTuple):
    """How figures draw an indicator: its label, empty where it has none, and whether chaotic orbits are above."""

    label: str
    above: bool

    @classmethod
    def of(cls, indicator: Any) -> IndicatorStyle:
        """Return the look of an indicator."""
        return cls(str(getattr(indicator, "label", None) or ""), bool(indicator.above))


class VectorIndicator(Indicator):
    """An indicator that is a `reading` of the growth of `count` tangent vectors, see `engine.kernels.readings`.

    parameters: further arguments of the reading; across_flow: whether it takes the part of the first vector across the
    flow, and so needs "flow"; each_step: whether it reads a maximum over all steps, else vectors are looked at about
    once a radian; spectrum: whether it asks for all exponents.
    """

    reading: Any
    count = 1
    parameters: tuple[float, ...] = ()
    across_flow = False
    each_step = False
    spectrum = False

    def vectors(self, n: int) -> int:
        """Return the number of tangent vectors it needs."""
        return self.count


def is_indicator(value: Any) -> bool:
    """Tell whether a value, not a class, is an indicator."""
    return isinstance(value, Indicator) and not isinstance(value, type)


Indicators = Indicator | str | Sequence[Indicator | str]
"""Indicators of chaos, also by their names."""

NEEDS = {
    "energy": "an energy: no friction, no dz/dt = f(z)",
    "flow": "equations that do not know the time: no map, no drive",
    "fixed steps": "a scheme that is not adaptive",
    "splitting": "a scheme that is symplectic and reversible",
}
"""Properties of a system and its scheme that an indicator may need."""


def refuse(where: str, indicator: Any, system: System, flow: Flow | None = None) -> None:
    """Raise TypeError or ValueError if a system, or the scheme that is planned for it, lacks a need of an indicator."""
    needs = [named(f"{where}.needs", need, NEEDS) for need in indicator.needs]
    name = type(indicator).__name__
    needs += ["flow"] if getattr(indicator, "across_flow", False) else []
    if "energy" in needs:
        instead = "those of deviation vectors, such as LyapunovSpectrum() and SALI(),"
        check_needs(system, "an indicator of the energy", instead=instead, got=repr(indicator))
    if "flow" in needs:
        check_needs(system, "an indicator along the flow", argument=f"{where}, {indicator.name},", got=name)
    if flow is not None and "fixed steps" in needs and flow.adaptive:
        raise ValueError(f"{name} needs a scheme of fixed steps, got {flow.scheme.name}")
    if flow is not None and "splitting" in needs and not flow.scheme.symplectic:
        raise ValueError(f"{name} needs a splitting, which is reversible, got {flow.scheme.name}")


def checked_indicators(indicators: Any, system: System) -> tuple[Any, ...]:
    """Return the indicators if they suit the body."""
    if not isinstance(indicators, (tuple, list)) or not indicators:
        instead = f". Use {indicators.__name__}()." if isinstance(indicators, type) else ""
        raise TypeError(
            f"indicators must be a tuple of indicators such as (MEGNO(), SALI()), got {shown(indicators)}{instead}"
        )
    for k, entry in enumerate(indicators):
        if not is_indicator(entry):
            hint = f". Use {entry.__name__}()." if isinstance(entry, type) and hasattr(entry, "calm") else ""
            raise TypeError(f"indicators[{k}] must be an indicator or its name, got {shown(entry)}{hint}")
        where = f"indicators[{k}], {type(entry).__name__}"
        if entry.threshold is not None or not hasattr(entry, "default"):
            real(f"{where}.threshold", entry.threshold)
        entry.check(where, system.model)
        if type(entry.name) is not str or not entry.name.isidentifier():
            raise ValueError(f"{where}.name must be a name such as 'entropy', got {shown(entry.name)}")
        refuse(f"indicators[{k}]", entry, system)
    names = [entry.name for entry in indicators]
    if len(set(names)) < len(names):
        raise ValueError(f"indicators must differ, got {listed(names)}")
    return tuple(indicators)


def judged(
    indicator: Any, value: np.ndarray, before: np.ndarray, threshold: np.ndarray, phase: np.ndarray, n: int
) -> np.ndarray:
    """Return the classifications (orbits,) of `Classification` on readings (orbits,) at the end and at half the time,
    for the phases omega T.
    """
    with np.errstate(invalid="ignore"):
        beyond = value > threshold if indicator.above else value < threshold
        calm = indicator.calm(value, before, threshold, n)
        chaotic = beyond & ~calm & (phase >= 2 * np.pi * indicator.least)
        calm = calm & (phase >= 2 * np.pi * MANY)
    return np.where(
        chaotic,
        Classification.CHAOTIC,
        np.where(calm & ~beyond & np.isfinite(value), Classification.REGULAR, Classification.UNDECIDED),
    )


def threshold_of(indicator: Any, n: int, phase: np.ndarray, time: float) -> np.ndarray:
    """Return the thresholds (orbits,) of the readings of an indicator, for n degrees of freedom at the phases omega T
    (orbits,).

    Those of an exponent are decades of growth.
    """
    if indicator.threshold is None:
        return indicator.default(n, phase)
    threshold = float(indicator.threshold)
    return np.full(phase.shape, threshold * time / math.log(10) if indicator.rate else threshold)
