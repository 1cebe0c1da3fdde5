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
from ...systems.models import Body, StackelBody
from ..states.level_table import LevelTable, level_list
from ..states.symmetry import SymmetryClass
from .angular_bodies import LADDER, AngularClasses, angular_classes, has_angular_potentials, search
from .class_search import FIRST, Key, Ladder
from .spectrum import tables_below

EVEN = Ladder(2, ((0, 0),))
"""Classes by |m - l|, |m + l|, both even."""
BOTH = Ladder(2, ((0, 0), (1, 1)))
"""The same on the double cover: both even, or both odd."""


@records_call
@inserts_parameters
def all_levels(
    model: Body | StackelBody,
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
    model : Body or StackelBody
        Affinely-rigid body. With angular potentials it must separate.
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
    - Completeness: E_k of a class grows with ``|m - l|`` and ``|m + l|``, or with the levels of eta and gamma
      (min-max), which ends the search.
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
    if has_angular_potentials(model):
        classes = angular_classes(model, hbar, single_valued, chart, tolerance, limit)
        with partial_result_on_interrupt("all_levels", lambda: _known(classes, limit) if classes.solved else None):
            top = search(classes, FIRST, lambda: limit if wanted is None else _end(classes.allowed(), wanted), callback)
            return _upto(classes.listed(top), top, wanted)
    options = {"hbar": hbar, "single_valued": single_valued, "chart": chart, "tolerance": tolerance}
    solved: dict[Key, LevelTable] = {}
    ladder = EVEN if flag("single_valued", single_valued) else BOTH
    todo = {(0, 0): FIRST if wanted is None else wanted + 1}
    top = limit
    share = 0.0
    with partial_result_on_interrupt(
        "all_levels", lambda: _listed(solved, min(ladder.complete(solved), limit), None) if solved else None
    ):
        while todo:
            solved |= _solved(model, todo, solved, ladder, limit, options)
            top = limit if wanted is None else _end(list(solved.values()), wanted)
            todo = ladder.todo(solved, top)
            if callback is not None:
                share = max(share, ladder.share(solved, top))  # the end comes closer only as levels are found
                callback(share)
    return _listed(solved, top, wanted)


def _solved(
    model: Any,
    todo: dict[Key, int],
    solved: dict[Key, LevelTable],
    ladder: Ladder,
    limit: float,
    options: dict[str, Any],
) -> dict[Key, LevelTable]:
    """Return the levels of all waiting classes if the body separates, else of the one that may have the lowest."""
    together = solved and next(iter(solved.values())).separated
    keys = list(todo) if together else [min(todo, key=lambda key: ladder.bound(solved, key))]
    spins, vorticities = zip(*(_class(key) for key in keys), strict=True)
    count = max(todo[key] for key in keys)
    return dict(zip(keys, tables_below(model, limit, spins, vorticities, count, **options), strict=True))


def _class(key: Key) -> SymmetryClass:
    """Return one of the classes."""
    return SymmetryClass((key[1] + key[0]) // 2, (key[1] - key[0]) // 2)


def _end(solved: list[LevelTable], multiplets: int) -> float:
    """Return the upper end of the multiplet of this number, infinity if there are not so many yet."""
    gathered = level_list(solved).multiplets()
    if len(gathered) < multiplets:
        return math.inf
    last = gathered.members(multiplets - 1)
    return float((last.E + last.error).max())


def _listed(solved: dict[Key, LevelTable], top: float, multiplets: int | None) -> LevelTable:
    """Return the levels below `top`, or the first multiplets, each class with all its signs."""
    signed = [
        replace(found, m=np.full_like(found.m, m), l=np.full_like(found.l, l))
        for key, found in solved.items()
        for m, l in _class(key).alike()
    ]
    return _upto(level_list(signed, complete_below=top), top, multiplets)


def _known(classes: AngularClasses, limit: float) -> LevelTable:
    """Return the levels of a body with angular potentials as far as none is missing."""
    top = min(LADDER.complete(classes.solved), limit)
    return _upto(classes.listed(top), top, None)


def _upto(merged: LevelTable, top: float, multiplets: int | None) -> LevelTable:
    """Return the levels below `top`, or the first multiplets."""
    size = np.searchsorted(merged.E, top) if multiplets is None else merged.multiplets().first[multiplets]
    return merged.upto(int(size))
