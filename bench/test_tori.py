"""Actions, frequencies and angles: states per second with their errors. Run: pytest bench/test_tori.py -s"""

from __future__ import annotations

import naive
import numpy as np
import pytest
from common import best

from fastaff import (
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    Hyperelastic,
    action_angles,
    energy_of_actions,
    from_action_angles,
)
from fastaff.charts import ALPHA_BETA, R_VARTHETA

STATES, CHECKED = 1_000_000, 2000
CASES = [
    (Harmonic(), ALPHA_BETA),
    (Harmonic(), R_VARTHETA),
    (Anharmonic(), ALPHA_BETA),
    (Anharmonic(), R_VARTHETA),
    (Hyperelastic(), R_VARTHETA),
    (HeavyTop(1.0, 0.5), R_VARTHETA),
]


@pytest.mark.parametrize(("potential", "chart"), CASES, ids=[f"{type(p).__name__}-{c.name}" for p, c in CASES])
def test_tori(benchmark, potential, chart):
    """A million random states around the undeformed body."""
    body = Body(potential)
    z = naive.states(body, STATES)
    found = action_angles(body, z, chart=chart)
    elapsed = best(lambda: action_angles(body, z, chart=chart), repeats=5)
    truth = naive.frequencies(body, z[:, :CHECKED])
    nu = np.array([*found.nu[:2], found.nu_eta, found.nu_gamma])[:, :CHECKED]
    error = (np.abs(nu - truth) / np.abs(truth).max(axis=0)).max(axis=0)
    arrays = [value for value in vars(found).values() if isinstance(value, np.ndarray)]
    memory = (z.nbytes + sum(array.nbytes for array in arrays)) / z.shape[1]
    benchmark.pedantic(action_angles, args=(body, z), kwargs={"chart": chart}, rounds=2)
    benchmark.extra_info.update(states_per_second=z.shape[1] / elapsed)
    print(
        f"\n{type(potential).__name__}, {chart.name}: {z.shape[1] / elapsed / 1e6:.2f} million states/s; relative "
        "error of nu: median "
        f"{np.nanmedian(error):.0e}, 99 % {np.nanquantile(error, 0.99):.0e}, worst {np.nanmax(error):.0e} of "
        f"{CHECKED}; "
        f"{memory:.0f} bytes a state; {found.summary()}"
    )


@pytest.mark.parametrize(("potential", "chart"), CASES, ids=[f"{type(p).__name__}-{c.name}" for p, c in CASES])
def test_inverse(benchmark, potential, chart):
    """Phase points from actions and angles, and E(J) alone."""
    body = Body(potential)
    z = naive.states(body, 100_000)
    found = action_angles(body, z, chart=chart)
    back = from_action_angles(body, found.J, found.theta, chart=chart)
    points = best(lambda: from_action_angles(body, found.J, found.theta, chart=chart), repeats=2)
    energies = best(lambda: energy_of_actions(body, found.J, chart=chart), repeats=2)
    error = np.abs(energy_of_actions(body, found.J, chart=chart).energy - found.energy).max()
    benchmark.pedantic(from_action_angles, args=(body, found.J, found.theta), kwargs={"chart": chart}, rounds=1)
    print(
        f"\n{type(potential).__name__}, {chart.name}: {z.shape[1] / points / 1e3:.0f} thousand points/s, worst round "
        "trip "
        f"{np.abs(back - z).max():.0e}; E(J): {z.shape[1] / energies / 1e3:.0f} thousand/s, worst error {error:.0e}"
    )
