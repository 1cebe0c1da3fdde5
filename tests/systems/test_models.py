"""The physics of the models, against expressions written here anew in D1, D2 and r, vartheta.

Derivatives are complex steps (f(q + i h v) with h = 1e-30 has no truncation and no cancellation), so tolerances are
rounding: 1e-13 of the size of the terms.
"""

import numpy as np
import pytest
from naive import MODELS, energy, label, states

from fastaff import Anharmonic, Body, Harmonic, HeavyTop, HenonHeiles, Hyperelastic, NeoHookean
from fastaff.systems.charts import TWO_POLAR, to_matrix

every_model = pytest.mark.parametrize("model", MODELS, ids=label)
BODIES = [m for m in MODELS if isinstance(m, Body)]
every_body = pytest.mark.parametrize("body", BODIES, ids=label)
H = 1e-30


def coordinates(model, orbits=50):
    return states(model, orbits)[: model.degrees_of_freedom]


def gradient(function, q):
    """Gradient of a function of the coordinates (n, orbits) by complex steps."""
    n = len(q)
    return np.array([function(*(q + 1j * H * np.eye(n)[k][:, None])).imag / H for k in range(n)])


@every_model
def test_force_is_minus_the_gradient_of_the_potential(model):
    q = coordinates(model)
    force = np.array(model.force(*q))
    np.testing.assert_allclose(force, -gradient(model.potential_energy, q), rtol=1e-13, atol=1e-13)


@every_model
def test_velocity_is_the_gradient_of_the_kinetic_energy(model):
    p = states(model, 50, seed=2)[model.degrees_of_freedom :]
    np.testing.assert_allclose(np.array(model.velocity(*p)), gradient(model.kinetic_energy, p), rtol=1e-14, atol=1e-15)


@every_model
def test_tangent_force_is_the_derivative_of_the_force(model):
    q = coordinates(model)
    v = np.random.default_rng(3).standard_normal(q.shape)
    expected = np.array([f.imag / H for f in map(np.asarray, model.force(*(q + 1j * H * v)))])
    np.testing.assert_allclose(np.array(model.tangent_force(*q, *v)), expected, rtol=1e-12, atol=1e-12)


@every_body
def test_slopes_and_curvatures_of_the_potential(body):
    V, rng = body.potential, np.random.default_rng(4)
    A, B = rng.uniform(1.5, 3, 40), rng.uniform(0, 1, 40)
    slopes, curvatures = V.slopes(A, B), V.curvatures(A, B)
    np.testing.assert_allclose(slopes[0], V.value(A + 1j * H, B).imag / H, rtol=1e-13)
    np.testing.assert_allclose(slopes[1], V.value(A, B + 1j * H).imag / H, rtol=1e-13)
    along_a, along_b = V.slopes(A + 1j * H, B), V.slopes(A, B + 1j * H)
    tolerance = {"rtol": 1e-12, "atol": 1e-13}
    np.testing.assert_allclose(curvatures[0] + 0 * A, np.imag(along_a[0]) / H + 0 * A, **tolerance)
    np.testing.assert_allclose(curvatures[1] + 0 * A, np.imag(along_a[1]) / H + 0 * A, **tolerance)
    np.testing.assert_allclose(curvatures[1] + 0 * A, np.imag(along_b[0]) / H + 0 * A, **tolerance)
    np.testing.assert_allclose(curvatures[2] + 0 * A, np.imag(along_b[1]) / H + 0 * A, **tolerance)


@every_model
def test_floats_and_arrays_give_the_same(model):
    """log of NumPy may differ by a unit of rounding between scalars and arrays, hence 4 eps."""
    z, n = states(model, 7), model.degrees_of_freedom
    calls = {
        "velocity": z[n:],
        "force": z[:n],
        "kinetic_energy": z[n:],
        "potential_energy": z[:n],
        "margin": z[:n],
        "tangent_force": z,
    }
    for name, rows in calls.items():
        whole = np.array(getattr(model, name)(*rows))
        assert whole.shape[-1:] == (7,), name
        for i in range(7):
            one = getattr(model, name)(*(float(x) for x in rows[:, i]))
            np.testing.assert_allclose(np.array(one, dtype=float), whole[..., i], rtol=1e-15, atol=1e-15, err_msg=name)


def stretches(z):
    """D1 >= |D2| from the singular values of the matrix and the sign of its determinant: no chart is used."""
    phi = np.moveaxis(to_matrix(z)[0], -1, 0)
    singular = np.linalg.svd(phi, compute_uv=False)
    return singular[:, 0], singular[:, 1] * np.sign(np.linalg.det(phi))


FORMULAS = {  # Martens & Slawianowski by label; in D1, D2
    Harmonic: lambda P, D1, D2: P.C / 2 * (D1**2 + D2**2),  # EQ3.1
    Anharmonic: lambda P, D1, D2: P.C / 2 * (D1**2 + D2**2) + 4 * P.C / (D1 + D2) ** 2,  # EQa
    Hyperelastic: lambda P, D1, D2: P.C * (1 / (D1 * D2) + (D1**2 + D2**2) / 2),  # EQ2.2h
    HeavyTop: lambda P, D1, D2: (  # EQ2.2f with V_vartheta = A cos vartheta, cos vartheta = 2 D1 D2/r
        P.C * (D1**2 + D2**2) / 2 + P.A * 2 * D1 * D2 / (D1**2 + D2**2) ** 2
    ),
    NeoHookean: lambda P, D1, D2: (  # docs/reference/formulas.md section 8
        P.G / 2 * (D1**2 + D2**2 - 2) - P.G * np.log(D1 * D2) + P.K / 2 * (D1 * D2 - 1) ** 2
    ),
}


@every_body
def test_potential_in_stretches(body):
    z = states(body, 60)
    V = FORMULAS[type(body.potential)](body.potential, *stretches(z))
    np.testing.assert_allclose(body.potential_energy(*z[:4]), V, rtol=1e-13, atol=1e-13)


def polar(z):
    """r and vartheta from D1, D2: cos vartheta = 2 D1 D2/r, vartheta in (0, pi)."""
    D1, D2 = stretches(z)
    r = D1**2 + D2**2
    return r, np.arctan2(D1**2 - D2**2, 2 * D1 * D2)


@pytest.mark.parametrize(
    ("potential", "formula"),
    [
        (Hyperelastic(1.1), lambda P, r, v: P.C * r / 2 + 2 * P.C / (r * np.cos(v))),
        (Anharmonic(0.9), lambda P, r, v: P.C * r / 2 + 2 * P.C / (r * np.cos(v / 2) ** 2)),  # EQb
        (Anharmonic(0.9), lambda P, r, v: P.C * (r + 4 / r) / 2 + 2 * P.C * np.tan(v / 2) ** 2 / r),  # EQb, first form
        (HeavyTop(1.2, 0.6), lambda P, r, v: P.C * r / 2 + P.A * np.cos(v) / r),
        (HeavyTop(0.7, -1.5), lambda P, r, v: P.C * r / 2 + P.A * np.cos(v) / r),
    ],
    ids=["EQ2.2h", "EQb", "EQb-tan", "top", "top-upside-down"],
)
def test_potential_in_r_vartheta(potential, formula):
    body = Body(potential)
    z = states(body, 60, seed=5)
    np.testing.assert_allclose(body.potential_energy(*z[:4]), formula(potential, *polar(z)), rtol=1e-13, atol=1e-13)


@every_body
def test_potential_does_not_feel_rotations_and_transposition(body):
    """phi -> R phi S and phi -> phi^T keep D1, D2; so does the exchange of D1 and D2 (two names of one matrix)."""
    z, rng = states(body, 30), np.random.default_rng(6)
    V = body.potential_energy(*z[:4])
    x, y = rng.uniform(0, 6, 2)
    turned = (
        np.array(
            [
                [np.cos(x), -np.sin(x), 0, 0],
                [np.sin(x), np.cos(x), 0, 0],
                [0, 0, np.cos(y), -np.sin(y)],
                [0, 0, np.sin(y), np.cos(y)],
            ]
        )
        @ z[:4]
    )
    np.testing.assert_allclose(body.potential_energy(*turned), V, rtol=1e-13)
    transposed = z[:4] * np.array([[1], [-1], [1], [1]])
    np.testing.assert_allclose(body.potential_energy(*transposed), V, rtol=1e-15)
    q = TWO_POLAR.from_planes(z)
    mirrored = q[[1, 0, 2, 3, 5, 4, 6, 7]]
    mirrored[2:4] += np.pi / 2
    np.testing.assert_allclose(TWO_POLAR.to_planes(mirrored), z, rtol=0, atol=1e-13)
    np.testing.assert_allclose(energy(body, TWO_POLAR.to_planes(mirrored)), energy(body, z), rtol=1e-13)
    # the formula itself, with D1 and D2 exchanged
    formula, (D1, D2) = FORMULAS[type(body.potential)], stretches(z)
    np.testing.assert_allclose(formula(body.potential, D2, D1), V, rtol=1e-13, atol=1e-13)


@every_body
def test_kinetic_energy_is_that_of_the_matrix(body):
    z = states(body, 20)
    momentum = to_matrix(z)[1]
    np.testing.assert_allclose(body.kinetic_energy(*z[4:]), (momentum**2).sum(axis=(0, 1)) / (2 * body.mu), rtol=1e-14)


def normal_modes(body, q):
    """Squared angular frequencies at a rest state, ascending: eigenvalues of the Hessian over mu."""
    q = np.asarray(q, dtype=float)
    hessian = -np.array([body.tangent_force(*q, *e) for e in np.eye(4)])
    np.testing.assert_allclose(hessian, hessian.T, rtol=0, atol=1e-13)
    return np.linalg.eigvalsh(hessian) / body.mu


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
@pytest.mark.parametrize(
    ("body", "radius", "squares"),
    [  # in docs/reference/formulas.md section 3; the other three from the Hessian in (D1, D2), by hand
        (Body(Hyperelastic(1.7), 0.6), np.sqrt(2), np.array([0, 2, 2, 4]) * 1.7 / 0.6),
        (Body(Anharmonic(1.7), 0.6), np.sqrt(2), np.array([0, 1, 1, 4]) * 1.7 / 0.6),
        (Body(NeoHookean(0.8, 2.3), 0.6), np.sqrt(2), np.array([0, 2 * 0.8, 2 * 0.8, 2 * (0.8 + 2.3)]) / 0.6),
        (Body(Harmonic(1.7), 0.6), 0.0, np.full(4, 1.7 / 0.6)),
        (Body(HeavyTop(1.7, 0.9), 0.6), (2 * 0.9 / 1.7) ** 0.25, np.array([-2, -2, 0, 4]) * 1.7 / 0.6),
    ],
    ids=["Hyperelastic", "Anharmonic", "NeoHookean", "Harmonic", "HeavyTop"],
)
def test_rest_states_and_normal_frequencies(body, radius, squares, angle):
    """phi in SO(2) times the radius: at rest, and the normal modes around it."""
    q = radius * np.cos(angle), radius * np.sin(angle), 0.0, 0.0
    np.testing.assert_allclose(body.force(*q), 0.0, atol=1e-14)
    np.testing.assert_allclose(normal_modes(body, q), squares, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("potential", "inside", "outside"),
    [
        (Harmonic(), [(1.0, 0.0), (0.0, 0.0), (0.5, 2.0)], []),
        (Anharmonic(), [(1.0, 0.0), (0.1, 5.0)], [(0.0, 1.0), (0.0, 0.0)]),
        (Hyperelastic(), [(1.0, 0.9)], [(1.0, 1.0), (0.5, 2.0)]),
        (HeavyTop(), [(1.0, 0.0), (0.0, 1.0)], [(0.0, 0.0)]),
        (NeoHookean(), [(1.0, 0.9)], [(1.0, 1.0), (0.5, 2.0)]),
    ],
    ids=label,
)
def test_margin_says_where_the_potential_lives(potential, inside, outside):
    """Points are (A, B) = (alpha^2, beta^2)."""
    body = Body(potential)
    for A, B in inside:
        assert potential.margin(A, B) > 0
        assert body.margin(np.sqrt(A), 0.0, 0.0, np.sqrt(B)) > 0
        assert np.isfinite(potential.value(A, B))
    for A, B in outside:
        assert not potential.margin(A, B) > 0


def test_henon_heiles_formula_and_escape_energy():
    """Critical points at energy 1/6 for lam = 1 (Henon & Heiles 1964), 1/(6 lam^2) in general."""
    for lam in (1.0, 0.5):
        model = HenonHeiles(lam)
        for q in ((0.0, 1 / lam), (np.sqrt(0.75) / lam, -0.5 / lam), (-np.sqrt(0.75) / lam, -0.5 / lam)):
            np.testing.assert_allclose(model.force(*q), 0.0, atol=1e-15)
            assert model.potential_energy(*q) == pytest.approx(1 / (6 * lam**2), rel=1e-14)
    assert HenonHeiles(1.0).potential_energy(0.3, 0.2) == pytest.approx(
        (0.09 + 0.04) / 2 + 0.09 * 0.2 - 0.008 / 3, rel=1e-15
    )
    assert HenonHeiles().kinetic_energy(3.0, 4.0) == 12.5


def test_models_are_values():
    assert Body(Hyperelastic(2.0), mu=3.0) == Body(Hyperelastic(C=2.0), 3.0)
    assert hash(Body(HeavyTop())) == hash(Body(HeavyTop(1.0, 1.0)))
    assert Body(Hyperelastic())._replace(mu=2.0).mu == 2.0
