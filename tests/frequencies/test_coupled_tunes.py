"""Tunes of coupled planes of maps: next to resonances, at resonances, in any unit and at any angle between planes."""

import sys
from pathlib import Path

import numpy as np
import pytest

import fastaff as fa
from fastaff import Classification
from fastaff.engine.jit import JIT_DISABLED

sys.path.append(str(Path(__file__).parents[2] / "bench"))
from coupled_maps import CALLS, CELLS, from_whole, map_results

SEEN = 0.3
"""Largest part of the orbits next to a resonance that are UNDECIDED, but next to nu_1 = nu_2."""


def held(results):
    """Assert that results are true where they are decided; return the kinds of all orbits."""
    kind, ratio, wrong = (
        np.concatenate([getattr(j, name) for j in results]) for name in ("classification", "ratio", "wrong")
    )
    own = kind == Classification.REGULAR
    assert (ratio[own] <= 1).mean() >= 0.99
    assert (ratio[own] <= 10).all()
    assert wrong.mean() <= 0.01
    assert not (wrong & ~own).any()
    return kind


@pytest.mark.parametrize("turns", [200, pytest.param(1000, marks=pytest.mark.slow), 3000])
def test_tunes_of_coupled_maps_next_to_resonances(turns):
    results = map_results(47, 2 if JIT_DISABLED else 20, turns=(turns,))
    for call in CALLS:
        for cell in CELLS:
            kind = held([j for j in results if (j.call, j.case.cell) == (call, cell)])
            if cell != "1:1" and turns > 500 and not JIT_DISABLED:
                assert (kind == Classification.REGULAR).mean() > 1 - SEEN


def seen_at(angle, w, rng):
    """Return samples (4, orbits, turns) of loops w (2, orbits, turns) in coordinates turned by angles (orbits,), in
    units of their own.
    """
    c, s, unit = np.cos(angle)[:, None], np.sin(angle)[:, None], 10.0 ** rng.uniform(-3, 3, (2, 1, 1))
    q, p = w.real, -w.imag
    q, p = (np.array([c * a[0] - s * a[1], s * a[0] + c * a[1]]) for a in (q, p))
    return np.concatenate([unit * q, p / unit])


def loops(rng, nu, size, turns, bend=0.0):
    """Return loops (2, orbits, turns) of tunes nu and sizes (2, orbits), with harmonics where they are bent."""
    t = nu[:, :, None] * np.arange(turns) + rng.uniform(size=(*nu.shape, 1))
    w = np.exp(2j * np.pi * (t - np.rint(t)))
    q, p = w.real, -w.imag
    p = p + bend * rng.uniform(-1, 1, (*nu.shape, 1)) * q * q
    q = q + bend * rng.uniform(-1, 1, (*nu.shape, 1)) * p * p / 2
    return size[:, :, None] * (q - 1j * p)


@pytest.mark.parametrize(("q", "p"), [(1, 1), (3, 2), (2, 1), (3, 1)])
@pytest.mark.parametrize("turns", [300, 2000])
def test_tunes_of_bent_loops_next_to_resonances(q, p, turns):
    """Their harmonics are next to the other mode's line: what is not told apart is no tune."""
    rng = np.random.default_rng([47, q, p, turns])
    count = 8 if JIT_DISABLED else 120
    nu = rng.uniform(0.05, 0.95, (2, 4 * count))
    near = rng.choice([-1, 1], nu.shape[1]) * 10 ** rng.uniform(-4, 1, nu.shape[1]) / turns
    nu[1] = rng.choice([-1, 1], nu.shape[1]) * (q * nu[0] - near + rng.integers(0, p, nu.shape[1])) / p % 1
    nu = nu[:, (from_whole(2 * nu) > 0.02 + 6 / turns).all(axis=0)][:, :count]
    size = 10 ** rng.uniform(-1.5, 1.5, (2, nu.shape[1]))
    found = fa.tunes(seen_at(rng.uniform(0, np.pi, nu.shape[1]), loops(rng, nu, size, turns, 0.3), rng))
    own = found.classification == Classification.REGULAR
    assert not (found.classification == Classification.RESONANT).any()
    assert not (found.classification == Classification.IRREGULAR).any()
    k = np.array([(i, j) for i in range(-4, 5) for j in range(-4, 5)])
    ratio = (from_whole(found.nu[:, None] - k @ nu) / (found.error + 3e-15)[:, None]).min(axis=1).max(axis=0)
    assert (ratio[own] <= 1).mean() >= 0.98
    assert (ratio[own] <= 10).all()
    apart = np.abs(found.nu[0] - found.nu[1])[own] * turns
    assert (np.minimum(apart, turns - apart) > 1.0).all()


@pytest.mark.parametrize(("q", "p"), [(3, 2), (2, 1), (3, 1)])
def test_two_modes_at_a_resonance_have_both_tunes_and_the_relation(q, p):
    """One plane's line twice is no resonance: both planes show the stronger mode."""
    rng = np.random.default_rng([48, q, p])
    turns, part = 2000, rng.uniform(0.03, 0.45 / q, 12)
    nu, size = np.array([p * part, q * part]), np.array([np.ones(12), 10 ** rng.uniform(-3, 0, 12)])
    found = fa.tunes(seen_at(rng.uniform(0.2, 1.3, 12), loops(rng, nu, size, turns), rng))
    assert (found.classification == Classification.RESONANT).all()
    np.testing.assert_allclose(np.sort(found.nu, axis=0), nu, atol=1e-11)
    related = fa.resonances(found, max_order=6)
    assert (np.sort(np.abs(related.basis[0, :2]), axis=0) == [[p], [q]]).all()


def test_labels_of_modes_do_not_depend_on_their_amplitudes():
    """Each plane has the mode whose direction is nearer, up to 45 degrees."""
    rng = np.random.default_rng(49)
    for degrees in (20, 38, 43, 47, 52, 70):
        for nu in ([0.22, 0.31], [0.31, 0.22], [0.81, 0.3]):
            size = 10.0 ** rng.uniform(-3, 3, (2, 20))
            w = loops(rng, np.repeat(np.array(nu)[:, None], 20, axis=1), size, 1000)
            found = fa.tunes(seen_at(np.full(20, np.deg2rad(degrees)), w, rng))
            known = nu if degrees < 45 else nu[::-1]
            np.testing.assert_allclose(found.nu, np.repeat(np.array(known)[:, None], 20, axis=1), atol=1e-9)


def test_a_rank_of_n_is_never_dependent():
    """Of islands and librations of maps, of both kinds of coordinates."""
    rng = np.random.default_rng(50)
    count = 12 if JIT_DISABLED else 120
    standard, two = fa.models.maps.StandardMap(rng.uniform(0.4, 0.9)), fa.models.maps.FroeschleMap(0.5, 0.3, 0.02)
    for model, n in ((standard, 1), (two, 2), (fa.models.OneTurnMap(0.3, 0.597, 0.0, 2.0), 2)):
        z0 = (
            rng.uniform(-0.3, 0.3, (2 * n, count))
            if model.coordinates == ("x", "y")
            else rng.uniform(-3, 3, (2 * n, count))
        )
        found = fa.frequency_map(model, z0, time=2000)
        assert (found.rank[found.classification == Classification.RESONANT] < n).all()
        assert (found.rank[found.classification == Classification.REGULAR] == n).all()
        assert (np.linalg.matrix_rank(found.basis.transpose(2, 0, 1)) == found.rank).all()
    island = fa.frequency_map(standard, [np.pi, 0.05], time=2000)
    assert (island.classification[0], island.rank[0]) == (Classification.RESONANT, 0)


def test_tunes_of_signals_of_any_size():
    """Powers of two of both rows change no bit; planes of other sizes beside them neither."""
    rng = np.random.default_rng(51)
    w = loops(rng, np.array([[0.28], [0.1234]]), np.ones((2, 1)), 500, 0.2)
    z = np.concatenate([w.real, -w.imag])
    usual = fa.tunes(z)
    for power in (-1000, -700, -500, -300, -260, 260, 300, 500, 700, 1000):
        for rows in ([0, 2], [0], [3], [0, 1, 2, 3], [0, 2, 3]):
            size = np.ones((4, 1, 1))
            size[rows] = 2.0**power
            found = fa.tunes(z * size)
            if power % 100 == 0 and abs(power) < 1000:
                np.testing.assert_array_equal(found.nu, usual.nu)
                np.testing.assert_array_equal(found.error, usual.error)
            np.testing.assert_allclose(found.nu, usual.nu, rtol=1e-11)
            assert (found.classification == Classification.REGULAR).all()
    turn = fa.iterated_map("x1 = c*x + s*p; p1 = c*p - s*x", c=np.cos(1.7), s=np.sin(1.7))
    starts = np.array([10.0 ** np.array([-150, -90, -1, 0, 90, 150]), np.zeros(6)])
    found = fa.frequency_map(turn, starts, time=300)
    assert (from_whole(found.nu - 1.7 / (2 * np.pi)) <= found.error).all()
    still = fa.tunes(np.ones((2, 100)))
    assert still.summary().endswith("1 without a tune")
    assert still.classification[0] == Classification.UNDECIDED
