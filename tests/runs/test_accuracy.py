"""Accuracy that is asked for: errors cover the truth, whatever the system, its units, its origin and the zero of V."""

from functools import cache

import mpmath
import numpy as np
import pytest
import shared_systems
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipj, ellipk

import fastaff as fa
from fastaff.runs import accuracy as accuracy_module
from fastaff.runs.accuracy import SLIGHTLY, Steps, round_down_to_grid, shortening
from fastaff.runs.flow import Damping
from fastaff.runs.options import Options, plan
from fastaff.runs.scales import motion
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, RKN12
from fastaff.sections import poincare_map as poincare_module
from fastaff.systems.models.mechanics import system_of
from fastaff.systems.models.sections import Stroboscopic

HH = fa.HenonHeiles()


def chain(rng, n, *, length=1.0, time=1.0, constant=0.0, origin=0.0):
    """Random coupled oscillators with unit masses, in units of length and time, and their matrix."""
    A = rng.normal(size=(n, n))
    K = (A @ A.T + 0.2 * np.eye(n)) / time**2
    return shared_systems.springs(K, origin=origin, zero=constant * length**2 / time**2), K


def chain_at(K, z, t, origin=0.0):
    """The states of the oscillators at the time t."""
    n = len(K)
    square, U = np.linalg.eigh(K)
    w = np.sqrt(square)[:, None]
    q, p = U.T @ (z[:n] - origin), U.T @ z[n:]
    return np.vstack(
        [U @ (q * np.cos(w * t) + p / w * np.sin(w * t)) + origin, U @ (p * np.cos(w * t) - w * q * np.sin(w * t))]
    )


def covered(true, estimate):
    """Assert that 99 % of the errors lie within the estimates and none ten times beyond."""
    ratio = true / estimate
    assert np.mean(ratio <= 1) >= 0.99
    assert ratio.max() < 10


@pytest.mark.parametrize("accuracy", [1e-3, 1e-6, None, 1e-12])
@pytest.mark.parametrize("seed", [1, 2])
def test_errors_of_states_cover_the_truth(accuracy, seed):
    rng = np.random.default_rng(seed)
    n = 2 + seed
    system, K = chain(rng, n)
    z0 = rng.normal(size=(2 * n, 60))
    for time in (rng.uniform(1, 10), rng.uniform(100, 400)):
        run = fa.integrate(system, z0, time=time, accuracy=accuracy, samples=3)
        for z, error, t in [(run.z, run.error, time), *zip(run.samples, run.sample_error, run.times)]:
            covered(np.abs(z - chain_at(K, z0, t)).max(axis=0), error.max(axis=0))
        if accuracy != 1e-12:
            assert np.median(run.error.max(axis=0)) < 30 * (accuracy or 1e-10)


@pytest.mark.parametrize(
    "scheme", [fa.BLANES_MOAN6, fa.SOFRONIOU_SPALETTA10, fa.YOSHIDA4, fa.RK4], ids=lambda scheme: scheme.name
)
def test_errors_cover_for_every_scheme(scheme):
    rng = np.random.default_rng(5)
    system, K = chain(rng, 3)
    z0 = rng.normal(size=(6, 100))
    run = fa.integrate(system, z0, time=50.0, accuracy=1e-7, scheme=scheme)
    true = np.abs(run.z - chain_at(K, z0, 50.0)).max(axis=0)
    covered(true, run.error.max(axis=0))
    assert true.max() < 1e-5


def test_a_pendulum_from_rest():
    """theta = 2 asin(k sn(K - t)), k = sin(theta0/2); from rest at any angle, also where V'' = 0."""
    theta0 = np.array([0.01, 0.5, np.pi / 2, 2.5, 3.0])
    k = np.sin(theta0 / 2)
    run = fa.integrate(fa.hamiltonian("-cos(x)", coordinates="x"), np.array([theta0, 0 * theta0]), time=30.0)
    sn, cn, dn, _ = ellipj(ellipk(k**2) - 30.0, k**2)
    true = np.abs(
        run.z
        - np.array(
            [2 * np.arcsin(k * sn), -2 * k * cn * dn / np.sqrt(1 - k**2 * sn**2) * np.sqrt(1 - k**2 * sn**2) / dn]
        )
    )
    assert (run.status == fa.Status.OK).all()
    assert (true[0] <= np.maximum(run.error[0], 1e-13)).all()
    assert (run.error.max(axis=0) < 1e-9).all()


def jacobi(u, m):
    """sn, cn, dn."""
    return (mpmath.ellipfun(name, u, m=m) for name in ("sn", "cn", "dn"))


@cache
def pendulum_at(x0, time, origin=0.0, unit=1.0):
    """Angle and velocity of a pendulum that was released at rest at (x0 - origin)/unit, by 30 digits: next to the top
    they are needed.
    """
    with mpmath.workdps(30):
        k = mpmath.sin((mpmath.mpf(x0) - origin) / mpmath.mpf(unit) / 2)
        sn, cn, _ = jacobi(mpmath.ellipk(k**2) - mpmath.mpf(time), k**2)
        return float(2 * mpmath.asin(k * sn)), float(-2 * k * cn)


def pendulum_and_oscillator(w, energy=1.0, unit=1.0, origin=0.0):
    return fa.hamiltonian("-e*cos((x - o)/l) + e*(w*y/l)**2/2", e=energy, l=unit, o=origin, w=w)


def well_at(x0, time):
    """The state in V = -x^2/2 + x^4/4 after a release at rest at x0 > 1, by 30 digits: x0 dn inside the separatrix
    2^(1/2), x0 cn outside.
    """
    with mpmath.workdps(30):
        a, excess = mpmath.mpf(x0), mpmath.mpf(x0) ** 2 - 1
        inside = excess < 1
        w = a / mpmath.sqrt(2) if inside else mpmath.sqrt(excess)
        m = 2 * excess / a**2 if inside else a**2 / (2 * excess)
        sn, cn, dn = jacobi(w * time, m)
        return (float(a * dn), float(-a * w * m * sn * cn)) if inside else (float(a * cn), float(-a * w * sn * dn))


def test_slowed_orbits_lose_what_they_should():
    """Of the energy of an oscillator as much as of the momenta, share*(u + 2 u e/(u + e)), u = sqrt(t); with the bits
    of an orbit alone.
    """
    rng = np.random.default_rng(4)
    z0, share = rng.normal(size=(4, 21)), np.geomspace(1e-8, 1e-6, 21)
    system = shared_systems.oscillators()

    def slowed(orbits):
        flow = plan(system, z0[:, orbits], Options(step=0.25)).flow.sized(np.full(len(orbits), 0.25))
        each = np.ones(len(orbits))
        damping = Damping(share[orbits], 100.0 * each, 2.0 * each)
        return flow.damped(flow.ensemble(z0[:, orbits].copy()), 5, damping, time=500.0, callback=None)[0]

    states, t = slowed(np.arange(21)), 100.0 * np.arange(1, 6)[:, None]
    energy = (states**2).sum(axis=1) / (z0**2).sum(axis=0)
    at_once, later = (share * np.sqrt(end) * (1 + 20 / (np.sqrt(end) + 10)) for end in (2.0, t))
    moving = (z0[2:] ** 2).sum(axis=0) / (z0**2).sum(axis=0)
    np.testing.assert_allclose(1 - energy, later + (2 * moving - 1) * at_once, rtol=0.2)
    for i in (0, 13):
        np.testing.assert_array_equal(slowed(np.array([i]))[..., 0], states[..., i])


def test_orbits_are_slowed_from_the_start():
    """In a chaotic sea, of whose orbits a turn amplifies what it meets; four times as many miss their errors, of single
    crossings, where the first momenta are lost after a turn.
    """
    z0 = fa.energy_sample(HH, energy=0.16, orbits=1500, section="x=0", seed=3).z0
    found, truth = (
        fa.poincare_map(HH, z0, section="x=0", crossings=40, max_time=400.0, accuracy=accuracy)
        for accuracy in (1e-5, 1e-13)
    )
    known = (truth.time_error < 0.1 * found.time_error) & (found.time_error < 0.03)
    beyond = known & (np.abs(found.times - truth.times) > found.time_error)
    assert known.mean() > 0.4
    assert beyond.any(axis=0).mean() < 0.003


@pytest.mark.parametrize("accuracy", [1e-6, 1e-9, 1e-12])
def test_rounding_next_to_a_separatrix(accuracy):
    """A random walk of the energy changes the time at the top by 1/d^2 of it, which no splitting's own error does: the
    estimates know, in any units, from any origin, in the company of an oscillator.
    """
    rng = np.random.default_rng(7)
    d, y0, w = 10 ** rng.uniform(-4, 0, 100), rng.uniform(0.2, 1.5, 100), 1.3
    ratio = []
    for energy, unit, origin in ((1.0, 1.0, 0.0), (1e6, 1e-6, 0.0), (1e-6, 1.0, 0.0), (1.0, 1.0, 8.0)):
        x0, past = unit * (np.pi - d) + origin, unit / energy**0.5
        system = pendulum_and_oscillator(w, energy, unit, origin)
        for time in (30.0, 317.0):
            run = fa.integrate(system, np.array([x0, unit * y0, 0 * x0, 0 * x0]), time=time * past, accuracy=accuracy)
            angle, speed = np.array([pendulum_at(x, time, origin, unit) for x in x0]).T
            oscillator = y0 * np.cos(w * time), -w * y0 * np.sin(w * time)
            truth = unit * np.array([angle, oscillator[0], speed / past, oscillator[1] / past])
            truth[0] += origin
            assert ((run.status == fa.Status.OK) | (run.accurate_until < run.t)).all()
            ratio.append((np.abs(run.z - truth) / run.error).max(axis=0))
            if accuracy == 1e-12:
                assert (run.accurate_until < run.t).mean() > 0.5
    covered(np.array(ratio), 1.0)


@pytest.mark.parametrize("accuracy", [1e-9, 1e-12])
def test_rounding_in_a_double_well(accuracy):
    """On both sides of the separatrix, as near as 1e-8."""
    rng = np.random.default_rng(8)
    x0 = np.sqrt(2) + rng.choice([-1, 1], 100) * 10 ** rng.uniform(-8, -1, 100)
    well = shared_systems.well(k=-1.0, c=1.0)
    run = fa.integrate(well, np.array([x0, 0 * x0]), time=100.0, accuracy=accuracy)
    truth = np.array([well_at(x, 100.0) for x in x0]).T
    covered((np.abs(run.z - truth) / run.error).max(axis=0), 1.0)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="needs 80-bit floats")
@pytest.mark.parametrize(("scheme", "most"), [(BLANES_CASAS_ESCORIHUELA8, 30), (RKN12, 400)], ids=["BCE8", "RKN12"])
def test_rounding_of_regular_orbits(scheme, most):
    """At 1e-12 rounding is all the error of Kepler orbits; the estimates are no more than 30 times as large as a
    splitting's. RKN12's, the default, are a twentieth of those, and its estimates half.
    """
    e = np.random.default_rng(9).uniform(0.05, 0.5, 100)
    z0 = np.array([1 - e, 0 * e, 0 * e, np.sqrt((1 + e) / (1 - e))])
    x, v, time = z0[0].astype(np.longdouble), z0[3].astype(np.longdouble), 300
    a = 1 / (2 / x - v**2)
    e, M = 1 - x / a, time / a**1.5
    E = M
    for _ in range(60):
        E = E - (E - e * np.sin(E) - M) / (1 - e * np.cos(E))
    r, b = a * (1 - e * np.cos(E)), a * np.sqrt(1 - e**2)
    truth = np.array([a * (np.cos(E) - e), b * np.sin(E), -np.sqrt(a) * np.sin(E) / r, b / np.sqrt(a) * np.cos(E) / r])
    run = fa.integrate(fa.hamiltonian("-1/sqrt(x**2 + y**2)"), z0, time=float(time), accuracy=1e-12, scheme=scheme)
    true = np.abs(run.z - truth.astype(float)).max(axis=0)
    covered(true, run.error.max(axis=0))
    assert np.median(run.error.max(axis=0) / true) < most
    assert np.median(run.error) < 2e-10


@pytest.mark.parametrize("scheme", [fa.LEAPFROG, fa.KAHAN_LI8, fa.SOFRONIOU_SPALETTA10], ids=lambda s: s.name)
def test_errors_of_coarse_steps_of_named_schemes_cover_the_truth(scheme):
    """Regular and chaotic orbits of random potentials: 99 % are within, and none is ten times beyond."""
    rng, ratios = np.random.default_rng(33), []
    for _ in range(4):
        a, b, e, g = rng.uniform(0.5, 2, 2).tolist() + rng.uniform(0, 1, 2).tolist()
        V = "(a*x**2 + b*y**2)/2 + 0.3*x**2*y + e*(x**4 + y**4)/4 + g*x**2*y**2"
        model = fa.hamiltonian(V, coordinates="x y", a=a, b=b, e=e, g=g)
        z0, time = rng.uniform(-1, 1, (4, 200)), float(rng.choice([10.0, 50.0, 150.0]))
        truth = fa.integrate(model, z0, time=time, accuracy=1e-12)
        run = fa.integrate(model, z0, time=time, accuracy=1e-5, scheme=scheme)
        known = (truth.error < 0.02 * run.error).all(axis=0) & (run.status == 0)
        assert known.mean() > 0.9
        ratios.append((np.abs(run.z - truth.z) / run.error).max(axis=0)[known])
    covered(np.concatenate(ratios), 1.0)


def chaotic(which):
    """A model with chaotic orbits, its force (t, *q) in the arithmetic of q, and the start of 400 of them."""
    rng = np.random.default_rng(7)
    if which == "Henon-Heiles":
        section = fa.Hyperplane((1, 0, 0, 0))
        axes = (np.linspace(-0.4, 0.8, 40), np.linspace(-0.5, 0.5, 40))
        grid = fa.energy_grid(HH, energy=1 / 6.2, section=section, axes=axes).z0
        z0 = grid[:, rng.choice(grid.shape[1], 400, replace=False)]
        return HH, lambda t, x, y: (-x - 2 * x * y, -y - x * x + y * y), z0
    w = 1.25  # whose binary digits, and those of the amplitude, are all there are
    duffing = shared_systems.duffing(a=0.3125, w=w)
    force = lambda t, x: (x - x**3 + np.longdouble(0.3125) * np.cos(w * t),)  # noqa: E731
    return duffing, force, np.array([rng.uniform(-1, 1, 400), rng.uniform(-0.5, 0.5, 400)])


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="needs 80-bit floats")
@pytest.mark.parametrize(
    ("which", "time", "accuracies"),
    [("Henon-Heiles", 120.0, (1e-9,)), ("Henon-Heiles", 120.0, (1e-12,)), ("Duffing", 40.0, (1e-9, 1e-12))],
)
def test_rounding_of_chaotic_orbits(which, time, accuracies):
    """What two runs differ by may be small by chance, of a few orbits in a hundred: each has a second witness."""
    model, force, z0 = chaotic(which)
    n, steps, ten = len(z0) // 2, round(time / 0.05), fa.SOFRONIOU_SPALETTA10
    drifts, kicks = (np.longdouble(1) * np.array(c) * np.longdouble(time) / steps for c in (ten.drift, ten.kick))
    q, p, t = *np.split(z0.astype(np.longdouble), 2), np.longdouble(0)
    for _ in range(steps):
        for drift, kick in zip(drifts, (*kicks, 0.0)):
            q, t = q + drift * p, t + drift
            if kick:
                p = p + kick * np.array(force(t, *q))
    truth = np.concatenate([q, p])
    rows = [*range(n), *range(len(model.coordinates), len(model.coordinates) + n)]
    for accuracy in accuracies:
        run = fa.integrate(model, z0, time=time, accuracy=accuracy)
        covered(np.abs(run.z[rows] - truth).max(axis=0), run.error[rows].max(axis=0))


@pytest.mark.parametrize("unit", [1e-6, 1e6, 3.7e-4])
def test_units_origin_and_zero_change_nothing(unit):
    """Lengths in the unit, times in its inverse root: the same numbers to rounding, with the same steps."""
    rng = np.random.default_rng(8)
    time = unit**-0.5
    plain, K = chain(np.random.default_rng(3), 3)
    scaled, _ = chain(np.random.default_rng(3), 3, length=unit, time=time, constant=1000.0)
    z0 = rng.normal(size=(6, 50))
    factor = np.repeat([unit, unit / time], 3)[:, None]
    first, second = fa.integrate(plain, z0, time=40.0), fa.integrate(scaled, factor * z0, time=40.0 * time)
    np.testing.assert_allclose(second.z / factor, first.z, rtol=0, atol=1e-11)
    np.testing.assert_allclose(second.step / time, first.step, rtol=1e-9)
    assert (first.status == second.status).all()
    shifted, _ = chain(np.random.default_rng(3), 3, origin=5.0, constant=-3.0)
    moved = fa.integrate(shifted, z0 + np.repeat([5.0, 0.0], 3)[:, None], time=40.0)
    true = np.abs(moved.z - chain_at(K, z0 + np.repeat([5.0, 0.0], 3)[:, None], 40.0, 5.0)).max(axis=0)
    assert true.max() < 3e-10
    assert (moved.status == fa.Status.OK).all()


def test_starts_at_rest_where_V_is_zero_keep_their_energy():
    """No scale of the energy is to be had at the start: T = V = 0 there."""
    system = shared_systems.plane(1, 1, c=1, d=1, zero=-0.005)
    angle = np.linspace(0, 6, 40)
    z0 = np.zeros((4, 40))
    z0[:2] = 0.1 * np.cos(angle), 0.1 * np.sin(angle)
    run = fa.integrate(system, z0, time=100.0, step=0.1)
    assert (run.status == fa.Status.OK).all()
    assert run.energy_error.max() < 1e-8


def test_a_fast_orbit_among_slow_ones():
    """Harmonic motion in a quartic well: frequencies from 0.01 to 100 in one set, each with a step of its own."""
    system = shared_systems.plane(e=1, g=1)
    rng = np.random.default_rng(2)
    size = np.append(np.full(60, 0.01), 100.0)
    z0 = rng.normal(size=(4, 61)) * np.vstack([size, size, size**2, size**2])
    run = fa.integrate(system, z0, time=30.0)
    assert (run.status == fa.Status.OK).all()
    for i in (0, 17, 60):
        alone = fa.integrate(system, z0[:, i], time=30.0)
        assert np.array_equal(alone.z[:, 0], run.z[:, i])
        assert np.array_equal(alone.error[:, 0], run.error[:, i])
        assert alone.step[0] == run.step[i]
    some = rng.permutation(61)[:23]
    part = fa.poincare_map(
        system, z0[:, some], section=fa.Hyperplane((1.0, 0.0, 0.0, 0.0)), crossings=5, max_time=2000.0
    )
    whole = fa.poincare_map(system, z0, section=fa.Hyperplane((1.0, 0.0, 0.0, 0.0)), crossings=5, max_time=2000.0)
    assert np.array_equal(part.times, whole.times[:, some], equal_nan=True)
    assert np.array_equal(part.time_error, whole.time_error[:, some], equal_nan=True)


def test_motion_knows_oscillators():
    """The scales of an oscillator: omega to what some radians tell, the kinetic energy's largest value, the
    amplitudes.
    """
    omega, amplitude = 37.0, np.array([1e-5, 2.0, 300.0])
    system = shared_systems.well(k=omega**2)
    found = motion(system_of(system), np.array([amplitude, 0 * amplitude]))
    np.testing.assert_allclose(found.rate, omega, rtol=0.1)
    np.testing.assert_allclose(found.kinetic, (omega * amplitude) ** 2 / 2, rtol=0.05)
    np.testing.assert_allclose(found.position[0], amplitude, rtol=0.1)


@pytest.mark.parametrize("accuracy", [1e-5, None])
def test_errors_of_crossings_cover_the_truth(accuracy):
    """x = 0 of uncoupled oscillators, upward: all crossing times in closed form."""
    rng = np.random.default_rng(4)
    w = rng.uniform(0.5, 2.0, 2)
    system = shared_systems.oscillators(*w**2)
    z0 = rng.normal(size=(4, 100))
    cut = fa.poincare_map(
        system, z0, section=fa.Hyperplane((1.0, 0.0, 0.0, 0.0)), crossings=40, max_time=2000.0, accuracy=accuracy
    )
    first = (-np.arctan2(z0[0], z0[2] / w[0]) % (2 * np.pi)) / w[0]
    true = np.abs(cut.times - (first + 2 * np.pi / w[0] * np.arange(40)[:, None]))
    covered(true.ravel(), cut.time_error.ravel())
    assert true.max() < 10 * (accuracy or 1e-10)


@pytest.mark.parametrize("accuracy", [1e-9, 1e-12])
def test_crossings_next_to_a_separatrix(accuracy):
    """x = 0 of a pendulum from rest, upward: at 3 K + 4 K j."""
    rng = np.random.default_rng(9)
    d, y0 = 10 ** rng.uniform(-4, 0, 80), rng.uniform(0.2, 1.5, 80)
    x0 = np.pi - d
    with mpmath.workdps(30):
        quarter = np.array([float(mpmath.ellipk(mpmath.sin(mpmath.mpf(x) / 2) ** 2)) for x in x0])
    system, section = pendulum_and_oscillator(1.3), fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
    z0 = np.array([x0, y0, 0 * x0, 0 * x0])
    cut = fa.poincare_map(system, z0, section=section, crossings=8, max_time=1000.0, accuracy=accuracy)
    covered(np.abs(cut.times - quarter * (3 + 4 * np.arange(8)[:, None])), cut.time_error)


def henon_heiles_crossings(z0, time, h=0.25, order=24):
    """Times of x = 0, upward, by Taylor series in 80-bit numbers; halving h changes them by 3e-15."""
    long = np.longdouble
    state, found, h = [long(v) for v in z0], [], long(h)

    def at(c, t):
        value = c[-1]
        for a in c[-2::-1]:
            value = value * t + a
        return value

    for i in range(round(time / float(h))):
        x, y, px, py = (np.zeros(order + 1, long) for _ in range(4))
        x[0], y[0], px[0], py[0] = state
        for k in range(order):
            xy, xx, yy = ((a[: k + 1] * b[k::-1]).sum() for a, b in ((x, y), (x, x), (y, y)))
            x[k + 1], y[k + 1] = px[k] / (k + 1), py[k] / (k + 1)
            px[k + 1], py[k + 1] = (-x[k] - 2 * xy) / (k + 1), (-y[k] - (xx - yy)) / (k + 1)
        after = [at(c, h) for c in (x, y, px, py)]
        if state[0] < 0 <= after[0]:
            t = -h * state[0] / (after[0] - state[0])
            for _ in range(6):
                t -= at(x, t) / at(px, t)
            found.append(i * h + t)
        state = after
    return np.array(found, float)


@pytest.mark.slow
@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="needs 80-bit floats")
@pytest.mark.parametrize(
    "z0",
    [
        (0.0, 0.2587703282931232, -0.2525875586263492, -0.2178423952983717),
        (0.0, -0.11, 0.31, 0.17),
        (0.1, 0.21, 0.05, -0.23),
    ],
)
def test_crossings_of_one_orbit_over_long_times(z0):
    truth = henon_heiles_crossings(z0, 2000.0)
    cut = fa.poincare_map(HH, z0, section=fa.Hyperplane((1.0, 0.0, 0.0, 0.0)), crossings=1000, max_time=2000.0)
    assert cut.counts[0] == len(truth)
    true = np.abs(cut.times[: len(truth), 0] - truth)
    assert (true[truth <= cut.accurate_until[0]] < 1e-10).all()
    assert true.max() < (1e-10 if z0[0] == 0.0 and z0[1] > 0 else 3e-10)  # crossings that graze feel rounding most
    covered(true, cut.time_error[: len(truth), 0])


def test_chaos_ends_the_accuracy_in_time():
    """At E = 1/6.5 most orbits are chaotic: the error estimate grows and the result says until when it holds."""
    rng = np.random.default_rng(6)
    z0 = np.zeros((4, 30))
    z0[1], z0[3] = rng.uniform(-0.2, 0.4, 30), rng.uniform(-0.1, 0.1, 30)
    z0[2] = np.sqrt(2 * (1 / 6.5) - z0[3] ** 2 - z0[1] ** 2 + 2 * z0[1] ** 3 / 3)
    run = fa.integrate(HH, z0, time=400.0, samples=80)
    fine = fa.integrate(HH, z0, time=400.0, samples=80, step=0.02, scheme=fa.SOFRONIOU_SPALETTA10)
    apart = np.abs(run.samples - fine.samples).max(axis=1)
    assert (run.accurate_until < 400).any()
    assert (apart[run.times[:, None] <= run.accurate_until] < 1e-9).all()


@pytest.mark.parametrize("which", ["plane", "body"])
def test_an_answer_with_an_error_costs_few_plain_runs(which, monkeypatch):
    """Steps of all runs beside those of the run that is handed over, trials and looks left out, of chaotic orbits too,
    whose crossings graze the section.
    """
    if which == "body":
        body, section = fa.Body(fa.Hyperelastic(1.0)), fa.AlphaTurning(+1)
        z0 = np.array([1.5, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0])[:, None] + 0.1 * np.random.default_rng(1).normal(
            size=(8, 128)
        )
    else:
        body, section, (_, _, z0) = HH, fa.Hyperplane((1, 0, 0, 0)), chaotic("Henon-Heiles")
    made, own = [], poincare_module.crossed

    def counted(*asked, **more):
        part, reached = own(*asked, **more)
        made.append(float((np.nanmax(part.times, axis=0) / part.step).sum()))
        return part, reached

    monkeypatch.setattr(poincare_module, "crossed", counted)
    cut = fa.poincare_map(body, z0, section=section, crossings=60, max_time=1000.0)
    plain = float((np.nanmax(cut.times, axis=0) / cut.step).sum())
    assert 1.5 < sum(made) / plain < 2.3
    assert (cut.status == fa.Status.OK).all()


def test_a_run_beside_another_ends_where_they_have_parted_and_changes_nothing(monkeypatch):
    """Chaotic orbits: errors, and all else, have the same bits where it runs on to the end."""
    _, _, z0 = chaotic("Henon-Heiles")
    taken, own = [], poincare_module.crossed

    def counted(*asked, **more):
        part, reached = own(*asked, **more)
        taken.append(np.nan_to_num(part.times).max(axis=0).sum())
        return part, reached

    monkeypatch.setattr(poincare_module, "crossed", counted)
    run = {"section": fa.Hyperplane((1, 0, 0, 0)), "crossings": 120, "max_time": 1500.0, "accuracy": 1e-8}
    cut, short = fa.poincare_map(HH, z0[:, ::4], **run), sum(taken)
    taken.clear()
    monkeypatch.setattr(poincare_module, "PARTED", np.inf)
    whole = fa.poincare_map(HH, z0[:, ::4], **run)
    assert short < 0.9 * sum(taken)
    for name in ("points", "times", "time_error", "point_error", "accurate_until", "status", "step", "energy_error"):
        np.testing.assert_array_equal(getattr(cut, name), getattr(whole, name), err_msg=name)
    assert np.isinf(cut.time_error).any()


@given(
    step=st.floats(1e-9, 1e9), time=st.floats(1e-6, 1e6), parts=st.sampled_from([1, 2, 32]), steps=st.integers(1, 10**9)
)
def test_numbers_of_steps_lie_on_a_ladder(step, time, parts, steps):
    """They are four to eight times a power of two, or below eight, and the first ones that are enough."""
    for asked, least in ((step, time / (parts * step)), (time / (parts * steps), steps)):
        found = time / (parts * round_down_to_grid(np.array([asked]), time, parts)[0])
        number = round(found)
        assert abs(found - number) <= 1e-9 * number
        assert number >= least * (1 - 1e-9)
        unit = max(1, 2 ** (number.bit_length() - 3))
        assert number % unit == 0
        below = number - (unit if number > 4 * unit else max(1, unit // 2))
        assert below < max(least, 1.0)


def test_steps_are_shortened_by_what_should_do():
    """SLIGHTLY where the order says that it is enough, else halved; not where rounding or chaos is what is left."""
    flow = plan(HH, np.full((4, 7), 0.1), Options(step=0.1, scheme=fa.SOFRONIOU_SPALETTA10)).flow
    flow = flow.sized(np.full(7, 0.1))
    each = np.ones(7)
    steps = Steps(0.1 * each, each, 10 * each, motion(system_of(HH), np.full((4, 7), 0.1)), 2 * each, 100.0, 2)
    error = 1e-10 * np.array([[0.9, 3.0, 900.0, 3.0, 1.2, 1e4, np.inf]])
    rounding = 1e-10 * np.array([[0.1, 0.1, 0.1, 2.8, 0.69, 0.1, 0.1]])
    factor = shortening(flow, steps, error, rounding, 1e-10)
    np.testing.assert_array_equal(factor, [1.0, SLIGHTLY, 2.0, 1.0, SLIGHTLY, 1.0, 1.0])
    shorter = steps.shortened(np.where(factor > 1, factor, 2.0))
    np.testing.assert_allclose(steps.step / shorter.step, shorter.ratio)
    assert (shorter.ratio >= factor * (1 - 1e-12)).all()
    parts = 100.0 / (2 * shorter.step)
    np.testing.assert_allclose(parts, np.rint(parts), rtol=1e-12)


@pytest.mark.parametrize(
    ("problem", "options", "says"),
    [
        (ValueError, {"accuracy": 1e-9, "step": 0.1}, "accuracy and step"),
        (ValueError, {"accuracy": -1e-9}, "accuracy"),
        (ValueError, {"accuracy": 2.0}, "accuracy"),
        (TypeError, {"accuracy": "high"}, "accuracy"),
        (ValueError, {"accuracy": 1e-9, "scheme": fa.DOP853}, "accuracy"),
        (ValueError, {"step": np.inf}, "step"),
        (ValueError, {"step": np.full(3, 0.1)}, "step"),
        (ValueError, {"step": -np.ones(4)}, "step"),
    ],
)
def test_wrong_input_is_named(problem, options, says):
    with pytest.raises(problem, match=says):
        fa.integrate(HH, np.full((4, 4), 0.1), time=1.0, **options)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 2e-19, reason="needs 80-bit floats")
@pytest.mark.parametrize("time", [1000.0, 3333.3])
def test_the_rounding_of_the_step_is_an_error(time):
    """All steps are too long or too short by the same part: the phase of an oscillator is off by that of the time."""
    body = fa.Body(fa.Harmonic(C=1.0), mu=1.0)
    z0 = np.random.default_rng(2).uniform(-0.9, 0.9, (8, 64))
    q, p = np.split(z0.astype(np.longdouble), 2)
    w = np.sqrt(np.longdouble(body.potential.C) / np.longdouble(body.mu))
    c, s = np.cos(w * np.longdouble(time)), np.sin(w * np.longdouble(time))
    run = fa.integrate(body, z0, time=time, accuracy=1e-13)
    ratio = np.abs(run.z - np.concatenate([q * c + p * s / w, p * c - w * q * s])) / run.error
    assert (ratio <= 1).mean() >= 0.99
    assert ratio.max() < 2


@pytest.mark.parametrize(
    ("model", "middle", "section"),
    [
        (fa.HenonHeiles(), np.zeros(4), "x=0"),
        (fa.Body(fa.NeoHookean()), np.array([1.5, 0, 0.3, 0, 0, 0, 0, 0]), fa.AlphaTurning()),
        (
            fa.hamiltonian("-cos(x) - f*x*cos(t)", coordinates="x", f=0.3, drive_period="2*pi"),
            np.zeros(2),
            Stroboscopic(),
        ),
    ],
    ids=["Hénon-Heiles", "neo-Hookean", "driven"],
)
def test_few_orbits_have_the_same_bits_as_many(model, middle, section, monkeypatch):
    """Both runs of few are one; those of many are apart, and the second ends where it has parted from the first."""
    z0 = middle[:, None] + 0.3 * np.random.default_rng(9).standard_normal((middle.size, 6))
    limit = {} if isinstance(section, Stroboscopic) else {"max_time": 400.0}

    def found():
        orbits = fa.integrate(model, z0, time=50.0)
        points = fa.poincare_map(model, z0, section=section, crossings=20, **limit)
        return *(orbits[name] for name in ("z", "error", "accurate_until", "status", "step")), *(
            points[name]
            for name in ("points", "times", "point_error", "accurate_until", "energy_error", "status", "step")
        )

    few = found()
    monkeypatch.setattr(accuracy_module, "FEW", 0)
    for one, other in zip(few, found(), strict=True):
        np.testing.assert_array_equal(one, other)
