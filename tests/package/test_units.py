"""Units of length, time and mass, the origin and the zero of V change no classification, and no number beyond rounding:
function by function.

`integrate`, `chaos_map`, `frequency_map`, periodic orbits and energy surfaces have such tests beside their others.
"""

import numpy as np
import pytest
from own_models import HenonHeilesInUnits

import fastaff as fa

PLAIN = HenonHeilesInUnits()
OTHERS = [
    HenonHeilesInUnits(**units)
    for units in (
        {"length": 1e-6},
        {"length": 1e6, "time": 1e-6},
        {"time": 1e6, "mass": 1e-6},
        {"mass": 1e6, "zero": 1e3},
        {"origin": 3.0, "time": 7e-4},
        {"length": 3e-5, "time": 2e3, "mass": 5e4, "origin": -1.5, "zero": -50.0},
    )
]
pytestmark = pytest.mark.slow
in_units = pytest.mark.parametrize("model", OTHERS, ids=str)


def points(energy, count, seed):
    """Phase points of the plane x = 0, in plain units."""
    return fa.energy_sample(
        fa.HenonHeiles(), energy=energy, section=fa.Hyperplane((1.0, 0.0, 0.0, 0.0)), orbits=count, seed=seed
    ).z0


def action(model):
    return model.energy * model.time


@in_units
@pytest.mark.parametrize(("energy", "seed", "time"), [(0.04, 3, 600.0), (0.1, 5, 600.0), (1 / 8, 2, 300.0)])
def test_tori(model, energy, seed, time):
    z0 = points(energy, 1, seed)[:, 0]
    plain, other = (
        fa.fit_torus(PLAIN, z0, time=time),
        fa.fit_torus(model, model.rows(z0[:, None])[:, 0], time=time * model.time),
    )
    assert other.classification is plain.classification
    if plain.classification is fa.Classification.REGULAR:
        np.testing.assert_array_equal(other.k.shape[0], plain.k.shape[0])
        np.testing.assert_allclose(other.nu * model.time, plain.nu, rtol=1e-9)
        np.testing.assert_allclose(other.J / action(model), plain.J, rtol=1e-7, atol=1e-9)
        assert other.nu_error.max() * model.time == pytest.approx(plain.nu_error.max(), rel=10.0)


@in_units
def test_resonances_of_frequency_maps(model):
    z0 = np.concatenate([points(0.05, 12, 1), points(0.11, 12, 2)], axis=1)
    plain = fa.frequency_map(PLAIN, z0, time=900.0)
    other = fa.frequency_map(model, model.rows(z0), time=900.0 * model.time)
    np.testing.assert_array_equal(other.classification, plain.classification)
    np.testing.assert_array_equal(other.rank, plain.rank)
    np.testing.assert_allclose(np.asarray(other.step) / model.time, plain.step, rtol=1e-9)
    first, second = (fa.resonances(f, max_order=12) for f in (plain, other))
    np.testing.assert_array_equal(second.rank, first.rank)
    np.testing.assert_array_equal(second.basis, first.basis)


@pytest.mark.parametrize("unit", [1e-6, 1e6, 3.7e-9])
def test_webs(unit):
    """A smooth map of three frequencies with an island of a resonance in it."""
    x, y = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 33), indexing="ij")
    nu = np.array([1 + 0.1 * x, 0.9 + 0.31 * y**2, 0.55 + 0.2 * x * y])
    nu[2] = np.where(np.abs(nu[2] - 0.6) < 0.02, nu[0] / 2, nu[2])
    plain, other = fa.resonance_web(nu, max_order=6), fa.resonance_web(unit * nu, max_order=6)
    assert len(plain) > 5
    assert [line.vector for line in other] == [line.vector for line in plain]
    assert any(line.locked.any() for line in plain)
    for one, two in zip(other, plain, strict=True):
        np.testing.assert_array_equal(one.locked, two.locked)
        assert len(one.lines) == len(two.lines)
        for a, b in zip(one.lines, two.lines, strict=True):
            np.testing.assert_allclose(a, b, atol=1e-9)
    ratios = fa.resonances(nu, max_order=8), fa.resonances(unit * nu, max_order=8)
    np.testing.assert_array_equal(ratios[1].basis, ratios[0].basis)


@in_units
def test_crossings_and_rotation_numbers(model):
    z0 = points(0.09, 8, 4)
    plain = fa.poincare_map(PLAIN, z0, section=PLAIN.section(), crossings=80, max_time=1000.0)
    other = fa.poincare_map(model, model.rows(z0), section=model.section(), crossings=80, max_time=1000.0 * model.time)
    np.testing.assert_array_equal(other.status, plain.status)
    np.testing.assert_array_equal(other.counts, plain.counts)
    np.testing.assert_allclose(other.times / model.time, plain.times, atol=2e-9)
    momentum = model.mass * model.length / model.time
    first = fa.rotation_number(plain.points[[1, 3]])
    rows = np.array([other.points[1] / model.length - model.origin, other.points[3] / momentum])
    second = fa.rotation_number(rows)
    np.testing.assert_allclose(second.rotation, first.rotation, atol=1e-6)
    kinds = [fa.islands(p).classification for p in (plain.points[[1, 3]], other.points[[1, 3]])]
    np.testing.assert_array_equal(*kinds)


@in_units
def test_tangent_maps(model):
    z0, factor = points(0.07, 5, 6), np.diag(model.rows(np.eye(4)) - model.rows(np.zeros((4, 4))))
    plain = fa.tangent_map(PLAIN, z0, time=30.0)
    other = fa.tangent_map(model, model.rows(z0), time=30.0 * model.time)
    np.testing.assert_array_equal(other.status, plain.status)
    np.testing.assert_allclose(other.matrix / factor[:, None, None] * factor[:, None], plain.matrix, rtol=0, atol=1e-7)


@in_units
def test_chaotic_fractions(model):
    energies, z0 = [0.05, 0.13, 0.16], {energy: points(energy, 24, 3) for energy in (0.05, 0.13, 0.16)}
    plain = fa.chaotic_fraction(lambda energy: (PLAIN, z0[energy]), [energies], time=300.0)
    other = fa.chaotic_fraction(lambda energy: (model, model.rows(z0[energy])), [energies], time=300.0 * model.time)
    assert plain.chaotic[-1] > 10 > plain.chaotic[0]
    np.testing.assert_array_equal(other.statuses, plain.statuses)
    for name in ("orbits", "chaotic", "regular", "undecided"):
        assert np.abs(getattr(other, name) - getattr(plain, name)).max() <= 1, name
