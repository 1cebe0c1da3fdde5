"""Periodic orbits as curves in the plane of two coordinates, over a figure there: scars of wave functions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.docstrings import inserts_parameters
from ..core.numbers import listed, shown
from ..core.status import Status
from ..periodic.found_orbits import PeriodicOrbits
from ..runs.integrate import integrate
from ..systems.charts import ALPHA_BETA, R_VARTHETA, TWO_POLAR, Chart
from ..systems.models.contracts import SeparableModel
from .backbone import STABLE
from .periodic import on_one_sheet
from .picking import carry
from .style import Artists, figure, symbol

PLANES = (ALPHA_BETA, R_VARTHETA, TWO_POLAR)


def in_plane(alpha: np.ndarray, beta: np.ndarray, chart: Chart) -> tuple[np.ndarray, np.ndarray]:
    """Return the two deformation invariants of a chart, of alpha and beta."""
    if chart.name == TWO_POLAR.name:
        return (alpha + beta) / math.sqrt(2), (alpha - beta) / math.sqrt(2)
    if chart.name == R_VARTHETA.name:
        return alpha**2 + beta**2, 2 * np.arctan2(beta, alpha)
    return alpha, beta


def traced(model: SeparableModel, orbits: PeriodicOrbits, points: int = 400) -> np.ndarray:
    """Return the phase points (2n, points + 1, orbits) of periodic orbits at equal times over their periods, the last
    one the first again; NaN where an orbit is not OK.

    Cost: one integration of each orbit over its period.
    """
    found = np.full((len(orbits.z), points + 1, len(orbits)), np.nan)
    for k in np.flatnonzero(orbits.status == Status.OK):
        run = integrate(model, orbits.z[:, k], time=float(orbits.period[k]), samples=points, accuracy=1e-8)
        found[:, 0, k] = orbits.z[:, k]
        found[:, 1:, k] = run.samples.reshape(points, len(orbits.z)).T
    return found


@figure
@inserts_parameters
def plot_scars(
    orbits: PeriodicOrbits,
    model: SeparableModel,
    *,
    ax: Any = None,
    chart: Chart | None = None,
    points: int = 400,
) -> Artists:
    """Plot periodic orbits as curves of two coordinates, over the density of a state.

    Parameters
    ----------
    orbits : PeriodicOrbits
        Periodic orbits.
    model : model
        Model of the orbits, for example `reduced_body`.
    {ax}
    chart : Chart, optional
        Coordinates of a body: `ALPHA_BETA`, `R_VARTHETA` or `TWO_POLAR`, the same as in `plot_density`. Default:
        `ALPHA_BETA`.
    points : int, default 400
        Number of points along each orbit.

    Returns
    -------
    Artists
        ``points`` are the curves, white with a dark casing: solid if stable, dashed if unstable. ``missing`` is the
        number of orbits that are not ``OK``.

    Raises
    ------
    ValueError
        If the chart is not supported or is not the chart of the axes.

    Notes
    -----
    - alpha and beta are plotted as positive numbers. Axes that already have a plot keep their limits.
    - Cost: one integration of each orbit over its period.

    References
    ----------
    Heller 1984, Phys. Rev. Lett. 53, 1515 (scars).

    Examples
    --------
    >>> orbit = fa.periodic_orbits(fa.HenonHeiles(), [0.0, 0.0, 0.3, 0.31], section="x=0", energy=0.1, max_time=20.0)
    >>> fa.plot.plot_scars(orbit, fa.HenonHeiles(), points=60).missing
    0
    """
    from matplotlib.patheffects import Normal, Stroke

    if chart is not None and chart.name not in [plane.name for plane in PLANES]:
        raise ValueError(f"chart must be one of {listed(plane.name for plane in PLANES)}, got {shown(chart.name)}")
    z = traced(model, orbits, points)
    if len(z) == 8:
        u, v = np.hypot(z[0], z[1]), np.hypot(z[2], z[3])
        names: tuple[str, ...] = ALPHA_BETA.names
    else:
        u, v = on_one_sheet(z, orbits.names)[:2]
        names = tuple(orbits.names)
    if chart is not None and tuple(names[:2]) == ALPHA_BETA.names[:2]:
        u, v = in_plane(u, v, chart)
        names = chart.names
    drawn = ax.has_data()
    limits = (ax.get_xlim(), ax.get_ylim())
    label = ax.get_xlabel()
    if drawn and label and not label.startswith(f"${symbol(names[0])}$"):
        raise ValueError(f"chart must be that of the axes, whose first coordinate is {label}, got {names[0]}")
    curves = []
    for k in np.flatnonzero(orbits.status == Status.OK):
        steady = orbits.stability[k] in STABLE
        look = {"lw": 1.2, "color": "white", "ls": "-" if steady else (0, (4, 1.6)), "zorder": 4}
        (curve,) = ax.plot(u[:, k], v[:, k], path_effects=[Stroke(linewidth=2.6, foreground="black"), Normal()], **look)
        curves.append(carry(curve, u[:, k], v[:, k], np.full(points + 1, k)))
    if drawn:
        ax.set(xlim=limits[0], ylim=limits[1])
    else:
        ax.set(xlabel=f"${symbol(names[0])}$", ylabel=f"${symbol(names[1])}$")
    return Artists(tuple(curves), None, (), (), int(np.count_nonzero(orbits.status != Status.OK)))
