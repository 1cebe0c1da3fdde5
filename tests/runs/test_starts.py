"""Starts where one point says nothing of the motion: centres, saddles, axes, turning points, no force, no velocity."""

import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff.runs.scales import motion
from fastaff.systems.models.mechanics import system_of

WELL = (
    "k*(a*(x/L)**2/2 + b*(y/L)**2/2 + c*(x**4 + y**4)/(4*L**4) + d*(x*y)**2/(2*L**4) + e*(x**2 + y**2)**3/(6*L**6))",
    {
        "quartic": (0, 0, 1, 0.3, 0),
        "sextic": (0, 0, 0, 0, 1),
        "saddle": (-1, 1, 1, 0.4, 0),
        "hill": (-1, -0.6, 1, 0.2, 0),
    },
)
OTHERS = {
    "degree 2.5": "k*((x/L)**2 + 0.7*(y/L)**2)**1.25",
    "flat": "k*(1 - exp(-(x/L)**4 - (y/L)**4))",
    "core": "k*log(0.01 + (x/L)**2 + (y/L)**2/0.81)/2",
    "pendulums": "k*(2 - cos(x/L) - cos((x + y)/L))",
}


def system(name, k, L):
    """One of the potentials in units of energy and length; masses are 1."""
    if name in OTHERS:
        return fa.hamiltonian(OTHERS[name], k=k, L=L)
    return fa.hamiltonian(WELL[0], k=k, L=L, **dict(zip("abcde", map(float, WELL[1][name]))))


def special(rng, k, L):
    """Starts at the centre, on axes and diagonals, moving and at rest, with and without a component that vanishes."""
    p, turn = np.sqrt(k), rng.uniform(0, 2 * np.pi)
    slow, fast = rng.uniform(0.1, 0.3), rng.uniform(0.3, 0.6)
    starts = [
        (0, 0, fast, 0),
        (0, 0, 0, slow),
        (0, 0, fast * np.cos(turn), fast * np.sin(turn)),
        (1e-9, 0, fast, slow),
        (0, -1e-200, fast, slow),
        (fast, 0, 0, 0),
        (0, slow, 0, 0),
        (slow, slow, 0, 0),
        (slow, 0, fast, 0),
        (slow, 0, 0, fast),
        (1, 0, 0, slow),
        (1, 1, slow, 0),
        (0, 0, 0, 0),
        tuple(rng.normal(scale=0.3, size=4)),
    ]
    return np.array(starts, float).T * np.array([[L], [L], [p], [p]])


@pytest.mark.parametrize("name", [*WELL[1], *OTHERS])
def test_states_from_special_starts_are_within_their_errors(name):
    rng = np.random.default_rng(len(name))
    for k, L in ((1.0, 1.0), 10.0 ** rng.uniform(-8, 8, 2)):
        model, z0 = system(name, k, L), special(rng, k, L)
        if name == "degree 2.5":  # whose domain has no centre
            z0[0] += 1e-12 * L * ((z0[0] == 0) & (np.abs(z0[1]) < 1e-99 * L))
        time = 40.0 * L / np.sqrt(k)
        found = fa.integrate(model, z0, time=time)
        assert (found.status == fa.Status.OK).all(), found.summary()
        truth = fa.integrate(model, z0, time=time, scheme=fa.schemes.VERNER9, rtol=1e-14, atol=1e-14)
        other = fa.integrate(model, z0, time=time, scheme=fa.schemes.DOP853, rtol=1e-14, atol=1e-14)
        unsure = 3 * np.abs(truth.z - other.z).max(axis=1, keepdims=True) + 1e-12 * np.abs(z0).max(
            axis=1, keepdims=True
        )
        scales = motion(system_of(model), z0)
        apart = np.abs(found.z - truth.z) / (found.error + unsure)
        assert apart.max() < 5, z0[:, apart.max(axis=0).argmax()]
        assert np.median(scales.distance(found.error)) < 1e-9


def test_all_analyses_take_the_centre_of_a_quartic_potential():
    """The residue from a start a billionth away; the same frequencies, classifications and crossings as from there."""
    model = fa.hamiltonian(WELL[0], k=1.0, L=1.0, a=0.0, b=0.0, c=1.0, d=0.3, e=0.0)
    z0 = np.array([[0, 0, 1, 0], [1e-9, 0, 1, 0], [0, 0, 0.8, 0.6], [1e-9, 1e-9, 0.8, 0.6]]).T
    orbits = fa.periodic_orbits(model, z0[:, :2], section="x=0")
    np.testing.assert_allclose(orbits.residue, 0.97009187, atol=1e-8)
    cut = fa.poincare_map(model, z0[:, 2:], section="y=0", crossings=20, max_time=500.0)
    np.testing.assert_allclose(cut.points[:, :, 0], cut.points[:, :, 1], atol=1e-6)
    nu = fa.frequency_map(model, z0, time=800.0)
    assert nu.regular.all()
    np.testing.assert_allclose(nu.nu[:, ::2], nu.nu[:, 1::2], atol=1e-7)
    chaos = fa.chaos_map(model, z0, time=900.0)
    assert chaos.regular.all()
    np.testing.assert_allclose(chaos.megno[::2], chaos.megno[1::2], atol=1e-3)
    assert (fa.tangent_map(model, z0, time=10.0).status == fa.Status.OK).all()


def test_orbits_at_rest_in_an_equilibrium_stay_there():
    """To the last digits: their energies, and their natural scales, are rounding."""
    body, z0 = fa.Body(fa.NeoHookean(G=1.0, K=2.0)), np.zeros((8, 3))
    z0[0] = np.sqrt(2), np.nextafter(np.sqrt(2), 2), np.sqrt(2) + 1e-9
    found = fa.integrate(body, z0, time=50.0)
    assert (found.status == fa.Status.OK).all()
    assert (np.abs(found.z - z0)[:, :2] <= found.error[:, :2]).all()
    assert found.error.max() < 1e-11
    # The triangular points of the restricted problem of three bodies, in their turning frame.
    m = 0.01215
    text = "-(1 - m)/sqrt((x + m)**2 + y**2) - m/sqrt((x - 1 + m)**2 + y**2)"
    model, rest = fa.hamiltonian(text, m=m, rotation=1.0), np.array([0.5 - m, np.sqrt(3) / 2, -np.sqrt(3) / 2, 0.5 - m])
    found = fa.integrate(model, rest, time=50.0)
    assert (found.status == fa.Status.OK).all()
    assert np.abs(found.z[:, 0] - rest).max() < 1e-11


def test_a_branch_starts_on_its_symmetry_axis():
    """The straight orbit of Henon-Heiles, with x = p_x = 0 to the last bit, to within 1e-7 of the saddle's energy."""
    bounds = (0.05, 1 / 6 - 1e-7)
    branch = fa.continuation(fa.HenonHeiles(), [0, 0, 0, np.sqrt(0.2)], section="y=0", bounds=bounds, max_steps=300)
    assert branch.parameter[-1] == bounds[1]
    assert len(branch.bifurcations) == 14
    assert branch.summary().endswith("14 bifurcations; ended at the bound 0.166667")
    short = fa.continuation(fa.HenonHeiles(), [0, 0, 0, np.sqrt(0.2)], section="y=0", bounds=bounds, max_steps=3)
    assert "after its 3 steps" in short.summary()


def test_free_motion_turns_nowhere():
    """x = x0 + p t of a driven oscillator without a spring, and of the plane: there is no reach."""
    driven = fa.hamiltonian("d*x**2 + q*cos(2*t)*x**2", coordinates="x", drive_period="pi", d=0.0, q=0.0)
    points = fa.poincare_map(driven, np.eye(2), section="t=0", crossings=1).points
    np.testing.assert_allclose(points[[0, 2], 0], [[1.0, np.pi], [0.0, 1.0]], atol=1e-12)
    plane = fa.hamiltonian("k*(x**2 + y**2)", k=0.0)
    z = fa.integrate(plane, [0.0, 1.0, 0.5, -2.0], time=10.0).z[:, 0]
    np.testing.assert_allclose(z, [5.0, -19.0, 0.5, -2.0], rtol=1e-12)


def walls(rng, orbits):
    """Systems with steep walls and small cores, and starts in them."""
    one = np.ones(orbits)
    draw = rng.normal(size=(6, orbits))
    kepler = [one, 0 * one, rng.uniform(-0.3, 0.3, orbits), rng.uniform(0.4, 1.2, orbits)]
    return {
        "Toda": (fa.hamiltonian("exp(x) + exp(y - x) + exp(z - y) + exp(-z) - 4", coordinates="x y z"), draw),
        "Calogero": (
            fa.hamiltonian("(x**2 + y**2)/2 + g/(x - y)**2", g=0.5, domain="x - y"),
            np.concatenate([rng.uniform([[1], [-2]], [[2], [-1]], (2, orbits)), draw[:2]]),
        ),
        "Morse": (fa.hamiltonian("(1 - exp(-x))**2 + 2*(1 - exp(-0.7*y))**2"), 0.4 * draw[:4]),
        "core": (shared_systems.galaxy(core=0.1), 0.6 * draw[:4]),
        "Kepler": (fa.hamiltonian("-1/sqrt(x**2 + y**2)"), np.array(kepler)),
    }


@pytest.mark.parametrize("name", ["Toda", "Calogero", "Morse", "core", "Kepler"])
def test_no_orbit_within_its_accuracy_drifts_and_errors_cover_at_any_accuracy(name):
    """99 % of the errors within the estimates, none ten times beyond, from coarse to fine."""
    rng = np.random.default_rng(len(name) + 20)
    model, z0 = walls(rng, 60)[name]
    truth = fa.integrate(model, z0, time=60.0, scheme=fa.schemes.VERNER9, rtol=1e-14, atol=1e-14)
    other = fa.integrate(model, z0, time=60.0, scheme=fa.schemes.DOP853, rtol=1e-14, atol=1e-14)
    scales, ratios = motion(system_of(model), z0), []
    for accuracy in (1e-3, 1e-4, 1e-6, 1e-8, 1e-10):
        found = fa.integrate(model, z0, time=60.0, accuracy=accuracy)
        assert (found.status == fa.Status.OK).all(), (accuracy, found.summary())
        true, error = (scales.distance(each) for each in (found.z - truth.z, found.error))
        known = error > 5 * scales.distance(truth.z - other.z)
        ratios.append((true / error)[known])
    ratios = np.concatenate(ratios)
    assert ratios.size > 150
    assert np.mean(ratios <= 1) >= 0.99
    assert ratios.max() < 10


def test_the_energy_tolerance_follows_the_accuracy_unless_it_is_given():
    rng = np.random.default_rng(3)
    model, z0 = walls(rng, 40)["Toda"]
    found = fa.integrate(model, z0, time=60.0, accuracy=1e-3)
    assert (found.energy_error > 1e-6).any()
    assert (found.status == fa.Status.OK).all()
    strict = fa.integrate(model, z0, time=60.0, accuracy=1e-3, energy_tolerance=1e-6)
    assert (strict.energy_error[strict.status == fa.Status.OK] <= 1e-6).all()


def test_a_flow_that_runs_away_ever_faster_ends():
    """Rabinovich & Fabrikant 1979, with parameters that let most orbits go: steps shrink without end."""
    model = fa.ode("x' = y*(z - 1 + x**2) + g*x; y' = x*(3*z + 1 - x**2) + g*y; z' = -2*z*(a + x*y)", a=1.1, g=0.87)
    z0 = np.random.default_rng(1).uniform(-1, 1, (3, 3))
    found = fa.integrate(model, z0, time=1e4, rtol=1e-9)
    assert np.isin(found.status, (fa.Status.OK, fa.Status.STEP_TOO_SMALL, fa.Status.NONFINITE)).all()
    assert (found.status == fa.Status.STEP_TOO_SMALL).any()
    assert np.isfinite(found.z).all()
