"""The equation of a class in the plane of rho and vartheta, with samples of its potential."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..states.symmetry import SymmetryClass
from .cover import Cover
from .singular_ends import REACH, NoGroundState, Well, check_bottom, check_poles, decayed, potential, well


class PlaneProblem(NamedTuple):
    """One class of a body in units hbar^2/2 mu = 1: U(rho, vartheta) = 2 mu V/hbar^2, and samples of it with
    centrifugal terms.

    rho, v: sample points; lowest: least value at every rho, with Langer's 1/rho^2; threshold: its limit at large rho,
    or inf; far: a wall, or inf; smooth: whether the weights take all singular parts at the ends of vartheta.
    """

    U: Callable
    a: np.ndarray
    b: np.ndarray
    well: Well
    rho: np.ndarray
    v: np.ndarray
    lowest: np.ndarray
    threshold: float
    smooth: bool
    states: Callable
    channels: Callable
    far: float

    def share(self, rho: np.ndarray, top: float) -> np.ndarray:
        """Return an upper bound of states up to `top` at rho, relative to the allowed region: e^-action."""
        allowed = np.flatnonzero(self.lowest < top)
        decay = np.minimum(np.sqrt(np.maximum(self.lowest - top, 0)) * np.gradient(self.rho), REACH)
        decay[allowed[0] : allowed[-1] + 1] = 0
        action = np.cumsum(decay)
        return np.exp(-np.interp(rho, self.rho, np.abs(action - action[allowed[0]])))


def plane_problem(
    model: Any, chosen: SymmetryClass, unit: float, limit: float, hidden: Cover | None = None
) -> PlaneProblem:
    """Return the problem of a class; hidden: where there are wells that the samples do not see."""
    a = np.array([chosen.a])
    b = np.array([chosen.b])

    def U(rho, vartheta):
        A = (rho * np.cos(vartheta / 2)) ** 2
        B = (rho * np.sin(vartheta / 2)) ** 2
        with np.errstate(over="ignore"):
            return potential(model, A, B) / unit

    v = np.pi * (np.arange(256) + 0.5) / 256
    rho = _size(U, v[::16], a, b) * np.geomspace(1e-4, 1e4, 1601)
    if hidden is not None:
        inside = (x := hidden.nodes(1))[(np.abs(x) < 1)]
        rho = np.union1d(rho, hidden.nodes(0))
        v = np.union1d(v, np.arccos(inside))
    grid = U(rho[:, None], v)
    far = np.inf
    if np.isfinite(limit):
        far = decayed("V", rho, grid.min(axis=1), limit / unit, 0.0, np.inf)[1]
        grid = grid[rho <= far]
        rho = rho[rho <= far]
    with np.errstate(over="ignore"):
        w = grid + (a**2 / np.cos(v / 2) ** 2 + b**2 / np.sin(v / 2) ** 2) / rho[:, None] ** 2
    lowest = w.min(axis=1) + 1 / rho**2
    place = int(np.argmin(lowest))
    if not np.isfinite(lowest[place]):
        raise ValueError("the potential is finite nowhere")
    if place == 0 and lowest[0] < 0:
        raise NoGroundState("V falls as -1/rho^2 or faster at phi = 0: the energy has no lower bound")
    check_bottom("V", place, rho.size, far)
    ends, uniform = _ends(U, rho, place)
    around = rho[:, None] / 2 * np.gradient(v)
    cell = np.gradient(rho)[:, None] * around

    def states(top):
        """Cells of phase space: int int (top - w) dalpha dbeta/(4 pi)."""
        return float((np.maximum(top - w, 0) * cell).sum() / (4 * np.pi))

    def channels(top):
        """Semiclassical number of channels below `top`, the largest over rho."""
        return float((np.sqrt(np.maximum(top - w, 0)) * around).sum(axis=1).max() / np.pi)

    fine = np.pi * (np.arange(200_000) + 0.5) / 200_000  # valleys far out are narrow in vartheta
    before, last = (float(U(q, fine).min()) for q in (rho[-1] / 10, rho[-1]))
    level_out = np.isinf(far) and last - before < 0.01 * (last - lowest[place])
    smooth = uniform and _even(U, rho[place], ends)
    top = last if level_out else np.inf
    return PlaneProblem(U, a, b, ends, rho, v, lowest, top, smooth=smooth, states=states, channels=channels, far=far)


def _ends(U: Callable, rho: np.ndarray, place: int) -> tuple[Well, bool]:
    """Return the well in vartheta at the rho of the bottom, and whether its strengths are those of other rho too. If
    not, no one exponent fits, and it has that of the free problem, 1 at a wall.
    """
    wells = [
        well("V", lambda angle, q=q: U(q, angle) * q * q / 4, 0.0, np.pi)
        for q in (0.8 * rho[place], rho[place], 1.3 * rho[place])
    ]
    one = wells[1]
    if any(abs(other.hi - one.hi) > 1e-9 or abs(other.lo - one.lo) > 1e-9 for other in wells) or one.lo != 0:
        raise ValueError(
            "model must have a potential on det phi > 0 or on all of GL(2,R), alpha > beta or alpha, beta > 0"
        )
    for angle in one.hi * np.array([0.2, 0.5, 0.8]):
        along = U(rho, angle)
        live = slice(*(np.flatnonzero(np.isfinite(along))[[0, -1]] + [0, 1]))
        check_poles("V along rho", lambda q, angle=angle: U(q, angle), rho[live], along[live])
    strengths = [sum(getattr(x, c) for x in wells) / 3 for c in ("c_lo", "c_hi")]
    uniform = all(
        max(getattr(x, c) for x in wells) - min(getattr(x, c) for x in wells) <= 1e-6 * (1 + abs(s))
        for c, s in zip(("c_lo", "c_hi"), strengths)
    )
    return one if uniform else one._replace(c_lo=0.0, c_hi=0.0), uniform


def _size(U: Callable, v: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Return the unit of rho: 1 where the lowest state lives there, in so many decades."""
    rho = np.geomspace(1e-24, 1e24, 193)
    with np.errstate(all="ignore"):
        around = a**2 / np.cos(v / 2) ** 2 + b**2 / np.sin(v / 2) ** 2
        lowest = (U(rho[:, None], v) + (1 + around) / rho[:, None] ** 2).min(axis=1)
    place = int(np.argmin(np.where(np.isnan(lowest), np.inf, lowest)))
    size = float(rho[place])
    return 1.0 if 1e-3 < size < 1e3 or place in (0, rho.size - 1) else size


def _even(U: Callable, rho: float, found: Well) -> bool:
    """Return whether V less its singular part is even in vartheta at both natural ends: no cone, as |beta| would
    make.
    """
    for natural, c, end, sign in ((found.natural_lo, found.c_lo, 0.0, 1), (found.natural_hi, found.c_hi, np.pi, -1)):
        if not natural:
            continue
        d = np.array([0.01, 0.02, 0.04])
        V = U(rho, end + sign * d) * rho**2 / 4 - c / d**2
        rise = abs(V[1] - V[0])
        next_rise = abs(V[2] - V[1])
        if rise > 1e-9 * np.abs(V).max() and next_rise < 3 * rise:  # 2 for a cone, 4 for a smooth top
            return False
    return True
