"""Spectra of separable bodies against closed forms, reference numbers of 20 digits, scaling laws and finite
differences.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import jn_zeros

import fastaff as fa
from fastaff import (
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    NeoHookean,
    SeparableAlphaBeta,
    SeparableRVartheta,
    univariate,
)
from fastaff.quantum.reference.operators import hamiltonian_operator, spin
from fastaff.quantum.solvers.separable import angular, radial
from fastaff.quantum.solvers.singular_ends import NoGroundState
from fastaff.quantum.spectra.spectrum import spectrum, spectrum_table
from fastaff.systems.charts import CARTESIAN, to_matrix
from fastaff.systems.models import Barriers, Cosine, Oscillator, Secant, Spring, StackelBody, Zero

# mu = C = hbar = 1; (m, l, n_vartheta): e_vartheta. Two methods each, agreed to 30 digits: Frobenius series matched
# inside, and Galerkin in 40-digit arithmetic.
EQ22H = {
    (0, 0, 0): 6.9283665548532502203,
    (0, 0, 1): 28.020341308083547668,
    (0, 0, 2): 64.621986716763465379,
    (0, 0, 3): 117.03169092428746265,
    (1, 1, 0): 15.035365122067779735,
    (1, 1, 3): 148.57777461706187430,
    (2, 0, 0): 15.652106622436395063,
    (2, 0, 3): 149.21382032275343460,
    (1, -1, 0): 7.5,
    (1, -1, 1): 28.641095738648536310,
}
TOP = {
    (0, 0, 0): -0.082101586964610200954,
    (0, 0, 1): 4.0487380565091985963,
    (0, 0, 3): 24.005556977352969811,
    (1, 1, 0): 1.1313221385884104089,
    (2, 0, 2): 24.004165782724398543,
    (1, -1, 0): 1.7947307970083132269,
    (1, -1, 2): 17.535155006622446063,
}
CRITICAL_A = 2.5572595087999248905
QUARTIC = univariate(lambda x: x**4)


@pytest.mark.parametrize(
    ("potential", "table"), [(Hyperelastic(), EQ22H), (HeavyTop(), TOP)], ids=["EQ2.2h", "heavy top"]
)
def test_reference_numbers(potential, table):
    for (m, l, n), e in table.items():
        found = spectrum(Body(potential), m=m, l=l, count=40, tolerance=1e-12)
        wanted = 2 * np.arange(3) + 1 + np.sqrt(1 + 2 * e)
        for n_r in range(3):
            row = np.flatnonzero((found.n == [[n_r], [n]]).all(axis=0))
            assert found.E[row] == pytest.approx(wanted[n_r], rel=1e-13)
        assert found.converged.all()
        assert np.all(np.diff(found.E) >= 0)


@pytest.mark.parametrize(("m", "l"), [(1, -1), (2, -2), (3, -1), (3, -3), (4, -2)])
def test_the_elementary_state_of_the_hyperelastic_body(m, l):
    """2 mu C/hbar^2 = |m - l| - |m + l|: f = cos(v) sin^b(v/2) cos^a(v/2), E = hbar omega (4 + 2 s), s = (a + b)/2."""
    hbar, mu = 0.7, 1.9
    C = (abs(m - l) - abs(m + l)) * hbar**2 / (2 * mu)
    found = spectrum(Body(Hyperelastic(C), mu), m=m, l=l, count=3, hbar=hbar)
    a, b = abs(m - l) / 2, abs(m + l) / 2
    assert found.E[0] == pytest.approx(hbar * np.sqrt(C / mu) * (4 + a + b), rel=1e-13)
    v = np.linspace(0.01, np.pi / 2 - 0.01, 50)
    f = found.state(0).shape.factors[1](v)
    assert np.ptp(f / (np.cos(v) * np.sin(v / 2) ** b * np.cos(v / 2) ** a)) < 1e-10 * np.abs(f).max()


def test_the_critical_heavy_top():
    """The lowest e_vartheta reaches -hbar^2/(2 mu) at A = 2.557...; beyond it there is no ground state."""
    e = angular("V", Cosine(CRITICAL_A), np.zeros(1), np.zeros(1), 1, 1.0, 1.0, 1e-12)
    assert e.values[0, 0] == pytest.approx(-0.5, abs=1e-13)
    near = spectrum(Body(HeavyTop(A=CRITICAL_A * (1 - 1e-9))), m=0, l=0, count=1)
    assert near.E[0] == pytest.approx(1.0, abs=1e-4)
    for A in (CRITICAL_A * (1 + 1e-9), -3.0):
        with pytest.raises(NoGroundState, match="no lower bound"):
            spectrum(Body(HeavyTop(A=A)), m=0, l=0, count=1)
    assert spectrum(Body(HeavyTop(A=3.0)), m=2, l=0, count=1).E[0] > 0  # its centrifugal term holds


@settings(max_examples=15, deadline=None)
@given(
    m=st.integers(-6, 6),
    half=st.integers(-5, 5),
    C=st.floats(0.05, 20),
    mu=st.floats(0.1, 10),
    hbar=st.floats(0.05, 3),
    wall=st.booleans(),
    chart=st.sampled_from(["alpha-beta", "r-vartheta"]),
)
def test_harmonic_and_anharmonic_closed_forms(m, half, C, mu, hbar, wall, chart):
    """EQ5.1 and EQ5.2, in both charts: level n = n_1 + n_2 with multiplicity n + 1."""
    l = m + 2 * half
    body = Body(Anharmonic(C) if wall else Harmonic(C), mu)
    found = spectrum(body, m=m, l=l, count=10, hbar=hbar, chart=chart)
    chi = np.sqrt((m - l) ** 2 + (16 * C * mu / hbar**2 if wall else 0))
    n = np.repeat(np.arange(4), np.arange(1, 5))
    np.testing.assert_allclose(found.E, hbar * np.sqrt(C / mu) / 2 * (4 * n + 4 + abs(m + l) + chi), rtol=1e-12)
    assert sorted(found.n.sum(axis=0)) == list(n)


@pytest.mark.parametrize(
    ("V", "exact"), [(lambda q: 0.8 * q**2, Oscillator(1.6)), (lambda q: 0.8 * q**2 + 0.3 / q**2, Oscillator(1.6, 0.3))]
)
def test_numerical_factors_meet_closed_ones(V, exact):
    """The Galerkin solution of what is an oscillator, given as a plain function: values, functions, normalisation."""
    K = np.array([0.0, 1.0, 36.0])
    for dimension, function, closed in ((2, V, exact), (4, lambda r: V(np.sqrt(r)), Spring(exact.k, exact.c))):
        numerical = radial("V", univariate(function), dimension, K, 6, 0.9, 1.7, 1e-12)
        truth = radial("V", closed, dimension, K, 6, 0.9, 1.7, 1e-12)
        assert numerical.values == pytest.approx(truth.values, rel=1e-12)
        x = np.linspace(0.05, 4, 40)
        for i in range(3):
            for j in (0, 5):
                assert numerical.functions(i, j)(x) == pytest.approx(truth.functions(i, j)(x), abs=1e-9)


def test_numerical_angles_meet_closed_ones():
    """Barriers as a plain function; whatever smooth V: e grows by its constant."""
    body = SeparableRVartheta(Spring(1.0), univariate(lambda v: 0.7 / np.cos(v / 2) ** 2 + 0.2 / np.sin(v / 2) ** 2))
    twin = SeparableRVartheta(Spring(1.0), Barriers(0.7, 0.2))
    for m, l in ((0, 0), (3, -1)):
        E = spectrum(Body(body), m=m, l=l, count=12).E
        s = np.sqrt(((m - l) / 2) ** 2 + 1.4) + np.sqrt(
            ((m + l) / 2) ** 2 + 0.4
        )  # e = (2 hbar^2/mu)(n + s/2)(n + s/2 + 1), E from it
        n = np.repeat(np.arange(5), np.arange(1, 6))[:12]
        np.testing.assert_allclose(E, 2 * n + 2 + s, rtol=1e-11)
        np.testing.assert_allclose(spectrum(Body(twin), m=m, l=l, count=12).E, E, rtol=1e-11)


def test_quartic_scaling_and_finite_differences():
    """E ~ (hbar^4/mu^2)^(1/3) for V = q^4, exactly; and a difference scheme of second order, extrapolated."""
    from scipy.linalg import eigh_tridiagonal

    body = SeparableAlphaBeta(QUARTIC, QUARTIC)
    one = spectrum(Body(body), m=2, l=0, count=20, tolerance=1e-12)
    two = spectrum(Body(body, 2.5), m=2, l=0, count=20, hbar=0.2, tolerance=1e-12)
    np.testing.assert_allclose(two.E, one.E * (0.2**4 / 2.5**2) ** (1 / 3), rtol=1e-12)

    def differences(n, a, far=4.0):
        h = far / n
        q = (np.arange(n) + 0.5) * h
        off = -(q[:-1] + h / 2) / np.sqrt(q[:-1] * q[1:]) / h**2 / 2
        diagonal = ((q - h / 2) + (q + h / 2)) / q / h**2 / 2 + a * a / (2 * q * q) + q**4
        return eigh_tridiagonal(diagonal, off, select="i", select_range=(0, 1), eigvals_only=True)

    E = (4 * differences(4000, 1) - differences(2000, 1)) / 3
    assert radial("V", QUARTIC, 2, np.ones(1), 2, 1.0, 1.0, 1e-12).values[0] == pytest.approx(E, rel=1e-8)


@pytest.mark.parametrize(
    ("potential", "chart"),
    [(Hyperelastic(), None), (HeavyTop(), None), (SeparableAlphaBeta(QUARTIC, Oscillator(1.0, 0.3)), None)],
)
def test_states_are_orthonormal_with_nodes_of_their_labels(potential, chart):
    found = spectrum(Body(potential), m=3, l=1, count=6, chart=chart)
    t, w = np.polynomial.legendre.leggauss(400)
    wall = np.pi / 2 if isinstance(potential, Hyperelastic) else np.pi
    spans = [(10.0, 1), (10.0, 1)] if found.names == ("alpha", "beta") else [(60.0, 1), (wall, None)]
    for side, (far, power) in enumerate(spans):
        q, weight = far * (1 + t) / 2, far * w / 2
        measure = weight * (q**power if power else np.sin(q))
        factors = {}
        for k in range(6):
            # levels of other n_vartheta have other radial equations; those of one are orthogonal
            key = (found.n[1 - side, k] if side == 0 else 0, found.n[side, k])
            factors[key] = found.state(k).shape.factors[side](q)
        for (family, n), f in factors.items():
            assert (measure * f * f).sum() == pytest.approx(1, abs=1e-9)
            strong = f[np.abs(f) > 1e-6 * np.abs(f).max()]
            assert (np.diff(np.sign(strong)) != 0).sum() == n
            assert strong[-1 if power is None else 0] > 0
            for (other, k), g in factors.items():
                if other == family and k != n:
                    assert abs((measure * f * g).sum()) < 1e-9


@pytest.mark.parametrize(
    ("V", "m", "E"),
    [
        (univariate(lambda q: np.where(q < 1, 0 * q, np.inf), slope=lambda q: 0 * q), 2, jn_zeros(1, 4) ** 2 / 2),
        (univariate(lambda q: -1 / q), 0, -0.5 / (np.arange(4) + 0.5) ** 2),
        (univariate(lambda q: -1 / q), 4, -0.5 / (np.arange(4) + 2.5) ** 2),
    ],
    ids=["disk", "Coulomb", "Coulomb, a = 2"],
)
def test_textbook_planes(V, m, E):
    """A particle in a hard disk, E = j^2/2 with zeros of J_a; the two-dimensional hydrogen atom, E = -1/(2 (n + a +
    1/2)^2).
    """
    found = spectrum(Body(SeparableAlphaBeta(V, Oscillator())), m=m, l=0, count=24)
    a = m / 2
    lowest = [found.E[(found.n == [[n], [0]]).all(axis=0)] for n in range(2)]
    np.testing.assert_allclose(np.concatenate(lowest), E[:2] + 1 + a, rtol=1e-10)
    assert found.converged.all()


def test_a_wall_of_finite_strength():
    """Poeschl and Teller, (nu^2 - 1/4)/(2 sin^2 q) on (0, pi): E = (n + nu + 1/2)^2/2; 1/(8 q^2) makes the plane a
    line.
    """
    nu = 1.8

    def value(q):
        return np.where(q < np.pi, (nu * nu - 0.25) / (2 * np.sin(q) ** 2) + 1 / (8 * q * q), np.inf)

    def slope(q):
        return np.where(q < np.pi, -(nu * nu - 0.25) * np.cos(q) / np.sin(q) ** 3 - 1 / (4 * q**3), 0.0)

    V = univariate(value, slope=slope)
    values = radial("V", V, 2, np.zeros(1), 4, 1.0, 1.0, 1e-12).values[0]
    np.testing.assert_allclose(values, (np.arange(4) + nu + 0.5) ** 2 / 2, rtol=1e-11)


@pytest.mark.parametrize(
    "potential",
    [Hyperelastic(0.7), HeavyTop(A=0.8), SeparableAlphaBeta(QUARTIC, Oscillator(1.0, 0.3)), NeoHookean(1.0, 2.0)],
    ids=lambda p: type(p).__name__,
)
def test_schroedinger_equation_of_numerical_states(potential):
    """H Psi = E Psi by differences of Psi on planes, with the Laplacian of R^4; and the spin of its values on matrices.

    Errors of levels are squares of those of states: 1e-9 and 3e-5 for the body that does not separate.
    """
    body, hbar, error = Body(potential, 1.2), 0.8, 3e-4 if isinstance(potential, NeoHookean) else 1e-7
    found = spectrum(body, m=3, l=-1, count=7, hbar=hbar, tolerance=1e-9)
    planes = np.random.default_rng(3).normal(size=(4, 40)) * np.array([[0.8], [0.8], [0.4], [0.4]])
    alpha, beta = np.hypot(*planes[:2]), np.hypot(*planes[2:])
    planes = planes[:, (alpha > beta + 0.2) & (beta > 0.2)]
    assert planes.shape[1] > 5
    H = hamiltonian_operator(body, CARTESIAN, hbar=hbar)
    for k in (0, 6):
        state = found.state(k)
        left = H(lambda x, state=state: state.at(x, CARTESIAN), CARTESIAN.points_from_planes(planes))
        scale = np.abs(state.planes(planes)).max() * state.energy
        assert np.abs(left - state.energy * state.planes(planes)).max() < error * scale
        matrices = to_matrix(np.concatenate([planes, planes]))[0]
        assert np.abs(spin(state, matrices, hbar=hbar) - 3 * hbar * state(matrices)).max() < 1e-9 * scale


def test_table_of_classes():
    classes = [(m, l) for m in range(-3, 4) for l in range(-3, 4) if (m + l) % 2 == 0]
    table = spectrum_table(Body(Hyperelastic()), m=[c[0] for c in classes], l=[c[1] for c in classes], count=30)
    for (m, l), row in zip(classes, table):
        assert set(zip(row.m, row.l)) == {(m, l)}
        np.testing.assert_allclose(
            row.E, spectrum(Body(Hyperelastic()), m=l, l=m, count=30).E, rtol=1e-13
        )  # |m - l|, |m + l| count
    covering = spectrum(Body(Hyperelastic()), m=1, l=0, count=3, single_valued=False)
    assert (
        spectrum(Body(Hyperelastic()), m=0, l=0, count=1).E[0]
        < covering.E[0]
        < spectrum(Body(Hyperelastic()), m=1, l=1, count=1).E[0]
    )


def falling(q):
    return -1 / q**4


@pytest.mark.parametrize(
    ("potential", "changes", "error", "words"),
    [
        (Hyperelastic(), {"hbar": 0.0}, ValueError, "hbar"),
        (Hyperelastic(), {"m": 0.5}, ValueError, "m must be a whole number"),
        (Hyperelastic(), {"l": "0"}, TypeError, "l must be a whole number"),
        (Hyperelastic(-1.0), {}, NoGroundState, "k > 0"),
        (Hyperelastic(), {"hbar": -1.0}, ValueError, "hbar"),
        (Hyperelastic(), {"count": 0}, ValueError, "count"),
        (Hyperelastic(), {"count": 1.5}, TypeError, "count"),
        (Hyperelastic(), {"m": 1}, ValueError, "even"),
        (Hyperelastic(), {"chart": "alpha-beta"}, ValueError, "chart"),
        (Hyperelastic(), {"chart": "elliptic"}, ValueError, "chart"),
        (Hyperelastic(), {"tolerance": 0}, ValueError, "tolerance"),
        (Harmonic(-1.0), {}, NoGroundState, "k > 0"),
        (SeparableAlphaBeta(Oscillator(1.0, -0.1), Oscillator()), {}, NoGroundState, "-1/4"),
        (SeparableAlphaBeta(univariate(falling), Oscillator()), {}, NoGroundState, "falls faster"),
        (SeparableAlphaBeta(univariate(lambda q: -(q**2)), Oscillator()), {}, NoGroundState, "large distance"),
        (SeparableAlphaBeta(univariate(lambda q: -np.exp(-q)), Oscillator()), {}, NoGroundState, "bind"),
        (SeparableRVartheta(Spring(), Barriers(-1.0)), {}, NoGroundState, "vartheta = pi"),
        (SeparableRVartheta(Spring(), Secant(-8.0)), {}, ValueError, "V_"),
        (
            SeparableAlphaBeta(univariate(lambda q: q**2 + 1 / (q - 1) ** 2), Oscillator()),
            {},
            ValueError,
            r"pole at 1\. ",
        ),
        (SeparableAlphaBeta(univariate(lambda q: np.tan(q) ** 2), Oscillator()), {}, ValueError, "pole at 1.5708"),
        (SeparableRVartheta(Spring(), univariate(lambda v: 1 / np.cos(v) ** 2)), {}, ValueError, "pole at 1.5708"),
    ],
)
def test_what_has_no_spectrum(potential, changes, error, words):
    with pytest.raises(error, match=words):
        spectrum(Body(potential), **({"m": 0, "l": 0, "count": 5} | changes))


def test_other_wrong_input():
    with pytest.raises(ValueError, match="mu"):
        spectrum(Body(Harmonic(), -1.0), m=0, l=0, count=1)
    with pytest.raises(ValueError, match="m is for a Body alone, HenonHeiles takes none"):
        spectrum(HenonHeiles(), m=0, l=0, count=1)
    with pytest.raises(ValueError, match="angular potentials"):
        spectrum(StackelBody(Harmonic(), univariate(lambda angle: np.cos(angle)), Zero()), m=0, l=0, count=1)
    with pytest.raises(ValueError, match="above 1200"):
        radial("V", QUARTIC, 2, np.zeros(1), 1200, 1.0, 1.0, 1e-12)
    with pytest.raises(ValueError, match="same length"):
        spectrum_table(Body(Harmonic()), m=[0, 1], l=[0], count=1)
    found = spectrum(Body(Harmonic()), m=0, l=0, count=2)
    with pytest.raises(ValueError, match="levels 2"):
        found.state(2)


def test_no_level_is_lost_where_inner_exponents_are_weak():
    """-1/4 < s < 0 in the reduced equation: bound, Friedrichs; s = -1/4 + 2 mu c/hbar^2 + a^2 of an oscillator in
    closed form.
    """
    potential = SeparableAlphaBeta(univariate(lambda q: q**2 / 2 - 0.1 / q**2), Oscillator())
    found = spectrum(Body(potential), m=1, l=-1, count=6)
    chi = np.sqrt(1 - 0.2)
    n = np.repeat(np.arange(3), np.arange(1, 4))
    np.testing.assert_allclose(found.E, 2 * n + 2 + chi, rtol=1e-11)


def test_what_has_no_levels_is_refused_before_quantum_numbers_are_asked_for():
    for model, said in (
        (fa.HenonHeiles(), "missing 1 required keyword-only argument: 'count'"),
        (fa.hamiltonian("(x**2 + y**2 + z**2 + w**2)/2", coordinates="x y z w"), "for one to 3 coordinates"),
        (fa.iterated_map("p1 = p + sin(x); x1 = x + p1"), "H = T"),
    ):
        with pytest.raises(TypeError, match=said):
            fa.quantum.spectrum(model)
    with pytest.raises(TypeError, match="a Body needs m and l, spin and vorticity: got no m"):
        fa.quantum.spectrum(fa.Body(fa.Harmonic()))
