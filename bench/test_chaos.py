"""Indicators of chaos: against pynamicalsys, a MEGNO map, the cost of tangent vectors. Errors beside times."""

from __future__ import annotations

import time

import numpy as np
import pytest
from common import best

import fastaff
from fastaff import GALI, MEGNO, SALI, HenonHeiles, LyapunovSpectrum, chaos_map

ORBITS, TIME, PEER_ORBITS = 1024, 1000.0, 32


def henon_heiles_orbits(orbits: int = ORBITS) -> np.ndarray:
    """Return z0 (4, orbits) on x = 0 at E = 1/8, a random choice of a grid (seed 0)."""
    axes = (np.linspace(-0.4, 0.6, 60), np.linspace(-0.45, 0.45, 60))
    z0 = fastaff.energy_grid(HenonHeiles(), energy=1 / 8, section=fastaff.Linear((1.0, 0.0, 0.0, 0.0)), axes=axes).z0
    return np.ascontiguousarray(z0[:, np.random.default_rng(0).choice(z0.shape[1], orbits, replace=False)])


def energy_error(z: np.ndarray, z0: np.ndarray) -> float:
    """Return the largest |E - E0|/(T0 + |V0|) over orbits (4, orbits)."""
    model = HenonHeiles()
    energy = [model.kinetic_energy(*s[2:]) + model.potential_energy(*s[:2]) for s in (z, z0)]
    return float(
        np.abs(
            (energy[0] - energy[1]) / (model.kinetic_energy(*z0[2:]) + np.abs(model.potential_energy(*z0[:2])))
        ).max()
    )


@pytest.mark.parametrize("what", ["SALI", "spectrum"])
def test_against_pynamicalsys(benchmark, what):
    """1024 Henon-Heiles orbits, T = 1000: pynamicalsys's faster splittings at their default and at longer steps, one
    orbit a call.

    Both warm, pynamicalsys on one core (its calls take one orbit and are serial), so its time is halved here: as if two
    processes shared the orbits without loss. No early stop.
    """
    peers = pytest.importorskip("pynamicalsys")
    z0 = henon_heiles_orbits()
    indicators = (SALI(),) if what == "SALI" else (LyapunovSpectrum(), GALI(4))
    found = benchmark.pedantic(
        lambda: chaos_map(HenonHeiles(), z0, time=TIME, step=0.2, indicators=indicators), warmup_rounds=1, rounds=5
    )
    seconds = benchmark.stats.stats.min
    print(
        f"\n{what}: fastaff KAHAN_LI8 step 0.2: {seconds:.3f} s, energy error {found.energy_error.max():.1e}, "
        f"{found.chaotic.sum()} chaotic"
    )
    for name, step in (("svy4", 0.01), ("svy4", 0.05), ("svy4", 0.1), ("vv2", 0.01)):
        system = peers.HamiltonianSystem(model="henon heiles")
        system.integrator(name, time_step=step)

        def run(o, total=TIME, system=system):
            q, p = z0[:2, o], z0[2:, o]
            return system.SALI(q, p, total, threshold=0.0) if what == "SALI" else system.lyapunov(q, p, total)

        run(0, 10.0)
        start = time.perf_counter()
        values = [run(o) for o in range(PEER_ORBITS)]
        other = (time.perf_counter() - start) * ORBITS / PEER_ORBITS / 2
        ends = np.array([system.trajectory(z0[:2, o], z0[2:, o], TIME)[-1, 1:] for o in range(PEER_ORBITS)]).T
        error = energy_error(ends, z0[:, :PEER_ORBITS])
        if what == "SALI":
            agree = np.mean([(v[-1] < 1e-7) == bool(c) for v, c in zip(values, found.chaotic[:PEER_ORBITS])])
        else:
            agree = np.mean(
                [(v[0] > limit) == bool(c) for v, limit, c in zip(values, found.limits[0], found.chaotic[:PEER_ORBITS])]
            )
        print(
            f"  pynamicalsys {name} step {step}: {other:.1f} s, energy error {error:.1e}: {other / seconds:.0f}x; "
            f"verdicts agree on {agree:.0%}"
        )


def neo_hookean_grid(cells: int) -> tuple[fastaff.Body, np.ndarray]:
    """Return the demo's body and a grid of cells x cells on its section at E = 1.5."""
    from fastaff import plot

    body, section = fastaff.Body(fastaff.NeoHookean()), fastaff.AlphaTurning()
    where = {"energy": 1.5, "p_eta": 0.3, "p_gamma": 0.2}
    axes = [
        low + (high - low) * (np.arange(cells) + 0.5) / cells for low, high in plot.edge(body, section, **where).axes
    ]
    return body, fastaff.energy_grid(body, section=section, axes=axes, **where).z0


def test_megno_map(benchmark):
    """256 x 256 cells of the neo-Hookean section over 200 natural periods: orbit-steps per second, with and without
    early stop.
    """
    from fastaff.flows.motion import typical_rate

    body, z0 = neo_hookean_grid(256)
    span = 200 * 2 * np.pi / typical_rate(body, z0)
    for early in (False, True):
        start = time.perf_counter()
        if early:
            found = chaos_map(body, z0, time=span, indicators=(MEGNO(),), early_stop=True)
        else:
            found = benchmark.pedantic(
                lambda: chaos_map(body, z0, time=span, indicators=(MEGNO(),)), warmup_rounds=0, rounds=1
            )
        seconds = time.perf_counter() - start
        steps = found.t.sum() / found.step
        print(
            f"\nMEGNO map, early stop {early}: {z0.shape[1]} orbits, T = {span:.0f}, step {found.step:.3g}: "
            f"{seconds:.1f} s, "
            f"{steps / seconds / 1e6:.1f} M orbit-steps/s with a tangent vector each; energy error "
            f"{np.median(found.energy_error):.1e} "
            f"(median), {found.energy_error.max():.1e} (largest); {found.summary()}"
        )


@pytest.mark.parametrize("name", ["henon-heiles", "neo-hookean"])
def test_cost_of_tangent_vectors(benchmark, name):
    """A pass with tangent vectors beside a plain one, for each pair of vectors."""
    if name == "henon-heiles":
        model, z0 = HenonHeiles(), henon_heiles_orbits()
    else:
        model, z0 = neo_hookean_grid(40)
    z0, size = np.ascontiguousarray(z0[:, :1024]), len(z0)
    run = {"time": 100.0, "step": 0.1}
    benchmark.pedantic(lambda: fastaff.integrate(model, z0, **run), warmup_rounds=1, rounds=10)
    plain = benchmark.stats.stats.min
    print(f"\n{name}: plain {plain * 1e3:.1f} ms")
    for count in range(2, size + 1, 2):
        deviations = np.eye(size)[:count]
        tangent = best(
            lambda deviations=deviations: fastaff.tangent_map(model, z0, deviations=deviations, **run), repeats=7
        )
        pair = 2 * (tangent / plain - 1) / count
        print(
            f"  {count} vectors: {tangent * 1e3:.1f} ms, {tangent / plain:.2f} of the plain pass, {pair:.2f} for each "
            "pair"
        )
    for indicators in ((MEGNO(),), (SALI(),), (SALI(), MEGNO(), LyapunovSpectrum())):
        seconds = best(lambda indicators=indicators: chaos_map(model, z0, indicators=indicators, **run), repeats=5)
        print(
            f"  chaos {', '.join(type(entry).__name__ for entry in indicators)}: {seconds * 1e3:.1f} ms, "
            f"{seconds / plain:.2f}"
        )
