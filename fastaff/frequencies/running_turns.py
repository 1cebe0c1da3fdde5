"""Weighted mean angles of the planes and coordinates of maps, added up while their orbits run: no samples are kept."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..engine.map_sums import AngleSumRows, angles_of, moments_of
from ..engine.plane_loops import COLUMNS, MOMENTS, SPANS
from ..engine.threads import by_portions
from ..runs.flow import Ensemble, Flow
from ..runs.map_sums import extended, summed
from .turning import (
    COST,
    PIECE,
    ROUNDING,
    SAFETY,
    Means,
    RotationAccumulator,
    TurningWindow,
    unresolved,
    without_standing,
)

ROWS = 64
"""Numbers that are kept of an orbit, about, in sums."""


class RunningMeans(NamedTuple):
    """Means of all n angles over the steps of orbits; moving (n, orbits): whether a plane moves."""

    means: Means
    moving: np.ndarray


def running_means(flow: Flow, ensemble: Ensemble, steps: int) -> RunningMeans:
    """Advance orbits of a map by so many steps and return the means over them: the same numbers as from their samples.

    Orbits that end before, by their status in `ensemble`, have no valid means. With planes that do not wind there are
    two runs: the first locates them.
    """
    n = flow.model.degrees_of_freedom
    orbits = ensemble.z.shape[1]
    own = angles_of(flow.system.winding)
    planes = [*own.planes, *(n + r for r in own.planes)]
    turning, window = RotationAccumulator(ensemble.z[planes]), TurningWindow(0, steps, (0, steps))
    if planes:
        _learn(flow, ensemble, turning, window)
    run = extended(ensemble, _started(own, turning, ensemble.z[planes]))
    for at in range(0, steps, PIECE):
        tables, _ = window.weights(at, min(PIECE, steps - at))
        turning.weights[:-1] += tables.sum(axis=1)
        summed(flow, "angles", run, tables.T)
    ensemble.z[:] = run.z[: 2 * n]
    for name in ("status", "count", "time", "kinetic"):
        getattr(ensemble, name)[:] = getattr(run, name)
    sums = run.z[own.step(0) : own.plane(0)].reshape(own.angles, 1 + SPANS, orbits)[:, 1:]
    nu = np.zeros((n, orbits))
    error = np.full((n, orbits), np.inf)
    halves = np.zeros((2, n, orbits))
    moving = np.ones((n, orbits), bool)
    if own.wound:

        def some(at: slice) -> None:
            wound = [*own.wound]
            first = sums[: len(own.wound), :, at] / turning.weights[:-1, None]
            now = first[:, 0]
            spread = SAFETY * np.abs(first[:, 1:] - first[:, :1]).max(axis=1)
            nu[wound, at], halves[:, wound, at] = now, first[:, 1:3].swapaxes(0, 1)
            error[wound, at] = spread + unresolved(now, steps) + ROUNDING * np.maximum(np.abs(now), 1.0)

        by_portions(some, orbits, COST * len(own.wound), flow.threads)
    if planes:
        turning.sums = sums[len(own.wound) :].transpose(2, 0, 1)
        found = without_standing(turning.means(steps, flow.threads), steps)
        plain = [*own.planes]
        nu[plain], error[plain], halves[:, plain] = found
        moving[plain] = (turning.planes[:, :, COLUMNS.a] != 0).T
    return RunningMeans(Means(nu, error, halves), moving)


def _learn(flow: Flow, ensemble: Ensemble, turning: RotationAccumulator, window: TurningWindow) -> None:
    """Find centre, shape and reference of the planes of orbits by a run that does not change the ensemble."""
    own = moments_of(flow.system.winding)
    rows = np.zeros((own.end - own.size, ensemble.z.shape[1]))
    for k, r in enumerate(own.planes):
        at = own.plane(k) - own.size
        rows[at : at + 2] = ensemble.z[[r, own.size // 2 + r]]
    run = extended(ensemble, rows)
    for at in range(0, window.length, PIECE):
        _, weights = window.weights(at, min(PIECE, window.length - at))
        turning.weights[-1] += weights.sum()
        summed(flow, "moments", run, weights)
    kept = run.z[own.plane(0) :].reshape(len(own.planes), 4 + MOMENTS, -1)
    turning.moments = np.ascontiguousarray(kept[:, 4:].transpose(2, 0, 1))
    turning.learn(run.status == 0, flow.threads)


def _started(own: AngleSumRows, turning: RotationAccumulator, points: np.ndarray) -> np.ndarray:
    """Return the rows of angles at the beginning, where the planes are at points (2 planes, orbits)."""
    rows = np.zeros((own.end - own.size, points.shape[1]))
    count = len(own.planes)
    for k in range(count):
        at = own.plane(k) - own.size
        plane = turning.planes[:, k].T
        rows[at : at + COLUMNS.end] = plane
        with np.errstate(invalid="ignore"):  # orbits that became infinite
            x = points[k] - plane[COLUMNS.q]
            y = points[count + k] - plane[COLUMNS.p]
        rows[at + COLUMNS.end] = plane[COLUMNS.a] * x
        rows[at + COLUMNS.end + 1] = plane[COLUMNS.b] * x + plane[COLUMNS.c] * y
    return rows
