"""Periodic orbits of three bodies in the tables of JPL's Solar System Dynamics: a file of its interface, as saved."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import numpy as np

from ..core.numbers import StrPath
from ..core.placing import text_of
from ..systems.formulas.formula import hamiltonian
from ..systems.models.mechanics import system_of

TEXT = "-(1 - m)/sqrt((x + m)**2 + y**2 + z**2) - m/sqrt((x - 1 + m)**2 + y**2 + z**2)"
NEEDED = ("x", "y", "z", "vx", "vy", "vz", "jacobi", "period")
SAME = 1e-6
"""Difference of Jacobi's constants from the file's that its digits explain."""


class PeriodicTable(NamedTuple):
    """Hold periodic orbits of the circular restricted three-body problem.

    The frame rotates. Lengths and times are in the units of the distance and the motion of the primaries.

    Attributes
    ----------
    model : model
        System with the mass ratio m.
    z0 : ndarray, shape (6, orbits)
        Initial conditions: x, y, z and the momenta in a frame at rest, p_x = vx - y, p_y = vy + x, p_z.
    period : ndarray, shape (orbits,), time
        Periods.
    jacobi : ndarray, shape (orbits,)
        Jacobi constants.
    stability : ndarray, shape (orbits,)
        Stability indices, NaN if the file has none.
    family : str
        Name of the family.
    length : float, km
        Unit of length, NaN if the file has none.
    time : float, s
        Unit of time, NaN if the file has none.
    """

    model: Any
    z0: np.ndarray
    period: np.ndarray
    jacobi: np.ndarray
    stability: np.ndarray
    family: str
    length: float
    time: float


def read_periodic(path: StrPath) -> PeriodicTable:
    """Read a file of periodic orbits of JPL's Solar System Dynamics.

    Parameters
    ----------
    path : path
        File of ssd-api.jpl.nasa.gov/periodic_orbits.api, with the keys system, fields and data.

    Returns
    -------
    `PeriodicTable`
        Model and orbits. Its z0 suits `integrate`, `periodic_orbits` and `continuation`.

    Raises
    ------
    ValueError
        If a key or a field is missing, or if the states have other Jacobi constants than the file.
    OSError
        If the file cannot be read.

    Notes
    -----
    The Jacobi constant is C = x^2 + y^2 + 2 (1 - m)/r1 + 2 m/r2 - v^2, with or without the constant m (1 - m).

    Examples
    --------
    >>> import json
    >>> from pathlib import Path
    >>> from fastaff.exchange.jpl import read_periodic
    >>> names = ["x", "y", "z", "vx", "vy", "vz", "jacobi", "period"]
    >>> row = ["0.4", "0.8660254037844386", "0", "0", "0", "0", "2.91", "6.28"]  # rest at L4
    >>> content = {"system": {"mass_ratio": "0.1"}, "fields": names, "data": [row]}
    >>> length = Path("orbits.json").write_text(json.dumps(content))
    >>> read_periodic("orbits.json").z0[:, 0].round(6)
    array([ 0.4     ,  0.866025,  0.      , -0.866025,  0.4     ,  0.      ])
    """
    try:
        found = json.loads(text_of(path))
        system = found["system"]
        fields = list(found["fields"])
        table = np.array(found["data"], dtype=float).T
        mass = float(system["mass_ratio"])
        columns = {name: table[fields.index(name)] for name in NEEDED}
    except (KeyError, ValueError, TypeError, IndexError) as problem:
        raise ValueError(
            f"path must be a file of JPL's periodic orbits with system, fields and data: {problem}"
        ) from None
    model = hamiltonian(TEXT, coordinates="x y z", rotation=1.0, m=mass)
    x, y, z, vx, vy, vz, jacobi, period = columns.values()
    z0 = np.array([x, y, z, vx - y, vy + x, vz])
    off = jacobi + 2 * system_of(model).energies(z0)
    if np.minimum(np.abs(off), np.abs(off - mass * (1 - mass))).max(initial=0.0) > SAME:
        raise ValueError(
            f"data must have the Jacobi constants of the states, they differ by up to {np.abs(off).max():.2g}"
        )
    stability = table[fields.index("stability")] if "stability" in fields else np.full(period.shape, np.nan)
    units = (float(system.get(name, "nan")) for name in ("lunit", "tunit"))
    return PeriodicTable(model, z0, period, jacobi, stability, str(found.get("family", "")), *units)
