"""Geodesics of ellipsoids and around black holes against quadratures, published frequencies and constants of motion."""

import functools
import math

import mpmath as mp
import numpy as np
import pytest

import fastaff as fa
from fastaff.core.status import Status

RNG = np.random.default_rng(1916)

PUBLISHED = """
0.050 10.200 0.160 0.740 2.463829345116514524 3.793215083788103570 3.804874962443791198 127.4552616822083593
0.950 12.680 0.650 0.660 3.233652806127779833 3.956440724876448378 4.113595549682501407 383.0130811684927039
0.450 18.000 0.660 0.260 3.871056938176167250 4.688501591346351915 4.745276373861005759 778.6915914081711207
0.500 12.010 0.420 -0.340 2.777593692025730476 4.097540557116754023 -3.993019446096020886 210.8788191593237684
0.500 19.760 0.230 -0.240 4.010950290142418773 4.854791552517200515 -4.798366611490850531 456.4236758339048379
0.430 6.310 0.050 0.540 1.398612776386835677 3.273211438956314723 3.445522334907432871 54.38887024124261416
0.220 18.630 0.490 -0.620 3.875610112759255266 4.777349224265896588 -4.750027428690057896 549.2035646859205826
0.960 8.480 0.050 0.050 2.107533686287228925 3.565742608461105689 3.839124112427782176 89.89049495279019197
0.110 7.040 0.620 0.920 1.246789238663324140 3.593952650930708703 3.650374411477899983 88.53174581536829635
0.530 14.360 0.070 0.230 3.297614532632735074 4.228121109129313382 4.309008418018829722 233.2957508485017115
0.140 14.670 0.470 -0.260 3.314470449731493851 4.345385927681731708 -4.322907753330222036 333.7647954039772458
0.590 11.200 0.210 -0.440 2.540111114364512979 4.013079495623014026 -3.880953145105922264 154.7808589252198601
0.630 8.570 0.410 0.320 2.205108475089508691 3.565031704340040353 3.746921480047956443 111.2735803142765718
0.250 14.290 0.050 0.340 3.269088257302252387 4.231189045663695580 4.269878708676792201 230.4040676945215012
0.740 9.400 0.390 -0.230 2.154359670575908048 3.827428687048907818 -3.616707437119702107 127.7617385027736674
"""
"""a, p, e, x; Upsilon_r, Upsilon_theta, Upsilon_phi, Gamma: of the tests of KerrGeoPy (tests/data/freq_values.txt and
mathematica_freq_output.txt), computed there with KerrGeodesics of the Black Hole Perturbation Toolkit.
"""
ORBITS = np.array([row.split() for row in PUBLISHED.split("\n") if row], dtype=float)
IN_COORDINATE_TIME = """
0.95 6.00 0.90 0.30 0.004800849870503979 0.010875592729535219 0.01278659649394388
0.99 12.0 0.50 1.00 0.01319448012413408 0.015513550082646335 0.01614608323014866
0.01 12.0 0.50 -1.0 0.012000588609775374 0.01710391897431342 -0.01709526006998466
0.90 6.00 0.30 1.00 0.037645648405229756 0.05262560724893245 0.05816122061091471
"""
"""a, p, e, x; Omega_r, Omega_theta, Omega_phi: three of the tests of pybhpt (geo), one of those of KerrGeodesics
(Tests/KerrGeoFrequencies.wlt).
"""
OMEGAS = np.array([row.split() for row in IN_COORDINATE_TIME.split("\n") if row], dtype=float)
OMEGAS = np.concatenate([np.hstack([ORBITS[:, :4], ORBITS[:, 4:7] / ORBITS[:, 7:]]), OMEGAS])


def constants(a, p, e, x):
    """E, L, Q of the orbit between p/(1 - e) and p/(1 + e) whose least sin(theta) is x or -x (Schmidt 2002)."""
    a, p, e, x = (mp.mpf(repr(float(v))) for v in (a, p, e, x))
    z = 1 - x * x

    def parts(r):
        delta = r * r - 2 * r + a * a
        f, h = r**4 + a * a * (r * (r + 2) + z * delta), r * (r - 2) + z * delta / (1 - z)
        return f, 2 * a * r, h, (r * r + a * a * z) * delta

    (f1, g1, h1, d1), (f2, g2, h2, d2) = parts(p / (1 - e)), parts(p / (1 + e))
    k, n, q = d1 * h2 - h1 * d2, d1 * g2 - g1 * d2, f1 * h2 - h1 * f2
    m, s, sign = f1 * g2 - g1 * f2, g1 * h2 - h1 * g2, mp.sign(x)
    square = (k * q + 2 * n * s - 2 * sign * mp.sqrt(s * (s * n * n + q * n * k - m * k * k))) / (q * q + 4 * m * s)
    E = mp.sqrt(square)
    L = (-g1 * E + sign * mp.sqrt(g1 * g1 * square + (f1 * square - d1) * h1)) / h1
    return E, L, z * (a * a * (1 - square) + L * L / (1 - z))


def averages(a, p, e, x):
    """Upsilon_r, Upsilon_theta, Upsilon_phi, Gamma by quadratures of the separated equations, to 25 digits."""
    with mp.workdps(30):
        E, L, Q = constants(a, p, e, x)
        a, p, e, x = (mp.mpf(repr(float(v))) for v in (a, p, e, x))
        near, far = p / (1 + e), p / (1 - e)
        total, product = 2 / (1 - E * E) - near - far, a * a * Q / ((1 - E * E) * near * far)

        def rate_r(r):  # (dr/dlambda)^2 without (far - r)(r - near)
            return (1 - E * E) * (r * r - total * r + product)

        beta, z = a * a * (1 - E * E), 1 - x * x

        def rate_u(u):  # (d cos(theta)/dlambda)^2 = (z - u^2) of this
            return L * L / (1 - z) + beta * (1 - u * u) if z == 0 else (Q / z - beta * u * u)

        def mean(g, low, high, rest):
            def at(s):
                u = (low + high) / 2 + (high - low) / 2 * mp.sin(s)
                return g(u) / mp.sqrt(rest(u))

            return mp.quad(at, [-mp.pi / 2, 0, mp.pi / 2])

        u = mp.sqrt(z)
        half_r, half_u = mean(lambda r: 1, near, far, rate_r), mean(lambda u: 1, -u, u, rate_u)

        def force(r):
            return (E * (r * r + a * a) - a * L) / (r * r - 2 * r + a * a)

        phi = mean(lambda r: a * force(r), near, far, rate_r) / half_r - a * E
        phi += mean(lambda u: L / (1 - u * u), -u, u, rate_u) / half_u
        t = mean(lambda r: (r * r + a * a) * force(r), near, far, rate_r) / half_r + a * L
        t -= mean(lambda u: a * a * E * (1 - u * u), -u, u, rate_u) / half_u
        return np.array([float(v) for v in (mp.pi / half_r, mp.pi / half_u, phi, t)])


def drawn(count):
    """Spins and bound orbits, p above the last stable one."""
    a, e = RNG.uniform(0.05, 0.95, count), RNG.uniform(0.05, 0.6, count)
    x = RNG.uniform(0.2, 0.9, count) * RNG.choice([-1, 1], count)
    return np.array([a, RNG.uniform(11, 16, count), e, x]).T


def start(a, p, e, x, time):
    """The farthest point, in the equator, going up."""
    E, L, Q = map(float, constants(a, p, e, x))
    z = [p / (1 - e), math.pi / 2, 0.0, 0.0, math.sqrt(max(Q, 0.0)), L]
    return np.array([0.0, *z[:3], -E, *z[3:]] if time == "mino" else z)


def test_the_quadratures_are_the_published_frequencies():
    for row in ORBITS:
        np.testing.assert_allclose(averages(*row[:4]), row[4:], rtol=1e-13)
    for row in OMEGAS[len(ORBITS) :]:
        found = averages(*row[:4])
        np.testing.assert_allclose(found[:3] / found[3], row[4:], rtol=1e-12)


def winding(samples, every):
    """Mean rates of rows (samples, rows) by weighted Birkhoff averages of their steps."""
    s = (np.arange(len(samples) - 1) + 0.5) / (len(samples) - 1)
    weight = np.exp(-1 / (s * (1 - s)))
    return (np.diff(samples, axis=0) * weight[:, None]).sum(axis=0) / weight.sum() / every


@pytest.mark.parametrize("orbits", [ORBITS[:6, :4], drawn(3)], ids=["published", "drawn"])
def test_orbits_around_a_hole_have_the_frequencies_of_minos_time(orbits):
    """r and theta come back after their own periods; phi and t go on at their mean rates."""
    for row in orbits:
        truth, hole, z0 = averages(*row), fa.models.KerrGeodesic(row[0], time="mino"), start(*row, "mino")
        for entry, rows in ((0, (1, 5)), (1, (2, 6))):
            end = fa.integrate(hole, z0, time=float(2 * np.pi / truth[entry]), accuracy=1e-12).z[:, 0]
            np.testing.assert_allclose(end[list(rows)], z0[list(rows)], rtol=1e-10, atol=1e-10)
        count, every = 1500, 0.1
        long = fa.integrate(hole, z0, time=count * every, samples=count, accuracy=1e-10).samples[..., 0]
        rates = winding(np.concatenate([z0[None], long])[:, [3, 0]], every)
        np.testing.assert_allclose(rates, truth[2:], rtol=1e-8)
        before, after = (fa.constants_of_motion(hole, z) for z in (z0, end))
        assert list(before) == ["energy", "mass_shell", "p_phi", "carter"]
        for name in before:
            assert abs(after[name] - before[name])[0] < 1e-11 * max(1.0, abs(before[name][0])), name
        assert abs(before["mass_shell"][0]) < 1e-11


def in_coordinate_time(orbits):
    """Rows a, p, e, x, Omega_r, Omega_theta, Omega_phi by quadrature."""
    found = np.array([averages(*row) for row in orbits])
    return np.hstack([orbits, found[:, :3] / found[:, 3:]])


@pytest.mark.parametrize(
    "orbits",
    [in_coordinate_time(drawn(3)), OMEGAS[[5]], pytest.param(OMEGAS, marks=pytest.mark.slow)],
    ids=["drawn", "published", "all published"],
)
def test_orbits_in_coordinate_time_have_frequencies_over_gamma(orbits):
    """Those of r, theta and, with its sense, the azimuth within twice their errors; nu_r by the times of apocentres.

    Of an eccentric orbit the strongest line of theta is nu_theta - nu_r, not nu_theta: the mean of exp(i f), of the
    true anomaly f, outweighs its first harmonic (for Kepler's ellipse, e > 1 - e^2: above 0.62).
    """
    sharp, farthest = [], fa.Hyperplane((0.0, 0.0, 0.0, 1.0, 0.0, 0.0), direction=-1)
    for a, p, e, x, *omega in orbits:
        nu, hole, z0 = np.array(omega) / (2 * np.pi), fa.models.KerrGeodesic(a), start(a, p, e, x, "coordinate")
        found = fa.frequency_map(hole, z0, time=100 / nu[0], accuracy=1e-10)
        assert found.names == ("r", "theta", "phi")
        radial = np.rint((nu[1] - found.nu[1, 0]) / nu[0]) if e > 0.4 and abs(x) < 1 else 0
        off = np.abs(found.nu[:, 0] - nu + np.array([0, radial * nu[0], 0]))
        assert (off <= 2 * found.error[:, 0]).all(), (a, p, e, x, off, found.error[:, 0])
        sharp.append((found.error[:, 0] < 1e-4 * np.abs(nu))[[0, 2]].all())
        times = fa.poincare_map(hole, z0, section=farthest, crossings=150, max_time=200 / nu[0], accuracy=1e-9).times
        assert abs(winding(times, 1.0)[0] * nu[0] - 1) < 1e-9, (a, p, e, x)
    assert np.mean(sharp) > 0.6


def test_constants_in_coordinate_time_stay_over_a_hundred_turns():
    for row in OMEGAS[[3, 5]]:
        hole, z0 = fa.models.KerrGeodesic(row[0]), start(*row[:4], "coordinate")
        end = fa.integrate(hole, z0, time=100 * 2 * np.pi / row[4], accuracy=1e-12).z
        before, after = (fa.constants_of_motion(hole, z) for z in (z0, end))
        for name in ("energy", "p_phi", "carter"):
            assert abs(after[name] - before[name])[0] < 1e-11 * max(1.0, abs(before[name][0])), name


def test_a_particle_that_falls_in_ends_and_bad_parameters_are_refused():
    fall = functools.partial(fa.integrate, fa.models.KerrGeodesic(0.5), [6.0, np.pi / 2, 0.0, -0.5, 0.0, 1.0])
    fallen = fall(time=50.0, accuracy=1e-6)  # next to the horizon, which the time of far observers never reaches
    np.testing.assert_allclose(fallen.z[0], 1.0 + np.sqrt(0.75), rtol=1e-6)
    assert fallen.status[0] == Status.OK
    assert fall(time=500.0).accurate_until[0] < 500.0
    for call, match in (
        (lambda: fa.models.KerrGeodesic(1.5), "a must be between -1 and 1, got 1.5"),
        (lambda: fa.models.KerrGeodesic(0.5, time="proper"), "time must be one of coordinate, mino"),
        (lambda: fa.models.EllipsoidGeodesic(0.0), "a must be positive"),
        (lambda: fa.models.AsymmetricTop(chart="x"), "chart must be one of euler, quaternion, got 'x'"),
        (lambda: fa.models.SphericalPendulum(g=-1.0), "g must be positive"),
        (lambda: fa.models.SymmetricTop(I_3=0.0), "I_3 must be positive"),
    ):
        with pytest.raises(ValueError, match=match):
            call()


# --- ellipsoid --------------------------------------------------------------------------------------------------------


def on_surface(axes, count):
    """Points of the ellipsoid with tangent vectors of length 1."""
    u = RNG.normal(size=(3, count))
    x = u / np.sqrt((u * u).sum(axis=0)) * axes[:, None]
    normal = x / axes[:, None] ** 2
    v = np.cross(normal, RNG.normal(size=(3, count)), axis=0)
    return np.concatenate([x, v / np.sqrt((v * v).sum(axis=0))])


def test_geodesics_of_an_ellipsoid_keep_joachimsthals_integral():
    axes = RNG.uniform(0.6, 2.0, 3)
    model, z0 = fa.models.EllipsoidGeodesic(*map(float, axes)), on_surface(axes, 12)
    np.testing.assert_allclose(model.energy(*z0), 0.5, rtol=1e-14)
    np.testing.assert_allclose(model.rates(*z0)[:3], z0[3:], atol=1e-14)
    end = fa.integrate(model, z0, time=600.0, accuracy=1e-13)
    assert (end.status == Status.OK).all()
    before, after = (fa.constants_of_motion(model, z) for z in (z0, end.z))
    for name, value in before.items():
        assert (np.abs(after[name] - value) <= 1e-12 * np.maximum(1.0, np.abs(value))).all(), name
    v = np.array(model.rates(*end.z)[:3])
    np.testing.assert_allclose((v * v).sum(axis=0), 1.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("turns", "low"),
    [(1e3, 0.8), pytest.param(1e4, 0.8, marks=pytest.mark.slow), pytest.param(1e4, 0.3, marks=pytest.mark.slow)],
)
def test_jacobis_integral_over_many_turns(turns, low):
    """Constants that were rounded differently in H's derivatives made it drift, by 8e-12 in 10^4, whatever the step."""
    axes = np.array([RNG.uniform(low, low + 0.2), *RNG.uniform(1.0, 1.6, 2)])
    model, z0 = fa.models.EllipsoidGeodesic(*map(float, axes)), on_surface(axes, 3)
    time, step = turns * 2 * np.pi * axes.max(), 0.3 * axes.min() ** 2 / axes.max()
    end = fa.integrate(model, z0, time=time, step=step, scheme=fa.schemes.GAUSS16)
    assert (end.status == Status.OK).all()
    before, after = (fa.constants_of_motion(model, z) for z in (z0, end.z))
    for name in ("energy", "joachimsthal", "size"):
        off = np.abs(after[name] / before[name] - 1)
        assert (off <= 1e-16 * turns).all(), (name, off)


def test_geodesics_of_a_sphere_are_great_circles_and_those_through_umbilics_meet_again():
    sphere = fa.models.EllipsoidGeodesic(1.3, 1.3, 1.3)
    z0 = on_surface(np.full(3, 1.3), 4)
    np.testing.assert_allclose(fa.integrate(sphere, z0, time=2.6 * np.pi, accuracy=1e-12).z, z0, atol=1e-10)
    a, b, c = 2.0, 1.5, 1.0
    umbilic = np.array(
        [a * math.sqrt((a * a - b * b) / (a * a - c * c)), 0.0, c * math.sqrt((b * b - c * c) / (a * a - c * c))]
    )
    normal = umbilic / np.array([a, b, c]) ** 2
    normal /= np.sqrt(normal @ normal)
    across = np.array([0.0, 1.0, 0.0])
    angle = np.linspace(0.3, 2.8, 4)
    v = np.cross(normal, across)[:, None] * np.cos(angle) + across[:, None] * np.sin(angle)
    z0 = np.concatenate([np.repeat(umbilic[:, None], 4, axis=1), v])
    length = 2 * mp.quad(lambda s: mp.sqrt((a * mp.cos(s)) ** 2 + (c * mp.sin(s)) ** 2), [0, mp.pi / 2])
    end = fa.integrate(fa.models.EllipsoidGeodesic(a, b, c), z0, time=float(length), accuracy=1e-12).z
    np.testing.assert_allclose(end[:3], -z0[:3], atol=1e-8)


@pytest.mark.slow
def test_the_azimuth_of_a_nearly_circular_orbit_has_its_rate():
    """Whatever the lines of r and theta tell: in coordinate time, over 150 radial periods, one seems to be two."""
    a, p, e, x = 0.25, 14.29, 0.05, 0.34
    truth = averages(a, p, e, x)
    radial, azimuth = (truth[i] / truth[3] / (2 * np.pi) for i in (0, 2))
    z0 = np.asarray(start(a, p, e, x, "coordinate"))[:, None]
    for periods in (100, 150, 300):
        found = fa.frequency_map(fa.models.KerrGeodesic(a), z0, time=periods / radial, accuracy=1e-11)
        assert abs(found.nu[2, 0] - azimuth) <= found.error[2, 0] < 1e-3 * azimuth
