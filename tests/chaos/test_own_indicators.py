"""Indicators of chaos of somebody else: of tangent vectors, with an observer, with a pass of their own, all defined
here alone.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import matplotlib.pyplot
import numpy as np
import pytest

import fastaff as fa
from fastaff import Classification
from fastaff.chaos.indicator import NEEDS, Indicator, VectorIndicator, Watch, is_indicator
from fastaff.core.numbers import portion
from fastaff.engine.jit import LANES
from fastaff.engine.kernels.readings import LN10, stretch
from fastaff.runs import observers

HENON = fa.HenonHeiles()
STARTS = np.array([[0.0, 0.0, 0.0], [-0.25, 0.1, 0.12], [0.42, 0.4, 0.36], [0.0, 0.1, 0.08]])
RUN = {"time": 1000.0, "step": 0.1}
DAMPED = fa.hamiltonian("(x**2 + y**2)/2 + x**2*y - y**3/3", friction=0.02)
DRIVEN = fa.hamiltonian("x**2/2*(1.3 + 0.2*cos(t))", coordinates="x", drive_period="2*pi")
LORENZ = fa.ode("x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z", s=10.0, r=28.0, b=8 / 3)
MAP = fa.models.HenonMap(0.2054)


def area(growth, i):
    return (stretch(growth, 0, i) + stretch(growth, 1, i)) / LN10


@dataclass(frozen=True)
class Area(VectorIndicator):
    """Decades by which the area of two tangent vectors has grown."""

    threshold: float = 8.0
    name = "area"
    count = 2
    reading = staticmethod(area)

    def calm(self, value, before, threshold, n):
        return value - before < 1.5


@dataclass(frozen=True)
class TwoOrbits(Indicator):
    """Decades by which the distance of two orbits has grown that start next to each other."""

    apart: float = 1e-10
    threshold: float | None = None
    name = "two_orbits"
    needs = ("energy",)

    def default(self, n, phase):
        return 4.0 + np.log10(np.maximum(phase, 10.0))

    def calm(self, value, before, threshold, n):
        return value < threshold - 0.5

    def check(self, where, model):
        if not 0 < self.apart < 1:
            raise ValueError(f"{where}.apart must be between 0 and 1, got {self.apart}")

    def compute(self, flow, z0, time, rates, callback):
        near = z0 + self.apart * np.abs(z0).max(axis=0)
        runs = [
            flow.observed(start, observers.nothing(), time=time, observations=1, callback=portion(callback, k, 2))[0]
            for k, start in enumerate((z0, near))
        ]
        with np.errstate(all="ignore"):
            grown = np.linalg.norm(runs[1].z - runs[0].z, axis=0) / np.linalg.norm(near - z0, axis=0)
            return np.log10(grown), np.nan, np.maximum(runs[0].status, runs[1].status)


class Scale(NamedTuple):
    """What the distance is measured in."""

    unit: float = 1.0


def farthest(value, lanes, orbit, fresh, t, z, memory, out, done):
    for i in range(lanes):
        distance = abs(z[LANES + i]) / value.unit
        if fresh[i] > 0.0 and distance > memory[i]:
            memory[i] = distance
    return 0


@dataclass(frozen=True)
class Farthest(Indicator):
    """The largest |y|, which is watched beside the tangent vectors; it calls no orbit regular."""

    threshold: float = 0.6
    name = "farthest"

    def calm(self, value, before, threshold, n):
        return np.zeros(value.shape, bool)

    def watch(self, flow, time, rates):
        observer = observers.Observer(farthest, 1, Scale())
        return Watch(observer, 0, lambda memory: None, lambda memory, reached: (memory[0], np.nan))


def refused(model, z0, *indicators, **options):
    with pytest.raises((TypeError, ValueError)) as caught:
        fa.chaos_map(model, z0, indicators=indicators, **{"time": 20.0} | options)
    return str(caught.value)


def test_an_indicator_of_tangent_vectors_from_outside():
    """The bits of a TangentIndicator with the same function, in the same pass as those of the package."""
    twin = fa.chaos.TangentIndicator("twin", area, threshold=8.0, count=2)
    found = fa.chaos_map(HENON, STARTS, indicators=(fa.MEGNO(), Area(), twin), history=4, **RUN)
    assert found.names == ("megno", "area", "twin")
    np.testing.assert_array_equal(found.area, found.twin)
    np.testing.assert_array_equal(found.history[1], found.history[2])
    np.testing.assert_array_equal(found.megno, fa.chaos_map(HENON, STARTS, history=4, **RUN).megno)
    assert [*found.classifications[1]] == [Classification.CHAOTIC, Classification.REGULAR, Classification.REGULAR]
    assert "1 chaotic" in fa.chaos_map(HENON, STARTS, indicators=Area(), early_stop=True, **RUN).summary()
    assert np.isfinite(fa.chaos_map(LORENZ, [1.0, 2.0, 20.0], time=20.0, indicators=Area()).area).all()


def test_an_indicator_with_a_pass_of_its_own_from_outside():
    """Its values are those of the two integrations; it counts in the classification, the summary and rows by name."""
    found = fa.chaos_map(HENON, STARTS, indicators=TwoOrbits(), **RUN)
    first, near = (fa.integrate(HENON, z, **RUN).z for z in (STARTS, STARTS + 1e-10 * np.abs(STARTS).max(axis=0)))
    away = np.linalg.norm(near - first, axis=0)
    assert np.all(np.abs(found.two_orbits[1:] - np.log10(away / (2e-10 * np.abs(STARTS).max(axis=0)))[1:]) < 1e-3)
    assert [*found.classification] == [Classification.CHAOTIC, Classification.REGULAR, Classification.REGULAR]
    assert "2 regular, 1 chaotic" in found.summary()
    np.testing.assert_array_equal(found["two_orbits"], found.values[0])
    beside = fa.chaos_map(HENON, STARTS, indicators=(fa.SALI(), TwoOrbits(), Farthest()), **RUN)
    np.testing.assert_array_equal(beside.two_orbits, found.two_orbits)
    np.testing.assert_array_equal(beside.sali, fa.chaos_map(HENON, STARTS, indicators="sali", **RUN).sali)
    assert (beside.classification == found.classification).all()
    shares = fa.chaotic_fraction(lambda lam: (fa.HenonHeiles(lam), STARTS), ([1.0],), indicators=(TwoOrbits(),), **RUN)
    assert shares.chaotic == 1
    assert shares.indicators == ("two_orbits",)


def test_an_indicator_with_an_observer_from_outside():
    found = fa.chaos_map(
        HENON, STARTS, indicators=(fa.WeightedBirkhoff(), Farthest(), fa.ZeroOneTest(), fa.MEGNO()), **RUN
    )
    path = fa.integrate(HENON, STARTS, samples=10_000, **RUN).samples[:, 1]
    np.testing.assert_allclose(found.farthest, np.abs(path).max(axis=0), rtol=1e-9)
    alone = fa.chaos_map(HENON, STARTS, indicators=(fa.ZeroOneTest(), fa.WeightedBirkhoff()), **RUN)
    np.testing.assert_array_equal(found.zero_one_test, alone.zero_one_test)
    np.testing.assert_array_equal(found.weighted_birkhoff, alone.weighted_birkhoff)


@pytest.mark.parametrize(
    ("model", "z0", "needs", "options", "words"),
    [
        (DAMPED, STARTS, ("energy",), {}, "for a system that has friction, got"),
        (LORENZ, [1.0, 2.0, 20.0], ("energy",), {}, "must be those of deviation vectors"),
        (DRIVEN, [0.1, 0.2], ("flow",), {}, "two_orbits, is not supported for driven systems"),
        (MAP, [0.1, 0.2], ("flow",), {}, "two_orbits, is not supported for maps"),
        (HENON, STARTS, ("fixed steps",), {"scheme": fa.VERNER9}, "Needy needs a scheme of fixed steps, got VERNER9"),
        (
            HENON,
            STARTS,
            ("splitting",),
            {"scheme": fa.RK4, "step": 0.1},
            "Needy needs a splitting, which is",
        ),
        (HENON, STARTS, ("patience",), {}, "needs must be one of energy, flow, fixed steps, splitting, got 'patience'"),
    ],
)
def test_what_a_system_lacks_is_said(model, z0, needs, options, words):
    class Needy(TwoOrbits):
        pass

    Needy.needs = needs
    assert words in refused(model, z0, Needy(), **options)
    assert {need for need in needs if need != "patience"} <= NEEDS.keys()


def test_own_fields_are_checked():
    assert "indicators[0], TwoOrbits.apart must be" in refused(HENON, STARTS, TwoOrbits(apart=2.0))
    assert "indicators[1], Area.threshold must be finite" in refused(HENON, STARTS, fa.SALI(), Area(threshold=np.inf))
    assert "indicators must differ, got area, area" in refused(HENON, STARTS, Area(), Area(threshold=2.0))
    assert "Use TwoOrbits()" in refused(HENON, STARTS, TwoOrbits)
    assert "early_stop must be False with " in refused(HENON, STARTS, TwoOrbits(), early_stop=True)

    @dataclass(frozen=True)
    class Silent(Indicator):
        threshold: float = 1.0
        name: str = "silent"

        def calm(self, value, before, threshold, n):
            return value < threshold

    assert "Silent must read vectors, or have a `watch` or a `compute`" in refused(HENON, STARTS, Silent())
    assert "Silent.name must be a name such as" in refused(HENON, STARTS, Silent(name="not a name"))


@pytest.mark.parametrize("answer", [None, np.ones(3), (np.ones(3), np.nan), (np.ones(2), np.nan, np.zeros(3, int))])
def test_what_a_pass_returns_is_checked(answer):
    class Wrong(TwoOrbits):
        def compute(self, flow, z0, time, rates, callback):
            return answer

    assert "compute of the indicator two_orbits must return values" in refused(HENON, STARTS, Wrong())


def test_a_value_that_inherits_nothing_is_an_indicator():
    """It has all that the contract has; what lacks something is refused with what it lacks."""

    class Bare:
        name, threshold, above, rate, least, needs = "bare", 3.0, True, False, 0.0, ()

        def vectors(self, n):
            return 0

        def check(self, where, model):
            return None

        def watch(self, flow, time, rates):
            return None

        def calm(self, value, before, threshold, n):
            return value < threshold

        def compute(self, flow, z0, time, rates, callback):
            return np.full(z0.shape[1], 2.0), np.nan, np.zeros(z0.shape[1], int)

    assert is_indicator(Bare())
    assert not is_indicator(Bare)
    found = fa.chaos_map(HENON, STARTS, indicators=(Bare(), fa.SALI()), **RUN)
    assert (found.bare == 2.0).all()
    del Bare.calm, Bare.watch
    assert refused(HENON, STARTS, Bare()).startswith("indicators[0] must be an indicator or its name")


def test_an_interrupted_pass_leaves_its_orbits_open():
    def stop(fraction):
        raise KeyboardInterrupt

    many = np.repeat(STARTS, 40, axis=1)
    with pytest.raises(fa.Interrupted) as stopped:
        fa.chaos_map(HENON, many, time=2e4, step=0.02, indicators=TwoOrbits(), callback=stop)
    assert (stopped.value.partial.status == fa.Status.INTERRUPTED).all()


def test_one_orbit_lost_in_its_pass_is_marked():
    class Lossy(TwoOrbits):
        def compute(self, flow, z0, time, rates, callback):
            value, before, status = super().compute(flow, z0, time, rates, callback)
            status[1] = fa.Status.NONFINITE
            return value, before, status

    found = fa.chaos_map(HENON, STARTS, indicators=(fa.SALI(), Lossy()), **RUN)
    assert [*found.status] == [fa.Status.OK, fa.Status.NONFINITE, fa.Status.OK]
    assert found.classification[1] == Classification.UNDECIDED
    assert replace(Lossy(), threshold=2.0).threshold == 2.0


def lost(growth, i):
    return -(stretch(growth, 0, i) + stretch(growth, 1, i)) / LN10


@dataclass(frozen=True)
class Lost(Area):
    """The same decades as they are lost: chaotic orbits are below."""

    threshold: float = -8.0
    name = "lost"
    label = "decades lost"
    above = False
    reading = staticmethod(lost)

    def calm(self, value, before, threshold, n):
        return before - value < 1.5


def test_colours_of_an_indicator_that_falls_are_those_of_one_that_rises(tmp_path):
    """Bright is chaotic, in sections and maps, after a file too, under its own label, whatever the name."""
    starts = fa.energy_sample(HENON, energy=0.13, section="x=0", orbits=40, seed=2)
    chosen: tuple = (Area(), Lost(), fa.chaos.TangentIndicator("sali", lost, threshold=-8.0, above=False, count=2))
    chosen += (fa.chaos.TangentIndicator("digits", area, threshold=8.0, count=2),)
    found = fa.chaos_map(HENON, starts, indicators=chosen, **RUN)
    assert found.chaotic.any()
    assert found.regular.any()
    fa.save(tmp_path / "chaos", found)
    for result in (found, fa.load(tmp_path / "chaos.npz"), found[:40]):
        colours = {}
        for name, sign in (("area", 1), ("lost", -1), ("sali", -1), ("digits", 1)):
            drawn = fa.plot.plot_chaos_map(starts, result, indicator=name, colorbar=True)
            colours[name] = drawn.points.to_rgba(drawn.points.get_array())
            assert drawn.colorbar.ax.yaxis_inverted() == (sign < 0)
            assert drawn.colorbar.ax.get_ylabel() == ("decades lost" if name == "lost" else name)
            scale = fa.plot.colouring(result, name)
            assert scale.falling == (sign < 0)
            image = fa.plot.plot_starts(starts, values=scale).points
            np.testing.assert_allclose(image.to_rgba(image.get_array()), colours[name], atol=1e-12)
            matplotlib.pyplot.close("all")
        for name in ("lost", "sali", "digits"):
            np.testing.assert_allclose(colours[name], colours["area"], atol=0.01)
        light = colours["lost"][:, :3] @ [0.3, 0.6, 0.1]
        assert (
            light[found.classifications[1] == Classification.CHAOTIC].min()
            > light[found.classifications[1] == Classification.REGULAR].max()
        )
