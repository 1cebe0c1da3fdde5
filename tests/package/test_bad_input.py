"""Wrong input raises at once and says which argument, what it got and what it takes; nothing is run."""

import re
from typing import NamedTuple

import numpy as np
import pytest
from naive import states
from own_models import OneSpring

from fastaff import (
    DOP853,
    AlphaEquals,
    AlphaTurning,
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    Hyperplane,
    frequency_map,
    integrate,
    poincare_map,
)
from fastaff.systems.models.angles import AlphaBeta, Coordinates2

BODY, BALL = Body(Hyperelastic()), HenonHeiles()
Z0 = states(BODY, 3)
CALLS = {
    "integrate": (integrate, {"time": 1.0, "step": 0.1}),
    "poincare_map": (poincare_map, {"section": AlphaTurning(), "crossings": 2, "max_time": 5.0, "step": 0.1}),
    "frequency_map": (frequency_map, {"time": 20.0, "step": 0.1}),
}
every_call = pytest.mark.parametrize("call", [*CALLS])


def refused(call, error, *fragments, model=BODY, z0=Z0, **change):
    """Assert that the call raises `error` with a message of all these fragments."""
    function, options = CALLS[call]
    with pytest.raises(error) as caught:
        function(model, z0, **(options | change))
    for fragment in fragments:
        assert re.search(fragment, str(caught.value)), f"{fragment!r} not in {caught.value!s}"


def misplaced(row, value):
    """Starts with one that is not as it should be."""
    z0 = Z0.copy()
    z0[row] = value
    return z0


# --- z0 and numbers ----------------------------------------------------------------------------------------------
# tests/battery.py hands in whatever can be wrong; here are the sentences.

SENTENCES = [
    (ValueError, r"z0 must have shape \(8,\) or \(8, orbits\) for Body.* got shape \(7,\)", {"z0": np.ones(7)}),
    (ValueError, r"z0 must have shape .* got shape \(8, 0\)", {"z0": np.ones((8, 0))}),
    (ValueError, r"z0 must have shape .* got shape \(\)", {"z0": 1.0}),
    (ValueError, r"\(4,\) or \(4, orbits\) for HenonHeiles, rows x, y.* got shape", {"model": BALL}),
    (ValueError, r"(?s)z0 must be finite; orbit 1 is .*\(1 such orbits\)", {"z0": misplaced((5, 1), np.nan)}),
    (ValueError, r"z0 must be finite; orbit 1 is", {"z0": misplaced((5, 1), -np.inf)}),
    (TypeError, "z0 must be an array of (real )?numbers", {"z0": "abc"}),
    (TypeError, "z0 must be an array of (real )?numbers", {"z0": np.ones(8) * 1j}),
    ((TypeError, ValueError), "z0 must (be an array of (real )?numbers|have shape)", {"z0": [[1, 2], [3]]}),
    (ValueError, "step must be (a )?positive.* got -0.1", {"step": -0.1}),
    (ValueError, "step must be (finite|a positive number).* got nan", {"step": np.nan}),
    (TypeError, "step must be a (real|positive) number.* got True", {"step": True}),
    (ValueError, "energy_tolerance must be (a )?positive.* got 0", {"energy_tolerance": 0}),
    (TypeError, "energy_tolerance must be a real number.* got '0.1'", {"energy_tolerance": "0.1"}),
    (ValueError, "threads must be at least 1, got 0", {"threads": 0}),
    (TypeError, "threads must be a whole number.* got 2.0", {"threads": 2.0}),
    (ValueError, "threads must be at most .* got 100000", {"threads": 100_000}),
    (ValueError, "model has a parameter that is not finite", {"model": Body(Hyperelastic(np.nan))}),
    (ValueError, "model.mu must be positive, got -1.0", {"model": Body(Hyperelastic(), -1.0)}),
    (TypeError, "Hyperelastic.C must be a float.* got '1.0'", {"model": Body(Hyperelastic("1.0"))}),
    (TypeError, "scheme must be a scheme such as fastaff.KAHAN_LI8.* or a name of .*DOP853", {"scheme": 8}),
]


@every_call
@pytest.mark.parametrize(("error", "said", "change"), SENTENCES, ids=[said for _, said, _ in SENTENCES])
def test_sentences(call, error, said, change):
    linear = {"section": Hyperplane((1, 0, 0, 0))} if call == "poincare_map" and change.get("model") is BALL else {}
    refused(call, error, said, **linear, **change)


@pytest.mark.parametrize(
    ("call", "error", "said", "change"),
    [
        ("integrate", ValueError, "time must be (a )?positive.* got 0", {"time": 0}),
        ("frequency_map", ValueError, "time must be finite.* got inf", {"time": np.inf}),
        ("poincare_map", ValueError, "max_time must be (a )?positive.* got -1", {"max_time": -1.0}),
        ("integrate", TypeError, r"rtol must be a real number.* got \[0.1\]", {"rtol": [0.1]}),
        ("integrate", ValueError, "atol must be positive, got 0.0", {"scheme": DOP853, "atol": 0.0}),
        ("integrate", ValueError, "samples must be at least 0, got -3", {"samples": -3}),
        ("integrate", TypeError, "samples must be a whole number.* got 1.5", {"samples": 1.5}),
        ("poincare_map", ValueError, "crossings must be at least 1, got 0", {"crossings": 0}),
        ("poincare_map", TypeError, "crossings must be a whole number.* got True", {"crossings": True}),
    ],
)
def test_sentences_of_one_call(call, error, said, change):
    refused(call, error, said, **change)


@pytest.mark.parametrize(
    ("potential", "start"),
    [(Hyperelastic(), (0.3, 0, 0.3, 0)), (Anharmonic(), (0, 0, 0.5, 0)), (HeavyTop(), (0, 0, 0, 0))],
    ids=lambda p: type(p).__name__,
)
def test_starts_outside_the_domain(potential, start):
    """det phi <= 0, alpha = 0, r = 0."""
    z0 = misplaced((slice(4), 2), start)
    said = r"z0 must lie where the potential lives.*det phi > 0.*orbit 2 has margin 0 <= 0 \(1 such"
    refused("integrate", ValueError, said, model=Body(potential), z0=z0)


def test_the_harmonic_body_lives_everywhere():
    integrate(Body(Harmonic()), [0.1, 0, 0.5, 0, 1, 0, 0, 1], time=1.0, step=0.1).raise_if_failed()


@pytest.mark.parametrize(
    "value", [np.float32(1.0), np.float64(1.0), 1, np.int64(1), np.array(1.0)], ids=lambda v: type(v).__name__
)
def test_numbers_of_every_make_are_taken(value):
    expected = integrate(BALL, np.full(4, 0.1), time=1.0, step=0.1).z
    np.testing.assert_array_equal(integrate(BALL, np.full(4, 0.1), time=value, step=0.1).z, expected)


# --- models, schemes, sections, methods --------------------------------------------------------------------------


class Lonely(NamedTuple):
    k: float = 1.0


@every_call
@pytest.mark.parametrize(
    ("body", "fragments"),
    [
        ("Hyperelastic", ["model must be a model such as", "got 'Hyperelastic' \\(str\\)"]),
        (None, ["model must be a model", "None"]),
        (Hyperelastic(), ["model Hyperelastic\\(C=1.0\\) is a potential", "wrap it, Body\\(Hyperelastic"]),
        (Hyperelastic, ["model must be a model"]),
        (Lonely(), ["model Lonely has no degrees_of_freedom, velocity"]),
        (Body(1.0), ["model.potential must be a NamedTuple", "1.0"]),
    ],
    ids=["text", "none", "potential", "class", "lonely", "number"],
)
def test_what_is_no_model(call, body, fragments):
    refused(call, TypeError, *fragments, model=body)


@pytest.mark.parametrize(
    ("section", "error", "fragment"),
    [
        ("alpha", ValueError, "section must be one of alpha-turning, .* got 'alpha'"),
        (None, TypeError, "section must be a section"),
        (AlphaTurning, TypeError, "section must be a section"),
        (BODY, TypeError, "section must be a section"),
        (AlphaTurning(2), ValueError, "section.direction must be -1, 0 or \\+1, got 2"),
        (AlphaEquals(np.nan), ValueError, "section has a parameter that is not finite"),
        (AlphaEquals("1"), TypeError, "AlphaEquals.constant must be a float"),
        (Hyperplane((1.0, 0.0, 0.0, 0.0)), ValueError, "does not suit a Body: it must take 8 numbers"),
        (Hyperplane((0.0,) * 8), ValueError, "depend on one of them"),
    ],
    ids=["text", "none", "class", "body", "direction", "nan", "string", "short", "zero"],
)
def test_what_is_no_section(section, error, fragment):
    refused("poincare_map", error, fragment, section=section)


def test_sections_of_bodies_do_not_suit_henon_heiles():
    refused(
        "poincare_map",
        ValueError,
        "does not suit a HenonHeiles: it must take 4 numbers",
        model=BALL,
        z0=np.full(4, 0.1),
    )


def test_angles():
    refused("frequency_map", ValueError, "signals must be 'R phi' of 2 coordinates or 'R z phi' of 3", signals="alpha")
    refused("frequency_map", TypeError, "signals must be a text such as 'R z phi'", signals=3)
    refused("frequency_map", ValueError, "signals must have 4 angles for Body", signals=Coordinates2())
    refused(
        "frequency_map",
        ValueError,
        "signals must have 2 angles for HenonHeiles",
        model=BALL,
        z0=np.full(4, 0.1),
        signals=AlphaBeta(),
    )


def test_a_model_without_angles_of_its_own():
    """Its coordinates and momenta are loops enough."""
    found = frequency_map(OneSpring(), np.ones(2), time=300.0)
    np.testing.assert_allclose(found.nu, np.sqrt(OneSpring().k) / (2 * np.pi), rtol=1e-10)


@every_call
def test_unknown_options_and_positions(call):
    function, options = CALLS[call]
    with pytest.raises(TypeError, match="unexpected keyword argument 'steps'"):
        function(BODY, Z0, **options, steps=3)
    with pytest.raises(TypeError, match="positional argument"):
        function(BODY, Z0, 1.0)


@every_call
def test_nothing_is_run_before_all_is_checked(call, monkeypatch):
    """The last option is wrong: no kernel may have been started for the others."""
    from fastaff.runs import flow

    def never(*arguments, **options):
        raise AssertionError("a kernel was started")

    monkeypatch.setattr(flow, "launch", never)
    function, options = CALLS[call]
    for change in ({"energy_tolerance": -1.0}, {"threads": 0}, {"scheme": "x"}, {"rtol": 0.0}):
        with pytest.raises((ValueError, TypeError)):
            function(BODY, Z0, **({k: v for k, v in options.items() if k != "step"} | change))
