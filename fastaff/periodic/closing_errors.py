"""Errors of periodic orbits that have closed, from another return, with other steps and from a neighbour."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..runs.flow import Flow
from ..systems.models.mechanics import System
from ..systems.models.sections import Stroboscopic
from .own_units import Scale
from .return_map import Returns, closing_matrix, inverses, section_returns, way_rounding

SAFETY = 4.0
"""Factor of the error over the change by another step."""

BESIDE = 1e-6
"""Distance in own units up to which the neighbour moves linearly; farther ones, of unclosed orbits, are not used."""

ROUNDED = 4e-16
"""Rounding error of a sum, of its size."""


class Errors(NamedTuple):
    """Errors of orbits (orbits,) in own units: change: the error of the return by the scheme; orbit: of the
    closed orbit and its period in radians; reduced_monodromy: of that matrix; and period: that of the orbit that closes
    exactly.
    """

    change: np.ndarray
    orbit: np.ndarray
    reduced_monodromy: np.ndarray
    period: np.ndarray


def closing_errors(flow: Flow, section: Any, z: np.ndarray, limit: np.ndarray, found: Returns, scale: Scale) -> Errors:
    """Estimate the errors of orbits from z (2n, orbits) with their returns `found`.

    They come from one return more: with steps shorter by sqrt(2), or a tolerance of an adaptive scheme larger by 8, and
    from a point a rounding error beside the end of Newton's last correction. Both returns are taken to the orbit that
    closes by a linear system for z and the time, whose solutions are not amplified as returns are: a rounding of z
    becomes |M| times itself in the time of the return, not in the period. The errors are SAFETY times their difference,
    the last correction, and the rounding errors on the way, amplified by the system.
    """
    gain = 1.0
    other = flow
    if flow.adaptive:
        other = replace(flow, rtol=8 * flow.rtol, atol=8 * flow.atol)
    elif not flow.system.iterated:
        other = replace(flow, step=flow.step / np.sqrt(2))
        gain = 1 / (1 - 2 ** (-flow.scheme.order / 2))
    system = flow.system
    rows = len(z)
    D = scale.rows.T
    with np.errstate(all="ignore"):
        matrix = closing_matrix(system, section, z, found.points[:, -1], found.monodromy, scale)
        inverse = inverses(matrix)
        known = inverse[:, :, rows:]
        inverse = inverse[:, :, :rows]
        rounding = way_rounding(z, found.time / (1.0 if flow.system.iterated else flow.step), scale)
        left = (z.T - found.points[:, -1]) / D
        last = _applied(inverse, left)
        plane = _plane(matrix)
        signs = (-1.0) ** np.arange(rows)
        aside = _applied(inverse, left + rounding[:, None] * signs)
        aside[:, :-1] += _applied(plane, scale.rounding(z)[:, None] * signs)
        beside = z + scale.rows * _short(aside)[:, :-1].T
        back = section_returns(other, section, beside, found.points.shape[1], limit)
        aside = (beside - z).T / D
        wait = _delay(matrix, aside)
        # The difference of the other return from the first one moved by the linear motion between their starts.
        moved = (back.points[:, -1] - beside.T) / D + left
        moved -= _applied(matrix[:, :rows, :rows], aside) + matrix[:, :rows, rows] * wait[:, None]
        later = gain * ((back.time - found.time) * scale.rate - wait)
        apart = -gain * _applied(inverse, moved)
        apart[:, -1] += later
        shift = np.abs(last) + SAFETY * np.abs(apart) + np.linalg.norm(inverse, axis=2) * rounding[:, None]
        time = found.time
        if not flow.system.iterated:
            if not isinstance(section, Stroboscopic):
                time = time + last[:, -1] / scale.rate
                shift[:, -1] = shift[:, -1] - np.abs(last[:, -1])
            shift += _applied(np.abs(known), _surface_roundings(system, z, matrix, scale))
            shift[:, -1] += ROUNDED * found.time * scale.rate
        change = np.hypot(gain * np.linalg.norm(moved, axis=1), np.abs(later))
        turned = scale.matrix(back.monodromy - found.monodromy)
        turned = turned if section is None else plane @ _returned(matrix, turned) @ plane
        # It is that of z, not of the orbit that closes, after the time of the return.
        wrong = rounding + np.hypot(np.linalg.norm(shift, axis=1), last[:, -1])
        size = np.linalg.norm(scale.matrix(found.monodromy), axis=(1, 2))
        reduced = SAFETY * gain * np.linalg.norm(turned, axis=(1, 2)) + wrong * size
    return Errors(np.where(np.isnan(change), np.inf, change), np.linalg.norm(shift, axis=1), reduced, time)


def _applied(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return matrix @ vector of stacks (orbits, ...)."""
    return (matrix @ vectors[:, :, None])[:, :, 0]


def _short(change: np.ndarray) -> np.ndarray:
    """Return the changes (orbits, 2n + 1), with 0 in place of those too long for linear motion."""
    size = np.linalg.norm(change, axis=1)
    return np.where((size < BESIDE)[:, None], change, 0.0)


def _delay(matrix: np.ndarray, aside: np.ndarray) -> np.ndarray:
    """Return the delay, in radians, with which orbits that start `aside` (orbits, 2n) return to the section, by their
    closing matrices.
    """
    rows = aside.shape[1]
    normal = matrix[:, rows, :rows]
    field = matrix[:, :rows, rows]
    ends = _applied(matrix[:, :rows, :rows], aside) + aside
    late = -(normal * ends).sum(axis=1) / (normal * field).sum(axis=1)
    return np.where(np.isfinite(late), late, 0.0)


def _returned(matrix: np.ndarray, monodromy: np.ndarray) -> np.ndarray:
    """Return monodromy matrices (orbits, 2n, 2n) with each image taken back to the section by the flow."""
    rows = monodromy.shape[1]
    normal = matrix[:, rows : rows + 1, :rows]
    field = matrix[:, :rows, rows:]
    return monodromy - field * (normal @ monodromy) / (normal @ field)


def _plane(matrix: np.ndarray) -> np.ndarray:
    """Return the projections (orbits, 2n, 2n) to the plane of section and energy by closing matrices."""
    rows = matrix.shape[2] - 1
    one = matrix[:, rows, :rows]
    up = matrix[:, rows + 1, :rows]
    up = up - one * (one * up).sum(axis=1, keepdims=True)
    length = np.linalg.norm(up, axis=1, keepdims=True)
    up = up / np.where(length > 0, length, 1.0)
    return np.eye(rows) - one[:, :, None] * one[:, None] - up[:, :, None] * up[:, None]


def _surface_roundings(system: System, z: np.ndarray, matrix: np.ndarray, scale: Scale) -> np.ndarray:
    """Return the largest distances (orbits, 2) of z (2n, orbits) from section and energy by rounding, in own units."""
    rows = len(z)
    n = len(z) // 2
    off = (np.abs(matrix[:, rows:, :rows]) * (1 + np.abs(z / scale.rows).T)[:, None]).sum(axis=2)
    slope = np.linalg.norm(
        matrix[:, :rows, rows] * (scale.rate * scale.rows[:n] * scale.rows[n:])[[*range(n)] * 2].T, axis=1
    )
    sums = scale.energy + system.kinetic_energies(z) + np.abs(system.potential_energies(z))
    off[:, 1] += np.where(slope > 0, sums / np.where(slope > 0, slope, 1.0), 0.0)
    return ROUNDED * off
