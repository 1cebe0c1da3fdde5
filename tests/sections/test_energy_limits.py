"""The least energy of a system and its lowest saddle, and what is said of energies beyond them."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.cli import main as cli
from fastaff.sections.energy_shell import energy_limits, may_escape, too_low
from fastaff.systems.models.mechanics import system_of

HH = fa.HenonHeiles()


@pytest.mark.parametrize("lam", [0.3, 1.0, 7.0])
def test_henon_heiles(lam):
    """Minimum 0 and saddles 1/(6 lam^2)."""
    found = energy_limits(system_of(fa.HenonHeiles(lam)))
    np.testing.assert_allclose(found, (0.0, 1 / (6 * lam**2)), atol=1e-15)


@pytest.mark.parametrize(("p_eta", "p_gamma"), [(0.3, 0.2), (-1.5, 0.0), (0.0, 0.0)])
def test_harmonic(p_eta, p_gamma):
    """A plane oscillator of angular momentum p has at least the energy omega |p|."""
    body = fa.Body(fa.Harmonic(C=4.0), mu=0.25)
    found = energy_limits(system_of(body), p_eta, p_gamma)
    np.testing.assert_allclose(found.minimum, 4.0 * (abs(p_eta) + abs(p_gamma)), rtol=1e-12, atol=1e-15)
    assert np.isnan(found.saddle)


def test_two_wells():
    found = energy_limits(system_of(fa.hamiltonian("h*(x**2 - 1)**2 + y**2 - 3", h=2.0)))
    np.testing.assert_allclose(found, (-3.0, -1.0), rtol=1e-13)


@pytest.mark.parametrize("scale", [1e-5, 1e4])
def test_units_of_length(scale):
    found = energy_limits(system_of(fa.hamiltonian("(x**2 + y**2)/2 + (x**2*y - y**3/3)/s", s=scale)))
    np.testing.assert_allclose(found.saddle, scale**2 / 6, rtol=1e-12)


def test_none_is_known():
    assert np.isnan(energy_limits(system_of(fa.hamiltonian("x + y")))).all()
    assert np.isnan(energy_limits(system_of(fa.hamiltonian("(x**2+y**2+z**2)/2", coordinates="x y z")))).all()
    assert too_low(system_of(fa.hamiltonian("x + y")), -1e9, 0.0, 0.0) is None
    assert may_escape(system_of(fa.Body(fa.Harmonic())), 1e9) is None


def test_the_minimum_is_reached_from_above_alone():
    """Grids and samples exist just above the number that is said, not below."""
    body, at = fa.Body(fa.NeoHookean()), {"p_eta": 0.3, "p_gamma": 0.2, "section": "alpha-turning"}
    least = energy_limits(system_of(body), 0.3, 0.2).minimum
    assert len(fa.energy_sample(body, energy=least + 1e-6, orbits=3, **at)) == 3
    for energy in (least - 1e-6, -1.0):
        said = rf"^energy must be at least the minimum {least:.6g} of this body with p_eta = 0.3 and p_gamma ="
        with pytest.raises(ValueError, match=said):
            fa.energy_sample(body, energy=energy, orbits=3, **at)
        with pytest.raises(ValueError, match=said):
            fa.energy_grid(body, energy=energy, axes=([0.5], [0.0]), **at)


def test_the_least_energy_on_a_section():
    """That of the potential there: 1/2 kinetic energy is left for nothing."""
    body, r = fa.Body(fa.Harmonic(C=2.0), mu=1.0), 3.0
    with pytest.raises(ValueError, match=r"does not reach the section alpha=3: the least energy there is 9$"):
        fa.energy_sample(body, energy=1.0, section=f"alpha={r}", orbits=3)


def test_energies_beyond_the_wells():
    with pytest.raises(ValueError, match=r"^energy must be at least the local minimum 0 of this system, got -1$"):
        fa.energy_sample(HH, energy=-1.0, section="x=0", orbits=3)
    with pytest.raises(ValueError, match=r"^section x=0 is unbounded: energy 1 exceeds the escape energy 0\.166667"):
        fa.energy_sample(HH, energy=1.0, section="x=0", orbits=3)


@pytest.mark.parametrize(
    ("text", "coordinates", "kind"),
    [
        ("(x**2 + y**2)/2 + x**2*y", "x y", "local minimum"),
        ("(x**2 + y**2)/2 + x**2*y**2", "x y", "minimum"),
        ("(x**2 + y**2 + z**2)/2 + x**2*z", "x y z", "local minimum"),
        ("(x**2 + y**2 + z**2)/2 + x**4*z**2", "x y z", "minimum"),
    ],
)
def test_a_minimum_is_local_where_the_potential_falls_below_it(text, coordinates, kind):
    with pytest.raises(ValueError, match=f"^energy must be at least the {kind} 0 of this system, got -0.1$"):
        fa.energy_sample(fa.hamiltonian(text, coordinates=coordinates), energy=-0.1, orbits=3)


def test_a_note_where_orbits_escape(here, capsys):
    words = "poincare --model henon-heiles --energy 1 --q-range=-1:1 --p-range=-1:1 --grid 4x4 --no-diffusion"
    run = words.split()
    assert cli.main([*run, "--crossings", "3", "--no-figure", "--out", "a", "--max-time", "20"]) == 0
    assert capsys.readouterr().err.count("note: energy 1 exceeds the escape energy 0.166667") == 1
    assert cli.main([*run[:4], "1/6", *run[5:], "--crossings", "3", "--no-figure", "--out", "b"]) == 0
    assert "note" not in capsys.readouterr().err
