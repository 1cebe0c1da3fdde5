"""Ratios of processor time within one run, alternating, beside bounds that noise seldom reaches.

A row above its bound is a warning: it is printed and written down, and fails nothing, because machines differ. No time
is compared with a number of another machine or day. Each bound is two to two and a half times the ratio it was set for
(the number before it), 1.4 times for frequency maps, defaults, short calls and two threads, 1.3 times for first calls:
a row is silent under noise and warns when something becomes three times, or half as much, slower. A row above its bound
is measured twice more before it warns. Two threads are beside one in wall time, where there are two cores.
Run: make gate.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import json
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import cold
from common import (
    NEO,
    alternating,
    hyperelastic_orbits,
    mixed_orbits,
    naive_henon_heiles,
    naive_hyperelastic,
    neo_hookean_orbits,
)
from pages import stamp

from fastaff import (
    KAHAN_LI8,
    SALI,
    YOSHIDA4,
    AlphaTurning,
    Body,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    chaos_map,
    frequency_map,
    integrate,
    poincare_map,
)
from fastaff.engine.threads import available_threads
from fastaff.frequencies.naff import naff

BODY, PLANE = Body(Hyperelastic(1.0), 1.0), HenonHeiles()
AXIS = Hyperplane((1, 0, 0, 0))
TIME, STEP = 100.0, 0.05
ATTEMPTS = 3


def naive(kernel, z0, scheme, *parameters):
    """Return a run of a scalar loop."""
    return lambda: kernel(z0.copy(), *parameters, scheme.drift_array, scheme.kick_array, STEP, round(TIME / STEP))


def rows():
    """Return (what, measured, bound, run, beside) for each ratio of the two runs' processor times."""
    grid, flat = hyperelastic_orbits(1024), np.array([[0.0], [0.1], [0.4], [0.14]])
    many = flat + 0.01 * np.random.default_rng(2).standard_normal((4, 1024))
    run = {"time": TIME, "step": STEP}
    signals = np.exp(2j * np.pi * np.outer(np.random.default_rng(3).random(100), np.arange(4096)))
    kahan = lambda z0, model: lambda: integrate(model, z0, **run)  # noqa: E731 the runs that others are beside
    yield (
        "integrate, YOSHIDA4, body / scalar loop",
        0.18,
        0.45,
        lambda: integrate(BODY, grid, scheme=YOSHIDA4, **run),
        naive(naive_hyperelastic, grid, YOSHIDA4, 1.0, 1.0),
    )
    yield (
        "integrate, KAHAN_LI8, body / scalar loop",
        0.1,
        0.25,
        kahan(grid, BODY),
        naive(naive_hyperelastic, grid, KAHAN_LI8, 1.0, 1.0),
    )
    yield (
        "integrate, one orbit of Henon-Heiles / scalar loop",
        1.1,
        2.2,
        lambda: integrate(PLANE, flat, time=100 * TIME, step=STEP),
        lambda: naive_henon_heiles(
            flat.copy(), 1.0, KAHAN_LI8.drift_array, KAHAN_LI8.kick_array, STEP, round(100 * TIME / STEP)
        ),
    )
    yield (
        "poincare_map / integrate, body",
        1.75,
        2.5,
        lambda: poincare_map(BODY, grid, section=AlphaTurning(+1), crossings=60, max_time=TIME, step=STEP),
        kahan(grid, BODY),
    )
    yield (
        "poincare_map / integrate, Henon-Heiles",
        1.75,
        2.5,
        lambda: poincare_map(PLANE, many, section=AXIS, crossings=30, max_time=TIME, step=STEP),
        kahan(many, PLANE),
    )
    yield (
        "poincare_map / integrate, one orbit of Henon-Heiles",
        1.2,
        1.7,
        lambda: poincare_map(PLANE, flat, section=AXIS, crossings=400, max_time=20 * TIME, step=STEP, threads=1),
        lambda: integrate(PLANE, flat, time=20 * TIME, step=STEP, threads=1),
    )
    few = slice(0, 256)  # beside scalar loops, as most of the analysis is no work for vectors
    yield (
        "frequency_map, body / scalar loop",
        5.4,
        7.5,
        lambda: frequency_map(BODY, grid[:, few], **run),
        naive(naive_hyperelastic, grid[:, :32], KAHAN_LI8, 1.0, 1.0),
    )
    yield (
        "frequency_map, Henon-Heiles / scalar loop",
        2.6,
        3.7,
        lambda: frequency_map(PLANE, many[:, few], time=4 * TIME, step=STEP),
        naive(naive_henon_heiles, np.ascontiguousarray(many[:, :128]), KAHAN_LI8, 1.0),
    )
    yield (
        "chaos_map, SALI / integrate, Henon-Heiles",
        4.0,
        6.0,
        lambda: chaos_map(PLANE, many, indicators=(SALI(),), **run),
        kahan(many, PLANE),
    )
    yield (
        "naff / five FFTs of NumPy",
        0.58,
        1.3,
        lambda: naff(signals, 1.0, lines=1),
        lambda: [np.fft.fft(signals) for _ in range(5)],
    )


def defaults():
    """Return such rows: the cost of an answer with an error beside the plain run with the median of its steps, and of
    calls of a few steps beside a scalar loop of about 2 ms.
    """
    z0 = neo_hookean_orbits(24, 25)[:, :396]
    plane, one = mixed_orbits(64), np.array([0.0, 0.1, 0.35, 0.1])
    cut = {"section": AXIS, "max_time": 2000.0}
    calls = (
        (
            "poincare_map, default / plain, neo-Hookean",
            (2.45, 3.4),
            lambda **step: poincare_map(NEO, z0, section=AlphaTurning(+1), crossings=100, max_time=400.0, **step),
        ),
        (
            "poincare_map, default / plain, Henon-Heiles",
            (2.3, 3.2),
            lambda **step: poincare_map(PLANE, plane, crossings=200, **cut, **step),
        ),
        (
            "integrate, default / plain, neo-Hookean",
            (2.4, 3.4),
            lambda **step: integrate(NEO, z0, time=TIME, **step),
        ),
        (
            "chaos_map, default / plain, Henon-Heiles",
            (1.3, 1.8),
            lambda **step: chaos_map(PLANE, plane, time=4 * TIME, **step),
        ),
    )
    for what, (measured, bound), run in calls:
        found = run()
        plain = {"step": float(np.median(found.step)), "scheme": found.scheme}
        yield what, measured, bound, run, functools.partial(run, **plain)
    loop = naive_henon_heiles, one[:, None], KAHAN_LI8
    scalar = lambda: loop[0](loop[1].copy(), 1.0, KAHAN_LI8.drift_array, KAHAN_LI8.kick_array, STEP, 10_000)  # noqa: E731
    every = hyperelastic_orbits(4096)
    short = (
        ("4096 orbits of one step", 1.6, lambda: integrate(BODY, every, time=STEP, step=STEP)),
        ("one orbit, step given", 0.39, lambda: integrate(BODY, every[:, 0], time=1.0, step=STEP)),
        ("one orbit, 3 crossings, default", 2.4, lambda: poincare_map(PLANE, one, crossings=3, **cut)),
    )
    for what, measured, run in short:
        yield f"{what} / loop of 10^4 steps", measured, round(1.4 * measured, 2), run, scalar


def speed_ups():
    """Return such rows of two threads beside one, with defaults, in wall time."""
    every = mixed_orbits(250)
    calls = (
        (
            "poincare_map",
            0.62,
            lambda threads: poincare_map(PLANE, every, section=AXIS, crossings=100, max_time=1e3, threads=threads),
        ),
        ("integrate", 0.6, lambda threads: integrate(NEO, hyperelastic_orbits(1024), time=TIME, threads=threads)),
        ("chaos_map", 0.6, lambda threads: chaos_map(PLANE, every, time=8 * TIME, threads=threads)),
    )
    for what, measured, run in calls:
        yield (
            f"{what}, two threads / one",
            measured,
            round(1.4 * measured, 2),
            *(functools.partial(run, k) for k in (2, 1)),
        )


def first_calls():
    """Return rows of the first calls of a process without a cache: their compilation, beside one loop, and its size."""
    found = functools.cache(lambda attempt: cold.measured())

    def beside_loop(name, attempt):
        seconds = found(attempt)[0]
        return seconds[name][0] / seconds["loop"][0]

    for name, measured in (("section", 14.2), ("frequency map", 17.7), ("chaos map", 5.6), ("formula", 2.4)):
        bound = round(1.3 * measured, 1)
        yield f"first {name}, cold / one loop", measured, bound, functools.partial(beside_loop, name)
    yield "machine code of these, MiB", 2.3, 3.0, lambda attempt: found(attempt)[2] / 2**20


def ratio(run, beside, clock, attempt: int) -> float:
    """Return the ratio of the shortest times of alternating runs."""
    _, cost = alternating({"run": run, "beside": beside}, repeats=5, clock=clock)
    return cost["run"] / cost["beside"]


def all_rows():
    """Return all rows, as (what, the number it was set for, its bound, how an attempt measures it)."""
    timed = [(row, time.process_time) for row in itertools.chain(rows(), defaults())]
    timed += [(row, time.perf_counter) for row in speed_ups()] if available_threads() > 1 else []
    for (what, measured, bound, run, beside), clock in timed:
        yield what, measured, bound, functools.partial(ratio, run, beside, clock)
    yield from first_calls()


def measured() -> tuple[dict[str, float], dict[str, float]]:
    """Print the numbers; return them by name, and the bounds of those that are above them."""
    start = time.perf_counter()
    found: dict[str, float] = {}
    above: dict[str, float] = {}
    for what, usual, bound, measure in all_rows():
        found[what] = measure(0)
        for attempt in range(1, ATTEMPTS):
            if found[what] > bound:
                found[what] = min(found[what], measure(attempt))
        if found[what] > bound:
            above[what] = bound
        said = f"ABOVE {bound}" if what in above else f"bound {bound}"
        print(f"{what:52s} {found[what]:6.2f}   (was {usual}, {said})", flush=True)
    print(f"{time.perf_counter() - start:.0f} s")
    for what, bound in above.items():
        print(f"warning: {what}: {found[what]:.2f} is above its bound of {bound}")
    return found, above


def main() -> None:
    """Print the numbers, and write them where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--write", type=Path, metavar="FILE", help="such as bench/history/0.2.0.json")
    path, made_on = parser.parse_args().write, stamp()
    found, above = measured()
    if path:
        write(path, made_on, found, above)


def write(path: Path, made_on: dict, found: dict[str, float], above: dict[str, float]) -> None:
    """Write the numbers, and the bounds of those above them: docs/benchmarks/history.md draws those of releases."""
    rounded = {what: float(f"{ratio:.3g}") for what, ratio in found.items()}
    kept = {"machine": made_on, "ratios": rounded, "above": above}
    path.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
