"""Orbits that leave through a saddle are ESCAPED, whatever number overflowed first; others that overflow are not."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.core.status import Status

HENON = fa.HenonHeiles()
CUBIC = fa.hamiltonian("x**2/2 - k*x**3/3", coordinates="x", k=1.0)


def starts(energy, count=40):
    return fa.energy_sample(
        HENON, energy=energy, section="x=0", axes=((-0.45, 0.75), (-0.58, 0.58)), orbits=count, seed=4
    ).z0


WAYS = {
    "its own step": {},
    "leapfrog": {"step": 0.1, "scheme": "LEAPFROG"},
    "a step": {"step": 0.1, "scheme": "KAHAN_LI8"},
    "adaptive": {"scheme": "DOP853"},
}


@pytest.mark.parametrize("way", WAYS)
def test_orbits_beyond_a_saddle_have_escaped_by_every_scheme(way):
    """They were NONFINITE wherever a fixed step overflowed before the radius was seen."""
    found = fa.integrate(HENON, starts(0.18), time=1000.0, **WAYS[way])
    left = found.status == Status.ESCAPED
    assert left.mean() > 0.8
    assert not (found.status == Status.NONFINITE).any()


def test_all_verbs_say_so():
    z = starts(0.18, 20)
    for found in (
        fa.poincare_map(HENON, z, section="x=0", crossings=300, max_time=1000.0),
        fa.chaos_map(HENON, z, time=600.0),
        fa.frequency_map(HENON, z, time=600.0),
    ):
        assert (found.status == Status.ESCAPED).sum() > 10
        assert not (found.status == Status.NONFINITE).any()


def test_orbits_of_any_units_and_one_alone():
    random = np.random.default_rng(16)
    for _ in range(8):
        length, k = 10 ** random.uniform(-8, 8), 10 ** random.uniform(-3, 3)
        model = CUBIC._replace(k=k / length)
        saddle = length / k
        z = [[1.0001 * saddle, 1.5 * saddle], [0.0, 0.2 * saddle]]
        assert (fa.integrate(model, z, time=60.0).status == Status.ESCAPED).all()
        assert (fa.integrate(model, [0.9 * saddle, 0.0], time=60.0).status == Status.OK).all()


def test_what_a_step_makes_unstable_has_not_escaped():
    """Orbits below the saddle stay inside: an overflow is the step's."""
    found = fa.integrate(HENON, starts(0.1), time=200.0, step=3.0, scheme="KAHAN_LI8")
    assert (found.status == Status.NONFINITE).sum() > 20
    assert (found.status == Status.ESCAPED).sum() < 5


def test_the_status_does_not_depend_on_company_or_threads():
    z = starts(0.18, 12)
    together = fa.integrate(HENON, z, time=500.0, threads=1)
    two = fa.integrate(HENON, z[:, ::-1], time=500.0, threads=2)
    np.testing.assert_array_equal(together.status, two.status[::-1])
    for k in range(0, 12, 4):
        assert fa.integrate(HENON, z[:, k], time=500.0).status[0] == together.status[k]
