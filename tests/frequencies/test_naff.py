"""naff: lines of synthetic signals against what went in, Laskar's theory, error bars, bitwise promises."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from fastaff.engine.jit import JIT_DISABLED
from fastaff.frequencies.naff import naff

EPS = np.finfo(float).eps
SAMPLES = 256 if JIT_DISABLED else 1024
WITH_NAN = np.r_[np.ones(5), np.nan, np.ones(58)]
MANY = 4 if JIT_DISABLED else 100


def signal_of(nu, amplitude, samples=SAMPLES, dt=1.0):
    """Sum the lines (..., lines) into signals (..., samples), phases reduced before they are rounded."""
    turns = np.asarray(nu)[..., None] * dt * np.arange(samples)
    return np.sum(np.asarray(amplitude)[..., None] * np.exp(2j * np.pi * (turns - np.rint(turns))), axis=-2)


def random_lines(rng, batch, lines, separation, smallest=0.1, samples=SAMPLES):
    """Draw frequencies at least `separation` bins apart and complex amplitudes from `smallest` to 1."""
    nu = np.empty((batch, lines))
    for row in nu:
        gaps = rng.exponential(size=lines)
        gaps = separation / samples + gaps / gaps.sum() * (1 - lines * separation / samples)
        row[:] = rng.permutation((np.cumsum(gaps) + rng.random()) % 1.0 - 0.5)
    size = 10 ** rng.uniform(np.log10(smallest), 0, (batch, lines))
    return nu, size * np.exp(2j * np.pi * rng.random((batch, lines)))


def nearest(found, true):
    """Return the distance on the circle from each true line to the nearest found, and its index."""
    d = np.abs(found[..., None, :] - true[..., :, None])
    d = np.minimum(d, 1 - d)
    return d.min(-1), d.argmin(-1)


def rounding(nu, samples=SAMPLES):
    """Bound the error of nu (cycles per sample): rounding of nu and of the phases 2 pi nu t, and of the sums."""
    return 4 * EPS * np.abs(nu) + 20 * EPS / samples


@pytest.mark.parametrize("order", [0, 1, 2, 3, 5])
@pytest.mark.parametrize("samples", [SAMPLES, SAMPLES - 1, SAMPLES // 2 + 37])
def test_separate_lines_are_exact_to_rounding(order, samples):
    nu, amplitude = random_lines(np.random.default_rng(1), MANY, 3, 5, samples=samples)
    found = naff(signal_of(nu, amplitude, samples), 1.0, lines=3, window_order=order)
    error, index = nearest(found.nu, nu)
    size = np.abs(amplitude)
    assert np.all(error <= rounding(nu, samples) / size)
    got = np.take_along_axis(found.amplitude, index, 1)
    assert np.all(np.abs(got - amplitude) <= 4 * np.pi * samples * rounding(nu, samples) + 50 * EPS)
    assert np.all(np.diff(np.abs(found.amplitude), axis=-1) <= 0)
    assert np.all(found.residual < EPS * samples)
    assert np.all(error <= 3 * np.take_along_axis(found.error, index, 1))


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@pytest.mark.parametrize("bins", [1.0, 1.5, 2.0, 3.0])
def test_close_lines_separate(order, bins):
    rng = np.random.default_rng(2)
    _, amplitude = random_lines(rng, MANY, 2, 1, smallest=0.3)
    nu = rng.uniform(-0.4, 0.4, (MANY, 1)) + np.array([0.0, bins / SAMPLES])
    found = naff(signal_of(nu, amplitude), 1.0, lines=2, window_order=order)
    error, index = nearest(found.nu, nu)
    assert np.all(error <= 10 * rounding(nu))
    assert np.all(error <= 3 * np.take_along_axis(found.error, index, 1))


def test_decreasing_amplitudes():
    nu = np.array([0.123456789, -0.301, 0.17])
    amplitude = np.array([1.0, 1e-3j, -1e-6])
    found = naff(signal_of(nu, amplitude), 1.0, lines=3)
    assert np.all(np.abs(found.nu - nu) <= rounding(nu) / np.abs(amplitude))
    assert np.all(np.abs(found.amplitude - amplitude) <= 1e-12)
    assert np.all(np.abs(found.nu - nu) <= 3 * found.error)


def test_real_signal_has_pairs_and_units_follow_dt():
    dt, t = 0.25, 0.25 * np.arange(SAMPLES)
    found = naff(1.5 + np.cos(2 * np.pi * 0.7 * t + 0.3) + 0.2 * np.sin(2 * np.pi * 1.1 * t), dt, lines=5)
    assert np.allclose(np.sort(found.nu), [-1.1, -0.7, 0, 0.7, 1.1], rtol=0, atol=1e-13)
    assert np.allclose(found.omega, 2 * np.pi * found.nu, rtol=0)
    assert abs(found.nu[0]) < 1e-13
    assert abs(found.amplitude[0] - 1.5) < 1e-12
    up = np.argmin(abs(found.nu - 0.7))
    assert abs(found.amplitude[up] - 0.5 * np.exp(0.3j)) < 1e-12


def test_missing_lines_are_zero_with_infinite_error():
    found = naff(signal_of([0.2, -0.1], [1.0, 0.5]), 1.0, lines=4)
    assert np.all(found.amplitude[2:] == 0)
    assert np.all(found.nu[2:] == 0)
    assert np.isinf(found.error[2:]).all()
    assert np.isfinite(found.error[:2]).all()
    nothing = naff(np.zeros(64), 1.0, lines=2)
    assert np.all(nothing.amplitude == 0)
    assert nothing.residual == 0


def test_dense_quasi_periodic_signal():
    samples = 2 * SAMPLES
    w2, w3 = 0.0531234, 0.0531234 * np.sqrt(2)
    i, j = (k.ravel() for k in np.mgrid[-4:5, -4:5])
    nu, size = 0.1234567 + i * w2 + j * w3, 0.25 ** (np.abs(i) + np.abs(j))
    signal = signal_of(nu - np.rint(nu), size * np.exp(1j * (i * i - 2 * j)), samples)
    errors = []
    for lines in (1, 9):
        found = naff(signal, 1.0, lines=lines, window_order=3)
        errors.append(abs(found.nu[0] - 0.1234567))
        assert errors[-1] <= found.error[0]
    assert 1e-12 / samples < errors[0] < 1e-4 / samples  # neighbours 10 bins away or more, D^-7 each
    assert errors[1] < 1e-4 / samples


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_error_bars_cover_noise(order):
    """Bars are three standard deviations: 99 % are within 1."""
    rng = np.random.default_rng(3)
    pair = rng.uniform(-0.4, 0.4, (MANY, 1)) + np.array([0.0, 1.5 / SAMPLES])
    sets = [random_lines(rng, MANY, 3, 5), (pair, random_lines(rng, MANY, 2, 1, smallest=0.3)[1])]
    for nu, amplitude in sets:
        for level in (1e-6, 1e-2 if nu.shape[1] == 3 else 1e-3):
            noise = level * rng.normal(size=(MANY, SAMPLES, 2)).view(complex)[..., 0]
            found = naff(signal_of(nu, amplitude) + noise, 1.0, lines=nu.shape[1], window_order=order)
            error, index = nearest(found.nu, nu)
            ratio = error / np.take_along_axis(found.error, index, 1)
            assert np.quantile(ratio, 0.99) < 1.0
            assert ratio.max() < 3
            assert np.median(ratio) > 0.05  # honest, not merely large


def test_error_bars_cover_lines_left_out():
    nu, amplitude = random_lines(np.random.default_rng(4), MANY, 8, 3, smallest=1e-3)
    for order in (1, 2, 3):
        found = naff(signal_of(nu, amplitude), 1.0, lines=3, window_order=order)
        error, _ = nearest(nu, found.nu)
        assert np.quantile(error / found.error, 0.98) < 2


@pytest.mark.parametrize("order", [1, 2])
def test_laskar_error_falls_like_t_to_minus_2p_plus_2(order):
    """One line fitted, its neighbour not: |error| <= (p!)^2/m2 (b/a) D^-(2p+1)/T, so T^-(2p+2)."""
    worst = []
    lengths = np.array([64, 128, 256])
    for samples in lengths:
        starts = np.linspace(0, 1, 24)
        nu = 0.1 + np.stack([0 * starts, 0.15 + starts / samples], -1)  # all phases of the tail
        found = naff(signal_of(nu, [1.0, 0.1], samples), 1.0, lines=1, window_order=order)
        worst.append(np.max(np.abs(found.nu[:, 0] - 0.1)))
        assert np.all(np.abs(found.nu[:, 0] - 0.1) <= found.error[:, 0])
    slope = np.polyfit(np.log(lengths), np.log(worst), 1)[0]
    assert slope == pytest.approx(-(2 * order + 2), abs=0.35)


def test_refit_beats_removal_one_by_one():
    signal = signal_of([0.1, 0.1 + 4 / SAMPLES], [1.0, 0.7j])
    alone = naff(signal, 1.0, lines=1)
    both = naff(signal, 1.0, lines=2)
    assert abs(alone.nu[0] - 0.1) > 1e-5 / SAMPLES
    assert abs(both.nu[0] - 0.1) < 1e-12 / SAMPLES


@pytest.mark.parametrize("order", [1, 2])
def test_naive_twin(order):
    """The strongest frequency and amplitude maximise Laskar's windowed integral, optimised by SciPy."""
    samples = 200
    rng = np.random.default_rng(5)
    signal = signal_of([0.21, -0.33, 0.05], [1, 0.3j, 0.2], samples) + 1e-3 * rng.normal(size=samples)
    t = np.arange(samples) - (samples - 1) / 2
    weight = np.prod([np.cos(2 * np.pi * t / samples) + np.cos((2 * i + 1) * np.pi / samples) for i in range(order)], 0)

    def integral(nu):
        return np.sum(weight * signal * np.exp(-2j * np.pi * nu * t)) / weight.sum()

    best = minimize(
        lambda x: -abs(integral(x[0])), [0.2101], method="Nelder-Mead", options={"xatol": 1e-13, "fatol": 0}
    )
    found = naff(signal, 1.0, lines=1, window_order=order)
    assert abs(found.nu[0] - best.x[0]) < 3e-9  # a maximum is located to sqrt(eps) bins = 1e-8/200
    at_start = integral(found.nu[0]) * np.exp(2j * np.pi * found.nu[0] * t[0])
    assert abs(found.amplitude[0] - at_start) < 1e-12


FIELDS = ("nu", "amplitude", "error", "residual")


def test_scale_does_not_matter():
    signal = signal_of([0.2, -0.1], [1.0, 0.5])
    plain = naff(signal, 1.0, lines=2)
    for power in (-1000, -40, 900):
        scaled = naff(np.ldexp(signal.view(float), power).view(complex), 1.0, lines=2)
        assert np.array_equal(scaled.nu, plain.nu)
        assert np.array_equal(scaled.amplitude.view(float), np.ldexp(plain.amplitude.view(float), power))


@settings(max_examples=5 if JIT_DISABLED else 40, deadline=None)
@given(
    shift=st.floats(-0.5, 0.5),
    start=st.floats(-0.5, 0.5),
    bins=st.floats(1.5, 100),
    ratio=st.floats(0.01, 1),
    order=st.integers(0, 4),
)
def test_shift_of_frequency_is_a_phase(shift, start, bins, ratio, order):
    nu = np.array([start, start + bins / 256])
    signal = signal_of(nu, [1.0, ratio * 1j], 256)
    moved = signal * np.exp(2j * np.pi * shift * np.arange(256))
    for found, true in (
        (naff(signal, 1.0, lines=2, window_order=order), nu),
        (naff(moved, 1.0, lines=2, window_order=order), nu + shift),
    ):
        true = true - np.rint(true)
        error, _ = nearest(found.nu, true)
        assert np.all(error <= 200 * EPS / ratio)
        assert np.all((found.nu >= -0.5) & (found.nu <= 0.5))


@pytest.mark.parametrize(
    ("kind", "words", "change"),
    [
        (TypeError, "signal must be", {"signal": np.array(["a"] * 64)}),
        (TypeError, "signal must be", {"signal": np.ones(64, bool)}),
        (ValueError, "signal must have shape", {"signal": 1.0}),
        (ValueError, "signal must be finite, got .*nan.* at sample 5 of signal 0", {"signal": WITH_NAN}),
        (ValueError, "signal must be finite", {"signal": np.r_[np.inf, np.ones(63)]}),
        (ValueError, "at least 4.*= 12 samples, got 11", {"signal": np.ones(11)}),
        (ValueError, "dt must be positive", {"dt": 0.0}),
        (ValueError, "dt must be finite", {"dt": float("nan")}),
        (TypeError, "dt must be a real", {"dt": "1"}),
        (ValueError, "lines must be at least 1, got 0", {"lines": 0}),
        (TypeError, "lines must be a whole number, got 1.5", {"lines": 1.5}),
        (ValueError, "window_order must be at least 0, got -1", {"window_order": -1}),
        (ValueError, "window_order must be at most 12, got 13", {"window_order": 13}),
        (TypeError, "window_order must be a whole number, got 2.0", {"window_order": 2.0}),
        (TypeError, "window_order must be a whole number, got True", {"window_order": True}),
    ],
)
def test_bad_input(kind, words, change):
    arguments = {"signal": np.ones(64), "dt": 1.0, "lines": 1, "window_order": 2} | change
    with pytest.raises(kind, match=words):
        naff(arguments.pop("signal"), arguments.pop("dt"), **arguments)
