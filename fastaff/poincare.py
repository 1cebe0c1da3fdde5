"""Poincaré maps: crossings of a surface of section by many orbits (layer L3)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from . import observers
from .auto import Automatic
from .boundary import checked_model, checked_section, energy_drift
from .charts import Chart
from .engine import Ensemble, Flow, Interrupted, Report, energy_error
from .kernels import crossings as kernels
from .scalars import positive, whole
from .schemes import KAHAN_LI8, RungeKutta, Splitting
from .status import Status, describe, raise_if_failed
from .transformed import TimeTransformed, lowered, transformed_section
from .transformed_flow import TransformedFlow, flow_over

SPARE = 8
"""Record slots beyond the wanted crossings, for suspected pairs of crossings inside a step."""

LAST_RECORDS = 500_000
"""Crossings still located after Ctrl-C: about half a second's worth; the later orbits of a larger run lose theirs."""


@dataclass(frozen=True)
class SectionMap:
    """Crossings of a section.

    points (orbits, crossings, 2n), the states at the crossings, and times (orbits, crossings): NaN past counts (orbits,).
    section_error (orbits,): the largest |section(z)| over the crossings; energy_error (orbits,): the largest
    |E - E0|/(T0 + |V0|) over them; status (orbits,) of `Status`; step: the fixed step, or inf for an adaptive scheme.
    An orbit with the status ENERGY_DRIFT keeps the crossings before its energy error exceeded the tolerance.
    """

    points: np.ndarray
    times: np.ndarray
    counts: np.ndarray
    section_error: np.ndarray
    energy_error: np.ndarray
    status: np.ndarray
    section: Any
    scheme: Splitting | RungeKutta | TimeTransformed
    step: float

    def coordinates(self, chart: Chart) -> np.ndarray:
        """Return the crossings in a chart of GL(2,R): (8, orbits, crossings), coordinates and momenta, NaN past counts."""
        z = np.moveaxis(self.points, -1, 0)
        kept = np.isfinite(self.times)
        converted = np.full(z.shape, np.nan)
        converted[:, kept] = chart.from_planes(z[:, kept])
        return converted

    def raise_if_failed(self) -> None:
        """Raise OrbitError unless every orbit is OK."""
        raise_if_failed(self.status)

    def summary(self) -> str:
        """Say in one line what became of the orbits."""
        return describe(self.status)


def poincare_map(
    body: Any, z0: Any, *, section: Any, crossings: int, max_time: float, step: float | None = None,
    scheme: Splitting | RungeKutta | TimeTransformed | Automatic = KAHAN_LI8, rtol: float = 1e-12, atol: float = 1e-12,
    energy_tolerance: float = 1e-6, threads: int | None = None, report: Report | None = None,
) -> SectionMap:  # fmt: skip
    """Follow orbits of `body` from `z0` to their first `crossings` crossings of `section`.

    Parameters: z0 (2n,) or (2n, orbits); section: a value of `fastaff.sections` (or your own); crossings >= 1; max_time > 0
    ends every orbit, whatever it does; step, scheme, rtol, atol, energy_tolerance, threads, report as in `integrate`.
    Returns SectionMap. Raises ValueError or TypeError for wrong input; Interrupted on Ctrl-C, with `.partial`.

    A start on the section itself is not counted. A sign change of the section function over a step is always found. Two
    crossings inside a step, where the sign does not change, are found when the function's values at three successive steps
    have their smallest in the middle and a parabola through them reaches zero within a margin of two: then the extremum
    between them is searched on the flow. They are missed only where the function turns more than once between steps.
    A crossing is the root of the section function along fractional steps of the same scheme, so it has the scheme's order
    and section error at the level of rounding; nothing is interpolated.
    Cost: the steps, and about eight steps for each crossing, located in full lane blocks. Memory: (2n + 4) numbers for each
    crossing and orbit, whatever max_time is.
    Source: Henon 1982, Physica D 5, 412 (the problem); Chandrupatla 1997 (the root finder).
    """
    wanted = whole("crossings", crossings, 1)
    max_time, tolerance = positive("max_time", max_time), positive("energy_tolerance", energy_tolerance)
    checked_section(section, checked_model(body))
    flow, z = flow_over(max_time, body, z0, scheme, step, rtol, atol, threads)
    if isinstance(flow, TransformedFlow):
        section = transformed_section(section, body.degrees_of_freedom)
    ensemble = flow.ensemble(z)
    rows, orbits = z.shape
    width = kernels.RECORD + rows
    slots = wanted + SPARE
    observer = observers.crossings(section, wanted, flow.model.degrees_of_freedom)
    memory, out = np.zeros((observer.rows, orbits)), np.full((orbits, slots * width), np.nan)
    start_crossings(memory, section, ensemble)
    interrupted = False
    try:
        follow_crossings(flow, ensemble, section, wanted, observer, memory, out, max_time, report)
    except KeyboardInterrupt:
        interrupted = True
    result = _result(flow, ensemble, section, wanted, memory, out, max_time, tolerance)
    if isinstance(flow, TransformedFlow):
        points = np.moveaxis(lowered(np.moveaxis(result.points, -1, 0)), 0, -1)
        result = replace(result, points=np.ascontiguousarray(points), section=section.section)
    if interrupted:
        result.status[(result.status == Status.TOO_FEW_CROSSINGS) & (ensemble.time < max_time)] = Status.INTERRUPTED
        stopped = Interrupted("poincare_map")
        stopped.partial = result
        raise stopped
    return result


def start_crossings(memory: np.ndarray, section: Any, ensemble: Ensemble) -> None:
    """Set the section function before the first step; a start on the section, to rounding, counts as exactly on it."""
    z = ensemble.points
    value = np.asarray(section.value(*z), dtype=np.float64) + np.zeros(z.shape[1])
    size = 1.0 + (z * z).sum(axis=0)
    memory[1] = np.where(np.abs(value) <= 1e-13 * size, 0.0, value)
    memory[kernels.MEMORY :] = ensemble.z


def follow_crossings(flow: Flow | TransformedFlow, ensemble: Ensemble, section, wanted, observer, memory, out, max_time, report) -> None:
    """Run, locate and drop false alarms until every orbit has its crossings or has ended.

    After an interruption the records so far are located before it is passed on; what is not located is never kept.
    """
    rows = ensemble.z.shape[0]
    width = kernels.RECORD + rows
    located = np.zeros(out.shape[0], np.int64)
    interrupted = False
    while True:
        try:
            flow.advance(ensemble, observer, memory, out, time=max_time, refill=True, report=report)
        except KeyboardInterrupt:
            interrupted = True
        written = memory[5].astype(np.int64)
        slot = np.arange(out.shape[1] // width)
        where = np.flatnonzero((slot >= located[:, None]) & (slot < written[:, None]))
        try:
            flow.locate(section, out.reshape(-1, width), where[:LAST_RECORDS] if interrupted else where)
        except KeyboardInterrupt:
            interrupted = True
        kernels.compact(rows, out, written)
        memory[5], memory[6] = written, written
        located = written
        short = (ensemble.status == Status.OK) & (written < wanted) & (ensemble.time < max_time * (1 - 1e-12))
        if interrupted:
            raise KeyboardInterrupt
        if not short.any():
            return
        _hold(flow, ensemble, short, max_time)


def _hold(flow: Flow | TransformedFlow, ensemble: Ensemble, short: np.ndarray, max_time: float) -> None:
    """Leave only the orbits that still miss crossings to the next round."""
    finished = ~short & (ensemble.status == Status.OK)
    if flow.adaptive:
        ensemble.time[finished] = max_time
    else:
        ensemble.count[finished] = flow.steps(max_time)


def _result(flow, ensemble, section, wanted, memory, out, max_time, tolerance) -> SectionMap:
    """Assemble the map: cut each orbit at the wanted number and where its energy has drifted."""
    rows, orbits = ensemble.z.shape
    width = kernels.RECORD + rows
    records = out.reshape(orbits, -1, width)[:, :wanted]
    counts = np.minimum(memory[5].astype(np.int64), wanted)
    kept = np.arange(wanted) < counts[:, None]
    points, times = records[:, :, kernels.RECORD :], np.where(kept, records[:, :, 0], np.nan)
    drift = np.full(times.shape, -1.0)
    start, scale = np.repeat(ensemble.energy, counts), np.repeat(ensemble.scale, counts)
    drift[kept] = energy_drift(flow.model, points.transpose(2, 0, 1)[:, kept], start, scale)
    beyond = drift > tolerance
    first = np.where(beyond.any(axis=1), beyond.argmax(axis=1), wanted)
    error = drift.max(axis=1)
    error = np.where(ensemble.status == Status.OK, np.maximum(error, energy_error(flow.model, ensemble)), error)
    status = ensemble.status.copy()
    status[(status == Status.OK) & (error > tolerance)] = Status.ENERGY_DRIFT
    status[(status == Status.OK) & (counts < wanted)] = Status.TOO_FEW_CROSSINGS
    written = memory[5].astype(np.int64)
    counts = np.minimum(counts, first)
    slot = np.arange(wanted)
    dropped = (slot >= counts[:, None]) & (slot < written[:, None])
    points[dropped], times[dropped] = np.nan, np.nan
    residual = np.zeros(orbits)
    np.maximum.at(residual, np.repeat(np.arange(orbits), counts), np.abs(records[slot < counts[:, None], 2]))
    return SectionMap(
        points, times, counts, residual, np.maximum(error, 0.0), status, section, flow.scheme, flow.step
    )
