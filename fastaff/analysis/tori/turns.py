"""Orbits from turn to turn: iterates of a map, states of a driven system after whole periods; and how well a Fourier
series obeys them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...base.status import Status
from ...flows.checks import energy_drift
from ...flows.flow import Flow
from ...flows.options import Options, plan
from ...models.mechanics import inside
from ...models.traits import traits_of
from .series import actions, evaluate

GRID = 512
"""Points of the torus where its equation is tried."""

STEP_ERROR = 1e-13
"""What the steps over a period of a driven system are chosen for."""

CONSTANT = 1e-6
"""Part of its distance from the origin below which the spread of a row is no scale of its errors."""


def turned(body: Any) -> bool:
    """Tell whether the torus of a model's orbit is one of a map: its own, or that over the period of its drive."""
    traits = traits_of(body)
    return traits.iterated or traits.driven


def periods_of(body: Any) -> np.ndarray:
    """Return the periods (2n,) of the rows, 0 where there is none."""
    if traits_of(body).iterated:
        return np.array(body.periods(), dtype=np.float64)
    return np.zeros(2 * body.degrees_of_freedom)


def rows_of(body: Any) -> np.ndarray:
    """Return the rows that move from turn to turn: all but the time of a driven system and its momentum."""
    n, kept = body.degrees_of_freedom, np.arange(traits_of(body).moving)
    return np.concatenate([kept, n + kept])


class Turns(NamedTuple):
    """A flow whose orbits are looked at once a turn, which takes the time `interval`."""

    flow: Flow
    interval: float

    def path(self, z: np.ndarray, count: int) -> tuple[np.ndarray, dict[str, float]]:
        """Return the states (2n, count + 1) of the orbit from z (2n, 1), angles as they wind on, and what became of
        it.
        """
        model, ensemble = self.flow.model, self.flow.ensemble(z.copy())
        states = self.flow.sampled(ensemble, count, time=count * self.interval)
        path = np.column_stack([z, states[0].T])
        if self.flow.traits.driven:
            row = self.flow.traits.moving
            path[row] = z[row]
            with np.errstate(all="ignore"):
                error = float(energy_drift(model, path, ensemble.energy, ensemble.scale).max())
        else:
            path, error = unwound(model, path), 0.0
        return path, {"status": float(ensemble.status[0]), "energy error": error, "samples": float(count)}


def turns_of(body: Any, z: np.ndarray, options: Options) -> Turns:
    """Return the turns of the orbits from z (2n, orbits)."""
    if traits_of(body).iterated:
        return Turns(plan(body, z, options).flow, 1.0)
    period = float(body.period)
    return Turns(plan(body, z, options, error=STEP_ERROR).flow.fitted(period), period)


def unwound(model: Any, path: np.ndarray) -> np.ndarray:
    """Return the iterates (2n, samples) of a map with angles as they wind on, whole periods from what they are."""
    path = path.copy()
    with np.errstate(all="ignore"):
        ahead = np.array(np.broadcast_arrays(*model.iterate(*path[:, :-1])))
        for row, period in enumerate(model.periods()):
            if period > 0:
                turns = np.rint((ahead[row] - path[row, 1:]) / period)
                path[row, 1:] += period * np.cumsum(turns)
    return path


def image(body: Any, z: np.ndarray, count: int) -> np.ndarray:
    """Return where phase points z (2n, points) are after `count` turns, NaN where they do not get there."""
    result = np.full(z.shape, np.nan)
    live = np.isfinite(z).all(axis=0) & inside(body, z)
    if not live.any():
        return result
    if traits_of(body).iterated:
        points = z[:, live]
        with np.errstate(all="ignore"):
            for _ in range(count):
                points = np.array(np.broadcast_arrays(*body.iterate(*points)))
        result[:, live] = points
        return result
    flow, points, _ = plan(body, z[:, live], Options(), error=STEP_ERROR)
    period = float(body.period)
    flow, row = flow.fitted(period), traits_of(body).moving
    ensemble = flow.ensemble(points.copy())
    states = flow.sampled(ensemble, 1 if flow.adaptive else count, time=count * period)
    after = np.where(ensemble.status == Status.OK, states[:, -1].T, np.nan)
    after[row] = np.where(np.isfinite(after[row]), points[row], np.nan)
    result[:, live] = after
    return result


def spread(d: int) -> np.ndarray:
    """Return GRID evenly spread points (d, GRID) of the torus of d angles (Roberts)."""
    ratio = np.roots([1.0, *[0.0] * (d - 1), -1.0, -1.0]).real.max() if d else 1.0
    return np.arange(GRID) * ratio ** -np.arange(1.0, d + 1)[:, None] % 1.0


def without_periods(away: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Take whole periods (rows,), 0 where a row has none, off differences (rows, points), which are returned."""
    for r in np.flatnonzero(periods > 0):
        away[r] -= periods[r] * np.rint(away[r] / periods[r])
    return away


def apart(body: Any, one: np.ndarray, other: np.ndarray) -> float:
    """Return the largest difference of phase points (2n, points), whole periods aside, relative to the extent of the
    others, for coordinates and momenta apart; inf where it is not finite.
    """
    periods, rows = periods_of(body), rows_of(body)
    half = len(rows) // 2
    with np.errstate(all="ignore"):
        away = without_periods(one - other, periods)
        extent = np.maximum(np.ptp(other, axis=1) / 2, CONSTANT * np.abs(other).max(axis=1))
        extent = np.where(periods > 0, np.minimum(extent, periods / 2), extent)
        parts = [np.abs(away[s]).max() / (extent[s].max() or 1.0) for s in (rows[:half], rows[half:])]
    return float(max(parts)) if np.isfinite(parts).all() else np.inf


def turn_residual(
    body: Any, k: np.ndarray, z: np.ndarray, nu: np.ndarray, winding: np.ndarray | None, count: int
) -> float:
    """Return the largest |z(theta + nu) - M(z(theta))| on the torus, M that of `count` turns; see `apart`."""
    theta = spread(k.shape[1])
    points, after = evaluate(k, z, theta), evaluate(k, z, theta + nu[:, None])
    if winding is not None:
        points, after = points + winding @ theta, after + winding @ (theta + nu[:, None])
    return apart(body, image(body, points, count), after)


def area(body: Any, k: np.ndarray, z: np.ndarray, winding: np.ndarray | None) -> np.ndarray:
    """Return the integrals J (d,) of p dq over the cycles of a torus; NaN where they mean nothing: more than one degree
    of freedom of a map that is not symplectic, a momentum that winds.
    """
    n, J = len(z) // 2, actions(k, z)
    if n > 1 and not traits_of(body).symplectic:
        return np.full(J.shape, np.nan)
    if winding is None:
        return J
    constant = z[n:, ~k.any(axis=1)].real.sum(axis=1)
    return np.where(winding[n:].any(), np.nan, J + winding[:n].T @ constant)
