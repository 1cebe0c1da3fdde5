"""Figures of basins of attraction: labels over initial conditions, attractors, and a legend with shares."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..chaos.basins import ESCAPED, UNDECIDED, AttractorKind, Basins
from ..core.docstrings import inserts_parameters
from ..core.names import named
from ..runs.requirements import current_system
from .curves import PIECES, hermite
from .mathematics import number
from .starts import cell_edges
from .style import MIDDLE, ON_LIGHT, Artists, Palette, contrast, figure, luminance, symbol
from .winding import argument_of

COLOURS = (ON_LIGHT.main, "#e3c65b", ON_LIGHT.pale, ON_LIGHT.accent, ON_LIGHT.plum, "#a9c7a0", "#5c5c5c", "#d9a7b0")
"""Colours of basins in turn, on any ground because they cover it: neighbours differ by lightness too."""

GREY = "0.72"
"""Colour of undecided orbits."""

SAME = 1e-9
"""Relative difference of rates that are one."""

AWAY = "0.95"
"""Colour of orbits that escape."""

FAINT = 1.5
"""Contrast to the ground below which a dot has an edge: white and navy dots on white and black."""

EDGE = "0.55"
"""Colour of that edge, seen on any ground."""


@figure
@inserts_parameters
def plot_basins(
    basins: Basins, *, ax: Any = None, x: str | None = None, y: str | None = None, size: float | None = None
) -> Artists:
    """Plot the basins of attraction over the initial conditions, with the attractors.

    Parameters
    ----------
    basins : Basins
        Result of `basins`.
    {ax}
    x, y : str, optional
        Names of the rows on the axes. Default: the first two rows in which initial conditions differ. If they differ in
        one row, the second axis is the settling time.
    {dot_size}

    Returns
    -------
    Artists
        ``points`` are the cells of a grid, else dots; ``lines`` the attractors. ``missing`` is the number of undecided
        orbits, which are grey.

    Notes
    -----
    - Legend: names and shares of the attractors, of all orbits.
    - Attractors: circles are fixed points and periodic orbits, curves limit cycles, dots other sets.
    - If an angle is the phase of a drive, the same for all initial conditions, attractors are drawn at this phase only.

    References
    ----------
    Nusse & Yorke 1996, Science 271, 1376.

    Examples
    --------
    >>> well = fa.hamiltonian("x**4/4 - x**2/2", coordinates="x", friction=0.5)
    >>> grid = fa.energy_grid(well, axes={"x": np.linspace(-2, 2, 40), "p_x": np.linspace(-2, 2, 40)})
    >>> fa.plot.plot_basins(fa.basins(well, grid, time=200.0)).missing
    0
    """
    first, second = _rows(basins, x, y)
    labels = [*range(basins.kind.size), *([ESCAPED] if basins.escaped.any() else [])]
    labels += [UNDECIDED] if basins.undecided.any() else []
    colours = [_colour(label) for label in labels]
    code = np.searchsorted(np.sort(labels), basins.label)
    code = np.argsort(labels)[code]
    along = basins.z0[first]
    if second is None:
        up = np.where(np.isfinite(basins.settling_time), basins.settling_time, basins.time)
        points = _dots(ax, along, up, code, colours, size or 6.0)
        ax.set(xlabel=f"${symbol(basins.names[first])}$", ylabel="settling time")
        lines: list[Any] = []
    else:
        up = basins.z0[second]
        points = _cells(ax, along, up, code, colours)
        if points is None:
            points = _dots(ax, along, up, code, colours, size or float(np.clip(24000 / along.size, 2.0, 24.0)))
        limits = ax.get_xlim(), ax.get_ylim()
        phase = _phase(basins, first, second)
        lines = [_attractor(ax, basins, k, first, second, colours[k], phase) for k in range(basins.kind.size)]
        ax.set(xlim=limits[0], ylim=limits[1])
        ax.set(xlabel=f"${symbol(basins.names[first])}$", ylabel=f"${symbol(basins.names[second])}$")
    _legend(ax, basins, labels, colours, None if second is None else phase)
    return Artists(points, None, tuple(lines), (), int(basins.undecided.sum()))


def _rows(basins: Basins, x: str | None, y: str | None) -> tuple[int, int | None]:
    """Return the numbers of the rows on the axes, None for the settling time."""
    names = {name: k for k, name in enumerate(basins.names)}
    vary = [k for k, row in enumerate(basins.z0) if np.ptp(row) > 0] or [0]
    first = vary[0] if x is None else names[named("x", x, names)]
    rest = [k for k in vary if k != first]
    if y is not None:
        return first, names[named("y", y, names)]
    return first, rest[0] if rest else None


def _colour(label: int) -> Any:
    """Return the colour of a label."""
    if label < 0:
        return AWAY if label == ESCAPED else GREY
    if label < len(COLOURS):
        return COLOURS[label]
    import matplotlib

    return matplotlib.colormaps["twilight"]((0.618034 * label) % 1.0)  # the golden ratio keeps neighbours apart


def _cells(ax: Any, along: np.ndarray, up: np.ndarray, code: np.ndarray, colours: list[Any]) -> Any:
    """Draw the labels of a full grid as cells; None where initial conditions are no grid."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    columns, i = np.unique(along, return_inverse=True)
    rows, j = np.unique(up, return_inverse=True)
    if columns.size * rows.size != along.size or min(columns.size, rows.size) < 2:
        return None
    image = np.full((rows.size, columns.size), -1)
    image[j, i] = code
    if (image < 0).any():
        return None
    norm = BoundaryNorm(np.arange(len(colours) + 1) - 0.5, max(len(colours), 1))
    how = {"cmap": ListedColormap(colours, "fastaff_basins"), "norm": norm, "rasterized": True}
    return ax.pcolormesh(cell_edges(columns), cell_edges(rows), image, **how)


def _dots(ax: Any, along: np.ndarray, up: np.ndarray, code: np.ndarray, colours: list[Any], size: float) -> Any:
    """Draw the labels as dots."""
    from matplotlib.colors import to_rgba_array

    faces = to_rgba_array(colours)
    ground = Palette.of(ax).ground
    faint = np.array([contrast(face[:3], ground) < FAINT for face in faces], bool)
    edges = np.where(faint[:, None], to_rgba_array([EDGE]), faces)
    how = {"c": faces[code], "edgecolors": edges[code], "linewidths": 0.4, "rasterized": True}
    return ax.scatter(along, up, s=size, **how)


class _Phase(NamedTuple):
    """An angle at a constant rate that is the same for all initial conditions: its row, value and period."""

    row: int
    value: float
    period: float


def _phase(basins: Basins, first: int, second: int) -> _Phase | None:
    """Return the phase of a drive that is an angle among the rows, None if there is none."""
    model = argument_of(basins, "model")
    if model is None or basins.stepwise or not basins.kind.size:
        return None
    system = current_system(model)
    some = basins.points.reshape(len(basins.points), -1)
    rates = system.slopes(some[:, np.isfinite(some).all(axis=0)])
    for row, period in enumerate(system.periods):
        steady = np.ptp(rates[row]) <= SAME * np.abs(rates[row]).max()
        if period > 0 and row not in (first, second) and np.ptp(basins.z0[row]) == 0 and steady and rates[row].any():
            return _Phase(row, float(basins.z0[row, 0]), float(period))
    return None


def _at_phase(basins: Basins, k: int, phase: _Phase) -> np.ndarray:
    """Return the states (rows, points) on an attractor at a phase, by cubics between its states."""
    system = current_system(argument_of(basins, "model"))
    states = basins.points[:, :, k]
    states = states[:, np.isfinite(states).all(axis=0)]
    dt = basins.interval
    if basins.kind[k] == AttractorKind.PERIODIC:
        dt = basins.period[k] / states.shape[1]
        states = np.concatenate([states, states[:, :1]], axis=1)
    periods = np.where(np.asarray(system.periods) > 0, system.periods, np.inf)
    for row in np.flatnonzero(np.isfinite(periods)):
        states[row] = np.unwrap(states[row], period=periods[row])
    times = dt * np.arange(states.shape[1])
    path = hermite(states[:, :, None], system.slopes(states)[:, :, None], times, PIECES)[0][:, :, 0]
    turn = (path[phase.row] - phase.value) / phase.period
    left = np.flatnonzero(np.diff(np.floor(turn)))
    share = (np.maximum(np.floor(turn[left]), np.floor(turn[left + 1])) - turn[left]) / (turn[left + 1] - turn[left])
    there = path[:, left] + share * (path[:, left + 1] - path[:, left])
    with np.errstate(invalid="ignore"):
        return there - np.where(np.isfinite(periods), periods, 0.0)[:, None] * np.rint(there / periods[:, None])


def _attractor(
    ax: Any, basins: Basins, k: int, first: int, second: int, colour: Any, phase: _Phase | None = None
) -> Any:
    """Draw the states on an attractor, whose basin has this colour, or those at a phase."""
    states = basins.points[:, :, k]
    states = states[:, np.isfinite(states).all(axis=0)] if phase is None else _at_phase(basins, k, phase)
    kind = basins.kind[k]
    apart = basins.stepwise or phase is not None
    if kind == AttractorKind.FIXED_POINT or (kind == AttractorKind.PERIODIC and apart):
        marks = {"ls": "", "marker": "o", "zorder": 4, "path_effects": _outlined()}
        return ax.plot(states[first], states[second], ms=5.5, mfc=colour, mec="white", mew=1.4, **marks)[0]
    if kind == AttractorKind.PERIODIC:
        closed = np.concatenate([states, states[:, :1]], axis=1)
        return ax.plot(closed[first], closed[second], color="white", lw=1.6, zorder=4, path_effects=_outlined())[0]
    ink = "black" if luminance(colour) > MIDDLE else "white"
    return ax.plot(states[first], states[second], ls="", marker="o", ms=1.1, mew=0, mfc=ink, zorder=4, rasterized=True)[
        0
    ]


def _outlined() -> list[Any]:
    """Return a dark outline for white lines and edges."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=3.0, foreground="black"), Normal()]


def _legend(ax: Any, basins: Basins, labels: list[int], colours: list[Any], phase: _Phase | None) -> None:
    """Write names and shares beside the frame."""
    from matplotlib.patches import Patch

    names = {ESCAPED: "escaped", UNDECIDED: "undecided"} | dict(enumerate(basins.attractor_names))
    total = max(basins.label.size, 1)
    handles: list[Any] = []
    for label, colour in zip(labels, colours, strict=True):
        share = 100 * np.count_nonzero(basins.label == label) / total
        said = f"{share:.1f} %" if share >= 0.05 else f"{np.count_nonzero(basins.label == label)} orbits"
        handles.append(Patch(facecolor=colour, edgecolor="0.3", lw=0.5, label=f"{names[label]}: {said}"))
    if phase is not None:
        said = f"attractors at ${symbol(basins.names[phase.row])}={number(phase.value, 4)}$"
        handles += ax.plot([], [], ls="", marker="o", ms=5.5, mfc="white", mec="black", mew=1.2, label=said)
    place = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
    ax.legend(handles=handles, frameon=False, handlelength=1.1, labelcolor=ax.xaxis.label.get_color(), **place)
