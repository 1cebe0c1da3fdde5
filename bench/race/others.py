"""Rows of indicators of chaos, tori, frequency maps and of a first start."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from functools import partial

import naive
import numpy as np
from common import energy_error, henon_heiles_orbits, hyperelastic_orbits
from pages import version

import fastaff
from fastaff import (
    BLANES_MOAN6,
    KAHAN_LI8,
    SALI,
    Body,
    HenonHeiles,
    Hyperelastic,
    LyapunovSpectrum,
    action_angles,
    chaos_map,
    frequency_map,
)
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8

from .contest import Contestant, Row
from .systems import SYSTEMS, equations

TIME = 1000.0
CELLS = 96
"""Cells along each axis of the frequency map; --cells 512 takes minutes."""


def indicators(what: str) -> list[Contestant]:
    """1024 orbits of Hénon-Heiles; pynamicalsys takes 16 of them, an orbit a call, no early stop."""
    z0 = henon_heiles_orbits()
    values = (SALI(),) if what == "SALI" else (LyapunovSpectrum(),)
    run = partial(chaos_map, HenonHeiles(), z0, time=TIME, indicators=values)
    ladder = {BLANES_MOAN6: (0.8, 0.6, 0.4, 0.3), BLANES_CASAS_ESCORIHUELA8: (0.5, 0.3, 0.2), KAHAN_LI8: (0.4, 0.2)}
    runs = {f"`{s.name}` {step}": partial(run, scheme=s, step=step) for s, steps in ladder.items() for step in steps}
    found = [Contestant("fastaff", runs, lambda result: result.energy_error.max())]
    if version("pynamicalsys"):
        from pynamicalsys import HamiltonianSystem

        orbits, peer = 16, HamiltonianSystem(model="henon heiles")

        def theirs(step):
            peer.integrator("svy4", time_step=step)
            for z in z0.T[:orbits]:
                if what == "SALI":
                    peer.SALI(z[:2], z[2:], TIME, threshold=0.0)
                else:
                    peer.lyapunov(z[:2], z[2:], TIME)
            return step

        def error(step):
            peer.integrator("svy4", time_step=step)
            ends = np.array([peer.trajectory(z[:2], z[2:], TIME)[-1, 1:] for z in z0.T[:orbits]]).T
            return energy_error(ends, z0[:, :orbits])

        runs = {f"svy4 {step}": partial(theirs, step) for step in (0.2, 0.1, 0.05, 0.02)}
        found.append(Contestant("pynamicalsys", runs, error, orbits / z0.shape[1]))
    return found


def tori(potential) -> list[Contestant]:
    """Make the one contestant of tori: 100 000 random states, against quadratures of SciPy on 500 of them."""
    body = Body(potential)
    z = naive.states(body, 100_000)
    truth = naive.frequencies(body, z[:, :500])

    def error(found):
        nu = np.array([*found.nu[:2], found.nu_eta, found.nu_gamma])[:, :500]
        return np.nanquantile((np.abs(nu - truth) / np.abs(truth).max(axis=0)).max(axis=0), 0.99)

    return [Contestant("fastaff", {"`action_angles`": partial(action_angles, body, z)}, error)]


def combinations(truth: np.ndarray, largest: int) -> np.ndarray:
    """Return integer combinations (count, orbits) of the frequencies (n, orbits), integers up to `largest`."""
    whole = np.arange(-largest, largest + 1)
    integers = np.array(np.meshgrid(*[whole] * len(truth), indexing="ij")).reshape(len(truth), -1).T
    return integers @ truth


def frequencies() -> list[Contestant]:
    """Orbits of EQ2.2h over 200: frequencies by fastaff, and lines of a1 + i a2 of heyoka's samples by nafflib."""
    z0 = hyperelastic_orbits(1024)
    body, time, checked = Body(Hyperelastic(1.0), 1.0), 200.0, 64
    truth = naive.frequencies(body, z0[:, :checked])
    scale = np.abs(truth).max(axis=0)

    def error(found):
        nu = np.array([*found.nu[:2], found.nu_eta, found.nu_gamma])[:, :checked]
        return np.quantile((np.abs(nu - truth) / scale).max(axis=0), 0.9)

    run = partial(frequency_map, body, z0, time=time)
    runs = {"step 0.1": partial(run, step=0.1), "step 0.05": partial(run, step=0.05), "as it comes": run}
    found = [Contestant("fastaff", runs, error)]
    if version("nafflib"):
        import heyoka as hy
        import nafflib

        orbits, width, samples = 64, hy.recommended_simd_size(), 4096
        start = z0[:, :width].copy()
        times = np.linspace(0.0, time, samples)
        grid = np.repeat(times[:, None], width, axis=1)
        peer = hy.taylor_adaptive_batch(equations(hy, SYSTEMS["EQ2.2h"])[0], start, tol=1e-13)

        def lines(order):
            rates = []
            for i in range(0, orbits, width):
                peer.set_time(0.0)
                peer.state[:] = z0[:, i : i + width]
                path = peer.propagate_grid(grid)[1]
                for q in ((0, 1), (2, 3)):
                    signals = (path[:, q[0]] + 1j * path[:, q[1]]).T
                    rates += [nafflib.naff(s, num_harmonics=3, window_order=order)[1] / times[1] for s in signals]
            return np.array(rates).reshape(-1, 2, width, 3).transpose(1, 3, 0, 2).reshape(6, orbits)

        def nearest(rates):
            known = combinations(truth, 3)
            distance = np.abs(rates[:, None, :] - known[None]).min(axis=1)
            return np.quantile((distance[[0, 3]] / scale).max(axis=0), 0.9)

        runs = {f"nafflib, window order {p}": partial(lines, p) for p in (1, 2, 4)}
        found.append(Contestant("heyoka + nafflib", runs, nearest, orbits / z0.shape[1]))
    return found


MAP = """
import time
import numpy as np
import fastaff as fa
from fastaff import plot
from fastaff.runs.scales import typical_rate

body, section = fa.Body(fa.NeoHookean()), fa.AlphaTurning()
where = {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2}
axes = [low + (high - low) * (np.arange(CELLS) + 0.5) / CELLS for low, high in plot.edge(body, section, **where).axes]
grid = fa.energy_grid(body, section=section, axes=axes, **where)
fa.frequency_map(body, grid.z0[:, :2], time=50.0)
span = 100 * 2 * np.pi / typical_rate(body, grid.z0)
wall, cpu = time.perf_counter(), time.process_time()
found = fa.frequency_map(body, grid.z0, time=span)
wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
status = open("/proc/self/status").read()  # ru_maxrss would begin with that of the process which started this one
peak = float(status.split("VmHWM:")[1].split()[0]) / 2**20
good = found.regular
error = found.error[:, good].max(axis=0) / np.abs(found.nu[:, good]).max(axis=0)
print(grid.z0.shape[1], good.sum(), np.median(error), cpu, wall, peak)
"""


def in_process(code: str, **environment: str) -> tuple[str, float, float]:
    """Run code in a process of its own; return its output, its processor time and the elapsed time."""
    import time

    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, env={**os.environ, **environment}
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.stdout, cpu, time.perf_counter() - start


def map_of_a_grid(cells: int = CELLS) -> dict:
    """Return the cost of a frequency map of a grid of the neo-Hookean body over 100 periods, end to end."""
    orbits, regular, error, cpu, wall, peak = map(float, in_process(f"CELLS = {cells}\n{MAP}")[0].split())
    named = {"cells": cells, "orbits": int(orbits), "regular": int(regular), "median_error_estimate": error}
    return {**named, "cpu": cpu, "wall": wall, "peak_GiB": peak}


FASTAFF = """
import numpy as np, fastaff
z0, model = np.array([0.0, 0.1, 0.4, 0.14]), fastaff.HenonHeiles()
m = fastaff.poincare_map(model, z0, section=fastaff.Hyperplane((1, 0, 0, 0)), crossings=20, max_time=200.0)
"""
STARTS = {
    "fastaff: first section": FASTAFF,
    "fastaff: first section and frequency map": FASTAFF + "fastaff.frequency_map(model, z0, time=200.0)",
    "heyoka: first section": """
import heyoka as hy
x, y, u, v = hy.make_vars("x", "y", "u", "v")
found = []
event = hy.nt_event(x, lambda ta, t, sign: found.append(t), direction=hy.event_direction.positive)
system = [(x, u), (y, v), (u, -x - 2.0 * x * y), (v, -y - x * x + y * y)]
hy.taylor_adaptive(system, [0.0, 0.1, 0.4, 0.14], nt_events=[event]).propagate_until(200.0)
""",
    "pynamicalsys: first section": """
import numpy as np
from pynamicalsys import HamiltonianSystem
HamiltonianSystem(model="henon heiles").poincare_section(np.array([0.0, 0.1]), np.array([0.4, 0.14]), 20)
""",
    "nafflib: first frequencies": """
import numpy as np, nafflib
nafflib.naff(np.exp(0.1j * np.arange(4096)), num_harmonics=3)
""",
}


def starts() -> dict[str, dict]:
    """Return the times of processes that start with nothing compiled, and again with the cache of the first one."""
    found = {}
    for name, code in STARTS.items():
        if version(name.split(":")[0]) is None:
            continue
        with tempfile.TemporaryDirectory() as folder:  # of mode 700, as the cache asks
            keep = {"FASTAFF_CACHE_DIR": folder, "NUMBA_CACHE_DIR": folder}
            (_, cold, cold_wall), (_, warm, warm_wall) = in_process(code, **keep), in_process(code, **keep)
        found[name] = {"cold": cold, "cold_wall": cold_wall, "warm": warm, "warm_wall": warm_wall}
    return found


ROWS = [
    *(
        Row(
            f"{what} of 1024 orbits of Hénon-Heiles, T = {TIME:g}",
            "largest energy error, relative to the kinetic energy",
            (1e-4, 1e-6, 1e-8, 1e-10),
            partial(indicators, what),
            ("pynamicalsys",),
            note="pynamicalsys runs 16 of the orbits; no early stop",
        )
        for what in ("SALI", "Lyapunov spectrum")
    ),
    *(
        Row(
            f"Tori of 100000 states, {type(potential).__name__}",
            "relative error of the frequencies, 99 %, against quadrature",
            (),
            partial(tori, potential),
            (),
            note="none of the peers finds them",
            per=("state", 100_000),
        )
        for potential in (Hyperelastic(), fastaff.Anharmonic(), fastaff.HeavyTop(1.0, 0.5))
    ),
    Row(
        "Frequencies of 1024 orbits of EQ2.2h, T = 200",
        "relative to the largest frequency, 90 % of 64 orbits, against quadrature",
        (1e-6, 1e-8),
        frequencies,
        ("nafflib",),
        note="fastaff: the four fundamental frequencies; heyoka + nafflib: the leading line of each plane, 64 orbits",
        per=("orbit", 1024),
    ),
]
