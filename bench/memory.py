"""Peak memory of calls on sets of orbits, each in a process of its own, beside their results: `python bench/memory.py`.

For each call: bytes an orbit of the result's arrays; of the peak above the memory of the process after a small call of
the same kind; and that peak in MiB.
"""

import dataclasses
import resource
import subprocess
import sys

import numpy as np

import fastaff as fa

HH, X = fa.HenonHeiles(), fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
CALLS = {
    "integrate, step": (400_000, lambda z: fa.integrate(HH, z, time=5.0, step=0.1)),
    "integrate, accuracy": (200_000, lambda z: fa.integrate(HH, z, time=5.0, accuracy=1e-8)),
    "poincare_map, step, 20 crossings": (
        40_000,
        lambda z: fa.poincare_map(HH, z, section=X, crossings=20, max_time=400.0, step=0.1),
    ),
    "poincare_map, step, 200 crossings": (
        8_000,
        lambda z: fa.poincare_map(HH, z, section=X, crossings=200, max_time=4000.0, step=0.1),
    ),
    "poincare_map, accuracy, 20 crossings": (
        100_000,
        lambda z: fa.poincare_map(HH, z, section=X, crossings=20, max_time=400.0, accuracy=1e-6),
    ),
    "frequency_map": (8_000, lambda z: fa.frequency_map(HH, z, time=100.0)),
    "chaos_map, MEGNO and SALI": (
        40_000,
        lambda z: fa.chaos_map(HH, z, time=20.0, step=0.1, indicators=(fa.MEGNO(), fa.SALI())),
    ),
}


def peak():
    """Return the largest number of bytes that this process has had."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def measure(name):
    """Print the row of one call."""
    orbits, call = CALLS[name]
    z0 = 0.1 * np.random.default_rng(1).standard_normal((4, orbits))
    call(z0[:, :300])
    before = peak()
    result = call(z0)
    taken = peak() - before
    values = (getattr(result, field.name) for field in dataclasses.fields(result))
    size = sum(value.nbytes for value in values if isinstance(value, np.ndarray))
    print(f"{name:38} {orbits:8,} {size / orbits:10,.0f} {taken / orbits:10,.0f} {taken / 2**20:8,.0f}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measure(sys.argv[1])
    else:
        print(f"{'call':38} {'orbits':>8} {'result':>10} {'peak':>10} {'MiB':>8}", flush=True)
        for name in CALLS:
            subprocess.run([sys.executable, __file__, name], check=True)
