"""The requested accuracy: the steps for it, and the errors of results.

A trial over SPAN radians of the motion chooses the step of each orbit by itself. Then steps are shortened until two
runs agree; their difference gives the error.

The difference of two runs does not show rounding errors: a splitting conserves a nearby energy, and rounding makes that
walk at random. The orbit amplifies the walk, next to a separatrix by many orders of magnitude more than elsewhere. So
the run with twice the step is slowed on purpose. It loses as much energy as some standard deviations of the walk, over
the share of the difference that counts: that share then covers both errors, for any amplification.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import Callback, Passes
from ..core.status import Status
from ..engine.threads import by_portions
from .flow import Damping, Flow
from .scales import MotionScales
from .schemes.catalogue import Collocation, Nystrom
from .time_transformed import TransformedFlow

SPAN = 16.0
"""Radians of each orbit's motion over which trial steps are compared."""

SAMPLES = 4
"""Number of moments of comparison."""

PACED = 4 * SPAN
"""Most radians of the pace over which they are compared: a slow orbit under a fast drive would take any number of
steps, and a chaotic one would forget its start.
"""

MEASURABLE = 3e-12
"""Least error over SPAN that a trial measures above rounding; smaller ones follow from the order."""

FIRST = 0.25
"""The first step of trials, in radians."""

COARSEST = 1.2
"""The longest step of trials, in radians."""

FINEST = 1.5e-3
"""The shortest step of trials, in radians."""

COMPARABLE = 1e-2
"""Errors of trials below which they show the order at which they fall."""

LADDER = 4
"""Numbers of steps are q 2^k with q from LADDER to 2 LADDER. Orbits of similar steps share blocks, and large numbers
have a large power of two as a divisor, after which slowed runs pause.
"""

TRIALS = 8
"""Most steps that are tried for an orbit."""

STALLS = 2
"""Trials end after so many shorter steps whose errors have not fallen in proportion: the errors are rounding then,
which a chaotic orbit amplifies and no step reduces.
"""

# tests/runs/test_accuracy.py and tests/runs/test_driven.py measure the coverage of errors with these constants.

SHARE = 1 / 24
"""Share of the accuracy that the error expected from the trial may take. A larger share saves less in the first runs
than the orbits cost that then miss the accuracy.
"""

SAFETY = 0.75
"""Safety factor for each order of the scheme over the error that follows from two runs: high orders are reached
late.
"""

REACHED = 10.0
"""Highest order at which errors are assumed to fall."""

HALVINGS = 3
"""Most times that steps are shortened after the first pair of runs."""

AGAIN = 0.25
"""Work for orbits whose error may be too large, as a part of a run of all: for the reported progress."""

NOISE = float(np.finfo(float).eps)
"""Rounding error of a kick."""

STEPPED = NOISE / 2
"""Relative rounding error of a step: the same in all steps and in those twice as long, so that no two runs show it."""

TURNED = 12 * NOISE
"""Rounding error of the angle by which a frame turns: that of sums of fractions of a step, the same in all steps."""

EARLY = 100.0
"""Radians up to which orbits are slowed three times as much. Until an orbit has returned to a hyperbolic point a few
times, a short stretch makes all its error, and has a larger share of the rounding errors than of the time.
"""

FEW = 64
"""Most orbits whose runs with both steps are one: Python's part of a run takes longer than some orbits, and one orbit
leaves all threads but one idle. Of more, those that part end early.
"""

WEIGHT = 40
"""Cost of the estimate of one error, with its powers and logarithms, in numbers."""

ROUNDING_CAP = 10.0
"""Rounding errors count up to this multiple of their estimate where two runs that were not slowed are so far apart. The
growth of the slowing on a chaotic orbit may be small by chance, but hardly rounding's own difference at the same time.
"""

DRIVEN = 3.0
"""Factor of the slowing of driven orbits: at moving hyperbolic points their momenta are small, and slow by little."""

ROUGH = 1e-4
"""Distance of two runs, in amplitudes of the motion, above which errors fall less than the order says."""

LOST = 0.1
"""Distance of two runs, in amplitudes of the motion, above which the runs are unrelated."""

SLIGHTLY = 1.4
"""Factor by which steps are shortened where errors are a little too large: two rungs of the ladder."""

MARGIN = 2.0
"""Safety factor on the error that is expected, by the order, of steps only SLIGHTLY shorter."""

LEAST = 4.0
"""How many times the error of its trial an orbit has at least, up to the distance of two runs: below a usual one, which
is 5 times that, as steps so long that the order is not reached yet make both runs alike by chance.
"""

AMPLIFIED_TRIAL_SHARE = 0.2
"""Part of the trial's error, amplified as the slowing was, that an orbit has at least: in one direction that grows the
coarse run's error is that of the fine one, or none, by chance. Slowing goes one way and is amplified more than errors.
"""

WEAR_RADIANS = 6.0
"""Radians of the motion in which the momenta of the run with twice the step are slowed once, or at each step."""


def round_down_to_grid(step: np.ndarray, time: Any, parts: int = 1) -> np.ndarray:
    """Return steps time/(parts*N), at most as long as the given ones, with N from 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14,
    16, 20, ...
    """
    least = np.maximum(time / (parts * step) * (1 - 1e-12), 1.0)
    unit = np.maximum(2.0 ** (np.floor(np.log2(least))) / LADDER, 1.0)
    return time / (parts * unit * np.ceil(least / unit))


class Chosen(NamedTuple):
    """Steps for orbits: step (orbits,), the error of each over SPAN radians, and the order at which errors fall
    there.
    """

    step: np.ndarray
    error: np.ndarray
    order: np.ndarray


def chosen_steps(flow: Flow, z: np.ndarray, found: MotionScales, error: np.ndarray) -> Chosen:
    """Return for each orbit (orbits,) the step whose error over SPAN radians of its motion is `error`.

    The error of a step is the distance from the states with half of it, in units of the motion's amplitudes
    (`MotionScales`). Steps are tried until one is near, over a shorter time where the pace is much faster; errors
    below MEASURABLE follow from the order. If no step down to FINEST radians reaches it, the step is FINEST; if
    shorter ones no longer help, it is the one before them. The order is the scheme's, or a lower one that two trials
    show: steps may be too coarse for the former, or forces not smooth. Every orbit is treated by itself. Cost: some
    500 steps an orbit.
    """
    orbits = z.shape[1]
    rate = found.rate
    pace = found.pace
    first = 2 * FIRST if isinstance(flow.scheme, Nystrom) else FIRST  # of order 12, whose steps are longer
    step = first / pace
    least = np.full(orbits, np.nan)
    order = np.full(orbits, float(flow.scheme.order))
    coarse, most = np.full((2, orbits), np.nan)
    at = step.copy()
    floor = np.full(orbits, np.inf)
    stalls = np.zeros(orbits, np.int64)
    share = np.minimum(1.0, PACED / SPAN * rate / pace)
    error = error * share
    wanted = np.maximum(error, MEASURABLE)
    todo = np.arange(orbits)
    for _ in range(TRIALS):
        apart = halving(flow, z[:, todo], step[todo], share[todo] * SPAN / rate[todo], found.of(todo))
        least[todo] = apart
        with np.errstate(all="ignore"):
            fell = ~(apart * at[todo] >= floor[todo] * step[todo])
        stalls[todo] += ~fell & (step[todo] < at[todo]) & (apart < COMPARABLE)
        at[todo], floor[todo] = np.where(fell, (step[todo], apart), (at[todo], floor[todo]))
        with np.errstate(all="ignore"):
            seen = np.log(most[todo] / apart) / np.log(coarse[todo] / step[todo])
        told = coarse[todo] > np.sqrt(2) * step[todo]
        order[todo] = np.where(told & (seen < flow.scheme.order), np.maximum(seen, 1.0), flow.scheme.order)
        wider = (apart < COMPARABLE) & ~(step[todo] < coarse[todo])
        coarse[todo], most[todo] = np.where(wider, (step[todo], apart), (coarse[todo], most[todo]))
        with np.errstate(all="ignore"):
            change = _change(wanted[todo] / np.maximum(apart, 1e-14), order[todo], flow.scheme.order)
        change = np.where(np.isfinite(apart), change, 0.0)
        following = np.clip(step[todo] * np.clip(change, 0.25, 3.0), FINEST / pace[todo], COARSEST / pace[todo])
        near = (change >= 0.6) & (change <= 1.6) | (following == step[todo]) | (stalls[todo] == STALLS)
        step[todo] = np.where(near, step[todo], following)
        todo = todo[~near]
        if not todo.size:
            break
    stalled = stalls == STALLS
    step, least = np.where(stalled, (at, floor), (step, least))
    known = np.maximum(np.where(np.isfinite(least), least, 1.0), 1e-14)
    change = np.where(stalled, 1.0, np.clip(_change(error / known, order, flow.scheme.order), 0.1, 1.6))
    last = np.clip(step * change, FINEST / pace, COARSEST / pace)
    return Chosen(last, known * (last / step) ** order / share, order)


def _change(gain: np.ndarray, order: np.ndarray, most: int) -> np.ndarray:
    """Return the factor of the step whose error is `gain` times as large: by the order seen if it becomes shorter, by
    the scheme's if it becomes longer.
    """
    return gain ** (1 / np.where(gain > 1, most, order))


def sampled(flow: Flow, z: np.ndarray, step: np.ndarray, time: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return states (SAMPLES, rows, orbits) with each orbit's step at equal intervals of its time, NaN where none."""
    tried = replace(flow, step=step)
    return tried.sampled(tried.ensemble(z.copy(), radius=radius), SAMPLES, time=time).transpose(1, 2, 0)


def halving(flow: Flow, z: np.ndarray, step: np.ndarray, time: np.ndarray, found: MotionScales) -> np.ndarray:
    """Return the largest distance between states with each orbit's step and with half of it, at SAMPLES moments; inf
    where none.
    """
    orbits = z.shape[1]
    states = sampled(flow, np.tile(z, 2), np.concatenate([step, step / 2]), np.tile(time, 2), np.tile(found.radius, 2))
    apart = found.between(states[..., :orbits], states[..., orbits:], flow.threads)
    known = np.isfinite(apart)
    return np.where(known[0], np.where(known, apart, 0.0).max(axis=0), np.inf)


class Steps(NamedTuple):
    """Steps that should reach an accuracy, for each orbit: step (orbits,), its expected local error over SPAN radians
    (NaN where unknown), the order at which that falls, the scales; ratio (orbits,): the step of the run for comparison
    over this one; a multiple of `parts` steps is the whole `run`.
    """

    step: np.ndarray
    local: np.ndarray
    order: np.ndarray
    motion: MotionScales
    ratio: np.ndarray
    run: float
    parts: int

    def of(self, orbits: Any) -> Steps:
        """Return the steps of some of the orbits."""
        each = (self.step[orbits], self.local[orbits], self.order[orbits], self.motion.of(orbits), self.ratio[orbits])
        return Steps(*each, self.run, self.parts)

    def shortened(self, factor: np.ndarray) -> Steps:
        """Return steps shorter by this factor, or the next on the ladder, for comparison with these."""
        step = np.where(factor == 2.0, self.step / 2, round_down_to_grid(self.step / factor, self.run, self.parts))
        ratio = self.step / step
        return self._replace(step=step, local=self.local / ratio**self.order, ratio=ratio)


def planned(
    flow: Flow | TransformedFlow,
    z: np.ndarray,
    found: MotionScales,
    time: np.ndarray | float,
    accuracy: float,
    *,
    run: float,
    parts: int,
) -> Steps:
    """Return steps whose errors stay below a share of the accuracy, if they grow in proportion to `time` as on regular
    orbits. A multiple of `parts` steps is the whole `run`.

    Where the caller chose one step, or tolerances, for all orbits, it is that step (1 for tolerances).
    """
    twice = np.full(z.shape[1], 2.0)
    if flow.alike:
        one = 1.0 if flow.adaptive else float(np.max(flow.step))
        unknown = np.full(z.shape[1], np.nan)
        order = np.full(z.shape[1], float(flow.scheme.order))
        return Steps(np.full(z.shape[1], one), unknown, order, motion=found, ratio=twice, run=run, parts=parts)
    spans = np.maximum(np.broadcast_to(time, z.shape[1]) * found.rate / SPAN, 1.0)
    step, local, order = chosen_steps(flow, z, found, SHARE * accuracy / spans)  # type: ignore[arg-type]
    if isinstance(flow.scheme, Collocation):  # whose iteration must converge with twice the step too
        states = sampled(flow, z, 2 * step, np.maximum(SPAN / found.rate, 2 * step), found.radius)
        step = np.where(np.isfinite(states).all(axis=(0, 1)), step, step / 2)
    used = round_down_to_grid(step, run, parts)
    return Steps(used, local * (used / step) ** order, order, motion=found, ratio=twice, run=run, parts=parts)


def share_of(flow: Flow | TransformedFlow, plan: Steps) -> np.ndarray:
    """Return the ratio (orbits,) of the error of a run to its distance from the run with a longer step."""
    # Tolerances bound errors of single steps: with smaller ones the errors at the end fall, but by no known power.
    share = SAFETY * flow.scheme.order / (plan.ratio ** np.minimum(plan.order, REACHED) - 1)
    return np.ones_like(share) if flow.adaptive else np.minimum(share, 1.0)


def noise_of(flow: Flow | TransformedFlow, plan: Steps) -> np.ndarray:
    """Return the rounding errors (orbits,) of the kicks over SPAN radians, without amplification."""
    kicks = SPAN / np.maximum(plan.step * plan.motion.rate, 1e-300) * max(flow.scheme.stages, 1)
    noise = NOISE * plan.motion.far * (2.0 * np.ones_like(kicks) if flow.precise else np.sqrt(kicks))
    return DRIVEN * noise if flow.system.driven else noise


def damping_for(flow: Flow | TransformedFlow, plan: Steps) -> Damping | None:
    """Return the slowing of the orbits that makes `share_of` the distance as large as rounding errors; None where the
    caller chose steps or tolerances for all orbits.
    """
    if flow.alike:
        return None
    rate = plan.motion.rate
    share = np.minimum(noise_of(flow, plan) / share_of(flow, plan), LOST) * np.sqrt(rate / SPAN)
    return Damping(share, EARLY / rate, WEAR_RADIANS / rate)


def estimated(
    flow: Flow | TransformedFlow,
    plan: Steps,
    apart: np.ndarray,
    phase: np.ndarray,
    rounding_distance: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the errors (moments, orbits) of states at a distance `apart` from those with twice the step, and
    rounding's share.

    phase (moments, orbits): radians of the motion up to each moment. SAFETY order/(2^order - 1) of the distance is the
    scheme's error, and covers rounding's if the run with twice the step was slowed as by `damping_for`.
    rounding_distance (moments, orbits): the distance that this slowing alone makes, where it is known and no part of
    `apart`; `apart` then shows rounding itself. Distances beyond LOST count whole. Errors never fall with time. Where
    orbits cannot be slowed, as with adaptive schemes, they count as regular: rounding errors grow like phase^(3/2), the
    scheme's like phase. No error is below that of a single step: within the first step both runs may be equal.
    """
    error = np.empty_like(apart)
    rounding = np.empty_like(apart)

    def some(at: slice) -> None:
        known = None if rounding_distance is None else rounding_distance[:, at]
        error[:, at], rounding[:, at] = _estimated(flow, plan.of(at), apart[:, at], phase[:, at], known)

    by_portions(some, apart.shape[1], WEIGHT * apart.shape[0], flow.threads)
    return error, rounding


def _estimated(flow, plan: Steps, apart, phase, rounding_distance) -> tuple[np.ndarray, np.ndarray]:
    """Return the result of `estimated`, by one thread."""
    order = plan.order
    spans = np.maximum(phase / SPAN, 1.0)
    # After few steps errors need not fall by the order yet, as where they lead through a core.
    part = np.broadcast_to(share_of(flow, plan), phase.shape).copy()
    early = phase < SPAN
    part[early] **= phase[early] / SPAN
    noise = noise_of(flow, plan) * np.sqrt(spans)
    if flow.system.frame:
        angle = abs(flow.model.angular_velocity()) * phase / np.maximum(plan.motion.rate, 1e-300)
        noise = noise + TURNED * plan.motion.far * angle
    local = np.where(np.isnan(plan.local), apart / (spans * 2.0**order), plan.local)
    with np.errstate(all="ignore"):
        if flow.alike:
            rounding = apart * np.minimum(noise / np.maximum(local * 2.0**order, 1e-300), 2.0) + noise
        else:
            rounding = noise if rounding_distance is None else noise + effective_distance(rounding_distance, part)
        error = effective_distance(apart, part) + rounding
        error += local * np.minimum(plan.step * plan.motion.rate / SPAN, 1.0)
        if not flow.alike:
            # The trial's error is a lower bound: by chance the difference of two runs is too small for some orbits.
            error = np.maximum(error, np.clip(apart, local * spans, LEAST * local * spans))
        if rounding_distance is not None:
            grown = (
                AMPLIFIED_TRIAL_SHARE
                * local
                * spans
                * effective_distance(rounding_distance, part)
                / np.maximum(noise, 1e-300)
            )
            error = np.maximum(error, np.minimum(grown, apart / part))
            witness = np.minimum(apart, ROUNDING_CAP * rounding)
            error = error + witness
            rounding = rounding + witness
    error, rounding = (np.where(np.isfinite(entry), entry + STEPPED * phase, np.inf) for entry in (error, rounding))
    return np.maximum.accumulate(error, axis=0), np.maximum.accumulate(rounding, axis=0)


def effective_distance(apart: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Return distances times `part` up to ROUGH, whole distances from LOST on, and a power law between."""
    result = part * apart
    rough = apart > ROUGH
    if rough.any():
        far = apart[rough]
        power = np.minimum(np.log(far / ROUGH) / np.log(LOST / ROUGH), 1.0)
        result[rough] = part[rough] ** (1.0 - power) * far
    return result


def refine_steps(
    flow: Flow | TransformedFlow,
    plan: Steps,
    accuracy: float,
    run: Callable[[np.ndarray, np.ndarray, Damping | None, Callback | None, Any], Any],
    compare: Callable[[Any, Any, np.ndarray, np.ndarray | None], tuple[np.ndarray, np.ndarray, np.ndarray]],
    keep: Callable[[np.ndarray, Any, np.ndarray, np.ndarray], None],
    drifts: Callable[[Any], np.ndarray],
    orbits: np.ndarray | None = None,
    callback: Callback | None = None,
) -> None:
    """Run orbits, of these numbers or all, with their steps and with twice these; then run those whose errors are too
    large with shorter steps.

    run(orbits, step, wear, callback, fine) integrates the orbits of that index array, slowed where there is a wear,
    some perhaps twice, and returns a run with a `status` (orbits,); the last of two counts if it stops; a run for
    comparison with the run `fine` may end where the two become unrelated. compare(fine, coarse, orbits, weight) returns
    distances of states and phases (moments, orbits), and the weight (moments or 1, orbits) of the error of a state,
    which it takes over where it is given; keep(orbits, fine, chosen, error) takes over the results numbered `chosen` of
    a run, in any thread; drifts(fine) tells which orbits (orbits,) lose their energy. Other orbits keep an error that
    no step cures, as of chaotic ones, or that is mostly rounding's. Cost: one and a half runs for most orbits; half a
    run more for driven ones and those whose error is too large: it separates the scheme's error from rounding's.
    """
    orbits = np.arange(len(plan.step)) if orbits is None else orbits
    with Passes(callback) as passes:
        wear = damping_for(flow, plan)
        work = _work(plan.step)
        more = 0.0 if flow.adaptive else work * (0.5 if flow.system.driven else AGAIN)
        if wear is not None and orbits.size <= FEW and max(orbits.size, flow.threads) > 1:
            fine, coarse = _both(run, orbits, plan.step, wear, passes.take(1.5 * work, more))
        else:
            fine = run(orbits, plan.step, None, passes.take(work, work / 2 + more), None)
            coarse = run(orbits, 2 * plan.step, wear, passes.take(work / 2, more), fine)
        apart, phase, weight = compare(fine, coarse, orbits, None)
        error, rounding = (weight * entry for entry in estimated(flow, plan, apart, phase))
        # One distance of chaotic and driven orbits is too small by chance too often: a run that is not slowed gives
        # another.
        again = ((error.max(axis=0) > accuracy) | flow.system.driven | drifts(fine)) & (not flow.adaptive)
        _kept(flow, keep, orbits, fine, np.flatnonzero(~again), error)
        if not again.any():
            return
        orbits = orbits[again]
        plan = plan.of(again)
        coarse = coarse.of(again)
        fine = fine.of(again)
        rounding_distance = None
        weight = weight[:, again]
        before = np.zeros((1, 1))
        for round_ in range(HALVINGS + 1):
            work = _work(plan.step)
            if round_ == 0 and wear is not None:
                plain = run(orbits, 2 * plan.step, None, passes.take(work / 2, work / 2), fine)
                rounding_distance = compare(plain, coarse, orbits, weight)[0]
                coarse = plain
            elif round_ > 0:
                coarse = fine
                fine = run(orbits, plan.step, None, passes.take(work, work / 2), None)
                if rounding_distance is not None:
                    # The kicks are `ratio` times as many.
                    rounding_distance = np.sqrt(plan.ratio) * rounding_distance
            apart, phase, weight = compare(fine, coarse, orbits, weight)
            if rounding_distance is not None:
                rounding_distance = np.where(np.isfinite(rounding_distance), rounding_distance, apart)
            error, rounding = (weight * entry for entry in estimated(flow, plan, apart, phase, rounding_distance))
            # The run that this one is compared with may have been lucky: what it had falls by the order at most.
            error = np.fmax(error, before / plan.ratio ** np.minimum(plan.order, REACHED))
            factor = shortening(flow, plan, error, rounding, accuracy)
            # A doubled step may have been too long for the iteration of a collocation.
            failed = (coarse.status == Status.NOT_CONVERGED) | (fine.status == Status.NOT_CONVERGED)
            factor = np.where(drifts(fine) | failed, 2.0, factor)
            again = (factor > 1) & (round_ < HALVINGS)
            _kept(flow, keep, orbits, fine, np.flatnonzero(~again), error)
            if not again.any():
                return
            orbits = orbits[again]
            plan = plan.of(again).shortened(factor[again])
            fine = fine.of(again)
            # Nothing is known of a run that failed.
            weight = weight[:, again]
            before = np.where(np.isfinite(error[:, again]), error[:, again], 0.0)
            if rounding_distance is not None:
                rounding_distance = rounding_distance[..., again]


def _both(run, orbits: np.ndarray, step: np.ndarray, wear: Damping, callback: Callback | None) -> tuple[Any, Any]:
    """Return runs of the orbits with these steps, and slowed ones with twice these, made as one run."""
    count = orbits.size
    slowed = Damping(np.append(wear.share, np.zeros(orbits.size)), *(np.tile(x, 2) for x in wear[1:]))
    both = run(np.tile(orbits, 2), np.append(2 * step, step), slowed, callback, None)
    return both.of(slice(count, None)), both.of(slice(count))


def _kept(flow, keep, orbits: np.ndarray, fine: Any, chosen: np.ndarray, error: np.ndarray) -> None:
    """Call keep as `refine_steps` says, for some of the chosen orbits in each thread."""
    some = lambda at: keep(orbits, fine, chosen[at], error)  # noqa: E731
    by_portions(some, chosen.size, WEIGHT * len(error), flow.threads)


def _work(step: np.ndarray) -> float:
    """Return the work of a run: its number of steps, or of orbits where these choose their own."""
    return float(np.sum(1.0 / step)) if np.isfinite(step).all() else float(step.size)


def shortening(
    flow: Flow | TransformedFlow, plan: Steps, error: np.ndarray, rounding: np.ndarray, accuracy: float
) -> np.ndarray:
    """Return the factor (orbits,) by which to shorten steps whose errors (moments, orbits), with rounding's part, are
    too large: SLIGHTLY or 2, by the order at which the rest falls; 1 where shorter steps are needless or do not help.
    """
    with np.errstate(all="ignore"):
        worst = error.max(axis=0)
        floor = np.sqrt(2.0) * rounding.max(axis=0)
        curable = (worst > accuracy) & (worst <= accuracy * 2.0**flow.scheme.order)
        goal = np.maximum(accuracy - floor, floor / 4)
        slight = MARGIN * (worst - rounding.max(axis=0)) <= goal * SLIGHTLY**plan.order
    curable &= (floor < accuracy) | (floor < 0.7 * worst)
    shorter = np.where(slight & (not flow.alike), SLIGHTLY, 2.0)
    return np.where(curable, shorter, 1.0)


def until(holds: np.ndarray, times: np.ndarray, end: np.ndarray | float) -> np.ndarray:
    """Return the last of `times` (moments, orbits) up to which `holds` (moments, orbits) is True at all moments: 0
    where it never is, the `end` where it always is.
    """
    always = holds.all(axis=0)
    first = np.where(always, 0, (~holds).argmax(axis=0))
    before = np.take_along_axis(np.pad(times, ((1, 0), (0, 0))), first[None], axis=0)[0]
    return np.where(always, end, before)


def is_dominated(error: np.ndarray, late: np.ndarray, least: np.ndarray, latest: np.ndarray) -> np.ndarray:
    """Return a mask (orbits,) of results that are no better than others: whose errors are larger than the `least`, or
    from LOST on, where no error means more than another, stay below the accuracy for less time than the `latest`.
    """
    error = np.minimum(error, LOST)
    least = np.minimum(least, LOST)
    return (error > least) | (error == least) & (late < latest)
