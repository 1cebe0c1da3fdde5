"""The three charts in which bodies separate: the names of their coordinates and constants, and their formulas.

Each family is a value without fields. number: its number in kernels; member: the property of a potential that gives it
as a member of the family; variables: its coordinates as functions of their regular variables; constants, eigenvalues:
names of the separation constants, classical and quantum; invertible: whether kernels find the tori of given actions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..systems.models.regular_variables import Circular, Hyperbolic, Itself, Radius, VarthetaVariable
from ..systems.models.separable import SeparableElliptic


class MotionQuantities(NamedTuple):
    """The quantities from which the constants of motion of phase points (orbits,) are made.

    A = alpha^2, B = beta^2; kinetic energies of the planes; h = sum over i < j of (q_i p_j - q_j p_i)^2/(2 mu); V, the
    potential without those of the angles; V_eta, V_gamma: these, or None; breathing: the kinetic energy less T_a + T_b.
    """

    A: np.ndarray
    B: np.ndarray
    T_a: np.ndarray
    T_b: np.ndarray
    h: np.ndarray
    V: np.ndarray
    V_eta: np.ndarray | None
    V_gamma: np.ndarray | None
    breathing: Any = 0.0

    @property
    def walls(self) -> tuple[Any, Any]:
        """Terms of the energy from the potentials of eta and gamma."""
        return tuple(0.0 if V is None else V / s for V, s in ((self.V_eta, self.A), (self.V_gamma, self.B)))  # type: ignore[return-value]


@dataclass(frozen=True)
class AlphaBetaFamily:
    """Bodies whose two planes are two systems: the energy is the sum of both constants.

    Source: Martens & Slawianowski, EQ2.1b.
    """

    number = 0
    member = "alpha_beta"
    chart = "alpha-beta"
    coordinates = "alpha", "beta"
    variables = Radius(), Radius()
    constants = "H_alpha", "H_beta"
    eigenvalues = "E_alpha", "E_beta"
    invertible = True

    def energy(self, constants: Any) -> Any:
        """Return the energy of the two separation constants (2, ...)."""
        return constants[0] + constants[1]

    def start(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """Return the coordinates (2, ...) at which kernels start to seek the well of a torus of given actions."""
        return np.array([A, B])

    def values(self, first: Any, second: Any, at: MotionQuantities) -> dict[str, np.ndarray]:
        """Return the constants of motion by name; first, second: the functions of the coordinates."""
        wall_a, wall_b = at.walls
        return {
            "H_alpha": at.T_a + first.value(np.sqrt(at.A)) + wall_a,
            "H_beta": at.T_b + second.value(np.sqrt(at.B)) + wall_b,
        }


@dataclass(frozen=True)
class RVarthetaFamily:
    """Bodies that separate in r and vartheta.

    Source: Martens & Slawianowski, EQ2.2f.
    """

    number = 1
    member = "r_vartheta"
    chart = "r-vartheta"
    coordinates = "r", "vartheta"
    variables = Itself(), VarthetaVariable()
    constants = "E", "h_vartheta"
    eigenvalues = "E", "e_vartheta"
    invertible = True

    def energy(self, constants: Any) -> Any:
        """Return the energy of the two separation constants (2, ...)."""
        return constants[0]

    def start(self, A: np.ndarray, B: np.ndarray) -> np.ndarray:
        """Return the coordinates (2, ...) at which kernels start to seek the well of a torus of given actions."""
        return np.array([A + B, B / A])

    def values(self, first: Any, second: Any, at: MotionQuantities) -> dict[str, np.ndarray]:
        """Return the constants of motion by name; first, second: the functions of the coordinates."""
        r = at.A + at.B
        wall_a, wall_b = at.walls
        vartheta = 2 * np.arctan2(np.sqrt(at.B), np.sqrt(at.A))
        h_vartheta = at.h + second.value(vartheta) + r * (wall_a + wall_b)
        E = at.T_a + at.T_b + at.breathing + first.value(r) + (h_vartheta - at.h) / r
        return {"E": E, "h_vartheta": h_vartheta}


@dataclass(frozen=True)
class EllipticFamily:
    """Bodies that separate in kappa and lambda.

    Source: Martens & Slawianowski, K and L of section 3 (corrected).
    """

    number = 2
    member = "elliptic"
    chart = "elliptic"
    coordinates = "kappa", "lambda"
    variables = Hyperbolic(), Circular()
    constants = "E", "K"
    eigenvalues = "E", "K"
    invertible = False

    def energy(self, constants: Any) -> Any:
        """Return the energy of the two separation constants (2, ...)."""
        return constants[0]

    def values(self, first: Any, second: Any, at: MotionQuantities) -> dict[str, np.ndarray]:
        """Return the constants of motion by name; first, second: the functions of the coordinates."""
        s, t = SeparableElliptic(first, second).squares(at.A, at.B)
        wall_a, wall_b = at.walls
        # The separated form is 0/0 at the focus, the undeformed body; V itself is not.
        E = at.T_a + at.T_b + at.V + (wall_a + wall_b)
        K = at.T_a + at.h / 2 + at.V * (1 - t) + second.value(np.arcsin(np.sqrt(t))) / 2
        if at.V_eta is not None:
            K = K + at.V_eta * (2 + s - t) / (2 * (1 + s) * (1 - t))
        if at.V_gamma is not None:
            K = K + at.V_gamma * (1 + s - t) / (2 * s * t)
        return {"E": E, "K": K, "L": E - K}


Family = AlphaBetaFamily | RVarthetaFamily | EllipticFamily

ALPHA_BETA_FAMILY = AlphaBetaFamily()
R_VARTHETA_FAMILY = RVarthetaFamily()
ELLIPTIC_FAMILY = EllipticFamily()
FAMILIES: tuple[Family, ...] = (ALPHA_BETA_FAMILY, R_VARTHETA_FAMILY, ELLIPTIC_FAMILY)
"""The families in the order in which a body's chart is chosen."""
