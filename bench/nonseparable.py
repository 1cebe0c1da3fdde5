"""The race of schemes for H(q, p): double pendulums, time against error. `python bench/nonseparable.py [--drift]`.

Time of an orbit at a given accuracy, trials and half-step runs included, and at fixed steps or tolerances, with the
derivatives of a step; for heyoka in batches, if installed, the same. --drift: energies over 10^6 steps.
"""

import sys
import time

import numpy as np

import fastaff as fa
from fastaff.models.mechanics import system_of
from fastaff.schemes import DOP853, GAUSS8, GAUSS16, VERNER9

H = "(p1**2 + 2*p2**2 - 2*p1*p2*cos(q1 - q2))/(2*(1 + sin(q1 - q2)**2)) - 2*cos(q1) - cos(q2)"
ORBITS, SIZES = 1024, ((0.3, 300.0), (1.2, 30.0))
FIXED = {
    GAUSS8: [{"step": h} for h in (0.3, 0.15, 0.07, 0.05)],
    GAUSS16: [{"step": h} for h in (0.5, 0.3, 0.2, 0.15)],
    DOP853: [{"rtol": r, "atol": r} for r in (1e-7, 1e-10, 1e-13)],
    VERNER9: [{"rtol": r, "atol": r} for r in (1e-7, 1e-10, 1e-11, 1e-12, 1e-13)],
}


def starts(size, orbits=ORBITS):
    """Return z0 (4, orbits) with angles up to a size (seed 0)."""
    shape = np.array([1, 1, 0.5, 0.5])[:, None]
    return size * np.random.default_rng(0).uniform(-1, 1, (4, orbits)) * shape


def said(name, how, spent, span, z, truth, failed=0):
    """Print the processor time of an orbit and unit of time, and the largest error of nine orbits in ten."""
    error = np.quantile(np.nan_to_num(np.abs(z - truth).max(axis=0), nan=np.inf), 0.9)
    print(
        f"{name:8s} {how:32s} {1e9 * spent / (ORBITS * span):8.0f} ns, error {error:.1e}, {failed} failed", flush=True
    )


def row(model, z0, truth, span, scheme, how):
    """Run a scheme on one thread."""
    fa.integrate(model, z0[:, :2], time=span, scheme=scheme, threads=1, **how)
    began = time.process_time()
    found = fa.integrate(model, z0, time=span, scheme=scheme, threads=1, **how)
    said(scheme.name, str(how), time.process_time() - began, span, found.z, truth, int((found.status != 0).sum()))


def heyoka(z0, truth, span):
    """Run heyoka's batch integrator, set anew for each batch, on one thread: as it comes, wide, and wide and fast.

    Wide ones are of eight, in vectors of 512 bits where there are any; `fast_math` lets LLVM reorder sums.
    """
    try:
        import heyoka as hy
    except ImportError:
        return
    q1, q2, p1, p2 = hy.make_vars("q1", "q2", "p1", "p2")
    energy = eval(H, {"q1": q1, "q2": q2, "p1": p1, "p2": p2, "cos": hy.cos, "sin": hy.sin})
    system = [(q1, hy.diff(energy, p1)), (q2, hy.diff(energy, p2))]
    system += [(p1, -hy.diff(energy, q1)), (p2, -hy.diff(energy, q2))]
    wide = {"force_avx512": True}
    for width, how in ((hy.recommended_simd_size(), {}), (8, wide), (8, {**wide, "fast_math": True})):
        for tolerance in (1e-8, 1e-9, 1e-10, 1e-12, 1e-13, 1e-14):
            batch = hy.taylor_adaptive_batch(system, np.zeros((4, width)), tol=tolerance, **how)
            z, began = np.empty_like(z0), time.process_time()
            for first in range(0, ORBITS, width):
                batch.set_time(0.0)
                batch.state[:] = z0[:, first : first + width]
                batch.propagate_until(span)
                z[:, first : first + width] = batch.state
            label = f"tol={tolerance:g}, {width} at once" + ", fast_math" * ("fast_math" in how)
            said("heyoka", label, time.process_time() - began, span, z, truth)


def evaluations(model, z0):
    """Print the derivatives of a step: GAUSS8 and GAUSS16 take 4 and 8 a sweep, as many sweeps as the slowest lane."""
    print("derivatives a step: DOP853 12, VERNER9 16")
    counted = np.zeros(1, np.int64)
    for scheme, h in ((GAUSS8, 0.15), (GAUSS8, 0.05), (GAUSS16, 0.5), (GAUSS16, 0.15)):
        for sweeps in range(1, 40):  # the fewest with which all orbits converge over 30 steps
            limited = type(scheme)(scheme.name, scheme.order, scheme.source, scheme.nodes, sweeps)
            counted[0] = (fa.integrate(model, z0, time=30 * h, step=h, scheme=limited).status == 0).mean() > 0.5
            if counted[0]:
                break
        print(f"{scheme.name}, step {h}: {sweeps} sweeps for half of the orbits, {sweeps * scheme.stages} derivatives")


def drift(model):
    """Print the energy errors of 16 orbits over 10^6 steps, and of VERNER9 over the same time."""
    z0 = starts(0.3, 16)
    for scheme, how in ((GAUSS8, {"step": 0.05}), (GAUSS16, {"step": 0.3}), (VERNER9, {"rtol": 1e-12, "atol": 1e-12})):
        span = 1e6 * how.get("step", 0.1)
        found = fa.integrate(model, z0, time=span, scheme=scheme, samples=4, **how)
        off = np.array([system_of(model).energies(z) - system_of(model).energies(z0) for z in found.samples]) / 3
        print(f"{scheme.name:8s} to {span:g}: energy error, in 3, at quarters of it", np.abs(off).max(axis=1))


def main():
    """Race on small and on large swings."""
    model = fa.hamiltonian(H, coordinates="q1 q2", momenta="p1 p2")
    if "--drift" in sys.argv:
        drift(model)
        return
    evaluations(model, starts(0.3, 256))
    for size, span in SIZES:
        z0 = starts(size)
        truth = fa.integrate(model, z0, time=span, scheme=VERNER9, rtol=3e-15, atol=1e-15).z
        print(f"angles up to {size}, time {span}")
        for accuracy in (1e-6, 1e-9, 1e-12):
            for scheme in (GAUSS8, GAUSS16):
                row(model, z0, truth, span, scheme, {"accuracy": accuracy})
        for scheme, runs in FIXED.items():
            for how in runs:
                row(model, z0, truth, span, scheme, how)
        heyoka(z0, truth, span)


if __name__ == "__main__":
    main()
