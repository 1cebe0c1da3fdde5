"""Figures of chaos: maps of an indicator or of the verdict, chaotic fractions against parameters, histories.

As in `fastaff.plot`, every function takes `ax=` and returns the artists it made. Bright is chaotic everywhere: the
colours of cividis have a step of lightness at the limit, so that the boundary between regular and chaotic is seen with
any kind of colour vision, and in grey.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..analysis.chaos.chaos_map import ChaosMap
from ..analysis.chaos.chaotic_fraction import ChaoticFraction
from ..analysis.chaos.indicators import GALI, SALI, BirkhoffDigits
from ..analysis.sections.energy_grid import EnergyGrid
from ..analysis.sections.energy_sample import Edge, EnergySample
from ..base.status import Status
from .sections import DIFFUSION, PALE_END, Artists, symbol

STEP = (0.36, 0.66)
"""The part of cividis that is left out at the limit."""
LABELS = {
    "megno": r"MEGNO $\langle Y\rangle$",
    "sali": r"$\log_{10}$ SALI",
    "fli": r"FLI, largest $\log_{10}|w|$",
    "ofli": r"OFLI, largest $\log_{10}|w_\perp|$",
    "lyapunov": r"Lyapunov exponent $\lambda_1$ (per unit time)",
    "largest": r"Lyapunov exponent $\lambda_1$ (per unit time)",
    "birkhoff_digits": "digits of Birkhoff averages",
    "frequency_diffusion": DIFFUSION,
    "zero_one": "0-1 test $K$",
    "reversibility_error": r"$\log_{10}$ reversibility error",
}
VERDICTS = ("regular", "undecided", "chaotic")


def label_of(name: str) -> str:
    """Return the label of an indicator for axes and colour bars."""
    return LABELS.get(name) or (rf"$\log_{{10}}$ GALI$_{{{name[5:]}}}$" if name.startswith("gali_") else name)


def _falls(name: str) -> bool:
    """Whether chaotic orbits are below the limit."""
    return name in (SALI.name, BirkhoffDigits.name) or name.startswith(GALI(2).name[:5])


def limit_colours(falls: bool) -> Any:
    """Return cividis with a step in its middle, the bright half on the side of chaos."""
    import matplotlib
    from matplotlib.colors import ListedColormap

    place = np.concatenate([np.linspace(0.0, STEP[0], 128), np.linspace(STEP[1], PALE_END, 128)])
    return ListedColormap(matplotlib.colormaps["cividis"](place[::-1] if falls else place), name="fastaff_limit")


def limit_scale(values: Any, limit: float) -> Any:
    """Return a colour scale with the limit in its middle, from the 2nd to the 98th percentile of the values beyond it
    on either side.
    """
    from matplotlib.colors import TwoSlopeNorm

    values = np.asarray(values, dtype=np.float64)
    below, above = values[values < limit], values[(values > limit) & np.isfinite(values)]
    below = below[np.isfinite(below)]
    low = float(np.quantile(below, 0.02)) if below.size else math.nan
    high = float(np.quantile(above, 0.98)) if above.size else math.nan
    other = max(limit - low if below.size else 0.0, high - limit if above.size else 0.0) or 1.0
    least = 1e-3 * max(other, abs(limit)) or 1e-3
    low = min(low, limit - least) if below.size else limit - 0.5 * other
    high = max(high, limit + least) if above.size else limit + 0.5 * other
    return TwoSlopeNorm(limit, low, high)


def plot_chaos_map(
    starts: EnergyGrid | EnergySample,
    chaos_map: ChaosMap,
    *,
    ax: Any,
    indicator: str | None = None,
    boundary: Edge | None = None,
    norm: Any = None,
    size: float | None = None,
    colorbar: bool = True,
) -> Artists:
    """Draw an indicator, or the verdict, of orbits over the section where they started.

    Parameters: starts: the Grid (cells) or Sample (points) of the orbits; indicator: a name in chaos_map.names, None
    for the verdict; boundary: of `edge`; norm: a colour scale, by default `limit_scale` about the median of the limits;
    size: area of a point of a Sample in square points. Returns Artists: points are the cells or dots, lines the
    boundary and the mark of the limit on the colour bar; `missing` counts the orbits without a value, which are drawn
    as crosses. Cells that the energy does not reach stay white.
    """
    if indicator is not None and indicator not in chaos_map.names:
        raise ValueError(f"indicator must be one of {', '.join(chaos_map.names)} or None, got {indicator!r}")
    orbits = starts.z0.shape[1]
    if chaos_map.status.size != orbits:
        raise ValueError(f"chaos_map must be of the {orbits} orbits of starts, got {chaos_map.status.size}")
    fine = chaos_map.status == Status.OK
    if indicator is None:
        each = np.where(chaos_map.chaotic, 2.0, np.where(chaos_map.regular, 0.0, 1.0))
        fine = fine & np.isfinite(chaos_map.values).any(axis=0)
        colours = _verdict_colours()
    else:
        row = chaos_map.names.index(indicator)
        each, limit = chaos_map.values[row], float(np.median(chaos_map.limits[row]))
        fine = fine & np.isfinite(each)
        colours = {"cmap": limit_colours(_falls(indicator)), "norm": norm or limit_scale(each[fine], limit)}
    if isinstance(starts, EnergyGrid):
        image = np.ma.masked_invalid(starts.spread(np.where(fine, each, np.nan)))
        points = ax.pcolormesh(*starts.axes, image.T, rasterized=True, shading="nearest", **colours)
        at = np.array([grid.ravel()[starts.cell] for grid in np.meshgrid(*starts.axes, indexing="ij")])
    else:
        at = starts.points
        area = size if size is not None else float(np.clip(24000 / max(orbits, 1), 2.0, 24.0))
        points = ax.scatter(*at[:, fine], c=each[fine], s=area, linewidths=0, rasterized=True, **colours)
    if not fine.all():
        ax.scatter(
            *at[:, ~fine],
            marker="x",
            s=float(np.clip(9000 / orbits, 4.0, 16.0)),
            color="black",
            linewidths=0.7,
            rasterized=True,
        )
    lines = [] if boundary is None else _outline(ax, boundary)
    ax.set(xlabel=f"${symbol(starts.names[0])}$", ylabel=f"${symbol(starts.names[1])}$")
    bar = None
    if colorbar:
        bar = _verdict_bar(ax, points) if indicator is None else _limit_bar(ax, points, indicator, limit, each[fine])
        lines += [] if indicator is None else [bar.ax.axhline(limit, color="black", lw=1.6)]
    return Artists(points, bar, tuple(lines), (), int(np.count_nonzero(~fine)))


def _verdict_colours() -> dict[str, Any]:
    import matplotlib
    from matplotlib.colors import BoundaryNorm, ListedColormap

    colours = matplotlib.colormaps["cividis"]([0.1, 0.55, PALE_END])
    return {"cmap": ListedColormap(colours, name="fastaff_verdict"), "norm": BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3)}


def _verdict_bar(ax: Any, points: Any) -> Any:
    bar = ax.figure.colorbar(points, ax=ax, ticks=[0, 1, 2])
    bar.ax.set_yticklabels(VERDICTS, rotation=90, va="center")
    bar.ax.tick_params(length=0)
    return bar


def _limit_bar(ax: Any, points: Any, name: str, limit: float, values: np.ndarray) -> Any:
    """Draw a colour bar with arrows where values lie beyond it, and the limit among its ticks."""
    scale = points.norm
    below, above = bool((values < scale.vmin).any()), bool((values > scale.vmax).any())
    extend = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}[below, above]
    bar = ax.figure.colorbar(points, ax=ax, label=label_of(name), extend=extend, spacing="uniform")
    room = (scale.vmax - limit) / 8, (limit - scale.vmin) / 8  # no tick so close to the limit
    ticks = [t for t in _ticks(scale.vmin, limit) if t < limit - room[1]] + [
        t for t in _ticks(limit, scale.vmax) if t > limit + room[0]
    ]
    labels = [*(f"{t:g}" for t in ticks), f"limit {limit:.3g}"]
    bar.set_ticks([*ticks, limit], labels=[text.replace("-", "\N{MINUS SIGN}") for text in labels])
    bar.ax.get_yticklabels()[-1].set_fontweight("bold")
    if _falls(name):
        bar.ax.invert_yaxis()
    for where, text, colour in ((0.25, "regular", "white"), (0.75, "chaotic", "black")):
        bar.ax.text(
            0.5,
            where,
            text,
            transform=bar.ax.transAxes,
            rotation=90,
            ha="center",
            va="center",
            fontsize=7.5,
            color=colour,
        )
    return bar


def _ticks(low: float, high: float) -> list[float]:
    from matplotlib.ticker import MaxNLocator

    return [float(t) for t in MaxNLocator(4).tick_values(low, high) if low <= t <= high]


def _outline(ax: Any, boundary: Edge) -> list[Any]:
    u, p = boundary.coordinate, boundary.momentum
    loop = np.concatenate([u, u[::-1], u[:1]]), np.concatenate([p, -p[::-1], p[:1]])
    return list(ax.plot(*loop, color="0.35", lw=0.8))


def parameter_label(name: str) -> str:
    """Return the label of a parameter for an axis."""
    known = {
        "energy": "energy $E$",
        "p_phi": r"spin $p_\varphi$",
        "p_psi": r"vorticity $p_\psi$",
        "mu": r"inertia $\mu$",
    }
    return known.get(name) or (f"${symbol(name)}$" if name.replace("_", "").isalnum() else name)


def plot_chaotic_fraction(
    scan: ChaoticFraction,
    *,
    ax: Any,
    colour: Any = "#00306f",
    marker: str = "o",
    label: str | None = None,
    colorbar: bool = True,
) -> Artists:
    """Draw the chaotic fraction against a parameter with its 95 % intervals, or as a map over two parameters.

    Parameters: scan: of `chaotic_fraction`; colour, marker, label: of the curve of one parameter; colorbar: beside a
    map of two. Returns Artists. Curve: points are the error bars, lines the pale band that undecided orbits leave open,
    and the grey part where the energy reaches nothing. Map: points are the cells; cases without orbits are hatched.
    `missing` counts cases without a value.
    """
    fraction = scan.fraction
    missing = int(np.count_nonzero(~np.isfinite(fraction)))
    ax.set(xlabel=parameter_label(scan.names[0]))
    if len(scan.axes) == 2:
        cells, bar = _fraction_map(scan, fraction, ax, colorbar)
        return Artists(cells, bar, (), (), missing)
    x = scan.axes[0]
    known = np.isfinite(fraction)
    low, high = scan.interval()
    away = np.maximum([fraction - low, high - fraction], 0.0)[:, known]
    lines: list[Any] = [ax.fill_between(x, *scan.bounds, color=colour, alpha=0.18, linewidth=0)]
    empty = scan.done & (scan.orbits == 0)
    if empty.any():
        ends = _cell_edges(x)
        lines += [ax.axvspan(ends[i], ends[i + 1], color="0.9", linewidth=0, zorder=0) for i in np.flatnonzero(empty)]
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
    import matplotlib
    from matplotlib.colors import ListedColormap, Normalize

    colours = ListedColormap(matplotlib.colormaps["cividis"](np.linspace(0.0, PALE_END, 256)))
    image = np.ma.masked_invalid(fraction)
    edges = [_cell_edges(axis) for axis in scan.axes]
    ax.fill_between(
        edges[0][[0, -1]], *edges[1][[0, -1]], facecolor="white", edgecolor="0.6", hatch="////", linewidth=0, zorder=0
    )
    cells = ax.pcolormesh(*edges, image.T, cmap=colours, norm=Normalize(0.0, 1.0), rasterized=True)
    ax.set(ylabel=parameter_label(scan.names[1]))
    return cells, ax.figure.colorbar(cells, ax=ax, label="chaotic fraction of the section") if colorbar else None


def _cell_edges(axis: np.ndarray) -> np.ndarray:
    if axis.size == 1:
        return np.array([axis[0] - 0.5, axis[0] + 0.5])
    middle = (axis[1:] + axis[:-1]) / 2
    return np.concatenate([[2 * axis[0] - middle[0]], middle, [2 * axis[-1] - middle[-1]]])


def plot_history(
    chaos_map: ChaosMap,
    indicator: str,
    *,
    ax: Any,
    orbits: Sequence[int] | None = None,
    slopes: Sequence[float] = (),
    labels: bool = True,
) -> Artists:
    """Draw how an indicator of orbits changed in time, with power laws for comparison.

    Parameters: chaos_map: with a history; indicator: a name in chaos_map.names; orbits: numbers of those drawn
    (default: up to 40); slopes: exponents s of laws t^s, such as -2 (k - n) for GALI_k of regular orbits; labels: write
    the exponents beside their lines. Returns Artists: points are the curves, lines the laws. Time is logarithmic;
    indicators that are logarithms are drawn as such, not far below the limit (the dotted line). Regular orbits dark and
    solid, chaotic ones orange and thin, undecided ones dotted; `missing` counts orbits of the choice without a record.
    """
    if indicator not in chaos_map.names:
        raise ValueError(f"indicator must be one of {', '.join(chaos_map.names)}, got {indicator!r}")
    history, times = chaos_map.history[chaos_map.names.index(indicator)], chaos_map.history_times
    if not np.isfinite(history).any():
        raise ValueError(
            f"chaos_map has no history of {indicator}: call chaos_map(..., history=200) with an indicator of tangent "
            "vectors"
        )
    total = history.shape[1]
    chosen = (
        np.unique(np.linspace(0, total - 1, min(total, 40)).astype(int))
        if orbits is None
        else np.asarray(orbits, dtype=int)
    )
    curves, missing = [], 0
    for i in chosen:
        known = np.isfinite(history[:, i]) & (times[:, i] > 0)
        missing += not known.any()
        chaotic, doubt = bool(chaos_map.chaotic[i]), bool(chaos_map.undecided[i])
        style = {
            "color": "#b35900" if chaotic else "#00306f",
            "lw": 0.7 if chaotic else 1.1,
            "ls": ":" if doubt else "-",
        }
        curves += ax.plot(times[known, i], history[known, i], alpha=0.8, **style)
    ax.set_xscale("log")
    first, last = np.nanmin(np.where(times > 0, times, np.nan)), np.nanmax(times)
    drawn, written = [], []
    calm = history[:, chosen][:, ~chaos_map.chaotic[chosen]]
    start = float(np.nanmedian(calm[0])) if calm.size and np.isfinite(calm[0]).any() else float(np.nanmax(history[0]))
    for slope in slopes:
        end = start + slope * math.log10(last / first)
        drawn += ax.plot([first, last], [start, end], color="black", lw=1.2, ls=(0, (5, 2.5)), zorder=3)
        if labels:
            written.append(ax.text(last, end, rf"$t^{{{slope:g}}}$", va="bottom", ha="right", fontsize=9))
    limit = float(np.median(chaos_map.limits[chaos_map.names.index(indicator), chosen]))
    ax.set(xlabel="time $t$", ylabel=label_of(indicator))
    ax.axhline(limit, color="0.5", lw=0.8, ls=(0, (1, 1.5)))
    if (
        _falls(indicator) and ax.get_ylim()[0] < 1.5 * limit
    ):  # room for the laws: chaotic orbits fall by hundreds of decades
        ax.set_ylim(1.5 * limit, 0.05 * abs(limit))
    return Artists(curves, None, tuple(drawn), tuple(written), missing)
