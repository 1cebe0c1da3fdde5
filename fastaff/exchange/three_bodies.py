"""Periodic orbits of three bodies in a plane, from the tables of initial velocities in which they are published."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..core.numbers import StrPath, numbers, positive
from ..core.placing import text_of
from ..systems.formulas.formula import hamiltonian
from ..systems.models.mechanics import system_of

NUMBER = re.compile(r"-?\d+\.\d{2,}(?:[eE][-+]?\d+)?")
"""Velocities, periods and scaled periods, but no numbers of orbits and no masses of one digit."""

MASS = re.compile(r"\((\d+(?:\.\d+)?)\)")
"""Masses."""

TEXT = "-1/sqrt((x1 - x2)**2 + (y1 - y2)**2)" + "".join(f" - m/sqrt((x{k} - x3)**2 + (y{k} - y3)**2)" for k in (1, 2))


class ThreeBodies(NamedTuple):
    """Bodies of masses 1, 1, m, G = 1: model, of x1, y1, ..., y3 and momenta; z0 (12, orbits), period (orbits,)."""

    model: Any
    z0: np.ndarray
    period: np.ndarray


def three_bodies(v1: ArrayLike, v2: ArrayLike, period: ArrayLike, m3: float = 1.0) -> ThreeBodies:
    """Return orbits that begin on a line, at (-1, 0), (1, 0) and (0, 0), with velocities (v1, v2) of the first two and
    -2 (v1, v2)/m3 of the third: the isosceles collinear starts of the tables.

    :Parameters: v1, v2, period: numbers or arrays (orbits,) with G = 1; m3: the third mass, those of the others are 1.
    :Returns: `ThreeBodies`, for `integrate`, `periodic_orbits`, `continuation`; bodies come close: scheme="verner9".
    :Raises: ValueError, TypeError for other numbers.
    :Source: Suvakov & Dmitrasinovic 2013, PRL 110, 114301; Li & Liao 2017, SCPMA 60, 129511; Li+ 2018, PASJ 70, 64.

    Examples
    --------
    >>> from fastaff.exchange.three_bodies import three_bodies
    >>> three_bodies(0.3471168881, 0.5327249454, 6.3259139829).z0[6:8, 0]
    array([0.34711689, 0.53272495])
    """
    given = {"v1": v1, "v2": v2, "period": period}.items()
    vx, vy, time = np.broadcast_arrays(*(np.atleast_1d(numbers(name, np.asarray(value))) for name, value in given))
    mass = positive("m3", m3)
    zero = 0.0 * vx
    model = hamiltonian(TEXT, coordinates="x1 y1 x2 y2 x3 y3", masses=(1.0,) * 4 + (mass, mass), m=mass)
    z0 = np.array([zero - 1, zero, zero + 1, zero, zero, zero, vx, vy, vx, vy, -2 * vx, -2 * vy])
    return ThreeBodies(model, z0, time.astype(float))


def read_three_bodies(path: StrPath, m3: float = 1.0) -> ThreeBodies:
    """Read a table of such orbits as `ThreeBodies`: text, or a page of Li & Liao, github.com/sjtu-liao/three-body.

    The first numbers with two decimals or more of a line, or of a row of HTML, are v1, v2, the period and perhaps the
    scaled period ``T |E|^(3/2)``. Among rows with a mass in parentheses those of m3 are taken.

    :Raises: ValueError where no row has three numbers, or where the states have other scaled periods than the table.

    Examples
    --------
    >>> from pathlib import Path
    >>> from fastaff.exchange.three_bodies import read_three_bodies
    >>> length = Path("table.txt").write_text("I.A 1: 0.3471168881 0.5327249454 6.3259139829 9.238")
    >>> read_three_bodies("table.txt").period
    array([6.32591398])
    """
    text = text_of(path)
    pieces = text.split("<tr>") if "<tr>" in text else text.splitlines()
    found = [NUMBER.findall(piece) for piece in pieces if all(float(m) == m3 for m in MASS.findall(piece)[:1])]
    rows = [[*map(float, words[:4]), np.nan][:4] for words in found if len(words) > 2]
    if not rows:
        raise ValueError(f"path must be a table with v1, v2 and a period in a row, of m3 = {m3:g}; {path} has none")
    v1, v2, period, scaled = np.array(rows).T
    table = three_bodies(v1, v2, period, m3)
    off = np.abs(table.period * np.abs(system_of(table.model).energies(table.z0)) ** 1.5 / scaled - 1)
    if np.nanmax(off, initial=0.0) > 1e-3:  # beyond the digits of a table
        raise ValueError(f"path must have scaled periods T |E|^(3/2) of its states, row {np.nanargmax(off)} has not")
    return table
