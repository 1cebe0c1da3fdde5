"""Every formula of the paper as a small record, and the independent numerics it is compared with."""

from __future__ import annotations

from .affine import AFFINE
from .anharmonic import ANHARMONIC
from .classical import CLASSICAL
from .constants import CONSTANTS
from .dynamics import DYNAMICS
from .geometry import GEOMETRY
from .groups import GROUPS
from .metrics import METRICS
from .quantum import QUANTUM
from .section7 import SECTION7
from .shear import SHEAR
from .space import SPACE
from .waves import WAVES

CHAPTERS = (
    GEOMETRY,
    METRICS,
    DYNAMICS,
    CONSTANTS,
    SPACE,
    CLASSICAL,
    ANHARMONIC,
    QUANTUM,
    SHEAR,
    WAVES,
    SECTION7,
    AFFINE,
    GROUPS,
)
"""The parts of the paper, in its order."""
