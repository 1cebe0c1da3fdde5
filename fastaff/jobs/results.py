"""The results of a job by analysis, in memory or in a store, and a table of the outcomes of the orbits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..core.interruption import imported
from ..core.numbers import MOST, listed, shown
from ..core.status import Status
from .chunks import LOG, Chunk, again_to_run, outcomes, waiting
from .guard import reported_as_damage
from .job import Job, in_one_line
from .scans import FoundCases, assembled
from .store import ATTEMPT, DONE, WAITING, Store


class JobResults:
    """Results of a job by the name of the analysis, for example ``results["frequency_map"]``.

    Results in a store are read on access. ``results["frequency_map", 0:100_000]`` reads the finished orbits among these
    points of the launch set.

    Parameters
    ----------
    job : Job
        The job.
    found : dict, optional
        Results in memory by name, None for a store.
    place : ndarray of int, shape (orbits,)
        Numbers of the orbits in the launch set.
    path : Path, optional
        Path of the store, None in memory.
    chunks : sequence of Chunk, optional
        Outcomes of the chunks.
    """

    def __init__(
        self, job: Job, found: dict[str, Any] | None, place: np.ndarray, path: Path | None, chunks: Any = ()
    ) -> None:
        self.job = job
        self.path = path
        self.chunks = list(chunks)
        self._found = found
        self._place = place

    @classmethod
    def stored(cls, path: Any, job: Job | None = None, **own: Any) -> JobResults:
        """Return the results in a store, finished or not.

        Parameters
        ----------
        path : path_like
            Path of the store.
        job : Job, optional
            The job. Default: the job that the store describes.
        **own : Any
            ``model`` or ``initial_conditions`` that TOML cannot describe.

        Returns
        -------
        JobResults
            The results.
        """
        store = Store(path)
        if job is None:
            if store.facts["own_initial_conditions"]:
                own = {"initial_conditions": store.root["launch/z0"][:, :1], **own}
            job = Job.parsed(store.facts["job"], str(path), **own)
        return cls(job, None, np.zeros(0), Path(path), _logged(Path(path)))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the analyses."""
        return ("chaotic_fraction",) if self.job.scan is not None else tuple(self.job.analyses())

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, key: str | tuple[str, slice]) -> Any:
        """Return the result of an analysis of all finished orbits; results[name, start:stop] is that of the finished
        orbits between two points of the launch set.
        """
        name, *points = key if isinstance(key, tuple) else (key,)
        if name not in self.names:
            raise KeyError(f"the job has {listed(self.names)}, not {shown(name)}")
        if points:
            return self._part(name, points)
        if self._found is not None:
            return self._found[name]
        found = Store(self.path).read(name)
        return assembled(found, self._cases()) if isinstance(found, FoundCases) else found

    def _part(self, name: str, points: list[Any]) -> Any:
        """Return the result of the finished orbits between two points."""
        if self.job.scan is not None:
            raise TypeError(f"a scan goes by cases, not points: results[{shown(name)}]")
        if len(points) != 1 or not isinstance(points[0], slice) or points[0].step not in (None, 1):
            raise TypeError(f"points must be one slice without a step, such as 0:100_000, got {points}")
        if self._found is not None:
            first, last, _ = points[0].indices(int(self._place.max(initial=-1)) + 1)
            return self._found[name].take((self._place >= first) & (self._place < last))
        store = Store(self.path)
        first, last, _ = points[0].indices(store.orbits)
        return store.read(name, slice(first, max(first, last)))

    def _cases(self) -> Any:
        return self.job.plan().launch

    @property
    def place(self) -> np.ndarray:
        """Numbers of the finished orbits in the launch set, cells for a grid, shape (orbits,)."""
        return self._place if self._found is not None else np.flatnonzero(Store(self.path).finished() == DONE)

    @property
    def complete(self) -> bool:
        """Whether all orbits are finished, including reruns."""
        return self._found is not None or not waiting(Store(self.path)).size

    def counts(self) -> dict[str, dict[str, int]]:
        """Return the number of orbits of each status.

        Returns
        -------
        dict of dict of int
            Numbers by analysis and name of the status.
        """
        field = "status" if self.job.scan is None else "statuses"
        return {name: outcomes(self._column(name, field)) for name in self.names}

    def attempts(self, name: str) -> np.ndarray:
        """Return the attempt that computed each finished orbit.

        Parameters
        ----------
        name : str
            Name of the analysis.

        Returns
        -------
        ndarray of int, shape (orbits,)
            0 for the first computation, else the number of the rerun.
        """
        values = self._column(name, ATTEMPT)
        return np.zeros(len(self.place), np.int16) if values is None else values

    def worst_energy_error(self) -> dict[str, float]:
        """Return the largest relative energy error of each analysis that has one.

        Returns
        -------
        dict of float
            Errors by analysis.
        """
        found = {}
        for name in self.names:
            values = self._column(name, "energy_error")
            if values is not None and np.isfinite(values).any():
                found[name] = float(np.nanmax(values))
        return found

    def table(self) -> str:
        """Return a table of the outcomes of the orbits.

        Returns
        -------
        str
            Number and share of each status, largest energy error, slowest chunk.
        """
        lines = []
        worst = self.worst_energy_error()
        for name, counts in self.counts().items():
            total = sum(counts.values())
            shares = ", ".join(f"{count} {status} ({count / total:.2%})" for status, count in counts.items())
            error = f"; largest energy error {worst[name]:.1e}" if name in worst else ""
            lines.append(f"{name}: {total} orbits: {shares or 'none'}{error}")
        if note := self._escape():
            lines.append(note)
        if self.path is not None:
            store = Store(self.path)
            state = store.finished()
            absent = np.count_nonzero(state == 0)
            missing = np.count_nonzero(state == WAITING)
            for attempt, again in enumerate(store.facts["reruns"], 1):
                count = sum(int(np.count_nonzero(self.attempts(name) == attempt)) for name in self.names)
                changed = ", ".join(f"{name} {value}" for name, value in again["options"].items())
                lines.append(f"run again with {changed}: {count} orbits")
            if left := int(np.count_nonzero(again_to_run(store))):
                lines.append(f"{left} orbits still to be run again")
            if store.facts["other_cpu_allowed"]:
                lines.append("computed by processors of several kinds: the last digits may differ between chunks")
            if absent:
                lines.append(f"{absent} points beyond the energy")
            if missing:
                lines.append(f"{missing} points not computed yet")
        if self.chunks:
            slow = max(self.chunks, key=lambda chunk: chunk.seconds)
            lines.append(f"slowest chunk {slow.number}: {slow.orbits} orbits in {slow.seconds:.1f} s")
        return "\n".join(map(in_one_line, lines))

    def _escape(self) -> str | None:
        """Return a note on the energy where orbits escaped."""
        found = [self._column(name, "status") for name in self.names]
        gone = [status for status in found if status is not None]
        if self.job.scan is not None or not gone:
            return None
        return self.job.energy_surface.escape(self.job.plan().system, np.concatenate(gone))

    def __repr__(self) -> str:
        where = "in memory" if self.path is None else f"in {self.path}"
        return f"JobResults: {', '.join(self.names)}, {where}"

    def to_xarray(self, chunks: Any = None) -> Any:
        """Open the store as an ``xarray.DataTree`` that reads arrays on access.

        Unlike all other reads, these are not compared with the checksums of the store.

        Parameters
        ----------
        chunks : dict, optional
            Chunks for dask, as in ``xarray.open_datatree``; {} uses the chunks of the job. Default: no dask.

        Returns
        -------
        xarray.DataTree
            The store.
        """
        if self.path is None:
            raise ValueError("these results are in memory: results[name].to_xarray() gives each of them")
        xarray = imported("xarray", what="to_xarray")
        if chunks is not None:
            imported("dask", what="to_xarray with chunks")
        with reported_as_damage(f"{self.path} is damaged"):
            return xarray.open_datatree(str(self.path), engine="zarr", chunks=chunks)

    def to_netcdf(self, path: Any) -> None:
        """Write the store as NetCDF, for other programs.

        Parameters
        ----------
        path : path_like
            Path of the file.
        """
        imported("h5netcdf", what="to_netcdf")
        if self.path is not None:
            Store(self.path).verify()
        self.to_xarray().to_netcdf(str(path), engine="h5netcdf")

    def _column(self, name: str, field: str) -> Any:
        """Return an array of an analysis for the finished orbits; None where it has none of that name."""
        if self._found is not None:
            return getattr(self._found[name], field, None)
        store = Store(self.path)
        if field not in store.root[name]:
            return None
        return np.asarray(store.root[f"{name}/{field}"][...][..., store.finished() == DONE])


def _logged(path: Path) -> list[Chunk]:
    """Return the chunks of the log, without a last line that was cut off."""
    found = {}
    try:
        lines = (path / LOG).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
    for line in lines:
        try:
            entry = Chunk(**json.loads(line))
        except (ValueError, TypeError, RecursionError):
            continue
        if _is_chunk(entry):
            found[entry.number] = entry
    return list(found.values())


def _is_chunk(entry: Chunk) -> bool:
    """Tell whether the fields of a line have the right kinds and ranges."""
    counts = (entry.number, entry.orbits, entry.crossings)
    return (
        all(type(count) is int and 0 <= count <= MOST for count in counts)
        and type(entry.seconds) is type(entry.energy_error) is float
        and 0 <= entry.seconds <= MOST
        and entry.energy_error >= 0
        and isinstance(entry.statuses, dict)
        and all(isinstance(found, dict) and _are_outcomes(found) for found in entry.statuses.values())
        and all(name.isidentifier() for name in entry.statuses)
    )


def _are_outcomes(found: dict[str, Any]) -> bool:
    return all(
        name in Status.__members__ and type(count) is int and 0 <= count <= MOST for name, count in found.items()
    )
