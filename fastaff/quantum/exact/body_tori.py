"""Quasiclassical levels of bodies that do not separate: tori of the body at fixed spin and vorticity."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from ...core.classification import Classification
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
from .mode_tori import Level, Oscillation, energy_at, level, levels_below, nearby_level, turned_to, vibration

GRID = 32
"""Points of each angle of a torus where the lines of its modes are sought: they are of low order."""

LIBRATIONS = 2, 2
"""Maslov indices of the modes: librations between two turning points, at the equilibrium and all along its tori."""

CENTRED = 1e-6
"""Part of the size of the body below which a plane of the equilibrium has no extent."""

ODD = 1e-8
"""Part of the power of a coordinate that terms of the other parity may have: errors of the series."""


def is_coupled(model: Any) -> bool:
    """Return whether a model is a doubly isotropic body that separates in no chart."""
    system = current_system(model)
    return system.isotropic and not any(hasattr(system.model.potential, family.member) for family in FAMILIES)


class TurningBody(NamedTuple):
    """A body at its angular momenta, in its planes.

    The series of a plane converge where those of its radius do not: next to the centrifugal barrier the radius is the
    root of a quickly varying function. Tori have the angles of the modes and the mean ones of the planes that turn. A
    plane without angular momentum is a line.
    """

    reduced: ReducedBody
    modes: NormalModes

    @property
    def model(self) -> Body:
        """The body in its planes."""
        return Body(self.reduced.potential, self.reduced.mu)

    @property
    def turning(self) -> dict[str, float]:
        """Angular momenta of the planes that turn, by the names of their angles."""
        return {name: p for name, p in (("eta", self.reduced.p_eta), ("gamma", self.reduced.p_gamma)) if p != 0.0}

    @property
    def whole(self) -> Classification:
        """A torus of four angles is one of all dimensions."""
        return Classification.REGULAR if len(self.turning) == 2 else Classification.RESONANT

    def near(self, point: np.ndarray) -> np.ndarray:
        """Return a phase point of alpha and beta as one of the body."""
        return self.reduced.to_planes(point)

    def start(self, n: np.ndarray, h: float) -> np.ndarray:
        """Return the equilibrium with momenta: the actions of these are those of a harmonic plane, for any size."""
        return self.reduced.to_planes(self.modes.kicked(h * (n + 0.5)))

    def size(self, h: float) -> np.ndarray:
        """Return the sizes of alpha and beta for both axes of their planes."""
        return np.repeat(self.modes.size(h), 2)

    def in_modes(self, fit: TorusFit) -> TorusFit | None:
        """Return the torus with the angles of the modes first: their largest lines at one angle of both planes."""
        if not self._has_angles(fit):
            return None
        amplitudes = self.modes.rows @ (self.reduced.from_planes(self._points(fit)) - self.modes.equilibrium[:, None])
        lines = np.abs(np.fft.fft2(amplitudes.reshape(2, GRID, GRID)))
        lines[:, 0, 0] = 0.0
        places = np.array(np.unravel_index(lines.reshape(2, -1).argmax(axis=1), (GRID, GRID))).T
        K = np.eye(fit.dimension, dtype=np.int64)
        K[:2, :2] = (places + GRID // 2) % GRID - GRID // 2
        return turned_to(fit, K)

    def quanta(self, fit: TorusFit, h: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return h and the Maslov indices of two librations; None where a line passes its centre."""
        if not self._has_angles(fit):
            return None
        z = self._points(fit)
        lines = [row for name, row in (("eta", 0), ("gamma", 2)) if name not in self.turning]
        if any((z[row : row + 2, 0] @ z[row : row + 2] <= 0).any() for row in lines):
            return None
        return np.full(2, h), np.array(LIBRATIONS)

    def harmonic(self, h: float) -> tuple[float, np.ndarray]:
        """Return the energy of the equilibrium and h nu."""
        return energy_at(self.reduced, self.modes), h / (2 * np.pi) * self.modes.omega

    def fixed(self) -> np.ndarray:
        """Return the actions of the angles of the planes."""
        return 2 * np.pi * np.array(list(self.turning.values()))

    def _has_angles(self, fit: TorusFit) -> bool:
        """Whether the angles of a torus are two librations and those of the planes that turn."""
        return fit.dimension == 2 + len(self.turning) and fit.names[2:] == tuple(self.turning)

    def _points(self, fit: TorusFit) -> np.ndarray:
        """Return points (8, GRID^2) of a torus where the angles of the planes are 0."""
        angles = np.indices((GRID, GRID)).reshape(2, -1) / GRID
        return fit.evaluate(np.vstack([angles, np.zeros((len(self.turning), GRID**2))]))


class PlaneMotion(NamedTuple):
    """A body reduced to alpha and beta, one of whose planes at least is a line through its centre.

    Where the orbit passes the centre, both ends of the line are the same radius: a cycle of the reduced torus is two of
    the radius, whose rule is J = (n + 1/2) h each, as in the limit of small angular momenta.
    """

    model: ReducedBody
    modes: NormalModes

    @property
    def whole(self) -> Classification:
        """Return that of a torus of two angles."""
        return Classification.REGULAR

    def near(self, point: np.ndarray) -> np.ndarray:
        """Return the point itself."""
        return point

    def start(self, n: np.ndarray, h: float) -> np.ndarray:
        """Return the equilibrium with the momenta of these quanta."""
        return self.modes.kicked(h * cycles(self.modes) * (n + 0.5))

    def size(self, h: float) -> np.ndarray:
        """Return the amplitudes of one quantum."""
        return self.modes.size(h)

    def in_modes(self, fit: TorusFit) -> TorusFit | None:
        """Return the torus with the angles of the largest lines of the modes."""
        return turned_to(fit, self.modes.lines(fit.k, fit.coefficients))

    def quanta(self, fit: TorusFit, h: float) -> tuple[np.ndarray, np.ndarray] | None:
        """Return h, or 2 h for two cycles in one, and the Maslov indices of the modes; None if a line's centre is
        passed in another manner.
        """
        unit = np.full(2, h)
        q = fit.evaluate(np.indices((GRID, GRID)).reshape(2, -1) / GRID)[:2]
        for row, p in enumerate((self.model.p_eta, self.model.p_gamma)):
            if p != 0.0 or q[row].min() > 0 or q[row].max() < 0:
                continue
            power = np.abs(fit.coefficients[:2]) ** 2 / (np.abs(fit.coefficients[:2]) ** 2).sum(axis=1)[:, None]
            odd = np.array([power[:, fit.k[:, i] % 2 == 1].sum(axis=1) for i in range(2)])  # angles, coordinates
            (turned,) = np.nonzero((odd[:, row] >= 1 - ODD) & (odd[:, 1 - row] <= ODD))
            if turned.size != 1:
                return None
            unit[turned[0]] = 2 * h
        return unit, fit.maslov

    def harmonic(self, h: float) -> tuple[float, np.ndarray]:
        """Return the energy of the equilibrium, and h nu of the cycles of the radii."""
        return energy_at(self.model, self.modes), h / (2 * np.pi) * cycles(self.modes) * self.modes.omega

    def fixed(self) -> np.ndarray:
        """Return none: the angular momenta are part of the model."""
        return np.zeros(0)


def centred(modes: NormalModes) -> np.ndarray:
    """Return a mask of the planes, alpha and beta, that have no extent at the equilibrium."""
    at = np.abs(modes.equilibrium[:2])
    return at <= CENTRED * np.maximum(at.max(), np.abs(modes.v[:2]).max(axis=1))


def cycles(modes: NormalModes) -> np.ndarray:
    """Return the number of cycles of the radius in one of each mode: 2 along a line through its centre."""
    return np.where(centred(modes)[np.abs(modes.v[:2]).argmax(axis=0)], 2.0, 1.0)


def upright(modes: NormalModes) -> NormalModes:
    """Return modes about the equilibrium with alpha, beta >= 0, which is the same motion of the body."""
    sign = np.tile(np.where(modes.equilibrium[:2] < 0, -1.0, 1.0), 2)
    return NormalModes(sign * modes.equilibrium, sign[:, None] * modes.v, modes.omega)


def oscillation(reduced: ReducedBody, way: str) -> Oscillation:
    """Return the motion of a body at its angular momenta about the lowest equilibrium, the modes in the order of the
    frequencies of the radii.
    """
    modes = upright(modes_of(reduced, way))
    if not centred(modes).any():
        return TurningBody(reduced, modes)
    if way == "normal":
        order = np.argsort(-cycles(modes) * modes.omega, kind="stable")
        modes = NormalModes(modes.equilibrium, modes.v[:, order], modes.omega[order])
    return PlaneMotion(reduced, modes)


def motion_of(model: Any, way: str) -> Oscillation:
    """Return the motion of a vibration; a reduced body that does not pass the centre of a plane moves as the body."""
    if isinstance(model, ReducedBody) and (model.p_eta != 0.0 or model.p_gamma != 0.0):
        modes = upright(modes_of(model, way))
        if not centred(modes).any():
            return TurningBody(model, modes)
    return vibration(model, way)


class BodyLevels:
    """Levels of a body that does not separate at given angular momenta; maslov: indices of both modes, None for those
    of librations.
    """

    def __init__(self, model: Body, hbar: Any, way: str, maslov: tuple[int, ...] | None) -> None:
        self.model = model
        self.way = way
        self.quantum = action_quantum(hbar, model.mu)
        self.h = 2 * np.pi * self.quantum
        self.indices = None if maslov is None else np.array(maslov)
        self.known: dict[tuple[int, int], Oscillation] = {}
        self.found: list[tuple[Level, int, int]] = []
        self.names: tuple[str, ...] = ("mode 1", "mode 2") if way == "normal" else ("alpha", "beta")
        self.of = f"{way} modes"

    def reduced(self, a: int, b: int) -> ReducedBody:
        """Return the body at m - l = a and m + l = b."""
        return ReducedBody(self.model.potential, self.model.mu, self.quantum * a / 2, self.quantum * b / 2)

    def motion(self, a: int, b: int) -> Oscillation:
        """Return the motion at m - l = a and m + l = b, which depends on their sizes alone."""
        if (abs(a), abs(b)) not in self.known:
            self.known[abs(a), abs(b)] = oscillation(self.reduced(abs(a), abs(b)), self.way)
        return self.known[abs(a), abs(b)]

    def numbered(self, n: Any, m: Any, l: Any, guess: Any, single_valued: bool) -> LevelTable:
        """Return the levels of quantum numbers, see `quasiclassical_levels`."""
        numbers, spins, vorticities = checked_numbers(n, m, l, single_valued)
        count = spins.size
        points: list[Any] = [None]
        if guess is not None:
            if self.way != "normal":
                raise ValueError("guess must be given without modes: a torus near a point has its own angles")
            points = list(phase_points("guess", guess, current_system(self.model)).T)
            if len(points) not in (1, count):
                raise ValueError(f"guess must be one phase point or {count}, as n has levels, got {len(points)}")
        near: dict[tuple[int, int], Level] = {}
        with partial_result_on_interrupt("quasiclassical_levels", self.table):
            for each, point in zip(range(count), points * (count // len(points)), strict=True):
                tell("quasiclassical_levels", each / count, f"level {each + 1} of {count}")
                m, l = int(spins[each]), int(vorticities[each])
                sides = abs(m - l), abs(m + l)
                motion = self.motion(m - l, m + l)
                if point is None:
                    before = near.get(sides)
                    one = nearby_level(motion, numbers[:, each], self.h, before, self.indices)
                    near[sides] = before if before is not None and np.isnan(one.E) else one
                else:
                    signed = oscillation(self.reduced(m - l, m + l), self.way)
                    z = signed.near(_reduced_point(self.reduced(m - l, m + l), point))
                    one = level(signed, numbers[:, each], self.h, z, None, self.indices)
                self.found.append((one, m, l))
            if guess is not None:
                self.names = next((one.names for one, _, _ in self.found if one.names), ("theta 1", "theta 2"))
                self.of = "the torus near a point"
            return self.table()

    def below(self, top: float, m: Any, l: Any, single_valued: bool) -> LevelTable:
        """Return all levels below an energy, of one class m, l or of all, and those without a torus."""
        with partial_result_on_interrupt("quasiclassical_levels", self.table):
            if m is not None:
                _, spins, vorticities = checked_numbers((0, 0), m, l, single_valued)
                for spin, vorticity in zip(spins.tolist(), vorticities.tolist(), strict=True):
                    self._class(spin, vorticity, top)
            else:
                for eta, gamma in self._classes(top, 2 if single_valued else 1):
                    first = self.found[:]
                    of_class = [one for one, spin, vorticity in first if (spin, vorticity) == _spins(eta, gamma)]
                    others = {(s * eta, t * gamma) for s in (-1, 1) for t in (-1, 1)} - {(eta, gamma)}
                    self.found += [(one, *_spins(*signed)) for signed in sorted(others) for one in of_class]
            lost = [row for row in self.found if np.isnan(row[0].E)]
            self.found = sorted((row for row in self.found if not np.isnan(row[0].E)), key=lambda row: row[0].E) + lost
            return self.table()

    def _classes(self, top: float, step: int) -> Iterator[tuple[int, int]]:
        """Search classes |m - l|, |m + l| of one parity in turn; yield those with levels."""
        for parity in range(0, 2, step):
            for eta in count(parity, 2):
                any_level = False
                for gamma in count(parity, 2):
                    if not self._class(*_spins(eta, gamma), top):
                        break
                    any_level = True
                    yield eta, gamma
                if not any_level:
                    break

    def _class(self, m: int, l: int, top: float) -> int:
        """Add the levels of one class below an energy; return their number."""
        found = levels_below(self.motion(m - l, m + l), top, self.h, self.indices, f"m = {m}, l = {l}: ")
        self.found += [(one, m, l) for one in found]
        return len(found)

    def table(self) -> LevelTable:
        """Return the levels so far."""
        done = len(self.found)
        levels = [one for one, _, _ in self.found]
        rule = "" if self.indices is None else f", Maslov indices {tuple(self.indices.tolist())}"
        return LevelTable(
            E=np.array([one.E for one in levels]),
            error=np.array([one.error for one in levels]),
            status=np.array([int(one.status) for one in levels], np.int64),
            n=np.array([one.n for one in levels], np.int64).reshape(done, 2).T,
            names=self.names,
            m=np.array([m for _, m, _ in self.found], np.int64),
            l=np.array([l for _, _, l in self.found], np.int64),
            constants=np.zeros((0, done)),
            constant_names=(),
            hbar=self.quantum,
            method=f"{TORI}, of {self.of}{rule}",
            spacing=np.array([one.spacing for one in levels]).reshape(done, 2).T,
        )


def _spins(eta: int, gamma: int) -> tuple[int, int]:
    """Return m and l of m - l = eta, m + l = gamma."""
    return (gamma + eta) // 2, (gamma - eta) // 2


def _reduced_point(reduced: ReducedBody, point: np.ndarray) -> np.ndarray:
    """Return alpha, beta and their momenta (4,) of a phase point (8,) of the body."""
    z = reduced.from_planes(point)
    if not (z[:2] > 0).all():
        raise ValueError(f"guess must have alpha and beta above 0, got {shown(point.tolist())}")
    return z
