"""Islands and chaos of a neo-Hookean body: the section p_alpha = 0 of one energy surface, coloured by diffusion.

Shows the whole way: body, starts on an energy surface, crossings, diffusion, figure, file.
"""

import numpy as np
from matplotlib.figure import Figure

import fastaff
from fastaff import files, plot

body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=2.0), mu=1.0)
section = fastaff.AlphaTurning(direction=+1)
surface = {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2}

edge = plot.edge(body, section, **surface)
axes = [np.linspace(low, high, 18)[1:-1] for low, high in edge.axes]
grid = fastaff.energy_grid(body, section=section, axes=axes, **surface)

found = fastaff.poincare_map(body, grid.z0, section=section, crossings=400, max_time=5000.0)
frequencies = fastaff.frequency_map(body, grid.z0, time=500.0)
print(f"{found.counts.sum()} crossings; {found.summary()}; largest energy error {found.energy_error.max():.1e}")

figure = Figure(figsize=(7, 6), dpi=200, layout="constrained")
plot.plot_section(found, ax=figure.subplots(), values=plot.colouring(frequencies), boundary=edge)
figure.savefig("poincare_neo_hookean.png")
print(files.save("poincare_neo_hookean", found, model=body, diffusion=frequencies.diffusion, **surface))
