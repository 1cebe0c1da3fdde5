"""The spectrum of a body, one symmetry class or many at a time."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, ParamSpec, cast

import numpy as np

from ...core.docstrings import inserts_parameters
from ...core.interruption import partial_result_on_interrupt
from ...core.numbers import an_array, checked_callback, fits, kind_of, positive, whole
from ...results.calls import records_call
from ...runs.interruptible import interruptible
from ...runs.requirements import checked_system
from ...systems.charts import Chart
from ...systems.formulas.systems.bodies import affine_parts
from ...systems.models import Body
from ...systems.models.contracts import Dynamics
from ...tori.families import R_VARTHETA_FAMILY, Family
from ...tori.separation import separate
from ..solvers.elliptic import Unresolved
from ..solvers.nonseparable import plane_levels
from ..solvers.vibrations import COORDINATES
from ..states.level_table import LevelTable, class_levels
from ..states.symmetry import SymmetryClass, action_quantum, checked_class, refuse_spins
from .angular_bodies import (
    angular_classes,
    chosen_key,
    class_of,
    has_angular_potentials,
    lowest_levels,
    refuse_angle_numbers,
)
from .separated_classes import SOLVED, Centres, SolvedClass
from .vibration import vibrates, vibration

P = ParamSpec("P")


def _refuse_affine(model: Any) -> None:
    """Raise TypeError for a body with an affinely invariant kinetic energy, which has a function of its own."""
    if affine_parts(model) is not None:
        raise TypeError(
            "model must be a Body, got an AffineBody. Use affine_spectrum(model, m=..., l=...) for its levels."
        )


def _checked_body(model: Any) -> None:
    if hasattr(model, "breathing"):
        separate(model)  # refuses a potential that does not separate in r and vartheta
        return
    system = checked_system(model, needs="H = T(p) + V(q)")
    if not system.isotropic:
        why = f". Use spectrum(model, count=..., hbar=...) for one to {COORDINATES} coordinates."
        why = ". With angular potentials m and l are not quantum numbers. Use spectrum." if system.planar else why
        got = f"{kind_of(model)} of {system.n} coordinates"
        raise TypeError(f"model must be a Body with a doubly isotropic potential, got {got}{why}")


def _of_bodies(function: Callable[P, LevelTable]) -> Callable[P, LevelTable]:
    """Make a function refuse systems without levels before it asks for m and l, which only bodies have."""

    @functools.wraps(function)
    def wrapped(*given: P.args, **named: P.kwargs) -> LevelTable:
        if given or "model" in named:
            body = given[0] if given else named["model"]
            _refuse_affine(body)
            if not vibrates(body) and not has_angular_potentials(body):
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
    n_eta: int | None = None,
    n_gamma: int | None = None,
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
    model : Body, StackelBody, BreathingBody or model
        A body, separable or not; a separable body with angular potentials or a breathing term; or a system H = T(p) +
        V(q) of one to three coordinates with T quadratic in the momenta.
    m, l : int, optional
        Quantum numbers of spin and vorticity. Required for a `Body` and not supported for other systems.
    n_eta, n_gamma : int, optional
        Numbers, from 0, of the levels of eta and gamma, for one class of a body with angular potentials. Default: the
        lowest levels of all classes.
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
    - Angular potentials: Fourier series in eta and gamma. ``single_valued=False`` adds functions that change sign
      over 2 pi.
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
    if has_angular_potentials(model):
        refuse_spins(m, l)
        classes = angular_classes(model, hbar, single_valued, chart, tolerance)
        key = chosen_key(n_eta, n_gamma)
        fits("count", count := whole("count", count, 1), 16)
        with partial_result_on_interrupt("spectrum", lambda: classes.listed(-np.inf) if classes.solved else None):
            if key is not None:
                return class_of(classes, key, count)
            return lowest_levels(classes, count, checked_callback(callback))
    refuse_angle_numbers(n_eta, n_gamma)
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
    K = np.array(pairs) ** 2
    centres = Centres(K, np.zeros_like(K))
    try:
        solved = interruptible(SOLVED[separated.family], separated, centres, count, hbar, tolerance, limit)
    except Unresolved:
        return [plane_levels(model, one, count, hbar, tolerance, limit=limit) for one in classes]
    return [_levels(c, solved[pairs.index((c.a, c.b))], separated, hbar, tolerance) for c in classes]


def solved_families(model: Any) -> list[Family]:
    """Return the families in which the body separates and its levels are computed coordinate by coordinate."""
    potential = getattr(model, "potential", None)
    families = [R_VARTHETA_FAMILY] if hasattr(model, "breathing") else SOLVED
    return [family for family in families if hasattr(potential, family.member)]


def _checked(model: Any, count: Any, hbar: Any, tolerance: Any) -> tuple[int, float, float]:
    _checked_body(model)
    return whole("count", count, 1), action_quantum(hbar, model.mu), positive("tolerance", tolerance)


def _levels(chosen: SymmetryClass, solved: SolvedClass, separated: Any, hbar: float, tolerance: float) -> LevelTable:
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
