"""The public names of the package and their modules: `fastaff` loads each when it is first used."""

from .analysis.chaos.chaos_map import chaos_map
from .analysis.chaos.chaotic_fraction import chaotic_fraction
from .analysis.chaos.indicators import (
    FLI,
    GALI,
    MEGNO,
    OFLI,
    SALI,
    Lyapunov,
    LyapunovSpectrum,
)
from .analysis.chaos.pass_indicators import BirkhoffDigits, FrequencyDiffusion, ReversibilityError, ZeroOne
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
from .analysis.tori.action_angles import action_angles
from .analysis.tori.fit_torus import fit_torus
from .analysis.tori.inverse_tori import energy_of_actions, from_action_angles
from .analysis.tori.separation import constants_of_motion
from .base.interruption import Interrupted
from .base.progress import progress
from .base.status import OrbitError, Status
from .exchange.files import load, save
from .explorer.explore import explore
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
    "progress",
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
