"""Grids of initial conditions on a section of an energy surface (layer L3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import singledispatch
from typing import Any

import numpy as np

from .boundary import checked_model, checked_section, energies
from .models import Body
from .scalars import real
from .sections import AlphaEquals, AlphaTurning, AreaEquals, BetaEquals, BetaTurning, Linear


class NotReached(ValueError):
    """Raised where an energy surface has no point on what was asked for: the energy is below the minimum there."""


@dataclass(frozen=True)
class Grid:
    """Initial conditions on the cells of a grid over two section coordinates.

    z0 (2n, orbits): the allowed cells; cell (orbits,): the flat index of each in the grid; forbidden (n1, n2): cells that the
    energy surface does not reach; axes and names: the two coordinates, first along rows.
    """

    z0: np.ndarray
    cell: np.ndarray
    forbidden: np.ndarray
    axes: tuple[np.ndarray, np.ndarray]
    names: tuple[str, str]
    energy: float

    def spread(self, values: Any) -> np.ndarray:
        """Return values (orbits,) as a masked (n1, n2) array in which forbidden cells are masked."""
        array = np.ma.masked_all(self.forbidden.size, dtype=np.asarray(values).dtype)
        array[self.cell] = values
        return array.reshape(self.forbidden.shape)


def energy_grid(
    body: Any, *, energy: float, section: Any, axes: Sequence[Any], p_eta: float = 0.0, p_gamma: float = 0.0
) -> Grid:
    """Lift a grid of section coordinates to phase points of a given energy and angular momenta.

    Parameters: body; energy; section: a value of `fastaff.sections`; axes: two arrays of coordinates, (beta, p_beta) for
    AlphaTurning, AlphaEquals and AreaEquals, (alpha, p_alpha)
    for BetaTurning and BetaEquals, (q_j, p_j) of the other degree of freedom for Linear sections q_i = offset of a system
    of two degrees of freedom; p_eta, p_gamma: the angular momenta of the planes (bodies only).
    Returns Grid; cells that the energy does not reach are in `forbidden` and have no orbit.
    Raises ValueError where no cell is reached (an energy below the minimum, an unreachable section), TypeError for a
    section that has no grid.

    On a turning section the missing radius is the turning point that the direction asks for: +1 the inner one (the radius has a
    minimum there), -1 and 0 the outer one; on the others the missing momentum has the sign of the direction (0: +).
    AreaEquals takes one of its two branches. The roots are polished to rounding. Cost: 350 evaluations of the
    potential for each cell of a turning section, else one.
    Source: H of EQ2.1 of Martens & Slawianowski in the chart EQ2.0b.
    """
    energy, p_eta, p_gamma = checked_surface(body, section, energy, p_eta, p_gamma)
    first, second = _axes(axes)
    u, v = (array.ravel() for array in np.meshgrid(first, second, indexing="ij"))
    z, found, names = lift(body, section, energy, p_eta, p_gamma, u, v)
    if not found.any():
        raise NotReached(
            f"energy {energy} reaches no cell of the grid {names[0]} in [{first.min():.6g}, {first.max():.6g}], {names[1]} in "
            f"[{second.min():.6g}, {second.max():.6g}] on {section!r}: it is below the minimum there, or the section is elsewhere"
        )
    return Grid(
        np.ascontiguousarray(z[:, found]), np.flatnonzero(found), ~found.reshape(first.size, second.size),
        (first, second), names, energy,
    )  # fmt: skip


def checked_surface(body: Any, section: Any, energy: Any, p_eta: Any, p_gamma: Any) -> tuple[float, float, float]:
    """Return energy, p_eta and p_gamma if they and the section suit the body."""
    checked_model(body)
    checked_section(section, body)
    energy, p_eta, p_gamma = real("energy", energy), real("p_eta", p_eta), real("p_gamma", p_gamma)
    if body.degrees_of_freedom == 4 and not hasattr(body, "potential"):
        raise TypeError(f"body must be a Body with a doubly isotropic potential to have a grid, got {body!r}")
    if not isinstance(body, Body) and (p_eta or p_gamma):
        raise ValueError(f"p_eta and p_gamma belong to a Body, got {p_eta}, {p_gamma} for {type(body).__name__}")
    return energy, p_eta, p_gamma


def lift(
    body: Any, section: Any, energy: float, p_eta: float, p_gamma: float, u: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Return phase points (2n, points) at section coordinates (u, v), which of them exist (points,), and the coordinates' names."""
    with np.errstate(all="ignore"):
        z, names = _lift(section, body, energy, p_eta, p_gamma, u, v)
        found = np.isfinite(z).all(axis=0)
        n = body.degrees_of_freedom
        found &= np.broadcast_to(body.margin(*np.where(found, z, 1.0)[:n]) > 0, found.shape)
    error = np.abs(energies(body, np.where(found, z, 1.0)) - energy)
    found &= ~found | (error <= 1e-9 * (1.0 + abs(energy)))
    return z, found, names


def _axes(axes: Any) -> tuple[np.ndarray, np.ndarray]:
    try:
        first, second = (np.atleast_1d(np.asarray(axis, dtype=np.float64)) for axis in axes)
    except (TypeError, ValueError):
        raise TypeError(f"axes must be two arrays of numbers, got {axes!r}") from None
    for axis in (first, second):
        if axis.ndim != 1 or axis.size == 0 or not np.isfinite(axis).all():
            raise ValueError(f"axes must be two non-empty, finite, one-dimensional arrays, got {axes!r}")
    return first, second


@singledispatch
def _lift(section, body, energy, p_eta, p_gamma, u, v):
    """Return phase points (2n, cells), NaN where there is none, and the names of the two coordinates."""
    raise TypeError(f"section must be one that has a grid (fastaff.sections), got {section!r} for {type(body).__name__}")


def planes(alpha, p_alpha, p_eta, beta, p_beta, p_gamma):
    """Return phase points with eta = gamma = 0; a radius 0 is allowed where its angular momentum is 0."""
    across_a = p_eta / alpha if p_eta else 0.0 * alpha
    across_b = p_gamma / beta if p_gamma else 0.0 * beta
    return np.array([alpha, 0 * alpha, beta, 0 * beta, p_alpha, across_a, p_beta, across_b])


def _rest(body, energy, alpha, p_alpha, p_eta, beta, p_beta, p_gamma):
    """Return 2 mu (energy - H) at these coordinates."""
    centrifugal = (p_eta / alpha) ** 2 if p_eta else 0.0
    centrifugal = centrifugal + ((p_gamma / beta) ** 2 if p_gamma else 0.0)
    V = body.potential.value(alpha * alpha, beta * beta)
    inside = body.potential.margin(alpha * alpha, beta * beta) > 0
    return np.where(inside, 2 * body.mu * (energy - V) - centrifugal - p_alpha**2 - p_beta**2, np.nan)


def _momentum(rest, direction):
    """Return the missing momentum, with the sign of the direction; NaN where the energy does not reach."""
    return np.where(rest >= 0, np.sqrt(np.maximum(rest, 0)), np.nan) * (-1.0 if direction < 0 else 1.0)


@_lift.register
def _(section: AlphaEquals, body, energy, p_eta, p_gamma, u, v):
    alpha = np.full(u.shape, float(section.constant))
    p_alpha = _momentum(_rest(body, energy, alpha, 0.0, p_eta, u, v, p_gamma), section.direction)
    return planes(alpha, p_alpha, p_eta, u, v, p_gamma), ("beta", "p_beta")


@_lift.register
def _(section: BetaEquals, body, energy, p_eta, p_gamma, u, v):
    beta = np.full(u.shape, float(section.constant))
    p_beta = _momentum(_rest(body, energy, u, v, p_eta, beta, 0.0, p_gamma), section.direction)
    return planes(u, v, p_eta, beta, p_beta, p_gamma), ("alpha", "p_alpha")


@_lift.register
def _(section: AreaEquals, body, energy, p_eta, p_gamma, u, v):
    alpha = np.sqrt(2 * section.constant + u * u)
    p_alpha = _momentum(_rest(body, energy, alpha, 0.0, p_eta, u, v, p_gamma), section.direction)
    rising = alpha * p_alpha - u * v
    p_alpha = np.where(rising * section.direction >= 0, p_alpha, np.nan)
    return planes(alpha, p_alpha, p_eta, u, v, p_gamma), ("beta", "p_beta")


@_lift.register
def _(section: AlphaTurning, body, energy, p_eta, p_gamma, u, v):
    alpha = _turning(
        lambda x: _rest(body, energy, x, 0.0, p_eta, u, v, p_gamma), u.shape, section.direction, np.abs(u).max()
    )
    return planes(alpha, 0 * alpha, p_eta, u, v, p_gamma), ("beta", "p_beta")


@_lift.register
def _(section: BetaTurning, body, energy, p_eta, p_gamma, u, v):
    beta = _turning(
        lambda x: _rest(body, energy, u, v, p_eta, x, 0.0, p_gamma), u.shape, section.direction, np.abs(u).max()
    )
    return planes(u, v, p_eta, beta, 0 * beta, p_gamma), ("alpha", "p_alpha")


@_lift.register
def _(section: Linear, body, energy, p_eta, p_gamma, u, v):
    normal = np.asarray(section.normal, dtype=np.float64)
    axis = np.flatnonzero(normal)
    if body.degrees_of_freedom != 2 or axis.size != 1 or axis[0] > 1:
        raise TypeError(
            "section must be Linear with one non-zero entry, of a coordinate, for a system of two degrees of freedom, "
            f"got {section!r} for {type(body).__name__}"
        )
    i = int(axis[0])
    z = np.zeros((4, u.size))
    z[i], z[1 - i], z[3 - i] = section.offset / normal[i], u, v
    unit = np.zeros(2)
    unit[i] = 1.0
    weight = body.kinetic_energy(*unit)
    sign = section.direction * np.sign(normal[i])
    z[2 + i] = _momentum((energy - energies(body, z)) / weight, sign)
    other = body.coordinates[1 - i]
    return z, (other, f"p_{other}")


def _turning(rest, shape, direction, least_scale):
    """Return the radius x where rest(x) = 0: rising there (inner turning point) for direction +1, else falling (outer).

    Scans 160 radii spread evenly in the logarithm for the outermost well, looks for a narrower one around the largest value,
    then bisects to neighbouring doubles.
    """
    scan = np.geomspace(1e-4, 1.0, 160) * 64.0 * max(1.0, least_scale)
    inner = direction > 0
    low, high = np.full(shape, np.nan), np.full(shape, np.nan)
    before, best, peak = np.full(shape, np.nan), np.full(shape, -np.inf), np.zeros(shape, np.int64)
    for k, radius in enumerate(scan):
        now = rest(np.full(shape, radius))
        # Beyond the wall of the domain is as good as forbidden.
        now = np.where(np.isnan(now), -np.inf, now)
        if k:
            here = (before < 0) & (now >= 0) if inner else (before >= 0) & (now < 0)
            low, high = np.where(here, scan[k - 1], low), np.where(here, radius, high)
        peak, best, before = np.where(now > best, k, peak), np.maximum(best, now), now
    left, right = scan[np.maximum(peak - 1, 0)], scan[np.minimum(peak + 1, scan.size - 1)]
    a, b = left, right
    for _ in range(60):
        c, d = a + 0.381966011250105 * (b - a), b - 0.381966011250105 * (b - a)
        lower = np.nan_to_num(rest(c), nan=-np.inf) > np.nan_to_num(rest(d), nan=-np.inf)
        a, b = np.where(lower, a, c), np.where(lower, d, b)
    top = 0.5 * (a + b)
    narrow = np.isnan(low) & (rest(top) >= 0)
    low, high = np.where(narrow, left if inner else top, low), np.where(narrow, top if inner else right, high)
    for _ in range(64):
        middle = 0.5 * (low + high)
        value = rest(middle)
        value = np.where(np.isnan(value), -np.inf, value)
        allowed = value >= 0
        upper = allowed if inner else ~allowed
        high, low = np.where(upper, middle, high), np.where(upper, low, middle)
    return high if inner else low
