"""Independent frequencies of any system: chains against eigenvalues, pendulums against elliptic integrals, tori; errors
that cover.
"""

import itertools
import math

import numpy as np
import pytest
import shared_systems
from hypothesis import given, settings
from hypothesis.strategies import floats
from naive import frequencies, states

import fastaff as fa
from fastaff import (
    DOP853,
    LEAPFROG,
    MEGNO,
    SALI,
    Anharmonic,
    Body,
    FrequencyDiffusion,
    Harmonic,
    HenonHeiles,
    chaos_map,
    fit_torus,
    frequency_map,
    hamiltonian,
    naff,
    resonances,
    rotation_number,
)
from fastaff.engine.plane_loops import angle_of


def chain(n, seed):
    """A linear system of random couplings and masses, and its frequencies."""
    rng = np.random.default_rng(seed)
    M = rng.normal(size=(n, n))
    K, mass = M @ M.T / n + 0.15 * np.eye(n), rng.uniform(0.5, 2.0, n)
    root = np.sqrt(mass)
    return shared_systems.springs(K, tuple(mass)), np.sqrt(np.linalg.eigvalsh(K / np.outer(root, root))) / (2 * np.pi)


@pytest.mark.parametrize("n", [2, 3, pytest.param(4, marks=pytest.mark.slow), pytest.param(6, marks=pytest.mark.slow)])
def test_all_frequencies_of_a_linear_chain(n):
    model, truth = chain(n, 10 + n)
    z0 = np.random.default_rng(n).normal(size=(2 * n, 40))
    f = frequency_map(model, z0, time=300 / truth.mean())
    error = np.abs(np.sort(f.nu, axis=0) - truth[:, None])
    assert (error.max(axis=0) < 1e-11).mean() >= 0.99
    assert (error <= f.error).mean() >= 0.99
    assert (f.rank == n).mean() >= 0.99
    assert (f.classification == fa.Classification.REGULAR).mean() >= 0.99
    # one coordinate, one mode: the same for all orbits, whatever their amplitudes
    whole = f.nu[:, f.rank == n]
    np.testing.assert_allclose(whole, np.repeat(whole[:, :1], whole.shape[1], axis=1), atol=1e-11)
    # the dominant line of each coordinate is what the integers say
    known = (f.basis != 0).any(axis=1)
    through = np.einsum("ijo,jo->io", f.basis, f.nu)
    assert known.all()
    np.testing.assert_allclose(through[known], f.dominant[known], atol=1e-7)
    if n <= 4:
        assert (resonances(f).rank == 0).mean() >= 0.99


def test_resonant_orbits_say_that_their_basis_is_another():
    """Near 1 : 2, systems and orbits at random: nu are the lines of x and y, or the summary counts the orbit as of
    another basis, whose integers lead back to these lines.
    """
    rng = np.random.default_rng(13)
    spring = "(w*w*x**2 + y**2)/2 + e*x*y**2"
    seen = 0
    for _ in range(12):
        model = hamiltonian(spring, w=rng.uniform(1.95, 2.05), e=rng.uniform(0.03, 0.4))
        f = frequency_map(model, rng.uniform(-0.3, 0.3, (4, 20)), time=600.0)
        through = np.einsum("ijo,jo->io", f.basis, f.nu)
        slack = f.dominant_error + np.einsum("ijo,jo->io", np.abs(f.basis), np.where(np.isfinite(f.error), f.error, 0))
        known = f.basis.any(axis=1) & f.regular
        assert (np.abs(through - f.dominant) <= slack)[known].all()
        off = (known & (np.abs(f.nu - f.dominant) > f.error + f.dominant_error)).any(axis=0)
        assert not (off & ~f.other_basis).any()
        assert f"{f.other_basis.sum()} with frequencies other" in f.summary() or not f.other_basis.any()
        seen += off.sum()
    assert 3 < seen < 220


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5, 1e-7, 1e-9, 1e-12])
def test_the_accuracy_asked_for_is_reached(accuracy):
    """Steps as long as it allows; what the time leaves is below 1e-12 here: few lines, far apart."""
    model, truth = chain(2, 40 + int(-np.log10(accuracy)))
    z0 = 7.0 * np.random.default_rng(8).normal(size=(4, 40))
    options = {"time": 400 / truth.min(), "accuracy": accuracy, "energy_tolerance": 1.0}
    f = frequency_map(model, z0, **options)
    assert f.regular.all(), f.summary()
    assert frequency_map(model, z0[:, :9], **(options | {"energy_tolerance": 1e-6})).regular.all()
    # Of a weak mode rounding errors are seen at 1e-12.
    assert (f.error <= 1.1 * accuracy * f.nu.max(axis=0)).mean() >= 0.99
    assert (np.abs(np.sort(f.nu, axis=0) - truth[:, None]) <= f.error).mean() >= 0.99
    finer = frequency_map(model, z0, **(options | {"accuracy": accuracy / 100}))
    assert (finer.step <= f.step).all()
    if accuracy < 1e-3:  # where the steps are not those that resolve the fast mode
        assert finer.step.mean() < 0.95 * f.step.mean()
    alone = frequency_map(model, z0[:, 17], **options)
    np.testing.assert_array_equal(alone.nu[:, 0], f.nu[:, 17])
    assert alone.step[0] == f.step[17]


@pytest.mark.parametrize("scheme", [fa.BLANES_MOAN6, fa.schemes.BLANES_CASAS_ESCORIHUELA8, fa.KAHAN_LI8])
@pytest.mark.parametrize("seed", [46, 48, 55])
def test_long_steps_show_no_other_frequency_of_a_weak_fast_mode(scheme, seed):
    """Frequencies from 2.7 to 6.9 apart: steps for an error of 1e-3 of the slow mode would not resolve the fast one."""
    model, truth = chain(2, seed)
    z0 = 7.0 * np.random.default_rng(seed - 40).normal(size=(4, 40))
    for options in ({"accuracy": 1e-3}, {"step": 3.0 / (2 * np.pi * truth.max())}):
        f = frequency_map(model, z0, time=400 / truth.min(), energy_tolerance=1.0, scheme=scheme, **options)
        order = np.argsort(f.nu, axis=0)
        nu, error = (np.take_along_axis(a, order, axis=0) for a in (f.nu, f.error))
        assert (np.abs(nu - truth[:, None]) <= error).all()
        assert (2 * np.pi * truth.max() * f.step < 1.6).all()


def test_steps_are_halved_where_the_trial_was_too_hopeful():
    """A spring that stiffens late: the trial sees 16 radians of soft motion only."""
    model = hamiltonian("(x**2 + 1.7*y**2)/2 + 0.8*exp(6*(x + y - 1.2))")
    z0 = np.random.default_rng(2).uniform(-0.6, 0.6, (4, 90))
    f = frequency_map(model, z0, time=400.0, accuracy=1e-9)
    fine = frequency_map(model, z0, time=400.0, step=0.01)
    both = (
        f.regular
        & fine.regular
        & (f.classification == fa.Classification.REGULAR)
        & (fine.classification == fa.Classification.REGULAR)
    )
    assert both.sum() > 10
    assert (np.abs(f.nu - fine.nu) <= f.error + fine.error)[:, both].mean() >= 0.99


@pytest.mark.parametrize(
    ("problem", "options", "says"),
    [
        (ValueError, {"accuracy": 1e-9, "step": 0.1}, "accuracy and step"),
        (ValueError, {"accuracy": 0.0}, "accuracy must be positive"),
        (ValueError, {"accuracy": 2.0}, "accuracy must be below 1"),
        (TypeError, {"accuracy": "high"}, "accuracy"),
        (
            ValueError,
            {"accuracy": 1e-9, "scheme": fa.DOP853},
            "accuracy must be None with the adaptive method DOP853",
        ),
    ],
)
def test_wrong_accuracies_are_named(problem, options, says):
    with pytest.raises(problem, match=says):
        frequency_map(HenonHeiles(), np.full((4, 2), 0.1), time=100.0, **options)


def test_a_mode_at_rest_and_a_free_one_are_said():
    K = np.array([[2.4, -1.4], [-1.4, 3.7]])
    model = shared_systems.springs(2 * K, (2.0, 2.0))
    omega2, modes = np.linalg.eigh(K)
    single = np.concatenate([0.8 * modes[:, 1], 0.3 * modes[:, 1]])
    f = frequency_map(model, single, time=600.0)
    np.testing.assert_allclose(f.nu[:, 0], np.sqrt(omega2[1]) / (2 * np.pi), atol=1e-11)
    assert f.rank[0] == 1
    assert f.classification[0] == fa.Classification.RESONANT
    chain = np.array([[1, -1, 0], [-1, 1.8, -0.8], [0, -0.8, 0.8]])
    free = frequency_map(
        shared_systems.springs(2 * chain, (2.0, 2.0, 2.0)), [0.3, -0.5, 1.1, 1.8, 0.4, -0.2], time=900.0
    )
    assert free.rank[0] == 2
    truth = np.sqrt(np.linalg.eigvalsh(chain)[1:]) / (2 * np.pi)
    np.testing.assert_allclose(np.unique(np.round(free.nu[free.error < 1e-9], 9)), np.round(truth, 9), atol=2e-9)
    resting = frequency_map(HenonHeiles(), np.array([0.0, 0.2, 0.0, 0.1]), time=400.0)
    assert resting.rank[0] == 1
    assert resting.error[0, 0] == np.inf
    assert resting.error[1, 0] < 1e-9


def elliptic_k(m):
    a, b = 1.0, np.sqrt(1 - m)
    for _ in range(40):
        a, b = (a + b) / 2, np.sqrt(a * b)
    return np.pi / (2 * a)


def test_a_pendulum_over_the_top():
    """nu = sqrt(E + 1)/(sqrt(8) K(2/(E + 1))) for V = -cos x: to either side, and librations of the same map."""
    model = hamiltonian("-cos(x)", coordinates="x")
    p = np.array([2.02, 2.3, -2.3, 3.7, 1.3])
    E = p**2 / 2 - 1
    over = np.sqrt(np.maximum(E + 1, 0) / 2) / (2 * elliptic_k(2 / np.maximum(E + 1, 2.001)))
    truth = np.where(np.abs(p) > 2, over, 1 / (4 * elliptic_k(np.minimum((E + 1) / 2, 0.9))))
    f = frequency_map(model, np.array([np.full(5, 0.4) * 0, p]), time=900.0)
    assert (np.abs(f.nu[0] - truth) <= f.error[0]).all()
    assert (np.abs(f.nu[0] - truth) < 1e-8).all()


@pytest.mark.parametrize("time", [700.0, 1e4])
def test_lines_are_never_aliases(time):
    """Samples as many as the time asks for."""
    body = Body(Harmonic(1.0), 1.0)
    f = frequency_map(body, states(body, 2, 3), time=time, step=0.2)
    np.testing.assert_allclose(f.nu[:2], 1 / np.pi, atol=1e-9)


# --- errors ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "periods"),
    [
        ({}, 200),
        ({"step": 0.25}, 200),
        ({"step": 0.1, "scheme": LEAPFROG}, 60),
        ({"step": 0.2}, 10),
        ({"scheme": DOP853, "rtol": 1e-10}, 60),
    ],
    ids=["chosen steps", "coarse steps", "leapfrog", "short", "adaptive"],
)
def test_errors_cover(options, periods):
    body = Body(Anharmonic(0.57), 1.21)
    z0 = states(body, 40, 31)
    truth = frequencies(body, z0)
    f = frequency_map(body, z0, time=periods / truth[0].mean(), energy_tolerance=1.0, **options)
    error = np.abs(np.array([*f.nu[:2], f.nu_eta, f.nu_gamma]) - truth)
    estimate = np.array([*f.error[:2], 2 * f.error[2], 2 * f.error[2]])
    assert (error <= estimate).mean() >= 0.99
    assert (error / estimate).max() < 10


def test_a_window_of_one_period_does_not_converge_by_chance():
    """Both halves of 2 pi hold one dilatation: they agree whatever the frequency of the other libration."""
    body = Body(Anharmonic(1.0), 1.0)
    z0 = states(body, 30, 8)
    f = frequency_map(body, z0, time=2 * np.pi, step=0.05)
    assert (np.abs(f.nu[:2] - frequencies(body, z0)[:2]) <= f.error[:2]).all()
    assert (f.classification == fa.Classification.UNDECIDED).all()


def curves(orbits, crossings, seed):
    """Points of smooth closed curves on which a circle map turns by `rotation`."""
    rng = np.random.default_rng(seed)
    rotation = rng.uniform(-0.45, 0.45, orbits)
    theta = 2 * np.pi * (rotation * np.arange(crossings)[:, None] + rng.random(orbits))
    amplitude = rng.uniform(0, 0.25, orbits)
    turned = theta + amplitude * np.sin(theta) + 0.3 * amplitude * np.sin(2 * theta)
    radius = 1 + rng.uniform(0, 0.2, orbits) * np.cos(theta)
    return rotation, np.array([radius * np.cos(turned), 0.7 * radius * np.sin(turned)])


@pytest.mark.parametrize("crossings", [60, 200, 900])
def test_errors_of_rotation_numbers_cover(crossings):
    rotation, points = curves(300, crossings, crossings)
    found = rotation_number(points, centre=(0.0, 0.0))
    ratio = np.abs(found.rotation - rotation) / found.error
    assert (ratio <= 1).mean() >= 0.99
    assert ratio.max() < 10


@settings(max_examples=200)
@given(x=floats(-1e100, 1e100), y=floats(-1e100, 1e100))
def test_angles_without_branches(x, y):
    truth = math.atan2(y, x) if y else math.pi * (x < 0)  # of the two arguments of negative numbers the positive one
    assert angle_of(x, y) == pytest.approx(truth, rel=4e-16, abs=4e-16)


def test_angles_around_the_circle():
    angle = np.concatenate([np.linspace(-np.pi, np.pi, 20001), np.geomspace(1e-300, 1.0, 1000)])
    got = np.array([angle_of(x, y) for x, y in zip(np.cos(angle), np.sin(angle))])
    np.testing.assert_allclose(got, np.arctan2(np.sin(angle), np.cos(angle)), rtol=4e-16, atol=4e-16)


# --- nonlinear systems ----------------------------------------------------------------------------------------------


def bound(energy, orbits, seed):
    """Random orbits of Henon and Heiles's system at an energy."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < orbits:
        x, y = rng.uniform(-0.7, 0.7, 2)
        T = energy - ((x * x + y * y) / 2 + x * x * y - y**3 / 3)
        if T > 0 and x * x + y * y < 1:
            angle = rng.uniform(0, 2 * np.pi)
            found.append([x, y, np.sqrt(2 * T) * np.cos(angle), np.sqrt(2 * T) * np.sin(angle)])
    return np.array(found).T


def unimodular(nu, other, reach=4):
    """How near other comes to M nu with an integer matrix M of determinant +-1."""
    k = np.array(list(itertools.product(range(-reach, reach + 1), repeat=2)))
    rows = [k[np.argsort(np.abs(k @ nu - value))[:3]] for value in other]
    return min(
        max(abs(a @ nu - other[0]), abs(b @ nu - other[1]))
        for a in rows[0]
        for b in rows[1]
        if abs(round(a[0] * b[1] - a[1] * b[0])) == 1
    )


def test_regular_orbits_have_the_lattice_of_their_torus():
    z0 = bound(1 / 30, 4, 2)
    f = frequency_map(HenonHeiles(), z0, time=4000.0)
    assert (f.classification == fa.Classification.REGULAR).all()
    assert (resonances(f).rank == 0).all()
    checked = 0
    for i in range(4):
        torus = fit_torus(HenonHeiles(), z0[:, i], time=4000.0)
        if np.size(torus.nu) == 2 and np.isfinite(torus.nu).all():
            assert unimodular(f.nu[:, i], np.ravel(torus.nu)) < 1e-8
            checked += 1
    assert checked >= 3


@pytest.mark.slow
@pytest.mark.parametrize(("energy", "orbits"), [(1 / 24, 400), (0.1, 400), (0.14, 200)])
def test_diffusion_agrees_with_tangent_vectors(energy, orbits):
    """Of those that all three decide, in 950 natural periods."""
    z0 = bound(energy, orbits, 6)
    found = chaos_map(HenonHeiles(), z0, time=6000.0, indicators=(SALI(), MEGNO(), FrequencyDiffusion()))
    sali, megno, diffusion = found.classifications
    told = (found.classifications != fa.Classification.UNDECIDED).all(axis=0) & (sali == megno)
    assert told.mean() > 0.3
    assert (diffusion == sali)[told].mean() >= 0.97  # a tenth of the 40 weakly chaotic orbits sticks to islands


def test_units_origin_and_zero_of_energy():
    """The same orbits in other units have the same frequencies in these, and the same kinds."""
    z0 = bound(0.09, 12, 9)
    f = frequency_map(HenonHeiles(), z0, time=1500.0, step=0.1)
    for length, duration in ((1e6, 1e-6), (1e-6, 1e6)):
        a, b = 1 / duration**2, 1 / (length * duration**2)
        model = shared_systems.plane(a, a, c=b, d=b, zero=1e3 * a * length**2)
        scaled = z0 * np.repeat([length, length / duration], 2)[:, None]
        other = frequency_map(model, scaled, time=1500.0 * duration, step=0.1 * duration)
        np.testing.assert_array_equal(other.classification, f.classification)
        sound = f.error < 1e-9
        np.testing.assert_allclose((other.nu * duration)[sound], f.nu[sound], atol=1e-10)


def test_signals_as_large_as_numbers_can_be():
    """Moduli beyond the largest number, of finite real and imaginary parts."""
    rng = np.random.default_rng(4)
    top = np.finfo(float).max
    signs = np.sign(rng.normal(size=(3, 200)))
    for signal in (np.full(200, top * (1 + 1j)), top * signs * (1 + 1j), top * np.ones((2, 300))):
        found = naff(signal, 1.0, lines=5)
        assert np.isfinite(found.nu).all()
    found = naff(0.9 * top * np.exp(2j * np.pi * 0.1713 * np.arange(400)), 1.0, lines=1)
    assert abs(found.nu[0] - 0.1713) < 1e-12


def test_lines_too_close_to_tell_are_undecided_and_their_errors_know():
    # Foucault's pendulum and two coupled oscillators, which are linear: 2e-3 to 0.6 cycles between their lines.
    rng = np.random.default_rng(6)
    z = rng.normal(size=(4, 16))
    for split, time in ((1e-3, 400.0), (1e-5, 1000.0), (1e-2, 200.0)):
        turning = fa.hamiltonian("w**2*(x**2 + y**2)/2", rotation=split, w=1.7)
        coupled = shared_systems.plane(1, 1, ab=split)
        for model, exact in ((turning, [1.7 - split, 1.7 + split]), (coupled, np.sqrt([1 - split, 1 + split]))):
            found = fa.frequency_map(model, z, time=time)
            off = np.abs(found.nu[:, None] - np.array(exact)[:, None] / (2 * np.pi)).min(axis=1)
            assert (found.classification == fa.Classification.IRREGULAR).sum() <= 1  # where the beat goes through zero
            assert (found.classification == fa.Classification.RESONANT).sum() <= 1  # where one mode is weak
            assert np.all(off <= 10 * found.error)
            assert (off <= found.error).mean() > 0.9
            assert np.all(found.error[:, found.classification == fa.Classification.UNDECIDED].max(axis=0) * time >= 1)
    apart = fa.frequency_map(shared_systems.oscillators(b=(1 + 1e-5) ** 2), z, time=1000.0)  # each has one exact line
    assert np.abs(apart.omega - [[1.0], [1 + 1e-5]]).max() < 1e-11


def librating(rng, orbits, time, samples):
    """Samples (4, orbits, samples) of two oscillators of one mean frequency whose phases librate about one another, by
    up to 1 cycle in that time, fastest in its middle; that frequency and that of the libration (orbits,).
    """
    t = (np.arange(samples) + 1) * time / samples
    size = rng.uniform(1.5, 3.1, (orbits, 1))
    slow = 2 * np.pi * 10 ** rng.uniform(-3.3, -0.02, (orbits, 1)) / (size * time)
    apart = size * np.sin(slow * (t - time / 2) + rng.choice([0, 0.3], (orbits, 1)) * rng.normal(size=(orbits, 1)))
    mean = rng.uniform(0.2, 0.4, (orbits, 1))
    one, other = (2 * np.pi * mean * t + half + rng.uniform(0, 6, (orbits, 1)) for half in (apart / 2, -apart / 2))
    b = rng.uniform(0.2, 2, (orbits, 1))
    signals = np.array([np.cos(one), b * np.cos(other), -np.sin(one), -b * np.sin(other)])
    return signals, mean[:, 0], slow[:, 0] / (2 * np.pi)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_slow_libration_is_not_taken_for_two_frequencies(seed):
    """Where it is fastest it looks like two steady lines: only its curvature tells, and errors reach the true lines."""
    signals, mean, slow = librating(np.random.default_rng(seed), 120, 400.0, 2000)
    found = fa.orbit_frequencies(signals, 0.2)
    assert (found.classification == fa.Classification.UNDECIDED).all()
    off = np.abs(found.nu - mean)
    assert (np.abs(off - np.rint(off / slow) * slow) <= found.error).all()


def test_orbits_of_integrable_systems_are_hardly_ever_irregular_in_short_times():
    """Toda's chain, Garnier's system and the quartic one of coefficients 1 : 12 : 16, of numbers drawn at random."""
    rng = np.random.default_rng(5)
    wrong = orbits = 0
    for turns in (35, 60, 150):
        a, b, c = rng.uniform(0.5, 2.0, 3)
        toda = fa.hamiltonian("a*exp(x) + b*exp(y - x) + c*exp(-y)", a=a, b=b, c=c)
        garnier = shared_systems.plane(a, b, e=1, f=1, g=1)
        quartic = shared_systems.plane(a, 4 * a, e=1, f=6, g=16)
        for model, rate in ((toda, 0.3 * b**0.5), (garnier, 0.2 * min(a, b) ** 0.5), (quartic, 0.2)):
            found = fa.frequency_map(model, 0.8 * rng.normal(size=(4, 200)), time=turns / rate)
            orbits += np.sum(found.status == fa.Status.OK)
            wrong += np.sum(found.classification == fa.Classification.IRREGULAR)
    assert orbits == 1800
    assert wrong <= 2, wrong
