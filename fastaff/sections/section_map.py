"""Crossings of a section by many orbits, as a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ..core.status import Status
from ..results.result import Result, along
from ..runs.coordinates import chart_row, in_chart
from ..runs.requirements import checked_chart
from ..runs.schemes.catalogue import Scheme
from ..runs.schemes.time_transformed import TimeTransformed
from ..systems.charts import Chart


@dataclass(frozen=True)
class SectionMap(Result):
    """Crossings of a section.

    points (2n, crossings, orbits), the states at the crossings, and times (crossings, orbits): NaN past counts
    (orbits,). section_error (orbits,): the largest ``|section(z)|`` over the crossings; energy_error (orbits,): the
    largest ``|E - E0|`` over them, relative to the largest kinetic energy met; status (orbits,) of `Status`; step: the
    fixed step, one for each orbit where it was chosen, or inf for an adaptive scheme. time_error (crossings, orbits)
    and point_error (2n, crossings, orbits): the estimated errors of both, inf where a run with another step has no such
    crossing; accurate_until (orbits,): the time up to which they stay below the accuracy; None where a step or
    tolerances were given. An orbit with the status ENERGY_DRIFT keeps the crossings before its energy error exceeded
    the tolerance. names (2n,): of the rows, as in `Orbits`: `result["p_beta"]` (crossings, orbits) of a body.
    """

    points: Annotated[
        np.ndarray, along("coordinate", "crossing", "orbit", labels="names", plain=True, padded="crossing")
    ]
    times: Annotated[np.ndarray, along("crossing", "orbit", unit="time", padded="crossing")]
    counts: Annotated[np.ndarray, along("orbit")]
    section_error: Annotated[np.ndarray, along("orbit", unit="section function")]
    energy_error: Annotated[np.ndarray, along("orbit", unit="largest kinetic energy")]
    status: Annotated[np.ndarray, along("orbit")]
    section: Any
    scheme: Scheme | TimeTransformed
    step: Annotated[float | np.ndarray, along("orbit", unit="time")]
    names: tuple[str, ...]
    time_error: Annotated[np.ndarray | None, along("crossing", "orbit", unit="time", padded="crossing")] = None
    point_error: Annotated[
        np.ndarray | None, along("coordinate", "crossing", "orbit", labels="names", padded="crossing")
    ] = None
    accurate_until: Annotated[np.ndarray | None, along("orbit", unit="time")] = None

    def coordinates(self, chart: Chart) -> np.ndarray:
        """Return the crossings in a chart of GL(2,R): (8, crossings, orbits), coordinates and momenta, NaN past
        counts.
        """
        return in_chart(self.points, checked_chart(chart))

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits, and how to ask for crossings that were not counted."""
        said = super().summary()
        way = getattr(self.section, "direction", 0)
        never = int(np.count_nonzero((self.counts == 0) & (self.status == Status.TOO_FEW_CROSSINGS)))
        if not never or way == 0 or "direction" not in getattr(self.section, "_fields", ()):
            return said
        known, other = ("upwards", "downwards")[:: 1 if way > 0 else -1]
        return f"{said}; {never} never cross {known}: direction={-int(way)} counts crossings {other}, direction=0 all"

    def _row(self, name: str) -> np.ndarray | None:
        return chart_row(self.points, name)
