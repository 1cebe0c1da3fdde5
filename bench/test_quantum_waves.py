"""Speed and error of product states Psi = e^(i m phi + i l psi) f_alpha f_beta beside mpmath.

Run: pytest bench/test_quantum_waves.py -s
"""

import math

import mpmath
import numpy as np
import pytest
from common import best

from fastaff import Anharmonic, Body
from fastaff.quantum.exact.wavefunction import wavefunction
from fastaff.systems.charts import ALPHA_BETA, R_VARTHETA

POINTS = 2_000_000


def exact(factor, x):
    """The factor at 80 digits by the three-term recurrence."""
    with mpmath.workdps(80 + int(factor.kappa * x * x / 4)):
        s, t = mpmath.mpf(factor.s), mpmath.mpf(factor.kappa) * mpmath.mpf(x) ** 2
        before, L = mpmath.mpf(0), mpmath.mpf(1)
        for k in range(factor.n):
            before, L = L, ((2 * k + 1 + s - t) * L - (k + s) * before) / (k + 1)
        norm = mpmath.sqrt(2 * mpmath.mpf(factor.kappa) * mpmath.factorial(factor.n) / mpmath.gamma(factor.n + s + 1))
        return float(norm * t ** (s / 2) * mpmath.exp(-t / 2) * L)


def factor_error(factor):
    """Largest error of a factor relative to its maximum, at 40 points."""
    top = math.sqrt((4 * factor.n + 2 * factor.s + 2) / factor.kappa) * 1.1
    x = np.linspace(0.01, top, 40)
    largest = np.abs(factor(np.linspace(0, top, 4000))).max()
    return float(np.abs(factor(x) - [exact(factor, value) for value in x]).max() / largest)


@pytest.mark.parametrize("n", [5, 50])
@pytest.mark.parametrize("chart", [ALPHA_BETA, R_VARTHETA], ids=lambda chart: chart.name)
def test_product_states(numbers, n, chart):
    """Points per second, and the error of the factors."""
    state = wavefunction(Body(Anharmonic()), m=2, l=-4, n=(n, n), chart=chart)
    planes = np.random.default_rng(1).normal(size=(4, POINTS)) * (1 + math.sqrt(n) / 2)
    numbers["rate"] = POINTS / best(lambda: state.planes(planes), repeats=3)
    if chart is ALPHA_BETA:
        numbers["error"] = max(factor_error(factor) for factor in state.shape.factors)
