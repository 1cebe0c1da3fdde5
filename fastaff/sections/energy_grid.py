"""Grids of initial conditions on a section of an energy surface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import an_array, fits, listed, numbers, shown
from ..core.status import counted
from ..results.calls import coerces_arguments, records_call
from ..results.result import Result, along
from ..runs.requirements import current_system
from ..systems.formulas.section_text import section_in_words, section_of
from ..systems.models.contracts import Dynamics, Section
from .energy_shell import EnergyShell, NotReached, too_low
from .named_axes import (
    Axes,
    Others,
    are_named,
    by_name,
    checked_sign,
    checked_values,
    launching,
)
from .section_edge import ranges_to_draw
from .section_points import lift

CELLS = 101
"""Cells along each axis of a whole section."""

ARRAYS = 32
"""Arrays of the size of a grid that lifting it takes at a time."""


@dataclass(frozen=True)
class EnergyGrid(Result):
    """Initial conditions on the cells of a grid over two section coordinates, or over any rows by name.

    Attributes
    ----------
    z0 : ndarray, shape (2n, orbits)
        Phase points of the accessible cells. ``grid["p_beta"]`` is the row of that name.
    cell_index : ndarray of int, shape (orbits,)
        Flat index of the cell of each orbit in the grid.
    inaccessible : ndarray of bool, shape (n1, n2, ...)
        Cells that the energy surface does not reach.
    axes : tuple of ndarray
        Coordinates along the axes of the grid; the first axis runs along the rows of the grid.
    names : tuple of str
        Names of the axes.
    energy : float
        Energy of all orbits; NaN for a map.
    section : Section or None
        Section that all orbits lie on. `poincare_map` uses it by default.
    """

    z0: Annotated[np.ndarray, along("coordinate", "orbit")]
    cell_index: Annotated[np.ndarray, along("orbit")]
    inaccessible: Annotated[np.ndarray, along("first", "second")]
    axes: tuple[np.ndarray, ...]
    names: tuple[str, ...]
    energy: float
    section: Section | None = None

    def summary(self) -> str:
        """Return one line with the number of orbits, their energy and the cells.

        Returns
        -------
        str
            Summary.
        """
        energy = f" of energy {self.energy:.6g}" if np.isfinite(self.energy) else ""
        cells = " x ".join(map(str, self.inaccessible.shape))
        missing = int(np.count_nonzero(self.inaccessible))
        left = f", {missing} of them inaccessible" if missing else ""
        return f"{counted(len(self), 'orbit')}{energy} on {cells} cells of {', '.join(self.names)}{left}"

    def _row(self, name: str) -> np.ndarray | None:
        if name not in self.names:
            return None
        k = self.names.index(name)
        return self.axes[k][np.unravel_index(self.cell_index, self.inaccessible.shape)[k]]

    def to_grid(self, values: Any) -> np.ndarray:
        """Arrange values of the orbits as a grid.

        Parameters
        ----------
        values : array_like, shape (orbits,)
            One value for each orbit.

        Returns
        -------
        numpy.ma.MaskedArray, shape (n1, n2, ...)
            Values in their cells; inaccessible cells are masked.
        """
        given = an_array("values", values)
        if given.shape not in ((), self.cell_index.shape) or given.dtype.kind not in "biufc":
            raise ValueError(
                f"values must be numbers of shape {self.cell_index.shape}, one for each orbit, got {given.dtype} "
                f"{given.shape}"
            )
        array = np.ma.masked_all(self.inaccessible.size, dtype=given.dtype)
        array[self.cell_index] = values
        return array.reshape(self.inaccessible.shape)


@coerces_arguments(section=section_of, axes=by_name, fixed=by_name)
@records_call
@inserts_parameters
def energy_grid(
    model: Dynamics,
    *,
    energy: float | None = None,
    axes: Axes | str = "whole",
    section: Section | str | None = None,
    fixed: Mapping[str, float] | None = None,
    solve: str | None = None,
    sign: int = 1,
    at_rest: bool = False,
    p_eta: float = 0.0,
    p_gamma: float = 0.0,
) -> EnergyGrid:
    """Compute initial conditions of a given energy on a grid of coordinates.

    Parameters
    ----------
    {model}
    energy : float, optional
        Energy of all orbits. Required if the model conserves an energy.
    axes : tuple of two array_like, dict of array_like, or "whole", default "whole"
        Grid of two section coordinates, or of rows of z by name, ``{"x": xs, "z": zs}``. The section coordinates are
        (beta, p_beta) on AlphaTurning, AlphaEquals and AreaEquals, (alpha, p_alpha) on BetaTurning and BetaEquals, and
        (q_j, p_j) of the other coordinate on q_i = c. The default is 101 values of each over all bounded parts of the
        accessible region. Periodic coordinates are taken modulo their period.
    section : Section or str, optional
        Surface that all orbits lie on, or a short form such as ``"x=0"`` (crossed upwards), ``"x=0-"`` (downwards),
        ``"alpha-turning"`` or ``"beta=0.2"`` of a body.
    fixed : dict of float, optional
        Values of rows of z by name, for rows that are not axes. Default for each: 0.
    solve : str, optional
        Name of the row that is computed from the energy. Default for a section q_i = c: the momentum p_i.
    sign : {1, -1}, default 1
        Root that `solve` takes. For a momentum, 1 takes the larger root and -1 the smaller one, so that the velocity
        has this sign. For a coordinate, 1 takes the largest root and -1 the smallest.
    at_rest : bool, default False
        Set all momenta to 0. Initial conditions then lie where the potential equals the energy. The axes are the angles
        of their direction from the point `fixed`: ``phi`` for n = 2, ``theta``, ``phi`` for n = 3, and ``theta_1``,
        ..., ``phi`` for n > 3.
    p_eta, p_gamma : float, default 0
        Angular momenta of the two planes. Only for bodies on a section.

    Returns
    -------
    `EnergyGrid`
        Phase points of the accessible cells.

    Raises
    ------
    ValueError
        If no cell is reached, the region is unbounded and `axes` is not given, or a name is unknown.
    TypeError
        If the section has no grid.

    Notes
    -----
    - Turning sections: the missing radius is the inner turning point for direction 1, else the outer one, in the
      outermost well.
    - Other sections: the missing momentum has the sign of the direction; for 0 it is positive. If several roots have a
      velocity of this sign, the outermost one counts.
    - AreaEquals: one of its two branches.
    - Accuracy: roots are correct to the last digit or the one before. Wells narrower than 1/40 of a decade may be
      missed.
    - Cost in evaluations of the potential: 1 per cell. It is 64 per cell at rest or if a coordinate is solved for. On
      turning sections it is 64 per cell and 500 per value of the first coordinate.

    See the explanation page on sections and measure.

    References
    ----------
    H of EQ2.1 of Martens & Slawianowski in the chart EQ2.0b; Schwarzschild 1993, Astrophys. J. 409, 563 (start spaces
    of galactic orbits: at rest, and x-z with p_y from the energy).

    Examples
    --------
    >>> grid = fa.energy_grid(fa.HenonHeiles(), energy=0.1, section="x=0", axes=([-0.2, 0.0, 0.6], [0.0, 0.1]))
    >>> grid.z0.shape, int(grid.inaccessible.sum())
    ((4, 4), 2)
    """
    system = current_system(model)
    others = Others(fixed, solve, checked_sign(sign), at_rest)
    if section is None or are_named(axes) or others.given:
        return _grid_by_name(EnergyShell.of_rows(system, energy, section, p_eta, p_gamma), axes, others)
    if others.sign != 1:
        raise ValueError(f"sign goes with axes by name; here the section's direction has it, got {shown(sign)}")
    shell = EnergyShell.of_section(system, energy, section, p_eta, p_gamma)
    whole = isinstance(axes, str)
    if whole and axes != "whole":
        raise ValueError(f"axes must be two arrays, rows by name, or 'whole', got {shown(axes)}")
    first, second = _axes(_whole(shell) if whole else axes)
    fits("axes", first.size, second.size, ARRAYS)
    u, v = (array.ravel() for array in np.meshgrid(first, second, indexing="ij"))
    z, found, names = lift(shell, u, v)
    if not found.any():
        raise NotReached(
            shell.too_low()
            or f"axes must reach points of energy {shell.energy:g} on {section_in_words(section, system)}, got "
            f"{names[0]} in [{first.min():.5g}, {first.max():.5g}], {names[1]} in [{second.min():.5g}, "
            f"{second.max():.5g}]."
            f"{_no_counts(first, second)}"
        )
    return grid_of(
        np.ascontiguousarray(z[:, found]), np.flatnonzero(found), (first, second), names, shell.energy, section
    )


def grid_of(
    z0: np.ndarray,
    cell_index: np.ndarray,
    axes: tuple[np.ndarray, ...],
    names: tuple[str, ...],
    energy: float,
    section: Any = None,
) -> EnergyGrid:
    """Return the grid of some cells; the others count as those that the energy does not reach."""
    inaccessible = np.ones([axis.size for axis in axes], bool)
    inaccessible.ravel()[cell_index] = False
    return EnergyGrid(z0, cell_index, inaccessible, axes=axes, names=names, energy=energy, section=section)


def _grid_by_name(shell: EnergyShell, axes: Any, others: Others) -> EnergyGrid:
    """Return a grid over rows by name."""
    system, energy, section = shell[:3]
    if isinstance(axes, str):
        form = f"{{{shown(system.row_names[0])}: array, ...}}"
        why = "without a section" if section is None else "with fixed, solve or at_rest"
        raise TypeError(f"axes must be arrays by name, {form}, {why}, got {shown(axes)}")
    names, arrays = checked_values(axes, system.row_names)
    launch = launching(shell, names, others)
    fits("axes", *(array.size for array in arrays), ARRAYS * system.n)
    z, found = launch.lift(np.array([array.ravel() for array in np.meshgrid(*arrays, indexing="ij")]))
    if not found.any():
        ranges = listed(f"{name} in [{array.min():.6g}, {array.max():.6g}]" for name, array in zip(names, arrays))
        if not system.conserves:
            what = "map" if system.iterated else "system"
            raise NotReached(f"axes must reach the domain of the {what}, got {ranges}")
        low = None if system.isotropic else too_low(system, energy, 0.0, 0.0)
        raise NotReached(low or f"axes must reach points of energy {energy:g}, got {ranges}")
    return grid_of(np.ascontiguousarray(z[:, found]), np.flatnonzero(found), arrays, names, energy, section)


def _whole(shell: EnergyShell) -> tuple[np.ndarray, np.ndarray]:
    """Return axes over all bounded parts of a section, CELLS each."""
    try:
        boxes = np.array(ranges_to_draw(shell))
    except NotReached:
        raise
    except ValueError as problem:
        raise ValueError(
            f"{str(problem).partition(' Pass ')[0]} Pass axes, two arrays such as np.linspace(low, high, {CELLS})."
        ) from None
    first, second = (np.linspace(boxes[:, k, 0].min(), boxes[:, k, 1].max(), CELLS) for k in range(2))
    return first, second


def _axes(axes: Any) -> tuple[np.ndarray, np.ndarray]:
    try:
        first, second = (np.atleast_1d(numbers("axes", axis)).astype(np.float64) for axis in axes)
    except (TypeError, ValueError):
        raise TypeError(f"axes must be two arrays of numbers, got {shown(axes)}") from None
    for axis in (first, second):
        if axis.ndim != 1 or axis.size == 0 or not np.isfinite(axis).all():
            raise ValueError(
                f"axes must be two non-empty, finite, one-dimensional arrays, got shape {axis.shape} in {shown(axes)}"
            )
    return first, second


def _no_counts(first: np.ndarray, second: np.ndarray) -> str:
    """Return a hint for the error if axes look like numbers of cells."""
    both = [axis[0] for axis in (first, second) if axis.size == 1 and axis[0] > 1 and axis[0] == int(axis[0])]
    return f" Use coordinates, np.linspace(low, high, {both[0]:.0f})." if len(both) == 2 else ""
