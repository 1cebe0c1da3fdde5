"""A neo-Hookean body in motion: on a torus, in the chaotic sea and on a periodic orbit, side by side.

Each panel shows the ellipse that the unit circle of the material has become, with its material lines, and the stretches
D1 and D2 below. The three motions have the same energy and angular momenta and start on the same section; the periodic
one is periodic up to a rotation, as its stretches show.

Run: python examples/animate_body.py [FILE.gif or FILE.mp4]        (about half a minute)
"""

import sys

import numpy as np

import fastaff as fa
from fastaff import plot

FILE = sys.argv[1] if len(sys.argv) > 1 else "animate_body.gif"

body = fa.Body(fa.NeoHookean(G=1.0, K=2.0), mu=1.0)
surface = {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2, "section": fa.AlphaTurning(direction=+1)}
starts = np.concatenate([fa.energy_grid(body, axes=([beta], [0.0]), **surface).z0 for beta in (0.75, 0.42)], axis=1)
chaos = fa.chaos_map(body, starts, time=3000.0, indicators=(fa.SALI(),))
print(f"SALI: {chaos.summary()}")

# The middle of the largest island, a periodic orbit of the body reduced by its rotations.
model = fa.reduced_body(body, p_eta=0.3, p_gamma=0.2)
guess = model.from_planes(fa.energy_grid(body, axes=([0.95], [0.0]), **surface).z0)
orbit = fa.periodic_orbits(model, guess, section=fa.Hyperplane(normal=(0, 0, 1, 0)), energy=1.5)
beta, p_beta = orbit.points[1, 0, 0], orbit.points[3, 0, 0]
periodic = fa.energy_grid(body, axes=([beta], [p_beta]), **surface).z0
print(f"periodic orbit at beta = {beta:.9f}: T = {orbit.period[0]:.6f}, residue {orbit.residue[0]:.4f}")

animation = plot.animate(
    body,
    np.concatenate([starts, periodic], axis=1),
    time=12 * orbit.period[0],
    frames=180,
    titles=("regular", "chaotic", "periodic"),
)
print(f"wrote {plot.save_animation(animation, FILE, overwrite=True)}")
