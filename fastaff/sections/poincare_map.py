"""Poincaré maps: crossings of a surface of section by many orbits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.interruption import Interrupted, partial_result_on_interrupt
from ..core.numbers import MOST, Callback, fits, portion, positive, shown, whole
from ..core.status import Status
from ..engine.kernels.crossing_roots import conditioning_of
from ..engine.packing import launch, units
from ..engine.threads import by_portions
from ..results.calls import Starts, coerces_arguments, records_call
from ..results.result import put
from ..runs.accuracy import Steps, planned, refine_steps, until
from ..runs.flow import Damping, Flow
from ..runs.observers import bound
from ..runs.options import Options, Problem
from ..runs.requirements import check_given, checked_section, checked_system, phase_points
from ..runs.scales import MotionScales, motion, typical_rate
from ..runs.schemes.automatic import Automatic
from ..runs.schemes.catalogue import Scheme, scheme_of
from ..runs.schemes.time_transformed import TimeTransformed
from ..runs.starts import starts_of
from ..systems.formulas.section_text import section_in_words, section_of
from ..systems.models.contracts import Dynamics, Section
from ..systems.models.mechanics import System
from ..systems.models.sections import Stroboscopic
from .crossing_run import COMPARED, FD_STEP, PORTION, Crossings, ReferenceCrossings, crossed
from .section_map import SectionMap
from .stroboscopic import strobed

SLOWEST = 2.0
"""Natural periods between crossings that steps are chosen for, where max_time allows more."""


SAME = 0.1
"""Distance, in amplitudes of the motion, below which crossings of the same number in two runs are the same."""

PARTED = 0.2
"""Radians of the motion between crossings of two runs from which on the coarser run is not compared."""


@coerces_arguments(z0=starts_of, section=section_of, scheme=scheme_of)
@records_call
@inserts_parameters
def poincare_map(
    model: Dynamics,
    z0: Starts,
    *,
    section: Section | str | None = None,
    crossings: int,
    max_time: float | None = None,
    direction: int | None = None,
    accuracy: float | None = None,
    step: float | np.ndarray | None = None,
    scheme: Scheme | str | TimeTransformed | Automatic | None = None,
    rtol: float = 1e-12,
    atol: float = 1e-12,
    energy_tolerance: float | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
) -> SectionMap:
    """Compute the crossings of orbits with a surface of section, or the iterates of a map.

    Parameters
    ----------
    {model}
    {z0}
    {section}
    crossings : int
        Number of crossings of each orbit, 1 or more. For a map, number of iterates.
    {max_time}
    direction : {1, -1, 0}, optional
        Crossings that count: 1 if the section function increases there, -1 if it decreases, 0 for both. Default: the
        direction of `section`.
    accuracy : float, default 1e-10
        Requested error of the points, relative to the amplitudes of the motion, and of the crossing times, multiplied
        by its angular frequency. It determines the step size of each orbit. Not supported for ODE systems and adaptive
        methods; use `rtol` and `atol`.
    {step}
    {scheme}
    {rtol}
    {atol}
    {energy_tolerance}
    {threads}
    {callback}

    Returns
    -------
    `SectionMap`
        Points and times of the crossings, with error estimates and the status of each orbit.

    Raises
    ------
    ValueError
        If a value is out of its range, `max_time` is given with a stroboscopic section, or the section has no
        direction.
    TypeError
        If `max_time` is missing, or an argument does not suit the model.
    Interrupted
        On Ctrl-C, with the crossings so far in ``.partial``.

    Notes
    -----
    - Crossings: initial conditions on the section and points after `max_time` do not count. Sign changes of the section
      function are always found. Two crossings within one step are found from the extremum between them; crossings are
      missed only if the function turns more than once between steps.
    - Accuracy: each crossing is a root of the section function along fractional steps, of the order of the method. A
      stroboscopic section has states after whole numbers of steps, at exact multiples of the drive period.
    - Cost: the steps, and about eight more for each crossing.
    - Memory: 6n + 11 numbers for each crossing, for any `max_time`; if an accuracy is requested, 4n + 2 and 130 MiB.

    References
    ----------
    Henon 1982, Physica D 5, 412 (the problem); Chandrupatla 1997 (the root finder).

    Examples
    --------
    >>> cut = fa.poincare_map(fa.HenonHeiles(), [0.0, 0.1, 0.3, 0.1], section="x=0", crossings=3, max_time=100.0)
    >>> cut.points.shape, cut["y"][:, 0].round(6)
    ((4, 3, 1), array([0.05131 , 0.033114, 0.051175]))
    """
    options = Options(
        scheme,
        step,
        accuracy,
        rtol=rtol,
        atol=atol,
        energy_tolerance=energy_tolerance,
        threads=threads,
        callback=callback,
    )
    problem = Problem(model, z0, options)
    if direction is not None:
        section = _directed(section, direction)
    wanted = Crossings(section, whole("crossings", crossings, 1), max_time, options.drift)
    system = checked_system(problem.model)
    mapping = system.iterated
    given = {"section": wanted.section, "max_time": max_time}
    check_given(system, "a time", "the crossings of a map are its iterates", **given)
    if not mapping:
        checked_section(wanted.section, system)
    problem = problem.suited()
    goal = problem.options.goal()
    if isinstance(wanted.section, Stroboscopic):
        if max_time is not None:
            raise ValueError(f"max_time must be left out with a stroboscopic section, got {shown(max_time)}")
        return strobed(problem, wanted)
    if not mapping:
        if max_time is None:
            raise TypeError(
                "max_time is required for the section "
                f"{section_in_words(wanted.section, system)}.{_enough(problem, wanted.number)}"
            )
        wanted = wanted._replace(max_time=positive("max_time", max_time))
    flow, z, *_ = problem.plan(time=wanted.max_time, error=None, transformed=True)
    if mapping:
        return _iterated(flow, system, z, wanted.number, callback)
    fits("crossings", wanted.number, *z.shape)
    if goal is not None:
        return _accurate(flow, system, z, wanted, goal, callback)
    return crossed(flow, system, z, wanted, callback)[0]


def _directed(section: Any, direction: Any) -> Any:
    """Return a section that is crossed in that direction."""
    sign = whole("direction", direction, -MOST)
    if sign not in (-1, 0, 1):
        raise ValueError(f"direction must be 1, -1 or 0, got {sign}")
    if "direction" not in getattr(section, "_fields", ()):
        raise ValueError(f"direction must be left out for a section without a direction, got {shown(direction)}")
    return section._replace(direction=sign)


def _enough(problem: Problem, wanted: int) -> str:
    """Return a sentence with the time for so many crossings: four turns of the orbits for each."""
    system = problem.system
    if not system.canonical:
        return ""
    turn = 2 * np.pi / typical_rate(system, phase_points("z0", problem.z0, system))
    return f" The typical period is {turn:.2g}. Try max_time={float(f'{4 * wanted * turn:.1g}'):g}."


def _iterated(flow: Flow, system: System, z: np.ndarray, wanted: int, callback: Callback | None) -> SectionMap:
    """Return the iterates of a map."""
    ensemble = flow.ensemble(z)
    time = np.arange(1.0, wanted + 1)
    states, interrupted = flow.trajectory(ensemble, float(wanted), wanted, callback)
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
        names=system.row_names,
    )
    with partial_result_on_interrupt("poincare_map", lambda: found):
        if interrupted:
            raise KeyboardInterrupt
    return found


class _CrossingRun(NamedTuple):
    """Orbits after a run: their map and the times they reached."""

    found: SectionMap
    reached: np.ndarray

    @property
    def status(self) -> np.ndarray:
        """The statuses (orbits,)."""
        return self.found.status

    def of(self, orbits: np.ndarray) -> _CrossingRun:
        """Return the crossings of some of the orbits."""
        return _CrossingRun(self.found.take(orbits), self.reached[orbits])


def crossing_conditioning(system: System, section: Any, points: np.ndarray, scales: MotionScales) -> np.ndarray:
    """Return the ratio of the error of a crossing to that of its state (crossings, orbits), at least 1, NaN where there
    is none.

    It is the change of the section function by an amplitude of the motion over its change in a radian: large where
    orbits graze.
    """
    z = np.ascontiguousarray(points.transpose(0, 2, 1))  # as crossings lie in memory: an orbit's together
    size = np.concatenate([scales.position, scales.momentum])
    result = np.empty(z.shape[1:])
    with np.errstate(all="ignore"):
        speed = system.slopes(z) / scales.rate[:, None]
    function = bound("value", section, system.n, 0)
    flat = z.reshape(len(z), -1), size, speed.reshape(len(z), -1), result.reshape(-1)
    launch(conditioning_of, (function, FD_STEP, *flat), units(result.size), 0.0, 1, None, float(result.size))
    return result.T


def _steps(flow, system: System, z, wanted, max_time, accuracy) -> Steps:
    """Return the first steps, fractions of max_time, for as long as the crossings may take."""
    found = motion(system, z, flow.threads)
    lasting = np.minimum(max_time, SLOWEST * wanted * 2 * np.pi / found.rate)
    return planned(flow, z, found, lasting, accuracy, run=max_time, parts=2)


def _accurate(flow, system: System, z, crossings: Crossings, accuracy, callback) -> SectionMap:
    """Follow the orbits with steps that are halved until their crossings agree."""
    section, wanted, max_time, _ = crossings
    steps = _steps(flow, system, z, wanted, max_time, accuracy)
    rows = 2 * system.n
    orbits = z.shape[1]
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
        names=system.row_names,
        time_error=np.full((orbits, wanted), np.nan).T,
        point_error=np.full((orbits, wanted, rows), np.nan).transpose(2, 1, 0),
        accurate_until=np.zeros(orbits),
    )

    def run(
        orbits: np.ndarray, step: np.ndarray, damping: Damping | None, callback: Callback | None, fine
    ) -> _CrossingRun:
        used = np.full(len(step), np.inf) if flow.adaptive else step
        start = np.ascontiguousarray(z[:, orbits])
        motion = steps.motion
        beside = None if fine is None else ReferenceCrossings(fine.found.times, PARTED / motion.rate[orbits])
        try:
            part, reached = crossed(
                flow.sized(step), system, start, crossings, callback, motion.radius[orbits], damping, beside
            )
        except Interrupted as stopped:
            unfinished = np.full(len(step), int(Status.INTERRUPTED))  # whatever their outcome with these steps
            there = replace(stopped.partial, step=used) if fine is None else fine.found
            put(result, orbits, replace(there, status=unfinished))
            raise
        return _CrossingRun(replace(part, step=used), reached)

    def compare(fine: _CrossingRun, coarse: _CrossingRun, orbits: np.ndarray, weight: np.ndarray | None) -> tuple:
        return _compared(system, section, steps.motion.of(orbits), fine.found, coarse.found, weight, flow.threads)

    def keep(orbits: np.ndarray, fine: _CrossingRun, chosen: np.ndarray, error: np.ndarray) -> None:
        together = chosen.size and chosen[-1] - chosen[0] < chosen.size  # taken without a copy
        which: Any = slice(chosen[0], chosen[-1] + 1) if together else chosen
        _put(result, steps, accuracy, fine, which, orbits[which], error[:, which])

    def drifts(run: _CrossingRun) -> np.ndarray:
        return run.found.status == Status.ENERGY_DRIFT

    # Runs that are compared take several times the memory of their result: some orbits run at a time.
    parts = max(1, min(orbits, 8 * COMPARED * wanted * rows * orbits // PORTION))
    with partial_result_on_interrupt("poincare_map", lambda: result):
        for number, part in enumerate(np.array_split(np.arange(orbits), parts)):
            told = portion(callback, number, parts)
            refine_steps(flow, steps.of(part), accuracy, run, compare, keep, drifts, part, told)
    return result


def _put(result: SectionMap, steps: Steps, accuracy, run: _CrossingRun, which, where: np.ndarray, error) -> None:
    """Put the orbits `which` of a run into the result, at the numbers `where`, with their errors."""
    part = run.found.take(which)
    scales = steps.motion.of(where)
    there = np.isfinite(part.times)
    late = np.where(there, error / scales.rate, np.nan)
    apart = np.where(there, error * np.concatenate([scales.position, scales.momentum])[:, None], np.nan)
    lasting = until(np.where(there, error <= accuracy, True), part.times, run.reached[which])
    put(result, where, replace(part, time_error=late, point_error=apart, accurate_until=lasting))


def _compared(
    system: System, section, motion: MotionScales, fine: SectionMap, coarse: SectionMap, slant, threads: int
) -> tuple:
    """Return distances (crossings, orbits) of states at crossings of two runs, radians up to these, and
    `crossing_conditioning`, where
    these are not given.
    """
    whole = np.empty((3, *fine.times.T.shape)).transpose(0, 2, 1)  # as crossings lie in memory

    def some(at: slice) -> None:
        scales = motion.of(at)
        times = fine.times[:, at]
        points = fine.points[..., at]
        with np.errstate(all="ignore"):
            late = np.abs(times - coarse.times[:, at]) * scales.rate
            apart = scales.between(points.transpose(1, 0, 2), coarse.points[..., at].transpose(1, 0, 2), 1)
            apart = np.maximum(apart, late)
            times_worse = crossing_conditioning(system, section, points, scales) if slant is None else slant[:, at]
            straight = apart / times_worse
        same = np.isfinite(apart) & (apart < SAME)
        # After the last crossing there is nothing to compare; after one that a run lacks nothing is known.
        ended = ~np.isfinite(times)
        known = np.logical_and.accumulate(same | ended, axis=0)
        straight = np.where(known, np.where(ended, 0.0, straight), np.inf)
        whole[..., at] = straight, np.where(ended, 0.0, times * scales.rate), np.where(ended, 1.0, times_worse)

    by_portions(some, len(fine), fine.points[..., :1].size, threads)
    return whole[0], whole[1], whole[2]
