"""Periods and revival times of wave packets of separable bodies, from levels and from classical frequencies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...core.differences import FIRST, OFFSETS
from ...core.docstrings import inserts_parameters
from ...core.numbers import shown, whole, whole_numbers
from ...results.display import screen
from ...results.progress import says_progress
from ...systems.charts import Chart
from ...systems.models import Body
from ...tori.inverse_tori import energy_of_actions
from ...tori.separation import separate
from ..exact.quasiclassical_levels import EBK
from ..states.symmetry import SymmetryClass, action_quantum, checked_class
from .number_packet import labelled_levels

NOISE = 1e-9
"""Relative size of d nu/dJ below which differences of frequencies give 0."""


class TimeScales(NamedTuple):
    """Derivatives of the energy to quantum numbers, and the times that follow.

    Attributes
    ----------
    names : tuple of str
        Coordinates of the rows.
    slope : ndarray, shape (n,)
        First derivatives dE/dn.
    curvature : ndarray, shape (n, n)
        Second derivatives d2E/dn dn'.
    hbar : float
        Planck's constant over 2 pi.
    """

    names: tuple[str, ...]
    slope: np.ndarray
    curvature: np.ndarray
    hbar: float

    def __repr__(self) -> str:
        return screen(self)

    def summary(self) -> str:
        """Return one line with the period and the revival time of each coordinate.

        Returns
        -------
        str
            Summary.
        """
        times = zip(self.names, self.period, np.diag(self.revival), strict=True)
        return "; ".join(f"{name}: period {period:.6g}, revival {late:.6g}" for name, period, late in times)

    @property
    def period(self) -> np.ndarray:
        """Classical periods of packets, 2 pi hbar/``|dE/dn|``, shape (n,), inf for a slope of 0."""
        return _over(2 * np.pi * self.hbar, self.slope)

    @property
    def revival(self) -> np.ndarray:
        """Revival times of packets, shape (n, n), inf for a second derivative of 0.

        They are 4 pi hbar/``|d2E/dn2|`` on the diagonal and 2 pi hbar/``|d2E/dn dn'|`` for pairs.

        References
        ----------
        Robinett 2004, Phys. Rep. 392, 1; Bluhm, Kostelecky & Tudose 1996, Phys. Lett. A 222, 220 (two quantum numbers).
        """
        return _over(2 * np.pi * self.hbar * (1 + np.eye(self.slope.size)), self.curvature)


class Revivals(NamedTuple):
    """Time scales of the same packet by two methods.

    Attributes
    ----------
    quantum : TimeScales
        Time scales from differences of the levels.
    classical : TimeScales
        Time scales from the frequencies dE/dJ and their derivatives d2E/dJ2.
    """

    quantum: TimeScales
    classical: TimeScales

    def __repr__(self) -> str:
        return screen(self)

    def summary(self) -> str:
        """Return the summary of the time scales from the levels.

        Returns
        -------
        str
            Summary.
        """
        return self.quantum.summary()


@says_progress
@inserts_parameters
def revivals(
    model: Body,
    *,
    n: ArrayLike,
    m: int,
    l: int,
    hbar: float = 1.0,
    chart: Chart | None = None,
    maslov: tuple[int, int] = EBK,
    single_valued: bool = True,
    guess: ArrayLike | None = None,
) -> Revivals:
    """Compute classical period and revival time of packets about given quantum numbers.

    Parameters
    ----------
    {body}
    n : array_like of int, shape (2,)
        Quantum numbers of the two coordinates in the order of the chart, at least 1.
    {spin_vorticity}
    {hbar}
    {quantum_chart}
    maslov : tuple of int, default EBK
        Maslov indices of the two coordinates: `EBK` = (2, 2), `BOHR_SOMMERFELD` = (0, 0) or others.
    {single_valued}
    {torus_guess}

    Returns
    -------
    Revivals
        Time scales from the quantum levels and from the classical actions. The rows are the coordinates of the chart,
        then eta and gamma. Rows eta and gamma exist only if ``|p_eta|`` = ``|m - l|`` hbar/2 and ``|p_gamma|`` =
        ``|m + l|`` hbar/2 are at least hbar, because E has a kink at 0.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the body does not separate, no torus has the actions, or an argument has a wrong value.

    Notes
    -----
    - Quantum: central differences of the levels. A second derivative below their error is 0.
    - Classical: dE/dn = h nu and d2E/dn2 = h^2 dnu/dJ at J = h (n + maslov/4), by differences of order 8 of
      `energy_of_actions`, to 1e-9.
    - Both agree to O(hbar^2) at given actions.
    - Cost: milliseconds after compilation.

    References
    ----------
    Averbukh & Perelman 1989, Phys. Lett. A 139, 449; Martens & Slawianowski, section 4 (E(J)).

    Examples
    --------
    >>> fa.quantum.revivals(fa.Body(fa.Harmonic()), n=(3, 2), m=0, l=0).quantum.period.round(6)
    array([3.141593, 3.141593])
    """
    quantum = action_quantum(hbar)
    symmetry = checked_class(m, l, single_valued)
    numbers = whole_numbers("n", n)
    if numbers.shape != (2,) or np.any(numbers < 1):
        raise ValueError(f"n must be two whole numbers of at least 1, got {shown(n)}")
    indices = tuple(whole("maslov", index, 0) for index in maslov) if isinstance(maslov, (tuple, list)) else ()
    if len(indices) != 2:
        raise ValueError(f"maslov must be two indices such as EBK = (2, 2), got {shown(maslov)}")
    separated = separate(model, chart)
    turning = [i for i, momentum in ((2, symmetry.a), (3, symmetry.b)) if momentum >= 1]
    rows = [0, 1, *turning]
    names = tuple((*separated.family.coordinates, "eta", "gamma")[i] for i in rows)
    centre = np.array([*numbers, (symmetry.m - symmetry.l) / 2, (symmetry.m + symmetry.l) / 2])
    slope, curvature = _differences(_levels(model, centre, rows, quantum, separated.family.chart, single_valued), rows)
    J = 2 * np.pi * quantum * (centre + np.array([indices[0] / 4, indices[1] / 4, 0, 0]))
    return Revivals(
        TimeScales(names, slope, curvature, quantum),
        TimeScales(names, *_classical(model, J, rows, quantum, separated.family.chart, guess), quantum),
    )


def _levels(model: Any, centre: np.ndarray, rows: list[int], hbar: float, chart: str, single_valued: bool) -> Callable:
    """Return a function of an offset (4,) from the centre that gives E and its error."""
    steps = [range(-1, 2) if i in rows else range(1) for i in (2, 3)]
    spins = [(eta, gamma) for eta in steps[0] for gamma in steps[1]]
    k = [centre[2:] + np.array(spin) for spin in spins]
    classes = [SymmetryClass(round(gamma + eta), round(gamma - eta)) for eta, gamma in k]
    n1, n2 = (int(n) for n in centre[:2])
    pairs = [(n1 + i, n2 + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    found = dict(zip(spins, labelled_levels(model, classes, pairs, hbar, chart, single_valued), strict=True))

    def level(offset: np.ndarray) -> tuple[float, float]:
        levels, places = found[int(offset[2]), int(offset[3])]
        k = places[n1 + int(offset[0]), n2 + int(offset[1])]
        return levels.E[k], levels.error[k]

    return level


def _differences(level: Callable, rows: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return slope and curvature of levels, 0 where they are below the error of the levels."""
    size = len(rows)
    unit = np.eye(4, dtype=int)[rows]
    E, error = level(0 * unit[0])

    def combined(terms: list[tuple[float, np.ndarray]], rest: float) -> float:
        parts = [(weight, *level(offset)) for weight, offset in terms]
        value = sum(weight * E for weight, E, _ in parts) + rest * E
        noise = sum(abs(weight) * error for weight, _, error in parts) + abs(rest) * error
        return value if abs(value) > 2 * noise else 0.0

    slope = np.zeros(size)
    curvature = np.zeros((size, size))
    for i in range(size):
        slope[i] = combined([(0.5, unit[i]), (-0.5, -unit[i])], 0.0)
        curvature[i, i] = combined([(1.0, unit[i]), (1.0, -unit[i])], -2.0)
        for j in range(i):
            corners = [(0.25 * s * t, s * unit[i] + t * unit[j]) for s in (1, -1) for t in (1, -1)]
            curvature[i, j] = curvature[j, i] = combined(corners, 0.0)
    return slope, curvature


def _classical(
    model: Any, J: np.ndarray, rows: list[int], hbar: float, chart: str, guess: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Return h nu and h^2 dnu/dJ of the primitive actions J (4,): of the two coordinates, eta, gamma."""
    h = 2 * np.pi * hbar

    def frequencies(actions: np.ndarray) -> np.ndarray:
        a, b, eta, gamma = actions
        found = energy_of_actions(model, np.array([a, b, gamma + eta, gamma - eta]), chart=chart, guess=guess)
        if np.any(found.status):
            raise ValueError(
                f"n, m, l must belong to a torus of the body with neighbours, got the actions {shown(J.tolist())}"
            )
        nu = found.nu
        return np.array([nu[0], nu[1], nu[2] - nu[3], nu[2] + nu[3]])

    nu = frequencies(J[:, None])[rows, 0]
    slopes = np.empty((len(rows), len(rows)))
    for column, i in enumerate(rows):
        step = abs(J[i]) / 32
        points = np.repeat(J[:, None], OFFSETS.size, axis=1)
        points[i] += step * OFFSETS
        slopes[:, column] = frequencies(points)[rows] @ FIRST / step
    slopes = (slopes + slopes.T) / 2
    scale = np.abs(nu[:, None] / J[rows]) + np.abs(nu[:, None] / J[rows]).T
    return h * nu, h * h * np.where(np.abs(slopes) > NOISE * scale, slopes, 0.0)


def _over(time: Any, rate: np.ndarray) -> np.ndarray:
    """Return time/|rate|, inf where the rate is 0."""
    size = np.abs(rate)
    return np.where(size > 0, time / np.where(size > 0, size, 1.0), np.inf)
