"""What every function of sets keeps to, whatever it computes: the same bits for any number of threads, any order of the
items and any company of an item, and Ctrl-C that hands over what is finished.

A new public function of sets, or one with `threads` or `report`, needs a row in ROWS, or a reason in EXEMPT.
"""

import sys
from functools import cache, partial
from typing import Any, NamedTuple

import battery
import naive
import numpy as np
import pytest
from comparison import same

import fastaff as fa
from fastaff.base.results import Result
from fastaff.flows import flow

THREADS, ORDER, COMPANY, INTERRUPTION = PROMISES = ("threads", "order", "company", "interruption")

HH, BODY, HARMONIC, X, TURN = battery.HH, battery.BODY, battery.HARMONIC, battery.X, battery.TURN


class Row(NamedTuple):
    """A function and a set: arrays with an item at each place of their last axis (`axis`), and its other arguments.

    without: the promises that it does not make, each with the reason.
    """

    function: Any
    sets: dict[str, np.ndarray]
    given: dict[str, Any]
    without: dict[str, str] = {}
    axis: int = -1

    def __call__(self, items=slice(None), **more):
        chosen = {name: np.asarray(array).take(self.numbers[items], self.axis) for name, array in self.sets.items()}
        return self.function(**chosen, **self.given, **more)

    @property
    def numbers(self):
        return np.arange(np.shape(next(iter(self.sets.values())))[self.axis])


def wild(orbits, seed=3):
    """Henon-Heiles orbits of all kinds: regular, chaotic, escaping, and one at rest."""
    z0 = naive.states(HH, orbits, seed)
    z0[:, ::5] *= 1.4
    z0[:, 7] = 0.0
    return z0


FEW, MANY, BODIES = wild(40), wild(200), naive.states(BODY, 150)
FIXED = {"step": 0.1, "energy_tolerance": 1e9}
DOP853 = {"scheme": fa.DOP853, "rtol": 1e-9, "atol": 1e-9}
SLOWED = {"step": 0.1, "scheme": fa.TimeTransformed(fa.KAHAN_LI8, fa.schemes.Logistic(0.1, 0.05))}
LIMITED = {"time": 30.0}
STREAMED = (fa.Lyapunov(), fa.MEGNO(), fa.SALI(), fa.GALI(4))
PASSES = (fa.LyapunovSpectrum(), fa.BirkhoffDigits(), fa.ReversibilityError(), fa.FrequencyDiffusion(), fa.ZeroOne())
FRAME = np.linalg.qr(np.random.default_rng(2).normal(size=(8, 8)))[0]
CUT = {"section": X, "crossings": 4, "max_time": 30.0}
CLOSED = np.array([0.0, 0.0, 0.3, 0.31])
NEAR = CLOSED[:, None] + 0.02 * np.random.default_rng(5).standard_normal((4, 9))
NEAR[:, 4] = 0.0, 5.0, 0.1, 0.1
ACTIONS = np.random.default_rng(12).choice([1e-6, 1e-3, 0.1, 1.0, 5.0], (4, 60)) * np.array([[1], [1], [1], [-1]])
TURNS = np.random.default_rng(13).random((4, 60))
RATIOS = np.random.default_rng(4).integers(-9, 10, (4, 300)) + 1e-10 * np.random.default_rng(5).random((4, 300))
SIGNALS = np.random.default_rng(7).normal(size=(300, 256)) + np.exp(0.3j * np.arange(256))
CURVES = np.random.default_rng(8).normal(size=(2, 1, 12)) + np.array(
    [np.cos(np.outer(np.arange(250), np.linspace(0.3, 2.5, 12))), np.sin(np.outer(np.arange(250), np.linspace(0.3, 2.5, 12)))]
)
CURVES[:, :, 9:] = np.random.default_rng(9).random((2, 250, 3))

ROWS = {
    "integrate": Row(fa.integrate, {"z0": FEW}, {"body": HH, **LIMITED, "samples": 3}),
    "integrate, given step": Row(fa.integrate, {"z0": MANY}, {"body": HH, **LIMITED, **FIXED, "samples": 3}),
    "integrate, a step each": Row(
        fa.integrate, {"z0": FEW, "step": np.geomspace(0.01, 0.2, 40)}, {"body": HH, **LIMITED}
    ),
    "integrate, adaptive": Row(fa.integrate, {"z0": MANY}, {"body": HH, **LIMITED, **DOP853, "samples": 3}),
    "integrate, time-transformed": Row(fa.integrate, {"z0": FEW}, {"body": HH, **LIMITED, **SLOWED, "samples": 3}),
    "tangent_map": Row(fa.tangent_map, {"z0": FEW}, {"body": HH, **LIMITED}),
    "tangent_map, given step": Row(fa.tangent_map, {"z0": FEW}, {"body": HH, **LIMITED, **FIXED}),
    "tangent_map, adaptive": Row(fa.tangent_map, {"z0": FEW}, {"body": HH, **LIMITED, **DOP853}),
    "chaos_map": Row(fa.chaos_map, {"z0": MANY}, {"body": HH, "time": 100.0, "indicators": STREAMED, "history": 2}),
    "chaos_map, given step": Row(
        fa.chaos_map, {"z0": MANY}, {"body": HH, "time": 100.0, "indicators": STREAMED, **FIXED}
    ),
    "chaos_map, adaptive": Row(
        fa.chaos_map, {"z0": MANY}, {"body": HH, "time": 100.0, "indicators": STREAMED, **DOP853}
    ),
    "chaos_map, early stop": Row(
        fa.chaos_map, {"z0": FEW}, {"body": HH, "time": 300.0, "indicators": STREAMED, "early_stop": True}
    ),
    "chaos_map, other passes": Row(fa.chaos_map, {"z0": FEW}, {"body": HH, "time": 100.0, "indicators": PASSES}),
    "chaos_map, given vectors": Row(
        fa.chaos_map,
        {"z0": BODIES[:, :40]},
        {"body": BODY, "time": 20.0, "indicators": (fa.LyapunovSpectrum(),), "deviations": FRAME, "step": 0.1},
    ),
    "frequency_map": Row(fa.frequency_map, {"z0": FEW}, {"body": HH, "time": 100.0}),
    "frequency_map, given step": Row(fa.frequency_map, {"z0": BODIES}, {"body": BODY, "time": 40.0, "step": 0.1}),
    "frequency_map, adaptive": Row(fa.frequency_map, {"z0": BODIES[:, :40]}, {"body": BODY, "time": 40.0, **DOP853}),
    "frequency_map, adaptive by a step": Row(
        fa.frequency_map, {"z0": BODIES[:, :40]}, {"body": BODY, "time": 40.0, "step": 0.06, **DOP853}
    ),
    "frequency_map, lines": Row(
        fa.frequency_map, {"z0": BODIES[:, :40]}, {"body": BODY, "time": 40.0, "step": 0.1, "method": "naff"}
    ),
    "poincare_map": Row(fa.poincare_map, {"z0": FEW}, {"body": HH, **CUT}),
    "poincare_map, given step": Row(fa.poincare_map, {"z0": MANY}, {"body": HH, **CUT, **FIXED}),
    "poincare_map, adaptive": Row(fa.poincare_map, {"z0": MANY}, {"body": HH, **CUT, **DOP853}),
    "poincare_map, time-transformed": Row(fa.poincare_map, {"z0": FEW}, {"body": HH, **CUT, **SLOWED}),
    "periodic_orbits": Row(fa.periodic_orbits, {"z0": NEAR}, {"model": HH, "section": X}),
    "periodic_orbits, given step": Row(fa.periodic_orbits, {"z0": NEAR}, {"model": HH, "section": X, "step": 0.07}),
    "action_angles": Row(fa.action_angles, {"z0": BODIES}, {"body": BODY}),
    "action_angles, closed": Row(fa.action_angles, {"z0": BODIES}, {"body": HARMONIC}),
    "constants_of_motion": Row(fa.constants_of_motion, {"z": BODIES}, {"body": BODY}),
    "energy_of_actions": Row(fa.energy_of_actions, {"J": ACTIONS}, {"body": fa.Body(fa.HeavyTop(0.7, 1.6), 1.3)}),
    "energy_of_actions, closed": Row(fa.energy_of_actions, {"J": ACTIONS}, {"body": HARMONIC}),
    "from_action_angles": Row(fa.from_action_angles, {"J": abs(ACTIONS), "theta": TURNS}, {"body": BODY}),
    "from_action_angles, closed": Row(
        fa.from_action_angles, {"J": abs(ACTIONS), "theta": TURNS}, {"body": HARMONIC}
    ),
    "naff": Row(fa.naff, {"signal": SIGNALS}, {"dt": 0.1, "lines": 3}, axis=0),
    "resonances": Row(fa.resonances, {"nu": RATIOS}, {"max_order": 6}),
    "rotation_number": Row(fa.rotation_number, {"points": CURVES}, {}),
    "islands": Row(fa.islands, {"points": CURVES}, {"max_period": 6}),
}


def items(result, numbers):
    """Some of the items of a result, an array, or a dict of arrays."""
    if isinstance(result, dict):
        return {name: items(value, numbers) for name, value in result.items()}
    return result.take(numbers) if isinstance(result, Result) else result[..., numbers]


@cache
def whole(name):
    row = ROWS[name]
    return row(threads=1) if "threads" in battery.arguments(name.partition(",")[0]) else row()


@pytest.mark.parametrize("name", ROWS)
def test_any_number_of_threads_gives_the_same_bits(name, two_threads):
    if "threads" in battery.arguments(name.partition(",")[0]):
        same(ROWS[name](threads=2), whole(name))

@pytest.mark.parametrize("name", ROWS)
def test_any_order_gives_the_same_bits(name):
    order = np.random.default_rng(1).permutation(ROWS[name].numbers)
    same(ROWS[name](order), items(whole(name), order))


@pytest.mark.parametrize("name", ROWS)
def test_any_company_gives_the_same_bits(name):
    rng, numbers = np.random.default_rng(2), ROWS[name].numbers
    for count in (1, 1, 2, 5, len(numbers) // 2):
        chosen = rng.choice(numbers, count, replace=False)
        same(ROWS[name](chosen), items(whole(name), chosen))
