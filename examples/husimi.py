"""Husimi functions of a neo-Hookean body on its Poincaré section p_alpha = 0, over the classical crossings of the same
energies.

Three levels of one class next to E = 1.5, where a chaotic sea surrounds islands: the states that fill least of the
section, each at another place, and the three that fill most. About 1 minute on two cores.
"""

import numpy as np
from matplotlib.figure import Figure

import fastaff
from fastaff import plot
from fastaff.plot import plot_husimi

HBAR, M, L, LEVELS = 1 / 50, 25, -5, 260  # p_eta = hbar (m - l)/2 = 0.3, p_gamma = hbar (m + l)/2 = 0.2
body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=2.0), mu=1.0)
section = fastaff.AlphaTurning(direction=+1)
planes = {"p_eta": 0.3, "p_gamma": 0.2}


def section_grid(energy, cells):
    """Return the boundary of the section and a grid over it."""
    edge = plot.edge(body, section, energy=energy, **planes)
    axes = [np.linspace(low, high, cells) for low, high in edge.axes]
    return edge, fastaff.energy_grid(body, energy=energy, section=section, axes=axes, **planes)


levels = fastaff.quantum.spectrum(body, m=M, l=L, count=LEVELS, hbar=HBAR, tolerance=1e-6)
near = np.flatnonzero(np.abs(levels.E - 1.5) < 0.06)
print(f"{near.size} levels next to E = 1.5; errors of levels below {levels.error.max():.0e}")
shares, images = [], []
for k in near:
    _, grid = section_grid(levels.E[k], 60)
    values = fastaff.quantum.husimi(levels.state(int(k)))(grid.z0)
    shares.append(np.sum(values) ** 2 / (values.size * np.sum(values**2)))  # share of the section's cells that it fills
    image = grid.to_grid(values).filled(0.0).ravel()
    images.append(image / np.linalg.norm(image))
order = [int(i) for i in np.argsort(shares)]
apart: list[int] = []
for i in order:  # states at other places than those before
    if len(apart) < 3 and all(images[i] @ images[j] < 0.3 for j in apart):
        apart.append(i)
chosen = [(int(near[i]), shares[i]) for i in [*apart, *order[-3:]]]

figure = Figure(figsize=(10.5, 6.6), dpi=130, layout="constrained")
for ax, (k, share) in zip(figure.subplots(2, 3, sharex=True, sharey=True).ravel(), chosen):
    energy = float(levels.E[k])
    edge, grid = section_grid(energy, 220)
    starts = fastaff.energy_sample(body, energy=energy, section=section, orbits=60, seed=2, **planes)
    crossings = fastaff.poincare_map(body, starts.z0, section=section, crossings=250, max_time=5000.0)
    Q = fastaff.quantum.husimi(levels.state(int(k)))
    plot_husimi(grid, Q(grid.z0), ax=ax, section_map=crossings, boundary=edge, colorbar=True)
    ax.set_title(f"level {k}, $E={energy:.4f}$, fills {100 * share:.0f} %", loc="left", fontsize=9)
    ax.label_outer()
    print(
        f"level {k}: E = {energy:.6f}, norm {Q.norm:.8f}, {Q.coefficients.shape[0]} quanta, fills {share:.3f}; "
        f"{crossings.summary()}"
    )
figure.supxlabel(
    rf"neo-Hookean body, $G=\mu=1$, $K=2$, $\hbar=1/50$, $(m,l)=({M},{L})$: $p_\eta=0.3$, $p_\gamma=0.2$; colour: "
    rf"Husimi function, each "
    "to its maximum; dots: 60 classical orbits",
    fontsize=8,
    color="0.3",
)
figure.savefig("husimi.png")
