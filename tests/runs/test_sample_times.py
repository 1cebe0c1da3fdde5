"""Samples at given times: against closed forms, other programs and equal samples, with the coverage of their errors."""

import numpy as np
import pytest
import shared_systems
from mpmath import mp
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import fastaff as fa
from fastaff.core.interruption import Interrupted
from fastaff.runs import schemes

OSCILLATORS = shared_systems.oscillators
LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
WAYS = {
    "default": {},
    "loose": {"accuracy": 1e-5},
    "tight": {"accuracy": 1e-12},
    "leapfrog": {"scheme": fa.LEAPFROG, "accuracy": 1e-4},
    "compensated": {"scheme": fa.SOFRONIOU_SPALETTA10, "accuracy": 1e-9},
    "collocation": {"scheme": schemes.GAUSS8},
    "Nyström": {"scheme": schemes.RKN12, "accuracy": 1e-11},
    "a step": {"step": 0.03},
    "Runge-Kutta": {"scheme": fa.RK4, "step": 0.005},
    "DOP853": {"scheme": fa.DOP853},
    "VERNER9": {"scheme": fa.VERNER9},
    "transformed": {"scheme": fa.TimeTransformed()},
}


def random_times(rng, time, count):
    """Times with gaps of all sizes: uniform, logarithmic and crowded ones, the end among them."""
    third = count // 3
    crowded = rng.uniform(0, time) + 1e-9 * np.arange(third)
    spread = np.concatenate([rng.uniform(0, time, third), time * 10.0 ** rng.uniform(-6, 0, third), crowded])
    return np.unique(np.append(spread[spread < time], time))


def along(slopes, z0, times):
    """Reference states (times, rows, orbits), integrated from each time to the next by DOP853 at 1e-13."""
    found = np.empty((len(times), *z0.shape))
    for orbit in range(z0.shape[1]):
        z, now = z0[:, orbit], 0.0
        for k, moment in enumerate(times):
            z = solve_ivp(slopes, (now, moment), z, method="DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
            now = moment
            found[k, :, orbit] = z
    return found


def assert_covered(run, exact, slack):
    """99 % of the true errors are within their estimates, none is ten times larger."""
    assert (run.status == fa.Status.OK).all()
    wrong = np.abs(run.samples - exact)
    assert (wrong <= run.sample_error + slack).mean() >= 0.99
    assert (wrong <= 10 * run.sample_error + slack).all()


# --- closed forms -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
def test_oscillators_by_every_family_of_schemes(way):
    rng = np.random.default_rng(4)
    a, b = rng.uniform(0.5, 3.0, 2)
    z0 = rng.normal(size=(4, 70))
    times = random_times(rng, 30.0, 45)
    run = fa.integrate(OSCILLATORS(a, b), z0, time=30.0, samples=times, **WAYS[way])
    w = np.sqrt([a, b])[:, None]
    phase = w * times[:, None, None]
    q, p = z0[:2], z0[2:]
    exact = np.concatenate(
        [q * np.cos(phase) + p / w * np.sin(phase), p * np.cos(phase) - w * q * np.sin(phase)], axis=1
    )
    np.testing.assert_array_equal(run.times, times)
    np.testing.assert_array_equal(run.samples[-1], run.z)
    if run.sample_error is None:
        bound = {"a step": 3e-13, "Runge-Kutta": 1e-7, "DOP853": 1e-10, "VERNER9": 1e-11, "transformed": 3e-9}
        assert np.abs(run.samples - exact).max() < bound[way]
    else:
        assert_covered(run, exact, 3e-15)


@pytest.mark.parametrize("seed", range(4))
def test_kepler_orbits_by_their_equation(seed):
    """Eccentric orbits, whose error differs by orders of magnitude between pericentre and apocentre."""
    rng = np.random.default_rng(seed)
    e = rng.uniform(0.0, 0.6, 40)
    times = random_times(rng, 40.0, 60)
    model = fa.hamiltonian("-1/sqrt(x**2 + y**2)")
    z0 = np.stack([1 - e, 0 * e, 0 * e, np.sqrt((1 + e) / (1 - e))])
    run = fa.integrate(model, z0, time=40.0, samples=times, accuracy=10.0 ** rng.uniform(-11, -5))
    mean = times[:, None] + 0 * e
    E = mean + e * np.sin(mean)
    for _ in range(60):
        E -= (E - e * np.sin(E) - mean) / (1 - e * np.cos(E))
    beside = np.sqrt(1 - e**2)
    rate = 1 / (1 - e * np.cos(E))
    exact = np.stack([np.cos(E) - e, beside * np.sin(E), -np.sin(E) * rate, beside * np.cos(E) * rate], axis=1)
    assert_covered(run, exact, 1e-14)


def test_friction_by_the_matrix_exponential():
    rng = np.random.default_rng(8)
    a, b, g = rng.uniform(0.3, 2.0, 3)
    model = fa.hamiltonian("a*x**2/2 + b*(x - y)**2/2", a=a, b=b, friction=g)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.array([[a + b, -b], [-b, b]]), -g * np.eye(2)]])
    z0 = rng.normal(size=(4, 20))
    times = random_times(rng, 8.0, 30)
    run = fa.integrate(model, z0, time=8.0, samples=times)
    assert_covered(run, np.array([expm(A * t) @ z0 for t in times]), 3e-15)


# --- other programs ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("accuracy", [1e-6, 1e-10])
def test_regular_and_chaotic_orbits_and_their_errors(accuracy):
    z0 = fa.energy_sample(fa.HenonHeiles(), energy=0.13, section="x=0", orbits=12, seed=3).z0
    times = random_times(np.random.default_rng(5), 120.0, 36)

    def slopes(t, z):
        x, y, u, v = z
        return [u, v, -x - 2 * x * y, -y - x**2 + y**2]

    run = fa.integrate(fa.HenonHeiles(), z0, time=120.0, samples=times, accuracy=accuracy)
    assert_covered(run, along(slopes, z0, times), 1e-11)
    alone = fa.integrate(fa.HenonHeiles(), z0[:, [7]], time=120.0, samples=times, accuracy=accuracy, threads=1)
    np.testing.assert_array_equal(alone.samples[..., 0], run.samples[..., 7])
    np.testing.assert_array_equal(alone.sample_error[..., 0], run.sample_error[..., 7])


def test_taylor_series_of_thirty_digits():
    """By mpmath, a nonlinear pendulum next to its separatrix."""
    times = np.array([1e-7, 0.013, 1.0, 1.0000001, 7.7, 11.0])
    model = fa.hamiltonian("-cos(x)", coordinates="x")
    run = fa.integrate(model, [0.1, 1.98], time=12.0, samples=times, accuracy=1e-12)
    with mp.workdps(30):
        solved = mp.odefun(lambda t, z: [z[1], -mp.sin(z[0])], 0, [mp.mpf(0.1), mp.mpf(1.98)])
        exact = np.array([[float(part) for part in solved(mp.mpf(float(t)))] for t in times])[..., None]
    assert_covered(run, exact, 1e-14)


def test_driven_rotating_and_nonseparable_systems():
    rng = np.random.default_rng(2)
    times = random_times(rng, 25.0, 30)
    model = shared_systems.duffing(a=0.3, w=1.2)
    z0 = rng.uniform(-0.5, 0.5, (2, 6))
    driven = fa.integrate(model, z0, time=25.0, samples=np.append(0.0, times))
    exact = along(lambda t, z: [z[1], z[0] - z[0] ** 3 + 0.3 * np.cos(1.2 * t)], z0, times)
    rows = [driven.names.index(name) for name in ("x", "p_x")]
    wrong = np.abs(driven.samples[1:, rows] - exact)
    assert (wrong <= driven.sample_error[1:, rows] + 1e-12).mean() >= 0.99
    assert (wrong <= 10 * driven.sample_error[1:, rows] + 1e-12).all()
    np.testing.assert_array_equal(driven.samples[0, rows], z0)
    np.testing.assert_array_equal(driven.sample_error[0], 0.0)

    w = 0.4
    turning = fa.hamiltonian("(x**2 + 2*y**2)/2", rotation=w)
    z0 = rng.normal(size=(4, 6))
    A = np.array([[0, w, 1, 0], [-w, 0, 0, 1], [-1, 0, 0, w], [0, -2, -w, 0]], float)
    run = fa.integrate(turning, z0, time=25.0, samples=times)
    assert_covered(run, np.array([expm(A * t) @ z0 for t in times]), 1e-13)

    bent = fa.hamiltonian("(p_x**2*(1 + x**2/2) + x**2)/2", coordinates="x", momenta="p_x")
    z0 = rng.normal(size=(2, 6))
    exact = along(lambda t, z: [z[1] * (1 + z[0] ** 2 / 2), -z[0] - z[1] ** 2 * z[0] / 2], z0, times)
    for given in ({}, {"scheme": schemes.GAUSS16}):
        assert_covered(fa.integrate(bent, z0, time=25.0, samples=times, **given), exact, 1e-11)


def test_dissipative_flow():
    rng = np.random.default_rng(6)
    z0 = rng.normal(size=(3, 5)) + np.array([[0.0], [0.0], [25.0]])
    times = random_times(rng, 4.0, 24)
    run = fa.integrate(LORENZ, z0, time=4.0, samples=np.append(0.0, times))
    exact = along(lambda t, z: [10 * (z[1] - z[0]), z[0] * (28 - z[2]) - z[1], z[0] * z[1] - 8 / 3 * z[2]], z0, times)
    np.testing.assert_allclose(run.samples[1:], exact, atol=1e-7)
    np.testing.assert_array_equal(run.samples[0], z0)
    assert run.sample_error is None


# --- steps, maps, ends ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("given", [{}, {"step": 0.07}, {"scheme": fa.DOP853}, {"scheme": fa.TimeTransformed()}])
def test_equal_times_are_equal_samples(given):
    z0 = np.random.default_rng(1).uniform(-0.2, 0.2, (4, 9))
    equal = fa.integrate(fa.HenonHeiles(), z0, time=7.0, samples=13, **given)
    timed = fa.integrate(fa.HenonHeiles(), z0, time=7.0, samples=np.linspace(0, 7.0, 14), **given)
    np.testing.assert_array_equal(timed.samples[1:], equal.samples)
    np.testing.assert_array_equal(timed.samples[0], z0)
    np.testing.assert_array_equal(timed.times[1:], equal.times)


def test_samples_leave_given_steps_alone():
    """The end of a run has its bits, and so do samples at the ends of its steps."""
    z0 = np.random.default_rng(1).uniform(-0.2, 0.2, (4, 9))
    steps = fa.integrate(fa.HenonHeiles(), z0, time=8.0, step=1 / 16, samples=128)
    times = np.sort(np.append(np.random.default_rng(2).uniform(0, 8, 40), steps.times[[3, 17, 90]]))
    timed = fa.integrate(fa.HenonHeiles(), z0, time=8.0, step=1 / 16, samples=times)
    np.testing.assert_array_equal(timed.z, steps.z)
    at = np.searchsorted(times, steps.times[[3, 17, 90]])
    np.testing.assert_array_equal(timed.samples[at], steps.samples[[3, 17, 90]])
    few = fa.integrate(fa.HenonHeiles(), z0, time=8.0, step=1 / 16, samples=times[::3])
    np.testing.assert_array_equal(few.samples, timed.samples[::3])


def test_iterates_of_a_map():
    z0 = np.random.default_rng(3).uniform(-0.1, 0.1, (2, 4))
    run = fa.integrate(shared_systems.henon(), z0, time=20, samples=[0, 1, 2, 5, 17])
    every = fa.integrate(shared_systems.henon(), z0, time=20, samples=20).samples
    np.testing.assert_array_equal(run.samples[0], z0)
    np.testing.assert_array_equal(run.samples[1:], every[[0, 1, 4, 16]])
    np.testing.assert_array_equal(run.times, [0, 1, 2, 5, 17])
    with pytest.raises(ValueError, match=r"samples of a map must be whole numbers of iterates, got 2\.5"):
        fa.integrate(shared_systems.henon(), z0, time=20, samples=[1, 2.5])


@pytest.mark.parametrize("given", [{"step": 0.05, "energy_tolerance": 1e12}, {"scheme": fa.DOP853}])
def test_orbits_that_leave_keep_their_samples_until_then(given):
    times = np.sort(np.random.default_rng(0).uniform(0, 40, 60))
    run = fa.integrate(shared_systems.well(-1.0), [1.0, 0.0], time=40.0, samples=times, **given)
    seen = np.isfinite(run.samples[:, 0, 0])
    assert run.status[0] == fa.Status.ESCAPED
    assert 8 <= seen.sum() <= 40
    assert not seen[np.argmin(seen) :].any()
    np.testing.assert_allclose(run.samples[seen][:, 0, 0], np.cosh(times[seen]), rtol=1e-8)


def test_the_start_alone():
    run = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1.0, samples=[0.0])
    np.testing.assert_array_equal(run.samples[0, :, 0], [0.1, 0.0, 0.0, 0.2])
    plain = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1.0)
    np.testing.assert_array_equal(run.z, plain.z)
    np.testing.assert_array_equal(run.error, plain.error)


def test_an_interrupted_run_keeps_samples():
    def stop(fraction):
        if fraction > 0.3:
            raise KeyboardInterrupt

    z0 = np.tile([[0.1], [0.0], [0.0], [0.2]], (1, 400)) * np.linspace(0.5, 1.0, 400)
    with pytest.raises(Interrupted) as stopped:
        fa.integrate(
            fa.HenonHeiles(),
            z0,
            time=3000.0,
            step=0.02,
            samples=np.geomspace(1.0, 3000.0, 12),
            threads=1,
            callback=stop,
        )
    partial = stopped.value.partial
    done = partial.status == fa.Status.OK
    assert 0 < done.sum() < 400
    assert np.isfinite(partial.samples[..., done]).all()
    assert (partial.status[~done] == fa.Status.INTERRUPTED).all()


# --- the result -------------------------------------------------------------------------------------------------------


def test_results_files_recipes_and_figures(tmp_path):
    times = np.geomspace(0.1, 20.0, 30)
    run = fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=20.0, samples=times)
    path = fa.save(tmp_path / "run", run)
    again = fa.files.recipe(path).run()
    np.testing.assert_array_equal(again.samples, run.samples)
    np.testing.assert_array_equal(again.times, times)
    np.testing.assert_array_equal(fa.load(path).samples, run.samples)
    np.testing.assert_array_equal(run.to_xarray()["samples"].coords["sample"].size, 30)
    assert run.energy_error.max() < 1e-9
    curve = run.plot(x="time", y="x").points[0]
    assert curve.get_xdata()[0] == times[0]
    np.testing.assert_allclose(curve.get_xdata()[-1], times[-1])


def test_jobs_take_times(tmp_path):
    z0 = np.random.default_rng(5).uniform(-0.2, 0.2, (4, 6))
    times = [0.0, 0.25, 1 / 3, 2.5]
    job = fa.Job(
        model=fa.HenonHeiles(),
        initial_conditions=z0,
        integrate=fa.jobs.IntegrateOptions(time=3.0, samples=times),
        options=fa.jobs.RunOptions(step=0.05),
    )
    text = fa.Job(
        model=fa.HenonHeiles(), initial_conditions={"grid": "2x2"}, integrate={"time": 3.0, "samples": np.array(times)}
    ).text()
    assert 'samples = "0.0:0.25:0.3333333333333333:2.5"' in text
    found = fa.run(job, tmp_path / "store.zarr")["integrate"]
    np.testing.assert_array_equal(found.times, times)
    np.testing.assert_array_equal(
        found.samples, fa.integrate(fa.HenonHeiles(), z0, time=3.0, samples=times, step=0.05).samples
    )
    with pytest.raises(ValueError, match=r"samples must be times from 0 to time=2, got 2\.5"):
        fa.Job(model=fa.HenonHeiles(), initial_conditions=z0, integrate={"time": 2.0, "samples": times}).plan()


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        ([], "samples must have at least one time, got none. Use samples=0 for the end alone."),
        ([1.0, np.nan], "samples must be finite times, got nan"),
        ([1.0, np.inf], "samples must be finite times, got inf"),
        ([1.0, 0.5], "samples must be increasing times, got 0.5 after 1"),
        ([1.0, 1.0], "samples must be increasing times, got 1 after 1"),
        ([-1.0, 1.0], "samples must be times from 0 to time=2, got -1"),
        ([1.0, 2.5], "samples must be times from 0 to time=2, got 2.5"),
        ([[1.0, 2.0]], r"samples must be times of shape \(samples,\), the same for all orbits, got shape \(1, 2\)"),
    ],
)
def test_wrong_times(samples, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=2.0, samples=samples)
    with pytest.raises(TypeError, match="samples must be an array of real numbers"):
        fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=2.0, samples=["a", "b"])
