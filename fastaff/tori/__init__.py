"""Action-angle variables: of bodies that separate in closed form and by quadrature, of others by fits."""

from .action_angles import ActionAngles
from .fit_torus import fit_samples
from .inverse_tori import EnergyOfActions
from .torus import TorusFit

__all__ = ["ActionAngles", "EnergyOfActions", "TorusFit", "fit_samples"]
