"""Runs of many orbits towards attractors: looks at equal intervals, tubes that end orbits, returns with derivatives.

An interval is an iterate of a map, a period of a drive, and about a radian of the motion of other systems. Distances
are in units of the rows, `Motion.scale`; angles count modulo their periods, the time of a driven system not at all.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import Callback, fits
from ..core.status import Status
from ..runs.flow import Ensemble, Flow, no_memory
from ..runs.observers import Observer, nothing
from ..systems.models.mechanics import System
from .kernels.traps import RECORD, ROWS, SEGMENT, trapped


class _TrapValue(NamedTuple):
    rows: float
    orbits: float
    segments: float


@dataclass
class Tube:
    """A neighbourhood of an attractor from which no orbit leaves: all points nearer to the polygon `points`
    (rows, points), which is closed if `curve`, or to one of the points, than the radius.
    """

    points: np.ndarray
    radius: float
    curve: bool


class Trapped(NamedTuple):
    """Orbits after a run: states (rows, orbits), numbers of the tubes that they have entered, -1 for none, the times
    when they entered them, or of the end, and statuses (orbits,).
    """

    z: np.ndarray
    tube: np.ndarray
    time: np.ndarray
    status: np.ndarray


@dataclass
class Motion:
    """The flow of a model with the interval between looks; rows and periods, for distances.

    kept: numbers of the rows that count; periods (rows,), 0 for none; scale (rows,): units of distances; stepwise:
    whether states are only compared after whole intervals, iterates or periods of a drive; phase: values of the rows
    of a drive at these times.
    """

    flow: Flow
    interval: float
    kept: np.ndarray
    periods: np.ndarray
    scale: np.ndarray
    stepwise: bool
    phase: dict[int, float]

    def of(self, flow: Flow) -> Motion:
        """Return the same for a flow of other orbits."""
        return replace(self, flow=flow)

    @property
    def system(self) -> System:
        """The system."""
        return self.flow.system

    def wrapped(self, away: np.ndarray) -> np.ndarray:
        """Return differences of states (rows, ...) with angles within half a period."""
        shape = (-1, *[1] * (away.ndim - 1))
        periods = self.periods.reshape(shape)
        with np.errstate(all="ignore"):
            turns = np.rint(away / np.where(periods > 0, periods, 1.0))
            return np.where(periods > 0, away - periods * turns, away)

    def apart(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Return the distances of states (rows, ...)."""
        away = self.wrapped(first - second)[self.kept]
        with np.errstate(all="ignore"):
            return np.linalg.norm(away / self.scale[self.kept].reshape(-1, *[1] * (away.ndim - 1)), axis=0)

    def begun(self, z: np.ndarray, vectors: int = 0) -> tuple[Flow, Ensemble]:
        """Return the flow and orbits that start at z (rows, orbits), with unit deviation vectors."""
        flow = replace(self.flow, vectors=vectors)
        unit = np.broadcast_to(np.eye(vectors)[:, :, None], (vectors, vectors, z.shape[1])) if vectors else None
        return flow, flow.ensemble(np.array(z, order="C"), unit)

    def run(
        self, z: np.ndarray, count: int, tubes: list[Tube], callback: Callback | None = None, kept: Any = None
    ) -> Trapped:
        """Run orbits over `count` intervals, or until they enter a tube. If Ctrl-C ends the run, `kept` gets what there
        is.
        """
        rows, orbits = z.shape
        table = self._table(tubes)
        fits("z0", orbits, table.shape[1])
        out = np.zeros((orbits + len(table), table.shape[1]))
        out[orbits:] = table
        value = _TrapValue(float(rows), float(orbits), float(len(table) - 1))
        flow, ensemble = self.begun(z)
        memory = np.zeros((ROWS.end, orbits))
        time = count * self.interval
        try:
            flow.advance(
                ensemble,
                Observer(trapped, ROWS.end, value),
                memory,
                out,
                time=time,
                observations=count,
                refill=True,
                callback=callback,
            )
        except KeyboardInterrupt:
            if kept is not None:
                open_ends = (out[:orbits, RECORD.attractor] == 0) & (ensemble.status == Status.OK)
                ensemble.status[open_ends] = Status.INTERRUPTED
                kept(self._ended(ensemble, out[:orbits]))
            raise
        return self._ended(ensemble, out[:orbits])

    def _ended(self, ensemble: Ensemble, record: np.ndarray) -> Trapped:
        tube = record[:, RECORD.attractor].astype(np.int64) - 1
        time = np.where(tube >= 0, record[:, RECORD.time], ensemble.time)
        return Trapped(self.restarted(ensemble.z), tube, time, ensemble.status)

    def restarted(self, z: np.ndarray) -> np.ndarray:
        """Return states from which the same motion goes on: a drive begins at its phase again."""
        for row, value in self.phase.items():
            z[row, np.isfinite(z[row])] = value
        return z

    def _table(self, tubes: list[Tube]) -> np.ndarray:
        """Return the units of the rows and the segments of tubes as `kernels.traps.SEGMENT` has them."""
        rows = len(self.scale)
        begin = SEGMENT.begin
        inverse = np.zeros(rows)
        inverse[self.kept] = 1 / self.scale[self.kept]
        first = np.zeros(begin + 2 * rows)
        first[begin : begin + rows] = inverse
        first[begin + rows :] = self.periods
        found = [first[None]]
        for number, tube in enumerate(tubes):
            part = np.zeros((tube.points.shape[1], begin + 2 * rows))
            part[:, SEGMENT.attractor] = number + 1
            part[:, SEGMENT.radius] = tube.radius**2
            part[:, begin : begin + rows] = tube.points.T
            if tube.curve:
                way = self.wrapped(np.roll(tube.points, -1, axis=1) - tube.points).T * inverse
                size = (way**2).sum(axis=1)
                part[:, SEGMENT.size] = size
                part[:, SEGMENT.inverse] = np.where(size > 0, 1 / np.where(size > 0, size, 1.0), 0.0)
                part[:, begin + rows :] = way
            found.append(part)
        return np.concatenate(found)

    def window(self, z: np.ndarray, count: int, parts: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Return states (count, rows, orbits) after each interval, or `parts` of it, NaN after an end, and statuses."""
        flow, ensemble = self.begun(z)
        states = flow.sampled(ensemble, count, time=count * self.interval / parts).transpose(1, 2, 0)
        return states, ensemble.status

    def after(self, z: np.ndarray, time: np.ndarray, finer: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Return the states (rows, orbits) after times (orbits,), and the derivatives (orbits, rows, rows); NaN where
        an orbit has ended.
        """
        rows = len(z)
        flow, ensemble = self.begun(z, rows)
        if not self.system.iterated:
            flow = flow.finer() if finer else flow
            flow = flow.fitted(time)
        observed = 0 if flow.adaptive else 1
        flow.advance(ensemble, nothing(), *no_memory(ensemble), time=time, observations=observed)
        ended = ensemble.status != Status.OK
        end = np.array(ensemble.points)
        matrix = ensemble.deviations.transpose(2, 1, 0).copy()
        end[:, ended] = np.nan
        matrix[ended] = np.nan
        return end, matrix
