"""The spectrum of a body, one symmetry class or many at a time."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, ParamSpec, cast

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.interruption import partial_result_on_interrupt
from ...core.numbers import an_array, checked_callback, fits, kind_of, positive, whole
from ...results.calls import records_call
from ...runs.interruptible import interruptible
from ...runs.requirements import checked_system
from ...systems.charts import ALPHA_BETA, R_VARTHETA, Chart
from ...systems.models import Body
from ...systems.models.contracts import Dynamics
from ...tori.families import ALPHA_BETA_FAMILY, ELLIPTIC_FAMILY, R_VARTHETA_FAMILY, Family
from ...tori.separation import separate
from ..solvers.elliptic import Unresolved, elliptic_levels
from ..solvers.factor_tables import Factors, FactorTable
from ..solvers.nonseparable import plane_levels
from ..solvers.separable import angular, radial
from ..solvers.singular_ends import radii, sampled
from ..solvers.vibrations import COORDINATES
from ..states.level_table import LevelTable, Waves, class_levels
from ..states.state import Product
from ..states.symmetry import SymmetryClass, action_quantum, checked_class
from .vibration import vibrates, vibration

SIDES = ("V_alpha", "V_beta")
NEAR = (1e-2, 1e-4, 1e-6)
"""Distances below the limit of a potential up to which its ground state is searched, in units of its depth."""

P = ParamSpec("P")


def _checked_body(model: Any) -> None:
    system = checked_system(model, needs="H = T(p) + V(q)")
    if not system.isotropic:
        why = f". Use spectrum(model, count=..., hbar=...) for one to {COORDINATES} coordinates."
        why = ". With angular potentials m and l are not quantum numbers." if system.planar else why
        got = f"{kind_of(model)} of {system.n} coordinates"
        raise TypeError(f"model must be a Body with a doubly isotropic potential, got {got}{why}")


def _of_bodies(function: Callable[P, LevelTable]) -> Callable[P, LevelTable]:
    """Make a function refuse systems without levels before it asks for m and l, which only bodies have."""

    @functools.wraps(function)
    def wrapped(*given: P.args, **named: P.kwargs) -> LevelTable:
        if given or "model" in named:
            body = given[0] if given else named["model"]
            if not vibrates(body):
                _checked_body(body)
                missing = [name for name in ("m", "l") if named.get(name) is None]
                if missing:
                    raise TypeError(f"spectrum() of a Body needs m and l, spin and vorticity: got no {missing[0]}")
        return function(*given, **named)

    return wrapped


@_of_bodies
@records_call
@inserts_parameters
def spectrum(
    model: Dynamics,
    *,
    m: int | None = None,
    l: int | None = None,
    count: int,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Chart | None = None,
    tolerance: float = 1e-10,
    callback: Callable[[float], None] | None = None,
) -> LevelTable:
    """Compute the lowest energy levels of one symmetry class of a body, or of a vibration.

    Parameters
    ----------
    model : Body or model
        A body, separable or not, or a system H = T(p) + V(q) of one to three coordinates with T quadratic in the
        momenta.
    m, l : int, optional
        Quantum numbers of spin and vorticity. Required for a body and not supported for other systems.
    count : int
        Number of levels, at least 1.
    {hbar}
    {single_valued}
    {quantum_chart}
    tolerance : float, default 1e-10
        Largest error of a converged level, relative to E and to the spacing of the levels. Bases grow until two agree
        to it or the largest size is reached.
    callback : callable, optional
        Function that is called after each basis with the largest fraction that may be completed.

    Returns
    -------
    LevelTable
        Levels in ascending order, with errors and wave functions.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If an argument has a wrong value.
    NoGroundState
        If the energy is unbounded below, the body does not bind that many levels, or no grid holds them. It is a
        `ValueError`.
    Interrupted
        On Ctrl-C. Its attribute ``partial`` has the levels of the last basis, None before the first.

    Notes
    -----
    - Separable bodies: Galerkin's method in Jacobi polynomials with the exponents of the singular ends; closed forms
      for oscillators. Milliseconds, errors of about 1e-13. In the elliptic chart, two equations have the common
      eigenvalues E and L = E - K; ten levels take half a second.
    - Nonseparable bodies: adiabatic channels. A tolerance of 1e-6 is much cheaper.
    - Vibrations: a uniform grid. Some 100 levels of two coordinates to 1e-12 in seconds if V is smooth and grows.
    - At a potential barrier det phi = 0 with two square-integrable solutions, f = 0 (Friedrichs).
    - A well behind a saddle is closed by a barrier. Tunnelling changes the levels by about their error.
    - Interval bounds find all wells. If V does not support them, ``method`` states it.

    References
    ----------
    Martens & Slawianowski, section 4 (EQ4.1-EQ4.9, corrected); Colbert & Miller 1992, J. Chem. Phys. 96, 1982.

    Examples
    --------
    >>> fa.quantum.spectrum(fa.Body(fa.Harmonic()), m=0, l=0, count=3).E.round(9)
    array([2., 4., 4.])
    >>> fa.quantum.spectrum(fa.HenonHeiles(), count=3, hbar=0.0125).E.round(7)
    array([0.0124824, 0.024876 , 0.024876 ])
    """
    if vibrates(model):
        return vibration(model, m, l, count, hbar, tolerance, single_valued, chart, checked_callback(callback))
    chosen = checked_class(m, l, single_valued)
    callback = checked_callback(callback)
    count, hbar, tolerance = _checked(model, count, hbar, tolerance)
    known: list[LevelTable] = []
    with partial_result_on_interrupt("spectrum", lambda: known[-1] if known else None):
        if chart is None and not solved_families(model):
            plane_levels(model, chosen, count, hbar, tolerance, known, callback)
        else:
            options: Any = {"hbar": hbar, "single_valued": single_valued, "chart": chart, "tolerance": tolerance}
            known += spectrum_table(cast(Any, model), m=[chosen.m], l=[chosen.l], count=count, **options)
        if callback is not None:
            callback(1.0)
    return known[-1]


@inserts_parameters
def spectrum_table(
    model: Body,
    *,
    m: Sequence[int],
    l: Sequence[int],
    count: int,
    hbar: float = 1.0,
    single_valued: bool = True,
    chart: Chart | None = None,
    tolerance: float = 1e-10,
) -> list[LevelTable]:
    """Compute the lowest levels of many symmetry classes of a separable body at once.

    Parameters
    ----------
    {body}
    m, l : sequence of int
        Quantum numbers of spin and vorticity of each class.
    {class_count}
    {hbar}
    {single_valued}
    {quantum_chart}
    {levels_tolerance}

    Returns
    -------
    list of LevelTable
        Levels of each class.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the body does not separate or an argument has a wrong value.
    NoGroundState
        If the energy is unbounded below or the body does not bind that many levels.

    Notes
    -----
    - Classes with the same ``|m - l|`` and ``|m + l|`` have the same levels and are computed once.
    - Eigenproblems of one size are solved together.

    References
    ----------
    Martens & Slawianowski, section 4 (EQ4.1-EQ4.9, corrected).

    Examples
    --------
    >>> classes = fa.quantum.spectrum_table(fa.Body(fa.Harmonic()), m=[0, 1], l=[0, 1], count=2)
    >>> [table.E.round(9) for table in classes]
    [array([2., 4.]), array([3., 5.])]
    """
    return separated_tables(model, m, l, count, hbar, single_valued, chart, tolerance)


def tables_below(
    model: Any,
    limit: float,
    m: Sequence[int],
    l: Sequence[int],
    count: int,
    hbar: float,
    single_valued: bool,
    chart: Any,
    tolerance: float,
) -> list[LevelTable]:
    """Return the lowest levels of classes of any body. Those below `limit` are true; the others belong to the body with
    a wall where waves up to `limit` have decayed. Raises NoGroundState where V does not grow to it.
    """
    if chart is not None or solved_families(model):
        return separated_tables(model, m, l, count, hbar, single_valued, chart, tolerance, limit)
    count, hbar, tolerance = _checked(model, count, hbar, tolerance)
    classes = [checked_class(*one, single_valued) for one in zip(m, l, strict=True)]
    return [plane_levels(model, one, count, hbar, tolerance, limit=limit) for one in classes]


def separated_tables(
    model: Any,
    m: Sequence[int],
    l: Sequence[int],
    count: int,
    hbar: float,
    single_valued: bool,
    chart: Any,
    tolerance: float,
    limit: float = np.inf,
) -> list[LevelTable]:
    """Return as `spectrum_table`; limit: as in `tables_below`."""
    count, hbar, tolerance = _checked(model, count, hbar, tolerance)
    spins = an_array("m", m)
    vorticities = an_array("l", l)
    if spins.ndim != 1 or spins.shape != vorticities.shape or spins.size == 0:
        raise ValueError(
            f"m and l must be sequences of the same length, got shapes {spins.shape} and {vorticities.shape}"
        )
    classes = [checked_class(one, other, single_valued) for one, other in zip(m, l, strict=True)]
    chart = solved_families(model)[0].chart if chart is None and solved_families(model) else chart
    separated = separate(model, chart)
    pairs = sorted({(c.a, c.b) for c in classes})
    fits("count", len(pairs), 16 * count)
    try:
        solved = interruptible(_SOLVED[separated.family], separated, np.array(pairs), count, hbar, tolerance, limit)
    except Unresolved:
        return [plane_levels(model, one, count, hbar, tolerance, limit=limit) for one in classes]
    return [_levels(c, solved[pairs.index((c.a, c.b))], separated, hbar, tolerance) for c in classes]


def solved_families(model: Any) -> list[Family]:
    """Return the families in which the body separates and its levels are computed coordinate by coordinate."""
    potential = getattr(model, "potential", None)
    return [family for family in _SOLVED if hasattr(potential, family.member)]


def _checked(model: Any, count: Any, hbar: Any, tolerance: Any) -> tuple[int, float, float]:
    _checked_body(model)
    return whole("count", count, 1), action_quantum(hbar, model.mu), positive("tolerance", tolerance)


@dataclass(frozen=True, repr=False)
class ProductWaves:
    """Products of factors: those of the second coordinate are solutions of one problem, rows[1] of `second`; those of
    the first of problem rows[0] + step*n of `first`, n the quantum number of the second.
    """

    chart: Chart
    first: FactorTable
    second: FactorTable
    rows: tuple[int, int]
    step: int

    def __repr__(self) -> str:
        return f"products of factors in {self.chart.name}"

    def shape(self, n: Sequence[int]) -> Product:
        """Return the shape of the state with quantum numbers n (2,)."""
        first = self.first(self.rows[0] + self.step * n[1], n[0])
        return Product(self.chart, (first, self.second(self.rows[1], n[1])))


class _Solved(NamedTuple):
    """Levels of one class: E, error (levels,), n, constants (2, levels), wave functions and the size of the basis."""

    E: np.ndarray
    error: np.ndarray
    n: np.ndarray
    constants: np.ndarray
    waves: Waves
    size: int
    said: str


def _alpha_beta(
    separated: Any, pairs: np.ndarray, levels: int, hbar: float, tolerance: float, limit: float
) -> list[_Solved]:
    """Sums E_alpha + E_beta of every pair (a, b)."""
    V_alpha, V_beta = separated.functions
    limits = _limits(separated, hbar, limit)
    count = min(levels, int(np.sqrt(2 * levels)) + 4)
    while True:
        sides = []
        for name, V, quanta, below in zip(SIDES, (V_alpha, V_beta), pairs.T, limits, strict=True):
            distinct, where = np.unique(quanta, return_inverse=True)
            K = distinct**2
            sides.append((radial(name, V, 2, K, count, hbar, separated.mu, tolerance, limit=below), where))
        (first, i), (second, j) = sides
        sums = first.values[i][:, :, None] + second.values[j][:, None, :]
        errors = first.error[i][:, :, None] + second.error[j][:, None, :]
        top = np.sort(sums.reshape(len(pairs), -1), axis=1)[:, min(levels, count * count) - 1]
        if count == levels or (count * count >= levels and np.all(top < np.minimum(sums[:, -1, 0], sums[:, 0, -1]))):
            break
        count = min(levels, 2 * count)
    found = []
    for p in range(len(pairs)):
        E, error, n = _merged(sums[p], errors[p], levels)
        constants = np.array([first.values[i[p], n[0]], second.values[j[p], n[1]]])
        waves = ProductWaves(ALPHA_BETA, first.functions, second.functions, (int(i[p]), int(j[p])), 0)
        found.append(_Solved(E, error, n, constants, waves, max(first.size, second.size), first.said or second.said))
    return found


def _limits(separated: Any, hbar: float, limit: float) -> list[float]:
    """Return upper bounds of the energies of alpha and of beta if their sum is below `limit`.

    Each is the limit less the ground state of the other side, or less a lower bound of it.
    """
    if np.isinf(limit):
        return [limit, limit]
    y = radii(0.0, np.inf)
    sides = [sampled(V.value, y) for V in separated.functions]
    low = [float(values.min()) for values in sides]
    for i, (name, V) in enumerate(zip(SIDES, separated.functions, strict=True)):
        bottom = low[i]
        threshold = float(sides[i][-1])
        for near in NEAR:
            top = min(limit - low[1 - i], bottom + (1 - near) * (threshold - bottom))
            if top <= low[i]:
                break
            ground = radial(name, V, 2, np.zeros(1), 1, hbar, separated.mu, 1e-6, limit=top)
            low[i] = min(top, float((ground.values - ground.error)[0, 0]))
            if low[i] < top:
                break
    return [limit - low[1], limit - low[0]]


def _r_vartheta(
    separated: Any, pairs: np.ndarray, levels: int, hbar: float, tolerance: float, limit: float
) -> list[_Solved]:
    """Radial levels over each level of vartheta; e_vartheta of both bases give E of both."""
    V_r, V_vartheta = separated.functions
    mu = separated.mu
    n_r, n_v = (min(levels, int(factor * np.sqrt(levels)) + 4) for factor in (2.0, 1.0))
    while True:
        e = angular("V_vartheta", V_vartheta, pairs[:, 0], pairs[:, 1], n_v, hbar, mu, 0.1 * tolerance)
        fine, moved = (_over(V_r, values, n_r, hbar, mu, tolerance, limit) for values in (e.values, e.values + e.error))
        sums = fine.values.reshape(*e.values.shape, n_r).swapaxes(1, 2)
        errors = (fine.error + np.abs(moved.values - fine.values)).reshape(*e.values.shape, n_r).swapaxes(1, 2)
        errors = errors + (np.inf if e.lost else 0.0)
        top = np.sort(sums.reshape(len(pairs), -1), axis=1)[:, min(levels, n_r * n_v) - 1]
        few_r = n_r < levels and (n_r * n_v < levels or np.any(top >= sums[:, -1, 0]))
        few_v = n_v < levels and (n_r * n_v < levels or np.any(top >= sums[:, 0, -1]))
        if not (few_r or few_v):
            break
        n_r, n_v = (min(levels, int(1.5 * n) + 1) if few else n for n, few in ((n_r, few_r), (n_v, few_v)))
    found = []
    for p in range(len(pairs)):
        E, error, n = _merged(sums[p], errors[p], levels)
        constants = np.array([fine.values[p * n_v + n[1], n[0]], e.values[p, n[1]]])
        waves = ProductWaves(R_VARTHETA, fine.functions, e.functions, (p * n_v, p), 1)
        found.append(_Solved(E, error, n, constants, waves, max(e.size, fine.size), e.said or fine.said))
    return found


def _over(V_r: Any, e: np.ndarray, count: int, hbar: float, mu: float, tolerance: float, limit: float) -> Factors:
    """Return the radial levels over every e_vartheta."""
    K = 2 * mu * e.ravel() / hbar**2
    return radial("V_r + e_vartheta/r", V_r, 4, K, count, hbar, mu, tolerance, limit=limit)


def _elliptic(
    separated: Any, pairs: np.ndarray, levels: int, hbar: float, tolerance: float, limit: float
) -> list[_Solved]:
    """Solve both equations in kappa and lambda with common eigenvalues, one class after another."""
    V_kappa, V_lambda = separated.functions
    return [
        _Solved(*elliptic_levels(V_kappa, V_lambda, a, b, levels, hbar, separated.mu, tolerance, limit))
        for a, b in pairs.tolist()
    ]


_SOLVED: dict[Family, Callable] = {
    ALPHA_BETA_FAMILY: _alpha_beta,
    R_VARTHETA_FAMILY: _r_vartheta,
    ELLIPTIC_FAMILY: _elliptic,
}


def _merged(sums: np.ndarray, errors: np.ndarray, levels: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the lowest values of a table, ascending, their errors, and their indices (2, levels)."""
    order = np.argsort(sums, axis=None, kind="stable")[:levels]
    n = np.stack(np.unravel_index(order, sums.shape))
    E = sums.ravel()[order]
    return E, errors.ravel()[order] + 16 * np.finfo(float).eps * np.abs(E), n


def _levels(chosen: SymmetryClass, solved: _Solved, separated: Any, hbar: float, tolerance: float) -> LevelTable:
    names = separated.family.coordinates
    method = (
        f"separated in {names[0]} and {names[1]}; Galerkin in Jacobi polynomials with the exponents of the ends, "
        f"oscillators in closed form; f = 0 where V is infinite (Friedrichs){solved.said}"
    )
    return class_levels(
        chosen,
        solved.E,
        solved.error,
        solved.n,
        tolerance,
        names=names,
        constants=solved.constants,
        constant_names=separated.family.eigenvalues,
        hbar=hbar,
        method=method,
        functions=solved.size,
        waves=solved.waves,
    )
