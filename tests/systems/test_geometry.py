"""Section 7: generators, parametrisations, Cartan forms, invariant metrics and their continuation.

Independent truths: SciPy's matrix exponential, complex-step derivatives (exact to rounding) of it, and matrices of ad.
Tolerances: products of a few 2 x 2 matrices of size e^1, so 1e-13 of the largest entry.
"""

import numpy as np
import pytest
from scipy.linalg import expm

from fastaff.systems import invariant_metrics as g
from fastaff.systems.charts import CARTESIAN, DELTA_B, EULER, EXPONENTIAL, R_EULER, TWO_POLAR, to_matrix
from fastaff.systems.invariant_metrics import (
    AFFINE_BODY,
    BREATHING_TOP,
    BREATHING_TOP_313,
    BREATHING_TOP_323,
    PAULI,
    TAU,
    TAU_TILDE,
    UNITARY,
)

GROUPS = (AFFINE_BODY, BREATHING_TOP, BREATHING_TOP_313, BREATHING_TOP_323, UNITARY)
every_group = pytest.mark.parametrize("group", GROUPS, ids=[f"{k}-{group.name}" for k, group in enumerate(GROUPS)])
RNG = np.random.default_rng(5)
POINTS = np.stack([RNG.normal(0, 0.5, 12), RNG.uniform(0, 6, 12), RNG.uniform(0.3, 2.5, 12), RNG.uniform(0, 6, 12)])
SIGNS = (-1.0, -0.3, 0.0, 0.7)


def dagger(m):
    return m.conj().T


def random_gl():
    """A matrix of GL+(2,R) of condition below 3."""
    shear, angle, stretch = RNG.uniform(-0.4, 0.4), RNG.uniform(0, 6), RNG.uniform(0.3, 0.9)
    return 1.3 * expm(shear * TAU_TILDE[1]) @ expm(angle * TAU_TILDE[2]) @ expm(stretch * TAU_TILDE[3])


def random_su2():
    w = RNG.normal(size=4)
    return np.einsum("k,kij->ij", w / np.linalg.norm(w), np.concatenate([PAULI[:1], 1j * PAULI[1:]]))


def test_pauli_and_generators():
    """sigma_a sigma_b = delta_ab + i eps_abc sigma_c; the commutators of tau and tilde tau as printed."""
    for a, b, c in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        np.testing.assert_array_equal(PAULI[a] @ PAULI[b], 1j * PAULI[c])
        np.testing.assert_array_equal(PAULI[a] @ PAULI[a], np.eye(2))
        np.testing.assert_array_equal(g.commutator(TAU[a], TAU[b]), TAU[c])
        np.testing.assert_array_equal(g.commutator(TAU_TILDE[a], TAU_TILDE[b]), TAU_TILDE[c] * (-1 if c == 2 else 1))
        np.testing.assert_array_equal(g.commutator(TAU[0], TAU[a]), 0)
        np.testing.assert_array_equal(TAU[a], PAULI[a] / 2j)
        np.testing.assert_array_equal(TAU[a] + dagger(TAU[a]), 0)
        assert np.trace(TAU_TILDE[a]) == 0
    assert TAU_TILDE.dtype == float
    c = g.structure_constants(TAU[1:])
    levi_civita = [[[np.linalg.det(np.eye(3)[[i, j, k]]) for k in range(3)] for j in range(3)] for i in range(3)]
    np.testing.assert_allclose(c, levi_civita, rtol=0, atol=1e-15)
    tilde = g.structure_constants(TAU_TILDE)
    assert tilde.shape == (4, 4, 4)
    assert (tilde[1, 2, 3], tilde[2, 3, 1], tilde[3, 1, 2]) == pytest.approx((1, 1, -1), abs=1e-15)
    with pytest.raises(ValueError, match="not closed"):
        g.structure_constants(TAU[[1, 2]])
    with pytest.raises(ValueError, match="linearly independent"):
        g.structure_constants(np.zeros((2, 2, 2)))


@pytest.mark.parametrize("t", [0.0, 0.4, -3.0, 0.3 + 0.8j])
def test_exponentials(t):
    for e in (*TAU, *TAU_TILDE, 1j * TAU[0]):
        np.testing.assert_allclose(g.exponential(e, t), expm(t * e), rtol=0, atol=1e-14 * 10)
    with pytest.raises(ValueError, match=r"of square \+-1/4"):
        g.exponential(np.array([[0, 1], [0, 0]]), 1.0)


@every_group
def test_parametrisations(group):
    """The product of matrix exponentials; each matrix in its group; tangents by complex step."""
    phi, tangents = group.matrix(POINTS), group.tangents(POINTS)
    assert phi.shape == (2, 2, 12)
    assert tangents.shape == (4, 2, 2, 12)
    for k, q in enumerate(POINTS.T):
        product = np.linalg.multi_dot([expm(t * e) for t, e in zip(q, group.generators)])
        np.testing.assert_allclose(phi[..., k], product, rtol=0, atol=1e-13 * np.abs(product).max())
        for row in range(4):
            shift = np.eye(4)[row] * 1e-6
            difference = (group.matrix(q + shift) - group.matrix(q - shift)) / 2e-6  # error h^2/6 * |phi'''| + eps/h
            np.testing.assert_allclose(tangents[row, ..., k], difference, rtol=0, atol=1e-9)
    one = group.matrix(POINTS[:, 0])
    if group is AFFINE_BODY:
        assert one.dtype == float
        assert np.linalg.det(one) == pytest.approx(np.exp(POINTS[0, 0]), rel=1e-13)
    else:
        scale = 1 if group is UNITARY else np.exp(POINTS[0, 0])
        np.testing.assert_allclose(one @ dagger(one), scale * np.eye(2), rtol=0, atol=1e-13)
        assert np.linalg.det(one) == pytest.approx(np.exp((1j if group is UNITARY else 1) * POINTS[0, 0]), rel=1e-13)


def test_affine_body_is_the_two_polar_form():
    """EQ6.20 is EQ2.0 with D1, D2 = e^{(a +- b)/2}, Phi = 2 phi, Psi = -2 psi: the coordinates of DELTA_B and
    EXPONENTIAL.
    """
    a, Phi, b, Psi = POINTS
    phi = AFFINE_BODY.matrix(POINTS)
    for chart, q in (
        (TWO_POLAR, [np.exp((a + b) / 2), np.exp((a - b) / 2), Phi / 2, -Psi / 2]),
        (EXPONENTIAL, [a, b, Phi / 2, -Psi / 2]),
        (DELTA_B, [np.exp(a / 2), b, Phi, Psi]),
    ):
        z = np.concatenate([chart.points_to_planes(q), np.zeros((4, 12))])
        np.testing.assert_allclose(to_matrix(z)[0], phi, rtol=0, atol=1e-13 * np.abs(phi).max())


@every_group
def test_cartan_forms(group):
    """Omega = dphi phi^-1, hat Omega = phi^-1 dphi, hat Omega = phi^-1 Omega phi; the first direction is the centre."""
    left, right = group.cartan_forms(POINTS)
    phi, tangents = group.matrix(POINTS), group.tangents(POINTS)
    for k in range(12):
        back = np.linalg.inv(phi[..., k])
        for row in range(4):
            np.testing.assert_allclose(left[row, ..., k], tangents[row, ..., k] @ back, rtol=0, atol=1e-12)
            np.testing.assert_allclose(right[row, ..., k], back @ left[row, ..., k] @ phi[..., k], rtol=0, atol=1e-12)
    np.testing.assert_allclose(left[0], np.broadcast_to(group.generators[0][..., None], (2, 2, 12)), rtol=0, atol=1e-14)
    np.testing.assert_allclose(left[1], np.broadcast_to(group.generators[1][..., None], (2, 2, 12)), rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        right[3], np.broadcast_to(group.generators[3][..., None], (2, 2, 12)), rtol=0, atol=1e-13
    )


@pytest.mark.parametrize("c", SIGNS)
def test_breathing_top_metric(c):
    """EQ6.15 = Tr(dphi^+ dphi)/2 + c ddelta^2 (the factor 2 of EQ6.8), in a, delta and lambda; the same in all Euler
    angles.
    """
    a, Phi, Theta, Psi = POINTS
    metric = g.breathing_metric(POINTS, c)
    for group in (BREATHING_TOP, BREATHING_TOP_313, BREATHING_TOP_323):
        pulled = g.gram(g.trace_form, group.tangents(POINTS)) / 2
        pulled[0, 0] += c * np.exp(a) / 4
        np.testing.assert_allclose(metric, pulled, rtol=0, atol=1e-13 * np.abs(metric).max())
    delta, lam = np.exp(a / 2), np.exp(a)
    by_delta, by_lambda = (
        g.breathing_metric_delta([delta, Phi, Theta, Psi], c),
        g.breathing_metric_lambda([lam, Phi, Theta, Psi], c),
    )
    for other, rate in ((by_delta, delta / 2), (by_lambda, lam)):
        J = np.ones((4, 12))
        J[0] = rate
        np.testing.assert_allclose(J[:, None] * other * J, metric, rtol=0, atol=1e-14 * np.abs(metric).max())
    np.testing.assert_allclose(metric[1:, 1:], np.exp(a) / 4 * g.top_metric(POINTS[1:]), rtol=1e-14)


@pytest.mark.parametrize("c", SIGNS)
def test_unitary_metric(c):
    """EQ6.16 = -Tr(Omega^2)/2 - (c/4) Tr(Omega)^2; at c = 0 Tr(dphi^+ dphi)/2."""
    metric = g.unitary_metric(POINTS, c)
    forms = UNITARY.cartan_forms(POINTS)
    for Omega in forms:
        pulled = g.gram(lambda x, y: g.invariant_form(x, y, main=-0.5, dilatation=-c / 4), Omega)
        np.testing.assert_allclose(pulled, metric, rtol=0, atol=1e-13)
    if c == 0:
        np.testing.assert_allclose(g.gram(g.trace_form, UNITARY.tangents(POINTS)) / 2, metric, rtol=0, atol=1e-14)


@pytest.mark.parametrize("c", SIGNS)
def test_affine_metric(c):
    """EQ6.22 corrected = Tr(Omega^2)/2 + (c/4) Tr(Omega)^2, by either Cartan form, in a, delta and lambda."""
    a, Phi, b, Psi = POINTS
    metric = g.affine_metric(POINTS, c)
    for Omega in AFFINE_BODY.cartan_forms(POINTS):
        pulled = g.gram(lambda x, y: g.invariant_form(x, y, main=0.5, dilatation=c / 4), Omega)
        np.testing.assert_allclose(pulled, metric, rtol=0, atol=1e-12 * np.abs(metric).max())
    delta, lam = np.exp(a / 2), np.exp(a)
    for other, rate in (
        (g.affine_metric_delta([delta, Phi, b, Psi], c), delta / 2),
        (g.affine_metric_lambda([lam, Phi, b, Psi], c), lam),
    ):
        J = np.ones((4, 12))
        J[0] = rate
        np.testing.assert_allclose(J[:, None] * other * J, metric, rtol=0, atol=1e-14 * np.abs(metric).max())
    for k in range(12):
        assert g.signature(metric[..., k]) == ((3, 1, 0) if c > -1 else (2, 1, 1))


def test_affine_metric_beside_the_printed_one():
    """With c = -2 it is -det(dphi)/det(phi); the printed EQ6.22 is e^a times it, and depends on where it is moved."""
    metric, tangents = g.affine_metric(POINTS, -2.0), AFFINE_BODY.tangents(POINTS)
    for k, q in enumerate(POINTS.T):
        v = RNG.normal(size=4)
        det = np.linalg.det(np.tensordot(v, tangents[..., k], 1))
        assert v @ metric[..., k] @ v == pytest.approx(-det / np.exp(q[0]), rel=1e-11, abs=1e-12)
    np.testing.assert_array_equal(g.affine_metric(POINTS), g.affine_metric(POINTS + np.array([[0.8], [1], [0], [1]])))
    assert g.signature(g.affine_metric(POINTS[:, 0], -1.5)) == (2, 2, 0)


def coordinates(phi):
    """(a, Phi, b, Psi) of a matrix of GL+(2,R)."""
    z = np.concatenate([CARTESIAN.points_to_planes(phi.ravel()), np.zeros(4)])
    delta, b, Phi, Psi = DELTA_B.from_planes(z)[:4]
    return np.array([2 * np.log(delta), Phi, b, Psi])


def euler_angles(phi):
    """(a, Phi, Theta, Psi) of a matrix of R+SU(2): components on 1, 2 tau_2, 2 tau_3, 2 tau_1 are planes of the chart
    EULER.
    """
    planes = [np.trace(phi).real / 2, *(-np.trace(2 * TAU[k] @ phi).real / 2 for k in (2, 3, 1))]
    rho, Phi, Theta, Psi = EULER.points_from_planes(planes)
    return np.array([2 * np.log(rho), Phi, Theta, Psi])


def moved(q, there, back):
    """q' of a transformed matrix and dq'/dq by central differences of order 4 (error h^4, and eps/h = 1e-12)."""
    steps = 1e-3 * np.eye(4)

    def near(value, centre):
        """The sheet of Phi, Psi next to the centre's: (Phi + 2 pi, Psi + 2 pi) is the same matrix."""
        choices = [
            value + np.array([0, i * 2 * np.pi, 0, j * 2 * np.pi])
            for i in range(-3, 4)
            for j in range(-3, 4)
            if (i + j) % 2 == 0
        ]
        return min(choices, key=lambda c: np.abs(c - centre).max())

    centre = back(there(q))
    f = [[near(back(there(q + m * s)), centre) for m in (1, -1, 2, -2)] for s in steps]
    J = np.stack([(8 * (p - n) - (pp - nn)) / 12e-3 for p, n, pp, nn in f], axis=1)
    return centre, J


@pytest.mark.parametrize("c", [0.0, 0.7])
def test_two_sided_invariance(c):
    """phi -> L phi R leaves the affine metric for any L, R of GL+, the breathing top's for SU(2), and nothing more."""
    for q in POINTS.T[:4]:
        for left, right in ((random_gl(), np.eye(2)), (np.eye(2), random_gl()), (random_gl(), random_gl())):
            there, J = moved(q, lambda p, m=left, n=right: m @ AFFINE_BODY.matrix(p) @ n, coordinates)
            np.testing.assert_allclose(J.T @ g.affine_metric(there, c) @ J, g.affine_metric(q, c), rtol=0, atol=1e-7)
        for left, right in ((random_su2(), np.eye(2)), (np.eye(2), random_su2()), (random_su2(), random_su2())):
            there, J = moved(q, lambda p, m=left, n=right: m @ BREATHING_TOP.matrix(p) @ n, euler_angles)
            np.testing.assert_allclose(
                J.T @ g.breathing_metric(there, c) @ J, g.breathing_metric(q, c), rtol=0, atol=1e-7
            )
    q = POINTS[:, 0]
    left = np.diag([1.5, 0.8])
    there, J = moved(q, lambda p: left @ AFFINE_BODY.matrix(p), coordinates)
    isotropic = np.exp(q[0]) * g.affine_metric(q, c)  # the printed EQ6.22 does not survive
    assert np.abs(J.T @ g.affine_metric(there, c) @ J * np.exp(there[0]) - isotropic).max() > 0.01


def test_two_sided_invariance_of_forms():
    """At the level of tangents, for all metrics: Omega -> L Omega L^-1, hat Omega -> R^-1 hat Omega R; U(2) too."""
    phi, dphi = random_gl(), RNG.normal(size=(2, 2))
    left, right = random_gl(), random_gl()
    there = left @ phi @ right, left @ dphi @ right
    np.testing.assert_allclose(g.omega(*there), left @ g.omega(phi, dphi) @ np.linalg.inv(left), rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        g.omega_hat(*there), np.linalg.inv(right) @ g.omega_hat(phi, dphi) @ right, rtol=0, atol=1e-12
    )
    for main, dilatation in ((1, 0), (0, 1), (4, -2), (0.5, 0.3)):
        before = g.invariant_form(g.omega(phi, dphi), g.omega(phi, dphi), main=main, dilatation=dilatation)
        hat = g.omega_hat(*there)
        assert g.invariant_form(hat, hat, main=main, dilatation=dilatation) == pytest.approx(before, rel=1e-10)
    U, V = np.exp(0.3j) * random_su2(), np.exp(-1.1j) * random_su2()
    for q in POINTS.T[:3]:
        tangents = UNITARY.tangents(q)
        Omega = np.stack([g.omega(U @ UNITARY.matrix(q) @ V, U @ t @ V) for t in tangents])
        pulled = g.gram(lambda x, y: g.invariant_form(x, y, main=-0.5, dilatation=-0.7 / 4), Omega)
        np.testing.assert_allclose(pulled, g.unitary_metric(q, 0.7), rtol=0, atol=1e-13)


def test_killing_form():
    """Tr(ad_X ad_Y) from the matrices of ad; degenerate on the centre only; positive on the two boosts, negative on
    rotations.
    """
    basis = TAU_TILDE
    c = g.structure_constants(basis)
    ad = np.einsum("abk->akb", c)
    traces = np.einsum("akb,dbk->ad", ad, ad)
    killing = g.gram(g.killing_form, basis)
    np.testing.assert_allclose(killing, traces, rtol=0, atol=1e-14)
    assert g.signature(killing) == (2, 1, 1)
    np.testing.assert_allclose(killing[0], 0, atol=1e-15)
    assert abs(np.linalg.det(killing[1:, 1:])) == pytest.approx(8)
    pulled = g.gram(g.killing_form, AFFINE_BODY.cartan_forms(POINTS)[0])
    np.testing.assert_allclose(pulled / 8, g.affine_metric(POINTS, -1.0), rtol=0, atol=1e-12)
    assert g.signature(g.gram(g.invariant_form, basis)) == (3, 1, 0)
    su2 = g.gram(g.killing_form, TAU[1:])
    np.testing.assert_allclose(su2, -2 * np.eye(3), rtol=0, atol=1e-15)  # compact: negative


@pytest.mark.parametrize("c", SIGNS)
def test_continuation_to_the_compact_form(c):
    """b = i Theta, a -> i a: minus EQ6.16; b alone: EQ6.23; and the matrices follow, tilde tau_3 Theta i = -tau_3
    Theta.
    """
    a, Phi, Theta, Psi = POINTS
    np.testing.assert_allclose(g.continued_affine_metric(POINTS, c), -g.unitary_metric(POINTS, c), rtol=0, atol=1e-15)
    turned = g.affine_metric(np.stack([a, Phi, 1j * Theta, Psi]), c)
    J = np.array([1, 1, 1j, 1])
    pulled = np.einsum("i,ijn,j->ijn", J, turned, J)
    assert np.abs(pulled.imag).max() < 1e-15
    np.testing.assert_allclose(4 * pulled.real[1:, 1:], -g.top_metric(POINTS[1:]), rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        AFFINE_BODY.matrix(np.stack([1j * a, Phi, 1j * Theta, Psi])),
        UNITARY.matrix(np.stack([a, Phi, -Theta, Psi])),
        rtol=0,
        atol=1e-14,
    )


def test_body_and_top_are_one_linear_isometry():
    """EQ6.4 and EQ6.10: planes -> R+SU(2) keeps Phi, Theta, Psi and rho = delta, and half the trace."""
    a, Phi, Theta, Psi = POINTS
    planes = EULER.points_to_planes([np.exp(a / 2), Phi, Theta, Psi])
    np.testing.assert_allclose(g.top_of_planes(planes), BREATHING_TOP.matrix(POINTS), rtol=0, atol=1e-13)
    image = g.top_of_planes(np.eye(4))
    np.testing.assert_allclose(g.gram(g.trace_form, np.moveaxis(image, -1, 0)) / 2, np.eye(4), rtol=0, atol=1e-15)
    rho, r = [np.exp(a / 2), Phi, Theta, Psi], [np.exp(a), Phi, Theta, Psi]
    np.testing.assert_allclose(EULER.metric(rho), g.breathing_metric_delta(rho), rtol=1e-13)
    np.testing.assert_allclose(R_EULER.metric(r), g.breathing_metric_lambda(r), rtol=1e-13)


def test_bad_input_is_named():
    singular = np.zeros((2, 2, 3))
    singular[0, 0] = singular[1, 1] = (1, 1, 0)
    for form in (g.omega, g.omega_hat):
        with pytest.raises(ValueError, match=r"phi must be invertible; det phi = 0 at orbit \(2,\)"):
            form(singular, singular)
        with pytest.raises(ValueError, match=r"phi must be .*\(2, 2, ...\), got shape \(4,\)"):
            form(np.ones(4), np.ones((2, 2)))
    for metric in (
        g.breathing_metric,
        g.breathing_metric_delta,
        g.breathing_metric_lambda,
        g.unitary_metric,
        g.affine_metric,
        g.affine_metric_delta,
        g.affine_metric_lambda,
        g.continued_affine_metric,
        BREATHING_TOP.matrix,
    ):
        with pytest.raises(ValueError, match=r"q must be .* shape \(4, ...\), got shape \(3,\)"):
            metric(np.ones(3))
        with pytest.raises(ValueError, match=r"q must be .* got nan"):
            metric([np.nan, 0, 0, 0])
        assert metric(POINTS).shape[:2] == metric(POINTS[:, 0]).shape
    for metric, name in (
        (g.breathing_metric_lambda, "lambda"),
        (g.affine_metric_lambda, "lambda"),
        (g.affine_metric_delta, "delta"),
    ):
        with pytest.raises(ValueError, match=f"{name} must not be 0 at orbit \\(1,\\)"):
            metric(np.array([[1.0, 0.0]] + [[1.0, 1.0]] * 3))
    with pytest.raises(ValueError, match="metric takes one symmetric matrix"):
        g.signature([[1, 2], [3, 4]])
    with pytest.raises(ValueError, match="basis takes"):
        g.gram(g.killing_form, np.eye(2))
