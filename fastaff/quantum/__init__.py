"""Quantum mechanics of the body: spectra and wave functions on GL(2,R), L^2 with the Riemannian measure."""

from .all_levels import LevelList, all_levels, level_list
from .coherent_packet import coherent_packet
from .exact_levels import (
    ExactLevels,
    Multiplets,
    Quantizations,
    exact_levels,
    exact_levels_below,
    multiplets,
    quantizations,
)
from .husimi import Husimi, husimi
from .level_diagram import LevelDiagram, class_diagram, level_diagram
from .levels import Levels
from .number_packet import number_packet
from .packet import Packet
from .projected_packet import projected_packet
from .quasiclassical import (
    BOHR_SOMMERFELD,
    EBK,
    QuasiclassicalLevels,
    quasiclassical_levels,
    quasiclassical_levels_below,
)
from .revivals import Revivals, TimeScales, revivals
from .singular_ends import NoGroundState
from .spectrum import spectrum, spectrum_table
from .state import State
from .statistics import (
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
from .wavefunction import wavefunction
from .weyl_count import weyl_count

__all__ = [
    "BOHR_SOMMERFELD",
    "EBK",
    "GOE_RATIO",
    "POISSON_RATIO",
    "BerryRobnik",
    "Brody",
    "ExactLevels",
    "Husimi",
    "LevelDiagram",
    "LevelList",
    "Levels",
    "MeanRatio",
    "Multiplets",
    "NoGroundState",
    "Packet",
    "Quantizations",
    "QuasiclassicalLevels",
    "Revivals",
    "SpacingFit",
    "State",
    "TimeScales",
    "all_levels",
    "class_diagram",
    "coherent_packet",
    "count_deviation",
    "exact_levels",
    "exact_levels_below",
    "fit_spacings",
    "husimi",
    "level_diagram",
    "level_list",
    "mean_spacing_ratio",
    "multiplets",
    "number_packet",
    "number_variance",
    "polynomial_count",
    "projected_packet",
    "quantizations",
    "quasiclassical_levels",
    "quasiclassical_levels_below",
    "revivals",
    "spacing_ratios",
    "spectrum",
    "spectrum_table",
    "unfold",
    "wavefunction",
    "weyl_count",
]
