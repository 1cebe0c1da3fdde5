"""Energy levels with their errors and quantum numbers: one table for exact, quasiclassical and computed ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Protocol

import numpy as np

from ...core.numbers import real, shown, whole
from ...core.status import Status
from ...results.display import screen
from ...results.result import Drawable, Result, along
from .state import Shape, State
from .symmetry import SymmetryClass
from .vibration_state import LatticeWaves, VibrationState

ROUNDING = 64 * np.finfo(float).eps
"""Relative difference of energies that is never told apart."""

LOOSEST = 0.1
"""Relative error above which levels are none at any tolerance."""

VIBRATION = "uniform grid"
"""Method of levels on a uniform grid, of systems that are not bodies, by which their tables are recognised."""

TORI = "quasiclassical, actions of fitted tori"
"""Method of levels by fitted tori, of systems that are not bodies, by which their tables are recognised."""


class Waves(Protocol):
    """The wave functions of a class, by quantum numbers."""

    def shape(self, n: Sequence[int]) -> Shape:
        """Return the shape of the state with quantum numbers n of the coordinates."""


@dataclass(frozen=True)
class LevelTable(Result, axis="level"):
    """Energy levels of a body; arrays have the levels on their last axis.

    E (levels,); error (levels,): bound of the error of the method, rounding in closed forms; status (levels,): OK,
    NOT_CONVERGED where error is above the tolerance asked for, UNBOUND or NOT_CONVERGED with E NaN where no torus was
    found, NOT_CONVERGED with E where a torus is not sure. n (numbers, levels): quantum numbers of the coordinates
    `names`, such as ("alpha", "beta"), or one row, "level": the number in its class, from 0, where the body does not
    separate; m, l (levels,): spin and vorticity, 0 for systems that are not bodies. constants (constants, levels):
    eigenvalues of `constant_names`: E_alpha, E_beta or E, e_vartheta (with V_vartheta = 2 C/cos^2(vartheta/2) for
    Anharmonic; for the paper's 2 C tan^2(vartheta/2) it is 2 C less). hbar; method: one sentence, with boundary
    conditions; functions: size of the largest basis, 0 without one; complete_below: no level of the body below this
    energy is missing (-inf: not known). spacing (2, levels): of quasiclassical levels, h nu of the two coordinates,
    the energy of one more quantum to first order. waves: the wave functions, where the method has them.
    """

    E: Annotated[np.ndarray, along("level", unit="energy")]
    error: Annotated[np.ndarray, along("level", unit="energy")]
    status: Annotated[np.ndarray, along("level")]
    n: Annotated[np.ndarray, along("number", "level", labels="names")]
    names: tuple[str, ...]
    m: Annotated[np.ndarray, along("level")]
    l: Annotated[np.ndarray, along("level")]
    constants: Annotated[np.ndarray, along("constant", "level", labels="constant_names", plain=True)]
    constant_names: tuple[str, ...]
    hbar: float
    method: str
    functions: int = 0
    complete_below: float = -math.inf
    spacing: Annotated[np.ndarray | None, along("coordinate", "level", unit="energy")] = None
    waves: Waves | LatticeWaves | None = field(default=None, repr=False)

    def summary(self) -> str:
        """Return one line with the number of levels, their range of energies, and whether they have converged."""
        known = np.isfinite(self.E)
        E = self.E[known]
        failed = int(np.count_nonzero(self.status))
        span = f" from {E.min():.10g} to {E.max():.10g}" if E.size else ""
        less = f", {self.E.size - E.size} of them without an energy" if E.size < self.E.size else ""
        doubt = f", {failed} of them not OK{self._enough()}" if failed else ""
        return f"{self.E.size} levels{span}{less}{doubt}; {self.method}"

    def _enough(self) -> str:
        """Return the tolerance that all levels of `spectrum` would keep, as a call; calls for levels that no torus
        has; empty where neither is known.
        """
        if self.method.startswith(f"{TORI}, of") and not np.isfinite(self.E).all():
            return (
                ": no torus of these modes was found with their quanta, as in a resonance or beyond a separatrix; "
                "quasiclassical_levels(..., guess=z0) takes the torus near a point, modes='local' other modes, and "
                "spectrum(body, count=..., hbar=...) gives exact levels"
            )
        call: Any = getattr(self, "call", None)
        off = float((self.error / level_scale(self.E)).max()) if self.E.size else math.nan
        if call is None or call.function != "spectrum" or not 0.0 < off < LOOSEST:
            return ""
        return f" at tolerance={call.arguments['tolerance']:g}, all are at spectrum(..., tolerance={1.1 * off:.1e})"

    @property
    def converged(self) -> np.ndarray:
        """Whether the status is OK (levels,)."""
        return self.status == Status.OK

    @property
    def separated(self) -> bool:
        """Whether the quantum numbers are those of two coordinates that the body separates in."""
        return len(self.n) == 2

    def take(self, items: Any) -> LevelTable:
        """Return the table of some of the levels: a number, a slice, numbers or a mask; its completeness is not known.

        :Raises: TypeError or ValueError naming the values allowed.
        """
        return replace(super().take(items), complete_below=-math.inf)

    def ascending(self) -> LevelTable:
        """Return the levels that have an energy, in ascending order."""
        order = np.argsort(self.E, kind="stable")
        return replace(self.take(order[np.isfinite(self.E[order])]), complete_below=self.complete_below)

    def below(self, energy: float) -> LevelTable:
        """Return the levels below an energy; raises ValueError or TypeError for a wrong value."""
        top = real("energy", energy)
        return replace(self.take(np.flatnonzero(top > self.E)), complete_below=min(self.complete_below, top))

    def upto(self, count: int) -> LevelTable:
        """Return the lowest levels, ascending, all where there are no more; complete below the first one left out.

        :Raises: ValueError or TypeError for a count that is no whole number of at least 0.
        """
        levels = self.ascending()
        size = min(whole("count", count, 0), len(levels))
        top = min(levels.complete_below, float(levels.E[size])) if size < len(levels) else levels.complete_below
        return replace(levels.take(slice(size)), complete_below=top)

    def multiplets(self, tolerance: float | None = None) -> Multiplets:
        """Group the levels that have an energy, in ascending order, into multiplets.

        tolerance: relative; neighbours that differ by no more are one multiplet. By default they may differ by the sum
        of their errors and 64 roundings.

        :Raises: ValueError or TypeError for a tolerance that is not in [0, 1).
        """
        levels = self.ascending()
        E = levels.E
        error = levels.error
        if tolerance is None:
            close = error[1:] + error[:-1] + ROUNDING * np.abs(E[1:])
        else:
            if not 0 <= (gap := real("tolerance", tolerance)) < 1:
                raise ValueError(f"tolerance must be at least 0 and below 1, got {tolerance!r}")
            close = gap * np.abs(E[1:])
        starts = np.flatnonzero(np.append(np.ones(min(E.size, 1), bool), np.diff(E) > close))
        return Multiplets(levels, np.append(starts, E.size))

    def state(self, k: int) -> State | VibrationState:
        """Return the wave function of level k, counted from 0; raises TypeError or ValueError for a number of no level,
        and for a table without wave functions.
        """
        if whole("k", k, 0) >= len(self):
            raise ValueError(f"k must be below the number of levels {len(self)}, got {k}")
        if self.waves is None:
            raise ValueError(
                f"these levels have no wave functions: {self.method}. Those that `spectrum` finds have, of a body of "
                "GL(2,R) by its numbers m and l, of other systems by their number"
            )
        if isinstance(self.waves, LatticeWaves):
            return self.waves.state(int(self.n[0, k]), float(self.E[k]), self.hbar)
        n = self.n[:, k].tolist()
        numbers = {f"n_{name}": number for name, number in zip(self.names, n, strict=True)}
        constants = dict(zip(self.constant_names, self.constants[:, k].tolist(), strict=True))
        symmetry = SymmetryClass(int(self.m[k]), int(self.l[k]))
        return State(symmetry, self.waves.shape(n), numbers, float(self.E[k]), constants, self.hbar)


@dataclass(frozen=True)
class Multiplets(Drawable):
    """Levels gathered by energy: levels, ascending, and first (multiplets + 1,), where each multiplet begins."""

    levels: LevelTable
    first: np.ndarray

    def __repr__(self) -> str:
        return f"Multiplets: {len(self)} energies of {self.levels.summary()}"

    def __str__(self) -> str:
        return screen(self)

    def __len__(self) -> int:
        return self.first.size - 1

    def __bool__(self) -> bool:
        return True

    @property
    def E(self) -> np.ndarray:
        """The lowest energy of each multiplet (multiplets,)."""
        return self.levels.E[self.first[:-1]]

    @property
    def degeneracy(self) -> np.ndarray:
        """Number of levels of each multiplet (multiplets,)."""
        return np.diff(self.first)

    def members(self, k: int) -> LevelTable:
        """Return the levels of multiplet k, counted from 0; raises ValueError or TypeError for a wrong value."""
        k = whole("k", k, 0, len(self) - 1)
        return self.levels.take(slice(*self.first[[k, k + 1]].tolist()))

    def labels(self, k: int) -> list[tuple[int, int, int]]:
        """Return the different (n1 + n2, ``|m + l|``, ``|m - l|``) of multiplet k, on which its energy depends where
        both planes are alike.
        """
        some = self.members(k)
        rows = some.n.sum(axis=0), np.abs(some.m + some.l), np.abs(some.m - some.l)
        return sorted(set(zip(*(row.tolist() for row in rows), strict=True)))


def level_list(classes: Sequence[LevelTable], *, complete_below: float = -math.inf) -> LevelTable:
    """Merge tables of levels, such as those of symmetry classes, into one in ascending order.

    classes: tables of one body, one or more, such as `spectrum_table` gives; complete_below: kept in the result.

    :Returns: LevelTable, without wave functions.
    :Raises: TypeError for values that are no tables, ValueError for none of them, or of different hbar or quantum
        numbers.
    :Source: none.

    Examples
    --------
    >>> classes = fa.quantum.spectrum_table(fa.Body(fa.Harmonic()), m=[0, 1], l=[0, 1], count=2)
    >>> fa.quantum.level_list(classes).E.round(9)
    array([2., 3., 4., 5.])
    """
    if not isinstance(classes, (list, tuple)) or not all(isinstance(found, LevelTable) for found in classes):
        raise TypeError(f"classes must be a list of LevelTable, got {shown(classes)}")
    if not (isinstance(complete_below, float) and complete_below == -math.inf):
        complete_below = real("complete_below", complete_below)
    if not classes or len({(found.hbar, found.names) for found in classes}) > 1:
        got = sorted({f"hbar = {found.hbar:g}, {found.names}" for found in classes})
        raise ValueError(f"classes must be one or more tables of the same hbar and quantum numbers, got {got}")
    alike: dict[str, Any] = {"functions": max(found.functions for found in classes), "method": classes[0].method}
    if any(found.spacing is None for found in classes):
        alike["spacing"] = None
    plain = [replace(found, **alike, complete_below=float(complete_below), waves=None) for found in classes]
    return LevelTable.concat(plain).ascending()


def level_scale(E: np.ndarray) -> np.ndarray:
    """Return the scale of relative errors of levels: |E|, or the mean spacing where E is next to 0."""
    return np.maximum(np.abs(E), (E[-1] - E[0]) / max(E.size - 1, 1))


def class_levels(
    symmetry: SymmetryClass, E: np.ndarray, error: np.ndarray, n: np.ndarray, tolerance: float, **facts: Any
) -> LevelTable:
    """Return the table of computed levels of one class; those with an error above a relative tolerance have not
    converged.
    """
    status = np.where(error <= tolerance * level_scale(E), Status.OK, Status.NOT_CONVERGED)
    m, l = (np.full(E.shape, number) for number in symmetry)
    return LevelTable(E=E, error=error, status=status, n=n, m=m, l=l, **facts)
