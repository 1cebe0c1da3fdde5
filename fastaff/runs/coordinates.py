"""Names of the rows of phase points, and their coordinates in the charts of GL(2,R)."""

from __future__ import annotations

import numpy as np

from ..systems.charts import ALPHA_BETA, ELLIPTIC, R_VARTHETA, TWO_POLAR, Chart

NAMED = (ALPHA_BETA, R_VARTHETA, TWO_POLAR, ELLIPTIC)
"""Charts in which a name means one coordinate."""


def in_chart(z: np.ndarray, chart: Chart) -> np.ndarray:
    """Return phase points z (8, ...) in a chart, coordinates and momenta (8, ...); NaN where z is not finite."""
    kept = np.isfinite(z).all(axis=0)
    converted = np.full(z.shape, np.nan)
    converted[:, kept] = chart.from_planes(z[:, kept])
    return converted


def chart_row(z: np.ndarray, name: str) -> np.ndarray | None:
    """Return the coordinate or momentum of that name (...) of phase points z (8, ...): one in the four charts of the
    paper's bodies, such as "p_beta"; None where there is none, or z is a state of another kind of system.
    """
    for chart in NAMED if len(z) == 8 else ():
        names = (*chart.names, *chart.momenta)
        if name in names:
            return in_chart(z, chart)[names.index(name)]
    return None
