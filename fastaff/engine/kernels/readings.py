"""Readings of tangent vectors: functions of the numbers kept of their growth, one number for an orbit.

A reading is reading(growth, i, *parameters), lane i of a `Growth`; see `deviations` for its rows.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..elementary import exp, log
from ..jit import LANES, jit
from .deviations import ROWS, Parts, parts_of

LN10 = math.log(10.0)


class Growth(NamedTuple):
    """Hold numbers kept of the deviation vectors of a block of orbits.

    Attributes
    ----------
    n : int
        Degrees of freedom.
    k : int
        Number of deviation vectors.
    parts : Parts
        First rows of the parts of the memory.
    memory : ndarray
        Flat memory: row r of lane i is memory[r*LANES + i], with LANES of ``fastaff.engine.jit``.
    """

    n: int
    k: int
    parts: Parts
    memory: Any


@jit
def growth_of(n, k, m, memory):
    """Return the view of the memory for k vectors of n degrees of freedom and m readings."""
    return Growth(n, k, parts_of(n, k, m), memory)


@jit(inline=True)
def time(growth, i):
    """Return the time of an orbit.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Time.

    Examples
    --------
    >>> from fastaff.engine.kernels import readings
    >>> growth = readings.growth_of(2, 2, 0, np.zeros(29 * 128))
    >>> growth.memory[3 * 128 + 5] = 40.0
    >>> readings.time(growth, 5)
    40.0
    """
    return growth.memory[ROWS.last * LANES + i]


@jit(inline=True)
def length(growth, j, i):
    """Return the logarithm of the length of a deviation vector.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    j : int
        Number of the vector, from 0.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Natural logarithm of the length, 0 at the start.

    Examples
    --------
    >>> from fastaff.engine.kernels import readings
    >>> growth = readings.growth_of(2, 2, 0, np.zeros(29 * 128))
    >>> growth.memory[growth.parts.lengths * 128 + 5] = 1.5
    >>> readings.length(growth, 0, 5)
    1.5
    """
    return growth.memory[(growth.parts.lengths + j) * LANES + i]


@jit(inline=True)
def stretch(growth, j, i):
    """Return the logarithm of the growth that one more vector adds to a volume.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    j : int
        Number of the vector, from 0.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Natural logarithm of the growth of the volume of vectors 0 ... j over that of 0 ... j - 1.

    Examples
    --------
    >>> from fastaff.engine.kernels import readings
    >>> growth = readings.growth_of(2, 2, 0, np.zeros(29 * 128))
    >>> growth.memory[(growth.parts.sums + 1) * 128 + 5] = -1.5
    >>> readings.stretch(growth, 1, 5)
    -1.5
    """
    return growth.memory[(growth.parts.sums + j) * LANES + i]


@jit
def first_length(growth, i):
    """Return the growth of the first deviation vector.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Growth in decades.
    """
    return length(growth, 0, i) / LN10


@jit
def first_stretch(growth, i):
    """Return the growth of the first of the orthonormal vectors.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Growth in decades.
    """
    return stretch(growth, 0, i) / LN10


@jit
def largest_length(growth, i):
    """Return the largest growth of the first deviation vector at any step.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Growth in decades.
    """
    return growth.memory[ROWS.largest * LANES + i] / LN10


@jit
def largest_across(growth, i):
    """Return the largest growth of the first vector across the flow at any step.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Growth in decades of the part across the flow.
    """
    return growth.memory[ROWS.largest_across * LANES + i] / LN10


@jit
def mean_megno(growth, i):
    """Return the mean of MEGNO over the time.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Mean of MEGNO.
    """
    return growth.memory[ROWS.area * LANES + i] / time(growth, i)


@jit
def log_volume(growth, i, count):
    """Return the logarithm of the volume of normalised deviation vectors.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.
    count : int
        Number of vectors, the first ones.

    Returns
    -------
    float
        Natural logarithm of the volume, at most 0.

    Examples
    --------
    >>> from fastaff.engine.kernels import readings
    >>> growth = readings.growth_of(2, 2, 0, np.zeros(29 * 128))
    >>> growth.memory[growth.parts.lengths * 128 + 5] = 1.5
    >>> readings.log_volume(growth, 5, 2)
    -1.5
    """
    total = 0.0
    for j in range(int(count)):
        total += stretch(growth, j, i) - length(growth, j, i)
    return min(total, 0.0)


@jit
def volume(growth, i, count):
    """Return GALI of the first deviation vectors.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.
    count : int
        Number of vectors, the first ones.

    Returns
    -------
    float
        Decimal logarithm of GALI.

    Examples
    --------
    >>> from fastaff.engine.kernels import readings
    >>> growth = readings.growth_of(2, 2, 0, np.zeros(29 * 128))
    >>> growth.memory[growth.parts.lengths * 128 + 5] = 2 * np.log(10)
    >>> readings.volume(growth, 5, 2)
    -2.0
    """
    return log_volume(growth, i, count) / LN10


@jit
def alignment(growth, i):
    """Return SALI of the first two deviation vectors.

    Parameters
    ----------
    growth : Growth
        Numbers kept of the deviation vectors of a block of orbits.
    i : int
        Lane, the place of the orbit in its block.

    Returns
    -------
    float
        Decimal logarithm of SALI.

    Notes
    -----
    SALI is the shorter diagonal 2 sin(x/2) of two unit vectors at the angle x, where sin x is their area.

    Examples
    --------
    >>> from fastaff.engine.kernels import readings
    >>> growth = readings.growth_of(2, 2, 0, np.zeros(29 * 128))
    >>> round(10 ** readings.alignment(growth, 5), 9)  # vectors at a right angle
    1.414213562
    """
    logarithm = log_volume(growth, i, 2)
    area = exp(logarithm)
    return (logarithm + 0.5 * log(2.0 / (1.0 + math.sqrt((1.0 - area) * (1.0 + area))))) / LN10
