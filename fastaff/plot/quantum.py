"""Figures of quantum levels and states: level diagrams, spectra of whole bodies, degeneracies, densities.

As in `fastaff.plot`, every function takes `ax=` and returns the artists it made. Curves differ in line style too where
colours tell them apart; colours are cividis, or a few that differ by lightness too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..quantum.spectra.level_diagram import Curve, LevelDiagram
from ..quantum.states.level_table import VIBRATION, LevelTable
from ..quantum.states.state import State
from ..quantum.states.vibration_state import VibrationState
from ..sections.accessible_box import potential_of
from ..systems.charts import ALPHA_BETA, R_VARTHETA, TWO_POLAR, Chart
from .parameters import parameter_label
from .style import Artists, Palette, figure, symbol

ENERGY = "energy $E$"
NEGLIGIBLE = 1e-3
"""Probability beyond either end of the frame of a density."""

TINY = 1e-12
"""Offset that keeps the edge of a chart free of curves."""

CHARTS = (ALPHA_BETA, R_VARTHETA, TWO_POLAR)


def quantum_label(name: str) -> str:
    """Return the label of the abscissa of a diagram: m, l, or a parameter."""
    known = {"m": r"spin $m$  (units of $\hbar$)", "l": r"vorticity $l$  (units of $\hbar$)"}
    return known.get(name) or parameter_label(name)


@figure
@inserts_parameters
def plot_levels(
    diagram: LevelDiagram,
    *,
    ax: Any = None,
    unit: ArrayLike = 1.0,
    ylabel: str = ENERGY,
    numbers: bool = True,
    marker: str | None = None,
) -> Artists:
    """Plot levels against a parameter, or against m or l, as curves with their crossings.

    Parameters
    ----------
    diagram : LevelDiagram
        Result of `level_diagram` or `class_diagram`.
    {ax}
    unit : float or array_like, shape (points,), default 1
        Divisor of the energies, for example hbar omega. State it in `ylabel`.
    ylabel : str, optional
        Label of the ordinate. Default: the energy.
    numbers : bool, default True
        Write the quantum numbers at the right ends of the curves.
    marker : str, optional
        Marker of the points. Default: dots if the abscissa has integers only.

    Returns
    -------
    Artists
        ``points`` are the curves, ``labels`` the quantum numbers. ``lines`` is the grey region above the highest level
        computed, of the class with the lowest of these, in which curves would be missing. ``missing`` is the number of
        curves entirely in that region.

    Notes
    -----
    Curves of one class of a separable body are coloured by the second quantum number, several classes by class.

    Examples
    --------
    >>> diagram = fa.quantum.level_diagram(lambda C: fa.Body(fa.Harmonic(C)), [1.0, 4.0], m=0, l=0, count=2, name="C")
    >>> len(fa.plot.plot_levels(diagram).points)
    2
    """
    order = np.argsort(diagram.values, kind="stable")
    x = diagram.values[order]
    scale = np.broadcast_to(np.asarray(unit, float), diagram.values.shape)[order]
    top = diagram.E[order, :, -1].min(axis=1) / scale
    palette = Palette.of(ax)
    drawn: list[Any] = []
    ends = []
    missing = 0
    seen = set()
    for curve in diagram.curves():
        E = curve.E[order] / scale
        inside = np.isfinite(E) & (top * (1 + 1e-12) >= E)
        if not inside.any():
            missing += 1
            continue
        colour, style, label = _look(palette.curves, diagram, curve)
        drawn += ax.plot(
            x,
            np.where(inside, E, np.nan),
            color=colour,
            ls=style,
            lw=1.2,
            ms=3.5,
            marker=marker or ("o" if diagram.name in ("m", "l") else None),
            label=None if label in seen else label,
        )
        seen.add(label)
        if inside[-1]:
            ends.append((float(E[-1]), ",".join(map(str, curve.label)), colour))
    low = float(np.nanmin(diagram.E[order, :, 0] / scale[:, None]))
    high = float(np.nanmax(top))
    room = 0.04 * (high - low) if high > low else 0.5
    ax.set(xlabel=quantum_label(diagram.name), ylabel=ylabel, ylim=(low - room, high + room))
    unknown = ax.fill_between(x, top, high + room, color=palette.shade, linewidth=0, zorder=0)
    if diagram.name in ("m", "l"):
        ax.xaxis.get_major_locator().set_params(integer=True)
    written = _written(ax, ends, diagram) if numbers else ()
    if seen - {None}:
        ax.legend(
            frameon=False,
            fontsize=8,
            loc="lower left",
            bbox_to_anchor=(-0.01, 0.995),
            ncols=8,
            handlelength=2.2,
            columnspacing=1.0,
            borderpad=0.2,
            title=_legend_title(diagram),
            title_fontsize=8,
            alignment="left",
        )
    return Artists(drawn, None, (unknown,), written, missing)


def _look(looks: Sequence[Any], diagram: LevelDiagram, curve: Curve) -> tuple[Any, Any, str | None]:
    """Return colour, line style and legend of a curve."""
    if diagram.m.shape[1] > 1:
        colour, style = looks[curve.column % len(looks)]
        return colour, style, f"({diagram.m[0, curve.column]}, {diagram.l[0, curve.column]})"
    if len(diagram.names) == 1:
        return looks[0][0], "-", None
    colour, style = looks[curve.label[1] % len(looks)]
    return colour, style, str(curve.label[1])


def _legend_title(diagram: LevelDiagram) -> str:
    if diagram.m.shape[1] > 1:
        return "class $(m, l)$"
    return f"$n_{{{symbol(diagram.names[1])}}}$"


def _written(ax: Any, ends: list[tuple[float, str, Any]], diagram: LevelDiagram) -> tuple[Any, ...]:
    """Write the quantum numbers beside the right ends of the curves, lowest first, where there is room, and their names
    above them.
    """
    low, high = ax.get_ylim()
    least = 0.03 * (high - low)
    texts = []
    last = -math.inf
    for E, text, colour in sorted(ends, key=lambda end: end[0]):
        if E - last > least and high > E:
            texts.append(_beside(ax, 1.008, E, text, color=colour, transform=ax.get_yaxis_transform(), va="center"))
            last = E
    names = (
        "number" if len(diagram.names) == 1 else "$" + ",".join(f"n_{{{symbol(name)}}}" for name in diagram.names) + "$"
    )
    texts.append(_beside(ax, 1.0, 1.008, names, transform=ax.transAxes, va="bottom"))
    return tuple(texts)


def _beside(ax: Any, x: float, y: float, text: str, **style: Any) -> Any:
    return ax.text(x, y, text, fontsize=7.5, ha="left", **style)


@figure
@inserts_parameters
def plot_spectrum(
    levels: LevelTable, *, ax: Any = None, unit: float = 1.0, ylabel: str = ENERGY, colorbar: bool = True
) -> Artists:
    """Plot the levels of many symmetry classes as short lines over their spin m.

    Parameters
    ----------
    levels : LevelTable
        Levels of `all_levels` or `level_list`. Levels of a vibration, which has no spin, are drawn as lines alone.
    {ax}
    unit : float, default 1
        Divisor of the energies, for example hbar omega. State it in the label of the axis.
    ylabel : str, optional
        Label of the ordinate. Default: the energy.
    colorbar : bool, default True
        Draw a colour bar of ``|l|``.

    Returns
    -------
    Artists
        ``points`` are the lines, coloured by ``|l|`` and wider for smaller ``|l|`` so that none is hidden. ``missing``
        is 0.

    Examples
    --------
    >>> levels = fa.quantum.all_levels(fa.Body(fa.Harmonic()), multiplets=3)
    >>> fa.plot.plot_spectrum(levels).missing
    0
    """
    from matplotlib.collections import LineCollection
    from matplotlib.colors import BoundaryNorm, ListedColormap

    size = int(np.abs(levels.l).max(initial=0))
    order = np.argsort(np.abs(levels.l), kind="stable")
    m = levels.m[order]
    E = levels.E[order] / unit
    vorticity = np.abs(levels.l[order])
    half = 0.46 - 0.3 * vorticity / max(size, 1)
    colours = ListedColormap(Palette.of(ax).cividis(np.linspace(0.0, 0.9, size + 1)), name="fastaff_quanta")
    segments: Any = np.stack([np.stack([m - half, E], 1), np.stack([m + half, E], 1)], 1)
    lines = LineCollection(
        segments, array=vorticity, cmap=colours, norm=BoundaryNorm(np.arange(size + 2) - 0.5, size + 1), linewidths=1.3
    )
    ax.add_collection(lines)
    ax.autoscale()
    if VIBRATION in levels.method:
        ax.set(xticks=[], ylabel=ylabel)
        return Artists(lines, None, (), (), 0)
    ax.set(xlabel=quantum_label("m"), ylabel=ylabel)
    ax.xaxis.get_major_locator().set_params(integer=True)
    step = max(1, -(-(size + 1) // 12))
    bar = (
        ax.figure.colorbar(lines, ax=ax, label=r"$|l|$  (units of $\hbar$)", ticks=np.arange(0, size + 1, step))
        if colorbar
        else None
    )
    return Artists(lines, bar, (), (), 0)


@figure
@inserts_parameters
def plot_degeneracies(levels: LevelTable, *, ax: Any = None, unit: float = 1.0, xlabel: str = ENERGY) -> Artists:
    """Plot the number of levels of each multiplet against its energy.

    Parameters
    ----------
    levels : LevelTable
        Levels of `all_levels` or `level_list`.
    {ax}
    unit : float, default 1
        Divisor of the energies, for example hbar omega. State it in the label of the axis.
    xlabel : str, optional
        Label of the abscissa. Default: the energy.

    Returns
    -------
    Artists
        ``points`` are the dots, ``lines`` their stems. ``missing`` is 0.

    Examples
    --------
    >>> levels = fa.quantum.all_levels(fa.Body(fa.Harmonic()), multiplets=3)
    >>> drawn = fa.plot.plot_degeneracies(levels)
    >>> drawn.points.get_offsets().data.round(9).tolist()
    [[2.0, 1.0], [3.0, 4.0], [4.0, 10.0]]
    """
    gathered = levels.multiplets()
    E = gathered.E / unit
    degeneracy = gathered.degeneracy
    palette = Palette.of(ax)
    stems = ax.vlines(E, 0, degeneracy, color=palette.pale, lw=0.9)
    dots = ax.scatter(E, degeneracy, s=12, color=palette.main, zorder=3)
    ax.set(xlabel=xlabel, ylabel="degeneracy", ylim=(0, 1.08 * max(int(degeneracy.max(initial=1)), 1)))
    ax.yaxis.get_major_locator().set_params(integer=True)
    return Artists(dots, None, (stems,), (), 0)


@figure
@inserts_parameters
def plot_density(
    state: State | VibrationState,
    *,
    ax: Any = None,
    model: Any = None,
    chart: Chart | None = None,
    limits: Sequence[Any] | None = None,
    points: int = 241,
    norm: Any = None,
    colorbar: bool = True,
) -> Artists:
    """Plot the probability density of a state over two deformation invariants or coordinates.

    Parameters
    ----------
    state : State or VibrationState
        State of `wavefunction` or ``LevelTable.state``. A vibration is drawn over its two coordinates.
    {ax}
    model : model, optional
        Model of the state, to draw the classical turning curve: V + hbar^2 (a^2/alpha^2 + b^2/beta^2)/(2 mu) = E for a
        body, V = E for a vibration.
    chart : Chart, optional
        Coordinates of a body: `ALPHA_BETA`, `R_VARTHETA` or `TWO_POLAR`. Default: the chart of the state. Not supported
        for vibrations.
    limits : tuple, optional
        Limits (x0, x1), (y0, y1) of the axes. Default: all but a thousandth of the probability at either end, with the
        accessible region of the body if it is bounded.
    points : int, default 241
        Number of points along each axis.
    {norm}
    {colorbar}

    Returns
    -------
    Artists
        ``points`` is the image. ``lines`` are the turning curve (white) and the boundary det phi = 0 (dashed, if it is
        in the frame). ``missing`` is 0.

    Raises
    ------
    ValueError
        If the chart is not supported.

    Notes
    -----
    The density is per unit of both coordinates. Its integral is 1.

    Examples
    --------
    >>> body = fa.Body(fa.Harmonic())
    >>> drawn = fa.plot.plot_density(fa.quantum.wavefunction(body, m=1, l=1, n=(1, 0)), model=body, points=41)
    >>> drawn.points.get_array().shape
    (41, 41)
    """
    if isinstance(state, VibrationState):
        return _vibration(state, ax, model, limits, points, norm, colorbar)
    chosen = chart or state.chart
    if getattr(chosen, "name", None) not in [known.name for known in CHARTS]:
        raise ValueError(
            f"chart must be {listed(known.name for known in CHARTS)}, got {shown(getattr(chosen, 'name', chosen))}"
        )
    (x0, x1), (y0, y1) = limits or _frame(state, chosen, model)
    x = np.linspace(x0, x1, points)
    y = np.linspace(y0, y1, points)
    X, Y = np.meshgrid(x, y)
    image = _image(ax, state.density(X, Y, chosen), x, y, norm)
    alpha, beta = _radii(chosen, X, Y)
    inside = (alpha >= 0) & (beta >= 0)
    lines = []
    if model is not None:
        if not hasattr(model, "potential"):
            raise TypeError(f"model must be the Body of the state, got {shown(model)}")
        left = np.where(inside, _left(model, state, alpha, beta), np.nan)
        lines.append(ax.contour(x, y, left, levels=[0.0], colors="white", linewidths=1.1))
    gap = alpha - beta  # 2 det phi/(alpha + beta)
    if gap.min() < 0 < gap.max():
        gap = np.where(inside, gap, np.nan)
        lines.append(ax.contour(x, y, gap, levels=[0.0], colors="white", linewidths=1.0, linestyles=[(0, (4, 3))]))
    _cased(lines)
    if not inside.all():
        ax.contour(x, y, np.minimum(alpha, beta), levels=[0.0], colors=[Palette.of(ax).grey(0.6)], linewidths=0.7)
    first, second = (f"${symbol(name)}$" for name in chosen.names[:2])
    ax.set(xlabel=first + _unit(chosen, 0), ylabel=second + _unit(chosen, 1), xlim=(x0, x1), ylim=(y0, y1))
    bar = ax.figure.colorbar(image, ax=ax, label=_per(first, second)) if colorbar else None
    return Artists(image, bar, tuple(lines), (), 0)


def _vibration(
    state: VibrationState, ax: Any, model: Any, limits: Any, points: int, norm: Any, colorbar: bool
) -> Artists:
    """Draw the density of a vibration of two coordinates, with the curve V = E."""
    lattice = state.lattice
    if len(lattice.names) != 2:
        raise ValueError(f"state must be of two coordinates to be drawn, got {listed(lattice.names)}")
    places = lattice.points(state.kept)
    whole = np.zeros(places.shape[1], bool)
    (x0, x1), (y0, y1) = limits or [_span(row, state.values**2, whole) for row in places]
    x = np.linspace(x0, x1, points)
    y = np.linspace(y0, y1, points)
    X, Y = np.meshgrid(x, y)
    image = _image(ax, state.density(np.array([X, Y])), x, y, norm)
    lines = []
    if model is not None:
        height = potential_of(model)(np.array([X, Y])) - state.energy
        lines.append(ax.contour(x, y, np.minimum(height, abs(state.energy)), [0.0], colors="white", linewidths=1.1))
    _cased(lines)
    first, second = (f"${symbol(name)}$" for name in lattice.names)
    ax.set(xlabel=first, ylabel=second, xlim=(x0, x1), ylim=(y0, y1))
    bar = ax.figure.colorbar(image, ax=ax, label=_per(first, second)) if colorbar else None
    return Artists(image, bar, tuple(lines), (), 0)


def _image(ax: Any, density: np.ndarray, x: np.ndarray, y: np.ndarray, norm: Any) -> Any:
    """Draw a density over even x and y as an image."""
    dx, dy = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
    return ax.imshow(
        density,
        extent=(x[0] - dx, x[-1] + dx, y[0] - dy, y[-1] + dy),
        origin="lower",
        aspect="auto",
        interpolation="bilinear",
        cmap=Palette.of(ax).image_map(),
        norm=norm,
        vmin=None if norm else 0.0,
    )


def _cased(lines: list[Any]) -> None:
    import matplotlib.patheffects as effects

    for line in lines:
        line.set(path_effects=[effects.withStroke(linewidth=2.4, foreground="black")])


def _per(first: str, second: str) -> str:
    return rf"probability density, per d{first}$\,$d{second}"


def _unit(chart: Chart, axis: int) -> str:
    return "  (radians)" if chart.names[axis] == "vartheta" else ""


def _radii(chart: Chart, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return alpha, beta of two invariants; negative ones are outside of the chart."""
    if chart.name == TWO_POLAR.name:
        return (x + y) / math.sqrt(2), (x - y) / math.sqrt(2)
    if chart.name == R_VARTHETA.name:
        rho = np.sqrt(np.maximum(x, 0.0))
        return rho * np.cos(y / 2), rho * np.sin(y / 2)
    return x, y


def _left(model: Any, state: Any, alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
    """Return a function that is negative where motion of the state's energy and angular momenta is allowed, positive
    elsewhere.

    It is bounded and, with the margin as a factor, goes through 0 at a wall too thin for the grid: its contours are
    smooth.
    """
    with np.errstate(all="ignore"):
        A = alpha**2
        B = beta**2
        margin = np.broadcast_to(model.potential.margin(A, B), A.shape)
        V = model.potential.value(A, B)
        for K, square in zip(state.symmetry.K, (A, B), strict=True):
            V = V + K * state.hbar**2 / (2 * model.mu * square) if K else V
        height = np.tanh((V - state.energy) / max(abs(state.energy), 1e-300))
        return np.where(margin > 0, np.where(np.isnan(height), 1.0, height) * margin, TINY - margin)


def _frame(state: Any, chart: Chart, model: Any) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the frame of nearly all of the probability, from its marginals on a grid of rho and vartheta, with the
    region that the energy allows to a body.
    """
    rho = np.geomspace(1e-3, 1e3, 1201)
    v = np.pi * (np.arange(181) + 0.5) / 181
    R, angle = np.meshgrid(rho, v, indexing="ij")
    near = state.density(rho[:, None] ** 2, v[::12], R_VARTHETA).sum(axis=1) * rho**2
    kept = near > 1e-12 * near.max()
    allowed = np.zeros(R.shape, bool)
    if hasattr(model, "potential"):
        allowed = _left(model, state, R * np.cos(angle / 2), R * np.sin(angle / 2)) < 0
        allowed &= ~allowed[-1].any()
    kept = kept | allowed.any(axis=1)
    allowed = allowed[kept]
    R = R[kept]
    angle = angle[kept]
    weight = state.density(R**2, angle, R_VARTHETA) * R**2
    alpha, beta = R * np.cos(angle / 2), R * np.sin(angle / 2)
    if chart.name == TWO_POLAR.name:
        pairs = ((alpha + beta) / math.sqrt(2), (alpha - beta) / math.sqrt(2))
    else:
        pairs = (R**2, angle) if chart.name == R_VARTHETA.name else (alpha, beta)
    (x0, x1), (y0, y1) = (_span(values, weight, allowed) for values in pairs)
    if chart.name == TWO_POLAR.name:
        return (x0, x1), (y0, y1)
    return (max(x0, 0.0), x1), (max(y0, 0.0), min(y1, math.pi) if chart.name == R_VARTHETA.name else y1)


def _span(values: np.ndarray, weight: np.ndarray, allowed: np.ndarray) -> tuple[float, float]:
    """Return the ends of the middle part of a distribution and of the allowed values, with a little room."""
    order = np.argsort(values, axis=None)
    share = np.cumsum(weight.ravel()[order])
    low, high = np.interp([NEGLIGIBLE, 1 - NEGLIGIBLE], share / share[-1], values.ravel()[order])
    low, high = (f(values, where=allowed, initial=end) for f, end in ((np.min, low), (np.max, high)))
    return float(low - 0.12 * (high - low)), float(high + 0.12 * (high - low))
