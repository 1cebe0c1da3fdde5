"""Models: NamedTuples of float parameters whose plain methods are the physics."""

from .body import Body, HenonHeiles
from .double_pendulum import DoublePendulum
from .functions import Barriers, CoshOscillator, Cosine, CosOscillator, Oscillator, Secant, Spring, Zero, one_variable
from .maps import FroeschleMap, HenonMap, McMillanMap, OneTurnMap, StandardMap
from .potentials import Anharmonic, Harmonic, HeavyTop, Hyperelastic, NeoHookean
from .reduced_body import ReducedBody, reduced
from .separable import SeparableAlphaBeta, SeparableElliptic, SeparableRVartheta, StackelBody

__all__ = [
    "Anharmonic",
    "Barriers",
    "Body",
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
    "one_variable",
    "reduced",
]
