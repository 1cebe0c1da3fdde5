"""Integration schemes: values that check themselves, the time transformation of a splitting, and the choice among
them.
"""

from ...engine.values import tell_apart
from .automatic import AUTO, Automatic
from .catalogue import (
    BLANES_CASAS_ESCORIHUELA8,
    BLANES_MOAN6,
    DOP853,
    ITERATION,
    KAHAN_LI8,
    LEAPFROG,
    RK4,
    RKN12,
    SCHEMES,
    SOFRONIOU_SPALETTA8,
    SOFRONIOU_SPALETTA10,
    VERNER9,
    YOSHIDA4,
    Nystrom,
    RungeKutta,
    Scheme,
    Splitting,
    compose,
    scheme_named,
    triple_jump,
)
from .collocation import GAUSS8, GAUSS16, Collocation
from .time_transformed import Algebraic, Exponential, Logistic, TimeTransformed

__all__ = [
    "AUTO",
    "BLANES_CASAS_ESCORIHUELA8",
    "BLANES_MOAN6",
    "DOP853",
    "GAUSS8",
    "GAUSS16",
    "ITERATION",
    "KAHAN_LI8",
    "LEAPFROG",
    "RK4",
    "RKN12",
    "SCHEMES",
    "SOFRONIOU_SPALETTA8",
    "SOFRONIOU_SPALETTA10",
    "VERNER9",
    "YOSHIDA4",
    "Algebraic",
    "Automatic",
    "Collocation",
    "Exponential",
    "Logistic",
    "Nystrom",
    "RungeKutta",
    "Scheme",
    "Splitting",
    "TimeTransformed",
    "compose",
    "scheme_named",
    "triple_jump",
]

tell_apart(__name__)
