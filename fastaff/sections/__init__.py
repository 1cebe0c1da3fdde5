"""Energy surfaces, Poincaré maps, rotation numbers and islands."""

from .energy_grid import EnergyGrid
from .energy_sample import EnergySample
from .energy_shell import NotReached
from .islands import Islands, Rotation
from .measured_series import map_samples
from .section_map import SectionMap

__all__ = ["EnergyGrid", "EnergySample", "Islands", "NotReached", "Rotation", "SectionMap", "map_samples"]
