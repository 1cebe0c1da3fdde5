"""Schemes before a steep wall: error, CPU time and forces of a neo-Hookean body at energy 8 to T = 1000. Run: pytest
bench/test_walls.py -s

WALLS_TIME sets another T.
"""

from __future__ import annotations

import math
import os
import time as clock

import numpy as np
import pytest

from fastaff import AUTO, DOP853, KAHAN_LI8, AlphaTurning, Body, NeoHookean, TimeTransformed, energy_grid, integrate
from fastaff.cli.demonstration import P_ETA, P_GAMMA
from fastaff.flows.flow import Flow, no_memory
from fastaff.flows.observers import nothing
from fastaff.flows.time_transformed import prepared
from fastaff.schemes import RungeKutta, Splitting

TIME = float(os.environ.get("WALLS_TIME", "1000"))
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
        flow, span = Flow(BODY, scheme, math.inf, rtol, rtol, 1), 10.0
        ensemble = flow.ensemble(z0.copy())
        flow.advance(ensemble, nothing(), *no_memory(ensemble), time=span)
        return float(ensemble.count.mean() * scheme.evaluations / span)
    return prepared(TIME, BODY, z0, TimeTransformed(scheme.splitting), None, 1)[2]


@pytest.mark.parametrize(
    ("scheme", "step", "rtol"),
    [
        (KAHAN_LI8, 1e-3, 1e-12),
        (KAHAN_LI8, 5e-4, 1e-12),
        (KAHAN_LI8, 2.5e-4, 1e-12),
        (KAHAN_LI8, 1.25e-4, 1e-12),
        (DOP853, None, 1e-12),
        (DOP853, None, 1e-13),
        (DOP853, None, 1e-14),
        (TimeTransformed(), None, 1e-12),
        (AUTO, None, 1e-12),
    ],
    ids=lambda value: getattr(value, "name", str(value))[:40],
)
def test_steep_wall(scheme, step, rtol):
    z0 = starts()
    integrate(BODY, z0[:, :1], time=0.1, scheme=scheme, step=step)  # compiles
    start = clock.process_time()
    orbits = integrate(BODY, z0, time=TIME, samples=20, step=step, scheme=scheme, rtol=rtol, atol=rtol)
    seconds = clock.process_time() - start
    per_time = forces(orbits.scheme, orbits.step, rtol, z0)
    print(
        f"\n{scheme.name[:24]:24} -> {orbits.scheme.name:28} step {orbits.step:8.3g} rtol {rtol:.0e}: "
        f"energy error {orbits.energy_error.max():.2e}"
        f" (median {np.median(orbits.energy_error):.1e}), {seconds:.1f} s CPU, {per_time:.0f} forces per unit time; "
        f"{orbits.summary()}"
    )
