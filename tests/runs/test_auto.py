"""The scheme that chooses itself: its rule, and what it picks on smooth and on steep models."""

import numpy as np
import pytest

from fastaff import (
    AUTO,
    BLANES_MOAN6,
    DOP853,
    KAHAN_LI8,
    LEAPFROG,
    AlphaTurning,
    Body,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    NeoHookean,
    Status,
    TimeTransformed,
    chaos_map,
    energy_grid,
    frequency_map,
    integrate,
    poincare_map,
)
from fastaff.runs.scales import typical_rate
from fastaff.runs.schemes import BLANES_CASAS_ESCORIHUELA8, Automatic, Logistic, RungeKutta, Splitting
from fastaff.runs.schemes.automatic import PREFERENCE, CandidateTrial
from fastaff.systems.models.mechanics import system_of

SMOOTH = np.array([[0.0, 0.0, 0.1], [0.1, 0.2, -0.1], [0.35, 0.3, 0.2], [0.0, 0.1, 0.2]])


def trial(scheme, error, cost):
    return CandidateTrial(scheme, 0.1, error, cost)


@pytest.mark.parametrize(
    ("options", "scheme"),
    [
        ({"accuracy": 1e-5}, BLANES_MOAN6),
        ({"accuracy": 1e-9}, BLANES_CASAS_ESCORIHUELA8),
        ({}, BLANES_CASAS_ESCORIHUELA8),
        ({"step": 0.1}, KAHAN_LI8),
    ],
)
def test_the_default_follows_the_accuracy(options, scheme):
    z0, section = SMOOTH[:, :2], Hyperplane((1.0, 0.0, 0.0, 0.0))
    assert integrate(HenonHeiles(), z0, time=5.0, **options).scheme == scheme
    assert poincare_map(HenonHeiles(), z0, section=section, crossings=2, max_time=30.0, **options).scheme == scheme
    assert frequency_map(HenonHeiles(), z0, time=40.0, **options).scheme == scheme
    if "accuracy" not in options:
        assert chaos_map(HenonHeiles(), z0, time=5.0, **options).scheme == scheme
    found = integrate(HenonHeiles(), z0, time=5.0, **options)
    given = integrate(HenonHeiles(), z0, time=5.0, scheme=scheme, **options)
    np.testing.assert_array_equal(found.z, given.z)


def test_the_cheapest_that_is_good_enough_wins():
    rule = Automatic((KAHAN_LI8, DOP853), energy_error=1e-10)
    good, bad = trial(DOP853, 1e-11, 100.0), trial(KAHAN_LI8, 1e-9, 10.0)
    assert rule.choose([bad, good]) is good
    dear = trial(KAHAN_LI8, 1e-12, 100.0 * PREFERENCE * 1.01)
    assert rule.choose([good, dear]) is good


def test_a_symplectic_scheme_is_preferred_when_close():
    rule = Automatic((KAHAN_LI8, DOP853), energy_error=1e-10)
    adaptive, close, cheaper = (
        trial(DOP853, 1e-11, 100.0),
        trial(KAHAN_LI8, 1e-12, 140.0),
        trial(LEAPFROG, 1e-12, 120.0),
    )
    assert rule.choose([adaptive, close]) is close
    assert rule.choose([adaptive, close, cheaper]) is cheaper


def test_the_least_error_wins_where_none_is_good_enough():
    rule = Automatic((KAHAN_LI8, DOP853), energy_error=1e-16)
    assert rule.choose([trial(KAHAN_LI8, 1e-12, 1.0), trial(DOP853, 1e-13, 9.0)]).scheme is DOP853


def test_smooth_motion_gets_a_fixed_step():
    found = integrate(HenonHeiles(), SMOOTH, time=200.0, samples=20, scheme=AUTO)
    assert isinstance(found.scheme, Splitting)
    assert (found.step > 0.0).all()
    assert (found.step < 2.0).all()
    assert found.energy_error.max() < AUTO.energy_error
    again = integrate(HenonHeiles(), SMOOTH, time=200.0, samples=20, scheme=found.scheme, step=found.step)
    assert np.array_equal(again.z, found.z)


@pytest.mark.parametrize("speed", [1e-6, 0.3])
def test_the_rate_on_a_circle_without_force_is_that_of_small_oscillations(speed):
    """V = alpha^2/2 + 2/alpha^2 at beta = 0: no force at alpha = sqrt 2; omega = 2 across it, more in beta."""
    z = np.zeros((8, 1))
    z[0], z[5] = np.sqrt(2.0), speed
    assert 0.2 < typical_rate(system_of(Body(Hyperelastic())), z) < 5.0


def launched(body, energy, *axes):
    """A grid on alpha-turning at p_eta = 0.3, p_gamma = 0.2."""
    axes = tuple(np.linspace(*axis) for axis in axes)
    return energy_grid(body, energy=energy, p_eta=0.3, p_gamma=0.2, section=AlphaTurning(+1), axes=axes)


def steep():
    return launched(Body(NeoHookean(), 1.0), 8.0, (0.1, 2.7, 7), (-3.5, 3.5, 7)).z0


def test_a_steep_wall_gets_no_fixed_step():
    """Over a short time adaptive steps may do; over a long one, as their error grows, the transformed ones."""
    body, z0 = Body(NeoHookean(), 1.0), steep()
    short = integrate(body, z0, time=3.0, scheme=AUTO)
    assert isinstance(short.scheme, (RungeKutta, TimeTransformed))
    rule = Automatic((KAHAN_LI8, TimeTransformed(), DOP853), energy_error=1e-11)
    long = poincare_map(body, z0[:, :3], section=AlphaTurning(+1), crossings=10, max_time=1000.0, scheme=rule)
    long.raise_if_failed()
    assert isinstance(long.scheme, TimeTransformed)
    assert long.scheme.rate is not None
    assert long.energy_error.max() < 1e-9
    assert short.energy_error.max() < AUTO.energy_error


def test_other_functions_choose_among_steps_in_time():
    found = frequency_map(
        HenonHeiles(), SMOOTH, time=200.0, scheme=Automatic((TimeTransformed(), BLANES_MOAN6, KAHAN_LI8), 1e-11)
    )
    plain = frequency_map(HenonHeiles(), SMOOTH, time=200.0, scheme=KAHAN_LI8)
    assert (np.abs(found.nu - plain.nu) <= found.error + plain.error + 1e-9).all()  # 30 periods are few
    with pytest.raises(ValueError, match="integrate and poincare_map"):
        frequency_map(HenonHeiles(), SMOOTH, time=200.0, scheme=Automatic((TimeTransformed(),)))


def test_the_choice_does_not_depend_on_the_order_of_candidates_or_the_run():
    rule = Automatic((KAHAN_LI8, BLANES_MOAN6, DOP853))
    first = integrate(HenonHeiles(), SMOOTH, time=5.0, scheme=rule)
    second = integrate(HenonHeiles(), SMOOTH, time=5.0, scheme=Automatic(rule.candidates[::-1]))
    assert first.scheme is second.scheme
    assert np.array_equal(first.step, second.step)


def test_orbits_that_escape_have_no_say():
    """The choice is that for the others, each of which moves as it would alone; alone, an escaping orbit has a
    status.
    """
    z0 = np.random.default_rng(1).uniform(-0.15, 0.15, (4, 40))
    escaping = z0.copy()
    escaping[1, :8], escaping[3, :8] = 1.05, 0.5
    rule = Automatic((KAHAN_LI8, BLANES_MOAN6, TimeTransformed(), DOP853))
    alone, mixed = (integrate(HenonHeiles(), z, time=30.0, scheme=rule) for z in (z0[:, 8:], escaping))
    assert (mixed.status[:8] != Status.OK).all()
    assert (mixed.status[8:] == Status.OK).all()
    assert mixed.scheme.name == alone.scheme.name
    assert mixed.energy_error[8:].max() < rule.energy_error
    lost = integrate(HenonHeiles(), escaping[:, 0], time=30.0, scheme=rule)
    assert isinstance(lost.scheme, RungeKutta)
    assert lost.status[0] != Status.OK
    assert integrate(HenonHeiles(), escaping[:, 0], time=30.0, scheme=TimeTransformed()).status[0] != Status.OK


@pytest.mark.parametrize(
    ("problem", "wrong"),
    [
        (ValueError, lambda: Automatic(())),
        (ValueError, lambda: Automatic([KAHAN_LI8])),
        (TypeError, lambda: Automatic((KAHAN_LI8, "DOP853"))),
        (TypeError, lambda: Automatic((AUTO,))),
        (TypeError, lambda: Automatic((Logistic(1.0),))),
        (ValueError, lambda: Automatic((KAHAN_LI8,), energy_error=0.0)),
        (ValueError, lambda: integrate(HenonHeiles(), SMOOTH, time=1.0, step=0.1, scheme=AUTO)),
        (ValueError, lambda: frequency_map(HenonHeiles(), SMOOTH, time=10.0, step=0.1, scheme=AUTO)),
        (ValueError, lambda: integrate(HenonHeiles(), SMOOTH, time=1.0, rtol=-1.0, scheme=AUTO)),
        (ValueError, lambda: integrate(HenonHeiles(), SMOOTH[:3], time=1.0, scheme=AUTO)),
    ],
)
def test_wrong_input_raises(problem, wrong):
    with pytest.raises(problem, match=r"candidates|energy_error|step|rtol|z0"):
        wrong()
