"""`fastaff warmup`: compile everything once."""

from __future__ import annotations

import time as clock

from ..progress import compiled


def warmup() -> int:
    """Compile everything once, into the cache folder, and print the times.

    Needed only to keep the first command of a new version short: each compiles the kernels that it uses.
    """
    import fastaff

    from ...engine.code_folder import cache_directory

    body = fastaff.Body(fastaff.NeoHookean())
    z0 = fastaff.energy_grid(
        body, energy=1.5, section=fastaff.AlphaTurning(), axes=([0.6, 0.7], [0.0]), p_eta=0.3, p_gamma=0.2
    ).z0
    jobs = {
        "integrate": lambda: fastaff.integrate(body, z0, time=1.0, step=0.05, samples=2),
        "integrate, adaptive": lambda: fastaff.integrate(body, z0, time=1.0, scheme=fastaff.DOP853),
        "poincare": lambda: fastaff.poincare_map(
            body, z0, section=fastaff.AlphaTurning(), crossings=2, max_time=20.0, step=0.05
        ),
        "tangent to a section": lambda: fastaff.poincare_map(
            fastaff.HenonHeiles(0.0),
            [0.0, 1.0, 0.0, 0.0],
            section=fastaff.Hyperplane((0, 1, 0, 0), offset=0.99995),
            crossings=1,
            max_time=20.0,
            step=0.1,
        ),
        "frequency-map": lambda: fastaff.frequency_map(body, z0, time=10.0, step=0.05),
        "chaos-map": lambda: fastaff.chaos_map(body, z0, time=10.0, step=0.05),
        "chaos-map, steep walls": lambda: fastaff.chaos_map(body, z0, time=10.0, scheme=fastaff.VERNER9),
        "time of return": lambda: fastaff.poincare_map(
            body, z0, section=fastaff.AlphaTurning(), crossings=2, max_time=20.0, scheme=fastaff.VERNER9
        ),
    }
    total = 0.0
    for name, job in jobs.items():
        start = clock.perf_counter()
        compiled(job, announce=False)
        seconds = clock.perf_counter() - start
        total += seconds
        print(f"{name:<24}{seconds:6.1f} s", flush=True)
    print(f"{'together':<24}{total:6.1f} s, kept in {cache_directory()}")
    return 0
