"""The race of schemes for H(q, p): double pendulums, time against error. `python bench/nonseparable.py`.

What an orbit takes at an accuracy asked for, trials and half-step runs included, and at fixed steps or tolerances.
"""

import time

import numpy as np

import fastaff as fa
from fastaff.schemes import DOP853, GAUSS8, GAUSS16, VERNER9

H = "(p1**2 + 2*p2**2 - 2*p1*p2*cos(q1 - q2))/(2*(1 + sin(q1 - q2)**2)) - 2*cos(q1) - cos(q2)"
ORBITS, SIZES = 256, ((0.3, 300.0), (1.2, 30.0))
FIXED = {
    GAUSS8: [{"step": h} for h in (0.3, 0.15, 0.07, 0.05)],
    GAUSS16: [{"step": h} for h in (0.5, 0.3, 0.2, 0.15)],
    DOP853: [{"rtol": r, "atol": r} for r in (1e-7, 1e-10, 1e-13)],
    VERNER9: [{"rtol": r, "atol": r} for r in (1e-7, 1e-10, 1e-13)],
}


def row(model, z0, truth, span, scheme, how):
    """Print the time of one thread an orbit and unit of time, and the largest error of nine orbits in ten."""
    fa.integrate(model, z0[:, :2], time=span, scheme=scheme, threads=1, **how)
    began = time.process_time()
    found = fa.integrate(model, z0, time=span, scheme=scheme, threads=1, **how)
    spent = (time.process_time() - began) / (ORBITS * span)
    error = np.quantile(np.nan_to_num(np.abs(found.z - truth).max(axis=0), nan=np.inf), 0.9)
    failed = int((found.status != 0).sum())
    print(f"{scheme.name:8s} {how!s:32s} {1e9 * spent:8.0f} ns, error {error:.1e}, {failed} failed", flush=True)


def main():
    """Race on small and on large swings."""
    model = fa.hamiltonian(H, coordinates="q1 q2", momenta="p1 p2")
    for size, span in SIZES:
        random = np.random.default_rng(0)
        z0 = size * random.uniform(-1, 1, (4, ORBITS)) * np.array([1, 1, 0.5, 0.5])[:, None]
        truth = fa.integrate(model, z0, time=span, scheme=VERNER9, rtol=3e-15, atol=1e-15).z
        print(f"angles up to {size}, time {span}")
        for accuracy in (1e-6, 1e-9, 1e-12):
            for scheme in (GAUSS8, GAUSS16):
                row(model, z0, truth, span, scheme, {"accuracy": accuracy})
        for scheme, runs in FIXED.items():
            for how in runs:
                row(model, z0, truth, span, scheme, how)


if __name__ == "__main__":
    main()
