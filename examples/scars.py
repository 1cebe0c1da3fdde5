"""A wave function of a neo-Hookean body beside the classical orbits that it sits on.

The level of one class next to E = 1.5 whose Husimi function fills least of the section p_alpha = 0: over
it, the relative periodic orbits of the same energy up to three crossings; beside it, the density of the deformation
invariants, with the two simplest of these orbits as curves.

Run: python examples/scars.py [FILE.png]        (about half a minute)
"""

import sys

import numpy as np
from matplotlib.figure import Figure

import fastaff as fa
from fastaff import plot

FILE = sys.argv[1] if len(sys.argv) > 1 else "scars.png"
HBAR, M, L, LEVELS = 1 / 20, 10, -2, 70  # p_eta = hbar (m - l)/2 = 0.3, p_gamma = hbar (m + l)/2 = 0.2
body = fa.Body(fa.NeoHookean(G=1.0, K=2.0), mu=1.0)
section = fa.AlphaTurning(direction=+1)
planes = {"p_eta": 0.3, "p_gamma": 0.2}


def section_grid(energy, cells):
    """Return the boundary of the section and a grid over it."""
    edge = plot.edge(body, section, energy=energy, **planes)
    axes = [np.linspace(low, high, cells) for low, high in edge.axes]
    return edge, fa.energy_grid(body, energy=energy, section=section, axes=axes, **planes)


levels = fa.quantum.spectrum(body, m=M, l=L, count=LEVELS, hbar=HBAR, tolerance=1e-6)
shares = {}
for k in np.argsort(np.abs(levels.E - 1.5))[:12]:
    _, grid = section_grid(float(levels.E[k]), 50)
    Q = fa.quantum.husimi(levels.state(int(k)))(grid.z0)
    shares[int(k)] = np.sum(Q) ** 2 / (Q.size * np.sum(Q**2))
k = min(shares, key=shares.get)
state, energy = levels.state(k), float(levels.E[k])

model = fa.reduced_body(body, **planes)
_, coarse = section_grid(energy, 9)
orbits = fa.find_periodic_orbits(
    model, model.from_planes(coarse.z0), section=fa.Hyperplane(normal=(0, 0, 1, 0)), max_crossings=3, energy=energy
)
print(f"level {k}: E = {energy:.6f}, fills {shares[k]:.2f} of the section; {orbits.summary()}")

figure = Figure(figsize=(11, 4.8), dpi=130, layout="constrained")
left, right = figure.subplots(1, 2)
edge, grid = section_grid(energy, 160)
plot.plot_husimi(grid, fa.quantum.husimi(state)(grid.z0), ax=left, boundary=edge, orbits=orbits)
left.set_title(f"level {k}, $E={energy:.4f}$: Husimi function", loc="left", fontsize=10)
plot.plot_density(state, ax=right, model=body, chart=fa.charts.ALPHA_BETA)
plot.plot_scars(orbits.select(crossings=1), model, ax=right, chart=fa.charts.ALPHA_BETA)
right.set_title("density; curves: orbits of one crossing", loc="left", fontsize=10)
figure.savefig(FILE)
print(f"wrote {FILE}")
