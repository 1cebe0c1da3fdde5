"""Lines of complex signals by harmonic inversion: places, amplitudes and errors against what went in."""

import numpy as np
import pytest

from fastaff.engine.jit import JIT_DISABLED
from fastaff.frequencies.plane_lines import plane_lines

MANY = 4 if JIT_DISABLED else 100


def signal_of(nu, amplitude, samples):
    """Sum the lines (signals, lines) into signals (signals, samples), phases reduced before they are rounded."""
    turns = nu[..., None] * np.arange(samples)
    return np.sum(amplitude[..., None] * np.exp(2j * np.pi * (turns - np.rint(turns))), axis=-2)


def matched(found, nu):
    """Return, for each true line nu (signals, lines), the distance to the nearest found one, its amplitude and its
    error.
    """
    apart = np.abs(found.nu[:, None, :] - nu[:, :, None])
    apart = np.minimum(apart, 1 - apart)
    index = apart.argmin(axis=2)
    return apart.min(axis=2), *(np.take_along_axis(entry, index, 1) for entry in (found.amplitude, found.error))


def drawn(rng, sizes):
    """Draw amplitudes (MANY, lines) of these sizes and any phases."""
    return np.array(sizes) * np.exp(2j * np.pi * rng.uniform(size=(MANY, len(sizes))))


@pytest.mark.parametrize("samples", [64, 100, 256, 1024])
def test_separate_lines_of_any_size_are_exact(samples):
    rng = np.random.default_rng(samples)
    nu = rng.uniform(0.1, 0.15, (MANY, 1)) + np.array([0.0, 0.13, -0.25, -0.4])
    amplitude = drawn(rng, [1.0, 0.3, 1e-3, 1e-5])
    off, size, error = matched(plane_lines(signal_of(nu, amplitude, samples), 8), nu)
    assert (off * samples * np.abs(amplitude)).max() < 1e-12
    assert (np.abs(size - amplitude)).max() < 1e-7
    assert np.quantile(off / (error + 1e-15), 0.99) < 1


@pytest.mark.parametrize("bins", [0.1, 0.5, 1.0, 2.5])
@pytest.mark.parametrize("ratio", [1.0, 1e-2, 1e-4])
def test_lines_beside_others_are_seen(bins, ratio):
    """However close, and where the weaker one makes no peak of its own."""
    samples, rng = 400, np.random.default_rng(7)
    nu = rng.uniform(-0.4, 0.4, (MANY, 1)) + np.array([0.0, bins / samples])
    amplitude = drawn(rng, [1.0, ratio])
    off, size, error = matched(plane_lines(signal_of(nu, amplitude, samples), 4), nu)
    assert np.quantile(off * samples, 0.7) < 1e-9 / ratio / bins**2
    assert np.quantile(np.abs(size / amplitude - 1), 0.7) < 1e-7 / ratio / bins**2
    assert np.quantile(off / (error + 1e-15), 0.95) < 1


def test_missing_lines_have_no_amplitude_and_an_infinite_error():
    found = plane_lines(signal_of(np.array([[0.2, -0.1]]), np.array([[1.0, 0.5]]), 200), 5)
    assert (np.abs(found.amplitude[0]) > 0).sum() == 2
    assert np.isinf(found.error[0, 2:]).all()
    assert np.isinf(plane_lines(np.zeros((2, 100)), 3).error).all()


def test_a_peak_without_a_line_is_not_sharp():
    rng = np.random.default_rng(3)
    noise = rng.normal(size=(MANY, 500)) + 1j * rng.normal(size=(MANY, 500))
    found = plane_lines(noise, 4)
    assert (np.abs(found.amplitude) > 0).all()
    assert (np.diff(np.abs(found.amplitude), axis=1) <= 0).all()
    assert np.median(found.error * 500) > 0.1
