"""Speed and frequency error of `naff` beside nafflib: 3 lines in signals of 8192 samples, times per batch.

Run: python -m pytest bench/test_naff.py --benchmark-columns=median,ops -s
"""

import time

import numpy as np
import pytest

from fastaff.analysis.frequencies.naff import naff

SAMPLES, SIGNALS, PEER_SIGNALS, ORDER = 8192, 1000, 50, 2
CASES = {  # lines in the signal, noise per sample
    "3 lines": (3, 0.0),
    "3 of 8 lines": (8, 0.0),
    "3 lines with noise": (3, 1e-3),
}


def make(case):
    """Return signals (SIGNALS, SAMPLES) and their frequencies (SIGNALS, lines), 3 bins apart or more."""
    lines, noise = CASES[case]
    rng = np.random.default_rng(1)
    gaps = rng.exponential(size=(SIGNALS, lines))
    gaps = 3 / SAMPLES + gaps / gaps.sum(1, keepdims=True) * (1 - 3 * lines / SAMPLES)
    nu = (np.cumsum(gaps, 1) + rng.random((SIGNALS, 1))) % 1.0 - 0.5
    size = 10 ** -np.linspace(0, 2, lines) * np.exp(2j * np.pi * rng.random((SIGNALS, lines)))
    signals = np.zeros((SIGNALS, SAMPLES), complex)
    for k in range(lines):
        turns = nu[:, k, None] * np.arange(SAMPLES)
        signals += size[:, k, None] * np.exp(2j * np.pi * (turns - np.rint(turns)))
    if noise:
        signals += noise * rng.normal(size=(SIGNALS, SAMPLES, 2)).view(complex)[..., 0]
    return signals, nu


def errors(found, nu):
    """Return the median and the 99 % quantile of the frequency errors of found lines, in bins."""
    d = np.abs(found[:, :, None] - nu[: len(found), None, :])
    d = np.minimum(d, 1 - d).min(2) * SAMPLES
    return float(np.nanmedian(d)), float(np.nanquantile(d, 0.99))


@pytest.mark.parametrize("case", CASES)
def test_naff_beside_nafflib(benchmark, case):
    nafflib = pytest.importorskip("nafflib")
    signals, nu = make(case)
    naff(signals[:2], 1.0, lines=3, window_order=ORDER)
    nafflib.naff(signals[0], num_harmonics=3, window_order=ORDER)
    start = time.perf_counter()
    peer = np.array([nafflib.naff(z, num_harmonics=3, window_order=ORDER)[1] for z in signals[:PEER_SIGNALS]])
    peer_time = (time.perf_counter() - start) / PEER_SIGNALS
    found = benchmark.pedantic(lambda: naff(signals, 1.0, lines=3, window_order=ORDER), rounds=3, warmup_rounds=1)
    own_time = benchmark.stats.stats.min / SIGNALS
    ours, theirs = errors(found.nu[:PEER_SIGNALS], nu), errors(peer, nu)  # of the same signals
    benchmark.extra_info.update(
        us_per_signal=1e6 * own_time,
        nafflib_us_per_signal=1e6 * peer_time,
        times_faster=peer_time / own_time,
        error_bins_median_and_99=ours,
        nafflib_error_bins_median_and_99=theirs,
    )
    print(
        f"\n{case}: naff {1e6 * own_time:.0f} us/signal, error {ours[0]:.1e} ({ours[1]:.1e} at 99 %) bins; "
        f"nafflib {1e6 * peer_time:.0f} us, {theirs[0]:.1e} ({theirs[1]:.1e}); {peer_time / own_time:.0f} times faster"
    )


@pytest.mark.parametrize("samples", [256, 2048, 32768])
def test_naff_cost_per_sample(benchmark, samples):
    signals = make("3 of 8 lines")[0].ravel()[: 1 << 20].reshape(-1, samples)
    naff(signals[:2], 1.0, lines=3)
    benchmark.pedantic(lambda: naff(signals, 1.0, lines=3), rounds=3, warmup_rounds=1)
    benchmark.extra_info["ns_per_sample"] = 1e9 * benchmark.stats.stats.min / signals.size


def test_naff_one_short_signal(benchmark):
    signal = make("3 lines")[0][0, :256]
    benchmark(naff, signal, 1.0, lines=1)
