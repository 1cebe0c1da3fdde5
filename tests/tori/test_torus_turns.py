"""fit_torus of maps and of driven systems over their period: against closed forms, quadrature and other schemes."""

import dataclasses

import numpy as np
import pytest
import shared_systems
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import fastaff as fa
from fastaff import Classification
from fastaff.systems.models.maps import FroeschleMap, McMillanMap, OneTurnMap, StandardMap

TURN = 2 * np.pi

ROWS = "x", "y", "px", "py"
SPACE = fa.iterated_map(
    "; ".join(
        f"{row}1 = {row}0 + " + " + ".join(f"m{i}{j}*({other} - {other}0)" for j, other in enumerate(ROWS))
        for i, row in enumerate(ROWS)
    ),
    coordinates="x y",
    momenta="px py",
    **{f"{row}0": 0.1 for row in ROWS},
    **{f"m{i}{j}": float(i == j) for i in range(4) for j in range(4)},
)


def turn(nu):
    c, s = np.cos(TURN * nu), np.sin(TURN * nu)
    return np.array([[c, s], [-s, c]])


def symplectic(rng, n):
    """A random symplectic matrix of rows q, p: shears and scales."""
    S = np.eye(2 * n)
    for _ in range(2):
        upper, lower = (rng.normal(size=(n, n)) * 0.4 for _ in range(2))
        one, other = np.eye(2 * n), np.eye(2 * n)
        one[:n, n:], other[n:, :n] = upper + upper.T, lower + lower.T
        S = S @ one @ other
    scale = np.exp(rng.uniform(-5, 5, n))
    return np.diag(np.concatenate([scale, 1 / scale])) @ S


def error_of(found, nu):
    return np.abs((found.nu - nu + 0.5) % 1 - 0.5)


def test_linear_maps_of_the_plane_in_any_units():
    """Tune, area and centre are given; errors cover."""
    rng, ratios = np.random.default_rng(3), []
    for _ in range(16):
        nu, S, unit = rng.uniform(0.02, 0.98), symplectic(rng, 1), 10.0 ** rng.uniform(-6, 6)
        centre = unit * rng.normal(size=2) * 10.0 ** rng.uniform(-2, 2)
        M = S @ turn(nu) @ np.linalg.inv(S)
        model = shared_systems.linear_map(M, centre)
        own = unit * rng.normal(size=2)
        found = fa.fit_torus(model, centre + S @ own, time=1000)
        assert found.classification is Classification.REGULAR, found.summary()
        ratios.append(error_of(found, nu)[0] / found.nu_error[0])
        far = 1e-15 * np.abs(centre).max() / np.abs(S @ own).max()
        np.testing.assert_allclose(found.J, np.pi * own @ own, rtol=1e-10 + 1e3 * far)
        t = np.arange(4)
        path = fa.integrate(model, centre + S @ own, time=3, samples=3).samples[..., 0].T
        at = found.evaluate(found.theta0[:, None] + found.nu[:, None] * t)[:, 1:]
        np.testing.assert_allclose(at, path, atol=1e-9 * np.abs(S @ own).max() + 1e-12 * np.abs(centre).max())
        assert found.residual < 1e-9
    assert np.max(ratios) <= 1


def test_linear_maps_of_two_planes_that_are_coupled():
    rng = np.random.default_rng(5)
    for _ in range(5):
        nu, S = rng.uniform(0.05, 0.95, 2), symplectic(rng, 2)
        R = np.zeros((4, 4))
        for i in range(2):
            R[np.ix_([i, i + 2], [i, i + 2])] = turn(nu[i])
        M, centre, own = S @ R @ np.linalg.inv(S), rng.normal(size=4), rng.normal(size=4)
        values = {f"m{i}{j}": float(M[i, j]) for i in range(4) for j in range(4)}
        model = SPACE._replace(**values, **{f"{row}0": float(c) for row, c in zip(ROWS, centre)})
        found = fa.fit_torus(model, centre + S @ own, time=2000)
        assert found.classification is Classification.REGULAR, found.summary()
        # The angles may come in any order, and one may be another's sum with it.
        J = np.pi * (own[:2] ** 2 + own[2:] ** 2)
        order = [int(np.argmin(np.abs((found.nu - value + 0.5) % 1 - 0.5))) for value in nu]
        assert sorted(order) == [0, 1]
        apart = error_of(dataclasses.replace(found, nu=found.nu[order]), nu)
        assert (apart <= found.nu_error[order]).all()
        np.testing.assert_allclose(found.J[order], J, rtol=1e-8)


@pytest.mark.parametrize(("m", "z0"), [(1.6, (0.5, 0.3)), (0.4, (0.9, 0.7)), (1.6, (1.5, -0.8)), (-0.7, (0.2, 0.4))])
def test_mcmillans_map_against_quadrature(m, z0):
    """Its curves are those of a flow, along which the map is a shift: rotation number and area by quadrature."""
    x0, p0 = z0
    h = x0**2 * p0**2 + x0**2 + p0**2 - 2 * m * x0 * p0

    def slopes(t, z):
        x, p = z
        return [2 * p * (1 + x * x) - 2 * m * x, -(2 * x * (1 + p * p) - 2 * m * p)]

    x1, p1 = p0, -x0 + 2 * m * p0 / (1 + p0 * p0)
    path = solve_ivp(slopes, (0, 60), z0, "DOP853", rtol=3e-14, atol=1e-15, dense_output=True).sol
    t = np.linspace(0, 60, 60001)

    def back_at(z):
        """Times at which the flow is at z."""
        away = np.hypot(*(path(t) - np.array(z)[:, None]))
        low = 1 + np.flatnonzero((away[1:-1] < away[:-2]) & (away[1:-1] <= away[2:]) & (away[1:-1] < 0.01))
        v = np.array(slopes(0, z))
        return [brentq(lambda s: (path(s) - z) @ v, t[k - 1], t[k + 1], xtol=1e-15) for k in low]

    period, shift = back_at(np.array(z0))[0], back_at(np.array([x1, p1]))[0]
    found = fa.fit_torus(McMillanMap(m), z0, time=4096)
    assert found.classification is Classification.REGULAR
    assert error_of(found, shift / period)[0] <= found.nu_error[0] + 1e-12

    def root(x):
        return (m * x) ** 2 + (1 + x * x) * (h - x * x)

    edge = brentq(root, *_edges(m, h, x0), xtol=1e-15)
    other = -edge if h > 0 else brentq(root, *_inner(m, h, x0), xtol=1e-15)
    low, high = min(edge, other), max(edge, other)

    def width(angle):
        x = (low + high) / 2 + (high - low) / 2 * np.sin(angle)
        return 2 * np.sqrt(max(root(x), 0.0)) / (1 + x * x) * (high - low) / 2 * np.cos(angle)

    np.testing.assert_allclose(found.J[0], quad(width, -np.pi / 2, np.pi / 2, epsabs=1e-14)[0], rtol=1e-9)
    invariant = found.evaluate(np.linspace(0, 1, 50)[None])
    x, p = invariant
    np.testing.assert_allclose(x**2 * p**2 + x**2 + p**2 - 2 * m * x * p, h, atol=1e-11)


def _edges(m, h, x0):
    """An interval with the outer edge of the curve on the side of x0."""
    sign = np.sign(x0)
    return sign * abs(x0), sign * (abs(x0) + 3 * (1 + abs(m) + abs(h)))


def _inner(m, h, x0):
    """An interval with its inner edge."""
    return 0.0, x0


def test_the_standard_map_winds_librates_and_has_islands():
    model = StandardMap(0.5)
    around = fa.fit_torus(model, [0.2, 2.1], time=4096)
    assert around.classification is Classification.REGULAR
    np.testing.assert_array_equal(around.winding, [[TURN], [0.0]])
    number = fa.frequency_map(model, [0.2, 2.1], time=20000)
    assert abs(around.nu[0] - number.nu[0, 0]) <= around.nu_error[0] + number.error[0, 0]
    # The area under the curve: the mean of p over x, from many iterates in the order of x.
    points = fa.poincare_map(model, [0.2, 2.1], crossings=200000).points[..., 0]
    x, p = np.mod(points[0], TURN), points[1]
    order = np.argsort(x)
    x, p = np.append(x[order], x[order[0]] + TURN), np.append(p[order], p[order[0]])
    np.testing.assert_allclose(around.J[0], np.trapezoid(p, x), rtol=1e-8)
    # In the well, and in that of the momentum a turn higher, where it winds once in an iterate.
    inner, higher = (fa.fit_torus(model, [np.pi + 0.7, 0.1 + shift], time=4096) for shift in (0.0, TURN))
    assert inner.winding is higher.winding is None
    np.testing.assert_allclose(inner.nu, higher.nu, atol=1e-12)
    np.testing.assert_allclose(inner.J, higher.J, rtol=1e-10)
    islands = fa.fit_torus(StandardMap(0.8), [np.pi, np.pi + 0.05], time=8192)
    assert islands.islands == 2
    assert islands.classification is Classification.REGULAR
    path = fa.integrate(StandardMap(0.8), [np.pi, np.pi + 0.05], time=40, samples=20).samples[..., 0].T
    at = islands.evaluate(islands.theta0[:, None] + islands.nu[:, None] * np.arange(2, 42, 2))
    away = at - path
    away[0] -= TURN * np.rint(away[0] / TURN)
    assert np.abs(away).max() < 1e-10
    # A small island: its tune is that of the orbit at its centre.
    orbit = fa.periodic_orbits(StandardMap(0.8), [np.pi, np.pi], crossings=2)
    small = fa.fit_torus(StandardMap(0.8), [orbit.z[0, 0] + 1e-4, orbit.z[1, 0]], time=8192)
    exact = np.arccos(1 - 2 * orbit.residue[0]) / TURN / 2
    assert min(abs(small.nu[0] - exact), abs(0.5 - small.nu[0] - exact)) < 1e-6
    chaos = fa.fit_torus(StandardMap(3.0), [0.1, 0.1], time=4096)
    assert chaos.classification is Classification.IRREGULAR
    assert np.isinf(chaos.nu_error).all()


def test_small_kicks_follow_perturbation_theory():
    """To the first order in K: p = I + K cos(x - I/2)/(2 sin(I/2)) + ..., nu and J/2 pi = nu 2 pi to the second."""
    K, I = 1e-6, 2.0
    found = fa.fit_torus(StandardMap(K), [0.3, I], time=2048)
    theta = np.linspace(0, 1, 64, endpoint=False)
    x, p = found.evaluate(theta[None])
    mean = found.J[0] / TURN
    np.testing.assert_allclose(p, mean - K * np.cos(x - mean / 2) / (2 * np.sin(mean / 2)), atol=1e-11)
    np.testing.assert_allclose(TURN * found.nu[0], mean, atol=1e-11)


def test_four_dimensions_have_two_frequencies_and_actions():
    model, z0 = OneTurnMap(0.28, 0.31, -0.3), [0.05, 0.05, 0.0, 0.0]
    found = fa.fit_torus(model, z0, time=4096)
    tune = fa.tunes(fa.integrate(model, z0, time=20000, samples=20000).samples.transpose(1, 2, 0))
    assert (error_of(found, tune.nu[:, 0]) <= found.nu_error + tune.error[:, 0]).all()
    assert found.residual < 1e-8
    both = fa.fit_torus(FroeschleMap(0.05, 0.03, 0.002), [0.1, 0.2, 1.2, 2.3], time=2048)
    assert both.classification is Classification.REGULAR
    np.testing.assert_array_equal(both.winding, TURN * np.eye(4)[:, :2])
    # Frequencies are the derivatives of one function of the actions: dnu_1/dJ_2 = dnu_2/dJ_1.
    shifts = 0.01 * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    starts = shifts + np.array([1.2, 2.3])
    ends = [fa.fit_torus(FroeschleMap(0.05, 0.03, 0.002), [0.1, 0.2, *p], time=2048) for p in starts]
    nu, J = (np.array([a - b for a, b in (rows[:2], rows[2:])]) for rows in ([e.nu for e in ends], [e.J for e in ends]))
    slope = np.linalg.solve(J, nu)
    assert abs(slope[0, 1] - slope[1, 0]) < 2e-3 * np.abs(slope[0, 1])
    cut = both.truncated(2)
    assert both.residual < 1e-9 < cut.residual < 0.1
    turned = both.in_basis([[1, 1], [0, 1]])
    theta = np.array([0.13, 0.57])
    np.testing.assert_allclose(turned.evaluate(np.array([[1, 1], [0, 1]]) @ theta), both.evaluate(theta), atol=1e-12)


def test_driven_oscillator_in_closed_form():
    """x'' = -k x/m + a cos(w t)/m: an ellipse around its periodic orbit, at any phase."""
    rng = np.random.default_rng(8)
    for _ in range(4):
        mass, k, w, a = np.exp(rng.uniform(-3, 3, 4))
        own = np.sqrt(k / mass)
        model = shared_systems.duffing(a=a, w=w, k=k, c=0.0, mass=mass)
        t0 = rng.uniform(0, TURN / w)
        centre = a / (k - mass * w * w) * np.array([np.cos(w * t0), -mass * w * np.sin(w * t0)])
        off = rng.normal(size=2) * np.abs(a / (k - mass * w * w)) * np.array([1.0, mass * own])
        z0 = [centre[0] + off[0], t0, centre[1] + off[1], 0.0]
        found = fa.fit_torus(model, z0, time=600 * TURN / w)
        assert found.classification is Classification.REGULAR, found.summary()
        assert error_of(found, own / w)[0] <= found.nu_error[0]
        np.testing.assert_allclose(
            found.J[0], np.pi * (off[0] ** 2 * mass * own + off[1] ** 2 / (mass * own)), rtol=1e-8
        )
        np.testing.assert_allclose(found.evaluate(found.theta0)[:3], z0[:3], rtol=1e-8, atol=1e-8 * np.abs(off).max())
        assert found.residual < 1e-8


def test_fixed_points_short_times_and_words():
    assert fa.fit_torus(StandardMap(0.5), [np.pi, 0.0], time=1000).dimension == 0
    four = fa.fit_torus(shared_systems.linear_map([[0.0, 1.0], [-1.0, 0.0]]), [0.3, 0.1], time=2000)
    assert (four.dimension, four.islands) == (0, 4)
    short = fa.fit_torus(StandardMap(0.5), [0.2, 2.1], time=50)
    assert short.classification is Classification.UNDECIDED
    assert short.evidence["suggested time"] > 50
    gone = fa.fit_torus(OneTurnMap(0.28, 0.31, -0.3, 5.0), [1.4, 0.9, 0.0, 0.0], time=1000)
    assert gone.classification is Classification.IRREGULAR
    with pytest.raises(ValueError, match=r"time of a map must be a whole number of iterates, got 100\.5"):
        fa.fit_torus(StandardMap(0.5), [0.2, 2.1], time=100.5)
    with pytest.raises(ValueError, match="step is not supported for maps"):
        fa.fit_torus(StandardMap(0.5), [0.2, 2.1], time=1000, step=0.1)


@pytest.mark.parametrize("p0", [2.5, -3.0])
def test_an_angle_of_a_flow_that_goes_round(p0):
    """A pendulum whose inertia depends on its angle: frequency, sense and area under the curve by quadrature."""
    model = fa.hamiltonian(
        "p**2/2*(1 + a*cos(q/s)) - cos(q/s)", coordinates="q", momenta="p", periodic={"q": "2*pi*s"}, a=0.2, s=0.7
    )
    energy = float(model.energy(0.2, p0))

    def momentum(q):
        return np.sqrt(2 * (energy + np.cos(q / 0.7)) / (1 + 0.2 * np.cos(q / 0.7)))

    once = quad(lambda q: 1 / ((1 + 0.2 * np.cos(q / 0.7)) * momentum(q)), 0, TURN * 0.7, epsabs=1e-14)[0]
    found = fa.fit_torus(model, [0.2, p0], time=200.0)
    assert found.classification is Classification.REGULAR
    assert abs(found.nu[0] - np.sign(p0) / once) <= found.nu_error[0] + 1e-14
    np.testing.assert_allclose(found.J, np.sign(p0) * quad(momentum, 0, TURN * 0.7, epsabs=1e-14)[0], rtol=1e-10)
    later = fa.integrate(model, [0.2, p0], time=7.0, accuracy=1e-12).z[:, 0]
    there = found.evaluate(found.theta0 + 7 * found.nu)
    np.testing.assert_allclose(there, later, atol=1e-9)


def test_an_azimuth_that_is_in_no_line_goes_round_beside_the_others():
    """A spherical pendulum: the rate of its azimuth is no line, and near 3 : 4 with the swing in the second orbit."""
    model, z, truth = shared_systems.spherical(np.random.default_rng(3), 3)
    for k in range(3):
        found = fa.fit_torus(model, z[:, k], time=400.0)
        assert found.classification is Classification.REGULAR
        assert found.names == ("th", "f")
        assert (np.abs(found.nu - truth[:, k]) <= found.nu_error).all()
        np.testing.assert_allclose(found.J[1], TURN * model.s * z[3, k], rtol=1e-10)
