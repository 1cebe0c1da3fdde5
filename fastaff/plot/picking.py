"""From a click on a figure to the orbit: our points and cells know their orbits.

figure.canvas.mpl_connect("pick_event", lambda event: print(picked(event)))
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

REACH = 5.0
"""Largest distance between the mouse and the point that it picks, in points (1/72 inch)."""


class Picked(NamedTuple):
    """Orbit and crossing under a click on a figure.

    Attributes
    ----------
    orbit : int
        Number of the orbit in its result.
    crossing : int, optional
        Number of its crossing, None if the artist has one mark for each orbit.
    x, y : float
        Coordinates on the axes.
    """

    orbit: int
    crossing: int | None
    x: float
    y: float


def picked(event: Any) -> Picked | None:
    """Return the orbit of a pick event of Matplotlib.

    Parameters
    ----------
    event : matplotlib.backend_bases.PickEvent
        Event of a figure.

    Returns
    -------
    Picked
        The orbit, None if the artist is not one of ``fastaff.plot``.

    Examples
    --------
    >>> fa.plot.picked(object()) is None
    True
    """
    return getattr(event, "picked", None)


def carry(
    artist: Any,
    x: Any,
    y: Any,
    orbit: Any = None,
    crossing: Any = None,
    *,
    orbits: int = 1,
    cell: tuple[float, float] | None = None,
) -> Any:
    """Let an artist name the orbit under a click; return the artist.

    x, y (marks,): places of its marks; orbit, crossing (marks,): their numbers; orbits: without these, mark k is of
    orbit k modulo orbits, the others of k // orbits crossings later; cell: width and height of the marks in data units,
    where these are cells. The nearest mark within `REACH` is picked, or the cell under the mouse.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)

    def found(_: Any, event: Any) -> tuple[bool, dict[str, Any]]:
        axes = artist.axes
        if axes is None or event.inaxes is not axes:
            return False, {}
        reach = REACH * axes.figure.dpi / 72
        if cell is None:
            corners = axes.transData.inverted().transform(
                [[event.x - reach, event.y - reach], [event.x + reach, event.y + reach]]
            )
            x0, y0 = corners.min(axis=0)
            x1, y1 = corners.max(axis=0)
        else:
            x0 = event.xdata - cell[0] / 2
            x1 = event.xdata + cell[0] / 2
            y0 = event.ydata - cell[1] / 2
            y1 = event.ydata + cell[1] / 2
        near = np.flatnonzero((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))
        if not near.size:
            return False, {}
        away = np.hypot(*(axes.transData.transform(np.column_stack([x[near], y[near]])) - [event.x, event.y]).T)
        k = int(near[away.argmin()])
        if cell is None and away.min() > reach:
            return False, {}
        if orbit is None:
            return True, {"picked": Picked(k % orbits, k // orbits, float(x[k]), float(y[k]))}
        number = None if crossing is None else int(crossing[k])
        return True, {"picked": Picked(int(orbit[k]), number, float(x[k]), float(y[k]))}

    artist.set_picker(found)
    return artist
