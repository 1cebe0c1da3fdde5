"""What every function of sets keeps to, whatever it computes: the same bits for any number of threads, any order of the
items and any company of an item, and Ctrl-C that hands over what is finished.

A new public function of sets, or one with `threads` or `callback`, needs a row in ROWS, or a reason in EXEMPT.
"""

import dataclasses
import sys
from functools import cache
from typing import Any, NamedTuple

import battery
import naive
import numpy as np
import pytest
import shared_systems
from comparison import same

import fastaff as fa
from fastaff.results.result import Result
from fastaff.runs import flow
from fastaff.runs.flow import escape_radii
from fastaff.runs.scales import vector_rates
from fastaff.systems.models.mechanics import system_of

HH, BODY, HARMONIC, X, TURN = battery.HH, battery.BODY, battery.HARMONIC, battery.X, battery.TURN


class Row(NamedTuple):
    """A function of a set: arrays with an item at each place of their last axis (`axis`), and its other arguments."""

    function: Any
    sets: dict[str, np.ndarray]
    given: dict[str, Any]
    axis: int = -1

    def __call__(self, items=slice(None), **more):
        chosen = {name: array.take(self.numbers[items], self.axis) for name, array in self.sets.items()}
        return self.function(**chosen, **self.given, **more)

    @property
    def numbers(self):
        """The numbers of all items."""
        return np.arange(next(iter(self.sets.values())).shape[self.axis])


def wild(orbits, seed=3):
    """Henon-Heiles orbits of all kinds: regular, chaotic, escaping, and one at rest."""
    z0 = naive.states(HH, orbits, seed)
    z0[:, ::5] *= 1.4
    z0[:, 7] = 0.0
    return z0


FEW, MANY, BODIES = wild(40), wild(200), naive.states(BODY, 150)
FAST = np.where((np.arange(150) % 7 == 0) & (np.arange(8) > 3)[:, None], 1e3, 1.0) * BODIES
STACKEL = fa.models.StackelBody(fa.Hyperelastic(0.9), fa.models.Cosine(0.2), fa.models.Cosine(0.1), mu=0.9)
FIXED = {"step": 0.1, "energy_tolerance": 1e9}
DOP853 = {"scheme": fa.DOP853, "rtol": 1e-9, "atol": 1e-9}
SLOWED = {"step": 0.1, "scheme": fa.TimeTransformed(fa.KAHAN_LI8, fa.schemes.Logistic(0.1, 0.05))}
RK4, TEN = {"scheme": fa.RK4, "energy_tolerance": 1.0}, {"scheme": fa.SOFRONIOU_SPALETTA10, "step": 0.2}
SPIN = fa.BetaEquals(0.3, 0)
LIMITED = {"time": 30.0}
STREAMED = (fa.Lyapunov(), fa.MEGNO(), fa.SALI(), fa.GALI(4))
PASSES = (
    fa.LyapunovSpectrum(),
    fa.WeightedBirkhoff(),
    fa.ReversibilityError(),
    fa.FrequencyDiffusion(),
    fa.ZeroOneTest(),
)
FRAME = np.linalg.qr(np.random.default_rng(2).normal(size=(8, 8)))[0]
CUT = {"section": X, "crossings": 4, "max_time": 30.0}
CLOSED = np.array([0.0, 0.0, 0.3, 0.31])
NEAR = CLOSED[:, None] + 0.02 * np.random.default_rng(5).standard_normal((4, 9))
NEAR[:, 4] = 0.0, 5.0, 0.1, 0.1
ACTIONS = np.random.default_rng(12).choice([1e-6, 1e-3, 0.1, 1.0, 5.0], (4, 150)) * np.array([[1], [1], [1], [-1]])
TURNS = np.random.default_rng(13).random((4, 150))
DUFFING = np.random.default_rng(9).uniform(-0.9, 0.9, (4, 140)) + np.array([[0.0], [1.0], [0.0], [0.0]])
"""With a time of its own each."""
LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
WINGS = np.random.default_rng(10).normal(size=(3, 140)) * 5 + np.array([[1.0], [1.0], [25.0]])
DAMPED = fa.hamiltonian("(x**2 + y**2)/2 + x**2*y - y**3/3", friction=0.02)
TURNING, STANDARD = shared_systems.turning_springs(1.3, 0.6, 0.4), fa.models.StandardMap(0.8)
ROUNDS = np.random.default_rng(11).uniform(-0.6, 0.6, (2, 140))
PENDULA = fa.models.DoublePendulum()
SWINGS = np.random.default_rng(14).uniform(-2, 2, (4, 140))
SWINGS[:, 17] = [3.1, 3.1, 30.0, -40.0]
"""One of whose iterations takes longest, and fails."""
RATIOS = np.random.default_rng(4).integers(-9, 10, (4, 300)) + 1e-10 * np.random.default_rng(5).random((4, 300))
SIGNALS = np.random.default_rng(7).normal(size=(300, 256)) + np.exp(0.3j * np.arange(256))
CURVES = np.random.default_rng(8).normal(size=(2, 1, 12)) + np.array(
    [
        np.cos(np.outer(np.arange(250), np.linspace(0.3, 2.5, 12))),
        np.sin(np.outer(np.arange(250), np.linspace(0.3, 2.5, 12))),
    ]
)
CURVES[:, :, 9:] = np.random.default_rng(9).random((2, 250, 3))
RECORDS = np.moveaxis(CURVES, 1, 2)


def by_class(function):
    """The levels of each class as a list, without their wave functions, which are those of all classes."""

    def numbers(**given):
        found = function(**given)
        if isinstance(found, list):
            return [(table.E, table.error, table.n) for table in found]
        return [(found.E[k], found.error[k], found.n[:, k]) for k in range(len(found.values))]

    return numbers


def by_case(**given):
    """The numbers of each case of a chaotic fraction as a list."""
    found = fa.chaotic_fraction(lambda lam: (fa.HenonHeiles(lam), FEW), (given.pop("values"),), **given)
    counts = found.orbits, found.chaotic, found.regular, found.undecided, found.recomputed, found.statuses
    numbers = (
        *counts,
        found.medians,
        found.chaotic_medians,
        found.thresholds,
        found.time,
        found.step,
        found.energy_error,
    )
    return [[array[..., k] for array in numbers] for k in range(len(found.chaotic))]


ROWS = {
    "integrate": Row(fa.integrate, {"z0": FEW}, {"model": HH, **LIMITED, "samples": 3}),
    "integrate, times of samples": Row(
        fa.integrate, {"z0": FEW}, {"model": HH, **LIMITED, "samples": np.geomspace(0.01, LIMITED["time"], 7)}
    ),
    "integrate, given step": Row(fa.integrate, {"z0": MANY}, {"model": HH, **LIMITED, **FIXED, "samples": 3}),
    "integrate, a step each": Row(
        fa.integrate, {"z0": FEW, "step": np.geomspace(0.01, 0.2, 40)}, {"model": HH, **LIMITED}
    ),
    "integrate, adaptive": Row(fa.integrate, {"z0": MANY}, {"model": HH, **LIMITED, **DOP853, "samples": 3}),
    "integrate, time-transformed": Row(fa.integrate, {"z0": FEW}, {"model": HH, **LIMITED, **SLOWED, "samples": 3}),
    "integrate, adaptive lanes refilled": Row(
        fa.integrate, {"z0": wild(1300)}, {"model": HH, "time": 15.0, "threads": 1, **DOP853}
    ),
    "integrate, Runge-Kutta": Row(
        fa.integrate, {"z0": BODIES}, {"model": BODY, "time": 3.0, "step": 0.05, "samples": 3, **RK4}
    ),
    "integrate, driven": Row(
        fa.integrate, {"z0": DUFFING}, {"model": shared_systems.duffing(), **LIMITED, **FIXED, "samples": 3}
    ),
    "integrate, driven, adaptive": Row(
        fa.integrate, {"z0": DUFFING}, {"model": shared_systems.duffing(), **LIMITED, **DOP853}
    ),
    "integrate, damped": Row(fa.integrate, {"z0": FEW}, {"model": DAMPED, **LIMITED, "samples": 3}),
    "integrate, turning": Row(fa.integrate, {"z0": MANY}, {"model": TURNING, **LIMITED, "samples": 3}),
    "integrate, flow": Row(fa.integrate, {"z0": WINGS}, {"model": LORENZ, "time": 2.0, "samples": 3}),
    "integrate, implicit": Row(
        fa.integrate, {"z0": SWINGS}, {"model": PENDULA, "time": 20.0, "scheme": "GAUSS16", "step": 0.25}
    ),
    "integrate, map": Row(fa.integrate, {"z0": ROUNDS}, {"model": STANDARD, "time": 300, "samples": 3}),
    "tangent_map": Row(fa.tangent_map, {"z0": FEW}, {"model": HH, **LIMITED}),
    "tangent_map, given step": Row(fa.tangent_map, {"z0": FEW}, {"model": HH, **LIMITED, **FIXED}),
    "tangent_map, adaptive": Row(fa.tangent_map, {"z0": FEW}, {"model": HH, **LIMITED, **DOP853}),
    "tangent_map, order ten": Row(fa.tangent_map, {"z0": BODIES[:, :40]}, {"model": BODY, "time": 5.0, **TEN}),
    "chaos_map": Row(fa.chaos_map, {"z0": MANY}, {"model": HH, "time": 100.0, "indicators": STREAMED, "history": 2}),
    "chaos_map, given step": Row(
        fa.chaos_map, {"z0": MANY}, {"model": HH, "time": 100.0, "indicators": STREAMED, **FIXED}
    ),
    "chaos_map, adaptive": Row(
        fa.chaos_map, {"z0": MANY}, {"model": HH, "time": 100.0, "indicators": STREAMED, **DOP853}
    ),
    "chaos_map, early stop": Row(
        fa.chaos_map, {"z0": FEW}, {"model": HH, "time": 300.0, "indicators": STREAMED, "early_stop": True}
    ),
    "chaos_map, turning": Row(fa.chaos_map, {"z0": FEW}, {"model": TURNING, "time": 40.0, "indicators": STREAMED[:3]}),
    "chaos_map, flow": Row(
        fa.chaos_map, {"z0": WINGS}, {"model": LORENZ, "time": 5.0, "indicators": (fa.LyapunovSpectrum(),)}
    ),
    "chaos_map, map": Row(fa.chaos_map, {"z0": ROUNDS}, {"model": STANDARD, "time": 100, "indicators": STREAMED[1:3]}),
    "chaos_map, other passes": Row(fa.chaos_map, {"z0": FEW}, {"model": HH, "time": 100.0, "indicators": PASSES}),
    "chaos_map, given vectors": Row(
        fa.chaos_map,
        {"z0": BODIES[:, :40]},
        {"model": BODY, "time": 20.0, "indicators": (fa.LyapunovSpectrum(),), "deviation_vectors": FRAME, "step": 0.1},
    ),
    "frequency_map": Row(fa.frequency_map, {"z0": FEW}, {"model": HH, "time": 100.0}),
    "frequency_map, accuracy": Row(
        fa.frequency_map, {"z0": BODIES[:, :40]}, {"model": BODY, "time": 40.0, "accuracy": 1e-6}
    ),
    "frequency_map, given step": Row(fa.frequency_map, {"z0": BODIES}, {"model": BODY, "time": 40.0, "step": 0.1}),
    "frequency_map, lines": Row(
        fa.frequency_map, {"z0": BODIES}, {"model": BODY, "time": 40.0, "step": 0.1, "lines": 3}
    ),
    "frequency_map, adaptive": Row(fa.frequency_map, {"z0": BODIES[:, :40]}, {"model": BODY, "time": 40.0, **DOP853}),
    "frequency_map, adaptive by a step": Row(
        fa.frequency_map, {"z0": BODIES[:, :40]}, {"model": BODY, "time": 40.0, "step": 0.06, **DOP853}
    ),
    "frequency_map, order ten": Row(fa.frequency_map, {"z0": BODIES[:, :40]}, {"model": BODY, "time": 40.0, **TEN}),
    "poincare_map": Row(fa.poincare_map, {"z0": FEW}, {"model": HH, **CUT}),
    "poincare_map, given step": Row(fa.poincare_map, {"z0": MANY}, {"model": HH, **CUT, **FIXED}),
    "poincare_map, adaptive": Row(fa.poincare_map, {"z0": MANY}, {"model": HH, **CUT, **DOP853}),
    "poincare_map, time-transformed": Row(fa.poincare_map, {"z0": FEW}, {"model": HH, **CUT, **SLOWED}),
    "poincare_map, driven": Row(
        fa.poincare_map,
        {"z0": DUFFING},
        {"model": shared_systems.duffing(), "section": "t=1.7", "crossings": 3, **FIXED},
    ),
    "poincare_map, strobed": Row(
        fa.poincare_map, {"z0": DUFFING}, {"model": shared_systems.duffing(), "section": "t=1.7", "crossings": 3}
    ),
    "poincare_map, turning": Row(fa.poincare_map, {"z0": FEW}, {"model": TURNING, **CUT}),
    "poincare_map, Runge-Kutta": Row(
        fa.poincare_map,
        {"z0": BODIES},
        {"model": BODY, "section": SPIN, "crossings": 4, "max_time": 8.0, "step": 0.1, **RK4},
    ),
    "poincare_map, order ten": Row(
        fa.poincare_map, {"z0": BODIES}, {"model": BODY, "section": SPIN, "crossings": 4, "max_time": 8.0, **TEN}
    ),
    "periodic_orbits": Row(fa.periodic_orbits, {"z0": NEAR}, {"model": HH, "section": X}),
    "periodic_orbits, given step": Row(fa.periodic_orbits, {"z0": NEAR}, {"model": HH, "section": X, "step": 0.07}),
    "periodic_orbits, adaptive": Row(fa.periodic_orbits, {"z0": NEAR}, {"model": HH, "section": X, **DOP853}),
    "periodic_orbits, eight rows": Row(
        fa.periodic_orbits,
        {"z0": BODIES[:, :4]},
        {"model": HARMONIC, "section": TURN, "step": 0.1, "max_time": 10.0, "iterations": 4},
    ),
    "action_angles": Row(fa.action_angles, {"z0": FAST}, {"model": BODY}),
    "action_angles, elliptic": Row(
        fa.action_angles, {"z0": FAST}, {"model": fa.Body(fa.Anharmonic(0.9)), "chart": fa.charts.ELLIPTIC}
    ),
    "action_angles, angular": Row(fa.action_angles, {"z0": FAST}, {"model": STACKEL}),
    "action_angles, closed": Row(fa.action_angles, {"z0": BODIES}, {"model": HARMONIC}),
    "constants_of_motion": Row(fa.constants_of_motion, {"z": BODIES}, {"model": BODY}),
    "energy_of_actions": Row(fa.energy_of_actions, {"J": ACTIONS}, {"model": fa.Body(fa.HeavyTop(0.7, 1.6), 1.3)}),
    "energy_of_actions, closed": Row(fa.energy_of_actions, {"J": ACTIONS}, {"model": HARMONIC}),
    "from_action_angles": Row(fa.from_action_angles, {"J": abs(ACTIONS), "theta": TURNS}, {"model": BODY}),
    "from_action_angles, closed": Row(fa.from_action_angles, {"J": abs(ACTIONS), "theta": TURNS}, {"model": HARMONIC}),
    "naff": Row(fa.naff, {"signal": SIGNALS}, {"dt": 0.1, "lines": 3}, axis=0),
    "tunes": Row(fa.tunes, {"samples": RECORDS}, {}, axis=1),
    "orbit_frequencies": Row(fa.orbit_frequencies, {"samples": RECORDS}, {"dt": 0.1, "lines": 3}, axis=1),
    "resonances": Row(fa.resonances, {"nu": RATIOS}, {"max_order": 6}),
    "rotation_number": Row(fa.rotation_number, {"points": CURVES}, {}),
    "islands": Row(fa.islands, {"points": CURVES}, {"max_islands": 6}),
    "chaotic_fraction": Row(by_case, {"values": np.array([1.0, 0.5, 0.8])}, {"time": 100.0, "step": 0.1}),
    "spectrum_table": Row(
        by_class(fa.quantum.spectrum_table),
        {"m": np.array([0, 2, 1, -1, 3]), "l": np.array([0, 0, 1, 1, -1])},
        {"model": BODY, "count": 5},
    ),
    "spectrum_table, closed": Row(
        by_class(fa.quantum.spectrum_table),
        {"m": np.array([0, 2, 1, -1, 3]), "l": np.array([0, 0, 1, 1, -1])},
        {"model": HARMONIC, "count": 5},
    ),
    "class_diagram": Row(
        by_class(fa.quantum.class_diagram), {"m": np.array([0, 2, 4])}, {"model": BODY, "l": 0, "count": 4}
    ),
    "level_diagram": Row(
        by_class(fa.quantum.level_diagram),
        {"values": np.array([1.0, 2.0, 1.5])},
        {"make": lambda C: fa.Body(fa.Hyperelastic(C)), "m": 0, "l": 0, "count": 4},
    ),
}


def items(result, numbers):
    """Some of the items of a result, an array, or a dict of arrays."""
    if isinstance(result, list):
        return [result[k] for k in numbers]
    if isinstance(result, dict):
        return {name: items(value, numbers) for name, value in result.items()}
    return result.take(numbers) if isinstance(result, Result) else result[..., numbers]


def public(name):
    """The public name of a row, which may have variants."""
    return name.partition(",")[0]


def taking(argument):
    """The rows whose function takes an argument that the row leaves open."""
    return [name for name in ROWS if argument in battery.arguments(public(name)) and argument not in ROWS[name].given]


COSTLY = {"chaos_map, turning", "chaos_map, given vectors", "tangent_map, order ten", "periodic_orbits, eight rows"}
"""Rows of the deep tier: blocks that no other row has are compiled for each."""


def tiers(names):
    """The rows as cases of a test, each in its tier."""
    return [pytest.param(name, marks=pytest.mark.slow) if name in COSTLY else name for name in names]


@cache
def whole(name):
    """The result of a row, by one thread; what the tests compare with."""
    return ROWS[name](**({"threads": 1} if name in taking("threads") else {}))


@pytest.mark.parametrize("name", tiers(taking("threads")))
def test_any_number_of_threads_gives_the_same_bits(name, two_threads):
    same(ROWS[name](threads=2), whole(name))


@pytest.mark.parametrize("name", tiers(ROWS))
def test_any_order_gives_the_same_bits(name):
    order, shares = np.random.default_rng(1).permutation(ROWS[name].numbers), []
    told = {"callback": shares.append} if name in taking("callback") else {}
    same(ROWS[name](order, **told), items(whole(name), order))
    assert shares == sorted(shares)  # one count over all passes
    assert not shares or 0 <= shares[0] <= shares[-1] <= 1


@pytest.mark.parametrize("name", tiers(ROWS))
def test_any_company_gives_the_same_bits(name):
    rng, numbers = np.random.default_rng(2), ROWS[name].numbers
    for count in (1, 1, 2, 1 + len(numbers) // 3):
        chosen = rng.choice(numbers, count, replace=False)
        same(ROWS[name](chosen), items(whole(name), chosen))


Q = [f"q{k}" for k in range(9)]
CHAIN = fa.hamiltonian(
    " + ".join(f"k*({one} - {two})**2/2" for one, two in zip(["0", *Q], [*Q, "0"], strict=True)), coordinates=Q, k=1.7
)
"""Nine masses on springs: sums over nine rows, which NumPy orders by the company."""


@pytest.mark.parametrize("scale", [escape_radii, vector_rates, lambda chain, z: chain.inverse_masses(z)])
def test_scales_of_many_rows_know_no_company(scale):
    z = np.random.default_rng(3).normal(size=(18, 50))
    system = system_of(CHAIN)
    together = scale(system, z)
    for k in range(50):
        same(scale(system, z[:, k : k + 1]), together[..., k : k + 1])


# --- Ctrl-C --------------------------------------------------------------------------------------------------------

MODULES = [module for name, module in sys.modules.items() if name.startswith("fastaff.")]


def stopping(monkeypatch, at):
    """Let Ctrl-C come in the launch of a kernel numbered `at`, when half its units are done; return the number of
    launches so far.
    """
    own, count = flow.launch, [0]

    def launch(kernel, arguments, progress, *rest):
        count[0] += 1
        if count[0] == at:
            own(kernel, arguments, progress[: progress.size // 2], *rest)
            raise KeyboardInterrupt
        own(kernel, arguments, progress, *rest)

    for module in MODULES:
        if getattr(module, "launch", None) is own:
            monkeypatch.setattr(module, "launch", launch)
    return count


APART = {"naff", "chaotic_fraction"}
"""Functions of the table that Ctrl-C stops in ways of their own, of which other tests tell."""

PREPARING = {"plan", "stable_plan", "start", "_steps", "_motion_of_map", "own_rates", "checked_guesses"}
"""Where there is nothing yet to hand over: steps are chosen, and scales found."""


def interrupted(name, call):
    """The partial result of a call that is interrupted, which is of the function's own kind; None where it has not yet
    begun.
    """
    with pytest.raises(KeyboardInterrupt) as caught:
        call()
    if not isinstance(caught.value, fa.Interrupted):
        assert {entry.name for entry in caught.traceback} & PREPARING
        return None
    assert str(caught.value) == public(name)
    partial = caught.value.partial
    if isinstance(partial, Result):
        assert hasattr(partial, "call") == hasattr(whole(name), "call")
        repr(partial), partial.summary()
        for field in dataclasses.fields(partial):
            assert (getattr(partial, field.name) is None) == (getattr(whole(name), field.name) is None), field.name
    return partial


def finished(result):
    """The numbers of the finished items of a partial result."""
    done = result.status != fa.Status.INTERRUPTED if hasattr(result, "status") else np.isfinite(result).all(axis=0)
    return np.flatnonzero(done)


LAUNCHING = [name for name in taking("threads") if public(name) not in APART and "closed" not in name]
"""Functions whose work is launches of kernels on their items."""


@pytest.mark.parametrize("name", tiers(LAUNCHING))
def test_what_is_finished_at_ctrl_c_is_that_of_the_whole(name, monkeypatch):
    with monkeypatch.context() as patch:
        count = stopping(patch, 0)
        ROWS[name]()
    last = count[0]
    for at in sorted({1, last // 2 + 1, last}):
        with monkeypatch.context() as patch:
            stopping(patch, at)
            partial = interrupted(name, ROWS[name])
        assert type(partial) is type(whole(name)) or (partial is None and at < last)
        if partial is not None:
            same(items(partial, finished(partial)), items(whole(name), finished(partial)))


def test_lines_that_are_finished_at_ctrl_c_are_those_of_the_whole():
    def stop(fraction):
        raise KeyboardInterrupt

    partial = interrupted("naff", lambda: ROWS["naff"](threads=1, callback=stop))
    done = np.flatnonzero(np.isfinite(partial.residual))
    assert 0 < done.size < len(partial)
    same(partial.take(done), whole("naff").take(done))


def test_cases_that_are_finished_at_ctrl_c_are_those_of_the_whole():
    def stop(lam):
        if lam < 0.6:
            raise KeyboardInterrupt
        return fa.HenonHeiles(lam), FEW

    row = ROWS["chaotic_fraction"]
    with pytest.raises(fa.Interrupted, match="chaotic_fraction") as caught:
        fa.chaotic_fraction(stop, (row.sets["values"],), **row.given)
    partial = caught.value.partial
    assert isinstance(partial, fa.chaos.ChaoticFraction)
    np.testing.assert_array_equal(partial.done, [True, False, False])
    same(partial.medians[:, 0], whole("chaotic_fraction")[0][6])
    same(partial.statuses[:, 0], whole("chaotic_fraction")[0][5])


# --- the table is complete -----------------------------------------------------------------------------------------

EXEMPT = {
    "find_periodic_orbits": "what it finds belongs to the set, guesses chosen apart from one another; its maps and "
    "searches are rows, its interruption is in test_results.py",
    "continuation": "one orbit after another along a branch; its interruption is in test_results.py",
    "fit_torus": "one orbit; its interruption is in test_results.py",
    "run": "a job, whose orbits are held to the same in test_jobs.py",
    "coherent_packet": "one phase point",
    "spectrum": "one class of one body, whose levels share a basis; its interruption is in test_results.py",
    "periodic_guesses": "guesses are chosen apart from one another: they belong to the set",
    "basins": "attractors belong to the set; threads and interruption are in tests/chaos/test_basins.py",
    "bifurcation_diagram": "parameters of one map: tests/systems/test_maps_of_one_variable.py",
    "resonance_web": "nodes are neighbours of one map: it is about the company",
    "all_levels": "one body; its interruption is in test_quantum_listing.py",
    "level_list": "merges all classes into one list",
    "unfold": "levels of one spectrum",
    "count_deviation": "levels of one spectrum",
    "polynomial_count": "a fit to all levels of one spectrum",
    "spacing_ratios": "neighbours of one spectrum",
    "mean_spacing_ratio": "one number of all spectra",
    "number_variance": "one number of all levels for each length",
    "to_matrix": "another form of the same numbers",
    "two_polar3": "another form of the same numbers",
    "diffusion_histogram": "counts of all orbits",
    "orbit_families": "orbits of a frequency map, which is in the table",
}
"""What takes sets, threads or a callback and has no row, each with the reason."""

OF_SETS = {"z0", "z", "J", "nu", "signal", "points", "threads", "callback", "levels", "classes", "spectra", "unfolded"}
OF_SETS |= {"values", "section_map", "diffusion"}


def test_every_function_of_sets_is_in_the_table():
    """Levels of one spectrum and such are named with their reason."""
    functions = {name for name in battery.discovered() if "." not in name and name[0].islower()}
    taking_sets = {name for name in functions if OF_SETS & set(battery.arguments(name))}
    tabled = {public(name) for name in ROWS}
    assert taking_sets - tabled == set(EXEMPT)
    assert tabled <= functions
