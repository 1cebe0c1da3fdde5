"""Poincaré maps, frequency maps and tori of planar affinely-rigid bodies, by lane-blocked Numba kernels.

Here are models, schemes, sections, indicators of chaos and the verbs. What they return, and what is needed less often,
is in `analysis`, `charts`, `models`, `schemes`, `formulas`, `files`, `jobs`; quantum mechanics in `quantum`, figures in
`plot`: each is loaded when it is first used.
"""

from importlib import import_module
from typing import Any

from .analysis.chaos.chaos_map import chaos_map
from .analysis.chaos.chaotic_fraction import chaotic_fraction
from .analysis.chaos.indicators import (
    FLI,
    GALI,
    MEGNO,
    OFLI,
    SALI,
    BirkhoffDigits,
    FrequencyDiffusion,
    Lyapunov,
    LyapunovSpectrum,
    ReversibilityError,
    ZeroOne,
)
from .analysis.frequencies.frequency_map import frequency_map
from .analysis.frequencies.naff import naff
from .analysis.frequencies.orbit_frequencies import orbit_frequencies
from .analysis.frequencies.resonance_web import resonance_web
from .analysis.frequencies.resonances import resonances
from .analysis.frequencies.tune_accumulator import TuneAccumulator
from .analysis.frequencies.tunes import tunes
from .analysis.orbits.integrate import integrate
from .analysis.orbits.tangent_map import tangent_map
from .analysis.periodic.continuation import continuation
from .analysis.periodic.find_periodic_orbits import find_periodic_orbits
from .analysis.periodic.periodic_orbits import periodic_orbits
from .analysis.sections.energy_grid import energy_grid
from .analysis.sections.energy_sample import energy_sample
from .analysis.sections.islands import islands, rotation_number
from .analysis.sections.poincare_map import poincare_map
from .analysis.tori.action_angles import action_angles, energy_of_actions, from_action_angles
from .analysis.tori.fit_torus import fit_torus
from .analysis.tori.separation import constants_of_motion
from .base.interruption import Interrupted
from .base.names import did_you_mean
from .base.status import OrbitError, Status
from .explorer.explore import explore
from .files import load, save
from .formulas.flow_text import flow
from .formulas.formula import formula, hamiltonian
from .formulas.mapping import mapping
from .jobs import Job, rerun, resume, run
from .models import (
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    NeoHookean,
    SeparableAlphaBeta,
    SeparableElliptic,
    SeparableRVartheta,
    one_variable,
    reduced,
)
from .models.sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Linear
from .schemes.automatic import AUTO
from .schemes.catalogue import BLANES_MOAN6, DOP853, KAHAN_LI8, LEAPFROG, RK4, SOFRONIOU_SPALETTA10, VERNER9, YOSHIDA4
from .schemes.time_transformed import TimeTransformed

__version__ = "0.2.0"

__all__ = [
    "AUTO",
    "BLANES_MOAN6",
    "DOP853",
    "FLI",
    "GALI",
    "KAHAN_LI8",
    "LEAPFROG",
    "MEGNO",
    "OFLI",
    "RK4",
    "SALI",
    "SOFRONIOU_SPALETTA10",
    "VERNER9",
    "YOSHIDA4",
    "AlphaEquals",
    "AlphaTurning",
    "Anharmonic",
    "AreaEquals",
    "BetaEquals",
    "BetaTurning",
    "BirkhoffDigits",
    "Body",
    "FrequencyDiffusion",
    "Harmonic",
    "HeavyTop",
    "HenonHeiles",
    "Hyperelastic",
    "Interrupted",
    "Job",
    "Linear",
    "Lyapunov",
    "LyapunovSpectrum",
    "NeoHookean",
    "OrbitError",
    "ReversibilityError",
    "SeparableAlphaBeta",
    "SeparableElliptic",
    "SeparableRVartheta",
    "Status",
    "TimeTransformed",
    "TuneAccumulator",
    "ZeroOne",
    "action_angles",
    "chaos_map",
    "chaotic_fraction",
    "constants_of_motion",
    "continuation",
    "energy_grid",
    "energy_of_actions",
    "energy_sample",
    "explore",
    "find_periodic_orbits",
    "fit_torus",
    "flow",
    "formula",
    "frequency_map",
    "from_action_angles",
    "hamiltonian",
    "integrate",
    "islands",
    "load",
    "mapping",
    "naff",
    "one_variable",
    "orbit_frequencies",
    "periodic_orbits",
    "poincare_map",
    "reduced",
    "rerun",
    "resonance_web",
    "resonances",
    "resume",
    "rotation_number",
    "run",
    "save",
    "tangent_map",
    "tunes",
]

_FOLDERS = (
    "analysis",
    "charts",
    "cli",
    "compile",
    "explorer",
    "files",
    "flows",
    "formulas",
    "jobs",
    "models",
    "paper",
    "plot",
    "quantum",
    "schemes",
)

_RENAMED = {
    "ChaosScan": "ChaoticFraction",
    "ExactLevels": "LevelTable",
    "Grid": "EnergyGrid",
    "LevelList": "LevelTable",
    "Levels": "LevelTable",
    "Lines": "FrequencyLines",
    "QuasiclassicalLevels": "LevelTable",
    "Sample": "EnergySample",
    "Tori": "ActionAngles",
    "WebLine": "ResonanceLine",
    "chaos": "chaos_map",
    "exact_levels_below": "exact_levels",
    "from_action_angle": "from_action_angles",
    "multiplets": "exact_levels",
    "quasiclassical_levels_below": "quasiclassical_levels",
    "tori": "action_angles",
    "web": "resonance_web",
}
"""Names of version 0.1 that are others now."""


def __getattr__(name: str) -> Any:
    """Load a folder of the package when it is first used; say where a name of version 0.1 is now.

    Raises ImportError for such a name, whose message `from fastaff import name` shows too, AttributeError for others.
    """
    if name in _FOLDERS:
        return import_module(f".{name}", __name__)
    new = _RENAMED.get(name, name)
    if new in __all__:
        raise ImportError(f"fastaff.{name} is fastaff.{new} since version 0.2")
    for folder in () if name.startswith("_") else ("analysis", "charts", "models", "quantum", "schemes"):
        if new in import_module(f".{folder}", __name__).__all__:
            raise ImportError(f"fastaff.{name} is fastaff.{folder}.{new} since version 0.2")
    raise AttributeError(f"fastaff has no {name!r}.{did_you_mean(name, __dir__())} dir(fastaff) lists what it has")


def __dir__() -> list[str]:
    """List the public names and folders."""
    return sorted([*__all__, *_FOLDERS])
