"""Figures of chaos: maps of an indicator or of the classification, chaotic fractions against parameters, histories.

As in `fastaff.plot`, every function takes `ax=` and returns the artists it made. Bright is chaotic everywhere: the
colours of cividis have a step of lightness at the threshold, so that the boundary between regular and chaotic is seen
with any kind of colour vision, and in grey.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..chaos.chaos_map import ChaosMap
from ..chaos.chaotic_fraction import ChaoticFraction
from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..sections.energy_grid import EnergyGrid
from ..sections.energy_sample import EnergySample
from ..sections.section_edge import Edge
from .colour_bars import colour_bar
from .parameters import parameter_label
from .picking import carry
from .scales import coloured, indicator_of, label_of, threshold_colours
from .sections import above_frame, why
from .starts import cell_edges, cut_sides, grey_cells, places, widths
from .style import Artists, Palette, beyond, chosen_orbits, figure, outline, symbol

CLASSIFICATIONS = ("regular", "undecided", "chaotic")


@figure
@inserts_parameters
def plot_chaos_map(
    starts: EnergyGrid | EnergySample,
    chaos_map: ChaosMap,
    *,
    ax: Any = None,
    indicator: str | None = None,
    boundary: Edge | None = None,
    norm: Any = None,
    vmin: float | None = None,
    vmax: float | None = None,
    size: float | None = None,
    colorbar: bool = True,
) -> Artists:
    """Plot an indicator, or the classification, of orbits over their initial conditions.

    Parameters
    ----------
    starts : EnergyGrid or EnergySample
        Initial conditions of the orbits: cells of a grid or points of a sample.
    chaos_map : ChaosMap
        Indicators of the orbits.
    {ax}
    indicator : str, optional
        Name in ``chaos_map.names``. Default: the classification.
    boundary : Edge, optional
        Boundary of the accessible region, from `edge`.
    norm : matplotlib.colors.Normalize, optional
        Colour scale. Default: a scale about the median of the thresholds.
    {colour_range}
    {dot_size}
    {colorbar}

    Returns
    -------
    Artists
        ``points`` are the cells or dots, ``lines`` the boundary. ``missing`` is the number of orbits without a value,
        which are grey; the legend has the reasons. Inaccessible cells stay empty. A click picks the orbit.

    Examples
    --------
    >>> grid = fa.energy_grid(fa.HenonHeiles(), energy=0.1, section="x=0", axes=([-0.2, 0.0, 0.6], [0.0, 0.1]))
    >>> chaos = fa.chaos_map(fa.HenonHeiles(), grid.z0, time=1000.0, indicators=fa.SALI())
    >>> fa.plot.plot_chaos_map(grid, chaos).missing
    0
    """
    if indicator is not None and indicator not in chaos_map.names:
        raise ValueError(f"indicator must be one of {listed(chaos_map.names)} or None, got {shown(indicator)}")
    orbits = starts.z0.shape[1]
    if chaos_map.status.size != orbits:
        raise ValueError(f"chaos_map must be of the {orbits} orbits of starts, got {chaos_map.status.size}")
    fine = chaos_map.status == Status.OK
    colours = None
    palette = Palette.of(ax)
    if indicator is None:
        each = np.where(chaos_map.chaotic, 2.0, np.where(chaos_map.regular, 0.0, 1.0))
        fine = fine & np.isfinite(chaos_map.values).any(axis=0)
        how = _classification_colours(palette)
    else:
        row = chaos_map.names.index(indicator)
        each = chaos_map.values[row]
        threshold = float(np.median(chaos_map.thresholds[row]))
        fine = fine & np.isfinite(each)
        given = {"vmin": vmin, "vmax": vmax, "norm": norm, "result": chaos_map}
        colours = coloured(indicator, np.where(fine, each, np.nan), threshold, **given)
        how = {"cmap": threshold_colours(palette, colours.falling), "norm": colours.norm}
    points = _drawn(ax, starts, np.where(fine, each, np.nan), fine, how, size)
    legend = "" if fine.all() else why(chaos_map.status, ~fine)
    if legend:
        handle = ax.scatter([], [], s=16, color=palette.lost, linewidths=0, label=legend)
        above_frame(ax, [handle])
    lines = [] if boundary is None else outline(ax, boundary)
    ax.set(xlabel=f"${symbol(starts.names[0])}$", ylabel=f"${symbol(starts.names[1])}$")
    bar = None
    if colorbar:
        bar = _classification_bar(ax, points) if colours is None else colour_bar(ax, points, colours)
    return Artists(points, bar, tuple(lines), cut_sides(ax, starts), int(np.count_nonzero(~fine)))


def _drawn(ax: Any, starts: Any, each: np.ndarray, fine: np.ndarray, how: dict[str, Any], size: float | None) -> Any:
    """Draw a value of each orbit at its start, in cells or dots, grey where there is none."""
    at = places(starts)
    number = np.arange(fine.size)
    if isinstance(starts, EnergyGrid):
        grey_cells(ax, starts, ~fine)
        image = np.ma.masked_invalid(starts.to_grid(each))
        cells = ax.pcolormesh(*map(cell_edges, starts.axes), image.T, rasterized=True, **how)
        return carry(cells, at[0], at[1], number, cell=widths(starts))
    area = size if size is not None else float(np.clip(24000 / max(fine.size, 1), 2.0, 24.0))
    if not fine.all():
        gone = ax.scatter(*at[:, ~fine], s=area, color=Palette.of(ax).lost, linewidths=0, rasterized=True)
        carry(gone, at[0, ~fine], at[1, ~fine], number[~fine])
    points = ax.scatter(*at[:, fine], c=each[fine], s=area, linewidths=0, rasterized=True, **how)
    return carry(points, at[0, fine], at[1, fine], number[fine])


def _classification_colours(palette: Palette) -> dict[str, Any]:
    from matplotlib.colors import BoundaryNorm, ListedColormap

    colours = palette.cividis([0.1, 0.55, palette.bright])
    return {
        "cmap": ListedColormap(colours, name="fastaff_classification"),
        "norm": BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3),
    }


def _classification_bar(ax: Any, points: Any) -> Any:
    bar = ax.figure.colorbar(points, ax=ax, ticks=[0, 1, 2])
    bar.ax.set_yticklabels(CLASSIFICATIONS, rotation=90, va="center")
    bar.ax.tick_params(length=0)
    return bar


@figure
@inserts_parameters
def plot_chaotic_fraction(
    scan: ChaoticFraction,
    *,
    ax: Any = None,
    colour: Any = None,
    marker: str = "o",
    label: str | None = None,
    colorbar: bool = True,
) -> Artists:
    """Plot the chaotic fraction against a parameter with 95 % intervals, or over two parameters.

    Parameters
    ----------
    scan : ChaoticFraction
        Result of `chaotic_fraction`.
    {ax}
    colour : str, optional
        Colour of the curve of one parameter. Default: dark blue, or light blue on a dark ground.
    marker : str, default "o"
        Marker of the curve.
    label : str, optional
        Label of the curve in the legend.
    {colorbar}

    Returns
    -------
    Artists
        Curve: ``points`` are the error bars, ``lines`` the pale band of undecided orbits and the grey range in which
        the energy allows no motion. Map: ``points`` are the cells; cases without orbits are hatched. ``missing`` is the
        number of cases without a value.

    Examples
    --------
    >>> def case(K):
    ...     return fa.models.StandardMap(K), np.array([[0.5, 2.0, 3.0], [0.0, 0.1, 0.2]])
    >>> scan = fa.chaotic_fraction(case, ([0.3, 6.0],), time=1000, names=["K"])
    >>> fa.plot.plot_chaotic_fraction(scan).missing
    0
    """
    fraction = scan.fraction
    missing = int(np.count_nonzero(~np.isfinite(fraction)))
    ax.set(xlabel=parameter_label(scan.names[0]))
    if len(scan.axes) == 2:
        cells, bar = _fraction_map(scan, fraction, ax, colorbar)
        return Artists(cells, bar, (), (), missing)
    palette = Palette.of(ax)
    colour = palette.main if colour is None else colour
    x = scan.axes[0]
    known = np.isfinite(fraction)
    low, high = scan.interval()
    away = np.maximum([fraction - low, high - fraction], 0.0)[:, known]
    lines: list[Any] = [ax.fill_between(x, *scan.bounds, color=colour, alpha=0.18, linewidth=0)]
    empty = scan.done & (scan.orbits == 0)
    if empty.any():
        ends = cell_edges(x)
        span = {"color": palette.shade, "linewidth": 0, "zorder": 0}
        lines += [ax.axvspan(ends[i], ends[i + 1], **span) for i in np.flatnonzero(empty)]
    points = ax.errorbar(
        x[known],
        fraction[known],
        yerr=away,
        color=colour,
        marker=marker,
        ms=4,
        lw=1.2,
        elinewidth=0.9,
        capsize=2,
        label=label,
    )
    ax.set(ylabel="chaotic fraction of the section", ylim=(-0.03, 1.03))
    return Artists(points, None, tuple(lines), (), missing)


def _fraction_map(scan: ChaoticFraction, fraction: np.ndarray, ax: Any, colorbar: bool) -> tuple[Any, Any]:
    from matplotlib.colors import Normalize

    palette = Palette.of(ax)
    image = np.ma.masked_invalid(fraction)
    edges = [cell_edges(axis) for axis in scan.axes]
    hatched = {"facecolor": palette.ground, "edgecolor": palette.grey(0.6), "hatch": "////", "linewidth": 0}
    ax.fill_between(edges[0][[0, -1]], *edges[1][[0, -1]], zorder=0, **hatched)
    cells = ax.pcolormesh(*edges, image.T, cmap=palette.colour_map(), norm=Normalize(0.0, 1.0), rasterized=True)
    ax.set(ylabel=parameter_label(scan.names[1]))
    return cells, ax.figure.colorbar(cells, ax=ax, label="chaotic fraction of the section") if colorbar else None


@figure
@inserts_parameters
def plot_history(
    chaos_map: ChaosMap,
    indicator: str,
    *,
    ax: Any = None,
    orbits: Sequence[int] | None = None,
    slopes: Sequence[float] = (),
    labels: bool = True,
) -> Artists:
    """Plot the history of an indicator, with power laws for comparison.

    Parameters
    ----------
    chaos_map : ChaosMap
        Result of `chaos_map` with a history.
    indicator : str
        Name in ``chaos_map.names``.
    {ax}
    orbits : sequence of int, optional
        Numbers of the orbits to draw. Default: up to 40.
    slopes : sequence of float, optional
        Exponents s of laws t^s, for example -2 (k - n) for GALI_k of regular orbits.
    labels : bool, default True
        Write the exponents beside the laws.

    Returns
    -------
    Artists
        ``points`` are the curves, ``lines`` the laws. ``missing`` is the number of chosen orbits without a record.

    Notes
    -----
    - Time is logarithmic. Indicators that are logarithms are drawn as such, not far below the threshold (dotted line).
    - Regular orbits are blue and solid, chaotic ones orange and thin, undecided ones dotted.

    Examples
    --------
    >>> chaos = fa.chaos_map(fa.models.StandardMap(1.3), [[3.1, 0.1], [0.2, 0.0]], time=2000, history=50)
    >>> len(fa.plot.plot_history(chaos, chaos.names[0]).points)
    2
    """
    histories = chaos_map.history
    times = chaos_map.history_times
    if indicator not in chaos_map.names:
        raise ValueError(f"indicator must be one of {listed(chaos_map.names)}, got {shown(indicator)}")
    history = histories[chaos_map.names.index(indicator)]
    if not np.isfinite(history).any():
        raise ValueError(
            f"chaos_map must have a history of {indicator} to be drawn. Use chaos_map(..., history=200) with an "
            "indicator of deviation vectors."
        )
    total = history.shape[1]
    chosen = chosen_orbits(orbits, total, 40)
    curves = []
    missing = 0
    palette = Palette.of(ax)
    for i in chosen:
        known = np.isfinite(history[:, i]) & (times[:, i] > 0)
        missing += not known.any()
        chaotic = bool(chaos_map.chaotic[i])
        doubt = bool(chaos_map.undecided[i])
        style = {
            "color": palette.accent if chaotic else palette.navy,
            "lw": 0.7 if chaotic else 1.1,
            "ls": ":" if doubt else "-",
        }
        curves += ax.plot(times[known, i], history[known, i], alpha=0.8, **style)
    ax.set_xscale("log")
    first = np.nanmin(np.where(times > 0, times, np.nan))
    last = np.nanmax(times)
    drawn = []
    written = []
    calm = history[:, chosen][:, ~chaos_map.chaotic[chosen]]
    start = float(np.nanmedian(calm[0])) if calm.size and np.isfinite(calm[0]).any() else float(np.nanmax(history[0]))
    for slope in slopes:
        end = start + slope * math.log10(last / first)
        drawn += ax.plot([first, last], [start, end], color=palette.ink, lw=1.2, ls=(0, (5, 2.5)), zorder=3)
        if labels:
            written.append(ax.text(last, end, rf"$t^{{{slope:g}}}$", va="bottom", ha="right", fontsize=9))
    threshold = float(np.median(chaos_map.thresholds[chaos_map.names.index(indicator), chosen]))
    known = indicator_of(indicator, chaos_map)
    ax.set(xlabel="time $t$", ylabel=label_of(indicator, known))
    ax.axhline(threshold, color=palette.grey(0.5), lw=0.8, ls=(0, (1, 1.5)))
    if not getattr(known, "above", True) and ax.get_ylim()[0] < 1.5 * threshold:
        # room for the laws: chaotic orbits fall by hundreds of decades
        written.append(beyond(ax, f"curves go on down to {ax.dataLim.ymin:.3g}"))
        ax.set_ylim(1.5 * threshold, 0.05 * abs(threshold))
    return Artists(curves, None, tuple(drawn), tuple(written), missing)
