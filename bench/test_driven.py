"""Driven systems beside natural ones of the same force, and beside heyoka (make peers).

Run: pytest bench/test_driven.py -s
"""

from __future__ import annotations

import time

import numpy as np
import pytest
from common import ORBITS, alternating

from fastaff import KAHAN_LI8, SOFRONIOU_SPALETTA10, hamiltonian, integrate
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, RKN12

STEPS, STEP = 250, 0.05
WAVES = "-cos(x) - a*cos(x - {t})"
DUFFING = "-x**2/2 + x**4/4 - a*x*cos({t})"
PAIRS = {
    "pendulum and a wave": (WAVES, "y", WAVES),
    "Duffing": (DUFFING, "y", DUFFING),
    "pendulum and a wave, at rest": (WAVES, None, "-cos(x) - a*cos(x - 0.3)"),
}
"""The potential of a driven system; the coordinate that stands for its time in a natural one with the same force, None
where that has one degree of freedom; the natural potential."""


@pytest.mark.parametrize("name", PAIRS)
def test_as_fast_as_a_natural_system(numbers, name):
    """Steps/s of both, in turns, and the energy errors after 250 steps: at least 0.8 of the natural one's."""
    text, other, natural = PAIRS[name]
    driven = hamiltonian(text.format(t="t"), coordinates="x", drive_period="2*pi", a=0.05)
    plain = hamiltonian(natural.format(t=other), coordinates="x" if other is None else "x y", a=0.05)
    rng = np.random.default_rng(1)
    z0 = {"driven": np.array([rng.uniform(-1, 1, ORBITS), rng.uniform(-0.5, 0.5, ORBITS)])}
    rest = np.zeros(ORBITS)
    rows = z0["driven"] if other is None else np.array([z0["driven"][0], rest, z0["driven"][1], rest + 1.0])
    z0["natural"] = rows
    run = {"time": STEP * STEPS, "step": STEP, "scheme": KAHAN_LI8}
    runs = {
        "driven": lambda: integrate(driven, z0["driven"], **run),
        "natural": lambda: integrate(plain, z0["natural"], **run),
    }
    found, shortest = alternating(runs, repeats=25, clock=time.perf_counter)
    numbers.update(
        speed=shortest["natural"] / shortest["driven"],
        rate=ORBITS * STEPS / shortest["driven"],
        energy_error=found["driven"].energy_error.max(),
        natural_error=found["natural"].energy_error.max(),
    )


BESIDE = {
    "Duffing, T = 10": ("-x**2/2 + x**4/4 - a*x*cos(w*t)", 0.3125, 1.25, 10.0),
    "driven pendulum, T = 50": ("-cos(x) - a*cos(x - w*t)", 0.0625, 1.5, 50.0),
}
"""Potential, amplitude and rate of the drive, time: numbers without rounding errors, the same for both programs."""
CHECKED, GOAL = 64, 1e-13
LADDER = {
    KAHAN_LI8: (0.1, 0.05),
    BLANES_CASAS_ESCORIHUELA8: (0.15, 0.1, 0.05, 0.03),
    SOFRONIOU_SPALETTA10: (0.3, 0.2, 0.15, 0.1),
    RKN12: (0.5, 0.42, 0.36, 0.3, 0.25, 0.2, 0.16, 0.12),
}


@pytest.mark.parametrize("name", BESIDE)
def test_beside_heyoka(numbers, name):
    """Processor time of the cheapest run of each program with errors below 1e-13, against 80-bit arithmetic."""
    hy = pytest.importorskip("heyoka")
    text, a, w, time = BESIDE[name]
    rng = np.random.default_rng(1)
    z0 = np.array([rng.uniform(-1, 1, ORBITS), rng.uniform(-0.5, 0.5, ORBITS)])
    x, v = hy.make_vars("x", "v")
    duffing = "x**4" in text
    force = x - x * x * x + a * hy.cos(w * hy.time) if duffing else -hy.sin(x) - a * hy.sin(x - w * hy.time)
    equations, extended, width = [(x, v), (v, force)], np.longdouble, hy.recommended_simd_size()
    exact = hy.taylor_adaptive(equations, [extended(1)] * 2, tol=extended(1e-19), fp_type=extended)
    truth = np.empty((2, CHECKED))
    for orbit in range(CHECKED):
        exact.time, exact.state[:] = extended(0), z0[:, orbit]
        exact.propagate_until(extended(time))
        truth[:, orbit] = exact.state

    def theirs(peer):
        end = np.empty_like(z0)
        for i in range(0, ORBITS, width):
            peer.set_time(0.0)
            peer.state[:] = z0[:, i : i + width]
            peer.propagate_until(time)
            end[:, i : i + width] = peer.state
        return end

    model = hamiltonian(text, coordinates="x", drive_period="2*pi/w", a=a, w=w)
    ours = lambda **how: integrate(model, z0, time=time, **how)  # noqa: E731
    runs = {
        f"fastaff {scheme.name} {step}": lambda scheme=scheme, step=step: ours(scheme=scheme, step=step).z[[0, 2]]
        for scheme, steps in LADDER.items()
        for step in steps
    }
    runs["fastaff accuracy=1e-13"] = lambda: ours(accuracy=1e-13).z[[0, 2]]
    for tol in (1e-11, 1e-12, 1e-13, 1e-14, 1e-15):
        peer = hy.taylor_adaptive_batch(equations, z0[:, :width].copy(), tol=tol)
        runs[f"heyoka tol {tol:.0e}"] = lambda peer=peer: theirs(peer)
    found, cost = alternating(runs, repeats=5)
    errors = {how: float(np.abs(z[:, :CHECKED] - truth).max()) for how, z in found.items()}
    least = {}
    for program in ("fastaff", "heyoka"):
        good = [how for how in runs if how.startswith(program) and errors[how] <= GOAL]
        how = least[program] = min(good, key=cost.get)
        numbers.update({program: how, f"{program}_ms": 1e3 * cost[how], f"{program}_error": errors[how]})
    numbers["ratio"] = cost[least["heyoka"]] / cost[least["fastaff"]]
    run = ours(accuracy=1e-13)
    assert min(errors.values()) <= GOAL
    assert (np.abs(run.z[[0, 2], :CHECKED] - truth) <= run.error[[0, 2], :CHECKED]).mean() >= 0.98
