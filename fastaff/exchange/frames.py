"""Tables of pandas, polars and Astropy: a row for each sample, of one orbit or of several told apart by a column."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.foreign import Foreign
from ..core.numbers import fits, listed, numbers, shown
from ..runs.given_orbits import ORBITS, SAMPLES
from .taylor import of_columns, turn


def orbits(table: Any, name: str, coordinates: tuple[str, ...] | None) -> Foreign | None:
    """Return the orbits of a table; None for a single column, which is an array.

    A column named as in `ORBITS`, or with "id" at its end, tells orbits apart, in the order in which they first appear;
    one as in `SAMPLES` orders them in time. Missing rows of an orbit are NaN. The columns are those of `coordinates`.
    """
    columns = _columns(table)
    if columns is None:
        return None
    if coordinates is None:
        raise ValueError(
            f"coordinates must name the columns q1, ..., qn, p1, ..., pn of the table {name}, which has "
            f"{listed(columns)}"
        )
    missing = [entry for entry in coordinates if entry not in columns]
    if missing:
        raise ValueError(f"coordinates must be columns of {name}, which has {listed(columns)}, got {shown(missing[0])}")
    rest = {entry.lower(): entry for entry in columns if entry not in coordinates}
    numbered = [word for word in rest if word.endswith("id")]
    words = ((*ORBITS, *numbered), SAMPLES)
    owner, time = (next((rest[word] for word in known if word in rest), None) for known in words)
    values = [numbers(f"{name}[{entry!r}]", columns[entry]) for entry in coordinates]
    times = None if time is None else numbers(f"{name}[{time!r}]", columns[time])
    if owner is None:
        order = np.arange(len(values[0])) if times is None else np.argsort(times, kind="stable")
        return Foreign(np.array(values)[:, order], None if times is None else times[order], coordinates)
    if times is None:
        raise ValueError(
            f"{name} must have a column 'time' or 'turn' that orders the rows of several orbits ({shown(owner)})"
        )
    known, first, orbit = np.unique(np.asarray(columns[owner]), return_index=True, return_inverse=True)
    orbit = np.argsort(np.argsort(first))[orbit]
    moments, sample = np.unique(times, return_inverse=True)
    if np.unique(orbit * moments.size + sample).size != sample.size:
        raise ValueError(f"{name} must have one row for each {shown(owner)} and {shown(time)}, it has several")
    fits(name, len(values), known.size, moments.size)
    array = np.full((len(values), known.size, moments.size), np.nan)
    array[:, orbit, sample] = values
    return Foreign(array, moments, coordinates)


def lattice(table: Any) -> str | None:
    """Return the map of one turn of a table of its coefficients as a text; None for other values."""
    columns = _columns(table)
    return None if columns is None else turn(of_columns(columns, "text"))


def _columns(table: Any) -> dict[str, Any] | None:
    """Return the columns of a table by name, with the levels of an index that have names; None for no table."""
    if isinstance(table, dict):
        return table
    if hasattr(table, "collect"):
        raise TypeError(f"a {type(table).__name__} of polars has no rows yet: give its .collect()")
    listed = getattr(table, "columns", None)
    if listed is None:
        return None
    levels = getattr(getattr(table, "index", None), "names", ())
    named = {str(level): table.index.get_level_values(level) for level in levels if level is not None}
    return named | {str(entry): table[entry] for entry in listed}
