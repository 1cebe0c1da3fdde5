"""Factors and product states: against mpmath, their equations, quadratures, and the Schroedinger equation of R^4."""

from dataclasses import dataclass
from math import factorial, gamma, pi, sqrt

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import eval_genlaguerre, gammaln

from fastaff import Anharmonic, Body, Harmonic, Hyperelastic, NeoHookean, SeparableAlphaBeta
from fastaff.quantum.exact.wavefunction import wavefunction
from fastaff.quantum.reference.matrices import class_matrices, radial_matrices
from fastaff.quantum.reference.operators import constant_operators, hamiltonian_operator, laplacian, spin, vorticity
from fastaff.quantum.spectra.spectrum import spectrum
from fastaff.quantum.states.factors import AngleFactor, PlaneFactor, RadialFactor
from fastaff.quantum.states.state import Product, State
from fastaff.systems.charts import (
    ALPHA_BETA,
    ALPHA_BETA_PHI_PSI,
    CARTESIAN,
    ELLIPTIC,
    EULER,
    EXPONENTIAL,
    POLAR_POLAR,
    R_VARTHETA,
    SPHERICAL,
    SPHERICAL_CARTESIAN,
    TWO_POLAR,
    to_matrix,
)
from fastaff.systems.models import Oscillator

CHARTS = (ALPHA_BETA, R_VARTHETA)
every_chart = pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: chart.name)
HARMONIC, ANHARMONIC = Body(Harmonic(1.3), 0.7), Body(Anharmonic(1.1), 0.8)
WALLS = Body(SeparableAlphaBeta(Oscillator(1.3, 0.4), Oscillator(0.7, 1.1)), mu=0.6)
SIZES = [(0, 0.0), (1, 2.5), (7, 0.0), (12, 40.3), (60, 500.0), (500, 0.0), (500, 3.7), (500, 500.0)]


def exact_laguerre(n, s, x, kappa):
    """f_alpha at 40 digits beyond what the recurrence loses."""
    with mpmath.workdps(60 + int(kappa * x * x / 4)):
        s, t = mpmath.mpf(s), mpmath.mpf(kappa) * mpmath.mpf(x) ** 2
        before, L = mpmath.mpf(0), mpmath.mpf(1)
        for k in range(n):
            before, L = L, ((2 * k + 1 + s - t) * L - (k + s) * before) / (k + 1)
        norm = mpmath.sqrt(2 * mpmath.mpf(kappa) * mpmath.factorial(n) / mpmath.gamma(n + s + 1))
        return float(norm * t ** (s / 2) * mpmath.exp(-t / 2) * L)


def exact_jacobi(n, a, b, theta):
    """f_vartheta from the paper's hypergeometric polynomial, term by term, and Gamma functions."""
    with mpmath.workdps(60 + 4 * n // 5):
        a, b, v = mpmath.mpf(a), mpmath.mpf(b), mpmath.mpf(theta)
        term = total = mpmath.mpf(1)
        for k in range(n):
            term *= (k - n) * (1 + n + a + b + k) * mpmath.cos(v / 2) ** 2 / ((1 + a + k) * (k + 1))
            total += term
        norm = mpmath.rf(1 + a, n) / mpmath.factorial(n)
        norm *= mpmath.sqrt((2 * n + a + b + 1) * mpmath.factorial(n) * mpmath.gamma(n + a + b + 1) / 2)
        norm /= mpmath.sqrt(mpmath.gamma(n + a + 1) * mpmath.gamma(n + b + 1))
        return float(norm * mpmath.cos(v / 2) ** a * mpmath.sin(v / 2) ** b * total)


@pytest.mark.parametrize(("n", "s"), SIZES)
def test_plane_and_radial_factors_to_1e12(n, s):
    kappa = 1.7
    top = sqrt((4 * n + 2 * s + 2) / kappa) * 1.15
    x = np.concatenate([[0.0, 1e-3], np.linspace(0.1, 1, 5 if n > 100 else 9) * top])
    exact = np.array([exact_laguerre(n, s, value, kappa) for value in x])
    factor = PlaneFactor(n, s, kappa)
    largest = np.abs(factor(np.linspace(0, top, 4000))).max()
    assert np.abs(factor(x) - exact).max() < 1e-12 * largest
    radial, x = RadialFactor(n, s + 1, kappa), x[2::3]  # f_r of index s times r^(1/2) is the plane's factor over sqrt2
    largest = np.abs(radial(np.linspace(0, top, 4000) ** 2)).max()
    exact = np.array([exact_laguerre(n, s + 1, value, kappa) for value in x]) / (sqrt(2) * x)
    assert np.abs(radial(x**2) - exact).max() < 1e-12 * largest
    np.testing.assert_array_equal(radial.of_rho(x), sqrt(2) * radial(x**2))


@pytest.mark.parametrize(
    ("n", "b", "a"), [(*size, a) for size, a in zip(SIZES, (0.0, 3.0, 12.3, 0.0, 500.0, 0.0, 12.3, 500.0))]
)
def test_shear_factor_to_1e12(n, b, a):
    theta = np.array([1e-3, 0.4, 1.7, 3.1] if n > 100 else [0.0, 1e-9, 1e-3, 0.1, 0.6, 1.1, 1.6, 2.1, 2.6, 3.1, np.pi])
    for factor in (AngleFactor(n, a, b), AngleFactor(n, b, a)):
        exact = np.array([exact_jacobi(n, factor.a, factor.b, value) for value in theta])
        largest = np.abs(factor(np.linspace(0, np.pi, 4000))).max()
        assert np.abs(factor(theta) - exact).max() < 1e-12 * largest


@pytest.mark.parametrize(("n", "s"), SIZES)
def test_far_away_factors_vanish(n, s):
    """No overflow, no 0*inf, from 0 to the largest number."""
    factor, radial = PlaneFactor(n, s, 1.0), RadialFactor(n, s + 1.0, 1.0)
    x = np.array([1e3, 1e10, 1e150, np.inf])
    assert not factor(x).any()
    assert not radial(x**2 if n < 500 else x[1:] ** 2).any()
    assert np.isfinite(factor(np.array([0.0, 5e-324, 1e-160, 1e-3]))).all()
    assert (factor(0.0) != 0) == (s == 0)


FACTORS = {
    "plane": (lambda n: PlaneFactor(n, 2.3, 1.7), 1.0),
    "plane s = 0": (lambda n: PlaneFactor(n, 0.0, 0.6), 1.0),
    "r": (lambda n: RadialFactor(n, 1.0, 1.7), 1.0),
    "r weak": (lambda n: RadialFactor(n, 0.4, 1.7), 1.0),
    "r s = 80": (lambda n: RadialFactor(n, 80.5, 0.4), 1.0),
    "vartheta": (lambda n: AngleFactor(n, 0.0, 3.0), 1.0),
    "vartheta (0, 0)": (lambda n: AngleFactor(n, 0.0, 0.0), 1.0),
    "vartheta far": (lambda n: AngleFactor(n, 100.5, 30.0), 1.0),
}


@pytest.mark.parametrize("name", FACTORS)
@pytest.mark.parametrize(("least", "order"), [(0, 25), (90, 130)])
def test_factors_are_orthonormal_by_their_rule(name, least, order):
    make = FACTORS[name][0]
    x, weights = make(0).rule(order)
    assert (np.diff(x) > 0).all() if name[0] != "v" else (np.diff(np.sort(x)) > 0).all()
    rows = np.array([make(least + k)(x) for k in range(20)])
    np.testing.assert_allclose(rows * weights @ rows.T, np.eye(20), atol=1e-12)


STATES = [
    (HARMONIC, 0, 0, (0, 0)),
    (HARMONIC, 3, -1, (1, 2)),
    (HARMONIC, -2, -2, (2, 1)),
    (ANHARMONIC, 2, -4, (2, 1)),
    (ANHARMONIC, 1, 1, (0, 3)),
]
every_state = pytest.mark.parametrize(("body", "m", "l", "n"), STATES, ids=lambda v: str(v)[:20])


@every_state
@every_chart
def test_schroedinger_equation_in_every_chart(body, m, l, n, chart):
    """H Psi = E Psi with the Laplacian of R^4 in matrix elements, and with that of each chart."""
    hbar = 0.8
    state = wavefunction(body, m=m, l=l, n=n, hbar=hbar, chart=chart)
    rng = np.random.default_rng(1)
    planes = rng.uniform(0.45, 1.0, (4, 8)) * rng.choice([-1, 1], (4, 8))
    planes = planes[:, np.abs(np.hypot(planes[0], planes[1]) - np.hypot(planes[2], planes[3])) > 0.05]
    matrices = to_matrix(np.concatenate([planes, planes]))[0]
    scale = state.energy * np.abs(state(matrices)).max()
    for laplace in (CARTESIAN, ALPHA_BETA, ALPHA_BETA_PHI_PSI, R_VARTHETA, EULER):
        q = laplace.points_from_planes(planes)
        left = hamiltonian_operator(body, laplace, hbar=hbar)(lambda x, c=laplace: state.at(x, c), q)
        assert np.abs(left - state.energy * state.planes(planes)).max() < 1e-10 * scale, laplace.name
    values = state(matrices)
    assert np.abs(spin(state, matrices, hbar=hbar) - hbar * m * values).max() < 1e-10 * scale
    assert np.abs(vorticity(state, matrices, hbar=hbar) - hbar * l * values).max() < 1e-10 * scale
    q = chart.points_from_planes(planes)
    values = state.constants | {"H": state.energy, "p_phi": hbar * m, "p_psi": hbar * l}
    values |= {"H_alpha": values.get("E_alpha"), "H_beta": values.get("E_beta"), "h_vartheta": values.get("e_vartheta")}
    for name, operator in constant_operators(body, chart, hbar=hbar).items():
        gap = np.abs(operator(lambda x: state.at(x, chart), q) - (values.get(name) or 0.0) * state.at(q, chart)).max()
        assert (gap < 1e-10 * scale) == (name != "H_r"), name  # H_r alone is no constant: no eigenvalue either


def test_laplacians_are_one_operator():
    """On a function that is no eigenstate; the step's error falls as step^8."""

    def function(x):
        return np.exp(0.3j * x[0] - 0.2 * x[3] ** 2) * (1 + x[1] * x[2])

    x = np.random.default_rng(2).uniform(0.5, 1.0, (4, 5)) * np.array([[1], [-1], [1], [-1]])
    planes = CARTESIAN.points_to_planes(x)
    truth = function(x) * (-0.09 - 0.4 + 0.16 * x[3] ** 2)
    errors = []
    paper = CARTESIAN, ALPHA_BETA, ALPHA_BETA_PHI_PSI, R_VARTHETA, EULER
    for chart in (*paper, ELLIPTIC, SPHERICAL, SPHERICAL_CARTESIAN, POLAR_POLAR):
        q = chart.points_from_planes(planes)

        def of_chart(at, chart=chart):
            return function(CARTESIAN.points_from_planes(chart.points_to_planes(at)))

        found = [laplacian(chart)(of_chart, q, step=h) for h in (0.02, 0.16, 0.08)]
        assert np.abs(found[0] - truth).max() < 1e-9, chart.name
        errors.append([np.abs(f - truth).max() for f in found[1:]])
    assert errors[0][0] / errors[0][1] == pytest.approx(256, rel=0.2)


@every_state
def test_elliptic_constant_is_the_sum_of_the_others(body, m, l, n):
    """K of the elliptic chart, by its separated operators, is H_alpha + h_vartheta/2 - C/4 on any function of the
    class.
    """
    hbar, mu, C = 0.8, body.mu, body.potential.C
    wall = 2 * C if body is ANHARMONIC else 0.0
    state = wavefunction(body, m=m, l=l, n=n, hbar=hbar)
    q = ELLIPTIC.points_from_planes(np.random.default_rng(1).uniform(0.4, 0.9, (4, 5)) * np.array([[2], [1], [1], [1]]))
    h, steps = 0.02, np.arange(-4, 5)
    first = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / h
    second = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]) / h**2

    def along(row, weights):
        points = np.repeat(q[:, None], 9, axis=1)
        points[row] += h * steps[:, None]
        return np.tensordot(weights, state.at(points, ELLIPTIC), axes=1)

    (k, lam), Psi = q[:2], state.at(q, ELLIPTIC)
    p_eta, p_gamma = hbar * (m - l) / 2, hbar * (m + l) / 2
    V_k = C / 2 * np.cosh(2 * k) ** 2 - wall / np.cosh(k) ** 2
    V_l = -C / 2 * np.cos(2 * lam) ** 2 + wall / np.cos(lam) ** 2
    h_k = -(hbar**2) * (along(0, second) + (np.tanh(k) + 1 / np.tanh(k)) * along(0, first)) / (2 * mu)
    h_k += (V_k + (-((p_eta / np.cosh(k)) ** 2) + (p_gamma / np.sinh(k)) ** 2) / (2 * mu)) * Psi
    h_l = -(hbar**2) * (along(1, second) + (1 / np.tan(lam) - np.tan(lam)) * along(1, first)) / (2 * mu)
    h_l += (V_l + ((p_eta / np.cos(lam)) ** 2 + (p_gamma / np.sin(lam)) ** 2) / (2 * mu)) * Psi
    distance = np.cosh(k) ** 2 - np.cos(lam) ** 2
    K = (h_k * np.cos(lam) ** 2 + h_l * np.cosh(k) ** 2) / (2 * distance)
    L = (h_k * np.sin(lam) ** 2 - h_l * np.sinh(k) ** 2) / (2 * distance)
    at_r = R_VARTHETA.points_from_planes(ELLIPTIC.points_to_planes(q))
    shear = constant_operators(body, R_VARTHETA, hbar=hbar)["h_vartheta"](lambda x: state.at(x, R_VARTHETA), at_r)
    expected = (state.constants["E_alpha"] - C / 4) * Psi + shear / 2
    assert np.abs(K - expected).max() < 1e-9 * np.abs(expected).max()
    assert np.abs(K + L - state.energy * Psi).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize(("body", "m", "l"), [(HARMONIC, 3, -1), (ANHARMONIC, 2, -4)])
def test_overlaps_of_the_two_charts_are_eigenvectors_of_h_vartheta(body, m, l):
    hbar, N = 0.6, 5
    planes, shears = (
        [wavefunction(body, m=m, l=l, n=(N - k, k), hbar=hbar, chart=chart) for k in range(N + 1)] for chart in CHARTS
    )
    overlaps = np.array([[plane.overlap(shear) for shear in shears] for plane in planes])
    np.testing.assert_allclose(overlaps, [[shear.overlap(plane) for shear in shears] for plane in planes], atol=1e-12)
    np.testing.assert_allclose(overlaps @ overlaps.T, np.eye(N + 1), atol=1e-12)
    found = class_matrices(body, m=m, l=l, shells=N + 1, hbar=hbar)
    block = np.array([np.flatnonzero((found.basis[0] == N - k) & (found.basis[1] == k))[0] for k in range(N + 1)])
    h = found.h_vartheta[np.ix_(block, block)]
    e = [shear.constants["e_vartheta"] for shear in shears]
    np.testing.assert_allclose(h @ overlaps, overlaps * e, atol=1e-11 * max(e))  # signs of both bases included
    other = wavefunction(body, m=m + 2, l=l, n=(0, 0), hbar=hbar)
    assert planes[0].overlap(other) == 0.0


@every_state
def test_radial_matrix_by_quadrature(body, m, l, n):
    found = radial_matrices(body, m=m, l=l, n_vartheta=n[1], size=5, hbar=0.8)
    states = [wavefunction(body, m=m, l=l, n=(k, n[1]), hbar=0.8, chart=R_VARTHETA) for k in range(5)]
    nodes, weights = np.polynomial.legendre.leggauss(150)
    r = states[-1].shape.factors[0].rule(60)[0].max() * (nodes + 1) / 2
    w = weights * r.max() / (nodes.max() + 1)
    rows = np.array([state.shape.factors[0](r) for state in states])
    np.testing.assert_allclose(found.h_over_r, states[0].constants["e_vartheta"] * (rows * w) @ rows.T, atol=1e-10)


@every_chart
def test_harmonic_states_are_products_of_two_planar_oscillators(chart):
    """The polynomial in the complex coordinates of the planes, by scipy's Laguerre polynomials: smooth on all of
    R^4.
    """
    m, l, hbar, kappa = 3, -5, 0.9, sqrt(1.3 * 0.7) / 0.9
    planes = np.random.default_rng(3).normal(size=(4, 3, 50))
    planes[:2, 0, 0], planes[2:, 1, 1], planes[:, 2, 2] = 0.0, 0.0, 0.0  # alpha = 0, beta = 0, both
    a, b = planes[0] + 1j * planes[1], planes[2] + 1j * planes[3]
    eta, gamma_ = (m - l) // 2, (m + l) // 2  # 4, -1

    def one(z, k, n):
        t = kappa * np.abs(z) ** 2
        norm = np.sqrt(kappa / pi * factorial(n) / gamma(n + abs(k) + 1)) * kappa ** (abs(k) / 2)
        return norm * (z if k > 0 else z.conj()) ** abs(k) * np.exp(-t / 2) * eval_genlaguerre(n, abs(k), t)

    n = (2, 3) if chart is ALPHA_BETA else (0, 0)  # the lowest of its class is one state in both charts
    expected = one(a, eta, n[0]) * one(b, gamma_, n[1])
    state = wavefunction(HARMONIC, m=m, l=l, n=n, hbar=hbar, chart=chart)
    np.testing.assert_allclose(state.planes(planes), expected, atol=1e-14)
    np.testing.assert_allclose(state(to_matrix(np.concatenate([planes, planes]))[0]), expected, atol=1e-14)


@every_state
@every_chart
@given(D1=st.floats(0.2, 2), ratio=st.floats(-0.99, 0.99), phi=st.floats(0, 6), psi=st.floats(0, 6))
def test_one_value_for_every_name_of_a_matrix(body, m, l, n, chart, D1, ratio, phi, psi):
    """Psi = e^(i m phi + i l psi) amplitude on the canonical sheet, and one value on all sheets: m + l even."""
    state, D2 = wavefunction(body, m=m, l=l, n=n, chart=chart), D1 * ratio
    value = state.amplitude(D1, D2, TWO_POLAR) * np.exp(1j * (m * phi + l * psi))
    sheets = np.array(
        [
            (D1, D2, phi, psi),
            (D2, D1, phi + pi / 2, psi + pi / 2),
            (D1, D2, phi + pi, psi + pi),
            (-D1, -D2, phi + pi, psi),
        ]
    ).T
    np.testing.assert_allclose(state.at(sheets, TWO_POLAR), np.full(4, value), atol=1e-13)


@every_chart
def test_two_values_on_the_covering(chart):
    state = wavefunction(ANHARMONIC, m=2, l=1, n=(1, 2), chart=chart, single_valued=False)
    q = np.array([1.1, 0.7, 0.4, 0.9])
    once, again = state.at(q, ALPHA_BETA_PHI_PSI), state.at(q + np.array([0, 0, pi, pi]), ALPHA_BETA_PHI_PSI)
    assert again == pytest.approx(-once, rel=1e-13)
    assert once == pytest.approx(state.amplitude(1.1, 0.7, ALPHA_BETA) * np.exp(1j * (2 * 0.4 + 0.9)), rel=1e-13)
    assert state.at([1.1, 0.7, 0.4 - 0.9, 0.4 + 0.9]) == pytest.approx(once, rel=1e-13)
    rho, vartheta = np.hypot(1.1, 0.7), 2 * np.arctan2(0.7, 1.1)
    assert state.at([rho, 0.8, vartheta, -1.8], EULER) == pytest.approx(once, rel=1e-13)
    assert state.norm() == pytest.approx(1, abs=1e-12)
    for call in (lambda: state.planes(np.ones(4)), lambda: state(np.eye(2))):
        with pytest.raises(ValueError, match="two values"):
            call()
    with pytest.raises(ValueError, match="radii >= 0"):
        state.at([-1.1, 0.7, 0.4, 0.9])
    with pytest.raises(ValueError, match="must have the angles"):
        state.at([1.1, 0.7, 0.4, 0.9], CARTESIAN)


@every_state
@every_chart
def test_norm_density_and_expectation(body, m, l, n, chart):
    """The densities of three pairs of invariants integrate to 1 over grids of their own, and agree with |Psi|^2."""
    hbar = 0.9
    state = wavefunction(body, m=m, l=l, n=n, hbar=hbar, chart=chart)
    assert abs(state.norm() - 1) < 1e-12
    assert abs(state.norm(order=80) - 1) < 1e-12
    kappa = sqrt(body.potential.C * body.mu) / hbar
    top = sqrt((4 * sum(n) + 2 * abs(m) + 2 * abs(l) + 60) / kappa)
    x, w = np.polynomial.legendre.leggauss(160)
    u, v = (x + 1) / 2, w / 2
    for own, function, X, Y, weight in (
        (ALPHA_BETA, lambda x, y: x * x - 0.3 * y * y, top * u[:, None], top * u, top * top * np.outer(v, v)),
        (
            R_VARTHETA,
            lambda x, y: x * np.cos(y),
            top**2 * u[:, None] ** 2,
            pi * u,
            top**2 * pi * np.outer(2 * u * v, v),
        ),
        (
            TWO_POLAR,
            lambda x, y: x * y,
            top * u[:, None],
            top * u[:, None] * (2 * u - 1),
            top * top * np.outer(u * v, 2 * v),
        ),
    ):
        density = state.density(X, Y, own)
        assert np.sum(density * weight) == pytest.approx(1, abs=1e-10), own.name
        assert np.sum(density * weight * function(X, Y)) == pytest.approx(
            state.expectation(function, chart=own), abs=1e-10
        ), own.name
    assert state.density(0.3, 0.5, TWO_POLAR) == 0
    alpha, beta = np.array([0.7, 1.3]), np.array([0.5, 1.4])
    square = np.abs(state.at([alpha, beta, 0.3 + 0 * alpha, 0.2 + 0 * alpha])) ** 2
    D1, D2, r, vartheta = (
        (alpha + beta) / sqrt(2),
        (alpha - beta) / sqrt(2),
        alpha**2 + beta**2,
        2 * np.arctan2(beta, alpha),
    )
    inside = D2 > -D1
    np.testing.assert_allclose(state.density(alpha, beta, ALPHA_BETA), 4 * pi**2 * alpha * beta * square, rtol=1e-12)
    np.testing.assert_allclose(
        state.density(r, vartheta, R_VARTHETA), pi**2 / 2 * r * np.sin(vartheta) * square, rtol=1e-12
    )
    np.testing.assert_allclose(
        state.density(D1, D2, TWO_POLAR)[inside], (2 * pi**2 * (D1**2 - D2**2) * square)[inside], rtol=1e-12
    )
    if body is HARMONIC:  # the virial theorem
        assert state.expectation(lambda a, b: 1.3 * (a * a + b * b) / 2, chart=ALPHA_BETA) == pytest.approx(
            state.energy / 2, rel=1e-12
        )
    else:  # Hellmann and Feynman: C dE/dC = <V>
        V = state.expectation(lambda a, b: body.potential.value(a * a, b * b), chart=ALPHA_BETA, order=400)
        d = 1e-4
        E = [wavefunction(Body(Anharmonic(1.1 * f), 0.8), m=m, l=l, n=n, hbar=hbar).energy for f in (1 - d, 1 + d)]
        assert pytest.approx((E[1] - E[0]) / (2 * d), rel=1e-4) == V  # 1/alpha^2 is no polynomial: error order^(-s)
    assert state.expectation(lambda x, y: 1j + 0 * x) == pytest.approx(1j, rel=1e-12)


@dataclass(frozen=True)
class PlaneByScipy:
    """A factor that some other program found: values, a degree, a rule."""

    n: int
    s: float
    kappa: float

    def __call__(self, x):
        t = self.kappa * np.square(x)
        log_norm = (np.log(2 * self.kappa) + gammaln(self.n + 1) - gammaln(self.n + self.s + 1)) / 2
        return np.exp(log_norm - t / 2) * t ** (self.s / 2) * eval_genlaguerre(self.n, self.s, t)

    @property
    def degree(self):
        return self.n

    def rule(self, order):
        nodes, weights = np.polynomial.legendre.leggauss(4 * order)
        end = sqrt(80 / self.kappa)
        x = end * (nodes + 1) / 2
        return x, x * weights * end / 2


def test_factors_from_elsewhere_make_states():
    own = wavefunction(ANHARMONIC, m=2, l=-4, n=(2, 1))
    factors = tuple(PlaneByScipy(f.n, f.s, f.kappa) for f in own.shape.factors)
    other = State(own.symmetry, Product(own.chart, factors), own.numbers, own.energy, own.constants, own.hbar)
    planes = np.random.default_rng(5).normal(size=(4, 100))
    np.testing.assert_allclose(other.planes(planes), own.planes(planes), atol=1e-14)
    assert other.norm() == pytest.approx(1, abs=1e-12)
    assert own.overlap(other) == pytest.approx(1, abs=1e-12)
    assert other.labels == {"n_alpha": 2, "n_beta": 1, "m": 2, "l": -4}


@every_chart
def test_values_depend_neither_on_neighbours_nor_on_threads(chart, two_threads):
    import numba

    state = wavefunction(ANHARMONIC, m=2, l=-4, n=(40, 3), chart=chart)
    planes = 2 * np.random.default_rng(7).normal(size=(4, 1000))
    together = state.planes(planes)
    numba.set_num_threads(1)
    alone = state.planes(planes)
    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    np.testing.assert_array_equal(together, alone)


@every_chart
def test_values_depend_not_on_neighbours(chart):
    state = wavefunction(ANHARMONIC, m=2, l=-4, n=(40, 3), chart=chart)
    planes = 2 * np.random.default_rng(7).normal(size=(4, 300))
    together = state.planes(planes)
    factor = state.shape.factors[1]
    x = np.linspace(0, 3, 300)
    values = factor(x)
    for k in (0, 127, 128, 299):
        assert factor(x[k]) == values[k]
        assert state.planes(planes[:, k]) == together[k]
    assert state.planes(planes[:, :0]).shape == (0,)
    assert state.planes(planes.reshape(4, 3, 100)).shape == (3, 100)


def wave(**change):
    return wavefunction(change.pop("model", HARMONIC), **({"n": (0, 0), "m": 0, "l": 0} | change))


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"n": (0, -1)}, ValueError, "n2 must be at least 0"),
        ({"n": (0.5, 0)}, ValueError, "n1 must be a whole"),
        ({"n": 1}, TypeError, "n must be two"),
        ({"n": (1, 2, 3)}, TypeError, "n must be two"),
        ({"m": 1}, ValueError, r"m \+ l must be even"),
        ({"m": 0.5}, ValueError, "m must be a whole"),
        ({"l": "0"}, TypeError, "l must be a whole"),
        ({"hbar": 0}, ValueError, "hbar must be positive"),
        ({"hbar": np.nan}, ValueError, "hbar must be finite"),
        ({"chart": TWO_POLAR}, ValueError, "chart must be"),
        ({"chart": "alpha-beta"}, ValueError, "chart must be"),
        ({"model": Body(Hyperelastic()), "chart": R_VARTHETA}, ValueError, "closed-form"),
        ({"model": Body(NeoHookean())}, ValueError, "model must be separable, got a Body of NeoHookean"),
        ({"model": WALLS, "chart": R_VARTHETA}, ValueError, "chart must separate"),
        ({"model": Body(Harmonic(), -1.0)}, ValueError, "mu must be positive"),
    ],
    ids=str,
)
def test_bad_input(change, error, words):
    with pytest.raises(error, match=words):
        wave(**change)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (
            lambda: wave()(np.eye(3)),
            ValueError,
            r"phi must be finite real numbers of shape \(2, 2, \.\.\.\), got shape",
        ),
        (
            lambda: wave()(np.nan * np.eye(2)),
            ValueError,
            r"phi must be finite real numbers of shape \(2, 2, \.\.\.\), got nan",
        ),
        (
            lambda: wave().planes(np.ones(3)),
            ValueError,
            r"planes must be finite real numbers of shape \(4, \.\.\.\), got shape",
        ),
        (
            lambda: wave().at(np.ones(4) * 1j),
            TypeError,
            r"q must be finite real numbers of shape \(4, \.\.\.\), got ndarray of",
        ),
        (lambda: wave().density(1.0, 1.0, EXPONENTIAL), ValueError, "chart must be"),
        (lambda: wave().density(-1.0, 1.0), ValueError, r"x \(alpha\) must lie"),
        (
            lambda: wave().density(1.0, np.inf),
            ValueError,
            r"y \(beta\) must be finite real numbers, got inf\.",
        ),
        (lambda: wave().expectation(np.add, chart=EULER), ValueError, "chart must be"),
        (lambda: wave().norm(order=0), ValueError, "order must be"),
        (lambda: PlaneFactor(-1, 0.0, 1.0), ValueError, "n must be at least 0"),
        (lambda: PlaneFactor(0, -0.5, 1.0), ValueError, "s must be at least 0"),
        (lambda: PlaneFactor(0, 0.5, 0.0), ValueError, "kappa must be positive"),
        (lambda: RadialFactor(0, -0.1, 1.0), ValueError, "s must be at least 0"),
        (lambda: AngleFactor(0, 0.0, np.inf), ValueError, "b must be finite"),
        (lambda: PlaneFactor(0, 0.0, 1.0)([1.0, np.nan]), ValueError, "radius must lie"),
        (lambda: AngleFactor(0, 0.0, 1.0)(4.0), ValueError, "vartheta must lie"),
        (lambda: AngleFactor(0, 0.0, 1.0)(1j), TypeError, "vartheta must be an array of real numbers"),
        (lambda: laplacian(TWO_POLAR), ValueError, "chart must be one of"),
        (lambda: constant_operators(HARMONIC, CARTESIAN), ValueError, "chart must be alpha-beta"),
        (lambda: hamiltonian_operator(HARMONIC, hbar=-1.0), ValueError, "hbar must be positive"),
        (lambda: spin(wave(), np.eye(2), step=0.0), ValueError, "step must be positive"),
    ],
)
def test_bad_calls(call, error, words):
    with pytest.raises(error, match=words):
        call()


@pytest.fixture(scope="module")
def states_of_every_solver():
    """One state in closed form, of each chart, one found numerically, and one of a body that does not separate."""
    exact = [wavefunction(HARMONIC, m=2, l=0, n=(1, 1), chart=chart) for chart in (ALPHA_BETA, R_VARTHETA)]
    return [
        *exact,
        *(
            spectrum(body, m=2, l=0, count=1, tolerance=1e-6).state(0)
            for body in (Body(Hyperelastic()), Body(NeoHookean()))
        ),
    ]


@pytest.mark.parametrize(
    ("x", "y", "chart", "words"),
    [
        (1.0, -0.5, ALPHA_BETA, r"y \(beta\) must lie in .0, inf., got -0.5$"),
        ([1.0, np.nan], 0.5, ALPHA_BETA, r"x \(alpha\) must be finite real numbers, got nan at index \(1,\)"),
        (-1.0, 0.5, R_VARTHETA, r"x \(r\) must lie"),
        (1.0, [0.5, -0.5], R_VARTHETA, r"y \(vartheta\) must lie in .0, 3.14., got -0.5 at index \(1,\)"),
        (1.0, np.nan, TWO_POLAR, r"y \(D2\) must be finite real numbers, got nan\."),
    ],
)
def test_states_of_every_solver_refuse_what_are_no_invariants(states_of_every_solver, x, y, chart, words):
    for state in states_of_every_solver:
        for method in (state.amplitude, state.density):
            with pytest.raises(ValueError, match=words):
                method(x, y, chart)


def test_outside_of_the_two_polar_chart_there_is_no_probability_and_no_amplitude(states_of_every_solver):
    for state in states_of_every_solver:
        assert state.density([1.0, -1.0], [1.5, 0.2], TWO_POLAR).tolist() == [0.0, 0.0]
        with pytest.raises(ValueError, match=r"D1 >= \|D2\|"):
            state.amplitude(1.0, 1.5, TWO_POLAR)


def test_amplitudes_of_numbers_are_numbers(states_of_every_solver):
    for state in states_of_every_solver:
        assert all(isinstance(state.amplitude(1, 1, chart), float) for chart in (ALPHA_BETA, R_VARTHETA))
