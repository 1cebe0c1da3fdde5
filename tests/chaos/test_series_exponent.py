"""Exponents of measured series: known ones within their errors, at any sampling, and none for series without chaos."""

import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff.chaos import series_exponent
from fastaff.core.classification import Classification

LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
ROESSLER = fa.ode("x' = -y - z; y' = x + a*y; z' = b + z*(x - c)", a=0.2, b=0.2, c=5.7)


def of_flow(model, start, row):
    def made(rng, samples, dt):
        z = fa.integrate(model, rng.normal(size=3) + start, time=100.0, rtol=1e-9, atol=1e-9).z
        run = fa.integrate(model, z, time=samples * dt, samples=samples, rtol=1e-9, atol=1e-9)
        return run.samples[:, row, 0]

    return made


def of_henon(rng, samples, dt):
    return fa.integrate(shared_systems.henon(), rng.uniform(-0.1, 0.1, 2), time=samples, samples=samples).samples[
        :, 0, 0
    ]


def of_logistic(rng, samples, dt):
    x = np.empty(samples)
    x[0] = rng.uniform(0.1, 0.9)
    for k in range(samples - 1):
        x[k + 1] = 4 * x[k] * (1 - x[k])
    assert np.ptp(x[-50:]) > 0
    return x


KNOWN = {
    "Lorenz x": (of_flow(LORENZ, [0, 0, 20], 0), 0.9056, (0.02, 0.06), (5000, 12000)),
    "Lorenz z": (of_flow(LORENZ, [0, 0, 20], 2), 0.9056, (0.02, 0.06), (4000, 12000)),
    "Roessler": (of_flow(ROESSLER, [1, 1, 1], 0), 0.0714, (0.1, 0.3), (5000, 12000)),
    "Henon": (of_henon, 0.4192, (1.0, 1.0), (1000, 8000)),
    "logistic": (of_logistic, np.log(2), (1.0, 1.0), (1000, 8000)),
}
"""Series, their exponents (Sprott 2003, Chaos and Time-Series Analysis, appendix A), intervals and lengths."""


@pytest.mark.parametrize("name", KNOWN)
def test_known_exponents_within_their_errors(name):
    made, true, (finest, coarsest), (least, most) = KNOWN[name]
    rng = np.random.default_rng(11)
    ratios, errors = [], []
    for _ in range(5):
        dt = float(np.exp(rng.uniform(np.log(finest), np.log(coarsest))))
        x = made(rng, int(rng.integers(least, most)), dt)
        unit, shift = 10.0 ** rng.uniform(-6, 6), rng.normal()
        found = series_exponent(unit * (x + shift), dt)
        ratios.append(abs(found.exponent - true) / found.error)
        errors.append(found.error / true)
    assert np.isfinite(errors).all()
    assert max(ratios) <= 1
    assert np.median(errors) < 0.6


def test_maps_at_random_parameters_by_their_derivative():
    """Systems that no constant was chosen for: x -> a sin(pi x) and x -> 1 - a |x|^b; exponent: mean of ln|f'|."""
    rng = np.random.default_rng(4)
    ratios = []
    while len(ratios) < 10:
        if len(ratios) % 2:
            a = rng.uniform(0.9, 1.0)
            f, slope = lambda x, a=a: a * np.sin(np.pi * x), lambda x, a=a: a * np.pi * np.cos(np.pi * x)
        else:
            a, b = rng.uniform(1.6, 1.9), rng.uniform(1.2, 2.0)
            f = lambda x, a=a, b=b: 1 - a * abs(x) ** b  # noqa: E731
            slope = lambda x, a=a, b=b: a * b * np.abs(x) ** (b - 1)  # noqa: E731
        x = np.empty(4000)
        x[0] = rng.uniform(0.1, 0.4)
        for k in range(3999):
            x[k + 1] = f(x[k])
        x = x[200:]
        true = np.log(np.abs(slope(x))).mean()
        if true < 0.2:
            continue
        found = series_exponent(x)
        ratios.append(abs(found.exponent - true) / found.error if np.isfinite(found.error) else 0.0)
    assert max(ratios) <= 1
    assert np.count_nonzero(ratios) >= 8


def test_noise_of_a_percent_and_other_delays():
    rng = np.random.default_rng(2)
    for _ in range(4):
        x = of_flow(LORENZ, [0, 0, 20], 0)(rng, 6000, 0.03)
        noisy = x + 0.01 * x.std() * rng.normal(size=x.size)
        found = series_exponent(noisy, 0.03, dimension=int(rng.integers(3, 6)), lag=int(rng.integers(4, 9)))
        assert not abs(found.exponent - 0.9056) > found.error


@pytest.mark.parametrize("kind", ["quasi-periodic", "periodic", "cycle", "white", "correlated", "surrogate"])
def test_series_without_chaos_are_undecided(kind):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        t = 0.1 * np.arange(4000)
        e = rng.normal(size=4000)
        if kind == "quasi-periodic":
            x = np.cos(t) + rng.uniform(0.2, 1) * np.cos(rng.uniform(0.3, 3) * t)
        elif kind == "periodic":
            x = np.cos(t) + 1e-3 * e
        elif kind == "cycle":
            x = np.tile([0.1, 0.7, 0.4, 0.9], 1000)
        elif kind == "white":
            x = e
        elif kind == "correlated":
            x = np.zeros(4000)
            for k in range(1, 4000):
                x[k] = 0.95 * x[k - 1] + e[k]
        else:  # the spectrum of a chaotic series with random phases
            lines = np.fft.rfft(of_flow(LORENZ, [0, 0, 20], 0)(rng, 4000, 0.05))
            x = np.fft.irfft(np.abs(lines) * np.exp(2j * np.pi * rng.uniform(size=lines.size)) * (lines != lines[0]))
        found = series_exponent(x, 0.1)
        assert found.classification == Classification.UNDECIDED
        assert np.isnan(found.exponent) or abs(found.exponent) <= found.error


def test_the_divergence_rises_by_the_exponent(tmp_path):
    x = of_henon(np.random.default_rng(3), 6000, 1.0)
    found = series_exponent(x)
    inside = (found.time >= found.fitted[0]) & (found.time <= found.fitted[1] - 5)
    slopes = np.polyfit(found.time[inside], found.divergence[:, inside].T, 1)[0]
    np.testing.assert_allclose(slopes, 0.4192, atol=0.03)
    assert "CHAOTIC: exponent 0.4" in found.summary()
    again = fa.load(fa.save(tmp_path / "exponent", found))
    np.testing.assert_array_equal(again.divergence, found.divergence)
    np.testing.assert_array_equal(series_exponent(x).divergence, found.divergence)


X = np.random.default_rng(0).normal(size=600)


@pytest.mark.parametrize(
    ("given", "kind", "message"),
    [
        ({"series": X[:400]}, ValueError, "series must have at least 500 samples, got 400"),
        ({"series": np.stack([X, X])}, ValueError, r"series must have shape \(samples,\), got \(2, 600\)"),
        ({"series": np.where(X > 2, np.nan, X)}, ValueError, "series must be finite, got nan at sample"),
        ({"series": np.ones(600)}, ValueError, "series must change, got 1 everywhere"),
        ({"series": ["a"] * 600}, TypeError, "series must be an array of real numbers"),
        ({"dt": 0.0}, ValueError, "dt must be positive"),
        ({"dimension": 0}, ValueError, "dimension must be at least 1"),
        ({"lag": 0}, ValueError, "lag must be at least 1"),
        ({"separation": 1.5}, TypeError, "separation must be a whole number"),
        ({"separation": 400}, ValueError, "series is too short for"),
        ({"lag": 200}, ValueError, "series is too short for"),
    ],
)
def test_wrong_input(given, kind, message):
    with pytest.raises(kind, match=message):
        series_exponent(**{"series": X, **given})
