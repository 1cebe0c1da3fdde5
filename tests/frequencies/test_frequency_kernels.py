"""Kernels of frequencies against plain NumPy: rows that runs write, transforms, peaks, lines of bands, generators."""

import numpy as np
import pytest
import shared_systems
from scipy.linalg import eigvals

from fastaff import Body, HenonHeiles, NeoHookean
from fastaff.frequencies import fundamental
from fastaff.frequencies.classify import SEEN, unresolved_modulations
from fastaff.frequencies.frequency_map import FrequencyWork, checked_signals
from fastaff.frequencies.fundamental import Loops, tables_of
from fastaff.frequencies.inverted_lines import inverted
from fastaff.frequencies.kernels import dual_loops, harmonic_inversion, loop_lines, spectrum_lines
from fastaff.frequencies.kernels import fundamental as kernels
from fastaff.frequencies.signals import ReusableBuffer, Signals, signals_of
from fastaff.frequencies.windows import APART_ORDER, BRIEF, apart_window, cosine_window, tables_for
from fastaff.runs.options import Options, plan


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
    work = FrequencyWork(flow, checked_signals(None, body), z0, 9.0, None, None, None)
    found, run = work._sampled(work.flow, np.arange(41), 9.0, counts, ReusableBuffer())
    assert (run.status == 0).all()
    for orbit in range(41):
        (s,), n = found.array(np.array([orbit])), int(counts[orbit])
        ensemble = flow.of(np.array([orbit])).ensemble(z0[:, [orbit]].copy())
        (states,) = flow.of(np.array([orbit])).sampled(ensemble, n, time=9.0)
        table = work.layout.signals(states[None], 1, ReusableBuffer())[0]
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


def test_transforms_are_those_of_plain_sums():
    """Windowed loops without growth and mean, in units of their sizes; and the sums of both halves, plain and ramped,
    over as many samples as a matrix has.
    """
    rng = np.random.default_rng(1)
    s = ragged(rng, 4, [60, 96, 61])
    s.numbers[:] += 3.0
    for orbit, n in ((0, 60), (1, 96), (2, 60)):  # a row that grows
        first = s.start[orbit]
        s.numbers[first : first + n] = 0.7 * np.arange(n) + 0.1 * np.sin(np.arange(n))
    spectra, bands = fundamental._transforms(s, 2, 2)
    drift, centre, size, moving = spectra.rows
    assert moving.all()
    np.testing.assert_array_equal(spectra.n, [60, 96, 60])
    np.testing.assert_allclose(drift[:, 0], 0.7, rtol=1e-2)
    for orbit, n in ((0, 60), (1, 96), (2, 60)):
        x = s.array(np.array([orbit]))[0, :, :n] - drift[orbit][:, None] * np.arange(n)
        mean = x @ cosine_window(n)
        x = x - mean[:, None]
        rms = np.sqrt((x**2) @ cosine_window(n))
        np.testing.assert_allclose(centre[orbit], mean, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(size[orbit], rms, rtol=1e-9)
        loops = x[0::2] / rms[0::2, None] - 1j * x[1::2] / rms[1::2, None]
        own = spectra.numbers[spectra.start[orbit] :][: 2 * n].reshape(2, n)
        np.testing.assert_allclose(own, np.fft.fft(loops * apart_window(n)), rtol=0, atol=1e-9)
        half, width = (n - 3) // 2, int(bands.size[orbit])
        one, other = loops[:, : half + 1], loops[:, half + 1 : 2 * half + 1]
        parts = one, np.arange(1, half + 2) * one, other, (half - np.arange(half)) * other
        own = bands.numbers[bands.start[orbit] :][: 8 * width].reshape(2, 4, width)
        expected = np.stack([np.fft.fft(part, width) for part in parts], axis=1)
        np.testing.assert_allclose(own, expected, rtol=0, atol=1e-8)
        np.testing.assert_allclose(bands.edges[orbit, :, 0], loops[:, [0, half + 1, 2 * half + 1]], atol=1e-9)
        np.testing.assert_allclose(bands.edges[orbit, :, 1], loops[:, [1, half + 2, 2 * half + 2]], atol=1e-9)


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
    count, rest = spectrum_lines.find_peaks(spectrum, APART_ORDER, 1e-6, 3, place, size, error)
    assert count == 3
    off = (place - u + n / 2) % n - n / 2
    assert (np.abs(off) < [1e-4, 1e-4, 1e-2]).all()
    assert (np.abs(off) <= error + 1e-9).all()
    np.testing.assert_allclose(size, np.abs(amplitude), rtol=1e-2)
    assert rest < 0.01


def transforms_of(f):
    """The windowed transform (n,), the transforms of the sums (4, size) and the edges of one complex signal."""
    n = f.size
    size, half = int(fundamental.band_sizes(np.array([n]))[0]), (n - 3) // 2
    one, other = f[: half + 1], f[half + 1 : 2 * half + 1]
    parts = one, np.arange(1, half + 2) * one, other, (half - np.arange(half)) * other
    edges = np.array([f[[p, p + half + 1, p + 2 * half + 1]] for p in (0, 1)])
    return np.fft.fft(f * apart_window(n)), np.array([np.fft.fft(part, size) for part in parts]), edges


def pencil(f, z):
    """U_0, U_1 and U_2 of a signal in the functions z, as double sums."""
    half = (f.size - 3) // 2
    j = np.arange(half + 1)
    powers = z[:, None] ** j
    return [powers @ f[np.add.outer(j, j) + p] @ powers.T for p in range(3)]


def lines_of_loop(f, split):
    """Places, sizes and error bars of the lines of a signal's peaks, and of those beside the first `split` of them."""
    (spectrum, *sums), n = transforms_of(f), f.size
    lines, band = loop_lines.LoopLines(*np.zeros((4, 16))), harmonic_inversion.new_band(harmonic_inversion.PEAK_BASIS)
    first = lines.place[:6], lines.size[:6], lines.doubt[:6]
    peaks, _ = spectrum_lines.find_peaks(spectrum, APART_ORDER, 1e-6, 6, *first)
    loop_lines.signed_places(lines, peaks, n)
    loop_lines.read_peaks(*sums, n, 0, peaks, lines, band)
    split = min(split, peaks)
    count = loop_lines.split_peaks(*sums, n, APART_ORDER, split, peaks, 1e-3, lines, peaks, band)
    return lines.place[:count], lines.size[:count], lines.bar[:count]


@pytest.mark.parametrize("n", [64, 97, 240])
def test_matrices_of_a_band_are_double_sums(n):
    """From the transforms of the sums, at any place, across frequency 0 too; noise keeps them of full rank."""
    rng = np.random.default_rng(n)
    f = rng.normal(size=n) + 1j * rng.normal(size=n)
    _, sums, edges = transforms_of(f)
    band = harmonic_inversion.new_band(harmonic_inversion.PEAK_BASIS)
    for guess in (*rng.uniform(-0.5, 0.5, 3), 0.0, 0.499):
        loop_lines.open_band(sums, edges, n, guess, band)
        off = -np.angle(band.z) / (2 * np.pi) - guess
        assert (np.abs(off - np.rint(off)) * n <= (harmonic_inversion.PEAK_BASIS // 2 + 0.5) * n / sums.shape[1]).all()
        expected = pencil(f, band.z)
        np.testing.assert_allclose(band.overlaps, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        # The line next to each eigenvalue, started there.
        for u in eigvals(expected[1], expected[0]):
            band.x[:] = rng.normal(size=harmonic_inversion.PEAK_BASIS)
            found, norm = harmonic_inversion.converge(band, 0, u, 1e-12)
            assert abs(found - u) < 1e-8
            assert abs(norm) > 0


@pytest.mark.parametrize("n", [96, 200, 1024, 1544])
def test_lines_of_a_loop_are_exact(n):
    """Lines apart, the band of each holding all of them or few, down to 1e-5 of the largest."""
    rng = np.random.default_rng(n)
    u = np.array([-25.3, 11.0, 31.7]) + rng.uniform(-0.5, 0.5, 3)
    size = np.array([1.0, 0.4, 1e-5])
    f = np.exp(2j * np.pi * np.outer(np.arange(n) / n, u)) @ (size * np.exp(2j * np.pi * rng.uniform(size=3)))
    place, found, bar = lines_of_loop(f, 0)
    assert (np.abs((place[:3] - u + n / 2) % n - n / 2) < [1e-11, 1e-11, 1e-7]).all()
    assert (np.abs(found[:3] / size - 1) < [1e-6, 1e-6, 1e-2]).all()
    assert (bar[:3] < 1e-4).all()
    assert (found[3:] < 1e-5).all()


@pytest.mark.parametrize("distance", [0.7, 1.0, 1.6])
def test_lines_within_a_peak_are_told_apart(distance):
    """Two lines closer than the width of a peak: one peak, whose band has both, where they are asked for."""
    rng = np.random.default_rng(9)
    for _ in range(20):
        n, middle = int(rng.integers(150, 900)), rng.uniform(20, 40)
        u = middle + np.array([0.0, distance])
        phase = np.exp(2j * np.pi * rng.uniform(size=2))
        f = np.exp(2j * np.pi * np.outer(np.arange(n) / n, u)) @ (np.array([1.0, 0.3]) * phase)
        place, size, _ = lines_of_loop(f, 6)
        for where, amplitude in zip(u, (1.0, 0.3), strict=True):
            assert np.abs(place - where).min() < 1e-8
            assert size[np.abs(place - where).argmin()] == pytest.approx(amplitude, rel=loop_lines.STEADY)


def test_lines_of_a_lattice_have_its_generators():
    """Orbits of two loops with the lines k . nu of two frequencies: a basis of the lattice that they span."""
    rng = np.random.default_rng(10)
    n, k = 600, np.array([(1, 0), (0, 1), (2, -1), (1, 1), (3, 0), (1, -2)])
    nu = np.array([rng.uniform(0.05, 0.08, 20), rng.uniform(0.09, 0.12, 20)])
    t, lines = np.arange(n), np.exp(2j * np.pi * rng.uniform(size=(20, 6, 2)))
    size = np.array([[1.0, 0.2], [0.1, 0.9], [0.05, 0.0], [0.02, 0.04], [0.0, 0.03], [0.01, 0.01]])
    turns = np.einsum("ki,io->ok", k, nu)
    f = np.einsum("okj,okn->ojn", lines * size, np.exp(2j * np.pi * turns[:, :, None] * t))
    s = np.stack([f.real, -f.imag], axis=2).reshape(20, 4, n)
    found = fundamental.modes(signals_of(s, 1.0), 2, 2)
    assert (found.rank == 2).all()
    assert (found.unexplained_size == 0).all()
    np.testing.assert_allclose(np.sort(found.nu, axis=1), nu.T, rtol=0, atol=1e-10)


def test_a_line_alone_is_exact():
    rng = np.random.default_rng(6)
    n, nu, dt = 333, rng.uniform(0.05, 0.2, 20), 0.7
    t = dt * np.arange(n)
    x = np.stack([np.cos(2 * np.pi * nu[:, None] * t), -np.sin(2 * np.pi * nu[:, None] * t)], axis=1)
    loops = Loops(np.tile([1.0, -1j], (20, 1, 1)), np.zeros((20, 1), complex), np.zeros((20, 1), complex))
    found = inverted(signals_of(x, dt), loops, nu[:, None] * (1 + 1e-4), 1)
    for value in (found.nu[:, 0], *found.halves[:, 0].T):
        np.testing.assert_allclose(value, nu, rtol=0, atol=1e-14)
    assert (found.error < 1e-11).all()


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


def test_dual_rows_have_one_line_each():
    """Amplitudes by weighted least squares, rows dual to them, and shares; signals of different lengths, without their
    growth and mean, in units of their sizes.
    """
    rng = np.random.default_rng(8)
    s = ragged(rng, 4, [90, 200, 130])
    n, interval = np.array([90, 192, 125]), s.interval
    drift, centre, units = rng.normal(size=(3, 3, 4))
    rank, nu = np.array([2, 1, 0]), rng.uniform(0.05, 0.3, (3, 2)) / interval[:, None]
    found = dual_loops.Duals(np.zeros((3, 4, 4), complex), np.zeros((3, 2, 4), complex), np.zeros((3, 2, 2)))
    amplitude, dual, share = found
    scaling = drift, centre, units
    arguments = s.ragged, n, tables_for(cosine_window, n), interval, scaling, rank, nu, found
    fundamental.run(dual_loops.dual_loops, 3, arguments, 2)
    for orbit in range(3):
        j, r = np.arange(n[orbit]), rank[orbit]
        (x,) = s.array(np.array([orbit]))[:, :, : n[orbit]]
        x = (x - centre[orbit][:, None] - np.outer(drift[orbit], j)) * units[orbit][:, None]
        t = (j - (n[orbit] - 1) / 2) * interval[orbit]
        lines = np.exp(2j * np.pi * np.outer(nu[orbit, :r], t))
        both, root = np.concatenate([lines, lines.conj()]), np.sqrt(cosine_window(int(n[orbit])))
        own = np.linalg.lstsq((both * root).T, (x * root).T, rcond=None)[0]
        np.testing.assert_allclose(amplitude[orbit, : 2 * r], own, rtol=1e-9, atol=1e-9)
        rows = np.linalg.pinv(own.T)[:r] if r else own[:0]
        np.testing.assert_allclose(dual[orbit, :r], rows, rtol=1e-7, atol=1e-9 * np.abs(rows).max(initial=1.0))
        size = np.abs(own[:r])
        np.testing.assert_allclose(share[orbit, :r], size[:, ::2] * size[:, 1::2], rtol=1e-9)
        for rest in (amplitude[orbit, 2 * r :], dual[orbit, r:], share[orbit, r:]):
            assert not rest.any()


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
    from fastaff import Classification, frequency_map

    model = shared_systems.plane(1, 2.3, ab=0.9)
    K = np.array([[1.0, 0.9], [0.9, 2.3]])
    w2, modes = np.linalg.eigh(K)
    q = modes @ np.array([1.0, 3e-3])
    f = frequency_map(model, [*q, 0.0, 0.0], time=2000.0)
    np.testing.assert_allclose(np.sort(f.nu[:, 0]), np.sqrt(w2) / (2 * np.pi), rtol=0, atol=1e-11)
    assert f.classification[0] == Classification.REGULAR


@pytest.mark.parametrize(("m", "longest"), [(2, 96), (3, 16)])
def test_modulations_are_bounds_over_all_slow_combinations(m, longest):
    """Of 40 frequency vectors at random, some of which are unknown, with one long resonance."""
    rng = np.random.default_rng(m)
    nu = rng.uniform(0.1, 0.3, (40, m))
    nu[:, 1] = (9 + rng.uniform(-1e-3, 1e-3, 40)) / 11 * nu[:, 0] if m == 2 else nu[:, 1]
    nu[::7, 0] = np.nan
    error = 10 ** rng.uniform(-9, -3, (40, m))
    time = rng.uniform(100.0, 1000.0, 40)
    k = np.stack(np.meshgrid(*[np.arange(-longest, longest + 1)] * m, indexing="ij"), axis=-1).reshape(-1, m)
    size = np.abs(k).sum(axis=1)
    k = k[(size > 1) & (size <= longest) & (np.gcd.reduce(k, axis=1) == 1)]
    expected = np.zeros((40, m))
    for orbit in range(40):
        with_nan = np.where(k != 0, k * nu[orbit], 0.0).sum(axis=1)
        for v in np.flatnonzero(np.abs(with_nan) * time[orbit] < 1):
            cycles = abs(with_nan[v]) * time[orbit]
            own = k[v] != 0
            windows = SEEN * error[orbit, own] / cycles**2
            rate = cycles / np.abs(k[v, own]) / time[orbit]
            expected[orbit, own] = np.maximum(expected[orbit, own], np.minimum(windows, rate))
    assert np.count_nonzero(expected) > 20
    found = unresolved_modulations(nu, error, time, 1)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
