"""Autonomous systems dz/dt = f(z) as text: solutions, sections, exponents, and words for what is wrong."""

import pickle
from typing import NamedTuple

import numpy as np
import pytest
import shared_systems
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.special import ellipk

import fastaff as fa
from fastaff import files
from fastaff.systems.models.contracts import Kind

LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
LETTERS = "abcdefghijklmnop"


def lorenz(t, z, s=10.0, r=28.0, b=8 / 3):
    return np.array([s * (z[1] - z[0]), z[0] * (r - z[2]) - z[1], z[0] * z[1] - b * z[2]])


def linear(A, shift=None):
    """The system z' = A z + shift, its numbers as parameters."""
    d = len(A)
    given = {f"m{i}{LETTERS[j]}": A[i, j] for i in range(d) for j in range(d)} if d <= 4 else {}
    entry = (lambda i, j: f"m{i}{LETTERS[j]}") if d <= 4 else (lambda i, j: f"({float(A[i, j])!r})")
    rows = [" + ".join(f"{entry(i, j)}*u{j}" for j in range(d)) for i in range(d)]
    if shift is not None:
        rows = [f"{row} + ({float(extra)!r})" for row, extra in zip(rows, shift)]
    return fa.ode("; ".join(f"u{i}' = {row}" for i, row in enumerate(rows)), **given)


def starts(count, seed=0):
    """Points near the attractor of Lorenz."""
    z0 = np.random.default_rng(seed).normal(size=(3, count)) + np.array([[1.0], [1.0], [25.0]])
    return fa.integrate(LORENZ, z0, time=20.0).z


# --- solutions ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [1, 2, 3, 5, 16])
def test_linear_systems_are_matrix_exponentials(d):
    """States, samples and tangent vectors of z' = A z, any number of variables."""
    rng = np.random.default_rng(d)
    A, z0, time = rng.normal(size=(d, d)) / np.sqrt(d), rng.normal(size=(d, 7)) * 10.0 ** rng.uniform(-3, 3), 2.3
    model = linear(A)
    run = fa.integrate(model, z0, time=time, samples=4)
    assert run.z.shape == (d, 7)
    assert run.samples.shape == (4, d, 7)
    assert run.names == model.coordinates == tuple(f"u{i}" for i in range(d))
    np.testing.assert_allclose(run.z, expm(A * time) @ z0, rtol=0, atol=1e-10 * np.abs(run.z).max())
    np.testing.assert_allclose(run.samples[1], expm(A * time / 2) @ z0, rtol=0, atol=1e-10 * np.abs(run.z).max())
    np.testing.assert_array_equal(run.energy_error, 0.0)
    tangent = fa.tangent_map(model, z0[:, :2], time=time)
    assert tangent.vectors.shape == (d, d, 2)
    for k in range(2):
        np.testing.assert_allclose(tangent.matrix[..., k], expm(A * time), atol=1e-10 * np.abs(expm(A * time)).max())


@pytest.mark.parametrize("scheme", [fa.DOP853, fa.VERNER9])
def test_lorenz_is_that_of_scipy(scheme):
    z0 = np.array([[1.0, -3.0, 5.0], [1.0, 2.0, 3.0], [20.0, 25.0, 30.0]])
    run = fa.integrate(LORENZ, z0, time=3.0, scheme=scheme)
    for k in range(3):
        exact = solve_ivp(lorenz, (0, 3), z0[:, k], method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        np.testing.assert_allclose(run.z[:, k], exact, atol=2e-9)


def test_time_is_a_variable_of_ones_own():
    run = fa.integrate(fa.ode("x' = cos(w*t); t' = 1", w=2.0), [0.3, 0.1], time=3.0)
    np.testing.assert_allclose(run["x"], 0.3 + (np.sin(2 * 3.1) - np.sin(0.2)) / 2, rtol=1e-11)


def test_a_hamiltonian_system_as_a_flow_is_the_same():
    model = fa.ode("x' = u; y' = v; u' = -x - 2*x*y; v' = -y - x**2 + y**2")
    z0 = fa.energy_sample(fa.HenonHeiles(), energy=0.1, section="x=0", orbits=40, seed=1).z0
    one, other = (fa.integrate(body, z0, time=30.0, scheme=fa.DOP853) for body in (model, fa.HenonHeiles()))
    np.testing.assert_allclose(one.z, other.z, atol=1e-8)
    one, other = (
        fa.poincare_map(body, z0, section="x=0", crossings=5, max_time=100.0, scheme=fa.DOP853)
        for body in (model, fa.HenonHeiles())
    )
    np.testing.assert_allclose(one.times, other.times, atol=1e-7)
    np.testing.assert_allclose(one.points, other.points, atol=1e-7)
    half = fa.chaos_map(model, z0[:, :3], time=200.0, indicators=fa.LyapunovSpectrum()).spectrum
    np.testing.assert_allclose(half, -half[::-1], atol=0.02)


# --- sections -------------------------------------------------------------------------------------------------------


def test_crossings_are_those_of_scipy():
    z0 = starts(4)
    cut = fa.poincare_map(LORENZ, z0, section="z=27", crossings=6, max_time=100.0)
    assert cut.points.shape == (3, 6, 4)
    assert cut.section == fa.Hyperplane((0.0, 0.0, 1.0), 27.0)
    np.testing.assert_allclose(cut["z"], 27.0, rtol=1e-14)

    def event(t, z):
        return z[2] - 27.0

    event.direction = 1
    for k in range(4):
        found = solve_ivp(lorenz, (0, 4.0), z0[:, k], method="DOP853", rtol=1e-12, atol=1e-12, events=event)
        times = found.t_events[0][:3]
        np.testing.assert_allclose(cut.times[: times.size, k], times, atol=1e-8)


def test_any_plane_and_either_side():
    normal = (1.0, -1.0, 0.5)
    for direction in (1, -1):
        cut = fa.poincare_map(
            LORENZ, starts(5), section=fa.Hyperplane(normal, 12.0, direction), crossings=9, max_time=99.0
        )
        np.testing.assert_allclose(np.einsum("i,ico->co", normal, cut.points), 12.0, rtol=1e-13)
        rate = np.einsum("i,ico->co", normal, lorenz(0, cut.points))
        assert (rate * direction > 0).all()


# --- exponents ------------------------------------------------------------------------------------------------------


def test_exponents_of_lorenz():
    """0.9056, 0, -14.572 (Viswanath 1998, Sprott 2003) as means over orbits; the sum is the divergence."""
    found = fa.chaos_map(LORENZ, starts(96), time=250.0, indicators=fa.LyapunovSpectrum())
    assert found.spectrum.shape == found.spectrum_error.shape == (3, 96)
    np.testing.assert_allclose(found.spectrum.sum(axis=0), -(10 + 1 + 8 / 3), rtol=0, atol=1e-10)
    mean, error = found.spectrum.mean(axis=1), found.spectrum.std(axis=1) / np.sqrt(96)
    # Vectors align once, which shifts each by some 1/time.
    np.testing.assert_array_less(np.abs(mean - [0.9056, 0.0, -14.572]), 4 * error + 2.0 / 250)
    assert (error < 0.005).all()
    assert (np.abs(found.spectrum - [[0.9056], [0.0], [-14.572]]) < 10 * found.spectrum_error + 0.1).mean() > 0.97
    assert found.chaotic.all()


ROESSLER = fa.ode("dx/dt = -y - z\n dy/dt = x + a*y\n dz/dt = b + z*(x - c)", a=0.2, b=0.2, c=5.7)


@pytest.mark.slow
def test_exponents_of_roessler():
    """0.0714, 0, -5.394 (Sprott 2003)."""
    z0 = fa.integrate(ROESSLER, np.random.default_rng(1).uniform(0.5, 2, (3, 48)), time=100.0).z
    found = fa.chaos_map(ROESSLER, z0, time=800.0, indicators=fa.LyapunovSpectrum())
    mean, error = found.spectrum.mean(axis=1), found.spectrum.std(axis=1) / np.sqrt(48)
    np.testing.assert_array_less(np.abs(mean - [0.0714, 0.0, -5.394]), 4 * error + [0.002, 0.002, 0.01])


@pytest.mark.parametrize("d", [1, 2, 3, 4, 5])
def test_exponents_of_linear_systems_are_real_parts(d):
    """A triangular matrix with its eigenvalues on the diagonal: any order of the exponents, their sum is the trace."""
    rng = np.random.default_rng([d, 3])
    own = np.sort(rng.uniform(-1.5, 0.5, d))[::-1]
    turn = np.linalg.qr(rng.normal(size=(d, d)))[0]
    A = turn @ (np.diag(rng.permutation(own)) + 0.3 * np.triu(rng.normal(size=(d, d)), 1)) @ turn.T
    found = fa.chaos_map(linear(A), rng.normal(size=(d, 3)), time=200.0, indicators=fa.LyapunovSpectrum())
    np.testing.assert_allclose(found.spectrum, np.repeat(own[:, None], 3, axis=1), atol=0.08)
    np.testing.assert_allclose(found.spectrum.sum(axis=0), np.trace(A), rtol=0, atol=1e-9)


def test_indicators_tell_a_cycle_from_chaos():
    """Van der Pol's cycle, in three variables with one that decays; Lorenz at r = 28 and at r = 14, where it rests."""
    cycle = fa.ode("x' = y; y' = m*(1 - x**2)*y - x; z' = -z", m=1.0)
    found = fa.chaos_map(cycle, [[2.0, 0.5], [0.0, 0.1], [0.1, 0.2]], time=400.0, indicators="spectrum,lyapunov")
    np.testing.assert_allclose(found.spectrum, [[0.0] * 2, [-1.0] * 2, [-1.0588] * 2], atol=0.03)
    assert not found.chaotic.any()
    given = fa.chaos_map(LORENZ, starts(3), time=200.0, deviation_vectors=np.eye(3), indicators="spectrum,sali,megno")
    assert given.chaotic.all()
    np.testing.assert_allclose(given.spectrum.sum(axis=0), -41 / 3, atol=1e-10)


# --- promises -------------------------------------------------------------------------------------------------------


def test_a_bad_orbit_has_a_status_and_no_neighbour():
    """x' = x^2 ends at time 1/x0; y' = -1/(2 y) leaves its domain at y0^2."""
    model = fa.ode("x' = x**2; z' = -z")
    run = fa.integrate(model, [[0.1, 2.0, 0.2], [1.0, 1.0, 1.0]], time=3.0)
    assert [fa.Status(status) for status in run.status][::2] == [fa.Status.OK] * 2
    assert run.status[1] != fa.Status.OK
    np.testing.assert_allclose(run["x"][::2], [0.1 / 0.7, 0.2 / 0.4], rtol=1e-10)
    wall = fa.integrate(fa.ode("y' = -1/(2*y**2)"), [[1.0, 5.0]], time=1.0)
    assert wall.status[0] != fa.Status.OK
    assert wall.z[0, 1] == pytest.approx((125 - 1.5) ** (1 / 3), rel=1e-11)


class Own(NamedTuple):
    """A flow of one's own: a damped oscillator in its amplitude, and a clock."""

    k: float
    g: float

    kind = Kind.FLOW
    coordinates = ("x", "v", "c")
    degrees_of_freedom = 2

    def rates(self, x, v, c):
        return v, -self.k * x - self.g * v, 1.0 + 0.0 * c

    def tangent_rates(self, x, v, c, dx, dv, dc):
        return dv, -self.k * dx - self.g * dv, 0.0 * dc

    def margin(self, x, v, c):
        return 1.0 + 0.0 * x


def test_a_flow_of_ones_own():
    own = Own(1.3, 0.2)
    text = fa.ode("x' = v; v' = -k*x - g*v; c' = 1", k=1.3, g=0.2)
    z0 = np.random.default_rng(1).normal(size=(3, 10))
    np.testing.assert_allclose(fa.integrate(own, z0, time=4.0).z, fa.integrate(text, z0, time=4.0).z, atol=1e-11)
    spectrum = fa.chaos_map(own, z0, time=100.0, indicators=fa.LyapunovSpectrum()).spectrum
    np.testing.assert_allclose(spectrum.sum(axis=0), -0.2, atol=1e-11)


def test_values_files_and_parameters(tmp_path):
    assert pickle.loads(pickle.dumps(LORENZ)) == LORENZ
    assert repr(LORENZ).startswith("FormulaODE(\"x' = s*(y - x)")
    other = LORENZ._replace(r=14.0)
    rest = fa.integrate(other, [[1.0], [2.0], [3.0]], time=60.0)
    root = np.sqrt(8 / 3 * 13)
    np.testing.assert_allclose(np.abs(rest.z[:, 0]), [root, root, 13], rtol=1e-6)
    run = fa.integrate(LORENZ, [1.0, 2.0, 3.0], time=1.0)
    again = fa.load(run.save(tmp_path / "o.npz"))
    assert again.z.tobytes() == run.z.tobytes()
    assert files.recipe(tmp_path / "o.npz").run().z.tobytes() == run.z.tobytes()


def test_jobs_of_a_flow(tmp_path):
    z0 = starts(5)
    job = fa.Job(
        model=LORENZ,
        initial_conditions=z0,
        energy_surface={"section": "z=27"},
        integrate={"time": 1.0},
        poincare={"crossings": 4},
        chaos_map={"returns": 20.0, "indicators": "spectrum"},
        chunk=2,
    )
    found = fa.run(job, tmp_path / "a.zarr")
    np.testing.assert_array_equal(found["integrate"].z, fa.integrate(LORENZ, z0, time=1.0).z)
    assert found["poincare"].points.shape == (3, 4, 5)
    np.testing.assert_allclose(found["chaos_map"].spectrum.sum(axis=0), -41 / 3, atol=1e-9)


# --- words ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "given", "error", "message"),
    [
        (3, {}, TypeError, "text must be equations such as .* got 3"),
        ("", {}, ValueError, "text must have 1 to 16 equations such as"),
        ("x + y", {}, ValueError, r"text must be equations such as .*, got 'x \+ y'"),
        ("x = y; y' = x", {}, ValueError, "text must be equations"),
        ("x' = ", {}, ValueError, "text must be equations"),
        ("x' = x; x' = 1", {}, ValueError, "variable 'x' is taken"),
        ("rates' = 1", {}, ValueError, "variable 'rates' is taken"),
        ("x' = k*x", {}, ValueError, "'k'"),
        ("alpha1' = alpa1*2", {}, ValueError, "alpha1"),
        ("x' = x", {"k": 1.0}, ValueError, "parameter 'k' must be a name in the equations"),
        ("x' = k*x", {"k": "a"}, TypeError, "k must be a real number"),
        ("x' = k*x", {"k": np.nan}, ValueError, "k must be finite"),
        ("x' = cos(t)", {}, ValueError, "x' must not depend on t. Try a variable t with t' = 1"),
        ("x' = cos(w*t)", {"w": 1.0, "drive_period": "2*pi/w"}, ValueError, "drive_period must be left out for an ODE"),
        ("x' = __import__('os')", {}, ValueError, "text"),
        ("x' = log(-1 - x**2)", {}, ValueError, "no finite real value"),
        ("; ".join(f"u{k}' = u{k}" for k in range(17)), {}, ValueError, "1 to 16 equations .* got 17"),
        ("x' = x", {"domain": 1}, TypeError, "domain"),
        (
            "x' = y; y' = -sin(x)",
            {"periodic": {"x": 3.0}},
            ValueError,
            r"periodic\['x'\] must be a period of the system, got 3",
        ),
        ("x' = y; y' = -sin(x)", {"periodic": {"z": 3.0}}, ValueError, "periodic must be of x, y, got one of 'z'"),
    ],
)
def test_wrong_texts(text, given, error, message):
    with pytest.raises(error, match=message):
        fa.ode(text, **given)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda z: fa.integrate(LORENZ, z, time=1.0, scheme=fa.KAHAN_LI8),
            ValueError,
            "KAHAN_LI8 requires a Ham.* DOP853",
        ),
        (lambda z: fa.integrate(LORENZ, z, time=1.0, scheme=fa.AUTO), ValueError, "scheme AUTO requires .* Use DOP853"),
        (lambda z: fa.chaos_map(LORENZ, z, time=1.0, scheme="leapfrog"), ValueError, "scheme LEAPFROG requires"),
        (lambda z: fa.tangent_map(LORENZ, z, time=1.0, scheme="leapfrog"), ValueError, "scheme LEAPFROG requires"),
        (lambda z: fa.integrate(LORENZ, z, time=1.0, scheme=fa.RK4), ValueError, "step must be given .* with RK4"),
        (lambda z: fa.integrate(LORENZ, z, time=1.0, accuracy=1e-8), ValueError, "accuracy .* Use rtol and atol"),
        (lambda z: fa.integrate(LORENZ, np.ones((6, 2)), time=1.0), ValueError, r"shape \(3,\) or \(3, orbits\)"),
        (lambda z: fa.frequency_map(LORENZ, z, time=1.0), TypeError, r"got an ODE system\. Use fa.naff"),
        (
            lambda z: fa.energy_grid(LORENZ, energy=1.0, axes={"x": [1]}, solve="y"),
            ValueError,
            "energy is not supported for ODE",
        ),
        (
            lambda z: fa.energy_sample(LORENZ, energy=1.0, orbits=3),
            ValueError,
            "energy is not supported for ODE systems",
        ),
        (lambda z: fa.plot.edge(LORENZ, "x=0", energy=1.0), TypeError, "got an ODE system"),
        (lambda z: fa.fit_torus(LORENZ, z[:, 0], time=5.0), TypeError, "got an ODE system"),
        (
            lambda z: fa.chaos_map(LORENZ, z, time=1.0, indicators="zero_one_test"),
            TypeError,
            "those of deviation vectors",
        ),
        (
            lambda z: fa.chaos_map(LORENZ, z, time=1.0, indicators="gali_4"),
            ValueError,
            "GALI.count must be from 2 to 3",
        ),
        (lambda z: fa.tangent_map(LORENZ, z, time=1.0, deviation_vectors=np.eye(4)), ValueError, r"shape \(count, 3\)"),
        (
            lambda z: fa.poincare_map(LORENZ, z, section="w=0", crossings=1, max_time=1.0),
            ValueError,
            "section must be one of x=c, y=c, z=c, got 'w=0'",
        ),
        (
            lambda z: fa.poincare_map(LORENZ, z, section=fa.Hyperplane((1.0, 0, 0, 0)), crossings=1, max_time=1.0),
            ValueError,
            "section must depend on the 3 rows",
        ),
    ],
)
def test_what_a_flow_has_not_is_refused(call, error, message):
    with pytest.raises(error, match=message):
        call(np.ones((3, 2)))


def test_flows_know_no_units():
    # Roessler's equations with each variable in a unit of its own, and time too: against scipy in units of 1.
    def roessler(t, v):
        return [-v[1] - v[2], v[0] + 0.2 * v[1], 0.2 + v[2] * (v[0] - 5.7)]

    text = "x' = (-Y*y - Z*z)/(X*T); y' = (X*x + 0.2*Y*y)/(Y*T); z' = (0.2 + Z*z*(X*x - 5.7))/(Z*T)"
    z = np.array([[1.0, -2.0, 0.0], [2.0, 0.5, -3.0], [0.1, 0.0, 0.02]])
    truth = [solve_ivp(roessler, (0, 15), column, method="DOP853", rtol=3e-14, atol=1e-15).y[:, -1] for column in z.T]
    for X, Y, Z, T in ((1e8, 1e8, 1e8, 1e-9), (1e14, 1e14, 1e14, 1e3), (1e-9, 1e-9, 1e-9, 1.0), (1e3, 1e-2, 1e5, 1e9)):
        bound = 1e-9 if X == Y else 1e-6  # a variable of 1e-9 of another one: rounding of both counts alike
        model = fa.ode(text, X=X, Y=Y, Z=Z, T=T)
        unit = np.array([[1 / X], [1 / Y], [1 / Z]])
        for scheme in ("dop853", "verner9"):
            run = fa.integrate(model, z * unit, time=15 * T, scheme=scheme)
            assert np.all(run.status == fa.Status.OK)
            assert np.abs(run.z / unit - np.array(truth).T).max() < bound


def test_hamiltonians_of_adaptive_schemes_know_no_units():
    for unit in (1e-10, 1.0, 1e10):
        model = shared_systems.plane(1e-6, 1e-6, c=1e-6 / unit, d=1e-6 / unit)
        start = unit * np.array([0.1, 0.2, 3e-4, 1e-4])
        run = fa.integrate(model, start, time=2e5, scheme="dop853")
        if unit == 1e-10:
            first = run.z / unit
        assert np.abs(run.z / unit - first).max() < 1e-8


def test_a_variable_of_rounding_noise_alone_does_not_stop_a_flow():
    flow = fa.ode("x' = A*sin(z) + C*cos(y); y' = A*cos(z); z' = C*sin(y)", A=0.0, C=1.0)
    run = fa.integrate(flow, [0.0, np.pi / 2, 0.0], time=100.0)  # cos(pi/2) is 6e-17: x is noise
    assert run.status[0] == fa.Status.OK
    assert np.allclose(run.z[1:, 0], [np.pi / 2, 100.0], rtol=1e-14)
    lorenz = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
    axis = fa.integrate(lorenz, [0.0, 0.0, 20.0], time=30.0)
    assert np.all(axis.z[:2] == 0)
    assert np.allclose(axis.z[2], 20 * np.exp(-80.0), rtol=1e-9)


def test_a_section_of_a_variable_with_a_period_counts_each_turn():
    """Of a rotating pendulum, behind a clock: the time of a turn is 4 K(4/p^2)/p, with p at the bottom."""
    p = np.random.default_rng(31).uniform(2.1, 4.0)
    model = fa.ode("s' = 1; x' = y; y' = -sin(x)", periodic={"x": "2*pi"})
    assert pickle.loads(pickle.dumps(model)).periods() == (0.0, 2 * np.pi, 0.0)
    found = fa.poincare_map(model, [0.0, -0.1, p], section="x=0", crossings=4, max_time=50.0, rtol=1e-12, atol=1e-12)
    assert found.section == fa.models.sections.AngleEquals((0.0, 1.0, 0.0), 0.0, 2 * np.pi, 1)
    turn = 4 * ellipk(4 / found.points[2, 0, 0] ** 2) / found.points[2, 0, 0]
    np.testing.assert_allclose(np.diff(found.times[:, 0]), turn, rtol=1e-10)
    np.testing.assert_allclose(found.points[1], 0.0, atol=1e-10)
    np.testing.assert_allclose(found.points[0], found.times, atol=1e-10)
