"""Quasiclassical levels of vibrations: tori whose actions are whole numbers of quanta beside their Maslov indices."""

from __future__ import annotations

import functools
import heapq
import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

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

REMAINDER = 1e-8
"""Error of second order of E, in units of the spacing of levels, where the steps end too."""

COARSE = 0.1
"""Error of the actions of an undecided fit, in parts of their distance from the quanta, at which it still serves for
the next step.
"""

INHERITED = 4.0
"""Most time of a fit that begins at another torus, in units of that of PERIODS: what one longer fit takes."""

SURE = 0.1
"""Error of the energy of a level that two neighbours in a row predict, in parts of the spacing. A
margin, not a bound: a larger one costs fits of levels above the limit.
"""

UNSURE = 0.5
"""The same if one neighbour alone predicts it: half of the spacing that it has there."""

NEAR_NOTHING = 1e-3
"""Action in units of h in place of 0, where tori have fewer angles: E is corrected to first order in it."""


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
    torus: NearTorus | None = None


class NearTorus(NamedTuple):
    """A torus from which Newton's steps to its neighbours begin: its fit, the phase point and the time of the fit."""

    fit: TorusFit
    z: np.ndarray
    time: float


class Oscillation(Protocol):
    """What quanta belong to: a vibration, or a body at fixed spin and vorticity."""

    @property
    def model(self) -> Any:
        """Model whose orbits have the tori."""

    @property
    def modes(self) -> NormalModes:
        """Modes about the equilibrium."""

    @property
    def whole(self) -> Classification:
        """What the fit of a torus of all these angles is: resonant if a plane of the body does not turn."""

    def near(self, point: np.ndarray) -> np.ndarray:
        """Return a phase point of the system as one of the model."""

    def start(self, n: np.ndarray, h: float) -> np.ndarray:
        """Return a phase point (2d,) near the torus with quantum numbers n (modes,)."""

    def size(self, h: float) -> np.ndarray:
        """Return the size (2d,) of the rows of a quantum h."""

    def in_modes(self, fit: TorusFit) -> TorusFit | None:
        """Return a torus with the angles of the modes first, None if these are no basis."""

    def quanta(self, fit: TorusFit, h: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return h and the Maslov indices (modes,) of the quanta h (n + maslov/4) of actions, None if unknown."""

    def harmonic(self, h: float) -> tuple[float, np.ndarray]:
        """Return the energy of the equilibrium, and of one more quantum (modes,) of small oscillations about it."""

    def fixed(self) -> np.ndarray:
        """Return the actions that follow those of the modes and have given values."""


class Vibration(NamedTuple):
    """A system without conserved momenta, whose angles are those of its modes."""

    model: Any
    modes: NormalModes

    @property
    def whole(self) -> Classification:
        """Return that of a torus of as many angles as coordinates."""
        return Classification.REGULAR

    def near(self, point: np.ndarray) -> np.ndarray:
        """Return the point itself."""
        return point

    def start(self, n: np.ndarray, h: float) -> np.ndarray:
        """Return the point of small oscillations with these quanta."""
        return self.modes.start(h * (n + 0.5))

    def size(self, h: float) -> np.ndarray:
        """Return the amplitudes of one quantum in all modes."""
        return self.modes.size(h)

    def in_modes(self, fit: TorusFit) -> TorusFit | None:
        """Return the torus with the angles of the largest lines of the modes."""
        return turned_to(fit, self.modes.lines(fit.k, fit.coefficients))

    def quanta(self, fit: TorusFit, h: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return h and the Maslov indices of the torus."""
        return np.full(fit.dimension, h), fit.maslov

    def harmonic(self, h: float) -> tuple[float, np.ndarray]:
        """Return the energy of the minimum and h nu."""
        return energy_at(self.model, self.modes), h / (2 * np.pi) * self.modes.omega

    def fixed(self) -> np.ndarray:
        """Return none."""
        return np.zeros(0)


def energy_at(model: Any, modes: NormalModes) -> float:
    """Return the energy of the equilibrium of modes of a model."""
    return float(current_system(model).energies(modes.equilibrium[:, None])[0])


def turned_to(fit: TorusFit, K: np.ndarray) -> TorusFit | None:
    """Return the torus with the angles K theta, None if these are no basis."""
    return fit.in_basis(K) if K.shape == (fit.dimension,) * 2 and abs(determinant(K)) == 1 else None


def level(
    what: Oscillation,
    n: np.ndarray | None,
    h: float,
    guess: np.ndarray | None,
    near: NearTorus | None = None,
    indices: np.ndarray | None = None,
) -> Level:
    """Return the level with quantum numbers n (modes,) of these modes, or in the basis of the torus near a phase point
    (2d,), by default the next ones there: Newton's method on the actions, whose gradient is S dz/dtheta.

    near: a torus of these modes to begin with; indices (modes,): Maslov indices in place of those of the torus.
    """
    omega = what.modes.omega
    time = PERIODS * 2 * np.pi / float(omega.min())
    if near is not None:
        time = min(near.time, INHERITED * time)
    longer = LONGER
    none = np.full(omega.size, np.nan)
    failed = Level(np.zeros(none.size, np.int64) if n is None else n, np.nan, np.inf, none, Status.NOT_CONVERGED, ())
    before: tuple[np.ndarray, float] | None = None
    z: Any = guess
    if n is not None and guess is None:
        z = what.start(n if indices is None else np.maximum(n + indices / 4, NEAR_NOTHING) - 0.5, h)
    if near is not None and n is not None and (aims := _aims(what, near.fit, n, h, indices)) is not None:
        away = aims.lifted - near.fit.J
        before = near.fit.nu, float(np.abs(away).max())
        z = _stepped(what, near.fit, near.z, away, h)
    steps = 0
    coarse = math.inf
    while steps < STEPS:
        fit = fit_torus(what.model, z, time=time)
        turned = (what.in_modes(fit) if guess is None else fit) if _usable(fit, what.whole) else None
        if turned is not None and n is None:
            n = _nearest(what, turned, h)
        aims = None if turned is None or n is None else _aims(what, turned, n, h, indices)
        far = math.inf if turned is None or aims is None else float(np.abs(aims.lifted - turned.J).max())
        if fit.classification is Classification.UNDECIDED:
            misfit = fit.residual + fit.prediction_error
            serves = turned is not None and aims is not None and COARSE * far >= float(np.abs(turned.J).max()) * misfit
            if not serves and longer and "suggested time" in fit.evidence and not misfit > HALF * coarse:
                longer -= 1
                coarse = misfit if turned is not None else math.inf
                time = float(fit.evidence["suggested time"])
                continue
        if turned is None or aims is None or n is None:
            return failed
        away = aims.exact - turned.J
        error = _error(turned, away, before)
        spacing = aims.unit * turned.nu[: omega.size]
        small = error - _of_actions(turned) <= REMAINDER * float(np.abs(spacing).min())
        if far <= CLOSE * h or small:
            E = turned.energy + float(turned.nu @ away)
            status = Status.OK if fit.classification is what.whole else Status.NOT_CONVERGED
            return Level(n, E, error, spacing, status, turned.names[: omega.size], NearTorus(turned, z, time))
        if steps and before is not None and not far < before[1]:
            return failed
        before = turned.nu, far
        z = _stepped(what, turned, z, aims.lifted - turned.J, h)
        steps += 1
    return failed


def nearby_level(
    what: Oscillation, n: np.ndarray, h: float, beside: Level | None, indices: np.ndarray | None = None
) -> Level:
    """Return a level by steps from the torus of another one, if this finds none, from small oscillations."""
    if beside is not None and beside.torus is not None:
        found = level(what, n, h, None, beside.torus, indices)
        if not math.isnan(found.E):
            return found
    return level(what, n, h, None, None, indices)


class _Aims(NamedTuple):
    """Actions of a torus that belong to quanta: h of the modes (modes,), all actions (d,), and the same with actions of
    0 lifted, where tori have fewer angles.
    """

    unit: np.ndarray
    exact: np.ndarray
    lifted: np.ndarray


def _aims(what: Oscillation, fit: TorusFit, n: np.ndarray, h: float, indices: np.ndarray | None) -> _Aims | None:
    """Return the actions of quanta on tori near a fit, None if the torus has no rule."""
    found = what.quanta(fit, h)
    if found is None:
        return None
    unit = found[0]
    J = unit * (n + (found[1] if indices is None else indices) / 4)
    exact, lifted = (np.concatenate([row, what.fixed()]) for row in (J, np.maximum(J, NEAR_NOTHING * unit)))
    return _Aims(unit, exact, lifted)


def _nearest(what: Oscillation, fit: TorusFit, h: float) -> np.ndarray | None:
    """Return the quantum numbers next to the actions of a torus, None if the torus has no rule."""
    found = what.quanta(fit, h)
    if found is None:
        return None
    unit, maslov = found
    return np.asarray(np.maximum(np.rint(fit.J[: unit.size] / unit - maslov / 4), 0))


def _stepped(what: Oscillation, fit: TorusFit, z: np.ndarray, away: np.ndarray, h: float) -> np.ndarray:
    """Return a phase point whose actions differ to first order by `away` from those of z on a torus."""
    size = what.size(h)
    gradient = (swapped(tangents(fit, fit.theta0[:, None])[..., 0]) * -size[:, None]).T
    return np.asarray(z + size * np.linalg.lstsq(gradient, away, rcond=None)[0])


def _usable(fit: TorusFit, whole: Classification) -> bool:
    """Whether a fit gives actions: of a torus, or an undecided one whose series is close to the orbit.

    Series of three angles have more terms than a fit may take, and some of the lines left out are no rounding.
    """
    if fit.classification is Classification.UNDECIDED:
        return bool(fit.residual + fit.prediction_error < LOOSE)
    return fit.classification is whole


def _error(fit: TorusFit, away: np.ndarray, before: tuple[np.ndarray, float] | None) -> float:
    """Return the error of E: that of the actions, the remainder of Newton's last step, and rounding."""
    change = fit.nu if before is None else (fit.nu - before[0]) * min(1.0, np.abs(away).max() / before[1])
    return float(_of_actions(fit) + np.abs(change) @ np.abs(away) + 64 * np.finfo(float).eps * abs(fit.energy))


def _of_actions(fit: TorusFit) -> float:
    """Return the error of E by that of the actions."""
    return float(np.abs(fit.nu) @ np.abs(fit.J) * (fit.residual + fit.prediction_error))


def vibration(model: Any, way: str) -> Oscillation:
    """Return the motion of a vibration about its lowest minimum."""
    return Vibration(model, modes_of(model, way))


def mode_levels(
    model: Any,
    n: Any,
    max_energy: Any,
    guess: Any,
    hbar: Any,
    way: str,
    motion: Callable[[Any, str], Oscillation] = vibration,
) -> LevelTable:
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
    known = motion(model, way)
    size = known.modes.omega.size
    points = [None] if guess is None else list(phase_points("guess", guess, current_system(model)).T)
    found: list[Level] = []
    table = functools.partial(_table, found, size, way, guess is not None, model, quantum)
    with partial_result_on_interrupt("quasiclassical_levels", table):
        if max_energy is not None:
            found += levels_below(known, real("max_energy", max_energy), h)
            return table()
        rows = [None] * len(points) if n is None else list(quanta(n, size).T)
        count = max(len(rows), len(points))
        if {len(rows), len(points)} - {1, count}:
            raise ValueError(f"guess must be one phase point or {len(rows)}, as n has levels, got {len(points)}")
        for one, point in zip(rows * (count // len(rows)), points * (count // len(points)), strict=True):
            tell("quasiclassical_levels", len(found) / count, f"level {len(found) + 1} of {count}")
            if point is None and one is not None:
                beside = next((done for done in reversed(found) if done.torus is not None), None)
                found.append(nearby_level(known, one, h, beside))
            else:
                found.append(level(known, one, h, None if point is None else known.near(point)))
        return table()


def levels_below(
    what: Oscillation, top: float, h: float, indices: np.ndarray | None = None, tell_of: str = ""
) -> list[Level]:
    """Find all levels below an energy, from the ground state on, each from the torus of a neighbour.

    Levels without a torus whose energy may be below, as their neighbours predict, are at the end of the list, with NaN.
    The search goes on beyond one, not beyond two in succession, nor where neighbours predict energies above.
    """
    size = what.modes.omega.size
    bottom, spacing = what.harmonic(h)
    first = bottom + float(spacing @ (np.full(size, 0.5) if indices is None else indices / 4))
    waiting = [(first, (0,) * size)]
    beside: dict[tuple[int, ...], tuple[Level | None, np.ndarray, bool]] = {(0,) * size: (None, spacing, False)}
    found: dict[tuple[int, ...], Level] = {}
    while waiting:
        expected, n = heapq.heappop(waiting)
        tell("quasiclassical_levels", 0.0, f"{tell_of}level {len(found) + 1}, {len(waiting)} more to try")
        near, spacing, doubtful = beside[n]
        one = nearby_level(what, np.array(n), h, near, indices)
        lost = math.isnan(one.E)
        if not (expected if lost else one.E) < top:
            continue
        found[n] = one
        if lost and doubtful:
            continue
        E, spacing = (expected, spacing) if lost else (one.E, one.spacing)
        for k, unit in enumerate(np.eye(size, dtype=int)):
            more, less = (tuple((np.array(n) + sign * unit).tolist()) for sign in (1, -1))
            bend = 0.0 if lost or less not in found else float(spacing[k] - found[less].spacing[k]) / 2
            rise = float(spacing[k]) + (0.0 if math.isnan(bend) else bend)
            unsure = float(spacing[k]) * (SURE if bend else UNSURE)
            if more not in beside and rise > 0 and E + rise - unsure < top:
                beside[more] = (None if lost else one, spacing, lost)
                heapq.heappush(waiting, (E + rise, more))
    return sorted(found.values(), key=lambda one: (math.isnan(one.E), one.E))


def quanta(n: Any, size: int) -> np.ndarray:
    """Return quantum numbers (modes, levels) of modes."""
    rows = numbers("n", n)
    if rows.ndim not in (1, 2) or len(rows) != size or not rows.size or (rows % 1).any() or not (rows >= 0).all():
        raise ValueError(f"n must be whole numbers >= 0 of shape ({size},) or ({size}, levels), got {shown(n)}")
    if not rows.max() < 1e6:
        raise ValueError(f"n must be below 1e6, got {rows.max():g}")
    return rows.reshape(size, -1).astype(np.int64)


def _table(found: list[Level], size: int, way: str, near: bool, model: Any, hbar: float) -> LevelTable:
    """Return levels as a table."""
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
