"""Number of points of the plane in each cell of a rectangular table, and the sum of a value over them."""

from __future__ import annotations

import numpy as np

from ..compile.jit import jit


@jit(inline=True)
def cell_of(x, edges, half_low, rate):
    """Return k with edges[k] <= x < edges[k + 1], the last one closed; -1 beyond the edges and for NaN.

    edges: ascending; half_low, rate: half of the first edge, and cells per unit of x/2, for a guess.
    """
    last = edges.size - 2
    k = -1
    if x >= edges[0] and x <= edges[last + 1]:
        guess = (0.5 * x - half_low) * rate
        k = 0
        if guess >= last:
            k = last
        elif guess > 0:
            k = int(guess)
        # Rounding misses by one at most, except for edges as close as neighbouring floats.
        if x < edges[k] and x >= edges[max(k - 1, 0)]:
            k -= 1
        elif k < last and x >= edges[k + 1] and x < edges[min(k + 2, last + 1)]:
            k += 1
        if x < edges[k] or (k < last and x >= edges[k + 1]):
            k = min(np.searchsorted(edges, x, side="right") - 1, last)
    return k


@jit
def finite_range(x):
    """Return the least and the largest finite entry; inf and -inf where there is none."""
    low, high = np.inf, -np.inf
    for k in range(x.size):
        if np.isfinite(x[k]):
            low, high = min(low, x[k]), max(high, x[k])
    return low, high


@jit
def count_cells(x, y, values, x_edges, y_edges, counts, sums):
    """Add to counts (n1, n2) the points (x, y) of each cell and, where there are values, these to sums (n1, n2).

    x, y (points,); values (any,): that of point k is entry k modulo their number, (0,) without values; x_edges (n1 +
    1,), y_edges (n2 + 1,) ascending. A cell includes its lower edges, the last ones both. Points that are not finite or
    beyond the edges are in no cell; values that are not finite spoil their cell.
    """
    rate_x = (x_edges.size - 1) / (0.5 * x_edges[-1] - 0.5 * x_edges[0])
    rate_y = (y_edges.size - 1) / (0.5 * y_edges[-1] - 0.5 * y_edges[0])
    half_x, half_y = 0.5 * x_edges[0], 0.5 * y_edges[0]
    whose = -1
    for point in range(x.size):
        whose = 0 if whose + 1 >= values.size else whose + 1
        i = cell_of(x[point], x_edges, half_x, rate_x)
        if i >= 0:
            j = cell_of(y[point], y_edges, half_y, rate_y)
            if j >= 0:
                counts[i, j] += 1
                if values.size:
                    sums[i, j] += values[whose]
