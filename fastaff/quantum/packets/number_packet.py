"""Gaussian packets in the quantum numbers of separable bodies, and levels found by their quantum numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.docstrings import inserts_parameters
from ...core.numbers import an_array, fits, shown, whole_numbers
from ...results.progress import says_progress
from ...systems.charts import Chart
from ...systems.models import Body
from ..spectra.spectrum import spectrum_table
from ..states.level_table import LevelTable
from ..states.quadrature import converged_box, factors, grid_tables
from ..states.state import State
from ..states.symmetry import SymmetryClass, checked_class
from .packet import Packet

TAIL = 7.7
"""Standard deviations at which weights end: 1e-13 of the largest."""


@says_progress
@inserts_parameters
def number_packet(
    model: Body,
    *,
    n: ArrayLike,
    m: int,
    l: int,
    width: ArrayLike,
    theta: ArrayLike = (0.0, 0.0, 0.0, 0.0),
    hbar: float = 1.0,
    chart: Chart | None = None,
    single_valued: bool = True,
) -> Packet:
    """Build a packet whose weights are a Gaussian in the quantum numbers of a separable body.

    Parameters
    ----------
    {body}
    n : array_like of int, shape (2,)
        Central quantum numbers of the two coordinates in the order of the chart.
    m, l : int
        Central quantum numbers of spin and vorticity.
    width : array_like, shape (2,) or (4,)
        Standard deviations of the weights in n1, n2, or in n1, n2, m, l, at least 0. For 0 the number is fixed.
    theta : array_like, shape (4,), default (0, 0, 0, 0)
        Angles in cycles. The packet starts near the phase point `from_action_angles` of these angles on the torus of n,
        m, l.
    {hbar}
    {quantum_chart}
    {single_valued}

    Returns
    -------
    Packet
        Packet of norm 1. Weights of n < 0 are cut off.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the body does not separate or an argument has a wrong value.

    Notes
    -----
    - c ~ exp(-sum of (d/(2 width))^2 - 2 pi i theta.d), with d the distance from the centre, down to ``|c|^2`` = 1e-13.
    - Phases: factors are positive next to the inner turning point.
    - Cost: one call of `spectrum_table` for all levels below the last one.

    References
    ----------
    Robinett 2004, Phys. Rep. 392, 1 (Gaussian weights); Martens & Slawianowski, EQ4.3 (the states).

    Examples
    --------
    >>> packet = fa.quantum.number_packet(fa.Body(fa.Harmonic()), n=(3, 2), m=0, l=0, width=(1.0, 0.0))
    >>> abs(packet.autocorrelation([0.0, np.pi])).round(9)
    array([1., 1.])
    """
    centre = np.array([*_pair("n", n), *checked_class(m, l, single_valued)])
    sigma = _reals("width", width, (2, 4))
    angles = _reals("theta", theta, (4,))
    if np.any(sigma < 0):
        raise ValueError(f"width must not be negative, got {shown(width)}")
    sigma = np.concatenate([sigma, np.zeros(4 - sigma.size)])
    sizes = [2 * math.ceil(TAIL * s) + 1 for s in sigma]
    fits("width", 64, *sizes)
    ranges = [
        range(c - math.ceil(TAIL * s), c + math.ceil(TAIL * s) + 1) for c, s in zip(centre.tolist(), sigma, strict=True)
    ]
    rows = np.array(list(product(*ranges)))
    steps = np.where(sigma > 0, (rows - centre) / np.where(sigma > 0, sigma, 1.0), 0.0)
    with np.errstate(over="ignore"):
        inside = ((steps**2).sum(axis=1) <= TAIL**2) & (rows[:, 0] >= 0) & (rows[:, 1] >= 0)
    if single_valued:
        inside &= rows[:, 2:].sum(axis=1) % 2 == 0
    rows = rows[inside]
    steps = steps[inside]
    pairs, spins = (sorted(set(map(tuple, part.tolist()))) for part in (rows[:, :2], rows[:, 2:]))
    classes = [SymmetryClass(m, l) for m, l in spins]
    found = dict(zip(classes, labelled_levels(model, classes, pairs, hbar, chart, single_valued), strict=True))
    states: list[Any] = []
    for n1, n2, spin, vorticity in rows.tolist():
        levels, place = found[SymmetryClass(spin, vorticity)]
        states.append(levels.state(place[n1, n2]))
    c = np.exp(-((steps / 2) ** 2).sum(axis=1) - 2j * np.pi * ((rows - centre) @ angles)) * _inner_signs(states)
    return Packet(tuple(states), np.array([state.energy for state in states]), c / np.linalg.norm(c), hbar)


def labelled_levels(
    model: Any,
    classes: Sequence[SymmetryClass],
    pairs: Sequence[tuple[int, int]],
    hbar: float,
    chart: Any,
    single_valued: bool,
) -> list[tuple[LevelTable, dict[tuple[int, int], int]]]:
    """Return the levels of classes of a separable body that include all quantum numbers in `pairs`, and the place of
    each pair in them.
    """
    m, l = zip(*classes, strict=True)
    most = max(i + j for i, j in pairs)
    count = (most + 1) * (most + 2) // 2 + most + 8  # the number of an oscillator up to there, and some more
    while True:
        tables = spectrum_table(model, m=m, l=l, count=count, hbar=hbar, chart=chart, single_valued=single_valued)
        if not all(table.separated for table in tables):
            raise ValueError(
                "model must have smooth functions of kappa and lambda for quantum numbers, got narrow ones"
            )
        places = [{(i, j): k for k, (i, j) in enumerate(table.n.T.tolist())} for table in tables]
        if all(pair in place for place in places for pair in pairs):
            return list(zip(tables, places, strict=True))
        count *= 2


def _inner_signs(states: Sequence[State]) -> np.ndarray:
    """Return the signs (states,) of states next to the inner turning points of both factors."""
    signs = np.ones(len(states))
    if factors(states, states[0].chart) is None:  # those of the elliptic chart are positive there
        return signs
    box, orders = converged_box(states)
    grid = box.grid(orders)
    for values, weights in zip(
        grid_tables(states, grid), (grid.weights.sum(axis=1), grid.weights.sum(axis=0)), strict=True
    ):
        density = values**2 * weights
        first = np.argmax(density > 1e-6 * density.max(axis=1, keepdims=True), axis=1)
        signs *= np.sign(values[np.arange(len(states)), first])
    return signs


def _pair(name: str, n: ArrayLike) -> tuple[int, int]:
    numbers = whole_numbers(name, n)
    if numbers.shape != (2,) or np.any(numbers < 0):
        raise ValueError(f"{name} must be two whole numbers of at least 0, got {shown(n)}")
    return int(numbers[0]), int(numbers[1])


def _reals(name: str, given: ArrayLike, sizes: tuple[int, ...]) -> np.ndarray:
    row = an_array(name, given)
    if row.dtype.kind not in "fiu":
        raise TypeError(f"{name} must be real numbers, got {shown(given)}")
    if row.ndim != 1 or row.size not in sizes or not np.isfinite(row).all():
        raise ValueError(f"{name} must be {' or '.join(map(str, sizes))} finite numbers, got {shown(given)}")
    return row.astype(float)
