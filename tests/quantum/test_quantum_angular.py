"""Levels and states of bodies with angular potentials against Mathieu functions, other matrices and classical tori."""

from itertools import pairwise
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.special import mathieu_a, mathieu_b

from fastaff import action_angles, load, save
from fastaff.core.status import Status
from fastaff.quantum import (
    NoGroundState,
    all_levels,
    husimi,
    level_list,
    projected_packet,
    quasiclassical_levels,
    spectrum,
    spectrum_table,
)
from fastaff.quantum.exact.angle_quanta import AngleQuanta
from fastaff.quantum.solvers.angle_levels import angle_levels
from fastaff.systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA
from fastaff.systems.models import (
    Anharmonic,
    Body,
    Cosine,
    Harmonic,
    HeavyTop,
    Hyperelastic,
    NeoHookean,
    Oscillator,
    SeparableAlphaBeta,
    StackelBody,
    Zero,
    univariate,
)


class Waves(NamedTuple):
    """c0 + sum of a_k cos(k x) + b_k sin(k x) up to k = 4, as a potential of an angle."""

    c0: float
    a1: float = 0.0
    b1: float = 0.0
    a2: float = 0.0
    b2: float = 0.0
    a3: float = 0.0
    b3: float = 0.0
    a4: float = 0.0
    b4: float = 0.0

    def value(self, x):
        low = self.a1 * np.cos(x) + self.b1 * np.sin(x) + self.a2 * np.cos(2 * x) + self.b2 * np.sin(2 * x)
        high = self.a3 * np.cos(3 * x) + self.b3 * np.sin(3 * x) + self.a4 * np.cos(4 * x) + self.b4 * np.sin(4 * x)
        return self.c0 + low + high

    def slope(self, x):
        low = self.b1 * np.cos(x) - self.a1 * np.sin(x) + 2 * (self.b2 * np.cos(2 * x) - self.a2 * np.sin(2 * x))
        high = 3 * (self.b3 * np.cos(3 * x) - self.a3 * np.sin(3 * x))
        return low + high + 4 * (self.b4 * np.cos(4 * x) - self.a4 * np.sin(4 * x))


def fourier(c0, c):
    """Return c0 + sum 2 Re(c_k e^(i k x)) as a potential of an angle."""
    return Waves(c0, *np.ravel(np.array([2 * c.real, -2 * c.imag]).T).tolist())


def independent(c0, c, shift, size=120):
    """Return the levels of -X'' + W X in complex waves e^(i (k + shift) x), ascending."""
    k = np.arange(-size, size + 1) + shift
    H = np.diag((k**2 + c0).astype(complex))
    for j, entry in enumerate(c, 1):
        H += np.diag(np.full(2 * size + 1 - j, entry), -j) + np.diag(np.full(2 * size + 1 - j, np.conj(entry)), j)
    return np.linalg.eigvalsh(H)


def of_oscillators(K_eta, K_gamma, walls, hbar, mu, k, count):
    """Return the lowest levels hbar omega (2 n + 2 + s_alpha + s_beta) of an oscillator with walls."""
    s_alpha, s_beta = (np.sqrt(K + 2 * mu * wall / hbar**2) for K, wall in zip((K_eta, K_gamma), walls, strict=True))
    n = np.arange(30)
    E = 2 * (n[:, None] + n)[..., None, None] + 2 + s_alpha[:, None] + s_beta
    return np.sort(hbar * np.sqrt(k / mu) * E.ravel())[:count]


@pytest.mark.parametrize("seed", range(5))
def test_mathieu(seed):
    """V_eta = a cos 2 eta: characteristic values a_n, b_n of q = mu a/hbar^2 take the place of (m - l)^2/4."""
    rng = np.random.default_rng(seed)
    hbar, mu, C = rng.uniform(0.4, 1.5, 3)
    a, b = rng.uniform(-1.5, 1.5) * C, rng.uniform(-1.0, 1.0)
    body = StackelBody(
        Anharmonic(C),
        univariate(lambda x: a * np.cos(2 * x), lambda x: -2 * a * np.sin(2 * x)),
        univariate(lambda x: 1.5 + b * np.cos(2 * x), lambda x: -2 * b * np.sin(2 * x)),
        mu,
    )
    K = []
    for size, constant in ((a, 0.0), (b, 1.5)):
        q = abs(mu * size / hbar**2)
        K.append(np.sort([*(mathieu_a(k, q) for k in range(14)), *(mathieu_b(k, q) for k in range(1, 14))]))
        K[-1] += 2 * mu * constant / hbar**2
    found = spectrum(body, count=40, hbar=hbar)
    exact = of_oscillators(*K, (2 * C, 0.0), hbar, mu, C, 41)
    assert np.all(np.abs(found.E - exact[:40]) <= found.error + 3e-13 * exact[:40])
    assert found.converged.all()
    assert found.E[-1] <= found.complete_below <= exact[40] * (1 + 1e-12)
    np.testing.assert_allclose(found.constants[2], hbar**2 / (2 * mu) * K[0][found.n[2]], atol=1e-12 * K[0][-1])
    np.testing.assert_allclose(found.constants[:2].sum(axis=0), found.E, rtol=1e-14)


@pytest.mark.parametrize("single_valued", [True, False])
@pytest.mark.parametrize("angle", [Zero(), Cosine(0.0)], ids=["Zero", "Cosine(0)"])
@pytest.mark.parametrize(
    "potential", [Harmonic(1.3), Anharmonic(0.7), HeavyTop(1.0, 0.4)], ids=lambda V: type(V).__name__
)
def test_without_a_potential_the_levels_are_those_of_m_and_l(potential, angle, single_valued):
    how = {"hbar": 0.7, "single_valued": single_valued}
    found = spectrum(StackelBody(potential, angle, angle, 0.8), count=20, **how)
    expected = all_levels(Body(potential, 0.8), max_energy=found.E[-1] * 1.001, **how).upto(20)
    if isinstance(potential, HeavyTop):  # the classes of both calls share other bases
        assert np.all(np.abs(found.E - expected.E) <= found.error + expected.error)
    else:
        assert (found.E == expected.E).all()


@pytest.mark.parametrize("seed", range(5))
def test_levels_of_angles_against_another_matrix(seed):
    """Random Fourier series of all sizes, up to deep wells."""
    rng = np.random.default_rng(100 + seed)
    c = 10 ** rng.uniform(-2, 2.5) * (rng.normal(size=4) + 1j * rng.normal(size=4))
    c0 = rng.normal()
    hbar, mu = rng.uniform(0.3, 2.0, 2)
    V = fourier(c0 * hbar**2 / (2 * mu), c * hbar**2 / (2 * mu))
    count = int(rng.integers(1, 25))
    truth = independent(c0, c, 0.0)
    rounding = 1e-14 * np.abs(truth).max()  # of the reference
    found = angle_levels("V", V, count, hbar, mu, 1e-11, True)
    assert np.all(np.abs(found.K - truth[:count]) <= found.error + rounding)
    both = np.concatenate([truth, independent(c0, c, 0.5)])
    double = angle_levels("V", V, count, hbar, mu, 1e-11, False)
    order = np.argsort(both)[:count]
    assert np.all(np.abs(double.K - both[order]) <= double.error + rounding)
    apart = np.diff(both[np.argsort(both)[: count + 1]]) > 1e-6 * np.abs(both[order]).max()
    sure = apart & np.append(True, apart[:-1])
    assert (double.periodic == (order < truth.size))[sure].all()
    hill = (np.arange(count) + 1) // 2 % 2 == 0
    assert (double.periodic == hill)[sure].all()


def by_pieces(V, edges, count, p=20):
    """Return the lowest levels of -X'' + V X on the circle by polynomials between edges, where V is smooth."""
    x, w = np.polynomial.legendre.leggauss(p + 8)
    basis = np.polynomial.legendre.legvander(x, p)
    slopes = np.array([np.polynomial.legendre.legval(x, np.polynomial.legendre.legder(row)) for row in np.eye(p + 1)]).T
    # hats at both ends, and differences of Legendre polynomials that vanish there
    change = np.zeros((p + 1, p + 1))
    change[:2, 0] = 0.5, -0.5
    change[:2, p] = 0.5, 0.5
    for k in range(1, p):
        change[k + 1, k] = 1.0
        change[k - 1, k] = -1.0
    basis, slopes = basis @ change, slopes @ change
    size = (edges.size - 1) * p
    H = np.zeros((size, size))
    S = np.zeros((size, size))
    for e, (a, b) in enumerate(pairwise(edges)):
        at = (e * p + np.arange(p + 1)) % size
        h = (b - a) / 2
        values = V(a + h * (1 + x))
        H[np.ix_(at, at)] += (slopes.T * w / h) @ slopes + (basis.T * (w * h * values)) @ basis
        S[np.ix_(at, at)] += (basis.T * w * h) @ basis
    return eigh(H, S, eigvals_only=True)[:count]


def test_errors_of_rough_potentials_cover():
    """Potentials with kinks and steps: against polynomials between their kinks."""
    step = np.arccos(0.3)
    ratios = []
    for V, kinks in (
        (lambda x: np.abs(np.sin(x)) ** 3, [0.0]),
        (lambda x: np.abs(np.sin(x)), [0.0]),
        (lambda x: 1.0 * (np.cos(x) > 0.3), [-step, step]),
        (lambda x: np.exp(-np.abs(np.sin(x / 2))), [0.0]),
    ):
        edges = np.union1d(np.linspace(-np.pi, np.pi, 9), kinks)
        for size in (0.7, 4.0):
            truth = by_pieces(lambda x, V=V, size=size: size * V(x), edges, 6)
            rough = SimpleNamespace(value=lambda x, V=V, size=size: size * V(x))
            found = angle_levels("V", rough, 6, 1.0, 0.5, 1e-4, True)
            ratios.append((np.abs(found.K - truth) - 1e-10) / found.error)
    ratios = np.concatenate(ratios)
    assert (ratios <= 1).mean() > 0.98
    assert ratios.max() < 10


ETA = fourier(3.0, np.array([0.4 + 0.2j, -0.3j]))
GAMMA = fourier(2.0, np.array([0.1 - 0.3j, 0.2]))


@pytest.mark.parametrize("potential", [Harmonic(1.2), Anharmonic(0.8)], ids=lambda V: type(V).__name__)
@pytest.mark.parametrize("single_valued", [True, False])
def test_both_charts_have_the_same_levels(potential, single_valued):
    how = {"count": 25, "hbar": 0.6, "single_valued": single_valued}
    first, second = (
        spectrum(StackelBody(potential, ETA, GAMMA, 1.4), chart=c, **how) for c in (ALPHA_BETA, R_VARTHETA)
    )
    assert np.all(np.abs(first.E - second.E) <= first.error + second.error)
    assert first.names == ("alpha", "beta", "eta", "gamma")
    assert second.names == ("r", "vartheta", "eta", "gamma")


def laplacian(psi, q, step):
    """Return the Laplacian of psi at points q (4, ...) by differences of sixth order."""
    total = 0.0
    for unit in np.eye(4):
        d = step * unit[:, None]
        for k, weight in ((1, 1.5), (2, -0.15), (3, 1 / 90)):
            total = total + weight * (psi(q + k * d) + psi(q - k * d) - 2 * psi(q))
    return total / step**2


@pytest.mark.parametrize(
    "body",
    [StackelBody(Harmonic(1.2), ETA, GAMMA, 1.4), StackelBody(Hyperelastic(1.1), ETA, Zero(), 0.9)],
    ids=lambda body: type(body.potential).__name__,
)
def test_states_solve_the_equation_in_four_dimensions(body):
    hbar = 0.9
    levels = spectrum(body, count=12, hbar=hbar)
    rng = np.random.default_rng(5)
    q = rng.normal(size=(4, 40)) * 0.5 + np.array([[1.3], [0.4], [0.2], [0.1]])
    q = q[:, np.hypot(q[2], q[3]) < 0.7 * np.hypot(q[0], q[1])]
    q = q[:, np.hypot(q[2], q[3]) > 0.25]
    for k in (0, 4, 11):
        state = levels.state(k)
        psi = state.planes(q)
        H = -(hbar**2) / (2 * body.mu) * laplacian(state.planes, q, 2e-3) + body.potential_energy(*q) * psi
        np.testing.assert_allclose(H, levels.E[k] * psi, atol=3e-6 * np.abs(psi).max() * levels.E[k])
        assert state.norm() == pytest.approx(1, abs=1e-12)
        assert state.labels == dict(
            zip(
                ("n_r", "n_vartheta") if "r" in levels.names else ("n_alpha", "n_beta"),
                levels.n[:2, k].tolist(),
                strict=True,
            )
        ) | {"n_eta": levels.n[2, k], "n_gamma": levels.n[3, k]}


def test_states_are_orthonormal_and_single_valued():
    body = StackelBody(Harmonic(1.2), ETA, GAMMA, 1.4)
    found = spectrum(body, count=14, hbar=0.6)
    states = [found.state(k) for k in range(14)]
    overlaps = np.array([[one.overlap(other) for one in states] for other in states])
    np.testing.assert_allclose(overlaps, np.eye(14), atol=1e-11)
    matrices = np.random.default_rng(2).normal(size=(2, 2, 6))
    q = ALPHA_BETA.from_planes(np.zeros((8, 6)) + 0.3)[:4]
    q[2:] += np.arange(6)
    psi = states[3].at(q, ALPHA_BETA)
    np.testing.assert_allclose(states[3].at(q + 2 * np.pi * np.array([[0], [0], [1], [-1]])), psi, atol=1e-13)
    assert states[3](matrices).shape == (6,)
    # the norm as an integral over both planes: the mean over the angles is 1
    angle = np.arange(32) * 2 * np.pi / 32
    radial = states[3].amplitude(0.9, 0.7) ** 2
    mean = (np.array([states[3].at([0.9, 0.7, x, y]) for x in angle for y in angle]) ** 2).mean()
    assert mean == pytest.approx(radial, rel=1e-12)


def test_tables_with_their_states_are_kept_in_files(tmp_path):
    found = spectrum(StackelBody(Anharmonic(1.2), ETA, GAMMA, 1.4), count=6, hbar=0.6)
    save(tmp_path / "levels.npz", found)
    again = load(tmp_path / "levels.npz")
    assert (again.E == found.E).all()
    assert again.state(5).symmetry == found.state(5).symmetry
    assert again.state(5).overlap(found.state(5)) == pytest.approx(1, abs=1e-12)


def test_states_of_the_double_cover_change_sign():
    body = StackelBody(Harmonic(1.2), ETA, GAMMA, 1.4)
    found = spectrum(body, count=30, hbar=0.6, single_valued=False)
    single = spectrum(body, count=8, hbar=0.6).E
    assert np.abs(single[single < found.E[-1], None] - found.E).min(axis=1).max() < 1e-12
    q = np.array([0.9, 0.7, 0.3, 1.1])
    turned = q + np.array([0, 0, 2 * np.pi, 0])
    seen = set()
    for k in range(30):
        state = found.state(k)
        sign = 1 if state.symmetry.single_valued else -1
        seen.add(sign)
        assert state.at(turned) == pytest.approx(sign * state.at(q), abs=1e-13)
        assert sign == (1 if (found.n[2, k] + 1) // 2 % 2 == 0 else -1)
    assert seen == {1, -1}
    with pytest.raises(ValueError, match="two values"):
        found.state(int(np.flatnonzero(found.n[2] == 1)[0])).planes([1.0, 0, 0, 0])


def test_lists_are_complete():
    body = StackelBody(Harmonic(1.2), ETA, GAMMA, 1.4)
    found = all_levels(body, max_energy=6.2, hbar=0.6)
    more = spectrum(body, count=len(found) + 1, hbar=0.6)
    assert (more.E[:-1] == found.E).all()
    assert more.E[-1] >= 6.2
    assert found.complete_below == 6.2
    assert found.state(1).norm() == pytest.approx(1, abs=1e-12)
    multiplets = all_levels(StackelBody(Harmonic(), Zero(), Zero()), multiplets=5).multiplets()
    assert multiplets.degeneracy.tolist() == [1, 4, 10, 20, 35]
    one = spectrum(body, n_eta=2, n_gamma=1, count=4, hbar=0.6)
    some = more.take((more.n[2] == 2) & (more.n[3] == 1))
    assert np.abs(some.E[:4] - one.E[: len(some)]).max() <= 2e-13
    assert level_list([one, found]).names == found.names


def test_levels_of_a_body_that_dissociates():
    """A well of finite depth: the levels below an energy, though the body binds only a few."""
    well = univariate(lambda q: -6 * np.exp(-(q**2)), lambda q: 12 * q * np.exp(-(q**2)))
    body = StackelBody(SeparableAlphaBeta(Oscillator(1.0), well), Zero(), Cosine(0.0), 2.0)
    found = all_levels(body, max_energy=-2.0, hbar=1.0)
    expected = all_levels(Body(body.potential, 2.0), max_energy=-2.0, hbar=1.0)
    assert len(found) == len(expected) > 2
    assert np.all(np.abs(found.E - expected.E) <= found.error + expected.error)


def test_attracting_levels_fall_to_the_centre():
    attracting = univariate(lambda x: np.cos(2 * x), lambda x: -2 * np.sin(2 * x))
    body = StackelBody(Harmonic(), attracting, Zero())
    with pytest.raises(
        NoGroundState, match=r"V_eta must have no level below 0.*the body falls to the centre alpha = 0"
    ):
        spectrum(body, count=2)
    with pytest.raises(NoGroundState, match=r"V_gamma must.*centre beta = 0"):
        all_levels(StackelBody(Hyperelastic(), Zero(), attracting), max_energy=9.0)
    level = spectrum(body, n_eta=2, n_gamma=0, count=1)  # repels: its own class has a ground state
    assert level.E[0] == pytest.approx(2 + np.sqrt(mathieu_a(1, 1.0)), rel=1e-12)
    walled = spectrum(StackelBody(Anharmonic(), attracting, Zero()), count=1)
    assert walled.E[0] == pytest.approx(2 + np.sqrt(4 + mathieu_a(0, 1.0)), rel=1e-12)


# Quasiclassical levels


@pytest.mark.parametrize("seed", range(4))
def test_actions_of_angles_are_those_of_tori(seed):
    rng = np.random.default_rng(seed)
    V = fourier(8.0, rng.normal(size=3) + 1j * rng.normal(size=3))
    mu = rng.uniform(0.5, 2.0)
    quanta = AngleQuanta(V, mu, 1.0, 1)
    z = rng.normal(size=(8, 30))
    tori = action_angles(StackelBody(Harmonic(1.2), V, Zero(), mu), z)
    compared = 0
    for k in np.flatnonzero(tori.status == 0):
        c = tori.constants[2, k]
        actions = [quanta._libration(well, c) for well in quanta._wells if well.low < c < well.high]
        actions = actions or [quanta._rotation(c)]
        assert min(abs(J - abs(tori.J[2, k])) for J in actions) < 1e-9 * (1 + actions[0])
        compared += 1
    assert compared > 20


def test_quasiclassical_levels_tend_to_the_exact_ones():
    wall = fourier(6.0, np.array([0.5 + 0.4j, 1.2]))
    errors = []
    for hbar in (0.4, 0.1):
        exact = angle_levels("V", wall, 40, hbar, 1.0, 1e-10, True).K * hbar**2 / 2
        quanta = AngleQuanta(wall, 1.0, 2 * np.pi * hbar, 1)
        levels = np.array([quanta.level(k) for k in range(40)])
        away = np.abs(levels - quanta._top) > 2 * hbar  # not next to the separatrix
        errors.append(np.nanmax(np.abs(levels - exact)[away]))
    assert errors[1] < 0.25 * errors[0]


@pytest.mark.parametrize("single_valued", [True, False])
def test_quasiclassical_levels_without_angular_potentials_are_exact(single_valued):
    body = StackelBody(Anharmonic(0.7), Zero(), Zero(), 1.2)
    found = quasiclassical_levels(body, max_energy=5.0, hbar=0.8, single_valued=single_valued)
    exact = all_levels(Body(Anharmonic(0.7), 1.2), max_energy=5.0, hbar=0.8, single_valued=single_valued)
    np.testing.assert_allclose(found.E, exact.E, rtol=1e-12)
    same = quasiclassical_levels(body, n=found.n, hbar=0.8, single_valued=single_valued)
    np.testing.assert_allclose(same.E, found.E, rtol=1e-13)


def test_quasiclassical_levels_stand_beside_the_exact_ones():
    deep = univariate(lambda x: 30 + 20 * np.cos(2 * x) + 7 * np.sin(x), lambda x: -40 * np.sin(2 * x) + 7 * np.cos(x))
    attracting = univariate(lambda x: 8 * np.cos(x), lambda x: -8 * np.sin(x))
    for angles in ((deep, Zero()), (attracting, Zero())):
        body = StackelBody(Anharmonic(12.0), *angles, 1.3)
        exact = spectrum(body, count=12, hbar=0.3)
        found = quasiclassical_levels(body, n=exact.n, hbar=0.3)
        assert np.abs(found.E - exact.E).max() < 2e-3 * exact.E[0]
    with_gap = quasiclassical_levels(StackelBody(Harmonic(), Cosine(1e-3), Zero()), n=[[0, 0], [0, 0], [0, 1], [0, 0]])
    assert with_gap.status.tolist() == [Status.UNBOUND, Status.OK]  # no torus is as slow as the lowest level


HARMONIC = StackelBody(Harmonic(), ETA, GAMMA)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: spectrum(HARMONIC, m=0, l=0, count=1), ValueError, "m must be None"),
        (lambda: spectrum(HARMONIC, n_eta=0, count=1), ValueError, "together"),
        (lambda: spectrum(HARMONIC, n_eta=-1, n_gamma=0, count=1), ValueError, "n_eta must be at least 0"),
        (lambda: spectrum(HARMONIC, n_eta=0.5, n_gamma=0, count=1), TypeError, "n_eta"),
        (
            lambda: spectrum(HARMONIC, n_eta=1, n_gamma=0, count=1, single_valued=False),
            ValueError,
            "levels of one period",
        ),
        (lambda: spectrum(HARMONIC, count=0), ValueError, "count"),
        (lambda: spectrum(HARMONIC, count=1, hbar=-1.0), ValueError, "hbar"),
        (lambda: spectrum(HARMONIC, count=1, tolerance=0.0), ValueError, "tolerance"),
        (lambda: spectrum(HARMONIC, count=1, chart=ELLIPTIC), ValueError, "alpha-beta or r-vartheta"),
        (lambda: spectrum(StackelBody(NeoHookean(), ETA, GAMMA), count=1), ValueError, "separable"),
        (lambda: spectrum(Body(Harmonic()), m=0, l=0, n_eta=0, count=1), ValueError, "n_eta must be None"),
        (lambda: spectrum_table(HARMONIC, m=[0], l=[0], count=1), TypeError, "angular potentials"),
        (
            lambda: spectrum(StackelBody(Harmonic(), univariate(lambda x: np.sin(x / 2)), Zero()), count=1),
            ValueError,
            "V_eta must have the period 2 pi",
        ),
        (
            lambda: spectrum(
                StackelBody(Harmonic(), Zero(), univariate(lambda x: 1 / np.maximum(np.cos(x), 0.0))), count=1
            ),
            ValueError,
            "V_gamma must be finite",
        ),
        (lambda: husimi(spectrum(HARMONIC, count=1).state(0)), ValueError, "must have m and l"),
        (
            lambda: (
                spectrum(HARMONIC, count=1).state(0).overlap(spectrum(Body(Harmonic()), m=0, l=0, count=1).state(0))
            ),
            ValueError,
            "other must be a state",
        ),
        (lambda: quasiclassical_levels(HARMONIC, n=(0, 0), m=0, l=0), ValueError, "m must be None"),
        (lambda: quasiclassical_levels(HARMONIC, n=(0, 0)), ValueError, r"shape \(4,\)"),
        (lambda: quasiclassical_levels(HARMONIC, n=(0, 0, 1, 0), single_valued=False), ValueError, "one period"),
        (lambda: quasiclassical_levels(HARMONIC), ValueError, "give either n or max_energy"),
        (lambda: quasiclassical_levels(HARMONIC, n=(0, 0, 0, 0), chart=ELLIPTIC), ValueError, "alpha-beta"),
        (
            lambda: quasiclassical_levels(StackelBody(Harmonic(), Cosine(1.0), Zero()), n=(0, 0, 0, 0), hbar=1e-6),
            ValueError,
            "hbar must be larger",
        ),
    ],
)
def test_bad_input(call, error, words):
    with pytest.raises(error, match=words) as raised:
        call()
    assert len(str(raised.value)) <= 160


def test_packets_of_states():
    """States of angular potentials make packets as others do."""
    from fastaff.quantum import Packet

    found = spectrum(HARMONIC, count=3)
    packet = Packet(tuple(found.state(k) for k in range(3)), found.E, np.array([0.6, 0.0, 0.8j]), 1.0)
    q = np.array([0.9, 0.1, 0.5, 0.4])
    assert packet.planes(q) == pytest.approx(0.6 * found.state(0).planes(q) + 0.8j * found.state(2).planes(q))
    assert packet.density(0.9, 0.5) == pytest.approx(
        0.36 * found.state(0).density(0.9, 0.5) + 0.64 * found.state(2).density(0.9, 0.5)
    )
    with pytest.raises(ValueError, match="angular potentials"):
        projected_packet(HARMONIC, lambda alpha, beta: np.exp(-alpha - beta), m=0, l=0, count=3)
