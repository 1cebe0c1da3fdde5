"""Fundamental frequencies, resonances and their web."""

from .angle_lines import AngleLines
from .frequencies import FrequencyMap
from .naff import FrequencyLines
from .orbit_family import OrbitFamilies, OrbitFamily, orbit_families
from .resonance_web import ResonanceLine, ratio_web
from .resonances import Resonances, diffusion_histogram
from .tune_accumulator import TuneSums
from .tunes import Tunes

__all__ = [
    "AngleLines",
    "FrequencyLines",
    "FrequencyMap",
    "OrbitFamilies",
    "OrbitFamily",
    "ResonanceLine",
    "Resonances",
    "TuneSums",
    "Tunes",
    "diffusion_histogram",
    "orbit_families",
    "ratio_web",
]
