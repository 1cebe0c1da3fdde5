"""Operators and levels of bodies that separate in the elliptic chart."""

import numpy as np
import pytest

from fastaff import Body, Harmonic, SeparableElliptic, SeparableRVartheta, univariate
from fastaff.quantum.exact.wavefunction import wavefunction
from fastaff.quantum.reference.operators import constant_operators, hamiltonian_operator
from fastaff.systems.charts import ALPHA_BETA, CARTESIAN, ELLIPTIC, R_VARTHETA, SPHERICAL
from fastaff.systems.models import CoshOscillator, CosOscillator, Spring, Zero

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
    assert CoshOscillator(1.0).value(0.3) + CosOscillator(1.0).value(0.2) > 0
    assert Spring().value(2.0) == 1.0
