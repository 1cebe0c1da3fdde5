"""Basins of attraction against closed forms, symmetries and slow twins."""

import signal

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastaff as fa
from fastaff.chaos import AttractorKind

NEWTON = fa.iterated_map(
    "d = (x**2 + y**2)**2; x1 = 2*x/3 + (x**2 - y**2)/(3*d); y1 = 2*y/3 - 2*x*y/(3*d)", coordinates="x", momenta="y"
)
HENON = fa.iterated_map("x1 = 1 - a*x**2 + y; y1 = b*x", coordinates="x", momenta="y", a=1.4, b=0.3)
LOGISTIC = fa.iterated_map("x1 = r*x*(1 - x)", r=3.2)
WELL = fa.hamiltonian("x**4/4 - x**2/2", coordinates="x", friction=0.5)
DUFFING = fa.ode(
    fa.hamiltonian("x**4/4 - x**2/2", coordinates="x"), forces={"x": "a*cos(w*t) - g*p_x"}, g=0.15, a=0.2, w=1.0
)
LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)


def uniform(low, high, shape):
    """Numbers drawn at random, the same in each test."""
    return np.random.default_rng(52).uniform(low, high, shape)


def near_lorenz(orbits):
    z0 = np.random.default_rng(1).uniform(-20, 20, (3, orbits))
    z0[2] += 20
    return z0


def test_newtons_method_has_three_equal_basins():
    """By symmetry each root of z^3 = 1 has a third of a disc; the labels are those of a slow twin."""
    radius = 2 * np.sqrt((np.arange(4000) + 0.5) / 4000)
    angle = uniform(0, 2 * np.pi / 3, 4000)
    turned = angle + 2 * np.pi / 3 * np.arange(3)[:, None]
    z0 = np.array([radius * np.cos(turned), radius * np.sin(turned)]).reshape(2, -1)
    found = fa.basins(NEWTON, z0, time=200)
    assert not found.undecided.any()
    np.testing.assert_allclose(found.shares[:3], 1 / 3, atol=0.003)
    points = found.points[0, 0] + 1j * found.points[1, 0]
    np.testing.assert_allclose(points**3, 1.0, atol=1e-14)
    w = z0[0] + 1j * z0[1]
    for _ in range(200):
        w = w - (w**3 - 1) / (3 * w**2)
    np.testing.assert_array_equal(found.label, np.abs(w[:, None] - points).argmin(axis=1))


@pytest.mark.parametrize(
    ("r", "period", "exponent"),
    [(2.5, 1, np.log(0.5)), (3.2, 2, np.log(np.abs(4 + 2 * 3.2 - 3.2**2)) / 2), (3.83, 3, None), (3.5, 4, None)],
)
def test_cycles_of_the_logistic_map(r, period, exponent):
    x0 = np.linspace(-0.1, 1.1, 501)[None]
    found = fa.basins(LOGISTIC._replace(r=r), x0, time=2000)
    assert found.kind.tolist() == [AttractorKind.FIXED_POINT if period == 1 else AttractorKind.PERIODIC]
    assert found.period[0] == period
    np.testing.assert_array_equal(found.escaped, (x0[0] < 0) | (x0[0] > 1))
    assert (found.label[(x0[0] > 0.01) & (x0[0] < 0.99)] == 0).all()
    x = float(found.points[0, 0, 0])
    slopes = 1.0
    for _ in range(period):
        slopes *= r * (1 - 2 * x)
        x = r * x * (1 - x)
    assert abs(x - found.points[0, 0, 0]) <= 2 * found.error[0, 0]
    exact = np.log(abs(slopes)) / period if exponent is None else exponent
    assert abs(found.exponent[0] - exact) <= found.exponent_error[0]


@pytest.mark.parametrize("r", [3.0, 1 + np.sqrt(6)])
def test_at_a_bifurcation_orbits_are_undecided(r):
    found = fa.basins(LOGISTIC._replace(r=r), np.linspace(-0.1, 1.1, 121)[None], time=1000)
    assert found.kind.size == 0
    np.testing.assert_array_equal(found.label, np.where(found.escaped, -1, -2))
    np.testing.assert_array_equal(np.isfinite(found.suggested_time), found.undecided)
    assert "may decide" in found.summary()


def test_one_chaotic_attractor_has_one_label():
    """Exponents of the literature: Henon 0.4192, the logistic map at 4 ln 2."""
    for model, z0, exponent in (
        (HENON, uniform(-1.5, 1.5, (2, 3000)), 0.4192),
        (LOGISTIC._replace(r=4.0), uniform(0.001, 0.999, (1, 300)), np.log(2)),
    ):
        found = fa.basins(model, z0, time=1000)
        assert found.kind.tolist() == [AttractorKind.CHAOTIC]
        assert abs(found.exponent[0] - exponent) < found.exponent_error[0]
        assert found.undecided.sum() <= 0.01 * found.label.size
        w = z0.copy()
        with np.errstate(all="ignore"):
            for _ in range(1000):
                w = np.array([1 - 1.4 * w[0] ** 2 + w[1], 0.3 * w[0]]) if len(w) == 2 else 4 * w * (1 - w)
        left = ~np.isfinite(w).all(axis=0)
        np.testing.assert_array_equal(found.escaped, left)


def test_basins_of_a_double_well():
    """Below the saddle an orbit stays in its well; (x, p) and (-x, -p) have opposite labels; a twin by SciPy."""
    z0 = uniform(-2, 2, (2, 400))
    found = fa.basins(WELL, np.concatenate([z0, -z0], axis=1), time=200.0)
    assert found.kind.tolist() == [AttractorKind.FIXED_POINT] * 2
    side = np.sign(found.points[0, 0, found.label])
    np.testing.assert_array_equal(side[:400], -side[400:])
    low = z0[1] ** 2 / 2 + z0[0] ** 4 / 4 - z0[0] ** 2 / 2 < 0
    assert low.sum() > 50
    np.testing.assert_array_equal(side[:400][low], np.sign(z0[0, low]))
    for k in range(40):
        end = solve_ivp(lambda t, z: [z[1], z[0] - z[0] ** 3 - 0.5 * z[1]], (0, 60), z0[:, k], rtol=1e-10, atol=1e-10)
        assert np.sign(end.y[0, -1]) == side[k]
    np.testing.assert_allclose(found.exponent, -0.25, rtol=0, atol=1e-9)


def test_periodic_orbits_of_a_driven_well_have_periods_of_the_drive():
    """Two oscillations coexist; each is the periodic orbit that Newton's method on a section finds."""
    z0 = np.concatenate([uniform(-1.5, 1.5, (2, 300)), np.ones((1, 300)), np.zeros((1, 300))])
    found = fa.basins(DUFFING, z0, time=2 * np.pi * 150)
    assert found.attractor_names == ("period 1 (1)", "period 1 (2)")
    assert not found.undecided.any()
    for k in range(2):
        cycle = fa.periodic_orbits(DUFFING, found.points[:, 0, k], section="sine=0")
        away = np.abs(cycle.z[:2, 0] - found.points[:2, 0, k])
        assert (away <= found.error[:2, k] + 1e-11).all()
        across = np.sort(np.abs(cycle.multipliers[:, 0]))[-1]
        assert abs(np.log(across) / (2 * np.pi) - found.exponent[k]) < 1e-8
    quick = np.argsort(found.settling_time)[:20]  # errors of slow orbits, near the fractal border, decide
    for k in quick:
        end = solve_ivp(
            lambda t, z: [z[1], z[0] - z[0] ** 3 - 0.15 * z[1] + 0.2 * np.cos(t)],
            (0, 2 * np.pi * 40),
            z0[:2, k],
            rtol=1e-9,
            atol=1e-9,
        ).y[:, -1]
        assert np.linalg.norm(end[:, None] - found.points[:2, 0], axis=0).argmin() == found.label[k]


def test_a_rotation_and_an_equilibrium_of_a_pendulum_with_torque():
    """The cycle winds once in its minimal period."""
    model = fa.ode("x' = v; v' = -sin(x) - 0.2*v + 0.5", periodic={"x": "2*pi"})
    found = fa.basins(model, uniform(-3, 3, (2, 300)), time=200.0)
    assert sorted(found.kind.tolist()) == [AttractorKind.FIXED_POINT, AttractorKind.PERIODIC]
    cycle = int(np.argmax(found.kind))
    np.testing.assert_allclose(found.points[0, 0, 1 - cycle], np.arcsin(0.5), atol=1e-9)
    mean = 2 * np.pi / found.period[cycle]
    assert 2.3 < mean < 2.5  # torque over friction, a little less
    v = found.points[1, :, cycle]
    assert v[np.isfinite(v)].min() > 0


def test_lorenz_has_fixed_points_and_chaos_side_by_side():
    """Sparrow 1982: fixed points alone below 24.06, both kinds up to 24.74, chaos alone above."""
    z0 = near_lorenz(150)
    for r, kinds in ((20.0, {0}), (24.4, {0, 3}), (28.0, {3})):
        found = fa.basins(LORENZ._replace(r=r), z0, time=300.0)
        assert set(found.kind.tolist()) == kinds
        assert (found.kind == AttractorKind.CHAOTIC).sum() <= 1
        side = np.sqrt(8 / 3 * (r - 1))
        for k in np.flatnonzero(found.kind == AttractorKind.FIXED_POINT):
            np.testing.assert_allclose(np.abs(found.points[:2, 0, k]), side, atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_random_driven_wells_agree_with_a_slow_twin(seed):
    """Attractors by the ends of long orbits, in clusters; no label is another's, none is found twice."""
    rng = np.random.default_rng(seed)
    g, a, w = rng.uniform(0.2, 0.35), rng.uniform(0.05, 0.2), rng.uniform(0.8, 1.4)
    model = DUFFING._replace(g=g, a=a, w=w) if hasattr(DUFFING, "_replace") else DUFFING
    z0 = rng.uniform(-1.5, 1.5, (2, 60))
    whole = np.concatenate([z0, np.ones((1, 60)), np.zeros((1, 60))])
    found = fa.basins(model, whole, time=2 * np.pi / w * 200)
    ends = fa.integrate(model, whole, time=2 * np.pi / w * 600, scheme="VERNER9", rtol=1e-10, atol=1e-10).z[:2]
    for k in range(found.kind.size):
        own = found.points[:2, :, k]
        own = own[:, np.isfinite(own).all(axis=0)]
        if found.kind[k] == AttractorKind.PERIODIC:
            away = np.linalg.norm(ends[:, :, None] - own[:, None], axis=0).min(axis=1)
            decided = found.settling_time < found.time / 8  # errors of slow orbits, near the border, decide
            assert decided.sum() > 20
            np.testing.assert_array_equal((away < 1e-4)[decided], (found.label == k)[decided])


def test_results_do_not_depend_on_threads():
    z0 = uniform(-1.5, 1.5, (2, 700))
    one, other = (fa.basins(HENON, z0, time=400, threads=threads) for threads in (1, 2))
    np.testing.assert_array_equal(one.label, other.label)
    np.testing.assert_array_equal(one.settling_time, other.settling_time)
    np.testing.assert_array_equal(one.points, other.points)


def test_labels_do_not_depend_on_units():
    k = 3e4
    scaled = fa.ode("x' = v; v' = x - x**3/k**2 - 0.5*v", k=k)
    plain = fa.ode("x' = v; v' = x - x**3 - 0.5*v")
    z0 = uniform(-2, 2, (2, 200))
    one = fa.basins(plain, z0, time=100.0, atol=1e-10)
    other = fa.basins(scaled, k * z0, time=100.0, atol=k * 1e-10)
    np.testing.assert_array_equal(one.label, other.label)
    np.testing.assert_allclose(other.points / k, one.points, atol=1e-9)


@pytest.mark.parametrize("after", [0.0, 0.5])
def test_ctrl_c_keeps_the_labels_so_far(after):
    """How many orbits have labels by then depends on the clock; those without say that they were interrupted."""
    z0 = uniform(-1.9, 1.9, (2, 3000))

    def stop(fraction):
        if fraction > after:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(fa.Interrupted, match="basins") as caught:
        fa.basins(WELL, z0, time=200.0, callback=stop)
    part = caught.value.partial
    whole = fa.basins(WELL, z0, time=200.0)
    done = ~part.undecided
    assert (part.status[part.undecided & ~whole.undecided] == fa.Status.INTERRUPTED).all()
    np.testing.assert_array_equal(part.label[done], whole.label[done])


def test_shares_have_bounds_and_intervals():
    found = fa.basins(LOGISTIC, np.linspace(-0.1, 1.1, 121)[None], time=1000)
    counts = found.counts
    assert counts.sum() == 121
    np.testing.assert_allclose(found.shares, counts / 121)
    assert (found.intervals[0] < found.shares).all()
    assert (found.intervals[1] > found.shares).all()
    np.testing.assert_allclose(found.bounds[0], found.shares)
    p = found.shares
    assert found.entropy == pytest.approx(-(p * np.log(p)).sum())


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda: fa.basins(fa.HenonHeiles(), [0.1, 0, 0, 0.1], time=100.0), TypeError, "must lose volume"),
        (lambda: fa.basins(fa.models.StandardMap(), [0.1, 0.1], time=100), TypeError, "must lose volume"),
        (lambda: fa.basins(LOGISTIC, [0.3], time=8), ValueError, "time must be at least 16, 16 intervals, got 8"),
        (lambda: fa.basins(LOGISTIC, [0.3], time=100.5), ValueError, "whole number of iterates"),
        (
            lambda: fa.basins(DUFFING, [[0.1, 0.2], [0, 0], [1, 0], [0, 1]], time=400.0),
            ValueError,
            "z0 must have one phase of the drive",
        ),
    ],
)
def test_wrong_input_is_refused(call, error, said):
    with pytest.raises(error, match=said):
        call()
