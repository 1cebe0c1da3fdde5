"""Scans of parameters: the chaotic fraction of a body for each value of one or two of them."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Callback, entries, function, numbers, portion, positive, shown, texts
from ..core.status import Status, counted
from ..results.calls import axes_of, coerces_arguments, names_of, records_call
from ..results.result import Result, along
from ..runs.requirements import current_system
from ..runs.schemes.catalogue import VERNER9, RungeKutta, Scheme, scheme_of
from ..runs.starts import in_rows
from ..sections.energy_shell import NotReached
from ..systems.models.contracts import Dynamics
from .chaos_map import chaos_map
from .indicator import MANY, Indicators, is_indicator
from .indicators import MEGNO, SALI, indicators_of
from .shares import Shares

TOO_STEEP = (Status.OUT_OF_DOMAIN, Status.NONFINITE, Status.ENERGY_DRIFT)
"""Outcomes of an orbit whose fixed step is too long for a steep wall."""


@dataclass(frozen=True)
class ChaoticFraction(Result, axis=None):
    """Chaotic fraction for each value of one or two parameters.

    Arrays have the shape of the cases, (n1,) or (n1, n2), written (...).

    Attributes
    ----------
    names : tuple of str
        Names of the parameters.
    axes : tuple of ndarray
        Values of the parameters.
    orbits : ndarray of int, shape (...)
        Number of orbits; 0 if the energy reaches no point.
    chaotic, regular, undecided : ndarray of int, shape (...)
        Numbers of orbits of each class that did not fail.
    recomputed : ndarray of int, shape (...)
        Number of failed orbits that the fallback method finished.
    statuses : ndarray of int, shape (statuses, ...)
        Number of orbits with each `Status`.
    indicators : tuple of str
        Names of the indicators.
    medians : ndarray, shape (indicators, ...)
        Median values over all orbits that did not fail.
    chaotic_medians : ndarray, shape (indicators, ...)
        Median values over the chaotic orbits.
    thresholds : ndarray, shape (indicators, ...)
        Median thresholds.
    time : ndarray, shape (...)
        Length of the runs.
    step : ndarray, shape (...)
        Median step size.
    energy_error : ndarray, shape (...)
        Largest energy error, relative to the largest kinetic energy.
    done : ndarray of bool, shape (...)
        Whether a case is finished; False after Ctrl-C.
    """

    names: tuple[str, ...]
    axes: tuple[np.ndarray, ...]
    orbits: Annotated[np.ndarray, along("case")]
    chaotic: Annotated[np.ndarray, along("case")]
    regular: Annotated[np.ndarray, along("case")]
    undecided: Annotated[np.ndarray, along("case")]
    recomputed: Annotated[np.ndarray, along("case")]
    statuses: Annotated[np.ndarray, along("status", "case")]
    indicators: tuple[str, ...]
    medians: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    chaotic_medians: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    thresholds: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    time: Annotated[np.ndarray, along("case", unit="time")]
    step: Annotated[np.ndarray, along("case", unit="time")]
    energy_error: Annotated[np.ndarray, along("case", unit="largest kinetic energy")]
    done: Annotated[np.ndarray, along("case")]

    @property
    def failed(self) -> np.ndarray:
        """Number of orbits of each case that failed."""
        return self.orbits - self.completed

    @property
    def shares(self) -> Shares:
        """Numbers of orbits of each class and case, with the fractions that they give, as `Shares`."""
        return Shares(self.chaotic, self.regular, self.undecided)

    @property
    def completed(self) -> np.ndarray:
        """Number of orbits of each case that did not fail."""
        return self.shares.completed

    @property
    def fraction(self) -> np.ndarray:
        """Fraction of chaotic orbits among the decided ones of each case; NaN if there are none."""
        return self.shares.fraction

    @property
    def bounds(self) -> np.ndarray:
        """Chaotic fractions, shape (2, ...), of each case if all undecided orbits were regular, or chaotic."""
        return self.shares.bounds

    @inserts_parameters
    def interval(self, sigmas: float = 1.959964) -> np.ndarray:
        """Return the confidence interval of the fraction of each case, due to the number of orbits.

        Parameters
        ----------
        {sigmas}

        Returns
        -------
        ndarray, shape (2, ...)
            Lower and upper ends.
        """
        return self.shares.interval(sigmas)

    def summary(self) -> str:
        """Return one line with the outcomes of the cases.

        Returns
        -------
        str
            Summary.
        """
        kinds = {"regular": self.regular, "chaotic": self.chaotic, "undecided": self.undecided}
        orbits = [f"{n} {name}" for name, count in kinds.items() if (n := int(count.sum()))]
        lost = self.statuses.reshape(len(self.statuses), -1).sum(axis=1)
        failed = [f"{n} {s.name} ({s.sentence})" for s, n in zip(Status, lost) if n and s != Status.OK]
        said = "; ".join([", ".join(orbits), *failed] if orbits else failed)
        total = f"{counted(int(self.orbits.sum()), 'orbit')} in {counted(self.orbits.size, 'case')}"
        parts = [f"{total}{f': {said}' if said else ''}"]
        if np.any(self.shares.completed):
            parts.append(self.shares.fraction_text())
        if self.undecided.any() and not (self.regular.any() or self.chaotic.any()):
            parts.append(f"a longer time may decide, {MANY:g} natural periods or more")
        if self.recomputed.any():
            parts.append(f"{int(self.recomputed.sum())} recomputed with the fallback scheme")
        empty = int(np.count_nonzero(self.done & (self.orbits == 0)))
        late = int(np.count_nonzero(~self.done))
        parts += [f"{counted(empty, 'case')} without accessible points"] if empty else []
        parts += [f"{counted(late, 'case')} not done"] if late else []
        return "; ".join(parts)


@dataclass(frozen=True)
class FoundCases(Result, axis="case"):
    """Results of a scan by case; the fields are those of `ChaoticFraction`."""

    values: Annotated[np.ndarray, along("parameter", "case", labels="names")]
    names: tuple[str, ...]
    orbits: Annotated[np.ndarray, along("case")]
    chaotic: Annotated[np.ndarray, along("case")]
    regular: Annotated[np.ndarray, along("case")]
    undecided: Annotated[np.ndarray, along("case")]
    recomputed: Annotated[np.ndarray, along("case")]
    statuses: Annotated[np.ndarray, along("outcome", "case")]
    indicators: tuple[str, ...]
    medians: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    chaotic_medians: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    thresholds: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    time: Annotated[np.ndarray, along("case", unit="time")]
    step: Annotated[np.ndarray, along("case", unit="time")]
    energy_error: Annotated[np.ndarray, along("case", unit="largest kinetic energy")]
    done: Annotated[np.ndarray, along("case")]

    @classmethod
    def of(cls, scan: ChaoticFraction) -> FoundCases:
        """Return the cases of a scan as a list, the last parameter fastest."""
        values = np.array([grid.ravel() for grid in np.meshgrid(*scan.axes, indexing="ij")])
        cases = len(scan.axes)
        arrays = {
            name: (array := getattr(scan, name)).reshape(*array.shape[: array.ndim - cases], values.shape[1])
            for name in _ARRAYS
        }
        return cls(values=values, names=scan.names, indicators=scan.indicators, **arrays)

    def assembled(self, axes: tuple[np.ndarray, ...]) -> ChaoticFraction:
        """Return the scan over these axes; cases that are missing here are not done."""
        place = [np.searchsorted(axis, row) for axis, row in zip(axes, self.values)]
        arrays = {}
        for name in _ARRAYS:
            array = getattr(self, name)
            empty = np.nan if array.dtype.kind == "f" else 0
            arrays[name] = np.full((*array.shape[:-1], *(axis.size for axis in axes)), empty, array.dtype)
            arrays[name][(..., *place)] = array
        return ChaoticFraction(names=self.names, axes=axes, indicators=self.indicators, **arrays)


_ARRAYS = tuple(entry.name for entry in fields(FoundCases) if entry.name not in ("values", "names", "indicators"))

AXES = "one or two arrays of values, such as (np.linspace(1, 2, 5),)"


@coerces_arguments(scheme=scheme_of, fallback=scheme_of, indicators=indicators_of, names=names_of, axes=axes_of)
@records_call
@inserts_parameters
def chaotic_fraction(
    model: Callable[..., tuple[Dynamics, ArrayLike]],
    axes: Sequence[ArrayLike],
    *,
    time: float | Callable[[Dynamics, np.ndarray], float],
    names: str | Sequence[str] = (),
    indicators: Indicators = (MEGNO(), SALI()),  # noqa: B008 - values
    early_stop: bool = False,
    step: float | None = None,
    scheme: Scheme | str | None = None,
    fallback: RungeKutta | str | None = VERNER9,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    energy_tolerance: float | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> ChaoticFraction:
    """Compute the fraction of chaotic orbits for each value of one parameter, or for each pair of values of two.

    Parameters
    ----------
    model : callable
        Function of one or two parameter values that returns (model, z0), with initial conditions z0 of shape (2n,
        orbits) such as those of `energy_sample`. If it raises `NotReached` or returns an empty z0, the case is empty.
    axes : array_like, or sequence of two array_like
        Values of the parameters.
    time : float or callable
        Length of the runs, in units of time, or a function of (model, z0) that returns it.
    names : str or sequence of str, optional
        Names of the parameters.
    {indicators}
    {early_stop}
    step : float, optional
        Fixed step size, in units of time. Default: chosen for each orbit.
    {tangent_scheme}
    fallback : RungeKutta, str or None, default VERNER9
        Adaptive method for orbits that fixed steps lose at a steep potential barrier. None: no second run.
    {rtol}
    {atol}
    {plain_energy_tolerance}
    {threads}
    {callback}

    Returns
    -------
    `ChaoticFraction`
        Numbers of chaotic, regular and undecided orbits of each case.

    Raises
    ------
    ValueError
        If a value is out of its range; the message names the case.
    TypeError
        If an argument is of a wrong kind.
    Interrupted
        On Ctrl-C, with the finished cases in ``.partial``.

    Notes
    -----
    - Method: a `chaos_map` of each case. Lost orbits are fast and often chaotic, and their loss would bias the
      fraction. They run again with the fallback method and the same thresholds.
    - Measure: the fraction of points of a section (`energy_sample`) is that of its invariant area, not of the volume of
      the energy surface.
    - Cost: that of `chaos_map` and the choice of steps, for each case. Memory: one case.

    References
    ----------
    Henon & Heiles 1964, Astron. J. 69, 73 (the share of the area against the energy).

    Examples
    --------
    >>> def case(K):
    ...     return fa.models.StandardMap(K), np.array([[0.5, 2.0, 3.0], [0.0, 0.1, 0.2]])
    >>> scan = fa.chaotic_fraction(case, ([0.3, 6.0],), time=1000, names=["K"])
    >>> scan.chaotic
    array([0, 3])
    """
    values = tuple(_axis(k, axis) for k, axis in enumerate(entries("axes", axes, AXES, 1, 2)))
    function("model", model)
    names = texts("names", names) or tuple(f"parameter {k + 1}" for k in range(len(values)))
    if len(names) != len(values):
        raise ValueError(f"names must be {len(values)}, one for each axis, got {shown(names)}")
    if not (isinstance(indicators, (tuple, list)) and indicators and all(is_indicator(entry) for entry in indicators)):
        raise TypeError(f"indicators must be a tuple of indicators such as (MEGNO(), SALI()), got {shown(indicators)}")
    if fallback is not None and not (isinstance(fallback, RungeKutta) and fallback.adaptive):
        raise TypeError(f"fallback must be an adaptive scheme such as fastaff.VERNER9, or None, got {shown(fallback)}")
    if not callable(time):
        time = positive("time", time)
    run = functools.partial(
        chaos_map,
        indicators=indicators,
        early_stop=early_stop,
        rtol=rtol,
        atol=atol,
        energy_tolerance=energy_tolerance,
        threads=threads,
    )
    scan = _empty(names, values, tuple(entry.name for entry in indicators))
    cells = list(itertools.product(*(range(len(axis)) for axis in values)))
    for number, cell in enumerate(cells):
        share = portion(callback, number, len(cells))
        try:
            with partial_result_on_interrupt("chaotic_fraction", lambda: scan):
                _fill(scan, cell, model, time, run, step, scheme, fallback, share)
        except (TypeError, ValueError) as problem:
            at = ", ".join(f"{axis[i]:g}" for axis, i in zip(values, cell))
            raise type(problem)(f"axes at {at}: {problem}") from problem
        if callback is not None:
            callback((number + 1) / len(cells))
    return scan


def _axis(k: int, axis: Any) -> np.ndarray:
    values = np.array(numbers(f"axes[{k}]", axis))
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise ValueError(f"axes[{k}] must be a non-empty one-dimensional array of finite numbers, got {shown(axis)}")
    return values


def _empty(names: tuple[str, ...], axes: tuple[np.ndarray, ...], indicators: tuple[str, ...]) -> ChaoticFraction:
    shape = tuple(axis.size for axis in axes)
    counts = ("orbits", "chaotic", "regular", "undecided", "recomputed")
    medians = ("medians", "chaotic_medians", "thresholds")
    return ChaoticFraction(
        names=names,
        axes=axes,
        indicators=indicators,
        statuses=np.zeros((len(Status), *shape), np.int64),
        done=np.zeros(shape, bool),
        **{name: np.zeros(shape, np.int64) for name in counts},
        **{name: np.full((len(indicators), *shape), np.nan) for name in medians},
        **{name: np.full(shape, np.nan) for name in ("time", "step", "energy_error")},
    )


def _fill(scan, cell, model, time, run, step, scheme, fallback, callback) -> None:
    """Compute one case and write its numbers into the arrays of the scan."""
    try:
        model, z0 = model(*(float(axis[i]) for axis, i in zip(scan.axes, cell)))
    except NotReached:
        scan.done[cell] = True
        return
    system = current_system(model)
    z0 = numbers("z0", in_rows("z0", z0, system))
    if z0.size == 0:
        scan.done[cell] = True
        return
    z0 = z0.reshape(z0.shape[0], -1)
    length = positive("time", time(model, z0) if callable(time) else time)
    found = run(model, z0, time=length, step=step, scheme=scheme, callback=callback)
    lost = np.flatnonzero(np.isin(found.status, TOO_STEEP))
    fallback = None if system.iterated else fallback  # a map has no steps
    if fallback is not None and lost.size:
        found = found.replaced(lost, run(model, z0[:, lost], time=length, scheme=fallback))
    fine = found.status == Status.OK
    row = (slice(None), *cell)
    with np.errstate(all="ignore"):
        for target, chosen in ((scan.medians, fine), (scan.chaotic_medians, fine & found.chaotic)):
            if chosen.any():
                target[row] = np.median(found.values[:, chosen], axis=1)
    scan.orbits[cell] = fine.size
    scan.recomputed[cell] = np.count_nonzero(fine[lost]) if fallback is not None else 0
    for name in ("chaotic", "regular", "undecided"):
        getattr(scan, name)[cell] = np.count_nonzero(getattr(found, name) & fine)
    scan.statuses[row] = np.bincount(found.status, minlength=len(Status))
    scan.thresholds[row] = np.median(found.thresholds, axis=1)
    scan.time[cell] = length
    scan.step[cell] = np.median(found.step)
    scan.energy_error[cell] = found.energy_error[fine].max() if fine.any() else math.nan
    scan.done[cell] = True
