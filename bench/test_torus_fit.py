"""Fitted tori: seconds per orbit beside the errors of frequencies and actions. Run: pytest bench/test_torus_fit.py
-s
"""

from __future__ import annotations

import naive
import numpy as np
import pytest

from fastaff import Body, HeavyTop, HenonHeiles, Hyperelastic, NeoHookean, fit_torus
from fastaff.charts import from_matrix

POINTS = (
    (((1.3, 0.2), (-0.1, 0.8)), ((0.3, -0.4), (0.5, 0.2))),
    (((1.0, 0.5), (-0.3, 1.4)), ((-0.2, 0.6), (0.1, -0.5))),
    (((1.7, -0.2), (0.5, 0.8)), ((0.2, -0.9), (-0.3, -0.4))),
)

SEPARABLE = [(Hyperelastic(), 0), (Hyperelastic(), 2), (HeavyTop(1.0, 0.5), 1)]


@pytest.mark.parametrize("time", [300.0, 1000.0])
@pytest.mark.parametrize(("potential", "i"), SEPARABLE, ids=[f"{type(p).__name__}-{i}" for p, i in SEPARABLE])
def test_separable(benchmark, potential, i, time):
    """One orbit over `time` (about 0.3 to 0.5 times as many periods); truth by quadrature."""
    body, z = Body(potential), from_matrix(*map(np.array, POINTS[i]))
    fit = benchmark.pedantic(fit_torus, args=(body, z), kwargs={"time": time}, rounds=1, warmup_rounds=1)
    nu = np.abs(fit.nu - naive.frequencies(body, z[:, None])[:, 0]).max()
    J = np.abs(fit.J / naive.r_vartheta_actions(body, z) - 1).max()
    benchmark.extra_info.update(nu_error=nu, J_error=J)
    print(
        f"\n{type(potential).__name__} {i}, time {time:.0f}: {benchmark.stats['min']:.2f} s, {len(fit.k)} terms of "
        f"order {fit.order}; "
        f"error of nu {nu:.0e}, of J (relative) {J:.0e}, residual {fit.residual:.0e}, prediction "
        f"{fit.prediction_error:.0e}"
    )


@pytest.mark.parametrize("i", [0, 1])
def test_neo_hookean(benchmark, i):
    """No separation; p_eta and p_gamma are two of the actions."""
    body, z = Body(NeoHookean()), from_matrix(*map(np.array, POINTS[i]))
    fit = benchmark.pedantic(fit_torus, args=(body, z), kwargs={"time": 1000.0}, rounds=1, warmup_rounds=1)
    error = np.abs(fit.I[2:] - naive.constants(body, z)[1:]).max()
    benchmark.extra_info.update(I_error=error)
    print(
        f"\nneo-Hookean {i}: {benchmark.stats['min']:.2f} s, {len(fit.k)} terms of order {fit.order}; "
        f"error of I_eta, I_gamma {error:.0e}, residual {fit.residual:.0e}, prediction {fit.prediction_error:.0e}"
    )


def test_henon_heiles(benchmark):
    """A regular orbit and a chaotic one of two degrees of freedom."""
    regular, chaotic = [0.1, -0.05, 0.12081, 0.1], [0.0, -0.25, 0.42081, 0.0]
    fit = benchmark.pedantic(
        fit_torus, args=(HenonHeiles(), regular), kwargs={"time": 600.0}, rounds=3, warmup_rounds=1
    )
    print(
        f"\nHenon-Heiles: {benchmark.stats['min']:.2f} s; "
        f"{fit.summary()}\n{fit_torus(HenonHeiles(), chaotic, time=600.0).summary()}"
    )
