"""Poincaré maps, frequency maps and tori of planar affinely-rigid bodies, by lane-blocked Numba kernels."""

from .charts import ALPHA_BETA, R_VARTHETA, TWO_POLAR, from_matrix, to_matrix
from .engine import Interrupted
from .frequency import FrequencyMap, frequency_map
from .grid import Grid, energy_grid
from .integrate import Orbits, integrate
from .models import Anharmonic, Body, Harmonic, HeavyTop, HenonHeiles, Hyperelastic, NeoHookean
from .naff import Lines, naff
from .poincare import SectionMap, poincare_map
from .schemes import (
    BLANES_MOAN6,
    DOP853,
    KAHAN_LI8,
    LEAPFROG,
    RK4,
    SOFRONIOU_SPALETTA10,
    YOSHIDA4,
    RungeKutta,
    Splitting,
    scheme_named,
)
from .sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Linear
from .status import OrbitError, Status

__version__ = "0.1.0"

__all__ = [
    "ALPHA_BETA",
    "BLANES_MOAN6",
    "DOP853",
    "KAHAN_LI8",
    "LEAPFROG",
    "RK4",
    "R_VARTHETA",
    "SOFRONIOU_SPALETTA10",
    "TWO_POLAR",
    "YOSHIDA4",
    "AlphaEquals",
    "AlphaTurning",
    "Anharmonic",
    "AreaEquals",
    "BetaEquals",
    "BetaTurning",
    "Body",
    "FrequencyMap",
    "Grid",
    "Harmonic",
    "HeavyTop",
    "HenonHeiles",
    "Hyperelastic",
    "Interrupted",
    "Linear",
    "Lines",
    "NeoHookean",
    "OrbitError",
    "Orbits",
    "RungeKutta",
    "SectionMap",
    "Splitting",
    "Status",
    "energy_grid",
    "frequency_map",
    "from_matrix",
    "integrate",
    "naff",
    "poincare_map",
    "scheme_named",
    "to_matrix",
]
