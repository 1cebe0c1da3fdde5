"""Close approaches with default arguments: orbits that equal steps lose are run with controlled steps."""

import numpy as np
import pytest

import fastaff as fa
from fastaff import Status

RNG = np.random.default_rng(1313)
KEPLER = fa.hamiltonian("-1/sqrt(x**2 + y**2)", coordinates="x y")


def pythagorean():
    """Masses 3, 4, 5 at the corners of the triangle with the opposite sides 3, 4, 5: Szebehely & Peters 1967."""
    masses = (3, 4, 5)
    kinetic = "+".join(f"(p{2 * k + 1}**2 + p{2 * k + 2}**2)/{2 * mass}" for k, mass in enumerate(masses))
    pairs = [(0, 1), (0, 2), (1, 2)]
    potential = "".join(
        f"-{masses[i] * masses[j]}/sqrt((x{i + 1} - x{j + 1})**2 + (y{i + 1} - y{j + 1})**2)" for i, j in pairs
    )
    return fa.hamiltonian(
        kinetic + potential, coordinates="x1 y1 x2 y2 x3 y3", momenta=" ".join(f"p{k + 1}" for k in range(6))
    )


def on_the_ellipse(e, t):
    """Return x, y of an orbit of semi-major axis 1 that starts at its aphelion (-1 - e, 0), clockwise."""
    M = (t + np.pi) % (2 * np.pi)
    low, high = np.zeros_like(M), np.full_like(M, 2 * np.pi)
    for _ in range(60):  # bisection: M - E + e sin(E) falls with E
        middle = (low + high) / 2
        late = middle - e * np.sin(middle) > M
        low, high = np.where(late, low, middle), np.where(late, middle, high)
    return np.array([np.cos(low) - e, -np.sqrt(1 - e * e) * np.sin(low)])


def test_pythagorean_three_bodies():
    model = pythagorean()
    z0 = np.array([1, 3, -2, -1, 1, -1, *[0] * 6], dtype=float)
    found = fa.integrate(model, z0, time=70.0, samples=140)
    fine = fa.integrate(model, z0, time=70.0, samples=140, scheme="VERNER9", rtol=1e-14, atol=1e-14)
    assert found.status.tolist() == [Status.OK]
    assert found.scheme.name == "VERNER9"
    assert found.energy_error[0] < 1e-10
    assert found.accurate_until[0] > 1.83  # the first close approach, where equal steps lose the energy
    apart = np.abs(found.samples - fine.samples)
    assert (apart <= found.sample_error)[:80].all()  # both are lost to chaos later on
    momenta = found.samples[:, 6:].reshape(140, 3, 2).sum(axis=1)
    assert np.abs(momenta).max() < 1e-8


@pytest.mark.slow
def test_auto_returns_on_bodies_that_are_thrown_out():
    """Its trial was one of 3880 units of time: the radians of a body that does not come back."""
    z0 = [1, 3, -2, -1, 1, -1, *[0] * 6]
    found = fa.integrate(pythagorean(), z0, time=70.0, samples=20, scheme=fa.AUTO)
    assert found.status.tolist() == [Status.OK]
    assert found.energy_error[0] < fa.AUTO.energy_error
    fine = fa.integrate(pythagorean(), z0, time=70.0, samples=20, scheme="VERNER9", rtol=1e-14, atol=1e-14)
    assert np.abs(found.samples - fine.samples)[:12].max() < 1e-3


def test_orbits_that_equal_steps_lose_are_on_the_ellipse_and_others_keep_their_bits():
    e = np.append(1 - 10 ** RNG.uniform(-9, -1, 60), RNG.uniform(0.1, 0.3))
    z0 = np.array([-1 - e, 0 * e, 0 * e, np.sqrt((1 - e) / (1 + e))])
    found = fa.integrate(KEPLER, z0, time=10.0, samples=20)
    assert (found.status == Status.OK).all()
    assert 20 < np.isinf(found.step).sum() < 61
    for k in range(61):
        apart = np.abs(found.samples[:, :2, k].T - on_the_ellipse(e[k], found.times))
        assert (apart <= found.sample_error[:, :2, k].T).all()
    alone = fa.integrate(KEPLER, z0[:, -1], time=10.0, samples=20)
    np.testing.assert_array_equal(alone.z[:, 0], found.z[:, -1])
    assert np.isfinite(alone.step).all()
    assert alone.scheme == found.scheme


@pytest.mark.parametrize("choice", [{"scheme": "BLANES_CASAS_ESCORIHUELA8"}, {"step": 0.01}])
def test_a_scheme_or_a_step_of_ones_own_is_kept(choice):
    found = fa.integrate(KEPLER, [-2.0, 0.0, 0.0, 1e-4], time=5.0, **choice)
    assert found.status.tolist() == [Status.ENERGY_DRIFT]
    assert np.isfinite(found.step).all()
