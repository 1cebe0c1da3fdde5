"""Figures: sections, frequency maps and diffusion maps drawn on given axes.

Every function takes `ax=` and returns the artists it made. matplotlib is imported at the first call. Colours are
cividis, perceptually uniform and the same to people with any kind of colour vision, cut at its palest end so that no
point vanishes on white. Colour scales are clipped at the 5th and 95th percentile and say so by the arrows of the colour
bar.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..analysis.sections.energy_grid import EnergyGrid
from ..analysis.sections.energy_sample import Edge
from ..base.status import Status
from ..charts import ALPHA_BETA, Chart
from ..models.sections import BetaEquals, BetaTurning, Linear

SYMBOLS = {
    "alpha": r"\alpha",
    "beta": r"\beta",
    "eta": r"\eta",
    "gamma": r"\gamma",
    "phi": r"\varphi",
    "psi": r"\psi",
    "vartheta": r"\vartheta",
    "D1": "D_1",
    "D2": "D_2",
    "area": r"\mathrm{area}",
}
PALE_END = 0.93
DIFFUSION = r"diffusion  $\log_{10}|\Delta\nu|$"


class Artists(NamedTuple):
    """What a function drew: the points or cells, colour bar, lines with their labels, and the number of orbits not
    drawn.
    """

    points: Any
    colorbar: Any
    lines: tuple
    labels: tuple
    missing: int


def symbol(name: str) -> str:
    """Return the mathematical symbol, without dollars, of a coordinate, a momentum (p_...) or a frequency (nu_...)."""
    head, _, tail = name.partition("_")
    if tail and head in ("p", "nu"):
        return (r"\nu" if head == "nu" else "p") + f"_{{{SYMBOLS.get(tail, tail)}}}"
    return SYMBOLS.get(name, name)


def colour_map() -> Any:
    """Return cividis without its palest end."""
    import matplotlib
    from matplotlib.colors import ListedColormap

    colours = matplotlib.colormaps["cividis"](np.linspace(0.0, PALE_END, 256))
    return ListedColormap(colours, name="fastaff")


def clipped(values: Any) -> Any:
    """Return a colour scale from the 5th to the 95th percentile of the finite values, rounded outwards to halves."""
    from matplotlib.colors import Normalize

    finite = np.asarray(values)[np.isfinite(values)]
    low, high = np.quantile(finite, [0.05, 0.95]) if finite.size else (0.0, 1.0)
    low, high = math.floor(2 * low) / 2, math.ceil(2 * high) / 2
    return Normalize(low, high if high > low else low + 0.5)


def diffusion_scale(values: Any) -> Any:
    """Return `clipped(values)` with its upper end at -6 or above, so that rounding noise of regular orbits does not
    look like chaos.
    """
    from matplotlib.colors import Normalize

    scale = clipped(values)
    return Normalize(min(scale.vmin, -8.0), max(scale.vmax, -6.0))


def plot_section(
    section_map: Any,
    *,
    ax: Any,
    values: Any = None,
    x: str | None = None,
    y: str | None = None,
    chart: Chart = ALPHA_BETA,
    boundary: Edge | None = None,
    norm: Any = None,
    label: str = DIFFUSION,
    size: float | None = None,
    colorbar: bool = True,
) -> Artists:
    """Draw the crossings of a SectionMap in two coordinates, coloured by a value of each orbit.

    Parameters: values (orbits,), for example the diffusion of a frequency map, or None for one dark colour; x, y: names
    of coordinates of the chart or momenta (`p_beta`), x, y, p_x, p_y for two degrees of freedom; by default those free
    on the section; boundary: of `edge`; norm: a colour scale, by default `clipped(values)`; size: area of a point in
    square points. Returns Artists; `missing` counts orbits without a crossing or a value, which are not drawn.
    """
    names, coordinates = _section_coordinates(section_map, chart)
    default = _free_coordinate(section_map.section, names)
    x, y = x or default, y or f"p_{default}"
    for name in (x, y):
        if name not in names:
            raise ValueError(f"x and y must be among {', '.join(names)}, got {name!r}")
    u, v = coordinates[names.index(x)], coordinates[names.index(y)]
    each = np.zeros(u.shape[1]) if values is None else np.asarray(values, dtype=np.float64)
    if each.shape != u.shape[1:]:
        raise ValueError(f"values must have shape ({u.shape[1]},), one for each orbit, got {each.shape}")
    drawn = np.isfinite(each) & (section_map.counts > 0)
    u, v, c = u.T[drawn].ravel(), v.T[drawn].ravel(), np.repeat(each[drawn], len(u))
    kept = np.isfinite(u) & np.isfinite(v)
    # In an order without meaning, so that no kind of orbit covers another.
    order = np.random.default_rng(0).permutation(np.flatnonzero(kept))
    area = size if size is not None else float(np.clip(60000 / max(order.size, 1), 0.25, 9.0))
    colours = (
        {"color": "#00224e"} if values is None else {"c": c[order], "cmap": colour_map(), "norm": norm or clipped(each)}
    )
    points = ax.scatter(u[order], v[order], s=area, linewidths=0, rasterized=True, **colours)
    lines: tuple = ()
    if boundary is not None:
        loop = np.append(boundary.coordinate, boundary.coordinate[::-1])
        momenta = np.append(boundary.momentum, -boundary.momentum[::-1])
        lines = tuple(ax.plot(np.append(loop, loop[0]), np.append(momenta, momenta[0]), color="0.35", lw=0.8))
    ax.set(xlabel=f"${symbol(x)}$", ylabel=f"${symbol(y)}$")
    bar = None
    if colorbar and values is not None:
        bar = ax.figure.colorbar(points, ax=ax, label=label, extend="both")
    return Artists(points, bar, lines, (), int(np.count_nonzero(~drawn)))


def _section_coordinates(section_map: Any, chart: Chart) -> tuple[tuple[str, ...], np.ndarray]:
    """Return names and values (names, crossings, orbits) of all coordinates."""
    if len(section_map.points) == 8:
        return (*chart.names, *chart.momenta), section_map.coordinates(chart)
    return ("x", "y", "p_x", "p_y"), section_map.points


def _free_coordinate(section: Any, names: tuple[str, ...]) -> str:
    if isinstance(section, Linear) and len(names) == 4:
        return names[1] if section.normal[0] else names[0]
    chosen = "alpha" if isinstance(section, (BetaTurning, BetaEquals)) else "beta"
    return chosen if chosen in names else names[0]


def frequency(frequency_map: Any, name: str) -> np.ndarray:
    """Return one frequency (orbits,) of a map by name: a row of .names, `eta` or `gamma`; or a ratio of two:
    "beta/alpha".
    """
    numerator, slash, denominator = name.partition("/")
    if slash:
        with np.errstate(all="ignore"):
            return frequency(frequency_map, numerator) / frequency(frequency_map, denominator)
    if name in frequency_map.names:
        return frequency_map.nu[frequency_map.names.index(name)]
    if name in ("eta", "gamma") and frequency_map.nu_eta is not None:
        return frequency_map.nu_eta if name == "eta" else frequency_map.nu_gamma
    extra = ", eta, gamma" if frequency_map.nu_eta is not None else ""
    raise ValueError(f"frequency must be one of {', '.join(frequency_map.names)}{extra}, or a ratio a/b, got {name!r}")


def resonances_between(low: float, high: float, max_order: int) -> list[tuple[int, int, int]]:
    """Return the resonances m : n with low < m/n < high as lines (n, 0, -m) of a frequency map, of order m + n at
    most.
    """
    found = [
        (n, 0, -m)
        for n in range(1, max_order)
        for m in range(1, max_order - n + 1)
        if math.gcd(m, n) == 1 and low < m / n < high
    ]
    return sorted(found, key=lambda k: k[0] - k[2])


def on_line(frequency_map: Any, line: Sequence[int], *, x: str, y: str, tolerance: float, shown: Any = True) -> int:
    """Count the orbits, of those shown, with |k1 X + k2 Y + k0| < tolerance for the line (k1, k2, k0) of a map's
    plane.
    """
    X, Y = frequency(frequency_map, x), frequency(frequency_map, y)
    with np.errstate(all="ignore"):
        return int(np.count_nonzero((np.abs(line[0] * X + line[1] * Y + line[2]) < tolerance) & shown))


def plot_frequency_map(
    frequency_map: Any,
    *,
    ax: Any,
    x: str | None = None,
    y: str | None = None,
    values: Any = None,
    lines: Sequence[Sequence[int]] = (),
    shown: Any = None,
    norm: Any = None,
    label: str = DIFFUSION,
    size: float | None = None,
    colorbar: bool = True,
    limits: tuple | None = None,
) -> Artists:
    """Draw orbits in the plane of two frequencies, or ratios of frequencies, with resonance lines.

    Parameters: x, y: names or ratios such as "beta/alpha", by default second row and gamma to the first row for a body,
    else the two rows; values: colours (orbits,), by default the map's diffusion on a `diffusion_scale`; lines: integers
    (k1, k2, k0), each for k1 X + k2 Y + k0 = 0, where X and Y are ratios to one frequency: a resonance k . nu = 0;
    shown: a mask of orbits; limits: (x0, x1), (y0, y1). Returns Artists; `missing` counts orbits that are not OK or not
    shown. Vertical lines n X = m are labelled m:n above the frame, the others by their equation; a label without room
    is left out, its line is drawn.
    """
    names = frequency_map.names
    body = frequency_map.nu_eta is not None
    if x is None and y is None and not body:
        x, y = names[0], names[1]
    x, y = x or f"{names[1]}/{names[0]}", y or f"gamma/{names[0]}"
    X, Y = frequency(frequency_map, x), frequency(frequency_map, y)
    c = np.asarray(frequency_map.diffusion if values is None else values, dtype=np.float64)
    good = (frequency_map.status == Status.OK) & np.isfinite(X) & np.isfinite(Y) & np.isfinite(c)
    good &= np.ones(good.shape, bool) if shown is None else np.asarray(shown)
    order = np.random.default_rng(0).permutation(np.flatnonzero(good))
    area = size if size is not None else float(np.clip(24000 / max(order.size, 1), 1.2, 16.0))
    points = ax.scatter(
        X[order],
        Y[order],
        c=c[order],
        s=area,
        linewidths=0,
        rasterized=True,
        cmap=colour_map(),
        norm=norm or _scale(c, values),
        zorder=2,
    )
    if limits is not None:
        ax.set(xlim=limits[0], ylim=limits[1])
    ax.set(xlabel=f"${_fraction(x)}$", ylabel=f"${_fraction(y)}$")
    if "/" not in x:
        ax.set(xlabel=f"${_fraction(x)}$  (cycles per unit time)", ylabel=f"${_fraction(y)}$  (cycles per unit time)")
    drawn, labels = _draw_lines(ax, lines, x, y)
    bar = ax.figure.colorbar(points, ax=ax, label=label, extend="both") if colorbar else None
    return Artists(points, bar, drawn, labels, int(np.count_nonzero(~good)))


def _scale(c: np.ndarray, given: Any) -> Any:
    return diffusion_scale(c) if given is None else clipped(c)


def _fraction(name: str) -> str:
    numerator, slash, denominator = name.partition("/")
    top = symbol(f"nu_{numerator}")
    return rf"{top}/{symbol(f'nu_{denominator}')}" if slash else top


def _draw_lines(ax: Any, lines: Sequence[Sequence[int]], x: str, y: str) -> tuple[tuple, tuple]:
    """Draw k1 X + k2 Y + k0 = 0 inside the present limits, lowest orders first; label those with room."""
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    drawn: list[Any] = []
    labels: list[Any] = []
    taken: list[float] = []
    for k1, k2, k0 in sorted((tuple(line) for line in lines), key=lambda k: sum(map(abs, k))):
        order = abs(k1) + abs(k2) + abs(k0)
        style = {"color": "0.25", "lw": float(np.clip(6.0 / order, 0.5, 1.1)), "zorder": 1, "alpha": 0.75}
        if k2 == 0 and k1:
            at = -k0 / k1
            if not x0 < at < x1:
                continue
            drawn.append(ax.axvline(at, **style))
            place = (at - x0) / (x1 - x0)
            if all(abs(place - other) > 0.075 for other in taken):
                taken.append(place)
                labels.append(
                    ax.text(place, 1.012, f"{-k0}:{k1}", transform=ax.transAxes, ha="center", va="bottom", fontsize=8)
                )
        elif k2:
            ends = [(u, -(k1 * u + k0) / k2) for u in np.linspace(x0, x1, 200)]
            inside = [(u, v) for u, v in ends if y0 < v < y1]
            if len(inside) < 2:
                continue
            style.update(ls=(0, (4, 2.5)))
            drawn += ax.plot(*np.array([inside[0], inside[-1]]).T, **style)
            labels.append(_label_along(ax, inside, _equation((k1, k2, k0), x, y)))
    ax.set(xlim=(x0, x1), ylim=(y0, y1))
    return tuple(drawn), tuple(labels)


def _label_along(ax: Any, inside: list, text: str) -> Any:
    """Write a line's equation along it, a little below its upper end."""
    (u0, v0), (u1, v1) = inside[int(0.70 * len(inside))], inside[int(0.72 * len(inside)) + 1]
    return ax.text(
        u0,
        v0,
        text,
        fontsize=8,
        ha="center",
        va="bottom",
        rotation=math.degrees(math.atan2(v1 - v0, u1 - u0)),
        rotation_mode="anchor",
        transform_rotates_text=True,
    )


def _equation(line: tuple[int, int, int], x: str, y: str) -> str:
    """Return k1 a + k2 b + k0 c = 0 with the terms on the side where they are positive."""
    a, _, c = x.partition("/")
    terms = [(line[0], a), (line[1], y.partition("/")[0]), (line[2], c)]
    sides = []
    for sign in (1, -1):
        side = "+".join(
            (str(abs(k)) if abs(k) != 1 or not name else "") + (symbol(f"nu_{name}") if name else "")
            for k, name in terms
            if k * sign > 0
        )
        sides.append(side or "0")
    return f"${sides[0]}={sides[1]}$"


def plot_diffusion_grid(
    grid: EnergyGrid, values: Any, *, ax: Any, norm: Any = None, label: str = DIFFUSION, colorbar: bool = True
) -> Artists:
    """Draw values (orbits,) of the orbits of a Grid, such as a map's diffusion, as an image over its two coordinates.

    Cells that the energy does not reach stay white. Returns Artists; `missing` counts cells whose value is not finite.
    """
    each = np.asarray(values, dtype=np.float64)
    if each.shape != grid.cell.shape:
        raise ValueError(f"values must have shape {grid.cell.shape}, one for each orbit of the grid, got {each.shape}")
    image = np.ma.masked_invalid(grid.spread(each))
    cells = ax.pcolormesh(
        *grid.axes, image.T, cmap=colour_map(), norm=norm or clipped(each), rasterized=True, shading="nearest"
    )
    ax.set(xlabel=f"${symbol(grid.names[0])}$", ylabel=f"${symbol(grid.names[1])}$")
    bar = ax.figure.colorbar(cells, ax=ax, label=label, extend="both") if colorbar else None
    return Artists(cells, bar, (), (), int(np.count_nonzero(~np.isfinite(each))))
