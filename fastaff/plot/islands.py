"""Figures of islands and of rotation numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.status import Status
from ..sections.islands import Islands, Rotation
from .picking import carry
from .sections import why
from .style import Artists, Palette, figure, nothing


@figure
@inserts_parameters
def plot_rotation(result: Rotation, x: Any = None, *, ax: Any = None, label: str = "orbit") -> Artists:
    """Plot rotation numbers with their errors against a number of each orbit.

    Parameters
    ----------
    result : Rotation
        Result of `rotation_number`.
    x : array_like, shape (orbits,), optional
        Abscissa, for example the place of the initial conditions on a line. Default: the number of the orbit.
    {ax}
    label : str, default "orbit"
        Label of the abscissa.

    Returns
    -------
    Artists
        ``points`` are the dots with error bars. ``missing`` is the number of orbits without a rotation number.

    Examples
    --------
    >>> angle = 2 * np.pi * 0.381966 * np.arange(500)
    >>> rotation = fa.rotation_number([np.cos(angle), np.sin(angle)])
    >>> fa.plot.plot_rotation(rotation).missing
    0
    """
    rotation = np.atleast_1d(result.rotation)
    error = np.atleast_1d(result.error)
    at = np.arange(rotation.size) if x is None else np.asarray(x, float)
    if at.shape != rotation.shape:
        raise ValueError(f"x must have shape {rotation.shape}, one number for each orbit, got {at.shape}")
    fine = (np.atleast_1d(result.status) == Status.OK) & np.isfinite(rotation) & np.isfinite(error)
    style = {"ls": "", "marker": "o", "ms": 3.0, "lw": 0.8, "capsize": 1.5}
    points = ax.errorbar(at[fine], rotation[fine], yerr=error[fine], color=Palette.of(ax).main, **style)
    carry(points[0], at[fine], rotation[fine], np.flatnonzero(fine))
    if not fine.any():
        nothing(ax, why(np.atleast_1d(result.status), ~fine))
    ax.set(xlabel=label, ylabel="rotation number  (turns per crossing)")
    return Artists(points, None, (), (), int(np.count_nonzero(~fine)))


@figure
@inserts_parameters
def plot_islands(result: Islands, *, ax: Any = None, labels: bool = True) -> Artists:
    """Plot chains of islands on a section, with the size of each island and the rotation numbers.

    Parameters
    ----------
    result : Islands
        Result of `islands`.
    {ax}
    labels : bool, default True
        Write the rotation number p/q beside the first island of each chain.

    Returns
    -------
    Artists
        ``points`` are the centres of the islands, ``lines`` the ellipses of their sizes and ``labels`` the rotation
        numbers. ``missing`` is the number of orbits of no chain. A click picks orbit and island. Axes of a section keep
        their labels.

    Examples
    --------
    >>> turns = fa.poincare_map(fa.models.HenonMap(), [0.6, 0.0], crossings=1000)
    >>> [text.get_text() for text in fa.plot.plot_islands(fa.islands(turns)).labels]
    ['-1/5']
    """
    from matplotlib.patches import Ellipse

    own = np.flatnonzero(result.q > 0)
    x, y = result.centres[:, :, own]
    island, which = np.nonzero(np.isfinite(x) & np.isfinite(y))
    u = x[island, which]
    v = y[island, which]
    orbit = own[which]
    chains = {int(q): k for k, q in enumerate(np.unique(result.q[own]))}
    palette = Palette.of(ax)
    ring = palette.curves[1:] + palette.curves[:1]  # told from crossings
    colours = [ring[chains[int(result.q[k])] % len(ring)][0] for k in orbit]
    points = carry(ax.scatter(u, v, s=10, c=colours or palette.main, zorder=4), u, v, orbit, island)
    ellipses = []
    for a, b, k, i, colour in zip(u, v, orbit, island, colours):
        width, height = 2 * result.semi_axes[:, i, k]
        if np.isfinite(width) and np.isfinite(height):
            ellipses.append(ax.add_patch(Ellipse((a, b), width, height, fill=False, ec=colour, lw=1.0, zorder=4)))
    written = []
    seen = set()
    for k in own if labels else ():
        chain = int(result.p[k]), int(result.q[k])
        if chain not in seen:
            seen.add(chain)
            text = f"{chain[0]}/{chain[1]}"
            place = {"xytext": (5, 5), "textcoords": "offset points", "fontsize": 8, "bbox": palette.plate, "zorder": 5}
            written.append(ax.annotate(text, tuple(result.centres[:, 0, k]), **place))
    if not u.size:
        nothing(ax, "no chain of islands")
    ax.autoscale_view()
    if not ax.get_xlabel():
        ax.set(xlabel="first section coordinate", ylabel="second section coordinate")
    return Artists(points, None, tuple(ellipses), tuple(written), int(result.q.size - own.size))
