"""Rows of end states: 4096 orbits of each system, the error that of the whole state against 80-bit arithmetic."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from common import batched
from pages import version

from fastaff import BLANES_MOAN6, DOP853, KAHAN_LI8, SOFRONIOU_SPALETTA10, YOSHIDA4, integrate
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, RKN12

from .contest import Contestant, Row
from .systems import CHECKED, SYSTEMS, System, equations, peer_functions, true_states

ORBITS = 4096
TOLERANCES = (*(part * 10.0**-k for k in range(5, 16) for part in (10.0, 3.0)), 1e-15)
CARRIED = replace(BLANES_CASAS_ESCORIHUELA8, increments=True)
LADDER = {
    "YOSHIDA4": (YOSHIDA4, (0.2, 0.1)),
    "BLANES_MOAN6": (BLANES_MOAN6, (0.6, 0.5, 0.4, 0.3, 0.2, 0.17, 0.15, 0.14, 0.12, 0.1, 0.07, 0.05)),
    "BLANES_CASAS_ESCORIHUELA8": (BLANES_CASAS_ESCORIHUELA8, (0.4, 0.3, 0.2, 0.17, 0.15, 0.12, 0.1, 0.085, 0.07)),
    "BLANES_CASAS_ESCORIHUELA8, carried": (CARRIED, (0.085, 0.07, 0.06, 0.05, 0.04)),
    "KAHAN_LI8": (KAHAN_LI8, (0.2, 0.1, 0.07)),
    "SOFRONIOU_SPALETTA10": (SOFRONIOU_SPALETTA10, (0.3, 0.2, 0.15, 0.12, 0.1, 0.088, 0.075, 0.06)),
    "RKN12": (RKN12, (1.0, 0.7, 0.5, 0.45, 0.4, 0.36, 0.33, 0.3, 0.28, 0.25, 0.22, 0.2, 0.18, 0.16, 0.14, 0.12)),
}
"""Schemes with their steps; `carried` carries rounding errors on."""


def ours(system: System, z0: np.ndarray, time: float, error) -> list[Contestant]:
    """All schemes at all steps, an adaptive one, and the accuracies that one asks for without knowing of either."""
    run = partial(integrate, system.model, z0, time=time)
    stretch = {"EQ2.2h": 1.0, "neo-Hookean": 1.0, "Hénon-Heiles": 2.0}[system.name]  # the plane orbits are slower
    runs = {
        f"`{name}` {step * stretch:.3g}": partial(run, scheme=scheme, step=step * stretch)
        for name, (scheme, steps) in LADDER.items()
        for step in steps
    }
    adaptive = {
        f"`DOP853` rtol {tolerance:.0e}": partial(run, scheme=DOP853, step=0.1, rtol=tolerance, atol=tolerance)
        for tolerance in (1e-6, 1e-10, 1e-13)
    }
    asked = {f"accuracy={accuracy:.0e}": partial(run, accuracy=accuracy) for accuracy in (1e-6, 1e-9, 1e-12)}
    return [Contestant("fastaff", ladder, lambda found: error(found.z)) for ladder in (runs, adaptive, asked)]


def heyoka_batches(system: System, z0: np.ndarray, time: float, error) -> list[Contestant]:
    """heyoka's batch mode, vectors of eight: its ensemble, which copies the integrator for each batch, and one
    integrator that is set anew for each, with and without fast_math.
    """
    import heyoka as hy

    width = hy.recommended_simd_size()

    def make(tolerance, **options):
        return hy.taylor_adaptive_batch(equations(hy, system)[0], z0[:, :width].copy(), tol=tolerance, **options)

    def start(integrator, i):
        integrator.set_time(0.0)
        integrator.state[:] = z0[:, i * width : (i + 1) * width]
        return integrator

    def ensemble(integrator):
        runs = hy.ensemble_propagate_until_batch(integrator, time, z0.shape[1] // width, start, algorithm="thread")
        return np.concatenate([run[0].state for run in runs], axis=1)

    runs = {}
    for tolerance in TOLERANCES:
        runs[f"tol {tolerance:.0e}"] = partial(batched, make(tolerance), z0, time)
        runs[f"tol {tolerance:.0e}, fast_math"] = partial(batched, make(tolerance, fast_math=True), z0, time)
    runs["tol 1e-15, high_accuracy"] = partial(batched, make(1e-15, high_accuracy=True), z0, time)
    copies = {f"tol {t:.0e}": partial(ensemble, make(t)) for t in (1e-6, 1e-9, 1e-12, 1e-15)}
    return [Contestant("heyoka", runs, error), Contestant("heyoka, ensemble", copies, error)]


def scipy_system(system: System, z0: np.ndarray, time: float, error) -> Contestant:
    """DOP853 on some orbits as one system, which NumPy then evaluates for all at once."""
    from scipy.integrate import solve_ivp

    orbits, n = 512, system.degrees
    start = np.ascontiguousarray(z0[:, :orbits])

    def slope(t, y):
        z = y.reshape(2 * n, orbits)
        return np.concatenate([z[n:], -np.array(system.slopes(*z[:n]))]).ravel()

    def run(tolerance):
        found = solve_ivp(slope, (0.0, time), start.ravel(), method="DOP853", rtol=tolerance, atol=tolerance)
        return found.y[:, -1].reshape(2 * n, orbits)

    runs = {f"`DOP853` rtol {t:.0e}": partial(run, t) for t in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 3e-14)}
    return Contestant("SciPy", runs, error, share=orbits / z0.shape[1])


def pynamicalsys_orbits(system: System, z0: np.ndarray, time: float, error) -> Contestant:
    """Its splitting of order 4, an orbit a call; it keeps the trajectory."""
    from pynamicalsys import HamiltonianSystem

    orbits, n = 16, system.degrees
    grad_t, grad_v = peer_functions(system)
    peer = HamiltonianSystem(grad_T=grad_t, grad_V=grad_v, degrees_of_freedom=n, number_of_parameters=0)

    def run(step):
        peer.integrator("svy4", time_step=step)
        ends = [peer.trajectory(z0[:n, o], z0[n:, o], time)[-1] for o in range(orbits)]
        return np.array(ends)[:, 1:].T

    runs = {f"svy4 {step}": partial(run, step) for step in (0.1, 0.05, 0.02, 0.01, 0.005, 0.002)}
    return Contestant("pynamicalsys", runs, error, share=orbits / z0.shape[1])


def gala_orbits(system: System, z0: np.ndarray, time: float, error) -> Contestant:
    """gala's compiled integrators with its own Hénon-Heiles potential, the last state kept."""
    import gala.dynamics as dynamics
    import gala.integrate as integrators
    import gala.potential as potentials
    from gala.units import dimensionless

    model = potentials.Hamiltonian(potentials.HenonHeilesPotential(units=dimensionless))
    start = dynamics.PhaseSpacePosition(z0[:2], z0[2:])

    def run(integrator, step, **options):
        options = {"Integrator": integrator, "Integrator_kwargs": options, "save_all": False}
        end = model.integrate_orbit(start, dt=step, n_steps=round(time / step), **options)
        return np.concatenate([end.pos.xyz.value[:, -1], end.vel.d_xyz.value[:, -1]])

    runs = {
        f"`DOPRI853` rtol {t:.0e}": partial(run, integrators.DOPRI853Integrator, time / 50, rtol=t, atol=t)
        for t in (1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-15)
    }
    runs |= {f"`Ruth4` {step}": partial(run, integrators.Ruth4Integrator, step) for step in (0.2, 0.1, 0.05)}
    return Contestant("gala", runs, error)


def contestants(name: str, time: float) -> list[Contestant]:
    """Make the contestants of a row."""
    system = SYSTEMS[name]
    z0, truth = system.orbits(ORBITS), true_states(name, ORBITS, time)

    def error(z):
        checked = min(CHECKED, z.shape[1])
        off = np.abs(z[:, :checked] - truth[:, :checked]).max(axis=0)
        return np.quantile(off, 0.99) if np.isfinite(off).all() else np.inf

    found = [*ours(system, z0, time, error), *heyoka_batches(system, z0, time, error)]
    found.append(scipy_system(system, z0, time, error))
    if version("pynamicalsys"):
        found.append(pynamicalsys_orbits(system, z0, time, error))
    if version("gala") and name == "Hénon-Heiles":
        found.append(gala_orbits(system, z0, time, error))
    return found


ROWS = [
    Row(
        f"End states of {ORBITS} orbits of {name}, T = {time:g}",
        f"largest error of a coordinate or momentum, 99 % of {CHECKED} orbits, against 80-bit arithmetic",
        (1e-4, 1e-6, 1e-9, 1e-12, last),
        partial(contestants, name, time),
        ("heyoka", "pynamicalsys") + (("gala",) if name == "Hénon-Heiles" else ()),
    )
    for name, time, last in (
        ("EQ2.2h", 200.0, 1e-13),
        ("EQ2.2h", 50.0, 1e-14),
        ("neo-Hookean", 50.0, 1e-14),
        ("Hénon-Heiles", 50.0, 1e-14),
    )
]
