"""Named systems H(q, p) against closed forms: elliptic functions, quadratures, integrals of motion."""

import functools
import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

import fastaff as fa
from fastaff.core.status import Status
from fastaff.jobs import system as jobs
from fastaff.systems.formulas.systems import SYSTEMS, constants_of

RNG = np.random.default_rng(3205)


def quadrature(g, low, high, rest):
    """Integral of g(u) dt from one turning point to the other, of u'^2 = (u - low)(high - u) rest(u)."""
    with mp.workdps(25):

        def at(s):
            u = (low + high) / 2 + (high - low) / 2 * mp.sin(s)
            return g(u) / mp.sqrt(rest(u))

        return mp.quad(at, [-mp.pi / 2, 0, mp.pi / 2])


def roots(coefficients):
    """Real roots of a polynomial, ascending, with 25 digits."""
    with mp.workdps(40):
        return sorted(mp.re(r) for r in mp.polyroots(coefficients, maxsteps=200, extraprec=200))


def conserved(model, z0, time, tolerance, **how):
    """Check that the constants of motion of orbits stay."""
    found = fa.integrate(model, z0, time=time, **how)
    assert (found.status == Status.OK).all()
    before, after = fa.constants_of_motion(model, z0), fa.constants_of_motion(model, found.z)
    assert list(before) == list(after)
    for name, value in before.items():
        size = np.maximum(np.abs(value), 1.0)
        assert (np.abs(after[name] - value) <= tolerance * size).all(), (name, np.abs(after[name] - value).max())
    return list(before)


# --- spherical pendulum -----------------------------------------------------------------------------------------------


def test_a_spherical_pendulum_closes_after_its_period_with_the_advance_of_its_azimuth():
    """Quadratures: u = cos(theta), (l u')^2 = 2 (E/m + g l u)(1 - u^2) - (L/ml)^2."""
    for _ in range(4):
        m, l, g = (float(x) for x in 10 ** RNG.uniform(-0.4, 0.4, 3))
        model = fa.models.SphericalPendulum(m, l, g)
        theta, turn = RNG.uniform(0.4, 2.4), math.sqrt(g / l) * m * l * l
        z0 = [theta, 0.3, 0.0, float(RNG.uniform(0.3, 1.5) * turn)]
        E, L = (mp.mpf(float(x)) for x in (model.energy(*z0), z0[3]))
        a, b = E / (m * l * l), mp.mpf(g) / l
        far, low, high = roots([-2 * b, -2 * a, 2 * b, 2 * a - (L / (m * l * l)) ** 2])
        rest = functools.partial(lambda u, b, far: 2 * b * (u - far), b=b, far=far)
        period = 2 * quadrature(lambda u: 1, low, high, rest)
        advance = 2 * quadrature(lambda u: 1 / (1 - u * u), low, high, rest) * L / (m * l * l)
        end = fa.integrate(model, z0, time=float(period), accuracy=1e-12).z[:, 0]
        np.testing.assert_allclose(end, [z0[0], z0[1] + float(advance), 0.0, z0[3]], rtol=1e-11, atol=1e-11 * turn)


def test_a_spherical_pendulums_azimuth_goes_round_at_a_frequency():
    """1/T of theta, and the advance over 2 pi T of the azimuth, with its sense, from the same quadratures."""
    model, decided = fa.models.SphericalPendulum(), 0
    for _ in range(6):
        z0 = [float(RNG.uniform(0.5, 2.2)), 0.3, 0.1, float(RNG.uniform(0.3, 1.3) * RNG.choice([-1, 1]))]
        E, L = (mp.mpf(float(x)) for x in (model.energy(*z0), z0[3]))
        far, low, high = roots([-2, -2 * E, 2, 2 * E - L * L])
        rest = functools.partial(lambda u, far: 2 * (u - far), far=far)
        period = 2 * quadrature(lambda u: 1, low, high, rest)
        advance = 2 * quadrature(lambda u: 1 / (1 - u * u), low, high, rest) * L
        truth = np.array([float(1 / period), float(advance / (2 * mp.pi * period))])
        found = fa.frequency_map(model, z0, time=400.0)
        assert (np.abs(found.nu[:, 0] - truth) <= found.error[:, 0]).all()
        decided += (np.abs(found.nu[:, 0] - truth) < 1e-9).all()
    assert decided >= 5


@pytest.mark.slow
def test_the_rotation_of_a_spherical_pendulum_has_monodromy_around_its_focus():
    """Around the equilibrium on top, E = m g l and L = 0, the advance of the azimuth winds once; elsewhere not."""
    model = fa.models.SphericalPendulum()
    turns = []
    for centre in (1.0, 1.9):
        w = np.linspace(0, 2 * np.pi, 41)[:-1] + 0.05
        E, L = centre + 0.35 * np.cos(w), 0.35 * np.sin(w) + (0.0 if centre == 1.0 else 0.9)
        lowest = [float(roots([-2, -2 * e, 2, 2 * e - k * k])[2]) for e, k in zip(E, L, strict=True)]
        z0 = np.array([np.arccos(lowest), 0 * L, 0 * L, L])
        cut = fa.poincare_map(
            model, z0, section=fa.Hyperplane((0.0, 0.0, 1.0, 0.0), 0.0, 0), crossings=3, max_time=60.0, accuracy=1e-8
        )
        assert (cut.counts >= 3).all()
        low = np.abs(cut.points[0] - z0[0]) < 1e-5
        first = np.array([np.flatnonzero(low[:, k] & (cut.times[:, k] > 0.5))[0] for k in range(40)])
        advance = cut.points[1, first, np.arange(40)]
        steps = np.diff(np.append(advance, advance[0]))
        turns.append(np.rint((steps - 2 * np.pi * np.rint(steps / (2 * np.pi))).sum() / (2 * np.pi)))
    assert abs(turns[0]) == 1
    assert turns[1] == 0


def on_the_sphere(theta, phi, p_theta, p_phi, times):
    """Angles and momenta of a spherical pendulum of unit mass and length under g = 1, by Cartesian equations."""
    out, round_ = np.array([np.cos(phi), np.sin(phi), 0.0]), np.array([-np.sin(phi), np.cos(phi), 0.0])
    down = np.array([0.0, 0.0, 1.0])
    place = np.sin(theta) * out + np.cos(theta) * down
    speed = p_theta * (np.cos(theta) * out - np.sin(theta) * down) + p_phi / np.sin(theta) * round_

    def rates(t, y):
        x, v = y[:3], y[3:]
        return [*v, *(down - (v @ v + x[2]) * x)]

    y = solve_ivp(rates, (0, times[-1]), [*place, *speed], "DOP853", times, rtol=3e-14, atol=1e-15).y
    out = np.hypot(y[0], y[1])
    return np.array([np.arctan2(out, y[2]), np.arctan2(y[1], y[0]), -y[5] / out])


@pytest.mark.parametrize("text", ["sin(theta)**2", "(1 - cos(theta)**2)"])
def test_no_orbit_passes_through_the_pole_of_its_chart(text):
    """Steps that see nothing of p_phi^2/sin(theta)^2 went to theta < 0 as if there were none."""
    rows = {"coordinates": "theta phi", "momenta": "p_theta p_phi", "periodic": {"phi": "2*pi"}}
    rows |= {"domain": "1 - cos(theta)**2"} if "cos" in text else {}
    model, passed, failed = fa.hamiltonian(f"(p_theta**2 + p_phi**2/{text})/2 - cos(theta)", **rows), 0, 0
    count = 12
    z0 = np.array([RNG.uniform(0.5, 1.5, count), RNG.uniform(-1, 1, count), RNG.uniform(-0.5, 0.5, count)])
    z0 = np.array([*z0, 10 ** RNG.uniform(-10, -4, count) * RNG.choice([-1, 1], count)])
    for accuracy, scheme in [(1e-3, None), (1e-6, None), (1e-9, None), (1e-6, "GAUSS8"), (1e-10, "GAUSS16")]:
        found = fa.integrate(model, z0, time=30.0, accuracy=accuracy, samples=8, scheme=scheme)
        well = found.status == Status.OK
        for k in np.flatnonzero(well):
            apart = np.abs(found.samples[:, :3, k].T - on_the_sphere(*z0[:, k], found.times))
            apart[1] = np.abs((apart[1] + np.pi) % (2 * np.pi) - np.pi)
            close = apart <= 10 * found.sample_error[:, :3, k].T + np.array([1e-12, 1e-9, 1e-12])[:, None]
            assert close.all(), (z0[:, k], accuracy, apart.max())
        assert set(found.status[~well]) <= {Status.OUT_OF_DOMAIN, Status.NOT_CONVERGED, Status.ENERGY_DRIFT}
        passed, failed = passed + well.sum(), failed + (found.status == Status.OUT_OF_DOMAIN).sum()
    assert passed >= (2 * count if "sin" in text else count)  # the other has a domain that loses its digits
    assert failed >= 4


def test_a_pole_whose_residue_is_zero_is_passed():
    """Without p_phi it is a pendulum in a plane, and a top that sleeps moves through its axis."""
    model = fa.models.SphericalPendulum()
    for scheme in (None, "GAUSS8"):
        found = fa.integrate(model, [1.0, 0.3, 0.0, 0.0], time=50.0, samples=200, accuracy=1e-9, scheme=scheme)
        assert found.status[0] == Status.OK
        period = 4 * ellipk(np.sin(0.5) ** 2)
        assert found.samples[:, 0, 0].min() < -0.9
        end = fa.integrate(model, [1.0, 0.3, 0.0, 0.0], time=period, accuracy=1e-12, scheme=scheme).z[:, 0]
        np.testing.assert_allclose(end, [1.0, 0.3, 0.0, 0.0], atol=1e-11)
    top = fa.models.SymmetricTop()
    found = fa.integrate(top, [0.3, 0.0, 0.0, 0.0, 3.0, 3.0], time=20.0, accuracy=1e-9, samples=50)
    assert found.status[0] == Status.OK
    assert found.samples[:, 0, 0].min() < 0


@pytest.mark.parametrize("weak", [1e-14, 1e-11, 1e-8, 1e-3])
def test_no_orbit_passes_a_wall_that_its_steps_do_not_see(weak):
    """Of x^2/2 + c/x^2 the square of x is E + sqrt(E^2 - 2c) cos 2t, in any unit and about any origin."""
    unit, time, count = float(10 ** RNG.uniform(-3, 3)), 20.0, 12
    x0, p0 = RNG.uniform(0.3, 1.5, count), RNG.uniform(-1, 1, count)
    E, u0 = (x0 * x0 + p0 * p0) / 2 + weak / x0**2, x0 * x0
    u = E + (u0 - E) * np.cos(2 * time) + x0 * p0 * np.sin(2 * time)
    truth = np.array([np.sqrt(u), (x0 * p0 * np.cos(2 * time) - (u0 - E) * np.sin(2 * time)) / np.sqrt(u)])
    model = fa.hamiltonian("x**2/2 + c/x**2", coordinates="x", c=weak * unit**4)
    flow, passed = fa.ode("x' = y; y' = -x + 2*c/x**3", c=weak * unit**4), 0
    z0, truth = unit * np.array([x0, p0]), unit * truth
    for accuracy, scheme in [(1e-3, None), (1e-9, None), (1e-6, "YOSHIDA4"), (1e-6, "RKN12"), (1e-6, "GAUSS8")]:
        found = fa.integrate(model, z0, time=time, accuracy=accuracy, scheme=scheme)
        apart, well = np.abs(found.z - truth), found.status == Status.OK
        close = apart <= 10 * found.error + 1e-12 * unit
        assert close[:, well].all(), (accuracy, scheme, apart[:, well].max() / unit)
        passed += well.sum()
    assert passed >= 40 or weak < 1e-3
    for system in (model, flow):
        for scheme in ("DOP853", "VERNER9"):
            found = fa.integrate(system, z0, time=time, scheme=scheme)
            assert (found.status == Status.OK).all()
            np.testing.assert_allclose(found.z, truth, atol=1e-7 * unit)


def test_a_step_sees_that_it_passes_two_poles():
    """Free rotors between walls c/sin(q - a)^2: a step of many half turns lands anywhere."""
    model = fa.hamiltonian("c/sin(q - a)**2 + d*tan(q - a)", coordinates="q", c=1e-12, d=1e-13, a=0.3)
    z0 = np.array([RNG.uniform(0.4, 3.0, 16), RNG.uniform(0.2, 3.0, 16) * RNG.choice([-1, 1], 16)])
    for step in (1.7, 6.9):
        assert (fa.integrate(model, z0, time=69.0, scheme="YOSHIDA4", step=step).status == Status.OUT_OF_DOMAIN).all()
    assert (fa.integrate(model, z0, time=69.0, accuracy=1e-6).status == Status.OUT_OF_DOMAIN).all()


BODIES = {  # V with a pole that moves with g, and what changes its sign there, of phi = [[x, y], [z, u]]
    "radius": ("(r - g)**2/2 + c/(r - g)", lambda x, y, z, u, g: x * x + y * y + z * z + u * u - g),
    "stretch": (
        "(D1**2 + D2**2)/2 + c/(D1 - g) + c/(D2 - g)",
        lambda x, y, z, u, g: (np.hypot(x + u, z - y) + np.hypot(x - u, y + z)) / 2 - g,
    ),
    "element": ("(x**2 + y**2 + 2*z**2 + u**2)/2 + c/(x - g)", lambda x, y, z, u, g: x - g),
}


@pytest.mark.parametrize("kind", BODIES)
def test_no_body_passes_a_pole_of_its_potential(kind):
    """Of a formula of D1, D2 or of the elements, by steps in time or transformed; what ends well is DOP853's orbit."""
    text, side = BODIES[kind]
    g, count = float(RNG.uniform(1.1, 1.3)) ** (2 if kind == "radius" else 1), 24
    body = fa.affine_body(text, g=g, c=float(10 ** RNG.uniform(-12, -6)))
    z0 = np.array([*RNG.uniform(-0.4, 0.4, (4, count)), *RNG.normal(0, 0.4, (4, count))])
    z0[0] += 1.5

    def sides(z):
        a1, a2, b1, b2 = z[..., :4, :].swapaxes(0, -2) / np.sqrt(2)
        return np.sign(side(a1 + b1, b2 - a2, a2 + b2, a1 - b1, g))

    given = {"time": 20.0, "samples": 50}
    truth = fa.integrate(body, z0, scheme="DOP853", **given)
    fixed = [fa.integrate(body, z0, accuracy=accuracy, **given) for accuracy in (1e-4, 1e-8)]
    fixed += [fa.integrate(body, z0, scheme="YOSHIDA4", step=0.1, **given)]
    fixed += [fa.integrate(body, z0, scheme=fa.TimeTransformed(rate=fa.schemes.Logistic(1.0, 5.0)), step=0.1, **given)]
    for found in (truth, *fixed):
        well = found.status == Status.OK
        assert (sides(found.samples) == sides(z0))[..., well].all()
    for found in fixed:
        assert (found.status == Status.OUT_OF_DOMAIN).any()
    well = (truth.status == Status.OK) & (fixed[1].status == Status.OK)
    assert (np.abs(fixed[1].z - truth.z) <= 10 * fixed[1].error + 1e-8)[:, well].all()


# --- tops -------------------------------------------------------------------------------------------------------------


def body_axes(z):
    """Angular momentum along the axes of the body."""
    theta, _, psi, p_theta, p_phi, p_psi = z
    k = (p_phi - p_psi * np.cos(theta)) / np.sin(theta)
    return np.array([k * np.sin(psi) + p_theta * np.cos(psi), k * np.cos(psi) - p_theta * np.sin(psi), p_psi])


def from_axes(theta, psi, L):
    """Phase point with angles theta, 0, psi and an angular momentum along the axes of the body."""
    up = np.array([np.sin(theta) * np.sin(psi), np.sin(theta) * np.cos(psi), np.cos(theta)])
    return np.array([theta, 0.0, psi, L[0] * np.cos(psi) - L[1] * np.sin(psi), L @ up, L[2]])


def test_eulers_top_is_that_of_jacobi():
    """Omega by sn, cn, dn (Landau & Lifshitz, section 37), and the constant angular momentum in space."""
    for _ in range(5):
        I = np.sort(RNG.uniform(0.5, 3.0, 3)) + np.array([0.0, 0.2, 0.5])
        w0 = np.array([RNG.uniform(0.2, 0.6), 0.0, RNG.uniform(0.9, 1.5)])
        E2, M2 = (I * w0 * w0).sum(), (I * I * w0 * w0).sum()
        if E2 * I[1] >= M2:
            w0[2] += 1.0
            E2, M2 = (I * w0 * w0).sum(), (I * I * w0 * w0).sum()
        time = 20.0
        scale = math.sqrt((I[2] - I[1]) * (M2 - E2 * I[0]) / I.prod())
        k2 = (I[1] - I[0]) * (E2 * I[2] - M2) / ((I[2] - I[1]) * (M2 - E2 * I[0]))
        sn, cn, dn, _ = ellipj(scale * time, k2)
        w = [
            math.sqrt((E2 * I[2] - M2) / (I[0] * (I[2] - I[0]))) * cn,
            math.sqrt((E2 * I[2] - M2) / (I[1] * (I[2] - I[1]))) * sn,
            math.sqrt((M2 - E2 * I[0]) / (I[2] * (I[2] - I[0]))) * dn,
        ]
        model = fa.models.AsymmetricTop(*map(float, I))
        z0 = from_axes(RNG.uniform(0.8, 2.2), RNG.uniform(0, 6), I * w0)
        found = fa.integrate(model, z0, time=time, accuracy=1e-13)
        np.testing.assert_allclose(body_axes(found.z[:, 0]) / I, w, rtol=0, atol=1e-12 * np.abs(w0).max())
        assert conserved(model, z0, time, 1e-12, accuracy=1e-13) == ["energy", "p_phi", "L2"]


def test_lagranges_top_nods_as_sn_squared():
    """cos(theta) = u_1 + (u_2 - u_1) sn^2 (Whittaker, section 71), in both of the charts, in 40 digits from the very
    numbers of the start, whose theta is a turning point.
    """
    for _ in range(5):
        I_1, I_3, h = (float(x) for x in RNG.uniform(0.4, 2.0, 3))
        p_phi, p_psi, theta = (float(x) for x in (RNG.uniform(0.5, 2), RNG.uniform(0.5, 3), RNG.uniform(0.5, 2.0)))
        model, z0, time = fa.models.SymmetricTop(I_1, I_3, h), np.array([theta, 0.0, 0.4, 0.0, p_phi, p_psi]), 12.0
        with mp.workdps(40):
            u, (b, c, d) = mp.cos(mp.mpf(theta)), (mp.mpf(x) / mp.mpf(I_1) for x in (2 * h, p_phi, p_psi))
            a = (c - d * u) ** 2 / (1 - u * u) + b * u
            u1, u2, u3 = roots([b, -a - d * d, 2 * c * d - b, a - c * c])
            m, begin = (u2 - u1) / (u3 - u1), 0 if abs(u - u1) < abs(u - u2) else 1
            sn = mp.ellipfun("sn", mp.sqrt(b * (u3 - u1)) / 2 * time + begin * mp.ellipk(m), m=m)
            truth = float(u1 + (u2 - u1) * sn**2)
        for top in (model, fa.models.AsymmetricTop(I_1, I_1, I_3, h_3=h)):
            found = fa.integrate(top, z0, time=time, accuracy=1e-13)
            assert abs(np.cos(found.z[0, 0]) - truth) < 1e-12, (I_1, I_3, h, z0)
        assert conserved(model, z0, time, 1e-12, accuracy=1e-13) == ["energy", "p_phi", "p_psi"]


def starts(count, p_phi=None):
    """Phase points of tops, any orientation, in quaternions: p = 2 q L for an angular momentum L in the body."""
    q, L = RNG.normal(size=(4, count)), RNG.uniform(-1.2, 1.2, (3, count))
    q /= np.sqrt((q * q).sum(axis=0))
    if p_phi is not None:
        up = vertical(q)
        L += (p_phi - (L * up).sum(axis=0)) * up
    scalar, vector = -(q[1:] * L).sum(axis=0), q[0] * L + np.cross(q[1:], L, axis=0)
    return np.array([*q, 2 * scalar, *(2 * vector)])


def vertical(q):
    """The vertical in the axes of the body: the third row of the matrix of a unit quaternion."""
    a, b, c, d = q
    return np.array([2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d])


def kovalevskaya():
    J, h, angle = RNG.uniform(0.5, 1.5), RNG.uniform(0.5, 1.5), RNG.uniform(0, 6)
    return fa.models.AsymmetricTop(2 * J, 2 * J, J, h * math.cos(angle), h * math.sin(angle), chart="quaternion")


def test_both_charts_of_a_top_are_the_same_top():
    """Orbits of the vertical and of the angular momentum in the axes of the body."""
    parameters = [*map(float, RNG.uniform(0.5, 2, 3)), *map(float, RNG.uniform(-0.5, 0.5, 3))]
    euler, regular = (fa.models.AsymmetricTop(*parameters, chart=chart) for chart in ("euler", "quaternion"))
    z = np.array([RNG.uniform(1.0, 2.0), 0.4, 0.9, 0.1, 0.3, 0.5])
    half, (s, c) = z[0] / 2, (z[1] + z[2], z[1] - z[2])
    q = np.array([np.cos(half) * np.cos(s / 2), np.sin(half) * np.cos(c / 2), np.sin(half) * np.sin(c / 2)])
    q = np.append(q, np.cos(half) * np.sin(s / 2))
    L = body_axes(z)
    other = np.array([*q, -2 * q[1:] @ L, *(2 * (q[0] * L + np.cross(q[1:], L)))])
    assert abs(euler.energy(*z) - regular.energy(*other)) < 1e-14
    one, two = (fa.integrate(top, at, time=4.0, accuracy=1e-12).z[:, 0] for top, at in ((euler, z), (regular, other)))
    theta, psi = one[0], one[2]
    up = [np.sin(theta) * np.sin(psi), np.sin(theta) * np.cos(psi), np.cos(theta)]
    np.testing.assert_allclose(vertical(two[:4]), up, rtol=0, atol=1e-10)
    names = fa.constants_of_motion(regular, other)
    assert list(names) == ["energy", "p_phi", "q2", "qp"]
    assert abs(names["p_phi"] - z[4]) < 1e-14


def test_the_tops_of_kovalevskaya_and_of_goryachev_and_chaplygin_keep_their_integrals():
    names = conserved(kovalevskaya(), starts(8), 50.0, 1e-11, accuracy=1e-12)
    assert names == ["energy", "p_phi", "kovalevskaya", "q2", "qp"]
    J, h = RNG.uniform(0.5, 1.5), RNG.uniform(0.3, 1, 2)
    other = fa.models.AsymmetricTop(4 * J, 4 * J, J, *map(float, h), chart="quaternion")
    names = conserved(other, starts(8, p_phi=0.0), 50.0, 1e-11, accuracy=1e-12)
    assert "goryachev_chaplygin" in names
    off = starts(8)  # where p_phi is not 0 it is no constant
    after = fa.integrate(other, off, time=5.0).z
    before, after = (fa.constants_of_motion(other, z)["goryachev_chaplygin"] for z in (off, after))
    assert np.abs(after - before).max() > 1e-3


@pytest.mark.parametrize("orbits", [12, pytest.param(1000, marks=pytest.mark.slow)])
def test_kovalevskayas_top_has_no_chaotic_orbit_and_its_neighbour_has(orbits):
    top = kovalevskaya()
    found = fa.chaos_map(top, starts(orbits), time=1000.0, indicators="megno")
    assert not found.chaotic.any()
    assert found.regular.mean() > 0.3
    near = top._replace(I_3=top.I_3 * 1.6, h_3=0.6)
    assert fa.chaos_map(near, starts(12), time=1000.0, indicators="megno").chaotic.any()


# --- one entry ------------------------------------------------------------------------------------------------------


def test_a_named_system_is_one_entry():
    """`makes` alone: models, command line and its own constants know each."""
    for name, make in SYSTEMS.items():
        assert getattr(fa.models, name) is make
        assert name in dir(fa.models)
        key = next(key for key, kind in jobs.SYSTEMS.items() if kind == name)
        model = jobs.Model(model=key).build()
        assert model == make()
        assert constants_of(model) is not None
    with pytest.raises(AttributeError, match=r"fastaff\.models has no 'Nothing'"):
        fa.models.Nothing  # noqa: B018
