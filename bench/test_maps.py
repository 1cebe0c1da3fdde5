"""Maps: bare iterates, tunes and diffusion streamed, rotation numbers and indicators beside pynamicalsys.

Errors stand beside times; ratios are of processor time in one process. Run: pytest bench/test_maps.py -s
"""

import numpy as np
import pytest
from common import alternating

import fastaff as fa
from fastaff.systems.models import HenonMap, OneTurnMap, StandardMap

ORBITS = 1000


def cost(run):
    """The least processor time of three runs, and their result."""
    found, seconds = alternating({"run": run}, repeats=3)
    return seconds["run"], found["run"]


def golden(count=ORBITS):
    """Orbits of the standard map that wind: on rotational curves, mostly."""
    return np.array([np.full(count, np.pi), np.linspace(2.2, 3.0, count)])


@pytest.mark.parametrize(
    "model", [StandardMap(0.6), HenonMap(), OneTurnMap(octupole=-0.3)], ids=lambda m: type(m).__name__
)
def test_bare_iterates(numbers, model):
    n = model.degrees_of_freedom
    z = np.random.default_rng(1).uniform(-0.1, 0.1, (2 * n, 10_000))
    taken, found = cost(lambda: fa.integrate(model, z, time=10_000))
    assert (found.status == 0).all()
    numbers["ns_an_iterate"] = taken / 1e8 * 1e9


@pytest.mark.parametrize("window", [256, 512, 1024])
def test_tunes_and_diffusion_streamed(numbers, window):
    """10,000 particles, 100,000 turns of the 4-D Henon map: bare iteration over tunes and diffusion of both ends."""
    rng = np.random.default_rng(0)
    r, angle = 0.25 * np.sqrt(rng.uniform(0, 1, 10_000)), rng.uniform(0, 2 * np.pi, 10_000)
    z, model = np.array([r * np.cos(angle), r * np.sin(angle), 0 * r, 0 * r]), OneTurnMap(0.28, 0.31, -0.3)
    bare, _ = cost(lambda: fa.integrate(model, z, time=100_000))
    taken, found = cost(lambda: fa.frequency_map(model, z, time=100_000, window=window))
    numbers.update(
        rate=1e9 / taken,
        of_bare_iteration=bare / taken,
        median_error=np.median(found.error),
        largest_diffusion=found.diffusion.max(),
    )


def peer(K):
    """The standard map of pynamicalsys, whose coordinates are turns: x/2 pi, p/2 pi with K."""
    pynamicalsys = pytest.importorskip("pynamicalsys")
    system = pynamicalsys.DiscreteDynamicalSystem(model="standard map")
    system.set_parameters(K)
    return system


def test_rotation_numbers_beside_pynamicalsys(numbers):
    turns, z, some = 5000, golden(), 50
    exact = fa.frequency_map(StandardMap(0.3), z, time=100_000)
    known = exact.error[0] < 1e-12
    system = peer(0.3)
    points = z.T[:: ORBITS // some] / (2 * np.pi)
    theirs, found = cost(lambda: [system.rotation_number(point, turns) for point in points])
    off = np.abs((np.array(found) - exact.nu[0, :: ORBITS // some] + 0.5) % 1.0 - 0.5)
    numbers.update(pynamicalsys_us=theirs / some * 1e6, pynamicalsys_error=np.median(off))
    for count in (100, 200, 400, turns):
        taken, ours = cost(lambda count=count: fa.frequency_map(StandardMap(0.3), z, time=count))
        numbers[f"{count}_turns_us"] = taken / ORBITS * 1e6
        numbers[f"{count}_turns_error"] = np.median(np.abs(ours.nu - exact.nu)[0, known])


@pytest.mark.parametrize("what", ["SALI", "spectrum"])
def test_indicators_beside_pynamicalsys(numbers, what):
    turns, some = 5000, 20
    z = np.random.default_rng(2).uniform(-np.pi, np.pi, (2, ORBITS))
    indicator = fa.SALI() if what == "SALI" else fa.LyapunovSpectrum()
    taken, found = cost(lambda: fa.chaos_map(StandardMap(1.5), z, time=turns, indicators=indicator))
    system = peer(1.5)
    points = z.T[:some] / (2 * np.pi)
    run = (lambda p: system.SALI(p, turns, tol=0.0)) if what == "SALI" else (lambda p: system.lyapunov(p, turns))
    theirs, exponents = cost(lambda: [run(point) for point in points])
    numbers.update(us=taken / ORBITS * 1e6, pynamicalsys_us=theirs / some * 1e6, said=found.summary())
    if what == "spectrum":
        numbers["difference"] = np.abs(np.array(exponents)[:, 0] - found.spectrum[0, :some]).max()
