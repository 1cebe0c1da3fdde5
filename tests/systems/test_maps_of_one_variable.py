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
        (
            lambda: fa.chaos_map(LOGISTIC, [0.3], time=500, indicators=fa.FrequencyDiffusion()),
            "must have momenta, got a map of one variable",
        ),
        (lambda: fa.integrate(LOGISTIC, [0.3, 0.2], time=5), r"z0 must have shape \(1,\) or \(1, orbits\)"),
        (lambda: fa.chaos_map(LOGISTIC, [0.3], time=50, indicators="sali"), "at most 1 deviation vector"),
        (lambda: fa.iterated_map("x1 = y; y1 = z; z1 = x"), "images of 1, 2, 4, ... or 16 variables"),
        (lambda: fa.iterated_map("x1 = r*x", r=1.0, momenta="p"), "coordinates and momenta must each be half"),
    ],
)
def test_what_one_variable_has_not_is_refused(call, said):
    with pytest.raises((ValueError, TypeError), match=said):
        call()


# --- bifurcation diagrams and cobwebs -------------------------------------------------------------------------------


def test_a_bifurcation_diagram_has_the_cycles_of_closed_form():
    """The fixed point 1 - 1/r up to 3, then the cycle of two; the exponent is ln|product of slopes|/period."""
    r = np.concatenate([np.linspace(1.51, 2.95, 30), np.linspace(3.05, 3.42, 30)])
    found = fa.chaos.bifurcation_diagram(LOGISTIC, "r", r, x0=0.3, transient=4000)
    single = r < 3
    np.testing.assert_allclose(found.points[:, single], np.broadcast_to(1 - 1 / r[single], (256, 30)), atol=1e-10)
    slope = np.where(single, np.abs(2 - r), np.sqrt(np.abs(4 + 2 * r - r * r)))
    np.testing.assert_allclose(found.exponent, np.log(slope), atol=1e-8)
    s = np.sqrt((r + 1) * (r - 3) + 0j).real
    pair = np.sort(found.points[-2:], axis=0)
    truth = np.array([(r + 1 - s) / (2 * r), (r + 1 + s) / (2 * r)])
    np.testing.assert_allclose(pair[:, ~single], truth[:, ~single], atol=1e-10)
    assert (found.status == fa.Status.OK).all()
    assert len(found) == 60


def test_exponents_of_a_diagram_are_ln_2_within_their_errors():
    x0 = np.random.default_rng(8).uniform(0.05, 0.95, 400)
    found = fa.chaos.bifurcation_diagram(LOGISTIC, "r", np.full(400, 4.0), x0=x0, iterates=4096)
    off = np.abs(found.exponent - np.log(2)) / found.exponent_error
    assert (off < 3.3).mean() >= 0.97
    assert (off < 10).all()


def test_orbits_of_a_diagram_that_end_are_nan():
    found = fa.chaos.bifurcation_diagram(LOGISTIC, "r", [3.2, 4.5], x0=0.3)
    assert [fa.Status(k).name for k in found.status] == ["OK", "NONFINITE"]
    assert np.isfinite(found.points).all(axis=0).tolist() == [True, False]
    assert np.isnan(found.exponent[1])
    assert "NONFINITE (an iterate became infinite or NaN; choose x0" in found.summary()
    with pytest.raises(fa.OrbitError, match="an iterate became infinite or NaN"):
        found.raise_if_failed()


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ({"model": fa.models.StandardMap()}, TypeError, "model must be a map of one variable"),
        ({"model": fa.HenonHeiles()}, TypeError, "model must be a map of one variable"),
        ({"parameter": "s"}, ValueError, "parameter must be one of r, got 's'"),
        ({"parameter": 3}, ValueError, "parameter must be one of r, got 3"),
        ({"values": [[1.0, 2.0]]}, ValueError, "values must be finite numbers in one row"),
        ({"values": [np.nan]}, ValueError, "values must be"),
        ({"values": []}, ValueError, "values must be"),
        ({"x0": [0.1, 0.2, 0.3]}, ValueError, "x0 must be a finite number or 2 of them"),
        ({"transient": -1}, ValueError, "transient must be"),
        ({"iterates": 3}, ValueError, "iterates must be at least 16"),
        ({"iterates": 2**50}, ValueError, "iterates"),
    ],
)
def test_wrong_input_of_a_diagram(given, error, said):
    asked = {"model": LOGISTIC, "parameter": "r", "values": [3.0, 3.5], "x0": 0.3} | given
    with pytest.raises(error, match=said):
        fa.chaos.bifurcation_diagram(**asked)


def test_figures_of_a_map_of_one_variable():
    found = fa.chaos.bifurcation_diagram(LOGISTIC, "r", np.linspace(2.8, 4.2, 20), x0=0.3)
    drawn = found.plot()
    assert drawn.missing == (found.values > 4).sum()
    assert len(drawn.points.get_xdata()) == np.isfinite(found.points).sum()
    web = fa.plot.plot_cobweb(LOGISTIC._replace(r=3.2), 0.2, iterates=30)
    x, y = web.points.get_data()
    orbit = fa.integrate(LOGISTIC._replace(r=3.2), [0.2], time=30, samples=30).samples[:, 0, 0]
    np.testing.assert_allclose(y[1::2], orbit, atol=1e-13)
    np.testing.assert_allclose(x[2::2], orbit, atol=1e-13)
    assert web.missing == 0
    assert fa.plot.plot_cobweb(LOGISTIC._replace(r=5.0), 0.4, iterates=30).missing > 0
    with pytest.raises(TypeError, match="map of one variable"):
        fa.plot.plot_cobweb(fa.models.StandardMap(), 0.2)


def test_one_deviation_vector_is_enough_for_the_usual_indicators():
    logistic = fa.iterated_map("x1 = r*x*(1 - x)", r=4.0)
    found = fa.chaos_map(logistic, [[0.3, 0.41]], time=1000)
    assert found.names == ("megno",)
    assert found.chaotic.all()
    with pytest.raises(ValueError, match=r"^indicators must need at most 1 deviation vector .* got sali\. Use 'megno'"):
        fa.chaos_map(logistic, [[0.3, 0.41]], time=1000, indicators="sali")


@pytest.mark.parametrize("r", [2.0, 1 + np.sqrt(5.0)])
def test_exponent_of_a_superstable_cycle_is_not_known(r):
    """It is -inf; rounding leaves a slope of 1e-16 at the critical point."""
    logistic = fa.iterated_map("x1 = r*x*(1 - x)", r=r)
    found = fa.chaos.bifurcation_diagram(logistic, "r", [r, 2.5, 4.0], x0=0.3)
    assert found.exponent[0] < -15
    assert found.exponent_error[0] == np.inf
    assert (found.exponent_error[1:] < 0.05).all()
    assert abs(found.exponent[1] + np.log(2.0)) < 1e-12
