"""Exactly solvable bodies: energies, multiplets, quasiclassical levels beside them, matrices of the constants of
motion, tops.
"""

from itertools import product
from math import comb, sqrt

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from fastaff import (
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    Hyperelastic,
    SeparableAlphaBeta,
    SeparableRVartheta,
    univariate,
)
from fastaff.quantum.exact.exact_levels import exact_levels
from fastaff.quantum.exact.quantizations import quantizations
from fastaff.quantum.reference.matrices import class_matrices, oscillator_matrices, radial_matrices
from fastaff.quantum.reference.rigid_tops import nutation_factor, shear_levels, spherical_top, symmetric_top, wigner_d
from fastaff.quantum.states.factors import AngleFactor
from fastaff.systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA
from fastaff.systems.models import Barriers, Oscillator, Spring, StackelBody, Zero

CHARTS = (ALPHA_BETA, R_VARTHETA)
every_chart = pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: chart.name)
WALLS = Body(SeparableAlphaBeta(Oscillator(1.3, 0.4), Oscillator(0.7, 1.1)), mu=0.6)
CORE = Body(SeparableRVartheta(Spring(1.2, 0.5), Barriers(0.3, 0.9)), mu=0.8)

# E and degeneracy of the 30 lowest levels of Anharmonic, mu = C = hbar = 1: exact algebraic grouping of EQ5.2 at 50
# digits, and E_alpha + E_beta by a power-series root search of EQ4.1 and EQ4.2, which agree to 1e-49.
EVEN = [
    ("4.0000000000000000000", 1),
    ("4.2360679774997896964", 2),
    ("4.8284271247461900976", 2),
    ("5.0000000000000000000", 2),
    ("5.2360679774997896964", 4),
    ("5.6055512754639892931", 2),
    ("5.8284271247461900976", 4),
    ("6.0000000000000000000", 4),
    ("6.2360679774997896964", 8),
    ("6.4721359549995793928", 2),
    ("6.6055512754639892931", 4),
    ("6.8284271247461900976", 8),
    ("7.0000000000000000000", 6),
    ("7.2360679774997896964", 12),
    ("7.3851648071345040313", 2),
    ("7.4721359549995793928", 4),
    ("7.6055512754639892931", 8),
    ("7.8284271247461900976", 12),
    ("8.0000000000000000000", 9),
    ("8.2360679774997896964", 18),
    ("8.3245553203367586640", 2),
    ("8.3851648071345040313", 4),
    ("8.4721359549995793928", 8),
    ("8.6055512754639892931", 12),
    ("8.8284271247461900976", 18),
    ("9.0000000000000000000", 12),
    ("9.2360679774997896964", 24),
    ("9.2801098892805182711", 2),
    ("9.3245553203367586640", 4),
    ("9.3851648071345040313", 8),
]
COVERING = [
    ("4.0000000000000000000", 1),
    ("4.2360679774997896964", 2),
    ("4.5615528128088302749", 4),
    ("4.8284271247461900976", 2),
    ("5.0000000000000000000", 6),
    ("5.2360679774997896964", 4),
    ("5.5615528128088302749", 4),
    ("5.6055512754639892931", 2),
    ("5.7015621187164243432", 4),
    ("5.8284271247461900976", 4),
    ("6.0000000000000000000", 8),
    ("6.2360679774997896964", 8),
    ("6.4721359549995793928", 2),
    ("6.5311288741492748262", 4),
    ("6.5615528128088302749", 12),
    ("6.6055512754639892931", 4),
    ("6.7015621187164243432", 4),
    ("6.8284271247461900976", 8),
    ("7.0000000000000000000", 18),
    ("7.2360679774997896964", 12),
    ("7.3851648071345040313", 2),
    ("7.4244289008980523609", 4),
    ("7.4721359549995793928", 4),
    ("7.5311288741492748262", 4),
    ("7.5615528128088302749", 12),
    ("7.6055512754639892931", 8),
    ("7.7015621187164243432", 12),
    ("7.8284271247461900976", 12),
    ("8.0000000000000000000", 21),
    ("8.2360679774997896964", 18),
]


@every_chart
@pytest.mark.parametrize(("single_valued", "table"), [(True, EVEN), (False, COVERING)], ids=["GL(2,R)", "covering"])
def test_anharmonic_spectrum_to_all_digits(chart, single_valued, table):
    """To 2 units of rounding of E, with every degeneracy."""
    found = exact_levels(Body(Anharmonic()), multiplets=30, chart=chart, single_valued=single_valued).multiplets()
    expected = np.array([float(E) for E, _ in table])
    assert np.all(np.abs(found.E - expected) <= 2 * np.spacing(expected))
    assert found.degeneracy.tolist() == [times for _, times in table]
    assert found.first[-1] == found.levels.E.size == sum(times for _, times in table)
    for k in range(30):
        members = found.members(k)
        assert len(members) == found.degeneracy[k]
        assert len(set(zip(*members.n.tolist(), members.m.tolist(), members.l.tolist()))) == len(members)


def test_labels_of_a_multiplet():
    found = exact_levels(Body(Anharmonic()), multiplets=9).multiplets()
    assert found.labels(7) == [(0, 4, 0), (1, 0, 0)]  # E = 6
    assert found.labels(8) == [(0, 4, 2), (1, 0, 2)]


@every_chart
@pytest.mark.parametrize(("C", "mu", "hbar"), [(1.0, 1.0, 1.0), (1.7, 0.6, 0.4)])
def test_harmonic_multiplets_are_those_of_the_oscillator_of_R4(chart, C, mu, hbar):
    quantum = hbar * sqrt(C / mu)
    found = exact_levels(Body(Harmonic(C), mu), max_energy=(2 + 8.5) * quantum, hbar=hbar, chart=chart).multiplets()
    np.testing.assert_allclose(found.E, quantum * (2 + np.arange(9)), rtol=1e-14)
    assert found.degeneracy.tolist() == [comb(N + 3, 3) for N in range(9)]


@given(
    n1=st.integers(0, 50),
    n2=st.integers(0, 50),
    m=st.integers(-60, 60),
    half=st.integers(-60, 60),
    C=st.floats(0.1, 10),
    mu=st.floats(0.1, 10),
    hbar=st.floats(0.05, 3),
)
def test_formulas_of_the_paper(n1, n2, m, half, C, mu, hbar):
    """EQ5.1 with its cases (i)-(iii), EQ5.2, and the separation constants, in both charts."""
    l, n, omega = 2 * half - m, n1 + n2, sqrt(C / mu)
    root = sqrt((m - l) ** 2 + 16 * C * mu / hbar**2)
    for potential, eta in ((Harmonic, abs(m - l)), (Anharmonic, root)):
        body = Body(potential(C), mu)
        E = hbar * omega / 2 * (4 * n + 4 + abs(m + l) + eta)
        for chart in CHARTS:
            levels = exact_levels(body, n=(n1, n2), m=m, l=l, hbar=hbar, chart=chart)
            np.testing.assert_allclose(levels.E, [E], rtol=1e-13)
        Q = 4 * n2 + 2 + abs(m + l) + eta
        np.testing.assert_allclose(
            levels.constants[1], hbar**2 / (8 * mu) * (Q * Q - 4), rtol=1e-12, atol=1e-14 * hbar**2 / mu
        )
        planes = exact_levels(body, n=(n1, n2), m=m, l=l, hbar=hbar)
        np.testing.assert_allclose(planes.constants[0], hbar * omega / 2 * (4 * n1 + 2 + eta), rtol=1e-13)
        np.testing.assert_allclose(planes.constants[1], hbar * omega / 2 * (4 * n2 + 2 + abs(m + l)), rtol=1e-13)
    harmonic = exact_levels(Body(Harmonic(C), mu), n=(n1, n2), m=m, l=l, hbar=hbar)
    case = 1 if abs(m) > abs(l) else 2 if abs(m) < abs(l) else 3
    for quantum in {1: [abs(m)], 2: [abs(l)], 3: [abs(m), abs(l)]}[case]:
        np.testing.assert_allclose(harmonic.E, hbar * omega * (2 * n + 2 + quantum), rtol=1e-13)


@pytest.mark.parametrize(
    ("body", "chart"),
    [*product((Body(Harmonic(1.3), 0.7), Body(Anharmonic(0.9), 1.4)), CHARTS), (WALLS, ALPHA_BETA), (CORE, R_VARTHETA)],
)
def test_EBK_is_exact_and_Bohr_Sommerfeld_misses_the_zero_point(body, chart):
    n, m, l, hbar = [[0, 1, 4, 0], [0, 3, 2, 5]], [0, 2, -5, 3], [0, 4, 1, 3], 0.7
    found = quantizations(body, n=n, m=m, l=l, hbar=hbar, chart=chart)
    np.testing.assert_allclose(
        found.ebk.E, found.exact.E, rtol=1e-11
    )  # quadratures of the classical actions where walls are general
    np.testing.assert_array_equal(found.E, [found.bohr_sommerfeld.E, found.ebk.E, found.exact.E])
    if body not in (WALLS, CORE):
        zero_point = 2 * hbar * sqrt(body.potential.C / body.mu)
        np.testing.assert_allclose(found.exact.E - found.bohr_sommerfeld.E, zero_point, rtol=1e-12)


@pytest.mark.parametrize("single_valued", [True, False])
@pytest.mark.parametrize("body", [Body(Harmonic(1.2), 1.5), Body(Anharmonic(1.2), 1.5), WALLS])
def test_levels_below_are_complete(body, single_valued):
    """Against all quantum numbers of a box: walls only raise the levels of the weaker oscillator."""
    hbar = 0.9
    quantum = hbar * sqrt((0.7 if body is WALLS else 1.2) / body.mu)
    top, size = 6.3 * quantum, 7
    found = exact_levels(body, max_energy=top, hbar=hbar, single_valued=single_valued)
    whole = range(-size, size + 1)
    box = [q for q in product(range(4), range(4), whole, whole) if not (single_valued and (q[2] + q[3]) % 2)]
    n1, n2, m, l = np.array(box).T
    every = exact_levels(body, n=[n1, n2], m=m, l=l, hbar=hbar, single_valued=single_valued)
    below = {q for q, E in zip(box, every.E) if top > E}
    assert len(below) > 10
    assert sorted(zip(*found.n.tolist(), found.m.tolist(), found.l.tolist())) == sorted(below)
    assert (np.diff(found.E) >= 0).all()


def test_no_level_below():
    for top in (2.0, -1.0):
        levels = exact_levels(Body(Harmonic()), max_energy=top)
        assert levels.E.shape == levels.m.shape == (0,)
        assert levels.n.shape == levels.constants.shape == (2, 0)
    found = exact_levels(Body(Harmonic()), max_energy=1.0).multiplets()
    assert found.E.size == found.degeneracy.size == 0


def test_tolerance_joins_multiplets():
    assert exact_levels(Body(Anharmonic()), max_energy=4.9).multiplets(tolerance=0.1).degeneracy.tolist() == [3, 2]


def test_whole_floats_are_quantum_numbers():
    levels = exact_levels(Body(Harmonic()), n=(0.0, 1.0), m=2.0, l=np.array([0.0, 2.0]))
    assert levels.n.dtype == levels.m.dtype == np.int64
    assert levels.names == ("alpha", "beta")
    assert levels.constant_names == ("E_alpha", "E_beta")


def level(**change):
    return exact_levels(change.pop("model", Body(Harmonic())), **({"n": (0, 0), "m": 0, "l": 0} | change))


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"n": (0, -1)}, ValueError, "n must .*>= 0"),
        ({"n": (0, 0.5)}, ValueError, "n must be whole"),
        ({"n": (0, np.nan)}, ValueError, "n must be whole"),
        ({"n": (0, 0, 0)}, ValueError, "n must have shape"),
        ({"n": "ab"}, TypeError, "n must be whole"),
        ({"n": [[0, 1, 2], [0, 1, 2]], "m": [0, 0]}, ValueError, "n, m and l must"),
        ({"m": 0.5}, ValueError, "m must be whole"),
        ({"m": 1e300}, ValueError, "m must be whole"),
        ({"l": None}, TypeError, "l must be whole"),
        ({"l": 1j}, TypeError, "l must be whole"),
        ({"m": 1}, ValueError, r"m \+ l must be even.*single_valued=False"),
        ({"hbar": 0.0}, ValueError, "hbar must be positive"),
        ({"hbar": -1.0}, ValueError, "hbar must be positive"),
        ({"hbar": "1"}, TypeError, "hbar must be a real"),
        ({"model": Body(Harmonic(), mu=-1.0)}, ValueError, "mu must be positive"),
        ({"model": Body(Harmonic(-1.0))}, ValueError, "k .* must be positive"),
        ({"model": Harmonic()}, TypeError, r"Use Body\(Harmonic\(...\)\)"),
        ({"model": Body(Hyperelastic())}, ValueError, "closed-form"),
        ({"model": Body(HeavyTop())}, ValueError, "closed-form"),
        (
            {"model": Body(SeparableAlphaBeta(Oscillator(1.0, -2.0), Oscillator()))},
            ValueError,
            "got a potential barrier c = -2",
        ),
        ({"model": Body(SeparableRVartheta(Spring(1.0, -2.0), Barriers()))}, ValueError, "attracts"),
        ({"model": StackelBody(Harmonic(), univariate(lambda eta: np.cos(eta)), Zero())}, ValueError, "isotropic"),
        ({"chart": ELLIPTIC}, ValueError, "closed-form"),
        ({"chart": "polar"}, ValueError, "chart must separate"),
    ],
    ids=str,
)
def test_bad_input(change, error, words):
    with pytest.raises(error, match=words):
        level(**change)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({}, ValueError),
        ({"max_energy": 3.0, "multiplets": 2}, ValueError),
        ({"max_energy": 3.0, "m": 2}, ValueError),
        ({"multiplets": 0}, ValueError),
        ({"multiplets": 1.5}, TypeError),
        ({"max_energy": np.inf}, ValueError),
    ],
)
def test_bad_lists(change, error):
    with pytest.raises(error, match=r"max_energy|multiplets"):
        exact_levels(Body(Harmonic()), **change)


@pytest.mark.parametrize("tolerance", [-1.0, 1.0, np.nan])
def test_bad_tolerance_of_multiplets(tolerance):
    with pytest.raises(ValueError, match="tolerance must be"):
        exact_levels(Body(Harmonic()), multiplets=2).multiplets(tolerance)


# Matrices of the constants of motion


def commutator(A, B):
    return np.abs(A @ B - B @ A).max() / (np.abs(A).max() * np.abs(B).max())


CLASSES = [(Body(Harmonic(1.3), 0.7), 2, -4), (Body(Anharmonic(1.1), 0.8), 2, -4), (Body(Anharmonic(0.4), 1.6), 3, 3)]


@pytest.mark.parametrize(("body", "m", "l"), CLASSES)
def test_constants_of_motion_of_a_class(body, m, l):
    """[H, K] = [H, L] = [K, L] = 0; each chart's own constants commute with H, not with those of the others."""
    shells, hbar = 7, 0.6
    found = class_matrices(body, m=m, l=l, shells=shells, hbar=hbar)
    for A, B in (
        (found.H, found.K),
        (found.H, found.L),
        (found.K, found.L),
        (found.H, found.h_vartheta),
        (found.H, found.H_alpha),
    ):
        assert commutator(A, B) < 1e-15
    assert commutator(found.H_alpha, found.h_vartheta) > 1e-3
    assert commutator(found.K, found.h_vartheta) > 1e-3
    assert commutator(found.K, found.H_alpha) > 1e-3
    np.testing.assert_allclose(found.K + found.L, found.H, atol=1e-14 * np.abs(found.H).max())
    for N in range(shells):
        block = np.flatnonzero(found.basis.sum(0) == N)
        n = np.array([np.arange(N, -1, -1), np.arange(N + 1)])
        in_planes, in_r = (exact_levels(body, n=n, m=m, l=l, hbar=hbar, chart=chart) for chart in CHARTS)
        h = found.h_vartheta[np.ix_(block, block)]
        np.testing.assert_allclose(np.linalg.eigvalsh(h), in_r.constants[1], rtol=1e-12)
        np.testing.assert_allclose(np.sort(np.diag(found.H_alpha)[block]), np.sort(in_planes.constants[0]), rtol=1e-14)


def test_constants_of_motion_in_the_whole_oscillator_basis():
    body, hbar, top = Body(Harmonic(1.3), 0.7), 0.6, 4
    found = oscillator_matrices(body, quanta=top, hbar=hbar)
    constants = (found.H, found.K, found.L, found.p_phi, found.p_psi)
    for A, B in product(constants, repeat=2):
        assert commutator(A, B) < 1e-14
    for A in (*constants, found.h_vartheta, found.H_alpha):
        np.testing.assert_allclose(A, A.conj().T, atol=1e-15 * np.abs(A).max())
    assert commutator(found.H_alpha, found.h_vartheta) > 1e-3
    assert found.H.shape == (comb(top + 4, 4),) * 2
    # all of H, K, p_phi, p_psi at once: the classes (m, l) hold the same eigenvalues of K
    mixed = found.H + sqrt(2) * found.K + sqrt(3) * found.p_phi + sqrt(5) * found.p_psi
    expected = []
    for m, l in product(range(-top, top + 1), repeat=2):
        shells = (top - max(abs(m), abs(l))) // 2 + 1
        if (m + l) % 2 == 0 and shells > 0:
            block = class_matrices(body, m=m, l=l, shells=shells, hbar=hbar)
            expected.append(np.linalg.eigvalsh(block.H + sqrt(2) * block.K) + hbar * (sqrt(3) * m + sqrt(5) * l))
    np.testing.assert_allclose(np.linalg.eigvalsh(mixed), np.sort(np.concatenate(expected)), atol=1e-12)


def test_shear_levels_are_in_the_oscillator_basis():
    """The shell of N quanta has j = N/2, N/2 - 1, ..., each (2 j + 1)^2 times."""
    body, hbar = Body(Harmonic(1.3), 0.7), 0.6
    found = oscillator_matrices(body, quanta=5, hbar=hbar)
    j = np.concatenate([np.arange(N, -1, -2) / 2 for N in range(6)])
    levels = shear_levels(0.7, j=j, hbar=hbar)
    expected = np.sort(np.repeat(levels.E, levels.degeneracy))
    np.testing.assert_allclose(np.linalg.eigvalsh(found.h_vartheta), expected, atol=1e-12)


@pytest.mark.parametrize("body", [Body(Harmonic(1.3), 0.7), Body(Anharmonic(1.1), 0.8)])
def test_contributions_to_H_are_no_constants(body):
    """The paper's warning: H = H_r + h_vartheta/r commutes with neither."""
    found = radial_matrices(body, m=2, l=0, n_vartheta=1, size=6, hbar=0.8)
    np.testing.assert_allclose(found.H_r + found.h_over_r, found.H, atol=1e-13)
    for part in (found.H_r, found.h_over_r):
        np.testing.assert_allclose(part, part.T, atol=1e-13)
        assert commutator(found.H, part) > 0.01
    # <1/r> = (dE/de): Hellmann and Feynman
    step = 1e-5
    levels = exact_levels(body, n=(2, 1), m=2, l=0, hbar=0.8, chart=R_VARTHETA)
    e, mu, omega = levels.constants[1, 0], body.mu, sqrt(body.potential.C / body.mu)
    E = [0.8 * omega * (5 + sqrt(1 + 2 * mu * (e + d) / 0.64)) for d in (-step, step)]
    assert found.h_over_r[2, 2] / e == pytest.approx((E[1] - E[0]) / (2 * step), rel=1e-8)


def test_bad_matrices():
    with pytest.raises(ValueError, match="same k in both planes"):
        class_matrices(WALLS, m=0, l=0, shells=2)
    with pytest.raises(ValueError, match="harmonic"):
        oscillator_matrices(Body(Anharmonic()), quanta=2)
    with pytest.raises(ValueError, match="shells must be at least 1"):
        class_matrices(Body(Harmonic()), m=0, l=0, shells=0)
    with pytest.raises(ValueError, match="must be even"):
        class_matrices(Body(Harmonic()), m=1, l=0, shells=1)


# Tops


def angular_momentum_y(j):
    """J_y in the basis m = j, j - 1, ..., -j."""
    m = np.arange(j, -j - 1, -1)
    raising = np.diag(np.sqrt(j * (j + 1) - m[1:] * (m[1:] + 1)), 1)
    return (raising - raising.T) / 2j, m


@pytest.mark.parametrize("j", [0, 0.5, 1, 1.5, 2, 3.5, 6])
def test_wigner_functions_are_matrix_elements_of_rotations(j):
    J_y, projections = angular_momentum_y(j)
    theta = np.array([0.0, 0.3, 1.7, np.pi])
    found = np.array([[wigner_d(j, m, l, theta) for l in projections] for m in projections])
    expected = np.moveaxis([expm(-1j * t * J_y).real for t in theta], 0, -1)
    np.testing.assert_allclose(found, expected, atol=2e-14 * (2 * j + 1))


@pytest.mark.parametrize(("j", "m", "l"), [(40, 3, -7), (60.5, 30.5, 12.5), (120, 0, 0), (150, 149, -150)])
def test_wigner_functions_against_the_explicit_sum(j, m, l):
    """Wigner's sum at 120 digits."""
    with mpmath.workdps(120):
        for theta in (0.02, 1.1, 2.9):
            half, total = mpmath.mpf(theta) / 2, mpmath.mpf(0)
            front = mpmath.sqrt(mpmath.fprod(mpmath.factorial(x) for x in (j + m, j - m, j + l, j - l)))
            for s in range(max(0, int(l - m)), int(min(j + l, j - m)) + 1):
                below = mpmath.fprod(mpmath.factorial(x) for x in (j + l - s, s, m - l + s, j - m - s))
                powers = mpmath.cos(half) ** int(2 * j + l - m - 2 * s) * mpmath.sin(half) ** int(m - l + 2 * s)
                total += (-1) ** int(m - l + s) * powers / below
            assert abs(wigner_d(j, m, l, theta) - float(front * total)) < 1e-12


@pytest.mark.parametrize(("m", "l", "j"), [(0, 0, 3), (2, -4, 5), (3, 1, 4.5), (-5, 3, 2.5)])
def test_nutation_factor_is_the_harmonic_shear_factor(m, l, j):
    theta = np.linspace(0, np.pi, 50)
    a, b = abs(m - l) / 2, abs(m + l) / 2
    factor = AngleFactor(int(j - (a + b) / 2), a, b)
    found = nutation_factor(m=m, l=l, j=j, theta=theta)
    sign = np.sign(found[20] * factor(theta)[20])
    np.testing.assert_allclose(found, sign * factor(theta), atol=1e-14)


def test_free_tops():
    levels = spherical_top(2.0, j=[0, 0.5, 1, 1.5], hbar=3.0)
    np.testing.assert_allclose(levels.E, 9 / 4 * np.array([0, 0.75, 2, 3.75]), rtol=1e-15)
    assert levels.degeneracy.tolist() == [1, 4, 9, 16]
    np.testing.assert_allclose(shear_levels(0.8, j=[1, 2.5]).E, 2 / 0.8 * np.array([2, 8.75]), rtol=1e-15)
    round_top = symmetric_top(2.0, 2.0, j=1.5, l=[-1.5, -0.5, 0.5, 1.5])
    np.testing.assert_allclose(round_top.E, spherical_top(2.0, j=1.5).E, rtol=1e-15)
    # H = (J^2 - J_3^2)/2I + J_3^2/2K in the basis of J_3: energies and degeneracies of j = 2, with 2 j + 1 values of m
    I, K, j = 1.7, 0.6, 2
    J_y, _ = angular_momentum_y(j)
    rotation = expm(-1j * np.pi / 2 * np.diag(np.arange(j, -j - 1, -1)))
    J_x = rotation @ J_y @ rotation.conj().T  # squares alone count
    J_3 = J_x @ J_y - J_y @ J_x  # +-i J_3
    H = (J_x @ J_x + J_y @ J_y) / (2 * I) + np.real(-J_3 @ J_3) / (2 * K)
    values = np.linalg.eigvalsh(H)
    for l in range(-j, j + 1):
        level = symmetric_top(I, K, j=j, l=l)
        assert level.degeneracy == (2 * j + 1) * np.isclose(values, level.E).sum()


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: spherical_top(1.0, j=0.25), ValueError, "j must be integers or half"),
        (lambda: spherical_top(1.0, j=-1), ValueError, "j must be at least 0"),
        (lambda: spherical_top(0.0, j=1), ValueError, "I must be positive"),
        (lambda: spherical_top(1.0, j="1"), TypeError, "j must be integers"),
        (lambda: symmetric_top(1.0, -1.0, j=1, l=0), ValueError, "K must be positive"),
        (lambda: symmetric_top(1.0, 1.0, j=1, l=2), ValueError, "l must be j"),
        (lambda: symmetric_top(1.0, 1.0, j=1, l=0.5), ValueError, "l must be j"),
        (lambda: wigner_d(1, 0, 1.5, 0.3), ValueError, "l must be j"),
        (lambda: wigner_d(-1, 0, 0, 0.3), ValueError, "j must be at least 0"),
        (lambda: wigner_d([1], 0, 0, 0.3), TypeError, "j must be one number"),
        (lambda: wigner_d(1, 0, 0, 4.0), ValueError, "vartheta must lie"),
        (lambda: wigner_d(1, 0, 0, np.nan), ValueError, "vartheta must lie"),
        (lambda: nutation_factor(m=1, l=0, j=1, theta=0.1), ValueError, "must be even"),
    ],
)
def test_bad_tops(call, error, words):
    with pytest.raises(error, match=words):
        call()
