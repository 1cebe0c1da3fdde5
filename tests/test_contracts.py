"""Contracts (`fastaff.models.contracts`): what the package has keeps them, what keeps them works, what lacks
something is told.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest

import fastaff as fa
from fastaff.flows.checks import EVERY, lacking
from fastaff.models import contracts
from fastaff.models.contracts import Angles, Kind, Model, OneVariable, Potential, Section

POTENTIALS = [fa.Harmonic(), fa.Anharmonic(), fa.Hyperelastic(), fa.HeavyTop(), fa.NeoHookean()]
POTENTIALS += [fa.SeparableAlphaBeta(fa.models.Oscillator(1.0), fa.models.Zero())]
BODIES = [fa.Body(potential) for potential in POTENTIALS]
SYSTEMS = [
    fa.HenonHeiles(),
    fa.reduced(BODIES[0], p_eta=0.3, p_gamma=0.2),
    fa.hamiltonian("x**2*y**2", coordinates="x y"),
]
SECTIONS = [fa.AlphaTurning(), fa.BetaTurning(), fa.AlphaEquals(1.0), fa.BetaEquals(1.0), fa.AreaEquals()]
SECTIONS += [fa.Linear((1.0, 0.0, 0.0, 0.0))]
NEEDS = [(Model, BODIES + SYSTEMS), (Potential, POTENTIALS), (Section, SECTIONS), (OneVariable, [fa.models.Zero()])]
NEEDS += [(Angles, [body.angles for body in BODIES] + [fa.HenonHeiles().angles])]
Z = np.array([[0.1, 0.05], [0.02, -0.1], [0.1, 0.2], [0.0, 0.1]])


class Relativistic(NamedTuple):
    """H = sqrt(m^2 + p^2) - m + |q|^2/2, two degrees of freedom, no names: a T that is not quadratic."""

    m: float = 1.0

    @property
    def degrees_of_freedom(self):
        return 2

    def velocity(self, px, py):
        w = 1 / np.sqrt(self.m**2 + px * px + py * py)
        return px * w, py * w

    def force(self, x, y):
        return -x, -y

    def kinetic_energy(self, px, py):
        return np.sqrt(self.m**2 + px * px + py * py) - self.m

    def potential_energy(self, x, y):
        return (x * x + y * y) / 2

    def margin(self, x, y):
        return 1.0 + 0.0 * x


class OwnBody(NamedTuple):
    """A body of somebody else, not the package's class."""

    potential: Any
    mu: float = 1.0
    degrees_of_freedom = 4
    coordinates = ("a1", "a2", "b1", "b2")
    isotropic = True

    velocity = fa.Body.velocity
    force = fa.Body.force
    kinetic_energy = fa.Body.kinetic_energy
    potential_energy = fa.Body.potential_energy
    margin = fa.Body.margin


def test_what_the_package_has_keeps_its_contracts():
    for contract, values in NEEDS:
        for value in values:
            assert isinstance(value, contract), (contract, value)
            assert not lacking(value, contract)


@pytest.mark.parametrize("method", ["velocity", "force", "kinetic_energy", "potential_energy", "margin"])
def test_a_model_that_lacks_a_method_is_told_which(method):
    own = type("Own", (Relativistic,), {})
    body = {name: entry for name, entry in vars(Relativistic).items() if name != method and not name.startswith("__")}
    own = type("Own", (tuple,), {**body, "_fields": ("m",), "__getnewargs__": lambda self: tuple(self)})
    with pytest.raises(TypeError, match=f"Own has no {method}$"):
        fa.integrate(own((1.0,)), Z[:, 0], time=1.0)


@pytest.mark.parametrize("kind", [kind for kind in Kind if kind not in EVERY])
def test_other_kinds_of_models_are_refused_in_a_sentence(kind):
    class Other(NamedTuple):
        m: float = 1.0

    for name, entry in vars(Relativistic).items():
        if not name.startswith("_") and name != "m":
            setattr(Other, name, entry)
    Other.kind = kind
    calls = (
        lambda: fa.integrate(Other(), Z, time=1.0),
        lambda: fa.frequency_map(Other(), Z, time=1.0),
        lambda: fa.poincare_map(Other(), Z, section=SECTIONS[-1], crossings=1, max_time=1.0),
        lambda: fa.chaos_map(Other(), Z, time=1.0),
        lambda: fa.fit_torus(Other(), Z[:, 0], time=1.0),
    )
    for call in calls:
        with pytest.raises(TypeError, match=r"Other is .*; what runs here is H = T") as caught:
            call()
        assert kind.value in str(caught.value)


def test_a_model_without_names_is_named_by_numbers():
    with pytest.raises(ValueError, match="rows q1, q2 and their momenta"):
        fa.integrate(Relativistic(), [1.0, 2.0], time=1.0)


@pytest.mark.parametrize("options", [{}, {"accuracy": 1e-5}])
def test_the_default_scheme_takes_any_kinetic_energy(options):
    assert fa.integrate(Relativistic(), Z, time=5.0, **options).scheme == fa.KAHAN_LI8


def test_schemes_for_quadratic_kinetic_energies_are_refused_for_others():
    """BLANES_MOAN6 has order 6 for T quadratic in p alone; among candidates it is passed over."""
    with pytest.raises(ValueError, match="BLANES_MOAN6 has its order 6 only where T is quadratic"):
        fa.integrate(Relativistic(), Z, time=10.0, scheme=fa.BLANES_MOAN6)
    only = fa.schemes.Automatic((fa.BLANES_MOAN6,))
    with pytest.raises(ValueError, match="takes T quadratic in the momenta"):
        fa.integrate(Relativistic(), Z, time=10.0, scheme=only)
    free = fa.schemes.Automatic((fa.BLANES_MOAN6, fa.KAHAN_LI8))
    found = fa.integrate(Relativistic(), Z, time=10.0, scheme=free)
    assert found.scheme == fa.KAHAN_LI8
    plain = fa.integrate(Relativistic(), Z, time=10.0, step=0.02, scheme=fa.SOFRONIOU_SPALETTA10)
    assert (np.abs(found.z - plain.z) <= found.error + 1e-13).all()


def test_a_body_of_another_class_is_a_body():
    """p_eta, p_gamma, grids, frequencies of the planes: by what it says of itself, not by its class."""
    own, ours = OwnBody(fa.Hyperelastic()), fa.Body(fa.Hyperelastic())
    assert contracts.isotropic(own)
    assert not contracts.isotropic(fa.HenonHeiles())
    where = {
        "energy": 3.5,
        "section": fa.AlphaTurning(1),
        "axes": [np.linspace(-0.5, 0.5, 4)] * 2,
        "p_eta": 0.3,
        "p_gamma": 0.1,
    }
    z = fa.energy_grid(own, **where).z0
    np.testing.assert_array_equal(z, fa.energy_grid(ours, **where).z0)
    found, known = (fa.action_angles(body, z[:, :3]) for body in (own, ours))
    np.testing.assert_array_equal(found.J, known.J)


def test_a_step_belongs_to_its_orbit_and_a_chosen_scheme_to_the_set():
    """Both halves of what plans promise: alone or in company the same step; AUTO's scheme is that of the sample."""
    from fastaff.flows.options import Options, plan

    body, rng = fa.HenonHeiles(), np.random.default_rng(12)
    z = rng.uniform(-0.2, 0.2, (4, 30)) * rng.choice([1.0, 1e-3], 30)
    order = rng.permutation(30)
    together = plan(body, z, Options(), time=100.0)
    np.testing.assert_array_equal(plan(body, z[:, order], Options(), time=100.0).flow.step, together.flow.step[order])
    for k in (0, 7, 29):
        np.testing.assert_array_equal(plan(body, z[:, k], Options(), time=100.0).flow.step, together.flow.step[[k]])
    chosen = plan(body, z, Options(scheme=fa.AUTO), time=100.0)
    same = plan(body, z, Options(scheme=chosen.flow.scheme), time=100.0)
    if not chosen.flow.adaptive:
        np.testing.assert_array_equal(chosen.flow.step, same.flow.step)
    assert chosen.flow.scheme.name in chosen.why
    assert "own step" in together.why
    assert plan(body, z, Options(step=0.1)).why == "the step given"
    assert "rtol 1e-12" in plan(body, z, Options(scheme=fa.DOP853)).why
