"""Crossings of a section by many orbits, as a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ..core.status import Status, counted, describe
from ..results.result import Result, along
from ..runs.coordinates import chart_row, in_chart
from ..runs.requirements import checked_chart
from ..runs.schemes.catalogue import ITERATION, Scheme
from ..runs.schemes.time_transformed import TimeTransformed
from ..systems.charts import Chart


@dataclass(frozen=True)
class SectionMap(Result):
    """Crossings of a surface of section, or iterates of a map.

    Attributes
    ----------
    points : ndarray, shape (2n, crossings, orbits)
        States at the crossings, NaN after the last one of an orbit.
    times : ndarray, shape (crossings, orbits)
        Times of the crossings, NaN after the last one; for a map the numbers of the iterates.
    counts : ndarray of int, shape (orbits,)
        Number of crossings of each orbit.
    section_error : ndarray, shape (orbits,)
        Largest ``|section(z)|`` over the crossings, in units of the section function.
    energy_error : ndarray, shape (orbits,)
        Largest ``|E - E0|`` over the crossings, relative to the largest kinetic energy.
    status : ndarray of int, shape (orbits,)
        `Status` of each orbit. An orbit with ENERGY_DRIFT keeps the crossings before its energy error exceeded the
        tolerance.
    section : Section or None
        Surface of section; None for a map.
    scheme : Scheme or None
        Integration method; None for samples of `map_samples`.
    step : float or ndarray, shape (orbits,)
        Step size, in units of time: one for each orbit if it was chosen, inf for an adaptive method.
    names : tuple of str, length 2n
        Names of the rows: ``result["p_beta"]`` is the row of that name, of shape (crossings, orbits).
    time_error : ndarray, shape (crossings, orbits), or None
        Error estimates of `times`: inf if the comparison run has no such crossing, None if a step or tolerances were
        given.
    point_error : ndarray, shape (2n, crossings, orbits), or None
        Error estimates of `points`, with the same exceptions.
    accurate_until : ndarray, shape (orbits,), or None
        Time until which both errors stay below the requested accuracy, with the same exception.
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
    scheme: Scheme | TimeTransformed | None
    step: Annotated[float | np.ndarray, along("orbit", unit="time")]
    names: tuple[str, ...]
    time_error: Annotated[np.ndarray | None, along("crossing", "orbit", unit="time", padded="crossing")] = None
    point_error: Annotated[
        np.ndarray | None, along("coordinate", "crossing", "orbit", labels="names", padded="crossing")
    ] = None
    accurate_until: Annotated[np.ndarray | None, along("orbit", unit="time")] = None

    def coordinates(self, chart: Chart) -> np.ndarray:
        """Return the crossings in a chart of GL(2,R).

        Parameters
        ----------
        chart : Chart
            Coordinates to return.

        Returns
        -------
        ndarray, shape (8, crossings, orbits)
            Coordinates and momenta, NaN after the last crossing.
        """
        return in_chart(self.points, checked_chart(chart))

    def summary(self) -> str:
        """Return one line with the outcomes of the orbits, and advice if crossings are missing.

        Returns
        -------
        str
            Summary.
        """
        crossings = counted(int(self.counts.sum()), "crossing")
        head, colon, rest = self._in_own_words(describe(self.status)).partition(":")
        said = f"{head}, {crossings}{colon}{rest}"
        way = getattr(self.section, "direction", 0)
        never = int(np.count_nonzero((self.counts == 0) & (self.status == Status.TOO_FEW_CROSSINGS)))
        if not never or way == 0 or "direction" not in getattr(self.section, "_fields", ()):
            return said
        known, other = ("upwards", "downwards")[:: 1 if way > 0 else -1]
        return f"{said}; {never} never cross {known}. Use direction={-int(way)} for crossings {other}, 0 for all."

    def _advice(self) -> dict[Status, str]:
        """Return the words for crossings of samples, which have no scheme, and for iterates of a map."""
        if self.scheme is None:
            return {
                Status.NOT_CONVERGED: "samples too few or too far apart to find the crossings; take more samples",
                Status.NONFINITE: "a coordinate became infinite or NaN; check the samples",
            }
        if self.scheme == ITERATION:
            return {Status.NONFINITE: "an iterate became infinite or NaN; reduce the amplitude"}
        return {}

    def _row(self, name: str) -> np.ndarray | None:
        return chart_row(self.points, name)
