"""Lines by harmonic inversion: beside plain NumPy, on sums of lines that are known, and on orbits of few turns."""

import numpy as np
import pytest
from scipy.linalg import eig

import fastaff as fa
from fastaff import Classification
from fastaff.frequencies.fundamental import Loops, run
from fastaff.frequencies.inverted_lines import inverted
from fastaff.frequencies.kernels import harmonic_inversion as kernels
from fastaff.frequencies.signals import signals_of
from fastaff.frequencies.windows import cosine_window

RNG = np.random.default_rng(0)
PLAIN = np.array([1.0, 1.0j])
"""The loop Q + i P of two rows."""


def loops_of(values):
    """Signals and loops of complex values (orbits, samples)."""
    rows = np.ascontiguousarray(np.stack([values.real, values.imag], axis=1))
    count = len(values)
    loops = Loops(np.tile(PLAIN, (count, 1, 1)), np.zeros((count, 1), complex), np.zeros((count, 1), complex))
    return rows, loops


def sums_of_lines(orbits, samples, others, apart):
    """Values (orbits, samples) of a line of amplitude 1 with others at least so many cycles away, and its frequency, in
    cycles per sample.
    """
    n, nu = np.arange(samples), RNG.uniform(0.1, 0.3, (orbits, 1))
    values = np.exp(2j * np.pi * (nu * n + RNG.uniform(size=(orbits, 1))))
    for _ in range(others):
        away = RNG.uniform(apart, 15.0, (orbits, 1)) * RNG.choice([-1.0, 1.0], (orbits, 1)) / samples
        size = 10 ** RNG.uniform(-6, -0.3, (orbits, 1))
        values = values + size * np.exp(2j * np.pi * ((nu + away) * n + RNG.uniform(size=(orbits, 1))))
    return values, nu


def lines_of(values, guess, basis=kernels.PEAK_BASIS):
    """Lines of the whole next to a guess, by the kernel, in bands of so many functions."""
    rows, loops = loops_of(values)
    signals = signals_of(rows, 1.0)
    begin, (count, samples) = np.zeros((len(values), 1), np.int64), values.shape
    length, weights = np.full((count, 1), samples), cosine_window(samples - 1)
    windows = kernels.Windows(begin, length, np.array([basis]), begin, weights)
    lines = kernels.Line(*np.full((4, len(values), 1, 1), np.nan))
    arguments = signals.ragged, loops, guess, signals.interval, windows, lines
    run(kernels.invert_loops, len(values), arguments, 1)
    return lines


def by_eigenvalues(values, size):
    """The eigenvalue next to 1 of the pencil of one signal, whose sums are written as they are defined, and the
    residual of its vector in U_2, in a band of so many functions.
    """
    samples = values.size
    half = (samples - 3) // 2
    angles = 2 * np.pi * kernels.SPACING * (np.arange(size) - (size - 1) / 2) / samples
    basis = np.exp(-1j * angles[:, None] * np.arange(half + 1))
    place = np.add.outer(np.arange(half + 1), np.arange(half + 1))
    pencil = [basis @ values[place + shift] @ basis.T for shift in (0, 1, 2)]
    u, vectors = eig(pencil[1], pencil[0])
    best = np.abs(u - 1).argmin()
    x = vectors[:, best]
    residual = abs(x @ pencil[2] @ x / (x @ pencil[0] @ x) - u[best] ** 2)
    return u[best], residual


@pytest.mark.parametrize("basis", [kernels.PEAK_BASIS, kernels.LINE_BASIS])
@pytest.mark.parametrize("samples", [64, 97, 200])
def test_the_kernel_finds_the_eigenvalue(samples, basis):
    """With more lines than functions, so that no direction of the pencil is empty."""
    values, nu = sums_of_lines(20, samples, basis + 4, 1.5)
    found = lines_of(values, nu.copy(), basis)
    for orbit in range(20):
        shifted = values[orbit] * np.exp(-2j * np.pi * nu[orbit] * np.arange(samples))
        u, residual = by_eigenvalues(shifted, basis)
        weights = cosine_window(samples - 1)
        mean = (weights @ shifted[1:]) / (weights @ shifted[:-1])
        assert abs(found.shift[orbit, 0, 0] - np.angle(u) / (2 * np.pi)) * samples < 1e-7
        assert abs(found.growth[orbit, 0, 0] - np.log(abs(u)) / (2 * np.pi)) * samples < 1e-7
        assert abs(found.residual[orbit, 0, 0] - residual / (4 * np.pi)) * samples < 1e-7
        assert abs(found.mean[orbit, 0, 0] - np.angle(mean) / (2 * np.pi)) * samples < 1e-7


@pytest.mark.parametrize("others", [0, 1, 3, 5])
@pytest.mark.parametrize("samples", [64, 500, 4000])
def test_lines_of_a_band_come_out_exactly(samples, others):
    """Up to rounding, wherever the guess is."""
    values, nu = sums_of_lines(200, samples, others, 1.5)
    guess = nu + RNG.uniform(-0.4, 0.4, nu.shape) / samples
    found = lines_of(values, guess)
    off = guess[:, 0] + found.shift[:, 0, 0] - nu[:, 0]
    assert np.abs(off).max() * samples < 1e-9
    assert np.median(np.abs(off)) < 1e-15


@pytest.mark.parametrize("others", [0, 4, 8, 20])
def test_errors_cover_whatever_is_in_the_band(others):
    """More lines than functions too; 99 of 100 within, none ten times beyond."""
    values, nu = sums_of_lines(600, 150, others, 1.0)
    rows, loops = loops_of(values)
    guess = nu + RNG.uniform(-0.3, 0.3, nu.shape) / 150
    found = inverted(signals_of(rows, 1.0), loops, guess, 2)
    known = found.error[:, 0] * 150 < 0.3
    ratio = np.abs(found.nu - nu)[known, 0] / (found.error[known, 0] + 1e-15)
    assert known.mean() > (0.95 if others < 8 else 0.5)
    assert (ratio <= 1).mean() >= 0.99
    assert ratio.max() < 10


def test_lines_that_are_lost_have_no_error():
    """Noise has no line, a guess far from all lines neither; the interval is that of the samples."""
    noise = RNG.normal(size=(50, 120)) + 1j * RNG.normal(size=(50, 120))
    rows, loops = loops_of(noise)
    found = inverted(signals_of(rows, 0.5), loops, np.full((50, 1), 0.3), 2)
    assert (found.error > 0.1 / (120 * 0.5)).all()
    line = np.exp(2j * np.pi * 0.2 * np.arange(120))[None]
    rows, loops = loops_of(line)
    for far in (0.2 + 5 / 120, 0.2 - 5 / 120):
        lost = inverted(signals_of(rows, 1.0), loops, np.array([[far]]), 1)
        assert abs(lost.nu[0, 0] - 0.2) <= lost.error[0, 0]


@pytest.mark.parametrize("time", [130.0, 200.0, 350.0])
def test_frequencies_of_few_turns(time):
    """Henon and Heiles at E = 0.1, whose spectra are dense, beside runs twenty times as long."""
    z0 = fa.energy_sample(fa.HenonHeiles(), energy=0.1, section="x=0", orbits=60, seed=5).z0
    truth = fa.frequency_map(fa.HenonHeiles(), z0, time=7000.0)
    brief = fa.frequency_map(fa.HenonHeiles(), z0, time=time)
    told = (truth.classification == Classification.REGULAR) & (brief.classification == Classification.REGULAR)
    assert told.sum() > 15
    # Another basis of the lattice is as true.
    span = range(-2, 3)
    k = np.array([(i, j) for i in span for j in span if abs(i) + abs(j) in (1, 2, 3)])
    lattice = np.einsum("ki,io->ko", k, truth.nu)
    off = np.abs(brief.nu[:, None] - lattice[None])[:, :, told].min(axis=1)
    ratio = off / (brief.error + 3 * truth.error.max(axis=0))[:, told]
    assert (ratio > 1).mean() <= 0.02
    assert ratio.max() < 10
    assert np.median(off) < 3e-6
