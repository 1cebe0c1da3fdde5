"""Models: NamedTuples of float parameters whose plain methods are the physics."""

from typing import Any

from ...engine.values import tell_apart
from .body import Body, HenonHeiles
from .body3 import Body3
from .breathing import BreathingBody
from .double_pendulum import DoublePendulum
from .ellipsoid_gravity import SelfGravity
from .equilibria3 import RelativeEquilibrium, relative_equilibrium, riemann_ellipsoid
from .functions import Barriers, CoshOscillator, Cosine, CosOscillator, Oscillator, Secant, Spring, Zero, univariate
from .maps import FroeschleMap, HenonMap, McMillanMap, OneTurnMap, StandardMap
from .potentials import Anharmonic, Harmonic, HeavyTop, Hyperelastic, NeoHookean
from .potentials3 import GasCloud, MooneyRivlin3, NeoHookean3, Ogden3, Sum3
from .reduction import ReducedBody, reduced_body
from .reduction3 import ReducedBody3, reduced_body3
from .separable import SeparableAlphaBeta, SeparableElliptic, SeparableRVartheta, StackelBody

__all__ = [
    "Anharmonic",
    "Barriers",
    "Body",
    "Body3",
    "BreathingBody",
    "CosOscillator",
    "CoshOscillator",
    "Cosine",
    "DoublePendulum",
    "FroeschleMap",
    "GasCloud",
    "Harmonic",
    "HeavyTop",
    "HenonHeiles",
    "HenonMap",
    "Hyperelastic",
    "McMillanMap",
    "MooneyRivlin3",
    "NeoHookean",
    "NeoHookean3",
    "Ogden3",
    "OneTurnMap",
    "Oscillator",
    "ReducedBody",
    "ReducedBody3",
    "RelativeEquilibrium",
    "Secant",
    "SelfGravity",
    "SeparableAlphaBeta",
    "SeparableElliptic",
    "SeparableRVartheta",
    "Spring",
    "StackelBody",
    "StandardMap",
    "Sum3",
    "Zero",
    "reduced_body",
    "reduced_body3",
    "relative_equilibrium",
    "riemann_ellipsoid",
    "univariate",
]

tell_apart(__name__, "angles", "regular_variables", "sections")


def __getattr__(name: str) -> Any:
    """Load a named system: it is a text, and `fastaff.formulas`, a higher layer, makes models of texts."""
    if name == "formula3":
        return _formulas("space_formula").formula3
    found = _systems().get(name) if name[:1].isupper() else None
    if found is None:
        from ...core.names import did_you_mean

        raise AttributeError(f"fastaff.models has no {name!r}.{did_you_mean(name, __dir__())}")
    return found


def __dir__() -> list[str]:
    """List the public names, with those of named systems."""
    return sorted([*__all__, "formula3", *_systems()])


def _systems() -> dict[str, Any]:
    systems: dict[str, Any] = _formulas("systems").SYSTEMS
    return systems


def _formulas(name: str) -> Any:
    """Return a module of `fastaff.formulas`."""
    from ...core.interruption import imported

    return imported(f"..formulas.{name}", __package__)
