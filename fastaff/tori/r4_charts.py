"""The charts of R^4 = GL(2,R) in which central potentials and the harmonic one separate.

Each chart splits the matrix elements x, y, z, u into subspaces R^d and has spherical coordinates in each: the radius
(or the element itself, d = 1), then d - 2 polar angles from an axis each, then the azimuth of the first two elements.

    H = sum over the subspaces of [p_r^2 + L_d^2/r^2]/(2 mu) + V,
    L_j^2 = p_j^2 + L_{j-1}^2/sin^2(angle_j)  (j = d ... 3),   L_2 = |p_azimuth|

A potential separates in R^4 as a whole if and only if it depends on r alone; in a sum of subspaces, if and only if it
is C |phi|^2/2 + constant. For V(alpha, beta) = f(D1^2 + D2^2) no other angular term is possible, because every term
that depends on vartheta couples all angles of these charts.

Source: Martens & Slawianowski, section 3, EQ2.2c and the mixed coordinates below it (corrected).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..systems.charts.catalogue import CARTESIAN, POLAR_CARTESIAN, POLAR_POLAR, SPHERICAL, SPHERICAL_CARTESIAN

EXPONENTS = (-12, 24)
"""Range of |phi|^2, in powers of 2, on which a potential is compared with its values on spheres."""

DIRECTIONS = 24
"""Directions that are compared."""

ALIKE = 1e-9
"""Largest difference of V over a sphere that counts as round-off, relative to V nearby."""

FEWEST = 8
"""Least number of spheres on which V must be finite."""


class Subspace(NamedTuple):
    """A subspace of x, y, z, u with spherical coordinates: the rows of its elements, the azimuth's two first; for the
    polar angle of each further element, the last first, whether it grows from the axis (a latitude falls).
    """

    elements: tuple[int, ...]
    from_axis: tuple[bool, ...] = ()

    @property
    def dimension(self) -> int:
        """Number of elements."""
        return len(self.elements)

    @property
    def rotating(self) -> tuple[bool, ...]:
        """Whether each coordinate rotates: the azimuth does."""
        return tuple(i > 0 and i == self.dimension - 1 for i in range(self.dimension))


@dataclass(frozen=True)
class R4Family:
    """A chart of R^4 in which bodies separate: its coordinates, separation constants and subspaces."""

    chart: str
    coordinates: tuple[str, ...]
    constants: tuple[str, ...]
    subspaces: tuple[Subspace, ...]

    @property
    def whole(self) -> bool:
        """Whether R^4 is not split: any central potential separates."""
        return len(self.subspaces) == 1

    @property
    def rotating(self) -> tuple[bool, ...]:
        """Whether each coordinate rotates; actions of the others are not negative."""
        return tuple(turns for space in self.subspaces for turns in space.rotating)

    def energy(self, constants: Any) -> Any:
        """Return the energy of the separation constants (4, ...)."""
        return sum(row for name, row in zip(self.constants, constants, strict=True) if name.startswith("E"))


R4_FAMILIES: tuple[R4Family, ...] = (
    R4Family(SPHERICAL.name, SPHERICAL.names, ("E", "L_4", "L_3", "p_nu"), (Subspace((0, 1, 2, 3), (True, False)),)),
    R4Family(
        SPHERICAL_CARTESIAN.name,
        SPHERICAL_CARTESIAN.names,
        ("E_R", "L_3", "p_chi", "E_u"),
        (Subspace((0, 1, 2), (True,)), Subspace((3,))),
    ),
    R4Family(
        POLAR_POLAR.name,
        POLAR_POLAR.names,
        ("E_r1", "p_chi1", "E_r2", "p_chi2"),
        (Subspace((0, 1)), Subspace((2, 3))),
    ),
    R4Family(
        POLAR_CARTESIAN.name,
        POLAR_CARTESIAN.names,
        ("E_r1", "p_chi1", "E_z", "E_u"),
        (Subspace((0, 1)), Subspace((2,)), Subspace((3,))),
    ),
    R4Family(
        CARTESIAN.name, CARTESIAN.names, ("E_x", "E_y", "E_z", "E_u"), tuple(Subspace((row,)) for row in range(4))
    ),
)
"""The charts of R^4, the one of most potentials first."""


class CentralPotential(NamedTuple):
    """The potential energy of a central body as a function of s = |phi|^2."""

    model: Any

    def value(self, s):
        """Return V at s, from the point of four equal coordinates."""
        q = 0.5 * np.sqrt(s)
        return self.model.potential_energy(q, q, q, q)


class CentralBody(NamedTuple):
    """A body whose potential depends on r alone: its potential; its stiffness k if V = k |phi|^2/2 + offset, else 0."""

    potential: CentralPotential
    stiffness: float
    offset: float


@dataclass(frozen=True)
class R4Separated:
    """A central body in a chart of R^4: its family, its potential and mu."""

    family: R4Family
    body: CentralBody
    mu: float

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows of actions, frequencies and angles."""
        return self.family.coordinates

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of the four constants of motion in involution."""
        return self.family.constants

    def energy(self, constants: np.ndarray) -> np.ndarray:
        """Return the energy of the separation constants (4, ...)."""
        return self.family.energy(constants) + (0.0 if self.family.whole else self.body.offset)

    def turning_points(self, places: np.ndarray) -> np.ndarray:
        """Return the turning points (4, 2, ...): these charts have them as coordinates."""
        return places

    def plane_actions(self, J: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return NaN: eta and gamma are no coordinates of these charts."""
        none = np.full(J.shape[1:], np.nan)
        return none, none


def central_body(model: Any) -> CentralBody | None:
    """Return a body as a central one, or None if its potential does not depend on D1^2 + D2^2 alone."""
    s = 2.0 ** np.arange(EXPONENTS[0], EXPONENTS[1] + 1)
    k = np.arange(1, DIRECTIONS + 1)
    # Quasirandom points of the three angles of a direction.
    fraction, eta, gamma = (np.mod(k * step, 1.0)[:, None] for step in (0.8191725134, 0.6710436067, 0.5497004779))
    alpha, beta = np.sqrt(s * fraction), np.sqrt(s * (1 - fraction))
    turn = 2 * np.pi
    at = (
        alpha * np.cos(turn * eta),
        alpha * np.sin(turn * eta),
        beta * np.cos(turn * gamma),
        beta * np.sin(turn * gamma),
    )
    potential = CentralPotential(model)
    with np.errstate(all="ignore"):
        V = np.asarray(model.potential_energy(*at), dtype=np.float64) + np.zeros_like(at[0])
        radial = np.asarray(potential.value(s), dtype=np.float64) + 0.0 * s
        finite = np.isfinite(V)
        known = finite.all(axis=0) & np.isfinite(radial)
        if known.sum() < FEWEST or np.any(finite.any(axis=0) & ~known):
            return None
        size = np.where(known, np.abs(radial), 0.0)
        nearby = np.maximum(size, np.maximum(np.append(size[1:], 0.0), np.append(0.0, size[:-1])))
        if np.any(np.abs(V - radial)[:, known] > ALIKE * nearby[known]):
            return None
        slope = 2 * (radial[-1] - radial[0]) / (s[-1] - s[0])
        offset = radial[0] - slope * s[0] / 2
        misfit = np.abs(radial - offset - slope * s / 2)
    harmonic = bool(np.all(known)) and slope > 0 and bool(np.all(misfit <= ALIKE * nearby))
    return CentralBody(potential, float(slope) if harmonic else 0.0, float(offset) if harmonic else 0.0)


def r4_families(body: CentralBody | None) -> list[R4Family]:
    """Return the charts of R^4 in which a central body separates; none for other bodies, None."""
    if body is None:
        return []
    return [family for family in R4_FAMILIES if family.whole or body.stiffness > 0]
