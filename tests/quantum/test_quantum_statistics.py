"""Level statistics: Weyl counts against exact counts and plain quadrature, ratios and laws of spacings against random
matrices.
"""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

import fastaff
from fastaff import Body, Harmonic, Hyperelastic, NeoHookean, affine_body
from fastaff.quantum import (
    GOE_RATIO,
    POISSON_RATIO,
    BerryRobnik,
    Brody,
    count_deviation,
    fit_spacings,
    mean_spacing_ratio,
    number_variance,
    polynomial_count,
    spacing_ratios,
    spectrum,
    unfold,
    weyl_count,
)
from fastaff.quantum.chaos import weyl_count as weyl


@pytest.mark.parametrize(("m", "l"), [(0, 0), (1, 0), (2, 0), (3, -1), (8, 4)])
def test_harmonic_count_in_closed_form(m, l):
    """Z = e^(-(a + b) y)/(2 sinh y)^2 of a class, y = hbar omega/kT: N = x^2/2 - 1/12 at x = (E/hbar omega - a -
    b)/2.
    """
    body, hbar = Body(Harmonic(1.4), 1.3), 0.3
    x = np.array([[1.4, 3.0], [9.7, 20.0]])
    E = hbar * np.sqrt(1.4 / 1.3) * (2 * x + abs(m - l) / 2 + abs(m + l) / 2)
    found = weyl_count(body, E, m=m, l=l, hbar=hbar)
    np.testing.assert_allclose(found, x**2 / 2 - 1 / 12, rtol=2e-6, atol=1e-5)
    assert weyl_count(body, E[1, 0], m=m, l=l, hbar=hbar) == pytest.approx(found[1, 0], rel=2e-6)
    assert weyl_count(body, E[0, 0] - 3.0 * hbar, m=m, l=l, hbar=hbar) == 0  # x < 0


@pytest.mark.parametrize(("m", "l", "hbar"), [(0, 0, 0.1), (3, -1, 0.1)])
def test_count_has_no_drift_on_exact_levels(m, l, hbar):
    """The wall det phi = 0 included: with the Dirichlet perimeter term or with a^2 - 1/4 the staircase would lie off by
    whole levels.
    """
    body = Body(Hyperelastic(1.4), 1.3)
    E = spectrum(body, m=m, l=l, count=160, hbar=hbar).E
    count = weyl_count(body, E, m=m, l=l, hbar=hbar)
    deviation = count_deviation(E, lambda _: count)
    assert abs(deviation.mean()) < 0.03
    assert abs(deviation[:80].mean()) < 0.06
    assert abs(deviation[80:].mean()) < 0.06
    short = count_deviation(np.delete(E, 60), lambda _: np.delete(count, 60))
    assert short[:60].mean() == pytest.approx(deviation[:60].mean())
    assert short[60:].mean() == pytest.approx(-1 + deviation[61:].mean())


def test_count_of_a_body_that_does_not_separate():
    body = Body(NeoHookean(1.0, 2.0))
    E = spectrum(body, m=5, l=-1, count=60, hbar=0.1, tolerance=1e-6).E
    deviation = count_deviation(E, partial(weyl_count, body, m=5, l=-1, hbar=0.1))
    assert abs(deviation.mean()) < 0.05
    assert np.abs(deviation).max() < 2


TWO_WELLS = "((D1**2 + D2**2) - 2)**2*((D1**2 + D2**2) - 6)**2/20 + D1*D2/10"


@pytest.mark.parametrize(
    ("body", "energy"),
    [(Body(NeoHookean(1.0, 2.0), 1.2), 2.2), (affine_body(TWO_WELLS), 0.6), (affine_body(TWO_WELLS), 2.5)],
    ids=["neo-Hookean", "two wells", "two wells, above the pass"],
)
def test_leading_term_against_cells(body, energy):
    """Phase space by cells of alpha and beta, exact for the leading term at hbar -> 0; angular momenta fixed."""
    hbar, p_eta, p_gamma = 1e-3, 0.3, 0.2
    step = 2e-3
    alpha, beta = np.meshgrid(step * (np.arange(2000) + 0.5), step * (np.arange(1600) + 0.5), indexing="ij")
    with np.errstate(invalid="ignore", divide="ignore"):
        V = body.potential.value(alpha**2, beta**2) + (p_eta**2 / alpha**2 + p_gamma**2 / beta**2) / (2 * body.mu)
        room = np.where((body.potential.margin(alpha**2, beta**2) > 0) & (energy > V), energy - V, 0.0)
    truth = body.mu / (2 * np.pi) * room.sum() * step**2
    found = weyl_count(body, energy, m=500, l=-100, hbar=hbar) * hbar**2
    assert found == pytest.approx(truth, rel=2e-5)


def test_what_has_no_count():
    with pytest.raises(ValueError, match="not bounded"):
        weyl_count(affine_body("-(D1**2 + D2**2)"), 1.0, m=0, l=0)
    with pytest.raises(TypeError, match="Body"):
        weyl_count(fastaff.HenonHeiles(1.0), 1.0, m=0, l=0)
    with pytest.raises(ValueError, match="energy"):
        weyl_count(Body(Harmonic()), [1.0, np.nan], m=0, l=0)
    with pytest.raises(ValueError, match="hbar"):
        weyl_count(Body(Harmonic()), 1.0, m=0, l=0, hbar=-1.0)


def goe_levels(n, random):
    """Unfolded middle levels of a GOE matrix. Source of the tridiagonal form: Dumitriu & Edelman 2002, J. Math. Phys.
    43, 5830.
    """
    from scipy.linalg import eigvalsh_tridiagonal

    E = eigvalsh_tridiagonal(np.sqrt(2) * random.normal(size=n), np.sqrt(random.chisquare(np.arange(n - 1, 0, -1)))) / (
        2 * np.sqrt(n)
    )
    E = np.clip(E, -1, 1)
    return (n * (0.5 + (E * np.sqrt(1 - E**2) + np.arcsin(E)) / np.pi))[n // 5 : -(n // 5)]


def superposed(chaotic, random):
    """Levels of GOE and Poisson, with densities `chaotic` and 1 - chaotic."""
    levels = goe_levels(400, random)
    levels = (levels - levels[0]) / max(chaotic, 1e-9)
    length = levels[-1] if chaotic else 400.0
    regular = random.uniform(0, length, random.poisson((1 - chaotic) * length))
    return np.sort(np.concatenate([levels, regular] if chaotic else [regular]))


@pytest.mark.parametrize("chaotic", [0.0, 0.5, 0.75, 1.0])
def test_ratios_of_random_spectra(chaotic):
    """Their mean, its error against the scatter of many spectra, and the theory of Berry and Robnik (0.0052 high at
    GOE).
    """
    random = np.random.default_rng(3)
    spectra = [superposed(chaotic, random) for _ in range(60)]
    pooled = mean_spacing_ratio(spectra)
    assert pooled.ratios == sum(E.size - 2 for E in spectra)
    each = [mean_spacing_ratio([E]) for E in spectra]
    assert np.mean([one.error for one in each]) == pytest.approx(
        np.std([one.value for one in each]), rel=0.35
    )  # 4 sigma of 60
    law = BerryRobnik(chaotic).mean_ratio()
    assert law - 0.0052 * chaotic - 4 * pooled.error < pooled.value < law + 4 * pooled.error
    exact = {0.0: POISSON_RATIO, 1.0: GOE_RATIO}.get(chaotic)
    assert exact is None or abs(pooled.value - exact) < 4 * pooled.error


def test_ratios_known_in_closed_form():
    np.testing.assert_allclose(spacing_ratios([0.0, 1.0, 3.0, 4.0]), [0.5, 0.5])
    assert BerryRobnik(0.0).mean_ratio() == pytest.approx(2 * np.log(2) - 1, abs=1e-6)
    assert BerryRobnik(1.0).mean_ratio() == pytest.approx(4 - 2 * np.sqrt(3), abs=1e-6)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(300)


@given(st.floats(0.05, 1.0), st.sampled_from([BerryRobnik, Brody]))
def test_laws_are_densities_with_mean_one(parameter, family):
    law = family(parameter)
    s, w = 10 * (1 + NODES) ** 2, 20 * WEIGHTS * (1 + NODES)  # to 40, dense at 0
    assert w @ law.density(s) == pytest.approx(1, abs=1e-6)
    assert w @ (s * law.density(s)) == pytest.approx(1, abs=1e-6)
    assert law.cumulative(0.0) == pytest.approx(0, abs=1e-15)
    slope = (law.cumulative(1.3 + 1e-5) - law.cumulative(1.3 - 1e-5)) / 2e-5
    assert slope == pytest.approx(float(law.density(1.3)), rel=1e-7)


def test_laws_meet_at_both_ends():
    s = np.linspace(0.01, 4, 9)
    for family in (BerryRobnik, Brody):
        np.testing.assert_allclose(family(0.0).density(s), np.exp(-s), rtol=1e-12)
        np.testing.assert_allclose(family(1.0).density(s), np.pi * s / 2 * np.exp(-np.pi * s**2 / 4), rtol=1e-12)


@pytest.mark.parametrize(("family", "parameter"), [(BerryRobnik, 0.6), (Brody, 0.4), (BerryRobnik, 0.0), (Brody, 1.0)])
def test_fits_find_the_parameter(family, parameter):
    random, x = np.random.default_rng(5), np.linspace(0, 25, 40001)
    spacings = np.interp(random.uniform(size=4000), family(parameter).cumulative(x), x)
    fit = fit_spacings(spacings[spacings > 0], family)
    found = next(iter(vars(fit.law).values()))
    assert fit.low <= found <= fit.high
    assert abs(found - parameter) < 4 * max(fit.high - fit.low, 0.005)
    assert fit.high - fit.low < 0.15


def test_unfolding_by_a_polynomial_and_number_variance():
    random = np.random.default_rng(8)
    x = np.cumsum(random.exponential(size=3000))
    E = 1000 * (np.sqrt(1 + 2 * x / 1000) - 1)  # x = E + E^2/2000
    unfolded = unfold(E, polynomial_count(E, 3))
    assert np.diff(unfolded).mean() == pytest.approx(1, abs=0.02)
    assert np.abs(np.diff(unfolded[::300]) / 300 - 1).max() < 4 / np.sqrt(300)
    np.testing.assert_allclose(number_variance(x, [0.5, 2.0]) * x.size / x[-1], [0.5, 2.0], rtol=0.12)
    goe = np.mean([number_variance(goe_levels(400, random), [4.0]) for _ in range(20)])
    assert goe == pytest.approx(2 / np.pi**2 * (np.log(8 * np.pi) + 1.5772 - np.pi**2 / 8), rel=0.06)
    np.testing.assert_allclose(number_variance(np.arange(50.0), 3.0), 0.0, atol=0.05)  # a fence


@pytest.mark.parametrize(
    ("levels", "words"),
    [
        ([1.0, 2.0], "at least|n >= 3"),
        ([1.0, 3.0, 2.0], "ascend"),
        ([1.0, np.nan, 2.0], "finite"),
        ([[1.0, 2.0, 3.0]], "shape"),
        ([1.0, 2.0, 2.0, 3.0], "degenerate"),
        (spectrum(Body(Harmonic()), m=0, l=0, count=10).E, "degenerate"),
    ],
)
def test_levels_that_have_no_statistics(levels, words):
    with pytest.raises(ValueError, match=words):
        spacing_ratios(levels)


def test_other_wrong_input():
    E = np.arange(10.0)
    with pytest.raises(TypeError, match="spectra"):
        mean_spacing_ratio(E)
    with pytest.raises(ValueError, match="smooth must grow"):
        unfold(E, lambda x: -x)
    with pytest.raises(ValueError, match="one number"):
        unfold(E, lambda x: x[:3])
    with pytest.raises(ValueError, match=r"\[0, 1\]"):
        BerryRobnik(1.2)
    with pytest.raises(ValueError, match=r"\[0, 1\]"):
        Brody(-0.1)
    with pytest.raises(ValueError, match="positive"):
        fit_spacings([1.0, 0.0], Brody)
    with pytest.raises(ValueError, match="lengths"):
        number_variance(E, 5.0)
    with pytest.raises(ValueError, match="n >= 7"):
        polynomial_count(E[:5])


@pytest.mark.parametrize("law", [fastaff.quantum.BerryRobnik(0.5), fastaff.quantum.Brody(0.5)])
@pytest.mark.parametrize("s", [-1.0, np.nan, [0.0, -0.1]])
def test_laws_refuse_what_are_no_spacings(law, s):
    for method in (law.density, law.cumulative):
        with pytest.raises(ValueError, match="s must be at least 0"):
            method(s)


def test_a_single_ratio_has_no_error_and_few_energies_no_polynomial():
    assert fastaff.quantum.mean_spacing_ratio([[1.0, 2.0, 4.0]]) == (0.5, np.inf, 1)
    with pytest.raises(ValueError, match="more than degree = 3 different energies, got 1"):
        fastaff.quantum.polynomial_count(np.ones(10), 3)


@pytest.mark.parametrize("energy", [10.0, 20.0, 40.0])
def test_phase_space_integrals_of_a_body_with_a_wall_are_those_of_one_quadrature(energy):
    """Hyperelastic, (m, l) = (1, 1): on a ray V_eff = u/2 + K/u, u = rho^2, so that both radial integrals are
    elementary.
    """

    def K(angle):
        return 2 / np.cos(2 * angle) + 0.5 / np.sin(angle) ** 2

    bottom = minimize_scalar(K, bounds=(0.1, 0.7), method="bounded").x
    lo, hi = (
        brentq(lambda angle: K(angle) - energy**2 / 2, *ends) for ends in ((1e-6, bottom), (bottom, np.pi / 4 - 1e-9))
    )
    t, w = np.polynomial.legendre.leggauss(300)
    half = np.pi / 4 * (1 + t)
    angle, weight = lo + (hi - lo) * np.sin(half) ** 2, np.pi / 4 * w * (hi - lo) * np.sin(2 * half)
    root = np.sqrt(np.maximum(energy**2 - 2 * K(angle), 0))
    u1, u2 = 2 * K(angle) / (energy + root), energy + root
    volume = weight @ (energy * (u2 - u1) / 2 - (u2**2 - u1**2) / 8 - K(angle) * np.log(u2 / u1) / 2)
    laplacian = weight @ ((2 + 4 / (np.cos(2 * angle) ** 3 * K(angle))) * 2 * root)
    well, _ = weyl._wells(Body(Hyperelastic()), np.array([0.0, 1.0]), 1.0, 41.0)
    found = weyl._integrals(well, np.array([energy]))[:, 0]
    np.testing.assert_allclose(found[[0, 3]], [volume, laplacian], rtol=1e-8)
