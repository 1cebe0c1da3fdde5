"""Short runs of H(q, p) by an explicit scheme to tolerances: which orbits, which tolerances, what error two runs leave.

Over few turns a symplectic scheme has nothing to keep that an accuracy does not ask for, its iteration and the trials
of its steps cost several times what VERNER9 does, and tolerances need no trial. Errors come from a run with looser
ones; orbits that miss the accuracy are left to the symplectic scheme.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.numbers import Passes
from ..base.status import Status
from ..models.mechanics import system_of
from ..schemes.catalogue import VERNER9
from .accuracy import AGAIN, NOISE, Steps, counted
from .flow import Flow
from .launch import Report
from .motion import Motion
from .trials import SPAN

RADIANS = 1000.0
"""Radians of the motion up to which runs are short: beyond, errors of what is not symplectic outgrow others."""

RATIO, PART = 64.0, 1 / 4
"""How many times looser the other run's tolerances are, and the part of the distance of both that is counted as error:
in the middle it is 1/70, and where the step control of one run was lucky, half of it and more.
"""

GROWTH, LEAST = 0.3, 8.0
"""Accuracy beside the tolerance for an orbit: GROWTH times the 3/2th power of its radians, or LEAST."""

LOWEST = 0.02
"""Error beside the tolerance, as GROWTH is: that of orbits whose steps are no harder than a pendulum's."""

UNSTEADY, BETWEEN = 2.0, 8.0
"""How many times the usual error of its tolerance an orbit's must be for that of a third run to be asked, as errors of
orbits that amplify them fall by chance; how many times looser the third run's tolerance is.
"""

UNSURE = 4.6
"""Order at which errors of orbits that are left by short runs count as falling: by it a quarter of the distance of two
runs is error, as here. In one direction that grows the error of one run is a hundredth of its usual size by chance.
"""

FINEST = 1e-14
"""Tolerance below which rounding is in the way."""

SLOW = 0.5
"""Work behind short runs, of these: for the progress that is reported."""

FALLS, WHOLE, STUCK = 12.0, 8.0, 3.0
"""Errors of the third run beside the other's, times FALLS, are how many times more of them is error where they have not
fallen as they should, up to WHOLE: orbits that pass close to the singular point of a chart, such as a focus of elliptic
coordinates, have all errors from a few steps, in which luck decides more than tolerances do. From STUCK times more
on a further pair is asked, which bears witness.
"""

STOPS = 0.0, 0.62, 0.38
"""Parts of the time between two moments of comparison at which runs stop besides, the fine one, that which it is
compared with, and the third: a step that ends at a moment has a length that no tolerance chose, and one error in all.
"""

PAIRS = 4
"""How many times tolerances are made RATIO times smaller at most, the first time included."""


def tolerances(found: Motion, time: float, accuracy: float) -> np.ndarray:
    """Return the tolerances (orbits,), powers of 4, that should reach an accuracy: NaN where a run is not short."""
    phase = time * found.pace
    with np.errstate(all="ignore"):
        wanted = accuracy / (found.far * np.maximum(GROWTH * phase**1.5, LEAST))
        level = 4.0 ** np.floor(np.log2(wanted) / 2)
    return np.where((phase <= RADIANS) & (level >= FINEST), level, np.nan)


def beyond(steps: Steps, found: Motion, time: float, accuracy: float, had: np.ndarray) -> tuple[Steps, np.ndarray]:
    """Return steps of orbits that short runs have left, and their numbers: of order UNSURE where a run is short, as
    these amplify errors; without those of which there is something (`had`) and whose shortest steps do not reach the
    accuracy: they meet the singular point of a chart, of which equal steps see nothing until all are that short.
    """
    order = np.where(np.isfinite(tolerances(found, time, accuracy)), UNSURE, np.inf)
    reached = steps.local * np.maximum(time * found.rate / SPAN, 1.0) <= accuracy
    orbits = np.flatnonzero(reached | ~had)
    return steps._replace(order=np.minimum(steps.order, order)).of(orbits), orbits


def walled(model: Any, states: np.ndarray) -> np.ndarray:
    """Return which orbits (orbits,) of these states (moments, 2n, orbits) have walls or singular points of a chart, to
    which their distance changes: two runs may leave the same error there by chance.
    """
    positions = states[:, : system_of(model).positions].transpose(1, 0, 2)
    with np.errstate(all="ignore"):
        return np.ptp(np.broadcast_to(model.margin(*positions), states[:, 0].shape), axis=0) > 0


def with_tolerance(flow: Any, tolerance: float) -> Flow:
    """Return the flow by VERNER9 with that tolerance."""
    return replace(flow, scheme=VERNER9, step=np.inf, rtol=tolerance, atol=tolerance)


def left(found: Motion, apart: np.ndarray, times: np.ndarray, tolerance: np.ndarray) -> np.ndarray:
    """Return the errors (moments, orbits) at `times` of runs with these tolerances (orbits,) whose distance from those
    with RATIO times as much is `apart`: a PART of it, what rounding adds, amplified as the tolerance's errors are, and
    what is usual for the tolerance, as both may have taken the same steps.
    """
    phase = times[:, None] * found.pace
    with np.errstate(all="ignore"):
        rounding = 4 * NOISE * found.far * (np.maximum(phase / SPAN, 1.0) ** 1.5 + 8 * apart / (RATIO * tolerance))
        usual = tolerance * _usual(found, phase)
        error = counted(apart, np.full_like(apart, PART)) + rounding + usual
    return np.maximum.accumulate(np.where(np.isfinite(error), error, np.inf), axis=0)


def _usual(found: Motion, phase: np.ndarray) -> np.ndarray:
    """Return the usual errors, beside the tolerance, after so many radians."""
    return found.far * np.maximum(LOWEST * phase**1.5, 1.0)


def tightened(
    found: Motion,
    time: float,
    accuracy: float,
    run: Callable[[np.ndarray, np.ndarray, Report | None, float], Any],
    compare: Callable[[Any, Any, np.ndarray, np.ndarray], np.ndarray],
    keep: Callable[[np.ndarray, Any, np.ndarray, np.ndarray], None],
    walled: Callable[[Any], np.ndarray],
    report: Report | None = None,
) -> np.ndarray:
    """Run the orbits for which that is short in pairs of tolerances; return the index array of those left to others.

    run(orbits, tolerance, report, stop) integrates orbits, stopping at one of STOPS, and returns what has a `status`
    (orbits,); compare(fine, coarse, orbits, tolerance) returns the errors (moments, orbits), inf where the fine run is
    no good; keep(orbits, fine, chosen, error) takes over the results numbered `chosen`, of orbits that are left to
    others too: there may be none better; walled(fine) says which are asked for a third run in any case.
    Cost: 1.6 runs for orbits as expected, one to three more for others, 0.7 by walls and where errors are amplified.
    """
    tolerance = tolerances(found, time, accuracy)
    orbits = np.flatnonzero(np.isfinite(tolerance))
    rest = [np.flatnonzero(np.isnan(tolerance))]
    tolerance = tolerance[orbits]
    passes = Passes(report)
    coarse: Any = run(orbits, RATIO * tolerance, passes.take(0.6, 1 + AGAIN), STOPS[1]) if orbits.size else None
    before: Any = 0.0
    for more in range(PAIRS - 1, -1, -1):
        if not orbits.size:
            break
        fine = run(orbits, tolerance, passes.take(1.0, AGAIN), STOPS[(PAIRS - 1 - more) % 2])
        error = np.fmax(compare(fine, coarse, orbits, tolerance), before / RATIO)  # the coarse run may have been lucky
        size = tolerance * _usual(found.of(orbits), time * found.pace[orbits])
        stuck = np.zeros(orbits.size, bool)
        unsteady = np.flatnonzero(np.isfinite(error[-1]) & ((error[-1] > UNSTEADY * size) | walled(fine)))
        if unsteady.size:
            own, tight = orbits[unsteady], tolerance[unsteady]
            third = run(own, BETWEEN * tight, None, STOPS[2])
            first, second = error[:, unsteady], compare(fine.of(unsteady), third, own, tight)
            with np.errstate(invalid="ignore"):
                part = np.clip(FALLS * second / first, 1.0, WHOLE)
            part = np.where(np.isfinite(part), part, 1.0)
            error[:, unsteady], stuck[unsteady] = np.fmax(first, second) * part, part.max(axis=0) >= STUCK
        worst, sound = error.max(axis=0), (fine.status == Status.OK) & (coarse.status == Status.OK)
        further = (tolerance >= RATIO * FINEST) & (more > 0)
        good = sound & (worst <= accuracy) & ~(stuck & further)
        keep(orbits, fine, np.flatnonzero(sound), error)
        within = accuracy * np.minimum(RATIO**more, tolerance / FINEST)  # what further pairs can mend
        again = sound & ~good & (worst <= within) & further
        rest.append(orbits[~(good | again)])
        orbits, coarse, tolerance, before = orbits[again], fine.of(again), tolerance[again] / RATIO, error[:, again]
    return np.sort(np.concatenate([*rest, orbits]))
