"""The body with a breathing term: motion, constants, actions and frequencies against the metric and closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import fastaff as fa
from fastaff.systems.charts import ALPHA_BETA, EULER, R_VARTHETA
from fastaff.systems.models import BreathingBody
from fastaff.systems.models.mechanics import system_of

POTENTIALS = [fa.Harmonic(1.2), fa.Anharmonic(0.8), fa.Hyperelastic(1.1), fa.HeavyTop(1.3, 0.4)]
by_potential = pytest.mark.parametrize("potential", POTENTIALS, ids=lambda V: type(V).__name__)


def states(n=12, seed=3):
    """Return random phase points (8, n), alpha around 1.5, beta around 0.6."""
    rng = np.random.default_rng(seed)
    radius, angle = np.array([rng.uniform(1.2, 1.8, n), rng.uniform(0.4, 0.8, n)]), rng.uniform(0, 2 * np.pi, (2, n))
    a, b = radius * np.cos(angle), radius * np.sin(angle)
    return np.array([a[0], b[0], a[1], b[1], *(0.5 * rng.standard_normal((4, n)))])


def drawn(seed):
    """Return random c and mu."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.8, 3.0), rng.uniform(0.5, 2.0)


@pytest.mark.parametrize("seed", range(4))
def test_energy_is_that_of_the_metric(seed):
    """EQ6.13: T = mu/2 ((1 + c) drho^2 + (rho^2/4) dsigma^2), at the velocities of the model, by the chart of Euler."""
    c, mu = drawn(seed)
    body = BreathingBody(fa.NeoHookean(K=2.0), c, mu)
    z = states()
    v = np.array(body.rates(*z)[:4])
    step = 1e-4
    ahead, behind = (EULER.from_planes(np.concatenate([z[:4] + t * v, z[4:]]))[:4] for t in (step, -step))
    here = EULER.from_planes(z)[:4]
    change = (ahead - behind + np.pi) % (2 * np.pi) - np.pi
    change[0] = (ahead - behind)[0]
    rates = change / (2 * step)
    square = np.einsum("in,ijn,jn->n", rates, EULER.metric(here), rates)
    place = EULER.names.index("rho") if "rho" in EULER.names else 0
    T = mu / 2 * (square + c * rates[place] ** 2)
    V = body.potential.value((z[:2] ** 2).sum(axis=0), (z[2:4] ** 2).sum(axis=0))
    np.testing.assert_allclose(body.energy(*z), T + V, rtol=1e-6)


@by_potential
def test_rates_are_derivatives_of_the_energy(potential):
    c, mu = drawn(11)
    body = BreathingBody(potential, c, mu)
    z = states()
    step = 1e-3
    slopes = []
    for unit in np.eye(8):
        d = step * unit[:, None]
        near, far = (body.energy(*(z + k * d)) - body.energy(*(z - k * d)) for k in (1, 2))
        slopes.append((8 * near - far) / (12 * step))
    expected = np.array([*slopes[4:], *(-row for row in slopes[:4])])
    np.testing.assert_allclose(np.array(body.rates(*z)), expected, rtol=1e-8, atol=1e-8)
    w = np.random.default_rng(1).normal(size=z.shape)
    near, far = (np.array(body.rates(*(z + k * step * w))) - np.array(body.rates(*(z - k * step * w))) for k in (1, 2))
    change = (8 * near - far) / (12 * step)
    np.testing.assert_allclose(np.array(body.tangent_rates(*z, *w)), change, rtol=1e-7, atol=1e-7)


@by_potential
def test_without_the_term_all_is_as_before(potential):
    """c = 0: the tori of `Body` to the last digit, and its orbits to the accuracy of both integrators."""
    z = states()
    body, plain = BreathingBody(potential, 0.0, 0.9), fa.Body(potential, 0.9)
    found, expected = fa.action_angles(body, z), fa.action_angles(plain, z, chart=R_VARTHETA)
    for name in ("J", "nu", "theta", "constants", "energy", "status"):
        assert np.array_equal(getattr(found, name), getattr(expected, name), equal_nan=True)
    orbits = [fa.integrate(model, z, time=20.0, accuracy=1e-12).z for model in (body, plain)]
    np.testing.assert_allclose(*orbits, atol=1e-9)


@by_potential
def test_frequencies_of_the_radius(potential):
    """V_r = C r/2: nu_r = sqrt(C/mu)/(pi sqrt(1 + c)), the actions of vartheta and both angles as without the term."""
    c, mu = drawn(5)
    z = states()
    found = fa.action_angles(BreathingBody(potential, c, mu), z)
    assert (found.status == 0).all()
    np.testing.assert_allclose(found.nu[0], np.sqrt(potential.C / mu / (1 + c)) / np.pi, rtol=1e-11)
    plain = fa.action_angles(fa.Body(potential, mu), z, chart=R_VARTHETA)
    np.testing.assert_allclose(found.J[1:], plain.J[1:], rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(found.constants[1:], plain.constants[1:], rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("seed", range(4))
def test_closed_form_of_the_anharmonic_body(seed):
    """E = omega (J_r/(pi sqrt(1 + c)) + Lambda) with Lambda = sqrt(2 mu h_vartheta) of EQb, and its derivatives."""
    c, mu = drawn(20 + seed)
    C = np.random.default_rng(seed).uniform(0.3, 2.0)
    body = BreathingBody(fa.Anharmonic(C), c, mu)
    found = fa.action_angles(body, states(seed=seed))
    omega = np.sqrt(C / mu)
    root = np.sqrt(16 * np.pi**2 * mu * C + found.J_eta**2)
    Lambda = (2 * found.J[1] + np.abs(found.J_gamma) + root) / (2 * np.pi)
    np.testing.assert_allclose(found.energy, omega * (found.J[0] / (np.pi * np.sqrt(1 + c)) + Lambda), rtol=1e-12)
    np.testing.assert_allclose(found.nu[1], omega / np.pi, rtol=1e-11)
    np.testing.assert_allclose(found.nu_eta, omega / (2 * np.pi) * found.J_eta / root, rtol=1e-10, atol=1e-14)
    np.testing.assert_allclose(found.nu_gamma, omega / (2 * np.pi) * np.sign(found.J_gamma), rtol=1e-10)
    by_actions = fa.energy_of_actions(body, found.J)
    np.testing.assert_allclose(by_actions.energy, found.energy, rtol=1e-12)
    np.testing.assert_allclose(by_actions.nu, found.nu, rtol=1e-9)


def test_actions_against_adaptive_quadrature():
    """J_r of V_r = k r/2 + 0.3 r^2: the closed integral of p_rho d rho between roots."""
    V_r = fa.models.univariate(lambda r: 0.7 * r + 0.3 * r * r, lambda r: 0.7 + 0.6 * r)
    c, mu = 1.4, 0.8
    body = BreathingBody(fa.SeparableRVartheta(V_r, fa.models.Cosine(0.6)), c, mu)
    z = states(4)
    found = fa.action_angles(body, z)
    E, h = found.constants[:2]
    for k in range(4):

        def square(x, E=E[k], h=h[k]):
            return 2 * mu * (1 + c) * (E - 0.7 * x**2 - 0.3 * x**4 - h / x**2)

        rho = np.sqrt((z[:4, k] ** 2).sum())
        ends = [brentq(square, rho, end, xtol=1e-15) for end in (1e-3, 1e2)]
        half = (ends[1] - ends[0]) / 2

        def momentum(t, square=square, half=half, middle=ends[0] + half):
            return np.sqrt(max(square(middle - half * np.cos(t)), 0.0)) * half * np.sin(t)

        assert found.J[0, k] == pytest.approx(2 * quad(momentum, 0, np.pi, epsabs=1e-13)[0], rel=1e-10)


@by_potential
def test_orbits_stay_on_their_tori(potential):
    c, mu = drawn(7)
    body = BreathingBody(potential, c, mu)
    z = states(6)
    orbit = fa.integrate(body, z, time=30.0, accuracy=1e-12)
    assert (orbit.status == 0).all()
    before, after = (fa.constants_of_motion(body, at) for at in (z, orbit.z))
    assert list(before) == ["E", "h_vartheta", "p_phi", "p_psi"]
    np.testing.assert_allclose(before["E"], body.energy(*z), rtol=1e-14)
    for name, value in before.items():
        np.testing.assert_allclose(after[name], value, atol=1e-10)
    first, last = (fa.action_angles(body, at) for at in (z, orbit.z))
    for name in ("theta_eta", "theta_gamma"):
        turned = getattr(last, name) - getattr(first, name) - 30.0 * getattr(first, name.replace("theta", "nu"))
        np.testing.assert_allclose(turned, np.rint(turned), atol=1e-8)
    turned = (last.theta - first.theta - 30.0 * first.nu)[:2]
    np.testing.assert_allclose(turned, np.rint(turned), atol=1e-8)
    np.testing.assert_allclose(fa.from_action_angles(body, first.J, first.theta), z, atol=1e-10)


def test_frequency_maps_and_fitted_tori_have_the_same_frequencies():
    body = BreathingBody(fa.Hyperelastic(1.1), 1.7, 0.9)
    z = states(3)
    tori = fa.action_angles(body, z)
    found = fa.frequency_map(body, z, time=300.0)
    assert found.names == ("r", "vartheta", "phi", "psi")
    np.testing.assert_allclose(found.nu, tori.nu, atol=1e-8)
    fit = fa.fit_torus(body, z[:, 0], time=200.0)
    np.testing.assert_allclose(fit.J[:2], tori.J[:2, 0], rtol=1e-6)


def test_sections_of_a_body_that_does_not_separate():
    body = BreathingBody(fa.NeoHookean(K=2.0), 0.6, 1.3)
    z = np.array([1.5, 0.0, 0.2, 0.0, 0.0, 0.3, 0.1, 0.1])
    found = fa.poincare_map(body, z, section="b2=0", crossings=10, max_time=400.0)
    points = found.points[:, : found.counts[0], 0]
    assert points.shape[1] == 10
    np.testing.assert_allclose(points[3], 0.0, atol=1e-11)
    np.testing.assert_allclose(body.energy(*points), body.energy(*z), rtol=1e-9)
    for i in (0, 2):
        spins = points[i] * points[i + 5] - points[i + 1] * points[i + 4]
        np.testing.assert_allclose(spins, z[i] * z[i + 5] - z[i + 1] * z[i + 4], atol=1e-9)
    assert system_of(body).conserves_spins
    assert not system_of(body).isotropic
    indicators = fa.chaos_map(body, z, time=50.0)
    assert indicators.status[0] == 0


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda z: fa.integrate(BreathingBody(fa.Harmonic(), -1.0), z, time=1.0), ValueError, "c must be above -1"),
        (lambda z: fa.action_angles(BreathingBody(fa.Harmonic(), -2.0), z), ValueError, "c must be above -1"),
        (lambda z: fa.integrate(BreathingBody(fa.Harmonic(), np.nan), z, time=1.0), ValueError, "not finite"),
        (lambda z: fa.integrate(BreathingBody(fa.Harmonic(), "c"), z, time=1.0), TypeError, "BreathingBody.c"),
        (
            lambda z: fa.integrate(BreathingBody(fa.Harmonic(), 1.0, 0.0), z, time=1.0),
            ValueError,
            "mu must be positive",
        ),
        (lambda z: fa.integrate(BreathingBody(3.0, 1.0), z, time=1.0), TypeError, "potential must be a NamedTuple"),
        (lambda z: fa.integrate(BreathingBody(fa.models.Zero(), 1.0), z, time=1.0), TypeError, "potential of A and B"),
        (lambda z: fa.action_angles(BreathingBody(fa.NeoHookean(), 1.0), z), ValueError, "separable in r and vartheta"),
        (lambda z: fa.action_angles(BreathingBody(fa.Harmonic(), 1.0), z, chart=ALPHA_BETA), ValueError, "r-vartheta"),
        (lambda z: fa.reduced_body(BreathingBody(fa.Harmonic(), 1.0), p_eta=0.1, p_gamma=0.1), TypeError, "Body"),
    ],
)
def test_bad_input(call, error, words):
    with pytest.raises(error, match=words):
        call(states(1)[:, 0])
