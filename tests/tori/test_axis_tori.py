"""Actions and angles about an axis, R, z, phi, against closed forms and quadratures."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq

import fastaff as fa
from fastaff import Classification
from fastaff.tori.axis_tori import with_own_cycles

TURN = 2 * np.pi
ISOCHRONE = "-M/(b + sqrt(b**2 + x**2 + y**2 + z**2))"
KUZMIN_KUTUZOV = "-1/sqrt(x**2 + y**2 + z**2 + a**2 + c**2 + 2*sqrt(a**2*c**2 + c**2*(x**2 + y**2) + a**2*z**2))"


def momenta(z):
    """Return L and L_z."""
    momentum = np.cross(z[:3], z[3:])
    return np.linalg.norm(momentum), momentum[2]


def isochrone(z, M, b):
    """Return the actions and frequencies of Henon's isochrone, of Kepler's potential for b = 0 (Binney & Tremaine,
    section 3.5).
    """
    L, L_z = momenta(z)
    energy = z[3:] @ z[3:] / 2 - M / (b + np.sqrt(b * b + z[:3] @ z[:3]))
    root = np.sqrt(L * L + 4 * M * b)
    radial = (-2 * energy) ** 1.5 / M
    across = radial * (1 + L / root) / 2
    J = np.array([M / np.sqrt(-2 * energy) - (L + root) / 2, L - abs(L_z), L_z])
    return TURN * J, np.array([radial, across, np.sign(L_z) * across]) / TURN


def oscillator(z, w):
    """Return the actions and frequencies of the isotropic harmonic oscillator."""
    L, L_z = momenta(z)
    energy = z[3:] @ z[3:] / 2 + w * w * (z[:3] @ z[:3]) / 2
    return TURN * np.array([energy / w / 2 - L / 2, L - abs(L_z), L_z]), w * np.array([2, 1, np.sign(L_z)]) / TURN


def kuzmin_kutuzov(z, a, c, nodes=100):
    """Return the actions of the potential of Kuzmin & Kutuzov, with

        2 (t + alpha)(t + gamma) p_t^2 = E t + sqrt(t) + L_z^2 (alpha - gamma)/(2 (t + alpha)) + K,

    alpha = -a^2, gamma = -c^2, in both prolate spheroidal coordinates t (Dejonghe & de Zeeuw 1988, ApJ 333, 90), and
    its frequencies dE/dJ.
    """
    alpha, gamma = -a * a, -c * c
    square = z[0] ** 2 + z[1] ** 2
    L = z[0] * z[4] - z[1] * z[3]
    total = square + z[2] ** 2 + a * a + c * c
    product = a * a * c * c + c * c * square + a * a * z[2] ** 2
    outer = (total + np.sqrt(total * total - 4 * product)) / 2
    energy = z[3:] @ z[3:] / 2 - 1 / np.sqrt(total + 2 * np.sqrt(product))
    slope = (z[0] * z[3] + z[1] * z[4]) / (2 * (outer + alpha)) + z[5] * z[2] / (2 * (outer + gamma))
    K = 2 * (outer + alpha) * (outer + gamma) * slope**2 - energy * outer - np.sqrt(outer)
    K -= L * L * (alpha - gamma) / (2 * (outer + alpha))

    def right(t):
        return energy * t + np.sqrt(t) + L * L * (alpha - gamma) / (2 * (t + alpha)) + K

    def roots(points):
        values = right(points) * (points + alpha)
        change = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
        return [brentq(lambda t: right(t) * (t + alpha), *points[[i, i + 1]], xtol=1e-15, rtol=1e-15) for i in change]

    low, high = roots(-alpha + np.geomspace(1e-12, 1e4, 4000))
    (top,) = roots(np.linspace(-gamma, -alpha - 1e-13, 4000))
    x, w = np.polynomial.legendre.leggauss(nodes)
    across = x * np.pi / 2
    up = (x + 1) * np.pi / 4
    panels = (
        (2, (low + high) / 2 + (high - low) / 2 * np.sin(across), (high - low) / 2 * np.cos(across) * np.pi / 2 * w),
        (4, -gamma + (top + gamma) * np.sin(up) ** 2, (top + gamma) * np.sin(2 * up) * np.pi / 4 * w),
    )
    J, slopes = [], []
    for cycles, t, dt in panels:
        p = np.sqrt(right(t) / (2 * (t + alpha) * (t + gamma)))
        part = cycles / (4 * (t + alpha) * (t + gamma) * p) * dt
        J.append(cycles * (p @ dt))
        slopes.append([part @ t, part.sum(), part @ (L * (alpha - gamma) / (t + alpha))])
    return np.array([*J, TURN * L]), np.linalg.inv([*slopes, [0, 0, TURN]])[0]


def check(fit, J, nu, rounding=0.0):
    assert fit.classification is Classification.REGULAR
    assert fit.names == ("R", "z", "phi")
    assert (np.abs(fit.J - J) <= fit.J_error + rounding).all()
    assert (np.abs(fit.nu - nu) <= fit.nu_error + rounding).all()
    assert (fit.J_error < 1e-5 * np.abs(J).max()).all()


def draw(random, kind, speed):
    """Return a start of a kind in a spherical potential whose circular speed at a radius is speed(r)."""
    x = random.normal(size=3)
    v = random.normal(size=3)
    if kind == "flat":
        x[2], v[2] = 1e-5 * x[2], 1e-4 * v[2]
    radius = np.linalg.norm(x)
    if kind == "circular":
        v = np.cross(x, v)
    v *= speed(radius) / np.linalg.norm(v) * (1 + 1e-5 if kind == "circular" else random.uniform(0.5, 1.1))
    if kind == "radial":
        v = 0.02 * v + 0.8 * speed(radius) * x / radius
    if (x[0] * v[1] - x[1] * v[0] > 0) == (kind == "retrograde"):
        v = np.where([True, True, False], -v, v) if kind == "flat" else -v
    return np.concatenate([x, v])


@pytest.mark.parametrize("kind", ["prograde", "retrograde", "circular", "radial", "flat"])
def test_isochrone(kind):
    random = np.random.default_rng(["prograde", "retrograde", "circular", "radial", "flat"].index(kind))
    M, b = random.uniform(0.5, 2), random.uniform(0.2, 1)
    z = draw(random, kind, lambda r: np.sqrt(M / np.hypot(b, r)) * r / (b + np.hypot(b, r)))
    J, nu = isochrone(z, M, b)
    fit = fa.fit_torus(fa.hamiltonian(ISOCHRONE, coordinates="x y z", M=M, b=b), z, time=150 / nu[1], angles="R z phi")
    check(fit, J, nu)
    np.testing.assert_allclose(fit.evaluate(fit.theta0), z, rtol=0, atol=1e-9)
    assert np.sign(fit.J[2]) == (-1 if kind == "retrograde" else 1)


def test_closed_orbits_have_three_actions():
    """The three frequencies of Kepler's potential and of the oscillator are commensurable."""
    random = np.random.default_rng(7)
    M, w = random.uniform(0.5, 2, 2)
    kepler = fa.hamiltonian("-M/sqrt(x**2 + y**2 + z**2)", coordinates="x y z", M=M)
    spring = fa.hamiltonian("w**2*(x**2 + y**2 + z**2)/2", coordinates="x y z", w=w)
    z = draw(random, "prograde", lambda r: np.sqrt(M / r))
    check(fa.fit_torus(kepler, z, time=100 / isochrone(z, M, 0.0)[1][0], angles="R z phi"), *isochrone(z, M, 0.0))
    z = draw(random, "retrograde", lambda r: w * r)
    check(fa.fit_torus(spring, z, time=100 * TURN / w, angles="R z phi"), *oscillator(z, w))


def test_staeckel_potential():
    """A flattened potential that separates: actions by quadrature."""
    random = np.random.default_rng(3)
    a, c = random.uniform(0.9, 1.3), random.uniform(0.5, 0.8)
    model = fa.hamiltonian(KUZMIN_KUTUZOV, coordinates="x y z", a=a, c=c)
    for sense in (1, -1):
        z = np.array([0.9, 0.2, 0.1, 0.1, 0.45 * sense, 0.2]) + random.uniform(-0.05, 0.05, 6)
        J, nu = kuzmin_kutuzov(z, a, c)
        fit = fa.fit_torus(model, z, time=200 / abs(nu).min(), angles="R z phi")
        check(fit, J, nu, rounding=1e-11)
        np.testing.assert_allclose(fit.evaluate(fit.theta0), z, rtol=0, atol=1e-8)
        assert list(fit.maslov) == [2, 2, 0]
    sheared = fit.in_basis([[1, 1, 0], [0, 1, 0], [0, 0, 1]])
    again = with_own_cycles(dataclasses.replace(sheared, names=fit.names))
    np.testing.assert_allclose(again.J, fit.J, rtol=1e-13)
    np.testing.assert_allclose(again.nu, fit.nu, rtol=1e-13)
    trapped = fit.coefficients.copy()
    trapped[[2, 5]] = (fit.k == [1, 0, 0]).all(axis=1) * np.array([[1.0], [1j]])  # z goes around with R
    assert with_own_cycles(dataclasses.replace(fit, coefficients=trapped)).names == ("theta 1", "theta 2", "phi")


def test_planes_and_circles():
    """An orbit in z = 0 has the angles R and phi; a circle has phi."""
    disk = fa.hamiltonian("-1/(b + sqrt(b**2 + x**2 + y**2))", coordinates="x y", b=0.5)
    space = fa.hamiltonian(ISOCHRONE, coordinates="x y z", M=1.0, b=0.5)
    z = np.array([1.0, 0.0, 0.0, 0.2, -0.5, 0.0])
    J, nu = isochrone(z, 1.0, 0.5)
    flat = fa.fit_torus(disk, z[[0, 1, 3, 4]], time=500.0, angles="R phi")
    level = fa.fit_torus(space, z, time=500.0, angles="R z phi")
    assert (flat.classification, level.classification) == (Classification.REGULAR, Classification.RESONANT)
    for fit in (flat, level):
        assert fit.names == ("R", "phi")
        assert (np.abs(fit.J - J[[0, 2]]) <= fit.J_error).all()
        assert (np.abs(fit.nu - nu[[0, 2]]) <= fit.nu_error).all()
    root = np.hypot(0.5, 1.0)
    speed = np.sqrt(1 / root) / (0.5 + root)
    circle = fa.fit_torus(disk, [1.0, 0.0, 0.0, speed], time=500.0, angles="R phi")
    assert circle.names == ("phi",)
    np.testing.assert_allclose([circle.J[0], circle.nu[0]], [TURN * speed, speed / TURN], rtol=1e-12)


def test_polar_coordinates_are_angles_already():
    polar = fa.hamiltonian(
        "p_R**2/2 + p_phi**2/(2*R**2) - 1/(b + sqrt(b**2 + R**2))",
        coordinates="R phi",
        momenta="p_R p_phi",
        periodic={"phi": "2*pi"},
        domain="R",
        b=0.5,
    )
    J, nu = isochrone(np.array([1.0, 0.0, 0.0, 0.2, 0.4, 0.0]), 1.0, 0.5)
    fit = fa.fit_torus(polar, [1.0, 0.0, 0.2, 0.4], time=500.0, angles="R phi")
    assert fit.names == ("R", "phi")
    np.testing.assert_allclose(fit.J, J[[0, 2]], rtol=1e-10)
    np.testing.assert_allclose(fit.nu, nu[[0, 2]], rtol=1e-10)


def test_samples_of_other_programs():
    w, t = 0.7, np.linspace(0.0, 300.0, 4001)
    start = np.array([0.8, -0.1, 0.3, 0.2, 0.5, -0.3])
    samples = np.vstack(
        [
            start[:3, None] * np.cos(w * t) + start[3:, None] / w * np.sin(w * t),
            start[3:, None] * np.cos(w * t) - w * start[:3, None] * np.sin(w * t),
        ]
    )
    J, nu = oscillator(start, w)
    check(fa.tori.fit_samples(samples, t[1], angles="R z phi"), J, nu)
    with pytest.raises(ValueError, match="angles must be of 3 coordinates, got 'R phi' of 2"):
        fa.tori.fit_samples(samples, t[1], angles="R phi")
    with pytest.raises(ValueError, match="samples must have a constant angular momentum about z, got"):
        fa.tori.fit_samples(samples * np.array([1, 0.7, 1, 1, 1, 1])[:, None], t[1], angles="R z phi")
    plane = samples[[0, 2, 3, 5]]
    plane[[1, 3]] = 0.0
    with pytest.raises(ValueError, match="samples must have angular momentum about the z axis, got 0"):
        fa.tori.fit_samples(plane, t[1], angles="R phi")


DISK = fa.hamiltonian("-1/sqrt(x**2 + y**2 + 1)", coordinates="x y")
OVAL = fa.hamiltonian("log(x**2 + y**2/q**2 + 0.1)/2", coordinates="x y", q=0.999999)


@pytest.mark.parametrize(
    ("model", "z0", "angles", "error", "message"),
    [
        (DISK, [1.0, 0.0, 0.0, 0.5], "phi R", ValueError, "angles must be 'R phi' for x, y or 'R z phi' for x, y, z"),
        (DISK, [1.0, 0.0, 0.0, 0.5], 2, TypeError, "angles must be text such as 'R z phi', got int"),
        (DISK, [1.0, 0.0, 0.0, 0.5], "R z phi", ValueError, "angles must be of 2 coordinates.*Use 'R phi'"),
        (DISK, [1.0, 0.0, 0.5, 0.0], "R phi", ValueError, "z0 must have angular momentum about the z axis, got 0"),
        (OVAL, [1.0, 0.0, 0.0, 0.5], "R phi", ValueError, "model must be symmetric about the z axis"),
        (fa.models.StandardMap(0.5), [3.0, 0.3], "R phi", ValueError, "angles must be left out for StandardMap"),
        (
            fa.Body(fa.NeoHookean()),
            [1.3, 0.1, 0.2, 0.0, 0.2, 0.3, 0.1, 0.2],
            "R z phi",
            ValueError,
            "angles must be left out for Body, got 'R z phi'",
        ),
    ],
)
def test_models_without_these_angles(model, z0, angles, error, message):
    with pytest.raises(error, match=message) as raised:
        fa.fit_torus(model, z0, time=500.0, angles=angles)
    assert len(str(raised.value)) <= 160
