"""Models: NamedTuples of float parameters whose plain methods are the physics."""

from typing import Any

from ...core.identity import tell_apart
from .body import Body, HenonHeiles
from .breathing import BreathingBody
from .double_pendulum import DoublePendulum
from .functions import Barriers, CoshOscillator, Cosine, CosOscillator, Oscillator, Secant, Spring, Zero, univariate
from .maps import FroeschleMap, HenonMap, McMillanMap, OneTurnMap, StandardMap
from .potentials import Anharmonic, Harmonic, HeavyTop, Hyperelastic, NeoHookean
from .reduction import ReducedBody, reduced_body
from .separable import SeparableAlphaBeta, SeparableElliptic, SeparableRVartheta, StackelBody

__all__ = [
    "Anharmonic",
    "Barriers",
    "Body",
    "BreathingBody",
    "CosOscillator",
    "CoshOscillator",
    "Cosine",
    "DoublePendulum",
    "FroeschleMap",
    "Harmonic",
    "HeavyTop",
    "HenonHeiles",
    "HenonMap",
    "Hyperelastic",
    "McMillanMap",
    "NeoHookean",
    "OneTurnMap",
    "Oscillator",
    "ReducedBody",
    "Secant",
    "SeparableAlphaBeta",
    "SeparableElliptic",
    "SeparableRVartheta",
    "Spring",
    "StackelBody",
    "StandardMap",
    "Zero",
    "reduced_body",
    "univariate",
]

tell_apart(__name__, "angles", "regular_variables", "sections")


def __getattr__(name: str) -> Any:
    """Load a named system: it is a text, and `fastaff.formulas`, a higher layer, makes models of texts."""
    found = _systems().get(name) if name[:1].isupper() else None
    if found is None:
        from ...core.names import did_you_mean

        raise AttributeError(f"fastaff.models has no {name!r}.{did_you_mean(name, __dir__())}")
    return found


def __dir__() -> list[str]:
    """List the public names, with those of named systems."""
    return sorted([*__all__, *_systems()])


def _systems() -> dict[str, Any]:
    from ...core.interruption import imported

    systems: dict[str, Any] = imported("..formulas.systems", __package__).SYSTEMS
    return systems
