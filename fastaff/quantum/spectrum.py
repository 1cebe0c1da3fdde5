"""The spectrum of a body, one symmetry class or many at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..analysis.tori.separation import FAMILIES, separate
from ..base.numbers import an_array, fits, positive, whole
from ..base.recipe import recorded
from ..charts import ALPHA_BETA, R_VARTHETA
from ..flows.checks import checked_model
from ..flows.interruptible import interruptible
from ..models import Body, StackelBody
from .levels import Levels, level_scale
from .nonseparable import plane_levels
from .separable import Factors, angular, radial
from .state import Product
from .symmetry import SymmetryClass, action_quantum, checked_class


@recorded
def spectrum(
    body: Any,
    *,
    m: int,
    l: int,
    levels: int,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Any = None,
    tolerance: float = 1e-10,
) -> Levels:
    """Compute the lowest energy levels of a body in one symmetry class, with error estimates and wave functions.

    Parameters: body: a Body, whose potential may separate or not; m, l: whole quantum numbers of spin and vorticity, m
    + l even for functions on GL(2,R) (single_valued=True), else any, on the double covering; levels: how many, at least
    1; hbar > 0; chart: one of ALPHA_BETA, R_VARTHETA that the body separates in (by default the first); tolerance:
    relative, of E and of the spacing of levels, for `converged`; bases grow until two agree to it or they are as large
    as they may be. Returns Levels. Raises ValueError or TypeError for wrong input, NoGroundState (a ValueError) where
    the energy is unbounded below or the body does not bind that many levels. Method: H = -(hbar^2/2 mu) Delta + V; the
    separated equations EQ4.1, EQ4.2, EQ4.6, EQ4.9 by Galerkin in Jacobi polynomials with the exponents at singular ends
    built in (oscillators in closed form); bodies that do not separate by adiabatic channels, see `plane_levels`. At a
    wall det phi = 0 where both solutions are square integrable f = 0 (Friedrichs). Milliseconds for separable bodies,
    to about 1e-13; for others see bench/test_quantum.py. Source: Martens & Slawianowski, section 4 (EQ4.1-EQ4.9,
    corrected).
    """
    chosen = checked_class(m, l, single_valued)
    levels, hbar, tolerance = _checked(body, levels, hbar, tolerance)
    if chart is None and not _families(body):
        return plane_levels(body, chosen, levels, hbar, tolerance)
    return spectrum_table(
        body,
        m=[chosen.m],
        l=[chosen.l],
        levels=levels,
        hbar=hbar,
        single_valued=single_valued,
        chart=chart,
        tolerance=tolerance,
    )[0]


def spectrum_table(
    body: Any,
    *,
    m: Sequence[int],
    l: Sequence[int],
    levels: int,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Any = None,
    tolerance: float = 1e-10,
) -> list[Levels]:
    """Compute the lowest levels of many symmetry classes of a separable body at once.

    Parameters: m, l: (classes,) each; levels of each class, hbar, single_valued, chart, tolerance: as in `spectrum`.
    Returns a list of Levels, one for each pair. Raises as `spectrum`, and ValueError for a body that does not separate.
    Classes with the same |m - l| and |m + l| have the same levels and are computed once; eigenproblems of one size are
    solved in stacks. Source: as `spectrum`.
    """
    levels, hbar, tolerance = _checked(body, levels, hbar, tolerance)
    spins, vorticities = an_array("m", m), an_array("l", l)
    if spins.ndim != 1 or spins.shape != vorticities.shape or spins.size == 0:
        raise ValueError(
            f"m and l must be sequences of the same length, got shapes {spins.shape} and {vorticities.shape}"
        )
    classes = [checked_class(one, other, single_valued) for one, other in zip(m, l, strict=True)]
    chart = _families(body)[0].chart if chart is None and _families(body) else chart
    separated = separate(body, chart)
    if separated.family.code not in _SOLVED:
        raise ValueError(f"chart must be alpha-beta or r-vartheta, got {separated.family.chart}")
    pairs = sorted({(c.a, c.b) for c in classes})
    fits("levels", len(pairs), 16 * levels)
    solved = interruptible(_SOLVED[separated.family.code], separated, np.array(pairs), levels, hbar, tolerance)
    return [_levels(c, solved[pairs.index((c.a, c.b))], separated, hbar, tolerance) for c in classes]


def _families(body: Any) -> list[Any]:
    return [family for family in FAMILIES if family.code in _SOLVED and hasattr(body.potential, family.member)]


def _checked(body: Any, levels: Any, hbar: Any, tolerance: Any) -> tuple[int, float, float]:
    checked_model(body)
    if not isinstance(body, Body):
        why = (
            "; with angular potentials spin and vorticity are no quantum numbers"
            if isinstance(body, StackelBody)
            else ""
        )
        raise TypeError(f"body must be a Body with a doubly isotropic potential, got {type(body).__name__}{why}")
    return whole("levels", levels, 1), action_quantum(hbar, body.mu), positive("tolerance", tolerance)


def _alpha_beta(separated: Any, pairs: np.ndarray, levels: int, hbar: float, tolerance: float) -> list[Any]:
    """Sums E_alpha + E_beta of every pair (a, b)."""
    V_alpha, V_beta = separated.functions
    count = min(levels, int(np.sqrt(2 * levels)) + 4)
    while True:
        sides = []
        for name, V, quanta in (("V_alpha", V_alpha, pairs[:, 0]), ("V_beta", V_beta, pairs[:, 1])):
            distinct, where = np.unique(quanta, return_inverse=True)
            sides.append((radial(name, V, 2, distinct**2, count, hbar, separated.mu, tolerance), where))
        (first, i), (second, j) = sides
        sums = first.values[i][:, :, None] + second.values[j][:, None, :]
        coarse = first.coarse[i][:, :, None] + second.coarse[j][:, None, :]
        top = np.sort(sums.reshape(len(pairs), -1), axis=1)[:, min(levels, count * count) - 1]
        if count == levels or (count * count >= levels and np.all(top < np.minimum(sums[:, -1, 0], sums[:, 0, -1]))):
            break
        count = min(levels, 2 * count)

    def factors(pair, n_alpha, n_beta):
        shapes = first.functions(i[pair], n_alpha), second.functions(j[pair], n_beta)
        return shapes, {"E_alpha": first.values[i[pair], n_alpha], "E_beta": second.values[j[pair], n_beta]}

    return [
        (*_merged(sums[p], coarse[p], levels), _states(factors, p), max(first.size, second.size))
        for p in range(len(pairs))
    ]


def _r_vartheta(separated: Any, pairs: np.ndarray, levels: int, hbar: float, tolerance: float) -> list[Any]:
    """Radial levels over each level of vartheta; e_vartheta of both bases give E of both."""
    (V_r, V_vartheta), mu = separated.functions, separated.mu
    n_r, n_v = (min(levels, int(factor * np.sqrt(levels)) + 4) for factor in (2.0, 1.0))
    while True:
        e = angular("V_vartheta", V_vartheta, pairs[:, 0], pairs[:, 1], n_v, hbar, mu, 0.1 * tolerance)
        fine, coarse = (_over(V_r, values, n_r, hbar, mu, tolerance) for values in (e.values, e.coarse))
        sums = fine.values.reshape(*e.values.shape, n_r).swapaxes(1, 2)
        other = sums + np.abs((coarse.coarse - fine.values).reshape(*e.values.shape, n_r).swapaxes(1, 2))
        top = np.sort(sums.reshape(len(pairs), -1), axis=1)[:, min(levels, n_r * n_v) - 1]
        few_r = n_r < levels and (n_r * n_v < levels or np.any(top >= sums[:, -1, 0]))
        few_v = n_v < levels and (n_r * n_v < levels or np.any(top >= sums[:, 0, -1]))
        if not (few_r or few_v):
            break
        n_r, n_v = (min(levels, int(1.5 * n) + 1) if few else n for n, few in ((n_r, few_r), (n_v, few_v)))
    count = n_v

    def factors(pair, n_r, n_vartheta):
        row = pair * count + n_vartheta
        constants = {"E": fine.values[row, n_r], "e_vartheta": e.values[pair, n_vartheta]}
        return (fine.functions(row, n_r), e.functions(pair, n_vartheta)), constants

    return [
        (*_merged(sums[p], other[p], levels), _states(factors, p), max(e.size, fine.size)) for p in range(len(pairs))
    ]


def _over(V_r: Any, e: np.ndarray, count: int, hbar: float, mu: float, tolerance: float) -> Factors:
    """Return the radial levels over every e_vartheta."""
    return radial("V_r + e_vartheta/r", V_r, 4, 2 * mu * e.ravel() / hbar**2, count, hbar, mu, tolerance)


_SOLVED = {0: _alpha_beta, 1: _r_vartheta}
_CHARTS = {0: ALPHA_BETA, 1: R_VARTHETA}


def _merged(sums: np.ndarray, coarse: np.ndarray, levels: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the lowest values of a table, ascending, their changes from the coarse table, and their indices (levels,
    2).
    """
    order = np.argsort(sums, axis=None, kind="stable")[:levels]
    labels = np.stack(np.unravel_index(order, sums.shape), axis=1)
    E = sums.ravel()[order]
    return E, np.abs(coarse.ravel()[order] - E) + 16 * np.finfo(float).eps * np.abs(E), labels


def _states(factors, pair):
    return lambda labels: factors(pair, int(labels[0]), int(labels[1]))


def _levels(chosen: SymmetryClass, solved: Any, separated: Any, hbar: float, tolerance: float) -> Levels:
    E, error, labels, factors, size = solved
    names = separated.family.coordinates
    method = (
        f"separated in {names[0]} and {names[1]}; Galerkin in Jacobi polynomials with the exponents of the ends, "
        "oscillators in closed "
        "form; f = 0 where V is infinite (Friedrichs)"
    )
    converged = error <= tolerance * level_scale(E)

    def describe(k):
        pair, constants = factors(labels[k])
        numbers = {f"n_{name}": int(n) for name, n in zip(names, labels[k], strict=True)}
        return (
            Product(_CHARTS[separated.family.code], pair),
            numbers,
            {name: float(value) for name, value in constants.items()},
        )

    return Levels(E, error, converged, labels, names, chosen.m, chosen.l, hbar, size, method, describe)
