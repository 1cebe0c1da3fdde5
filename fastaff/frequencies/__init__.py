"""Fundamental frequencies, resonances and their web."""

from .angle_lines import AngleLines
from .frequencies import FrequencyMap
from .naff import FrequencyLines
from .resonance_web import ResonanceLine, ratio_web
from .resonances import Resonances, diffusion_histogram
from .tune_accumulator import TuneSums
from .tunes import Tunes

__all__ = [
    "AngleLines",
    "FrequencyLines",
    "FrequencyMap",
    "ResonanceLine",
    "Resonances",
    "TuneSums",
    "Tunes",
    "diffusion_histogram",
    "ratio_web",
]
