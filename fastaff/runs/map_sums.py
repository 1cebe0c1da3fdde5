"""Weighted sums along the iterates of a map, added up in its own loops: `engine.map_sums` has their rows."""

from __future__ import annotations

import numpy as np

from ..engine.kernels.drive import FixedSteps, run_fixed
from ..engine.kernels.stepping import Coefficients
from ..engine.packing import launch, units
from . import observers
from .flow import Ensemble, Flow, blocks_of, no_memory


def extended(ensemble: Ensemble, rows: np.ndarray) -> Ensemble:
    """Return the orbits of a map with further rows (rows, orbits) after their states."""
    found = Ensemble(np.concatenate([ensemble.z, rows]), ensemble.energy, ensemble.kinetic.copy())
    for name in ("status", "count", "radius"):
        setattr(found, name, getattr(ensemble, name).copy())
    return found


def summed(flow: Flow, kind: str, ensemble: Ensemble, weights: np.ndarray) -> None:
    """Advance orbits of a map by len(weights) iterates, or to their ends, and add up the sums of that kind with the
    weights (iterates,) or (iterates, SPANS) in the rows after their states.
    """
    n = flow.model.degrees_of_freedom
    orbits = ensemble.z.shape[1]
    iterates = len(weights)
    going = ensemble.count[ensemble.status == 0]
    if not going.size or not iterates:
        return
    ensemble.z[2 * n] = 0.0  # weights are counted from here
    total = np.full(orbits, going[0] + iterates)
    unit = flow.unit(orbits)
    arguments = (
        blocks_of(flow.system, splitting=kind, inside="inside", check="check"),
        Coefficients(np.ascontiguousarray(weights).ravel(), np.zeros(1)),
        observers.nothing().bound,
        FixedSteps(np.ones(orbits), total, total, np.arange(orbits)),
        unit,
        ensemble.orbits(*no_memory(ensemble)),
    )
    steps = float(orbits * iterates)
    launch(run_fixed, arguments, units(orbits, unit), steps, flow.threads, None, steps)
    ensemble.time[:] = ensemble.count
