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
    "mooney-rivlin": (_mooney_rivlin, {"c10": 0.7, "c01": 0.2, "K": 2.0}),
    "Ogden": (_ogden, {"a1": 1.1, "m1": 1.3, "K": 1.5}),
    "ogden": (_ogden, {"a1": 0.9, "m1": 1.3, "a2": -0.2, "m2": -2.1, "K": 1.5}),
    "gent": (_gent, {"G": 0.8, "Jm": 9.0, "K": 2.0}),
    "hencky": (_hencky, {"G": 0.8, "lam": 1.3}),
    "Saint-Venant-Kirchhoff": (_kirchhoff, {"G": 0.8, "lam": 1.3}),
}
LAME = {
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


@pytest.mark.parametrize("text", ["arruda-boyce", "Yeoh", "neo hooke"])
def test_laws_that_are_not_known_are_said_to_be_none(text):
    with pytest.raises(ValueError, match=r"is no law known by name, those are mooney-rivlin, .*: write its formula"):
        fa.affine_body(text, G=1.0)
