"""Chaos indicators, maps of verdicts, chaotic fractions."""

from .chaos_map import ChaosMap
from .chaotic_fraction import ChaoticFraction
from .indicator import Character
from .own_indicator import TangentIndicator
from .shares import Shares

__all__ = ["ChaosMap", "ChaoticFraction", "Character", "Shares", "TangentIndicator"]
