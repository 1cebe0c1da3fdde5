"""Molecules of atoms with pair potentials: their inertia, the body that they become, and the modes that it drops."""

from ...engine.values import tell_apart
from .pair_sums import MolecularBody
from .pairs import HarmonicBond, LennardJones, MorseBond
from .planar_molecule import Equilibrium, MolecularModes, Molecule, Vibrations, molecule, ring

__all__ = [
    "Equilibrium",
    "HarmonicBond",
    "LennardJones",
    "MolecularBody",
    "MolecularModes",
    "Molecule",
    "MorseBond",
    "Vibrations",
    "molecule",
    "ring",
]

tell_apart(__name__)
