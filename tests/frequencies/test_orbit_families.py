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


def test_parts_of_a_map_have_the_families_of_the_whole():
    rng = np.random.default_rng(4)
    z0 = np.concatenate([rng.uniform(0.2, 0.7, (2, 12)), rng.uniform(-0.9, 0.9, (2, 12))])
    nu = fa.frequency_map(GALAXY, z0, time=300.0)
    whole = orbit_families(nu)
    assert 0 < (whole.family == OrbitFamily.LOOP).sum() < 12
    odd = np.arange(12) % 2 == 1
    for part, numbers in ((nu[3:9], range(3, 9)), (nu[odd][[4, 0]], (9, 1)), (nu[::-1][2], (9,))):
        found = orbit_families(part)
        assert [found.label(k) for k in range(len(part))] == [whole.label(k) for k in numbers]
        np.testing.assert_array_equal(found.energy, whole.energy[list(numbers)])
    assert [whole[k : k + 1].label(0) for k in range(12)] == [whole.label(k) for k in range(12)]


def test_loops_of_samples_are_named_once_the_model_is_given():
    galaxy = GALAXY._replace(q=0.9)
    z0 = np.array([[0.5, 0.6], [0.0, 0.0], [0.0, 0.8], [0.9, 0.1]])
    nu = fa.frequency_map(galaxy, z0, time=300.0)
    samples = fa.integrate(galaxy, z0, time=300.0, samples=3000, accuracy=1e-10)
    for given in (fa.orbit_frequencies(samples), type(nu).concat([nu[:1], nu[1:]])):
        found = orbit_families(given)
        assert found.label(0) == "loop or resonant 1:1"
        assert "give both" in found.summary()
        assert np.isnan(found.energy).all()
        named = orbit_families(given, model=galaxy, z0=z0)
        assert named.label(0) == "loop +"
        np.testing.assert_array_equal(named.energy, orbit_families(nu).energy)


def test_resonances_of_the_dominant_lines_count_loops():
    rng = np.random.default_rng(5)
    z0 = np.concatenate([rng.uniform(0.2, 0.7, (2, 40)), rng.uniform(-0.9, 0.9, (2, 40))])
    nu = fa.frequency_map(GALAXY, z0, time=300.0)
    found = fa.resonances(nu)
    assert found.lines.names == found.names
    equal = (np.abs(found.lines.basis[0]) == 1).all(axis=0) & (found.lines.rank == 1)
    loops = orbit_families(nu).family == OrbitFamily.LOOP
    assert loops.sum() > 5
    assert equal[loops].all()
    assert found.rank[loops].max() == 0  # two independent frequencies
    assert "resonance of the dominant lines" in str(found)
    assert f"{np.count_nonzero(found.lines.rank)} orbits with resonant dominant lines" in found.summary()
    assert fa.resonances(nu.nu, errors=nu.error).lines is None
    np.testing.assert_array_equal(found[loops].lines.rank, 1)


def test_wrong_input_is_refused():
    nu = fa.frequency_map(GALAXY, [0.6, 0.0, 0.1, 0.9], time=300.0)
    with pytest.raises(ValueError, match="max_order must be"):
        orbit_families(nu, max_order=1)
    with pytest.raises(TypeError, match="frequency_map must be a FrequencyMap"):
        orbit_families(np.ones((2, 3)))
    with pytest.raises(ValueError, match="model and z0 must be given together"):
        orbit_families(nu, model=GALAXY)
    with pytest.raises(ValueError, match=r"z0 must have shape \(4, 1\), got \(4, 2\)"):
        orbit_families(nu, model=GALAXY, z0=np.ones((4, 2)))
    turns = fa.frequency_map(fa.models.OneTurnMap(nu_x=0.28, nu_y=0.31), [[0.1], [0.1], [0.0], [0.0]], time=200)
    with pytest.raises(ValueError, match="frequency_map must be of a system in time, got that of a map"):
        orbit_families(turns)
    round_about = fa.frequency_map(GALAXY, [0.6, 0.0, 0.1, 0.9], time=300.0, signals="R phi")
    with pytest.raises(ValueError, match="two or three Cartesian coordinates, got R, phi"):
        orbit_families(round_about)
