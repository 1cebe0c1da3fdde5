"""The spectrum of a whole body: all symmetry classes together, with degeneracies, complete below an energy.

With a = |m - l|/2 and b = |m + l|/2 the k-th level of a class is E_k(a, b), and H of another class differs from it by
(hbar^2/2 mu) (a^2/alpha^2 + b^2/beta^2) alone. By the min-max principle E_k grows with a and with b: a class cannot
have more levels below an energy than its neighbours with smaller a or b have, and where one of them has none the search
ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.interruption import partial_result_on_interrupt
from ...core.numbers import checked_callback, fits, flag, real, shown, whole
from ...results.calls import records_call
from ...systems.charts import Chart
from ...systems.models import Body
from ..states.level_table import LevelTable, level_list
from ..states.symmetry import SymmetryClass
from .spectrum import tables_below

Key = tuple[int, int]
"""|m - l|, |m + l| of classes with the same levels: both even, or both odd on the covering."""
FIRST = 16
"""Levels of the lowest class to begin with where only an energy is given."""


@records_call
@inserts_parameters
def all_levels(
    model: Body,
    *,
    max_energy: float | None = None,
    multiplets: int | None = None,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Chart | None = None,
    tolerance: float = 1e-10,
    callback: Callable[[float], None] | None = None,
) -> LevelTable:
    """Compute all levels of a body below an energy, or its lowest multiplets, of all symmetry classes.

    Parameters
    ----------
    {body}
    max_energy : float, optional
        Energy below which all levels are computed. Give `max_energy` or `multiplets`.
    multiplets : int, optional
        Number of different energies, at least 1. All their levels are computed.
    {hbar}
    {single_valued}
    {quantum_chart}
    {levels_tolerance}
    {callback}

    Returns
    -------
    LevelTable
        Levels in ascending order, possibly none.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If an argument has a wrong value.
    NoGroundState
        If the energy is unbounded below or the body does not bind the levels.
    Interrupted
        On Ctrl-C. Its attribute ``partial`` has a complete list up to a lower energy.

    Notes
    -----
    - Completeness: E_k of a class grows with ``|m - l|`` and ``|m + l|`` (min-max), which ends the search.
    - Classes with the same ``|m - l|`` and ``|m + l|``, up to four, have the same levels and are computed once.
    - Cost: the sum over the classes. Classes of a separable body are computed together. For other bodies, a tolerance
      of 1e-6 is much cheaper.

    References
    ----------
    Courant & Hilbert 1924, Methoden der mathematischen Physik I, ch. VI (min-max); Martens & Slawianowski, EQ4.1, EQ4.2
    (a, b).

    Examples
    --------
    >>> levels = fa.quantum.all_levels(fa.Body(fa.Harmonic()), multiplets=3)
    >>> np.unique(levels.E.round(9), return_counts=True)
    (array([2., 3., 4.]), array([ 1,  4, 10]))
    """
    if (max_energy is None) == (multiplets is None):
        raise ValueError(
            f"give either max_energy or multiplets, got max_energy = {shown(max_energy, 30)}, multiplets = "
            f"{shown(multiplets, 30)}"
        )
    checked_callback(callback)
    limit = math.inf if max_energy is None else real("max_energy", max_energy)
    wanted = None if multiplets is None else whole("multiplets", multiplets, 1)
    if wanted is not None:
        fits("multiplets", 16, wanted)
    options = {"hbar": hbar, "single_valued": single_valued, "chart": chart, "tolerance": tolerance}
    solved: dict[Key, LevelTable] = {}
    seeds = ((0, 0),) if flag("single_valued", single_valued) else ((0, 0), (1, 1))
    todo = {(0, 0): FIRST if wanted is None else wanted + 1}
    top = limit
    share = 0.0
    with partial_result_on_interrupt(
        "all_levels", lambda: _listed(solved, min(_complete(solved, seeds), limit), None) if solved else None
    ):
        while todo:
            solved |= _solved(model, todo, solved, limit, options)
            top = limit if wanted is None else _end(solved, wanted)
            todo = _todo(solved, top, seeds)
            if callback is not None:
                share = max(share, _share(solved, top, seeds))  # the end comes closer only as levels are found
                callback(share)
    return _listed(solved, top, wanted)


def _solved(
    model: Any, todo: dict[Key, int], solved: dict[Key, LevelTable], limit: float, options: dict[str, Any]
) -> dict[Key, LevelTable]:
    """Return the levels of all waiting classes if the body separates, else of the one that may have the lowest."""
    together = solved and next(iter(solved.values())).separated
    keys = list(todo) if together else [min(todo, key=lambda key: _bound(solved, key))]
    spins, vorticities = zip(*(_class(key) for key in keys), strict=True)
    count = max(todo[key] for key in keys)
    return dict(zip(keys, tables_below(model, limit, spins, vorticities, count, **options), strict=True))


def _class(key: Key) -> SymmetryClass:
    """Return one of the classes."""
    return SymmetryClass((key[1] + key[0]) // 2, (key[1] - key[0]) // 2)


def _smaller(key: Key) -> list[Key]:
    """Return the neighbours with smaller |m - l| or |m + l|."""
    if key == (1, 1):
        return [(0, 0)]
    return [(eta, gamma) for eta, gamma in ((key[0] - 2, key[1]), (key[0], key[1] - 2)) if min(eta, gamma) >= 0]


def _bound(solved: dict[Key, LevelTable], key: Key) -> float:
    """Return a lower bound of the levels of a class that are still to be found."""
    if key in solved:
        return float(solved[key].E[-1])
    return max((float(solved[other].E[0]) for other in _smaller(key)), default=-math.inf)


def _next(solved: dict[Key, LevelTable], seeds: tuple[Key, ...]) -> list[Key]:
    """Return the unsolved classes whose smaller neighbours are all solved."""
    candidates = dict.fromkeys(seeds) | dict.fromkeys(
        new for eta, gamma in solved for new in ((eta + 2, gamma), (eta, gamma + 2))
    )
    return [new for new in candidates if new not in solved and all(other in solved for other in _smaller(new))]


def _todo(solved: dict[Key, LevelTable], top: float, seeds: tuple[Key, ...]) -> dict[Key, int]:
    """Return the classes that may have more levels up to `top`, and the numbers to compute: twice as many as before, or
    in a new class one more than its smaller neighbours have.
    """
    longer = {key: 2 * found.E.size for key, found in solved.items() if found.E[-1] - found.error[-1] <= top}
    if math.isinf(top):
        return longer
    inside = {key: int(np.count_nonzero(found.E - found.error <= top)) for key, found in solved.items()}
    new = {key: min(inside[other] for other in _smaller(key)) for key in _next(solved, seeds)}
    return longer | {key: levels + 1 for key, levels in new.items() if levels}


def _end(solved: dict[Key, LevelTable], multiplets: int) -> float:
    """Return the upper end of the multiplet of this number, infinity if there are not so many yet."""
    gathered = level_list(list(solved.values())).multiplets()
    if len(gathered) < multiplets:
        return math.inf
    last = gathered.members(multiplets - 1)
    return float((last.E + last.error).max())


def _complete(solved: dict[Key, LevelTable], seeds: tuple[Key, ...]) -> float:
    """Return the energy below which no level is missing."""
    return min(_bound(solved, key) for key in [*solved, *_next(solved, seeds)])


def _share(solved: dict[Key, LevelTable], top: float, seeds: tuple[Key, ...]) -> float:
    ground = min(float(found.E[0]) for found in solved.values())
    if not ground < top < math.inf:
        return 0.0
    return min(max((_complete(solved, seeds) - ground) / (top - ground), 0.0), 1.0)


def _listed(solved: dict[Key, LevelTable], top: float, multiplets: int | None) -> LevelTable:
    """Return the levels below `top`, or the first multiplets, each class with all its signs."""
    signed = [
        replace(found, m=np.full_like(found.m, m), l=np.full_like(found.l, l))
        for key, found in solved.items()
        for m, l in _class(key).alike()
    ]
    merged = level_list(signed, complete_below=top)
    size = np.searchsorted(merged.E, top) if multiplets is None else merged.multiplets().first[multiplets]
    return merged.upto(int(size))
