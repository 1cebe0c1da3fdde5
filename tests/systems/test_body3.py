"""The body in space: forces, exact motions, the two-polar form, ellipsoids of equilibrium, and wrong input."""

import pickle
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

import fastaff as fa
from fastaff.systems.formulas.space_formula import formula3
from fastaff.systems.models import (
    Body3,
    GasCloud,
    MooneyRivlin3,
    NeoHookean3,
    Ogden3,
    SelfGravity,
    Sum3,
    reduced_body3,
    relative_equilibrium,
    riemann_ellipsoid,
)
from fastaff.systems.models.equilibria3 import _residual
from fastaff.systems.models.matrix_potentials import of_invariants

RANDOM = np.random.default_rng(20)
POTENTIALS = (
    GasCloud(1.2, 1.4, 0.8),
    NeoHookean3(1.1, 2.3),
    MooneyRivlin3(0.4, 0.2, 1.5),
    Ogden3(),
    SelfGravity(1.3),
    Sum3(SelfGravity(0.7), Ogden3(K=1.1)),
    formula3("c*sqrt(I2) + I1*J + k*I3**-p", c=0.6, k=0.3, p=0.7),
    formula3("D1*D2 + D2*D3 + D3*D1 + exp(-s*(D1 + D2 + D3)) - log(J)", s=0.4),
)
NAMES = [type(potential).__name__ for potential in POTENTIALS]
STAR = Body3(Sum3(SelfGravity(1.7), GasCloud(0.3, 2.2, 0.0)), 0.6)


def rotation():
    """A random rotation."""
    Q, _ = np.linalg.qr(RANDOM.normal(size=(3, 3)))
    return Q * np.sign(np.linalg.det(Q))


def placed(*stretches):
    """A matrix with these stretches and random principal axes, row by row."""
    return (rotation() @ np.diag(stretches) @ rotation()).ravel()


def starts(orbits, spread=0.2, speed=0.3):
    """Random phase points around the undeformed body."""
    q = np.eye(3).reshape(9, 1) + spread * RANDOM.uniform(-1, 1, (9, orbits))
    return np.concatenate([q, speed * RANDOM.uniform(-1, 1, (9, orbits))])


def squared_frequency(steady):
    """Omega^2/(pi G rho) of an ellipsoid of STAR: pi G rho = k/(4 mu J)."""
    return 4 * STAR.mu * steady.D.prod() * steady.omega[2] ** 2 / STAR.potential.first.k


# Forces


@pytest.mark.parametrize("potential", POTENTIALS, ids=NAMES)
@pytest.mark.parametrize("stretches", [(1.4, 0.9, 0.6), (1.1, 1.1, 0.8), (0.9, 0.9, 0.9), (1.1, 1.1 + 1e-7, 0.7)])
def test_slopes_and_changes_are_derivatives_also_where_stretches_coincide(potential, stretches):
    q = placed(*stretches)
    h = 2e-3

    def difference(function, d):
        at = [np.array(function(*(q + k * h * d))) for k in (-2, -1, 1, 2)]
        return (8 * (at[2] - at[1]) - (at[3] - at[0])) / (12 * h)

    slopes = np.array(potential.matrix_slopes(*q))
    expected = np.array([difference(potential.matrix_value, unit) for unit in np.eye(9)])
    assert np.abs(slopes - expected).max() < 1e-8 * np.abs(expected).max()
    d = RANDOM.normal(size=9)
    expected = difference(potential.matrix_slopes, d)
    assert np.abs(np.array(potential.matrix_changes(*q, *d)) - expected).max() < 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize("potential", POTENTIALS, ids=NAMES)
def test_matrices_and_stretches_give_the_same_numbers(potential):
    D = RANDOM.uniform(0.6, 1.5, 3)
    L, R = rotation(), rotation()
    q = (L @ np.diag(D) @ R.T).ravel()
    assert np.isclose(potential.matrix_value(*q), potential.stretch_value(*D), rtol=1e-13)
    gradient = L.T @ np.reshape(potential.matrix_slopes(*q), (3, 3)) @ R
    assert np.abs(gradient - np.diag(potential.stretch_slopes(*D))).max() < 1e-13
    d = RANDOM.normal(size=3)
    change = L.T @ np.reshape(potential.matrix_changes(*q, *(L @ np.diag(d) @ R.T).ravel()), (3, 3)) @ R
    assert np.abs(change - np.diag(potential.stretch_changes(*D, *d))).max() < 1e-12
    assert potential.matrix_margin(*q) > 0
    assert potential.stretch_margin(*D) > 0


@pytest.mark.parametrize("ratio", [1.0, 10.0, 1000.0])
def test_gravity_is_carlsons_integral(ratio):
    """Against SciPy's R_F and R_D, to rounding for all axes."""
    for _ in range(20):
        D = ratio ** RANDOM.uniform(-0.5, 0.5, 3)
        k = RANDOM.uniform(0.5, 2.0)
        gravity = SelfGravity(k)
        x = D * D
        assert np.isclose(gravity.stretch_value(*D), -k * elliprf(*x), rtol=1e-14)
        slopes = [k / 3 * D[i] * elliprd(x[i - 1], x[i - 2], x[i]) for i in range(3)]
        assert np.allclose(gravity.stretch_slopes(*D), slopes, rtol=1e-14)
        # Euler: the slopes in I1, I2 and J have the degrees -3/2, -5/2 and -2 in the squared axes.
        at = x.sum(), x[0] * x[1] + x[1] * x[2] + x[2] * x[0], D.prod()
        changes = gravity.changes(*at, at[0], 2 * at[1], 1.5 * at[2])
        assert np.allclose(changes, np.array([-1.5, -2.5, -2.0]) * gravity.slopes(*at), rtol=1e-13)


def test_formulas_equal_named_potentials():
    q = np.eye(3).ravel() + 0.3 * RANDOM.uniform(-1, 1, 9)
    d = RANDOM.normal(size=9)
    gas = GasCloud(1.2, 1.4, 0.8)
    for text in ("C*I1/2 + k*J**(1 - g)/(g - 1)", "C*(D1**2 + D2**2 + D3**2)/2 + k*(D1*D2*D3)**(1 - g)/(g - 1)"):
        potential = formula3(text, C=0.8, k=1.2, g=1.4)
        assert np.isclose(potential.matrix_value(*q), gas.matrix_value(*q), rtol=1e-14)
        assert np.allclose(potential.matrix_slopes(*q), gas.matrix_slopes(*q), rtol=0, atol=1e-13)
        assert np.allclose(potential.matrix_changes(*q, *d), gas.matrix_changes(*q, *d), rtol=0, atol=1e-12)
        assert potential.formula == text
    everywhere = formula3("I1**2 + I2")
    assert everywhere.matrix_margin(*-q) > 0
    assert formula3("I1 + J**2").matrix_margin(*-q) < 0


# Motions


def test_squared_radius_of_a_gas_with_three_degrees_of_freedom_oscillates_harmonically():
    """gamma = 5/3 at random spin and vorticity: R^2 = a + b cos(2 w t + c), and error estimates cover."""
    k, C, mu = RANDOM.uniform(0.5, 2.0, 3)
    cloud = Body3(GasCloud(k, 5 / 3, C), mu)
    z0 = starts(12)
    run = fa.integrate(cloud, z0, time=30.0, samples=60, accuracy=1e-10)
    q, p = z0[:9], z0[9:]
    w = 2 * np.sqrt(C / mu)
    H = cloud.kinetic_energy(*p) + cloud.potential_energy(*q)
    middle = H / C  # mu R^2'' = 4 (H - C R^2) by the virial theorem
    first, rate = (q * q).sum(axis=0) - middle, 2 * (q * p).sum(axis=0) / mu / w
    t = run.times[:, None]
    expected = middle + first * np.cos(w * t) + rate * np.sin(w * t)
    found = (run.samples[:, :9] ** 2).sum(axis=1)
    allowed = 2 * (np.abs(run.samples[:, :9]) * run.sample_error[:, :9]).sum(axis=1)
    assert np.abs(found - expected).max() < 1e-9
    assert np.mean(np.abs(found - expected) <= allowed + 1e-14) > 0.99
    for before, after in zip(*(fa.constants_of_motion(cloud, z).values() for z in (z0, run.z)), strict=True):
        assert np.abs(after - before).max() < 1e-10


def test_the_radius_of_a_monatomic_cloud_separates():
    """h = (R^2 |p|^2 - (q.p)^2)/2 mu + R^2 (V - C R^2/2) is conserved for gamma = 5/3 alone."""
    z0 = starts(6)
    changes = []
    for gamma in (5 / 3, 1.4):
        cloud = Body3(GasCloud(0.8, gamma, 1.3), 0.7)
        values = []
        for z in (z0, fa.integrate(cloud, z0, time=20.0, accuracy=1e-11).z):
            q, p = z[:9], z[9:]
            R2 = (q * q).sum(axis=0)
            turning = R2 * (p * p).sum(axis=0) - (q * p).sum(axis=0) ** 2
            values.append(turning / (2 * cloud.mu) + R2 * (cloud.potential_energy(*q) - 1.3 * R2 / 2))
        changes.append(np.abs(values[1] - values[0]).max())
    assert changes[0] < 1e-9
    assert changes[1] > 1e-3


def test_spheroids_stay_spheroids():
    """D1 = D2 is an invariant plane to the last bit, so that its sections are planes too."""
    cloud = reduced_body3(Body3(GasCloud(gamma=3.0)), spin=0.2, vorticity=-0.2)
    run = fa.integrate(cloud, [1.3, 1.3, 0.8, 0.2, 0.2, 0.4], time=100.0)
    assert run.z[0, 0] == run.z[1, 0]
    assert run.z[3, 0] == run.z[4, 0]


def test_another_gas_does_not():
    cloud = Body3(GasCloud(1.0, 1.4, 1.0))
    run = fa.integrate(cloud, starts(1), time=20.0, samples=200)
    R2 = (run.samples[:, :9, 0] ** 2).sum(axis=1)
    basis = np.stack([np.ones_like(run.times), np.cos(2 * run.times), np.sin(2 * run.times)], axis=1)
    assert np.abs(basis @ np.linalg.lstsq(basis, R2, rcond=None)[0] - R2).max() > 1e-3


def test_a_planar_motion_is_that_of_the_planar_body():
    """V = sum of g(D_i): the third axis rests at D3 = 1, and the first two are a planar body."""
    material = Ogden3(0.6, 1.3, -0.1, -2.0, K=0.0)
    planar = fa.affine_body(
        "m/a*(D1**a + D2**a - 2) + n/b*(D1**b + D2**b - 2) - (m + n)*log(D1*D2)", m=0.6, a=1.3, n=-0.1, b=-2.0
    )
    flat = np.eye(2)[:, :, None] + RANDOM.uniform(-0.3, 0.3, (2, 2, 4))
    momenta = RANDOM.uniform(-0.3, 0.3, (2, 2, 4))
    phi, p = np.zeros((2, 3, 3, 4))
    phi[:2, :2], phi[2, 2], p[:2, :2] = flat, 1.0, momenta
    options = {"time": 20.0, "step": 0.01, "scheme": fa.BLANES_MOAN6}
    space = fa.integrate(Body3(material), np.concatenate([phi, p]).reshape(18, 4), **options)
    plane = fa.integrate(planar, fa.charts.from_matrix(flat, momenta), **options)
    phi, p = space.z.reshape(2, 3, 3, 4)
    expected = fa.charts.to_matrix(plane.z)
    assert np.abs(phi[:2, :2] - expected[0]).max() < 1e-12
    assert np.abs(p[:2, :2] - expected[1]).max() < 1e-12
    assert np.abs(phi[2] - np.array([0.0, 0.0, 1.0])[:, None]).max() < 1e-13


def test_neo_hookean_materials_agree_at_unit_thickness():
    flat = np.eye(2) + RANDOM.uniform(-0.3, 0.3, (2, 2))
    z = fa.charts.from_matrix(flat, 0 * flat)[:4]
    phi = np.eye(3)
    phi[:2, :2] = flat
    assert np.isclose(
        Body3(NeoHookean3(1.3, 2.1)).potential_energy(*phi.ravel()),
        fa.Body(fa.NeoHookean(1.3, 2.1)).potential_energy(*z),
        rtol=1e-13,
    )


def test_transposition_exchanges_spin_and_vorticity():
    """Dedekind's theorem: the transposed orbit is an orbit."""
    z0 = starts(3)
    transposed = z0.reshape(2, 3, 3, 3).transpose(0, 2, 1, 3).reshape(18, 3)
    options = {"time": 10.0, "step": 0.02, "scheme": fa.BLANES_MOAN6}
    one, other = (fa.integrate(STAR, z, **options).z for z in (z0, transposed))
    assert np.abs(one.reshape(2, 3, 3, 3).transpose(0, 2, 1, 3).reshape(18, 3) - other).max() < 1e-12
    forms = [fa.charts.two_polar3(z) for z in (z0, transposed)]
    assert np.allclose(forms[0].spin, forms[1].vorticity, rtol=0, atol=1e-15)


def test_units_do_not_matter():
    """Length 3, mass 2, time 5 in other units: GasCloud scales with k and C."""
    L, M, T = 3.0, 2.0, 5.0
    E = M * L * L / T**2
    z0 = starts(2)
    one = fa.integrate(Body3(GasCloud(0.7, 1.5, 0.9), 1.1), z0, time=10.0)
    scaled = Body3(GasCloud(0.7 * E * L**1.5, 1.5, 0.9 * E / L**2), 1.1 * M)
    other = fa.integrate(scaled, np.concatenate([z0[:9] * L, z0[9:] * M * L / T]), time=10.0 * T)
    assert np.allclose(other.z[:9] / L, one.z[:9], rtol=0, atol=1e-9)


def test_reduced_bodies_move_as_bodies():
    for spin, vorticity in ((0.3, 0.1), (0.0, 0.0), (0.2, -0.2)):
        reduced = reduced_body3(STAR, spin=spin, vorticity=vorticity)
        z = np.array([1.2, 0.8, 0.9, 0.1, 0.2, -0.1])
        whole = reduced.to_matrix(z, phi=0.3, psi=0.4)
        form = fa.charts.two_polar3(whole)
        assert np.allclose(form.spin, [0, 0, spin], rtol=0, atol=1e-14)
        assert np.allclose(form.vorticity, [0, 0, vorticity], rtol=0, atol=1e-14)
        energy = STAR.kinetic_energy(*whole[9:]) + STAR.potential_energy(*whole[:9])
        assert np.isclose(reduced.kinetic_energy(*z[3:]) + reduced.potential_energy(*z[:3]), energy, rtol=1e-14)
        h, d = 1e-5, RANDOM.normal(size=3)
        change = (np.array(reduced.force(*(z[:3] + h * d))) - reduced.force(*(z[:3] - h * d))) / (2 * h)
        assert np.allclose(reduced.tangent_force(*z[:3], *d), change, rtol=1e-7)
        ends = fa.integrate(reduced, z, time=5.0).z, fa.integrate(STAR, whole, time=5.0).z
        assert np.allclose(np.sort(ends[0][:3, 0]), np.sort(fa.charts.two_polar3(ends[1]).D[:, 0]), rtol=0, atol=1e-10)


def test_a_body_without_rotation_stays_diagonal():
    phi, p = np.diag([1.2, 0.9, 0.8]), np.diag([0.1, -0.2, 0.3])
    end = fa.integrate(STAR, np.concatenate([phi.ravel(), p.ravel()]), time=10.0).z[:, 0].reshape(2, 3, 3)
    assert not (end * (1 - np.eye(3))).any()
    reduced = fa.integrate(reduced_body3(STAR), [1.2, 0.9, 0.8, 0.1, -0.2, 0.3], time=10.0)
    assert np.allclose(np.diag(end[0]), reduced.z[:3, 0], rtol=0, atol=1e-11)


def test_sections_frequencies_and_chaos():
    """Small vibrations of a spherical gas cloud: frequencies sqrt(4 C/mu) twice, sqrt((3 gamma - 1) C/mu)."""
    cloud = reduced_body3(Body3(GasCloud(1.0, 1.4, 1.0)))
    z = np.array([[1.0, 1.0], [1.0, 1.0], [1.0, 1.0], [1e-4, 1e-4], [1e-4, -1e-4], [1e-4, 0.0]])
    nu = fa.frequency_map(cloud, z, time=200.0)
    rates = 2 * np.pi * nu.dominant
    assert np.allclose(rates[:, 0], np.sqrt(3 * 1.4 - 1), rtol=1e-5)
    assert np.allclose(rates[:2, 1], np.sqrt(2.0), rtol=1e-5)
    sample = fa.energy_sample(cloud, energy=5.0, section="D1=1", orbits=4, seed=1)
    cut = fa.poincare_map(cloud, sample.z0, section="D1=1", crossings=5, max_time=200.0)
    assert np.abs(cut["D1"] - 1).max() < 1e-12
    regular = np.array([[1.2, 1.0, 1.1, 0.0, 0.0, 0.1], [1.0, 0.8, 1.0, 0.0, 0.2, 0.0]]).T
    assert fa.chaos_map(cloud, regular, time=500.0).regular.all()
    whole = fa.poincare_map(Body3(GasCloud()), starts(2), section="x2=0", crossings=3, max_time=200.0)
    assert np.abs(whole["x2"]).max() < 1e-12


def test_orbits_that_collapse_get_a_status():
    run = fa.integrate(Body3(SelfGravity()), starts(2, speed=0.0), time=20.0)
    assert (run.status == fa.Status.OUT_OF_DOMAIN).all()


# The two-polar form


def test_two_polar_form_and_back():
    z = RANDOM.normal(size=(18, 40))
    form = fa.charts.two_polar3(z)
    assert (np.diff(form.D, axis=0) <= 0).all()
    assert (form.D[1] >= np.abs(form.D[2])).all()
    determinants = np.linalg.det(np.moveaxis(z[:9].reshape(3, 3, 40), 2, 0))
    assert (np.sign(form.D[2]) == np.sign(determinants)).all()
    for rotated in (form.L, form.R):
        assert np.allclose(np.linalg.det(np.moveaxis(rotated, 2, 0)), 1.0)
    assert np.abs(fa.charts.from_two_polar3(*form) - z).max() < 1e-11
    flat = np.zeros((2, 3, 3))
    flat[:, :2, :2], flat[0, 2, 2] = RANDOM.normal(size=(2, 2, 2)), 1.0
    plane = fa.charts.angular_momenta(fa.charts.from_matrix(flat[0, :2, :2], flat[1, :2, :2]))
    form = fa.charts.two_polar3(flat.reshape(18))
    assert np.isclose(form.spin[2], plane.p_phi)
    assert np.isclose(form.vorticity[2], plane.p_psi)


# Ellipsoids of equilibrium. Source of the figures of equilibrium: Chandrasekhar 1969, Ellipsoidal Figures of
# Equilibrium; the numbers follow here from closed forms and root finding in 30 digits.


def spheroid(e):
    """Maclaurin spheroid of this eccentricity."""
    return riemann_ellipsoid(STAR, 1.0, np.sqrt(1 - e * e))


def test_maclaurin_spheroids():
    for e in RANDOM.uniform(0.2, 0.99, 4):
        closed = 2 * np.sqrt(1 - e * e) / e**3 * (3 - 2 * e * e) * np.arcsin(e) - 6 * (1 - e * e) / e**2
        assert np.isclose(squared_frequency(spheroid(e)), closed, rtol=1e-11)


def test_jacobi_ellipsoids_begin_on_the_maclaurin_sequence():
    def distance(e):
        D = spheroid(e).D
        V_1, V_2, _ = STAR.potential.stretch_slopes(*D)
        return STAR.potential.stretch_changes(*D, 1.0, -1.0, 0.0)[0] - (V_1 + V_2) / (D[0] + D[1])

    e = brentq(distance, 0.7, 0.9, xtol=1e-14)
    assert abs(e - 0.812670010611742950) < 1e-12
    assert abs(squared_frequency(spheroid(e)) - 0.374229674786195634) < 1e-12
    assert spheroid(e - 1e-3).stable


def test_a_jacobi_ellipsoid():
    jacobi = riemann_ellipsoid(STAR, 0.8)
    assert abs(jacobi.D[2] / jacobi.D[0] - 0.517216058580115093) < 1e-13
    assert abs(squared_frequency(jacobi) - 0.366837036679417374) < 1e-13
    assert np.abs(jacobi.circulation).max() < 1e-7
    assert jacobi.stable
    run = fa.integrate(STAR, jacobi.z0, time=20.0)
    assert np.abs(np.sort(fa.charts.two_polar3(run.z).D[:, 0]) - np.sort(jacobi.D)).max() < 1e-10


def test_maclaurin_spheroids_become_unstable():
    """The two bar modes meet: the square of their distance passes through 0."""

    def distance(e):
        exponents = spheroid(e).exponents
        if exponents.real.max() > 1e-6:
            return -4 * exponents.real.max() ** 2
        rates = np.sort(exponents.imag[exponents.imag > 0.05])
        return np.diff(rates).min() ** 2

    e = brentq(distance, 0.9525, 0.9535, xtol=1e-13)
    assert abs(e - 0.952886702034253892) < 1e-8
    assert spheroid(0.952).stable
    assert not spheroid(0.954).stable


def test_riemann_ellipsoids_and_their_adjoints():
    steady = riemann_ellipsoid(STAR, 0.7, 0.6)
    assert steady.omega[2] > steady.circulation[2] > 0.01
    for one in (steady, steady.adjoint):
        residual, scale = _residual(STAR, one.D, one.omega, one.circulation)
        assert np.abs(residual).max() < 1e-13 * scale
        run = fa.integrate(STAR, one.z0, time=10.0)
        assert np.abs(np.sort(fa.charts.two_polar3(run.z).D[:, 0]) - np.sort(one.D)).max() < 1e-10
    forms = [fa.charts.two_polar3(one.z0) for one in (steady, steady.adjoint)]
    assert np.allclose(forms[0].spin, forms[1].vorticity, rtol=0, atol=1e-14)


def test_bodies_at_rest_are_steady():
    """All forces vanish at rest: what counts as zero is relative to the stiffness."""
    for _ in range(20):
        k, pressure, mu, G, K = np.exp(3 * RANDOM.normal(size=5))
        gamma = 4 / 3 + RANDOM.uniform(0.1, 2)
        star = Body3(Sum3(SelfGravity(k), GasCloud(pressure, gamma, 0.0)), mu)
        sphere = riemann_ellipsoid(star, 1.0, 1.0)
        assert np.allclose(sphere.D, (3 * pressure / k) ** (1 / (3 * gamma - 4)), rtol=1e-12)
        assert not sphere.omega.any()
        assert not sphere.circulation.any()
        guess = RANDOM.uniform(0.9, 1.1, 3)
        assert np.allclose(relative_equilibrium(star, sphere.D * guess, np.zeros(3)).D, sphere.D, rtol=1e-9)
        solid = relative_equilibrium(Body3(NeoHookean3(G, K), mu), guess, np.zeros(3))
        assert np.allclose(solid.D, 1.0, rtol=0, atol=1e-9)


def test_ellipsoids_of_almost_equal_axes():
    """Rates are smooth functions of the axes: nothing cancels near a2 = 1."""
    near = [riemann_ellipsoid(STAR, 1 - d, 0.5) for d in (1e-3, 1e-9, 1e-14)]
    rates = np.array([(one.omega[2], one.circulation[2]) for one in near])
    assert np.allclose(rates[2], rates[1], rtol=1e-7)
    assert np.allclose(rates[1], rates[0], rtol=0.01)
    jacobi = riemann_ellipsoid(STAR, 1 - 1e-13)
    assert np.isclose(jacobi.D[2] / jacobi.D[0], np.sqrt(1 - 0.81267**2), rtol=0, atol=1e-5)
    assert np.abs(jacobi.circulation).max() < 1e-12


@pytest.mark.parametrize("found_from", range(3))
def test_tilted_steady_motions(found_from):
    """Riemann's ellipsoids of types I to III rotate about no principal axis, nor does their circulation."""
    D, omega, circulation = (
        ([0.82, 0.60, 1.04], [0.0, -0.81, 0.92], [0.0, -0.78, 0.86]),
        ([1.24, 1.74, 0.46], [0.0, 0.78, 0.68], [0.0, 0.30, 0.51]),
        ([1.65, 1.78, 0.483], [0.0, 0.391, 0.855], [0.0, 0.082, 0.476]),
    )[found_from]
    steady = relative_equilibrium(STAR, D, omega, circulation)
    assert np.abs(steady.omega[1:]).min() > 0.05
    assert np.abs(steady.omega[0]) < 1e-9
    for one in (steady, steady.adjoint):
        run = fa.integrate(STAR, one.z0, time=5.0)
        assert np.abs(np.sort(fa.charts.two_polar3(run.z).D[:, 0]) - np.sort(steady.D)).max() < 1e-9


def test_growth_rates_are_those_of_orbits():
    """An unstable spheroid: a small deviation grows at the predicted rate."""
    steady = spheroid(0.97)
    z = steady.z0 + 1e-7 * RANDOM.normal(size=18)
    samples = fa.integrate(STAR, z, time=60.0, samples=240, accuracy=1e-12)
    D = fa.charts.two_polar3(samples.samples[:, :, 0].T).D
    late = samples.times > 30.0
    slope = np.polyfit(samples.times[late], np.log(D[0, late] - D[1, late]), 1)[0]
    assert np.isclose(slope, steady.growth, rtol=1e-3)


# Use in the package


@of_invariants
class Shear(NamedTuple):
    """A user's potential, G (I1/2 - ln J)."""

    G: float = 1.0

    def value(self, I1, I2, J):
        return self.G * (I1 / 2 - np.log(J))

    def slopes(self, I1, I2, J):
        return self.G / 2 + 0.0 * I1, 0.0 * I2, -self.G / J

    def changes(self, I1, I2, J, dI1, dI2, dJ):
        return 0.0 * dI1, 0.0 * dI2, self.G / (J * J) * dJ

    def margin(self, I1, I2, J):
        return J + 0.0 * I1


def test_potentials_of_users():
    z0 = starts(2)
    own = fa.integrate(Body3(Shear(1.4)), z0, time=5.0, accuracy=1e-11)
    assert np.allclose(own.z, fa.integrate(Body3(NeoHookean3(1.4, 0.0)), z0, time=5.0, accuracy=1e-11).z, atol=1e-9)


@pytest.mark.parametrize("potential", [STAR.potential, POTENTIALS[-2], POTENTIALS[-1]])
def test_files_keep_models(potential, tmp_path):
    model = Body3(potential, 0.6)
    assert pickle.loads(pickle.dumps(model)) == model
    path = fa.save(tmp_path / "run", fa.integrate(model, starts(1), time=0.5))
    assert fa.files.recipe(path).arguments["model"] == model


# Wrong input


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: Body3(fa.NeoHookean()), TypeError, "potential must be a potential of 3x3 matrices"),
        (lambda: Body3(Sum3(GasCloud(), fa.NeoHookean())), TypeError, "potential must be a potential of 3x3 matrices"),
        (lambda: GasCloud(gamma=1), ValueError, "gamma must differ from 1, got 1"),
        (lambda: fa.Body(GasCloud()), TypeError, "Use fa.models.Body3"),
        (lambda: fa.integrate(GasCloud(), np.ones(18), time=1.0), TypeError, "Use fa.models.Body3"),
        (lambda: fa.integrate(Body3(GasCloud()), -starts(1), time=1.0), ValueError, "det phi > 0"),
        (lambda: formula3("D1 + 2*D2"), ValueError, "must not change if D1, D2 and D3 are exchanged"),
        (lambda: formula3("I1 + x"), ValueError, "unknown name 'x'"),
        (lambda: formula3(3), TypeError, "text"),
        (lambda: reduced_body3(fa.HenonHeiles()), TypeError, "model must be a Body3"),
        (lambda: reduced_body3(STAR, spin=np.inf), ValueError, "spin"),
        (lambda: reduced_body3(STAR).to_matrix(np.ones(3)), ValueError, "z must be finite real numbers of shape"),
        (lambda: reduced_body3(STAR, spin=1.0).to_matrix(np.ones(6)), ValueError, "z must have D1 > D2 if spin"),
        (lambda: riemann_ellipsoid(STAR._replace(mu=-1.0), 0.8, 0.6), ValueError, "model.mu must be positive, got -1"),
        (lambda: riemann_ellipsoid(STAR, 1.0), ValueError, "a3 must be given"),
        (lambda: riemann_ellipsoid(STAR, -1.0, 0.5), ValueError, "a2 must be positive"),
        (lambda: riemann_ellipsoid(STAR, 0.9, 3.0), ValueError, "axes of a steady ellipsoid"),
        (lambda: riemann_ellipsoid(Body3(SelfGravity()), 0.9, 0.8), ValueError, "equilibrium size"),
        (lambda: riemann_ellipsoid(fa.HenonHeiles(), 0.9), TypeError, "model must be a Body3"),
        (lambda: relative_equilibrium(STAR, [1, 1], [0, 0, 1]), ValueError, "D must be finite real numbers"),
        (lambda: relative_equilibrium(STAR, [1, 1, -1], [0, 0, 1]), ValueError, "inside the domain"),
        (lambda: fa.charts.two_polar3(np.ones(8)), ValueError, "z must be finite real numbers"),
        (lambda: fa.charts.two_polar3(np.full(18, np.nan)), ValueError, "z must be finite real numbers"),
        (
            lambda: fa.charts.from_two_polar3(2 * np.eye(3), np.ones(3), np.eye(3), np.zeros(3)),
            ValueError,
            "L must be a rotation",
        ),
        (
            lambda: fa.charts.from_two_polar3(np.eye(3), np.ones(3), np.eye(3), np.zeros(3), spin=[0, 0, 1]),
            ValueError,
            "D must be of different size",
        ),
    ],
)
def test_wrong_input_is_refused(call, error, words):
    with pytest.raises(error, match=words):
        call()
