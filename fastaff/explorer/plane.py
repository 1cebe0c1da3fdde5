"""The plane of a coordinate of a map and its momentum, as in map_plane.js: its points and its extent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..core.status import Status
from ..frequencies.frequency_map import frequency_map
from ..systems.models.maps import jacobian
from ..systems.models.mechanics import System
from .curve import curve_rotation
from .setup import planes

SIZES = 1e-5 * 10.0 ** (np.arange(45) / 4)
"""Half widths of the squares in which starts of a map are tried: 1e-5 to 1e6, four in a decade."""

TRIED = 64
"""Starts that are tried in a square of each size."""

STARTS = 256
"""Starts whose iterates give the range of the axes."""

LOOKS = 200
"""Iterates of the first trial."""

LONG = 1000
"""Iterates of the trial that gives the range of the axes."""

FAR = 1e3
"""Distance from which a start has left, in half widths of its square."""

SOME = 1 / 16
"""Least share of starts that stay for a size to count."""

BENT = 0.5
"""Relative change of a map's derivative from which the map is bent."""

BENDS = 5.0
"""Range of the axes in sizes at which the map is bent, if no start leaves."""

QUANTILE = 0.005
"""Share of the points at either end that the axes leave out."""

EDGE = 0.06
"""Edge around the other points, in parts of their range."""

LEAST = 64
"""Least number of iterates for a rotation number."""

LOCKED = 12
"""The largest number of islands of a chain that is sought."""

PLASTIC = (0.7548776662466927, 0.5698402909980532)
"""Steps of an additive sequence with low discrepancy in two dimensions: 1/p and 1/p^2 of the plastic number p."""


class Plane(NamedTuple):
    """Two rows of a map; start (2n,): starting values of the others."""

    system: System
    name: str
    rows: tuple[int, int]
    start: np.ndarray

    @classmethod
    def of(cls, system: System, name: str, others: dict[str, float] | None) -> Plane:
        """Return the plane of that name, such as "x,p"; ValueError if the map has no such plane."""
        names = planes(system)
        known = system.row_names
        if name not in names:
            raise ValueError(f"the plane must be one of {'; '.join(names)}, got {name}")
        index = names.index(name)
        rows = (index, system.n + index)
        values = [0.0 if r in rows else float((others or {}).get(entry, 0.0)) for r, entry in enumerate(known)]
        return cls(system, name, rows, np.array(values))

    @property
    def model(self) -> Any:
        """The map."""
        return self.system.model

    @property
    def periods(self) -> tuple[float, float]:
        """Periods of the two rows, 0 where there is none."""
        found = self.model.periods()
        return float(found[self.rows[0]]), float(found[self.rows[1]])

    def lift(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return states (2n, points) over points, and which are in the map's domain."""
        z = np.repeat(self.start[:, None], u.size, axis=1)
        for row, values, period in zip(self.rows, (u, v), self.periods, strict=True):
            z[row] = reduced(values, period)
        return z, self.system.inside(z)

    def projected(self, z: np.ndarray) -> np.ndarray:
        """Return the coordinates (2, ...) of states (2n, ...), angles in [-T/2, T/2)."""
        return np.array([reduced(z[row], period) for row, period in zip(self.rows, self.periods, strict=True)])

    def extent(self) -> list[float]:
        """Return a first frame [u0, u1, v0, v1]: whole periods, turns, bounded orbits or the bend of the map."""
        T, S = self.periods
        if T and S:
            turn = 0.0
        elif T:
            turn = self._turn(0)
        elif S:
            turn = self._turn(1)
        else:
            turn = 0.0
        u0, u1, v0, v1 = _square(turn / 2) if (T and S) or turn else self._bounds()
        return [-T / 2 if T else u0, T / 2 if T else u1, -S / 2 if S else v0, S / 2 if S else v1]

    def _turn(self, k: int) -> float:
        """Return the change of the partner of the angle k for which it winds by a turn more in each iterate."""
        slope = float(jacobian(self.model, self.start)[self.rows[k], self.rows[1 - k]])
        return abs(self.periods[k] / slope) if slope and np.isfinite(slope) else 0.0

    def _tried(self, count: int, size: np.ndarray) -> np.ndarray:
        """Return starts (2n, sizes * count) in squares of these half widths (sizes,)."""
        z = np.repeat(self.start[:, None], size.size * count, axis=1)
        for row, share, period in zip(self.rows, PLASTIC, self.periods, strict=True):
            place = (0.5 + (np.arange(count) + 1) * share) % 1
            z[row] = np.ravel(size[:, None] * 0 + place * period if period else size[:, None] * (2 * place - 1))
        return z

    def _stay(self, z: np.ndarray, far: np.ndarray, count: int, sees: Callable[[np.ndarray, int], None]) -> np.ndarray:
        """Return a mask of the starts that stay within `far` for so many iterates."""
        alive = np.ones(z.shape[1], bool)
        periods = np.array(self.model.periods())[:, None]
        with np.errstate(all="ignore"):
            for k in range(count):
                alive &= self.system.inside(z)
                z = np.array(np.broadcast_arrays(*self.model.iterate(*z)))
                z = np.where(periods > 0, z - periods * np.rint(z / np.where(periods > 0, periods, 1.0)), z)
                for row, period in zip(self.rows, self.periods, strict=True):
                    alive &= (period > 0) | (np.abs(z[row]) < far)
                sees(z, k)
        return alive

    def _bounds(self) -> list[float]:
        kept = self._stay(self._tried(TRIED, SIZES), np.repeat(FAR * SIZES, TRIED), LOOKS, lambda z, k: None)
        share = kept.reshape(SIZES.size, TRIED).mean(axis=1)
        some = np.flatnonzero(share >= SOME)
        if not some.size or share[some[-1] :].min() == 1.0:
            return _square(self._bend())
        size = SIZES[some[-1]]
        seen = []

        def sees(z: np.ndarray, k: int) -> None:
            if 2 * k >= LONG:
                seen.append(self.projected(z))

        stayed = self._stay(self._tried(STARTS, np.array([size])), FAR * size, LONG, sees)
        points = np.array(seen)[:, :, stayed]
        return [*_ends(points[:, 0]), *_ends(points[:, 1])] if stayed.any() else _square(float(size))

    def _bend(self) -> float:
        """Return a size at which the derivative of the map differs from that at the start."""
        columns = list(self.rows)
        first = jacobian(self.model, self.start[:, None])[:, columns]
        other = jacobian(self.model, self._tried(TRIED, SIZES))[:, columns]
        with np.errstate(all="ignore"):
            change = np.abs(other - first).max(axis=(0, 1)).reshape(SIZES.size, TRIED).max(axis=1)
            bent = np.flatnonzero(~(change <= BENT * np.abs(first).max()))
        return float(BENDS * SIZES[bent[0]]) if bent.size else 1.0


def survived(chaos: Any) -> int:
    """Return the number of iterates of the first orbit in a chaos map of a map, without the one that leaves."""
    return int(chaos.t[0]) - int(chaos.status[0] != Status.OK)


def map_reading(plane: Plane, z0: np.ndarray, states: np.ndarray, points: np.ndarray) -> dict[str, Any]:
    """Return rotation number and tunes of an orbit of iterates states (2n, count), points (2, count) of the plane, as
    map_orbit.js does.
    """
    model = plane.model
    count = states.shape[1]
    if count < LEAST:
        return {"rotation": None, "frequencies": None}
    tunes = frequency_map(model, z0, time=count)
    values, errors = ([float(x) if np.isfinite(x) else None for x in row[:, 0]] for row in (tunes.nu, tunes.error))
    lines = {"names": list(model.coordinates), "values": values, "errors": errors}
    at = plane.rows[0]
    alone = model.degrees_of_freedom == 1
    value = values[at]
    error = errors[at]
    if alone and not plane.periods[0]:
        turning = curve_rotation(points)
        if turning is not None and turning.q:
            return {"rotation": turning.record(), "frequencies": lines}
        value, error = (None, None) if turning is None else turning[:2]
    if value is None or error is None:
        return {"rotation": None, "frequencies": lines}
    rotation: dict[str, Any] = {"value": value, "error": error}
    locked = [q for q in range(1, LOCKED + 1) if abs(q * value - round(q * value)) <= q * min(error, 1 / count)]
    if alone and locked:
        q = locked[0]
        secondary = curve_rotation(_lifted(plane, z0, states, points, round(q * value), q)[:, q - 1 :: q])
        rotation |= {
            "q": q,
            "secondary": None if secondary is None else {"value": secondary.value, "error": secondary.error},
        }
    return {"rotation": rotation, "frequencies": lines}


def _lifted(plane: Plane, z0: np.ndarray, states: np.ndarray, points: np.ndarray, p: int, q: int) -> np.ndarray:
    """Return points (2, count), an angle without the turns that an island of a chain p/q makes."""
    period = plane.periods[0]
    if not period:
        return points
    before = np.concatenate([z0[:, None], states[:, :-1]], axis=1)
    turns = np.cumsum(np.broadcast_to(plane.model.iterate(*before)[0], points.shape[1:]) - before[0])
    return np.array([turns - period * p * np.arange(1, points.shape[1] + 1) / q, points[1]])


def reduced(x: Any, period: float) -> np.ndarray:
    """Return numbers in [-T/2, T/2), themselves where there is no period T."""
    values = np.asarray(x, dtype=np.float64)
    if not period > 0:
        return values
    rest = values - period * np.floor(values / period + 0.5)
    half = period / 2
    return np.where((rest < -half) | (rest >= half), -half, rest)


def _square(size: float) -> list[float]:
    return [-size, size, -size, size]


def _ends(values: np.ndarray) -> tuple[float, float]:
    """Return the range of all but a few of some numbers, with an edge around."""
    ordered = np.sort(values.ravel())
    skip = int(QUANTILE * ordered.size)
    low = ordered[skip]
    high = ordered[ordered.size - 1 - skip]
    edge = EDGE * (high - low) or EDGE * abs(high) or 1.0
    return float(low - edge), float(high + edge)
