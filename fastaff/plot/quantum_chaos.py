"""Figures of quantum chaos: Husimi functions over classical sections, and distributions of spacings.

As in `fastaff.plot`, every function takes `ax=` and returns the artists it made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import checked
from ..core.docstrings import inserts_parameters
from ..core.numbers import entries, positive, shown, whole
from ..periodic.found_orbits import PeriodicOrbits
from ..sections.energy_grid import EnergyGrid
from ..sections.section_edge import Edge
from ..systems.charts import ALPHA_BETA
from .periodic import plot_periodic
from .picking import carry
from .sections import section_coordinates
from .starts import cut_sides, places, widths
from .style import Artists, Palette, beyond, figure, outline, symbol

LABELLED = 'laws of spacings, or such by their labels, as {"Poisson": BerryRobnik(0.0)}'
"""Description of the laws of a figure."""


@figure
@inserts_parameters
def plot_husimi(
    grid: EnergyGrid,
    values: ArrayLike,
    *,
    ax: Any = None,
    section_map: Any = None,
    boundary: Edge | None = None,
    peak: float | None = None,
    size: float = 0.5,
    orbits: PeriodicOrbits | None = None,
    colorbar: bool = True,
) -> Artists:
    """Plot a Husimi function over a section, with classical crossings and periodic orbits.

    Parameters
    ----------
    grid : EnergyGrid
        Grid of `energy_grid`.
    values : array_like, shape (orbits,)
        Husimi function at ``grid.z0``.
    {ax}
    section_map : SectionMap, optional
        Crossings of orbits of the same energy on the same section, drawn as dots.
    boundary : Edge, optional
        Boundary of the accessible region, from `edge`.
    peak : float, optional
        Value at the end of the colours. Default: the largest value.
    size : float, default 0.5
        Area of a dot in square points.
    orbits : PeriodicOrbits, optional
        Periodic orbits on the same section, marked by their stability. The function may be scarred by them.
    {colorbar}

    Returns
    -------
    Artists
        ``points`` are the cells, ``lines`` the dots, the boundary and the marks. ``missing`` is the number of values
        that are not finite. The ground is 0 or inaccessible. A click picks the orbit of a cell.

    Examples
    --------
    >>> body, section, axes = fa.Body(fa.Harmonic()), fa.AlphaTurning(), ([0.5, 1.0, 1.5], [-0.5, 0.0, 0.5])
    >>> grid = fa.energy_grid(body, energy=4.0, section=section, axes=axes)
    >>> Q = fa.quantum.husimi(fa.quantum.wavefunction(body, m=0, l=0, n=(1, 0)))
    >>> fa.plot.plot_husimi(grid, Q(grid.z0)).missing
    0
    """
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    each = np.asarray(values, dtype=np.float64)
    if each.shape != grid.cell_index.shape:
        raise ValueError(
            f"values must have shape {grid.cell_index.shape}, one for each orbit of the grid, got {each.shape}"
        )
    palette = Palette.of(ax)
    shades: list[Any] = [palette.ground, *palette.browns]
    colours = LinearSegmentedColormap.from_list("fastaff_husimi", shades)
    top = float(np.max(each, where=np.isfinite(each), initial=0.0)) or 1.0 if peak is None else peak
    image = np.ma.masked_invalid(grid.to_grid(each))
    # Smooth between cells, as the function is; the section's edge is drawn by `boundary`.
    cells = ax.pcolormesh(
        *grid.axes, image.T, cmap=colours, norm=Normalize(0.0, top), rasterized=True, shading="gouraud"
    )
    lines: list[Any] = []
    if section_map is not None:
        names, z = section_coordinates(section_map, ALPHA_BETA)
        u, v = (z[names.index(name)].T.ravel() for name in grid.names)
        kept = np.isfinite(u) & np.isfinite(v)
        lines.append(
            ax.scatter(u[kept], v[kept], s=size, color=palette.navy, alpha=0.55, linewidths=0, rasterized=True)
        )
    if boundary is not None:
        lines += outline(ax, boundary)
    at = places(grid)
    carry(cells, at[0], at[1], np.arange(each.size), cell=widths(grid))
    ax.set(xlabel=f"${symbol(grid.names[0])}$", ylabel=f"${symbol(grid.names[1])}$")
    if orbits is not None:
        lines += plot_periodic(orbits, ax=ax, x=grid.names[0], y=grid.names[1], labels=False).points
    bar = None
    if colorbar:
        bar = ax.figure.colorbar(cells, ax=ax, label=r"Husimi function $|\langle z|\Psi\rangle|^2$")
        bar.formatter.set_powerlimits((-2, 3))
    return Artists(cells, bar, tuple(lines), cut_sides(ax, grid), int(np.count_nonzero(~np.isfinite(each))))


@figure
@inserts_parameters
def plot_spacings(
    spacings: ArrayLike,
    laws: Mapping[str, Any] | Sequence[Any],
    *,
    ax: Any = None,
    bins: int = 20,
    top: float = 3.5,
    colour: Any = None,
    label: str | None = None,
) -> Artists:
    """Plot a histogram of unfolded spacings, as a density, with laws for comparison.

    Parameters
    ----------
    spacings : array_like, shape (n,)
        Spacings with a mean of about 1.
    laws : dict or sequence
        Laws by label, for example ``{"Poisson": BerryRobnik(0.0)}``, or laws alone, which are their own labels. They
        are drawn in this order.
    {ax}
    bins : int, default 20
        Number of bins from 0 to `top`.
    top : float, default 3.5
        Largest spacing of the histogram.
    colour : str, optional
        Colour of the histogram. Default: grey.
    label : str, optional
        Label of the histogram.

    Returns
    -------
    Artists
        ``points`` are the bars, ``lines`` the laws. ``missing`` is the number of spacings beyond `top`, which count in
        the norm.

    Examples
    --------
    >>> spacings = np.random.default_rng(0).exponential(size=4000)
    >>> drawn = fa.plot.plot_spacings(spacings, {"Poisson": fa.quantum.BerryRobnik(0.0)})
    >>> drawn.missing == int(np.sum(spacings > 3.5))
    True
    """
    s = checked("spacings", spacings, ()).ravel()
    labelled = _labelled(laws)
    edges = np.linspace(0.0, positive("top", top), whole("bins", bins, 1) + 1)
    counts = np.histogram(s, edges)[0]
    total = max(s.size, 1)
    height = counts / (total * np.diff(edges))
    palette = Palette.of(ax)
    fill = {"color": palette.grey(0.82) if colour is None else colour, "edgecolor": palette.ground, "linewidth": 0.5}
    bars = ax.bar(edges[:-1], height, np.diff(edges), align="edge", label=label, **fill)
    middle = (edges[1:] + edges[:-1]) / 2
    error = np.sqrt(counts * (1 - counts / total)) / (total * np.diff(edges))
    ax.errorbar(middle, height, yerr=error, fmt="none", ecolor=palette.grey(0.45), elinewidth=0.8)
    x = np.linspace(0.0, top, 400)
    lines = []
    looks = _looks(palette)
    for number, (name, law) in enumerate(labelled.items()):
        colour, dashes = looks[number % len(looks)]
        lines += ax.plot(x, law.density(x), color=colour, ls=dashes, lw=1.5, label=name)
    ax.set(xlabel="spacing $s$ (unfolded)", ylabel="$P(s)$", xlim=(0.0, top))
    many = int(np.count_nonzero(s > top))
    texts = (beyond(ax, f"{many} of {s.size} spacings above {top:g}"),) if many else ()
    return Artists(bars, None, tuple(lines), texts, many)


def _looks(palette: Palette) -> tuple[tuple[Any, Any], ...]:
    """Return colours and dashes of laws, in turn."""
    return (palette.accent, "-"), (palette.main, "--"), (palette.grey(0.25), (0, (1, 1.2))), ("#7a8fb8", "-.")


def _labelled(laws: Any) -> Mapping[str, Any]:
    """Return laws of spacings by their labels."""
    single = (laws,) if hasattr(laws, "density") else laws
    found = single if isinstance(single, Mapping) else {repr(law): law for law in entries("laws", single, LABELLED)}
    for law in found.values():
        if isinstance(law, type) or not hasattr(law, "density"):
            raise TypeError(f"laws must be {LABELLED}, got {shown(law)} among them")
    return found
