"""Figure of the divergence of neighbours in a measured series."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..chaos.measured_series import SeriesExponent
from ..core.docstrings import inserts_parameters
from .style import GREY, LINES, Artists, figure


@figure
@inserts_parameters
def plot_divergence(result: SeriesExponent, *, ax: Any = None) -> Artists:
    """Plot the mean logarithmic distances of neighbours against time, with the fitted exponent.

    Parameters
    ----------
    result : SeriesExponent
        Result of `chaos.series_exponent`.
    {ax}

    Returns
    -------
    Artists
        ``points`` are the curves, one for each number of delay coordinates. ``lines`` has the slope, if there is one.

    References
    ----------
    Kantz 1994, Phys. Lett. A 185, 77.

    Examples
    --------
    >>> found = fa.chaos.series_exponent(np.cos(np.cumsum(np.sqrt(np.arange(700.0)))))
    >>> len(fa.plot.plot_divergence(found).points)
    3
    """
    curves = tuple(
        ax.plot(result.time, curve, lw=0.8, color=colour, ls=dashes)[0]
        for curve, (colour, dashes) in zip(result.divergence, LINES, strict=False)
    )
    slope = ()
    if np.isfinite(result.exponent):
        ends = np.array(result.fitted)
        middle = np.interp(ends.mean(), result.time, result.divergence.mean(axis=0))
        line = middle + result.exponent * (ends - ends.mean())
        slope = tuple(ax.plot(ends, line, color=GREY, ls="--", lw=1.2))
    ax.set_xlabel("time")
    ax.set_ylabel("mean logarithmic distance")
    return Artists(curves, colorbar=None, lines=slope, labels=(), missing=0)
