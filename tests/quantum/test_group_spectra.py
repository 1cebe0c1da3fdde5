"""Spectra with the invariant metrics of section 7, against operators by differences, a heat trace, radial matrices."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh_tridiagonal

import fastaff as fa
from fastaff.core.status import Status
from fastaff.quantum import affine_spectrum, shear_factor, unitary_levels, unitary_wave
from fastaff.quantum.groups.shear_series import BOTTOM, casimir, series, why_none
from fastaff.quantum.states.symmetry import SymmetryClass
from fastaff.systems import invariant_metrics as g

RNG = np.random.default_rng(616)
TAU = "k*log(det)**2/8"
"""Potential of an oscillating dilatation: one compiled text for all tests."""
SHEARED = fa.models.AffineBody("left", potential="k*log(det)**2/8 + c*r/det/2", k=1.0, c=1.0)
MORSE = "k*(1/det**2 - 2/det)"
MIXED = fa.models.AffineBody("left", potential="k*r", k=1.0)
STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
"""Fourth-order central first difference."""


def laplacian(metric, f, q, h=2e-3):
    """The Laplace-Beltrami operator |g|^(-1/2) d_i |g|^(1/2) g^ij d_j of f at q, by differences."""

    def moved(q, i, steps):
        there = q.copy()
        there[i] += steps * h
        return there

    def flux(i, q):
        slopes = [sum(w * f(moved(q, j, s)) for s, w in STENCIL) / h for j in range(4)]
        G = metric(q)
        return math.sqrt(abs(np.linalg.det(G))) * (np.linalg.inv(G)[i] @ np.array(slopes))

    total = sum(sum(w * flux(i, moved(q, i, s)) for s, w in STENCIL) / h for i in range(4))
    return total / math.sqrt(abs(np.linalg.det(metric(q))))


# --- U(2) -------------------------------------------------------------------------------------------------------------


def drawn_state():
    """Quantum numbers k, j, m, l of a state on U(2)."""
    twice = int(RNG.integers(0, 7))
    k = twice % 2 + 2 * int(RNG.integers(-3, 4))
    m, l = (twice - 2 * int(RNG.integers(0, twice + 1)) for _ in range(2))
    return {"k": k, "j": twice / 2, "m": m, "l": l}


def angles(*shape):
    """Random a, Phi, Theta, Psi away from the singular points."""
    q = RNG.uniform(-3, 3, (4, *shape))
    q[2] = RNG.uniform(0.6, 2.5, shape)
    return q


@pytest.mark.parametrize("_", range(4))
def test_waves_of_the_unitary_group_are_eigenfunctions_of_its_laplacian(_):
    inertia, c, hbar, numbers = RNG.uniform(0.5, 2), RNG.uniform(-0.5, 2), RNG.uniform(0.5, 2), drawn_state()
    q = angles()
    E = unitary_levels(inertia=inertia, c=c, hbar=hbar, k=numbers["k"], j=numbers["j"]).E[0]
    found = (
        -(hbar**2)
        / (2 * inertia)
        * laplacian(lambda q: g.unitary_metric(q, c), lambda q: unitary_wave(q, **numbers), q)
    )
    scale = hbar**2 / inertia * (1 + numbers["j"]) ** 2 * (1 + abs(numbers["k"]))
    assert abs(found - E * unitary_wave(q, **numbers)) < 1e-7 * scale


def test_waves_are_functions_of_the_matrix():
    """Coordinates of one matrix give one value; the states of k = 1, j = 1/2 are its elements in a unitary basis."""
    for _ in range(20):
        numbers, q = drawn_state(), angles()
        value = unitary_wave(q, **numbers)
        for shift in ((2, 0, 0, 2), (0, 2, 0, 2), (4, 0, 0, 0), (-2, 2, 0, 0)):
            moved = q + np.pi * np.array(shift)
            np.testing.assert_allclose(g.UNITARY.matrix(moved), g.UNITARY.matrix(q), atol=1e-13)
            np.testing.assert_allclose(unitary_wave(moved, **numbers), value, rtol=0, atol=1e-13)
    q = angles(5)
    phi = g.UNITARY.matrix(q)
    values, basis = np.linalg.eigh(2j * g.TAU[2])  # exp(Phi tau_2) is e^(-+i Phi/2) on these
    elements = np.einsum("ia,ij...,jb->ab...", basis.conj(), phi, basis)
    for a, m in enumerate(values):
        for b, l in enumerate(values):
            wave = unitary_wave(q, k=1, j=0.5, m=round(-m), l=round(l))
            np.testing.assert_allclose(np.abs(wave), np.abs(elements[a, b]) * math.sqrt(2 / (32 * np.pi**3)))
            ratio = wave / elements[a, b]
            np.testing.assert_allclose(ratio, ratio[0], atol=1e-13)


def test_waves_are_orthonormal():
    """Trapezoidal rules in the angles and a Gauss rule in cos(Theta) are exact for these states."""
    x, w = np.polynomial.legendre.leggauss(8)
    a, Phi, Psi = (span * np.arange(12) / 12 for span in (2 * np.pi, 2 * np.pi, 4 * np.pi))
    q = np.array(np.meshgrid(a, Phi, np.arccos(x), Psi, indexing="ij"))
    weight = w[None, None, :, None] * (2 * np.pi / 12) ** 2 * (4 * np.pi / 12)
    some = [(0, 0, 0, 0), (2, 0, 0, 0), (0, 1, 2, 0), (0, 1, 2, -2), (1, 0.5, 1, 1), (1, 1.5, 1, 1), (-1, 1.5, 3, -1)]
    waves = [unitary_wave(q, k=k, j=j, m=m, l=l) for k, j, m, l in some]
    overlaps = [[(one.conj() * other * weight).sum() for other in waves] for one in waves]
    np.testing.assert_allclose(overlaps, np.eye(len(some)), atol=1e-13)


@pytest.mark.parametrize("_", range(3))
def test_the_heat_trace_of_the_levels_is_that_of_the_manifold(_):
    """sum e^(-t lambda) = Vol e^t/(4 pi t)^2 on U(2), a quotient of the unit sphere S^3 and a circle, up to terms of
    closed geodesics, at most e^(-pi^2/(4 t)). With a wrong degeneracy or selection rule it fails.
    """
    c, inertia, hbar, t = RNG.uniform(0.0, 2), RNG.uniform(0.5, 2), RNG.uniform(0.5, 2), 0.08
    unit = hbar**2 / (2 * inertia)
    levels = unitary_levels(inertia=inertia, c=c, hbar=hbar, max_energy=420 * unit)
    trace = np.exp(-t * levels.E / unit).sum()
    volume = 2 * np.pi**3 * math.sqrt(1 + c)
    assert abs(trace / (volume * math.exp(t) / (4 * np.pi * t) ** 2) - 1) < 1e-10
    assert (levels.error < 1e-12 * (1 + levels.E)).all()
    assert levels.complete_below == 420 * unit


def test_lists_of_levels_are_complete():
    c, hbar = RNG.uniform(-0.6, 3), RNG.uniform(0.5, 2)
    lowest = unitary_levels(c=c, hbar=hbar, multiplets=12)
    groups = lowest.multiplets()
    assert len(groups) == 12
    every = unitary_levels(c=c, hbar=hbar, max_energy=lowest.complete_below)
    np.testing.assert_array_equal(every.E, lowest.E)
    assert (np.diff(groups.E) > 0).all()
    brute = sorted(
        hbar**2 / 2 * (k * k / (1 + c) + twice * (twice + 2))
        for twice in range(30)
        for k in range(-60, 61)
        for _ in range((twice + 1) ** 2)
        if (k + twice) % 2 == 0
    )
    np.testing.assert_allclose(lowest.E, brute[: len(lowest)], rtol=1e-14)
    assert brute[len(lowest)] == pytest.approx(lowest.complete_below, rel=1e-12)
    k, n_Theta = lowest.n
    twice = 2 * n_Theta + np.maximum(np.abs(lowest.m), np.abs(lowest.l))
    assert not ((k + twice) % 2).any()
    np.testing.assert_allclose(lowest.constants[1], hbar**2 / 2 * twice * (twice + 2), rtol=1e-14)
    rows = np.array([k, twice, lowest.m, lowest.l])
    assert len(np.unique(rows, axis=1).T) == len(lowest)


def test_lowest_multiplets_for_a_heavy_dilatation():
    """For a large c the lowest levels have j = 0 and k = 0, 2, -2, ...: no other is listed on the way."""
    c = 10 ** RNG.uniform(11, 13)
    found = unitary_levels(c=c, multiplets=4)
    assert found.n[0].tolist() == [0, -2, 2, -4, 4, -6, 6]
    np.testing.assert_allclose(found.E, found.n[0] ** 2 / (2 * (1 + c)), rtol=1e-13)
    assert found.complete_below > found.E[-1]


def test_the_motion_on_the_unitary_group_is_its_geodesic():
    inertia, c = RNG.uniform(0.5, 2), RNG.uniform(-0.5, 2)
    model = fa.models.UnitaryBody(inertia=inertia, c=c)
    q, p = angles(5), RNG.normal(0, 0.5, (4, 5))
    z0 = np.concatenate([q, p])
    found = fa.integrate(model, z0, time=6.0, accuracy=1e-12)
    assert (found.status == Status.OK).all()
    velocity = np.array([model.rates(*z)[:4] for z in z0.T]).T
    exact = g.UNITARY.geodesic(q, velocity, 6.0)
    assert np.abs(g.UNITARY.matrix(found.z[:4]) - exact).max() < 1e-9
    half = np.einsum("k...,kl...,l...->...", velocity, g.unitary_metric(q, c), velocity) * inertia / 2
    np.testing.assert_allclose(model.energy(*z0), half, rtol=1e-12)
    before, after = (fa.constants_of_motion(model, z) for z in (z0, found.z))
    for name, value in before.items():
        np.testing.assert_allclose(after[name], value, rtol=1e-10, atol=1e-11)


def test_level_spacings_are_the_frequencies_of_geodesics():
    """Central differences of E in j and in k/2, over hbar: the speed of the great circle and of the phase, at J = hbar
    (j + 1/2) and p_a = hbar k/2.
    """
    inertia, c, hbar = RNG.uniform(0.5, 2), RNG.uniform(-0.5, 2), RNG.uniform(0.5, 2)
    j, k = 4, 2 * int(RNG.integers(1, 6))
    constants = {"inertia": inertia, "c": c}
    q = angles()
    p_Phi, p_Psi = hbar * RNG.uniform(-1.5, 1.5, 2)
    rest = (p_Phi**2 + p_Psi**2 - 2 * np.cos(q[2]) * p_Phi * p_Psi) / np.sin(q[2]) ** 2
    p = [hbar * k / 2, p_Phi, math.sqrt((hbar * (j + 0.5)) ** 2 - rest), p_Psi]
    phase, Phi, Theta, Psi = fa.models.UnitaryBody(**constants).rates(*q, *p)[:4]
    speed = math.sqrt(Theta**2 + Phi**2 + Psi**2 + 2 * math.cos(q[2]) * Phi * Psi)

    def E(k, j):
        return unitary_levels(**constants, hbar=hbar, k=k, j=j).E[0]

    assert (E(k, j + 1) - E(k, j - 1)) / (2 * hbar) == pytest.approx(speed, rel=1e-12)
    assert (E(k + 2, j) - E(k - 2, j)) / (2 * hbar) == pytest.approx(phase, rel=1e-12)


# --- affinely invariant bodies ----------------------------------------------------------------------------------------


def drawn(invariance):
    """Constants of inertia for which the dilatation and the shear have positive masses."""
    A, B = RNG.uniform(0.3, 0.9), RNG.uniform(-0.1, 0.5)
    return {"A": A, "B": B} | ({} if invariance == "both" else {"I": RNG.uniform(1.2, 2.0)})


def drawn_class(least=2):
    """m, l with an even sum and of opposite signs, both at least `least` in size."""
    m = int(RNG.integers(least, 9))
    l = -(m + 2 * int(RNG.integers(-((m - least) // 2), 4)))
    return (m, l) if RNG.integers(2) else (-m, -l)


def metric_of(invariance, constants):
    """The metric g with T = g(v, v)/2 in a, Phi, b, Psi, from the matrices alone."""
    I, A, B = (constants.get(name, 0.0) for name in "IAB")

    def form(X, Y):
        return I * np.trace(X.T @ Y) + A * np.trace(X @ Y) + B * np.trace(X) * np.trace(Y)

    def metric(q):
        here = g.AFFINE_BODY.cartan_forms(q)[invariance == "left"]
        return np.array([[form(X, Y) for Y in here] for X in here])

    return metric


@pytest.mark.parametrize("invariance", ["left", "right", "both"])
def test_discrete_states_are_eigenfunctions_of_the_invariant_laplacian(invariance):
    """The operator is that of the metric of T, by differences; an oscillator's Gaussian is the state of a."""
    for _ in range(2):
        constants, hbar, k = drawn(invariance), RNG.uniform(0.5, 2), RNG.uniform(0.5, 2)
        m, l = drawn_class()
        model = fa.models.AffineBody(invariance, **constants, potential=TAU, k=k)
        found = affine_spectrum(model, m=m, l=l, hbar=hbar)
        assert found.levels.converged.all()
        mass = (constants["A"] + constants.get("I", 0.0) + 2 * constants["B"]) / 2
        width = math.sqrt(mass * k / 4) / hbar
        q = np.array([RNG.normal(0, 0.3), RNG.uniform(-3, 3), RNG.uniform(0.5, 2), RNG.uniform(-3, 3)])
        for E, n in zip(found.levels.E, found.levels.n[1], strict=True):

            def wave(q, n=n):
                a, Phi, b, Psi = q
                phase = np.exp(0.5j * (m * Phi - l * Psi))  # noqa: B023
                return math.exp(-width * a * a / 2) * phase * shear_factor(b, n=n, m=m, l=l)  # noqa: B023

            kinetic = -(hbar**2) / 2 * laplacian(metric_of(invariance, constants), wave, q)
            psi = wave(q)
            scale = hbar**2 * (m * m + l * l) * max(1.0, abs(psi))
            assert abs(kinetic + (k * q[0] ** 2 / 8 - E) * psi) < 1e-7 * scale


def radial_levels(m, l, box, count, cells, V=lambda b: 0.0):
    """The lowest values of L + V between b = 0 and a wall, by a symmetric difference scheme and Richardson's step."""

    def once(cells):
        edges = np.linspace(0.0, box, cells + 1)
        b, h = (edges[1:] + edges[:-1]) / 2, box / cells
        q = ((m * m + l * l) / np.sinh(b) + 2 * m * l / np.tanh(b)) / np.sinh(b) / 4 + V(b)
        ahead, behind = np.sinh(edges[1:]) / np.sinh(b), np.sinh(edges[:-1]) / np.sinh(b)
        off = -ahead[:-1] * np.sqrt(np.sinh(b[:-1]) / np.sinh(b[1:])) / h**2
        return eigh_tridiagonal((ahead + behind) / h**2 + q, off, select="i", select_range=(0, count - 1))[0]

    return (4 * once(2 * cells) - once(cells)) / 3


@pytest.mark.parametrize("_", range(6))
def test_discrete_values_of_the_shear_are_those_of_the_radial_equation(_):
    m, l = drawn_class()
    k = series(SymmetryClass(m, l))
    assert k.size == min(abs(m), abs(l)) // 2
    found = radial_levels(m, l, 35.0, k.size + 1, 20000)
    np.testing.assert_allclose(found[:-1], casimir(k), rtol=0, atol=2e-5 * (1 + m * m))
    assert found[-1] > BOTTOM - 1e-6


@pytest.mark.parametrize("pair", [(0, 0), (0, 4), (3, 5), (1, -1), (1, -3), (2, 2), (-5, -1), (6, 0)])
def test_classes_without_discrete_levels_have_none_in_any_box(pair):
    assert why_none(SymmetryClass(*pair))
    for box in (20.0, 80.0):
        assert radial_levels(*pair, box, 1, 10000)[0] > BOTTOM - 1e-6


@pytest.mark.parametrize("pair", [(2, 2), (4, -6), (0, 2)])
def test_the_continuum_begins_at_a_quarter(pair):
    """In a box of length B the values above the discrete ones are 1/4 + s^2 with s in steps of pi/B."""
    least = series(SymmetryClass(*pair)).size
    steps = []
    for box in (100.0, 200.0, 400.0):
        values = radial_levels(*pair, box, least + 3, int(60 * box))[least:]
        s = np.sqrt(values - BOTTOM)
        steps.append(box * (s[2] - s[1]) / np.pi)
    off = np.abs(np.array(steps) - 1)
    assert off[2] < off[1] < off[0] < 0.1
    assert off[2] < 0.02


def test_shear_factors_are_normalised_orthogonal_and_stable_for_large_numbers():
    x, w = np.polynomial.legendre.leggauss(700)
    for m, l in [drawn_class() for _ in range(4)] + [(160, -200), (160, -160)]:
        number = series(SymmetryClass(m, l)).size
        chosen = sorted({0, number // 2, number - 1})
        b = 20 * (1 + x) ** 2  # f is narrow near 0 and falls as exp(-k b)
        rows = np.array([shear_factor(b, n=n, m=m, l=l) * np.sqrt(np.sinh(b)) for n in chosen])
        np.testing.assert_allclose((rows * w * 40 * (1 + x)) @ rows.T, np.eye(len(chosen)), atol=1e-11)
        assert (rows[:, -1] > -1e-300).all()


@pytest.mark.parametrize("invariance", ["left", "right", "both"])
def test_levels_are_sums_in_closed_form(invariance):
    constants, hbar, k = drawn(invariance), RNG.uniform(0.5, 2), RNG.uniform(0.5, 2)
    m, l = drawn_class(4)
    I, A, B = (constants.get(name, 0.0) for name in "IAB")
    found = affine_spectrum(
        fa.models.AffineBody(invariance, **constants, potential=TAU, k=k), m=m, l=l, count=4, hbar=hbar
    )
    quantum = hbar * math.sqrt(k / 2 / (I + A + 2 * B))
    turn = {"left": l, "right": m, "both": 0}[invariance]
    rotor = hbar**2 * I * turn**2 / (2 * (I**2 - A**2))
    weights = min(abs(m), abs(l)) / 2 - np.arange(min(abs(m), abs(l)) // 2)
    exact = np.add.outer(quantum * (np.arange(4) + 0.5), hbar**2 / (I + A) * weights * (1 - weights) + rotor)
    levels = found.levels
    n_a, n_b = levels.n
    off = np.abs(levels.E - exact[n_a, n_b])
    assert len(levels) == exact.size
    assert (off <= levels.error).all()
    assert (levels.error < 1e-8).all()
    assert (np.diff(levels.E) >= 0).all()
    bottom = quantum / 2 + hbar**2 / (4 * (I + A)) + rotor
    assert abs(found.threshold - bottom) <= found.error
    if I:  # T is positive: all levels lie in the continuum of the class without rotation
        lowest = affine_spectrum(fa.models.AffineBody(invariance, **constants, potential=TAU, k=k), m=0, l=0, hbar=hbar)
        assert lowest.threshold < levels.E.min()


def test_without_a_potential_and_with_a_weak_one_the_dilatation_makes_the_continuum():
    free = affine_spectrum(fa.models.AffineBody("both", A=0.5, B=0.2), m=6, l=-4)
    assert len(free.levels) == 0
    assert free.threshold == pytest.approx(2 * (1 - 2) / 0.5, rel=1e-13)
    assert "the dilatation is free" in free.reason
    assert affine_spectrum(fa.models.AffineBody("left"), m=2, l=0).threshold == pytest.approx(0.25 / 1.5, rel=1e-13)
    k = RNG.uniform(0.5, 2)
    deep = affine_spectrum(fa.models.AffineBody("both", A=1.0, potential=TAU, k=k), m=2, l=4)
    assert len(deep.levels) == 0
    assert "m l = 8" in deep.reason


@pytest.mark.parametrize("invariance", ["left", "right"])
def test_levels_of_a_shear_with_a_potential_are_those_of_the_radial_equation(invariance):
    """V_b = c cosh b, beside a difference scheme, in classes of both signs."""
    constants, hbar, k, c = drawn(invariance), RNG.uniform(0.5, 1.5), RNG.uniform(0.5, 2), RNG.uniform(0.5, 2)
    model = fa.models.AffineBody(invariance, **constants, potential="k*log(det)**2/8 + c*r/det/2", k=k, c=c)
    I, A, B = (constants[name] for name in "IAB")
    unit = hbar**2 / (I + A)
    for m, l in ((0, 0), (2, -4), (5, -5), (1, 3)):
        found = affine_spectrum(model, m=m, l=l, count=3, hbar=hbar)
        rotor = hbar**2 * I * (l if invariance == "left" else m) ** 2 / (2 * (I**2 - A**2))
        shear = unit * radial_levels(m, l, 9.0, 3, 8000, lambda b: c * (np.cosh(b) - 1) / unit) + rotor
        dilatation = hbar * math.sqrt(k / 2 / (I + A + 2 * B)) * (np.arange(3) + 0.5) + c
        exact = np.add.outer(dilatation, shear)[tuple(found.levels.n)]
        np.testing.assert_allclose(found.levels.E, exact, rtol=3e-6)
        assert found.levels.converged.all()
        assert found.threshold == np.inf


def test_levels_of_an_exactly_solvable_shear():
    """-h/(r/det + 2) = -h/(4 cosh(b/2)^2) turns alpha^2 into alpha^2 + h S/hbar^2: discrete levels in any class."""
    for m, l in ((0, 0), (2, 2), (-3, 5)):
        A, k, h, hbar = RNG.uniform(0.5, 2), RNG.uniform(0.5, 2), RNG.uniform(300, 400), RNG.uniform(0.8, 1.2)
        model = fa.models.AffineBody("both", A=A, potential="k*log(det)**2/8 - h/(r/det + 2)", k=k, h=h)
        alpha, beta = math.sqrt((m - l) ** 2 / 4 + h * A / hbar**2), abs(m + l) / 2
        found = affine_spectrum(model, m=m, l=l, count=2, hbar=hbar, tolerance=1e-8)
        weights = (alpha - beta) / 2 - np.arange(2)
        exact = hbar**2 / A * weights * (1 - weights)
        levels = found.levels
        quantum = hbar * math.sqrt(k / 2 / A)
        sums = np.add.outer(quantum * (np.arange(2) + 0.5), exact)[tuple(levels.n)]
        assert (np.abs(levels.E - sums) <= levels.error).all()
        assert (levels.error < 1e-8 * (1 + h)).all()
        assert found.threshold == pytest.approx(quantum / 2 + hbar**2 / (4 * A), abs=1e-3)


def test_levels_of_a_morse_dilatation():
    """k (1/det^2 - 2/det) is Morse's potential of a: E = -(hbar^2/M)(sqrt(M k)/hbar - n - 1/2)^2, continuum from 0."""
    A, B, k, hbar = RNG.uniform(0.5, 1.5), RNG.uniform(0.0, 0.5), RNG.uniform(8, 12), RNG.uniform(0.8, 1.2)
    M, (m, l) = A + 2 * B, drawn_class(4)
    found = affine_spectrum(fa.models.AffineBody("both", A=A, B=B, potential=MORSE, k=k), m=m, l=l, count=2, hbar=hbar)
    weights = series(SymmetryClass(m, l))
    shear = hbar**2 / A * weights * (1 - weights)
    dilatation = -(hbar**2) / M * (math.sqrt(M * k) / hbar - np.arange(2) - 0.5) ** 2
    off = np.abs(found.levels.E - np.add.outer(dilatation, shear)[tuple(found.levels.n)])
    assert found.levels.converged.all()
    assert (off <= found.levels.error).all()
    # Below: the continuum over the ground state, or free dilatation over the lowest level of the shear
    bottom = min(dilatation[0] + hbar**2 / (4 * A), shear.min())
    assert abs(found.threshold - bottom) <= found.error
    with pytest.raises(fa.quantum.NoGroundState, match="binds fewer levels"):
        affine_spectrum(fa.models.AffineBody("both", A=A, potential=MORSE, k=0.3), m=0, l=0, count=3)


def test_geodesics_of_discrete_levels_are_bounded_with_the_frequency_of_the_spacing():
    """Elliptic exp(Omega t): D1/D2 has the period pi/s, and E = -S s^2 of the shear, S = I + A, so dE/dk/hbar = 2 s."""
    k, size = 40.0, RNG.uniform(0.5, 2)
    s = (k - 0.5) / size  # hbar = 1
    E = casimir(np.array([k - 0.5, k + 0.5])) / size
    q = np.array([0.2, 0.3, 0.9, -0.4])
    phi = g.AFFINE_BODY.matrix(q)
    W = np.array([[0.3, 1.0], [0.0, -0.3]]) * s
    W[1, 0] = -(s * s + W[0, 0] ** 2) / W[0, 1]  # det = s^2, trace 0
    times = np.linspace(0.0, np.pi / s, 7)
    path = np.einsum("ijt,jk->tik", g.one_parameter_group(W, times), phi)
    stretches = np.linalg.svd(path, compute_uv=False)
    b = np.log(stretches[:, 0] / stretches[:, 1])
    assert b[-1] == pytest.approx(b[0], rel=1e-12)
    assert np.ptp(b) > 0.01
    assert (E[0] - E[1]) == pytest.approx(2 * s, rel=1e-12)
    assert -size * s * s == pytest.approx(casimir(k) / size, rel=1e-3)  # of T = (S/2) Tr W^2
    assert size / 2 * np.trace(W @ W) == pytest.approx(-size * s * s, rel=1e-12)


# --- wrong input ------------------------------------------------------------------------------------------------------


def body(**more):
    return fa.models.AffineBody("both", A=1.0, **more)


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda: unitary_levels(), ValueError, "give k and j, or max_energy, or multiplets"),
        (lambda: unitary_levels(k=1, max_energy=3.0), ValueError, "give k and j"),
        (lambda: unitary_levels(k=1), ValueError, "give k and j"),
        (lambda: unitary_levels(k=1, j=1), ValueError, r"k \+ 2 j must be even, got k = 1, j = 1"),
        (lambda: unitary_levels(k=1, j=0.3), ValueError, "j must be an integer or half-integer"),
        (lambda: unitary_levels(k=0, j=-1), ValueError, "j must be an integer or half-integer of at least 0"),
        (lambda: unitary_levels(k=0, j=[1, 2]), TypeError, "j must be a"),
        (lambda: unitary_levels(c=-1.0, multiplets=2), ValueError, "c must be above -1, got -1.0"),
        (lambda: unitary_levels(inertia=0.0, multiplets=2), ValueError, "inertia must be positive"),
        (lambda: unitary_levels(hbar=-1.0, multiplets=2), ValueError, "hbar must be positive"),
        (lambda: unitary_levels(multiplets=0), ValueError, "multiplets must be"),
        (lambda: unitary_levels(multiplets=10**13), ValueError, "multiplets asks for"),
        (lambda: unitary_levels(max_energy=1e12), ValueError, "max_energy asks for"),
        (lambda: unitary_levels(max_energy="a"), TypeError, "max_energy must be"),
        (lambda: unitary_wave([0.1, 0.2, 0.3], k=0, j=0, m=0, l=0), ValueError, r"q must be .* shape \(4, ...\)"),
        (lambda: unitary_wave([np.nan, 0, 1, 0], k=0, j=0, m=0, l=0), ValueError, "q must be finite"),
        (lambda: unitary_levels(k=2**70, j=0), ValueError, r"k must be at most 2\*\*53 in size"),
        (lambda: unitary_levels(k=0, j=1e10), ValueError, "j asks for"),
        (
            lambda: unitary_wave([0.1, 0.2, -0.3, 0.0], k=0, j=0, m=0, l=0),
            ValueError,
            r"q must have Theta in \[0, pi\]",
        ),
        (lambda: unitary_wave(np.ones(4), k=0, j=1, m=1, l=0), ValueError, "m must be 2 j, 2 j - 2"),
        (lambda: unitary_wave(np.ones(4), k=0, j=1, m=0, l=4), ValueError, "l must be 2 j, 2 j - 2"),
        (lambda: shear_factor(1.0, n=1, m=2, l=-2), ValueError, "n must be below the 1 discrete levels"),
        (lambda: shear_factor(1.0, n=0, m=2, l=2), ValueError, "n must be below the 0 discrete levels"),
        (lambda: shear_factor(-1.0, n=0, m=2, l=-2), ValueError, "b must be at least 0"),
        (lambda: shear_factor("b", n=0, m=2, l=-2), TypeError, "b must be"),
        (lambda: affine_spectrum(fa.Body(fa.Harmonic()), m=0, l=0), TypeError, "model must be an AffineBody, got"),
        (lambda: affine_spectrum(3, m=0, l=0), TypeError, "model must be an AffineBody, got"),
        (lambda: affine_spectrum(MIXED, m=0, l=0), ValueError, r"potential V\(det\) \+ W\(r/det\), got 'k\*r'"),
        (lambda: affine_spectrum(body(B=-0.7), m=0, l=0), ValueError, r"I \+ A and I \+ A \+ 2 B positive"),
        (lambda: affine_spectrum(body(), m=1, l=0), ValueError, r"m \+ l must be even"),
        (lambda: affine_spectrum(body(), m=1.5, l=0), ValueError, "m must be a whole number"),
        (lambda: affine_spectrum(body(), m=0, l=0, count=0), ValueError, "count must be"),
        (lambda: affine_spectrum(body(), m=0, l=0, hbar=0.0), ValueError, "hbar must be positive"),
        (lambda: affine_spectrum(body(), m=0, l=0, tolerance=0.0), ValueError, "tolerance must be positive"),
        (lambda: fa.models.UnitaryBody(c=-2.0), ValueError, "c must be above -1"),
        (lambda: fa.models.UnitaryBody(inertia=0.0), ValueError, "inertia must be positive"),
        (lambda: fa.models.UnitaryBody(3), TypeError, "potential must be a text"),
        (lambda: fa.models.UnitaryBody("cos(Phi)"), ValueError, "potential: unknown name 'Phi'"),
        (lambda: fa.models.UnitaryBody("a**2"), ValueError, r"periodic\['a'\] must be a period"),
        (lambda: g.one_parameter_group(np.ones((2, 3)), 1.0), ValueError, "W must be"),
        (lambda: g.UNITARY.geodesic(np.ones(3), np.ones(4), 1.0), ValueError, "q must be"),
        (lambda: g.UNITARY.geodesic(np.ones(4), np.ones(4), "t"), TypeError, "t must be"),
    ],
)
def test_wrong_input_is_named(call, error, match):
    with pytest.raises(error, match=match):
        call()


def test_a_potential_that_binds_too_little_is_named():
    with pytest.raises(fa.quantum.NoGroundState, match="must have a well"):
        affine_spectrum(body(potential=TAU, k=-1.0), m=0, l=0)
