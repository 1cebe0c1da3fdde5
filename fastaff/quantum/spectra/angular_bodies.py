"""Levels of bodies with potentials of eta and gamma: those of both angles take the place of m and l.

With X(eta) of -(hbar^2/2 mu) X'' + V_eta X = c_eta X, K = 2 mu c_eta/hbar^2 stands where a^2 = (m - l)^2/4 does in the
equations of alpha or vartheta, and the same for gamma and b^2 = (m + l)^2/4. Levels grow with both K, so the search of
`class_search` finds them all.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...core.numbers import flag, positive, shown, whole
from ...runs.interruptible import interruptible
from ...runs.requirements import checked_system
from ...tori.separation import Separated, separate
from ..solvers.angle_levels import AngleLevels, angle_levels
from ..solvers.singular_ends import FallsToCentre, NoGroundState
from ..states.angle_states import AngularClass, AngularWaves
from ..states.level_table import LevelTable, class_levels, level_list
from ..states.symmetry import SymmetryClass, action_quantum
from .class_search import FIRST, Key, Ladder
from .separated_classes import OF_ANGLES, Centres

ANGLES = ("V_eta", "V_gamma")
RADII = ("alpha", "beta")
LADDER = Ladder(1, ((0, 0),))
"""Classes by the numbers of the levels of eta and gamma."""
SHARE = 0.01
"""Tolerance of the levels of angles, in units of that of the levels of the body."""


def has_angular_potentials(model: Any) -> bool:
    """Return whether a system is a body with potentials of eta or gamma."""
    if hasattr(model, "breathing"):
        return False
    system = checked_system(model, needs="H = T(p) + V(q)")
    return system.planar and not system.isotropic


def refuse_angle_numbers(n_eta: Any, n_gamma: Any) -> None:
    """Raise ValueError if the number of a level of an angle is given for a system without angular potentials."""
    for name, value in (("n_eta", n_eta), ("n_gamma", n_gamma)):
        if value is not None:
            raise ValueError(f"{name} must be None without angular potentials, got {shown(value)}")


def chosen_key(n_eta: Any, n_gamma: Any) -> Key | None:
    """Return the numbers of the levels of eta and gamma, None if neither is given."""
    if n_eta is None and n_gamma is None:
        return None
    if n_eta is None or n_gamma is None:
        raise ValueError(f"n_eta and n_gamma must be given together, got {shown(n_eta)} and {shown(n_gamma)}")
    return whole("n_eta", n_eta, 0), whole("n_gamma", n_gamma, 0)


@dataclass
class AngularClasses:
    """The classes of a body with angular potentials: levels of its angles, and tables of its classes, as far as they
    are computed.
    """

    separated: Separated
    hbar: float
    single_valued: bool
    tolerance: float
    limit: float = math.inf
    angles: list[AngleLevels] = field(default_factory=list)
    solved: dict[Key, LevelTable] = field(default_factory=dict)
    pairs: dict[Key, AngularClass] = field(default_factory=dict)

    def solve(self, todo: dict[Key, int]) -> None:
        """Compute the classes of some keys, of each the largest number of levels that one of them should have."""
        keys = list(todo)
        self._know_angles(max(key[0] for key in keys) + 1, max(key[1] for key in keys) + 1)
        K, error = (
            np.array([[getattr(side, name)[n] for side, n in zip(self.angles, key, strict=True)] for key in keys])
            for name in ("K", "error")
        )
        family = self.separated.family
        levels = max(todo.values())
        try:
            found = interruptible(
                OF_ANGLES[family], self.separated, Centres(K, error), levels, self.hbar, self.tolerance, self.limit
            )
        except FallsToCentre as problem:
            raise _singular(K.min(axis=0)) or problem from problem
        for key, one, k in zip(keys, found, K, strict=True):
            eta, gamma = (side.functions[n] for side, n in zip(self.angles, key, strict=True))
            self.pairs[key] = AngularClass(*key, eta, gamma, (float(k[0]), float(k[1])))
            self.solved[key] = self._table(key, one, k)

    def _know_angles(self, *counts: int) -> None:
        """Compute the levels of the angles up to so many of eta and of gamma, with a few more."""
        known = [side.K.size for side in self.angles] or [0, 0]
        if all(have >= count for have, count in zip(known, counts, strict=True)):
            return
        self.angles = [
            angle_levels(
                name,
                V,
                max(2 * count, have, 8),
                self.hbar,
                self.separated.mu,
                SHARE * self.tolerance,
                self.single_valued,
            )
            for name, V, count, have in zip(ANGLES, self.separated.angular, counts, known, strict=True)
        ]

    def _table(self, key: Key, found: Any, K: np.ndarray) -> LevelTable:
        size = found.E.size
        family = self.separated.family
        c = self.hbar**2 / (2 * self.separated.mu) * K
        method = (
            f"separated in {', '.join(family.coordinates)}, eta and gamma; angles in Fourier series, others in Jacobi "
            f"polynomials; f = 0 where V is infinite (Friedrichs){found.said}"
        )
        return class_levels(
            SymmetryClass(0, 0),
            found.E,
            found.error,
            np.concatenate([found.n, np.repeat(np.array(key)[:, None], size, axis=1)]),
            self.tolerance,
            names=(*family.coordinates, "eta", "gamma"),
            constants=np.concatenate([found.constants, np.repeat(c[:, None], size, axis=1)]),
            constant_names=(*family.eigenvalues, "c_eta", "c_gamma"),
            hbar=self.hbar,
            method=method,
            functions=max(found.size, *(side.size for side in self.angles)),
            waves=found.waves,
        )

    def allowed(self) -> list[LevelTable]:
        """Return the tables of classes whose functions of both angles have the same period."""
        return [
            table
            for key, table in self.solved.items()
            if self.pairs[key].eta.changes_sign == self.pairs[key].gamma.changes_sign
        ]

    def listed(self, top: float) -> LevelTable:
        """Return all levels, complete below `top`, with their wave functions."""
        merged = level_list(self.allowed(), complete_below=top)
        waves = AngularWaves(tuple((pair, self.solved[key].waves) for key, pair in self.pairs.items()))
        return replace(merged, waves=waves)


def _singular(K: np.ndarray) -> NoGroundState | None:
    """Return the error that names the angle whose level makes a centre singular, None if none is below 0."""
    for name, radius, k in zip(ANGLES, RADII, K, strict=True):
        if k < 0:
            return NoGroundState(
                f"{name} must have no level below 0, got 2 mu c/hbar^2 = {k:.4g}: the body falls to the centre {radius}"
                " = 0. Try n_eta and n_gamma of higher levels."
            )
    return None


def angular_classes(
    model: Any, hbar: Any, single_valued: Any, chart: Any, tolerance: Any, limit: float = math.inf
) -> AngularClasses:
    """Return the classes of a body with angular potentials, none of them computed."""
    separated = separate(model, chart)
    if separated.family not in OF_ANGLES:
        raise ValueError(f"chart must be alpha-beta or r-vartheta, got {separated.family.chart}")
    return AngularClasses(
        separated,
        action_quantum(hbar, separated.mu),
        flag("single_valued", single_valued),
        positive("tolerance", tolerance),
        limit,
    )


def lowest_levels(classes: AngularClasses, count: int, callback: Callable[[float], None] | None) -> LevelTable:
    """Return the lowest `count` levels of a body."""

    def end() -> float:
        E = np.concatenate([table.E + table.error for table in classes.allowed()])
        return float(np.sort(E)[count - 1]) if E.size >= count else math.inf

    top = search(classes, min(count, FIRST), end, callback)
    found = classes.listed(top).upto(count)
    return found


def class_of(classes: AngularClasses, key: Key, count: int) -> LevelTable:
    """Return the lowest `count` levels of one pair of levels of eta and gamma."""
    classes.solve({key: count})
    if not classes.allowed():
        raise ValueError(f"n_eta and n_gamma must be levels of one period, 2 pi or 4 pi, got {key[0]} and {key[1]}")
    return replace(classes.listed(-math.inf), complete_below=-math.inf)


def search(
    classes: AngularClasses, first: int, end: Callable[[], float], callback: Callable[[float], None] | None
) -> float:
    """Compute classes until no level below the energy end() is missing; return that energy."""
    todo = {(0, 0): first}
    share = 0.0
    top = math.inf
    while todo:
        classes.solve(todo)
        top = end()
        todo = LADDER.todo(classes.solved, top)
        if callback is not None:
            share = max(share, LADDER.share(classes.solved, top))
            callback(share)
    return top
