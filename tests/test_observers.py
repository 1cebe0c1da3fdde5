"""Observers compose: one pass gives each of two what it keeps on its own, to the bit."""

import numpy as np
import pytest

from fastaff import AlphaTurning, BetaTurning, Body, Hyperelastic
from fastaff.analysis.sections.poincare_map import start_crossings
from fastaff.flows import observers
from fastaff.flows.plan import Options, plan
from fastaff.kernels.crossings import RECORD

BODY, ORBITS, TIME, WANTED = Body(Hyperelastic()), 150, 60.0, 6
WIDTH = (RECORD + 8) * (WANTED + 8)


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
    flow, z, _ = plan(BODY, z0, Options(step=0.1))
    start_crossings(flow, memory, section, flow.ensemble(z))
    return observer, memory


def test_a_section_that_is_soon_full_and_averages_that_never_end(z0):
    section, first = section_memory(AlphaTurning(), z0)
    ranges = observers.averages(BODY, 0, TIME)
    second = np.zeros((ranges.rows, ORBITS))
    both = observers.together(section, ranges, WIDTH)
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
    both = observers.together(parts[0][0], parts[1][0], WIDTH)
    memory = np.concatenate([parts[0][1], parts[1][1], np.zeros((3, ORBITS))])
    runs = [run(observer, rows, WIDTH, z0) for observer, rows in parts]
    ensemble, out = run(both, memory, 2 * WIDTH, z0)
    np.testing.assert_array_equal(out, np.concatenate([crossed for _, crossed in runs], axis=1))
    np.testing.assert_array_equal(ensemble.count, np.maximum(runs[0][0].count, runs[1][0].count))
