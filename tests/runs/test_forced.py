"""Flows of models with forces beside their own: equations of the energy, drives, damping, refusals."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.systems.formulas.forced import BUILT_IN

LAWS = {
    "gent": {"G": 0.8, "Jm": 9.0, "K": 2.0},
    "ogden": {"a1": 0.9, "m1": 1.3, "a2": -0.2, "m2": -2.1, "K": 1.5},
    "E/2*(log(D1)**2 + log(D2)**2) + S*log(D1*D2)**2 + I*(D1 - D2)**4": {"E": 1.1, "S": 0.4, "I": 0.3},
}
"""Laws by name, and one whose letters SymPy would take for its own numbers."""


@pytest.mark.parametrize("law", LAWS)
def test_a_pulled_sheet_moves_as_its_stored_energy_says(law):
    """Slopes of V by complex steps of the body's own energy, the drive and the damping beside them."""
    rng = np.random.default_rng(7)
    mu, f, g, w = rng.uniform(0.5, 2.0, 4)
    body = fa.affine_body(law, mu=mu, **LAWS[law])
    drawn = {"D1": "f*cos(w*t) - g*p_D1", "D2": "-g*p_D2 + f*sin(t*w)"}
    sheet = fa.ode(body, forces=drawn, f=f, g=g, w=w)
    assert sheet.coordinates == ("D1", "D2", "p_D1", "p_D2", "cosine", "sine")
    D, p = rng.uniform(0.7, 1.4, (2, 20)), rng.normal(size=(2, 20))
    phase = rng.uniform(0, 2 * np.pi, 20)
    c, s = np.cos(phase), np.sin(phase)

    def energy(x, y):
        return body.potential.value(x * x / 2 + y * y / 2 + x * y, x * x / 2 + y * y / 2 - x * y)

    h = 1e-20
    slopes = energy(D[0] + 1j * h, D[1]).imag / h, energy(D[0], D[1] + 1j * h).imag / h
    truth = [*p / mu, f * c - g * p[0] - slopes[0], f * s - g * p[1] - slopes[1], -w * s, w * c]
    np.testing.assert_allclose(sheet.rates(*D, *p, c, s), truth, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("scaled", [False, True])
def test_a_linear_oscillator_swings_as_its_closed_form(scaled):
    rng = np.random.default_rng(8)
    m, k, f, g, w = rng.uniform(0.5, 2.0, 5)
    masses = {"masses": [m]} if scaled else {}
    m = m if scaled else 1.0
    spring = fa.hamiltonian("k*x**2/2", coordinates="x", k=k, **masses)
    pulled = fa.ode(spring, forces={"x": "f*cos(w*t) - g*p_x"}, f=f, g=g, w=w)
    far = 60 / (g / min(m, 1.0)) + 100
    x, p, c, s = fa.integrate(pulled, [0.3, 0.1, 1.0, 0.0], time=far, rtol=1e-12, atol=1e-12).z[:, 0]
    swing = f / (k - m * w**2 + 1j * g * m * w)
    assert abs(x - (swing * (c + 1j * s)).real) < 1e-8
    assert abs(p - (1j * w * m * swing * (c + 1j * s)).real) < 1e-8


@pytest.mark.parametrize("potential", [cls for cls in BUILT_IN if hasattr(cls, "slopes")])
def test_bodies_of_named_potentials_are_pulled_by_their_own_energy(potential):
    """Text, domain and slopes against the class, where D1 D2 > 0 and beyond."""
    rng = np.random.default_rng(10)
    potential = potential(*rng.uniform(0.5, 2.0, len(potential._fields)))
    mu, g = rng.uniform(0.5, 2.0, 2)
    body = fa.Body(potential, mu=mu)
    free, damped = fa.ode(body), fa.ode(body, forces={"D2": "-damp*p_D2"}, damp=g)
    assert free.coordinates == ("D1", "D2", "p_D1", "p_D2")
    (x, y), p = rng.uniform(0.7, 1.4, (2, 20)), rng.normal(size=(2, 20))

    def invariants(x, y):
        return (x + y) ** 2 / 2, (x - y) ** 2 / 2

    A, B = invariants(x, y)
    V_A, V_B = potential.slopes(A, B)
    forces = -V_A * (x + y) - V_B * (x - y), -V_A * (x + y) + V_B * (x - y)
    np.testing.assert_allclose(np.broadcast_arrays(*free.rates(x, y, *p)), [*p / mu, *forces], rtol=1e-11, atol=1e-11)
    changed = np.subtract(damped.rates(x, y, *p), free.rates(x, y, *p))
    np.testing.assert_allclose(changed, [0 * x, 0 * x, 0 * x, -g * p[1]], atol=1e-11)
    text = fa.affine_body(BUILT_IN[type(potential)].formula, **potential._asdict())
    np.testing.assert_allclose(text.potential.value(A, B), potential.value(A, B), rtol=1e-12, atol=1e-12)
    x, y = rng.normal(size=(2, 50))
    inside = [free.margin(*z, 0.1, 0.2) > 0 for z in zip(x, y)]
    assert inside == list(potential.margin(*invariants(x, y)) > 0)


def test_any_hamiltonian_may_be_pulled_and_without_forces_it_is_its_own():
    """H(q, p) with momenta in its text, and a named system: rates of the model, and what is added."""
    rng = np.random.default_rng(9)
    sphere = fa.models.SphericalPendulum()
    torus = fa.hamiltonian("p**2/2 + L**2/(2*(R + cos(q))**2)", coordinates="q phi", momenta="p L", R=2.2)
    charge = fa.hamiltonian("x**2 + y**2", masses=(2.0, 3.0), vector_potential={"x": "-y*x", "y": "x*y"})
    double = fa.models.DoublePendulum(*map(float, rng.uniform(0.5, 2.0, 5)))
    assert fa.ode(double).periods() == (2 * np.pi, 2 * np.pi, 0.0, 0.0)
    henon = fa.HenonHeiles(lam=rng.uniform(0.5, 2.0))
    for model in (sphere, torus, charge, double, henon):
        z = rng.uniform(0.5, 1.5, (4, 12))
        name, momentum = model.coordinates[0], getattr(model, "momenta", ["p_x"])[0]
        free, damped = fa.ode(model), fa.ode(model, forces={name: f"-damp*{momentum}"}, damp=0.3)
        own = np.broadcast_arrays(*(model.rates(*z) if hasattr(model, "rates") else (*z[2:], *model.force(*z[:2]))))
        np.testing.assert_allclose(np.broadcast_arrays(*free.rates(*z)), own, rtol=1e-10, atol=1e-12)
        own = np.array(own)
        own[2] -= 0.3 * z[2]
        np.testing.assert_allclose(np.broadcast_arrays(*damped.rates(*z)), own, rtol=1e-10, atol=1e-12)
    assert fa.ode(fa.hamiltonian("x**2 - log(x)", coordinates="x", domain="x")).domain == "x"


GENT = fa.affine_body("gent", **LAWS["gent"])


@pytest.mark.parametrize(
    ("make", "error", "said"),
    [
        (lambda: fa.ode(GENT, forces={"x": "f"}, f=1.0), ValueError, "forces must be of D1, D2, as {'D1': 'f"),
        (lambda: fa.ode(GENT, forces="f*cos(w*t)"), TypeError, "forces must be formulas by coordinate"),
        (
            lambda: fa.ode(GENT, forces={"D1": "cos(w*t + 1)"}, w=1.0),
            ValueError,
            r"forces\['D1'\] must have the time as cos\(w\*t\) and sin\(w\*t\) of one",
        ),
        (lambda: fa.ode(GENT, forces={"D1": "cos(t) + cos(w*t)"}, w=1.0), ValueError, "of one rate w"),
        (lambda: fa.ode(GENT, forces={"D1": "K*cos(t)"}, K=1.0), ValueError, "'K' is that of the model, 2: rename"),
        (lambda: fa.ode(GENT, forces={"D1": "sine*cos(t)"}, sine=1.0), ValueError, "sine is the phase of the drive"),
        (lambda: fa.ode(GENT, forces={"D1": "f*cos(t)"}), ValueError, "unknown name 'f'"),
        (lambda: fa.ode(fa.affine_body("alpha**2 + beta**2")), ValueError, "is a formula of D1 and D2, got 'alpha"),
        (
            lambda: fa.ode(fa.Body(fa.Harmonic().alpha_beta)),
            TypeError,
            "text must be equations or a model made of a formula, without",
        ),
        (
            lambda: fa.ode(fa.Harmonic(), forces={"D1": "1"}),
            TypeError,
            "text must be equations or a model made of a formula, without",
        ),
        (
            lambda: fa.ode("x' = -x", forces={"x": "1"}),
            TypeError,
            "text must be equations or a model made of a formula, without",
        ),
        (
            lambda: fa.ode(fa.hamiltonian("x**2", coordinates="x", friction=0.1)),
            TypeError,
            "text must be equations or a model made of a formula, without",
        ),
    ],
)
def test_refusals_say_what_forces_may_be(make, error, said):
    with pytest.raises(error, match=said):
        make()


def test_periods_of_a_model_stay_those_of_its_flow():
    pendulum = fa.hamiltonian("-k*cos(n*q)", coordinates="q", periodic={"q": "2*pi/n"}, k=1.3, n=2.0)
    driven = fa.ode(pendulum, forces={"q": "f*cos(w*t) - g*p_q"}, f=0.1, w=0.7, g=0.1)
    assert driven.periods() == (np.pi, 0.0, 0.0, 0.0)
    assert fa.ode(pendulum, periodic={"q": "2*pi"}).periods() == (2 * np.pi, 0.0)
    assert not hasattr(fa.ode(pendulum, periodic={}), "periods")
