"""Wrong input raises at once and says which argument, what it got and what it takes; nothing is run."""

import re
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from naive import states
from own_models import OneSpring

from fastaff import (
    DOP853,
    KAHAN_LI8,
    AlphaEquals,
    AlphaTurning,
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    Linear,
    NeoHookean,
    frequency_map,
    integrate,
    poincare_map,
)
from fastaff.analysis import BirkhoffAverages
from fastaff.models.angles import AlphaBeta, Coordinates2

BODY, BALL = Body(Hyperelastic()), HenonHeiles()
Z0 = states(BODY, 3)
CALLS = {
    "integrate": (integrate, {"time": 1.0, "step": 0.1}),
    "poincare_map": (poincare_map, {"section": AlphaTurning(), "crossings": 2, "max_time": 5.0, "step": 0.1}),
    "frequency_map": (frequency_map, {"time": 20.0, "step": 0.1}),
}
every_call = pytest.mark.parametrize("call", [*CALLS])
CALLS["BirkhoffAverages"] = (lambda body, z0, **given: BirkhoffAverages(**given), {})


def refused(call, error, *fragments, body=BODY, z0=Z0, **change):
    """Assert that the call raises `error` with a message of all these fragments."""
    function, options = CALLS[call]
    with pytest.raises(error) as caught:
        function(body, z0, **(options | change))
    for fragment in fragments:
        assert re.search(fragment, str(caught.value)), f"{fragment!r} not in {caught.value!s}"


# --- z0 ----------------------------------------------------------------------------------------------------------


@every_call
@pytest.mark.parametrize("shape", [(7,), (4,), (8, 2, 2), (2, 8), (0,), (8, 0), ()])
def test_wrong_shapes(call, shape):
    got = "got shape " + re.escape(str(shape))
    refused(call, ValueError, r"z0 must have shape \(8,\) or \(8, orbits\) for Body", got, z0=np.ones(shape))


@every_call
def test_the_shape_depends_on_the_model(call):
    change = {"section": Linear((1, 0, 0, 0))} if call == "poincare_map" else {}
    refused(call, ValueError, r"\(4,\) or \(4, orbits\) for HenonHeiles, rows x, y", "got shape", body=BALL, **change)


@every_call
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite(call, bad):
    z0 = Z0.copy()
    z0[5, 1] = bad
    refused(call, ValueError, "z0 must be finite; orbit 1 is", r"\(1 such orbits\)", z0=z0)


@every_call
@pytest.mark.parametrize(
    "z0", ["abc", None, [["a"] * 3] * 8, np.ones(8) * 1j, object(), [[1, 2], [3]]], ids=lambda z0: type(z0).__name__
)
def test_what_is_no_array_of_numbers(call, z0):
    refused(call, (TypeError, ValueError), "z0 must (be an array of (real )?numbers|have shape)", z0=z0)


@every_call
@pytest.mark.parametrize(
    "potential", [Hyperelastic(), NeoHookean(), Anharmonic(), HeavyTop()], ids=lambda p: type(p).__name__
)
def test_starts_outside_the_domain(call, potential):
    """det phi <= 0 for the first two, alpha = 0, r = 0."""
    z0 = Z0.copy()
    z0[:4, 2] = [0, 0, 0.5, 0] if isinstance(potential, Anharmonic) else [0.3, 0, 0.3, 0]
    if isinstance(potential, HeavyTop):
        z0[:4, 2] = 0
    fragments = "z0 must lie where the potential lives", "det phi > 0", r"orbit 2 has margin 0 <= 0 \(1 such"
    refused(call, ValueError, *fragments, body=Body(potential), z0=z0)


def test_the_harmonic_body_lives_everywhere():
    integrate(Body(Harmonic()), [0.1, 0, 0.5, 0, 1, 0, 0, 1], time=1.0, step=0.1).raise_if_failed()


@given(st.integers(0, 20), st.integers(0, 3))
def test_any_wrong_shape_is_refused(rows, orbits):
    shape = (rows, orbits)
    if rows == 8 and orbits > 0:
        return
    refused("integrate", ValueError, "z0 must have shape", re.escape(str(shape)), z0=np.ones(shape))


# --- numbers -----------------------------------------------------------------------------------------------------

NUMBERS = [
    ("integrate", "time"),
    ("integrate", "step"),
    ("integrate", "energy_tolerance"),
    ("integrate", "rtol"),
    ("integrate", "atol"),
    ("poincare_map", "max_time"),
    ("poincare_map", "step"),
    ("poincare_map", "energy_tolerance"),
    ("frequency_map", "time"),
    ("frequency_map", "step"),
    ("BirkhoffAverages", "fallback"),
]
every_number = pytest.mark.parametrize(("call", "name"), NUMBERS)


@every_number
@given(value=st.one_of(st.floats(max_value=0.0, allow_nan=False, allow_infinity=False), st.integers(max_value=0)))
def test_sizes_must_be_positive(call, name, value):
    refused(call, ValueError, f"{name} must be (a )?positive", re.escape(repr(value)), **{name: value})


@every_number
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_sizes_must_be_finite(call, name, value):
    if (name, value) == ("fallback", np.inf):
        return  # "never"
    refused(call, ValueError, f"{name} must be (finite|a positive number)", "got", **{name: value})


@every_number
@pytest.mark.parametrize("value", ["0.1", True, [0.1], 1j, b"1"], ids=repr)
def test_sizes_must_be_numbers(call, name, value):
    refused(
        call,
        (TypeError, ValueError),
        f"{name} must be a (real|positive) number",
        re.escape(repr(value)),
        **{name: value},
    )


@pytest.mark.parametrize(
    "value", [np.float32(1.0), np.float64(1.0), 1, np.int64(1), np.array(1.0)], ids=lambda v: type(v).__name__
)
def test_numbers_of_every_make_are_taken(value):
    expected = integrate(BALL, np.full(4, 0.1), time=1.0, step=0.1).z
    np.testing.assert_array_equal(integrate(BALL, np.full(4, 0.1), time=value, step=0.1).z, expected)


COUNTS = [
    ("integrate", "samples", 0),
    ("integrate", "threads", 1),
    ("poincare_map", "crossings", 1),
    ("poincare_map", "threads", 1),
    ("frequency_map", "threads", 1),
]


@pytest.mark.parametrize(("call", "name", "least"), COUNTS)
@given(data=st.data())
def test_counts_have_a_least_value(call, name, least, data):
    value = data.draw(st.integers(-1000, least - 1))
    refused(call, ValueError, f"{name} must be at least {least}, got {value}", **{name: value})


@pytest.mark.parametrize(("call", "name", "least"), COUNTS)
@pytest.mark.parametrize("value", [1.5, 2.0, "3", True, [1]], ids=repr)
def test_counts_must_be_whole(call, name, least, value):
    refused(call, TypeError, f"{name} must be a whole number", re.escape(repr(value)), **{name: value})


@every_call
def test_more_threads_than_there_are(call):
    refused(call, ValueError, "threads must be at most", "got 100000", threads=100_000)


# --- models, schemes, sections, methods --------------------------------------------------------------------------


class Lonely(NamedTuple):
    k: float = 1.0


@every_call
@pytest.mark.parametrize(
    ("body", "fragments"),
    [
        ("Hyperelastic", ["body must be a model such as", "got 'Hyperelastic' \\(str\\)"]),
        (None, ["body must be a model", "None"]),
        (Hyperelastic(), ["body Hyperelastic\\(C=1.0\\) is a potential", "wrap it, Body\\(Hyperelastic"]),
        (Hyperelastic, ["body must be a model"]),
        (Lonely(), ["body Lonely has no degrees_of_freedom, velocity"]),
        (Body(1.0), ["body.potential must be a NamedTuple", "1.0"]),
    ],
    ids=["text", "none", "potential", "class", "lonely", "number"],
)
def test_what_is_no_model(call, body, fragments):
    refused(call, TypeError, *fragments, body=body)


@every_call
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_models_have_finite_parameters(call, bad):
    refused(call, ValueError, "body has a parameter that is not finite", body=Body(Hyperelastic(bad)))


@every_call
@pytest.mark.parametrize("mu", [0.0, -1.0])
def test_inertia_is_positive(call, mu):
    refused(call, ValueError, f"body.mu must be positive, got {mu}", body=Body(Hyperelastic(), mu))


@every_call
@pytest.mark.parametrize("parameter", ["1.0", None, 1j, True], ids=repr)
def test_parameters_are_numbers(call, parameter):
    refused(
        call,
        TypeError,
        r"Hyperelastic.C must be a float",
        re.escape(repr(parameter)),
        body=Body(Hyperelastic(parameter)),
    )


@every_call
@pytest.mark.parametrize("scheme", [False, KAHAN_LI8.__class__, 8], ids=repr)
def test_schemes_are_values(call, scheme):
    refused(
        call,
        TypeError,
        "scheme must be a scheme such as fastaff.KAHAN_LI8",
        "or a name of",
        "DOP853",
        scheme=scheme,
    )


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
        (Linear((1.0, 0.0, 0.0, 0.0)), ValueError, "does not suit a Body: it must take 8 numbers"),
        (Linear((0.0,) * 8), ValueError, "depend on one of them"),
    ],
    ids=["text", "none", "class", "body", "direction", "nan", "string", "short", "zero"],
)
def test_what_is_no_section(section, error, fragment):
    refused("poincare_map", error, fragment, section=section)


def test_sections_of_bodies_do_not_suit_henon_heiles():
    refused(
        "poincare_map", ValueError, "does not suit a HenonHeiles: it must take 4 numbers", body=BALL, z0=np.full(4, 0.1)
    )


@pytest.mark.parametrize("method", [None, 3, BirkhoffAverages], ids=repr)
def test_unknown_methods(method):
    refused(
        "frequency_map",
        TypeError,
        re.escape(
            "method must be BirkhoffAverages() or NaffLines() of fastaff.analysis, or a name, birkhoff or naff; "
        ),
        re.escape(f"got {method!r}") + "$",
        method=method,
    )


def test_names_of_methods():
    refused(
        "frequency_map", ValueError, "method must be one of birkhoff, naff, got 'naf'. Did you mean naff", method="naf"
    )


def test_angles():
    refused("frequency_map", ValueError, "angles must be 'R phi' of 2 coordinates or 'R z phi' of 3", angles="alpha")
    refused("frequency_map", TypeError, "angles must be a text such as 'R z phi'", angles=3)
    refused("frequency_map", ValueError, "angles must have 4 angles for Body", angles=Coordinates2())
    refused(
        "frequency_map",
        ValueError,
        "angles must have 2 angles for HenonHeiles",
        body=BALL,
        z0=np.full(4, 0.1),
        angles=AlphaBeta(),
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
    from fastaff.flows import flow

    def never(*arguments, **options):
        raise AssertionError("a kernel was started")

    monkeypatch.setattr(flow, "launch", never)
    function, options = CALLS[call]
    for change in ({"energy_tolerance": -1.0}, {"threads": 0}, {"scheme": "x"}, {"rtol": 0.0}):
        with pytest.raises((ValueError, TypeError)):
            function(BODY, Z0, **({k: v for k, v in options.items() if k != "step"} | change))


def test_atol_of_an_adaptive_scheme():
    refused("integrate", ValueError, "atol must be positive, got 0.0", scheme=DOP853, atol=0.0)
