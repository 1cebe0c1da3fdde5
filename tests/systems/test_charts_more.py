"""Every chart of the paper: points, velocities, momenta, metric, density, kinetic energy, singular sets, group actions.

The truth is a second writing of each point map, straight from the paper and good for complex numbers: its derivative by
complex step (exact to rounding, step 1e-30) is the Jacobian. Tolerances: grids keep alpha, beta, |D1 - |D2|| and the
distance to every focus above 0.2, so condition numbers are below 100 and 1e-12 is 50 units of rounding at that
condition.
"""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fastaff.systems.charts import (
    ALPHA_BETA,
    CHARTS,
    DELTA_B,
    ELLIPTIC,
    EULER,
    EXPONENTIAL,
    PARABOLIC,
    POLAR_POLAR,
    R_VARTHETA,
    RHO_EPSILON,
    RHO_VARTHETA,
    SPHERICAL,
    SPHERICAL_CARTESIAN,
    TWO_POLAR,
    Chart,
    b_of_vartheta,
    bipolar,
    deformation,
    elliptic,
    from_matrix,
    reflect_body,
    reflect_space,
    rotate,
    to_matrix,
    vartheta_of_b,
)

ROOT2 = np.sqrt(2)
MU = 1.7
ALL = [*CHARTS.values(), elliptic(0.6), bipolar(2.5)]
every_chart = pytest.mark.parametrize("chart", ALL, ids=[f"{k}-{chart.name}" for k, chart in enumerate(ALL)])
AREA_POSITIVE = ("exponential", "delta-b")


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def two_polar_matrix(D1, D2, phi, psi):
    """EQ2.0, complex arguments too."""
    return turn(phi) @ np.diag([D1, D2]) @ turn(psi).T


def from_radii(alpha, beta, phi, psi):
    return two_polar_matrix((alpha + beta) / ROOT2, (alpha - beta) / ROOT2, phi, psi)


def planar(radii, angles):
    """The matrix of a chart q1, q2 -> alpha, beta with angles q3, q4 -> phi, psi."""
    return lambda q1, q2, q3, q4: from_radii(*radii(q1, q2), *angles(q3, q4))


def turned(eta, gamma):
    return (eta + gamma) / 2, (gamma - eta) / 2


def doubled(Phi, Psi):
    return Phi / 2, -Psi / 2


def same(phi, psi):
    return phi, psi


def exchanged(f):
    """A chart of coordinates q1, q3, q2, q4."""
    return lambda q1, q2, q3, q4: f(q1, q3, q2, q4)


def r_radii(r, vartheta):
    return np.sqrt(r) * np.cos(vartheta / 2), np.sqrt(r) * np.sin(vartheta / 2)


def rho_radii(rho, vartheta):
    return rho * np.cos(vartheta / 2), rho * np.sin(vartheta / 2)


def elements(x, y, z, u):
    return np.array([[x, y], [z, u]])


def exponential_radii(a, b):
    return ROOT2 * np.exp(a / 2) * np.cosh(b / 2), ROOT2 * np.exp(a / 2) * np.sinh(b / 2)


def elliptic_radii(focus):
    return lambda k, lam: (focus * np.cosh(k) * np.cos(lam), focus * np.sinh(k) * np.sin(lam))


def bipolar_radii(c):
    return lambda e, f: (c * np.sinh(e) / (np.cosh(e) - np.cos(f)), c * np.sin(f) / (np.cosh(e) - np.cos(f)))


TRUTH = {
    "Cartesian": elements,
    "two-polar": two_polar_matrix,
    "alpha-beta": planar(lambda alpha, beta: (alpha, beta), turned),
    "alpha-beta-phi-psi": from_radii,
    "r-vartheta": planar(r_radii, same),
    "r-vartheta-eta-gamma": planar(r_radii, turned),
    "rho-vartheta": planar(rho_radii, turned),
    "rho-epsilon": planar(lambda rho, epsilon: rho_radii(rho, 2 * epsilon), turned),
    "Euler": exchanged(planar(rho_radii, doubled)),
    "r-Euler": exchanged(planar(r_radii, doubled)),
    "elliptic": planar(elliptic_radii(ROOT2), turned),
    "parabolic": planar(lambda xi, delta: ((xi**2 - delta**2) / 2, xi * delta), turned),
    "bipolar": planar(bipolar_radii(1.0), turned),
    "exponential": planar(exponential_radii, same),
    "delta-b": planar(lambda delta, b: exponential_radii(2 * np.log(delta), b), doubled),
    "spherical": lambda r, lam, mu, nu: elements(
        r * np.sin(lam) * np.cos(mu) * np.cos(nu),
        r * np.sin(lam) * np.cos(mu) * np.sin(nu),
        r * np.sin(lam) * np.sin(mu),
        r * np.cos(lam),
    ),
    "spherical-Cartesian": lambda R, theta, chi, u: elements(
        R * np.sin(theta) * np.cos(chi), R * np.sin(theta) * np.sin(chi), R * np.cos(theta), u
    ),
    "polar-polar": lambda r1, chi1, r2, chi2: elements(
        r1 * np.cos(chi1), r1 * np.sin(chi1), r2 * np.cos(chi2), r2 * np.sin(chi2)
    ),
    "polar-Cartesian": lambda r1, chi1, z, u: elements(r1 * np.cos(chi1), r1 * np.sin(chi1), z, u),
}


def truth(chart):
    if chart is ALL[-2]:
        return planar(elliptic_radii(0.6), turned)
    if chart is ALL[-1]:
        return planar(bipolar_radii(2.5), turned)
    return TRUTH[chart.name]


def planes_of(matrix):
    (x, y), (z, u) = matrix
    return np.array([x + u, z - y, x - u, y + z]) / ROOT2


def complex_step(f, q, h=1e-30):
    """df_i/dq_k."""
    return np.stack([planes_of(f(*(q + 1j * h * unit))).imag / h for unit in np.eye(4)], axis=1)


def grid(chart, orbits=60, seed=11):
    """Phase points well inside the chart: alpha, beta in [0.3, 2.2], off foci; alpha - beta > 0.3 where det phi > 0 is
    needed.
    """
    rng = np.random.default_rng(seed)
    alpha, beta = rng.uniform(0.3, 2.2, (2, 40 * orbits))
    foci = np.array([ROOT2, 1.0, 0.6, 2.5])
    keep = (np.abs(alpha - beta) > 0.2) & (np.hypot(alpha[:, None] - foci, beta[:, None]).min(axis=1) > 0.3)
    if chart.name in AREA_POSITIVE:
        keep &= alpha - beta > 0.3
    eta, gamma = rng.uniform(0.1, 2 * np.pi - 0.1, (2, 40 * orbits))
    planes = np.stack([alpha * np.cos(eta), alpha * np.sin(eta), beta * np.cos(gamma), beta * np.sin(gamma)])
    (x, y), (z, u) = to_matrix(np.concatenate([planes, planes]))[0]
    keep &= (np.hypot(x, y) > 0.3) & (np.hypot(z, u) > 0.3) & (np.sqrt(x**2 + y**2 + z**2) > 0.3)
    chosen = np.flatnonzero(keep)[:orbits]
    assert chosen.size == orbits
    return np.concatenate([planes[:, chosen], rng.normal(size=(4, orbits))])


def test_every_chart_is_in_the_table():
    assert len(CHARTS) == 19
    assert set(TRUTH) == set(CHARTS)
    assert all(CHARTS[name].name == name for name in CHARTS)


@every_chart
def test_points_are_the_papers(chart):
    z = grid(chart)
    q = chart.from_planes(z)
    written = np.stack([planes_of(truth(chart)(*point)) for point in q[:4].T], axis=1)
    np.testing.assert_allclose(written, z[:4], rtol=0, atol=1e-13)
    np.testing.assert_allclose(chart.points_to_planes(q[:4]), z[:4], rtol=0, atol=1e-13)
    np.testing.assert_array_equal(chart.points_from_planes(z[:4]), q[:4])


@every_chart
def test_jacobian_is_the_complex_step(chart):
    q = chart.from_planes(grid(chart))[:4]
    J = chart.jacobian(q)
    assert J.shape == (4, 4, 60)
    for k, point in enumerate(q.T):
        np.testing.assert_allclose(
            J[..., k], complex_step(truth(chart), point), rtol=0, atol=1e-13 * np.abs(J[..., k]).max()
        )
    np.testing.assert_array_equal(chart.jacobian(q.reshape(4, 3, 20)), J.reshape(4, 4, 3, 20))
    np.testing.assert_array_equal(chart.jacobian(q[:, 7]), J[..., 7])


@every_chart
def test_metric_is_the_pullback(chart):
    """g = J^T J, sqrt|g| = |det J|, from the complex step alone; the inverse metric to the condition of g."""
    q = chart.from_planes(grid(chart))[:4]
    g, density, back = chart.metric(q), chart.density(q), chart.inverse_metric(q)
    for k, point in enumerate(q.T):
        J = complex_step(truth(chart), point)
        np.testing.assert_allclose(g[..., k], J.T @ J, rtol=0, atol=1e-13 * np.abs(g[..., k]).max())
        np.testing.assert_allclose(density[k], abs(np.linalg.det(J)), rtol=1e-12)
        np.testing.assert_allclose(back[..., k] @ g[..., k], np.eye(4), rtol=0, atol=1e-14 * np.linalg.cond(J.T @ J))
    np.testing.assert_allclose(
        chart.metric(q[:, 3]), g[..., 3], rtol=1e-14
    )  # vector and scalar functions of NumPy differ by an ulp
    assert chart.density(q[:, 3]).shape == ()


@every_chart
def test_momenta_and_velocities_both_ways(chart):
    """p_q = J^T p and v = J dq/dt with the complex-step J; every conversion comes back."""
    z = grid(chart)
    q, w = chart.from_planes(z), chart.velocities_from_planes(z)
    np.testing.assert_array_equal(w[:4], q[:4])
    for k, point in enumerate(q[:4].T):
        J = complex_step(truth(chart), point)
        np.testing.assert_allclose(q[4:, k], J.T @ z[4:, k], rtol=0, atol=1e-12 * max(1, np.abs(J).max()))
        np.testing.assert_allclose(J @ w[4:, k], z[4:, k], rtol=0, atol=1e-12)
    np.testing.assert_allclose(chart.to_planes(q), z, rtol=0, atol=1e-12)
    np.testing.assert_allclose(chart.velocities_to_planes(w), z, rtol=0, atol=1e-12)


@every_chart
def test_legendre_transformation(chart):
    """p = mu g dq/dt, with z's lower rows as velocities; and back."""
    w = chart.velocities_from_planes(grid(chart))
    p = chart.momenta_from_velocities(w, MU)
    expected = MU * np.einsum("ijn,jn->in", chart.metric(w[:4]), w[4:])
    np.testing.assert_allclose(p[4:], expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(chart.velocities_from_momenta(p, MU), w, rtol=0, atol=1e-11 * np.abs(w).max())
    np.testing.assert_array_equal(chart.momenta_from_velocities(w[:, 5], MU)[:4], w[:4, 5])


@every_chart
def test_kinetic_energy(chart):
    """mu |v|^2/2 and |p|^2/2 mu, and through g_ij and g^ij."""
    z = grid(chart)
    T = np.sum(z[4:] ** 2, axis=0)
    q, w = chart.from_planes(z), chart.velocities_from_planes(z)
    np.testing.assert_allclose(chart.kinetic_energy(w, MU), MU / 2 * T, rtol=1e-11)
    np.testing.assert_allclose(chart.kinetic_energy_from_momenta(q, MU), T / (2 * MU), rtol=1e-11)
    contracted = np.einsum("ijn,in,jn->n", chart.inverse_metric(q[:4]), q[4:], q[4:])
    np.testing.assert_allclose(contracted, T, rtol=1e-11)


def test_hamiltonians_of_the_paper():
    """The kinetic parts of the Hamiltonians in (D1, D2), (alpha, beta), (r, vartheta), (kappa, lambda), written out."""
    z = grid(ELLIPTIC)
    al, be, _, _, pal, pbe, pe, pg = ALPHA_BETA.from_planes(z)
    T = ALPHA_BETA.kinetic_energy_from_momenta(ALPHA_BETA.from_planes(z), MU)
    D1, D2, _, _, p1, p2, pphi, ppsi = TWO_POLAR.from_planes(z)  # EQ2.0a inverted, EQ2.1a, EQ2.2f
    size, area = D1**2 + D2**2, D1 * D2
    turning = (size * (pphi**2 + ppsi**2) + 4 * area * pphi * ppsi) / (size**2 - 4 * area**2)
    np.testing.assert_allclose(T, (p1**2 + p2**2 + turning) / (2 * MU), rtol=1e-11)
    np.testing.assert_allclose(T, ((pal**2 + pe**2 / al**2) + (pbe**2 + pg**2 / be**2)) / (2 * MU), rtol=1e-12)
    r, th, _, _, pr, pth, pphi, ppsi = R_VARTHETA.from_planes(z)
    top = (pphi**2 + ppsi**2 + 2 * pphi * ppsi * np.cos(th)) / np.sin(th) ** 2 + 4 * pth**2
    np.testing.assert_allclose(T, (4 * r * pr**2 + top / r) / (2 * MU), rtol=1e-11)
    k, lam, _, _, pk, pl, _, _ = ELLIPTIC.from_planes(z)
    stretch = np.cosh(k) ** 2 - np.cos(lam) ** 2
    angular = pe**2 / (np.cosh(k) * np.cos(lam)) ** 2 + pg**2 / (np.sinh(k) * np.sin(lam)) ** 2
    np.testing.assert_allclose(T, ((pk**2 + pl**2) / stretch + angular) / (4 * MU), rtol=1e-11)


def test_errata_of_the_line_elements():
    """The elliptic form and EQ6.4a are half of the truth as printed; EQ6.4 needs Psi = -2 psi."""
    k, lam = 0.7, 0.4
    assert ELLIPTIC.metric([k, lam, 0, 0])[0, 0] == pytest.approx(2 * (np.cosh(k) ** 2 - np.cos(lam) ** 2), rel=1e-14)
    assert DELTA_B.metric([1.3, 0.5, 0, 0])[0, 0] == pytest.approx(2 * np.cosh(0.5), rel=1e-14)
    assert DELTA_B.metric([1.3, 0.5, 0, 0])[2, 3] == pytest.approx(1.3**2 / 2, rel=1e-14)
    z = grid(EULER)
    rho, Phi, Theta, Psi = EULER.from_planes(z)[:4]
    two_polar, r_vartheta = TWO_POLAR.from_planes(z), R_VARTHETA.from_planes(z)
    np.testing.assert_allclose(
        (Phi, Psi, Theta), (2 * two_polar[2], -2 * two_polar[3], r_vartheta[1]), rtol=0, atol=1e-14
    )
    np.testing.assert_allclose(
        EULER.metric([rho, Phi, Theta, Psi])[1, 3], rho**2 / 4 * np.cos(Theta), rtol=0, atol=1e-15
    )


# --- sheets and group actions ------------------------------------------------------------------------------------


@every_chart
def test_canonical_sheet(chart):
    """Angles and radii where the docstring of the package says."""
    q = dict(zip(chart.names, chart.from_planes(grid(chart, 200))))
    pi = np.pi
    ranges = {
        "alpha": (0, 9),
        "beta": (0, 9),
        "eta": (0, 2 * pi),
        "gamma": (0, 2 * pi),
        "phi": (0, 2 * pi),
        "psi": (-pi, pi),
        "b": (0, 9),
        "Phi": (0, 4 * pi),
        "Psi": (-2 * pi, 2 * pi),
        "vartheta": (0, pi),
        "Theta": (0, pi),
        "epsilon": (0, pi / 2),
        "rho": (0, 9),
        "r": (0, 20),
        "kappa": (0, 9),
        "xi": (0, 9),
        "e": (0, 9),
        "f": (0, pi),
        "mu": (-pi / 2, pi / 2),
        "nu": (0, 2 * pi),
        "theta": (0, pi),
        "chi": (0, 2 * pi),
        "chi1": (0, 2 * pi),
        "chi2": (0, 2 * pi),
        "R": (0, 9),
        "r1": (0, 9),
        "r2": (0, 9),
        "lambda": (0, pi if chart is SPHERICAL else pi / 2),
        "D1": (0, 9),
    }
    for name, values in q.items():
        if name in ranges:
            low, high = ranges[name]
            assert low <= values.min()
            assert values.max() <= high
    if chart is PARABOLIC:
        assert (q["xi"] >= q["delta"]).all()
        assert (q["delta"] >= 0).all()
    if chart is TWO_POLAR:
        assert (q["D1"] >= np.abs(q["D2"])).all()


def test_one_matrix_many_coordinates():
    """The exchange D1 <-> D2, a turn of gamma, both signs; and what they are in alpha-beta: the same matrix, det of any
    sign.
    """
    z = grid(TWO_POLAR)
    assert (deformation(z).area < 0).any()
    assert (deformation(z).area > 0).any()
    D1, D2, phi, psi, p1, p2, p3, p4 = TWO_POLAR.from_planes(z)
    h, pi = np.pi / 2, np.pi
    for sheet in (
        (D2, D1, phi + h, psi + h, p2, p1, p3, p4),
        (D1, D2, phi + pi, psi + pi, p1, p2, p3, p4),
        (-D1, -D2, phi + pi, psi, -p1, -p2, p3, p4),
    ):
        there = TWO_POLAR.to_planes(sheet)
        np.testing.assert_allclose(there, z, rtol=0, atol=1e-12)
        np.testing.assert_allclose(TWO_POLAR.from_planes(there), TWO_POLAR.from_planes(z), rtol=0, atol=1e-11)
    al, be, eta, gamma, pal, pbe, pe, pg = ALPHA_BETA.from_planes(z)
    for sheet in (
        (al, -be, eta, gamma + pi, pal, -pbe, pe, pg),
        (al, be, eta, gamma + 2 * pi, pal, pbe, pe, pg),
        (-al, -be, eta + pi, gamma + pi, -pal, -pbe, pe, pg),
    ):
        np.testing.assert_allclose(ALPHA_BETA.to_planes(sheet), z, rtol=0, atol=1e-12)
        np.testing.assert_allclose(
            ALPHA_BETA.velocities_to_planes(ALPHA_BETA.velocities_from_momenta(sheet)), z, rtol=0, atol=1e-11
        )


@pytest.mark.parametrize("chart", [EXPONENTIAL, DELTA_B], ids=lambda chart: chart.name)
def test_signed_shear(chart):
    """b -> -b is the exchange D1 <-> D2: with a quarter turn of phi and psi (Phi + pi, Psi - pi) the same matrix."""
    q = chart.from_planes(grid(chart))
    sheet = q.copy()
    sheet[[1, 5]] *= -1
    sheet[2] += np.pi / 2 if chart is EXPONENTIAL else np.pi
    sheet[3] += np.pi / 2 if chart is EXPONENTIAL else -np.pi
    np.testing.assert_allclose(chart.to_planes(sheet), chart.to_planes(q), rtol=0, atol=1e-12)
    np.testing.assert_allclose(chart.density(sheet[:4]), chart.density(q[:4]), rtol=1e-14)


def around(angle, turn_by):
    """The distance of two angles on a circle."""
    return np.abs(np.angle(np.exp(2j * np.pi * (angle - turn_by) / (2 * np.pi))))


def test_rotations():
    """O(x) phi O(y)^T: phi + x, psi + y; the other rows of every chart of the invariants stay."""
    z, x, y = grid(TWO_POLAR), 0.7, -1.9
    phi, momentum = to_matrix(z)
    by_hand = from_matrix(*(np.einsum("ij,jkn,lk->iln", turn(x), m, turn(y)) for m in (phi, momentum)))
    rotated = rotate(z, space=x, body=y)
    np.testing.assert_allclose(rotated, by_hand, rtol=0, atol=1e-14 * 10)
    q, p = ALPHA_BETA.from_planes(z), ALPHA_BETA.from_planes(rotated)
    np.testing.assert_allclose(p[[0, 1, 4, 5, 6, 7]], q[[0, 1, 4, 5, 6, 7]], rtol=0, atol=1e-13)
    assert around(p[2] - q[2], x - y).max() < 1e-13
    assert around(p[3] - q[3], x + y).max() < 1e-13
    right = from_matrix(*(np.einsum("ijn,jk->ikn", m, turn(x)) for m in (phi, momentum)))  # phi -> phi O(x)
    np.testing.assert_allclose(rotate(z, body=-x), right, rtol=0, atol=1e-13)
    assert around(ALPHA_BETA.from_planes(right)[2] - q[2], x).max() < 1e-13
    assert around(ALPHA_BETA.from_planes(right)[3] - q[3], -x).max() < 1e-13
    np.testing.assert_allclose(rotate(z, space=np.full(60, x), body=y), rotated, rtol=0, atol=1e-15)


def test_reflections():
    z = grid(ALPHA_BETA)
    phi, momentum = to_matrix(z)
    mirror = np.diag([1.0, -1.0])
    left = from_matrix(*(np.einsum("ij,jkn->ikn", mirror, m) for m in (phi, momentum)))
    right = from_matrix(*(np.einsum("ijn,jk->ikn", m, mirror) for m in (phi, momentum)))
    np.testing.assert_allclose(reflect_space(z), left, rtol=0, atol=1e-14)
    np.testing.assert_allclose(reflect_body(z), right, rtol=0, atol=1e-14)
    al, be, eta, gamma, pal, pbe, pe, pg = ALPHA_BETA.from_planes(z)
    q = ALPHA_BETA.from_planes(reflect_space(z))
    np.testing.assert_allclose(q[[0, 1, 4, 5, 6, 7]], (be, al, pbe, pal, -pg, -pe), rtol=0, atol=1e-14 * 5)
    assert max(around(q[2], -gamma).max(), around(q[3], -eta).max()) < 1e-14
    q = ALPHA_BETA.from_planes(reflect_body(z))
    np.testing.assert_allclose(q[[0, 1, 4, 5, 6, 7]], (be, al, pbe, pal, pg, pe), rtol=0, atol=1e-14 * 5)
    np.testing.assert_allclose(deformation(reflect_space(z)).area, -deformation(z).area, rtol=0, atol=1e-14)


# --- singular sets -----------------------------------------------------------------------------------------------

MOVING = np.array([0.4, -0.7, 0.3, 0.9])
PLANE_CHARTS = [chart for chart in ALL if {"eta", "phi", "Phi"} & set(chart.names)]
SETS = {
    "beta = 0": (1.1, 0.3, 0, 0),
    "beta = 0, alpha < foci": (0.2, 0.1, 0, 0),
    "beta = 0, alpha > foci": (2.1, 2.3, 0, 0),
    "alpha = 0": (0, 0, 0.5, -1.2),
}


@pytest.mark.parametrize("where", SETS)
@pytest.mark.parametrize("chart", PLANE_CHARTS, ids=lambda chart: chart.name)
def test_plane_singular_sets_come_back(chart, where):
    """The angle is that of the motion: momenta and velocities come back; the inverse metric is refused with the
    orbit.
    """
    planes = np.array(SETS[where], dtype=float)
    if where == "alpha = 0" and chart.name in AREA_POSITIVE:
        with pytest.raises(ValueError, match=r"z must avoid det phi = D1 D2 <= 0 and D1 = D2 \(b = 0\) in the"):
            chart.from_planes(np.concatenate([planes, MOVING]))
        return
    z = np.concatenate([planes, MOVING])
    for there, back in (
        (chart.from_planes, chart.to_planes),
        (chart.velocities_from_planes, chart.velocities_to_planes),
    ):
        np.testing.assert_allclose(back(there(z)), z, rtol=0, atol=1e-13)
    q = chart.from_planes(z)
    assert np.isfinite(chart.metric(q[:4])).all()
    assert np.isfinite(chart.jacobian(q[:4])).all()
    assert chart.kinetic_energy_from_momenta(q) == pytest.approx(np.sum(MOVING**2) / 2, rel=1e-12)
    assert chart.kinetic_energy(chart.velocities_from_planes(z)) == pytest.approx(np.sum(MOVING**2) / 2, rel=1e-12)
    np.testing.assert_allclose(chart.velocities_from_momenta(q), chart.velocities_from_planes(z), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    "chart", [c for c in PLANE_CHARTS if c.name not in AREA_POSITIVE], ids=lambda chart: chart.name
)
@pytest.mark.parametrize("zero", ["alpha", "beta"])
def test_what_was_zero_comes_back_zero(chart, zero):
    """Exactly, for any other radius: else an angular momentum of rounding would become a momentum."""
    other = np.exp(np.random.default_rng(4).uniform(-3, 3, 500))
    planes = np.zeros((4, 500))
    planes[2 if zero == "alpha" else 0] = other
    back = chart.points_to_planes(chart.points_from_planes(planes))
    assert not back[:2].any() if zero == "alpha" else not back[2:].any()


def test_density_and_inverse_metric_on_singular_sets():
    """beta = 0 exactly: density 0, the inverse metric refused, the chart, the set and the orbit named."""
    for chart in PLANE_CHARTS:
        q = chart.from_planes(np.stack([grid(chart, 1)[:, 0], np.array([0.2, 0.1, 0, 0, *MOVING])], axis=1))[:4]
        density = chart.density(q)
        assert density[0] > 0
        assert density[1] <= 1e-15
        if density[1] == 0:
            with pytest.raises(
                ValueError, match=rf"q must avoid .* in the {chart.name} chart, got .* at orbit \(1,\)$"
            ):
                chart.inverse_metric(q)


CENTRES = {
    SPHERICAL: [(0, 0, 0.7, 0.2), (0, 0, 0.0, 0.9), (0, 0, 0.0, -0.9), (0, 0, -0.7, 0.2), (0, 0, 0, 0)],
    SPHERICAL_CARTESIAN: [(0, 0, 0.7, 0.2), (0, 0, -0.7, 0.2), (0, 0, 0, 0.3)],
    POLAR_POLAR: [(0, 0, 0.7, 0.2), (0.3, 0.4, 0, 0), (0, 0, 0, 0)],
    CHARTS["polar-Cartesian"]: [(0, 0, 0.7, 0.2)],
}
MOTIONS = [(0.4, -0.7, 0.3, 0.9), (0, 0, 0.3, 0.9), (0.4, 0, 0, 0), (0, 0, 0, 0)]


@pytest.mark.parametrize("chart", CENTRES, ids=lambda chart: chart.name)
def test_centres_of_r4_come_back(chart):
    for matrix in CENTRES[chart]:
        for motion in MOTIONS:
            z = from_matrix(np.reshape(matrix, (2, 2)), np.reshape(motion, (2, 2)))
            np.testing.assert_allclose(chart.to_planes(chart.from_planes(z)), z, rtol=0, atol=1e-15)
            np.testing.assert_allclose(
                chart.velocities_to_planes(chart.velocities_from_planes(z)), z, rtol=0, atol=1e-15
            )


@pytest.mark.parametrize(
    ("chart", "name", "q"),
    [
        (ALPHA_BETA, "p_gamma", [1, 0, 0, 0, 0, 0, 0, 0.3]),
        (ALPHA_BETA, "p_gamma", [1, 1e-320, 0, 0, 0, 0, 0, 0.3]),
        (ALPHA_BETA, "p_eta", [0, 1, 0, 0, 0, 0, 0.3, 0]),
        (TWO_POLAR, "p_gamma", [1, 1, 0, 0, 0, 0, 0.3, 0.3]),
        (TWO_POLAR, "p_eta", [1, -1, 0, 0, 0, 0, 0.3, -0.3]),
        (R_VARTHETA, "p_gamma", [1, 0, 0, 0, 0, 0, 0.3, 0.3]),
        (R_VARTHETA, "p_eta", [1, np.pi, 0, 0, 0, 0, 0.3, -0.3]),
        (R_VARTHETA, "p_vartheta", [0, 1, 0, 0, 0, 0.3, 0, 0]),
        (SPHERICAL, "p_nu", [1, 0, 0, 0, 0, 0, 0, 0.3]),
        (SPHERICAL, "p_nu", [1, 1, np.pi / 2, 0, 0, 0, 0, 0.3]),
        (SPHERICAL, "p_mu", [1, np.pi, 0, 0, 0, 0, 0.3, 0]),
        (SPHERICAL, "p_lambda", [0, 1, 0, 0, 0, 0.3, 0, 0]),
        (SPHERICAL_CARTESIAN, "p_chi", [1, np.pi, 0, 0, 0, 0, 0.3, 0]),
        (POLAR_POLAR, "p_chi2", [1, 0, 0, 0, 0, 0, 0, 0.3]),
        (RHO_EPSILON, "p_epsilon", [0, 1, 0, 0, 0, 0.3, 0, 0]),
        (RHO_VARTHETA, "p_eta", [1, np.pi, 0, 0, 0, 0, 0.3, 0]),
        (EULER, "p_gamma", [1, 0, 0, 0, 0, 0.3, 0, 0]),
        (ELLIPTIC, "p_gamma", [0, 1, 0, 0, 0, 0, 0, 0.3]),
        (ELLIPTIC, "p_eta", [1, np.pi / 2, 0, 0, 0, 0, 0.3, 0]),
        (PARABOLIC, "p_eta", [1, 1, 0, 0, 0, 0, 0.3, 0]),
        (CHARTS["bipolar"], "p_gamma", [1, np.pi, 0, 0, 0, 0, 0, 0.3]),
        (EXPONENTIAL, "p_gamma", [1, 0, 0, 0, 0, 0, 0.3, 0.3]),
    ],
)
def test_infinite_momenta_are_refused(chart, name, q):
    with pytest.raises(ValueError, match=rf"q: {name}.* must be 0 where .* got 0\.3"):
        chart.to_planes(q)
    good = chart.from_planes(grid(chart, 1))[:, 0]
    with pytest.raises(ValueError, match=rf"{name}.* at orbit \(1,\)"):
        chart.to_planes(np.column_stack([good, q]))


def test_focus_of_the_elliptic_chart():
    """The undeformed state: momenta have the limit 0 and do not come back; rates are infinite but at rest."""
    z = np.array([ROOT2, 0, 0, 0, *MOVING])
    q = ELLIPTIC.from_planes(z)
    np.testing.assert_allclose(q, [0, 0, 0, np.arctan2(0.9, 0.3), 0, 0, -0.7 * ROOT2, 0], rtol=0, atol=1e-15)
    with pytest.raises(ValueError, match=r"q must avoid the focus D1 = D2 .* in the elliptic chart"):
        ELLIPTIC.to_planes(q)
    both = np.stack([grid(ELLIPTIC, 1)[:, 0], z], axis=1)
    with pytest.raises(ValueError, match=r"w must avoid the focus .* in the elliptic chart, got .* at orbit \(1,\)"):
        ELLIPTIC.velocities_from_planes(both)
    rest = np.concatenate([z[:4], np.zeros(4)])
    np.testing.assert_array_equal(ELLIPTIC.velocities_to_planes(ELLIPTIC.velocities_from_planes(rest)), rest)
    np.testing.assert_array_equal(ELLIPTIC.metric(q[:4])[:2, :2], 0)
    near = np.array([ROOT2 + 1e-8, 0, 1e-8, 0, *MOVING])  # the loss is sqrt(focus/distance): 1e4 units of rounding
    np.testing.assert_allclose(ELLIPTIC.to_planes(ELLIPTIC.from_planes(near)), near, rtol=0, atol=1e-11)


def test_focus_of_the_parabolic_chart():
    z = np.array([0, 0, 0, 0, *MOVING])
    q = PARABOLIC.from_planes(z)
    np.testing.assert_array_equal(q[[0, 1, 4, 5, 6, 7]], 0)
    with pytest.raises(ValueError, match=r"q must avoid the focus .* in the parabolic chart"):
        PARABOLIC.to_planes(q)
    with pytest.raises(ValueError, match=r"w must avoid the focus .* in the parabolic chart"):
        PARABOLIC.velocities_from_planes(z)


def test_poles_of_the_bipolar_chart():
    chart = CHARTS["bipolar"]
    poles = np.stack([grid(chart, 1)[:, 0], np.array([0, 1.0, 0, 0, *MOVING])], axis=1)
    for convert in (chart.from_planes, chart.velocities_from_planes):
        with pytest.raises(
            ValueError, match=r"[zw] must avoid alpha = c, beta = 0 .* in the bipolar chart, got .* at orbit \(1,\)"
        ):
            convert(poles)
    with pytest.raises(ValueError, match=r"q must avoid .* infinity .* in the bipolar chart"):
        chart.points_to_planes([0, 0, 0, 0])
    near = np.array([0, 1 + 1e-9, 1e-9, 0, *MOVING])
    np.testing.assert_allclose(chart.to_planes(chart.from_planes(near)), near, rtol=0, atol=1e-14 * 10)


@pytest.mark.parametrize("chart", [EXPONENTIAL, DELTA_B], ids=lambda chart: chart.name)
@pytest.mark.parametrize(
    "planes", [(0.5, 0, 0, 1.2), (0.5, 0, 0.5, 0), (0, 0, 0, 0)], ids=["det < 0", "det = 0", "phi = 0"]
)
def test_exponential_charts_need_positive_area(chart, planes):
    """D2 = 0 in the second: refused, also for what lies beside it."""
    both = np.stack([grid(chart, 1)[:, 0], np.array([*planes, *MOVING])], axis=1)
    for convert in (chart.from_planes, chart.velocities_from_planes):
        with pytest.raises(ValueError, match=r"[zw] must avoid det phi = D1 D2 <= 0 .* at orbit \(1,\)"):
            convert(both)


def test_outside_of_a_chart():
    with pytest.raises(
        ValueError, match=r"q: delta = sqrt\(D1 D2\) must be positive; got delta = -1\.0 at orbit \(1,\)"
    ):
        DELTA_B.to_planes(np.array([[1.0, -1.0]] + [[0.5, 0.5]] * 7))
    for method in (DELTA_B.metric, DELTA_B.points_to_planes, DELTA_B.jacobian):
        with pytest.raises(ValueError, match="must be positive; got delta = 0"):
            method([0, 1, 0, 0])
    for method in (R_VARTHETA.metric, R_VARTHETA.jacobian):
        with pytest.raises(ValueError, match=r"must avoid r = 0 .* in the r-vartheta chart"):
            method([0, 1, 0, 0])
    with pytest.raises(ValueError, match=r"must avoid .* in the r-vartheta chart"):
        R_VARTHETA.velocities_to_planes([0, 1, 0, 0, 0, 0, 0, 0])
    at_centre = R_VARTHETA.velocities_from_planes([0, 0, 0, 0, 3, 0, 0, -3])
    np.testing.assert_allclose(at_centre, [0, np.pi / 2, 3 * np.pi / 4, 3 * np.pi / 4, 0, 0, 0, 0], rtol=1e-15)
    with pytest.raises(ValueError, match=r"must avoid .* in the exponential chart"):
        EXPONENTIAL.points_to_planes([2000.0, 0, 0, 0])  # e^a overflows


def test_centre_of_the_concentric_charts():
    """rho and epsilon come back through the centre, where r-vartheta cannot."""
    z = [0, 0, 0, 0, 3, 0, 0, -3]
    for chart in (RHO_EPSILON, RHO_VARTHETA, EULER):
        np.testing.assert_allclose(chart.to_planes(chart.from_planes(z)), z, rtol=0, atol=1e-14)
        np.testing.assert_allclose(chart.velocities_to_planes(chart.velocities_from_planes(z)), z, rtol=0, atol=1e-14)
    assert RHO_EPSILON.from_planes(z)[4] == pytest.approx(np.sqrt(18), rel=1e-15)


def test_velocities_are_limits():
    """Along a straight motion through beta = 0 the rates at the singular point are those of both sides."""
    w = np.array([1.1, 0.3, 0, 0, *MOVING])
    at = ALPHA_BETA.velocities_from_planes(w)
    assert at[7] == 0
    for t in (1e-7, -1e-7):
        beside = w.copy()
        beside[:4] += t * MOVING
        q = ALPHA_BETA.velocities_from_planes(beside)
        assert q[5] == pytest.approx(np.sign(t) * at[5], rel=1e-14)
        assert abs(q[7]) * 1e-7 < 1e-14


# --- invariants, input -------------------------------------------------------------------------------------------


def test_names_of_the_invariants():
    """EQ2.2x-EQ2.2z and the exponential variables, from det and trace of the matrix alone."""
    z = grid(EXPONENTIAL)
    phi = np.moveaxis(to_matrix(z)[0], -1, 0)
    d, det, size = deformation(z), np.linalg.det(phi), np.sum(phi**2, axis=(1, 2))
    for value, expected in (
        (d.r, size),
        (d.rho**2, size),
        (d.area, det),
        (d.shear**2, size**2 - 4 * det**2),
        (d.r, 2 * d.area / np.cos(d.vartheta)),
        (np.tan(d.vartheta), (d.D1 / d.D2 - d.D2 / d.D1) / 2),
        (2 * d.epsilon, d.vartheta),
        (d.delta**2, det),
        (np.exp(d.a), det),
        (d.r, 2 * np.exp(d.a) * np.cosh(d.b)),
        (d.shear, 2 * np.exp(d.a) * np.sinh(d.b)),
        (d.D1 / d.D2, np.exp(d.b)),
        (np.sin(d.vartheta), np.tanh(d.b)),
        (np.cos(d.vartheta), 1 / np.cosh(d.b)),
        (np.tan(d.vartheta), np.sinh(d.b)),
        (vartheta_of_b(d.b), d.vartheta),
        (b_of_vartheta(d.vartheta), d.b),
        (d.alpha, ROOT2 * d.delta * np.cosh(d.b / 2)),
        (d.beta, ROOT2 * d.delta * np.sinh(d.b / 2)),
    ):
        np.testing.assert_allclose(value, expected, rtol=1e-11)
    k, lam = ELLIPTIC.from_planes(z)[:2]
    np.testing.assert_allclose(d.area, (1 + np.cosh(2 * k) * np.cos(2 * lam)) / 2, rtol=1e-12)
    np.testing.assert_allclose(d.r, np.cosh(2 * k) + np.cos(2 * lam), rtol=1e-12)
    with pytest.raises(ValueError, match=r"need det phi = D1 D2 > 0; got D2 = -.* at orbit \(1,\)"):
        _ = deformation(np.column_stack([z[:, 0], reflect_space(z)[:, 0]])).b


@given(b=st.floats(-30, 30))
def test_gudermannian(b):
    """sinh(30) = 5e12, so vartheta stands 2e-13 from pi/2 and knows b to 1e-3 only; the sine and cosine are exact."""
    vartheta = vartheta_of_b(b)
    assert np.cos(vartheta) == pytest.approx(1 / np.cosh(b), abs=1e-15)
    assert np.sin(vartheta) == pytest.approx(np.tanh(b), abs=1e-15)
    assert b_of_vartheta(vartheta) == pytest.approx(b, abs=4e-16 * np.cosh(b))


def test_gudermannian_ends():
    with pytest.raises(ValueError, match=r"vartheta must lie in \(-pi/2, pi/2\).* got 1\.57.* at orbit \(1,\)"):
        b_of_vartheta([0.0, np.pi / 2])


def test_scales():
    """elliptic(f) is elliptic(1) of phi/f, and so for bipolar."""
    z = grid(ELLIPTIC)
    for build in (elliptic, bipolar):
        scaled = z * np.array([[0.4]] * 4 + [[1.0]] * 4)
        np.testing.assert_allclose(
            build(0.4).points_from_planes(scaled[:4]), build(1).points_from_planes(z[:4]), rtol=0, atol=1e-13
        )
        np.testing.assert_allclose(
            build(0.4).metric([0.3, 0.4, 0, 0]), 0.16 * build(1.0).metric([0.3, 0.4, 0, 0]), rtol=1e-14
        )
        for bad, error in (
            (0.0, ValueError),
            (-1.0, ValueError),
            (np.inf, ValueError),
            ("1", TypeError),
            (None, TypeError),
        ):
            with pytest.raises(error, match=r"must be .*got"):
                build(bad)


@every_chart
def test_bad_input_is_named(chart):
    for method, name, rows in (
        (chart.velocities_from_planes, "w", 8),
        (chart.velocities_to_planes, "q", 8),
        (chart.points_from_planes, "planes", 4),
        (chart.points_to_planes, "q", 4),
        (chart.metric, "q", 4),
        (chart.inverse_metric, "q", 4),
        (chart.density, "q", 4),
        (chart.jacobian, "q", 4),
        (chart.kinetic_energy, "q", 8),
        (chart.kinetic_energy_from_momenta, "q", 8),
        (chart.momenta_from_velocities, "q", 8),
        (chart.velocities_from_momenta, "q", 8),
    ):
        with pytest.raises(
            ValueError, match=rf"{name} must be finite real numbers of shape \({rows}, ...\), got shape \(3,\)"
        ):
            method(np.ones(3))
        with pytest.raises(ValueError, match=rf"{name} must be .* got nan"):
            method(np.full(rows, np.nan))
        with pytest.raises(TypeError, match=f"{name} must be"):
            method(np.ones(rows, complex))
    for mu, error in ((0.0, ValueError), (np.nan, ValueError), ("1", TypeError)):
        with pytest.raises(error, match="mu must be"):
            chart.kinetic_energy(np.ones(8), mu)


def test_charts_are_values():
    assert isinstance(ELLIPTIC, Chart)
    assert ELLIPTIC.momenta == ("p_kappa", "p_lambda", "p_eta", "p_gamma")
    assert {ALPHA_BETA: 1}[ALPHA_BETA] == 1


@every_chart
def test_charts_travel_to_other_processes(chart):
    q = chart.from_planes(grid(chart))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(chart)).from_planes(grid(chart)), q)
