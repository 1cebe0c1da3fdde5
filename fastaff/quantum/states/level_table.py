"""Energy levels with their errors and quantum numbers: one table for exact, quasiclassical and computed ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Protocol

import numpy as np

from ...core.numbers import real, shown, whole
from ...core.status import Status, counted
from ...results.display import screen
from ...results.result import Drawable, Result, along
from .angle_states import AngularWaves
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
    """Energy levels of a body or a vibration; the levels are the last axis of arrays.

    Attributes
    ----------
    E : ndarray, shape (levels,)
        Energies.
    error : ndarray, shape (levels,)
        Bound of the error of the method, round-off for closed forms.
    status : ndarray of int, shape (levels,)
        `Status`: ``OK``; ``NOT_CONVERGED`` if the error exceeds the tolerance or a torus is not sure; ``UNBOUND`` or
        ``NOT_CONVERGED`` with E NaN if no torus was found.
    n : ndarray of int, shape (numbers, levels)
        Quantum numbers of `names`.
    names : tuple of str
        Coordinates such as ("alpha", "beta"), followed by "eta" and "gamma" for angular potentials, or ("level",) for
        the number in the symmetry class, from 0, of a nonseparable system.
    m, l : ndarray of int, shape (levels,)
        Spin and vorticity, 0 for angular potentials and for systems that are not bodies.
    constants : ndarray, shape (constants, levels)
        Eigenvalues of the separation constants. For `Anharmonic`, e_vartheta belongs to V_vartheta = 2
        C/cos^2(vartheta/2); for 2 C tan^2(vartheta/2) of the paper it is 2 C less.
    constant_names : tuple of str
        E_alpha, E_beta or E, e_vartheta; with c_eta, c_gamma for angular potentials.
    hbar : float
        Planck's constant over 2 pi.
    method : str
        Method and boundary conditions, in one sentence.
    functions : int
        Size of the largest basis, 0 without one.
    complete_below : float
        Energy below which no level of the body is missing, -inf if unknown.
    spacing : ndarray, shape (2, levels), optional
        For semiclassical levels, h nu of the two coordinates: the energy of one more quantum to first order.
    waves : object, optional
        Wave functions, if the method has them.
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
        """Return one line with the number of levels, their range of energies and their convergence.

        Returns
        -------
        str
            The line.
        """
        known = np.isfinite(self.E)
        E = self.E[known]
        failed = int(np.count_nonzero(self.status))
        span = f" from {E.min():.10g} to {E.max():.10g}" if E.size else ""
        span = f", E = {E[0]:.10g}" if E.size == 1 else span
        less = f"; {self.E.size - E.size} without an energy" if E.size < self.E.size else ""
        doubt = f"; {failed} not converged{self._enough()}" if failed else ""
        return f"{counted(self.E.size, 'level')}{span}{less}{doubt}"

    def _enough(self) -> str:
        """Return the tolerance that all levels of `spectrum` would keep, as a call; calls for levels that no torus
        has; empty where neither is known.
        """
        if self.method.startswith(f"{TORI}, of") and not np.isfinite(self.E).all():
            return (
                ": no torus of these modes has their quanta. Try quasiclassical_levels(..., guess=z0) or "
                "modes='local', or spectrum(...) for exact levels"
            )
        call: Any = getattr(self, "call", None)
        off = float((self.error / level_scale(self.E)).max()) if self.E.size else math.nan
        if call is None or call.function != "spectrum" or not 0.0 < off < LOOSEST:
            return ""
        return f" at tolerance={call.arguments['tolerance']:g}. Try spectrum(..., tolerance={1.1 * off:.1e})"

    @property
    def converged(self) -> np.ndarray:
        """Whether the status is ``OK``, shape (levels,)."""
        return self.status == Status.OK

    @property
    def separated(self) -> bool:
        """Whether the quantum numbers belong to coordinates in which the body separates."""
        return len(self.n) > 1

    def take(self, items: Any) -> LevelTable:
        """Return the table of some of the levels, whose completeness is unknown.

        Parameters
        ----------
        items : int, slice, array_like of int or array_like of bool
            Levels to keep.

        Returns
        -------
        LevelTable
            The table of these levels.

        Raises
        ------
        TypeError
            If the items have the wrong type.
        ValueError
            If a number or mask does not fit the table.
        """
        return replace(super().take(items), complete_below=-math.inf)

    def ascending(self) -> LevelTable:
        """Return the levels that have an energy, in ascending order.

        Returns
        -------
        LevelTable
            The sorted table.
        """
        order = np.argsort(self.E, kind="stable")
        return replace(self.take(order[np.isfinite(self.E[order])]), complete_below=self.complete_below)

    def below(self, energy: float) -> LevelTable:
        """Return the levels below an energy.

        Parameters
        ----------
        energy : float
            The energy.

        Returns
        -------
        LevelTable
            The levels, complete below the energy if the table is.

        Raises
        ------
        TypeError, ValueError
            If the energy is not a number.
        """
        top = real("energy", energy)
        return replace(self.take(np.flatnonzero(top > self.E)), complete_below=min(self.complete_below, top))

    def upto(self, count: int) -> LevelTable:
        """Return the lowest levels in ascending order, complete below the first one left out.

        Parameters
        ----------
        count : int
            Number of levels, at least 0. All levels are returned if there are fewer.

        Returns
        -------
        LevelTable
            The levels.

        Raises
        ------
        TypeError, ValueError
            If the count is not an integer of at least 0.
        """
        levels = self.ascending()
        size = min(whole("count", count, 0), len(levels))
        top = min(levels.complete_below, float(levels.E[size])) if size < len(levels) else levels.complete_below
        return replace(levels.take(slice(size)), complete_below=top)

    def multiplets(self, tolerance: float | None = None) -> Multiplets:
        """Group the levels that have an energy into multiplets, in ascending order.

        Parameters
        ----------
        tolerance : float, optional
            Largest relative difference of neighbours in a multiplet, in [0, 1). Default: the sum of their errors and 64
            units of round-off.

        Returns
        -------
        Multiplets
            The multiplets.

        Raises
        ------
        TypeError, ValueError
            If the tolerance is not in [0, 1).
        """
        levels = self.ascending()
        E = levels.E
        error = levels.error
        if tolerance is None:
            close = error[1:] + error[:-1] + ROUNDING * np.abs(E[1:])
        else:
            if not 0 <= (gap := real("tolerance", tolerance)) < 1:
                raise ValueError(f"tolerance must be at least 0 and below 1, got {shown(tolerance)}")
            close = gap * np.abs(E[1:])
        starts = np.flatnonzero(np.append(np.ones(min(E.size, 1), bool), np.diff(E) > close))
        return Multiplets(levels, np.append(starts, E.size))

    def state(self, k: int) -> State | VibrationState:
        """Return the wave function of a level.

        Parameters
        ----------
        k : int
            Number of the level, from 0.

        Returns
        -------
        State or VibrationState
            The stationary state.

        Raises
        ------
        TypeError, ValueError
            If no level has the number or the table has no wave functions.
        """
        if whole("k", k, 0) >= len(self):
            raise ValueError(f"k must be below the number of levels {len(self)}, got {k}")
        if self.waves is None:
            raise ValueError("these levels have no wave functions. Use the levels of fa.quantum.spectrum.")
        if isinstance(self.waves, LatticeWaves):
            return self.waves.state(int(self.n[0, k]), float(self.E[k]), self.hbar)
        n = self.n[:, k].tolist()
        numbers = {f"n_{name}": number for name, number in zip(self.names, n, strict=True)}
        constants = dict(zip(self.constant_names, self.constants[:, k].tolist(), strict=True))
        symmetry: Any = SymmetryClass(int(self.m[k]), int(self.l[k]))
        if isinstance(self.waves, AngularWaves):
            symmetry = self.waves.symmetry(n)
        return State(symmetry, self.waves.shape(n), numbers, float(self.E[k]), constants, self.hbar)


@dataclass(frozen=True)
class Multiplets(Drawable):
    """Levels grouped by energy.

    Attributes
    ----------
    levels : LevelTable
        Levels in ascending order.
    first : ndarray of int, shape (multiplets + 1,)
        Number of the first level of each multiplet, and the number of levels.
    """

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
        """Lowest energy of each multiplet, shape (multiplets,)."""
        return self.levels.E[self.first[:-1]]

    @property
    def degeneracy(self) -> np.ndarray:
        """Number of levels of each multiplet, shape (multiplets,)."""
        return np.diff(self.first)

    def members(self, k: int) -> LevelTable:
        """Return the levels of a multiplet.

        Parameters
        ----------
        k : int
            Number of the multiplet, from 0.

        Returns
        -------
        LevelTable
            The levels.

        Raises
        ------
        TypeError, ValueError
            If no multiplet has the number.
        """
        k = whole("k", k, 0, len(self) - 1)
        return self.levels.take(slice(*self.first[[k, k + 1]].tolist()))

    def labels(self, k: int) -> list[tuple[int, int, int]]:
        """Return the different (n1 + n2, ``|m + l|``, ``|m - l|``) of a multiplet.

        Its energy depends on these if both planes are alike.

        Parameters
        ----------
        k : int
            Number of the multiplet, from 0.

        Returns
        -------
        list of tuple of int
            The labels.
        """
        some = self.members(k)
        rows = some.n.sum(axis=0), np.abs(some.m + some.l), np.abs(some.m - some.l)
        return sorted(set(zip(*(row.tolist() for row in rows), strict=True)))


def level_list(classes: Sequence[LevelTable], *, complete_below: float = -math.inf) -> LevelTable:
    """Merge tables of levels, for example of symmetry classes, into one in ascending order.

    Parameters
    ----------
    classes : sequence of LevelTable
        One or more tables of one body, for example from `spectrum_table`.
    complete_below : float, default -inf
        Energy below which no level is missing. It is kept in the result.

    Returns
    -------
    LevelTable
        All levels, without wave functions.

    Raises
    ------
    TypeError
        If a value is not a table.
    ValueError
        If there is no table, or the tables differ in hbar or in the names of quantum numbers.

    References
    ----------
    Martens & Slawianowski, EQ4.3 (the symmetry classes).

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
