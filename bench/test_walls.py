"""Schemes before a steep wall: error, processor time and forces of a neo-Hookean body at energy 8 to T = 200. Run:
pytest bench/test_walls.py -s
"""

from __future__ import annotations

import math
import time as clock

import numpy as np
import pytest

from fastaff import (
    AUTO,
    DOP853,
    KAHAN_LI8,
    VERNER9,
    AlphaTurning,
    Body,
    NeoHookean,
    TimeTransformed,
    energy_grid,
    integrate,
)
from fastaff.cli.demonstration import P_ETA, P_GAMMA
from fastaff.runs.flow import Flow, no_memory
from fastaff.runs.observers import nothing
from fastaff.runs.schemes import RungeKutta, Splitting
from fastaff.runs.time_transformed import prepared
from fastaff.systems.models.mechanics import system_of

TIME = 200.0
BODY = Body(NeoHookean(G=1.0, K=2.0), 1.0)


def starts() -> np.ndarray:
    """Return the starts of the 20 x 20 cells of the section that the energy reaches."""
    axes = (np.linspace(0.0514, 2.817, 22)[1:-1], np.linspace(-3.906, 3.906, 22)[1:-1])
    return energy_grid(BODY, energy=8.0, p_eta=P_ETA, p_gamma=P_GAMMA, section=AlphaTurning(+1), axes=axes).z0


def forces(scheme, step, rtol, z0) -> float:
    """Return the forces of an orbit per unit time."""
    if isinstance(scheme, Splitting):
        return scheme.stages / step
    if isinstance(scheme, RungeKutta):
        flow, span = Flow(system_of(BODY), scheme, math.inf, rtol, rtol, 1), 10.0
        ensemble = flow.ensemble(z0.copy())
        flow.advance(ensemble, nothing(), *no_memory(ensemble), time=span)
        return float(ensemble.count.mean() * scheme.evaluations / span)
    return prepared(TIME, system_of(BODY), z0, TimeTransformed(scheme.splitting), None, 1)[2]


RACERS = [(KAHAN_LI8, 5e-4), (DOP853, None), (VERNER9, None), (TimeTransformed(), None), (AUTO, None)]


@pytest.mark.parametrize(("scheme", "step"), RACERS, ids=[scheme.name.split()[0] for scheme, _ in RACERS])
def test_steep_wall(numbers, scheme, step):
    """Processor time and the largest energy error."""
    z0 = starts()
    integrate(BODY, z0[:, :1], time=0.1, scheme=scheme, step=step)  # compiles
    start = clock.process_time()
    orbits = integrate(BODY, z0, time=TIME, samples=20, step=step, scheme=scheme, rtol=1e-13, atol=1e-13)
    numbers.update(
        seconds=clock.process_time() - start,
        orbits=z0.shape[1],
        scheme=orbits.scheme.name,
        energy_error=orbits.energy_error.max(),
        forces_per_unit_time=forces(orbits.scheme, orbits.step, 1e-13, z0),
        said=orbits.summary(),
    )
