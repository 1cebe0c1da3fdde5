"""Figures of resonances: webs over a grid and in the plane of frequency ratios, histograms of diffusion.

As in `fastaff.plot`, every function takes `ax=` and returns the artists it made.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..frequencies.resonance_web import ResonanceLine
from ..frequencies.resonances import DiffusionHistogram, Resonances, relation
from ..sections.energy_grid import EnergyGrid
from .labels import LabelBox, drawn_points, pixel_length, settled, write_along
from .picking import carry
from .scales import DIFFUSION, clipped
from .sections import above_frame
from .style import Artists, Palette, figure, nothing, symbol

FEW = 3
"""Resonances without room for their names that a legend names."""

MARKS = "s^Dv"
"""Symbols of resonances that have locked starts but no line, one each, those with most starts first, the last for all
others.
"""

WHOLE = 0.5
"""Share of the grid from which a resonance is no island but holds everywhere."""


def formula(vector: Sequence[int], names: Sequence[str], letter: str = "") -> str:
    """Return k . nu = 0 for a label: 3 nu_x - 2 nu_y = 0; of tunes 2 Q_x - Q_y = 1. letter: instead of these."""
    terms, right, usual = relation(vector, names)
    text = "".join(
        f"{'-' if c < 0 else '+'}{abs(c) if abs(c) > 1 else ''}{symbol(f'{letter or usual}_{name}')}"
        for c, name in terms
    )
    return f"${text.removeprefix('+') or 0}={right}$"


@figure
@inserts_parameters
def plot_web(
    lines: Sequence[ResonanceLine],
    *,
    ax: Any = None,
    names: Sequence[str] | None = None,
    axes: Sequence[Any] | EnergyGrid | None = None,
    labels: int = 8,
    dots: bool = True,
) -> Artists:
    """Plot the resonance lines of a web over a grid, lines of low order thicker.

    Parameters
    ----------
    lines : sequence of ResonanceLine
        Lines of `resonance_web`. They are drawn white with a dark casing.
    {ax}
    names : sequence of str, optional
        Names of the frequencies. Default: the names that the lines have, else numbers.
    axes : sequence of array_like or EnergyGrid, optional
        Axes of the grid. Default: the axes of the lines.
    labels : int, default 8
        Number of resonances to label, the longest lines first.
    dots : bool, default True
        Mark the grid points that are trapped in a resonance, for resonances that do not hold everywhere. Resonances
        without a line have symbols of their own.

    Returns
    -------
    Artists
        ``points`` are the dots, or None. ``missing`` is 0. A legend above the frame explains dots and symbols, and
        lists lines without room for a label.

    Examples
    --------
    >>> axes = np.linspace(0.2, 0.4, 9), np.linspace(0.21, 0.43, 9)
    >>> lines = fa.resonance_web(np.array(np.meshgrid(*axes)), axes=axes, max_order=2)
    >>> len(fa.plot.plot_web(lines, names=("x", "y")).labels)
    1
    """
    drawn: list[Any] = []
    over: Any = axes
    marked = None
    coordinates: tuple[str, ...] = ()
    for line in lines:
        for part in line.lines:
            drawn += ax.plot(*part.T, **_style(line.order))
        if dots and line.locked is not None and line.locked.any() and line.lines:
            marked = line.locked if marked is None else marked | line.locked
        if over is None:
            over = line.axes
            coordinates = line.coordinates
    if isinstance(axes, EnergyGrid):
        over = axes.axes
        coordinates = axes.names
    said = f"{0 if marked is None else marked.sum()} orbits trapped in a resonance that is drawn"
    points = _mark(ax, marked, over, said) if marked is not None else None
    if not ax.get_xlabel():
        words = [f"${symbol(name)}$" for name in coordinates] or [
            "first coordinate of the grid",
            "second coordinate of the grid",
        ]
        ax.set(xlabel=words[0], ylabel=words[1])
    written, left = _named(ax, lines, names, labels)
    key = [points] if points is not None else []
    key += _islands(ax, lines, names, over) if dots else []
    if left:
        few = ", ".join(left) if len(left) <= FEW else f"{len(left)} resonances without room for a name"
        key += ax.plot([], [], label=few, **_style(4))
    if key:
        above_frame(ax, key)
    return Artists(points, None, tuple(drawn), written, 0)


@figure
@inserts_parameters
def plot_ratio_web(
    lines: Sequence[ResonanceLine],
    *,
    ax: Any = None,
    names: Sequence[str],
    nu: Any = None,
    values: Any = None,
    norm: Any = None,
    label: str = DIFFUSION,
    labels: int = 8,
) -> Artists:
    """Plot the resonance lines of a web in the plane of two frequency ratios, over the orbits of a map.

    Parameters
    ----------
    lines : sequence of ResonanceLine
        Lines of `ratio_web`.
    {ax}
    names : sequence of str
        Names of the three frequencies.
    nu : array_like, shape (3, ...), optional
        Frequencies of orbits, drawn at (nu1/nu3, nu2/nu3).
    values : array_like, optional
        Value of each orbit, of the shape of a row of `nu`, for example the diffusion. Default: one colour.
    {norm}
    label : str, optional
        Label of the colour bar. Default: the diffusion.
    labels : int, default 8
        Number of lines to label.

    Returns
    -------
    Artists
        ``missing`` is the number of orbits that are not finite.

    Examples
    --------
    >>> lines = fa.frequencies.ratio_web(x=(0.6, 1.4), y=(0.7, 1.2), max_order=2)
    >>> fa.plot.plot_ratio_web(lines, names=("x", "y", "z"), nu=[[0.2, 0.25], [0.21, 0.2], [0.22, 0.23]]).missing
    0
    """
    drawn = [ax.plot(*part.T, **_style(line.order))[0] for line in lines for part in line.lines]
    palette = Palette.of(ax)
    points = bar = None
    missing = 0
    if nu is not None:
        with np.errstate(all="ignore"):
            flat = np.asarray(nu, dtype=np.float64).reshape(3, -1)
            x, y = flat[0] / flat[2], flat[1] / flat[2]
        each = np.zeros(x.size) if values is None else np.asarray(values, dtype=np.float64).ravel()
        if each.size != x.size:
            raise ValueError(f"values must have {x.size} entries, one for each orbit, got {each.size}")
        kept = np.isfinite(x) & np.isfinite(y) & np.isfinite(each)
        missing = int(np.count_nonzero(~kept))
        colours = (
            {"color": palette.main}
            if values is None
            else {"c": each[kept], "cmap": palette.colour_map(), "norm": norm or clipped(each)}
        )
        limits = (ax.get_xlim(), ax.get_ylim())
        points = ax.scatter(x[kept], y[kept], s=5, linewidths=0, zorder=3, rasterized=True, **colours)
        carry(points, x[kept], y[kept], np.flatnonzero(kept))
        ax.set(xlim=limits[0], ylim=limits[1])
        bar = None if values is None else ax.figure.colorbar(points, ax=ax, label=label, extend="both")
    top, left, below = (symbol(f"nu_{name}") for name in (names[0], names[1], names[2]))
    ax.set(xlabel=f"${top}/{below}$", ylabel=f"${left}/{below}$")
    return Artists(points, bar, tuple(drawn), _named(ax, lines, names, labels)[0], missing)


@figure
@inserts_parameters
def plot_diffusion_histogram(histogram: DiffusionHistogram, *, ax: Any = None, label: str = DIFFUSION) -> Artists:
    """Plot a histogram of frequency diffusion, with the fraction above its threshold.

    Parameters
    ----------
    histogram : DiffusionHistogram
        Result of `diffusion_histogram`.
    {ax}
    label : str, optional
        Label of the abscissa. Default: the diffusion.

    Returns
    -------
    Artists
        ``points`` are the bars, those above the threshold in a second colour, ``lines`` the threshold and ``labels``
        the fraction. ``missing`` is the number of the histogram.

    Examples
    --------
    >>> histogram = fa.frequencies.diffusion_histogram([-9.0, -8.0, -3.0, np.nan])
    >>> fa.plot.plot_diffusion_histogram(histogram).missing
    1
    """
    edges = histogram.edges
    counts = histogram.counts
    threshold = histogram.threshold
    palette = Palette.of(ax)
    colours = [palette.accent if middle > threshold else palette.main for middle in (edges[:-1] + edges[1:]) / 2]
    fill = {"color": colours, "linewidth": 0.3, "edgecolor": palette.ground}
    bars = ax.bar(edges[:-1], counts, width=np.diff(edges), align="edge", **fill)
    line = ax.axvline(threshold, color=palette.grey(0.2), lw=1.0, ls=(0, (4, 2)))
    ax.set(xlabel=label, ylabel="orbits", ylim=(0, 1.18 * max(1, counts.max())))
    text = ax.text(
        0.03,
        0.97,
        rf"above ${threshold:g}$: ${100 * histogram.fraction:.1f}\pm{100 * histogram.error:.1f}$ %",
        transform=ax.transAxes,
        ha="left",
        va="top",
        fontsize=9,
        color=palette.accent,
    )
    return Artists(bars, None, (line,), (text,), histogram.missing)


def _style(order: int) -> dict[str, Any]:
    """White with a dark casing, visible on both ends of cividis and on any ground."""
    from matplotlib.patheffects import Normal, Stroke

    width = float(np.clip(8.0 / order, 0.6, 1.4))
    casing = [Stroke(linewidth=width + 1.2, foreground="black"), Normal()]
    return {"color": "white", "lw": width, "zorder": 2, "solid_capstyle": "butt", "path_effects": casing}


def _mark(ax: Any, marked: np.ndarray, axes: Sequence[Any], said: str, marker: str = "o") -> Any:
    """Mark the grid points of a mask (n1, n2)."""
    first, second = axes if axes is not None and len(axes) else [np.arange(m) for m in marked.shape]
    i, j = np.nonzero(marked)
    x, y = np.asarray(first)[i], np.asarray(second)[j]
    style = {"color": "white", "edgecolor": "black", "linewidths": 0.5, "zorder": 2, "rasterized": True}
    return ax.scatter(x, y, s=6 if marker == "o" else 14, label=said, marker=marker, **style)


def _islands(ax: Any, lines: Sequence[ResonanceLine], names: Sequence[str] | None, axes: Any) -> list[Any]:
    """Mark the starts that are locked in resonances without a line: islands too small for one."""
    alone = [(_name(line, names), line.locked) for line in lines if not line.lines and line.locked is not None]
    alone = sorted((e for e in alone if 0 < e[1].mean() < WHOLE), key=lambda entry: -int(entry[1].sum()))
    own = len(alone) if len(alone) <= len(MARKS) else len(MARKS) - 1
    marked = alone[:own]
    if more := [locked for _, locked in alone[own:]]:
        marked.append((f"{len(more)} resonances more", np.any(more, axis=0)))
    places = zip(marked, MARKS, strict=False)
    return [_mark(ax, where, axes, f"{said}: {where.sum()} starts", mark) for (said, where), mark in places]


def _name(line: ResonanceLine, names: Sequence[str] | None) -> str:
    return formula(line.vector, names or line.names or [f"{k + 1}" for k in range(len(line.vector))])


def _named(
    ax: Any, lines: Sequence[ResonanceLine], names: Sequence[str] | None, most: int
) -> tuple[tuple[Any, ...], list[str]]:
    """Name the longest lines, each on its longest part, as many as have room; return the texts, and the other names."""
    settled(ax)
    plate = Palette.of(ax).plate
    dots = drawn_points(ax)
    taken: list[LabelBox] = []
    written: list[Any] = []
    left: list[str] = []
    parts = [(max(pixel_length(ax, part) for part in line.lines), line) for line in lines if line.lines]
    for _, line in sorted(parts, key=lambda entry: (-entry[0], entry[1].order)):
        name = _name(line, names)
        left.append(name)
        for part in sorted(line.lines, key=lambda part: -pixel_length(ax, part)) if len(written) < most else ():
            text = write_along(ax, part, name, taken, points=dots, zorder=4, bbox=plate)
            if text is not None:
                written.append(text)
                left.pop()
                break
    return tuple(written), left


@figure
@inserts_parameters
def plot_resonances(resonances: Resonances, *, ax: Any = None, most: int = 12) -> Artists:
    """Plot the number of orbits of each resonance module, the frequent ones on top.

    Parameters
    ----------
    resonances : Resonances
        Result of `resonances`.
    {ax}
    most : int, default 12
        Number of modules to draw.

    Returns
    -------
    Artists
        ``points`` are the bars, ``labels`` the numbers beside them. ``missing`` is the number of orbits that are not
        ``OK``.

    Examples
    --------
    >>> found = fa.resonances([[0.2, 0.1], [0.4, 0.2], [0.3137, 0.2719]], max_order=4)
    >>> [text.get_text() for text in fa.plot.plot_resonances(found).labels]
    ['2']
    """
    rows = resonances.table()[:most]
    text = [" and ".join(formula(k, resonances.names) for k in basis) or "none" for basis, _ in rows]
    counts = [count for _, count in rows]
    palette = Palette.of(ax)
    colours = [palette.main if basis else palette.lost for basis, _ in rows]
    bars = ax.barh(np.arange(len(rows)), counts, color=colours, height=0.7)
    if not rows:
        nothing(ax, "no orbit has frequencies")
    labels = ax.bar_label(bars, fontsize=8, padding=2)
    ax.set_yticks(np.arange(len(rows)), labels=text)
    ax.invert_yaxis()
    ax.set(xlabel="orbits", ylabel="resonance", xlim=(0, 1.12 * max(counts, default=1)))
    return Artists(bars, None, (), tuple(labels), int(np.count_nonzero(resonances.status)))
