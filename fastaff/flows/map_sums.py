"""Weighted sums along the iterates of a map, added up in its own loops: `compile.map_sums` has their rows."""

from __future__ import annotations

import math

import numpy as np

from ..compile.blocks import idle_block, model_block, parameters
from ..kernels.drive import run_fixed
from . import observers
from .ensemble import Ensemble
from .flow import Flow, launch, no_memory


def extended(ensemble: Ensemble, rows: np.ndarray) -> Ensemble:
    """Return the orbits of a map with further rows (rows, orbits) behind their states."""
    found = Ensemble(np.concatenate([ensemble.z, rows]), ensemble.energy, ensemble.kinetic.copy())
    for name in ("status", "count", "radius"):
        setattr(found, name, getattr(ensemble, name).copy())
    return found


def summed(flow: Flow, kind: str, ensemble: Ensemble, weights: np.ndarray) -> None:
    """Advance orbits of a map by len(weights) iterates, those that end before to their ends, and add up the sums of
    that kind with the weights (iterates,) or (iterates, SPANS) in the rows behind their states.
    """
    n, orbits, iterates = flow.model.degrees_of_freedom, ensemble.z.shape[1], len(weights)
    going = ensemble.count[ensemble.status == 0]
    if not going.size or not iterates:
        return
    ensemble.z[2 * n] = 0.0  # weights are counted from here
    watcher, numbers, calls = observers.nothing().bound
    total = np.full(orbits, going[0] + iterates)
    unit = flow.unit(orbits)
    stop, progress = np.zeros(1, np.int64), np.zeros(math.ceil(orbits / unit), np.int64)
    arguments = (
        model_block(kind, flow.model, n),
        idle_block("march"),
        idle_block("derivative"),
        model_block("inside", flow.model, n),
        model_block("check", flow.model, n),
        watcher,
        parameters(flow.model),
        numbers,
        calls,
        np.ascontiguousarray(weights).ravel(),
        np.zeros(1),
        np.zeros((0, 0)),
        np.zeros(0),
        np.ones(orbits),
        total,
        total,
        np.arange(orbits),
        ensemble.radius,
        False,
        0,
        False,
        False,
        False,
        unit,
        ensemble.z,
        ensemble.count,
        ensemble.kinetic,
        *no_memory(ensemble),
        ensemble.status,
    )
    steps = float(orbits * iterates)
    launch(run_fixed, arguments, stop, progress, steps, flow.threads, None, steps)
    ensemble.time[:] = ensemble.count
