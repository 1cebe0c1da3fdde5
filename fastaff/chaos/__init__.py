"""Chaos indicators, maps of classifications, chaotic fractions."""

from .chaos_map import ChaosMap
from .chaotic_fraction import ChaoticFraction
from .own_indicator import TangentIndicator
from .shares import Shares

__all__ = ["ChaosMap", "ChaoticFraction", "Shares", "TangentIndicator"]
