"""Fitted tori: seconds per orbit beside the errors of frequencies and actions. Run: pytest bench/test_torus_fit.py
-s
"""

from __future__ import annotations

import naive
import numpy as np
import pytest
from common import best

import fastaff
from fastaff import Body, HeavyTop, HenonHeiles, Hyperelastic, NeoHookean, fit_torus
from fastaff.systems.charts import from_matrix

POINTS = (
    (((1.3, 0.2), (-0.1, 0.8)), ((0.3, -0.4), (0.5, 0.2))),
    (((1.0, 0.5), (-0.3, 1.4)), ((-0.2, 0.6), (0.1, -0.5))),
    (((1.7, -0.2), (0.5, 0.8)), ((0.2, -0.9), (-0.3, -0.4))),
)

SEPARABLE = [(Hyperelastic(), 0), (Hyperelastic(), 2), (HeavyTop(1.0, 0.5), 1)]


def fitted(model, z, time: float) -> tuple[dict, fastaff.tori.TorusFit]:
    """Return the numbers of a fit, and the fit."""
    seconds, fit = best(lambda: fit_torus(model, z, time=time), repeats=1), fit_torus(model, z, time=time)
    found = {"seconds": seconds, "terms": len(fit.k), "order": fit.order}
    return {**found, "residual": fit.residual, "prediction_error": fit.prediction_error}, fit


@pytest.mark.parametrize("time", [300.0, 1000.0])
@pytest.mark.parametrize(("potential", "i"), SEPARABLE, ids=[f"{type(p).__name__}-{i}" for p, i in SEPARABLE])
def test_separable(numbers, potential, i, time):
    """One orbit over `time` (about 0.3 to 0.5 times as many periods); truth by quadrature."""
    body, z = Body(potential), from_matrix(*map(np.array, POINTS[i]))
    found, fit = fitted(body, z, time)
    numbers.update(
        **found,
        nu_error=np.abs(fit.nu - naive.frequencies(body, z[:, None])[:, 0]).max(),
        J_error=np.abs(fit.J / naive.r_vartheta_actions(body, z) - 1).max(),
    )


@pytest.mark.parametrize("i", [0, 1])
def test_neo_hookean(numbers, i):
    """No separation; p_eta and p_gamma are two of the actions."""
    body, z = Body(NeoHookean()), from_matrix(*map(np.array, POINTS[i]))
    found, fit = fitted(body, z, 1000.0)
    numbers.update(**found, I_error=np.abs(fit.I[2:] - naive.constants(body, z)[1:]).max())


def test_henon_heiles(numbers):
    """A regular orbit and a chaotic one of two degrees of freedom."""
    regular, chaotic = [0.1, -0.05, 0.12081, 0.1], [0.0, -0.25, 0.42081, 0.0]
    numbers.update(fitted(HenonHeiles(), regular, 600.0)[0])
    numbers["chaotic"] = fit_torus(HenonHeiles(), chaotic, time=600.0).summary()
