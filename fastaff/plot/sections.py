"""Figures of sections: crossings, values of orbits over the cells of a grid, starting points."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..runs.coordinates import chart_row
from ..runs.requirements import checked_chart, current_system
from ..sections.energy_grid import EnergyGrid
from ..sections.energy_sample import EnergySample
from ..sections.section_edge import Edge, edge
from ..sections.section_map import SectionMap
from ..systems.charts import ALPHA_BETA, Chart
from ..systems.formulas.forced import PHASE
from ..systems.models.sections import AngleEquals, Hyperplane
from .colour_bars import colour_bar, plain_numbers
from .density import DENSE, draw_density
from .one_variable import draw_diagonal, images, name_iterates
from .picking import carry
from .scales import Colouring, colours_of, orbit_colours
from .starts import places
from .style import Artists, Palette, beyond, figure, outline, symbol
from .winding import argument_of

SAME = 1e-8
"""Largest relative differences of energies (to the largest kinetic one) and momenta of orbits with one boundary."""


@figure
@inserts_parameters
def plot_section(
    section_map: SectionMap,
    *,
    ax: Any = None,
    values: Any = None,
    x: str | None = None,
    y: str | None = None,
    chart: Chart = ALPHA_BETA,
    boundary: Edge | bool | None = None,
    starts: EnergyGrid | EnergySample | None = None,
    norm: Any = None,
    vmin: float | None = None,
    vmax: float | None = None,
    label: str | None = None,
    size: float | None = None,
    density: bool | None = None,
    colorbar: bool = True,
) -> Artists:
    """Plot the crossings of a Poincaré map in two coordinates, coloured by a value of each orbit.

    Parameters
    ----------
    section_map : SectionMap
        Result of `poincare_map`.
    {ax}
    values : array_like, shape (orbits,), str or Colouring, optional
        Colours: values, a column of the map such as ``"energy_error"``, or a `Colouring` of another result of the same
        orbits, for example ``colouring(chaos_map, "sali")``. Default: one blue.
    x, y : str, optional
        Coordinates or momenta (``p_beta``), for a body of the chart. Default: those free on the section. For a map of
        one variable, the second axis is the next iterate.
    chart : Chart, default ALPHA_BETA
        Coordinates of a body.
    boundary : Edge or bool, optional
        Boundary of the accessible region, from `edge`, or True to compute it at the energy of the orbits.
    starts : EnergyGrid or EnergySample, optional
        Initial conditions of the orbits, to mark those that never crossed.
    {norm}
    {colour_range}
    {colour_label}
    {dot_size}
    density : bool, optional
        Draw an image of the number of crossings in each pixel, or of the mean of their values. Default: above 300 000
        crossings.
    {colorbar}

    Returns
    -------
    Artists
        ``missing`` is the number of orbits that are not drawn. Orbits without a value and those that failed or escaped
        are grey; the legend has their number. A click picks orbit and crossing.

    Notes
    -----
    Cost: an image takes about 0.1 microseconds per crossing.

    Examples
    --------
    >>> cut = fa.poincare_map(fa.HenonHeiles(), [0.0, 0.1, 0.3, 0.1], section="x=0", crossings=3, max_time=100.0)
    >>> fa.plot.plot_section(cut).points.get_offsets().shape
    (3, 2)
    """
    boundary = _own_edge(section_map) if boundary is True else boundary or None
    names, coordinates = section_coordinates(section_map, chart)
    first, second = _free_pair(section_map, names)
    x, y = x or first, y or second
    for name in (x, y):
        if name not in names:
            raise ValueError(f"x and y must be among {listed(names)}, got {shown(name)}")
    u = coordinates[names.index(x)]
    v = coordinates[names.index(y)]
    returns = len(names) == 1
    v = images(u) if returns else v
    colours = None if values is None else orbit_colours(section_map, values, u.shape[1], norm, vmin, vmax, label)
    gone = ~np.isin(section_map.status, (Status.OK, Status.TOO_FEW_CROSSINGS, Status.INTERRUPTED))
    crossed = section_map.counts > 0
    drawn = crossed & (~gone if colours is None else np.isfinite(colours.values))
    total = int(section_map.counts[drawn].sum())
    dense = total > DENSE if density is None else density
    flat = _all_crossings(u, v, drawn) if dense else _crossings(u, v, np.flatnonzero(drawn))
    lines: list[Any] = []
    grey = crossed & ~drawn
    away = _crossings(u, v, np.flatnonzero(grey))
    legend = _grey(ax, away, why(section_map.status, grey), size, total)
    waiting = np.zeros_like(drawn)
    if starts is not None and not crossed.all():
        at = places(starts)
        waiting = ~crossed
        legend += _crosses(ax, at, waiting, why(section_map.status, waiting))
    points = _draw(ax, flat, colours, size, dense, away[0].size, drawn.size)
    if boundary is not None:
        lines += outline(ax, boundary)
    _look_at(ax, flat, (u, v), grey, starts, boundary)
    texts = _cut(ax, away)
    if legend:
        above_frame(ax, legend)
    ax.set(xlabel=f"${symbol(x)}$", ylabel=f"${symbol(y)}$")
    if returns:
        name_iterates(ax, x)
        lines.append(draw_diagonal(ax))
    bar = None
    if colorbar and colours is not None and total:
        bar = colour_bar(ax, points, colours)
    elif colorbar and dense and total:
        bar = ax.figure.colorbar(points, ax=ax, label="crossings per cell")
        if points.norm.vmax < 100:
            plain_numbers(bar)
    return Artists(points, bar, tuple(lines), texts, int(np.count_nonzero(~(drawn | grey | waiting))))


def _own_edge(found: Any) -> Edge:
    """Return the edge of a section at the energy, and for a body the angular momenta, of the orbits that cross it."""
    instead = "give boundary=fastaff.plot.edge(body, section, energy=...)"
    body = argument_of(found, "model")
    z0 = argument_of(found, "z0")
    if body is None or z0 is None:
        raise ValueError(f"boundary=True needs the call that made the map, with a model of the package: {instead}")
    starts = np.reshape(np.asarray(z0, dtype=np.float64), (len(z0), -1))
    system = current_system(body)
    own: dict[str, Any] = {"energy": system.energies(starts)}
    size = system.kinetic_energies(starts).max()
    if system.isotropic:
        own |= {name: chart_row(starts, name) for name in ("p_eta", "p_gamma")}
    one: dict[str, Any] = {name: float(np.median(row)) for name, row in own.items()}
    for name, row in own.items():
        if not np.ptp(row) <= SAME * (size if name == "energy" else np.abs(row).max()):
            raise ValueError(
                f"boundary=True needs orbits of one {name}, got {row.min():.6g} to {row.max():.6g}: {instead}"
            )
    return edge(body, found.section, **one)


def _cut(ax: Any, away: tuple[np.ndarray, ...]) -> tuple[Any, ...]:
    """Write the number of grey crossings beyond the frame."""
    if not away[0].size:
        return ()
    x0, x1 = sorted(ax.get_xlim())
    y0, y1 = sorted(ax.get_ylim())
    inside = (x0 <= away[0]) & (away[0] <= x1) & (y0 <= away[1]) & (away[1] <= y1)
    many = np.count_nonzero(~inside)
    return (beyond(ax, f"{many} crossings of grey orbits beyond the axes"),) if many else ()


def _crossings(u: np.ndarray, v: np.ndarray, orbits: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return u, v, orbit and crossing (points,) of the finite crossings of some orbits."""
    x, y = (row.T[orbits].ravel() if orbits.size < row.shape[1] else row.T.ravel() for row in (u, v))
    number = np.repeat(orbits.astype(np.int32), len(u))
    crossing = np.tile(np.arange(len(u), dtype=np.int32), orbits.size)
    kept = np.isfinite(x) & np.isfinite(y)
    return (x, y, number, crossing) if kept.all() else (x[kept], y[kept], number[kept], crossing[kept])


def _all_crossings(u: np.ndarray, v: np.ndarray, drawn: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return u, v (crossings*orbits,) of all crossings, one of each orbit after the other, NaN for those not drawn."""
    if not drawn.all():
        u = np.where(drawn, u, np.nan)
    return u.ravel(), v.ravel()


def _draw(
    ax: Any,
    flat: tuple[np.ndarray, ...],
    colours: Colouring | None,
    size: float | None,
    dense: bool,
    besides: int,
    orbits: int,
) -> Any:
    """Draw crossings as an image or as dots."""
    palette = Palette.of(ax)
    how = {} if colours is None else {"cmap": colours_of(colours, palette), "norm": colours.norm}
    if dense:
        x, y = flat
        image = draw_density(ax, x, y, None if colours is None else colours.values, **how)
        return carry(image, x, y, orbits=orbits)
    x, y, orbit, crossing = flat
    # In a random order, so that no kind of orbit covers another.
    order = np.random.default_rng(0).permutation(x.size)
    x = x[order]
    y = y[order]
    orbit = orbit[order]
    crossing = crossing[order]
    area = size if size is not None else float(np.clip(60000 / max(x.size + besides, 1), 0.25, 9.0))
    how = {"color": palette.main} if colours is None else {"c": colours.values[orbit], **how}
    points = ax.scatter(x, y, s=area, linewidths=0, rasterized=True, **how)
    return carry(points, x, y, orbit, crossing)


def above_frame(ax: Any, handles: list[Any]) -> None:
    """Put a legend above the frame, under a title on the left, where it hides nothing."""
    place = {"loc": "lower right", "bbox_to_anchor": (1.01, 0.995), "labelspacing": 0.2}
    place["labelcolor"] = ax.xaxis.label.get_color()  # outside of the frame
    ax.legend(handles=handles, frameon=False, handletextpad=0.2, borderpad=0.2, **place)
    if said := ax.get_title(loc="left"):
        ax.set_title(said, fontsize=9, loc="left", pad=6 + 12 * len(handles))


def _look_at(
    ax: Any, flat: tuple[np.ndarray, ...], rows: tuple[np.ndarray, np.ndarray], grey: np.ndarray, starts: Any, edge: Any
) -> None:
    """Set the frame to the coloured crossings and the starts if some orbits have gone far away."""
    if not grey.any():
        return
    near = [np.array(flat[:2])]
    if starts is not None:
        near.append(places(starts))
    if edge is not None:
        near.append(
            np.array([np.tile(edge.coordinate, 2), np.append(edge.centre + edge.momentum, edge.centre - edge.momentum)])
        )
    inside = np.concatenate(near, axis=1)
    inside = inside[:, np.isfinite(inside).all(axis=0)]
    if not inside.size:  # the first crossings, without those that were farthest
        first = np.array([row[0, grey] for row in rows])
        first = first[:, np.isfinite(first).all(axis=0)]
        if not first.size:
            return
        low, high = np.quantile(first, [0.1, 0.9], axis=1)
        low, high = low - 2 * (high - low), high + 2 * (high - low)
        inside = np.array([row[:, grey].ravel() for row in rows])
        with np.errstate(invalid="ignore"):
            inside = inside[:, ((low <= inside.T) & (high >= inside.T)).all(axis=1)]
    low, high = inside.min(axis=1), inside.max(axis=1)
    room = np.where(high > low, 0.08 * (high - low), 0.5)
    ax.set(xlim=(low[0] - room[0], high[0] + room[0]), ylim=(low[1] - room[1], high[1] + room[1]))


def words(status: Any) -> str:
    """Name an outcome in a legend."""
    known = {
        Status.OK: "without a value",
        Status.TOO_FEW_CROSSINGS: "few crossings",
        Status.NONFINITE: "became infinite",
        Status.OUT_OF_DOMAIN: "left the domain",
        Status.STEP_TOO_SMALL: "step too small",
    }
    return known.get(Status(int(status)), Status(int(status)).name.lower().replace("_", " "))


def why(status: np.ndarray, chosen: np.ndarray) -> str:
    """Return the numbers of chosen orbits by outcome, frequent ones first."""
    codes, counts = np.unique(np.asarray(status)[chosen], return_counts=True)
    order = np.argsort(-counts, kind="stable")
    return ", ".join(f"{counts[k]} {words(codes[k])}" for k in order)


def _grey(ax: Any, flat: tuple[np.ndarray, ...], why: str, size: float | None, besides: int) -> list[Any]:
    """Draw crossings in grey below the others; return the entries of the legend."""
    x, y, orbit, crossing = flat
    if not x.size:
        return []
    area = size if size is not None else float(np.clip(60000 / (x.size + besides), 0.25, 9.0))
    grey = Palette.of(ax).lost
    carry(ax.scatter(x, y, s=area, color=grey, linewidths=0, rasterized=True, zorder=0.9), x, y, orbit, crossing)
    return [ax.scatter([], [], s=16, color=grey, linewidths=0, label=why)]


def _crosses(ax: Any, at: np.ndarray, chosen: np.ndarray, why: str) -> list[Any]:
    """Mark the starts of orbits that never crossed."""
    number = np.flatnonzero(chosen)
    area = float(np.clip(4000 / number.size, 3.0, 16.0))
    style = {"marker": "x", "color": Palette.of(ax).grey(0.6), "linewidths": 0.7}
    marks = ax.scatter(*at[:, number], s=area, rasterized=True, zorder=0.9, **style)
    carry(marks, at[0, number], at[1, number], number)
    return [ax.scatter([], [], s=16, **style, label=f"no crossing: {why}")]


def section_coordinates(section_map: Any, chart: Chart) -> tuple[tuple[str, ...], np.ndarray]:
    """Return names and values (names, crossings, orbits) of all coordinates."""
    if len(section_map.points) == 8:
        return (*checked_chart(chart).names, *chart.momenta), section_map.coordinates(chart)
    names = section_map.names if len(section_map.names) == len(section_map.points) else ("x", "y", "p_x", "p_y")
    return tuple(names), section_map.points


def _free_pair(section_map: Any, names: tuple[str, ...]) -> tuple[str, str]:
    """Return a coordinate that is free on the section and its momentum; without momenta, the first two free ones."""
    section = section_map.section
    if names[-2:] == PHASE and isinstance(section, Hyperplane) and np.any(section.normal[-2:]):  # a phase of the force
        names = names[:-2]
        return names[0], names[len(names) // 2 if has_momenta(section_map) else 1 % len(names)]
    if len(names) > 2 and not has_momenta(section_map):
        return free_rows(section, names)
    free = _free_coordinate(section, names)
    return free, names[names.index(free) + len(names) // 2]


def has_momenta(found: Any) -> bool:
    """Tell whether the second half of the rows of a result are momenta: by its model, or by their names, which are
    those of `hamiltonian` for a forced system, and begin with p if the model is not known.
    """
    names = tuple(name for name in found.names if name not in PHASE)
    model = argument_of(found, "model")
    if model is not None and current_system(model).canonical:
        return True
    half = len(names) // 2
    if model is not None:
        return names[half:] == tuple(f"p_{name}" for name in names[:half])
    return len(names) == 2 * half and all(name[:1] == "p" for name in names[half:])


def free_rows(section: Any, names: tuple[str, ...]) -> tuple[str, str]:
    """Return the first two of three or more coordinates without the one that the section fixes."""
    fixed = np.flatnonzero(section.normal)[:1] if isinstance(section, (Hyperplane, AngleEquals)) else ()
    first, second, *_ = [name for row, name in enumerate(names) if row not in fixed]
    return first, second


def _free_coordinate(section: Any, names: tuple[str, ...]) -> str:
    if isinstance(section, (Hyperplane, AngleEquals)):
        own = int(np.flatnonzero(section.normal)[0]) % (len(names) // 2)
        return names[1 if own == 0 and len(names) > 2 else 0]
    chosen = getattr(section, "over", "beta")
    return chosen if chosen in names else names[0]


@figure
@inserts_parameters
def plot_edge(boundary: Edge, *, ax: Any = None) -> Artists:
    """Plot the boundary of the accessible part of a section.

    Parameters
    ----------
    boundary : Edge
        Boundary of `edge`.
    {ax}

    Returns
    -------
    Artists
        ``points`` is the curve.

    Examples
    --------
    >>> drawn = fa.plot.plot_edge(fa.plot.edge(fa.HenonHeiles(), "x=0", energy=1 / 8))
    >>> drawn.points.get_ydata().max().round(4)
    np.float64(0.5)
    """
    (curve,) = outline(ax, boundary)
    ax.set(xlabel="section coordinate", ylabel="its momentum")
    return Artists(curve, None, (curve,), (), 0)
