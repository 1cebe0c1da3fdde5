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
    """Hold orbits of three bodies in a plane.

    The masses are 1, 1 and m; the gravitational constant is 1.

    Attributes
    ----------
    model : model
        System of x1, y1, x2, y2, x3, y3 and their momenta.
    z0 : ndarray, shape (12, orbits)
        Initial conditions.
    period : ndarray, shape (orbits,), time
        Periods.
    """

    model: Any
    z0: np.ndarray
    period: np.ndarray


def three_bodies(v1: ArrayLike, v2: ArrayLike, period: ArrayLike, m3: float = 1.0) -> ThreeBodies:
    """Return orbits of three bodies that begin on a line.

    Parameters
    ----------
    v1, v2 : float or array_like, shape (orbits,)
        Velocity of the first two bodies in x and y. The third has -2 (v1, v2)/m3.
    period : float or array_like, shape (orbits,)
        Periods.
    m3 : float, default 1
        Mass of the third body; the others have mass 1. The gravitational constant is 1.

    Returns
    -------
    `ThreeBodies`
        Model and initial conditions for `integrate`, `periodic_orbits` and `continuation`. Bodies come close, so use
        ``scheme="verner9"``.

    Raises
    ------
    TypeError
        If an argument is not a number or an array of numbers.
    ValueError
        If `m3` is not positive, or if shapes do not match.

    Notes
    -----
    The bodies begin at (-1, 0), (1, 0) and (0, 0): the isosceles collinear initial conditions of the tables.

    References
    ----------
    Suvakov & Dmitrasinovic 2013, PRL 110, 114301; Li & Liao 2017, SCPMA 60, 129511; Li+ 2018, PASJ 70, 64.

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
    """Read a table of three-body orbits.

    Parameters
    ----------
    path : path
        Text, or a page of Li & Liao, github.com/sjtu-liao/three-body.
    m3 : float, default 1
        Mass of the third body. Among rows with a mass in parentheses, only rows with this mass are read.

    Returns
    -------
    `ThreeBodies`
        Model and initial conditions.

    Raises
    ------
    ValueError
        If no row has three numbers, or if the states have other scaled periods than the table.
    OSError
        If the file cannot be read.

    Notes
    -----
    The first numbers with two or more decimals of a line, or of a row of HTML, are v1, v2, the period and, optionally,
    the scaled period ``T |E|^(3/2)``.

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
        raise ValueError(f"path must be a table with v1, v2 and a period in a row for m3 = {m3:g}, got {path}")
    v1, v2, period, scaled = np.array(rows).T
    table = three_bodies(v1, v2, period, m3)
    off = np.abs(table.period * np.abs(system_of(table.model).energies(table.z0)) ** 1.5 / scaled - 1)
    if np.nanmax(off, initial=0.0) > 1e-3:  # beyond the digits of a table
        raise ValueError(f"path must have scaled periods T |E|^(3/2) of its states, row {np.nanargmax(off)} has not")
    return table
