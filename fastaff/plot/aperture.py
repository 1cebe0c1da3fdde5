"""The dynamic aperture: the number of turns that particles survive, over the plane of their starts."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import numbers, whole
from ..core.status import Status
from ..runs.starts import ordered
from .picking import carry
from .style import SMALL, Artists, Palette, figure, symbol

FAR = 1.6
"""Initial conditions beyond so many times the largest amplitude of the aperture, all lost, lie outside of the frame."""

FILLED = 0.5
"""Share of the cells of a grid beyond which places are a grid: an inscribed ellipse has 0.79, four rays less than 0.5.
"""

DIRECTIONS = 181
"""Directions in which the aperture of a grid is measured."""

FINE = 2000
"""Places that are tried in each of them."""

BINS = 15
"""Bins of the angle if the starts have too many angles of their own."""


@figure
@inserts_parameters
def plot_aperture(
    result: Any, z0: Any, *, ax: Any = None, x: int = 0, y: int = 1, bins: int | None = None, colorbar: bool = True
) -> Artists:
    """Plot the time that orbits survived over their initial conditions, and the outline of those that survived.

    Parameters
    ----------
    result : Result
        Result with ``t`` and ``status`` of shape (orbits,), for example of `integrate` or `frequency_map` for a map, or
        of `tunes`.
    z0 : array_like, shape (2n, orbits), EnergyGrid or EnergySample
        Initial conditions of the orbits: a grid of x and y, rays, or any others.
    {ax}
    x, y : int, default 0 and 1
        Rows of `z0` on the axes: r cos a and r sin a for a ray of amplitudes r at an angle a.
    bins : int, optional
        Number of bins of the angles of others than a grid. Default: the angles themselves if they are few.
    {colorbar}

    Returns
    -------
    Artists
        ``points`` are the initial conditions. ``lines`` are the outline, a mark at the least aperture, and, for others
        than a grid, marks of angles without a loss. ``labels`` has the least, mean and largest aperture; ``missing`` is
        0. A click picks the orbit. A note has the number of initial conditions far beyond the aperture, outside of the
        frame.

    Notes
    -----
    - A grid of x and y: the outline encloses the cells of surviving orbits that are connected with the centre. The
      aperture in a direction is the distance from the centre to this outline. Cells without an orbit count as lost.
    - Other initial conditions: at each angle, the aperture is the largest amplitude up to which all orbits survived.
      The outline joins the angles.
    - If no orbit is lost in a direction, the aperture is at least that large.

    Examples
    --------
    >>> starts = np.array([[0.1, 0.2, 2.0], [0.0, 0.0, 0.0]])
    >>> turns = fa.integrate(fa.models.HenonMap(), starts, time=100)
    >>> [text.get_text() for text in fa.plot.plot_aperture(turns, starts).labels]
    ['dynamic aperture: least 0.2, mean 0.2, largest 0.2']
    """
    z0 = numbers("z0", ordered("z0", getattr(z0, "z0", z0), lambda: [tuple(result.names)]))
    if z0.ndim != 2 or z0.shape[1:] != np.shape(result.t):
        raise ValueError(f"z0 must be the starts (2n, {np.size(result.t)}) of the result, got {z0.shape}")
    rows = [whole(name, row, 0, len(z0) - 1) for name, row in (("x", x), ("y", y))]
    across, up = z0[rows]
    angle = np.degrees(np.arctan2(up, across))
    radius = np.hypot(across, up)
    lost = np.asarray(result.status) != Status.OK
    from matplotlib.colors import LogNorm

    end = float(np.max(result.t, initial=1.0))
    shown = np.clip(result.t, 1e-3 * end, end)
    palette = Palette.of(ax)
    how = {"cmap": palette.colour_map().reversed(), "norm": LogNorm(float(shown.min(initial=0.1 * end)), end)}
    plane = _on_grid(across, up)
    points = ax.scatter(across, up, c=shown, s=14, linewidths=0, rasterized=True, **how)
    carry(points, across, up, np.arange(angle.size))
    if plane:
        outline = _outline(across, up, lost)
        turned, aperture, open_ = outline.apertures(angle[radius > 0])
        edge, name = outline.edges(), "edge of the surviving set"
    else:
        turned, aperture, open_ = _aperture(angle, radius, lost, bins)
        edge, name = _around(turned, aperture), "dynamic aperture"
    (curve,) = ax.plot(*edge, color=palette.accent, lw=1.6, label=name, **({} if plane else {"marker": "o", "ms": 3}))
    sure = ~open_ & np.isfinite(aperture)
    marked = [int(np.where(sure, aperture, np.inf).argmin())] if sure.any() else []
    at = np.array([aperture * np.cos(turned), aperture * np.sin(turned)])
    (least,) = ax.plot(
        *at[:, marked], ls="", color=palette.accent, marker="*", ms=11, mec=palette.ground, label="least aperture"
    )
    drawn = [curve, *([least] if marked else [])]
    if not plane:
        (beyond_,) = ax.plot(*at[:, open_], ls="", color=palette.accent, marker="^", ms=7, label="at least")
        drawn += [beyond_] if open_.any() else []
    known = aperture[np.isfinite(aperture)]
    said = "no aperture"
    if known.size:
        said = f"dynamic aperture: least {known.min():.3g}, mean {known.mean():.3g}, largest {known.max():.3g}"
    text = ax.set_title(said + (" (at least)" if open_.any() else ""), fontsize=9, loc="left")
    ax.legend(handles=drawn, loc="upper right")
    names = getattr(result, "names", ())
    xlabel, ylabel = (f"${symbol(names[k])}$" if k < len(names) else f"row {k}" for k in rows)
    ax.set(xlabel=f"initial {xlabel}", ylabel=f"initial {ylabel}")
    _near(ax, (across, up), FAR * np.max(known, initial=0.0))
    unit = "turns" if getattr(result, "scheme", None) is None or repr(result.scheme) == "ITERATION" else "time"
    bar = ax.figure.colorbar(points, ax=ax, label=f"{unit} survived") if colorbar else None
    return Artists(points, bar, (curve, least) if plane else (curve, least, beyond_), (text,), 0)


def _on_grid(across: np.ndarray, up: np.ndarray) -> bool:
    """Tell whether places are the cells of a grid of x and y, or most of them: others are outside of a domain."""
    columns, column = np.unique(across, return_inverse=True)
    rows, row = np.unique(up, return_inverse=True)
    cells = np.unique(row * columns.size + column).size
    return min(columns.size, rows.size) > 1 and cells == across.size > FILLED * columns.size * rows.size


def _near(ax: Any, rows: tuple[np.ndarray, ...], reach: float) -> None:
    """Set the frame to starts, by their rows of x and y, no farther than `reach`, if that is not 0."""
    far = np.max(np.abs(rows), axis=0) > reach
    if not reach or not far.any():
        return
    for axis, row in zip("xy", rows, strict=True):
        low, high = getattr(ax, f"get_{axis}lim")()
        low = max(low, -1.05 * reach, float(row.min()) - 0.05 * reach)
        ax.set(**{f"{axis}lim": (low, min(high, 1.05 * reach))})
    said = f"{np.count_nonzero(far)} of {far.size} initial conditions beyond the axes"
    style = {"ha": "right", "va": "bottom", "fontsize": SMALL, "color": Palette.of(ax).grey(0.35)}
    ax.text(1.0, 1.01, said, transform=ax.transAxes, **style)
    ax.set_title(ax.get_title(loc="left"), fontsize=9, loc="left", pad=17)


class Outline(NamedTuple):
    """Cells of a grid that belong to the surviving set: borders of columns and rows, and a mask (rows, columns)."""

    across: np.ndarray
    up: np.ndarray
    inside: np.ndarray

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the sides between cells inside and others as one curve with gaps; those on the centre's side of a grid
        that begins there are left out.
        """
        mask = np.pad(self.inside, 1)
        pieces = []
        for row, column in np.argwhere(mask[1:-1, 1:] != mask[1:-1, :-1]):
            pieces.append([(self.across[column], self.up[row]), (self.across[column], self.up[row + 1])])
        for row, column in np.argwhere(mask[1:, 1:-1] != mask[:-1, 1:-1]):
            pieces.append([(self.across[column], self.up[row]), (self.across[column + 1], self.up[row])])
        points = np.array(pieces, dtype=float).reshape(-1, 2, 2)
        begins = [(self.across[0], 0), (self.up[0], 1)]  # an axis, not a loss
        for border, axis in begins:
            points = points[~((points[:, :, axis] == border).all(axis=1) & (abs(border) <= self._centre(axis)))]
        gaps = np.full((len(points), 1, 2), np.nan)
        return tuple(np.concatenate([points, gaps], axis=1).reshape(-1, 2).T)  # type: ignore[return-value]

    def _centre(self, axis: int) -> float:
        """Return the width of the first column or row: a grid whose border is as near to 0 begins at the centre."""
        borders = (self.across, self.up)[axis]
        return float(borders[1] - borders[0])

    def apertures(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return directions in radians within a range of angles in degrees, the distance to the outline in each, and a
        mask of those that leave the grid before.
        """
        turned = np.radians(np.linspace(angles.min(), angles.max(), DIRECTIONS))
        corners = np.hypot(np.abs(self.across).max(), np.abs(self.up).max())
        away = np.linspace(0.0, corners, FINE)
        column = np.searchsorted(self.across, away * np.cos(turned)[:, None], side="right") - 1
        row = np.searchsorted(self.up, away * np.sin(turned)[:, None], side="right") - 1
        within = (column >= 0) & (column < self.inside.shape[1]) & (row >= 0) & (row < self.inside.shape[0])
        kept = within & self.inside[np.clip(row, 0, len(self.inside) - 1), np.clip(column, 0, len(self.inside[0]) - 1)]
        first = np.where(kept.all(axis=1), FINE - 1, (~kept).argmax(axis=1))
        return turned, away[first], ~np.take_along_axis(within, first[:, None], axis=1)[:, 0]


def _outline(across: np.ndarray, up: np.ndarray, lost: np.ndarray) -> Outline:
    """Return the surviving cells of a grid, by its places and a mask of lost orbits, that are connected with the one
    nearest the centre.
    """
    from scipy.ndimage import label

    columns, column = np.unique(across, return_inverse=True)
    rows, row = np.unique(up, return_inverse=True)
    kept = np.zeros((rows.size, columns.size), bool)
    kept[row, column] = ~lost
    pieces, _ = label(kept)
    nearest = int(np.hypot(across, up).argmin())
    own = pieces[row[nearest], column[nearest]]
    return Outline(_borders(columns), _borders(rows), (pieces == own) & (own > 0))


def _borders(places: np.ndarray) -> np.ndarray:
    """Return the borders of the cells around places in order; a grid that begins at the centre, or next to it, has a
    border there.
    """
    middles = 0.5 * (places[1:] + places[:-1])
    first, last = 1.5 * places[0] - 0.5 * places[1], 1.5 * places[-1] - 0.5 * places[-2]
    if places[0] >= 0:
        first = min(first, -1e-9 * places[-1])
    return np.concatenate([[first], middles, [last]])


def _around(turned: np.ndarray, aperture: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the outline of apertures in directions in ascending order; it is closed if these go around the centre."""
    if turned.size > 2 and turned[0] + 2 * np.pi - turned[-1] < 1.5 * np.diff(turned).max():
        turned, aperture = np.append(turned, turned[0]), np.append(aperture, aperture[0])
    return aperture * np.cos(turned), aperture * np.sin(turned)


def _aperture(
    angle: np.ndarray, radius: np.ndarray, lost: np.ndarray, bins: int | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return angles in radians, the largest amplitude at each below the smallest lost one, and a mask of angles without
    loss.
    """
    own = np.unique(np.round(angle[radius > 0], 6))
    if bins is None and own.size <= max(BINS, angle.size // 4):
        middles = own
        number = np.searchsorted(own, np.round(angle, 6) - 1e-9).clip(0, max(own.size - 1, 0))
    else:
        count = BINS if bins is None else whole("bins", bins, 1)
        edges = np.linspace(angle.min(), angle.max(), count + 1)
        middles = (edges[1:] + edges[:-1]) / 2
        number = np.clip(np.digitize(angle, edges) - 1, 0, count - 1)
    found = np.full(middles.size, np.nan)
    least = np.zeros(middles.size, bool)
    for k in range(middles.size):
        mine = (number == k) | (radius == 0)
        first = np.min(radius[mine & lost], initial=np.inf)
        inside = radius[mine & ~lost & (radius < first * (1 - 1e-9))]
        found[k] = inside.max() if inside.size else 0.0 if np.isfinite(first) else np.nan
        least[k] = not np.isfinite(first) and bool(inside.size)
    return np.radians(middles), found, least
