"""Maps of one variable against closed forms: the logistic map, the tent map, the map of the circle."""

import numpy as np
import pytest
from scipy.stats import norm

import fastaff as fa
from fastaff.systems.models.contracts import Kind, Map

LOGISTIC = fa.iterated_map("x1 = r*x*(1 - x)", r=4.0)


def test_a_map_of_one_variable_has_one_row():
    assert isinstance(LOGISTIC, Map)
    assert (LOGISTIC.coordinates, LOGISTIC.momenta, LOGISTIC.kind) == (("x",), (), Kind.MAP)
    assert not LOGISTIC.symplectic
    assert LOGISTIC.tangent_iterate(0.3, 2.0) == pytest.approx((4 * (1 - 0.6) * 2,), rel=1e-15)
    assert fa.integrate(LOGISTIC, [0.3], time=2).names == ("x",)


def test_orbits_are_those_of_the_closed_form():
    """At r = 4, x_n = sin(2^n arcsin(sqrt(x_0)))^2."""
    x0 = np.random.default_rng(4).uniform(0.05, 0.95, 300)
    run = fa.integrate(LOGISTIC, x0[None], time=12, samples=12)
    truth = np.sin(2.0 ** np.arange(1, 13)[:, None] * np.arcsin(np.sqrt(x0))) ** 2
    np.testing.assert_allclose(run.samples[:, 0], truth, atol=1e-11)
    cut = fa.poincare_map(LOGISTIC, x0[None], crossings=12)
    np.testing.assert_array_equal(cut.points[0], run.samples[:, 0])


def test_the_exponent_is_ln_2_and_its_error_covers():
    x0 = np.random.default_rng(5).uniform(0.05, 0.95, (1, 200))
    found = fa.chaos_map(LOGISTIC, x0, time=4000, indicators="spectrum")
    assert (found.classification == 1).all()
    off = np.abs(found.spectrum[0] - np.log(2)) / found.spectrum_error[0]
    assert (off < norm.ppf(0.995)).mean() > 0.9
    assert (off < 10).all()
    largest = fa.chaos_map(LOGISTIC, x0[:, :5], time=20000, indicators="lyapunov")
    np.testing.assert_allclose(largest.values[0], np.log(2), atol=2e-3)


@pytest.mark.parametrize(
    ("r", "period"), [(2.9, 1), (3.1, 2), (3.44, 2), (3.46, 4), (3.54, 4), (3.55, 8), (3.5644, 16), (3.8319, 3)]
)
def test_periods_double_at_the_known_points(r, period):
    """At 3, 1 + sqrt(6), 3.54409, 3.56441; the window of period 3 begins at 1 + sqrt(8)."""
    map_ = LOGISTIC._replace(r=r)
    end = fa.integrate(map_, [0.4], time=60000).z
    x = fa.poincare_map(map_, end, crossings=32).points[0, :, 0]
    same = [k for k in range(1, 17) if abs(x[k:] - x[:-k]).max() < 1e-6]
    assert same[0] == period
    exponent = fa.chaos_map(map_, end, time=3200, indicators="lyapunov").values[0, 0]
    slopes = [r * (1 - 2 * entry) for entry in x[:period]]
    assert exponent == pytest.approx(np.log(np.abs(slopes)).mean(), abs=2e-3)


def test_a_periodic_variable_winds():
    """A rigid rotation is known, its angle within half a turn of 0."""
    circle = fa.iterated_map("x1 = x + W + K*sin(x)", periodic={"x": "2*pi"}, W=2.4, K=0.0)
    x = fa.integrate(circle, [[0.3, -1.0]], time=500).z[0]
    truth = np.array([0.3, -1.0]) + 500 * 2.4
    np.testing.assert_allclose(x, truth - 2 * np.pi * np.rint(truth / (2 * np.pi)), atol=1e-11)


def test_orbits_that_escape_or_leave_the_domain_end():
    run = fa.integrate(LOGISTIC, [[0.3, 2.0]], time=100)
    assert [fa.Status(k).name for k in run.status] == ["OK", "NONFINITE"]
    inside = fa.iterated_map("x1 = r*x*(1 - x)", domain="4 - x**2", r=4.0)
    run = fa.integrate(inside, [[0.3, 1.4]], time=100)
    assert [fa.Status(k).name for k in run.status] == ["OK", "LOST"]
    assert run.t[1] < 3


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: fa.frequency_map(LOGISTIC, [0.3], time=500), "must have momenta, got a map of one variable"),
        (lambda: fa.fit_torus(LOGISTIC, [0.3], time=500), "must have momenta, got a map of one variable"),
        (lambda: fa.explore(LOGISTIC), "must have momenta, got a map of one variable"),
        (
            lambda: fa.chaos_map(LOGISTIC, [0.3], time=500, indicators=fa.FrequencyDiffusion()),
            "must have momenta, got a map of one variable",
        ),
        (lambda: fa.periodic_orbits(LOGISTIC, [0.3], crossings=1), "is not symplectic"),
        (lambda: fa.integrate(LOGISTIC, [0.3, 0.2], time=5), r"z0 must have shape \(1,\) or \(1, orbits\)"),
        (lambda: fa.chaos_map(LOGISTIC, [0.3], time=50, indicators="sali"), "at least 2 vectors"),
        (lambda: fa.iterated_map("x1 = y; y1 = z; z1 = x"), "images of 1, 2, 4, ... or 16 variables"),
        (lambda: fa.iterated_map("x1 = r*x", r=1.0, momenta="p"), "coordinates and momenta must each be half"),
    ],
)
def test_what_one_variable_has_not_is_refused(call, said):
    with pytest.raises((ValueError, TypeError), match=said):
        call()
