"""Tori about an axis of symmetry: angles R, z, phi of orbits in x, y, z.

An orbit whose vector of angular momentum is conserved, as in a spherical potential, is fitted in its plane, where it
has two frequencies. The third angle is that of the plane, which rests, so relations of the frequencies do no harm.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ..core.numbers import kind_of, shown
from ..frequencies.angle_loops import NAMED
from ..results.calls import names_of
from ..systems.models.mechanics import System
from .series import canonical
from .torus import TorusFit, classified, residual

AZIMUTHS = (0.7, 1.3, 2.1, 2.9, 3.6, 4.7, 5.9)
"""Angles, in radians, by which initial conditions are rotated for a comparison of forces."""

OFFSETS = 9
"""Values of an angle at which the cycles of another one are followed."""

LEAST_POINTS = 128
"""Least number of points of a cycle."""

EQUAL = 1e-9
"""Relative difference of vectors that counts as rounding and integration errors."""


def angle_names(angles: Any, coordinates: int) -> tuple[str, ...]:
    """Return the names of angles about the z axis. Raises ValueError or TypeError for others, and for those of another
    number of coordinates.
    """
    if not isinstance(angles, str):
        raise TypeError(f"angles must be text such as 'R z phi', got {kind_of(angles)}.")
    names = names_of(angles)
    if names not in NAMED:
        raise ValueError(f"angles must be 'R phi' for x, y or 'R z phi' for x, y, z, got {shown(angles)}.")
    if len(names) != coordinates:
        own = next((f"Use {' '.join(known)!r}." for known in NAMED if len(known) == coordinates), "Leave angles out.")
        raise ValueError(f"angles must be of {coordinates} coordinates, got {' '.join(names)!r} of {len(names)}. {own}")
    return names


def axis_angles(angles: Any, system: System, z: np.ndarray) -> bool:
    """Tell whether angles about the z axis of rows x, y, z are asked for, not those of coordinates R, z, phi. Raises
    ValueError or TypeError where the model or the initial conditions z (2n, 1) have none.
    """
    if angles is None:
        return False
    if system.iterated or system.driven or system.planar:
        raise ValueError(f"angles must be left out for {kind_of(system.model)}, got {shown(angles)}.")
    names = angle_names(angles, system.n)
    said = repr(" ".join(names))
    if sorted(system.names) == sorted(names):
        return False
    if not symmetric(system, z):
        raise ValueError(
            f"model must be symmetric about the z axis for angles={said}, got forces that depend on the azimuth. Leave "
            "angles out."
        )
    check_momentum(z, "z0")
    return True


def symmetric(system: System, z: np.ndarray) -> bool:
    """Tell whether rotations about the z axis rotate dz/dt with the phase points z (2n, 1)."""
    here = system.slopes(z)
    n = system.n
    size = np.repeat([np.abs(here[:n]).max(), np.abs(here[n:]).max()], n)[:, None]
    apart = [np.abs(system.slopes(rotated(z, angle)) - rotated(here, angle)) for angle in AZIMUTHS]
    return bool((np.array(apart) <= EQUAL * size).all())


def check_momentum(z: np.ndarray, name: str) -> None:
    """Raise ValueError unless states z (2n, samples) have one angular momentum about the z axis that is not 0."""
    n = len(z) // 2
    momentum = z[0] * z[n + 1] - z[1] * z[n]
    size = np.sqrt((z[:n] ** 2).sum(axis=0).max() * (z[n:] ** 2).sum(axis=0).max())
    if not np.ptp(momentum) <= EQUAL * size:
        raise ValueError(
            f"{name} must have a constant angular momentum about z, got {momentum.min():.6g} to {momentum.max():.6g}. "
            "Leave angles out."
        )
    if not np.abs(momentum).min() > EQUAL * size:
        raise ValueError(
            f"{name} must have angular momentum about the z axis, got {shown(float(momentum[0]))}. Leave angles out."
        )


def momentum_drift(z: np.ndarray) -> float:
    """Return by how much the angular momentum of states z (2n, samples) changes: for an orbit in space, its vector if
    that is conserved, else its component along z.
    """
    n = len(z) // 2
    along = z[0] * z[n + 1] - z[1] * z[n]
    if n == 2 or orbital_plane(z) is None:
        return float(np.ptp(along))
    return float(np.sqrt((np.ptp(np.cross(z[:3], z[3:], axis=0), axis=1) ** 2).sum()))


def rotated(z: np.ndarray, angle: float) -> np.ndarray:
    """Return phase points z (2n, ...) rotated about the z axis."""
    c, s = np.cos(angle), np.sin(angle)
    n = len(z) // 2
    out = z.copy()
    for x, y in ((0, 1), (n, n + 1)):
        out[x] = c * z[x] - s * z[y]
        out[y] = s * z[x] + c * z[y]
    return out


class OrbitalPlane:
    """The plane of an orbit in space: its basis (3, 2), a node and the direction 90 degrees ahead, its cosine and sine
    of inclination, and the azimuth of the node in cycles.
    """

    def __init__(self, momentum: np.ndarray):
        size = np.sqrt((momentum**2).sum())
        across = np.hypot(momentum[0], momentum[1])
        self.cosine = float(momentum[2] / size)
        self.sine = float(across / size)
        self.node = float(np.arctan2(momentum[0], -momentum[1]) / (2 * np.pi))
        c, s = np.cos(2 * np.pi * self.node), np.sin(2 * np.pi * self.node)
        self.basis = np.array([[c, -s * self.cosine], [s, c * self.cosine], [0.0, self.sine]])

    def inside(self, z: np.ndarray) -> np.ndarray:
        """Return states (6, samples) as states in the plane (4, samples)."""
        return np.vstack([self.basis.T @ z[:3], self.basis.T @ z[3:]])

    def lifted(self, flat: TorusFit, system: System) -> TorusFit:
        """Return the torus in space of a torus in the plane: the azimuth is that of the node, and that of the orbit
        from it.
        """
        sense = 1 if self.cosine > 0 else -1
        names = [{"phi": "z"}.get(name, name) for name in flat.names]
        last = len(names) - 1
        still = np.pad(flat.k, ((0, 0), (0, 1)))
        node = np.zeros(flat.dimension + 1, int)
        node[last:] = -sense, 1
        terms, coefficients = [still], [np.zeros((6, len(still)), complex)]
        coefficients[0][[2, 5]] = self.sine * flat.coefficients[[1, 3]]
        for way in (1, -1):
            rows = np.zeros((6, len(still)), complex)
            for row, u, v in ((0, 0, 1), (3, 2, 3)):
                part = (flat.coefficients[u] + way * 1j * self.cosine * flat.coefficients[v]) / 2
                rows[row] = part
                rows[row + 1] = -1j * way * part
            terms.append(still + way * node)
            coefficients.append(rows)
        k, z, shift = canonical(np.concatenate(terms), np.concatenate(coefficients, axis=1))
        flatter = self.sine**2 / (1 + abs(self.cosine))
        nu = np.append(flat.nu, sense * flat.nu[last])
        theta0 = np.append(flat.theta0, self.node + sense * flat.theta0[last])
        J = np.append(flat.J, self.cosine * flat.J[last])
        J[last] *= flatter
        J_error = np.append(flat.J_error, flat.J_error[last])
        left = residual(system, k, z, nu, None, 1)
        return replace(
            flat,
            names=(*names, "phi"),
            nu=nu,
            nu_error=np.append(flat.nu_error, flat.nu_error[last]),
            J=J,
            J_error=J_error,
            theta0=(theta0 + shift) % 1.0,
            k=k,
            coefficients=z,
            residual=left,
            classification=classified(system, len(nu)),
            dimension=len(nu),
            relations=np.zeros((0, len(nu)), int),
            evidence=MappingProxyType({**flat.evidence, "residual": left}),
            model=system.model,
        )


def cycle_windings(fit: TorusFit) -> np.ndarray:
    """Return how often the cycles of the first two angles of a torus in space go around the middle of the loops in R^2
    and in z: (2 cycles, 2 loops), the median over OFFSETS values of the other angle.
    """
    windings = np.zeros((2, 2), int)
    for cycle in (0, 1):
        count = max(LEAST_POINTS, 16 * int(np.abs(fit.k[:, cycle]).max(initial=0)))
        theta = np.zeros((3, OFFSETS, count))
        theta[cycle] = np.arange(count) / count
        theta[1 - cycle] = np.arange(OFFSETS)[:, None] / OFFSETS
        x, y, z, p_x, p_y, p_z = fit.evaluate(theta)
        for loop, (q, p) in enumerate(((x * x + y * y, x * p_x + y * p_y), (z, p_z))):
            q = q - (q.max() + q.min()) / 2
            around = q - 1j * np.ptp(q) / (np.ptp(p) or 1.0) * p
            turns = np.angle(np.roll(around, -1, axis=1) * around.conj()).sum(axis=1) / (2 * np.pi)
            windings[cycle, loop] = round(float(np.median(turns)))
    return windings


def with_own_cycles(fit: TorusFit) -> TorusFit:
    """Return a torus in space in the basis whose cycles go once around in R and in z; without the names R and z if it
    has none, because the orbit is trapped in a resonance of R and z.
    """
    if fit.names != ("R", "z", "phi") or not np.isfinite(fit.coefficients).all():
        return fit
    windings = cycle_windings(fit)
    if np.array_equal(windings, np.eye(2, dtype=int)):
        return fit
    if abs(round(np.linalg.det(windings))) != 1:
        return replace(fit, names=("theta 1", "theta 2", "phi"))
    basis = np.eye(3, dtype=int)
    basis[:2, :2] = windings.T
    return replace(fit.in_basis(basis), names=fit.names)


def orbital_plane(z: np.ndarray) -> OrbitalPlane | None:
    """Return the plane of the states z (2n, samples) of an orbit in space; None for z = 0, and for no plane."""
    if len(z) != 6:
        return None
    momentum = np.cross(z[:3], z[3:], axis=0)
    size = np.sqrt((momentum**2).sum(axis=0))
    if not (np.ptp(momentum, axis=1) <= EQUAL * size.max()).all():
        return None
    plane = OrbitalPlane(momentum[:, 0])
    return plane if plane.sine > EQUAL else None
