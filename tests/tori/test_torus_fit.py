"""Tori fitted from one orbit: actions against quadrature and closed forms, nu = dE/dJ, classifications, and the integer
algebra below them.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import shared_systems
from hypothesis import given
from hypothesis import strategies as st
from naive import constants, frequencies, label, r_vartheta_actions

from fastaff import (
    KAHAN_LI8,
    LEAPFROG,
    AlphaTurning,
    Anharmonic,
    Body,
    Classification,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    NeoHookean,
    Status,
    energy_grid,
    fit_torus,
    frequency_map,
    integrate,
)
from fastaff.frequencies.integer_lattice import (
    box,
    determinant,
    first_basis,
    generators,
    inverse,
    primitive,
    quotient,
    reduced,
    relations,
)
from fastaff.systems.charts import from_matrix
from fastaff.tori import TorusFit, series

# x y z u, p_x p_y p_z p_u
POINTS = (
    ((1.3, 0.2, -0.1, 0.8), (0.3, -0.4, 0.5, 0.2)),
    ((1.0, 0.5, -0.3, 1.4), (-0.2, 0.6, 0.1, -0.5)),
    ((1.7, -0.2, 0.5, 0.8), (0.2, -0.9, -0.3, -0.4)),
)
REGULAR = np.array([0.1, -0.05, 0.12081, 0.1])  # a Henon-Heiles torus at E = 0.02


def point(i):
    phi, p = POINTS[i]
    return from_matrix(np.reshape(phi, (2, 2)), np.reshape(p, (2, 2)))


@cache
def fitted(body, i, time):
    return fit_torus(body, point(i), time=time)


SEPARABLE = [(Body(Hyperelastic()), 0), (Body(Hyperelastic(1.1), 0.8), 2), (Body(HeavyTop(1.0, 0.5)), 1)]


@pytest.mark.parametrize(("body", "i"), SEPARABLE, ids=lambda v: label(v) if isinstance(v, tuple) else str(v))
def test_separable_bodies_have_their_own_frequencies_and_actions(body, i):
    """In the default basis (r, vartheta, eta, gamma), with no knowledge of the separation but the signals r and
    vartheta.
    """
    f, z = fitted(body, i, 600.0), point(i)
    assert f.classification is Classification.REGULAR
    assert f.names == ("r", "vartheta", "eta", "gamma")
    truth = frequencies(body, z[:, None])[:, 0]
    np.testing.assert_allclose(f.nu, truth, rtol=0, atol=1e-11)
    assert (np.abs(f.nu - truth) <= f.nu_error + 1e-14).all()
    actions = r_vartheta_actions(body, z)
    np.testing.assert_allclose(f.J, actions, rtol=1e-9)
    assert (np.abs(f.J - actions) <= f.J_error + 1e-11 * np.abs(actions)).all()
    assert (f.J_error <= 1e-9 * np.abs(actions).max()).all()


def test_the_harmonic_body_is_periodic():
    """E = omega J/2 pi with J = 2 (J_alpha + J_beta) + |J_eta| + |J_gamma| (formulas.md section 4): a resonant
    torus of dimension 1.
    """
    body = Body(Harmonic(1.3), 0.7)
    f = fitted(body, 0, 150.0)
    omega = np.sqrt(1.3 / 0.7)
    assert (f.classification, f.dimension) == (Classification.RESONANT, 1)
    np.testing.assert_allclose(np.abs(f.nu), omega / (2 * np.pi), rtol=1e-12)
    np.testing.assert_allclose(np.abs(f.J), 2 * np.pi * f.energy / omega, rtol=1e-11)


@pytest.mark.parametrize("i", [0, 1])
def test_the_anharmonic_body_moves_on_two_tori(i):
    """nu_alpha = nu_beta = 2 |nu_gamma|; J_gamma of the 2-torus is 2 (J_alpha + J_beta) + |J_gamma|, from E(J) of EQa
    corrected.
    """
    body = Body(Anharmonic(0.9), 1.4)
    f, z = fitted(body, i, 300.0), point(i)
    omega, (E, p_eta, p_gamma) = np.sqrt(0.9 / 1.4), constants(body, z)
    assert (f.classification, f.dimension, f.names) == (Classification.RESONANT, 2, ("eta", "gamma"))
    assert [abs(c) for c in f.relations[0]] == [1, 0, 2]
    J_eta = 2 * np.pi * p_eta
    root = np.sqrt(16 * np.pi**2 * 1.4 * 0.9 + J_eta**2)
    total = 2 * np.pi * E / omega - root
    np.testing.assert_allclose(
        f.nu, omega / (2 * np.pi) * np.array([J_eta / root, np.sign(p_gamma)]), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(f.J, [J_eta, np.sign(p_gamma) * total], rtol=1e-10)


NEO = Body(NeoHookean(1.0, 2.0))


def test_neo_hookean_torus():
    """Two constants of motion come out as actions, the series is the orbit, and energy is constant on the torus."""
    z = point(0)
    f = fitted(NEO, 0, 1000.0)
    assert f.classification is Classification.REGULAR
    assert max(f.residual, f.prediction_error) < 1e-9
    np.testing.assert_allclose(f.I[2:], constants(NEO, z)[1:], rtol=1e-9)
    np.testing.assert_allclose(f.evaluate(f.theta0), z, rtol=0, atol=1e-10)
    later = integrate(NEO, z, time=2000.0, step=0.03).z[:, 0]
    np.testing.assert_allclose(f.evaluate(f.theta0 + f.nu * 2000.0), later, rtol=0, atol=1e-8)
    theta = np.random.default_rng(1).random((4, 3, 5))
    assert f.evaluate(theta).shape == (8, 3, 5)
    E, p_eta, p_gamma = constants(NEO, f.evaluate(theta))
    for value, expected in ((E, f.energy), (p_eta, f.I[2]), (p_gamma, f.I[3])):
        np.testing.assert_allclose(value, np.full((3, 5), expected), rtol=0, atol=1e-9)


def test_series_converges_with_its_order():
    f = fitted(NEO, 0, 1000.0)
    residuals = [f.truncated(order).residual for order in (4, 8, 12, 16)]
    assert all(b < a / 20 for a, b in pairwise(residuals))
    assert f.truncated(6).order == 6


def test_later_start_is_the_same_torus():
    """Same frequencies, actions and coefficients; the angles have moved on."""
    model, time = HenonHeiles(0.9), 37.3
    first = fit_torus(model, REGULAR, time=600.0)
    second = fit_torus(model, integrate(model, REGULAR, time=time, step=0.02).z, time=600.0)
    np.testing.assert_allclose(second.nu, first.nu, rtol=0, atol=2e-11)  # 2.7 cycles apart over the window
    np.testing.assert_allclose(second.J, first.J, rtol=1e-9)
    turned = second.theta0 - first.theta0 - first.nu * time
    np.testing.assert_allclose(turned - np.rint(turned), 0.0, atol=1e-8)
    theta = np.random.default_rng(2).random((2, 40))
    np.testing.assert_allclose(second.evaluate(theta), first.evaluate(theta), rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("model", "z", "direction", "time"),
    [
        (HenonHeiles(0.9), REGULAR, [0.3, 1.0, -0.5, 0.2], 800.0),
        pytest.param(NEO, point(0), [0.2, 0.1, 0.4, -0.3, 0.3, -0.1, 0.2, 0.5], 600.0, marks=pytest.mark.slow),
    ],
    ids=["Henon-Heiles", "neo-Hookean"],
)
def test_frequencies_are_the_slopes_of_the_energy(model, z, direction, time):
    """E(J + dJ/2) - E(J - dJ/2) = nu . dJ + O(dJ^3) between neighbouring tori, none of it separable."""
    step = 1e-3 * np.array(direction)
    low, middle, high = (fit_torus(model, z + s * step, time=time) for s in (-1.0, 0.0, 1.0))
    assert {low.classification, middle.classification, high.classification} == {Classification.REGULAR}
    assert low.names == middle.names == high.names
    change = (high.nu + low.nu) / 2 @ (high.J - low.J)  # the trapezoid: error of third order
    assert abs(high.energy - low.energy) > 1e-5
    third = np.abs((high.nu - 2 * middle.nu + low.nu) @ (high.J - low.J)) + 1e-12
    assert abs(high.energy - low.energy - change) <= 2 * third


@pytest.mark.slow
def test_island_chain():
    """Around a resonant periodic orbit the lattice has its frequency and the island's slow one, though all strong lines
    are multiples.
    """
    grid = energy_grid(
        NEO, energy=1.0, p_eta=0.3, p_gamma=0.2, section=AlphaTurning(+1), axes=(np.linspace(0.2, 0.8, 5), [0.0])
    )
    f = fit_torus(NEO, grid.z0[:, 1], time=1000.0)
    assert f.classification is Classification.REGULAR
    np.testing.assert_allclose(f.I[2:], [0.3, 0.2], rtol=1e-10)


def test_chaotic_orbits_are_no_tori():
    """The classical chaotic orbit of Henon & Heiles at E = 1/8, and a neo-Hookean body at E = 3."""
    henon = fit_torus(HenonHeiles(), [0.0, -0.25, 0.42081, 0.0], time=600.0)
    grid = energy_grid(NEO, energy=3.0, p_eta=0.3, p_gamma=0.2, section=AlphaTurning(+1), axes=([0.6], [0.0]))
    body = fit_torus(NEO, grid.z0, time=300.0)
    for f in (henon, body):
        assert f.classification is Classification.IRREGULAR
        assert f.evidence["diffusion"] > 1e-4
        assert f.evidence["megno"] > 5
        assert np.isinf(f.nu_error).all()
        assert f.prediction_error > 0.1
        assert np.isfinite(f.J).all()
        assert "not a torus" in f.summary()


@pytest.mark.parametrize("start", [(0.0, 0.1, 0.27, 0.05), (0.0, -0.12, 0.21, 0.13)])
def test_regular_orbits_are_never_called_no_tori(start):
    """Henon-Heiles at E = 0.04 in 14 and 50 periods: too little for the slow beat, which says so; longer ones find
    it.
    """
    classifications = [fit_torus(HenonHeiles(), start, time=time).classification for time in (90.0, 320.0)]
    assert Classification.IRREGULAR not in classifications


def test_frequencies_have_the_names_of_a_frequency_map():
    """Both coordinates of a tube of Hénon and Heiles have the same dominant line: the shares of the lines decide, which
    two programs find equal once in a while.
    """
    z0 = np.random.default_rng(5).normal(0, 0.13, (4, 12))[:, :8]
    mapped = frequency_map(HenonHeiles(), z0, time=2000.0)
    regular = np.flatnonzero(mapped.classification == Classification.REGULAR)
    tubes = np.ptp(mapped.dominant[:, regular], axis=0) < 1e-6
    fits = [fit_torus(HenonHeiles(), z0[:, i], time=2000.0) for i in regular]
    same = np.array([np.allclose(fit.nu, mapped.nu[:, i], atol=1e-5) for fit, i in zip(fits, regular, strict=True)])
    assert all(fit.names == mapped.names for fit in fits)
    assert tubes.sum() >= 4
    assert same[~tubes].all()
    assert same.sum() >= same.size - 1


@pytest.mark.parametrize("time", [1e-15, 1e-6, 0.3, 20.0])
def test_less_than_eight_periods_are_undecided_at_once(time):
    f = fit_torus(HenonHeiles(), REGULAR, time=time)
    assert f.classification is Classification.UNDECIDED
    assert np.isinf(f.nu_error).all()
    assert 20.0 < f.evidence["suggested time"] < 80.0
    assert "may decide" in f.summary()


def pair(a, k):
    """Two unit masses on springs a, coupled by k: frequencies sqrt(a), sqrt(a + 2 k), the coordinates are not the
    modes.
    """
    return shared_systems.plane(a + k, a + k, ab=-k)


RUNS = {"default": {}, "coarse": {"scheme": KAHAN_LI8, "step": 0.5}, "order 2": {"scheme": LEAPFROG, "step": 5e-4}}


@pytest.mark.parametrize("run", RUNS.values(), ids=RUNS)
def test_frequency_errors_cover_those_of_the_scheme(run):
    """Coupled oscillators with random springs against the closed form: coarse steps move both frequencies, and the
    errors say so.
    """
    rng = np.random.default_rng(9)
    for a, k in rng.uniform((0.6, 0.3), (1.4, 0.9), (3, 2)):
        f = fit_torus(pair(a, k), 0.5 * rng.standard_normal(4), time=rng.uniform(150.0, 250.0), **run)
        assert f.classification is Classification.REGULAR
        order = np.argsort(f.nu)
        truth = np.sqrt([a, a + 2 * k]) / (2 * np.pi)
        assert (np.abs(f.nu[order] - truth) <= f.nu_error[order] + 1e-15).all()
        assert (f.nu_error < 1e-6).all()


def test_failed_orbit():
    """Above E = 1/6 Henon-Heiles orbits escape: no exception, the status is the evidence."""
    f = fit_torus(HenonHeiles(), [0.0, 0.9, 0.3, 0.8], time=100.0)
    assert f.evidence["status"] in (Status.ESCAPED, Status.NONFINITE, Status.ENERGY_DRIFT)
    assert f.classification is (
        Classification.IRREGULAR if f.evidence["status"] == Status.ESCAPED else Classification.UNDECIDED
    )
    assert np.isnan(f.J).all()


def test_motions_of_few_dimensions():
    """A body at rest; one that breathes and spins with beta = 0 for ever."""
    rest = np.zeros(8)
    rest[0] = np.sqrt(2.0)
    still = fit_torus(NEO, rest, time=100.0)
    assert (still.classification, still.dimension, still.J.shape) == (Classification.RESONANT, 0, (0,))
    np.testing.assert_allclose(still.evaluate(np.zeros((0, 3))), np.tile(rest[:, None], 3), atol=1e-12)
    rest[5] = 0.3
    breathing = fit_torus(Body(Hyperelastic()), rest, time=300.0)
    assert (breathing.classification, breathing.names) == (Classification.RESONANT, ("r", "eta"))
    np.testing.assert_allclose(breathing.I[1], 0.3 * np.sqrt(2.0), rtol=1e-11)


def test_another_basis_is_the_same_torus():
    f = fit_torus(HenonHeiles(0.9), REGULAR, time=600.0)
    M = np.array([[2, 1], [1, 1]])
    g = f.in_basis(M)
    assert isinstance(g, TorusFit)
    assert g.names == ("2*x+y", "x+y")
    np.testing.assert_allclose(g.nu @ g.J, f.nu @ f.J, rtol=1e-12)
    theta = np.random.default_rng(4).random((2, 30))
    np.testing.assert_allclose(g.evaluate(M @ theta), f.evaluate(theta), rtol=0, atol=1e-12)
    np.testing.assert_allclose(g.evaluate(g.theta0), f.evaluate(f.theta0), rtol=0, atol=1e-12)
    np.testing.assert_allclose(g.truncated(g.order).J, g.J, rtol=1e-12)
    assert g.in_basis(inverse(M)).names == ("x", "y") or np.allclose(g.in_basis(inverse(M)).nu, f.nu)


@pytest.mark.parametrize(
    ("kwargs", "error", "name"),
    [
        ({"time": -1.0}, ValueError, "time"),
        ({"time": 100.0, "tolerance": 0.0}, ValueError, "tolerance"),
        ({"time": 100.0, "z0": np.zeros((4, 2))}, ValueError, "z0"),
        ({"time": 100.0, "z0": [0.0, np.nan, 0.0, 0.0]}, ValueError, "z0"),
        ({"time": 100.0, "scheme": "RK5"}, ValueError, "scheme.*Did you mean RK4"),
        ({"time": 100.0, "model": Harmonic()}, TypeError, "model"),
    ],
)
def test_wrong_input_raises_at_once(kwargs, error, name):
    with pytest.raises(error, match=name):
        fit_torus(kwargs.pop("model", HenonHeiles()), kwargs.pop("z0", REGULAR), **kwargs)


def test_wrong_arguments_of_a_fit_raise():
    f = fitted(Body(Harmonic(1.3), 0.7), 0, 150.0)
    for M in ([[2]], [[0.5]], [1], np.eye(2)):
        with pytest.raises(ValueError, match="M must"):
            f.in_basis(M)
    with pytest.raises(ValueError, match="theta"):
        f.evaluate(np.zeros((2, 5)))
    with pytest.raises(ValueError, match="order"):
        f.truncated(-1)


matrices = st.lists(st.lists(st.integers(-5, 5), min_size=3, max_size=3), min_size=2, max_size=2).map(np.array)


@given(matrices)
def test_echelon_form(M):
    H, V = reduced(M)
    np.testing.assert_array_equal(M @ V, H)
    assert abs(determinant(V)) == 1
    np.testing.assert_array_equal(V @ inverse(V), np.eye(3, dtype=int))
    assert (H[0, 1:] == 0).all()
    assert (H[1, 2:] == 0).all()


def test_primitive_sets_and_bases():
    assert primitive(np.array([[2, 3]]))
    assert not primitive(np.array([[2, 4]]))
    assert not primitive(np.array([[1, 1], [1, -1]]))
    assert first_basis(np.array([[2, 0], [1, 1], [1, 2], [0, 1]])) == [1, 2]
    assert len(box((1, 2))) == 15


@given(st.integers(0, 10**6))
def test_generators_of_random_lines(seed):
    """Lines k . nu of two incommensurate frequencies whose k generate the integers: all found, with another basis at
    most.
    """
    rng = np.random.default_rng(seed)
    nu = np.array([1.0, np.sqrt(2.0) - 0.7]) * (1 + 0.1 * rng.random())
    k = rng.integers(-2, 3, (12, 2))
    k = np.vstack([k[k.any(axis=1)], [[1, 0], [0, 1]]])
    found = generators(k @ nu, np.full(len(k), 1e-13), 2)
    assert found.known.all()
    np.testing.assert_allclose(found.k @ found.nu, k @ nu, rtol=0, atol=1e-11)
    T = np.linalg.lstsq(found.k.astype(float), k.astype(float), rcond=None)[0]
    assert abs(round(float(np.linalg.det(T)))) == 1


def test_relations_and_their_quotient():
    """nu = (2, 1, -1, sqrt 2): two relations, two independent frequencies."""
    nu = np.array([2.0, 1.0, -1.0, np.sqrt(2.0)])
    found = relations(nu, np.full(4, 1e-12), 4)
    assert len(found) == 2
    np.testing.assert_allclose(found @ nu, 0.0, atol=1e-12)
    R, C = quotient(found, 4)
    np.testing.assert_array_equal(C @ R, np.eye(2, dtype=int))
    np.testing.assert_allclose(R @ (C @ nu), nu, rtol=0, atol=1e-14)


@pytest.mark.parametrize("count", [37, 500, 1001])
def test_transforms_of_signals_are_their_sums(count):
    """At random frequencies, above that of the samples too, in 80-bit arithmetic."""
    random = np.random.default_rng(count)
    t = (np.arange(count) - (count - 1) / 2) * random.uniform(0.1, 10.0)
    signals = random.standard_normal((3, count)) + 1j * random.standard_normal((3, count))
    nu = random.uniform(-2.0, 2.0, 50) / (t[1] - t[0])
    phases = -2 * np.longdouble(np.pi) * np.outer(t.astype(np.longdouble), nu.astype(np.longdouble))
    phases += -2 * np.longdouble(1.2246467991473532e-16) * np.outer(t, nu)
    truth = signals @ (np.cos(phases) + 1j * np.sin(phases)).astype(np.clongdouble)
    wrong = np.abs(series.transform(t, signals, nu) - truth).max(axis=1) / np.abs(signals).sum(axis=1)
    assert wrong.max() < 5e-15 + 4e-16 * count  # the latter by the rounding of the frequencies


@pytest.mark.parametrize("degrees", [0, 1, 2, 3])
def test_series_have_the_values_of_their_sums(degrees):
    random = np.random.default_rng(degrees)
    k = np.unique(random.integers(-6, 9, (1 if degrees == 0 else 40, degrees)), axis=0)
    z = random.standard_normal((4, len(k))) + 1j * random.standard_normal((4, len(k)))
    theta = random.uniform(-3.0, 3.0, (degrees, 100))
    np.testing.assert_allclose(
        series.evaluate(k, z, theta), (z @ np.exp(2j * np.pi * (k @ theta))).real, rtol=0, atol=1e-12
    )
