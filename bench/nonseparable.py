"""The race of schemes for H(q, p): double pendulums, time against error. `python bench/nonseparable.py [--drift]`.

Time of an orbit at a given accuracy, trials and half-step runs included, and at fixed steps or tolerances, with the
derivatives of a step; for heyoka in batches, if installed, the same. Then the times at equal errors, interpolated, by
one thread and, of VERNER9 and of heyoka's fastest batches, by two. --drift: energies over 10^6 steps.
"""

import functools
import multiprocessing
import sys
import time

import numpy as np
from common import batched

import fastaff as fa
from fastaff.runs.schemes import DOP853, GAUSS8, GAUSS16, VERNER9
from fastaff.systems.models.mechanics import system_of

H = "(p1**2 + 2*p2**2 - 2*p1*p2*cos(q1 - q2))/(2*(1 + sin(q1 - q2)**2)) - 2*cos(q1) - cos(q2)"
ORBITS, SIZES, ERRORS, TURNS = 1024, ((0.3, 300.0), (1.2, 30.0)), (1e-6, 1e-9, 1e-12), 15
FIXED = {
    GAUSS8: [{"step": h} for h in (0.5, 0.3, 0.15, 0.07, 0.05)],
    GAUSS16: [{"step": h} for h in (0.8, 0.5, 0.3, 0.2, 0.15)],
    DOP853: [{"rtol": r, "atol": r} for r in (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)],
    VERNER9: [{"rtol": r, "atol": r} for r in (1e-5, 1e-7, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)],
}
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)


def starts(size, orbits=ORBITS):
    """Return z0 (4, orbits) with angles up to a size (seed 0)."""
    shape = np.array([1, 1, 0.5, 0.5])[:, None]
    return size * np.random.default_rng(0).uniform(-1, 1, (4, orbits)) * shape


def said(name, how, spent, span, z, truth, failed=0):
    """Print the processor time of an orbit and unit of time, and the largest error of nine orbits in ten; return both
    with `how`.
    """
    error = np.quantile(np.nan_to_num(np.abs(z - truth).max(axis=0), nan=np.inf), 0.9)
    cost = 1e9 * spent / (ORBITS * span)
    print(f"{name:8s} {how!s:32s} {cost:8.0f} ns, error {error:.1e}, {failed} failed", flush=True)
    return error, cost, how


def shortest(run):
    """Return the least processor time of three runs, and the last one's result."""
    spent = []
    for _ in range(3):
        began = time.process_time()
        found = run()
        spent.append(time.process_time() - began)
    return min(spent), found


def row(model, z0, truth, span, scheme, how):
    """Run a scheme on one thread."""
    fa.integrate(model, z0[:, :2], time=span, scheme=scheme, threads=1, **how)
    spent, found = shortest(lambda: fa.integrate(model, z0, time=span, scheme=scheme, threads=1, **how))
    name = "default" if scheme is None else scheme.name
    return said(name, how, spent, span, found.z, truth, int((found.status != 0).sum()))


@functools.cache
def batch(tolerance, width, more):
    """Return heyoka's integrator of a batch."""
    import heyoka as hy

    q1, q2, p1, p2 = hy.make_vars("q1", "q2", "p1", "p2")
    energy = eval(H, {"q1": q1, "q2": q2, "p1": p1, "p2": p2, "cos": hy.cos, "sin": hy.sin})
    system = [(q1, hy.diff(energy, p1)), (q2, hy.diff(energy, p2))]
    system += [(p1, -hy.diff(energy, q1)), (p2, -hy.diff(energy, q2))]
    return hy.taylor_adaptive_batch(system, np.zeros((4, width)), tol=tolerance, **dict(more))


def heyoka(z0, span, how):
    """Return the ends of orbits by heyoka's batches on one thread, set anew for each."""
    return batched(batch(*how), z0, span)


def others(z0, truth, span):
    """Race heyoka as it comes, wide, and wide and fast, if it is installed; return the points of each.

    Wide ones are of eight, in vectors of 512 bits where there are any; `fast_math` lets LLVM reorder sums.
    """
    try:
        import heyoka as hy
    except ImportError:
        return {}
    wide, points = ("force_avx512", True), {}
    for width, more in ((hy.recommended_simd_size(), ()), (8, (wide,)), (8, (wide, ("fast_math", True)))):
        name = f"heyoka, {width} at once" + ", fast_math" * (len(more) > 1)
        for tolerance in TOLERANCES:
            how = (tolerance, width, more)
            heyoka(z0[:, :width], span, how)
            spent, z = shortest(lambda how=how: heyoka(z0, span, how))
            points.setdefault(name, []).append((*said(name, how[:1], spent, span, z, truth)[:2], how))
    return points


def at(error, points):
    """Return the time at an error, interpolated between two points in logarithms; NaN outside."""
    errors, costs = np.log([point[:2] for point in sorted(points, key=lambda point: point[0])]).T
    return float(np.exp(np.interp(np.log(error), errors, costs, left=np.nan, right=np.nan)))


def walls(runs):
    """Return the least wall times of runs that take turns, in seconds."""
    best = np.full(len(runs), np.inf)
    for _ in range(TURNS):
        for i, run in enumerate(runs):
            began = time.perf_counter()
            run()
            best[i] = min(best[i], time.perf_counter() - began)
    return best


def table(model, z0, span, points, pool):
    """Print the times at equal errors: by one thread, and by two of VERNER9 and of heyoka's last batches."""
    for name, own in points.items():
        print(f"at {ERRORS}, {name:28s}", *(f"{at(error, own):8.0f} ns" for error in ERRORS))
    ours, theirs = points["VERNER9"], list(points.values())[-1]
    for error in ERRORS:
        first, second = (min(p, key=lambda point: abs(np.log(point[0] / error))) for p in (ours, theirs))
        if pool is None or first is second:
            return
        parts = [(half, span, second[2]) for half in np.array_split(z0, 2, axis=1)]
        found = walls(
            [
                lambda how=first[2]: fa.integrate(model, z0, time=span, scheme=VERNER9, threads=2, **how),
                lambda parts=parts: pool.starmap(heyoka, parts, chunksize=1),
            ]
        )
        # The tolerances at hand have other errors: times by two change with the error as times by one do.
        found *= [at(error, ours) / first[1], at(error, theirs) / second[1]]
        print(
            f"two at {error:g}: VERNER9 {1e9 * found[0] / (ORBITS * span):.0f} ns of wall time, heyoka / VERNER9",
            end=" ",
        )
        print(f"{found[1] / found[0]:.2f}; by one {at(error, theirs) / at(error, ours):.2f}", flush=True)


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
    with multiprocessing.Pool(2) as pool:
        for size, span in SIZES:
            z0 = starts(size)
            truth = fa.integrate(model, z0, time=span, scheme=VERNER9, rtol=3e-15, atol=1e-15).z
            print(f"angles up to {size}, time {span}")
            for accuracy in ERRORS:
                for scheme in (None, GAUSS8, GAUSS16):
                    row(model, z0, truth, span, scheme, {"accuracy": accuracy})
            points = {s.name: [row(model, z0, truth, span, s, how) for how in runs] for s, runs in FIXED.items()}
            table(model, z0, span, points | others(z0, truth, span), pool)


if __name__ == "__main__":
    main()
