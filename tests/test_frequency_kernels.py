"""Kernels of frequencies against plain NumPy: rows that runs write, spectra, peaks, demodulated sums, generators."""

import numpy as np
import pytest

from fastaff import Body, HenonHeiles, NeoHookean, hamiltonian
from fastaff.analysis.frequencies import demodulated, fundamental
from fastaff.analysis.frequencies.frequency_map import FrequencyWork, checked_angles
from fastaff.analysis.frequencies.fundamental import Loops, tables_of
from fastaff.analysis.frequencies.rooms import Room
from fastaff.analysis.frequencies.signals import Signals, signals_of
from fastaff.analysis.frequencies.windows import APART_ORDER, BRIEF, apart_window, cosine_window, tables_for
from fastaff.flows.options import Options, plan
from fastaff.kernels import fundamental as kernels
from fastaff.kernels import peaks


def ragged(rng, rows, counts):
    """Signals of random numbers, of so many samples each, with gaps between the orbits."""
    sizes = rows * np.array(counts) + 5
    start = np.cumsum(sizes) - sizes
    return Signals(rng.normal(size=int(sizes.sum())), rows, start, np.array(counts), rng.uniform(0.1, 1.0, len(counts)))


@pytest.mark.parametrize("body", [HenonHeiles(), Body(NeoHookean())], ids=["plane", "body"])
def test_runs_write_the_signals_of_their_states(body):
    """Orbits of different steps and numbers of samples share blocks; each has the bits that it has alone."""
    rng = np.random.default_rng(3)
    z0 = rng.normal(0, 0.1, (2 * body.degrees_of_freedom, 41))
    if isinstance(body, Body):
        z0[0] += 1.5
    flow, z0, *_ = plan(body, z0, Options(None, 0.11, None, 1e-12, 1e-12, None, 2, None), time=9.0)
    counts = rng.choice([7, 24, 41, 64], 41)
    work = FrequencyWork(flow, checked_angles(None, body), z0, 9.0, None, None, None)
    found, run = work._sampled(work.flow, np.arange(41), 9.0, counts, Room())
    assert (run.status == 0).all()
    for orbit in range(41):
        (s,), n = found.array(np.array([orbit])), int(counts[orbit])
        ensemble = flow.of(np.array([orbit])).ensemble(z0[:, [orbit]].copy())
        (states,) = flow.of(np.array([orbit])).sampled(ensemble, n, time=9.0)
        table = work.layout.signals(states[None], 1, Room())[0]
        np.testing.assert_array_equal(s, table)
    q = np.arange(2 * body.degrees_of_freedom).reshape(2, -1).T.ravel()
    if not isinstance(body, Body):
        np.testing.assert_array_equal(s, states.T[q])


def test_signals_of_different_lengths():
    rng = np.random.default_rng(0)
    s = ragged(rng, 3, [7, 9, 7, 7, 9])
    assert [list(o) for o in s.alike()] == [[0, 2, 3], [1, 4]]
    for orbits in s.alike():
        for orbit, table in zip(orbits, s.array(orbits), strict=True):
            first = s.start[orbit]
            np.testing.assert_array_equal(table.ravel(), s.numbers[first : first + table.size])
    some = s.of(np.array([4, 0]))
    np.testing.assert_array_equal(some.samples, [9, 7])
    low, high = np.empty((2, 5, 3))
    fundamental.run(kernels.extremes, 5, (s.ragged, low, high), 2)
    for orbits in s.alike():
        np.testing.assert_array_equal(low[orbits], s.array(orbits).min(axis=2))
        np.testing.assert_array_equal(high[orbits], s.array(orbits).max(axis=2))
    whole = rng.normal(size=(4, 3, 11))
    np.testing.assert_array_equal(signals_of(whole, 0.5).array(np.arange(1, 3)), whole[1:3])


def test_tables_of_few_and_of_many_samples():
    found = tables_for(cosine_window, np.array([64, 100, 64]))
    for count, start in zip((64, 100, 64), found.start, strict=True):
        np.testing.assert_array_equal(found.numbers[start : start + count], cosine_window(count))
    assert cosine_window(64) is cosine_window(64)
    kept = [cosine_window(BRIEF + k) for k in range(1, 4)]
    assert cosine_window(BRIEF + 3) is kept[2]
    assert cosine_window(BRIEF + 1) is not kept[0]


def test_spectra_are_fourier_transforms_of_weighted_loops():
    rng = np.random.default_rng(1)
    s = ragged(rng, 4, [60, 96, 60])
    s.numbers[:] += 3.0
    for orbit, n in ((0, 60), (1, 96), (2, 60)):  # a row that grows
        first = s.start[orbit]
        s.numbers[first : first + n] = 0.7 * np.arange(n) + 0.1 * np.sin(np.arange(n))
    spectra, start, _, (drift, centre, size, moving) = fundamental._spectra(s, 2, 2)
    assert moving.all()
    np.testing.assert_allclose(drift[:, 0], 0.7, rtol=1e-2)
    for orbit, n in ((0, 60), (1, 96), (2, 60)):
        x = s.array(np.array([orbit]))[0] - drift[orbit][:, None] * np.arange(n)
        mean = x @ cosine_window(n)
        x = x - mean[:, None]
        rms = np.sqrt((x**2) @ cosine_window(n))
        np.testing.assert_allclose(centre[orbit], mean, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(size[orbit], rms, rtol=1e-9)
        loops = (x[0::2] / rms[0::2, None] - 1j * x[1::2] / rms[1::2, None]) * apart_window(n)
        own = spectra[start[orbit] : start[orbit] + 2 * n].reshape(2, n)
        np.testing.assert_allclose(own, np.fft.fft(loops), rtol=0, atol=1e-9)


@pytest.mark.parametrize("n", [96, 200, 1024, 1544])
def test_peaks_are_lines_that_stand_apart(n):
    """Places and amplitudes of three lines 12 bins and more apart, to what their tails leave."""
    rng = np.random.default_rng(n)
    u = np.array([-25.3, 11.0, 31.7]) + rng.uniform(-0.5, 0.5, 3)
    amplitude = np.array([1.0, 0.4, 0.02]) * np.exp(2j * np.pi * rng.uniform(size=3))
    t = np.arange(n) / n
    f = np.exp(2j * np.pi * np.outer(t, u)) @ amplitude
    spectrum = np.fft.fft(f * apart_window(n))
    place, size, error = np.zeros((3, 3))
    count, rest = peaks.find_peaks(spectrum, APART_ORDER, place, size, error)
    assert count == 3
    off = (place - u + n / 2) % n - n / 2
    assert (np.abs(off) < [1e-4, 1e-4, 1e-2]).all()
    assert (np.abs(off) <= error + 1e-9).all()
    np.testing.assert_allclose(size, np.abs(amplitude), rtol=1e-2)
    assert rest < 0.01


def test_demodulated_sums_are_sums():
    """All sums of orbits of different lengths, odd ones too; and the frequency of a line to rounding."""
    rng = np.random.default_rng(5)
    s = ragged(rng, 4, [97, 640, 1000])
    loops = Loops(*(rng.normal(size=(3, 2, *more)) + 1j * rng.normal(size=(3, 2, *more)) for more in ((4,), (), ())))
    loops.c[0, 1, 2] = loops.c[2, 0, :3] = 0.0
    loops.drift[:] *= 1e-2
    nu = rng.uniform(0.1, 0.4, (3, 2)) / s.interval[:, None]
    sums = np.zeros((3, 2, 18), complex)
    weights, places = (tables_for(make, s.samples) for make in (demodulated._weights, demodulated._places))
    arguments = s.ragged, s.samples, loops, nu, s.interval, weights, places, sums
    fundamental.run(demodulated.demodulation.demodulate, 3, arguments, 2)
    for orbit in range(3):
        n = int(s.samples[orbit])
        j = np.arange(n)
        table, where = demodulated._windows(n)
        (x,) = s.array(np.array([orbit]))
        f = loops.c[orbit] @ x - loops.offset[orbit][:, None] - loops.drift[orbit][:, None] * j
        f = f * np.exp(-2j * np.pi * nu[orbit][:, None] * s.interval[orbit] * j)
        for k, (first, begin, length) in enumerate(where):
            expected = f[:, begin : begin + length] @ table[first : first + length]
            np.testing.assert_allclose(sums[orbit, :, k], expected, rtol=1e-10, atol=1e-12)


def test_a_line_alone_is_exact():
    rng = np.random.default_rng(6)
    n, nu, dt = 333, rng.uniform(0.05, 0.2, 20), 0.7
    t = dt * np.arange(n)
    x = np.stack([np.cos(2 * np.pi * nu[:, None] * t), -np.sin(2 * np.pi * nu[:, None] * t)], axis=1)
    loops = Loops(np.tile([1.0, -1j], (20, 1, 1)), np.zeros((20, 1), complex), np.zeros((20, 1), complex))
    found = demodulated.demodulated(signals_of(x, dt), loops, nu[:, None] * (1 + 1e-4), 1)
    for value in (found.nu[:, 0], *found.halves[:, 0].T):
        np.testing.assert_allclose(value, nu, rtol=0, atol=1e-14)


def test_the_shortest_vector_is_found_as_one_after_another_finds_it():
    """Lines of random lattices, some of no lattice, with errors from tiny to so large that all is an accident."""
    rng = np.random.default_rng(7)
    tables, sizes = tables_of(3)
    outcomes = set()
    for _ in range(600):
        rank = int(rng.integers(1, 4))
        table, count = tables[rank - 1], int(sizes[rank - 1, rng.integers(2)])
        basis, spread = rng.uniform(1, 9, rank), 10.0 ** rng.uniform(-12, -3, rank)
        true = table[:rank, rng.integers(count)]
        value = float(true @ basis) if rng.random() < 0.7 else float(rng.uniform(0, 20))
        bar, accidental = float(10.0 ** rng.uniform(-10, -2)), float(rng.choice([0.01, 0.5]))
        expected = None
        for v in range(count):
            k = table[:rank, v]
            tolerance = bar + np.abs(k) @ spread
            if 2 * tolerance * (v + 1) > accidental * np.abs(basis).max() * np.abs(k).sum():
                break
            if abs(value - k @ basis) <= tolerance:
                expected = list(k)
                break
        k = np.zeros(rank, np.int64)
        found = kernels.relate(value, bar, basis, spread, rank, table, count, accidental, k)
        assert (list(k) if found else None) == expected
        outcomes.add((found, rank))
    assert len(outcomes) == 6


def test_moments_of_lines_are_weighted_sums():
    """Signals of different lengths, without their growth and mean, in units of their sizes."""
    rng = np.random.default_rng(8)
    s = ragged(rng, 4, [90, 200, 130])
    n, interval = np.array([90, 192, 125]), s.interval
    drift, centre, units = rng.normal(size=(3, 3, 4))
    rank, nu = np.array([2, 1, 0]), rng.uniform(0.05, 0.3, (3, 2)) / interval[:, None]
    moments, gram = np.zeros((3, 4, 2), complex), np.zeros((3, 4, 4))
    scaling = drift, centre, units
    arguments = s.ragged, n, tables_for(cosine_window, n), interval, scaling, rank, nu, moments, gram
    fundamental.run(kernels.project, 3, arguments, 2)
    for orbit in range(3):
        j, r = np.arange(n[orbit]), rank[orbit]
        (x,) = s.array(np.array([orbit]))[:, :, : n[orbit]]
        x = (x - centre[orbit][:, None] - np.outer(drift[orbit], j)) * units[orbit][:, None]
        t = (j - (n[orbit] - 1) / 2) * interval[orbit]
        lines = np.exp(2j * np.pi * np.outer(nu[orbit, :r], t))
        w = cosine_window(int(n[orbit]))
        np.testing.assert_allclose(moments[orbit, :, :r], (x * w) @ lines.conj().T, rtol=1e-9, atol=1e-9)
        both = np.concatenate([lines, lines.conj()])
        np.testing.assert_allclose(gram[orbit, : 2 * r, : 2 * r], ((both * w) @ both.conj().T).real, atol=1e-12)


def test_aliased_harmonics_are_no_generators():
    """A line at 5 nu - rate, nu = 23: with the rate it is a harmonic, without it a frequency."""
    value, bar = np.array([23.0, 5 * 23.0 - 96.0, 7.3]), np.full(3, 1e-6)

    def found(rate):
        basis, spread, source = np.zeros(2), np.zeros(2), np.full(2, -1)
        rank = kernels.generate(value, bar, 3, 2, tables_of(2), rate, basis, spread, source)
        return list(basis[:rank])

    assert found(96.0) == [23.0, 7.3]
    assert found(1000.0) == [23.0, 19.0]


def test_weak_modes_of_a_chain_are_frequencies():
    """A mode whose share in every coordinate is a thousandth is no harmonic of others, where no combination of both is
    near a multiple of the sampling rate.
    """
    from fastaff import frequency_map
    from fastaff.analysis.frequencies.frequencies import FrequencyKind

    model = hamiltonian("(x**2 + 2.3*y**2)/2 + 0.9*x*y", coordinates="x y")
    K = np.array([[1.0, 0.9], [0.9, 2.3]])
    w2, modes = np.linalg.eigh(K)
    q = modes @ np.array([1.0, 3e-3])
    f = frequency_map(model, [*q, 0.0, 0.0], time=2000.0)
    np.testing.assert_allclose(np.sort(f.nu[:, 0]), np.sqrt(w2) / (2 * np.pi), rtol=0, atol=1e-11)
    assert f.kind[0] == FrequencyKind.INDEPENDENT
