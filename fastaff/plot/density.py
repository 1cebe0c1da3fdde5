"""Many points as an image: their number in each cell, and the mean of a value over them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.numbers import numbers
from ..kernels.counting import count_cells, finite_range

DENSE = 300_000
"""Points above which a section is drawn as an image."""
CELLS = (160, 1600)
"""Fewest and most cells of an image along an axis; between, one for each pixel."""


class Density(NamedTuple):
    """Points in the cells of a table: counts (n1, n2), mean (n1, n2) of their values (NaN in empty cells, None without
    values), edges (n1 + 1,), (n2 + 1,).
    """

    counts: np.ndarray
    mean: np.ndarray | None
    edges: tuple[np.ndarray, np.ndarray]


def count_points(x: Any, y: Any, *, edges: tuple[Any, Any], values: Any = None) -> Density:
    """Count points in the cells between edges, exactly, and average a value of each over them.

    :Parameters: x, y (points,); edges: ascending numbers along both axes, two at least; values (points,), or fewer,
        which are repeated: one for each orbit if the crossings of all orbits follow one another. A point on an edge is
        in the cell above it, on the last edge in the last cell; points beyond and points that are not finite are not
        counted.
    :Returns: Density, the counts those of `numpy.histogram2d`.
    :Raises: ValueError or TypeError for wrong input.
    :Cost: about 10 ns a point.

    Examples
    --------
    >>> found = fa.plot.count_points([0.5, 0.6, 1.5], [0.5, 0.5, 0.5], edges=([0.0, 1.0, 2.0], [0.0, 1.0]))
    >>> found.counts
    array([[2],
           [1]])
    """
    u, v = (np.ascontiguousarray(numbers(name, given)).ravel() for name, given in (("x", x), ("y", y)))
    if u.size != v.size:
        raise ValueError(f"y must have {u.size} entries, as x has, got {v.size}")
    along = [np.ascontiguousarray(numbers("edges", edge)) for edge in edges]
    for edge in along:
        if edge.ndim != 1 or edge.size < 2 or not (np.isfinite(edge).all() and (edge[1:] >= edge[:-1]).all()):
            raise ValueError("edges must be two lists of ascending finite numbers, two at least")
    c = np.zeros(0) if values is None else np.ascontiguousarray(numbers("values", values)).ravel()
    if values is not None and (u.size % c.size if c.size else u.size):
        raise ValueError(f"values must have {u.size} entries, one for each point, or a part of that, got {c.size}")
    shape = along[0].size - 1, along[1].size - 1
    counts, sums = np.zeros(shape, np.int64), np.zeros(shape if c.size else (0, 0))
    count_cells(u, v, c, *along, counts, sums)
    if values is None:
        return Density(counts, None, (along[0], along[1]))
    with np.errstate(all="ignore"):
        mean = sums / counts if c.size else np.full(shape, np.nan)
    return Density(counts, mean, (along[0], along[1]))


def even_edges(values: np.ndarray, cells: int) -> np.ndarray:
    """Return the edges (cells + 1,) of equal cells that hold all finite values, whatever their scale."""
    low, high = finite_range(np.ascontiguousarray(values, dtype=np.float64).ravel())
    if low > high:
        low, high = 0.0, 1.0
    if low == high:
        room = 0.5 * abs(low) or 0.5
        low, high = max(low - room, -np.finfo(float).max), min(high + room, np.finfo(float).max)
    part = np.linspace(0.0, 1.0, cells + 1)
    edges = low * (1.0 - part) + high * part
    edges[0], edges[-1] = low, high
    return np.maximum.accumulate(np.clip(edges, low, high))


def draw_density(ax: Any, x: np.ndarray, y: np.ndarray, values: np.ndarray | None, **colours: Any) -> Any:
    """Draw points (points,) as an image on axes: the mean of their values, or the logarithm of their number."""
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    box = ax.get_window_extent()
    cells = [int(np.clip(side, *CELLS)) for side in (box.width, box.height)]
    found = count_points(x, y, edges=(even_edges(x, cells[0]), even_edges(y, cells[1])), values=values)
    if found.mean is None:
        blues = LinearSegmentedColormap.from_list("fastaff_density", ["#b9cfe8", "#5a8fc8", "#00306f", "#000d20"])
        colours = {"cmap": blues, "norm": LogNorm(1, max(2, int(found.counts.max(initial=1))))}
        image = np.ma.masked_equal(found.counts, 0)
    else:
        image = np.ma.masked_array(found.mean, found.counts == 0)
    (x0, x1), (y0, y1) = (edge[[0, -1]] for edge in found.edges)
    drawn = ax.imshow(
        image.T,
        extent=(x0, x1, y0, y1),
        origin="lower",
        aspect="auto",
        interpolation="nearest",
        rasterized=True,
        **colours,
    )
    ax.autoscale_view()
    ax.margins(0.03)
    return drawn
