"""Figures of maps of one variable: bifurcation diagrams and cobwebs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..chaos.parameter_diagrams import BifurcationDiagram
from ..core.docstrings import inserts_parameters
from ..core.numbers import real, shown, whole
from ..engine.values import at_points
from ..runs.requirements import checked_system
from ..systems.models.contracts import FormulaMap
from .parameters import parameter_label
from .style import Artists, Palette, figure, symbol

CURVE = 400
"""Points of the curve of a map."""

MARGIN = 0.08
"""Share of the range of the iterates by which a cobweb's axes are wider."""


def images(x: np.ndarray) -> np.ndarray:
    """Return the next of iterates (iterates, orbits) of a map, NaN after the last."""
    return np.concatenate([x[1:], np.full_like(x[:1], np.nan)])


def draw_diagonal(ax: Any) -> Any:
    """Draw the diagonal of iterates and their images."""
    return ax.axline((0.0, 0.0), slope=1.0, color=Palette.of(ax).lost, lw=0.9, zorder=0.8)


def name_iterates(ax: Any, name: str) -> None:
    """Name the axes of iterates of one variable and their images."""
    ax.set(xlabel=f"${{{symbol(name)}}}_{{n}}$", ylabel=f"${{{symbol(name)}}}_{{n+1}}$")


@figure
@inserts_parameters
def plot_bifurcation_diagram(diagram: BifurcationDiagram, *, ax: Any = None, size: float = 0.3) -> Artists:
    """Plot the iterates of a map of one variable against its parameter.

    Parameters
    ----------
    diagram : BifurcationDiagram
        Result of `chaos.bifurcation_diagram`.
    {ax}
    size : float, default 0.3
        Size of a point, in points of print.

    Returns
    -------
    Artists
        ``points`` are the iterates. ``missing`` is the number of values of the parameter whose orbit has ended.

    References
    ----------
    May 1976, Nature 261, 459.

    Examples
    --------
    >>> logistic = fa.iterated_map("x1 = r*x*(1 - x)", r=4.0)
    >>> found = fa.chaos.bifurcation_diagram(logistic, "r", np.linspace(2.8, 4.0, 300), x0=0.3)
    >>> fa.plot.plot_bifurcation_diagram(found).missing
    0
    """
    values = np.broadcast_to(diagram.values, diagram.points.shape)
    there = np.isfinite(diagram.points)
    (points,) = ax.plot(
        values[there], diagram.points[there], ls="", marker=".", ms=2 * size, mew=0, color=Palette.of(ax).main
    )
    points.set_rasterized(True)
    ax.set_xlabel(parameter_label(diagram.parameter))
    ax.set_ylabel(symbol(diagram.names[0]))
    return Artists(points, colorbar=None, lines=(), labels=(), missing=int(np.count_nonzero(~there[-1])))


@figure
@inserts_parameters
def plot_cobweb(model: FormulaMap, x0: float, *, iterates: int = 50, ax: Any = None) -> Artists:
    """Plot an orbit of a map of one variable as steps between its curve and the diagonal.

    Parameters
    ----------
    model : map of one variable
        Result of `iterated_map`.
    x0 : float
        Initial condition.
    iterates : int, default 50
        Number of iterates.
    {ax}

    Returns
    -------
    Artists
        ``points`` is the line of the steps and ``lines`` are the curve of the map and the diagonal. ``missing`` is the
        number of iterates that are not finite or outside of the domain.

    References
    ----------
    May 1976, Nature 261, 459.

    Examples
    --------
    >>> fa.plot.plot_cobweb(fa.iterated_map("x1 = r*x*(1 - x)", r=3.7), 0.2, iterates=20).missing
    0
    """
    system = checked_system(model)
    if not (system.iterated and system.rows == 1):
        raise TypeError(f"model must be a map of one variable such as 'x1 = r*x*(1 - x)', got {shown(model, 60)}.")
    x = [real("x0", x0)]
    (period,) = model.periods()
    count = whole("iterates", iterates, 1)
    for _ in range(count):
        with np.errstate(all="ignore"):
            image = float(at_points(model, "iterate", x[-1])[0])
        image -= period * np.rint(image / period) if period > 0 and np.isfinite(image) else 0.0
        if not (np.isfinite(image) and model.margin(image) > 0):
            break
        x.append(image)
    room = MARGIN * (np.ptp(x) or abs(x[0]) or 1.0)
    at: np.ndarray = np.linspace(min(x) - room, max(x) + room, CURVE)
    with np.errstate(all="ignore"):
        above = np.array(np.broadcast_to(at_points(model, "iterate", at)[0], at.shape))
        inside = np.broadcast_to(model.margin(at), at.shape) > 0
    if period > 0:
        above -= period * np.rint(above / period)
        above[1:][np.abs(np.diff(above)) > period / 2] = np.nan
    palette = Palette.of(ax)
    (curve,) = ax.plot(at, np.where(inside & np.isfinite(above), above, np.nan), color=palette.main, lw=1.4)
    (diagonal,) = ax.plot(at, at, color=palette.lost, lw=0.9)
    steps = np.repeat(x, 2)
    (web,) = ax.plot(steps[:-1], np.concatenate([[x[0]], steps[2:]]), color=palette.main, lw=0.8)
    name = symbol(system.row_names[0])
    ax.set_xlabel(name)
    ax.set_ylabel(f"image of {name}")
    ax.set_xlim(at[0], at[-1])
    ax.set_ylim(at[0], at[-1])
    return Artists(web, colorbar=None, lines=(curve, diagonal), labels=(), missing=count + 1 - len(x))
