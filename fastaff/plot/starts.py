"""Figures of the starts of orbits: dots, and values over the cells of a grid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..results.result import Result
from ..sections.energy_grid import EnergyGrid
from ..sections.energy_sample import EnergySample
from .colour_bars import colour_bar
from .picking import carry
from .scales import colouring, colours_of, orbit_colours
from .style import Artists, Palette, beyond, figure, symbol

STEEP = 0.8
"""Least ratio of allowed cells in the last row of a grid to those beside it if the grid cuts the region."""


def places(starts: EnergyGrid | EnergySample) -> np.ndarray:
    """Return the section coordinates (2, orbits) of the starts of orbits. Raises ValueError where they are not two."""
    if not isinstance(starts, (EnergyGrid, EnergySample)):
        raise TypeError(f"starts must be an EnergyGrid or EnergySample, got {shown(starts)}")
    if len(starts.names) != 2:
        raise ValueError(
            f"starts must lie over two coordinates, got {listed(starts.names)}. Use plt.scatter(starts['x'], "
            "starts['z']) to draw two of them."
        )
    if isinstance(starts, EnergyGrid):
        return np.array([grid.ravel()[starts.cell_index] for grid in np.meshgrid(*starts.axes, indexing="ij")])
    return starts.points


def cell_edges(axis: np.ndarray) -> np.ndarray:
    """Return the edges (n + 1,) of the cells about the n entries of an axis; one alone is 1 wide."""
    if axis.size == 1:
        return np.array([axis[0] - 0.5, axis[0] + 0.5])
    middle = (axis[1:] + axis[:-1]) / 2
    return np.concatenate([[2 * axis[0] - middle[0]], middle, [2 * axis[-1] - middle[-1]]])


def widths(grid: EnergyGrid) -> tuple[float, float]:
    """Return width and height of the cells of a grid."""
    first, second = (float(np.ptp(axis)) / max(axis.size - 1, 1) or 1.0 for axis in grid.axes)
    return first, second


def cut_sides(ax: Any, grid: EnergyGrid | EnergySample) -> tuple[Any, ...]:
    """Note the sides on which the energy allows more than a grid shows: nearly as many of its last cells are allowed as
    of those beside them. The value 0 and the ends of a whole turn of an angle are no such sides. Samples, grids of maps
    and those at rest, over angles, have none.
    """
    if not isinstance(grid, EnergyGrid) or math.isnan(grid.energy) or grid.names[-1].startswith("phi"):
        return ()
    words = []
    for k, (axis, name) in enumerate(zip(grid.axes, grid.names, strict=True)):
        whole = axis.size > 1 and abs((axis[-1] - axis[0]) / (2 * math.pi) - 1) < 1.5 / (axis.size - 1)
        allowed = np.moveaxis(~grid.inaccessible, k, 0).sum(axis=1)
        for end, beside, sign in () if whole or axis.size < 3 else ((0, 1, "<"), (-1, -2, ">")):
            at_zero = abs(axis[end]) <= 1.5 * abs(axis[end] - axis[beside])
            if not at_zero and allowed[end] > max(2, STEEP * allowed[beside]):
                words.append(f"${symbol(name)} {sign} {axis[end]:.3g}$")
    return (beyond(ax, f"allowed too: {', '.join(words)}"),) if words else ()


@figure
@inserts_parameters
def plot_diffusion_grid(
    grid: EnergyGrid,
    values: Any,
    *,
    ax: Any = None,
    norm: Any = None,
    vmin: float | None = None,
    vmax: float | None = None,
    label: str | None = None,
    colorbar: bool = True,
) -> Artists:
    """Plot values of the orbits of a grid as an image over its two coordinates.

    Parameters
    ----------
    grid : EnergyGrid
        Initial conditions of the orbits.
    values : array_like, shape (orbits,), Colouring or Result
        Values, for example the diffusion of a frequency map, or a `Colouring`. A result of the orbits of the grid is
        drawn with the values, scale and label of its own figure.
    {ax}
    {norm}
    {colour_range}
    {colour_label}
    {colorbar}

    Returns
    -------
    Artists
        ``missing`` is the number of orbits without a value, which are grey. Inaccessible cells stay empty. A click
        picks the orbit of a cell.

    Examples
    --------
    >>> grid = fa.energy_grid(fa.HenonHeiles(), energy=0.1, section="x=0", axes=([-0.2, 0.0, 0.6], [0.0, 0.1]))
    >>> fa.plot.plot_diffusion_grid(grid, grid.z0[1], label="y at the start").missing
    0
    """
    if not isinstance(grid, EnergyGrid):
        raise TypeError(f"grid must be an EnergyGrid, with values of its orbits behind it, got {shown(grid)}")
    if isinstance(values, Result):
        values = colouring(values)
    if isinstance(values, str) and values not in grid.names:
        raise TypeError(
            "values must be numbers (orbits,), a result or its colouring, got a text. Use colouring(result, "
            f"{shown(values)})."
        )
    at = places(grid)
    colours = orbit_colours(grid, values, grid.cell_index.size, norm, vmin, vmax, label)
    each = colours.values
    grey_cells(ax, grid, ~np.isfinite(each))
    image = np.ma.masked_invalid(grid.to_grid(each))
    cells = ax.pcolormesh(
        *map(cell_edges, grid.axes),
        image.T,
        cmap=colours_of(colours, Palette.of(ax)),
        norm=colours.norm,
        rasterized=True,
    )
    carry(cells, at[0], at[1], np.arange(each.size), cell=widths(grid))
    ax.set(xlabel=f"${symbol(grid.names[0])}$", ylabel=f"${symbol(grid.names[1])}$")
    bar = colour_bar(ax, cells, colours) if colorbar else None
    missing = int(np.count_nonzero(~np.isfinite(each)))
    cut = cut_sides(ax, grid)
    if missing:
        words = f"grey: {missing} orbit{'' if missing == 1 else 's'} without a value"
        cut = (*cut, ax.set_title(words, fontsize=9, loc="left"))
    return Artists(cells, bar, (), cut, missing)


def grey_cells(ax: Any, grid: EnergyGrid, chosen: np.ndarray) -> Any:
    """Draw the cells of the chosen orbits (orbits,) in grey."""
    from matplotlib.colors import ListedColormap

    if not chosen.any():
        return None
    image = np.ma.masked_invalid(grid.to_grid(np.where(chosen, 1.0, np.nan)))
    return ax.pcolormesh(
        *map(cell_edges, grid.axes), image.T, cmap=ListedColormap([Palette.of(ax).lost]), rasterized=True
    )


@figure
@inserts_parameters
def plot_starts(
    starts: EnergyGrid | EnergySample, *, ax: Any = None, values: Any = None, size: float = 4.0, **options: Any
) -> Artists:
    """Plot the initial conditions of the orbits of a grid or a sample.

    Parameters
    ----------
    starts : EnergyGrid or EnergySample
        Initial conditions of the orbits.
    {ax}
    values : array_like, shape (orbits,) or Colouring, optional
        Colours of the cells or dots.
    size : float, default 4
        Area of a dot in square points.
    **options : Any
        Options ``norm``, ``vmin``, ``vmax``, ``label`` and ``colorbar`` of `plot_diffusion_grid`.

    Returns
    -------
    Artists
        ``points`` are the dots, which pick their orbit at a click. ``missing`` is the number of orbits without a value.
        Inaccessible cells of a grid are pale.

    Examples
    --------
    >>> grid = fa.energy_grid(fa.HenonHeiles(), energy=0.1, section="x=0", axes=([-0.2, 0.0, 0.6], [0.0, 0.1]))
    >>> fa.plot.plot_starts(grid).points.get_offsets().shape
    (4, 2)
    """
    from matplotlib.colors import ListedColormap

    if values is not None:
        if isinstance(starts, EnergyGrid):
            return plot_diffusion_grid(starts, values, ax=ax, **options)
        return _sample(starts, values, ax=ax, **options)
    at = places(starts)
    palette = Palette.of(ax)
    if isinstance(starts, EnergyGrid) and starts.inaccessible.any():
        image = np.ma.masked_equal(starts.inaccessible, False)
        ax.pcolormesh(*map(cell_edges, starts.axes), image.T, cmap=ListedColormap([palette.shade]), rasterized=True)
    points = ax.scatter(*at, s=size, color=palette.main, linewidths=0, rasterized=True)
    carry(points, at[0], at[1], np.arange(at.shape[1]))
    ax.set(xlabel=f"${symbol(starts.names[0])}$", ylabel=f"${symbol(starts.names[1])}$")
    return Artists(points, None, (), cut_sides(ax, starts), 0)


def _sample(
    starts: EnergySample,
    values: Any,
    *,
    ax: Any,
    norm: Any = None,
    vmin: float | None = None,
    vmax: float | None = None,
    label: str | None = None,
    colorbar: bool = True,
) -> Artists:
    """Draw values of the orbits of a sample as dots."""
    at = places(starts)
    colours = orbit_colours(starts, values, at.shape[1], norm, vmin, vmax, label)
    each = colours.values
    fine = np.isfinite(each)
    area = float(np.clip(24000 / max(fine.size, 1), 2.0, 24.0))
    palette = Palette.of(ax)
    ax.scatter(*at[:, ~fine], s=area, color=palette.lost, linewidths=0, rasterized=True)
    how = {"cmap": colours_of(colours, palette), "norm": colours.norm}
    points = ax.scatter(*at[:, fine], c=each[fine], s=area, linewidths=0, rasterized=True, **how)
    carry(points, at[0, fine], at[1, fine], np.flatnonzero(fine))
    ax.set(xlabel=f"${symbol(starts.names[0])}$", ylabel=f"${symbol(starts.names[1])}$")
    bar = colour_bar(ax, points, colours) if colorbar else None
    return Artists(points, bar, (), (), int(np.count_nonzero(~fine)))
