"""Models: NamedTuples of float parameters whose plain methods are the physics (layer L1)."""

from .body import Body, HenonHeiles
from .potentials import Anharmonic, Harmonic, HeavyTop, Hyperelastic, NeoHookean

__all__ = ["Anharmonic", "Body", "Harmonic", "HeavyTop", "HenonHeiles", "Hyperelastic", "NeoHookean"]
