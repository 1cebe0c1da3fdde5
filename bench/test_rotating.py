"""Turning frames beside natural systems with the same force, in turns. Run: pytest bench/test_rotating.py -s"""

from __future__ import annotations

import numpy as np
import pytest
from common import ORBITS, alternating

from fastaff import KAHAN_LI8, chaos_map, hamiltonian, integrate, poincare_map
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8
from fastaff.systems.models.mechanics import system_of

STEP, SPAN = 0.05, 20.0
CASES = {
    "two centres": ("-(1 - m)/sqrt((x + m)**2 + y**2) - m/sqrt((x - 1 + m)**2 + y**2)", 0.0121, 1.0, "y=0"),
    "logarithmic": ("log(m + x**2 + y**2/0.8)/2", 0.1, 0.3, "y=0"),
    "Henon-Heiles": ("m*(x**2 + y**2)/2 + x**2*y - y**3/3", 1.0, 0.3, "y=0"),
}
"""Potentials, a parameter, rates of turning and sections; from the dearest force to the cheapest."""


def starts(name: str) -> np.ndarray:
    """Return z0 (4, ORBITS) of regular and chaotic orbits that stay."""
    cloud = np.random.default_rng(1).uniform(-0.1, 0.1, (4, ORBITS))
    if name != "two centres":
        return cloud
    return 0.1 * cloud + np.array([0.5 - 0.0121, np.sqrt(0.75), -np.sqrt(0.75), 0.5 - 0.0121])[:, None]


@pytest.mark.parametrize("name", CASES)
def test_beside_the_natural_system(numbers, name):
    """The speed of both (processor time), their ratio, and the loss of the energy, Jacobi's."""
    text, m, omega, section = CASES[name]
    natural, turning = hamiltonian(text, m=m), hamiltonian(text, m=m, rotation=omega)
    z, own = starts(name), STEP * np.random.default_rng(2).uniform(0.9, 1.0, ORBITS)
    runs = {
        "KAHAN_LI8": lambda model: integrate(model, z, time=SPAN, step=STEP, scheme=KAHAN_LI8),
        "BLANES_CASAS_ESCORIHUELA8": lambda model: integrate(
            model, z, time=SPAN, step=STEP, scheme=BLANES_CASAS_ESCORIHUELA8
        ),
        "own steps": lambda model: integrate(model, z, time=SPAN, step=own, scheme=KAHAN_LI8),
        "section": lambda model: poincare_map(model, z, section=section, crossings=5, max_time=SPAN, step=STEP),
        "chaos map": lambda model: chaos_map(model, z[:, :256], time=2 * SPAN, step=STEP),
    }
    for what, run in runs.items():
        both = {"natural": lambda run=run: run(natural), "turning": lambda run=run: run(turning)}
        _, cost = alternating(both, repeats=7)
        numbers[what] = cost["natural"] / cost["turning"]
    end = runs["KAHAN_LI8"](turning)
    numbers["energy_change"] = np.max(np.abs(system_of(turning).energies(end.z) - system_of(turning).energies(z)))
    assert numbers["energy_change"] < 1e-7
