"""Short runs of H(q, p) by an explicit scheme with tolerances: choice of orbits and tolerances, errors from two runs.

Over few turns a symplectic scheme has no advantage. Its iteration and the trials of its steps cost several times as
much as VERNER9, whose tolerances need no trial. Errors follow from a run with looser tolerances; orbits that miss the
accuracy are left to the symplectic scheme. Long runs follow it where equal steps would be very short, or fail.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.numbers import Callback, Passes
from ..core.status import Status
from ..engine.values import at_points
from ..systems.models.mechanics import System
from .accuracy import AGAIN, LOST, NOISE, SPAN, Steps, effective_distance
from .flow import Flow
from .scales import MotionScales
from .schemes.catalogue import VERNER9

# tests/runs/test_nonseparable.py measures the coverage of errors with these constants, bench/nonseparable.py the cost.

RADIANS = 1000.0
"""Radians of the motion up to which runs are short: beyond, errors of a scheme that is not symplectic grow faster."""

UNEVEN = 2.0**-6
"""Equal steps, in radians, below which an orbit is run with tolerances however long its time: a small part of its way,
as next to a centre or on the axis of a chart, asks for steps so short, and all of it would get them.
"""

RATIO = 64.0
"""Ratio of the looser run's tolerances to the tighter ones."""

PART = 1 / 4
"""Part of the distance of both runs that counts as error: typically it is 1/70, but half or more where the error of one
run is small by chance.
"""

GROWTH = 0.3
"""Accuracy over tolerance for an orbit, over the 3/2th power of its radians."""

LEAST = 8.0
"""Least accuracy over tolerance for an orbit."""

LOWEST = 0.02
"""Error over tolerance, like GROWTH, for orbits whose steps are no harder than a pendulum's."""

UNSTEADY = 2.0
"""Multiple of the usual error of its tolerance above which an orbit gets a third run, as amplified errors may be small
by chance.
"""

BETWEEN = 8.0
"""Ratio of the third run's tolerance to the tight one."""

UNSURE = 4.6
"""Order at which errors are assumed to fall for orbits that short runs have left: by it a quarter of the distance of
two runs is error, as here. Along one growing direction an error is a hundredth of its usual size by chance.
"""

FINEST = 4.0**-23
"""Tolerance below which rounding errors dominate."""

CLOSE = 4.0
"""Multiple of a wanted tolerance at which FINEST is tried instead: most orbits have smaller errors than GROWTH says,
and equal steps for such an accuracy cost three times as much.
"""

AMPLIFIED = 16.0
"""Multiple of the usual error of FINEST up to which orbits that short runs have left are as others."""

SLOW = 0.5
"""Work after short runs, relative to theirs: for the reported progress."""

FALLS = 12.0
"""Factor of the ratio of the third run's errors to the other's. The product multiplies errors that have not fallen as
they should. Orbits near the singular point of a chart, such as a focus of elliptic coordinates, get all errors in a few
steps, by chance more than by tolerance.
"""

WHOLE = 8.0
"""Largest factor of errors that have not fallen as they should."""

STUCK = 3.0
"""Such a factor from which on a further pair of runs checks the errors."""

STOPS = 0.0, 0.62, 0.38
"""Fractions of the time between two moments of comparison at which runs also stop: of the fine run, the coarse one and
the third. A step that ends at a moment has a length that no tolerance chose, hence the same error in all runs.
"""

PAIRS = 4
"""Most pairs of runs, the first included; each has tolerances RATIO times smaller than the one before."""


def tolerances(found: MotionScales, time: float, accuracy: float, most: Any = RADIANS) -> np.ndarray:
    """Return the tolerances (orbits,), powers of 4, that should reach an accuracy: NaN where a run is not short, which
    it is up to `most` radians, for all or each.
    """
    phase = time * found.pace
    with np.errstate(all="ignore"):
        wanted = accuracy / (found.far * np.maximum(GROWTH * phase**1.5, LEAST))
        level = 4.0 ** np.floor(np.log2(wanted) / 2)
    return np.where((phase <= most) & (level >= FINEST / CLOSE), np.fmax(level, FINEST), np.nan)


def max_radians(found: MotionScales, time: float, chosen: np.ndarray) -> np.ndarray:
    """Return the radians (orbits,) up to which chosen orbits are run with tolerances: none where short runs were."""
    return np.where(chosen & (time * found.pace > RADIANS), np.inf, 0.0)


def last(found: MotionScales, time: float, accuracy: float, error: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """Return the tolerances (orbits,) of runs after equal steps, NaN where none, for orbits whose first coordinates
    have these errors, and these energy errors.

    Equal steps miss the accuracy, and tell nothing of an orbit, where it passes close to the axis of a chart: FINEST
    may do better, unless errors are rounding's or short runs were of no use. Long runs are left to it only if they
    lose energy, as on such a pass, but not by chaos.
    """
    phase = time * found.pace
    level = tolerances(found, time, accuracy, np.inf)
    error = error / np.maximum(found.position[0], 1e-300)
    short = phase <= RADIANS
    missed = error > np.maximum(accuracy, FINEST * _usual(found, phase))
    hope = np.where(short, np.isnan(level) | (error <= LOST) & (level > FINEST), energy > accuracy)
    return np.where(np.isinf(error) & ~short & np.isfinite(level), level, np.where(missed & hope, FINEST, np.nan))


def steps_for_remaining(
    steps: Steps, found: MotionScales, time: float, accuracy: float, error: np.ndarray, rest: np.ndarray
) -> tuple[Steps, np.ndarray]:
    """Return steps of the orbits that short runs have left, and their numbers, some of `rest`; the order is UNSURE
    where a run is short, if its error (orbits,) is AMPLIFIED. Orbits that have a result, hence a finite error, are left
    out if their shortest steps do not reach the accuracy: they meet the singular point of a chart, which only equal
    steps as short would resolve.
    """
    steady = error <= AMPLIFIED * FINEST * _usual(found, time * found.pace)
    order = np.where(np.isfinite(tolerances(found, time, accuracy)) & ~steady, UNSURE, np.inf)
    reached = steps.local * np.maximum(time * found.rate / SPAN, 1.0) <= accuracy
    orbits = rest[(reached | np.isinf(error))[rest]]
    return steps._replace(order=np.minimum(steps.order, order)).of(orbits), orbits


def walled(system: System, states: np.ndarray) -> np.ndarray:
    """Return a mask (orbits,) of those whose states (moments, 2n, orbits) change their distance from walls or singular
    points of a chart: two runs may have the same error there by chance.
    """
    positions = states[:, : system.positions].transpose(1, 0, 2)
    with np.errstate(all="ignore"):
        return np.ptp(np.broadcast_to(at_points(system.model, "margin", *positions), states[:, 0].shape), axis=0) > 0


def with_tolerance(flow: Any, tolerance: float) -> Flow:
    """Return the flow by VERNER9 with that tolerance."""
    return replace(flow, scheme=VERNER9, step=np.inf, rtol=tolerance, atol=tolerance)


def tolerance_errors(
    found: MotionScales, apart: np.ndarray, times: np.ndarray, tolerance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the errors (moments, orbits) at `times` of runs with these tolerances (orbits,) at a distance `apart` from
    those with tolerances RATIO times as large: a PART of it, rounding errors, amplified as the tolerance's are, and the
    usual error of the tolerance, as both may have taken the same steps; and the latter.
    """
    phase = times[:, None] * found.pace
    with np.errstate(all="ignore"):
        rounding = 4 * NOISE * found.far * (np.maximum(phase / SPAN, 1.0) ** 1.5 + 8 * apart / (RATIO * tolerance))
        usual = tolerance * _usual(found, phase)
        error = effective_distance(apart, np.full_like(apart, PART)) + rounding + usual
    return np.maximum.accumulate(np.where(np.isfinite(error), error, np.inf), axis=0), usual


def _usual(found: MotionScales, phase: np.ndarray) -> np.ndarray:
    """Return the usual errors, over the tolerance, at these phases."""
    return found.far * np.maximum(LOWEST * phase**1.5, 1.0)


def refine_tolerances(
    tolerance: np.ndarray,
    accuracy: float,
    run: Callable[[np.ndarray, np.ndarray, Callback | None, float], Any],
    compare: Callable[[Any, Any, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]],
    keep: Callable[[np.ndarray, Any, np.ndarray, np.ndarray], None],
    walled: Callable[[Any], np.ndarray],
    callback: Callback | None = None,
) -> np.ndarray:
    """Run the orbits that have a tolerance (orbits,), which is not NaN, with pairs of tolerances; return the index
    array of those left over.

    run(orbits, tolerance, callback, stop) integrates orbits, stopping at one of STOPS, and returns a run with a
    `status` (orbits,); compare(fine, coarse, orbits, tolerance) returns the errors (moments, orbits), inf where the
    fine run is no good, and the usual ones of the tolerance; keep(orbits, fine, chosen, error) takes over the results
    numbered `chosen`, also of orbits left over: there may be no better ones; walled(fine) tells which orbits get a
    third run in any case. Cost: 1.6 runs for most orbits, one to three more for others, 0.7 near walls and where errors
    are amplified.
    """
    orbits = np.flatnonzero(np.isfinite(tolerance))
    rest = [np.flatnonzero(np.isnan(tolerance))]
    tolerance = tolerance[orbits]
    passes = Passes(callback)
    coarse: Any = run(orbits, RATIO * tolerance, passes.take(0.6, 1 + AGAIN), STOPS[1]) if orbits.size else None
    before: Any = 0.0
    for more in range(PAIRS - 1, -1, -1):
        if not orbits.size:
            break
        fine = run(orbits, tolerance, passes.take(1.0, AGAIN), STOPS[(PAIRS - 1 - more) % 2])
        error, usual = compare(fine, coarse, orbits, tolerance)
        error = np.fmax(error, before / RATIO)  # the coarse run may have been lucky
        stuck = np.zeros(orbits.size, bool)
        unsteady = np.flatnonzero(np.isfinite(error[-1]) & ((error[-1] > UNSTEADY * usual[-1]) | walled(fine)))
        if unsteady.size:
            own = orbits[unsteady]
            tight = tolerance[unsteady]
            third = run(own, BETWEEN * tight, None, STOPS[2])
            first = error[:, unsteady]
            second, least = compare(fine.of(unsteady), third, own, tight)
            with np.errstate(invalid="ignore"):  # usual errors, in both, are no sign that errors do not fall
                part = np.clip(FALLS * (second - least) / np.fmax(first - least, least), 1.0, WHOLE)
            part = np.where(np.isfinite(part), part, 1.0)
            error[:, unsteady] = np.fmax(first, second) * part
            stuck[unsteady] = part.max(axis=0) >= STUCK
        worst = error.max(axis=0)
        sound = (fine.status == Status.OK) & (coarse.status == Status.OK)
        further = (tolerance >= RATIO * FINEST) & (more > 0)
        good = sound & (worst <= accuracy) & ~(stuck & further)
        keep(orbits, fine, np.flatnonzero(sound), error)
        within = accuracy * np.minimum(RATIO**more, tolerance / FINEST)  # errors that further pairs can mend
        again = sound & ~good & (worst <= within) & further
        rest.append(orbits[~(good | again)])
        orbits = orbits[again]
        coarse = fine.of(again)
        tolerance = tolerance[again] / RATIO
        before = error[:, again]
    return np.sort(np.concatenate([*rest, orbits]))
