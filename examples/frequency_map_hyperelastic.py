"""Frequencies of the hyperelastic body against the closed form nu_r = sqrt(C/mu)/pi, the same for every orbit.

Shows that the body is integrable: the frequencies of an energy surface lie on a smooth curve and do not diffuse.
"""

import numpy as np

import fastaff

C, mu = 2.0, 0.5
body = fastaff.Body(fastaff.Hyperelastic(C=C), mu=mu)
grid = fastaff.energy_grid(
    body,
    energy=7.0,
    section=fastaff.AlphaTurning(+1),
    axes=(np.linspace(0.1, 1.2, 20), np.linspace(-0.8, 0.8, 9)),
    p_eta=0.3,
    p_gamma=0.2,
)
found = fastaff.frequency_map(body, grid.z0, time=300.0)

exact = np.sqrt(C / mu) / np.pi
print(f"{grid.cell_index.size} orbits: {found.summary()}")
print(
    f"nu_r = {found.nu[0].mean():.15f}, exact {exact:.15f}; largest difference {np.abs(found.nu[0] - exact).max():.1e}"
)
print(f"largest estimate of its error {found.error[0].max():.1e}; median diffusion 10^{np.median(found.diffusion):.1f}")
