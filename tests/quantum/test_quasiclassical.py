"""Quasiclassical levels against the paper's closed forms, a table at 15 digits, brute-force counts and the limit of
small hbar.
"""

from __future__ import annotations

from itertools import product
from math import floor, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from fastaff import (
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    Hyperelastic,
    NeoHookean,
    SeparableAlphaBeta,
    SeparableRVartheta,
    univariate,
)
from fastaff.quantum import BOHR_SOMMERFELD, EBK, LevelTable, quasiclassical_levels
from fastaff.systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA
from fastaff.systems.models import Barriers, Oscillator, Spring, StackelBody, Zero

every_chart = pytest.mark.parametrize("chart", [ALPHA_BETA, R_VARTHETA], ids=["alpha-beta", "r-vartheta"])
quantum = st.integers(0, 30)
spin = st.integers(-30, 30)
strength = st.floats(0.05, 20.0)
HARD_WALL = (2, 3)
"""Maslov indices of a libration in r and one between a soft turning point and a wall."""


def harmonic(n, m, l, C, mu, hbar, M):
    """EQ3.2 (M = 0) and EQ5.1 (M = 4) of the paper."""
    return hbar * sqrt(C / mu) / 2 * (4 * n + M + abs(m - l) + abs(m + l))


def anharmonic(n, m, l, C, mu, hbar, M):
    """EQ3.6 (M = 0) and EQ5.2 (M = 4) of the paper."""
    return hbar * sqrt(C / mu) / 2 * (4 * n + M + abs(m + l) + sqrt((m - l) ** 2 + 16 * C * mu / hbar**2))


@every_chart
@pytest.mark.parametrize(("potential", "formula"), [(Harmonic, harmonic), (Anharmonic, anharmonic)])
@pytest.mark.parametrize(("maslov", "M"), [(BOHR_SOMMERFELD, 0), (EBK, 4)], ids=["Bohr-Sommerfeld", "EBK"])
@given(n1=quantum, n2=quantum, m=spin, half=spin, C=strength, mu=strength, hbar=strength)
def test_levels_of_the_paper(chart, potential, formula, maslov, M, n1, n2, m, half, C, mu, hbar):
    """EQ3.2, EQ3.6, EQ5.1, EQ5.2: only n_1 + n_2 counts, and m + l is even. Ten roundings of positive terms."""
    l = 2 * half - m
    levels = quasiclassical_levels(Body(potential(C), mu), n=(n1, n2), m=m, l=l, maslov=maslov, hbar=hbar, chart=chart)
    np.testing.assert_allclose(levels.E, formula(n1 + n2, m, l, C, mu, hbar, M), rtol=5e-15, atol=0)
    np.testing.assert_allclose(levels.spacing[0], 2 * hbar * sqrt(C / mu), rtol=5e-15)
    assert (levels.n.ravel() == (n1, n2)).all()
    assert (levels.m[0], levels.l[0], levels.method, levels.hbar) == (
        m,
        l,
        f"quasiclassical, Maslov indices {maslov}",
        hbar,
    )


@pytest.mark.parametrize(
    "potential",
    [
        SeparableAlphaBeta(Oscillator(1.4, 2.8), univariate(lambda beta: 0.7 * beta * beta)),
        SeparableRVartheta(Spring(1.4), univariate(lambda vartheta: 2.8 / np.cos(vartheta / 2) ** 2)),
        SeparableRVartheta(univariate(lambda r: 0.7 * r), Barriers(2.8)),
    ],
    ids=["beta", "vartheta", "r"],
)
def test_quadratures_agree_with_the_closed_form(potential):
    """EQ5.2 once more, with a function that has no closed form in the program: 1e-12, what `energy_of_actions`
    converges to.
    """
    numbers = [
        (n1, n2, m, l) for n1, n2, m, l in product((0, 1, 5), (0, 2), (-2, 0, 3), (-1, 0, 2)) if (m + l) % 2 == 0
    ]
    n1, n2, m, l = np.array(numbers).T
    levels = quasiclassical_levels(Body(potential, 0.8), n=[n1, n2], m=m, l=l, hbar=0.6)
    expected = [anharmonic(a + b, c, d, 1.4, 0.8, 0.6, 4) for a, b, c, d in numbers]
    np.testing.assert_allclose(levels.E, expected, rtol=1e-12)


# V = C (1/(D1 D2) + (D1^2 + D2^2)/2), mu = C = hbar = 1, n_r = 0: m, l, n_vartheta, the separation constant h_vartheta
# and E by EBK (midpoint quadrature and bisection in mpmath, 15 digits), and the exact E, the Heun equation with f = 0
# at det phi = 0 (20 digits).
TABLE = """
2 0 0 13.8002116078794 6.25361049334253 6.6836795515645311692
2 0 1 39.4317559854833 9.88051304660753 10.475993313531639756
2 0 2 80.4512391535104 13.6847340652857 14.369309031018083140
2 0 3 137.185637576675 17.5641563369026 18.303977596076194330
0 2 0 13.8002116078794 6.25361049334253 6.6836795515645311692
0 2 1 39.4317559854833 9.88051304660753 10.475993313531639756
0 2 2 80.4512391535104 13.6847340652857 14.369309031018083140
0 2 3 137.185637576675 17.5641563369026 18.303977596076194330
3 1 0 23.138307683697 7.80269177365798 8.3236425792594002399
3 1 1 56.2525820395298 11.6068451520261 12.254144100446574144
3 1 2 105.043921094381 15.4944072727643 16.211595116835626881
3 1 3 169.653919323908 19.4203104927093 20.182488481424289456
"""
ROWS = [row.split() for row in TABLE.split("\n") if row]
every_row = pytest.mark.parametrize("row", ROWS, ids=lambda row: "-".join(row[:3]))


@every_row
def test_hyperelastic_levels_to_all_digits(row):
    """All stated digits: within 1.5 units of the last one, half a unit its own rounding and one ours."""
    m, l, n = map(int, row[:3])
    E = quasiclassical_levels(Body(Hyperelastic()), n=(0, n), m=m, l=l).E[0]
    assert abs(E - float(row[4])) <= 1.5 * 10.0 ** -len(row[4].split(".")[1])
    assert abs((E - 1) ** 2 / 2 - float(row[3])) <= 5e-15 * 2 * float(row[3]) * E / (E - 1) + 10.0 ** -len(
        row[3].split(".")[1]
    )


def turns_of_vartheta(E, p_r, p_eta, p_gamma, C=1.0, mu=1.0):
    """Return J_vartheta/2 pi of the body in V = C (1/(D1 D2) + (D1^2 + D2^2)/2), by adaptive quadrature.

    E = omega (2 I_r + Lambda) and p_epsilon^2 = Lambda^2 - p_eta^2/cos^2 - p_gamma^2/sin^2 - 4 mu C/cos(2 epsilon),
    epsilon = vartheta/2; p_r: I_r.
    """
    Lambda = E / sqrt(C / mu) - 2 * p_r

    def square_of_p(e):
        return Lambda**2 - (p_eta / np.cos(e)) ** 2 - (p_gamma / np.sin(e)) ** 2 - 4 * mu * C / np.cos(2 * e)

    grid = pi / 8 * (1 + np.sin(np.linspace(-pi / 2, pi / 2, 20001)[1:-1]))
    allowed = np.flatnonzero(square_of_p(grid) > 0)
    first = brentq(square_of_p, grid[allowed[0] - 1], grid[allowed[0]], xtol=1e-15)
    last = brentq(square_of_p, grid[allowed[-1]], grid[allowed[-1] + 1], xtol=1e-15)
    middle, width = (first + last) / 2, (last - first) / 2
    half, _ = quad(
        lambda t: sqrt(max(square_of_p(middle + width * np.sin(t)), 0.0)) * width * np.cos(t),
        -pi / 2,
        pi / 2,
        epsabs=1e-12,
        limit=400,
    )
    return half / pi


HARD = [(1, 7, 8.0), (0, 4, 25.0), (-4, 0, 50.0)]


@pytest.mark.parametrize(("m", "l", "hbar"), [(2, 0, 1.0), (1, 7, 0.2), (5, -3, 0.5), (7, 1, 1.0), *HARD])
def test_hyperelastic_levels_by_adaptive_quadrature(m, l, hbar):
    """The wall at vartheta = pi/2 gets hard where actions are large against sqrt(C mu)."""
    C, mu = 1.2, 0.9
    E = quasiclassical_levels(Body(Hyperelastic(C), mu), n=(1, 2), m=m, l=l, hbar=hbar, single_valued=False).E[0]
    assert abs(turns_of_vartheta(E, 1.5 * hbar, (m - l) / 2 * hbar, (m + l) / 2 * hbar, C, mu) / hbar - 2.5) < 1e-9


@pytest.mark.parametrize(("m", "l"), [(2, 0), (0, 2), (1, -1), (1, 1), (0, 0)], ids=str)
def test_heavy_top_levels_by_adaptive_quadrature(m, l):
    """E = omega (2 I_r + Lambda), p_epsilon^2 = Lambda^2 - p_eta^2/cos^2 - p_gamma^2/sin^2 - 2 mu A cos(2 epsilon)."""
    A, p_eta, p_gamma = 0.2, (m - l) / 2, (m + l) / 2
    E = quasiclassical_levels(Body(HeavyTop(1.0, A)), n=(0, 1), m=m, l=l).E[0]

    def square_of_p(e):
        return (E - 1) ** 2 - (p_eta / np.cos(e)) ** 2 - (p_gamma / np.sin(e)) ** 2 - 2 * A * np.cos(2 * e)

    edges, grid = [0.0, pi / 2], np.linspace(1e-9, pi / 2 - 1e-9, 2001)
    if p_gamma:
        edges[0] = brentq(square_of_p, grid[0], pi / 4)
    if p_eta:
        edges[1] = brentq(square_of_p, pi / 4, grid[-1])
    middle, width = sum(edges) / 2, (edges[1] - edges[0]) / 2
    half, _ = quad(
        lambda t: sqrt(max(square_of_p(middle + width * np.sin(t)), 0)) * width * np.cos(t),
        -pi / 2,
        pi / 2,
        epsabs=1e-12,
    )
    assert abs(half / pi - 1.5) < 1e-9


@every_row
def test_exact_hyperelastic_levels_lie_between_soft_and_hard_walls(row):
    m, l, n = map(int, row[:3])
    soft, hard = (
        quasiclassical_levels(Body(Hyperelastic()), n=(0, n), m=m, l=l, maslov=M).E[0] for M in (EBK, HARD_WALL)
    )
    assert soft < float(row[5]) < hard


@pytest.mark.parametrize("potential", [Harmonic, Anharmonic, Hyperelastic])
@given(
    n1=st.integers(0, 4),
    n2=st.integers(0, 4),
    m=st.integers(-5, 5),
    half=st.integers(-5, 5),
    scale=st.floats(0.1, 10),
    hbar=st.floats(0.01, 0.5),
)
def test_scaling(potential, n1, n2, m, half, scale, hbar):
    """E = C f(hbar/sqrt(C mu)), so E(s C, mu, hbar sqrt s) = s E(C, mu, hbar); actions alone count: hbar/3 with J the
    same.
    """
    l = 2 * half - m
    one = quasiclassical_levels(Body(potential(1.2), 0.9), n=(n1, n2), m=m, l=l, hbar=hbar)
    other = quasiclassical_levels(Body(potential(1.2 * scale), 0.9), n=(n1, n2), m=m, l=l, hbar=hbar * sqrt(scale))
    np.testing.assert_allclose(other.E, scale * one.E, rtol=1e-12)
    np.testing.assert_allclose(other.spacing, scale * one.spacing, rtol=1e-10)
    third = quasiclassical_levels(
        Body(potential(1.2), 0.9), n=(3 * n1 + 1, 3 * n2 + 1), m=3 * m, l=3 * l, hbar=hbar / 3
    )
    np.testing.assert_allclose(third.E, one.E, rtol=1e-12)
    np.testing.assert_allclose(third.spacing, one.spacing / 3, rtol=1e-10)


@pytest.mark.parametrize("row", [0, 1], ids=["r", "vartheta"])
def test_spacing_is_the_slope_of_the_levels(row):
    """Sixth-order differences of the levels in n around 60: error E (1/60)^6, below 1e-9 of the spacing."""
    n = np.full((2, 7), 60)
    n[row] += np.arange(-3, 4)
    levels = quasiclassical_levels(Body(Hyperelastic(1.1), 0.8), n=n, m=3, l=1, hbar=0.05)
    slope = np.array([-1, 9, -45, 0, 45, -9, 1]) @ levels.E / 60
    np.testing.assert_allclose(levels.spacing[row, 3], slope, rtol=1e-9)


def test_degeneracies_join_what_the_tolerance_joins():
    number = np.zeros(4, int)
    E = np.array([3.0, 1.0 + 1e-12, 1.0, 1.0 + 1e-6])
    names, numbers = ("alpha", "beta"), np.array([number, number])
    for scale in (1.0, 1e-12):  # the tolerance is relative, and so are the errors
        levels = LevelTable(
            scale * E, 5e-10 * scale * E, number, numbers, names, number, number, np.zeros((0, 4)), (), 1.0, "made"
        )
        assert levels.multiplets().degeneracy.tolist() == [2, 1, 1]
        assert levels.multiplets(tolerance=1e-5).degeneracy.tolist() == [3, 1]
        assert levels.multiplets(tolerance=0.0).degeneracy.tolist() == [1, 1, 1, 1]


def test_degeneracies_of_no_level():
    found = quasiclassical_levels(Body(Harmonic()), max_energy=1.0).multiplets()
    assert found.E.size == found.degeneracy.size == len(found) == 0


def numbers_of(levels):
    """Return the quantum numbers as a list of (n1, n2, m, l)."""
    return list(zip(*levels.n.tolist(), levels.m.tolist(), levels.l.tolist()))


def box(top, even):
    """Return all n1, n2, m, l with 2 (n1 + n2) + max(|m|, |l|) <= top: no level of the oscillator below `top` is
    outside.
    """
    N = floor(top)
    whole = range(-N, N + 1)
    return [
        (n1, n2, m, l)
        for n1, n2, m, l in product(range(N // 2 + 1), range(N // 2 + 1), whole, whole)
        if 2 * (n1 + n2) + max(abs(m), abs(l)) <= N and not (even and (m + l) % 2)
    ]


@pytest.mark.parametrize(
    ("potential", "formula", "maslov", "single_valued"),
    [
        *((Harmonic, harmonic, maslov, single) for maslov in (BOHR_SOMMERFELD, EBK) for single in (True, False)),
        *((Anharmonic, anharmonic, maslov, True) for maslov in (BOHR_SOMMERFELD, EBK)),
        (Anharmonic, anharmonic, BOHR_SOMMERFELD, False),
        (Anharmonic, anharmonic, EBK, False),
    ],
)
def test_levels_below_are_complete(potential, formula, maslov, single_valued):
    C, mu, hbar = 1.2, 1.5, 0.9
    top = 6.3 * hbar * sqrt(C / mu)
    found = quasiclassical_levels(
        Body(potential(C), mu), max_energy=top, maslov=maslov, hbar=hbar, single_valued=single_valued
    )
    expected = {}
    for n1, n2, m, l in box(6.3, single_valued):  # the wall 2 C/alpha^2 > 0 only raises levels
        E = formula(n1 + n2, m, l, C, mu, hbar, 2 * sum(maslov) / 2)
        if top > E:
            expected[n1, n2, m, l] = E
    assert len(expected) > 10
    assert len(numbers_of(found)) == len(set(numbers_of(found)))
    assert set(numbers_of(found)) == set(expected)
    np.testing.assert_allclose(found.E, [expected[q] for q in numbers_of(found)], rtol=1e-14)
    assert (np.diff(found.E) >= 0).all()


@pytest.mark.parametrize("maslov", [BOHR_SOMMERFELD, EBK, HARD_WALL])
def test_levels_below_are_complete_by_quadrature(maslov):
    """V is at least that of the oscillator where it lives, so its levels are higher: the oscillator's box holds them
    all.
    """
    body, top = Body(Hyperelastic(1.0), 1.0), 9.0
    found = quasiclassical_levels(body, max_energy=top, maslov=maslov)
    n1, n2, m, l = np.array(box(top, even=True)).T
    every = quasiclassical_levels(body, n=[n1, n2], m=m, l=l, maslov=maslov)
    below = np.flatnonzero(top > every.E)
    assert 20 < below.size < every.E.size
    assert set(numbers_of(found)) == {numbers_of(every)[k] for k in below}
    np.testing.assert_allclose(found.E, np.sort(every.E[below]), rtol=1e-13)


STRIP = Body(SeparableAlphaBeta(Oscillator(0.01), Oscillator(1.0)))


@pytest.mark.parametrize("single_valued", [True, False], ids=["GL(2,R)", "covering"])
def test_levels_below_are_complete_where_the_planes_differ(single_valued):
    """omega_alpha = 0.1, omega_beta = 1: odd m + l costs half a quantum of both planes, more than m - l = 2 does."""
    top, expected = 1.45, set()
    for n1, n2, m, l in product(range(8), range(2), range(-9, 10), range(-9, 10)):
        E = 0.1 * (2 * n1 + 1 + abs(m - l) / 2) + (2 * n2 + 1 + abs(m + l) / 2)
        if top > E and not (single_valued and (m + l) % 2):
            expected.add((n1, n2, m, l))
    found = quasiclassical_levels(STRIP, max_energy=top, single_valued=single_valued)
    assert len(expected) >= 4
    assert set(numbers_of(found)) == expected


def test_long_rows_of_levels_below():
    """26 levels in n_alpha of one n_beta, m, l: more than the search asks for at once."""
    body = Body(SeparableAlphaBeta(Oscillator(1.0), Oscillator(1e4)))  # omega = 1 and 100
    found = quasiclassical_levels(body, max_energy=151.5)
    assert found.n[0, (found.m == 0) & (found.l == 0)].tolist() == list(range(26))


def test_no_level_below():
    for top in (2.0, -1.0):  # the ground state of C = mu = hbar = 1 is at 2: below means below
        levels = quasiclassical_levels(Body(Harmonic()), max_energy=top)
        assert levels.E.shape == levels.m.shape == levels.l.shape == (0,)
        assert levels.n.shape == levels.spacing.shape == (2, 0)
    assert quasiclassical_levels(Body(Harmonic()), max_energy=np.nextafter(2.0, 3.0)).E.shape == (1,)


@pytest.mark.parametrize(("m", "l"), [(1, 0), (0, -1), (2, 3), ([0, 1], [0, 2])])
def test_odd_sum_lives_on_the_covering_only(m, l):
    with pytest.raises(ValueError, match=r"m \+ l must be even.*single_valued=False"):
        quasiclassical_levels(Body(Harmonic()), n=(0, 0), m=m, l=l)
    levels = quasiclassical_levels(Body(Harmonic()), n=(0, 0), m=m, l=l, single_valued=False)
    expected = [harmonic(0, a, b, 1.0, 1.0, 1.0, 4) for a, b in zip(np.ravel(m), np.ravel(l))]
    np.testing.assert_allclose(levels.E, expected, rtol=1e-14)


def test_names_and_broadcasting():
    levels = quasiclassical_levels(Body(Harmonic()), n=[[0, 1, 2], [0, 0, 1]], m=2, l=[0, 2, -4])
    assert levels.names == ("alpha", "beta")
    assert levels.n.tolist() == [[0, 1, 2], [0, 0, 1]]
    assert (levels.m.tolist(), levels.l.tolist()) == ([2, 2, 2], [0, 2, -4])
    assert quasiclassical_levels(Body(HeavyTop(1.0, 0.2)), n=(0, 0), m=2, l=0, chart=R_VARTHETA).names[:2] == (
        "r",
        "vartheta",
    )


def level(**change):
    return quasiclassical_levels(change.pop("model", Body(Harmonic())), **({"n": (0, 0), "m": 0, "l": 0} | change))


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"n": [[0, 1, 2], [0, 1, 2]], "m": [0, 0]}, ValueError, "n, m and l must"),
        ({"maslov": 2}, (TypeError, ValueError), "maslov must"),
        ({"m": 1e300}, (TypeError, ValueError), "m must"),
        ({"n": (0, -1)}, ValueError, "n must .*>= 0"),
        ({"n": (0, 0.5)}, ValueError, "n must be whole"),
        ({"n": (0, np.nan)}, ValueError, "n must be whole"),
        ({"n": (0, 0, 0)}, ValueError, "n must have shape"),
        ({"n": 1}, ValueError, "n must have shape"),
        ({"n": np.zeros((2, 0))}, TypeError, "n must be whole"),
        ({"n": "ab"}, TypeError, "n must be whole"),
        ({"m": 0.5}, ValueError, "m must be whole"),
        ({"l": None}, ValueError, "n, m and l must be given together"),
        ({"l": 1j}, TypeError, "l must be whole"),
        ({"maslov": (2, 2, 0)}, ValueError, "maslov must be two"),
        ({"maslov": (2, -1)}, ValueError, "maslov must be at least 0"),
        ({"maslov": (2, 0.5)}, TypeError, "maslov must be a whole"),
        ({"hbar": 0.0}, ValueError, "hbar must be positive"),
        ({"hbar": -1.0}, ValueError, "hbar must be positive"),
        ({"hbar": "1"}, TypeError, "hbar must be a real"),
        ({"hbar": np.inf}, ValueError, "hbar must be finite"),
        ({"model": Harmonic()}, TypeError, r"Use Body\(Harmonic\(...\)\)"),
        ({"model": Body(NeoHookean())}, ValueError, "model must be separable, got a Body of NeoHookean"),
        ({"model": Body(Hyperelastic()), "chart": ALPHA_BETA}, ValueError, "chart must be one"),
        ({"chart": ELLIPTIC}, ValueError, "alpha-beta or r-vartheta"),
        (
            {"model": StackelBody(Harmonic(), univariate(lambda eta: np.cos(eta)), Zero())},
            ValueError,
            "angular potentials",
        ),
    ],
    ids=str,
)
def test_bad_input(change, error, words):
    with pytest.raises(error, match=words):
        level(**change)


@pytest.mark.parametrize(
    ("energy", "error"), [(np.inf, ValueError), (np.nan, ValueError), ("3", TypeError), ([3.0], TypeError)]
)
def test_bad_energy(energy, error):
    with pytest.raises(error, match="max_energy must be"):
        quasiclassical_levels(Body(Harmonic()), max_energy=energy)
