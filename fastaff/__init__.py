"""Poincaré maps, frequency maps and tori of planar affinely-rigid bodies, by lane-blocked Numba kernels."""

from .analysis.chaos.chaos_map import ChaosMap, chaos
from .analysis.chaos.chaotic_fraction import ChaosScan, chaotic_fraction
from .analysis.chaos.indicators import (
    FLI,
    GALI,
    MEGNO,
    OFLI,
    SALI,
    BirkhoffDigits,
    Character,
    FrequencyDiffusion,
    Lyapunov,
    LyapunovSpectrum,
    ReversibilityError,
    ZeroOne,
)
from .analysis.frequencies.frequency_map import FrequencyKind, FrequencyMap, frequency_map
from .analysis.frequencies.naff import Lines, naff
from .analysis.frequencies.resonance_web import WebLine, ratio_web, web
from .analysis.frequencies.resonances import Resonances, diffusion_histogram, resonances
from .analysis.orbits.integrate import Orbits, integrate
from .analysis.orbits.tangent_map import TangentMap, tangent_map
from .analysis.periodic.bifurcations import Bifurcation, Event
from .analysis.periodic.continuation import Branch, continuation
from .analysis.periodic.find_periodic_orbits import find_periodic_orbits, periodic_guesses
from .analysis.periodic.periodic_orbits import PeriodicOrbits, Stability, periodic_orbits
from .analysis.sections.energy_grid import Grid, NotReached, energy_grid
from .analysis.sections.energy_sample import Sample, energy_sample
from .analysis.sections.islands import Islands, Rotation, islands, rotation_number
from .analysis.sections.poincare_map import SectionMap, poincare_map
from .analysis.tori.action_angles import EnergyOfActions, Tori, energy_of_actions, from_action_angle, tori
from .analysis.tori.fit_torus import TorusFit, Verdict, fit_torus
from .analysis.tori.separation import constants_of_motion
from .base.status import OrbitError, Status
from .charts import ALPHA_BETA, CHARTS, ELLIPTIC, R_VARTHETA, TWO_POLAR, from_matrix, to_matrix
from .flows.flow import Interrupted
from .formulas.formula import formula, hamiltonian
from .models import (
    Anharmonic,
    Body,
    Harmonic,
    HeavyTop,
    HenonHeiles,
    Hyperelastic,
    NeoHookean,
    ReducedBody,
    SeparableAlphaBeta,
    SeparableElliptic,
    SeparableRVartheta,
    StackelBody,
    Zero,
    one_variable,
    reduced,
)
from .models.sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Linear
from .quantum.all_levels import LevelList, all_levels, level_list
from .quantum.coherent_packet import coherent_packet
from .quantum.exact_levels import (
    ExactLevels,
    Multiplets,
    Quantizations,
    exact_levels,
    exact_levels_below,
    multiplets,
    quantizations,
)
from .quantum.husimi import Husimi, husimi
from .quantum.level_diagram import LevelDiagram, class_diagram, level_diagram
from .quantum.levels import Levels
from .quantum.number_packet import number_packet
from .quantum.packet import Packet
from .quantum.projected_packet import projected_packet
from .quantum.quasiclassical import (
    BOHR_SOMMERFELD,
    EBK,
    QuasiclassicalLevels,
    quasiclassical_levels,
    quasiclassical_levels_below,
)
from .quantum.revivals import Revivals, TimeScales, revivals
from .quantum.singular_ends import NoGroundState
from .quantum.spectrum import spectrum, spectrum_table
from .quantum.state import State
from .quantum.statistics import (
    GOE_RATIO,
    POISSON_RATIO,
    BerryRobnik,
    Brody,
    MeanRatio,
    SpacingFit,
    count_deviation,
    fit_spacings,
    mean_spacing_ratio,
    number_variance,
    polynomial_count,
    spacing_ratios,
    unfold,
)
from .quantum.wavefunction import wavefunction
from .quantum.weyl_count import weyl_count
from .schemes.automatic import AUTO, Automatic
from .schemes.catalogue import (
    BLANES_MOAN6,
    DOP853,
    KAHAN_LI8,
    LEAPFROG,
    RK4,
    SOFRONIOU_SPALETTA10,
    VERNER9,
    YOSHIDA4,
    RungeKutta,
    Splitting,
    scheme_named,
)
from .schemes.time_transformed import Algebraic, Exponential, Logistic, TimeTransformed

__version__ = "0.1.0"

__all__ = [
    "ALPHA_BETA",
    "AUTO",
    "BLANES_MOAN6",
    "BOHR_SOMMERFELD",
    "CHARTS",
    "DOP853",
    "EBK",
    "ELLIPTIC",
    "FLI",
    "GALI",
    "GOE_RATIO",
    "KAHAN_LI8",
    "LEAPFROG",
    "MEGNO",
    "OFLI",
    "POISSON_RATIO",
    "RK4",
    "R_VARTHETA",
    "SALI",
    "SOFRONIOU_SPALETTA10",
    "TWO_POLAR",
    "VERNER9",
    "YOSHIDA4",
    "Algebraic",
    "AlphaEquals",
    "AlphaTurning",
    "Anharmonic",
    "AreaEquals",
    "Automatic",
    "BerryRobnik",
    "BetaEquals",
    "BetaTurning",
    "Bifurcation",
    "BirkhoffDigits",
    "Body",
    "Branch",
    "Brody",
    "ChaosMap",
    "ChaosScan",
    "Character",
    "EnergyOfActions",
    "Event",
    "ExactLevels",
    "Exponential",
    "FrequencyDiffusion",
    "FrequencyKind",
    "FrequencyMap",
    "Grid",
    "Harmonic",
    "HeavyTop",
    "HenonHeiles",
    "Husimi",
    "Hyperelastic",
    "Interrupted",
    "Islands",
    "LevelDiagram",
    "LevelList",
    "Levels",
    "Linear",
    "Lines",
    "Logistic",
    "Lyapunov",
    "LyapunovSpectrum",
    "MeanRatio",
    "Multiplets",
    "NeoHookean",
    "NoGroundState",
    "NotReached",
    "OrbitError",
    "Orbits",
    "Packet",
    "PeriodicOrbits",
    "Quantizations",
    "QuasiclassicalLevels",
    "ReducedBody",
    "Resonances",
    "ReversibilityError",
    "Revivals",
    "Rotation",
    "RungeKutta",
    "Sample",
    "SectionMap",
    "SeparableAlphaBeta",
    "SeparableElliptic",
    "SeparableRVartheta",
    "SpacingFit",
    "Splitting",
    "Stability",
    "StackelBody",
    "State",
    "Status",
    "TangentMap",
    "TimeScales",
    "TimeTransformed",
    "Tori",
    "TorusFit",
    "Verdict",
    "WebLine",
    "Zero",
    "ZeroOne",
    "all_levels",
    "chaos",
    "chaotic_fraction",
    "class_diagram",
    "coherent_packet",
    "constants_of_motion",
    "continuation",
    "count_deviation",
    "diffusion_histogram",
    "energy_grid",
    "energy_of_actions",
    "energy_sample",
    "exact_levels",
    "exact_levels_below",
    "find_periodic_orbits",
    "fit_spacings",
    "fit_torus",
    "formula",
    "frequency_map",
    "from_action_angle",
    "from_matrix",
    "hamiltonian",
    "husimi",
    "integrate",
    "islands",
    "level_diagram",
    "level_list",
    "mean_spacing_ratio",
    "multiplets",
    "naff",
    "number_packet",
    "number_variance",
    "one_variable",
    "periodic_guesses",
    "periodic_orbits",
    "poincare_map",
    "polynomial_count",
    "projected_packet",
    "quantizations",
    "quasiclassical_levels",
    "quasiclassical_levels_below",
    "ratio_web",
    "reduced",
    "resonances",
    "revivals",
    "rotation_number",
    "scheme_named",
    "spacing_ratios",
    "spectrum",
    "spectrum_table",
    "tangent_map",
    "to_matrix",
    "tori",
    "unfold",
    "wavefunction",
    "web",
    "weyl_count",
]
