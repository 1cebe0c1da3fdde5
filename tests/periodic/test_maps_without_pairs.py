"""Periodic orbits of maps of one variable, and of maps that lose area: closed forms of May, Henon and others."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.periodic import Event, Stability


def logistic(r):
    return fa.iterated_map("x1 = r*x*(1 - x)", r=r)


def henon(a):
    return fa.iterated_map("x1 = 1 - a*x**2 + y; y1 = b*x", coordinates="x", momenta="y", a=a, b=0.3)


@pytest.mark.parametrize("r", [1.7, 2.8, 3.4, 3.9])
def test_the_fixed_point_of_the_logistic_map(r):
    """1 - 1/r with the multiplier 2 - r."""
    found = fa.periodic_orbits(logistic(r), [1 - 1 / r + 0.01])
    found.raise_if_failed()
    assert not found.symplectic
    assert abs(found.z[0, 0] - (1 - 1 / r)) <= found.error[0] * found.scale[0, 0]
    assert abs(found.multipliers[0, 0] - (2 - r)) <= found.multiplier_errors[0, 0]
    assert found.stability[0] == (Stability.ATTRACTING if r < 3 else Stability.REPELLING)


def test_the_number_of_cycles_of_the_full_logistic_map():
    """At r = 4 there are 2, 1, 2, 3 cycles of 1 to 4 points: sin^2 of multiples of pi/(2^n -+ 1)."""
    x0 = np.linspace(0.01, 0.99, 60)[None]
    found = fa.find_periodic_orbits(logistic(4.0), x0, max_crossings=4, scan_crossings=300)
    assert np.bincount(found.crossings).tolist() == [0, 2, 1, 2, 3]
    for z, n in zip(found.z[0], found.crossings, strict=True):
        turns = np.arcsin(np.sqrt(max(z, 0.0))) / np.pi
        whole = [abs(turns * (2**n + sign) - np.round(turns * (2**n + sign))) for sign in (-1, 1)]
        assert min(whole) < 1e-10
    slopes = np.sort(np.abs(found.multipliers[0]))
    np.testing.assert_allclose(slopes, [2, 4, 4, 8, 8, 16, 16, 16], rtol=1e-10)


@pytest.mark.parametrize(
    ("crossings", "start", "first", "direction", "event", "value"),
    [
        (1, 0.6, 2.5, 1, Event.PERIOD_DOUBLING, 3.0),
        (2, 0.5130445, 3.2, 1, Event.PERIOD_DOUBLING, 1 + np.sqrt(6)),
        (3, 0.149407, 3.84, -1, Event.FOLD, 1 + np.sqrt(8)),
    ],
)
def test_bifurcations_of_the_logistic_map(crossings, start, first, direction, event, value):
    branch = fa.continuation(
        logistic,
        [start],
        crossings=crossings,
        parameter=first,
        direction=direction,
        bounds=(2.4, 3.9),
        ds_max=1.0,
        max_steps=60,
    )
    near = [b for b in branch.bifurcations if b.event == event and abs(b.parameter - value) < 1e-3]
    assert len(near) == 1
    assert abs(near[0].parameter - value) <= near[0].error < 1e-9


def test_henons_fixed_point_folds_and_doubles():
    """The fold is at a = -(1 - b)^2/4, the period doubling at 3 (1 - b)^2/4."""
    x = (-0.7 + np.sqrt(0.49 + 4 * 1.4)) / 2.8
    found = fa.periodic_orbits(henon(1.4), [0.6, 0.2])
    np.testing.assert_allclose(found.z[:, 0], [x, 0.3 * x], atol=1e-14)
    np.testing.assert_allclose(np.sort(found.multipliers[:, 0].real), np.sort(np.roots([1, 2.8 * x, -0.3])), atol=1e-13)
    assert found.stability[0] == Stability.SADDLE
    branch = fa.continuation(
        henon, found.z[:, 0], parameter=1.4, direction=-1, bounds=(-1.0, 1.5), ds_max=1.0, max_steps=120
    )
    for event, value in ((Event.PERIOD_DOUBLING, 0.3675), (Event.FOLD, -0.1225)):
        (one,) = (b for b in branch.bifurcations if b.event == event)
        assert abs(one.parameter - value) <= one.error


def test_the_map_of_the_circle_is_locked():
    """sin(2 pi x) = 2 pi w/k at the fixed points, the multiplier 1 - k cos(2 pi x)."""
    circle = fa.iterated_map("x1 = x + w - k/(2*pi)*sin(2*pi*x)", periodic={"x": "1"}, w=0.1, k=0.9)
    found = fa.periodic_orbits(circle, [[0.1, 0.4]])
    found.raise_if_failed()
    angle = np.arcsin(0.2 * np.pi / 0.9) / (2 * np.pi)
    np.testing.assert_allclose(np.sort(found.z[0]), [angle, 0.5 - angle], atol=1e-14)
    np.testing.assert_allclose(found.multipliers[0].real, 1 - 0.9 * np.cos(2 * np.pi * found.z[0]), atol=1e-13)
