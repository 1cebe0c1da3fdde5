"""A body thrown against the wall at det phi = 0: energy errors of a fixed step, of adaptive steps and of
time-transformed ones.

At energy 8 the neo-Hookean body comes within det phi = 0.0004 of the wall; AUTO chooses a scheme for it.
"""

import numpy as np

from fastaff import AUTO, DOP853, KAHAN_LI8, AlphaTurning, Body, NeoHookean, TimeTransformed, energy_grid, integrate

TIME = 50.0

body = Body(NeoHookean(G=1.0, K=2.0), mu=1.0)
grid = energy_grid(
    body,
    energy=8.0,
    p_eta=0.3,
    p_gamma=0.2,
    section=AlphaTurning(+1),
    axes=(np.linspace(0.2, 2.6, 6), np.linspace(-3.0, 3.0, 6)),
)

print(f"{grid.z0.shape[1]} orbits, time {TIME:g}")
print(f"{'scheme':28} {'step':>9} {'largest energy error':>21}  what became of the orbits")
for scheme, step in ((KAHAN_LI8, 1e-3), (KAHAN_LI8, 2.5e-4), (DOP853, None), (TimeTransformed(), None), (AUTO, None)):
    orbits = integrate(body, grid.z0, time=TIME, samples=20, scheme=scheme, step=step)
    chosen = f"AUTO: {orbits.scheme.name}" if scheme is AUTO else orbits.scheme.name
    counts = orbits.summary().split(" (")[0]
    print(f"{chosen:28} {np.median(orbits.step):9.3g} {orbits.energy_error.max():21.1e}  {counts}")
    rate = getattr(orbits.scheme, "rate", None)
    if rate is not None:
        print(f"{'':28} dt/ds = {rate}")
