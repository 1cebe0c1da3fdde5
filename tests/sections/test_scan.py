"""Random points of a section in its invariant measure, and chaotic fractions over parameters."""

from __future__ import annotations

import battery
import numpy as np
import pytest
import shared_systems
from own_models import Radius
from scipy import stats

import fastaff
from fastaff.core.status import Status
from fastaff.systems.models.mechanics import system_of

NEO = fastaff.Body(fastaff.NeoHookean())
HENON = fastaff.HenonHeiles()
PLANES = {"p_eta": 0.3, "p_gamma": 0.2}
X0 = fastaff.Hyperplane((1.0, 0.0, 0.0, 0.0))
SECTIONS = [
    (NEO, fastaff.AlphaTurning(+1), 1.5, PLANES),
    (NEO, fastaff.BetaTurning(-1), 1.5, PLANES),
    (NEO, fastaff.AlphaEquals(1.4), 1.5, PLANES),
    (NEO, fastaff.AreaEquals(1.0), 1.5, PLANES),
    (NEO, Radius(1.6), 1.5, PLANES),
    (HENON, X0, 0.14, {}),
]
NAMES = [type(section).__name__ for _, section, _, _ in SECTIONS]


def canonical(body, section, z):
    """Canonical coordinates (2, points) of a section, from phase points (2n, points)."""
    if body is HENON:
        return z[[1, 3]]
    a, b, pa, pb = z[:2], z[2:4], z[4:6], z[6:]
    alpha, beta = np.hypot(*a), np.hypot(*b)
    p_alpha, p_beta = (a * pa).sum(axis=0) / alpha, (b * pb).sum(axis=0) / beta
    if isinstance(section, fastaff.BetaTurning):
        return np.array([alpha, p_alpha])
    if hasattr(section, "slopes"):
        to_alpha, to_beta = section.slopes(alpha, beta)
        return np.array([beta, p_beta - to_beta / to_alpha * p_alpha])
    return np.array([beta, p_beta])


# Points


@pytest.mark.parametrize(("body", "section", "energy", "planes"), SECTIONS, ids=NAMES)
def test_points_are_on_the_surface_and_the_return_map_keeps_their_distribution(body, section, energy, planes):
    """Points and their images are samples of one distribution: two-sample tests along both coordinates and a third
    direction.
    """
    drawn = fastaff.energy_sample(body, energy=energy, section=section, orbits=1200, seed=3, **planes)
    np.testing.assert_allclose(system_of(body).energies(drawn.z0), energy, rtol=1e-9)
    assert np.abs(section.value(*drawn.z0)).max() < 1e-9
    np.testing.assert_allclose(canonical(body, section, drawn.z0), drawn.points, atol=1e-9)
    image = fastaff.poincare_map(body, drawn.z0, section=section, crossings=1, max_time=200.0)
    image.raise_if_failed()
    after = canonical(body, section, image.points[:, 0])
    for direction in ((1.0, 0.0), (0.0, 1.0), (1.0, 0.5)):
        assert stats.ks_2samp(direction @ drawn.points, direction @ after).pvalue > 1e-3


def test_points_fill_a_half_disc():
    """Harmonic body at alpha = c: beta^2 + p_beta^2 < 2 E - C c^2 with C = mu = 1, so the squared radius is uniform."""
    body = fastaff.Body(fastaff.Harmonic(C=1.0))
    drawn = fastaff.energy_sample(body, energy=2.0, section=fastaff.AlphaEquals(1.2), orbits=3000, seed=8)
    radius = np.hypot(*drawn.points) ** 2 / (4.0 - 1.2**2)
    assert radius.max() <= 1 + 1e-12
    assert stats.kstest(radius, "uniform").pvalue > 1e-3
    assert stats.kstest(np.arctan2(*drawn.points) / np.pi, "uniform").pvalue > 1e-3


def test_seeds_and_ranges():
    surface = {"energy": 1.5, "section": fastaff.AlphaTurning(), **PLANES}
    one, two, other = (fastaff.energy_sample(NEO, orbits=50, seed=seed, **surface).z0 for seed in (1, 1, 2))
    assert one.tobytes() == two.tobytes() != other.tobytes()
    part = fastaff.energy_sample(NEO, orbits=50, axes=((0.5, 0.7), (-0.1, 0.2)), **surface)
    assert (part.points[0] > 0.5).all()
    assert (part.points[0] < 0.7).all()
    assert part.z0.shape == (8, 50)
    with pytest.raises(fastaff.sections.NotReached, match="at least the minimum"):
        fastaff.energy_sample(NEO, orbits=5, **{**surface, "energy": 0.0})
    with pytest.raises(fastaff.sections.NotReached, match="less than a thousandth"):
        fastaff.energy_sample(NEO, orbits=5, axes=((5.0, 6.0), (0.0, 1.0)), **surface)
    with pytest.raises(ValueError, match="orbits must be at least 1"):
        fastaff.energy_sample(NEO, orbits=0, **surface)


# Fractions


def starts(body, energy, orbits=40, seed=5):
    section = X0 if body is HENON else fastaff.AlphaTurning()
    return fastaff.energy_sample(
        body, energy=energy, section=section, orbits=orbits, seed=seed, **({} if body is HENON else PLANES)
    ).z0


def test_henon_heiles_turns_chaotic_as_henon_and_heiles_found():
    """No chaos seen at E = 1/12, little order left at 0.16, close to the escape energy 1/6 (their figures 4 to 7)."""
    energies = [1 / 12, 0.16]
    found = fastaff.chaotic_fraction(
        lambda energy: (HENON, starts(HENON, energy, 96)), (energies,), names=("energy",), time=1500.0
    )
    assert found.fraction[0] <= 1 / 96
    assert found.interval()[0, 1] > 0.7
    assert found.done.all()
    assert (found.chaotic + found.regular + found.undecided == 96).all()
    direct = fastaff.chaos_map(HENON, starts(HENON, 0.16, 96), time=1500.0)
    assert found.chaotic[1] == direct.chaotic.sum()
    assert found.undecided[1] == direct.undecided.sum()
    np.testing.assert_array_equal(found.medians[:, 1], np.median(direct.values, axis=1))
    np.testing.assert_array_equal(found.thresholds[:, 1], np.median(direct.thresholds, axis=1))
    assert found.step[1] == np.median(direct.step)
    assert (found.bounds[0] <= found.fraction).all()
    assert (found.fraction <= found.bounds[1]).all()
    assert "192 orbits in 2 cases: " in found.summary()


def test_integrable_bodies_have_none():
    def make(C, p_gamma):
        body = fastaff.Body(fastaff.Hyperelastic(C=C))
        surface = {"energy": 3.5 * C, "section": fastaff.AlphaTurning(), "p_eta": 0.3, "p_gamma": p_gamma}
        return body, fastaff.energy_sample(body, orbits=24, **surface).z0

    axes = ([0.5, 1.0, 2.0], [0.1, 0.4])
    found = fastaff.chaotic_fraction(
        make, axes, names=("C", "p_gamma"), time=lambda body, z: 800 / body.potential.C**0.5
    )
    assert found.fraction.shape == (3, 2)
    assert (found.fraction == 0).all()
    np.testing.assert_allclose(found.time[:, 1], 800 / np.sqrt([0.5, 1.0, 2.0]))


def test_an_energy_below_the_minimum_is_an_empty_case():
    found = fastaff.chaotic_fraction(
        lambda energy: (NEO, starts(NEO, energy, 8)), ([0.05, 1.0],), names=("energy",), time=500.0
    )
    assert found.orbits.tolist() == [0, 8]
    assert np.isnan(found.fraction[0])
    assert np.isnan(found.interval()[:, 0]).all()
    assert found.fraction[1] == 0
    assert found.done.all()
    assert "1 case without accessible points" in found.summary()
    nothing = fastaff.chaotic_fraction(lambda energy: (NEO, np.zeros((8, 0))), ([1.0],), time=40.0)
    assert nothing.orbits[0] == 0


def test_lost_orbits_run_again_with_step_control():
    """At E = 8 det phi comes near exp(-8): a step of 0.02 leaves the domain, VERNER9 does not."""

    def make(energy):
        return NEO, starts(NEO, energy, 24)

    fixed = {"time": 60.0, "step": 0.02}
    plain = fastaff.chaotic_fraction(make, ([8.0],), fallback=None, **fixed)
    found = fastaff.chaotic_fraction(make, ([8.0],), **fixed)
    assert plain.failed[0] > 12
    assert found.recomputed[0] == plain.failed[0]
    assert found.failed[0] == 0
    assert found.statuses[Status.OK, 0] == 24
    assert found.energy_error[0] <= 1e-6
    adaptive = fastaff.chaos_map(NEO, make(8.0)[1], time=60.0, scheme=fastaff.VERNER9)
    assert abs(found.chaotic[0] - adaptive.chaotic.sum()) <= 2  # at 60 units some are still close to the limit
    assert "recomputed with the fallback" in found.summary()


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"axes": ([1.0], [2.0], [3.0])}, "one or two arrays"),
        ({"axes": np.ones((3, 3))}, "one or two arrays"),
        ({"axes": ([],)}, r"axes\[0\] must be a non-empty"),
        ({"axes": ([np.nan],)}, r"axes\[0\] must be a non-empty"),
        ({"axes": (["a"],)}, r"axes\[0\] must be an array"),
        ({"names": ("a", "b")}, "names must be 1"),
        ({"time": -1.0}, "time must be positive"),
        ({"time": lambda body, z: 0.0}, "time must be positive"),
        ({"fallback": fastaff.RK4}, "fallback must be an adaptive scheme"),
        ({"step": 0.0}, "step must be positive"),
    ],
)
def test_wrong_input(changed, said):
    given = {"axes": ([1.0],), "time": 10.0, **changed}
    with pytest.raises((ValueError, TypeError), match=said):
        fastaff.chaotic_fraction(lambda value: (NEO, starts(NEO, 1.0, 2)), **given)


def test_a_time_that_decides_nothing_says_so():
    found = fastaff.chaotic_fraction(lambda energy: (NEO, starts(NEO, energy, 8)), ([1.0, 1.1],), time=40.0)
    assert np.isnan(found.fraction).all()
    assert found.undecided.tolist() == [8, 8]
    assert "a longer time may decide, 100 natural periods or more" in found.summary()


def test_maps_lose_orbits_through_an_aperture_and_to_infinity():
    """None of them is done again by a scheme of systems in time."""
    rng = np.random.default_rng(0)
    makes = {
        "NONFINITE": lambda a: (shared_systems.henon(a), rng.uniform(-2, 2, (2, 40))),
        "LOST": lambda a: (fastaff.models.OneTurnMap(octupole=-0.3, aperture=a), rng.uniform(-0.6, 0.6, (4, 40))),
    }
    for name, make in makes.items():
        found = fastaff.chaotic_fraction(make, ([0.8, 1.1],), time=700)
        gone = found.statuses[fastaff.Status[name]]
        assert (gone > 3).all()
        np.testing.assert_array_equal(found.failed, gone)
        assert (found.completed > 0).all()
        assert not found.recomputed.any()
        assert f"{gone.sum()} {name} (" in found.summary()


@pytest.mark.parametrize("kind", ["in degrees", "complex64", "in percent", "in a list, masked"])
def test_what_a_case_starts_from_is_plain_numbers(kind):
    z0 = battery.astray(battery.Z4)[kind]
    with pytest.raises((TypeError, ValueError), match="z0 must"):
        fastaff.chaotic_fraction(lambda lam: (fastaff.HenonHeiles(lam), z0), ([1.0],), time=20.0, step=0.1)
