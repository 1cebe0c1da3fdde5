"""Speed and error of product states Psi = e^(i m phi + i l psi) f_alpha f_beta beside SciPy and mpmath.

Run: python -m pytest bench/test_quantum_waves.py --benchmark-columns=median,ops -s
"""

import math

import mpmath
import numpy as np
import pytest
from common import best
from scipy.special import eval_genlaguerre

from fastaff import Anharmonic, Body
from fastaff.charts import ALPHA_BETA, R_VARTHETA
from fastaff.quantum.exact.wavefunction import wavefunction
from fastaff.quantum.packets.packet import Packet
from fastaff.quantum.states.factors import PlaneFactor

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


@pytest.mark.parametrize("chart", [ALPHA_BETA, R_VARTHETA], ids=lambda chart: chart.name)
@pytest.mark.parametrize("n", [0, 5, 10, 50, 200])
def test_product_states(benchmark, n, chart):
    state = wavefunction(Body(Anharmonic()), m=2, l=-4, n=(n, n), chart=chart)
    planes = np.random.default_rng(1).normal(size=(4, POINTS)) * (1 + math.sqrt(n) / 2)
    benchmark.pedantic(lambda: state.planes(planes), rounds=3, warmup_rounds=1)
    rate = POINTS / benchmark.stats.stats.min / 1e6
    error = max(factor_error(f) for f in state.shape.factors) if chart is ALPHA_BETA else float("nan")
    benchmark.extra_info.update(million_points_per_second=rate, error_of_the_maximum=error)
    print(f"\n{chart.name}, n = ({n}, {n}): {rate:.1f} million points/s, error {error:.1e} of the maximum")


def test_autocorrelation(benchmark):
    """A packet of 200 states at 10^6 times, beside mpmath at some of them."""
    states = [wavefunction(Body(Anharmonic()), m=0, l=0, n=(k, 0)) for k in range(200)]
    rng = np.random.default_rng(1)
    packet = Packet(states, np.sort(rng.uniform(0, 100, 200)), rng.normal(size=200) / math.sqrt(200), 1.0)
    times = np.linspace(0, 1e4, 1_000_000)
    A = benchmark.pedantic(lambda: packet.autocorrelation(times), rounds=3, warmup_rounds=1)
    some = rng.integers(0, times.size, 20)
    levels = [(w, mpmath.mpf(E)) for w, E in zip(packet.weights, packet.energies)]
    exact = [complex(sum(w * mpmath.expj(-E * mpmath.mpf(times[i])) for w, E in levels)) for i in some]
    error = float(np.abs(A[some] - exact).max())
    benchmark.extra_info.update(error=error)
    print(f"\n10^6 times x 200 states: {benchmark.stats.stats.min:.2f} s, error {error:.1e} of 1 at phases up to 10^6")


@pytest.mark.parametrize("n", [10, 200])
def test_factor_beside_scipy(benchmark, n):
    """eval_genlaguerre with an integer n, times its weight; beyond n of some hundreds its polynomials overflow before
    the weight.
    """
    factor = PlaneFactor(n, 3.5, 1.0)
    x = np.random.default_rng(1).uniform(0, math.sqrt(4 * n + 10), POINTS // 10)
    log_norm = (math.log(2) + math.lgamma(n + 1) - math.lgamma(n + 4.5)) / 2

    def scipy_factor(x):
        t = x * x
        return np.exp(log_norm - t / 2) * t**1.75 * eval_genlaguerre(n, 3.5, t)

    benchmark.pedantic(lambda: factor(x), rounds=3, warmup_rounds=1)
    theirs = best(lambda: scipy_factor(x), repeats=3)
    ours = benchmark.stats.stats.min
    top = np.abs(factor(x)).max()
    points = x[:40]
    truth = np.array([exact(factor, value) for value in points])
    errors = [float(np.abs(values - truth).max() / top) for values in (factor(points), scipy_factor(points))]
    benchmark.extra_info.update(times_faster=theirs / ours, errors_ours_and_scipy=errors)
    rate = x.size / ours / 1e6
    print(
        f"\nn = {n}: {rate:.1f} million points/s, error {errors[0]:.1e}; scipy {theirs / ours:.1f} times slower, "
        f"{errors[1]:.1e}"
    )
