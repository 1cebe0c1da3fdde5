"""Frequencies of angles about an axis, R (, z) and phi, in potentials with and without symmetry about it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastaff as fa
from fastaff import Classification

RNG = np.random.default_rng(314)
DISC = "-M/sqrt(x**2+y**2+s) + v/2*log(c+x**2+y**2/q**2) + e*(x**2-y**2)/(1+x**2+y**2)**2 + l*x/(1+x**2+y**2)"
THICK = (
    "-M/sqrt(x**2+y**2+(0.5+sqrt(z**2+0.01))**2) + log(c+x**2+y**2/q**2+z**2/0.64)/2 + e*(x**2-y**2)/(1+x**2+y**2)**2"
)
BAR = {"M": 0.6, "s": 0.36, "v": 1.0, "c": 0.09, "q": 0.8, "e": 0.0, "l": 0.0}


def disc(rotation=0.4, **changed):
    return fa.hamiltonian(DISC, coordinates="x y", rotation=rotation, **(BAR | changed))


def drawn(count, M):
    """Return starts (4, count) of both senses of turning."""
    R, turned = RNG.uniform(0.3, 2.5, count), RNG.uniform(0, 2 * np.pi, count)
    speed = np.sqrt(1 + M * R**2 / (R**2 + 0.36) ** 1.5)
    along = speed * RNG.choice([-1, 1], count) * RNG.uniform(0.2, 1.1, count)
    out, c, s = speed * RNG.uniform(-0.3, 0.3, count), np.cos(turned), np.sin(turned)
    return np.array([R * c, R * s, out * c - along * s, out * s + along * c])


def check_a_basis(about, plain, reach):
    """The frequencies of REGULAR orbits are those of the coordinates by integers of determinant +-1."""
    n = len(about.nu)
    k = np.stack(np.meshgrid(*[np.arange(-reach, reach + 1)] * n), axis=-1).reshape(-1, n)
    k = k[np.argsort(np.abs(k).sum(axis=1), kind="stable")]
    both = np.flatnonzero(
        (about.classification == Classification.REGULAR) & (plain.classification == Classification.REGULAR)
    )
    for o in both:
        apart = np.abs(k @ plain.nu[:, o] - about.nu[:, [o]])
        within = apart <= 3 * (np.abs(k) @ plain.error[:, o] + about.error[:, [o]]) + 1e-12
        assert within.any(axis=1).all(), (o, about.nu[:, o], plain.nu[:, o])
        assert abs(round(np.linalg.det(k[within.argmax(axis=1)]))) == 1, (o, about.nu[:, o], plain.nu[:, o])
    return both.size


def test_a_line_that_a_bar_drives_is_no_frequency():
    """R leads with 2 nu_phi: its own line is a peak of the Fourier transform of the orbit of another program."""
    energy, x, out = -0.4, np.array([1.0, -0.5085]), np.array([0.3, -0.0408])
    well = -0.6 / np.sqrt(x**2 + 0.36) + 0.5 * np.log(0.09 + x**2)
    along = 0.4 * x + np.sqrt((0.4 * x) ** 2 - 2 * (out**2 / 2 + well - energy))
    start = np.array([x, 0 * x, out, along])
    found = fa.frequency_map(disc(), start, time=2000.0, signals="R phi")
    assert (found.classification == Classification.REGULAR).all()
    assert found.other_basis.all()
    np.testing.assert_allclose(found.dominant[0], 2 * np.abs(found.nu[1]), rtol=1e-7)
    np.testing.assert_allclose(found.nu[0], [0.388512, 0.512845], atol=1e-6)
    assert check_a_basis(found, fa.frequency_map(disc(), start, time=2000.0), 6) == 2

    def rates(_, z):
        x, y, px, py = z
        r, d = (x * x + y * y + 0.36) ** 1.5, 0.09 + x * x + y * y / 0.64
        down = -0.6 * x / r - x / d, -0.6 * y / r - y / 0.64 / d
        return px + 0.4 * y, py - 0.4 * x, down[0] + 0.4 * py, down[1] - 0.4 * px

    times = 0.25 * np.arange(4096)
    for o in range(2):
        x, y = solve_ivp(rates, (0, times[-1]), start[:, o], "DOP853", times, rtol=1e-11, atol=1e-12).y[:2]
        R = np.sqrt(x**2 + y**2)
        window = np.sin(np.pi * (np.arange(R.size) + 0.5) / R.size) ** 6
        near = found.nu[0, o] + np.linspace(-2e-4, 2e-4, 81)
        size = np.abs(np.exp(-2j * np.pi * near[:, None] * times) @ (window * (R - R.mean())))
        assert abs(near[size.argmax()] - found.nu[0, o]) <= 1e-5


@pytest.mark.parametrize("rotation", [0.0, 0.25, 0.7])
def test_frequencies_of_random_bars_are_a_basis(rotation):
    M, q, e, l = RNG.uniform([0.2, 0.7, -0.3, -0.1], [1.5, 0.97, 0.3, 0.1])
    model, start = disc(rotation, M=M, q=q, e=e, l=l * (rotation > 0.5)), drawn(24, M)
    about, plain = (fa.frequency_map(model, start, time=800.0, signals=angles) for angles in ("R phi", None))
    assert check_a_basis(about, plain, 12) > 8
    samples = fa.integrate(model, start, time=800.0, samples=6400)
    assert check_a_basis(fa.orbit_frequencies(samples, signals="R phi"), plain, 12) > 8


def test_frequencies_of_a_thick_bar_are_a_basis():
    start = drawn(24, 0.8)
    z = np.array([*start[:2], RNG.uniform(-0.3, 0.3, 24), *start[2:], RNG.uniform(-0.3, 0.3, 24)])
    model = fa.hamiltonian(THICK, coordinates="x y z", rotation=0.2, M=0.8, c=0.1, q=0.9, e=0.02)
    about, plain = (fa.frequency_map(model, z, time=3000.0, signals=angles) for angles in ("R z phi", None))
    assert check_a_basis(about, plain, 6) > 5


def test_orbits_near_a_circle_have_the_epicyclic_frequency():
    """In a potential with symmetry kappa^2 = R d(Omega^2)/dR + 4 Omega^2, however small the swings."""
    R, small = 1.3, 10.0 ** -np.arange(4.0, 9)
    turning = np.sqrt(0.6 / (R**2 + 0.36) ** 1.5 + 1 / (R**2 + 0.09))
    slope = -1.8 * R / (R**2 + 0.36) ** 2.5 - 2 * R / (R**2 + 0.09) ** 2
    for sense in (1, -1):
        start = np.array([R + 0 * small, 0 * small, small, sense * turning * R + 0 * small])
        found = fa.frequency_map(disc(0.0, q=1.0), start, time=800.0, signals="R phi")
        expected = [[np.sqrt(R * slope + 4 * turning**2)], [sense * turning]]
        assert (np.abs(found.omega - expected) <= 2 * np.pi * found.error + 2 * small**2).all()
        assert (found.classification == Classification.REGULAR).all()
        assert (found.error < 1e-7).all()


def test_an_orbit_without_an_own_line_of_R_is_not_independent():
    """In Kepler's potential nu_R = nu_phi; on a circle R is at rest."""
    kepler = disc(0.0, M=1.0, s=0.0, v=0.0)
    start = np.array([[1.0, 1.0, 1.0], [0.0, 0.0, 0.0], [0.1, 0.0, 0.3], [1.1, 0.9, 1.2]])
    found = fa.frequency_map(kepler, start, time=1000.0, signals="R phi")
    assert (found.classification != Classification.REGULAR).all()
    assert (found.rank == 1).all()
    semiaxis = 1 / (2 - (start[2] ** 2 + start[3] ** 2))
    np.testing.assert_allclose(found.omega, np.tile(semiaxis**-1.5, (2, 1)), rtol=1e-8)
    circle = fa.frequency_map(kepler, [[1.0], [0.0], [0.0], [1.0]], time=1000.0, signals="R phi")
    assert circle.classification[0] == Classification.RESONANT
    np.testing.assert_allclose(circle.omega[1], 1.0, rtol=1e-10)
