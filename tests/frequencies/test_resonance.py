"""Resonance modules against exact integer arithmetic and the paper's degeneracies; webs against their equations."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from fractions import Fraction

import naive
import numpy as np
import pytest
import shared_systems
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

import fastaff
from fastaff import Anharmonic, Body, Harmonic, HeavyTop, Hyperelastic, Status
from fastaff.frequencies.kernels import resonance as kernels
from fastaff.frequencies.resonance_web import ratio_web, resonance_web
from fastaff.frequencies.resonances import CHANCE, diffusion_histogram, equation, resonances, vectors

CHART = ("alpha", "beta", "phi", "psi")


def every_vector(n, max_order):
    """Return all primitive k with |k|_1 <= max_order, first entry that is not zero positive: by looking at every k."""
    found = []
    for k in itertools.product(range(-max_order, max_order + 1), repeat=n):
        lead = next((c for c in k if c), 0)
        if lead > 0 and sum(map(abs, k)) <= max_order and math.gcd(*k) == 1:
            found.append(k)
    return found


def rank_of(rows):
    """Return the rank of integer vectors, by elimination with fractions."""
    rows, rank = [[Fraction(c) for c in row] for row in rows], 0
    for column in range(len(rows[0]) if rows else 0):
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for i in range(rank + 1, len(rows)):
            factor = rows[i][column] / rows[rank][column]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[rank])]
        rank += 1
    return rank


def minors_divisor(rows):
    """Return the greatest common divisor of the largest minors of integer rows: 1 where they span a primitive
    lattice.
    """
    r = len(rows)
    return math.gcd(
        *(round(np.linalg.det(np.array(rows)[:, list(c)])) for c in itertools.combinations(range(len(rows[0])), r))
    )


def relations(nu, width, max_order):
    """Naive twin: the vectors within their widths, one at a time."""
    return [k for k in every_vector(len(nu), max_order) if abs(np.dot(k, nu)) <= np.dot(np.abs(k), width)]


def chance_of_a_relation(nu, errors, max_order):
    """Return the expected number of relations of a random direction: the part of the sphere beside their planes, from
    the density of one component there.
    """
    n, size = len(nu), np.linalg.norm(nu)
    density = 1 / quad(lambda u: math.sin(u) ** (n - 2), 0.0, math.pi)[0]
    widths = [np.abs(k) @ errors / (np.linalg.norm(k) * size) for k in every_vector(n, max_order)]
    return 2 * density * sum(widths)


@pytest.mark.parametrize(("n", "max_order"), [(1, 3), (2, 7), (3, 5), (4, 4)])
def test_vectors_are_all_primitive_ones_by_length(n, max_order):
    found = [tuple(int(c) for c in k) for k in vectors(n, max_order)]
    assert len(set(found)) == len(found)
    assert set(found) == set(every_vector(n, max_order))
    lengths = [sum(map(abs, k)) for k in found]
    assert lengths == sorted(lengths)
    assert not vectors(n, max_order).flags.writeable


@st.composite
def whole_frequencies(draw):
    """Small whole numbers: their relations are exact in floating point."""
    n = draw(st.integers(2, 4))
    return draw(st.lists(st.integers(-12, 12), min_size=n, max_size=n)), draw(st.integers(1, 6 if n == 4 else 9))


@given(whole_frequencies())
def test_module_of_whole_frequencies(case):
    """Rank, span, primitivity and shortest vector against Python integers."""
    nu, max_order = case
    truth = [k for k in every_vector(len(nu), max_order) if sum(a * b for a, b in zip(k, nu)) == 0]
    found = resonances(np.array(nu, dtype=float), max_order=max_order, tolerance=0.0)
    rank = int(found.rank)
    basis = found.basis[:rank].tolist()
    assert rank == (rank_of(truth) if truth else 0)
    assert found.dimension == len(nu) - rank
    assert not found.basis[rank:].any()
    if truth:
        assert found.order == sum(map(abs, truth[0])) or found.order == min(sum(map(abs, k)) for k in truth)
        assert minors_divisor(basis) == 1
        assert all(rank_of([*basis, k]) == rank for k in truth), (
            "every relation lies in the span of a primitive lattice"
        )
        assert all(next(c for c in k if c) > 0 and sum(a * b for a, b in zip(k, nu)) == 0 for k in basis)
        lengths = [sum(map(abs, k)) for k in basis]
        assert lengths == sorted(lengths)
        assert found.distance[:rank] == pytest.approx(0.0, abs=0)
    assert np.isnan(found.distance[rank:]).all()


def minkowski(truth, basis):
    """Return the lengths of Minkowski's reduced basis: the shortest vector that leaves the set primitive, one after
    another.
    """
    chosen = []
    for k in sorted(truth, key=lambda k: sum(map(abs, k))):
        rows = [*chosen, k]
        if rank_of(rows) == len(rows) and minors_divisor(rows) == 1:
            chosen.append(k)
    return [sum(map(abs, k)) for k in chosen][: len(basis)]


@given(st.lists(st.integers(-6, 6), min_size=4, max_size=4).filter(any))
def test_basis_is_reduced(nu):
    """The lengths are those of Minkowski's reduction by definition, over vectors far beyond the longest."""
    found = resonances(np.array(nu, dtype=float), max_order=12, tolerance=0.0)
    basis = found.basis[: int(found.rank)].tolist()
    assert len(basis) == 3, "three independent vectors of order 12 or less are orthogonal to any such nu"
    truth = [tuple(k) for k in vectors(4, 12).tolist() if sum(a * b for a, b in zip(k, nu)) == 0]
    assert [sum(map(abs, k)) for k in basis] == minkowski(truth, basis)


def test_a_set_that_is_not_primitive_is_completed():
    """(1, 2, 0) and (1, 0, 2) span a lattice of index 2: their mean (1, 1, 1) replaces the second."""
    form, basis, work = np.zeros(6, np.int64), np.zeros((4, 4), np.int64), np.zeros(10, np.int64)
    rank = 0
    for k in ([1, 2, 0, 0], [1, 0, 2, 0], [3, 2, 4, 0]):  # the last is in their span
        rank = kernels.adopt(4, rank, np.array(k), form, basis, work)
    assert rank == 2
    assert minors_divisor(basis[:2].tolist()) == 1
    assert rank_of([*basis[:2].tolist(), [1, 0, 2, 0]]) == 2
    assert basis[1].tolist() in ([0, 1, -1, 0], [1, 1, 1, 0])
    assert kernels.inside(2, form[None], 0, 3, 2, 4, 0)
    assert not kernels.inside(2, form[None], 0, 3, 2, 4, 1)


@given(st.integers(0, 2**32 - 1), st.integers(2, 4), st.floats(1e-6, 3e-3))
def test_naive_twin_with_errors(seed, n, tolerance):
    """Any frequencies and errors: the relations found one at a time have the rank of the kernel's and lie in its
    span. Without one that is significant an orbit with relations is undecided.
    """
    rng = np.random.default_rng(seed)
    nu, errors = rng.standard_normal((n, 5)), tolerance * rng.random((n, 5))
    found = resonances(nu, max_order=5, tolerance=tolerance, errors=errors)
    for i in range(5):
        width = tolerance * np.abs(nu[:, i]).max() + errors[:, i]
        truth = relations(nu[:, i], width, 5)
        rank = int(found.rank[i])
        basis = found.basis[:rank, :, i].tolist()
        orders = [m for m in range(1, 6) if chance_of_a_relation(nu[:, i], errors[:, i], m) < CHANCE]
        truth = [k for k in truth if sum(map(abs, k)) <= max(orders, default=0)]
        if found.status[i]:  # contradictory, or by chance
            assert not rank
            assert rank_of(truth) > 1 if truth else relations(nu[:, i], width, 5)
            continue
        assert rank == (rank_of(truth) if truth else 0)
        if truth:
            assert rank_of(basis) == rank
            assert all(rank_of([*basis, k]) == rank for k in truth)
            assert minors_divisor(basis) == 1
            assert found.distance[:rank, i] == pytest.approx(np.abs(np.array(basis) @ nu[:, i]), abs=1e-14)
            assert found.width[:rank, i] == pytest.approx(np.abs(basis) @ width, rel=1e-12)


def test_harmonic_body_is_periodic():
    """nu = w/pi, w/pi and eta, gamma at w/2 pi each: three relations, closed orbits. Source: EQ3.21-3.23."""
    body = Body(Harmonic(C=1.3), mu=0.7)
    found = resonances(four(body, naive.states(body, 12)), names=CHART)
    assert (found.dimension == 1).all()
    assert (found.status == Status.OK).all()
    w = math.sqrt(1.3 / 0.7)
    for s in (1, -1):
        one = resonances([w / math.pi, w / math.pi, s * w / (2 * math.pi), 0.0], names=CHART)
        assert one.dimension == 1
        assert one.label() == f"nu_psi = 0, nu_alpha - nu_beta = 0, nu_alpha {'-' if s > 0 else '+'} 2 nu_phi = 0"


def four(body, z):
    """Return the frequencies of an integrable body in the order librations, phi, psi."""
    nu = naive.frequencies(body, z)
    return np.array([nu[0], nu[1], (nu[2] + nu[3]) / 2, (nu[3] - nu[2]) / 2])


def test_anharmonic_body_fills_two_dimensional_tori():
    """nu_alpha = nu_beta = 2 s (nu_phi + nu_psi), s = sign p_gamma, and no third relation. Source: after EQa,
    corrected.
    """
    body = Body(Anharmonic(C=0.9), mu=1.4)
    z = naive.states(body, 40)
    found = resonances(four(body, z), names=CHART)
    p_gamma = naive.constants(body, z)[2]
    # A random orbit meets a third relation with the probability `accidental`, 2e-6.
    assert (found.dimension == 2).all()
    expected = {1: ((1, -1, 0, 0), (1, 0, -2, -2)), -1: ((1, -1, 0, 0), (1, 0, 2, 2))}
    for i, s in enumerate(np.sign(p_gamma).astype(int)):
        assert tuple(tuple(k) for k in found.basis[:2, :, i].tolist()) == expected[s]
    assert found.table() == sorted(
        ((expected[s], int((np.sign(p_gamma) == s).sum())) for s in (1, -1)), key=lambda entry: (-entry[1], entry[0])
    )
    assert found.label(int(np.argmax(p_gamma > 0))) == "nu_alpha - nu_beta = 0, nu_alpha - 2 nu_phi - 2 nu_psi = 0"
    assert (found.order == 2).all()


@pytest.mark.parametrize(
    "body", [Body(Hyperelastic(C=1.1), mu=0.8), Body(HeavyTop(C=1.2, A=0.6), mu=1.1)], ids=naive.label
)
def test_generic_integrable_bodies_have_no_relation(body):
    """Four independent frequencies: none of 40 orbits is resonant, as the expected number of accidents says."""
    z = naive.states(body, 60)
    nu = four(body, z)
    nu = nu[:, np.isfinite(nu).all(axis=0)][:, :40]
    found = resonances(nu, tolerance=1e-9)
    assert found.accidental.sum() < 1e-3
    assert (found.dimension == 4).all()


def test_accidental_is_the_mean_number_of_relations():
    """20 000 random directions, order 3: orbits with a relation, to 4 standard deviations and the few with two."""
    for n in (2, 3, 4):
        rng = np.random.default_rng(n)
        nu = rng.standard_normal((n, 20_000))
        nu /= np.sqrt((nu * nu).sum(axis=0))
        errors = np.full(nu.shape, 5e-4)
        found = resonances(nu, max_order=3, tolerance=0.0, errors=errors)
        expected = found.accidental
        assert np.ptp(expected) < 1e-12
        count = np.count_nonzero(found.rank | (found.status == Status.NOT_CONVERGED))  # counted or undecided
        mean = nu.shape[1] * expected[0]
        assert mean > 50
        assert abs(count - mean) < 4 * math.sqrt(mean) + expected[0] * mean


def test_shapes_and_statuses():
    nu = np.ones((3, 4, 5))
    nu[1, 2, 3], nu[0, 0, 0] = np.nan, np.inf
    errors = np.zeros_like(nu)
    errors[2, 1, 1] = np.inf
    found = resonances(nu, errors=errors)
    assert found.rank.shape == found.order.shape == found.status.shape == found.accidental.shape == (4, 5)
    assert found.basis.shape == (3, 3, 4, 5)
    assert found.distance.shape == found.width.shape == (3, 4, 5)
    assert found.status[2, 3] == found.status[0, 0] == Status.NONFINITE
    assert found.status[1, 1] == Status.NOT_CONVERGED
    bad = found.status != Status.OK
    assert bad.sum() == 3
    assert not found.rank[bad].any()
    assert (found.rank[~bad] == 2).all()
    assert "NONFINITE" in found.label((2, 3))
    assert "17 with 2 resonances" in found.summary()
    assert resonances([1.0, math.sqrt(2)]).label() == "no resonance up to order 8"
    assert resonances(np.ones((2, 0))).rank.shape == (0,)


def test_relations_within_wide_errors_are_undecided():
    """Frequencies drawn at random, no relation holds: with errors from sharp to wider than they are, few count."""
    rng = np.random.default_rng(8)
    nu = np.abs(rng.standard_normal((3, 4000))) + 0.1
    errors = 10.0 ** rng.uniform(-6, 0.3, 4000) * rng.uniform(0.5, 1.5, (3, 4000))
    found = resonances(nu, max_order=4, errors=errors)
    assert np.count_nonzero(found.rank) < 0.01 * 4000
    undecided = found.status == Status.NOT_CONVERGED
    assert (undecided[errors.min(axis=0) > nu.max(axis=0)]).all()
    assert not undecided[errors.max(axis=0) < 1e-5].any()
    assert not found.rank[undecided].any()
    said = f"{np.count_nonzero(undecided)} NOT_CONVERGED (undecided, as the errors of the frequencies are too wide"
    assert said in found.summary()
    assert f"{np.count_nonzero(undecided):8d}          undecided" in str(found)
    assert "guess" not in found.summary()
    assert "undecided" in found.label(int(np.flatnonzero(undecided)[0]))


def test_true_relations_count_up_to_the_errors_that_allow_them():
    """A tube with nu_x = nu_y: counted with sharp errors, with a chance of other relations alone, and not with wide
    ones.
    """
    rng = np.random.default_rng(9)
    nu = np.abs(rng.standard_normal((3, 500))) + 0.3
    nu[1] = nu[0]
    for error, rank, share in ((1e-9, 1, 0.9), (1e-4, 1, 0.9), (0.1, 0, 0.0)):
        found = resonances(nu, max_order=8, errors=np.full(nu.shape, error))
        assert np.mean(found.rank == rank) > 0.9
        assert (found.basis[0] == np.array([1, -1, 0])[:, None]).all(axis=0).mean() >= share
    wide = resonances(nu, max_order=2, errors=np.full(nu.shape, 0.1))
    assert (wide.status == Status.NOT_CONVERGED).mean() > 0.9
    assert (resonances(nu, max_order=2, tolerance=0.1).rank > 0).all()  # a tolerance is the user's own


def test_rest_is_the_whole_lattice():
    found = resonances(np.zeros(4), max_order=3)
    assert found.dimension == 0
    assert (found.basis == np.eye(4)).all()
    assert found.accidental == len(vectors(4, 3))


def test_lanes_do_not_see_one_another():
    """Any order and company of the orbits gives the same bits; bad neighbours change nothing."""
    rng = np.random.default_rng(3)
    nu = rng.integers(-9, 10, (4, 300)).astype(float)
    whole = resonances(nu, max_order=6)
    order = rng.permutation(300)
    shuffled = nu[:, order]
    shuffled[:, ::7] = np.nan
    other = resonances(shuffled, max_order=6)
    kept = np.isfinite(shuffled[0])
    assert (other.basis[..., kept] == whole.basis[..., order][..., kept]).all()
    one = resonances(nu[:, 17], max_order=6)
    assert (one.basis == whole.basis[..., 17]).all()


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda: resonances(1.0), ValueError, "nu must have shape"),
        (lambda: resonances(np.ones(5)), ValueError, "nu must have shape"),
        (lambda: resonances(["a", "b"]), TypeError, "arrays of real numbers"),
        (lambda: resonances(np.ones(2) * 1j), TypeError, "arrays of real numbers"),
        (lambda: resonances([1, 2], max_order=0), ValueError, "max_order must be at least 1"),
        (lambda: resonances([1, 2], max_order=51), ValueError, "max_order must be at most 50"),
        (lambda: resonances([1, 2], tolerance=-1.0), ValueError, "tolerance must not be negative"),
        (lambda: resonances([1, 2], errors=[1.0]), ValueError, "errors must have the shape"),
        (lambda: resonances([1, 2], errors=[-1.0, 0.0]), ValueError, "errors must not be negative"),
        (lambda: resonances([1, 2], names=["x"]), ValueError, "names must be 2 names"),
        (lambda: resonance_web(np.ones((2, 5))), ValueError, "nu must have shape"),
        (
            lambda: resonance_web(np.ones((2, 5, 4)), axes=[np.arange(4), np.arange(5)]),
            ValueError,
            "axes must be two increasing",
        ),
        (
            lambda: resonance_web(np.ones((2, 5, 4)), resonances=[[1.5, 0]]),
            ValueError,
            "resonances must be integer vectors",
        ),
        (lambda: ratio_web(x=(1, 0), y=(0, 1)), ValueError, "x must be a range"),
        (lambda: diffusion_histogram([0.0], bin_width=0.0), ValueError, "bin_width must be positive"),
        (lambda: diffusion_histogram([0.0], status=[0, 0]), ValueError, "status must have the shape"),
    ],
)
def test_wrong_input(call, error, match):
    with pytest.raises(error, match=match):
        call()


def test_equation():
    assert equation((1, -2, 0), ("x", "y", "z")) == "nu_x - 2 nu_y = 0"


# Webs

AXES = (np.linspace(0.5, 1.5, 41), np.linspace(-1.0, 1.0, 61))


def test_web_of_linear_frequencies_is_exact():
    """nu = (x, y, 1): the interpolant is exact, so every point of a line k satisfies k1 x + k2 y + k3 = 0 to
    rounding.
    """
    pytest.importorskip("contourpy")
    x, y = np.meshgrid(*AXES, indexing="ij")
    found = resonance_web(np.array([x, y, np.ones_like(x)]), axes=AXES, max_order=4, tolerance=1e-12)
    straight = {line.vector: line.lines[0] for line in ratio_web(x=(0.5, 1.5), y=(-1.0, 1.0), max_order=4)}
    assert len(found) > 10
    orders = [line.order for line in found]
    assert orders == sorted(orders)
    for line in found:
        if not line.lines:  # along the edge of the grid
            continue
        points = np.concatenate(line.lines)
        assert np.abs(points @ line.vector[:2] + line.vector[2]).max() < 1e-12
        # A contour reaches from edge to edge of the grid, as the exact segment does.
        exact = straight[line.vector]
        assert line.length == pytest.approx(np.linalg.norm(exact[1] - exact[0]), abs=1e-9)
    assert {line.vector for line in found if line.lines} <= set(straight)


def test_web_marks_islands_as_areas_and_keeps_clear_of_gaps():
    """A plateau nu1/nu2 = 3/2 (an island): locked, no line in it; no line in the part without frequencies."""
    pytest.importorskip("contourpy")
    x = np.repeat(AXES[0][:, None], AXES[1].size, axis=1)
    ratio = 1.5 + np.where(np.abs(x - 1) < 0.1, 0.0, x - 1)
    nu = np.array([ratio, np.ones_like(x)])
    nu[:, :, :10] = np.nan
    found = {line.vector: line for line in resonance_web(nu, axes=AXES, max_order=9)}
    island = found[(2, -3)]
    assert (island.locked == ((np.abs(x - 1) < 0.1) & np.isfinite(nu[0]))).all()
    assert not island.lines
    assert np.concatenate(found[(4, -5)].lines)[:, 0] == pytest.approx(1.25 - 0.5 + 0.0, abs=1e-9)
    assert np.concatenate(found[(4, -5)].lines)[:, 1].min() == AXES[1][10]
    torn = {line.vector: line for line in resonance_web(nu, axes=AXES, max_order=9, jump=0.04)}
    assert (7, -5) not in torn or not torn[(7, -5)].lines, "1.4 is jumped over at the edge of the island"


def test_web_has_no_line_around_a_single_cell():
    """Which one orbit makes; a line through it stays."""
    x = np.repeat(np.linspace(-1, 1, 20)[:, None], 20, axis=1)
    nu = np.array([1.0 + 0.2 * x, np.ones_like(x)])
    plain = resonance_web(nu, resonances=[[1, -1]])
    nu[0, 3, 7] = 1.4
    (line,), (before,) = (web[0].lines for web in (resonance_web(nu, resonances=[[1, -1]]), plain))
    np.testing.assert_array_equal(line, before)


def test_web_of_a_degenerate_map_has_each_line_once():
    """nu1 = nu2 everywhere: (1, 0, -1) and (0, 1, -1) are one line, named once, and (1, -1, 0) an area."""
    pytest.importorskip("contourpy")
    x, _ = np.meshgrid(*AXES, indexing="ij")
    found = resonance_web(np.array([x, x, np.ones_like(x)]), axes=AXES, max_order=3)
    assert (1, -1, 0) in [line.vector for line in found]
    assert sum(line.locked.all() for line in found) == 1
    places = [round(float(line.lines[0][0, 0]), 9) for line in found if line.lines]
    assert len(places) == len(set(places))
    assert 1.0 in places


def test_islands_without_a_line_are_marked_and_named(ax):
    """Two resonances that a few starts are locked in, and one that holds for too few to show, or for all."""
    from fastaff.plot import resonances as plot_resonance

    nu = np.array([np.linspace(1.41, 1.413, 144).reshape(12, 12), np.full((12, 12), 1.3)])
    nu[0, 2:5, 3:6], nu[0, 8, 2:6], nu[0, 10, 9] = 1.3, 1.95, 0.65
    lines = resonance_web(nu, max_order=5)
    kept = [line.vector for line in lines if not line.lines]
    assert kept == [(1, -1), (2, -3)]
    plot_resonance.plot_web(lines, ax=ax, names=("R", "phi"))
    said = [text.get_text() for text in ax.get_legend().get_texts()]
    assert said == [
        r"$\nu_{R}-\nu_{\varphi}=0$: 9 starts",
        r"$2\nu_{R}-3\nu_{\varphi}=0$: 4 starts",
    ]
    assert [len(mark.get_offsets()) for mark in ax.collections] == [9, 4]
    ax.clear()
    plot_resonance.plot_web(resonance_web(np.ones((2, 12, 12)), max_order=2), ax=ax)
    assert not ax.collections, "a resonance of all is no island"


def test_diffusion_histogram():
    values = np.array([-9.9, -6.1, -6.0, -5.75, -2.0, np.nan, -1.0])
    found = diffusion_histogram(values, threshold=-6.0, status=[0, 0, 0, 0, 0, 0, 1])
    assert found.missing == 2
    assert found.orbits == found.counts.sum() == 5
    assert found.fraction == 2 / 5
    assert found.error == pytest.approx(math.sqrt(0.4 * 0.6 / 5))
    assert np.diff(found.edges) == pytest.approx(0.25)
    assert (found.edges / 0.25 == np.rint(found.edges / 0.25)).all()
    assert (
        np.histogram(values[:5], bins=np.append(found.edges[:-1], found.edges[-1] + 1e-12))[0] == found.counts
    ).all()
    empty = diffusion_histogram([np.nan])
    assert (empty.fraction, empty.missing, empty.counts.tolist()) == (0.0, 1, [0])


def test_figures(ax):
    from fastaff.plot import resonances as plot_resonance

    x, y = np.meshgrid(*AXES, indexing="ij")
    nu = np.array([x + np.where(np.abs(x - 0.75) < 0.05, 0.75 - x, 0.0), y, np.ones_like(x)])
    ax.set(xlim=(0.5, 1.5), ylim=(-1, 1))
    lines = resonance_web(nu, axes=AXES, max_order=3)
    drawn = plot_resonance.plot_web(lines, ax=ax, names=("alpha", "beta", "gamma"), axes=AXES, labels=3)
    assert len(drawn.lines) == sum(len(line.lines) for line in lines)
    assert 1 <= len(drawn.labels) <= 3
    assert plot_resonance.formula((1, -2, 0), ("alpha", "beta", "phi")) == r"$\nu_{\alpha}-2\nu_{\beta}=0$"
    exact = ratio_web(x=(0.5, 1.5), y=(-1, 1), max_order=3)
    drawn = plot_resonance.plot_ratio_web(exact, ax=ax, names=("alpha", "beta", "gamma"), nu=nu, values=x, labels=4)
    assert len(drawn.lines) == len(exact)
    assert drawn.missing == 0
    assert ax.get_xlim() == (0.5, 1.5)
    bars = plot_resonance.plot_diffusion_histogram(diffusion_histogram([-8.0, -3.0, np.nan]), ax=ax)
    assert bars.missing == 1
    assert "50.0" in bars.labels[0].get_text()
    ax.figure.canvas.draw()


@pytest.fixture(scope="module")
def rotations():
    """A map of two rotations whose tunes change by the squares of the radii, its grid of radii, and its tunes."""
    rng = np.random.default_rng(31)
    a, b = rng.uniform([0.29, 0.27], [0.3, 0.28]), rng.uniform(0.1, 0.2, 2)
    text = "; ".join(
        f"{q}1 = {q}*cos(w{q}) + p{q}*sin(w{q}); p{q}1 = p{q}*cos(w{q}) - {q}*sin(w{q})" for q in ("x", "y")
    )
    turn = "; ".join(f"w{q} = 2*pi*(a{q} + b{q}*({q}**2 + p{q}**2))" for q in ("x", "y"))
    body = fastaff.iterated_map(
        f"{turn}; {text}", domain="1.3 - x**2 - y**2 + 1.6*x*y", ax=a[0], ay=a[1], bx=b[0], by=b[1]
    )
    grid = fastaff.energy_grid(body, axes={"x": np.linspace(0.05, 1.0, 24), "y": np.linspace(0.05, 1.0, 23)})
    return a, b, grid, body


@pytest.mark.parametrize("kind", ["map", "tunes"])
def test_a_web_of_a_map_has_the_turn(rotations, kind):
    """k1 nu_x + k2 nu_y = k3 where the radii of the rotations say so; what is lost has no tune and no line."""
    a, b, grid, body = rotations
    if kind == "map":
        found = fastaff.frequency_map(body, grid.z0, time=512)
    else:
        found = fastaff.tunes(fastaff.integrate(body, grid.z0, time=512, samples=512))
    lost, none = found.status != Status.OK, np.isnan(found.nu)
    assert 10 < none[0].sum() <= lost.sum() < lost.size / 2
    assert lost[none.any(axis=0)].all()  # others lived long enough
    np.testing.assert_array_equal(none, np.isinf(found.error))
    web = fastaff.resonance_web(found, axes=grid, max_order=6)
    assert {(3, 0, -1), (0, 3, -1), (1, 2, -1)} <= {line.vector for line in web if line.lines}
    for line in web:
        assert line.names == ("x", "y", "turn")
        for x, y in np.concatenate([np.zeros((0, 2)), *line.lines]):
            nu = a + b * [x**2, y**2]
            slope = np.abs(line.vector[:2] * b).sum() * 2.0
            assert abs(np.dot(line.vector, [*nu, 1.0])) < 0.003 * slope  # of straight pieces across cells of 0.04
    assert "3 Q_x = 1" in next(line for line in web if line.vector == (3, 0, -1)).summary()
    drawn = found.plot(grid, web=web)
    texts = [text.get_text() for text in (*drawn.labels, *drawn.points.axes.get_legend().get_texts())]
    assert any(r"3Q_{x}=1" in text for text in texts)


@given(st.integers(0, 2**32 - 1), st.integers(2, 4), st.floats(1e-3, 0.3))
def test_relations_that_no_frequencies_have_are_none(seed, n, size):
    """With errors so wide that relations contradict one another nothing is claimed; what is claimed is within its
    width, and the turn of a map is never 0.
    """
    rng = np.random.default_rng(seed)
    nu, errors = rng.random((n, 40)), size * rng.random((n, 40))
    nu[-1], errors[-1] = 1.0, 0.0
    found = resonances(nu, max_order=5, errors=errors)
    fine = found.status == Status.OK
    assert (found.status[~fine] == Status.NOT_CONVERGED).all()
    assert (found.rank < n).all()
    assert not found.basis[:, :, ~fine].any()
    assert not found.order[~fine].any()
    assert np.isnan(found.distance[:, ~fine]).all()
    kept = np.isfinite(found.distance)
    assert (kept.sum(axis=0) == found.rank).all()
    assert (found.distance[kept] <= found.width[kept] + 1e-14).all()
    for i in np.flatnonzero(~fine):  # whose relations have no frequencies within the errors
        truth = np.array(relations(nu[:, i], 1e-9 + errors[:, i], 5))
        k = truth[:, :-1] if len(truth) else truth
        assert np.linalg.matrix_rank(truth) > 1 or k.any()


def test_resonances_are_printed_by_name_with_their_shares():
    nu = np.array([[0.2, 0.2, 0.3, 0.1], [0.4, 0.4, 0.6137, np.nan], [0.3137, 0.3137, 0.9, 0.3]])
    found = fastaff.resonances(nu, max_order=4, names=("x", "y", "z"))
    rows = [line.split(maxsplit=2) for line in str(found).splitlines() if "%" in line]
    assert rows == [["2", "66.7%", "2 nu_x - nu_y = 0"], ["1", "33.3%", "3 nu_x - nu_z = 0"]]
    many = np.stack([np.ones(40), np.arange(1, 41) / np.arange(40, 0, -1)])
    last = str(fastaff.resonances(many, max_order=41)).splitlines()[-1].split()
    assert last[2:] == ["28", "others"]
    assert (last[0], last[1]) == ("28", "70.0%")


@pytest.mark.parametrize(
    ("body", "energy", "rows", "jump"),
    [
        (fastaff.HenonHeiles(), 0.09, ("nu", "error"), None),  # whose own lines are alike: of its largest family
        (shared_systems.plane(1, 2.3, f=0.5, g=4), 0.15, ("dominant", "dominant_error"), 0.03),
    ],
)
def test_a_web_of_a_map_over_its_grid_is_that_of_the_arrays(body, energy, rows, jump):
    axes = (np.linspace(0.05, 0.4, 14), np.linspace(-0.5, 0.5, 13))
    grid = fastaff.energy_grid(body, energy=energy, section="x=0", axes=axes)
    found = fastaff.frequency_map(body, grid.z0, time=200.0)
    known = found.regular | (
        (found.classification == fastaff.Classification.UNDECIDED) & (100 * 10**found.diffusion < 0.3)
    )
    assert known.sum() >= found.regular.sum() > 20
    if jump is None:
        basis = [matrix.tobytes() for matrix in found.basis.transpose(2, 0, 1)]
        counts = Counter(matrix for matrix, one in zip(basis, known, strict=True) if one)
        known = known & [matrix == counts.most_common(1)[0][0] for matrix in basis]
        assert len(counts) > 1
    assert grid.inaccessible.any()
    nu = np.full((2, *grid.inaccessible.shape), np.nan)
    nu.reshape(2, -1)[:, grid.cell_index] = np.where(known, getattr(found, rows[0]), np.nan)
    errors = np.zeros(nu.shape)
    errors.reshape(2, -1)[:, grid.cell_index] = np.where(known, np.maximum(getattr(found, rows[1]), 0.1 / 200), 0.0)
    one = fastaff.resonance_web(found, axes=grid, max_order=14)
    other = fastaff.resonance_web(nu, axes=axes, errors=errors, max_order=14, jump=jump)
    assert one
    assert any(line.lines for line in one)
    assert [line.vector for line in one] == [line.vector for line in other]
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.locked, b.locked)
        for x, y in zip(a.lines, b.lines, strict=True):
            np.testing.assert_array_equal(x, y)
        assert f"order {a.order}, length {a.length:.3g}, {a.locked.sum()} points locked" in a.summary()
    with pytest.raises(TypeError, match="nu must be a frequency map of the"):
        fastaff.resonance_web(grid, axes=grid)
    drawn = found.plot(grid, web=one)
    assert len(drawn.lines) == sum(len(line.lines) for line in one)
    with pytest.raises(TypeError, match="web must be drawn over its EnergyGrid"):
        found.plot(web=one)
    for other in (None, axes):
        with pytest.raises(TypeError, match=r"axes must be the EnergyGrid .*nu\.reshape\(-1, n1, n2\)"):
            fastaff.resonance_web(found, axes=other)
