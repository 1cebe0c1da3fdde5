"""The analyses of orbits, one subject a folder: here are their results and less common functions.

Each folder imports only those named before it: orbits, frequencies, sections, chaos, periodic, tori.
"""

from .chaos.chaos_map import ChaosMap
from .chaos.chaotic_fraction import ChaoticFraction
from .chaos.indicator import Character
from .chaos.own_indicator import TangentIndicator
from .chaos.shares import Shares
from .frequencies.angle_lines import AngleLines
from .frequencies.frequencies import FrequencyKind, FrequencyMap
from .frequencies.naff import FrequencyLines
from .frequencies.resonance_web import ResonanceLine, ratio_web
from .frequencies.resonances import Resonances, diffusion_histogram
from .frequencies.tune_accumulator import TuneSums
from .frequencies.tunes import Tunes
from .orbits.integrate import Orbits
from .orbits.tangent_map import TangentMap
from .periodic.bifurcations import Bifurcation, Event
from .periodic.continuation import Branch
from .periodic.find_periodic_orbits import periodic_guesses
from .periodic.found_orbits import PeriodicOrbits, Stability
from .sections.energy_grid import EnergyGrid
from .sections.energy_limits import NotReached
from .sections.energy_sample import EnergySample
from .sections.islands import Islands, Rotation
from .sections.section_map import SectionMap
from .tori.action_angles import ActionAngles
from .tori.fit_torus import fit_samples
from .tori.inverse_tori import EnergyOfActions
from .tori.torus import TorusFit, Verdict

__all__ = [
    "ActionAngles",
    "AngleLines",
    "Bifurcation",
    "Branch",
    "ChaosMap",
    "ChaoticFraction",
    "Character",
    "EnergyGrid",
    "EnergyOfActions",
    "EnergySample",
    "Event",
    "FrequencyKind",
    "FrequencyLines",
    "FrequencyMap",
    "Islands",
    "NotReached",
    "Orbits",
    "PeriodicOrbits",
    "ResonanceLine",
    "Resonances",
    "Rotation",
    "SectionMap",
    "Shares",
    "Stability",
    "TangentIndicator",
    "TangentMap",
    "TorusFit",
    "TuneSums",
    "Tunes",
    "Verdict",
    "diffusion_histogram",
    "fit_samples",
    "periodic_guesses",
    "ratio_web",
]
