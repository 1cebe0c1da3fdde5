"""Tori in the charts of R^4: against quadratures of p dq, EQ2.2c, other charts, orbits and canonical relations."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad

import fastaff as fa
from fastaff import Body, Harmonic, SeparableAlphaBeta, SeparableElliptic, SeparableRVartheta, Status, action_angles
from fastaff.systems.charts import (
    CARTESIAN,
    POLAR_CARTESIAN,
    POLAR_POLAR,
    R_VARTHETA,
    SPHERICAL,
    SPHERICAL_CARTESIAN,
    TWO_POLAR,
)
from fastaff.systems.models import Barriers, CoshOscillator, CosOscillator, Oscillator, Spring, StackelBody, Zero

MIXED = (SPHERICAL_CARTESIAN, POLAR_POLAR, POLAR_CARTESIAN, CARTESIAN)
CHARTS = (SPHERICAL, *MIXED)
FACTORS = {
    SPHERICAL: (2, 1, 1, 1),
    SPHERICAL_CARTESIAN: (2, 1, 1, 1),
    POLAR_POLAR: (2, 1, 2, 1),
    POLAR_CARTESIAN: (2, 1, 1, 1),
    CARTESIAN: (1, 1, 1, 1),
}
"""E = (omega/2 pi) times the sum of factor |J|, by the rows of each chart."""


class Logarithm(NamedTuple):
    """V = ln(1 + r), of no separable family."""

    def value(self, A, B):
        return np.log(1 + A + B)

    def slopes(self, A, B):
        return 1 / (1 + A + B), 1 / (1 + A + B)

    def margin(self, A, B):
        return 1.0 + 0.0 * (A + B)


CORED = Body(SeparableRVartheta(Spring(1.1, 0.4), Barriers()), mu=0.9)
CASES = [
    *((Body(Harmonic(1.3), mu=0.7), chart) for chart in CHARTS),
    (CORED, SPHERICAL),
    (Body(Logarithm()), SPHERICAL),
]


def named(value):
    return value.name if hasattr(value, "name") else type(value.potential).__name__


def states(orbits, seed=5):
    return np.random.default_rng(seed).normal(size=(8, orbits))


def loop(square, low, high):
    """Closed integral of sqrt(square(x)) dx between neighbouring zeros."""
    middle, half = (low + high) / 2, (high - low) / 2

    def integrand(chi):
        x = middle - half * np.cos(chi)
        return np.sqrt(max(0.0, square(x))) * half * np.sin(chi)

    return 2 * quad(integrand, 0, np.pi, epsabs=1e-12, epsrel=1e-12, limit=200)[0]


@pytest.mark.parametrize(("body", "chart"), CASES, ids=named)
def test_actions_are_loops_of_the_momenta_of_the_chart(body, chart):
    z = states(6)
    found = action_angles(body, z, chart=chart)
    assert found.names == chart.names
    q = chart.from_planes(z)
    for k in range(z.shape[1]):
        for row, turns in enumerate(found.separated.family.rotating):
            if turns:
                assert found.J[row, k] == pytest.approx(2 * np.pi * q[4 + row, k], rel=1e-12, abs=1e-13)
                continue

            def square(x, row=row, k=k):
                return momentum_squared(body, chart, row, q[:, k], x)

            low, high = found.turning_points[row, :, k]
            assert abs(square(low)) + abs(square(high)) < 1e-9
            assert found.J[row, k] == pytest.approx(loop(square, low, high), rel=1e-8, abs=1e-9)


def momentum_squared(body, chart, row, q, x):
    """p_row^2 at the coordinate x on the torus of a phase point q (8,) of a chart."""
    weights = np.diag(chart.metric(q[:4]))
    if chart.names[row] == "mu":
        L = q[7] ** 2
        return q[4 + row] ** 2 + L / np.cos(q[row]) ** 2 - L / np.cos(x) ** 2
    # twice the kinetic energy of the angles around this coordinate, times mu
    inside = sum(q[4 + i] ** 2 / weights[i] for i in inner(chart, row))
    if chart.names[row] in ("lambda", "theta"):
        L = inside * weights[row] * np.sin(q[row]) ** 2
        return q[4 + row] ** 2 + L / np.sin(q[row]) ** 2 - L / np.sin(x) ** 2

    def V(r):
        return body.potential.value(r**2 / 2, r**2 / 2)

    L = inside * q[row] ** 2
    turned = L / q[row] ** 2 - (L / x**2 if L > 0 else 0.0)
    return q[4 + row] ** 2 + turned + 2 * body.mu * (V(q[row]) - V(x))


def inner(chart, row):
    """Rows of the angles whose momenta belong to the angular momentum around a coordinate."""
    return {
        SPHERICAL: {0: (1, 2, 3), 1: (2, 3)},
        SPHERICAL_CARTESIAN: {0: (1, 2), 1: (2,), 3: ()},
        POLAR_POLAR: {0: (1,), 2: (3,)},
        POLAR_CARTESIAN: {0: (1,), 2: (), 3: ()},
        CARTESIAN: dict.fromkeys(range(4), ()),
    }[chart][row]


@pytest.mark.parametrize("chart", CHARTS, ids=named)
def test_the_energy_of_the_harmonic_body_is_a_sum_of_actions(chart):
    rng = np.random.default_rng(11)
    for C, mu in rng.uniform(0.4, 2.0, (3, 2)):
        z = rng.normal(size=(8, 20))
        found = action_angles(Body(Harmonic(C), mu=mu), z, chart=chart)
        omega = np.sqrt(C / mu)
        factor = np.array(FACTORS[chart])[:, None]
        np.testing.assert_allclose(found.energy, omega / (2 * np.pi) * (factor * abs(found.J)).sum(axis=0), rtol=1e-13)
        np.testing.assert_allclose(
            found.energy, (z[4:] ** 2).sum(0) / (2 * mu) + C * (z[:4] ** 2).sum(0) / 2, rtol=1e-13
        )
        signs = np.where(found.J < 0, -1, 1)
        np.testing.assert_allclose(found.nu, omega / (2 * np.pi) * factor * signs, rtol=1e-13)
        found.raise_if_failed()


@pytest.mark.parametrize(("body", "chart"), CASES, ids=named)
def test_angles_advance_with_the_frequencies_and_actions_stay(body, chart):
    z = states(5, seed=8)
    before = action_angles(body, z, chart=chart)
    time = 5.3
    later = action_angles(body, fa.integrate(body, z, time=time, accuracy=1e-12).z, chart=chart)
    np.testing.assert_allclose(later.J, before.J, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(later.constants, before.constants, rtol=1e-10, atol=1e-10)
    moved = later.theta - before.theta - time * before.nu
    assert np.abs(moved - np.round(moved)).max() < 1e-10


@pytest.mark.parametrize(("body", "chart"), CASES, ids=named)
def test_angles_and_actions_are_canonical(body, chart):
    z = states(1, seed=21)
    h = 1e-5
    found = action_angles(body, np.concatenate([z + h * np.eye(8), z - h * np.eye(8)], axis=1), chart=chart)
    dJ = (found.J[:, :8] - found.J[:, 8:]) / (2 * h)
    turned = found.theta[:, :8] - found.theta[:, 8:]
    dtheta = (turned - np.round(turned)) / (2 * h)
    unit, zero = np.eye(4), np.zeros((4, 4))
    bracket = np.block([[zero, unit], [-unit, zero]])
    assert np.abs(dtheta @ bracket @ dJ.T - unit).max() < 1e-6
    assert np.abs(dtheta @ bracket @ dtheta.T).max() < 1e-6
    assert np.abs(dJ @ bracket @ dJ.T).max() < 1e-6


@pytest.mark.parametrize(("body", "chart"), CASES, ids=named)
def test_states_of_actions_and_angles(body, chart):
    z = states(30, seed=2)
    found = action_angles(body, z, chart=chart)
    np.testing.assert_allclose(fa.from_action_angles(body, found.J, found.theta, chart=chart), z, rtol=1e-9, atol=1e-10)
    energies = fa.energy_of_actions(body, found.J, chart=chart)
    np.testing.assert_allclose(energies.energy, found.energy, rtol=1e-11)
    np.testing.assert_allclose(energies.nu, found.nu, rtol=1e-10)
    one = fa.from_action_angles(body, found.J[:, 0], found.theta[:, 0], chart=chart)
    assert one.shape == (8,)


def test_errors_cover_the_closed_form_of_another_chart():
    z = states(400, seed=4)
    body = CORED
    found = action_angles(body, z, chart=SPHERICAL)
    exact = action_angles(body, z, chart=R_VARTHETA)  # closed form: oscillator with a core
    off = np.maximum(abs(found.nu[0] / exact.nu[0] - 1), abs(2 * found.nu[1] / exact.nu[1] - 1))
    assert np.mean(off > found.error + 4e-16) <= 0.01
    assert np.all(off < 10 * found.error + 4e-15)
    np.testing.assert_allclose(found.J[0], exact.J[0], rtol=1e-10, atol=1e-12)
    # 2 pi L = 2 J_vartheta + |J_eta| + |J_gamma| = J_lambda + J_mu + |J_nu|
    L = 2 * exact.J[1] + abs(exact.J_eta) + abs(exact.J_gamma)
    np.testing.assert_allclose(abs(found.J[1:]).sum(axis=0), L, rtol=1e-12)
    np.testing.assert_array_equal(np.isnan(found.nu_eta) & np.isnan(found.J_eta), True)


@pytest.mark.parametrize(
    "potential",
    [
        SeparableAlphaBeta(Oscillator(0.8), Oscillator(0.8)),
        SeparableElliptic(CoshOscillator(0.8), CosOscillator(0.8)),
        SeparableRVartheta(Spring(0.8), Zero()),
    ],
    ids=lambda potential: type(potential).__name__,
)
def test_every_form_of_the_harmonic_body_separates_in_all_charts(potential):
    z = states(4)
    for body in (Body(potential), StackelBody(potential, Zero(), Zero())):
        for chart in CHARTS:
            found = action_angles(body, z, chart=chart.name)
            np.testing.assert_allclose(found.J, action_angles(Body(Harmonic(0.8)), z, chart=chart).J, rtol=1e-12)


def test_a_constant_shear_potential_and_an_offset_are_central():
    z = states(4)
    shifted = Body(SeparableRVartheta(fa.univariate(lambda r: 0.4 * r + 0.7), Zero()))
    plain = Body(Harmonic(0.8))
    for chart in CHARTS:
        found, known = (action_angles(body, z, chart=chart) for body in (shifted, plain))
        np.testing.assert_allclose(found.J, known.J, rtol=1e-12)
        np.testing.assert_allclose(found.energy, known.energy + 0.7, rtol=1e-13)


def test_vanishing_actions_have_a_status():
    body = Body(Harmonic())
    still = np.zeros(8)
    circle = CARTESIAN.to_planes([1.0, 0, 0, 0, 0, 1.0, 0, 0])
    flat = np.array([0.7, 0.2, 0.7, 0.4, -0.3, 1.0, -0.3, 0.2])  # u = p_u = 0: J_lambda = 0
    axis = np.array([0.7, 0.2, 0.5, 0.2, -0.3, 1.0, 0.4, 1.0])  # y = p_y = 0: p_nu = 0
    line = np.array([0.3, 0.6, 0.5, 0.4, 0.15, 0.3, 0.25, 0.2])  # L = 0
    for model in (body, CORED):
        found = action_angles(model, np.array([circle, flat, axis, line]).T, chart=SPHERICAL)
        assert found.J[1, 1] == 0.0
        assert list(found.status[2:]) == [Status.SEPARATRIX, Status.SEPARATRIX]
        assert found.status[1] == Status.ACTION_ZERO
        assert np.isnan(found.theta[1, 1])
        assert np.isnan(found.nu[3, 2])
        assert np.all(np.isfinite(found.J))
        assert np.all(np.isfinite(found.nu[:3]))
        # theta_mu and theta_nu keep their values as J_lambda vanishes
        near = flat + 1e-9 * CARTESIAN.to_planes([0, 0, 0, 1.0, 0, 0, 0, 0.0])
        moved = action_angles(model, near, chart=SPHERICAL).theta[2:, 0] - found.theta[2:, 1]
        assert np.abs(moved - np.round(moved)).max() < 1e-7
    circular = action_angles(body, circle, chart=SPHERICAL)
    assert circular.status[0] == Status.ACTION_ZERO
    np.testing.assert_allclose(circular.J[:, 0], [0, 0, 0, 2 * np.pi], atol=1e-14)
    for chart in CHARTS:
        rest = action_angles(body, still, chart=chart)
        assert rest.status[0] != Status.OK
        assert np.all(rest.J == 0)


def test_unbound_motion_has_a_status():
    free = Body(SeparableRVartheta(fa.univariate(lambda r: -1 / (1 + r)), Zero()))
    z = states(1)
    fast = action_angles(free, np.concatenate([z[:4], 30 * z[4:]]), chart=SPHERICAL)
    assert fast.status[0] == Status.UNBOUND
    assert np.isnan(fast.J).all()
    assert np.isinf(fast.error[0])


def test_a_central_body_of_no_other_family_separates_by_default():
    found = action_angles(Body(Logarithm()), states(3))
    assert found.names == ("r", "lambda", "mu", "nu")


def test_tori_of_r4_are_kept_in_files(tmp_path):
    z = states(3)
    for body, chart in ((Body(Harmonic(1.3), mu=0.7), POLAR_POLAR), (CORED, SPHERICAL)):
        found = action_angles(body, z, chart=chart)
        again = fa.load(found.save(tmp_path / "tori.npz"))
        np.testing.assert_array_equal(again.theta, found.theta)
        np.testing.assert_array_equal(again.turning_points, found.turning_points)
        assert again.separated == found.separated


def test_refusals_name_the_chart_and_those_that_separate():
    z = states(1)
    cases = [
        (Body(fa.HeavyTop()), SPHERICAL, r"chart must separate HeavyTop \(r-vartheta\), got 'spherical'"),
        (CORED, POLAR_POLAR, r"chart must separate SeparableRVartheta \(r-vartheta, spherical\), got 'polar-polar'"),
        (Body(Harmonic()), TWO_POLAR, r"chart must separate Harmonic \(.*spherical, .*Cartesian\), got 'two-polar'"),
        (Body(Logarithm()), CARTESIAN, r"chart must separate Logarithm \(spherical\), got 'Cartesian'"),
        (Body(fa.NeoHookean()), SPHERICAL, "model must be separable, got a Body of NeoHookean"),
    ]
    for body, chart, message in cases:
        with pytest.raises(ValueError, match=message) as refused:
            action_angles(body, z, chart=chart)
        assert len(str(refused.value)) <= 160
        with pytest.raises(ValueError, match=message):
            fa.constants_of_motion(body, z, chart=chart)
    body = Body(Harmonic())
    with pytest.raises(ValueError, match="J of r and lambda and mu must not be negative"):
        fa.from_action_angles(body, [1.0, -1.0, 1.0, 1.0], [0, 0, 0, 0], chart=SPHERICAL)
    with pytest.raises(ValueError, match="must separate Harmonic in two coordinates"):
        fa.quantum.spectrum(body, m=0, l=0, count=1, chart=SPHERICAL)
    with pytest.raises(TypeError, match="callback must be a function"):
        action_angles(body, z, chart=SPHERICAL, callback=3)
