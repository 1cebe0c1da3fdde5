"""Quantum mechanics of the body: spectra and wave functions on GL(2,R), L^2 with the Riemannian measure."""

from .chaos.husimi import Husimi, VibrationHusimi, husimi
from .chaos.level_statistics import (
    GOE_RATIO,
    POISSON_RATIO,
    MeanRatio,
    mean_spacing_ratio,
    number_variance,
    spacing_ratios,
)
from .chaos.spacing_laws import BerryRobnik, Brody, SpacingFit, fit_spacings
from .chaos.unfold import count_deviation, polynomial_count, unfold
from .chaos.weyl_count import weyl_count
from .exact.exact_levels import exact_levels
from .exact.quantizations import Quantizations, quantizations
from .exact.quasiclassical_levels import BOHR_SOMMERFELD, EBK, quasiclassical_levels
from .exact.wavefunction import wavefunction
from .groups.affine import AffineSpectrum, affine_spectrum
from .groups.shear_series import shear_factor
from .groups.unitary import unitary_levels, unitary_wave
from .packets.coherent_packet import coherent_packet
from .packets.number_packet import number_packet
from .packets.packet import Packet
from .packets.projected_packet import projected_packet
from .packets.revivals import Revivals, TimeScales, revivals
from .solvers.singular_ends import NoGroundState
from .spectra.all_levels import all_levels
from .spectra.level_diagram import LevelDiagram, class_diagram, level_diagram
from .spectra.spectrum import spectrum, spectrum_table
from .states.level_table import LevelTable, Multiplets, level_list
from .states.state import State
from .states.vibration_state import VibrationState

__all__ = [
    "BOHR_SOMMERFELD",
    "EBK",
    "GOE_RATIO",
    "POISSON_RATIO",
    "AffineSpectrum",
    "BerryRobnik",
    "Brody",
    "Husimi",
    "LevelDiagram",
    "LevelTable",
    "MeanRatio",
    "Multiplets",
    "NoGroundState",
    "Packet",
    "Quantizations",
    "Revivals",
    "SpacingFit",
    "State",
    "TimeScales",
    "VibrationHusimi",
    "VibrationState",
    "affine_spectrum",
    "all_levels",
    "class_diagram",
    "coherent_packet",
    "count_deviation",
    "exact_levels",
    "fit_spacings",
    "husimi",
    "level_diagram",
    "level_list",
    "mean_spacing_ratio",
    "number_packet",
    "number_variance",
    "polynomial_count",
    "projected_packet",
    "quantizations",
    "quasiclassical_levels",
    "revivals",
    "shear_factor",
    "spacing_ratios",
    "spectrum",
    "spectrum_table",
    "unfold",
    "unitary_levels",
    "unitary_wave",
    "wavefunction",
    "weyl_count",
]
