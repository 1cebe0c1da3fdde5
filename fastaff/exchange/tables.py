"""Results as files of other programs: CSV and Parquet tables, NetCDF, MATLAB."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..core.interruption import imported
from ..core.numbers import listed, shown
from ..core.placing import write_atomically
from ..results.result import Result, columns


def table(result: Result) -> dict[str, np.ndarray]:
    """Return columns with an entry for each item: arrays along the items, NAME, and rows of arrays with one more axis,
    NAME_LABEL or NAME_NUMBER; complex ones as NAME_re, NAME_im. Arrays of more axes, such as samples, are left out.
    """
    found: dict[str, np.ndarray] = {}
    for name, value, axes, labels, _ in columns(result):
        if value.ndim == 1 and len(axes) == 1:
            found[name] = value
        elif value.ndim == 2 and len(axes) == 2:
            numbered = labels or tuple(map(str, range(1, len(value) + 1)))
            found |= {f"{name}_{label}": row for label, row in zip(numbered, value, strict=True)}
    for name, value in list(found.items()):
        if value.dtype.kind == "c":
            found |= {f"{name}_re": value.real, f"{name}_im": value.imag}
            del found[name]
    if not found:
        raise TypeError(f"result must have arrays along several items for a table, got a {type(result).__name__}")
    return found


def _csv(path: Path, result: Result) -> None:
    found = table(result)
    with open(path, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(found)
        rows.writerows(zip(*(value.tolist() for value in found.values()), strict=True))


def _parquet(path: Path, result: Result) -> None:
    arrow, parquet = (imported(name, what="a Parquet table (.csv does not)") for name in ("pyarrow", "pyarrow.parquet"))
    parquet.write_table(arrow.table({name: np.ascontiguousarray(v) for name, v in table(result).items()}), path)


def _netcdf(path: Path, result: Result) -> None:
    imported("h5netcdf", what="a NetCDF file")
    data = result.to_xarray()
    own = any(array.dtype.kind == "c" for array in data.values())  # HDF5 has complex numbers, NetCDF none
    path.write_bytes(data.to_netcdf(engine="h5netcdf", invalid_netcdf=own))


def _matlab(path: Path, result: Result) -> None:
    content = result.to_dict()
    entries = {name: entry["data"] for part in ("coords", "data_vars") for name, entry in content[part].items()}
    texts = {name: f"{value}" for name, value in content["attrs"].items()}
    imported("scipy.io").savemat(path, {**entries, "facts": texts}, long_field_names=True, oned_as="column")


WRITERS = {".csv": _csv, ".mat": _matlab, ".nc": _netcdf, ".parquet": _parquet}
"""Functions that write files of each ending."""


def exported(path: Path, result: Any, overwrite: bool, parameters: Mapping[str, Any]) -> Path:
    """Write a result as a file of other programs, of the ending of a path; ValueError for one that is none of them."""
    if path.suffix not in WRITERS:
        raise ValueError(f"path must end in .npz, {listed(WRITERS)}, or have no ending, got {shown(path.name)}")
    if not isinstance(result, Result):
        raise TypeError(f"result must be a result of fastaff, such as a SectionMap, got {type(result).__name__}")
    if parameters:
        raise ValueError(f"{next(iter(parameters))} is kept in .npz files alone, got a path that ends in {path.suffix}")
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_atomically(
        path.with_suffix(""), path.suffix, lambda file: WRITERS[path.suffix](file, result), overwrite=overwrite
    )
