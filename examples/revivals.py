"""Revivals of a wave packet of the hyperelastic body EQ2.2h, predicted from its classical action.

A packet of some levels of vartheta about n = 80 swings with the classical period 1/nu, nu = dE/dJ, spreads over its
torus, and is whole again after 2/(h |d2E/dJ2|), h = 2 pi hbar; at simple fractions of that time it consists of a few
copies of itself. (a) |<Psi(0)|Psi(t)>|^2, between its least and greatest value within each period, beside the times
that the classical action gives. (b), (c) the density of vartheta at the beginning, and at half of the revival time,
where the packet is whole too, half a period late.

Run: python examples/revivals.py [FILE.png]        (some seconds)
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import fastaff as fa

FILE = sys.argv[1] if len(sys.argv) > 1 else "revivals.png"

body, hbar = fa.Body(fa.Hyperelastic(C=2.0), mu=1.0), 0.04
n, m, l = (1, 80), 10, 0
packet = fa.quantum.number_packet(body, n=n, m=m, l=l, width=(0.0, 1.7), hbar=hbar)
times = fa.quantum.revivals(body, n=n, m=m, l=l, hbar=hbar)
T, whole = times.classical.period[1], times.classical.revival[1, 1]
print(packet)
print(f"period of vartheta: {times.quantum.period[1]:.6f} from the levels, {T:.6f} from dE/dJ")
print(f"revival time:       {times.quantum.revival[1, 1]:.3f} from the levels, {whole:.3f} from d2E/dJ2")

t = np.linspace(0, 1.04 * whole, 400_001)
back = np.abs(packet.autocorrelation(t)) ** 2
# the best return within each classical period: the visible envelope of a comb of some thousand teeth
per = max(int(T / t[1]), 1)
teeth = back[: back.size // per * per].reshape(-1, per)
near = np.linspace(whole - T, whole + T, 20_001)
found = np.abs(packet.autocorrelation(near)) ** 2
print(f"best return within a period of it: |A|^2 = {found.max():.3f} at t = {near[found.argmax()]:.3f}")

v = np.linspace(0, np.pi / 2, 451)
r = np.linspace(4, 18, 113)  # E = r + e/r keeps r next to E/2


def carpet(moments):
    """The density of vartheta alone (times, vartheta): that of r and vartheta, summed over r."""
    return packet.density(r[:, None], v, fa.charts.R_VARTHETA, moments).sum(axis=1) * (r[1] - r[0])


figure = plt.figure(figsize=(9.5, 7.2), layout="constrained")
upper, lower = figure.subfigures(2, 1, height_ratios=(1, 1.15))
axis = upper.subplots()
axis.fill_between(t[: teeth.size : per] / whole, teeth.min(axis=1), teeth.max(axis=1), color="#6b7a99", linewidth=0)
for fraction, name in (
    (1, r"$T_\mathrm{rev}$"),
    (1 / 2, "1/2"),
    (1 / 3, "1/3"),
    (2 / 3, "2/3"),
    (1 / 4, "1/4"),
    (3 / 4, "3/4"),
):
    axis.axvline(fraction, color="#b35900", linewidth=0.9, linestyle="--")
    axis.annotate(name, (fraction, 1.02), xycoords=("data", "axes fraction"), ha="center", color="#b35900")
axis.set(xlim=(0, 1.04), ylim=(0, 1.02), xlabel=r"$t/T_\mathrm{rev}$", ylabel=r"$|\langle\Psi(0)|\Psi(t)\rangle|^2$")
axis.set_title("(a) return, least to greatest of each period", loc="left", fontsize=10, pad=16)
starts = 0.0, round(whole / 2 / T) * T - 2 * T
moments = np.linspace(0, 4 * T, 241)
carpets = [np.radians(carpet(start + moments).T) for start in starts]
top = max(image.max() for image in carpets)
held = [image.sum(axis=0) * np.degrees(v[1]) for image in carpets]
print(f"integral of the densities drawn: 1 to {max(np.abs(one - 1).max() for one in held):.0e}")
axes = lower.subplots(1, 2, sharey=True)
for axis, start, image, name in zip(
    axes, starts, carpets, ("(b) at first", r"(c) about $T_\mathrm{rev}/2$"), strict=True
):
    drawn = axis.pcolormesh(
        moments / T, np.degrees(v), image, cmap="cividis", shading="gouraud", vmin=0, vmax=top, rasterized=True
    )
    axis.set_xlabel(rf"$t/T - {start / T:.0f}$" if start else r"$t/T$")
    axis.set_title(name, loc="left", fontsize=10)
axes[0].set_ylabel(r"$\vartheta$ (degrees)")
lower.colorbar(drawn, ax=axes, label=r"probability density of $\vartheta$ (1/degree)")
figure.savefig(FILE, dpi=130)
print(f"wrote {FILE}")
