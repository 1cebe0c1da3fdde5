"""Marks of periodic orbits on sections, by stability, with their numbers of crossings and residues.

As in `fastaff.plot`, the function takes `ax=` and returns the artists it made. Kinds differ by shape and by lightness,
not by colour alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..periodic.found_orbits import PeriodicOrbits, Stability
from ..runs.coordinates import in_chart
from ..systems.charts import ALPHA_BETA, Chart
from .curves import above_rounding
from .one_variable import draw_diagonal, images, name_iterates
from .picking import carry
from .sections import free_rows, has_momenta
from .style import Artists, Palette, figure, symbol

STYLES = {
    Stability.ELLIPTIC: {"marker": "o", "mfc": "#e69f00", "mec": "black", "ms": 6.5, "mew": 0.9},
    Stability.PARABOLIC: {"marker": "s", "mfc": "white", "mec": "black", "ms": 5.5, "mew": 1.2},
    Stability.HYPERBOLIC: {"marker": "X", "mfc": "#d55e00", "mec": "white", "ms": 8.5, "mew": 0.9},
    Stability.INVERSE_HYPERBOLIC: {"marker": "D", "mfc": "#56b4e9", "mec": "black", "ms": 5.5, "mew": 0.9},
    Stability.COMPLEX: {"marker": "P", "mfc": "black", "mec": "white", "ms": 8.5, "mew": 0.9},
    Stability.ATTRACTING: {"marker": "v", "mfc": "#009e73", "mec": "black", "ms": 7.0, "mew": 0.9},
    Stability.SADDLE: {"marker": "d", "mfc": "#cc79a7", "mec": "black", "ms": 7.0, "mew": 0.9},
    Stability.REPELLING: {"marker": "^", "mfc": "#f0e442", "mec": "black", "ms": 7.0, "mew": 0.9},
}
"""The colours of Okabe & Ito 2008 (Color Universal Design), each with a shape of its own."""


@figure
@inserts_parameters
def plot_periodic(
    orbits: PeriodicOrbits,
    *,
    ax: Any = None,
    x: str | None = None,
    y: str | None = None,
    chart: Chart = ALPHA_BETA,
    labels: bool = True,
    legend: bool = True,
    fontsize: float = 8.0,
) -> Artists:
    """Plot the crossings of periodic orbits on a section, labelled by their number and residue or multiplier.

    Parameters
    ----------
    orbits : PeriodicOrbits
        Periodic orbits. Those that are not ``OK`` are not drawn.
    {ax}
    x, y : str, optional
        Names of the coordinates or momenta on the axes; for a body, those of `chart`. Default: the two that vary on the
        section. For a map of one variable, the second axis is the image.
    chart : Chart, default ALPHA_BETA
        Coordinates of a body.
    labels : bool, default True
        Write "crossings: residue", or without residues the largest multiplier, beside the crossing with most free
        space. Set the limits of the axes before the call, because the free space depends on them.
    legend : bool, default True
        Name the marks.
    fontsize : float, default 8
        Size of the labels in points.

    Returns
    -------
    Artists
        ``points`` are the marks, one artist for each kind of stability. ``lines`` are the diagonal and the cycles of a
        map of one variable. ``missing`` is the number of orbits not drawn. A click picks orbit and crossing.

    Raises
    ------
    ValueError
        If a name is unknown.

    Notes
    -----
    Filled circle: elliptic. Square: parabolic. Cross: hyperbolic. Diamond: inverse hyperbolic (with reflection). Plus:
    complex.

    References
    ----------
    Greene 1979, J. Math. Phys. 20, 1183 (residue); colours: Okabe & Ito 2008, Color Universal Design.

    Examples
    --------
    >>> orbit = fa.periodic_orbits(fa.HenonHeiles(), [0.0, 0.0, 0.3, 0.31], section="x=0", energy=0.1, max_time=20.0)
    >>> [text.get_text() for text in fa.plot.plot_periodic(orbit).labels]
    ['1: $-0.239$']
    """
    names, rows = _coordinates(orbits, chart)
    first, second = _free_pair(orbits, names)
    chosen = x or first, y or second
    for name in chosen:
        if name not in names:
            raise ValueError(f"x and y must be among {listed(names)}, got {shown(name)}")
    u, v = (rows[names.index(name)].T for name in chosen)
    one = len(names) == 1
    if one:
        v = _images(u, orbits.crossings)
    kinds = orbits.stability
    drawn = orbits.status == Status.OK
    marks = []
    lines = _cycles(ax, u[drawn], orbits.crossings[drawn]) if one else ()
    for kind, style in STYLES.items():
        own = drawn & (kinds == kind)
        if own.any():
            (mark,) = ax.plot(u[own].ravel(), v[own].ravel(), ls="", zorder=5, label=_name(kind), **style)
            whose, crossing = np.divmod(np.arange(u[own].size), u.shape[1])
            marks.append(carry(mark, u[own].ravel(), v[own].ravel(), np.flatnonzero(own)[whose], crossing))
    sizes = np.abs(rows[:, :, drawn])
    above_rounding(ax, float(np.max(sizes, where=np.isfinite(sizes), initial=0.0)))
    if one and not ax.get_xlabel():
        name_iterates(ax, names[0])
    if not ax.get_xlabel():
        ax.set(xlabel=f"${symbol(chosen[0])}$", ylabel=f"${symbol(chosen[1])}$")
    written = _write(ax, orbits, u, v, drawn, fontsize) if labels else ()
    if legend and marks:
        ax.legend(handles=marks, loc="upper right", fontsize=fontsize, framealpha=0.95, borderpad=0.6)
    return Artists(tuple(marks), None, lines, written, int(np.count_nonzero(~drawn)))


def _images(u: np.ndarray, crossings: np.ndarray) -> np.ndarray:
    """Return the images (orbits, crossings) of points on cycles of a map of one variable."""
    found = images(u.T).T
    whole = np.flatnonzero(crossings > 0)
    found[whole, crossings[whole] - 1] = u[whole, 0]
    return found


def _cycles(ax: Any, u: np.ndarray, crossings: np.ndarray) -> tuple[Any, ...]:
    """Draw the diagonal and the steps of each cycle between its points and the diagonal."""
    colour = Palette.of(ax).grey(0.55)
    steps = [np.repeat(np.append(row[:count], row[0]), 2) for row, count in zip(u, crossings, strict=True)]
    cycles = [line for x in steps for line in ax.plot(x[:-1], x[1:], color=colour, lw=0.7, zorder=0.9)]
    return draw_diagonal(ax), *cycles


def _name(kind: Stability) -> str:
    return kind.name.lower().replace("_", " ")


def _coordinates(orbits: PeriodicOrbits, chart: Chart) -> tuple[tuple[str, ...], np.ndarray]:
    """Return names and values (names, crossings, orbits) of all coordinates of the crossings."""
    if len(orbits.points) != 8:
        return orbits.names, on_one_sheet(orbits.points, orbits.names)
    return (*chart.names, *chart.momenta), in_chart(orbits.points, chart)


def on_one_sheet(points: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
    """Return phase points (2n, ...) of a body reduced by its rotations with alpha and beta as they are in charts,
    positive: (-beta, -p_beta) is the same state. Those of other systems stay.
    """
    if tuple(names[:2]) != ALPHA_BETA.names[:2] or len(points) != 4:
        return points
    sign = np.where(points[:2] < 0, -1.0, 1.0)
    return points * np.concatenate([sign, sign])


def _free_pair(orbits: PeriodicOrbits, names: tuple[str, ...]) -> tuple[str, str]:
    """Return the coordinate that the section leaves free and its momentum; without momenta, the first two free ones."""
    if len(names) > 2 and not has_momenta(orbits):
        return free_rows(orbits.section, names)
    free = _free(orbits, names)
    return free, names[names.index(free) + len(names) // 2]


def _free(orbits: PeriodicOrbits, names: tuple[str, ...]) -> str:
    """Return the coordinate that the section leaves free: for a hyperplane of two degrees of freedom that of the other
    pair.
    """
    normal = getattr(orbits.section, "normal", None)
    if normal is not None and len(names) == 4:
        return names[1 - int(np.flatnonzero(normal)[0]) % 2]
    fixed = type(orbits.section).__name__.startswith("Beta")
    return names[0] if fixed or "beta" not in names else "beta"


def _write(ax: Any, orbits: PeriodicOrbits, u: np.ndarray, v: np.ndarray, drawn: np.ndarray, fontsize: float) -> tuple:
    """Write the labels, each beside the crossing and on the side where the nearest mark or label is farthest."""
    from matplotlib.patheffects import withStroke

    kept = np.isfinite(u) & np.isfinite(v) & drawn[:, None]
    pixels = np.full((*u.shape, 2), np.nan)
    pixels[kept] = ax.transData.transform(np.column_stack([u[kept], v[kept]]))
    unit = ax.figure.dpi / 72 * fontsize
    taken = [pixels[kept]]
    frame = np.array([ax.bbox.min, ax.bbox.max])
    written = []
    for o in np.flatnonzero(drawn).tolist():
        value, prefix = _value(orbits, o)
        text = f"{orbits.crossings[o]}: ${prefix}{number_text(value)}$"
        half = np.array([0.28 * unit * (len(number_text(value)) + (6 if prefix else 3)), 0.6 * unit])
        best = -np.inf
        place = np.zeros(2)
        side = np.zeros(2)
        at = 0
        for j in range(orbits.crossings[o]):
            for angle in np.arange(8) * np.pi / 4:
                direction = np.array([np.cos(angle), np.sin(angle)])
                centre = pixels[o, j] + direction * (half + 0.7 * unit)
                room = np.abs(np.concatenate(taken) - centre) / half
                edges = np.min(np.minimum(centre - frame[0], frame[1] - centre) / half)
                score = (
                    min(np.nanmin(room.max(axis=1)), 2.5)
                    + min(edges - 1.1, 0.0) * 10
                    - 0.05 * (angle % (np.pi / 2) > 0)
                    - 0.01 * j
                )
                if score > best:
                    best = score
                    place = centre
                    side = centre - pixels[o, j]
                    at = j
        offset = side * 72 / ax.figure.dpi
        halo = [withStroke(linewidth=2.5, foreground=Palette.of(ax).ground)]
        style = {"ha": "center", "va": "center", "fontsize": fontsize, "zorder": 6, "path_effects": halo}
        written.append(
            ax.annotate(text, (u[o, at], v[o, at]), xytext=tuple(offset), textcoords="offset points", **style)
        )
        # The extent of a label: its middle and both ends.
        taken.append(place + np.array([[-1.0, 0.0], [-0.5, 0.0], [0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]) * half)
    return tuple(written)


def _value(orbits: PeriodicOrbits, k: int) -> tuple[float, str]:
    """Return the residue of an orbit, or the multiplier of largest magnitude of one without a residue, with the text
    before it.
    """
    if orbits.symplectic and np.isfinite(orbits.residue[k]):
        return float(orbits.residue[k]), ""
    multipliers = orbits.multipliers[:, k]
    largest = multipliers[np.abs(multipliers).argmax()]
    if abs(largest.imag) > 1e-12 * abs(largest):
        return float(abs(largest)), r"|\lambda|="
    return float(largest.real), r"\lambda="


def number_text(residue: float) -> str:
    """Return a residue with three digits, or a power of ten where it is large."""
    if abs(residue) < 1000:
        return f"{residue:.3g}" if abs(residue) >= 5e-4 else "0"
    power = int(np.floor(np.log10(abs(residue))))
    return rf"{residue / 10**power:.1f}\times10^{{{power}}}"
