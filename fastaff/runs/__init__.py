"""From options to running orbits: schemes, flows, observers, `integrate`, `tangent_map`, orbits of others."""

from .integrate import Orbits
from .tangent_map import TangentMap

__all__ = ["Orbits", "TangentMap"]
