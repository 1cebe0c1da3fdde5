"""Hyperelastic laws by name, against energies of matrices that are differentiated by the complex step."""

import numpy as np
import pytest

import fastaff as fa

STEP = 1e-30


def _invariants(F):
    """I1 and I2 of the matrix in three dimensions whose third stretch is 1, and its determinant."""
    C = np.einsum("ki,kj->ij", F, F)
    trace, J = C[0, 0] + C[1, 1], F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]
    return trace + 1, J * J + trace, J


def _squares(F):
    """The squares of the stretches, roots of x^2 - trace x + J^2."""
    first, _, J = _invariants(F)
    half = (first - 1) / 2
    root = np.sqrt(half * half - J * J)
    return np.array([half + root, half - root])


def _mooney_rivlin(F, c10, c01, K):
    first, second, J = _invariants(F)
    return c10 * (first - 3) + c01 * (second - 3) - 2 * (c10 + 2 * c01) * np.log(J) + K / 2 * (J - 1) ** 2


def _ogden(F, K, **terms):
    J = _invariants(F)[2]
    W = K / 2 * (J - 1) ** 2
    for k in range(1, len(terms) // 2 + 1):
        a, m = terms[f"a{k}"], terms[f"m{k}"]
        W = W + a / m * (np.sum(_squares(F) ** (m / 2)) - 2) - a * np.log(J)
    return W


def _neo_hookean(F, G, K):
    first, _, J = _invariants(F)
    return G / 2 * (first - 3) - G * np.log(J) + K / 2 * (J - 1) ** 2


def _yeoh(F, c10, c20, c30, K):
    first, _, J = _invariants(F)
    e = first - 3
    return c10 * e + c20 * e**2 + c30 * e**3 - 2 * c10 * np.log(J) + K / 2 * (J - 1) ** 2


def _chain_series(N):
    """Coefficients of the energy of the eight chains in I1^k: the integral of the inverse Langevin function's series
    3 x + 9/5 x^3 + 297/175 x^5 + 1539/875 x^7 + 126117/67375 x^9 at x^2 = I1/(3 N), over G.
    """
    inverse = np.array([3, 9 / 5, 297 / 175, 1539 / 875, 126117 / 67375])
    k = np.arange(1, 6)
    return N * inverse / (2 * k) / (3 * N) ** k


def _arruda_boyce(F, G, N, K):
    first, _, J = _invariants(F)
    c, k = _chain_series(N), np.arange(1, 6)
    slope = 2 * np.sum(k * c * 3.0 ** (k - 1))
    return G / slope * np.sum(c * (first**k - 3.0**k)) - G * np.log(J) + K / 2 * (J - 1) ** 2


def _stiffening(G, N):
    c, k = _chain_series(N), np.arange(1, 6)
    return 4 * G * np.sum(k * (k - 1) * c * 3.0 ** (k - 2)) / (2 * np.sum(k * c * 3.0 ** (k - 1)))


def _gent(F, G, Jm, K):
    first, _, J = _invariants(F)
    return -G * Jm / 2 * np.log(1 - (first - 3) / Jm) - G * np.log(J) + K / 2 * (J - 1) ** 2


def _hencky(F, G, lam):
    logs = np.log(_squares(F)) / 2
    return G * np.sum(logs * logs) + lam / 2 * np.sum(logs) ** 2


def _kirchhoff(F, G, lam):
    E = (np.einsum("ki,kj->ij", F, F) - np.eye(2)) / 2
    return lam / 2 * np.trace(E) ** 2 + G * np.sum(E * E)


LAWS = {
    "neo-hookean": (_neo_hookean, {"G": 0.8, "K": 2.0}),
    "yeoh": (_yeoh, {"c10": 0.5, "c20": -0.02, "c30": 0.01, "K": 2.0}),
    "Arruda-Boyce": (_arruda_boyce, {"G": 0.8, "N": 6.0, "K": 2.0}),
    "mooney-rivlin": (_mooney_rivlin, {"c10": 0.7, "c01": 0.2, "K": 2.0}),
    "Ogden": (_ogden, {"a1": 1.1, "m1": 1.3, "K": 1.5}),
    "ogden": (_ogden, {"a1": 0.9, "m1": 1.3, "a2": -0.2, "m2": -2.1, "K": 1.5}),
    "gent": (_gent, {"G": 0.8, "Jm": 9.0, "K": 2.0}),
    "hencky": (_hencky, {"G": 0.8, "lam": 1.3}),
    "Saint-Venant-Kirchhoff": (_kirchhoff, {"G": 0.8, "lam": 1.3}),
}
LAME = {
    "neo-hookean": lambda G, K: (G, K),
    "yeoh": lambda c10, c20, c30, K: (2 * c10, K + 8 * c20),
    "Arruda-Boyce": lambda G, N, K: (G, K + _stiffening(G, N)),
    "mooney-rivlin": lambda c10, c01, K: (2 * (c10 + c01), K + 4 * c01),
    "Ogden": lambda a1, m1, K: (a1 * m1 / 2, K),
    "ogden": lambda a1, m1, a2, m2, K: ((a1 * m1 + a2 * m2) / 2, K),
    "gent": lambda G, Jm, K: (G, K + 2 * G / Jm),
    "hencky": lambda G, lam: (G, lam),
    "Saint-Venant-Kirchhoff": lambda G, lam: (G, lam),
}
"""Shear modulus and Lame's first constant at small strains."""


def _planes(phi):
    (x, y), (z, u) = phi
    return np.array([x + u, z - y, x - u, y + z]) / np.sqrt(2)


def _drawn(name, rng):
    """A body of a law with parameters around the given ones, its energy of matrices, and matrices."""
    energy, letters = LAWS[name]
    letters = {key: value * rng.uniform(0.8, 1.25) for key, value in letters.items()}
    turned = [np.linalg.qr(rng.normal(size=(2, 2)))[0] for _ in range(24)]
    turned = [Q * [1, np.linalg.det(Q)] for Q in turned]
    matrices = [
        Q @ np.diag(rng.uniform(0.6, 1.7, 2)) @ other for Q, other in zip(turned, turned[1:] + turned[:1], strict=True)
    ]
    return fa.affine_body(name, **letters), lambda F: energy(F, **letters), matrices, letters


@pytest.mark.parametrize("name", LAWS)
def test_stress_is_the_derivative_of_the_energy_of_matrices(name):
    rng = np.random.default_rng(len(name))
    body, energy, matrices, _ = _drawn(name, rng)
    for F in matrices:
        stress = np.empty((2, 2))
        for i, j in np.ndindex(2, 2):
            moved = F.astype(complex)
            moved[i, j] += 1j * STEP
            stress[i, j] = energy(moved).imag / STEP
        size = np.abs(stress).max() + 1
        assert abs(body.potential_energy(*_planes(F)) - energy(F)) < 1e-12 * (1 + abs(energy(F)))
        np.testing.assert_allclose(body.force(*_planes(F)), -_planes(stress), atol=2e-12 * size)


@pytest.mark.parametrize("name", LAWS)
def test_small_strains_have_the_constants_of_lame(name):
    body, _, _, letters = _drawn(name, np.random.default_rng(3))
    shear, first = LAME[name](**letters)
    rest = _planes(np.eye(2))
    np.testing.assert_allclose(body.force(*rest), 0.0, atol=1e-13)
    for strain in ([[1.0, 0.0], [0.0, 0.0]], [[0.0, 0.5], [0.5, 0.0]], [[0.3, -0.2], [-0.2, 1.1]], [[0, 1], [-1, 0]]):
        e = np.array(strain, float)
        symmetric = (e + e.T) / 2
        expected = first * np.trace(e) * np.eye(2) + 2 * shear * symmetric
        np.testing.assert_allclose(body.tangent_force(*rest, *_planes(e)), -_planes(expected), atol=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_no_frame_is_preferred(name):
    rng = np.random.default_rng(5)
    body, _, matrices, _ = _drawn(name, rng)
    for F in matrices:
        (c, s), (d, t) = ((np.cos(angle), np.sin(angle)) for angle in rng.uniform(0, 2 * np.pi, 2))
        turned = np.array([[c, -s], [s, c]]) @ F @ np.array([[d, -t], [t, d]])
        here, there = (body.potential_energy(*_planes(phi)) for phi in (F, turned))
        assert abs(here - there) < 1e-12 * (1 + abs(here))


def test_gent_ends_where_the_chains_are_stretched():
    potential = fa.affine_body("gent", G=1.0, Jm=1.0, K=2.0).potential
    for D1, D2, inside in ((1.2, 1.0, True), (1.5, 1.0, False), (1.0, -0.1, False)):
        assert (potential.margin((D1 + D2) ** 2 / 2, (D1 - D2) ** 2 / 2) > 0) == inside


@pytest.mark.parametrize("letters", [{}, {"G": 1.0}, {"G": 1.0, "Jm": 2.0, "K": 1.0, "c10": 1.0}])
def test_wrong_letters_are_named(letters):
    with pytest.raises(ValueError, match="'gent' takes the parameters G, Jm, K; got"):
        fa.affine_body("gent", **letters)
    with pytest.raises(ValueError, match="'ogden' takes the parameters K, a1, m1; got"):
        fa.affine_body("ogden", **letters)


@pytest.mark.parametrize("text", ["arruda boyce law", "Veronda", "neo hooke"])
def test_laws_that_are_not_known_are_said_to_be_none(text):
    with pytest.raises(
        ValueError, match=r"is no law known by name, those are neo-hookean, mooney-rivlin, .*: write its formula"
    ):
        fa.affine_body(text, G=1.0)


def test_invariants_of_plane_strain_are_letters_of_formulas():
    written = fa.affine_body("G/2*(I1 - 3) - G*log(J) + k*(I2 - 3)**2", domain="J - 0.1", G=0.8, k=0.3)
    for F in _drawn("gent", np.random.default_rng(8))[2]:
        first, second, J = _invariants(F)
        expected = 0.4 * (first - 3) - 0.8 * np.log(J) + 0.3 * (second - 3) ** 2
        assert written.potential_energy(*_planes(F)) == pytest.approx(expected, rel=1e-12, abs=1e-12)
        assert written.margin(*_planes(F)) == pytest.approx(J - 0.1, rel=1e-12)


def test_parameters_may_have_the_names_of_invariants():
    body = fa.affine_body("J*(D1**2 + D2**2)/2 + I1*D1*D2", J=2.0, I1=0.5)
    assert (body.potential.J, body.potential.I1) == (2.0, 0.5)
    assert body.potential_energy(*_planes(np.diag([1.5, 0.5]))) == pytest.approx(2.5 + 0.375, rel=1e-14)


def test_mu_is_a_parameter_where_there_is_no_body():
    assert fa.hamiltonian("mu*x**2 + y**2", mu=2.0).energy(1.0, 0.0, 0.0, 0.0) == 2.0
    assert fa.ode("x' = y; y' = mu*(1 - x**2)*y - x", mu=1.5).rates(0.0, 2.0) == (2.0, 3.0)
    assert fa.iterated_map("p1 = p + mu_1*x; x1 = x + p1", mu_1=0.5).iterate(1.0, 0.0) == (1.5, 0.5)
    with pytest.raises(ValueError, match="parameter 'mu_1' is taken"):
        fa.affine_body("mu_1*(D1**2 + D2**2)", mu_1=1.0)
