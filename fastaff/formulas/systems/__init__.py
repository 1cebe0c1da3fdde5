"""Named systems H(q, p), each a text with its rows and constants of motion."""

from typing import Any

from .bodies import AFFINE, TWO_POLAR, AffineBody, TwoPolarBody
from .geodesics import ELLIPSOID, KERR, MINO, EllipsoidGeodesic, KerrGeodesic
from .system import Constants
from .tops import PENDULUM, QUATERNION, SYMMETRIC, TOP, AsymmetricTop, SphericalPendulum, SymmetricTop

__all__ = [
    "AffineBody",
    "AsymmetricTop",
    "EllipsoidGeodesic",
    "KerrGeodesic",
    "SphericalPendulum",
    "SymmetricTop",
    "TwoPolarBody",
    "constants_of",
]

SYSTEMS = (PENDULUM, SYMMETRIC, TOP, QUATERNION, ELLIPSOID, KERR, MINO, TWO_POLAR, *AFFINE.values())


def constants_of(model: Any) -> Constants | None:
    """Return the constants of motion of a named system, None where a model is none."""
    text, rows = getattr(model, "formula", None), [getattr(model, name, ()) for name in ("coordinates", "momenta")]
    if not isinstance(text, str):
        return None
    for system in SYSTEMS:
        own = text == system.text or text.startswith(f"{system.text} + (")
        if own and rows == [tuple(system.coordinates.split()), tuple(system.momenta.split())]:
            return system.constants
    return None
