"""Families of orbits: against the sign of the angular momentum, and closed forms."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.frequencies import OrbitFamily, orbit_families

GALAXY = fa.hamiltonian("v0**2/2*log(Rc**2 + x**2 + y**2/q**2)", v0=1.0, Rc=0.14, q=0.7)


def senses(model, z0, time):
    """The sign of L along each orbit; 0 where it changes."""
    run = fa.integrate(model, z0, time=time, samples=4000, accuracy=1e-6)
    x, y, p_x, p_y = run.samples.transpose(1, 0, 2)
    L = x * p_y - y * p_x
    return np.where((L > 0).all(axis=0), 1, np.where((L < 0).all(axis=0), -1, 0))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_loops_are_the_orbits_whose_angular_momentum_keeps_its_sign(seed):
    """Logarithmic potentials drawn at random: no loop, box or resonant orbit is taken for another."""
    rng = np.random.default_rng(seed)
    q, core, energy = rng.uniform(0.6, 0.95), rng.uniform(0.05, 0.3), rng.uniform(-0.3, 0.5)
    model = GALAXY._replace(q=q, Rc=core)
    starts = fa.energy_sample(model, energy=energy, section="y=0", orbits=60, seed=seed)
    found = orbit_families(fa.frequency_map(model, starts.z0, time=500.0))
    known = np.isin(found.family, (OrbitFamily.BOX, OrbitFamily.LOOP, OrbitFamily.RESONANT))
    assert known.sum() > 35
    np.testing.assert_array_equal(found.sense[known], senses(model, starts.z0, 200.0)[known])
    assert {-1, 0, 1} == set(found.sense[known])
    np.testing.assert_allclose(found.energy, energy, atol=1e-9)
    ratio = found.nu[1] / found.nu[0]
    for orbit in np.flatnonzero(found.family == OrbitFamily.RESONANT):
        up, down = map(int, found.label(orbit).removeprefix("resonant ").split(":"))
        assert abs(ratio[orbit] - up / down) < 1e-3
    assert (found.turns[found.family == OrbitFamily.LOOP] * found.sense[found.family == OrbitFamily.LOOP] > 0.9).all()


def test_oscillators_have_the_families_of_their_frequencies():
    """Uncoupled oscillators: commensurable lines, or none; motion along an axis."""
    a = np.array([[0.3, 0.2, 0.0, 0.1], [0.3, 0.0, 0.1, 0.0]]).T
    for ratio, expected in ((2.0, "resonant 2:1"), (1.5, "resonant 3:2"), (np.sqrt(2), "box")):
        model = fa.hamiltonian("(x**2 + w**2*y**2)/2", w=ratio)
        found = orbit_families(fa.frequency_map(model, a, time=400.0))
        assert [found.label(0), found.label(1)] == [expected, "axial"]
        assert found.radius[1] == 0.3


def test_orbits_of_one_frequency_that_do_not_circulate_are_resonant():
    """Equal frequencies without coupling: x and y in phase swing on a line, a quarter apart they go round."""
    z0 = np.array([[0.3, 0.2, 0.0, 0.0], [0.3, 0.0, 0.0, 0.2], [0.3, 0.0, 0.0, -0.2]]).T
    model = fa.hamiltonian("(x**2 + w**2*y**2)/2", w=1.0)
    found = orbit_families(fa.frequency_map(model, z0, time=400.0))
    assert [found.label(k) for k in range(3)] == ["resonant 1:1", "loop +", "loop -"]
    assert found.table() == [("loop +", 1), ("loop -", 1), ("resonant 1:1", 1)]
    np.testing.assert_allclose(found.angular_momentum, [0.0, 0.06, -0.06], atol=1e-15)


def test_tubes_of_three_coordinates_are_named_by_their_axis():
    model = fa.hamiltonian("log(0.01 + x**2 + y**2/0.81 + z**2/0.49)/2", coordinates="x y z")
    z0 = np.array([[0.5, 0.0, 0.1, 0.0, 0.9, 0.1], [0.1, 0.0, 0.5, 0.1, -0.9, 0.0], [0.7, 0.1, 0.2, 0.1, 0.1, 0.1]]).T
    found = orbit_families(fa.frequency_map(model, z0, time=400.0))
    labels = [found.label(k) for k in range(3)]
    assert labels[:2] == ["z tube +", "x tube +"]
    assert not labels[2].endswith(("+", "-"))


def test_a_part_of_a_map_does_not_know_its_model_and_says_no_sense():
    nu = fa.frequency_map(GALAXY._replace(q=0.9), [[0.5, 0.6], [0.0, 0.0], [0.0, 0.8], [0.9, 0.1]], time=300.0)
    assert orbit_families(nu).label(0) == "loop +"
    part = orbit_families(nu[:1])
    assert part.label(0) == "resonant 1:1"
    assert np.isnan(part.energy).all()
    whole = orbit_families(nu)
    assert [family.label(0) for family in (whole[0:1], whole[1:2])] == [whole.label(0), whole.label(1)]


def test_wrong_input_is_refused():
    nu = fa.frequency_map(GALAXY, [0.6, 0.0, 0.1, 0.9], time=300.0)
    with pytest.raises(ValueError, match="max_order must be"):
        orbit_families(nu, max_order=1)
    with pytest.raises(TypeError, match="frequency_map must be a FrequencyMap"):
        orbit_families(np.ones((2, 3)))
    round_about = fa.frequency_map(GALAXY, [0.6, 0.0, 0.1, 0.9], time=300.0, signals="R phi")
    with pytest.raises(ValueError, match="two or three Cartesian coordinates, got R, phi"):
        orbit_families(round_about)
