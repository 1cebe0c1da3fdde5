"""Whatever is handed in to a public callable is taken, or refused by a ValueError or TypeError that names the
argument.
"""

import random
import signal
from collections import defaultdict

import battery
import numpy as np
import pytest
from thorough import TIMES

import fastaff as fa
from fastaff.core import numbers

# The clock of the battery may ring in a callback of the garbage collector, which cannot pass it on: it rings again.
pytestmark = pytest.mark.filterwarnings("ignore:(?s).*battery.TooLong:pytest.PytestUnraisableExceptionWarning")

EACH = 16
"""Inputs of each callable in the default suite: 2000 in all."""
MANY = 90 * TIMES
"""The same in the slow one: 13,000 in all, others than those; all there are, 64,000, where it is thorough."""
PAIRS = 4 * TIMES**2
"""Pairs of inputs of each callable in the slow one: 600 in all; 60,000 where it is thorough."""

OF = defaultdict(list)
for _name, *_what in battery.inputs():
    OF[_name].append(tuple(_what))


def judged(name, count, seed):
    """The inputs of a callable, drawn by a seed, that had another outcome than they may have."""
    battery.call(name, battery.base(name))  # compiled before anything is timed
    return wrong(name, [(one,) for one in random.Random(f"{seed} {name}").sample(OF[name], min(count, len(OF[name])))])


def wrong(name, chosen):
    """Those of some inputs of a callable, each one or several arguments with values, that had another outcome."""
    outcomes = {replaced: battery.outcome(name, *replaced) for replaced in chosen}
    return {what: said for what, said in outcomes.items() if said not in ("accepted", "refused")}


def test_every_public_callable_is_in_the_battery():
    missing = set(battery.discovered()) - set(battery.CALLS)
    assert not missing, f"{sorted(missing)}: give each a row of CALLS in tests/battery.py, with arguments that work"
    assert sum(map(len, OF.values())) > 40_000


@pytest.mark.slow
@pytest.mark.parametrize("name", battery.CALLS)
def test_the_calls_that_work_do(name):
    """All kernels run here, for `make bounds` with NUMBA_BOUNDSCHECK=1; every change makes these calls in `judged`."""
    battery.call(name, battery.base(name))


@pytest.mark.parametrize("name", battery.CALLS)
def test_inputs(name):
    assert judged(name, EACH, 1) == {}


@pytest.mark.parametrize("name", battery.CALLS)
def test_nothing_in_particular_is_taken_nowhere(name):
    """In place of any argument, needed here or not."""
    said = {argument: battery.outcome(name, (argument, "object")) for argument in battery.arguments(name)}
    assert set(said.values()) <= {"refused"}, said


@pytest.mark.parametrize("name", [name for name in battery.CALLS if battery.numeric(name)])
def test_no_part_of_a_number_is_thrown_away(name):
    """Of what is complex, masked, True or has a unit, in place of each number and array: nothing is taken."""
    taken = {}
    for argument, value in battery.numeric(name).items():
        for kind in battery.astray(value):
            said = battery.outcome(name, (argument, kind))
            if said != "refused":
                taken[argument, kind] = said
    assert taken == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", battery.CALLS)
def test_many_inputs(name):
    assert judged(name, MANY, 2) == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", battery.CALLS)
def test_pairs_of_inputs(name):
    """What is refused alone is refused beside another wrong argument too, by the name of either."""
    battery.call(name, battery.base(name))
    source = random.Random(f"3 {name}")
    pairs = [tuple(source.choices(OF[name], k=2)) for _ in range(PAIRS if OF[name] else 0)]
    assert wrong(name, [pair for pair in pairs if pair[0][0] != pair[1][0]]) == {}


# --- what can't fit -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "argument"),
    [
        ("integrate", "samples"),
        ("poincare_map", "crossings"),
        ("chaos_map", "history"),
        ("islands", "max_islands"),
        ("energy_sample", "orbits"),
    ],
)
@pytest.mark.parametrize("value", [10**10, 10**15])
def test_sizes_that_cannot_fit_are_refused_with_the_bytes(name, argument, value):
    function, _ = battery.CALLS[name]
    with pytest.raises(ValueError, match=rf"{argument} asks for \S+ [KMGTPE]iB of memory .*\S+ [KMG]iB are free"):
        function(**{**battery.base(name), argument: value})


def test_the_least_array_that_does_not_fit(monkeypatch):
    monkeypatch.setattr(numbers, "free_memory", lambda: 8 * 2**20)
    numbers.fits("n", 2**10, 2**10)
    with pytest.raises(
        ValueError, match=r"^n asks for 8.008 MiB of memory \(an array of 1024 x 1025\), 8 MiB are free$"
    ):
        numbers.fits("n", 2**10, 2**10 + 1)
    with pytest.raises(ValueError, match="EiB of memory"):
        numbers.fits("n", *[2**53] * 5)


def test_memory_that_is_free():
    """What the system tells, between a megabyte and a petabyte; an array of a tenth of it can be made (not touched)."""
    free = numbers.free_memory()
    assert 2**20 < free < 2**50
    np.empty(free // 80)


@pytest.mark.parametrize("T", [1e17, 1e18, 1e300])
@pytest.mark.parametrize("name", ["integrate", "poincare_map", "frequency_map", "chaos_map", "tangent_map"])
def test_times_that_no_run_comes_to_the_end_of(name, T):
    """More steps than 2**53."""
    function, _ = battery.CALLS[name]
    argument = "max_time" if name == "poincare_map" else "time"
    with pytest.raises(ValueError, match=r"needs \S+ steps of \S+: no run comes to its end"):
        function(**{**battery.base(name), argument: T})


@pytest.mark.parametrize(
    "name", ["integrate", "poincare_map", "frequency_map", "chaos_map", "tangent_map", "resonances", "action_angles"]
)
@pytest.mark.parametrize("value", [1, "x", (), {}])
def test_a_report_is_a_function(name, value):
    function, _ = battery.CALLS[name]
    with pytest.raises(TypeError, match="callback must be a function of the fraction done, or None, got"):
        function(**{**battery.base(name), "callback": value})


def test_long_arguments_make_short_messages():
    with pytest.raises(TypeError) as caught:
        fa.integrate(battery.HH, battery.Z4, time=list(range(10**5)))
    assert len(str(caught.value)) < 300


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers here")
def test_the_battery_notices_what_it_looks_for(monkeypatch):
    """Messages without the name, other exceptions, warnings and calls that take long are told from refusals."""

    def known(kind):
        if kind == 1:
            raise ValueError("something is wrong")
        if kind == 7:
            raise ValueError("kind must not be 7")
        if kind == 2.7:
            np.log(np.zeros(1))
        if kind is None:
            while True:
                pass
        return {}[kind]

    monkeypatch.setitem(battery.CALLS, "known", (known, {"kind": 0}))
    monkeypatch.setattr(battery, "SECONDS", 0.1)
    said = {value: battery.outcome("known", ("kind", value)) for value in ("1", "7", "2.7", "none", "0")}
    assert said["7"] == "refused"
    for value, part in {
        "1": "without the name 'kind'",
        "2.7": "RuntimeWarning",
        "none": "took more than",
        "0": "KeyError",
    }.items():
        assert part in said[value]
