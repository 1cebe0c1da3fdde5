"""Periodic orbits: exact orbits of Henon-Heiles, Hill's equation, symplectic structure, resonant tori, relative
periodic orbits.
"""

import importlib
import sys
from functools import cache, partial

import naive
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from own_models import HenonHeilesInUnits
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize
from scipy.special import ellipk

import fastaff as fa
from fastaff import Status
from fastaff.periodic import Event, Stability
from fastaff.periodic.return_map import section_gradient
from fastaff.plot.periodic import plot_periodic

X = fa.Hyperplane(normal=(1, 0, 0, 0))
OMEGA = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])
BODY = fa.Body(fa.NeoHookean(G=1.0, K=2.0), mu=1.0)
RADIAL = fa.Hyperplane(normal=(0, 0, 1, 0))


def straight(E):
    """The straight-line orbit of Henon-Heiles along the ray at 30 degrees, where it crosses x = 0."""
    return np.array([0, 0, *(np.sqrt(2 * E) * np.array([np.sqrt(3) / 2, 0.5]))])


def turning_points(E):
    """The roots of 2E - q^2 + 2 q^3/3: the motion on a straight line (towards a saddle) is that of a cubic
    potential.
    """
    return np.sort(np.roots([2 / 3, -1, 0, 2 * E]).real)


def straight_period(E):
    """4 sqrt(3/2)/sqrt(q3 - q1) K(m), m = (q2 - q1)/(q3 - q1), of q'^2 = 2/3 (q - q1)(q2 - q)(q3 - q)."""
    q1, q2, q3 = turning_points(E)
    return 2 * np.sqrt(3 / 2) * 2 / np.sqrt(q3 - q1) * ellipk((q2 - q1) / (q3 - q1))


def hill_trace(E):
    """Trace of the transverse monodromy of the straight line by Hill's equation xi'' = -(1 + 2 q(t)) xi."""

    def slope(t, y):
        q, p, a, va, b, vb = y
        k = 1 + 2 * q
        return p, -q + q * q, va, -k * a, vb, -k * b

    start = [0, np.sqrt(2 * E), 1, 0, 0, 1]
    end = solve_ivp(slope, (0, straight_period(E)), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return end[2] + end[5]


@cache
def all_periodic(period):
    E = 1 / 12
    axes = np.linspace(-0.4, 0.6, 24), np.linspace(-0.4, 0.4, 24)
    grid = fa.energy_grid(fa.HenonHeiles(), energy=E, section=X, axes=axes)
    return fa.find_periodic_orbits(fa.HenonHeiles(), grid.z0, section=X, max_crossings=period, energy=E)


@cache
def radial_orbits():
    model = fa.reduced_body(BODY, p_eta=0.3, p_gamma=0.2)
    grid = fa.energy_grid(
        BODY,
        energy=1.5,
        p_eta=0.3,
        p_gamma=0.2,
        section=fa.AlphaTurning(),
        axes=(np.linspace(0.1, 1.2, 16), np.linspace(-1.4, 1.4, 16)),
    )
    return model, fa.find_periodic_orbits(
        model, model.from_planes(grid.z0), section=RADIAL, max_crossings=3, energy=1.5
    )


@pytest.mark.parametrize("E", [0.004, 0.02, 1 / 12, 0.12, 0.15, 0.163])
def test_straight_orbits_have_their_period_and_hills_trace(E):
    noise = 0.02 * np.sqrt(E) * np.random.default_rng(3).standard_normal(4)
    orbit = fa.periodic_orbits(fa.HenonHeiles(), straight(E) + noise, section=X, energy=E)
    orbit.raise_if_failed()
    np.testing.assert_allclose(orbit.z[:, 0], straight(E), atol=1e-11)
    assert orbit.period[0] == pytest.approx(straight_period(E), rel=1e-10)
    trace = hill_trace(E)
    assert orbit.indices[0, 0].real == pytest.approx(trace, abs=1e-9)
    assert np.trace(orbit.monodromy[:, :, 0]) - 2 == pytest.approx(trace, abs=1e-8)
    assert orbit.residue[0] == pytest.approx((2 - trace) / 4, abs=1e-9)
    expected = (
        Stability.ELLIPTIC if abs(trace) < 2 else Stability.HYPERBOLIC if trace > 2 else Stability.INVERSE_HYPERBOLIC
    )
    assert orbit.stability[0] == expected


def test_seven_simple_orbits_of_henon_heiles():
    """Churchill, Pecelli & Rod 1979: with x = 0 itself, the section's rim, eight at E < 1/6; three-fold symmetry makes
    them alike.
    """
    found = all_periodic(1)
    assert found.crossings.tolist() == [1] * 7
    assert found.residual.max() < 1e-13
    elliptic = found.stability == Stability.ELLIPTIC
    assert elliptic.sum() == 4
    assert (found.stability == Stability.HYPERBOLIC).sum() == 3
    assert np.ptp(found.residue[~elliptic]) < 1e-11
    assert np.ptp(found.period[~elliptic]) < 1e-11
    lines = elliptic & (np.abs(found.z[3]) > 0.1)
    assert lines.sum() == 2
    np.testing.assert_allclose(np.sort(found.z[3, lines]), [-np.sqrt(1 / 24), np.sqrt(1 / 24)], atol=1e-12)
    loops = elliptic & ~lines
    assert np.ptp(found.residue[loops]) < 1e-11
    assert found.residue[loops][0] != pytest.approx(found.residue[lines][0], abs=0.01)
    # Rotated by 120 degrees, one hyperbolic orbit is another: follow it to x = 0 and find that orbit's start.
    c, s = -0.5, np.sqrt(3) / 2
    turn = np.kron(np.eye(2), [[c, -s], [s, c]])
    hyperbolic = found.z[:, ~elliptic]
    images = fa.poincare_map(
        fa.HenonHeiles(), turn @ hyperbolic, section=X, crossings=1, max_time=20.0, step=0.02
    ).points[:, 0]
    distance = np.linalg.norm(images.T[:, None] - hyperbolic.T, axis=2).min(axis=1)
    assert distance.max() < 1e-9


def test_structure_of_monodromy_matrices():
    """Symplectic, with pairs of multipliers; the reduced one has determinant 1 and the trace less 2; f and grad H are
    eigenvectors.
    """
    found = all_periodic(1)
    M, S = (np.moveaxis(matrices, -1, 0) for matrices in (found.monodromy, found.reduced_monodromy))
    assert np.abs(M.transpose(0, 2, 1) @ OMEGA @ M - OMEGA).max() < 1e-11
    assert np.abs(np.linalg.det(S) - 1).max() < 1e-11
    assert np.abs(np.trace(S, axis1=1, axis2=2) + 2 - np.trace(M, axis1=1, axis2=2)).max() < 1e-10
    assert np.abs(found.multipliers[0] * found.multipliers[1] - 1).max() < 1e-11
    for z, matrix in zip(found.z.T, M, strict=True):
        f = naive.slope(fa.HenonHeiles(), z)
        assert np.abs(matrix @ f - f).max() < 1e-9
        assert np.abs(matrix.T @ OMEGA @ f - OMEGA @ f).max() < 1e-9


def test_monodromy_against_differences_of_scipy():
    found = all_periodic(1)
    z, T, h = found.z[:, 2], found.period[2], 1e-5
    ends = [naive.solve(fa.HenonHeiles(), z + s * h * e, T)[0] for e in np.eye(4) for s in (1, -1)]
    expected = np.transpose([(up - down) / (2 * h) for up, down in zip(ends[::2], ends[1::2], strict=True)])
    np.testing.assert_allclose(found.monodromy[:, :, 2], expected, atol=2e-8)


def test_convergence_is_quadratic():
    guess = straight(1 / 12) + np.array([0, 0.01, 0, 0.01])
    run = partial(fa.periodic_orbits, fa.HenonHeiles(), guess, section=X, energy=1 / 12, step=0.08)
    size = np.array([run(iterations=k).residual[0] for k in range(1, 6)])
    constants = size[1:4] / size[:3] ** 2
    assert size[4] < 1e-14
    assert (size[1:4] < 0.1 * size[:3]).all()
    assert (constants < 10).all()
    assert run(iterations=1).status[0] == Status.NOT_CONVERGED


def test_longer_orbits_come_in_pairs():
    """Poincare and Birkhoff: chains of islands have as many orbits with R > 0 as with R < 0; all that is found is prime
    and once.
    """
    _, found = radial_orbits()
    assert found.crossings.tolist() == sorted(found.crossings)
    np.testing.assert_array_equal(found.minimal_crossings, found.crossings)
    assert len(np.unique(found.same())) == found.crossings.size
    np.testing.assert_array_equal(np.isfinite(found.points).all(axis=0).sum(axis=0), found.crossings)
    chains = found.residue[found.crossings == 3]
    assert chains.size >= 2
    assert (chains > 0).sum() == (chains < 0).sum()


def test_same_orbits_are_one_wherever_they_start():
    model, found = radial_orbits()
    chain = found.take(found.crossings == 3)
    starts = chain.points[:, :, 0]
    again = fa.periodic_orbits(model, starts, section=RADIAL, crossings=3, energy=1.5)
    again.raise_if_failed()
    assert again.same().tolist() == [0, 0, 0]
    assert again.unique().crossings.size == 1
    single = found.take(found.crossings == 1).take([0])
    twice = fa.periodic_orbits(model, single.z, section=RADIAL, crossings=2, energy=1.5)
    assert twice.minimal_crossings.tolist() == [1]
    assert twice.period[0] == pytest.approx(2 * single.period[0], rel=1e-11)
    # Residue of the second power: the multipliers squared.
    assert twice.residue[0] == pytest.approx(4 * single.residue[0] * (1 - single.residue[0]), abs=1e-8)


@settings(max_examples=10)
@given(st.floats(0.05, 0.9), st.floats(-0.3, 0.3))
def test_resonant_tori_are_parabolic(C, p_beta):
    """All orbits of the reduced harmonic body have the period pi/omega: every point is periodic, with residue 0."""
    body = fa.Body(fa.Harmonic(C=C), mu=1.2)
    model = fa.reduced_body(body, p_eta=0.4, p_gamma=0.3)
    z = np.array([[1.1, 1.0], [0.7, 0.8], [0.0, 0.0], [p_beta, 0.1]])
    found = fa.periodic_orbits(model, z, section=RADIAL._replace(direction=0), crossings=2, max_time=400.0, step=0.01)
    found.raise_if_failed()
    np.testing.assert_allclose(found.z, z, atol=1e-9)
    np.testing.assert_allclose(found.period, np.pi * np.sqrt(1.2 / C), rtol=1e-9)
    assert np.abs(found.residue).max() < 1e-8
    assert (found.stability == Stability.PARABOLIC).all()


def test_a_guess_beyond_the_saddle_is_not_found():
    found = fa.periodic_orbits(fa.HenonHeiles(), [0, 5.0, 0.1, 0.1], section=X, step=0.07, max_time=60.0)
    assert found.status[0] != Status.OK
    assert np.isnan(found.period[0])
    assert np.isnan(found.residue[0])
    assert found.stability[0] == Stability.UNKNOWN


@pytest.mark.parametrize("scheme", [fa.BLANES_MOAN6, fa.DOP853, fa.SOFRONIOU_SPALETTA10], ids=naive.label)
def test_schemes_agree(scheme):
    step = None if isinstance(scheme, fa.schemes.RungeKutta) else 0.02
    found = fa.periodic_orbits(
        fa.HenonHeiles(), straight(0.1) + np.array([0, 0.01, 0, 0]), section=X, energy=0.1, scheme=scheme, step=step
    )
    found.raise_if_failed()
    assert found.indices[0, 0].real == pytest.approx(hill_trace(0.1), abs=1e-8)


def test_a_scheme_that_chooses_itself():
    guess = straight(0.1) + np.array([0, 0.01, 0, 0])
    found = fa.periodic_orbits(fa.HenonHeiles(), guess, section=X, energy=0.1, scheme=fa.AUTO)
    found.raise_if_failed()
    assert found.indices[0, 0].real == pytest.approx(hill_trace(0.1), abs=1e-8)
    assert found.scheme in fa.AUTO.candidates
    branch = fa.continuation(fa.HenonHeiles(), guess, section=X, energy=0.1, scheme=fa.AUTO, max_steps=3)
    np.testing.assert_allclose(branch.orbits.period, [straight_period(E) for E in branch.parameter], rtol=1e-9)
    grid = straight(0.1)[:, None] + 0.01 * np.random.default_rng(1).standard_normal((4, 5))
    found = fa.find_periodic_orbits(fa.HenonHeiles(), grid, section=X, max_crossings=1, energy=0.1, scheme=fa.AUTO)
    assert np.abs(found.period - straight_period(0.1)).min() < 1e-9


def test_reduced_body_is_the_body():
    """Energy, force, tangent force and motion of the reduced model are those of the body; both ways of the
    conversion.
    """
    z = naive.states(BODY, 20, seed=8)
    E, p_eta, p_gamma = naive.constants(BODY, z)
    for o in range(z.shape[1]):
        model = fa.reduced_body(BODY, p_eta=p_eta[o], p_gamma=p_gamma[o])
        w = model.from_planes(z[:, o])
        assert naive.energy(model, w) == pytest.approx(E[o], rel=1e-13)
        eta, gamma = np.arctan2(z[1, o], z[0, o]), np.arctan2(z[3, o], z[2, o])
        np.testing.assert_allclose(model.to_planes(w, eta, gamma), z[:, o], atol=1e-13)
        for axis in range(2):
            up, down = (np.array(w[:2]) + s * 1e-5 * np.eye(2)[axis] for s in (1, -1))
            slope = (model.potential_energy(*up) - model.potential_energy(*down)) / 2e-5
            assert model.force(*w[:2])[axis] == pytest.approx(-slope, rel=1e-6, abs=1e-6)
            bend = (np.array(model.force(*up)) - np.array(model.force(*down))) / 2e-5
            np.testing.assert_allclose(model.tangent_force(*w[:2], *np.eye(2)[axis]), bend, rtol=1e-6, atol=1e-5)
    end = fa.integrate(BODY, z[:, 0], time=5.0, step=0.01).z[:, 0]
    model = fa.reduced_body(BODY, p_eta=p_eta[0], p_gamma=p_gamma[0])
    reduced_end = fa.integrate(model, model.from_planes(z[:, 0]), time=5.0, step=0.01).z[:, 0]
    np.testing.assert_allclose(model.from_planes(end), reduced_end, atol=1e-9)


def test_without_angular_momentum_beta_runs_through_zero():
    model = fa.reduced_body(BODY, p_eta=0.3, p_gamma=0.0)
    run = fa.integrate(model, [1.4, 0.0, 0.1, 0.6], time=20.0, samples=200, step=0.01)
    run.raise_if_failed()
    assert run.samples[:, 1].min() < -0.1 < 0.1 < run.samples[:, 1].max()
    assert run.energy_error[0] < 1e-12
    lifted = fa.integrate(BODY, model.to_planes([1.4, 0.0, 0.1, 0.6]), time=20.0, samples=200, step=0.01)
    np.testing.assert_allclose(lifted.samples[:, 2, 0], run.samples[:, 1, 0], atol=1e-9)


UNITS = [
    HenonHeilesInUnits(**units)
    for units in (
        {"length": 1e-6},
        {"length": 3e5},
        {"time": 1e-6},
        {"time": 1e6},
        {"mass": 1e-6},
        {"mass": 1e6},
        {"length": 2e-4, "time": 3e3, "mass": 1e5, "zero": -7.0},
        {"origin": 3.0},
        {"zero": 40.0},
    )
]


@pytest.mark.parametrize("model", UNITS, ids=str)
def test_units_origin_and_zero_of_the_potential_change_nothing(model):
    E = 0.11
    plain = orbits_in_natural_units(E)
    other = all_of(model, E)
    assert other.crossings.tolist() == plain.crossings.tolist()
    assert plain.crossings.size >= 6
    # Order within a period follows the residue, which symmetry makes equal: compare as sets.
    momentum = model.mass * model.length / model.time
    z = np.concatenate([other.z[:2] / model.length - model.origin, other.z[2:] / momentum])
    apart = np.linalg.norm(z[:, :, None] - plain.z[:, None], axis=0)
    match = apart.argmin(axis=1)
    assert sorted(match) == list(range(match.size))
    assert apart.min(axis=1).max() < 1e-9 * (1 + abs(model.zero) + model.origin)
    np.testing.assert_allclose(other.period / model.time, plain.period[match], rtol=1e-9)
    np.testing.assert_allclose(other.residue, plain.residue[match], atol=1e-7)
    np.testing.assert_array_equal(other.stability, plain.stability[match])


def all_of(model, E):
    axes = np.linspace(-0.4, 0.6, 10), np.linspace(-0.4, 0.4, 10)
    z0 = fa.energy_grid(fa.HenonHeiles(), energy=E, section=X, axes=axes).z0
    energy = (E + model.zero) * model.energy
    return fa.find_periodic_orbits(
        model, model.rows(z0), section=model.section(), max_crossings=2, energy=energy, max_guesses=25
    )


@cache
def orbits_in_natural_units(E):
    return all_of(HenonHeilesInUnits(), E)


@cache
def branch_in_natural_units(E):
    return fa.continuation(
        HenonHeilesInUnits(), straight(E), section=X, energy=E, bounds=(E - 0.01, E + 0.04), max_steps=60
    )


@pytest.mark.parametrize("model", UNITS[3:7], ids=str)
def test_branches_are_the_same_in_any_units(model):
    guess, E = straight(0.12), 0.12
    plain = branch_in_natural_units(E)
    scale = model.energy
    bounds = tuple((end + model.zero) * scale for end in (E - 0.01, E + 0.04))
    energy = (E + model.zero) * scale
    other = fa.continuation(
        model, model.rows(guess), section=model.section(), energy=energy, bounds=bounds, max_steps=60
    )
    assert other.status == plain.status == Status.OK
    np.testing.assert_allclose(other.parameter / scale - model.zero, plain.parameter, rtol=1e-6)
    np.testing.assert_allclose(other.arclength, plain.arclength, rtol=1e-4, atol=1e-6)
    assert [b.event for b in other.bifurcations] == [b.event for b in plain.bifurcations]
    for a, b in zip(other.bifurcations, plain.bifurcations, strict=True):
        assert a.parameter / scale - model.zero == pytest.approx(b.parameter, rel=1e-9)
        assert a.period / model.time == pytest.approx(b.period, rel=1e-8)


@pytest.mark.parametrize("scheme", [fa.KAHAN_LI8, fa.BLANES_MOAN6, fa.SOFRONIOU_SPALETTA10], ids=naive.label)
def test_errors_cover_the_truth_from_coarse_to_fine_steps(scheme):
    E = np.random.default_rng(4).uniform(0.02, 0.16, 5)
    truth = np.array([straight_period(e) for e in E])
    z = np.array([straight(e) for e in E]).T
    for step in (0.2, 0.07, 0.02, None):
        found = fa.periodic_orbits(fa.HenonHeiles(), z, section=X, energy=E, scheme=scheme, step=step)
        found.raise_if_failed()
        off = np.linalg.norm((found.z - z) / found.scale, axis=0)
        rate = found.scale[2] / found.scale[0]
        own = 1e-13  # rounding of the truth: the cubic's roots
        assert (off <= found.error + own).all()
        assert (np.abs(found.period - truth) * rate <= found.error + own).all()
        assert step is not None or found.error.max() < 1e-9


def test_a_branch_goes_on_where_its_orbits_need_other_steps():
    """From gentle orbits into the wall of the logarithm: each point has a step that suits it, and the orbits are
    closed.
    """
    model = fa.reduced_body(fa.Body(fa.NeoHookean(G=1.0, K=2.0), mu=1.3), p_eta=0.25, p_gamma=0.15)
    start = fa.periodic_orbits(model, [1.33, 0.94, 0.0, 0.0], section=RADIAL, energy=1.5)
    start.raise_if_failed()
    up = fa.continuation(model, start.z[:, 0], section=RADIAL, energy=1.5, bounds=(0.2, 7.0), ds_max=0.3, max_steps=200)
    assert up.status == Status.OK
    assert up.parameter[-1] == 7.0
    assert up.orbits.error.max() < 1e-8
    assert up.orbits.step[-1] < up.orbits.step.max()
    end = up.orbits.take(-1)
    z, T = end.z[:, 0], end.period[0]
    np.testing.assert_allclose(naive.solve(model, z, T)[0], z, atol=1e-9 * np.linalg.norm(end.monodromy))
    down = fa.continuation(
        model, start.z[:, 0], section=RADIAL, energy=1.5, bounds=(0.0, 7.0), direction=-1, ds_max=0.3, max_steps=200
    )
    assert down.status == Status.ACTION_ZERO
    bottom = minimize(lambda q: float(model.potential_energy(*q)), down.orbits.z[:2, -1], tol=1e-15).fun
    assert down.parameter[-1] == pytest.approx(bottom, rel=1e-4)


def test_a_bifurcation_survives_where_the_branch_is_lost_between_two_points(monkeypatch):
    family = sys.modules["fastaff.periodic.family"].Family
    lost = family.corrected
    calls = [0]

    def sometimes(self, *arguments):
        calls[0] += 1
        return None if calls[0] % 3 == 0 and arguments[1] is not None else lost(self, *arguments)

    run = partial(fa.continuation, fa.HenonHeiles(), straight(0.12), section=X, energy=0.12, bounds=(0.12, 0.15))
    whole = run()
    monkeypatch.setattr(family, "corrected", sometimes)
    holed = run()
    assert [b.event for b in holed.bifurcations] == [b.event for b in whole.bifurcations] == [Event.PERIOD_DOUBLING]
    assert abs(holed.bifurcations[0].parameter - whole.bifurcations[0].parameter) < 1e-9


def test_relative_periodic_orbits_return_in_all_invariants_of_the_body():
    model, found = radial_orbits()
    assert (found.stability == Stability.ELLIPTIC).any()
    assert (found.stability == Stability.HYPERBOLIC).any()
    for o in range(found.crossings.size):
        z = model.to_planes(found.z[:, o], eta=0.4, gamma=-1.1)
        end = fa.integrate(BODY, z, time=found.period[o], step=0.005).z[:, 0]
        np.testing.assert_allclose(
            model.from_planes(end), found.z[:, o], atol=1e-10 * np.linalg.norm(found.monodromy[:, :, o])
        )
        crossings = fa.poincare_map(
            BODY, z, section=fa.AlphaTurning(), crossings=int(found.crossings[o]), max_time=100.0, step=0.005
        )
        assert crossings.times[-1, 0] == pytest.approx(found.period[o], rel=1e-9)


def test_branch_of_the_straight_orbit_changes_stability_where_hills_equation_says():
    """Brack 2001, Found. Phys. 31, 209: the first two bifurcations with Tr M = 2 at 6 E = 0.969309 and 0.986709."""
    branch = fa.continuation(
        fa.HenonHeiles(), straight(0.1), section=X, bounds=(0.05, 0.1655), ds_max=0.05, max_steps=200
    )
    assert branch.status == Status.OK
    assert branch.parameter[-1] == 0.1655
    events = [(b.event, b.parameter) for b in branch.bifurcations]
    assert [e for e, _ in events] == [
        Event.PERIOD_DOUBLING,
        Event.PERIOD_DOUBLING,
        Event.BRANCH_POINT,
        Event.BRANCH_POINT,
    ]
    assert 6 * events[2][1] == pytest.approx(0.969309, abs=1e-6)
    assert 6 * events[3][1] == pytest.approx(0.986709, abs=1e-6)
    for event, E in events[1:3]:
        target = -2.0 if event == Event.PERIOD_DOUBLING else 2.0
        assert brentq(lambda e, target=target: hill_trace(e) - target, E - 1e-4, E + 1e-4, xtol=1e-12) == pytest.approx(
            E, abs=1e-9
        )
    for bifurcation in branch.bifurcations:
        assert bifurcation.period == pytest.approx(straight_period(bifurcation.parameter), rel=1e-9)
    np.testing.assert_allclose(branch.orbits.period, [straight_period(E) for E in branch.parameter], rtol=1e-9)
    np.testing.assert_allclose(branch.orbits.energy, branch.parameter, rtol=1e-14)


def test_branch_in_a_parameter_is_the_scaled_branch_in_the_energy():
    """H of lam at energy E is H of 1 at energy lam^2 E with z scaled by lam: same period, same residue."""
    E = 0.08
    branch = fa.continuation(
        fa.HenonHeiles, straight(E), section=X, parameter=1.0, energy=E, bounds=(0.5, 1.3), ds_max=0.1
    )
    assert branch.parameter[-1] == 1.3
    assert (branch.orbits.energy == E).all()
    np.testing.assert_allclose(
        branch.orbits.period, [straight_period(lam**2 * E) for lam in branch.parameter], rtol=1e-9
    )
    np.testing.assert_allclose(
        branch.orbits.indices[0].real, [hill_trace(lam**2 * E) for lam in branch.parameter], atol=1e-8
    )


def test_branch_passes_a_fold():
    """Going down in energy, the chain of period 3 of the body is born with its partner: the residue passes 0 at the
    fold.
    """
    model, found = radial_orbits()
    chain = found.take((found.crossings == 3) & (found.stability == Stability.ELLIPTIC)).take([0])
    branch = fa.continuation(
        model,
        chain.z,
        section=RADIAL,
        crossings=3,
        energy=1.5,
        direction=-1,
        bounds=(0.3, 1.6),
        ds_max=0.1,
        max_steps=150,
    )
    folds = [b for b in branch.bifurcations if b.event == Event.FOLD]
    assert folds
    assert branch.parameter.min() >= folds[0].parameter - 1e-9
    assert branch.parameter[-1] > folds[0].parameter
    low = branch.arclength < folds[0].arclength
    assert branch.orbits.residue[low][-1] * branch.orbits.residue[~low][0] < 0
    assert branch.orbits.residual.max() < 1e-9


def test_gradient_of_sections_that_are_not_analytic():
    z = naive.states(BODY, 5)
    for section in (fa.AlphaEquals(1.2), fa.AreaEquals(1.0), fa.BetaTurning()):
        gradient = section_gradient(section, z, np.ones_like(z))
        for r in range(8):
            h = np.eye(8)[r][:, None] * 1e-5
            np.testing.assert_allclose(gradient[:, r], (section(z + h) - section(z - h)) / 2e-5, atol=1e-9)


def test_wrong_input_is_named():
    model = fa.HenonHeiles()
    for name, error, call in (
        ("crossings", ValueError, lambda: fa.periodic_orbits(model, straight(0.1), section=X, crossings=0)),
        ("energy", ValueError, lambda: fa.periodic_orbits(model, straight(0.1), section=X, energy=[0.1, 0.2])),
        ("energy", TypeError, lambda: fa.periodic_orbits(model, straight(0.1), section=X, energy="low")),
        ("section", TypeError, lambda: fa.periodic_orbits(model, straight(0.1), section=3)),
        ("z0", ValueError, lambda: fa.periodic_orbits(model, np.zeros(3), section=X)),
        ("bounds", ValueError, lambda: fa.continuation(model, straight(0.1), section=X, bounds=(1, 0))),
        ("bounds", ValueError, lambda: fa.continuation(model, straight(0.1), section=X, bounds=(0.2, 0.3))),
        ("direction", ValueError, lambda: fa.continuation(model, straight(0.1), section=X, direction=0)),
        ("model", TypeError, lambda: fa.continuation(model, straight(0.1), section=X, parameter=1.0)),
        ("z0", ValueError, lambda: fa.continuation(model, [0, 5.0, 0.1, 0], section=X, max_time=30.0)),
        ("model", TypeError, lambda: fa.reduced_body(model, p_eta=0.1, p_gamma=0.1)),
        ("p_gamma", ValueError, lambda: fa.reduced_body(BODY, p_eta=0.1, p_gamma=np.nan)),
        ("section_map", TypeError, lambda: fa.periodic.periodic_guesses(np.zeros((3, 4)), 1)),
    ):
        with pytest.raises(error, match=name):
            call()


def test_marks_and_labels():
    found = all_periodic(1)
    ax = Figure().subplots()
    ax.set(xlim=(-0.5, 0.7), ylim=(-0.5, 0.5))
    artists = plot_periodic(found, ax=ax)
    marked = np.concatenate([np.column_stack(line.get_data()) for line in artists.points])
    assert {tuple(m) for m in marked.round(9)} == {tuple(m) for m in found.z[[1, 3]].T.round(9)}
    assert [line.get_marker() for line in artists.points] == ["o", "X"]
    assert len(artists.labels) == 7
    assert artists.missing == 0
    assert ax.get_xlabel() == "$y$"
    ax.figure.canvas.draw()
    boxes = [label.get_window_extent() for label in artists.labels]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    with pytest.raises(ValueError, match="p_y"):
        plot_periodic(found, ax=ax, x="alpha")


@pytest.mark.slow
def test_a_family_that_shrinks_to_an_equilibrium_ends_with_steps_that_are_not_much_finer():
    """The shear mode of an Ogden body: where orbits were missed steps halved from point to point, without an end."""
    rubber = fa.affine_body("ogden", a1=2.0, m1=1.2, a2=-0.3, m2=-1.5, K=6.0)
    plane, section = fa.reduced_body(rubber, p_eta=0.0, p_gamma=0.0), fa.Hyperplane(normal=(0, 0, 1.0, 0.3))
    options = {"section": section, "direction": -1, "bounds": (1e-4, 3.0), "ds_max": 0.4}
    branch = fa.continuation(plane, [np.sqrt(2), 0.05, 0.0, 0.0], **options)
    assert (np.diff(branch.parameter) < 0).all()
    assert branch.orbits.step[-1] > branch.orbits.step[0] / 64
    # Linear at small strains: 2 G = a1 m1 + a2 m2.
    assert abs(2 * np.pi / branch.orbits.period[-1] - np.sqrt(2.0 * 1.2 + 0.3 * 1.5)) < 1e-3


@pytest.mark.parametrize(
    ("argument", "value"), [("energy", 1j), ("energy", [0.1, 0.2]), ("tolerance", -1.0), ("iterations", 0)]
)
def test_a_search_refuses_before_it_runs_a_map(monkeypatch, argument, value):
    module = importlib.import_module("fastaff.periodic.find_periodic_orbits")
    monkeypatch.setattr(module, "poincare_map", None)  # where it is called, TypeError without the name
    with pytest.raises((TypeError, ValueError), match=f"^{argument} must be"):
        fa.find_periodic_orbits(
            fa.HenonHeiles(), [0.0, 0.0, 0.3, 0.31], section="x=0", max_crossings=1, step=0.1, **{argument: value}
        )
