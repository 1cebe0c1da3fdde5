"""Periodic orbits of a neo-Hookean body on its section p_alpha = 0, with islands and chaos, and a family followed in
the energy.

Left: crossings of a grid of orbits coloured by their diffusion, and the relative periodic orbits up to six crossings:
period and Greene's residue beside each. Right: backbone curves, the frequency of the body's two simplest orbits over
the energy; where solid lines turn dashed the orbit loses its stability and others branch off.

Run: python examples/periodic_orbits.py [FILE.png]        (about a minute)
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import fastaff as fa
from fastaff import plot
from fastaff.plot import plot_backbone, plot_periodic

FILE = sys.argv[1] if len(sys.argv) > 1 else "periodic_orbits.png"

body = fa.Body(fa.NeoHookean(G=1.0, K=2.0), mu=1.0)
turning = fa.AlphaTurning(direction=+1)
surface = {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2}

edge = plot.edge(body, turning, **surface)
axes = [np.linspace(low, high, 30)[1:-1] for low, high in edge.axes]
grid = fa.energy_grid(body, section=turning, axes=axes, **surface)
crossings = fa.poincare_map(body, grid.z0, section=turning, crossings=250, max_time=3000.0)
frequencies = fa.frequency_map(body, grid.z0, time=500.0)

# The body reduced by its rotations: two degrees of freedom, where a relative periodic orbit of the body is a periodic
# one.
model = fa.reduced_body(body, p_eta=surface["p_eta"], p_gamma=surface["p_gamma"])
section = fa.Hyperplane(normal=(0, 0, 1, 0))
orbits = fa.find_periodic_orbits(
    model, model.from_planes(grid.z0), section=section, max_crossings=6, energy=surface["energy"]
)
print(f"{orbits.summary()}; |flow(z) - z| at most {orbits.residual.max():.1e}")

figure, (left, right) = plt.subplots(1, 2, figsize=(12.5, 5.6), layout="constrained", width_ratios=(3, 2))
branches, names = [], []
plot.plot_section(crossings, ax=left, values=plot.colouring(frequencies), boundary=edge)
figure.canvas.draw()
plot_periodic(orbits, ax=left)

for number, z in enumerate(orbits.z[:, orbits.crossings == 1].T):
    for direction in (-1, 1):
        branch = fa.continuation(
            model, z, section=section, direction=direction, bounds=(0.2, 4.0), ds_max=0.1, max_steps=200
        )
        branches.append(branch)
        names.append(rf"$\beta={z[1]:.3f}$ at $E=1.5$")
        for found in branch.bifurcations:
            print(f"orbit {number}: {found.event.name} at E = {found.parameter:.9f}, period {found.period:.6f}")
plot_backbone(branches, ax=right, names=names)
figure.get_layout_engine().set(wspace=0.06)
figure.savefig(FILE, dpi=130)
print(f"wrote {FILE}")
