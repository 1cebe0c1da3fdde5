"""The spectrum of the hyperelastic body EQ2.2h, which the paper could not solve: levels, quantizations, elementary
states, densities.

V = C (1/(D1 D2) + (D1^2 + D2^2)/2) separates in r and vartheta; its equation in vartheta is Heun's, with a wall at det
phi = 0. Where 2 mu C/hbar^2 = |m - l| - |m + l| the lowest factor is elementary, f = cos(v) cos^a(v/2) sin^b(v/2), a =
|m - l|/2, b = |m + l|/2, and E = hbar omega (2 n_r + 4 + a + b). At C = mu = hbar = 1 these classes have a = b + 1:
their levels E = 5, 7, 9, ... coincide, and E = 5 + 2 k is 4 k + 2 times degenerate, all other energies below 12 four
times at most.

Run: python examples/hyperelastic_spectrum.py [FILE.png]        (a few seconds, and the compiler once)
"""

import sys

import numpy as np
from matplotlib.figure import Figure

import fastaff as fa
from fastaff.plot import plot_degeneracies, plot_density, plot_levels

FILE = sys.argv[1] if len(sys.argv) > 1 else "hyperelastic_spectrum.png"
HARD_WALL = (2, 3)  # Maslov indices of r and vartheta if the wall at det phi = 0 were hard
body = fa.Body(fa.Hyperelastic(C=1.0), mu=1.0)  # omega = hbar = 1

# Quantizations of the class (2, 0) against its exact levels with n_r = 0: E = 2 n_r + 1 + Lambda(n_vartheta).
n_vartheta = np.arange(30)
n = np.array([0 * n_vartheta, n_vartheta])
exact = fa.quantum.spectrum(body, m=2, l=0, count=1000)
E = np.array([exact.E[(exact.n == [[0], [k]]).all(axis=0)][0] for k in n_vartheta])
rules = {
    "Bohr-Sommerfeld (0, 0)": fa.quantum.BOHR_SOMMERFELD,
    "EBK (2, 2)": fa.quantum.EBK,
    "EBK, hard wall (2, 3)": HARD_WALL,
}
quasi = {name: fa.quantum.quasiclassical_levels(body, n=n, m=2, l=0, maslov=maslov).E for name, maslov in rules.items()}
for name, levels in quasi.items():
    print(f"{name:24} E - exact at n_vartheta = 0, 5, 29: " + "  ".join(f"{(levels - E)[k]:+.4f}" for k in (0, 5, 29)))

spins = np.arange(-8, 9, 2)
against_m = fa.quantum.class_diagram(body, m=spins.tolist(), l=0, count=6)
numbers = np.array([(n_r, k, m) for m in spins for n_r, k in ((0, 0), (1, 0), (0, 1))]).T
ebk = fa.quantum.quasiclassical_levels(body, n=numbers[:2], m=numbers[2], l=0)

C = np.geomspace(0.05, 60, 120)
against_C = fa.quantum.level_diagram(lambda value: fa.Body(fa.Hyperelastic(value)), C, m=1, l=-1, count=12, name="C")

elementary = fa.quantum.spectrum(body, m=1, l=-1, count=4)
v = np.linspace(0.0, np.pi / 2, 7)[1:-1]
shape = elementary.state(0).shape.factors[1](v) / (np.cos(v) * np.cos(v / 2))
print(f"(1, -1): E = {elementary.E[0]:.15g}, f/(cos(v) cos(v/2)) constant to {np.ptp(shape) / shape.max():.1e}")

whole = fa.quantum.all_levels(body, max_energy=12.0)
k = np.arange(4)
gathered = whole.multiplets()
found = [int(gathered.degeneracy[np.argmin(np.abs(gathered.E - energy))]) for energy in 5 + 2 * k]
others = gathered.degeneracy[np.abs(gathered.E[:, None] - (5 + 2 * k)).min(axis=1) > 1e-9]
print(
    f"{whole.E.size} levels below 12, error {whole.error.max():.1e}: E = 5, 7, 9, 11 come {found} times, others "
    f"{others.max()} at most"
)

figure = Figure(figsize=(15.5, 9.2), dpi=150, layout="constrained")
(a, b, c), (d, e, f) = figure.subplots(2, 3)
plot_levels(against_m, ax=a)
a.plot(numbers[2], ebk.E, ls="", marker="x", color="black", ms=6, mew=1.0, label="EBK (2, 2)")
a.legend(
    frameon=False, fontsize=8, loc="upper center", title=r"$n_\vartheta$, and three levels by EBK", title_fontsize=8
)

looks = (("#5a8fc8", "s"), ("#00306f", "o"), ("#b35900", "^"))
for (name, levels), (colour, marker) in zip(quasi.items(), looks):
    b.semilogy(n_vartheta, np.abs(levels - E), color=colour, marker=marker, ms=4, lw=0.9, label=name)
b.set(xlabel=r"$n_\vartheta$", ylabel=r"$|E-E_\mathrm{exact}|$  (units of $\hbar\omega$)")
b.legend(
    frameon=False, fontsize=8, title=r"Maslov indices of $(r, \vartheta)$", title_fontsize=8, bbox_to_anchor=(1, 0.94)
)

plot_levels(against_C, ax=c, unit=np.sqrt(C), ylabel=r"$E/\hbar\omega$")
c.set_xscale("log")
c.plot(1 + 0 * k, 5 + 2 * k, ls="", marker="*", ms=11, mfc="#f0e442", mec="black", mew=0.7, zorder=4)
c.annotate("elementary states", (1, 5), (1.6, 4.05), fontsize=8, va="center")
c.set_xlabel(r"$C$  (units of $\hbar^2/\mu$)")

high = int(np.flatnonzero((exact.n == [[2], [3]]).all(axis=0))[0])
plot_density(elementary.state(0), ax=d, model=body, chart=fa.charts.TWO_POLAR)
plot_density(exact.state(high), ax=e, model=body, chart=fa.charts.ALPHA_BETA)
plot_degeneracies(whole, ax=f)
f.plot(5 + 2 * k, 4 * k + 2, color="#b35900", lw=1.0, ls=(0, (5, 2)), label=r"elementary states, $4k+2$ at $E=5+2k$")
f.legend(frameon=False, fontsize=8, loc="upper left")
for letter, ax, text in (
    ("a", a, "levels against spin, $l=0$"),
    ("b", b, "quantizations of $(m, l)=(2, 0)$, $n_r=0$"),
    ("c", c, "levels of $(1, -1)$ against $C$"),
    ("d", d, "elementary state of $(1, -1)$, $E=5$"),
    ("e", e, f"$(2, 0)$, $n_r=2$, $n_\\vartheta=3$, $E={exact.E[high]:.4f}$"),
    ("f", f, "degeneracies of the whole body"),
):
    ax.set_title(f"{letter}   {text}", loc="left", fontsize=10, pad=36 if ax is c else 8)
figure.supxlabel(
    r"hyperelastic body EQ2.2h, $C=\mu=\hbar=1$ ($\omega=1$) but in c; grey: above the levels computed; densities: "
    r"white the classical "
    r"turning curve, dashed $\det\varphi=0$, grey the edge of the chart",
    fontsize=8,
    color="0.3",
)
figure.savefig(FILE)
print(f"wrote {FILE}")
