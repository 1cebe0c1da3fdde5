"""Spectra of whole bodies and level diagrams: against closed forms, brute force over classes, and the order of
levels.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fastaff import (
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    Interrupted,
    NeoHookean,
    SeparableAlphaBeta,
)
from fastaff.quantum import (
    LevelTable,
    NoGroundState,
    all_levels,
    class_diagram,
    exact_levels,
    level_diagram,
    level_list,
    spectrum,
    spectrum_table,
)
from fastaff.systems.models import Oscillator


class Unseparated(NamedTuple):
    """The harmonic potential without a word on the charts it separates in."""

    C: float = 1.0

    def value(self, A, B):
        return Harmonic(self.C).value(A, B)

    def slopes(self, A, B):
        return Harmonic(self.C).slopes(A, B)

    def margin(self, A, B):
        return Harmonic(self.C).margin(A, B)


@pytest.mark.parametrize("chart", ["alpha-beta", "r-vartheta"])
def test_harmonic_degeneracies(chart):
    """E = hbar omega (N + 2), C(N + 3, 3) times: the oscillator in four dimensions."""
    found = all_levels(Body(Harmonic(2.0), 0.5), multiplets=7, hbar=0.3, chart=chart)
    N = np.arange(7)
    gathered = found.multiplets()
    np.testing.assert_allclose(gathered.E, 0.3 * 2.0 * (N + 2), rtol=1e-13)
    assert gathered.degeneracy.tolist() == [math.comb(n + 3, 3) for n in N]
    assert found.converged.all()
    assert gathered.first[-1] == len(found) == found.E.size == math.comb(10, 4)
    assert found.names == tuple(chart.split("-"))


@settings(max_examples=8, deadline=None)
@given(
    C=st.floats(0.1, 5),
    mu=st.floats(0.2, 4),
    hbar=st.floats(0.3, 2),
    single_valued=st.booleans(),
    quanta=st.floats(3, 7),
    wall=st.booleans(),
)
def test_whole_bodies_are_complete(C, mu, hbar, single_valued, quanta, wall):
    """The exact list of EQ5.1 and EQ5.2, on GL(2,R) and on its covering."""
    body = Body(Anharmonic(C) if wall else Harmonic(C), mu)
    top = hbar * math.sqrt(C / mu) * (quanta + (2 * math.sqrt(C * mu) / hbar if wall else 0))
    truth = exact_levels(body, max_energy=top, hbar=hbar, single_valued=single_valued)
    found = all_levels(body, max_energy=top, hbar=hbar, single_valued=single_valued)
    if np.abs(truth.E - top).min(initial=1.0) > 1e-9:
        np.testing.assert_allclose(found.E, truth.E, rtol=1e-12)
        assert sorted(zip(found.m, found.l, *found.n)) == sorted(zip(truth.m, truth.l, *truth.n))
        assert found.multiplets().degeneracy.tolist() == truth.multiplets().degeneracy.tolist()
        assert found.complete_below == top


def test_elementary_states_of_the_hyperelastic_body():
    """2 mu C/hbar^2 = 2 = |m - l| - |m + l|: E = 2 n_r + 4 + a + b with a = b + 1, so E = 5 + 2 k comes 2 + 4 k times,
    others 4 at most.
    """
    found = all_levels(Body(Hyperelastic(1.0)), max_energy=12.0).multiplets()
    special = np.isclose(found.E % 2, 1.0, atol=1e-12)
    np.testing.assert_allclose(found.E[special], [5, 7, 9, 11], rtol=1e-14)
    assert found.degeneracy[special].tolist() == [2, 6, 10, 14]
    assert set(found.degeneracy[~special]) == {1, 2, 4}
    for k in np.flatnonzero(special):
        inside = found.members(k)
        assert (np.abs(inside.m - inside.l) - np.abs(inside.m + inside.l)).tolist() == [2] * found.degeneracy[k]
        assert (inside.n[1] == 0).all()


@pytest.mark.slow
def test_no_class_is_missed():
    """Against all classes with |m|, |l| <= 12; those at the edge of that square start above 11."""
    body = Body(Hyperelastic(1.0))
    pairs = [(m, l) for m in range(-12, 13) for l in range(-12, 13) if (m + l) % 2 == 0]
    table = spectrum_table(body, m=[p[0] for p in pairs], l=[p[1] for p in pairs], count=30)
    assert min(row.E[0] for row in table if max(abs(row.m[0]), abs(row.l[0])) == 12) > 11
    all_of_them = sorted((E, row.m[0], row.l[0]) for row in table for E in row.E if E < 10.9)
    found = all_levels(body, max_energy=10.9)
    assert found.E.size == len(all_of_them)
    np.testing.assert_allclose(found.E, [E for E, _, _ in all_of_them], rtol=1e-12)
    assert sorted(zip(found.m, found.l)) == sorted((m, l) for _, m, l in all_of_them)
    few = all_levels(body, multiplets=9)
    np.testing.assert_allclose(few.E, found.E[: few.E.size], rtol=1e-12)
    assert len(few.multiplets()) == 9


def test_bodies_that_do_not_separate():
    shares = []
    found = all_levels(Body(Unseparated()), multiplets=3, tolerance=1e-6, callback=shares.append)
    np.testing.assert_allclose(found.multiplets().E, [2, 3, 4], rtol=1e-7)
    assert found.multiplets().degeneracy.tolist() == [1, 4, 10]
    assert found.names == ("level",)
    assert np.all(np.diff(shares) >= 0)
    assert 0 <= shares[0] < shares[-1] == 1


def test_an_interrupted_list_is_complete_as_far_as_it_says():
    calls = []

    def stop(share):
        calls.append(share)
        if len(calls) == 4:
            raise KeyboardInterrupt

    body = Body(Harmonic())
    with pytest.raises(Interrupted) as stopped:
        all_levels(body, max_energy=9.5, callback=stop)
    partial = stopped.value.partial
    truth = exact_levels(body, max_energy=partial.complete_below).multiplets()
    assert 2 < partial.complete_below < 9.5
    assert partial.multiplets().degeneracy.tolist() == truth.degeneracy.tolist()
    assert len(truth.degeneracy) > 1


def made(E, error, m=0, l=0):
    E, error = np.array(E, float), np.array(error, float)
    whole = np.ones(E.size, int)
    n = np.arange(E.size)[None]
    return LevelTable(E, error, 0 * whole, n, ("level",), m * whole, l * whole, np.zeros((0, E.size)), (), 1.0, "made")


def test_levels_within_their_errors_are_one_multiplet():
    merged = level_list([made([1.0, 2.0, 3.0], [0, 0.04, 0]), made([1.0, 2.05, 2.5], [0, 0.02, 0.1], 2, 0)])
    assert merged.E.tolist() == [1.0, 1.0, 2.0, 2.05, 2.5, 3.0]
    assert merged.multiplets().degeneracy.tolist() == [2, 2, 1, 1]
    assert merged.m.tolist() == [0, 2, 0, 2, 2, 0]
    assert merged.n[0].tolist() == [0, 0, 1, 1, 2, 2]
    assert merged.complete_below == -math.inf
    with pytest.raises(ValueError, match="classes must be"):
        level_list([])


@pytest.mark.parametrize(
    ("body", "changes", "error", "words"),
    [
        (Body(Harmonic()), {}, ValueError, "either max_energy or multiplets"),
        (Body(Harmonic()), {"max_energy": 3.0, "multiplets": 2}, ValueError, "either max_energy or multiplets"),
        (Body(Harmonic()), {"multiplets": 0}, ValueError, "multiplets"),
        (Body(Harmonic()), {"max_energy": math.inf}, ValueError, "max_energy must be finite"),
        (Body(Harmonic()), {"multiplets": 2, "hbar": 0.0}, ValueError, "hbar"),
        (Body(Harmonic()), {"multiplets": 2, "chart": "spherical"}, ValueError, "chart must separate"),
        (Body(NeoHookean()), {"multiplets": 2, "chart": "alpha-beta"}, ValueError, "model must be separable"),
        (HenonHeiles(), {"multiplets": 2}, TypeError, "Body"),
        (Body(HeavyTop(A=-3.0)), {"multiplets": 2}, NoGroundState, "no lower bound"),
    ],
)
def test_wrong_input_of_lists(body, changes, error, words):
    with pytest.raises(error, match=words):
        all_levels(body, **changes)


def test_nothing_below_the_ground_state():
    assert all_levels(Body(Harmonic()), max_energy=1.9).E.size == 0


# Level diagrams


def test_curves_follow_quantum_numbers_through_crossings():
    """E = sqrt(k) (2 n_alpha + 1 + a) + 2 n_beta + 1 + b of two oscillators crosses itself as k grows."""
    k = np.linspace(0.3, 3.0, 40)
    found = level_diagram(
        lambda value: Body(SeparableAlphaBeta(Oscillator(value), Oscillator(1.0))), k, m=3, l=1, count=15, name="k"
    )
    assert found.names == ("alpha", "beta")
    curves = {curve.label: curve.E for curve in found.curves()}
    for (first, second), E in curves.items():
        closed = np.sqrt(k) * (2 * first + 2) + 2 * second + 3
        np.testing.assert_allclose(E[np.isfinite(E)], closed[np.isfinite(E)], rtol=1e-13)
        assert np.isfinite(E[closed < found.E[:, 0, -1] - 1e-9]).all(), "no gap below the highest level computed"
    rise = curves[1, 0] - curves[0, 1]
    assert rise[0] < 0 < rise[-1], "they cross, at k = 1"
    assert np.all(np.diff(found.E, axis=2) >= -1e-12)
    assert found.top == found.E[..., -1].min()


def test_classes_and_values_are_kept_apart():
    shares = []
    found = level_diagram(
        lambda C: Body(Hyperelastic(C)),
        [0.5, 2.0],
        m=[0, 1, 2],
        l=[0, -1, 0],
        count=4,
        hbar=0.8,
        name="C",
        callback=shares.append,
    )
    assert shares == [0.5, 1.0]
    for i, C in enumerate(found.values):
        for j in range(3):
            one = spectrum(Body(Hyperelastic(C)), m=found.m[i, j], l=found.l[i, j], count=4, hbar=0.8)
            np.testing.assert_allclose(found.E[i, j], one.E, rtol=1e-13)
            np.testing.assert_array_equal(found.n[:, i, j], one.n)


def test_diagrams_against_spin_and_vorticity():
    body = Body(Hyperelastic())
    spin = class_diagram(body, m=range(-4, 5, 2), l=0, count=5)
    vorticity = class_diagram(body, m=0, l=[-4, -2, 0, 2, 4], count=5)
    assert (spin.name, vorticity.name) == ("m", "l")
    np.testing.assert_array_equal(spin.values, [-4, -2, 0, 2, 4])
    np.testing.assert_allclose(spin.E, vorticity.E, rtol=1e-13)  # |m - l| and |m + l| count
    np.testing.assert_allclose(spin.E, spin.E[::-1], rtol=1e-13)


def test_levels_of_bodies_that_do_not_separate_keep_their_order():
    found = level_diagram(lambda K: Body(NeoHookean(K=K)), [1.0, 2.0], m=0, l=0, count=3, tolerance=1e-4)
    curves = found.curves()
    assert [curve.label for curve in curves] == [(0,), (1,), (2,)]
    assert all(np.isfinite(curve.E).all() for curve in curves)
    assert np.all(found.E[1] > found.E[0]), "V grows with K"


def test_an_interrupted_diagram_keeps_its_rows():
    def make(C):
        if C > 2:
            raise KeyboardInterrupt
        return Body(Hyperelastic(C))

    with pytest.raises(Interrupted) as stopped:
        level_diagram(make, [1.0, 2.0, 3.0], m=0, l=0, count=3)
    E = stopped.value.partial.E
    assert np.isfinite(E[:2]).all()
    assert np.isnan(E[2]).all()


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"values": []}, ValueError, "values"),
        ({"values": [np.nan]}, ValueError, "values"),
        ({"count": 0}, ValueError, "count"),
        ({"m": 1}, ValueError, "even"),
        ({"m": [0.5], "l": [0]}, ValueError, "whole"),
        ({"make": lambda C: Body(Hyperelastic()) if C < 1.5 else Body(Harmonic())}, ValueError, "make must give"),
    ],
)
def test_wrong_input_of_diagrams(changes, error, words):
    given_ = {"make": lambda C: Body(Hyperelastic(C)), "values": [1.0, 2.0], "m": 0, "l": 0, "count": 2} | changes
    with pytest.raises(error, match=words):
        level_diagram(given_.pop("make"), given_.pop("values"), **given_)


def test_diagrams_against_spin_need_one_sequence():
    for m, l in ((0, 0), ([0, 2], [0, 2])):
        with pytest.raises(ValueError, match="m or l must be a sequence and the other a whole number"):
            class_diagram(Body(Harmonic()), m=m, l=l, count=2)
    with pytest.raises(ValueError, match="non-empty"):
        class_diagram(Body(Harmonic()), m=[], l=0, count=2)


def test_a_shortened_list_knows_where_it_ends():
    whole = all_levels(Body(Harmonic()), multiplets=4)  # energies 2, 3, 4, 5 with 1, 4, 10, 20 levels
    cut = whole.upto(5)
    assert cut.multiplets().degeneracy.tolist() == [1, 4]
    assert cut.complete_below == pytest.approx(4.0, rel=1e-14)
    for more in (whole.E.size, 10**6):
        same = whole.upto(more)
        assert same.multiplets().degeneracy.tolist() == [1, 4, 10, 20]
        assert same.complete_below == whole.complete_below
    with pytest.raises(ValueError, match="count must be at least 0"):
        whole.upto(-1)


def test_lists_of_what_does_not_belong_together_are_refused():
    body = Body(Harmonic())
    with pytest.raises(ValueError, match="quantum numbers"):
        level_list([spectrum(body, m=0, l=0, count=1, chart=chart) for chart in ("alpha-beta", "r-vartheta")])
    with pytest.raises(TypeError, match="classes must be a list of LevelTable, got"):
        level_list([1])


@pytest.mark.parametrize(("m", "l"), [([], 0), ([0, 1], [0, 1, 2]), ([[0]], 0)])
def test_diagrams_name_classes_that_are_none(m, l):
    with pytest.raises(ValueError, match="m and l must be"):
        level_diagram(lambda C: Body(Harmonic(C=C)), [1.0], m=m, l=l, count=1, single_valued=False)
