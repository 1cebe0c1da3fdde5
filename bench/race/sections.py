"""Rows of Poincaré sections: a grid of the body, a grid and one orbit of Hénon-Heiles; the error that of the times."""

from __future__ import annotations

from functools import partial

import numpy as np
from pages import version

from fastaff import BLANES_MOAN6, KAHAN_LI8, SOFRONIOU_SPALETTA10, poincare_map
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, RKN12

from .contest import Contestant, Row
from .systems import SYSTEMS, System, equations, peer_functions, true_crossings

LADDER = {
    "BLANES_MOAN6": (BLANES_MOAN6, (0.3, 0.2, 0.1, 0.07, 0.05)),
    "BLANES_CASAS_ESCORIHUELA8": (BLANES_CASAS_ESCORIHUELA8, (0.3, 0.2, 0.15, 0.1, 0.07, 0.05)),
    "KAHAN_LI8": (KAHAN_LI8, (0.1, 0.05)),
    "SOFRONIOU_SPALETTA10": (SOFRONIOU_SPALETTA10, (0.2, 0.15, 0.1, 0.088, 0.075)),
    "RKN12": (RKN12, (1.0, 0.7, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2)),
}


def ours(
    system: System, z0: np.ndarray, time: float, crossings: int, stretch: float, error, **options
) -> list[Contestant]:
    """Schemes at steps, and the accuracies that one asks for without knowing of either."""
    run = partial(poincare_map, system.model, z0, section=system.section, crossings=crossings, max_time=time, **options)
    said = "".join(f", {name}={value}" for name, value in options.items())

    def times(found):
        return error([row[np.isfinite(row)] for row in found.times.T])

    runs = {
        f"`{name}` {step * stretch:.3g}{said}": partial(run, scheme=scheme, step=step * stretch)
        for name, (scheme, steps) in LADDER.items()
        for step in steps
    }
    asked = {f"accuracy={accuracy:.0e}{said}": partial(run, accuracy=accuracy) for accuracy in (1e-6, 1e-10, 1e-12)}
    return [Contestant("fastaff", ladder, times) for ladder in (runs, asked)]


def heyoka_batches(system: System, z0: np.ndarray, time: float, error, share: float) -> Contestant:
    """heyoka's batch mode with an event whose callback stores time and state; one integrator, set anew."""
    import heyoka as hy

    width = hy.recommended_simd_size()
    system_equations, z = equations(hy, system)

    class Store:
        """The callback; the state at the event comes from the step's Taylor series."""

        rows: list = []  # noqa: RUF012 one list of all copies: integrators copy their callbacks

        def __call__(self, ta, when, sign, lane):
            ta.update_d_output(np.where(np.arange(width) == lane, when, ta.time))
            self.rows.append((lane, when, ta.d_output[:, lane].copy()))

    def make(tolerance, fast):
        event = hy.nt_event_batch(system.section.value(*z), Store(), direction=hy.event_direction.positive)
        start = z0[:, :width].copy()
        return hy.taylor_adaptive_batch(system_equations, start, tol=tolerance, nt_events=[event], fast_math=fast)

    def run(integrator):
        times: list = [[] for _ in range(z0.shape[1])]
        for i in range(0, z0.shape[1], width):
            Store.rows.clear()
            integrator.set_time(0.0)
            integrator.reset_cooldowns()
            integrator.state[:] = z0[:, i : i + width]
            integrator.propagate_until(time)
            for lane, when, _ in Store.rows:
                times[i + lane].append(when)
        return [np.array(row) for row in times]

    runs = {
        f"tol {tolerance:.0e}" + (", fast_math" if fast else ""): partial(run, make(tolerance, fast))
        for tolerance in (1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-15)
        for fast in (False, True)
    }
    return Contestant("heyoka", runs, error, share)


def heyoka_orbit(system: System, z0: np.ndarray, time: float, error) -> Contestant:
    """heyoka's scalar integrator with an event whose callback stores time and state."""
    import heyoka as hy

    system_equations, z = equations(hy, system)
    rows: list = []

    def store(ta, when, sign):
        ta.update_d_output(when)
        rows.append((when, ta.d_output.copy()))

    def make(tolerance, fast):
        event = hy.nt_event(system.section.value(*z), store, direction=hy.event_direction.positive)
        return hy.taylor_adaptive(system_equations, list(z0), tol=tolerance, nt_events=[event], fast_math=fast)

    def run(integrator):
        rows.clear()
        integrator.time = 0.0
        integrator.reset_cooldowns()
        integrator.state[:] = z0
        integrator.propagate_until(time)
        return [np.array([when for when, _ in rows])]

    runs = {
        f"tol {tolerance:.0e}" + (", fast_math" if fast else ""): partial(run, make(tolerance, fast))
        for tolerance in (1e-7, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-15)
        for fast in (False, True)
    }
    return Contestant("heyoka", runs, error)


def pynamicalsys_orbits(system: System, z0: np.ndarray, crossings: int, error, share: float) -> Contestant:
    """Its section by its splitting of order 4, an orbit a call, one crossing more: it counts the start."""
    from pynamicalsys import HamiltonianSystem

    n = system.degrees
    grad_t, grad_v = peer_functions(system)
    peer = HamiltonianSystem(grad_T=grad_t, grad_V=grad_v, degrees_of_freedom=n, number_of_parameters=0)

    def run(step):
        peer.integrator("svy4", time_step=step)
        return [peer.poincare_section(z[:n], z[n:], crossings + 1)[:, 0] for z in z0.T]

    runs = {f"svy4 {step}": partial(run, step) for step in (0.1, 0.05, 0.02, 0.01, 0.005)}
    return Contestant("pynamicalsys", runs, error, share)


def scipy_orbit(system: System, z0: np.ndarray, time: float, error) -> Contestant:
    """DOP853 with an event."""
    from scipy.integrate import solve_ivp

    n = system.degrees

    def slope(t, y):
        return [*y[n:], *(-slope for slope in system.slopes(*y[:n]))]

    def event(t, y):
        return system.section.value(*y)

    event.direction = 1.0

    def run(tolerance):
        found = solve_ivp(slope, (0.0, time), z0, method="DOP853", rtol=tolerance, atol=tolerance, events=event)
        return [found.t_events[0][found.t_events[0] > 1e-9]]

    runs = {f"`DOP853` rtol {t:.0e}": partial(run, t) for t in (1e-6, 1e-9, 1e-11, 3e-14)}
    return Contestant("SciPy", runs, error)


def difference(truth: list[np.ndarray], share: float = 0.99):
    """Return the error of lists of crossing times: a quantile over all crossings of the orbits that have a truth,
    infinite where one is missing. Programs differ in whether a start on the section is a crossing: it is left out.
    """

    def error(times):
        pairs = [(found[found > 1e-6], true) for found, true in zip(times, truth)]
        if any(found.size < true.size for found, true in pairs):
            return np.inf
        return np.quantile(np.concatenate([np.abs(f[: t.size] - t) for f, t in pairs]), share)

    return error


def grid(name: str, orbits: int, time: float, stretch: float) -> list[Contestant]:
    """Make the contestants of a grid."""
    system, slow = SYSTEMS[name], 256
    z0, truth = system.orbits(orbits), true_crossings(name, orbits, time)
    error = difference(truth)
    crossings = 2 * max(row.size for row in truth)
    found = ours(system, z0, time, crossings, stretch, error)
    found.append(heyoka_batches(system, z0[:, :slow], time, error, slow / orbits))
    if version("pynamicalsys") and name == "Hénon-Heiles":
        few = 32
        same = difference([row[: min(r.size for r in truth)] for row in truth[:few]])
        crossings = min(row.size for row in truth)
        found.append(pynamicalsys_orbits(system, z0[:, :few], crossings, same, few / orbits))
    return found


def orbit() -> list[Contestant]:
    """Make the contestants of one orbit."""
    system = SYSTEMS["Hénon-Heiles, one orbit"]
    z0, truth = system.orbits(1), true_crossings(system.name, 1, TIME, 1)
    assert truth[0].size == CROSSINGS, truth[0].size
    error = difference(truth, 1.0)
    found = [
        run for options in ({}, {"threads": 1}) for run in ours(system, z0, TIME, CROSSINGS, 1.5, error, **options)
    ]
    found += [heyoka_orbit(system, z0[:, 0], TIME, error), scipy_orbit(system, z0[:, 0], TIME, error)]
    if version("pynamicalsys"):
        found.append(pynamicalsys_orbits(system, z0, CROSSINGS, error, 1.0))
    return found


TIME, CROSSINGS = 2000.0, 306
ERROR = "error of crossing times, 99 %, against events in 80-bit arithmetic"
ROWS = [
    Row(
        "Section of 4096 orbits of EQ2.2h, turning points of alpha, T = 200",
        ERROR,
        (1e-6, 1e-9, 1e-12),
        partial(grid, "EQ2.2h", 4096, 200.0, 1.0),
        ("heyoka",),
        note="heyoka runs 256 of the orbits; pynamicalsys cuts at coordinates only",
    ),
    Row(
        "Section of 1024 orbits of Hénon-Heiles, x = 0, T = 200",
        ERROR,
        (1e-6, 1e-9, 1e-12),
        partial(grid, "Hénon-Heiles", 1024, 200.0, 2.0),
        ("heyoka", "pynamicalsys"),
        note="heyoka runs 256 of the orbits, pynamicalsys 32",
    ),
    Row(
        f"Section of one orbit of Hénon-Heiles, {CROSSINGS} crossings of x = 0, T = {TIME:g}",
        ERROR.replace("99 %", "the largest"),
        (1e-6, 1e-8, 1e-10),
        orbit,
        ("heyoka", "pynamicalsys"),
        per=("crossing", CROSSINGS),
    ),
]
