"""The schemes have the orders they claim, and corrupted ones do not come into being.

Orders are measured in 30 digits by naive steppers, against mpmath's Taylor series (`odefun`), which shares nothing with
them; those of tableaux are also checked on all rooted trees.
"""

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import combinations, pairwise

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import DOP853 as ScipyDOP853

from fastaff import schemes
from fastaff.runs.schemes import _dprkn12, _verner98
from fastaff.runs.schemes.catalogue import (
    BLANES_CASAS_ESCORIHUELA8,
    BLANES_MOAN6,
    DOP853,
    GAUSS8,
    GAUSS16,
    KAHAN_LI8,
    LEAPFROG,
    RK4,
    RKN12,
    SCHEMES,
    SOFRONIOU_SPALETTA8,
    SOFRONIOU_SPALETTA10,
    VERNER9,
    YOSHIDA4,
    Collocation,
    Nystrom,
    RungeKutta,
    Splitting,
    compose,
    scheme_named,
    triple_jump,
)

SPLITTINGS = [s for s in SCHEMES.values() if isinstance(s, Splitting)]
TABLEAUX = [s for s in SCHEMES.values() if isinstance(s, RungeKutta)]
Z0 = ("0.1", "-0.2", "0.35", "0.2")
TIME = 6

# scheme, order, steps of the coarser of two runs (their errors stay clear of the rounding of the coefficients)
ORDERS = [
    (LEAPFROG, 2, 120),
    (YOSHIDA4, 4, 60),
    (BLANES_MOAN6, 6, 24),
    (BLANES_CASAS_ESCORIHUELA8, 8, 16),
    (KAHAN_LI8, 8, 24),
    (SOFRONIOU_SPALETTA8, 8, 16),
    (SOFRONIOU_SPALETTA10, 10, 12),
    (RKN12, 12, 12),
    (RK4, 4, 90),
    (DOP853, 8, 24),
    (VERNER9, 9, 28),
    (GAUSS8, 8, 6),
    (GAUSS16, 16, 10),
]


@pytest.fixture(autouse=True)
def thirty_digits():
    with mp.workdps(30):
        yield


def force(q):
    """Hénon-Heiles."""
    x, y = q
    return [-x - 2 * x * y, -y - x * x + y * y]


def rate(t, z):
    return [z[2], z[3], *force(z[:2])]


def quartic_rate(t, z):
    """The same potential with T = sum of p^2/2 + p^4."""
    return [*map(quartic_velocity, z[2:]), *force(z[:2])]


def quartic_velocity(p):
    return p + 4 * p**3


def start():
    return [mp.mpf(v) for v in Z0]


@cache
def exact(equations, time):
    with mp.workdps(30):
        return mp.odefun(equations, 0, start(), tol=mp.mpf("1e-26"))(time)


def split_step(scheme, z, h, velocity=lambda p: p):
    q, p = z[:2], z[2:]
    for drift, kick in zip(scheme.drift, (*scheme.kick, 0.0)):
        q = [x + h * drift * velocity(v) for x, v in zip(q, p)]
        p = [v + h * kick * f for v, f in zip(p, force(q))]
    return q + p


def slopes(scheme, z, h):
    k = []
    for row in (*scheme.a, *scheme.extra_a):
        k.append(rate(0, combine(z, h, row, k)))
    return k


def combine(z, h, weights, k):
    return [x + h * mp.fsum(w * s[i] for w, s in zip(weights, k)) for i, x in enumerate(z)]


@cache
def collocation(scheme):
    """Its tableau in 30 digits, of its nodes alone: row i integrates all powers below s exactly to c_i."""
    upper = [mp.mpf(x) for x in scheme.nodes]
    c = [1 - x for x in reversed(upper)] + upper
    powers = mp.matrix([[x**k for x in c] for k in range(scheme.stages)])
    rows = [
        list(mp.lu_solve(powers, mp.matrix([x ** (k + 1) / (k + 1) for k in range(len(c))]))) for x in (*c, mp.mpf(1))
    ]
    return rows[:-1], rows[-1]


def gauss_step(scheme, z, h):
    """Picard's iteration of the stages, which knows nothing of the package's own."""
    (a, b), k = collocation(scheme), [rate(0, z)] * scheme.stages
    for _ in range(60):
        k = [rate(0, combine(z, h, row, k)) for row in a]
    return combine(z, h, b, k)


def fractions(row):
    return [Fraction(x) for x in row.split()]


@cache
def nystrom():
    """RKN12 with all its digits."""
    numbers = [fractions(row) for row in (*_dprkn12.A, _dprkn12.B, _dprkn12.C)]
    *a, b, c = [[mp.mpf(x.numerator) / x.denominator for x in row] for row in numbers]
    return a, b, c


def nystrom_step(z, h):
    """The formula as it is published, for q'' = f(q)."""
    (a, b, c), forces = nystrom(), []
    q, p = z[:2], z[2:]
    drift = [w * (1 - x) for w, x in zip(b, c)]
    for row, node in zip((*a, drift), (*c, mp.mpf(1))):
        at = [
            x + node * h * v + h**2 * mp.fsum(w * f[i] for w, f in zip(row, forces))
            for i, (x, v) in enumerate(zip(q, p))
        ]
        if len(forces) < len(b):
            forces.append(force(at))
    return at + combine(p, h, b, forces)


def step(scheme, z, h):
    if isinstance(scheme, Nystrom):
        return nystrom_step(z, h)
    if isinstance(scheme, Collocation):
        return gauss_step(scheme, z, h)
    return split_step(scheme, z, h) if isinstance(scheme, Splitting) else combine(z, h, scheme.b, slopes(scheme, z, h))


def dense(scheme, z, h, x, k):
    """Value of the interpolant at the fraction x of a step, by the formula of the docstring."""
    value = [mp.mpf(0)] * len(z)
    for r, row in reversed(list(enumerate(scheme.dense))):
        inner = combine([mp.mpf(0)] * len(z), h, row, k)
        value = [(u + v) * (x if r % 2 == 0 else 1 - x) for u, v in zip(inner, value)]
    return [u + v for u, v in zip(z, value)]


def distance(u, v):
    return mp.norm(mp.matrix(u) - mp.matrix(v))


def global_error(advance, equations, steps):
    z = start()
    for _ in range(steps):
        z = advance(z, mp.mpf(TIME) / steps)
    return distance(z, exact(equations, TIME))


def halving_slope(error_of):
    """log2 of the ratio of the errors at size 1 and size 1/2."""
    return float(mp.log(error_of(1) / error_of(2), 2))


def agrees(scheme, slope, order, allowance):
    """VERNER9's leading terms, as Gauss's, are so small that the next ones still show where the rounding of its
    coefficients begins.

    Its orders themselves are the business of the rooted trees.
    """
    return -allowance < slope - order < (1.0 if scheme in (VERNER9, RKN12, GAUSS8, GAUSS16) else allowance)


def test_the_order_table_is_complete():
    assert {scheme.name: order for scheme, order, _ in ORDERS} == {s.name: s.order for s in SCHEMES.values()}


@pytest.mark.parametrize(("scheme", "order", "steps"), ORDERS, ids=lambda v: getattr(v, "name", None))
def test_order(scheme, order, steps):
    slope = halving_slope(lambda m: global_error(lambda z, h: step(scheme, z, h), rate, m * steps))
    assert agrees(scheme, slope, order, 0.06)


@pytest.mark.parametrize("scheme", SPLITTINGS, ids=lambda s: s.name)
def test_order_for_kinetic_energy_of_degree_four(scheme):
    """Only a Nyström splitting loses its order (six becomes four) when T is not quadratic."""
    steps = {s.name: n for s, _, n in ORDERS}[scheme.name]
    slope = halving_slope(
        lambda m: global_error(lambda z, h: split_step(scheme, z, h, quartic_velocity), quartic_rate, 2 * m * steps)
    )
    assert slope == pytest.approx(4 if scheme.nystrom else scheme.order, abs=0.2)


@pytest.mark.parametrize("scheme", SPLITTINGS, ids=lambda s: s.name)
def test_splittings_are_reversible(scheme):
    h = mp.mpf("0.3")
    assert distance(split_step(scheme, split_step(scheme, start(), h), -h), start()) < 1e-28


@pytest.mark.parametrize("scheme", TABLEAUX, ids=lambda s: s.name)
def test_the_interpolant_meets_both_ends(scheme):
    z, h = start(), mp.mpf("0.4")
    k = slopes(scheme, z, h)
    assert distance(dense(scheme, z, h, 0, k), z) == 0
    assert distance(dense(scheme, z, h, 1, k), step(scheme, z, h)) == 0


# A rooted tree is the sorted tuple of its branches.


def grown(tree):
    """All trees with a leaf more."""
    yield tuple(sorted((*tree, ())))
    for i, branch in enumerate(tree):
        for larger in grown(branch):
            yield tuple(sorted((*tree[:i], larger, *tree[i + 1 :])))


def trees(largest):
    """The trees with 1, 2, ..., `largest` nodes."""
    every = [{()}]
    while len(every) < largest:
        every.append({larger for tree in every[-1] for larger in grown(tree)})
    return every


def nodes(tree):
    return 1 + sum(map(nodes, tree))


def density(tree):
    """gamma(t): the product of the numbers of nodes of all subtrees."""
    return nodes(tree) * math.prod(map(density, tree))


def elementary_weights(scheme, tree, known):
    """Phi(t): the vector over slopes of products, over the branches, of a times their vectors."""
    if tree not in known:
        branches = [scheme.a_array @ elementary_weights(scheme, branch, known) for branch in tree]
        known[tree] = math.prod(branches, start=np.ones(len(scheme.a_array)))
    return known[tree]


def test_rooted_trees_are_counted_right():
    assert [len(t) for t in trees(9)] == [1, 1, 2, 4, 9, 20, 48, 115, 286]
    assert sorted(density(t) for t in trees(4)[-1]) == [4, 8, 12, 24]


def test_order_conditions():
    """Sum of w_i Phi_i(t) = x^n/gamma(t) for all trees of n <= order nodes, and not for all trees with a node more.

    For b at x = 1, for the interpolant at any x, and with 0 at the right for the estimates: Hairer, Norsett & Wanner
    II.2.
    """
    largest = trees(max(s.order for s in TABLEAUX) + 1)
    for scheme in TABLEAUX:
        known, size = {}, len(scheme.a_array)
        cases = [(scheme.b, 1.0, scheme.order), *((e, 0.0, p) for e, p in zip(scheme.errors, scheme.error_orders))]
        for x in (0.2, 0.37, 0.8):
            weights = np.zeros(size)
            for r, row in reversed(list(enumerate(scheme.dense))):
                weights = (np.array(row) + weights) * (x if r % 2 == 0 else 1 - x)
            cases.append((weights, x, scheme.dense_order))
        for weights, x, order in cases:
            full = np.array([*weights, *[0.0] * (size - len(weights))])
            residuals = [
                max(abs(full @ elementary_weights(scheme, tree, known) - x**n / density(tree)) for tree in level)
                for n, level in enumerate(largest[: order + 1], 1)
            ]
            assert max(residuals[:-1]) < 5e-16 * max(1.0, np.abs(full).sum()) * len(full) ** 0.5, (scheme.name, x)
            assert residuals[-1] > 1e-6, (scheme.name, x)


@pytest.mark.parametrize("x", ["0", "1/7", "1/2", "6/7", "1"])
def test_verner9_interpolates_by_the_published_polynomials(x):
    """The nested rows, each rounded once, are the polynomials in powers of x."""
    x, value = Fraction(x), [Fraction(0)] * len(VERNER9.dense[0])
    for r, row in reversed(list(enumerate(VERNER9.dense))):
        value = [(Fraction(c) + v) * (x if r % 2 == 0 else 1 - x) for c, v in zip(row, value)]
    for column, weight in enumerate(value):
        published = sum(Fraction(c) * x**n for n, c in enumerate(_verner98._POWERS.get(column, ()), 1))
        rounding = sum(abs(row[column]) * float(x * (1 - x)) ** (r // 2) for r, row in enumerate(VERNER9.dense))
        assert abs(weight - published) <= 2e-16 * rounding + 1e-30


def test_dop853_steps_and_interpolates_like_scipy():
    h, z = 0.4, [float(v) for v in Z0]
    solver = ScipyDOP853(lambda t, z: np.array(rate(t, z)), 0.0, np.array(z), 10.0, first_step=h, rtol=0.1, atol=0.1)
    solver.step()
    assert solver.t == h
    interpolant, k = solver.dense_output(), slopes(DOP853, start(), mp.mpf(h))
    for x in np.linspace(0.0, 1.0, 9):
        ours = np.array([float(v) for v in dense(DOP853, start(), mp.mpf(h), mp.mpf(x), k)])
        np.testing.assert_allclose(interpolant(x * h), ours, rtol=0, atol=1e-14)


def test_shapes_and_derived_properties():
    assert {s.name: (s.stages, s.evaluations) for s in SCHEMES.values()} == {
        "LEAPFROG": (1, 1),
        "YOSHIDA4": (3, 3),
        "BLANES_MOAN6": (14, 14),
        "BLANES_CASAS_ESCORIHUELA8": (19, 19),
        "KAHAN_LI8": (17, 17),
        "SOFRONIOU_SPALETTA8": (21, 21),
        "SOFRONIOU_SPALETTA10": (35, 35),
        "RKN12": (17, 17),
        "RK4": (4, 4),
        "DOP853": (13, 12),
        "VERNER9": (17, 16),
        "GAUSS8": (4, 32),
        "GAUSS16": (8, 64),
    }
    assert [(s.fsal, s.adaptive) for s in (RK4, DOP853, VERNER9)] == [(False, False), (True, True), (True, True)]
    for s in SPLITTINGS:
        assert (s.drift_array.shape, s.kick_array.shape) == ((s.stages + 1,), (s.stages,))
    for s, extra in ((RK4, 0), (DOP853, 3), (VERNER9, 4)):
        every = s.stages + extra
        shapes = [a.shape for a in (s.a_array, s.b_array, s.c_array, s.error_array, s.dense_array)]
        assert shapes == [(every, every), (s.stages,), (every,), (len(s.errors), s.stages), (len(s.dense), every)]
        np.testing.assert_allclose(s.a_array.sum(axis=1), s.c_array, rtol=0, atol=1e-13)
        assert not np.triu(s.a_array).any()
    KAHAN_LI8.drift_array[:] = 0.0
    assert KAHAN_LI8.drift_array.all()


def test_nystrom_coefficients_fulfil_the_conditions_in_all_their_digits():
    """Simplifying conditions and quadratures of RKN12, exactly but for the digits that are kept, whence its order by
    rooted trees; its numbers are these, and sums of them.
    """
    a, (b, c) = [fractions(row) for row in _dprkn12.A], map(fractions, (_dprkn12.B, _dprkn12.C))
    stages = range(len(b))
    assert all(abs(sum(w * x**k for w, x in zip(b, c)) - Fraction(1, k + 1)) < 1e-28 for k in range(12))
    for k in range(5):  # rows of the stages that weights and later sums are of
        defects = [
            sum(w * c[j] ** k for j, w in enumerate(row)) - x ** (k + 2) / ((k + 1) * (k + 2)) for row, x in zip(a, c)
        ]
        assert max(map(abs, defects[6:])) < 1e-26
    for j in stages:  # columns
        column = sum(b[i] * a[i][j] for i in stages if i > j)
        assert abs(column - b[j] * (c[j] ** 2 / 2 - c[j] + Fraction(1, 2))) < 1e-26 or j == 1
    sums = [[x / node for x in row] for row, node in zip(a, c)] + [[x * (1 - y) for x, y in zip(b, c)], b]
    flat = [float(x) for row in sums for x in row if x != 0]
    np.testing.assert_allclose(RKN12.drift_array, flat, rtol=1e-15, atol=0)
    assert [list(terms) for terms in RKN12.terms] == [[j for j, x in enumerate(row) if x] for row in sums]
    np.testing.assert_array_equal(RKN12.kick_array, [float(x) for x in c])


@pytest.mark.parametrize(
    ("wrong", "fault"),
    [
        (lambda s: {"b": s.b[:-1]}, "one row or entry per stage"),
        (lambda s: {"a": (*s.a[:-1], s.a[-1][:-1])}, "row i of a must have i entries"),
        (lambda s: {"c": (0.0, -0.02, *s.c[2:])}, "nodes must be positive"),
        (lambda s: {"b": (math.nan, *s.b[1:])}, "finite"),
        (lambda s: {"order": 13}, "contradicts the order 13"),
        *(
            (lambda s, i=i, j=j: {"a": _moved_apart(s.a, i, j)}, "a contradicts the order")
            for i, j in ((4, 2), (5, 2), (8, 6), (11, 4), (13, 9), (14, 13), (16, 7))
        ),
        *((lambda s, j=j: {"b": _changed(s.b, j)}, "b contradicts the order") for j in (0, 6, 12, 16)),
        *((lambda s, j=j: {"c": _changed(s.c, j)}, "contradict|must sum to") for j in (3, 9, 14)),
    ],
)
def test_nystrom_refuses_what_is_not(wrong, fault):
    with pytest.raises(ValueError, match=fault):
        replace(RKN12, **wrong(RKN12))


def _changed(row, j, by=1e-9):
    return (*row[:j], row[j] + by, *row[j + 1 :])


def _moved_apart(a, i, j):
    """A row with the same sum."""
    by = 1e-9 if i > 6 else 1e-5
    return (*a[:i], _changed(_changed(a[i], j, by), (j + 1) % i, -by), *a[i + 1 :])


def test_every_scheme_names_its_source_and_is_exported():
    for s in SCHEMES.values():
        assert getattr(schemes, s.name) is s
        assert any(character.isdigit() for character in s.source)
        assert hash(s) == hash(replace(s))


@pytest.mark.parametrize("scheme", [GAUSS8, GAUSS16], ids=lambda s: s.name)
def test_collocations_are_symplectic_symmetric_and_refuse_what_is_not(scheme):
    a, b, dense = scheme.a_array, scheme.b_array, scheme.dense_array
    exact, weights = collocation(scheme)
    np.testing.assert_allclose(a * b, np.array(exact, dtype=float), rtol=0, atol=1e-16)
    np.testing.assert_allclose(b, np.array(weights, dtype=float), rtol=1e-15)
    assert (a + a.T == 1.0).all()  # b_i a_ij + b_j a_ji = b_i b_j, exactly
    np.testing.assert_allclose(a + a[::-1, ::-1], 1.0, rtol=0, atol=1e-15)
    roots, weights = np.polynomial.legendre.leggauss(scheme.stages)
    np.testing.assert_allclose(b, weights / 2, rtol=0, atol=1e-15)
    c = (1 + roots) / 2
    np.testing.assert_allclose(a @ b, c, rtol=0, atol=1e-15)
    for i, k in np.ndindex(scheme.stages, 2 * scheme.stages):  # polynomials through the slopes are integrated exactly
        if k < scheme.stages + i:
            parts = np.concatenate([b * (c - 1) ** k, b * c**k])
            size = np.abs(dense[i] * parts).sum() * 1e-14
            assert dense[i] @ parts == pytest.approx(c[i] ** (k + 1) / (k + 1), rel=0, abs=size)
        assert not dense[i, scheme.stages + i :].any()
    for k, wrong in enumerate(scheme.nodes):
        nodes = (*scheme.nodes[:k], wrong[:4] + str((int(wrong[4]) + 3) % 10) + wrong[5:], *scheme.nodes[k + 1 :])
        with pytest.raises(ValueError, match="contradict order"):
            replace(scheme, nodes=nodes)
    for change in ({"order": scheme.order + 1}, {"nodes": scheme.nodes[::-1]}, {"nodes": scheme.nodes[1:]}):
        with pytest.raises(ValueError, match=scheme.name):
            replace(scheme, **change)


def corrupted(value, index, change):
    """The nested tuple with `change` applied to the entry of that index, counted through all rows."""
    flat = [list(row) if isinstance(row, tuple) else row for row in value]
    places = [(flat, i) for i, row in enumerate(flat) if not isinstance(row, list)]
    places += [(row, j) for row in flat if isinstance(row, list) for j in range(len(row))]
    row, j = places[index % len(places)]
    row[j] = change(row[j])
    return tuple(tuple(row) if isinstance(row, list) else row for row in flat)


FIELDS = [(s, f) for s in SPLITTINGS for f in ("drift", "kick")] + [
    (s, f) for s in TABLEAUX for f in ("a", "b", "c", "errors", "extra_a", "extra_c", "dense") if getattr(s, f)
]


@settings(deadline=None, max_examples=300)
@given(
    field=st.sampled_from(FIELDS),
    index=st.integers(0, 10_000),
    sign=st.sampled_from([-1, 1]),
    size=st.floats(1e-10, 1.0),
)
def test_one_wrong_coefficient_is_refused(field, index, sign, size):
    scheme, name = field
    with pytest.raises(ValueError, match=scheme.name):
        replace(scheme, **{name: corrupted(getattr(scheme, name), index, lambda c: c + sign * size)})


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize(("scheme", "name"), FIELDS, ids=lambda v: getattr(v, "name", v))
def test_coefficients_must_be_finite(scheme, name, value):
    with pytest.raises(ValueError, match=scheme.name):
        replace(scheme, **{name: corrupted(getattr(scheme, name), 1, lambda c: value)})


@pytest.mark.parametrize("scheme", [s for s in SPLITTINGS if s.order >= 6], ids=lambda s: s.name)
def test_exchanged_coefficients_are_refused(scheme):
    """An exchange keeps the sum and the symmetry: only the quadrature conditions see it."""
    half = len(scheme.kick) // 2
    for i, j in combinations(range(half), 2):
        order = list(range(len(scheme.kick)))
        order[i], order[j], order[-1 - i], order[-1 - j] = j, i, order[-1 - j], order[-1 - i]
        with pytest.raises(ValueError, match="contradict the order"):
            replace(scheme, kick=tuple(scheme.kick[n] for n in order))


@pytest.mark.parametrize(
    ("scheme", "changes", "message"),
    [
        (LEAPFROG, {"drift": (0.4, 0.6)}, "drift coefficients must be palindromic"),
        (LEAPFROG, {"drift": (0.6, 0.6)}, "drift coefficients must sum to 1"),
        (LEAPFROG, {"drift": (0.5,)}, "one drift more than kicks, got 1 drifts and 1 kicks"),
        (LEAPFROG, {"drift": (1.0,), "kick": ()}, "one drift more than kicks"),
        (LEAPFROG, {"order": 4}, "contradict the order 4"),
        (LEAPFROG, {"order": 0}, "order must be at least 1, got 0"),
        (RK4, {"a": RK4.a[1:]}, "one row or entry per stage"),
        (RK4, {"a": ((0.0,), *RK4.a[1:])}, "must have i entries"),
        (RK4, {"order": 5}, "b contradicts the order 5"),
        (RK4, {"dense": RK4.dense[:2]}, "at least as many rows as its order"),
        (RK4, {"b": RK4.b, "dense": (RK4.dense[0][:3], *RK4.dense[1:])}, "rows of dense must have 4 weights"),
        (DOP853, {"error_orders": (5,)}, "one order per row"),
        (DOP853, {"error_orders": (6, 3)}, r"errors\[0\] contradicts the order 6"),
        (DOP853, {"errors": (DOP853.errors[0], DOP853.errors[1][:-1])}, "one weight per stage"),
        (DOP853, {"errors": DOP853.errors * 2, "error_orders": (5, 3, 5, 3)}, "at most two rows"),
        (
            RK4,
            {"errors": ((0.0,) * 4,), "error_orders": (3,)},
            r"errors need a last row of a that is b, with b\[-1\] = 0",
        ),
        (DOP853, {"extra_c": DOP853.extra_c[:2]}, "per extra slope"),
        (DOP853, {"dense_order": 8}, "at least as many rows"),
    ],
)
def test_faults_are_named(scheme, changes, message):
    with pytest.raises(ValueError, match=message):
        replace(scheme, **changes)


def test_a_splitting_may_kick_first_and_be_composed():
    verlet = Splitting("VERLET", 2, "kick first", drift=(0.0, 1.0, 0.0), kick=(0.5, 0.5))
    assert (verlet.stages, verlet.evaluations) == (2, 1)
    jump = triple_jump(verlet, name="VERLET4", source="Yoshida 1990")
    assert (jump.order, jump.stages, jump.evaluations) == (4, 4, 3)
    assert jump.drift[0] == jump.drift[-1] == 0.0
    assert jump.drift[1:-1] == YOSHIDA4.kick
    assert jump.kick == YOSHIDA4.drift
    assert compose(verlet, [], name="VERLET", order=2, source="kick first") == verlet


def test_a_sixth_order_triple_jump_has_order_six():
    jump = triple_jump(YOSHIDA4, name="YOSHIDA6", source="Yoshida 1990")
    slope = halving_slope(lambda m: global_error(lambda z, h: step(jump, z, h), rate, 60 * m))
    assert (jump.order, jump.stages) == (6, 9)
    assert slope == pytest.approx(6, abs=0.1)


def test_compose_refuses_an_order_it_does_not_reach():
    with pytest.raises(ValueError, match="scheme X: kick coefficients contradict the order 4"):
        compose(LEAPFROG, ["1.3"], name="X", order=4, source="none")


def test_adjacent_drifts_are_merged_with_one_rounding():
    weights = KAHAN_LI8.kick
    assert len(weights) == 17
    np.testing.assert_allclose(KAHAN_LI8.drift[1:-1], [(u + v) / 2 for u, v in pairwise(weights)], rtol=0, atol=1e-16)


def test_scheme_named():
    assert scheme_named("KAHAN_LI8") is KAHAN_LI8
    assert scheme_named("dop853") is DOP853
    with pytest.raises(ValueError, match=r"one of LEAPFROG, .*, got 'KAHAN_LI9'\. Did you mean KAHAN_LI8\?"):
        scheme_named("KAHAN_LI9")
    with pytest.raises(ValueError, match=r"got 'xyz'\.$"):
        scheme_named("xyz")
