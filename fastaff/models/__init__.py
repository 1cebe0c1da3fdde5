"""Models: NamedTuples of float parameters whose plain methods are the physics."""

from typing import Any

from .body import Body, HenonHeiles
from .double_pendulum import DoublePendulum
from .functions import Barriers, CoshOscillator, Cosine, CosOscillator, Oscillator, Secant, Spring, Zero, one_variable
from .maps import FroeschleMap, HenonMap, McMillanMap, OneTurnMap, StandardMap
from .potentials import Anharmonic, Harmonic, HeavyTop, Hyperelastic, NeoHookean
from .reduced_body import ReducedBody, reduced
from .separable import SeparableAlphaBeta, SeparableElliptic, SeparableRVartheta, StackelBody

__all__ = [
    "AffineBody",
    "Anharmonic",
    "AsymmetricTop",
    "Barriers",
    "Body",
    "CosOscillator",
    "CoshOscillator",
    "Cosine",
    "DoublePendulum",
    "EllipsoidGeodesic",
    "FroeschleMap",
    "Harmonic",
    "HeavyTop",
    "HenonHeiles",
    "HenonMap",
    "Hyperelastic",
    "KerrGeodesic",
    "McMillanMap",
    "NeoHookean",
    "OneTurnMap",
    "Oscillator",
    "ReducedBody",
    "Secant",
    "SeparableAlphaBeta",
    "SeparableElliptic",
    "SeparableRVartheta",
    "SphericalPendulum",
    "Spring",
    "StackelBody",
    "StandardMap",
    "SymmetricTop",
    "TwoPolarBody",
    "Zero",
    "one_variable",
    "reduced",
]


def __getattr__(name: str) -> Any:
    """Load a system of the list that is a text: `fastaff.formulas`, which stands above, makes models of texts."""
    if name not in __all__:
        raise AttributeError(f"fastaff.models has no {name!r}")
    from ..base.interruption import imported

    return getattr(imported(".formulas.systems", "fastaff"), name)
