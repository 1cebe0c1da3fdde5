"""Wrong input raises before anything is run; numbers of every make are taken. The sentences are in `refusals`."""

import numpy as np
import pytest
from naive import states
from own_models import OneSpring

from fastaff import (
    AlphaTurning,
    Body,
    Harmonic,
    HenonHeiles,
    Hyperelastic,
    frequency_map,
    integrate,
    poincare_map,
)

BODY, BALL = Body(Hyperelastic()), HenonHeiles()
Z0 = states(BODY, 3)
CALLS = {
    "integrate": (integrate, {"time": 1.0, "step": 0.1}),
    "poincare_map": (poincare_map, {"section": AlphaTurning(), "crossings": 2, "max_time": 5.0, "step": 0.1}),
    "frequency_map": (frequency_map, {"time": 20.0, "step": 0.1}),
}
every_call = pytest.mark.parametrize("call", [*CALLS])


def test_the_harmonic_body_lives_everywhere():
    integrate(Body(Harmonic()), [0.1, 0, 0.5, 0, 1, 0, 0, 1], time=1.0, step=0.1).raise_if_failed()


@pytest.mark.parametrize(
    "value", [np.float32(1.0), np.float64(1.0), 1, np.int64(1), np.array(1.0)], ids=lambda v: type(v).__name__
)
def test_numbers_of_every_make_are_taken(value):
    expected = integrate(BALL, np.full(4, 0.1), time=1.0, step=0.1).z
    np.testing.assert_array_equal(integrate(BALL, np.full(4, 0.1), time=value, step=0.1).z, expected)


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
