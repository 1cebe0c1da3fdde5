"""The points of an energy surface over two coordinates of a section, for each kind of section."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np

from ..core.numbers import shown
from ..systems.models.sections import AlphaTurning, AngleEquals, BetaTurning, Hyperplane
from .allowed_region import crossings, extrema
from .energy_shell import EnergyShell


def lift(shell: EnergyShell, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Return phase points (2n, points) at section coordinates (u, v), a mask of those that exist (points,), and the
    coordinates' names.

    If there are several sheets over a point, the first counts.
    """
    z, found, names = lift_sheets(shell, u, v)
    first = found.argmax(axis=0)
    return np.take_along_axis(z, first[None, None], axis=0)[0], np.asarray(found.any(axis=0)), names


def lift_sheets(shell: EnergyShell, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Return all phase points (sheets, 2n, points) at section coordinates (u, v), a mask of those that exist (sheets,
    points), and the coordinates' names.

    A turning section has a sheet for each well of its radius, the outermost first; the others have one.
    """
    body = shell.model
    energy = shell.energy
    system = shell.system
    with np.errstate(all="ignore"):
        sheets, names = section_points(shell.section, shell, u, v)
        z = sheets.reshape(-1, 2 * body.degrees_of_freedom, u.size)
        rows = np.moveaxis(np.where(np.isfinite(z), z, 1.0), 1, 0)
        T = system.kinetic_energies(rows)
        V = system.potential_energies(rows)
        lives = system.inside(rows)
    # A sign change at a wall where the potential jumps is no turning point.
    found: np.ndarray = np.abs(T + V - energy) <= 1e-9 * (T + np.abs(V) + abs(energy))
    return z, found & np.isfinite(z).all(axis=1) & lives, names


def lift_leaning(shell: EnergyShell, u: np.ndarray, P: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Lift (u, P) to a section that leans, such as that of the area: P du/dl, of the length l along it, is the momentum
    along it, the energy gives the one across.
    """
    section = shell.section
    alpha, beta = radii_over(section, u)
    own, other = slopes_over(section, alpha, beta)
    length = np.hypot(other, own)
    with np.errstate(all="ignore"):
        along = P * other / length
        rest = shell.room(alpha, beta)[0] - along**2
        across = (-1.0 if section.direction < 0 else 1.0) * np.sqrt(np.maximum(rest, 0.0))
        found = (rest >= 0) & np.isfinite(rest)
        momenta = (across * other - along * own) / length, (along * other + across * own) / length
        p_alpha, p_beta = momenta[::-1] if section.over == "alpha" else momenta
        z = shell.point(alpha, p_alpha, beta, p_beta)
    return z[None], (found & np.isfinite(z).all(axis=0))[None], (section.over, "P")


@singledispatch
def section_points(
    section: Any, shell: EnergyShell, u: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, tuple[str, str]]:
    """Return phase points (2n, cells), NaN where there is none, and the names of the two coordinates."""
    if hasattr(section, "radii"):
        return _over_a_radius(section, shell, u, v)
    raise TypeError(f"section must be one that has a grid (fastaff.models.sections), got {shown(section)}")


def _momentum(rest, direction):
    """Return the missing momentum, with the sign of the direction; NaN where the energy does not reach."""
    return np.where(rest >= 0, np.sqrt(np.maximum(rest, 0)), np.nan) * (-1.0 if direction < 0 else 1.0)


def radii_over(section: Any, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return alpha and beta on a section that gives one of them over the other, u; TypeError for any other section."""
    if not hasattr(section, "radii"):
        raise TypeError(f"section {shown(section)} has no known boundary: give `axes`")
    alpha, beta = section.radii(u)
    return alpha, beta


def slopes_over(section: Any, alpha: np.ndarray, beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of the function of a section with respect to the radius of its figure and to the other."""
    to_alpha, to_beta = section.slopes(alpha, beta)
    return (to_alpha, to_beta) if section.over == "alpha" else (to_beta, to_alpha)


def _over_a_radius(section, shell, u, v):
    alpha, beta = radii_over(section, u)
    across = _momentum(shell.room(alpha, beta)[0] - v**2, section.direction)
    if hasattr(section, "slopes"):
        own, other = slopes_over(section, alpha, beta)
        across = np.where((other * across + own * v) * section.direction >= 0, across, np.nan)
    momenta = (v, across) if section.over == "alpha" else (across, v)
    return shell.point(alpha, momenta[0], beta, momenta[1]), (section.over, f"p_{section.over}")


@section_points.register(AlphaTurning)
@section_points.register(BetaTurning)
def _(section, shell, u, v):
    alpha = isinstance(section, AlphaTurning)
    radius, across = _turning(shell, u, v, alpha=alpha)
    z = np.array([shell.point(*((x, 0 * x, u, v) if alpha else (u, v, x, 0 * x))) for x in radius])
    own = z[:, 5 if alpha else 7]
    own[across > 0] = across[across > 0]
    return z, ("beta", "p_beta") if alpha else ("alpha", "p_alpha")


@section_points.register(Hyperplane)
@section_points.register(AngleEquals)
def _(section, shell, u, v):
    body = shell.model
    system = shell.system
    if body.degrees_of_freedom != 2:
        raise TypeError(
            "section must be a Hyperplane normal to one coordinate for a system of two degrees of freedom, got "
            f"{shown(section)}"
        )
    i, at, sign = shell.section_coordinate()
    z = np.zeros((4, u.size))
    z[i] = at
    z[1 - i] = u
    z[3 - i] = v
    coordinates, momenta = np.reshape(system.row_names, (2, 2))
    names = str(coordinates[1 - i]), str(momenta[1 - i])
    if not system.quadratic:
        roots = shell.roots_along(z, 2 + i, -1 if sign < 0 else 1)
        sheets = np.repeat(z[None], len(roots), axis=0)
        sheets[:, 2 + i] = roots
        return sheets, names
    unit = np.zeros(2)
    unit[i] = 1.0
    weight = body.kinetic_energy(*unit)
    # The sign is the velocity's, which is 0 at another momentum in a turning frame or beside a product of momenta.
    own = system.at_rest(z[:2])[i] - body.velocity(*z[2:])[i] / (2 * weight)
    z[2 + i] = _momentum((shell.energy - system.energies(z)) / weight + own * own, sign)
    z[2 + i] += own
    return z, names


def _turning(shell, u, v, *, alpha):
    """Return the turning points of a radius, (sheets, points): inner ones for direction +1, else outer ones, the
    outermost first.

    The last sheet of the inner ones is the axis, where the angular momentum is 0 and the motion goes through it; the
    momentum that it then has, across like that of the inner turning points in the limit of small angular momentum,
    comes second (sheets, points).
    """
    other, column = np.unique(u, return_inverse=True)
    rest = shell.radial(other, alpha=alpha)
    direction = shell.section.direction
    sheets, axis = crossings(rest, extrema(rest, other.size), column, v * v, direction > 0)
    across = 0.0 * sheets
    if direction > 0 and axis.any():
        through = rest(np.zeros(u.size), column)[0] - v * v
        through = np.sqrt(np.where(axis & (through >= 0), through, np.nan))
        sheets = np.concatenate([sheets, [0.0 * through]])
        across = np.concatenate([across, [through]])
    return sheets, across
