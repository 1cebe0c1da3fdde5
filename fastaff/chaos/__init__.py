"""Chaos indicators, maps of classifications, chaotic fractions."""

from .basins import AttractorKind, Basins
from .chaos_map import ChaosMap
from .chaotic_fraction import ChaoticFraction
from .measured_series import SeriesExponent, series_exponent
from .own_indicator import TangentIndicator
from .parameter_diagrams import BifurcationDiagram, bifurcation_diagram
from .shares import Shares

__all__ = [
    "AttractorKind",
    "Basins",
    "BifurcationDiagram",
    "ChaosMap",
    "ChaoticFraction",
    "SeriesExponent",
    "Shares",
    "TangentIndicator",
    "bifurcation_diagram",
    "series_exponent",
]
