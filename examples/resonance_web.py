"""Resonance web of a neo-Hookean body: where the two librations of an energy surface lock, and how fast frequencies
diffuse.

Shows frequencies on a grid of a section, the lines k_alpha nu_alpha + k_beta nu_beta = 0 on it, and the diffusion
histogram.
"""

import numpy as np
from matplotlib.figure import Figure

import fastaff
from fastaff import plot, resonance_web, resonances
from fastaff.frequencies import diffusion_histogram
from fastaff.plot import plot_diffusion_histogram, plot_web

CHAOTIC = -3.5  # log10 of the change of frequency between the halves of the time
body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=2.0), mu=1.0)
section = fastaff.AlphaTurning(direction=+1)
surface = {"energy": 1.0, "p_eta": 0.3, "p_gamma": 0.2}

edge = plot.edge(body, section, **surface)
axes = [np.linspace(low, high, cells + 2)[1:-1] for (low, high), cells in zip(edge.axes, (64, 72))]
grid = fastaff.energy_grid(body, section=section, axes=axes, **surface)
found = fastaff.frequency_map(body, grid.z0, time=600.0)
print(f"{grid.cell_index.size} orbits: {found.summary()}")

# Only where frequencies exist, and outside of large islands, which have a lattice of their own.
ratio = found.nu[0] / found.nu[1]
regular = found.regular & (ratio > 1.2) & (ratio < 1.6)
chosen = found.nu[:2, regular], found.error[:2, regular]
librations = resonances(chosen[0], errors=chosen[1], tolerance=1e-6, max_order=24, names=found.names[:2])
print(librations.summary())
for module, orbits in librations.table()[:6]:
    print(f"  {orbits:5d} orbits: {module}")

nu = np.where(regular, found.nu[:2], np.nan)
spread = np.full((2, grid.inaccessible.size), np.nan)
spread[:, grid.cell_index] = nu
lines = resonance_web(spread.reshape(2, *grid.inaccessible.shape), axes=grid, max_order=24, tolerance=1e-6, jump=0.02)

figure = Figure(figsize=(10, 5), dpi=200, layout="constrained")
left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
plot.plot_diffusion_grid(grid, plot.colouring(found), ax=left)
left.plot(edge.coordinate, edge.momentum, edge.coordinate, -edge.momentum, color="0.35", lw=0.8)
plot_web(lines, ax=left, names=found.names[:2], labels=6)
left.set_title(
    "a   librations of area and size r at $p_{\\alpha}=0$, order $\\leq 24$; circles: locked", loc="left", fontsize=10
)
plot_diffusion_histogram(diffusion_histogram(found.diffusion, threshold=CHAOTIC, status=found.status), ax=right)
right.set_title("b   diffusion of the orbits of the grid", loc="left", fontsize=10)
figure.savefig("resonance_web.png")
