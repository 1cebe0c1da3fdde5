"""Quasiclassical levels of vibrations: tori whose actions are whole numbers of quanta beside their Maslov indices."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...core.classification import Classification
from ...core.interruption import partial_result_on_interrupt
from ...core.numbers import kind_of, numbers, real, shown
from ...core.status import Status
from ...frequencies.integer_lattice import determinant
from ...results.progress import tell
from ...runs.requirements import checked_system, current_system, phase_points
from ...tori.fit_torus import fit_torus
from ...tori.torus import TorusFit, tangents
from ..states.level_table import TORI, LevelTable
from ..states.modes import NormalModes, modes_of, swapped
from ..states.symmetry import action_quantum

PERIODS = 60.0
"""Periods of the slowest mode in the fit of a torus."""

LONGER = 2
"""Number of times that an undecided fit gets more time."""

STEPS = 8
"""Most of Newton's steps on the actions."""

CLOSE = 1e-5
"""Distance of an action from its quanta, in units of h, where the steps end: E is corrected to first order in the
remaining distance, so that its error is of second order.
"""


def is_vibration(model: Any) -> bool:
    """Return whether a system is no body and has a kinetic energy quadratic in the momenta."""
    if hasattr(model, "breathing"):  # a body too, not of the form T(p) + V(q)
        return False
    system = checked_system(model, needs="H = T(p) + V(q)")
    return not system.planar and system.quadratic


def bodies_alone(model: Any, given: dict[str, tuple[Any, Any]]) -> None:
    """Refuse arguments that only bodies have, unless they have their defaults: (value, default) by name."""
    for name, (value, default) in given.items():
        if value is not default and not (isinstance(value, tuple) and value == default):
            raise ValueError(f"{name} is for a Body alone, {kind_of(model)} takes none: got {name} = {shown(value)}")


LOOSE = 1e-3
"""Residual and error of prediction, in sizes of the orbit, of an undecided fit that still gives a level, whose error
they make.
"""

HALF = 0.5
"""Ratio of the residuals of a longer fit and a shorter one above which more time does not help."""


class Level(NamedTuple):
    """A level on a torus: quantum numbers n (modes,), E, its error, h nu (modes,), NaN where there is none; status, OK
    only where the torus is sure; names of its angles.
    """

    n: np.ndarray
    E: float
    error: float
    spacing: np.ndarray
    status: Status
    names: tuple[str, ...]


def level(model: Any, modes: NormalModes, n: np.ndarray | None, h: float, guess: np.ndarray | None) -> Level:
    """Return the level with quantum numbers n (modes,) of these modes, or in the basis of the torus near a phase point
    (2n,), by default the next ones there: Newton's method on the actions, whose gradient is S dz/dtheta.
    """
    z: Any = modes.start(h * (n + 0.5)) if n is not None and guess is None else guess
    size = np.sqrt((np.abs(modes.v) ** 2).sum(axis=1) * h)[:, None]
    time = PERIODS * 2 * np.pi / float(modes.omega.min())
    longer = LONGER
    before = None
    none = np.full(modes.omega.size, np.nan)
    failed = Level(np.zeros(none.size, np.int64) if n is None else n, np.nan, np.inf, none, Status.NOT_CONVERGED, ())
    for _ in range(STEPS):
        fit = fit_torus(model, z, time=time)
        while fit.classification is Classification.UNDECIDED and "suggested time" in fit.evidence and longer:
            longest = fit_torus(model, z, time=float(fit.evidence["suggested time"]))
            longer -= 1
            if (
                _usable(fit)
                and longest.classification is Classification.UNDECIDED
                and longest.residual > HALF * fit.residual
            ):
                longer = 0
                break
            time = float(fit.evidence["suggested time"])
            fit = longest
        if not _usable(fit):
            return failed
        if guess is None:
            K = modes.lines(fit.k, fit.coefficients)
            if abs(determinant(K)) != 1:
                return failed
            fit = fit.in_basis(K)
        n = np.maximum(np.rint(fit.J / h - fit.maslov / 4), 0) if n is None else n
        away = h * (n + fit.maslov / 4) - fit.J
        far = float(np.abs(away).max())
        if far <= CLOSE * h:
            E = fit.energy + float(fit.nu @ away)
            error = _error(fit, away, before)
            status = Status.OK if fit.classification is Classification.REGULAR else Status.NOT_CONVERGED
            return Level(n, E, error, h * fit.nu, status, fit.names)
        if before is not None and not far < before[1]:
            return failed
        before = fit.nu, far
        gradient = (swapped(tangents(fit, fit.theta0[:, None])[..., 0]) * -size).T
        z = z + size[:, 0] * np.linalg.lstsq(gradient, away, rcond=None)[0]
    return failed


def _usable(fit: TorusFit) -> bool:
    """Whether a fit gives actions: of a torus, or an undecided one whose series is close to the orbit.

    Series of three angles have more terms than a fit may take, and some of the lines left out are no rounding.
    """
    if fit.classification is Classification.UNDECIDED:
        return bool(fit.residual + fit.prediction_error < LOOSE)
    return fit.classification is Classification.REGULAR


def _error(fit: TorusFit, away: np.ndarray, before: tuple[np.ndarray, float] | None) -> float:
    """Return the error of E: that of the actions, the remainder of Newton's last step, and rounding."""
    change = fit.nu if before is None else (fit.nu - before[0]) * min(1.0, np.abs(away).max() / before[1])
    of_actions = np.abs(fit.nu) @ np.abs(fit.J) * (fit.residual + fit.prediction_error)
    return float(of_actions + np.abs(change) @ np.abs(away) + 64 * np.finfo(float).eps * abs(fit.energy))


def mode_levels(model: Any, n: Any, max_energy: Any, guess: Any, hbar: Any, way: str) -> LevelTable:
    """Return quasiclassical levels of a vibration, see `quasiclassical_levels`."""
    quantum = action_quantum(hbar)
    if guess is not None and (way != "normal" or max_energy is not None):
        raise ValueError("guess must be given without modes and max_energy: a torus near a point has its own angles")
    if (max_energy is None) == (n is None and guess is None):
        wrong = (
            "max_energy must be None with n or guess"
            if max_energy is not None
            else "n, guess or max_energy must be given"
        )
        raise ValueError(f"{wrong}, got {shown(max_energy)}")
    h = 2 * np.pi * quantum
    known = modes_of(model, way)
    points = [None] if guess is None else list(phase_points("guess", guess, current_system(model)).T)
    found: list[Level] = []
    table = functools.partial(_table, found, known, way, guess is not None, model, quantum)
    with partial_result_on_interrupt("quasiclassical_levels", table):
        if max_energy is not None:
            return _below(model, known, real("max_energy", max_energy), h, found, table)
        rows = [None] * len(points) if n is None else list(quanta(n, known.omega.size).T)
        count = max(len(rows), len(points))
        if {len(rows), len(points)} - {1, count}:
            raise ValueError(f"guess must be one phase point or {len(rows)}, as n has levels, got {len(points)}")
        for one, point in zip(rows * (count // len(rows)), points * (count // len(points)), strict=True):
            tell("quasiclassical_levels", len(found) / count, f"level {len(found) + 1} of {count}")
            found.append(level(model, known, one, h, point))
        return table()


def _below(
    model: Any, modes: NormalModes, top: float, h: float, found: list[Level], table: Callable[[], LevelTable]
) -> LevelTable:
    """Find all levels below an energy, from the ground state on, by ever more quanta."""
    size = modes.omega.size
    waiting = [(0,) * size]
    seen = set()
    while waiting:
        tell("quasiclassical_levels", 0.0, f"level {len(found) + 1}, {len(waiting)} more to try")
        found.append(level(model, modes, np.array(waiting.pop(0)), h, None))
        if top > found[-1].E:
            more = [tuple((found[-1].n + unit).tolist()) for unit in np.eye(size, dtype=int)]
            waiting += [n for n in more if n not in seen]
            seen.update(more)
    return table().below(top).ascending()


def quanta(n: Any, size: int) -> np.ndarray:
    """Return quantum numbers (modes, levels) of modes."""
    rows = numbers("n", n)
    if rows.ndim not in (1, 2) or len(rows) != size or not rows.size or (rows % 1).any() or not (rows >= 0).all():
        raise ValueError(f"n must be whole numbers >= 0 of shape ({size},) or ({size}, levels), got {shown(n)}")
    if not rows.max() < 1e6:
        raise ValueError(f"n must be below 1e6, got {rows.max():g}")
    return rows.reshape(size, -1).astype(np.int64)


def _table(found: list[Level], modes: NormalModes, way: str, near: bool, model: Any, hbar: float) -> LevelTable:
    """Return levels as a table."""
    size = modes.omega.size
    if near:
        names = next((one.names for one in found if one.names), tuple(f"theta {i + 1}" for i in range(size)))
    else:
        names = (
            current_system(model).row_names[:size] if way == "local" else tuple(f"mode {i + 1}" for i in range(size))
        )
    none = np.zeros(len(found), np.int64)
    return LevelTable(
        E=np.array([one.E for one in found]),
        error=np.array([one.error for one in found]),
        status=np.array([int(one.status) for one in found], np.int64),
        n=np.array([one.n for one in found], np.int64).reshape(len(found), size).T,
        names=names,
        m=none,
        l=none,
        constants=np.zeros((0, len(found))),
        constant_names=(),
        hbar=hbar,
        method=f"{TORI}, of {'the torus near a point' if near else f'{way} modes'}",
        spacing=np.array([one.spacing for one in found]).reshape(len(found), size).T,
    )
