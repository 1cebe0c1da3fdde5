"""What is printed at a prompt takes a screen: signatures, schemes, charts and results, whatever their size."""

import inspect
import pydoc

import battery
import numpy as np
import pytest

import fastaff as fa
from fastaff.results.display import SMALL, brief, screen
from fastaff.runs.schemes.catalogue import SCHEMES, compose

LINES, CHARACTERS = 40, 4000


def fits_a_screen(value):
    """Assert that a repr fits a screen."""
    text = repr(value)
    assert len(text.splitlines()) <= LINES, text
    assert len(text) <= CHARACTERS, text


@pytest.mark.parametrize("name", [name for name, value in battery.PUBLIC.items() if not inspect.isclass(value)])
def test_public_values(name):
    fits_a_screen(battery.PUBLIC[name])


@pytest.mark.parametrize("name", [name for name, value in battery.PUBLIC.items() if inspect.isfunction(value)])
def test_signatures(name):
    """One paragraph: no coefficients."""
    signature = str(inspect.signature(battery.PUBLIC[name]))
    assert len(signature) < 1200
    first = pydoc.plain(pydoc.render_doc(battery.PUBLIC[name])).splitlines()[2]
    assert len(first) < 1200
    for scheme in SCHEMES:
        assert f"{scheme}'" not in signature


def scheme_by_default(scheme=fa.KAHAN_LI8):
    """A function of a user's own."""


def test_a_signature_names_its_scheme():
    assert "=KAHAN_LI8)" in str(inspect.signature(scheme_by_default))


@pytest.mark.parametrize("name", [name for name in battery.CALLS if "." not in name and name not in battery.OF_TEXTS])
def test_results(name):
    result = battery.CALLS[name][0](**battery.base(name))
    fits_a_screen(result)
    assert len(str(result).splitlines()) <= LINES


def test_schemes_are_shown_by_name():
    assert [repr(scheme) for scheme in SCHEMES.values()] == list(SCHEMES)
    mine = compose(fa.LEAPFROG, ["0.4"], name="mine", order=2, source="somebody 2000")
    assert repr(mine) == "Splitting(name='mine', order=2, stages=3)"
    impostor = fa.schemes.Splitting("KAHAN_LI8", 2, "somebody 2000", mine.drift, mine.kick)
    assert repr(impostor) == "Splitting(name='KAHAN_LI8', order=2, stages=3)"
    assert (
        repr(fa.TimeTransformed(rate=fa.schemes.Logistic(1.0, 2.0)))
        == "TimeTransformed(KAHAN_LI8, Logistic(kappa=1.0, origin=2.0))"
    )


def test_a_large_result_is_no_longer_than_a_small_one():
    sizes = []
    for orbits in (2, 500):
        z0 = np.repeat(battery.Z4[:, :1], orbits, axis=1)
        cut = fa.poincare_map(battery.HH, z0, section=battery.X, crossings=2, max_time=30.0, step=0.1)
        sizes.append(len(str(cut)))
        assert repr(cut).startswith(f"SectionMap: {orbits} orbits, {2 * orbits} crossings: {orbits} OK")
        assert "\n" not in repr(cut)
        assert str(cut).startswith(f"{cut!r}\n")
        assert f"float64 (4, 2, {orbits})" in str(cut)
        assert "KAHAN_LI8" in str(cut)
        fits_a_screen(str(cut))
    assert abs(sizes[1] - sizes[0]) < 100


def test_values_in_one_line():
    assert brief(np.arange(3.0)) == "[0., 1., 2.]"
    assert brief(np.zeros(SMALL + 1)) == f"float64 ({SMALL + 1},)"
    assert brief(np.zeros((2, 2), complex)) == "complex128 (2, 2)"
    assert brief((np.zeros(9), 1)) == "(float64 (9,), 1)"
    assert brief(("a",)) == "('a',)"
    assert brief(list(range(9))) == "[0, 1, 2, 3, 4, 5, ... 9 in all]"
    assert brief(battery.HH) == "HenonHeiles(lam=1.0)"


def test_a_result_within_a_result_takes_a_line():
    assert len(screen(fa.islands(battery.POINTS)).splitlines()) == 1 + len(fa.sections.Islands.__dataclass_fields__)
