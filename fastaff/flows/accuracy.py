"""The accuracy that is asked for: steps halved until two runs agree, and what they leave as error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .flow import Flow
from .motion import Motion
from .time_transformed import TransformedFlow
from .trials import SPAN, chosen_steps, on_ladder

SHARE = 0.25
"""Share of the accuracy that the error expected from the trial may take."""

SAFETY = 0.5
"""Factor, for each order of the scheme, over the error that the difference of two runs leaves: high orders are reached
late.
"""

HALVINGS = 3
"""How often steps are halved at most beyond the first pair of runs."""

NOISE = float(np.finfo(float).eps)
"""Rounding error of a kick."""


class Steps(NamedTuple):
    """Steps that should reach an accuracy, for each orbit: step (orbits,), the local error expected of it over SPAN
    radians (NaN where not known), the scales.
    """

    step: np.ndarray
    local: np.ndarray
    motion: Motion


def planned(
    flow: Flow | TransformedFlow,
    z: np.ndarray,
    found: Motion,
    time: np.ndarray | float,
    accuracy: float,
    *,
    run: float,
    parts: int,
) -> Steps:
    """Return steps whose errors, growing in proportion to `time` as on regular orbits, stay below a share of the
    accuracy, and of which a multiple of `parts` is the whole `run`.

    Where others chose one step, or tolerances, for all orbits, it is that step (1 for tolerances).
    """
    if flow.alike:
        one = 1.0 if flow.adaptive else float(np.max(flow.step))
        return Steps(np.full(z.shape[1], one), np.full(z.shape[1], np.nan), found)
    spans = np.maximum(np.broadcast_to(time, z.shape[1]) * found.rate / SPAN, 1.0)
    step, local = chosen_steps(flow, z, found, SHARE * accuracy / spans)  # type: ignore[arg-type]
    return Steps(on_ladder(step, run, parts), local, found)


def estimated(
    flow: Flow | TransformedFlow, plan: Steps, apart: np.ndarray, phase: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the errors (moments, orbits) of states whose distance from those with twice the step is `apart`, and
    rounding's share.

    phase (moments, orbits): radians of the motion up to each moment. Two parts: SAFETY order/(2^order - 1) of the
    distance is the scheme's; rounding errors grow along an orbit as the scheme's do, but like phase^(3/2) where these
    grow like phase, so their share of the distance follows from the local errors of both. Errors never fall with time.
    Where the local errors are not known, as of adaptive schemes, orbits count as regular: rounding errors grow like
    phase^(3/2). No error is below that of a single step: within the first step both runs may do the same.
    """
    order = flow.scheme.order
    spans = np.maximum(phase / SPAN, 1.0)
    kicks = SPAN / np.maximum(plan.step * plan.motion.rate, 1e-300) * max(flow.scheme.stages, 1)
    noise = NOISE * (2.0 * np.ones_like(kicks) if flow.precise else np.sqrt(kicks))
    local = np.where(np.isnan(plan.local), apart / (spans * 2.0**order), plan.local)
    share = noise * np.sqrt(spans) / np.maximum(local * 2.0**order, 1e-300)
    with np.errstate(all="ignore"):
        rounding = apart * np.minimum(share, 2.0) + noise * np.sqrt(spans)
        # Tolerances hold errors of single steps: with smaller ones the errors at the end fall, but by no known power.
        error = (1.0 if flow.adaptive else SAFETY * order / (2.0**order - 1)) * apart + rounding
        error += local * np.minimum(plan.step * plan.motion.rate / SPAN, 1.0)
    error, rounding = (np.where(np.isfinite(entry), entry, np.inf) for entry in (error, rounding))
    return np.maximum.accumulate(error, axis=0), rounding


def halved(
    flow: Flow | TransformedFlow,
    plan: Steps,
    accuracy: float,
    run: Callable[[np.ndarray, np.ndarray], Any],
    compare: Callable[[Any, Any, np.ndarray], tuple[np.ndarray, np.ndarray, Any]],
    keep: Callable[[np.ndarray, Any, np.ndarray, np.ndarray], None],
) -> None:
    """Run all orbits with twice their steps and with these, then those that need it with steps halved again.

    run(orbits, step) integrates the orbits of that index array; compare(fine, coarse, orbits) returns distances of
    states and phases (moments, orbits), and how many times the error of a state counts; keep(orbits, fine, chosen,
    error) takes over the results numbered `chosen` of a run. Orbits whose error is too large for one more halving, as
    chaotic ones', are left at that.
    Cost: one and a half runs for orbits as expected.
    """
    orbits, order = np.arange(len(plan.step)), flow.scheme.order
    step, local = plan.step, plan.local
    coarse = run(orbits, 2 * step)
    for round_ in range(HALVINGS + 1):
        fine = run(orbits, step)
        apart, phase, weight = compare(fine, coarse, orbits)
        error, rounding = (
            weight * part for part in estimated(flow, Steps(step, local, plan.motion.of(orbits)), apart, phase)
        )
        worst = error.max(axis=0)
        again = (worst > accuracy) & (worst <= accuracy * 2.0**order) & (rounding.max(axis=0) < 0.5 * worst)
        again &= round_ < HALVINGS and not flow.adaptive
        keep(orbits, fine, np.flatnonzero(~again), error)
        if not again.any():
            return
        coarse = fine.of(again)
        orbits, step, local = orbits[again], step[again] / 2, local[again] / 2.0**order


def until(error: np.ndarray, times: np.ndarray, accuracy: float) -> np.ndarray:
    """Return the time (orbits,) up to which errors (moments, orbits) at `times` (moments,) stay below the accuracy."""
    holds = error <= accuracy
    count = np.where(holds.all(axis=0), len(times), (~holds).argmax(axis=0))
    return np.concatenate([[0.0], times])[count]
