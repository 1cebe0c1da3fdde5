"""Chaos of a neo-Hookean body: a map of one section, and the chaotic fraction against the energy and the ratio of its
moduli.

Orbits of the scans start at random points, uniform over the section's area. Near det phi = 0 the wall is so steep at
high energies that no fixed step gets through it: those orbits are done again with step control, and are counted below.
About 90 s on two cores.
"""

import numpy as np
from matplotlib.figure import Figure

import fastaff
from fastaff import plot
from fastaff.plot import plot_chaos_map, plot_chaotic_fraction

TIME, ORBITS = 1200.0, 300  # about 500 returns to the section at E = 1.5
section = fastaff.AlphaTurning(direction=+1)
planes = {"p_eta": 0.3, "p_gamma": 0.2}


def case(energy, ratio):
    """Return the body with K/G = ratio and random orbits of this energy."""
    body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=ratio), mu=1.0)
    return body, fastaff.energy_sample(body, energy=energy, section=section, orbits=ORBITS, seed=1, **planes).z0


def scan(name, values, make):
    """Scan one parameter and print the results."""
    found = fastaff.chaotic_fraction(make, (values,), names=(name,), time=TIME, early_stop=True)
    print(found.summary())
    for row in zip(
        values, found.fraction, *found.interval(), found.recomputed, found.failed, found.undecided, found.energy_error
    ):
        numbers = (
            "{:8.3f}  fraction {:.3f} ({:.3f} ... {:.3f}); done again {}, failed {}, undecided {}; energy error {:.0e}"
        )
        print("  " + numbers.format(*row))
    return found


body = fastaff.Body(fastaff.NeoHookean(G=1.0, K=2.0), mu=1.0)
edge = plot.edge(body, section, energy=1.5, **planes)
axes = [np.linspace(low, high, 62)[1:-1] for low, high in edge.axes]
grid = fastaff.energy_grid(body, energy=1.5, section=section, axes=axes, **planes)
chaos_map = fastaff.chaos_map(body, grid.z0, time=TIME)
print(f"map: {chaos_map.summary()}; largest energy error {chaos_map.energy_error.max():.0e}")

energies = np.concatenate([np.linspace(0.25, 3.0, 12), [4.0, 5.0, 6.0, 8.0]])
ratios = np.geomspace(0.25, 16.0, 9)
figure = Figure(figsize=(14.5, 4.6), dpi=200, layout="constrained")
left, middle, right = figure.subplots(1, 3)
plot_chaos_map(grid, chaos_map, indicator="megno", ax=left, boundary=edge)
styles = ((2.0, "#00306f", "o"), (8.0, "#b35900", "s"))
for ratio, colour, marker in styles:
    found = scan("energy", energies, lambda energy, ratio=ratio: case(energy, ratio))
    plot_chaotic_fraction(found, ax=middle, colour=colour, marker=marker, label=f"$K/G={ratio:g}$")
for energy, colour, marker in ((1.5, "#00306f", "o"), (2.0, "#b35900", "s")):
    found = scan("K/G", ratios, lambda ratio, energy=energy: case(energy, ratio))
    plot_chaotic_fraction(found, ax=right, colour=colour, marker=marker, label=f"$E={energy:g}$")
right.set_xscale("log")
right.set_xticks([0.25, 0.5, 1, 2, 4, 8, 16], labels=["1/4", "1/2", "1", "2", "4", "8", "16"])
right.minorticks_off()
right.set_xlabel("$K/G$")
middle.set_xlabel("energy $E/G$")
middle.legend(frameon=False, loc="lower right")
right.legend(frameon=False, loc="upper left")
left.set_title("a   section $p_\\alpha=0$, $K/G=2$, $E=1.5$", loc="left", fontsize=10)
middle.set_title("b   against the energy (grey: not reached)", loc="left", fontsize=10)
right.set_title("c   against the ratio of moduli", loc="left", fontsize=10)
figure.supxlabel(
    rf"neo-Hookean body, $G=\mu=1$, $p_\eta=0.3$, $p_\gamma=0.2$; time {TIME:g}; b, c: {ORBITS} random orbits each, 95 "
    rf"% intervals, "
    "pale band: undecided orbits",
    fontsize=8,
    color="0.3",
)
figure.savefig("chaos_neo_hookean.png")
