"""One run of orbits to their crossings of a section: brackets are recorded, then located on the flow."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..core.interruption import partial_result_on_interrupt
from ..core.numbers import Passes, fits
from ..core.status import Status
from ..engine.jit import LANES
from ..engine.kernels import crossings as kernels
from ..engine.kernels.crossing_roots import compact, gather
from ..engine.kernels.crossings import RECORD
from ..engine.kernels.samples import DAMPING_ROWS
from ..engine.packing import run_units
from ..engine.threads import by_portions
from ..runs import observers
from ..runs.flow import Ensemble, Flow, early, energy_error
from ..runs.requirements import energy_drift
from ..runs.scales import typical_rate
from ..runs.time_transformed import TransformedFlow
from ..systems.models.mechanics import System
from .section_map import SectionMap

PORTION = 2**27
"""Bytes that are used beside the result at a time."""

COMPARED = 16
"""Work memory of an orbit, in units of its crossings."""

LOOKED = 2**24
"""Bytes of the arrays whose energies are computed at a time: a part of the cache, where NumPy is a third faster."""
LATER = 0.02
"""Work of orbits that have lost a suspected crossing and go on, relative to that of all."""
SPARE = 8
"""Record slots beyond the wanted crossings, for suspected pairs of crossings inside a step."""
FD_STEP = 1e-6
"""Displacement, in amplitudes of the motion or relative, for slopes of the section function."""
START = 8 * float(np.finfo(float).eps)
"""Section function at the start, relative to its changes with z and over a step, and time after max_time, that are
rounding.
"""
LATE = 1e-13
"""Part of a step by which a crossing at max_time may be located too late."""
LAST_RECORDS = 500_000
"""Crossings still located after Ctrl-C, in about half a second; the later orbits of a larger run lose theirs."""


SOME = 64
"""Orbits that show the time of all, for the reported progress."""


class Crossings(NamedTuple):
    """The crossings asked for: the section, their number for each orbit, the time after which an orbit ends without
    them, and the energy error above which it drifts.
    """

    section: Any
    number: int
    max_time: Any
    tolerance: float


class ReferenceCrossings(NamedTuple):
    """The crossings (crossings, orbits) of another run, and the largest differences (orbits,) in time of the same
    crossings: runs that are compared with it end where they have parted.
    """

    times: np.ndarray
    apart: np.ndarray


def crossed(
    flow: Flow | TransformedFlow,
    system: System,
    z: np.ndarray,
    crossings: Crossings,
    callback,
    radius=None,
    damping=None,
    beside: ReferenceCrossings | None = None,
) -> tuple[SectionMap, np.ndarray]:
    """Follow the orbits once; return their crossings and the times that they reached.

    The energy is not checked of a run `beside` another, and of orbits that are slowed.
    """
    asked, wanted, max_time, tolerance = crossings
    section = flow.section(asked)
    ensemble = flow.ensemble(z, radius=radius)
    rows, orbits = ensemble.z.shape
    width = RECORD.state + rows
    slots = wanted + SPARE
    fits("crossings", orbits, slots, width)
    compared = beside is not None and isinstance(flow, Flow)  # the steps of another flow are not of time
    observer = observers.crossings(section, wanted, flow.model.degrees_of_freedom, beside=compared)
    if damping is not None:
        pace = damping.pace(ensemble.ahead)
        first = observer.rows
        observer = observers.either(observer, observers.damped_samples(rows, int(pace.min())))
    memory = np.zeros((observer.rows, orbits))
    out = np.empty((orbits, slots * width))
    records = out.reshape(orbits, slots, width)

    def begin(at: slice) -> None:
        assert beside is not None
        out[at] = np.nan
        times = beside.times.T[at]
        apart = beside.apart[at, None]
        records[at, :wanted, RECORD.earliest] = times - apart
        records[at, :wanted, RECORD.latest] = times + apart

    if compared:
        by_portions(begin, orbits, out.shape[1], flow.threads)
    if damping is not None:
        damping.begin(ensemble, memory[first:], pace)
        memory[first + DAMPING_ROWS.stride] = pace
        memory[first + DAMPING_ROWS.left] = pace

    def found(interrupted: bool) -> SectionMap:
        checked = (
            None
            if beside is not None
            else tolerance
            if damping is None
            else np.where(damping.share > 0, np.inf, tolerance)
        )
        result = _result(flow, system, ensemble, section, wanted, memory, out, checked)
        points = system.turned_back(flow.states(result.points))
        result = replace(result, points=points, section=asked)
        if interrupted:
            result.status[result.status == Status.TOO_FEW_CROSSINGS] = Status.INTERRUPTED  # there may be more
        return result

    with partial_result_on_interrupt("poincare_map", lambda: found(True)):
        start_crossings(flow, memory, section, ensemble)
        follow_crossings(flow, ensemble, section, wanted, observer, memory, out, max_time, callback)
    return found(False), ensemble.time


def _share(flow: Flow | TransformedFlow, ensemble: Ensemble, wanted: int, max_time: float) -> float:
    """Return the share of the steps to max_time after which orbits should have their crossings: one a turn."""
    turns = max_time
    if flow.system.canonical:
        some = ensemble.points[:, :: max(1, ensemble.points.shape[1] // SOME)]
        turns = min(max_time, wanted * 2 * np.pi / typical_rate(flow.system, some))
    return turns / max_time / flow.patience


def start_crossings(
    flow: Flow | TransformedFlow, memory: np.ndarray, section: Any, ensemble: Ensemble, *, on: bool = False
) -> None:
    """Set the section function at the start and a step before it; `on` says that all starts are on the section, to some
    error.

    Where a start is on the section, to rounding of z or of a step, it keeps only the sign of the function just after
    it.
    """
    z = ensemble.points
    n = flow.model.degrees_of_freedom
    with np.errstate(all="ignore"):
        value = _section_values(section, z)
        change = (_section_values(section, z + FD_STEP * ensemble.ahead * flow.system.slopes(z)) - value) / FD_STEP
        nudged = z[:, None] * (1 + FD_STEP * np.eye(2 * n)[:, :, None])
        size = np.abs(change) + np.abs(_section_values(section, nudged) - value).sum(axis=0) / FD_STEP
        leaving = np.where(np.abs(change) > 1e-9 * size, kernels.BARELY * np.sign(change), 0.0)
        memory[kernels.ROWS.before] = np.where((np.abs(value) <= START * size) | on, leaving, value)
    before = replace(ensemble, z=flow.shifted(ensemble.z, -ensemble.ahead))
    memory[kernels.ROWS.earlier] = _section_values(section, before.points)
    memory[kernels.ROWS.size] = np.fmax(np.abs(memory[kernels.ROWS.earlier]), np.abs(value))
    memory[kernels.ROWS.time_earlier] = -ensemble.ahead
    memory[kernels.ROWS.state : kernels.ROWS.state + len(ensemble.z)] = ensemble.z


def _section_values(section: Any, z: np.ndarray) -> np.ndarray:
    """Return the section function at z (2n, ...), one number for each point."""
    with np.errstate(all="ignore"):
        return np.asarray(section.value(*z), dtype=np.float64) + np.zeros(z.shape[1:])


def follow_crossings(
    flow: Flow | TransformedFlow, ensemble: Ensemble, section, wanted, observer, memory, out, max_time, callback
) -> None:
    """Run, locate and drop false alarms until every orbit has its crossings or has ended.

    After an interruption the records so far are located before it is passed on; a record that is not located is never
    kept, and its orbit is INTERRUPTED.
    """
    rows, orbits = ensemble.z.shape
    records = out.reshape(-1, RECORD.state + rows)
    slot = np.arange(out.shape[1] // records.shape[1])
    located = np.zeros(orbits, np.int64)
    looked = np.zeros(orbits, dtype=bool)
    interrupted = False
    parted = np.zeros(orbits, dtype=bool)
    passes = Passes(callback)
    share = 1.0 if callback is None else _share(flow, ensemble, wanted, max_time)
    # A crossing at the last step may be located a rounding of a step beyond it.
    late = LATE * np.where(np.isfinite(ensemble.ahead), np.abs(ensemble.ahead), 0.0)
    limit = max_time * (1 + START) + late
    reached = np.full(orbits, np.nan)

    def settle(most: int | None) -> np.ndarray:
        """Locate the new records, but at most so many, and keep the crossings that exist and are in time; return their
        numbers.
        """
        written = memory[kernels.ROWS.written].astype(np.int64)
        parted[:] |= memory[kernels.ROWS.certain] == kernels.PARTED
        found = np.flatnonzero((slot >= located[:, None]) & (slot < written[:, None]))
        left = np.zeros(orbits, bool)
        try:
            flow.locate(section, records, found[:most])
        finally:
            run_units(compact, (rows, out, written, limit, left), -(-orbits // LANES), threads=flow.threads)
            ensemble.status[left & (written < wanted)] = Status.INTERRUPTED
            memory[kernels.ROWS.written] = written
            memory[kernels.ROWS.certain] = written
        return written

    while True:
        try:
            told = early(passes.take(1.0, LATER), flow, ensemble, max_time, share)
            flow.advance(ensemble, observer, memory, out, time=max_time, refill=True, callback=told)
        except KeyboardInterrupt:
            interrupted = True
        try:
            located = settle(LAST_RECORDS if interrupted else None)
            missing = (ensemble.status == Status.OK) & (located < wanted) & ~parted
            ended = ensemble.time >= max_time * (1 - 1e-12)
            last = missing & ended & ~looked
            if last.any() and not interrupted:
                looked |= last
                if look_beyond(flow, ensemble, section, memory, out, last):
                    located = settle(None)
        except KeyboardInterrupt:
            interrupted = True
        if interrupted:
            raise KeyboardInterrupt
        short = missing & ~ended
        if not short.any():
            ensemble.time[:] = np.where(np.isnan(reached), ensemble.time, reached)
            return
        _hold(flow, ensemble, short, max_time, reached)


def look_beyond(flow, ensemble, section, memory, out, last: np.ndarray) -> bool:
    """Record suspected pairs around the ends of the orbits `last`, from the section function a step beyond; tell
    whether there are some.
    """
    rows = ensemble.z.shape[0]
    at = kernels.ROWS
    step = ensemble.ahead
    after = replace(ensemble, z=flow.shifted(ensemble.z, step))
    records = out.reshape(len(out), -1, RECORD.state + rows)
    back = memory[at.time_before] - memory[at.time_earlier]
    with np.errstate(all="ignore"):
        now = _section_values(section, after.points)
        dip = last & kernels.may_touch_zero(memory[at.earlier], memory[at.before], now, back, step)
    for o in np.flatnonzero(dip):
        slot = int(memory[at.written, o])
        for k, kind in enumerate((kernels.LOWER, kernels.UPPER)):
            record = records[o, slot + k]
            record[RECORD.time] = memory[at.time_before, o]
            record[RECORD.kind] = kind
            record[RECORD.lower] = -back[o]
            record[RECORD.upper] = step[o]
            record[RECORD.state :] = memory[at.state : at.state + rows, o]
        memory[at.written, o] += 2
    return bool(dip.any())


def _hold(flow: Flow | TransformedFlow, ensemble: Ensemble, short: np.ndarray, max_time: float, reached) -> None:
    """Leave only the orbits that still miss crossings to the next round; keep the times that the others have
    `reached`.
    """
    finished = ~short & (ensemble.status == Status.OK)
    first = finished & np.isnan(reached)
    reached[first] = ensemble.time[first]
    if flow.adaptive:
        ensemble.time[finished] = np.broadcast_to(max_time, finished.shape)[finished]
    else:
        ensemble.count[finished] = np.broadcast_to(flow.steps(max_time), finished.shape)[finished]


def _result(flow, system: System, ensemble, section, wanted, memory, out, tolerance) -> SectionMap:
    """Assemble the map: cut each orbit at the wanted number and, unless there is no tolerance, where its energy has
    drifted.
    """
    rows, orbits = ensemble.z.shape
    counts = np.minimum(memory[kernels.ROWS.written].astype(np.int64), wanted)
    points = np.empty((rows, orbits, wanted))
    times = np.empty((orbits, wanted))
    error = np.zeros(orbits)
    status = ensemble.status.copy()
    residual = np.empty(orbits)

    def fill() -> None:
        """Read the points from the first `counts` records."""
        run_units(gather, (out, counts, points, times, residual), -(-orbits // LANES), threads=flow.threads)

    def look(at: slice) -> None:
        """Find the errors, the statuses and the numbers of points of some orbits."""
        ended = status[at]
        if tolerance is not None:
            found = ensemble.of(at)
            drift = energy_drift(flow.system, points[:, at], found.energy[:, None], found.scale[:, None])
            drift[np.isnan(times[at])] = -1.0
            bound = np.broadcast_to(tolerance, orbits)[at]
            beyond = drift > bound[:, None]
            worst = drift.max(axis=1)
            if beyond.any():
                counts[at] = np.where(beyond.any(axis=1), np.minimum(counts[at], beyond.argmax(axis=1)), counts[at])
            worst = np.where(ended == Status.OK, np.maximum(worst, energy_error(flow.system, found)), worst)
            ended[(ended == Status.OK) & (worst > bound)] = Status.ENERGY_DRIFT
            error[at] = np.maximum(worst, 0.0)
        ended[(ended == Status.OK) & (counts[at] < wanted)] = Status.TOO_FEW_CROSSINGS

    most = max(1, LOOKED // (8 * COMPARED * wanted * rows))

    def some(at: slice) -> None:
        for first in range(at.start, at.stop, most):
            look(slice(first, min(first + most, at.stop)))

    fill()
    read = counts.copy()
    by_portions(some, orbits, wanted * rows, flow.threads)
    if (counts < read).any():
        fill()
    return SectionMap(
        points=points.transpose(0, 2, 1),
        times=times.T,
        counts=counts,
        section_error=residual,
        energy_error=error,
        status=status,
        section=section,
        scheme=flow.scheme,
        step=flow.step,
        names=system.row_names,
    )
