"""Poincaré maps: crossings of a surface of section by many orbits."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...base.interruption import Interrupted, keeping
from ...base.numbers import fits, portion, positive, whole
from ...base.recipe import recorded
from ...base.results import put
from ...base.short_forms import starts_of, takes
from ...base.status import Status
from ...compile.threads import by_portions
from ...flows import observers
from ...flows.accuracy import Steps, halved, planned, until
from ...flows.checks import checked_model, checked_section, energy_drift
from ...flows.ensemble import Ensemble
from ...flows.flow import Flow, Report, Wear, energy_error
from ...flows.motion import Motion, motion
from ...flows.needs import check_given
from ...flows.options import Options, plan, suited
from ...flows.time_transformed import TransformedFlow
from ...formulas.section_text import section_of
from ...kernels import crossings as kernels
from ...kernels.crossings import RECORD
from ...kernels.samples import WEAR_ROWS
from ...models.contracts import Map, Model, Section
from ...models.mechanics import slopes
from ...models.sections import Stroboscopic
from ...models.traits import traits_of
from ...schemes.automatic import Automatic
from ...schemes.catalogue import Scheme, scheme_of
from ...schemes.time_transformed import TimeTransformed
from .section_map import SectionMap
from .stroboscopic import strobed

PORTION, COMPARED = 2**27, 16
"""Bytes that are taken beside the result at a time; how many times the crossings of an orbit these are."""

SPARE = 8
"""Record slots beyond the wanted crossings, for suspected pairs of crossings inside a step."""

SLOWEST = 2.0
"""Natural periods between crossings that steps are chosen for, where max_time allows more."""

NUDGE = 1e-6
"""Displacement, in amplitudes of the motion or relative, for slopes of the section function."""

START = 8 * float(np.finfo(float).eps)
"""Section function at the start, relative to its changes with z and over a step, and time after max_time, that are
rounding.
"""

SAME = 0.1
"""Distance, in amplitudes of the motion, below which crossings of the same number in two runs are the same."""

LAST_RECORDS = 500_000
"""Crossings still located after Ctrl-C: about half a second's worth; the later orbits of a larger run lose theirs."""


@takes(z0=starts_of, section=section_of, scheme=scheme_of)
@recorded
def poincare_map(
    body: Model | Map,
    z0: Any,
    *,
    section: Section | None = None,
    crossings: int,
    max_time: float | None = None,
    accuracy: float | None = None,
    step: float | np.ndarray | None = None,
    scheme: Scheme | TimeTransformed | Automatic | None = None,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    energy_tolerance: float | None = None,
    threads: int | None = None,
    report: Report | None = None,
) -> SectionMap:
    """Follow orbits of `body` from `z0` to their first `crossings` crossings of `section`, or iterates of a map.

    Parameters
    ----------
    body, z0 : as in `integrate`
    section : value of `fastaff.models.sections` (or your own) or str, optional
        Text such as "alpha-turning", "beta=0.2", "x=0" (crossed upwards), for a driven system "t=0"; none for a map.
    crossings : int >= 1
        Crossings of each orbit; for a map iterates, whose numbers are the times.
    max_time : float > 0, time, optional
        Ends every orbit. Sections other than stroboscopic ones need it; a map takes none.
    accuracy : float, optional
        Error of times (times the angular frequency) and of points (relative to the amplitudes of the motion); default
        1e-10 where neither it nor a step is given.
    step, scheme, rtol, atol, energy_tolerance, threads, report : as in `integrate`

    Returns
    -------
    `SectionMap`
        Points and times of the crossings.

    Raises
    ------
    ValueError, TypeError, Interrupted
        As in `integrate`.

    Notes
    -----
    A start on the section, to rounding, is no crossing, nor is one after max_time. A sign change of the section
    function over a step is always found. Two crossings within a step, without a sign change, are found where the
    function at three successive steps is smallest in the middle and a parabola reaches zero within a margin of two:
    then the extremum is searched on the flow. The first and last step are treated alike, from a step before the start
    and one beyond the end. Crossings are missed only where the function turns more than once between steps. A crossing
    is the root of the section function along fractional steps of the same scheme: it has the scheme's order, and a
    section error of rounding; nothing is interpolated. Crossings of a stroboscopic section are states after whole
    numbers of steps, at exact multiples of the period.

    Cost: the steps, and about eight steps for each crossing, in full lane blocks. Peak memory, whatever max_time is:
    three times 2n + 1 numbers for each crossing and eight more, of each orbit; with an accuracy the result, 4n + 2
    numbers, and some 130 MiB (bench/memory.py).

    References
    ----------
    Henon 1982, Physica D 5, 412 (the problem); Chandrupatla 1997 (the root finder).

    Examples
    --------
    >>> cut = fa.poincare_map(fa.HenonHeiles(), [0.0, 0.1, 0.3, 0.1], section="x=0", crossings=3, max_time=100.0)
    >>> cut.points.shape, cut["y"][:, 0].round(6)
    ((4, 3, 1), array([0.05131 , 0.033114, 0.051175]))
    """
    wanted = whole("crossings", crossings, 1)
    mapping = traits_of(checked_model(body)).iterated
    check_given(body, "a time", "the crossings of a map are its iterates", section=section, max_time=max_time)
    if not mapping:
        checked_section(section, body)
    options = Options(
        scheme, step, accuracy, rtol=rtol, atol=atol, energy_tolerance=energy_tolerance, threads=threads, report=report
    )
    options = suited(options, body)
    if isinstance(section, Stroboscopic):
        if max_time is not None:
            raise ValueError(f"max_time must be left out with a stroboscopic section, got {max_time!r}")
        return strobed(body, z0, section, wanted, options)
    if not mapping:
        if max_time is None:
            raise TypeError(f"max_time must be given: the time after which an orbit ends that misses {section!r}")
        max_time = positive("max_time", max_time)
    flow, z, _ = plan(body, z0, options, time=max_time, error=None, transformed=True)
    if mapping:
        return _iterated(flow, body, z, wanted, report)
    goal, tolerance = options.goal(), options.drift
    fits("crossings", wanted, *z.shape)
    if goal is not None:
        return _accurate(flow, body, z, section, wanted, max_time, tolerance, goal, report)
    return _mapped(flow, body, z, section, wanted, max_time, tolerance, report)[0]


def _iterated(flow: Flow, body: Any, z: np.ndarray, wanted: int, report: Report | None) -> SectionMap:
    """Return the iterates of a map."""
    ensemble, time = flow.ensemble(z), np.arange(1.0, wanted + 1)
    states, interrupted = flow.trajectory(ensemble, float(wanted), wanted, report)
    counts = np.isfinite(states).all(axis=1).sum(axis=0)
    nothing = np.zeros(counts.size)
    if interrupted:
        ensemble.status[(ensemble.status == Status.OK) & (counts < wanted)] = Status.INTERRUPTED
    times = np.where(time[:, None] <= counts, time[:, None], np.nan)
    found = SectionMap(
        points=states.transpose(1, 0, 2),
        times=times,
        counts=counts,
        section_error=nothing,
        energy_error=nothing.copy(),
        status=ensemble.status,
        section=None,
        scheme=flow.scheme,
        step=flow.step,
        names=traits_of(body).row_names,
    )
    with keeping("poincare_map", lambda: found):
        if interrupted:
            raise KeyboardInterrupt
    return found


def _mapped(
    flow, body, z, section, wanted, max_time, tolerance, report, radius=None, wear=None
) -> tuple[SectionMap, np.ndarray]:
    """Follow the orbits once; return their crossings and the times that they reached."""
    asked, section = section, flow.section(section)
    ensemble = flow.ensemble(z, radius=radius)
    rows, orbits = ensemble.z.shape
    width, slots = RECORD.state + rows, wanted + SPARE
    fits("crossings", orbits, slots, width)
    observer = observers.crossings(section, wanted, flow.model.degrees_of_freedom)
    if wear is not None:
        first, observer = observer.rows, observers.either(observer, observers.worn(rows))
    memory, out = np.zeros((observer.rows, orbits)), np.full((orbits, slots * width), np.nan)
    if wear is not None:
        memory[first + WEAR_ROWS.share], memory[first + WEAR_ROWS.early] = wear.share, np.sqrt(wear.early)

    def found(interrupted: bool) -> SectionMap:
        result = _result(flow, body, ensemble, section, wanted, memory, out, tolerance)
        points = traits_of(body).turned_back(flow.states(result.points))
        result = replace(result, points=points, section=asked)
        if interrupted:
            result.status[result.status == Status.TOO_FEW_CROSSINGS] = Status.INTERRUPTED  # there may be more
        return result

    with keeping("poincare_map", lambda: found(True)):
        start_crossings(flow, memory, section, ensemble)
        follow_crossings(flow, ensemble, section, wanted, observer, memory, out, max_time, report)
    return found(False), ensemble.time


class _Crossings(NamedTuple):
    """Orbits after a run: their map and the times they reached."""

    found: SectionMap
    reached: np.ndarray

    @property
    def status(self) -> np.ndarray:
        """The statuses (orbits,)."""
        return self.found.status

    def of(self, orbits: np.ndarray) -> _Crossings:
        """Return those of some of the orbits."""
        return _Crossings(self.found.take(orbits), self.reached[orbits])


def slants(model: Any, section: Any, points: np.ndarray, scales: Motion) -> np.ndarray:
    """Return how many times the error of a state is the error of its crossing (crossings, orbits), at least 1, NaN
    where there is none.

    That is the change of the section function by an amplitude of the motion over its change in a radian: large where
    orbits graze.
    """
    n = model.degrees_of_freedom
    z = np.ascontiguousarray(points.transpose(0, 2, 1))  # as crossings lie in memory: an orbit's together
    size = np.concatenate([scales.position, scales.momentum])[:, :, None]
    with np.errstate(all="ignore"):
        speed = slopes(model, z) / scales.rate[:, None]
        change, passing = np.zeros(z.shape[1:]), np.zeros(z.shape[1:])
        for row in range(2 * n):
            shift, (ahead, behind) = NUDGE * size[row], ([*z], [*z])
            ahead[row], behind[row] = z[row] + shift, z[row] - shift
            slope = (section.value(*ahead) - section.value(*behind)) / (2 * NUDGE)
            change += slope**2
            passing += np.where(size[row] > 0, slope / size[row], 0.0) * speed[row]
        return np.maximum(np.sqrt(change) / np.abs(passing), 1.0).T


def _steps(flow, body, z, wanted, max_time, accuracy) -> Steps:
    """Return the steps to begin with: for as long as the crossings may take, fractions of max_time."""
    found = motion(body, z, flow.threads)
    lasting = np.minimum(max_time, SLOWEST * wanted * 2 * np.pi / found.rate)
    return planned(flow, z, found, lasting, accuracy, run=max_time, parts=2)


def _accurate(flow, body, z, section, wanted, max_time, tolerance, accuracy, report) -> SectionMap:
    """Follow the orbits with steps that are halved until their crossings agree."""
    steps = _steps(flow, body, z, wanted, max_time, accuracy)
    rows, orbits = 2 * body.degrees_of_freedom, z.shape[1]
    result = SectionMap(
        points=np.full((orbits, wanted, rows), np.nan).transpose(2, 1, 0),
        times=np.full((orbits, wanted), np.nan).T,
        counts=np.zeros(orbits, np.int64),
        section_error=np.zeros(orbits),
        energy_error=np.zeros(orbits),
        status=np.full(orbits, int(Status.INTERRUPTED)),
        section=section,
        scheme=flow.scheme,
        step=np.full(orbits, np.nan),
        names=traits_of(body).row_names,
        time_error=np.full((orbits, wanted), np.nan).T,
        point_error=np.full((orbits, wanted, rows), np.nan).transpose(2, 1, 0),
        accurate_until=np.zeros(orbits),
    )

    def run(report: Report | None, orbits: np.ndarray, step: np.ndarray, wear: Wear | None) -> _Crossings:
        used = np.full(len(step), np.inf) if flow.adaptive else step
        start = np.ascontiguousarray(z[:, orbits])
        asked = section, wanted, max_time, tolerance, report, steps.motion.radius[orbits], wear
        try:
            part, reached = _mapped(flow.sized(step), body, start, *asked)
        except Interrupted as stopped:
            unfinished = np.full(len(step), int(Status.INTERRUPTED))  # whatever became of them with these steps
            put(result, orbits, replace(stopped.partial, step=used, status=unfinished))
            raise
        return _Crossings(replace(part, step=used), reached)

    def compare(fine: _Crossings, coarse: _Crossings, orbits: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return _compared(body, section, steps.motion.of(orbits), fine.found, coarse.found, flow.threads)

    def keep(orbits: np.ndarray, fine: _Crossings, chosen: np.ndarray, error: np.ndarray) -> None:
        where, part = orbits[chosen], fine if len(chosen) == len(orbits) else fine.of(chosen)
        error = error[:, chosen]
        scales = steps.motion.of(where)
        there = np.isfinite(part.found.times)
        late = np.where(there, error / scales.rate, np.nan)
        apart = np.where(there, error * np.concatenate([scales.position, scales.momentum])[:, None], np.nan)
        holds = np.where(there, error <= accuracy, True)
        lasting = until(holds, part.found.times, part.reached)
        put(result, where, replace(part.found, time_error=late, point_error=apart, accurate_until=lasting))

    def drifts(run: _Crossings) -> np.ndarray:
        return run.found.status == Status.ENERGY_DRIFT

    # Runs that are compared take several times the memory of their result: of some orbits at a time.
    parts = max(1, min(orbits, 8 * COMPARED * wanted * rows * orbits // PORTION))
    with keeping("poincare_map", lambda: result):
        for number, part in enumerate(np.array_split(np.arange(orbits), parts)):
            asked = partial(run, portion(report, number, parts))
            halved(flow, steps.of(part), accuracy, asked, compare, keep, drifts, part)
    return result


def _compared(body, section, motion: Motion, fine: SectionMap, coarse: SectionMap, threads: int) -> tuple:
    """Return distances (crossings, orbits) of states at crossings of two runs, radians up to these, and `slants`."""
    whole = np.empty((3, *fine.times.shape))

    def some(at: slice) -> None:
        scales, times, points = motion.of(at), fine.times[:, at], fine.points[..., at]
        with np.errstate(all="ignore"):
            late = np.abs(times - coarse.times[:, at]) * scales.rate
            apart = scales.distance((points - coarse.points[..., at]).transpose(1, 0, 2))
            apart = np.maximum(apart, late)
            slant = slants(body, section, points, scales)
            straight = apart / slant
        same = np.isfinite(apart) & (apart < SAME)
        # Behind the last crossing there is nothing to compare; behind one that one of the runs lacks nothing is known.
        ended = ~np.isfinite(times)
        known = np.logical_and.accumulate(same | ended, axis=0)
        straight = np.where(known, np.where(ended, 0.0, straight), np.inf)
        whole[..., at] = straight, np.where(ended, 0.0, times * scales.rate), np.where(ended, 1.0, slant)

    by_portions(some, len(fine), fine.points[..., :1].size, threads)
    return whole[0], whole[1], whole[2]


def start_crossings(
    flow: Flow | TransformedFlow, memory: np.ndarray, section: Any, ensemble: Ensemble, *, on: bool = False
) -> None:
    """Set the section function at the start and a step before it; `on` says that all starts are on the section, to some
    error.

    Where a start is on the section, to rounding of z or of a step, it keeps only the sign of the function just after
    it.
    """
    z, n = ensemble.points, flow.model.degrees_of_freedom
    with np.errstate(all="ignore"):
        value = _section_values(section, z)
        change = (_section_values(section, z + NUDGE * ensemble.ahead * slopes(flow.model, z)) - value) / NUDGE
        size = np.abs(change)
        for row in np.eye(2 * n):
            size += np.abs(_section_values(section, z * (1 + NUDGE * row[:, None])) - value) / NUDGE
        leaving = np.where(np.abs(change) > 1e-9 * size, kernels.BARELY * np.sign(change), 0.0)
        memory[kernels.ROWS.before] = np.where((np.abs(value) <= START * size) | on, leaving, value)
    before = replace(ensemble, z=flow.shifted(ensemble.z, -ensemble.ahead))
    memory[kernels.ROWS.earlier] = _section_values(section, before.points)
    memory[kernels.ROWS.time_earlier] = -ensemble.ahead
    memory[kernels.ROWS.state : kernels.ROWS.state + len(ensemble.z)] = ensemble.z


def _section_values(section: Any, z: np.ndarray) -> np.ndarray:
    """Return the section function at z (2n, orbits), one number for each orbit."""
    with np.errstate(all="ignore"):
        return np.asarray(section.value(*z), dtype=np.float64) + np.zeros(z.shape[1])


def follow_crossings(
    flow: Flow | TransformedFlow, ensemble: Ensemble, section, wanted, observer, memory, out, max_time, report
) -> None:
    """Run, locate and drop false alarms until every orbit has its crossings or has ended.

    After an interruption the records so far are located before it is passed on; what is not located is never kept, and
    an orbit that misses it is INTERRUPTED.
    """
    rows, orbits = ensemble.z.shape
    records = out.reshape(-1, RECORD.state + rows)
    slot = np.arange(out.shape[1] // records.shape[1])
    located, looked, interrupted = np.zeros(orbits, np.int64), np.zeros(orbits, dtype=bool), False

    def settle(most: int | None) -> np.ndarray:
        """Locate what was recorded since, but at most so much, and keep what is there and in time; return the numbers
        of crossings.
        """
        written = memory[kernels.ROWS.written].astype(np.int64)
        found = np.flatnonzero((slot >= located[:, None]) & (slot < written[:, None]))
        where = found[:most]
        try:
            flow.locate(section, records, where)
        finally:
            limit = np.broadcast_to(max_time, orbits)[where // slot.size]
            late = ~((records[where, RECORD.time] > 0.0) & (records[where, RECORD.time] <= limit * (1 + START)))
            records[where[late], RECORD.kind] = kernels.NOTHING
            kind = records[found, RECORD.kind]
            left = found[(kind != kernels.LOCATED) & (kind != kernels.NOTHING)] // slot.size
            kernels.compact(rows, out, written)
            ensemble.status[left[written[left] < wanted]] = Status.INTERRUPTED
            memory[kernels.ROWS.written], memory[kernels.ROWS.certain] = written, written
        return written

    while True:
        try:
            flow.advance(ensemble, observer, memory, out, time=max_time, refill=True, report=report)
        except KeyboardInterrupt:
            interrupted = True
        try:
            located = settle(LAST_RECORDS if interrupted else None)
            missing = (ensemble.status == Status.OK) & (located < wanted)
            ended = ensemble.time >= max_time * (1 - 1e-12)
            last = missing & ended & ~looked
            if last.any() and not interrupted:
                look_beyond(flow, ensemble, section, memory, out, last)
                looked |= last
                located = settle(None)
        except KeyboardInterrupt:
            interrupted = True
        if interrupted:
            raise KeyboardInterrupt
        short = missing & ~ended
        if not short.any():
            return
        _hold(flow, ensemble, short, max_time)


def look_beyond(flow, ensemble, section, memory, out, last: np.ndarray) -> None:
    """Record suspected pairs around the ends of the orbits `last`, from the section function a step beyond."""
    rows, at = ensemble.z.shape[0], kernels.ROWS
    after = replace(ensemble, z=flow.shifted(ensemble.z, ensemble.ahead))
    now, step = _section_values(section, after.points), ensemble.ahead
    records = out.reshape(len(out), -1, RECORD.state + rows)
    for o in np.flatnonzero(last):
        time = memory[at.time_before, o]
        back = time - memory[at.time_earlier, o]
        if kernels.dips(memory[at.earlier, o], memory[at.before, o], now[o], back, step[o]):
            slot = int(memory[at.written, o])
            for k, kind in enumerate((kernels.LOWER, kernels.UPPER)):
                record = records[o, slot + k]
                record[RECORD.time], record[RECORD.kind] = time, kind
                record[RECORD.lower], record[RECORD.upper] = -back, step[o]
                record[RECORD.state :] = memory[at.state : at.state + rows, o]
            memory[at.written, o] += 2


def _hold(flow: Flow | TransformedFlow, ensemble: Ensemble, short: np.ndarray, max_time: float) -> None:
    """Leave only the orbits that still miss crossings to the next round."""
    finished = ~short & (ensemble.status == Status.OK)
    if flow.adaptive:
        ensemble.time[finished] = np.broadcast_to(max_time, finished.shape)[finished]
    else:
        ensemble.count[finished] = np.broadcast_to(flow.steps(max_time), finished.shape)[finished]


def _result(flow, body, ensemble, section, wanted, memory, out, tolerance) -> SectionMap:
    """Assemble the map: cut each orbit at the wanted number and where its energy has drifted."""
    rows, orbits = ensemble.z.shape
    width = RECORD.state + rows
    records = out.reshape(orbits, -1, width)[:, :wanted]
    counts = np.minimum(memory[kernels.ROWS.written].astype(np.int64), wanted)
    kept = np.arange(wanted) < counts[:, None]
    points, times = records[:, :, RECORD.state :], np.where(kept, records[:, :, RECORD.time], np.nan)
    drift = np.full(times.shape, -1.0)
    most = max(1, PORTION // (8 * COMPARED * wanted * rows))

    def look(at: slice) -> None:
        for first in range(at.start, min(at.stop, orbits), most):
            part = slice(first, min(first + most, at.stop))
            there, count = kept[part], counts[part]
            start, scale = (np.repeat(entry[part], count) for entry in (ensemble.energy, ensemble.scale))
            drift[part][there] = energy_drift(flow.model, points[part].transpose(2, 0, 1)[:, there], start, scale)

    by_portions(look, orbits, wanted * rows, flow.threads)
    beyond = drift > tolerance
    first = np.where(beyond.any(axis=1), beyond.argmax(axis=1), wanted)
    error = drift.max(axis=1)
    error = np.where(ensemble.status == Status.OK, np.maximum(error, energy_error(flow.model, ensemble)), error)
    status = ensemble.status.copy()
    status[(status == Status.OK) & (error > tolerance)] = Status.ENERGY_DRIFT
    status[(status == Status.OK) & (counts < wanted)] = Status.TOO_FEW_CROSSINGS
    written = memory[kernels.ROWS.written].astype(np.int64)
    counts = np.minimum(counts, first)
    slot = np.arange(wanted)
    dropped = (slot >= counts[:, None]) & (slot < written[:, None])
    points[dropped], times[dropped] = np.nan, np.nan
    residual = np.where(slot < counts[:, None], np.abs(records[:, :, RECORD.residual]), 0.0).max(axis=1)
    return SectionMap(
        points=points.transpose(2, 1, 0),
        times=times.T,
        counts=counts,
        section_error=residual,
        energy_error=np.maximum(error, 0.0),
        status=status,
        section=section,
        scheme=flow.scheme,
        step=flow.step,
        names=traits_of(body).row_names,
    )
