"""Levels and states of the breathing top against closed forms and its equation in four dimensions."""

import numpy as np
import pytest

from fastaff.quantum import (
    NoGroundState,
    all_levels,
    exact_levels,
    quasiclassical_levels,
    spectrum,
    spectrum_table,
    wavefunction,
)
from fastaff.systems.charts import ALPHA_BETA, R_VARTHETA
from fastaff.systems.models import (
    Anharmonic,
    Body,
    BreathingBody,
    Cosine,
    Harmonic,
    HeavyTop,
    Hyperelastic,
    NeoHookean,
    SeparableRVartheta,
    univariate,
)

POTENTIALS = [Harmonic(1.2), Anharmonic(0.8), Hyperelastic(1.1), HeavyTop(1.3, 0.1)]


@pytest.mark.parametrize("potential", POTENTIALS, ids=lambda V: type(V).__name__)
def test_levels_of_oscillators_follow_from_e_vartheta(potential):
    """V_r = C r/2: E = hbar omega/sqrt(1 + c) (2 n_r + 1 + sqrt(1 + 2 mu (1 + c) e_vartheta/hbar^2)); as before at c =
    0.
    """
    rng = np.random.default_rng(4)
    for c in (0.0, *rng.uniform(-0.9, 4.0, 3)):
        hbar, mu = rng.uniform(0.4, 1.5, 2)
        how = {"m": [0, 2, 3], "l": [0, 0, 1], "count": 8, "hbar": hbar}
        plain = spectrum_table(Body(potential, mu), chart=R_VARTHETA, **how)
        tables = spectrum_table(BreathingBody(potential, c, mu), **how)
        for found, before in zip(tables, plain, strict=True):
            if c == 0.0:
                assert (found.E == before.E).all()
                assert (found.n == before.n).all()
            e = found.constants[1]
            root = np.sqrt(1 + 2 * mu * (1 + c) * e / hbar**2)
            E = hbar * np.sqrt(potential.C / mu / (1 + c)) * (2 * found.n[0] + 1 + root)
            assert np.all(np.abs(found.E - E) <= found.error + 1e-13 * E)
            some = before.n[1] == 0
            if (found.n[1] == 0).any() and some.any():
                assert e[found.n[1] == 0][0] == pytest.approx(before.constants[1][some][0], rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("seed", range(3))
def test_exact_levels_are_those_of_the_solver(seed):
    """Anharmonic: e_vartheta = (hbar^2/2 mu)(Q^2 - 1), Q = 2 n + 1 + s_alpha + s_beta, is the same with the term."""
    rng = np.random.default_rng(seed)
    c, hbar, mu, C = rng.uniform(-0.8, 3.0), *rng.uniform(0.5, 1.2, 3)
    body = BreathingBody(Anharmonic(C), c, mu)
    found = all_levels(body, multiplets=12, hbar=hbar)
    n_r, n_v = found.n
    Q = 2 * n_v + 1 + np.abs(found.m + found.l) / 2 + np.sqrt((found.m - found.l) ** 2 / 4 + 4 * mu * C / hbar**2)
    E = hbar * np.sqrt(C / mu / (1 + c)) * (2 * n_r + 1 + np.sqrt((1 + c) * (Q**2 - 1) + 1))
    np.testing.assert_allclose(found.E, E, rtol=1e-12)
    exact = exact_levels(body, max_energy=found.E[-1] * (1 + 1e-9), hbar=hbar)
    np.testing.assert_allclose(exact.E[: len(found)], found.E, rtol=1e-12)
    plain = exact_levels(Body(Anharmonic(C), mu), n=found.n, m=found.m, l=found.l, hbar=hbar, chart=R_VARTHETA)
    same = exact_levels(BreathingBody(Anharmonic(C), 0.0, mu), n=found.n, m=found.m, l=found.l, hbar=hbar)
    assert (plain.E == same.E).all()
    state = wavefunction(body, m=1, l=1, n=(1, 2), hbar=hbar, chart=R_VARTHETA)
    other = spectrum(body, m=1, l=1, count=40, hbar=hbar)
    place = int(np.flatnonzero((other.n == [[1], [2]]).all(axis=0))[0])
    assert abs(state.overlap(other.state(place))) == pytest.approx(1, abs=1e-11)
    assert state.energy == pytest.approx(other.E[place], rel=1e-12)


def test_states_solve_the_equation_in_four_dimensions():
    """-(hbar^2/2 mu)(Delta - c/(1 + c) rho^-3 d(rho^3 d/drho)/drho) Psi + V Psi = E Psi, by differences."""
    V_r = univariate(lambda r: 0.7 * r + 0.3 * r * r, lambda r: 0.7 + 0.6 * r)
    c, mu, hbar = 1.4, 0.8, 0.9
    body = BreathingBody(SeparableRVartheta(V_r, Cosine(0.6)), c, mu)
    levels = spectrum(body, m=2, l=0, count=9, hbar=hbar)
    q = np.random.default_rng(5).normal(size=(4, 20)) * 0.7 + 0.4
    rho = np.sqrt((q**2).sum(axis=0))
    step = 2e-3
    weights = ((1, 1.5), (2, -0.15), (3, 1 / 90))
    for k in (0, 5, 8):
        psi = levels.state(k).planes
        here = psi(q)
        second = 0.0
        for d in step * np.eye(4)[..., None]:
            second = second + sum(w * (psi(q + j * d) + psi(q - j * d) - 2 * here) for j, w in weights) / step**2
        d = step * q / rho
        radial = sum(w * (psi(q + j * d) + psi(q - j * d) - 2 * here) for j, w in weights) / step**2
        slope = sum(w * (psi(q + j * d) - psi(q - j * d)) for j, w in ((1, 0.75), (2, -0.15), (3, 1 / 60))) / step
        radial = radial + 3 / rho * slope
        V = body.potential.value((q[:2] ** 2).sum(axis=0), (q[2:] ** 2).sum(axis=0))
        H = -(hbar**2) / (2 * mu) * (second - c / (1 + c) * radial) + V * here
        np.testing.assert_allclose(H, levels.E[k] * here, atol=1e-6 * levels.E[k] * np.abs(here).max())
        assert levels.state(k).norm() == pytest.approx(1, abs=1e-12)


def test_the_term_lowers_the_bound_of_the_heavy_top():
    """1 + 2 mu (1 + c) e_vartheta/hbar^2 >= 0 binds: a large c makes an attracting top fall to the centre."""
    e = spectrum(Body(HeavyTop(1.0, 1.0)), m=0, l=0, count=1).constants[1, 0]
    bound = -1 / (2 * e) - 1
    assert bound > 0
    spectrum(BreathingBody(HeavyTop(1.0, 1.0), 0.999 * bound), m=0, l=0, count=1)
    with pytest.raises(NoGroundState, match="too attractive at 0"):
        spectrum(BreathingBody(HeavyTop(1.0, 1.0), 1.001 * bound), m=0, l=0, count=1)


def test_quasiclassical_levels():
    """EBK: E = hbar omega (2 (n_r + 1/2)/sqrt(1 + c) + Q), not exact for c other than 0, tending to the exact one."""
    c, mu, C, hbar = 1.3, 0.9, 0.8, 0.7
    body = BreathingBody(Anharmonic(C), c, mu)
    n = np.array([[0, 1, 3, 2], [0, 2, 1, 40]])
    found = quasiclassical_levels(body, n=n, m=1, l=-1, hbar=hbar)
    Q = 2 * n[1] + 1 + np.sqrt(1 + 4 * mu * C / hbar**2)
    E = hbar * np.sqrt(C / mu) * ((2 * n[0] + 1) / np.sqrt(1 + c) + Q)
    np.testing.assert_allclose(found.E, E, rtol=1e-11)
    exact = exact_levels(body, n=n, m=1, l=-1, hbar=hbar)
    away = np.abs(found.E - exact.E)
    assert away[0] > 1e-3
    assert away[3] < 0.1 * away[0]


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (
            lambda: spectrum(BreathingBody(NeoHookean(), 1.0), m=0, l=0, count=1),
            ValueError,
            "separable in r and vartheta",
        ),
        (lambda: spectrum(BreathingBody(Harmonic(), -1.0), m=0, l=0, count=1), ValueError, "c must be above -1"),
        (lambda: spectrum(BreathingBody(Harmonic(), 1.0), count=1), TypeError, "needs m and l"),
        (
            lambda: spectrum(BreathingBody(Harmonic(), 1.0), m=0, l=0, n_eta=1, count=1),
            ValueError,
            "n_eta must be None",
        ),
        (
            lambda: spectrum(BreathingBody(Harmonic(), 1.0), m=0, l=0, count=1, chart=ALPHA_BETA),
            ValueError,
            "r-vartheta",
        ),
        (lambda: wavefunction(BreathingBody(Harmonic(), 1.0), m=0, l=0, n=(0, 0)), ValueError, "r-vartheta"),
        (lambda: exact_levels(BreathingBody(HeavyTop(), 1.0), multiplets=1), ValueError, "closed-form"),
        (lambda: all_levels(BreathingBody(NeoHookean(), 1.0), max_energy=1.0), ValueError, "separable"),
        (
            lambda: quasiclassical_levels(BreathingBody(Harmonic(), 1.0), n=(0, 0)),
            ValueError,
            "n, m and l must be given together",
        ),
    ],
)
def test_bad_input(call, error, words):
    with pytest.raises(error, match=words):
        call()
