"""Observers and indicators of one's own, and pairs: one pass gives each of two what it keeps on its own, to the bit."""

import functools
import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest

import fastaff as fa
from fastaff import AlphaTurning, BetaTurning, Body, HenonHeiles, Hyperelastic
from fastaff.engine.jit import LANES
from fastaff.engine.kernels.crossings import RECORD
from fastaff.engine.kernels.readings import LN10, length, stretch, time
from fastaff.runs import observers
from fastaff.runs.observers import Observer
from fastaff.runs.options import Options, plan
from fastaff.sections.crossing_run import start_crossings

BODY, ORBITS, TIME, WANTED = Body(Hyperelastic()), 150, 60.0, 6
WIDTH = (RECORD.state + 8) * (WANTED + 8)


@pytest.fixture(scope="module")
def z0():
    z = np.zeros((8, ORBITS))
    z[0], z[2] = 1.5, 0.3
    return z + 0.1 * np.random.default_rng(3).standard_normal(z.shape)


def run(observer, memory, columns, z0):
    flow = plan(BODY, z0, Options(step=0.1)).flow
    ensemble, out = flow.ensemble(z0.copy()), np.zeros((z0.shape[1], columns))
    flow.advance(ensemble, observer, memory, out, time=TIME, refill=True)
    return ensemble, out


def section_memory(section, z0):
    observer = observers.crossings(section, WANTED, 4)
    memory = np.zeros((observer.rows, ORBITS))
    flow, z, *_ = plan(BODY, z0, Options(step=0.1))
    start_crossings(flow, memory, section, flow.ensemble(z))
    return observer, memory


def test_a_section_that_is_soon_full_and_averages_that_never_end(z0):
    section, first = section_memory(AlphaTurning(), z0)
    ranges = observers.averages(BODY, 0, TIME)
    second = np.zeros((ranges.rows, ORBITS))
    both = observers.both(section, ranges, WIDTH)
    memory = np.concatenate([first, second, np.zeros((3, ORBITS))])
    alone, crossed = run(section, first, WIDTH, z0)
    other, _ = run(ranges, second, 1, z0)
    ensemble, out = run(both, memory, WIDTH + 1, z0)
    np.testing.assert_array_equal(out[:, :WIDTH], crossed)
    np.testing.assert_array_equal(memory[section.rows : both.rows - 3], second)
    np.testing.assert_array_equal(ensemble.z, other.z)
    assert alone.time.max() < TIME
    np.testing.assert_allclose(ensemble.time, TIME)


def test_two_sections_end_when_both_are_full(z0):
    parts = [section_memory(section, z0) for section in (AlphaTurning(), BetaTurning(-1))]
    both = observers.both(parts[0][0], parts[1][0], WIDTH)
    memory = np.concatenate([parts[0][1], parts[1][1], np.zeros((3, ORBITS))])
    runs = [run(observer, rows, WIDTH, z0) for observer, rows in parts]
    ensemble, out = run(both, memory, 2 * WIDTH, z0)
    np.testing.assert_array_equal(out, np.concatenate([crossed for _, crossed in runs], axis=1))
    np.testing.assert_array_equal(ensemble.count, np.maximum(runs[0][0].count, runs[1][0].count))


class Line(NamedTuple):
    """A value of the first coordinate, and the passages after which an orbit ends."""

    place: float
    wanted: float


def passages(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Count passages of the line in row 0 and write the step's time of each; row 1 keeps the side, 0 at the start."""
    ended = 0
    for i in range(lanes):
        if fresh[i] == 0.0:
            continue
        side = 1.0 if z[i] > value.place else -1.0
        if side * memory[LANES + i] < 0.0:
            out[orbit[i], int(memory[i])] = t[i]
            memory[i] += 1.0
        memory[LANES + i] = side
        if memory[i] >= value.wanted:
            done[i] = 1.0
            ended += 1
    return ended


HENON = np.random.default_rng(5).uniform(-0.25, 0.25, (4, 200))
"""More orbits than a block has."""


@functools.cache
def states_at_every_step():
    found = fa.integrate(HenonHeiles(), HENON, time=40.0, step=0.1, samples=400)
    return found.samples[:, 0], found.times


@pytest.mark.parametrize("function", [passages, numba.njit(passages)], ids=["plain", "compiled"])
@pytest.mark.parametrize("place", [0.0, 0.1])
def test_an_observer_of_ones_own_sees_every_step(function, place):
    flow, z, *_ = plan(HenonHeiles(), HENON, Options(step=0.1))
    wanted = 13
    ensemble, memory, out = flow.observed(z, Observer(function, 2, Line(place, wanted)), time=40.0, columns=wanted)
    x, times = states_at_every_step()
    side = np.where(x > place, 1, -1)
    for orbit in range(z.shape[1]):
        expected = times[1:][side[1:, orbit] != side[:-1, orbit]][:wanted]
        assert memory[0, orbit] == len(expected)
        np.testing.assert_allclose(out[orbit, : len(expected)], expected, rtol=1e-14)
        assert np.isnan(out[orbit, len(expected) :]).all()
        assert ensemble.time[orbit] == pytest.approx(expected[-1] if len(expected) == wanted else 40.0)
    assert (memory[0] == wanted).any()
    assert (memory[0] < wanted).any()


def test_one_of_ones_own_beside_one_of_the_package():
    flow, z, *_ = plan(HenonHeiles(), HENON, Options(step=0.1))
    own, averages = Observer(passages, 2, Line(0.0, 4.0)), observers.averages(HenonHeiles(), 0, 40.0)
    _, first, out = flow.observed(z, own, time=40.0, columns=4)
    _, second, _ = flow.observed(z, averages, time=40.0)
    ensemble, memory, written = flow.observed(z, observers.both(own, averages, 4), time=40.0, columns=5)
    np.testing.assert_array_equal(memory[:2], first)
    np.testing.assert_array_equal(memory[2:7], second)
    np.testing.assert_array_equal(written[:, :4], out)
    np.testing.assert_array_equal(ensemble.time, 40.0)
    ended, memory, written = flow.observed(z, observers.either(own, observers.beyond(1, 0.2)), time=40.0, columns=4)
    sooner = ended.time < flow.observed(z, own, time=40.0, columns=4)[0].time
    assert (ended.z[1, sooner] >= 0.2).all()
    assert sooner.any()
    np.testing.assert_array_equal(written[~sooner], out[~sooner])


def decades(growth, i):
    return length(growth, 0, i) / LN10


def weighted(growth, i, first, second):
    return (first * stretch(growth, 0, i) + second * stretch(growth, 1, i)) / time(growth, i)


def test_an_indicator_of_ones_own_beside_those_of_the_package():
    own = fa.chaos.TangentIndicator("decades", decades, threshold=4.0)
    first, second = (
        fa.chaos.TangentIndicator(name, weighted, threshold=-1.0, above=False, count=2, parameters=weights)
        for name, weights in (("first", (1.0, 0.0)), ("second", (0.0, 1.0)))
    )
    small, given = HENON[:, :40], (fa.Lyapunov(), fa.LyapunovSpectrum(), own, first, second)
    found = fa.chaos_map(HenonHeiles(), small, time=200.0, step=0.1, indicators=given, history=5)
    np.testing.assert_array_equal(found.decades * (LN10 / found.t), found.lyapunov)
    exponents = np.array([found.first, found.second, -found.first, -found.second])
    np.testing.assert_allclose(np.sort(exponents, axis=0)[::-1], found.spectrum, atol=1e-13)
    np.testing.assert_array_equal(found.history[2, -1], found.decades)
    assert (found.decades[found.classifications[2] == fa.Classification.CHAOTIC] > 4.0).all()
    late = np.isfinite(found.detection_time[2])
    assert (found.history[2].max(axis=0)[~late] <= 4.0).all()
    assert not (found.classifications[3] == fa.Classification.CHAOTIC).any()
    both = replace(first, name="both", parameters=(1.0, 0.5))
    again = fa.chaos_map(HenonHeiles(), small, time=200.0, step=0.1, indicators=(own, both))
    np.testing.assert_allclose(again.both, found.first + found.second / 2, atol=1e-13)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"reading": "memory[0]"}, TypeError, "reading must be a function"),
        ({"name": "my own"}, ValueError, "name must be a name"),
        ({"count": 5}, ValueError, "count must be from 1 to 4 here, got 5"),
        ({"parameters": 1.0}, TypeError, "parameters must be a tuple of floats"),
        ({"parameters": ("1",)}, TypeError, r"parameters\[0\]"),
        ({"judge": 3}, TypeError, "judge must be a function or None"),
        ({"threshold": None}, TypeError, "threshold"),
        ({"above": "yes"}, TypeError, "above"),
    ],
)
def test_an_indicator_of_ones_own_is_checked(change, error, message):
    fields = {"name": "own", "reading": decades, "threshold": 1.0} | change
    with pytest.raises(error, match=message):
        fa.chaos_map(HenonHeiles(), HENON[:, 0], time=10.0, step=0.1, indicators=(fa.chaos.TangentIndicator(**fields),))


def nothing_of_some(growth, i):
    if time(growth, i) < 0.0:
        return 1.0


def unknown(growth, i):
    return np.nan


def of_half_a_digit(growth, i):
    return np.float16(1.0)


def of_a_text(growth, i):
    return "calm"


@pytest.mark.parametrize("above", [True, False])
@pytest.mark.parametrize("more", [{}, {"early_stop": True}, {"history": 3}])
@pytest.mark.parametrize("reading", [unknown, nothing_of_some])
def test_an_indicator_that_says_nothing_leaves_all_undecided(reading, more, above):
    own = fa.chaos.TangentIndicator("own", reading, threshold=2.0, above=above)
    found = fa.chaos_map(HenonHeiles(), HENON[:, :3], time=400.0, step=0.1, indicators=(own, fa.SALI()), **more)
    alone = fa.chaos_map(HenonHeiles(), HENON[:, :3], time=400.0, step=0.1, indicators=(own,), **more)
    assert np.isnan(found.own).all()
    assert (found.classifications[0] == fa.Classification.UNDECIDED).all()
    assert (alone.classification == fa.Classification.UNDECIDED).all()
    assert (alone.status == fa.Status.OK).all()
    assert np.isfinite(found.sali).all()


@pytest.mark.parametrize("reading", [of_half_a_digit, of_a_text])
def test_an_indicator_that_numba_cannot_compile_is_refused_by_name(reading):
    own = fa.chaos.TangentIndicator("own", reading, threshold=2.0)
    with pytest.raises(TypeError, match=r"reading must be a function reading.* for Numba: ."):
        fa.chaos_map(HenonHeiles(), HENON[:, 0], time=10.0, step=0.1, indicators=(own,))


@pytest.mark.parametrize("said", [np.nan, None, 3, True, [True], np.ones(7, bool), np.ones(2), np.array(True), "calm"])
def test_what_a_judge_says_is_checked(said):
    own = fa.chaos.TangentIndicator("own", decades, threshold=2.0, judge=lambda *_: said)
    with pytest.raises(TypeError, match="judge of the indicator own must return an array of 2 True or False, got"):
        fa.chaos_map(HenonHeiles(), HENON[:, :2], time=10.0, step=0.1, indicators=(own,))


def test_what_a_judge_says_stays_his():
    kept = np.ones(2, bool)
    own = fa.chaos.TangentIndicator("own", decades, threshold=9.0, judge=lambda *_: kept)
    fa.chaos_map(HenonHeiles(), HENON[:, :2], time=10.0, step=0.1, indicators=(own,))
    assert kept.all()


def test_the_example_of_both():
    """The area is that of the spectrum's two positive exponents, and orbits end at their first point far out."""
    path = Path(__file__).parents[2] / "examples" / "own_indicator.py"
    spec = importlib.util.spec_from_file_location("own_indicator_example", path)
    example = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = example  # functions are found by their file
    spec.loader.exec_module(example)
    z0 = example.starts(12)
    found = fa.chaos_map(HenonHeiles(), z0, time=500.0, step=0.1, indicators=(fa.LyapunovSpectrum(), example.AREA))
    grown = found.spectrum[:2].sum(axis=0) * found.t / LN10
    chaotic = found.classifications[0] == fa.Classification.CHAOTIC
    assert chaotic.any()
    np.testing.assert_allclose(found.area[chaotic], grown[chaotic], rtol=1e-9, atol=0.5)
    flow, z, *_ = plan(HenonHeiles(), z0, Options(step=0.05))
    far = Observer(example.farthest, 1, example.Farthest(0.6))
    orbits, memory, when = flow.observed(z, far, time=50.0)
    states = fa.integrate(HenonHeiles(), z0, time=50.0, step=0.05, samples=1000)
    distance = np.hypot(states.samples[:, 0], states.samples[:, 1])
    for orbit in range(z0.shape[1]):
        out = np.flatnonzero(distance[:, orbit] > 0.6)
        last = out[0] + 1 if out.size else 1000
        assert orbits.time[orbit] == pytest.approx(states.times[last - 1])
        assert memory[0, orbit] == pytest.approx(distance[:last, orbit].max(), rel=1e-12)
        assert when[orbit, 0] == pytest.approx(states.times[distance[:last, orbit].argmax()])
