"""Quasiclassical levels of vibrations: closed forms, quadrature, exact levels in the limit of small hbar."""

import types

import numpy as np
import pytest

import fastaff as fa
from fastaff import Classification, Status
from fastaff.quantum import quasiclassical_levels, spectrum
from fastaff.quantum.exact import mode_tori

RNG = np.random.default_rng(311)
MORSE = "D*(1 - exp(-a*x))**2"
PAIR = "(p**2 + r**2)/2 + g*p*r + D*(1 - exp(-a*x))**2 + F*(1 - exp(-b*y))**2"


def morse(D, a, hbar, n):
    omega = a * np.sqrt(2 * D) * hbar * (n + 0.5)
    return omega - omega**2 / (4 * D)


def pair(**numbers):
    return fa.hamiltonian(PAIR, coordinates="x y", momenta="p r", **numbers)


def test_a_morse_oscillator_is_exact():
    D, a, hbar = RNG.uniform(8, 12), RNG.uniform(0.18, 0.3), RNG.uniform(0.1, 0.4)
    model = fa.hamiltonian(MORSE, coordinates="x", D=D, a=a)
    found = quasiclassical_levels(model, n=[[0, 2, 5]], hbar=hbar)
    truth = morse(D, a, hbar, np.array([0, 2, 5]))
    assert found.converged.all()
    assert (np.abs(found.E - truth) <= found.error).all()
    assert found.error.max() < 1e-9
    np.testing.assert_allclose(found.spacing[0], np.gradient(morse(D, a, hbar, np.arange(9.0)))[[0, 2, 5]], rtol=0.1)
    listed = quasiclassical_levels(model, max_energy=float(truth[1]) * 1.001, hbar=hbar)
    np.testing.assert_array_equal(listed.n, [[0, 1, 2]])
    np.testing.assert_allclose(listed.E, morse(D, a, hbar, np.arange(3)), atol=1e-10)


@pytest.mark.parametrize("modes", ["local", pytest.param("normal", marks=pytest.mark.slow)])
def test_a_pair_that_separates_is_a_sum_of_its_bonds(modes):
    D, F, hbar = RNG.uniform(8, 12), RNG.uniform(8, 12), RNG.uniform(0.1, 0.3)
    a, b, slow, fast = RNG.uniform(0.18, 0.2), RNG.uniform(0.26, 0.3), 1, 2
    n, names = ((slow, fast), ("x", "y")) if modes == "local" else ((fast, slow), ("mode 1", "mode 2"))
    found = quasiclassical_levels(pair(D=D, F=F, a=a, b=b, g=0.0), n=n, hbar=hbar, modes=modes)
    assert found.names == names
    assert abs(found.E[0] - morse(D, a, hbar, slow) - morse(F, b, hbar, fast)) <= found.error[0]
    assert found.error[0] < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("number", range(3))
def test_the_difference_from_exact_levels_falls_as_hbar_squared(number):
    rng = np.random.default_rng(number)
    D, F, g = *rng.uniform(8, 12, 2), rng.uniform(-0.1, 0.1)
    model = pair(D=D, F=F, a=rng.uniform(0.18, 0.2), b=rng.uniform(0.26, 0.3), g=g)
    n = np.array([[0, 1], [0, 0]])
    away = []
    for hbar in (0.1, 0.05):
        found = quasiclassical_levels(model, n=n, hbar=hbar)
        exact = spectrum(model, count=3, hbar=hbar)
        away.append(found.E - exact.E[[0, 2]])  # the faster mode is the first
    ratios = np.array(away[:-1]) / np.array(away[1:])
    known = np.isfinite(ratios)  # next to a resonance, 3:2 of the second draw, a level may have no torus
    assert known.any()
    np.testing.assert_allclose(ratios[known], 4.0, rtol=0.15)


def test_maslov_indices_of_librations_rotations_and_other_bases():
    pendulum = fa.hamiltonian("p**2/2 - cos(x)", coordinates="x", momenta="p", periodic={"x": "2*pi"})
    assert fa.fit_torus(pendulum, [0.5, 0.0], time=400.0).maslov.tolist() == [2]
    assert fa.fit_torus(pendulum, [0.0, 2.5], time=400.0).maslov.tolist() == [0]
    linear = fa.hamiltonian("(x**2 + k*y**2)/2", coordinates="x y", k=RNG.uniform(2, 3))
    fit = fa.fit_torus(linear, [0.4, 0.7, 0.1, -0.2], time=400.0)
    assert fit.maslov.tolist() == [2, 2]
    M = np.array([[1, 2], [0, 1]])
    np.testing.assert_array_equal(fit.in_basis(M).maslov, np.linalg.inv(M).T @ fit.maslov)


@pytest.mark.slow
def test_maslov_indices_beside_a_constant_momentum():
    """The azimuth's momentum is the same all over the torus: a libration and a rotation."""
    pendulum = fa.models.SphericalPendulum()
    assert fa.fit_torus(pendulum, [1.0, 0.3, 0.1, 0.5], time=300.0).maslov.tolist() == [2, 0]
    with pytest.raises(ValueError, match=r"got dimension 2 \(undecided\)"):
        _ = fa.fit_torus(pendulum, [1.0, 0.3, 0.1, 0.5], time=3.0).maslov


def test_maslov_indices_of_bodies():
    torus = fa.fit_torus(fa.Body(fa.Hyperelastic()), [1.5, 0.1, 0.3, 0.0, 0.1, 0.3, 0.2, 0.1], time=300.0)
    assert sorted(np.abs(torus.maslov).tolist()) == [0, 0, 2, 2]
    with pytest.raises(ValueError, match=r"maslov must be of a torus of 4 dimensions of a flow, got dimension [0-3]"):
        _ = fa.fit_torus(fa.Body(fa.Harmonic()), [1.5, 0.1, 0.3, 0.0, 0.1, 0.3, 0.2, 0.1], time=100.0).maslov


def test_wrong_calls_say_the_right_one():
    model = fa.hamiltonian(MORSE, coordinates="x", D=10.0, a=0.2)
    for wrong, message in (
        ({"n": [0], "m": 1}, "m is for a Body alone"),
        ({"n": [0], "maslov": (0, 0)}, "maslov is for a Body alone"),
        ({}, "n, guess or max_energy must be given"),
        ({"n": [0], "max_energy": 1.0}, "max_energy must be None with n or guess"),
        ({"n": [-1]}, "n must be whole numbers >= 0 of shape"),
        ({"n": [0, 1]}, "n must be whole numbers >= 0 of shape"),
        ({"n": [0], "modes": "locla"}, "Did you mean local"),
        ({"guess": [1.0, 0.0], "modes": "local"}, "guess must be given without modes"),
    ):
        with pytest.raises(ValueError, match=message):
            quasiclassical_levels(model, **wrong)
    with pytest.raises(ValueError, match="modes is for vibrations and bodies that do not separate"):
        quasiclassical_levels(fa.Body(fa.Harmonic()), n=(0, 0), m=0, l=0, modes="local")
    with pytest.raises(ValueError, match="potential with a minimum"):
        quasiclassical_levels(fa.hamiltonian("-x**4", coordinates="x"), n=[0])


@pytest.mark.parametrize("sign", [-1, 1])
def test_normal_modes_turn_into_local_ones_where_averaging_says(sign):
    """H = omega I - kappa I^2 (1 + z^2)/2 + g omega I sqrt(1 - z^2) cos(psi)/2, kappa = omega^2/4D, of two equal Morse
    bonds: at z = 0, the mode with g cos(psi) < 0, local modes branch off where kappa I = |g| omega/2, up to a share of
    order g.
    """
    D, a = RNG.uniform(8, 12), RNG.uniform(0.2, 0.4)
    omega = a * np.sqrt(2 * D)
    away = []
    for g in (0.02, 0.01):
        text = "(p**2 + r**2)/2 + g*p*r + D*(1 - exp(-a*x))**2 + D*(1 - exp(-a*y))**2"
        model = fa.hamiltonian(text, coordinates="x y", momenta="p r", D=D, a=a, g=sign * g)
        kappa = omega**2 / (4 * D)
        I = g * omega / (2 * kappa)
        E = omega * I - kappa * I**2 / 2 - g * omega * I / 2
        section = fa.Hyperplane(normal=(0, 0, 1, -sign), direction=-1)
        x = np.sqrt(E / 2 / D) / a  # each bond has half the energy
        low, high = E / 2, 2 * E
        branch = fa.continuation(
            model, [0.6 * x, -sign * 0.6 * x, 0, 0], section=section, direction=1, bounds=(low / 2, high), ds_max=0.1
        )
        (found,) = [one for one in branch.bifurcations if one.event.name == "BRANCH_POINT"]
        away.append(found.parameter / E - 1)
    assert abs(away[0]) < 0.04
    np.testing.assert_allclose(away[0] / away[1], 2.0, rtol=0.2)


def test_levels_without_a_torus_name_the_calls_that_go_on(monkeypatch):
    """A torus in a resonance is one of islands, whose classification is no torus of all dimensions."""
    fit = types.SimpleNamespace(classification=Classification.RESONANT, evidence={})
    monkeypatch.setattr(mode_tori, "fit_torus", lambda *given, **named: fit)
    found = quasiclassical_levels(fa.HenonHeiles(), n=[0, 1], hbar=0.01)
    assert found.status.tolist() == [Status.NOT_CONVERGED]
    assert np.isnan(found.E).all()
    assert "no torus of these modes" in found.summary()
    assert "quasiclassical_levels(..., guess=z0)" in found.summary()
    assert "spectrum(...)" in found.summary()
