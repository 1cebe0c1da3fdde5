"""Speed and frequency error of `naff`: 3 lines in signals of 8192 samples, times per batch.

Run: python -m pytest bench/test_naff.py --benchmark-columns=median,ops -s
"""

import numpy as np
import pytest
from common import SAMPLES, SIGNALS, signals_of

from fastaff.analysis.frequencies.naff import naff


@pytest.mark.parametrize(("lines", "noise"), [(3, 0.0), (8, 0.0), (3, 1e-3)])
def test_naff(benchmark, lines, noise):
    """Three lines of three, of eight and in noise."""
    signals, nu = signals_of(lines, noise)
    found = benchmark.pedantic(lambda: naff(signals, 1.0, lines=3), rounds=3, warmup_rounds=1)
    distance = np.abs(found.nu[:, :, None] - nu[:, None, :])
    error = np.minimum(distance, 1 - distance).min(axis=2) * SAMPLES
    each = benchmark.stats.stats.min / SIGNALS
    benchmark.extra_info.update(us_per_signal=1e6 * each, error_bins=float(np.nanmedian(error)))
    print(
        f"\n3 of {lines} lines, noise {noise}: {1e6 * each:.0f} us/signal, error {np.nanmedian(error):.1e} "
        f"({np.nanquantile(error, 0.99):.1e} at 99 %) bins"
    )


@pytest.mark.parametrize("samples", [256, 2048, 32768])
def test_naff_cost_per_sample(benchmark, samples):
    signals = signals_of(8)[0].ravel()[: 1 << 20].reshape(-1, samples)
    naff(signals[:2], 1.0, lines=3)
    benchmark.pedantic(lambda: naff(signals, 1.0, lines=3), rounds=3, warmup_rounds=1)
    benchmark.extra_info["ns_per_sample"] = 1e9 * benchmark.stats.stats.min / signals.size


def test_naff_one_short_signal(benchmark):
    signal = signals_of(3)[0][0, :256]
    benchmark(naff, signal, 1.0, lines=1)
