"""Spectra: time with the error beside it. Run: python -m pytest bench/test_quantum.py --benchmark-columns=median -s"""

import resource
import time

import numpy as np
import pytest

from fastaff import Body, Hyperelastic, NeoHookean
from fastaff.quantum.spectra.spectrum import spectrum, spectrum_table

LEVELS = 1000
"""Of each class: all with n_r, n_vartheta <= 20 are among them."""
REFERENCE = 6.9283665548532502203  # e_vartheta of (0, 0, 0), 20 digits, mu = C = hbar = 1


def test_hyperelastic_table(benchmark):
    """All levels of EQ2.2h with n_r, n_vartheta <= 20 of the 221 classes |m|, |l| <= 10."""
    classes = [(m, l) for m in range(-10, 11) for l in range(-10, 11) if (m + l) % 2 == 0]
    m, l = (list(side) for side in zip(*classes))
    table = benchmark.pedantic(
        lambda: spectrum_table(Body(Hyperelastic()), m=m, l=l, count=LEVELS, tolerance=1e-12),
        rounds=3,
        warmup_rounds=1,
    )
    wanted, worst = 0, 0.0
    for row in table:
        inside = (row.n <= 20).all(axis=0)
        assert inside.sum() == 21 * 21
        wanted += int(inside.sum())
        worst = max(worst, float((row.error / row.E)[inside].max()))
    truth = abs(table[classes.index((0, 0))].E[0] / (1 + np.sqrt(1 + 2 * REFERENCE)) - 1)
    median = benchmark.stats.stats.median
    benchmark.extra_info.update(count=wanted, error=worst)
    print(f"\nEQ2.2h: {wanted} levels of {len(table)} classes in {median:.2f} s")
    print(f"largest relative error estimate {worst:.1e}, true error of the lowest level of (0, 0) {truth:.1e}")


@pytest.mark.parametrize("hbar", [1.0, 0.3, 0.1, 0.05])
def test_neo_hookean(hbar):
    """500 levels of (0, 0), relative error estimate below 1e-8."""
    start = time.perf_counter()
    found = spectrum(Body(NeoHookean(1.0, 2.0)), m=0, l=0, count=500, hbar=hbar, tolerance=1e-8)
    spent = time.perf_counter() - start
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"\nneo-Hookean, hbar {hbar}: 500 levels, {found.E[0]:.6g} to {found.E[-1]:.6g}, {spent:.1f} s, {memory:.2f} "
        "GiB"
    )
    error = found.error / found.E
    print(f"{found.functions} functions, relative error estimate {error.max():.1e} (median {np.median(error):.1e})")
    assert found.converged.all()


def test_twice_the_basis():
    """What the estimate of the error is worth: the change of 250 levels when the basis has twice the functions."""
    body = Body(NeoHookean(1.0, 2.0))
    found, twice = (spectrum(body, m=0, l=0, count=250, hbar=0.3, tolerance=tolerance) for tolerance in (1e-8, 1e-13))
    change = np.abs(found.E - twice.E) / found.E
    print(
        f"\nneo-Hookean, hbar 0.3: {found.functions} functions, then {twice.functions}: levels change by "
        f"{change.max():.1e} at most"
    )
    print(f"relative, {np.median(change):.1e} in the median; estimated {(found.error / found.E).max():.1e}")
    assert twice.functions >= 2 * found.functions
