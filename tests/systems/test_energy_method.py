"""`model.energy(*z)` of every system with an energy, against H written here anew."""

import numpy as np
import pytest
from naive import MODELS, energy, label, states

import fastaff as fa

RNG = np.random.default_rng(52)
Z4 = RNG.uniform(-0.6, 0.6, (4, 3, 5))


def _cubic(x, y):
    return (x * x + y * y) / 2 + x * x * y - y**3 / 3


PLANE = "(x**2 + y**2)/2 + x**2*y - y**3/3"


def _turned(rate):
    def H(x, y, p_x, p_y):
        return (p_x**2 + p_y**2) / 2 + _cubic(x, y) - rate * (x * p_y - y * p_x)

    return H


def _magnetic(x, y, p_x, p_y):
    return ((p_x + 0.4 * y) ** 2 + (p_y - 0.4 * x) ** 2) / 2 + _cubic(x, y)


SYSTEMS = {
    "plane": (fa.hamiltonian(PLANE), _turned(0.0)),
    "masses": (
        fa.hamiltonian(PLANE, masses=[2.0, 0.5]),
        lambda x, y, p_x, p_y: p_x**2 / 4 + p_y**2 + _cubic(x, y),
    ),
    "frame": (fa.hamiltonian(PLANE, rotation=0.7), _turned(0.7)),
    "field": (fa.hamiltonian(PLANE, magnetic=0.8), _magnetic),
    "friction": (fa.hamiltonian(PLANE, friction=0.1), _turned(0.0)),
    "drive": (
        fa.hamiltonian("-(1 + 0.2*cos(t))*cos(x)", coordinates="x", drive_period="2*pi"),
        lambda x, t, p, p_t: p**2 / 2 - (1 + 0.2 * np.cos(t)) * np.cos(x) + p_t,
    ),
    "momenta": (
        fa.hamiltonian(f"sqrt(1 + p_x**2) + p_y**2/2 + {PLANE}", momenta="p_x p_y"),
        lambda x, y, p_x, p_y: np.sqrt(1 + p_x**2) + p_y**2 / 2 + _cubic(x, y),
    ),
    "coupled": (
        fa.hamiltonian("(x**2 + P**2)*(y**2 + Q**2 + 1)/2", coordinates="x y", momenta="P Q"),
        lambda x, y, p, q: (x**2 + p**2) * (y**2 + q**2 + 1) / 2,
    ),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_energy_of_a_text_is_its_hamiltonian(name):
    model, H = SYSTEMS[name]
    np.testing.assert_allclose(model.energy(*Z4), H(*Z4), rtol=1e-14, atol=1e-15)
    assert model.energy(*Z4[:, 0, 0]) == pytest.approx(H(*Z4[:, 0, 0]), rel=1e-14)


@pytest.mark.parametrize("model", MODELS, ids=label)
def test_energy_of_a_model_is_kinetic_and_potential_energy(model):
    z = states(model, 20)
    np.testing.assert_allclose(model.energy(*z), energy(model, z), rtol=1e-15)


def test_energy_of_the_other_classes_of_models_is_that_of_the_body():
    body = fa.Body(fa.NeoHookean(G=0.8, K=2.3), mu=1.2)
    p_eta, p_gamma = 0.3, -0.2
    reduced = fa.reduced_body(body, p_eta=p_eta, p_gamma=p_gamma)
    alpha, beta, p_alpha, p_beta = 1.5, 0.4, 0.2, 0.1
    # a = (alpha, 0) with momentum (p_alpha, p_eta/alpha), b likewise.
    z = [alpha, 0.0, beta, 0.0, p_alpha, p_eta / alpha, p_beta, p_gamma / beta]
    assert reduced.energy(alpha, beta, p_alpha, p_beta) == pytest.approx(body.energy(*z), rel=1e-14)
    cloud = fa.models.Body3(fa.models.GasCloud(k=0.2, gamma=2.0, C=0.3), mu=1.4)
    z = np.concatenate([np.eye(3).ravel(), np.linspace(-0.2, 0.3, 9)])
    assert cloud.energy(*z) == pytest.approx(cloud.kinetic_energy(*z[9:]) + cloud.potential_energy(*z[:9]), rel=1e-14)


def test_the_energy_of_an_orbit_is_conserved():
    model = SYSTEMS["frame"][0]
    orbit = fa.integrate(model, [0.1, 0.1, 0.2, 0.0], time=20.0, samples=5, accuracy=1e-10)
    rows = np.moveaxis(orbit.samples, 1, 0)
    assert np.ptp(model.energy(*rows)) < 1e-9


def test_energy_is_nan_outside_the_domain_and_maps_have_none():
    assert np.isnan(fa.hamiltonian("log(x) + y**2").energy(-1.0, 0.0, 0.0, 0.0))
    assert not hasattr(fa.models.StandardMap(), "energy")
    assert not hasattr(fa.ode("x' = y; y' = -x"), "energy")


def test_far_points_of_a_map_warn_of_nothing():
    kicked = fa.iterated_map("x1 = p*exp(x**2); p1 = x*exp(p**2)")
    assert not kicked.symplectic
