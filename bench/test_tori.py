"""Actions, frequencies and angles: states per second with their errors. Run: pytest bench/test_tori.py -s"""

from __future__ import annotations

import naive
import numpy as np
import pytest
from common import best

from fastaff import Anharmonic, Body, HeavyTop, Hyperelastic, action_angles, energy_of_actions, from_action_angles
from fastaff.systems.charts import ALPHA_BETA, R_VARTHETA

STATES, CHECKED = 200_000, 2000
CASES = [
    (Anharmonic(), ALPHA_BETA),
    (Anharmonic(), R_VARTHETA),
    (Hyperelastic(), R_VARTHETA),
    (HeavyTop(1.0, 0.5), R_VARTHETA),
]


@pytest.mark.parametrize(("potential", "chart"), CASES, ids=[f"{type(p).__name__}-{c.name}" for p, c in CASES])
def test_tori(numbers, timed, potential, chart):
    """Random states around the undeformed body, both ways, and E(J) alone."""
    body = Body(potential)
    z = naive.states(body, STATES)
    found = action_angles(body, z, chart=chart)
    some = found.J[:, :CHECKED], found.theta[:, :CHECKED]
    truth = naive.frequencies(body, z[:, :CHECKED])
    nu = np.array([*found.nu[:2], found.nu_eta, found.nu_gamma])[:, :CHECKED]
    error = (np.abs(nu - truth) / np.abs(truth).max(axis=0)).max(axis=0)
    arrays = [value for value in vars(found).values() if isinstance(value, np.ndarray)]
    energy = energy_of_actions(body, some[0], chart=chart).energy
    numbers.update(
        rate=STATES / timed(lambda: action_angles(body, z, chart=chart), repeats=2),
        median_error=np.nanmedian(error),
        error_of_99=np.nanquantile(error, 0.99),
        worst_error=np.nanmax(error),
        bytes_a_state=(z.nbytes + sum(array.nbytes for array in arrays)) / STATES,
        inverse_rate=CHECKED / best(lambda: from_action_angles(body, *some, chart=chart), repeats=2),
        round_trip=np.abs(from_action_angles(body, *some, chart=chart) - z[:, :CHECKED]).max(),
        energy_error=np.abs(energy - found.energy[:CHECKED]).max(),
    )
