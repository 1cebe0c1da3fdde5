"""Quasiclassical levels of bodies that do not separate: tori of the body at fixed spin and vorticity."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np

from ...core.interruption import partial_result_on_interrupt
from ...core.numbers import shown
from ...results.progress import tell
from ...runs.requirements import current_system, phase_points
from ...systems.models.body import Body
from ...systems.models.reduction import ReducedBody
from ...tori.families import FAMILIES
from ...tori.torus import TorusFit
from ..states.level_table import TORI, LevelTable
from ..states.modes import NormalModes, modes_of
from ..states.symmetry import action_quantum, checked_numbers
from .mode_tori import Level, Oscillation, level, turned_to

GRID = 64
"""Points of each angle of a torus where the lines of its modes are sought: they are of low order."""

CENTRED = 1e-6
"""Part of the size of the body below which a plane of the equilibrium has no extent."""

ODD = 1e-8
"""Part of the power of a coordinate that terms of the other parity may have: errors of the series."""


class TurningBody(NamedTuple):
    """A body both of whose planes turn, at their angular momenta.

    The series of its planes converge where those of the radii do not: next to the centrifugal barrier a radius is the
    root of a quickly varying function. Tori have four angles, those of the modes and the mean ones of both planes.
    """

    reduced: ReducedBody
    modes: NormalModes

    @property
    def model(self) -> Body:
        """The body in its planes."""
        return Body(self.reduced.potential, self.reduced.mu)

    def start(self, n: np.ndarray, h: float) -> np.ndarray:
        """Return the equilibrium with momenta: the actions of these are those of a harmonic plane, for any size."""
        return self.reduced.to_planes(self.modes.kicked(h * (n + 0.5)))

    def size(self, h: float) -> np.ndarray:
        """Return the sizes of alpha and beta for both axes of their planes."""
        return np.repeat(self.modes.size(h), 2)

    def in_modes(self, fit: TorusFit) -> TorusFit | None:
        """Return the torus with the angles of the modes first: their largest lines at one angle of both planes."""
        angles = np.indices((GRID, GRID)).reshape(2, -1) / GRID
        z = self.reduced.from_planes(fit.evaluate(np.vstack([angles, np.zeros_like(angles)])))
        amplitudes = self.modes.rows @ (z - self.modes.equilibrium[:, None])
        lines = np.abs(np.fft.fft2(amplitudes.reshape(2, GRID, GRID)))
        lines[:, 0, 0] = 0.0
        places = np.array(np.unravel_index(lines.reshape(2, -1).argmax(axis=1), (GRID, GRID))).T
        K = np.eye(4, dtype=np.int64)
        K[:2, :2] = (places + GRID // 2) % GRID - GRID // 2
        return turned_to(fit, K)

    def quanta(self, fit: TorusFit, h: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return h and the Maslov indices of the modes, two librations."""
        return np.full(2, h), fit.maslov[:2]

    def fixed(self) -> np.ndarray:
        """Return the actions of the angles of both planes."""
        return 2 * np.pi * np.array([self.reduced.p_eta, self.reduced.p_gamma])


class PlaneMotion(NamedTuple):
    """A body one of whose planes at least does not turn, reduced to alpha and beta.

    A plane without angular momentum is a line. Where the orbit passes its centre, both of its ends are the same radius:
    a cycle of the reduced torus is two of the radius, whose rule is J = (n + 1/2) h each, as in the limit of small
    angular momenta.
    """

    model: ReducedBody
    modes: NormalModes

    def start(self, n: np.ndarray, h: float) -> np.ndarray:
        """Return the equilibrium with the momenta of these quanta."""
        at = self.modes.equilibrium[:2]
        lines = np.abs(at) < CENTRED * np.abs(at).max(initial=1e-300)
        twice = np.where(lines[np.abs(self.modes.v[:2]).argmax(axis=0)], 2.0, 1.0)
        return self.modes.kicked(h * twice * (n + 0.5))

    def size(self, h: float) -> np.ndarray:
        """Return the amplitudes of one quantum."""
        return self.modes.size(h)

    def in_modes(self, fit: TorusFit) -> TorusFit | None:
        """Return the torus with the angles of the largest lines of the modes."""
        return turned_to(fit, self.modes.lines(fit.k, fit.coefficients))

    def quanta(self, fit: TorusFit, h: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return h or 2 h for the modes, and their Maslov indices; None where a line is passed in another manner."""
        unit = np.full(2, h)
        angles = np.indices((GRID, GRID)).reshape(2, -1) / GRID
        for row, p in enumerate((self.model.p_eta, self.model.p_gamma)):
            q = fit.evaluate(angles)[row]
            if p != 0.0 or q.min() > 0 or q.max() < 0:
                continue
            power = np.abs(fit.coefficients[row]) ** 2
            odd = [float(power[fit.k[:, i] % 2 == 0].sum()) <= ODD * float(power.sum()) for i in range(2)]
            other = fit.coefficients[1 - row]
            even = [float((np.abs(other[fit.k[:, i] % 2 == 1]) ** 2).sum()) <= ODD * _power(other) for i in range(2)]
            turned = np.flatnonzero(np.logical_and(odd, even))
            if turned.size != 1:
                return None
            unit[turned[0]] *= 2
        return unit, fit.maslov

    def fixed(self) -> np.ndarray:
        """Return none: the angular momenta are part of the model."""
        return np.zeros(0)


def is_coupled(model: Any) -> bool:
    """Return whether a model is a doubly isotropic body that separates in no chart."""
    system = current_system(model)
    return system.isotropic and not any(hasattr(system.model.potential, family.member) for family in FAMILIES)


def _power(coefficients: np.ndarray) -> float:
    return float((np.abs(coefficients) ** 2).sum())


def upright(modes: NormalModes) -> NormalModes:
    """Return modes about the equilibrium with alpha, beta >= 0, which is the same motion of the body."""
    sign = np.tile(np.where(modes.equilibrium[:2] < 0, -1.0, 1.0), 2)
    return NormalModes(sign * modes.equilibrium, sign[:, None] * modes.v, modes.omega)


def oscillation(reduced: ReducedBody, way: str) -> Oscillation:
    """Return the motion of a body at its angular momenta about the lowest equilibrium."""
    modes = upright(modes_of(reduced, way))
    if reduced.p_eta != 0.0 and reduced.p_gamma != 0.0:
        return TurningBody(reduced, modes)
    return PlaneMotion(reduced, modes)


def body_levels(model: Body, n: Any, m: Any, l: Any, guess: Any, hbar: Any, single_valued: Any, way: str) -> LevelTable:
    """Return quasiclassical levels of a body that does not separate, see `quasiclassical_levels`."""
    quantum = action_quantum(hbar, model.mu)
    if guess is not None and way != "normal":
        raise ValueError("guess must be given without modes: a torus near a point has its own angles")
    numbers, spins, vorticities = checked_numbers(n, m, l, single_valued)
    count = spins.size
    points: list[Any] = [None] if guess is None else list(phase_points("guess", guess, current_system(model)).T)
    if len(points) not in (1, count):
        raise ValueError(f"guess must be one phase point or {count}, as n has levels, got {len(points)}")
    h = 2 * np.pi * quantum
    known: dict[tuple[int, int], Oscillation] = {}
    found: list[Level] = []

    def table() -> LevelTable:
        done = len(found)
        names = next((one.names for one in found if one.names), ()) if guess is not None else ()
        return LevelTable(
            E=np.array([one.E for one in found]),
            error=np.array([one.error for one in found]),
            status=np.array([int(one.status) for one in found], np.int64),
            n=numbers[:, :done],
            names=names or ("mode 1", "mode 2") if way == "normal" else ("alpha", "beta"),
            m=spins[:done],
            l=vorticities[:done],
            constants=np.zeros((0, done)),
            constant_names=(),
            hbar=quantum,
            method=f"{TORI}, of {'the torus near a point' if guess is not None else f'{way} modes'}",
            spacing=np.array([one.spacing for one in found]).reshape(done, 2).T,
        )

    with partial_result_on_interrupt("quasiclassical_levels", table):
        for each, point in zip(range(count), points * (count // len(points)), strict=True):
            tell("quasiclassical_levels", each / count, f"level {each + 1} of {count}")
            a = int(spins[each]) - int(vorticities[each])
            b = int(spins[each]) + int(vorticities[each])
            reduced = ReducedBody(model.potential, model.mu, quantum * a / 2, quantum * b / 2)
            if (a, b) not in known:
                known[a, b] = oscillation(reduced, way)
            found.append(level(known[a, b], numbers[:, each], h, near(known[a, b], reduced, point)))
        return table()


def near(what: Oscillation, reduced: ReducedBody, point: np.ndarray | None) -> np.ndarray | None:
    """Return a phase point (8,) of a body with the angular momenta of a level, in the rows of its tori."""
    if point is None:
        return None
    z = reduced.from_planes(point)
    if not (z[:2] > 0).all():
        raise ValueError(f"guess must have alpha and beta above 0, got {shown(point.tolist())}")
    return reduced.to_planes(z) if isinstance(what, TurningBody) else z
