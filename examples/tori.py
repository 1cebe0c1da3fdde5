"""Action-angle tori: frequencies over the plane of actions, resonances, and the way back to phase points.

Left: the hyperelastic body EQ2.2h. nu_r is the same for all tori; nu_vartheta depends on J_vartheta and J_gamma, and
the lines are its resonances p : q with nu_r. Right: the heavy top, 2 cos(vartheta)/r, kept from the origin by 4/r, with
p_eta = p_gamma: where it spins slowly the libration slows down to 0 on the tori that reach the upright position, the
separatrix of p_gamma = 0.

Run: python examples/tori.py [FILE.png]        (a few seconds)
"""

import sys
from fractions import Fraction

import matplotlib.pyplot as plt
import numpy as np

import fastaff as fa
from fastaff.systems.models import Cosine, Spring

FILE = sys.argv[1] if len(sys.argv) > 1 else "tori.png"

body = fa.Body(fa.Hyperelastic(C=1.0), mu=1.0)
J_eta = 2 * np.pi * 0.3
J_gamma, J_vartheta = np.meshgrid(np.linspace(-12, 12, 161), np.linspace(0, 8, 101))
rows = np.array([0.5 + 0 * J_gamma, J_vartheta, J_gamma + J_eta, J_gamma - J_eta]).reshape(
    4, -1
)  # J_r, J_vartheta, J_phi, J_psi
found = fa.energy_of_actions(body, rows)
ratio = (found.nu[1] / found.nu[0]).reshape(J_gamma.shape)

# One torus both ways: points on it, their actions, and the straight motion of the angles along an orbit.
J = rows[:, 5000]
theta = np.random.default_rng(1).uniform(size=(4, 1000))
points = fa.from_action_angles(body, J, theta)
again = fa.action_angles(body, points)
orbit = fa.integrate(body, points[:, 0], time=50.0, step=0.01, scheme=fa.SOFRONIOU_SPALETTA10)
end = fa.from_action_angles(body, J, theta[:, 0] + found.nu[:, 5000] * 50.0)
print(f"actions of 1000 points of one torus: spread {np.ptp(again.J, axis=1).max():.1e}")
print(f"orbit after t = 50 against theta + nu t: {np.abs(orbit.z[:, 0] - end).max():.1e}")

levels = sorted({Fraction(p, q) for q in range(1, 8) for p in range(q, 3 * q) if ratio.min() < p / q < ratio.max()})
degrees = fa.resonances(found.nu[[0, 1]], max_order=16, tolerance=1e-3)
print(
    f"nu_vartheta/nu_r from {ratio.min():.4f} to {ratio.max():.4f}; {np.mean(degrees.rank > 0):.1%} of the tori within "
    "1e-3 of p : q"
)

top = fa.Body(fa.SeparableRVartheta(Spring(k=1.0, c=4.0), Cosine(k=2.0)))
spin, action = np.meshgrid(np.linspace(0.02, 3.0, 150), np.linspace(0.01, 12.0, 120))
J_spin = 2 * np.pi * spin
libration = fa.energy_of_actions(top, np.array([1.0 + 0 * spin, action, 2 * J_spin, 0 * spin]).reshape(4, -1))
slow = (libration.nu[1] / libration.nu[0]).reshape(spin.shape)

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
image = left.pcolormesh(J_gamma, J_vartheta, ratio, cmap="cividis", shading="gouraud", rasterized=True)
lines = left.contour(J_gamma, J_vartheta, ratio, levels=[float(f) for f in levels], colors="white", linewidths=0.9)
left.clabel(lines, fmt={float(f): f"{f.numerator}:{f.denominator}" for f in levels}, fontsize=8)
figure.colorbar(image, ax=left, label=r"$\nu_\vartheta/\nu_r$")
left.set(xlabel=r"$J_\gamma$", ylabel=r"$J_\vartheta$", title=r"Hyperelastic body EQ2.2h, $J_\eta = 0.6\pi$")
image = right.pcolormesh(spin, action, slow, cmap="cividis", shading="gouraud", rasterized=True)
lines = right.contour(spin, action, slow, levels=np.arange(0.1, 1.2, 0.1), colors="white", linewidths=0.8)
right.clabel(lines, fmt="%.1f", fontsize=8)
figure.colorbar(image, ax=right, label=r"$\nu_\vartheta/\nu_r$")
right.set(
    xlabel=r"$p_\eta = p_\gamma$", ylabel=r"$J_\vartheta$", title=r"Heavy top, $V = r/2 + (4 + 2\cos\vartheta)/r$"
)
figure.savefig(FILE, dpi=130)
print(f"wrote {FILE}")
