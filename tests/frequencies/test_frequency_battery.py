"""Frequencies of systems drawn at random whose truth is known: weak lines, nearly circular orbits, angles that
circulate, orbits next to separatrices, and short runs of dense spectra.
"""

import itertools

import numpy as np
import pytest
import shared_systems
from scipy.special import ellipkm1

import fastaff as fa
from fastaff import Classification


def misses(nu, error, true, reach=4):
    """The least, over unimodular M, of the largest |nu - M true|/error of rows, for each orbit."""
    n = len(nu)
    k = np.array(list(itertools.product(range(-reach, reach + 1), repeat=n)))
    result = np.full(nu.shape[1], np.inf)
    for o in range(nu.shape[1]):
        off = np.abs(nu[:, o] - (k @ true[:, o])[:, None]) / (error[:, o] + 1e-13 * np.abs(true[:, o]).max())
        best = np.argsort(off, axis=0)[:12].T
        for rows in itertools.product(*best):
            if abs(round(np.linalg.det(k[list(rows)]))) == 1:
                result[o] = min(result[o], off[list(rows), range(n)].max())
    return result


def turned(n, rng, ratio):
    """Springs of frequencies at random seen from axes at random, and orbits whose second and third modes have these
    ratios (orbits,) to the first one's amplitude: the model, starts and true frequencies.
    """
    while True:
        w = np.sort(rng.uniform(1.0, 3.0, n))
        k = np.array(list(itertools.product(range(-4, 5), repeat=n)))
        if np.abs(k @ w)[(k != 0).any(axis=1)].min() > 0.02:
            break
    w, axes = rng.permutation(w), np.linalg.qr(rng.standard_normal((n, n)))[0]
    phase, size = rng.uniform(0, 2 * np.pi, (n, ratio.size)), np.ones((n, ratio.size))
    size[1:] = ratio
    z0 = np.concatenate([axes @ (size * np.cos(phase)), axes @ (-w[:, None] * size * np.sin(phase))])
    return shared_systems.springs((axes * w**2) @ axes.T, (1.0,) * n), z0, np.tile(w[:, None] / (2 * np.pi), ratio.size)


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("time", [1000.0, 10000.0])
def test_weak_lines_are_frequencies(n, time):
    rng = np.random.default_rng(n)
    found = dependent = 0
    for _ in range(4):
        ratio = 10 ** rng.uniform(-8, -1, 10)
        model, z0, true = turned(n, rng, ratio)
        f = fa.frequency_map(model, z0, time=time)
        own = f.classification == Classification.REGULAR
        assert (misses(f.nu[:, own], f.error[:, own], true[:, own]) <= 1).all()
        assert (f.error[:, own] * time < 0.1).all()
        assert (fa.resonances(f).rank[own] == 0).all()
        dependent += np.sum(f.classification == Classification.RESONANT)
        found += own.sum()
    assert dependent == 0
    assert found >= 32


@pytest.mark.parametrize("ratio", [(1, 1), (2, 1), (3, 2)])
def test_harmonics_do_not_stand_for_a_line_hidden_beside_another(ratio):
    """Two oscillators with harmonics, seen from axes at random, up to a cycle from a resonance: the lattice of lines
    that peaks show may be a part of theirs.
    """
    rng = np.random.default_rng(ratio)
    orbits, time, samples = 150, 400.0, 1600
    t = (np.arange(samples) + 1) * time / samples
    cycles = 10 ** rng.uniform(-2.5, 0, orbits) * rng.choice([-1, 1], orbits)
    nu = rng.uniform(0.2, 0.3, orbits)
    true = np.array([nu, (ratio[1] * nu + cycles / time) / ratio[0]])
    modes = np.zeros((2, orbits, samples), complex)
    for i in range(2):
        phase = 2 * np.pi * (true[i][:, None] * t + rng.random((orbits, 1)))
        sizes = rng.uniform(0.3, 1, (orbits, 1)), rng.uniform(0, 0.3, (orbits, 1)), rng.uniform(0, 0.1, (orbits, 1))
        modes[i] = sum(size * np.exp(-1j * ((k + 1) * phase + k)) for k, size in enumerate(sizes))
    axis = rng.uniform(0, np.pi, (orbits, 1))
    x, y = np.cos(axis) * modes[0] - np.sin(axis) * modes[1], np.sin(axis) * modes[0] + np.cos(axis) * modes[1]
    found = fa.orbit_frequencies(np.array([x.real, y.real, x.imag, y.imag]), time / samples)
    own = found.classification == Classification.REGULAR
    assert own.sum() > 20
    assert (misses(found.nu[:, own], found.error[:, own], true[:, own]) <= 1).all()
    assert not (found.classification == Classification.IRREGULAR).any()


def test_two_modes_of_a_turned_oscillator():
    g = 1.618033988749895
    turned = shared_systems.plane((1 + g**2) / 2, (1 + g**2) / 2, ab=(1 - g**2) / 2)
    weak = 1e-3
    for time in (1000.0, 10000.0):
        f = fa.frequency_map(turned, np.sqrt(0.5) * np.array([1 + weak, 1 - weak, 0.0, 0.0]), time=time)
        np.testing.assert_allclose(f.omega[:, 0], [1.0, g], atol=1e-11)
        assert f.classification[0] == Classification.REGULAR
        assert fa.resonances(f).label(0) == "no resonance up to order 8"


def test_what_has_one_frequency_stays_dependent():
    """Equal springs, one mode of unequal ones, modes of 1 : 2; Kepler's ellipses have only harmonics."""
    rng = np.random.default_rng(3)
    axes = np.linalg.qr(rng.standard_normal((2, 2)))[0]
    z0 = rng.standard_normal((4, 12))
    for w in ((1.3, 1.3), (1.3, 2.6)):
        f = fa.frequency_map(shared_systems.springs((axes * np.square(w)) @ axes.T, (1.0, 1.0)), z0, time=700.0)
        assert (f.classification == Classification.RESONANT).all()
        assert (f.rank == 1).all()
    model, single, _ = turned(2, rng, np.zeros(6))
    assert (fa.frequency_map(model, single, time=700.0).classification == Classification.RESONANT).all()
    kepler = fa.hamiltonian("-1/sqrt(x**2 + y**2)")
    far, turn = rng.uniform(1.05, 1.5, 12), rng.uniform(0, 2 * np.pi, 12)
    speed = np.sqrt(2 / far - 1)
    z0 = np.array([far * np.cos(turn), far * np.sin(turn), -speed * np.sin(turn), speed * np.cos(turn)])
    f = fa.frequency_map(kepler, z0, time=1000.0)
    assert (f.classification != Classification.REGULAR).all()
    assert (f.rank == 1).all()


@pytest.mark.parametrize("time", [1000.0, 3000.0])
def test_nearly_circular_orbits_have_two_frequencies(time):
    """Started with the circle's angular momentum: Omega and kappa but for the square of the amplitude."""
    rng = np.random.default_rng(4)
    halo = fa.hamiltonian("v*log(x**2 + y**2 + c**2)/2 - m/sqrt(x**2 + y**2 + b**2)", v=1.0, c=0.5, m=0.7, b=0.6)
    r, turn, small = rng.uniform(0.4, 2.0, 40), rng.uniform(0, 2 * np.pi, 40), 10 ** rng.uniform(-8, -6.3, 40)
    square = 1 / (r**2 + 0.25) + 0.7 / (r**2 + 0.36) ** 1.5  # Omega^2
    change = -2 * r * (1 / (r**2 + 0.25) ** 2 + 1.05 / (r**2 + 0.36) ** 2.5)
    true = np.sqrt([square, r * change + 4 * square]) / (2 * np.pi)
    across, along = r * np.sqrt(square) * rng.choice([-1, 1], 40), small * r * np.sqrt(square)
    cos, sin = np.cos(turn), np.sin(turn)
    z0 = np.array([r * cos, r * sin, along * cos - across * sin, along * sin + across * cos])
    f = fa.frequency_map(halo, z0, time=time)
    own = f.classification == Classification.REGULAR
    assert (misses(f.nu[:, own], f.error[:, own] + 1e-11, true[:, own]) <= 1).all()
    assert not (f.classification == Classification.RESONANT).any()
    assert own.sum() >= 30


def rotors(e=0.0):
    """Pendulums of several equal wells a turn; e couples them."""
    periods = {"x": "2*pi", "y": "2*pi"}
    text = "u*(1 - cos(k*x)) + v*(1 - cos(l*y)) + e*cos(x - y)"
    return lambda **given: fa.hamiltonian(text, coordinates="x y", periodic=periods, e=e, **given)


def pendulum(e):
    """The frequency times 2 pi of p^2/2 + 1 - cos(q) at these energies: swings, or turns beyond 2."""
    with np.errstate(all="ignore"):
        swings, turns = np.pi / (2 * ellipkm1(1 - e / 2)), np.pi * np.sqrt(e / 2) / ellipkm1((e - 2) / e)
    return np.where(e > 2, turns, swings)


@pytest.mark.parametrize("folds", list(itertools.product((1, 2, 3, 4), repeat=2))[1::3], ids=str)
def test_mean_rates_of_angles_are_frequencies(folds):
    """In either sense, of swings and turns at random."""
    rng = np.random.default_rng(folds)
    k = np.array(folds, float)[:, None]
    w = rng.uniform(0.6, 1.7, (2, 1))
    e = np.where(rng.random((2, 24)) < 0.7, rng.uniform(2.3, 8, (2, 24)), rng.uniform(0.1, 1.8, (2, 24)))
    z0 = np.concatenate([np.zeros((2, 24)), w / k * np.sqrt(2 * e) * rng.choice([-1, 1], (2, 24))])
    scales = (w / k).ravel() ** 2
    f = fa.frequency_map(rotors()(u=scales[0], v=scales[1], k=folds[0], l=folds[1]), z0, time=1500.0)
    true = w * pendulum(e) / (2 * np.pi) / np.where(e > 2, k, 1.0)
    own = f.classification == Classification.REGULAR
    assert own.sum() >= 18
    assert (np.abs(f.nu - true) <= f.error + 1e-13)[:, own].all()
    assert (f.error[:, own] < 1e-3).all()
    harmonics = np.abs(np.einsum("ijo,jo->io", f.basis, f.nu) - f.dominant)
    assert (harmonics <= 1e-3)[:, own].all()


def test_mean_rates_of_coupled_angles_are_frequencies():
    """Beside weighted means of the coordinates' own steps."""
    rng = np.random.default_rng(8)
    model = rotors(e=0.02)(u=0.3, v=0.2, k=2.0, l=1.0)
    z0 = np.concatenate([rng.uniform(-1, 1, (2, 16)), rng.uniform(1.6, 2.6, (2, 16)) * rng.choice([-1, 1], (2, 16))])
    f = fa.frequency_map(model, z0, time=2000.0)
    q = fa.integrate(model, z0, time=2000.0, samples=8000, accuracy=1e-11).samples[:, :2]
    s = (np.arange(7999) + 0.5) / 7999
    weight = np.exp(-1 / (s * (1 - s)))
    steps = np.diff(q, axis=0) * weight[:, None, None] / weight.sum()
    mean = np.abs(steps.sum(axis=0)) / (2 * np.pi * 0.25)
    # Angles trapped in the resonance 1 : 1 turn together: the second frequency is that of their libration.
    free = np.minimum(*(np.ptp(q[:, 0] + sign * q[:, 1], axis=0) for sign in (1, -1))) > 2 * np.pi
    own = (f.classification == Classification.REGULAR) & free
    assert own.sum() >= 10
    np.testing.assert_allclose(f.nu[:, own], mean[:, own], atol=1e-8)


def test_the_angles_of_two_rotors():
    model = fa.hamiltonian("-cos(2*x)/2 + 0.1*cos(2*y)", coordinates="x y", periodic={"x": "2*pi", "y": "2*pi"})
    for signs in itertools.product((1, -1), repeat=2):
        f = fa.frequency_map(model, [0.0, 0.0, 2.3 * signs[0], 1.7 * signs[1]], time=3000.0)
        np.testing.assert_allclose(f.nu[:, 0], [0.32622061, 0.27954877], atol=1e-8)
        assert f.classification[0] == Classification.REGULAR
        np.testing.assert_array_equal(f.basis[:, :, 0], [[2, 0], [0, 2]])


@pytest.mark.slow
def test_polar_orbits_go_round_a_black_hole():
    """a = 0.9, p = 10, e = 0.5 of KerrGeodesics #49: theta turns, the node is dragged."""
    start = [20.0, np.pi / 2, 0.0, 0.0, np.sqrt(14.65853302909102), 0.0]
    f = fa.frequency_map(fa.models.KerrGeodesic(0.9), start, time=1e5)
    assert f.classification[0] == Classification.REGULAR
    assert abs(f.nu[1, 0] - 0.0036247247) < 1e-10


def test_orbits_next_to_separatrices():
    rng = np.random.default_rng(6)
    e = 2 + 10 ** rng.uniform(-4, -1, (2, 30)) * rng.choice([-1, 1], (2, 30))
    w = np.array([[1.0], [0.7320508]])
    z0 = np.concatenate([np.zeros((2, 30)), w * np.sqrt(2 * e) * rng.choice([-1, 1], (2, 30))])
    f = fa.frequency_map(rotors()(u=1.0, v=float(w[1, 0]) ** 2, k=1.0, l=1.0), z0, time=5000.0)
    own = f.classification == Classification.REGULAR
    ratio = misses(f.nu[:, own], f.error[:, own], (w * pendulum(e) / (2 * np.pi))[:, own])
    assert own.sum() >= 20
    assert (ratio <= 1).mean() >= 0.95
    assert ratio.max() < 10


@pytest.mark.parametrize("time", [200.0, 300.0, 500.0])
def test_errors_of_short_runs_of_dense_spectra_cover(time):
    """Orbits of Henon and Heiles over 30 to 80 periods, beside 30 times longer runs."""
    model = fa.HenonHeiles()
    z0 = fa.energy_sample(model, energy=0.1, section="x=0", orbits=60, seed=5).z0
    f, long = fa.frequency_map(model, z0, time=time), fa.frequency_map(model, z0, time=9000.0)
    sure = (long.classification == Classification.REGULAR) & (long.error.max(axis=0) < 1e-6)
    own = sure & (f.classification == Classification.REGULAR)
    assert own.sum() >= 30
    ratio = misses(f.nu[:, own], f.error[:, own], long.nu[:, own])
    assert (ratio <= 1).mean() >= 0.95
    assert ratio.max() < 10
