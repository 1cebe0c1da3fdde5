"""Spectra: time with the error beside it. Run: pytest bench/test_quantum.py -s"""

import time

import numpy as np
import pytest

from fastaff import Body, Hyperelastic, NeoHookean
from fastaff.quantum.spectra.spectrum import spectrum, spectrum_table

LEVELS = 1000
"""Of each class: all with n_r, n_vartheta <= 20 are among them."""
REFERENCE = 6.9283665548532502203  # e_vartheta of (0, 0, 0), 20 digits, mu = C = hbar = 1


def test_hyperelastic_table(numbers, timed):
    """All levels of EQ2.2h with n_r, n_vartheta <= 20 of the 221 classes |m|, |l| <= 10."""
    classes = [(m, l) for m in range(-10, 11) for l in range(-10, 11) if (m + l) % 2 == 0]
    m, l = (list(side) for side in zip(*classes))

    def run():
        return spectrum_table(Body(Hyperelastic()), m=m, l=l, count=LEVELS, tolerance=1e-12)

    seconds, table = timed(run, repeats=3), run()
    inside = [(row.n <= 20).all(axis=0) for row in table]
    assert all(each.sum() == 21 * 21 for each in inside)
    numbers.update(
        classes=len(classes),
        levels=int(sum(each.sum() for each in inside)),
        seconds=seconds,
        error=max((row.error / row.E)[each].max() for row, each in zip(table, inside)),
        true_error_of_lowest=abs(table[classes.index((0, 0))].E[0] / (1 + np.sqrt(1 + 2 * REFERENCE)) - 1),
    )


@pytest.mark.parametrize("hbar", [1.0, 0.3, 0.1, 0.05])
def test_neo_hookean(numbers, hbar):
    """500 levels of (0, 0), relative error estimate below 1e-8."""
    start = time.perf_counter()
    found = spectrum(Body(NeoHookean(1.0, 2.0)), m=0, l=0, count=500, hbar=hbar, tolerance=1e-8)
    numbers.update(
        seconds=time.perf_counter() - start,
        functions=found.functions,
        error=(found.error / found.E).max(),
    )
    assert found.converged.all()


def test_twice_the_basis(numbers):
    """Quality of the estimate of the error: the change of 250 levels when the basis has twice the functions."""
    body = Body(NeoHookean(1.0, 2.0))
    found, twice = (spectrum(body, m=0, l=0, count=250, hbar=0.3, tolerance=tolerance) for tolerance in (1e-8, 1e-13))
    numbers.update(
        functions=found.functions,
        twice=twice.functions,
        change=(np.abs(found.E - twice.E) / found.E).max(),
        error=(found.error / found.E).max(),
    )
    assert twice.functions >= 2 * found.functions
