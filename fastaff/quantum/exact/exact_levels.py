"""Energy levels of exactly solvable bodies, with their separation constants."""

from __future__ import annotations

from dataclasses import replace
from itertools import count

import numpy as np
from numpy.typing import ArrayLike

from ...core.docstrings import inserts_parameters
from ...core.numbers import fits, flag, real, shown, whole
from ...core.status import Status
from ...results.calls import records_call
from ...systems.charts import Chart
from ...systems.models import Body
from ..states.level_table import LevelTable
from ..states.symmetry import checked_numbers
from .numbers_below import numbers_below
from .solvable_body import SolvableBody, solvable

ROUNDING = 16 * np.finfo(float).eps
"""Relative error of closed forms."""


@records_call
@inserts_parameters
def exact_levels(
    model: Body,
    *,
    n: ArrayLike | None = None,
    m: ArrayLike | None = None,
    l: ArrayLike | None = None,
    max_energy: float | None = None,
    multiplets: int | None = None,
    hbar: float = 1.0,
    chart: Chart | None = None,
    single_valued: bool = True,
) -> LevelTable:
    """Compute exact energy levels of a solvable body from quantum numbers, or all of the lowest.

    Parameters
    ----------
    {solvable_body}
    n : array_like of int, shape (2,) or (2, levels), optional
        Quantum numbers of the two coordinates in the order of the chart, at least 0. Give `n`, `m` and `l`, or
        `max_energy`, or `multiplets`.
    m, l : int or array_like of int, shape (levels,), optional
        Quantum numbers of spin and vorticity.
    max_energy : float, optional
        Energy below which all levels are returned, ascending.
    multiplets : int, optional
        Number of different energies. All their levels are returned, ascending.
    {hbar}
    {quantum_chart}
    {single_valued}

    Returns
    -------
    LevelTable
        Levels, possibly none.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the body has no closed-form states, m + l is odd for a single-valued function, or an argument has a wrong
        value.

    Notes
    -----
    - E_alpha = hbar omega (2 n_alpha + 1 + s_alpha), the same for beta, with s_beta = ``|m + l|``/2.
    - s_alpha = ``|m - l|``/2 for `Harmonic`, sqrt((m - l)^2 + 16 C mu/hbar^2)/2 for `Anharmonic`.
    - E = hbar omega (2 n_r + 1 + 2 epsilon); e_vartheta = (hbar^2/2 mu) ((2 n_vartheta + 1 + s_alpha + s_beta)^2 - 1).
    - Degeneracy: C(N + 3, 3) for E = hbar omega (N + 2) of `Harmonic`; n1 + n2 + 1 for each (n1 + n2, m, l) of
      `Anharmonic`.
    - Lists are complete because E grows with n, ``|m - l|`` and ``|m + l|``.
    - Exact to round-off; nanoseconds per level.

    References
    ----------
    Martens & Slawianowski, EQ5.1, EQ5.2, EQ3.2.2 (with m + l even; e_vartheta corrected).

    Examples
    --------
    >>> fa.quantum.exact_levels(fa.Body(fa.Harmonic()), n=(1, 0), m=1, l=1).E
    array([5.])
    """
    solved = solvable(model, chart, hbar)
    flagged = flag("single_valued", single_valued)
    given = [name for name, value in (("max_energy", max_energy), ("multiplets", multiplets)) if value is not None]
    numbers = n is not None or m is not None or l is not None
    if numbers + len(given) != 1:
        raise ValueError(
            f"give n, m and l, or max_energy, or multiplets, got n = {shown(n, 12)}, m = {shown(m, 12)}, l = "
            f"{shown(l, 12)}, max_energy = {shown(max_energy, 12)}, multiplets = {shown(multiplets, 12)}"
        )
    if max_energy is not None:
        return _below(solved, real("max_energy", max_energy), flagged)
    if multiplets is not None:
        return _lowest(solved, whole("multiplets", multiplets, 1), flagged)
    return _levels(solved, *checked_numbers(n, m, l, flagged))


def _levels(model: SolvableBody, n: np.ndarray, m: np.ndarray, l: np.ndarray) -> LevelTable:
    E = model.energy(n, m, l)
    return LevelTable(
        E=E,
        error=ROUNDING * np.abs(E),
        status=np.full(E.shape, Status.OK),
        n=n,
        names=model.family.coordinates,
        m=m,
        l=l,
        constants=model.constants(n, m, l),
        constant_names=model.family.eigenvalues,
        hbar=model.hbar,
        method=f"closed form in {' and '.join(model.family.coordinates)}",
    )


def _below(model: SolvableBody, top: float, single_valued: bool) -> LevelTable:
    """Return all levels below an energy, ascending."""
    fits("max_energy", 10, _many(model, top, single_valued))
    found = _levels(model, *numbers_below(model.energy, top, single_valued)).ascending()
    return replace(found, complete_below=top)


def _lowest(model: SolvableBody, multiplets: int, single_valued: bool) -> LevelTable:
    """Return the levels of the lowest multiplets."""
    fits("multiplets", 10, multiplets)
    ground = float(model.energy(np.zeros((2, 1), np.int64), 0, 0)[0])
    rise = float(model.quanta.min())
    tables = (_below(model, ground + k * rise, single_valued) for k in count(1))
    gathered = (found.multiplets() for found in tables)
    enough = next(found for found in gathered if len(found) > multiplets)  # one more: nothing next to it is missing
    return enough.levels.upto(int(enough.first[multiplets]))


def _many(model: SolvableBody, top: float, single_valued: bool) -> int:
    """Return an upper estimate of the number of levels below `top`."""
    rise = top - float(model.energy(np.zeros((2, 1), np.int64), 0, 0)[0])
    if rise <= 0:
        return 0
    many = 1.0
    for quantum, s in zip(model.quanta, model.indices(0, 0), strict=True):
        x = min(rise / float(quantum), 1e70)
        many *= (x / 2 + 1) * (2 * np.sqrt(x * (x + 2 * float(s))) + 1)
    return int(many / (12 if single_valued else 6))
