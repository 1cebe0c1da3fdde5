"""Directions of sections, by a sign in the text or by an argument, and what is said where there is no crossing."""

import numpy as np
import pytest
import shared_systems

import fastaff as fa
from fastaff.systems.formulas.section_text import canonical, section_named
from fastaff.systems.models.mechanics import system_of

FREE = fa.hamiltonian("0*x", coordinates="x")
HENON = fa.HenonHeiles()


def crossed(model, z, section, **more):
    return fa.poincare_map(model, z, section=section, crossings=4, max_time=60.0, **more)


def test_a_particle_that_crosses_downwards_is_told_how_to_ask():
    """TOO_FEW_CROSSINGS said nothing."""
    up = crossed(FREE, [3.0, -4.0], "x=0")
    assert up.counts[0] == 0
    assert up.summary().endswith("1 never cross upwards. Use direction=-1 for crossings downwards, 0 for all.")
    for found in (
        crossed(FREE, [3.0, -4.0], "x=0-"),
        crossed(FREE, [3.0, -4.0], "x = 0 +-"),
        crossed(FREE, [3.0, -4.0], "x=0", direction=-1),
        crossed(FREE, [3.0, -4.0], "x=0", direction=0),
        crossed(FREE, [3.0, -4.0], fa.Hyperplane((1.0, 0.0), 0.0, 1), direction=0),
    ):
        np.testing.assert_allclose(found.times[0, 0], 0.75, rtol=1e-13)
        assert found.section.direction in (0, -1)
    down = crossed(FREE, [-3.0, 4.0], "x=0-")
    assert "1 never cross downwards. Use direction=1 for crossings upwards" in down.summary()
    assert "never" not in crossed(FREE, [-3.0, 4.0], "x=0+-").summary()
    assert "never" not in crossed(HENON, [0.0, 0.1, 0.3, 0.1], "x=0").summary()


def test_signs_and_arguments_are_the_sections_of_these_directions():
    z = np.random.default_rng(3).uniform(-0.2, 0.2, (4, 5))
    for sign, direction in (("", 1), ("+", 1), ("-", -1), ("+-", 0), ("-+", 0), (" - ", -1)):
        for constant in ("0", "0.05", "-0.02", "1/20", "1e-2", "-1e-2"):
            section = section_named(f"x={constant}{sign}", system_of(HENON))
            assert section == section_named(f"x={constant}", system_of(HENON), direction)
            again = section_named(canonical(f"x={constant}{sign}"), system_of(HENON))
            assert again == section
        text, value = (
            crossed(HENON, z, f"x=0.01{sign}"),
            crossed(HENON, z, fa.Hyperplane((1, 0, 0, 0), 0.01, direction)),
        )
        np.testing.assert_array_equal(text.times, value.times)
    body = fa.Body(fa.Hyperelastic(C=1.0), mu=1.0)
    assert section_named("alpha-turning-", system_of(body)) == fa.AlphaTurning(-1)
    assert section_named("alpha-turning", system_of(body)) == fa.AlphaTurning(1)
    assert section_named("beta=0.2+-", system_of(body)) == section_named("beta=0.2", system_of(body), 0)


@pytest.mark.parametrize("direction", [2, -2, 0.5, "up", True, [1]])
def test_wrong_directions_are_refused(direction):
    with pytest.raises((TypeError, ValueError), match="direction must be"):
        crossed(HENON, [0.0, 0.1, 0.3, 0.1], "x=0", direction=direction)


def test_sections_without_a_direction_refuse_one():
    driven = fa.hamiltonian("x**2/2 - a*x*cos(t)", coordinates="x", drive_period="2*pi", a=0.1)
    with pytest.raises(ValueError, match="direction must be left out"):
        fa.poincare_map(driven, [0.1, 0.0], section="t=0", crossings=3, direction=-1)
    with pytest.raises(ValueError, match="leave the sign out"):
        fa.poincare_map(driven, [0.1, 0.0], section="t=0-", crossings=3)
    with pytest.raises(ValueError, match="direction must be left out"):
        fa.poincare_map(fa.models.StandardMap(0.5), [0.1, 0.0], crossings=3, direction=-1)
    for text in ("x=-", "x=+-", "-", "y-"):
        with pytest.raises(ValueError, match="section"):
            crossed(HENON, [0.0, 0.1, 0.3, 0.1], text)


def test_resonances_of_a_map_agree_with_its_figure():
    """Of the own lines, which figures show: loops are 1:1. Their generators are independent."""
    potential = shared_systems.galaxy(core=0.1)
    random = np.random.default_rng(5)
    radius, speed = random.uniform(0.5, 1.5, 24), random.uniform(0.7, 1.1, 24)
    found = fa.frequency_map(potential, [radius, 0 * radius, 0 * radius, speed], time=400.0)
    ratio = found.dominant[1] / found.dominant[0]
    diagonal = found.regular & (np.abs(ratio - 1) < 1e-6)
    assert diagonal.sum() > 5
    named = fa.resonances(found.dominant, errors=found.dominant_error, max_order=4)
    one = (named.rank == 1) & (named.order == 2) & (named.status == 0)
    assert (one[diagonal]).mean() > 0.95
    generators = fa.resonances(found, max_order=4)
    assert ((generators.rank == 1) & (generators.order == 2))[diagonal].mean() < 0.5
