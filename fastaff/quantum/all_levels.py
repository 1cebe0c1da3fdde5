"""The spectrum of a whole body: all symmetry classes together, with degeneracies, complete below an energy.

With a = |m - l|/2 and b = |m + l|/2 the k-th level of a class is E_k(a, b), and H of another class differs from it by
(hbar^2/2 mu) (a^2/alpha^2 + b^2/beta^2) alone. By the min-max principle E_k grows with a and with b: a class cannot
have more levels below an energy than its neighbours with smaller a or b have, and where one of them has none the search
ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.display import screen
from ..base.numbers import fits, flag, real, reporter, shown, whole
from ..base.recipe import recorded
from ..flows.flow import Interrupted
from .levels import Levels
from .spectrum import spectrum, spectrum_table
from .symmetry import SymmetryClass

Key = tuple[int, int]
"""|m - l|, |m + l| of classes with the same levels: both even, or both odd on the covering."""
FIRST = 16
"""Levels of the lowest class to begin with where only an energy is given."""
ROUNDING = 64 * np.finfo(float).eps
"""Relative difference of energies that is never told apart."""


@dataclass(frozen=True)
class LevelList:
    """Levels of many symmetry classes in ascending order, gathered to multiplets.

    E, error, converged (levels,) as in `Levels`; m, l (levels,): the class; k (levels,): its number in the class, from
    0; labels (levels, 2), names as in `Levels`, None where the body does not separate. first (multiplets + 1,): where
    each multiplet begins; its levels follow one another within their errors. complete_below: no level of the body below
    this energy is missing (-inf: not known).
    """

    E: np.ndarray
    error: np.ndarray
    converged: np.ndarray
    m: np.ndarray
    l: np.ndarray
    k: np.ndarray
    labels: np.ndarray | None
    names: tuple[str, str] | None
    first: np.ndarray
    hbar: float
    complete_below: float
    method: str

    def __repr__(self) -> str:
        return screen(self)

    @property
    def degeneracy(self) -> np.ndarray:
        """How many levels each multiplet has (multiplets,)."""
        return np.diff(self.first)

    @property
    def energies(self) -> np.ndarray:
        """The lowest E of each multiplet (multiplets,)."""
        return self.E[self.first[:-1]]

    def members(self, multiplet: int) -> slice:
        """Return which levels make up a multiplet, as a slice of the arrays."""
        multiplet = whole("multiplet", multiplet, 0, self.first.size - 2)
        return slice(*self.first[[multiplet, multiplet + 1]])

    def upto(self, levels: int) -> LevelList:
        """Return the list of the lowest levels only, all where there are no more; complete below the first one left
        out.
        """
        size = min(whole("levels", levels, 0), self.E.size)
        cut: dict[str, Any] = {name: getattr(self, name)[:size] for name in ("E", "error", "converged", "m", "l", "k")}
        labels = None if self.labels is None else self.labels[:size]
        top = min(self.complete_below, float(self.E[size])) if size < self.E.size else self.complete_below
        return replace(
            self, **cut, labels=labels, first=np.append(self.first[self.first < size], size), complete_below=top
        )


def level_list(classes: Sequence[Levels], *, complete_below: float = -math.inf) -> LevelList:
    """Merge the levels of symmetry classes into one list with degeneracies.

    classes: Levels of one body, one or more, such as `spectrum_table` gives; complete_below: kept in the result.
    Returns LevelList. Raises TypeError for what are no Levels, ValueError for none of them, or of different hbar or
    quantum numbers. Formula: neighbours are one multiplet where E differs by no more than the sum of their errors (and
    64 roundings). Source: none; the errors are those of `Levels`.
    """
    if not isinstance(classes, (list, tuple)) or not all(isinstance(found, Levels) for found in classes):
        raise TypeError(f"classes must be a list of Levels, got {shown(classes)}")
    if not (isinstance(complete_below, float) and complete_below == -math.inf):
        complete_below = real("complete_below", complete_below)
    if not classes or len({(found.hbar, found.names) for found in classes}) > 1:
        got = sorted({f"hbar = {found.hbar:g}, {found.names}" for found in classes})
        raise ValueError(f"classes must be one or more Levels of the same hbar and quantum numbers, got {got}")
    sizes = [found.E.size for found in classes]
    E = np.concatenate([found.E for found in classes])
    order = np.argsort(E, kind="stable")
    m, l = (np.repeat([getattr(found, name) for found in classes], sizes)[order] for name in ("m", "l"))
    error = np.concatenate([found.error for found in classes])[order]
    labels = None if classes[0].labels is None else np.concatenate([found.labels for found in classes])[order]
    return LevelList(
        E[order],
        error,
        np.concatenate([found.converged for found in classes])[order],
        m,
        l,
        np.concatenate([np.arange(size) for size in sizes])[order],
        labels,
        classes[0].names,
        _first(E[order], error),
        classes[0].hbar,
        float(complete_below),
        classes[0].method,
    )


def _first(E: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return where multiplets begin, and the number of levels."""
    apart = np.diff(E) > error[1:] + error[:-1] + ROUNDING * np.abs(E[1:])
    return np.concatenate([[0], np.flatnonzero(apart) + 1, [E.size]]) if E.size else np.zeros(1, np.int64)


@recorded
def all_levels(
    body: Any,
    *,
    below: float | None = None,
    count: int | None = None,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Any = None,
    tolerance: float = 1e-10,
    report: Callable[[float], None] | None = None,
) -> LevelList:
    """Compute all levels of a body below an energy, or its lowest multiplets, of all symmetry classes together.

    Parameters: body: a Body; below: finite, or count >= 1: how many different energies, one of them; hbar, chart,
    tolerance as in `spectrum`; single_valued: functions on GL(2,R), m + l even; False: on its double covering, all m
    and l; report: called with the fraction that is done. Returns LevelList, perhaps of no level. Raises as `spectrum`;
    Interrupted on Ctrl-C, with a complete list up to a lower energy in `.partial`. Completeness: E_k of a class grows
    with |m - l| and |m + l| (min-max), which ends the search and bounds the number of levels to compute. Classes with
    the same |m - l| and |m + l| have the same levels and are computed once: up to four (m, l). Cost: that of the
    classes; many at once where the body separates, one after another else (there a tolerance of 1e-6 is much cheaper).
    Source: Courant & Hilbert 1924, Methoden der mathematischen Physik I, ch. VI (min-max); Martens & Slawianowski,
    EQ4.1, EQ4.2 (a, b).
    """
    if (below is None) == (count is None):
        raise ValueError(f"give either below or count, got below = {below!r}, count = {count!r}")
    reporter(report)
    limit = math.inf if below is None else real("below", below)
    wanted = None if count is None else whole("count", count, 1)
    if wanted is not None:
        fits("count", 16, wanted)
    options = {"hbar": hbar, "single_valued": single_valued, "chart": chart, "tolerance": tolerance}
    solved: dict[Key, Levels] = {}
    seeds = ((0, 0),) if flag("single_valued", single_valued) else ((0, 0), (1, 1))
    todo = {(0, 0): FIRST if wanted is None else wanted + 1}
    top, share = limit, 0.0
    try:
        while todo:
            solved |= _solved(body, todo, solved, options)
            top = limit if wanted is None else _end(solved, wanted)
            todo = _todo(solved, top, seeds)
            if report is not None:
                share = max(share, _share(solved, top, seeds))  # the end comes closer only as levels are found
                report(share)
    except KeyboardInterrupt:
        stopped = Interrupted("all_levels")
        stopped.partial = _listed(solved, min(_complete(solved, seeds), limit), None) if solved else None
        raise stopped from None
    return _listed(solved, top, wanted)


def _solved(body: Any, todo: dict[Key, int], solved: dict[Key, Levels], options: dict[str, Any]) -> dict[Key, Levels]:
    """Return the levels of all classes to do where the body separates, else of that which may have the lowest ones."""
    if solved and next(iter(solved.values())).labels is not None:
        spins, vorticities = zip(*(_class(key) for key in todo), strict=True)
        return dict(
            zip(todo, spectrum_table(body, m=spins, l=vorticities, levels=max(todo.values()), **options), strict=True)
        )
    key = min(todo, key=lambda key: _bound(solved, key))
    m, l = _class(key)
    return {key: spectrum(body, m=m, l=l, levels=todo[key], **options)}


def _class(key: Key) -> SymmetryClass:
    """Return one of the classes."""
    return SymmetryClass((key[1] + key[0]) // 2, (key[1] - key[0]) // 2)


def _smaller(key: Key) -> list[Key]:
    """Return the neighbours with smaller |m - l| or |m + l|."""
    if key == (1, 1):
        return [(0, 0)]
    return [(eta, gamma) for eta, gamma in ((key[0] - 2, key[1]), (key[0], key[1] - 2)) if min(eta, gamma) >= 0]


def _bound(solved: dict[Key, Levels], key: Key) -> float:
    """Return an energy that the levels of a class still to be found are not below."""
    if key in solved:
        return float(solved[key].E[-1])
    return max((float(solved[other].E[0]) for other in _smaller(key)), default=-math.inf)


def _next(solved: dict[Key, Levels], seeds: tuple[Key, ...]) -> list[Key]:
    """Return the classes not solved whose smaller neighbours all are."""
    candidates = dict.fromkeys(seeds) | dict.fromkeys(
        new for eta, gamma in solved for new in ((eta + 2, gamma), (eta, gamma + 2))
    )
    return [new for new in candidates if new not in solved and all(other in solved for other in _smaller(new))]


def _todo(solved: dict[Key, Levels], top: float, seeds: tuple[Key, ...]) -> dict[Key, int]:
    """Return the classes that may have more levels up to `top`, and how many to compute: none more than their
    neighbours, and one.
    """
    longer = {key: 2 * found.E.size for key, found in solved.items() if found.E[-1] - found.error[-1] <= top}
    if math.isinf(top):
        return longer
    inside = {key: int(np.count_nonzero(found.E - found.error <= top)) for key, found in solved.items()}
    new = {key: min(inside[other] for other in _smaller(key)) for key in _next(solved, seeds)}
    return longer | {key: levels + 1 for key, levels in new.items() if levels}


def _end(solved: dict[Key, Levels], count: int) -> float:
    """Return where the multiplet of this number ends, infinity where there are not so many yet."""
    merged = level_list(list(solved.values()))
    if merged.first.size <= count:
        return math.inf
    last = merged.members(count - 1)
    return float((merged.E + merged.error)[last].max())


def _complete(solved: dict[Key, Levels], seeds: tuple[Key, ...]) -> float:
    """Return the energy below which no level is missing."""
    return min(_bound(solved, key) for key in [*solved, *_next(solved, seeds)])


def _share(solved: dict[Key, Levels], top: float, seeds: tuple[Key, ...]) -> float:
    ground = min(float(found.E[0]) for found in solved.values())
    if not ground < top < math.inf:
        return 0.0
    return min(max((_complete(solved, seeds) - ground) / (top - ground), 0.0), 1.0)


def _listed(solved: dict[Key, Levels], top: float, count: int | None) -> LevelList:
    """Return the levels below `top`, or the first `count` multiplets, each class with all its signs."""
    signed = [replace(found, m=m, l=l) for key, found in solved.items() for m, l in _class(key).alike()]
    merged = level_list(signed, complete_below=top)
    return merged.upto(int(np.searchsorted(merged.E, top)) if count is None else int(merged.first[count]))
