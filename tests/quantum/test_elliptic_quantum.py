"""Operators and levels of bodies that separate in the elliptic chart."""

from typing import NamedTuple

import numpy as np
import pytest

from fastaff import Anharmonic, Body, Harmonic, SeparableElliptic, SeparableRVartheta, load, univariate
from fastaff.quantum import NoGroundState, all_levels, number_packet, spectrum
from fastaff.quantum.exact.wavefunction import wavefunction
from fastaff.quantum.reference.operators import constant_operators, hamiltonian_operator
from fastaff.quantum.solvers.elliptic import Unresolved, elliptic_levels
from fastaff.quantum.solvers.nonseparable import plane_levels
from fastaff.quantum.states.symmetry import SymmetryClass
from fastaff.systems.charts import ALPHA_BETA, CARTESIAN, ELLIPTIC, R_VARTHETA, SPHERICAL
from fastaff.systems.models import CosOscillator, Zero

STEP = 0.05
"""Step of differences of differences."""


def bumpy_kappa(k):
    return 0.7 * np.cosh(2 * k) ** 2 + 0.4 * np.cosh(k)


def bumpy_lambda(x):
    return -0.7 * np.cos(2 * x) ** 2 + 0.3 * np.sin(x) ** 2


BUMPY = Body(SeparableElliptic(univariate(bumpy_kappa), univariate(bumpy_lambda)), mu=0.8)
CENTRAL = Body(SeparableRVartheta(univariate(lambda r: 0.3 * r + 0.1 * r * r), Zero()), mu=1.3)


def smooth(q):
    """A function of matrix elements without symmetry."""
    x, y, z, u = q
    return np.exp(0.3j * x - 0.2 * u**2 + 0.1 * y * z) * (1 + y * z + 0.5 * x * u**2 - 0.3j * y)


def in_chart(chart, function):
    return lambda q: function(CARTESIAN.points_from_planes(chart.points_to_planes(q)))


def applied(operator, function):
    return lambda q: operator(function, q, step=STEP)


@pytest.mark.parametrize(("body", "chart"), [(BUMPY, ELLIPTIC), (CENTRAL, SPHERICAL)], ids=["elliptic", "spherical"])
def test_constants_commute_with_each_other_and_sum_to_h(body, chart):
    hbar = 0.7
    planes = np.random.default_rng(3).uniform(0.5, 1.1, (4, 6)) * np.array([[1.6], [1], [1], [-1]])
    q = chart.points_from_planes(planes)
    f = in_chart(chart, smooth)
    operators = constant_operators(body, chart, hbar=hbar)
    expected = hamiltonian_operator(body, CARTESIAN, hbar=hbar)(smooth, CARTESIAN.points_from_planes(planes))
    scale = np.abs(expected).max()
    assert np.abs(operators["H"](f, q) - expected).max() < 1e-9 * scale
    if chart is ELLIPTIC:
        total = operators["K"](f, q) + operators["L"](f, q)
        assert np.abs(total - expected).max() < 1e-9 * scale
    names = list(operators)
    for i, first in enumerate(names):
        for second in names[:i]:
            one = applied(operators[first], applied(operators[second], f))(q)
            other = applied(operators[second], applied(operators[first], f))(q)
            assert np.abs(one - other).max() < 1e-6 * np.abs(one).max(), (first, second)
    if chart is ELLIPTIC:  # the printed sign of K gives no constant
        H = operators["H"]
        printed = operators["L"].scaled(lambda q: 1 / np.tanh(q[0]) ** 2)
        one, other = applied(H, applied(printed, f))(q), applied(printed, applied(H, f))(q)
        assert np.abs(one - other).max() > 1e-3 * np.abs(one).max()


def test_k_of_the_harmonic_body_on_known_waves():
    """K = H_alpha + h_vartheta/2 - C/4 on closed wave functions, where h_vartheta acts by its own operator."""
    rng = np.random.default_rng(7)
    planes = rng.uniform(0.4, 0.9, (4, 5)) * np.array([[2], [1], [1], [1]])
    for C, mu, hbar in rng.uniform(0.5, 1.5, (2, 3)):
        body = Body(Harmonic(C), mu=mu)
        K = constant_operators(body, ELLIPTIC, hbar=hbar)["K"]
        h = constant_operators(body, R_VARTHETA, hbar=hbar)["h_vartheta"]
        for m, l, n in ((0, 0, (0, 0)), (2, 0, (1, 2))):
            state = wavefunction(body, m=m, l=l, n=n, hbar=hbar, chart=ALPHA_BETA)
            Psi = state.at(ALPHA_BETA.points_from_planes(planes), ALPHA_BETA)
            shear = h(lambda x, s=state: s.at(x, R_VARTHETA), R_VARTHETA.points_from_planes(planes))
            found = K(lambda x, s=state: s.at(x, ELLIPTIC), ELLIPTIC.points_from_planes(planes))
            expected = (state.constants["E_alpha"] - C / 4) * Psi + shear / 2
            assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    # the lowest state of a class is an eigenstate of all
    state = wavefunction(Body(Harmonic()), m=2, l=0, n=(0, 0))
    q = ELLIPTIC.points_from_planes(planes)
    e = ((1 + 1 + 1) ** 2 - 1) / 2
    K = constant_operators(Body(Harmonic()), ELLIPTIC)["K"](lambda x: state.at(x, ELLIPTIC), q)
    np.testing.assert_allclose(K, (state.constants["E_alpha"] + e / 2 - 0.25) * state.at(q, ELLIPTIC), rtol=1e-9)


class Polynomial(NamedTuple):
    """V_kappa = C/2 cosh^2(2 kappa) + p s^3 + q s^4 or V_lambda = -C/2 cos^2(2 lambda) + p t^3 - q t^4.

    As s^3 + t^3 = (s + t)(d^2 + s t) and s^4 - t^4 = (s + t) d (d^2 + 2 s t) with d = s - t = (A + B)/2 - 1 and
    s t = B/2, V is a polynomial: C (A + B)/2 + p (d^2 + B/2)/2 + q d (d^2 + B)/2.
    """

    C: float
    p: float
    q: float
    sign: float

    def value(self, x):
        square = np.sinh(x) ** 2 if self.sign > 0 else np.sin(x) ** 2
        double = 1 + 2 * self.sign * square
        return self.sign * (self.C * double**2 / 2 + self.q * square**4) + self.p * square**3

    def slope(self, x):
        square = np.sinh(x) ** 2 if self.sign > 0 else np.sin(x) ** 2
        rate = np.sinh(2 * x) if self.sign > 0 else np.sin(2 * x)
        double = 1 + 2 * self.sign * square
        inner = 2 * self.C * double * self.sign + 4 * self.q * square**3
        return (self.sign * inner + 3 * self.p * square**2) * rate


def polynomial_body(C, p, q, mu):
    return Body(SeparableElliptic(Polynomial(C, p, q, 1.0), Polynomial(C, p, q, -1.0)), mu=mu)


def levels_by_oscillators(C, p, q, mu, hbar, m, l, stiffness, size):
    """Lowest 8 levels, and round-off, of the polynomial potential in products of `size` functions of alpha and beta.

    The matrices of A and B are tridiagonal; products of them on larger spaces, cut down, are exact.
    """
    omega = np.sqrt(stiffness / mu)
    larger = size + 4

    def plane(index):
        n = np.arange(larger)
        square = np.diag(2 * n + index + 1.0)
        square -= np.diag(np.sqrt((n[1:]) * (n[1:] + index)), 1) + np.diag(np.sqrt((n[1:]) * (n[1:] + index)), -1)
        return hbar / (mu * omega) * square, hbar * omega * (2 * n + index + 1)

    (A, E_a), (B, E_b) = plane(abs(m - l) / 2), plane(abs(m + l) / 2)

    def product(i, j):
        """A^i B^j between functions of the small space."""
        a, b = (np.linalg.matrix_power(M, k)[:size, :size] for M, k in ((A, i), (B, j)))
        return np.kron(a, b)

    one = product(0, 0)
    sum_ = product(1, 0) + product(0, 1)
    second = product(2, 0) + 2 * product(1, 1) + product(0, 2)
    third = product(3, 0) + 3 * product(2, 1) + 3 * product(1, 2) + product(0, 3)
    d2 = second / 4 - sum_ + one
    d3 = third / 8 - 3 * second / 4 + 3 * sum_ / 2 - one
    dB = (product(1, 1) + product(0, 2)) / 2 - product(0, 1)
    V = C * sum_ / 2 + p * (d2 + product(0, 1) / 2) / 2 + q * (d3 + dB) / 2
    H = np.diag((E_a[:size, None] + E_b[:size]).ravel()) - stiffness * sum_ / 2 + V
    values = np.linalg.eigvalsh(H)
    return values[:8], 8 * np.finfo(float).eps * values[-1]


@pytest.mark.parametrize(("m", "l"), [(0, 0), (1, 1), (3, -1), (-2, 4)])
def test_levels_of_oscillators_in_the_elliptic_chart(m, l):
    rng = np.random.default_rng(abs(10 * m + l))
    C, mu, hbar = rng.uniform(0.4, 2.0, 3)
    for potential in (Harmonic(C), Anharmonic(C)):
        exact = spectrum(Body(potential, mu=mu), m=m, l=l, count=8, hbar=hbar).E
        found = spectrum(Body(potential.elliptic, mu=mu), m=m, l=l, count=8, hbar=hbar)
        assert found.names == ("kappa", "lambda")
        off = np.abs(found.E - exact)
        assert np.all(off <= found.error)
        assert np.all(found.error <= 1e-13 * np.abs(exact))  # within 100 times of round-off
        assert found.state(3).norm() == pytest.approx(1.0, abs=1e-8)
        assert len(set(map(tuple, found.n.T.tolist()))) == 8
    # E and the quantum numbers do not depend on the form of the body
    direct = spectrum(Body(Anharmonic(C), mu=mu), m=m, l=l, count=8, hbar=hbar, chart=ELLIPTIC)
    np.testing.assert_allclose(direct.E, found.E, rtol=1e-13)


@pytest.mark.parametrize("case", range(4))
def test_levels_of_random_elliptic_bodies(case):
    """Against products of oscillators, which know nothing of the elliptic chart."""
    rng = np.random.default_rng(100 + case)
    C, mu, p, q = rng.uniform([0.5, 0.5, 0.2, 0.0], [1.5, 1.5, 1.5, 0.3])
    m, l = [(0, 0), (2, 0), (1, -1), (3, 3)][case]
    found = spectrum(polynomial_body(C, p, q, mu), m=m, l=l, count=8)
    fine, rounding = levels_by_oscillators(C, p, q, mu, 1.0, m, l, 3.0 * C, 26)
    coarse, _ = levels_by_oscillators(C, p, q, mu, 1.0, m, l, 3.0 * C, 23)
    unsure = np.abs(fine - coarse) + rounding
    off = np.abs(found.E - fine)
    assert unsure.max() < 1e-9
    assert np.all(off <= found.error + unsure)
    assert np.all(found.error <= 1e-12 * np.abs(fine))
    assert np.all(found.status == 0)


def test_states_solve_both_equations_and_are_orthonormal():
    """A body with a singular focus: H Psi = E Psi and K Psi = K Psi by differences, at random points."""
    hbar = 0.7
    table = spectrum(BUMPY, m=1, l=-1, count=5, hbar=hbar)
    planes = np.random.default_rng(9).uniform(0.5, 1.0, (4, 6)) * np.array([[1.5], [1], [1], [-1]])
    H = hamiltonian_operator(BUMPY, CARTESIAN, hbar=hbar)
    K = constant_operators(BUMPY, ELLIPTIC, hbar=hbar)["K"]
    states = [table.state(k) for k in range(5)]
    for k, state in enumerate(states):
        x, q = CARTESIAN.points_from_planes(planes), ELLIPTIC.points_from_planes(planes)
        scale = np.abs(state.planes(planes)).max()
        left = H(lambda x, s=state: s.at(x, CARTESIAN), x)
        assert np.abs(left - table.E[k] * state.planes(planes)).max() < 1e-7 * abs(table.E[k]) * scale
        left = K(lambda q, s=state: s.at(q, ELLIPTIC), q)
        assert np.abs(left - table.constants[1, k] * state.planes(planes)).max() < 1e-7 * abs(table.E[k]) * scale
    overlaps = np.array([[one.overlap(other, order=120) for one in states] for other in states])
    np.testing.assert_allclose(overlaps, np.eye(5), atol=1e-5)


def test_channels_agree():
    body = polynomial_body(1.0, 0.8, 0.1, 1.0)
    two = spectrum(body, m=0, l=0, count=3)
    general = plane_levels(body, SymmetryClass(0, 0), 3, 1.0, 1e-2)
    assert np.all(np.abs(general.E - two.E) <= general.error + two.error)


def test_all_levels_of_an_elliptic_body_are_complete():
    C, mu = 0.9, 1.2
    omega = np.sqrt(C / mu)
    levels = all_levels(Body(Harmonic(C).elliptic, mu=mu), max_energy=4.5 * omega)
    multiplets = levels.multiplets()
    np.testing.assert_allclose(multiplets.E, omega * np.arange(2, 5), rtol=1e-12)
    np.testing.assert_array_equal(multiplets.degeneracy, [1, 4, 10])


def test_kinks_and_inner_walls_are_not_expanded_in_one_polynomial():
    class Bent(NamedTuple):
        def value(self, x):
            return 0.5 * np.cosh(2 * x) ** 2 + np.abs(x - 0.8)

        def slope(self, x):
            return np.sinh(4 * x) + np.sign(x - 0.8)

    class Walled(NamedTuple):
        def value(self, x):
            return np.where(x < 0.3, np.inf, 0.5 * np.cosh(2 * x) ** 2)

    for V_kappa in (Bent(), Walled()):
        with pytest.raises(Unresolved):
            elliptic_levels(V_kappa, CosOscillator(1.0), 0.0, 0.0, 2, 1.0, 1.0, 1e-10, np.inf)


def test_bad_input():
    body = Body(Harmonic().elliptic)
    for call, error, message in (
        (lambda: spectrum(body, m=0, l=0, count=0), ValueError, "count must be at least 1"),
        (lambda: spectrum(body, m=1, l=0, count=2), ValueError, r"m \+ l must be even"),
        (lambda: spectrum(body, m=0, l=0, count=2, chart=R_VARTHETA), ValueError, "in two coordinates .elliptic."),
        (lambda: constant_operators(body, SPHERICAL, hbar=-1.0), ValueError, "hbar must be positive"),
        (lambda: constant_operators(Body(Harmonic()), CARTESIAN), ValueError, "chart must be alpha-beta"),
    ):
        with pytest.raises(error, match=message):
            call()
    free = Body(SeparableElliptic(univariate(lambda x: 0.0 * x + 0.3), univariate(lambda x: 0.0 * x)))
    with pytest.raises(NoGroundState):
        spectrum(free, m=0, l=0, count=2)


def test_packets_of_elliptic_numbers_revive():
    packet = number_packet(Body(Harmonic()), n=(3, 2), m=0, l=0, width=(1.0, 0.0), chart=ELLIPTIC)
    np.testing.assert_allclose(np.abs(packet.autocorrelation([0.0, np.pi])), 1.0, atol=1e-9)


def test_waves_are_kept_in_files(tmp_path):
    table = spectrum(Body(Harmonic().elliptic), m=1, l=1, count=3)
    table.save(tmp_path / "levels.npz")
    again = load(tmp_path / "levels.npz")
    planes = np.random.default_rng(2).uniform(0.3, 1.0, (4, 5))
    np.testing.assert_array_equal(again.state(2).planes(planes), table.state(2).planes(planes))
