"""Wave packets against closed forms, classical orbits, propagation by matrix exponentials, and the frequencies dE/dJ,
d2E/dJ2.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from fastaff import (
    Anharmonic,
    Body,
    Harmonic,
    Hyperelastic,
    SeparableAlphaBeta,
    SeparableRVartheta,
    affine_body,
    energy_of_actions,
    from_action_angles,
    univariate,
)
from fastaff.quantum import (
    Packet,
    TimeScales,
    coherent_packet,
    number_packet,
    projected_packet,
    revivals,
    spectrum,
    wavefunction,
)
from fastaff.quantum.packets.coherent_packet import PlaneGaussian
from fastaff.systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA, TWO_POLAR
from fastaff.systems.models import Barriers, Cosine, Spring

QUARTIC = Body(SeparableAlphaBeta(univariate(lambda x: x**4), univariate(lambda x: x**2 / 2 + x**4 / 10)), mu=1.3)
CORED = Body(SeparableRVartheta(Spring(1.0, 4.0), Cosine(0.7)))
WALLED = Body(Hyperelastic(2.0))
HARMONIC = Body(Harmonic(1.3), 0.7)
OMEGA = np.sqrt(1.3 / 0.7)
Z0 = np.array([0.7, 0.2, 0.4, -0.5, 0.3, -0.6, 0.2, 0.7])


@pytest.fixture(scope="module")
def coherent():
    """A coherent state of the harmonic body of its own width: it moves without changing shape."""
    hbar = 0.6
    return coherent_packet(HARMONIC, Z0, width=np.sqrt(hbar / (2 * 0.7 * OMEGA)), count=30, hbar=hbar, missing=1e-7)


def harmonic_orbit(t):
    """Rows a1, a2, b1, b2 (4, times)."""
    return np.multiply.outer(Z0[:4], np.cos(OMEGA * t)) + np.multiply.outer(Z0[4:], np.sin(OMEGA * t)) / (0.7 * OMEGA)


def test_a_harmonic_coherent_state_is_the_moving_gaussian(coherent):
    width, t = np.sqrt(0.6 / (2 * 0.7 * OMEGA)), np.array([0.0, 0.9, 2.3])
    points = np.random.default_rng(0).normal(scale=0.8, size=(4, 60))
    steps = points[:, None, :] - harmonic_orbit(t)[:, :, None]
    exact = np.exp(-(steps**2).sum(axis=0) / (4 * width**2)) / (2 * np.pi * width**2)
    psi = coherent.planes(points, t)
    assert coherent.missing < 1e-7
    assert (
        np.abs(np.abs(psi) - exact).max() < 10 * np.sqrt(coherent.missing) * exact.max()
    )  # what is missing may add up at a point
    # its phase at first: the momentum of the orbit
    phase = np.exp(1j * np.tensordot(Z0[4:], steps[:, 0], axes=1) / 0.6)
    assert np.abs(psi[0] - exact[0] * phase).max() < 10 * np.sqrt(coherent.missing) * exact.max()
    matrices = np.array(
        [[points[0] + points[2], points[3] - points[1]], [points[3] + points[1], points[0] - points[2]]]
    ) / np.sqrt(2)
    np.testing.assert_allclose(coherent(matrices[..., :3]), psi[0, :3], atol=1e-12)


def test_means_follow_the_orbit_exactly_where_the_body_is_harmonic(coherent):
    """<alpha^2> = |a(t)|^2 + 2 width^2, <r> likewise; E = classical energy + 2 hbar omega; full return after pi/omega
    and 2 pi/omega.
    """
    t = np.linspace(0, 4, 9)
    orbit, width = harmonic_orbit(t), np.sqrt(0.6 / (2 * 0.7 * OMEGA))
    A = coherent.expectation(lambda alpha, beta: alpha**2, time=t)
    r = coherent.expectation(lambda r, vartheta: r, chart=R_VARTHETA, time=t)
    assert pytest.approx((orbit[:2] ** 2).sum(axis=0) + 2 * width**2, abs=1e-5) == A
    assert r == pytest.approx((orbit**2).sum(axis=0) + 4 * width**2, abs=1e-5)
    assert coherent.energy == pytest.approx(
        HARMONIC.kinetic_energy(*Z0[4:]) + HARMONIC.potential_energy(*Z0[:4]) + 1.2 * OMEGA, abs=1e-5
    )
    back = coherent.autocorrelation(2 * np.pi / OMEGA * np.arange(4))
    assert np.abs(back) == pytest.approx(np.full(4, coherent.norm() ** 2), abs=1e-12)
    assert abs(coherent.autocorrelation(np.pi / OMEGA)) < 0.1
    expected = np.exp(-((harmonic_orbit(np.array([np.pi / OMEGA]))[:, 0] - Z0[:4]) ** 2).sum() / (8 * width**2))
    expected *= np.exp(
        -(width**2) * (4 * (Z0[4:] ** 2).sum()) / (2 * 0.6**2)
    )  # overlap of two Gaussians: distance, and momenta
    assert abs(coherent.autocorrelation(np.pi / OMEGA)) == pytest.approx(expected, abs=1e-5)


def test_density_is_psi_over_both_angles(coherent):
    """The trapezoidal sum over eta and gamma is exact for as many angles as the classes turn."""
    alpha, beta = 0.8, 0.6
    angles = 2 * np.pi * np.arange(64) / 64
    eta, gamma = (a.ravel() for a in np.meshgrid(angles, angles))
    psi = coherent.at(np.array([alpha + 0 * eta, beta + 0 * eta, eta, gamma]), time=0.4)
    summed = (np.abs(psi) ** 2).mean() * 4 * np.pi**2 * alpha * beta
    assert coherent.density(alpha, beta, time=0.4) == pytest.approx(summed, rel=1e-9)
    r, vartheta = alpha**2 + beta**2, 2 * np.arctan2(beta, alpha)
    assert coherent.density(r, vartheta, R_VARTHETA, 0.4) == pytest.approx(summed / 4, rel=1e-9)
    D1, D2 = (alpha + beta) / np.sqrt(2), (alpha - beta) / np.sqrt(2)
    assert coherent.density(D1, D2, TWO_POLAR, 0.4) == pytest.approx(summed, rel=1e-9)
    assert coherent.density(D2, D1, TWO_POLAR, 0.4) == 0.0


def test_the_plane_gaussian_by_bessel_functions():
    """Harmonics exp(z cos) = sum I_k(z): the closed form with scipy's I_k of complex argument."""
    from scipy.special import iv

    gaussian = PlaneGaussian(np.array([0.6, -0.3]), np.array([0.4, 0.9]), 0.3, 0.5)
    radius, k = np.linspace(0, 1.8, 25), [-9, -2, 0, 1, 7]
    v = gaussian.centre / (2 * 0.09) + 1j * gaussian.momentum / 0.5
    z = np.sqrt(v @ v)
    front = np.exp(-(radius**2 + 0.45) / 0.36 - 1j * (gaussian.momentum @ gaussian.centre) / 0.5) / np.sqrt(
        2 * np.pi * 0.09
    )
    exact = [front * iv(j, radius * z) * ((v[0] - 1j * v[1]) / z) ** j for j in k]
    np.testing.assert_allclose(gaussian.harmonics(radius, k), exact, atol=1e-14)
    share = gaussian.probabilities()
    assert sum(share.values()) == pytest.approx(1, abs=1e-12)
    angular = (gaussian.centre[0] * 0.9 + 0.3 * 0.4) / 0.5
    assert sum(j * p for j, p in share.items()) == pytest.approx(angular, abs=1e-10)


def test_autocorrelation_against_a_matrix_exponential():
    """Class m = 1, l = 0 of the covering: u = sqrt(alpha beta) f has no centrifugal term, so a sine basis propagates it
    by expm.
    """
    hbar, mu, size, length = 0.4, 1.3, 64, 4.2
    x = length * np.arange(1, size + 1) / (size + 1)
    sines = np.sqrt(2 / (size + 1)) * np.sin(
        np.outer(np.arange(1, size + 1), np.arange(1, size + 1)) * np.pi / (size + 1)
    )
    kinetic = sines @ np.diag(hbar**2 / (2 * mu) * (np.arange(1, size + 1) * np.pi / length) ** 2) @ sines

    def start(x, centre, momentum):
        return x * np.exp(-((x - centre) ** 2) / 0.16 + 1j * momentum * x / hbar)

    packet = projected_packet(
        QUARTIC,
        lambda alpha, beta: start(alpha, 1.0, 0.5) * start(beta, 1.4, -0.3) / np.sqrt(alpha * beta),
        m=1,
        l=0,
        count=400,
        hbar=hbar,
        missing=1e-9,
        single_valued=False,
    )
    time, product = np.array([0.3, 1.1, 4.7]), np.ones(3, complex)
    for V, centre, momentum in ((QUARTIC.potential.V_alpha, 1.0, 0.5), (QUARTIC.potential.V_beta, 1.4, -0.3)):
        u = start(x, centre, momentum)
        H = kinetic + np.diag(V.value(x))
        product *= [np.vdot(u, expm(-1j * H * t / hbar) @ u) / np.vdot(u, u) for t in time]
    assert np.abs(packet.autocorrelation(time) - product).max() < 1e-8


def test_bodies_that_do_not_separate_take_the_same_way():
    """An oscillator given as a formula is solved without separation: the same packet as in closed form."""
    plain = affine_body("(D1**2 + D2**2)/2")
    taken = {
        "z0": np.array([0.8, 0.1, 0.5, 0.2, 0.1, 0.5, -0.2, 0.2]),
        "width": 0.6,
        "count": 40,
        "m": 2,
        "l": 0,
        "missing": 1e-6,
    }
    one, other = coherent_packet(plain, **taken), coherent_packet(Body(Harmonic()), **taken)
    assert one.states[0].numbers.keys() == {"n_level"}
    t = np.linspace(0, 5, 11)
    np.testing.assert_allclose(one.autocorrelation(t), other.autocorrelation(t), atol=1e-8)
    means = [packet.expectation(lambda a, b: a * b, time=t[:3]) for packet in (one, other)]
    np.testing.assert_allclose(*means, atol=1e-7)
    x, y = np.linspace(0.2, 2, 6)[:, None], np.linspace(0.1, 2, 5)
    np.testing.assert_allclose(one.density(x, y, time=t[:2]), other.density(x, y, time=t[:2]), atol=3e-5)  # sqrt(1e-9)


def gauss_density(packet, time):
    """The integral of density in each chart, on grids of their own."""
    q, w = np.polynomial.legendre.leggauss(160)
    x, y = 4 * (1 + q[:, None]), 4 * (1 + q)
    yield (packet.density(x, y, ALPHA_BETA, time) * w[:, None] * w).sum() * 16
    r, v = (x + 0.0) ** 2, np.pi / 4 * (1 + q)  # det phi > 0
    yield (packet.density(r, v, R_VARTHETA, time) * (2 * x * w[:, None]) * w).sum() * np.pi


def test_norm_is_conserved_and_densities_integrate_to_it():
    packet = number_packet(WALLED, n=(3, 5), m=2, l=0, width=(0.7, 1.0), hbar=0.4)
    t = np.array([0.0, 3.7, 1e4])
    assert packet.norm() == pytest.approx(1, abs=1e-14)
    assert packet.expectation(lambda a, b: np.ones(a.shape), time=t) == pytest.approx(np.ones(3), abs=1e-9)
    for moment in t:
        assert packet.evolved(moment).norm() == pytest.approx(1, abs=1e-12)
    *_, inside = gauss_density(packet, 3.7)
    assert inside == pytest.approx(1, abs=1e-6)
    assert packet.density(0.5, 0.9) == 0.0  # det phi < 0


@settings(max_examples=30, deadline=None)
@given(
    E=st.lists(st.floats(-50, 50), min_size=1, max_size=12),
    hbar=st.floats(0.1, 3),
    t=st.floats(-1e3, 1e3),
    s=st.floats(-1e3, 1e3),
    seed=st.integers(0, 99),
)
def test_autocorrelation_is_the_sum_and_a_group(E, hbar, t, s, seed):
    rng = np.random.default_rng(seed)
    c = rng.normal(size=len(E)) + 1j * rng.normal(size=len(E))
    c /= np.linalg.norm(c)
    states = [wavefunction(HARMONIC, m=0, l=0, n=(k, 0)) for k in range(len(E))]
    packet = Packet(states, np.array(E), c, hbar)
    naive = sum(abs(ck) ** 2 * np.exp(-1j * Ek * t / hbar) for ck, Ek in zip(c, E))
    rounding = 1e-15 * (10 + max(map(abs, E)) * (abs(t) + abs(s)) / hbar)
    assert abs(packet.autocorrelation(t) - naive) < rounding
    assert packet.autocorrelation(-t) == pytest.approx(np.conj(packet.autocorrelation(t)), abs=rounding)
    twice = packet.evolved(t).evolved(s)
    assert np.abs(twice.coefficients - packet.evolved(t + s).coefficients).max() < 4 * rounding
    assert np.vdot(packet.coefficients, packet.evolved(t).coefficients) == pytest.approx(naive, abs=4 * rounding)


def test_many_times_in_blocks():
    packet = number_packet(HARMONIC, n=(20, 8), m=2, l=0, width=(3, 0), hbar=0.1)
    t = np.linspace(0, 50, 30_000).reshape(3, -1)
    found = packet.autocorrelation(t)
    some = [np.sum(packet.weights * np.exp(-1j * packet.energies * moment / 0.1)) for moment in t[:, ::1000].ravel()]
    assert found.shape == t.shape
    assert np.abs(found[:, ::1000].ravel() - some).max() < 1e-10


@pytest.mark.parametrize(
    ("body", "n"), [(CORED, (3, 4)), (WALLED, (2, 4)), (QUARTIC, (4, 3))], ids=["heavy top", "EQ2.2h", "quartic"]
)
def test_time_scales_agree_with_frequencies_to_order_hbar_squared(body, n):
    """The same actions at hbar and hbar/3: n + 1/2 and m, l three times as large; differences fall ninefold."""
    away = []
    for factor in (1, 3):
        hbar = 0.12 / factor
        numbers = [(2 * k + 1) * factor // 2 for k in n]
        found = revivals(body, n=numbers, m=4 * factor, l=-2 * factor, hbar=hbar)
        assert found.quantum.names == found.classical.names
        J = 2 * np.pi * hbar * np.array([numbers[0] + 0.5, numbers[1] + 0.5, 4 * factor, -2 * factor])
        nu = energy_of_actions(body, J).nu
        np.testing.assert_allclose(found.classical.period[:2], 1 / np.abs(nu[:2]), rtol=1e-12)
        slope = np.abs(found.quantum.slope / found.classical.slope - 1)
        change = np.abs(found.quantum.curvature - found.classical.curvature) / np.abs(found.classical.curvature).max()
        away.append((slope.max(), change.max()))
    orders = np.log(np.array(away[0]) / away[1]) / np.log(3)
    assert orders == pytest.approx([2, 2], abs=0.4), (away, orders)


def test_time_scales_in_closed_form():
    """Harmonic: T = pi/omega, revivals never; Anharmonic: only eta, from sqrt(16 C mu/hbar^2 + (m - l)^2); a core: from
    the square root.
    """
    scales = revivals(HARMONIC, n=(9, 4), m=5, l=1, hbar=0.3)
    for found in scales:
        np.testing.assert_allclose(found.period, np.pi / OMEGA * np.array([1, 1, 2, 2]), rtol=1e-11)
        assert np.isinf(found.revival).all()
    hbar, C, mu, k = 0.3, 1.1, 0.8, 3
    root, omega = np.sqrt(4 * C * mu + (hbar * k) ** 2), np.sqrt(C / mu)
    for chart in (ALPHA_BETA, R_VARTHETA):
        found = revivals(Body(Anharmonic(C), mu), n=(3, 2), m=4, l=-2, hbar=hbar, chart=chart)
        revival = 4 * np.pi / (hbar * omega * (1 / root - (hbar * k) ** 2 / root**3))
        assert found.classical.revival[2, 2] == pytest.approx(revival, rel=1e-8)
        assert found.quantum.revival[2, 2] == pytest.approx(revival, rel=0.01)
        others = found.quantum.revival.copy()
        others[2, 2] = np.inf
        assert np.isinf(others).all()
    # E = hbar omega (2 n_r + 1 + sqrt((2 n_v + 1 + a + b)^2 + 2 mu c/hbar^2))
    rotor = Body(SeparableRVartheta(Spring(1.0, 3.0), Barriers()))
    found = revivals(rotor, n=(1, 12), m=0, l=0, hbar=0.2)
    q = 0.2 * 25
    assert found.classical.names == ("r", "vartheta")
    assert found.classical.period[1] == pytest.approx(2 * np.pi * 0.2 / (2 * 0.2 * q / np.sqrt(q * q + 6)), rel=1e-12)
    assert found.classical.revival[1, 1] == pytest.approx(
        4 * np.pi * 0.2 / (4 * 0.04 * 6 / (q * q + 6) ** 1.5), rel=1e-8
    )
    assert np.isinf(found.classical.revival[0]).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "n"), [(WALLED, (1, 40)), (CORED, (1, 36)), (QUARTIC, (36, 1))], ids=["EQ2.2h", "top", "quartic"]
)
def test_a_packet_revives_when_the_actions_say(body, n):
    """|A| has peaks within a period of the classical revival time and of its half, and has collapsed between.

    What is lost at the revival is the phase (2 pi/3) (E_nnn/E_nn) d^3 of d ~ 1.2 quanta, a few percent at n = 40.
    """
    along = int(np.argmax(n))
    packet = number_packet(body, n=n, m=4, l=0, width=np.where(np.arange(2) == along, 1.2, 0.0), hbar=0.1)
    classical = revivals(body, n=n, m=4, l=0, hbar=0.1).classical
    T, whole = classical.period[along], classical.revival[along, along]

    def best(t):
        return np.abs(packet.autocorrelation(t + np.linspace(-T, T, 4001))).max()

    assert abs(packet.autocorrelation(T)) > 0.97
    assert best(whole / 2) > 0.9  # whole, half a period late
    assert best(whole) > 0.85
    assert best(0.225 * whole) < 0.75  # away from p/q, q <= 5: spread over its torus


@pytest.mark.parametrize(
    ("body", "n", "theta"),
    [(HARMONIC, (20, 14), (0.0, 0.3)), (WALLED, (14, 18), (0.6, 0.8)), (QUARTIC, (18, 12), (0.3, 0.55))],
    ids=["harmonic", "EQ2.2h", "quartic"],
)
def test_number_packets_are_where_their_angles_say(body, n, theta):
    """<alpha^2> and <beta^2> are those of a cloud of phase points on the torus, of angles spread by 1/(4 pi width); and
    later.
    """
    hbar, width = 0.05, 1.4
    packet = number_packet(body, n=n, m=12, l=-4, width=(width, width), theta=(*theta, 0.0, 0.0), hbar=hbar)
    J = 2 * np.pi * hbar * np.array([n[0] + 0.5, n[1] + 0.5, 12, -4])
    nu, time = energy_of_actions(body, J).nu, np.array([0.0, 0.9])
    means = [packet.expectation(f, time=time) for f in (lambda a, b: a * a, lambda a, b: b * b)]
    rng = np.random.default_rng(2)
    spread, everywhere = (
        rng.normal(0, 1 / (4 * np.pi * width), (4, 4000)),
        from_action_angles(body, J, rng.uniform(size=(4, 4000))),
    )
    for i, moment in enumerate(time):
        cloud = from_action_angles(body, J, (np.array([*theta, 0.0, 0.0]) + moment * nu)[:, None] + spread)
        for plane, mean in enumerate(means):
            here, torus = ((z[2 * plane : 2 * plane + 2] ** 2).sum(axis=0) for z in (cloud, everywhere))
            assert mean[i] == pytest.approx(here.mean(), abs=0.05 * np.ptp(torus))  # of a torus far wider than that


def test_a_state_is_its_own_packet():
    """A projected stationary state has one weight, and its density does not move; also in the other charts."""
    state = spectrum(QUARTIC, m=2, l=0, count=12, hbar=0.5).state(7)
    for chart in (ALPHA_BETA, R_VARTHETA, TWO_POLAR):
        packet = projected_packet(
            QUARTIC,
            lambda x, y, chart=chart: 3 * state.amplitude(x, y, chart),
            m=2,
            l=0,
            count=12,
            hbar=0.5,
            chart=chart,
        )
        assert packet.weights.max() == pytest.approx(1, abs=1e-9)
        assert packet.energy == pytest.approx(state.energy, abs=1e-8)
        assert packet.spread < 1e-3
    x = np.linspace(0.3, 1.5, 4)
    np.testing.assert_allclose(
        packet.amplitude(x, x, time=2.0), state.amplitude(x, x, ALPHA_BETA) * np.exp(-4j * state.energy), atol=1e-7
    )
    walled = spectrum(WALLED, m=2, l=0, count=9).state(6)  # ends at det phi = 0
    packet = projected_packet(WALLED, lambda r, v: walled.amplitude(r, v), m=2, l=0, count=9, chart=R_VARTHETA)
    assert packet.weights.max() == pytest.approx(1, abs=1e-9)


def test_too_few_levels_are_refused_with_how_many_do():
    taken = {"width": 0.4, "m": 2, "l": 0, "hbar": 0.5, "missing": 1e-6}
    with pytest.raises(ValueError, match=r"count = 15 .* Try count = \d+") as refused:
        coherent_packet(HARMONIC, Z0 * 1.2, count=15, **taken)
    enough = int(str(refused.value).split("count = ")[-1].rstrip("."))
    assert coherent_packet(HARMONIC, Z0 * 1.2, count=enough, **taken).missing <= 1e-6
    with pytest.raises(ValueError, match=r"leave out 0.12 of the packet, .* Try count > 4"):
        coherent_packet(HARMONIC, Z0 * 1.2, count=1, **taken)
    with pytest.raises(ValueError, match=r"count = 3 levels .* leave out 1 of the packet, .* Try count > 12"):
        projected_packet(HARMONIC, lambda a, b: np.exp(-((a - 9) ** 2) - (b - 9) ** 2), m=0, l=0, count=3)


def test_wrong_input():
    packet = number_packet(HARMONIC, n=(3, 2), m=0, l=0, width=(1, 0))
    for time in (np.nan, [0.0, np.inf]):
        with pytest.raises(ValueError, match="time must be finite"):
            packet.autocorrelation(time)
    with pytest.raises(TypeError, match="time must be real"):
        packet.density(1.0, 1.0, time=1j)
    with pytest.raises(ValueError, match="time must be one number"):
        packet.evolved([0.0, 1.0])
    with pytest.raises(ValueError, match="chart must be"):
        packet.density(1.0, 1.0, ELLIPTIC)
    with pytest.raises(TypeError, match="real values"):
        packet.expectation(lambda a, b: 1j * a)
    states = packet.states[:2]
    for energies, c, hbar, wrong in (
        ([1.0], [1.0, 1.0], 1.0, "energies"),
        ([1.0, 2.0], [1.0], 1.0, "coefficients"),
        ([1.0, np.nan], [1, 1], 1.0, "energies"),
        ([1.0, 2.0], [1.0, np.inf], 1.0, "coefficients"),
        ([1.0, 2.0], [1.0, 1.0], -1.0, "hbar"),
    ):
        with pytest.raises(ValueError, match=wrong):
            Packet(states, energies, c, hbar)
    outside = np.array([0.5, 0, 0.9, 0, 0, 0, 0, 0.0])  # det phi < 0
    with pytest.raises(ValueError, match="z0 must lie in the domain of the potential"):
        coherent_packet(WALLED, outside, width=0.1, count=20)
    good = np.array([1.2, 0, 0.3, 0, 0, 0, 0, 0.0])
    for changed, wrong in (
        ({"width": 0.0}, "width"),
        ({"width": [1, 2, 3]}, "width"),
        ({"hbar": np.nan}, "hbar"),
        ({"m": 2}, "m and l"),
        ({"m": 1, "l": 0}, "even"),
        ({"missing": 0.0}, "missing"),
        ({"count": 0}, "count"),
        ({"m": 90, "l": 0}, "must be of a class of the packet, got 0 of it in m = 90, l = 0"),
    ):
        with pytest.raises(ValueError, match=wrong):
            coherent_packet(HARMONIC, good, **{"width": 0.5, "count": 20} | changed)
    with pytest.raises(ValueError, match="shape"):
        coherent_packet(HARMONIC, good[:4], width=0.5, count=20)
    with pytest.raises(ValueError, match="one phase point"):
        coherent_packet(HARMONIC, np.repeat(good[:, None], 2, axis=1), width=0.5, count=20)
    with pytest.raises(TypeError, match="callable"):
        projected_packet(HARMONIC, 3.0, m=0, l=0, count=3)
    with pytest.raises(ValueError, match="finite"):
        projected_packet(HARMONIC, lambda a, b: a * np.nan, m=0, l=0, count=3)
    with pytest.raises(ValueError, match="vanish"):
        projected_packet(HARMONIC, lambda a, b: 0 * a, m=0, l=0, count=3)
    number = {"n": (3, 2), "m": 0, "l": 0, "width": (1, 0)}
    for changed, wrong in (
        ({"n": (3, -1)}, "n must"),
        ({"width": (1, -1)}, "width"),
        ({"width": (1,)}, "width"),
        ({"theta": (0, 0)}, "theta"),
        ({"m": 1}, "even"),
        ({"theta": (0, 0, 0, np.nan)}, "theta"),
        ({"hbar": 0}, "hbar"),
    ):
        with pytest.raises(ValueError, match=wrong):
            number_packet(HARMONIC, **number | changed)
    for changed, wrong in (
        ({"n": (0, 3)}, "at least 1"),
        ({"maslov": (1,)}, "maslov"),
        ({"hbar": -1.0}, "hbar"),
        ({"n": (1, 2, 3)}, "n"),
    ):
        with pytest.raises(ValueError, match=wrong):
            revivals(HARMONIC, **{"n": (3, 2), "m": 0, "l": 0} | changed)
    with pytest.raises(ValueError, match="model must be separable"):
        revivals(affine_body("(D1**2 + D2**2)/2 + (D1 - D2)**4"), n=(3, 2), m=0, l=0)


def test_a_packet_of_several_classes_has_no_one_amplitude():
    packet = number_packet(HARMONIC, n=(3, 2), m=2, l=0, width=(1, 0, 1, 1), hbar=0.3)
    assert len(packet.classes) > 5
    assert all((m + l) % 2 == 0 for m, l in packet.classes)
    assert "classes" in repr(packet)
    with pytest.raises(ValueError, match="one class"):
        packet.amplitude(1.0, 1.0)
    scales = TimeScales(("r",), np.array([2.0]), np.array([[0.0]]), 1.0)
    assert scales.period == pytest.approx([np.pi])
    assert np.isinf(scales.revival).all()


def test_expectations_of_functions_that_are_not_finite_are_refused():
    packet = number_packet(Body(Harmonic()), n=(1, 1), m=0, l=0, width=(0.0, 0.0))
    with pytest.raises(ValueError, match="function must return finite"):
        packet.expectation(lambda alpha, beta: np.nan * alpha)
    with pytest.raises(ValueError, match=r"y \(beta\) must lie"):
        packet.density(1.0, -1.0)
