"""The cases of a scan of parameters as a list, any of them, of which results on disk are made."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Annotated

import numpy as np

from ...base.axes import along
from ...base.results import Result
from .chaotic_fraction import ChaoticFraction


@dataclass(frozen=True)
class FoundCases(Result, axis="case"):
    """What a scan found of each case; the fields are those of `ChaoticFraction`."""

    values: Annotated[np.ndarray, along("parameter", "case", labels="names")]
    names: tuple[str, ...]
    orbits: Annotated[np.ndarray, along("case")]
    chaotic: Annotated[np.ndarray, along("case")]
    regular: Annotated[np.ndarray, along("case")]
    undecided: Annotated[np.ndarray, along("case")]
    rescued: Annotated[np.ndarray, along("case")]
    statuses: Annotated[np.ndarray, along("outcome", "case")]
    indicators: tuple[str, ...]
    medians: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    chaotic_medians: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    limits: Annotated[np.ndarray, along("indicator", "case", labels="indicators")]
    time: Annotated[np.ndarray, along("case", unit="time")]
    step: Annotated[np.ndarray, along("case", unit="time")]
    energy_error: Annotated[np.ndarray, along("case", unit="largest kinetic energy")]
    done: Annotated[np.ndarray, along("case")]

    @classmethod
    def of(cls, scan: ChaoticFraction) -> FoundCases:
        """Return the cases of a scan as a list, the last parameter fastest."""
        values = np.array([grid.ravel() for grid in np.meshgrid(*scan.axes, indexing="ij")])
        cases = len(scan.axes)
        arrays = {
            name: (array := getattr(scan, name)).reshape(*array.shape[: array.ndim - cases], values.shape[1])
            for name in _ARRAYS
        }
        return cls(values=values, names=scan.names, indicators=scan.indicators, **arrays)

    def assembled(self, axes: tuple[np.ndarray, ...]) -> ChaoticFraction:
        """Return the scan over these axes; cases that are missing here are not done."""
        place = [np.searchsorted(axis, row) for axis, row in zip(axes, self.values)]
        arrays = {}
        for name in _ARRAYS:
            array = getattr(self, name)
            empty = np.nan if array.dtype.kind == "f" else 0
            arrays[name] = np.full((*array.shape[:-1], *(axis.size for axis in axes)), empty, array.dtype)
            arrays[name][(..., *place)] = array
        return ChaoticFraction(names=self.names, axes=axes, indicators=self.indicators, **arrays)


_ARRAYS = tuple(entry.name for entry in fields(FoundCases) if entry.name not in ("values", "names", "indicators"))
